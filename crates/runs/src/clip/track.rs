//! The track of a clip: what the glass is like in each frame.
//!
//! `damage_onset` is the impact: the first frame that begins at it or later; where no glass breaks,
//! the first frame with a fault. `first_visible` is the first frame whose region is not empty, `null`
//! where none is: a crack that grows out of sight or is still too short comes later than its impact.
//! Each is `{"frame_idx", "time_s"}`.

use std::fmt::Write as _;

use serde::Serialize;
use serde_json::{Map, Value, json};
use starbreak::Chain;
use starbreak_dataset::video::Fraction;
use starbreak_glass::LengthUnit;
use starbreak_seed::Seed;

use super::{ClipRequest, GlassState, Growth, Light};
use crate::RunContext;

/// Name and version of the track format.
pub const TRACK_SCHEMA: &str = "starbreak.track/1";

/// One line of the track.
#[derive(Debug, Clone, Serialize)]
pub(super) struct TrackFrame {
    pub(super) frame_idx: u64,
    pub(super) time_s: f64,
    #[serde(serialize_with = "state_name")]
    pub(super) state: GlassState,
    /// Whether the damage has begun by then, whatever the frame shows.
    #[serde(skip)]
    pub(super) has_begun: bool,
    /// In the unit of the header's `growth.unit`; where that is null, because the network keeps no
    /// times, 1 for cracks that are there and 0 for none.
    pub(super) growth: f64,
    /// Null where a photograph is shown, which says nothing of its cracks.
    pub(super) crack_length_px: Option<f64>,
    pub(super) region_fraction: f64,
    /// What lies on the glass, by table, where that changes as time goes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) on_glass: Option<Map<String, Value>>,
    /// Where the sun is, degrees from the optical axis to the right, if it turns.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) sun_azimuth_deg: Option<f64>,
    /// What became of the frame, where the recipe has `[frames]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) arrival: Option<Arrival>,
    /// File of the frame, in a folder.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) file: Option<String>,
}

/// What became of a frame. What the line says of the glass is that of the frame that is shown.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Arrival {
    /// `good`, `black`, `white`, `frozen` or `dropped`.
    pub(super) state: &'static str,
    /// The frame that is shown; none where it is blank.
    pub(super) shows_frame_idx: Option<u64>,
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde asks for a reference"
)]
fn state_name<S: serde::Serializer>(state: &GlassState, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(state.name())
}

/// What the whole clip has in common.
pub(super) struct TrackHeader<'a> {
    pub(super) request: &'a ClipRequest,
    pub(super) context: &'a RunContext,
    pub(super) name: &'a str,
    pub(super) seed: Seed,
    pub(super) input_kind: &'static str,
    pub(super) input_sha256: &'a str,
    pub(super) size: (u32, u32),
    pub(super) rate: Fraction,
    pub(super) has_constant_rate: bool,
    pub(super) chain: &'a Chain,
    /// Name and SHA-256 of the network's file, if there is a network.
    pub(super) network_file: Option<(&'a str, &'a str)>,
    pub(super) output_name: &'a str,
    pub(super) n_lights: u64,
}

/// The first frame at the impact or after it; where no glass breaks, the first with a fault.
pub(super) fn onset(frames: &[TrackFrame]) -> Option<(u64, f64)> {
    frames
        .iter()
        .find(|frame| frame.has_begun)
        .map(|frame| (frame.frame_idx, frame.time_s))
}

/// The first frame whose region is not empty.
pub(super) fn first_visible(frames: &[TrackFrame]) -> Option<(u64, f64)> {
    frames
        .iter()
        .find(|frame| frame.region_fraction > 0.0)
        .map(|frame| (frame.frame_idx, frame.time_s))
}

