#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicU32;

use serde_json::json;
use starbreak_eval::{BoxPx, Detections};

use super::super::arm_log::{read_found, read_whole, seen_files};
use super::*;

fn images() -> Vec<ImageToSee> {
    let image = |k| ImageToSee {
        name: format!("{k:03}.png"),
        path: PathBuf::new(),
    };
    (0..40).map(image).collect()
}

/// As many boxes as the place of the image, with numbers that need all their digits.
#[expect(clippy::unnecessary_wraps, reason = "as an arm has it")]
fn find(place: u32, _image: &ImageToSee, _pixels: &RgbImage) -> Result<Vec<Detection>, Error> {
    let one = |k: u32| Detection {
        image: place,
        category: k,
        box_px: BoxPx {
            x: f64::from(k) / 3.0,
            y: 0.1,
            width: 1.0 / 7.0,
            height: 2.0,
        },
        score: 1.0 / f64::from(place + 1),
    };
    Ok((0..place).map(one).collect())
}

/// Another file in the place of one image.
#[test]
fn an_image_that_was_replaced_is_looked_at_again() {
    let dir = tempfile::tempdir().unwrap();
    let go = AtomicBool::new(false);
    run(&dir, 1, &find, &go).unwrap();
    let mut images = images();
    images[20].path = PathBuf::from("another");
    let n_calls = AtomicU32::new(0);
    let counted = |place: u32, image: &ImageToSee, pixels: &RgbImage| {
        n_calls.fetch_add(1, Ordering::Relaxed);
        find(place, image, pixels)
    };
    run_arms(&[arm(&dir, 1, &counted)], &images, &go, &read);
    assert_eq!(n_calls.into_inner(), 1, "that one");
    let found = read_whole(&dir.path().join("arm.jsonl"), r#"{"model":1}"#, &images).unwrap();
    let places: Vec<u32> = found.items.iter().map(|one| one.image).collect();
    assert!(places.is_sorted() && places.len() == 780, "in order");
}

#[expect(clippy::unnecessary_wraps, reason = "as a run has it")]
fn read(_image: &ImageToSee) -> Result<RgbImage, Error> {
    Ok(RgbImage::new(1, 1))
}

fn arm<'a>(dir: &tempfile::TempDir, model: u32, find: &'a Find<'a>) -> Arm<'a> {
    Arm {
        log: dir.path().join("arm.jsonl"),
        identity: json!({ "model": model }),
        find: Box::new(find),
    }
}

fn run_arms(
    arms: &[Arm<'_>],
    images: &[ImageToSee],
    stop: &AtomicBool,
    read: &Read<'_>,
) -> Option<Vec<UnseenImage>> {
    run_on(arms, images, stop, read, 3)
}

fn run_on(
    arms: &[Arm<'_>],
    images: &[ImageToSee],
    stop: &AtomicBool,
    read: &Read<'_>,
    n_threads: usize,
) -> Option<Vec<UnseenImage>> {
    let run = ArmsRun {
        arms,
        images,
        blake3: &|image| Ok(format!("{} {}", image.name, image.path.display())),
        read,
        n_threads,
        stop,
        tell: &|_| (),
    };
    run.run().unwrap()
}

/// Detections of an arm that is whole, and images without a result.
fn run(
    dir: &tempfile::TempDir,
    model: u32,
    find: &Find<'_>,
    stop: &AtomicBool,
) -> Option<(Detections, Vec<UnseenImage>)> {
    let arm = arm(dir, model, find);
    let unseen = run_arms(std::slice::from_ref(&arm), &images(), stop, &read)?;
    let detections = read_whole(&arm.log, &arm.identity.to_string(), &images()).unwrap();
    Some((detections, unseen))
}

#[test]
fn an_image_is_read_once_for_all_arms_that_do_not_know_it() {
    let dirs = [0; 3].map(|_| tempfile::tempdir().unwrap());
    let go = AtomicBool::new(false);
    let log = |k: usize| std::fs::read(dirs[k].path().join("arm.jsonl")).unwrap();
    let fewer = |place: u32, image: &ImageToSee, pixels: &RgbImage| find(place / 2, image, pixels);
    run(&dirs[0], 1, &find, &go).unwrap();
    run(&dirs[1], 2, &fewer, &go).unwrap();
    let alone = [log(0), log(1)];

    // The first goes on after 11 images or some more, the second is whole, the third begins.
    std::fs::remove_file(dirs[0].path().join("arm.jsonl")).unwrap();
    let stop = AtomicBool::new(false);
    let interrupted = |place: u32, image: &ImageToSee, pixels: &RgbImage| {
        stop.fetch_or(place > 10, Ordering::Relaxed);
        find(place, image, pixels)
    };
    assert_eq!(run(&dirs[0], 1, &interrupted, &stop), None, "not whole");
    let n_known = seen_files(&dirs[0].path().join("arm.jsonl")).unwrap().len();
    let never = |_: u32, _: &ImageToSee, _: &RgbImage| -> Result<Vec<Detection>, Error> {
        panic!("a whole arm is asked")
    };
    let n_reads = AtomicU32::new(0);
    let counted = |image: &ImageToSee| {
        n_reads.fetch_add(1, Ordering::Relaxed);
        read(image)
    };
    let places = Mutex::new(Vec::new());
    let noted = |place: u32, image: &ImageToSee, pixels: &RgbImage| {
        places.lock().unwrap().push(place as usize);
        find(place, image, pixels)
    };
    let arms = [
        arm(&dirs[0], 1, &noted),
        arm(&dirs[1], 2, &never),
        arm(&dirs[2], 1, &find),
    ];
    assert_eq!(run_arms(&arms, &images(), &go, &counted), Some(Vec::new()));
    assert_eq!(n_reads.into_inner(), 40, "each image once");
    let mut places = places.lock().unwrap().clone();
    places.sort_unstable();
    assert_eq!(places, (n_known..40).collect::<Vec<_>>(), "what it had not");
    assert!(log(0) == alone[0] && log(1) == alone[1] && log(2) == alone[0]);
    let unread = |_: &ImageToSee| -> Result<RgbImage, Error> { panic!("read for nothing") };
    run_arms(&arms, &images(), &go, &unread).unwrap();
}

/// Of three arms the first fails in an image and the second is whole; another image is not decoded, and all is
/// interrupted. Mended, each has the log that it has alone.
#[test]
fn arms_that_failed_and_were_interrupted_come_to_what_each_has_alone() {
    for n_threads in [1, 3] {
        let dirs = [0; 3].map(|_| tempfile::tempdir().unwrap());
        let go = AtomicBool::new(false);
        let log = |k: usize| std::fs::read(dirs[k].path().join("arm.jsonl")).unwrap();
        let other =
            |place: u32, image: &ImageToSee, pixels: &RgbImage| find(place / 2, image, pixels);
        run(&dirs[0], 1, &find, &go).unwrap();
        let alone = log(0);
        std::fs::remove_file(dirs[0].path().join("arm.jsonl")).unwrap();
        run(&dirs[1], 2, &other, &go).unwrap();
        let whole = log(1);

        let stop = AtomicBool::new(false);
        let fails = |place: u32, image: &ImageToSee, pixels: &RgbImage| match place {
            3 => Err(Error::NoPhotos {
                folder: PathBuf::new(),
            }),
            _ => find(place, image, pixels),
        };
        let undecoded = |image: &ImageToSee| {
            stop.fetch_or(image.name.as_str() >= "020.png", Ordering::Relaxed);
            match image.name.as_str() {
                "007.png" => Err(Error::NoSize),
                _ => read(image),
            }
        };
        let never = |_: u32, _: &ImageToSee, _: &RgbImage| -> Result<Vec<Detection>, Error> {
            panic!("a whole arm is asked")
        };
        let failing = [
            arm(&dirs[0], 1, &fails),
            arm(&dirs[1], 2, &never),
            arm(&dirs[2], 1, &find),
        ];
        assert_eq!(
            run_on(&failing, &images(), &stop, &undecoded, n_threads),
            None
        );
        let failed = |k: usize| {
            let text = String::from_utf8(log(k)).unwrap();
            let errors = text.lines().filter(|line| line.contains("\"error\""));
            let names = errors.map(|line| line[10..17].to_owned());
            names.collect::<Vec<_>>()
        };
        assert_eq!(failed(0), ["003.png", "007.png"], "{n_threads} threads");
        assert_eq!(failed(2), ["007.png"], "{n_threads} threads");

        let go_on = AtomicBool::new(false);
        let mended = [
            arm(&dirs[0], 1, &find),
            arm(&dirs[1], 2, &never),
            arm(&dirs[2], 1, &find),
        ];
        let unseen = run_on(&mended, &images(), &go_on, &read, n_threads);
        assert_eq!(unseen, Some(Vec::new()), "{n_threads} threads");
        assert!(
            log(0) == alone && log(1) == whole && log(2) == alone,
            "{n_threads} threads"
        );
    }
}

#[test]
fn what_was_interrupted_goes_on_and_comes_to_the_same() {
    let (dir, other_dir) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let go = AtomicBool::new(false);
    let whole = run(&other_dir, 1, &find, &go).unwrap();
    assert_eq!(whole.0.items.len(), 780, "0 to 39 boxes");

    let stop = AtomicBool::new(false);
    let interrupted = |place: u32, image: &ImageToSee, pixels: &RgbImage| {
        stop.fetch_or(place > 10, Ordering::Relaxed);
        find(place, image, pixels)
    };
    assert_eq!(run(&dir, 1, &interrupted, &stop), None, "not whole");
    let n_calls = AtomicU32::new(0);
    let counted = |place: u32, image: &ImageToSee, pixels: &RgbImage| {
        n_calls.fetch_add(1, Ordering::Relaxed);
        find(place, image, pixels)
    };
    assert_eq!(
        run(&dir, 1, &counted, &go),
        Some(whole),
        "the same to the last bit"
    );
    assert!(n_calls.into_inner() < 40, "what was done is not done again");
}

#[test]
fn a_line_that_was_altered_is_looked_for_again() {
    let dir = tempfile::tempdir().unwrap();
    let go = AtomicBool::new(false);
    let whole = run(&dir, 1, &find, &go).unwrap();
    let log = dir.path().join("arm.jsonl");
    let written = std::fs::read_to_string(&log).unwrap();
    // A coordinate of another value, and a box less.
    for (from, to) in [
        ("0.1,", "0.2,"),
        ("[0,[0.0,0.1,0.14285714285714285,2.0],0.5]", ""),
    ] {
        assert!(written.contains(from), "{from}");
        std::fs::write(&log, written.replacen(from, to, 1)).unwrap();
        let n_calls = AtomicU32::new(0);
        let counted = |place: u32, image: &ImageToSee, pixels: &RgbImage| {
            n_calls.fetch_add(1, Ordering::Relaxed);
            find(place, image, pixels)
        };
        assert_eq!(run(&dir, 1, &counted, &go).unwrap(), whole, "{from}");
        assert_eq!(n_calls.into_inner(), 1, "that one: {from}");
        assert_eq!(std::fs::read_to_string(&log).unwrap(), written, "mended");
    }
}

#[test]
fn a_log_that_is_damaged_after_the_arm_is_refused_by_the_first_image_without_a_line() {
    let dir = tempfile::tempdir().unwrap();
    run(&dir, 1, &find, &AtomicBool::new(false)).unwrap();
    let (log, identity) = (dir.path().join("arm.jsonl"), r#"{"model":1}"#);
    let written = std::fs::read_to_string(&log).unwrap();
    let lines: Vec<&str> = written.lines().collect();
    let without = |k: usize| [&lines[..=k], &lines[k + 2..]].concat().join("\n") + "\n";
    let swapped = written.replacen("0.1,", "0.2,", 1);
    for (damaged, image) in [
        (String::new(), "000.png"),
        (without(0), "000.png"),
        (without(20), "020.png"),
        (without(39), "039.png"),
        (written[..written.len() - 9].to_owned(), "039.png"),
        (written.replacen("\"model\":1", "\"model\":2", 1), "000.png"),
        (swapped, "001.png"),
    ] {
        std::fs::write(&log, damaged).unwrap();
        let error = read_whole(&log, identity, &images()).unwrap_err();
        let is_it = matches!(&error, Error::StudyLog { image: first, .. } if first == image);
        assert!(is_it, "{image}: {error}");
        assert!(error.to_string().contains("run the study again"), "{error}");
    }
    std::fs::remove_file(&log).unwrap();
    assert!(read_whole(&log, identity, &images()).is_err(), "no log");
    std::fs::write(&log, &written).unwrap();
    let found = read_whole(&log, identity, &images()).unwrap();
    assert_eq!(found.items.len(), 780, "put back");
}

#[test]
fn another_model_begins_anew() {
    let dir = tempfile::tempdir().unwrap();
    let go = AtomicBool::new(false);
    run(&dir, 1, &find, &go).unwrap();
    let (found, _) = run(&dir, 2, &|_, _, _| Ok(Vec::new()), &go).unwrap();
    assert!(found.items.is_empty(), "of the second");
}

/// However often a run is killed, and wherever, what it has found counts.
#[test]
fn an_image_that_cannot_be_read_is_listed_and_tried_again_alone() {
    let (dir, other_dir) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let go = AtomicBool::new(false);
    let log = |dir: &tempfile::TempDir| std::fs::read(dir.path().join("arm.jsonl")).unwrap();
    let fails = |place: u32, image: &ImageToSee, pixels: &RgbImage| match place {
        3 => Err(Error::NoSize),
        _ => find(place, image, pixels),
    };
    let whole = run(&other_dir, 1, &fails, &go).unwrap();
    assert_eq!(whole.1.len(), 1, "one");
    assert_eq!(whole.1[0].name, "003.png", "that one");
    let seen = seen_files(&other_dir.path().join("arm.jsonl")).unwrap();
    assert_eq!(seen.len(), 39, "all but that one");
    assert_eq!(seen["004.png"], "004.png ", "the hash of its file");

    // Each run comes no further than three images, of which the bad one is one each time.
    let n_calls = AtomicU32::new(0);
    for n_runs in 1.. {
        let stop = AtomicBool::new(false);
        let n_before = n_calls.load(Ordering::Relaxed);
        let interrupted = |place: u32, image: &ImageToSee, pixels: &RgbImage| {
            let n_now = n_calls.fetch_add(1, Ordering::Relaxed) + 1;
            stop.fetch_or(n_now >= n_before + 3, Ordering::Relaxed);
            fails(place, image, pixels)
        };
        let arms = [arm(&dir, 1, &interrupted)];
        if run_on(&arms, &images(), &stop, &read, 1).is_some() {
            break;
        }
        assert!(n_runs < 40, "it does not come to an end");
    }
    assert!(log(&dir) == log(&other_dir), "as without a break");
    let n_calls = n_calls.into_inner();
    assert!(n_calls <= 39 + 20, "{n_calls}");

    // Tried again, and killed before it is at its end: whoever joins is told.
    let path = dir.path().join("arm.jsonl");
    let n_found = |path: &Path| {
        let found = read_found(path, r#"{"model":1}"#, &images(), &mut |_| ());
        found.unwrap().unwrap()
    };
    assert_eq!(n_found(&path), (40, false), "whole");
    let own = log(&dir);
    let line = FoundInImage::new("003.png", "003.png ".to_owned(), Ok(Vec::new()));
    let more = [&own, line.to_line().unwrap().as_bytes(), b"\n"].concat();
    std::fs::write(&path, more).unwrap();
    assert_eq!(n_found(&path), (40, true), "a line more");
    std::fs::write(&path, own).unwrap();

    assert_eq!(run(&dir, 1, &fails, &go).unwrap(), whole, "still bad");
    assert!(log(&dir) == log(&other_dir), "still bad");
    let n_calls = AtomicU32::new(0);
    let mended = |place: u32, image: &ImageToSee, pixels: &RgbImage| {
        n_calls.fetch_add(1, Ordering::Relaxed);
        find(place, image, pixels)
    };
    assert_eq!(run(&dir, 1, &mended, &go).unwrap().1, [], "mended");
    assert_eq!(n_calls.into_inner(), 1, "that one");
    run(&other_dir, 2, &find, &go).unwrap();
    run(&other_dir, 1, &find, &go).unwrap();
    assert!(log(&dir) == log(&other_dir), "as if it had been good");
}
