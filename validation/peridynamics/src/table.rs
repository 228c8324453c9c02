//! What was expected and what came out.

use std::fmt;

/// One law and its check.
#[derive(Clone, Debug)]
pub struct Check {
    /// What is compared.
    pub law: String,
    /// What it should be, in words.
    pub expected: String,
    /// What came out, with its unit.
    pub got: String,
    /// How far off it may be.
    pub tolerance: String,
    /// Where the expectation comes from.
    pub source: String,
    /// Whether it holds; nothing where the row only reports.
    pub holds: Option<bool>,
}

impl Check {
    /// A row.
    #[must_use]
    pub fn new(law: &str, expected: &str, got: String, tolerance: &str, source: &str) -> Self {
        let [law, expected, tolerance, source] =
            [law, expected, tolerance, source].map(str::to_owned);
        Self {
            law,
            expected,
            got,
            tolerance,
            source,
            holds: None,
        }
    }

    /// The row with its verdict.
    #[must_use]
    pub const fn judged(mut self, holds: bool) -> Self {
        self.holds = Some(holds);
        self
    }

    fn cells(&self) -> [&str; 6] {
        let verdict = match self.holds {
            Some(true) => "pass",
            Some(false) => "FAIL",
            None => "-",
        };
        [
            &self.law,
            &self.expected,
            &self.got,
            &self.tolerance,
            verdict,
            &self.source,
        ]
    }
}

/// Rows under their heads, in columns.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// The rows.
    pub checks: Vec<Check>,
}

impl Table {
    /// Whether no row fails.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.checks.iter().all(|check| check.holds != Some(false))
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let head = ["law", "expected", "got", "tolerance", "", "source"];
        let rows = || std::iter::once(head).chain(self.checks.iter().map(Check::cells));
        let mut widths = [0; 6];
        for row in rows() {
            for (width, cell) in widths.iter_mut().zip(row) {
                *width = cell.chars().count().max(*width);
            }
        }
        for row in rows() {
            let mut line = String::new();
            for (width, cell) in widths.into_iter().zip(row) {
                line.push_str(&format!("{cell:width$}  "));
            }
            writeln!(f, "{}", line.trim_end())?;
        }
        Ok(())
    }
}

/// Least squares of log y over log x: the exponent of y ∝ xᵖ and its standard error.
#[must_use]
pub fn exponent(points: &[(f64, f64)]) -> (f64, f64) {
    let n = crate::lattice::as_f64(points.len());
    let logs: Vec<_> = points
        .iter()
        .map(|(x, y)| (libm::log(*x), libm::log(*y)))
        .collect();
    let mean_x = logs.iter().map(|p| p.0).sum::<f64>() / n;
    let mean_y = logs.iter().map(|p| p.1).sum::<f64>() / n;
    let spread: f64 = logs.iter().map(|p| (p.0 - mean_x) * (p.0 - mean_x)).sum();
    let joint: f64 = logs.iter().map(|p| (p.0 - mean_x) * (p.1 - mean_y)).sum();
    let slope = joint / spread;
    let rest: f64 = logs
        .iter()
        .map(|p| {
            let off = p.1 - mean_y - slope * (p.0 - mean_x);
            off * off
        })
        .sum();
    (slope, libm::sqrt(rest / (n - 2.0) / spread))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponent_of_a_power() {
        let points: Vec<_> = [1.0, 2.0, 5.0, 9.0]
            .map(|x: f64| (x, 3.0 * x.powf(0.5)))
            .to_vec();
        let (slope, error) = exponent(&points);
        assert!(
            (slope - 0.5).abs() < 1e-12 && error < 1e-9,
            "{slope} ± {error}"
        );
    }

    #[test]
    fn a_table_fails_with_one_row() {
        let row = |holds| Check::new("a", "1", "2".to_owned(), "0", "b").judged(holds);
        let table = Table {
            checks: vec![row(true), row(false)],
        };
        assert!(!table.holds(), "one fails");
        assert!(table.to_string().contains("FAIL"), "and says so");
        assert!(
            Table {
                checks: vec![row(true)]
            }
            .holds(),
            "none fails"
        );
    }
}
