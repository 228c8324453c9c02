//! The table of the paper, with intervals.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::words;
use crate::evaluation::{
    Estimate, Evaluation, Group, GroupKind, PairedMetric, Scope, ScopeKind, Study,
};

/// Most classes per detector that a printed table holds.
const MAX_GROUPS: usize = 12;

/// AP50 and AP75 per class over detectors and conditions as a LaTeX table, in the layout of the paper's
/// Table 1: detectors and thresholds as row groups, classes as rows, clean and each condition as columns.
///
/// It holds all classes, the supercategories (of data without any: the classes) with numbers, in the
/// region at the study's own τ, or on whole images where there is no region. Needs the packages
/// `booktabs` and `multirow`. Where a number is refused stands `--` with a footnote that says why.
#[must_use]
pub fn latex(study: &Study) -> String {
    let mut detectors: Vec<&str> = Vec::new();
    let mut conditions: Vec<&str> = Vec::new();
    for one in &study.evaluations {
        if !detectors.contains(&one.detector.as_str()) {
            detectors.push(&one.detector);
        }
        if !conditions.contains(&one.condition.name.as_str()) {
            conditions.push(&one.condition.name);
        }
    }
    let mut table = PrintedTable {
        study,
        conditions,
        body: String::new(),
        reasons: Vec::new(),
    };
    for (place, detector) in detectors.iter().enumerate() {
        if place > 0 {
            table.body.push_str("  \\midrule\n");
        }
        table.add_detector(detector);
    }
    table.finish()
}

struct PrintedTable<'a> {
    study: &'a Study,
    conditions: Vec<&'a str>,
    body: String,
    reasons: Vec<String>,
}

impl<'a> PrintedTable<'a> {
    fn evaluations_of(&self, detector: &str) -> Vec<&'a Evaluation> {
        let of = self.study.evaluations.iter();
        of.filter(|one| one.detector == detector).collect()
    }

    fn add_detector(&mut self, detector: &str) {
        let evaluations = self.evaluations_of(detector);
        let Some(scope) = main_scope(self.study, &evaluations) else {
            return;
        };
        let groups = printed_groups(&evaluations, &scope);
        let metrics = [
            PairedMetric::Ap50,
            PairedMetric::Ap75,
            PairedMetric::KittiAp40,
            PairedMetric::KittiAp11,
        ];
        let metrics: Vec<PairedMetric> = metrics
            .into_iter()
            .filter(|metric| {
                let rows = evaluations.iter().flat_map(|one| &one.paired);
                rows.clone()
                    .any(|row| row.metric == *metric && row.scope == scope)
            })
            .collect();
        let n_rows = groups.len() * metrics.len();
        let n_columns = self.conditions.len() + 5;
        let mut is_first = true;
        let mut lines = String::new();
        for (place, metric) in metrics.iter().enumerate() {
            if place > 0 {
                let _ = writeln!(lines, "  \\cmidrule{{2-{n_columns}}}");
            }
            for (row, group) in groups.iter().enumerate() {
                let detector = match is_first {
                    true => format!("\\multirow{{{n_rows}}}{{*}}{{{}}}", escaped(detector)),
                    false => String::new(),
                };
                is_first = false;
                let metric_cell = match row {
                    0 => format!(
                        "\\multirow{{{}}}{{*}}{{{}}}",
                        groups.len(),
                        words::metric(*metric)
                    ),
                    _ => String::new(),
                };
                let cells = self.cells(&evaluations, &scope, group, *metric);
                let _ = writeln!(
                    lines,
                    "  {detector} & {metric_cell} & {} & {} \\\\",
                    escaped(&group_name(group)),
                    cells.join(" & ")
                );
            }
        }
        self.body.push_str(&lines);
    }

    /// How many objects, then clean and each condition.
    fn cells(
        &mut self,
        evaluations: &[&Evaluation],
        scope: &Scope,
        group: &Group,
        metric: PairedMetric,
    ) -> Vec<String> {
        let find = |one: &&Evaluation| {
            let is_it = |row: &&crate::evaluation::PairedRow| {
                row.scope == *scope && row.group == *group && row.metric == metric
            };
            one.paired.iter().find(is_it).cloned()
        };
        let rows: Vec<_> = evaluations.iter().map(|one| (one, find(one))).collect();
        let first = rows.iter().find_map(|(_, row)| row.as_ref());
        // The clean number belongs to the region, and the region to the condition: with several
        // conditions it is that of the first.
        let mut cells = vec![
            first.map_or_else(|| "--".to_owned(), |row| row.n_objects.to_string()),
            first.map_or_else(|| "--".to_owned(), |row| self.number(&row.clean)),
        ];
        for condition in self.conditions.clone() {
            let row = rows
                .iter()
                .find(|(one, _)| one.condition.name == condition)
                .and_then(|(_, row)| row.as_ref());
            cells.push(match row {
                Some(row) => self.number(&row.cracked),
                None => "--".to_owned(),
            });
        }
        cells
    }

    fn number(&mut self, estimate: &Estimate) -> String {
        let print = |value: f64| format!("{:.1}", value * 100.0);
        if let Some(value) = estimate.value {
            let interval = estimate.interval().map_or(String::new(), |[low, high]| {
                format!(" {{\\scriptsize [{}, {}]}}", print(low), print(high))
            });
            return format!("{}{interval}", print(value));
        }
        let Some(why) = &estimate.refused else {
            return "--".to_owned();
        };
        let place = self.reasons.iter().position(|known| known == why);
        let place = place.unwrap_or_else(|| {
            self.reasons.push(why.clone());
            self.reasons.len() - 1
        });
        format!("--\\textsuperscript{{{}}}", place + 1)
    }

    fn finish(self) -> String {
        let Self {
            study,
            conditions,
            body,
            reasons,
        } = self;
        let mut text = String::new();
        let columns = "r".repeat(conditions.len() + 2);
        let heads: Vec<String> = conditions.iter().map(|name| escaped(name)).collect();
        let place = match study.provenance.settings.tau {
            Some(tau) => format!("of objects in the region ($\\tau = {tau}$)"),
            None => "of all objects".to_owned(),
        };
        let _ = writeln!(
            text,
            "% Needs \\usepackage{{booktabs}} and \\usepackage{{multirow}}."
        );
        let _ = writeln!(text, "\\begin{{table*}}");
        let _ = writeln!(text, "  \\centering");
        let _ = writeln!(
            text,
            "  \\caption{{Average precision (\\%) {place}, {}, clean and cracked, with 95\\,\\% intervals.}}",
            escaped(&study.dataset)
        );
        let _ = writeln!(text, "  \\begin{{tabular}}{{lll{columns}}}");
        let _ = writeln!(text, "  \\toprule");
        let _ = writeln!(
            text,
            "  Detector & Metric & Category & $n$ & Clean & {} \\\\",
            heads.join(" & ")
        );
        let _ = writeln!(text, "  \\midrule");
        text.push_str(&body);
        let _ = writeln!(text, "  \\bottomrule");
        let _ = writeln!(text, "  \\end{{tabular}}");
        for (place, reason) in reasons.iter().enumerate() {
            let _ = writeln!(
                text,
                "  \\par{{\\footnotesize \\textsuperscript{{{}}} {}}}",
                place + 1,
                escaped(reason)
            );
        }
        let _ = writeln!(text, "\\end{{table*}}");
        text
    }
}

