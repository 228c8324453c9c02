//! Detections as frames in the form of Scalabel.

use std::path::Path;

use starbreak_dataset::bdd_class;

use super::{Detection, Detections, ReadDetections, Unused};
use crate::json_record::refuse;
use crate::labels::scalabel::for_each_frame;
use crate::{EvalError, LabelSet};

pub(super) fn read(path: &Path, labels: &LabelSet) -> Result<ReadDetections, EvalError> {
    // Frames go by their names without folders of the dataset.
    let mut places: Vec<(&str, u32)> = Vec::with_capacity(labels.images.len());
    places.extend(
        labels
            .images
            .iter()
            .zip(0u32..)
            .map(|(image, place)| (image.name.as_str(), place)),
    );
    let mut by_end: Vec<(&str, u32)> = places
        .iter()
        .map(|(name, place)| (name.rsplit('/').next().unwrap_or(name), *place))
        .collect();
    places.sort_unstable();
    by_end.sort_unstable();
    let find = |list: &[(&str, u32)], name: &str| {
        let from = list.partition_point(|(known, _)| *known < name);
        let same: Vec<u32> = list
            .get(from..)
            .unwrap_or(&[])
            .iter()
            .take_while(|(known, _)| *known == name)
            .map(|(_, place)| *place)
            .collect();
        same
    };
    let mut by_image: Vec<(u32, Vec<Detection>)> = Vec::new();
    let mut seen = vec![false; labels.images.len()];
    let (mut n_all, mut n_unknown) = (0, 0);
    let mut first: Option<String> = None;
    let mut unused: Option<Unused> = None;
    for_each_frame(path, |frame, at| {
        let mut found = find(&places, &frame.name);
        if let (true, Some(video)) = (found.is_empty(), &frame.video) {
            found = find(&places, &format!("{video}/{}", frame.name));
        }
        if found.is_empty() {
            found = find(&by_end, &frame.name);
        }
        let image = match found.as_slice() {
            [image] => Some(*image),
            [] => None,
            _ => {
                return Err(refuse(
                    path,
                    at,
                    "several images have this name; give it with its folder",
                ));
            }
        };
        let mut items = Vec::new();
        for (idx, label) in frame.labels.iter().flatten().enumerate() {
            let wrong = |reason: String| refuse(path, format!("{at}, label [{idx}]"), reason);
            let Some(box_px) = label.box_px().map_err(wrong)? else {
                continue;
            };
            n_all += 1;
            let Some(image) = image else {
                n_unknown += 1;
                continue;
            };
            let Some(name) = &label.category else {
                return Err(wrong("it has a box but no category".to_owned()));
            };
            let Some(score) = label.score else {
                return Err(wrong("it has no score; detections have one".to_owned()));
            };
            match labels.category_of_name(bdd_class(name).0) {
                Some(category) => items.push(Detection {
                    image,
                    category,
                    box_px,
                    score,
                }),
                None => {
                    let unused = unused.get_or_insert_with(|| Unused {
                        first: name.clone(),
                        n_detections: 0,
                    });
                    unused.n_detections += 1;
                }
            }
        }
        match image {
            None => {
                first.get_or_insert_with(|| frame.name.escape_debug().to_string());
            }
            Some(image) => {
                let idx = usize::try_from(image).unwrap_or(usize::MAX);
                if let Some(is_seen) = seen.get_mut(idx)
                    && std::mem::replace(is_seen, true)
                {
                    return Err(refuse(path, at, "the frame occurs twice"));
                }
                by_image.push((image, items));
            }
        }
        Ok(())
    })?;
    if let Some(first) = first {
        return Err(EvalError::UnknownImages {
            path: path.to_owned(),
            n_detections: n_unknown,
            n_all,
            first,
        });
    }
    // In the order of the labels' frames, which decides between equal scores.
    by_image.sort_by_key(|(image, _)| *image);
    Ok(ReadDetections {
        detections: Detections {
            items: by_image.into_iter().flat_map(|(_, items)| items).collect(),
        },
        unused,
    })
}
