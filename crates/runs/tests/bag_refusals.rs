//! Bags that are damaged, of other kinds, or hold what is not put behind glass.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use crate::bag_file;

use std::fs;
use std::io::{Seek, SeekFrom, Write};

use bag_file::{
    BagFile, COMPRESSED, Cdr, Content, Folder, HEIGHT, IMAGE, Kept, WIDTH, compressed, context,
    drive, file, nothing, packings, places, raw, rows, small,
};
use mcap::WriteOptions;
use starbreak_runs::bag::{Added, BagRequest, CameraRequest, ImpactAt};

const TIME: u64 = 1_700_000_000_000_000_000;

/// A bag with one message of a topic.
fn lone(schema: &str, message: &[u8]) -> Folder {
    let mut bag = BagFile::new(WriteOptions::new());
    let good = bag.topic("/good", IMAGE);
    bag.message(good, TIME, &raw(false, TIME, "rgb8", 0));
    let id = bag.topic("/cam", schema);
    bag.message(id, TIME, message);
    Folder::with(&bag.finish())
}

#[test]
fn a_bag_that_is_cut_is_read_to_its_last_whole_chunk() {
    for (name, options) in packings() {
        let bag = drive(options, 3);
        let whole = Content::of(&bag).records;
        let mut most = 0;
        let step = (bag.len() / 60).max(1);
        let cuts = (100..bag.len())
            .step_by(step)
            .chain([bag.len() - 9, bag.len() - 1]);
        for cut in cuts {
            let folder = Folder::with(&bag[..cut]);
            let request = BagRequest {
                all: None,
                ..folder.request(nothing())
            };
            let report = folder.run(request, 1).unwrap();
            let damage = report.damage.unwrap();
            assert!(damage.at_byte <= cut as u64, "{name}, {cut}: {damage:?}");
            let output = folder.output();
            assert!(
                output.provenance().contains_key("input_damage"),
                "{name}, {cut}"
            );
            let records = output.without_provenance().records;
            assert_eq!(records, whole[..records.len()], "{name}, {cut}");
            most = most.max(records.len());
        }
        assert_eq!(
            most,
            whole.len(),
            "{name}: all records, where only the end is missing"
        );
    }
}

/// Where the chunks of a bag begin.
fn chunks(bag: &[u8]) -> Vec<usize> {
    let chunks = places(bag).into_iter();
    chunks
        .filter_map(|(kind, at)| (kind == 0x06).then_some(at))
        .collect()
}

#[test]
fn chunks_that_are_broken_are_left_out_alone() {
    let options = WriteOptions::new().compression(None).chunk_size(Some(4000));
    let bag = drive(options, 4);
    let whole = Content::of(&bag).records;
    let chunks = chunks(&bag);
    assert!(chunks.len() > 5, "{chunks:?}");
    for lost in [&[2_usize][..], &[0], &[0, 1, 4], &[chunks.len() - 1]] {
        let mut broken = bag.clone();
        for k in lost {
            broken[chunks[*k] + 1000] ^= 1;
        }
        let folder = Folder::with(&broken);
        let report = folder.run(folder.request(nothing()), 1).unwrap();
        let damage = report.damage.unwrap();
        assert!(damage.reason.contains("checksum"), "{damage:?}");
        let found = (damage.at_byte, damage.n_lost_chunks, damage.ends_at_byte);
        let first = chunks[lost[0]] as u64;
        assert_eq!(found, (first, lost.len() as u64, None), "{damage}");
        let records = folder.output().without_provenance().records;
        let mut others = whole.clone();
        others.retain(|it| records.contains(it));
        assert_eq!(
            records, others,
            "{lost:?}: those that are left, in their order"
        );
        assert!(
            records.len() + 3 * lost.len() >= whole.len(),
            "{lost:?}: the others"
        );
    }
}

/// The channels of a bag may stand in its first chunk alone. Its summary has them, too; without that what they describe is
/// lost with them.
#[test]
fn messages_whose_channel_is_lost_need_the_summary() {
    let bag = drive(
        WriteOptions::new().chunk_size(Some(4000)).compression(None),
        4,
    );
    let chunks = chunks(&bag);
    let mut broken = bag.clone();
    broken[chunks[0] + 1000] ^= 1;
    let without_summary = &broken[..bag.len() - 40];
    let folder = Folder::with(without_summary);
    let request = BagRequest {
        all: None,
        ..folder.request(nothing())
    };
    let report = folder.run(request, 1).unwrap();
    let damage = report.damage.unwrap();
    assert!(
        damage.n_lost_chunks > 1 && damage.ends_at_byte.is_some(),
        "{damage:?}"
    );
    // A valid bag in any case, of what else is described.
    let records = folder.output().without_provenance().records;
    let whole = Content::of(&bag).records;
    assert!(records.len() + 6 < whole.len(), "{}", records.len());
    assert!(records.iter().all(|it| whole.contains(it)), "nothing else");
}

