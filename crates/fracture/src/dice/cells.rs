//! Middles of dice to the cracks between them: a Voronoi diagram that ends at the rim.

use spade::{DelaunayTriangulation, Point2, Triangulation};
use starbreak_seed::{Seed, Stream};

use super::count::fragment_density_per_m2;
use super::graph::Diced;
use super::points::{self, Middles};
use super::radial_map::RadialMap;
use super::wander::Wander;
use crate::FractureError;
use crate::mesh::{Indexed, Outline, to_u32};

/// Most dice of one pane.
pub(super) const MAX_CELLS: f64 = 400_000.0;
/// Edges shorter than this fraction of a cell become one corner.
const SHORT: f64 = 0.08;
/// Middles up to this many cells from the rim are mirrored in it.
const MIRROR_DEPTH: f64 = 3.0;

/// The dice of a tempered pane.
///
/// As many middles as [`fragment_density_per_m2`] says are thrown at random, none closer to
/// another than a hard core, and the pane is divided between them (Voronoi)
/// \[Pourmoghaddam2018\]. Near a hit all of it happens in a stretched plane, so that dice there are
/// longer along the radius and finer towards the hit. Middles near the rim are mirrored in it, so
/// that the rim itself divides no die and leaves no splinter. Edges shorter than 8 % of a cell are
/// contracted, and a smooth displacement bends all a little. A pane below the onset is left whole.
///
/// # Errors
/// [`FractureError::TooManyDice`] for a pane of more than 400 000.
/// [`FractureError::Triangulation`] if the triangulation library refuses the points.
pub fn dice_cells(
    outline: &Outline,
    thickness_m: f64,
    surface_compression_pa: f64,
    impacts_m: &[[f64; 2]],
    seed: Seed,
) -> Result<Diced, FractureError> {
    let whole = Diced {
        n_cells: 1,
        ..Diced::default()
    };
    let Some(density) = fragment_density_per_m2(surface_compression_pa, thickness_m) else {
        return Ok(whole);
    };
    let [width, height] = outline.size_m();
    let map = RadialMap::new(impacts_m);
    let area = match outline {
        Outline::Rectangle { .. } => width * height,
        Outline::Disc { .. } => 0.25 * std::f64::consts::PI * width * width,
    };
    let area = area + map.excess_area_m2(|point| outline.depth_m(point) > 0.0);
    let expected = density * area;
    if expected > MAX_CELLS {
        return Err(FractureError::TooManyDice {
            expected,
            limit: MAX_CELLS,
            width_mm: width * 1e3,
            height_mm: height * 1e3,
            compression_mpa: surface_compression_pa * 1e-6,
        });
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 0 and 400 000"
    )]
    let n = libm::round(expected) as usize;
    let mut rng = seed.stream(Stream::Dice, 0);
    // Distance in a hexagonal lattice.
    let spacing_m = (2.0 / (3.0_f64.sqrt() * density)).sqrt();
    let middles = points::draw(outline, &map, n, spacing_m, &mut rng);
    if middles.even.len() < 2 {
        return Ok(whole);
    }
    let wander = Wander::new(spacing_m, &mut seed.stream(Stream::Dice, 1));
    let diagram = Diagram::new(outline, &map, &middles, spacing_m)?;
    let (nodes, edges) = diagram.drawn(outline, &map, &wander, spacing_m);
    Ok(Diced::with_front(
        nodes,
        edges,
        middles.even.len(),
        impacts_m,
    ))
}

/// Mirror images of a point in the rim, near it.
fn mirrored(outline: &Outline, point: [f64; 2], depth_m: f64) -> Vec<[f64; 2]> {
    let [x, y] = point;
    match *outline {
        Outline::Rectangle { width_m, height_m } => {
            let images = |at: f64, side: f64| {
                let mut images = vec![at];
                if at < depth_m {
                    images.push(-at);
                }
                if side - at < depth_m {
                    images.push(2.0 * side - at);
                }
                images
            };
            let (xs, ys) = (images(x, width_m), images(y, height_m));
            let mut all = Vec::new();
            for (i, &x) in xs.iter().enumerate() {
                for (j, &y) in ys.iter().enumerate() {
                    if i + j > 0 {
                        all.push([x, y]);
                    }
                }
            }
            all
        }
        Outline::Disc { diameter_m } => {
            let radius = 0.5 * diameter_m;
            let r = libm::hypot(x - radius, y - radius);
            if radius - r >= depth_m || r < 1e-3 * radius {
                return Vec::new();
            }
            let factor = (2.0 * radius - r) / r;
            vec![[
                radius + factor * (x - radius),
                radius + factor * (y - radius),
            ]]
        }
    }
}

