//! Legs of stars as a picture shows them, against what is known of photographs.
//!
//! `cargo run --release -p starbreak --example legs [STARS]` breaks 100 windscreens, or so many, under
//! a white sky over dark ground, with the camera focused on the glass, and measures in the pictures
//! how wide the legs are and how bright, by direction. Ends with 1 if a law does not hold.

#![expect(clippy::print_stdout, reason = "a report is what this is for")]

use std::error::Error;
use std::process::ExitCode;

use image::{DynamicImage, GrayImage, Luma, RgbImage};
use rayon::prelude::*;
use starbreak::{Chain, Recipe, Scene, Seed, Settings};
use starbreak_glass::SegmentKind;
use starbreak_optics::View;

/// Side of the frame, px, and its focal length, px.
const SIDE_PX: u32 = 1000;
const F_PX: f64 = 1800.0;

/// Codes of the sky and of the ground.
const SKY: u8 = 235;
const GROUND: u8 = 60;

/// Legs are measured between these distances from the hit, mm, and this far to either side.
const FROM_MM: f64 = 5.0;
const ASIDE_MM: f64 = 1.5;

/// Thickness of the ply, mm, and from how many on a leg is through.
const THICKNESS_MM: f64 = 2.1;
const LONG: f64 = 17.0;

/// A piece of a leg, seen.
struct Piece {
    crack: usize,
    length_mm: f64,
    /// Depth in the middle of it, over the thickness of the ply.
    depth: f64,
    /// Width as it is seen, and what geometry gives at full depth, mm.
    width_mm: f64,
    full_mm: f64,
    /// Linear light that the crack sends, over that of the sky.
    light: f64,
    /// Sine of the elevation of what a smooth upright crack mirrors there.
    rises: f64,
}

struct Star {
    pieces: Vec<Piece>,
    /// Length of each crack over the thickness of the ply.
    reach: Vec<f64>,
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let n_stars = std::env::args()
        .nth(1)
        .map_or(Ok(100), |text| text.parse::<u64>())?;
    let settings = settings()?;
    let stars: Vec<Star> = (0..n_stars)
        .into_par_iter()
        .map(|seed| star(&settings, Seed(seed)).map_err(|error| format!("seed {seed}: {error}")))
        .collect::<Result<_, _>>()?;

