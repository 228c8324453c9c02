//! What a crack network promises, one check each.

use super::{MAX_IMPACTS, MAX_NODES, NETWORK_SCHEMA, NetworkData, NetworkError};
use crate::Impact;

/// Every invariant but planarity, in linear time (and a sort for the duplicates).
pub(super) fn check_columns(data: &NetworkData) -> Result<(), NetworkError> {
    if data.schema != NETWORK_SCHEMA {
        return Err(NetworkError::Schema {
            found: data.schema.clone(),
        });
    }
    data.pane.check()?;
    check_lengths(data)?;
    check_numbers(data)?;
    check_on_pane(data)?;
    check_ends(data)?;
    check_history(data)
}

fn check_lengths(data: &NetworkData) -> Result<(), NetworkError> {
    let segments = &data.segments;
    let n_segments = segments.from.len();
    let n_nodes = data.nodes.x.len();
    check_length("nodes.y", data.nodes.y.len(), n_nodes)?;
    check_length("segments.to", segments.to.len(), n_segments)?;
    check_length("segments.kind", segments.kind.len(), n_segments)?;
    let optional = [
        ("segments.parent", segments.parent.as_ref().map(Vec::len)),
        ("segments.zone", segments.zone.as_ref().map(Vec::len)),
        ("segments.ply", segments.ply.as_ref().map(Vec::len)),
        ("segments.face", segments.face.as_ref().map(Vec::len)),
        (
            "segments.depth_ends",
            segments.depth_ends.as_ref().map(Vec::len),
        ),
        (
            "segments.tilt_ends_deg",
            segments.tilt_ends_deg.as_ref().map(Vec::len),
        ),
    ];
    let measured = measures(data).map(|measure| (measure.column, measure.values.map(<[f64]>::len)));
    for (column, found) in optional.into_iter().chain(measured) {
        check_length(column, found.unwrap_or(n_segments), n_segments)?;
    }
    if segments.departure_us.is_some() && segments.arrival_us.is_none() {
        check_length("segments.arrival_us", 0, n_segments)?;
    }
    if data.impacts.len() > MAX_IMPACTS {
        return Err(NetworkError::TooManyImpacts {
            found: data.impacts.len(),
        });
    }
    if n_nodes > MAX_NODES {
        check_length("nodes.x", n_nodes, MAX_NODES)?;
    }
    Ok(())
}

fn check_length(column: &'static str, found: usize, expected: usize) -> Result<(), NetworkError> {
    if found == expected {
        return Ok(());
    }
    Err(NetworkError::ColumnLength {
        column,
        found,
        expected,
    })
}

/// A column of numbers of the segments and what is possible in it.
struct Measure<'a> {
    column: &'static str,
    values: Option<&'a [f64]>,
    range: Range,
}

/// What numbers are possible: whether a finite one is in the range, and the range in words.
type Range = (fn(f64) -> bool, &'static str);

const ANY: Range = (|_| true, "a finite number");
const POSITIVE: Range = (|value| value >= 0.0, "a finite number ≥ 0");
const FRACTION: Range = (|value| (0.0..=1.0).contains(&value), "a fraction, 0 to 1");
const TILT: Range = (
    |value| value.abs() < 90.0,
    "an angle between -90 and 90 degrees",
);
const OBLIQUITY: Range = (
    |value| (0.0..=90.0).contains(&value),
    "an angle, 0 to 90 degrees",
);

fn measures(data: &NetworkData) -> impl Iterator<Item = Measure<'_>> {
    let segments = &data.segments;
    [
        ("segments.arrival_step", &segments.arrival_step, POSITIVE),
        ("segments.arrival_us", &segments.arrival_us, POSITIVE),
        ("segments.departure_us", &segments.departure_us, POSITIVE),
        (
            "segments.stress_paper_units",
            &segments.stress_paper_units,
            ANY,
        ),
        ("segments.stress_mpa", &segments.stress_mpa, ANY),
        ("segments.opening_um", &segments.opening_um, POSITIVE),
        (
            "segments.depth_fraction",
            &segments.depth_fraction,
            FRACTION,
        ),
        ("segments.roughness_um", &segments.roughness_um, POSITIVE),
        ("segments.tilt_deg", &segments.tilt_deg, TILT),
        ("segments.k_ratio", &segments.k_ratio, POSITIVE),
    ]
    .into_iter()
    .map(|(column, values, range)| Measure {
        column,
        values: values.as_deref(),
        range,
    })
}

