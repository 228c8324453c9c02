//! Masks as MS-COCO stores them: the lengths of runs of pixels outside and inside in turn, column by column.

use super::{MovedFrame, STEP_PX};

/// A mask of a frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::source) struct Mask {
    /// Width and height, px.
    size: [u64; 2],
    /// Where each run ends, counted from the first pixel; the first run lies outside and may be empty.
    ends: Vec<u64>,
}

impl Mask {
    /// A mask of a width and height by the lengths of its runs; why not where these do not fill the frame.
    pub(in crate::source) fn of_counts(
        size: [u64; 2],
        counts: impl IntoIterator<Item = u64>,
    ) -> Result<Self, String> {
        let n_pixels = size[0].saturating_mul(size[1]);
        let mut end = 0_u64;
        let mut ends = Vec::new();
        for count in counts {
            end = end.saturating_add(count);
            ends.push(end);
        }
        match end == n_pixels {
            true => Ok(Self { size, ends }),
            false => Err(format!(
                "runs of {end} pixels in all for a mask of {} x {} px",
                size[0], size[1]
            )),
        }
    }

    /// The lengths of runs out of their compressed text: each in groups of 5 bits from the lowest on, from the fourth on
    /// as what it is more than the last but one. Why not where the text is none.
    pub(in crate::source) fn counts_of_text(text: &str) -> Result<Vec<u64>, String> {
        let mut counts: Vec<i64> = Vec::new();
        let (mut value, mut n_bits) = (0_i64, 0_u32);
        for byte in text.bytes() {
            let bits = byte
                .checked_sub(48)
                .filter(|bits| *bits < 64 && n_bits <= 40);
            let bits = i64::from(bits.ok_or("runs that are no compressed numbers")?);
            value |= (bits & 0x1f) << n_bits;
            n_bits += 5;
            if bits & 0x20 != 0 {
                continue;
            }
            if bits & 0x10 != 0 {
                value |= -1 << n_bits;
            }
            let before = match counts.len() {
                0..=2 => 0,
                n => counts[n - 2],
            };
            counts.push(value.saturating_add(before));
            (value, n_bits) = (0, 0);
        }
        let counts = counts.into_iter().map(u64::try_from);
        match n_bits {
            0 => counts
                .collect::<Result<_, _>>()
                .map_err(|_| "a run of less than 0 pixels".to_owned()),
            _ => Err("runs that end too early".to_owned()),
        }
    }

    /// Width and height, px.
    pub(in crate::source) fn size(&self) -> [u64; 2] {
        self.size
    }

    /// The lengths of its runs.
    pub(in crate::source) fn counts(&self) -> Vec<u64> {
        let begins = std::iter::once(&0).chain(&self.ends);
        self.ends
            .iter()
            .zip(begins)
            .map(|(end, begin)| end - begin)
            .collect()
    }

    /// Pixels inside.
    pub(in crate::source) fn area_px2(&self) -> u64 {
        self.counts().iter().skip(1).step_by(2).sum()
    }

    fn has(&self, x: u64, y: u64) -> bool {
        let at = x * self.size[1] + y;
        self.ends.partition_point(|end| *end <= at) % 2 == 1
    }

    /// The box around it, px; none around none.
    fn around(&self) -> Option<[u64; 4]> {
        let height = self.size[1];
        let begins = self.ends.iter().step_by(2);
        let inside = begins.zip(self.ends.iter().skip(1).step_by(2));
        let mut around: Option<[u64; 4]> = None;
        for (begin, end) in inside.filter(|(begin, end)| begin < end) {
            let [x0, x1] = [begin / height, (end - 1) / height];
            let [y0, y1] = match x0 == x1 {
                true => [begin % height, (end - 1) % height],
                false => [0, height - 1],
            };
            let now = around.unwrap_or([x0, y0, x1 + 1, y1 + 1]);
            around = Some([
                now[0].min(x0),
                now[1].min(y0),
                now[2].max(x1 + 1),
                now[3].max(y1 + 1),
            ]);
        }
        around
    }
}

impl MovedFrame {
    /// A mask of the frame, moved: a pixel is inside where that was which its middle shows.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_precision_loss,
        clippy::cast_sign_loss,
        reason = "px of a frame"
    )]
    pub(in crate::source) fn mask(&self, mask: &Mask) -> Mask {
        let [width, height] = mask.size;
        let n_pixels = width * height;
        let corners = mask
            .around()
            .and_then(|corners| self.box_px(corners.map(|at| at as f64)));
        let mut runs: Vec<[u64; 2]> = Vec::new();
        // No farther than the box may miss where the lens sees a part alone.
        let [x0, y0, x1, y1] = corners.map_or([0.0; 4], |moved| {
            let [x0, y0, x1, y1] = moved.corners_px;
            [x0 - STEP_PX, y0 - STEP_PX, x1 + STEP_PX, y1 + STEP_PX].map(f64::ceil)
        });
        for x in x0 as u64..(x1 as u64).min(width) {
            for y in y0 as u64..(y1 as u64).min(height) {
                let shown = self.map.shown_at([x as f64 + 0.5, y as f64 + 0.5]);
                let shown = shown.filter(|at| self.is_inside(*at));
                let has = shown.is_some_and(|[u, v]| {
                    mask.has((u as u64).min(width - 1), (v as u64).min(height - 1))
                });
                let at = x * height + y;
                match runs.last_mut() {
                    Some(run) if has && run[1] == at => run[1] += 1,
                    _ if has => runs.push([at, at + 1]),
                    _ => {}
                }
            }
        }
        let mut ends = runs.concat();
        if ends.last() != Some(&n_pixels) {
            ends.push(n_pixels);
        }
        Mask {
            size: mask.size,
            ends,
        }
    }
}
