use starbreak::RecipeError;
use starbreak_dataset::DatasetError;

/// What a question may come to, in the words of the command.
#[derive(Debug, thiserror::Error)]
pub enum Trouble {
    /// A recipe that is none.
    #[error(transparent)]
    Recipe(#[from] RecipeError),
    /// A picture that cannot be read or written.
    #[error(transparent)]
    File(#[from] DatasetError),
    /// Glass that cannot break so, or be shown.
    #[error(transparent)]
    Chain(#[from] starbreak::Error),
    /// Not what this module knows.
    #[error("not a question: {0}")]
    Question(#[from] serde_json::Error),
    /// A step too early.
    #[error("there is no {0} yet")]
    Missing(&'static str),
    /// A frame whose bytes are not those of its size.
    #[error(
        "{n_bytes} bytes are no picture of {width_px} x {height_px} px; expected four for each pixel"
    )]
    Frame {
        /// How many came.
        n_bytes: usize,
        /// Its width, px.
        width_px: u32,
        /// Its height, px.
        height_px: u32,
    },
}
