//! Frames of 8-bit codes in memory that belongs to somebody else: a driver's, a simulator's, an array's.

use image::{DynamicImage, GrayImage, RgbImage, RgbaImage};

use crate::OpticsError;

/// What the samples of a pixel are, in the order in which they lie in memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Channels {
    /// One gray sample.
    Gray,
    /// Red, green, blue.
    Rgb,
    /// Blue, green, red.
    Bgr,
    /// Red, green, blue, and alpha, which nothing but distortion changes.
    Rgba,
    /// Blue, green, red, and alpha, which nothing but distortion changes.
    Bgra,
}

impl Channels {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Gray, Self::Rgb, Self::Bgr, Self::Rgba, Self::Bgra];

    /// Its name: `gray`, `rgb`, `bgr`, `rgba` or `bgra`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Gray => "gray",
            Self::Rgb => "rgb",
            Self::Bgr => "bgr",
            Self::Rgba => "rgba",
            Self::Bgra => "bgra",
        }
    }

    /// The channels of a name.
    #[must_use]
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|channels| channels.name() == name)
    }

    /// Samples of a pixel, 1, 3 or 4.
    #[must_use]
    pub fn n_samples(self) -> usize {
        match self {
            Self::Gray => 1,
            Self::Rgb | Self::Bgr => 3,
            Self::Rgba | Self::Bgra => 4,
        }
    }

    /// Colors of a pixel, 1 or 3.
    #[must_use]
    pub fn n_colors(self) -> usize {
        self.n_samples().min(3)
    }

    /// Whether blue comes before red.
    fn is_reversed(self) -> bool {
        matches!(self, Self::Bgr | Self::Bgra)
    }
}

/// A frame of 8-bit codes that are changed where they lie: rows that may be anywhere, of pixels that lie side by side.
///
/// # Shapes
/// As many rows as the frame is high, from the top; each of at least its width times the samples of a pixel. What comes
/// after them in a row, such as padding, is never read or written.
///
/// # Example
/// ```
/// use starbreak_optics::{Channels, FrameMut};
///
/// // Two rows of three BGRA pixels, padded to 16 bytes.
/// let mut bytes = [0_u8; 32];
/// let rows = bytes.chunks_exact_mut(16).collect();
/// let frame = FrameMut::of_rows(rows, 3, Channels::Bgra)?;
/// assert_eq!(frame.size(), (3, 2));
/// # Ok::<(), starbreak_optics::OpticsError>(())
/// ```
#[derive(Debug)]
pub struct FrameMut<'a> {
    rows: Vec<&'a mut [u8]>,
    width: usize,
    channels: Channels,
}

impl<'a> FrameMut<'a> {
    /// A frame of rows that are this many pixels wide.
    ///
    /// # Errors
    /// [`OpticsError::EmptyImage`] without pixels, [`OpticsError::FrameBytes`] for a row that is too short.
    pub fn of_rows(
        rows: Vec<&'a mut [u8]>,
        width_px: u32,
        channels: Channels,
    ) -> Result<Self, OpticsError> {
        let height = u32::try_from(rows.len()).unwrap_or(u32::MAX);
        if width_px == 0 || height == 0 {
            return Err(OpticsError::EmptyImage {
                width: width_px,
                height,
            });
        }
        let width = width_px as usize;
        let expected = width.saturating_mul(channels.n_samples());
        if let Some(row) = rows.iter().find(|row| row.len() < expected) {
            return Err(OpticsError::FrameBytes {
                what: "a row",
                n_bytes: row.len(),
                expected,
            });
        }
        Ok(Self {
            rows,
            width,
            channels,
        })
    }

    /// A frame of a width and height, px, whose bytes lie side by side.
    ///
    /// # Errors
    /// As [`FrameMut::of_rows`], and for more bytes than it has.
    pub fn of_bytes(
        bytes: &'a mut [u8],
        (width, height): (u32, u32),
        channels: Channels,
    ) -> Result<Self, OpticsError> {
        let of_row = (width as usize).saturating_mul(channels.n_samples());
        let expected = of_row.saturating_mul(height as usize);
        if expected == 0 {
            return Err(OpticsError::EmptyImage { width, height });
        }
        if bytes.len() != expected {
            return Err(OpticsError::FrameBytes {
                what: "the frame",
                n_bytes: bytes.len(),
                expected,
            });
        }
        Self::of_rows(bytes.chunks_exact_mut(of_row).collect(), width, channels)
    }

