//! Cracks as facets of the frame.

use std::rc::Rc;

use starbreak_glass::CrackNetwork;

use super::SheetView;
use super::chains::{Chain, End, chains};
use super::divided::{Divided, MOST_CELLS};
use super::lobe::{FRAME, FRAME_U, FRAME_V, LANES, LightFrom, Mirror, N_SHARES, Sent, into_glass};
use super::roughness::{Sampled, WIDE_ALPHA};
use super::runs::{Group, Run, WIDE_GAP_UM, each_run};
use super::strip::Strip;
use super::walk::Among;
use super::walls::{Wall, Walls};
use crate::interface::fresnel::reflectance;
use crate::maps::Facet;
use crate::surface::SurfaceParams;
use crate::vector::{Vector, cross, dot, unit};

/// Colors weaker than this are none.
const LEAST_TINT: f64 = 0.004;

/// Parts of the depth, and weights, at which a crack is looked at whose opening or lean changes with
/// the depth: Gauss-Legendre.
pub(super) const PLACES: [[f64; 2]; 3] = [
    [0.112_701_665_379_258, 5.0 / 18.0],
    [0.5, 8.0 / 18.0],
    [0.887_298_334_620_742, 5.0 / 18.0],
];

/// Places along a crack that are this far apart are never neighbors.
const FAR_ALONG: u32 = 1 << 24;

/// Facets of a crack network, and of what tints them.
#[derive(Debug, Default)]
pub(crate) struct Facets {
    pub(crate) light: Vec<Facet<LANES>>,
    /// Share, and by how much more than the mean each color is reflected.
    pub(crate) tint: Vec<Facet<4>>,
    /// Where surfaces themselves lie in the frame, without their ghosts.
    pub(crate) outlines: Vec<[[f64; 2]; 4]>,
}

/// The facets of all cracks of a network as far as they have grown, within `reach_px` of the
/// frame.
pub(crate) fn crack_facets(
    from: &LightFrom<'_>,
    network: &CrackNetwork,
    time: f64,
    surface: &SurfaceParams,
    reach_px: f64,
    facets: &mut Facets,
) {
    let chains = chains(from.sheet, network, time, surface);
    let mut runs = Vec::new();
    let mut walls = Vec::new();
    for (crack, chain) in (0_u32..).zip(&chains) {
        let mut along = 0;
        each_run(from.sheet, chain, reach_px, |run| {
            along += 1;
            let run = Rc::new(run);
            for (k, band) in (0_u32..).zip(chain.bands()) {
                let corners = chain.corners([&run.first(), &run.last()], band);
                // Bands of a cone see each other.
                let own = along + k * FAR_ALONG;
                let opens = match chain.is_flared {
                    true => chain.closes(0.5 * (band[0] + band[1])),
                    false => 1.0,
                };
                if let Some(wall) = Wall::new(corners, opens * run.mean_gap_um(), crack, own) {
                    walls.push(wall);
                    runs.push((crack, Rc::clone(&run), band));
                }
            }
        });
    }
    let thickness_mm = chains.first().map_or(1.0, Chain::thickness_mm);
    let walls = Walls::new(walls, thickness_mm);
    let mut divided = Vec::new();
    for (k, (crack, run, band)) in runs.iter().enumerate() {
        let chain = &chains[*crack as usize];
        let Some(surface) = RunSurface::of(from.sheet, chain, (run, *band)) else {
            continue;
        };
        let among = Among {
            near: walls.near(k, chain.thickness_mm()),
            walls: &walls,
            own: walls.get(k).own(),
            reach_mm: thickness_mm,
        };
        let run = Divided::of(from, surface, among);
        if run.is_needed() {
            divided.push(run);
        } else {
            run.surface.add_alone(from, facets);
        }
    }
    let n_cells: f64 = divided
        .iter()
        .map(|run| run.split().iter().product::<f64>())
        .sum();
    let coarser = (n_cells / MOST_CELLS).sqrt().max(1.0);
    for run in &mut divided {
        run.cell_px *= coarser;
        run.add(from, facets);
    }
}

impl Chain {
    /// Whether what its front left shows in a surface of this roughness: of very rough ones their
    /// own facets lean by more.
    pub(super) fn has_relief(&self, alpha: f64) -> bool {
        (self.relief.is_some() || self.is_flared) && alpha < WIDE_ALPHA
    }

    /// The mirror that a part of the surface is, at a part of the depth from the face.
    pub(super) fn mirror_at(&self, mirror: Mirror, [a, b]: &[End; 2], part: f64) -> Mirror {
        let [low, high] = [-0.02, 0.02].map(|by| part + by);
        let corners = [(a, low), (b, low), (b, high), (a, high)];
        Mirror {
            normal: normal_of(&corners.map(|(end, part)| self.place(end, part)))
                .unwrap_or(mirror.normal),
            gap_um: mirror.gap_um * self.closes(part),
            ..mirror
        }
    }
}

