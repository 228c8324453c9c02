//! The way to the computer: what a frame of codes becomes, beside the closed forms of its laws.
#![expect(clippy::unwrap_used, reason = "a test may panic")]
#![expect(clippy::cast_possible_truncation, reason = "small numbers")]

use starbreak_seed::Seed;
use starbreak_sensor::{Code, Codes, Fault, Filters, FrameState, Frames, Link, Moment, Sensor};

const SOUND: Link = Link {
    row_bits: 16,
    bit_error_rate: 0.0,
    jpeg_quality: 0,
};

fn sent(link: Link, samples: &[u8], size: (usize, usize), n_channels: usize, seed: u64) -> Vec<u8> {
    let mut samples = samples.to_vec();
    let mut codes = Codes::new(&mut samples, size, n_channels).unwrap();
    let sensor = Sensor::of(link);
    let light_of = |code: u8| f32::from(code) / 255.0;
    sensor
        .over_codes(&mut codes, light_of, Seed(seed).into())
        .unwrap();
    samples
}

#[test]
fn wrong_bits_are_binomial_and_leave_alpha() {
    let size = (200, 100);
    let samples = vec![0x5A_u8; size.0 * size.1 * 4];
    let link = Link {
        bit_error_rate: 1e-3,
        ..SOUND
    };
    let expected = 200.0 * 100.0 * 24.0 * 1e-3;
    let (mut sum, mut squares, mut by_bit) = (0.0, 0.0, [0_u32; 8]);
    let n = 300_u64;
    for seed in 0..n {
        let after = sent(link, &samples, size, 4, seed);
        let mut n_wrong = 0.0;
        for (k, code) in after.iter().enumerate() {
            let wrong = code ^ 0x5A;
            assert!(k % 4 != 3 || wrong == 0, "alpha stays");
            n_wrong += f64::from(wrong.count_ones());
            for (bit, n) in by_bit.iter_mut().enumerate() {
                *n += u32::from(wrong >> bit & 1);
            }
        }
        sum += n_wrong;
        squares += n_wrong * n_wrong;
    }
    let mean = sum / n as f64;
    let variance = squares / n as f64 - mean * mean;
    assert!(
        (mean - expected).abs() < 4.0 * (expected / n as f64).sqrt(),
        "{mean} of {expected}"
    );
    // Within four of its standard deviations, √(2/n).
    assert!(
        (variance / expected - 1.0).abs() < 4.0 * (2.0 / n as f64).sqrt(),
        "{variance}"
    );
    for n_wrong in by_bit {
        let each = sum / 8.0;
        assert!(
            (f64::from(n_wrong) - each).abs() < 4.0 * each.sqrt(),
            "{by_bit:?}"
        );
    }
}

#[test]
fn rows_that_lack_address_bits_are_those_of_the_rest() {
    let size = (5, 40);
    let samples: Vec<u8> = (0..200_u8).collect();
    let link = Link {
        row_bits: 3,
        ..SOUND
    };
    let after = sent(link, &samples, size, 1, 1);
    for (y, row) in after.chunks_exact(5).enumerate() {
        let from = (y % 8) * 5;
        assert_eq!(row, &samples[from..from + 5], "row {y}");
    }
}

#[test]
fn codes_of_16_bits_pass_jpeg_by_their_upper_byte() {
    let size = (32, 32);
    let low: Vec<u8> = (0..32 * 32 * 3).map(|k| (k * 7 % 256) as u8).collect();
    let link = Link {
        jpeg_quality: 40,
        ..SOUND
    };
    let after = sent(link, &low, size, 3, 1);
    assert_ne!(after, low, "something is lost");
    let mut wide: Vec<u16> = low.iter().map(|code| u16::of_byte(*code)).collect();
    let mut codes = Codes::new(&mut wide, size, 3).unwrap();
    let light_of = |code: u16| f32::from(code) / 65_535.0;
    Sensor::of(link)
        .over_codes(&mut codes, light_of, Seed(1).into())
        .unwrap();
    let again: Vec<u16> = after.iter().map(|code| u16::of_byte(*code)).collect();
    assert_eq!(wide, again, "the same picture");
    let mut line = vec![0_u8; 70_000];
    let mut codes = Codes::new(&mut line, (70_000, 1), 1).unwrap();
    let refused = Sensor::of(link).over_codes(&mut codes, |_| 0.0, Seed(1).into());
    let refused = refused.unwrap_err().to_string();
    assert!(
        refused.contains("70000 x 1 px") && refused.contains("link.jpeg_quality"),
        "{refused}"
    );
}

