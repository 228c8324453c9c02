//! The records of a COCO index file.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::error::DatasetError;
use crate::json_records::JsonRecord;
use crate::source::coco_row::{CocoAnnotation, CocoCategory, CocoImage};
use crate::source::id::Id;
use crate::source::index::{IndexFile, Label, Row, image_name, second_names, seconds};
use crate::source::record::BadRecord;

/// What is needed to know whose annotation it is.
#[derive(Deserialize)]
pub(super) struct AnnotationOf {
    pub(super) image_id: Option<Id>,
}

/// What became of an image that a record names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fate {
    /// No record of it was read yet.
    Unknown,
    /// Its record is bad and reported.
    Refused,
    /// Its place among the rows.
    Row(usize),
}

/// Takes the records of one index file.
#[derive(Default)]
pub(super) struct Reader {
    name: String,
    /// Images by id, numbered as they occur, in records of images or of annotations.
    image_numbers: BTreeMap<Id, usize>,
    fates: Vec<Fate>,
    /// Ids of several images.
    shared_ids: BTreeSet<Id>,
    rows: Vec<Row>,
    /// Classes by id, numbered as they occur.
    category_numbers: BTreeMap<Id, usize>,
    categories: Vec<Option<String>>,
    /// The number of the image, and the box.
    labels: Vec<(usize, Label)>,
    /// The number of the image, and what is wrong.
    problems: Vec<(usize, BadRecord)>,
    bad: Vec<BadRecord>,
}

