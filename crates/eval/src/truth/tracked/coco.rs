//! MS-COCO with tracks, as of TAO and CocoVID.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;
use serde::de::IgnoredAny;
use starbreak_dataset::{JsonRecord, WholeId, read_json_records};

use super::{LabeledClip, LabeledFrame, TrackedLabels, in_order, number};
use crate::json_record::{parse, refuse};
use crate::{EvalError, GroundTruth, LabelSet, Protocol};

#[derive(Deserialize)]
struct ImageRecord {
    id: WholeId,
    #[serde(default)]
    video_id: Option<WholeId>,
    #[serde(default)]
    frame_id: Option<WholeId>,
    #[serde(default)]
    frame_index: Option<WholeId>,
}

#[derive(Deserialize)]
struct AnnotationRecord {
    id: WholeId,
    #[serde(default)]
    track_id: Option<WholeId>,
    #[serde(default)]
    instance_id: Option<WholeId>,
}

#[derive(Deserialize)]
struct VideoRecord {
    id: WholeId,
    #[serde(default)]
    name: Option<String>,
}

/// What a file says of clips and tracks, beyond what every file of MS-COCO says.
#[derive(Default)]
struct Beyond {
    /// Clip and number of each image.
    images: BTreeMap<i64, (Option<i64>, Option<i64>)>,
    /// Track of each annotation.
    tracks: BTreeMap<i64, i64>,
    /// Names of clips.
    videos: BTreeMap<i64, String>,
    /// The clip of each name.
    named: BTreeMap<String, i64>,
}

impl Beyond {
    fn take(&mut self, path: &Path, record: &JsonRecord<'_>) -> Result<(), EvalError> {
        match (record.key, record.idx) {
            ("images", Some(_)) => {
                let image: ImageRecord = parse(path, record)?;
                let idx = image.frame_id.or(image.frame_index).map(|idx| idx.0);
                let video = image.video_id.map(|video| video.0);
                self.images.insert(image.id.0, (video, idx));
            }
            ("annotations", Some(_)) => {
                let annotation: AnnotationRecord = parse(path, record)?;
                if let Some(track) = annotation.track_id.or(annotation.instance_id) {
                    self.tracks.insert(annotation.id.0, track.0);
                }
            }
            ("videos", Some(_)) => {
                let video: VideoRecord = parse(path, record)?;
                let name = video.name.unwrap_or_else(|| video.id.0.to_string());
                let id = self.named.entry(name.clone()).or_insert(video.id.0);
                if *id != video.id.0 {
                    let place = format!("video {}", video.id.0);
                    let reason = format!(
                        "its name {name:?} is that of video {id}, too; give each video its own name"
                    );
                    return Err(refuse(path, place, reason));
                }
                if self.videos.insert(video.id.0, name).is_some() {
                    let place = format!("video {}", video.id.0);
                    return Err(refuse(path, place, "the id occurs twice"));
                }
            }
            _ => {
                parse::<IgnoredAny>(path, record)?;
            }
        }
        Ok(())
    }
}

pub(super) fn read(path: &Path, first_idx: u64) -> Result<TrackedLabels, EvalError> {
    // Two passes: what every file of MS-COCO has is read as always.
    let labels = LabelSet::read_coco(path)?;
    let mut beyond = Beyond::default();
    read_json_records(path, |record| beyond.take(path, &record))?;
    let mut clips = BTreeMap::<Option<String>, Vec<LabeledFrame>>::new();
    for (place, image) in (0..).zip(&labels.images) {
        let (video, idx) = beyond.images.get(&image.id).copied().unwrap_or_default();
        let clip = match video {
            None => None,
            Some(video) => match beyond.videos.get(&video) {
                Some(name) => Some(name.clone()),
                None if beyond.videos.is_empty() => Some(video.to_string()),
                None => {
                    let place = format!("image {}", image.id);
                    let reason = format!("its video {video} is not in the file");
                    return Err(refuse(path, place, reason));
                }
            },
        };
        let number = idx
            .map(|idx| number(path, &image.name, idx, first_idx))
            .transpose()?;
        clips.entry(clip).or_default().push(LabeledFrame {
            image: place,
            number,
        });
    }
    let clips: Vec<LabeledClip> = in_order(path, clips)?;
    let tracks = labels.objects.iter();
    Ok(TrackedLabels {
        tracks: tracks
            .map(|object| beyond.tracks.get(&object.id).map(i64::to_string))
            .collect(),
        truth: GroundTruth {
            protocol: Protocol::Coco,
            labels,
            kitti: None,
            root: None,
        },
        clips,
        has_image_ids: true,
    })
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test may panic")]

    use super::read;

    #[test]
    fn two_videos_of_one_name_are_named() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("labels.json");
        let videos = r#"[{"id": 1, "name": "a"}, {"id": 5, "name": "a"}]"#;
        let images =
            r#"[{"id": 1, "video_id": 1, "frame_id": 0}, {"id": 2, "video_id": 5, "frame_id": 0}]"#;
        let text = format!(
            r#"{{"videos": {videos}, "images": {images}, "annotations": [], "categories": []}}"#
        );
        std::fs::write(&path, text).unwrap();
        let error = read(&path, 0).unwrap_err().to_string();
        for word in ["video 5", "\"a\"", "video 1", "its own name"] {
            assert!(error.contains(word), "{word}: {error}");
        }
    }
}
