//! A contract out of TOML.

use toml::{Table, Value};

use super::presets::{class_list, preset_text};
use super::table::{Keys, did_you_mean};
use super::{
    Activation, BoxForm, BoxUnit, ClassNames, ColorOrder, Contract, InputContract, Interpolation,
    Layout, NmsContract, OutputContract, OutputForm, PadStage, Resize, Rounding, SizeInput,
};
use crate::DetectError;

/// The schema of contracts.
const SCHEMA: i64 = 1;

impl Contract {
    /// The contract in a text of TOML; `name` is what messages call it.
    ///
    /// With `preset = "NAME"` it begins as that preset and says only what differs.
    ///
    /// # Errors
    ///
    /// [`DetectError::Contract`] with the key, the value and what is expected, for what is no TOML,
    /// unknown keys, values out of range, and keys that are missing.
    pub fn parse(name: &str, text: &str) -> Result<Self, DetectError> {
        let own = table_of(name, text)?;
        let table = match own.get("preset") {
            None => own,
            Some(Value::String(preset)) => {
                let mut base = table_of(preset, preset_text(preset)?)?;
                lay_over(&mut base, &own);
                base
            }
            Some(other) => {
                return Err(DetectError::Contract {
                    contract: name.to_owned(),
                    key: "preset".to_owned(),
                    reason: format!("expected the name of a preset in quotes, found {other}"),
                });
            }
        };
        let keys = Keys::new(name, "", &table);
        let _ = keys.get("preset");
        match keys.whole("schema", [SCHEMA, SCHEMA])? {
            Some(_) => {}
            None => {
                return Err(keys.wrong("schema", format!("is missing; write schema = {SCHEMA}")));
            }
        }
        let about = keys.text("about")?.unwrap_or("a contract of your own");
        let input = section(&keys, "input")?;
        let output = section(&keys, "output")?;
        let detections = section(&keys, "detections")?;
        let nms = keys.table("nms")?;
        let classes = section(&keys, "classes")?;
        keys.refuse_unknown()?;

        let input = read_input(&Keys::new(name, "input", input))?;
        let output = read_output(&Keys::new(name, "output", output))?;
        let nms = match nms {
            None => None,
            Some(table) => Some(read_nms(&Keys::new(name, "nms", table))?),
        };
        let detections = Keys::new(name, "detections", detections);
        let score_threshold = detections.number("score_threshold", [0.0, 1.0], 0.001)?;
        let max_detections = detections.whole("max_detections", [1, 100_000])?;
        let clips_boxes = detections.truth("clip", true)?;
        detections.refuse_unknown()?;
        let (classes, first_label) = read_classes(&Keys::new(name, "classes", classes))?;
        Ok(Self {
            name: name.to_owned(),
            about: about.to_owned(),
            input,
            output,
            score_threshold,
            max_detections: u32::try_from(max_detections.unwrap_or(300)).unwrap_or(u32::MAX),
            clips_boxes,
            nms,
            classes,
            first_label,
        })
    }
}

fn table_of(name: &str, text: &str) -> Result<Table, DetectError> {
    text.parse().map_err(|error: toml::de::Error| {
        let line = error.span().map(|span| {
            let before = text.get(..span.start).unwrap_or_default();
            before.matches('\n').count() + 1
        });
        DetectError::Contract {
            contract: name.to_owned(),
            key: line.map_or_else(|| "TOML".to_owned(), |line| format!("line {line}")),
            reason: format!(
                "it is no TOML: {}",
                error.message().lines().collect::<Vec<_>>().join(", ")
            ),
        }
    })
}

/// Lays the values of one table over another's; tables inside are laid over, all else replaced.
fn lay_over(base: &mut Table, over: &Table) {
    for (key, value) in over {
        match (base.get_mut(key), value) {
            (Some(Value::Table(below)), Value::Table(above)) => lay_over(below, above),
            _ => {
                base.insert(key.clone(), value.clone());
            }
        }
    }
}

fn section<'a>(keys: &Keys<'a>, name: &'static str) -> Result<&'a Table, DetectError> {
    keys.table(name)?.ok_or_else(|| {
        keys.wrong(
            name,
            "this table is missing; begin with preset = \"NAME\" and say what differs",
        )
    })
}

/// A key that must be there.
fn needed<T>(keys: &Keys<'_>, key: &str, value: Option<T>) -> Result<T, DetectError> {
    value.ok_or_else(|| keys.wrong(key, "is missing"))
}

