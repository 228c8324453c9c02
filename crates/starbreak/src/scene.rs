//! What a frame sees of a pane: every question about the view.

use starbreak_deposit::Area;
use starbreak_glass::{CrackNetwork, LengthUnit, Pane};
use starbreak_optics::lens_faults::{MovedPlaces, Optic};
use starbreak_optics::physical::LEAST_DROP_PX;
use starbreak_optics::{Camera, View};

use crate::{Error, FractureSettings, Mount, OpticsSettings, Settings};

const MM_PER_M: f64 = 1e3;

/// Beyond the frame, mm of the pane.
const MARGIN_MM: f64 = 10.0;

/// A windscreen about the optical axis.
const WINDSCREEN: Area = Area::rectangle([-700.0, -400.0], [700.0, 700.0]);

/// Camera, lens and mount of some settings, with frames of one size.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    settings: &'a Settings,
    size_px: (u32, u32),
}

impl<'a> Scene<'a> {
    /// The scene of some settings for frames of a width and height, px.
    #[must_use]
    pub fn of(settings: &'a Settings, size_px: (u32, u32)) -> Self {
        Self { settings, size_px }
    }

    /// The lens and the frame behind it; none by the paper's optics, which know no lens.
    #[must_use]
    pub fn optic(&self) -> Option<Optic> {
        let OpticsSettings::Physical(optics) = &self.settings.optics else {
            return None;
        };
        let (width, height) = self.size_px;
        Some(Optic {
            f_px: self.settings.camera.f_px.of_frame(width),
            lens: optics.lens,
            size: (width as usize, height as usize),
        })
    }

    /// Where the camera shows what frames show without distortion; none where it moves nothing.
    #[must_use]
    pub fn moved_places(&self) -> Option<MovedPlaces> {
        let faults = self.settings.faults.as_ref()?;
        faults.lens.moved_places(&self.optic()?)
    }

    /// How the frame shows the pane that the settings break: the paper's is the frame itself, that
    /// of the physics stands before the camera.
    ///
    /// # Errors
    /// [`Error::Optics`] for a camera that sees nothing.
    pub fn pane(&self) -> Result<View, Error> {
        let (width_px, height_px) = self.size_px;
        match &self.settings.fracture {
            FractureSettings::Paper(_) | FractureSettings::None(_) => Ok(View::stretched(
                &Pane::from_frame_px(width_px, height_px),
                self.size_px,
            )),
            FractureSettings::Physics(physics) => {
                let size_mm = physics.pane.outline.size_m().map(|side| side * MM_PER_M);
                self.mounted(&physics.mount, size_mm)
            }
        }
    }

    /// How the frame shows a network, simulated or from a file: one in px is stretched over the
    /// frame, one in mm lies on the pane that it states, which stands where the recipe says
    /// (`glass.distance_m`, `glass.rake_deg` and `glass.axis_at`, parts of that pane). The physical
    /// optics put one in px on the sheet of the recipe, each point where its line of sight meets it.
    ///
    /// # Errors
    /// [`Error::NoMount`] for a network in mm and a recipe without a mount, [`Error::Optics`] for a
    /// camera that sees nothing.
    pub fn of_network(&self, network: &CrackNetwork) -> Result<View, Error> {
        let pane = &network.data().pane;
        match (network.data().unit, &self.settings.optics) {
            (LengthUnit::Px, OpticsSettings::Paper(_)) => Ok(View::stretched(pane, self.size_px)),
            (LengthUnit::Px, OpticsSettings::Physical(_)) => self.sheet(),
            (LengthUnit::Mm, _) => {
                let mount = self.mount().ok_or(Error::NoMount)?;
                self.mounted(&mount, [pane.width, pane.height])
            }
        }
    }

