//! Detections in the forms in which others read them.

use std::fmt::Write as _;

use serde_json::{Value, json};

use super::{Detection, Detections};
use crate::{Category, LabelSet, LabeledImage};

impl Detections {
    /// The detections as results of MS-COCO: a list of `{image_id, category_id, bbox, score}`, one
    /// per line, with the numbers of the labels. Those of images or categories that the labels lack
    /// are left out. Reading it gives the same numbers to the last bit.
    #[must_use]
    pub fn to_coco(&self, labels: &LabelSet) -> String {
        let mut text = String::from("[");
        for (detection, image, category) in self.named(labels) {
            let b = &detection.box_px;
            let row = json!({
                "image_id": image.id,
                "category_id": category.id,
                "bbox": [b.x, b.y, b.width, b.height],
                "score": detection.score,
            });
            let comma = if text.len() == 1 { "\n" } else { ",\n" };
            let _ = write!(text, "{comma}{row}");
        }
        text.push_str("\n]\n");
        text
    }

    /// The detections as results of KITTI: the name `NNNNNN.txt` and the text of the file of each
    /// image, also of those without detections. What a detector in 2-D does not know has KITTI's
    /// values for it.
    #[must_use]
    pub fn to_kitti(&self, labels: &LabelSet) -> Vec<(String, String)> {
        let mut files: Vec<(String, String)> = labels
            .images
            .iter()
            .map(|image| {
                let file = image.name.rsplit('/').next().unwrap_or(&image.name);
                let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
                (format!("{stem}.txt"), String::new())
            })
            .collect();
        for (detection, _, category) in self.named(labels) {
            let place = detection.image as usize;
            let [x0, y0, x1, y1] = detection.box_px.corners();
            // A name with white space would be two fields.
            let name = category.name.replace(char::is_whitespace, "_");
            if let Some((_, text)) = files.get_mut(place) {
                let _ = writeln!(
                    text,
                    "{name} -1 -1 -10 {x0} {y0} {x1} {y1} -1 -1 -1 -1000 -1000 -1000 -10 {}",
                    detection.score
                );
            }
        }
        files
    }

    /// The detections as frames of Scalabel, one per image, each line one.
    #[must_use]
    pub fn to_scalabel(&self, labels: &LabelSet) -> String {
        let mut frames: Vec<Vec<Value>> = vec![Vec::new(); labels.images.len()];
        for (number, (detection, _, category)) in self.named(labels).enumerate() {
            let [x1, y1, x2, y2] = detection.box_px.corners();
            let place = detection.image as usize;
            if let Some(frame) = frames.get_mut(place) {
                frame.push(json!({
                    "id": number.to_string(),
                    "category": category.name,
                    "score": detection.score,
                    "box2d": { "x1": x1, "y1": y1, "x2": x2, "y2": y2 },
                }));
            }
        }
        let mut text = String::from("[");
        for (image, found) in labels.images.iter().zip(frames) {
            let name = image.name.rsplit('/').next().unwrap_or(&image.name);
            let mut frame = json!({ "name": name, "labels": found });
            if let (Some(video), Some(members)) = (&image.cluster, frame.as_object_mut()) {
                members.insert("videoName".to_owned(), json!(video));
            }
            let comma = if text.len() == 1 { "\n" } else { ",\n" };
            let _ = write!(text, "{comma}{frame}");
        }
        text.push_str("\n]\n");
        text
    }

    /// The detections with their images and categories, as far as the labels have these.
    fn named<'a>(
        &'a self,
        labels: &'a LabelSet,
    ) -> impl Iterator<Item = (&'a Detection, &'a LabeledImage, &'a Category)> {
        self.items.iter().filter_map(|detection| {
            let image = usize::try_from(detection.image).ok()?;
            let category = usize::try_from(detection.category).ok()?;
            Some((
                detection,
                labels.images.get(image)?,
                labels.categories.get(category)?,
            ))
        })
    }
}
