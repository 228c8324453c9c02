//! Cracks in pieces of the frame: segments that look like one quadrilateral.

use super::SheetView;
use super::chains::{Chain, End, Piece, distance};

/// Longest piece of a straight crack, px, that one facet stands for, or this part of the radius of
/// a large disc.
const LONGEST_PX: f64 = 48.0;
const LONGEST_OF_BLUR: f64 = 0.125;

/// Most pieces of one segment.
const MOST_PIECES: f64 = 4096.0;

/// A run may lie off its line, at either edge of the crack, by this share of the radius of its
/// blur, and by these px at least and at most.
const OFF_LINE: f64 = 0.04;
const OFF_LINE_PX: [f64; 2] = [0.02, 0.4];

/// Longest run, px, and the longest over surfaces that are not alike, besides the blur's radius.
const LONGEST_RUN_PX: f64 = 24.0;
const LONGEST_MIXED_PX: f64 = 2.0;

/// Least cosine of the angle between a segment of a run and the first one: 6°.
const LEAST_COSINE: f64 = 0.9945;

/// Surfaces are alike that differ by at most this in depth over thickness and in their tilt, and by these ratios in their
/// gaps, unless both are wide, and in their roughness.
const ALIKE_DEPTH: f64 = 0.03;
const ALIKE_TILT_RAD: f64 = 0.03;
const ALIKE_GAPS: f64 = 1.2;
const ALIKE_ALPHAS: f64 = 1.25;

/// Gaps from this on, µm, let nothing through beyond the critical angle: they may differ by this ratio.
const SHUT_OUT_UM: f64 = 0.7;
const ALIKE_WIDER_GAPS: f64 = 2.0;

/// From here on a gap is wide: it reflects in full beyond the critical angle, and without colors
/// short of it.
pub(super) const WIDE_GAP_UM: f64 = 6.0;

/// From this tangent of its tilt on a crack is not nearly upright in the glass: 14°.
const STEEP: f64 = 0.25;

/// Segments that follow each other and look like one quadrilateral.
#[derive(Debug)]
pub(super) struct Run {
    /// Parts of it whose surfaces are alike.
    pub(super) groups: Vec<Group>,
    length: f64,
}

/// A part of a run over which the surface is the same.
#[derive(Debug, Clone, Copy)]
pub(super) struct Group {
    pub(super) ends: [End; 2],
    pub(super) length: f64,
    /// Sums weighted by length.
    pub(super) alpha: f64,
    pub(super) gap_um: f64,
}

impl Group {
    fn of(piece: &Piece) -> Self {
        let length = distance(piece.ends[0].at, piece.ends[1].at);
        Self {
            ends: piece.ends,
            length,
            alpha: length * piece.alpha,
            gap_um: length * piece.gap_um,
        }
    }

    /// Whether a piece that follows may be seen as the same surface: of one depth and tilt, as
    /// rough, and with gaps that are wide for light or alike.
    fn looks_like(&self, piece: &Piece) -> bool {
        let length = self.length.max(f64::MIN_POSITIVE);
        let ratio = |a: f64, b: f64| a.max(b) / a.min(b).max(f64::MIN_POSITIVE);
        let (gap_um, alpha) = (self.gap_um / length, self.alpha / length);
        let first = &self.ends[0];
        let is_wide = gap_um.min(piece.gap_um) >= WIDE_GAP_UM;
        let most = match gap_um.min(piece.gap_um) < SHUT_OUT_UM {
            true => ALIKE_GAPS,
            false => ALIKE_WIDER_GAPS,
        };
        let is_alike = |end: &End| {
            (first.depth - end.depth).abs() <= ALIKE_DEPTH && turns(first.lean, end.lean) <= 1.0
        };
        piece.ends.iter().all(is_alike)
            && (is_wide || ratio(gap_um, piece.gap_um) <= most)
            && (alpha <= 0.0 && piece.alpha <= 0.0 || ratio(alpha, piece.alpha) <= ALIKE_ALPHAS)
    }

    fn add(&mut self, piece: &Piece) {
        let more = Self::of(piece);
        self.ends[1] = piece.ends[1];
        self.length += more.length;
        self.alpha += more.alpha;
        self.gap_um += more.gap_um;
    }
}

impl Run {
    pub(super) fn first(&self) -> End {
        self.groups[0].ends[0]
    }