#[test]
fn a_length_that_is_broken_ends_the_bag_before_it() {
    let bag = drive(WriteOptions::new().use_chunks(false), 2);
    let whole = Content::of(&bag).records;
    let mut messages = places(&bag).into_iter().filter(|(kind, _)| *kind == 0x05);
    let (_, at) = messages.nth(7).unwrap();
    let folder = Folder::with(&bag);
    let path = folder.at("in.mcap");
    let mut file = fs::OpenOptions::new().write(true).open(path).unwrap();
    // So much that it is refused, and that still fits the file, which is a hole from there on.
    file.seek(SeekFrom::Start(at as u64 + 1)).unwrap();
    file.write_all(&(2_u64 << 30).to_le_bytes()).unwrap();
    file.set_len(3 << 30).unwrap();
    drop(file);
    let report = folder.run(folder.request(nothing()), 1).unwrap();
    let damage = report.damage.unwrap();
    assert_eq!(damage.at_byte, at as u64, "{damage:?}");
    assert!(damage.reason.contains("has 2147483648 bytes"), "{damage:?}");
    let records = folder.output().without_provenance().records;
    assert_eq!(report.n_messages, 7, "messages");
    assert_eq!(records, whole[..records.len()], "those before");
}

#[test]
fn a_name_of_a_compression_that_is_broken_costs_its_chunk() {
    let options = || {
        let options = WriteOptions::new().chunk_size(Some(4000));
        options.compression(Some(mcap::Compression::Lz4))
    };
    let bag = drive(options(), 4);
    let whole = Content::of(&bag).records;
    let chunks = chunks(&bag);
    let broken = |at: usize| {
        let mut broken = bag.clone();
        let name = at + 9 + 28 + 4;
        assert_eq!(&bag[name..name + 3], b"lz4", "where the name stands");
        broken[name] ^= 1;
        Folder::with(&broken)
    };
    let folder = broken(chunks[2]);
    let report = folder.run(folder.request(nothing()), 1).unwrap();
    let damage = report.damage.unwrap();
    assert_eq!(damage.at_byte, chunks[2] as u64, "{damage:?}");
    assert_eq!(damage.n_lost_chunks, 1, "{damage:?}");
    assert!(
        damage.reason.contains("compressed by \"mz4\""),
        "{damage:?}"
    );
    let records = folder.output().without_provenance().records;
    let mut others = whole.clone();
    others.retain(|it| records.contains(it));
    assert_eq!(records, others, "those that are left");
    assert!(records.len() + 4 > whole.len(), "all others");
    // Nothing of a bag whose chunks are all compressed otherwise is read.
    let folder = broken(chunks[0]);
    let refusal = folder.refusal(folder.request(nothing()));
    assert!(refusal.contains("compressed by \"mz4\""), "{refusal}");
}

#[test]
fn other_files_are_refused_with_the_way_out() {
    for (bytes, expected) in [
        (
            &b"#ROSBAG V2.0\n"[..],
            "is a bag of ROS 1; convert it first: mcap convert ",
        ),
        (
            b"SQLite format 3\0",
            "is a bag of ROS 2 in SQLite; convert it first: mcap convert ",
        ),
        (b"", "is not an MCAP file"),
        (b"\x89MCAP1\r\n and more", "is not an MCAP file"),
        (
            b"\x89MCAP0\r\n\x05\0\0\0\0\0\0\0\0",
            "it begins without a header",
        ),
    ] {
        let folder = Folder::with(bytes);
        let message = folder.refusal(folder.request(small(0)));
        assert!(message.contains(expected), "{message}");
    }
    let folder = Folder::with(&drive(WriteOptions::new(), 1));
    let into_itself = BagRequest {
        output: folder.at("./in.mcap"),
        ..folder.request(small(0))
    };
    let message = folder.refusal(into_itself);
    assert!(message.contains("would replace the input"), "{message}");
    let mut bag = BagFile::new(WriteOptions::new());
    let id = bag.topic("/imu", "sensor_msgs/msg/Imu");
    bag.message(id, TIME, b"x");
    let folder = Folder::with(&bag.finish());
    let message = folder.refusal(folder.request(small(0)));
    assert!(
        message.contains("has no camera: none of its 1 topics"),
        "{message}"
    );
}

