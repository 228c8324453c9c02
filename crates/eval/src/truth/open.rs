//! Ground truth from where a user says it is, in the convention of a protocol.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::{Path, PathBuf};

use starbreak_dataset::{DatasetError, IndexFiles, Source, SourceFormat, SourceSpec, files_in};

use crate::json_record::{refuse, refuse_file};
use crate::labels::{coco, scalabel};
use crate::{
    BoxPx, Detections, EvalError, KittiDetections, KittiLabels, LabelSet, ReadDetections, Unused,
    bdd_detections, bdd_labels,
};

/// By which rules a detection counts as right.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Protocol {
    /// MS-COCO.
    Coco,
    /// KITTI, object detection in 2-D.
    Kitti,
    /// BDD100K: those of MS-COCO, boxes with their last pixels.
    Bdd,
}

impl Protocol {
    /// `coco`, `kitti` or `bdd`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Coco => "coco",
            Self::Kitti => "kitti",
            Self::Bdd => "bdd",
        }
    }
}

impl fmt::Display for Protocol {
    /// Writes [`Protocol::name`].
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Ground truth, and by which protocol it is evaluated.
#[derive(Debug, Clone)]
pub struct GroundTruth {
    /// By which rules.
    pub protocol: Protocol,
    /// Images, categories and objects in the convention of the protocol.
    pub labels: LabelSet,
    /// What KITTI says beyond, where the labels are KITTI's; its objects are those of
    /// [`labels`](Self::labels) under KITTI's protocol only.
    pub kitti: Option<KittiLabels>,
    /// The root of the dataset, if it is one with images.
    pub root: Option<PathBuf>,
}

/// Detections in the convention of the protocol of their ground truth.
#[derive(Debug, Clone, Default)]
pub struct SaidDetections {
    /// The detections.
    pub detections: Detections,
    /// Corners, and which frames are evaluated, under KITTI's protocol.
    pub kitti: Option<KittiDetections>,
    /// Detections of categories that the labels lack.
    pub unused: Option<Unused>,
}

impl GroundTruth {
    /// The labels of a dataset. Without a protocol that of its format: KITTI's of KITTI, BDD100K's
    /// of BDD100K, else MS-COCO's.
    ///
    /// # Errors
    /// [`EvalError::Dataset`] where it cannot be read, [`EvalError::Record`] and
    /// [`EvalError::File`] for labels that make no sense, [`EvalError::Rule`] for a format without
    /// labels, or a protocol that does not go with it.
    pub fn of_dataset(spec: &SourceSpec, protocol: Option<Protocol>) -> Result<Self, EvalError> {
        match spec.format {
            SourceFormat::Coco => {
                let files = IndexFiles::of(spec)?;
                let mut reader = coco::Reader::default();
                for name in &files.names {
                    reader.read(&files.path(name), |images| files.image_names(name, images))?;
                }
                Self::of(
                    reader.finish(&spec.path)?,
                    protocol,
                    Protocol::Coco,
                    Some(files.root),
                )
            }
            SourceFormat::Bdd => {
                let files = IndexFiles::of(spec)?;
                let mut reader = scalabel::Reader::default();
                for name in &files.names {
                    reader.read(&files.path(name), |images| files.image_names(name, images))?;
                }
                Self::of(
                    reader.finish(&spec.path)?,
                    protocol,
                    Protocol::Bdd,
                    Some(files.root),
                )
            }
            SourceFormat::Kitti => {
                let source = Source::open(spec)?;
                let labels = kitti_of(&source)?;
                Self::of_kitti(labels, protocol, Some(source.root().to_owned()))
            }
            SourceFormat::Yolo => {
                let source = Source::open(spec)?;
                let labels = boxes_of(&source)?;
                Self::of(
                    labels,
                    protocol,
                    Protocol::Coco,
                    Some(source.root().to_owned()),
                )
            }
            SourceFormat::Folder | SourceFormat::List => Err(EvalError::Rule(format!(
                "{}: has no labels; give a dataset with labels: kitti:, coco:, bdd: or yolo:",
                spec.format
            ))),
        }
    }

