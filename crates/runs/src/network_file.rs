//! Networks from files.

use std::path::Path;

use starbreak::ImportError;
use starbreak::import::{ImportedNetwork, parse_network};
use starbreak_dataset::{DatasetError, read_text};

use crate::Error;

/// Longest network file, bytes.
pub const MAX_NETWORK_FILE_BYTES: u64 = 1 << 26;

/// The network in a file, [`MAX_NETWORK_FILE_BYTES`] at most.
///
/// # Errors
/// [`Error::Dataset`] if it cannot be read, [`Error::Import`] if it is not a network.
pub fn read_network(path: &Path) -> Result<ImportedNetwork, Error> {
    let file = match read_text(path, MAX_NETWORK_FILE_BYTES) {
        Err(DatasetError::NotText { .. }) => {
            return Err(Error::Import {
                path: path.to_owned(),
                cause: ImportError::NotUtf8,
            });
        }
        file => file?,
    };
    let network = parse_network(&file.text).map_err(|cause| Error::Import {
        path: path.to_owned(),
        cause,
    })?;
    let name = path.file_name().unwrap_or(path.as_os_str());
    Ok(ImportedNetwork {
        network,
        name: name.to_string_lossy().into_owned(),
        sha256: file.sha256(),
    })
}
