//! Coats on the glass: screens that take light away, spread it, turn it, and shine themselves.
//!
//! What a coat does to light at each place of the pane ([`Coating`]) becomes maps of a frame, each spread by the pupil as the
//! pane is out of focus. Then, for any image of that size,
//!
//! I(x) ← D I(x + d) + N G_n∗I + W G_w∗I + S L∗I + A
//!
//! with shares D of what goes straight on, N and W of what is turned a little, S of what grooves turn across them, and A the
//! light of all that is around, of which the coat sends some on and some back.

mod samples;
mod streak;
mod turned;

use starbreak_deposit::Coating;

use crate::View;
use crate::environment::{
    Environment, EnvironmentParams, HemisphereWeights, Rgb, luminance, of_colors,
};
use crate::lens::Lens;
use crate::lens_faults::Optic;
use crate::maps::Pupil;
use crate::pyramid::{Cells, Pyramid, vectorized};
use crate::vector::dot;

use samples::{Samples, Spread};
use streak::Streaks;
use turned::Turned;

/// Cells of a map per radius of the disc that a point of the pane becomes in the middle row.
const CELLS_PER_RADIUS: f64 = 1.2;

/// Widest cell of a map, px.
const WIDEST_PX: f64 = 4.0;

/// What is moved or blurred by more than this, px, is no longer where it was.
const MOVED_PX: f32 = 0.5;

/// A coat before one camera, ready for any image of its size.
#[derive(Debug, Clone, PartialEq)]
pub struct Screen {
    size: (usize, usize),
    direct: Map,
    /// Turned by the smaller and by the larger angle, and by grooves.
    turned: Map,
    /// Sent on in any direction, and sent back, where there is any.
    diffuse: Option<Map>,
    back: Option<Map>,
    moved: Option<Turned>,
    streaks: Option<Streaks>,
    spreads_px: [f64; 2],
    wide_rad: f64,
    wide_rgb: Rgb,
    covered: f64,
    /// Whether any light is turned by the smaller and by the larger angle, and whether any changes at all.
    has_halos: [bool; 2],
    is_nothing: bool,
    sights: Sights,
}

/// Three numbers in each cell of a frame.
type Map = Cells<3>;

/// Focal length, px, and the pane's normal on the side of the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Sights {
    f_px: f64,
    normal: [f64; 3],
}

/// Radius of the disc that a point of the pane becomes in a row of the frame, px.
fn radius_px(view: &View, lens: &Lens, f_px: f64, row_px: f64) -> f64 {
    let depth_m = view.depth_mm(row_px).map_or(f64::INFINITY, |mm| mm * 1e-3);
    0.5 * lens.circle_of_confusion_px(f_px, depth_m)
}

/// Width of the cells of a coat that is even over a way on the pane, mm, px.
fn even_px(view: &View, even_over_mm: f64) -> u32 {
    let middle = [view.size().0, view.size().1].map(|n| 0.5 * f64::from(n));
    let px_per_mm = (view.unproject(middle)).and_then(|at_mm| view.px_per_unit(at_mm));
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "some px"
    )]
    let even_px = (even_over_mm * px_per_mm.unwrap_or(0.0)).clamp(1.0, WIDEST_PX) as u32;
    even_px
}

