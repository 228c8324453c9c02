//! A photograph as opacity and light.

use image::DynamicImage;

use super::background::{Background, Border, NEAR};
use super::placement::Placement;
use super::raster::Raster;
use crate::OpticsError;
use crate::srgb::{decode16, encode16};

/// How a photograph is read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhotoParams {
    /// What stands behind the glass; none: [recognized](Background::recognize).
    pub background: Option<Background>,
    /// Distance from the background, as codes over the greatest code, 0 to 0.5, up to which a
    /// pixel is background: what sensor noise and the compression leave in it. It is counted from
    /// the median of the border, and what is beyond it is stretched, so that nothing jumps and
    /// white stays white. Not used with alpha. **Default**: 0.03, 8 of 255. FIT: see
    /// validation/overlay_photo.py.
    pub floor: f64,
}

impl Default for PhotoParams {
    fn default() -> Self {
        Self {
            background: None,
            floor: 0.03,
        }
    }
}

impl PhotoParams {
    /// Every parameter is in its range.
    ///
    /// # Errors
    /// [`OpticsError::Parameter`] naming the first that is not.
    pub fn check(&self) -> Result<(), OpticsError> {
        OpticsError::check_ranges(&[("overlay_floor", self.floor, 0.0, 0.5)])
    }
}

/// A photograph of broken glass: opacity and light of each pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct Photo {
    width: usize,
    height: usize,
    background: Background,
    codes: Codes,
    /// Of each code its opacity; with alpha its light.
    of_code: Vec<f32>,
}

/// Samples as they were in the file: three per pixel, four with alpha.
#[derive(Debug, Clone, PartialEq)]
enum Codes {
    Eight(Vec<u8>),
    Sixteen(Vec<u16>),
}

impl Photo {
    /// A photograph of 8 or 16 bits, grey or color. Its codes are read as sRGB.
    ///
    /// # Errors
    /// [`OpticsError::EmptyImage`], [`OpticsError::ImageMode`] for floating point,
    /// [`OpticsError::PhotoBackground`] where the background is not given and cannot be
    /// recognized, [`OpticsError::NoGlass`] where all of it is background,
    /// [`OpticsError::Parameter`].
    ///
    /// # Limits
    /// Where it has alpha and another background is given, its alpha is ignored.
    pub fn new(photo: DynamicImage, params: &PhotoParams) -> Result<Self, OpticsError> {
        params.check()?;
        let (width, height) = (photo.width(), photo.height());
        if width == 0 || height == 0 {
            return Err(OpticsError::EmptyImage { width, height });
        }
        let is_deep = match photo.color().bytes_per_pixel() / photo.color().channel_count() {
            1 => false,
            2 => true,
            _ => {
                return Err(OpticsError::ImageMode {
                    mode: format!("{:?}", photo.color()),
                });
            }
        };
        let background = match params.background {
            Some(background) => background,
            None => Background::recognize(&photo)?,
        };
        let border = Border::of(&photo);
        let of_code = table(background, border, params.floor, is_deep);
        let codes = match (background, is_deep) {
            (Background::Alpha, false) => Codes::Eight(photo.into_rgba8().into_raw()),
            (Background::Alpha, true) => Codes::Sixteen(photo.into_rgba16().into_raw()),
            (_, false) => Codes::Eight(photo.into_rgb8().into_raw()),
            (_, true) => Codes::Sixteen(photo.into_rgb16().into_raw()),
        };
        let photo = Self {
            width: width as usize,
            height: height as usize,
            background,
            codes,
            of_code,
        };
        if photo.shows_glass() {
            Ok(photo)
        } else {
            Err(OpticsError::NoGlass {
                background: background.name(),
            })
        }
    }

