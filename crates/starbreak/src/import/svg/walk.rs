//! The elements of a drawing, one after the other.

use std::collections::BTreeMap;
use std::rc::Rc;

use roxmltree::{Document, Node};
use starbreak_fracture::traced::Trace;
use starbreak_glass::SegmentKind;
use svgtypes::{AspectRatio, FuncIRI, Length, LengthUnit, NumberListParser, ViewBox};

use super::clip::{MAX_PAIRS, Region, Shape, clipped, is_inside};
use super::one_line;
use super::outline::{MAX_POINTS, OutOfPoints, Outline};
use super::style::{Declared, MAX_QUESTIONS, Styles};
use super::transform::Affine;
use crate::ImportError;

/// Deepest nesting of elements, `<use>` included.
pub(super) const MAX_DEPTH: usize = 64;

/// Most elements, each `<use>` counted with what it draws.
pub(super) const MAX_ELEMENTS: u32 = 1_000_000;

/// Corners that a drawing cannot have: far off any page.
const FAR: f64 = 1e15;

const SVG: &str = "http://www.w3.org/2000/svg";
const XLINK: &str = "http://www.w3.org/1999/xlink";
const INKSCAPE: &str = "http://www.inkscape.org/namespaces/inkscape";

/// What an element is said to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Label {
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
    fn of_element(node: Node<'_, '_>) -> Option<Self> {
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
    styles: Styles<'a>,
    ids: BTreeMap<&'a str, Node<'a, 'input>>,
    page: [f64; 2],
    points_left: usize,
    elements_left: u32,
    pairs_left: u64,
    pub(super) traces: Vec<Trace>,
    pub(super) impacts: Vec<[f64; 2]>,
}

