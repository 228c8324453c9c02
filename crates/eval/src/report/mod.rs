//! A study for readers: one HTML file, and the same numbers as JSON, CSV and LaTeX.

mod charts;
mod html;
mod page;
mod words;

pub use html::html;