/// No number of a network is farther from 0, whatever its unit (a crack that a month of cold nights drives on arrives
/// after 10¹² µs): sums and squares of wilder ones would end
/// in infinity.
const MOST_MAGNITUDE: f64 = 1e18;

fn check_numbers(data: &NetworkData) -> Result<(), NetworkError> {
    for (column, values) in [("nodes.x", &data.nodes.x), ("nodes.y", &data.nodes.y)] {
        check_range(column, values, ANY)?;
    }
    for measure in measures(data) {
        check_range(
            measure.column,
            measure.values.unwrap_or_default(),
            measure.range,
        )?;
    }
    let segments = &data.segments;
    for (column, pairs, range) in [
        ("segments.depth_ends", &segments.depth_ends, FRACTION),
        ("segments.tilt_ends_deg", &segments.tilt_ends_deg, TILT),
    ] {
        for end in 0..2 {
            let pairs = pairs.as_deref().unwrap_or_default();
            let values: Vec<f64> = pairs.iter().map(|pair| pair[end]).collect();
            check_range(column, &values, range)?;
        }
    }
    for (index, impact) in data.impacts.iter().enumerate() {
        check_impact(index, impact)?;
    }
    let given = data.summary.unwrap_or_default();
    for (name, energy) in [
        ("summary.dissipated_j", given.dissipated_j),
        ("summary.available_j", given.available_j),
    ] {
        check_range(name, energy.as_slice(), POSITIVE)?;
    }
    Ok(())
}

fn check_range(
    column: &'static str,
    values: &[f64],
    (is_possible, expected): Range,
) -> Result<(), NetworkError> {
    let bad = |value: &f64| !(value.abs() <= MOST_MAGNITUDE && is_possible(*value));
    match values.iter().position(bad) {
        None => Ok(()),
        Some(index) => Err(NetworkError::Value {
            column,
            index,
            value: values[index],
            expected,
        }),
    }
}

fn check_impact(index: usize, impact: &Impact) -> Result<(), NetworkError> {
    let measures = [
        ("impacts.force", impact.force, ANY),
        ("impacts.direction_deg", impact.direction_deg, ANY),
        ("impacts.speed_m_s", impact.speed_m_s, POSITIVE),
        ("impacts.radius_mm", impact.radius_mm, POSITIVE),
        ("impacts.tip_radius_mm", impact.tip_radius_mm, POSITIVE),
        ("impacts.angle_deg", impact.angle_deg, OBLIQUITY),
        ("impacts.azimuth_deg", impact.azimuth_deg, ANY),
        ("impacts.mass_g", impact.mass_g, POSITIVE),
        ("impacts.energy_j", impact.energy_j, POSITIVE),
        ("impacts.peak_force_n", impact.peak_force_n, POSITIVE),
        ("impacts.contact_time_us", impact.contact_time_us, POSITIVE),
        (
            "impacts.contact_radius_mm",
            impact.contact_radius_mm,
            POSITIVE,
        ),
        (
            "impacts.crushed_radius_mm",
            impact.crushed_radius_mm,
            POSITIVE,
        ),
    ];
    for (column, value, (is_possible, expected)) in measures {
        if let Some(value) = value
            && !(value.abs() <= MOST_MAGNITUDE && is_possible(value))
        {
            return Err(NetworkError::Value {
                column,
                index,
                value,
                expected,
            });
        }
    }
    Ok(())
}

