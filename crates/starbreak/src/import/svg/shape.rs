//! Outlines of single shapes, and the regions that clip them.

use roxmltree::Node;
use svgtypes::{FuncIRI, NumberListParser};

use super::clip::{Region, Shape};
use super::outline::{MAX_POINTS, OutOfPoints, Outline};
use super::style::Declared;
use super::transform::Affine;
use super::walk::{Around, Walk, href, svg_name};
use crate::ImportError;

/// Corners that a drawing cannot have: far off any page.
const FAR: f64 = 1e15;

impl<'a, 'input> Walk<'a, 'input> {
    pub(super) fn check_points(
        &self,
        node: Node<'_, '_>,
        points: &[[f64; 2]],
    ) -> Result<(), ImportError> {
        let is_there = |value: &f64| value.abs() <= FAR;
        if points.iter().flatten().all(is_there) {
            return Ok(());
        }
        let what = "has a point that is not a number or far off the page; draw it again";
        Err(self.wrong(node, what.to_owned()))
    }

    /// Middle and radii of a circle or an ellipse.
    pub(super) fn round(
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
    pub(super) fn outline(
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
    pub(super) fn clip_path(
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
                let Some(&used) = self.ids.get(href(child).trim_start_matches('#')) else {
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
}
