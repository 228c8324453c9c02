//! Patterns out of a bank.

use std::path::Path;

use image::GrayImage;
use serde_json::{Map, json};
use starbreak::{Chain, PaneLayer, Settings, Stopwatch};
use starbreak_dataset::{BankFile, ImageLimits, decode_image, file_in};
use starbreak_glass::CrackNetwork;
use starbreak_optics::OpticsError;
use starbreak_seed::Seed;

use super::baked::{BakedRecord, bake_record};
use super::header::{BANK_SCHEMA, BankHeader, read_header};
use super::network_record::network_of_bytes;
use super::{BANK_FILE, PatternFacts};
use crate::Error;

/// A bank of patterns, open for reading. In memory there are its header and its index; any number
/// of threads may take patterns out of it at one time.
#[derive(Debug)]
pub struct PatternBank {
    file: BankFile,
    header: BankHeader,
    settings: Settings,
}

/// A pattern of a bank, ready to be shown in images of one size.
#[derive(Debug, Clone)]
pub struct BankPattern {
    /// Its number in the bank.
    pub idx: usize,
    /// What the optics show, ready for any frame of the size.
    pub chain: Chain,
    /// The crack mask as the bytes of a PNG file.
    pub crack_mask_png: Vec<u8>,
    /// Key figures for provenance.
    pub facts: PatternFacts,
}

