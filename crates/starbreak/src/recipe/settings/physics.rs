//! Settings of the physics: pane, stones and loads in SI units.

use starbreak_fracture::mesh::Outline;
use starbreak_fracture::paper::{Direction, Position};
use starbreak_fracture::physics::{
    Dicing, GlassBuild, GlassPane, LongCrack, LongCrackGrowth, LongCrackOrigin, MembraneLoad,
    MeshResolution, PhysicsParams, StoneImpact, Support,
};
use starbreak_glass::{GlassKind, Material};

use super::super::error::{Place, RecipeError};
use super::super::tables::{
    DicingWord, GlassTable, GrowthWord, KindWord, LongCrackTable, MeshWord, OriginWord,
    PhysicsFractureTable, PhysicsFractureTables, ReachEntry, StoneTable, StoneWord, SupportWord,
};
use super::{direction, impacts, is_aimed, out_of_range, position};

/// What the physics needs to know.
#[derive(Debug, Clone, PartialEq)]
pub struct PhysicsSettings {
    /// The pane that breaks.
    pub pane: GlassPane,
    /// What kind of pane it is called.
    pub kind: GlassKind,
    /// How it stands before the camera.
    pub mount: Mount,
    /// The hits, in the order in which they happen.
    pub stones: Vec<StoneSettings>,
    /// A long crack after the hits.
    pub long_crack: Option<LongCrack>,
    /// Parameters of the model.
    pub params: PhysicsParams,
}

impl PhysicsSettings {
    /// Puts stones before the objects that are drawn for them.
    pub(super) fn aim(&mut self, drawn: impl Fn(u64) -> Option<Position>) {
        for (k, stone) in (0..).zip(&mut self.stones) {
            if std::mem::take(&mut stone.is_aimed) {
                stone.first_position = drawn(k);
            }
        }
    }
}

/// How a pane stands before the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mount {
    /// Distance to the pane along the optical axis, m, 0.001 to 10.
    pub distance_m: f64,
    /// Tilt about the pane's horizontal axis, rad, 0 where it faces the camera, -80° to 80°;
    /// positive: the upper edge leans towards the camera.
    pub rake_rad: f64,
    /// Where the optical axis meets the pane, as fractions of its width and height.
    pub axis_at: [f64; 2],
}

impl Mount {
    /// Where nothing breaks there is no pane, but the camera looks somewhere.
    pub(crate) const NOWHERE: Self = Self {
        distance_m: 1.0,
        rake_rad: 0.0,
        axis_at: [0.5; 2],
    };
}

/// A hit by a stone, of which place and direction may still be open.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StoneSettings {
    position: Position,
    /// Whether the first of them is to be before a labeled object.
    pub(super) is_aimed: bool,
    first_position: Option<Position>,
    /// Direction of the path in the plane of the pane.
    pub azimuth: Direction,
    /// How many of them there are.
    pub count: u32,
    /// Standard deviation of the logarithm of their radius.
    pub radius_spread: f64,
    /// The rest.
    stone: StoneImpact,
}

/// Radii of a stone, m, that a spread of sizes may come to.
const RADII_M: [f64; 2] = [2e-4, 0.1];

impl StoneSettings {
    /// Where the n-th of them hits, as fractions of the frame.
    #[must_use]
    pub fn position(&self, n: u64) -> Position {
        let first = self.first_position.filter(|_| n == 0);
        first.unwrap_or(self.position)
    }

    /// The stone that hits the pane here, flying this way in its plane, larger than the others by a
    /// factor e^(`larger` σ) as far as stones go.
    #[must_use]
    pub fn at(&self, position_m: [f64; 2], azimuth_rad: f64, larger: f64) -> StoneImpact {
        let radius_m = self.stone.radius_m;
        let wanted = radius_m * libm::exp(self.radius_spread * larger);
        let [least, most] = RADII_M;
        let factor = if self.radius_spread > 0.0 {
            wanted.clamp(least.min(radius_m), most.max(radius_m)) / radius_m
        } else {
            1.0
        };
        StoneImpact {
            position_m,
            azimuth_rad,
            radius_m: factor * radius_m,
            tip_radius_m: factor * self.stone.tip_radius_m,
            ..self.stone
        }
    }
}

