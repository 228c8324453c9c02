//! The film of air in an open crack, between two parallel faces of glass.
//!
//! Below the critical angle it shows interference colors, above it the crack is a mirror as soon
//! as it is open by a few hundred nm. Both are one formula.

use std::f64::consts::PI;

/// Share of unpolarized light of one wavelength that glass | air | glass reflects, 0 to 1.
///
/// `cos_in_glass` is the cosine of incidence in the glass, `n` its index. With cos θ_t in the
/// air, β = 2π d cos θ_t/λ and r the amplitude of one face, the reflected amplitude is
/// r (1 − e^{2iβ})/(1 − r² e^{2iβ}) \[BornWolf1999, 7.6\]; above the critical angle cos θ_t is
/// imaginary. Reflected over transmitted power is then real on both sides of that angle:
///
/// R/T = (sin β/cos θ_t)² (A² − B²)²/(4 A² g), with A = n cos θ_i, B = cos θ_t, g = 1 for light
/// polarized across the plane of incidence, and A = cos θ_i, B = n cos θ_t, g = n² for light in
/// it; sin β/cos θ_t is sinh(2π d κ/λ)/κ where cos θ_t = iκ.
///
/// # Example
/// ```
/// use starbreak_optics::interface::gap::gap_reflectance;
/// // Frustrated total reflection: at 50° half of green light crosses 120 nm of air.
/// let cos = 50_f64.to_radians().cos();
/// assert!((gap_reflectance(cos, 120e-9, 550e-9, 1.52) - 0.5).abs() < 0.005);
/// ```
#[must_use]
pub fn gap_reflectance(cos_in_glass: f64, gap_m: f64, wavelength_m: f64, n: f64) -> f64 {
    if gap_m <= 0.0 {
        return 0.0;
    }
    Incidence::new(cos_in_glass, n).reflectance(2.0 * PI * gap_m / wavelength_m)
}

/// What of the formula does not depend on gap and wavelength.
struct Incidence {
    /// cos² θ_t in the air; negative above the critical angle.
    cos2_air: f64,
    /// (A² − B²)²/(4 A² g) of either polarization.
    factors: [f64; 2],
}

impl Incidence {
    fn new(cos_in_glass: f64, n: f64) -> Self {
        let (cos, n2) = (clamped(cos_in_glass), n * n);
        let cos2_air = cos2_air(cos_in_glass, n);
        let factor = |a2: f64, b2: f64, g: f64| (a2 - b2) * (a2 - b2) / (4.0 * a2 * g);
        Self {
            cos2_air,
            factors: [
                factor(n2 * cos * cos, cos2_air, 1.0),
                factor(cos * cos, n2 * cos2_air, n2),
            ],
        }
    }

    /// Reflectance for a gap of `phase` = 2π d/λ rad.
    fn reflectance(&self, phase: f64) -> f64 {
        let c = self.cos2_air.abs().sqrt();
        let s = if c * phase < 1e-6 {
            phase
        } else if self.cos2_air > 0.0 {
            libm::sin(c * phase) / c
        } else {
            // Beyond 40 the film lets less than 10⁻³⁰ through.
            sinh((c * phase).min(40.0)) / c
        };
        self.reflectance_of(s)
    }

    /// Reflectance where sin β/cos θ_t is `s`: half of a/(1 + a) + b/(1 + b), of the two polarizations.
    fn reflectance_of(&self, s: f64) -> f64 {
        let [a, b] = self.factors.map(|f| f * s * s);
        let product = a * b;
        (0.5 * (a + b) + product) / (1.0 + a + b + product)
    }
}

fn clamped(cos_in_glass: f64) -> f64 {
    cos_in_glass.abs().clamp(1e-9, 1.0)
}

/// cos² θ_t in the air; negative above the critical angle.
fn cos2_air(cos_in_glass: f64, n: f64) -> f64 {
    let cos = clamped(cos_in_glass);
    1.0 - n * n * (1.0 - cos * cos)
}

