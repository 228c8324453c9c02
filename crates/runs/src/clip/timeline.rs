//! When the glass is hit, and how far the cracks are in each frame.

use starbreak::{Arrivals, Chain, FractureSettings};

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
    /// Growth per second of the clip, in the unit of the arrivals; infinite without growth.
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
    /// Of the damage of a chain that is hit at a time; frames last `frame_s`.
    pub(super) fn new(
        chain: &Chain,
        impact_at_s: f64,
        growth: Growth,
        frame_s: f64,
    ) -> Result<Self, ClipError> {
        let is_whole = matches!(chain.settings().fracture, FractureSettings::None(_))
            && chain.network().is_none()
            && chain.photo().is_none();
        if is_whole && (impact_at_s > 0.0 || growth != Growth::Whole) {
            return Err(ClipError::NothingBreaks);
        }
        if !chain.can_grow() && growth != Growth::Whole {
            return Err(ClipError::NoNetwork);
        }
        Self::of_arrivals(
            chain.arrivals(),
            chain.is_broken(),
            (impact_at_s, frame_s),
            growth,
        )
    }

    fn of_arrivals(
        arrivals: Option<Arrivals>,
        is_broken: bool,
        (impact_at_s, frame_s): (f64, f64),
        growth: Growth,
    ) -> Result<Self, ClipError> {
        let times = arrivals.filter(|_| is_broken);
        let [first_arrival, last_arrival] =
            times.map_or([0.0; 2], |times| [times.first, times.last]);
        let mut first = 0.0;
        let speed = match growth {
            Growth::Whole => f64::INFINITY,
            _ if is_broken && arrivals.is_none() => return Err(ClipError::NoArrivals),
            Growth::OwnSpeed if times.is_some_and(|times| times.unit != "us") => {
                return Err(ClipError::NoSpeed);
            }
            Growth::OwnSpeed => 1e6,
            Growth::Stretched { time_s } => {
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
            has_times: arrivals.is_some(),
        })
    }

    /// State and growth (in the unit of the arrivals; infinite once still) of a frame that
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

    /// Growth in the unit of the arrivals, once still the last arrival. Of damage without times 1 once
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

    fn timeline(
        unit: Option<&'static str>,
        impact_at_s: f64,
        growth: Growth,
    ) -> Result<Timeline, ClipError> {
        let arrivals = unit.map(|unit| Arrivals {
            unit,
            first: 100.0,
            last: 100.0,
        });
        Timeline::of_arrivals(arrivals, true, (impact_at_s, 0.1), growth)
    }

    fn states(timeline: &Timeline, n: u32, frame_s: f64) -> Vec<GlassState> {
        (0..n)
            .map(|k| timeline.at(f64::from(k) * frame_s).0)
            .collect()
    }

    #[test]
    fn stretched_growth_ends_in_the_frame_that_ends_with_it() {
        let growth = Growth::Stretched { time_s: 0.3 };
        let timeline = timeline(Some("us"), 0.2, growth).unwrap_or_else(|e| panic!("{e}"));
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
        for growth in [Growth::OwnSpeed, Growth::Whole] {
            let timeline = timeline(Some("us"), 0.15, growth).unwrap_or_else(|e| panic!("{e}"));
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
        let result = timeline(Some("step"), 0.0, Growth::OwnSpeed);
        assert!(matches!(result, Err(ClipError::NoSpeed)), "steps");
        assert!(
            timeline(Some("step"), 0.0, stretched).is_ok(),
            "steps, stretched"
        );
        let result = timeline(None, 0.0, stretched);
        assert!(matches!(result, Err(ClipError::NoArrivals)), "no column");
        assert!(timeline(None, 0.0, Growth::Whole).is_ok(), "still");
    }
}
