//! What a picture takes, estimated before it is made, and refused above a limit.
//!
//! The glass breaks first and is shown then, so that each of the two is asked about when its size
//! is known: of breaking the settings and the frame tell it, of showing also what has broken.
//! Time has its bounds where the models have theirs: a recipe has only so many hits, and the paper's
//! model so many neighbors of its particles.

mod showing;
mod touched;

use starbreak_deposit::Cap;
use starbreak_fracture::mesh::Outline;
use starbreak_fracture::physics::{GlassBuild, GlassPane, MeshResolution};
use starbreak_glass::CrackNetwork;
use starbreak_optics::View;

use crate::{Error, FractureSettings, PaperSettings, PhysicsSettings, Settings};

/// What the program holds besides.
const BASE_BYTES: f64 = 1e7;

/// What one picture takes at most, about: more than is measured, up to some three times as much; by the paper's model
/// more than that where cracks do not reach everywhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// What is done.
    what: &'static str,
    /// Memory, bytes.
    pub memory_bytes: f64,
    /// What to change so that it takes less.
    way_out: &'static str,
}

/// A part of a cost, bytes, and what makes it smaller.
type Part = (f64, &'static str);

impl Cost {
    /// The way out is that of the largest part.
    fn of(what: &'static str, parts: &[Part]) -> Self {
        let way_out = parts.iter().max_by(|a, b| a.0.total_cmp(&b.0));
        Self {
            what,
            memory_bytes: BASE_BYTES + parts.iter().map(|(bytes, _)| bytes).sum::<f64>(),
            way_out: way_out.map_or("", |(_, way_out)| way_out),
        }
    }

    fn within(&self, limit_bytes: u64) -> Result<(), Error> {
        #[expect(clippy::cast_precision_loss, reason = "bytes, about")]
        let limit_bytes = limit_bytes as f64;
        if self.memory_bytes <= limit_bytes {
            return Ok(());
        }
        Err(Error::TooCostly {
            what: self.what,
            needs_bytes: self.memory_bytes,
            limit_bytes,
            way_out: self.way_out,
        })
    }
}

impl Settings {
    /// What it takes to break the glass before a frame of this size, px.
    #[must_use]
    pub fn cost_of_breaking(&self, (width_px, height_px): (u32, u32)) -> Cost {
        let what = "breaking the glass";
        match &self.fracture {
            FractureSettings::Paper(paper) => {
                let area_px = f64::from(width_px) * f64::from(height_px);
                Cost::of(what, &[of_particles(paper, area_px)])
            }
            FractureSettings::Physics(physics) => Cost::of(what, &of_pane(physics)),
            FractureSettings::None(_) => Cost::of(what, &[]),
        }
    }

    /// The memory to break the glass is within the limit.
    ///
    /// # Errors
    /// [`Error::TooCostly`] with what to change.
    pub fn may_break(&self, size: (u32, u32)) -> Result<(), Error> {
        self.cost_of_breaking(size).within(self.max_memory_bytes)
    }

    /// The memory to show a network, and drops as a view shows them, is within the limit.
    ///
    /// # Errors
    /// [`Error::TooCostly`] with what to change.
    pub fn may_show(
        &self,
        network: &CrackNetwork,
        view: &View,
        drops: Option<(&[Cap], &View)>,
    ) -> Result<(), Error> {
        let most = self.most_of_showing(network, view, drops);
        if most.within(self.max_memory_bytes).is_ok() {
            return Ok(());
        }
        self.cost_of_showing(network, view, drops)
            .within(self.max_memory_bytes)
    }

    /// The memory to show a photograph of broken glass is within the limit.
    ///
    /// # Errors
    /// [`Error::TooCostly`] with what to change.
    pub fn may_show_photo(&self, size: (u32, u32)) -> Result<(), Error> {
        self.cost_of_photo(size).within(self.max_memory_bytes)
    }
}

/// Bytes of a particle, of one whose cracks fork or walk along the edges of its mesh, and of a piece of crack on its way
/// into the network.
const PARTICLE_BYTES: f64 = 60.0;
const JOINED_PARTICLE_BYTES: f64 = 240.0;
const SEGMENT_BYTES: f64 = 200.0;

/// Pieces per particle where none cross, and how many more there are per neighbor where they do: of cracks that do not
/// fork, and of those that do. The most that the model takes.
const PIECES: [f64; 2] = [0.3, 3.0];
const CROSSINGS: [f64; 2] = [0.0012, 0.004];
const MOST_PIECES: f64 = 2e6;

fn of_particles(paper: &PaperSettings, area_px: f64) -> Part {
    let params = &paper.params;
    let particles = f64::from(params.particles);
    let around = std::f64::consts::PI * params.neighbor_radius * params.neighbor_radius;
    let neighbors = particles * (around / area_px).min(1.0);
    let forks = params.branches > 1;
    let [pieces, crossings] = [PIECES, CROSSINGS].map(|of| of[usize::from(forks)]);
    let pieces = (particles * (pieces + crossings * neighbors)).min(MOST_PIECES);
    let particle_bytes = match forks || params.walks_along_edges() {
        true => JOINED_PARTICLE_BYTES,
        false => PARTICLE_BYTES,
    };
    (
        particle_bytes * particles + SEGMENT_BYTES * pieces,
        "lower fracture.particles",
    )
}

/// Bytes of the plates that a hit solves, of a laminate and of one sheet, by their mesh; of what it leaves; and of one
/// of the dice into which tempered glass breaks.
const LAMINATE_BYTES: [f64; 2] = [3.5e7, 1.2e8];
const SHEET_BYTES: [f64; 2] = [2.5e7, 5e7];
const HIT_BYTES: f64 = 3e5;
const DIE_BYTES: f64 = 6000.0;

fn of_pane(physics: &PhysicsSettings) -> [Part; 3] {
    let n_hits: u32 = physics.stones.iter().map(|stone| stone.count).sum();
    let [fast, default] = match physics.pane.build {
        GlassBuild::Laminated { .. } => LAMINATE_BYTES,
        GlassBuild::Annealed | GlassBuild::Tempered { .. } => SHEET_BYTES,
    };
    let plates = match physics.params.mesh {
        MeshResolution::Fast => fast,
        MeshResolution::Default => default,
    };
    let dice = DIE_BYTES * n_dice(&physics.pane);
    [
        // A pane that goes to dice bends no more.
        ((plates - dice).max(0.0), "set fracture.mesh = \"fast\""),
        (HIT_BYTES * f64::from(n_hits), "lower impact.count"),
        (
            dice,
            "lower glass.surface_compression_mpa or glass.width_mm",
        ),
    ]
}

fn n_dice(pane: &GlassPane) -> f64 {
    let GlassBuild::Tempered {
        surface_compression_pa,
    } = pane.build
    else {
        return 0.0;
    };
    let per_m2 =
        starbreak_fracture::dice::fragment_density_per_m2(surface_compression_pa, pane.thickness_m);
    let area_m2 = match pane.outline {
        Outline::Rectangle { width_m, height_m } => width_m * height_m,
        Outline::Disc { diameter_m } => diameter_m * diameter_m,
    };
    per_m2.unwrap_or(0.0) * area_m2
}
