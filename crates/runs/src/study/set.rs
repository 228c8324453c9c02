//! The cracked twin of the source under one condition.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use starbreak_dataset::Source;

use super::Condition;
use crate::RunContext;
use crate::generate::{
    Event, GenerateOptions, GenerateReport, ItemFailure, Plan, Survey, generate,
};
use crate::{Error, Patterns};

/// Makes the set of a condition in a folder, or goes on with it.
pub(super) fn make_set(
    (source, survey): (&Source, &Survey),
    (condition, patterns): (&Condition, &Patterns),
    folder: &Path,
    stop: &AtomicBool,
    tell: &(dyn Fn(Event<'_>) + Sync),
) -> Result<GenerateReport, Error> {
    with_plan((source, survey), (condition, patterns), folder, |plan| {
        generate(plan, stop, tell)
    })?
}

/// Why none of these images can be broken under a condition; none where one can, or once `stop` is set. Nothing is
/// written.
pub(super) fn why_none_breaks(
    (source, survey): (&Source, &Survey),
    (condition, patterns): (&Condition, &Patterns),
    folder: &Path,
    names: &BTreeSet<String>,
    stop: &AtomicBool,
) -> Result<Option<Vec<ItemFailure>>, Error> {
    with_plan((source, survey), (condition, patterns), folder, |plan| {
        plan.why_none_is_made(names, stop)
    })
}

fn with_plan<T>(
    (source, survey): (&Source, &Survey),
    (condition, patterns): (&Condition, &Patterns),
    folder: &Path,
    run: impl FnOnce(&Plan<'_>) -> T,
) -> Result<T, Error> {
    let context = RunContext::new(&condition.recipe, condition.seed, folder)?;
    let options = GenerateOptions {
        selection: survey.selection(),
        other_files: None,
        ..GenerateOptions::default()
    };
    Ok(run(&Plan {
        source,
        context: &context,
        patterns,
        options: &options,
        survey,
    }))
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test may panic")]

    use std::fs;
    use std::path::PathBuf;

    use starbreak_dataset::SourceSpec;
    use starbreak_seed::Seed;

    use super::*;
    use crate::generate::{Selection, survey};
    use starbreak::Recipe;

    #[test]
    fn altered_images_and_masks_are_made_again() {
        let dir = tempfile::tempdir().unwrap();
        let photos = dir.path().join("photos");
        fs::create_dir(&photos).unwrap();
        for (name, code) in [("a.png", 90), ("b.png", 120), ("c.png", 150)] {
            let gray = image::Rgb([code, code, code]);
            let image = image::RgbImage::from_pixel(96, 64, gray);
            image.save(photos.join(name)).unwrap();
        }
        let spec = format!("folder:{}", photos.display());
        let source = Source::open(&SourceSpec::parse(spec.as_ref()).unwrap()).unwrap();
        let mut recipe = Recipe::preset("paper").unwrap();
        recipe.set("fracture.particles=400").unwrap();
        let condition = Condition {
            name: "paper".to_owned(),
            family: "paper".to_owned(),
            severity: None,
            seed: Seed(7),
            recipe,
            is_photographed: false,
        };
        let survey = survey(&source, Selection::default(), condition.seed);
        let set = dir.path().join("set");
        let run = || {
            let go = AtomicBool::new(false);
            make_set(
                (&source, &survey),
                (&condition, &Patterns::Fresh),
                &set,
                &go,
                &|_| (),
            )
            .unwrap()
        };
        assert_eq!(run().n_made, 3, "all");
        assert_eq!(run().n_made, 0, "none is made twice");

        let regions = set.join("starbreak/regions");
        let files: [PathBuf; 2] = [set.join("a.png"), regions.join("b.png")];
        let before = files.each_ref().map(|path| fs::read(path).unwrap());
        // Cut off, and that of another image.
        fs::write(&files[0], &before[0][..40]).unwrap();
        fs::copy(regions.join("c.png"), &files[1]).unwrap();
        let report = run();
        assert_eq!([report.n_made, report.n_done_before], [2, 1], "those two");
        assert!(report.manifest.is_some(), "the set is whole");
        let after = files.each_ref().map(|path| fs::read(path).unwrap());
        assert_eq!(after, before, "as they were");
    }
}
