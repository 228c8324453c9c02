//! The elements of a drawing, one after the other.

use std::collections::BTreeMap;
use std::rc::Rc;

use roxmltree::{Document, Node};
use starbreak_fracture::traced::Trace;
use starbreak_glass::SegmentKind;
use svgtypes::{AspectRatio, Length, LengthUnit, ViewBox};

use super::clip::{MAX_PAIRS, Region, Shape, clipped, is_inside};
use super::label::Label;
use super::one_line;
use super::outline::MAX_POINTS;
use super::style::{Declared, MAX_QUESTIONS, Styles};
use super::transform::Affine;
use crate::ImportError;

/// Deepest nesting of elements, `<use>` included.
pub(super) const MAX_DEPTH: usize = 64;

/// Most elements, each `<use>` counted with what it draws.
pub(super) const MAX_ELEMENTS: u32 = 1_000_000;

const SVG: &str = "http://www.w3.org/2000/svg";

/// What an element has from those around it.
#[derive(Clone)]
pub(super) struct Around {
    pub(super) to_page: Affine,
    /// What percentages are of, in user units.
    pub(super) viewport: [f64; 2],
    is_stroked: bool,
    has_width: bool,
    is_visible: bool,
    label: Option<Label>,
    clips: Vec<Rc<Region>>,
    depth: usize,
}

impl Around {
    pub(super) fn page(to_page: Affine, viewport: [f64; 2]) -> Self {
        Self {
            to_page,
            viewport,
            is_stroked: false,
            has_width: true,
            is_visible: true,
            label: None,
            clips: Vec::new(),
            depth: 0,
        }
    }

    fn inherit(&mut self, declared: &Declared<'_>) {
        match declared.get("stroke") {
            None | Some("inherit") => {}
            Some(paint) => self.is_stroked = !matches!(paint, "none" | "transparent"),
        }
        if let Some(Ok(width)) = declared.get("stroke-width").map(str::parse::<Length>) {
            self.has_width = width.number > 0.0;
        }
        match declared.get("visibility") {
            Some("visible") => self.is_visible = true,
            Some("hidden" | "collapse") => self.is_visible = false,
            _ => {}
        }
    }
}

/// What has been found, and what is still allowed.
pub(super) struct Walk<'a, 'input> {
    document: &'a Document<'input>,
    pub(super) styles: Styles<'a>,
    pub(super) ids: BTreeMap<&'a str, Node<'a, 'input>>,
    page: [f64; 2],
    pub(super) points_left: usize,
    elements_left: u32,
    pairs_left: u64,
    pub(super) traces: Vec<Trace>,
    pub(super) impacts: Vec<[f64; 2]>,
}

impl<'a, 'input> Walk<'a, 'input> {
    pub(super) fn new(document: &'a Document<'input>, page: [f64; 2]) -> Result<Self, ImportError> {
        let mut ids = BTreeMap::new();
        for node in document.descendants() {
            if let Some(id) = node.attribute("id") {
                ids.entry(id).or_insert(node);
            }
        }
        Ok(Self {
            document,
            styles: Styles::of(document)?,
            ids,
            page,
            points_left: MAX_POINTS,
            elements_left: MAX_ELEMENTS,
            pairs_left: MAX_PAIRS,
            traces: Vec::new(),
            impacts: Vec::new(),
        })
    }

    /// What the root shows.
    pub(super) fn root(
        &mut self,
        root: Node<'a, 'input>,
        page: &Around,
    ) -> Result<(), ImportError> {
        let declared = self.styles.of_element(root).unwrap_or_default();
        if declared.get("display") == Some("none") {
            return Ok(());
        }
        if declared.get("transform").is_some_and(|text| text != "none") {
            let what =
                "a transform of the whole drawing is not read; apply it to a group in the editor";
            return Err(self.wrong(root, what.to_owned()));
        }
        let mut around = page.clone();
        around.inherit(&declared);
        around.label = Label::of_element(root);
        self.children(root, &around)
    }

    fn children(&mut self, node: Node<'a, 'input>, around: &Around) -> Result<(), ImportError> {
        for child in node.children().filter(Node::is_element) {
            self.element(child, around)?;
        }
        Ok(())
    }

