//! Photographs of broken glass in a bank: each file once, and the part that each pattern takes.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use starbreak::photo::{OverlayOptions, PlacedPhoto};
use starbreak_dataset::{
    BankFile, BankRecord, BankWriter, ImageLimits, OutputBatch, WrittenBank, file_in, read_bytes,
    refuse_inside_set,
};
use starbreak_glass::Generator;
use starbreak_optics::photo::{Background, PhotoParams, Placement, PlacementRange, covered_share};
use starbreak_seed::Seed;

use super::header::read_header;
use crate::Error;
use crate::overlay::{OverlaySet, photo_files, photo_of_bytes};

/// Name of the file in the folder of a bank of photographs.
pub const OVERLAY_BANK_FILE: &str = "overlays.bank";

/// Name and version of the format, the value of its header's `schema`.
pub const OVERLAY_BANK_SCHEMA: &str = "starbreak.overlay-bank/1";

/// What the patterns of a bank of photographs were made from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OverlayBankHeader {
    /// [`OVERLAY_BANK_SCHEMA`].
    pub schema: String,
    /// The program that made it.
    pub generator: Generator,
    /// The seed; pattern k is drawn by the seed of (`patterns`, k) of it.
    pub seed: Seed,
    /// Frame that the parts were drawn for, width and height, px. In a frame of another size
    /// pattern k is the same photograph, and a part that is drawn for that size.
    pub size: (u32, u32),
    /// What is behind the glass, or `auto`.
    pub background: String,
    /// See [`PhotoParams::floor`].
    pub floor: f64,
    /// See [`OverlayOptions::gain`].
    pub gain: f64,
    /// See [`PlacementRange::min_scale`].
    pub min_scale: f64,
    /// See [`PlacementRange::max_shift`].
    pub max_shift: f64,
    /// Names of the photographs; their bytes are the first records.
    pub photos: Vec<String>,
}

/// A pattern in the last record of the file.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct StoredPart {
    photo: usize,
    left_px: f64,
    top_px: f64,
    width_px: f64,
    height_px: f64,
    flip_horizontal: bool,
    flip_vertical: bool,
}

/// A row of the statistics of a bank of photographs.
#[derive(Debug, Clone, PartialEq)]
pub struct OverlayRow {
    /// Number of the pattern, from 0.
    pub idx: usize,
    /// Name of its photograph.
    pub photo: String,
    /// The part of it.
    pub placement: Placement,
    /// Share of the frame that glass covers, 0 to 1: the mean of the crack mask of the physical
    /// optics. The paper's optics draw glass before black or white by its brightness instead.
    pub area_share: f64,
}

/// A bank of photographs under a temporary name.
#[derive(Debug)]
pub struct OverlayBankDraft {
    /// What it was made from.
    pub header: OverlayBankHeader,
    /// Each pattern, in order.
    pub rows: Vec<OverlayRow>,
    written: WrittenBank,
}

/// A bank of photographs in memory.
#[derive(Debug)]
pub struct OverlayBank {
    header: OverlayBankHeader,
    set: OverlaySet,
    parts: Vec<StoredPart>,
    sha256: String,
    path: PathBuf,
}

impl OverlayBankHeader {
    /// The seed of a pattern.
    #[must_use]
    pub fn seed_of(&self, idx: usize) -> Seed {
        self.seed.of_item("patterns", idx as u64)
    }

    fn options(&self) -> Option<OverlayOptions> {
        let background = match self.background.as_str() {
            "auto" => None,
            name => Some(
                [Background::Alpha, Background::Black, Background::White]
                    .into_iter()
                    .find(|background| background.name() == name)?,
            ),
        };
        Some(OverlayOptions {
            params: PhotoParams {
                background,
                floor: self.floor,
            },
            gain: self.gain,
            random: Some(PlacementRange {
                min_scale: self.min_scale,
                max_shift: self.max_shift,
            }),
        })
    }
}

