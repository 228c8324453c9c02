//! What the names in a drawing say.

use roxmltree::Node;
use starbreak_glass::SegmentKind;

const INKSCAPE: &str = "http://www.inkscape.org/namespaces/inkscape";

/// What an element is said to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Label {
    Crack(SegmentKind),
    Impact,
}

impl Label {
    /// A name like `radial`, `Ring-2` or `impact_17`.
    fn of_name(name: &str) -> Option<Self> {
        let stem = name.trim_end_matches(|c: char| c.is_ascii_digit() || " -_.".contains(c));
        if stem.eq_ignore_ascii_case("impact") {
            return Some(Self::Impact);
        }
        let kind = SegmentKind::ALL
            .into_iter()
            .find(|kind| stem.eq_ignore_ascii_case(kind.name()))?;
        Some(Self::Crack(kind))
    }

    /// The first that names one: Inkscape's label, the id, Illustrator's name, the classes.
    pub(super) fn of_element(node: Node<'_, '_>) -> Option<Self> {
        let whole = [
            node.attribute((INKSCAPE, "label")),
            node.attribute("id"),
            node.attribute("data-name"),
        ];
        let classes = node.attribute("class").unwrap_or_default();
        whole
            .into_iter()
            .flatten()
            .chain(classes.split_whitespace())
            .find_map(Self::of_name)
    }
}