    /// Width and height, px.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        let side = |n| u32::try_from(n).unwrap_or(u32::MAX);
        (side(self.width), side(self.rows.len()))
    }

    /// What the samples of its pixels are.
    #[must_use]
    pub fn channels(&self) -> Channels {
        self.channels
    }

    /// Red, green and blue of a pixel in a column and a row of it; gray three times.
    #[inline]
    pub(crate) fn rgb_at(&self, x: usize, y: usize) -> [u8; 3] {
        let n = self.channels.n_samples();
        let pixel = &self.rows[y][x * n..(x + 1) * n];
        match self.channels {
            Channels::Gray => [pixel[0]; 3],
            Channels::Rgb | Channels::Rgba => [pixel[0], pixel[1], pixel[2]],
            Channels::Bgr | Channels::Bgra => [pixel[2], pixel[1], pixel[0]],
        }
    }

    /// The colors, 1 or 3, of pixels from a column of a row on; they must be in the frame.
    #[inline(always)]
    pub(crate) fn read<const COLORS: usize>(
        &self,
        (x, y): (usize, usize),
        codes: &mut [[u8; COLORS]],
    ) {
        let (row, is_reversed) = (&*self.rows[y], self.channels.is_reversed());
        match self.channels.n_samples() {
            1 => read_pixels::<1, COLORS>(row, x, codes, is_reversed),
            3 => read_pixels::<3, COLORS>(row, x, codes, is_reversed),
            _ => read_pixels::<4, COLORS>(row, x, codes, is_reversed),
        }
    }

    /// Writes what [`FrameMut::read`] reads.
    #[inline(always)]
    pub(crate) fn write<const COLORS: usize>(
        &mut self,
        (x, y): (usize, usize),
        codes: &[[u8; COLORS]],
    ) {
        let (row, is_reversed) = (&mut *self.rows[y], self.channels.is_reversed());
        match self.channels.n_samples() {
            1 => write_pixels::<1, COLORS>(row, x, codes, is_reversed),
            3 => write_pixels::<3, COLORS>(row, x, codes, is_reversed),
            _ => write_pixels::<4, COLORS>(row, x, codes, is_reversed),
        }
    }

    /// Copies it over an image, in whose memory it stays where that has its size and channels: gray, RGB or RGBA.
    pub fn copy_to(&self, image: &mut DynamicImage) {
        let (width, height) = self.size();
        let fits = (image.width(), image.height()) == (width, height)
            && match self.channels {
                Channels::Gray => matches!(image, DynamicImage::ImageLuma8(_)),
                Channels::Rgb | Channels::Bgr => matches!(image, DynamicImage::ImageRgb8(_)),
                Channels::Rgba | Channels::Bgra => matches!(image, DynamicImage::ImageRgba8(_)),
            };
        if !fits {
            *image = match self.channels {
                Channels::Gray => GrayImage::new(width, height).into(),
                Channels::Rgb | Channels::Bgr => RgbImage::new(width, height).into(),
                Channels::Rgba | Channels::Bgra => RgbaImage::new(width, height).into(),
            };
        }
        let n = self.width * self.channels.n_samples();
        let Some(bytes) = bytes_of(image) else { return };
        for (to, from) in bytes.chunks_exact_mut(n).zip(&self.rows) {
            copy_row(to, &from[..n], self.channels);
        }
    }

    /// Copies an image over it that [`FrameMut::copy_to`] has made of it.
    ///
    /// # Errors
    /// [`OpticsError::FrameBytes`] for an image of another size or other channels.
    pub fn copy_from(&mut self, image: &mut DynamicImage) -> Result<(), OpticsError> {
        let n = self.width * self.channels.n_samples();
        let expected = n * self.rows.len();
        let bytes = bytes_of(image).unwrap_or_default();
        if bytes.len() != expected {
            return Err(OpticsError::FrameBytes {
                what: "the image that is copied back",
                n_bytes: bytes.len(),
                expected,
            });
        }
        for (from, to) in bytes.chunks_exact(n).zip(&mut self.rows) {
            copy_row(&mut to[..n], from, self.channels);
        }
        Ok(())
    }
}

