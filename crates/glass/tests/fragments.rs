//! Fragments against closed forms, against Euler's formula, and against a flood fill.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::f64::consts::{PI, TAU};

use proptest::prelude::*;
use starbreak_glass::{
    CrackNetwork, Generator, GlassKind, LengthUnit, Model, NETWORK_SCHEMA, NetworkData, Nodes,
    Pane, SegmentKind, Segments,
};

fn pane(width: f64, height: f64, kind: GlassKind) -> Pane {
    Pane {
        width,
        height,
        thickness_mm: Some(3.0),
        kind: Some(kind),
    }
}

fn network(pane: Pane, points: &[[f64; 2]], segments: &[[usize; 2]]) -> CrackNetwork {
    let ids = |k: usize| {
        segments
            .iter()
            .map(|ends| u32::try_from(ends[k]).unwrap())
            .collect()
    };
    CrackNetwork::new(NetworkData {
        schema: NETWORK_SCHEMA.to_owned(),
        generator: Generator {
            name: "test".to_owned(),
            version: "1".to_owned(),
        },
        model: Model::Physics,
        seed: None,
        unit: LengthUnit::Mm,
        pane,
        damage_class: None,
        impacts: Vec::new(),
        nodes: Nodes {
            x: points.iter().map(|point| point[0]).collect(),
            y: points.iter().map(|point| point[1]).collect(),
        },
        segments: Segments {
            from: ids(0),
            to: ids(1),
            kind: vec![SegmentKind::Radial; segments.len()],
            ..Segments::default()
        },
        fallen: Vec::new(),
        summary: None,
    })
    .unwrap()
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * (1.0 + a.abs().max(b.abs()))
}

/// Areas, smallest first, once their sum and count have been checked.
fn areas(network: &CrackNetwork) -> Vec<f64> {
    let pane = &network.data().pane;
    let whole = if pane.is_disc() {
        PI * pane.width * pane.width / 4.0
    } else {
        pane.width * pane.height
    };
    let fragments = network.fragments();
    let mut areas: Vec<f64> = fragments.iter().map(|fragment| fragment.area).collect();
    areas.sort_unstable_by(f64::total_cmp);
    let sum: f64 = areas.iter().sum();
    assert!(
        (sum / whole - 1.0).abs() < 1e-9,
        "areas sum to {sum} of {whole}"
    );
    assert_eq!(
        network.summary().n_fragments,
        Some(areas.len()),
        "the summary counts them"
    );
    for k in 0..2 {
        let moment: f64 = fragments.iter().map(|f| f.area * f.centroid[k]).sum();
        let middle = [pane.width, pane.height][k] / 2.0;
        assert!(
            (moment / sum / middle - 1.0).abs() < 1e-9,
            "they balance in the middle"
        );
    }
    areas
}

#[test]
fn an_intact_pane_is_one_fragment() {
    let whole = network(pane(300.0, 200.0, GlassKind::Annealed), &[], &[]);
    let fragments = whole.fragments();
    assert_eq!(areas(&whole), [60000.0], "the pane");
    assert!(
        close(fragments[0].perimeter, 1000.0),
        "its rim: {fragments:?}"
    );
    assert!(fragments[0].touches_rim, "bounded by the rim");
    assert_eq!(fragments[0].outline.len(), 4, "four corners");

    let disc = network(pane(20.0, 20.0, GlassKind::Cover), &[], &[]);
    let fragments = disc.fragments();
    assert_eq!(areas(&disc).len(), 1, "one disc");
    assert!(
        close(fragments[0].perimeter, TAU * 10.0),
        "its rim: {fragments:?}"
    );
    let oval = network(pane(20.0, 30.0, GlassKind::Cover), &[], &[]);
    assert_eq!(areas(&oval), [600.0], "only a square box holds a disc");
}

#[test]
fn a_crack_from_rim_to_rim_parts_the_pane_and_a_dangling_one_does_not() {
    let rectangle = pane(300.0, 200.0, GlassKind::Annealed);
    let points = [[100.0, 0.0], [100.0, 120.0], [100.0, 200.0], [250.0, 150.0]];
    let parted = network(rectangle, &points, &[[0, 1], [1, 2], [1, 3]]);
    assert_eq!(areas(&parted), [20000.0, 40000.0], "left and right");
    let left = parted
        .fragments()
        .into_iter()
        .find(|f| f.area < 3e4)
        .unwrap();
    assert!(close(left.perimeter, 600.0), "{left:?}");
    assert!(
        close(left.centroid[0], 50.0) && close(left.centroid[1], 100.0),
        "{left:?}"
    );
    let hanging = network(rectangle, &points, &[[0, 1], [1, 3]]);
    assert_eq!(areas(&hanging), [60000.0], "nothing came off");
}