    fn element(&mut self, node: Node<'a, 'input>, around: &Around) -> Result<(), ImportError> {
        let name = svg_name(node);
        if !matches!(
            name,
            "svg"
                | "g"
                | "a"
                | "switch"
                | "use"
                | "path"
                | "polyline"
                | "polygon"
                | "line"
                | "circle"
                | "ellipse"
        ) {
            return Ok(());
        }
        self.elements_left = self
            .elements_left
            .checked_sub(1)
            .ok_or(ImportError::TooMuch {
                what: "elements",
                limit: u64::from(MAX_ELEMENTS),
            })?;
        if around.depth >= MAX_DEPTH {
            let what = format!("is nested deeper than {MAX_DEPTH} levels; ungroup the drawing");
            return Err(self.wrong(node, what));
        }
        let declared = self.styles.of_element(node).ok_or(ImportError::TooMuch {
            what: "questions of style rules; remove <style>",
            limit: MAX_QUESTIONS,
        })?;
        if declared.get("display") == Some("none") {
            return Ok(());
        }
        let mut own = around.clone();
        own.depth += 1;
        own.inherit(&declared);
        own.label = Label::of_element(node).or(around.label);
        let transform = self.transform(node, &declared)?;
        own.to_page = around.to_page.after(&transform);
        if let Some(clip) = self.clip_path(node, &declared, &own)? {
            own.clips.push(Rc::new(clip));
        }
        match name {
            "g" | "a" => self.children(node, &own),
            "switch" => self.switch(node, &own),
            "svg" => {
                let place = self.place(node, &own)?;
                let size = self.size(node, &own)?;
                self.viewport(node, place, size, &own)
            }
            "use" => self.used(node, &own),
            _ => self.shape(node, &own),
        }
    }

    /// The first child that every program can show.
    fn switch(&mut self, node: Node<'a, 'input>, around: &Around) -> Result<(), ImportError> {
        let is_shown = |child: &Node<'_, '_>| {
            child.is_element()
                && svg_name(*child) != "foreignObject"
                && child.attribute("requiredExtensions").is_none()
        };
        match node.children().find(is_shown) {
            Some(child) => self.element(child, around),
            None => Ok(()),
        }
    }

    fn used(&mut self, node: Node<'a, 'input>, around: &Around) -> Result<(), ImportError> {
        let href = href(node);
        let Some(id) = href.strip_prefix('#') else {
            let what = format!("refers to {href:?}, not to a part of this drawing; paste it in");
            return Err(self.wrong(node, what));
        };
        let Some(&target) = self.ids.get(id) else {
            return Ok(());
        };
        let place = self.place(node, around)?;
        if svg_name(target) == "symbol" {
            let size = self.size(node, around)?;
            return self.viewport(target, place, size, around);
        }
        let mut moved = around.clone();
        moved.to_page = around.to_page.after(&Affine::translate(place[0], place[1]));
        self.element(target, &moved)
    }

    pub(super) fn place(
        &self,
        node: Node<'_, '_>,
        around: &Around,
    ) -> Result<[f64; 2], ImportError> {
        let [width, height] = around.viewport;
        Ok([
            self.length(node, "x", width)?.unwrap_or(0.0),
            self.length(node, "y", height)?.unwrap_or(0.0),
        ])
    }

    fn size(&self, node: Node<'_, '_>, around: &Around) -> Result<[f64; 2], ImportError> {
        let [width, height] = around.viewport;
        Ok([
            self.length(node, "width", width)?.unwrap_or(width),
            self.length(node, "height", height)?.unwrap_or(height),
        ])
    }

    /// What a nested `<svg>` or a `<symbol>` shows.
    fn viewport(
        &mut self,
        node: Node<'a, 'input>,
        [x, y]: [f64; 2],
        size: [f64; 2],
        around: &Around,
    ) -> Result<(), ImportError> {
        let [width, height] = size;
        if !(width > 0.0 && height > 0.0) {
            return Ok(());
        }
        let mut inner = around.clone();
        inner.to_page = around.to_page.after(&Affine::translate(x, y));
        if !matches!(node.attribute("overflow"), Some("visible" | "auto")) {
            let corners = [[0.0, 0.0], [width, 0.0], size, [0.0, height]];
            let ring = corners.map(|corner| inner.to_page.point(corner)).to_vec();
            inner.clips.push(Rc::new(Region {
                shapes: vec![Shape {
                    rings: vec![ring],
                    is_even_odd: false,
                }],
            }));
        }
        inner.viewport = size;
        if let Some(view) = view_box(self.document, node)? {
            let fit = aspect_ratio(node);
            inner.to_page = inner.to_page.after(&Affine::of_view_box(&view, size, fit));
            inner.viewport = [view.w, view.h];
        }
        self.children(node, &inner)
    }

