//! What stands behind the glass in a photograph of it.

use image::DynamicImage;

use crate::OpticsError;

/// What stands behind the glass in a photograph, which decides how it is read.
///
/// With P the linear light of a pixel, 1 for white, and α its alpha:
///
/// | background | opacity a | light c |
/// |---|---|---|
/// | `Alpha` | α | αP |
/// | `Black` | P, per color | P |
/// | `White` | 1 − P, per color | 0 |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Background {
    /// None: the glass is cut out, in straight alpha. A pixel shows glass of its color over the
    /// share α of its area, and what lies behind over the rest.
    Alpha,
    /// Black: what is not black is light that the glass sent to the camera from lamps beside it.
    ///
    /// A camera's ray that ends at lamps by a share does not end at the scene by that share, and
    /// a pixel P under lamps of light 1 has at least the share P of its rays there. Taking it to
    /// be P, glass in the even light of its scene is not seen, as it should be, and over a scene
    /// I₀ under white light the result is the *screen* of two pictures, 1 − (1 − I₀)(1 − P). The
    /// photograph does not show what the glass takes away without sending light: cracks that are
    /// dark before a bright sky are missing.
    Black,
    /// White: the glass before evenly lit paper. What is darker than paper is light that did not
    /// come through, P is the transmittance, and the result is the *product* of two pictures,
    /// I₀ P. Light that the glass sends from beside the paper is missing: cracks are only dark.
    White,
}

/// Codes of the border, over the greatest code, up to which it is black; as far from the greatest
/// it is white. FIT: studio black is 0 to 0.1, and a grey card is 0.46.
pub(super) const NEAR: f64 = 0.15;

impl Background {
    /// Name of it: `alpha`, `black` or `white`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Alpha => "alpha",
            Self::Black => "black",
            Self::White => "white",
        }
    }

    /// The background of a photograph: `Alpha` if any pixel is not opaque, else what the median
    /// pixel of the outermost rows and columns is near to.
    ///
    /// # Errors
    /// [`OpticsError::PhotoBackground`] where it is neither near black nor near white.
    pub fn recognize(photo: &DynamicImage) -> Result<Self, OpticsError> {
        if photo.color().has_alpha() && has_transparency(photo) {
            return Ok(Self::Alpha);
        }
        let border = Border::of(photo);
        if border.brightest <= NEAR {
            Ok(Self::Black)
        } else if border.darkest >= 1.0 - NEAR {
            Ok(Self::White)
        } else {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a code"
            )]
            let [darkest, brightest] =
                [border.darkest, border.brightest].map(|code| (code * 255.0).round() as u8);
            Err(OpticsError::PhotoBackground { darkest, brightest })
        }
    }
}

/// Medians over the outermost pixels of a photograph, codes over the greatest code.
#[derive(Debug, Clone, Copy)]
pub(super) struct Border {
    /// Of the least code of a pixel's colors.
    pub(super) darkest: f64,
    /// Of the greatest.
    pub(super) brightest: f64,
}

impl Border {
    pub(super) fn of(photo: &DynamicImage) -> Self {
        let (width, height) = (photo.width(), photo.height());
        let rows = [0, height.saturating_sub(1)];
        let columns = [0, width.saturating_sub(1)];
        let along_rows = rows
            .into_iter()
            .flat_map(|y| (0..width).map(move |x| (x, y)));
        let along_columns = columns
            .into_iter()
            .flat_map(|x| (0..height).map(move |y| (x, y)));
        let (mut least, mut most): (Vec<u16>, Vec<u16>) = along_rows
            .chain(along_columns)
            .map(|(x, y)| {
                let colors = colors16(photo, x, y);
                let [r, g, b] = colors;
                (r.min(g).min(b), r.max(g).max(b))
            })
            .unzip();
        let median = |codes: &mut Vec<u16>| {
            let middle = codes.len() / 2;
            if codes.is_empty() {
                return 0.0;
            }
            f64::from(*codes.select_nth_unstable(middle).1) / 65535.0
        };
        Self {
            darkest: median(&mut least),
            brightest: median(&mut most),
        }
    }
}

/// The color of a pixel in 16 bits, without its alpha.
fn colors16(photo: &DynamicImage, x: u32, y: u32) -> [u16; 3] {
    let wide = |code: u8| u16::from(code) * 257;
    match photo {
        DynamicImage::ImageLuma8(image) => [wide(image.get_pixel(x, y).0[0]); 3],
        DynamicImage::ImageLumaA8(image) => [wide(image.get_pixel(x, y).0[0]); 3],
        DynamicImage::ImageRgb8(image) => image.get_pixel(x, y).0.map(wide),
        DynamicImage::ImageRgba8(image) => {
            let [r, g, b, _] = image.get_pixel(x, y).0;
            [r, g, b].map(wide)
        }
        DynamicImage::ImageLuma16(image) => [image.get_pixel(x, y).0[0]; 3],
        DynamicImage::ImageLumaA16(image) => [image.get_pixel(x, y).0[0]; 3],
        DynamicImage::ImageRgb16(image) => image.get_pixel(x, y).0,
        DynamicImage::ImageRgba16(image) => {
            let [r, g, b, _] = image.get_pixel(x, y).0;
            [r, g, b]
        }
        _ => [0; 3],
    }
}

fn has_transparency(photo: &DynamicImage) -> bool {
    match photo {
        DynamicImage::ImageLumaA8(image) => image.pixels().any(|pixel| pixel.0[1] < u8::MAX),
        DynamicImage::ImageRgba8(image) => image.pixels().any(|pixel| pixel.0[3] < u8::MAX),
        DynamicImage::ImageLumaA16(image) => image.pixels().any(|pixel| pixel.0[1] < u16::MAX),
        DynamicImage::ImageRgba16(image) => image.pixels().any(|pixel| pixel.0[3] < u16::MAX),
        _ => false,
    }
}