#[test]
fn corners_and_the_rim_itself_part_nothing_twice() {
    let rectangle = pane(4.0, 2.0, GlassKind::Annealed);
    let diagonal = network(rectangle, &[[0.0, 0.0], [4.0, 2.0]], &[[0, 1]]);
    assert_eq!(areas(&diagonal), [4.0, 4.0], "corner to corner");
    let points = [[1.0, 0.0], [3.0, 0.0], [2.0, 1.0]];
    let on_rim = network(rectangle, &points, &[[0, 1], [1, 2], [2, 0]]);
    assert_eq!(
        areas(&on_rim),
        [1.0, 7.0],
        "a crack along the rim is the rim"
    );
}

/// A ring of four cracks around the middle of a 10 × 10 pane.
fn square(points: &mut Vec<[f64; 2]>, segments: &mut Vec<[usize; 2]>, half: f64) {
    let first = points.len();
    let (low, high) = (5.0 - half, 5.0 + half);
    points.extend([[low, low], [high, low], [high, high], [low, high]]);
    segments.extend((0..4).map(|k| [first + k, first + (k + 1) % 4]));
}

#[test]
fn a_ring_is_a_hole_in_what_surrounds_it() {
    let (mut points, mut segments) = (Vec::new(), Vec::new());
    for half in [1.0, 2.0, 3.0] {
        square(&mut points, &mut segments, half);
    }
    let rings = network(pane(10.0, 10.0, GlassKind::Annealed), &points, &segments);
    assert_eq!(
        areas(&rings),
        [4.0, 12.0, 20.0, 64.0],
        "4, 16 − 4, 36 − 16, 100 − 36"
    );
    let outer = rings
        .fragments()
        .into_iter()
        .find(|f| f.touches_rim)
        .unwrap();
    assert!(
        close(outer.perimeter, 40.0 + 24.0),
        "rim and hole: {outer:?}"
    );
    let disc = network(pane(10.0, 10.0, GlassKind::Cover), &points, &segments);
    assert!(
        close(areas(&disc)[3], PI * 25.0 - 36.0),
        "in a disc: {:?}",
        areas(&disc)
    );

    // A crack that joins the first two rings parts nothing and bounds nothing.
    segments.push([2, 6]);
    let joined = network(pane(10.0, 10.0, GlassKind::Annealed), &points, &segments);
    assert_eq!(areas(&joined), [4.0, 12.0, 20.0, 64.0], "as before");
    let between = joined
        .fragments()
        .into_iter()
        .find(|f| close(f.area, 12.0))
        .unwrap();
    assert!(
        close(between.perimeter, 24.0),
        "without the bridge: {between:?}"
    );
}

#[test]
fn what_fell_is_the_piece_at_the_point_not_one_that_surrounds_it() {
    let (mut points, mut segments) = (Vec::new(), Vec::new());
    for half in [1.0, 2.0, 3.0] {
        square(&mut points, &mut segments, half);
    }
    let rings = network(pane(10.0, 10.0, GlassKind::Annealed), &points, &segments);
    for (point, area) in [([5.0, 5.0], 4.0), ([5.0, 6.5], 12.0), ([1.0, 1.0], 64.0)] {
        let data = NetworkData {
            fallen: vec![point],
            ..rings.data().clone()
        };
        let fallen = CrackNetwork::new(data).unwrap().fallen_fragments();
        assert_eq!(fallen.len(), 1, "{point:?}");
        assert!(close(fallen[0].area, area), "{point:?}: {}", fallen[0].area);
    }
}

#[test]
fn a_hole_lies_where_it_lies_even_at_the_height_of_a_node() {
    // Cracks to the right end at the very height of the ring's top, 4, from above and below.
    for bend in [0.0, 10.0] {
        let (mut points, mut segments) = (Vec::new(), Vec::new());
        square(&mut points, &mut segments, 1.0);
        let (y, x) = (4.0, 8.0);
        points.extend([[x, bend], [x, y], [10.0, y]]);
        segments.extend([[4, 5], [5, 6]]);
        // What is cut off: 2 × 4 above, or 2 × 6 below.
        let cut = 2.0 * (bend - y).abs();
        let pieces = network(pane(10.0, 10.0, GlassKind::Annealed), &points, &segments);
        assert_eq!(areas(&pieces), [4.0, cut, 96.0 - cut], "bend {bend}");
    }
    // The same on a disc that is cut along its diameter on one side of the ring.
    let points = [
        [4.0, 5.0],
        [3.0, 6.0],
        [2.0, 5.0],
        [3.0, 7.0],
        [10.0, 5.0],
        [5.0, 0.0],
    ];
    let segments = [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5]];
    let disc = network(pane(10.0, 10.0, GlassKind::Cover), &points, &segments);
    let cap = PI * 25.0 / 4.0 - 12.5;
    let found = areas(&disc);
    assert!(
        close(found[1], cap) && close(found[2], PI * 25.0 - 1.0 - cap),
        "{found:?}"
    );
}