/// The track as text: the header's keys, then a line for each frame.
pub(super) fn track_text(header: &TrackHeader<'_>, frames: &[TrackFrame]) -> String {
    let mut text = String::from("{\n");
    for (key, value) in header_json(header, frames) {
        // Writing to a String does not fail.
        let _ = writeln!(text, "  \"{key}\": {value},");
    }
    text += "  \"frames\": [\n";
    for (k, frame) in frames.iter().enumerate() {
        let line = serde_json::to_value(frame).unwrap_or_default();
        let end = if k + 1 < frames.len() { "," } else { "" };
        let _ = writeln!(text, "    {line}{end}");
    }
    text += "  ]\n}\n";
    text
}

fn header_json(header: &TrackHeader<'_>, frames: &[TrackFrame]) -> Map<String, Value> {
    let TrackHeader {
        request, context, ..
    } = header;
    let (mode, stretched_s) = match request.growth {
        Growth::Whole => ("whole", None),
        Growth::OwnSpeed => ("own_speed", None),
        Growth::Stretched { time_s } => ("stretched", Some(time_s)),
    };
    let arrivals = header.chain.arrivals();
    let unit = arrivals.map(|times| times.unit);
    let last_arrival = arrivals.map_or(0.0, |times| times.last);
    let rate = header.rate;
    let place = |frame: Option<(u64, f64)>| {
        json!(frame.map(|(idx, time_s)| json!({ "frame_idx": idx, "time_s": time_s })))
    };
    let rows = [
        ("schema", json!(TRACK_SCHEMA)),
        (
            "generator",
            json!({ "name": "starbreak", "version": env!("CARGO_PKG_VERSION") }),
        ),
        (
            "input",
            json!({ "name": header.name, "kind": header.input_kind, "sha256": header.input_sha256 }),
        ),
        ("output", json!({ "name": header.output_name })),
        ("n_frames", json!(frames.len())),
        ("fps", json!(rate.value())),
        (
            "fps_fraction",
            json!([rate.numerator(), rate.denominator()]),
        ),
        ("constant_rate", json!(header.has_constant_rate)),
        ("width_px", json!(header.size.0)),
        ("height_px", json!(header.size.1)),
        ("seed", json!(context.seed.0)),
        (
            "item",
            json!({ "name": header.name, "sample_index": 0, "seed": header.seed.0 }),
        ),
        ("recipe", json!(context.recipe)),
        ("recipe_sha256", json!(context.recipe_sha256)),
        (
            "network_unit",
            json!(
                header
                    .chain
                    .network()
                    .map(|network| match network.data().unit {
                        LengthUnit::Px => "px",
                        LengthUnit::Mm => "mm",
                    })
            ),
        ),
        ("impact_at_s", json!(request.impact_at_s)),
        (
            "growth",
            json!({ "mode": mode, "time_s": stretched_s, "unit": unit, "last_arrival": last_arrival }),
        ),
        (
            "light",
            json!({
                "mode": match request.light { Light::First => "first", Light::Follow => "follow" },
                "n_lights": header.n_lights,
            }),
        ),
        ("damage_onset", place(onset(frames))),
        ("first_visible", place(first_visible(frames))),
    ];
    let mut all = Map::new();
    for (key, value) in rows {
        // The damage stands behind the recipe that it was made by.
        if key == "network_unit" {
            all.extend(damage_json(header));
        }
        all.insert(key.to_owned(), value);
    }
    all
}

/// What a record says of the damage, and the file of its network.
fn damage_json(header: &TrackHeader<'_>) -> Map<String, Value> {
    let mut facts = header.chain.facts().clone();
    if let (Some((name, sha256)), Some(Value::Object(said))) =
        (header.network_file, facts.get("network").cloned())
    {
        let mut network = Map::from_iter([
            ("file".to_owned(), json!(name)),
            ("sha256".to_owned(), json!(sha256)),
        ]);
        for (key, value) in said {
            // The file that the network was read from.
            let key = if key == "file" {
                "source".to_owned()
            } else {
                key
            };
            network.insert(key, value);
        }
        facts.insert("network".to_owned(), Value::Object(network));
    }
    facts
}
