//! Tables to print: a column of the main numbers, and the table of the paper with intervals.

mod summary;

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::conditions::{Told, printed};
use super::words;
use crate::evaluation::{
    Estimate, Group, GroupKind, PairedMetric, PairedRow, Scope, ScopeKind, Study,
};

/// Most classes per detector that a printed table holds.
const MAX_GROUPS: usize = 12;

/// Most conditions side by side: with intervals more do not fit a page.
const MAX_CONDITIONS: usize = 2;

/// LaTeX tables: first one of a column's width, with AP50, difference and p of all classes together
/// under each condition; then AP50 and AP75 per class over detectors and conditions, in the layout of the
/// paper's Table 1: detectors and thresholds as row groups, classes as rows, conditions as columns.
///
/// In the latter a condition has three columns, its objects, clean and cracked: the region is its own, and so are the
/// objects in it and their clean AP. Up to two conditions stand side by side, more have further tables,
/// family by family. It holds all classes, the supercategories (of data without any: the classes) with
/// numbers, in the region at the study's own τ, or on whole images where there is no region. Needs the
/// packages `booktabs` and `multirow`. Where a number is refused stands `--` with a footnote that says why.
#[must_use]
pub fn latex(study: &Study) -> String {
    let detectors = words::distinct(study.evaluations.iter().map(|one| &one.detector));
    let told = printed(study);
    let blocks = blocks(&told);
    let mut text = String::from("% Needs \\usepackage{booktabs} and \\usepackage{multirow}.\n");
    summary::add(study, &told, &mut text);
    for (place, conditions) in blocks.iter().enumerate() {
        let mut table = PrintedTable {
            study,
            conditions,
            body: String::new(),
            reasons: Vec::new(),
        };
        for detector in &detectors {
            table.add_detector(detector);
        }
        table.finish((place + 1, blocks.len()), &mut text);
    }
    text
}

/// The conditions of each table: of one family, if any family has several.
fn blocks<'a>(told: &[Told<'a>]) -> Vec<Vec<Told<'a>>> {
    let mut runs: Vec<Vec<Told<'a>>> = Vec::new();
    for one in told {
        let family = &one.condition.family;
        let known = |run: &&mut Vec<Told<'a>>| {
            run.first()
                .is_some_and(|first| first.condition.family == *family)
        };
        match runs.iter_mut().find(known) {
            Some(run) => run.push(one.clone()),
            None => runs.push(vec![one.clone()]),
        }
    }
    if runs.iter().all(|run| run.len() == 1) {
        runs = vec![told.to_vec()];
    }
    runs.iter()
        .flat_map(|run| run.chunks(MAX_CONDITIONS).map(<[_]>::to_vec))
        .collect()
}

struct PrintedTable<'a> {
    study: &'a Study,
    conditions: &'a [Told<'a>],
    body: String,
    reasons: Vec<String>,
}

