//! A first walk over a source: which images are taken, and what is wrong with it.

use std::collections::{BTreeSet, BinaryHeap};

use serde::{Deserialize, Serialize};
use starbreak_dataset::{
    BadRecord, FileRole, STATE_FOLDER, SetLayout, Source, SourceFile, SourceImage, sha256_hex,
};
use starbreak_seed::Seed;

use super::Selection;

/// One part of many, by number from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// Which one, from 1.
    pub number: u32,
    /// Of how many.
    pub of: u32,
}

impl Shard {
    /// Whether an image of this name is one of its.
    #[must_use]
    pub fn takes(self, name: &str) -> bool {
        let place = digest(Seed(0), "shard", name) % u64::from(self.of.max(1));
        place + 1 == u64::from(self.number)
    }
}

/// What a first walk over a source has found.
#[derive(Debug, Clone)]
pub struct Survey {
    /// Images of the source.
    pub n_images: u64,
    /// Images that are taken, by this shard.
    pub n_selected: u64,
    /// Labeled objects in these.
    pub n_objects: u64,
    /// Images that cannot be taken, and records that stand for no image.
    pub n_left_out: u64,
    /// Files that look like images but belong to no image of the dataset. They are not carried
    /// over: a cracked set holds no image without a crack.
    pub n_strays: u64,
    has_state: bool,
    /// Records that break the rules of the format, or of a set: images among them are left out.
    pub bad: Vec<BadRecord>,
    /// The names of all images that are taken, shards or not: the SHA-256 of that of the names
    /// before, followed by the name.
    pub(crate) names_sha256: String,
    seed: Seed,
    selection: Selection,
    /// The last image that a limit takes.
    last: Option<String>,
    /// The highest rank that a sample takes.
    highest_rank: Option<u64>,
    /// Digests of the names that there were: images that come later belong to no set of this survey.
    names: BTreeSet<u64>,
    /// Images that cannot be taken.
    left_out: BTreeSet<String>,
    /// Digests of the bad records in the place of images.
    bad_digests: BTreeSet<u64>,
}

/// Walks over a source, twice where images are drawn. Labels are read and checked, images are not
/// opened.
#[must_use]
pub fn survey(source: &Source, selection: Selection, seed: Seed) -> Survey {
    let mut survey = Survey {
        n_images: 0,
        n_selected: 0,
        n_objects: 0,
        n_left_out: 0,
        n_strays: 0,
        has_state: false,
        bad: Vec::new(),
        names_sha256: sha256_hex(b""),
        seed,
        selection,
        last: None,
        highest_rank: None,
        names: BTreeSet::new(),
        left_out: BTreeSet::new(),
        bad_digests: BTreeSet::new(),
    };
    survey.walk(source);
    if selection.sample.is_some() {
        for image in source.images().filter_map(Result::ok) {
            survey.count(&image);
        }
    }
    for file in source.files() {
        match file {
            Err(bad) => survey.bad.push(bad),
            Ok(file) if is_state(&file.name) => survey.has_state = true,
            Ok(file) if is_stray(&file) => survey.n_strays += 1,
            Ok(_) => {}
        }
    }
    if survey.has_state {
        survey.bad.push(BadRecord {
            place: STATE_FOLDER.to_owned(),
            reason: "lies where the set keeps its own files; is the source a generated set?"
                .to_owned(),
            image: None,
        });
    }
    survey
}

impl Survey {
    /// Which images were to be taken.
    #[must_use]
    pub const fn selection(&self) -> Selection {
        self.selection
    }

    /// Whether an image belongs to the set that all shards make.
    #[must_use]
    pub fn is_of_set(&self, name: &str) -> bool {
        let in_limit = self.last.as_deref().is_none_or(|last| name <= last);
        let in_sample = self
            .highest_rank
            .is_none_or(|highest| digest(self.seed, "sample", name) <= highest);
        in_limit
            && in_sample
            && self.selection.limit != Some(0)
            && self.selection.sample != Some(0)
            && !self.left_out.contains(name)
            && self.names.contains(&digest_of_name(name))
    }

    /// Whether an image is taken by this run.
    #[must_use]
    pub fn is_selected(&self, name: &str) -> bool {
        let in_shard = self.selection.shard.is_none_or(|shard| shard.takes(name));
        in_shard && self.is_of_set(name)
    }

