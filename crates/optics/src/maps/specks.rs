//! What is hardly larger than its blur: facets that are spread pixel by pixel, each over the pupil's image about its own
//! middle.

use super::emit::hand_on;
use super::kernel::Pupil;
use super::lane_runs::LaneRuns;
use super::layer::{Facet, add_scaled};
use crate::pyramid::vectorized;

/// Radii of blur, px, from which and up to which things are specks: in a narrower one the outlines of their facets show,
/// and for a wider one the coarse cells of a layer take less time.
const BLURS_PX: [f64; 2] = [1.0, 8.0];

/// Facets of one thing, of one blur, whose lanes do not lean.
pub(crate) type Speck<const L: usize> = Vec<Facet<L>>;

/// Whether small things with a blur of this radius, px, are specks.
pub(crate) fn has_specks(radius_px: f64) -> bool {
    (BLURS_PX[0]..BLURS_PX[1]).contains(&radius_px.abs())
}

/// Adds specks to the maps of a frame. The first `n_shares` lanes are shares of coverage; where specks lie over each other
/// theirs are summed.
pub(crate) fn add_specks<const L: usize>(
    frame: &mut LaneRuns<L>,
    specks: &[Speck<L>],
    n_shares: usize,
    pupil: Pupil,
) {
    let sides = Sides::of(pupil);
    let mut canvas = Canvas::default();
    for speck in specks {
        let discs: Vec<Disc<L>> = speck.iter().filter_map(Disc::of).collect();
        vectorized(
            #[inline(always)]
            || canvas.draw(&discs, &sides, frame.size()),
        );
        canvas.add_to(frame, n_shares);
    }
    frame.sort();
}

/// A facet as the pupil's image about its middle, as wide as blur, facet and pixel together.
struct Disc<const L: usize> {
    middle: [f64; 2],
    /// Signed as that of the blur, px.
    radius: f64,
    /// How wide the rim is, px.
    ramp: f32,
    area: f32,
    lanes: [f32; L],
}

impl<const L: usize> Disc<L> {
    /// None of a facet without an area.
    fn of(facet: &Facet<L>) -> Option<Self> {
        let [origin, ..] = facet.corners;
        let corners = facet
            .corners
            .map(|at| [at[0] - origin[0], at[1] - origin[1]]);
        let (mut twice, mut moment) = (0.0, [0.0; 2]);
        for (k, [x0, y0]) in corners.iter().enumerate() {
            let [x1, y1] = corners[(k + 1) % corners.len()];
            let cross = x0 * y1 - x1 * y0;
            twice += cross;
            moment = [moment[0] + cross * (x0 + x1), moment[1] + cross * (y0 + y1)];
        }
        let area = 0.5 * f64::abs(twice);
        if area < 1e-9 {
            return None;
        }
        // Variances per axis, px²: of a disc ρ²/4, of one whose rim is a ramp of w px ρ²/4 + 5w²/48; and of the facet about
        // a twelfth of its area, of the pixel 1/12, together that of a step of w px.
        let square_of_ramp = area + 1.0;
        let square = facet.radius_px * facet.radius_px - square_of_ramp / 12.0;
        #[expect(clippy::cast_possible_truncation, reason = "shares of light")]
        let (area_px, ramp_px) = (area as f32, square_of_ramp.sqrt() as f32);
        Some(Self {
            middle: [0, 1].map(|k| origin[k] + moment[k] / (3.0 * twice)),
            radius: square.max(0.0).sqrt().copysign(facet.radius_px),
            ramp: ramp_px,
            area: area_px,
            lanes: facet.lanes,
        })
    }

    /// From which column to before which it has light, and from which row to before which.
    #[inline(always)]
    fn spans(&self, sides: &Sides) -> [[isize; 2]; 2] {
        let reach = (self.radius.abs() + 0.5 * f64::from(self.ramp)) * sides.reach;
        self.middle.map(|at| {
            #[expect(clippy::cast_possible_truncation, reason = "px of a frame")]
            let span = [(at - reach).floor() as isize, (at + reach).ceil() as isize];
            span
        })
    }
}

