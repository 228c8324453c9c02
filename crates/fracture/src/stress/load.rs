//! Forces and moments at the nodes that stand for a pressure.

use std::f64::consts::PI;

use super::PatchLoad;
use super::dkt::{Element, Frame, deflection};
use super::near_load::NearLoad;
use crate::FractureError;
use crate::mesh::PlateMesh;

/// The load of a uniform pressure on a disc: its force at points that stand for equal areas,
/// each handed to the corners of its triangle by the cubic of the deflection.
pub(super) fn patch(
    mesh: &PlateMesh,
    frames: &[Frame],
    load: &PatchLoad,
) -> Result<Vec<[f64; 3]>, FractureError> {
    let [cx, cy] = load.center_m;
    for (name, value, is_right) in [
        ("force_n", load.force_n, load.force_n.is_finite()),
        (
            "patch radius_m",
            load.radius_m,
            (0.0..1e6).contains(&load.radius_m),
        ),
    ] {
        if !is_right {
            return Err(FractureError::Parameter {
                name,
                value,
                expected: "a finite number, the radius 0 or more".into(),
            });
        }
    }
    let mut found = Vec::new();
    let mut hint = 0;
    // Off the pane there is nothing to press on; `locate` alone would forgive a little.
    let mut add = |point: [f64; 2]| {
        if mesh.outline().depth_m(point) >= 0.0
            && let Some(place) = mesh.locate(point, &mut hint)
        {
            found.push(place);
        }
    };
    if load.radius_m > 0.0 {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped"
        )]
        let n_rings = (3.0 * load.radius_m / mesh.inner_size_m()).clamp(12.0, 40.0) as u32;
        let n_around = 4 * n_rings;
        for ring in 0..n_rings {
            // The middle of a ring's area.
            let radius = load.radius_m * ((f64::from(ring) + 0.5) / f64::from(n_rings)).sqrt();
            for k in 0..n_around {
                let turn = f64::from(k) + 0.5 * f64::from(ring % 2);
                let (sin, cos) = libm::sincos(2.0 * PI * turn / f64::from(n_around));
                add([cx + radius * cos, cy + radius * sin]);
            }
        }
    }
    if found.is_empty()
        && let Some(place) = mesh.locate(load.center_m, &mut hint)
    {
        found.push(place);
    }
    if found.is_empty() {
        return Err(FractureError::Parameter {
            name: "load center x_m",
            value: cx,
            expected: "a load on the mesh".into(),
        });
    }
    let force = load.force_n / found.len() as f64;
    let mut forces = vec![[0.0; 3]; mesh.nodes_of_sides().len()];
    for (triangle, l) in found {
        let nodes = mesh.triangles()[triangle as usize];
        let row = deflection(
            &mesh.corners_m(triangle),
            &nodes.map(|node| frames[node as usize]),
            &l,
        );
        // A force is of the node, a moment of its side.
        let sides = mesh.sides()[triangle as usize];
        for (k, part) in row.iter().enumerate() {
            let takes = if k % 3 == 0 { nodes } else { sides };
            forces[takes[k / 3] as usize][k % 3] += force * part;
        }
    }
    Ok(forces)
}

/// Barycentric coordinates and weights of a rule that is exact for polynomials of degree five
/// \[Cowper1973\].
const SEVEN_POINTS: [([f64; 3], f64); 7] = {
    const A: f64 = 0.470_142_064_105_115_1;
    const B: f64 = 0.101_286_507_323_456_34;
    const OF_A: f64 = 0.132_394_152_788_506_2;
    const OF_B: f64 = 0.125_939_180_544_827_14;
    [
        ([1.0 / 3.0; 3], 0.225),
        ([A, A, 1.0 - 2.0 * A], OF_A),
        ([A, 1.0 - 2.0 * A, A], OF_A),
        ([1.0 - 2.0 * A, A, A], OF_A),
        ([B, B, 1.0 - 2.0 * B], OF_B),
        ([B, 1.0 - 2.0 * B, B], OF_B),
        ([1.0 - 2.0 * B, B, B], OF_B),
    ]
};

/// The load of a spread pressure on a whole plate.
pub(super) fn spread(
    mesh: &PlateMesh,
    frames: &[Frame],
    elements: &[Element],
    near: &NearLoad,
) -> Vec<[f64; 3]> {
    let mut forces = vec![[0.0; 3]; mesh.nodes().len()];
    for ((t, nodes), element) in (0..).zip(mesh.triangles()).zip(elements) {
        let corners = mesh.corners_m(t);
        let frames = nodes.map(|node| frames[node as usize]);
        for (l, weight) in &SEVEN_POINTS {
            let at = [0, 1].map(|axis| (0..3).map(|k| l[k] * corners[k][axis]).sum());
            let force = weight * element.area_m2 * near.spread_pa(at);
            if force == 0.0 {
                continue;
            }
            for (k, part) in deflection(&corners, &frames, l).iter().enumerate() {
                forces[nodes[k / 3] as usize][k % 3] += force * part;
            }
        }
    }
    forces
}
