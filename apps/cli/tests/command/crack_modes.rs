//! `crack` on every mode of image and format of file.

use std::fs;

use crate::program::{
    RawPng, all_refused, folder, high_byte, json, names, picture, png_bytes, raw_png,
    starbreak_small, succeed_small,
};
use image::DynamicImage;
use starbreak_dataset::{ImageFile, ImageFormat, ImageLimits, read_image};

const SIZE: (u32, u32) = (160, 100);

/// Cracks a PNG file of these bytes: what was read, the result, and its region.
fn cracked(bytes: &[u8], more: &[&str]) -> [RawPng; 3] {
    let dir = folder();
    fs::write(dir.path().join("a.png"), bytes).unwrap();
    succeed_small(
        dir.path(),
        &[&["crack", "a.png", "-o", "o"][..], more].concat(),
    );
    ["a.png", "o/a.png", "o/a.region.png"].map(|name| raw_png(&dir.path().join(name)))
}

#[test]
fn every_mode_of_png_is_kept() {
    let (eight, sixteen) = (high_byte, |sample| sample);
    let images = [
        DynamicImage::ImageLuma8(picture(SIZE, eight)),
        DynamicImage::ImageLumaA8(picture(SIZE, eight)),
        DynamicImage::ImageRgb8(picture(SIZE, eight)),
        DynamicImage::ImageRgba8(picture(SIZE, eight)),
        DynamicImage::ImageLuma16(picture(SIZE, sixteen)),
        DynamicImage::ImageLumaA16(picture(SIZE, sixteen)),
        DynamicImage::ImageRgb16(picture(SIZE, sixteen)),
        DynamicImage::ImageRgba16(picture(SIZE, sixteen)),
    ];
    for image in images {
        let name = format!("{:?}", image.color());
        let [before, after, region] = cracked(&png_bytes(&image), &[]);
        assert_eq!(before.mode, after.mode, "{name}: mode");
        assert_eq!(before.size, after.size, "{name}: size");
        let has_alpha = image.color().has_alpha();
        let n_bytes_alpha = match (has_alpha, before.mode.1) {
            (false, _) => 0,
            (true, png::BitDepth::Sixteen) => 2,
            (true, _) => 1,
        };
        let (mut n_outside, mut n_changed, mut n_fine) = (0, 0, 0);
        for ((before, after), region) in before.pixels().zip(after.pixels()).zip(&region.data) {
            let alpha = before.len() - n_bytes_alpha;
            assert_eq!(before[alpha..], after[alpha..], "{name}: alpha");
            if *region == 0 {
                n_outside += 1;
                assert_eq!(before, after, "{name}: a pixel outside the region");
            } else if before != after {
                n_changed += 1;
                let color = after[..alpha].chunks_exact(2);
                n_fine += usize::from(color.clone().any(|pair| pair[0] != pair[1]));
            }
        }
        assert!(n_outside > 100 && n_changed > 100, "{name}: a part changes");
        if before.mode.1 == png::BitDepth::Sixteen {
            assert!(
                n_fine * 10 > n_changed * 9,
                "{name}: {n_fine} of {n_changed} changed pixels have 16 bits, not 8 times 257"
            );
        }
    }
}

#[test]
fn a_palette_comes_out_as_its_colors() {
    let mut info = png::Info::with_size(SIZE.0, SIZE.1);
    info.color_type = png::ColorType::Indexed;
    info.bit_depth = png::BitDepth::Eight;
    let palette = [10, 20, 30, 200, 100, 50, 90, 180, 240];
    info.palette = Some(palette.as_slice().into());
    let indices: Vec<u8> = (0_u8..3).cycle().take((SIZE.0 * SIZE.1) as usize).collect();
    let mut bytes = Vec::new();
    let mut writer = png::Encoder::with_info(&mut bytes, info)
        .unwrap()
        .write_header()
        .unwrap();
    writer.write_image_data(&indices).unwrap();
    writer.finish().unwrap();

    let [_, after, region] = cracked(&bytes, &[]);
    assert_eq!(
        after.mode,
        (png::ColorType::Rgb, png::BitDepth::Eight),
        "a palette has no place for a crack"
    );
    assert!(after.size == SIZE, "size {:?}", after.size);
    for ((index, pixel), region) in indices.iter().zip(after.pixels()).zip(&region.data) {
        let start = usize::from(*index) * 3;
        assert!(
            *region == 255 || *pixel == palette[start..start + 3],
            "a pixel of color {index} outside the region came out as {pixel:?}"
        );
    }
}