const ANY: [f32; 2] = [-1e6, 1e6];
const POSITIVE: [f32; 2] = [1e-6, 1e6];

fn read_input(keys: &Keys<'_>) -> Result<InputContract, DetectError> {
    let layout = keys.word(
        "layout",
        &[
            ("nchw", Layout::Nchw),
            ("nhwc", Layout::Nhwc),
            ("chw", Layout::Chw),
        ],
    )?;
    let color = keys.word(
        "color",
        &[("rgb", ColorOrder::Rgb), ("bgr", ColorOrder::Bgr)],
    )?;
    let interpolation = keys.word(
        "interpolation",
        &[
            ("linear", Interpolation::Linear),
            ("area", Interpolation::Area),
            ("antialiased", Interpolation::Antialiased),
        ],
    )?;
    let pad_stage = keys.word(
        "pad_stage",
        &[("pixels", PadStage::Pixels), ("numbers", PadStage::Numbers)],
    )?;
    let size_px = match keys.sides_px("size_px")? {
        None => None,
        Some(sides) => Some(<[u32; 2]>::try_from(sides).map_err(|sides| {
            keys.wrong(
                "size_px",
                format!("expected [width, height], found {} numbers", sides.len()),
            )
        })?),
    };
    let image_size = keys.name("image_size_input")?;
    let size_order = keys.word(
        "image_size_order",
        &[("width-height", true), ("height-width", false)],
    )?;
    let input = InputContract {
        image: keys.name("image_input")?,
        layout: needed(keys, "layout", layout)?,
        color: needed(keys, "color", color)?,
        divisor: keys.number("divisor", POSITIVE, 1.0)?,
        mean: keys.channels("mean", ANY, 0.0)?,
        std: keys.channels("std", POSITIVE, 1.0)?,
        resize: read_resize(keys)?,
        interpolation: interpolation.unwrap_or(Interpolation::Linear),
        pad_value: keys.number("pad_value", ANY, 114.0)?,
        pad_stage: pad_stage.unwrap_or(PadStage::Pixels),
        size_px,
        image_size: image_size.map(|name| SizeInput {
            name,
            width_first: size_order.unwrap_or(true),
        }),
        mask: keys.name("mask_input")?,
    };
    keys.refuse_unknown()?;
    Ok(input)
}

fn read_resize(keys: &Keys<'_>) -> Result<Resize, DetectError> {
    #[derive(Clone, Copy)]
    enum Word {
        Keep,
        Stretch,
        Letterbox,
        TopLeft,
        ShortestSide,
    }
    let word = keys.word(
        "resize",
        &[
            ("none", Word::Keep),
            ("stretch", Word::Stretch),
            ("letterbox", Word::Letterbox),
            ("letterbox-top-left", Word::TopLeft),
            ("shortest-side", Word::ShortestSide),
        ],
    )?;
    let rounding = keys.word(
        "rounding",
        &[
            ("half-to-even", Rounding::HalfToEven),
            ("down", Rounding::Down),
        ],
    )?;
    let rounding = rounding.unwrap_or(Rounding::HalfToEven);
    let sides = [keys.side_px("min_side_px")?, keys.side_px("max_side_px")?];
    let pad_multiple_px = keys.side_px("pad_multiple_px")?.unwrap_or(1);
    Ok(match needed(keys, "resize", word)? {
        Word::Keep => Resize::Keep,
        Word::Stretch => Resize::Stretch,
        Word::Letterbox => Resize::Letterbox {
            is_centered: true,
            rounding,
        },
        Word::TopLeft => Resize::Letterbox {
            is_centered: false,
            rounding,
        },
        Word::ShortestSide => Resize::ShortestSide {
            min_side_px: needed(keys, "min_side_px", sides[0])?,
            max_side_px: needed(keys, "max_side_px", sides[1])?,
            pad_multiple_px,
        },
    })
}

