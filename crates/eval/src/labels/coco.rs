//! MS-COCO: `instances_*.json`.

use std::collections::BTreeSet;
use std::path::Path;

use starbreak_dataset::{
    CocoAnnotation, CocoCategory, CocoImage, JsonRecord, WholeId, read_coco_records,
};

use super::{Category, LabelSet, LabeledImage, Object, ObjectKind, index_of};
use crate::json_record::{parse, refuse};
use crate::{BoxPx, EvalError};

/// An object whose image and category are still numbers of the file.
struct Row {
    id: i64,
    image_id: i64,
    category_id: i64,
    box_px: BoxPx,
    area_px2: f64,
    kind: ObjectKind,
    /// Its place in its list.
    idx: u64,
}

/// Takes the records of one file or several.
#[derive(Default)]
pub(crate) struct Reader {
    images: Vec<LabeledImage>,
    categories: Vec<Category>,
    rows: Vec<Row>,
}

impl Reader {
    /// Reads a file; `names` makes the names of images in the dataset of what the file calls them.
    pub(crate) fn read(
        &mut self,
        path: &Path,
        names: impl Fn(&[&str]) -> Vec<String>,
    ) -> Result<(), EvalError> {
        let n_before = self.images.len();
        read_coco_records(path, |record| self.take(path, &record))?;
        let images = self.images.get_mut(n_before..).unwrap_or(&mut []);
        let said: Vec<&str> = images.iter().map(|image| image.name.as_str()).collect();
        let named = names(&said);
        for (image, name) in images.iter_mut().zip(named) {
            image.name = name;
        }
        Ok(())
    }

    fn take(&mut self, path: &Path, record: &JsonRecord<'_>) -> Result<(), EvalError> {
        match record.key {
            "images" => {
                let image: CocoImage<WholeId, u32> = parse(path, record)?;
                let WholeId(id) = image.id;
                self.images.push(LabeledImage {
                    id,
                    name: image.file_name.unwrap_or_else(|| id.to_string()),
                    width_px: image.width,
                    height_px: image.height,
                    cluster: None,
                });
            }
            "categories" => {
                let category: CocoCategory<WholeId, String> = parse(path, record)?;
                let WholeId(id) = category.id;
                let category = Category {
                    id,
                    name: category.name.unwrap_or_else(|| id.to_string()),
                    supercategory: category.supercategory,
                };
                // Several files of one dataset repeat their categories.
                if !self.categories.contains(&category) {
                    self.categories.push(category);
                }
            }
            _ => self.rows.push(row_of(path, record)?),
        }
        Ok(())
    }

    /// All that was read, in the order of the protocol: images and categories by their numbers,
    /// objects as they stood.
    pub(crate) fn finish(mut self, path: &Path) -> Result<LabelSet, EvalError> {
        self.images.sort_by_key(|image| image.id);
        self.categories.sort_by_key(|category| category.id);
        let twice = |what: &str, id: Option<i64>| match id {
            Some(id) => Err(refuse(path, format!("{what} {id}"), "the id occurs twice")),
            None => Ok(()),
        };
        twice("image", second(self.images.iter().map(|image| image.id)))?;
        let categories = self.categories.iter().map(|category| category.id);
        twice("category", second(categories))?;
        tell_apart(&mut self.categories);
        let mut ids: Vec<i64> = self.rows.iter().map(|row| row.id).collect();
        ids.sort_unstable();
        twice("annotation", second(ids.into_iter()))?;

        let mut objects = Vec::with_capacity(self.rows.len());
        for row in self.rows {
            let lost = |what: &str, id: i64| {
                let place = format!("annotations[{}], annotation {}", row.idx, row.id);
                refuse(path, place, format!("its {what} {id} is not in the file"))
            };
            let image = index_of(&self.images, row.image_id, |image| image.id);
            let category = index_of(&self.categories, row.category_id, |category| category.id);
            objects.push(Object {
                id: row.id,
                image: image.ok_or_else(|| lost("image", row.image_id))?,
                category: category.ok_or_else(|| lost("category", row.category_id))?,
                box_px: row.box_px,
                area_px2: row.area_px2,
                kind: row.kind,
            });
        }
        let labels = LabelSet {
            images: self.images,
            categories: self.categories,
            objects,
        };
        labels.within_limits(path)
    }
}

fn row_of(path: &Path, record: &JsonRecord<'_>) -> Result<Row, EvalError> {
    let annotation: CocoAnnotation<WholeId, f64> = parse(path, record)?;
    let place = match annotation.id {
        Some(WholeId(id)) => format!("{}, annotation {id}", record.place()),
        None => record.place(),
    };
    let area_px2 = annotation.area.ok_or("it has no area".to_owned());
    let row = area_px2.and_then(|area_px2| {
        let object = annotation.object()?;
        Ok(Row {
            id: object.id.0,
            image_id: object.image_id.0,
            category_id: object.category_id.0,
            box_px: BoxPx::from_bbox(object.bbox_px),
            area_px2,
            kind: object.kind,
            idx: record.idx.unwrap_or(0),
        })
    });
    row.map_err(|reason| refuse(path, place, reason))
}

/// Of several categories of one name all but the first get their number behind it: a name stands for one
/// category in all that is reported.
fn tell_apart(categories: &mut [Category]) {
    let mut known = BTreeSet::new();
    for category in categories {
        while !known.insert(category.name.clone()) {
            category.name = format!("{} (id {})", category.name, category.id);
        }
    }
}

/// The first of these sorted numbers that occurs twice.
fn second(mut ids: impl Iterator<Item = i64>) -> Option<i64> {
    let mut last = ids.next()?;
    ids.find(|id| std::mem::replace(&mut last, *id) == *id)
}

#[cfg(test)]
mod tests {
    use super::{Category, tell_apart};

    #[test]
    fn no_two_categories_share_a_name_whatever_they_are_called() {
        let all = [(1, "car"), (2, "car (id 7)"), (7, "car"), (9, "bus")];
        let mut categories = all.map(|(id, name)| Category {
            id,
            name: name.to_owned(),
            supercategory: None,
        });
        tell_apart(&mut categories);
        let names = categories.map(|category| category.name);
        let expected = ["car", "car (id 7)", "car (id 7) (id 7)", "bus"];
        assert_eq!(names, expected, "each its own");
    }
}
