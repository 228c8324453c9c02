//! The numbers as CSV, one row each.

use super::numbers::{COUNT, Number, numbers};
use crate::evaluation::{Estimate, Study};

/// The columns.
const HEAD: &str = "detector,condition,scope,tau,group,class,metric,clean,cracked,value,low,high,p,p_holm,n,\
                    method,refused";

/// The numbers of a study as tidy CSV (RFC 4180, UTF-8, lines end in a line feed): one row per number.
///
/// Fractions are fractions; `value` of an AP, of scores and of overlaps is the difference, cracked minus clean, and of
/// rPC the ratio. `n` says on how many things a number rests and is empty where that is not known; `method` names an
/// interval only where `low` and `high` are there. Where a number is refused, `value` is empty and `refused` says why.
/// A text that a spreadsheet would take for a formula gets an apostrophe in front, and so does one that begins with
/// an apostrophe.
#[must_use]
pub fn csv(study: &Study) -> String {
    let mut text = String::from(HEAD);
    text.push('\n');
    for number in numbers(study) {
        text.push_str(&row(&number));
        text.push('\n');
    }
    text
}

fn row(number: &Number) -> String {
    let estimate = &number.estimate;
    let float = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    [
        field(&number.detector),
        field(&number.condition),
        field(number.scope),
        float(number.tau),
        field(number.group_kind),
        field(&number.class),
        field(&number.metric),
        float(number.clean),
        float(number.cracked),
        float(estimate.value),
        float(estimate.low),
        float(estimate.high),
        float(number.p),
        float(number.p_holm),
        n_things(estimate, number.method),
        field(number.method),
        field(estimate.refused.as_deref().unwrap_or("")),
    ]
    .join(",")
}

/// On how many things a number rests; empty where it does not say. A count says it, also of nothing.
fn n_things(estimate: &Estimate, method: &str) -> String {
    match (estimate.n, estimate.value) {
        (0, Some(_)) if method != COUNT => String::new(),
        (n, _) => n.to_string(),
    }
}

/// A text as one field.
fn field(text: &str) -> String {
    let mut text = text.to_owned();
    if text.starts_with(['=', '+', '-', '@', '\t', '\r', '\'']) {
        text.insert(0, '\'');
    }
    if text.contains([',', '"', '\n', '\r']) {
        return format!("\"{}\"", text.replace('"', "\"\""));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{COUNT, Estimate, field, n_things};

    #[test]
    fn a_count_of_nothing_rests_on_nothing() {
        let nothing = Estimate::of(0.0, 0);
        assert_eq!(n_things(&nothing, COUNT), "0", "a count");
        assert_eq!(n_things(&nothing, "COCO protocol"), "", "not known");
    }

    #[test]
    fn fields_stay_fields() {
        assert_eq!(field("hot dog"), "hot dog", "as it is");
        assert_eq!(field("a,\"b\""), "\"a,\"\"b\"\"\"", "quoted");
        assert_eq!(field("=1+1"), "'=1+1", "no formula");
        assert_eq!(field("'=1+1"), "''=1+1", "another text stays another one");
    }
}
