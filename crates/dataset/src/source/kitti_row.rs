//! One line of a KITTI file.

use super::moved::MovedBox;
use super::record::ObjectKind;

/// A line of a KITTI file: a label, or a result, which has a score.
#[derive(Debug, Clone, PartialEq)]
pub struct KittiRow {
    /// Its type.
    pub category: String,
    /// The numbers behind it: truncation, occlusion, angle, box, 3-D size, place and turn, score;
    /// the score of a label is NaN.
    pub numbers: [f64; 15],
}

impl KittiRow {
    /// Longest file of a frame, in bytes; real ones have a few kilobytes. FIT
    pub const MAX_FILE_BYTES: u64 = 16 << 20;

    /// The row of a line of 15 fields, or 16 with a score; `None` for an empty line.
    ///
    /// # Errors
    /// What is wrong with the line.
    pub fn parse(line: &str) -> Result<Option<Self>, String> {
        let fields: Vec<&str> = line.split_ascii_whitespace().collect();
        let Some((category, rest)) = fields.split_first() else {
            return Ok(None);
        };
        if !matches!(fields.len(), 15 | 16) {
            let n_fields = fields.len();
            return Err(format!(
                "{n_fields} fields; expected 15, or 16 with a score"
            ));
        }
        let mut numbers = [f64::NAN; 15];
        for ((idx, number), text) in numbers.iter_mut().enumerate().zip(rest) {
            let parsed = text.parse().ok().filter(|value: &f64| value.abs() <= 1e9);
            *number = parsed.ok_or_else(|| {
                let field = idx + 2;
                format!("field {field} = {text:?} is not a finite number within 1e9 of 0")
            })?;
        }
        Ok(Some(Self {
            category: (*category).to_owned(),
            numbers,
        }))
    }

    /// Its box `x0, y0, x1, y1`, px.
    #[must_use]
    pub fn corners_px(&self) -> [f64; 4] {
        let [_, _, _, x0, y0, x1, y1, ..] = self.numbers;
        [x0, y0, x1, y1]
    }

    /// Its box, which a label must have.
    ///
    /// # Errors
    /// Where the box ends before it begins.
    pub fn label_corners_px(&self) -> Result<[f64; 4], String> {
        let corners @ [x0, y0, x1, y1] = self.corners_px();
        if x1 < x0 || y1 < y0 {
            return Err(format!("the box {corners:?} px ends before it begins"));
        }
        Ok(corners)
    }
}

/// A label of which the box is moved and cut to the frame; the rest of it stays in its very characters, but for the share
/// of the object that is cut off, which is raised by what the frame cuts off.
pub(super) fn moved_line(line: &str, row: &KittiRow, moved: &MovedBox) -> String {
    let mut replaced: [Option<String>; 8] = Default::default();
    for (field, at) in replaced[4..].iter_mut().zip(moved.corners_px) {
        *field = Some(format!("{at:.2}"));
    }
    let truncated = row.numbers[0];
    if truncated >= 0.0 && moved.kept < 1.0 {
        let left = (1.0 - truncated).max(0.0) * moved.kept;
        replaced[1] = Some(format!("{:.2}", 1.0 - left));
    }
    let mut text = String::with_capacity(line.len());
    let mut rest = line;
    let mut replaced = replaced.into_iter();
    while !rest.is_empty() {
        let begin = rest
            .find(|c: char| !c.is_ascii_whitespace())
            .unwrap_or(rest.len());
        let end = rest[begin..].find(|c: char| c.is_ascii_whitespace());
        let end = end.map_or(rest.len(), |at| begin + at);
        text.push_str(&rest[..begin]);
        let new = if begin < end {
            replaced.next().flatten()
        } else {
            None
        };
        text.push_str(new.as_deref().unwrap_or(&rest[begin..end]));
        rest = &rest[end..];
    }
    text
}

impl ObjectKind {
    /// How KITTI's benchmarks treat an object of a type: `DontCare`, in whatever letters, is an area
    /// in which nothing is labeled, as the development kit has it.
    #[must_use]
    pub fn of_kitti_type(category: &str) -> Self {
        if category.eq_ignore_ascii_case("DontCare") {
            Self::Ignored
        } else {
            Self::Regular
        }
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::float_cmp, reason = "numbers as they are written")]

    use super::*;

    const LABEL: &str = "Car 0.5 1 -1.57 10 20 30.5 40 1.5 1.6 3.9 1 2 30 0.1";

    #[test]
    fn a_label_has_no_score_and_a_result_has_one() {
        let read = |line: &str| KittiRow::parse(line).ok().flatten();
        let label = read(LABEL);
        let result = read(&format!("{LABEL} 0.75"));

        let label = label.as_ref().map(|row| (row.corners_px(), row.numbers));
        let Some((corners, numbers)) = label else {
            panic!("a label is read");
        };
        assert_eq!(corners, [10.0, 20.0, 30.5, 40.0]);
        assert!(numbers[14].is_nan(), "a label has no score");
        assert_eq!(result.map(|row| row.numbers[14]), Some(0.75));
        assert_eq!(KittiRow::parse("  "), Ok(None), "an empty line");
    }

    #[test]
    fn what_is_no_box_stays_in_its_very_characters() {
        let moved = |line: &str, kept| {
            let moved = MovedBox {
                corners_px: [9.0, 20.25, 31.5, 41.999],
                kept,
            };
            let row = KittiRow::parse(line).ok().flatten();
            row.map(|row| moved_line(line, &row, &moved))
                .unwrap_or_default()
        };
        assert_eq!(
            moved(&format!("{LABEL}\t0.75 "), 1.0),
            "Car 0.5 1 -1.57 9.00 20.25 31.50 42.00 1.5 1.6 3.9 1 2 30 0.1\t0.75 ",
            "nothing is cut off"
        );
        assert!(
            moved(LABEL, 0.8).starts_with("Car 0.60 1 -1.57 9.00"),
            "1 - (1 - 0.5) 0.8"
        );
        let area = moved(&LABEL.replace("Car 0.5", "DontCare -1"), 0.8);
        assert!(area.starts_with("DontCare -1 1"), "{area}");
    }

    #[test]
    fn what_is_no_row_is_refused_by_field() {
        let wrong = |line: String| KittiRow::parse(&line).err().unwrap_or_default();
        assert!(wrong("Car 1 2".to_owned()).starts_with("3 fields"));
        assert!(wrong(LABEL.replace("40", "NaN")).starts_with("field 8 = \"NaN\""));
        assert!(wrong(LABEL.replace("40", "2e9")).starts_with("field 8"));
        let turned = KittiRow::parse(&LABEL.replace("30.5", "9")).ok().flatten();
        assert!(
            turned.is_some_and(|row| row.label_corners_px().is_err()),
            "x1 < x0"
        );
    }

    #[test]
    fn areas_are_known_in_whatever_letters() {
        for name in ["DontCare", "dontcare", "DONTCARE"] {
            assert_eq!(
                ObjectKind::of_kitti_type(name),
                ObjectKind::Ignored,
                "{name}"
            );
        }
        assert_eq!(ObjectKind::of_kitti_type("Car"), ObjectKind::Regular);
    }
}
