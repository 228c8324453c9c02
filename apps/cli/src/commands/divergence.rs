//! `starbreak divergence`: how far sets of images are apart.

mod experiment;
mod given;
mod show;

use serde::Serialize;
use starbreak_eval::divergence::{
    Background, CompareSettings, DivergenceReport, ImageSet, ReadSettings, compare_sets,
    divergence_csv, divergence_svg,
};
use starbreak_runs::divergence::{Eye, NamedSet};
use starbreak_runs::with_threads;

use crate::args::Global;
use crate::args::divergence::DivergenceArgs;
use crate::failure::{DONE, Failure, SOME_FAILED};
use crate::interrupt::Interrupt;
use crate::screen::{Screen, path_text};

/// The files that go into the output folder.
const FILES: [&str; 3] = ["divergence.json", "divergence.csv", "divergence.svg"];

pub(crate) fn run(global: &Global, args: &DivergenceArgs, screen: &Screen) -> Result<u8, Failure> {
    if let Some(file) = &args.histograms {
        return given::histograms(file, screen);
    }
    if let Some(folder) = &args.output {
        global.refuse_taken(&FILES.map(|name| folder.join(name)))?;
    }
    let reading = ReadSettings {
        background: Background::of_name(&args.background).unwrap_or(Background::Black),
        shorter_side_px: args.side,
    };
    let settings = CompareSettings {
        alpha: args.alpha,
        n_bootstrap: wide(args.bootstrap),
        n_permutations: wide(args.permutations),
        n_splits: wide(args.splits),
        seed: global.seed,
    };
    with_threads(usize::from(global.threads), || {
        if let Some(files) = &args.features {
            return given::features(files, screen);
        }
        let interrupt = Interrupt::listen(screen);
        let model = args.model.as_deref();
        let eye = model.map(|model| Eye::open(model, args.layer.as_deref()));
        let reader = Reader {
            global,
            args,
            reading,
            eye: eye.transpose()?,
            interrupt: &interrupt,
            screen,
        };
        if args.experiment.experiment.is_some() {
            return experiment::run(&reader, &settings);
        }
        let named = NamedSet::parse_all(&args.sets)?.into_iter();
        let sets = named.map(|named| reader.read(named));
        let sets: Vec<ImageSet> = sets.collect::<Result<_, _>>()?;
        let report = compare_sets(&sets, &reading, &settings)?;
        interrupt.check()?;
        show::report(&report, screen);
        finish(&reader, &report, &report)
    })?
}

/// Reads sets of the command line.
struct Reader<'a> {
    global: &'a Global,
    args: &'a DivergenceArgs,
    reading: ReadSettings,
    eye: Option<Eye>,
    interrupt: &'a Interrupt,
    screen: &'a Screen,
}

impl Reader<'_> {
    /// Reads a set, with a progress bar, and says which images could not be.
    fn read(&self, named: NamedSet) -> Result<ImageSet, Failure> {
        let named = named.following_links(self.global.follow_links);
        let open = named.open(self.args.limit.map(wide))?;
        let n = u64::try_from(open.n()).unwrap_or(u64::MAX);
        let progress = self.screen.progress(n, "images");
        let (eye, stop) = (self.eye.as_ref(), self.interrupt.flag());
        let set = open.read(&self.reading, eye, stop, &|| progress.step());
        progress.finish();
        self.interrupt.check()?;
        let set = set?;
        let name = &set.summary.name;
        for failed in &set.summary.failed {
            let line = format!("{name}: {}: {}", failed.name, failed.reason);
            self.screen.note(&line);
        }
        Ok(set)
    }
}

/// Writes the files of a report, of which `all` is the JSON; says what failed.
fn finish(
    reader: &Reader<'_>,
    report: &DivergenceReport,
    all: &impl Serialize,
) -> Result<u8, Failure> {
    let (global, screen) = (reader.global, reader.screen);
    let value = serde_json::to_value(all).map_err(Failure::wrong_input)?;
    if let Some(folder) = &reader.args.output {
        let text = serde_json::to_string_pretty(&value).map_err(Failure::wrong_input)?;
        let contents = [text + "\n", divergence_csv(report), divergence_svg(report)];
        let mut batch = global.batch();
        for (name, content) in FILES.iter().zip(&contents) {
            batch.stage(&folder.join(name), content.as_bytes())?;
        }
        batch.commit()?;
        let files = FILES.join(", ");
        screen.say(&format!("wrote {files} to {}", path_text(folder)));
    }
    screen.result(|| value)?;
    let n_failed: usize = report.sets.iter().map(|set| set.failed.len()).sum();
    if n_failed == 0 {
        return Ok(DONE);
    }
    Err(Failure {
        message: format!(
            "{n_failed} images could not be read and are in no number; they are listed above and in the result"
        ),
        code: SOME_FAILED,
    })
}

fn wide(n: u32) -> usize {
    usize::try_from(n).unwrap_or(usize::MAX)
}