#[test]
fn cracks_of_other_plies_part_nothing() {
    let mut data = network(
        pane(10.0, 10.0, GlassKind::Laminated),
        &[[0.0, 2.0], [10.0, 2.0], [0.0, 8.0], [10.0, 8.0]],
        &[[0, 1], [2, 3]],
    )
    .data()
    .clone();
    data.segments.ply = Some(vec![0, 1]);
    let laminate = CrackNetwork::new(data).unwrap();
    assert_eq!(areas(&laminate), [20.0, 80.0], "only the ply that was hit");
}

/// Cells of a triangulation, joined where the edge between them is no crack.
struct Cells(Vec<usize>);

impl Cells {
    fn find(&mut self, cell: usize) -> usize {
        if self.0[cell] != cell {
            self.0[cell] = self.find(self.0[cell]);
        }
        self.0[cell]
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a] = b;
    }
}

/// The areas of the cells that hang together, smallest first.
fn flood(triangles: &[([usize; 3], f64)], cracks: &[[usize; 2]]) -> Vec<f64> {
    let mut sides = std::collections::BTreeMap::new();
    let mut cells = Cells((0..triangles.len()).collect());
    for (cell, ([a, b, c], _)) in triangles.iter().enumerate() {
        for (a, b) in [(*a, *b), (*b, *c), (*c, *a)] {
            let side = [a.min(b), a.max(b)];
            if cracks.contains(&side) {
                continue;
            }
            if let Some(other) = sides.insert(side, cell) {
                cells.join(cell, other);
            }
        }
    }
    let mut areas = std::collections::BTreeMap::new();
    for (cell, (_, area)) in triangles.iter().enumerate() {
        *areas.entry(cells.find(cell)).or_insert(0.0) += area;
    }
    let mut areas: Vec<f64> = areas.into_values().collect();
    areas.sort_unstable_by(f64::total_cmp);
    areas
}

/// Faces without the outside by Euler's formula V − E + F = 1 + C, from nothing but the cracks
/// (dangling ones included) and the rim.
fn by_euler(n_points: usize, cracks: &[[usize; 2]], rim: &[usize]) -> usize {
    let mut parts = Cells((0..n_points).collect());
    let mut used = vec![false; n_points];
    let pieces: Vec<[usize; 2]> = (0..rim.len())
        .map(|k| [rim[k], rim[(k + 1) % rim.len()]])
        .collect();
    let inside = cracks
        .iter()
        .filter(|[a, b]| !pieces.contains(&[*a, *b]) && !pieces.contains(&[*b, *a]));
    let mut n_edges = 0;
    for [a, b] in inside.chain(&pieces) {
        (used[*a], used[*b]) = (true, true);
        parts.join(*a, *b);
        n_edges += 1;
    }
    let n_vertices = used.iter().filter(|used| **used).count();
    let n_parts = (0..n_points)
        .filter(|k| used[*k] && parts.find(*k) == *k)
        .count();
    n_edges + n_parts - n_vertices
}

