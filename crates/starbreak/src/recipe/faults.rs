//! The faults of a camera beside broken glass: one line each.

/// A fault of the camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FaultKind {
    /// The table of a recipe that turns it on.
    pub table: &'static str,
    /// Its presets with what each is; the first says what a table leaves out. In `distortion`, `fringes`, `defocus`, `isp`, `link` and `frames`, which hold
    /// several faults, what is left out works.
    pub presets: &'static [(&'static str, &'static str)],
}

impl FaultKind {
    /// Whether it is drops on the pane, and so is baked with broken glass.
    #[must_use]
    pub fn is_on_pane(&self) -> bool {
        self.table == "drops"
    }

    /// Whether it needs a pane to lie on.
    #[must_use]
    pub fn needs_pane(&self) -> bool {
        self.is_on_pane() || COATS.contains(&self.table)
    }

    /// Whether it moves what an image shows, so that labels no longer fit.
    #[must_use]
    pub fn moves_labels(&self) -> bool {
        self.table == "distortion"
    }
}

/// The tables of coats on the pane.
const COATS: [&str; 6] = ["mud", "dust", "film", "frost", "scratches", "condensation"];

/// All of them, in the order in which light meets them.
pub const FAULTS: [FaultKind; 26] = [
    FaultKind {
        table: "mud",
        presets: &[("muddy", "splats of mud that have dried on the glass")],
    },
    FaultKind {
        table: "dust",
        presets: &[(
            "dusty",
            "dust of all sizes on the glass: less light, and a veil around what is bright",
        )],
    },
    FaultKind {
        table: "film",
        presets: &[(
            "greasy",
            "a film of grease: what is seen bends, and some light is scattered",
        )],
    },
    FaultKind {
        table: "frost",
        presets: &[(
            "frosted",
            "ice on the glass: crystals that grow in branches and let white light through",
        )],
    },
    FaultKind {
        table: "scratches",
        presets: &[(
            "scratched",
            "worn glass: haze, and streaks through lamps across the wiper's way",
        )],
    },
    FaultKind {
        table: "drops",
        presets: &[(
            "rain",
            "rain on the pane since the wiper passed: drops that show the scene upside down",
        )],
    },
    FaultKind {
        table: "condensation",
        presets: &[(
            "fogged",
            "dew on the inner face: a veil of drops too small to be seen",
        )],
    },
    FaultKind {
        table: "distortion",
        presets: &[(
            "distortion",
            "a lens whose distortion nothing corrects: straight lines bend",
        )],
    },
    FaultKind {
        table: "fringes",
        presets: &[(
            "fringes",
            "a lens whose color error nothing corrects: red and blue edges",
        )],
    },
    FaultKind {
        table: "defocus",
        presets: &[(
            "defocus",
            "a sensor out of the focal plane, as by heat or a knock",
        )],
    },
    FaultKind {
        table: "shake",
        presets: &[("shake", "a camera that turns while it exposes")],
    },
    FaultKind {
        table: "ghosts",
        presets: &[(
            "ghosts",
            "light that faces of the lens mirror: images of the aperture, thrown by lamps and the sun",
        )],
    },
    FaultKind {
        table: "star",
        presets: &[(
            "star-burst",
            "light that the edges of the aperture diffract: a star through each lamp",
        )],
    },
    FaultKind {
        table: "glare",
        presets: &[(
            "glare",
            "light that a dirty or scratched lens scatters: a veil around what is bright",
        )],
    },
    FaultKind {
        table: "shading",
        presets: &[("shading", "corners that get less light than the middle")],
    },
    FaultKind {
        table: "exposure",
        presets: &[
            (
                "overexposed",
                "too much light: one to four stops, clipped where it is white",
            ),
            (
                "underexposed",
                "too little light, with the noise of fewer photons",
            ),
        ],
    },
    FaultKind {
        table: "banding",
        presets: &[
            (
                "banding",
                "lamps on the mains under a rolling shutter: bands across the picture",
            ),
            (
                "led-banding",
                "dimmed LEDs under a rolling shutter: dark bands between their pulses",
            ),
        ],
    },
    FaultKind {
        table: "spots",
        presets: &[("spots", "dust on the cover of the sensor: soft, dark discs")],
    },
    FaultKind {
        table: "cfa",
        presets: &[(
            "no-filters",
            "color filters that are lost: colors fade to gray",
        )],
    },
    FaultKind {
        table: "noise",
        presets: &[(
            "noise",
            "a sensor that counts few photons: shot, read and row noise, in electrons",
        )],
    },
    FaultKind {
        table: "pixels",
        presets: &[(
            "pixels",
            "dead, hot and stuck pixels, 1 to 10,000 of a million",
        )],
    },
    FaultKind {
        table: "lines",
        presets: &[("lines", "rows and columns that are always bright")],
    },
    FaultKind {
        table: "mosaic",
        presets: &[(
            "no-demosaicing",
            "rows whose colors are not interpolated: the sensor's mosaic shows",
        )],
    },
    FaultKind {
        table: "isp",
        presets: &[
            ("no-sharpening", "an image processor that does not sharpen"),
            (
                "no-white-balance",
                "an image processor without white balance: a green cast",
            ),
            (
                "no-color-matrix",
                "an image processor without its color matrix: pale colors",
            ),
            (
                "no-black-level",
                "an image processor that leaves the black level in: a magenta veil",
            ),
            (
                "no-tone-curve",
                "an image processor without its tone curve: dark, hard pictures",
            ),
        ],
    },
    FaultKind {
        table: "link",
        presets: &[
            (
                "bit-errors",
                "bits that arrive wrong, one of ten million to one of a thousand",
            ),
            (
                "compression",
                "pictures that pass JPEG of low quality on their way",
            ),
            (
                "row-alias",
                "row addresses that lack bits: the same rows again and again",
            ),
        ],
    },
    FaultKind {
        table: "frames",
        presets: &[("blank-frames", "frames that are black, and in clips frozen")],
    },
];

