//! A placed image as the numbers of a model's input.

use image::RgbImage;

use super::{Placement, resize};
use crate::contract::{ColorOrder, InputContract, Layout, PadStage};

/// Numbers of an image input.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ImageTensor {
    /// Sides, in the order of the layout.
    pub(crate) shape: Vec<usize>,
    /// Numbers, last side fastest.
    pub(crate) values: Vec<f32>,
}

/// The image, placed, in the numbers and the order that the contract says.
pub(crate) fn image_tensor(
    image: &RgbImage,
    placement: &Placement,
    contract: &InputContract,
) -> ImageTensor {
    let placed = resize(
        image,
        placement.width_px,
        placement.height_px,
        contract.interpolation,
    );
    let (fw, fh) = (
        placement.frame_width_px as usize,
        placement.frame_height_px as usize,
    );
    let normal = |value: f32, channel: usize| {
        let mean = contract.mean.get(channel).copied().unwrap_or(0.0);
        let std = contract.std.get(channel).copied().unwrap_or(1.0);
        (value / contract.divisor - mean) / std
    };
    // Every byte of every channel once; the division is the one of the reference.
    let tables: Vec<Vec<f32>> = (0..3)
        .map(|channel| {
            (0..=u8::MAX)
                .map(|byte| normal(f32::from(byte), channel))
                .collect()
        })
        .collect();
    let pad = |channel: usize| match contract.pad_stage {
        PadStage::Pixels => normal(contract.pad_value, channel),
        PadStage::Numbers => contract.pad_value,
    };
    let n_frame = fw * fh;
    let is_planar = contract.layout != Layout::Nhwc;
    let mut values = vec![0.0; n_frame * 3];
    let (w, left, top) = (
        placement.width_px as usize,
        placement.left_px as usize,
        placement.top_px as usize,
    );
    for (channel, table) in tables.iter().enumerate() {
        let of_pixel = match contract.color {
            ColorOrder::Rgb => channel,
            ColorOrder::Bgr => 2 - channel,
        };
        let place = |pixel: usize| {
            if is_planar {
                channel * n_frame + pixel
            } else {
                pixel * 3 + channel
            }
        };
        let padding = pad(channel);
        for pixel in 0..n_frame {
            if let Some(value) = values.get_mut(place(pixel)) {
                *value = padding;
            }
        }
        for (row, bytes) in placed.as_raw().chunks_exact(w * 3).enumerate() {
            let start = (row + top) * fw + left;
            for (column, pixel) in bytes.chunks_exact(3).enumerate() {
                let byte = pixel.get(of_pixel).copied().unwrap_or_default();
                let number = table.get(usize::from(byte)).copied().unwrap_or_default();
                if let Some(value) = values.get_mut(place(start + column)) {
                    *value = number;
                }
            }
        }
    }
    let shape = match contract.layout {
        Layout::Nchw => vec![1, 3, fh, fw],
        Layout::Nhwc => vec![1, fh, fw, 3],
        Layout::Chw => vec![3, fh, fw],
    };
    ImageTensor { shape, values }
}
