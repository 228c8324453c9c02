use super::{Anchor, Axis, Color, Drawing};

/// Size of the words on axes, px.
const LETTER_PX: f64 = 13.0;

/// Width of a letter as a share of its size, of most fonts and names not below the true one.
const LETTER_WIDTH: f64 = 0.6;

/// Most letters of a mark.
const MAX_MARK_LETTERS: usize = 26;

/// What axes, marks and words are drawn in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Colors {
    /// Words.
    pub ink: &'static str,
    /// Words that matter less.
    pub soft: &'static str,
    /// The axes.
    pub axis: &'static str,
    /// Lines behind what is drawn.
    pub grid: &'static str,
}

/// Those of a file of its own.
pub const PAPER: Colors = Colors {
    ink: "#1a1d21",
    soft: "#565d66",
    axis: "#7b838c",
    grid: "#e4e7ea",
};

/// How a point looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    /// ●
    Circle,
    /// ◆
    Diamond,
    /// ■
    Square,
    /// ▲
    Triangle,
}

impl Marker {
    /// A letter that looks like it.
    #[must_use]
    pub fn letter(self) -> &'static str {
        match self {
            Self::Circle => "●",
            Self::Diamond => "◆",
            Self::Square => "■",
            Self::Triangle => "▲",
        }
    }

    /// Its corners around the middle: `(how many, radius in px, angle of the first in degrees)`.
    fn corners(self) -> (u32, f64, f64) {
        match self {
            Self::Circle => (24, 4.5, 0.0),
            Self::Diamond => (4, 5.6, 0.0),
            Self::Square => (4, 5.6, 45.0),
            Self::Triangle => (3, 5.6, -90.0),
        }
    }
}

/// A frame of two axes in which values are drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Plot {
    drawing: Drawing,
    colors: Colors,
    x: Axis,
    y: Axis,
    /// Left, top, right and bottom of what is within the axes, px.
    area: [f64; 4],
}

impl Plot {
    /// The axes with their marks and labels, and nothing in them yet.
    #[must_use]
    pub fn new([width, height]: [f64; 2], x: Axis, y: Axis, colors: Colors) -> Self {
        let longest = y.marks.iter().map(|(_, text)| width_px(&shortened(text)));
        let label_px = |axis: &Axis| if axis.label.is_empty() { 0.0 } else { 26.0 };
        let left = 12.0 + label_px(&y) + longest.fold(0.0, f64::max);
        let right = width - 24.0;
        let [top, bottom] = [12.0, height - 30.0 - label_px(&x)];
        let mut plot = Self {
            drawing: Drawing {
                size_px: [width, height],
                shapes: Vec::new(),
            },
            colors,
            area: [left, top, right, bottom],
            x,
            y,
        };
        plot.draw_axes();
        plot
    }

    fn draw_axes(&mut self) {
        let [left, top, right, bottom] = self.area;
        let Colors {
            ink, axis, grid, ..
        } = self.colors;
        let [x_marks, y_marks] = [self.x.marks.clone(), self.y.marks.clone()];
        let drawing = &mut self.drawing;
        for (value, text) in &x_marks {
            let x = left + self.x.share(*value) * (right - left);
            drawing.line(&[[x, top], [x, bottom]], grid, 1.0, &[]);
            drawing.line(&[[x, bottom], [x, bottom + 5.0]], axis, 1.0, &[]);
            let style = (LETTER_PX, Anchor::Middle, 0.0);
            drawing.words([x, bottom + 20.0], &shortened(text), style, ink);
        }
        for (value, text) in &y_marks {
            let y = bottom - self.y.share(*value) * (bottom - top);
            drawing.line(&[[left, y], [right, y]], grid, 1.0, &[]);
            drawing.line(&[[left - 5.0, y], [left, y]], axis, 1.0, &[]);
            let style = (LETTER_PX, Anchor::End, 0.0);
            drawing.words([left - 9.0, y + 4.5], &shortened(text), style, ink);
        }
        let corners = [[left, top], [left, bottom], [right, bottom]];
        drawing.line(&corners, axis, 1.0, &[]);
        let middle = [0.5 * (left + right), 0.5 * (top + bottom)];
        for (label, at, turn_deg) in [
            (&self.x.label, [middle[0], bottom + 44.0], 0.0),
            (&self.y.label, [16.0, middle[1]], -90.0),
        ] {
            if !label.is_empty() {
                drawing.words(at, label, (LETTER_PX + 1.0, Anchor::Middle, turn_deg), ink);
            }
        }
    }

