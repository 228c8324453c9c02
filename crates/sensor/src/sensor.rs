//! The stages behind the lens, in the order in which light meets them.

use starbreak_seed::{Seed, Stream, uniform};

use crate::draw::{Normal, single};
use crate::mosaic::{Padded, REACH, color_at};
use crate::{Defect, Exposure, Lamps, Light, Lines, Noise, Pixels};
use rand_chacha::rand_core::Rng as _;

/// What white balance multiplies red, green and blue by, in daylight: the filters let through less red and blue
/// \[Brooks2019\].
const WHITE_BALANCE: [f32; 3] = [2.0, 1.0, 1.7];

/// A frame among others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// What differs from frame to frame is drawn from it.
    pub frame: Seed,
    /// What is the same in all frames of a clip.
    pub clip: Seed,
    /// When the frame begins, s.
    pub time_s: f64,
}

impl From<Seed> for Moment {
    /// A picture by itself.
    fn from(seed: Seed) -> Self {
        Self {
            frame: seed,
            clip: seed,
            time_s: 0.0,
        }
    }
}

/// A sensor with its faults. Without any, or with all of them at nothing, a frame stays as it is, to the last bit.
///
/// Stages that work are not run: a photograph has been through them. With U the way from light back to the mosaic and
/// P from there to light, a fault F of the mosaic gives I + P(F(U(I)) − U(I)), since P, the white balance and the
/// interpolation of colors, is linear: the photograph keeps its sharpness, and a defect reaches 5 x 5 px.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Sensor {
    /// Too much light, or too little.
    pub exposure: Option<Exposure>,
    /// Lamps on the mains.
    pub lamps: Option<Lamps>,
    /// Noise.
    pub noise: Option<Noise>,
    /// Defective pixels.
    pub pixels: Option<Pixels>,
    /// Defective rows and columns.
    pub lines: Option<Lines>,
    /// Which sensor it is: what is fixed in it is drawn from this.
    pub number: u64,
}

impl Sensor {
    /// Without the faults that are nothing; none where no other is left.
    #[must_use]
    pub fn faulty(self) -> Option<Self> {
        let kept = Self {
            exposure: self.exposure.filter(|it| !it.is_nothing()),
            lamps: self.lamps.filter(|it| !it.is_nothing()),
            noise: self.noise.filter(|it| !it.is_nothing()),
            pixels: self.pixels.filter(|it| !it.is_nothing()),
            lines: self.lines.filter(|it| !it.is_nothing()),
            number: self.number,
        };
        let sound = Self {
            number: self.number,
            ..Self::default()
        };
        (kept != sound).then_some(kept)
    }

    /// What the faults make of a frame, in place.
    pub fn over(&self, light: &mut Light, at: Moment) {
        // Only a darker frame lacks noise.
        let is_darker = self.exposure.is_some_and(|exposure| exposure.ev < 0.0);
        let before = (is_darker && self.noise().is_none()).then(|| light.clone());
        self.expose(light, at);
        let change = self.mosaic_change(light, before.as_ref(), at);
        if light.n_colors() == 1 {
            for (idx, change) in change.iter().enumerate().filter(|(_, it)| **it != 0.0) {
                light.pixel_mut(idx)[0] += change;
            }
        } else {
            add_colors(light, change);
        }
    }

    /// Which pixels of a frame the faults reach: all of them, or 5 x 5 around each defect. It is the same for every frame
    /// of this size, and none where all faults are nothing.
    #[must_use]
    pub fn reach(&self, (width, height): (usize, usize)) -> Vec<bool> {
        let is_everywhere = self.exposure.is_some_and(|it| !it.is_nothing())
            || self.lamps.is_some_and(|it| !it.is_nothing())
            || self.noise().is_some();
        let mut reached = vec![is_everywhere; width * height];
        if is_everywhere {
            return reached;
        }
        for (at, _) in self.defects((width, height)) {
            let (x, y) = (at % width, at / width);
            for y in y.saturating_sub(REACH)..(y + REACH + 1).min(height) {
                let row = y * width;
                let near = x.saturating_sub(REACH)..(x + REACH + 1).min(width);
                reached[row + near.start..row + near.end].fill(true);
            }
        }
        reached
    }

    /// The noise, where it is any.
    fn noise(&self) -> Option<&Noise> {
        self.noise.as_ref().filter(|noise| !noise.is_nothing())
    }

