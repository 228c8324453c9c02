//! Compares the physical optics with profiles across cracks that Mitsuba 3 traced.
//!
//! `validation/mitsuba/chain.py` writes the profiles: thin lens, sheet of glass, crack, and light
//! that [`Environment`] can hold exactly. Here the same crack is baked, lit and put over the image
//! of the intact sheet, T L(w) + R C, and both are averaged along the crack. Printed per case, of
//! the contrast (cracked over intact − 1): the peaks of means over 3 px and their ratio, the sums
//! in px and their ratio, and the root mean square of the difference; then the light of Mitsuba's
//! intact sheet over ours.
//!
//! Run with `cargo run --release -p starbreak-optics --example chain FILE.json`, with one more
//! word for the profiles themselves; ends with 1 if a case that is judged is off.
#![expect(clippy::print_stdout, reason = "a table is what it is for")]

use std::error::Error;
use std::process::ExitCode;

use image::{DynamicImage, ImageBuffer, Luma};
use serde_json::{Value, json};
use starbreak_glass::CrackNetwork;
use starbreak_optics::environment::{Environment, EnvironmentParams, Horizon};
use starbreak_optics::interface::fresnel::{slab_reflectance, slab_transmittance};
use starbreak_optics::lens::Lens;
use starbreak_optics::physical::{Glass, PhysicalOptics, SurfaceParams, bake};
use starbreak_optics::{Camera, View};
use starbreak_seed::Seed;

/// Where the optical axis meets the pane, mm from its corner.
const AXIS_MM: f64 = 1000.0;

/// Off by at most: the intact sheet; peak and sum of the contrast, or these parts of its light.
const RADIANCE: f64 = 0.002;
const PEAK: f64 = 0.03;
const SUM: f64 = 0.05;
const LEAST_PEAK: f64 = 0.003;
const LEAST_SUM_PX: f64 = 0.03;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let path = std::env::args()
        .nth(1)
        .ok_or("usage: chain FILE.json [profiles]")?;
    let off = compare_all(&path, std::env::args().nth(2).is_some())?;
    Ok(ExitCode::from(u8::from(!off.is_empty())))
}

/// Compares all cases of a file; gives the names of those that are judged and off.
pub(crate) fn compare_all(path: &str, with_profiles: bool) -> Result<Vec<String>, Box<dyn Error>> {
    let cases: Vec<Value> = serde_json::from_str(&std::fs::read_to_string(path)?)?;
    println!(
        "{:20} | {:>7} {:>7} {:>6} | {:>7} {:>7} {:>6} | {:>6} | {:>6} |",
        "case", "peak", "ours", "ratio", "sum px", "ours", "ratio", "rms", "intact"
    );
    let mut failed = Vec::new();
    for value in &cases {
        let row = Case(value).compare()?;
        let least = value["least_peak"].as_f64().unwrap_or(LEAST_PEAK);
        let peak = value["peak_tolerance"].as_f64().unwrap_or(PEAK);
        let is_off = |[theirs, ours]: [f64; 2], tolerance: f64, least: f64| {
            (ours - theirs).abs() > (tolerance * theirs.abs()).max(least)
        };
        let is_off = is_off(row.peak, peak, least)
            || is_off(
                row.sum,
                SUM.max(peak),
                LEAST_SUM_PX.max(least * row.sum[0].abs() / row.peak[0].abs()),
            )
            || (row.intact - 1.0).abs() > RADIANCE && !Case(value).is_polarized();
        let name = value["name"].as_str().unwrap_or("?");
        let is_judged = value["is_judged"].as_bool().unwrap_or(true);
        println!(
            "{:20} | {:+7.4} {:+7.4} {:6.3} | {:+7.3} {:+7.3} {:6.3} | {:6.4} | {:6.4} | {}",
            name,
            row.peak[0],
            row.peak[1],
            row.peak[1] / row.peak[0],
            row.sum[0],
            row.sum[1],
            row.sum[1] / row.sum[0],
            row.rms,
            row.intact,
            match (is_judged, is_off) {
                (false, _) => "reported",
                (true, true) => "OFF",
                (true, false) => "ok",
            }
        );
        if is_off && is_judged {
            failed.push(name.to_owned());
        }
        if with_profiles {
            for (k, (theirs, ours)) in row.profiles.iter().enumerate() {
                println!("{k:4} {theirs:+.5} {ours:+.5}");
            }
        }
    }
    println!("{} of {} cases are off", failed.len(), cases.len());
    Ok(failed)
}

/// What came out of one case, Mitsuba's first.
struct Row {
    peak: [f64; 2],
    sum: [f64; 2],
    rms: f64,
    /// Mitsuba's intact sheet over ours.
    intact: f64,
    profiles: Vec<(f64, f64)>,
}

