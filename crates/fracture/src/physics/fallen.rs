//! Pieces of glass that fall out.

use starbreak_glass::{CrackNetwork, Fragment};

/// The pieces that fall out of a broken pane: of those that nothing holds the largest, then those of
/// which the rim is the smallest part of the bound. The largest piece of all stays.
pub(super) fn loose_pieces(network: &CrackNetwork, n_fallen: u32) -> Vec<Fragment> {
    if n_fallen == 0 {
        return Vec::new();
    }
    let mut fragments = network.fragments();
    let largest = fragments
        .iter()
        .map(|fragment| fragment.area)
        .fold(0.0, f64::max);
    fragments.retain(|fragment| fragment.area < largest && fragment.inner_point().is_some());
    let held = |fragment: &Fragment| match fragment.touches_rim {
        false => 0.0,
        true => rim_part(network, fragment).max(f64::MIN_POSITIVE),
    };
    let mut ranked: Vec<(f64, Fragment)> = fragments
        .into_iter()
        .map(|fragment| (held(&fragment), fragment))
        .collect();
    // A stable sort keeps the order of those that are alike.
    ranked.sort_by(|(a, one), (b, other)| a.total_cmp(b).then(other.area.total_cmp(&one.area)));
    ranked.truncate(n_fallen as usize);
    ranked.into_iter().map(|(_, fragment)| fragment).collect()
}

/// The part of the bound of a piece that is rim of the pane.
fn rim_part(network: &CrackNetwork, fragment: &Fragment) -> f64 {
    let pane = &network.data().pane;
    let near = |[x, y]: [f64; 2]| {
        let sides = [x, pane.width - x, y, pane.height - y];
        let to_rim = if pane.is_disc() {
            let radius = 0.5 * pane.width;
            radius - libm::hypot(x - radius, y - radius)
        } else {
            sides.into_iter().fold(f64::INFINITY, f64::min)
        };
        to_rim <= pane.rim_tolerance()
    };
    let n = fragment.outline.len();
    let on_rim: f64 = (0..n)
        .map(|k| [fragment.outline[k], fragment.outline[(k + 1) % n]])
        .filter(|ends| ends.iter().all(|end| near(*end)))
        .map(|[a, b]| libm::hypot(b[0] - a[0], b[1] - a[1]))
        .sum();
    on_rim / fragment.perimeter.max(f64::MIN_POSITIVE)
}