pub(super) fn settings(
    place: &Place,
    recipe: &PhysicsFractureTables,
) -> Result<PhysicsSettings, RecipeError> {
    let pane = pane(place, &recipe.glass)?;
    let stones = impacts(place, &recipe.impact, |k, stone| {
        stone_settings(place, k, stone)
    })?;
    check_hits(place, &stones, recipe.glass.kind)?;
    Ok(PhysicsSettings {
        pane,
        kind: match recipe.glass.kind {
            KindWord::Annealed => GlassKind::Annealed,
            KindWord::Laminated => GlassKind::Laminated,
            KindWord::Tempered => GlassKind::Tempered,
            KindWord::Cover => GlassKind::Cover,
        },
        mount: mount(
            recipe.glass.distance_m,
            recipe.glass.rake_deg,
            recipe.glass.axis_at,
        ),
        stones,
        long_crack: recipe
            .long_crack
            .as_ref()
            .map(|given| long_crack(place, given))
            .transpose()?,
        params: params(place, &recipe.fracture)?,
    })
}

fn pane(place: &Place, given: &GlassTable) -> Result<GlassPane, RecipeError> {
    let outline = if given.kind == KindWord::Cover {
        if given.width_mm.to_bits() != given.height_mm.to_bits() {
            let expected = format!(
                "glass.width_mm ({}): a cover is a disc; for a rectangle choose another glass.kind",
                given.width_mm
            );
            return Err(out_of_range(
                place,
                "glass.height_mm",
                given.height_mm,
                &expected,
            ));
        }
        Outline::Disc {
            diameter_m: given.width_mm / 1e3,
        }
    } else {
        Outline::Rectangle {
            width_m: given.width_mm / 1e3,
            height_m: given.height_mm / 1e3,
        }
    };
    let material = Material::soda_lime().map_err(|error| RecipeError::Type {
        place: place.clone(),
        key: "glass".to_owned(),
        what: error.to_string(),
    })?;
    let pane = GlassPane {
        outline,
        thickness_m: given.thickness_mm / 1e3,
        build: build(place, given)?,
        support: match given.support {
            SupportWord::SimplySupported => Support::SimplySupported,
            SupportWord::Clamped => Support::Clamped,
        },
        material,
    };
    pane.check()
        .map_err(|error| RecipeError::of_model(place, "glass", error))?;
    Ok(pane)
}

/// How the pane was made; keys that its kind does not have are refused, not ignored.
fn build(place: &Place, given: &GlassTable) -> Result<GlassBuild, RecipeError> {
    let thickness = ("interlayer_thickness_mm", given.interlayer_thickness_mm);
    let modulus = ("interlayer_modulus_mpa", given.interlayer_modulus_mpa);
    let inner = ("inner_thickness_mm", given.inner_thickness_mm);
    let compression = ("surface_compression_mpa", given.surface_compression_mpa);
    let wrong = |key: &str, what: &str| RecipeError::Type {
        place: place.clone(),
        key: format!("glass.{key}"),
        what: what.to_owned(),
    };
    let required = |(key, value): (&str, Option<f64>)| {
        value.ok_or_else(|| wrong(key, "this kind of glass needs it; add it"))
    };
    let absent = |keys: &[(&str, Option<f64>)]| match keys.iter().find(|(_, value)| value.is_some())
    {
        Some((key, _)) => Err(wrong(
            key,
            "glass of this glass.kind has none; remove it or choose another kind",
        )),
        None => Ok(()),
    };
    if given.kind == KindWord::Laminated {
        absent(&[compression])?;
        return Ok(GlassBuild::Laminated {
            interlayer_thickness_m: required(thickness)? / 1e3,
            interlayer_modulus_pa: required(modulus)? * 1e6,
            inner_thickness_m: required(inner)? / 1e3,
        });
    }
    absent(&[thickness, modulus, inner])?;
    match (given.kind, compression.1) {
        (KindWord::Annealed, _) => absent(&[compression])?,
        (KindWord::Cover, None) => {}
        _ => {
            return Ok(GlassBuild::Tempered {
                surface_compression_pa: required(compression)? * 1e6,
            });
        }
    }
    Ok(GlassBuild::Annealed)
}

pub(super) fn mount(distance_m: f64, rake_deg: f64, axis_at: [f64; 2]) -> Mount {
    Mount {
        distance_m,
        rake_rad: rake_deg.to_radians(),
        axis_at,
    }
}

