//! The page as one HTML file.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use minijinja::{Environment, context};
use sha2::{Digest as _, Sha256};

use super::page;
use crate::EvalError;
use crate::evaluation::Study;

const TEMPLATE: &str = include_str!("../../templates/report.html");
const STYLE: &str = include_str!("../../templates/report.css");
const SCRIPT: &str = include_str!("../../templates/report.js");

/// A study as one HTML file that needs nothing else: no network, no font, no script but its own for
/// sorting tables.
///
/// All text is escaped, and the page's own policy forbids every other script and every address, so
/// that a name cannot do anything. It is also well-formed XML.
///
/// # Errors
/// [`EvalError::Report`] if the template does not work out.
pub fn html(study: &Study) -> Result<String, EvalError> {
    let failed = |cause: minijinja::Error| EvalError::Report {
        reason: cause.to_string().replace('\n', " "),
    };
    let mut environment = Environment::new();
    environment
        .add_template("report.html", TEMPLATE)
        .map_err(failed)?;
    let template = environment.get_template("report.html").map_err(failed)?;
    let script_hash = STANDARD.encode(Sha256::digest(SCRIPT.as_bytes()));
    template
        .render(context! {
            page => minijinja::value::Serde(page::page(study)),
            style => STYLE,
            script => SCRIPT,
            script_hash => script_hash,
        })
        .map_err(failed)
}
