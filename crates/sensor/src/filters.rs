//! The color filters over the pixels.

/// Shares of red, green and blue in what a pixel without a filter sees: those of luminance, BT.709.
const WEIGHTS: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Color filters that are lost: each pixel sees a share of all colors instead of its own.
///
/// C′ = (1 − s) C + s Σ w C, with the weights of luminance. FIT: the filters' own are not known of a photograph, and a
/// camera that sets white balance and exposure anew is assumed, which keeps gray gray and as bright as it was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Filters {
    /// Share of the filters that is lost, 0 to 1.
    pub loss: f64,
}

impl Filters {
    /// Whether none is lost.
    #[must_use]
    pub fn is_nothing(&self) -> bool {
        self.loss == 0.0
    }

    /// The colors that are seen.
    #[inline]
    pub(crate) fn of(&self, [red, green, blue]: [f32; 3]) -> [f32; 3] {
        let share = crate::draw::single(self.loss);
        let [r, g, b] = WEIGHTS;
        let all = r * red + g * green + b * blue;
        [red, green, blue].map(|color| color + share * (all - color))
    }
}