/// The nearest point of the rim.
pub(super) fn on_rim(outline: &Outline, [x, y]: [f64; 2]) -> [f64; 2] {
    match *outline {
        Outline::Rectangle { width_m, height_m } => {
            let (x, y) = (x.clamp(0.0, width_m), y.clamp(0.0, height_m));
            let gaps = [x, width_m - x, y, height_m - y];
            let nearest = (0..4).fold(0, |best, k| if gaps[k] < gaps[best] { k } else { best });
            match nearest {
                0 => [0.0, y],
                1 => [width_m, y],
                2 => [x, 0.0],
                _ => [x, height_m],
            }
        }
        Outline::Disc { diameter_m } => {
            let radius = 0.5 * diameter_m;
            let r = libm::hypot(x - radius, y - radius).max(f64::MIN_POSITIVE);
            [
                radius + radius / r * (x - radius),
                radius + radius / r * (y - radius),
            ]
        }
    }
}

/// The point itself, or the nearest to it that lies `inset_m` inside the rim.
fn inside(outline: &Outline, point: [f64; 2], inset_m: f64) -> [f64; 2] {
    let [x, y] = point;
    match *outline {
        Outline::Rectangle { width_m, height_m } => [
            x.clamp(inset_m, width_m - inset_m),
            y.clamp(inset_m, height_m - inset_m),
        ],
        Outline::Disc { diameter_m } => {
            let radius = 0.5 * diameter_m;
            let r = libm::hypot(x - radius, y - radius);
            let factor = if r > radius - inset_m {
                (radius - inset_m) / r
            } else {
                1.0
            };
            [
                radius + factor * (x - radius),
                radius + factor * (y - radius),
            ]
        }
    }
}

/// Voronoi corners and edges in the even plane, short edges contracted.
struct Diagram {
    corners: Vec<[f64; 2]>,
    is_on_rim: Vec<bool>,
    edges: Vec<[u32; 2]>,
}

impl Diagram {
    fn new(
        outline: &Outline,
        map: &RadialMap,
        middles: &Middles,
        spacing_m: f64,
    ) -> Result<Self, FractureError> {
        let n = middles.even.len();
        let mut sites: Vec<Indexed> = (0..n)
            .map(|k| Indexed::new(to_u32(k), middles.even[k]))
            .collect();
        for &point in &middles.on_pane {
            for image in mirrored(outline, point, MIRROR_DEPTH * spacing_m) {
                sites.push(Indexed::new(to_u32(sites.len()), map.to_even(image)));
            }
        }
        // Far away, so that every edge between two middles has a corner at both ends.
        let [width, height] = outline.size_m();
        for corner in 0..8_u32 {
            let (sin, cos) = libm::sincos(f64::from(corner) * std::f64::consts::FRAC_PI_4 + 0.1);
            let far = 10.0 * (width + height);
            let point = [0.5 * width + far * cos, 0.5 * height + far * sin];
            sites.push(Indexed::new(to_u32(sites.len()), point));
        }
        let n_sites = sites.len();
        let triangulation =
            DelaunayTriangulation::<Indexed>::bulk_load_stable(sites).map_err(|cause| {
                FractureError::Triangulation {
                    n_nodes: n_sites,
                    cause: cause.to_string(),
                }
            })?;
        let mut corners = Vec::with_capacity(triangulation.num_all_faces());
        let mut is_on_rim = Vec::with_capacity(triangulation.num_all_faces());
        // Face 0 is the outer one, and has no corner.
        corners.push([f64::NAN; 2]);
        is_on_rim.push(true);
        for face in triangulation.inner_faces() {
            let Point2 { x, y } = face.circumcenter();
            corners.push([x, y]);
            let vertices = face.vertices();
            is_on_rim.push(vertices.iter().any(|v| v.data().idx as usize >= n));
        }
        let mut edges = Vec::with_capacity(3 * n);
        for edge in triangulation.undirected_edges() {
            let is_between = edge.vertices().iter().all(|v| (v.data().idx as usize) < n);
            if is_between {
                let directed = edge.as_directed();
                let faces = [directed.face(), directed.rev().face()].map(|f| f.fix().index());
                if faces.iter().all(|&face| face > 0) {
                    edges.push(faces.map(to_u32));
                }
            }
        }
        let mut diagram = Self {
            corners,
            is_on_rim,
            edges,
        };
        diagram.contract(SHORT * spacing_m);
        Ok(diagram)
    }

