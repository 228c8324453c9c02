use std::fs;
use std::path::{Component, Path};

use starbreak_dataset::{FileRole, PlaceMap, Source, SourceFormat, SourceImage, SourceSpec};

use crate::Vocabulary;

/// Words of labels and index files, and values that sit on an edge.
pub(crate) const VOCABULARY: Vocabulary = &[
    "\"images\":[",
    "\"annotations\":[",
    "\"categories\":[",
    "\"frames\":[",
    "\"labels\":null",
    "{\"id\":1,\"file_name\":\"b.png\"}",
    "\"image_id\":1",
    "\"category_id\":1",
    "\"iscrowd\":true",
    "\"bbox\":[1,2,3,4]",
    "\"box2d\":{\"x1\":1,\"y1\":2,\"x2\":3,\"y2\":4}",
    "\"videoName\":\"v\"",
    "\"name\":\"b.png\"",
    "b.png",
    "B.PNG",
    "../",
    "/",
    "./",
    "\\",
    "\\u0000",
    "\\ud800",
    "C:",
    "null",
    "[[[[",
    "]}",
    ",",
    "1e308",
    "-1e308",
    "1e-308",
    "1e400",
    "-0",
    "nan",
    "inf",
    "9223372036854775808",
    "DontCare",
    "\n",
    "\r\n",
    "path: ",
    "train: ",
    "names: ",
    "- ",
    "&a ",
    "*a",
    "|\n ",
    "\"",
    "# ",
    "\u{feff}",
    "\u{202e}",
];

