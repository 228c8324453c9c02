//! Digests of a bank and of sets of our own: they guard against change and prove nothing else. They are
//! the same on every processor; `cargo xtask test` runs this file on emulated ones, too
//! (docs/decisions/0013).
//!
//! A change that is meant is written with `UPDATE_GOLDEN=1 cargo test -p starbreak-runs --test
//! golden_sets` and entered in CHANGELOG.md under "Numbers changed".
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::fs;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use image::{DynamicImage, GenericImageView as _};
use starbreak::{Recipe, Seed};
use starbreak_dataset::{
    Encoding, JpegQuality, Source, SourceSpec, encode_image, sha256_hex, street_scene,
};
use starbreak_runs::bank::{PatternBank, write_bank};
use starbreak_runs::generate::{GenerateOptions, Plan, generate, survey};
use starbreak_runs::{Patterns, RunContext};
use std::fmt::Write as _;

fn recipe(preset: &str) -> Recipe {
    let mut recipe = Recipe::preset(preset).unwrap();
    recipe.set("fracture.mesh=fast").unwrap();
    recipe.set("impact.position=[0.5, 0.5]").unwrap();
    recipe
}

/// A part of the street, small enough for a processor that is emulated.
fn street() -> DynamicImage {
    DynamicImage::ImageRgb8(street_scene().image.view(480, 120, 320, 180).to_image())
}

#[test]
fn sets_are_what_they_were() {
    let folder = tempfile::tempdir().unwrap();
    let [input, bank] = ["in", "stars.bank"].map(|name| folder.path().join(name));
    fs::create_dir(&input).unwrap();
    let jpeg = |quality| Encoding::Jpeg {
        quality: JpegQuality::new(quality).unwrap(),
    };
    // One with its colors halved, one without, as decoders treat them apart.
    for (name, encoding) in [
        ("a.jpg", jpeg(80)),
        ("b.jpg", jpeg(95)),
        ("c.png", Encoding::Png),
    ] {
        let bytes = encode_image(&street(), &encoding, None).unwrap();
        fs::write(input.join(name), bytes).unwrap();
    }
    let stars = RunContext::new(&recipe("windshield-star"), Seed(5), &bank).unwrap();
    let stop = AtomicBool::new(false);
    let draft = write_bank(&stars, 2, &[(320, 180)], &bank, &stop, |_| {}).unwrap();
    draft.commit(&[]).unwrap();
    let mut text = format!(
        "source {}\nbank {}\n",
        digest_of(&input),
        sha256_hex(&fs::read(&bank).unwrap())
    );
    for (name, preset, patterns) in [
        ("fresh", "windshield-combination", Patterns::Fresh),
        (
            "from-bank",
            "windshield-star",
            Patterns::Bank(Box::new(PatternBank::open(&bank).unwrap())),
        ),
    ] {
        let out = folder.path().join(name);
        let spec = format!("folder:{}", input.display());
        let source = Source::open(&SourceSpec::parse(spec.as_ref()).unwrap());
        let (source, options) = (source.unwrap(), GenerateOptions::default());
        let plan = Plan {
            source: &source,
            context: &RunContext::new(&recipe(preset), Seed(5), &out).unwrap(),
            patterns: &patterns,
            options: &options,
            survey: &survey(&source, options.selection, Seed(5)),
        };
        let report = generate(&plan, &stop, &|_| ()).unwrap();
        assert_eq!(report.n_made, 3, "{name}: {:?}", report.failures);
        writeln!(text, "{name} {}", digest_of(&out)).unwrap();
    }
    compare("sets.txt", &text);
}

/// Digest of all files in a folder with their names.
fn digest_of(folder: &Path) -> String {
    let mut list = Vec::new();
    list_files(folder, folder, &mut list);
    list.sort();
    sha256_hex(list.concat().as_bytes())
}

fn list_files(root: &Path, folder: &Path, list: &mut Vec<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            list_files(root, &path, list);
        } else {
            let name = path.strip_prefix(root).unwrap().display();
            list.push(format!(
                "{name} {}\n",
                sha256_hex(&fs::read(&path).unwrap())
            ));
        }
    }
}

fn compare(name: &str, text: &str) {
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden/physics");
    let path = golden.join(name);
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        fs::create_dir_all(&golden).unwrap();
        fs::write(&path, text).unwrap();
        return;
    }
    let expected = fs::read_to_string(&path).unwrap();
    assert_eq!(
        text, expected,
        "output changed; if that is meant, see the head of this file"
    );
}