/// Makes a bank of `n` random parts of the photographs below a folder, for frames of a size, px,
/// to be at the path `to`, as a file of the batch. `progress` is called after each pattern.
///
/// Pattern k depends on the photographs, the options, the seed, the size and k alone.
///
/// # Errors
/// As for [`OverlaySet::read`]; [`Error::Interrupted`] once `stop` is set; [`Error::Dataset`]
/// for a path in a generated set, and where the file system refuses.
#[expect(clippy::too_many_arguments, reason = "each says another thing")]
pub fn write_overlay_bank(
    folder: &Path,
    options: &OverlayOptions,
    n: usize,
    size: (u32, u32),
    seed: Seed,
    (batch, to): (OutputBatch, &Path),
    stop: &AtomicBool,
    progress: impl Fn() + Sync,
) -> Result<OverlayBankDraft, Error> {
    refuse_inside_set(to)?;
    options.check()?;
    let range = options.random.unwrap_or_default();
    let options = OverlayOptions {
        random: Some(range),
        ..*options
    };
    let files = photo_files(folder)?;
    let set = OverlaySet::read(folder, &options)?;
    let header = OverlayBankHeader {
        schema: OVERLAY_BANK_SCHEMA.to_owned(),
        generator: Generator {
            name: "starbreak".to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        },
        seed,
        size,
        background: options
            .params
            .background
            .map_or("auto", Background::name)
            .to_owned(),
        floor: options.params.floor,
        gain: options.gain,
        min_scale: range.min_scale,
        max_shift: range.max_shift,
        photos: set
            .photos()
            .iter()
            .map(|glass| glass.name.clone())
            .collect(),
    };
    let rows = (0..n)
        .into_par_iter()
        .map(|idx| {
            if stop.load(Ordering::Relaxed) {
                return Err(Error::Interrupted);
            }
            let placed = set.draw(size, header.seed_of(idx))?;
            let row = OverlayRow {
                idx,
                area_share: covered_share(&placed.glass.photo, &placed.placement, size)?,
                photo: placed.glass.name.clone(),
                placement: placed.placement,
            };
            progress();
            Ok(row)
        })
        .collect::<Result<Vec<_>, Error>>()?;
    let text = serde_json::to_vec(&header).unwrap_or_default();
    let mut writer = BankWriter::create(batch, to, &text)?;
    for file in &files {
        let bytes = read_bytes(&file.path, ImageLimits::default().max_file_bytes)?;
        writer.append(&BankRecord::new(bytes))?;
    }
    let photo_of = |name: &str| header.photos.iter().position(|photo| photo == name);
    let parts: Vec<StoredPart> = rows
        .iter()
        .map(|row| StoredPart::new(photo_of(&row.photo).unwrap_or(0), &row.placement))
        .collect();
    let parts = serde_json::to_vec(&parts).unwrap_or_default();
    writer.append(&BankRecord::new(parts))?;
    Ok(OverlayBankDraft {
        header,
        rows,
        written: writer.finish()?,
    })
}

impl OverlayBankDraft {
    /// SHA-256 that identifies the bank.
    #[must_use]
    pub fn sha256(&self) -> &str {
        self.written.sha256()
    }

    /// Length of the file, in bytes.
    #[must_use]
    pub fn n_bytes(&self) -> u64 {
        self.written.n_bytes()
    }

    /// Gives the bank its name, after some files that belong to it: path and bytes of each.
    /// A draft that is dropped instead leaves nothing.
    ///
    /// # Errors
    /// [`Error::Dataset`] where the file system refuses.
    pub fn commit(self, beside: &[(PathBuf, Vec<u8>)]) -> Result<(), Error> {
        Ok(self.written.commit(beside)?)
    }
}

