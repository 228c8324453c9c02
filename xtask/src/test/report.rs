//! What cargo test prints, read line by line.

use std::fmt;

/// Sums of all `test result:` lines, and what was skipped.
#[derive(Debug, Default)]
pub(super) struct Report {
    n_passed: usize,
    n_failed: usize,
    n_ignored: usize,
    skipped: Vec<String>,
    is_in_output_of_passed: bool,
    test: String,
}

impl Report {
    /// Reads one line, and says whether to print it: the output of tests that passed is not.
    pub(super) fn read(&mut self, line: &str) -> bool {
        if line == "successes:" {
            self.is_in_output_of_passed = true;
        } else if line == "failures:" || line.starts_with("test result:") {
            self.is_in_output_of_passed = false;
        }
        if let Some(counts) = line.strip_prefix("test result:") {
            self.n_passed += count(counts, "passed");
            self.n_failed += count(counts, "failed");
            self.n_ignored += count(counts, "ignored");
        }
        let headline = line.strip_prefix("---- ");
        if let Some(name) = headline.and_then(|rest| rest.strip_suffix(" stdout ----")) {
            name.clone_into(&mut self.test);
        }
        if let Some(why) = line.strip_prefix("SKIPPED:") {
            self.skipped.push(format!("{}: {}", self.test, why.trim()));
        }
        if let Some((name, outcome)) = line
            .strip_prefix("test ")
            .and_then(|rest| rest.split_once(" ... "))
            && let Some(why) = outcome.strip_prefix("ignored")
        {
            let why = why.trim_start_matches(',').trim();
            let why = if why.is_empty() { "ignored" } else { why };
            self.skipped.push(format!("{name}: {why}"));
        }
        !self.is_in_output_of_passed
    }

    /// Reads one line of pytest: its sum (`3 passed, 1 skipped in 0.12s`) or a test that was skipped
    /// (`SKIPPED [1] tests/a.py:3: why`).
    pub(super) fn read_pytest(&mut self, line: &str) {
        if let Some((place, why)) = line
            .strip_prefix("SKIPPED [")
            .and_then(|rest| rest.split_once("] "))
            .and_then(|(_, rest)| rest.split_once(": "))
        {
            self.skipped.push(format!("{place}: {}", why.trim()));
        }
        let counts = line.trim_matches('=').trim();
        let Some((counts, _)) = counts.split_once(" in ") else {
            return;
        };
        let n = |word: &str| -> usize {
            let parts = counts.split(", ");
            let of_word =
                parts.filter_map(|part| part.strip_suffix(word)?.trim().parse::<usize>().ok());
            of_word.sum()
        };
        self.n_passed += n("passed");
        self.n_failed += n("failed") + n("error") + n("errors");
    }

    /// Notes what was skipped and why.
    pub(super) fn skip(&mut self, what: &str, why: &str) {
        self.skipped.push(format!("{what}: {why}"));
    }

    /// What was skipped and why, one line each.
    pub(super) fn skipped(&self) -> &[String] {
        &self.skipped
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} passed, {} failed, {} ignored, {} skipped",
            self.n_passed,
            self.n_failed,
            self.n_ignored,
            // A test that is ignored is counted as such.
            self.skipped.len().saturating_sub(self.n_ignored)
        )
    }
}

/// The number before a word: `… 12 passed; …`.
fn count(counts: &str, word: &str) -> usize {
    counts
        .split([';', '.'])
        .filter_map(|part| part.trim().strip_suffix(word))
        .filter_map(|number| number.trim().parse::<usize>().ok())
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_of_pytest_are_added_and_what_it_skips_is_kept() {
        let mut report = Report::default();
        for line in [
            "....s.F   [100%]",
            "E   AssertionError: 3 passed, or so it seems",
            "SKIPPED [1] tests/test_a.py:3: no fork here: sorry",
            "1 failed, 152 passed, 1 skipped, 2 errors in 83.56s (0:01:23)",
        ] {
            report.read_pytest(line);
        }
        assert_eq!(
            report.to_string(),
            "152 passed, 3 failed, 0 ignored, 1 skipped",
            "sums"
        );
        assert_eq!(
            report.skipped(),
            ["tests/test_a.py:3: no fork here: sorry"],
            "reasons"
        );
    }

    #[test]
    fn counts_are_summed_and_output_of_passed_tests_is_hidden() {
        let text = "\
running 3 tests
test a ... ok
test slow ... ignored, takes minutes
test b ... FAILED

successes:

---- a stdout ----
12 passed; but that is not a result
SKIPPED: there is no mkfifo

failures:

---- b stdout ----
assertion failed

test result: FAILED. 1 passed; 1 failed; 1 ignored; 0 measured; 0 filtered out; finished in 0.00s
test result: ok. 4 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 1.20s";
        let mut report = Report::default();
        let shown: Vec<&str> = text.lines().filter(|line| report.read(line)).collect();
        assert_eq!(
            report.to_string(),
            "5 passed, 1 failed, 1 ignored, 1 skipped",
            "sums"
        );
        assert_eq!(
            report.skipped(),
            ["slow: takes minutes", "a: there is no mkfifo"],
            "reasons"
        );
        assert!(shown.contains(&"assertion failed"), "failures are shown");
        assert!(
            !shown.contains(&"SKIPPED: there is no mkfifo"),
            "output of passed tests is not"
        );
    }
}
