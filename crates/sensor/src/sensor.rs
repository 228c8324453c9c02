//! The stages behind the lens, in the order in which light meets them.

use std::borrow::Cow;

use starbreak_seed::{Seed, Stream, uniform};

use crate::draw::{Normal, single, words_of};
use crate::fault::Acts;
use crate::mosaic::{Padded, REACH, WHITE_BALANCE, color_at, colors_at};
use crate::{
    Code, Codes, Defect, Exposure, Fault, Filters, FrameState, Frames, Isp, Lamps, Light, Lines,
    Link, Noise, Pixels, RawRows, SensorError, Spots,
};

/// A frame among others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// What differs from frame to frame is drawn from it.
    pub frame: Seed,
    /// What is the same in all frames of a clip.
    pub clip: Seed,
    /// Place of the frame in the clip.
    pub frame_idx: u64,
    /// When the frame begins, s.
    pub time_s: f64,
}

impl From<Seed> for Moment {
    /// A picture by itself. All faults have begun.
    fn from(seed: Seed) -> Self {
        Self {
            frame: seed,
            clip: seed,
            frame_idx: 0,
            time_s: f64::INFINITY,
        }
    }
}

/// A sensor with its faults, and those of what comes after it. Without any, or with all of them at nothing, a frame
/// stays as it is, to the last bit.
///
/// Stages that work are not run: a photograph has been through them. With U the way from light back to the mosaic and
/// P from there to light, a fault F of the mosaic gives I + P(F(U(I)) − U(I)), since P, the white balance and the
/// interpolation of colors, is linear: the photograph keeps its sharpness, and a defect reaches 13 pixels of 5 x 5.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Sensor {
    /// Which sensor it is: what is fixed in it is drawn from this.
    pub number: u64,
    faults: Vec<(f64, Fault)>,
}

impl Sensor {
    /// A sensor with faults, each with the time of a clip at which it begins, s; of each kind one.
    #[must_use]
    pub fn new(number: u64, faults: Vec<(f64, Fault)>) -> Self {
        Self { number, faults }
    }

    /// Sensor 0 with a fault that is there from the beginning.
    #[must_use]
    pub fn of(fault: impl Into<Fault>) -> Self {
        Self::default().and(fault)
    }

    /// With another fault.
    #[must_use]
    pub fn and(mut self, fault: impl Into<Fault>) -> Self {
        self.faults.push((0.0, fault.into()));
        self
    }

    /// The faults, each with the time of a clip at which it begins, s.
    #[must_use]
    pub fn faults(&self) -> &[(f64, Fault)] {
        &self.faults
    }

    /// Without the faults that are nothing.
    #[must_use]
    pub fn faulty(mut self) -> Self {
        self.faults.retain(|(_, fault)| !fault.is_nothing());
        self
    }