    pub(super) fn last(&self) -> End {
        self.groups[self.groups.len() - 1].ends[1]
    }

    /// The group at a part of the run's length.
    pub(super) fn group_at(&self, part: f64) -> usize {
        let mut left = part * self.length;
        let is_there = |group: &Group| {
            left -= group.length;
            left <= 0.0
        };
        let last = self.groups.len() - 1;
        self.groups.iter().position(is_there).unwrap_or(last)
    }

    /// Whether light that it turns may come back to it from a face.
    pub(super) fn is_steep(&self) -> bool {
        let ends = self.groups.iter().flat_map(|group| &group.ends);
        ends.map(|end| end.lean.abs()).fold(0.0, f64::max) > STEEP
    }

    pub(super) fn mean_gap_um(&self) -> f64 {
        let sum: f64 = self.groups.iter().map(|group| group.gap_um).sum();
        sum / self.length.max(f64::MIN_POSITIVE)
    }
}

/// How far runs may be from straight.
struct Tolerance {
    off_line_mm: f64,
    longest_mm: f64,
    longest_mixed_mm: f64,
    thickness_mm: f64,
}

impl Tolerance {
    fn at(sheet: &SheetView, chain: &Chain, place: [f64; 2]) -> Self {
        let px_per_mm = sheet.view().px_per_unit(place).unwrap_or(f64::INFINITY);
        let blur_px = sheet
            .blur_radius_px(place, chain.ply_mm[0])
            .unwrap_or(0.0)
            .abs();
        let off_line_px = (OFF_LINE * blur_px).clamp(OFF_LINE_PX[0], OFF_LINE_PX[1]);
        let longest_px = LONGEST_RUN_PX.max(0.5 * LONGEST_OF_BLUR * blur_px);
        Self {
            off_line_mm: off_line_px / px_per_mm,
            longest_mm: longest_px / px_per_mm,
            longest_mixed_mm: blur_px.clamp(LONGEST_MIXED_PX, LONGEST_RUN_PX) / px_per_mm,
            thickness_mm: chain.thickness_mm(),
        }
    }

    /// Whether a run over these points may go on to one more.
    fn allows(&self, points: &[End], to: &End) -> bool {
        let (Some(start), Some(last), Some(second)) =
            (points.first(), points.last(), points.get(1))
        else {
            return false;
        };
        let whole = distance(start.at, to.at);
        if whole > self.longest_mm || whole <= 0.0 {
            return false;
        }
        let along = [0, 1].map(|k| (to.at[k] - start.at[k]) / whole);
        let is_straight = points.iter().all(|p| {
            let (dx, dy) = (p.at[0] - start.at[0], p.at[1] - start.at[1]);
            let off = dx * along[1] - dy * along[0];
            let between = start.to(to, (dx * along[0] + dy * along[1]) / whole);
            let deep = self.thickness_mm * (p.depth - between.depth).abs();
            let leans = self.thickness_mm * p.depth * (p.lean - between.lean).abs();
            off.abs() + deep.max(leans) <= self.off_line_mm
        });
        let turns = |a: &End, b: &End| {
            let length = distance(a.at, b.at);
            let cosine = ((b.at[0] - a.at[0]) * along[0] + (b.at[1] - a.at[1]) * along[1]) / length;
            length > 0.0 && cosine < LEAST_COSINE
        };
        is_straight && !turns(start, second) && !turns(last, to)
    }
}

