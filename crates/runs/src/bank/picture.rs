//! The patterns of a bank as pictures, for whoever compares sets of pictures.

use std::path::Path;

use image::{DynamicImage, RgbImage};
use starbreak::{OpticsSettings, Stopwatch};
use starbreak_dataset::file_len;

use super::{BANK_FILE, OVERLAY_BANK_FILE, PatternBank};
use crate::Error;

/// Which kind of bank lies in a folder, if any.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BankIn {
    /// One of cracks.
    Cracks,
    /// One of photographs.
    Photos,
}

impl BankIn {
    /// The bank in a folder.
    #[must_use]
    pub fn folder(folder: &Path) -> Option<Self> {
        let has = |name: &str| file_len(&folder.join(name)).is_ok();
        let photos = has(OVERLAY_BANK_FILE).then_some(Self::Photos);
        has(BANK_FILE).then_some(Self::Cracks).or(photos)
    }
}

impl PatternBank {
    /// A pattern on black, in the first frame size of the bank: as the paper's optics draw it, and
    /// with the physical optics, which show the light of a scene that black has not, its crack mask.
    ///
    /// # Errors
    /// As for [`PatternBank::pattern`]; [`Error::Chain`].
    pub fn picture(&self, idx: usize) -> Result<DynamicImage, Error> {
        let size = self.header().sizes.first().copied().ok_or(Error::NoSize)?;
        let chain = self.pattern(idx, size, &mut Stopwatch::start())?.chain;
        match self.settings().optics {
            OpticsSettings::Physical(_) => Ok(chain.crack_mask()?.into()),
            OpticsSettings::Paper(_) => {
                let mut image = RgbImage::new(size.0, size.1).into();
                chain.over(&mut image, self.header().seed_of(idx))?;
                Ok(image)
            }
        }
    }
}
