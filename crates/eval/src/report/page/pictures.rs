//! The worst failures as pairs of pictures with boxes.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;

use super::super::words;
use super::Block;
use crate::evaluation::{BoxRole, Evaluation, RoledBox, Study, WorstFailure};

/// Most boxes that are drawn over a picture.
const MAX_BOXES: usize = 60;

/// What the boxes are.
const BOXES: &str = "The images with the most lost objects, clean and damaged. Lost objects count wherever they are; the \
     caption says how much of each the region covers. Solid boxes: found in both images. Thick boxes with a dark edge: \
     lost. Dashed boxes: found in neither. Dotted boxes: new false positives, that is, detections that match no label \
     and that no clean detection overlaps.";

/// Width of a bold letter, at most and on average, as a share of its height.
const LETTER_WIDTH: f64 = 0.62;

/// A pair of pictures.
#[derive(Debug, Serialize)]
pub(in crate::report) struct Pair {
    id: String,
    image: String,
    text: String,
    width_px: u32,
    height_px: u32,
    /// How wide a stroke is so that it looks the same on every image, px of the image.
    stroke_px: f64,
    letter_px: f64,
    sides: Vec<Side>,
}

/// One of both.
#[derive(Debug, Serialize)]
pub(in crate::report) struct Side {
    /// What ids are made with.
    name: &'static str,
    /// What a reader sees.
    label: &'static str,
    uri: String,
    boxes: Vec<Drawn>,
}

/// A box as it is drawn.
#[derive(Debug, Serialize)]
pub(in crate::report) struct Drawn {
    role: &'static str,
    x: f64,
    y: f64,
    width: f64,
    height: f64,
    text: String,
    text_x: f64,
    text_y: f64,
}

pub(super) fn blocks(study: &Study, evaluation: &Evaluation, id: &str) -> Vec<Block> {
    let tau = study.provenance.settings.tau;
    let pairs: Vec<Pair> = evaluation
        .worst
        .iter()
        .enumerate()
        .filter_map(|(place, worst)| pair(worst, tau, format!("{id}-worst{place}")))
        .collect();
    if pairs.is_empty() {
        return Vec::new();
    }
    vec![
        Block::heading(format!("{id}-worst"), "Worst failures".to_owned()),
        Block::text(BOXES),
        Block::Pictures { pairs },
    ]
}

/// So many pairs stand at the beginning.
const N_EXAMPLES: usize = 3;

/// The images with the most lost objects of all conditions, each image once.
pub(super) fn examples(study: &Study) -> Vec<Block> {
    if study.evaluations.len() < 2 {
        return Vec::new();
    }
    let mut all: Vec<(&Evaluation, &WorstFailure)> = study
        .evaluations
        .iter()
        .flat_map(|one| one.worst.iter().map(move |worst| (one, worst)))
        .filter(|(_, worst)| worst.n_lost > 0)
        .collect();
    all.sort_by_key(|(_, worst)| std::cmp::Reverse(worst.n_lost));
    let tau = study.provenance.settings.tau;
    let mut shown: Vec<&str> = Vec::new();
    let mut pairs = Vec::new();
    for (one, worst) in all {
        if pairs.len() == N_EXAMPLES || shown.contains(&worst.image.as_str()) {
            continue;
        }
        let id = format!("example{}", pairs.len());
        if let Some(mut pair) = pair(worst, tau, id) {
            shown.push(&worst.image);
            let who = words::name(&format!("{}, {}", one.detector, one.condition.name));
            pair.text = format!("{who}: {}", pair.text);
            pairs.push(pair);
        }
    }
    if pairs.is_empty() {
        return Vec::new();
    }
    vec![
        Block::heading("examples".to_owned(), "Examples".to_owned()),
        Block::text(BOXES),
        Block::Pictures { pairs },
    ]
}

