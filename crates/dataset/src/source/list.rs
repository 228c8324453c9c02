//! A text list: one image per line, relative to the folder of the list.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use super::index::{image_name, second_of_case, seconds};
use super::lines::for_each_line;
use super::name::path_below;
use super::record::{BadRecord, FileRole, SourceFile, SourceImage};
use super::tree::differs_in_case;
use super::{Images, Layout, SourceFormat, SourceSpec, is_file, no_index};
use crate::error::DatasetError;

#[derive(Debug)]
pub(super) struct List {
    /// The name of the list itself.
    own_files: [String; 1],
    /// Names with the numbers of their lines, in the order of the names.
    images: Vec<(String, usize)>,
    bad: Vec<BadRecord>,
}

impl List {
    /// The folder of the list and what the list says.
    pub(super) fn open(spec: &SourceSpec) -> Result<(PathBuf, Self), DatasetError> {
        let (root, file) = super::root_and_name(spec, &[])?;
        let mut images = Vec::new();
        let mut bad = Vec::new();
        let place_of = |number: usize| format!("{file}:{number}");
        for_each_line(&spec.path, |line| {
            match line.text.map_err(str::to_owned).and_then(name_of_line) {
                Ok(Some(name)) => images.push((name, line.number)),
                Ok(None) => {}
                Err(reason) => bad.push(BadRecord::new(place_of(line.number), reason)),
            }
            Ok(())
        })?;
        let mut refuse = |name: &str, number: usize, reason: String| {
            bad.push(BadRecord::new(place_of(number), reason).of_image(name));
        };
        let mut idx = 0;
        let twice = seconds(&images, |(name, _)| name);
        images.retain(|(name, number)| {
            let is_kept = !twice.contains(&idx);
            idx += 1;
            if !is_kept {
                refuse(name, *number, format!("{name:?} is listed twice"));
            }
            is_kept
        });
        images.sort_unstable();
        let name_of = |idx: usize| images.get(idx).map_or("", |(name, _)| name.as_str());
        let all: Vec<usize> = (0..images.len()).collect();
        let collisions: BTreeMap<usize, String> = second_of_case(&all, name_of)
            .into_iter()
            .map(|(second, first)| (second, differs_in_case(name_of(first))))
            .collect();
        let mut idx = 0;
        images.retain(|(name, number)| {
            let collision = collisions.get(&idx);
            idx += 1;
            if let Some(reason) = collision {
                refuse(name, *number, format!("{name:?}: {reason}"));
            }
            collision.is_none()
        });
        let list = Self {
            own_files: [file],
            images,
            bad,
        };
        Ok((root, list))
    }
}

/// The name in a line; nothing for an empty line or a comment.
fn name_of_line(line: &str) -> Result<Option<String>, String> {
    if line.is_empty() || line.starts_with('#') {
        return Ok(None);
    }
    image_name(line).map(Some)
}

impl Layout for List {
    fn images<'a>(&'a self, root: &'a Path) -> Images<'a> {
        let [file] = &self.own_files;
        let images = self.images.iter().map(move |(name, number)| {
            let path = path_below(root, name);
            match is_file(&path) {
                Ok(()) => Ok(SourceImage {
                    name: name.clone(),
                    path,
                    objects: Vec::new(),
                    problems: Vec::new(),
                }),
                Err(reason) => {
                    let reason = format!("image {name:?}: {reason}");
                    Err(BadRecord::new(format!("{file}:{number}"), reason).of_image(name))
                }
            }
        });
        Box::new(self.bad.iter().cloned().map(Err).chain(images))
    }

    fn has_image(&self, name: &str) -> bool {
        let found = self
            .images
            .binary_search_by(|(known, _)| known.as_str().cmp(name));
        found.is_ok()
    }

    fn role(&self, _: &Path, name: &str) -> FileRole {
        match self.own_files.iter().any(|own| own == name) {
            true => FileRole::Index,
            false => FileRole::Other,
        }
    }

    fn own_files(&self) -> Option<&[String]> {
        Some(&self.own_files)
    }

    fn subset(
        &self,
        file: &SourceFile,
        is_kept: &mut dyn FnMut(&str) -> bool,
        out: &mut dyn Write,
    ) -> Result<(), DatasetError> {
        if !self.own_files.contains(&file.name) {
            return Err(no_index(file, SourceFormat::List));
        }
        let mut kept: BTreeMap<usize, &str> = self
            .images
            .iter()
            .filter(|(name, _)| is_kept(name))
            .map(|(name, number)| (*number, name.as_str()))
            .collect();
        for_each_line(&file.path, |line| {
            let is_kept = match line.text.map_err(str::to_owned).and_then(name_of_line) {
                Ok(None) => true,
                // A line that is not the one that was read stays to be missed below.
                Ok(Some(name)) if kept.get(&line.number) == Some(&name.as_str()) => {
                    kept.remove(&line.number).is_some()
                }
                _ => false,
            };
            match is_kept {
                true => out
                    .write_all(line.bytes)
                    .map_err(|e| super::subset_error(file, e)),
                false => Ok(()),
            }
        })?;
        match kept.is_empty() {
            true => Ok(()),
            false => Err(super::changed(&file.path, SourceFormat::List)),
        }
    }
}
