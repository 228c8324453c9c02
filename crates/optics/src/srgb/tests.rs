//! Against the formula by `libm`, which the tables do not use.

use super::{
    BINS, DECODE8, bin8, code16_of_light, decode8, decode16, encode8, encode16, light_of_code16,
};

/// Light of an encoded value, by the standard's formula.
fn reference_light(encoded: f64) -> f64 {
    if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        libm::pow((encoded + 0.055) / 1.055, 2.4)
    }
}

/// Encoded value of light, by the standard's formula.
fn reference_encoded(light: f64) -> f64 {
    if light <= 0.0031308 {
        12.92 * light
    } else {
        1.055 * libm::pow(light, 1.0 / 2.4) - 0.055
    }
}

/// Light on a fine grid, denser in the dark, and beside every bin's edge.
fn much_light() -> impl Iterator<Item = f32> {
    let ramp = (0..2_000_000_u32).map(|step| {
        let s = f64::from(step) / 2e6;
        s * s
    });
    let edges = (0..=BINS).map(|bin| f64::from(u32::try_from(bin).unwrap_or(0)) / 4096.0);
    #[expect(clippy::cast_possible_truncation, reason = "light to try")]
    let to_f32 = |light: f64| light as f32;
    ramp.chain(edges).flat_map(move |light| {
        let light = to_f32(light);
        [light.next_down(), light, light.next_up()]
    })
}

#[test]
fn every_8_bit_code_comes_back() {
    for code in 0..=u8::MAX {
        assert_eq!(encode8(decode8(code)), code, "code {code}");
    }
}

#[test]
fn every_16_bit_code_comes_back() {
    for code in 0..=u16::MAX {
        assert_eq!(encode16(decode16(code)), code, "code {code}");
    }
}

#[test]
fn decoding_is_the_standards_formula() {
    for code in 0..=u8::MAX {
        let exact = reference_light(f64::from(code) / 255.0);
        let error = (f64::from(decode8(code)) - exact).abs();
        assert!(error <= exact * 6e-8, "code {code}: {error:e} off");
    }
    for code in 0..=u16::MAX {
        let exact = reference_light(f64::from(code) / 65535.0);
        let error = (f64::from(decode16(code)) - exact).abs();
        assert!(error <= exact * 6e-8, "code {code}: {error:e} off");
    }
}

#[test]
fn known_codes_have_their_published_light() {
    // 18 % grey is code 118 (117.6), half is code 188 (187.5), 0.0031308 is the join at 10.3.
    for (light, code) in [(0.18, 118), (0.5, 188), (0.003_130_8, 10)] {
        assert_eq!(encode8(light), code, "light {light}");
    }
    assert!(
        (f64::from(DECODE8[128]) - 0.215_860_500).abs() < 1e-8,
        "code 128"
    );
}

#[test]
fn encoding_8_bits_rounds_the_formula_and_never_falls() {
    let mut worst = 0.0_f64;
    for light in much_light() {
        let exact = reference_encoded(f64::from(light).clamp(0.0, 1.0)) * 255.0;
        worst = worst.max((f64::from(encode8(light)) - exact).abs());
    }
    // The two branches of the standard meet only within 3e-8 of white.
    assert!(worst < 0.5 + 1e-4, "{worst} of a code off");
    let mut last = 0;
    for step in 0..=8_000_000_u32 {
        #[expect(clippy::cast_precision_loss, reason = "light to try")]
        let code = encode8(step as f32 / 8e6);
        assert!(code >= last, "at {step}");
        last = code;
    }
}

#[test]
fn a_code_by_itself_is_that_of_the_tables() {
    for code in 0..=u16::MAX {
        let light = decode16(code);
        let alone = light_of_code16(code);
        assert_eq!(alone.to_bits(), light.to_bits(), "light of {code}");
        // About the limits, too.
        for light in [light, light * 0.999_99, light * 1.000_01, light + 7.6e-6] {
            assert_eq!(code16_of_light(light), encode16(light), "code of {light}");
        }
    }
    for light in [f32::NAN, -1.0, 0.0, 1.0, 2.0] {
        assert_eq!(code16_of_light(light), encode16(light), "code of {light}");
    }
}

