//! Outlines of drops: water wets glass again only beyond one contact angle and leaves it only below another, so that a
//! drop need not be round.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::ops::{Add, Mul, Sub};

use rand_chacha::ChaCha8Rng;
use starbreak_seed::uniform;

/// Waves around an outline, by k, how many bulges each has, from the first k on.
const FIRST: usize = 2;
const N_WAVES: usize = 4;
const BULGES: [f64; N_WAVES] = [2.0, 3.0, 4.0, 5.0];

/// The most by which contact angles may change along an outline, as a share of the slope: the form of the surface is that of
/// small bulges.
const MOST: f64 = 0.25;

/// How much of that a wave takes, times its height: (k² − 1)/3. For the contact angle k − 1 would do; by this the curvature of
/// the outline, in the first order 1 + (k² − 1) aₖ of the circle's, is above 0 everywhere and nowhere that of a point.
const TAKES: [f64; N_WAVES] = [1.0, 8.0 / 3.0, 5.0, 8.0];

/// How far the outline of a drop is from a circle.
///
/// The radius at an angle φ is in the first order 1 + Σ (aₖ cos kφ + bₖ sin kφ), k = 2 to 5, of that of the round drop of its
/// water. The surface is at the height that a round drop has at a distance √u from its middle, with
/// u = ρ² − 2 Σ ρᵏ (aₖ cos kφ + bₖ sin kφ): where the glass is wet flatly, this is the form that surface tension gives to
/// water of that outline, for ρᵏ cos kφ has no curvature. The outline is at u = 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outline {
    /// aₖ and bₖ.
    waves: [[f64; 2]; N_WAVES],
    /// How much smaller all of it is drawn, so that its area is that of the circle: waves make it 1 + Σ k (aₖ² + bₖ²) times
    /// as large in the second order.
    stretch: f64,
}

impl Default for Outline {
    /// A circle.
    fn default() -> Self {
        Self::of([[0.0; 2]; N_WAVES])
    }
}

/// Numbers from 0 to 1 that make the outline of a drop that fell.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Drawn {
    /// How high all waves are together.
    all: f64,
    /// How high each is of what those before it left, and its angle.
    each: [[f64; 2]; N_WAVES],
}

impl Drawn {
    pub(crate) fn by(rng: &mut ChaCha8Rng) -> Self {
        Self {
            all: uniform(rng),
            each: [(); N_WAVES].map(|()| [uniform(rng), uniform(rng)]),
        }
    }
}

/// A place in a drop, as the place of a round one; or several, of numbers that hold those of each.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoundPlace<N = f64> {
    /// Distance from the middle of a place of a round drop at which the surface is as high, squared: 1 on the outline.
    pub level: N,
    /// How fast half of `level` changes to the right and down: on a round drop the place itself.
    pub slope: [N; 2],
}

#[inline(always)]
fn times<N>([a, b]: [N; 2], [c, d]: [N; 2]) -> [N; 2]
where
    N: Copy + Add<Output = N> + Sub<Output = N> + Mul<Output = N>,
{
    [a * c - b * d, a * d + b * c]
}

impl Outline {
    fn of(waves: [[f64; 2]; N_WAVES]) -> Self {
        let more: f64 = (BULGES.iter().zip(&waves))
            .map(|(k, [a, b])| k * (a * a + b * b))
            .sum();
        Self {
            waves,
            stretch: (1.0 + more).sqrt(),
        }
    }

    /// The most that Σ (k² − 1)/3 |aₖ, bₖ| may be, so that the contact angle, which is lower where the outline bulges and
    /// higher where it is drawn in, stays between those at which the outline moves: its sine is lower and its tangent higher by
    /// that share at most.
    pub(crate) fn most(contact_rad: f64, [receding, advancing]: [f64; 2]) -> f64 {
        if contact_rad >= FRAC_PI_2 {
            return 0.0;
        }
        let lower = 1.0 - libm::sin(receding) / libm::sin(contact_rad);
        let higher = match advancing < FRAC_PI_2 {
            true => libm::tan(advancing) / libm::tan(contact_rad) - 1.0,
            false => MOST,
        };
        lower.min(higher).clamp(0.0, MOST)
    }

    /// Of a drop that fell: the water spread, shrank and was held here and there.
    pub(crate) fn fallen(drawn: &Drawn, most: f64) -> Self {
        let mut left = most * drawn.all;
        let mut waves = [[0.0; 2]; N_WAVES];
        for ((wave, takes), [size, angle]) in waves.iter_mut().zip(TAKES).zip(drawn.each) {
            let part = left * size;
            left -= part;
            let size = part / takes;
            let (sin, cos) = libm::sincos(TAU * angle);
            *wave = [size * cos, size * sin];
        }
        Self::of(waves)
    }

    /// Of one that ran downhill (1) or uphill (−1): drawn out behind, where its contact angle is the least.
    pub(crate) fn ran(goes: f64, most: f64) -> Self {
        let mut waves = [[0.0; 2]; N_WAVES];
        waves[0] = [-0.5 * most / TAKES[0], 0.0];
        waves[1] = [0.0, 0.5 * goes * most / TAKES[1]];
        Self::of(waves)
    }

