//! A made-up population of images with detections, clean and damaged, whose full value is the truth
//! that intervals of samples are held against.
//!
//! Images differ in how hard they are, in which few of many classes they show, and in how strongly
//! the damage hits them, so that objects of one image are alike: what statistics that take objects as
//! independent get wrong. Without an effect, clean and damaged versions are draws of the same law.

pub(crate) mod cells;

use std::collections::BTreeMap;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use starbreak_eval::failure::{Found, ObjectPair};
use starbreak_eval::{
    BoxPx, Category, Detection, Detections, ImageMatches, LabelSet, LabeledImage, MatchedDetection,
    MatchedObject, Object, ObjectKind, Outcome,
};

/// Classes, the first of them the commonest.
pub(crate) const N_CATEGORIES: u32 = 20;

/// An image of the population.
pub(crate) struct Image {
    objects: Vec<Shown>,
    /// Share of the image that the region takes.
    region: f64,
    /// Per version, the clean one first: what is nothing.
    false_positives: Vec<Vec<Phantom>>,
}

/// An object.
struct Shown {
    category: u32,
    /// Share that the region covers.
    coverage: f64,
    /// Per version, the clean one first: the score, if it is found.
    scores: Vec<Option<f64>>,
    /// Per version: the class that it is taken for where it is not found, and the score.
    taken_for: Vec<Option<(u32, f64)>>,
}

/// A detection of nothing.
struct Phantom {
    category: u32,
    score: f64,
    /// Which of the places it is at, where clean and damaged versions may see the same.
    place: u32,
    /// Share that the region covers.
    coverage: f64,
}

/// Side of an image and of what it shows, px.
const IMAGE_PX: u32 = 1000;
const SHOWN_PX: f64 = 20.0;
/// Places of phantoms in an image.
const N_PLACES: u32 = 12;

/// How images are made.
#[derive(Clone, Copy)]
pub(crate) struct Law {
    /// How much the damage lowers what a detector sees of a covered object; 0 is the null.
    pub(crate) effect: f64,
    /// Damaged versions of each image.
    pub(crate) n_seeds: usize,
    /// Images that follow each other in one drive, alike in how hard they are and in the damage; 1 for none.
    pub(crate) drive: u64,
}

/// The image of a number under a law: always the same.
pub(crate) fn image(law: Law, number: u64) -> Image {
    let mut stream = Stream(ChaCha8Rng::seed_from_u64(number));
    let mut drive = Stream(ChaCha8Rng::seed_from_u64(!(number / law.drive)));
    let of_drive = match law.drive {
        1 => 0.0,
        _ => 0.6 * drive.normal(),
    };
    let hardness = of_drive + 0.8 * stream.normal();
    let region = 0.1 + 0.8 * stream.unit();
    let damage = |stream: &mut Stream, drive: &mut Stream| match law.drive {
        1 => stream.exponential(),
        _ => 0.5 * (stream.exponential() + drive.exponential()),
    };
    let damage: Vec<f64> = (0..law.n_seeds)
        .map(|_| damage(&mut stream, &mut drive))
        .collect();
    let mut objects = Vec::new();
    let mut shown = Vec::new();
    for _ in 0..1 + stream.below(3) {
        let category = stream.category();
        shown.push(category);
        for _ in 0..1 + stream.poisson(1.5) {
            let difficulty = hardness + stream.normal();
            let is_covered = stream.unit() < region;
            let coverage = if is_covered {
                0.1 + 0.9 * stream.unit()
            } else {
                0.0
            };
            let scores = (0..=law.n_seeds).map(|version| {
                let lost = match version.checked_sub(1) {
                    Some(seed) if is_covered => law.effect * damage[seed] * coverage,
                    _ => 0.0,
                };
                let seen = 1.0 - difficulty + 0.7 * stream.normal() - lost;
                (seen > 0.0).then(|| logistic(1.5 * seen - 1.0))
            });
            let scores: Vec<Option<f64>> = scores.collect();
            let taken = |found: &Option<f64>| {
                let (chance, other) = (stream.unit(), 1 + stream.below(N_CATEGORIES - 1));
                let score = logistic(stream.normal());
                let other = (category + other) % N_CATEGORIES;
                (found.is_none() && chance < 0.4).then_some((other, score))
            };
            let taken_for = scores.iter().map(taken).collect();
            objects.push(Shown {
                category,
                coverage,
                scores,
                taken_for,
            });
        }
    }
    // What is nothing is taken mostly for what is there.
    let false_positives = (0..=law.n_seeds).map(|_| {
        let n = stream.poisson(4.0);
        let one = |stream: &mut Stream| {
            let category = match stream.below(2) {
                0 => stream.category(),
                _ => shown[stream.below(u32::try_from(shown.len()).unwrap_or(1)) as usize],
            };
            let score = logistic(-1.0 + 0.8 * hardness + stream.normal());
            let place = stream.below(N_PLACES);
            let is_covered = stream.unit() < region;
            Phantom {
                category,
                score,
                place,
                coverage: f64::from(u8::from(is_covered)),
            }
        };
        (0..n).map(|_| one(&mut stream)).collect()
    });
    Image {
        false_positives: false_positives.collect(),
        region,
        objects,
    }
}