/// sinh x of x from 0 to 40; relative error below 10⁻¹⁰.
fn sinh(x: f64) -> f64 {
    if x < 0.1 {
        let x2 = x * x;
        return x * (1.0 + x2 / 6.0 * (1.0 + x2 / 20.0 * (1.0 + x2 / 42.0)));
    }
    let exp = libm::exp(x);
    0.5 * (exp - 1.0 / exp)
}

/// Wavelengths of the bands: 380 to 780 nm by 2 nm.
const FIRST_NM: f64 = 380.0;
const STEP_NM: f64 = 2.0;
const N_WAVELENGTHS: usize = 201;
/// Wave numbers of the average where the film has no resonance: from that of the longest wavelength, `FIRST_COARSE`
/// steps above 0, to twice that, in equal steps.
const N_COARSE: usize = 6;
const FIRST_COARSE: i32 = 5;
/// Path through the film, µm, from which on its two faces no longer interfere.
const COHERENCE_UM: f64 = 8.0;
/// Steps of [`Bands::coherence`] per µm.
const STEPS_PER_UM: f64 = 96.0;
/// `COHERENCE_UM * STEPS_PER_UM`, and one more on each side for the interpolation.
const N_STEPS: usize = 768 + 3;
/// Path in units of λ/2π from which on the film may resonate at some wavelength.
const RESONANCE_PHASE: f64 = 1.5;
/// Wavelength of that phase, µm.
const MIDDLE_UM: f64 = 0.55;

/// Reflectance of an air gap in glass, averaged over the three bands of linear sRGB.
///
/// The bands are the CIE 1931 color matching functions in the fit of \[Wyman2013\], by the matrix
/// of IEC 61966-2-1, each scaled to a mean of 1 for light of equal energy. They have negative
/// lobes: where a color of the film lies outside sRGB, its share is clipped to 0 (by 0.055 at
/// most, in red), as in any image of it.
///
/// A path of 8 µm or more through the film shows no fringes: what remains is 2R/(1 + R). Short of
/// that the Airy series T = (1 − R)/(1 + R) (1 + 2 Σ R^m ⟨cos 2mβ⟩) is summed per polarization
/// over the tabulated ⟨cos 2kx⟩ of each band, which is exact for the sharpest resonance, too
/// (the pre-integration of \[BelcourBarla2017\]); below the first resonance, and above the critical
/// angle, cubics through 6 wave numbers are averaged. Error against 1600 wavelengths: below 10⁻³
/// everywhere, below 5·10⁻⁴ outside 1° of the critical angle (tested).
///
/// Built in about 1 ms; a look-up takes below 1 µs.
#[derive(Debug, Clone)]
pub struct GapTable {
    n: f64,
    colors: Bands<3>,
    mean: Bands<1>,
}

impl GapTable {
    /// The table for glass of index `n`, above 1.
    #[must_use]
    pub fn new(n: f64) -> Self {
        let bands = bands();
        let means: Vec<[f64; 1]> = bands.iter().map(|[r, g, b]| [(r + g + b) / 3.0]).collect();
        Self {
            n,
            colors: Bands::of(&bands),
            mean: Bands::of(&means),
        }
    }

    /// Reflectance of a gap in red, green and blue, each 0 to 1.
    ///
    /// `cos_in_glass` is the cosine of incidence in the glass.
    #[must_use]
    pub fn rgb(&self, cos_in_glass: f64, gap_um: f64) -> [f64; 3] {
        self.colors.reflectance(self.n, cos_in_glass, gap_um)
    }

    /// The mean of the three colors, before any is clipped, 0 to 1.
    #[must_use]
    pub fn mean(&self, cos_in_glass: f64, gap_um: f64) -> f64 {
        let [mean] = self.mean.reflectance(self.n, cos_in_glass, gap_um);
        mean
    }
}

/// What is known of some bands of light.
#[derive(Debug, Clone)]
struct Bands<const N: usize> {
    /// ⟨cos 2kx⟩ of each band at x = (i − 1)/[`STEPS_PER_UM`] µm.
    coherence: Vec<[f64; N]>,
    /// Weights of the bands at the wave numbers of the average.
    coarse: [[f64; N]; N_COARSE],
}

