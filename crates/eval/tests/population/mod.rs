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
use starbreak_eval::{ImageMatches, MatchedDetection, MatchedObject, Outcome};

/// Classes, the first of them the commonest.
pub(crate) const N_CATEGORIES: u32 = 20;

/// An image of the population.
pub(crate) struct Image {
    objects: Vec<Object>,
    /// Per version, the clean one first: class and score of what is nothing.
    false_positives: Vec<Vec<(u32, f64)>>,
}

struct Object {
    category: u32,
    /// Share that the region covers.
    coverage: f64,
    /// Per version, the clean one first: the score, if it is found.
    scores: Vec<Option<f64>>,
}

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
            objects.push(Object {
                category,
                coverage,
                scores: scores.collect(),
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
            (category, logistic(-1.0 + 0.8 * hardness + stream.normal()))
        };
        (0..n).map(|_| one(&mut stream)).collect()
    });
    Image {
        false_positives: false_positives.collect(),
        objects,
    }
}

/// The matches of one version of the images, 0 the clean one, of all objects.
pub(crate) fn matches(images: &[Image], version: usize) -> Vec<ImageMatches> {
    let mut all = Vec::new();
    let mut n_objects = 0_u32;
    for (place, image) in (0..).zip(images) {
        let mut by_category = BTreeMap::<u32, ImageMatches>::new();
        let empty = |category: u32| ImageMatches {
            image: place,
            category,
            detections: Vec::new(),
            objects: Vec::new(),
        };
        for object in &image.objects {
            let category = object.category;
            let item = by_category
                .entry(category)
                .or_insert_with(|| empty(category));
            item.objects.push(MatchedObject {
                object: n_objects,
                is_ignored: false,
                detection: None,
            });
            if let Some(score) = object.scores[version] {
                item.detections.push(MatchedDetection {
                    detection: 0,
                    score,
                    outcome: Outcome::TruePositive {
                        object: n_objects,
                        iou: 0.8,
                    },
                });
            }
            n_objects += 1;
        }
        for (category, score) in &image.false_positives[version] {
            let item = by_category
                .entry(*category)
                .or_insert_with(|| empty(*category));
            item.detections.push(MatchedDetection {
                detection: 0,
                score: *score,
                outcome: Outcome::FalsePositive,
            });
        }
        for item in by_category.values_mut() {
            item.detections.sort_by(|a, b| b.score.total_cmp(&a.score));
        }
        all.extend(by_category.into_values());
    }
    all
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
