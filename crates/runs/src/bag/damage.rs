//! What is wrong with a bag that is not whole.

use std::fmt;

use serde_json::{Value, json};

/// Where and why a bag is not whole.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Damage {
    /// Where the first record begins that was not read.
    pub at_byte: u64,
    /// What is wrong there.
    pub reason: String,
    /// Chunks that were left out because they are broken; those behind them were read.
    pub n_lost_chunks: u64,
    /// The byte from which on nothing was read.
    pub ends_at_byte: Option<u64>,
}

impl Damage {
    /// As it stands in results.
    #[must_use]
    pub fn to_json(&self) -> Value {
        json!({
            "at_byte": self.at_byte,
            "reason": self.reason,
            "n_lost_chunks": self.n_lost_chunks,
            "ends_at_byte": self.ends_at_byte,
        })
    }
}

impl fmt::Display for Damage {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            at_byte, reason, ..
        } = self;
        write!(to, "{reason} (byte {at_byte})")?;
        match self.n_lost_chunks {
            0 => {}
            1 => write!(to, ", and that chunk is left out")?,
            n => write!(to, ", and {n} such chunks are left out")?,
        }
        match self.ends_at_byte {
            Some(end) if end > *at_byte => write!(to, "; from byte {end} on nothing was read"),
            Some(_) => write!(to, "; what stands before it was read"),
            None => Ok(()),
        }
    }
}
