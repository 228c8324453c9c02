//! `starbreak demo`: the whole chain on an embedded scene, with nothing needed.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use serde_json::json;
use starbreak::dataset::{
    AnimationParams, Encoding, ImageLimits, OutputBatch, StreetScene, decode_image,
    encode_animation, encode_image, street_scene,
};
use starbreak::pipeline::{
    self, ImageJob, RunContext, Stopwatch, growth_over, growth_times, stage_cracked,
};

use super::crack::item_json;
use crate::args::Global;
use crate::failure::Failure;
use crate::screen::Screen;

/// Frames of the growth animation.
const GROWTH_FRAMES: u32 = 24;

/// Name of the scene's file, which its seed is keyed by.
const SCENE: &str = "scene.png";

pub(crate) fn run(global: &Global, out: &Path, screen: &Screen) -> Result<ExitCode, Failure> {
    let recipe = global.recipe()?;
    let scene = street_scene();
    let pixels = image_of(&scene);
    let scene_png = encode_image(&pixels, &Encoding::Png, None)?;
    let mut batch = OutputBatch::new();
    batch.stage(&out.join(SCENE), &scene_png)?;
    batch.stage(&out.join("scene.boxes.json"), boxes_json(&scene).as_bytes())?;

    let mut written = Vec::new();
    for focus in ["far", "short"] {
        let mut focused = recipe.clone();
        focused.set(&format!("camera.focus_distance_m={focus}"))?;
        let settings = focused.settings()?;
        let context = RunContext::new(&focused, global.seed());
        let watch = Stopwatch::start();
        let file = decode_image(SCENE, &scene_png, &ImageLimits::default())?;
        let job = ImageJob {
            input: PathBuf::from(SCENE),
            name: SCENE.to_owned(),
            stem: format!("{focus}-focus"),
        };
        written.push(stage_cracked(
            &job, file, watch, out, &settings, &context, &mut batch,
        )?);
    }

    let settings = recipe.settings()?;
    let seed = global.seed().of_item(SCENE, 0);
    let simulated = pipeline::simulate(&settings, pixels.width(), pixels.height(), seed)?;
    let network = &simulated.fracture.network;
    batch.stage(&out.join("network.json"), network.to_json().as_bytes())?;
    batch.stage(&out.join("network.svg"), network.to_svg().as_bytes())?;
    batch.stage(
        &out.join("recipe.toml"),
        recipe.to_commented_toml().as_bytes(),
    )?;
    let mut frames = Vec::new();
    for time in growth_times(network, GROWTH_FRAMES) {
        frames.push(growth_over(&pixels, network, time, &settings.optics)?.into_rgb8());
    }
    let delays = AnimationParams {
        delay_ms: 80,
        ..AnimationParams::default()
    };
    batch.stage(&out.join("growth.png"), &encode_animation(frames, &delays)?)?;
    batch.commit()?;

    for item in &written {
        screen.say(&super::crack::describe(item));
    }
    screen.say(&guide(out));
    screen.result(&json!({
        "output": out,
        "scene": out.join(SCENE),
        "boxes": out.join("scene.boxes.json"),
        "network": out.join("network.json"),
        "growth": out.join("growth.png"),
        "images": written.iter().map(item_json).collect::<Vec<_>>(),
    }));
    Ok(ExitCode::SUCCESS)
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

fn guide(out: &Path) -> String {
    let folder = out.display();
    format!(
        "\nin {folder}:\n\
         \x20 scene.png, scene.boxes.json          the street, and the true boxes of its objects\n\
         \x20 far-focus.png, short-focus.png       what the camera sees: focused on the street, on the glass\n\
         \x20 *.region.png, *.crack.png            where the image may differ; where the cracks are\n\
         \x20 *-focus.json                         provenance: recipe, seed, hashes, timings\n\
         \x20 network.json, network.svg            the cracks themselves\n\
         \x20 growth.png                           the crack as it grows (animated PNG; open it in a browser)\n\
         \x20 recipe.toml                          every parameter, with comments\n\
         \n\
         next:\n\
         \x20 starbreak crack photo.png -o cracked              your own photo\n\
         \x20 starbreak demo --seed 3                           another crack\n\
         \x20 starbreak demo --recipe {folder}/recipe.toml      after a change to a parameter\n\
         \x20 starbreak simulate -o network.json --svg net.svg  only the network"
    )
}