/// The normal of a surface between four corners, if it has one.
pub(super) fn normal_of([a, b, c, d]: &[Vector; 4]) -> Option<Vector> {
    let along: Vector = std::array::from_fn(|k| b[k] + c[k] - a[k] - d[k]);
    let down: Vector = std::array::from_fn(|k| c[k] + d[k] - a[k] - b[k]);
    let normal = cross(along, down);
    let has_one = normal.iter().any(|part| part.abs() > 0.0);
    has_one.then(|| unit(normal))
}

/// The mirror that a surface between four corners is, seen at one place in it.
fn mirror_of(sheet: &SheetView, corners: &[Vector; 4], group: &Group) -> Option<Mirror> {
    let [a, b, c, d] = corners;
    let middle: Vector = std::array::from_fn(|k| 0.25 * (a[k] + b[k] + c[k] + d[k]));
    let normal = normal_of(corners)?;
    let entry = sheet.entry([middle[0], middle[1]], middle[2], [0.0; 2])?;
    Some(Mirror {
        sight: sheet.sight(entry, [0.0; 2])?,
        normal,
        alpha: group.alpha / group.length,
        gap_um: group.gap_um / group.length,
    })
}

/// A group of a run as sight meets it.
pub(super) struct Look {
    pub(super) mirror: Mirror,
    /// Direction of sight in the glass.
    pub(super) inside: Vector,
    /// What is seen of it once more, by way of the outer face.
    pub(super) ghost: Sent,
}

impl Look {
    pub(super) fn of(
        from: &LightFrom<'_>,
        chain: &Chain,
        (group, band): (&Group, [f64; 2]),
    ) -> Option<Self> {
        let [a, b] = &group.ends;
        let mirror = mirror_of(from.sheet, &chain.corners([a, b], band), group)?;
        Some(Self {
            mirror,
            inside: into_glass(mirror.sight, from.sheet.index),
            ghost: from.ghost(&mirror),
        })
    }

    /// What it sends, the mean over its depth.
    pub(super) fn sent(
        &self,
        from: &LightFrom<'_>,
        chain: &Chain,
        (group, band): (&Group, [f64; 2]),
    ) -> Sent {
        let mirror = self.mirror;
        let closes = chain.has_front && mirror.gap_um < WIDE_GAP_UM;
        let mut sent = Sent::default();
        if chain.has_relief(mirror.alpha) {
            for (k, [part, weight]) in PLACES.into_iter().enumerate() {
                let part = band[0] + (band[1] - band[0]) * part;
                let mirror = chain.mirror_at(mirror, &group.ends, part);
                sent.add(&from.mirror(&mirror, Sampled::Cell(k)), weight);
            }
        } else if closes {
            for (k, [part, weight]) in PLACES.into_iter().enumerate() {
                let part = band[0] + (band[1] - band[0]) * part;
                let gap_um = mirror.gap_um * chain.closes(part);
                let mirror = Mirror { gap_um, ..mirror };
                sent.add(&from.mirror(&mirror, Sampled::Third(k)), weight);
            }
        } else {
            sent = from.mirror(&mirror, Sampled::Whole);
        }
        sent
    }
}

/// A run, its corners in the sheet, and where it appears in the frame.
pub(super) struct RunSurface<'a> {
    pub(super) chain: &'a Chain,
    pub(super) run: &'a Run,
    /// Of its depth, as parts from the face it begins at.
    pub(super) band: [f64; 2],
    pub(super) corners: [Vector; 4],
    pub(super) strip: Strip,
}

