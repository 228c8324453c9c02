//! Where and how the glass is hit.

use serde::{Deserialize, Serialize};

/// One hit on the pane.
///
/// The paper's model knows a force in units of its own and a direction in the plane of the
/// pane, the physics a stone and what its contact did; what a model does not know is absent.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
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
    /// Speed of the stone, m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_m_s: Option<f64>,
    /// Radius of the sphere of the stone's mass, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius_mm: Option<f64>,
    /// Radius of curvature of the stone where it touches, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tip_radius_mm: Option<f64>,
    /// Angle between the path and the normal of the pane, degrees, 0 (head-on) to 90.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angle_deg: Option<f64>,
    /// Direction of the path in the plane of the pane, degrees from +x towards +y (down).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub azimuth_deg: Option<f64>,
    /// Mass of the stone, g.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass_g: Option<f64>,
    /// Kinetic energy of the stone, J.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy_j: Option<f64>,
    /// Greatest force of the contact, N.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub peak_force_n: Option<f64>,
    /// Duration of the contact, µs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact_time_us: Option<f64>,
    /// Greatest radius of the contact, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact_radius_mm: Option<f64>,
    /// Radius of the crushed zone, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crushed_radius_mm: Option<f64>,
    /// Name of the damage class of this hit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damage_class: Option<String>,
}
