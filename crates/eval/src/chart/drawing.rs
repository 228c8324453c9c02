use std::borrow::Cow;
use std::fmt::Write as _;

/// A color of CSS. As pixels only `#rrggbb` can be drawn.
pub type Color = Cow<'static, str>;

/// Which end of words stands at their place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// They begin there.
    Start,
    /// They have their middle there.
    Middle,
    /// They end there.
    End,
}

/// What a drawing is made of; places in px from the top left corner.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// Straight lines from point to point.
    Line {
        /// The points.
        points: Vec<[f64; 2]>,
        /// Its color.
        color: Color,
        /// How wide it is, px.
        width_px: f64,
        /// Lengths of dashes and gaps in turn, px; none of a solid line.
        dashes: &'static [f64],
    },
    /// A polygon.
    Area {
        /// Its corners.
        points: Vec<[f64; 2]>,
        /// Its color.
        color: Color,
        /// 0 to 1.
        opacity: f64,
    },
    /// A line of text.
    Words {
        /// Where, on the line that letters stand on.
        at: [f64; 2],
        /// The text.
        text: String,
        /// Size of the letters, px.
        size_px: f64,
        /// Which end is at `at`.
        anchor: Anchor,
        /// By how much it is turned about `at`, clockwise, degrees.
        turn_deg: f64,
        /// Its color.
        color: Color,
    },
}

/// Shapes on a sheet; the later lie over the earlier.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Drawing {
    /// Width and height, px.
    pub size_px: [f64; 2],
    /// The shapes.
    pub shapes: Vec<Shape>,
}

impl Drawing {
    /// Adds straight lines from point to point.
    pub fn line(
        &mut self,
        points: &[[f64; 2]],
        color: impl Into<Color>,
        width_px: f64,
        dashes: &'static [f64],
    ) {
        self.shapes.push(Shape::Line {
            points: points.to_vec(),
            color: color.into(),
            width_px,
            dashes,
        });
    }

    /// Adds a polygon.
    pub fn area(&mut self, points: &[[f64; 2]], color: impl Into<Color>, opacity: f64) {
        self.shapes.push(Shape::Area {
            points: points.to_vec(),
            color: color.into(),
            opacity,
        });
    }

    /// Adds a line of text.
    pub fn words(
        &mut self,
        at: [f64; 2],
        text: &str,
        (size_px, anchor, turn_deg): (f64, Anchor, f64),
        color: impl Into<Color>,
    ) {
        self.shapes.push(Shape::Words {
            at,
            text: text.to_owned(),
            size_px,
            anchor,
            turn_deg,
            color: color.into(),
        });
    }

    /// Adds another drawing with its top left corner at a place.
    pub fn put(&mut self, other: Self, [dx, dy]: [f64; 2]) {
        let moved = |[x, y]: [f64; 2]| [x + dx, y + dy];
        self.shapes
            .extend(other.shapes.into_iter().map(|mut shape| {
                match &mut shape {
                    Shape::Line { points, .. } | Shape::Area { points, .. } => {
                        points.iter_mut().for_each(|point| *point = moved(*point));
                    }
                    Shape::Words { at, .. } => *at = moved(*at),
                }
                shape
            }));
    }

    /// The drawing as a file of its own, on white.
    #[must_use]
    pub fn svg(&self) -> String {
        let [width, height] = self.size_px;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" \
             viewBox=\"0 0 {width:.0} {height:.0}\" font-family=\"DejaVu Sans, Verdana, Arial, sans-serif\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n{}</svg>\n",
            self.elements()
        )
    }

    /// Its elements, one a line.
    #[must_use]
    pub fn elements(&self) -> String {
        let mut text = String::new();
        for shape in &self.shapes {
            // Writing to a string cannot fail.
            let _ = match shape {
                Shape::Line {
                    points,
                    color,
                    width_px,
                    dashes,
                } => {
                    let dashes: Vec<String> = dashes.iter().map(ToString::to_string).collect();
                    let dashes = match dashes.is_empty() {
                        true => String::new(),
                        false => format!(" stroke-dasharray=\"{}\"", dashes.join(" ")),
                    };
                    writeln!(
                        text,
                        "<path d=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width_px}\"{dashes}/>",
                        path(points),
                    )
                }
                Shape::Area {
                    points,
                    color,
                    opacity,
                } => {
                    let opacity = match *opacity < 1.0 {
                        true => format!(" fill-opacity=\"{opacity}\""),
                        false => String::new(),
                    };
                    writeln!(
                        text,
                        "<path d=\"{}Z\" fill=\"{color}\"{opacity}/>",
                        path(points)
                    )
                }
                Shape::Words {
                    at: [x, y],
                    text: words,
                    size_px,
                    anchor,
                    turn_deg,
                    color,
                } => {
                    let [x, y] = [px(*x), px(*y)];
                    let anchor = match anchor {
                        Anchor::Start => "",
                        Anchor::Middle => " text-anchor=\"middle\"",
                        Anchor::End => " text-anchor=\"end\"",
                    };
                    let turn = match turn_deg.abs() > 0.0 {
                        true => format!(" transform=\"rotate({turn_deg} {x} {y})\""),
                        false => String::new(),
                    };
                    writeln!(
                        text,
                        "<text x=\"{x}\" y=\"{y}\" font-size=\"{size_px}\"{anchor}{turn} fill=\"{color}\">{}</text>",
                        escaped(words)
                    )
                }
            };
        }
        text
    }
}

fn path(points: &[[f64; 2]]) -> String {
    let places: Vec<String> = points
        .iter()
        .map(|[x, y]| format!("{} {}", px(*x), px(*y)))
        .collect();
    format!("M{}", places.join("L"))
}

/// A place to a hundredth of a px; what is no number is at the corner.
fn px(value: f64) -> f64 {
    match value.is_finite() {
        true => (value * 100.0).round() / 100.0 + 0.0,
        false => 0.0,
    }
}

/// Text between tags.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}
