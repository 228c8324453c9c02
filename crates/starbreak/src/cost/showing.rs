//! What it takes to show cracks, or a photograph of them, and what lies on the glass.

use starbreak_deposit::{Cap, Coat};
use starbreak_glass::{CrackNetwork, LengthUnit};
use starbreak_optics::View;
use starbreak_optics::paper::PaperOptics;
use starbreak_optics::physical::PhysicalOptics;
use starbreak_optics::screens::Screen;

use super::touched::Touched;
use super::{Cost, Part};
use crate::{CameraFaults, OpticsSettings, Scene, Settings};

/// Bytes of a pixel: image and masks; what a layer of the physical optics and the paper's hold of one
/// that a crack touches; what an image out of focus as a whole takes, and the maps.
const FRAME_BYTES: f64 = 12.0;
const TOUCHED_BYTES: f64 = 160.0;
const DRAWN_BYTES: f64 = 40.0;
const WHOLE_BYTES: f64 = 30.0;
const MAP_BYTES: f64 = 80.0;

/// Bytes of a pixel in a camera with faults: its light before and after, what the mosaic adds, and the image as it was.
const FAULT_BYTES: f64 = 64.0;

/// Bytes of a pixel whose light is kept in linear numbers, with a copy, behind glass that is not broken.
const LIGHT_BYTES: f64 = 30.0;

/// Bytes of a cell of a coat: what it does there, and its maps, of which those of coats that are made already remain; of a
/// pixel, copies of the frame that are blurred ever more, where a film turns light.
const COAT_BYTES: f64 = 130.0;
const MADE_COAT_BYTES: f64 = 80.0;
const FILM_BYTES: f64 = 40.0;

