//! Which detection is what kind of error, as tidecv decides it.

use super::{ErrorKind, TideSettings};
use crate::detections::{Detection, Detections};
use crate::labels::{LabelSet, Object, ObjectKind};

/// What became of all detections and objects.
#[derive(Debug, Default)]
pub(super) struct Classified {
    /// Detections that count, by image and score: category, score, whether right.
    pub(super) points: Vec<(u32, f64, bool)>,
    /// Errors, in the order of images and scores.
    pub(super) errors: Vec<ErrorItem>,
    /// Objects to be found, per category.
    pub(super) n_objects: Vec<u64>,
    /// Objects not found, per category.
    pub(super) n_missed: Vec<u64>,
}

/// An error.
#[derive(Debug, Clone, Copy)]
pub(super) struct ErrorItem {
    pub(super) kind: ErrorKind,
    /// The point in the curve as it is: category, score; `None` for what has none.
    pub(super) as_is: Option<(u32, f64)>,
    /// The true positive that it becomes when put right; `None` if it just goes.
    pub(super) fixed: Option<(u32, f64)>,
    /// The category that has one object less when put right.
    pub(super) missed: Option<u32>,
}

pub(super) fn classify(
    labels: &LabelSet,
    detections: &Detections,
    settings: TideSettings,
) -> Classified {
    let n_images = labels.images.len();
    let mut objects: Vec<Vec<&Object>> = vec![Vec::new(); n_images];
    let mut regions: Vec<Vec<&Object>> = vec![Vec::new(); n_images];
    let mut by_image: Vec<Vec<&Detection>> = vec![Vec::new(); n_images];
    let mut out = Classified {
        n_objects: vec![0; labels.categories.len()],
        n_missed: vec![0; labels.categories.len()],
        ..Classified::default()
    };
    for object in &labels.objects {
        if object.kind == ObjectKind::Regular {
            objects[object.image as usize].push(object);
            out.n_objects[object.category as usize] += 1;
        } else {
            regions[object.image as usize].push(object);
        }
    }
    for detection in &detections.items {
        by_image[detection.image as usize].push(detection);
    }
    for ((objects, regions), mut detections) in objects.iter().zip(&regions).zip(by_image) {
        detections.sort_by(|a, b| b.score.total_cmp(&a.score));
        detections.truncate(settings.max_detections as usize);
        let image = Image::matched(&detections, objects, regions, settings.found_iou);
        image.collect(settings, &mut out);
    }
    out
}

/// What became of a detection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    Right,
    Wrong,
    Ignored,
}

/// The detections and objects of an image.
struct Image<'a> {
    detections: &'a [&'a Detection],
    objects: &'a [&'a Object],
    /// Overlaps, a row per detection.
    iou: Vec<f64>,
    state: Vec<State>,
    is_found: Vec<bool>,
}

