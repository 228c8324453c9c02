//! `starbreak bag`: what it says, its exit codes, and what it leaves.

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::Path;

use crate::program::{SMALL, all_refused, folder, names, starbreak, succeed, succeed_small};
use mcap::records::MessageHeader;
use mcap::{MessageStream, WriteOptions, Writer};
use serde_json::Value;

const SIZE_PX: (u32, u32) = (96, 64);

/// `sensor_msgs/msg/Image` in mono8, whose sides are such that nothing is padded but the encoding.
fn message(stamp: u32) -> Vec<u8> {
    let (width, height) = SIZE_PX;
    let mut bytes = vec![0, 1, 0, 0];
    let number = |bytes: &mut Vec<u8>, number: u32| bytes.extend(number.to_le_bytes());
    number(&mut bytes, stamp);
    number(&mut bytes, 0);
    number(&mut bytes, 4);
    bytes.extend(b"cam\0");
    number(&mut bytes, height);
    number(&mut bytes, width);
    number(&mut bytes, 6);
    bytes.extend(b"mono8\0\0\0");
    number(&mut bytes, width);
    number(&mut bytes, width * height);
    bytes.extend((0..width * height).map(|k| u8::try_from(60 + k * 7 % 150).unwrap()));
    bytes
}

/// Two cameras, five images each, a second apart.
fn write_bag(path: &Path) {
    let options = WriteOptions::new().profile("ros2").chunk_size(Some(10_000));
    let mut bag: Writer<Cursor<Vec<u8>>> = options.create(Cursor::new(Vec::new())).unwrap();
    let schema = bag
        .add_schema("sensor_msgs/msg/Image", "ros2msg", b"")
        .unwrap();
    let mut topic = |topic| {
        bag.add_channel(schema, topic, "cdr", &BTreeMap::new())
            .unwrap()
    };
    let ids = [topic("/cam/front"), topic("/cam/rear")];
    for stamp in 0..5 {
        for channel_id in ids {
            let header = MessageHeader {
                channel_id,
                sequence: stamp,
                log_time: u64::from(stamp) * 1_000_000_000,
                publish_time: u64::from(stamp),
            };
            let data = message(100 + stamp);
            bag.write_to_known_channel(&header, &data).unwrap();
        }
    }
    bag.finish().unwrap();
    fs::write(path, bag.into_inner().into_inner()).unwrap();
}

/// Messages of a topic.
fn messages(path: &Path, topic: &str) -> Vec<Vec<u8>> {
    let bytes = fs::read(path).unwrap();
    let all = MessageStream::new(&bytes).unwrap().map(Result::unwrap);
    let of_topic = all.filter(|message| message.channel.topic == topic);
    of_topic.map(|message| message.data.into_owned()).collect()
}

#[test]
fn all_cameras_are_damaged_and_told_of() {
    let dir = folder();
    let at = |name: &str| dir.path().join(name);
    write_bag(&at("in.mcap"));
    let said = succeed_small(dir.path(), &["bag", "in.mcap", "-o", "out.mcap"]).stdout;
    assert!(said.starts_with("out.mcap: 10 messages in "), "{said}");
    assert!(
        said.contains("/cam/front: 5 of 5 images damaged; "),
        "{said}"
    );
    assert_eq!(names(dir.path()), ["in.mcap", "out.mcap"], "files");
    for topic in ["/cam/front", "/cam/rear"] {
        let (before, after) = (
            messages(&at("in.mcap"), topic),
            messages(&at("out.mcap"), topic),
        );
        assert_eq!(before.len(), after.len(), "{topic}");
        assert!(
            before
                .iter()
                .zip(&after)
                .all(|(before, after)| before != after),
            "{topic}"
        );
    }
    let json = [
        "bag",
        "in.mcap",
        "-o",
        "b.mcap",
        "--json",
        "--impact-at",
        "@102.5",
        "--masks",
    ];
    let result: Value = serde_json::from_str(&succeed_small(dir.path(), &json).stdout).unwrap();
    let front = &result["cameras"][0];
    assert_eq!(front["topic"], "/cam/front", "{result}");
    assert_eq!(front["damage_onset"]["frame_idx"], 3, "{result}");
    assert_eq!(front["n_altered"], 2, "{result}");
    assert_eq!(result["input_damage"], Value::Null, "{result}");
    assert_eq!(
        messages(&at("b.mcap"), "/cam/rear/starbreak/region").len(),
        5,
        "masks"
    );
}

