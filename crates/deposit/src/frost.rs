//! Frost: crystals of ice that grow from nuclei in branches of sixty degrees.

use std::f64::consts::{FRAC_PI_3, TAU};

use starbreak_seed::{Seed, Stream, normal, uniform};

use crate::closing::close_in;
use crate::raster::Raster;
use crate::{Area, Coating, Heat, Heating, Passage, vectorized};

/// Ice on a pane.
///
/// From each nucleus stems grow at the speed of the front, in directions 60° apart; they branch on both sides, at 60°
/// again, and branches branch, each kind slower than the one before. A tip that meets ice stops. Between branches ice
/// closes in slowly. It thickens with the root of the time since it came, as heat has to be led away through it.
///
/// Between crystals dew has frozen: drops, as those of dew, cover a share of the glass that comes with the front.
///
/// When the glass is heated it grows no more and becomes thinner, so that stems stay longest. One µm/s takes 306 W/m². The
/// water is not seen: on glass under ice it is a film.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frost {
    /// How long it has been there, s.
    pub age_s: f64,
    /// Age from which it melts, s; infinite where it never does.
    pub melts_from_s: f64,
    /// How fast it becomes thinner then, mm/s, in the mean over the pane.
    pub melts_mm_s: f64,
    /// What heats it then.
    pub heated_by: Heating,
    /// Speed of the tips of stems, mm/s.
    pub front_mm_s: f64,
    /// Nuclei per mm².
    pub nuclei_per_mm2: f64,
    /// Share of the glass between crystals that frozen dew covers in the end.
    pub rime: f64,
}

/// Angle by which it turns light per axis, rad: (n − 1) times slopes of some 30°, and more where it scatters. FIT.
const TURNED_RAD: f64 = 0.18;

/// Thickness of ice when the front has gone a millimeter further, mm. FIT.
const THICKNESS_MM: f64 = 0.06;

/// Thickness up to which most of its face is even, mm. FIT.
const EVEN_MM: f64 = 0.08;

/// What it scatters, by bubbles and cracks, mm⁻¹. FIT.
const SCATTERS_PER_MM: f64 = 2.0;

/// How much thicker it is on stems, branches and branches of these, and between them. FIT.
const RIDGES: [f32; 3] = [3.0, 2.0, 1.4];
const BETWEEN: f32 = 0.35;

/// Speed of stems, branches, and branches of these, over that of the front. FIT.
const SPEEDS: [f64; 3] = [1.0, 0.6, 0.4];

/// Half the width of each when its tip passes, mm. FIT.
const HALF_WIDTHS_MM: [f64; 3] = [0.3, 0.16, 0.1];

/// From one branch to the next, mm. FIT.
const BRANCHES_EACH_MM: [f64; 2] = [2.2, 1.4];

/// Standard deviation of the curvature of stems, mm⁻¹, and of what chance turns a tip by on a millimeter, rad. FIT.
const CURVES_PER_MM: f64 = 0.012;
const WANDERS_RAD: f64 = 0.05;

/// Share of scattered light that each crystal sends back: half of 1 − g, with a mean cosine of the angle g of 0.8, that of
/// crystals of ice \[Macke1996\].
const BACKWARDS: f64 = 0.1;

/// Of what ice scatters and lets through, the share that goes on forwards. FIT.
const FORWARDS: f64 = 0.6;

/// Way of the front on which frozen dew comes to 1 − 1/e of what it covers in the end, and how thick it is, mm. FIT.
const RIME_OVER_MM: f64 = 30.0;
const RIME_MM: f64 = 0.02;

/// Way of the front, mm, on which nothing visible changes: a fiftieth of a pixel or so.
const STEP_MM: f64 = 0.01;

/// Most nuclei.
const MOST_NUCLEI: f64 = 2e4;

/// Largest side that grows, mm: a larger pane has it again and again, without a seam.
const TILE_MM: f64 = 400.0;

/// Cells of a row that are worked out side by side.
const TOGETHER: usize = 4;

/// A cell that no ice has come to.
const NEVER: f32 = f32::INFINITY;

impl Frost {
    /// Its age so many seconds later, s: by steps while it grows.
    pub(crate) fn later_s(&self, by_s: f64) -> f64 {
        let (step_s, later_s) = (STEP_MM / self.front_mm_s, self.age_s + by_s);
        match later_s < self.melts_from_s && step_s.is_finite() {
            true => self.age_s + (by_s / step_s).floor() * step_s,
            false => later_s,
        }
    }

