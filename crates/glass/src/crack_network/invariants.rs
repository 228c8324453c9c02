//! What a crack network promises, one check each.

use super::{MAX_NODES, NETWORK_SCHEMA, NetworkData, NetworkError, SegmentKind, Summary};

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

/// Key figures of a network whose columns are in order.
pub(super) fn summarize(data: &NetworkData) -> Summary {
    let is_impact = |node: u32| {
        let (x, y) = (data.nodes.x[node as usize], data.nodes.y[node as usize]);
        #[expect(
            clippy::float_cmp,
            reason = "an impact is a node when it is the very same point"
        )]
        data.impacts
            .iter()
            .any(|impact| impact.x == x && impact.y == y)
    };
    let segments = &data.segments;
    let mut n_radial = 0;
    let mut total_length = 0.0;
    for ((&from, &to), kind) in segments.from.iter().zip(&segments.to).zip(&segments.kind) {
        let (a, b) = (from as usize, to as usize);
        let (dx, dy) = (
            data.nodes.x[b] - data.nodes.x[a],
            data.nodes.y[b] - data.nodes.y[a],
        );
        total_length += (dx * dx + dy * dy).sqrt();
        if matches!(kind, SegmentKind::Propagated | SegmentKind::Radial) && is_impact(from) {
            n_radial += 1;
        }
    }
    Summary {
        n_radial,
        n_segments: segments.from.len(),
        total_length,
    }
}

fn check_lengths(data: &NetworkData) -> Result<(), NetworkError> {
    let segments = &data.segments;
    let n_segments = segments.from.len();
    let n_nodes = data.nodes.x.len();
    let of = |column: &Option<Vec<f64>>| column.as_ref().map_or(n_segments, Vec::len);
    let columns = [
        ("nodes.y", data.nodes.y.len(), n_nodes),
        ("segments.to", segments.to.len(), n_segments),
        ("segments.kind", segments.kind.len(), n_segments),
        (
            "segments.parent",
            segments.parent.as_ref().map_or(n_segments, Vec::len),
            n_segments,
        ),
        (
            "segments.arrival_step",
            of(&segments.arrival_step),
            n_segments,
        ),
        ("segments.arrival_us", of(&segments.arrival_us), n_segments),
        (
            "segments.stress_paper_units",
            of(&segments.stress_paper_units),
            n_segments,
        ),
        ("segments.stress_mpa", of(&segments.stress_mpa), n_segments),
        ("segments.opening_um", of(&segments.opening_um), n_segments),
        (
            "segments.depth_fraction",
            of(&segments.depth_fraction),
            n_segments,
        ),
    ];
    for (column, found, expected) in columns {
        if found != expected {
            return Err(NetworkError::ColumnLength {
                column,
                found,
                expected,
            });
        }
    }
    if n_nodes > MAX_NODES {
        return Err(NetworkError::ColumnLength {
            column: "nodes.x",
            found: n_nodes,
            expected: MAX_NODES,
        });
    }
    Ok(())
}

fn check_numbers(data: &NetworkData) -> Result<(), NetworkError> {
    let segments = &data.segments;
    let empty = Vec::new();
    let any = (f64::MIN, "a finite number");
    let positive = (0.0, "a finite number ≥ 0");
    let columns: [(&'static str, &Vec<f64>, (f64, &'static str)); 8] = [
        ("nodes.x", &data.nodes.x, any),
        ("nodes.y", &data.nodes.y, any),
        (
            "segments.arrival_step",
            segments.arrival_step.as_ref().unwrap_or(&empty),
            positive,
        ),
        (
            "segments.arrival_us",
            segments.arrival_us.as_ref().unwrap_or(&empty),
            positive,
        ),
        (
            "segments.stress_paper_units",
            segments.stress_paper_units.as_ref().unwrap_or(&empty),
            any,
        ),
        (
            "segments.stress_mpa",
            segments.stress_mpa.as_ref().unwrap_or(&empty),
            any,
        ),
        (
            "segments.opening_um",
            segments.opening_um.as_ref().unwrap_or(&empty),
            positive,
        ),
        (
            "segments.depth_fraction",
            segments.depth_fraction.as_ref().unwrap_or(&empty),
            positive,
        ),
    ];
    for (column, values, (low, expected)) in columns {
        if let Some(index) = values.iter().position(|v| !(v.is_finite() && *v >= low)) {
            return Err(NetworkError::Value {
                column,
                index,
                value: values[index],
                expected,
            });
        }
    }
    if let Some(depths) = &segments.depth_fraction
        && let Some(index) = depths.iter().position(|depth| *depth > 1.0)
    {
        return Err(NetworkError::Value {
            column: "segments.depth_fraction",
            index,
            value: depths[index],
            expected: "a fraction, 0 to 1",
        });
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
    for (index, (what, x, y)) in nodes.enumerate().chain(impacts.enumerate()) {
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
