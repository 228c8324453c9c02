//! A frame whose pixels come from other places.

/// Form of the light of a frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Channel {
    /// Values per pixel, side by side.
    pub(super) n: usize,
    /// Width and height, px.
    pub(super) size: (usize, usize),
}

/// The light of each pixel as it was at another place, px, which is said of its middle; black where there is none.
/// Beyond the frame its border goes on.
///
/// Between pixels by the cubic of Keys \[Keys1981\], which keeps what is a straight line or a parabola: a frame that is
/// moved by half a pixel is not blurred as by a mean of neighbors. It gives no light below 0.
pub(super) fn resample(
    light: &[f32],
    Channel {
        n,
        size: (width, height),
    }: Channel,
    from: impl Fn(f64, f64) -> Option<[f64; 2]>,
) -> Vec<f32> {
    let mut out = vec![0.0; light.len()];
    for (y, row) in out.chunks_exact_mut(width * n).enumerate() {
        for (x, pixel) in row.chunks_exact_mut(n).enumerate() {
            #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
            let Some([u, v]) = from(x as f64 + 0.5, y as f64 + 0.5) else {
                continue;
            };
            let (left, across) = taps(u);
            let (top, down) = taps(v);
            for (k, down) in (top..).zip(down) {
                let row = clamped(k, height) * width;
                for (k, across) in (left..).zip(across) {
                    let at = (row + clamped(k, width)) * n;
                    let share = down * across;
                    for (to, from) in pixel.iter_mut().zip(&light[at..at + n]) {
                        *to += share * from;
                    }
                }
            }
            pixel.iter_mut().for_each(|value| *value = value.max(0.0));
        }
    }
    out
}

/// The first of four pixels around a place, px, and their shares.
#[expect(
    clippy::cast_possible_truncation,
    reason = "px of a frame; shares of light"
)]
fn taps(place: f64) -> (isize, [f32; 4]) {
    let place = place - 0.5;
    let whole = place.floor();
    let t = (place - whole) as f32;
    let (t2, t3) = (t * t, t * t * t);
    let shares = [
        0.5 * (-t + 2.0 * t2 - t3),
        0.5 * (2.0 - 5.0 * t2 + 3.0 * t3),
        0.5 * (t + 4.0 * t2 - 3.0 * t3),
        0.5 * (t3 - t2),
    ];
    (whole as isize - 1, shares)
}

fn clamped(k: isize, n: usize) -> usize {
    k.clamp(0, n.cast_signed() - 1).cast_unsigned()
}
