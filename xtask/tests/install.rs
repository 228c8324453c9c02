//! The archive of a release, and the script that installs it, on a made-up binary.
#![cfg(unix)]
#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test that cannot write its files has failed; one that is skipped says so"
)]

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use xtask::root;

/// Systems of whose binaries one is installed here.
const TARGETS: [&str; 4] = [
    "x86_64-unknown-linux-gnu",
    "aarch64-unknown-linux-gnu",
    "x86_64-apple-darwin",
    "aarch64-apple-darwin",
];

/// A release in a folder: archives of all systems and their checksums.
fn release(folder: &Path) {
    let _ = fs::remove_dir_all(folder);
    fs::create_dir_all(folder).unwrap();
    let binary = folder.join("starbreak");
    fs::write(&binary, "#!/bin/sh\necho starbreak 9.9.9\n").unwrap();
    fs::set_permissions(&binary, fs::Permissions::from_mode(0o755)).unwrap();
    let others = folder.join("others.txt");
    fs::write(&others, "licences of others").unwrap();
    for target in TARGETS {
        let mut pack = Command::new(root().join("packaging/archive.sh"));
        pack.arg(target).args([&binary, &others, &folder.into()]);
        let output = pack.output().unwrap();
        assert!(output.status.success(), "{output:?}");
    }
    let sums = "sha256sum *.tar.gz > SHA256SUMS || shasum -a 256 *.tar.gz > SHA256SUMS";
    let mut sum = Command::new("sh");
    let status = sum.args(["-c", sums]).current_dir(folder).status().unwrap();
    assert!(status.success(), "no checksums: {status}");
}

fn install(from: &Path, bin: &Path) -> Output {
    let mut install = Command::new("sh");
    install.arg(root().join("packaging/install.sh"));
    install.env("STARBREAK_FROM", format!("file://{}", from.display()));
    install.env("STARBREAK_BIN", bin).output().unwrap()
}

fn folder(name: &str) -> Option<PathBuf> {
    if Command::new("curl").arg("--version").output().is_err() {
        println!("SKIPPED: install.sh: there is no curl");
        return None;
    }
    Some(Path::new(env!("CARGO_TARGET_TMPDIR")).join(name))
}

#[test]
fn what_is_released_is_installed() {
    let Some(folder) = folder("install") else {
        return;
    };
    release(&folder);
    let bin = folder.join("bin");
    let output = install(&folder, &bin);
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{output:?}");
    assert!(said.starts_with("starbreak 9.9.9 is in "), "{said}");
    let archive = folder.join(format!("starbreak-{}.tar.gz", TARGETS[0]));
    let mut list = Command::new("tar");
    let listed = list.arg("-tzf").arg(archive).output().unwrap().stdout;
    let listed = String::from_utf8_lossy(&listed);
    for file in [
        "README.md",
        "LICENSE-MIT",
        "LICENSE-APACHE",
        "LICENSE-THIRD-PARTY.txt",
    ] {
        assert!(listed.contains(&format!("/{file}\n")), "{file}: {listed}");
    }
}

#[test]
fn an_archive_with_another_checksum_is_not_installed() {
    let Some(folder) = folder("install-changed") else {
        return;
    };
    release(&folder);
    for target in TARGETS {
        let archive = folder.join(format!("starbreak-{target}.tar.gz"));
        let mut bytes = fs::read(&archive).unwrap();
        *bytes.last_mut().unwrap() ^= 1;
        fs::write(&archive, bytes).unwrap();
    }
    let bin = folder.join("bin");
    let output = install(&folder, &bin);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success(), "installed: {output:?}");
    assert!(said.contains("SHA-256"), "{said}");
    assert!(!bin.join("starbreak").exists(), "{said}");
}
