//! What the reader refuses, and how it says so.
#![expect(clippy::unwrap_used, reason = "a failure here is a failed test")]
#![expect(clippy::print_stderr, reason = "a skipped test must be seen")]

use crate::common;

use std::fs;
use std::path::Path;
use std::time::Duration;

use common::{all_modes, jpeg_with, png_info, png_with, ramp};
use image::{DynamicImage, RgbImage};
use starbreak_dataset::{
    DatasetError, Encoding, ImageLimits, decode_image, encode_image, read_image,
};

fn refusal(bytes: &[u8]) -> DatasetError {
    decode_image("in.png", bytes, &ImageLimits::default()).unwrap_err()
}

/// A valid signature and IHDR chunk, and nothing else.
fn png_header(width_px: u32, height_px: u32) -> Vec<u8> {
    let info = png_info((1, 1), png::ColorType::Rgb, png::BitDepth::Eight);
    let mut bytes = png_with(info, &[0; 3])[..33].to_vec();
    bytes[16..20].copy_from_slice(&width_px.to_be_bytes());
    bytes[20..24].copy_from_slice(&height_px.to_be_bytes());
    let crc = bytes[12..29].iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| {
            (crc >> 1) ^ (0xedb8_8320 * (crc & 1))
        })
    });
    bytes[29..33].copy_from_slice(&(!crc).to_be_bytes());
    bytes
}

fn jpeg_header(width_px: u16, height_px: u16) -> Vec<u8> {
    let mut bytes = jpeg_with(&RgbImage::new(8, 8), |_| {});
    let frame = bytes.windows(2).position(|w| w == [0xff, 0xc0]).unwrap();
    bytes[frame + 5..frame + 7].copy_from_slice(&height_px.to_be_bytes());
    bytes[frame + 7..frame + 9].copy_from_slice(&width_px.to_be_bytes());
    bytes
}

#[test]
fn bombs_fail_on_the_header_with_size_and_limit() {
    for bytes in [png_header(60_000, 60_000), jpeg_header(60_000, 60_000)] {
        let message = refusal(&bytes).to_string();
        for part in [
            "in.png",
            "60000 x 60000 px",
            "32768 px per side",
            "134217728 px in all",
        ] {
            assert!(message.contains(part), "{part:?} is missing in {message:?}");
        }
    }
    // Each side is fine, the product is not; and one side is not.
    for size in [(20_000, 20_000), (32_769, 1), (1, u32::MAX >> 1)] {
        let error = refusal(&png_header(size.0, size.1));
        assert!(
            matches!(error, DatasetError::ImageTooLarge { .. }),
            "{size:?}: {error}"
        );
    }
    // At the limit it goes on, to find that nothing follows.
    let error = refusal(&png_header(32_768, 4096));
    assert!(matches!(error, DatasetError::Truncated { .. }), "{error}");
}

#[test]
fn limits_are_the_callers() {
    let bytes = encode_image(&DynamicImage::ImageRgb8(ramp(20, 10)), &Encoding::Png, None).unwrap();
    let limits = ImageLimits::default();
    let fits = ImageLimits {
        max_side_px: 20,
        max_pixels: 200,
        max_file_bytes: bytes.len() as u64,
    };
    assert!(
        decode_image("x", &bytes, &fits).is_ok(),
        "exactly at all limits"
    );
    for limits in [
        ImageLimits {
            max_side_px: 19,
            ..limits
        },
        ImageLimits {
            max_pixels: 199,
            ..limits
        },
        ImageLimits {
            max_file_bytes: bytes.len() as u64 - 1,
            ..limits
        },
    ] {
        assert!(decode_image("x", &bytes, &limits).is_err(), "{limits:?}");
    }
}

#[test]
fn every_cut_of_a_valid_file_is_an_error() {
    let image = ramp(40, 24);
    let mut files: Vec<_> = all_modes(9, 7)
        .iter()
        .map(|mode| encode_image(mode, &Encoding::Png, Some(b"profile")).unwrap())
        .collect();
    files.push(jpeg_with(&image, |_| {}));
    files.push(jpeg_with(&image, |e| e.set_progressive(true)));
    files.push(jpeg_with(&image, |e| e.set_restart_interval(2)));
    for (idx, file) in files.iter().enumerate() {
        assert!(
            decode_image("x", file, &ImageLimits::default()).is_ok(),
            "file {idx} is whole"
        );
        for end in 0..file.len() {
            let error = refusal(&file[..end]);
            let cut = matches!(
                error,
                DatasetError::Truncated { .. } | DatasetError::EmptyFile { .. }
            );
            assert!(
                cut,
                "file {idx} cut after {end} of {} bytes: {error}",
                file.len()
            );
        }
    }
}

