//! The report: whole, self-contained, well-formed, and no name breaks out of it.
#![expect(
    clippy::unwrap_used,
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a test, over small made-up numbers"
)]

use std::fs;
use std::path::Path;

use starbreak_eval::report::html;

#[path = "report/plausible.rs"]
mod plausible;

#[test]
fn a_page_is_written() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    fs::write(
        folder.join("report-2.html"),
        html(&plausible::study(&[3])).unwrap(),
    )
    .unwrap();
    fs::write(
        folder.join("report-10.html"),
        html(&plausible::study(&[1, 2, 3, 4, 5])).unwrap(),
    )
    .unwrap();
}
