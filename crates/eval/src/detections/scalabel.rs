//! Detections as frames in the form of Scalabel.

use std::path::Path;

use starbreak_dataset::ScalabelFrame;

use super::{Detection, Detections, ReadDetections, Unused};
use crate::json_record::refuse;
use crate::labels::scalabel::{for_each_frame, for_each_label};
use crate::{BoxPx, EvalError, LabelSet};

pub(super) fn read(path: &Path, labels: &LabelSet) -> Result<ReadDetections, EvalError> {
    let mut reader = Reader {
        labels,
        images: ImagesByName::of(labels),
        by_image: vec![None; labels.images.len()],
        n_all: 0,
        n_in_unknown_images: 0,
        first_unknown_image: None,
        unused: None,
    };
    for_each_frame(path, |frame, at| reader.take(path, frame, at))?;
    if let Some(first) = reader.first_unknown_image {
        return Err(EvalError::UnknownImages {
            path: path.to_owned(),
            n_detections: reader.n_in_unknown_images,
            n_all: reader.n_all,
            first,
        });
    }
    // In the order of the labels' frames, which decides between equal scores.
    let items = reader.by_image.into_iter().flatten().flatten();
    Ok(ReadDetections {
        detections: Detections {
            items: items.collect(),
        },
        unused: reader.unused,
    })
}

/// What is found while a file is read.
struct Reader<'l> {
    labels: &'l LabelSet,
    images: ImagesByName<'l>,
    /// The detections of each image that was a frame.
    by_image: Vec<Option<Vec<Detection>>>,
    n_all: usize,
    n_in_unknown_images: usize,
    first_unknown_image: Option<String>,
    unused: Option<Unused>,
}

impl Reader<'_> {
    fn take(&mut self, path: &Path, frame: &ScalabelFrame<'_>, at: &str) -> Result<(), EvalError> {
        let image = match self.images.of_frame(frame).as_slice() {
            [image] => Some(*image),
            [] => None,
            _ => {
                let reason = "several images have this name; give it with its folder";
                return Err(refuse(path, at, reason));
            }
        };
        let mut items = Vec::new();
        for_each_label(path, frame, at, |label| {
            let Some(object) = label.object()? else {
                return Ok(());
            };
            self.n_all += 1;
            let Some(image) = image else {
                self.n_in_unknown_images += 1;
                return Ok(());
            };
            let score = label.score()?;
            match self.labels.category_of_name(object.class) {
                Some(category) => items.push(Detection {
                    image,
                    category,
                    box_px: BoxPx::from_corners(object.corners_px),
                    score,
                }),
                None => {
                    let unused = self.unused.get_or_insert_with(|| Unused {
                        first: label.category.clone().unwrap_or_default(),
                        n_detections: 0,
                    });
                    unused.n_detections += 1;
                }
            }
            Ok(())
        })?;
        let Some(image) = image else {
            self.first_unknown_image
                .get_or_insert_with(|| frame.name.escape_debug().to_string());
            return Ok(());
        };
        if let Some(of_image) = self.by_image.get_mut(image as usize)
            && of_image.replace(items).is_some()
        {
            return Err(refuse(path, at, "the frame occurs twice"));
        }
        Ok(())
    }
}

/// The places of images by what frames call them.
struct ImagesByName<'l> {
    by_name: Vec<(&'l str, u32)>,
    /// By their names without the folders of the dataset.
    by_end: Vec<(&'l str, u32)>,
}

impl<'l> ImagesByName<'l> {
    fn of(labels: &'l LabelSet) -> Self {
        let names = labels.images.iter().map(|image| image.name.as_str());
        let mut by_name: Vec<(&str, u32)> = names.zip(0..).collect();
        let end = |name: &'l str| name.rsplit('/').next().unwrap_or(name);
        let mut by_end: Vec<(&str, u32)> = by_name
            .iter()
            .map(|(name, place)| (end(name), *place))
            .collect();
        by_name.sort_unstable();
        by_end.sort_unstable();
        Self { by_name, by_end }
    }

    /// The places of the images that a frame may be: of those with its name, with the folder of its
    /// video before it, or without folders, the first that there are.
    fn of_frame(&self, frame: &ScalabelFrame<'_>) -> Vec<u32> {
        let find = |list: &[(&str, u32)], name: &str| -> Vec<u32> {
            let from = list.partition_point(|(known, _)| *known < name);
            let behind = list.get(from..).unwrap_or(&[]).iter();
            let same = behind.take_while(|(known, _)| *known == name);
            same.map(|(_, place)| *place).collect()
        };
        let mut found = find(&self.by_name, &frame.name);
        if let (true, Some(video)) = (found.is_empty(), &frame.video) {
            found = find(&self.by_name, &format!("{video}/{}", frame.name));
        }
        if found.is_empty() {
            found = find(&self.by_end, &frame.name);
        }
        found
    }
}
