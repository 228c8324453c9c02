//! Detection over frames, on tracks small enough to follow by hand.
#![expect(
    clippy::unwrap_used,
    reason = "a test whose scene is refused has failed"
)]

use starbreak_eval::timeline::{
    FollowSettings, Frame, GlassState, Sighting, Timeline, TimelineSettings, Track, TrackFate,
    timeline, track_detections, tracks_of,
};
use starbreak_eval::{
    BoxPx, Detection, Detections, ImageMatches, LabelSet, MatchedDetection, MatchedObject, Object,
    ObjectKind, Outcome,
};

/// Frames at 10 per second, the glass broken from frame 4 on.
fn frames(n: u32) -> Vec<Frame> {
    (0..n)
        .map(|k| Frame {
            frame_idx: u64::from(k),
            time_s: f64::from(k) / 10.0,
            state: Some(if k < 4 {
                GlassState::Intact
            } else {
                GlassState::Still
            }),
        })
        .collect()
}

/// A track from a picture: x found, . missed, space not there.
fn track(number: u64, picture: &str) -> Track {
    let sightings = (0_u32..).zip(picture.chars()).filter(|(_, it)| *it != ' ');
    Track {
        track: number,
        category: 0,
        sightings: sightings
            .map(|(frame, it)| Sighting {
                frame,
                score: (it == 'x').then_some(0.5),
            })
            .collect(),
    }
}

fn run(pictures: &[&str], reference: Option<&[&str]>) -> Timeline {
    let tracks = |pictures: &[&str]| -> Vec<Track> {
        (1..).zip(pictures).map(|(k, it)| track(k, it)).collect()
    };
    let settings = TimelineSettings {
        lost_for_frames: 3,
        n_replicates: 100,
        ..TimelineSettings::default()
    };
    let reference = reference.map(tracks);
    timeline(
        &frames(12),
        Some(4),
        &tracks(pictures),
        reference.as_deref(),
        settings,
    )
    .unwrap()
}

fn fates(timeline: &Timeline) -> Vec<String> {
    let fate = |it: &TrackFate| match it {
        TrackFate::Lost { frame_idx, after_s } => format!("lost {frame_idx} {after_s:.1}"),
        TrackFate::Kept { for_s } => format!("kept {for_s:.1}"),
        TrackFate::NotAtRisk { reason } => reason.clone(),
    };
    timeline.tracks.iter().map(|it| fate(&it.fate)).collect()
}

#[test]
fn an_object_is_lost_at_the_first_frame_of_a_gap_that_is_long_enough() {
    let timeline = run(
        &[
            "xxxxxx...xxx",
            "xxxx...xxxxx",
            "xxxxxx..x..x",
            "xxxxxxxxxx..",
            "xxxxx ..x   ",
            "x...xxxxxxxx",
            "     xxxxxxx",
            "xxx         ",
            "xxxx. . .xxx",
        ],
        None,
    );
    assert_eq!(
        fates(&timeline),
        [
            "lost 6 0.2",
            "lost 4 0.0",
            "kept 0.7",
            // Lost from frame 10 on, perhaps.
            "kept 0.6",
            "kept 0.4",
            "it is not found without damage either",
            "it begins after the onset of damage",
            "it ends before the onset of damage",
            "lost 4 0.0",
        ],
        "fates"
    );
    let survival = timeline.survival.unwrap();
    assert_eq!((survival.n, survival.n_lost), (6, 3), "three of six");
    let steps: Vec<_> = survival
        .steps
        .iter()
        .map(|it| (it.n_at_risk, it.n_lost))
        .collect();
    assert_eq!(steps, [(6, 2), (4, 1)], "two at once, one later");
    let median_s = survival.median_s.value.unwrap();
    assert!((median_s - 0.2).abs() < 1e-12, "half at {median_s} s");
}

#[test]
fn the_clean_video_says_what_could_be_found() {
    let cracked = ["    ...xxxxx", "xxxx...xxxxx", "xxxxxxxxxxxx"];
    let clean = ["    x..xxxxx", "xxxx...xxxxx"];
    let timeline = run(&cracked, Some(&clean));
    assert_eq!(
        fates(&timeline),
        [
            "lost 4 0.0",
            "it is not found without damage either",
            "it is not in the clean video",
        ],
        "fates"
    );
}

#[test]
fn flicker_counts_turns_and_gaps() {
    let timeline = run(&["xx.xx..x.x..", "xxxxxxxx    "], None);
    let first = &timeline.tracks[0];
    assert_eq!((first.n_frames, first.n_found), (12, 6), "frames");
    assert_eq!(first.n_changes, 7, "turns");
    assert_eq!(first.gaps_frames, [1, 2, 1], "the end is no gap");
    assert_eq!(
        (timeline.before.n_steps, timeline.after.n_steps),
        (6, 12),
        "steps"
    );
    assert_eq!(timeline.before.flicker.value, Some(2.0 / 6.0), "before");
    assert_eq!(timeline.after.flicker.value, Some(5.0 / 12.0), "after");
    assert_eq!(timeline.after.found.value, Some(7.0 / 12.0), "found after");
    let row = &timeline.frames[2];
    assert_eq!((row.n_objects, row.n_found), (2, 1), "frame 2");
    assert_eq!(row.state, Some(GlassState::Intact), "frame 2");
    assert_eq!(timeline.damage_onset.unwrap().frame_idx, 4, "onset");
}