    /// Of drops that became one: what their water covered together, as far as it is held. Each is given by its middle, its
    /// radius and its outline.
    ///
    /// Moments ∫ zᵏ dA of what is covered, z = x + iy, are π (aₖ + i bₖ) rᵏ⁺² of a drop about its middle. Those of drops side
    /// by side add up.
    pub(crate) fn joined(parts: &[([f64; 2], f64, Self)], most: f64) -> Self {
        let area: f64 = parts.iter().map(|(_, radius, _)| radius * radius).sum();
        let middle = [0, 1].map(|axis| {
            let of = |(at, radius, _): &([f64; 2], f64, Self)| at[axis] * radius * radius;
            parts.iter().map(of).sum::<f64>() / area
        });
        let mut waves = [[0.0; 2]; N_WAVES];
        for (at, radius, outline) in parts {
            let away = [0, 1].map(|axis| at[axis] - middle[axis]);
            for (sum, moment) in waves.iter_mut().zip(outline.moments(*radius, away)) {
                *sum = [0, 1].map(|axis| sum[axis] + moment[axis]);
            }
        }
        let mut scale = area;
        for wave in &mut waves {
            scale *= area.sqrt();
            *wave = wave.map(|part| part / (scale * area.sqrt()));
        }
        Self::held(waves, most)
    }

    /// Moments, of π, of what a drop of a radius covers that is so far away.
    fn moments(&self, radius: f64, away: [f64; 2]) -> [[f64; 2]; N_WAVES] {
        // Powers of how far away it is, and moments about its own middle: its area, none, and those of its waves.
        let mut powers = [[1.0, 0.0]; N_WAVES + FIRST];
        let mut own = [[0.0; 2]; N_WAVES + FIRST];
        let mut scale = radius * radius;
        own[0][0] = scale;
        for k in 1..N_WAVES + FIRST {
            powers[k] = times(powers[k - 1], away);
            scale *= radius;
            if k >= FIRST {
                own[k] = self.waves[k - FIRST].map(|part| part * scale);
            }
        }
        let mut moments = [[0.0; 2]; N_WAVES];
        for (moment, k) in moments.iter_mut().zip(FIRST..) {
            let mut choose = 1.0;
            for j in 0..=k {
                let part = times(powers[k - j], own[j]);
                *moment = [0, 1].map(|axis| moment[axis] + choose * part[axis]);
                #[expect(clippy::cast_precision_loss, reason = "up to five")]
                let next = (k - j) as f64 / (j + 1) as f64;
                choose *= next;
            }
        }
        moments
    }

    /// With these waves, or as much lower ones as are held everywhere.
    fn held(waves: [[f64; 2]; N_WAVES], most: f64) -> Self {
        let needs: f64 = (waves.iter().zip(TAKES))
            .map(|([a, b], takes)| takes * libm::hypot(*a, *b))
            .sum();
        let by = if needs > most { most / needs } else { 1.0 };
        Self::of(waves.map(|wave| wave.map(|part| by * part)))
    }

    /// Whether it is a circle.
    #[must_use]
    #[inline]
    pub fn is_round(&self) -> bool {
        self.stretch <= 1.0
    }

    /// How far the outline is from the middle at most, of the radius, or somewhat more: as if all waves were highest there.
    #[must_use]
    pub fn reach(&self) -> f64 {
        if self.is_round() {
            return 1.0;
        }
        let sizes = self.waves.map(|[a, b]| (a * a + b * b).sqrt());
        let mut radius = 1.0;
        // Ever farther, as a rule in some steps.
        for _ in 0..12 {
            let mut power = radius;
            let mut square = 1.0;
            for size in sizes {
                power *= radius;
                square += 2.0 * power * size;
            }
            let before = std::mem::replace(&mut radius, square.min(4.0).sqrt());
            if radius - before < 1e-6 {
                break;
            }
        }
        radius / self.stretch
    }

    /// What is at a place, of the radius from the middle.
    #[must_use]
    pub fn round_place(&self, place: [f64; 2]) -> RoundPlace {
        let RoundPlace { level, slope } = self.round_places(place, |value| value);
        let level = level.max(0.0);
        RoundPlace { level, slope }
    }

    /// The same of several places side by side, of numbers that hold those of each; `all` makes one that is the same of all.
    /// In the middle of an uneven drop a level may be somewhat below 0.
    #[must_use]
    #[inline(always)]
    pub fn round_places<N>(&self, place: [N; 2], all: impl Fn(f64) -> N) -> RoundPlace<N>
    where
        N: Copy + Add<Output = N> + Sub<Output = N> + Mul<Output = N>,
    {
        if self.is_round() {
            return RoundPlace {
                level: place[0] * place[0] + place[1] * place[1],
                slope: place,
            };
        }
        let stretch = all(self.stretch);
        let z = place.map(|part| part * stretch);
        let mut level = z[0] * z[0] + z[1] * z[1];
        let mut slope = z;
        // z to the power of k − 1.
        let mut power = z;
        for ([a, b], k) in self.waves.into_iter().zip(BULGES) {
            // (a − i b) zᵏ⁻¹: its real part is half of a derivative to the right, the imaginary one of that upwards.
            let [right, up] = times(power, [all(a), all(-b)]);
            slope = [slope[0] - all(k) * right, slope[1] + all(k) * up];
            level = level - all(2.0) * (right * z[0] - up * z[1]);
            power = times(power, z);
        }
        let slope = slope.map(|part| stretch * part);
        RoundPlace { level, slope }
    }
}

#[cfg(test)]
mod tests;
