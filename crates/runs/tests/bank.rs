//! Banks: what is written is what is read, whatever the threads and the number of patterns.
#![expect(clippy::unwrap_used, reason = "a test that cannot set up has failed")]

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use image::DynamicImage;
use starbreak::optics::Coverage;
use starbreak::optics::OpticsError;
use starbreak::optics::environment::Environment;
use starbreak::optics::paper::{composite, draw};
use starbreak::optics::physical::{Overlay, PackedPattern, Pattern, bake};
use starbreak::{OpticsSettings, PaneLayer, Recipe, Scene, Seed, Stopwatch, simulate};
use starbreak_dataset::{BankRecord, BankWriter, OutputBatch, street_scene};
use starbreak_runs::bank::{BankPattern, BankReport, PatternBank, write_bank};
use starbreak_runs::{Error, RunContext, with_threads};

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
    let mut context = RunContext::new(&recipe(preset), Seed(5), to).unwrap();
    context.replaces = true;
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
            let network = simulate(&settings, SIZE, seed).unwrap().network;
            assert_eq!(bank.network(idx).unwrap(), network, "{preset} {idx}");
            for size in [SIZE, (200, 150)] {
                let (pattern, was_baked_anew) = at(&bank, idx, size);
                assert!(!was_baked_anew, "{preset} {idx}");
                assert_eq!(pattern.chain.size(), size, "{preset} {idx}");
                assert_eq!(pattern.facts.summary, network.summary(), "{preset} {idx}");
                let mask = pattern.chain.crack_mask().unwrap();
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
            let (stored, is_stored_anew) = at(&with, idx, (250, 140));
            let (anew, is_anew) = at(&without, idx, (250, 140));
            assert!(is_anew && !is_stored_anew, "{preset}");
            assert_eq!(stored.crack_mask_png, anew.crack_mask_png, "{preset}");
            assert_eq!(
                packed(stored.chain.layer()),
                packed(anew.chain.layer()),
                "{preset} {idx}"
            );
        }
    }
}

/// A pattern, and whether it was baked from its network.
fn at(bank: &PatternBank, idx: usize, size: (u32, u32)) -> (BankPattern, bool) {
    let mut watch = Stopwatch::start();
    let pattern = bank.pattern(idx, size, &mut watch).unwrap();
    (pattern, watch.stop().of("bake").is_some())
}

