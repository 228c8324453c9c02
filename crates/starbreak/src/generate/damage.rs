//! What the crack did to each labeled object.

use image::DynamicImage;
use serde_json::{Value, json};
use starbreak_dataset::{LabeledObject, ObjectKind};
use starbreak_optics::DamageReader;

use crate::pipeline::Shown;
use crate::{OpticsSettings, Settings};

/// One entry per object, in the order of the labels.
pub(super) fn damage_of(
    objects: &[LabeledObject],
    images: [&DynamicImage; 2],
    shown: &Shown,
    settings: &Settings,
) -> Vec<Value> {
    let region = &shown.region;
    let reader = match (&shown.overlay, &settings.optics) {
        (Some(overlay), _) => DamageReader::of_overlay(images, region, overlay),
        (None, OpticsSettings::Paper(optics)) => DamageReader::of_paper(images, region, optics),
        // The physical optics leave an overlay.
        (None, OpticsSettings::Physical(_)) => return Vec::new(),
    };
    objects
        .iter()
        .map(|object| {
            let mut entry = json!({
                "record": object.record,
                "category": object.category,
                "kind": match object.kind {
                    ObjectKind::Regular => "regular",
                    ObjectKind::Crowd => "crowd",
                    ObjectKind::Ignored => "ignored",
                },
                "box_px": object.box_px,
            });
            // A box without a pixel of the frame has none.
            entry["damage"] = reader.in_box(object.box_px).map_or(Value::Null, |damage| {
                json!({
                    "region_share": rounded(damage.region_share),
                    "displacement_px": rounded(damage.displacement_px),
                    "blur_radius_px": rounded(damage.blur_radius_px),
                    "contrast_lost": damage.contrast_lost.map(rounded),
                })
            });
            entry
        })
        .collect()
}

/// To six decimals, which is more than is known.
fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}