/// A picture of one pixel.
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x01\0\0\0\x01\x08\0\0\0\0\x3a\x7e\x9b\x55\
    \0\0\0\nIDATx\x9cc`\0\0\0\x02\0\x01\x48\xaf\xa4\x71\0\0\0\0IEND\xae\x42\x60\x82";

/// A dataset with a file of these bytes is refused with one printable line, or gives images whose
/// names stay inside, boxes that are boxes, the same on a second walk, and after its index was
/// written for the images that are there.
///
/// The first line says what the rest is: `coco`, `bdd`, `list`, `data` (a `data.yaml`), `kitti` or
/// `yolo` (labels of one image).
///
/// # Panics
/// If the input is a finding, or the folder of temporary files cannot be written.
pub fn source(bytes: &[u8]) {
    let Some(line) = bytes.iter().position(|byte| *byte == b'\n') else {
        return;
    };
    let (kind, bytes) = (&bytes[..line], &bytes[line + 1..]);
    let (format, file, path) = match kind {
        b"coco" => (SourceFormat::Coco, "annotations/instances_x.json", ""),
        b"bdd" => (SourceFormat::Bdd, "labels/det_20/x.json", ""),
        b"list" => (SourceFormat::List, "list.txt", "list.txt"),
        b"data" => (SourceFormat::Yolo, "data.yaml", ""),
        b"kitti" => (SourceFormat::Kitti, "label_2/a.txt", ""),
        b"yolo" => (SourceFormat::Yolo, "labels/a.txt", ""),
        _ => return,
    };
    let dir = match tempfile::tempdir() {
        Ok(dir) => dir,
        Err(error) => panic!("no folder: {error}"),
    };
    // One folder deeper, so that a path that leads out is still ours.
    let root = dir.path().join("set");
    let images = match format {
        SourceFormat::Kitti => "image_2",
        _ => "images",
    };
    put(&root, &format!("{images}/a.png"), PNG);
    put(&root, &format!("{images}/b.png"), PNG);
    if kind == b"yolo" {
        put(&root, "data.yaml", b"train: images\nnames: [a, b]\n");
    }
    put(&root, file, bytes);
    let spec = SourceSpec::new(format, root.join(path));
    let source = match Source::open(&spec) {
        Ok(source) => source,
        Err(error) => return check_message(&error.to_string()),
    };
    let images = walk(&source);
    assert_eq!(walk(&source), images, "a second walk");

    move_labels(&source, &images);
    let index = source.files().flatten().find(|f| f.role == FileRole::Index);
    let Some(index) = index.filter(|index| index.name == file) else {
        return;
    };
    let mut part = Vec::new();
    let mut is_kept = |name: &str| images.iter().any(|image| image.name == name);
    if let Err(error) = source.subset(&index, &mut is_kept, &mut part) {
        panic!("cannot write the index: {error}");
    }
    put(source.root(), file, &part);
    match Source::open(&spec) {
        Ok(again) => {
            let again: Vec<_> = walk(&again).into_iter().map(plain).collect();
            let images: Vec<_> = images.into_iter().map(plain).collect();
            assert_eq!(again, images, "written and read again");
        }
        Err(error) => assert!(images.is_empty(), "does not read what it wrote: {error}"),
    }
}

/// A lens that turns and shrinks what is near the middle, and shows nothing else.
struct Lens([f64; 2]);

impl PlaceMap for Lens {
    fn seen_at(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        let [u, v] = [x - self.0[0], y - self.0[1]];
        let is_seen = u * u + v * v < 9.0;
        is_seen.then_some([self.0[0] + 0.5 * v, self.0[1] - 0.5 * u])
    }

    fn shown_at(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        let [u, v] = [x - self.0[0], y - self.0[1]];
        Some([self.0[0] - 2.0 * v, self.0[1] + 2.0 * u])
    }
}

/// Labels are moved or refused by name.
fn move_labels(source: &Source, images: &[SourceImage]) {
    let motion = |(width, height): (u32, u32)| -> Box<dyn PlaceMap> {
        Box::new(Lens([0.5 * f64::from(width), 0.5 * f64::from(height)]))
    };
    for image in images {
        match source.moved_objects(image, &motion) {
            Ok(objects) => assert!(
                objects.len() <= image.objects.len(),
                "none comes from nowhere"
            ),
            Err(error) => check_message(&error.to_string()),
        }
    }
    for file in source.files().flatten() {
        let mut moved = Vec::new();
        let checked = source.check_movable(&file, &mut |_| true);
        let written = match file.role {
            FileRole::Other => continue,
            _ => source.write_moved(&file, &motion, &mut |_| true, &mut moved),
        };
        for error in checked.err().into_iter().chain(written.err()) {
            check_message(&error.to_string());
        }
    }
}

/// What the index says of an image.
fn plain(mut image: SourceImage) -> SourceImage {
    image.problems.clear();
    image
}

fn walk(source: &Source) -> Vec<SourceImage> {
    let mut images: Vec<SourceImage> = Vec::new();
    for image in source.images() {
        match image {
            Ok(image) => {
                check_name(&image.name);
                for problem in &image.problems {
                    check_message(&problem.to_string());
                }
                for object in &image.objects {
                    let [x0, y0, x1, y1] = object.box_px;
                    let is_box =
                        object.box_px.iter().all(|v| v.is_finite()) && x0 <= x1 && y0 <= y1;
                    assert!(is_box, "{object:?}");
                }
                let before = images.last().map_or("", |image| image.name.as_str());
                assert!(
                    before < image.name.as_str(),
                    "{before:?} before {:?}",
                    image.name
                );
                images.push(image);
            }
            Err(bad) => check_message(&bad.to_string()),
        }
    }
    for file in source.files() {
        match file {
            Ok(file) => check_name(&file.name),
            Err(bad) => check_message(&bad.to_string()),
        }
    }
    images
}

/// A name that is joined to a folder stays inside of it.
fn check_name(name: &str) {
    let is_inside = Path::new(name)
        .components()
        .all(|part| matches!(part, Component::Normal(_)));
    assert!(
        is_inside && !name.is_empty() && !name.contains('\\'),
        "{name:?} leads out"
    );
}

fn check_message(message: &str) {
    assert!(
        !message.contains(char::is_control) && !message.is_empty(),
        "a message that is not one printable line: {message:?}"
    );
}

fn put(root: &Path, name: &str, bytes: &[u8]) {
    let path = root.join(name);
    let folder = path.parent().unwrap_or(root);
    if let Err(error) = fs::create_dir_all(folder).and_then(|()| fs::write(&path, bytes)) {
        panic!("cannot write {name}: {error}");
    }
}
