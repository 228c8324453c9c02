//! Sets of images as they are named, and read: what `starbreak divergence` compares.

use std::ffi::{OsStr, OsString};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use image::{DynamicImage, RgbImage};
use starbreak_dataset::{Source, SourceFormat, SourceSpec, blake3_hex};
use starbreak_eval::EvalError;
use starbreak_eval::detector::{Detector, DetectorOptions};
use starbreak_eval::divergence::{
    CompareSettings, DivergenceReport, FailedImage, ImageFile, ImageSet, NamedPattern,
    ReadSettings, VectorOf, compare_sets, compare_vectors,
};

use crate::Error;
use crate::bank::{BankIn, PatternBank};
use crate::{crack_geometry, read_network};

/// Before the folder of crack networks.
const NETWORKS: &str = "networks:";

/// The model by whose activations images are compared.
#[derive(Debug)]
pub struct Eye {
    detector: Detector,
    layer: String,
    origin: String,
}

impl Eye {
    /// An ONNX detector, and the name of the value whose channel means are the features: the
    /// widest of its coarsest maps unless given.
    ///
    /// # Errors
    /// [`Error::Eval`] for a model that cannot be read, or has no such layer.
    pub fn open(model: &Path, layer: Option<&str>) -> Result<Self, Error> {
        let detector = Detector::open(model, &DetectorOptions::default())?;
        let layer = match layer {
            Some(layer) => {
                detector.check_layer(layer)?;
                layer.to_owned()
            }
            None => detector.coarsest_layer()?,
        };
        let origin = format!("{}, layer {layer}, channel means", model.display());
        Ok(Self {
            detector,
            layer,
            origin,
        })
    }

    /// Adds the comparison of activations to each pair of a report, with an RBF kernel of width
    /// `sigma`; sets of one image have none.
    ///
    /// # Errors
    /// [`Error::Eval`].
    pub fn compare(
        &self,
        sets: &[ImageSet],
        sigma: f64,
        settings: &CompareSettings,
        report: &mut DivergenceReport,
    ) -> Result<(), Error> {
        for pair in &mut report.pairs {
            let place = |name: &str| sets.iter().position(|set| set.name() == name);
            let Some((a, b)) = place(&pair.a).zip(place(&pair.b)) else {
                continue;
            };
            let vectors = |at: usize| sets.get(at).and_then(ImageSet::vectors);
            let (Some(of_a), Some(of_b)) = (vectors(a), vectors(b)) else {
                continue;
            };
            if of_a.n() < 2 || of_b.n() < 2 {
                continue;
            }
            let compared = compare_vectors(of_a, of_b, &self.origin, sigma, [a, b], settings)?;
            pair.activations = Some(compared);
        }
        Ok(())
    }
}

/// A set that was named.
#[derive(Debug)]
pub struct NamedSet {
    name: String,
    spec: SourceSpec,
    is_networks: bool,
}

/// What is read of a set.
#[derive(Debug)]
enum Content {
    Images(Source),
    Networks(Source),
    /// The patterns of a bank, as pictures.
    Bank(Box<PatternBank>),
}

impl NamedSet {
    /// `[NAME=]FORMAT:PATH`; the format may be `networks`, for the crack networks of a folder.
    ///
    /// # Errors
    /// [`Error::Dataset`] for an unknown format.
    pub fn parse(text: &OsStr) -> Result<Self, Error> {
        let whole = text.to_string_lossy();
        let (name, rest) = match text.to_str().and_then(|text| text.split_once('=')) {
            Some((name, rest)) if !name.is_empty() && !name.contains([':', '/']) => {
                (name.to_owned(), OsString::from(rest))
            }
            _ => (whole.clone().into_owned(), text.to_owned()),
        };
        if let Some(folder) = rest.to_str().and_then(|rest| rest.strip_prefix(NETWORKS)) {
            let spec = SourceSpec::new(SourceFormat::Folder, folder);
            return Ok(Self {
                name,
                spec,
                is_networks: true,
            });
        }
        let spec = SourceSpec::parse(&rest)?;
        Ok(Self {
            name,
            spec,
            is_networks: false,
        })
    }

