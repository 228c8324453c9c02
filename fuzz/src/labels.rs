use std::fs;
use std::path::Path;

use starbreak_eval::timeline::ClipTrack;
use starbreak_eval::{
    EvalError, GroundTruth, KittiLabels, LabelSet, Protocol, TrackedLabels, frames_of,
};

use crate::Vocabulary;

/// Words of labels, detections and tracks, and values that sit on an edge.
pub(crate) const VOCABULARY: Vocabulary = &[
    "\"images\":[",
    "\"annotations\":[",
    "\"categories\":[",
    "\"videos\":[",
    "\"frames\":[",
    "\"labels\":null",
    "{\"id\":1,\"file_name\":\"b.png\"}",
    "\"image_id\":1",
    "\"category_id\":1",
    "\"track_id\":1",
    "\"instance_id\":2",
    "\"video_id\":1",
    "\"frame_id\":1",
    "\"frame_index\":1000001",
    "\"frameIndex\":3",
    "\"videoName\":\"v\"",
    "\"frame_idx\":1",
    "\"time_s\":0.5",
    "\"state\":\"intact\"",
    "\"damage_onset\":null",
    "\"score\":0.5",
    "\"iscrowd\":true",
    "\"bbox\":[1,2,3,4]",
    "\"box2d\":{\"x1\":1,\"y1\":2,\"x2\":3,\"y2\":4}",
    "null",
    "[[[[",
    "]}",
    ",",
    "1e308",
    "-1e308",
    "1e400",
    "-0",
    "17.0",
    "nan",
    "inf",
    "NaN",
    "9223372036854775808",
    "999999",
    "DontCare",
    "Misc",
    "\n",
    "\r\n",
    "\u{feff}",
    "\u{202e}",
];

/// Labels of three images and two categories, to which detections are read.
const LABELS: &str = r#"{"images": [{"id": 1, "file_name": "a.png"}, {"id": 2, "file_name": "b.png"},
 {"id": 3, "file_name": "c.png"}], "categories": [{"id": 1, "name": "car"}, {"id": 7, "name": "person"}],
 "annotations": []}"#;

/// A file of labels or of detections is refused with one printable line, or what it says is of
/// images and categories that there are, in boxes that are boxes.
///
/// The first line says what the rest is: labels (`coco`, `bdd`, `kitti`) or detections in the images
/// a, b and c (`coco-dt`, `bdd-dt`, `kitti-dt`).
///
/// # Panics
/// If the input is a finding, or the folder of temporary files cannot be written.
pub fn labels(bytes: &[u8]) {
    let Some((kind, bytes)) = kind_of(bytes) else {
        return;
    };
    let dir = Folder::new();
    match kind {
        b"coco" => {
            let path = dir.put("labels.json", bytes);
            check_labels(LabelSet::read_coco(&path));
        }
        b"bdd" => {
            let path = dir.put("labels.json", bytes);
            check_labels(LabelSet::read_scalabel(&path));
        }
        b"kitti" => {
            dir.put("label_2/a.txt", bytes);
            let folder = dir.0.path().join("label_2");
            let read = KittiLabels::read(&folder, "").map(|labels| labels.set);
            for category in read.iter().flat_map(|labels| &labels.categories) {
                assert!(!category.name.contains('\u{feff}'), "{category:?}");
            }
            check_labels(read);
        }
        b"coco-dt" | b"bdd-dt" | b"kitti-dt" => {
            let path = match kind {
                b"kitti-dt" => {
                    for other in ["b", "c"] {
                        dir.put(&format!("data/{other}.txt"), b"");
                    }
                    dir.put("data/a.txt", bytes);
                    dir.0.path().join("data")
                }
                _ => dir.put("detections.json", bytes),
            };
            let truth = truth(kind == b"kitti-dt", &dir);
            match truth.read_detections(&path) {
                Ok(said) => {
                    for detection in &said.detections.items {
                        let is_there = (detection.image as usize) < truth.labels.images.len()
                            && (detection.category as usize) < truth.labels.categories.len();
                        assert!(is_there && detection.score.is_finite(), "{detection:?}");
                    }
                }
                Err(error) => check_message(&error),
            }
        }
        _ => {}
    }
}

