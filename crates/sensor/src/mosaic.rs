//! The color filters on the sensor, and the colors that are made of what is behind them.
//!
//! Each pixel sees one color, in Bayer's pattern: red and green alternate in even rows, green and blue in odd
//! ones. The missing two are interpolated linearly from 5 x 5 px \[Malvar2004\]. Beyond the border the mosaic is
//! mirrored, so that the pattern goes on.

/// What white balance multiplies red, green and blue by, in daylight: the filters let through less red and blue
/// \[Brooks2019\].
pub(crate) const WHITE_BALANCE: [f32; 3] = [2.0, 1.0, 1.7];

/// Red, green or blue.
#[inline]
pub(crate) fn color_at(x: usize, y: usize) -> usize {
    (x & 1) + (y & 1)
}

/// A mosaic with two mirrored pixels around it.
#[derive(Debug, Clone)]
pub(crate) struct Padded {
    stride: usize,
    values: Vec<f32>,
}

/// Pixels that an interpolation reaches to.
pub(crate) const REACH: usize = 2;

impl Padded {
    /// The mosaic of a frame.
    pub(crate) fn of(mosaic: &[f32], width: usize, height: usize) -> Self {
        let stride = width + 2 * REACH;
        let mut values = Vec::with_capacity(stride * (height + 2 * REACH));
        for row in 0..height + 2 * REACH {
            let y = mirrored(row, height);
            let row = &mosaic[y * width..(y + 1) * width];
            values.extend((0..REACH).map(|x| row[mirrored(x, width)]));
            values.extend_from_slice(row);
            values.extend((width + REACH..stride).map(|x| row[mirrored(x, width)]));
        }
        Self { stride, values }
    }

    /// Red, green and blue of each pixel of a row.
    pub(crate) fn colors_of_row(&self, y: usize, mut put: impl FnMut(usize, [f32; 3])) {
        let rows: [&[f32]; 5] = std::array::from_fn(|dy| {
            let at = (y + dy) * self.stride;
            &self.values[at..at + self.stride]
        });
        let windows = rows.map(|row| row.windows(2 * REACH + 1));
        let [up2, up, here, down, down2] = windows;
        let columns = up2.zip(up).zip(here).zip(down).zip(down2);
        for (x, ((((up2, up), here), down), down2)) in columns.enumerate() {
            put(x, interpolated(x, y, [up2, up, here, down, down2]));
        }
    }
}

/// Red, green and blue of a pixel of a mosaic that is zero nearly everywhere.
pub(crate) fn colors_at(mosaic: &[f32], size: (usize, usize), at: usize) -> [f32; 3] {
    let (width, height) = size;
    let (x, y) = (at % width, at / width);
    let near: [[f32; 5]; 5] = std::array::from_fn(|dy| {
        let row = mirrored(y + dy, height) * width;
        std::array::from_fn(|dx| mosaic[row + mirrored(x + dx, width)])
    });
    interpolated(x, y, near.each_ref().map(|row| row.as_slice()))
}

/// The colors of a pixel out of 5 x 5 around it.
#[inline(always)]
fn interpolated(x: usize, y: usize, [up2, up, here, down, down2]: [&[f32]; 5]) -> [f32; 3] {
    let center = here[2];
    let near_h = here[1] + here[3];
    let near_v = up[2] + down[2];
    let far_h = here[0] + here[4];
    let far_v = up2[2] + down2[2];
    let diagonal = up[1] + up[3] + down[1] + down[3];
    let along = |near: f32, far_along: f32, far_across: f32| {
        (5.0 * center + 4.0 * near - diagonal - far_along + 0.5 * far_across) / 8.0
    };
    match color_at(x, y) {
        1 => {
            let in_row = along(near_h, far_h, far_v);
            let in_column = along(near_v, far_v, far_h);
            match y & 1 {
                0 => [in_row, center, in_column],
                _ => [in_column, center, in_row],
            }
        }
        own => {
            let far = far_h + far_v;
            let green = (4.0 * center + 2.0 * (near_h + near_v) - far) / 8.0;
            let other = (6.0 * center + 2.0 * diagonal - 1.5 * far) / 8.0;
            match own {
                0 => [center, green, other],
                _ => [other, green, center],
            }
        }
    }
}

/// The row or column that stands at a place of the padded frame.
fn mirrored(at: usize, n: usize) -> usize {
    let period = 2 * n.saturating_sub(1).max(1);
    // The place in the frame, moved by whole periods so that it is not negative.
    let place = (at + REACH * period - REACH) % period;
    place.min(period - place).min(n - 1)
}

/// Red, green and blue of every pixel of a mosaic of light, in rows from the top.
///
/// # Panics
/// If the values do not fill the frame.
#[must_use]
pub fn demosaic(mosaic: &[f32], (width, height): (usize, usize)) -> Vec<[f32; 3]> {
    assert_eq!(mosaic.len(), width * height, "a value for each pixel");
    let padded = Padded::of(mosaic, width, height);
    let mut colors = Vec::with_capacity(mosaic.len());
    for y in 0..height {
        padded.colors_of_row(y, |_, rgb| colors.push(rgb));
    }
    colors
}

#[cfg(test)]
mod tests {
    use super::mirrored;

    #[test]
    fn beyond_the_border_the_frame_is_mirrored_without_its_last_pixel() {
        let row = |n: usize| (0..n + 4).map(|at| mirrored(at, n)).collect::<Vec<_>>();
        assert_eq!(row(5), [2, 1, 0, 1, 2, 3, 4, 3, 2], "five");
        assert_eq!(row(2), [0, 1, 0, 1, 0, 1], "two");
        assert_eq!(row(1), [0, 0, 0, 0, 0], "one");
    }
}