    /// As [`NamedSet::parse`], and a folder without a format is a folder of images, or of this
    /// format where it has its layout.
    #[must_use]
    pub fn parse_or(text: &OsStr, name: &str, layout: Option<SourceFormat>) -> Self {
        if let Ok(named) = Self::parse(text) {
            return Self {
                name: name.to_owned(),
                ..named
            };
        }
        let spec = |format| SourceSpec::new(format, text);
        let special = layout.map(spec).filter(|spec| Source::open(spec).is_ok());
        Self {
            name: name.to_owned(),
            spec: special.unwrap_or_else(|| spec(SourceFormat::Folder)),
            is_networks: false,
        }
    }

    /// The same, with links that may lead out of a plain folder or not.
    #[must_use]
    pub fn following_links(mut self, follows_links: bool) -> Self {
        self.spec = self.spec.following_links(follows_links);
        self
    }

    /// Two or more sets, no two of one name.
    ///
    /// # Errors
    /// [`Error::Divergence`] for too few, or two of one name; as for [`NamedSet::parse`].
    pub fn parse_all(texts: &[OsString]) -> Result<Vec<Self>, Error> {
        if texts.len() < 2 {
            return Err(Error::Divergence {
                why: "divergence compares two sets or more; for the noise floor of one, give it twice under two names \
                      (a=folder:DIR b=folder:DIR)"
                    .to_owned(),
            });
        }
        let mut named: Vec<Self> = Vec::new();
        for text in texts {
            let set = Self::parse(text)?;
            if let Some(other) = named.iter().find(|other| other.name == set.name) {
                return Err(Error::Divergence {
                    why: format!(
                        "two sets are called {:?}, the second {}; give each a name of its own: a=folder:DIR b=folder:DIR",
                        other.name,
                        text.to_string_lossy()
                    ),
                });
            }
            named.push(set);
        }
        Ok(named)
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Opens it; at most the first `limit` images count. A plain folder that holds a bank of cracks
    /// is that bank, whose patterns are rendered on black.
    ///
    /// # Errors
    /// [`Error::Dataset`] for a folder that is not what its format says.
    pub fn open(&self, limit: Option<usize>) -> Result<OpenSet<'_>, Error> {
        let is_folder = self.spec.format == SourceFormat::Folder && !self.is_networks;
        let bank = BankIn::folder(&self.spec.path).filter(|_| is_folder);
        let content = match bank {
            Some(BankIn::Cracks) => Content::Bank(Box::new(PatternBank::open(&self.spec.path)?)),
            Some(BankIn::Photos) => {
                return Err(Error::Divergence {
                    why: format!(
                        "{}: {:?} is a bank of photographs; give the folder of the photographs",
                        self.name, self.spec.path
                    ),
                });
            }
            None if self.is_networks => Content::Networks(Source::open(&self.spec)?),
            None => Content::Images(Source::open(&self.spec)?),
        };
        Ok(OpenSet {
            named: self,
            content,
            limit,
        })
    }
}

/// A set that is open.
#[derive(Debug)]
pub struct OpenSet<'a> {
    named: &'a NamedSet,
    content: Content,
    limit: Option<usize>,
}

