//! Fragments whose faces are not parallel: each shows the scene a little to the side.

use std::collections::BTreeMap;

use rand_chacha::rand_core::Rng;
use starbreak_glass::CrackNetwork;
use starbreak_seed::{Seed, Stream};

use super::cracks::Facets;
use super::lobe::{LightFrom, Sent};

/// Adds every fragment that cracks have cut out by `time` as a prism of a random wedge angle of this standard deviation.
///
/// A wedge ε turns sight by (n − 1) ε, that is by f (n − 1) ε in the frame, whatever its distance.
pub(crate) fn fragment_facets(
    from: &LightFrom<'_>,
    (network, time): (&CrackNetwork, f64),
    wedge_rad: f64,
    seed: Seed,
    facets: &mut Facets,
) {
    if wedge_rad <= 0.0 || network.n_segments() == 0 {
        return;
    }
    let data = network.data();
    let pane = [data.pane.width, data.pane.height];
    // After the streams of the hits.
    let mut rng = seed.stream(Stream::CrackRelief, u64::MAX);
    let arrivals = arrivals(network);
    for fragment in network.fragments() {
        let turn = [normal(&mut rng), normal(&mut rng)]
            .map(|z| z * wedge_rad * (from.sheet.index - 1.0) * from.sheet.f_px());
        // Drawn all the same, so that it does not depend on the time.
        let is_cut = fragment.outline.iter().all(|corner| {
            arrivals
                .get(&corner.map(f64::to_bits))
                .is_none_or(|arrival| *arrival <= time)
        });
        if !is_cut {
            continue;
        }
        let project = |point: [f64; 2]| {
            let point = from.sheet.on_sheet(point, data.unit, pane)?;
            let radius = from.sheet.blur_radius_px(point, 0.0)?;
            Some((from.sheet.project(point, 0.0, [0.0; 2])?, radius))
        };
        let Some((middle, radius_px)) = project(fragment.centroid) else {
            continue;
        };
        let outline: Option<Vec<[f64; 2]>> = fragment
            .outline
            .iter()
            .map(|corner| project(*corner).map(|(corner, _)| corner))
            .collect();
        let Some(outline) = outline else {
            continue;
        };
        for (k, &a) in outline.iter().enumerate() {
            let b = outline[(k + 1) % outline.len()];
            // Triangles about the middle; those that are turned over take away what others have
            // too much.
            let area =
                (a[0] - middle[0]) * (b[1] - middle[1]) - (a[1] - middle[1]) * (b[0] - middle[0]);
            let share = 1.0_f64.copysign(area);
            let center = [
                (a[0] + b[0] + 2.0 * middle[0]) / 4.0,
                (a[1] + b[1] + 2.0 * middle[1]) / 4.0,
            ];
            let mut sent = Sent::default();
            let ray = from.sheet.ray([center[0] + turn[0], center[1] + turn[1]]);
            from.seen(&mut sent.lanes, ray, share);
            facets.add(
                [middle, a, b, middle],
                radius_px,
                &sent,
                [[1.0, 0.0], [0.0, 1.0]],
            );
        }
    }
}

/// When the last crack through each node reaches it, by the bits of its place; nothing for those
/// that are there from the start.
fn arrivals(network: &CrackNetwork) -> BTreeMap<[u64; 2], f64> {
    let data = network.data();
    let mut arrivals = BTreeMap::new();
    for (idx, arrival) in data
        .segments
        .arrival()
        .unwrap_or_default()
        .iter()
        .enumerate()
    {
        let [_, _, x, y] = network.ends(idx);
        let last = arrivals
            .entry([x.to_bits(), y.to_bits()])
            .or_insert(f64::NEG_INFINITY);
        *last = last.max(*arrival);
    }
    arrivals
}

/// A normally distributed number \[BoxMuller1958\].
fn normal(rng: &mut rand_chacha::ChaCha8Rng) -> f64 {
    let mut uniform = || (f64::from(rng.next_u32()) + 0.5) / 4_294_967_296.0;
    let (a, b) = (uniform(), uniform());
    (-2.0 * libm::log(a)).sqrt() * libm::cos(std::f64::consts::TAU * b)
}
