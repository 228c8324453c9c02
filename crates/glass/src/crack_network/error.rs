//! Why something is not a crack network.

use super::{MAX_IMPACTS, NETWORK_SCHEMA};
use crate::PaneError;

/// Why something is not a crack network.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NetworkError {
    /// Not JSON, or not of this shape.
    #[error(transparent)]
    Parse(#[from] serde_json::Error),
    /// Another format or version.
    #[error("schema = {found:?}; this version reads {NETWORK_SCHEMA:?}")]
    Schema {
        /// What the file says.
        found: String,
    },
    /// The pane has no area.
    #[error(transparent)]
    Pane(#[from] PaneError),
    /// Two columns that belong together differ in length.
    #[error("column `{column}` has {found} entries; expected {expected}")]
    ColumnLength {
        /// Name of the column.
        column: &'static str,
        /// Its length.
        found: usize,
        /// The length of the others.
        expected: usize,
    },
    /// More impacts than a pane may have.
    #[error("{found} impacts; expected {MAX_IMPACTS} at most")]
    TooManyImpacts {
        /// How many there are.
        found: usize,
    },
    /// A number that is not finite, or not in its range.
    #[error("{column}[{index}] = {value:?}; expected {expected}, within 1e18 of 0")]
    Value {
        /// Name of the column.
        column: &'static str,
        /// Which entry.
        index: usize,
        /// What it holds.
        value: f64,
        /// What is possible.
        expected: &'static str,
    },
    /// An index that points nowhere.
    #[error("segments.{column}[{segment}] = {index}, but there are only {count} {what}")]
    Index {
        /// Name of the column.
        column: &'static str,
        /// Which segment.
        segment: usize,
        /// What it points to.
        index: u32,
        /// How many there are.
        count: usize,
        /// Of what.
        what: &'static str,
    },
    /// A node or an impact that lies off the pane.
    #[error("{what} {index} at ({x}, {y}) lies outside the pane of {width} × {height}")]
    OffPane {
        /// `node`, `impact` or `fallen`.
        what: &'static str,
        /// Which one.
        index: usize,
        /// Its position.
        x: f64,
        /// Its position.
        y: f64,
        /// Width of the pane.
        width: f64,
        /// Height of the pane.
        height: f64,
    },
    /// A segment from a node to itself, or between two nodes at one place.
    #[error("segment {segment} has no length")]
    ZeroLength {
        /// Which segment.
        segment: usize,
    },
    /// Two segments between the same two nodes.
    #[error("segments {first} and {second} join the same two nodes")]
    Duplicate {
        /// The earlier one.
        first: usize,
        /// The later one.
        second: usize,
    },
    /// Two segments meet where neither has a node, or one ends in the middle of another.
    #[error("segments {first} and {second} {how}; split them at a common node")]
    NotPlanar {
        /// The earlier one.
        first: u32,
        /// The later one.
        second: u32,
        /// In which way they meet.
        how: &'static str,
    },
    /// So many segments beside each other that looking for crossings would not end.
    #[error(
        "the {n_segments} segments cross or lie beside each other too often to be checked; use fewer"
    )]
    Crowded {
        /// How many.
        n_segments: usize,
    },
    /// A segment that arrives before the one it grew out of, or is its own ancestor.
    #[error(
        "segment {segment} arrives at {arrival}, before its parent {parent} at {parent_arrival}"
    )]
    ArrivalBeforeParent {
        /// Which segment.
        segment: usize,
        /// Its arrival.
        arrival: f64,
        /// Its parent.
        parent: u32,
        /// The parent's arrival.
        parent_arrival: f64,
    },
    /// A segment whose tip leaves later than it arrives.
    #[error("segment {segment} departs at {departure} µs, after its arrival at {arrival} µs")]
    DepartureAfterArrival {
        /// Which segment.
        segment: usize,
        /// Its departure, µs.
        departure: f64,
        /// Its arrival, µs.
        arrival: f64,
    },
    /// A segment whose tip leaves before the one it grew out of is there.
    #[error(
        "segment {segment} departs at {departure} µs, before its parent {parent} arrives at {parent_arrival} µs"
    )]
    DepartureBeforeParent {
        /// Which segment.
        segment: usize,
        /// Its departure, µs.
        departure: f64,
        /// Its parent.
        parent: u32,
        /// The parent's arrival, µs.
        parent_arrival: f64,
    },
    /// A parent that does not end where the child starts, or a chain of parents without end.
    #[error("segment {segment} cannot grow out of segment {parent}: {why}")]
    Parent {
        /// Which segment.
        segment: usize,
        /// Its parent.
        parent: u32,
        /// What is wrong with it.
        why: &'static str,
    },
}
