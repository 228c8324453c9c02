//! Runs of cracks that one facet cannot stand for: others are near, or their relief can be seen.

use starbreak_glass::Face;

use super::chains::{End, distance};
use super::cracks::{Facets, Look, PLACES, RunSurface, normal_of};
use super::lobe::{FRAME, LightFrom, Mirror, SUN, Sent};
use super::roughness::Sampled;
use super::runs::Run;
use super::strip::Strip;
use super::walk::Among;
use crate::vector::Vector;

/// Cells are no larger than this, px, and where relief is seen than that, or than the radius of their
/// blur, unless there are more of them than so many.
const CELL_PX: f64 = 2.0;
const RELIEF_PX: f64 = 1.25;
pub(super) const MOST_CELLS: f64 = 20_000.0;

/// How the wall of a cone leans between its edges is not seen where it reflects less than this everywhere.
const CLEAR: f64 = 0.2;

/// Shares of light that differ by less are one.
const ALIKE: f64 = 0.003;

/// Less of a cell than this is not seen.
const LEAST_VISIBLE: f64 = 1e-3;

/// A run in cells, each with light of its own.
pub(super) struct Divided<'a> {
    pub(super) surface: RunSurface<'a>,
    among: Among<'a>,
    /// Whether how it leans between its edges can be seen.
    has_relief: bool,
    /// Whether that cannot, and changes what it shows.
    is_narrow: bool,
    /// By how much the radius of its blur grows from its first end to its last, px.
    widens_px: f64,
    /// Size of its cells, px.
    pub(super) cell_px: f64,
}

/// What one cell of such a run is like.
#[derive(Clone, Copy)]
struct Cell {
    /// Share of it that no other crack hides.
    visible: f64,
    /// What it shows that the whole does not.
    own: Option<Sent>,
}

/// Corners of the cells of a column, each of which up to four of them share.
struct Corners {
    /// The run where the column begins and ends.
    ends: [End; 2],
    /// Places there, as far as they were asked for.
    places: [Vec<Option<Vector>>; 2],
}

impl Corners {
    fn of(run: &Run, n_across: f64) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "some thousand cells"
        )]
        let n = n_across as usize + 1;
        Self {
            ends: [run.first(), run.last()],
            places: [vec![None; n], vec![None; n]],
        }
    }

    /// To the next column, which begins where this one ends.
    fn go_on(&mut self) {
        self.places.swap(0, 1);
        self.places[1].fill(None);
    }
}

/// What all cells of a column show, if that is one thing; what the whole does where they show nothing of their own.
fn one_of_all<'a>(column: &'a [Cell], whole: &'a Sent) -> Option<&'a Sent> {
    let all = |cell: &'a Cell| cell.own.as_ref().unwrap_or(whole);
    let first = all(column.first()?);
    let is_one = |cell: &'a Cell| cell.visible > 1.0 - LEAST_VISIBLE && is_alike(first, all(cell));
    column.iter().all(is_one).then_some(first)
}

/// Whether two places show the same; places of the frame are never the same but where they are equal.
fn is_alike(a: &Sent, b: &Sent) -> bool {
    let is_near = |(a, b): (&f64, &f64)| (a - b).abs() <= ALIKE;
    a == b
        || a.lanes[FRAME].max(b.lanes[FRAME]) <= ALIKE
            && a.lanes[..=SUN].iter().zip(&b.lanes[..=SUN]).all(is_near)
            && a.tint.iter().zip(&b.tint).all(is_near)
}

impl<'a> Divided<'a> {
    pub(super) fn of(from: &LightFrom<'_>, surface: RunSurface<'a>, among: Among<'a>) -> Self {
        let sheet = from.sheet;
        let blur_px = surface.strip.radius_px.abs();
        let is_clear = surface.chain.is_flared && surface.mirrors_less(from, CLEAR);
        let is_wide = surface.strip.width_px.abs() > blur_px.max(RELIEF_PX);
        let has_relief = surface.chain.has_relief(0.0) && is_wide && !is_clear;
        let least_px = if has_relief { RELIEF_PX } else { CELL_PX };
        let [first, last, ..] = surface.corners;
        let radius_px = |[x, y, z]: Vector| sheet.blur_radius_px([x, y], z);
        let widens_px = radius_px(first)
            .zip(radius_px(last))
            .map_or(0.0, |(first, last)| last - first);
        Self {
            // Only the last band of a cone turns by much within itself.
            is_narrow: surface.chain.is_flared && surface.band[1] >= 1.0 && !is_wide && !is_clear,
            surface,
            among,
            has_relief,
            widens_px,
            cell_px: blur_px.max(least_px),
        }
    }

    /// Whether one facet is not enough.
    pub(super) fn is_needed(&self) -> bool {
        self.has_relief || !self.among.near.is_empty() || self.surface.run.is_steep()
    }

    /// Cells along the run and across it.
    pub(super) fn split(&self) -> [f64; 2] {
        let [a, b, c, d] = self.surface.strip.corners;
        let along_px = distance(a, b).max(distance(d, c));
        let across_px = distance(a, d).max(distance(b, c));
        [along_px, across_px].map(|side| (side / self.cell_px).ceil().max(1.0))
    }

