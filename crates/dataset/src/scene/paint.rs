//! A small painter over `tiny-skia`.
//!
//! What comes out is a filled picture and, for each object that is drawn
//! between [`Painter::begin_object`] and [`Painter::end_object`], the box that
//! bounds everything filled for it.

use image::RgbImage;
use tiny_skia::{
    Color, FillRule, GradientStop, LinearGradient, Paint, Path, Pixmap, Point, RadialGradient,
    Rect, Shader, SpreadMode, Transform,
};

use super::camera::{Board, HEIGHT_PX, Point3, WIDTH_PX, project, shadow_of};
use super::shape::Shape;

/// A color with opacity, each part from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tint {
    pub(super) red: f32,
    pub(super) green: f32,
    pub(super) blue: f32,
    pub(super) opacity: f32,
}

/// An opaque color from 0xRRGGBB.
pub(super) fn rgb(hex: u32) -> Tint {
    let [_, red, green, blue] = hex.to_be_bytes();
    Tint {
        red: f32::from(red) / 255.0,
        green: f32::from(green) / 255.0,
        blue: f32::from(blue) / 255.0,
        opacity: 1.0,
    }
}

impl Tint {
    /// This color, `share` of the way to another; the opacity stays.
    pub(super) fn mix(self, other: Self, share: f32) -> Self {
        Self {
            red: self.red + (other.red - self.red) * share,
            green: self.green + (other.green - self.green) * share,
            blue: self.blue + (other.blue - self.blue) * share,
            opacity: self.opacity,
        }
    }

    /// This color in a warm light (positive) or in a blue shade (negative).
    pub(super) fn lit(self, amount: f32) -> Self {
        if amount >= 0.0 {
            self.mix(rgb(0x00FF_F8E8), amount)
        } else {
            self.mix(rgb(0x0012_182A), -amount)
        }
    }

    /// This color with another opacity.
    pub(super) fn clear(self, opacity: f32) -> Self {
        Self { opacity, ..self }
    }

    fn color(self) -> Color {
        Color::from_rgba(
            self.red.clamp(0.0, 1.0),
            self.green.clamp(0.0, 1.0),
            self.blue.clamp(0.0, 1.0),
            self.opacity.clamp(0.0, 1.0),
        )
        .unwrap_or(Color::TRANSPARENT)
    }
}

/// How an outline is filled; gradients span the outline's own bounds.
#[derive(Clone, Copy, Debug)]
pub(super) enum Ink {
    /// One color.
    Flat(Tint),
    /// From the top edge to the bottom edge.
    Down(Tint, Tint),
    /// From the top edge over the middle to the bottom edge.
    Down3(Tint, Tint, Tint),
    /// From the left edge to the right edge.
    Across(Tint, Tint),
    /// From the upper left corner to the lower right one.
    Slant(Tint, Tint),
    /// From the middle outward.
    Glow(Tint, Tint),
}

/// The picture being drawn.
pub(super) struct Painter {
    pixmap: Pixmap,
    /// How much of the haze color lies over what is drawn now, 0 to 1.
    haze: f32,
    drawn: usize,
    left_out: Option<usize>,
    tracking: bool,
    bounds_px: Option<Rect>,
}

const HAZE_HEX: u32 = 0x00D3_E2EE;
const HAZE_REACH_M: f32 = 125.0;

impl Painter {
    /// An empty picture; `left_out` names an object that is to be skipped.
    pub(super) fn new(left_out: Option<usize>) -> Option<Self> {
        Some(Self {
            pixmap: Pixmap::new(WIDTH_PX, HEIGHT_PX)?,
            haze: 0.0,
            drawn: 0,
            left_out,
            tracking: false,
            bounds_px: None,
        })
    }

    /// From now on, draws as seen through the air over a distance.
    pub(super) fn set_distance(&mut self, ahead_m: f32) {
        self.haze = 1.0 - libm::expf(-(ahead_m - 8.0).max(0.0) / HAZE_REACH_M);
    }

    /// From now on, what is filled belongs to one labelled object.
    pub(super) fn begin_object(&mut self) {
        self.tracking = true;
        self.bounds_px = None;
    }

    /// Ends the object; its box (left, top, right, bottom) clipped to the
    /// picture, or nothing when none of it is inside.
    pub(super) fn end_object(&mut self) -> Option<[f64; 4]> {
        self.tracking = false;
        self.drawn += 1;
        let bounds = self.bounds_px.take()?;
        let [width_px, height_px] = [WIDTH_PX, HEIGHT_PX].map(f64::from);
        let bbox = [
            f64::from(bounds.left()).clamp(0.0, width_px),
            f64::from(bounds.top()).clamp(0.0, height_px),
            f64::from(bounds.right()).clamp(0.0, width_px),
            f64::from(bounds.bottom()).clamp(0.0, height_px),
        ];
        (bbox[2] > bbox[0] && bbox[3] > bbox[1]).then_some(bbox)
    }

