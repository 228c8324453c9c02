//! What a reader of TOML or JSON says of a value, in words that need no Rust.

/// The message with the kinds of its types in words; what it says of the place, at its end, stays.
pub(crate) fn in_plain_words(message: &str) -> String {
    let (said, place) = match message.find(" at line ") {
        Some(at) => message.split_at(at),
        None => (message, ""),
    };
    let said = said
        .replace("invalid type: unit variant, ", "")
        .replace("unknown variant `", "unknown word `")
        .replace("unknown field `", "unknown key `")
        .replace("missing field `", "missing key `");
    let Some((before, kind)) = said.rsplit_once("expected ") else {
        return format!("{said}{place}");
    };
    let kind = match kind {
        "f32" | "f64" => "a number",
        "u8" | "u16" | "u32" | "u64" | "usize" | "i32" | "i64" => "a whole number",
        "string only" | "a string" | "a borrowed string" => "text",
        "a boolean" => "true or false",
        kind if kind.starts_with("struct ") => "a table",
        kind => kind,
    };
    format!("{before}expected {kind}{place}")
}

#[cfg(test)]
mod tests {
    use super::in_plain_words;

    #[test]
    fn kinds_are_words_and_places_stay() {
        for (said, words) in [
            (
                "invalid type: string \"u32\", expected f64",
                "invalid type: string \"u32\", expected a number",
            ),
            (
                "invalid value: integer `-1`, expected u32 at line 1 column 9",
                "invalid value: integer `-1`, expected a whole number at line 1 column 9",
            ),
            (
                "invalid type: unit variant, expected string only",
                "expected text",
            ),
            (
                "invalid type: integer `5`, expected struct Nodes at line 1 column 10",
                "invalid type: integer `5`, expected a table at line 1 column 10",
            ),
            (
                "missing field `schema` at line 1 column 2",
                "missing key `schema` at line 1 column 2",
            ),
            (
                "unknown variant `a`, expected `b` or `c`",
                "unknown word `a`, expected `b` or `c`",
            ),
            ("duplicate key", "duplicate key"),
        ] {
            assert_eq!(in_plain_words(said), words);
        }
    }
}
