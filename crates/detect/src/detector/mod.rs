//! The detector: a model with its contract, and what runs it.

mod batch;
mod layers;

use std::path::Path;

use image::RgbImage;
use starbreak_dataset::read_bytes;

use crate::contract::{BoxUnit, ClassNames, Contract, choose};
use crate::decode::{Candidate, Decoded, decode, output_names};
use crate::input_plan::InputPlan;
use crate::model_file::{self, ModelFacts, ModelLimits};
use crate::pixels::{self, Placement};
use crate::runtime::{Backend, OutputTensor, PureRust, Runtime};
use crate::{DetectError, nms};

pub use batch::{ImageToSee, Seen};

/// How a model is opened.
#[derive(Debug, Clone, Default)]
pub struct DetectorOptions {
    /// Its contract; without it the preset that fits.
    pub contract: Option<Contract>,
    /// Detections with a lower score are left out, instead of the contract's threshold.
    pub score_threshold: Option<f32>,
    /// What runs it.
    pub backend: Backend,
    /// How much memory it may ask for.
    pub limits: ModelLimits,
}

/// An ONNX model that finds boxes in images.
#[derive(Debug)]
pub struct Detector {
    name: String,
    facts: ModelFacts,
    contract: Contract,
    reason: String,
    plan: InputPlan,
    outputs: Vec<String>,
    runtime_name: String,
    runtime: Box<dyn Runtime>,
}

/// A box that a model found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RawDetection {
    /// Place of its class in [`Detector::classes`].
    pub class: u32,
    /// Where it is in the image: left, upper, right and lower side, px; the first pixel's center is at (0.5, 0.5).
    pub corners_px: [f64; 4],
    /// How sure the model is.
    pub score: f64,
}

/// What a model found in an image.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ImageDetections {
    /// By falling score; equal ones in the order of the model's output.
    pub detections: Vec<RawDetection>,
    /// Boxes whose right side lay left of the left one, or the lower above the upper: left out.
    pub n_inverted: u32,
    /// Boxes whose label stands for no class: left out.
    pub n_without_class: u32,
}

/// An output as the model gave it.
#[derive(Debug, Clone, PartialEq)]
pub struct RawTensor {
    /// Its name.
    pub name: String,
    /// Its sides.
    pub shape: Vec<usize>,
    /// Its numbers, last side fastest; whole numbers as floating point.
    pub values: Vec<f32>,
}

impl Detector {
    /// The model in a file.
    ///
    /// # Errors
    ///
    /// [`DetectError::Dataset`] where it cannot be read; [`DetectError::Model`] where it is no ONNX
    /// model, needs an operator that the backend does not have, lacks its file of weights, asks
    /// for more memory than the limits allow, or does not take and give what its contract says;
    /// [`DetectError::Contract`]; [`DetectError::Runtime`].
    pub fn open(path: &Path, options: &DetectorOptions) -> Result<Self, DetectError> {
        let name = path.to_string_lossy().into_owned();
        let bytes = read_bytes(path, options.limits.max_file_bytes)?;
        let facts = model_file::read_facts(&name, &bytes, &options.limits)?;
        let external = external_files(&name, path, &facts, &options.limits)?;
        Self::load(&name, path, bytes, external, facts, options)
    }

    /// The model in the bytes of a file, for the backend that is compiled in; `name` serves only for messages.
    ///
    /// # Errors
    ///
    /// Those of [`open`](Self::open), and [`DetectError::Model`] where weights or the backend are other files.
    pub fn of_bytes(
        name: &str,
        bytes: Vec<u8>,
        options: &DetectorOptions,
    ) -> Result<Self, DetectError> {
        let wrong = |reason: String| DetectError::Model {
            model: name.to_owned(),
            reason,
        };
        let facts = model_file::read_facts(name, &bytes, &options.limits)?;
        if let Some(file) = facts.external_files.first() {
            return Err(wrong(format!(
                "keeps weights in {file:?} beside it, which is not here; export it into one file"
            )));
        }
        if options.backend != Backend::PureRust {
            return Err(wrong(
                "is not run by ONNX Runtime from memory; open its file".to_owned(),
            ));
        }
        Self::load(name, Path::new(name), bytes, Vec::new(), facts, options)
    }

