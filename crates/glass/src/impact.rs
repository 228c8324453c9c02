//! Where and how the glass is hit.

use serde::{Deserialize, Serialize};

/// One hit on the pane.
///
/// The paper's model knows a force in units of its own and a direction in the plane of the
/// pane; both are absent in models that do not use them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Impact {
    /// Position in the network's length unit.
    pub x: f64,
    /// Position in the network's length unit, y down.
    pub y: f64,
    /// The paper's impact force F, in its own unit ("units").
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<f64>,
    /// In-plane direction of the paper's impact vector, degrees from +x towards +y (down).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction_deg: Option<f64>,
}
