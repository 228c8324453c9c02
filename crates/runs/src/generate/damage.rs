//! What the damage did to each labeled object.

use serde_json::{Value, json};
use starbreak::damage_to_json;
use starbreak_dataset::LabeledObject;
use starbreak_optics::Damage;

/// One entry per object, in the order of the labels, from the damage in its box.
pub(super) fn damage_of(objects: &[LabeledObject], damage: &[Option<Damage>]) -> Vec<Value> {
    let entry = |(object, damage): (&LabeledObject, &Option<Damage>)| {
        json!({
            "record": object.record,
            "category": object.category,
            "kind": object.kind.name(),
            "box_px": object.box_px,
            // A box without a pixel of the frame has none.
            "damage": damage.as_ref().map(damage_to_json),
        })
    };
    objects.iter().zip(damage).map(entry).collect()
}
