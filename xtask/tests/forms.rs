//! Files whose form others prescribe fit their published schemas: workflows, issue forms and the
//! citation. check-jsonschema carries the schemas.
#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test that cannot read its files has failed; one that is skipped says so"
)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use xtask::root;

const SKIPPED: &str =
    "SKIPPED: schemas: STARBREAK_TEST_PYTHON is not set; `cargo xtask test` provides a Python";

fn check(schema: &str, files: &[PathBuf]) -> Option<Output> {
    let python = std::env::var_os("STARBREAK_TEST_PYTHON")?;
    let mut check = Command::new(python);
    check.args(["-m", "check_jsonschema", "--builtin-schema", schema]);
    Some(check.args(files).output().unwrap())
}

/// All YAML files of a folder.
fn files_in(folder: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(root().join(folder)).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    paths
        .filter(|path| path.extension().is_some_and(|e| e == "yml"))
        .collect()
}

#[test]
fn workflows_issue_forms_and_citation_fit_their_schemas() {
    let is_config = |path: &PathBuf| path.ends_with("config.yml");
    let (config, issues) = files_in(".github/ISSUE_TEMPLATE")
        .into_iter()
        .partition(is_config);
    for (schema, files) in [
        ("github-workflows", files_in(".github/workflows")),
        ("github-issue-forms", issues),
        ("github-issue-config", config),
        ("citation-file-format", vec![root().join("CITATION.cff")]),
    ] {
        assert!(!files.is_empty(), "no file for {schema}");
        let Some(output) = check(&format!("vendor.{schema}"), &files) else {
            println!("{SKIPPED}");
            return;
        };
        let said = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{schema}: {said}{output:?}");
    }
}

#[test]
fn a_broken_workflow_is_found() {
    let text = fs::read_to_string(root().join(".github/workflows/checks.yml")).unwrap();
    let broken = text.replace("runs-on:", "runs-in:");
    assert_ne!(text, broken, "nothing was broken");
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("broken-workflow.yml");
    fs::write(&path, broken).unwrap();
    let Some(output) = check("vendor.github-workflows", &[path]) else {
        println!("{SKIPPED}");
        return;
    };
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(!output.status.success(), "passed: {said}");
    assert!(said.contains("jobs"), "does not say where: {said}");
}
