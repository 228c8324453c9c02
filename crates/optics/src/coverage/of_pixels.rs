//! Coverage that is known pixel by pixel.

use super::{Cell, Coverage, LEAST, Window};
use crate::bit_rows::BitRows;

impl Coverage {
    /// The coverage of a `width × height` frame of which each pixel's (x, y) coverage, 0 to 1, and
    /// weight are known.
    pub fn of_pixels(width: u32, height: u32, pixel: impl Fn(usize, usize) -> (f32, f32)) -> Self {
        let (width, height) = (width as usize, height as usize);
        let mut cells = Vec::with_capacity(width * height);
        let mut touched = BitRows::new(width, height);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let (covered, weighted) = pixel(x, y);
            if covered >= LEAST {
                touched.set_run(y, x, x + 1);
            }
            cells.push(Cell {
                covered: covered.min(1.0),
                weighted,
            });
        }
        Self {
            width,
            height,
            window: Window {
                x: 0,
                y: 0,
                width,
                height,
            },
            cells,
            touched,
        }
    }
}
