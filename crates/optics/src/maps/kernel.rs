//! The image of the pupil: how a point out of focus is spread over cells.

use std::f64::consts::{PI, TAU};

use crate::lens::Lens;

/// Lines per cell along which a kernel is integrated: Gauss-Legendre abscissae and weights on
/// [0, 1], \[AbramowitzStegun1964\] table 25.4.
const LINES: [(f64, f64); 6] = [
    (0.033_765_242_898_424, 0.085_662_246_189_585),
    (0.169_395_306_766_868, 0.180_380_786_524_069),
    (0.380_690_406_958_402, 0.233_956_967_286_346),
    (0.619_309_593_041_598, 0.233_956_967_286_346),
    (0.830_604_693_233_132, 0.180_380_786_524_069),
    (0.966_234_757_101_576, 0.085_662_246_189_585),
];

/// Shape of the pupil.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Pupil {
    /// A disc.
    Round,
    /// A regular polygon of the disc's area, with the direction of a corner.
    Polygon {
        /// Number of corners.
        n: u32,
        /// Direction of the first corner, rad.
        angle_rad: f64,
    },
}

impl Pupil {
    /// The pupil of a lens.
    pub(crate) fn of(lens: &Lens) -> Self {
        match lens.blades {
            0 => Self::Round,
            n => Self::Polygon {
                n,
                angle_rad: lens.blade_angle_rad,
            },
        }
    }

    /// Farthest from its middle, of the radius of a disc of its area.
    pub(crate) fn reach(self) -> f64 {
        let away = self.corners().into_iter().map(|[x, y]| libm::hypot(x, y));
        away.fold(1.0, f64::max)
    }

    /// Corners of the polygon for a disc of radius 1.
    pub(crate) fn corners(self) -> Vec<[f64; 2]> {
        match self {
            Self::Round => Vec::new(),
            Self::Polygon { n, angle_rad } => {
                let step = TAU / f64::from(n);
                // Area n/2 ρ² sin(2π/n) = π.
                let rho = (2.0 * PI / (f64::from(n) * libm::sin(step))).sqrt();
                (0..n)
                    .map(|k| {
                        let (sin, cos) = libm::sincos(angle_rad + step * f64::from(k));
                        [rho * cos, rho * sin]
                    })
                    .collect()
            }
        }
    }
}

/// A row in which a chord's half grows by more cells is made of two stretches.
const SWEEP: f64 = 0.3;

/// What a cell of unit value becomes: for each row the *steps* from one cell to the next, so
/// that a running sum along the row restores the kernel. It sums to 1.
///
/// Each row is one stretch of even light, or two, with the mass, the middle and the second moment
/// of the pupil's part of that row, so that two steps at either end make it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Kernel {
    stretches: Vec<Stretch>,
    reach: i32,
}

/// Even light along a row of a kernel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stretch {
    /// Offset of the row.
    pub(crate) dy: i32,
    /// Its two ends.
    pub(crate) ends: [End; 2],
}

/// One end of a stretch: offset of the first of two cells, and the steps to them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct End {
    pub(crate) dx: i32,
    pub(crate) steps: [f32; 2],
}

