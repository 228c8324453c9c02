//! Every preset and damage class, and the optics over its parameters, as small pictures for the
//! documentation (`cargo xtask gallery`).
//!
//! Street scenes are JPEG, since their grain makes a PNG of them six times as large; drawings are
//! PNG. Damage that is small in the frame is cut out at full size, damage of the whole pane is
//! shown at half size. A word behind the folder makes only the pictures whose names contain it.
#![expect(clippy::print_stdout, reason = "a report is what this is for")]

use std::error::Error;
use std::path::{Path, PathBuf};

use image::imageops::{FilterType, crop_imm, replace, resize};
use image::{DynamicImage, GrayImage, Rgb, RgbImage};
use starbreak::glass::{GlassKind, Pane};
use starbreak::optics::{Camera, Coverage, Line, View};
use starbreak::{
    Chain, Details, FAULTS, FractureSettings, PRESETS, Recipe, Seed, growth_drawing, simulate,
};
use starbreak_dataset::{
    Encoding, JpegQuality, OutputBatch, encode_image, encode_mask, street_scene,
};

mod series;

use series::SERIES;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// The frame, px.
const FRAME: (u32, u32) = (1242, 375);

/// Between two pictures of a strip, px.
const GAP: u32 = 4;

/// Seeds of the pictures over the street, and what the camera is focused on.
const SEEDS: [(u64, &str); 3] = [(1, "far"), (2, "far"), (3, "short")];

/// Sheets of all presets over the severities, and what the camera is focused on.
const SHEETS: [(&str, &str); 2] = [("sheet.jpg", "far"), ("sheet-on-glass.jpg", "short")];

/// The sheet of the faults of the camera.
const FAULT_SHEET: &str = "faults.jpg";

/// Width of a picture on a sheet, px, and the seed of all of them.
const SHEET_WIDTH: u32 = 320;
const SHEET_SEED: u64 = 2;

/// Side of a drawing of a damage class, px.
const DRAWING: u32 = 400;

/// Seeds among which a damage class is looked for.
const TRIES: u64 = 20;

/// Presets whose damage spans the frame and makes sense only as a whole.
const WHOLE: [&str; 6] = [
    "windshield-bullseye",
    "windshield-long-crack",
    "windshield-spiderweb",
    "windshield-gravel",
    "windshield-hail",
    "paper",
];

/// Damage classes: name, preset, what is set beside it, and width of the drawing, mm.
const CLASSES: [(&str, &str, &[&str], f64); 12] = [
    ("pit", "windshield-star", &["impact.speed_m_s=8"], 12.0),
    ("bullseye", "windshield-bullseye", &[], 20.0),
    (
        "half-moon",
        "windshield-bullseye",
        &["impact.angle_deg=70", "impact.speed_m_s=90"],
        20.0,
    ),
    (
        "star",
        "windshield-star",
        &["fracture.until_reach_mm=16"],
        36.0,
    ),
    (
        "combination",
        "windshield-combination",
        &["fracture.until_reach_mm=16"],
        36.0,
    ),
    (
        "rim-to-impact",
        "lens-cover-star",
        &[
            "impact.speed_m_s=40",
            "impact.radius_mm=6",
            "fracture.until_reach_mm=end",
        ],
        44.0,
    ),
    ("diced", "tempered-cover", &[], 200.0),
    ("long-crack", "windshield-long-crack", &[], 1500.0),
    (
        "floater-crack",
        "windshield-long-crack",
        &[
            "long_crack.frame_tension_mpa=0.5",
            "long_crack.origin=impact",
            "long_crack.temperature_difference_k=-12",
            "fracture.until_reach_mm=end",
        ],
        1500.0,
    ),
    (
        "edge-crack",
        "windshield-long-crack",
        &[
            "long_crack.origin=rim",
            "long_crack.temperature_difference_k=40",
            "long_crack.spot=[0.5,0.5]",
            "fracture.until_reach_mm=end",
        ],
        1500.0,
    ),
    (
        "stress-crack",
        "windshield-long-crack",
        &[
            "long_crack.origin=rim",
            "long_crack.temperature_difference_k=40",
            "long_crack.spot=[0.5,0.5]",
            "fracture.until_reach_mm=end",
            "long_crack.frame_tension_mpa=0",
        ],
        1500.0,
    ),
    ("paper", "paper", &[], 0.0),
];