/// The bytes of an image of 8 bits.
fn bytes_of(image: &mut DynamicImage) -> Option<&mut [u8]> {
    match image {
        DynamicImage::ImageLuma8(image) => Some(&mut *image),
        DynamicImage::ImageRgb8(image) => Some(&mut *image),
        DynamicImage::ImageRgba8(image) => Some(&mut *image),
        _ => None,
    }
}

/// Copies a row, with red and blue exchanged where blue comes first.
fn copy_row(to: &mut [u8], from: &[u8], channels: Channels) {
    match channels {
        Channels::Bgr => reverse::<3>(to, from),
        Channels::Bgra => reverse::<4>(to, from),
        _ => to.copy_from_slice(from),
    }
}

fn reverse<const N: usize>(to: &mut [u8], from: &[u8]) {
    let pixels = from.as_chunks::<N>().0;
    for (to, from) in to.as_chunks_mut::<N>().0.iter_mut().zip(pixels) {
        *to = *from;
        (to[0], to[2]) = (from[2], from[0]);
    }
}

#[inline(always)]
fn read_pixels<const N: usize, const COLORS: usize>(
    row: &[u8],
    x: usize,
    codes: &mut [[u8; COLORS]],
    is_reversed: bool,
) {
    let pixels = &row.as_chunks::<N>().0[x..x + codes.len()];
    for (codes, pixel) in codes.iter_mut().zip(pixels) {
        for (c, code) in codes.iter_mut().enumerate() {
            *code = pixel[if is_reversed { COLORS - 1 - c } else { c }];
        }
    }
}

#[inline(always)]
fn write_pixels<const N: usize, const COLORS: usize>(
    row: &mut [u8],
    x: usize,
    codes: &[[u8; COLORS]],
    is_reversed: bool,
) {
    let pixels = &mut row.as_chunks_mut::<N>().0[x..x + codes.len()];
    for (codes, pixel) in codes.iter().zip(pixels) {
        for (c, code) in codes.iter().enumerate() {
            pixel[if is_reversed { COLORS - 1 - c } else { c }] = *code;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_goes_to_an_image_and_comes_back() {
        for channels in Channels::ALL {
            let n = channels.n_samples();
            let mut bytes: Vec<u8> = (0..).take(3 * 2 * n).collect();
            let before = bytes.clone();
            let mut image = DynamicImage::new_luma8(1, 1);
            let mut frame = FrameMut::of_bytes(&mut bytes, (3, 2), channels)
                .unwrap_or_else(|error| panic!("{error}"));
            frame.copy_to(&mut image);
            let pixel = image.to_rgba8().get_pixel(1, 1).0;
            assert_eq!(pixel[..3], frame.rgb_at(1, 1), "{channels:?}");
            let mut codes = [[0; 3]; 2];
            if n > 1 {
                frame.read((1, 1), &mut codes);
                assert_eq!(codes[0], frame.rgb_at(1, 1), "{channels:?}");
                frame.write((1, 1), &codes);
            }
            frame
                .copy_from(&mut image)
                .unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(bytes, before, "{channels:?}");
            assert_eq!(Channels::of_name(channels.name()), Some(channels), "a name");
        }
    }

    #[test]
    fn what_is_no_frame_is_refused() {
        let of = |n: usize, size| {
            FrameMut::of_bytes(&mut vec![0; n], size, Channels::Rgb).map(|frame| frame.size())
        };
        assert_eq!(of(18, (3, 2)), Ok((3, 2)), "a frame");
        let short = of(17, (3, 2)).map_err(|error| error.to_string());
        let said = "the frame has 17 bytes; expected 18, its width × height × samples of a pixel";
        assert_eq!(short, Err(said.to_owned()), "too few");
        assert!(of(0, (0, 2)).is_err() && of(0, (3, 0)).is_err(), "none");
        let mut bytes = [0; 10];
        let rows = bytes.chunks_exact_mut(5).collect();
        let short = FrameMut::of_rows(rows, 2, Channels::Rgb);
        assert!(
            matches!(short, Err(OpticsError::FrameBytes { expected: 6, .. })),
            "a row"
        );
    }
}
