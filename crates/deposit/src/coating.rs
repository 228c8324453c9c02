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
    /// The direction across those grooves, a unit vector: of single precision, so that a passage takes 128 bytes, up to which
    /// it is copied in registers.
    pub across: [f32; 2],
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

    /// The mean of some places; the direction of the grooves is that of the first.
    #[must_use]
    pub fn mean(mut places: impl Iterator<Item = Self>) -> Self {
        let Some(mut sum) = places.next() else {
            return Self::CLEAN;
        };
        let mut n = 1.0;
        for it in places {
            n += 1.0;
            sum.covered += it.covered;
            sum.narrow += it.narrow;
            sum.wide += it.wide;
            sum.streak += it.streak;
            for k in 0..3 {
                sum.direct[k] += it.direct[k];
                sum.diffuse[k] += it.diffuse[k];
                sum.back[k] += it.back[k];
            }
            for k in 0..2 {
                sum.turned_rad[k] += it.turned_rad[k];
            }
        }
        let per = 1.0 / n;
        Self {
            covered: per * sum.covered,
            direct: sum.direct.map(|it| per * it),
            narrow: per * sum.narrow,
            wide: per * sum.wide,
            streak: per * sum.streak,
            across: sum.across,
            diffuse: sum.diffuse.map(|it| per * it),
            back: sum.back.map(|it| per * it),
            turned_rad: sum.turned_rad.map(|it| per * it),
        }
    }
}

/// A coat on one pane.
pub trait Coating {
    /// What it does to light at a place, mm.
    fn passage(&self, at_mm: [f64; 2]) -> Passage;

    /// The mean over each of some ways on the pane, added in their order: each is given by its middle and by how far it goes,
    /// mm, and looked at in so many places.
    fn along(&self, ways_mm: &[[[f64; 2]; 2]], n_places: u32, to: &mut Vec<Passage>) {
        let place = |[at, way]: &[[f64; 2]; 2], k: u32| {
            let part = (f64::from(k) + 0.5) / f64::from(n_places) - 0.5;
            self.passage([at[0] + part * way[0], at[1] + part * way[1]])
        };
        if n_places == 1 {
            to.extend(ways_mm.iter().map(|[at, _]| self.passage(*at)));
        } else {
            let mean = |way| Passage::mean((0..n_places).map(|k| place(way, k)));
            to.extend(ways_mm.iter().map(mean));
        }
    }

    /// How wide the places may be that it is looked at, mm; 0 where that is all the same to it.
    fn even_over_mm(&self) -> f64 {
        0.0
    }

    /// How far apart those places may be, mm, where a pixel shows more of the pane.
    fn apart_mm(&self) -> f64 {
        self.even_over_mm()
    }

    /// Standard deviations per axis of its smaller and its larger angle, rad.
    fn turns_by_rad(&self) -> [f64; 2];

    /// Red, green and blue of white light that it turns by the larger angle, over what [`Passage::wide`] says.
    fn wide_rgb(&self) -> [f64; 3] {
        [1.0; 3]
    }
}