#[test]
fn without_damage_there_is_no_survival() {
    let settings = TimelineSettings::default();
    let timeline = timeline(&frames(3), None, &[track(1, "x.x")], None, settings).unwrap();
    assert_eq!(timeline.survival, None, "nothing to survive");
    assert_eq!(timeline.before.n_sightings, 3, "all is before");
    assert_eq!(timeline.after.found.value, None, "nothing is after");
}

#[test]
fn what_is_no_video_is_refused() {
    let settings = TimelineSettings::default();
    let run = |frames: &[Frame], onset, tracks: &[Track]| {
        timeline(frames, onset, tracks, None, settings)
            .unwrap_err()
            .to_string()
    };
    let mut backwards = frames(3);
    backwards[2].time_s = 0.05;
    assert!(run(&backwards, None, &[]).contains("time"), "times");
    assert!(run(&frames(3), Some(3), &[]).contains("frame"), "onset");
    assert!(
        run(&frames(3), None, &[track(1, "xxxx")]).contains("frame"),
        "sighting"
    );
    let twice = [track(7, "x"), track(7, "x")];
    assert!(run(&frames(3), None, &twice).contains("track 7"), "numbers");
}

#[test]
fn tracks_come_from_matches_of_frames() {
    let object = |k: u32| MatchedObject {
        object: k,
        is_ignored: k == 3,
        detection: None,
    };
    let frame = |image: u32, objects: &[u32], found: &[(u32, f64)]| ImageMatches {
        image,
        category: 0,
        detections: found
            .iter()
            .map(|(object, score)| MatchedDetection {
                detection: 0,
                score: *score,
                outcome: Outcome::TruePositive {
                    object: *object,
                    iou: 0.9,
                },
            })
            .collect(),
        objects: objects.iter().map(|k| object(*k)).collect(),
    };
    let labels = LabelSet {
        objects: (0..5_u32)
            .map(|k| Object {
                id: i64::from(k),
                image: 0,
                category: 0,
                box_px: BoxPx::from_corners([0.0, 0.0, 1.0, 1.0]),
                area_px2: 1.0,
                kind: ObjectKind::Regular,
            })
            .collect(),
        ..LabelSet::default()
    };
    let matches = [
        frame(0, &[0, 3, 4], &[(0, 0.9)]),
        frame(2, &[1], &[(1, 0.2)]),
        frame(1, &[2], &[(2, 0.4)]),
    ];
    let numbers = [Some(5), Some(5), Some(5), Some(5), None];
    let tracks = tracks_of(&matches, &labels, &numbers, 0.3).unwrap();
    let expected = Track {
        track: 5,
        category: 0,
        sightings: vec![
            Sighting {
                frame: 0,
                score: Some(0.9),
            },
            Sighting {
                frame: 1,
                score: Some(0.4),
            },
            Sighting {
                frame: 2,
                score: None,
            },
        ],
    };
    assert_eq!(
        tracks,
        [expected],
        "by frame; ignored and untracked ones are out"
    );
    let twice = [frame(0, &[0, 1], &[])];
    assert!(
        tracks_of(&twice, &labels, &numbers, 0.3).is_err(),
        "twice in a frame"
    );
    assert!(
        tracks_of(&matches, &labels, &numbers[..2], 0.3).is_err(),
        "numbers lack"
    );
}

#[test]
fn detections_are_followed_over_short_gaps() {
    let detection = |image: u32, x: f64, score: f64, category: u32| Detection {
        image,
        category,
        box_px: BoxPx::from_corners([x, 0.0, x + 10.0, 10.0]),
        score,
    };
    let mut items = Vec::new();
    for frame in [0, 1, 2, 4, 5, 6, 7] {
        // Two objects that drift; frame 3 lacks both.
        items.push(detection(frame, f64::from(frame), 0.9, 0));
        items.push(detection(frame, 100.0 + f64::from(frame), 0.8, 0));
        // Too weak to follow.
        items.push(detection(frame, 200.0, 0.4, 0));
    }
    // The same place under another class, and too short to keep.
    items.push(detection(5, 5.0, 0.95, 1));
    let followed = track_detections(
        &Detections {
            items: items.clone(),
        },
        8,
        FollowSettings::default(),
    )
    .unwrap();
    assert_eq!(followed.objects.len(), 14, "two objects in seven frames");
    let mut numbers = followed.tracks.clone();
    numbers.sort_unstable();
    numbers.dedup();
    assert_eq!(numbers, [Some(1), Some(2)], "two tracks");
    for (object, number) in followed.objects.iter().zip(&followed.tracks) {
        let is_far = object.box_px.x > 50.0;
        assert_eq!(*number, Some(if is_far { 2 } else { 1 }), "{object:?}");
    }
    let one = FollowSettings {
        max_gap_frames: 1,
        ..FollowSettings::default()
    };
    let held = Detections {
        items: items.clone(),
    };
    let held = track_detections(&held, 8, one).unwrap();
    assert_eq!(held.objects.len(), 14, "one missing frame is bridged");
    let short = FollowSettings {
        max_gap_frames: 0,
        ..FollowSettings::default()
    };
    let cut = track_detections(
        &Detections {
            items: items.clone(),
        },
        8,
        short,
    )
    .unwrap();
    assert!(
        cut.objects.is_empty(),
        "pieces of 3 and 4 frames are too short"
    );
    assert!(
        track_detections(&Detections { items }, 7, FollowSettings::default()).is_err(),
        "a frame beyond the video"
    );
}