#[test]
fn topics_that_are_not_damaged_are_named() {
    let folder = lone("foxglove_msgs/msg/CompressedVideo", b"x");
    for request in [
        folder.request(small(0)),
        folder.request_of("/cam", small(0)),
    ] {
        let message = folder.refusal(request);
        let expected = "topic /cam is foxglove_msgs/msg/CompressedVideo in cdr: frames of a video depend on each \
                        other; decode it to images first; name only topics that are damaged with --topic";
        assert_eq!(message, expected, "a video");
    }
    for schema in [
        "foxglove_msgs/msg/RawImage",
        "foxglove_msgs/msg/CompressedImage",
        "foxglove.RawImage",
    ] {
        let folder = lone(schema, b"x");
        let message = folder.refusal(folder.request(small(0)));
        assert!(
            message.contains("only messages of sensor_msgs are read"),
            "{message}"
        );
    }
    // Others of Foxglove are no pictures.
    for schema in ["ImageAnnotations", "SceneUpdate", "Log"] {
        let folder = lone(&format!("foxglove_msgs/msg/{schema}"), b"x");
        let report = folder.run(folder.request(small(0)), 1).unwrap();
        assert_eq!(report.cameras.len(), 1, "{schema}");
    }
    // Nor is a video hidden by a camera of its name.
    for schemas in [
        [IMAGE, "foxglove_msgs/msg/CompressedVideo"],
        ["foxglove_msgs/msg/CompressedVideo", IMAGE],
    ] {
        let mut bag = BagFile::new(WriteOptions::new());
        for schema in schemas {
            let id = bag.topic("/cam", schema);
            bag.message(id, TIME, &raw(false, TIME, "rgb8", 0));
        }
        let folder = Folder::with(&bag.finish());
        for request in [
            folder.request(small(0)),
            folder.request_of("/cam", small(0)),
        ] {
            let message = folder.refusal(request);
            assert!(
                message.starts_with("topic /cam is foxglove_msgs/msg/CompressedVideo in cdr: "),
                "{message}"
            );
        }
    }
    let folder = lone("foxglove_msgs/msg/CompressedVideo", b"x");
    // Another topic is damaged all the same.
    folder.run(folder.request_of("/good", small(0)), 1).unwrap();
    let folder = lone("sensor_msgs/msg/Imu", b"x");
    let message = folder.refusal(folder.request_of("/cam", small(0)));
    assert!(
        message.contains("topic /cam is sensor_msgs/msg/Imu in cdr: it holds no images"),
        "{message}"
    );
    let message = folder.refusal(folder.request_of("/no", small(0)));
    assert!(
        message.contains("has no topic /no; its cameras are /good"),
        "{message}"
    );
    let mut twice = folder.request_of("/good", small(0));
    twice.cameras.push(CameraRequest {
        topic: "/good".to_owned(),
        context: small(0),
    });
    let message = folder.refusal(twice);
    assert!(message.contains("topic /good is named twice"), "{message}");
    let png = context("paper", &["output.format=\"png\""], 0);
    let message = folder.refusal(folder.request_of("/good", png));
    assert!(
        message.contains("topic /good sets output.format"),
        "{message}"
    );
    let control = BagRequest {
        added: vec![Added::Control],
        ..folder.request_of("/good", small(0))
    };
    let message = folder.refusal(control);
    assert!(message.contains("--control is for JPEG"), "{message}");
    let hit = BagRequest {
        impact_at: ImpactAt::AfterFirst(1.0),
        ..folder.request(nothing())
    };
    let message = folder.refusal(hit);
    assert!(message.contains("no glass breaks"), "{message}");
}