impl<'a, 'input> Walk<'a, 'input> {
    pub(super) fn new(document: &'a Document<'input>, page: [f64; 2]) -> Self {
        let mut ids = BTreeMap::new();
        for node in document.descendants() {
            if let Some(id) = node.attribute("id") {
                ids.entry(id).or_insert(node);
            }
        }
        Self {
            document,
            styles: Styles::of(document),
            ids,
            page,
            points_left: MAX_POINTS,
            elements_left: MAX_ELEMENTS,
            pairs_left: MAX_PAIRS,
            traces: Vec::new(),
            impacts: Vec::new(),
        }
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
        let href = node
            .attribute("href")
            .or_else(|| node.attribute((XLINK, "href")))
            .unwrap_or_default();
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

    fn place(&self, node: Node<'_, '_>, around: &Around) -> Result<[f64; 2], ImportError> {
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

    fn check_points(&self, node: Node<'_, '_>, points: &[[f64; 2]]) -> Result<(), ImportError> {
        let is_there = |value: &f64| value.abs() <= FAR;
        if points.iter().flatten().all(is_there) {
            return Ok(());
        }
        let what = "has a point that is not a number or far off the page; draw it again";
        Err(self.wrong(node, what.to_owned()))
    }

    /// Middle and radii of a circle or an ellipse.
    fn round(
        &self,
        node: Node<'_, '_>,
        around: &Around,
    ) -> Result<([f64; 2], [f64; 2]), ImportError> {
        let [width, height] = around.viewport;
        let center = [
            self.length(node, "cx", width)?.unwrap_or(0.0),
            self.length(node, "cy", height)?.unwrap_or(0.0),
        ];
        let radii = if svg_name(node) == "circle" {
            let diagonal = ((width * width + height * height) * 0.5).sqrt();
            [self.length(node, "r", diagonal)?.unwrap_or(0.0); 2]
        } else {
            let (rx, ry) = (
                self.length(node, "rx", width)?,
                self.length(node, "ry", height)?,
            );
            [rx.or(ry).unwrap_or(0.0), ry.or(rx).unwrap_or(0.0)]
        };
        Ok((center, radii))
    }

    /// The polylines of a shape on the page.
    fn outline(
        &mut self,
        node: Node<'_, '_>,
        around: &Around,
    ) -> Result<Vec<Vec<[f64; 2]>>, ImportError> {
        let [width, height] = around.viewport;
        let mut points_left = self.points_left;
        let mut outline = Outline::new(&around.to_page, &mut points_left);
        let drawn: Result<(), OutOfPoints> = match svg_name(node) {
            "path" => {
                let text = node.attribute("d").unwrap_or_default();
                match outline.path(text) {
                    Ok(Err(error)) => {
                        return Err(self.wrong(node, format!("d: {error}; draw the path again")));
                    }
                    Ok(Ok(())) => Ok(()),
                    Err(error) => Err(error),
                }
            }
            "line" => {
                let at = |name, whole| -> Result<f64, ImportError> {
                    Ok(self.length(node, name, whole)?.unwrap_or(0.0))
                };
                let (from, to) = (
                    [at("x1", width)?, at("y1", height)?],
                    [at("x2", width)?, at("y2", height)?],
                );
                outline.move_to(from);
                outline.line_to(to)
            }
            "polyline" | "polygon" => {
                let text = node.attribute("points").unwrap_or_default();
                let numbers: Result<Vec<f64>, _> = NumberListParser::from(text).collect();
                let numbers = numbers
                    .map_err(|error| self.wrong(node, format!("points: {error}; draw it again")))?;
                if numbers.len() % 2 != 0 {
                    let what = format!(
                        "points has {} numbers; expected pairs of x and y",
                        numbers.len()
                    );
                    return Err(self.wrong(node, what));
                }
                let mut points = numbers.chunks_exact(2).map(|pair| [pair[0], pair[1]]);
                if let Some(first) = points.next() {
                    outline.move_to(first);
                }
                let lines = points.try_for_each(|point| outline.line_to(point));
                if svg_name(node) == "polygon" {
                    lines.and_then(|()| outline.close())
                } else {
                    lines
                }
            }
            "circle" | "ellipse" => {
                let (center, radii) = self.round(node, around)?;
                if radii.iter().all(|radius| *radius > 0.0) {
                    outline.ellipse(center, radii)
                } else {
                    Ok(())
                }
            }
            "rect" => {
                let [x, y] = self.place(node, around)?;
                let size = [
                    self.length(node, "width", width)?.unwrap_or(0.0),
                    self.length(node, "height", height)?.unwrap_or(0.0),
                ];
                let (rx, ry) = (
                    self.length(node, "rx", width)?,
                    self.length(node, "ry", height)?,
                );
                let radii = [rx.or(ry), ry.or(rx)].map(|radius| radius.unwrap_or(0.0).max(0.0));
                let radii = [0, 1].map(|k| radii[k].min(0.5 * size[k]));
                if size.iter().all(|side| *side > 0.0) {
                    outline.rectangle([x, y], size, radii)
                } else {
                    Ok(())
                }
            }
            _ => Ok(()),
        };
        let lines = outline.lines;
        self.points_left = points_left;
        drawn.map_err(|OutOfPoints| ImportError::TooMuch {
            what: "points",
            limit: MAX_POINTS as u64,
        })?;
        Ok(lines)
    }

    /// The region of a `clip-path`, if there is one.
    fn clip_path(
        &mut self,
        node: Node<'a, 'input>,
        declared: &Declared<'_>,
        around: &Around,
    ) -> Result<Option<Region>, ImportError> {
        let Some(text) = declared.get("clip-path").filter(|text| *text != "none") else {
            return Ok(None);
        };
        let Ok(FuncIRI(id)) = FuncIRI::from_str(text) else {
            let what = format!("clip-path = {text:?}; only url(#…) is read: release the clip");
            return Err(self.wrong(node, what));
        };
        let Some(&path) = self
            .ids
            .get(id)
            .filter(|path| svg_name(**path) == "clipPath")
        else {
            return Ok(None);
        };
        if path.attribute("clipPathUnits") == Some("objectBoundingBox") {
            let what = "is measured by the box of what it clips; release the clip";
            return Err(self.wrong(path, what.to_owned()));
        }
        let declared = self.styles.of_element(path).unwrap_or_default();
        let mut outer = around.clone();
        outer.to_page = around.to_page.after(&self.transform(path, &declared)?);
        let mut region = Region::default();
        for child in path.children().filter(Node::is_element) {
            let (mut inner, mut target) = (outer.clone(), child);
            let declared = self.styles.of_element(child).unwrap_or_default();
            inner.to_page = inner.to_page.after(&self.transform(child, &declared)?);
            if svg_name(child) == "use" {
                let href = child
                    .attribute("href")
                    .or_else(|| child.attribute((XLINK, "href")))
                    .unwrap_or_default();
                let Some(&used) = self.ids.get(href.trim_start_matches('#')) else {
                    continue;
                };
                let [x, y] = self.place(child, &inner)?;
                inner.to_page = inner.to_page.after(&Affine::translate(x, y));
                let declared = self.styles.of_element(used).unwrap_or_default();
                inner.to_page = inner.to_page.after(&self.transform(used, &declared)?);
                target = used;
            }
            match svg_name(target) {
                "path" | "polyline" | "polygon" | "circle" | "ellipse" | "rect" => {}
                "title" | "desc" | "line" | "" => continue,
                other => {
                    let what = format!("<{other}> in a clip path is not read; release the clip");
                    return Err(self.wrong(path, what));
                }
            }
            let rings = self.outline(target, &inner)?;
            for ring in &rings {
                self.check_points(target, ring)?;
            }
            let rule = target
                .attribute("clip-rule")
                .or_else(|| child.attribute("clip-rule"));
            region.shapes.push(Shape {
                rings,
                is_even_odd: rule == Some("evenodd"),
            });
        }
        Ok(Some(region))
    }

    fn transform(
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
    fn length(
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

    fn wrong(&self, node: Node<'_, '_>, what: String) -> ImportError {
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
