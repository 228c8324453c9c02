//! Which kinds of errors cost how much, and whether the classes are the right ones.

use super::super::charts::{ChartText, Ink, RowSeries, row_chart};
use super::super::words;
use super::{Block, Cell, Section, Table};
use crate::chart::Axis;
use crate::evaluation::{Evaluation, LabelAudit, LabelVerdict, Study, TideErrors};

pub(super) fn blocks(study: &Study, evaluation: &Evaluation, id: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let of_clean = study.clean_of(&evaluation.detector);
    let clean = of_clean.and_then(|one| one.tide.as_ref());
    if let (Some(clean), Some(cracked)) = (clean, &evaluation.tide_cracked) {
        blocks.push(Block::heading(
            format!("{id}-errors"),
            "Error types".to_owned(),
        ));
        blocks.push(tide_chart(clean, cracked, id));
    }
    blocks
}

/// Whether the classes of each detector are those of the labels, on the clean images.
pub(super) fn classes_section(study: &Study) -> Option<Section> {
    let mut blocks = Vec::new();
    for (place, one) in study.clean.iter().enumerate() {
        let Some(audit) = &one.label_audit else {
            continue;
        };
        blocks.push(Block::heading(
            format!("classes-{place}"),
            words::name(&one.detector),
        ));
        blocks.push(Block::text(audit_text(audit)));
        if !audit.disagreements.is_empty() {
            blocks.push(Block::fold(
                "Objects detected as another class",
                vec![Block::table(audit_table(audit))],
            ));
        }
    }
    (!blocks.is_empty()).then(|| Section {
        id: "classes".to_owned(),
        title: "Label-map audit".to_owned(),
        blocks,
    })
}

fn of(errors: &TideErrors) -> [(&'static str, f64); 8] {
    [
        ("classification", errors.classification),
        ("localization", errors.localization),
        ("both", errors.both),
        ("duplicate", errors.duplicate),
        ("background", errors.background),
        ("missed", errors.missed),
        ("all false positives", errors.false_positive),
        ("all false negatives", errors.false_negative),
    ]
}

fn tide_chart(clean: &TideErrors, cracked: &TideErrors, id: &str) -> Block {
    let mut table = Table::new(
        "AP50 gained if all errors of a type were corrected, percentage points.",
        "Type|#Clean|#Damaged|#Difference",
    );
    let mut end = 1.0_f64;
    for ((name, clean), (_, cracked)) in of(clean).into_iter().zip(of(cracked)) {
        table.push(vec![
            Cell::head(name),
            Cell::number(Some(clean), words::percent),
            Cell::number(Some(cracked), words::percent),
            Cell::number(Some(cracked - clean), words::signed_percent),
        ]);
        end = end.max(clean * 100.0).max(cracked * 100.0);
    }
    let names = of(clean).map(|(name, _)| name.to_owned());
    let series = |name, ink, errors| RowSeries {
        name,
        ink,
        marker: None,
        values: of(errors).map(|(_, gain)| (gain * 100.0, None)).to_vec(),
    };
    let chart_id = format!("{id}-tide-chart");
    let chart = row_chart(
        &names,
        &[
            series("clean (upper bar)", Ink::Clean, clean),
            series("damaged (lower bar)", Ink::Cracked, cracked),
        ],
        Axis::up_to(end, "AP50 gain, percentage points"),
        &ChartText {
            id: &chart_id,
            title: "AP50 gain by error type, clean and damaged",
            description: "Two bars per error type; the table gives the numbers.",
        },
    );
    Block::chart(
        chart,
        format!(
            "Error types by TIDE, whole images: the gain of TIDE's own AP50 ({} clean, {} damaged) if all errors \
             of a type were corrected. It is not the AP50 of the other tables: TIDE counts classes that are \
             detected but have no objects as 0, and keeps 100 detections per image over all classes together.",
            words::percent(clean.ap50),
            words::percent(cracked.ap50)
        ),
        Some(table),
    )
}

fn audit_text(audit: &LabelAudit) -> String {
    let agreement = audit.agreement.value.map_or_else(
        || words::NOTHING.to_owned(),
        |share| format!("{} %", words::percent(share)),
    );
    let verdict = match audit.verdict {
        LabelVerdict::Fits => "No other label map agrees clearly better",
        LabelVerdict::Wrong => {
            "Another label map agrees clearly better, so the one in use is probably wrong, and every number \
             per class with it"
        }
        LabelVerdict::Unexplained => "No other label map explains the disagreement",
        LabelVerdict::TooFew => "There are too few for a verdict",
    };
    let advice = audit.advice.as_deref().map(words::name);
    let advice = advice.map_or(String::new(), |advice| format!(": {advice}"));
    format!(
        "{} objects in the clean images overlap well with a detection of any class; the class agrees in \
         {agreement}. {verdict}{advice}.",
        words::count(audit.n_pairs),
    )
}

fn audit_table(audit: &LabelAudit) -> Table {
    let mut table = Table::new(
        "The most frequent disagreements between labels and detections, clean images.",
        "Label|Detected as|#Count",
    );
    for row in audit.disagreements.iter().take(20) {
        table.push(vec![
            Cell::head(&row.truth),
            Cell::text(&row.detected),
            Cell::count(row.n),
        ]);
    }
    table
}
