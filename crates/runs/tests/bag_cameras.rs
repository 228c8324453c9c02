//! The cameras of a bag behind broken glass: pixels, panes, recipes, times, and the topics that are added.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use crate::bag_file;

use std::fs;
use std::path::PathBuf;

use bag_file::{
    BagFile, COMPRESSED, Cdr, Content, Folder, HEIGHT, IMAGE, Kept, MASKS, WIDTH, compressed,
    context, data_at, drive, file, nothing, raw, rows, small, stamp_of,
};
use mcap::WriteOptions;
use mcap::records::MessageHeader;
use starbreak_dataset::{
    Encoding, ImageLimits, JpegQuality, decode_image, encode_image, read_image,
};
use starbreak_runs::bag::{Added, BagRequest, CameraRequest, ImpactAt};
use starbreak_runs::clip::Growth;
use starbreak_runs::images::{ImageJob, damage_file};
use starbreak_runs::{Patterns, RunContext};

#[test]
fn pixels_are_those_that_crack_makes_of_the_image() {
    let time = 1_700_000_000_000_000_000;
    let mut bag = BagFile::new(WriteOptions::new());
    let topics = [
        ("/a/rgb", "rgb8", false, 0),
        ("/a/bgr", "bgr8", true, 3),
        ("/a/rgba", "rgba8", false, 1),
        ("/a/bgra", "bgra8", true, 0),
        ("/a/mono", "mono8", false, 7),
    ];
    for (topic, encoding, is_big, filler) in topics {
        let id = bag.topic(topic, IMAGE);
        bag.message(id, time, &raw(is_big, time, encoding, filler));
    }
    for (topic, is_jpeg) in [("/b/jpeg", true), ("/b/png", false)] {
        let id = bag.topic(topic, COMPRESSED);
        bag.message(id, time, &compressed(false, time, "", &file(is_jpeg)));
    }
    let bag = bag.finish();
    for damage in [
        small(5),
        context("windshield-star", &["fracture.mesh=fast"], 5),
    ] {
        let folder = Folder::with(&bag);
        folder.run(folder.request(damage.clone()), 2).unwrap();
        let after = folder.output();
        for (topic, encoding, is_big, filler) in topics {
            let (swapped, n_channels) = match encoding {
                "mono8" => (false, 1),
                "rgba8" | "bgra8" => (encoding == "bgra8", 4),
                _ => (encoding == "bgr8", 3),
            };
            let old = raw(is_big, time, encoding, filler);
            let mut picture = rows(n_channels, 0);
            if swapped {
                picture
                    .chunks_mut(n_channels as usize)
                    .for_each(|it| it.swap(0, 2));
            }
            let mut expected = cracked(&folder, topic, &picture, n_channels, &damage);
            if swapped {
                expected
                    .chunks_mut(n_channels as usize)
                    .for_each(|it| it.swap(0, 2));
            }
            let mut new = old.clone();
            let at = data_at(&old);
            let n_row = (WIDTH * n_channels) as usize;
            for (y, row) in expected.chunks(n_row).enumerate() {
                let at = at + y * (n_row + filler as usize);
                new[at..at + n_row].copy_from_slice(row);
            }
            assert_ne!(new, old, "{topic}");
            assert_eq!(after.messages(topic)[0].1, new, "{topic}");
        }
        for (topic, is_jpeg) in [("/b/jpeg", true), ("/b/png", false)] {
            let name = name_of(topic);
            fs::write(folder.at(&name), file(is_jpeg)).unwrap();
            let cracked = fs::read(crack(&folder, &name, &damage)).unwrap();
            let expected = compressed(false, time, "", &cracked);
            assert!(
                after.messages(topic)[0].1 == expected,
                "{topic}: other bytes"
            );
        }
    }
}