fn read(path: &std::path::Path) -> ImageFile {
    read_image(path, &ImageLimits::default()).unwrap()
}

#[test]
fn jpeg_stays_jpeg_unless_told_otherwise() {
    let dir = folder();
    let gray = DynamicImage::ImageLuma8(picture(SIZE, high_byte));
    for (name, pixels) in [
        ("color.jpg", crate::program::photo(SIZE)),
        ("gray.JPEG", gray),
    ] {
        let input = dir.path().join(name);
        fs::write(&input, crate::program::jpeg_bytes(&pixels)).unwrap();
        succeed_small(dir.path(), &["crack", name, "-o", "same"]);
        let (before, after) = (read(&input), read(&dir.path().join("same").join(name)));
        assert_eq!(after.format, ImageFormat::Jpeg, "{name}");
        assert_eq!(after.pixels.color(), before.pixels.color(), "{name}: mode");
        assert_eq!(after.pixels.width(), SIZE.0, "{name}: width");

        // Lossless: outside the region stand the pixels that the JPEG decodes to.
        let set = ["--set", "output.format=png"];
        succeed_small(
            dir.path(),
            &[&["crack", name, "-o", "png"][..], &set].concat(),
        );
        let stem = name.split('.').next().unwrap();
        let after = raw_png(&dir.path().join(format!("png/{stem}.png")));
        let region = raw_png(&dir.path().join(format!("png/{stem}.region.png")));
        let samples = after.mode.0.samples();
        let decoded = before.pixels.as_bytes().chunks_exact(samples);
        let mut n_outside = 0;
        for ((before, after), region) in decoded.zip(after.pixels()).zip(&region.data) {
            if *region == 0 {
                n_outside += 1;
                assert_eq!(before, after, "{name}: a pixel outside the region");
            }
        }
        assert!(n_outside > 100, "{name}: a part is outside");
        let record = json(&dir.path().join(format!("png/{stem}.json")));
        assert_eq!(record["output"]["name"], format!("{stem}.png"), "{name}");
    }
}

#[test]
fn quality_and_format_follow_the_recipe() {
    let dir = folder();
    crate::program::write_photo(&dir.path().join("a.png"));
    let size_at = |quality: &str| {
        let set = format!("output.quality={quality}");
        let args = [
            "crack",
            "a.png",
            "-o",
            quality,
            "--set",
            "output.format=jpeg",
        ];
        succeed_small(dir.path(), &[&args[..], &["--set", &set]].concat());
        assert!(
            !names(&dir.path().join(quality)).contains(&"a.png".to_owned()),
            "no PNG beside the JPEG"
        );
        let path = dir.path().join(quality).join("a.jpg");
        assert_eq!(read(&path).format, ImageFormat::Jpeg, "quality {quality}");
        fs::metadata(path).unwrap().len()
    };
    assert!(
        size_at("20") < size_at("95"),
        "quality 20 is smaller than 95"
    );
}

#[test]
fn the_content_decides_and_not_the_name() {
    let dir = folder();
    fs::write(
        dir.path().join("a.jpg"),
        png_bytes(&crate::program::photo(SIZE)),
    )
    .unwrap();
    fs::write(
        dir.path().join("b"),
        crate::program::jpeg_bytes(&crate::program::photo(SIZE)),
    )
    .unwrap();
    succeed_small(dir.path(), &["crack", "a.jpg", "b", "-o", "o"]);
    let a = read(&dir.path().join("o/a.png"));
    assert_eq!(a.format, ImageFormat::Png, "a PNG that is called .jpg");
    let b = read(&dir.path().join("o/b.jpg"));
    assert_eq!(b.format, ImageFormat::Jpeg, "a JPEG without extension");
}