    let all: Vec<&Piece> = stars.iter().flat_map(|star| &star.pieces).collect();
    let level = all.iter().filter(|piece| piece.full_mm > 0.5);
    let widths: Vec<f64> = level.map(|piece| piece.width_mm).collect();
    println!(
        "width of legs of which 0.5 mm or more show at full depth: {:.2} mm in the median, {:.2} to {:.2} mm from the 10th to the 90th percentile",
        quantile(&widths, 0.5),
        quantile(&widths, 0.1),
        quantile(&widths, 0.9)
    );
    let long = shares(&stars);
    println!(
        "share of the length at 80 % or more, of legs longer than 17 thicknesses: {:.2} of their full depth (at least 0.90), {:.2} of their full width as it is seen, with the tilt that wanders",
        long[0], long[1]
    );
    let sign = correlation(&all);
    let bright = |low: f64, high: f64| {
        let some = all
            .iter()
            .filter(|piece| (low..high).contains(&piece.rises));
        quantile(&some.map(|piece| piece.light).collect::<Vec<_>>(), 0.5)
    };
    println!(
        "light of legs over that of the sky, by the elevation of what they mirror: {:.2} below 0 degrees, {:.2} to 6, {:.2} to 24, {:.2} above; correlation with the share of the sky in that {sign:.2} (above 0)",
        bright(-1.0, 0.0),
        bright(0.0, 0.1),
        bright(0.1, 0.4),
        bright(0.4, 1.0),
    );
    let holds = long[0] >= 0.9 && sign > 0.0;
    Ok(if holds {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

fn settings() -> Result<Settings, Box<dyn Error>> {
    let mut recipe = Recipe::preset("windshield-star")?;
    for assignment in [
        "impact.position=[0.5,0.5]",
        "fracture.mesh=fast",
        "glass.rake_deg=30",
        "camera.focus_distance_m=0.15",
        &format!("camera.f_px={F_PX}"),
    ] {
        recipe.set(assignment)?;
    }
    Ok(recipe.settings()?)
}

fn star(settings: &Settings, seed: Seed) -> Result<Star, Box<dyn Error>> {
    let scene = RgbImage::from_fn(SIDE_PX, SIDE_PX, |_, y| {
        let code = if 2 * y < SIDE_PX { SKY } else { GROUND };
        [code; 3].into()
    });
    let mut after = DynamicImage::ImageRgb8(scene.clone());
    let size = (SIDE_PX, SIDE_PX);
    let chain = Chain::of(settings, size, seed)?;
    chain.over(&mut after, seed)?;
    let crack = chain.crack_mask()?;
    let view = Scene::of(settings, size).pane()?;
    let seen = Seen {
        before: &scene,
        after: &after.to_rgb8(),
        crack: &crack,
        view: &view,
    };
    let network = chain.network().ok_or("no network")?;
    let data = network.data();
    let hit = data.impacts.first().ok_or("no hit")?;
    let segments = &data.segments;
    let parents = segments.parent.as_ref().ok_or("no parents")?;

    // A leg is a chain of segments of one kind, each grown out of the one before.
    let n = segments.from.len();
    let is_leg = |idx: usize| matches!(segments.kind[idx], SegmentKind::Radial | SegmentKind::Edge);
    let mut crack = vec![usize::MAX; n];
    let mut reach: Vec<f64> = Vec::new();
    let mut order: Vec<usize> = (0..n).filter(|idx| is_leg(*idx)).collect();
    let depths = segments.depth_ends.as_ref().ok_or("no depths")?;
    let departure = segments.departure_us.as_ref().ok_or("no times")?;
    order.sort_by(|a, b| departure[*a].total_cmp(&departure[*b]));
    let mut is_continued = vec![false; n];
    for &idx in &order {
        let parent = parents[idx].map(|parent| parent as usize);
        let goes_on =
            parent.filter(|parent| crack[*parent] != usize::MAX && !is_continued[*parent]);
        crack[idx] = match goes_on {
            Some(parent) => {
                is_continued[parent] = true;
                crack[parent]
            }
            None => {
                reach.push(0.0);
                reach.len() - 1
            }
        };
        let [_, _, x, y] = network.ends(idx);
        let far = (x - hit.x).hypot(y - hit.y) / THICKNESS_MM;
        reach[crack[idx]] = reach[crack[idx]].max(far);
    }
    let pieces = order
        .iter()
        .filter_map(|idx| {
            let ends = network.ends(*idx);
            let [x, y] = [0.5 * (ends[0] + ends[2]), 0.5 * (ends[1] + ends[3])];
            let is_far = (x - hit.x).hypot(y - hit.y) > FROM_MM;
            let depth = 0.5 * (depths[*idx][0] + depths[*idx][1]);
            is_far
                .then(|| seen.piece((crack[*idx], depth), ends))
                .flatten()
        })
        .collect();
    Ok(Star { pieces, reach })
}

struct Seen<'a> {
    before: &'a RgbImage,
    after: &'a RgbImage,
    crack: &'a GrayImage,
    view: &'a View,
}

impl Seen<'_> {
    /// What the picture shows of a stretch of crack.
    fn piece(&self, (crack, depth): (usize, f64), [x0, y0, x1, y1]: [f64; 4]) -> Option<Piece> {
        let length_mm = (x1 - x0).hypot(y1 - y0);
        let (a, b) = (self.view.project([x0, y0])?, self.view.project([x1, y1])?);
        let length_px = (b[0] - a[0]).hypot(b[1] - a[1]);
        let middle = [0.5 * (x0 + x1), 0.5 * (y0 + y1)];
        let px_per_mm = self.view.px_per_unit(middle)?;
        if length_px < 1.0 {
            return None;
        }
        let along = [(b[0] - a[0]) / length_px, (b[1] - a[1]) / length_px];
        let aside_px = ASIDE_MM * px_per_mm;
        let (mut covered, mut sent) = (0.0, 0.0);
        let (n_along, step_px) = (length_px.ceil(), length_px / length_px.ceil());
        let mut i = 0.5;
        while i < n_along {
            let mut off = -aside_px;
            while off <= aside_px {
                let u = a[0] + i * step_px * along[0] - off * along[1];
                let v = a[1] + i * step_px * along[1] + off * along[0];
                let (share, light) = self.at(u, v)?;
                covered += share;
                sent += light;
                off += 1.0;
            }
            i += 1.0;
        }
        if covered <= 0.0 {
            return None;
        }
        let (rises, across) = mirrored(middle, [x1 - x0, y1 - y0], self.view)?;
        Some(Piece {
            crack,
            length_mm,
            depth,
            width_mm: covered / n_along / px_per_mm,
            full_mm: THICKNESS_MM * across,
            light: sent / covered / linear(SKY),
            rises,
        })
    }

    /// Coverage by the crack at a pixel, and the linear light that it sends.
    fn at(&self, u: f64, v: f64) -> Option<(f64, f64)> {
        let side = f64::from(SIDE_PX);
        if !(0.0..side).contains(&u) || !(0.0..side).contains(&v) {
            return None;
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "within the frame"
        )]
        let (x, y) = (u as u32, v as u32);
        let Luma([code]) = *self.crack.get_pixel(x, y);
        let share = f64::from(code) / 255.0;
        let mean = |image: &RgbImage| {
            let codes = image.get_pixel(x, y).0;
            codes.map(linear).iter().sum::<f64>() / 3.0
        };
        Some((share, mean(self.after) - (1.0 - share) * mean(self.before)))
    }
}

