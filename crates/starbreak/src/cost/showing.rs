//! What it takes to show cracks or a photograph of them.

use starbreak_glass::{CrackNetwork, LengthUnit};
use starbreak_optics::View;
use starbreak_optics::paper::PaperOptics;
use starbreak_optics::physical::PhysicalOptics;

use super::touched::Touched;
use super::{Cost, Part};
use crate::{OpticsSettings, Settings};

/// Bytes of a pixel: image and masks; what a layer of the physical optics and the paper's hold of one
/// that a crack touches; what an image out of focus as a whole takes, and the maps.
const FRAME_BYTES: f64 = 12.0;
const TOUCHED_BYTES: f64 = 160.0;
const DRAWN_BYTES: f64 = 40.0;
const WHOLE_BYTES: f64 = 30.0;
const MAP_BYTES: f64 = 80.0;

/// Bytes of a pixel in a camera with faults: its light before and after, what the mosaic adds, and the image as it was.
const FAULT_BYTES: f64 = 64.0;

/// A coat: what it does in each cell, its maps, and copies of the frame.
const COAT_BYTES: f64 = 280.0;

/// Bytes of the most drops.
const DROPS_BYTES: f64 = 2e8;

/// Bytes of a piece of crack: its facets and what they are made from.
const PIECE_BYTES: f64 = 1500.0;

/// Bytes of a photograph of glass per pixel of the frame and of the margin of its discs, whose reach
/// over their radius, and pixels beyond, are those of the optics.
const PHOTO_BYTES: f64 = 56.0;
const PHOTO_REACH: f64 = 1.56;
const PHOTO_SPARE_PX: f64 = 20.0;

/// A scene or glass out of focus by less, px of radius, is sharp.
const SHARP_PX: f64 = 0.05;

/// How far sideways a crack is seen to go into the ply, and its ghost beyond, over its thickness.
const SLANT: f64 = 0.8;

/// Radius of what surrounds a hit over the radius of its crushed zone.
const AROUND_HIT: f64 = 2.0;

const SMALLER_IMAGE: &str = "take smaller images";
const SMALLER_DISC: &str = "take smaller images, or make the discs of the glass smaller (raise camera.f_number or \
                            glass.distance_m)";
const FEWER_PIECES: &str = "break the glass into fewer pieces (lower impact.count, glass.width_mm or glass.surface_compression_mpa)";
const NO_MAPS: &str = "set output.maps = false, or take smaller images";

impl Settings {
    /// What it takes to show a network in a frame, by the optics.
    #[must_use]
    pub fn cost_of_showing(&self, network: &CrackNetwork, view: &View) -> Cost {
        let area_px = area_px(view.size());
        let mut parts: Vec<Part> = vec![(FRAME_BYTES * area_px, SMALLER_IMAGE)];
        parts.extend(self.of_faults(area_px));
        parts.extend(self.of_coats(area_px));
        parts.extend(self.of_drops(area_px));
        match &self.optics {
            OpticsSettings::Paper(optics) => {
                let touched = touched_by_lines(network, view, optics);
                parts.push((DRAWN_BYTES * area_px * touched, SMALLER_IMAGE));
            }
            OpticsSettings::Physical(optics) => {
                let (touched, n_pieces) = touched_by_discs(network, view, optics, self.f_px(view));
                parts.push((TOUCHED_BYTES * area_px * touched, SMALLER_DISC));
                if optics.surface.fragment_wedge_deg > 0.0 {
                    parts.push((TOUCHED_BYTES * area_px, "set optics.fragment_wedge_deg = 0"));
                }
                parts.push((PIECE_BYTES * n_pieces, FEWER_PIECES));
                parts.extend(self.of_whole(optics, area_px, self.f_px(view)));
            }
        }
        Cost::of("showing the cracks", &parts)
    }

    /// What it takes to show a photograph of broken glass in a frame of this size.
    #[must_use]
    pub fn cost_of_photo(&self, size: (u32, u32)) -> Cost {
        let [width, height] = [size.0, size.1].map(f64::from);
        let area_px = area_px(size);
        let frame = (FRAME_BYTES * area_px, SMALLER_IMAGE);
        let OpticsSettings::Physical(optics) = &self.optics else {
            let mut parts = vec![frame, (DRAWN_BYTES * area_px, SMALLER_IMAGE)];
            parts.extend(self.of_faults(area_px));
            parts.extend(self.of_coats(area_px));
            return Cost::of("showing the photograph of glass", &parts);
        };
        let distance_m = self.fracture.mount().map_or(1.0, |mount| mount.distance_m);
        let f_px = self.camera.f_px.of_frame(size.0);
        // A raked pane is nearer on one side.
        let radius_px = optics.lens.circle_of_confusion_px(f_px, distance_m).abs();
        let margin = if radius_px < SHARP_PX {
            0.0
        } else {
            (PHOTO_REACH * radius_px).min(width.max(height)) + PHOTO_SPARE_PX
        };
        let spread_px = (width + 2.0 * margin) * (height + 2.0 * margin);
        let mut parts = vec![frame, (PHOTO_BYTES * spread_px, SMALLER_DISC)];
        parts.extend(self.of_whole(optics, area_px, f_px));
        parts.extend(self.of_faults(area_px));
        parts.extend(self.of_coats(area_px));
        Cost::of("showing the photograph of glass", &parts)
    }