#[test]
fn bad_frames_are_as_many_and_as_long_as_asked() {
    let frames = Frames {
        black: 0.1,
        white: 0.02,
        frozen: 0.06,
        dropped: 0.02,
        burst_frames: 5.0,
    };
    let (mut counts, mut n_bursts, n) = ([0_u32; 5], 0_u32, 400_u32);
    for clip in 0..n {
        let mut was_bad = false;
        for idx in 0..500 {
            let state = frames.of(Seed(clip.into()), idx);
            counts[state as usize] += 1;
            let is_bad = state != FrameState::Good;
            n_bursts += u32::from(is_bad && !was_bad);
            was_bad = is_bad;
        }
    }
    let all = f64::from(n * 500);
    for (share, n) in [0.8, 0.1, 0.02, 0.06, 0.02].into_iter().zip(counts) {
        // Frames of a burst come together: as many as all/7 draws, of which each has its chance.
        let error = (share * (1.0 - share) * 8.0 / all).sqrt();
        assert!(
            (f64::from(n) / all - share).abs() < 4.0 * error,
            "{counts:?}"
        );
    }
    let bad: u32 = counts[1..].iter().sum();
    let length = f64::from(bad) / f64::from(n_bursts);
    assert!((length - 5.0).abs() < 0.25, "{length} frames in a row");
    // Each for itself, where that is as short as can be: runs of 1/(1 − p).
    let single = Frames {
        burst_frames: 1.0,
        ..frames
    };
    let states: Vec<bool> = (0..40_000)
        .map(|idx| single.of(Seed(3), idx) != FrameState::Good)
        .collect();
    let n_bad = states.iter().filter(|it| **it).count();
    let n_runs = states.windows(2).filter(|two| !two[0] && two[1]).count();
    let length = n_bad as f64 / n_runs as f64;
    assert!((length - 1.25).abs() < 0.03, "{length} frames in a row");
    let all = Frames {
        black: 1.0,
        white: 0.0,
        frozen: 0.0,
        dropped: 0.0,
        burst_frames: 1.0,
    };
    assert!(
        (0..50).all(|idx| all.of(Seed(1), idx) == FrameState::Black),
        "all"
    );
}

#[test]
fn blank_frames_are_blank_and_faults_begin_when_they_should() {
    let frames = Frames {
        black: 0.0,
        white: 1.0,
        frozen: 0.0,
        dropped: 0.0,
        burst_frames: 1.0,
    };
    let sensor = Sensor::new(
        0,
        vec![
            (2.0, frames.into()),
            (1.0, Fault::from(Filters { loss: 1.0 })),
        ],
    );
    for (time_s, n_faults) in [(0.5, 0), (1.0, 1), (3.0, 2)] {
        assert_eq!(sensor.at(time_s).faults().len(), n_faults, "{time_s} s");
        let at = Moment {
            time_s,
            ..Seed(1).into()
        };
        let is_reached = sensor.reach((3, 3), (3, 8), at).contains(&true);
        assert_eq!(is_reached, n_faults > 0, "{time_s} s");
    }
    let mut samples = [7_u8; 16];
    let mut codes = Codes::new(&mut samples, (2, 2), 4).unwrap();
    sensor
        .over_codes(&mut codes, |_| 0.0, Seed(1).into())
        .unwrap();
    assert_eq!(
        samples,
        [255, 255, 255, 7].repeat(4).as_slice(),
        "white, but for alpha"
    );
}

/// Masks are told by what changes.
#[test]
fn only_what_may_change_is_reached() {
    let (width, height) = (40, 50);
    let link = |row_bits, bit_error_rate| Link {
        row_bits,
        bit_error_rate,
        jpeg_quality: 0,
    };
    for (link, n_colors) in [
        (link(5, 0.0), 3),
        (link(16, 0.001), 3),
        (link(16, 0.001), 1),
        (link(10, 0.0), 1),
    ] {
        let before: Vec<u8> = (0..width * height * n_colors)
            .map(|k| ((k * 31 + k / 97) % 256) as u8)
            .collect();
        let after = sent(link, &before, (width, height), n_colors, 3);
        let reached = Sensor::of(link).reach((width, height), (n_colors, 8), Seed(3).into());
        let pixels = before
            .chunks_exact(n_colors)
            .zip(after.chunks_exact(n_colors));
        for (at, ((before, after), is_reached)) in pixels.zip(reached).enumerate() {
            let may = is_reached || before == after;
            assert!(may, "{at} changes unsaid");
            // A wrong bit always changes a code; another row may have the same.
            assert!(
                link.bit_error_rate == 0.0 || is_reached == (before != after),
                "{at} is said to change"
            );
            assert!(
                link.row_bits == 16 || is_reached == (at / width >= 1 << link.row_bits),
                "{at}: rows"
            );
        }
    }
}