/// The outline of a pupil of radius 1: none of a disc, or outward normals over how far the sides are from the middle.
struct Sides {
    normals: Vec<[f32; 2]>,
    /// Farthest that it reaches from its middle.
    reach: f64,
}

impl Sides {
    fn of(pupil: Pupil) -> Self {
        let corners = pupil.corners();
        let normal = |(k, [x0, y0]): (usize, &[f64; 2])| {
            let [x1, y1] = corners[(k + 1) % corners.len()];
            let middle = [0.5 * (x0 + x1), 0.5 * (y0 + y1)];
            let square = middle[0] * middle[0] + middle[1] * middle[1];
            #[expect(clippy::cast_possible_truncation, reason = "a direction")]
            let normal = middle.map(|part| (part / square) as f32);
            normal
        };
        Self {
            normals: corners.iter().enumerate().map(normal).collect(),
            reach: corners
                .iter()
                .map(|[x, y]| libm::hypot(*x, *y))
                .fold(1.0, f64::max),
        }
    }

    /// How far a place is from the middle, in outlines of radius 1 that hold it.
    #[inline(always)]
    fn away(&self, [x, y]: [f32; 2]) -> f32 {
        if self.normals.is_empty() {
            return (x * x + y * y).sqrt();
        }
        let sides = self.normals.iter().map(|[a, b]| a * x + b * y);
        sides.fold(0.0, f32::max)
    }
}

/// The pixels around a speck.
struct Canvas<const L: usize> {
    /// First column and row, which may lie before the frame, and how many there are.
    first: [isize; 2],
    size: [usize; 2],
    pixels: Vec<[f32; L]>,
    weights: Vec<f32>,
}

impl<const L: usize> Default for Canvas<L> {
    fn default() -> Self {
        Self {
            first: [0; 2],
            size: [0; 2],
            pixels: Vec::new(),
            weights: Vec::new(),
        }
    }
}

impl<const L: usize> Canvas<L> {
    /// Draws some discs on a canvas that just holds them; none where they do not reach into the frame.
    #[inline(always)]
    fn draw(&mut self, discs: &[Disc<L>], sides: &Sides, (width, height): (usize, usize)) {
        let mut spans = [[isize::MAX, isize::MIN]; 2];
        for disc in discs {
            for (span, own) in spans.iter_mut().zip(disc.spans(sides)) {
                *span = [span[0].min(own[0]), span[1].max(own[1])];
            }
        }
        let is_within = |[first, end]: [isize; 2], n: usize| end > 0 && first < n.cast_signed();
        let is_in_frame = is_within(spans[0], width) && is_within(spans[1], height);
        self.first = spans.map(|[first, _]| first);
        self.size = match is_in_frame {
            true => spans.map(|[first, end]| (end - first).unsigned_abs()),
            false => [0; 2],
        };
        self.pixels.clear();
        self.pixels.resize(self.size[0] * self.size[1], [0.0; L]);
        if is_in_frame {
            for disc in discs {
                self.add(disc, sides);
            }
        }
    }

