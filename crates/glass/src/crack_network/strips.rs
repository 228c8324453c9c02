//! Segments sorted by height, so that those near a place are found without asking all.

use robust::Coord;

/// A segment clipped to one horizontal strip.
#[derive(Clone, Copy)]
pub(super) struct InStrip {
    pub(super) x_min: f64,
    pub(super) x_max: f64,
    pub(super) y_min: f64,
    pub(super) y_max: f64,
    pub(super) nodes: [u32; 2],
    pub(super) segment: u32,
}

impl InStrip {
    pub(super) fn shares_node(&self, other: &Self) -> bool {
        let ([a, b], [c, d]) = (self.nodes, other.nodes);
        a == c || a == d || b == c || b == d
    }
}

/// Segments sorted into horizontal strips.
pub(super) struct Strips {
    count: usize,
    y_top: f64,
    height: f64,
    /// Padding that makes clipping conservative under rounding.
    pad: f64,
    starts: Vec<u32>,
    members: Vec<u32>,
}

impl Strips {
    pub(super) fn new(ends: &[(Coord<f64>, Coord<f64>)]) -> Self {
        let (mut y_top, mut y_bottom, mut extent, mut climb) = (f64::MAX, f64::MIN, 1.0_f64, 0.0);
        for (a, b) in ends {
            y_top = y_top.min(a.y).min(b.y);
            y_bottom = y_bottom.max(a.y).max(b.y);
            extent = extent
                .max(a.x.abs())
                .max(b.x.abs())
                .max(a.y.abs())
                .max(b.y.abs());
            climb += (a.y - b.y).abs();
        }
        #[expect(
            clippy::cast_precision_loss,
            reason = "a count, only to choose a strip height"
        )]
        let n = ends.len().max(1) as f64;
        let range = (y_bottom - y_top).max(0.0);
        let height = (2.0 * climb / n)
            .max(range / (4.0 * n.sqrt() + 1.0))
            .max(extent * 1e-9);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "at most 4√n + 2"
        )]
        let count = (range / height) as usize + 1;
        let mut strips = Self {
            count,
            y_top,
            height,
            pad: extent * 1e-9,
            starts: vec![0; count + 1],
            members: Vec::new(),
        };
        for end in ends {
            let (low, high) = strips.range(end);
            for strip in low..=high {
                strips.starts[strip + 1] += 1;
            }
        }
        for strip in 0..count {
            strips.starts[strip + 1] += strips.starts[strip];
        }
        let mut next = strips.starts.clone();
        strips.members = vec![0; strips.starts[count] as usize];
        for (segment, end) in (0_u32..).zip(ends) {
            let (low, high) = strips.range(end);
            for slot in &mut next[low..=high] {
                strips.members[*slot as usize] = segment;
                *slot += 1;
            }
        }
        strips
    }

    /// Number of strips.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// The segments that may reach a height.
    pub(super) fn members_at(&self, y: f64) -> &[u32] {
        self.members(self.strip_at(y))
    }

    fn range(&self, (a, b): &(Coord<f64>, Coord<f64>)) -> (usize, usize) {
        (
            self.strip_at(a.y.min(b.y) - self.pad),
            self.strip_at(a.y.max(b.y) + self.pad),
        )
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "`as` saturates, and it is clamped"
    )]
    fn strip_at(&self, y: f64) -> usize {
        (((y - self.y_top) / self.height) as usize).min(self.count - 1)
    }

    /// The segments that may reach into a strip.
    pub(super) fn members(&self, strip: usize) -> &[u32] {
        &self.members[self.starts[strip] as usize..self.starts[strip + 1] as usize]
    }

    /// Bounds of the part of a segment inside a strip, a little too large rather than too small.
    pub(super) fn clip(
        &self,
        strip: usize,
        segment: u32,
        (a, b): &(Coord<f64>, Coord<f64>),
        nodes: [u32; 2],
    ) -> InStrip {
        let (top, bottom) = if a.y <= b.y { (a, b) } else { (b, a) };
        #[expect(clippy::cast_precision_loss, reason = "a strip number")]
        let (low, high) = (
            self.y_top + self.height * strip as f64,
            self.y_top + self.height * (strip + 1) as f64,
        );
        let climb = bottom.y - top.y;
        let x_at = |y: f64| {
            let t = if climb > self.pad {
                ((y - top.y) / climb).clamp(0.0, 1.0)
            } else {
                0.0
            };
            top.x + (bottom.x - top.x) * t
        };
        let (mut x0, mut x1) = (x_at(low - self.pad), x_at(high + self.pad));
        if climb <= self.pad {
            (x0, x1) = (top.x, bottom.x);
        }
        // A flat segment moves fast in x over the padding in y: widen by what that can be.
        let slack = self.pad
            * (1.0
                + if climb > self.pad {
                    ((bottom.x - top.x) / climb).abs()
                } else {
                    0.0
                });
        InStrip {
            x_min: x0.min(x1) - slack,
            x_max: x0.max(x1) + slack,
            y_min: top.y,
            y_max: bottom.y,
            nodes,
            segment,
        }
    }
}
