//! `--network FILE`: a network from a file in the place of a simulated one.

use std::path::{Path, PathBuf};

use starbreak::import::ImportedNetwork;
use starbreak_dataset::same_file;
use starbreak_runs::read_network;

use crate::failure::Failure;

/// The network, if a file was named; none of the outputs is that file.
pub(super) fn read(
    file: Option<&Path>,
    outputs: &[PathBuf],
) -> Result<Option<ImportedNetwork>, Failure> {
    let Some(file) = file else { return Ok(None) };
    if let Some(output) = outputs.iter().find(|output| same_file(file, output)) {
        return Err(Failure::wrong_input(format!(
            "the output {output:?} would replace the network {file:?}; choose another name"
        )));
    }
    Ok(Some(read_network(file)?))
}
