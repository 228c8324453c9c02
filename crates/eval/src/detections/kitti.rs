//! Results in the form of KITTI: a folder with a file `NNNNNN.txt` per frame.

use std::path::Path;

use super::{Detection, Detections, Unused};
use crate::json_record::refuse;
use crate::labels::kitti::{Line, frame_files, lines, place_of_type};
use crate::{BoxPx, EvalError, KittiLabels, LabelSet};

/// Detections of KITTI frames, with their corners as they were written.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct KittiDetections {
    /// The detections, frame by frame; those of types that the labels lack are of type `Misc`.
    pub set: Detections,
    /// The box `x0, y0, x1, y1` in the numbers of the file, px, one per detection.
    pub corners_px: Vec<[f64; 4]>,
    /// Places of the images that have a result file, rising; only these are evaluated.
    pub images: Vec<u32>,
    /// Detections of types that the labels lack.
    pub unused: Option<Unused>,
    /// Places in `set` of those, rising.
    pub(crate) of_unused: Vec<usize>,
}

impl KittiDetections {
    /// The detections in a folder with a file `NNNNNN.txt` per frame, 16 fields per line, or in
    /// the folder `data` in it. A frame without a file is not evaluated; one with an empty file has
    /// no detections. A box that ends before it begins is taken, as by the benchmark's program; it
    /// overlaps nothing.
    ///
    /// # Errors
    /// [`EvalError::Record`] with file and line for what is no result, [`EvalError::UnknownImages`]
    /// for files of frames that the labels lack, [`EvalError::File`] where there is no file at all,
    /// [`EvalError::Dataset`].
    pub fn read(folder: &Path, labels: &KittiLabels) -> Result<Self, EvalError> {
        let data = folder.join("data");
        let files = match frame_files(&data) {
            Ok(files) => files,
            Err(_) => frame_files(folder)?,
        };
        let mut frames: Vec<(&str, u32)> = labels
            .set
            .images
            .iter()
            .zip(0u32..)
            .map(|(image, place)| (stem(&image.name), place))
            .collect();
        frames.sort_unstable();
        let mut read = Self::default();
        let (mut n_all, mut n_unknown, mut first) = (0, 0, None);
        for (frame, path) in files {
            let at = frames.binary_search_by(|(known, _)| (*known).cmp(&frame));
            let image = at
                .ok()
                .and_then(|at| frames.get(at))
                .map(|(_, place)| *place);
            match image {
                Some(image) => read.images.push(image),
                None => first = first.or(Some(frame)),
            }
            for line in lines(&path)? {
                let Line { row, place } = line?;
                n_all += 1;
                let [.., score] = row.numbers;
                if score.is_nan() {
                    let reason = "15 fields; a result has the score as the 16th";
                    return Err(refuse(&path, place, reason));
                }
                let Some(image) = image else {
                    n_unknown += 1;
                    continue;
                };
                let category = match place_of_type(&labels.set, &row.category) {
                    Some(category) => category,
                    None => {
                        let unused = read.unused.get_or_insert_with(|| Unused {
                            first: row.category.clone(),
                            n_detections: 0,
                        });
                        unused.n_detections += 1;
                        read.of_unused.push(read.set.items.len());
                        place_of_type(&labels.set, "Misc").unwrap_or(0)
                    }
                };
                let corners_px = row.corners_px();
                read.set.items.push(Detection {
                    image,
                    category,
                    box_px: BoxPx::from_corners(corners_px),
                    score,
                });
                read.corners_px.push(corners_px);
            }
        }
        if let Some(first) = first {
            return Err(EvalError::UnknownImages {
                path: folder.to_owned(),
                n_detections: n_unknown,
                n_all,
                first,
            });
        }
        read.images.sort_unstable();
        Ok(read)
    }

    /// The same detections as if they had come in files: of all images.
    #[must_use]
    pub fn of(detections: &Detections, labels: &LabelSet) -> Self {
        Self {
            corners_px: detections
                .items
                .iter()
                .map(|d| d.box_px.corners())
                .collect(),
            set: detections.clone(),
            images: (0u32..)
                .zip(&labels.images)
                .map(|(place, _)| place)
                .collect(),
            unused: None,
            of_unused: Vec::new(),
        }
    }
}

/// The name of a file without folders and extension.
fn stem(name: &str) -> &str {
    let file = name.rsplit('/').next().unwrap_or(name);
    file.rsplit_once('.').map_or(file, |(stem, _)| stem)
}