fn check_on_pane(data: &NetworkData) -> Result<(), NetworkError> {
    let nodes = data
        .nodes
        .x
        .iter()
        .zip(&data.nodes.y)
        .map(|(x, y)| ("node", *x, *y));
    let impacts = data
        .impacts
        .iter()
        .map(|impact| ("impact", impact.x, impact.y));
    let fallen = data.fallen.iter().map(|[x, y]| ("fallen", *x, *y));
    let places = nodes.enumerate().chain(impacts.enumerate());
    for (index, (what, x, y)) in places.chain(fallen.enumerate()) {
        if !data.pane.contains(x, y) {
            let (width, height) = (data.pane.width, data.pane.height);
            return Err(NetworkError::OffPane {
                what,
                index,
                x,
                y,
                width,
                height,
            });
        }
    }
    Ok(())
}

fn check_ends(data: &NetworkData) -> Result<(), NetworkError> {
    let segments = &data.segments;
    let count = data.nodes.x.len();
    let mut pairs: Vec<(u32, u32, usize)> = Vec::with_capacity(segments.from.len());
    for (segment, (&from, &to)) in segments.from.iter().zip(&segments.to).enumerate() {
        for (column, index) in [("from", from), ("to", to)] {
            if index as usize >= count {
                return Err(NetworkError::Index {
                    column,
                    segment,
                    index,
                    count,
                    what: "nodes",
                });
            }
        }
        let (a, b) = (from as usize, to as usize);
        #[expect(clippy::float_cmp, reason = "no length means the very same point")]
        let no_length = data.nodes.x[a] == data.nodes.x[b] && data.nodes.y[a] == data.nodes.y[b];
        if no_length {
            return Err(NetworkError::ZeroLength { segment });
        }
        pairs.push((from.min(to), from.max(to), segment));
    }
    pairs.sort_unstable();
    for pair in pairs.windows(2) {
        if (pair[0].0, pair[0].1) == (pair[1].0, pair[1].1) {
            return Err(NetworkError::Duplicate {
                first: pair[0].2,
                second: pair[1].2,
            });
        }
    }
    Ok(())
}

fn check_history(data: &NetworkData) -> Result<(), NetworkError> {
    let segments = &data.segments;
    if let (Some(departures), Some(arrivals)) = (&segments.departure_us, &segments.arrival_us) {
        for (segment, (&departure, &arrival)) in departures.iter().zip(arrivals).enumerate() {
            if departure > arrival {
                return Err(NetworkError::DepartureAfterArrival {
                    segment,
                    departure,
                    arrival,
                });
            }
        }
    }
    let Some(parents) = &segments.parent else {
        return Ok(());
    };
    let count = segments.from.len();
    for (segment, parent) in parents.iter().enumerate() {
        let Some(parent) = *parent else { continue };
        let parent_idx = parent as usize;
        if parent_idx >= count {
            return Err(NetworkError::Index {
                column: "parent",
                segment,
                index: parent,
                count,
                what: "segments",
            });
        }
        if segments.to[parent_idx] != segments.from[segment] {
            let why = "it does not end where this one starts";
            return Err(NetworkError::Parent {
                segment,
                parent,
                why,
            });
        }
        if let Some(times) = segments.arrival()
            && times[segment] < times[parent_idx]
        {
            return Err(NetworkError::ArrivalBeforeParent {
                segment,
                arrival: times[segment],
                parent,
                parent_arrival: times[parent_idx],
            });
        }
        if let (Some(departures), Some(arrivals)) = (&segments.departure_us, &segments.arrival_us)
            && departures[segment] < arrivals[parent_idx]
        {
            return Err(NetworkError::DepartureBeforeParent {
                segment,
                departure: departures[segment],
                parent,
                parent_arrival: arrivals[parent_idx],
            });
        }
    }
    // A chain of parents ends after at most `count` steps; colours mark what is known to end.
    let mut ends = vec![false; count];
    let mut chain = Vec::new();
    for start in 0..count {
        chain.clear();
        let mut at = start;
        while !ends[at] {
            chain.push(at);
            if chain.len() > count {
                let parent = parents[start].unwrap_or_default();
                return Err(NetworkError::Parent {
                    segment: start,
                    parent,
                    why: "it is its own ancestor",
                });
            }
            let Some(parent) = parents[at] else { break };
            at = parent as usize;
        }
        for &segment in &chain {
            ends[segment] = true;
        }
    }
    Ok(())
}
