//! Dust: grains of all sizes, most of them too small to be seen.

use std::f64::consts::{LN_10, PI};

use starbreak_seed::{Seed, Stream, uniform};

use crate::raster::Raster;
use crate::{Area, Coating, Field, Passage};

/// Dust on a pane.
///
/// There are 10^(0.926 (lg²L − lg²x)) grains of more than x µm on 0.1 m² \[CC1246\], with the cleanliness level L.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dust {
    /// Share of the glass that it covers in the mean, 0 to 0.3.
    pub coverage: f64,
    /// Share of the green light that meets a grain which is not absorbed; of red it is more, of blue less.
    pub albedo: f64,
    /// How much more or less of it there is in places, a share of the mean.
    pub unevenness: f64,
    /// How large such places are, mm.
    pub scale_mm: f64,
}

/// Slope of the sizes.
const SLOPE: f64 = 0.926;

/// Least and largest grain, µm.
const SIZES_UM: [f64; 2] = [1.0, 5000.0];

/// Most grains that are placed one by one, the largest.
const MOST_PLACED: f64 = 5e4;

/// Wavelength of green light, µm.
const WAVELENGTH_UM: f64 = 0.55;

/// Of the light that a grain takes from its way, twice what meets it, nine tenths go on forwards \[Fong1994\]: half is
/// diffracted, and so of what meets it these are.
const FORWARDS: f64 = 0.8;

/// Angle by which grains turn it, rad. FIT.
const TURNED_RAD: f64 = 0.35;

/// What grains absorb of red, green and blue over what they absorb of green, at 610, 550 and 450 nm: the imaginary part of
/// the refractive index of mineral dust, which falls to 0.55 of itself from 370 to 520 nm and to 0.45 from there to
/// 950 nm \[DiBiagio2019\], as powers of the wavelength, over the wavelength. It is why dust is ochre.
const ABSORBS: [f64; 3] = [0.79, 1.0, 1.70];

/// Grains of more than a size on a square meter.
fn n_per_m2(level_um: f64, size_um: f64) -> f64 {
    let (level, size) = (libm::log10(level_um), libm::log10(size_um));
    10.0 * libm::pow(10.0, SLOPE * (level * level - size * size))
}

/// What grains of sizes cover, and the mean over that of the logarithm of their size.
fn covered_by(level_um: f64, from_um: f64) -> (f64, f64) {
    const STEPS: u32 = 120;
    let (from, to) = (libm::log10(from_um), libm::log10(SIZES_UM[1]));
    let step = (to - from) / f64::from(STEPS);
    let (mut covered, mut sum) = (0.0, 0.0);
    for k in 0..STEPS {
        let lg = from + (f64::from(k) + 0.5) * step;
        let size_m = libm::pow(10.0, lg) * 1e-6;
        let per_lg = n_per_m2(level_um, libm::pow(10.0, lg)) * SLOPE * 2.0 * lg * LN_10;
        let area = 0.25 * PI * size_m * size_m * per_lg * step;
        covered += area;
        sum += area * lg;
    }
    (covered, sum / covered.max(f64::MIN_POSITIVE))
}

impl Dust {
    /// What dust of a cleanliness level covers: the area of all its grains, side by side.
    #[must_use]
    pub fn coverage_of_level(level_um: f64) -> f64 {
        covered_by(level_um, SIZES_UM[0]).0
    }

