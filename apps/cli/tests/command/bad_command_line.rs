//! Flags and verbs that are wrong: one line that names the flag, code 2, nothing left behind.

use std::fs;

use crate::program::{all_refused, folder};

#[test]
fn wrong_command_lines_are_refused_in_one_line() {
    let dir = folder();
    fs::write(dir.path().join("r.toml"), "schema = 1\n").unwrap();
    let simulate = |args: &[&'static str], named| ([&["simulate"][..], args].concat(), named);
    all_refused(
        dir.path(),
        &[
            simulate(&["--nope"], "--nope"),
            simulate(&["--size", "0x5"], "--size"),
            simulate(&["--size", "5"], "--size"),
            simulate(&["--size", "99999x5"], "--size"),
            simulate(&["--frames", "0", "--frames-to", "f"], "--frames"),
            simulate(&["--frames-to", "f"], "--frames"),
            simulate(&["--recipe", "r.toml", "--preset", "paper"], "--preset"),
            simulate(&["--max-memory", "4"], "--max-memory"),
            simulate(&["--max-memory", "63MiB"], "--max-memory"),
            simulate(&["--max-memory=-1GiB"], "--max-memory"),
            simulate(&["--max-memory", "nanGB"], "--max-memory"),
            simulate(&["--seed", "-1"], "-1"),
            simulate(&["--seed", "1.5"], "--seed"),
            (vec!["carck", "a.png", "-o", "out"], "crack"),
            (vec!["crack", "-o", "out"], "IMAGE"),
            (vec!["crack", "", "-o", "out"], "IMAGE"),
            (vec!["crack", "a.png"], "--output"),
            (vec!["crack", "a.png", "-o", ""], "--output"),
            (vec!["bench", "--runs", "0", "-o", "out"], "--runs"),
            (vec!["bench", "--particles", "0", "-o", "out"], "particles"),
            (
                vec!["bench", "--particles", "x", "-o", "out"],
                "--particles",
            ),
            (vec!["completions", "tcsh"], "tcsh"),
        ],
    );
}
