//! The sheet of glass: its outline, and in which unit its plane is measured.

use serde::{Deserialize, Serialize};

/// Unit of length of a network's plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LengthUnit {
    /// Pixels of the frame: origin at the top left corner, first pixel centre at (0.5, 0.5), y down.
    Px,
    /// Millimetres on the glass: origin at the top left corner, y down.
    Mm,
}

impl LengthUnit {
    /// The unit's symbol.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Px => "px",
            Self::Mm => "mm",
        }
    }
}

/// How the glass was made, which decides how it breaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GlassKind {
    /// Slowly cooled float glass, free of residual stress.
    Annealed,
    /// Two plies with a polymer between them (windscreen).
    Laminated,
    /// Surfaces in compression, core in tension: dices as a whole.
    Tempered,
    /// Small cover over a lens.
    Cover,
}

/// A pane that spans `[0, width] × [0, height]`: a rectangle or, see [`Pane::is_disc`], a disc.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pane {
    /// Width in the network's [`LengthUnit`], 10⁻⁶ to 10⁹.
    pub width: f64,
    /// Height in the network's [`LengthUnit`], 10⁻⁶ to 10⁹.
    pub height: f64,
    /// Thickness, mm; absent where the model has none (the paper's).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thickness_mm: Option<f64>,
    /// Kind of glass; absent where the model has none (the paper's).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kind: Option<GlassKind>,
}

/// Why a pane was refused.
#[derive(Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
#[error("pane {field} = {value}; expected a number from 1e-6 to 1e9")]
pub struct PaneError {
    /// Which measure.
    pub field: &'static str,
    /// What was given.
    pub value: f64,
}

impl Pane {
    /// A pane as large as a frame of `width_px × height_px` pixels.
    #[must_use]
    pub fn from_frame_px(width_px: u32, height_px: u32) -> Self {
        Self {
            width: f64::from(width_px),
            height: f64::from(height_px),
            thickness_mm: None,
            kind: None,
        }
    }

    /// Every measure is from 10⁻⁶ to 10⁹, so that no length or area leaves the range of a number.
    ///
    /// # Errors
    /// [`PaneError`] naming the first measure that is not.
    pub fn check(&self) -> Result<(), PaneError> {
        let measures = [
            ("width", Some(self.width)),
            ("height", Some(self.height)),
            ("thickness_mm", self.thickness_mm),
        ];
        for (field, value) in measures {
            if let Some(value) = value
                && !(1e-6..=1e9).contains(&value)
            {
                return Err(PaneError { field, value });
            }
        }
        Ok(())
    }

    /// Whether the pane is round: a cover as wide as it is high is the disc inscribed in its box.
    #[must_use]
    pub fn is_disc(&self) -> bool {
        #[expect(clippy::float_cmp, reason = "a disc is as wide as high, exactly")]
        let is_square = self.width == self.height;
        is_square && self.kind == Some(GlassKind::Cover)
    }

    /// How far from the rim a point still counts as on it, in the unit of the pane: no computed
    /// point lies exactly on a circle. 10⁻⁹ of the longer side.
    #[must_use]
    pub fn rim_tolerance(&self) -> f64 {
        1e-9 * self.width.max(self.height)
    }

    /// Whether the point lies on the pane, its rim included (of a disc, with
    /// [`Pane::rim_tolerance`]).
    #[must_use]
    pub fn contains(&self, x: f64, y: f64) -> bool {
        if self.is_disc() {
            let radius = 0.5 * self.width;
            let (dx, dy) = (x - radius, y - radius);
            return (dx * dx + dy * dy).sqrt() <= radius + self.rim_tolerance();
        }
        (0.0..=self.width).contains(&x) && (0.0..=self.height).contains(&y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pane_without_area_is_refused() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let pane = Pane {
                width: bad,
                ..Pane::from_frame_px(10, 10)
            };
            assert!(pane.check().is_err(), "width {bad} was accepted");
        }
        assert!(
            Pane::from_frame_px(1, 1).check().is_ok(),
            "a pane of one pixel is a pane"
        );
    }
}
