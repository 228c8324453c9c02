//! What a model computes on the way: activations of a layer, as a feature vector of an image.

use image::{Rgb, RgbImage};

use super::Detector;
use crate::DetectError;

/// Side of the gray image by which a layer is chosen, px.
const PROBE_SIDE_PX: u32 = 64;

/// Values that are asked for in one run.
const AT_ONCE: usize = 16;

/// Sides of an array, and its numbers, last side fastest.
type ShapeAndValues = (Vec<usize>, Vec<f32>);

/// Most names that an error lists.
const MAX_LISTED: usize = 400;

/// Names with commas between; of very many the first ones.
fn listed(names: &[String]) -> String {
    let first: Vec<&str> = names.iter().take(MAX_LISTED).map(String::as_str).collect();
    let more = match names.len() > first.len() {
        true => ", …",
        false => "",
    };
    format!("{}{more}", first.join(", "))
}

impl Detector {
    /// The mean of each channel of a layer over the whole input: the feature vector of an image, one
    /// value per channel. Padding around the image is in the mean, alike for images of one shape.
    ///
    /// `layer` is the name of a value in the model that has the sides 1, channels, height, width.
    ///
    /// # Errors
    /// [`DetectError::Inference`] where the model fails, has no such value ([`Self::check_layer`] says so before the
    /// work), or it is no such map.
    pub fn pooled_activations(
        &self,
        name: &str,
        image: &RgbImage,
        layer: &str,
    ) -> Result<Vec<f32>, DetectError> {
        let wrong = |reason: String| self.wrong(name, reason);
        let mut found = self.values(name, image, &[layer.to_owned()])?;
        let (shape, values) = found.pop().unwrap_or_default();
        let &[1, channels, height, width] = shape.as_slice() else {
            return Err(wrong(format!(
                "the value {layer:?} has the sides {shape:?}; take one of 1 x channels x height x width"
            )));
        };
        let area = height * width;
        if channels == 0 || area == 0 || values.len() != channels * area {
            return Err(wrong(format!("the value {layer:?} is empty")));
        }
        #[expect(clippy::cast_precision_loss, reason = "a number of cells")]
        let count = area as f64;
        #[expect(clippy::cast_possible_truncation, reason = "a mean of f32")]
        let mean = |map: &[f32]| (map.iter().map(|v| f64::from(*v)).sum::<f64>() / count) as f32;
        Ok(values.chunks_exact(area).map(mean).collect())
    }

    /// Whether the model computes a value of this name.
    ///
    /// # Errors
    /// [`DetectError::Model`] with the names of those that it computes.
    pub fn check_layer(&self, layer: &str) -> Result<(), DetectError> {
        if self.facts.values.iter().any(|known| known == layer) {
            return Ok(());
        }
        Err(DetectError::Model {
            model: self.name.clone(),
            reason: format!(
                "has no layer {layer:?}; leave the layer out, or name one of its {} values: {}",
                self.facts.values.len(),
                listed(&self.facts.values)
            ),
        })
    }

    /// The name of the layer that sees most: of all maps (1 x channels x height x width) of the
    /// smallest area above one cell, the one of most channels, the first of equal ones. In the detectors with
    /// a pyramid it is the end of the backbone.
    ///
    /// # Errors
    /// [`DetectError::Inference`] where the model fails, or has no such map.
    pub fn coarsest_layer(&self) -> Result<String, DetectError> {
        let probe = RgbImage::from_pixel(PROBE_SIDE_PX, PROBE_SIDE_PX, Rgb([128; 3]));
        let name = "a gray image";
        let mut best: Option<(usize, usize, &String)> = None;
        let shapes = self.facts.values.chunks(AT_ONCE).flat_map(|values| {
            let all = self.values(name, &probe, values);
            // A value that is no floating point fails, and alone where they are asked for one by one.
            let found = all.unwrap_or_else(|_| {
                let one = |value| self.values(name, &probe, std::slice::from_ref(value));
                let one = |value| one(value).ok().and_then(|mut found| found.pop());
                values
                    .iter()
                    .map(|value| one(value).unwrap_or_default())
                    .collect()
            });
            values.iter().zip(found)
        });
        for (value, (shape, _)) in shapes {
            let &[1, channels, height, width] = shape.as_slice() else {
                continue;
            };
            let area = height * width;
            let is_better = best
                .is_none_or(|(least, most, _)| area < least || (area == least && channels > most));
            if height > 1 && width > 1 && channels > 1 && is_better {
                best = Some((area, channels, value));
            }
        }
        best.map(|(_, _, value)| value.clone()).ok_or_else(|| {
            self.wrong(
                name,
                "the model has no map of 1 x channels x height x width; name a layer".to_owned(),
            )
        })
    }

    /// Shapes and values that the model computes for an image.
    fn values(
        &self,
        name: &str,
        image: &RgbImage,
        wanted: &[String],
    ) -> Result<Vec<ShapeAndValues>, DetectError> {
        let wrong = |reason: String| self.wrong(name, reason);
        let placement = self.placement(name, image)?;
        let tensor = super::pixels::image_tensor(image, &placement, &self.contract.input);
        let inputs = self
            .plan
            .inputs(tensor, image.dimensions(), &placement)
            .map_err(wrong)?;
        self.runtime.run(inputs, wanted).map_err(wrong)
    }
}
