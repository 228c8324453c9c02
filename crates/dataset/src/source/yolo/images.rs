//! The images that `data.yaml` names, in folders and lists.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Component, Path, PathBuf};

use super::data_file::DataFile;
use crate::error::DatasetError;
use crate::source::index::image_name;
use crate::source::lines::for_each_line;
use crate::source::name::{is_image_name, path_below};
use crate::source::record::BadRecord;
use crate::source::tree::Walk;

/// The folders and lists of a dataset, with their names in it.
#[derive(Debug)]
pub(super) struct Places {
    /// The folder of the dataset.
    pub(super) root: PathBuf,
    /// The name of `data.yaml` in the dataset.
    pub(super) data_name: String,
    /// The name of each path that `data.yaml` gives and that is there.
    pub(super) names: BTreeMap<String, String>,
    /// Names of folders with images.
    pub(super) folders: Vec<String>,
    /// Names of lists of images.
    pub(super) lists: Vec<String>,
    pub(super) bad: Vec<BadRecord>,
}

impl Places {
    /// Finds what the file at `data_path` names.
    pub(super) fn of(data_path: &Path, data: &DataFile) -> Result<Self, String> {
        let file_name = data_path.file_name().and_then(|name| name.to_str());
        let file_name = file_name.ok_or("its name is not UTF-8; rename it")?;
        let beside = match data_path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        // Paths begin at `path`; where it leads nowhere, as after a move, beside the file.
        let base = data.base.as_ref().map(|base| beside.join(&base.text));
        let base = base.filter(|base| base.is_dir());
        let base = base.unwrap_or_else(|| beside.to_owned());
        let (root, data_name) = match (inside(beside, &base), inside(&base, beside)) {
            (Some(_), _) => (beside.to_owned(), file_name.to_owned()),
            (None, Some(folder)) if !folder.is_empty() => {
                (base.clone(), format!("{folder}/{file_name}"))
            }
            _ => (base.clone(), file_name.to_owned()),
        };
        let mut places = Self {
            root,
            data_name,
            names: BTreeMap::new(),
            folders: Vec::new(),
            lists: Vec::new(),
            bad: Vec::new(),
        };
        for (part, values) in &data.parts {
            for value in values {
                if let Err(reason) = places.add(&base, &value.text) {
                    let place = format!("{}: {part}", places.data_name);
                    places.bad.push(BadRecord::new(place, reason));
                }
            }
        }
        if places.folders.is_empty() && places.lists.is_empty() {
            let first = places.bad.first().map(|bad| bad.reason.as_str());
            let first = first.unwrap_or("they are empty");
            return Err(format!("none of train, val and test is there: {first}"));
        }
        Ok(places)
    }

    fn add(&mut self, base: &Path, text: &str) -> Result<(), String> {
        let path = base.join(text);
        // Some exports lead one folder too far out.
        let nearer = text.strip_prefix("../").map(|text| base.join(text));
        let found = [Some(path), nearer]
            .into_iter()
            .flatten()
            .find_map(|path| Some((fs::metadata(&path).ok()?, path)));
        let (metadata, path) = found.ok_or_else(|| format!("there is no {text:?}"))?;
        let name = inside(&self.root, &path)
            .ok_or_else(|| format!("{text:?} is outside the folder of the dataset"))?;
        if metadata.is_dir() {
            self.folders.push(name.clone());
        } else {
            self.lists.push(name.clone());
        }
        self.names.insert(text.to_owned(), name);
        Ok(())
    }

    /// All images, in the order of their names, each once.
    pub(super) fn images(&mut self) -> Result<Vec<String>, DatasetError> {
        let mut images = Vec::new();
        for folder in &self.folders {
            let prefix = if folder.is_empty() {
                String::new()
            } else {
                format!("{folder}/")
            };
            for found in Walk::below(&path_below(&self.root, folder), &prefix) {
                match found.file {
                    Ok(_) if is_image_name(&found.name) => images.push(found.name),
                    Err(bad) if is_image_name(&found.name) || found.is_folder => self.bad.push(bad),
                    _ => {}
                }
            }
        }
        for list in &self.lists {
            let mut of_list = BTreeMap::new();
            for_each_line(&path_below(&self.root, list), |line| {
                let place = || format!("{list}:{}", line.number);
                let name = line.text.map_err(str::to_owned);
                match name.and_then(|text| name_of_line(&self.root, list, text)) {
                    Ok(None) => {}
                    Ok(Some(name)) if of_list.contains_key(&name) => {
                        let reason = format!("{name:?} is listed twice");
                        self.bad
                            .push(BadRecord::new(place(), reason).of_image(&name));
                    }
                    Ok(Some(name)) => {
                        of_list.insert(name, ());
                    }
                    Err(reason) => self.bad.push(BadRecord::new(place(), reason)),
                }
                Ok(())
            })?;
            images.extend(of_list.into_keys());
        }
        images.sort_unstable();
        images.dedup();
        Ok(images)
    }
}

/// The name of the image in a line of a list; nothing for an empty line.
///
/// Paths are relative to the folder of the list or, where nothing is there, to the dataset.
pub(super) fn name_of_line(root: &Path, list: &str, text: &str) -> Result<Option<String>, String> {
    let text = text.trim();
    if text.is_empty() || text.starts_with('#') {
        return Ok(None);
    }
    if text.contains(['\\', '\0']) {
        return Err(format!(
            "the name {text:?} holds a backslash or a NUL character"
        ));
    }
    let folder = path_below(root, list.rsplit_once('/').map_or("", |(folder, _)| folder));
    let beside = folder.join(text);
    let path = if beside.exists() {
        beside
    } else {
        root.join(text)
    };
    let name = inside(root, &path)
        .ok_or_else(|| format!("{text:?} is outside the folder of the dataset"))?;
    image_name(&name).map(Some)
}

/// The name of a path below a folder, by its parts or else with links resolved; empty for the
/// folder itself.
pub(super) fn inside(folder: &Path, path: &Path) -> Option<String> {
    let by_parts = name_below(&normal(folder), &normal(path));
    by_parts.or_else(|| {
        // The last part is kept, for it may be a link that leads out.
        let parent = fs::canonicalize(path.parent()?).ok()?;
        let path = match path.file_name() {
            Some(last) => parent.join(last),
            None => fs::canonicalize(path).ok()?,
        };
        name_below(&fs::canonicalize(folder).ok()?, &path)
    })
}

fn name_below(folder: &Path, path: &Path) -> Option<String> {
    let parts: Option<Vec<&str>> = path
        .strip_prefix(folder)
        .ok()?
        .iter()
        .map(|p| p.to_str())
        .collect();
    parts.map(|parts| parts.join("/"))
}

/// The absolute path without `.` and `..`, by its parts alone.
fn normal(path: &Path) -> PathBuf {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let mut normal = PathBuf::new();
    for part in absolute.components() {
        match part {
            Component::ParentDir => {
                normal.pop();
            }
            Component::CurDir => {}
            other => normal.push(other),
        }
    }
    normal
}
