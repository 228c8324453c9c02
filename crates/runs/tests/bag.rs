//! A bag behind broken glass: what stays record for record, what is altered, and by what.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use crate::bag_file;

use std::fs;
use std::sync::atomic::AtomicBool;

use bag_file::suite;
use bag_file::{
    Content, Folder, IMAGE, Kept, MASKS, context, data_at, drive, nothing, packings, silent, small,
};
use mcap::WriteOptions;
use starbreak_dataset::sha256_hex;
use starbreak_runs::bag::{Added, BagRequest, ImpactAt};
use starbreak_runs::clip::Growth;

#[test]
fn glass_that_nothing_hits_leaves_every_record_as_it_is() {
    for (name, options) in packings() {
        let bag = drive(options, 4);
        let before = Content::of(&bag);
        let n_messages = before
            .records
            .iter()
            .filter(|it| matches!(it, Kept::Message(..)));
        assert_eq!(n_messages.count(), 24, "{name}");
        let folder = Folder::with(&bag);
        let report = folder.run(folder.request(nothing()), 2).unwrap();
        assert_eq!(report.n_messages, 24, "{name}");
        assert_eq!(report.damage, None, "{name}");
        assert_eq!(folder.output().without_provenance(), before, "{name}");
        let n: Vec<_> = report
            .cameras
            .iter()
            .map(|it| (it.n_frames, it.n_altered))
            .collect();
        assert_eq!(n, [(4, 0); 4], "{name}");
    }
}

/// SHA-256 of the SHA-256 of each file of MCAP's conformance suite, in hexadecimal, in their order, a line each, as the
/// pointers to them say that lie in its repository (`tests/conformance/data`).
const SUITE_SHA256: &str = "7527a8c627d3bca60247b5ad6f651aa6116d2be8fed434dc041dbfd78de39487";

#[test]
fn the_files_of_the_conformance_suite_stay_as_they_are() {
    let mut hashes = Vec::new();
    for (name, counts, has_schema, choices) in suite::CONTENTS {
        for chosen in suite::subsets(choices) {
            let bag = suite::bag(counts, has_schema, &chosen);
            hashes.push(sha256_hex(&bag));
            let before = Content::of(&bag);
            let n_records: u32 = counts.into_iter().sum();
            assert_eq!(
                before.records.len(),
                n_records as usize,
                "{name} {chosen:?}"
            );
            let folder = Folder::with(&bag);
            // It has no camera, so none is asked for.
            let request = BagRequest {
                all: None,
                ..folder.request(nothing())
            };
            let report = folder.run(request, 1).unwrap();
            assert_eq!(report.damage, None, "{name} {chosen:?}");
            let after = folder.output().without_provenance();
            assert_eq!(after, before, "{name} {chosen:?}");
        }
    }
    assert_eq!(hashes.len(), 416, "files of the suite");
    hashes.sort();
    let all: String = hashes.iter().map(|hash| format!("{hash}\n")).collect();
    assert_eq!(
        sha256_hex(all.as_bytes()),
        SUITE_SHA256,
        "they are its files"
    );
}

#[test]
fn topics_that_stand_in_the_summary_alone_stay() {
    for (name, options) in packings().into_iter().take(4) {
        let bag = drive(options.emit_summary_offsets(false), 2);
        let bag = silent(&bag, 40, "/late/image_raw", IMAGE);
        let bag = silent(&bag, 41, "/tf", "tf2_msgs/msg/TFMessage");
        let before = Content::of(&bag);
        assert_eq!(before.topic(41), "/tf", "{name}");
        let folder = Folder::with(&bag);
        let report = folder.run(folder.request(nothing()), 1).unwrap();
        assert_eq!(folder.output().without_provenance(), before, "{name}");
        let n: Vec<_> = report.cameras.iter().map(|it| it.n_frames).collect();
        assert_eq!(n, [2, 0, 2, 2, 2], "{name}");
        // It may be named, too, and has its topics of masks then.
        let request = BagRequest {
            added: MASKS.to_vec(),
            ..folder.request_of("/late/image_raw", small(3))
        };
        let report = folder.run(request, 1).unwrap();
        assert_eq!(report.cameras[0].n_frames, 0, "{name}");
        let after = folder.output().without_provenance();
        assert_eq!(after.records, before.records, "{name}");
        let region = Added::Region.topic("/late/image_raw");
        assert!(
            after.channels.values().any(|it| it.0 == region),
            "{name}: no channel of masks"
        );
        fs::remove_file(folder.at("out.mcap")).unwrap();
        let refusal = folder.refusal(folder.request_of("/tf", small(3)));
        assert!(
            refusal.contains("topic /tf is tf2_msgs/msg/TFMessage in cdr: it holds no images"),
            "{name}: {refusal}"
        );
    }
}

