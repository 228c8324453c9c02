//! Networks from files: our own JSON, and drawings in SVG that somebody traced over a photo.

mod error;
mod svg;

use starbreak_glass::CrackNetwork;

pub use error::ImportError;

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