fn main() -> Result<()> {
    let out = std::env::args()
        .nth(1)
        .map_or_else(|| PathBuf::from("docs/figures/gallery"), PathBuf::from);
    let part = std::env::args().nth(2).unwrap_or_default();
    let is_wanted = |name: &str| name.contains(&part);
    let mut batch = OutputBatch::new().replacing(true);
    let street = street_scene().image;
    for (preset, _) in PRESETS {
        let name = format!("{preset}-street.jpg");
        if is_wanted(&name) {
            let seeds: Vec<RgbImage> = SEEDS
                .iter()
                .map(|&(seed, focus)| {
                    let mut recipe = Recipe::preset(preset)?;
                    recipe.set(&format!("camera.focus_distance_m={focus}"))?;
                    cracked(&recipe, &street, seed)
                })
                .collect::<Result<_>>()?;
            stage(&mut batch, &out, &name, &jpeg(strip(preset, &seeds))?)?;
        }
    }
    for (name, focus) in SHEETS {
        if is_wanted(name) {
            stage(&mut batch, &out, name, &jpeg(sheet(&street, focus)?)?)?;
        }
    }
    if is_wanted(FAULT_SHEET) {
        let sheet = fault_sheet(&street)?;
        stage(&mut batch, &out, FAULT_SHEET, &jpeg(sheet)?)?;
    }
    for series in &SERIES {
        let name = format!("{}.jpg", series.name);
        if is_wanted(&name) {
            println!("{}", series.command());
            stage(&mut batch, &out, &name, &jpeg(series.strip(&street)?)?)?;
        }
    }
    for (class, preset, sets, width_mm) in CLASSES {
        let name = format!("class-{class}.png");
        if !is_wanted(&name) {
            continue;
        }
        let Some((seed, drawing)) = drawing(class, preset, sets, width_mm)? else {
            println!("{class}: not among {TRIES} seeds of {preset} {sets:?}; no picture");
            continue;
        };
        let sets: String = sets.iter().map(|set| format!(" --set {set}")).collect();
        println!("{class}: starbreak simulate --preset {preset} --seed {seed}{sets}");
        let bytes = encode_mask(&drawing)?;
        stage(&mut batch, &out, &name, &bytes)?;
    }
    batch.commit()?;
    Ok(())
}

fn stage(batch: &mut OutputBatch, out: &Path, name: &str, bytes: &[u8]) -> Result<()> {
    println!("{name}: {} kB", bytes.len().div_ceil(1000));
    Ok(batch.stage(&out.join(name), bytes)?)
}

/// The frame through glass that a stone hits in its middle, or several where they do.
fn cracked(recipe: &Recipe, scene: &RgbImage, seed: u64) -> Result<RgbImage> {
    let mut recipe = recipe.clone();
    let is_one = match &recipe.settings()?.fracture {
        FractureSettings::Physics(physics) => physics.stones[0].count == 1,
        FractureSettings::Paper(_) | FractureSettings::None(_) => true,
    };
    if is_one {
        recipe.set("impact.position=[0.5,0.5]")?;
    }
    shown(&recipe, scene, seed)
}

/// The frame through broken glass.
fn shown(recipe: &Recipe, scene: &RgbImage, seed: u64) -> Result<RgbImage> {
    let mut image = DynamicImage::ImageRgb8(scene.clone());
    let size = (image.width(), image.height());
    Chain::of(&recipe.settings()?, size, Seed(seed))?.over(&mut image, Seed(seed))?;
    Ok(image.into_rgb8())
}

fn jpeg(picture: RgbImage) -> Result<Vec<u8>> {
    let encoding = Encoding::Jpeg {
        quality: JpegQuality::new(80)?,
    };
    Ok(encode_image(&picture.into(), &encoding, None)?)
}

/// All presets over the severities, one row each.
fn sheet(scene: &RgbImage, focus: &str) -> Result<RgbImage> {
    let height = SHEET_WIDTH * FRAME.1 / FRAME.0;
    let n_rows = u32::try_from(PRESETS.len()).unwrap_or(1);
    let size = (5 * (SHEET_WIDTH + GAP) - GAP, n_rows * (height + GAP) - GAP);
    let mut sheet = RgbImage::from_pixel(size.0, size.1, Rgb([255; 3]));
    for (row, (preset, _)) in (0..).zip(PRESETS) {
        for severity in 1..=5 {
            let mut recipe = Recipe::preset_at(preset, severity)?;
            recipe.set(&format!("camera.focus_distance_m={focus}"))?;
            let picture = shown(&recipe, scene, SHEET_SEED)?;
            let tile = resize(&picture, SHEET_WIDTH, height, FilterType::Triangle);
            let x = i64::from(severity - 1) * i64::from(SHEET_WIDTH + GAP);
            replace(&mut sheet, &tile, x, row * i64::from(height + GAP));
        }
    }
    Ok(sheet)
}

/// All presets of faults of the camera, one row each: severity 1, 3 and 5 of the frame, then the middle of 3 and 5 at
/// full size.
fn fault_sheet(scene: &RgbImage) -> Result<RgbImage> {
    let height = SHEET_WIDTH * FRAME.1 / FRAME.0;
    let presets = FAULTS.iter().flat_map(|fault| fault.presets);
    // A blank frame is no picture.
    let presets = presets.filter(|(preset, _)| *preset != "blank-frames");
    let n_rows = u32::try_from(presets.clone().count())?;
    let size = (5 * (SHEET_WIDTH + GAP) - GAP, n_rows * (height + GAP) - GAP);
    let mut sheet = RgbImage::from_pixel(size.0, size.1, Rgb([255; 3]));
    for (row, (preset, _)) in (0..).zip(presets) {
        for (severity, column) in [(1, None), (3, Some(3)), (5, Some(4))] {
            let picture = shown(&Recipe::preset_at(preset, severity)?, scene, SHEET_SEED)?;
            let mut put = |tile: &RgbImage, column: i64| {
                let x = column * i64::from(SHEET_WIDTH + GAP);
                replace(&mut sheet, tile, x, row * i64::from(height + GAP));
            };
            let whole = resize(&picture, SHEET_WIDTH, height, FilterType::Triangle);
            put(&whole, i64::from(severity / 2));
            if let Some(column) = column {
                let (x, y) = ((FRAME.0 - SHEET_WIDTH) / 2, (FRAME.1 - height) / 2);
                put(
                    &crop_imm(&picture, x, y, SHEET_WIDTH, height).to_image(),
                    column,
                );
            }
        }
    }
    Ok(sheet)
}