impl OpenSet<'_> {
    /// How many images will be read; networks, which are quick, count as none.
    #[must_use]
    pub fn n_images(&self) -> usize {
        let limit = self.limit.unwrap_or(usize::MAX);
        match &self.content {
            Content::Networks(_) => 0,
            Content::Images(source) => source.images().take(limit).count(),
            Content::Bank(bank) => bank.len().min(limit),
        }
    }

    /// Reads it, in the thread pool of the caller; `step` is called after each image, and once
    /// `stop` is set no further image begins.
    ///
    /// # Errors
    /// [`Error::Eval`] where nothing can be read.
    pub fn read(
        &self,
        reading: &ReadSettings,
        eye: Option<&Eye>,
        stop: &AtomicBool,
        step: &(dyn Fn() + Sync),
    ) -> Result<ImageSet, Error> {
        let name = &self.named.name;
        let vector_of = |image: &RgbImage| -> Result<Vec<f32>, String> {
            let Some(eye) = eye else {
                return Ok(Vec::new());
            };
            let found = eye.detector.pooled_activations(name, image, &eye.layer);
            found.map_err(|error| error.to_string())
        };
        let vector_of = eye.map(|_| &vector_of as &VectorOf<'_>);
        match &self.content {
            Content::Networks(source) => {
                Ok(ImageSet::of_patterns(name, networks(source, self.limit))?)
            }
            Content::Images(source) => Ok(ImageSet::read(
                name, source, reading, self.limit, vector_of, stop, step,
            )?),
            Content::Bank(bank) => {
                let files: Vec<ImageFile> = (0..self.n_images())
                    .map(|idx| ImageFile {
                        name: format!("pattern {idx}"),
                        path: idx.to_string().into(),
                    })
                    .collect();
                let picture = |path: &Path| -> Result<(DynamicImage, String), String> {
                    if stop.load(Ordering::Relaxed) {
                        return Err("interrupted".to_owned());
                    }
                    let idx = path.to_string_lossy().parse().unwrap_or(usize::MAX);
                    let picture = bank.picture(idx).map_err(|error| error.to_string())?;
                    step();
                    let digest = blake3_hex(picture.as_bytes());
                    Ok((picture, digest))
                };
                Ok(ImageSet::of_files(
                    name, &files, reading, vector_of, &picture,
                )?)
            }
        }
    }
}

/// Most draws of each kind.
pub const MAX_DRAWS: usize = 1_000_000;

/// Longest side that images are analyzed at, px.
pub const MAX_SIDE_PX: u32 = 8192;

/// Says whether settings, and the width `sigma` of the RBF kernel, are in their ranges, before
/// anything is read.
///
/// # Errors
/// [`Error::Eval`] for the kernel, [`Error::Divergence`] for all else, naming the value and what is possible.
pub fn check_settings(
    reading: &ReadSettings,
    settings: &CompareSettings,
    limit: Option<usize>,
    sigma: f64,
) -> Result<(), Error> {
    let refused = |why: String| Err(Error::Divergence { why });
    for (name, n) in [
        ("bootstrap", settings.n_bootstrap),
        ("permutations", settings.n_permutations),
        ("splits", settings.n_splits),
    ] {
        if n > MAX_DRAWS {
            return refused(format!("{name} = {n}; expected 0 to {MAX_DRAWS}"));
        }
    }
    if reading.analysis.shorter_side_px > MAX_SIDE_PX {
        return refused(format!(
            "side = {} px; expected 0 to {MAX_SIDE_PX}",
            reading.analysis.shorter_side_px
        ));
    }
    if !(sigma.is_finite() && sigma > 0.0) {
        return Err(EvalError::KernelWidth { sigma }.into());
    }
    if limit == Some(0) {
        return refused("limit = 0; expected 1 or more images of each set".to_owned());
    }
    Ok(())
}

/// Compares sets that were read, pair by pair; also by their activations where a model looked at
/// them, with an RBF kernel of width `sigma`.
///
/// # Errors
/// [`Error::Eval`].
pub fn compare_read_sets(
    sets: &[ImageSet],
    reading: &ReadSettings,
    settings: &CompareSettings,
    eye: Option<(&Eye, f64)>,
) -> Result<DivergenceReport, Error> {
    let mut report = compare_sets(sets, reading, settings, &[])?;
    if let Some((eye, sigma)) = eye {
        eye.compare(sets, sigma, settings, &mut report)?;
    }
    Ok(report)
}

/// The networks of a folder.
fn networks(source: &Source, limit: Option<usize>) -> Vec<Result<NamedPattern, FailedImage>> {
    let files = source.files().filter(|file| {
        file.as_ref()
            .map_or(true, |file| file.name.to_lowercase().ends_with(".json"))
    });
    files
        .take(limit.unwrap_or(usize::MAX))
        .map(|file| {
            let file = file.map_err(|bad| FailedImage {
                name: bad.place,
                reason: bad.reason,
            })?;
            let failed = |reason: String| FailedImage {
                name: file.name.clone(),
                reason,
            };
            let imported = read_network(&file.path).map_err(|error| failed(error.to_string()))?;
            let geometry =
                crack_geometry(&imported.network).map_err(|error| failed(error.to_string()))?;
            Ok(NamedPattern {
                name: file.name.clone(),
                digest: imported.sha256,
                geometry,
            })
        })
        .collect()
}
