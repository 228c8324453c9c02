//! `starbreak verify` and `starbreak merge`: finished sets.

use serde_json::{Value, json};
use starbreak_dataset::{Finding, Source, merge_sets};
use starbreak_runs::generate::{RegenerateReport, VerifyReport, regenerate, verify};
use starbreak_runs::with_threads;

use super::generate::patterns;
use crate::args::Global;
use crate::args::generate::{HowMany, MergeArgs, VerifyArgs};
use crate::args::shell_word;
use crate::failure::{DONE, Failure, SOME_FAILED};
use crate::interrupt::Interrupt;
use crate::screen::{Screen, path_text};

/// Findings that are shown one by one.
const MOST_SHOWN: usize = 50;

pub(crate) fn run(global: &Global, args: &VerifyArgs, screen: &Screen) -> Result<u8, Failure> {
    if global.says_what_to_make() {
        return Err(Failure::wrong_input(
            "verify takes recipe and seed from the set itself; leave --preset, --recipe, --severity, --camera, --set and --seed out",
        ));
    }
    let interrupt = Interrupt::listen(screen);
    let progress = screen.progress(0, "files");
    let n_threads = usize::from(global.threads);
    let checked = with_threads(n_threads, || {
        verify(&args.folder, interrupt.flag(), &|| progress.step())
    })??;
    progress.finish();
    show(&checked.findings, screen);
    let again = match (&args.source, args.regenerate) {
        (Some(source), Some(how_many)) => {
            let source = Source::open(&global.spec(source)?)?;
            let photos = args.overlay.read_folder(args.overlays.as_deref())?;
            let patterns = patterns(
                photos,
                (args.bank.as_deref(), global.max_memory),
                args.network.as_deref(),
                &[],
            )?;
            let n = match how_many {
                HowMany::All => None,
                HowMany::Only(n) => Some(n),
            };
            let total = n.unwrap_or(checked.manifest.n_items);
            let progress = screen.progress(total.min(checked.manifest.n_items), "images");
            let again = with_threads(n_threads, || {
                regenerate(
                    &args.folder,
                    &source,
                    &patterns,
                    (n, global.max_memory),
                    interrupt.flag(),
                    &|| {
                        progress.step();
                    },
                )
            })??;
            progress.finish();
            show(&again.findings, screen);
            Some(again)
        }
        _ => None,
    };
    screen.say(&summary(args, &checked, again.as_ref()));
    screen.result(|| result_json(global, args, &checked, again.as_ref()))?;
    if interrupt.is_set() {
        return Err(Failure::interrupted(
            "interrupted: the check is not complete",
        ));
    }
    let n_findings =
        checked.findings.len() + again.as_ref().map_or(0, |again| again.findings.len());
    if n_findings == 0 {
        return Ok(DONE);
    }
    let mends = mends(global, args, &checked);
    for mend in &mends {
        screen.say(&format!("to mend it: {mend}"));
    }
    Err(Failure {
        message: format!(
            "{:?} is not as it should be: {n_findings} findings{}",
            args.folder,
            if mends.is_empty() {
                "; the same `starbreak generate` that made it mends it"
            } else {
                "; the commands above mend it"
            }
        ),
        code: SOME_FAILED,
    })
}

/// The commands that mend what was found, as a shell takes them.
fn mends(global: &Global, args: &VerifyArgs, checked: &VerifyReport) -> Vec<String> {
    let (foreign, own): (Vec<&Finding>, Vec<&Finding>) = checked
        .findings
        .iter()
        .partition(|finding| finding.is_foreign);
    let mut mends = Vec::new();
    if !foreign.is_empty() {
        let files = foreign
            .iter()
            .map(|finding| args.folder.join(&finding.name));
        let files: Vec<String> = files.map(|file| shell_word(file.as_os_str())).collect();
        mends.push(format!("rm -- {}", files.join(" ")));
    }
    // What the flags were is not known where that is damaged.
    let is_run_file = |finding: &&Finding| finding.name == "starbreak/run.json";
    if own.iter().any(is_run_file) {
        return mends;
    }
    if !own.is_empty() {
        let format = checked.identity["source"]["format"]
            .as_str()
            .unwrap_or_default();
        let source = match &args.source {
            Some(source) => shell_word(source),
            None => format!("{format}:PATH"),
        };
        let folder = shell_word(args.folder.as_os_str());
        let links = global.follow_links.then(|| "--follow-links".to_owned());
        let flags = checked
            .generate_flags(&args.folder)
            .into_iter()
            .chain(links);
        let flags: Vec<String> = flags.map(|flag| shell_word(flag.as_ref())).collect();
        mends.push(format!(
            "starbreak generate {source} -o {folder} {}",
            flags.join(" ")
        ));
    }
    mends
}

pub(crate) fn merge(args: &MergeArgs, screen: &Screen) -> Result<u8, Failure> {
    let report = merge_sets(&args.parts, &args.output, true)?;
    let manifest = &report.manifest;
    screen.say(&format!(
        "{}: {} shards with {} images, and {} labels and other files",
        args.output.display(),
        report.n_shards,
        manifest.n_items,
        manifest.n_files
    ));
    screen.result(|| {
        json!({
            "output": path_text(&args.output),
            "n_shards": report.n_shards,
            "manifest": manifest,
        })
    })?;
    if manifest.n_failed == 0 {
        return Ok(DONE);
    }
    Err(Failure {
        message: format!("{} images had failed in the shards", manifest.n_failed),
        code: SOME_FAILED,
    })
}

fn show(findings: &[Finding], screen: &Screen) {
    for finding in findings.iter().take(MOST_SHOWN) {
        screen.say(&finding.to_string());
    }
    if findings.len() > MOST_SHOWN {
        screen.say(&format!("and {} more", findings.len() - MOST_SHOWN));
    }
}

fn summary(args: &VerifyArgs, checked: &VerifyReport, again: Option<&RegenerateReport>) -> String {
    let again = again.map_or(String::new(), |again| {
        format!(
            "; {} images made again, {} with the same bytes in all files",
            again.n_made, again.n_same_bytes
        )
    });
    let unchecked = match args.regenerate {
        Some(HowMany::All) => "",
        _ => {
            "; not checked: whether the images are what source and recipe give (--source FORMAT:PATH --regenerate all)"
        }
    };
    format!(
        "{}: {} images and {} other files hashed, {} findings{again}{unchecked}",
        args.folder.display(),
        checked.n_items,
        checked.n_files,
        checked.findings.len()
    )
}

fn result_json(
    global: &Global,
    args: &VerifyArgs,
    checked: &VerifyReport,
    again: Option<&RegenerateReport>,
) -> Value {
    let listed = |findings: &[Finding]| -> Vec<Value> {
        findings
            .iter()
            .map(|finding| json!({ "name": finding.name, "what": finding.what }))
            .collect()
    };
    json!({
        "set": path_text(&args.folder),
        "manifest": checked.manifest,
        "n_items": checked.n_items,
        "n_files": checked.n_files,
        "findings": listed(&checked.findings),
        "mend": mends(global, args, checked),
        "regenerated": again.map(|again| {
            json!({
                "n_made": again.n_made,
                "n_same_bytes": again.n_same_bytes,
                "n_same_pixels": again.n_same_pixels,
                "findings": listed(&again.findings),
            })
        }),
    })
}
