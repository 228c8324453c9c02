//! The numbers of clips in the long list.

use super::numbers::{Adder, Number};
use crate::evaluation::{Estimate, PooledClips, PooledUnit, TimelineResults};
use crate::timeline::{Survival, Timeline, TrackFate};

const OVER_TRACKS: &str = "bootstrap over tracks, 95 %";
const PAIRED_OVER_TRACKS: &str = "paired bootstrap over tracks, 95 %";
const CURVE: &str = "Kaplan-Meier; Greenwood, log-log, 95 %";
const CURVE_BETWEEN_CLIPS: &str = "Kaplan-Meier; between clips (Williams), log-log, 95 %";

pub(super) fn of_clip(about: &Number, clip: &TimelineResults, list: &mut Vec<Number>) {
    let mut adder = Adder {
        list,
        about: about.clone(),
    };
    let name = |what: &str| format!("{what}[{}]", clip.clip);
    if let Some(onset) = clip.cracked.damage_onset {
        let n_frames = clip.cracked.frames.len() as u64;
        adder.add_value(name("damage_onset_s"), onset.time_s, n_frames, "frames");
    }
    for (side, timeline) in [("clean", &clip.clean), ("cracked", &clip.cracked)] {
        of_side(&mut adder, clip, side, timeline);
    }
    if let Some(change) = &clip.change {
        for (what, change) in [
            ("found_share", &change.found),
            ("flicker_rate", &change.flicker),
        ] {
            let metric = name(&format!("{what}_after_difference"));
            adder.add(metric, &Estimate::from(change), PAIRED_OVER_TRACKS);
        }
    }
}

/// The clips together.
pub(super) fn of_pooled_clips(about: &Number, pooled: &PooledClips, list: &mut Vec<Number>) {
    let mut adder = Adder {
        list,
        about: about.clone(),
    };
    adder.add_count("clips_with_damage", pooled.n_clips);
    let method = match pooled.unit {
        PooledUnit::Object => CURVE,
        PooledUnit::Clip => CURVE_BETWEEN_CLIPS,
    };
    of_survival(&mut adder, "clean", "", &pooled.clean, method);
    of_survival(&mut adder, "cracked", "", &pooled.cracked, method);
}

/// A curve and its median; `of` stands behind each name.
fn of_survival(
    adder: &mut Adder<'_>,
    side: &str,
    of: &str,
    survival: &Survival,
    method: &'static str,
) {
    let name = |what: &str| format!("{what}_{side}{of}");
    adder.add_count(name("at_risk"), survival.n);
    adder.add_count(name("lost"), survival.n_lost);
    let median = Estimate::from(&survival.median_s);
    adder.add(
        name("median_time_to_failure_s"),
        &median,
        "Kaplan-Meier; Brookmeyer-Crowley, 95 %",
    );
    let ends = ["low", "high"].into_iter().zip(survival.median_ends_s);
    for (end, value) in ends {
        if let (Some(value), None) = (value, median.interval()) {
            let metric = name(&format!("median_time_to_failure_{end}_s"));
            adder.add_value(metric, value, survival.n, "Brookmeyer-Crowley");
        }
    }
    for step in &survival.steps {
        let metric = format!("not_lost_{side}_after_{:.6}_s{of}", step.time_s);
        adder.add(metric, &Estimate::from(&step.share), method);
    }
}

fn of_side(adder: &mut Adder<'_>, clip: &TimelineResults, side: &str, timeline: &Timeline) {
    let name = |what: &str| format!("{what}_{side}[{}]", clip.clip);
    let when: &[_] = match timeline.damage_onset {
        Some(_) => &[("before", &timeline.before), ("after", &timeline.after)],
        None => &[("all", &timeline.before)],
    };
    for (when, part) in when {
        let found = Estimate::from(&part.found);
        adder.add(name(&format!("found_share_{when}")), &found, OVER_TRACKS);
        let flicker = Estimate::from(&part.flicker);
        adder.add(name(&format!("flicker_rate_{when}")), &flicker, OVER_TRACKS);
    }
    if let Some(survival) = &timeline.survival {
        of_survival(adder, side, &format!("[{}]", clip.clip), survival, CURVE);
    }
    for row in &timeline.tracks {
        let named = clip.objects.iter().find(|it| it.track == row.track);
        let Some(named) = named else { continue };
        adder.about.class.clone_from(&named.class);
        let name = |what: &str| format!("{what}_{side}[{}/{}]", clip.clip, named.name);
        let n = row.n_frames;
        if n > 0 {
            #[expect(
                clippy::cast_precision_loss,
                reason = "counts of frames are far below 2^53"
            )]
            let share = row.n_found as f64 / n as f64;
            adder.add_value(name("found_share"), share, n, "share of frames");
        }
        adder.add_count(name("changes"), row.n_changes);
        match &row.fate {
            TrackFate::Lost { after_s, .. } => {
                adder.add_value(name("time_to_failure_s"), *after_s, n, "frames");
            }
            TrackFate::Kept { for_s } => {
                adder.add_value(name("kept_for_s"), *for_s, n, "frames");
            }
            TrackFate::NotAtRisk { .. } => {}
        }
    }
    adder.about.class = String::new();
}