    pub(crate) fn on_pane(&self, area: &Area, finest_mm: f64, seed: Seed) -> FrostedPane {
        let cell_mm = finest_mm.clamp(0.2, 0.5);
        // A whole number of cells, so that what leaves on one side comes in on the other.
        let sides_mm = area
            .sides_mm()
            .map(|side| ((side.min(TILE_MM) / cell_mm).round().max(4.0) - 1e-6) * cell_mm);
        let tile = Area::rectangle(area.from_mm, [0, 1].map(|k| area.from_mm[k] + sides_mm[k]));
        let mut ice = Ice {
            from_mm: area.from_mm,
            sides_mm,
            cells: Raster::over(&tile, cell_mm, Cell::BARE),
        };
        let grows_s = self.age_s.min(self.melts_from_s);
        let most_mm = self.front_mm_s * grows_s;
        if most_mm > 0.0 {
            Growing::over(self, &tile, seed).run(&mut ice, most_mm);
        }
        let melted_mm = self.melts_mm_s * (self.age_s - grows_s);
        FrostedPane {
            thickness_mm: ice.thickness_mm(most_mm),
            melted_mm,
            heat: self.heated_by.of_lost(melted_mm, area),
            rime: self.rime * (1.0 - libm::exp(-most_mm / RIME_OVER_MM)),
            from_mm: ice.from_mm,
            sides_mm: ice.sides_mm,
        }
    }
}

/// Ice in the cells of a pane.
struct Ice {
    from_mm: [f64; 2],
    sides_mm: [f64; 2],
    cells: Raster<Cell>,
}

/// Ice in a cell.
#[derive(Debug, Clone, Copy)]
struct Cell {
    /// Way of the front when it comes, mm.
    arrives_mm: f32,
    /// How much thicker it is than in the mean.
    ridge: f32,
}

impl Cell {
    const BARE: Self = Self {
        arrives_mm: NEVER,
        ridge: BETWEEN,
    };
}

/// Tips of ice on their way.
struct Growing {
    tips: Vec<Tip>,
    rng: rand_chacha::ChaCha8Rng,
}

/// The tip of a stem or a branch.
#[derive(Debug, Clone, Copy)]
struct Tip {
    at_mm: [f64; 2],
    /// Direction, rad, and how it turns, rad/mm.
    angle: f64,
    curve: f64,
    kind: usize,
    /// Its speed over that of the front.
    speed: f64,
    /// Way of the front when it began, mm.
    from_mm: f64,
    /// Way to its next branch, mm.
    next_mm: f64,
    /// Way that it has not gone yet: tips go by half cells, mm.
    owed_mm: f64,
    is_stopped: bool,
}

impl Growing {
    fn over(frost: &Frost, area: &Area, seed: Seed) -> Self {
        let mut rng = seed.stream(Stream::Frost, 0);
        let sides = area.sides_mm();
        let n = (frost.nuclei_per_mm2 * sides[0] * sides[1]).min(MOST_NUCLEI);
        let mut tips = Vec::new();
        let mut place = 0.0;
        while {
            place -= libm::log(1.0 - uniform(&mut rng));
            place < n
        } {
            let at_mm = [0, 1].map(|k| area.from_mm[k] + sides[k] * uniform(&mut rng));
            let turn = TAU * uniform(&mut rng);
            // Nuclei take hold one after another.
            let from_mm = 6.0 * uniform(&mut rng);
            for k in 0..6 {
                // Not every direction finds water.
                if uniform(&mut rng) < 0.6 {
                    tips.push(Tip {
                        at_mm,
                        angle: turn + FRAC_PI_3 * f64::from(k),
                        curve: CURVES_PER_MM * normal(&mut rng),
                        kind: 0,
                        speed: SPEEDS[0] * (0.6 + 0.4 * uniform(&mut rng)),
                        from_mm,
                        next_mm: BRANCHES_EACH_MM[0],
                        owed_mm: 0.0,
                        is_stopped: false,
                    });
                }
            }
        }
        Self { tips, rng }
    }

    /// Lets all tips grow side by side until the front has gone a way.
    fn run(&mut self, ice: &mut Ice, most_mm: f64) {
        let step_mm = 0.7 * ice.cells.cell_mm;
        let mut way_mm = 0.0;
        while way_mm < most_mm {
            way_mm += step_mm;
            let n_before = self.tips.len();
            for k in 0..n_before {
                if way_mm >= self.tips[k].from_mm {
                    self.grow(k, ice, (way_mm, step_mm));
                }
            }
            self.tips.retain(|tip| !tip.is_stopped);
        }
    }

