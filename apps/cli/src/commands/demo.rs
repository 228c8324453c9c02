//! `starbreak demo`: the whole chain on an embedded scene, with nothing needed.

use std::path::{Path, PathBuf};

use serde_json::{Map, json};
use starbreak::{Chain, PaneLayer, Stopwatch, growth_times};
use starbreak_dataset::{
    AnimationParams, Encoding, FileSet, ImageLimits, StreetScene, decode_image, encode_animation,
    encode_image, street_scene,
};
use starbreak_runs::images::{ImageJob, Written, chain_for, stage_shown};
use starbreak_runs::{Patterns, RunContext};

use super::crack::item_json;
use crate::args::Global;
use crate::failure::{DONE, Failure};
use crate::interrupt::Interrupt;
use crate::screen::{Screen, path_text};

/// Frames of the growth animation.
const GROWTH_FRAMES: u32 = 24;

/// Name of the scene's file, which its seed is keyed by.
const SCENE: &str = "scene.png";

pub(crate) fn run(global: &Global, out: &Path, screen: &Screen) -> Result<u8, Failure> {
    let names = [
        "network.json",
        "network.svg",
        "growth.png",
        "scene.png",
        "scene.boxes.json",
    ];
    global.refuse_recipe_among(&names.map(|name| out.join(name)))?;
    let recipe = global.recipe()?;
    let interrupt = Interrupt::listen(screen);
    let scene = street_scene();
    let pixels = image_of(&scene);
    let scene_png = encode_image(&pixels, &Encoding::Png, None)?;
    let recipes: Vec<PathBuf> = global.recipe.iter().cloned().collect();
    let batch = global.batch().never_over(FileSet::of(&recipes));
    let mut batch = batch.with_list(&out.join("written.json"), "demo");
    batch.stage(&out.join(SCENE), &scene_png)?;
    batch.stage(&out.join("scene.boxes.json"), boxes_json(&scene).as_bytes())?;

    let mut stage = |focus: &str| -> Result<Written, Failure> {
        interrupt.check()?;
        let mut focused = recipe.clone();
        focused.set(&format!("camera.focus_distance_m={focus}"))?;
        let context = RunContext::new(&focused, global.seed(), out)?;
        let mut watch = Stopwatch::start();
        let mut file = decode_image(SCENE, &scene_png, &ImageLimits::default())?;
        let job = ImageJob {
            input: PathBuf::from(SCENE),
            name: SCENE.to_owned(),
            stem: format!("{focus}-focus"),
            image_name: None,
        };
        let chain = chain_for(&job, &file, &context, &Patterns::Fresh, &mut watch)?;
        Ok(stage_shown(
            &job, &mut file, chain, watch, &context, &mut batch,
        )?)
    };
    let written = [stage("far")?, stage("short")?];

    let settings = recipe.settings()?;
    // Both pictures show the same glass: focus is no part of its breaking.
    let Some(network) = written[0].chain.network() else {
        return Err(Failure::wrong_input("the demo shows no network"));
    };
    batch.stage(&out.join("network.json"), network.to_json().as_bytes())?;
    batch.stage(&out.join("network.svg"), network.to_svg().as_bytes())?;
    // A recipe that was edited there and given again stays as its author wrote it.
    let recipe_path = out.join("recipe.toml");
    if global
        .refuse_recipe_among(std::slice::from_ref(&recipe_path))
        .is_ok()
    {
        batch.stage(&recipe_path, recipe.to_commented_toml().as_bytes())?;
    }
    let mut frames = Vec::new();
    let seed = global.seed().of_item(SCENE, 0);
    let size = (pixels.width(), pixels.height());
    for time in growth_times(network, GROWTH_FRAMES) {
        interrupt.check()?;
        let mut frame = pixels.clone();
        let grown = PaneLayer::of_network(&settings, (network, time), size, seed)?;
        Chain::of_layer(&settings, grown, Map::new(), false).over(&mut frame, seed)?;
        frames.push(frame.into_rgb8());
    }
    let delays = AnimationParams {
        delay_ms: 80,
        ..AnimationParams::default()
    };
    batch.stage(&out.join("growth.png"), &encode_animation(frames, &delays)?)?;
    interrupt.check()?;
    batch.commit()?;

    for item in &written {
        screen.say(&super::crack::describe(item));
    }
    screen.say(&guide(out, &written));
    screen.result(|| {
        json!({
            "output": path_text(out),
            "scene": path_text(out.join(SCENE)),
            "boxes": path_text(out.join("scene.boxes.json")),
            "network": path_text(out.join("network.json")),
            "growth": path_text(out.join("growth.png")),
            "images": written.iter().map(item_json).collect::<Vec<_>>(),
        })
    })?;
    Ok(DONE)
}

fn image_of(scene: &StreetScene) -> image::DynamicImage {
    image::DynamicImage::ImageRgb8(scene.image.clone())
}

/// The ground truth of the scene: class and box of every object.
fn boxes_json(scene: &StreetScene) -> String {
    let objects = scene
        .objects
        .iter()
        .map(|object| json!({ "category": object.category, "bbox_xyxy_px": object.bbox_xyxy_px }));
    let value = json!({
        "schema": "starbreak.boxes/1",
        "image": SCENE,
        "width_px": scene.image.width(),
        "height_px": scene.image.height(),
        "objects": objects.collect::<Vec<_>>(),
    });
    format!("{value:#}\n")
}

/// What lies in the folder, and what to try next.
fn guide(out: &Path, written: &[Written]) -> String {
    let folder = out.display();
    let names = |of: &dyn Fn(&Written) -> Option<&PathBuf>| {
        let names = written
            .iter()
            .filter_map(of)
            .filter_map(|path| path.file_name());
        names
            .map(|name| name.to_string_lossy().into_owned())
            .collect::<Vec<_>>()
            .join(", ")
    };
    let lines = [
        (
            "scene.png, scene.boxes.json".to_owned(),
            "the street, and the true boxes of its objects",
        ),
        (
            names(&|item| Some(&item.image)),
            "what the camera sees: focused on the street, on the glass",
        ),
        (
            names(&|item| item.region.as_ref()),
            "where the crack influences the image",
        ),
        (names(&|item| item.crack.as_ref()), "where the cracks are"),
        (
            names(&|item| Some(&item.provenance)),
            "provenance: recipe, seed, hashes, timings",
        ),
        (
            "network.json, network.svg".to_owned(),
            "the cracks themselves",
        ),
        (
            "growth.png".to_owned(),
            "the crack as it grows (animated PNG; open it in a browser)",
        ),
        ("recipe.toml".to_owned(), "every parameter, with comments"),
        (
            "written.json".to_owned(),
            "these files with their hashes: the next demo may replace them",
        ),
    ];
    let mut text = format!("\nin {folder}:\n");
    for (names, what) in lines.iter().filter(|(names, _)| !names.is_empty()) {
        text.push_str(&format!("  {names:46}  {what}\n"));
    }
    text.push_str(&format!(
        "\nnext:\n\
         \x20 starbreak crack photo.png -o cracked              your own photo\n\
         \x20 starbreak simulate -o network.json --svg net.svg  only the network\n\
         \x20 another crack:\n\
         \x20   starbreak demo -o {folder} --seed 3\n\
         \x20 after a change to a parameter:\n\
         \x20   starbreak demo -o {folder} --recipe {folder}/recipe.toml"
    ));
    text
}
