//! Labels of a set whose lens moves what images show.

use std::borrow::Cow;

use starbreak::Scene;
use starbreak::optics::lens_faults::MovedPlaces;
use starbreak_dataset::{FileRole, LabeledObject, PlaceMap, SourceFormat, SourceImage};

use super::Plan;
use super::survey::{is_state, is_stray};
use crate::Error;

/// Where the lens shows the places of frames of one size.
struct OfLens(Option<MovedPlaces>);

impl PlaceMap for OfLens {
    fn seen_at(&self, at: [f64; 2]) -> Option<[f64; 2]> {
        self.0
            .as_ref()
            .map_or(Some(at), |places| places.seen_at(at))
    }

    fn shown_at(&self, at: [f64; 2]) -> Option<[f64; 2]> {
        self.0
            .as_ref()
            .map_or(Some(at), |places| places.shown_at(at))
    }
}

impl Plan<'_> {
    /// Whether the source has labels, and the lens moves what they name.
    #[must_use]
    pub fn moves_labels(&self) -> bool {
        let format = self.source.format();
        !matches!(format, SourceFormat::Folder | SourceFormat::List)
            && self.context.settings.moves_labels()
    }

    /// Where the lens shows the places of frames of a size, px.
    pub(super) fn places(&self, size_px: (u32, u32)) -> Box<dyn PlaceMap> {
        let scene = Scene::of(&self.context.settings, size_px);
        Box::new(OfLens(scene.moved_places()))
    }

    /// The objects of an image where its damaged twin shows them.
    pub(super) fn objects_of<'i>(
        &self,
        image: &'i SourceImage,
    ) -> Result<Cow<'i, [LabeledObject]>, Error> {
        if !self.moves_labels() {
            return Ok(Cow::Borrowed(&image.objects));
        }
        let moved = self
            .source
            .moved_objects(image, &|size_px| self.places(size_px))?;
        Ok(Cow::Owned(moved))
    }

    /// Refuses labels that cannot be moved with what the lens moves, as far as it is known before the images are read, and
    /// files in which there may be more of them.
    pub(super) fn check_movable(&self) -> Result<(), Error> {
        if !self.moves_labels() {
            return Ok(());
        }
        let files = self.source.files().filter_map(Result::ok);
        for file in files.filter(|file| !is_state(&file.name)) {
            match file.role {
                FileRole::Index => {
                    let is_kept = &mut |image: &str| self.survey.is_of_set(image);
                    self.source.check_movable(&file, is_kept)?;
                }
                FileRole::Other if self.options.other_files.is_some() && !is_stray(&file) => {
                    return Err(Error::OtherFileStays { path: file.path });
                }
                FileRole::LabelOf(_) | FileRole::Other => {}
            }
        }
        Ok(())
    }

    /// Whether the labels in a file of one image are written: the image is taken, and can be asked for its size.
    pub(super) fn writes_moved(&self, image: &str) -> bool {
        let path = self.source.root().join(image);
        self.survey.is_selected(image) && starbreak_dataset::readable_size(&path).is_ok()
    }
}
