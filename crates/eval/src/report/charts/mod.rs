//! Charts as SVG that stands inside the page: colors and letters come from its style sheet, so that
//! light, dark and paper each get their own.

mod curves;
mod rows;

use serde::Serialize;

use crate::chart::{Colors, Plot, escaped};

pub(super) use curves::{Curve, CurvePoint, CurveStyle, Mark, curve_chart};
pub(super) use rows::{RowSeries, row_chart};

/// Width of a chart, px of its own; it shrinks with the page.
const WIDTH: f64 = 680.0;

/// The colors of the page.
const PAGE: Colors = Colors {
    ink: "var(--ink)",
    soft: "var(--soft)",
    axis: "var(--axis)",
    grid: "var(--grid)",
};

/// What a chart says about itself, for those who do not see it.
pub(super) struct ChartText<'a> {
    /// Its id, which no other chart of the page has.
    pub(super) id: &'a str,
    /// One line.
    pub(super) title: &'a str,
    /// What is to be seen in it.
    pub(super) description: &'a str,
}

/// A chart: the picture, and what its colors and marks mean, which stands above it as text.
pub(super) struct Chart {
    pub(super) id: String,
    pub(super) svg: String,
    pub(super) key: Vec<KeyEntry>,
}

/// What a color and mark mean.
#[derive(Debug, Serialize)]
pub(super) struct KeyEntry {
    name: String,
    color: &'static str,
    mark: &'static str,
}

/// Name of a series' color in the style sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ink {
    Clean,
    Cracked,
    Third,
    Fourth,
    Fifth,
    Sixth,
    Seventh,
    Eighth,
}

impl Ink {
    fn css(self) -> &'static str {
        match self {
            Self::Clean => "var(--clean)",
            Self::Cracked => "var(--cracked)",
            Self::Third => "var(--third)",
            Self::Fourth => "var(--fourth)",
            Self::Fifth => "var(--fifth)",
            Self::Sixth => "var(--sixth)",
            Self::Seventh => "var(--seventh)",
            Self::Eighth => "var(--eighth)",
        }
    }

    /// What stands in the key.
    fn key(self, name: &str, mark: &'static str) -> KeyEntry {
        KeyEntry {
            name: name.to_owned(),
            color: self
                .css()
                .trim_start_matches("var(--")
                .trim_end_matches(')'),
            mark,
        }
    }

    /// Colors for series that are neither clean nor cracked, in turn.
    pub(super) fn of_series(place: usize) -> Self {
        let all = [
            Self::Cracked,
            Self::Clean,
            Self::Third,
            Self::Fourth,
            Self::Fifth,
            Self::Sixth,
            Self::Seventh,
            Self::Eighth,
        ];
        all.get(place % all.len()).copied().unwrap_or(Self::Third)
    }
}

/// The SVG of a plot, with its own words, and a view box in place of a size.
fn finish(plot: Plot, text: &ChartText<'_>, key: Vec<KeyEntry>) -> Chart {
    let drawing = plot.finish();
    let [width, height] = drawing.size_px;
    let id = text.id;
    let svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"chart\" viewBox=\"0 0 {width:.0} {height:.0}\" \
         role=\"img\" aria-labelledby=\"{id}-title {id}-desc\"><title id=\"{id}-title\">{}</title>\
         <desc id=\"{id}-desc\">{}</desc>\n{}</svg>",
        escaped(text.title),
        escaped(text.description),
        drawing.elements(),
    );
    Chart {
        id: id.to_owned(),
        svg,
        key,
    }
}
