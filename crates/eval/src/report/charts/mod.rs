//! Charts as SVG that stands inside the page: colors and letters come from its style sheet, so that
//! light, dark and paper each get their own.

mod bars;
mod curves;
mod rows;

use kuva::backend::svg::SvgBackend;
use kuva::prelude::{Layout, LegendPosition, Plot};
use kuva::render::render::render_multiple;
use kuva::render::theme::Theme;

pub(super) use bars::bar_chart;
pub(super) use curves::{Curve, CurvePoint, CurveStyle, curve_chart};
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

/// Name of a series' color in the style sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ink {
    Clean,
    Cracked,
    Third,
    Fourth,
    Fifth,
    Faint,
}

impl Ink {
    pub(super) fn css(self) -> &'static str {
        match self {
            Self::Clean => "var(--clean)",
            Self::Cracked => "var(--cracked)",
            Self::Third => "var(--third)",
            Self::Fourth => "var(--fourth)",
            Self::Fifth => "var(--fifth)",
            Self::Faint => "var(--grid)",
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
        .with_legend_position(LegendPosition::OutsideTopLeft)
        .with_legend_box(false)
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
fn finish(plots: Vec<Plot>, layout: Layout, text: &ChartText<'_>) -> String {
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
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"chart\" viewBox=\"0 0 {width:.0} {height:.0}\" \
         role=\"img\" aria-labelledby=\"{id}-title {id}-desc\"><title id=\"{id}-title\">{}</title>\
         <desc id=\"{id}-desc\">{}</desc>{inside}",
        escaped(text.title),
        escaped(text.description),
    )
}

/// Text between tags.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
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
