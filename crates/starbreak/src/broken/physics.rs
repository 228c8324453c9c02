//! Physics: where the stones hit what the camera sees of the pane, and what breaks.

use std::f64::consts::TAU;

use starbreak_fracture::paper::{Direction, Position};
use starbreak_fracture::physics::{Stage, StoneImpact, simulate};
use starbreak_optics::View;
use starbreak_seed::{Seed, Stream, normal, uniform};

use super::{Details, PhysicsDetails, Simulated};
use crate::{Error, PhysicsSettings, Stopwatch};

/// How often a random place is drawn before the frame is said to show no glass.
const MAX_DRAWS: u32 = 10_000;

const MM_PER_M: f64 = 1e3;

/// What the stones of the settings break of the pane that a view shows.
pub(super) fn network(
    settings: &PhysicsSettings,
    view: &View,
    seed: Seed,
) -> Result<Simulated, Error> {
    let mut watch = Stopwatch::start();
    let stones = stones_on(settings, view, seed)?;
    let broken = simulate(
        &settings.pane,
        &stones,
        settings.long_crack.as_ref(),
        &settings.params,
        seed,
        |stage| {
            watch.lap(match stage {
                Stage::Contact => "contact",
                Stage::Stress => "stress",
                Stage::Tips => "tips",
                Stage::Rings => "rings",
                Stage::Dice => "dice",
                Stage::LongCrack => "long_crack",
                Stage::Network => "network",
            });
        },
    )?;
    Ok(Simulated {
        network: broken.network,
        details: Details::Physics(PhysicsDetails {
            impacts: broken.impacts,
            long_crack: broken.long_crack,
            n_solutions: broken.n_solutions,
            n_mesh_nodes: broken.n_mesh_nodes,
        }),
        timings: watch.stop(),
    })
}

/// The stones where they hit the pane, m; what is random is drawn, each from a stream of its own.
fn stones_on(
    settings: &PhysicsSettings,
    view: &View,
    seed: Seed,
) -> Result<Vec<StoneImpact>, Error> {
    let outline = &settings.pane.outline;
    let on_pane = |[u, v]: [f64; 2]| {
        let (width, height) = view.size();
        let point = view.unproject([u * f64::from(width), v * f64::from(height)])?;
        let point_m = point.map(|coordinate| coordinate / MM_PER_M);
        (outline.depth_m(point_m) >= 0.0).then_some(point_m)
    };
    let mut stones = Vec::new();
    for (table, stone) in (0_u64..).zip(&settings.stones) {
        for n in 0..u64::from(stone.count) {
            // The same stones come first however many there are.
            let k = n << 32 | table;
            let position = stone.position(n);
            let position_m = match position {
                Position::At { x, y } => on_pane([x, y]),
                Position::Random { share } => {
                    let mut rng = seed.stream(Stream::ImpactPosition, k);
                    let mut draw = || 0.5 * (1.0 - share) + share * uniform(&mut rng);
                    // Of what a dashboard leaves of the frame.
                    let mut on_glass = || {
                        let [u, v] = [draw(), draw()];
                        [u, v * view.dashboard().row(u)]
                    };
                    (0..MAX_DRAWS).find_map(|_| on_pane(on_glass()))
                }
            };
            let Some(position_m) = position_m else {
                return Err(Error::OffGlass {
                    impact: table,
                    is_random: matches!(position, Position::Random { .. }),
                });
            };
            let azimuth_rad = match stone.azimuth {
                Direction::Angle { rad } => rad,
                Direction::Random => uniform(&mut seed.stream(Stream::ImpactDirection, k)) * TAU,
            };
            let larger = if stone.radius_spread > 0.0 {
                normal(&mut seed.stream(Stream::ImpactShape, k))
            } else {
                0.0
            };
            stones.push(stone.at(position_m, azimuth_rad, larger));
        }
    }
    Ok(stones)
}