    /// Width and height, px of the photograph.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        let side = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        (side(self.width), side(self.height))
    }

    /// What stands behind the glass, as given or as recognized.
    #[must_use]
    pub fn background(&self) -> Background {
        self.background
    }

    /// The same photograph with no side longer than this, px: area means of its opacity and its
    /// light, in 16 bits. A smaller one stays as it is.
    #[must_use]
    pub fn shrunk_to(self, most_side_px: u32) -> Self {
        let (width, height) = self.size();
        let longest = width.max(height);
        if longest <= most_side_px || most_side_px == 0 {
            return self;
        }
        let side = |px: u32| {
            let shrunk = u64::from(px) * u64::from(most_side_px) / u64::from(longest);
            u32::try_from(shrunk.max(1)).unwrap_or(u32::MAX)
        };
        let (width, height) = (side(width) as usize, side(height) as usize);
        let placement = Placement {
            left_px: 0.0,
            top_px: 0.0,
            width_px: f64::from(self.size().0),
            height_px: f64::from(self.size().1),
            flip_horizontal: false,
            flip_vertical: false,
        };
        let raster = Raster::new(&self, &placement, (width, height), 0);
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let codes = pixels.flat_map(|(x, y)| {
            let glass = raster.glass(x, y);
            let codes = match self.background {
                Background::Alpha => {
                    let opacity = glass.opacity[0];
                    let [r, g, b] = glass.light.map(|light| encode16(light / opacity.max(1e-9)));
                    [r, g, b, code_of_share(opacity)]
                }
                Background::Black => {
                    let [r, g, b] = glass.light.map(encode16);
                    [r, g, b, 0]
                }
                Background::White => {
                    let [r, g, b] = glass.opacity.map(|opacity| encode16(1.0 - opacity));
                    [r, g, b, 0]
                }
            };
            let n_samples = if self.background == Background::Alpha {
                4
            } else {
                3
            };
            codes.into_iter().take(n_samples)
        });
        // The background has been taken off already.
        let clean = Border {
            darkest: 1.0,
            brightest: 0.0,
        };
        Self {
            width,
            height,
            background: self.background,
            codes: Codes::Sixteen(codes.collect()),
            of_code: table(self.background, clean, 0.0, true),
        }
    }

    fn shows_glass(&self) -> bool {
        fn any<S: Code>(samples: &[S], background: Background, of_code: &[f32]) -> bool {
            match background {
                Background::Alpha => samples.chunks_exact(4).any(|pixel| pixel[3].index() > 0),
                _ => samples.iter().any(|code| of_code[code.index()] > 0.0),
            }
        }
        match &self.codes {
            Codes::Eight(samples) => any(samples, self.background, &self.of_code),
            Codes::Sixteen(samples) => any(samples, self.background, &self.of_code),
        }
    }

    /// Lanes of the pixels `start..` of a row: with alpha [a, c red, c green, c blue], else a of
    /// red, green and blue.
    pub(super) fn read<const L: usize>(&self, y: usize, start: usize, lanes: &mut [[f32; L]]) {
        match &self.codes {
            Codes::Eight(samples) => self.read_codes(samples, y, start, lanes),
            Codes::Sixteen(samples) => self.read_codes(samples, y, start, lanes),
        }
    }

    fn read_codes<S: Code, const L: usize>(
        &self,
        samples: &[S],
        y: usize,
        start: usize,
        lanes: &mut [[f32; L]],
    ) {
        let first = (y * self.width + start) * L;
        let pixels = samples[first..first + lanes.len() * L].as_chunks::<L>().0;
        for (lanes, pixel) in lanes.iter_mut().zip(pixels) {
            *lanes = if L == 4 {
                let opacity = pixel[3].share();
                std::array::from_fn(|l| {
                    if l == 0 {
                        opacity
                    } else {
                        opacity * self.of_code[pixel[l - 1].index()]
                    }
                })
            } else {
                pixel.map(|code| self.of_code[code.index()])
            };
        }
    }
}

/// What each code stands for.
fn table(background: Background, border: Border, floor: f64, is_deep: bool) -> Vec<f32> {
    let codes: u32 = if is_deep { 1 << 16 } else { 1 << 8 };
    let light = |share: f64| {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a code of 16 bits"
        )]
        let code = (share.clamp(0.0, 1.0) * 65535.0).round() as u16;
        decode16(code)
    };
    // How far the background itself is off, and beyond that the floor.
    let black = border.brightest.min(NEAR) + floor;
    let white = border.darkest.max(1.0 - NEAR) - floor;
    (0..codes)
        .map(|code| {
            let share = f64::from(code) / f64::from(codes - 1);
            match background {
                Background::Alpha => light(share),
                Background::Black => light((share - black) / (1.0 - black)),
                Background::White => 1.0 - light(share / white),
            }
        })
        .collect()
}

/// The nearest code of 16 bits.
fn code_of_share(share: f32) -> u16 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a code of 16 bits"
    )]
    let code = (share.clamp(0.0, 1.0) * 65535.0).round() as u16;
    code
}

/// A sample of a photograph.
trait Code: Copy {
    fn index(self) -> usize;
    /// Over the greatest one.
    fn share(self) -> f32;
}

impl Code for u8 {
    fn index(self) -> usize {
        usize::from(self)
    }

    fn share(self) -> f32 {
        f32::from(self) / 255.0
    }
}

impl Code for u16 {
    fn index(self) -> usize {
        usize::from(self)
    }

    fn share(self) -> f32 {
        f32::from(self) / 65535.0
    }
}
