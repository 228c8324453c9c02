//! The numbers as lines of a table.

use super::report::{DivergenceReport, Estimate};

/// Columns of [`divergence_csv`].
const HEADER: &str = "definition,a,b,n_a,n_b,feature,n_bins,alpha,log_base,measure,value,\
interval_low,interval_high,confidence,floor,floor_q95,effect,p_value,seed\n";

/// All numbers of a report as CSV (RFC 4180), one per line; what there is none of stays empty.
#[must_use]
pub fn divergence_csv(report: &DivergenceReport) -> String {
    let mut text = HEADER.to_owned();
    for pair in &report.pairs {
        let sets = format!(
            "{},{},{},{},{}",
            report.definition,
            quoted(&pair.a),
            quoted(&pair.b),
            pair.n_a,
            pair.n_b
        );
        let mut line = |feature: &str, n_bins: &str, alpha: &str, measure: &str, e: &Estimate| {
            let number = |value: Option<f64>| value.map_or_else(String::new, |v| v.to_string());
            text.push_str(&format!(
                "{sets},{feature},{n_bins},{alpha},{},{measure},{},{},{},{},{},{},{},{},{}\n",
                report.log_base,
                e.value,
                number(e.interval.map(|ends| ends[0])),
                number(e.interval.map(|ends| ends[1])),
                report.settings.confidence,
                number(e.floor),
                number(e.floor_q95),
                number(e.effect),
                number(e.p_value),
                report.settings.seed,
            ));
        };
        for compared in &pair.features {
            let n_bins = compared.n_bins.to_string();
            let alpha = report.settings.alpha.to_string();
            for (measure, estimate) in &compared.measures {
                line(
                    compared.feature.name(),
                    &n_bins,
                    &alpha,
                    measure.name(),
                    estimate,
                );
            }
        }
        if let Some(activations) = &pair.activations {
            for (measure, estimate) in &activations.measures {
                line(
                    &quoted(&activations.origin),
                    "",
                    "",
                    measure.name(),
                    estimate,
                );
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
