//! Settings of the faults behind the lens, in SI units.

use starbreak_sensor::{Exposure, Lamps, Lines, Noise, Pixels, Sensor};

use super::super::tables::FaultTables;

/// The sensor with its faults; none where there are none, or all of them are nothing.
pub(super) fn settings(given: &FaultTables) -> Option<Sensor> {
    let sensor = Sensor {
        exposure: given.exposure.map(|it| Exposure {
            ev: it.ev,
            white_e: it.white_e,
            read_e: it.read_e,
        }),
        lamps: given.banding.map(|it| Lamps {
            mains_hz: it.mains_hz,
            depth: it.depth,
            row_s: it.row_us * 1e-6,
            exposure_s: it.exposure_ms * 1e-3,
        }),
        noise: given.noise.map(|it| Noise {
            white_e: it.white_e,
            read_e: it.read_e,
            row_e: it.row_e,
            prnu: it.prnu_percent / 100.0,
            dsnu_e: it.dsnu_e,
            dark_e_s: it.dark_e_s,
            doubling_k: it.doubling_k,
            temperature_c: it.temperature_c,
            exposure_s: it.exposure_ms * 1e-3,
        }),
        pixels: given.pixels.map(|it| Pixels {
            dead_per_mpx: it.dead_per_mpx,
            hot_per_mpx: it.hot_per_mpx,
            stuck_per_mpx: it.stuck_per_mpx,
            hot_level: it.hot_level,
        }),
        lines: given.lines.map(|it| Lines {
            rows: it.rows,
            columns: it.columns,
            level: it.level,
        }),
        number: given.sensor.map_or(0, |it| it.number),
    };
    sensor.faulty()
}