impl OverlayBank {
    /// Opens a bank of photographs: its file, or the folder with `overlays.bank`. All photographs
    /// are decoded.
    ///
    /// # Errors
    /// [`Error::Dataset`] for a file that cannot be read or is no whole bank, [`Error::Bank`] for
    /// one whose content this version does not know.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let file = BankFile::open(&file_in(path, OVERLAY_BANK_FILE))?;
        let wrong = |why: String| Error::Bank {
            path: file.path().to_owned(),
            idx: None,
            why,
        };
        let header: OverlayBankHeader =
            read_header(&file, OVERLAY_BANK_SCHEMA, "a bank of photographs has")?;
        let n_photos = header.photos.len();
        if n_photos == 0 || file.n_records() != n_photos + 1 {
            return Err(wrong(format!(
                "it has {} records, but its header names {n_photos} photographs",
                file.n_records()
            )));
        }
        let options = header
            .options()
            .ok_or_else(|| wrong(format!("its background is {:?}", header.background)))?;
        options.check()?;
        let parts: Vec<StoredPart> = serde_json::from_slice(&file.read(n_photos)?)
            .map_err(|cause| wrong(format!("its parts are not understood: {cause}")))?;
        if let Some(idx) = parts.iter().position(|part| part.photo >= n_photos) {
            return Err(Error::Bank {
                path: file.path().to_owned(),
                idx: Some(idx),
                why: format!("it has only {n_photos} photographs"),
            });
        }
        for part in &parts {
            part.placement().check()?;
        }
        let photos = header
            .photos
            .par_iter()
            .enumerate()
            .map(|(record, name)| photo_of_bytes(name, &file.read(record)?, &options.params))
            .collect::<Result<Vec<_>, Error>>()?;
        Ok(Self {
            sha256: file.sha256().to_owned(),
            path: file.path().to_owned(),
            set: OverlaySet::of_all(photos, &options),
            header,
            parts,
        })
    }

    /// What it was made from.
    #[must_use]
    pub fn header(&self) -> &OverlayBankHeader {
        &self.header
    }

    /// Number of patterns.
    #[must_use]
    pub fn len(&self) -> usize {
        self.parts.len()
    }

    /// Whether it has none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }

    /// SHA-256 of header and index, which hold the checksums of all records.
    #[must_use]
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// Which pattern the item with this seed gets: each with the same chance.
    #[must_use]
    pub fn idx_for(&self, item_seed: Seed) -> usize {
        let drawn = item_seed.of_item("bank", 0).0;
        usize::try_from(drawn % (self.len() as u64).max(1)).unwrap_or(0)
    }

    /// A pattern for frames of a size, px: the part of the bank, or, for another size than the
    /// bank's, one that its seed draws from the same photograph.
    ///
    /// # Errors
    /// [`Error::Bank`] for a number that it does not have.
    pub fn pattern(&self, idx: usize, size: (u32, u32)) -> Result<PlacedPhoto, Error> {
        let part = self.parts.get(idx).ok_or_else(|| Error::Bank {
            path: self.path.clone(),
            idx: None,
            why: format!("it has no pattern {idx}, only {} (from 0)", self.len()),
        })?;
        let mut placed = self.set.draw(size, self.header.seed_of(idx))?;
        if size == self.header.size {
            placed.placement = part.placement();
            if let Some(glass) = self.set.photos().get(part.photo) {
                placed.glass = Arc::clone(glass);
            }
        }
        Ok(placed)
    }
}

impl StoredPart {
    fn new(photo: usize, placement: &Placement) -> Self {
        let Placement {
            left_px,
            top_px,
            width_px,
            height_px,
            flip_horizontal,
            flip_vertical,
        } = *placement;
        Self {
            photo,
            left_px,
            top_px,
            width_px,
            height_px,
            flip_horizontal,
            flip_vertical,
        }
    }

    fn placement(&self) -> Placement {
        Placement {
            left_px: self.left_px,
            top_px: self.top_px,
            width_px: self.width_px,
            height_px: self.height_px,
            flip_horizontal: self.flip_horizontal,
            flip_vertical: self.flip_vertical,
        }
    }
}
