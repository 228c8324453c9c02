//! The categories that detections speak of, where no labels say which there are.

use std::collections::BTreeSet;
use std::path::Path;

use serde::Deserialize;
use starbreak_dataset::{WholeId, files_in, read_json_records};

use crate::json_record::parse;
use crate::labels::kitti::{frame_files, lines};
use crate::labels::scalabel::{for_each_frame, for_each_label};
use crate::truth::open::is_scalabel;
use crate::{Category, EvalError};

#[derive(Deserialize)]
struct ResultRecord {
    category_id: WholeId,
}

/// The categories in files of detections: by name where they have names (Scalabel, KITTI), else
/// `category N` for each number N of results of MS-COCO, in the order of numbers.
///
/// # Errors
/// [`EvalError::Rule`] for files of both kinds, and the errors of their readers.
pub fn said_categories(paths: &[&Path]) -> Result<Vec<Category>, EvalError> {
    let (mut names, mut ids) = (BTreeSet::<String>::new(), BTreeSet::<i64>::new());
    for path in paths {
        if files_in(path, "txt").is_ok() {
            let data = path.join("data");
            let files = frame_files(&data).or_else(|_| frame_files(path))?;
            for (_, file) in files {
                for line in lines(&file)? {
                    names.insert(line?.row.category);
                }
            }
        } else if is_scalabel(path)? {
            for_each_frame(path, |frame, at| {
                for_each_label(path, frame, at, |label| {
                    names.extend(label.class().map(str::to_owned));
                    Ok(())
                })
            })?;
        } else {
            read_json_records(path, |record| {
                let result: ResultRecord = parse(path, &record)?;
                ids.insert(result.category_id.0);
                Ok::<(), EvalError>(())
            })?;
        }
    }
    if !names.is_empty() && !ids.is_empty() {
        return Err(EvalError::Rule(
            "the clean and the cracked detections are of two forms, one with names of categories and one with numbers; give both in one form".to_owned(),
        ));
    }
    let named = (1..).zip(names);
    let numbered = ids.into_iter().map(|id| (id, format!("category {id}")));
    Ok(named
        .chain(numbered)
        .map(|(id, name)| Category {
            id,
            name,
            supercategory: None,
        })
        .collect())
}
