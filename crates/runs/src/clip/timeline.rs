//! When the glass is hit, and how far the cracks are in each frame.

use starbreak_glass::CrackNetwork;

use super::{ClipError, Growth};

/// What the glass of a frame is like.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GlassState {
    /// Not hit yet, or hit and not broken.
    Intact,
    /// The cracks run.
    Growing,
    /// The cracks stand still.
    Still,
}

impl GlassState {
    /// Its word in the track.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Intact => "intact",
            Self::Growing => "growing",
            Self::Still => "still",
        }
    }
}

/// From the time of a frame to the growth of the cracks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Timeline {
    impact_at_s: f64,
    /// What a frame lasts, s.
    frame_s: f64,
    /// Growth per second of the clip, in the network's unit of time; infinite without growth.
    speed: f64,
    /// Growth at the impact: just before the first arrival if the growth is stretched, else 0.
    first: f64,
    last_arrival: f64,
    is_broken: bool,
    has_times: bool,
}

/// How much of the time from the first arrival to the last the stretched growth begins early, so
/// that the first frame shows more than nothing. FIT.
const HAIR: f64 = 1e-6;

impl Timeline {
    /// Of damage without a network, a photograph: it is there at once.
    pub(super) fn at_once(
        is_intact: bool,
        impact_at_s: f64,
        growth: Growth,
        frame_s: f64,
    ) -> Result<Self, ClipError> {
        if growth != Growth::Whole {
            return Err(ClipError::NoNetwork);
        }
        Ok(Self {
            impact_at_s,
            frame_s,
            speed: f64::INFINITY,
            first: 0.0,
            last_arrival: 0.0,
            is_broken: !is_intact,
            has_times: false,
        })
    }

    pub(super) fn new(
        network: &CrackNetwork,
        impact_at_s: f64,
        growth: Growth,
        frame_s: f64,
    ) -> Result<Self, ClipError> {
        let segments = &network.data().segments;
        let last_arrival = network.last_arrival();
        let is_broken = network.n_segments() > 0;
        let first_arrival = segments
            .arrival()
            .and_then(|times| times.iter().copied().reduce(f64::min));
        let mut first = 0.0;
        let speed = match growth {
            Growth::Whole => f64::INFINITY,
            _ if is_broken && segments.arrival().is_none() => return Err(ClipError::NoArrivals),
            Growth::OwnSpeed if is_broken && segments.arrival_us.is_none() => {
                return Err(ClipError::NoSpeed);
            }
            Growth::OwnSpeed => 1e6,
            Growth::Stretched { time_s } => {
                let first_arrival = first_arrival.unwrap_or(0.0);
                let span = last_arrival - first_arrival;
                // Cracks that all arrive at once are seen on their way there.
                if span > 0.0 {
                    first = (first_arrival - HAIR * span).max(0.0);
                }
                (last_arrival - first) / time_s
            }
        };
        Ok(Self {
            impact_at_s,
            frame_s,
            speed,
            first,
            last_arrival,
            is_broken,
            has_times: segments.arrival().is_some(),
        })
    }

    /// State and growth (in the network's unit of time; infinite once still) of a frame that
    /// begins `time_s` after the first.
    ///
    /// The first frame that begins at the impact or later shows it. A frame shows what has grown by
    /// its end.
    pub(super) fn at(&self, time_s: f64) -> (GlassState, f64) {
        // Times of frames are rounded to the clock of their container.
        let age_s = time_s - self.impact_at_s;
        if !self.is_broken || age_s < -1e-6 {
            return (GlassState::Intact, 0.0);
        }
        let grown = self.first + (age_s.max(0.0) + self.frame_s) * self.speed;
        // Rounding must not hold back the last tip for a frame.
        if grown >= self.last_arrival * (1.0 - 1e-9) {
            (GlassState::Still, f64::INFINITY)
        } else {
            (GlassState::Growing, grown)
        }
    }

    /// Growth in the network's unit, once still the last arrival. Of a network without times 1 once
    /// it is there, 0 before.
    pub(super) fn reached(&self, grown: f64) -> f64 {
        if self.has_times {
            grown.min(self.last_arrival)
        } else {
            grown.min(1.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn network(arrivals: &str) -> CrackNetwork {
        CrackNetwork::from_json(&format!(
            r#"{{"schema":"starbreak.crack-network/1", "generator":{{"name":"by hand","version":"1"}},
            "model":"imported", "unit":"mm", "pane":{{"width":64.0,"height":48.0}}, "impacts":[{{"x":8.0,"y":24.0}}],
            "nodes":{{"x":[8.0,40.0],"y":[24.0,30.0]}},
            "segments":{{"from":[0],"to":[1],"kind":["radial"]{arrivals}}}}}"#
        ))
        .unwrap_or_else(|error| panic!("{error}"))
    }

    fn states(timeline: &Timeline, n: u32, frame_s: f64) -> Vec<GlassState> {
        (0..n)
            .map(|k| timeline.at(f64::from(k) * frame_s).0)
            .collect()
    }

    #[test]
    fn stretched_growth_ends_in_the_frame_that_ends_with_it() {
        let network = network(r#","arrival_us":[100.0]"#);
        let growth = Growth::Stretched { time_s: 0.3 };
        let timeline = Timeline::new(&network, 0.2, growth, 0.1).unwrap_or_else(|e| panic!("{e}"));
        use GlassState::{Growing, Intact, Still};
        assert_eq!(
            states(&timeline, 7, 0.1),
            [Intact, Intact, Growing, Growing, Still, Still, Still],
            "0.2 s intact, 0.3 s of growth"
        );
        let (_, grown) = timeline.at(0.3);
        assert!(
            (grown - 200.0 / 3.0).abs() < 1e-9,
            "{grown} of 100 us after 0.2 of 0.3 s"
        );
    }

    #[test]
    fn at_its_own_speed_a_crack_is_there_within_a_frame() {
        let network = network(r#","arrival_us":[100.0]"#);
        for growth in [Growth::OwnSpeed, Growth::Whole] {
            let timeline =
                Timeline::new(&network, 0.15, growth, 0.1).unwrap_or_else(|e| panic!("{e}"));
            use GlassState::{Intact, Still};
            assert_eq!(
                states(&timeline, 4, 0.1),
                [Intact, Intact, Still, Still],
                "{growth:?}"
            );
        }
    }

    #[test]
    fn what_has_no_time_does_not_grow_by_itself() {
        let stretched = Growth::Stretched { time_s: 1.0 };
        let steps = network(r#","arrival_step":[3.0]"#);
        let result = Timeline::new(&steps, 0.0, Growth::OwnSpeed, 0.1);
        assert!(matches!(result, Err(ClipError::NoSpeed)), "steps");
        assert!(
            Timeline::new(&steps, 0.0, stretched, 0.1).is_ok(),
            "steps, stretched"
        );
        let none = network("");
        let result = Timeline::new(&none, 0.0, stretched, 0.1);
        assert!(matches!(result, Err(ClipError::NoArrivals)), "no column");
        assert!(
            Timeline::new(&none, 0.0, Growth::Whole, 0.1).is_ok(),
            "still"
        );
    }
}