    /// The cleanliness level, µm, at which it covers what it does.
    #[must_use]
    pub fn level_um(&self) -> f64 {
        let (mut low, mut high) = (1.0, SIZES_UM[1]);
        for _ in 0..30 {
            let middle = 0.5 * (low + high);
            if Self::coverage_of_level(middle) < self.coverage {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }

    pub(crate) fn on_pane(&self, area: &Area, finest_mm: f64, seed: Seed) -> DustyPane {
        let level_um = self.level_um();
        let mut large = Raster::over(area, finest_mm, 0.0);
        // Sizes from the largest on: the k-th is exceeded by k grains.
        let n_of = |size_um: f64| n_per_m2(level_um, size_um) * area.rectangle_m2();
        let mut from_um = SIZES_UM[1];
        while n_of(from_um) < MOST_PLACED && from_um > 5.0 {
            from_um *= 0.98;
        }
        let field = Field::over(area, (self.scale_mm, self.unevenness), (Stream::Dust, seed));
        let mut rng = seed.stream(Stream::Dust, 9);
        let level = libm::log10(level_um);
        let n = n_of(from_um);
        let mut place = 0.0;
        let mut grains = Vec::new();
        while {
            // Places of a Poisson process along the number of larger ones.
            place -= libm::log(1.0 - uniform(&mut rng));
            place < n
        } {
            let lg_n = libm::log10(0.1 * place / area.rectangle_m2());
            let size_mm = 1e-3 * libm::pow(10.0, (level * level - lg_n / SLOPE).max(0.0).sqrt());
            let sides = area.sides_mm();
            // Where there is more dust there are more.
            let at = loop {
                let at = [0, 1].map(|k| area.from_mm[k] + uniform(&mut rng) * sides[k]);
                if uniform(&mut rng) * 2.0 < field.at(at) {
                    break at;
                }
            };
            grains.push((at, 0.5 * size_mm));
        }
        // Together, so that the processor fetches the cells of several at once.
        for (at, radius_mm) in grains {
            add_grain(&mut large, at, radius_mm);
        }
        let (all, mean_lg) = covered_by(level_um, SIZES_UM[0]);
        let small = (all - covered_by(level_um, from_um).0).max(0.0);
        DustyPane {
            albedo: self.albedo,
            rgb: ABSORBS.map(|times| libm::pow(self.albedo.max(1e-6), times - 1.0)),
            large,
            small,
            field,
            diffracts_by_rad: 0.42 * WAVELENGTH_UM / libm::pow(10.0, mean_lg),
        }
    }
}

/// Adds what a grain covers of its cells.
fn add_grain(covered: &mut Raster, at_mm: [f64; 2], radius_mm: f64) {
    let cell_mm = covered.cell_mm;
    let [columns, rows] = covered.around(at_mm, radius_mm);
    let n_cells = columns.len() * rows.len();
    if n_cells <= 4 {
        #[expect(clippy::cast_possible_truncation, reason = "a share of a cell")]
        let share = (PI * radius_mm * radius_mm / (cell_mm * cell_mm)) as f32;
        if let Some(cell) = covered.cell(at_mm) {
            covered.values[cell] += share;
        }
        return;
    }
    for y in rows {
        for x in columns.clone() {
            let [mx, my] = covered.middle_mm(x, y);
            let beyond = (libm::hypot(mx - at_mm[0], my - at_mm[1]) - radius_mm) / cell_mm;
            #[expect(clippy::cast_possible_truncation, reason = "a share of a cell")]
            let share = (0.5 - beyond).clamp(0.0, 1.0) as f32;
            covered.values[y * covered.size[0] + x] += share;
        }
    }
}

/// Dust on one pane.
pub(crate) struct DustyPane {
    albedo: f64,
    /// The albedo of each color over that of green: absorption is e^(−αd) of a way d.
    rgb: [f64; 3],
    large: Raster,
    small: f64,
    field: Field,
    diffracts_by_rad: f64,
}

impl Coating for DustyPane {
    fn passage(&self, at_mm: [f64; 2]) -> Passage {
        let c = (self.small * self.field.at(at_mm) + self.large.at(at_mm)).clamp(0.0, 1.0);
        Passage {
            covered: c,
            direct: [(1.0 - c) * (1.0 - c); 3],
            narrow: c * (1.0 - c),
            wide: c * self.albedo * FORWARDS,
            back: (self.rgb).map(|color| c * self.albedo * (1.0 - FORWARDS) * color),
            ..Passage::CLEAN
        }
    }

    fn turns_by_rad(&self) -> [f64; 2] {
        [self.diffracts_by_rad, TURNED_RAD]
    }

    fn wide_rgb(&self) -> [f64; 3] {
        self.rgb
    }
}
