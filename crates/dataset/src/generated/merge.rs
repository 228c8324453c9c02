//! Shards of one run, each in a folder of its own, to the set that one run would have made.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::identity::difference;
use super::lists::read_list;
use super::{
    CarriedFile, Carry, GeneratedSet, ItemRecord, Manifest, SetChecker, SetLayout, set_identity,
};
use crate::error::DatasetError;
use crate::paths::is_inside;
use crate::provenance::blake3_file;

/// What a merge has done.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MergeReport {
    /// What the merged set says of itself.
    pub manifest: Manifest,
    /// Number of shards.
    pub n_shards: u64,
}

/// One shard.
struct Part {
    layout: SetLayout,
    manifest: Manifest,
}

/// Joins the shards of one run in `out`. Files get a second name there where the disk gives one,
/// else they are copied; the parts stay as they are. Without `has_images` the images have been removed
/// from the parts: masks, records and lists are joined.
///
/// # Errors
/// [`DatasetError::NotASet`] for a part that is no finished shard, [`DatasetError::OtherSet`] for
/// parts of different runs, [`DatasetError::Shards`] for shards that are missing or there twice,
/// and for a file that is not what the lists of its shard say.
pub fn merge_sets(
    parts: &[PathBuf],
    out: &Path,
    has_images: bool,
) -> Result<MergeReport, DatasetError> {
    let (parts, identity) = shards(parts)?;
    let n_samples = identity["samples"].as_u64().unwrap_or(1);
    let n_samples = u32::try_from(n_samples).unwrap_or(1);
    for part in parts.values() {
        if is_inside(out, part.layout.root()) || is_inside(part.layout.root(), out) {
            return Err(DatasetError::OutputInInput {
                input: part.layout.root().to_owned(),
                output: out.to_owned(),
            });
        }
    }
    let files = other_files(&parts)?;
    // Before anything is written: a file that is not as it was made ends the merge.
    each_file(&parts, &files, has_images, &mut Part::check)?;
    let set = GeneratedSet::begin(out, n_samples, &identity)?;
    each_file(&parts, &files, has_images, &mut |part, name, blake3| {
        part.give(&set, name, blake3)
    })?;
    let (mut n_taken, mut n_failed, mut n_skipped) = (0, 0, 0);
    for part in parts.values() {
        n_taken += part.manifest.n_items + part.manifest.n_failed;
        n_failed += part.manifest.n_failed;
        // Each shard has seen the whole source.
        n_skipped = n_skipped.max(part.manifest.n_skipped);
    }
    for name in ["failures.jsonl", "skipped.jsonl"] {
        set.put_state(name, joined(&parts, name)?.as_deref())?;
    }
    if let Some(first) = parts.values().next() {
        let recipe = first.layout.state("recipe.toml");
        set.carry(
            &recipe,
            &format!("{}/recipe.toml", super::STATE_FOLDER),
            Carry::HardLink,
        )?;
    }
    let n_shards = parts.len() as u64;
    let files: Vec<CarriedFile> = files.into_values().map(|(_, file)| file).collect();
    let mut items = in_order(&parts)?;
    let manifest = set.finish(&mut items, &files, n_taken, [n_failed, n_skipped])?;
    Ok(MergeReport { manifest, n_shards })
}

/// Hands over each file of the parts by its name, with the hash that the lists say.
fn each_file(
    parts: &BTreeMap<u64, Part>,
    others: &BTreeMap<String, (&Part, CarriedFile)>,
    has_images: bool,
    take: &mut dyn FnMut(&Part, &str, &str) -> Result<(), DatasetError>,
) -> Result<(), DatasetError> {
    for (name, (part, file)) in others {
        take(part, name, &file.blake3)?;
    }
    for part in parts.values() {
        for item in read_list::<ItemRecord>(&part.layout.state("items.jsonl"))? {
            let item = item?;
            let named = part.layout.files_of(&item.name, item.sample);
            let images = [
                (&named.image, has_images.then_some(&item.image_blake3)),
                (&named.region, item.region_blake3.as_ref()),
                (&named.crack, item.crack_blake3.as_ref()),
                (&named.provenance, Some(&item.provenance_blake3)),
            ];
            for (name, blake3) in images {
                if let Some(blake3) = blake3 {
                    take(part, name, blake3)?;
                }
            }
        }
    }
    Ok(())
}

impl Part {
    /// Refuses a file that is not what the part's lists say.
    fn check(&self, name: &str, blake3: &str) -> Result<(), DatasetError> {
        let from = self.layout.safe(name)?;
        expect_listed(&from, &blake3_file(&from)?, blake3)
    }

    /// Gives a set a file, if it is still what the part's lists say.
    fn give(&self, set: &GeneratedSet, name: &str, blake3: &str) -> Result<(), DatasetError> {
        let from = self.layout.safe(name)?;
        let carried = set.carry(&from, name, Carry::HardLink)?;
        expect_listed(&from, &carried.blake3, blake3)
    }
}