    /// The defects with their places, in rows from the top.
    fn defects(&self, (width, height): (usize, usize)) -> Vec<(usize, Defect)> {
        let sensor = Seed(self.number);
        let mut all = match &self.pixels {
            Some(pixels) => pixels.of_sensor(width * height, sensor),
            None => Vec::new(),
        };
        if let Some(lines) = &self.lines {
            let [rows, columns] = lines.of_sensor((width, height), sensor);
            let level = Defect::Stuck(single(lines.level));
            for y in rows {
                all.extend((0..width).map(|x| (y * width + x, level)));
            }
            for x in columns {
                all.extend((0..height).map(|y| (y * width + x, level)));
            }
        }
        all
    }

    /// Exposure and lamps.
    fn expose(&self, light: &mut Light, at: Moment) {
        if self.exposure.is_none() && self.lamps.is_none() {
            return;
        }
        let gain = self.exposure.map_or(1.0, |exposure| exposure.gain());
        let phase = uniform(&mut at.clip.stream(Stream::Lamps, 0));
        let n_colors = light.n_colors();
        for (y, row) in light.rows_mut() {
            #[expect(clippy::cast_precision_loss, reason = "rows of a frame")]
            let lamps = (self.lamps).map_or(1.0, |lamps| lamps.gain(y as f64, at.time_s, phase));
            let gain = single(gain * lamps);
            for pixel in row.chunks_exact_mut(n_colors) {
                // No more than the full well holds, after the white balance.
                let full = if n_colors == 1 {
                    [1.0; 3]
                } else {
                    WHITE_BALANCE
                };
                for (color, full) in pixel.iter_mut().zip(full) {
                    *color = (*color * gain).min(full);
                }
            }
        }
    }

    /// What the faults of the mosaic add to it.
    fn mosaic_change(&self, light: &Light, before: Option<&Light>, at: Moment) -> Vec<f32> {
        let (width, height) = light.size();
        let n_colors = light.n_colors();
        // What a pixel of the mosaic sees.
        let raw_of = |values: &[f32], x: usize, y: usize| match n_colors {
            1 => values[y * width + x],
            _ => {
                let color = color_at(x, y);
                values[(y * width + x) * n_colors + color] / WHITE_BALANCE[color]
            }
        };
        // It cannot hold more than 1.
        let raw = |x: usize, y: usize| raw_of(light.values(), x, y).min(1.0);
        let mut change = vec![0.0_f32; width * height];
        if let Some(noise) = self.noise() {
            for y in 0..height {
                let mut row = noise.row(y, at.frame, Seed(self.number));
                for x in 0..width {
                    let here = raw(x, y);
                    change[y * width + x] = (here + row.next(noise, here)).min(1.0) - here;
                }
            }
        } else if let (Some(exposure), Some(before)) = (&self.exposure, before) {
            let (normal, missing) = (Normal::new(), exposure.missing());
            for y in 0..height {
                let mut words = at.frame.stream(Stream::SensorElectrons, y as u64);
                for x in 0..width {
                    let deviation = missing(f64::from(raw_of(before.values(), x, y)));
                    let here = raw(x, y);
                    let more = single(deviation) * normal.of(words.next_u32());
                    change[y * width + x] = (here + more).min(1.0) - here;
                }
            }
        }
        for (at, defect) in self.defects((width, height)) {
            let here = raw(at % width, at / width);
            change[at] = defect.of(here + change[at]).min(1.0) - here;
        }
        change
    }
}

/// Adds the colors that are made of a change of the mosaic, where there is one within reach.
fn add_colors(light: &mut Light, mut change: Vec<f32>) {
    let (width, height) = light.size();
    // The white balance comes before the colors are interpolated.
    for (at, change) in change.iter_mut().enumerate() {
        *change *= WHITE_BALANCE[color_at(at % width, at / width)];
    }
    let padded = Padded::of(&change, width, height);
    let has_change = |part: &[f32]| part.iter().any(|change| *change != 0.0);
    let rows_with: Vec<bool> = change.chunks_exact(width).map(has_change).collect();
    for y in 0..height {
        let near = y.saturating_sub(REACH)..(y + REACH + 1).min(height);
        let rows: Vec<usize> = near.filter(|y| rows_with[*y]).collect();
        if rows.is_empty() {
            continue;
        }
        for x in 0..width {
            let near = x.saturating_sub(REACH)..(x + REACH + 1).min(width);
            // A few defects cost little.
            if !rows
                .iter()
                .any(|y| has_change(&change[y * width..][near.clone()]))
            {
                continue;
            }
            let more = padded.colors(x, y);
            let colors = light.pixel_mut(y * width + x).iter_mut();
            for (color, more) in colors.zip(more) {
                *color += more;
            }
        }
    }
}
