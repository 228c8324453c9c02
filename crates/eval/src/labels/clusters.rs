//! Which images are not independent of each other.

use std::collections::BTreeMap;
use std::path::Path;

use starbreak_dataset::{files_in, read_text};

use super::LabelSet;
use crate::EvalError;
use crate::json_record::{refuse, refuse_file};

/// Longest file of a mapping, in bytes; KITTI's has half a megabyte.
const MAX_BYTES: u64 = 64 << 20;

/// The files of KITTI's development kit, in its folder `mapping`.
const MAPPING: &str = "train_mapping.txt";
const ORDER: &str = "train_rand.txt";

impl LabelSet {
    /// Says of each image which clip, drive or scene it is of, so that statistics draw these and not
    /// single images: by a folder `mapping` of KITTI's development kit
    /// (`train_mapping.txt` and `train_rand.txt`), or by a CSV file of lines `image,cluster` with the name of
    /// an image as in the labels, or its last part, with or without extension, where that is unique.
    /// Fields may stand in quotes; lines of other images say nothing.
    ///
    /// # Errors
    /// [`EvalError::Dataset`] where it cannot be read, [`EvalError::Record`] for a line that is not of
    /// two fields, [`EvalError::File`] for an image that it lacks or has twice.
    pub fn read_clusters(&mut self, path: &Path) -> Result<(), EvalError> {
        if files_in(path, "txt").is_ok() {
            return self.read_drives(path);
        }
        let text = read_text(path, MAX_BYTES)?.text;
        let mut by_name: BTreeMap<&str, &str> = BTreeMap::new();
        let text = text.trim_start_matches('\u{feff}');
        for (idx, line) in text.lines().enumerate() {
            let fields = line.rsplit_once(',');
            let fields = fields.map(|(name, cluster)| (bare(name), bare(cluster)));
            if line.trim().is_empty() || (idx == 0 && fields == Some(("image", "cluster"))) {
                continue;
            }
            let Some((name, cluster)) = fields.filter(|(a, b)| !a.is_empty() && !b.is_empty())
            else {
                let reason = format!("{line:?} is not image,cluster");
                return Err(refuse(path, format!("line {}", idx + 1), reason));
            };
            if by_name.insert(name, cluster).is_some() {
                return Err(refuse_file(path, format!("it has {name:?} twice")));
            }
        }
        let mut n_of_stem: BTreeMap<String, u32> = BTreeMap::new();
        for image in &self.images {
            *n_of_stem.entry(stem(&image.name).to_owned()).or_default() += 1;
        }
        for image in &mut self.images {
            let last = last_part(&image.name);
            let stem = stem(&image.name);
            let alone = || {
                let is_unique = n_of_stem.get(stem) == Some(&1);
                let found = by_name.get(last).or_else(|| by_name.get(stem));
                found.filter(|_| is_unique)
            };
            let found = by_name.get(image.name.as_str()).or_else(alone);
            let Some(cluster) = found else {
                let reason = format!("it lacks the image {:?}", image.name);
                return Err(refuse_file(path, reason));
            };
            image.cluster = Some((*cluster).to_owned());
        }
        Ok(())
    }

    /// Says of each frame of KITTI's training data which drive it is of, by the folder `mapping` of
    /// the development kit: `train_rand.txt` has, separated by commas, for each frame the line of
    /// `train_mapping.txt`, from 1, on which its day, drive and number stand.
    ///
    /// # Errors
    /// [`EvalError::Dataset`] where the files cannot be read, [`EvalError::Record`] for what is no
    /// such line, [`EvalError::File`] for a frame that they lack.
    fn read_drives(&mut self, mapping: &Path) -> Result<(), EvalError> {
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
            let frame: Option<usize> = stem(&image.name).parse().ok();
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

/// A field without its quotes.
fn bare(field: &str) -> &str {
    let field = field.trim();
    let inside = field
        .strip_prefix('"')
        .and_then(|rest| rest.strip_suffix('"'));
    inside.unwrap_or(field)
}

/// The last part of a name without its extension.
fn stem(name: &str) -> &str {
    let last = last_part(name);
    last.rsplit_once('.').map_or(last, |(stem, _)| stem)
}

fn last_part(name: &str) -> &str {
    name.rsplit('/').next().unwrap_or(name)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test may panic")]

    use crate::{LabelSet, LabeledImage};

    fn labels_of(names: &[&str]) -> LabelSet {
        let image = |name: &&str| LabeledImage {
            id: 1,
            name: (*name).to_owned(),
            width_px: None,
            height_px: None,
            cluster: None,
        };
        LabelSet {
            images: names.iter().map(image).collect(),
            ..LabelSet::default()
        }
    }

    #[test]
    fn an_image_is_of_the_cluster_on_its_line() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("clusters.csv");
        let read = |text: &str, names: &[&str]| {
            std::fs::write(&file, text).unwrap();
            let mut labels = labels_of(names);
            let read = labels.read_clusters(&file);
            read.map(|()| {
                labels
                    .images
                    .iter()
                    .filter_map(|i| i.cluster.clone())
                    .collect::<Vec<_>>()
            })
            .map_err(|error| error.to_string())
        };
        let names = ["a/1.png", "b/1.png", "b/2.png"];
        let text = "image,cluster\nb/1.png, two\na/1.png,one\n\n2.png,two\n";
        assert_eq!(
            read(text, &names).unwrap(),
            ["one", "two", "two"],
            "by name"
        );
        let text =
            "\u{feff}\"image\",\"cluster\"\r\n\"b/1.png\",\"two\"\r\na/1.png,one\r\n2,two\r\n";
        assert_eq!(
            read(text, &names).unwrap(),
            ["one", "two", "two"],
            "as spreadsheets write"
        );
        for (text, named) in [
            ("1.png,x\n2.png,y\n", "a/1.png"),
            ("a/1.png,x\na/1.png,y\n", "twice"),
            ("a/1.png\n", "line 1"),
            ("a/1.png,\n", "line 1"),
        ] {
            let error = read(text, &names).unwrap_err();
            assert!(error.contains(named), "{error} names {named}");
        }
    }

    #[test]
    fn a_frame_is_of_the_drive_on_its_line() {
        let dir = tempfile::tempdir().unwrap();
        let mapping = "2011_09_26 2011_09_26_drive_0005_sync 0000000109\n2011_09_28 2011_09_28_drive_0001_sync 0000000003\n";
        std::fs::write(dir.path().join("train_mapping.txt"), mapping).unwrap();
        std::fs::write(dir.path().join("train_rand.txt"), "2, 1,2\n").unwrap();
        let mut labels = labels_of(&["image_2/000000.png", "training/image_2/000001.png"]);
        labels.read_drives(dir.path()).unwrap();
        let drives: Vec<_> = labels.images.iter().map(|i| i.cluster.as_deref()).collect();
        let expected = [
            Some("2011_09_28_drive_0001_sync"),
            Some("2011_09_26_drive_0005_sync"),
        ];
        assert_eq!(drives, expected, "by the order of the kit");
        labels
            .images
            .extend(labels_of(&["image_2/000003.png"]).images);
        let error = labels.read_drives(dir.path()).unwrap_err().to_string();
        assert!(error.contains("000003"), "{error}");
    }
}
