//! The tables of a recipe that turn a fault of the camera on: one that is there is a fault that is there.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The faults behind the lens, in the order in which light meets them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(super) struct FaultTables {
    /// Too much light, or too little. Without this table the exposure is right.
    #[schemars(with = "ExposureTable")]
    pub(super) exposure: Option<ExposureTable>,
    /// Lamps on the mains, whose light pulses: bands across the picture. Without this table there are none.
    #[schemars(with = "BandingTable")]
    pub(super) banding: Option<BandingTable>,
    /// Noise of the sensor, added to that of the image. Without this table there is none.
    #[schemars(with = "NoiseTable")]
    pub(super) noise: Option<NoiseTable>,
    /// Defective pixels. Without this table there are none.
    #[schemars(with = "PixelsTable")]
    pub(super) pixels: Option<PixelsTable>,
    /// Defective rows and columns. Without this table there are none.
    #[schemars(with = "LinesTable")]
    pub(super) lines: Option<LinesTable>,
    /// Which sensor it is. Without this table it is number 0.
    #[schemars(with = "SensorTable")]
    pub(super) sensor: Option<SensorTable>,
}

/// Too much light, or too little.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ExposureTable {
    /// Steps of a factor of 2 away from the image's own exposure, -10 to 10; below 0 it is darker. 0: none.
    #[schemars(range(min = -10.0, max = 10.0))]
    pub(super) ev: f64,
    /// Electrons that a green pixel held where the image is white, 1 to 1000000. A darker frame has fewer, and so more
    /// noise; [noise] says it instead if it is there.
    #[schemars(range(min = 1.0, max = 1e6))]
    pub(super) white_e: f64,
    /// Standard deviation of the reading of a pixel, electrons, 0 to 1000. With white_e it says how much noise a darker
    /// frame has.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub(super) read_e: f64,
}

/// Lamps on the mains.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct BandingTable {
    /// How far the light of the lamps goes up and down, a share of its mean, 0 (none) to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub(super) depth: f64,
    /// Frequency of the mains, Hz, 1 to 1000; light pulses twice as often.
    #[schemars(range(min = 1.0, max = 1000.0))]
    pub(super) mains_hz: f64,
    /// From the beginning of a row to that of the next, us, 0.1 to 1000. Bands are 1/(2 mains_hz row_us) rows high.
    #[schemars(range(min = 0.1, max = 1000.0))]
    pub(super) row_us: f64,
    /// How long a row is exposed, ms, 0.001 to 1000. Of whole pulses nothing is seen.
    #[schemars(range(min = 0.001, max = 1000.0))]
    pub(super) exposure_ms: f64,
}

/// Noise of the sensor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct NoiseTable {
    /// Electrons that a green pixel holds where the image is white, 1 or more; inf: no noise at all.
    #[schemars(extend("minimum" = 1.0))]
    pub(super) white_e: f64,
    /// Standard deviation of the reading of a pixel, electrons, 0 to 1000.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub(super) read_e: f64,
    /// The same of a whole row, electrons, 0 to 1000.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub(super) row_e: f64,
    /// Standard deviation of the pixels' sensitivities (PRNU), percent, 0 to 50; fixed in the sensor.
    #[schemars(range(min = 0.0, max = 50.0))]
    pub(super) prnu_percent: f64,
    /// Standard deviation of the pixels' offsets (DSNU), electrons, 0 to 10000; fixed in the sensor.
    #[schemars(range(min = 0.0, max = 1e4))]
    pub(super) dsnu_e: f64,
    /// Dark current at 25 C, electrons per second, 0 to 1000000.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub(super) dark_e_s: f64,
    /// Temperature of the sensor, C, -60 to 150.
    #[schemars(range(min = -60.0, max = 150.0))]
    pub(super) temperature_c: f64,
    /// How much warmer it has to be for twice the dark current, K, 1 to 50.
    #[schemars(range(min = 1.0, max = 50.0))]
    pub(super) doubling_k: f64,
    /// Exposure of a frame, ms, 0.001 to 100000, in which the dark current gathers.
    #[schemars(range(min = 0.001, max = 1e5))]
    pub(super) exposure_ms: f64,
}

/// Defective pixels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PixelsTable {
    /// Black ones, per million, 0 to 1000000.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub(super) dead_per_mpx: f64,
    /// Such as add light of their own, per million, 0 to 1000000.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub(super) hot_per_mpx: f64,
    /// Such as always show the same, somewhere between black and white, per million, 0 to 1000000.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub(super) stuck_per_mpx: f64,
    /// What a hot pixel adds in the mean, 0 to 1 (white); it falls exponentially from pixel to pixel.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub(super) hot_level: f64,
}

/// Defective rows and columns.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LinesTable {
    /// Rows, 0 to 1000.
    #[schemars(range(min = 0, max = 1000))]
    pub(super) rows: u32,
    /// Columns, 0 to 1000.
    #[schemars(range(min = 0, max = 1000))]
    pub(super) columns: u32,
    /// What they show, 0 (black) to 1 (white).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub(super) level: f64,
}

/// Which sensor it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SensorTable {
    /// Its number, 0 to 1000000: what is fixed in a sensor (defects, PRNU, DSNU) is drawn from it, so all images of a camera
    /// have it in the same places.
    #[schemars(range(min = 0, max = 1_000_000))]
    pub(super) number: u64,
}