    /// The part of the pane that frames show and a margin, above it of the share `above` of its height; a pane without a
    /// size is as large as a windscreen.
    pub(crate) fn seen_area(&self, view: &View, above: f64) -> Area {
        let (width, height) = (f64::from(self.size_px.0), f64::from(self.size_px.1));
        let pane = match &self.settings.fracture {
            FractureSettings::Physics(physics) => {
                let size_mm = physics.pane.outline.size_m().map(|side| side * MM_PER_M);
                Area::rectangle([0.0; 2], size_mm)
            }
            FractureSettings::Paper(_) | FractureSettings::None(_) => WINDSCREEN,
        };
        let mut seen = Area::rectangle([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        const STEPS: u32 = 8;
        for step in 0..=STEPS {
            let part = f64::from(step) / f64::from(STEPS);
            for (x, edge_mm) in [(0.0, pane.from_mm[0]), (width, pane.to_mm[0])] {
                // Some rows may look past a pane that leans: it goes on to its end there.
                let end_mm = if part > 0.5 {
                    pane.to_mm[1]
                } else {
                    pane.from_mm[1]
                };
                let at = view.unproject([x, part * height]);
                let at = at.unwrap_or([edge_mm, end_mm]);
                for (k, mm) in at.into_iter().enumerate() {
                    seen.from_mm[k] = seen.from_mm[k].min(mm);
                    seen.to_mm[k] = seen.to_mm[k].max(mm);
                }
            }
        }
        let [wide, high] = seen.sides_mm();
        // Discs out of focus reach into the frame.
        let beyond_mm = [0.1 * wide, 0.1 * high].map(|part| part + MARGIN_MM);
        let above_mm = above * high + MARGIN_MM;
        let [x, y] = seen.from_mm;
        let from_mm = [x - beyond_mm[0], y - above_mm];
        let area = Area::rectangle(
            [0, 1].map(|k| from_mm[k].max(pane.from_mm[k])),
            [0, 1].map(|k| (seen.to_mm[k] + beyond_mm[k]).min(pane.to_mm[k])),
        );
        // A frame's sides are straight lines on the pane, and what is above them may come down to where they are.
        let upper_mm = area.from_mm[1] + above_mm;
        let line = |x: f64, aside_mm: f64| {
            let top = view.unproject([x, 0.0])?;
            let middle = view.unproject([x, 0.5 * height])?;
            let moves = (middle[0] - top[0]) / (middle[1] - top[1]);
            Some((top[0] + (upper_mm - top[1]) * moves + aside_mm, moves))
        };
        let aside_mm = 2.0 * MARGIN_MM + self.pupil_mm();
        let area = area.shown_below(y - aside_mm, above_mm);
        let area = match (line(0.0, -aside_mm), line(width, aside_mm)) {
            (Some(left), Some(right)) => area.between([left, right]),
            _ => area,
        };
        // The least drops that are seen at two rows of the frame: their radius grows with the distance, which
        // changes evenly on the pane.
        let least = |part: f64| {
            let at_mm = view.unproject([0.5 * width, part * height])?;
            let [[px_per_mm, _], _] = view.jacobian(at_mm)?;
            Some((at_mm[1], LEAST_DROP_PX / px_per_mm))
        };
        match (least(0.5), least(0.9)) {
            (Some(middle), Some(lower)) => area.without_smaller([middle, lower]),
            _ => area,
        }
    }

    /// Diameter of the entrance pupil, mm.
    fn pupil_mm(&self) -> f64 {
        match &self.settings.optics {
            OpticsSettings::Physical(optics) => optics.lens.aperture_m() * MM_PER_M,
            OpticsSettings::Paper(_) => 0.0,
        }
    }

    /// What a pixel shows of the pane, or a sixth of what the pupil sees of it at once, mm: nothing finer is seen.
    pub(crate) fn finest_mm(&self, view: &View) -> f64 {
        let (width, height) = self.size_px;
        let middle = [0.5 * f64::from(width), 0.5 * f64::from(height)];
        let at = view.unproject(middle);
        let pixel_mm = at
            .and_then(|at| view.px_per_unit(at))
            .map_or(1.0, |px| 1.0 / px);
        pixel_mm.max(self.pupil_mm() / 6.0)
    }

    /// Length of what the frame shows of a network at a time, in the unit of its arrivals, px.
    ///
    /// # Errors
    /// As for [`Scene::of_network`].
    pub(crate) fn crack_length_px(&self, network: &CrackNetwork, time: f64) -> Result<f64, Error> {
        // Networks in px lie over the frame, also where the optics see glass that is raked.
        let data = network.data();
        let view = match data.unit {
            LengthUnit::Px => View::stretched(&data.pane, self.size_px),
            LengthUnit::Mm => self.of_network(network)?,
        };
        let lengths = network
            .grown_at(time)
            .filter_map(|(_, ends)| view.visible(ends, 0.0))
            .map(|[u0, v0, u1, v1]| libm::hypot(u1 - u0, v1 - v0));
        // An empty sum is -0.
        Ok(lengths.sum::<f64>().abs())
    }

    /// The pane as the physical optics see it: every camera looks through glass, also where the
    /// cracks are those of the paper, which lie over the frame.
    pub(crate) fn sheet(&self) -> Result<View, Error> {
        match (&self.settings.fracture, self.mount()) {
            (FractureSettings::None(None), _) => self.mounted(&Mount::NOWHERE, [0.0; 2]),
            (FractureSettings::Paper(_) | FractureSettings::None(_), Some(mount)) => {
                // The sheet goes on beyond the frame, so that any of its points will do.
                self.mounted(&mount, [0.0; 2])
            }
            _ => self.pane(),
        }
    }

    /// How the pane stands before frames of this size.
    fn mount(&self) -> Option<Mount> {
        let mount = self.settings.fracture.mount()?;
        let rake_rad = self.lowered_rake_rad().unwrap_or(mount.rake_rad);
        Some(Mount { rake_rad, ..mount })
    }

    /// The rake of a pane without a size that leans less than its mount says, so that what lies on it lies in the whole
    /// frame: in a tall one lines of sight would run past its end, or never meet it. None where it need not.
    ///
    /// The last row sees it v d/(cos ρ − v sin ρ) below the axis, with v = height/(2 f).
    pub(crate) fn lowered_rake_rad(&self) -> Option<f64> {
        let is_bare = self.settings.drops.is_none() && self.settings.coats.is_empty();
        if is_bare || matches!(self.settings.fracture, FractureSettings::Physics(_)) {
            return None;
        }
        let mount = self.settings.fracture.mount()?;
        let f_px = self.settings.camera.f_px.of_frame(self.size_px.0);
        let below = 0.5 * f64::from(self.size_px.1) / f_px;
        let (up_mm, down_mm) = (-WINDSCREEN.from_mm[1], WINDSCREEN.to_mm[1]);
        let end_mm = if mount.rake_rad > 0.0 { down_mm } else { up_mm } - MARGIN_MM;
        let least = mount.distance_m * MM_PER_M * below / end_mm / libm::hypot(1.0, below);
        let most_rad = libm::acos(least.min(1.0)) - libm::atan(below);
        (mount.rake_rad.abs() > most_rad).then(|| libm::copysign(most_rad.max(0.0), mount.rake_rad))
    }

    /// A pane of `[width, height]` mm behind which the camera stands.
    fn mounted(&self, mount: &Mount, [width_mm, height_mm]: [f64; 2]) -> Result<View, Error> {
        let [x, y] = mount.axis_at;
        let camera = Camera {
            f_px: self.settings.camera.f_px.of_frame(self.size_px.0),
            distance_m: mount.distance_m,
            rake_rad: mount.rake_rad,
            axis_at_mm: [x * width_mm, y * height_mm],
        };
        let view = View::through(&camera, self.size_px)?;
        Ok(match &self.settings.optics {
            OpticsSettings::Physical(optics) => view.over(optics.environment.dashboard),
            OpticsSettings::Paper(_) => view,
        })
    }

    /// Diameters, px, of the discs that a point of the glass on the optical axis and one of the world
    /// become; 0 where no glass stands before the camera, and where its optics know no lens.
    pub(crate) fn discs_px(&self, f_px: f64) -> [f64; 2] {
        let OpticsSettings::Physical(optics) = &self.settings.optics else {
            return [0.0; 2];
        };
        let lens = &optics.lens;
        let disc = |distance_m| lens.circle_of_confusion_px(f_px, distance_m).abs();
        let mount = self.settings.fracture.mount();
        let glass = mount.map_or(0.0, |mount| disc(mount.distance_m));
        [glass, disc(lens.scene_m)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Recipe;

    /// Whatever a frame shows of a pane is in the area on which things lie, but for what is beyond the pane.
    #[test]
    fn all_that_is_seen_is_in_the_area_and_little_else() {
        let (mut least, mut least_shown) = (f64::INFINITY, f64::INFINITY);
        for (width, height) in [(1242, 375), (640, 480), (480, 640), (1280, 720), (300, 300)] {
            for set in [
                "glass.rake_deg=50",
                "glass.rake_deg=30",
                "glass.rake_deg=0",
                "glass.rake_deg=-40",
                "camera.f_px=2000",
                "glass.distance_m=0.02",
            ] {
                let mut recipe = Recipe::preset("rain").unwrap_or_else(|it| panic!("{it}"));
                recipe.set(set).unwrap_or_else(|it| panic!("{it}"));
                let settings = recipe.settings().unwrap_or_else(|it| panic!("{it}"));
                let scene = Scene::of(&settings, (width, height));
                let view = scene.sheet().unwrap_or_else(|it| panic!("{it}"));
                for above in [0.1, 0.4] {
                    let area = scene.seen_area(&view, above);
                    let shown = area.shown();
                    let mut n_seen = 0;
                    for k in 0..10_000 {
                        let [s, t] = [k % 100, k / 100].map(|n| f64::from(n) / 99.0);
                        let at = [s * f64::from(width), t * f64::from(height)];
                        let Some(at_mm) = view.unproject(at) else {
                            continue;
                        };
                        let is_on = |k: usize| {
                            (WINDSCREEN.from_mm[k]..WINDSCREEN.to_mm[k]).contains(&at_mm[k])
                        };
                        if is_on(0) && is_on(1) {
                            n_seen += 1;
                            // Drops that are drawn are on it, too.
                            let px_per_mm = view.jacobian(at_mm).map_or(0.0, |it| it[0][0]);
                            let least_px = area.least_radius_mm(at_mm[1]) * px_per_mm;
                            assert!(
                                (least_px / LEAST_DROP_PX - 1.0).abs() < 1e-6,
                                "{least_px} px"
                            );
                            assert!(
                                area.holds(at_mm) && shown.holds(at_mm),
                                "{set}, {width} x {height}, {above}: {at:?} px shows {at_mm:?} mm"
                            );
                        }
                    }
                    assert!(n_seen > 5000, "{set}, {width} x {height}: {n_seen}");
                    let [wide, high] = area.sides_mm();
                    least = least.min(area.area_m2() * 1e6 / (wide * high));
                    least_shown = least_shown.min(shown.area_m2() / area.area_m2());
                }
            }
        }
        assert!(least < 0.65, "of the rectangle at least: {least}");
        assert!(least_shown < 0.65, "of that at least: {least_shown}");
    }
}
