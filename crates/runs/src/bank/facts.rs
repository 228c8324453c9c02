//! Key figures of a pattern.

use std::f64::consts::FRAC_PI_4;

use image::GrayImage;
use serde::{Deserialize, Serialize};
use starbreak_glass::{CrackNetwork, LengthUnit, Model, Summary};
use starbreak_seed::Seed;

/// What provenance says of a pattern's network.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PatternFacts {
    /// The seed of the pattern.
    pub seed: Seed,
    /// Which model made the network.
    pub model: Model,
    /// Name of the damage class, where the model names one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damage_class: Option<String>,
    /// Unit of lengths.
    pub unit: LengthUnit,
    /// Area of the pane, in that unit squared.
    pub pane_area: f64,
    /// Key figures of the network.
    pub summary: Summary,
}

impl PatternFacts {
    pub(super) fn of(network: &CrackNetwork, seed: Seed) -> Self {
        let data = network.data();
        let pane = &data.pane;
        Self {
            seed,
            model: data.model,
            damage_class: data.damage_class.clone(),
            unit: data.unit,
            pane_area: if pane.is_disc() {
                FRAC_PI_4 * pane.width * pane.height
            } else {
                pane.width * pane.height
            },
            summary: network.summary(),
        }
    }
}

/// A row of a bank's statistics: key figures of a pattern in the frame that it was simulated for.
#[derive(Debug, Clone, PartialEq)]
pub struct PatternRow {
    /// Number of the pattern, from 0.
    pub idx: usize,
    /// Key figures of its network.
    pub facts: PatternFacts,
    /// Share of the frame that cracks cover.
    pub area_share: f64,
    /// Least rectangle of the frame with all cracks, px: left, top, and right and bottom
    /// exclusive; `None` where no crack is in the frame.
    pub bbox_px: Option<[u32; 4]>,
}

impl PatternRow {
    pub(super) fn of(idx: usize, facts: &PatternFacts, mask: &GrayImage) -> Self {
        let (mut sum, mut bbox) = (0_u64, None::<[u32; 4]>);
        for (x, y, code) in mask.enumerate_pixels() {
            if code.0[0] > 0 {
                sum += u64::from(code.0[0]);
                let [left, top, right, bottom] = bbox.unwrap_or([x, y, x, y]);
                bbox = Some([left.min(x), top.min(y), right.max(x + 1), bottom.max(y + 1)]);
            }
        }
        let n = f64::from(mask.width()) * f64::from(mask.height());
        #[expect(clippy::cast_precision_loss, reason = "a sum of codes")]
        let area_share = sum as f64 / (255.0 * n.max(1.0));
        Self {
            idx,
            facts: facts.clone(),
            area_share,
            bbox_px: bbox,
        }
    }

    /// Length of all cracks over the area of the pane: m/m² for a network in mm, px/px² for one
    /// in px.
    #[must_use]
    pub fn density(&self) -> f64 {
        let per_unit = self.facts.summary.total_length / self.facts.pane_area;
        match self.facts.unit {
            LengthUnit::Px => per_unit,
            LengthUnit::Mm => per_unit * 1e3,
        }
    }
}
