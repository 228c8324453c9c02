//! Pictures side by side on one sheet, each with a caption.

use image::RgbImage;
use image::imageops::{FilterType, replace, resize};
use starbreak_eval::chart::{Anchor, Shape};

use super::raster;

/// Pictures wider than this are scaled down on the sheet, px.
const CELL_PX: u32 = 640;

/// Narrower cells have no room for a caption, px.
const LEAST_CELL_PX: u32 = 440;

/// Between pictures and around them, px.
const GAP_PX: u32 = 12;

/// Height of a line of text with the space below it, px.
const LINE_PX: u32 = 20;

/// Size of text, px.
const TEXT_PX: u32 = 13;

/// Characters that fit the narrowest cell.
const MOST_CHARACTERS: usize = 56;

/// Width over height that a sheet comes near to.
const ASPECT: f64 = 1.5;

/// A picture with the two lines below it.
pub(super) struct Cell {
    pub(super) picture: RgbImage,
    pub(super) caption: [String; 2],
}

impl Cell {
    /// A picture as it is on the sheet, which is no wider than 640 px.
    pub(super) fn new(picture: &RgbImage, caption: [String; 2]) -> Self {
        let (width, height) = picture.dimensions();
        let picture = if width > CELL_PX {
            let scaled = (u64::from(height) * u64::from(CELL_PX) / u64::from(width)).max(1);
            let scaled = u32::try_from(scaled).unwrap_or(height);
            resize(picture, CELL_PX, scaled, FilterType::Triangle)
        } else {
            picture.clone()
        };
        Self { picture, caption }
    }
}

/// The sheet of some pictures, row by row, under a title.
pub(super) fn contact_sheet(title: &str, cells: &[Cell]) -> RgbImage {
    let sides = |of: &dyn Fn(&RgbImage) -> u32| cells.iter().map(|cell| of(&cell.picture)).max();
    let width = sides(&RgbImage::width).unwrap_or(0).max(LEAST_CELL_PX) + GAP_PX;
    let picture_height = sides(&RgbImage::height).unwrap_or(0);
    let height = picture_height + 2 * LINE_PX + GAP_PX;
    let n_cells = u32::try_from(cells.len()).unwrap_or(u32::MAX).max(1);
    let columns = columns(n_cells, (width, height));
    let rows = n_cells.div_ceil(columns);
    let size = (
        columns * width + GAP_PX,
        rows * height + LINE_PX + 2 * GAP_PX,
    );

    let mut sheet = RgbImage::from_pixel(size.0, size.1, [255; 3].into());
    write(&mut sheet, title, (GAP_PX, GAP_PX));
    let place = |k: u32| {
        let (column, row) = (k % columns, k / columns);
        (GAP_PX + column * width, 2 * GAP_PX + LINE_PX + row * height)
    };
    for (k, cell) in (0..).zip(cells) {
        let (x, y) = place(k);
        for (line, text) in (0..).zip(&cell.caption) {
            let below = y + cell.picture.height() + line * LINE_PX;
            write(&mut sheet, text, (x, below));
        }
        replace(&mut sheet, &cell.picture, i64::from(x), i64::from(y));
    }
    sheet
}

/// Cells in a row, so that the sheet has nearly the wanted shape.
fn columns(n_cells: u32, (width, height): (u32, u32)) -> u32 {
    let strangeness = |columns: u32| {
        let rows = n_cells.div_ceil(columns);
        let shape = f64::from(columns * width) / f64::from(rows * height);
        (shape / ASPECT).ln().abs()
    };
    (1..=n_cells)
        .min_by(|a, b| strangeness(*a).total_cmp(&strangeness(*b)))
        .unwrap_or(1)
}

fn write(sheet: &mut RgbImage, text: &str, (x, y): (u32, u32)) {
    let is_long = text.chars().count() > MOST_CHARACTERS;
    let content = if is_long {
        let short: String = text.chars().take(MOST_CHARACTERS - 1).collect();
        format!("{short}…")
    } else {
        text.to_owned()
    };
    let words = Shape::Words {
        // The line that letters stand on.
        at: [x, y + TEXT_PX].map(f64::from),
        text: content,
        size_px: f64::from(TEXT_PX),
        anchor: Anchor::Start,
        turn_deg: 0.0,
        color: "#000000".into(),
    };
    raster::draw(sheet, &words, 1.0);
}
