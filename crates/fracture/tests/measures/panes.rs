//! Panes and random stones.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng;
use starbreak_fracture::mesh::Outline;
use starbreak_fracture::physics::{GlassBuild, GlassPane, StoneImpact, Support};
use starbreak_glass::{Material, MaterialError};
use starbreak_seed::{Seed, Stream};

pub(crate) fn rectangle(width_m: f64, height_m: f64) -> Outline {
    Outline::Rectangle { width_m, height_m }
}

/// A simply supported pane of soda-lime glass.
pub(crate) fn pane(
    outline: Outline,
    thickness_m: f64,
    build: GlassBuild,
) -> Result<GlassPane, MaterialError> {
    Ok(GlassPane {
        outline,
        thickness_m,
        build,
        support: Support::SimplySupported,
        material: Material::soda_lime()?,
    })
}

/// A windscreen: plies of 2.1 mm on 0.76 mm of an interlayer with a Young's modulus.
pub(crate) fn windscreen(interlayer_modulus_pa: f64) -> Result<GlassPane, MaterialError> {
    let build = GlassBuild::Laminated {
        interlayer_thickness_m: 0.76e-3,
        interlayer_modulus_pa,
        inner_thickness_m: 2.1e-3,
    };
    pane(rectangle(1.4, 0.8), 2.1e-3, build)
}

/// Numbers for the `k`-th of many random cases.
pub(crate) fn case(purpose: u64, k: u64) -> ChaCha8Rng {
    Seed(purpose).stream(Stream::ImpactShape, k)
}

/// A number between two.
pub(crate) fn between(rng: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "53 bits fit an f64 exactly")]
    let part = (rng.next_u64() >> 11) as f64 / 9_007_199_254_740_992.0;
    low + (high - low) * part
}

/// A stone of the road: R 1 to 6 mm with a tip of 0.3 R to R, 10 to 40 m/s, up to 60° oblique.
pub(crate) fn road_stone(position_m: [f64; 2], rng: &mut ChaCha8Rng) -> StoneImpact {
    let radius_m = between(rng, 1e-3, 6e-3);
    let speed_m_s = between(rng, 10.0, 40.0);
    StoneImpact {
        tip_radius_m: between(rng, 0.3, 1.0) * radius_m,
        obliquity_rad: between(rng, 0.0, 60.0).to_radians(),
        azimuth_rad: between(rng, 0.0, TAU),
        ..StoneImpact::granite(position_m, speed_m_s, radius_m)
    }
}

/// A pane of any kind, any stone, and where it hits: small and large, thin and thick.
pub(crate) fn any_hit(k: u64) -> Result<(GlassPane, StoneImpact), MaterialError> {
    let mut rng = case(15, k);
    let (width_m, height_m) = (between(&mut rng, 0.05, 0.6), between(&mut rng, 0.05, 0.6));
    let outline = if k % 5 == 4 {
        Outline::Disc {
            diameter_m: width_m,
        }
    } else {
        rectangle(width_m, height_m)
    };
    let thickness_m = between(&mut rng, 0.5e-3, 8e-3);
    let build = match k % 3 {
        0 => GlassBuild::Annealed,
        1 => GlassBuild::Laminated {
            interlayer_thickness_m: between(&mut rng, 0.38e-3, 1.52e-3),
            interlayer_modulus_pa: 30e6 * libm::pow(1000.0 / 30.0, between(&mut rng, 0.0, 1.0)),
            inner_thickness_m: 2.1e-3,
        },
        _ => GlassBuild::Tempered {
            surface_compression_pa: between(&mut rng, 20e6, 130e6),
        },
    };
    let [width, height] = outline.size_m();
    // Within the disc, too, which is inscribed in its box.
    let position_m = [width, height].map(|side| side * between(&mut rng, 0.2, 0.8));
    let mut stone = road_stone(position_m, &mut rng);
    stone.speed_m_s = libm::pow(10.0, between(&mut rng, 0.0, 2.0));
    Ok((pane(outline, thickness_m, build)?, stone))
}