/// A frozen camera shows an earlier picture in the message of now, whose last row has nothing behind it.
#[test]
fn a_frozen_camera_repeats_pixels_and_nothing_else_of_a_message() {
    const FILLER: usize = 5;
    let n_row = WIDTH as usize * 4;
    let message = |k: u8| {
        let stamp_ns = 1_700_000_000_000_000_000 + u64::from(k) * 100_000_000;
        let filler = u32::try_from(FILLER).unwrap();
        let mut message = raw(false, stamp_ns, "bgra8", filler);
        let at = data_at(&message);
        message.truncate(at + (HEIGHT as usize - 1) * (n_row + FILLER) + n_row);
        let n_bytes = u32::try_from(message.len() - at).unwrap();
        message[at - 4..at].copy_from_slice(&n_bytes.to_le_bytes());
        message[at..]
            .iter_mut()
            .for_each(|byte| *byte = byte.wrapping_add(k));
        message
    };
    let messages: Vec<Vec<u8>> = (0..40).map(message).collect();
    let mut bag = BagFile::new(WriteOptions::new());
    let id = bag.topic("/a/bgra", IMAGE);
    for (message, time) in messages.iter().zip(0..) {
        bag.message(id, time, message);
    }
    let folder = Folder::with(&bag.finish());
    let frozen = ["frames.black=0", "frames.frozen=0.5"];
    let damage = context("blank-frames", &frozen, 5);
    folder.run(folder.request(damage), 2).unwrap();
    let after = folder.output().messages("/a/bgra");
    let mut n_repeated = 0;
    for (k, (_, new)) in after.iter().enumerate() {
        let at = data_at(new);
        let shows = |earlier: &Vec<u8>| {
            let mut expected = messages[k].clone();
            for start in (at..expected.len()).step_by(n_row + FILLER) {
                expected[start..start + n_row].copy_from_slice(&earlier[start..start + n_row]);
            }
            expected == *new
        };
        let shown = messages[..=k].iter().rposition(shows).unwrap();
        n_repeated += usize::from(shown < k);
    }
    assert_eq!(after.len(), 40, "all");
    assert!((10..=30).contains(&n_repeated), "half: {n_repeated}");
}

fn name_of(topic: &str) -> String {
    topic.trim_start_matches('/').replace('/', ".")
}

/// What `crack` makes of pixels in a file with the name of a camera.
fn cracked(
    folder: &Folder,
    topic: &str,
    pixels: &[u8],
    n_channels: u32,
    context: &RunContext,
) -> Vec<u8> {
    let image: image::DynamicImage = match n_channels {
        1 => image::GrayImage::from_raw(WIDTH, HEIGHT, pixels.to_vec())
            .unwrap()
            .into(),
        3 => image::RgbImage::from_raw(WIDTH, HEIGHT, pixels.to_vec())
            .unwrap()
            .into(),
        _ => image::RgbaImage::from_raw(WIDTH, HEIGHT, pixels.to_vec())
            .unwrap()
            .into(),
    };
    let png = encode_image(&image, &Encoding::Png, None);
    let name = name_of(topic);
    fs::write(folder.at(&name), png.unwrap()).unwrap();
    let written = crack(folder, &name, context);
    let limits = ImageLimits::default();
    let read = read_image(&written, &limits).unwrap();
    read.pixels.as_bytes().to_vec()
}

fn crack(folder: &Folder, name: &str, context: &RunContext) -> PathBuf {
    let mut context = context.clone();
    context.out = folder.at("cracked");
    context.replaces = true;
    let job = ImageJob {
        input: folder.at(name),
        name: name.to_owned(),
        stem: name.to_owned(),
        image_name: None,
    };
    damage_file(&job, &context, &Patterns::Fresh).unwrap().image
}

