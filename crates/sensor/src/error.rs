/// What is wrong with a fault of the sensor, or with a frame.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SensorError {
    /// A frame whose values are not those of its size.
    #[error(
        "{n_values} values are no frame of {width} x {height} px with {n_colors} colors; expected one or three for \
         each pixel"
    )]
    Frame {
        /// How many there are.
        n_values: usize,
        /// Its width, px.
        width: usize,
        /// Its height, px.
        height: usize,
        /// Colors of a pixel.
        n_colors: usize,
    },
    /// A frame that no JPEG holds.
    #[error(
        "a frame of {width} x {height} px does not pass as JPEG: {reason}; set link.jpeg_quality to 0"
    )]
    Jpeg {
        /// Its width, px.
        width: usize,
        /// Its height, px.
        height: usize,
        /// Why.
        reason: String,
    },
}
