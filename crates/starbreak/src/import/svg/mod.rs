//! Drawings in SVG to networks.

mod clip;
mod label;
mod limits;
mod outline;
mod shape;
mod style;
mod transform;
mod walk;

use roxmltree::{Document, Node, ParsingOptions};
use starbreak_fracture::traced;
use starbreak_glass::{CrackNetwork, LengthUnit, Pane};
use svgtypes::{Length, LengthUnit as SvgUnit};

use crate::ImportError;
use transform::Affine;
use walk::{Around, Walk, aspect_ratio, mm_per, px, svg_name, view_box};

/// Most nodes of the XML: elements, texts and comments.
const MAX_XML_NODES: u32 = 4_000_000;

/// The network that an SVG drawing shows.
///
/// **What counts.** Every visible `path`, `polyline`, `polygon`, `line`, `circle` and `ellipse`
/// with a stroke is a crack along its outline; a fill alone, a `rect`, text and images are not.
/// Groups, nested `svg`, `use`, `symbol`, `switch`, transforms, view boxes, percentages, style
/// sheets, `display`, `visibility` and clip paths are resolved [SVG2018]; masks, filters, markers,
/// dashes and opacity change nothing.
///
/// **Kinds.** The first of `inkscape:label`, `id`, `data-name` and `class` that names a
/// [`SegmentKind`](starbreak_glass::SegmentKind) decides, of the element or else of the nearest
/// group around it; numbers at the end are passed over (`ring-2`). Without one it is `radial`. A
/// circle or an ellipse named `impact` is an impact, stroked or not.
///
/// **Unit and pane.** A page with its width in mm, cm, in, pt or pc makes a network in mm, any
/// other one in px (96 per inch); the page is the pane, and what leaves it is cut off.
///
/// Curves become chords that stay within 0.02 px or mm. Where lines cross or touch they get a
/// common node: see [`traced::network`].
///
/// # Errors
/// [`ImportError`], with the line where there is one.
///
/// # Limits
/// 256 attributes of an element, 2²⁴ bytes out of entities, 10⁶ elements (`use` expanded), 64 levels, 2²⁰ points and as many contacts, 2¹⁷ bytes of style sheets and 2·10⁷
/// questions of their rules, 10⁸ pairs of line and clip edge. Lengths in em and ex, clip paths by bounding box,
/// CSS shapes and `transform-origin` are refused.
pub(super) fn network(text: &str) -> Result<CrackNetwork, ImportError> {
    limits::check(text)?;
    let options = ParsingOptions {
        // Illustrator keeps its namespaces there.
        allow_dtd: true,
        nodes_limit: MAX_XML_NODES,
        ..ParsingOptions::default()
    };
    let document =
        Document::parse_with_options(text, options).map_err(|error| ImportError::Xml {
            cause: one_line(&error.to_string()),
        })?;
    let root = document.root_element();
    if svg_name(root) != "svg" {
        return Err(ImportError::Root {
            root: one_line(root.tag_name().name()),
        });
    }
    let page = Page::of(&document, root)?;
    let [width, height] = page.size;
    let pane = Pane {
        width,
        height,
        thickness_mm: None,
        kind: None,
    };
    pane.check().map_err(|error| ImportError::Size {
        what: error.to_string(),
    })?;
    let mut walk = Walk::new(&document, page.size)?;
    walk.root(root, &Around::page(page.to_page, page.viewport))?;
    if walk.traces.is_empty() && walk.impacts.is_empty() {
        return Err(ImportError::NoCracks);
    }
    Ok(traced::network(
        &pane,
        page.unit,
        &walk.impacts,
        &walk.traces,
    )?)
}

/// The root's viewport.
struct Page {
    size: [f64; 2],
    unit: LengthUnit,
    to_page: Affine,
    viewport: [f64; 2],
}

impl Page {
    fn of(document: &Document<'_>, root: Node<'_, '_>) -> Result<Self, ImportError> {
        let view = view_box(document, root)?;
        let side = |name: &str| -> Result<Option<Length>, ImportError> {
            let Some(text) = root.attribute(name).filter(|text| *text != "auto") else {
                return Ok(None);
            };
            let length: Option<Length> = text.trim().parse().ok();
            match length {
                Some(length) if length.unit == SvgUnit::Percent => Ok(None),
                Some(length) if px(length).is_some() => Ok(Some(length)),
                _ => Err(ImportError::Size {
                    what: format!("{name} = {}", one_line(text)),
                }),
            }
        };
        let sides = [side("width")?, side("height")?];
        let is_paper = |length: &Length| mm_per(length.unit).is_some();
        let is_mm = sides.iter().flatten().any(is_paper);
        if is_mm && !sides.iter().flatten().all(is_paper) {
            return Err(ImportError::Size {
                what: "width and height are in different kinds of units".to_owned(),
            });
        }
        let measure = |length: Length| {
            let per_unit = if is_mm {
                mm_per(length.unit)
            } else {
                Some(1.0)
            };
            length.number * per_unit.unwrap_or(1.0)
        };
        let size = match (sides.map(|side| side.map(measure)), &view) {
            ([Some(width), Some(height)], _) => [width, height],
            ([Some(width), None], Some(view)) => [width, width * view.h / view.w],
            ([None, Some(height)], Some(view)) => [height * view.w / view.h, height],
            ([None, None], Some(view)) => [view.w, view.h],
            _ => {
                return Err(ImportError::Size {
                    what: "width or height is missing, and there is no viewBox".to_owned(),
                });
            }
        };
        let (unit, per_px) = if is_mm {
            (LengthUnit::Mm, 25.4 / 96.0)
        } else {
            (LengthUnit::Px, 1.0)
        };
        let (to_page, viewport) = match &view {
            Some(view) => (
                Affine::of_view_box(view, size, aspect_ratio(root)),
                [view.w, view.h],
            ),
            None => (
                Affine::scale(per_px, per_px),
                size.map(|side| side / per_px),
            ),
        };
        Ok(Self {
            size,
            unit,
            to_page,
            viewport,
        })
    }
}

/// The text without line breaks and other control characters.
fn one_line(text: &str) -> String {
    text.chars()
        .map(|c| {
            let is_break = c.is_control() || matches!(c, '\u{2028}' | '\u{2029}');
            if is_break { ' ' } else { c }
        })
        .take(400)
        .collect()
}
