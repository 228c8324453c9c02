use starbreak::import::parse_network;

use crate::Vocabulary;

/// Words of a drawing, and values that sit on an edge.
pub(crate) const VOCABULARY: Vocabulary = &[
    "<g transform=\"rotate(30) scale(-1 2)\">",
    "</g>",
    "<use href=\"#a\" x=\"1\"/>",
    "<svg viewBox=\"0 0 5 5\" width=\"9\" height=\"9\">",
    "<circle class=\"impact\" cx=\"5\" cy=\"5\" r=\"1\"/>",
    "<ellipse stroke=\"red\" cx=\"5\" cy=\"5\" rx=\"3\" ry=\"2\"/>",
    "<polygon stroke=\"red\" points=\"0,0 9,9 9,0\"/>",
    "<line stroke=\"red\" x1=\"1\" y1=\"9\" x2=\"9\" y2=\"1\"/>",
    "<path stroke=\"red\" d=\"M1 1L9 9\"/>",
    "<style>path{stroke:none}</style>",
    " clip-path=\"url(#c)\"",
    " id=\"a\"",
    " class=\"ring\"",
    " style=\"display:none\"",
    " transform=\"matrix(1 2 3 4 5 6)\"",
    "viewBox=\"0 0 1e-6 1e9\"",
    "A5 5 30 1 0 9 9",
    "a1e-9 1e9 0 0 1 1 1",
    "C1 1 2 2 3 3",
    "S9 9 1 1",
    "q1 1 2 0",
    "T5 5",
    "H9V9z",
    "m0 0",
    "mm",
    "%",
    "em",
    "nan",
    "inf",
    "1e308",
    "1e-308",
    "-0",
    "&lt;",
    "<!--",
    "]]>",
];

/// A drawing that is accepted makes a network that holds its invariants, survives being written
/// as JSON, and reads back from its own drawing; a refusal is one printable line.
///
/// # Panics
/// If the input is a finding.
pub fn svg(bytes: &[u8]) {
    let Ok(text) = str::from_utf8(bytes) else {
        return;
    };
    let network = match parse_network(text) {
        Ok(network) => network,
        Err(error) => {
            let message = error.to_string();
            assert!(
                !message.contains(char::is_control),
                "a message that is not one printable line: {message:?}"
            );
            return;
        }
    };
    if let Err(error) = network.check_invariants() {
        panic!("accepted, but {error}");
    }
    match parse_network(&network.to_json()) {
        Ok(again) => assert_eq!(again, network, "written and read again"),
        Err(error) => panic!("does not read what it wrote: {error}"),
    }
    // Cracks shorter than a thousandth are points in a drawing.
    if network.summary().total_length > 1.0
        && let Err(error) = parse_network(&network.to_svg())
    {
        panic!("does not read its own drawing: {error}");
    }
}