fn pair(worst: &WorstFailure, tau: Option<f64>, id: String) -> Option<Pair> {
    let pictures = worst.pictures.as_ref()?;
    let (width, height) = (f64::from(worst.width_px), f64::from(worst.height_px));
    if width < 1.0 || height < 1.0 {
        return None;
    }
    let letter_px = width.max(height) / 36.0;
    let drawn = |on_cracked: bool| {
        let is_here = |one: &&RoledBox| on_cracked || one.role != BoxRole::New;
        let boxes = worst.boxes.iter().filter(is_here).take(MAX_BOXES);
        boxes
            .map(|one| draw(one, on_cracked, tau, (width, height), letter_px))
            .collect()
    };
    let uri = |jpeg: &[u8]| format!("data:image/jpeg;base64,{}", STANDARD.encode(jpeg));
    Some(Pair {
        image: words::name(&worst.image),
        text: format!(
            "{} of {} found objects lost, {} new false positives{}",
            worst.n_lost,
            worst.n_found_clean,
            worst.n_new,
            lost_objects(worst, tau)
        ),
        width_px: worst.width_px,
        height_px: worst.height_px,
        stroke_px: width.max(height) / 320.0,
        letter_px,
        sides: vec![
            Side {
                name: "clean",
                label: "clean",
                uri: uri(&pictures.clean_jpeg),
                boxes: drawn(false),
            },
            Side {
                name: "cracked",
                label: "damaged",
                uri: uri(&pictures.cracked_jpeg),
                boxes: drawn(true),
            },
        ],
        id,
    })
}

/// The lost objects with the share of each that the region covers, most covered first.
fn lost_objects(worst: &WorstFailure, tau: Option<f64>) -> String {
    let mut lost: Vec<(f64, &RoledBox)> = worst
        .boxes
        .iter()
        .filter(|one| one.role == BoxRole::Lost)
        .filter_map(|one| Some((one.coverage?, one)))
        .collect();
    if lost.is_empty() || tau.is_none() {
        return String::new();
    }
    lost.sort_by(|a, b| b.0.total_cmp(&a.0));
    let texts: Vec<String> = lost
        .iter()
        .map(|(coverage, one)| {
            let outside = match is_outside(one, tau) {
                true => ", outside the region",
                false => "",
            };
            let class = words::name(&one.class);
            format!("{class} ({} %{outside})", words::percent(*coverage))
        })
        .collect();
    format!(". Lost objects and their coverage: {}", texts.join(", "))
}

/// Whether the region leaves an object out, so that its loss has another cause than the glass in front.
fn is_outside(one: &RoledBox, tau: Option<f64>) -> bool {
    match (one.coverage, tau) {
        (Some(coverage), Some(tau)) if tau > 0.0 => coverage < tau,
        (Some(coverage), Some(_)) => coverage <= 0.0,
        _ => false,
    }
}

fn draw(
    one: &RoledBox,
    on_cracked: bool,
    tau: Option<f64>,
    (width, height): (f64, f64),
    letter_px: f64,
) -> Drawn {
    let role = match (one.role, on_cracked) {
        (BoxRole::Missed, _) => "missed",
        (BoxRole::Lost, true) => "lost",
        (BoxRole::Found | BoxRole::Lost, _) => "found",
        (BoxRole::New, _) => "new",
    };
    // A box from outside may be anywhere, and be no number.
    let inside = |value: f64, end: f64| match value.is_finite() {
        true => (value.clamp(0.0, end) * 10.0).round() / 10.0,
        false => 0.0,
    };
    let [x0, y0, x1, y1] = one.box_px.corners();
    let (x, y) = (inside(x0, width), inside(y0, height));
    let class = words::name(&one.class);
    let score = one.score.filter(|score| score.is_finite());
    let text = match (role, score) {
        ("lost", _) if is_outside(one, tau) => format!("{class} lost, outside"),
        ("lost", _) => format!("{class} lost"),
        ("new", Some(score)) => format!("{class} new {score:.2}"),
        ("new", None) => format!("{class} new"),
        ("found", Some(score)) => format!("{class} {score:.2}"),
        _ => class,
    };
    // Long words begin further left, so that they end inside.
    let n_letters = f64::from(u32::try_from(text.chars().count()).unwrap_or(u32::MAX));
    let room = (width - n_letters * letter_px * LETTER_WIDTH).max(0.0);
    Drawn {
        role,
        text_x: (x.min(room) * 10.0).round() / 10.0,
        x,
        y,
        width: (inside(x1, width) - x).max(0.0),
        height: (inside(y1, height) - y).max(0.0),
        text,
        text_y: (y - 0.25 * letter_px).max(letter_px),
    }
}