impl<const N: usize> Bands<N> {
    /// Of the weights of the bands at each wavelength.
    fn of(bands: &[[f64; N]]) -> Self {
        let mut coherence = vec![[0.0; N]; N_STEPS];
        let mut coarse = [[0.0; N]; N_COARSE];
        let coarse_step = coarse_step();
        for (i, weights) in bands.iter().enumerate() {
            // cos 2kx at the steps x, by turning a unit vector.
            let step = 2.0 * wave_number(i) / STEPS_PER_UM;
            let (sin, cos) = libm::sincos(step);
            let (mut x, mut y) = (cos, -sin);
            for entry in &mut coherence {
                for (sum, weight) in entry.iter_mut().zip(weights) {
                    *sum += weight * x;
                }
                (x, y) = (x * cos - y * sin, x * sin + y * cos);
            }
            // Shared out among four neighbors of the coarse row.
            let at = wave_number(i) / coarse_step - f64::from(FIRST_COARSE);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "0 to N_COARSE"
            )]
            let first = (at as usize).clamp(1, N_COARSE - 3) - 1;
            #[expect(clippy::cast_precision_loss, reason = "a small count")]
            let shares = cubic(at - (first + 1) as f64);
            for (sums, share) in coarse[first..].iter_mut().zip(shares) {
                for (sum, weight) in sums.iter_mut().zip(weights) {
                    *sum += share * weight;
                }
            }
        }
        Self { coherence, coarse }
    }

    /// Reflectance of a gap in each band, 0 to 1, in glass of index `n`.
    fn reflectance(&self, n: f64, cos_in_glass: f64, gap_um: f64) -> [f64; N] {
        if gap_um <= 0.0 {
            return [0.0; N];
        }
        let cos2_air = cos2_air(cos_in_glass, n);
        let cos_air = cos2_air.abs().sqrt();
        let path_um = gap_um * cos_air;
        let phase = 2.0 * PI / MIDDLE_UM * path_um;
        let bands = if cos2_air <= 0.0 && phase > 8.0 {
            // e^(−2·8·0.7) of the longest wavelength, 1.4·10⁻⁵: nothing crosses that is seen.
            return [1.0; N];
        } else if cos2_air <= 0.0 || phase < RESONANCE_PHASE {
            self.smooth(&Incidence::new(cos_in_glass, n), gap_um)
        } else {
            self.airy((cos_in_glass.abs(), n), cos_air, path_um)
        };
        bands.map(|r| r.clamp(0.0, 1.0))
    }

    /// The average over wave numbers in equal steps from a whole number of them on, whose sines follow from that of one
    /// step.
    fn smooth(&self, incidence: &Incidence, gap_um: f64) -> [f64; N] {
        let step = coarse_step() * gap_um;
        let c = incidence.cos2_air.abs().sqrt();
        let mut sum = [0.0; N];
        let mut add = |s: f64, weights: &[f64; N]| {
            let r = incidence.reflectance_of(s);
            for (sum, weight) in sum.iter_mut().zip(weights) {
                *sum += weight * r;
            }
        };
        if c * step < 1e-6 {
            let mut phase = f64::from(FIRST_COARSE) * step;
            for weights in &self.coarse {
                add(phase, weights);
                phase += step;
            }
        } else if incidence.cos2_air > 0.0 {
            let (turn_sin, turn_cos) = libm::sincos(c * step);
            let turned = |(sin, cos): (f64, f64)| {
                (
                    sin * turn_cos + cos * turn_sin,
                    cos * turn_cos - sin * turn_sin,
                )
            };
            let mut turn = (0..FIRST_COARSE).fold((0.0, 1.0), |turn, _| turned(turn));
            for weights in &self.coarse {
                add(turn.0 / c, weights);
                turn = turned(turn);
            }
        } else {
            let growth = libm::exp(c * step);
            let fading = 1.0 / growth;
            let mut ends = (0..FIRST_COARSE).fold([1.0, 1.0], |[grows, fades], _| {
                [grows * growth, fades * fading]
            });
            for weights in &self.coarse {
                let [grows, fades] = ends;
                add(0.5 * (grows - fades) / c, weights);
                ends = [grows * growth, fades * fading];
            }
        }
        sum
    }

    /// The Airy series below the critical angle.
    fn airy(&self, (cos_glass, n): (f64, f64), cos_air: f64, path_um: f64) -> [f64; N] {
        let amplitude = |a: f64, b: f64| (a - b) / (a + b);
        let s = amplitude(n * cos_glass, cos_air);
        let p = amplitude(cos_glass, n * cos_air);
        let one_face = [s * s, p * p];
        let mut powers = [1.0_f64; 2];
        let mut series = [[1.0; N]; 2];
        let mut path = path_um;
        while path < COHERENCE_UM && powers[0].max(powers[1]) > 3e-4 {
            let coherence = self.coherence_at(path);
            for ((power, r), series) in powers.iter_mut().zip(one_face).zip(&mut series) {
                *power *= r;
                for (sum, cos) in series.iter_mut().zip(coherence) {
                    *sum += 2.0 * *power * cos;
                }
            }
            path += path_um;
        }
        let [across, within] = one_face.map(|r| (1.0 - r) / (1.0 + r));
        std::array::from_fn(|c| 1.0 - 0.5 * (across * series[0][c] + within * series[1][c]))
    }

    /// ⟨cos 2kx⟩ of each band, between four steps.
    fn coherence_at(&self, path_um: f64) -> [f64; N] {
        let at = path_um * STEPS_PER_UM;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0 to 768: the caller stays below COHERENCE_UM"
        )]
        let first = at as usize;
        let t = at - at.floor();
        let Some(four) = self.coherence.get(first..first + 4) else {
            return [0.0; N];
        };
        let weights = cubic(t);
        std::array::from_fn(|c| four.iter().zip(weights).map(|(d, w)| w * d[c]).sum())
    }
}

