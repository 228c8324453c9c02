//! A crack before a camera, baked: what each pixel loses, and which light it gains.

use std::sync::{Arc, Mutex, PoisonError};

use image::GrayImage;
use starbreak_deposit::Deposit;
use starbreak_glass::CrackNetwork;
use starbreak_seed::Seed;

use super::layer::{PatternLayer, Spread};
use super::{Overlay, PhysicalOptics};
use crate::environment::{Dashboard, Environment, HemisphereWeights};
use crate::interface::gap::GapTable;
use crate::lens::Lens;
use crate::maps::{CHUNK, Facet, LaneRuns, Pupil, Reaching, cover, spread};
use crate::surface::{
    Drops, Facets, KeptDrops, LANES, LightFrom, N_SHARES, SeenBy, SheetView, crack_facets,
    fragment_facets, hit_facets,
};
use crate::{OpticsError, View};

/// A crack network before one camera, ready for any image of the camera's size.
///
/// It holds no light yet: each pixel has its shares of the light of the sky, the ground, the
/// cabin, the sun and other places of the frame. [`Pattern::light`] gives it the light of an
/// environment. One pattern serves all frames of a video, and all images of a bank.
#[derive(Debug, Clone)]
pub struct Pattern {
    size: (u32, u32),
    f_px: f64,
    /// What is rendered one after the other: fragments, then cracks and hits.
    layers: Vec<PatternLayer>,
    outline: Outline,
    dashboard: Dashboard,
}

/// What is known of where the cracks would be in focus.
#[derive(Debug, Clone)]
pub(crate) enum Outline {
    /// The corners of the facets.
    Corners(Vec<[[f64; 2]; 4]>),
    /// Their coverage, as codes of a mask.
    Codes(LaneRuns<1>),
}

/// Bakes a network as far as it has grown at `time` (in the unit of its arrival column; infinity
/// for all of it).
///
/// The seed places what the network leaves open: grains of crushed glass, chips, wedges.
///
/// # Errors
/// [`OpticsError::Parameter`] for a parameter out of range, [`OpticsError::NoCamera`] for a view
/// of a stretched pane.
pub fn bake(
    network: &CrackNetwork,
    time: f64,
    view: &View,
    optics: &PhysicalOptics,
    seed: Seed,
) -> Result<Pattern, OpticsError> {
    optics.check()?;
    let sheet = SheetView::new(view, &optics.lens, &optics.glass)?;
    let mut pattern = Pattern {
        size: view.size(),
        f_px: sheet.f_px(),
        layers: Vec::new(),
        outline: Outline::Corners(Vec::new()),
        dashboard: *view.dashboard(),
    };
    if network.n_segments() == 0 || pattern.is_without_pixels() {
        return Ok(pattern);
    }
    let gaps = gap_table(optics.glass.refractive_index);
    let from = light_from(&sheet, optics, &gaps);
    let wedge_rad = optics.surface.fragment_wedge_deg.to_radians();
    let mut fragments = Facets::default();
    fragment_facets(&from, (network, time), wedge_rad, seed, &mut fragments);
    let mut cracks = Facets::default();
    let reach_px = reach_px(&sheet, Pupil::of(&optics.lens).reach());
    crack_facets(&from, network, time, &optics.surface, reach_px, &mut cracks);
    let surface = (&optics.surface, reach_px);
    hit_facets(&from, network, time, surface, seed, &mut cracks);
    pattern.outline = Outline::Corners(std::mem::take(&mut cracks.outlines));
    for facets in [fragments, cracks] {
        let places = Spread::Neighbors(mean_blur_px(&facets.light));
        let light = pattern.spread(&facets.light, &[], &optics.lens);
        let layer = pattern.layer_of(light, &facets.tint, (&optics.lens, places));
        pattern.layers.extend(layer);
    }
    Ok(pattern)
}

/// What is the same for all facets before one camera.
fn light_from<'a>(
    sheet: &'a SheetView,
    optics: &PhysicalOptics,
    gaps: &'a GapTable,
) -> LightFrom<'a> {
    let (_, height) = sheet.view().size();
    let environment = &optics.environment;
    let horizon = environment.horizon(height, sheet.f_px());
    let sun = environment.sun(&horizon);
    let outward = sheet.camera_from_sheet([0.0, 0.0, 1.0]);
    LightFrom {
        sheet,
        horizon,
        fades_over_px: (environment.fades_over() * sheet.f_px()).max(1e-9),
        sun: sheet.sheet_from_camera(sun),
        gaps,
        outside: HemisphereWeights::facing(horizon.sin_elevation(outward)),
        // The mean of a light that runs with the sine, over the half space that a face sees, is
        // that of 2/3 of the sine of its normal.
        inside_high: 0.5 - horizon.sin_elevation(outward) / 3.0,
    }
}