/// In the region at the study's own τ, else everywhere.
fn main_scope(study: &Study, evaluations: &[&Evaluation]) -> Option<Scope> {
    let tau = study.provenance.settings.tau;
    let scopes = || {
        evaluations
            .iter()
            .flat_map(|one| &one.paired)
            .map(|row| &row.scope)
    };
    let is_own = |scope: &&Scope| match (scope.tau, tau) {
        (Some(one), Some(own)) => (one - own).abs() < 1e-12,
        _ => true,
    };
    scopes()
        .find(|scope| scope.kind == ScopeKind::InRegion && is_own(scope))
        .or_else(|| scopes().next())
        .cloned()
}

fn printed_groups(evaluations: &[&Evaluation], scope: &Scope) -> Vec<Group> {
    let rows = || {
        evaluations
            .iter()
            .flat_map(|one| &one.paired)
            .filter(|row| row.scope == *scope)
    };
    let kinds: BTreeSet<GroupKind> = rows().map(|row| row.group.kind).collect();
    let small = match kinds.contains(&GroupKind::Supercategory) {
        true => GroupKind::Supercategory,
        false => GroupKind::Class,
    };
    let mut groups: Vec<(Group, u64)> = Vec::new();
    for row in rows().filter(|row| row.group.kind == GroupKind::All || row.group.kind == small) {
        if groups.iter().all(|(known, _)| *known != row.group) {
            groups.push((row.group.clone(), row.n_objects));
        }
    }
    groups.sort_by(|a, b| (a.0.kind, b.1, &a.0.name).cmp(&(b.0.kind, a.1, &b.0.name)));
    groups
        .into_iter()
        .map(|(group, _)| group)
        .take(MAX_GROUPS)
        .collect()
}

fn group_name(group: &Group) -> String {
    match group.kind {
        GroupKind::All => "all".to_owned(),
        _ => words::name(&group.name),
    }
}

/// Text as LaTeX sets it, letter by letter; what its fonts may not have becomes a question mark.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for letter in words::name(text).chars() {
        match letter {
            '\\' => escaped.push_str("\\textbackslash{}"),
            '{' | '}' | '$' | '&' | '#' | '_' | '%' => {
                escaped.push('\\');
                escaped.push(letter);
            }
            '^' => escaped.push_str("\\textasciicircum{}"),
            '~' => escaped.push_str("\\textasciitilde{}"),
            '<' => escaped.push_str("\\textless{}"),
            '>' => escaped.push_str("\\textgreater{}"),
            '|' => escaped.push_str("\\textbar{}"),
            '"' => escaped.push_str("\\textquotedbl{}"),
            'τ' => escaped.push_str("$\\tau$"),
            '\u{fffd}' => escaped.push('?'),
            other => escaped.push(other),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::escaped;

    #[test]
    fn letters_that_latex_would_run_are_set() {
        assert_eq!(
            escaped("50% of a_b & \\input{x} #1 $y$ ^~"),
            "50\\% of a\\_b \\& \\textbackslash{}input\\{x\\} \\#1 \\$y\\$ \\textasciicircum{}\\textasciitilde{}",
            "each by its command"
        );
    }
}
