//! What a study comes to, in a table that fits a column.

use std::fmt::Write as _;

use super::{Told, add_notes, escaped, main_scope, number};
use crate::evaluation::{Estimate, GroupKind, PairedMetric, PairedRow, Study};
use crate::report::words;

/// AP50 of all classes (of KITTI its AP40) under each condition of each detector: objects, clean,
/// damaged, and the difference with its interval and p.
pub(super) fn add(study: &Study, conditions: &[Told<'_>], text: &mut String) {
    let mut reasons = Vec::new();
    let mut body = String::new();
    for detector in words::distinct(study.evaluations.iter().map(|one| &one.detector)) {
        let _ = writeln!(
            body,
            "  \\multicolumn{{6}}{{l}}{{\\textit{{{}}}}} \\\\",
            escaped(detector)
        );
        for told in conditions {
            let paired = told.paired(study, detector).unwrap_or(&[]);
            for row in rows_of(study, paired) {
                let label = match row.group.kind {
                    GroupKind::All => told.label.clone(),
                    _ => format!("{}, {}", told.label, row.group.name),
                };
                let _ = writeln!(
                    body,
                    "  {} & {} & {} & {} & {} & {} \\\\",
                    escaped(&label),
                    row.n_objects,
                    number(&alone(&row.clean), &mut reasons),
                    number(&alone(&row.cracked), &mut reasons),
                    number(&row.delta, &mut reasons),
                    p_text(row.p_holm)
                );
            }
        }
    }
    let place = match study.provenance.settings.tau {
        Some(tau) => format!("of the $n$ objects in the damaged region ($\\tau = {tau}$)"),
        None => "of all $n$ objects".to_owned(),
    };
    let metric = match is_of_kitti(study) {
        true => "AP40 of moderate objects",
        false => "AP50",
    };
    let seeds = match conditions.iter().any(|one| one.is_pooled) {
        true => " Values over several seeds are means; an object counts once per seed.",
        false => "",
    };
    let _ = writeln!(
        text,
        "\\begin{{table}}\n  \\centering\n  \\footnotesize\n  \\setlength{{\\tabcolsep}}{{3pt}}\n  \
         \\caption{{{metric} (\\%) {place}, on {}: clean, damaged, and the difference with its 95\\,\\% interval; \
         $p$ by permutation, after Holm's correction.{seeds}}}\n  \
         \\label{{tab:starbreak}}\n  \\begin{{tabular}}{{@{{}}lrrrrr@{{}}}}\n  \\toprule\n  \
         Condition & $n$ & Clean & Dam. & Difference & $p$ \\\\\n  \\midrule",
        escaped(&study.dataset)
    );
    text.push_str(&body);
    let _ = writeln!(text, "  \\bottomrule\n  \\end{{tabular}}");
    add_notes(&reasons, text);
    let _ = writeln!(text, "\\end{{table}}");
}

/// All classes together; of KITTI, which has no mean over classes, each of them.
fn rows_of<'a>(study: &Study, paired: &'a [PairedRow]) -> Vec<&'a PairedRow> {
    let scope = main_scope(study, &[paired]);
    let is_main = |row: &&PairedRow| match is_of_kitti(study) {
        true => row.metric == PairedMetric::KittiAp40,
        false => row.metric == PairedMetric::Ap50 && row.group.kind == GroupKind::All,
    };
    let rows = paired
        .iter()
        .filter(|row| Some(&row.scope) == scope.as_ref());
    rows.filter(is_main).collect()
}

fn is_of_kitti(study: &Study) -> bool {
    study.provenance.settings.protocol == "kitti"
}

/// A number without its interval: the difference has one.
fn alone(estimate: &Estimate) -> Estimate {
    Estimate {
        low: None,
        high: None,
        ..estimate.clone()
    }
}

fn p_text(p: Option<f64>) -> String {
    match p {
        None => "--".to_owned(),
        Some(p) if p < 0.001 => "$<$.001".to_owned(),
        Some(p) => format!("{p:.3}").trim_start_matches('0').to_owned(),
    }
}