impl Screen {
    /// Of a coat on the pane that a view sees through a lens.
    #[must_use]
    pub fn of(coating: &dyn Coating, view: &View, optic: &Optic) -> Self {
        let radius = |row_px: f64| radius_px(view, &optic.lens, optic.f_px, row_px);
        let per_cell = Self::cell_px(view, &optic.lens, optic.f_px);
        let per_cell = per_cell.max(even_px(view, coating.even_over_mm()));
        let samples = Samples::of(coating, (view, optic.f_px), per_cell);
        let radii: Vec<f64> = (0_u32..)
            .take(samples.size.1)
            .map(|y| {
                let cells =
                    radius((f64::from(y) + 0.5) * f64::from(per_cell)) / f64::from(per_cell);
                // Variances per axis, cells²: the kernel 1/12, lines between cells 1/6; that of a disc is ρ²/4.
                let known = if per_cell > 1 { 1.0 } else { 0.0 };
                (cells * cells - known).max(0.0).sqrt().copysign(cells)
            })
            .collect();
        let spread = Spread::of(Pupil::of(&optic.lens), &radii);
        let [narrow_rad, wide_rad] = coating.turns_by_rad();
        let (width, height) = view.size();
        #[expect(clippy::cast_possible_truncation, reason = "shares of light")]
        let wide_rgb = coating.wide_rgb().map(|color| color as f32);
        let direct = samples.map(&spread, &samples.direct, 1.0);
        let turned = samples.map(&spread, &samples.turned, 0.0);
        let moved = Turned::of(&samples, &spread);
        let is_whole = |it: &Rgb| it.iter().all(|share| *share >= 1.0);
        Self {
            size: (width as usize, height as usize),
            has_halos: [0, 1].map(|k| turned.values().any(|it| it[k] > 0.0)),
            is_nothing: direct.values().all(is_whole) && moved.is_none(),
            direct,
            turned,
            moved,
            diffuse: samples.map_of_any(&spread, &samples.diffuse),
            back: samples.map_of_any(&spread, &samples.back),
            streaks: Streaks::of(&samples, optic.f_px),
            spreads_px: [narrow_rad, wide_rad].map(|rad| rad * optic.f_px),
            wide_rad,
            wide_rgb,
            covered: samples.covered,
            sights: Sights {
                f_px: optic.f_px,
                normal: view.outer_normal(),
            },
        }
    }

