//! The record of what was done to a bag, which it carries as metadata.

use std::collections::BTreeMap;

use mcap::records::Metadata;
use serde_json::{Value, json};

use super::damage::Damage;
use super::{Bag, CameraReport};
use crate::clip::{Growth, Light};

/// Name and version of the record.
pub const BAG_SCHEMA: &str = "starbreak.bag/1";

/// Texts by name, `cameras` and `growth` as JSON: for each camera its recipe, its seeds and what came of it.
pub(super) fn provenance(bag: &Bag, reports: &[CameraReport], damage: Option<&Damage>) -> Metadata {
    let cameras: Vec<Value> = (bag.cameras.iter().zip(reports))
        .map(|(camera, report)| {
            let place = |place: Option<(u64, f64)>| {
                place.map(|(idx, time_s)| json!({ "frame_idx": idx, "time_s": time_s }))
            };
            json!({
                "topic": camera.topic,
                "recipe": camera.context.recipe,
                "recipe_sha256": camera.context.recipe_sha256,
                "seed": camera.context.seed.0,
                "item": { "name": report.name, "sample_index": 0, "seed": report.seed },
                "sizes_px": report.sizes,
                "frame_s": camera.frame_s,
                "n_frames": report.n_frames,
                "n_altered": report.n_altered,
                "damage_onset": place(report.damage_onset),
                "first_visible": place(report.first_visible),
                "added": camera.added.iter().map(|added| added.topic(&camera.topic)).collect::<Vec<_>>(),
            })
        })
        .collect();
    let (mode, time_s) = match bag.request.growth {
        Growth::Whole => ("whole", None),
        Growth::OwnSpeed => ("own_speed", None),
        Growth::Stretched { time_s } => ("stretched", Some(time_s)),
    };
    let impact_at_s = bag.cameras.iter().map(|camera| camera.impact_at_s);
    let impact_at_s = impact_at_s.reduce(f64::max).unwrap_or(0.0);
    let first_ns = bag
        .cameras
        .first()
        .map_or(0, |camera| camera.clock.first_ns);
    let mut texts = BTreeMap::from_iter(
        [
            ("schema", BAG_SCHEMA.to_owned()),
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
            ("cameras", Value::from(cameras).to_string()),
            ("first_stamp_ns", first_ns.to_string()),
            ("impact_at_s", impact_at_s.to_string()),
            (
                "growth",
                json!({ "mode": mode, "time_s": time_s }).to_string(),
            ),
            (
                "light",
                match bag.request.light {
                    Light::First => "first",
                    Light::Follow => "follow",
                }
                .to_owned(),
            ),
        ]
        .map(|(key, text)| (key.to_owned(), text)),
    );
    if let Some(damage) = damage {
        texts.insert("input_damage".to_owned(), damage.to_json().to_string());
    }
    Metadata {
        name: "starbreak".to_owned(),
        metadata: texts,
    }
}
