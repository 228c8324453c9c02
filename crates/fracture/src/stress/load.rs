//! Forces and moments at the nodes that stand for a pressure.

use std::f64::consts::PI;

use super::PatchLoad;
use super::dkt::{Frame, deflection};
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