    fn load(
        name: &str,
        path: &Path,
        bytes: Vec<u8>,
        external: Vec<(String, Vec<u8>)>,
        facts: ModelFacts,
        options: &DetectorOptions,
    ) -> Result<Self, DetectError> {
        let wrong = |reason: String| DetectError::Model {
            model: name.to_owned(),
            reason,
        };
        let (mut contract, reason) = match &options.contract {
            Some(contract) => (contract.clone(), "it was asked for".to_owned()),
            None => {
                let choice = choose(name, &facts)?;
                (choice.contract, choice.reason)
            }
        };
        if let Some(threshold) = options.score_threshold {
            contract.score_threshold = threshold;
        }
        // What the model says of its classes is better than what a preset guesses.
        if contract.classes.is_guess()
            && let Some(names) = facts.entry("names")
        {
            contract.classes = ClassNames::from_python_dictionary(name, names)?;
        }
        let plan = InputPlan::new(&contract, &facts).map_err(wrong)?;
        let outputs = outputs_of(&contract, &facts).map_err(wrong)?;
        let runtime_name = options.backend.name()?;
        #[cfg(target_family = "wasm")]
        let _ = path;
        let runtime: Box<dyn Runtime> = match &options.backend {
            Backend::PureRust => Box::new(
                PureRust::load(bytes, external, &facts, options.limits.max_tensor_bytes)
                    .map_err(wrong)?,
            ),
            #[cfg(not(target_family = "wasm"))]
            Backend::OnnxRuntime { library, device } => Box::new(
                crate::runtime::OnnxRuntime::load(library, *device, path, &facts).map_err(wrong)?,
            ),
        };
        Ok(Self {
            name: name.to_owned(),
            facts,
            contract,
            reason,
            plan,
            outputs,
            runtime_name,
            runtime,
        })
    }

    /// How images become input and outputs boxes.
    #[must_use]
    pub fn contract(&self) -> &Contract {
        &self.contract
    }

    /// Why this contract.
    #[must_use]
    pub fn reason(&self) -> &str {
        &self.reason
    }

    /// What runs it, as [`Backend::name`] says it.
    #[must_use]
    pub fn runtime(&self) -> &str {
        &self.runtime_name
    }

    /// What the file says of itself.
    #[must_use]
    pub fn facts(&self) -> &ModelFacts {
        &self.facts
    }

    /// The model's classes.
    #[must_use]
    pub fn classes(&self) -> &ClassNames {
        &self.contract.classes
    }

    /// The boxes that the model finds in an image; `name` is what messages call the image.
    ///
    /// The same bits for the same image, however many threads do this at once.
    ///
    /// # Errors
    ///
    /// [`DetectError::Inference`] where the model fails, or gives what is no number, another number
    /// of classes than its list, or other shapes than its contract says.
    ///
    /// # Limits
    ///
    /// Bits may differ between kinds of processors, whose vector units add in another order.
    pub fn detect(&self, name: &str, image: &RgbImage) -> Result<ImageDetections, DetectError> {
        let wrong = |reason| self.wrong(name, reason);
        let placement = self.placement(name, image)?;
        let outputs = self.run(image, &placement).map_err(wrong)?;
        let decoded = decode(&self.contract, &outputs).map_err(wrong)?;
        Ok(self.finish(image, &placement, decoded))
    }

    /// What the model gives for an image, before any of it is read.
    ///
    /// # Errors
    ///
    /// [`DetectError::Inference`] where the model fails.
    pub fn raw_outputs(&self, name: &str, image: &RgbImage) -> Result<Vec<RawTensor>, DetectError> {
        let placement = self.placement(name, image)?;
        let outputs = self
            .run(image, &placement)
            .map_err(|reason| self.wrong(name, reason))?;
        let raw = outputs.into_iter().map(|output| RawTensor {
            name: output.name,
            shape: output.shape,
            values: output.values,
        });
        Ok(raw.collect())
    }

    fn wrong(&self, image: &str, reason: String) -> DetectError {
        DetectError::Inference {
            model: self.name.clone(),
            image: image.to_owned(),
            reason,
        }
    }

    fn placement(&self, name: &str, image: &RgbImage) -> Result<Placement, DetectError> {
        let (width, height) = image.dimensions();
        if width == 0 || height == 0 {
            return Err(self.wrong(name, "it has no pixels".to_owned()));
        }
        Ok(pixels::place(
            self.contract.input.resize,
            [width, height],
            self.plan.frame_px,
        ))
    }