const COLUMNS: usize = 8;
const ROWS: usize = 7;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    /// A triangulated grid with its inner nodes moved; its edges are cracks at random.
    #[test]
    fn fragments_of_a_rectangle_are_those_of_a_flood_fill(
        draws in prop::collection::vec(0.0_f64..1.0, 3 * COLUMNS * ROWS),
        moves in prop::collection::vec((-0.2_f64..0.2, -0.2_f64..0.2), COLUMNS * ROWS),
        density in 0.2_f64..1.0,
        is_moved in any::<bool>(),
    ) {
        let id = |i: usize, j: usize| j * COLUMNS + i;
        let mut points = Vec::new();
        for j in 0..ROWS {
            for i in 0..COLUMNS {
                let is_inner = i > 0 && j > 0 && i + 1 < COLUMNS && j + 1 < ROWS;
                let (dx, dy) = if is_inner && is_moved { moves[id(i, j)] } else { (0.0, 0.0) };
                points.push([i as f64 + dx, j as f64 + dy]);
            }
        }
        let area = |[a, b, c]: [usize; 3]| {
            let [a, b, c]: [[f64; 2]; 3] = [points[a], points[b], points[c]];
            0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
        };
        let (mut triangles, mut cracks) = (Vec::new(), Vec::new());
        for j in 0..ROWS {
            for i in 0..COLUMNS {
                let at = id(i, j);
                if i + 1 < COLUMNS && j + 1 < ROWS {
                    let (right, down, across) = (at + 1, at + COLUMNS, at + COLUMNS + 1);
                    triangles.extend([[at, right, across], [at, across, down]].map(|t| (t, area(t))));
                }
                for (k, (is_there, other)) in [
                    (i + 1 < COLUMNS, at + 1),
                    (j + 1 < ROWS, at + COLUMNS),
                    (i + 1 < COLUMNS && j + 1 < ROWS, at + COLUMNS + 1),
                ].into_iter().enumerate() {
                    if is_there && draws[3 * at + k] < density {
                        cracks.push([at, other]);
                    }
                }
            }
        }
        let network = network(
            pane((COLUMNS - 1) as f64, (ROWS - 1) as f64, GlassKind::Annealed), &points, &cracks,
        );
        let (found, expected) = (areas(&network), flood(&triangles, &cracks));
        prop_assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(&expected) {
            prop_assert!((found - expected).abs() < 1e-9, "{found} is not {expected}");
        }
        let rim: Vec<usize> = (0..COLUMNS).map(|i| id(i, 0))
            .chain((1..ROWS).map(|j| id(COLUMNS - 1, j)))
            .chain((0..COLUMNS - 1).rev().map(|i| id(i, ROWS - 1)))
            .chain((1..ROWS - 1).rev().map(|j| id(0, j)))
            .collect();
        prop_assert_eq!(found.len(), by_euler(points.len(), &cracks, &rim));
    }

    /// Rings and spokes on a disc; between the outermost ring and the rim lie segments of the
    /// circle.
    #[test]
    fn fragments_of_a_disc_are_those_of_a_flood_fill(
        draws in prop::collection::vec(0.0_f64..1.0, 2 * 9 * 4),
        density in 0.2_f64..1.0,
        turn in 0.0_f64..TAU,
        diameter in 1.0_f64..100.0,
    ) {
        let (n_spokes, n_rings) = (9_usize, 4_usize);
        let radius = diameter / 2.0;
        let mut points = vec![[radius, radius]];
        for ring in 1..=n_rings {
            for spoke in 0..n_spokes {
                let r = radius * ring as f64 / n_rings as f64;
                let (sin, cos) = (turn + TAU * spoke as f64 / n_spokes as f64).sin_cos();
                points.push([radius + r * cos, radius + r * sin]);
            }
        }
        // The circle's own segments hang on nodes of their own, one beyond each rim node.
        let n_points = points.len();
        let id = |ring: usize, spoke: usize| {
            if ring == 0 { 0 } else { 1 + (ring - 1) * n_spokes + spoke % n_spokes }
        };
        let slice = TAU / n_spokes as f64;
        let (mut triangles, mut cracks) = (Vec::new(), Vec::new());
        for ring in 1..=n_rings {
            let (inner, outer) = ((ring - 1) as f64, ring as f64);
            let unit = 0.5 * slice.sin() * radius * radius / (n_rings * n_rings) as f64;
            for spoke in 0..n_spokes {
                let (a, b) = (id(ring - 1, spoke), id(ring, spoke));
                let (c, d) = (id(ring, spoke + 1), id(ring - 1, spoke + 1));
                // Split along a diagonal that is never a crack.
                triangles.push(([a, b, c], unit * outer * (outer - inner)));
                if ring > 1 {
                    triangles.push(([a, c, d], unit * inner * (outer - inner)));
                }
                if ring == n_rings {
                    let area = 0.5 * radius * radius * (slice - slice.sin());
                    triangles.push(([b, n_points + spoke, c], area));
                }
                let draw = 2 * ((ring - 1) * n_spokes + spoke);
                if draws[draw] < density {
                    cracks.push([a.min(b), a.max(b)]);
                }
                if draws[draw + 1] < density {
                    cracks.push([b.min(c), b.max(c)]);
                }
            }
        }
        let network = network(pane(diameter, diameter, GlassKind::Cover), &points, &cracks);
        let (found, expected) = (areas(&network), flood(&triangles, &cracks));
        prop_assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(&expected) {
            prop_assert!((found - expected).abs() < 1e-9 * diameter * diameter, "{found} is not {expected}");
        }
    }
}
