//! What cracks that are there have relieved of the stress in the plane.

use std::collections::BTreeMap;

use starbreak_glass::SegmentKind;

use super::long_crack::PaneStress;
use crate::stress::{PlaneStress, StressField};
use crate::tips::Web;

/// Cracks are taken as straight between places this far apart, m.
const STRAIGHT_M: f64 = 0.01;

/// From this part of a crack's half length beside it nothing is relieved: where
/// [`left_over`] comes to 1.
const REACH: f64 = 0.786_151_377_757_423_3;

/// Stress in the plane of a pane that long cracks run through already.
pub(super) struct Relieved<'a> {
    field: &'a PaneStress,
    cracks: Vec<Line>,
}

/// A long crack, from the hit that it came from, or the rim, to its tip.
struct Line {
    points: Vec<[f64; 2]>,
    /// Way from the first point to each, m.
    ways_m: Vec<f64>,
    /// Whether it ends in the glass, not at the rim or another crack.
    has_tip: bool,
    /// Least and greatest x and y of where it relieves anything.
    bounds_m: [[f64; 2]; 2],
}

impl<'a> Relieved<'a> {
    /// By the long cracks of a web, as they are now.
    pub(super) fn by(web: &Web, field: &'a PaneStress) -> Self {
        let mut n_at = vec![0_u32; web.nodes.len()];
        let mut ways: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        let mut begins: BTreeMap<u32, u32> = BTreeMap::new();
        for piece in &web.pieces {
            n_at[piece.a as usize] += 1;
            n_at[piece.b as usize] += 1;
            begins.entry(piece.crack).or_insert(piece.a);
            if piece.kind == SegmentKind::Edge {
                ways.entry(piece.crack)
                    .or_insert_with(|| vec![piece.a])
                    .push(piece.b);
            }
        }
        let line = |(crack, nodes): (u32, Vec<u32>)| {
            let mut root = crack;
            while let Some(parent) = web.parent(root) {
                root = parent;
            }
            let first = begins.get(&root).copied();
            let end = *nodes.last()?;
            let at = |node: u32| web.nodes[node as usize];
            let is_open = n_at[end as usize] > 1 || web.outline.depth_m(at(end)) <= 1e-6;
            Some(Line::new(first.into_iter().chain(nodes).map(at), !is_open))
        };
        Self {
            field,
            cracks: ways.into_iter().filter_map(line).collect(),
        }
    }

    /// The stress of the pane without them.
    pub(super) fn whole(&self) -> &PaneStress {
        self.field
    }
}

impl Line {
    fn new(places: impl Iterator<Item = [f64; 2]>, has_tip: bool) -> Self {
        let (mut points, mut ways_m) = (Vec::new(), Vec::new());
        let mut last: Option<[f64; 2]> = None;
        let mut way_m = 0.0;
        for place in places {
            let since_m = last.map_or(f64::INFINITY, |last| distance(last, place));
            if since_m >= STRAIGHT_M {
                way_m += if last.is_some() { since_m } else { 0.0 };
                points.push(place);
                ways_m.push(way_m);
                last = Some(place);
            }
        }
        let bounds_m = [0, 1].map(|axis| {
            let values = points.iter().map(|point| point[axis]);
            let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| {
                [low.min(at), high.max(at)]
            });
            [low - REACH * way_m, high + REACH * way_m]
        });
        Self {
            points,
            ways_m,
            has_tip,
            bounds_m,
        }
    }

    /// Takes from a stress what the crack has relieved.
    fn relieve(&self, stress: &mut PlaneStress, at_m: [f64; 2]) {
        let is_near = |axis: usize| {
            let [low, high] = self.bounds_m[axis];
            (low..=high).contains(&at_m[axis])
        };
        if !is_near(0) || !is_near(1) {
            return;
        }
        // Distance, way along the crack, and direction across it, of its nearest place.
        let mut nearest = (f64::INFINITY, 0.0, [0.0, 0.0]);
        for (k, ends) in self.points.windows(2).enumerate() {
            let [a, b] = [ends[0], ends[1]];
            let length_m = distance(a, b);
            let along = [0, 1].map(|axis| (b[axis] - a[axis]) / length_m);
            let to = [at_m[0] - a[0], at_m[1] - a[1]];
            let way_m = (to[0] * along[0] + to[1] * along[1]).clamp(0.0, length_m);
            let off = [0, 1].map(|axis| to[axis] - way_m * along[axis]);
            let off_m = libm::hypot(off[0], off[1]);
            if off_m < nearest.0 {
                let across = if off_m > 0.0 {
                    off.map(|part| part / off_m)
                } else {
                    [-along[1], along[0]]
                };
                nearest = (off_m, self.ways_m[k] + way_m, across);
            }
        }
        let (off_m, way_m, across) = nearest;
        let whole_m = self.ways_m.last().copied().unwrap_or(0.0);
        // Towards its tip it relieves less and less.
        let half_m = if self.has_tip {
            whole_m - way_m
        } else {
            whole_m
        };
        if off_m >= REACH * half_m {
            return;
        }
        let [nx, ny] = across;
        let taken = 1.0 - left_over(off_m / half_m);
        let normal = taken * stress.normal_pa(across);
        let shear =
            taken * (nx * ny * (stress.yy_pa - stress.xx_pa) + (nx * nx - ny * ny) * stress.xy_pa);
        stress.xx_pa -= normal * nx * nx - 2.0 * shear * nx * ny;
        stress.yy_pa -= normal * ny * ny + 2.0 * shear * nx * ny;
        stress.xy_pa -= normal * nx * ny + shear * (nx * nx - ny * ny);
    }
}