    fn run(&self, image: &RgbImage, placement: &Placement) -> Result<Vec<OutputTensor>, String> {
        let tensor = pixels::image_tensor(image, placement, &self.contract.input);
        let inputs = self.plan.inputs(tensor, image.dimensions(), placement)?;
        let raw = self.runtime.run(inputs, &self.outputs)?;
        if raw.len() != self.outputs.len() {
            return Err(format!(
                "it gave {} outputs of {}",
                raw.len(),
                self.outputs.len()
            ));
        }
        let frame_px = [placement.frame_width_px, placement.frame_height_px];
        let named = self.outputs.iter().zip(raw);
        Ok(named
            .map(|(name, (shape, values))| OutputTensor {
                name: name.clone(),
                shape,
                values,
                frame_px,
            })
            .collect())
    }

    fn finish(&self, image: &RgbImage, placement: &Placement, decoded: Decoded) -> ImageDetections {
        let mut candidates = match &self.contract.nms {
            Some(contract) => nms::suppress(decoded.candidates, contract),
            None => {
                let mut candidates = decoded.candidates;
                nms::sort_by_score(&mut candidates);
                candidates
            }
        };
        candidates.truncate(self.contract.max_detections as usize);
        let detections = candidates
            .iter()
            .map(|candidate| self.in_image(image, placement, candidate));
        ImageDetections {
            detections: detections.collect(),
            n_inverted: decoded.n_inverted,
            n_without_class: decoded.n_without_class,
        }
    }

    fn in_image(
        &self,
        image: &RgbImage,
        placement: &Placement,
        candidate: &Candidate,
    ) -> RawDetection {
        let [x0, y0, x1, y1] = candidate.corners.map(f64::from);
        let (fw, fh) = (
            f64::from(placement.frame_width_px),
            f64::from(placement.frame_height_px),
        );
        let point = |x: f64, y: f64| match self.contract.output.box_unit {
            BoxUnit::FramePx => placement.to_image([x, y]),
            BoxUnit::FrameFraction => placement.to_image([x * fw, y * fh]),
            BoxUnit::ImagePx => [x, y],
        };
        let ([mut x0, mut y0], [mut x1, mut y1]) = (point(x0, y0), point(x1, y1));
        if self.contract.clips_boxes {
            let (width, height) = (f64::from(image.width()), f64::from(image.height()));
            (x0, x1) = (x0.clamp(0.0, width), x1.clamp(0.0, width));
            (y0, y1) = (y0.clamp(0.0, height), y1.clamp(0.0, height));
        }
        RawDetection {
            class: candidate.class,
            corners_px: [x0, y0, x1, y1],
            score: f64::from(candidate.score),
        }
    }
}

/// The outputs that the contract reads, by their names in the model.
fn outputs_of(contract: &Contract, facts: &ModelFacts) -> Result<Vec<String>, String> {
    let wanted = output_names(&contract.output.form);
    let mut names = Vec::with_capacity(wanted.len());
    for (place, name) in wanted.iter().enumerate() {
        let found = match name {
            // The only output is meant, whatever it is called.
            Some(name) => facts
                .output(name)
                .or_else(|| facts.outputs.first().filter(|_| facts.outputs.len() == 1)),
            None => facts.outputs.get(place),
        };
        match found {
            Some(output) => names.push(output.name.clone()),
            None => {
                return Err(format!(
                    "has no output {:?}, which the contract {:?} reads: it {facts}; choose another contract, or name \
                     the outputs in its table [output]",
                    name.unwrap_or("?"),
                    contract.name
                ));
            }
        }
    }
    Ok(names)
}

/// The files of weights beside a model.
fn external_files(
    name: &str,
    path: &Path,
    facts: &ModelFacts,
    limits: &ModelLimits,
) -> Result<Vec<(String, Vec<u8>)>, DetectError> {
    let wrong = |reason: String| DetectError::Model {
        model: name.to_owned(),
        reason,
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut files = Vec::new();
    for file in &facts.external_files {
        let is_plain = !file.is_empty()
            && !file.contains('\\')
            && Path::new(file)
                .components()
                .all(|part| matches!(part, std::path::Component::Normal(_)));
        if !is_plain {
            return Err(wrong(format!(
                "keeps weights in {file:?}, which is not beside it; export it into one file"
            )));
        }
        let bytes = read_bytes(&folder.join(file), limits.max_file_bytes).map_err(|error| {
            wrong(format!(
                "keeps weights in {file:?} beside it, which cannot be read ({error}); copy it along, or export the \
                 model into one file"
            ))
        })?;
        files.push((file.clone(), bytes));
    }
    Ok(files)
}
