//! Sets as they are named on the command line.

use std::ffi::{OsStr, OsString};

use image::RgbImage;
use starbreak::dataset::{Source, SourceFormat, SourceSpec};
use starbreak::import::{crack_geometry, read_network};
use starbreak_eval::detector::{Detector, DetectorOptions};
use starbreak_eval::divergence::{
    CompareSettings, DivergenceReport, FailedImage, ImageSet, NamedPattern, ReadSettings, VectorOf,
    compare_vectors,
};

use super::wide;
use crate::args::divergence::DivergenceArgs;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::screen::Screen;

/// Before the folder of crack networks.
const NETWORKS: &str = "networks:";

/// The model by whose activations images are compared.
pub(super) struct Eye {
    detector: Detector,
    layer: String,
    origin: String,
}

impl Eye {
    /// The model of the command line, if there is one.
    pub(super) fn open(args: &DivergenceArgs) -> Result<Option<Self>, Failure> {
        let Some(file) = &args.model else {
            return Ok(None);
        };
        let detector = Detector::open(file, &DetectorOptions::default())?;
        let layer = match &args.layer {
            Some(layer) => layer.clone(),
            None => detector.coarsest_layer()?,
        };
        let origin = format!("{}, layer {layer}, channel means", file.display());
        Ok(Some(Self {
            detector,
            layer,
            origin,
        }))
    }

    /// Adds the comparison of activations to each pair of a report; sets of one image have none.
    pub(super) fn compare(
        &self,
        sets: &[ImageSet],
        args: &DivergenceArgs,
        settings: &CompareSettings,
        report: &mut DivergenceReport,
    ) -> Result<(), Failure> {
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
            let compared = compare_vectors(of_a, of_b, &self.origin, args.sigma, [a, b], settings)?;
            pair.activations = Some(compared);
        }
        Ok(())
    }
}

/// A set that was named.
pub(super) struct Named {
    name: String,
    spec: SourceSpec,
    is_networks: bool,
}

impl Named {
    /// `[NAME=]FORMAT:PATH`.
    pub(super) fn parse(text: &OsStr) -> Result<Self, Failure> {
        let whole = text.to_string_lossy();
        let (name, rest) = match text.to_str().and_then(|text| text.split_once('=')) {
            Some((name, rest)) if !name.is_empty() && !name.contains([':', '/']) => {
                (name.to_owned(), OsString::from(rest))
            }
            _ => (whole.clone().into_owned(), text.to_owned()),
        };
        if let Some(folder) = rest.to_str().and_then(|rest| rest.strip_prefix(NETWORKS)) {
            let spec = SourceSpec {
                format: SourceFormat::Folder,
                path: folder.into(),
            };
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

    /// As [`Named::parse`], and a folder without a format is a folder of images, or of this format
    /// where it has its layout.
    pub(super) fn parse_or(
        text: &OsStr,
        name: &str,
        layout: Option<SourceFormat>,
    ) -> Result<Self, Failure> {
        if let Ok(named) = Self::parse(text) {
            return Ok(Self {
                name: name.to_owned(),
                ..named
            });
        }
        let spec = |format| SourceSpec {
            format,
            path: text.into(),
        };
        let special = layout.map(spec).filter(|spec| Source::open(spec).is_ok());
        Ok(Self {
            name: name.to_owned(),
            spec: special.unwrap_or_else(|| spec(SourceFormat::Folder)),
            is_networks: false,
        })
    }

    pub(super) fn read(
        &self,
        args: &DivergenceArgs,
        reading: &ReadSettings,
        eye: Option<&Eye>,
        interrupt: &Interrupt,
        screen: &Screen,
    ) -> Result<ImageSet, Failure> {
        let source = Source::open(&self.spec)?;
        let limit = args.limit.map(wide);
        if self.is_networks {
            return Ok(ImageSet::of_patterns(&self.name, networks(&source, limit))?);
        }
        let n = source.images().take(limit.unwrap_or(usize::MAX)).count();
        let progress = screen.progress(u64::try_from(n).unwrap_or(u64::MAX), "images");
        let vector_of = |image: &RgbImage| -> Result<Vec<f32>, String> {
            let Some(eye) = eye else {
                return Ok(Vec::new());
            };
            let found = eye
                .detector
                .pooled_activations(&self.name, image, &eye.layer);
            found.map_err(|error| error.to_string())
        };
        let set = ImageSet::read(
            &self.name,
            &source,
            reading,
            limit,
            eye.map(|_| &vector_of as &VectorOf<'_>),
            interrupt.flag(),
            &|| progress.step(),
        );
        progress.finish();
        interrupt.check()?;
        let set = set?;
        for failed in set.failed() {
            screen.note(&format!(
                "{}: {}: {}",
                self.name, failed.name, failed.reason
            ));
        }
        Ok(set)
    }
}

/// All sets of the command line; no two of one name.
pub(super) fn read_all(
    texts: &[OsString],
    args: &DivergenceArgs,
    reading: &ReadSettings,
    eye: Option<&Eye>,
    interrupt: &Interrupt,
    screen: &Screen,
) -> Result<Vec<ImageSet>, Failure> {
    if texts.len() < 2 {
        return Err(Failure::wrong_input(
            "divergence compares two sets or more; for the noise floor of one, give it twice under two names (a=folder:DIR b=folder:DIR)",
        ));
    }
    let mut named: Vec<Named> = Vec::new();
    for text in texts {
        let set = Named::parse(text)?;
        if let Some(other) = named.iter().find(|other| other.name == set.name) {
            return Err(Failure::wrong_input(format!(
                "two sets are called {:?}; name them: a={} b={}",
                other.name,
                text.to_string_lossy(),
                text.to_string_lossy()
            )));
        }
        named.push(set);
    }
    named
        .iter()
        .map(|set| set.read(args, reading, eye, interrupt, screen))
        .collect()
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
                sha256: imported.sha256,
                geometry,
            })
        })
        .collect()
}
