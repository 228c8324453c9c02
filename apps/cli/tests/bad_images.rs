//! Images that cannot be cracked: one line that names the file, code 2, nothing left behind.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::fs;

use common::{all_refused, folder, photo, png_bytes, starbreak, write_photo};

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
    let jpeg = common::jpeg_bytes(&photo((160, 100)));
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
    let rgba = image::DynamicImage::ImageRgba8(common::picture((160, 100), common::high_byte));
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