#[test]
fn a_camera_may_have_its_own_recipe() {
    let dir = folder();
    let at = |name: &str| dir.path().join(name);
    write_bag(&at("in.mcap"));
    let recipe = succeed_small(dir.path(), &["recipe"]).stdout;
    fs::write(at("own.toml"), recipe).unwrap();
    let own = [
        "bag",
        "in.mcap",
        "-o",
        "own.mcap",
        "--topic",
        "/cam/front=own.toml",
        "--topic",
        "/cam/rear=noise",
    ];
    succeed(dir.path(), &own);
    succeed_small(dir.path(), &["bag", "in.mcap", "-o", "all.mcap"]);
    let both = |topic: &str| ["own.mcap", "all.mcap"].map(|name| messages(&at(name), topic));
    let [own, all] = both("/cam/front");
    assert!(own == all, "the same recipe gives the same images");
    let [own, all] = both("/cam/rear");
    assert!(own != all, "another recipe gives others");
    // The camera that is not named stays clean.
    succeed_small(
        dir.path(),
        &["bag", "in.mcap", "-o", "one.mcap", "--topic", "/cam/front"],
    );
    let rear = messages(&at("one.mcap"), "/cam/rear");
    assert!(
        rear == messages(&at("in.mcap"), "/cam/rear"),
        "a camera that is not named"
    );
}

#[test]
fn a_bag_that_is_cut_ends_with_code_1_and_a_bag_that_is_whole() {
    let dir = folder();
    write_bag(&dir.path().join("whole.mcap"));
    let bytes = fs::read(dir.path().join("whole.mcap")).unwrap();
    fs::write(dir.path().join("in.mcap"), &bytes[..bytes.len() * 2 / 3]).unwrap();
    let args = [&["bag", "in.mcap", "-o", "out.mcap"][..], &SMALL].concat();
    let outcome = starbreak(dir.path(), &args);
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    let expected = "error: \"in.mcap\" is not whole: the file ends within a record (byte ";
    assert!(outcome.stderr.starts_with(expected), "{outcome:?}");
    let n_messages = messages(&dir.path().join("out.mcap"), "/cam/front").len();
    assert!((1..5).contains(&n_messages), "{n_messages} messages");
}

#[test]
fn what_makes_no_sense_is_refused_and_nothing_is_written() {
    let dir = folder();
    let at = dir.path();
    write_bag(&at.join("in.mcap"));
    fs::write(at.join("old.bag"), b"#ROSBAG V2.0\nand more").unwrap();
    fs::write(at.join("there.mcap"), b"of somebody").unwrap();
    fs::write(at.join("r.toml"), "schema = 1\n").unwrap();
    let bag = |more: &[&'static str]| [&["bag", "in.mcap", "-o", "out.mcap"], more].concat();
    all_refused(
        at,
        &[
            (
                vec!["bag", "old.bag", "-o", "out.mcap"],
                "mcap convert \"old.bag\" \"old.mcap\"",
            ),
            (
                vec!["bag", "none.mcap", "-o", "out.mcap"],
                "cannot read \"none.mcap\"",
            ),
            (
                vec!["bag", "in.mcap", "-o", "in.mcap"],
                "would replace the input",
            ),
            (vec!["bag", "in.mcap", "-o", "there.mcap"], "there.mcap"),
            (
                vec![
                    "bag",
                    "in.mcap",
                    "-o",
                    "r.toml",
                    "--topic",
                    "/cam/rear=r.toml",
                ],
                "would replace the recipe",
            ),
            (
                bag(&["--topic", "/no"]),
                "has no topic /no; its cameras are /cam/front, /cam/rear",
            ),
            (bag(&["--topic", "/cam/rear=none.toml"]), "none.toml"),
            (bag(&["--topic", "/cam/rear=nose"]), "did you mean `noise`?"),
            (
                vec!["bag", "in.mcap", "-o", "-"],
                "a name that ends in .mcap",
            ),
            (
                vec!["bag", "in.mcap", "-o", "out.bag"],
                "a name that ends in .mcap",
            ),
            (
                vec!["bag", ".", "-o", "out.mcap"],
                "\".\" is a folder; give the .mcap in it",
            ),
            (
                bag(&["--topic", "/cam/rear=r.toml", "--severity", "2"]),
                "--severity scales a preset",
            ),
            (bag(&["--topic", "=r.toml"]), "expected a topic"),
            (bag(&["--impact-at", "-1"]), "seconds after the first image"),
            (
                bag(&["--impact-at", "9", "--set", "fracture.mesh=fast"]),
                "comes after the last image, 4.000 s",
            ),
            (bag(&["--growth-time", "1"]), "--grow"),
            (bag(&["--grow", "--preset", "noise"]), "no glass breaks"),
            (bag(&["--control"]), "--control is for JPEG"),
            (
                bag(&["--set", "output.format=png"]),
                "a message keeps its format",
            ),
        ],
    );
}
