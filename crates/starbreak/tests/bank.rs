//! Banks: what is written is what is read, whatever the threads and the number of patterns.
#![expect(clippy::unwrap_used, reason = "a test that cannot set up has failed")]

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use starbreak::bank::{Baked, BankReport, PatternBank, write_bank};
use starbreak::pipeline::{RunContext, simulate, with_threads};
use starbreak::{Error, Recipe, Seed};

const SIZE: (u32, u32) = (320, 96);

/// A recipe that is quick.
fn recipe(preset: &str) -> Recipe {
    let mut recipe = Recipe::preset(preset).unwrap();
    if preset == "paper" {
        recipe.set("fracture.particles=1500").unwrap();
    }
    recipe
}

fn bank(preset: &str, n: usize, sizes: &[(u32, u32)], to: &Path) -> BankReport {
    let context = RunContext::new(&recipe(preset), Seed(5), to).unwrap();
    let stop = AtomicBool::new(false);
    let draft = write_bank(&context, n, sizes, to, &stop, |_| {}).unwrap();
    draft.commit(&[]).unwrap()
}

#[test]
fn a_pattern_comes_out_as_it_went_in() {
    let folder = tempfile::tempdir().unwrap();
    for preset in ["paper", "windshield-star", "tempered-cover"] {
        let path = folder.path().join(format!("{preset}.bank"));
        let report = bank(preset, 3, &[SIZE, (200, 150)], &path);
        let bank = PatternBank::open(&path).unwrap();
        assert_eq!(bank.len(), 3, "{preset}");
        assert_eq!(bank.header(), &report.header, "{preset}");
        assert_eq!(bank.sha256(), report.sha256, "{preset}");
        assert_eq!(bank.n_bytes(), report.n_bytes, "{preset}");
        assert_eq!(bank.n_bytes(), path.metadata().unwrap().len(), "{preset}");
        let settings = recipe(preset).settings().unwrap();
        for idx in [2, 0, 1] {
            let seed = bank.header().seed_of(idx);
            let network = simulate(&settings, SIZE.0, SIZE.1, seed).unwrap().network;
            assert_eq!(bank.network(idx).unwrap(), network, "{preset} {idx}");
            for size in [SIZE, (200, 150)] {
                let pattern = bank.pattern(idx, size).unwrap();
                assert!(!pattern.was_baked_anew, "{preset} {idx}");
                assert_eq!(pattern.baked.size(), size, "{preset} {idx}");
                assert_eq!(pattern.facts.summary, network.summary(), "{preset} {idx}");
                let mask = match &pattern.baked {
                    Baked::Physical(pattern) => pattern.coverage(),
                    Baked::Paper(coverage) => coverage.to_mask(),
                };
                assert_eq!(pattern.crack_mask().unwrap(), mask, "{preset} {idx}");
                if size == SIZE {
                    let sum: u64 = mask.as_raw().iter().map(|code| u64::from(*code)).sum();
                    let share = sum as f64 / 255.0 / f64::from(SIZE.0 * SIZE.1);
                    let error = (report.rows[idx].area_share - share).abs();
                    assert!(error < 1e-12, "{preset} {idx}: off by {error}");
                }
            }
        }
    }
}

#[test]
fn a_pattern_of_another_size_is_that_of_a_bank_with_the_size() {
    let folder = tempfile::tempdir().unwrap();
    for preset in ["paper", "windshield-star"] {
        let [without, with] = ["without", "with"].map(|name| folder.path().join(name));
        bank(preset, 2, &[SIZE], &without);
        bank(preset, 2, &[SIZE, (250, 140)], &with);
        let [without, with] = [without, with].map(|path| PatternBank::open(&path).unwrap());
        for idx in 0..2 {
            let stored = with.pattern(idx, (250, 140)).unwrap();
            let anew = without.pattern(idx, (250, 140)).unwrap();
            assert!(anew.was_baked_anew && !stored.was_baked_anew, "{preset}");
            assert_eq!(stored.crack_mask_png, anew.crack_mask_png, "{preset}");
            assert_eq!(packed(&stored.baked), packed(&anew.baked), "{preset} {idx}");
        }
    }
}

fn packed(baked: &Baked) -> Vec<u8> {
    match baked {
        Baked::Physical(pattern) => pattern.to_packed(),
        Baked::Paper(coverage) => coverage.to_packed(),
    }
}

#[test]
fn neither_threads_nor_number_of_patterns_change_a_byte() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    for preset in ["paper", "windshield-star"] {
        with_threads(1, || bank(preset, 6, &[SIZE], &file("one"))).unwrap();
        with_threads(2, || bank(preset, 6, &[SIZE], &file("two"))).unwrap();
        bank(preset, 2, &[SIZE], &file("short"));
        let [one, two, short] =
            ["one", "two", "short"].map(|name| std::fs::read(file(name)).unwrap());
        assert!(one == two, "{preset}: threads change bytes");
        // 20 bytes of index per pattern's two records, a digest and the tail.
        let n_records = short.len() - 2 * 2 * 20 - 32 - 36;
        assert!(
            short[..n_records] == one[..n_records],
            "{preset}: not a prefix"
        );
        let [whole, part] = ["one", "short"].map(|name| PatternBank::open(&file(name)).unwrap());
        assert_ne!(whole.sha256(), part.sha256(), "{preset}: other banks");
    }
}

#[test]
fn a_bank_that_is_interrupted_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let to = folder.path().join("new").join("patterns.bank");
    let context = RunContext::new(&recipe("paper"), Seed(5), &to).unwrap();
    let stop = AtomicBool::new(false);
    let result = write_bank(&context, 500, &[SIZE], &to, &stop, |n| {
        if n == 3 {
            stop.store(true, Ordering::Relaxed);
        }
    });
    assert!(matches!(result, Err(Error::Interrupted)), "not interrupted");
    assert_eq!(
        folder.path().read_dir().unwrap().count(),
        0,
        "something is left"
    );
}

#[test]
fn items_get_all_patterns_about_as_often() {
    let folder = tempfile::tempdir().unwrap();
    bank("paper", 10, &[SIZE], &folder.path().join("patterns.bank"));
    let bank = PatternBank::open(folder.path()).unwrap();
    let mut counts = [0_u32; 10];
    for k in 0..10_000 {
        counts[bank.idx_for(Seed(1).of_item("image.png", k))] += 1;
    }
    // Binomial: 1000 ± 30.
    assert!(counts.iter().all(|n| n.abs_diff(1000) < 150), "{counts:?}");
}