    /// The labels in a file or folder of the protocol's own form: `instances_*.json` of MS-COCO, a
    /// folder with `NNNNNN.txt` of KITTI, frames of BDD100K.
    ///
    /// # Errors
    /// As [`of_dataset`](Self::of_dataset).
    pub fn of_path(path: &Path, protocol: Protocol) -> Result<Self, EvalError> {
        match protocol {
            Protocol::Coco => Self::of(LabelSet::read_coco(path)?, Some(protocol), protocol, None),
            Protocol::Bdd => Self::of(
                LabelSet::read_scalabel(path)?,
                Some(protocol),
                protocol,
                None,
            ),
            Protocol::Kitti => {
                let inside = path.join("label_2");
                let folder = match files_in(&inside, "txt") {
                    Ok(files) if !files.is_empty() => inside,
                    _ => path.to_owned(),
                };
                Self::of_kitti(KittiLabels::read(&folder, "")?, Some(protocol), None)
            }
        }
    }

    fn of(
        labels: LabelSet,
        protocol: Option<Protocol>,
        own: Protocol,
        root: Option<PathBuf>,
    ) -> Result<Self, EvalError> {
        let protocol = protocol.unwrap_or(own);
        let labels = match protocol {
            Protocol::Coco => labels,
            Protocol::Bdd => bdd_labels(&labels),
            Protocol::Kitti => {
                return Err(EvalError::Rule(
                    "the protocol of KITTI needs its labels, which say how far an object is hidden; give kitti:DIR, or another protocol".to_owned(),
                ));
            }
        };
        Ok(Self {
            protocol,
            labels,
            kitti: None,
            root,
        })
    }

    fn of_kitti(
        kitti: KittiLabels,
        protocol: Option<Protocol>,
        root: Option<PathBuf>,
    ) -> Result<Self, EvalError> {
        let protocol = protocol.unwrap_or(Protocol::Kitti);
        let labels = match protocol {
            Protocol::Kitti => kitti.set.clone(),
            Protocol::Coco => kitti.with_areas_as_crowds(),
            Protocol::Bdd => bdd_labels(&kitti.with_areas_as_crowds()),
        };
        Ok(Self {
            protocol,
            labels,
            kitti: Some(kitti),
            root,
        })
    }

    /// Which images are not independent of each other, by [`LabelSet::read_clusters`].
    ///
    /// # Errors
    /// As it.
    pub fn read_clusters(&mut self, path: &Path) -> Result<(), EvalError> {
        self.labels.read_clusters(path)?;
        if let Some(kitti) = &mut self.kitti {
            kitti.set.images.clone_from(&self.labels.images);
        }
        Ok(())
    }

    /// The detections in a file or folder: results of MS-COCO or frames of Scalabel, told apart by
    /// what is in them, or a folder of results of KITTI.
    ///
    /// # Errors
    /// As the readers of [`Detections`] and [`KittiDetections`]; [`EvalError::Rule`] for results of
    /// KITTI with labels of another dataset.
    pub fn read_detections(&self, path: &Path) -> Result<SaidDetections, EvalError> {
        if files_in(path, "txt").is_ok() {
            return self.read_kitti(path);
        }
        let ReadDetections { detections, unused } = match is_scalabel(path)? {
            true => Detections::read_scalabel(path, &self.labels)?,
            false => Detections::read_coco(path, &self.labels)?,
        };
        let detections = detections.within_limits(path, &self.labels)?;
        let detections = match self.protocol {
            Protocol::Bdd => bdd_detections(&detections),
            Protocol::Coco | Protocol::Kitti => detections,
        };
        let kitti = (self.protocol == Protocol::Kitti)
            .then(|| KittiDetections::of(&detections, &self.labels));
        Ok(SaidDetections {
            detections,
            kitti,
            unused,
        })
    }

