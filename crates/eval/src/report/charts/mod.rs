//! Charts as SVG that stands inside the page: colors and letters come from its style sheet, so that
//! light, dark and paper each get their own.

mod bars;
mod curves;
mod rows;

use std::sync::Arc;

use kuva::backend::svg::SvgBackend;
use kuva::prelude::{Layout, MarkerShape, Plot, TickFormat};
use kuva::render::render::render_multiple;
use kuva::render::theme::Theme;
use serde::Serialize;

pub(super) use bars::bar_chart;
pub(super) use curves::{
    Axis, Curve, CurvePoint, CurveStyle, Mark, curve_chart, marked_curve_chart,
};
pub(super) use rows::{RowPoint, RowSeries, row_chart};

/// Width of a chart, px of its own; it shrinks with the page.
const WIDTH: f64 = 680.0;

/// Most letters of a name beside an axis.
const MAX_LABEL_LETTERS: usize = 26;

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

impl KeyEntry {
    fn new(name: &str, ink: Ink, mark: &'static str) -> Self {
        Self {
            name: name.to_owned(),
            color: ink.class(),
            mark,
        }
    }
}

/// A letter that looks like a marker.
fn letter_of(marker: MarkerShape) -> &'static str {
    match marker {
        MarkerShape::Diamond => "◆",
        MarkerShape::Square => "■",
        MarkerShape::Triangle => "▲",
        _ => "●",
    }
}

/// Name of a series' color in the style sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ink {
    Clean,
    Cracked,
    Third,
    Fourth,
    Fifth,
}

impl Ink {
    pub(super) fn css(self) -> &'static str {
        match self {
            Self::Clean => "var(--clean)",
            Self::Cracked => "var(--cracked)",
            Self::Third => "var(--third)",
            Self::Fourth => "var(--fourth)",
            Self::Fifth => "var(--fifth)",
        }
    }

    fn class(self) -> &'static str {
        match self {
            Self::Clean => "clean",
            Self::Cracked => "cracked",
            Self::Third => "third",
            Self::Fourth => "fourth",
            Self::Fifth => "fifth",
        }
    }

    /// Colors for series that are neither clean nor cracked, in turn.
    pub(super) fn of_series(place: usize) -> Self {
        match place % 5 {
            0 => Self::Cracked,
            1 => Self::Clean,
            2 => Self::Third,
            3 => Self::Fourth,
            _ => Self::Fifth,
        }
    }
}

/// A layout with the looks that all charts share.
fn layout(x: (f64, f64), y: (f64, f64), height: f64) -> Layout {
    let theme = Theme {
        background: "none".into(),
        axis_color: "var(--axis)".into(),
        grid_color: "var(--grid)".into(),
        tick_color: "var(--axis)".into(),
        text_color: "var(--ink)".into(),
        legend_bg: "none".into(),
        legend_border: "none".into(),
        font_family: Some("inherit".into()),
        ..Theme::light()
    };
    Layout::new(x, y)
        .with_theme(theme)
        .with_width(WIDTH)
        .with_height(height)
        .with_tick_size(13)
        .with_label_size(14)
        .with_body_size(13)
        .with_axis_line_width(1.0)
        .with_x_axis_min(x.0)
        .with_x_axis_max(x.1)
        .with_y_axis_min(y.0)
        .with_y_axis_max(y.1)
}

/// The SVG of plots, with its own words, a view box in place of a size, and ids of its own.
fn finish(plots: Vec<Plot>, layout: Layout, text: &ChartText<'_>, key: Vec<KeyEntry>) -> Chart {
    let scene = render_multiple(plots, layout);
    let (width, height) = (scene.width, scene.height);
    let svg = SvgBackend::new().render_scene(&scene);
    let inside = svg
        .split_once("-->")
        .or_else(|| svg.split_once('>'))
        .map_or("", |(_, inside)| inside);
    let id = text.id;
    let inside = inside
        .replace(" id=\"", &format!(" id=\"{id}-"))
        .replace("url(#", &format!("url(#{id}-"));
    let svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"chart\" viewBox=\"0 0 {width:.0} {height:.0}\" \
         role=\"img\" aria-labelledby=\"{id}-title {id}-desc\"><title id=\"{id}-title\">{}</title>\
         <desc id=\"{id}-desc\">{}</desc>{inside}",
        escaped(text.title),
        escaped(text.description),
    );
    Chart { svg, key }
}

/// Text between tags.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

/// The words of an axis whose marks stand at 1, 2, …: names, from the end nearest to the origin.
fn names_at_marks(names: Vec<String>) -> TickFormat {
    let at = move |value: f64| {
        let is_at = |place: usize| (count(place + 1) - value).abs() < 1e-6;
        let place = (0..names.len()).find(|place| is_at(*place));
        place
            .and_then(|place| names.get(place))
            .cloned()
            .unwrap_or_default()
    };
    TickFormat::Custom(Arc::new(at))
}

/// A count of rows or series as a place on an axis.
fn count(n: usize) -> f64 {
    f64::from(u32::try_from(n).unwrap_or(u32::MAX))
}

/// A name as kuva is to draw it: short, and no formula of TeX.
fn label(name: &str) -> String {
    let n_letters = name.chars().count();
    let short: String = if n_letters > MAX_LABEL_LETTERS {
        let kept = name.chars().take(MAX_LABEL_LETTERS - 1);
        kept.chain(['…']).collect()
    } else {
        name.to_owned()
    };
    short.replace('$', "\\$")
}
