//! What the cracks did to each object, as the generated set has recorded it.

use std::path::Path;

use serde::Deserialize;
use starbreak_dataset::{DatasetError, MAX_ITEM_BYTES, read_text};

use crate::{BoxPx, EvalError, KittiLabels, LabelSet};

/// How far a box of a record may lie from that of its label, px: BDD100K's convention makes boxes one
/// pixel wider.
const SAME_BOX_PX: f64 = 1.5;

/// Damage to each object, in the order of [`LabelSet::objects`]; NaN where it is not recorded.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DamageFacts {
    /// Mean displacement of the scene's light, px.
    pub displacement_px: Vec<f64>,
    /// Radius of the disc that a point of the scene became, px.
    pub blur_radius_px: Vec<f64>,
    /// Share of the contrast that is lost; 1 is all of it.
    pub contrast_lost: Vec<f64>,
    /// Images without a record.
    pub n_images_without: u64,
}

#[derive(Deserialize)]
struct Record {
    #[serde(default)]
    objects: Vec<RecordedObject>,
}

#[derive(Deserialize)]
struct RecordedObject {
    #[serde(default)]
    record: String,
    category: String,
    box_px: [f64; 4],
    damage: Option<Damage>,
}

#[derive(Deserialize)]
struct Damage {
    displacement_px: Option<f64>,
    blur_radius_px: Option<f64>,
    contrast_lost: Option<f64>,
}

impl DamageFacts {
    /// The facts in a folder of records `STEM.json`, one per image `STEM.*`, as `generate` writes them
    /// below `starbreak/provenance`.
    ///
    /// A record's object is the label with its number (`annotation 4711`), else the label of its class
    /// with the nearest box, if that is within 1.5 px.
    ///
    /// # Errors
    /// [`EvalError::Dataset`] where a record cannot be read, [`EvalError::File`] where it is none. An image
    /// without a record is no error: its objects have no facts.
    pub fn read(folder: &Path, labels: &LabelSet) -> Result<Self, EvalError> {
        let n = labels.objects.len();
        let mut facts = Self {
            displacement_px: vec![f64::NAN; n],
            blur_radius_px: vec![f64::NAN; n],
            contrast_lost: vec![f64::NAN; n],
            n_images_without: 0,
        };
        let mut of_image: Vec<Vec<usize>> = vec![Vec::new(); labels.images.len()];
        for (place, object) in labels.objects.iter().enumerate() {
            if let Some(list) = of_image.get_mut(object.image as usize) {
                list.push(place);
            }
        }
        for (image, mut places) in labels.images.iter().zip(of_image) {
            if places.is_empty() {
                continue;
            }
            let (stem, extension) = image.name.rsplit_once('.').unwrap_or((&image.name, ""));
            let stem = if extension.contains('/') {
                &image.name
            } else {
                stem
            };
            let path = folder.join(format!("{stem}.json"));
            let text = match read_text(&path, MAX_ITEM_BYTES) {
                Ok(file) => file.text,
                Err(DatasetError::Read { source, .. })
                    if source.kind() == std::io::ErrorKind::NotFound =>
                {
                    facts.n_images_without += 1;
                    continue;
                }
                Err(error) => return Err(error.into()),
            };
            let record: Record = serde_json::from_str(&text).map_err(|cause| EvalError::File {
                path: path.clone(),
                reason: format!(
                    "it is not a damage record: {}; give the folder starbreak/provenance of a generated set",
                    cause.to_string().replace('\n', " ")
                ),
            })?;
            for recorded in &record.objects {
                let Some(at) = find(labels, &places, recorded) else {
                    continue;
                };
                let place = places.swap_remove(at);
                places.sort_unstable();
                if let Some(damage) = &recorded.damage {
                    put(&mut facts.displacement_px, place, damage.displacement_px);
                    put(&mut facts.blur_radius_px, place, damage.blur_radius_px);
                    put(&mut facts.contrast_lost, place, damage.contrast_lost);
                }
            }
        }
        Ok(facts)
    }

    /// The same in the order of [`KittiLabels::with_areas_as_crowds`]; a `DontCare` area has none.
    pub(super) fn with_areas_as_crowds(&self, labels: &KittiLabels) -> Self {
        let places = labels.places_with_areas_as_crowds();
        let of = |values: &[f64]| -> Vec<f64> {
            let value = |place: &Option<usize>| place.and_then(|place| values.get(place).copied());
            places
                .iter()
                .map(|place| value(place).unwrap_or(f64::NAN))
                .collect()
        };
        Self {
            displacement_px: of(&self.displacement_px),
            blur_radius_px: of(&self.blur_radius_px),
            contrast_lost: of(&self.contrast_lost),
            n_images_without: self.n_images_without,
        }
    }
}

fn put(values: &mut [f64], place: usize, value: Option<f64>) {
    if let (Some(slot), Some(value)) = (values.get_mut(place), value) {
        *slot = value;
    }
}

/// Which of the places has the label of a record.
fn find(labels: &LabelSet, places: &[usize], recorded: &RecordedObject) -> Option<usize> {
    let number = recorded.record.strip_prefix("annotation ");
    if let Some(id) = number.and_then(|number| number.parse::<i64>().ok()) {
        let is_it = |place: &usize| labels.objects.get(*place).is_some_and(|o| o.id == id);
        return places.iter().position(is_it);
    }
    let wanted = BoxPx::from_corners(recorded.box_px);
    let mut best: Option<(usize, f64)> = None;
    for (at, place) in places.iter().enumerate() {
        let Some(object) = labels.objects.get(*place) else {
            continue;
        };
        let category = labels.categories.get(object.category as usize);
        if category.is_none_or(|category| category.name != recorded.category) {
            continue;
        }
        let pairs = object.box_px.corners().into_iter().zip(wanted.corners());
        let off = pairs.fold(0.0_f64, |off, (a, b)| off.max((a - b).abs()));
        if off <= SAME_BOX_PX && best.is_none_or(|(_, least)| off < least) {
            best = Some((at, off));
        }
    }
    best.map(|(at, _)| at)
}