/// Most hits of one pane, of a laminate and of another: some minute of work, since each hit solves
/// the pane anew that the ones before have cracked. The severest preset has 48.
const MAX_HITS: [u32; 2] = [600, 120];

fn check_hits(place: &Place, stones: &[StoneSettings], kind: KindWord) -> Result<(), RecipeError> {
    let n_hits: u32 = stones.iter().map(|stone| stone.count).sum();
    let [laminated, other] = MAX_HITS;
    let most = if kind == KindWord::Laminated {
        laminated
    } else {
        other
    };
    if n_hits <= most {
        return Ok(());
    }
    let expected = format!(
        "at most {laminated} hits in all on laminated glass and {other} on other kinds, which take a minute already; \
         lower it"
    );
    Err(out_of_range(place, "impact.count", n_hits, &expected))
}

fn stone_settings(
    place: &Place,
    k: usize,
    given: &StoneTable,
) -> Result<StoneSettings, RecipeError> {
    let azimuth = direction(given.azimuth_deg);
    let of_material = match given.material {
        StoneWord::Granite => StoneImpact::granite,
        StoneWord::Ice => StoneImpact::ice,
        StoneWord::Head => StoneImpact::head,
    };
    let stone = StoneImpact {
        obliquity_rad: given.angle_deg.to_radians(),
        azimuth_rad: match azimuth {
            Direction::Random => 0.0,
            Direction::Angle { rad } => rad,
        },
        tip_radius_m: given.tip_radius_mm / 1e3,
        density_kg_m3: given.density_kg_m3,
        ..of_material([0.0; 2], given.speed_m_s, given.radius_mm / 1e3)
    };
    if given.tip_radius_mm > given.radius_mm {
        let key = format!("impact.{k}.tip_radius_mm");
        let expected = format!("up to radius_mm ({} mm)", given.radius_mm);
        return Err(out_of_range(place, &key, given.tip_radius_mm, &expected));
    }
    stone
        .check()
        .map_err(|error| RecipeError::of_model(place, &format!("impact.{k}"), error))?;
    Ok(StoneSettings {
        position: position(given.position),
        is_aimed: is_aimed(given.position),
        first_position: None,
        azimuth,
        count: given.count,
        radius_spread: given.radius_spread,
        stone,
    })
}

fn long_crack(place: &Place, given: &LongCrackTable) -> Result<LongCrack, RecipeError> {
    let long_crack = LongCrack {
        load: MembraneLoad {
            temperature_difference_k: given.temperature_difference_k,
            spot: given.spot,
            spot_size: given.spot_size,
            frame_tension_pa: given.frame_tension_mpa * 1e6,
            frame_direction_rad: given.frame_direction_deg.to_radians(),
        },
        origin: match given.origin {
            OriginWord::Rim => LongCrackOrigin::Rim,
            OriginWord::Impact => LongCrackOrigin::Impact,
            OriginWord::Legs => LongCrackOrigin::Legs,
        },
        flaw_m: given.flaw_mm / 1e3,
        growth: match given.growth {
            GrowthWord::Sudden => LongCrackGrowth::Sudden,
            GrowthWord::Slow => LongCrackGrowth::Slow {
                period_s: given.period_s,
            },
        },
    };
    long_crack
        .check()
        .map_err(|error| RecipeError::of_model(place, "long_crack", error))?;
    Ok(long_crack)
}

fn params(place: &Place, given: &PhysicsFractureTable) -> Result<PhysicsParams, RecipeError> {
    let params = PhysicsParams {
        mesh: match given.mesh {
            MeshWord::Fast => MeshResolution::Fast,
            MeshWord::Default => MeshResolution::Default,
        },
        epochs: given.epochs,
        dicing: match given.dicing {
            DicingWord::Cells => Dicing::Cells,
            DicingWord::Cascade => Dicing::Cascade,
        },
        radial_count_factor: given.radial_count_factor,
        strength_pa: given.strength_mpa * 1e6,
        weibull_modulus: given.weibull_modulus,
        until_reach_m: match given.until_reach_mm {
            ReachEntry::Mm(reach_mm) => Some(reach_mm / 1e3),
            ReachEntry::Word(_) => None,
        },
        n_fallen: given.fallen_pieces,
    };
    params
        .check()
        .map_err(|error| RecipeError::of_model(place, "fracture", error))?;
    Ok(params)
}
