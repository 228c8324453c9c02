//! What a study does, on the screen.

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

use starbreak_runs::study::{Step, StudyEvent, UnseenImage};

use crate::screen::{Progress, Screen};

/// What a study does now, on the screen.
pub(super) struct Steps<'a> {
    screen: &'a Screen,
    n_lines: usize,
    now: Mutex<StepNow>,
}

/// The line of a study on the screen.
#[derive(Default)]
struct StepNow {
    number: usize,
    progress: Option<Progress>,
    /// What has failed so far.
    told: BTreeSet<String>,
}

impl<'a> Steps<'a> {
    pub(super) fn new(screen: &'a Screen, n_lines: usize) -> Self {
        Self {
            screen,
            n_lines,
            now: Mutex::default(),
        }
    }

    pub(super) fn tell(&self, event: StudyEvent<'_>) {
        let Ok(mut now) = self.now.lock() else {
            return;
        };
        match event {
            StudyEvent::Begun(step, n_images) => {
                if let Some(progress) = now.progress.take() {
                    progress.finish();
                }
                now.number += 1;
                let what = match step {
                    Step::Comparing => "comparing the sets of images".to_owned(),
                    Step::Breaking(condition) => format!("breaking: {}", condition.name),
                    Step::Detecting(None) => "detecting: clean images".to_owned(),
                    Step::Detecting(Some(condition)) => format!("detecting: {}", condition.name),
                };
                self.screen
                    .note(&format!("[{}/{}] {what}", now.number, self.n_lines));
                now.progress = Some(self.screen.progress(n_images, "images"));
            }
            StudyEvent::Known(0) => {}
            StudyEvent::Known(n) => {
                let known = n.try_into().map_or_else(|_| n.to_string(), images);
                if let Some(progress) = &now.progress {
                    progress.note(&format!("  {known} known from an earlier run"));
                    progress.skip(n);
                }
            }
            StudyEvent::Image => {
                if let Some(progress) = &now.progress {
                    progress.step();
                }
            }
            StudyEvent::Failed(error) => {
                // A file that cannot be read fails in each step.
                if !now.told.insert(error.clone()) {
                    return;
                }
                if let Some(progress) = &now.progress {
                    progress.line(&format!("error: {error}"));
                }
            }
        }
    }

    /// Takes the line away. Comes to what has been told.
    pub(super) fn finish(self) -> BTreeSet<String> {
        let now = self
            .now
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner);
        if let Some(progress) = now.progress {
            progress.finish();
        }
        now.told
    }
}

/// Says which images have no result, but for those that were told of when they failed.
pub(super) fn say_unseen(unseen: &[UnseenImage], told: &BTreeSet<String>, screen: &Screen) {
    let is_told = |one: &&UnseenImage| {
        let of_condition = one.reason.split_once(": ").map(|(_, reason)| reason);
        told.contains(&one.reason) || of_condition.is_some_and(|reason| told.contains(reason))
    };
    let untold: Vec<&UnseenImage> = unseen.iter().filter(|one| !is_told(one)).collect();
    for one in untold.iter().take(10) {
        screen.note(&format!(
            "left out of all numbers: {:?}: {}",
            one.name, one.reason
        ));
    }
    if untold.len() > 10 {
        screen.note(&format!("and {} more", untold.len() - 10));
    }
}

/// So many images, in words.
pub(super) fn images(n: usize) -> String {
    match n {
        1 => "1 image".to_owned(),
        n => format!("{n} images"),
    }
}
