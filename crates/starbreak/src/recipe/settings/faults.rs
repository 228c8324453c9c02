//! Settings of the faults behind the lens, in SI units.

use starbreak_sensor::{Exposure, Lamps, Lines, Noise, Pixels, Sensor};

use super::super::tables::{FaultTables, PixelsTable};

/// The sensor with its faults; none where there are none, or all of them are nothing.
pub(super) fn settings(given: &FaultTables) -> Option<Sensor> {
    let sensor = Sensor {
        exposure: given.exposure.filter(|it| it.ev != 0.0).map(|it| Exposure {
            ev: it.ev,
            white_e: it.white_e,
            read_e: it.read_e,
        }),
        lamps: given.banding.filter(|it| it.depth > 0.0).map(|it| Lamps {
            mains_hz: it.mains_hz,
            depth: it.depth,
            row_s: it.row_us * 1e-6,
            exposure_s: it.exposure_ms * 1e-3,
        }),
        noise: given
            .noise
            .filter(|it| it.white_e.is_finite())
            .map(|it| Noise {
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
        pixels: given.pixels.filter(has_defects).map(|it| Pixels {
            dead_per_mpx: it.dead_per_mpx,
            hot_per_mpx: it.hot_per_mpx,
            stuck_per_mpx: it.stuck_per_mpx,
            hot_level: it.hot_level,
        }),
        lines: given
            .lines
            .filter(|it| it.rows + it.columns > 0)
            .map(|it| Lines {
                rows: it.rows,
                columns: it.columns,
                level: it.level,
            }),
        number: given.sensor.map_or(0, |it| it.number),
    };
    (!sensor.is_sound()).then_some(sensor)
}

fn has_defects(given: &PixelsTable) -> bool {
    given.dead_per_mpx + given.hot_per_mpx + given.stuck_per_mpx > 0.0
}