impl Pattern {
    /// Width and height of the frame, px.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// Focal length of the camera, px.
    #[must_use]
    pub fn f_px(&self) -> f64 {
        self.f_px
    }

    /// Whether nothing of a crack is in the frame.
    #[must_use]
    pub fn is_intact(&self) -> bool {
        self.layers.is_empty()
    }

    /// With what lies on the outer face of the glass, which light meets first.
    ///
    /// # Errors
    /// As for [`bake`].
    pub fn behind(
        self,
        deposit: &Deposit,
        view: &View,
        optics: &PhysicalOptics,
    ) -> Result<Self, OpticsError> {
        self.behind_some(deposit, (view, optics), None)
    }

    /// The same, with what is known of drops that were there before.
    ///
    /// # Errors
    /// As for [`bake`].
    pub fn behind_kept(
        self,
        deposit: &Deposit,
        view: &View,
        optics: &PhysicalOptics,
        kept: &KeptDrops,
    ) -> Result<Self, OpticsError> {
        self.behind_some(deposit, (view, optics), Some(kept))
    }

    fn behind_some(
        mut self,
        deposit: &Deposit,
        (view, optics): (&View, &PhysicalOptics),
        kept: Option<&KeptDrops>,
    ) -> Result<Self, OpticsError> {
        optics.check()?;
        let sheet = SheetView::new(view, &optics.lens, &optics.glass)?;
        if deposit.is_empty() || self.is_without_pixels() {
            return Ok(self);
        }
        let gaps = gap_table(optics.glass.refractive_index);
        let from = light_from(&sheet, optics, &gaps);
        let pupil_reach = Pupil::of(&optics.lens).reach();
        let reaches = (reach_px(&sheet, pupil_reach), pupil_reach);
        let caps = &deposit.caps;
        let by = SeenBy {
            view: *view,
            lens: optics.lens,
            glass: optics.glass,
            environment: optics.environment,
        };
        let mut looked = kept.map(|kept| kept.look_for(caps, by));
        let drops = Drops::of(&from, caps, reaches, looked.as_mut());
        if let Some((kept, looked)) = kept.zip(looked) {
            kept.keep(looked, by);
        }
        let light = self.spread(&[], &drops.all(), &optics.lens);
        let layer = self.layer_of(light, &[], (&optics.lens, Spread::Squares));
        self.layers.splice(0..0, layer);
        Ok(self)
    }

    fn is_without_pixels(&self) -> bool {
        self.size.0 == 0 || self.size.1 == 0
    }

