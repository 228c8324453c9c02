//! A frame of linear light.

use crate::SensorError;

/// A frame of linear light, 1 where the image is white, in rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Light {
    width: usize,
    height: usize,
    n_colors: usize,
    values: Vec<f32>,
}

impl Light {
    /// A frame of a width and height, px, with one value per pixel (gray) or three (red, green, blue).
    ///
    /// # Errors
    /// [`SensorError::Frame`] where the values do not fill it.
    pub fn new(
        (width, height): (usize, usize),
        n_colors: usize,
        values: Vec<f32>,
    ) -> Result<Self, SensorError> {
        let wanted = width
            .checked_mul(height)
            .and_then(|n| n.checked_mul(n_colors));
        if wanted != Some(values.len()) || ![1, 3].contains(&n_colors) || values.is_empty() {
            return Err(SensorError::Frame {
                n_values: values.len(),
                width,
                height,
                n_colors,
            });
        }
        Ok(Self {
            width,
            height,
            n_colors,
            values,
        })
    }

    /// Width and height, px.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// 1 or 3.
    #[must_use]
    pub fn n_colors(&self) -> usize {
        self.n_colors
    }

    /// The values, colors of a pixel side by side.
    #[must_use]
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// The values, to be changed.
    pub(crate) fn values_mut(&mut self) -> &mut [f32] {
        &mut self.values
    }

    /// Each row with its number.
    pub(crate) fn rows_mut(&mut self) -> impl Iterator<Item = (usize, &mut [f32])> {
        let length = self.width * self.n_colors;
        self.values.chunks_exact_mut(length).enumerate()
    }

    /// The colors of a pixel.
    pub(crate) fn pixel_mut(&mut self, idx: usize) -> &mut [f32] {
        let at = idx * self.n_colors;
        &mut self.values[at..at + self.n_colors]
    }
}
