//! What the crack did to each labeled object.

use image::DynamicImage;
use serde_json::{Value, json};
use starbreak_dataset::LabeledObject;
use starbreak_optics::Before;

use crate::Settings;
use crate::pipeline::{Shown, damage_reader, damage_to_json};

/// One entry per object, in the order of the labels.
pub(super) fn damage_of(
    objects: &[LabeledObject],
    images: (&Before, &DynamicImage),
    shown: &Shown,
    settings: &Settings,
) -> Vec<Value> {
    let Some(reader) = damage_reader(images, shown, settings) else {
        return Vec::new();
    };
    objects
        .iter()
        .map(|object| {
            let mut entry = json!({
                "record": object.record,
                "category": object.category,
                "kind": object.kind.name(),
                "box_px": object.box_px,
            });
            // A box without a pixel of the frame has none.
            entry["damage"] = reader
                .in_box(object.box_px)
                .map_or(Value::Null, |damage| damage_to_json(&damage));
            entry
        })
        .collect()
}
