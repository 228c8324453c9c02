//! Areas of dice, and how they are distributed.

use starbreak_fracture::dice::Diced;

/// Closed faces by walking half-edges: (area, centroid). The outer one is left out.
pub(crate) fn faces(diced: &Diced) -> Vec<(f64, [f64; 2])> {
    let n = diced.nodes.len();
    let mut starts = vec![0_usize; n + 1];
    for edge in &diced.edges {
        for &node in edge {
            starts[node as usize + 1] += 1;
        }
    }
    for k in 0..n {
        starts[k + 1] += starts[k];
    }
    // Half-edges around each node by angle.
    let mut slots = starts.clone();
    let mut to = vec![0_u32; starts[n]];
    for &[a, b] in &diced.edges {
        for [from, end] in [[a, b], [b, a]] {
            to[slots[from as usize]] = end;
            slots[from as usize] += 1;
        }
    }
    let angle = |from: usize, end: u32| {
        let (p, q) = (diced.nodes[from], diced.nodes[end as usize]);
        (q[1] - p[1]).atan2(q[0] - p[0])
    };
    for node in 0..n {
        to[starts[node]..starts[node + 1]]
            .sort_by(|&p, &q| angle(node, p).total_cmp(&angle(node, q)));
    }
    let mut is_seen = vec![false; to.len()];
    let mut found = Vec::new();
    for node in 0..n {
        for first in starts[node]..starts[node + 1] {
            if is_seen[first] {
                continue;
            }
            let (mut from, mut half) = (node, first);
            let (mut area, mut moment) = (0.0, [0.0; 2]);
            let origin = diced.nodes[node];
            while !is_seen[half] {
                is_seen[half] = true;
                let end = to[half] as usize;
                let [p, q] = [from, end]
                    .map(|k| [diced.nodes[k][0] - origin[0], diced.nodes[k][1] - origin[1]]);
                let cross = p[0] * q[1] - q[0] * p[1];
                area += 0.5 * cross;
                for k in 0..2 {
                    moment[k] += cross * (p[k] + q[k]) / 6.0;
                }
                // Next: the one before the way back, in the order around the end.
                let around = &to[starts[end]..starts[end + 1]];
                let back = around.iter().position(|&k| k as usize == from);
                // Every edge has a way back.
                half = starts[end] + (back.unwrap_or(0) + around.len() - 1) % around.len();
                from = end;
            }
            if area > 0.0 {
                found.push((area, [0, 1].map(|k| origin[k] + moment[k] / area)));
            }
        }
    }
    found
}

/// Centroids of closed faces in windows of 50 mm × 50 mm that keep 20 mm from the rim and 75 mm
/// from the hit.
pub(crate) fn window_counts(diced: &Diced, side: f64, hit: [f64; 2]) -> Vec<f64> {
    let starts: Vec<f64> = (0..100)
        .map(|k| 0.02 + 0.05 * f64::from(k))
        .take_while(|start| start + 0.05 <= side - 0.02 + 1e-9)
        .collect();
    let n = starts.len();
    let mut counts = vec![0.0; n * n];
    for (_, at) in faces(diced) {
        let [x, y] = at.map(|c| starts.iter().position(|&s| (s..s + 0.05).contains(&c)));
        if let (Some(x), Some(y)) = (x, y) {
            counts[y * n + x] += 1.0;
        }
    }
    let is_far = |window: usize| {
        let center = [window % n, window / n].map(|k| starts[k] + 0.025);
        let off = [0, 1].map(|k| ((center[k] - hit[k]).abs() - 0.025).max(0.0));
        off[0].hypot(off[1]) > 0.075
    };
    (0..n * n)
        .filter(|&w| is_far(w))
        .map(|w| counts[w])
        .collect()
}

/// P(k, x): regularized lower incomplete gamma function by its series.
pub(crate) fn gamma_cdf(shape: f64, x: f64) -> f64 {
    let mut term = 1.0 / shape;
    let mut sum = term;
    for k in 1..400 {
        term *= x / (shape + f64::from(k));
        sum += term;
    }
    sum * (shape * x.ln() - x - libm::lgamma(shape)).exp()
}

/// Largest distance of the distribution of areas over their mean from `cdf`.
pub(crate) fn kolmogorov_smirnov(mut areas: Vec<f64>, cdf: impl Fn(f64) -> f64) -> f64 {
    areas.sort_by(f64::total_cmp);
    let n = areas.len() as f64;
    let mean = areas.iter().sum::<f64>() / n;
    let gap = |(k, area): (usize, &f64)| {
        let p = cdf(area / mean);
        (p - k as f64 / n).abs().max((p - (k + 1) as f64 / n).abs())
    };
    areas.iter().enumerate().map(gap).fold(0.0, f64::max)
}
