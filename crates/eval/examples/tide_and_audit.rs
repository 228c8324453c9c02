//! TIDE and the label-map audit of results in the form of MS-COCO, as JSON.
//!
//! `cargo run --release -p starbreak-eval --example tide_and_audit -- LABELS.json RESULTS.json`;
//! `validation/tide_and_audit.py` compares its TIDE with tidecv.
#![expect(clippy::print_stdout, reason = "a program for the terminal")]

use std::path::Path;

use serde_json::json;
use starbreak_eval::label_audit::{AuditSettings, label_audit};
use starbreak_eval::tide::{TideSettings, tide};
use starbreak_eval::{Detections, LabelSet};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(labels), Some(results)) = (arguments.next(), arguments.next()) else {
        return Err("give LABELS.json and RESULTS.json".into());
    };
    let labels = LabelSet::read_coco(Path::new(&labels))?;
    let detections = Detections::read_coco(Path::new(&results), &labels)?.detections;
    let tide = tide(&labels, &detections, TideSettings::default())?;
    let audit = label_audit(&labels, &detections, AuditSettings::default())?;
    println!("{}", json!({ "tide": tide, "audit": audit }));
    Ok(())
}
