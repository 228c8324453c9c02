//! The image processor: stages that are left out, and rows whose colors are not interpolated.

use rand_chacha::rand_core::Rng as _;
use starbreak_seed::{Seed, Stream};

use crate::Light;
use crate::draw::single;
use crate::mosaic::{WHITE_BALANCE, color_at};

/// From the camera's colors to those of sRGB: what a processor multiplies by. FIT, such as of common cameras; rows sum
/// to 1, so that gray stays gray.
const COLOR_MATRIX: [[f64; 3]; 3] = [[1.7, -0.5, -0.2], [-0.25, 1.55, -0.3], [0.0, -0.6, 1.6]];

/// Rows whose colors are not interpolated: each pixel shows what it saw itself, M⁻¹C at its own color, after the white
/// balance and before the color matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RawRows {
    /// Share of the rows, 0 to 1. They follow each other, from a random row on.
    pub share: f64,
    /// Whether a pixel keeps its color, and lacks the others; gray otherwise.
    pub is_colored: bool,
}

impl RawRows {
    /// Whether all rows have their colors.
    #[must_use]
    pub fn is_nothing(&self) -> bool {
        self.share == 0.0
    }

    /// Whether each row is raw; the same in all frames of a clip.
    #[must_use]
    pub fn of_clip(&self, n_rows: usize, clip: Seed) -> Vec<bool> {
        #[expect(
            clippy::cast_precision_loss,
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "rows of a frame"
        )]
        let n_raw = (self.share * n_rows as f64).round() as usize;
        let mut rng = clip.stream(Stream::SensorRawRows, 0);
        let first = usize::try_from(rng.next_u64() % n_rows.max(1) as u64).unwrap_or(0);
        (0..n_rows)
            .map(|y| (y + n_rows - first) % n_rows < n_raw)
            .collect()
    }
}

/// Stages of the image processor that are left out, each by a share: 0 is a processor that works, 1 one without the
/// stage. A photograph has been through all of them, so that leaving one out takes back what it did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Isp {
    /// Light that the black level should have taken away, 1 is white.
    pub black_level: f64,
    /// Of the white balance.
    pub white_balance: f64,
    /// Of the color matrix.
    pub color_matrix: f64,
    /// Amount a of the sharpening that is taken back: 1/(1 + a(1 − Ĝ)), with Ĝ that of 1 2 1 in x and in y.
    pub unsharp: f64,
    /// Of the tone curve: codes become those of linear light.
    pub tone: f64,
}

impl Isp {
    /// A processor that works.
    pub(crate) const WORKS: Self = Self {
        black_level: 0.0,
        white_balance: 0.0,
        color_matrix: 0.0,
        unsharp: 0.0,
        tone: 0.0,
    };

    /// Whether no stage is left out.
    #[must_use]
    pub fn is_nothing(&self) -> bool {
        self.acts_on_no_light() && self.tone == 0.0
    }

    /// Whether only the tone curve is left out, or nothing.
    pub(crate) fn acts_on_no_light(&self) -> bool {
        self.keeps_colors() && self.unsharp == 0.0
    }

    /// Whether black level, white balance and color matrix work.
    fn keeps_colors(&self) -> bool {
        self.black_level == 0.0 && self.white_balance == 0.0 && self.color_matrix == 0.0
    }

    /// Of a frame of light, without the tone curve; some rows may be raw.
    ///
    /// With G the gains, M the matrix, and G′ and M′ what is left of them: M′(G′(G⁻¹M⁻¹C + b)). What is white stays white:
    /// it was too bright for all filters.
    pub(crate) fn over(&self, light: &mut Light, raw: Option<(&RawRows, Seed)>) {
        if light.n_colors() == 1 {
            let more = single(self.black_level);
            if more != 0.0 {
                light.values_mut().iter_mut().for_each(|it| *it += more);
            }
        } else if raw.is_some() || !self.keeps_colors() {
            self.change_colors(light, raw);
        }
        if self.unsharp > 0.0 {
            take_back_sharpening(light, self.unsharp);
        }
    }

