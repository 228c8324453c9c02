//! A frame of codes, as a file has it.

/// A sample of 8 or 16 bits.
pub trait Code: Copy + PartialEq {
    /// Bits of it.
    const BITS: u32;
    /// With one bit the other way round.
    #[must_use]
    fn flipped(self, bit: u32) -> Self;
    /// Its upper eight bits, rounded.
    fn upper_byte(self) -> u8;
    /// The code of eight bits.
    fn of_byte(byte: u8) -> Self;
    /// In units of the greatest code.
    fn share(self) -> f64;
    /// The nearest code to a share of the greatest.
    fn of_share(share: f64) -> Self;
}

impl Code for u8 {
    const BITS: u32 = 8;

    fn flipped(self, bit: u32) -> Self {
        self ^ (1 << bit)
    }

    fn upper_byte(self) -> u8 {
        self
    }

    fn of_byte(byte: u8) -> Self {
        byte
    }

    fn share(self) -> f64 {
        f64::from(self) / 255.0
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "held between 0 and the greatest"
    )]
    fn of_share(share: f64) -> Self {
        (share.clamp(0.0, 1.0) * 255.0 + 0.5) as Self
    }
}

impl Code for u16 {
    const BITS: u32 = 16;

    fn flipped(self, bit: u32) -> Self {
        self ^ (1 << bit)
    }

    fn upper_byte(self) -> u8 {
        u8::of_share(self.share())
    }

    fn of_byte(byte: u8) -> Self {
        Self::from(byte) * 257
    }

    fn share(self) -> f64 {
        f64::from(self) / 65_535.0
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "held between 0 and the greatest"
    )]
    fn of_share(share: f64) -> Self {
        (share.clamp(0.0, 1.0) * 65_535.0 + 0.5) as Self
    }
}

/// A frame of codes: `n_channels` samples side by side for each pixel, of which the first `n_colors` are colors and the
/// rest is alpha, in rows from the top.
#[derive(Debug)]
pub struct Codes<'a, C> {
    pub(crate) samples: &'a mut [C],
    pub(crate) size: (usize, usize),
    pub(crate) n_channels: usize,
    pub(crate) n_colors: usize,
}

impl<'a, C: Code> Codes<'a, C> {
    /// The samples of a frame of a width and height, px, with 1 to 4 channels; none where they do not fill it.
    pub fn new(samples: &'a mut [C], size: (usize, usize), n_channels: usize) -> Option<Self> {
        let wanted = size.0.checked_mul(size.1)?.checked_mul(n_channels)?;
        let is_frame = wanted > 0 && wanted == samples.len() && n_channels <= 4;
        is_frame.then_some(Self {
            samples,
            size,
            n_channels,
            n_colors: if n_channels < 3 { 1 } else { 3 },
        })
    }

    /// The colors, without alpha.
    pub(crate) fn colors(&self) -> impl Iterator<Item = C> {
        let n_colors = self.n_colors;
        let pixels = self.samples.chunks_exact(self.n_channels);
        pixels.flat_map(move |pixel| pixel[..n_colors].iter().copied())
    }

    /// The same, to be changed.
    pub(crate) fn colors_mut(&mut self) -> impl Iterator<Item = &mut C> {
        let n_colors = self.n_colors;
        let pixels = self.samples.chunks_exact_mut(self.n_channels);
        pixels.flat_map(move |pixel| &mut pixel[..n_colors])
    }
}