/// Weights of the values at −1, 0, 1 and 2 of the cubic through them at `t`.
fn cubic(t: f64) -> [f64; 4] {
    [
        -t * (t - 1.0) * (t - 2.0) / 6.0,
        (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
        -(t + 1.0) * t * (t - 2.0) / 2.0,
        (t + 1.0) * t * (t - 1.0) / 6.0,
    ]
}

fn wavelength_nm(i: usize) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "at most 200")]
    let i = i as f64;
    FIRST_NM + STEP_NM * i
}

/// 2π/λ, rad/µm.
fn wave_number(i: usize) -> f64 {
    2.0 * PI / (1e-3 * wavelength_nm(i))
}

/// From one wave number of the average to the next, rad/µm.
fn coarse_step() -> f64 {
    wave_number(N_WAVELENGTHS - 1) / f64::from(FIRST_COARSE)
}

/// Weights of the bands of linear sRGB at each wavelength; each band sums to 1.
fn bands() -> Vec<[f64; 3]> {
    let mut sums = [0.0; 3];
    let mut weights = Vec::with_capacity(N_WAVELENGTHS);
    for i in 0..N_WAVELENGTHS {
        let [x, y, z] = color_matching(wavelength_nm(i));
        let rgb = [
            3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
            -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
            0.0556434 * x - 0.2040259 * y + 1.0572252 * z,
        ];
        for (sum, weight) in sums.iter_mut().zip(rgb) {
            *sum += weight;
        }
        weights.push(rgb);
    }
    for rgb in &mut weights {
        for (weight, sum) in rgb.iter_mut().zip(sums) {
            *weight /= sum;
        }
    }
    weights
}

