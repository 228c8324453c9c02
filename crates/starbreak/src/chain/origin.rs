//! What a layer was made from.

use starbreak_glass::CrackNetwork;
use starbreak_seed::Seed;

use crate::Details;
use crate::photo::PlacedPhoto;

/// What a layer was made from.
#[derive(Debug, Clone)]
pub(super) enum Origin {
    Network(Box<Cracks>),
    Photo(Box<PlacedPhoto>),
    /// A bank, which keeps the network, or no glass at all.
    Stored,
}

#[derive(Debug, Clone)]
pub(super) struct Cracks {
    pub(super) network: CrackNetwork,
    /// None where the network was kept without them.
    pub(super) details: Option<Details>,
    /// It places what the network leaves open.
    pub(super) seed: Seed,
}

impl Origin {
    pub(super) fn network(&self) -> Option<&CrackNetwork> {
        match self {
            Self::Network(cracks) => Some(&cracks.network),
            Self::Photo(_) | Self::Stored => None,
        }
    }

    pub(super) fn details(&self) -> Option<&Details> {
        match self {
            Self::Network(cracks) => cracks.details.as_ref(),
            Self::Photo(_) | Self::Stored => None,
        }
    }

    pub(super) fn photo(&self) -> Option<&PlacedPhoto> {
        match self {
            Self::Photo(placed) => Some(placed),
            Self::Network(_) | Self::Stored => None,
        }
    }
}
