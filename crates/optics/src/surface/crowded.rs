//! Facets of cracks that others are near.

use starbreak_glass::Face;

use super::SheetView;
use super::chains::{Chain, distance};
use super::cracks::{Facets, Look, add_ghosts};
use super::lobe::{LightFrom, Mirror, Sent};
use super::runs::Run;
use super::strip::Strip;
use super::walk::Among;
use crate::vector::Vector;

/// Where cracks are near each other, facets are no larger than this, px, or this part of the
/// radius of their blur, unless there are more of them than so many.
const CROWDED_PX: f64 = 2.0;
const CROWDED_OF_BLUR: f64 = 1.0;
pub(super) const MOST_CROWDED: f64 = 20_000.0;

/// Less of a facet than this is not seen.
const LEAST_VISIBLE: f64 = 1e-3;

/// A run that other cracks are near: how its surface is divided, and what is at each place.
pub(super) struct Crowded<'a> {
    chain: &'a Chain,
    run: &'a Run,
    among: Among<'a>,
    corners: [Vector; 4],
    strip: Strip,
    /// Size of its facets, px.
    pub(super) facet_px: f64,
}

/// What one facet of such a run is like.
#[derive(Clone, Copy)]
struct Cell {
    /// Share of it that no other crack hides.
    visible: f64,
    /// What it shows where light goes on to other cracks.
    traced: Option<Sent>,
}

impl Cell {
    fn is_plain(&self) -> bool {
        self.traced.is_none() && self.visible > 1.0 - LEAST_VISIBLE
    }
}

impl<'a> Crowded<'a> {
    pub(super) fn of(
        sheet: &SheetView,
        chain: &'a Chain,
        run: &'a Run,
        among: Among<'a>,
    ) -> Option<Self> {
        let corners = chain.corners(&run.first(), &run.last());
        let strip = Strip::new(sheet, &corners)?;
        Some(Self {
            facet_px: (CROWDED_OF_BLUR * strip.radius_px.abs()).max(CROWDED_PX),
            chain,
            run,
            among,
            corners,
            strip,
        })
    }

    /// Facets along the run and across it.
    pub(super) fn split(&self) -> [f64; 2] {
        let [a, b, c, d] = self.strip.corners;
        let along_px = distance(a, b).max(distance(d, c));
        let across_px = distance(a, d).max(distance(b, c));
        [along_px, across_px].map(|side| (side / self.facet_px).ceil().max(1.0))
    }

    /// Adds facets of which others hide a part, and whose light may go on to others. Where neither
    /// is so, neighbors along the run are one facet.
    pub(super) fn add(&self, from: &LightFrom<'_>, facets: &mut Facets) -> Option<()> {
        let [n_along, n_across] = self.split();
        let looks: Vec<Option<Look>> = (self.run.groups.iter())
            .map(|group| Look::of(from, self.chain, group))
            .collect();
        facets.outlines.push(self.strip.corners);
        let mut shown = Sent::default();
        // Where columns without others began, and what they show.
        let mut plain: Option<(f64, usize)> = None;
        let mut column = Vec::new();
        let mut i = 0.0;
        while i <= n_along {
            let group = self.run.group_at((i + 0.5) / n_along);
            let is_last = i >= n_along;
            column.clear();
            if !is_last && let Some(look) = &looks[group] {
                let mut j = 0.0;
                while j < n_across {
                    let place = [(i + 0.5) / n_along, (j + 0.5) / n_across];
                    column.push(self.cell(from, look, place));
                    j += 1.0;
                }
            }
            let is_plain = !is_last && column.iter().all(Cell::is_plain);
            if let Some((first, of)) = plain
                && (!is_plain || of != group)
            {
                plain = None;
                if let Some(look) = &looks[of] {
                    let part = [[first / n_along, i / n_along], [0.0, 1.0]];
                    self.add_part(part, &look.sent, facets);
                    shown.add(&look.sent, (i - first) / n_along);
                }
            }
            if is_plain && !column.is_empty() {
                plain = plain.or(Some((i, group)));
            } else if let Some(look) = looks.get(group).and_then(Option::as_ref) {
                let mut j = 0.0;
                for cell in &column {
                    let sent = cell
                        .traced
                        .as_ref()
                        .unwrap_or(&look.sent)
                        .scaled(cell.visible);
                    let along = [i / n_along, (i + 1.0) / n_along];
                    if cell.visible > LEAST_VISIBLE {
                        let part = [along, [j / n_across, (j + 1.0) / n_across]];
                        self.add_part(part, &sent, facets);
                    }
                    shown.add(&sent, 1.0 / (n_along * n_across));
                    j += 1.0;
                }
            }
            i += 1.0;
        }
        let look = looks.iter().flatten().next()?;
        add_ghosts(
            from,
            &self.corners,
            (&self.strip, &shown),
            &look.ghost,
            look.mirror.sight,
            facets,
        );
        Some(())
    }

    fn cell(&self, from: &LightFrom<'_>, look: &Look, [along, across]: [f64; 2]) -> Cell {
        let [a, b, c, d] = &self.corners;
        let mix = |p: f64, q: f64, t: f64| p + (q - p) * t;
        let at: Vector =
            std::array::from_fn(|k| mix(mix(a[k], b[k], along), mix(d[k], c[k], along), across));
        let among = &self.among;
        let visible = among
            .walls
            .passes(&among.near, at, look.inside, |cos, gap_um| {
                from.mean_reflectance(cos, gap_um)
            });
        if visible <= LEAST_VISIBLE {
            return Cell {
                visible: 0.0,
                traced: None,
            };
        }
        let from_face = match self.chain.face {
            Face::Outer => across,
            Face::Inner => 1.0 - across,
        };
        let mirror = Mirror {
            gap_um: look.mirror.gap_um * self.chain.closes(from_face),
            ..look.mirror
        };
        Cell {
            visible,
            traced: from.mirror_among(&mirror, (at, among)),
        }
    }

    /// A facet from one fraction of the run to another, along it and across it.
    fn add_part(&self, [along, across]: [[f64; 2]; 2], sent: &Sent, facets: &mut Facets) {
        let [a, b, c, d] = self.strip.corners;
        let mix = |p: f64, q: f64, t: f64| p + (q - p) * t;
        let at = |s: f64, t: f64| [0, 1].map(|k| mix(mix(a[k], b[k], s), mix(d[k], c[k], s), t));
        let corners = [
            at(along[0], across[0]),
            at(along[1], across[0]),
            at(along[1], across[1]),
            at(along[0], across[1]),
        ];
        let strip = Strip {
            corners,
            ..self.strip
        };
        strip.add(facets, sent);
    }
}
