//! No bytes, however broken, make the reader panic.

use crate::common;

use common::{all_modes, jpeg_with, ramp};
use proptest::prelude::*;
use proptest::sample::Index;
use starbreak_dataset::{Encoding, ImageLimits, Provenance, decode_image, encode_image};

/// Small limits, so that a mutated header does not slow the test down.
const LIMITS: ImageLimits = ImageLimits {
    max_side_px: 2000,
    max_pixels: 400_000,
    max_file_bytes: 1 << 20,
};

fn seeds() -> Vec<Vec<u8>> {
    let image = ramp(40, 24);
    let mut seeds: Vec<_> = all_modes(11, 6)
        .iter()
        .filter_map(|mode| encode_image(mode, &Encoding::Png, Some(b"profile")).ok())
        .collect();
    seeds.push(jpeg_with(&image, |_| {}));
    seeds.push(jpeg_with(&image, |e| e.set_progressive(true)));
    seeds.push(jpeg_with(&image, |e| {
        e.set_sampling_factor(jpeg_encoder::SamplingFactor::F_2_2)
    }));
    seeds.push(jpeg_with(&image, |e| e.set_restart_interval(2)));
    for format in [image::ImageFormat::WebP, image::ImageFormat::Bmp] {
        let mut bytes = std::io::Cursor::new(Vec::new());
        if image.write_to(&mut bytes, format).is_ok() {
            seeds.push(bytes.into_inner());
        }
    }
    seeds
}

/// Recomputes the checksums of PNG chunks, so that a mutation reaches the code behind them.
fn repair_checksums(bytes: &mut [u8]) {
    let mut at = 8;
    while let Some(head) = bytes.get(at..at + 4) {
        let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
        let Some(body) = bytes.get(at + 4..(at + 8).saturating_add(length)) else {
            return;
        };
        let crc = body.iter().fold(u32::MAX, |crc, &byte| {
            (0..8).fold(crc ^ u32::from(byte), |crc, _| {
                (crc >> 1) ^ (0xedb8_8320 * (crc & 1))
            })
        });
        at += 8 + length;
        match bytes.get_mut(at..at + 4) {
            Some(place) => place.copy_from_slice(&(!crc).to_be_bytes()),
            None => return,
        }
        at += 4;
    }
}

proptest! {
    // Found cases become named tests, not files.
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes(bytes in prop::collection::vec(any::<u8>(), 0..600), head in 0..5usize) {
        let heads = [&b""[..], b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff", b"RIFF\xff\0\0\0WEBPVP8 ", b"BM\xff\0\0\0\0\0\0\0"];
        let head: &[u8] = heads[head];
        let _ = decode_image("x", &[head, &bytes].concat(), &LIMITS);
        let _ = Provenance::from_bytes(&bytes);
    }

    #[test]
    fn mutated_files(
        seed in any::<Index>(),
        edits in prop::collection::vec((any::<Index>(), any::<u8>()), 1..6),
        cut in prop::option::of(any::<Index>()),
        repair in any::<bool>(),
    ) {
        let seeds = seeds();
        let mut bytes = seed.get(&seeds).clone();
        for (at, value) in edits {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Some(cut) = cut {
            let end = cut.index(bytes.len());
            bytes.truncate(end);
        }
        if repair {
            repair_checksums(&mut bytes);
        }
        if let Err(error) = decode_image("x", &bytes, &LIMITS) {
            let message = error.to_string();
            prop_assert!(!message.chars().any(char::is_control), "{:?}", message);
        }
    }
}
