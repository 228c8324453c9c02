//! Frames in the form of Scalabel whose images are moved.

use std::collections::BTreeSet;

use serde::Deserialize;
use serde_json::json;
use serde_json::value::RawValue;

use super::id::Id;
use super::moved::{MovedFrame, hundredth};
use super::scalabel_row::ScalabelLabel;
use crate::json_records::JsonMembers;

/// The members of a label with places that are moved.
const PLACES: [&str; 2] = ["box2d", "poly2d"];

/// Those that cannot be moved.
const FIXED: [&str; 3] = ["rle", "box3d", "graph"];

/// A line or an outline; what else it says stays as it is.
#[derive(Deserialize)]
struct Line {
    vertices: Vec<[f64; 2]>,
}

/// A label, of which all that has places is understood.
struct Places<'a> {
    members: JsonMembers<'a>,
    corners_px: Option<[f64; 4]>,
    lines: Vec<(JsonMembers<'a>, Vec<[f64; 2]>)>,
}

impl<'a> Places<'a> {
    /// The places of a label whose box was read; what of it cannot be moved where there is such.
    fn of(text: &'a str, corners_px: Option<[f64; 4]>) -> Result<Self, String> {
        let members: JsonMembers<'a> =
            serde_json::from_str(text).map_err(|error| error.to_string())?;
        if let Some(key) = FIXED.iter().find(|key| members.get(key).is_some()) {
            return Err(format!("its {key}"));
        }
        if let Some(key) = members.other_with_numbers(&PLACES) {
            return Err(format!("its {key}, whose numbers may be places,"));
        }
        let lines = members.get("poly2d").map(|lines| {
            let lines: Vec<&RawValue> = serde_json::from_str(lines.get())?;
            let line = |line: &&'a RawValue| {
                let Line { vertices } = serde_json::from_str(line.get())?;
                if vertices.as_flattened().iter().any(|at| at.abs() > 1e9) {
                    return Err(serde::de::Error::custom("beyond 1e9 px"));
                }
                Ok((serde_json::from_str(line.get())?, vertices))
            };
            lines.iter().map(line).collect()
        });
        let lines = lines.transpose().map_err(
            |_: serde_json::Error| "its poly2d, which is none or reaches beyond 1e9 px,",
        )?;
        Ok(Self {
            members,
            corners_px,
            lines: lines.unwrap_or_default(),
        })
    }

    /// The label with its places moved; none where nothing of it is left in the frame.
    fn moved(&self, frame: &MovedFrame) -> Option<String> {
        let mut replaced = Vec::new();
        if let Some(corners_px) = self.corners_px {
            let [x1, y1, x2, y2] = frame.box_px(corners_px)?.corners_px;
            let box2d: JsonMembers<'_> =
                serde_json::from_str(self.members.get("box2d")?.get()).ok()?;
            let corners = [("x1", x1), ("y1", y1), ("x2", x2), ("y2", y2)];
            let corners = corners.map(|(key, at)| (key, json!(at).to_string()));
            replaced.push(("box2d", box2d.with(&corners)));
        }
        let mut vertices = self
            .lines
            .iter()
            .flat_map(|(_, vertices)| vertices)
            .peekable();
        let is_line = self.corners_px.is_none() && vertices.peek().is_some();
        if is_line && vertices.all(|at| frame.point(*at).is_none()) {
            return None;
        }
        if self.members.get("poly2d").is_some() {
            let line = |(members, vertices): &(JsonMembers<'_>, Vec<[f64; 2]>)| {
                let moved = vertices
                    .iter()
                    .map(|at| frame.point_anywhere(*at).map(hundredth));
                members.with(&[("vertices", json!(moved.collect::<Vec<_>>()).to_string())])
            };
            let lines: Vec<String> = self.lines.iter().map(line).collect();
            replaced.push(("poly2d", format!("[{}]", lines.join(","))));
        }
        Some(self.members.with(&replaced))
    }
}

/// The labels of a frame, of which the boxes have these ids, each with what becomes of it; an error names the label and
/// what of it cannot be moved.
fn each_label<T>(
    labels: &RawValue,
    mut ids: BTreeSet<&Id>,
    of: impl Fn(&Places<'_>) -> Option<T>,
) -> Result<Vec<T>, (String, String)> {
    // Labels that are no list are among the problems of their image, and so are labels that cannot be read.
    let labels: Vec<&RawValue> = serde_json::from_str(labels.get()).unwrap_or_default();
    let mut all = Vec::new();
    for (idx, text) in labels.into_iter().enumerate() {
        let Ok(label) = serde_json::from_str::<ScalabelLabel>(text.get()) else {
            continue;
        };
        let by_number = format!("[{idx}]");
        let id = match Option::<Id>::deserialize(&label.id) {
            Ok(id) => id.unwrap_or(Id::Text(by_number.into_boxed_str())),
            Err(_) => continue,
        };
        let corners_px = match label.object() {
            Ok(Some(object)) if ids.remove(&id) => Some(object.corners_px),
            Ok(None) => None,
            _ => continue,
        };
        let places = Places::of(text.get(), corners_px);
        let places = places.map_err(|what| (format!("label {id}"), what))?;
        all.extend(of(&places));
    }
    Ok(all)
}

/// Refuses a frame with labels that cannot be moved: which, and what of it.
pub(super) fn check_labels(text: &str, ids: BTreeSet<&Id>) -> Result<(), (String, String)> {
    let frame: Option<JsonMembers<'_>> = serde_json::from_str(text).ok();
    match frame.as_ref().and_then(|frame| frame.get("labels")) {
        Some(labels) => each_label(labels, ids, |_| Some(())).map(drop),
        None => Ok(()),
    }
}

/// The text of a frame with its labels moved; which of them cannot be, and why not.
pub(super) fn moved_labels(
    text: &str,
    ids: BTreeSet<&Id>,
    frame: &MovedFrame,
) -> Result<String, (String, String)> {
    let members: Option<JsonMembers<'_>> = serde_json::from_str(text).ok();
    let labels = members
        .as_ref()
        .and_then(|members| Some((members, members.get("labels")?)));
    let Some((members, labels)) = labels else {
        return Ok(text.to_owned());
    };
    let labels = each_label(labels, ids, |places| places.moved(frame))?;
    Ok(members.with(&[("labels", format!("[{}]", labels.join(",")))]))
}
