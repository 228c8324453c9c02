//! Parts of a dataset by region and size, as values that the protocols restrict by.

use crate::{Detections, EvalError, LabelSet, Restriction};

/// A coverage above all that there are: 1 is the greatest.
const ABOVE_ALL: f64 = 2.0;

/// Area of the greatest small and of the greatest medium objects, px² [MS-COCO].
const SIZES_PX2: [f64; 2] = [1024.0, 9216.0];

/// Which objects are to be found. All others are ignored, and so are detections that find one of
/// them, or nothing, where they themselves do not belong.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Subset {
    /// All.
    WholeImage,
    /// Those with this coverage or more; 0 stands for the region touching them.
    InRegion {
        /// The least coverage, 0 to 1.
        tau: f64,
    },
    /// Those with less coverage, or none for 0: the control.
    OutOfRegion {
        /// The least coverage that is inside, 0 to 1.
        tau: f64,
    },
    /// Those with a coverage from one value to below another; up to 1 with 1 in it.
    CoverageBin {
        /// The least coverage.
        least: f64,
        /// The coverage that is above all of these.
        below: f64,
    },
    /// Those of a size, by area, in the region.
    SizeInRegion {
        /// The size.
        size: Size,
        /// The least coverage, 0 to 1.
        tau: f64,
    },
}

/// Sizes of objects, as MS-COCO has them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// To 32² px².
    Small,
    /// To 96² px².
    Medium,
    /// Above.
    Large,
}

impl Size {
    /// From small to large.
    pub const ALL: [Self; 3] = [Self::Small, Self::Medium, Self::Large];

    /// `small`, `medium`, `large`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Small => "small",
            Self::Medium => "medium",
            Self::Large => "large",
        }
    }
}

/// Coverages of the objects, and of the detections of one set.
#[derive(Debug, Clone, Copy)]
pub struct CoverageOf<'a> {
    /// In the order of [`LabelSet::objects`].
    pub objects: &'a [f64],
    /// In the order of [`Detections::items`].
    pub detections: &'a [f64],
}

/// The values by which a subset is told from the rest.
#[derive(Debug, Clone)]
pub struct SubsetValues {
    objects: Vec<f64>,
    detections: Vec<f64>,
    range: [f64; 2],
}

impl SubsetValues {
    /// As a restriction of a protocol.
    #[must_use]
    pub fn restriction(&self) -> Restriction<'_> {
        Restriction {
            objects: &self.objects,
            detections: &self.detections,
            range: self.range,
        }
    }

    /// Whether each object is to be found: it is in the subset, and neither crowd nor ignored.
    pub fn counted<'a>(&'a self, labels: &'a LabelSet) -> impl Iterator<Item = bool> + 'a {
        let objects = labels.objects.iter().zip(&self.objects);
        objects.map(|(object, value)| {
            let is_inside = (self.range[0]..=self.range[1]).contains(value);
            is_inside && object.is_to_be_found()
        })
    }
}

impl Subset {
    /// The values of this subset, all of them the coverages, or areas where sizes count.
    ///
    /// # Errors
    /// [`EvalError::Rule`] for coverages of other number than the objects and detections, or a
    /// threshold that is not a number.
    pub fn values(
        &self,
        labels: &LabelSet,
        detections: &Detections,
        coverage: CoverageOf<'_>,
    ) -> Result<SubsetValues, EvalError> {
        let all = Restriction {
            objects: coverage.objects,
            detections: coverage.detections,
            range: [0.0, ABOVE_ALL],
        };
        all.check(labels.objects.len(), detections.items.len())?;
        let inside = |tau: f64| match tau {
            // The smallest number that there is.
            tau if tau <= 0.0 => f64::from_bits(1),
            tau => tau,
        };
        let range = match *self {
            Self::WholeImage => [0.0, ABOVE_ALL],
            Self::InRegion { tau } => [inside(tau), ABOVE_ALL],
            Self::OutOfRegion { tau } => [0.0, inside(tau).next_down()],
            Self::CoverageBin { least, below } if below >= 1.0 => [least, ABOVE_ALL],
            Self::CoverageBin { least, below } => [least, below.next_down()],
            Self::SizeInRegion { size, tau } => {
                return Ok(by_size(labels, detections, coverage, size, inside(tau)));
            }
        };
        if range.iter().any(|edge| edge.is_nan()) {
            return Err(EvalError::Rule(
                "a coverage that is not a number; give 0 to 1".to_owned(),
            ));
        }
        Ok(SubsetValues {
            objects: coverage.objects.to_vec(),
            detections: coverage.detections.to_vec(),
            range,
        })
    }
}

/// Areas where the coverage suffices, -1 elsewhere: out of all ranges of sizes.
fn by_size(
    labels: &LabelSet,
    detections: &Detections,
    coverage: CoverageOf<'_>,
    size: Size,
    tau: f64,
) -> SubsetValues {
    let value = |area: f64, coverage: f64| if coverage >= tau { area } else { -1.0 };
    let objects = labels.objects.iter().zip(coverage.objects);
    let said = detections.items.iter().zip(coverage.detections);
    let [small, medium] = SIZES_PX2;
    SubsetValues {
        objects: objects.map(|(o, c)| value(o.area_px2, *c)).collect(),
        detections: said.map(|(d, c)| value(d.box_px.area_px2(), *c)).collect(),
        range: match size {
            Size::Small => [0.0, small],
            Size::Medium => [small, medium],
            Size::Large => [medium, 1e10],
        },
    }
}