#[test]
fn every_camera_has_its_own_pane_and_its_own_recipe() {
    let bag = drive(WriteOptions::new(), 2);
    let folder = Folder::with(&bag);
    folder.run(folder.request(small(3)), 2).unwrap();
    let all = folder.output();
    let mut request = folder.request_of("/front/image_raw", small(3));
    request.cameras.push(CameraRequest {
        topic: "/right/compressed".to_owned(),
        context: nothing(),
    });
    let report = folder.run(request, 2).unwrap();
    let some = folder.output();
    let before = Content::of(&bag);
    let topics = [
        "/front/image_raw",
        "/rear/image_raw",
        "/left/compressed",
        "/right/compressed",
    ];
    for (topic, is_altered) in topics.into_iter().zip([true, false, false, false]) {
        let expected = if is_altered { &all } else { &before };
        assert_eq!(some.messages(topic), expected.messages(topic), "{topic}");
    }
    let names: Vec<_> = report.cameras.iter().map(|it| it.topic.as_str()).collect();
    assert_eq!(names, ["/front/image_raw", "/right/compressed"], "cameras");
    // The panes of front and rear, which show the same pixels but for their order, differ.
    let data = |topic: &str| {
        let message = all.messages(topic)[0].1.clone();
        message[data_at(&message)..].to_vec()
    };
    let front: Vec<u8> = data("/front/image_raw");
    let rear = data("/rear/image_raw");
    let n_row = WIDTH as usize * 4 + 5;
    let green = |row: usize, x: usize| {
        (
            front[(row * WIDTH as usize + x) * 3 + 1],
            rear[row * n_row + x * 4 + 1],
        )
    };
    let differ = (0..HEIGHT as usize).any(|y| {
        (0..WIDTH as usize).any(|x| {
            let (front, rear) = green(y, x);
            front != rear
        })
    });
    assert!(differ, "one pane for both");
    let cameras: serde_json::Value = serde_json::from_str(&some.provenance()["cameras"]).unwrap();
    assert_eq!(cameras[0]["topic"], "/front/image_raw", "{cameras}");
    assert_eq!(cameras[0]["item"]["name"], "front.image_raw", "{cameras}");
    assert_eq!(cameras[0]["seed"], 3, "{cameras}");
    assert_eq!(some.provenance()["schema"], "starbreak.bag/1", "schema");
}

#[test]
fn before_the_hit_nothing_is_altered_and_then_the_cracks_grow() {
    let bag = drive(WriteOptions::new(), 10);
    let before = Content::of(&bag);
    let folder = Folder::with(&bag);
    let request = |impact_at| BagRequest {
        impact_at,
        growth: Growth::Stretched { time_s: 0.3 },
        added: MASKS.to_vec(),
        ..folder.request(small(3))
    };
    let report = folder.run(request(ImpactAt::AfterFirst(0.25)), 2).unwrap();
    let after = folder.output();
    // Frames of the front come at 0, 0.1, 0.2, …, those of the rear 0.02 s later.
    for (topic, first_s) in [("/front/image_raw", 0.3), ("/rear/image_raw", 0.32)] {
        let (old, new) = (before.messages(topic), after.messages(topic));
        assert_eq!(old[..3], new[..3], "{topic}: before the hit");
        assert!(old[9] != new[9] && old[3] != new[3], "{topic}: behind it");
        let camera = report.cameras.iter().find(|it| it.topic == topic).unwrap();
        let (idx, time_s) = camera.damage_onset.unwrap();
        assert_eq!(idx, 3, "{topic}");
        assert!((time_s - first_s).abs() < 1e-9, "{topic}: {time_s} s");
        assert!(camera.n_growing > 0, "{topic}: {camera:?}");
        let n_affected: Vec<usize> = (after.messages(&Added::Region.topic(topic)).iter())
            .map(|(_, mask)| mask[data_at(mask)..].iter().filter(|it| **it > 0).count())
            .collect();
        assert_eq!(n_affected[..3], [0; 3], "{topic}: before the hit");
        assert!(n_affected.is_sorted(), "{topic}: {n_affected:?}");
        // The small crack of the rear is nearly all there with its first step.
        let is_more = n_affected[3] < n_affected[9];
        assert!(
            is_more || topic.starts_with("/rear"),
            "{topic}: {n_affected:?}"
        );
    }
    let stamp = ImpactAt::Stamp(1_700_000_000_250_000_000);
    folder.run(request(stamp), 2).unwrap();
    assert_eq!(folder.output(), after, "by a stamp");
    let late = {
        fs::remove_file(folder.at("out.mcap")).unwrap();
        folder.refusal(request(ImpactAt::AfterFirst(5.0)))
    };
    assert!(
        late.contains("--impact-at: the hit at 5 s comes after the last image, 0.920 s"),
        "{late}"
    );
    let other = folder.refusal(request(ImpactAt::Stamp(250_000_000)));
    assert!(
        other.contains(
            "--impact-at @0.25: the images are stamped by a wall clock, the first at 1700000000.000 s"
        ),
        "{other}"
    );
}

