//! Results of KITTI that are called by the numbers of frames.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::labels::kitti::frame_files;
use crate::{EvalError, GroundTruth};

impl GroundTruth {
    /// The same frames under the numbers that the files of a folder of KITTI results have, and the
    /// number of the first; `None` where the files are called as the frames are, or not by numbers.
    ///
    /// Numbers count from 0, as in KITTI's tracking benchmark; from 1 where there is no 0 and the
    /// highest is the number of frames. The frames are those of [`frames_of`](crate::frames_of).
    ///
    /// # Errors
    /// [`EvalError::File`] and [`EvalError::Dataset`] for a folder without such files.
    pub fn numbered_as(&self, folder: &Path) -> Result<Option<(Self, u64)>, EvalError> {
        let files = match frame_files(&folder.join("data")) {
            Ok(files) => files,
            Err(_) => frame_files(folder)?,
        };
        let stem = |name: &str| match name.rsplit_once('.') {
            Some((stem, _)) => stem.to_owned(),
            None => name.to_owned(),
        };
        let images = &self.labels.images;
        let names: BTreeSet<String> = images.iter().map(|image| stem(&image.name)).collect();
        if files.iter().all(|(file, _)| names.contains(file)) {
            return Ok(None);
        }
        let mut numbers = BTreeMap::<u64, &str>::new();
        for (file, _) in &files {
            let is_number = file.bytes().all(|byte| byte.is_ascii_digit());
            match file.parse() {
                Ok(number) if is_number => numbers.insert(number, file),
                _ => return Ok(None),
            };
        }
        let highest = numbers.keys().next_back().copied();
        let is_from_1 = !numbers.contains_key(&0) && highest == Some(images.len() as u64);
        let first = u64::from(is_from_1);
        let mut numbered = self.clone();
        if let Some(kitti) = &mut numbered.kitti {
            for (number, image) in (first..).zip(&mut kitti.set.images) {
                // A frame without a file must not keep a name that is another's number.
                let file = numbers.get(&number).copied();
                image.name = file.map_or_else(|| format!("frame {number}"), str::to_owned);
            }
        }
        Ok(Some((numbered, first)))
    }
}