fn expect_listed(from: &Path, found: &str, listed: &str) -> Result<(), DatasetError> {
    if found == listed {
        return Ok(());
    }
    Err(DatasetError::Shards {
        reason: format!(
            "{from:?} is not what the lists of its shard say; make this shard again by its own command, then join all"
        ),
    })
}

/// The files beside the images by their names, each with the first part that has it.
fn other_files(
    parts: &BTreeMap<u64, Part>,
) -> Result<BTreeMap<String, (&Part, CarriedFile)>, DatasetError> {
    let mut files: BTreeMap<String, (&Part, CarriedFile)> = BTreeMap::new();
    for part in parts.values() {
        for file in read_list::<CarriedFile>(&part.layout.state("files.jsonl"))? {
            let file = file?;
            match files.get(&file.name) {
                Some((_, first)) if first.blake3 != file.blake3 => {
                    return Err(DatasetError::Shards {
                        reason: format!(
                            "two of them have {:?} with different bytes; the source has changed between them, so make \
                             them anew",
                            file.name
                        ),
                    });
                }
                Some(_) => {}
                None => {
                    files.insert(file.name.clone(), (part, file));
                }
            }
        }
    }
    Ok(files)
}

/// The parts by their number, and what the whole set is made from.
fn shards(paths: &[PathBuf]) -> Result<(BTreeMap<u64, Part>, Value), DatasetError> {
    let mut parts = BTreeMap::new();
    let mut whole: Option<(Value, u64)> = None;
    for path in paths {
        let mut identity = set_identity(path)?;
        let shard = identity
            .as_object_mut()
            .and_then(|identity| identity.remove("shard"))
            .unwrap_or_default();
        let (Some(number), Some(of)) = (shard["number"].as_u64(), shard["of"].as_u64()) else {
            return Err(DatasetError::NotASet {
                path: path.clone(),
                reason: "it is not a shard: it was made without --shard".to_owned(),
            });
        };
        match &whole {
            None => whole = Some((identity.clone(), of)),
            Some((first, first_of)) => {
                let differs = difference(&identity, first, "").or_else(|| {
                    (of != *first_of)
                        .then(|| ("shard.of".to_owned(), of.into(), (*first_of).into()))
                });
                if let Some((key, found, wanted)) = differs {
                    return Err(DatasetError::OtherSet {
                        path: path.clone(),
                        key,
                        found: found.to_string(),
                        wanted: wanted.to_string(),
                    });
                }
            }
        }
        let checker = SetChecker::open(path)?;
        if let Some(finding) = checker.check_lists()?.first() {
            return Err(DatasetError::NotASet {
                path: path.clone(),
                reason: format!("{finding}; make this shard again by its own command"),
            });
        }
        let part = Part {
            layout: checker.layout().clone(),
            manifest: checker.manifest().clone(),
        };
        if parts.insert(number, part).is_some() {
            return Err(DatasetError::Shards {
                reason: format!("number {number} is there twice; give each of them once"),
            });
        }
    }
    let Some((identity, of)) = whole else {
        return Err(DatasetError::Shards {
            reason: "none was given; give each of them once".to_owned(),
        });
    };
    if let Some(missing) = (1..=of).find(|number| !parts.contains_key(number)) {
        return Err(DatasetError::Shards {
            reason: format!("number {missing} of {of} is missing; give each of them once"),
        });
    }
    Ok((parts, identity))
}

/// The items of all parts in the order of the source, which is that of their names.
fn in_order(
    parts: &BTreeMap<u64, Part>,
) -> Result<impl Iterator<Item = Result<ItemRecord, DatasetError>> + use<>, DatasetError> {
    let mut lists = Vec::new();
    for part in parts.values() {
        let list = read_list::<ItemRecord>(&part.layout.state("items.jsonl"))?;
        lists.push(list.peekable());
    }
    Ok(std::iter::from_fn(move || {
        let mut least: Option<(usize, (String, u32))> = None;
        for (k, list) in lists.iter_mut().enumerate() {
            match list.peek() {
                // An error is passed on at once.
                Some(Err(_)) => return list.next(),
                Some(Ok(item)) => {
                    let key = (item.name.clone(), item.sample);
                    if least.as_ref().is_none_or(|(_, least)| key < *least) {
                        least = Some((k, key));
                    }
                }
                None => {}
            }
        }
        least.and_then(|(k, _)| lists[k].next())
    }))
}

/// The lines of one list of all parts, each once, sorted; none where no part has it.
fn joined(parts: &BTreeMap<u64, Part>, name: &str) -> Result<Option<String>, DatasetError> {
    let mut lines = std::collections::BTreeSet::new();
    for part in parts.values() {
        let path = part.layout.state(name);
        if super::is_there(&path)? {
            for line in read_list::<Value>(&path)? {
                lines.insert(line?.to_string());
            }
        }
    }
    Ok((!lines.is_empty()).then(|| lines.into_iter().map(|line| line + "\n").collect()))
}
