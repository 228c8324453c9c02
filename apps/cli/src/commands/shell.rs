//! `starbreak completions` and `starbreak man`, generated from the command line's definition.

use std::path::Path;

use serde_json::json;

use crate::args::{Global, command};
use crate::failure::{DONE, Failure};
use crate::screen::{Screen, path_text};

pub(crate) fn completions(shell: clap_complete::Shell, screen: &Screen) -> Result<u8, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut command(), "starbreak", &mut script);
    screen.data(&String::from_utf8_lossy(&script))?;
    Ok(DONE)
}

pub(crate) fn man_pages(global: &Global, output: &Path, screen: &Screen) -> Result<u8, Failure> {
    let mut command = command();
    command.build();
    let mut batch = global.batch();
    let mut names = Vec::new();
    let pages = std::iter::once(command.clone()).chain(command.get_subcommands().cloned());
    for page in pages {
        if page.get_name() == "help" {
            continue;
        }
        let name = page
            .get_display_name()
            .unwrap_or(page.get_name())
            .to_owned();
        let mut text = Vec::new();
        clap_mangen::Man::new(page.display_name(name.clone()))
            .render(&mut text)
            .map_err(|cause| Failure::wrong_input(format!("man page {name}: {cause}")))?;
        batch.stage(&output.join(format!("{name}.1")), &text)?;
        names.push(format!("{name}.1"));
    }
    batch.commit()?;
    screen.say(&format!(
        "{} man pages in {}",
        names.len(),
        output.display()
    ));
    screen.result(|| json!({ "folder": path_text(output), "pages": names }))?;
    Ok(DONE)
}
