//! The tables of a recipe that turn a fault of the camera on: one that is there is a fault that is there.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The faults behind the lens, in the order in which light meets them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(super) struct FaultTables {
    /// Too much light, or too little. Without this table the exposure is right.
    #[schemars(with = "ExposureTable")]
    pub(super) exposure: Option<ExposureTable>,
    /// Lamps whose light pulses: bands across the picture. Without this table there are none.
    #[schemars(with = "BandingTable")]
    pub(super) banding: Option<BandingTable>,
    /// Dust on the sensor's cover. Without this table there is none.
    #[schemars(with = "SpotsTable")]
    pub(super) spots: Option<SpotsTable>,
    /// Color filters that are lost. Without this table none is.
    #[schemars(with = "CfaTable")]
    pub(super) cfa: Option<CfaTable>,
    /// Noise of the sensor, added to that of the image. Without this table there is none.
    #[schemars(with = "NoiseTable")]
    pub(super) noise: Option<NoiseTable>,
    /// Defective pixels. Without this table there are none.
    #[schemars(with = "PixelsTable")]
    pub(super) pixels: Option<PixelsTable>,
    /// Defective rows and columns. Without this table there are none.
    #[schemars(with = "LinesTable")]
    pub(super) lines: Option<LinesTable>,
    /// Rows whose colors are not interpolated. Without this table all are.
    #[schemars(with = "MosaicTable")]
    pub(super) mosaic: Option<MosaicTable>,
    /// Stages of the image processor that are left out. Without this table none is.
    #[schemars(with = "IspTable")]
    pub(super) isp: Option<IspTable>,
    /// Faults of the way to the computer. Without this table all arrives as it was sent.
    #[schemars(with = "LinkTable")]
    pub(super) link: Option<LinkTable>,
    /// Frames that do not arrive. Without this table all do.
    #[schemars(with = "FramesTable")]
    pub(super) frames: Option<FramesTable>,
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
    /// Time of a clip at which it begins, s, 0 to 1000000; pictures by themselves have it.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub(super) onset_s: f64,
}

/// Lamps that pulse.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct BandingTable {
    /// How far the light of the lamps goes up and down, a share of its mean, 0 (none) to 1; of LEDs their share of all
    /// light.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub(super) depth: f64,
    /// Frequency of the mains, Hz, 1 to 1000; light pulses twice as often.
    #[schemars(range(min = 1.0, max = 1000.0))]
    pub(super) mains_hz: f64,
    /// Share of the time in which LEDs are lit, 0.001 to 1; 0: no LEDs, but lamps on the mains.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub(super) led_duty: f64,
    /// Pulses of LEDs, Hz, 1 to 100000.
    #[schemars(range(min = 1.0, max = 1e5))]
    pub(super) led_hz: f64,
    /// From the beginning of a row to that of the next, us, 0.1 to 1000. A band is as many rows high as begin in a
    /// pulse: 338 of 29.6 us at 50 Hz.
    #[schemars(range(min = 0.1, max = 1000.0))]
    pub(super) row_us: f64,
    /// How long a row is exposed, ms, 0.001 to 1000. Of whole pulses nothing is seen.
    #[schemars(range(min = 0.001, max = 1000.0))]
    pub(super) exposure_ms: f64,
    /// Time of a clip at which it begins, s, 0 to 1000000; pictures by themselves have it.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub(super) onset_s: f64,
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
    /// Time of a clip at which it begins, s, 0 to 1000000; pictures by themselves have it.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub(super) onset_s: f64,
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
    /// Time of a clip at which it begins, s, 0 to 1000000; pictures by themselves have it.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub(super) onset_s: f64,
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
    /// Time of a clip at which it begins, s, 0 to 1000000; pictures by themselves have it.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub(super) onset_s: f64,
}

