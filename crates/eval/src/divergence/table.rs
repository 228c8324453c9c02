//! The numbers as lines of a table.

use super::report::{DivergenceReport, Estimate};

/// Columns of [`divergence_csv`].
const HEADER: &str = "definition,a,b,n_a,n_b,feature,n_bins,alpha,log_base,measure,value,\
interval_low,interval_high,confidence,floor,effect,p_value,seed\n";

/// All numbers of a report as CSV (RFC 4180), one per line; what there is none of stays empty.
#[must_use]
pub fn divergence_csv(report: &DivergenceReport) -> String {
    let mut text = HEADER.to_owned();
    let settings = &report.settings;
    for pair in &report.pairs {
        let mut line = |feature: &str, bins: &str, measure: &str, e: &Estimate| {
            let number = |value: Option<f64>| value.map_or_else(String::new, |v| v.to_string());
            let fields = [
                report.definition.to_owned(),
                quoted(&pair.a),
                quoted(&pair.b),
                pair.n_a.to_string(),
                pair.n_b.to_string(),
                quoted(feature),
                bins.to_owned(),
                report.log_base.to_owned(),
                measure.to_owned(),
                e.value.to_string(),
                number(e.interval.map(|ends| ends[0])),
                number(e.interval.map(|ends| ends[1])),
                report.confidence.to_string(),
                number(e.floor),
                number(e.effect),
                number(e.p_value),
                settings.seed.to_string(),
            ];
            text.push_str(&fields.join(","));
            text.push('\n');
        };
        for compared in &pair.features {
            let bins = format!("{},{}", compared.n_bins, settings.alpha);
            for (measure, estimate) in &compared.measures {
                line(compared.feature.name(), &bins, measure.name(), estimate);
            }
        }
        if let Some(of) = &pair.activations {
            for (name, value) in [("frechet", of.frechet), ("kid", of.kid)] {
                let alone = Estimate::of(value, Vec::new(), None, &[], 1.0);
                line(&of.origin, ",", name, &alone);
            }
        }
    }
    text
}

/// A field as CSV has it.
fn quoted(text: &str) -> String {
    if text.contains(['"', ',', '\n', '\r']) {
        return format!("\"{}\"", text.replace('"', "\"\""));
    }
    text.to_owned()
}
