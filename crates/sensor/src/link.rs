//! The way from the camera to the computer: what a serializer and a codec do to the codes of a picture.

use jpeg_encoder::{ColorType, Encoder, SamplingFactor};
use starbreak_seed::{Seed, Stream, uniform};
use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;

use crate::{Code, Codes, SensorError};

/// Faults of the way to the computer. Rows come first, then bits, then the codec.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Link {
    /// Bits of a row's address that arrive: row y shows row y mod 2^bits. 16: all.
    pub row_bits: u32,
    /// Share of the bits that arrive wrong; each by itself.
    pub bit_error_rate: f64,
    /// Quality of JPEG that the picture passes, 1 to 100; 0: it passes none.
    pub jpeg_quality: u8,
}

impl Link {
    /// Whether all arrives as it was sent.
    #[must_use]
    pub fn is_nothing(&self) -> bool {
        self.row_bits >= 16 && self.bit_error_rate == 0.0 && self.jpeg_quality == 0
    }

    pub(crate) fn over<C: Code>(
        &self,
        codes: &mut Codes<'_, C>,
        frame: Seed,
    ) -> Result<(), SensorError> {
        self.alias_rows(codes);
        self.flip(codes, frame);
        match self.jpeg_quality {
            0 => Ok(()),
            quality => through_jpeg(codes, quality),
        }
    }

    fn alias_rows<C: Code>(&self, codes: &mut Codes<'_, C>) {
        let height = codes.size.1;
        let stride = codes.size.0 * codes.n_channels;
        if self.row_bits >= 16 {
            return;
        }
        let n_own = 1_usize << self.row_bits;
        for y in n_own..height {
            let (own, here) = codes.samples.split_at_mut(y * stride);
            let from = own[(y % n_own) * stride..].chunks_exact(codes.n_channels);
            let pixels = here[..stride].chunks_exact_mut(codes.n_channels);
            for (pixel, from) in pixels.zip(from) {
                pixel[..codes.n_colors].copy_from_slice(&from[..codes.n_colors]);
            }
        }
    }

    fn flip<C: Code>(&self, codes: &mut Codes<'_, C>, frame: Seed) {
        let form = (codes.n_colors, C::BITS);
        let (size, n_channels) = (codes.size, codes.n_channels);
        self.each_wrong(size, form, frame, |pixel, color, bit| {
            let sample = &mut codes.samples[pixel * n_channels + color];
            *sample = sample.flipped(bit);
        });
    }

    /// Calls for each wrong bit with its pixel, its color, and its place in the code. The number of good bits before the
    /// next wrong one is geometric, so that their count is binomial.
    pub(crate) fn each_wrong(
        &self,
        (width, height): (usize, usize),
        (n_colors, n_bits): (usize, u32),
        frame: Seed,
        mut call: impl FnMut(usize, usize, u32),
    ) {
        if self.bit_error_rate <= 0.0 {
            return;
        }
        let n_bits = n_bits as usize;
        let per_pixel = n_colors * n_bits;
        let mut rng = frame.stream(Stream::LinkBits, 0);
        let rarity = libm::log1p(-self.bit_error_rate.min(1.0));
        let mut at = 0_usize;
        loop {
            let good = libm::log1p(-uniform(&mut rng)) / rarity;
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a count of bits, held by the largest"
            )]
            let good = good as usize;
            at = at.saturating_add(good);
            if at / per_pixel >= width * height {
                return;
            }
            let (pixel, within) = (at / per_pixel, at % per_pixel);
            let bit = u32::try_from(within % n_bits).unwrap_or(0);
            call(pixel, within / n_bits, bit);
            at += 1;
        }
    }
}

/// Encodes and decodes the colors; of 16-bit codes the upper 8 bits pass.
fn through_jpeg<C: Code>(codes: &mut Codes<'_, C>, quality: u8) -> Result<(), SensorError> {
    let samples: Vec<u8> = codes.colors().map(|code| code.upper_byte()).collect();
    let decoded = samples_through_jpeg(&samples, codes.size, codes.n_colors, quality)?;
    for (code, byte) in codes.colors_mut().zip(decoded) {
        *code = C::of_byte(byte);
    }
    Ok(())
}

/// Apart from the kind of codes, for each of which the whole codec would be compiled.
fn samples_through_jpeg(
    samples: &[u8],
    (width, height): (usize, usize),
    n_colors: usize,
    quality: u8,
) -> Result<Vec<u8>, SensorError> {
    let error = |reason: String| SensorError::Jpeg {
        width,
        height,
        reason,
    };
    let [Ok(w), Ok(h)] = [width, height].map(u16::try_from) else {
        return Err(error("its sides are at most 65535 px".to_owned()));
    };
    let (color, space) = match n_colors {
        1 => (ColorType::Luma, ColorSpace::Luma),
        _ => (ColorType::Rgb, ColorSpace::RGB),
    };
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, quality);
    encoder.set_sampling_factor(if quality >= 90 {
        SamplingFactor::F_1_1
    } else {
        SamplingFactor::F_2_2
    });
    encoder
        .encode(samples, w, h, color)
        .map_err(|it| error(it.to_string()))?;
    let options = DecoderOptions::default()
        .set_max_width(usize::MAX)
        .set_max_height(usize::MAX)
        .jpeg_set_out_colorspace(space);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(&bytes), options);
    decoder.decode().map_err(|it| error(it.to_string()))
}
