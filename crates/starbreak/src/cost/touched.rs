//! How much of a frame a crack may touch.

/// Side of a tile, px; frames of more tiles have larger ones.
const TILE_PX: f64 = 16.0;
const MOST_TILES: f64 = 512.0;

/// The same for what is as small as drops.
const SMALL_TILE_PX: f64 = 4.0;
const MOST_SMALL_TILES: f64 = 2048.0;

/// A frame in tiles, of which rectangles are marked. Each rectangle is noted at its corners, so that
/// many of any size take no time.
pub(super) struct Touched {
    size_px: [f64; 2],
    tile_px: f64,
    n_tiles: [usize; 2],
    /// How many more rectangles begin than end here, of columns and rows one more than there are.
    steps: Vec<i64>,
}

impl Touched {
    pub(super) fn new(size_px: (u32, u32)) -> Self {
        Self::in_tiles(size_px, TILE_PX, MOST_TILES)
    }

    /// The same in smaller tiles.
    pub(super) fn by_small(size_px: (u32, u32)) -> Self {
        Self::in_tiles(size_px, SMALL_TILE_PX, MOST_SMALL_TILES)
    }

    fn in_tiles((width, height): (u32, u32), tile_px: f64, most: f64) -> Self {
        let size_px = [f64::from(width), f64::from(height)];
        let tile_px = tile_px.max(size_px[0].max(size_px[1]) / most);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "some hundreds of tiles"
        )]
        let n_tiles = size_px.map(|side| (side / tile_px).ceil().max(1.0) as usize);
        Self {
            size_px,
            tile_px,
            n_tiles,
            steps: vec![0; (n_tiles[0] + 1) * (n_tiles[1] + 1)],
        }
    }

    /// Marks what lies within some px of a straight line.
    pub(super) fn mark_line(&mut self, [u0, v0, u1, v1]: [f64; 4], within_px: f64) {
        let (along_u, along_v) = (u1 - u0, v1 - v0);
        // In parts, whose rectangles are little more than what is near them.
        let part_px = self.tile_px.max(0.5 * within_px);
        let n = (along_u.abs().max(along_v.abs()) / part_px)
            .ceil()
            .clamp(1.0, 4.0 * MOST_TILES);
        let mut k = 0.0;
        while k < n {
            let at = |t: f64| [u0 + along_u * t / n, v0 + along_v * t / n];
            self.mark(at(k), at(k + 1.0), within_px);
            k += 1.0;
        }
    }

    fn mark(&mut self, a: [f64; 2], b: [f64; 2], within_px: f64) {
        let mut tiles = [[0; 2]; 2];
        for axis in 0..2 {
            let low = a[axis].min(b[axis]) - within_px;
            let high = a[axis].max(b[axis]) + within_px;
            if !(low < self.size_px[axis] && high > 0.0) {
                return;
            }
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "clamped to the tiles"
            )]
            let tile = |at: f64| (at.clamp(0.0, self.size_px[axis]) / self.tile_px) as usize;
            let last = self.n_tiles[axis] - 1;
            tiles[axis] = [tile(low).min(last), tile(high).min(last) + 1];
        }
        let [[left, right], [top, bottom]] = tiles;
        let stride = self.n_tiles[0] + 1;
        for (column, row, step) in [
            (left, top, 1),
            (right, top, -1),
            (left, bottom, -1),
            (right, bottom, 1),
        ] {
            if let Some(sum) = self.steps.get_mut(row * stride + column) {
                *sum += step;
            }
        }
    }

    /// Share of the frame in marked tiles.
    pub(super) fn share(&self) -> f64 {
        let stride = self.n_tiles[0] + 1;
        let mut above = vec![0_i64; stride];
        let mut n_marked = 0_u32;
        for row in self.steps.chunks_exact(stride).take(self.n_tiles[1]) {
            let mut along = 0;
            for (sum, step) in above.iter_mut().zip(row) {
                along += step;
                *sum += along;
                n_marked += u32::from(*sum > 0);
            }
        }
        #[expect(clippy::cast_precision_loss, reason = "some thousands of tiles")]
        let n_tiles = (self.n_tiles[0] * self.n_tiles[1]) as f64;
        f64::from(n_marked) / n_tiles
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_tiles_say_more_closely_what_is_touched() {
        let touched_by = |mut touched: Touched| {
            touched.mark_line([104.0, 104.0, 104.0, 104.0], 2.0);
            touched.share() * 640.0 * 320.0
        };
        let small = touched_by(Touched::by_small((640, 320)));
        let large = touched_by(Touched::new((640, 320)));
        // Four of 4 px, one of 16.
        assert!((small - 64.0).abs() < 1e-6, "{small}");
        assert!((large - 256.0).abs() < 1e-6, "{large}");
    }

    #[test]
    fn tiles_near_a_line_are_marked_once() {
        let mut touched = Touched::new((640, 320));
        assert!(touched.share() <= 0.0, "nothing as yet");
        for _ in 0..3 {
            touched.mark_line([8.0, 8.0, 312.0, 8.0], 4.0);
        }
        // Twenty of 40 × 20 tiles.
        assert!(
            (touched.share() - 0.025).abs() < 1e-9,
            "{}",
            touched.share()
        );
        touched.mark_line([-500.0, -500.0, -90.0, -90.0], 50.0);
        assert!((touched.share() - 0.025).abs() < 1e-9, "out of reach");
        touched.mark_line([-500.0, 160.0, 900.0, 160.0], 1e6);
        assert!((touched.share() - 1.0).abs() < 1e-9, "all");
    }

    #[test]
    fn a_diagonal_touches_no_more_than_a_band() {
        let mut touched = Touched::new((3200, 3200));
        touched.mark_line([0.0, 0.0, 3200.0, 3200.0], 20.0);
        let share = touched.share();
        assert!((0.02..0.06).contains(&share), "{share}");
    }
}
