//! Whether something is known against a package that we link.
//!
//! crates.io says which versions were withdrawn ("yanked"), through cargo itself. Advisories are in
//! RustSec's database, which no registry has: `cargo audit` reads it where that is installed and
//! the database is there or can be fetched. What was not checked is said.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use crate::Failure;
use crate::command::{cargo, line_of};
use crate::metadata::{Metadata, Package};

/// Where the pins are resolved, in the target folder.
const FOLDER: &str = "xtask-yanked";

/// `cargo xtask advisories`
///
/// # Errors
/// If a version in the lock file was withdrawn, or `cargo audit` finds an advisory.
pub fn run(root: &Path) -> Result<(), Failure> {
    let metadata = Metadata::of_workspace(root)?;
    let used: Vec<&Package> = metadata
        .packages
        .iter()
        .filter(|package| !package.is_ours)
        .collect();
    let folder = metadata.target_directory.join(FOLDER);
    let yanked = withdrawn(&folder, &pins(&used))?;
    let audited = audit(root)?;
    println!("advisories: {}", yanked.said(used.len(), &today()));
    println!("advisories: {}", audited.said());
    let found = [yanked.finding(), audited.finding()];
    let findings: Vec<String> = found.into_iter().flatten().collect();
    Failure::from_findings(&findings, "packages have something against them")
}

/// What one source says.
#[derive(Debug, PartialEq, Eq)]
enum Answer {
    /// Nothing against any package; where and of when the data is, if it says so.
    Clean(String),
    /// Something.
    Found(String),
    /// It could not be asked.
    Unknown(String),
}

impl Answer {
    fn finding(&self) -> Option<String> {
        match self {
            Self::Found(what) => Some(what.clone()),
            Self::Clean(_) | Self::Unknown(_) => None,
        }
    }
}

/// Whether versions were withdrawn.
struct Withdrawn(Answer);

impl Withdrawn {
    fn finding(&self) -> Option<String> {
        self.0.finding()
    }

    fn said(&self, n_packages: usize, today: &str) -> String {
        match &self.0 {
            Answer::Clean(_) => {
                format!("of {n_packages} versions none is withdrawn, by crates.io on {today}")
            }
            Answer::Found(what) => format!("withdrawn by crates.io on {today}: {what}"),
            Answer::Unknown(why) => {
                format!(
                    "NOT CHECKED whether versions are withdrawn: crates.io did not answer: {why}"
                )
            }
        }
    }
}

/// Whether there are advisories.
struct Audited(Answer);

impl Audited {
    fn finding(&self) -> Option<String> {
        self.0.finding()
    }

    fn said(&self) -> String {
        match &self.0 {
            Answer::Clean(data) => format!("cargo audit finds none; {data}"),
            Answer::Found(what) => format!("cargo audit finds some: {what}"),
            Answer::Unknown(why) => format!(
                "NOT CHECKED for advisories: {why}; `cargo install cargo-audit`, and a copy of RustSec's database, \
                 which is on no registry, would do it"
            ),
        }
    }
}

/// A manifest that asks for these versions and no others.
fn pins(packages: &[&Package]) -> String {
    let mut manifest = "[package]\nname = \"yanked\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\
                        [workspace]\n[dependencies]\n"
        .to_owned();
    for (k, Package { name, version, .. }) in packages.iter().enumerate() {
        // What stands behind the plus is no part of a version that can be asked for.
        let version = version.split('+').next().unwrap_or(version);
        let _ = writeln!(
            manifest,
            "p{k} = {{ package = {name:?}, version = \"={version}\", default-features = false }}"
        );
    }
    manifest
}

/// Cargo resolves a manifest without a lock file to versions that were not withdrawn.
fn withdrawn(folder: &Path, manifest: &str) -> Result<Withdrawn, Failure> {
    let unwritten = |cause| Failure::of_file(folder, &cause);
    let _ = fs::remove_dir_all(folder);
    fs::create_dir_all(folder.join("src")).map_err(unwritten)?;
    fs::write(folder.join("src/lib.rs"), "").map_err(unwritten)?;
    fs::write(folder.join("Cargo.toml"), manifest).map_err(unwritten)?;
    let command = cargo(folder, &["generate-lockfile"]);
    let (is_good, said) = answer(command)?;
    Ok(Withdrawn(of_resolver(is_good, &said)))
}

fn of_resolver(is_good: bool, said: &str) -> Answer {
    let mut lines = said.lines().map(str::trim);
    match lines.find(|line| line.contains("yanked")) {
        _ if is_good => Answer::Clean(String::new()),
        Some(_) => {
            let words: Vec<&str> = said.split_whitespace().collect();
            Answer::Found(words.join(" "))
        }
        None => Answer::Unknown(last_line(said)),
    }
}

