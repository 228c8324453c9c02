//! What must hold for every input of a parser: it never panics, and what it accepts survives
//! being written and read again.
//!
//! One function per target. Each returns for an input that behaves, and panics for a finding;
//! libFuzzer and the test `replay` call the same functions.
#![forbid(unsafe_code)]

mod bag;
mod bank;
mod image;
mod labels;
mod model;
mod mutation;
mod network;
mod recipe;
mod source;
mod svg;

pub use bag::{bag, message};
pub use bank::{bank, coverage, pattern};
pub use image::image;
pub use labels::{labels, timeline};
pub use model::model;
pub use mutation::{Mutator, Vocabulary};
pub use network::network;
pub use recipe::recipe;
pub use source::source;
pub use svg::svg;

/// A fuzz target: its name is the name of its corpus folder.
#[derive(Clone, Copy)]
pub struct Target {
    /// Name of the target and of its folder in `corpus/`.
    pub name: &'static str,
    /// Panics if the input is a finding.
    pub check: fn(&[u8]),
    /// Words that a mutation may write into an input.
    pub vocabulary: Vocabulary,
    /// Mutations that a replay tries: about two seconds' worth.
    pub n_mutations: usize,
}

/// All targets.
pub const TARGETS: [Target; 13] = [
    Target {
        name: "bag",
        check: bag,
        vocabulary: bag::VOCABULARY,
        n_mutations: 1000,
    },
    Target {
        name: "bank",
        check: bank,
        vocabulary: bank::VOCABULARY,
        n_mutations: 10_000,
    },
    Target {
        name: "coverage",
        check: coverage,
        vocabulary: bank::VOCABULARY,
        n_mutations: 10_000,
    },
    Target {
        name: "pattern",
        check: pattern,
        vocabulary: bank::VOCABULARY,
        n_mutations: 4000,
    },
    Target {
        name: "image",
        check: image,
        vocabulary: image::VOCABULARY,
        n_mutations: 20_000,
    },
    Target {
        name: "labels",
        check: labels,
        vocabulary: labels::VOCABULARY,
        n_mutations: 10_000,
    },
    Target {
        name: "message",
        check: message,
        vocabulary: bag::VOCABULARY,
        n_mutations: 50_000,
    },
    Target {
        name: "model",
        check: model,
        vocabulary: model::VOCABULARY,
        n_mutations: 20_000,
    },
    Target {
        name: "timeline",
        check: timeline,
        vocabulary: labels::VOCABULARY,
        n_mutations: 10_000,
    },
    Target {
        name: "recipe",
        check: recipe,
        vocabulary: recipe::VOCABULARY,
        n_mutations: 4000,
    },
    Target {
        name: "network",
        check: network,
        vocabulary: network::VOCABULARY,
        n_mutations: 100_000,
    },
    Target {
        name: "svg",
        check: svg,
        vocabulary: svg::VOCABULARY,
        n_mutations: 100_000,
    },
    Target {
        name: "source",
        check: source,
        vocabulary: source::VOCABULARY,
        n_mutations: 1000,
    },
];
