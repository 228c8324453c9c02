//! Banks of patterns: cracks simulated and baked once, for any number of images.
//!
//! A bank is one file, `patterns.bank`. Its header ([`BankHeader`]) says what its patterns were
//! made from; each pattern has a record with its crack network, and one for each frame size with
//! what the optics baked. Pattern k depends on recipe, seed and k alone, so that a bank of 100 is
//! the beginning of the bank of 1000.

mod baked;
mod facts;
mod frame_sizes;
mod header;
mod network_record;
mod overlays;
mod picture;
mod read;
mod write;

pub use facts::{PatternFacts, PatternRow};
pub use frame_sizes::FrameSizes;
pub use header::{BANK_SCHEMA, BankHeader, BankKind};
pub use overlays::{
    OVERLAY_BANK_FILE, OVERLAY_BANK_SCHEMA, OverlayBank, OverlayBankDraft, OverlayBankHeader,
    OverlayRow, write_overlay_bank,
};
pub use picture::BankIn;
pub use read::{BankPattern, PatternBank};
pub use write::{BankDraft, BankReport, write_bank};

/// Name of the file in a bank's folder.
pub const BANK_FILE: &str = "patterns.bank";