    fn shape(&mut self, node: Node<'a, 'input>, around: &Around) -> Result<(), ImportError> {
        let name = svg_name(node);
        if !around.is_visible {
            return Ok(());
        }
        let is_round = matches!(name, "circle" | "ellipse");
        if around.label == Some(Label::Impact) && is_round {
            let ([x, y], _) = self.round(node, around)?;
            let center = around.to_page.point([x, y]);
            self.check_points(node, &[center])?;
            if is_inside(center, self.page, around.clips.iter().map(Rc::as_ref)) {
                self.impacts.push(center);
            }
            return Ok(());
        }
        if !(around.is_stroked && around.has_width) {
            return Ok(());
        }
        let kind = match around.label {
            None => SegmentKind::Radial,
            Some(Label::Crack(kind)) => kind,
            Some(Label::Impact) => {
                let what =
                    "is named impact, which is a circle or an ellipse; rename it, or draw a circle";
                return Err(self.wrong(node, what.to_owned()));
            }
        };
        let lines = self.outline(node, around)?;
        let regions: Vec<&Region> = around.clips.iter().map(Rc::as_ref).collect();
        for line in lines {
            self.check_points(node, &line)?;
            let parts = clipped(&line, self.page, &regions, &mut self.pairs_left).ok_or(
                ImportError::TooMuch {
                    what: "pairs of a line and an edge of a clip path",
                    limit: MAX_PAIRS,
                },
            )?;
            self.traces
                .extend(parts.into_iter().map(|points| Trace { points, kind }));
        }
        Ok(())
    }

    pub(super) fn transform(
        &self,
        node: Node<'_, '_>,
        declared: &Declared<'_>,
    ) -> Result<Affine, ImportError> {
        let Some(text) = declared.get("transform").filter(|text| *text != "none") else {
            return Ok(Affine::IDENTITY);
        };
        if declared.get("transform-origin").is_some() {
            let what =
                "has a transform-origin, which is not read; apply the transform in the editor";
            return Err(self.wrong(node, what.to_owned()));
        }
        Affine::parse(text).map_err(|error| {
            self.wrong(
                node,
                format!("transform = {text:?}: {error}; apply it in the editor"),
            )
        })
    }

    /// A length in user units.
    pub(super) fn length(
        &self,
        node: Node<'_, '_>,
        name: &str,
        whole: f64,
    ) -> Result<Option<f64>, ImportError> {
        let Some(text) = node.attribute(name).filter(|text| *text != "auto") else {
            return Ok(None);
        };
        let length: Option<Length> = text.trim().parse().ok();
        let value = length.and_then(|length| match length.unit {
            LengthUnit::Percent => Some(length.number * 0.01 * whole),
            _ => px(length),
        });
        match value {
            Some(value) if value.is_finite() => Ok(Some(value)),
            _ => {
                let what = format!(
                    "{name} = {text:?}; expected a number, with px, mm, cm, in, pt, pc or % after it"
                );
                Err(self.wrong(node, what))
            }
        }
    }

    pub(super) fn wrong(&self, node: Node<'_, '_>, what: String) -> ImportError {
        wrong(self.document, node, &what)
    }
}

fn wrong(document: &Document<'_>, node: Node<'_, '_>, what: &str) -> ImportError {
    ImportError::Element {
        line: document.text_pos_at(node.range().start).row,
        element: one_line(node.tag_name().name()),
        what: one_line(what),
    }
}

pub(super) fn view_box(
    document: &Document<'_>,
    node: Node<'_, '_>,
) -> Result<Option<ViewBox>, ImportError> {
    let Some(text) = node.attribute("viewBox") else {
        return Ok(None);
    };
    text.parse().map(Some).map_err(|_| {
        let what = format!("viewBox = {text:?}; expected x, y, and width and height > 0");
        wrong(document, node, &what)
    })
}

/// CSS pixels of a length that needs no font and no viewport: 96 per inch.
pub(super) fn px(length: Length) -> Option<f64> {
    let per_unit = match length.unit {
        LengthUnit::None | LengthUnit::Px => 1.0,
        _ => mm_per(length.unit)? * 96.0 / 25.4,
    };
    Some(length.number * per_unit)
}

/// Millimetres of a unit of paper.
pub(super) fn mm_per(unit: LengthUnit) -> Option<f64> {
    match unit {
        LengthUnit::Mm => Some(1.0),
        LengthUnit::Cm => Some(10.0),
        LengthUnit::In => Some(25.4),
        LengthUnit::Pt => Some(25.4 / 72.0),
        LengthUnit::Pc => Some(25.4 / 6.0),
        _ => None,
    }
}

pub(super) fn aspect_ratio(node: Node<'_, '_>) -> AspectRatio {
    node.attribute("preserveAspectRatio")
        .and_then(|text| text.parse().ok())
        .unwrap_or_default()
}

/// The name of an element of SVG, else nothing.
pub(super) fn svg_name<'a>(node: Node<'a, '_>) -> &'a str {
    match node.tag_name().namespace() {
        None | Some(SVG) => node.tag_name().name(),
        _ => "",
    }
}

/// Where a `<use>` points.
pub(super) fn href<'a>(node: Node<'a, '_>) -> &'a str {
    const XLINK: &str = "http://www.w3.org/1999/xlink";
    node.attribute("href")
        .or_else(|| node.attribute((XLINK, "href")))
        .unwrap_or_default()
}
