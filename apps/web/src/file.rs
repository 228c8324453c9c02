//! What can be taken away.

use serde::Deserialize;

/// A file of a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub enum File {
    /// The damaged picture.
    #[serde(rename = "picture")]
    Picture,
    /// The picture as it was.
    #[serde(rename = "clean")]
    Clean,
    /// Where the glass affects it.
    #[serde(rename = "region")]
    Region,
    /// Where cracks are.
    #[serde(rename = "crack")]
    Crack,
    /// The cracks on the pane.
    #[serde(rename = "network.json")]
    Network,
    /// The same as a drawing.
    #[serde(rename = "network.svg")]
    Drawing,
    /// The recipe with its comments.
    #[serde(rename = "recipe")]
    Recipe,
}

impl File {
    /// What its name ends with, behind the stem of the picture's.
    #[must_use]
    pub fn suffix(self) -> &'static str {
        match self {
            Self::Picture => ".damaged.png",
            Self::Clean => ".png",
            Self::Region => ".region.png",
            Self::Crack => ".crack.png",
            Self::Network => ".network.json",
            Self::Drawing => ".network.svg",
            Self::Recipe => ".recipe.toml",
        }
    }

    /// Its media type.
    #[must_use]
    pub fn media_type(self) -> &'static str {
        match self {
            Self::Picture | Self::Clean | Self::Region | Self::Crack => "image/png",
            Self::Network => "application/json",
            Self::Drawing => "image/svg+xml",
            Self::Recipe => "application/toml",
        }
    }
}
