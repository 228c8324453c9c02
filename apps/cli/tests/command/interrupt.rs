//! Ctrl-C: what is begun is finished, nothing more is begun, nothing is left half-written.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::program::{Outcome, folder, names, snapshot};

/// Sends Ctrl-C once something is true, and waits for the end.
fn interrupt(mut child: Child, begun: impl Fn() -> bool) -> Outcome {
    let started = Instant::now();
    while !begun() && child.try_wait().unwrap().is_none() {
        assert!(started.elapsed().as_secs() < 120, "nothing began");
        std::thread::sleep(Duration::from_millis(2));
    }
    let id = child.id().to_string();
    let sent = Command::new("kill").args(["-INT", &id]).status().unwrap();
    assert!(sent.success(), "the command had ended before");
    child.wait_with_output().unwrap().into()
}

fn spawn(dir: &Path, args: &[&str]) -> Child {
    crate::program::command(dir, args)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

fn no_temporary_files(dir: &Path) {
    let left = names(dir);
    let temporary: Vec<_> = left
        .iter()
        .filter(|name| name.contains(".starbreak"))
        .collect();
    assert!(temporary.is_empty(), "left behind: {temporary:?}");
}

#[test]
fn an_interrupted_bench_writes_nothing() {
    let dir = folder();
    let args = [
        "bench",
        "--runs",
        "100000",
        "--particles",
        "2000",
        "-o",
        "b",
    ];
    let started = Instant::now();
    let outcome = interrupt(spawn(dir.path(), &args), || {
        started.elapsed().as_millis() > 1500
    });
    assert_eq!(outcome.code, Some(130), "{outcome:?}");
    assert!(
        outcome.stderr.starts_with("error: interrupted"),
        "{outcome:?}"
    );
    assert!(snapshot(dir.path()).is_empty(), "something was written");
}

#[test]
fn an_interrupted_crack_keeps_whole_images_only() {
    let dir = folder();
    let pixels = crate::program::png_bytes(&crate::program::photo((640, 400)));
    let inputs: Vec<String> = (0..300).map(|k| format!("i{k:03}.png")).collect();
    for name in &inputs {
        fs::write(dir.path().join(name), &pixels).unwrap();
    }
    let mut args = vec!["crack", "-o", "out", "--preset", "paper"];
    args.extend(inputs.iter().map(String::as_str));
    let out = dir.path().join("out");
    let begun = || fs::read_dir(&out).is_ok_and(|entries| entries.count() > 12);
    let outcome = interrupt(spawn(dir.path(), &args), begun);
    assert_eq!(outcome.code, Some(130), "{outcome:?}");
    assert!(outcome.stderr.contains("interrupted: "), "{outcome:?}");
    no_temporary_files(dir.path());
    let files = names(&out);
    let n_done = files.iter().filter(|name| name.ends_with(".json")).count();
    assert!(n_done > 0 && n_done < inputs.len(), "{n_done} done");
    assert_eq!(files.len(), 4 * n_done, "every image is whole: {files:?}");
}

#[test]
fn interrupted_frames_are_not_written() {
    let dir = folder();
    let args = [
        "simulate",
        "--preset",
        "paper",
        "--frames",
        "10000",
        "--frames-to",
        "f",
        "-o",
        "n.json",
    ];
    let folder = dir.path().join("f");
    let outcome = interrupt(spawn(dir.path(), &args), || folder.exists());
    assert_eq!(outcome.code, Some(130), "{outcome:?}");
    assert!(snapshot(dir.path()).is_empty(), "something was written");
}

#[test]
fn an_interrupted_demo_leaves_no_temporary_files() {
    let dir = folder();
    let folder = dir.path().join("d");
    let child = spawn(dir.path(), &["demo", "-o", "d", "--preset", "paper"]);
    let outcome = interrupt(child, || folder.exists());
    no_temporary_files(dir.path());
    assert!(
        matches!(outcome.code, Some(0 | 130)),
        "done, or stopped in order: {outcome:?}"
    );
}

#[test]
fn an_interrupted_bank_is_not_written() {
    let dir = folder();
    let args = [
        "patterns", "-n", "100000", "-o", "bank", "--preset", "paper",
    ];
    let bank = dir.path().join("bank");
    let outcome = interrupt(spawn(dir.path(), &args), || bank.exists());
    assert_eq!(outcome.code, Some(130), "{outcome:?}");
    assert!(
        outcome
            .stderr
            .contains("as a whole or not at all, so nothing was written"),
        "{outcome:?}"
    );
    assert_eq!(names(dir.path()), [""; 0], "something is left");
}