impl Kernel {
    /// The image of a pupil of signed radius `radius`, in cells, each cell holding its share; a
    /// negative radius turns the pupil over.
    pub(crate) fn new(pupil: Pupil, radius: f64) -> Self {
        let corners: Vec<[f64; 2]> = pupil
            .corners()
            .iter()
            .map(|corner| corner.map(|coordinate| coordinate * radius))
            .collect();
        let size = if corners.is_empty() {
            radius.abs()
        } else {
            corners
                .iter()
                .map(|[x, y]| (x * x + y * y).sqrt())
                .fold(0.0, f64::max)
        };
        let chord = |y: f64| -> Option<[f64; 2]> {
            if corners.is_empty() {
                let square = radius * radius - y * y;
                return (square > 0.0).then(|| [-square.sqrt(), square.sqrt()]);
            }
            polygon_chord(&corners, y)
        };
        #[expect(clippy::cast_possible_truncation, reason = "radii of some cells")]
        let reach = (size + 0.5).ceil() as i32;
        let mut parts: Vec<(i32, Part)> = Vec::new();
        for dy in -reach..=reach {
            let (top, bottom) = (
                (f64::from(dy) - 0.5).max(-size),
                (f64::from(dy) + 0.5).min(size),
            );
            if top >= bottom {
                continue;
            }
            let lines = lines(&corners, size, [top, bottom]);
            let (upper, lower) = lines.split_at(lines.len() / 2);
            let moments = [upper, lower].map(|lines| moments(lines, chord));
            let whole = std::array::from_fn(|k| moments[0][k] + moments[1][k]);
            match moments.map(Part::of) {
                [Some(upper), Some(lower)] if (upper.half - lower.half).abs() > SWEEP => {
                    parts.extend([(dy, upper), (dy, lower)]);
                }
                _ => parts.extend(Part::of(whole).map(|part| (dy, part))),
            }
        }
        let total: f64 = parts.iter().map(|(_, part)| part.mass).sum();
        let stretches = if total > 0.0 {
            let stretch = |(dy, Part { mass, middle, half })| {
                let height = mass / (2.0 * half * total);
                let ends = [
                    End::at(middle - half, height),
                    End::at(middle + half, -height),
                ];
                Stretch { dy, ends }
            };
            parts.into_iter().map(stretch).collect()
        } else {
            // A point: all in one cell.
            vec![Stretch {
                dy: 0,
                ends: [End::at(-0.5, 1.0), End::at(0.5, -1.0)],
            }]
        };
        Self { stretches, reach }
    }

    /// Rows and columns beyond the middle that the steps reach at most.
    pub(crate) fn reach(&self) -> usize {
        self.reach.unsigned_abs() as usize + 1
    }

    /// Its stretches, row by row.
    pub(crate) fn stretches(&self) -> &[Stretch] {
        &self.stretches
    }
}

/// What a stretch is made from: its mass, its middle, and half its length.
struct Part {
    mass: f64,
    middle: f64,
    half: f64,
}

/// Mass of some lines and its first two moments along the row.
fn moments(lines: &[(f64, f64)], chord: impl Fn(f64) -> Option<[f64; 2]>) -> [f64; 3] {
    let mut moments = [0.0; 3];
    for &(y, weight) in lines {
        if let Some([left, right]) = chord(y) {
            moments[0] += weight * (right - left);
            moments[1] += weight * (right * right - left * left) / 2.0;
            moments[2] += weight * (right * right * right - left * left * left) / 3.0;
        }
    }
    moments
}

impl Part {
    /// The stretch of three moments.
    fn of(moments: [f64; 3]) -> Option<Self> {
        let [mass, first, second] = moments;
        let middle = first / mass;
        (mass > 0.0).then(|| Self {
            mass,
            middle,
            half: (3.0 * (second / mass - middle * middle)).max(1e-12).sqrt(),
        })
    }
}

impl End {
    /// The steps of coverage right of a place, in cells from the middle of cell 0.
    fn at(place: f64, height: f64) -> Self {
        let place = place + 0.5;
        let cell = place.floor();
        let within = place - cell;
        #[expect(
            clippy::cast_possible_truncation,
            reason = "cells within the reach; weights as f32"
        )]
        Self {
            dx: cell as i32,
            steps: [height * (1.0 - within), height * within].map(|step| step as f32),
        }
    }
}

/// Lines through a part of a pupil, by which it is integrated exactly (a polygon) or nearly so (a
/// disc): their places and weights.
fn lines(corners: &[[f64; 2]], size: f64, [top, bottom]: [f64; 2]) -> Vec<(f64, f64)> {
    if corners.is_empty() {
        // Over the angle, in which the chord of a disc is smooth up to its ends.
        let (from, to) = (libm::asin(top / size), libm::asin(bottom / size));
        let line = |(at, weight): (f64, f64)| {
            let (sin, cos) = libm::sincos(from + at * (to - from));
            (size * sin, weight * (to - from) * size * cos)
        };
        return LINES.into_iter().map(line).collect();
    }
    // From corner to corner, between which chords are straight.
    let mut stops: Vec<f64> = corners.iter().map(|corner| corner[1]).collect();
    stops.retain(|y| (top..bottom).contains(y));
    stops.extend([top, bottom]);
    stops.sort_by(f64::total_cmp);
    let parts = stops.windows(2).flat_map(|part| {
        let height = part[1] - part[0];
        LINES.map(|(at, weight)| (part[0] + at * height, weight * height))
    });
    parts.filter(|(_, weight)| *weight > 0.0).collect()
}