fn packed(layer: &PaneLayer) -> Vec<u8> {
    match layer {
        PaneLayer::Packed(pattern) => pattern.unpack().unwrap().to_packed(),
        PaneLayer::Baked(_) => panic!("a pattern of a bank is packed"),
        PaneLayer::Paper(coverage) => coverage.to_packed(),
        PaneLayer::Photo { .. } => panic!("no photograph is in this bank"),
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

/// Samples of two pictures that differ by one code, and by more.
fn differences(a: &DynamicImage, b: &DynamicImage) -> [usize; 2] {
    let mut n = [0; 2];
    for (a, b) in a.as_bytes().iter().zip(b.as_bytes()) {
        match a.abs_diff(*b) {
            0 => {}
            1 => n[0] += 1,
            _ => n[1] += 1,
        }
    }
    n
}

#[test]
fn a_packed_pattern_shows_the_picture_of_the_unpacked_one_to_a_code() {
    let (width, height) = (1242, 375);
    let street = DynamicImage::ImageRgb8(street_scene().image);
    for preset in [
        "paper",
        "windshield-star",
        "windshield-combination",
        "lens-cover-star",
        "tempered-cover",
    ] {
        let settings = recipe(preset).settings().unwrap();
        let (mut n_changed, mut n_off) = (0, [0; 2]);
        for seed in (0..3).map(Seed) {
            let network = simulate(&settings, (width, height), seed).unwrap().network;
            let view = Scene::of(&settings, (width, height))
                .of_network(&network)
                .unwrap();
            let (mut unpacked, mut packed) = (street.clone(), street.clone());
            match &settings.optics {
                OpticsSettings::Paper(optics) => {
                    let drawn = draw(&network, &view, f64::INFINITY, optics);
                    let bytes = drawn.to_packed();
                    let again = Coverage::from_packed(&bytes).unwrap();
                    assert!(again.to_packed() == bytes, "{preset}: packed twice");
                    composite(&mut unpacked, &drawn, optics).unwrap();
                    composite(&mut packed, &again, optics).unwrap();
                }
                OpticsSettings::Physical(optics) => {
                    let pattern = bake(&network, f64::INFINITY, &view, optics, seed).unwrap();
                    let bytes = pattern.to_packed();
                    let again = PackedPattern::new(bytes.clone()).unwrap();
                    let unpacked_pattern = again.unpack().unwrap();
                    assert!(
                        unpacked_pattern.to_packed() == bytes,
                        "{preset}: packed twice"
                    );
                    for coverage in [again.coverage().unwrap(), unpacked_pattern.coverage()] {
                        assert!(coverage == pattern.coverage(), "{preset}: coverage");
                    }
                    let light = Environment::estimate(&street, &optics.environment, pattern.f_px());
                    pattern
                        .light(&light, optics)
                        .apply(&mut unpacked, seed)
                        .unwrap();
                    let lit = again.light(&light, optics).unwrap();
                    lit.apply(&mut packed, seed).unwrap();
                    // The one is compiled for this processor, the other for any.
                    let [lit, anew] = [lit, unpacked_pattern.light(&light, optics)];
                    assert!(lit.maps() == anew.maps(), "{preset}: lit as it is read");
                    assert!(lit.region() == anew.region(), "{preset}: region");
                }
            }
            n_changed += differences(&street, &unpacked).iter().sum::<usize>();
            let [one, more] = differences(&unpacked, &packed);
            n_off = [n_off[0] + one, n_off[1] + more];
        }
        assert!(n_changed > 3000, "{preset}: nothing to see");
        assert!(
            n_off[0] * 25 < n_changed,
            "{preset}: {n_off:?} of {n_changed} are off"
        );
        // The renderer averages a mirror's picture over steps of width; one may fall to either side.
        assert!(
            n_off[1] * 5000 < n_changed,
            "{preset}: {n_off:?} of {n_changed} by more"
        );
    }
}

#[test]
fn damaged_packed_forms_are_refused_or_read_but_never_more() {
    let settings = recipe("windshield-star").settings().unwrap();
    let network = simulate(&settings, (160, 60), Seed(3)).unwrap().network;
    let view = Scene::of(&settings, (160, 60))
        .of_network(&network)
        .unwrap();
    let OpticsSettings::Physical(optics) = &settings.optics else {
        panic!("a preset of the physics");
    };
    let pattern = bake(&network, f64::INFINITY, &view, optics, Seed(3)).unwrap();
    let bytes = pattern.to_packed();
    let environment = Environment::estimate(
        &DynamicImage::new_rgb8(160, 60),
        &optics.environment,
        pattern.f_px(),
    );
    let read = |bytes: &[u8]| -> Result<(Pattern, Overlay), OpticsError> {
        let packed = PackedPattern::new(bytes.to_vec())?;
        let lit = packed.light(&environment, optics);
        Ok((packed.unpack()?, lit?))
    };
    for n in 0..bytes.len() {
        let error = read(&bytes[..n]).map(|_| ()).unwrap_err();
        assert!(
            error.to_string().starts_with("not a packed pattern"),
            "{n}: {error}"
        );
    }
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x55;
        if let Ok((pattern, lit)) = read(&damaged) {
            let _ = pattern.coverage();
            let unpacked = pattern.light(&environment, optics);
            assert!(lit.maps() == unpacked.maps(), "{at}: lit otherwise");
        }
    }
    let longer = [bytes.as_slice(), &[0]].concat();
    assert!(read(&longer).is_err(), "a byte too many");
}

#[test]
fn records_that_are_whole_but_mean_nothing_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("patterns.bank");
    let header = {
        bank("paper", 1, &[SIZE], &path);
        let bank = PatternBank::open(&path).unwrap();
        serde_json::to_vec(bank.header()).unwrap()
    };
    let forge = |header: &[u8], records: &[&[u8]]| {
        let mut writer =
            BankWriter::create(OutputBatch::new().replacing(true), &path, header).unwrap();
        for record in records {
            let record = BankRecord::new(record.to_vec());
            writer.append(&record).unwrap();
        }
        writer.finish().unwrap().commit(&[]).unwrap();
        PatternBank::open(&path)
    };
    let bank = forge(&header, &[b"no network", b"no pattern"]).unwrap();
    for error in [
        bank.network(0).map(|_| ()).unwrap_err(),
        bank.pattern(0, SIZE, &mut Stopwatch::start())
            .map(|_| ())
            .unwrap_err(),
        bank.check(|_| true).unwrap_err(),
    ] {
        let message = error.to_string();
        assert!(message.contains("pattern 0: "), "{message}");
        assert!(!message.contains('\n'), "{message}");
    }
    let message = bank.network(1).unwrap_err().to_string();
    assert!(message.contains("no pattern 1, only 1"), "{message}");
    for (header, named) in [
        (&b"no json"[..], "no JSON"),
        (
            b"{\"schema\":\"starbreak.bank/1\"}",
            "\"starbreak.bank/1\"; this version reads",
        ),
        (b"{\"schema\":\"starbreak.bank/3\"}", "not understood"),
    ] {
        let message = forge(header, &[b"", b""])
            .map(|_| ())
            .unwrap_err()
            .to_string();
        assert!(message.contains(named), "{message}");
    }
    let message = forge(&header, &[b""]).map(|_| ()).unwrap_err().to_string();
    assert!(
        message.contains("its 1 records do not fit its 1 frame sizes"),
        "{message}"
    );
    let text = String::from_utf8(header)
        .unwrap()
        .replace("\"simulated\"", "\"photographs\"");
    let message = forge(text.as_bytes(), &[])
        .map(|_| ())
        .unwrap_err()
        .to_string();
    assert!(message.contains("not understood"), "{message}");
}