    /// With the faults alone that have begun at a time.
    #[must_use]
    pub fn at(&self, time_s: f64) -> Cow<'_, Self> {
        if self.faults.iter().all(|(onset_s, _)| *onset_s <= time_s) {
            return Cow::Borrowed(self);
        }
        let mut now = self.clone();
        now.faults.retain(|(onset_s, _)| *onset_s <= time_s);
        Cow::Owned(now)
    }

    /// A fault of a kind, where it is any.
    pub fn get<'a, F>(&'a self) -> Option<&'a F>
    where
        &'a F: TryFrom<&'a Fault>,
    {
        let faults = self.faults.iter().filter(|(_, it)| !it.is_nothing());
        faults
            .map(|(_, fault)| fault)
            .find_map(|it| it.try_into().ok())
    }

    /// Whether light of a frame changes; of some faults codes do alone.
    #[must_use]
    pub fn changes_light(&self) -> bool {
        !self.acts_only(Acts::OnCodes)
    }

    /// Whether the faults change nothing but this, and codes.
    fn acts_only(&self, what: Acts) -> bool {
        let mut acts = self.faults.iter().map(|(_, fault)| fault.acts());
        acts.all(|it| it == what || it == Acts::OnCodes)
    }

    /// What the light of each row is multiplied by, where that is all that changes it.
    #[must_use]
    pub fn gains_of_rows(&self, height: usize, at: Moment) -> Option<Vec<f32>> {
        (self.acts_only(Acts::ByRows)).then(|| self.row_gains(height, at))
    }

    /// Exposure and lamps, row by row.
    fn row_gains(&self, height: usize, at: Moment) -> Vec<f32> {
        let (exposure, lamps) = (self.get::<Exposure>(), self.get::<Lamps>());
        let gain = exposure.map_or(1.0, Exposure::gain);
        let phase = uniform(&mut at.clip.stream(Stream::Lamps, 0));
        let time_s = if at.time_s.is_finite() {
            at.time_s
        } else {
            0.0
        };
        let of_row = |y: usize| {
            #[expect(clippy::cast_precision_loss, reason = "rows of a frame")]
            let lamps = lamps.map_or(1.0, |lamps| lamps.gain(y as f64, time_s, phase));
            single(gain * lamps)
        };
        (0..height).map(of_row).collect()
    }

    /// What becomes of a frame of a clip.
    #[must_use]
    pub fn frame_state(&self, at: Moment) -> FrameState {
        let frames = self.get::<Frames>();
        frames.map_or(FrameState::Good, |frames| frames.of(at.clip, at.frame_idx))
    }

    /// What the faults make of a frame of light, in place. Spots, filters, lamps and exposure multiply and mix it, in any
    /// order, before the full well cuts it.
    pub fn over(&self, light: &mut Light, at: Moment) {
        self.shade(light);
        if let (Some(filters), 3) = (self.get::<Filters>(), light.n_colors()) {
            for pixel in light.values_mut().chunks_exact_mut(3) {
                pixel.copy_from_slice(&filters.of([pixel[0], pixel[1], pixel[2]]));
            }
        }
        self.expose(light, at);
        let change = self.mosaic_change(light, at);
        if !change.is_empty() {
            add_colors(light, change);
        }
        let raw = self.get::<RawRows>().map(|rows| (rows, at.clip));
        let isp = self.get::<Isp>().unwrap_or(&Isp::WORKS);
        isp.over(light, raw);
    }

    /// What the faults add to the light of single pixels, where defects are the only ones that change light: each with
    /// its place in rows from the top. `light_of` is the light of a color of a pixel.
    pub fn changes_of_defects(
        &self,
        (width, height): (usize, usize),
        n_colors: usize,
        light_of: impl Fn(usize, usize) -> f32,
    ) -> Option<Vec<(usize, [f32; 3])>> {
        if !self.acts_only(Acts::OnPixels) {
            return None;
        }
        let defects = self.defects((width, height));
        let mut change = vec![0.0_f32; width * height];
        for (at, defect) in &defects {
            let (color, gain) = filter_of(*at, width, n_colors);
            let here = (light_of(*at, color) / gain).min(1.0);
            change[*at] = (defect.of(here).min(1.0) - here) * gain;
        }
        if n_colors == 1 {
            let all = defects.iter().map(|(at, _)| (*at, [change[*at]; 3]));
            return Some(all.collect());
        }
        let mut is_done = vec![false; width * height];
        let mut changes = Vec::with_capacity(13 * defects.len());
        for (at, _) in defects {
            each_reached(at, (width, height), |at| {
                if !std::mem::replace(&mut is_done[at], true) {
                    changes.push((at, colors_at(&change, (width, height), at)));
                }
            });
        }
        Some(changes)
    }

    /// What the faults make of the codes of a frame, in place; `light_of` is the light of a code.
    ///
    /// # Errors
    /// [`SensorError::Jpeg`] for a frame that no JPEG holds.
    pub fn over_codes<C: Code>(
        &self,
        codes: &mut Codes<'_, C>,
        light_of: impl Fn(C) -> f32,
        at: Moment,
    ) -> Result<(), SensorError> {
        match self.frame_state(at) {
            FrameState::Black => codes.colors_mut().for_each(|it| *it = C::of_share(0.0)),
            FrameState::White => codes.colors_mut().for_each(|it| *it = C::of_share(1.0)),
            _ => {
                if let Some(isp) = self.get::<Isp>().filter(|isp| isp.tone > 0.0) {
                    for code in codes.colors_mut() {
                        let light = f64::from(light_of(*code));
                        *code = C::of_share(isp.code_without_tone(code.share(), light));
                    }
                }
                if let Some(link) = self.get::<Link>() {
                    link.over(codes, at.frame)?;
                }
            }
        }
        Ok(())
    }

    /// Which pixels of a frame the faults reach: all of them, or those around defects, under spots, in rows without colors
    /// or of other rows, and with wrong bits. `form` is how many colors a pixel has, 1 or 3, and the bits of each.
    #[must_use]
    pub fn reach(&self, size: (usize, usize), form: (usize, u32), at: Moment) -> Vec<bool> {
        let now = self.at(at.time_s);
        let (width, height) = size;
        let is_everywhere = now.frame_state(at).is_blank()
            || now
                .faults
                .iter()
                .any(|(_, fault)| is_everywhere(fault, form.0));
        let mut reached = vec![is_everywhere; width * height];
        if is_everywhere {
            return reached;
        }
        for (defect, _) in now.defects(size) {
            if form.0 == 1 {
                reached[defect] = true;
            } else {
                each_reached(defect, size, |at| reached[at] = true);
            }
        }
        if let Some(spots) = now.get::<Spots>() {
            spots.each_shadowed(size, Seed(now.number), |at, _| reached[at] = true);
        }
        if let (Some(raw), 3) = (now.get::<RawRows>(), form.0) {
            let rows = reached.chunks_exact_mut(width);
            for (row, is_raw) in rows.zip(raw.of_clip(height, at.clip)) {
                row.iter_mut().for_each(|it| *it |= is_raw);
            }
        }
        if let Some(link) = now.get::<Link>() {
            if link.row_bits < 16 {
                let first = (width << link.row_bits).min(reached.len());
                reached[first..].fill(true);
            }
            link.each_wrong(size, form, at.frame, |pixel, _, _| reached[pixel] = true);
        }
        reached
    }

    /// The defects with their places, in rows from the top, each pixel once.
    #[must_use]
    pub fn defects(&self, (width, height): (usize, usize)) -> Vec<(usize, Defect)> {
        let sensor = Seed(self.number);
        let mut all = match self.get::<Pixels>() {
            Some(pixels) => pixels.of_sensor(width * height, sensor),
            None => Vec::new(),
        };
        if let Some(lines) = self.get::<Lines>() {
            let [rows, columns] = lines.of_sensor((width, height), sensor);
            let level = Defect::Stuck(single(lines.level));
            for y in rows {
                all.extend((0..width).map(|x| (y * width + x, level)));
            }
            for x in columns {
                all.extend((0..height).map(|y| (y * width + x, level)));
            }
        }
        // Of two at one place the last counts.
        all.reverse();
        all.sort_by_key(|(at, _)| *at);
        all.dedup_by_key(|(at, _)| *at);
        all
    }

    /// Shadows of spots.
    fn shade(&self, light: &mut Light) {
        if let Some(spots) = self.get::<Spots>() {
            spots.each_shadowed(light.size(), Seed(self.number), |at, left| {
                light.pixel_mut(at).iter_mut().for_each(|it| *it *= left);
            });
        }
    }

    /// Exposure and lamps.
    fn expose(&self, light: &mut Light, at: Moment) {
        if self.get::<Exposure>().is_none() && self.get::<Lamps>().is_none() {
            return;
        }
        let n_colors = light.n_colors();
        let gains = self.row_gains(light.size().1, at);
        for ((_, row), gain) in light.rows_mut().zip(gains) {
            // No more than the full well holds, after the white balance.
            if n_colors == 1 {
                row.iter_mut().for_each(|it| *it = (*it * gain).min(1.0));
            } else {
                for pixel in row.chunks_exact_mut(3) {
                    for (color, full) in pixel.iter_mut().zip(WHITE_BALANCE) {
                        *color = (*color * gain).min(full);
                    }
                }
            }
        }
    }

    /// What the faults of the mosaic add to it, after the white balance; nothing where there are none.
    fn mosaic_change(&self, light: &Light, at: Moment) -> Vec<f32> {
        let noise = self.get::<Noise>();
        // Only a darker frame lacks noise.
        let darker = self.get::<Exposure>().filter(|it| it.ev < 0.0);
        let missing = darker.filter(|_| noise.is_none()).map(Exposure::missing);
        let (width, height) = light.size();
        let defects = self.defects((width, height));
        if noise.is_none() && missing.is_none() && defects.is_empty() {
            return Vec::new();
        }
        let n_colors = light.n_colors();
        let mut change = vec![0.0_f32; width * height];
        let mut row = vec![0.0_f32; width];
        for (y, change) in change.chunks_exact_mut(width).enumerate() {
            if let Some(noise) = noise {
                raw_row(light, y, &mut row);
                let seeds = [at.frame, Seed(self.number)];
                noise.add_to_row(y, &row, change, seeds);
            } else if let Some(missing) = &missing {
                raw_row(light, y, &mut row);
                let normal = Normal::new();
                let words = words_of(at.frame, Stream::SensorElectrons, y, width);
                for ((change, here), word) in change.iter_mut().zip(&row).zip(words) {
                    *change = (here + missing(*here) * normal.of(word)).min(1.0) - here;
                }
            }
        }
        for (at, defect) in defects {
            let (color, gain) = filter_of(at, width, n_colors);
            let here = (light.values()[at * n_colors + color] / gain).min(1.0);
            change[at] = defect.of(here + change[at]).min(1.0) - here;
        }
        if n_colors == 3 {
            for (y, row) in change.chunks_exact_mut(width).enumerate() {
                let gains = [0, 1].map(|x| WHITE_BALANCE[color_at(x, y)]);
                for two in row.chunks_mut(2) {
                    for (change, gain) in two.iter_mut().zip(gains) {
                        *change *= gain;
                    }
                }
            }
        }
        change
    }
}

