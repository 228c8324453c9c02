//! Pixels, rows and columns that no longer tell of light.

use rand_chacha::rand_core::Rng as _;
use starbreak_seed::{Seed, Stream, uniform};

/// Defective pixels. Each pixel is one with the same small chance, whatever its neighbors are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pixels {
    /// Black ones, per million.
    pub dead_per_mpx: f64,
    /// Such as add light of their own, per million.
    pub hot_per_mpx: f64,
    /// Such as are always the same, somewhere between black and white, per million.
    pub stuck_per_mpx: f64,
    /// Mean of what a hot pixel adds, 1 is white; it falls exponentially from pixel to pixel.
    pub hot_level: f64,
}

/// Defective rows and columns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lines {
    /// How many rows.
    pub rows: u32,
    /// How many columns.
    pub columns: u32,
    /// What they show: 0 is black, 1 white.
    pub level: f64,
}

/// What a defect makes of the light of a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Defect {
    /// It is always this.
    Stuck(f32),
    /// So much is added.
    Adds(f32),
}

impl Defect {
    /// The light that the pixel tells of.
    #[must_use]
    pub fn of(self, light: f32) -> f32 {
        match self {
            Self::Stuck(level) => level,
            Self::Adds(more) => light + more,
        }
    }
}

impl Pixels {
    /// Whether there are none.
    #[must_use]
    pub fn is_nothing(&self) -> bool {
        self.dead_per_mpx + self.hot_per_mpx + self.stuck_per_mpx <= 0.0
    }

    /// The defective pixels of a sensor, with their places in rows from the top; of a pixel with two defects the last
    /// counts.
    #[must_use]
    pub fn of_sensor(&self, n_pixels: usize, sensor: Seed) -> Vec<(usize, Defect)> {
        let mut all = Vec::new();
        let kinds = [self.dead_per_mpx, self.hot_per_mpx, self.stuck_per_mpx];
        for (kind, per_mpx) in (0_u64..).zip(kinds) {
            let chance = (per_mpx / 1e6).min(1.0);
            if chance <= 0.0 {
                continue;
            }
            let mut rng = sensor.stream(Stream::SensorDefects, kind);
            // The number of sound pixels before the next defective one is geometric.
            let rarity = libm::log1p(-chance);
            let mut at = 0.0;
            loop {
                let sound = libm::log1p(-uniform(&mut rng)) / rarity;
                at += if chance < 1.0 { sound.floor() } else { 0.0 };
                let level = uniform(&mut rng);
                #[expect(
                    clippy::cast_precision_loss,
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "places of a frame"
                )]
                let place = if at < n_pixels as f64 {
                    at as usize
                } else {
                    break;
                };
                all.push((
                    place,
                    match kind {
                        0 => Defect::Stuck(0.0),
                        1 => {
                            Defect::Adds(crate::draw::single(-self.hot_level * libm::log1p(-level)))
                        }
                        _ => Defect::Stuck(crate::draw::single(level)),
                    },
                ));
                at += 1.0;
            }
        }
        all
    }
}

impl Lines {
    /// Whether there are none.
    #[must_use]
    pub fn is_nothing(&self) -> bool {
        self.rows == 0 && self.columns == 0
    }

    /// The defective rows and columns of a sensor, each once.
    #[must_use]
    pub fn of_sensor(&self, (width, height): (usize, usize), sensor: Seed) -> [Vec<usize>; 2] {
        let chosen = |kind: u64, n_wanted: u32, n: usize| {
            let mut rng = sensor.stream(Stream::SensorDefects, kind);
            let mut chosen: Vec<usize> = Vec::new();
            while chosen.len() < (n_wanted as usize).min(n) {
                let place = usize::try_from(rng.next_u64() % n as u64).unwrap_or(0);
                if !chosen.contains(&place) {
                    chosen.push(place);
                }
            }
            chosen
        };
        [chosen(3, self.rows, height), chosen(4, self.columns, width)]
    }
}