    /// The images that this run takes, in the order of the source, and what is wrong with those
    /// that were good when the source was surveyed.
    pub(super) fn selected_or_gone<'a>(
        &'a self,
        source: &'a Source,
    ) -> impl Iterator<Item = Result<SourceImage, BadRecord>> + Send + 'a {
        source.images().filter(|image| match image {
            Ok(image) => self.is_selected(&image.name),
            Err(bad) => {
                let is_taken = bad
                    .image
                    .as_ref()
                    .is_some_and(|name| self.is_selected(name));
                is_taken && !self.bad_digests.contains(&digest_of_bad(bad))
            }
        })
    }

    /// The images that this run takes, in the order of the source.
    pub fn selected<'a>(
        &'a self,
        source: &'a Source,
    ) -> impl Iterator<Item = SourceImage> + Send + 'a {
        source
            .images()
            .filter_map(Result::ok)
            .filter(|image| self.is_selected(&image.name))
    }

    /// The names of the images that this run takes, in the order of the source, without a look at
    /// their labels.
    pub(crate) fn selected_names<'a>(
        &'a self,
        source: &'a Source,
    ) -> impl Iterator<Item = String> + Send + 'a {
        source.names().filter(|name| self.is_selected(name))
    }

    /// Finds where the limit and the sample end and which images cannot be taken, and counts what
    /// is taken unless images are drawn.
    fn walk(&mut self, source: &Source) {
        let mut ranks = BinaryHeap::new();
        // Digests of the names of records.
        let mut stems = BTreeSet::new();
        let mut bad = BTreeSet::new();
        let layout = SetLayout::new(std::path::Path::new(""), 1);
        let mut n_good = 0;
        for image in source.images() {
            let image = match image {
                Ok(image) => image,
                Err(record) => {
                    bad.extend(record.image.clone());
                    self.bad_digests.insert(digest_of_bad(&record));
                    self.bad.push(record);
                    self.n_left_out += 1;
                    continue;
                }
            };
            self.n_images += 1;
            let name = &image.name;
            if is_state(name) {
                self.refuse(
                    name,
                    "lies where the set keeps its own files; is the source a generated set?",
                );
                continue;
            }
            let stem = layout.files_of(name, 0).provenance.to_lowercase();
            if !stems.insert(digest(Seed(0), "stem", &stem)) {
                self.refuse(
                    name,
                    "differs from another image only in its extension or in case, so that their masks would have one name",
                );
                continue;
            }
            self.names.insert(digest_of_name(name));
            n_good += 1;
            if let Some(n) = self.selection.sample {
                ranks.push(digest(self.seed, "sample", name));
                if ranks.len() as u64 > n {
                    ranks.pop();
                }
                continue;
            }
            match self.selection.limit {
                Some(limit) if n_good > limit => {}
                limit => {
                    self.last = limit.map(|_| name.clone());
                    self.count(&image);
                }
            }
        }
        // Where an image is taken, the bad record was a second one of it.
        bad.retain(|name| !self.names.contains(&digest_of_name(name)));
        self.left_out.append(&mut bad);
        self.highest_rank = self.selection.sample.and_then(|_| ranks.peek().copied());
    }

    fn count(&mut self, image: &SourceImage) {
        self.bad.extend(image.problems.iter().cloned());
        if self.is_of_set(&image.name) {
            self.names_sha256.push_str(&image.name);
            self.names_sha256 = sha256_hex(self.names_sha256.as_bytes());
        }
        if self.is_selected(&image.name) {
            self.n_selected += 1;
            self.n_objects += image.objects.len() as u64;
        }
    }

    fn refuse(&mut self, name: &str, reason: &str) {
        self.left_out.insert(name.to_owned());
        self.n_left_out += 1;
        self.bad.push(BadRecord {
            place: name.to_owned(),
            reason: reason.to_owned(),
            image: Some(name.to_owned()),
        });
    }
}

fn digest_of_name(name: &str) -> u64 {
    digest(Seed(0), "name", name)
}

fn digest_of_bad(bad: &BadRecord) -> u64 {
    digest(Seed(0), "bad", &bad.to_string())
}

/// Whether a name lies where a set keeps its own files.
pub(super) fn is_state(name: &str) -> bool {
    let rest = name.strip_prefix(STATE_FOLDER);
    rest.is_some_and(|rest| rest.starts_with('/'))
}

/// Whether a file is an image that the dataset does not know as one.
pub(super) fn is_stray(file: &SourceFile) -> bool {
    const EXTENSIONS: [&str; 10] = [
        "png", "jpg", "jpeg", "bmp", "webp", "tif", "tiff", "gif", "heic", "avif",
    ];
    let extension = file.name.rsplit('.').next().unwrap_or_default();
    file.role == FileRole::Other
        && EXTENSIONS
            .iter()
            .any(|known| extension.eq_ignore_ascii_case(known))
}

/// A number that a name stands for, one for each purpose.
fn digest(seed: Seed, purpose: &str, name: &str) -> u64 {
    seed.of_item(&format!("{purpose}/{name}"), 0).0
}
