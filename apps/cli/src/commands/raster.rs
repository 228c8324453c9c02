//! Drawings and words as pixels.

use ab_glyph::{Font as _, FontRef, OutlineCurve};
use ab_glyph_rasterizer::{Point, Rasterizer, point};
use image::RgbImage;
use starbreak_dataset::{Encoding, encode_image};
use starbreak_eval::chart::{Anchor, Drawing, Shape};

use crate::failure::Failure;

/// The font of all words: Hack, whose letters are all equally wide.
const FONT: &[u8] = epaint_default_fonts::HACK_REGULAR;

/// Pixels per px of a drawing.
const SCALE: f32 = 2.0;

/// A drawing on white as the bytes of a PNG file. Its lines have no dashes there.
pub(super) fn png(drawing: &Drawing) -> Result<Vec<u8>, Failure> {
    let [width, height] = drawing.size_px.map(|side| float(side) * SCALE);
    let mut image = RgbImage::from_pixel(whole(width), whole(height), [255; 3].into());
    for shape in &drawing.shapes {
        draw(&mut image, shape, SCALE);
    }
    Ok(encode_image(&image.into(), &Encoding::Png, None)?)
}

/// Puts a shape over an image.
pub(super) fn draw(image: &mut RgbImage, shape: &Shape, scale: f32) {
    let scaled = |[x, y]: [f64; 2]| point(float(x) * scale, float(y) * scale);
    match shape {
        Shape::Line {
            points,
            color,
            width_px,
            dashes: _,
        } => {
            let points: Vec<Point> = points.iter().copied().map(scaled).collect();
            let half = 0.5 * float(*width_px) * scale;
            let curves: Vec<OutlineCurve> = points
                .windows(2)
                .flat_map(|ends| around(ends[0], ends[1], half))
                .collect();
            fill(image, &curves, color, 1.0);
        }
        Shape::Area {
            points,
            color,
            opacity,
        } => {
            let points: Vec<Point> = points.iter().copied().map(scaled).collect();
            fill(image, &polygon(&points), color, float(*opacity));
        }
        Shape::Words {
            at,
            text,
            size_px,
            anchor,
            turn_deg,
            color,
        } => {
            let style = (float(*size_px) * scale, *anchor, float(*turn_deg));
            fill(image, &letters(scaled(*at), text, style), color, 1.0);
        }
    }
}

/// The outlines of letters.
fn letters(
    at: Point,
    text: &str,
    (size, anchor, turn_deg): (f32, Anchor, f32),
) -> Vec<OutlineCurve> {
    let Ok(font) = FontRef::try_from_slice(FONT) else {
        return Vec::new();
    };
    let scale = size / font.units_per_em().unwrap_or(1000.0);
    let ids: Vec<_> = text.chars().map(|letter| font.glyph_id(letter)).collect();
    let advance = |id: &_| font.h_advance_unscaled(*id) * scale;
    let width: f32 = ids.iter().map(advance).sum();
    let mut x = match anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => -0.5 * width,
        Anchor::End => -width,
    };
    let (sin, cos) = libm::sincosf(turn_deg.to_radians());
    let mut curves = Vec::new();
    for id in &ids {
        // A font's y points up.
        let put = |p: Point| {
            let [dx, dy] = [x + p.x * scale, -p.y * scale];
            point(at.x + dx * cos - dy * sin, at.y + dx * sin + dy * cos)
        };
        let outline = font.outline(*id).map(|outline| outline.curves);
        curves.extend(outline.into_iter().flatten().map(|curve| match curve {
            OutlineCurve::Line(a, b) => OutlineCurve::Line(put(a), put(b)),
            OutlineCurve::Quad(a, b, c) => OutlineCurve::Quad(put(a), put(b), put(c)),
            OutlineCurve::Cubic(a, b, c, d) => OutlineCurve::Cubic(put(a), put(b), put(c), put(d)),
        }));
        x += advance(id);
    }
    curves
}