    /// Width of the cells in which a lens of a focal length, px, shows the coats on a pane, px.
    #[must_use]
    pub fn cell_px(view: &View, lens: &Lens, f_px: f64) -> u32 {
        let middle_px = radius_px(view, lens, f_px, 0.5 * f64::from(view.size().1)).abs();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "some px"
        )]
        let cell_px = (middle_px / CELLS_PER_RADIUS).clamp(1.0, WIDEST_PX) as u32;
        cell_px
    }

    /// Whether no light changes.
    #[must_use]
    pub fn is_nothing(&self) -> bool {
        self.is_nothing
    }

    /// Mean share of the frame that is covered.
    #[must_use]
    pub fn mean_covered(&self) -> f64 {
        self.covered
    }

    /// Mean share of light that goes straight on, of all colors.
    #[must_use]
    pub fn mean_direct(&self) -> f64 {
        let sum: f64 = self
            .direct
            .values()
            .map(|it| f64::from(luminance(*it)))
            .sum();
        #[expect(clippy::cast_precision_loss, reason = "cells of a frame")]
        let n = (self.direct.size.0 * self.direct.size.1).max(1) as f64;
        sum / n
    }

    /// Standard deviations of the light about a lamp, px: of what is turned by the smaller and by the larger angle.
    #[must_use]
    pub fn halos_px(&self) -> [f64; 2] {
        self.spreads_px
    }

    /// Where more than a share of the light is not as it was, in rows of pixels.
    #[must_use]
    pub fn reaches(&self, least: f64) -> Vec<bool> {
        #[expect(clippy::cast_possible_truncation, reason = "a share of light")]
        let most = 1.0 - (least as f32).max(1e-6);
        let mut reached = Vec::with_capacity(self.size.0 * self.size.1);
        let mut direct = self.direct.rows(self.size.0, 1);
        for y in 0..self.size.1 {
            let shares = direct.at(y).as_chunks::<3>().0;
            reached.extend(
                shares
                    .iter()
                    .map(|it| it.iter().any(|share| *share <= most)),
            );
        }
        if let Some(moved) = &self.moved {
            let (per_cell, columns) = (self.direct.per_cell as usize, self.direct.size.0);
            for (row, y) in reached.chunks_exact_mut(self.size.0.max(1)).zip(0..) {
                for (is_reached, x) in row.iter_mut().zip(0..) {
                    let cell = y / per_cell * columns + x / per_cell;
                    *is_reached |= moved.moves_by(cell) >= MOVED_PX;
                }
            }
        }
        reached
    }

    /// Share of the light of an image that passes at all, in rows of pixels.
    #[must_use]
    pub fn passing(&self) -> Vec<f32> {
        let mut passing = Vec::with_capacity(self.size.0 * self.size.1);
        let [mut direct, mut turned] =
            [&self.direct, &self.turned].map(|it| it.rows(self.size.0, 1));
        for y in 0..self.size.1 {
            let both = direct.at(y).as_chunks::<3>().0.iter();
            let both = both.zip(turned.at(y).as_chunks::<3>().0);
            passing.extend(
                both.map(|(direct, turned)| luminance(*direct) + turned.iter().sum::<f32>()),
            );
        }
        passing
    }

    /// The light that the coat itself sends to the camera, under the light around it.
    fn shines(&self, light: &Environment, params: &EnvironmentParams) -> Option<Map> {
        let has_lobe = light.sun_rgb.iter().any(|it| *it > 0.0) && self.has_halos[1];
        if self.diffuse.is_none() && self.back.is_none() && !has_lobe {
            return None;
        }
        let Sights { f_px, normal } = self.sights;
        let height = u32::try_from(self.size.1).unwrap_or(u32::MAX);
        let horizon = params.horizon(height, f_px);
        let sun = params.sun(&horizon);
        let cos_to_up = dot(normal, horizon.up);
        let sky = HemisphereWeights::facing(cos_to_up).mean_radiance(light);
        #[expect(clippy::cast_possible_truncation, reason = "shares of light")]
        let on_pane = (dot(normal, sun).max(0.0) / std::f64::consts::PI) as f32;
        let outside: Rgb = std::array::from_fn(|k| sky[k] + on_pane * light.sun_rgb[k]);
        let cabin: Rgb =
            std::array::from_fn(|k| 0.5 * (light.cabin_low_rgb[k] + light.cabin_high_rgb[k]));
        let (columns, _) = self.direct.size;
        let per_cell = f64::from(self.direct.per_cell);
        let is_outside = dot(normal, sun) > 0.0;
        let values: Vec<f32> = (self.turned.values().enumerate())
            .flat_map(|(cell, turned)| {
                #[expect(clippy::cast_precision_loss, reason = "cells of a frame")]
                let at = [cell % columns, cell / columns].map(|k| (k as f64 + 0.5) * per_cell);
                let lobe = if has_lobe && is_outside {
                    turned[1] * self.lobe(at, sun)
                } else {
                    0.0
                };
                let of = |map: &Option<Map>| map.as_ref().map_or([0.0; 3], |map| map.cell(cell));
                let (diffuse, back) = (of(&self.diffuse), of(&self.back));
                let shine: Rgb = std::array::from_fn(|k| {
                    let lobe = lobe * self.wide_rgb[k];
                    diffuse[k] * outside[k] + back[k] * cabin[k] + lobe * light.sun_rgb[k]
                });
                shine
            })
            .collect();
        Some(Cells::of_cells(
            &values,
            self.direct.size,
            self.direct.per_cell,
        ))
    }

    /// Light of a distant lamp that is turned by the larger angle towards the camera, per irradiance: the phase function of
    /// Henyey and Greenstein \[HenyeyGreenstein1941\] with the mean cosine of that angle.
    fn lobe(&self, at_px: [f64; 2], lamp: [f64; 3]) -> f32 {
        let [x, y] = [
            at_px[0] - 0.5 * to_f64(self.size.0),
            at_px[1] - 0.5 * to_f64(self.size.1),
        ];
        let f = self.sights.f_px;
        let cos = dot([x, y, f], lamp) / (x * x + y * y + f * f).sqrt();
        let g = libm::exp(-self.wide_rad * self.wide_rad);
        let square = 1.0 + g * g - 2.0 * g * cos;
        #[expect(clippy::cast_possible_truncation, reason = "light is single precision")]
        let density =
            ((1.0 - g * g) / (4.0 * std::f64::consts::PI * square * square.sqrt())) as f32;
        density
    }

    /// The coat under what is around it, for any frame of its size.
    #[must_use]
    pub fn under(&self, light: &Environment, params: &EnvironmentParams) -> LitScreen<'_> {
        LitScreen {
            screen: self,
            shine: self.shines(light, params),
        }
    }
}

/// A coat under one light.
#[derive(Debug, Clone)]
pub struct LitScreen<'a> {
    screen: &'a Screen,
    /// The light that it sends to the camera itself.
    shine: Option<Map>,
}

