//! What was expected and what came out.

use std::error::Error;

/// Rows, or why they could not be measured.
pub(crate) type Rows = Result<Vec<Row>, Box<dyn Error>>;

/// What measures some rows.
pub(crate) type Measure = fn() -> Rows;

/// One law and its check.
#[derive(Debug, Clone)]
pub(crate) struct Row {
    law: String,
    expected: String,
    got: String,
    tolerance: String,
    source: &'static str,
    /// Whether it holds; nothing where the row only reports.
    holds: Option<bool>,
}

impl Row {
    /// A row that only reports.
    pub(crate) fn report(law: &str, expected: &str, got: String, source: &'static str) -> Self {
        Self {
            law: law.to_owned(),
            expected: expected.to_owned(),
            got,
            tolerance: "reported".to_owned(),
            source,
            holds: None,
        }
    }

    /// A row whose figure either holds or not.
    pub(crate) fn judged(
        law: &str,
        expected: &str,
        got: String,
        tolerance: &str,
        source: &'static str,
        holds: bool,
    ) -> Self {
        Self {
            tolerance: tolerance.to_owned(),
            holds: Some(holds),
            ..Self::report(law, expected, got, source)
        }
    }

    /// A row for what something else checks: unit tests, which see what is private.
    pub(crate) fn elsewhere(law: &str, expected: &str, place: &str) -> Self {
        let got = format!("see {place}");
        Self {
            tolerance: "-".to_owned(),
            ..Self::report(law, expected, got, "-")
        }
    }

    pub(crate) fn fails(&self) -> bool {
        self.holds == Some(false)
    }

    fn cells(&self) -> [&str; 6] {
        let verdict = match self.holds {
            Some(true) => "ok",
            Some(false) => "FAIL",
            None => "info",
        };
        [
            &self.law,
            &self.expected,
            &self.got,
            &self.tolerance,
            self.source,
            verdict,
        ]
    }
}

/// The rows under their heads.
pub(crate) fn text(rows: &[Row]) -> String {
    let heads = ["law", "expected", "got", "tolerance", "source", ""];
    let all = || std::iter::once(heads).chain(rows.iter().map(Row::cells));
    let mut widths = [0; 6];
    for cells in all() {
        for (width, cell) in widths.iter_mut().zip(cells) {
            *width = cell.chars().count().max(*width);
        }
    }
    let mut text = String::new();
    for cells in all() {
        let line: Vec<String> = widths
            .into_iter()
            .zip(cells)
            .map(|(width, cell)| format!("{cell:width$}"))
            .collect();
        text.push_str(line.join(" | ").trim_end());
        text.push('\n');
    }
    text
}

/// Slope of the line of least squares of ln y over ln x.
pub(crate) fn exponent(points: &[(f64, f64)]) -> f64 {
    let n = points.iter().map(|_| 1.0).sum::<f64>();
    let logs = points.iter().map(|&(x, y)| (libm::log(x), libm::log(y)));
    let (sum_x, sum_y) = logs
        .clone()
        .fold((0.0, 0.0), |(sx, sy), (x, y)| (sx + x, sy + y));
    let (mean_x, mean_y) = (sum_x / n, sum_y / n);
    let (joint, spread) = logs.fold((0.0, 0.0), |(joint, spread), (x, y)| {
        let dx = x - mean_x;
        (joint + dx * (y - mean_y), spread + dx * dx)
    });
    joint / spread
}