    fn grow(&mut self, k: usize, ice: &mut Ice, (way_mm, step_mm): (f64, f64)) {
        let tip = &mut self.tips[k];
        tip.owed_mm += step_mm * tip.speed;
        if tip.owed_mm < 0.5 * ice.cells.cell_mm {
            return;
        }
        let step_mm = std::mem::take(&mut tip.owed_mm);
        let (sin, cos) = libm::sincos(tip.angle);
        let is_clear = |ahead_mm: f64| {
            let ahead = [tip.at_mm[0] + ahead_mm * cos, tip.at_mm[1] + ahead_mm * sin];
            let there = ice.cells.cell(ice.inside(ahead));
            there.is_some_and(|cell| ice.cells.values[cell].arrives_mm >= NEVER)
        };
        let ahead_mm = HALF_WIDTHS_MM[tip.kind] + 1.5 * ice.cells.cell_mm;
        let is_young = way_mm - tip.from_mm < 2.0 * ahead_mm / tip.speed;
        if !is_young && !is_clear(ahead_mm) {
            tip.is_stopped = true;
            return;
        }
        tip.at_mm = ice.inside([tip.at_mm[0] + step_mm * cos, tip.at_mm[1] + step_mm * sin]);
        tip.angle += tip.curve * step_mm + WANDERS_RAD * step_mm.sqrt() * normal(&mut self.rng);
        tip.next_mm -= step_mm;
        ice.mark(tip.at_mm, tip.kind, way_mm);
        if tip.next_mm <= 0.0
            && let Some(each_mm) = BRANCHES_EACH_MM.get(tip.kind)
        {
            tip.next_mm += each_mm * libm::exp(0.4 * normal(&mut self.rng));
            let parent = *tip;
            for side in [-FRAC_PI_3, FRAC_PI_3] {
                if uniform(&mut self.rng) < 0.2 {
                    continue;
                }
                let kind = parent.kind + 1;
                let each_mm = BRANCHES_EACH_MM.get(kind).copied();
                self.tips.push(Tip {
                    angle: parent.angle + side + 0.06 * normal(&mut self.rng),
                    kind,
                    speed: parent.speed * SPEEDS[kind] * (0.5 + uniform(&mut self.rng)),
                    from_mm: way_mm,
                    next_mm: each_mm.unwrap_or(f64::INFINITY) * uniform(&mut self.rng),
                    ..parent
                });
            }
        }
    }
}

impl Ice {
    /// The same place of the tile.
    fn inside(&self, at_mm: [f64; 2]) -> [f64; 2] {
        inside(at_mm, self.from_mm, self.sides_mm)
    }

    /// How thick it is when the front has gone a way and ice has closed in between branches, mm.
    fn thickness_mm(&self, front_mm: f64) -> Raster {
        let mut thickness_mm = self.cells.map(|cell| cell.arrives_mm);
        #[expect(clippy::cast_possible_truncation, reason = "lengths")]
        let (front_mm, per_ridge_mm) = (front_mm as f32, THICKNESS_MM as f32);
        close_in(&mut thickness_mm, front_mm);
        for (value, cell) in thickness_mm.values.iter_mut().zip(&self.cells.values) {
            let since_mm = (front_mm - *value).max(0.0);
            *value = cell.ridge * per_ridge_mm * since_mm.sqrt();
        }
        thickness_mm
    }

    /// Ice comes to the cells of a disc, where none is, on both sides of an edge of the tile.
    fn mark(&mut self, at_mm: [f64; 2], kind: usize, way_mm: f64) {
        let radius_mm = HALF_WIDTHS_MM[kind].max(0.5 * self.cells.cell_mm);
        let reach_mm = radius_mm + 0.5 * self.cells.cell_mm;
        let copies = [0, 1].map(|k| {
            let within = at_mm[k] - self.from_mm[k];
            let side = self.sides_mm[k];
            let other = if within < reach_mm {
                Some(at_mm[k] + side)
            } else if within > side - reach_mm {
                Some(at_mm[k] - side)
            } else {
                None
            };
            [Some(at_mm[k]), other]
        });
        for x in copies[0].into_iter().flatten() {
            for y in copies[1].into_iter().flatten() {
                vectorized(
                    #[inline(always)]
                    || self.mark_disc([x, y], (radius_mm, kind), way_mm),
                );
            }
        }
    }