    /// What a camera with a fault takes.
    fn of_faults(&self, area_px: f64) -> Option<Part> {
        let part = (FAULT_BYTES * area_px, SMALLER_IMAGE);
        self.faults.is_some().then_some(part)
    }

    /// What coats on the pane take.
    fn of_coats(&self, area_px: f64) -> Option<Part> {
        let n = u32::try_from(self.coats.len()).unwrap_or(u32::MAX);
        let part = (COAT_BYTES * f64::from(n) * area_px, SMALLER_IMAGE);
        (n > 0).then_some(part)
    }

    /// What drops on the pane take.
    fn of_drops(&self, area_px: f64) -> Option<Part> {
        let part = (
            DROPS_BYTES + TOUCHED_BYTES * area_px,
            "set drops.rain_mm_h = 0",
        );
        self.drops.is_some().then_some(part)
    }

    /// What changes every pixel, and the maps.
    fn of_whole(
        &self,
        optics: &PhysicalOptics,
        area_px: f64,
        f_px: f64,
    ) -> impl Iterator<Item = Part> + use<> {
        let lens = &optics.lens;
        let scene_px = 0.5 * lens.circle_of_confusion_px(f_px, lens.scene_m).abs();
        let is_whole = scene_px >= SHARP_PX || optics.veiling_glare > 0.0;
        let whole = is_whole.then_some((WHOLE_BYTES * area_px, SMALLER_IMAGE));
        let maps = self.output.maps.then_some((MAP_BYTES * area_px, NO_MAPS));
        whole.into_iter().chain(maps)
    }

    fn f_px(&self, view: &View) -> f64 {
        self.camera.f_px.of_frame(view.size().0)
    }
}

fn area_px((width, height): (u32, u32)) -> f64 {
    f64::from(width) * f64::from(height)
}

/// Share of the frame that the paper's lines may touch.
fn touched_by_lines(network: &CrackNetwork, view: &View, optics: &PaperOptics) -> f64 {
    let within_px = 0.5 * optics.line_width_px + f64::from(optics.blur_radius_px()) + 1.0;
    let mut touched = Touched::new(view.size());
    for k in 0..network.n_segments() {
        if let Some(line) = view.visible(network.ends(k), within_px) {
            touched.mark_line(line, within_px);
        }
    }
    touched.share()
}

/// Share of the frame that the discs of cracks and hits may touch, and number of pieces within reach.
fn touched_by_discs(
    network: &CrackNetwork,
    view: &View,
    optics: &PhysicalOptics,
    f_px: f64,
) -> (f64, f64) {
    let frame = Frame { view, optics, f_px };
    let data = network.data();
    let mut touched = Touched::new(view.size());
    let mut n_pieces = 0.0;
    for k in 0..network.n_segments() {
        let ends = network.ends(k);
        let line = match data.unit {
            LengthUnit::Mm => {
                let middle = [0.5 * (ends[0] + ends[2]), 0.5 * (ends[1] + ends[3])];
                frame
                    .reach_px(middle)
                    .and_then(|reach| Some((view.visible(ends, reach)?, reach)))
            }
            // Over the frame, whatever the pane.
            LengthUnit::Px => {
                let [width, height] = [view.size().0, view.size().1].map(f64::from);
                let scale = [width / data.pane.width, height / data.pane.height];
                let line = [0, 1, 2, 3].map(|at: usize| ends[at] * scale[at % 2]);
                let middle = [0.5 * (line[0] + line[2]), 0.5 * (line[1] + line[3])];
                (view.unproject(middle))
                    .and_then(|point| frame.reach_px(point))
                    .map(|reach| (line, reach))
            }
        };
        if let Some((line, reach)) = line {
            n_pieces += 1.0;
            touched.mark_line(line, reach);
        }
    }
    for impact in &data.impacts {
        let crushed_mm = impact.crushed_radius_mm.unwrap_or(0.0);
        let around = AROUND_HIT.max(optics.surface.film).max(optics.surface.chip);
        let place = [impact.x, impact.y];
        if let (Some(reach), Some([u, v]), Some(px_per_mm)) = (
            frame.reach_px(place),
            view.project(place),
            view.px_per_unit(place),
        ) && crushed_mm > 0.0
        {
            let radius = crushed_mm * around.max(optics.surface.crushed_zone) * px_per_mm;
            touched.mark_line([u, v, u, v], reach + radius);
        }
    }
    (touched.share(), n_pieces)
}

/// A frame, and how far from its place in it something of the glass is seen.
struct Frame<'a> {
    view: &'a View,
    optics: &'a PhysicalOptics,
    f_px: f64,
}

impl Frame<'_> {
    /// The radius of the disc of a place of the pane, and how far a crack is seen to go from it, px.
    fn reach_px(&self, point: [f64; 2]) -> Option<f64> {
        // Across the rake a mm is f/z px.
        let [[px_per_mm, _], _] = self.view.jacobian(point)?;
        let distance_m = 1e-3 * self.f_px / px_per_mm;
        let lens = &self.optics.lens;
        let radius_px = 0.5 * lens.circle_of_confusion_px(self.f_px, distance_m).abs();
        Some(radius_px + SLANT * self.optics.glass.thickness_mm * px_per_mm)
    }
}
