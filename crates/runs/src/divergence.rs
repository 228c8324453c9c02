//! Sets of images as they are named, and read: what `starbreak divergence` compares.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;
use starbreak_dataset::{
    BadRecord, ImageLimits, Source, SourceFile, SourceFormat, SourceSpec, blake3_hex, read_image,
};
use starbreak_detect::{Detector, DetectorOptions};
use starbreak_eval::EvalError;
use starbreak_eval::divergence::{FailedImage, ImageSet, Item, ReadSettings};
use starbreak_glass::CrackNetwork;

use crate::Error;
use crate::bank::{BankIn, PatternBank};
use crate::read_network;

/// Before the folder of crack networks.
const NETWORKS: &str = "networks:";

/// Most draws of each kind.
pub const MAX_DRAWS: usize = 1_000_000;

/// Longest side that images are analyzed at, px.
pub const MAX_SIDE_PX: u32 = 8192;

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
    /// [`Error::Detect`] for a model that cannot be read, or has no such layer.
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
}

/// A set that was named.
#[derive(Debug)]
pub struct NamedSet {
    name: String,
    spec: SourceSpec,
    is_networks: bool,
}

impl NamedSet {
    /// `[NAME=]FORMAT:PATH`; the format may be `networks`, for the crack networks of a folder.
    ///
    /// # Errors
    /// [`Error::Dataset`] for an unknown format.
    pub fn parse(text: &OsStr) -> Result<Self, Error> {
        let (name, rest) = match text.to_str().and_then(|text| text.split_once('=')) {
            Some((name, rest)) if !name.is_empty() && !name.contains([':', '/']) => {
                (name.to_owned(), OsString::from(rest))
            }
            _ => (text.to_string_lossy().into_owned(), text.to_owned()),
        };
        let folder = rest.to_str().and_then(|rest| rest.strip_prefix(NETWORKS));
        Ok(Self {
            name,
            spec: match folder {
                Some(folder) => SourceSpec::new(SourceFormat::Folder, folder),
                None => SourceSpec::parse(&rest)?,
            },
            is_networks: folder.is_some(),
        })
    }

    /// As [`NamedSet::parse`], and a folder without a format is a folder of images, or of this
    /// format where it has its layout.
    #[must_use]
    pub fn parse_or(text: &OsStr, name: &str, layout: Option<SourceFormat>) -> Self {
        let name = name.to_owned();
        if let Ok(named) = Self::parse(text) {
            return Self { name, ..named };
        }
        let spec = |format| SourceSpec::new(format, text);
        let special = layout.map(spec).filter(|spec| Source::open(spec).is_ok());
        Self {
            name,
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

    /// Opens it; at most the first `limit` images count. A plain folder that holds a bank of cracks
    /// is that bank, whose patterns are rendered on black.
    ///
    /// # Errors
    /// [`Error::Dataset`] for a folder that is not what its format says.
    pub fn open(&self, limit: Option<usize>) -> Result<OpenSet<'_>, Error> {
        let limit = limit.unwrap_or(usize::MAX);
        let is_folder = self.spec.format == SourceFormat::Folder && !self.is_networks;
        let (kind, members) = match BankIn::folder(&self.spec.path).filter(|_| is_folder) {
            Some(BankIn::Cracks) => {
                let bank = PatternBank::open(&self.spec.path)?;
                let name = |idx| Ok((format!("pattern {idx}"), self.spec.path.clone()));
                let members = (0..bank.len().min(limit)).map(name).collect();
                (Kind::Bank(Box::new(bank)), members)
            }
            Some(BankIn::Photos) => {
                return Err(Error::Divergence {
                    why: format!(
                        "{}: {:?} is a bank of photographs; give the folder of the photographs",
                        self.name, self.spec.path
                    ),
                });
            }
            None if self.is_networks => {
                let source = Source::open(&self.spec)?;
                let is_network = |file: &SourceFile| file.name.to_lowercase().ends_with(".json");
                let files = source.files();
                let files = files.filter(|file| file.as_ref().map_or(true, is_network));
                let files = files.map(|file| file.map(|file| (file.name, file.path)));
                (Kind::Networks, files.take(limit).collect())
            }
            None => {
                let source = Source::open(&self.spec)?;
                let images = source.images().take(limit);
                let images = images.map(|image| image.map(|image| (image.name, image.path)));
                (Kind::Images, images.collect())
            }
        };
        Ok(OpenSet {
            name: &self.name,
            kind,
            members,
        })
    }
}

/// A set that is open.
#[derive(Debug)]
pub struct OpenSet<'a> {
    name: &'a str,
    kind: Kind,
    /// Name and file of each.
    members: Vec<Result<(String, PathBuf), BadRecord>>,
}

