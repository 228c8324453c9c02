//! A line of a YOLO label file.

use std::fmt::Write as _;

use crate::source::moved::{MovedFrame, box_around};

/// A class by number, and its box in shares of the width and height: `x0, y0, x1, y1`.
#[derive(Debug, PartialEq)]
pub(super) struct Label {
    pub(super) class: usize,
    pub(super) shares: [f64; 4],
}

/// How far beyond the frame a share may lie, which rounding does. FIT
const TOLERANCE: f64 = 0.01;

/// The label in a line, `class cx cy w h` or `class x y x y x y …`; nothing for an empty line.
pub(super) fn label_of_line(line: &str) -> Result<Option<Label>, String> {
    let fields: Vec<&str> = line.split_ascii_whitespace().collect();
    let Some((class, shares)) = fields.split_first() else {
        return Ok(None);
    };
    if shares.len() != 4 && (shares.len() < 6 || !shares.len().is_multiple_of(2)) {
        return Err(format!(
            "{} fields, expected class cx cy w h, or a class and 3 or more corners x y",
            fields.len()
        ));
    }
    let class = class
        .parse()
        .map_err(|_| format!("the class {class:?} is not a whole number from 0 on"))?;
    let mut values = Vec::with_capacity(shares.len());
    for text in shares {
        let value: f64 = text
            .parse()
            .map_err(|_| format!("the share {text:?} is not a number"))?;
        if !(-TOLERANCE..=1.0 + TOLERANCE).contains(&value) {
            return Err(format!("the share {text} is outside 0 to 1"));
        }
        values.push(value);
    }
    let shares = match values[..] {
        [cx, cy, w, h] => {
            if w < 0.0 || h < 0.0 {
                return Err(format!("the box of {w} x {h} has a negative side"));
            }
            [cx - w / 2.0, cy - h / 2.0, cx + w / 2.0, cy + h / 2.0]
        }
        _ => {
            let mut box_of = [
                f64::INFINITY,
                f64::INFINITY,
                f64::NEG_INFINITY,
                f64::NEG_INFINITY,
            ];
            let (corners, _) = values.as_chunks::<2>();
            for [x, y] in corners {
                let [x0, y0, x1, y1] = box_of;
                box_of = [x0.min(*x), y0.min(*y), x1.max(*x), y1.max(*y)];
            }
            box_of
        }
    };
    Ok(Some(Label { class, shares }))
}

/// The line of a label once what its image shows is moved, with its box `x0, y0, x1, y1`, px; none where nothing of it is
/// left in the frame.
pub(super) fn moved_line(
    line: &str,
    label: &Label,
    frame: &MovedFrame,
) -> Option<(String, [f64; 4])> {
    let size = frame.size();
    let fields: Vec<&str> = line.split_ascii_whitespace().collect();
    let (class, numbers) = fields.split_first()?;
    let (corners_px, shares) = if numbers.len() == 4 {
        let [x0, y0, x1, y1] = label.shares;
        let [w, h] = size;
        let moved = frame.box_px([x0 * w, y0 * h, x1 * w, y1 * h])?.corners_px;
        let [x0, y0, x1, y1] = moved;
        let middle = [0.5 * (x0 + x1) / w, 0.5 * (y0 + y1) / h];
        (moved, vec![middle, [(x1 - x0) / w, (y1 - y0) / h]])
    } else {
        let shares: Option<Vec<f64>> = numbers.iter().map(|text| text.parse().ok()).collect();
        let (corners, _) = shares.as_deref()?.as_chunks::<2>();
        let corners: Vec<_> = corners
            .iter()
            .map(|at| [at[0] * size[0], at[1] * size[1]])
            .collect();
        let moved = frame.outline(&corners);
        let shares = moved.iter().map(|at| [at[0] / size[0], at[1] / size[1]]);
        (box_around(&moved)?, shares.collect())
    };
    let mut text = (*class).to_owned();
    for share in shares.as_flattened() {
        let _ = write!(text, " {share:.7}");
    }
    Some((text, corners_px))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_is_given_by_its_center_and_a_polygon_by_its_corners() {
        let expected = Some(Label {
            class: 7,
            shares: [0.25, 0.375, 0.75, 0.625],
        });
        for line in [
            "7 0.5 0.5 0.5 0.25",
            "  7\t0.5 0.5  0.5 0.25 ",
            "7 0.25 0.5 0.5 0.375 0.75 0.5 0.5 0.625",
        ] {
            assert_eq!(label_of_line(line).as_ref(), Ok(&expected), "{line:?}");
        }
        assert_eq!(label_of_line(" "), Ok(None), "an empty line");
    }

    #[test]
    fn what_is_neither_is_refused() {
        for line in [
            "7",
            "7 0.5 0.5 0.5",
            "7 0.5 0.5 0.5 0.25 0.9",
            "7 0 0 1 1 0.5 0.5 0.5",
            "-1 0.5 0.5 1 1",
            "1.5 0.5 0.5 1 1",
            "car 0.5 0.5 1 1",
            "7 nan 0.5 1 1",
            "7 0.5 inf 1 1",
            "7 640 360 20 20",
            "7 0.5 0.5 -0.001 0.2",
            "7 0.5 0.5 0,5 0.2",
        ] {
            let label = label_of_line(line);
            assert!(label.is_err(), "{line:?} gave {label:?}");
        }
    }
}