/// The runs of a chain that are in the frame or within reach of it.
pub(super) fn each_run(sheet: &SheetView, chain: &Chain, reach_px: f64, mut each: impl FnMut(Run)) {
    let mut points: Vec<End> = Vec::new();
    let mut run: Option<(Run, Tolerance)> = None;
    for piece in chain
        .pieces
        .iter()
        .flat_map(|piece| smooth_parts(sheet, chain, piece))
    {
        let piece = &piece;
        let [a, b] = &piece.ends;
        let line = [a.at[0], a.at[1], b.at[0], b.at[1]];
        // What is shut is not seen.
        let is_open = piece.gap_um > 0.0;
        let Some(visible) = (sheet.view().visible(line, reach_px)).filter(|_| is_open) else {
            if let Some((run, _)) = run.take() {
                each(run);
            }
            continue;
        };
        let group = Group::of(piece);
        if let Some((open, tolerance)) = &mut run
            && let Some(last) = points.last()
            && distance(last.at, a.at) <= 0.0
            && tolerance.thickness_mm * (last.depth - a.depth).abs() <= tolerance.off_line_mm
            && tolerance.thickness_mm * (last.lean - a.lean).abs() <= tolerance.off_line_mm
            && tolerance.allows(&points, b)
        {
            let is_alike = open
                .groups
                .last()
                .is_some_and(|group| group.looks_like(piece));
            if is_alike || open.length + group.length <= tolerance.longest_mixed_mm {
                points.push(*b);
                open.length += group.length;
                match open.groups.last_mut().filter(|_| is_alike) {
                    Some(last) => last.add(piece),
                    None => open.groups.push(group),
                }
                continue;
            }
        }
        if let Some((run, _)) = run.take() {
            each(run);
        }
        let [u0, v0, u1, v1] = visible;
        let length_px = ((u1 - u0) * (u1 - u0) + (v1 - v0) * (v1 - v0)).sqrt();
        if length_px > LONGEST_PX {
            let blur_px = sheet.blur_radius_px(a.at, chain.ply_mm[0]).unwrap_or(0.0);
            let longest_px = LONGEST_PX.max(LONGEST_OF_BLUR * blur_px.abs());
            each_part(sheet, piece, (visible, longest_px), &mut each);
            continue;
        }
        points.clear();
        points.extend([*a, *b]);
        let length = group.length;
        run = Some((
            Run {
                groups: vec![group],
                length,
            },
            Tolerance::at(sheet, chain, a.at),
        ));
    }
    if let Some((run, _)) = run {
        each(run);
    }
}

/// By how much two tilts differ, by their tangents, over what is alike.
fn turns(a: f64, b: f64) -> f64 {
    (b - a).abs() / (ALIKE_TILT_RAD * (1.0 + (a * b).max(0.0)))
}

/// A piece in as many parts as its tilt changes by, none shorter than can be seen.
fn smooth_parts(sheet: &SheetView, chain: &Chain, piece: &Piece) -> impl Iterator<Item = Piece> {
    let [a, b] = piece.ends;
    let turns = turns(a.lean, b.lean);
    let n = if turns > 1.0 {
        let px_per_mm = sheet.view().px_per_unit(a.at).unwrap_or(0.0);
        let blur_px = sheet.blur_radius_px(a.at, chain.ply_mm[0]).unwrap_or(0.0);
        let seen = distance(a.at, b.at) * px_per_mm / blur_px.abs().max(LONGEST_MIXED_PX);
        turns.min(seen).ceil().clamp(1.0, MOST_PIECES)
    } else {
        1.0
    };
    let piece = *piece;
    std::iter::successors(Some(0.0), move |k| (k + 1.0 < n).then_some(k + 1.0)).map(move |k| {
        Piece {
            ends: if n > 1.0 {
                [a.to(&b, k / n), a.to(&b, (k + 1.0) / n)]
            } else {
                [a, b]
            },
            ..piece
        }
    })
}

/// The visible part of a long segment, px, in parts of at most some length, px.
fn each_part(
    sheet: &SheetView,
    piece: &Piece,
    ([u0, v0, u1, v1], longest_px): ([f64; 4], f64),
    each: &mut impl FnMut(Run),
) {
    let [a, b] = &piece.ends;
    let length = distance(a.at, b.at);
    let part_of = |at: [f64; 2]| -> Option<f64> {
        Some(distance(a.at, sheet.view().unproject(at)?) / length)
    };
    let (Some(start), Some(end)) = (part_of([u0, v0]), part_of([u1, v1])) else {
        return;
    };
    let length_px = ((u1 - u0) * (u1 - u0) + (v1 - v0) * (v1 - v0)).sqrt();
    let n = (length_px / longest_px).ceil().clamp(1.0, MOST_PIECES);
    let mut k = 0.0;
    while k < n {
        let at = |k: f64| a.to(b, start + (end - start) * k / n);
        let part = Piece {
            ends: [at(k), at(k + 1.0)],
            ..*piece
        };
        let group = Group::of(&part);
        each(Run {
            length: group.length,
            groups: vec![group],
        });
        k += 1.0;
    }
}
