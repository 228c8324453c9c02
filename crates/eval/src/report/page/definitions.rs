//! What every number means, in plain words.

use super::super::words;
use super::{Block, Section, Term};

/// The words of the page, in the order in which a reader meets them.
const TERMS: &[Term] = &[
    Term {
        word: "IoU",
        meaning: "Intersection over union of two boxes: the area that both cover, divided by the area that \
                  either covers. 1 is a perfect fit, 0 no contact.",
    },
    Term {
        word: "AP50, AP75, AP",
        meaning: "Average precision: the mean precision over all recalls (101 of them, by the rules of \
                  MS-COCO) when a detection counts as right from an IoU of 0.5 or 0.75 on; AP alone is the mean \
                  over the IoUs 0.50, 0.55, …, 0.95. Over all classes it is the mean of theirs; of a \
                  supercategory, its classes count as one; the mean of the groups is over these.",
    },
    Term {
        word: "AP40, AP11",
        meaning: "Average precision by the rules of KITTI, over 40 or 11 recalls. With few objects it cannot \
                  reach 100 %: the ceiling is what a perfect detector would get.",
    },
    Term {
        word: "Region",
        meaning: "The pixels that the broken glass changes, grown by a few pixels. Each image has its own; the \
                  clean image is judged under the mask of its cracked twin.",
    },
    Term {
        word: "Coverage and τ",
        meaning: "Coverage is the share of a box that lies in the region. An object is in the region if its \
                  coverage is at least τ; the others are neither to be found nor errors there. A detection that \
                  matches no object counts as a false positive in the region only if its own coverage is at \
                  least τ.",
    },
    Term {
        word: "Out of region",
        meaning: "The control: objects with a coverage below τ. What changes there is not the crack in front of \
                  the object, but its surroundings, haze over the whole image, or chance.",
    },
    Term {
        word: "95 % interval",
        meaning: words::INTERVALS,
    },
    Term {
        word: "p and Holm",
        meaning: words::TESTS,
    },
    Term {
        word: "Failure rate",
        meaning: "Of the objects found in the clean image, the share that is not found in the cracked one. \
                  Recovered objects went the other way.",
    },
    Term {
        word: "New false positives",
        meaning: "Detections in the cracked image that match no label, and that no detection of the clean \
                  image overlaps by an IoU of 0.5 or more; per million pixels of the place. Something without a \
                  label, or with another one, may well be there.",
    },
    Term {
        word: "Kinds of errors (TIDE)",
        meaning: "What AP50 would gain if all errors of a kind were mended: wrong class in the right place, \
                  poor overlap, both, a second detection of the same object, a detection of nothing, an object \
                  missed. Mending one kind changes the others, so they do not add up. The AP50 that \
                  TIDE starts from is its own: a class without objects that is detected counts as 0 in the mean, \
                  and an image keeps its 100 best detections over all classes, not of each class. It is \
                  therefore mostly lower than the AP50 by the rules of MS-COCO.",
    },
    Term {
        word: "mPC and rPC",
        meaning: "Mean performance under corruption: AP of the cracked images, averaged over families, \
                  severities and seeds. rPC is its share of the clean AP. Their n is that of the different \
                  objects which some condition asks for.",
    },
    Term {
        word: "Lost, at risk, time to failure",
        meaning: "Of clips. An object is at risk if it is there when the damage comes and the clean clip shows it to \
                  the detector just then. It is lost at the first frame from which it is not found in so many of \
                  its frames in a row; the time from the damage to that frame is its time to failure. One that is never \
                  lost is counted for as long as it is there. The curve is the estimate of Kaplan and Meier with \
                  Greenwood's interval on the log-log scale; its median's interval ends where those of the curve \
                  pass one half. The clean clip, under the same rules, is the control: what is lost without damage.",
    },
    Term {
        word: "Flicker",
        meaning: "Of clips: from one frame of an object to its next, how often found turns to missed or back.",
    },
    Term {
        word: "Seeds",
        meaning: "A seed is one draw of cracks for all images. Of conditions that differ in their seed alone, AP \
                  is the mean over the seeds, and a share that of the objects of all seeds. With two or three \
                  seeds they say little of how draws of cracks differ.",
    },
    Term {
        word: "Refused numbers",
        meaning: "A dash with a letter stands where too few objects would make a number that looks like a \
                  finding and is none; the note below the table says why.",
    },
];

pub(super) fn section() -> Section {
    let terms = TERMS.iter().map(|term| Term {
        word: term.word,
        meaning: term.meaning,
    });
    Section {
        id: "meaning".to_owned(),
        title: "What the numbers mean".to_owned(),
        blocks: vec![Block::Terms {
            terms: terms.collect(),
        }],
    }
}
