//! Non-maximum suppression.

use crate::contract::NmsContract;
use crate::decode::Candidate;

/// The candidates by falling score, without those that overlap a better one by more than the
/// threshold; equal scores keep the order of the model's output, as the stable sort of PyTorch and
/// torchvision does.
///
/// Overlap is calculated in 32-bit floating point as `torchvision.ops.nms` does:
/// `intersection / (area_a + area_b - intersection) > iou`.
pub(crate) fn suppress(mut candidates: Vec<Candidate>, nms: &NmsContract) -> Vec<Candidate> {
    sort_by_score(&mut candidates);
    candidates.truncate(nms.max_candidates as usize);
    let mut kept: Vec<Candidate> = Vec::new();
    // What is kept, per class: a box needs to be compared with its own class only.
    let mut kept_of: Vec<Vec<(usize, f32)>> = Vec::new();
    for candidate in candidates {
        let class = if nms.is_across_classes {
            0
        } else {
            candidate.class as usize
        };
        if kept_of.len() <= class {
            kept_of.resize_with(class + 1, Vec::new);
        }
        let area = area(candidate.corners);
        let Some(rivals) = kept_of.get_mut(class) else {
            continue;
        };
        let is_covered = rivals.iter().any(|&(place, rival_area)| {
            kept.get(place).is_some_and(|rival| {
                overlap(rival.corners, rival_area, candidate.corners, area) > nms.iou
            })
        });
        if !is_covered {
            rivals.push((kept.len(), area));
            kept.push(candidate);
        }
    }
    kept
}

/// Falling scores; equal ones in their order.
pub(crate) fn sort_by_score(candidates: &mut [Candidate]) {
    candidates.sort_by(|a, b| b.score.total_cmp(&a.score));
}

fn area([x0, y0, x1, y1]: [f32; 4]) -> f32 {
    (x1 - x0) * (y1 - y0)
}

fn overlap(a: [f32; 4], area_a: f32, b: [f32; 4], area_b: f32) -> f32 {
    let width = (a[2].min(b[2]) - a[0].max(b[0])).max(0.0);
    let height = (a[3].min(b[3]) - a[1].max(b[1])).max(0.0);
    let intersection = width * height;
    intersection / (area_a + area_b - intersection)
}

#[cfg(test)]
mod tests {
    use super::{Candidate, NmsContract, suppress};

    fn candidate(corners: [f32; 4], score: f32, class: u32) -> Candidate {
        Candidate {
            corners,
            score,
            class,
        }
    }

    const NMS: NmsContract = NmsContract {
        iou: 0.5,
        is_across_classes: false,
        max_candidates: 100,
    };

    #[test]
    fn a_worse_box_over_a_better_one_goes_only_within_its_class() {
        let better = candidate([0.0, 0.0, 10.0, 10.0], 0.9, 1);
        let worse = candidate([0.0, 0.0, 10.0, 9.0], 0.8, 1);
        let other = candidate([0.0, 0.0, 10.0, 9.0], 0.7, 2);
        let all = vec![other, worse, better];
        assert_eq!(suppress(all.clone(), &NMS), [better, other], "per class");
        let across = NmsContract {
            is_across_classes: true,
            ..NMS
        };
        assert_eq!(suppress(all, &across), [better], "across classes");
    }

    #[test]
    fn an_overlap_of_just_the_threshold_stays_and_ties_keep_their_order() {
        // 50 of 100: exactly one half.
        let whole = candidate([0.0, 0.0, 10.0, 10.0], 0.5, 0);
        let half = candidate([0.0, 0.0, 10.0, 5.0], 0.5, 0);
        assert_eq!(suppress(vec![half, whole], &NMS), [half, whole], "a tie");
        let more = candidate([0.0, 0.0, 10.0, 5.1], 0.5, 0);
        assert_eq!(suppress(vec![whole, more], &NMS), [whole], "over one half");
    }
}
