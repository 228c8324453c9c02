//! `starbreak patterns --overlays`: a bank of random parts of photographs of broken glass.

use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use serde_json::{Value, json};
use starbreak_runs::bank::{
    OVERLAY_BANK_FILE, OverlayBank, OverlayBankHeader, OverlayRow, write_overlay_bank,
};
use starbreak_runs::with_threads;

use super::patterns::bytes_text;
use crate::args::Global;
use crate::args::patterns::PatternsArgs;
use crate::failure::{DONE, Failure};
use crate::interrupt::Interrupt;
use crate::screen::{Screen, path_text};

/// Makes a bank of `n` parts of the photos in a folder, in the folder `output`.
pub(crate) fn run(
    global: &Global,
    args: &PatternsArgs,
    photos: &Path,
    (n, output): (u32, &Path),
    screen: &Screen,
) -> Result<u8, Failure> {
    let &[size] = args.size.as_slice() else {
        return Err(Failure::wrong_input(
            "a bank of photos is for one --size; frames of other sizes get parts of the same photos that are drawn for \
             them",
        ));
    };
    let options = args.overlay.options(true)?;
    let to = output.join(OVERLAY_BANK_FILE);
    let table = output.join("overlays.csv");
    global.refuse_taken(&[to.clone(), table.clone()])?;
    let interrupt = Interrupt::listen(screen);
    let started = Instant::now();
    let progress = screen.progress(u64::from(n), "patterns");
    let draft = with_threads(usize::from(global.threads), || {
        write_overlay_bank(
            photos,
            &options,
            n as usize,
            size,
            global.seed(),
            (global.batch(), &to),
            interrupt.flag(),
            || progress.step(),
        )
    })?;
    progress.finish();
    let draft = draft.map_err(|error| match error {
        starbreak_runs::Error::Interrupted => Failure::interrupted(
            "interrupted: a bank is written as a whole or not at all, so nothing was written; run the command again",
        ),
        error => error.into(),
    })?;
    let (header, sha256, n_bytes) = (
        draft.header.clone(),
        draft.sha256().to_owned(),
        draft.n_bytes(),
    );
    let n = draft.rows.len();
    let mut shares: Vec<f64> = draft.rows.iter().map(|row| row.area_share).collect();
    shares.sort_by(f64::total_cmp);
    let rank = |share: usize| shares.get(n * share / 100).copied().unwrap_or(0.0) * 100.0;
    let area_percent = [rank(5), rank(50), rank(95)];
    let n_empty = shares.iter().take_while(|share| **share <= 0.0).count();
    let csv = csv(&draft.rows).into_bytes();
    interrupt.check()?;
    draft.commit(&[(table.clone(), csv)])?;
    let elapsed_s = started.elapsed().as_secs_f64();
    screen.say(&format!(
        "{n} parts of {} photos for frames of {} × {} px in {elapsed_s:.1} s, {}",
        header.photos.len(),
        size.0,
        size.1,
        bytes_text(n_bytes)
    ));
    screen.say(&format!(
        "glass covers {:.2} % of the frame in the middle (5 % to 95 %: {:.2} to {:.2} %), nothing in {n_empty}",
        area_percent[1], area_percent[0], area_percent[2]
    ));
    screen.say(&format!("sha256 {sha256}"));
    screen.say(&format!("statistics in {}", table.display()));
    screen.result(|| {
        let mut result = described(&header, n, &to, &sha256);
        result["bytes"] = n_bytes.into();
        result["seconds"] = elapsed_s.into();
        result["statistics"] = json!({ "area_percent": area_percent, "n_empty": n_empty });
        result["files"] = json!([path_text(&table)]);
        result
    })?;
    Ok(DONE)
}

/// What a bank was made from. All of it has been read then, and its checksums verified.
pub(crate) fn info(path: &Path, screen: &Screen) -> Result<u8, Failure> {
    let bank = OverlayBank::open(path)?;
    let header = bank.header();
    screen.say(&format!(
        "{} is whole: {} parts of {} photos for frames of {} × {} px",
        path.display(),
        bank.len(),
        header.photos.len(),
        header.size.0,
        header.size.1
    ));
    screen.say(&format!(
        "made by {} {}, seed {}",
        header.generator.name, header.generator.version, header.seed.0
    ));
    screen.say(&format!("sha256 {}", bank.sha256()));
    screen.result(|| {
        let mut result = described(header, bank.len(), path, bank.sha256());
        result["whole"] = true.into();
        result
    })?;
    Ok(DONE)
}

fn described(header: &OverlayBankHeader, n: usize, path: &Path, sha256: &str) -> Value {
    json!({
        "bank": path_text(path),
        "kind": "overlays",
        "n_patterns": n,
        "sha256": sha256,
        "header": header,
    })
}

/// One line for each pattern.
fn csv(rows: &[OverlayRow]) -> String {
    let mut text = String::from(
        "idx,left_px,top_px,width_px,height_px,flip_horizontal,flip_vertical,area_share,photo\n",
    );
    for row in rows {
        let place = &row.placement;
        // Names may have commas in them.
        let photo = row.photo.replace('"', "\"\"");
        let _ = writeln!(
            text,
            "{},{:.2},{:.2},{:.2},{:.2},{},{},{:.6},\"{photo}\"",
            row.idx,
            place.left_px,
            place.top_px,
            place.width_px,
            place.height_px,
            u8::from(place.flip_horizontal),
            u8::from(place.flip_vertical),
            row.area_share,
        );
    }
    text
}