    #[inline(always)]
    fn mark_disc(&mut self, at_mm: [f64; 2], (radius_mm, kind): (f64, usize), way_mm: f64) {
        let cell_mm = self.cells.cell_mm;
        let [columns, rows] = (self.cells).around(at_mm, radius_mm + 0.5 * cell_mm);
        #[expect(clippy::cast_possible_truncation, reason = "a length")]
        let way = way_mm as f32;
        for left in columns.clone().step_by(TOGETHER) {
            let right = (left + TOGETHER).min(columns.end);
            let across: [f64; TOGETHER] = std::array::from_fn(|k| {
                let dx = self.cells.middle_mm(left + k, 0)[0] - at_mm[0];
                dx * dx
            });
            for y in rows.clone() {
                let dy = self.cells.middle_mm(0, y)[1] - at_mm[1];
                let down = dy * dy;
                // As far as the disc covers each.
                let away_mm = across.map(|across| (across + down).sqrt());
                let parts = away_mm.map(|away| ((radius_mm - away) / cell_mm + 0.5).min(1.0));
                let row = &mut self.cells.values[y * self.cells.size[0]..][left..right];
                for ((cell, away_mm), part) in row.iter_mut().zip(away_mm).zip(parts) {
                    if away_mm <= radius_mm {
                        cell.arrives_mm = cell.arrives_mm.min(way);
                    }
                    #[expect(clippy::cast_possible_truncation, reason = "a ratio")]
                    let higher = BETWEEN + (RIDGES[kind] - BETWEEN) * part as f32;
                    // No lower than between branches where it covers nothing.
                    cell.ridge = cell.ridge.max(higher);
                }
            }
        }
    }
}

/// Ice on one pane.
pub(crate) struct FrostedPane {
    /// As it has grown, and what of it has melted in the mean.
    thickness_mm: Raster,
    melted_mm: f64,
    heat: Heat,
    /// Share of the glass between crystals that frozen dew covers.
    rime: f64,
    from_mm: [f64; 2],
    sides_mm: [f64; 2],
}

impl Coating for FrostedPane {
    fn passage(&self, at_mm: [f64; 2]) -> Passage {
        let melted_mm = self.melted_mm * self.heat.times(at_mm);
        let at_mm = inside(at_mm, self.from_mm, self.sides_mm);
        let thickness_mm = self.thickness_mm.at(at_mm);
        if thickness_mm <= 0.0 {
            return frozen_dew(self.rime * (1.0 - melted_mm / RIME_MM).max(0.0));
        }
        let thickness_mm = thickness_mm - melted_mm;
        if thickness_mm <= 0.0 {
            return Passage::CLEAN;
        }
        let depth = SCATTERS_PER_MM * thickness_mm;
        // Two streams, of which nothing is absorbed: ice is white where light is behind it.
        let through = 1.0 / (1.0 + BACKWARDS * depth);
        // Of what is not scattered some meets an even face, as of a thin film; the rest is turned.
        let unscattered = libm::exp(-depth);
        let even = libm::exp(-thickness_mm / EVEN_MM);
        let is_covered = |cell: usize| f64::from(self.thickness_mm.values[cell]) > melted_mm;
        Passage {
            covered: f64::from(u8::from(
                self.thickness_mm.cell(at_mm).is_some_and(is_covered),
            )),
            direct: [unscattered * even; 3],
            wide: unscattered * (1.0 - even) + FORWARDS * (through - unscattered),
            diffuse: [(1.0 - FORWARDS) * (through - unscattered); 3],
            back: [1.0 - through; 3],
            ..Passage::CLEAN
        }
    }

    fn turns_by_rad(&self) -> [f64; 2] {
        [0.0, TURNED_RAD]
    }
}

/// What drops of ice that cover a share of the glass do to light: as those of dew, but what they diffract is too little to
/// be told from what goes straight on.
fn frozen_dew(covered: f64) -> Passage {
    let direct = (1.0 - covered) * (1.0 - covered);
    Passage {
        covered,
        direct: [direct; 3],
        wide: 1.0 - direct,
        ..Passage::CLEAN
    }
}

/// The same place of a tile.
fn inside(at_mm: [f64; 2], from_mm: [f64; 2], sides_mm: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|k| {
        let within = at_mm[k] - from_mm[k];
        // Most places are in the tile itself.
        let sides = match (0.0..0.999 * sides_mm[k]).contains(&within) {
            true => 0.0,
            false => (within / sides_mm[k]).floor(),
        };
        from_mm[k] + (within - sides * sides_mm[k])
    })
}
