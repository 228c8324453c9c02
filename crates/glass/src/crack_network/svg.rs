//! A drawing of the network that opens in any browser and vector editor.

use std::fmt::Write as _;

use super::{CrackNetwork, SegmentKind};
use crate::LengthUnit;

impl CrackNetwork {
    /// The network as an SVG picture, one path per kind of segment, one user unit per length
    /// unit of the network; impacts are circles. Classes name them: the kind, and `impact`. A
    /// network in mm is drawn at its true size. Numbers have three decimals.
    #[must_use]
    pub fn to_svg(&self) -> String {
        let pane = &self.data.pane;
        let (width, height) = (pane.width, pane.height);
        let (stroke, suffix) = match self.data.unit {
            LengthUnit::Px => (0.8_f64.max(width.max(height) / 1500.0), ""),
            // Cracks open by µm, which no drawing shows: a line that suits the pane instead.
            LengthUnit::Mm => (0.05_f64.max(width.max(height) / 2000.0), "mm"),
        };
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
             width=\"{width}{suffix}\" height=\"{height}{suffix}\">\n\
             <title>crack network: {} segments, total length {:.1} {}</title>\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#14181d\"/>\n",
            self.summary.n_segments,
            self.summary.total_length,
            self.data.unit.symbol(),
        );
        let kinds = &self.data.segments.kind;
        let mut present = kinds.clone();
        present.sort_unstable();
        present.dedup();
        for kind in present {
            let mut path = String::new();
            for (idx, _) in kinds
                .iter()
                .enumerate()
                .filter(|(_, other)| **other == kind)
            {
                let [x0, y0, x1, y1] = self.ends(idx);
                // Writing to a String cannot fail.
                let _ = write!(path, "M{x0:.3} {y0:.3}L{x1:.3} {y1:.3}");
            }
            let _ = writeln!(
                svg,
                "<path class=\"{}\" d=\"{path}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{stroke:.2}\" stroke-linecap=\"round\"/>",
                kind.name(),
                color(kind),
            );
        }
        for impact in &self.data.impacts {
            let _ = writeln!(
                svg,
                "<circle class=\"impact\" cx=\"{:.3}\" cy=\"{:.3}\" r=\"{:.2}\" fill=\"none\" stroke=\"#ff5a36\" stroke-width=\"{:.2}\"/>",
                impact.x,
                impact.y,
                stroke * 5.0,
                stroke * 1.5,
            );
        }
        svg.push_str("</svg>\n");
        svg
    }
}

/// Colors that stay apart for color-blind eyes (Okabe and Ito), light on dark.
fn color(kind: SegmentKind) -> &'static str {
    match kind {
        SegmentKind::Propagated | SegmentKind::Radial => "#f4f4f4",
        SegmentKind::Mst => "#56b4e9",
        SegmentKind::Fork => "#f0e442",
        SegmentKind::Ring => "#009e73",
        SegmentKind::Cone => "#cc79a7",
        SegmentKind::Edge => "#e69f00",
        SegmentKind::Dice => "#0072b2",
    }
}