/// Several faults at once, as they come together on the road.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Scenario {
    /// The suite of a study that looks at it.
    pub suite: &'static str,
    /// Its preset, and what it is.
    pub preset: (&'static str, &'static str),
    /// The tables of its faults.
    pub faults: &'static [&'static str],
}

impl Scenario {
    /// Presets of its faults, each alone with the values that it has in the scenario: its preset and the table of the fault,
    /// as `rainy-drive.drops`.
    pub fn alone(&self) -> impl Iterator<Item = String> {
        let name = self.preset.0;
        self.faults
            .iter()
            .map(move |table| format!("{name}.{table}"))
    }
}

/// All of them.
pub const SCENARIOS: [Scenario; 5] = [
    Scenario {
        suite: "rain",
        preset: (
            "rainy-drive",
            "driving in rain: drops, a fogged pane, a wet film, and lights that glare",
        ),
        faults: &["drops", "condensation", "film", "glare"],
    },
    Scenario {
        suite: "winter",
        preset: (
            "winter-morning",
            "a winter morning: ice that was not scraped off, breath on the pane, and road salt",
        ),
        faults: &["frost", "condensation", "dust"],
    },
    Scenario {
        suite: "night",
        preset: (
            "night-drive",
            "driving at night: few photons, a long exposure, bright lamps, and a worn, greasy pane",
        ),
        faults: &["film", "scratches", "shake", "glare", "exposure", "noise"],
    },
    Scenario {
        suite: "car-wash",
        preset: (
            "car-wash",
            "in a car wash: water that runs down, drops, and foam",
        ),
        faults: &["film", "drops"],
    },
    Scenario {
        suite: "desert",
        preset: (
            "desert-track",
            "a track in the desert: dust, scratches of sand, a camera that shakes, and too much light",
        ),
        faults: &["dust", "scratches", "shake", "exposure"],
    },
];

/// All presets with what each is for: first those that break glass, then those of other faults, then scenarios.
pub fn presets() -> impl Iterator<Item = (&'static str, &'static str)> + Clone {
    let faults = FAULTS
        .iter()
        .flat_map(|fault| fault.presets.iter().copied());
    let scenarios = SCENARIOS.iter().map(|scenario| scenario.preset);
    super::PRESETS.into_iter().chain(faults).chain(scenarios)
}
