//! How long each stage took.

use std::time::Instant;

use serde_json::{Map, Value, json};

/// Wall-clock milliseconds per stage, in the order of the stages.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Timings {
    stages: Vec<(&'static str, f64)>,
}

impl Timings {
    /// Milliseconds of one stage, if it ran.
    #[must_use]
    pub fn of(&self, stage: &str) -> Option<f64> {
        self.stages
            .iter()
            .find(|(name, _)| *name == stage)
            .map(|(_, ms)| *ms)
    }

    /// Milliseconds of all stages together.
    #[must_use]
    pub fn total_ms(&self) -> f64 {
        self.stages.iter().map(|(_, ms)| ms).sum()
    }

    /// Adds the stages of a later part of the same run.
    pub fn append(&mut self, later: Self) {
        self.stages.extend(later.stages);
    }

    /// Adds the times of another run of the same stages.
    pub fn add(&mut self, other: &Self) {
        for (stage, ms) in &other.stages {
            match self.stages.iter_mut().find(|(name, _)| name == stage) {
                Some((_, sum_ms)) => *sum_ms += ms,
                None => self.stages.push((stage, *ms)),
            }
        }
    }

    /// `{stage: ms, …, total: ms}`, to a microsecond.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let rounded = |ms: f64| json!((ms * 1e3).round() / 1e3);
        let mut map: Map<String, Value> = self
            .stages
            .iter()
            .map(|(name, ms)| ((*name).to_owned(), rounded(*ms)))
            .collect();
        map.insert("total".to_owned(), rounded(self.total_ms()));
        Value::Object(map)
    }
}

/// Laps of a wall clock. In a browser, which gives a library none, all laps take no time.
#[derive(Debug)]
pub struct Stopwatch {
    last: Option<Instant>,
    timings: Timings,
}

impl Stopwatch {
    /// Starts now.
    #[must_use]
    pub fn start() -> Self {
        Self {
            last: now(),
            timings: Timings::default(),
        }
    }

    /// Ends a stage and starts the next; a stage that comes again adds to its time.
    pub fn lap(&mut self, stage: &'static str) {
        let now = now();
        let spent = now.zip(self.last).map(|(now, last)| now - last);
        let spent_ms = spent.unwrap_or_default().as_secs_f64() * 1e3;
        let stages = &mut self.timings.stages;
        match stages.iter_mut().find(|(name, _)| *name == stage) {
            Some((_, total_ms)) => *total_ms += spent_ms,
            None => stages.push((stage, spent_ms)),
        }
        self.last = now;
    }

    /// Adds stages that were timed elsewhere; the next lap starts now.
    pub fn append(&mut self, stages: Timings) {
        self.timings.append(stages);
        self.last = now();
    }

    /// The laps.
    #[must_use]
    pub fn stop(self) -> Timings {
        self.timings
    }
}

fn now() -> Option<Instant> {
    let has_clock = cfg!(not(all(target_family = "wasm", target_os = "unknown")));
    has_clock.then(Instant::now)
}
