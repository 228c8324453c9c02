//! How deep a crack in a bent plate goes: its front.
//!
//! A radial crack begins at the face away from the stone and hangs there like the half of a surface
//! crack, of half length c. Of all fronts of that length it has the one along which the stress
//! intensity is the same at the face and at the deepest point: a shallower one would run deeper, a
//! deeper one along the face.

/// Depth over thickness of the deepest point, of cracks in a bent plate, by their half length over
/// thickness: where K of \[NewmanRaju1981\] at the face is that at the deepest point, up to 0.8,
/// as far as their fit goes.
const BENT: [[f64; 2]; 9] = [
    [0.0, 0.0],
    [0.148, 0.1],
    [0.377, 0.2],
    [0.752, 0.3],
    [1.372, 0.4],
    [2.386, 0.5],
    [3.994, 0.6],
    [6.404, 0.7],
    [9.807, 0.8],
];

/// Half length over thickness from which a crack is through. FIT: the curve above, gone on with.
const THROUGH: f64 = 17.0;

/// Over how many thicknesses the front of a crack that is through rises from its tip: a quarter of
/// an ellipse. FIT.
const RISE: f64 = 1.5;

/// Over how many thicknesses a branch comes from the depth of the crack that forked to its own.
/// FIT.
const BRANCH: f64 = 1.0;

/// Deepest point of the front of a crack over the thickness, by its half length over the
/// thickness.
pub(super) fn deepest(half_length: f64) -> f64 {
    let through = [THROUGH, 1.0];
    for pair in BENT
        .windows(2)
        .chain([&[BENT[BENT.len() - 1], through][..]])
    {
        let [[from, low], [to, high]] = [pair[0], pair[1]];
        if half_length < to {
            return low + (high - low) * (half_length - from).max(0.0) / (to - from);
        }
    }
    1.0
}

/// Depth over thickness at a distance from where a crack began, whose tip is at `tip`, all in
/// thicknesses: δ (1 − (r/c)²), and of one that is through 1, but for a quarter of an ellipse
/// behind the tip. From c = 9.8 to 17 the one turns into the other.
///
/// The parabola is a FIT: under one stress all along, the front would be half an ellipse, but that of a hit falls
/// outwards. In a photograph of a chip its legs are 0.65 and 0.4 as wide half way and three quarters of the way from the
/// pit to their tips, as here; an ellipse's would be 0.81 and 0.6.
pub(super) fn depth(at: f64, tip: f64) -> f64 {
    let tip = tip.max(f64::MIN_POSITIVE);
    let part = (at / tip).clamp(0.0, 1.0);
    let round = deepest(tip) * (1.0 - part * part);
    let left = (1.0 - (tip - at).max(0.0) / RISE.min(tip)).max(0.0);
    let blunt = deepest(tip) * (1.0 - left * left).max(0.0).sqrt();
    let last = BENT[BENT.len() - 1][0];
    let t = ((tip - last) / (THROUGH - last)).clamp(0.0, 1.0);
    let through = t * t * (3.0 - 2.0 * t);
    round + (blunt - round) * through
}

/// The depth of a branch a way behind the fork, in thicknesses, that of the crack which forked being
/// `before` there, and `own` that of its front.
pub(super) fn of_branch(own: f64, before: f64, way: f64) -> f64 {
    own + (before - own) * libm::exp(-way / BRANCH)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    /// K over S √(πa) of a surface crack of depth a and half length c in a wide plate of thickness
    /// t under bending S, at the angle φ of its front \[NewmanRaju1981\], a/c ≤ 1.
    fn newman_raju(a_c: f64, a_t: f64, phi: f64) -> f64 {
        let q = 1.0 + 1.464 * a_c.powf(1.65);
        let m1 = 1.13 - 0.09 * a_c;
        let m2 = -0.54 + 0.89 / (0.2 + a_c);
        let m3 = 0.5 - 1.0 / (0.65 + a_c) + 14.0 * (1.0 - a_c).powi(24);
        let (sin, cos) = phi.sin_cos();
        let f = (a_c * a_c * cos * cos + sin * sin).powf(0.25);
        let g = 1.0 + (0.1 + 0.35 * a_t * a_t) * (1.0 - sin) * (1.0 - sin);
        let p = 0.2 + a_c + 0.6 * a_t;
        let h1 = 1.0 - 0.34 * a_t - 0.11 * a_c * a_t;
        let g1 = -1.22 - 0.12 * a_c;
        let g2 = 0.55 - 1.05 * a_c.powf(0.75) + 0.47 * a_c.powf(1.5);
        let h2 = 1.0 + g1 * a_t + g2 * a_t * a_t;
        let h = h1 + (h2 - h1) * sin.powf(p);
        h * (m1 + m2 * a_t * a_t + m3 * a_t.powi(4)) * f * g / q.sqrt()
    }

    #[test]
    fn the_fit_has_the_values_of_other_citations() {
        // A deep semicircle in tension is 0.663·2 … in bending the deepest point of a/c = 1, a/t → 0
        // has 1.03·√2/… of the embedded circle, 2/π: M1 = 1.04, Q = 2.464.
        let shallow = newman_raju(1.0, 1e-6, FRAC_PI_2);
        assert!(
            (shallow - 1.04 / 2.464_f64.sqrt()).abs() < 1e-4,
            "{shallow}"
        );
        // Free surface of the same: 1.1 times as much.
        let face = newman_raju(1.0, 1e-6, 0.0);
        assert!((face / shallow - 1.1).abs() < 1e-3, "{face}");
        // A long shallow crack is the edge crack: 1.12.
        let long = newman_raju(1e-3, 1e-3, FRAC_PI_2);
        assert!((long - 1.12).abs() < 0.02, "{long}");
    }

    #[test]
    fn the_table_is_where_face_and_deepest_point_have_one_intensity() {
        for [half_length, depth] in &BENT[1..] {
            let excess = |c: f64| {
                let a_c = depth / c;
                newman_raju(a_c, *depth, FRAC_PI_2) - newman_raju(a_c, *depth, 0.0)
            };
            let (mut low, mut high) = (*depth, 40.0);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if excess(middle) > 0.0 {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            assert!(
                (low / half_length - 1.0).abs() < 2e-3,
                "depth {depth}: c = {low}, not {half_length}"
            );
        }
    }

    #[test]
    fn fronts_have_no_steps_and_end_at_their_tips() {
        let mut last = 0.0;
        for k in 1..4000 {
            let tip = 0.01 * f64::from(k);
            let deep = depth(0.0, tip);
            assert!(deep >= last - 1e-12, "c = {tip}: {deep} after {last}");
            assert!(deep - last < 0.011, "c = {tip}: a step");
            last = deep;
            assert!(depth(tip, tip) < 1e-9, "c = {tip}: the tip");
            let mut before = deep;
            for j in 1..=200 {
                let at = tip * f64::from(j) / 200.0;
                let here = depth(at, tip);
                assert!(here <= before + 1e-12, "c = {tip}: grows towards the tip");
                before = here;
            }
        }
        assert!((last - 1.0).abs() < 1e-12, "long cracks are through");
    }

    #[test]
    fn a_long_crack_has_its_full_width_nearly_to_the_tip() {
        for tip in [17.0, 25.0, 100.0] {
            let n = 10_000;
            let wide = (0..n).filter(|k| depth(tip * f64::from(*k) / f64::from(n), tip) >= 0.8);
            let share = wide.count() as f64 / f64::from(n);
            assert!(share >= 0.9, "c = {tip}: {share}");
        }
    }
}
