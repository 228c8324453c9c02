//! A crack network as a record: the same network to the bit.

use starbreak_glass::{CrackNetwork, NetworkError};

/// The record of a network.
pub(super) fn network_to_bytes(network: &CrackNetwork) -> Vec<u8> {
    network.to_json().into_bytes()
}

/// The network of a record, checked in full.
pub(super) fn network_of_bytes(bytes: &[u8]) -> Result<CrackNetwork, NetworkError> {
    CrackNetwork::from_json(&String::from_utf8_lossy(bytes))
}