/// A driver that sets no stamps leaves 0, where simulations begin.
#[test]
fn a_stamp_that_was_never_set_is_no_moment() {
    const WALL_NS: u64 = 1_700_000_000_000_000_000;
    let same = |stamp: u64| stamp;
    let bag = |from_ns: u64, unset: &[u64], of_rear: fn(u64) -> u64| {
        let mut bag = BagFile::new(WriteOptions::new());
        let (front, rear) = (bag.topic("/front", IMAGE), bag.topic("/rear", IMAGE));
        let n_images = if unset.len() > 6 { 36 } else { 6 };
        for k in 0..n_images {
            let stamp = match unset.contains(&k) {
                true => 0,
                false => from_ns + k * 100_000_000,
            };
            bag.message(front, k, &raw(false, stamp, "rgb8", 0));
            bag.message(rear, k, &raw(false, of_rear(stamp), "rgb8", 0));
        }
        Folder::with(&bag.finish())
    };
    let altered = |folder: &Folder, impact_at_s: f64| {
        let request = BagRequest {
            impact_at: ImpactAt::AfterFirst(impact_at_s),
            ..folder.request(small(3))
        };
        let report = folder.run(request, 2).unwrap();
        fs::remove_file(folder.at("out.mcap")).unwrap();
        report
            .cameras
            .iter()
            .map(|camera| camera.n_altered)
            .collect::<Vec<_>>()
    };
    // Some have none: the first, as that of the first moment; others, as the one before them.
    let some = bag(WALL_NS, &[0, 2, 5], same);
    assert_eq!(altered(&some, 0.0), [6, 6], "hit from the first on");
    assert_eq!(
        altered(&some, 0.15),
        [3, 3],
        "from 0.2 s after the second on"
    );
    // A driver that begins long before its clock is set.
    let late = bag(WALL_NS, &(0..30).collect::<Vec<_>>(), same);
    assert_eq!(
        altered(&late, 0.15),
        [4, 4],
        "from 0.2 s after the first that is set"
    );
    // A simulation's first stamp is 0.
    let simulated = bag(0, &[], same);
    assert_eq!(altered(&simulated, 0.0), [6, 6], "a simulation");
    assert_eq!(altered(&simulated, 0.15), [4, 4], "a simulation, hit later");
    // None of the rear has any.
    let rear = bag(WALL_NS, &[], |_| 0);
    assert_eq!(altered(&rear, 0.0), [6, 6], "all broken");
    let refused = |folder: &Folder| {
        folder.refusal(BagRequest {
            impact_at: ImpactAt::AfterFirst(0.15),
            ..folder.request(small(3))
        })
    };
    let said = refused(&rear);
    assert!(
        said.contains("topic /rear: its images have no stamps"),
        "{said}"
    );
    // The rear goes by the time since it was started.
    let rear = bag(WALL_NS, &[], |stamp| stamp - WALL_NS + 5_000_000_000);
    let at_stamp = rear.refusal(BagRequest {
        impact_at: ImpactAt::Stamp(5_150_000_000),
        ..rear.request(small(3))
    });
    for said in [refused(&rear), at_stamp] {
        assert!(
            said.contains("topic /rear: its images are stamped by another clock"),
            "{said}"
        );
    }
}

