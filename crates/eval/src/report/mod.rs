//! A study for readers: one HTML file, and the same numbers as JSON, CSV and LaTeX.

mod charts;
mod clip_numbers;
mod conditions;
mod csv;
mod failed;
mod files;
mod html;
mod json;
mod latex;
mod numbers;
mod page;
mod words;

pub use csv::csv;
pub use failed::failures_jsonl;
pub use files::report_files;
pub use html::html;
pub use json::{json, read_json};
pub use latex::latex;
pub use numbers::{Number, numbers};
