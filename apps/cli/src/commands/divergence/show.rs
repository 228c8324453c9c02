//! Numbers for people.

use starbreak_eval::divergence::{
    DivergenceReport, Estimate, Measure, Ordering, PairComparison, VectorComparison,
};

use crate::screen::Screen;

pub(super) fn report(report: &DivergenceReport, screen: &Screen) {
    let settings = &report.settings;
    screen.say(&format!(
        "{}: natural logarithms, alpha {} per bin, {} % intervals of {} bootstrap replicates, floors of {} split-halves, p of {} relabelings, seed {}",
        report.definition,
        settings.alpha,
        report.confidence * 100.0,
        settings.n_bootstrap,
        settings.n_splits,
        settings.n_permutations,
        settings.seed
    ));
    for note in &report.notes {
        screen.note(&format!("note: {note}"));
    }
    for pair in &report.pairs {
        self::pair(pair, screen);
    }
}

fn pair(pair: &PairComparison, screen: &Screen) {
    screen.say(&format!(
        "\n{} ({}) | {} ({}){}",
        pair.a,
        pair.n_a,
        pair.b,
        pair.n_b,
        if pair.is_paired {
            ", the same images by name: p exchanges the two versions of each"
        } else {
            ""
        }
    ));
    screen.say(&format!(
        "  {:<15} {:>10} {:>23} {:>10} {:>8} {:>7} {:>10} {:>10} {:>22}",
        "feature", "JS", "interval", "floor", "effect", "p", "KL(A|B)", "KL(B|A)", "W1"
    ));
    for compared in &pair.features {
        let value = |measure| compared.measures.get(&measure);
        let Some(js) = value(Measure::Js) else {
            let why = compared.missing.unwrap_or_default();
            screen.say(&format!("  {:<15} {why}", compared.feature.name()));
            continue;
        };
        let number = |measure| value(measure).map_or_else(|| "-".to_owned(), |e| digits(e.value));
        let unit = compared.w1_unit.unwrap_or_default();
        let w1 = format!("{} {unit}", number(Measure::W1));
        screen.say(&format!(
            "  {:<15} {} {:>10} {:>10} {:>22}",
            compared.feature.name(),
            columns(js),
            number(Measure::KlAb),
            number(Measure::KlBa),
            w1.trim_end()
        ));
    }
    if let Some(compared) = &pair.activations {
        vectors(compared, screen);
    }
}

pub(super) fn vectors(compared: &VectorComparison, screen: &Screen) {
    let deficient = if compared.is_rank_deficient {
        "; fewer vectors than dimensions: frechet is far too large, kid is the number to read"
    } else {
        ""
    };
    screen.say(&format!(
        "  {}: {} and {} vectors of {} values: frechet {}, kid {}{deficient}",
        compared.origin,
        compared.n_a,
        compared.n_b,
        compared.n_dimensions,
        digits(compared.frechet),
        digits(compared.kid)
    ));
}

/// Value, interval, floor, effect and p.
fn columns(estimate: &Estimate) -> String {
    let or_none = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), digits);
    let interval = estimate.interval.map_or_else(
        || "-".to_owned(),
        |[low, high]| format!("[{}, {}]", digits(low), digits(high)),
    );
    format!(
        "{:>10} {interval:>23} {:>10} {:>8} {:>7}",
        digits(estimate.value),
        or_none(estimate.floor),
        estimate
            .effect
            .map_or_else(|| "-".to_owned(), |e| format!("{e:.1}")),
        estimate
            .p_value
            .map_or_else(|| "-".to_owned(), |p| format!("{p:.3}")),
    )
}

pub(super) fn ordering(test: &Ordering, screen: &Screen) {
    screen.say(&format!(
        "\nJS({}, {}) < JS({}, {}): {} in {} of {} features with probability > 0.95",
        test.closer[0],
        test.closer[1],
        test.farther[0],
        test.farther[1],
        if test.holds { "holds," } else { "not shown:" },
        test.n_holding,
        test.features.len()
    ));
    for feature in &test.features {
        let probability = feature
            .probability
            .map_or_else(|| "-".to_owned(), |p| format!("{p:.3}"));
        screen.say(&format!(
            "  {:<15} {} < {}: probability {probability}",
            feature.feature.name(),
            digits(feature.closer),
            digits(feature.farther),
        ));
    }
}

/// A number for people: four digits.
pub(super) fn digits(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-3 {
        return format!("{value:.2e}");
    }
    format!("{value:.4}")
}