#[test]
fn encodings_that_are_not_damaged_are_named_with_their_topic() {
    for (encoding, reason) in [
        ("bayer_rggb8", "a mosaic has one color per pixel"),
        ("bayer_gbrg16", "a mosaic"),
        ("16UC1", "more than 8 bits per channel"),
        ("32FC1", "more than 8 bits per channel"),
        ("mono16", "more than 8 bits per channel"),
        ("yuv422_yuy2", "luma and chroma"),
        ("8UC3", "it does not say which channel is which color"),
        ("RGB8", "not known"),
    ] {
        let folder = lone(IMAGE, &raw(false, TIME, encoding, 0));
        let message = folder.refusal(folder.request(small(0)));
        let expected = format!("topic /cam, message 0: encoding {encoding:?}: {reason}");
        assert!(message.starts_with(&expected), "{message}");
    }
    let deep = image::ImageBuffer::<image::Luma<u16>, _>::from_pixel(8, 8, image::Luma([999]));
    let deep = starbreak_dataset::encode_image(
        &image::DynamicImage::from(deep),
        &starbreak_dataset::Encoding::Png,
        None,
    )
    .unwrap();
    for (format, data, reason) in [
        (
            "16UC1; png compressed ",
            deep.clone(),
            "encoding \"16UC1\": more than 8 bits per channel",
        ),
        ("mono16; jpeg compressed ", file(true), "more than 8 bits"),
        (
            "bayer_rggb8; jpeg compressed ",
            file(true),
            "encoding \"bayer_rggb8\": a mosaic has one color per pixel",
        ),
        ("png", deep, "the data have more than 8 bits per channel"),
        (
            "32FC1; compressedDepth png",
            file(false),
            "depth is no light",
        ),
        ("jpeg", b"BM".repeat(40), "data"),
        ("jpeg", file(true)[..300].to_vec(), "data"),
        ("jpeg", Vec::new(), "data"),
    ] {
        let folder = lone(COMPRESSED, &compressed(false, TIME, format, &data));
        let message = folder.refusal(folder.request(small(0)));
        let is_named = message.starts_with("topic /cam, message 0: ") && message.contains(reason);
        assert!(is_named, "{format}: {message}");
    }
    for format in [
        "",
        "jpeg",
        "jpg",
        "rgb8; jpeg compressed bgr8",
        "mono8; jpeg compressed ",
        "yuv422; jpeg compressed bgr8",
        "rgb16; jpeg compressed bgr8",
    ] {
        let folder = lone(COMPRESSED, &compressed(false, TIME, format, &file(true)));
        let report = folder.run(folder.request(small(0)), 1).unwrap();
        assert_eq!(report.cameras[0].n_altered, 1, "{format}");
    }
}

#[test]
fn messages_that_claim_what_they_do_not_have_are_refused() {
    let good = raw(false, TIME, "rgb8", 0);
    let head = || Cdr::new(false).header(TIME, "camera");
    let image = |height, width, step, data: &[u8]| {
        let it = head().u32(height).u32(width).text("rgb8").u8(0);
        it.u32(step).data(data).bytes
    };
    let with = |at: usize, bytes: &[u8]| {
        let mut message = good.clone();
        message[at..at + bytes.len()].copy_from_slice(bytes);
        message
    };
    let data = rows(3, 0);
    let cases: Vec<(&str, Vec<u8>, &str)> = vec![
        (
            "no header",
            vec![0, 1, 0],
            "3 bytes, fewer than the 4 of CDR's header",
        ),
        (
            "a parameter list",
            with(0, &[0, 3]),
            "encapsulation 0x0003 (PL_CDR_LE, a parameter list)",
        ),
        (
            "a parameter list",
            with(0, &[0, 2]),
            "encapsulation 0x0002 (PL_CDR_BE, a parameter list)",
        ),
        (
            "version 2",
            with(0, &[0, 7]),
            "encapsulation 0x0007 (CDR2_LE)",
        ),
        (
            "nonsense",
            with(0, &[9, 9]),
            "encapsulation 0x0909 (not known)",
        ),
        (
            "only a header",
            good[..4].to_vec(),
            "it ends within header.stamp.sec",
        ),
        (
            "half a stamp",
            good[..10].to_vec(),
            "it ends within header.stamp.nanosec, of which 2 bytes are left",
        ),
        (
            "a long frame",
            with(12, &[255; 4]),
            "header.frame_id claims 4294967295 bytes",
        ),
        (
            "a frame without end",
            with(22, b"x"),
            "header.frame_id is not a text that ends in a zero byte",
        ),
        (
            "data cut",
            good[..good.len() - 1].to_vec(),
            "data claims 4608 bytes, but 4607 are left",
        ),
        (
            "more data",
            [&good[..], &[0; 4]].concat(),
            "4 bytes lie behind its last field",
        ),
        ("no width", image(HEIGHT, 0, 9, &data), "0 x 32 px"),
        ("no height", image(0, WIDTH, 144, &[]), "48 x 0 px"),
        (
            "a huge height",
            image(u32::MAX, WIDTH, 144, &data),
            "48 x 4294967295 px",
        ),
        (
            "a huge product",
            image(32_768, 32_768, 98_304, &data),
            "32768 x 32768 px",
        ),
        (
            "a short step",
            image(HEIGHT, WIDTH, 143, &data),
            "step 143 bytes; a row of 48 px of rgb8 has 144 bytes",
        ),
        (
            "a huge step",
            image(HEIGHT, WIDTH, u32::MAX, &data),
            "data have 4608 bytes; 32 rows with a step of 4294967295",
        ),
        (
            "a row too few",
            image(HEIGHT + 1, WIDTH, 144, &data),
            "data have 4608 bytes; 33 rows with a step of 144 have 4752",
        ),
        (
            "a byte too many",
            image(HEIGHT, WIDTH, 144, &[&data[..], &[0]].concat()),
            "data have 4609 bytes",
        ),
    ];
    for (name, message, expected) in cases {
        let folder = lone(IMAGE, &message);
        let refusal = folder.refusal(folder.request(small(0)));
        assert!(
            refusal.starts_with("topic /cam, message 0: "),
            "{name}: {refusal}"
        );
        assert!(refusal.contains(expected), "{name}: {refusal}");
    }
    // One that comes after the look at the beginning ends the run.
    let mut bag = BagFile::new(WriteOptions::new());
    let id = bag.topic("/cam", IMAGE);
    for k in 0..30 {
        let message = if k == 27 {
            with(0, &[0, 3])
        } else {
            good.clone()
        };
        bag.message(id, TIME + k, &message);
    }
    let folder = Folder::with(&bag.finish());
    let refusal = folder.refusal(folder.request(small(0)));
    assert!(
        refusal.starts_with("topic /cam, message 27: encapsulation 0x0003"),
        "{refusal}"
    );
}

