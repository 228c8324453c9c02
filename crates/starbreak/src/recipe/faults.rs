//! The faults of a camera beside broken glass: one line each.

/// A fault of the camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FaultKind {
    /// The table of a recipe that turns it on.
    pub table: &'static str,
    /// Its presets with what each is; the first says what a table leaves out.
    pub presets: &'static [(&'static str, &'static str)],
}

/// All of them, in the order in which light meets them.
pub const FAULTS: [FaultKind; 5] = [
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
        presets: &[(
            "banding",
            "lamps on the mains under a rolling shutter: bands across the picture",
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
];

/// All presets with what each is for: first those that break glass, then those of other faults.
pub fn presets() -> impl Iterator<Item = (&'static str, &'static str)> + Clone {
    let faults = FAULTS
        .iter()
        .flat_map(|fault| fault.presets.iter().copied());
    super::PRESETS.into_iter().chain(faults)
}
