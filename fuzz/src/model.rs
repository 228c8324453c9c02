use starbreak_detect::{Contract, LabelRules, ModelFacts, ModelLimits, choose};

use crate::Vocabulary;

/// Words of contracts and of graphs, and values that sit on an edge.
pub(crate) const VOCABULARY: Vocabulary = &[
    "schema = 1\n",
    "[input]\n",
    "[output]\n",
    "[classes]\n",
    "names = [\"a\", \"-\"]\n",
    "list = \"coco-80\"\n",
    "score_threshold = 0.3\n",
    "= \"letterbox\"\n",
    "size = [640, 640]\n",
    "mean = [0.1, 0.2, 0.3]\n",
    "= nan\n",
    "= 1e400\n",
    "[map]\n\"a\" = \"-\"\n",
    "images",
    "output0",
    "Tile",
    "Pad",
    "Resize",
    "Expand",
    "Concat",
    "ConstantOfShape",
    "MatMul",
    "names",
    "{0: 'person', 1: 'car'}",
    "axis",
    "\u{8}\u{7f}",
    "\u{12}\u{0}",
    "\u{0}",
];

/// A contract, a map of labels or an ONNX model is refused with one printable line, or is what it
/// says; of a model its facts are read and its contract is chosen, and it is not run. Text is tried
/// as a contract and as a map, all else as a model.
///
/// # Panics
/// If the input is a finding.
pub fn model(bytes: &[u8]) {
    let is_text = bytes.starts_with(b"schema") || bytes.starts_with(b"#");
    if let (true, Ok(text)) = (is_text, str::from_utf8(bytes)) {
        if let Err(error) = Contract::parse("fuzz.toml", text) {
            is_one_line(&error.to_string());
        }
        if let Err(error) = LabelRules::parse("fuzz.toml", text) {
            is_one_line(&error.to_string());
        }
        return;
    }
    match ModelFacts::of_bytes("fuzz.onnx", bytes, &ModelLimits::default()) {
        Ok(facts) => {
            is_one_line(&facts.to_string());
            if let Err(error) = choose("fuzz.onnx", &facts) {
                is_one_line(&error.to_string());
            }
        }
        Err(error) => {
            let message = error.to_string();
            is_one_line(&message);
            assert!(
                !message.contains("breaks the parser"),
                "the parser panicked"
            );
        }
    }
}

fn is_one_line(message: &str) {
    assert!(
        !message.contains(char::is_control),
        "a message that is not one printable line: {message:?}"
    );
}