/// Pictures side by side: cut out around the middle, or whole ones at half size below each other.
fn strip(preset: &str, pictures: &[RgbImage]) -> RgbImage {
    let count = u32::try_from(pictures.len()).unwrap_or(1).max(1);
    let is_whole = WHOLE.contains(&preset);
    let (width, height) = if is_whole {
        (FRAME.0 / 2, FRAME.1 / 2)
    } else {
        ((FRAME.0 - (count - 1) * GAP) / count, FRAME.1)
    };
    let size = if is_whole {
        (width, count * (height + GAP) - GAP)
    } else {
        (count * (width + GAP) - GAP, height)
    };
    let mut strip = RgbImage::from_pixel(size.0, size.1, Rgb([255; 3]));
    for (k, picture) in (0..).zip(pictures) {
        let tile = if is_whole {
            resize(picture, width, height, FilterType::Triangle)
        } else {
            crop_imm(picture, (FRAME.0 - width) / 2, 0, width, height).to_image()
        };
        let place = if is_whole {
            (0, k * i64::from(height + GAP))
        } else {
            (k * i64::from(width + GAP), 0)
        };
        replace(&mut strip, &tile, place.0, place.1);
    }
    strip
}

/// The first seed whose damage is of this class, and a drawing of it, black on white.
fn drawing(
    class: &str,
    preset: &str,
    sets: &[&str],
    width_mm: f64,
) -> Result<Option<(u64, GrayImage)>> {
    let mut recipe = Recipe::preset(preset)?;
    for set in sets {
        recipe.set(set)?;
    }
    let settings = recipe.settings()?;
    for seed in 1..=TRIES {
        let simulated = simulate(&settings, FRAME, Seed(seed))?;
        let is_found = match &simulated.details {
            Details::Paper(_) | Details::Imported(_) | Details::None => true,
            Details::Physics(physics) => {
                let long = physics.long_crack.iter().map(|report| report.class);
                let mut all = physics
                    .impacts
                    .iter()
                    .map(|hit| hit.damage.name())
                    .chain(long);
                all.any(|name| name == class)
            }
        };
        if !is_found {
            continue;
        }
        let data = simulated.network.data();
        let is_whole = width_mm > 0.6 * data.pane.width;
        let middle = match data.impacts.first() {
            Some(impact) if !is_whole => [impact.x, impact.y],
            _ => [0.5 * data.pane.width, 0.5 * data.pane.height],
        };
        let view = if width_mm > 0.0 {
            let camera = Camera {
                f_px: f64::from(DRAWING) / width_mm * 1e3,
                distance_m: 1.0,
                rake_rad: 0.0,
                axis_at_mm: middle,
            };
            View::through(&camera, (DRAWING, DRAWING))?
        } else {
            View::stretched(&data.pane, (FRAME.0 / 2, FRAME.1 / 2))
        };
        let mut drawing = growth_drawing(&simulated.network, &view, f64::INFINITY, 1.2);
        let rim = rim(&data.pane, &view);
        for (pixel, rim) in drawing.iter_mut().zip(rim.iter()) {
            *pixel = u8::MAX - (*pixel).max(*rim);
        }
        return Ok(Some((seed, drawing)));
    }
    Ok(None)
}

/// The rim of a pane in mm, pale, as far as it is in view.
fn rim(pane: &Pane, view: &View) -> GrayImage {
    let (width, height) = view.size();
    let corners = if pane.kind == Some(GlassKind::Cover) {
        (0..64_u8)
            .map(|k| {
                let angle = std::f64::consts::TAU * f64::from(k) / 64.0;
                let radius = 0.5 * pane.width;
                [radius * (1.0 + angle.cos()), radius * (1.0 + angle.sin())]
            })
            .collect()
    } else {
        let (right, bottom) = (pane.width, pane.height);
        vec![[0.0, 0.0], [right, 0.0], [right, bottom], [0.0, bottom]]
    };
    let next = corners.iter().cycle().skip(1);
    let lines = corners.iter().zip(next).filter_map(|([x0, y0], [x1, y1])| {
        Some(Line {
            ends: view.visible([*x0, *y0, *x1, *y1], 2.0)?,
            weight: 1.0,
        })
    });
    let mut rim = Coverage::of_lines(width, height, 1.0, lines).to_mask();
    for level in rim.iter_mut() {
        *level /= 3;
    }
    rim
}
