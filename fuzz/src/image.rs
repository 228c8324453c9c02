use starbreak_dataset::{
    Encoding, ImageLimits, decode_array, decode_image, encode_array_f64, encode_image,
};

use crate::Vocabulary;

/// Words of headers, and values that sit on an edge.
pub(crate) const VOCABULARY: Vocabulary = &[
    "IHDR",
    "PLTE",
    "tRNS",
    "IDAT",
    "IEND",
    "eXIf",
    "iCCP",
    "acTL",
    "fcTL",
    "fdAT",
    "sBIT",
    "\u{0}\u{0}\u{0}\u{1}",
    "\u{0}\u{0}\u{0}\u{0}",
    "\u{7f}\u{7f}\u{7f}\u{7f}",
    "Exif\u{0}\u{0}II*\u{0}",
    "MM\u{0}*",
    "Adobe",
    "ICC_PROFILE\u{0}",
    "'descr': '<f4'",
    "'shape': (3, 4, 2)",
    "'shape': (99999999999, 9999999999)",
    "'fortran_order': True",
    "'<f2'",
    "'>f8'",
    "'|O'",
];

/// Small limits, so that a header does not take the time of many inputs.
const LIMITS: ImageLimits = ImageLimits {
    max_side_px: 2000,
    max_pixels: 400_000,
    max_file_bytes: 1 << 20,
};

/// An image (PNG or JPEG) or an array of NumPy is refused with one printable line, or has the pixels
/// or values that it has after it was written and read again. Checksums of PNG are made good, so
/// that what lies behind them is reached.
///
/// # Panics
/// If the input is a finding.
pub fn image(bytes: &[u8]) {
    if bytes.starts_with(b"\x93NUMPY") {
        return array(bytes);
    }
    let mut mended = bytes.to_vec();
    mend_checksums(&mut mended);
    for bytes in [bytes, &mended] {
        let image = match decode_image("fuzz", bytes, &LIMITS) {
            Ok(image) => image,
            Err(error) => {
                is_one_line(&error.to_string());
                assert!(
                    !error.to_string().contains("breaks the decoder"),
                    "the decoder panicked"
                );
                continue;
            }
        };
        let profile = image.icc_profile.as_deref();
        let Ok(written) = encode_image(&image.pixels, &Encoding::Png, profile) else {
            continue;
        };
        match decode_image("again", &written, &LIMITS) {
            Ok(again) => assert_eq!(again.pixels, image.pixels, "written and read again"),
            Err(error) => panic!("does not read what it wrote: {error}"),
        }
    }
}

fn array(bytes: &[u8]) {
    match decode_array("fuzz", bytes) {
        Ok(array) => {
            let shape: Vec<usize> = array.shape.clone();
            let Ok(written) = encode_array_f64(&shape, &array.values) else {
                panic!("an array that cannot be written: {shape:?}");
            };
            let again = decode_array("again", &written);
            let is_same = again.is_ok_and(|again| {
                let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
                again.shape == shape && bits(&again.values) == bits(&array.values)
            });
            assert!(is_same, "written and read again");
        }
        Err(error) => is_one_line(&error.to_string()),
    }
}

/// Writes the checksum of each chunk of a PNG anew.
fn mend_checksums(bytes: &mut [u8]) {
    let mut at = 8;
    while let Some(&[a, b, c, d]) = bytes.get(at..).and_then(|rest| rest.first_chunk()) {
        let length = u32::from_be_bytes([a, b, c, d]) as usize;
        let end = (at + 8).saturating_add(length);
        let Some(body) = bytes.get(at + 4..end) else {
            return;
        };
        let checksum = crc32(body).to_be_bytes();
        match bytes.get_mut(end..end + 4) {
            Some(place) => place.copy_from_slice(&checksum),
            None => return,
        }
        at = end + 4;
    }
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| {
            (crc >> 1) ^ (0xedb8_8320 * (crc & 1))
        })
    })
}

fn is_one_line(message: &str) {
    assert!(
        !message.contains(char::is_control),
        "a message that is not one printable line: {message:?}"
    );
}