/// Where a horizontal line crosses a convex polygon.
fn polygon_chord(corners: &[[f64; 2]], y: f64) -> Option<[f64; 2]> {
    let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
    for (k, &[x0, y0]) in corners.iter().enumerate() {
        let [x1, y1] = corners[(k + 1) % corners.len()];
        if (y0 - y) * (y1 - y) <= 0.0 && (y1 - y0).abs() > 0.0 {
            let x = x0 + (y - y0) / (y1 - y0) * (x1 - x0);
            left = left.min(x);
            right = right.max(x);
        }
    }
    (right > left).then_some([left, right])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The kernel as a dense square of side 2·reach + 1.
    fn dense(kernel: &Kernel) -> (i32, Vec<f64>) {
        let reach = kernel.reach + 1;
        let side = (2 * reach + 1).cast_unsigned() as usize;
        let mut cells = vec![0.0; side * side];
        let ends = |stretch: &Stretch| stretch.ends.map(|end| (stretch.dy, end));
        for (dy, end) in kernel.stretches().iter().flat_map(ends) {
            let row = (dy + reach).cast_unsigned() as usize * side;
            for (at, step) in (end.dx..).zip(end.steps) {
                // A running sum: each step raises all cells after it.
                for column in at..=reach {
                    cells[row + (column + reach).cast_unsigned() as usize] += f64::from(step);
                }
            }
        }
        for (row, cells) in cells.chunks(side).enumerate() {
            let last = cells[side - 1];
            assert!(last.abs() < 1e-6, "row {row} does not close: {last}");
        }
        (reach, cells)
    }

    #[test]
    fn kernels_sum_to_one_and_have_the_variance_of_the_pupil() {
        for pupil in [
            Pupil::Round,
            Pupil::Polygon {
                n: 5,
                angle_rad: 0.3,
            },
            Pupil::Polygon {
                n: 6,
                angle_rad: 0.0,
            },
            Pupil::Polygon {
                n: 3,
                angle_rad: 1.0,
            },
        ] {
            for radius in [0.0, 0.1, 0.5, 1.0, 2.3, 5.0, 9.7, -4.2, 33.3] {
                let (reach, cells) = dense(&Kernel::new(pupil, radius));
                let side = 2 * reach + 1;
                let (mut sum, mut x_sum, mut square) = (0.0, 0.0, 0.0);
                for (k, cell) in (0..).zip(&cells) {
                    let (dx, dy) = (f64::from(k % side - reach), f64::from(k / side - reach));
                    sum += cell;
                    x_sum += cell * dx;
                    square += cell * (dx * dx + dy * dy);
                    assert!(
                        *cell > -1e-7,
                        "no negative weight at radius {radius}: {cell}"
                    );
                }
                assert!((sum - 1.0).abs() < 1e-6, "{pupil:?}, {radius}: sum {sum}");
                // ⟨x² + y²⟩ = ρ²/2 of a disc; of a polygon n: ρ²/6 (2 + cos 2π/n); and 1/12 per axis
                // for the cells.
                let expected = 1.0 / 6.0
                    + match pupil {
                        Pupil::Round => radius * radius / 2.0,
                        Pupil::Polygon { n, .. } => {
                            let step = TAU / f64::from(n);
                            let rho2 = 2.0 * PI / (f64::from(n) * step.sin());
                            radius * radius * rho2 / 6.0 * (2.0 + step.cos())
                        }
                    };
                if radius.abs() >= 2.0 {
                    assert!(
                        x_sum.abs() < 0.02,
                        "{pupil:?}, {radius}: off centre by {x_sum}"
                    );
                    assert!(
                        (square / expected - 1.0).abs() < 0.015,
                        "{pupil:?}, {radius}: second moment {square}, not {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_negative_radius_turns_the_pupil_over() {
        let pupil = Pupil::Polygon {
            n: 3,
            angle_rad: 0.0,
        };
        let (_, cells) = dense(&Kernel::new(pupil, 6.0));
        let (_, mut turned) = dense(&Kernel::new(pupil, -6.0));
        assert!(
            cells.iter().zip(&turned).any(|(a, b)| (a - b).abs() > 1e-3),
            "a triangle is not its own mirror image"
        );
        turned.reverse();
        for (a, b) in cells.iter().zip(&turned) {
            assert!((a - b).abs() < 1e-6, "{a} against {b}");
        }
    }
}