/// Dust on the sensor's cover.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SpotsTable {
    /// Grains before the frame, 0 to 1000; beside it lie as many to each area.
    #[schemars(range(min = 0, max = 1000))]
    pub(super) count: u32,
    /// Diameter of a grain, um, 1 to 1000.
    #[schemars(range(min = 1.0, max = 1000.0))]
    pub(super) size_um: f64,
    /// From the cover to the pixels, mm, 0.01 to 10. A shadow is size + height/f_number wide, 500 px at most.
    #[schemars(range(min = 0.01, max = 10.0))]
    pub(super) height_mm: f64,
    /// Focal length over the diameter of the pupil, 0.7 to 32.
    #[schemars(range(min = 0.7, max = 32.0))]
    pub(super) f_number: f64,
    /// From pixel to pixel, um, 0.5 to 50.
    #[schemars(range(min = 0.5, max = 50.0))]
    pub(super) pitch_um: f64,
    /// Time of a clip at which it begins, s, 0 to 1000000; pictures by themselves have it.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub(super) onset_s: f64,
}

/// Color filters that are lost.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct CfaTable {
    /// Share of the filters, 0 (none is lost) to 1 (no color is left). Gray images stay as they are.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub(super) loss: f64,
    /// Time of a clip at which it begins, s, 0 to 1000000; pictures by themselves have it.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub(super) onset_s: f64,
}

/// What pixels show whose colors are not interpolated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawWord {
    /// What they saw, as gray.
    Gray,
    /// What they saw, in its color.
    Color,
}

/// Rows whose colors are not interpolated.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MosaicTable {
    /// Share of the rows, 0 to 1; they follow each other, from a random row on. Gray images stay as they are.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub(super) share: f64,
    /// What a pixel shows there: "gray", or "color" where it keeps its own and lacks the others.
    pub(super) shows: RawWord,
    /// Time of a clip at which it begins, s, 0 to 1000000; pictures by themselves have it.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub(super) onset_s: f64,
}

/// Stages of the image processor that are left out.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct IspTable {
    /// Black level that is not taken away, percent of white, 0 to 25.
    #[schemars(range(min = 0.0, max = 25.0))]
    pub(super) black_level_percent: f64,
    /// Share of the white balance that is left out, 0 to 1. Gray images have none.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub(super) white_balance: f64,
    /// Share of the color matrix that is left out, 0 to 1. Gray images have none.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub(super) color_matrix: f64,
    /// Amount of sharpening that is taken back, 0 to 5.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub(super) unsharp: f64,
    /// Share of the tone curve that is left out, 0 to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub(super) tone: f64,
    /// Time of a clip at which it begins, s, 0 to 1000000; pictures by themselves have it.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub(super) onset_s: f64,
}

/// Faults of the way to the computer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LinkTable {
    /// Share of the bits that arrive wrong, 0 to 0.01.
    #[schemars(range(min = 0.0, max = 0.01))]
    pub(super) bit_error_rate: f64,
    /// Quality of JPEG that the picture passes on its way, 1 to 100; 0: none. Of 16 bits 8 are left.
    #[schemars(range(min = 0, max = 100))]
    pub(super) jpeg_quality: u8,
    /// Bits of a row's address that arrive, 1 to 16: row y shows row y mod 2^bits. 16: all.
    #[schemars(range(min = 1, max = 16))]
    pub(super) row_bits: u32,
    /// Time of a clip at which it begins, s, 0 to 1000000; pictures by themselves have it.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub(super) onset_s: f64,
}

/// Frames that do not arrive.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct FramesTable {
    /// Share of the frames that is black, 0 to 1. Shares that are more than 1 together are cut in the order of the keys.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub(super) black: f64,
    /// Share of the frames that is white, 0 to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub(super) white: f64,
    /// Share of a clip's frames in which the camera repeats the last good one, 0 to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub(super) frozen: f64,
    /// Share of a clip's frames that is lost on the way, 0 to 1: the last good one is still seen.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub(super) dropped: f64,
    /// How many bad frames of a clip follow each other in the mean, 1 to 1000; 1/(1 - the share of bad frames) at least.
    #[schemars(range(min = 1.0, max = 1000.0))]
    pub(super) burst_frames: f64,
    /// Time of a clip at which it begins, s, 0 to 1000000; pictures by themselves have it.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub(super) onset_s: f64,
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
