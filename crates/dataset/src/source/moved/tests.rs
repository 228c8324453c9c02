//! Boxes, outlines and masks under maps that can be computed.

#![expect(clippy::float_cmp, reason = "numbers of a hundredth")]

use super::*;

/// Everything `gain` times as far from the middle of the frame, times 1 + k r² with r the share of half the width; what
/// is farther than `most` of it is not seen.
#[derive(Clone, Copy)]
struct Radial {
    middle: [f64; 2],
    gain: f64,
    k: f64,
    most: f64,
}

impl Radial {
    fn r(&self, at: [f64; 2]) -> f64 {
        libm::hypot(at[0] - self.middle[0], at[1] - self.middle[1]) / self.middle[0]
    }

    fn times(&self, at: [f64; 2], gain: f64) -> [f64; 2] {
        [0, 1].map(|k| self.middle[k] + gain * (at[k] - self.middle[k]))
    }
}

impl PlaceMap for Radial {
    fn seen_at(&self, at: [f64; 2]) -> Option<[f64; 2]> {
        let r = self.r(at);
        (r <= self.most).then(|| self.times(at, self.gain * (1.0 + self.k * r * r)))
    }

    fn shown_at(&self, at: [f64; 2]) -> Option<[f64; 2]> {
        let wanted = self.r(at);
        let (mut near, mut far) = (0.0, self.most);
        let seen = |r: f64| self.gain * r * (1.0 + self.k * r * r);
        if wanted > seen(far) {
            return None;
        }
        for _ in 0..60 {
            let half = 0.5 * (near + far);
            if seen(half) < wanted {
                near = half;
            } else {
                far = half;
            }
        }
        Some(self.times(at, near / wanted.max(1e-12)))
    }
}

fn frame(gain: f64, k: f64, most: f64) -> MovedFrame {
    MovedFrame::of_size((200, 100), &move |(width, height)| {
        Box::new(Radial {
            middle: [0.5 * f64::from(width), 0.5 * f64::from(height)],
            gain,
            k,
            most,
        })
    })
}

fn is_box(found: Option<MovedBox>, corners_px: [f64; 4], kept: f64) {
    assert!(
        found.is_some_and(|it| it.corners_px == corners_px && (it.kept - kept).abs() < 1e-9),
        "{found:?}, expected {corners_px:?} with {kept}"
    );
}

#[test]
fn boxes_are_cut_to_the_frame_before_and_after() {
    let wider = frame(2.0, 0.0, 9.0);
    is_box(
        wider.box_px([90.0, 40.0, 110.0, 60.0]),
        [80.0, 30.0, 120.0, 70.0],
        1.0,
    );
    is_box(
        wider.box_px([140.0, 40.0, 160.0, 60.0]),
        [180.0, 30.0, 200.0, 70.0],
        0.5,
    );
    is_box(
        wider.box_px([140.0, 20.0, 160.0, 60.0]),
        [180.0, 0.0, 200.0, 70.0],
        0.5 * 70.0 / 80.0,
    );
    assert_eq!(
        wider.box_px([150.0, 40.0, 190.0, 60.0]),
        None,
        "it ends where the frame does"
    );
    // No image shows what is beyond its frame.
    let smaller = frame(0.5, 0.0, 9.0);
    is_box(
        smaller.box_px([180.0, 40.0, 260.0, 60.0]),
        [140.0, 45.0, 150.0, 55.0],
        1.0,
    );
    assert_eq!(
        smaller.box_px([201.0, 40.0, 260.0, 60.0]),
        None,
        "it was never seen"
    );
    is_box(
        smaller.box_px([100.0, 50.0, 100.0, 60.0]),
        [100.0, 50.0, 100.0, 55.0],
        1.0,
    );
}

