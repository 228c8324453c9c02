//! `starbreak patterns --images-of`: the patterns of a bank as PNG files.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde_json::json;
use starbreak_dataset::{Encoding, encode_image};
use starbreak_runs::bank::PatternBank;
use starbreak_runs::with_threads;

use crate::args::Global;
use crate::args::overlay::is_bank as is_overlay_bank;
use crate::failure::{DONE, Failure};
use crate::interrupt::Interrupt;
use crate::screen::{Screen, path_text};

/// Pictures that are drawn before they are written: enough to keep many threads busy, few in memory.
const AT_ONCE: usize = 64;

/// Writes the first `n` patterns of a bank, or all, to a folder: all of them or none.
pub(crate) fn run(
    global: &Global,
    path: &Path,
    (n, output): (Option<u32>, &Path),
    screen: &Screen,
) -> Result<u8, Failure> {
    if is_overlay_bank(path) {
        return Err(Failure::wrong_input(format!(
            "{path:?} is a bank of photos; --images-of writes those of cracks"
        )));
    }
    let bank = PatternBank::open(path)?;
    let n = n.map_or(bank.len(), |n| n as usize);
    if n > bank.len() {
        return Err(Failure::wrong_input(format!(
            "{path:?} has {} patterns, not {n}; ask for fewer with -n, or for all without it",
            bank.len()
        )));
    }
    let files: Vec<PathBuf> = (0..n)
        .map(|idx| output.join(format!("pattern_{idx:06}.png")))
        .collect();
    let list = output.join("written.json");
    let mut batch = global.batch().with_list(&list, "patterns --images-of");
    files.iter().try_for_each(|file| batch.may_write(file))?;
    let interrupt = Interrupt::listen(screen);
    let progress = screen.progress(n as u64, "images");
    let idxs: Vec<usize> = (0..n).collect();
    for some in idxs.chunks(AT_ONCE) {
        interrupt.check()?;
        let drawn: Vec<Result<Vec<u8>, Failure>> =
            with_threads(usize::from(global.threads), || {
                let draw =
                    |idx: &usize| Ok(encode_image(&bank.picture(*idx)?, &Encoding::Png, None)?);
                some.par_iter().map(draw).collect()
            })?;
        for (idx, png) in some.iter().zip(drawn) {
            let png = png.map_err(|failure| Failure {
                message: format!("pattern {idx} of {path:?}: {}", failure.message),
                ..failure
            })?;
            if let Some(file) = files.get(*idx) {
                batch.stage(file, &png)?;
            }
            progress.step();
        }
    }
    progress.finish();
    interrupt.check()?;
    batch.commit()?;
    screen.say(&format!(
        "wrote {n} patterns as images to {}",
        path_text(output)
    ));
    screen.result(|| {
        json!({
            "bank": path_text(bank.path()),
            "sha256": bank.sha256(),
            "n_images": n,
            "folder": path_text(output),
        })
    })?;
    Ok(DONE)
}
