//! Coverage against closed forms and a supersampled strip.

use super::*;

fn single(ends: [f64; 4], line_width_px: f64) -> Coverage {
    Coverage::of_lines(
        64,
        64,
        line_width_px,
        std::iter::once(Line { ends, weight: 1.0 }),
    )
}

#[test]
fn the_sum_of_coverage_is_the_area_of_the_strip() {
    for k in 0..24 {
        let angle = f64::from(k) * 0.2618;
        let (sin, cos) = angle.sin_cos();
        for width in [0.25, 1.0, 1.7, 4.0] {
            let (cx, cy, half) = (31.37, 32.61, 13.2);
            let area = single(
                [
                    cx - cos * half,
                    cy - sin * half,
                    cx + cos * half,
                    cy + sin * half,
                ],
                width,
            )
            .area_px2();
            let error = (area / (2.0 * half * width) - 1.0).abs();
            assert!(
                error < 0.02,
                "angle {angle}, width {width}: area off by {error}"
            );
        }
    }
}

#[test]
fn an_upright_strip_has_its_exact_area_in_every_pixel() {
    let coverage = single([10.0, 20.5, 14.5, 20.5], 1.0);
    let row: Vec<_> = coverage
        .row(20)
        .map(|(x, covered, _)| (x, covered))
        .collect();
    assert_eq!(
        row,
        vec![(10, 1.0), (11, 1.0), (12, 1.0), (13, 1.0), (14, 0.5)],
        "one row, half at the end"
    );
    assert_eq!(coverage.n_pixels(), 5, "nothing elsewhere");
}

#[test]
fn pixels_agree_with_a_supersampled_strip() {
    let ends = [9.3, 11.2, 50.1, 37.9];
    let coverage = single(ends, 1.0);
    let mask = coverage.to_mask();
    let (length, n) = ((ends[2] - ends[0]).hypot(ends[3] - ends[1]), 16);
    let (ux, uy) = ((ends[2] - ends[0]) / length, (ends[3] - ends[1]) / length);
    let mut worst = 0.0_f64;
    for y in 0..64_u32 {
        for x in 0..64_u32 {
            let mut hits = 0;
            for k in 0..n * n {
                let px = f64::from(x) + (f64::from(k % n) + 0.5) / f64::from(n) - ends[0];
                let py = f64::from(y) + (f64::from(k / n) + 0.5) / f64::from(n) - ends[1];
                let (t, d) = (ux * px + uy * py, ux * py - uy * px);
                hits += i32::from((0.0..=length).contains(&t) && d.abs() <= 0.5);
            }
            // Pixels at the strip's ends hold its corners; see the limits.
            let end =
                |ex: f64, ey: f64| (f64::from(x) + 0.5 - ex).hypot(f64::from(y) + 0.5 - ey) < 1.5;
            if end(ends[0], ends[1]) || end(ends[2], ends[3]) {
                continue;
            }
            let exact = f64::from(hits) / f64::from(n * n);
            worst = worst.max((f64::from(mask.get_pixel(x, y).0[0]) / 255.0 - exact).abs());
        }
    }
    assert!(worst < 0.02, "worst pixel is off by {worst}");
}

#[test]
fn pieces_of_a_line_join_without_seam() {
    let whole = single([5.0, 7.0, 55.0, 40.0], 1.0).to_mask();
    let cut = [17.0 / 50.0, 18.3 / 50.0, 40.0 / 50.0];
    let at = |t: f64| [5.0 + 50.0 * t, 7.0 + 33.0 * t];
    let stops = [0.0, cut[0], cut[1], cut[2], 1.0];
    let pieces = stops.windows(2).map(|pair| {
        let ([x0, y0], [x1, y1]) = (at(pair[0]), at(pair[1]));
        Line {
            ends: [x0, y0, x1, y1],
            weight: 1.0,
        }
    });
    let joined = Coverage::of_lines(64, 64, 1.0, pieces).to_mask();
    let worst = whole
        .pixels()
        .zip(joined.pixels())
        .map(|(a, b)| a.0[0].abs_diff(b.0[0]))
        .max();
    assert!(worst <= Some(1), "a seam of {worst:?} levels");
}

#[test]
fn what_lies_outside_the_frame_is_left_out() {
    for ends in [
        [-1e6, -5.0, 1e6, -5.0],
        [-1e12, 32.0, 1e12, 32.0],
        [70.0, 0.0, 90.0, 1e9],
    ] {
        let coverage = single(ends, 1.0);
        assert!(coverage.n_pixels() <= 128, "{ends:?}");
    }
    assert_eq!(
        single([5.0, 5.0, 5.0, 5.0], 1.0).n_pixels(),
        0,
        "a point has no area"
    );
}
