use starbreak::glass::CrackNetwork;

use crate::Vocabulary;

/// Words of a network file, and values that sit on an edge.
pub(crate) const VOCABULARY: Vocabulary = &[
    "\"parent\":[null,0]",
    "\"parent\":null",
    "\"arrival_step\":[0,1]",
    "\"arrival_us\":[0.5]",
    "\"depth_fraction\":[1]",
    "\"departure_us\":[0.25]",
    "\"zone\":[\"mirror\",\"mist\",\"hackle\"]",
    "\"roughness_um\":[0.5]",
    "\"tilt_deg\":[-89.5]",
    "\"ply\":[0,255]",
    "\"k_ratio\":[1.5]",
    "\"kind\":\"cover\"",
    "\"model\":\"physics\"",
    "\"speed_m_s\":25",
    "\"available_j\":0.5",
    "\"summary\":{\"n_radial\":0,\"n_segments\":0,\"total_length\":0}",
    "\"propagated\"",
    "\"mst\"",
    "\"seed\":18446744073709551615",
    "null",
    "[]",
    "{}",
    "-0.0",
    "-1",
    "1e308",
    "1e-308",
    "4294967295",
    "0.30000000000000004",
    "\\u0000",
    ",",
];

/// A network that is accepted holds its invariants and survives being written and read again,
/// to the byte.
///
/// # Panics
/// If the input is a finding.
pub fn network(bytes: &[u8]) {
    let Ok(text) = str::from_utf8(bytes) else {
        return;
    };
    let Ok(network) = CrackNetwork::from_json(text) else {
        return;
    };
    if let Err(error) = network.check_invariants() {
        panic!("accepted, but {error}");
    }
    let written = network.to_json();
    match CrackNetwork::from_json(&written) {
        Ok(again) => {
            assert_eq!(again, network, "written and read again:\n{written}");
            assert_eq!(again.to_json(), written, "written twice");
        }
        Err(error) => panic!("does not read what it wrote: {error}\n{written}"),
    }
}
