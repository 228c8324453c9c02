//! Flags that a verb has no use for: hidden in its help, and refused where they would seem to be heard.

use clap::error::ErrorKind;
use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, Command};

/// Verbs that break glass by a recipe.
const BREAKING: &[&str] = &[
    "demo", "crack", "generate", "sweep", "simulate", "patterns", "video", "bag", "pipe", "study",
    "recipe", "bench",
];
/// What says which recipe.
const OF_RECIPE: [&str; 5] = ["recipe", "preset", "severity", "camera", "set"];

/// Whether a verb has a use for one of the flags that all verbs are given.
fn is_used(verb: &str, flag: &str) -> bool {
    let is_among = |verbs: &[&str]| verbs.contains(&verb);
    match flag {
        "max_memory" => is_among(BREAKING) || verb == "verify",
        "seed" => {
            is_among(BREAKING) && verb != "recipe"
                || is_among(&["divergence", "evaluate", "timeline"])
        }
        "threads" => !is_among(&[
            "demo",
            "sweep",
            "simulate",
            "bench",
            "pipe",
            "recipe",
            "merge",
            "completions",
            "man",
        ]),
        "replace" => !is_among(&["verify", "merge", "pipe", "recipe", "completions"]),
        "follow_links" => is_among(&["generate", "verify", "detect", "divergence", "patterns"]),
        "json" => verb != "completions",
        _ if OF_RECIPE.contains(&flag) => is_among(BREAKING),
        _ => true,
    }
}

/// The definition of the command line, each verb without what it has no use for.
pub(super) fn hidden(mut command: Command) -> Command {
    let flags: Vec<Arg> = command.get_arguments().cloned().collect();
    let verbs: Vec<String> = command
        .get_subcommands()
        .map(|verb| verb.get_name().to_owned())
        .collect();
    for name in verbs {
        let unused = flags
            .iter()
            .filter(|flag| !is_used(&name, flag.get_id().as_str()));
        // A verb that has a flag already is not given that of all verbs.
        let hidden = unused.map(|flag| flag.clone().hide(true));
        command = command.mut_subcommand(&name, |verb| verb.args(hidden));
    }
    command
}

/// Refuses a recipe for a verb that breaks no glass; `verify` says itself why it takes none.
pub(super) fn refuse(command: &mut Command, matches: &ArgMatches) -> Result<(), clap::Error> {
    let Some((verb, given)) = matches.subcommand() else {
        return Ok(());
    };
    let is_given = |flag: &&str| given.value_source(flag) == Some(ValueSource::CommandLine);
    let idle = OF_RECIPE.into_iter().find(is_given);
    match idle.filter(|flag| verb != "verify" && !is_used(verb, flag)) {
        Some(flag) => Err(command.error(
            ErrorKind::ArgumentConflict,
            format!("`{verb}` breaks no glass, so it has no use for --{flag}; leave it out"),
        )),
        None => Ok(()),
    }
}