    /// The maps of some facets and of what is drawn.
    fn spread(
        &self,
        facets: &[Facet<LANES>],
        drawn: &[Reaching<'_, LANES>],
        lens: &Lens,
    ) -> LaneRuns<LANES> {
        let size = (self.size.0 as usize, self.size.1 as usize);
        self.above_dashboard(spread(facets, drawn, N_SHARES, Pupil::of(lens), size))
    }

    /// What is seen of some maps where a dashboard stands before the pane.
    fn above_dashboard<const L: usize>(&self, maps: LaneRuns<L>) -> LaneRuns<L> {
        match self.dashboard.is_none() {
            true => maps,
            false => maps.times(|at| self.dashboard.glass_in(at, self.size, 1)),
        }
    }

    /// The layer of some maps, with what tints them; none where nothing is in the frame.
    fn layer_of(
        &self,
        light: LaneRuns<LANES>,
        tint: &[Facet<4>],
        (lens, places): (&Lens, Spread),
    ) -> Option<PatternLayer> {
        if light.is_empty() {
            return None;
        }
        let tint = self.above_dashboard(spread(tint, &[], 1, Pupil::of(lens), light.size()));
        Some(PatternLayer::of_sums(light, &tint, places))
    }

    /// A pattern from what it was taken apart to.
    pub(crate) fn from_parts(
        size: (u32, u32),
        f_px: f64,
        layers: Vec<PatternLayer>,
        outline: Outline,
    ) -> Self {
        Self {
            size,
            f_px,
            layers,
            outline,
            dashboard: Dashboard::default(),
        }
    }

    pub(crate) fn outline(&self) -> &Outline {
        &self.outline
    }

    pub(crate) fn layers(&self) -> &[PatternLayer] {
        &self.layers
    }

    /// The pattern under the light of an environment, ready to be put over images.
    #[must_use]
    pub fn light(&self, environment: &Environment, optics: &PhysicalOptics) -> Overlay {
        Overlay::new(self, environment, optics, None)
    }

    /// As [`Pattern::light`], in the memory of an overlay that is no longer needed: nothing is allocated where that was
    /// of the same pattern.
    #[must_use]
    pub fn light_in(
        &self,
        memory: Overlay,
        environment: &Environment,
        optics: &PhysicalOptics,
    ) -> Overlay {
        Overlay::new(self, environment, optics, Some(memory))
    }

    /// Coverage of the frame by cracks, crushed glass and chips, as if all were in focus.
    #[must_use]
    pub fn coverage(&self) -> GrayImage {
        match &self.outline {
            Outline::Corners(outlines) => self.covered_by(outlines),
            Outline::Codes(codes) => code_mask(self.size, codes),
        }
    }

    fn covered_by(&self, outlines: &[[[f64; 2]; 4]]) -> GrayImage {
        let (width, height) = self.size;
        let mut mask = GrayImage::new(width, height);
        let pixels = mask.as_mut();
        let size = (width as usize, height as usize);
        cover(outlines, size, |y, x, shares| {
            let row = &mut pixels[y * size.0 + x..];
            for ((pixel, share), x) in row.iter_mut().zip(shares).zip(x..) {
                let share = share * self.dashboard.glass_in([x, y], self.size, 1);
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "a share as a code"
                )]
                let code = (share.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
                *pixel = code;
            }
        });
        mask
    }
}

/// A mask of codes; 0 where there is no run.
pub(crate) fn code_mask(size: (u32, u32), codes: &LaneRuns<1>) -> GrayImage {
    let mut mask = GrayImage::new(size.0, size.1);
    let width = size.0 as usize;
    for (x, y, [run]) in codes.iter() {
        let row = &mut mask.as_mut()[y * width..(y + 1) * width];
        for (pixel, code) in row.iter_mut().skip(x).take(CHUNK).zip(run) {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "`as` clamps to a code"
            )]
            let code = code.round() as u8;
            *pixel = code;
        }
    }
    mask
}

/// Mean radius of the discs of some facets, px.
fn mean_blur_px(facets: &[Facet<LANES>]) -> f32 {
    let sum: f64 = facets.iter().map(|facet| facet.radius_px.abs()).sum();
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_precision_loss,
        reason = "a mean as f32"
    )]
    let mean = (sum / facets.len().max(1) as f64) as f32;
    mean
}

/// How far beyond the frame a crack may lie and still reach into it, px: the largest blur at the
/// frame's corners, by a pupil that reaches so many of its radii from its middle, and the parallax of the sheet.
fn reach_px(sheet: &SheetView, pupil_reach: f64) -> f64 {
    let (width, height) = sheet.view().size();
    let (width, height) = (f64::from(width), f64::from(height));
    let corners = [[0.0, 0.0], [width, 0.0], [0.0, height], [width, height]];
    let mut reach = 0.0_f64;
    for corner in corners {
        if let Some(point) = sheet.view().unproject(corner)
            && let Some(radius) = sheet.blur_radius_px(point, 0.0)
            && let Some([u, v]) = sheet.project(point, sheet.outer_mm(), [0.0; 2])
        {
            let parallax = (u - corner[0]).abs().max((v - corner[1]).abs());
            reach = reach.max(pupil_reach * radius.abs() + parallax);
        }
    }
    let axis = sheet.view().unproject([0.5 * width, 0.5 * height]);
    let axis_px = axis.and_then(|point| sheet.blur_radius_px(point, 0.0));
    // The rim of the frame is not its corners' equal where the sheet leaves the view.
    let most = (width + height).max(2.0 * pupil_reach * axis_px.unwrap_or(0.0).abs());
    (1.1 * reach + 4.0).min(most)
}

/// The table of an index; the last one is kept.
fn gap_table(index: f64) -> Arc<GapTable> {
    static LAST: Mutex<Option<(u64, Arc<GapTable>)>> = Mutex::new(None);
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    match &*last {
        Some((of, table)) if *of == index.to_bits() => Arc::clone(table),
        _ => {
            let table = Arc::new(GapTable::new(index));
            *last = Some((index.to_bits(), Arc::clone(&table)));
            table
        }
    }
}