#[test]
fn encoding_16_bits_rounds_the_formula_and_never_falls() {
    let mut worst = 0.0_f64;
    for light in much_light() {
        let exact = reference_encoded(f64::from(light).clamp(0.0, 1.0)) * 65535.0;
        worst = worst.max((f64::from(encode16(light)) - exact).abs());
    }
    // One rounding of light to f32 is up to 6e-8/2.4 of 65535 codes near white; the branches of
    // the standard meet within 3e-8 · 65535.
    assert!(worst < 0.51, "{worst} of a code off");
    let mut last = 0;
    for step in 0..=4_000_000_u32 {
        #[expect(clippy::cast_precision_loss, reason = "light to try")]
        let code = encode16(step as f32 / 4e6);
        assert!(code >= last, "at {step}");
        last = code;
    }
}

#[test]
fn light_outside_0_to_1_gives_the_end_codes() {
    for light in [-1.0, -0.0, 0.0, f32::NEG_INFINITY, f32::NAN, 1e-30] {
        assert_eq!(encode8(light), 0, "8 bits of {light}");
        assert_eq!(encode16(light), 0, "16 bits of {light}");
    }
    for light in [1.0, 1.5, 1e30, f32::INFINITY] {
        assert_eq!(encode8(light), 255, "8 bits of {light}");
        assert_eq!(encode16(light), 65535, "16 bits of {light}");
    }
    assert_eq!(
        bin8(f32::INFINITY) as usize,
        BINS - 1,
        "the last bin takes the rest"
    );
}

#[test]
fn each_bin_holds_at_most_one_limit() {
    let narrowest = DECODE8
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .fold(f32::INFINITY, f32::min);
    assert!(narrowest > 1.0 / 4096.0, "narrowest step {narrowest}");
}

/// Run with `cargo test --release -p starbreak-optics srgb -- --ignored --nocapture`.
#[test]
#[ignore = "prints times"]
#[expect(clippy::print_stderr, reason = "times must be seen")]
fn times() {
    use std::hint::black_box;
    use std::time::Instant;
    let n = 1242 * 375 * 3_u32;
    #[expect(clippy::cast_precision_loss, reason = "light to try")]
    let light: Vec<f32> = (0..n)
        .map(|i| (i.wrapping_mul(2_654_435_761) >> 8) as f32 / 16_777_216.0)
        .collect();
    let mut bytes = vec![0_u8; light.len()];
    let mut words = vec![0_u16; light.len()];
    let mut back = vec![0_f32; light.len()];
    let mut best = [f64::INFINITY; 5];
    for _ in 0..20 {
        let mut lap = [0.0; 5];
        let start = Instant::now();
        for (code, &light) in bytes.iter_mut().zip(black_box(&light)) {
            *code = encode8(light);
        }
        lap[0] = start.elapsed().as_secs_f64();
        let start = Instant::now();
        for (light, &code) in back.iter_mut().zip(black_box(&bytes)) {
            *light = decode8(code);
        }
        lap[1] = start.elapsed().as_secs_f64();
        let start = Instant::now();
        for (code, &light) in words.iter_mut().zip(black_box(&light)) {
            *code = encode16(light);
        }
        lap[2] = start.elapsed().as_secs_f64();
        let start = Instant::now();
        for (light, &code) in back.iter_mut().zip(black_box(&words)) {
            *light = decode16(code);
        }
        lap[3] = start.elapsed().as_secs_f64();
        let start = Instant::now();
        for (code, &light) in bytes.iter_mut().zip(black_box(&light)) {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a code"
            )]
            let rounded = (reference_encoded(f64::from(light)) * 255.0 + 0.5) as u8;
            *code = rounded;
        }
        lap[4] = start.elapsed().as_secs_f64();
        black_box((&bytes, &words, &back));
        for (best, lap) in best.iter_mut().zip(lap) {
            *best = best.min(lap);
        }
    }
    for (name, seconds) in ["encode8", "decode8", "encode16", "decode16", "pow, 8 bits"]
        .into_iter()
        .zip(best)
    {
        eprintln!(
            "{name:12} {:6.2} ns per sample",
            seconds * 1e9 / f64::from(n)
        );
    }
}