#[test]
fn masks_and_tracks_lie_right_behind_the_image_with_its_times() {
    let bag = drive(WriteOptions::new(), 2);
    let before = Content::of(&bag);
    let folder = Folder::with(&bag);
    let added = vec![Added::Region, Added::Track, Added::Control];
    let request = BagRequest {
        added,
        ..folder.request(small(3))
    };
    folder.run(request, 2).unwrap();
    let after = folder.output();
    let records = after.records.iter();
    let mut messages = records.filter_map(|record| match record {
        Kept::Message(header, data) => Some((header, data)),
        _ => None,
    });
    let mut n_ours = 0;
    for record in &before.records {
        let Kept::Message(old, _) = record else {
            continue;
        };
        let (header, data) = messages.next().unwrap();
        assert_eq!(header, old, "the order");
        let topic = before.topic(old.channel_id).to_owned();
        let ours: &[&str] = match topic.as_str() {
            "/imu" => &[],
            "/left/compressed" => &["region", "track", "control"],
            _ => &["region", "track"],
        };
        for name in ours {
            let (like, added) = messages.next().unwrap();
            assert_eq!(
                after.topic(like.channel_id),
                format!("{topic}/starbreak/{name}"),
                "name"
            );
            let times = |it: &MessageHeader| (it.sequence, it.log_time, it.publish_time);
            assert_eq!(times(like), times(header), "{topic} {name}");
            let schema = &after.schemas[&after.channels[&like.channel_id].1].0;
            match *name {
                "region" => {
                    assert_eq!(schema, IMAGE, "{topic}");
                    let stamp = &stamp_of(data);
                    assert_eq!(&stamp_of(added), stamp, "{topic}: stamp");
                    let mask = &added[data_at(added)..];
                    let head = Cdr::new(false)
                        .header(*stamp, "camera")
                        .u32(HEIGHT)
                        .u32(WIDTH)
                        .text("mono8")
                        .u8(0)
                        .u32(WIDTH)
                        .data(mask);
                    assert_eq!(added, &head.bytes, "{topic}");
                    assert_eq!(mask.len(), (WIDTH * HEIGHT) as usize, "{topic}");
                    assert!(
                        mask.contains(&255) && mask.contains(&0),
                        "{topic}: {mask:?}"
                    );
                }
                "track" => {
                    assert_eq!(schema, "std_msgs/msg/String", "{topic}");
                    let text = String::from_utf8(added[8..added.len() - 1].to_vec()).unwrap();
                    let line: serde_json::Value = serde_json::from_str(&text).unwrap();
                    assert_eq!(line["state"], "still", "{line}");
                    assert!(line["region_fraction"].as_f64().unwrap() > 0.0, "{line}");
                }
                _ => {
                    assert_eq!(schema, COMPRESSED, "{topic}");
                    let quality = JpegQuality::new(95).unwrap();
                    let encoding = Encoding::Jpeg { quality };
                    let limits = ImageLimits::default();
                    let image = decode_image("", &file(true), &limits).unwrap();
                    let again = encode_image(&image.pixels, &encoding, None).unwrap();
                    assert_eq!(
                        added,
                        &compressed(false, stamp_of(data), "jpeg", &again),
                        "{topic}"
                    );
                }
            }
            n_ours += 1;
        }
    }
    assert_eq!(n_ours, 2 * 9, "added messages");
    let topics = after.channels.values().map(|it| it.0.as_str());
    let controls: Vec<&str> = topics.filter(|it| it.ends_with("/control")).collect();
    assert_eq!(
        controls,
        ["/left/compressed/starbreak/control"],
        "of JPEG alone"
    );
    assert!(messages.next().is_none(), "more messages");
    // What was written has these topics already.
    fs::copy(folder.at("out.mcap"), folder.at("in.mcap")).unwrap();
    fs::remove_file(folder.at("out.mcap")).unwrap();
    let request = BagRequest {
        added: MASKS.to_vec(),
        ..folder.request_of("/front/image_raw", small(3))
    };
    let again = folder.refusal(request);
    assert!(
        again.contains("has a topic /front/image_raw/starbreak/region already"),
        "{again}"
    );
}

#[test]
fn images_of_several_sizes_have_a_pane_each() {
    let time = 1_700_000_000_000_000_000;
    let mut bag = BagFile::new(WriteOptions::new());
    let id = bag.topic("/a", IMAGE);
    let other = |k: u64| {
        let header = Cdr::new(false).header(time + k, "camera");
        let size = header
            .u32(HEIGHT / 2)
            .u32(WIDTH)
            .text("mono8")
            .u8(0)
            .u32(WIDTH);
        size.data(&rows(1, 0)[..(WIDTH * HEIGHT / 2) as usize])
            .bytes
    };
    for k in 0..6 {
        let message = match k {
            2 | 3 | 5 => other(k),
            _ => raw(false, time + k, "mono8", 0),
        };
        bag.message(id, time + k, &message);
    }
    let folder = Folder::with(&bag.finish());
    let report = folder.run(folder.request(small(3)), 2).unwrap();
    let camera = &report.cameras[0];
    assert_eq!(
        camera.sizes,
        [(WIDTH, HEIGHT), (WIDTH, HEIGHT / 2)],
        "sizes"
    );
    assert_eq!((camera.n_frames, camera.n_altered), (6, 6), "frames");
    let messages = folder.output().messages("/a");
    let data = |k: usize| messages[k].1[data_at(&messages[k].1)..].to_vec();
    assert_eq!(
        (data(0), data(2)),
        (data(4), data(5)),
        "the same pane again"
    );
}

