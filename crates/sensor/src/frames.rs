//! Frames that do not arrive.

use starbreak_seed::{Seed, Stream, uniform};

/// What becomes of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameState {
    /// It arrives.
    Good,
    /// It is black.
    Black,
    /// It is white.
    White,
    /// The camera repeats the last good one.
    Frozen,
    /// It is lost on the way; whoever looks still sees the last good one.
    Dropped,
}

impl FrameState {
    /// As a track has it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Black => "black",
            Self::White => "white",
            Self::Frozen => "frozen",
            Self::Dropped => "dropped",
        }
    }

    /// Whether it is black or white.
    #[must_use]
    pub fn is_blank(self) -> bool {
        matches!(self, Self::Black | Self::White)
    }

    /// Whether it shows the last good frame in its place.
    #[must_use]
    pub fn repeats(self) -> bool {
        matches!(self, Self::Frozen | Self::Dropped)
    }
}

/// How often frames do not arrive. A clip is a Markov chain: after each frame chance decides anew with probability
/// r = 1/(`burst_frames`·(1 − p)), p the share of bad frames, and else all stays as it is. So a share p of the frames is
/// bad, in rows of 1/(r(1 − p)) = `burst_frames` in the mean, at least 1/(1 − p). Shares that are more than 1 together are
/// cut in the order of the fields.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frames {
    /// Share of the frames that is black.
    pub black: f64,
    /// Share that is white.
    pub white: f64,
    /// Share that is frozen. Pictures by themselves do not freeze.
    pub frozen: f64,
    /// Share that is dropped. Pictures by themselves are not.
    pub dropped: f64,
    /// How many bad frames follow each other in the mean, 1 or more.
    pub burst_frames: f64,
}

impl Frames {
    /// Whether all arrive.
    #[must_use]
    pub fn is_nothing(&self) -> bool {
        self.bad() <= 0.0
    }

    /// Share of bad frames.
    #[must_use]
    pub fn bad(&self) -> f64 {
        (self.black + self.white + self.frozen + self.dropped).min(1.0)
    }

    /// What becomes of a frame of a clip, by its place in it.
    #[must_use]
    pub fn of(&self, clip: Seed, frame_idx: u64) -> FrameState {
        let renewal = 1.0 / (self.burst_frames * (1.0 - self.bad())).max(1.0);
        let mut idx = frame_idx;
        // Back to where chance decided last.
        loop {
            let mut rng = clip.stream(Stream::Frames, idx);
            let (is_anew, chance) = (uniform(&mut rng) < renewal, uniform(&mut rng));
            if is_anew || idx == 0 {
                return self.drawn(chance);
            }
            idx -= 1;
        }
    }

    /// What becomes of a picture by itself: it is good or blank, for there is none before it.
    #[must_use]
    pub fn of_picture(&self, seed: Seed) -> FrameState {
        match self.of(seed, 0) {
            state if state.repeats() => FrameState::Good,
            state => state,
        }
    }

    fn drawn(&self, chance: f64) -> FrameState {
        let mut below = 0.0;
        for (share, state) in [
            (self.black, FrameState::Black),
            (self.white, FrameState::White),
            (self.frozen, FrameState::Frozen),
            (self.dropped, FrameState::Dropped),
        ] {
            below += share;
            if chance < below {
                return state;
            }
        }
        FrameState::Good
    }
}