    #[inline(always)]
    fn add(&mut self, disc: &Disc<L>, sides: &Sides) {
        let [[left, right], [top, bottom]] = disc.spans(sides);
        let n = (right - left).unsigned_abs();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_precision_loss,
            reason = "px from the middle of a disc"
        )]
        let from_middle = |at: isize, axis: usize| (at as f64 + 0.5 - disc.middle[axis]) as f32;
        #[expect(clippy::cast_possible_truncation, reason = "some px")]
        let (radius, side) = (
            disc.radius.abs() as f32,
            1.0_f32.copysign(disc.radius as f32),
        );
        let steep = 1.0 / disc.ramp;
        self.weights.clear();
        let mut sum = 0.0;
        for y in top..bottom {
            let y = side * from_middle(y, 1);
            let first = side * from_middle(left, 0);
            for k in 0..n {
                #[expect(clippy::cast_precision_loss, reason = "some px")]
                let x = first + side * k as f32;
                let weight = ((radius - sides.away([x, y])) * steep + 0.5).clamp(0.0, 1.0);
                sum += weight;
                self.weights.push(weight);
            }
        }
        if sum <= 0.0 {
            return;
        }
        let share = disc.area / sum;
        let column = (left - self.first[0]).unsigned_abs();
        let row = (top - self.first[1]).unsigned_abs();
        for (y, weights) in self.weights.chunks_exact(n).enumerate() {
            let to = &mut self.pixels[(row + y) * self.size[0] + column..][..n];
            for (pixel, weight) in to.iter_mut().zip(weights) {
                *pixel = add_scaled(*pixel, share * weight, disc.lanes);
            }
        }
    }

    /// Adds what of it is in the frame.
    fn add_to(&self, frame: &mut LaneRuns<L>, n_shares: usize) {
        let [columns, _] = self.size;
        if columns == 0 {
            return;
        }
        let (width, height) = frame.size();
        let [left, top] = self.first;
        let skipped = left.min(0).unsigned_abs();
        let start = left.max(0).unsigned_abs();
        let n = (columns - skipped).min(width - start);
        for (y, row) in (top..).zip(self.pixels.chunks_exact(columns)) {
            if let Ok(y) = usize::try_from(y)
                && y < height
            {
                hand_on(frame, y, start, &row[skipped..skipped + n], n_shares);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maps::spread;

    /// A kite of a radius, px, about a place.
    fn kite([x, y]: [f64; 2], radius: f64, radius_px: f64) -> Facet<2> {
        let corners = [[1.0, 0.2], [-0.1, 0.9], [-1.1, -0.1], [0.2, -0.8]];
        Facet {
            corners: corners.map(|[u, v]| [x + radius * u, y + radius * v]),
            lanes: [1.0, 0.3],
            lean: [[0.0; 2]; 2],
            radius_px,
        }
    }

    #[test]
    fn specks_are_what_layers_make_of_the_same_facets() {
        let polygon = |n: u32| Pupil::Polygon { n, angle_rad: 0.4 };
        let size = (60, 50);
        // Of the peak. A layer on its cells is some hundredths from one on finer ones.
        for (pupil, most) in [(Pupil::Round, 0.06), (polygon(6), 0.1), (polygon(3), 0.16)] {
            for (radius, blur) in [(0.8, 1.0), (0.5, 1.4), (0.8, 2.3), (1.0, -4.1), (1.5, 7.2)] {
                assert!(has_specks(blur), "{blur} px");
                // Beside each other, as those of a drop are, and at the corner of the frame.
                let places = [[30.3, 24.6], [30.3 + 2.3 * radius, 24.1], [0.2, 0.4]];
                let facets = places.map(|at| kite(at, radius, blur));
                let expected = spread(&facets, &[], 1, pupil, size);
                let mut found = LaneRuns::with_room(size.0, size.1, 0);
                let specks = [facets[..2].to_vec(), facets[2..].to_vec()];
                add_specks(&mut found, &specks, 1, pupil);
                let of = |frame: &LaneRuns<2>, x: usize, y: usize, lane: usize| {
                    let run = frame.run_at(x, y);
                    run.map_or(0.0, |run| run[lane][x % crate::maps::CHUNK])
                };
                for lane in 0..2 {
                    let (mut worst, mut peak, mut sums) = (0.0_f32, 0.0_f32, [0.0; 2]);
                    for (x, y) in (0..size.0).flat_map(|x| (0..size.1).map(move |y| (x, y))) {
                        let [a, b] = [of(&found, x, y, lane), of(&expected, x, y, lane)];
                        worst = worst.max((a - b).abs());
                        peak = peak.max(b);
                        sums = [sums[0] + a, sums[1] + b];
                    }
                    let what = format!("{pupil:?}, {radius} px, blur {blur} px, lane {lane}");
                    assert!(worst < most * peak, "{what}: {}", worst / peak);
                    let ratio: f32 = sums[0] / sums[1];
                    assert!((ratio - 1.0).abs() < 0.02, "{what}: {ratio}");
                }
            }
        }
    }
}
