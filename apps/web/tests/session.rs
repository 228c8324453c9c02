//! A session beside the chain that it is made of.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use image::DynamicImage;
use serde_json::{Value, json};
use starbreak::{Chain, Recipe, Seed};
use starbreak_dataset::street_scene;
use starbreak_web::Session;
use starbreak_web_desk::Answer;

fn ask(session: &mut Session, question: &Value) -> Answer {
    session.answer(&question.to_string(), &[]).unwrap()
}

fn with_street() -> Session {
    let mut session = Session::default();
    ask(&mut session, &json!({ "ask": "street" }));
    session
}

fn broken(session: &mut Session, scene: &Value) -> Answer {
    let mut question = scene.clone();
    question["ask"] = "break".into();
    ask(session, &question)
}

/// The street behind the glass of a recipe, by the chain alone.
fn expected(recipe: &Recipe, seed: u64) -> Vec<u8> {
    let mut street = DynamicImage::ImageRgb8(street_scene().image);
    let seed = Seed(seed).of_item("scene.png", 0);
    let chain = Chain::of(&recipe.settings().unwrap(), (1242, 375), seed).unwrap();
    chain.over(&mut street, seed).unwrap();
    street.to_rgba8().into_raw()
}

#[test]
fn a_change_of_lens_or_light_gives_what_breaking_anew_gives() {
    let mut session = with_street();
    broken(
        &mut session,
        &json!({ "preset": "windshield-star", "seed": 3 }),
    );
    for set in [
        "camera.f_number=4.0",
        "camera.focal_length_mm=6.0",
        "camera.focus_distance_m=1.0",
        "camera.blades=6",
        "camera.pixel_pitch_um=4.0",
        "optics.sun_elevation_deg=15.0",
        "optics.model=paper",
        "glass.distance_m=0.3",
        "fracture.mesh=fast",
    ] {
        let scene = json!({ "preset": "windshield-star", "seed": 3, "set": [set] });
        let mut recipe = Recipe::preset("windshield-star").unwrap();
        recipe.set(set).unwrap();
        let given = broken(&mut session, &scene).bytes;
        assert!(given == expected(&recipe, 3), "{set}");
    }
    // With a pixel pitch, what is sharp decides where a line of sight goes, too.
    for (focus, scene_m) in [
        ("0.5", "20.0"),
        ("0.05", "20.0"),
        ("far", "20.0"),
        ("far", "0.5"),
    ] {
        let set = [
            "camera.pixel_pitch_um=4.0".to_owned(),
            format!("camera.scene_distance_m={scene_m}"),
            format!("camera.focus_distance_m={focus}"),
        ];
        let mut recipe = Recipe::preset("windshield-star").unwrap();
        for text in &set {
            recipe.set(text).unwrap();
        }
        let scene = json!({ "preset": "windshield-star", "seed": 3, "set": set });
        let given = broken(&mut session, &scene).bytes;
        assert!(given == expected(&recipe, 3), "{set:?}");
    }
}

#[test]
fn one_hit_is_what_its_assignments_say() {
    let mut session = with_street();
    let hit = json!({ "position": [0.3, 0.6], "azimuth_deg": 20.0, "speed_m_s": 33.0 });
    let scene = json!({ "preset": "windshield-gravel", "seed": 3, "hits": [hit] });
    let answer = broken(&mut session, &scene);
    let mut recipe = Recipe::preset("windshield-gravel").unwrap();
    let assignments = answer.words["assignments"].as_array().unwrap();
    for text in assignments {
        recipe.set(text.as_str().unwrap()).unwrap();
    }
    assert_eq!(assignments.len(), 4, "{assignments:?}");
    assert_eq!(answer.words["recipe"], recipe.to_json());
    assert!(answer.bytes == expected(&recipe, 3), "its pixels");
}