impl<'a> PrintedTable<'a> {
    /// One per condition of the table.
    fn evaluations_of(&self, detector: &str) -> Vec<Option<&'a [PairedRow]>> {
        self.conditions
            .iter()
            .map(|condition| condition.paired(self.study, detector))
            .collect()
    }

    fn add_detector(&mut self, detector: &str) {
        let of_conditions = self.evaluations_of(detector);
        let evaluations: Vec<&[PairedRow]> = of_conditions.iter().copied().flatten().collect();
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
                let rows = evaluations.iter().copied().flatten();
                rows.clone()
                    .any(|row| row.metric == *metric && row.scope == scope)
            })
            .collect();
        let n_rows = groups.len() * metrics.len();
        let n_columns = 3 * self.conditions.len() + 3;
        if !self.body.is_empty() {
            self.body.push_str("  \\midrule\n");
        }
        let mut is_first = true;
        for (place, metric) in metrics.iter().enumerate() {
            if place > 0 {
                let _ = writeln!(self.body, "  \\cmidrule{{2-{n_columns}}}");
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
                let cells: Vec<String> = of_conditions
                    .iter()
                    .flat_map(|one| self.cells(*one, &scope, group, *metric))
                    .collect();
                let _ = writeln!(
                    self.body,
                    "  {detector} & {metric_cell} & {} & {} \\\\",
                    escaped(&group_name(group)),
                    cells.join(" & ")
                );
            }
        }
    }

    /// How many objects the condition has there, then clean and cracked, of these objects.
    fn cells(
        &mut self,
        paired: Option<&[PairedRow]>,
        scope: &Scope,
        group: &Group,
        metric: PairedMetric,
    ) -> [String; 3] {
        let row = paired.and_then(|rows| {
            rows.iter()
                .find(|row| row.scope == *scope && row.group == *group && row.metric == metric)
        });
        match row {
            Some(row) => [
                row.n_objects.to_string(),
                number(&row.clean, &mut self.reasons),
                number(&row.cracked, &mut self.reasons),
            ],
            None => ["0".to_owned(), "--".to_owned(), "--".to_owned()],
        }
    }

    fn finish(self, (number, n_tables): (usize, usize), text: &mut String) {
        let Self {
            study,
            conditions,
            body,
            reasons,
        } = self;
        let columns = "rrr".repeat(conditions.len());
        let heads: Vec<String> = conditions
            .iter()
            .map(|one| format!("\\multicolumn{{3}}{{c}}{{{}}}", escaped(&one.label)))
            .collect();
        let rules: Vec<String> = (0..conditions.len())
            .map(|place| format!("\\cmidrule(lr){{{}-{}}}", 3 * place + 4, 3 * place + 6))
            .collect();
        let place = match study.provenance.settings.tau {
            Some(tau) => {
                format!("of the $n$ objects in the region of each condition ($\\tau = {tau}$)")
            }
            None => "of all $n$ objects".to_owned(),
        };
        let seeds = match conditions.iter().any(|one| one.is_pooled) {
            true => " Values over several seeds are means; an object counts once per seed.",
            false => "",
        };
        let part = match n_tables {
            1 => String::new(),
            _ => format!(" Table {number} of {n_tables}."),
        };
        let _ = writeln!(text, "\\begin{{table*}}");
        let _ = writeln!(text, "  \\centering");
        let _ = writeln!(
            text,
            "  \\caption{{Average precision (\\%) {place}, on {}: clean and damaged, with 95\\,\\% intervals. \
             Each condition has its own region, and so its own objects and clean value.{seeds}{part}}}",
            escaped(&study.dataset)
        );
        let _ = writeln!(text, "  \\label{{tab:starbreak-classes-{number}}}");
        let _ = writeln!(text, "  \\begin{{tabular}}{{lll{columns}}}");
        let _ = writeln!(text, "  \\toprule");
        let _ = writeln!(text, "   &  &  & {} \\\\", heads.join(" & "));
        let _ = writeln!(text, "  {}", rules.join(" "));
        let _ = writeln!(
            text,
            "  Detector & Metric & Category & {} \\\\",
            ["$n$ & Clean & Damaged"]
                .repeat(conditions.len())
                .join(" & ")
        );
        let _ = writeln!(text, "  \\midrule");
        text.push_str(&body);
        let _ = writeln!(text, "  \\bottomrule");
        let _ = writeln!(text, "  \\end{{tabular}}");
        add_notes(&reasons, text);
        let _ = writeln!(text, "\\end{{table*}}");
    }
}

/// A number in percent with its interval, or the number of the note that says why there is none.
fn number(estimate: &Estimate, reasons: &mut Vec<String>) -> String {
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
    let place = reasons.iter().position(|known| known == why);
    let place = place.unwrap_or_else(|| {
        reasons.push(why.clone());
        reasons.len() - 1
    });
    format!("--\\textsuperscript{{{}}}", place + 1)
}

/// Why numbers are missing, below a table.
fn add_notes(reasons: &[String], text: &mut String) {
    for (place, reason) in reasons.iter().enumerate() {
        let _ = writeln!(
            text,
            "  \\par{{\\footnotesize \\textsuperscript{{{}}} {}}}",
            place + 1,
            escaped(reason)
        );
    }
}

/// In the region at the study's own τ, else everywhere.
fn main_scope(study: &Study, evaluations: &[&[PairedRow]]) -> Option<Scope> {
    let tau = study.provenance.settings.tau;
    let scopes = || evaluations.iter().copied().flatten().map(|row| &row.scope);
    scopes()
        .find(|scope| scope.kind == ScopeKind::InRegion && scope.is_at(tau))
        .or_else(|| scopes().next())
        .cloned()
}

fn printed_groups(evaluations: &[&[PairedRow]], scope: &Scope) -> Vec<Group> {
    let rows = || {
        evaluations
            .iter()
            .copied()
            .flatten()
            .filter(|row| row.scope == *scope)
    };
    let kinds: BTreeSet<GroupKind> = rows().map(|row| row.group.kind).collect();
    let small = match kinds.contains(&GroupKind::Supercategory) {
        true => GroupKind::Supercategory,
        false => GroupKind::Class,
    };
    let mut groups: Vec<(Group, u64)> = Vec::new();
    let is_printed = |kind: GroupKind| {
        kind == small || matches!(kind, GroupKind::All | GroupKind::MeanOfSupercategories)
    };
    for row in rows().filter(|row| is_printed(row.group.kind)) {
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
        GroupKind::MeanOfSupercategories => "mean of supercategories".to_owned(),
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