/// What a set is made of.
#[derive(Debug)]
enum Kind {
    Images,
    Networks,
    /// The patterns of a bank, as pictures.
    Bank(Box<PatternBank>),
}

impl OpenSet<'_> {
    /// How many images, networks or patterns will be read.
    #[must_use]
    pub fn n(&self) -> usize {
        self.members.len()
    }

    /// Reads it, in the thread pool of the caller, with one decoded image per thread in memory; the same for
    /// any number of threads. What cannot be read is listed, and the rest is taken. `step` is called after
    /// each image. Once `stop` is set, no further one begins, and each one left has failed.
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
        let members = self.members.par_iter().enumerate();
        let items = members.map(|(idx, member)| {
            let (name, path) = member.as_ref().map_err(|bad| FailedImage {
                name: bad.place.clone(),
                reason: bad.reason.clone(),
            })?;
            let item = if stop.load(Ordering::Relaxed) {
                Err(Error::Interrupted)
            } else {
                self.item(idx, name, path, reading, eye)
            };
            step();
            item.map_err(|error| FailedImage {
                name: name.clone(),
                reason: error.to_string(),
            })
        });
        let origin = eye.map(|eye| eye.origin.as_str());
        Ok(ImageSet::new(self.name, items.collect(), origin)?)
    }

    /// One of its images, networks or patterns.
    fn item(
        &self,
        idx: usize,
        name: &str,
        path: &Path,
        reading: &ReadSettings,
        eye: Option<&Eye>,
    ) -> Result<Item, Error> {
        let (pixels, digest) = match &self.kind {
            Kind::Networks => {
                let imported = read_network(path)?;
                return Ok(network_item(name, imported.sha256, &imported.network)?);
            }
            Kind::Images => {
                let file = read_image(path, &ImageLimits::default())?;
                (file.pixels, file.blake3)
            }
            Kind::Bank(bank) => {
                let picture = bank.picture(idx)?;
                let digest = blake3_hex(picture.as_bytes());
                (picture, digest)
            }
        };
        let rgb = reading.opaque(&pixels);
        let vector = match eye {
            Some(eye) => {
                let detector = &eye.detector;
                detector.pooled_activations(self.name, &rgb, &eye.layer)?
            }
            None => Vec::new(),
        };
        Ok(Item::of_image(name, digest, &rgb, reading, vector))
    }
}

/// A network, in diagonals of its pane.
fn network_item(name: &str, digest: String, network: &CrackNetwork) -> Result<Item, EvalError> {
    let data = network.data();
    let places = data.nodes.x.iter().zip(&data.nodes.y);
    let nodes: Vec<[f64; 2]> = places.map(|(x, y)| [*x, *y]).collect();
    let place = |node: &u32| usize::try_from(*node).unwrap_or(usize::MAX);
    let ends = data.segments.from.iter().zip(&data.segments.to);
    let segments: Vec<[usize; 2]> = ends.map(|(from, to)| [place(from), place(to)]).collect();
    let diagonal = libm::hypot(data.pane.width, data.pane.height);
    Item::of_network(name, digest, &nodes, &segments, diagonal)
}