    /// Where two values are, px.
    #[must_use]
    pub fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [left, top, right, bottom] = self.area;
        [
            left + self.x.share(x) * (right - left),
            bottom - self.y.share(y) * (bottom - top),
        ]
    }

    /// Where the row of the name `k` is, on a y axis of names.
    #[must_use]
    pub fn row(&self, k: usize) -> f64 {
        self.y.marks.get(k).map_or(0.0, |(at, _)| *at)
    }

    /// A line from value to value.
    pub fn line(
        &mut self,
        values: &[[f64; 2]],
        color: impl Into<Color>,
        width_px: f64,
        dashes: &'static [f64],
    ) {
        let points: Vec<[f64; 2]> = values.iter().map(|value| self.at(*value)).collect();
        self.drawing.line(&points, color, width_px, dashes);
    }

    /// A polygon with corners at values.
    pub fn area(&mut self, values: &[[f64; 2]], color: impl Into<Color>, opacity: f64) {
        let points: Vec<[f64; 2]> = values.iter().map(|value| self.at(*value)).collect();
        self.drawing.area(&points, color, opacity);
    }

    /// A rectangle from one pair of values to another.
    pub fn bar(
        &mut self,
        [x0, y0]: [f64; 2],
        [x1, y1]: [f64; 2],
        color: &'static str,
        opacity: f64,
    ) {
        self.area(&[[x0, y0], [x1, y0], [x1, y1], [x0, y1]], color, opacity);
    }

    /// A point.
    pub fn marker(&mut self, value: [f64; 2], marker: Marker, color: &'static str) {
        let [x, y] = self.at(value);
        let (n, radius, first_deg) = marker.corners();
        let corner = |k: u32| {
            let angle = (first_deg + 360.0 * f64::from(k) / f64::from(n)).to_radians();
            [x + radius * libm::cos(angle), y + radius * libm::sin(angle)]
        };
        let corners: Vec<[f64; 2]> = (0..n).map(corner).collect();
        self.drawing.area(&corners, color, 1.0);
    }

    /// A line between two values with a stroke across each end: an interval.
    pub fn interval(&mut self, ends: [[f64; 2]; 2], color: &'static str) {
        let ends = ends.map(|end| self.at(end));
        self.drawing.line(&ends, color, 1.5, &[]);
        let is_upright = (ends[0][0] - ends[1][0]).abs() < 1e-9;
        let [dx, dy] = if is_upright { [4.0, 0.0] } else { [0.0, 4.0] };
        for [x, y] in ends {
            let across = [[x - dx, y - dy], [x + dx, y + dy]];
            self.drawing.line(&across, color, 1.5, &[]);
        }
    }

    /// Words in the row at the top, beside a value of the x axis.
    pub fn note(&mut self, x: f64, text: &str, anchor: Anchor, is_soft: bool) {
        let [x, _] = self.at([x, self.y.ends[1]]);
        let (size, color) = match is_soft {
            true => (11.0, self.colors.soft),
            false => (12.0, self.colors.ink),
        };
        let shift = match anchor {
            Anchor::Start => 6.0,
            Anchor::Middle => 0.0,
            Anchor::End => -6.0,
        };
        let at = [x + shift, self.area[1] + 12.0];
        self.drawing.words(at, text, (size, anchor, 0.0), color);
    }

    /// What was drawn.
    #[must_use]
    pub fn finish(self) -> Drawing {
        self.drawing
    }
}

fn width_px(text: &str) -> f64 {
    LETTER_PX * LETTER_WIDTH * f64::from(u32::try_from(text.chars().count()).unwrap_or(u32::MAX))
}

/// A mark as it is drawn: names are cut.
fn shortened(text: &str) -> String {
    if text.chars().count() <= MAX_MARK_LETTERS {
        return text.to_owned();
    }
    let kept = text.chars().take(MAX_MARK_LETTERS - 1);
    kept.chain(['…']).collect()
}