    /// Adds its cells. Neighbors along the run that show the same are one facet.
    pub(super) fn add(&self, from: &LightFrom<'_>, facets: &mut Facets) -> Option<()> {
        let RunSurface {
            chain, run, band, ..
        } = self.surface;
        let [n_along, n_across] = self.split();
        let look_of = |group| {
            let look = Look::of(from, chain, (group, band))?;
            // Where relief shows no cell shows what the whole does.
            let is_whole = !(self.has_relief && chain.has_relief(look.mirror.alpha));
            let sent = is_whole.then(|| look.sent(from, chain, (group, band)));
            Some((look, sent.unwrap_or_default()))
        };
        let looks: Vec<Option<(Look, Sent)>> = run.groups.iter().map(look_of).collect();
        let mut shown = Sent::default();
        // Where columns that show one thing began, and what that is.
        let mut even: Option<(f64, Sent)> = None;
        let mut column = Vec::new();
        let mut corners = Corners::of(run, n_across);
        let mut i = 0.0;
        while i <= n_along {
            let group = run.group_at((i + 0.5) / n_along);
            let is_last = i >= n_along;
            column.clear();
            if !is_last && let Some((look, _)) = &looks[group] {
                corners.ends = [i, i + 1.0].map(|i| self.end_at(i / n_along));
                let middle = self.end_at(0.5 * (i / n_along + (i + 1.0) / n_along));
                let mut j = 0.0;
                while j < n_across {
                    let across = [j / n_across, (j + 1.0) / n_across];
                    let row = column.len();
                    column.push(self.cell(from, look, (&middle, across), (&mut corners, row)));
                    j += 1.0;
                }
            }
            corners.go_on();
            let whole = looks.get(group).and_then(Option::as_ref);
            let whole = whole.map(|(_, sent)| sent);
            let all = whole.and_then(|whole| one_of_all(&column, whole));
            if let Some((first, sent)) = &even
                && !all.is_some_and(|all| is_alike(sent, all))
            {
                self.add_part([[first / n_along, i / n_along], [0.0, 1.0]], sent, facets);
                shown.add(sent, (i - first) / n_along);
                even = None;
            }
            if let Some(all) = all {
                even = even.or(Some((i, *all)));
            } else if let Some(whole) = whole {
                let mut j = 0.0;
                for cell in &column {
                    let sent = cell.own.as_ref().unwrap_or(whole).scaled(cell.visible);
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
        let (look, _) = looks.iter().flatten().next()?;
        self.surface
            .add_around(from, (&shown, &look.ghost), look.mirror.sight, facets);
        Some(())
    }

    /// The run at a fraction of it.
    fn end_at(&self, along: f64) -> End {
        let run = self.surface.run;
        run.first().to(&run.last(), along)
    }

    /// The cell about the middle of its column, between two fractions of the run across it, and its
    /// place among those of the column.
    fn cell(
        &self,
        from: &LightFrom<'_>,
        look: &Look,
        (middle, across): (&End, [f64; 2]),
        (corners, row): (&mut Corners, usize),
    ) -> Cell {
        let chain = self.surface.chain;
        let [low, high] = self.surface.band;
        let from_face = |across: f64| match chain.face {
            Face::Outer => low + (high - low) * across,
            Face::Inner => 1.0 - across,
        };
        let half_way = from_face(0.5 * (across[0] + across[1]));
        let at = chain.place(middle, half_way);
        let visible =
            (self.among.walls).passes(&self.among.near, at, look.inside, |cos, gap_um| {
                from.gaps.mean(cos, gap_um)
            });
        let mut cell = Cell { visible, own: None };
        if visible <= LEAST_VISIBLE {
            cell.visible = 0.0;
            return cell;
        }
        if self.is_narrow && chain.has_relief(look.mirror.alpha) {
            cell.own = Some(self.over_band(from, look, middle));
            return cell;
        }
        let mut mirror = Mirror {
            gap_um: look.mirror.gap_um * chain.closes(half_way),
            ..look.mirror
        };
        let has_relief = self.has_relief && chain.has_relief(mirror.alpha);
        if has_relief {
            let corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[i, j]| {
                let end = &corners.ends[i];
                *corners.places[i][row + j]
                    .get_or_insert_with(|| chain.place(end, from_face(across[j])))
            });
            mirror.normal = normal_of(&corners).unwrap_or(mirror.normal);
        }
        cell.own = (from.mirror_among(&mirror, (at, &self.among)))
            .or_else(|| has_relief.then(|| from.mirror(&mirror, Sampled::Cell(0))));
        cell
    }

    /// What a narrow band shows about the middle of a column: the mean over its depth.
    fn over_band(&self, from: &LightFrom<'_>, look: &Look, middle: &End) -> Sent {
        let (chain, [low, high]) = (self.surface.chain, self.surface.band);
        let ends = [self.surface.run.first(), self.surface.run.last()];
        let mut shown = Sent::default();
        for (k, [part, weight]) in PLACES.into_iter().enumerate() {
            let part = low + (high - low) * part;
            let mirror = chain.mirror_at(look.mirror, &ends, part);
            let at = chain.place(middle, part);
            let own = (from.mirror_among(&mirror, (at, &self.among)))
                .unwrap_or_else(|| from.mirror(&mirror, Sampled::Cell(k)));
            shown.add(&own, weight);
        }
        shown
    }

    /// A facet from one fraction of the run to another, along it and across it.
    fn add_part(&self, [along, across]: [[f64; 2]; 2], sent: &Sent, facets: &mut Facets) {
        let [a, b, c, d] = self.surface.strip.corners;
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
            radius_px: self.surface.strip.radius_px
                + (0.5 * (along[0] + along[1]) - 0.5) * self.widens_px,
            ..self.surface.strip
        };
        strip.add(facets, sent);
    }
}