/// What was found in one version of the images, 0 the clean one.
pub(crate) struct FoundSet {
    /// Of all objects.
    pub(crate) matches: Vec<ImageMatches>,
    pub(crate) detections: Detections,
    /// Share of each detection that the region covers.
    pub(crate) coverage: Vec<f64>,
}

impl FoundSet {
    fn add(&mut self, image: u32, category: u32, score: f64, box_px: BoxPx, coverage: f64) -> u32 {
        self.detections.items.push(Detection {
            image,
            category,
            box_px,
            score,
        });
        self.coverage.push(coverage);
        u32::try_from(self.coverage.len() - 1).unwrap_or(u32::MAX)
    }
}

/// The matches of one version of the images, 0 the clean one, of all objects.
pub(crate) fn matches(images: &[Image], version: usize) -> Vec<ImageMatches> {
    found_set(images, version).matches
}

/// What was found in one version of the images, 0 the clean one.
pub(crate) fn found_set(images: &[Image], version: usize) -> FoundSet {
    let mut set = FoundSet {
        matches: Vec::new(),
        detections: Detections::default(),
        coverage: Vec::new(),
    };
    let mut n_objects = 0_u32;
    for (place, image) in (0..).zip(images) {
        let mut by_category = BTreeMap::<u32, ImageMatches>::new();
        let empty = |category: u32| ImageMatches {
            image: place,
            category,
            detections: Vec::new(),
            objects: Vec::new(),
        };
        let mut found = |category: u32, detection: u32, score: f64, outcome: Outcome| {
            let item = by_category.entry(category);
            item.or_insert_with(|| empty(category))
                .detections
                .push(MatchedDetection {
                    detection,
                    score,
                    outcome,
                });
        };
        let mut objects = Vec::new();
        for (at, object) in (0..).zip(&image.objects) {
            let (category, coverage) = (object.category, object.coverage);
            objects.push((category, n_objects));
            if let Some(score) = object.scores[version] {
                let idx = set.add(place, category, score, box_of_object(at), coverage);
                let outcome = Outcome::TruePositive {
                    object: n_objects,
                    iou: 0.8,
                };
                found(category, idx, score, outcome);
            }
            if let Some((other, score)) = object.taken_for[version] {
                let idx = set.add(place, other, score, box_of_object(at), coverage);
                found(other, idx, score, Outcome::FalsePositive);
            }
            n_objects += 1;
        }
        for phantom in &image.false_positives[version] {
            let box_px = box_at(phantom.place, 500.0);
            let (category, score) = (phantom.category, phantom.score);
            let idx = set.add(place, category, score, box_px, phantom.coverage);
            found(category, idx, score, Outcome::FalsePositive);
        }
        for (category, object) in objects {
            let item = by_category.entry(category);
            item.or_insert_with(|| empty(category))
                .objects
                .push(MatchedObject {
                    object,
                    is_ignored: false,
                    detection: None,
                });
        }
        for item in by_category.values_mut() {
            item.detections.sort_by(|a, b| b.score.total_cmp(&a.score));
        }
        set.matches.extend(by_category.into_values());
    }
    set
}