    fn length(&self, [a, b]: [u32; 2]) -> f64 {
        let (a, b) = (self.corners[a as usize], self.corners[b as usize]);
        libm::hypot(a[0] - b[0], a[1] - b[1])
    }

    /// Makes one corner of both ends of short edges, the shortest first; no corner takes part
    /// twice, so that nothing moves far.
    fn contract(&mut self, shortest: f64) {
        let mut short: Vec<(f64, usize)> = (0..self.edges.len())
            .map(|k| (self.length(self.edges[k]), k))
            .filter(|(length, _)| *length < shortest)
            .collect();
        short.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut stands_for: Vec<u32> = (0..to_u32(self.corners.len())).collect();
        let mut is_taken = vec![false; self.corners.len()];
        for (_, k) in short {
            let [a, b] = self.edges[k].map(|corner| corner as usize);
            if is_taken[a] || is_taken[b] {
                continue;
            }
            is_taken[a] = true;
            is_taken[b] = true;
            let (keep, lose) = if self.is_on_rim[b] { (b, a) } else { (a, b) };
            if self.is_on_rim[keep] == self.is_on_rim[lose] {
                let (p, q) = (self.corners[keep], self.corners[lose]);
                self.corners[keep] = [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
            }
            stands_for[lose] = to_u32(keep);
        }
        for edge in &mut self.edges {
            *edge = edge.map(|corner| stands_for[corner as usize]);
        }
        self.edges.retain(|[a, b]| a != b);
    }

    /// Nodes and edges on the pane: each edge in pieces, bent.
    fn drawn(
        &self,
        outline: &Outline,
        map: &RadialMap,
        wander: &Wander,
        spacing_m: f64,
    ) -> (Vec<[f64; 2]>, Vec<[u32; 2]>) {
        let n_pieces: u32 = match self.edges.len() {
            0..100_000 => 4,
            100_000..300_000 => 3,
            _ => 2,
        };
        let [width, height] = outline.size_m();
        let inset_m = 1e-3 * spacing_m.min(width).min(height);
        let place = |even: [f64; 2]| {
            let still = map.to_pane(even);
            let calm = (outline.depth_m(still) / (0.5 * spacing_m)).clamp(0.0, 1.0);
            let bend = wander.at(even);
            let bent = map.to_pane([even[0] + calm * bend[0], even[1] + calm * bend[1]]);
            // Where the rim is bent in the even plane, its mirror is not exact.
            inside(outline, bent, inset_m)
        };
        let mut nodes = Vec::new();
        let mut node_of = vec![u32::MAX; self.corners.len()];
        let mut edges = Vec::new();
        for edge in &self.edges {
            for corner in edge.map(|corner| corner as usize) {
                if node_of[corner] == u32::MAX {
                    node_of[corner] = to_u32(nodes.len());
                    let even = self.corners[corner];
                    nodes.push(if self.is_on_rim[corner] {
                        on_rim(outline, map.to_pane(even))
                    } else {
                        place(even)
                    });
                }
            }
            let [a, b] = edge.map(|corner| self.corners[corner as usize]);
            let [mut last, end] = edge.map(|corner| node_of[corner as usize]);
            for piece in 1..n_pieces {
                let t = f64::from(piece) / f64::from(n_pieces);
                let node = place([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
                nodes.push(node);
                let idx = to_u32(nodes.len() - 1);
                edges.push([last, idx]);
                last = idx;
            }
            edges.push([last, end]);
        }
        (nodes, edges)
    }
}
