//! Feature vectors of images, one beside the other.

use crate::EvalError;

/// Larger values would overflow in a covariance.
const LARGEST: f64 = 1e100;

/// Vectors of one length, one for each image, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct FeatureVectors {
    n_dimensions: usize,
    values: Vec<f64>,
}

impl FeatureVectors {
    /// Vectors of `n_dimensions` values each, one after the other.
    ///
    /// # Errors
    /// [`EvalError::Dimensions`] where they do not come out even or there are none,
    /// [`EvalError::FeatureValue`] for one that is NaN, infinite or beyond 1e100.
    pub fn new(n_dimensions: usize, values: Vec<f64>) -> Result<Self, EvalError> {
        if n_dimensions == 0 || values.is_empty() || !values.len().is_multiple_of(n_dimensions) {
            return Err(EvalError::Dimensions {
                what: "a set of feature vectors",
                n_values: values.len(),
                n_dimensions,
                expected: n_dimensions.max(1) * values.len().div_ceil(n_dimensions.max(1)).max(1),
            });
        }
        let is_bad = |value: &f64| !(value.is_finite() && value.abs() < LARGEST);
        if let Some(at) = values.iter().position(is_bad) {
            return Err(EvalError::FeatureValue {
                row: at / n_dimensions,
                column: at % n_dimensions,
                value: values.get(at).copied().unwrap_or(f64::NAN),
            });
        }
        Ok(Self {
            n_dimensions,
            values,
        })
    }

    /// How many vectors there are.
    #[must_use]
    pub fn n(&self) -> usize {
        self.values.len() / self.n_dimensions
    }

    /// How long each is.
    #[must_use]
    pub fn n_dimensions(&self) -> usize {
        self.n_dimensions
    }

    /// The vectors in their order.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[f64]> + Clone {
        self.values.chunks_exact(self.n_dimensions)
    }

    /// Those at these places, as often as they are named; places beyond the last are left out.
    #[must_use]
    pub fn picked(&self, places: &[usize]) -> Vec<&[f64]> {
        let start = |place: &usize| place * self.n_dimensions;
        places
            .iter()
            .filter_map(|place| {
                self.values
                    .get(start(place)..start(place) + self.n_dimensions)
            })
            .collect()
    }

    /// That both sets are of one kind.
    ///
    /// # Errors
    /// [`EvalError::VectorLengths`].
    pub(super) fn check_like(&self, other: &Self) -> Result<(), EvalError> {
        if self.n_dimensions == other.n_dimensions {
            return Ok(());
        }
        Err(EvalError::VectorLengths {
            n_a: self.n_dimensions,
            n_b: other.n_dimensions,
        })
    }
}
