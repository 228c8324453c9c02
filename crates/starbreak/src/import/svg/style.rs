//! The few properties of CSS that decide whether a shape is a crack.

use std::cell::Cell;

use roxmltree::Node;
use simplecss::{AttributeOperator, DeclarationTokenizer, Element, PseudoClass, StyleSheet};

use crate::ImportError;

/// Most questions that style rules may ask of elements.
pub(super) const MAX_QUESTIONS: u64 = 20_000_000;

/// Longest style sheets together and longest `style` of an element, bytes: the time that the parser
/// of CSS takes grows with the square.
const MAX_SHEET_BYTES: usize = 1 << 17;
const MAX_STYLE_BYTES: usize = 1 << 12;

/// The properties.
pub(super) const PROPERTIES: [&str; 7] = [
    "display",
    "visibility",
    "stroke",
    "stroke-width",
    "clip-path",
    "transform",
    "transform-origin",
];

/// What is declared for an element itself, in the order of [`PROPERTIES`].
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Declared<'a> {
    values: [Option<(&'a str, bool)>; PROPERTIES.len()],
}

impl<'a> Declared<'a> {
    pub(super) fn get(&self, name: &str) -> Option<&'a str> {
        let idx = PROPERTIES.iter().position(|known| *known == name)?;
        self.values[idx].map(|(value, _)| value.trim())
    }

    /// Later ones win, but for those marked as important.
    fn declare(&mut self, name: &str, value: &'a str, is_important: bool) {
        let Some(idx) = PROPERTIES.iter().position(|known| *known == name) else {
            return;
        };
        let is_held = self.values[idx].is_some_and(|(_, held)| held) && !is_important;
        if !is_held {
            self.values[idx] = Some((value, is_important));
        }
    }
}

/// The style rules of a drawing.
pub(super) struct Styles<'a> {
    sheet: StyleSheet<'a>,
    questions_left: Cell<u64>,
}

impl<'a> Styles<'a> {
    /// Of all `<style>` elements.
    pub(super) fn of(document: &'a roxmltree::Document<'_>) -> Result<Self, ImportError> {
        let mut sheet = StyleSheet::new();
        let mut bytes_left = MAX_SHEET_BYTES;
        for node in document.descendants() {
            let own = node.attribute("style").unwrap_or_default();
            if own.len() > MAX_STYLE_BYTES {
                return Err(ImportError::TooMuch {
                    what: "bytes in the style of one element",
                    limit: MAX_STYLE_BYTES as u64,
                });
            }
            if node.has_tag_name("style") || node.tag_name().name() == "style" {
                let is_css = matches!(node.attribute("type"), None | Some("" | "text/css"));
                if let (true, Some(text)) = (is_css, node.text()) {
                    let left = bytes_left.checked_sub(text.len());
                    bytes_left = left.ok_or(ImportError::TooMuch {
                        what: "bytes of style sheets",
                        limit: MAX_SHEET_BYTES as u64,
                    })?;
                    sheet.parse_more(text);
                }
            }
        }
        Ok(Self {
            sheet,
            questions_left: Cell::new(MAX_QUESTIONS),
        })
    }

    /// Attributes, then rules by specificity, then `style`. None once the questions ran out.
    pub(super) fn of_element(&self, node: Node<'a, '_>) -> Option<Declared<'a>> {
        let mut declared = Declared::default();
        for attribute in node.attributes() {
            if attribute.namespace().is_none() {
                declared.declare(attribute.name(), attribute.value(), false);
            }
        }
        let asked = Asked {
            node,
            left: &self.questions_left,
        };
        for rule in &self.sheet.rules {
            // Each rule is a question, too, and so is what it declares.
            if !asked.is_answered() {
                break;
            }
            if rule.selector.matches(&asked) {
                for one in &rule.declarations {
                    if !asked.is_answered() {
                        break;
                    }
                    declared.declare(one.name, one.value, one.important);
                }
            }
        }
        if let Some(text) = node.attribute("style") {
            for one in DeclarationTokenizer::from(text) {
                declared.declare(one.name, one.value, one.important);
            }
        }
        (self.questions_left.get() > 0).then_some(declared)
    }
}

/// An element that counts what it is asked.
#[derive(Clone, Copy)]
struct Asked<'a, 'input, 'c> {
    node: Node<'a, 'input>,
    left: &'c Cell<u64>,
}

impl Asked<'_, '_, '_> {
    fn is_answered(&self) -> bool {
        self.left.set(self.left.get().saturating_sub(1));
        self.left.get() > 0
    }
}

impl Element for Asked<'_, '_, '_> {
    fn parent_element(&self) -> Option<Self> {
        let node = self.node.parent_element().filter(|_| self.is_answered())?;
        Some(Self { node, ..*self })
    }

    fn prev_sibling_element(&self) -> Option<Self> {
        let node = self
            .node
            .prev_sibling_element()
            .filter(|_| self.is_answered())?;
        Some(Self { node, ..*self })
    }

    fn has_local_name(&self, name: &str) -> bool {
        self.is_answered() && self.node.tag_name().name() == name
    }

    fn attribute_matches(&self, name: &str, operator: AttributeOperator<'_>) -> bool {
        self.is_answered()
            && self
                .node
                .attribute(name)
                .is_some_and(|value| operator.matches(value))
    }

    fn pseudo_class_matches(&self, class: PseudoClass<'_>) -> bool {
        class == PseudoClass::FirstChild
            && self.is_answered()
            && self.node.prev_sibling_element().is_none()
    }
}