/// Longest clip that labels are laid over, frames: more take no other way, only the time of many
/// inputs.
const MAX_FRAMES: u64 = 10_000;

/// A file of a clip is refused with one printable line, or its frames are in order and its labels
/// lie over them.
///
/// The first line says what the rest is: `track`, or labels with tracks: `coco`, `bdd`, `kitti`.
///
/// # Panics
/// If the input is a finding, or the folder of temporary files cannot be written.
pub fn timeline(bytes: &[u8]) {
    let Some((kind, bytes)) = kind_of(bytes) else {
        return;
    };
    let dir = Folder::new();
    let name = match kind {
        b"track" => {
            let path = dir.put("out.track.json", bytes);
            match ClipTrack::read(&path) {
                Ok(track) => {
                    let times: Vec<f64> = track.frames.iter().map(|it| it.frame.time_s).collect();
                    assert!(times.is_sorted_by(|a, b| a < b), "{times:?}");
                    let frames = frames_of(&track, Some("a"), &[], Protocol::Coco);
                    assert_eq!(frames.labels.images.len(), times.len(), "images of frames");
                }
                Err(error) => check_message(&error),
            }
            return;
        }
        b"coco" | b"bdd" => "labels.json",
        b"kitti" => "0000.txt",
        _ => return,
    };
    let tracked = match TrackedLabels::read(&dir.put(name, bytes), 0) {
        Ok(tracked) => tracked,
        Err(error) => return check_message(&error),
    };
    let labels = &tracked.truth.labels;
    assert_eq!(
        tracked.tracks.len(),
        labels.objects.len(),
        "a track for each object"
    );
    for clip in &tracked.clips {
        let highest = clip.frames.iter().filter_map(|frame| frame.number).max();
        let n_frames = highest.map_or(clip.frames.len() as u64, |last| last + 1);
        if n_frames > MAX_FRAMES {
            continue;
        }
        let laid =
            ClipTrack::plain(n_frames, 30.0, None).and_then(|track| tracked.of_clip(clip, &track));
        match laid {
            Ok(laid) => assert!(laid.labels.objects.len() <= labels.objects.len(), "no more"),
            Err(error) => check_message(&error),
        }
    }
}

fn kind_of(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let line = bytes.iter().position(|byte| *byte == b'\n')?;
    Some((&bytes[..line], &bytes[line + 1..]))
}

fn truth(is_kitti: bool, dir: &Folder) -> GroundTruth {
    let read = LabelSet::read_coco(&dir.put("truth.json", LABELS.as_bytes()));
    let labels = match read {
        Ok(labels) => labels,
        Err(error) => panic!("the labels of the target: {error}"),
    };
    let kitti = is_kitti.then(|| KittiLabels {
        set: labels.clone(),
        facts: Vec::new(),
    });
    GroundTruth {
        protocol: Protocol::Coco,
        labels,
        kitti,
        root: None,
    }
}

fn check_labels(read: Result<LabelSet, EvalError>) {
    let labels = match read {
        Ok(labels) => labels,
        Err(error) => return check_message(&error),
    };
    for object in &labels.objects {
        let is_there = (object.image as usize) < labels.images.len()
            && (object.category as usize) < labels.categories.len();
        assert!(is_there, "{object:?}");
        let corners = object.box_px.corners();
        let is_box = corners[0] <= corners[2] && corners[1] <= corners[3];
        assert!(
            is_box && corners.iter().all(|v| v.is_finite()),
            "{object:?}"
        );
    }
}

fn check_message(error: &EvalError) {
    let message = error.to_string();
    assert!(
        !message.contains(char::is_control) && !message.is_empty(),
        "a message that is not one printable line: {message:?}"
    );
}

/// A folder of temporary files.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        match tempfile::tempdir() {
            Ok(dir) => Self(dir),
            Err(error) => panic!("no folder: {error}"),
        }
    }

    fn put(&self, name: &str, bytes: &[u8]) -> std::path::PathBuf {
        let path = self.0.path().join(name);
        let folder = path.parent().unwrap_or(Path::new(""));
        if let Err(error) = fs::create_dir_all(folder).and_then(|()| fs::write(&path, bytes)) {
            panic!("cannot write {name}: {error}");
        }
        path
    }
}