#[test]
fn padding_stays_padding() {
    // As some write it: to a multiple of 4, told in the last bits of the header.
    for (n_told, told) in [(0, 0), (1, 1), (2, 2), (3, 3), (2, 0)] {
        for is_raw in [true, false] {
            let mut message = match is_raw {
                true => raw(false, TIME, "rgb8", 0),
                false => compressed(false, TIME, "png", &file(false)),
            };
            let n_bytes = message.len();
            message.extend(vec![0; n_told]);
            message[3] = told;
            let schema = if is_raw { IMAGE } else { COMPRESSED };
            let folder = lone(schema, &message);
            folder.run(folder.request_of("/cam", small(3)), 1).unwrap();
            let new = folder.output().messages("/cam")[0].1.clone();
            let name = format!("{n_told} told as {told}, raw: {is_raw}");
            assert_ne!(new, message, "{name}");
            if is_raw {
                assert_eq!(
                    (new.len(), &new[..4]),
                    (message.len(), &message[..4]),
                    "{name}"
                );
                assert_eq!(new[n_bytes..], message[n_bytes..], "{name}");
            } else if n_told == 0 {
                assert_eq!(new[3], 0, "{name}");
            } else {
                assert_eq!(new.len() % 4, 0, "{name}");
                let at = 4 + 8 + 4 + 8 + 4 + 4 + 4;
                let n_data = u32::from_le_bytes(new[at - 4..at].try_into().unwrap()) as usize;
                let n_padding = new.len() - at - n_data;
                let expected = if told == 0 { 0 } else { n_padding };
                assert_eq!(usize::from(new[3]), expected, "{name}");
                assert!(n_padding < 4, "{name}: {n_padding}");
            }
        }
    }
}

#[test]
fn a_summary_that_says_less_is_no_harm() {
    // Only the summary of this bag is broken, which serves to stop looking.
    let bag = drive(WriteOptions::new(), 2);
    let before = Content::of(&bag);
    let at = bag.len() - 8 - 20;
    for summary_start in [1_u64, u64::MAX, bag.len() as u64] {
        let mut broken = bag.clone();
        broken[at..at + 8].copy_from_slice(&summary_start.to_le_bytes());
        let folder = Folder::with(&broken);
        folder.run(folder.request(nothing()), 1).unwrap();
        let after = folder.output().without_provenance();
        assert_eq!(after, before, "a summary at {summary_start}");
    }
    let messages = before
        .records
        .iter()
        .filter(|it| matches!(it, Kept::Message(..)));
    assert_eq!(messages.count(), 12, "messages");
    let _ = fs::metadata(".");
}