/// What is not written becomes PNG, but in a set, which keeps names and formats.
#[test]
fn webp_and_bitmaps_become_png() {
    let dir = folder();
    let [png, webp, bmp] = ["png", "webp", "bmp"].map(|format| {
        let photo = dir.path().join(format!("{format}/a.{format}"));
        fs::create_dir(photo.parent().unwrap()).unwrap();
        crate::program::photo(SIZE).save(&photo).unwrap();
        // Cracks go by the name of the image.
        let same_name = photo.with_file_name("photo.png");
        fs::copy(&photo, &same_name).unwrap();
        let [input, out] = [same_name.to_str().unwrap(), &format!("out-{format}")];
        succeed_small(dir.path(), &["crack", input, "-o", out]);
        raw_png(&dir.path().join(out).join("photo.png")).data
    });
    assert_eq!(png, webp, "the same pixels and crack");
    assert_eq!(png, bmp, "the same pixels and crack");
    succeed_small(dir.path(), &["crack", "webp/a.webp", "-o", "named"]);
    assert_eq!(
        read(&dir.path().join("named/a.png")).format,
        ImageFormat::Png,
        "by its name"
    );

    all_refused(
        dir.path(),
        &[(
            vec!["crack", "webp/a.webp", "-o", "a.webp"],
            "written as .png",
        )],
    );

    fs::create_dir(dir.path().join("photos")).unwrap();
    fs::rename(
        dir.path().join("webp/a.webp"),
        dir.path().join("photos/a.png"),
    )
    .unwrap();
    let set = starbreak_small(dir.path(), &["generate", "folder:photos", "-o", "set"]);
    assert_eq!(set.code, Some(1), "{}", set.stderr);
    let failures = fs::read_to_string(dir.path().join("set/starbreak/failures.jsonl")).unwrap();
    assert!(
        failures.contains("a.png") && failures.contains("WebP"),
        "{failures}"
    );
}

#[test]
fn exif_orientation_is_applied() {
    let dir = folder();
    let upright_jpeg = crate::program::jpeg_bytes(&crate::program::photo(SIZE));
    // APP1 with a TIFF block that holds nothing but orientation 6: turn clockwise.
    let tiff = b"Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0";
    let length = u16::try_from(tiff.len() + 2).unwrap().to_be_bytes();
    let turned = [
        &upright_jpeg[..2],
        &[0xff, 0xe1],
        &length,
        tiff,
        &upright_jpeg[2..],
    ]
    .concat();
    fs::write(dir.path().join("plain.jpg"), &upright_jpeg).unwrap();
    fs::write(dir.path().join("turned.jpg"), turned).unwrap();
    let set = ["--set", "output.format=png"];
    let args = ["crack", "turned.jpg", "-o", "o"];
    succeed_small(dir.path(), &[&args[..], &set].concat());

    let expected = read(&dir.path().join("plain.jpg")).pixels.rotate90();
    let after = raw_png(&dir.path().join("o/turned.png"));
    let region = raw_png(&dir.path().join("o/turned.region.png"));
    assert_eq!(after.size, (SIZE.1, SIZE.0), "the image is turned");
    assert_eq!(region.size, after.size, "the mask is turned with it");
    let expected = expected.as_bytes().chunks_exact(3);
    let mut n_outside = 0;
    for ((expected, after), region) in expected.zip(after.pixels()).zip(&region.data) {
        if *region == 0 {
            n_outside += 1;
            assert_eq!(expected, after, "a pixel outside the region");
        }
    }
    assert!(n_outside > 100, "a part is outside");
    let camera = json(&dir.path().join("o/turned.json"))["camera"].clone();
    assert_eq!(camera["width_px"], SIZE.1, "the camera of the turned image");

    // As JPEG the turn is in the pixels, and must not be applied again by a viewer.
    succeed_small(dir.path(), &["crack", "turned.jpg", "-o", "j"]);
    let after = read(&dir.path().join("j/turned.jpg")).pixels;
    assert_eq!(
        (after.width(), after.height()),
        (SIZE.1, SIZE.0),
        "once only"
    );
}
