//! What the XML parser would take too much time or memory for, found before it begins.

use crate::ImportError;

/// Most attributes of an element: the parser compares each with all others of the element.
const MAX_ATTRIBUTES: usize = 256;

/// Most bytes that the entities of a document may become.
const MAX_EXPANSION_BYTES: usize = 1 << 24;

/// References inside of one that the parser follows.
const REFERENCES_INSIDE: usize = 255;

/// Neither attributes nor entities are more than a drawing needs.
pub(super) fn check(text: &str) -> Result<(), ImportError> {
    // There is no `<` inside of a tag: each piece begins with the rest of one.
    let pieces = text.split('<').skip(1);
    let tags = pieces.filter(|piece| !piece.starts_with(['!', '?', '/']));
    if tags.map(n_quoted).any(|n| n > MAX_ATTRIBUTES) {
        return Err(ImportError::TooMuch {
            what: "attributes of one element",
            limit: MAX_ATTRIBUTES as u64,
        });
    }
    if expansion_bytes(text) > MAX_EXPANSION_BYTES {
        return Err(ImportError::TooMuch {
            what: "bytes out of entities",
            limit: MAX_EXPANSION_BYTES as u64,
        });
    }
    Ok(())
}

/// Texts in quotes before the end of a tag.
fn n_quoted(tag: &str) -> usize {
    let mut rest = tag;
    let mut n = 0;
    while let Some(at) = rest.find(['>', '"', '\'']) {
        let (quote, after) = (&rest[at..=at], &rest[at + 1..]);
        if quote == ">" {
            break;
        }
        n += 1;
        let Some(end) = after.find(quote) else {
            break;
        };
        rest = &after[end + 1..];
    }
    n
}

/// A bound of what all entities together become.
fn expansion_bytes(text: &str) -> usize {
    let values = text.split("<!ENTITY").skip(1).filter_map(|declared| {
        let at = declared.find(['"', '\''])?;
        let (quote, after) = (&declared[at..=at], &declared[at + 1..]);
        Some(&after[..after.find(quote).unwrap_or(after.len())])
    });
    let values: Vec<&str> = values.collect();
    let longest = values.iter().map(|value| value.len()).max().unwrap_or(0);
    let has_inner = values.iter().any(|value| n_references(value) > 0);
    let each = longest.saturating_mul(if has_inner { REFERENCES_INSIDE } else { 1 });
    n_references(text).saturating_mul(each)
}

/// References to entities but those that every document has.
fn n_references(text: &str) -> usize {
    const KNOWN: [&str; 6] = ["#", "amp;", "lt;", "gt;", "quot;", "apos;"];
    let references = text.split('&').skip(1);
    references
        .filter(|name| !KNOWN.iter().any(|known| name.starts_with(known)))
        .count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_are_counted_up_to_the_end_of_their_tag() {
        for (tag, n) in [
            ("g>\"\"\"\"", 0),
            ("g a=\"1\" b='>\"' c=\"'\"/> text \"", 3),
            ("g a=\"1", 1),
            ("", 0),
        ] {
            assert_eq!(n_quoted(tag), n, "{tag}");
        }
    }

    #[test]
    fn entities_count_as_what_they_become() {
        let text = "<!DOCTYPE svg [<!ENTITY a \"1234\">]><g x=\"&a;&#38;\">&a;&amp;</g>";
        assert_eq!(expansion_bytes(text), 8, "two of four bytes");
        let nested = "<!ENTITY a \"1234\"><!ENTITY b '&a;&a;'>&b;";
        assert_eq!(
            expansion_bytes(nested),
            3 * 6 * 255,
            "one inside of another"
        );
    }
}
