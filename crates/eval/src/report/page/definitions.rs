//! What every number means, in plain words.

use super::super::words;
use super::{Block, Section, Term};

/// The words of the page, in the order in which a reader meets them.
const TERMS: &[Term] = &[
    Term {
        word: "IoU",
        meaning: "Intersection over union of two boxes: the area covered by both, divided by the area covered \
                  by either. 1 is a perfect match, 0 no overlap.",
    },
    Term {
        word: "AP50, AP75, AP",
        meaning: "Average precision as in MS-COCO: the mean precision at 101 recalls, where a detection counts \
                  as correct at an IoU of at least 0.5 or 0.75; AP alone is the mean over the IoUs 0.50, 0.55, \
                  …, 0.95. Over all classes it is the mean of the classes. In a supercategory, all its classes \
                  count as one; the mean of supercategories is the mean over these. Curves of precision over recall \
                  have these 101 precisions.",
    },
    Term {
        word: "AP40, AP11",
        meaning: "Average precision as in KITTI, at 40 or 11 recalls. With few objects it cannot reach 100 %: \
                  the ceiling is what a perfect detector would get.",
    },
    Term {
        word: "Region",
        meaning: "The pixels that the broken glass changes, grown by a few pixels. Each image has its own \
                  region. The clean image is evaluated under the mask of its damaged counterpart.",
    },
    Term {
        word: "Coverage and τ",
        meaning: "Coverage is the share of a box that lies in the region. An object is in the region if its \
                  coverage is at least τ. Other objects are ignored there: neither missing nor detecting them \
                  is an error. A detection that matches no object counts as a false positive in the region only \
                  if its own coverage is at least τ.",
    },
    Term {
        word: "Out of region",
        meaning: "The control: objects with a coverage below τ. A change there is not due to damage in front of \
                  the object, but to its surroundings, haze over the whole image, or chance. A warning says where AP50 \
                  changes there with p below 0.01.",
    },
    Term {
        word: "95 % confidence interval",
        meaning: words::INTERVALS,
    },
    Term {
        word: "p and Holm's correction",
        meaning: words::TESTS,
    },
    Term {
        word: "Failure rate",
        meaning: "The share of the objects found in the clean image that are not found in the damaged one \
                  (lost). Recovered objects are found only in the damaged image.",
    },
    Term {
        word: "New false positives",
        meaning: "Detections in the damaged image that match no label and that no detection in the clean image \
                  overlaps by an IoU of 0.5 or more, per million pixels of the area in question. Such a \
                  detection may still show a real object that has no label, or another one.",
    },
    Term {
        word: "Error types (TIDE)",
        meaning: "The AP50 that would be gained if all errors of a type were corrected: wrong class in the right \
                  place, poor overlap, both, a second detection of the same object, a detection of nothing \
                  (background), a missed object. Correcting one type changes the others, so the gains do not \
                  add up. TIDE starts from its own AP50: a class that is detected but has no objects counts as \
                  0 in the mean, and an image keeps its 100 best detections over all classes, not of each \
                  class. It is therefore mostly lower than the AP50 of MS-COCO.",
    },
    Term {
        word: "mPC and rPC",
        meaning: "Mean performance under corruption (mPC): AP on the damaged images, averaged over families \
                  (presets), severities and seeds. Relative performance under corruption (rPC): mPC \
                  divided by the clean AP. Their n counts the different objects evaluated in at least one \
                  condition.",
    },
    Term {
        word: "Lost, at risk, time to detection loss",
        meaning: "For clips. An object is at risk if it is present at the onset of damage and is found in the clean \
                  clip just then. It is lost at the first frame from which it is missed in a set number of its \
                  frames in a row; its time to detection loss is the time from the onset of damage to that \
                  frame. An object that is never lost is censored: it counts for as long as it is present. The \
                  curve is the Kaplan-Meier estimate with Greenwood's interval on the log-log scale; the interval \
                  of the median ends where those of the curve pass one half. The clean clip, under the same \
                  rules, is the control: what is lost without damage.",
    },
    Term {
        word: "Flicker",
        meaning: "For clips: the share of steps from one frame of an object to its next at which it changes \
                  between found and missed.",
    },
    Term {
        word: "Seeds",
        meaning: "A seed is one random draw of damage for all images. For conditions that differ only in their \
                  seed, AP is the mean over the seeds, and a rate is over the objects of all seeds. Two or three \
                  seeds say little about how much draws of damage differ.",
    },
    Term {
        word: "Numbers not given",
        meaning: "A dash with a letter replaces a number that would look like a finding but rests on too few \
                  objects to be one; the note below the table gives the reason.",
    },
];

pub(super) fn section() -> Section {
    let terms = TERMS.iter().map(|term| Term {
        word: term.word,
        meaning: term.meaning,
    });
    Section {
        id: "meaning".to_owned(),
        title: "Definitions".to_owned(),
        blocks: vec![Block::Terms {
            terms: terms.collect(),
        }],
    }
}