/// x̄, ȳ and z̄ of the CIE 1931 observer at a wavelength, in the fit of \[Wyman2013\].
fn color_matching(nm: f64) -> [f64; 3] {
    let lobe = |height: f64, middle: f64, below: f64, above: f64| {
        let t = (nm - middle) / if nm < middle { below } else { above };
        height * libm::exp(-0.5 * t * t)
    };
    [
        lobe(1.056, 599.8, 37.9, 31.0)
            + lobe(0.362, 442.0, 16.0, 26.7)
            + lobe(-0.065, 501.1, 20.4, 26.2),
        lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
        lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The band averages by 1600 wavelengths.
    fn by_quadrature(cos: f64, gap_um: f64, n: f64) -> [f64; 3] {
        let steps = 1600;
        let (mut sums, mut totals) = ([0.0; 3], [0.0; 3]);
        for i in 0..steps {
            let nm = 380.0 + 400.0 * (f64::from(i) + 0.5) / f64::from(steps);
            let [x, y, z] = color_matching(nm);
            let r = gap_reflectance(cos, 1e-6 * gap_um, 1e-9 * nm, n);
            for (c, row) in [
                [3.2404542, -1.5371385, -0.4985314],
                [-0.9692660, 1.8760108, 0.0415560],
                [0.0556434, -0.2040259, 1.0572252],
            ]
            .iter()
            .enumerate()
            {
                let weight = row[0] * x + row[1] * y + row[2] * z;
                sums[c] += weight * r;
                totals[c] += weight;
            }
        }
        [0, 1, 2].map(|c| sums[c] / totals[c])
    }

    #[test]
    fn the_table_is_the_average_over_the_bands() {
        for n in [1.4, 1.52, 1.8] {
            let table = GapTable::new(n);
            let critical = (1.0 / n).asin().to_degrees();
            let (mut worst, mut worst_near) = (0.0_f64, 0.0_f64);
            for i in 0..180 {
                let angle = 0.5 * f64::from(i) + 0.03;
                for k in 0..60 {
                    let gap_um = 0.001 * 10_f64.powf(f64::from(k) / 12.0);
                    let cos = angle.to_radians().cos();
                    let got = table.rgb(cos, gap_um);
                    let expected = by_quadrature(cos, gap_um, n);
                    let mean = expected.iter().sum::<f64>() / 3.0;
                    let off = (got.iter().zip(expected))
                        .map(|(got, expected)| (got - expected.clamp(0.0, 1.0)).abs())
                        .fold((table.mean(cos, gap_um) - mean).abs(), f64::max);
                    if (angle - critical).abs() < 1.0 {
                        worst_near = worst_near.max(off);
                    } else {
                        worst = worst.max(off);
                    }
                }
            }
            assert!(worst < 5e-4, "index {n}: off by {worst}");
            assert!(
                worst_near < 1e-3,
                "index {n}, critical angle: off by {worst_near}"
            );
        }
    }

    #[test]
    fn the_bands_are_those_of_the_observer() {
        // Tabulated CIE 1931: the peaks of the three functions, and a wavelength between.
        for (nm, expected) in [
            (600.0, [1.0622, 0.6310, 0.0008]),
            (555.0, [0.5121, 1.0000, 0.0057]),
            (445.0, [0.3481, 0.0298, 1.7826]),
            (500.0, [0.0049, 0.3230, 0.2720]),
        ] {
            for (got, expected) in color_matching(nm).iter().zip(expected) {
                assert!(
                    (got - expected).abs() < 0.03,
                    "at {nm} nm {got}, tabulated {expected}"
                );
            }
        }
        for band in 0..3 {
            let sum: f64 = bands().iter().map(|w| w[band]).sum();
            assert!((sum - 1.0).abs() < 1e-12, "band {band} sums to {sum}");
        }
    }

    #[test]
    fn a_thin_film_under_white_light_shows_newtons_colors() {
        // Straight on, between glass: dark at contact, then white, yellow-red, and blue at about
        // the retardation of 600 nm, the sensitive tint (2 d = 565 nm): red and green are down.
        let table = GapTable::new(1.52);
        assert!(
            table.rgb(1.0, 0.01).iter().all(|&r| r < 0.01),
            "dark at contact"
        );
        let [r, g, b] = table.rgb(1.0, 0.565 / 2.0);
        assert!(
            g < 0.02 && b > 2.0 * g && r > 2.0 * g,
            "purple at a retardation of 565 nm, not {r} {g} {b}"
        );
        let white = table.rgb(1.0, 0.125);
        assert!(
            white.iter().all(|&r| r > 0.12 && r < 0.16),
            "white of the first order, not {white:?}"
        );
    }
}