struct Case<'a>(&'a Value);

impl Case<'_> {
    fn number(&self, key: &str) -> Result<f64, String> {
        self.0[key]
            .as_f64()
            .ok_or_else(|| format!("{}: no number {key}", self.0["name"]))
    }

    fn pair(&self, key: &str) -> Result<[f64; 2], String> {
        let values = &self.0[key];
        match (values[0].as_f64(), values[1].as_f64()) {
            (Some(a), Some(b)) => Ok([a, b]),
            _ => Err(format!("{}: no pair {key}", self.0["name"])),
        }
    }

    fn size(&self) -> Result<(u32, u32), Box<dyn Error>> {
        let side = |k: usize| -> Result<u32, Box<dyn Error>> {
            let side = self.0["size"][k].as_u64().ok_or("no size")?;
            Ok(u32::try_from(side)?)
        };
        Ok((side(0)?, side(1)?))
    }

    fn compare(&self) -> Result<Row, Box<dyn Error>> {
        let size = self.size()?;
        let intact = self.intact(size)?;
        let mut image = DynamicImage::ImageLuma16(encoded(&intact, size));
        let optics = self.optics(size)?;
        let camera = Camera {
            f_px: self.number("f_px")?,
            distance_m: 1e-3 * self.number("distance_mm")?,
            rake_rad: self.number("rake_deg")?.to_radians(),
            axis_at_mm: [AXIS_MM; 2],
        };
        let view = View::through(&camera, size)?;
        let pattern = bake(&self.network()?, f64::INFINITY, &view, &optics, Seed(1))?;
        let overlay = pattern.light(&self.environment()?, &optics);
        overlay.apply(&mut image, Seed(1))?;
        let cracked: Vec<f64> = image
            .to_luma16()
            .as_raw()
            .iter()
            .map(|&code| decoded(code))
            .collect();
        let ours = self.profile(&cracked, size)?;
        let ours_intact = self.profile(&intact, size)?;
        let theirs = self.0["profile"]["mean"].as_array();
        let theirs = theirs.into_iter().flatten().filter_map(Value::as_f64);
        let mean = |values: &[f64]| values.iter().sum::<f64>() / count(values.len());
        let intact = self.number("intact")? / mean(&ours_intact);
        // Polarized light passes the intact sheet a little better than the image says.
        let intact_ratio = if self.is_polarized() { intact } else { 1.0 };
        let profiles: Vec<(f64, f64)> = theirs
            .zip(&ours)
            .zip(&ours_intact)
            .map(|((theirs, ours), intact)| {
                (theirs / (intact_ratio * intact) - 1.0, ours / intact - 1.0)
            })
            .collect();
        let square: Vec<f64> = profiles.iter().map(|(a, b)| (a - b) * (a - b)).collect();
        Ok(Row {
            peak: [
                peak(profiles.iter().map(|p| p.0)),
                peak(profiles.iter().map(|p| p.1)),
            ],
            sum: [
                profiles.iter().map(|p| p.0).sum(),
                profiles.iter().map(|p| p.1).sum(),
            ],
            rms: mean(&square).sqrt(),
            intact,
            profiles,
        })
    }

    fn is_polarized(&self) -> bool {
        self.0["polarized"].as_bool().unwrap_or(false)
    }

    /// The cabin's light by the sine of the elevation: the same everywhere, or from straight down
    /// to straight up.
    fn cabin(&self, sine: f64) -> Result<f64, String> {
        match self.pair("cabin") {
            Ok([low, high]) => Ok(low + (high - low) * 0.5 * (1.0 + sine)),
            Err(_) => self.number("cabin"),
        }
    }

    /// The direction that is up in camera coordinates.
    fn up(&self) -> Result<[f64; 3], String> {
        let (sin, cos) = self.number("pitch_deg")?.to_radians().sin_cos();
        Ok([0.0, -cos, sin])
    }

    /// Light from outside through the intact sheet, per pixel.
    fn intact(&self, (width, height): (u32, u32)) -> Result<Vec<f64>, Box<dyn Error>> {
        let (index, f_px) = (self.number("index")?, self.number("f_px")?);
        let (sin, cos) = self.number("rake_deg")?.to_radians().sin_cos();
        let horizon = Horizon { up: self.up()? };
        let light = ["horizon", "zenith", "ground"].map(|key| self.number(key));
        let [at_horizon, at_zenith, ground] = light;
        let (at_horizon, at_zenith, ground) = (at_horizon?, at_zenith?, ground?);
        let mut out = Vec::new();
        for y in 0..height {
            for x in 0..width {
                let u = (f64::from(x) + 0.5 - 0.5 * f64::from(width)) / f_px;
                let v = (f64::from(y) + 0.5 - 0.5 * f64::from(height)) / f_px;
                let length = (u * u + v * v + 1.0).sqrt();
                let sine = horizon.sin_elevation([u, v, 1.0]);
                let outside = if sine > 0.0 {
                    at_horizon + (at_zenith - at_horizon) * sine
                } else {
                    ground
                };
                let cos_i = (cos - v * sin) / length;
                // By the mirrored line of sight: d − 2 (d·n) n with n = (0, −sin, cos).
                let mirrored = [
                    u,
                    v + 2.0 * cos_i * length * sin,
                    1.0 - 2.0 * cos_i * length * cos,
                ];
                let cabin = self.cabin(horizon.sin_elevation(mirrored))?;
                out.push(
                    slab_transmittance(cos_i, index) * outside
                        + slab_reflectance(cos_i, index) * cabin,
                );
            }
        }
        Ok(out)
    }

    /// The light around the camera in units of the image: through the sheet at the angle of
    /// sight, with the cabin's reflection.
    fn environment(&self) -> Result<Environment, Box<dyn Error>> {
        let index = self.number("index")?;
        let cos = self.number("rake_deg")?.to_radians().cos();
        let (t, r) = (slab_transmittance(cos, index), slab_reflectance(cos, index));
        // Sight straight ahead is mirrored by the sheet.
        let sin = self.number("rake_deg")?.to_radians().sin();
        let horizon = Horizon { up: self.up()? };
        let cabin =
            self.cabin(horizon.sin_elevation([0.0, 2.0 * cos * sin, 1.0 - 2.0 * cos * cos]))?;
        let dark = self.0.get("cone_deg").is_some();
        let seen = |key: &str| -> Result<[f32; 3], String> {
            let outside = if dark { 0.0 } else { self.number(key)? };
            Ok(single(t * outside + r * cabin))
        };
        let sun = match self.0.get("sun") {
            Some(sun) => t * sun["irradiance"].as_f64().ok_or("no irradiance")?,
            None => 0.0,
        };
        Ok(Environment {
            horizon_rgb: seen("horizon")?,
            zenith_rgb: seen("zenith")?,
            ground_rgb: seen("ground")?,
            cabin_low_rgb: single(self.cabin(-1.0)?),
            cabin_high_rgb: single(self.cabin(1.0)?),
            sun_rgb: single(sun),
        })
    }

    fn optics(&self, (_, height): (u32, u32)) -> Result<PhysicalOptics, Box<dyn Error>> {
        let focus_m = self.number("focus_m")?;
        let up = self.up()?;
        let (azimuth, elevation) = match self.0.get("sun") {
            Some(sun) => {
                let to: Vec<f64> = sun["to"]
                    .as_array()
                    .into_iter()
                    .flatten()
                    .filter_map(Value::as_f64)
                    .collect();
                let [x, y, z] = to[..] else {
                    return Err("no direction of the sun".into());
                };
                // Ahead along the ground is (0, up_z, −up_y).
                let ahead = y * up[2] - z * up[1];
                (x.atan2(ahead), (y * up[1] + z * up[2]).asin())
            }
            None => (0.0, 0.5),
        };
        Ok(PhysicalOptics {
            lens: Lens {
                focal_length_m: 1e-3 * self.number("focal_mm")?,
                f_number: self.number("f_number")?,
                focus_m,
                // The scene is smooth: its own blur is left out.
                scene_m: focus_m,
                ..Lens::default()
            },
            environment: EnvironmentParams {
                sun_azimuth_rad: azimuth,
                sun_elevation_rad: elevation,
                horizon_row: 0.5
                    + self.number("f_px")? * self.number("pitch_deg")?.to_radians().tan()
                        / f64::from(height),
                // What is beyond the border is known; the light comes later.
                horizon_rgb: Some([0.0; 3]),
                zenith_rgb: Some([0.0; 3]),
                ground_rgb: Some([0.0; 3]),
                ..EnvironmentParams::default()
            },
            glass: Glass {
                thickness_mm: self.number("thickness_mm")?,
                refractive_index: self.number("index")?,
                rim_reflectance: self.0["rim"].as_f64().map_or(0.0, |_| 1.0),
                rim_way_mm: 0.0,
                ..Glass::default()
            },
            surface: SurfaceParams {
                mirror_alpha: Some(self.number("alpha")?),
                ..SurfaceParams::default()
            },
            ..PhysicalOptics::default()
        })
    }

    fn network(&self) -> Result<CrackNetwork, Box<dyn Error>> {
        let outer = self.pair("outer_mm")?;
        let reach = self.number("reach_mm")?;
        let (sin, cos) = self.number("crack_deg")?.to_radians().sin_cos();
        let shifts: Vec<f64> = self.0["shifts_mm"]
            .as_array()
            .into_iter()
            .flatten()
            .filter_map(Value::as_f64)
            .collect();
        let ends: Vec<[f64; 2]> = shifts
            .iter()
            .flat_map(|shift| {
                [-reach, reach].map(|s| {
                    [
                        AXIS_MM + outer[0] + s * cos + shift * sin,
                        AXIS_MM + outer[1] + s * sin - shift * cos,
                    ]
                })
            })
            .collect();
        let n = shifts.len();
        let column = |value: f64| vec![value; n];
        let network = json!({
            "schema": "starbreak.crack-network/1",
            "generator": {"name": "chain", "version": "1"},
            "model": "imported",
            "unit": "mm",
            "pane": {"width": 2.0 * AXIS_MM, "height": 2.0 * AXIS_MM},
            "impacts": [],
            "nodes": {
                "x": ends.iter().map(|p| p[0]).collect::<Vec<_>>(),
                "y": ends.iter().map(|p| p[1]).collect::<Vec<_>>(),
            },
            "segments": {
                "from": (0..n).map(|k| 2 * k).collect::<Vec<_>>(),
                "to": (0..n).map(|k| 2 * k + 1).collect::<Vec<_>>(),
                "kind": vec!["radial"; n],
                "opening_um": column(1e3 * self.number("gap_mm")?),
                "depth_fraction": column(self.number("depth_fraction")?),
                "tilt_deg": column(self.number("tilt_deg")?),
            },
        });
        Ok(CrackNetwork::from_json(&network.to_string())?)
    }

    /// Means over lines along the crack, 1 px apart, as Mitsuba's side takes them.
    fn profile(
        &self,
        light: &[f64],
        (width, height): (u32, u32),
    ) -> Result<Vec<f64>, Box<dyn Error>> {
        let lines = Case(&self.0["profile"]);
        let (normal, middle) = (lines.pair("normal")?, lines.pair("middle")?);
        let half = lines.number("half_px")?;
        let mut sums = Vec::new();
        let mut first = -half;
        while first < half {
            sums.push((0.0, 0.0));
            first += 1.0;
        }
        let mut pixels = light.iter();
        for y in 0..height {
            for x in 0..width {
                let Some(light) = pixels.next() else {
                    continue;
                };
                let u = f64::from(x) + 0.5 - middle[0];
                let v = f64::from(y) + 0.5 - middle[1];
                let s = (u * normal[0] + v * normal[1]).floor();
                if u.abs() < half && v.abs() < half && s >= -half && s < half {
                    #[expect(
                        clippy::cast_possible_truncation,
                        clippy::cast_sign_loss,
                        reason = "0 to 2 half"
                    )]
                    let (sum, weight) = &mut sums[(s + half) as usize];
                    *sum += light;
                    *weight += 1.0;
                }
            }
        }
        Ok(sums
            .into_iter()
            .map(|(sum, weight): (f64, f64)| sum / weight.max(1.0))
            .collect())
    }
}