/// What is left of the tension across a crack beside the middle of it, at a distance over its half
/// length: u (u² + 2)/(u² + 1)^{3/2} \[Westergaard1939\].
fn left_over(u: f64) -> f64 {
    let root = (u * u + 1.0).sqrt();
    u * (u * u + 2.0) / (root * root * root)
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    libm::hypot(b[0] - a[0], b[1] - a[1])
}

impl StressField for Relieved<'_> {
    fn stress_at(&self, point_m: [f64; 2], hint: &mut u32) -> Option<PlaneStress> {
        let mut stress = self.field.stress_at(point_m, hint)?;
        for crack in &self.cracks {
            crack.relieve(&mut stress, point_m);
        }
        Some(stress)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PULLED: PlaneStress = PlaneStress {
        xx_pa: 1e6,
        yy_pa: 3e6,
        xy_pa: 0.5e6,
    };

    fn level(has_tip: bool) -> Line {
        Line::new((0..=60).map(|k| [0.01 * f64::from(k), 0.0]), has_tip)
    }

    #[test]
    fn tension_across_is_gone_at_the_crack_and_tension_along_it_stays() {
        let mut stress = PULLED;
        level(false).relieve(&mut stress, [0.3, 1e-9]);
        assert!(stress.yy_pa.abs() < 1.0, "across: {stress:?}");
        assert!(stress.xy_pa.abs() < 1.0, "shear: {stress:?}");
        assert!((stress.xx_pa - 1e6).abs() < 1.0, "along: {stress:?}");
    }

    #[test]
    fn what_is_left_is_what_the_crack_in_an_infinite_sheet_leaves() {
        // σ_yy = Re Z + y Im Z′ with Z = σ z/√(z² − a²), at z = iy.
        for u in [0.1, 0.3, 0.6] {
            let mut stress = PULLED;
            level(false).relieve(&mut stress, [0.3, 0.6 * u]);
            let a2 = 1.0 / (u * u);
            let expected = 3e6 / (1.0 + a2).sqrt() * (1.0 + a2 / (1.0 + a2));
            assert!((stress.yy_pa - expected).abs() < 1.0, "u = {u}: {stress:?}");
        }
        assert!((left_over(REACH) - 1.0).abs() < 1e-12, "the reach");
        let mut far = PULLED;
        level(false).relieve(&mut far, [0.3, 0.6 * REACH + 1e-6]);
        assert_eq!(far, PULLED, "beyond the reach");
    }

    #[test]
    fn at_its_tip_a_crack_relieves_nothing_and_turning_it_turns_what_it_relieves() {
        let mut stress = PULLED;
        level(true).relieve(&mut stress, [0.599, 0.01]);
        assert_eq!(stress, PULLED, "near the tip");
        // The same, a quarter of a turn on.
        let upright = Line::new((0..=60).map(|k| [0.0, 0.01 * f64::from(k)]), false);
        let mut turned = PlaneStress {
            xx_pa: PULLED.yy_pa,
            yy_pa: PULLED.xx_pa,
            xy_pa: -PULLED.xy_pa,
        };
        let mut stress = PULLED;
        level(false).relieve(&mut stress, [0.3, 0.05]);
        upright.relieve(&mut turned, [-0.05, 0.3]);
        assert!((turned.xx_pa - stress.yy_pa).abs() < 1e-3, "{turned:?}");
        assert!((turned.yy_pa - stress.xx_pa).abs() < 1e-3, "{turned:?}");
        assert!((turned.xy_pa + stress.xy_pa).abs() < 1e-3, "{turned:?}");
    }
}
