//! Images that cannot be cracked: one line that names the file, code 2, nothing left behind.

use std::fs;

use crate::program::{all_refused, folder, photo, png_bytes, starbreak, write_photo};

/// A PNG header that announces this size, and nothing after it.
fn png_header((width_px, height_px): (u32, u32)) -> Vec<u8> {
    let mut bytes = png_bytes(&photo((8, 8)));
    bytes[16..20].copy_from_slice(&width_px.to_be_bytes());
    bytes[20..24].copy_from_slice(&height_px.to_be_bytes());
    let crc = crc32(&bytes[12..29]);
    bytes[29..33].copy_from_slice(&crc.to_be_bytes());
    bytes
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg())
        })
    })
}

#[test]
fn unreadable_images_are_named() {
    let dir = folder();
    let at = |name: &str| dir.path().join(name);
    let whole = png_bytes(&photo((160, 100)));
    let jpeg = crate::program::jpeg_bytes(&photo((160, 100)));
    fs::write(at("cut.png"), &whole[..whole.len() / 2]).unwrap();
    fs::write(at("cut.jpg"), &jpeg[..jpeg.len() / 2]).unwrap();
    fs::write(at("header_only.png"), &whole[..33]).unwrap();
    fs::write(at("signature_only.png"), &whole[..8]).unwrap();
    fs::write(
        at("text.png"),
        "this is no picture, whatever its name says\n",
    )
    .unwrap();
    fs::write(at("empty.png"), "").unwrap();
    fs::write(at("bomb.png"), png_header((60_000, 60_000))).unwrap();
    fs::write(at("zero.png"), png_header((0, 5))).unwrap();
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 0x55;
    fs::write(at("flipped.png"), flipped).unwrap();
    fs::create_dir(at("folder.png")).unwrap();

    let inputs = [
        "missing.png",
        "no/such/folder/a.png",
        "folder.png",
        "cut.png",
        "cut.jpg",
        "header_only.png",
        "signature_only.png",
        "text.png",
        "empty.png",
        "bomb.png",
        "zero.png",
        "flipped.png",
        "text.png/below.png",
    ];
    let cases: Vec<_> = inputs
        .iter()
        .map(|input| (vec!["crack", *input, "-o", "out"], *input))
        .collect();
    all_refused(dir.path(), &cases);
}

#[test]
fn an_image_that_breaks_a_decoder_is_one_failure_of_a_set() {
    let dir = folder();
    fs::create_dir(dir.path().join("in")).unwrap();
    for name in ["a.png", "c.png"] {
        write_photo(&dir.path().join("in").join(name));
    }
    // One pixel, and a palette of one color and a third.
    let chunk = |kind: &[u8], data: &[u8]| {
        let body = [kind, data].concat();
        let length = u32::try_from(data.len()).unwrap().to_be_bytes();
        [&length[..], &body, &crc32(&body).to_be_bytes()].concat()
    };
    let pixels = b"\x78\x01\x01\x02\x00\xfd\xff\x00\x00\x00\x02\x00\x01";
    let broken = [
        b"\x89PNG\r\n\x1a\n".to_vec(),
        chunk(b"IHDR", b"\0\0\0\x01\0\0\0\x01\x08\x03\0\0\0"),
        chunk(b"PLTE", b"\x01\x02\x03\x04"),
        chunk(b"IDAT", pixels),
        chunk(b"IEND", b""),
    ]
    .concat();
    assert_eq!(broken.len(), 86, "a small file");
    fs::write(dir.path().join("in/b.png"), broken).unwrap();
    let words = ["generate", "folder:in", "-o", "out", "--preset", "paper"];
    let outcome = starbreak(dir.path(), &words);
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(!outcome.stderr.contains("panicked"), "{outcome:?}");
    let failures = fs::read_to_string(dir.path().join("out/starbreak/failures.jsonl")).unwrap();
    assert!(
        failures.contains("b.png") && failures.contains("its palette has 4 bytes"),
        "{failures}"
    );
}

#[test]
fn header_is_what_is_refused() {
    let dir = folder();
    fs::write(dir.path().join("ok.png"), png_header((8, 8))).unwrap();
    fs::write(dir.path().join("bomb.png"), png_header((60_000, 60_000))).unwrap();
    let ok = starbreak(
        dir.path(),
        &["crack", "ok.png", "-o", "out", "--preset", "paper"],
    );
    assert_eq!(ok.code, Some(0), "the forged header is sound: {ok:?}");
    let bomb = starbreak(dir.path(), &["crack", "bomb.png", "-o", "out"]);
    assert!(
        bomb.stderr.contains("60000 x 60000"),
        "the size is named: {bomb:?}"
    );
}

#[test]
fn names_of_folders_are_no_images() {
    let dir = folder();
    let out = ["-o", "out"];
    let cases: Vec<_> = ["..", "/"]
        .iter()
        .map(|input| ([&["crack", *input][..], &out].concat(), *input))
        .collect();
    all_refused(dir.path(), &cases);
}

#[test]
fn a_name_that_breaks_the_line_stays_on_one() {
    let dir = folder();
    all_refused(
        dir.path(),
        &[
            (vec!["crack", "a\nb.png", "-o", "out"], "a\\nb.png"),
            (
                vec!["crack", "a\u{1b}[31m.png", "-o", "out"],
                "a\\u{1b}[31m.png",
            ),
            (
                vec!["simulate", "--recipe", "a\nb.toml", "-o", "out"],
                "a\\nb.toml",
            ),
        ],
    );
}

#[test]
fn a_mode_that_the_format_cannot_store_names_the_file() {
    let dir = folder();
    let rgba = image::DynamicImage::ImageRgba8(crate::program::picture(
        (160, 100),
        crate::program::high_byte,
    ));
    fs::write(dir.path().join("see_through.png"), png_bytes(&rgba)).unwrap();
    let args = vec![
        "crack",
        "see_through.png",
        "-o",
        "out",
        "--set",
        "output.format=jpeg",
    ];
    all_refused(dir.path(), &[(args, "see_through.png")]);
}

#[test]
fn inputs_with_one_stem_are_refused() {
    let dir = folder();
    fs::create_dir(dir.path().join("other")).unwrap();
    for name in ["a.png", "a.jpg", "A.png", "other/a.png"] {
        write_photo(&dir.path().join(name));
    }
    let cases: Vec<_> = ["a.jpg", "A.png", "other/a.png", "./a.png"]
        .iter()
        .map(|second| (vec!["crack", "a.png", *second, "-o", "out"], "\"a.png\""))
        .collect();
    all_refused(dir.path(), &cases);
}

/// `crack old/*.png -o new`, where `old` holds the masks of an earlier run.
#[test]
fn inputs_named_like_the_masks_of_others_are_refused() {
    let dir = folder();
    for name in ["a.png", "a.region.png", "a.crack.png"] {
        write_photo(&dir.path().join(name));
    }
    all_refused(
        dir.path(),
        &[
            (
                vec!["crack", "a.png", "a.region.png", "-o", "out"],
                "a.region",
            ),
            (
                vec!["crack", "a.crack.png", "a.png", "-o", "out"],
                "a.crack",
            ),
        ],
    );
}
