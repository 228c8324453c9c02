//! Numbers for people.

use starbreak_eval::divergence::{
    DivergenceReport, FeatureComparison, Measure, Ordering, PairComparison, VectorComparison,
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
    let PairComparison { a, b, n_a, n_b, .. } = pair;
    let paired = if pair.is_paired {
        ", the same images by name: p exchanges the two versions of each"
    } else {
        ""
    };
    screen.say(&format!("\n{a} ({n_a}) | {b} ({n_b}){paired}"));
    screen.say(&format!(
        "  {:<15} {:>10} {:>23} {:>10} {:>8} {:>7} {:>10} {:>10} {:>22}",
        "feature", "JS", "interval", "floor", "effect", "p", "KL(A|B)", "KL(B|A)", "W1"
    ));
    for compared in &pair.features {
        let name = compared.feature.name();
        screen.say(&format!("  {name:<15} {}", feature(compared)));
    }
    if let Some(compared) = &pair.activations {
        vectors(compared, screen);
    }
}

/// JS with all that stands beside it, KL and W1; or why there is none.
fn feature(compared: &FeatureComparison) -> String {
    let Some(js) = compared.measures.get(&Measure::Js) else {
        return compared.missing.unwrap_or_default().to_owned();
    };
    let number = |measure| {
        let estimate = compared.measures.get(&measure);
        or_none(estimate, |estimate| digits(estimate.value))
    };
    let unit = compared.w1_unit.unwrap_or_default();
    let w1 = format!("{} {unit}", number(Measure::W1));
    format!(
        "{:>10} {:>23} {:>10} {:>8} {:>7} {:>10} {:>10} {:>22}",
        digits(js.value),
        or_none(js.interval, |ends| {
            format!("[{}, {}]", digits(ends[0]), digits(ends[1]))
        }),
        or_none(js.floor, digits),
        or_none(js.effect, |effect| format!("{effect:.1}")),
        or_none(js.p_value, |p| format!("{p:.3}")),
        number(Measure::KlAb),
        number(Measure::KlBa),
        w1.trim_end()
    )
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

pub(super) fn ordering(test: &Ordering, screen: &Screen) {
    let ([a, b], [c, d]) = (&test.closer, &test.farther);
    let held = if test.holds { "holds," } else { "not shown:" };
    let (n, all) = (test.n_holding, test.features.len());
    screen.say(&format!(
        "\nJS({a}, {b}) < JS({c}, {d}): {held} in {n} of {all} features with probability > 0.95"
    ));
    for feature in &test.features {
        screen.say(&format!(
            "  {:<15} {} < {}: probability {}",
            feature.feature.name(),
            digits(feature.closer),
            digits(feature.farther),
            or_none(feature.probability, |p| format!("{p:.3}"))
        ));
    }
}

fn or_none<T>(value: Option<T>, text: impl FnOnce(T) -> String) -> String {
    value.map_or_else(|| "-".to_owned(), text)
}

/// A number for people: four digits.
pub(super) fn digits(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-3 {
        return format!("{value:.2e}");
    }
    format!("{value:.4}")
}