impl<'a> Image<'a> {
    /// By falling score, each detection takes the object of its class that it overlaps most among
    /// those that are left.
    fn matched(
        detections: &'a [&'a Detection],
        objects: &'a [&'a Object],
        regions: &[&Object],
        found_iou: f64,
    ) -> Self {
        let mut image = Self {
            detections,
            objects,
            iou: detections
                .iter()
                .flat_map(|it| objects.iter().map(|object| it.box_px.iou(&object.box_px)))
                .collect(),
            state: vec![State::Wrong; detections.len()],
            is_found: vec![false; objects.len()],
        };
        for (k, detection) in detections.iter().enumerate() {
            // What is taken overlaps by 0 from then on.
            let left = |g: usize| {
                let is_left = objects[g].category == detection.category && !image.is_found[g];
                if is_left { image.iou(k, g) } else { 0.0 }
            };
            if let Some((g, iou)) = greatest(objects.len(), left)
                && iou >= found_iou
            {
                image.state[k] = State::Right;
                image.is_found[g] = true;
            }
        }
        for region in regions {
            for (detection, state) in detections.iter().zip(&mut image.state) {
                if *state == State::Wrong
                    && region.category == detection.category
                    && share_inside(detection, region) > found_iou
                {
                    *state = State::Ignored;
                }
            }
        }
        image
    }

    fn iou(&self, detection: usize, object: usize) -> f64 {
        self.iou[detection * self.objects.len() + object]
    }

    fn collect(&self, settings: TideSettings, out: &mut Classified) {
        // The detection that would find an object, if put right: the first of the highest score.
        let mut heir: Vec<Option<usize>> = vec![None; self.objects.len()];
        let mut kinds = Vec::new();
        for (k, (detection, state)) in self.detections.iter().zip(&self.state).enumerate() {
            let is_right = *state == State::Right;
            if *state != State::Ignored {
                let point = (detection.category, detection.score, is_right);
                out.points.push(point);
            }
            if is_right {
                continue;
            }
            let (kind, object) = self.kind(k, settings);
            let object = object.filter(|g| !self.is_found[*g]);
            if let Some(g) = object {
                let slot = &mut heir[g];
                // They come by falling score.
                *slot = slot.or(Some(k));
            }
            kinds.push((k, kind, object));
        }
        for (k, kind, object) in kinds {
            let detection = self.detections[k];
            let heir = object.filter(|g| heir[*g] == Some(k));
            out.errors.push(ErrorItem {
                kind,
                as_is: (self.state[k] == State::Wrong)
                    .then_some((detection.category, detection.score)),
                fixed: heir.map(|g| match kind {
                    ErrorKind::Cls => (self.objects[g].category, detection.score),
                    _ => (detection.category, detection.score),
                }),
                missed: None,
            });
        }
        for ((object, is_found), heir) in self.objects.iter().zip(&self.is_found).zip(&heir) {
            if *is_found {
                continue;
            }
            out.n_missed[object.category as usize] += 1;
            if heir.is_none() {
                out.errors.push(ErrorItem {
                    kind: ErrorKind::Miss,
                    as_is: None,
                    fixed: None,
                    missed: Some(object.category),
                });
            }
        }
    }

    /// The kind of an error, and the object that it would find if put right.
    fn kind(&self, k: usize, settings: TideSettings) -> (ErrorKind, Option<usize>) {
        let category = self.detections[k].category;
        let is_same = |g: usize| self.objects[g].category == category;
        let only = |holds: &dyn Fn(usize) -> bool| {
            greatest(self.objects.len(), |g| {
                if holds(g) { self.iou(k, g) } else { 0.0 }
            })
        };
        let Some((nearest, iou)) = only(&is_same) else {
            return (ErrorKind::Bkg, None);
        };
        if settings.background_iou <= iou && iou <= settings.found_iou {
            return (ErrorKind::Loc, Some(nearest));
        }
        if let Some((other, iou)) = only(&|g| !is_same(g))
            && iou >= settings.found_iou
        {
            return (ErrorKind::Cls, Some(other));
        }
        let (found, any) = (only(&|g| is_same(g) && self.is_found[g]), only(&|_| true));
        if found.is_some_and(|(_, iou)| iou >= settings.found_iou) {
            (ErrorKind::Dupe, None)
        } else if any.is_some_and(|(_, iou)| iou <= settings.background_iou) {
            (ErrorKind::Bkg, None)
        } else {
            (ErrorKind::Both, None)
        }
    }
}

/// The first place with the greatest value.
fn greatest(n: usize, value: impl Fn(usize) -> f64) -> Option<(usize, f64)> {
    (0..n)
        .map(|g| (g, value(g)))
        .reduce(|best, it| if it.1 > best.1 { it } else { best })
}

/// Share of a detection's area inside a region, as for crowds in the COCO API.
fn share_inside(detection: &Detection, region: &Object) -> f64 {
    let inside = detection.box_px.intersection_px2(&region.box_px);
    if inside > 0.0 {
        inside / detection.box_px.area_px2()
    } else {
        0.0
    }
}