#[test]
fn a_jpeg_that_ends_early_behind_an_end_marker_is_refused() {
    let image = ramp(100, 60);
    let sampled = |factor| jpeg_with(&image, |e| e.set_sampling_factor(factor));
    let files = [
        jpeg_with(&image, |_| {}),
        jpeg_with(&image, |e| e.set_progressive(true)),
        jpeg_with(&image, |e| {
            e.set_progressive(true);
            e.set_sampling_factor(jpeg_encoder::SamplingFactor::F_2_2);
        }),
        jpeg_with(&image, |e| e.set_restart_interval(2)),
        sampled(jpeg_encoder::SamplingFactor::F_2_1),
        sampled(jpeg_encoder::SamplingFactor::F_2_2),
        sampled(jpeg_encoder::SamplingFactor::F_4_1),
    ];
    for (idx, file) in files.iter().enumerate() {
        let whole = decode_image("x", file, &ImageLimits::default());
        assert!(whole.is_ok(), "file {idx} is whole: {whole:?}");
        let scan = file.windows(2).position(|w| w == [0xff, 0xda]).unwrap();
        let mut n_read = 0;
        for end in scan + 14..file.len() - 2 {
            // What follows the marker is read by nobody.
            let bytes = [&file[..end], &b"\xff\xd9"[..], &file[end..]].concat();
            let result = decode_image("in.jpg", &bytes, &ImageLimits::default());
            n_read += usize::from(result.is_ok());
        }
        assert_eq!(
            n_read,
            0,
            "file {idx}: read as whole, of {} cuts",
            file.len() - scan
        );
    }
    let bytes = [&files[0][..files[0].len() / 2], b"\xff\xd9"].concat();
    let message = refusal(&bytes).to_string();
    assert!(
        message.contains("its pixels end after") && message.contains(" blocks of 8 x 8"),
        "{message}"
    );
}

#[test]
fn arithmetic_coding_is_named() {
    for marker in [0xc9, 0xca] {
        let mut bytes = jpeg_with(&ramp(40, 24), |_| {});
        let frame = bytes.windows(2).position(|w| w == [0xff, 0xc0]).unwrap();
        bytes[frame + 1] = marker;
        let message = refusal(&bytes).to_string();
        assert!(
            message.contains("not supported: arithmetic coding"),
            "{marker:#x}: {message}"
        );
    }
}

#[test]
fn a_flipped_bit_in_png_pixels_is_found() {
    let file = encode_image(&DynamicImage::ImageRgb8(ramp(40, 24)), &Encoding::Png, None).unwrap();
    for at in 41..file.len() - 12 {
        let mut damaged = file.clone();
        damaged[at] ^= 0x10;
        let result = decode_image("x", &damaged, &ImageLimits::default());
        assert!(
            matches!(result, Err(DatasetError::Corrupt { .. })),
            "byte {at}: {result:?}"
        );
    }
}

#[test]
fn other_content_is_named() {
    for (bytes, word) in [
        (&b"hello, I am no image\n"[..], "text"),
        (b"GIF89a\x01\0\x01\0", "a GIF image"),
        (
            b"version https://git-lfs.github.com/spec/v1\n",
            "Git LFS pointer",
        ),
    ] {
        let message = refusal(bytes).to_string();
        assert!(
            message.contains("is not PNG, JPEG, WebP or BMP"),
            "{message}"
        );
        assert!(message.contains(word), "{message}");
    }
    assert!(
        refusal(b"").to_string().contains("empty (0 bytes)"),
        "{}",
        refusal(b"")
    );
    let no_image = refusal(b"\xff\xd8\xff\xfe\x00\x02\xff\xd9").to_string();
    assert!(no_image.contains("it holds no image"), "{no_image}");
}