#[test]
fn a_topic_of_more_sizes_than_panes_are_kept_of_is_refused() {
    let mut bag = BagFile::new(WriteOptions::new());
    let id = bag.topic("/a", IMAGE);
    for k in 0..17 {
        let (width, time) = (WIDTH - 8 + k, u64::from(k) * 1000);
        let data = vec![100; (width * HEIGHT) as usize];
        let head = Cdr::new(false)
            .header(time, "camera")
            .u32(HEIGHT)
            .u32(width);
        let message = head.text("mono8").u8(0).u32(width).data(&data).bytes;
        bag.message(id, time, &message);
    }
    let folder = Folder::with(&bag.finish());
    let refusal = folder.refusal(folder.request(small(3)));
    let expected = "topic /a, message 16: 56 x 32 px, after images of 16 other sizes";
    assert!(refusal.starts_with(expected), "{refusal}");
}

#[test]
fn cameras_without_images_are_reported_with_none() {
    let time = 1_700_000_000_000_000_000;
    let bag = |n_images: u64| {
        let mut bag = BagFile::new(WriteOptions::new().chunk_size(Some(4000)));
        let imu = bag.topic("/imu", "sensor_msgs/msg/Imu");
        bag.message(imu, time, &[1, 2, 3]);
        let front = bag.topic("/front", IMAGE);
        for k in 0..n_images {
            bag.message(front, time + k, &raw(false, time + k, "rgb8", 0));
        }
        // Long after the first messages.
        let _ = bag.topic("/rear", IMAGE);
        bag.message(imu, time + 100, &[4, 5, 6]);
        bag.finish()
    };
    for n_images in [0, 20] {
        let folder = Folder::with(&bag(n_images));
        let report = folder.run(folder.request(small(3)), 1).unwrap();
        let n: Vec<_> = (report.cameras.iter())
            .map(|it| (it.topic.as_str(), it.n_frames))
            .collect();
        assert_eq!(n, [("/front", n_images), ("/rear", 0)], "all");
        let request = BagRequest {
            added: MASKS.to_vec(),
            ..folder.request_of("/rear", small(3))
        };
        let report = folder.run(request, 1).unwrap();
        assert_eq!(report.cameras[0].n_frames, 0, "{report:?}");
        let n_messages = folder.output().messages("/front").len() as u64;
        assert_eq!(n_messages, n_images, "the others stay");
    }
}

#[test]
fn images_stamped_before_the_hit_keep_their_bytes_wherever_they_come() {
    let time = 1_700_000_000_000_000_000;
    let mut bag = BagFile::new(WriteOptions::new());
    let id = bag.topic("/a", IMAGE);
    // The third was taken before the first.
    let stamps = [0, 100, -200, 200].map(|it: i64| time + it * 1_000_000);
    for stamp in stamps.map(i64::cast_unsigned) {
        bag.message(id, stamp, &raw(false, stamp, "rgb8", 0));
    }
    let bag = bag.finish();
    let before = Content::of(&bag).messages("/a");
    let folder = Folder::with(&bag);
    for impact_at in [
        ImpactAt::AfterFirst(0.0),
        ImpactAt::Stamp(time - 100_000_000),
    ] {
        let request = BagRequest {
            impact_at,
            ..folder.request(small(3))
        };
        let report = folder.run(request, 1).unwrap();
        assert_eq!(report.cameras[0].n_altered, 3, "{impact_at:?}: {report:?}");
        let after = folder.output().messages("/a");
        let is_altered: Vec<bool> = (before.iter().zip(&after))
            .map(|(old, new)| old != new)
            .collect();
        assert_eq!(is_altered, [true, true, false, true], "{impact_at:?}");
    }
}
