//! What lies on a pane without being seen piece by piece: what it does to light, from place to place.

/// What becomes of light of red, green and blue that meets a pane at one place, in shares of it. What is missing to 1 is
/// absorbed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passage {
    /// Share of the glass that is covered there.
    pub covered: f64,
    /// Goes straight on.
    pub direct: [f64; 3],
    /// Is turned by the coating's smaller angle: diffraction by grains and drops.
    pub narrow: f64,
    /// Is turned by its larger angle: refraction by drops, grains and ice.
    pub wide: f64,
    /// Is turned across a direction of the pane: by grooves along it.
    pub streak: f64,
    /// The direction across those grooves, a unit vector.
    pub across: [f64; 2],
    /// Goes on in any direction.
    pub diffuse: [f64; 3],
    /// Is sent back.
    pub back: [f64; 3],
    /// Angles by which what goes straight on is turned as a whole, right and down, rad.
    pub turned_rad: [f64; 2],
}

impl Passage {
    /// Clean glass.
    pub const CLEAN: Self = Self {
        covered: 0.0,
        direct: [1.0; 3],
        narrow: 0.0,
        wide: 0.0,
        streak: 0.0,
        across: [1.0, 0.0],
        diffuse: [0.0; 3],
        back: [0.0; 3],
        turned_rad: [0.0; 2],
    };
}

/// A coat on one pane.
pub trait Coating {
    /// What it does to light at a place, mm.
    fn passage(&self, at_mm: [f64; 2]) -> Passage;

    /// Standard deviations per axis of its smaller and its larger angle, rad.
    fn turns_by_rad(&self) -> [f64; 2];
}