#[test]
fn what_an_earlier_run_added_is_no_camera() {
    let folder = Folder::with(&drive(WriteOptions::new(), 2));
    let request = BagRequest {
        added: Added::ALL.to_vec(),
        ..folder.request(small(3))
    };
    folder.run(request, 1).unwrap();
    let first = fs::read(folder.at("out.mcap")).unwrap();
    let before = Content::of(&first);
    // With a summary and without.
    for bag in [&first[..], &first[..first.len() - 20]] {
        let folder = Folder::with(bag);
        let report = folder.run(folder.request(small(4)), 1).unwrap();
        assert_eq!(report.cameras.len(), 4, "{report:?}");
        let after = folder.output();
        for camera in &report.cameras {
            assert_eq!(camera.n_altered, 2, "{camera:?}");
            for added in Added::ALL {
                let topic = added.topic(&camera.topic);
                assert_eq!(after.messages(&topic), before.messages(&topic), "{topic}");
            }
        }
    }
    let folder = Folder::with(&first);
    let region = Added::Region.topic("/front/image_raw");
    let refusal = folder.refusal(folder.request_of(&region, small(4)));
    assert!(
        refusal.contains("an earlier run of starbreak added it"),
        "{refusal}"
    );
}

#[test]
fn of_what_is_altered_only_the_data_are_others() {
    for (name, options) in packings() {
        let bag = drive(options, 3);
        let before = Content::of(&bag);
        let folder = Folder::with(&bag);
        let report = folder.run(folder.request(small(3)), 2).unwrap();
        assert!(
            report.cameras.iter().all(|it| it.n_altered == 3),
            "{name}: {report:?}"
        );
        let after = folder.output().without_provenance();
        assert_eq!(after.schemas, before.schemas, "{name}");
        assert_eq!(after.channels, before.channels, "{name}");
        assert_eq!(after.records.len(), before.records.len(), "{name}");
        for (after, then) in after.records.iter().zip(&before.records) {
            let (Kept::Message(after, new), Kept::Message(then, old)) = (after, then) else {
                assert_eq!(after, then, "{name}");
                continue;
            };
            assert_eq!(after, then, "{name}: header of a message");
            match before.topic(then.channel_id) {
                "/front/image_raw" | "/rear/image_raw" => {
                    let at = differences(old, new).unwrap();
                    let n_data = old.len() - data_at(old);
                    assert!(
                        !at.is_empty() && at.len() < n_data,
                        "{name}: {} bytes",
                        at.len()
                    );
                    assert!(at[0] >= data_at(old), "{name}: byte {}", at[0]);
                }
                "/left/compressed" | "/right/compressed" => {
                    assert_ne!(old, new, "{name}");
                    let at = data_at(old);
                    assert_eq!(old[..at - 4], new[..at - 4], "{name}: before data");
                    let is_big = old[1] == 0;
                    let told = new[at - 4..at].try_into().unwrap();
                    let told = if is_big {
                        u32::from_be_bytes(told)
                    } else {
                        u32::from_le_bytes(told)
                    };
                    assert_eq!(told as usize, new.len() - at, "{name}: length of data");
                }
                _ => assert_eq!(old, new, "{name}: a message without images"),
            }
        }
    }
}

/// Where two messages differ: none where their lengths do.
fn differences(a: &[u8], b: &[u8]) -> Option<Vec<usize>> {
    let pairs = a.iter().zip(b).enumerate();
    let differ = pairs.filter(|(_, (a, b))| a != b).map(|(at, _)| at);
    (a.len() == b.len()).then(|| differ.collect())
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    let folder = Folder::with(&drive(WriteOptions::new().chunk_size(Some(4000)), 9));
    let mut outputs = Vec::new();
    for n_threads in [1, 2, 5] {
        let request = BagRequest {
            added: MASKS.to_vec(),
            growth: Growth::Stretched { time_s: 0.4 },
            impact_at: ImpactAt::AfterFirst(0.2),
            ..folder.request(small(1))
        };
        folder.run(request, n_threads).unwrap();
        outputs.push(fs::read(folder.at("out.mcap")).unwrap());
    }
    assert!(
        outputs[0] == outputs[1] && outputs[0] == outputs[2],
        "other bytes"
    );
}

#[test]
fn masks_do_not_depend_on_the_number_of_threads_where_deposits_age() {
    let folder = Folder::with(&drive(WriteOptions::new(), 9));
    let dewy = context(
        "windshield-star",
        &[
            "fracture.mesh=fast",
            "condensation.age_s=20.0",
            "condensation.growth_um_s=0.5",
            "dust.coverage_percent=2.0",
        ],
        1,
    );
    let mut outputs = Vec::new();
    for n_threads in [1, 8] {
        let request = BagRequest {
            added: MASKS.to_vec(),
            impact_at: ImpactAt::AfterFirst(0.5),
            ..folder.request_of("/front/image_raw", dewy.clone())
        };
        folder.run(request, n_threads).unwrap();
        outputs.push(folder.output());
    }
    for topic in MASKS.map(|it| it.topic("/front/image_raw")) {
        let [few, many] = [0, 1].map(|k: usize| outputs[k].messages(&topic));
        assert_eq!(few.len(), 9, "{topic}");
        assert!(few == many, "{topic}: other bytes");
    }
}

#[test]
fn a_run_that_is_stopped_writes_nothing() {
    let folder = Folder::with(&drive(WriteOptions::new(), 5));
    let bag = starbreak_runs::bag::Bag::open(folder.request(small(3))).unwrap();
    assert_eq!(bag.n_frames(), Some(20), "images that the summary has");
    let stop = AtomicBool::new(true);
    assert!(bag.run(&stop, || ()).unwrap().is_none(), "stopped");
    assert!(!folder.at("out.mcap").exists(), "nothing is written");
}