/// What `cargo audit` says of the lock file, if it is there.
fn audit(root: &Path) -> Result<Audited, Failure> {
    let (is_there, _) = answer(cargo(root, &["audit", "--version"]))?;
    if !is_there {
        let why = "cargo audit is not installed".to_owned();
        return Ok(Audited(Answer::Unknown(why)));
    }
    let (is_good, said) = answer(cargo(root, &["audit", "--json"]))?;
    Ok(Audited(of_audit(is_good, &said)))
}

fn of_audit(is_good: bool, said: &str) -> Answer {
    let json = said.find('{').and_then(|at| {
        let mut values = serde_json::Deserializer::from_str(&said[at..]).into_iter();
        values.next()?.ok()
    });
    let Some(serde_json::Value::Object(json)) = json else {
        return Answer::Unknown(format!("cargo audit failed: {}", last_line(said)));
    };
    let database = json.get("database").cloned().unwrap_or_default();
    let n = &database["advisory-count"];
    let date = database["last-updated"].as_str().unwrap_or("?");
    let data = format!("RustSec's database of {date}, {n} advisories");
    let list = json
        .get("vulnerabilities")
        .and_then(|all| all["list"].as_array());
    let ids = list.into_iter().flatten().map(|one| {
        let (package, id) = (&one["package"], &one["advisory"]["id"]);
        format!("{} {}: {}", package["name"], package["version"], id).replace('"', "")
    });
    let ids: Vec<String> = ids.collect();
    match (ids.as_slice(), is_good) {
        ([], true) => Answer::Clean(data),
        ([], false) => Answer::Unknown(format!("cargo audit failed: {}", last_line(said))),
        (ids, _) => Answer::Found(format!("{} ({data})", ids.join(", "))),
    }
}

/// Whether a command ended well, and what it said.
fn answer(mut command: Command) -> Result<(bool, String), Failure> {
    let line = line_of(&command);
    let output = command
        .output()
        .map_err(|cause| Failure::new(format!("{line}: {cause}")))?;
    let said = [output.stdout, output.stderr].concat();
    Ok((
        output.status.success(),
        String::from_utf8_lossy(&said).into_owned(),
    ))
}

fn last_line(said: &str) -> String {
    let mut lines = said.lines().map(str::trim).rev();
    let last = lines.find(|line| !line.is_empty());
    last.unwrap_or("it said nothing").to_owned()
}

/// The day by UTC, as 2026-01-31, as the system says it.
fn today() -> String {
    let mut date = Command::new("date");
    date.args(["-u", "+%F"]);
    match answer(date) {
        Ok((true, said)) => said.trim().to_owned(),
        _ => "a day that this system does not tell".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_withdrawn_version_is_found_and_silence_is_not_innocence() {
        let said = "error: failed to select a version for the requirement `futures = \"=0.3.18\"`\n  \
                    version 0.3.18 is yanked\nlocation searched: crates.io index\n";
        let found = of_resolver(false, said);
        assert!(
            matches!(&found, Answer::Found(what) if what.contains("0.3.18 is yanked")),
            "{found:?}"
        );
        let offline = "error: failed to get `futures`\n\nCaused by:\n  no network\n";
        let unknown = of_resolver(false, offline);
        assert_eq!(unknown, Answer::Unknown("no network".to_owned()), "offline");
        assert!(
            Withdrawn(unknown)
                .said(3, "2026-01-01")
                .contains("NOT CHECKED"),
            "said aloud"
        );
        let good = Withdrawn(of_resolver(true, "     Locking 3 packages"));
        assert!(good.said(3, "2026-01-01").contains("2026-01-01"), "the day");
    }

    #[test]
    fn what_cargo_audit_says_is_read_with_the_date_of_its_data() {
        let clean = r#"{"database":{"advisory-count":900,"last-updated":"2026-10-02T11:00:00Z"},
            "vulnerabilities":{"found":false,"count":0,"list":[]}}"#;
        let said = Audited(of_audit(true, clean)).said();
        assert!(
            said.contains("2026-10-02") && said.contains("900"),
            "{said}"
        );
        let bad = clean.replace(
            "\"list\":[]",
            r#""list":[{"advisory":{"id":"RUSTSEC-2020-0001"},"package":{"name":"png","version":"0.1.0"}}]"#,
        );
        let found = Audited(of_audit(false, &bad)).finding().unwrap_or_default();
        assert!(found.contains("png 0.1.0: RUSTSEC-2020-0001"), "{found}");
        let failed = Audited(of_audit(false, "error: couldn't fetch advisory database"));
        assert_eq!(failed.finding(), None, "nothing is known");
        assert!(failed.said().contains("NOT CHECKED"), "said aloud");
    }

    #[test]
    fn pins_ask_for_just_the_versions_of_the_lock_file() {
        let package = Package {
            name: "toml".to_owned(),
            version: "1.2.1+spec-1.1.0".to_owned(),
            ..Package::default()
        };
        let manifest = pins(&[&package]);
        assert!(
            manifest.contains("package = \"toml\", version = \"=1.2.1\""),
            "{manifest}"
        );
    }
}
