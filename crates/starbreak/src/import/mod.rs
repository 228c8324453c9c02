//! Networks from files: our own JSON, and drawings in SVG that somebody traced over a photo.

mod error;
mod geometry;
mod svg;

use std::path::Path;

use starbreak_dataset::{DatasetError, read_text};
use starbreak_glass::CrackNetwork;

use crate::Error;

pub use error::ImportError;
pub use geometry::crack_geometry;

/// Longest network file, bytes.
pub const MAX_NETWORK_FILE_BYTES: u64 = 1 << 26;

/// A network from a file, and which file.
#[derive(Debug, Clone, PartialEq)]
pub struct ImportedNetwork {
    /// The network.
    pub network: CrackNetwork,
    /// Name of the file, without its folder.
    pub name: String,
    /// SHA-256 of the bytes of the file, hexadecimal.
    pub sha256: String,
}

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

/// The network in a text: an SVG drawing if it begins with `<`, the network file in JSON if with
/// `{`. Space and a byte order mark before that are passed over.
///
/// # Errors
/// [`ImportError`].
pub fn parse_network(text: &str) -> Result<CrackNetwork, ImportError> {
    let text = text.trim_start_matches('\u{feff}').trim_start();
    match text.as_bytes().first() {
        Some(b'<') => svg::network(text),
        Some(b'{') => Ok(CrackNetwork::from_json(text)?),
        _ => Err(ImportError::UnknownFormat),
    }
}
