//! Why a file is not a network.

use starbreak_fracture::FractureError;
use starbreak_glass::NetworkError;

use crate::plain_words::in_plain_words;

/// Why the text of a file is not a network.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// No text at all.
    #[error(
        "is not UTF-8 text, so it is neither an SVG drawing nor a network in JSON; save it as UTF-8"
    )]
    NotUtf8,
    /// Neither SVG nor JSON.
    #[error(
        "is neither an SVG drawing nor a network in JSON; expected text that begins with `<` or `{{`"
    )]
    UnknownFormat,
    /// Not XML.
    #[error("is not valid XML: {cause}; save the drawing again as SVG")]
    Xml {
        /// What the parser says, with line and column.
        cause: String,
    },
    /// The root is not an SVG.
    #[error("is not an SVG: its root is <{root}>, expected <svg>; save the drawing as SVG")]
    Root {
        /// Name of the root element.
        root: String,
    },
    /// The drawing has no size, or one that makes no sense.
    #[error(
        "has no usable size: {what}; expected width and height, or a viewBox, each from 1e-6 to 1e9 px or mm"
    )]
    Size {
        /// What is wrong.
        what: String,
    },
    /// A value that makes no sense, or a feature that changes the drawing and is not read.
    #[error("line {line}, <{element}>: {what}")]
    Element {
        /// Line of the element's start, from 1.
        line: u32,
        /// Its name.
        element: String,
        /// What is wrong, and the way out.
        what: String,
    },
    /// More than a drawing of cracks needs.
    #[error("has more than {limit} {what}; draw less, or simplify the paths")]
    TooMuch {
        /// Of what.
        what: &'static str,
        /// The bound.
        limit: u64,
    },
    /// Nothing in it is a crack.
    #[error(
        "has no cracks: none of its paths, polylines, polygons, lines, circles and ellipses on the page has a stroke; give the cracks one"
    )]
    NoCracks,
    /// The lines do not make a network.
    #[error("is not a network: {0}")]
    Lines(#[from] FractureError),
    /// The JSON does not make a network.
    #[error("is not a crack network: {}", in_plain_words(&.0.to_string()))]
    Json(#[from] NetworkError),
}
