//! Results in the form of MS-COCO: a list of boxes with numbers of images and categories.

use std::path::Path;

use serde::Deserialize;
use starbreak_dataset::{JsonRecord, WholeId, read_json_records, sound_bbox};

use super::{Detection, Detections, ReadDetections, Unused};
use crate::json_record::{parse, refuse, refuse_file};
use crate::{BoxPx, EvalError, LabelSet};

#[derive(Deserialize)]
struct ResultRecord {
    image_id: WholeId,
    category_id: WholeId,
    bbox: [f64; 4],
    score: f64,
}

/// What is counted while a file is read.
struct Reader<'l> {
    labels: &'l LabelSet,
    items: Vec<Detection>,
    n_all: usize,
    n_in_unknown_images: usize,
    first_unknown_image: Option<i64>,
    unused: Option<Unused>,
}

pub(super) fn read(path: &Path, labels: &LabelSet) -> Result<ReadDetections, EvalError> {
    let mut reader = Reader {
        labels,
        items: Vec::new(),
        n_all: 0,
        n_in_unknown_images: 0,
        first_unknown_image: None,
        unused: None,
    };
    let lists = read_json_records(path, |record| reader.take(path, &record))?;
    if !lists.is_one_list {
        let reason =
            "it is an object; detections are one list of {image_id, category_id, bbox, score}";
        return Err(refuse_file(path, reason));
    }
    if let Some(first) = reader.first_unknown_image {
        return Err(EvalError::UnknownImages {
            path: path.to_owned(),
            n_detections: reader.n_in_unknown_images,
            n_all: reader.n_all,
            first: first.to_string(),
        });
    }
    reader.items.shrink_to_fit();
    Ok(ReadDetections {
        detections: Detections {
            items: reader.items,
        },
        unused: reader.unused,
    })
}

impl Reader<'_> {
    fn take(&mut self, path: &Path, record: &JsonRecord<'_>) -> Result<(), EvalError> {
        let result: ResultRecord = parse(path, record)?;
        self.n_all += 1;
        let bbox_px =
            sound_bbox(result.bbox).map_err(|reason| refuse(path, record.place(), reason))?;
        let Some(image) = self.labels.image_of_id(result.image_id.0) else {
            self.n_in_unknown_images += 1;
            self.first_unknown_image.get_or_insert(result.image_id.0);
            return Ok(());
        };
        let Some(category) = self.labels.category_of_id(result.category_id.0) else {
            let unused = self.unused.get_or_insert_with(|| Unused {
                first: result.category_id.0.to_string(),
                n_detections: 0,
            });
            unused.n_detections += 1;
            return Ok(());
        };
        self.items.push(Detection {
            image,
            category,
            box_px: BoxPx::from_bbox(bbox_px),
            score: result.score,
        });
        Ok(())
    }
}
