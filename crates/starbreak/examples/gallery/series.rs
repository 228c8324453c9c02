//! One crack over the values of one parameter: strips for docs/theory/optics.md.

use image::imageops::{crop_imm, replace};
use image::{Rgb, RgbImage};
use starbreak::Recipe;

use super::{FRAME, GAP, Result, cracked};

/// Height of a strip, px; it is as wide as the frame.
const HEIGHT: u32 = 260;

/// Pictures of one crack, from left to right.
pub(super) struct Series {
    pub(super) name: &'static str,
    preset: &'static str,
    seed: u64,
    /// What is the same for all of them.
    beside: &'static [&'static str],
    /// What differs.
    each: &'static [&'static str],
}

pub(super) const SERIES: [Series; 5] = [
    Series {
        name: "optics-focus",
        preset: "windshield-star",
        seed: 1,
        beside: &[],
        each: &[
            "camera.focus_distance_m=far",
            "camera.focus_distance_m=0.3",
            "camera.focus_distance_m=0.1",
            "camera.focus_distance_m=0.07",
            "camera.focus_distance_m=short",
        ],
    },
    Series {
        name: "optics-f-number",
        preset: "windshield-star",
        seed: 1,
        beside: &[],
        each: &[
            "camera.f_number=1.4",
            "camera.f_number=2.8",
            "camera.f_number=5.6",
            "camera.f_number=11",
            "camera.f_number=22",
        ],
    },
    Series {
        name: "optics-sun",
        preset: "windshield-star",
        seed: 1,
        beside: &[
            "camera.f_number=16",
            "optics.sun_irradiance=4",
            "optics.sun_elevation_deg=20",
        ],
        each: &[
            "optics.sun_azimuth_deg=-90",
            "optics.sun_azimuth_deg=-64",
            "optics.sun_azimuth_deg=0",
            "optics.sun_azimuth_deg=64",
            "optics.sun_azimuth_deg=90",
        ],
    },
    Series {
        name: "optics-rake",
        preset: "windshield-star",
        seed: 1,
        beside: &["camera.f_number=8"],
        each: &[
            "glass.rake_deg=0",
            "glass.rake_deg=20",
            "glass.rake_deg=40",
            "glass.rake_deg=60",
            "glass.rake_deg=70",
        ],
    },
    Series {
        name: "optics-paper",
        preset: "windshield-star",
        seed: 1,
        beside: &[],
        each: &[
            "optics.model=physical camera.focus_distance_m=far",
            "optics.model=paper camera.focus_distance_m=far",
            "optics.model=physical camera.focus_distance_m=short",
            "optics.model=paper camera.focus_distance_m=short",
        ],
    },
];

impl Series {
    /// The strip, cut out of the frames around the hit.
    pub(super) fn strip(&self, street: &RgbImage) -> Result<RgbImage> {
        let count = u32::try_from(self.each.len())?;
        let width = (FRAME.0 - (count - 1) * GAP) / count;
        let mut strip = RgbImage::from_pixel(count * (width + GAP) - GAP, HEIGHT, Rgb([255; 3]));
        for (k, sets) in (0..).zip(self.each) {
            let mut recipe = Recipe::preset(self.preset)?;
            for set in self.beside.iter().copied().chain(sets.split(' ')) {
                recipe.set(set)?;
            }
            let picture = cracked(&recipe, street, self.seed)?;
            let (x, y) = ((FRAME.0 - width) / 2, (FRAME.1 - HEIGHT) / 2);
            let tile = crop_imm(&picture, x, y, width, HEIGHT).to_image();
            replace(&mut strip, &tile, k * i64::from(width + GAP), 0);
        }
        Ok(strip)
    }

    /// How each picture is made.
    pub(super) fn command(&self) -> String {
        let beside: String = self
            .beside
            .iter()
            .map(|set| format!(" --set {set}"))
            .collect();
        format!(
            "crack --preset {} --seed {}{beside} --set {{{}}}",
            self.preset,
            self.seed,
            self.each.join(" | ")
        )
    }
}