/// What a smooth upright crack along a direction mirrors, by plane geometry alone: the sine of its
/// elevation; and how wide such a crack is seen, over its depth.
fn mirrored([x, y]: [f64; 2], [dx, dy]: [f64; 2], view: &View) -> Option<(f64, f64)> {
    let rake = 30.0_f64.to_radians();
    // Right, down and forward; the pane's upper edge leans towards the camera.
    let right = [1.0, 0.0, 0.0];
    let down = [0.0, rake.cos(), rake.sin()];
    let outward = [0.0, -rake.sin(), rake.cos()];
    let [u, v] = view.project([x, y])?;
    let center = 0.5 * f64::from(SIDE_PX);
    let sight = [(u - center) / F_PX, (v - center) / F_PX, 1.0];
    let size = dot(sight, sight).sqrt();
    let in_plane = [dot(sight, right) / size, dot(sight, down) / size];
    let length = dx.hypot(dy);
    let wall = [-dy / length, dx / length];
    let across = in_plane[0] * wall[0] + in_plane[1] * wall[1];
    let turned = [0, 1].map(|k| in_plane[k] - 2.0 * across * wall[k]);
    let forward = (1.0 - turned[0] * turned[0] - turned[1] * turned[1]).sqrt();
    let elevation = -(turned[0] * right[1] + turned[1] * down[1] + forward * outward[1]);
    // Inside the sheet the way across is that over the index.
    let inside = [in_plane[0] / 1.52, in_plane[1] / 1.52];
    let deep = (1.0 - inside[0] * inside[0] - inside[1] * inside[1]).sqrt();
    Some((elevation, (across / 1.52 / deep).abs()))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn linear(code: u8) -> f64 {
    let s = f64::from(code) / 255.0;
    if s <= 0.040_45 {
        s / 12.92
    } else {
        ((s + 0.055) / 1.055).powf(2.4)
    }
}

/// Of long legs, which part of their length is at least 0.8 of the full depth of the leg, and
/// of its full width over what geometry lets be seen there.
fn shares(stars: &[Star]) -> [f64; 2] {
    let mut sums = [0.0; 3];
    for star in stars {
        for (crack, reach) in star.reach.iter().enumerate() {
            let own = |piece: &&Piece| piece.crack == crack && piece.full_mm > 0.3;
            let own: Vec<&Piece> = star.pieces.iter().filter(own).collect();
            if *reach <= LONG || own.len() < 5 {
                continue;
            }
            let width = |piece: &Piece| piece.width_mm / piece.full_mm;
            let widths: Vec<f64> = own.iter().map(|piece| width(piece)).collect();
            let full = quantile(&widths, 0.5);
            let deepest = own.iter().map(|piece| piece.depth).fold(0.0, f64::max);
            for piece in own {
                let are_wide = [
                    piece.depth >= 0.8 * deepest,
                    width(piece) >= 0.8 * full,
                    true,
                ];
                for (sum, is_wide) in sums.iter_mut().zip(are_wide) {
                    *sum += if is_wide { piece.length_mm } else { 0.0 };
                }
            }
        }
    }
    [sums[0] / sums[2], sums[1] / sums[2]]
}

fn quantile(of: &[f64], part: f64) -> f64 {
    let mut sorted = of.to_vec();
    sorted.sort_by(f64::total_cmp);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "a place in a list"
    )]
    let at = (part * sorted.len().saturating_sub(1) as f64) as usize;
    sorted.get(at).copied().unwrap_or(f64::NAN)
}

/// Correlation of the light of legs with the share of the sky in what they mirror, weighted by the area
/// that is seen: rough legs that wander mirror 12 degrees around.
fn correlation(pieces: &[&Piece]) -> f64 {
    let sky = |piece: &Piece| (0.5 + piece.rises / 0.4).clamp(0.0, 1.0);
    let sum = |of: &dyn Fn(&Piece) -> f64| -> f64 {
        let weighted = |piece: &&Piece| piece.length_mm * piece.width_mm * of(piece);
        pieces.iter().map(weighted).sum()
    };
    let area = sum(&|_| 1.0);
    let (light, share) = (sum(&|p| p.light) / area, sum(&|p| sky(p)) / area);
    let joint = sum(&|p| (p.light - light) * (sky(p) - share));
    let of_light = sum(&|p| (p.light - light).powi(2));
    let of_share = sum(&|p| (sky(p) - share).powi(2));
    joint / (of_light * of_share).sqrt()
}
