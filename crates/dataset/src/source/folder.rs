//! A plain folder: all images below it, without labels.

use std::io::Write;
use std::path::Path;

use super::name::is_image_name;
use super::record::{FileRole, SourceFile, SourceImage};
use super::tree::{Found, Walk};
use super::{Images, Layout, SourceFormat, no_index};
use crate::error::DatasetError;

#[derive(Debug)]
pub(super) struct Folder {
    /// Whether links may lead out of it.
    pub(super) follows_links: bool,
}

impl Layout for Folder {
    fn images<'a>(&'a self, root: &'a Path) -> Images<'a> {
        let found = self.walk(root).filter(|found| self.hides_images(found));
        Box::new(found.map(|Found { name, file, .. }| match file {
            Ok(path) => Ok(SourceImage {
                name,
                path,
                objects: Vec::new(),
                problems: Vec::new(),
            }),
            Err(bad) if is_image_name(&name) => Err(bad.of_image(&name)),
            Err(bad) => Err(bad),
        }))
    }

    fn walk(&self, root: &Path) -> Walk {
        match self.follows_links {
            true => Walk::below(root, ""),
            false => Walk::inside(root),
        }
    }

    fn hides_images(&self, found: &Found) -> bool {
        found.is_folder || is_image_name(&found.name)
    }

    fn has_image(&self, name: &str) -> bool {
        is_image_name(name)
    }

    fn role(&self, _: &Path, _: &str) -> FileRole {
        FileRole::Other
    }

    fn subset(
        &self,
        file: &SourceFile,
        _: &mut dyn FnMut(&str) -> bool,
        _: &mut dyn Write,
    ) -> Result<(), DatasetError> {
        Err(no_index(file, SourceFormat::Folder))
    }
}