/// Bytes of all drops, however few, of each, and of a pixel that shows one.
const DROPS_BYTES: f64 = 5e7;
const DROP_BYTES: f64 = 600.0;
const WET_BYTES: f64 = 130.0;

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
    /// What it takes to show a network in a frame, by the optics, and what lies on the glass: drops as a view shows them,
    /// where the recipe has any.
    #[must_use]
    pub fn cost_of_showing(
        &self,
        network: &CrackNetwork,
        view: &View,
        drops: Option<(&[Cap], &View)>,
    ) -> Cost {
        self.cost_of_showing_with(network, view, drops.and_then(|drops| self.of_drops(drops)))
    }

    /// No less than [`Settings::cost_of_showing`], without looking at each drop: as if they were all over the frame.
    pub(super) fn most_of_showing(
        &self,
        network: &CrackNetwork,
        view: &View,
        drops: Option<(&[Cap], &View)>,
    ) -> Cost {
        let of_drops = drops.map(|(caps, view)| {
            #[expect(clippy::cast_precision_loss, reason = "a number of drops")]
            let n = caps.len() as f64;
            (drops_bytes(n, area_px(view.size())), SMALLER_IMAGE)
        });
        self.cost_of_showing_with(network, view, of_drops)
    }

    fn cost_of_showing_with(
        &self,
        network: &CrackNetwork,
        view: &View,
        of_drops: Option<Part>,
    ) -> Cost {
        let area_px = area_px(view.size());
        let is_broken = network.n_segments() > 0;
        let mut parts: Vec<Part> = vec![(FRAME_BYTES * area_px, SMALLER_IMAGE)];
        parts.extend(self.of_faults(area_px, is_broken));
        parts.extend(self.of_coats(view));
        parts.extend(of_drops);
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
        Cost::of(self.shown(is_broken), &parts)
    }

    /// What it takes to show a photograph of broken glass in a frame of this size.
    #[must_use]
    pub fn cost_of_photo(&self, size: (u32, u32)) -> Cost {
        let [width, height] = [size.0, size.1].map(f64::from);
        let area_px = area_px(size);
        let frame = (FRAME_BYTES * area_px, SMALLER_IMAGE);
        let OpticsSettings::Physical(optics) = &self.optics else {
            let mut parts = vec![frame, (DRAWN_BYTES * area_px, SMALLER_IMAGE)];
            parts.extend(self.of_faults(area_px, true));
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
        parts.extend(self.of_faults(area_px, true));
        parts.extend(
            Scene::of(self, size)
                .sheet()
                .ok()
                .and_then(|view| self.of_coats(&view)),
        );
        Cost::of("showing the photograph of glass", &parts)
    }

    /// What is shown.
    fn shown(&self, is_broken: bool) -> &'static str {
        match (is_broken, self.drops.is_some(), self.coats.is_empty()) {
            (true, false, true) => "showing the cracks",
            (true, ..) => "showing the cracks and what lies on the glass",
            (false, true, true) => "showing the drops on the glass",
            (false, true, false) => "showing the drops and what else lies on the glass",
            (false, false, false) => "showing what lies on the glass",
            (false, false, true) => "making the picture",
        }
    }

    /// What a camera with a fault takes; one that only knows lamps brighter than white keeps light.
    fn of_faults(&self, area_px: f64, is_broken: bool) -> Option<Part> {
        let has_fault = !(self.faults.as_ref()).is_none_or(CameraFaults::is_empty);
        let bytes = match has_fault || (is_broken && self.faults.is_some()) {
            true => FAULT_BYTES,
            false if self.faults.is_some() || !self.coats.is_empty() => LIGHT_BYTES,
            false => return None,
        };
        Some((bytes * area_px, SMALLER_IMAGE))
    }

    /// What coats on the pane that a view shows take.
    fn of_coats(&self, view: &View) -> Option<Part> {
        let OpticsSettings::Physical(optics) = &self.optics else {
            return None;
        };
        let n_made = u32::try_from(self.coats.len().checked_sub(1)?).unwrap_or(u32::MAX);
        let cell_px = f64::from(Screen::cell_px(view, &optics.lens, self.f_px(view)));
        let turns = self.coats.iter().any(|coat| matches!(coat, Coat::Film(_)));
        let film_bytes = if turns { FILM_BYTES } else { 0.0 };
        let of_cell = COAT_BYTES + MADE_COAT_BYTES * f64::from(n_made);
        let bytes = of_cell / (cell_px * cell_px) + film_bytes;
        Some((bytes * area_px(view.size()), SMALLER_IMAGE))
    }

    /// What drops on the pane that a view shows take.
    fn of_drops(&self, (caps, view): (&[Cap], &View)) -> Option<Part> {
        let OpticsSettings::Physical(optics) = &self.optics else {
            return None;
        };
        let f_px = self.f_px(view);
        let frame = Frame { view, optics, f_px };
        let mut touched = Touched::by_small(view.size());
        let mut n = 0.0;
        for cap in caps {
            if let (Some(disc), Some([u, v]), Some(px_per_mm)) = (
                frame.disc_px(cap.at_mm),
                view.project(cap.at_mm),
                view.px_per_unit(cap.at_mm),
            ) {
                n += 1.0;
                let radius = cap.radius_mm * cap.outline.reach() * px_per_mm;
                touched.mark_line([u, v, u, v], disc + radius);
            }
        }
        let wet_px = area_px(view.size()) * touched.share();
        Some((drops_bytes(n, wet_px), SMALLER_IMAGE))
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

/// What so many drops that are seen take, on so many pixels.
fn drops_bytes(n: f64, wet_px: f64) -> f64 {
    DROPS_BYTES + DROP_BYTES * n + WET_BYTES * wet_px
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
        let pit_mm = impact.pit_radius_mm(optics.glass.thickness_mm);
        let around = AROUND_HIT.max(optics.surface.film).max(optics.surface.chip);
        let place = [impact.x, impact.y];
        if let (Some(reach), Some([u, v]), Some(px_per_mm)) = (
            frame.reach_px(place),
            view.project(place),
            view.px_per_unit(place),
        ) && pit_mm > 0.0
        {
            let radius = pit_mm * around.max(optics.surface.crushed_zone) * px_per_mm;
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
    /// The radius of the disc of a place of the pane, px.
    fn disc_px(&self, point: [f64; 2]) -> Option<f64> {
        // Across the rake a mm is f/z px.
        let [[px_per_mm, _], _] = self.view.jacobian(point)?;
        let distance_m = 1e-3 * self.f_px / px_per_mm;
        let lens = &self.optics.lens;
        Some(0.5 * lens.circle_of_confusion_px(self.f_px, distance_m).abs())
    }

    /// The same, and how far a crack is seen to go from there, px.
    fn reach_px(&self, point: [f64; 2]) -> Option<f64> {
        let [[px_per_mm, _], _] = self.view.jacobian(point)?;
        Some(self.disc_px(point)? + SLANT * self.optics.glass.thickness_mm * px_per_mm)
    }
}
