//! Where and how the glass is hit.

use serde::{Deserialize, Serialize};

/// Radius of lateral cracks over that of the crushed zone to the power of 1.25, mm^−0.25: the radius of
/// \[MarshallLawnEvans1982\], (0.0289 (cot ψ)^(5/6) (E/H)^(3/4) / (`K_c` H^(1/4)))^(1/2) P^(5/8), of a contact that is
/// crushed all over, P = π H r², in soda-lime glass: E = 70 GPa, H = 5.5 GPa, `K_c` = 0.75 MPa √m, ψ = 68°.
const LATERAL: f64 = 9.4;

/// Part of the way from the crushed zone to the end of its lateral cracks that is off or white. FIT: in photographs of
/// chips pits are 0.1 to 0.2 as wide as the star or the cone.
const CHIPPED_OFF: f64 = 0.5;

/// Least radius of a pit over that of the contact: the edges of a stone crush the face where its body does not. FIT.
const UNDER_STONE: f64 = 0.7;

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

impl Impact {
    /// Radius of the pit that is left in a ply, mm: of glass that is crushed, or has come off above lateral cracks, which
    /// reach no farther beyond it than the ply is thick (FIT). 0 where the contact is not known.
    ///
    /// ```
    /// use starbreak_glass::Impact;
    ///
    /// // A stone whose tip crushed 0.31 mm of the face, in a ply of 2.1 mm: lateral cracks reach 2.2 mm.
    /// let hit = Impact {
    ///     contact_radius_mm: Some(0.39),
    ///     crushed_radius_mm: Some(0.31),
    ///     ..Impact::default()
    /// };
    /// assert!((hit.pit_radius_mm(2.1) - 1.24).abs() < 0.01);
    /// // A blunt one crushes nothing: what its edges do is left.
    /// let blunt = Impact {
    ///     contact_radius_mm: Some(0.8),
    ///     crushed_radius_mm: Some(0.0),
    ///     ..Impact::default()
    /// };
    /// assert!((blunt.pit_radius_mm(2.1) - 0.56).abs() < 1e-12);
    /// assert_eq!(Impact::default().pit_radius_mm(2.1), 0.0);
    /// ```
    #[must_use]
    pub fn pit_radius_mm(&self, ply_mm: f64) -> f64 {
        let [contact_mm, crushed_mm] = [self.contact_radius_mm, self.crushed_radius_mm]
            .map(|radius| radius.unwrap_or(0.0).max(0.0));
        let lateral_mm =
            (LATERAL * libm::pow(crushed_mm, 1.25)).clamp(crushed_mm, crushed_mm + ply_mm.max(0.0));
        let pit_mm = crushed_mm + CHIPPED_OFF * (lateral_mm - crushed_mm);
        pit_mm.max(UNDER_STONE * contact_mm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lateral_cracks_are_those_of_the_law() {
        let (young_pa, hardness_pa, toughness): (f64, f64, f64) = (70e9, 5.5e9, 0.75e6);
        let cot = 1.0 / 68.0_f64.to_radians().tan();
        let square = 0.0289 * cot.powf(5.0 / 6.0) * (young_pa / hardness_pa).powf(0.75)
            / (toughness * hardness_pa.powf(0.25));
        for crushed_mm in [0.1_f64, 0.3, 1.0] {
            let force_n = std::f64::consts::PI * hardness_pa * (1e-3 * crushed_mm).powi(2);
            let law_mm = 1e3 * square.sqrt() * force_n.powf(0.625);
            let here_mm = LATERAL * crushed_mm.powf(1.25);
            assert!(
                (here_mm / law_mm - 1.0).abs() < 0.01,
                "{crushed_mm} mm: {here_mm} mm, {law_mm} by the law"
            );
        }
    }

    #[test]
    fn a_pit_ends_within_half_a_ply_of_what_is_crushed() {
        let hit = |crushed_mm| Impact {
            crushed_radius_mm: Some(crushed_mm),
            ..Impact::default()
        };
        for crushed_mm in [0.01, 0.2, 2.0, 20.0] {
            let pit_mm = hit(crushed_mm).pit_radius_mm(2.1);
            let beyond_mm = pit_mm - crushed_mm;
            assert!(
                (0.0..=1.05 + 1e-9).contains(&beyond_mm),
                "{crushed_mm} mm: {pit_mm} mm"
            );
        }
    }
}