/// Whether a fault changes whole frames of so many colors.
fn is_everywhere(fault: &Fault, n_colors: usize) -> bool {
    !fault.is_nothing()
        && match fault {
            Fault::Exposure(_) | Fault::Lamps(_) | Fault::Noise(_) => true,
            Fault::Filters(_) => n_colors == 3,
            // Gray has no white balance and no color matrix.
            Fault::Isp(isp) => {
                n_colors == 3 || isp.black_level > 0.0 || isp.unsharp > 0.0 || isp.tone > 0.0
            }
            Fault::Link(link) => link.jpeg_quality > 0,
            Fault::Spots(_)
            | Fault::Pixels(_)
            | Fault::Lines(_)
            | Fault::RawRows(_)
            | Fault::Frames(_) => false,
        }
}

/// The color that the pixel of a place sees, and what white balance multiplies it by.
fn filter_of(at: usize, width: usize, n_colors: usize) -> (usize, f32) {
    match n_colors {
        1 => (0, 1.0),
        _ => {
            let color = color_at(at % width, at / width);
            (color, WHITE_BALANCE[color])
        }
    }
}

/// What the pixels of row y of the mosaic see; no more than the full well holds.
fn raw_row(light: &Light, y: usize, row: &mut [f32]) {
    let n_colors = light.n_colors();
    let values = &light.values()[y * row.len() * n_colors..];
    if n_colors == 1 {
        for (raw, value) in row.iter_mut().zip(values) {
            *raw = value.min(1.0);
        }
        return;
    }
    let filters = [0, 1].map(|x| (color_at(x, y), 1.0 / WHITE_BALANCE[color_at(x, y)]));
    for (two, pixels) in row.chunks_mut(2).zip(values.chunks(6)) {
        for ((raw, pixel), (color, share)) in two.iter_mut().zip(pixels.chunks(3)).zip(filters) {
            *raw = (pixel[color] * share).min(1.0);
        }
    }
}

/// Calls for each pixel whose colors are made of the pixel of a place: 13 of 5 x 5.
fn each_reached(at: usize, (width, height): (usize, usize), mut call: impl FnMut(usize)) {
    let (x, y) = (at % width, at / width);
    for near_y in y.saturating_sub(REACH)..(y + REACH + 1).min(height) {
        let left = REACH - near_y.abs_diff(y);
        for near_x in x.saturating_sub(left)..(x + left + 1).min(width) {
            call(near_y * width + near_x);
        }
    }
}

/// Adds the colors that are made of a change of the mosaic.
fn add_colors(light: &mut Light, change: Vec<f32>) {
    if light.n_colors() == 1 {
        for (value, change) in light.values_mut().iter_mut().zip(&change) {
            *value += change;
        }
        return;
    }
    let (width, height) = light.size();
    let padded = Padded::of(&change, width, height);
    for (y, row) in light.rows_mut() {
        padded.colors_of_row(y, |x, more| {
            for (color, more) in row[3 * x..3 * x + 3].iter_mut().zip(more) {
                *color += more;
            }
        });
    }
}
