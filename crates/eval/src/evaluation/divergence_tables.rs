//! Distances between sets of images as tables.

use crate::divergence::{
    DivergenceReport, Estimate as Distance, Feature, FeatureComparison, Measure,
};

use super::{DivergenceResults, DivergenceTable, Estimate};

/// What a table is of: its measure in both directions, and the words for it.
const TABLES: [([Measure; 2], &str); 3] = [
    ([Measure::KlAb, Measure::KlBa], "KL(row ‖ column), nats"),
    ([Measure::Js, Measure::Js], "JS, nats"),
    ([Measure::W1, Measure::W1], "W1"),
];

impl DivergenceResults {
    /// Tables of KL in both directions, JS and W1, a set per row and column, for each feature of pixels that
    /// the reports have; what no report compares is refused as `not compared`.
    ///
    /// `sets` are the names of all sets, the reports of some of them each.
    #[must_use]
    pub fn of_reports(sets: &[String], reports: &[DivergenceReport]) -> Self {
        let mut tables = Vec::new();
        for feature in Feature::OF_IMAGES {
            for (measures, name) in TABLES {
                tables.extend(table(sets, reports, feature, measures, name));
            }
        }
        Self {
            sets: sets.to_vec(),
            tables,
        }
    }
}

fn table(
    sets: &[String],
    reports: &[DivergenceReport],
    feature: Feature,
    [forth, back]: [Measure; 2],
    name: &str,
) -> Option<DivergenceTable> {
    let n = sets.len();
    let mut values = vec![vec![Estimate::refused(0, "not compared"); n]; n];
    let unit = feature.bin_width().map_or("", |(_, unit)| unit);
    let mut has_value = false;
    let place = |name: &String| sets.iter().position(|known| known == name);
    for pair in reports.iter().flat_map(|report| &report.pairs) {
        let is_it = |one: &&FeatureComparison| one.feature == feature;
        let found = pair.features.iter().find(is_it);
        let (Some(a), Some(b), Some(found)) = (place(&pair.a), place(&pair.b), found) else {
            continue;
        };
        let n_images = u64::try_from(pair.n_a.min(pair.n_b)).unwrap_or(u64::MAX);
        for (row, column, measure) in [(a, b, forth), (b, a, back)] {
            let slot = values.get_mut(row).and_then(|row| row.get_mut(column));
            if let Some(slot) = slot {
                has_value |= found.measures.contains_key(&measure);
                let why = found.missing.unwrap_or("not defined");
                *slot = match found.measures.get(&measure) {
                    Some(distance) => estimate(distance, n_images),
                    None => Estimate::refused(n_images, why),
                };
            }
        }
    }
    let floor = |set: &String| {
        let mut floors = reports.iter();
        floors.find_map(|report| report.floor(set, feature, forth))
    };
    has_value.then(|| DivergenceTable {
        feature: feature.name().to_owned(),
        measure: match forth {
            Measure::W1 => format!("{name}, {unit}"),
            _ => name.to_owned(),
        },
        noise_floor: sets.iter().map(floor).collect(),
        values,
    })
}

fn estimate(distance: &Distance, n: u64) -> Estimate {
    match distance.interval {
        Some(ends) => Estimate::with_interval(distance.value, ends, n),
        None => Estimate::of(distance.value, n),
    }
}