fn box_of_object(at: u32) -> BoxPx {
    box_at(at, 0.0)
}

fn box_at(at: u32, y: f64) -> BoxPx {
    let x = 1.5 * SHOWN_PX * f64::from(at);
    BoxPx::from_corners([x, y, x + SHOWN_PX, y + SHOWN_PX])
}

/// The labels of the images.
pub(crate) fn labels(images: &[Image]) -> LabelSet {
    let mut labels = LabelSet::default();
    for category in 0..N_CATEGORIES {
        labels.categories.push(Category {
            id: category.into(),
            name: category.to_string(),
            supercategory: None,
        });
    }
    for (place, image) in (0_u32..).zip(images) {
        labels.images.push(LabeledImage {
            id: place.into(),
            name: place.to_string(),
            width_px: Some(IMAGE_PX),
            height_px: Some(IMAGE_PX),
            cluster: None,
        });
        for (at, object) in (0..).zip(&image.objects) {
            labels.objects.push(Object {
                id: i64::try_from(labels.objects.len()).unwrap_or(i64::MAX),
                image: place,
                category: object.category,
                box_px: box_of_object(at),
                area_px2: SHOWN_PX * SHOWN_PX,
                kind: ObjectKind::Regular,
            });
        }
    }
    labels
}

/// Areas of region and of image, px, of each image.
pub(crate) fn areas_px(images: &[Image]) -> (Vec<f64>, Vec<f64>) {
    let all = f64::from(IMAGE_PX * IMAGE_PX);
    let regions = images.iter().map(|image| image.region * all).collect();
    (regions, vec![all; images.len()])
}

/// What became of each object in the clean images and in those of a seed, at a score.
pub(crate) fn pairs(images: &[Image], seed: usize, score: f64) -> Vec<ObjectPair> {
    let mut all = Vec::new();
    for (place, image) in (0..).zip(images) {
        for object in &image.objects {
            let found = |version: usize| {
                object.scores[version]
                    .filter(|it| *it >= score)
                    .map(|score| Found {
                        detection: 0,
                        score,
                        iou: 0.5 + 0.5 * score,
                    })
            };
            all.push(ObjectPair {
                object: u32::try_from(all.len()).unwrap_or(u32::MAX),
                image: place,
                category: object.category,
                coverage: object.coverage,
                clean: found(0),
                cracked: found(seed + 1),
            });
        }
    }
    all
}

struct Stream(ChaCha8Rng);

impl Stream {
    fn unit(&mut self) -> f64 {
        (f64::from(self.0.next_u32()) + 0.5) / 4_294_967_296.0
    }

    fn below(&mut self, n: u32) -> u32 {
        ((u64::from(self.0.next_u32()) * u64::from(n)) >> 32) as u32
    }

    /// By the method of Box and Muller, half of which is thrown away.
    fn normal(&mut self) -> f64 {
        let radius = libm::sqrt(-2.0 * libm::log(self.unit()));
        radius * libm::cos(std::f64::consts::TAU * self.unit())
    }

    fn exponential(&mut self) -> f64 {
        -libm::log(self.unit())
    }

    fn poisson(&mut self, mean: f64) -> u32 {
        let least = libm::exp(-mean);
        let (mut product, mut n) = (self.unit(), 0);
        while product > least {
            product *= self.unit();
            n += 1;
        }
        n
    }

    /// With a long tail of rare ones, as in photographs: the k-th with a weight of 1/k.
    fn category(&mut self) -> u32 {
        let total: f64 = (1..=N_CATEGORIES).map(|k| 1.0 / f64::from(k)).sum();
        let mut left = self.unit() * total;
        (0..N_CATEGORIES - 1)
            .find(|k| {
                left -= 1.0 / f64::from(k + 1);
                left < 0.0
            })
            .unwrap_or(N_CATEGORIES - 1)
    }
}

fn logistic(x: f64) -> f64 {
    1.0 / (1.0 + libm::exp(-x))
}
