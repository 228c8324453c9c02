//! Which images are not independent of each other.

use std::path::Path;

use starbreak_dataset::read_text;

use super::LabelSet;
use crate::EvalError;
use crate::json_record::{refuse, refuse_file};

/// Longest file of a mapping, in bytes; KITTI's has half a megabyte.
const MAX_BYTES: u64 = 64 << 20;

/// The files of KITTI's development kit, in its folder `mapping`.
const MAPPING: &str = "train_mapping.txt";
const ORDER: &str = "train_rand.txt";

impl LabelSet {
    /// Says of each frame of KITTI's training data which drive it is of, by the folder `mapping` of
    /// the development kit: `train_rand.txt` has, separated by commas, for each frame the line of
    /// `train_mapping.txt`, from 1, on which its day, drive and number stand.
    ///
    /// # Errors
    /// [`EvalError::Dataset`] where the files cannot be read, [`EvalError::Record`] for what is no
    /// such line, [`EvalError::File`] for a frame that they lack.
    pub fn read_drives(&mut self, mapping: &Path) -> Result<(), EvalError> {
        let order_path = mapping.join(ORDER);
        let lines_path = mapping.join(MAPPING);
        let order = read_text(&order_path, MAX_BYTES)?.text;
        let lines = read_text(&lines_path, MAX_BYTES)?.text;
        let mut order_of_frames = Vec::new();
        for (idx, text) in order.split(',').enumerate() {
            let text = text.trim();
            let line: Option<usize> = text.parse().ok().filter(|line| *line > 0);
            let wrong = || {
                let reason = format!("{text:?} is not the number of a line, from 1");
                refuse(&order_path, format!("number [{idx}]"), reason)
            };
            order_of_frames.push(line.ok_or_else(wrong)?);
        }
        let lines: Vec<&str> = lines.lines().collect();
        for image in &mut self.images {
            let file = image.name.rsplit('/').next().unwrap_or(&image.name);
            let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
            let frame: Option<usize> = stem.parse().ok();
            let line = frame.and_then(|frame| order_of_frames.get(frame));
            let Some(line) = line else {
                let reason = format!("it lacks the frame {:?}; leave the mapping out", image.name);
                return Err(refuse_file(&order_path, reason));
            };
            let text = lines.get(line - 1).copied().unwrap_or("");
            let Some(drive) = text.split_ascii_whitespace().nth(1) else {
                let reason = format!("{text:?} is not day, drive and number");
                return Err(refuse(&lines_path, format!("line {line}"), reason));
            };
            image.cluster = Some(drive.to_owned());
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test may panic")]

    use crate::{LabelSet, LabeledImage};

    #[test]
    fn a_frame_is_of_the_drive_on_its_line() {
        let dir = tempfile::tempdir().unwrap();
        let mapping = "2011_09_26 2011_09_26_drive_0005_sync 0000000109\n2011_09_28 2011_09_28_drive_0001_sync 0000000003\n";
        std::fs::write(dir.path().join("train_mapping.txt"), mapping).unwrap();
        std::fs::write(dir.path().join("train_rand.txt"), "2, 1,2\n").unwrap();
        let image = |name: &str| LabeledImage {
            id: 1,
            name: name.to_owned(),
            width_px: None,
            height_px: None,
            cluster: None,
        };
        let mut labels = LabelSet {
            images: ["image_2/000000.png", "training/image_2/000001.png"]
                .map(image)
                .into(),
            ..LabelSet::default()
        };
        labels.read_drives(dir.path()).unwrap();
        let drives: Vec<_> = labels.images.iter().map(|i| i.cluster.as_deref()).collect();
        let expected = [
            Some("2011_09_28_drive_0001_sync"),
            Some("2011_09_26_drive_0005_sync"),
        ];
        assert_eq!(drives, expected, "by the order of the kit");
        labels.images.push(image("image_2/000003.png"));
        let error = labels.read_drives(dir.path()).unwrap_err().to_string();
        assert!(error.contains("000003"), "{error}");
    }
}