    fn read_kitti(&self, path: &Path) -> Result<SaidDetections, EvalError> {
        let Some(labels) = &self.kitti else {
            return Err(EvalError::Rule(format!(
                "{path:?}: a folder of results is of KITTI, and so must the labels be; give kitti:DIR, or results as one JSON file"
            )));
        };
        let mut said = KittiDetections::read(path, labels)?;
        said.set = said.set.within_limits(path, &labels.set)?;
        if self.protocol == Protocol::Kitti {
            return Ok(SaidDetections {
                detections: said.set.clone(),
                unused: said.unused.clone(),
                kitti: Some(said),
            });
        }
        let n_frames = said.images.len();
        if n_frames != self.labels.images.len() {
            return Err(refuse_file(
                path,
                format!(
                    "it has results of {n_frames} of {} frames, and this protocol evaluates all; write an empty file for a frame without detections, or take the protocol kitti",
                    self.labels.images.len()
                ),
            ));
        }
        if let Some(flat) = said.set.items.iter().find(|d| !d.box_px.is_sound()) {
            let reason = format!(
                "the box {:?} px ends before it begins, or reaches beyond 1e9 px",
                flat.box_px.corners()
            );
            return Err(refuse_file(path, reason));
        }
        // By name, as there is no category for areas of no matter.
        let mut detections = Detections::default();
        for (place, detection) in said.set.items.iter().enumerate() {
            // KITTI's own program takes them for `Misc`; here they count for nothing.
            if said.of_unused.binary_search(&place).is_ok() {
                continue;
            }
            let category = labels.set.categories.get(detection.category as usize);
            let name = category.map_or("", |category| category.name.as_str());
            if let Some(category) = self.labels.category_of_name(name) {
                detections.items.push(crate::Detection {
                    category,
                    ..*detection
                });
            }
        }
        if self.protocol == Protocol::Bdd {
            detections = bdd_detections(&detections);
        }
        Ok(SaidDetections {
            detections,
            kitti: None,
            unused: said.unused,
        })
    }
}

/// Whether a file has frames with names, not boxes with numbers of images.
pub(super) fn is_scalabel(path: &Path) -> Result<bool, EvalError> {
    /// Why the reading ends.
    enum End {
        Seen(bool),
        Broken(DatasetError),
    }
    impl From<DatasetError> for End {
        fn from(error: DatasetError) -> Self {
            Self::Broken(error)
        }
    }
    let read = starbreak_dataset::read_json_records(path, |record| {
        let value: Option<serde_json::Value> = record.parse().ok();
        let has = |key: &str| value.as_ref().is_some_and(|value| value.get(key).is_some());
        Err(End::Seen(
            record.key == "frames" || (record.key.is_empty() && has("name") && !has("image_id")),
        ))
    });
    match read {
        Err(End::Seen(is_scalabel)) => Ok(is_scalabel),
        Err(End::Broken(error)) => Err(error.into()),
        Ok(lists) => Ok(lists.keys.iter().any(|key| key == "frames")),
    }
}

/// The labeled frames of the left color camera.
fn kitti_of(source: &Source) -> Result<KittiLabels, EvalError> {
    let mut files: Vec<(String, PathBuf)> = Vec::new();
    for image in source.images() {
        let Ok(image) = image else { continue };
        let Some((part, file)) = image.name.split_once("image_2/") else {
            continue;
        };
        let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
        let label = source.root().join(format!("{part}label_2/{stem}.txt"));
        if !part.starts_with("testing") {
            files.push((image.name.clone(), label));
        }
    }
    files.sort_unstable();
    KittiLabels::read_files(files.into_iter())
}

/// Boxes as a [`Source`] gives them: their areas are those of the boxes.
fn boxes_of(source: &Source) -> Result<LabelSet, EvalError> {
    let mut labels = LabelSet::default();
    let mut classes: Vec<String> = Vec::new();
    for image in source.images() {
        let bad = |bad: &starbreak_dataset::BadRecord| {
            refuse(&source.root().join(&bad.place), "label", bad.reason.clone())
        };
        let image = image.map_err(|record| bad(&record))?;
        if let Some(problem) = image.problems.first() {
            return Err(bad(problem));
        }
        let place = labels.add_image(image.name, None);
        for object in image.objects {
            // The category is set when all are known.
            let box_px = BoxPx::from_corners(object.box_px);
            labels.add_object(place, 0, box_px, object.kind);
            classes.push(object.category);
        }
    }
    // All classes that there may be, and those that occur: what a detector says of a class that
    // nothing is labeled with is an error, too.
    let occurring: BTreeSet<&String> = classes.iter().collect();
    let all = source.categories();
    let mut places = BTreeMap::<&str, u32>::new();
    for name in all.iter().chain(occurring) {
        places
            .entry(name)
            .or_insert_with(|| labels.add_category(name.clone()));
    }
    for (object, class) in labels.objects.iter_mut().zip(&classes) {
        object.category = places.get(class.as_str()).copied().unwrap_or(0);
    }
    Ok(labels)
}
