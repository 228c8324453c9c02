//! KITTI's tracking benchmark: `label_02/0000.txt`, one file per clip.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use starbreak_dataset::files_in;

use super::{LabeledClip, LabeledFrame, TrackedLabels};
use crate::json_record::{refuse, refuse_file};
use crate::labels::kitti::{category_of, rows};
use crate::timeline::MOST_FRAMES;
use crate::{BoxPx, EvalError, GroundTruth, LabelSet, ObjectKind, Protocol};

/// The types of the benchmark, which has `Person` where object detection has `Person_sitting`; a
/// type that is none of them is a category behind these.
const TYPES: [&str; 8] = [
    "Car",
    "Van",
    "Truck",
    "Pedestrian",
    "Person",
    "Cyclist",
    "Tram",
    "Misc",
];

/// Most objects of all clips.
const MOST_OBJECTS: usize = 10_000_000;

/// A line of a file.
struct Line {
    frame: u64,
    /// `None` of `DontCare`.
    track: Option<String>,
    name: String,
    box_px: BoxPx,
}

pub(super) fn read(path: &Path, first_idx: u64) -> Result<TrackedLabels, EvalError> {
    let files: Vec<(String, PathBuf)> = match files_in(path, "txt") {
        Ok(files) => files,
        Err(_) => {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            vec![(stem.into_owned(), path.to_owned())]
        }
    };
    if files.is_empty() {
        return Err(refuse_file(
            path,
            "it has no files 0000.txt; give the folder label_02 of KITTI's tracking benchmark, or one file of it",
        ));
    }
    let mut labels = LabelSet::default();
    for name in TYPES {
        category_of(&mut labels, name);
    }
    let mut read = Vec::new();
    for (name, file) in files {
        let lines = lines(&file, first_idx)?;
        for line in &lines {
            if line.track.is_some() {
                category_of(&mut labels, &line.name);
                labels.check_categories(&file)?;
            }
        }
        read.push((name, lines));
    }
    // Areas of no matter are crowds of every category: a detection in them counts for nothing.
    let all: Vec<u32> = (0..)
        .zip(&labels.categories)
        .map(|(place, _)| place)
        .collect();
    let (mut tracks, mut clips) = (Vec::new(), Vec::new());
    for (name, lines) in read {
        let mut by_frame = BTreeMap::<u64, Vec<Line>>::new();
        for line in lines {
            by_frame.entry(line.frame).or_default().push(line);
        }
        // Frames without a line hold no object: they are those of the clip, not of the highest number.
        let mut frames = Vec::new();
        for (idx, lines) in by_frame {
            let file = format!("{name}/{idx:06}.png");
            let image = labels.add_image(file, Some(name.clone()));
            frames.push(LabeledFrame {
                image,
                number: Some(idx),
            });
            for line in lines {
                let (categories, kind) = match line.track {
                    Some(_) => (
                        vec![category_of(&mut labels, &line.name)],
                        ObjectKind::Regular,
                    ),
                    None => (all.clone(), ObjectKind::Crowd),
                };
                if labels.objects.len() + categories.len() > MOST_OBJECTS {
                    let reason = format!(
                        "more than {MOST_OBJECTS} objects, DontCare counted once for each type; give fewer clips"
                    );
                    return Err(refuse_file(path, reason));
                }
                for category in categories {
                    labels.add_object(image, category, line.box_px, kind);
                    tracks.push(line.track.clone());
                }
            }
        }
        clips.push(LabeledClip {
            name: Some(name),
            frames,
            has_all_frames: true,
        });
    }
    Ok(TrackedLabels {
        truth: GroundTruth {
            protocol: Protocol::Coco,
            labels,
            kitti: None,
            root: None,
        },
        tracks,
        clips,
        has_image_ids: false,
    })
}

fn lines(path: &Path, first_idx: u64) -> Result<Vec<Line>, EvalError> {
    let rows = rows(path)?.into_iter();
    rows.map(|(place, row)| line(&row, first_idx).map_err(|reason| refuse(path, place, reason)))
        .collect()
}

/// `frame track type truncated occluded alpha x0 y0 x1 y1 …`, 17 fields.
fn line(row: &str, first_idx: u64) -> Result<Line, String> {
    let fields: Vec<&str> = row.split_ascii_whitespace().collect();
    let &[frame, track, name, _, _, _, x0, y0, x1, y1, ..] = fields.as_slice() else {
        return Err(format!("{} fields; expected 17", fields.len()));
    };
    if fields.len() != 17 {
        return Err(format!(
            "{} fields; labels of KITTI's tracking benchmark have 17 (frame, track, type, …)",
            fields.len()
        ));
    }
    let frame = frame
        .parse()
        .ok()
        .and_then(|idx: u64| idx.checked_sub(first_idx))
        .filter(|idx| *idx < MOST_FRAMES)
        .ok_or_else(|| {
            format!("the frame {frame:?} is no number from {first_idx} to {MOST_FRAMES}")
        })?;
    let mut corners_px = [f64::NAN; 4];
    for (corner, text) in corners_px.iter_mut().zip([x0, y0, x1, y1]) {
        let parsed = text.parse().ok().filter(|value: &f64| value.is_finite());
        *corner = parsed.ok_or_else(|| format!("the corner {text:?} is not a finite number"))?;
    }
    let box_px = BoxPx::from_corners(corners_px);
    if !box_px.is_sound() {
        return Err(format!(
            "the box {corners_px:?} px ends before it begins, or reaches beyond 1e9 px"
        ));
    }
    let is_area = ObjectKind::of_kitti_type(name) == ObjectKind::Ignored;
    let track = match (track.parse::<i64>(), is_area) {
        (Ok(_), true) => None,
        (Ok(number), false) if number >= 0 => Some(number.to_string()),
        _ => return Err(format!("the track {track:?} is no number from 0")),
    };
    Ok(Line {
        frame,
        track,
        name: name.to_owned(),
        box_px,
    })
}