impl Reader {
    /// For the index of this name.
    pub(super) fn of(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            ..Self::default()
        }
    }

    fn bad(&self, record: &str, reason: impl Into<String>) -> BadRecord {
        BadRecord::new(format!("{}: {record}", self.name), reason)
    }

    fn image_number(&mut self, id: Id) -> usize {
        let next = self.fates.len();
        let number = *self.image_numbers.entry(id).or_insert(next);
        if number == next {
            self.fates.push(Fate::Unknown);
        }
        number
    }

    fn category_number(&mut self, id: Id) -> usize {
        let next = self.categories.len();
        let number = *self.category_numbers.entry(id).or_insert(next);
        if number == next {
            self.categories.push(None);
        }
        number
    }

    /// Takes a record; one that is no JSON is an error of the file.
    pub(super) fn take(
        &mut self,
        path: &Path,
        record: &JsonRecord<'_>,
    ) -> Result<(), DatasetError> {
        // From 0, as JSON tools count.
        let place = record.place();
        match record.key {
            "images" => match record.row(path)? {
                Ok(image) => self.image(image, &place),
                Err(reason) => self.bad.push(self.bad(&place, reason)),
            },
            "categories" => match record.row(path)? {
                Ok(category) => self.category(category, &place),
                Err(reason) => self.bad.push(self.bad(&place, reason)),
            },
            _ => match record.row(path)? {
                Ok(annotation) => self.annotation(annotation, place),
                Err(reason) => {
                    let of = record.parse::<AnnotationOf>().ok();
                    self.problem(&place, of.and_then(|of| of.image_id), reason);
                }
            },
        }
        Ok(())
    }

    fn image(&mut self, record: CocoImage<Id, IgnoredAny>, place: &str) {
        let Some(file_name) = record.file_name else {
            self.bad.push(self.bad(place, "it has no file_name"));
            return;
        };
        let place = format!("image {}", record.id);
        let number = self.image_number(record.id.clone());
        let is_first = self.fates.get(number) == Some(&Fate::Unknown);
        let fate = match image_name(&file_name) {
            _ if !is_first => {
                let reason = format!("the id occurs twice, again for {file_name:?}");
                let bad = self.bad(&place, reason).of_image(&file_name);
                self.bad.push(bad);
                self.shared_ids.insert(record.id);
                return;
            }
            Ok(name) => {
                self.rows.push(Row {
                    name,
                    id: record.id,
                    labels_end: 0,
                });
                Fate::Row(self.rows.len() - 1)
            }
            Err(reason) => {
                let bad = self.bad(&place, reason).of_image(&file_name);
                self.bad.push(bad);
                Fate::Refused
            }
        };
        if let Some(known) = self.fates.get_mut(number) {
            *known = fate;
        }
    }

    fn category(&mut self, record: CocoCategory<Id, IgnoredAny>, place: &str) {
        let Some(name) = record.name else {
            self.bad.push(self.bad(place, "it has no name"));
            return;
        };
        let place = format!("category {}", record.id);
        let number = self.category_number(record.id);
        match self.categories.get_mut(number) {
            Some(known @ None) => *known = Some(name),
            _ => {
                let reason = format!("the id occurs twice, again for {name:?}");
                self.bad.push(self.bad(&place, reason));
            }
        }
    }

    fn annotation(&mut self, record: CocoAnnotation<Id, IgnoredAny>, place: String) {
        let place = match &record.id {
            Some(id) => format!("annotation {id}"),
            None => place,
        };
        let image_id = record.image_id.clone();
        let object = match record.object() {
            Ok(object) => object,
            Err(reason) => return self.problem(&place, image_id, reason),
        };
        let [x, y, width, height] = object.bbox_px;
        let label = Label {
            id: object.id,
            category: self.category_number(object.category_id),
            box_px: [x, y, x + width, y + height],
            kind: object.kind,
        };
        let number = self.image_number(object.image_id);
        self.labels.push((number, label));
    }

    /// An annotation is bad, of this image if it says so.
    fn problem(&mut self, place: &str, image_id: Option<Id>, reason: String) {
        let problem = self.bad(place, reason);
        match image_id {
            Some(id) => {
                let number = self.image_number(id);
                self.problems.push((number, problem));
            }
            None => self.bad.push(problem),
        }
    }

    /// Ids that stand for two images: nobody knows whose the annotations are, so both are refused.
    fn refuse_shared_ids(&mut self) {
        if self.shared_ids.is_empty() {
            return;
        }
        let mut kept = Vec::with_capacity(self.rows.len());
        for row in std::mem::take(&mut self.rows) {
            let is_shared = self.shared_ids.contains(&row.id);
            let fate = if is_shared {
                Fate::Refused
            } else {
                Fate::Row(kept.len())
            };
            if let Some(number) = self.image_numbers.get(&row.id)
                && let Some(known) = self.fates.get_mut(*number)
            {
                *known = fate;
            }
            if is_shared {
                let reason = "the id occurs twice, so that its annotations may be another's";
                let bad = self.bad(&format!("image {}", row.id), reason);
                self.bad.push(bad.of_image(&row.name));
            } else {
                kept.push(row);
            }
        }
        self.rows = kept;
    }

    /// Names that stand for two images: the second is refused.
    fn refuse_second_names(&mut self) {
        let seconds = second_names(&self.rows);
        if seconds.is_empty() {
            return;
        }
        let mut kept = Vec::with_capacity(self.rows.len());
        for (row_idx, row) in std::mem::take(&mut self.rows).into_iter().enumerate() {
            let is_second = seconds.contains(&row_idx);
            let fate = if is_second {
                Fate::Refused
            } else {
                Fate::Row(kept.len())
            };
            if let Some(number) = self.image_numbers.get(&row.id)
                && let Some(known) = self.fates.get_mut(*number)
            {
                *known = fate;
            }
            if is_second {
                let reason = format!("the file_name {:?} occurs twice", row.name);
                let bad = self.bad(&format!("image {}", row.id), reason);
                let bad = bad.of_image(&row.name);
                self.bad.push(bad);
            } else {
                kept.push(row);
            }
        }
        self.rows = kept;
    }

    /// Annotations that share an id: all but the first are problems, and stay in the index.
    fn refuse_second_ids(&mut self) {
        let seconds = seconds(&self.labels, |(_, label)| &label.id);
        if seconds.is_empty() {
            return;
        }
        let labels = std::mem::take(&mut self.labels);
        for (idx, (number, label)) in labels.into_iter().enumerate() {
            if seconds.contains(&idx) {
                let place = format!("annotation {}", label.id);
                let problem = self.bad(&place, "the id occurs twice");
                self.problems.push((number, problem));
            } else {
                self.labels.push((number, label));
            }
        }
    }

    /// Sorts what belongs to each image to it and reports the rest.
    pub(super) fn finish(mut self, path: PathBuf) -> IndexFile {
        self.refuse_shared_ids();
        self.refuse_second_names();
        self.refuse_second_ids();
        let mut image_ids = vec![None; self.fates.len()];
        for (id, number) in &self.image_numbers {
            if let Some(place) = image_ids.get_mut(*number) {
                *place = Some(id);
            }
        }
        let fate_of = |number: usize| self.fates.get(number).copied().unwrap_or(Fate::Unknown);
        let mut bad = Vec::new();
        let mut labels = Vec::with_capacity(self.labels.len());
        let mut problems = Vec::new();
        let place_of = |label: &Label| format!("{}: annotation {}", self.name, label.id);
        for (number, label) in std::mem::take(&mut self.labels) {
            match fate_of(number) {
                Fate::Refused => {}
                Fate::Unknown => {
                    let id = image_ids.get(number).copied().flatten();
                    let id = id.map(ToString::to_string).unwrap_or_default();
                    let reason = format!("its image {id} is not in the index");
                    bad.push(BadRecord::new(place_of(&label), reason));
                }
                Fate::Row(row) if !matches!(self.categories.get(label.category), Some(Some(_))) => {
                    let has_number = |(_, number): &(&Id, &usize)| **number == label.category;
                    let id = self.category_numbers.iter().find(has_number);
                    let id = id.map(|(id, _)| id.to_string()).unwrap_or_default();
                    let reason = format!("its category {id} is not in the index");
                    problems.push((row, BadRecord::new(place_of(&label), reason)));
                }
                Fate::Row(row) => labels.push((row, label)),
            }
        }
        for (number, problem) in self.problems {
            match fate_of(number) {
                Fate::Row(row) => problems.push((row, problem)),
                Fate::Unknown => bad.push(problem),
                Fate::Refused => {}
            }
        }
        self.bad.append(&mut bad);
        let categories = self.categories.into_iter().map(Option::unwrap_or_default);
        IndexFile {
            name: self.name,
            path,
            rows: self.rows,
            labels: Vec::new(),
            categories: categories.collect(),
            problems,
            bad: self.bad,
        }
        .with_labels(labels)
    }
}