#[test]
fn each_of_several_hits_breaks_the_glass() {
    let mut session = with_street();
    for preset in ["windshield-star", "lens-cover-star", "windshield-bullseye"] {
        let hits = [[0.2, 0.3], [0.5, 0.5], [0.8, 0.6]].map(|at| json!({ "position": at }));
        let scene = json!({ "preset": preset, "severity": 1, "hits": hits });
        let answer = broken(&mut session, &scene);
        let hits = answer.words["damage"]["hits"].as_array().unwrap();
        assert_eq!(hits.len(), 3, "{preset}");
    }
}

#[test]
fn growth_runs_from_nothing_to_the_whole_by_length() {
    let mut session = with_street();
    let whole = broken(
        &mut session,
        &json!({ "preset": "windshield-star", "seed": 3 }),
    );
    let grown = |session: &mut Session, share: f64| {
        ask(session, &json!({ "ask": "grown", "share": share }))
    };
    let lengths: Vec<f64> = [0.0, 0.25, 0.5, 0.75, 1.0]
        .map(|share| {
            grown(&mut session, share).words["length_px"]
                .as_f64()
                .unwrap()
        })
        .into();
    assert!(lengths.is_sorted(), "{lengths:?}");
    assert!(lengths[0].abs() < 1e-9, "{lengths:?}");
    let half = lengths[2] / lengths[4];
    assert!(
        (0.3..0.7).contains(&half),
        "half of the pane's length is {half} of the frame's"
    );
    assert!(grown(&mut session, 1.0).bytes == whole.bytes, "the whole");
    let clean = DynamicImage::ImageRgb8(street_scene().image)
        .to_rgba8()
        .into_raw();
    assert!(grown(&mut session, 0.0).bytes == clean, "nothing");
}

#[test]
fn what_cannot_be_answered_is_said_and_leaves_all_as_it_was() {
    let mut session = Session::default();
    let refusal = |session: &mut Session, question: Value, bytes: &[u8]| {
        session
            .answer(&question.to_string(), bytes)
            .unwrap_err()
            .to_string()
    };
    let early = refusal(&mut session, json!({ "ask": "break" }), &[]);
    assert_eq!(early, "there is no picture yet");
    ask(&mut session, &json!({ "ask": "street" }));
    let early = refusal(&mut session, json!({ "ask": "cracks" }), &[]);
    assert_eq!(early, "there is no broken glass yet");
    let whole = broken(
        &mut session,
        &json!({ "preset": "windshield-star", "seed": 3 }),
    );
    for (question, bytes, words) in [
        (
            json!({ "ask": "break", "preset": "windscreen" }),
            &b""[..],
            "windshield-star",
        ),
        (json!({ "ask": "break", "severity": 6 }), b"", "severity"),
        (
            json!({ "ask": "break", "set": ["camera.fnumber=2"] }),
            b"",
            "camera.f_number",
        ),
        (
            json!({ "ask": "picture", "name": "a.png" }),
            b"GIF89a",
            "a GIF image",
        ),
        (
            json!({ "ask": "frame", "width_px": 2, "height_px": 2 }),
            b"123",
            "3 bytes",
        ),
        (
            json!({ "ask": "frame", "width_px": 1, "height_px": 1 }),
            b"1234",
            "1242",
        ),
        (json!({ "ask": "dance" }), b"", "not a question"),
    ] {
        let said = refusal(&mut session, question.clone(), bytes);
        assert!(said.contains(words), "{question}: {said}");
    }
    let again = ask(&mut session, &json!({ "ask": "grown", "share": 1.0 }));
    assert!(again.bytes == whole.bytes, "the glass is still there");
}

#[test]
fn a_frame_of_a_camera_is_what_a_picture_of_it_would_be() {
    let mut session = with_street();
    let whole = broken(
        &mut session,
        &json!({ "preset": "windshield-star", "seed": 3 }),
    );
    let street = DynamicImage::ImageRgb8(street_scene().image)
        .to_rgba8()
        .into_raw();
    let question = json!({ "ask": "frame", "width_px": 1242, "height_px": 375 }).to_string();
    for _ in 0..2 {
        let frame = session.answer(&question, &street).unwrap();
        assert!(
            frame.bytes == whole.bytes,
            "the same light, the same pixels"
        );
    }
}