impl PatternBank {
    /// Opens a bank: its file, or the folder with `patterns.bank`.
    ///
    /// # Errors
    /// [`Error::Dataset`] for a file that cannot be read or is no whole bank, [`Error::Bank`] for
    /// one whose header this version does not know, [`Error::Chain`] for its recipe.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let file = BankFile::open(&file_in(path, BANK_FILE))?;
        let wrong = |why: String| Error::Bank {
            path: file.path().to_owned(),
            idx: None,
            why,
        };
        let header: BankHeader = read_header(&file, BANK_SCHEMA, "this version reads")?;
        if header.sizes.is_empty() || file.n_records() % header.n_records_per_pattern() != 0 {
            return Err(wrong(format!(
                "its {} records do not fit its {} frame sizes",
                file.n_records(),
                header.sizes.len()
            )));
        }
        let settings = header.parse_recipe()?.settings()?;
        Ok(Self {
            file,
            header,
            settings,
        })
    }

    /// Sets the most memory that a pattern may take that is baked anew, bytes.
    pub fn set_max_memory(&mut self, bytes: u64) {
        self.settings.max_memory_bytes = bytes;
    }

    /// Number of patterns.
    #[must_use]
    pub fn len(&self) -> usize {
        self.file.n_records() / self.header.n_records_per_pattern()
    }

    /// Whether it has none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What the patterns were made from.
    #[must_use]
    pub fn header(&self) -> &BankHeader {
        &self.header
    }

    /// The bank's recipe in SI units: camera, optics and output of whatever is shown with it.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// SHA-256 of header and index, which hold the checksums of all records: two banks with the
    /// same digest have the same patterns.
    #[must_use]
    pub fn sha256(&self) -> &str {
        self.file.sha256()
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    /// Length of the file, in bytes.
    #[must_use]
    pub fn n_bytes(&self) -> u64 {
        self.file.n_bytes()
    }

    /// Which pattern the item with this seed gets: each with the same chance.
    #[must_use]
    pub fn idx_for(&self, item_seed: Seed) -> usize {
        let drawn = item_seed.of_item("bank", 0).0;
        usize::try_from(drawn % (self.len() as u64).max(1)).unwrap_or(0)
    }

    /// The crack network of a pattern, the same to the bit as when it was simulated.
    ///
    /// # Errors
    /// [`Error::Dataset`] for a record that cannot be read or is damaged, [`Error::Bank`] for one that holds no
    /// network.
    pub fn network(&self, idx: usize) -> Result<CrackNetwork, Error> {
        let bytes = self.file.read(self.record(idx, 0)?)?;
        network_of_bytes(&bytes).map_err(|why| self.wrong(idx, why))
    }

    /// A pattern for frames of a size, px: from its record, or baked from its network where the
    /// bank does not have the size. A network in px is then stretched over the frame; one in mm
    /// is seen by the recipe's camera, whose frame is larger or smaller, so that the cracks may
    /// lie beyond a frame of other proportions.
    ///
    /// # Errors
    /// As for [`PatternBank::network`], and [`Error::Chain`] where it cannot be baked.
    pub fn pattern(
        &self,
        idx: usize,
        size: (u32, u32),
        watch: &mut Stopwatch,
    ) -> Result<BankPattern, Error> {
        let place = self.header.sizes.iter().position(|known| *known == size);
        let record = match place {
            Some(place) => {
                let bytes = self.file.read(self.record(idx, 1 + place)?)?;
                BakedRecord::of_bytes(bytes).map_err(|why| self.wrong(idx, why))?
            }
            None => {
                let network = self.network(idx)?;
                bake_record(&self.settings, &network, size, self.header.seed_of(idx))?.0
            }
        };
        let (facts, crack_mask_png, layer) = record
            .into_parts(&self.settings)
            .map_err(|cause| self.wrong(idx, cause.to_string()))?;
        if layer.size() != size {
            return Err(self.wrong(idx, "its pattern is of another size".to_owned()));
        }
        watch.lap(if place.is_some() { "unpack" } else { "bake" });
        let said = Map::from_iter([
            (
                "pattern".to_owned(),
                json!({ "bank_sha256": self.sha256(), "idx": idx }),
            ),
            (
                "network".to_owned(),
                json!({
                    "model": facts.model,
                    "damage_class": facts.damage_class,
                    "summary": facts.summary,
                }),
            ),
        ]);
        let is_intact = facts.summary.n_segments == 0 && layer.is_intact();
        Ok(BankPattern {
            idx,
            chain: Chain::of_layer(&self.settings, layer, said, is_intact),
            crack_mask_png,
            facts,
        })
    }

    /// Reads all records and verifies all checksums; `each` is called with the number of each
    /// pattern that was found whole, and ends the check by returning `false`.
    ///
    /// # Errors
    /// [`Error::Dataset`] naming the first record that is damaged, [`Error::Bank`] for one that
    /// does not hold what it should.
    pub fn check(&self, mut each: impl FnMut(usize) -> bool) -> Result<(), Error> {
        let per_pattern = self.header.n_records_per_pattern();
        let mut fault = None;
        self.file.check(|record, bytes| {
            let (idx, part) = (record / per_pattern, record % per_pattern);
            if let Err(why) = self.check_record(part, bytes) {
                fault = Some(self.wrong(idx, why));
                return false;
            }
            part + 1 < per_pattern || each(idx)
        })?;
        fault.map_or(Ok(()), Err)
    }

    fn check_record(&self, part: usize, bytes: Vec<u8>) -> Result<(), String> {
        let Some(place) = part.checked_sub(1) else {
            return network_of_bytes(&bytes).map(|_| ());
        };
        let record = BakedRecord::of_bytes(bytes)?;
        let wrong = |cause: OpticsError| cause.to_string();
        let (_, _, layer) = record.into_parts(&self.settings).map_err(wrong)?;
        if let PaneLayer::Packed(pattern) = &layer {
            pattern.unpack().map_err(wrong)?;
        }
        if self.header.sizes.get(place) == Some(&layer.size()) {
            Ok(())
        } else {
            Err("its pattern is of another size".to_owned())
        }
    }

    /// Number of a record of a pattern: 0 is the network, 1 the first frame size.
    fn record(&self, idx: usize, part: usize) -> Result<usize, Error> {
        if idx < self.len() {
            Ok(idx * self.header.n_records_per_pattern() + part)
        } else {
            Err(Error::Bank {
                path: self.file.path().to_owned(),
                idx: None,
                why: format!("it has no pattern {idx}, only {} (from 0)", self.len()),
            })
        }
    }

    fn wrong(&self, idx: usize, why: String) -> Error {
        Error::Bank {
            path: self.file.path().to_owned(),
            idx: Some(idx),
            why,
        }
    }
}

impl BankPattern {
    /// The crack mask: coverage by cracks as they would be in focus, 255 = in full.
    ///
    /// # Errors
    /// [`Error::Dataset`] for a mask that is no PNG.
    pub fn crack_mask(&self) -> Result<GrayImage, Error> {
        let name = format!("the crack mask of pattern {}", self.idx);
        let file = decode_image(&name, &self.crack_mask_png, &ImageLimits::default())?;
        Ok(file.pixels.into_luma8())
    }
}