fn read_refusal(path: &Path) -> String {
    read_image(path, &ImageLimits::default())
        .unwrap_err()
        .to_string()
}

#[test]
fn things_that_are_no_files() {
    let dir = tempfile::tempdir().unwrap();
    let folder = read_refusal(dir.path());
    assert!(folder.contains("it is a folder"), "{folder}");
    let missing = read_refusal(&dir.path().join("a\nb.png"));
    assert!(
        missing.ends_with("a\\nb.png\": no such file or folder; check the path"),
        "{missing}"
    );
    fs::write(dir.path().join("file"), b"x").unwrap();
    let through = read_refusal(&dir.path().join("file/in.png"));
    assert!(
        through.contains("a part of the path is a file"),
        "{through}"
    );
    let long = read_refusal(&dir.path().join("n".repeat(300)));
    assert!(long.contains("the file name is too long"), "{long}");
}

#[cfg(unix)]
#[test]
fn pipes_sockets_and_devices_do_not_hang() {
    let dir = tempfile::tempdir().unwrap();
    let device = read_refusal(Path::new("/dev/zero"));
    assert!(device.contains("it is a device"), "{device}");
    let _listener = std::os::unix::net::UnixListener::bind(dir.path().join("s")).unwrap();
    let socket = read_refusal(&dir.path().join("s"));
    assert!(socket.contains("it is a socket"), "{socket}");

    let pipe = dir.path().join("p");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    if !made.is_ok_and(|status| status.success()) {
        eprintln!("SKIPPED: there is no mkfifo");
        return;
    }
    let (sender, receiver) = std::sync::mpsc::channel();
    std::thread::spawn(move || sender.send(read_refusal(&pipe)));
    let message = receiver.recv_timeout(Duration::from_secs(120)).unwrap();
    assert!(message.contains("it is a pipe"), "{message}");
}

#[cfg(unix)]
#[test]
fn unreadable_file() {
    use std::os::unix::fs::PermissionsExt as _;
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("in.png");
    fs::write(&path, b"x").unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o000)).unwrap();
    if fs::read(&path).is_ok() {
        eprintln!("SKIPPED: this user may read everything");
        return;
    }
    let message = read_refusal(&path);
    assert!(
        message.contains("permission denied; check the permissions"),
        "{message}"
    );
}

#[test]
fn text_named_png() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("notes.png");
    fs::write(&path, "just notes\n").unwrap();
    let message = read_refusal(&path);
    assert!(
        message.contains("notes.png\" is not PNG, JPEG, WebP or BMP, it looks like text"),
        "{message}"
    );
}

#[test]
fn a_palette_with_a_color_cut_short_is_refused() {
    let mut info = png_info((1, 1), png::ColorType::Indexed, png::BitDepth::Eight);
    info.palette = Some(vec![1, 2, 3, 4, 5, 6].into());
    let whole = png_with(info, &[0]);
    let place = whole.windows(4).position(|w| w == b"PLTE").unwrap();
    assert!(
        decode_image("x", &whole, &ImageLimits::default()).is_ok(),
        "two whole colors"
    );
    for n_bytes in [4, 5] {
        let palette = [b"PLTE", &[1, 2, 3, 4, 5, 6][..n_bytes]].concat();
        let length = u32::try_from(n_bytes).unwrap().to_be_bytes();
        let checksum = crc32fast::hash(&palette).to_be_bytes();
        let chunk = [&length[..], &palette, &checksum].concat();
        let bytes = [&whole[..place - 4], &chunk, &whole[place + 14..]].concat();
        let message = refusal(&bytes).to_string();
        assert!(
            message.contains("palette") && message.contains("in.png"),
            "{n_bytes} bytes: {message}"
        );
    }
}

#[test]
fn a_bitmap_whose_pixels_would_begin_in_its_header_is_refused() {
    let image = DynamicImage::new_rgb8(9, 7);
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Bmp).unwrap();
    let mut bytes = bytes.into_inner();
    assert!(
        decode_image("x", &bytes, &ImageLimits::default()).is_ok(),
        "as it is written"
    );
    bytes[10] = 2;
    let message = refusal(&bytes).to_string();
    assert!(
        message.contains("begin at byte 2, but its header ends"),
        "{message}"
    );
}