/// The largest departure from 0 of means over three.
fn peak(values: impl Iterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.collect();
    values
        .windows(3)
        .map(|three| three.iter().sum::<f64>() / 3.0)
        .fold(
            0.0,
            |most: f64, mean| {
                if mean.abs() > most.abs() { mean } else { most }
            },
        )
}

fn count(n: usize) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "some hundred")]
    let n = n as f64;
    n
}

fn single(light: f64) -> [f32; 3] {
    #[expect(clippy::cast_possible_truncation, reason = "light is kept as f32")]
    let light = light as f32;
    [light; 3]
}

/// Linear light of a 16-bit sRGB code.
fn decoded(code: u16) -> f64 {
    let c = f64::from(code) / 65535.0;
    if c <= 0.04045 {
        c / 12.92
    } else {
        ((c + 0.055) / 1.055).powf(2.4)
    }
}

fn encoded(light: &[f64], (width, height): (u32, u32)) -> ImageBuffer<Luma<u16>, Vec<u16>> {
    let mut pixels = light.iter();
    ImageBuffer::from_fn(width, height, |_, _| {
        let light = pixels.next().copied().unwrap_or(0.0);
        let c = if light <= 0.003_130_8 {
            12.92 * light
        } else {
            1.055 * light.powf(1.0 / 2.4) - 0.055
        };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped"
        )]
        let code = (65535.0 * c.clamp(0.0, 1.0)).round() as u16;
        Luma([code])
    })
}
