//! The pixels of a frame on its way through the glass: an image, or rows that stay where a message has them.

use image::{ColorType, DynamicImage};
use starbreak::optics::{Channels, FrameMut, OpticsError};
use starbreak::sensor::Moment;
use starbreak::{Chain, KeptFrame, Lit};
use starbreak_optics::environment::Environment;

use crate::Error;

/// Where rows of pixels of 8-bit samples lie among other bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct RowLayout {
    /// Place of the first sample.
    pub(crate) start: usize,
    /// Bytes from row to row, no fewer than those of a row's pixels.
    pub(crate) step: usize,
    /// Width and height, px.
    pub(crate) size: (u32, u32),
    /// What the samples of a pixel are.
    pub(crate) channels: Channels,
}

impl RowLayout {
    /// The frame that lies there; what is between rows is no part of it.
    pub(crate) fn frame<'a>(&self, bytes: &'a mut [u8]) -> Result<FrameMut<'a>, OpticsError> {
        let (width, height) = self.size;
        let bytes = bytes.get_mut(self.start..).unwrap_or_default();
        let rows = bytes.chunks_mut(self.step).take(height as usize);
        FrameMut::of_rows(rows.collect(), width, self.channels)
    }
}

/// The pixels of a frame.
pub(crate) enum Pixels {
    /// An image of its own.
    Image(DynamicImage),
    /// Rows in bytes that hold more than them.
    Rows { bytes: Vec<u8>, layout: RowLayout },
}

impl Pixels {
    /// Width and height, px.
    pub(crate) fn size(&self) -> (u32, u32) {
        match self {
            Self::Image(image) => (image.width(), image.height()),
            Self::Rows { layout, .. } => layout.size,
        }
    }

    /// The colors of its image.
    pub(super) fn color(&self) -> ColorType {
        match self {
            Self::Image(image) => image.color(),
            Self::Rows { layout, .. } => match layout.channels {
                Channels::Gray => ColorType::L8,
                Channels::Rgb | Channels::Bgr => ColorType::Rgb8,
                Channels::Rgba | Channels::Bgra => ColorType::Rgba8,
            },
        }
    }

    /// The light around the camera, as far as it is seen.
    pub(super) fn light(&mut self, chain: &Chain) -> Result<Option<Environment>, Error> {
        Ok(match self {
            Self::Image(image) => chain.light_of(image),
            Self::Rows { bytes, layout } => chain.light_of_frame(&frame_of(bytes, layout)?),
        })
    }

    /// Puts the glass over them.
    pub(super) fn put_behind(&mut self, lit: &Lit<'_>, at: Moment) -> Result<(), Error> {
        match self {
            Self::Image(image) => lit.over(image, at)?,
            Self::Rows { bytes, layout } => {
                let mut frame = frame_of(bytes, layout)?;
                lit.over_frame(&mut frame, &mut KeptFrame::default(), at)?;
            }
        }
        Ok(())
    }

    /// A copy as an image.
    pub(super) fn copied(&mut self) -> Result<DynamicImage, Error> {
        Ok(match self {
            Self::Image(image) => image.clone(),
            Self::Rows { bytes, layout } => {
                let mut image = DynamicImage::default();
                frame_of(bytes, layout)?.copy_to(&mut image);
                image
            }
        })
    }

    /// Shows another picture of this size, in the colors of this one.
    pub(super) fn show(&mut self, picture: &DynamicImage) -> Result<(), Error> {
        let mut picture = as_color(picture, self.color());
        match self {
            Self::Image(image) => *image = picture,
            Self::Rows { bytes, layout } => {
                let copied = frame_of(bytes, layout)?.copy_from(&mut picture);
                copied.map_err(starbreak::Error::from)?;
            }
        }
        Ok(())
    }

    /// As an image.
    pub(super) fn into_image(mut self) -> Result<DynamicImage, Error> {
        match self {
            Self::Image(image) => Ok(image),
            Self::Rows { .. } => self.copied(),
        }
    }
}

fn frame_of<'a>(bytes: &'a mut [u8], layout: &RowLayout) -> Result<FrameMut<'a>, Error> {
    Ok(layout.frame(bytes).map_err(starbreak::Error::from)?)
}

/// The same picture in the colors of a file.
fn as_color(pixels: &DynamicImage, color: ColorType) -> DynamicImage {
    match color {
        ColorType::L8 => pixels.to_luma8().into(),
        ColorType::La8 => pixels.to_luma_alpha8().into(),
        ColorType::Rgb8 => pixels.to_rgb8().into(),
        ColorType::Rgba8 => pixels.to_rgba8().into(),
        ColorType::L16 => pixels.to_luma16().into(),
        ColorType::La16 => pixels.to_luma_alpha16().into(),
        ColorType::Rgb16 => pixels.to_rgb16().into(),
        ColorType::Rgba16 => pixels.to_rgba16().into(),
        _ => pixels.clone(),
    }
}