impl<'a> RunSurface<'a> {
    fn of(sheet: &SheetView, chain: &'a Chain, (run, band): (&'a Run, [f64; 2])) -> Option<Self> {
        let ends = [&run.first(), &run.last()];
        let corners = chain.corners(ends, band);
        let mut strip = Strip::new(sheet, &corners)?;
        if chain.is_flared {
            // Bands of one wall are blurred alike, so that nothing is seen where they meet.
            strip.radius_px = Strip::new(sheet, &chain.corners(ends, [0.0, 1.0]))?.radius_px;
        }
        Some(Self {
            strip,
            chain,
            run,
            band,
            corners,
        })
    }

    /// Whether it reflects less than this at both of its edges.
    pub(super) fn mirrors_less(&self, from: &LightFrom<'_>, most: f64) -> bool {
        let group = &self.run.groups[0];
        let Some(mirror) = mirror_of(from.sheet, &self.corners, group) else {
            return false;
        };
        let inside = into_glass(mirror.sight, from.sheet.index);
        self.band.into_iter().all(|part| {
            let normal = self.chain.mirror_at(mirror, &group.ends, part).normal;
            from.gaps.mean(dot(inside, normal).abs(), mirror.gap_um) < most
        })
    }

    /// One facet of all of it, which no other crack is near.
    fn add_alone(&self, from: &LightFrom<'_>, facets: &mut Facets) {
        let (mut sent, mut ghost, mut sum) = (Sent::default(), Sent::default(), 0.0);
        let mut sight = [0.0, 0.0, 1.0];
        for group in &self.run.groups {
            let weight = group.length * (group.ends[0].depth + group.ends[1].depth);
            let part = (group, self.band);
            let Some(look) = Look::of(from, self.chain, part) else {
                continue;
            };
            sent.add(&look.sent(from, self.chain, part), weight);
            ghost.add(&look.ghost, weight);
            sum += weight;
            sight = look.mirror.sight;
        }
        if sum <= 0.0 {
            return;
        }
        let (sent, ghost) = (sent.scaled(1.0 / sum), ghost.scaled(1.0 / sum));
        self.strip.add(facets, &sent);
        self.add_around(from, (&sent, &ghost), sight, facets);
    }

    /// Adds its outline and what is seen of it once more beyond it, by way of the faces.
    pub(super) fn add_around(
        &self,
        from: &LightFrom<'_>,
        (sent, ghost): (&Sent, &Sent),
        sight: Vector,
        facets: &mut Facets,
    ) {
        facets.outlines.push(self.strip.corners);
        let sheet = from.sheet;
        let outer = sheet.outer_mm();
        let mut add = |by: f64, strip: &Strip, sent: &Sent| {
            let lanes = sent.lanes.map(|lane| by * lane);
            let tint = [0.0; 3];
            strip.add(facets, &Sent { lanes, tint });
        };
        // By light that the outer face reflects onto the crack's back.
        if ghost.lanes.iter().any(|lane| lane.abs() > LEAST_GHOST)
            && let Some(behind) = Strip::new(
                sheet,
                &self.corners.map(|[x, y, z]| [x, y, 2.0 * outer - z]),
            )
        {
            // Where a crack leans over its own ghost, only what it lets through is seen of that.
            let hidden = (self.strip.width_px / behind.width_px).clamp(0.0, 1.0);
            let passes = 1.0 - hidden * sent.lanes[..N_SHARES].iter().sum::<f64>();
            add(passes, &behind, ghost);
        }
        // And by light that both faces reflect, which is much in a steep sheet only.
        let once = reflectance(sight[2], sheet.index);
        if once * once > LEAST_TWICE
            && let Some(beyond) = Strip::new(
                sheet,
                &self.corners.map(|[x, y, z]| [x, y, 2.0 * outer + z]),
            )
        {
            add(once * once, &beyond, sent);
        }
    }
}

/// Lanes of a ghost that are weaker are none.
const LEAST_GHOST: f64 = 2e-3;

/// Light that both faces reflect is none below this share.
const LEAST_TWICE: f64 = 0.02;

impl Facets {
    /// A facet that sends something. The place of the frame that it shows moves by `moves` from one
    /// of its places to another.
    pub(super) fn add(
        &mut self,
        corners: [[f64; 2]; 4],
        radius_px: f64,
        sent: &Sent,
        moves: [[f64; 2]; 2],
    ) {
        debug_assert_eq!(
            (FRAME_U, FRAME_V),
            (LANES - 2, LANES - 1),
            "the lanes that move"
        );
        #[expect(clippy::cast_possible_truncation, reason = "shares as f32")]
        let (lanes, lean) = (
            sent.lanes.map(|lane| lane as f32),
            moves.map(|row| row.map(|part| (sent.lanes[FRAME] * part) as f32)),
        );
        self.light.push(Facet {
            corners,
            lanes,
            lean,
            radius_px,
        });
        add_tint(self, corners, radius_px, sent.tint);
    }
}

impl Strip {
    /// A mirrored place moves along with the crack and against it across.
    pub(super) fn add(&self, facets: &mut Facets, sent: &Sent) {
        let [nx, ny] = self.normal_px;
        let moves = [
            [1.0 - 2.0 * nx * nx, -2.0 * nx * ny],
            [-2.0 * nx * ny, 1.0 - 2.0 * ny * ny],
        ];
        facets.add(self.corners, self.radius_px, sent, moves);
    }
}

/// Adds a tint where there is one.
fn add_tint(facets: &mut Facets, corners: [[f64; 2]; 4], radius_px: f64, tint: [f64; 3]) {
    if tint.iter().all(|part| part.abs() < LEAST_TINT) {
        return;
    }
    #[expect(clippy::cast_possible_truncation, reason = "shares as f32")]
    let lanes = [1.0, tint[0], tint[1], tint[2]].map(|lane| lane as f32);
    facets.tint.push(Facet {
        corners,
        lanes,
        lean: [[0.0; 2]; 2],
        radius_px,
    });
}