impl LitScreen<'_> {
    /// The coat.
    #[must_use]
    pub fn screen(&self) -> &Screen {
        self.screen
    }

    /// What the coat makes of the light of a frame with 1 or 3 values per pixel, in place.
    pub fn over(&self, light: &mut [f32], n_colors: usize) {
        match n_colors {
            1 => self.colors_over::<1>(light),
            _ => self.colors_over::<3>(light),
        }
    }

    fn colors_over<const COLORS: usize>(&self, light: &mut [f32]) {
        let screen = self.screen;
        let mut pyramid = Pyramid::<COLORS>::of(light, screen.size);
        let [narrow, mut wide] =
            [0, 1].map(|k| screen.has_halos[k].then(|| pyramid.spread(screen.spreads_px[k])));
        if let Some(wide) = &mut wide {
            let tint = of_colors::<COLORS>(screen.wide_rgb);
            for light in wide.values_mut() {
                *light = std::array::from_fn(|c| tint[c] * light[c]);
            }
        }
        let streaks = (screen.streaks.as_ref()).map(|it| it.over(&mut pyramid, screen.size));
        if let Some(moved) = &screen.moved {
            moved.over::<COLORS>(light, screen.size);
        }
        let spread = [narrow, wide, streaks];
        vectorized(
            #[inline(always)]
            || {
                let beside = self.beside(&spread);
                self.rows_over(light, beside.as_ref());
            },
        );
    }

    /// The light that joins what goes straight on, where there is any: of halos and streaks by their shares, and the coat's
    /// own. In cells as wide as the narrowest of these.
    #[inline(always)]
    fn beside<const COLORS: usize>(
        &self,
        spread: &[Option<Cells<COLORS>>; 3],
    ) -> Option<Cells<COLORS>> {
        let Screen { size, turned, .. } = self.screen;
        let widths = spread.iter().flatten().map(|cells| cells.per_cell);
        let per_cell = match (widths.min(), &self.shine) {
            (Some(narrowest), _) => narrowest.min(turned.per_cell),
            (None, Some(_)) => turned.per_cell,
            (None, None) => return None,
        };
        let mut beside = Cells::none(*size, per_cell);
        let columns = beside.size.0;
        let mut shares = turned.rows(columns, per_cell);
        let mut spread = (spread.each_ref())
            .map(|cells| cells.as_ref().map(|cells| cells.rows(columns, per_cell)));
        let mut shine = self.shine.as_ref().map(|map| map.rows(columns, per_cell));
        for (y, row) in beside.values_mut().chunks_exact_mut(columns).enumerate() {
            let shares = shares.at(y).as_chunks::<3>().0;
            for (k, rows) in spread.iter_mut().enumerate() {
                let Some(rows) = rows else { continue };
                let halo = rows.at(y).as_chunks::<COLORS>().0;
                for ((cell, share), halo) in row.iter_mut().zip(shares).zip(halo) {
                    for c in 0..COLORS {
                        cell[c] += share[k] * halo[c];
                    }
                }
            }
            if let Some(shine) = &mut shine {
                for (cell, more) in row.iter_mut().zip(shine.at(y).as_chunks::<3>().0) {
                    let more = of_colors::<COLORS>(*more);
                    for c in 0..COLORS {
                        cell[c] += more[c];
                    }
                }
            }
        }
        Some(beside)
    }

    /// Shares of the light of each pixel, and what joins it.
    #[inline(always)]
    fn rows_over<const COLORS: usize>(&self, light: &mut [f32], beside: Option<&Cells<COLORS>>) {
        let width = self.screen.size.0;
        let mut direct = self.screen.direct.rows(width, 1);
        let mut beside = beside.map(|cells| cells.rows(width, 1));
        for (y, row) in light.chunks_exact_mut(width * COLORS).enumerate() {
            let direct = direct.at(y);
            if COLORS == 3 {
                for (value, share) in row.iter_mut().zip(direct) {
                    *value *= share;
                }
            } else {
                let pixels = row.as_chunks_mut::<COLORS>().0.iter_mut();
                for (pixel, shares) in pixels.zip(direct.as_chunks::<3>().0) {
                    let shares = of_colors::<COLORS>(*shares);
                    for c in 0..COLORS {
                        pixel[c] *= shares[c];
                    }
                }
            }
            if let Some(beside) = &mut beside {
                for (value, more) in row.iter_mut().zip(beside.at(y)) {
                    *value += more;
                }
            }
        }
    }
}

#[expect(clippy::cast_precision_loss, reason = "px of a frame")]
fn to_f64(n: usize) -> f64 {
    n as f64
}
