use std::borrow::Cow;

/// Why no image came out.
#[derive(Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum OpticsError {
    /// A parameter outside its range.
    #[error("{name} = {value}; expected {expected}")]
    Parameter {
        /// Name of the parameter, with its unit.
        name: &'static str,
        /// What was given.
        value: f64,
        /// What is possible.
        expected: Cow<'static, str>,
    },
    /// An image whose samples are neither 8 nor 16 bits.
    #[error("images of mode {mode} cannot be rendered; convert to 8-bit or 16-bit grey or RGB")]
    ImageMode {
        /// The mode, as the image library names it.
        mode: String,
    },
    /// An image without pixels.
    #[error("the image has no pixels: {width} × {height}")]
    EmptyImage {
        /// Its width.
        width: u32,
        /// Its height.
        height: u32,
    },
    /// A view without a camera, through which no light can be followed.
    #[error("the physical optics need a camera before the pane; a stretched pane has none")]
    NoCamera,
    /// A photograph of broken glass without transparency, before neither black nor white.
    #[error(
        "the photo of glass has no transparency, and its border is neither black nor white (median codes {darkest} to \
         {brightest} of 255); cut the glass out as a PNG with alpha, or say what is behind it with --overlay-background \
         black or white"
    )]
    PhotoBackground {
        /// Median over the border of the least code of a pixel.
        darkest: u8,
        /// Median of the greatest.
        brightest: u8,
    },
    /// A photograph that is all background.
    #[error(
        "the photo of glass shows none: {}",
        match *.background {
            "alpha" => "every pixel is transparent",
            "black" => "nothing is brighter than its black background",
            _ => "nothing is darker than its white background",
        }
    )]
    NoGlass {
        /// Name of the background.
        background: &'static str,
    },
    /// Bytes that are not a packed pattern or drawing.
    #[error("not a packed {what}: {why}, at byte {at}")]
    Packed {
        /// What they should be.
        what: &'static str,
        /// Where they are wrong, from 0.
        at: usize,
        /// In which way.
        why: &'static str,
    },
    /// Memory that is no frame.
    #[error(
        "{what} has {n_bytes} bytes; expected {expected}, its width × {}samples of a pixel",
        if *.what == "a row" { "" } else { "height × " }
    )]
    FrameBytes {
        /// What has too many or too few.
        what: &'static str,
        /// How many it has.
        n_bytes: usize,
        /// How many it should have.
        expected: usize,
    },
    /// Cracks drawn for a frame of another size.
    #[error(
        "the image is {width} × {height} px, but the cracks were drawn for {drawn_width} × {drawn_height} px"
    )]
    SizeMismatch {
        /// Width of the image.
        width: u32,
        /// Height of the image.
        height: u32,
        /// Width of the drawing.
        drawn_width: usize,
        /// Height of the drawing.
        drawn_height: usize,
    },
}

impl OpticsError {
    /// Each value is in its range, of which rows give the least and the most; not a number is in
    /// none. The last digits, which a change of unit may cost, do not count.
    ///
    /// # Errors
    /// [`OpticsError::Parameter`] with what was given and what is possible.
    pub(crate) fn check_ranges(rows: &[(&'static str, f64, f64, f64)]) -> Result<(), Self> {
        for &(name, value, least, most) in rows {
            let slack = |bound: f64| 1e-12 * bound.abs();
            if !(least - slack(least)..=most + slack(most)).contains(&value) {
                return Err(Self::Parameter {
                    name,
                    value,
                    expected: format!("{least} to {most}").into(),
                });
            }
        }
        Ok(())
    }
}