    /// Black level, white balance, raw rows and color matrix.
    fn change_colors(&self, light: &mut Light, raw: Option<(&RawRows, Seed)>) {
        let (black, share) = (single(self.black_level), single(self.white_balance));
        let gains = WHITE_BALANCE.map(|gain| (1.0 - share) * gain + share);
        let keeps_colors = self.keeps_colors();
        let undone = inverse(COLOR_MATRIX);
        // M′ = (1 − s) M + s.
        let left: [[f32; 3]; 3] = std::array::from_fn(|r| {
            std::array::from_fn(|c| {
                let identity = f64::from(u8::from(r == c));
                single(COLOR_MATRIX[r][c] + self.color_matrix * (identity - COLOR_MATRIX[r][c]))
            })
        });
        let is_raw = raw.map(|(rows, clip)| rows.of_clip(light.size().1, clip));
        for (y, row) in light.rows_mut() {
            let is_raw = is_raw.as_ref().is_some_and(|rows| rows[y]);
            if !is_raw && keeps_colors {
                continue;
            }
            for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
                // Where all colors are white it was too bright for all filters, whatever the processor does.
                if pixel.iter().all(|color| *color >= 1.0) {
                    continue;
                }
                let camera = times(&undone, [pixel[0], pixel[1], pixel[2]]);
                let balanced: [f32; 3] =
                    std::array::from_fn(|c| (camera[c] / WHITE_BALANCE[c] + black) * gains[c]);
                let colors = match raw {
                    Some((rows, _)) if is_raw => {
                        let own = color_at(x, y);
                        let others = if rows.is_colored { 0.0 } else { balanced[own] };
                        std::array::from_fn(|c| if c == own { balanced[own] } else { others })
                    }
                    _ => times(&left, balanced),
                };
                pixel.copy_from_slice(&colors);
            }
        }
    }

    /// The code without a share of the tone curve, both in units of the greatest: `light` is that of the code.
    #[must_use]
    pub fn code_without_tone(&self, code: f64, light: f64) -> f64 {
        code + self.tone * (light - code)
    }
}

/// A matrix of colors times a color.
#[inline]
fn times(matrix: &[[f32; 3]; 3], [r, g, b]: [f32; 3]) -> [f32; 3] {
    matrix.map(|row| row[0] * r + row[1] * g + row[2] * b)
}

/// The inverse of a matrix of colors, by its cofactors.
fn inverse(m: [[f64; 3]; 3]) -> [[f32; 3]; 3] {
    let minor = |r: usize, c: usize| {
        let [r1, r2, c1, c2] = [(r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3];
        m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]
    };
    let determinant: f64 = (0..3).map(|c| m[0][c] * minor(0, c)).sum();
    std::array::from_fn(|r| std::array::from_fn(|c| single(minor(c, r) / determinant)))
}

/// Solves (1 + a(1 − G)) x = light by Chebyshev's iteration \[Saad2003, algorithm 12.1\]: the eigenvalues lie between 1
/// and 1 + a.
fn take_back_sharpening(light: &mut Light, amount: f64) {
    let (middle, half) = (1.0 + 0.5 * amount, 0.5 * amount);
    let ratio = middle / half;
    let shrinks = 1.0 / (ratio + (ratio * ratio - 1.0).sqrt());
    // Until a millionth is missing.
    let mut left = 1.0;
    let mut rho = 1.0 / ratio;
    let wanted = light.values().to_vec();
    let a = single(amount);
    let mut step = vec![0.0_f32; wanted.len()];
    let (mut gain, mut momentum) = (single(1.0 / middle), 0.0);
    while left > 1e-6 {
        let smooth = smoothed(light);
        let values = light.values_mut().iter_mut().zip(&mut step);
        for ((value, step), (wanted, smooth)) in values.zip(wanted.iter().zip(&smooth)) {
            let missing = wanted - (*value + a * (*value - smooth));
            *step = gain * missing + momentum * *step;
        }
        for (value, step) in light.values_mut().iter_mut().zip(&step) {
            *value += step;
        }
        let next = 1.0 / (2.0 * ratio - rho);
        gain = single(2.0 * next / half);
        momentum = single(next * rho);
        rho = next;
        left *= shrinks;
    }
}

/// A frame under 1 2 1 in x and in y, mirrored at the border.
fn smoothed(light: &Light) -> Vec<f32> {
    let (width, height) = light.size();
    let n_colors = light.n_colors();
    let stride = width * n_colors;
    let values = light.values();
    let mut rows = vec![0.0_f32; stride];
    let mut out = Vec::with_capacity(values.len());
    for y in 0..height {
        let row = |y: usize| &values[y * stride..(y + 1) * stride];
        let above = row(if y > 0 { y - 1 } else { 1.min(height - 1) });
        let below = row(if y + 1 < height {
            y + 1
        } else {
            height.saturating_sub(2)
        });
        for (sum, ((a, b), c)) in rows.iter_mut().zip(above.iter().zip(row(y)).zip(below)) {
            *sum = 0.0625 * (a + 2.0 * b + c);
        }
        // Mirrored at both ends, in one piece between.
        let ends = |x: usize, beside: usize| {
            (0..n_colors).map(move |c| (x * n_colors + c, beside * n_colors + c))
        };
        out.extend(ends(0, 1.min(width - 1)).map(|(at, beside)| 2.0 * (rows[at] + rows[beside])));
        let inner = rows
            .iter()
            .zip(rows.iter().skip(n_colors))
            .zip(rows.iter().skip(2 * n_colors));
        out.extend(inner.map(|((left, here), right)| left + 2.0 * here + right));
        if width > 1 {
            let last = ends(width - 1, width - 2);
            out.extend(last.map(|(at, beside)| 2.0 * (rows[at] + rows[beside])));
        }
    }
    out
}
