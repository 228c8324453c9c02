//! Settings of the faults behind the lens, in SI units.

use starbreak_sensor::{
    Exposure, Fault, Filters, Frames, Isp, Lamps, Lines, Link, Noise, Pixels, Pulse, RawRows,
    Sensor, Spots,
};

use super::super::error::{Place, RecipeError};
use super::super::tables::{
    BandingTable, CfaTable, ExposureTable, FaultTables, FramesTable, IspTable, LinesTable,
    LinkTable, MosaicTable, NoiseTable, PixelsTable, RawWord, SpotsTable,
};
use super::out_of_range;

/// Wider shadows are no spots, but a loss of light everywhere.
const MAX_SHADOW_PX: f64 = 500.0;

/// The sensor with its faults, without those that are nothing.
pub(super) fn settings(place: &Place, given: &FaultTables) -> Result<Sensor, RecipeError> {
    if let Some(it) = &given.banding
        && it.led_duty > 0.0
        && it.led_duty < 0.001
    {
        let key = "banding.led_duty";
        return Err(out_of_range(
            place,
            key,
            it.led_duty,
            "0.001 to 1, or 0: no LEDs",
        ));
    }
    if let Some(it) = &given.spots {
        let width_px = 2.0 * spots(*it).reach_px();
        if width_px > MAX_SHADOW_PX {
            let key = "(spots.size_um + 1000 spots.height_mm / spots.f_number) / spots.pitch_um";
            return Err(out_of_range(
                place,
                key,
                width_px.round(),
                "at most 500 px, the width of a shadow",
            ));
        }
    }
    // A table and the fault that it is.
    macro_rules! faults {
        ($($table:ident: $of:ident),*) => {
            [$(given.$table.map(|it| (it.onset_s, Fault::from($of(it))))),*]
        };
    }
    let faults = faults!(
        exposure: exposure, banding: lamps, spots: spots, cfa: filters, noise: noise, pixels: pixels,
        lines: lines, mosaic: raw_rows, isp: isp, link: link, frames: frames
    );
    let number = given.sensor.map_or(0, |it| it.number);
    Ok(Sensor::new(number, faults.into_iter().flatten().collect()).faulty())
}

fn exposure(it: ExposureTable) -> Exposure {
    Exposure {
        ev: it.ev,
        white_e: it.white_e,
        read_e: it.read_e,
    }
}

fn lamps(it: BandingTable) -> Lamps {
    Lamps {
        pulse: if it.led_duty > 0.0 {
            Pulse::Led {
                pulses_hz: it.led_hz,
                duty: it.led_duty,
            }
        } else {
            Pulse::Mains {
                mains_hz: it.mains_hz,
            }
        },
        depth: it.depth,
        row_s: it.row_us * 1e-6,
        exposure_s: it.exposure_ms * 1e-3,
    }
}

fn spots(it: SpotsTable) -> Spots {
    Spots {
        count: it.count,
        diameter_m: it.size_um * 1e-6,
        height_m: it.height_mm * 1e-3,
        f_number: it.f_number,
        pitch_m: it.pitch_um * 1e-6,
    }
}

fn filters(it: CfaTable) -> Filters {
    Filters { loss: it.loss }
}

fn noise(it: NoiseTable) -> Noise {
    Noise {
        white_e: it.white_e,
        read_e: it.read_e,
        row_e: it.row_e,
        prnu: it.prnu_percent / 100.0,
        dsnu_e: it.dsnu_e,
        dark_e_s: it.dark_e_s,
        doubling_k: it.doubling_k,
        temperature_c: it.temperature_c,
        exposure_s: it.exposure_ms * 1e-3,
    }
}

fn pixels(it: PixelsTable) -> Pixels {
    Pixels {
        dead_per_mpx: it.dead_per_mpx,
        hot_per_mpx: it.hot_per_mpx,
        stuck_per_mpx: it.stuck_per_mpx,
        hot_level: it.hot_level,
    }
}

fn lines(it: LinesTable) -> Lines {
    Lines {
        rows: it.rows,
        columns: it.columns,
        level: it.level,
    }
}

fn raw_rows(it: MosaicTable) -> RawRows {
    RawRows {
        share: it.share,
        is_colored: it.shows == RawWord::Color,
    }
}

fn isp(it: IspTable) -> Isp {
    Isp {
        black_level: it.black_level_percent / 100.0,
        white_balance: it.white_balance,
        color_matrix: it.color_matrix,
        unsharp: it.unsharp,
        tone: it.tone,
    }
}

fn link(it: LinkTable) -> Link {
    Link {
        row_bits: it.row_bits,
        bit_error_rate: it.bit_error_rate,
        jpeg_quality: it.jpeg_quality,
    }
}

fn frames(it: FramesTable) -> Frames {
    Frames {
        black: it.black,
        white: it.white,
        frozen: it.frozen,
        dropped: it.dropped,
        burst_frames: it.burst_frames,
    }
}