#[test]
fn a_box_is_around_its_bent_sides() {
    // A side bulges beyond its ends, by a pincushion inwards: its middle decides.
    let pincushion = frame(1.0, 0.2, 9.0);
    let found = pincushion
        .box_px([50.0, 10.0, 150.0, 90.0])
        .map(|it| it.corners_px);
    let r2 = 0.5 * 0.5 + 0.4 * 0.4;
    let out = 1.0 + 0.2 * r2;
    let expected = [50.0 * out, 40.0 * out].map(hundredth);
    assert_eq!(
        found,
        Some(
            [
                100.0 - expected[0],
                50.0 - expected[1],
                100.0 + expected[0],
                50.0 + expected[1]
            ]
            .map(hundredth)
        ),
        "the corners are farthest out"
    );
    let barrel = frame(1.0, -0.2, 9.0);
    let found = barrel
        .box_px([50.0, 10.0, 150.0, 90.0])
        .map(|it| it.corners_px);
    let sides = [50.0 * (1.0 - 0.2 * 0.25), 40.0 * (1.0 - 0.2 * 0.16)];
    assert_eq!(
        found,
        Some(
            [
                100.0 - sides[0],
                50.0 - sides[1],
                100.0 + sides[0],
                50.0 + sides[1]
            ]
            .map(hundredth)
        ),
        "the middles of the sides are"
    );
}

#[test]
fn what_the_lens_does_not_see_has_no_part_in_a_box() {
    // It sees a disc of 60 px.
    let disc = frame(1.0, 0.0, 0.6);
    let found = disc
        .box_px([130.0, 20.0, 190.0, 80.0])
        .map(|it| it.corners_px);
    let [x0, y0, x1, y1] = found.unwrap_or_default();
    assert!(
        [x0, y0, y1] == [130.0, 20.0, 80.0] && (159.0..=160.0).contains(&x1),
        "{found:?}"
    );
    assert_eq!(
        disc.box_px([170.0, 40.0, 190.0, 60.0]),
        None,
        "nothing of it is seen"
    );
    // A whole frame is the disc, cut above and below.
    let all = disc.outline(&[[0.0, 0.0], [200.0, 0.0], [200.0, 100.0], [0.0, 100.0]]);
    let half_angle = (50.0_f64 / 60.0).asin();
    let expected = 2.0 * (half_angle * 3600.0 + 50.0 * half_angle.cos() * 60.0);
    assert!(
        (area_px2(&all) / expected - 1.0).abs() < 0.003,
        "{} of {expected}",
        area_px2(&all)
    );
}

#[test]
fn outlines_are_cut_and_bent() {
    let still = frame(1.0, 0.0, 9.0);
    let triangle = [[-50.0, 50.0], [50.0, 0.0], [50.0, 100.0]];
    assert_eq!(
        area_px2(&still.outline(&triangle)),
        3750.0,
        "3/4 of 5000 are in the frame"
    );
    let inside = [[10.0, 10.0], [90.0, 20.0], [30.0, 70.25]];
    assert_eq!(still.outline(&inside), inside, "as it was");
    assert!(
        still
            .outline(&[[210.0, 10.0], [230.0, 10.0], [220.0, 20.0]])
            .is_empty(),
        "outside"
    );
    assert!(still.outline(&inside[..2]).is_empty(), "a line");
    let wider = frame(2.0, 0.0, 9.0);
    assert!(
        wider
            .outline(&[[160.0, 40.0], [190.0, 40.0], [170.0, 60.0]])
            .is_empty(),
        "moved out"
    );
    // A disc grows to a disc, whatever lies between its corners.
    let pincushion = frame(1.0, 0.2, 9.0);
    let square = [[60.0, 10.0], [140.0, 10.0], [140.0, 90.0], [60.0, 90.0]];
    let bent = pincushion.outline(&square);
    assert!(bent.len() > 8, "its sides are bent: {bent:?}");
    for at in &bent {
        let shown = pincushion.map.shown_at(*at).unwrap_or_default();
        let miss = square.map(|corner| [0, 1].map(|k| (shown[k] - corner[k]).abs()));
        let nearest = miss
            .as_flattened()
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min);
        assert!(nearest < 0.02, "a corner beside the side: {at:?}");
    }
}