    /// Fills an outline given in pixels.
    pub(super) fn fill_px(&mut self, shape: &Shape, ink: Ink) {
        self.fill_path(shape.path(&|point| point), ink);
    }

    /// Fills an outline after a mapping of its own units to the street.
    pub(super) fn fill(&mut self, shape: &Shape, ink: Ink, place: &dyn Fn([f32; 2]) -> Point3) {
        self.fill_path(shape.path(&|point| project(place(point))), ink);
    }

    /// Fills an outline drawn in metres on an upright board.
    pub(super) fn fill_board(&mut self, shape: &Shape, ink: Ink, board: &Board) {
        self.fill(shape, ink, &|point| board.at(point));
    }

    /// Darkens the ground where the sun throws an outline's shadow.
    pub(super) fn shadow(
        &mut self,
        shape: &Shape,
        opacity: f32,
        place: &dyn Fn([f32; 2]) -> Point3,
    ) {
        let path = shape.path(&|point| project(shadow_of(place(point))));
        self.fill_path(path, Ink::Flat(rgb(0x0014_1A2C).clear(opacity)));
    }

    fn fill_path(&mut self, path: Option<Path>, ink: Ink) {
        let Some(path) = path else { return };
        let bounds = path.bounds();
        if self.tracking {
            self.bounds_px = match self.bounds_px {
                None => Some(bounds),
                Some(old) => old.join(&bounds).or(Some(old)),
            };
            if self.left_out == Some(self.drawn) {
                return;
            }
        }
        let Some(shader) = self.shader(ink, bounds) else {
            return;
        };
        let paint = Paint {
            shader,
            anti_alias: true,
            ..Paint::default()
        };
        self.pixmap.fill_path(
            &path,
            &paint,
            FillRule::Winding,
            Transform::identity(),
            None,
        );
    }

    fn shader(&self, ink: Ink, bounds: Rect) -> Option<Shader<'static>> {
        let air = |tint: Tint| tint.mix(rgb(HAZE_HEX), self.haze).color();
        let (left, top, right, bottom) =
            (bounds.left(), bounds.top(), bounds.right(), bounds.bottom());
        let line = |from: [f32; 2], to: [f32; 2], tints: &[Tint]| {
            LinearGradient::new(
                Point::from_xy(from[0], from[1]),
                Point::from_xy(to[0], to[1]),
                stops(tints, &air),
                SpreadMode::Pad,
                Transform::identity(),
            )
        };
        match ink {
            Ink::Flat(tint) => Some(Shader::SolidColor(air(tint))),
            Ink::Down(a, b) => line([left, top], [left, bottom], &[a, b]),
            Ink::Down3(a, b, c) => line([left, top], [left, bottom], &[a, b, c]),
            Ink::Across(a, b) => line([left, top], [right, top], &[a, b]),
            Ink::Slant(a, b) => line([left, top], [right, bottom], &[a, b]),
            Ink::Glow(a, b) => {
                let (width_px, height_px) = (bounds.width().max(0.01), bounds.height().max(0.01));
                let center = Point::from_xy((left + right) / 2.0, (top + bottom) / 2.0);
                // A round gradient squeezed to the outline's proportions.
                let squeeze = Transform::from_row(
                    1.0,
                    0.0,
                    0.0,
                    height_px / width_px,
                    0.0,
                    center.y * (1.0 - height_px / width_px),
                );
                RadialGradient::new(
                    center,
                    0.0,
                    center,
                    width_px / 2.0,
                    stops(&[a, b], &air),
                    SpreadMode::Pad,
                    squeeze,
                )
            }
        }
    }

    /// The finished picture without its opacity.
    pub(super) fn into_image(self) -> RgbImage {
        let mut image = RgbImage::new(WIDTH_PX, HEIGHT_PX);
        for (target, source) in image.pixels_mut().zip(self.pixmap.pixels()) {
            target.0 = [source.red(), source.green(), source.blue()];
        }
        image
    }
}

fn stops(tints: &[Tint], air: &dyn Fn(Tint) -> Color) -> Vec<GradientStop> {
    let mut position = 0.0;
    let step = if tints.len() == 3 { 0.5 } else { 1.0 };
    let mut list = Vec::with_capacity(tints.len());
    for &tint in tints {
        list.push(GradientStop::new(position, air(tint)));
        position += step;
    }
    list
}