fn read_output(keys: &Keys<'_>) -> Result<OutputContract, DetectError> {
    #[derive(Clone, Copy)]
    enum Word {
        Dense,
        Rows,
        Three,
        Two,
        Logits,
        FastestDet,
    }
    let form = keys.word(
        "form",
        &[
            ("dense", Word::Dense),
            ("rows", Word::Rows),
            ("boxes-scores-labels", Word::Three),
            ("scored-boxes-labels", Word::Two),
            ("boxes-logits", Word::Logits),
            ("fastestdet", Word::FastestDet),
        ],
    )?;
    let output = keys.name("output")?;
    let boxes = keys.name("boxes")?;
    let scores = keys.name("scores")?;
    let labels = keys.name("labels")?;
    let logits = keys.name("logits")?;
    let places_first = keys.truth("places_first", false)?;
    let has_objectness = keys.truth("objectness", false)?;
    let strides_px = keys.sides_px("strides_px")?.unwrap_or_default();
    let last_is_background = keys.truth("last_is_background", false)?;
    let form = match needed(keys, "form", form)? {
        Word::Dense => OutputForm::Dense {
            output,
            places_first,
            has_objectness,
            strides_px,
        },
        Word::Rows => OutputForm::Rows { output },
        Word::Three => OutputForm::BoxesScoresLabels {
            outputs: [boxes, scores, labels],
        },
        Word::Two => OutputForm::ScoredBoxesLabels {
            outputs: [boxes, labels],
        },
        Word::Logits => OutputForm::BoxesLogits {
            outputs: [boxes, logits],
            last_is_background,
        },
        Word::FastestDet => OutputForm::FastestDet { output },
    };
    let box_form = keys.word(
        "box_form",
        &[
            ("corners", BoxForm::Corners),
            ("center-size", BoxForm::CenterSize),
        ],
    )?;
    let box_unit = keys.word(
        "box_unit",
        &[
            ("frame-px", BoxUnit::FramePx),
            ("frame-fraction", BoxUnit::FrameFraction),
            ("image-px", BoxUnit::ImagePx),
        ],
    )?;
    let activation = keys.word(
        "activation",
        &[
            ("none", Activation::None),
            ("sigmoid", Activation::Sigmoid),
            ("softmax", Activation::Softmax),
        ],
    )?;
    let output = OutputContract {
        form,
        box_form: box_form.unwrap_or(BoxForm::Corners),
        box_unit: box_unit.unwrap_or(BoxUnit::FramePx),
        activation: activation.unwrap_or(Activation::None),
        objectness_power: keys.number("objectness_power", [0.0, 10.0], 1.0)?,
        class_power: keys.number("class_power", [0.0, 10.0], 1.0)?,
        is_multi_label: keys.truth("multi_label", false)?,
    };
    keys.refuse_unknown()?;
    Ok(output)
}

fn read_nms(keys: &Keys<'_>) -> Result<NmsContract, DetectError> {
    let iou = keys.number("iou", [0.0, 1.0], 0.7)?;
    let is_across_classes = keys.truth("across_classes", false)?;
    let max_candidates = keys.whole("max_candidates", [1, 10_000_000])?;
    keys.refuse_unknown()?;
    Ok(NmsContract {
        iou,
        is_across_classes,
        max_candidates: u32::try_from(max_candidates.unwrap_or(30_000)).unwrap_or(u32::MAX),
    })
}

fn read_classes(keys: &Keys<'_>) -> Result<(ClassNames, i64), DetectError> {
    let list = keys.text("list")?;
    let names = keys.get("names");
    let first_label = keys.whole("first_label", [-1000, 1_000_000])?.unwrap_or(0);
    keys.refuse_unknown()?;
    // A contract that begins as a preset and has names of its own keeps the preset's list.
    let classes = match (names, list) {
        (Some(Value::Array(items)), _) => {
            let mut texts = Vec::with_capacity(items.len());
            for item in items {
                match item {
                    Value::String(text) if !text.trim().is_empty() => texts.push(text.as_str()),
                    other => {
                        return Err(keys.wrong("names", format!("expected names, found {other}")));
                    }
                }
            }
            ClassNames::new("the contract", texts)
        }
        (Some(other), _) => {
            return Err(keys.wrong(
                "names",
                format!("expected names in brackets, found {other}"),
            ));
        }
        (None, Some(list)) => class_list(list).ok_or_else(|| {
            let known = ["coco-80", "coco-91"];
            keys.wrong(
                "list",
                format!(
                    "{list:?} is none of {}{}; or give names = [\"…\", …]",
                    known.join(", "),
                    did_you_mean(list, &known)
                ),
            )
        })?,
        (None, None) => {
            return Err(keys.wrong("list", "is missing, and so is names; give one of the two"));
        }
    };
    if classes.names.is_empty() {
        return Err(keys.wrong("names", "is empty; give at least one name"));
    }
    Ok((classes, first_label))
}