#[test]
fn points_that_are_not_seen_have_no_place() {
    let wider = frame(2.0, 0.0, 9.0);
    assert_eq!(wider.point([110.0, 55.0]), Some([120.0, 60.0]));
    assert_eq!(wider.point([190.0, 55.0]), None, "moved out");
    assert_eq!(
        frame(0.5, 0.0, 9.0).point([210.0, 55.0]),
        None,
        "it was outside"
    );
    assert_eq!(frame(1.0, 0.0, 0.6).point([170.0, 50.0]), None, "unseen");
}

/// A mask of the frame that has the pixels of a box of whole numbers.
fn mask_of([x0, y0, x1, y1]: [u64; 4]) -> Mask {
    let mut counts = vec![x0 * 100 + y0];
    for x in x0..x1 {
        counts.push(y1 - y0);
        counts.push(if x + 1 < x1 { 100 - (y1 - y0) } else { 0 });
    }
    let sum: u64 = counts.iter().sum();
    counts.push(0);
    counts.push(20_000 - sum);
    Mask::of_counts([200, 100], counts).unwrap_or_else(|why| panic!("{why}"))
}

#[test]
fn masks_move_as_outlines_do() {
    let still = frame(1.0, 0.0, 9.0);
    for corners in [
        [40, 20, 90, 60],
        [0, 0, 200, 100],
        [199, 99, 200, 100],
        [0, 0, 1, 1],
        [50, 0, 60, 100],
    ] {
        let mask = mask_of(corners);
        let [x0, y0, x1, y1] = corners;
        assert_eq!(mask.area_px2(), (x1 - x0) * (y1 - y0), "{corners:?}");
        let moved = still.mask(&mask);
        assert_eq!(moved.area_px2(), mask.area_px2(), "{corners:?}");
        assert_eq!(
            moved.counts().iter().sum::<u64>(),
            20_000,
            "all of the frame"
        );
        assert_eq!(still.mask(&moved), moved, "again");
    }
    let corners = [120, 20, 180, 90];
    for (gain, k, most) in [
        (1.0, -0.2, 1.2),
        (1.0, 0.3, 9.0),
        (1.4, 0.0, 9.0),
        (1.0, -0.2, 0.6),
    ] {
        let lens = frame(gain, k, most);
        let mask = lens.mask(&mask_of(corners));
        let [x0, y0, x1, y1] = corners.map(|at| f64::from(u32::try_from(at).unwrap_or(0)));
        let outline = lens.outline(&[[x0, y0], [x1, y0], [x1, y1], [x0, y1]]);
        let mask_area = f64::from(u32::try_from(mask.area_px2()).unwrap_or(0));
        let share = mask_area / area_px2(&outline);
        assert!(
            (share - 1.0).abs() < 0.02,
            "gain {gain}, k {k}, most {most}: {share}"
        );
    }
    let nothing = Mask::of_counts([200, 100], [20_000]).unwrap_or_else(|why| panic!("{why}"));
    assert_eq!(still.mask(&nothing), nothing, "an empty mask");
}

#[test]
fn compressed_runs_are_those_of_pycocotools() {
    // mask.frPyObjects({'size': [100, 200], 'counts': [4020, 40, 60, 40, 59, 41, 15740]}, 100, 200)['counts']
    let text = "dm3X1l10O1QZ?";
    assert_eq!(
        Mask::counts_of_text(text),
        Ok(vec![4020, 40, 60, 40, 59, 41, 15_740]),
        "{text}"
    );
    for wrong in ["é", "`", "0P", "0000N000J", "\u{1}"] {
        assert!(Mask::counts_of_text(wrong).is_err(), "{wrong:?}");
    }
    assert!(
        Mask::of_counts([2, 2], [1, 2]).is_err(),
        "a pixel is missing"
    );
}