/// The rectangle of a line, and half its width beyond each end, so that lines meet without a gap.
fn around(a: Point, b: Point, half: f32) -> Vec<OutlineCurve> {
    let length = libm::hypotf(b.x - a.x, b.y - a.y);
    if length <= 0.0 {
        return Vec::new();
    }
    let [dx, dy] = [(b.x - a.x) * half / length, (b.y - a.y) * half / length];
    polygon(&[
        point(a.x - dx - dy, a.y - dy + dx),
        point(b.x + dx - dy, b.y + dy + dx),
        point(b.x + dx + dy, b.y + dy - dx),
        point(a.x - dx + dy, a.y - dy - dx),
    ])
}

fn polygon(points: &[Point]) -> Vec<OutlineCurve> {
    let next = points.iter().cycle().skip(1);
    let sides = points.iter().zip(next);
    sides.map(|(a, b)| OutlineCurve::Line(*a, *b)).collect()
}

/// Fills what outlines enclose, smooth at its rim.
fn fill(image: &mut RgbImage, curves: &[OutlineCurve], color: &str, opacity: f32) {
    let points = curves.iter().flat_map(|curve| match curve {
        OutlineCurve::Line(a, b) => vec![*a, *b],
        OutlineCurve::Quad(a, b, c) => vec![*a, *b, *c],
        OutlineCurve::Cubic(a, b, c, d) => vec![*a, *b, *c, *d],
    });
    let mut ends: Option<[Point; 2]> = None;
    for p in points {
        let [low, high] = ends.unwrap_or([p, p]);
        ends = Some([
            point(low.x.min(p.x), low.y.min(p.y)),
            point(high.x.max(p.x), high.y.max(p.y)),
        ]);
    }
    let Some([low, high]) = ends else { return };
    let corner = point(low.x.floor() - 1.0, low.y.floor() - 1.0);
    let side = |length: f32| usize::try_from(whole(length + 3.0)).unwrap_or(0);
    let size = [side(high.x - corner.x), side(high.y - corner.y)];
    let mut rasterizer = Rasterizer::new(size[0], size[1]);
    for curve in curves {
        let at = |p: &Point| point(p.x - corner.x, p.y - corner.y);
        match curve {
            OutlineCurve::Line(a, b) => rasterizer.draw_line(at(a), at(b)),
            OutlineCurve::Quad(a, b, c) => rasterizer.draw_quad(at(a), at(b), at(c)),
            OutlineCurve::Cubic(a, b, c, d) => {
                rasterizer.draw_cubic(at(a), at(b), at(c), at(d));
            }
        }
    }
    let color = rgb(color);
    rasterizer.for_each_pixel_2d(|x, y, coverage| {
        let place = |corner: f32, k: u32| u32::try_from(signed(corner) + i64::from(k)).ok();
        let place = place(corner.x, x).zip(place(corner.y, y));
        let Some(pixel) = place.and_then(|(x, y)| image.get_pixel_mut_checked(x, y)) else {
            return;
        };
        let share = coverage.clamp(0.0, 1.0) * opacity;
        for (own, new) in pixel.0.iter_mut().zip(color) {
            let mixed = f32::from(*own) * (1.0 - share) + f32::from(new) * share;
            *own = u8::try_from(whole(mixed.round())).unwrap_or(255);
        }
    });
}

/// `#rrggbb`; black where it is none.
fn rgb(color: &str) -> [u8; 3] {
    let hex = color.trim_start_matches('#');
    [0, 2, 4].map(|at| {
        let pair = hex.get(at..at + 2);
        pair.and_then(|pair| u8::from_str_radix(pair, 16).ok())
            .unwrap_or(0)
    })
}

#[expect(clippy::cast_possible_truncation, reason = "px, far below 2^24")]
fn float(px: f64) -> f32 {
    px as f32
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "px of a sheet: a cast that saturates"
)]
fn whole(px: f32) -> u32 {
    px as u32
}

#[expect(clippy::cast_possible_truncation, reason = "px of a sheet")]
fn signed(px: f32) -> i64 {
    px as i64
}
