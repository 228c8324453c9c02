//! Sets of the command line, read with a progress bar.

use starbreak_eval::divergence::{ImageSet, ReadSettings};
use starbreak_runs::divergence::{Eye, NamedSet};

use super::wide;
use crate::args::Global;
use crate::args::divergence::DivergenceArgs;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::screen::Screen;

/// The model of the command line, if there is one.
pub(super) fn eye(args: &DivergenceArgs) -> Result<Option<Eye>, Failure> {
    match &args.model {
        Some(model) => Ok(Some(Eye::open(model, args.layer.as_deref())?)),
        None => Ok(None),
    }
}

/// Reads a set, and says which images could not be.
pub(super) fn read(
    named: &NamedSet,
    args: &DivergenceArgs,
    reading: &ReadSettings,
    eye: Option<&Eye>,
    interrupt: &Interrupt,
    screen: &Screen,
) -> Result<ImageSet, Failure> {
    let open = named.open(args.limit.map(wide))?;
    let n = open.n_images();
    let progress = screen.progress(u64::try_from(n).unwrap_or(u64::MAX), "images");
    let set = open.read(reading, eye, interrupt.flag(), &|| progress.step());
    progress.finish();
    interrupt.check()?;
    let set = set?;
    for failed in set.failed() {
        screen.note(&format!(
            "{}: {}: {}",
            named.name(),
            failed.name,
            failed.reason
        ));
    }
    Ok(set)
}

/// All sets of the command line; no two of one name.
pub(super) fn read_all(
    global: &Global,
    args: &DivergenceArgs,
    reading: &ReadSettings,
    eye: Option<&Eye>,
    interrupt: &Interrupt,
    screen: &Screen,
) -> Result<Vec<ImageSet>, Failure> {
    let named = NamedSet::parse_all(&args.sets)?.into_iter();
    named
        .map(|named| named.following_links(global.follow_links))
        .map(|named| read(&named, args, reading, eye, interrupt, screen))
        .collect()
}
