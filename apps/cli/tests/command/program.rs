//! The real binary in a folder of its own, and pictures to feed it with.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use image::{DynamicImage, ImageBuffer, Pixel};
use serde_json::Value;
use starbreak_dataset::{Encoding, JpegQuality, encode_image};
use tempfile::TempDir;

/// A crack that fits the small pictures of these tests and leaves a part of them untouched.
pub(crate) const SMALL: [&str; 10] = [
    "--preset",
    "paper",
    "--set",
    "fracture.particles=300",
    "--set",
    "fracture.neighbour_radius_px=20",
    "--set",
    "impact.position=[0.2,0.4]",
    "--set",
    "impact.direction_deg=20",
];

/// The same for a recipe that names its model and hits itself: only the size of the mesh.
pub(crate) const SMALL_MESH: [&str; 4] = [SMALL[2], SMALL[3], SMALL[4], SMALL[5]];

/// The model of the paper, measured once over a few particles.
pub(crate) const QUICK_BENCH: [&str; 7] = [
    "bench",
    "--model",
    "paper",
    "--runs",
    "1",
    "--particles",
    "50",
];

/// Divergences without the draws that take time.
pub(crate) const NO_DRAWS: [&str; 6] = ["--bootstrap", "0", "--permutations", "0", "--splits", "0"];

/// How a run of the command ended.
#[derive(Debug)]
pub(crate) struct Outcome {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl From<Output> for Outcome {
    fn from(output: Output) -> Self {
        Self {
            code: output.status.code(),
            stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
            stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }
}

impl Outcome {
    /// What speaks against a refusal with code 2 in exactly one line that contains `named`.
    pub(crate) fn complaint(&self, named: &str) -> Option<String> {
        let one_line = self.stderr.starts_with("error: ")
            && self.stderr.ends_with('\n')
            && self.stderr.chars().filter(|c| c.is_control()).count() == 1;
        let as_wanted = self.code == Some(2)
            && one_line
            && self.stderr.contains(named)
            && self.stdout.is_empty();
        (!as_wanted).then(|| {
            format!(
                "expected code 2, an empty stdout and one line `error: …{named}…`; got {self:?}"
            )
        })
    }
}

/// An empty folder that goes away with the test.
pub(crate) fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

/// The command in a folder, ready to be started.
pub(crate) fn command<S: AsRef<OsStr>>(dir: &Path, args: &[S]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_starbreak"));
    command
        .args(args)
        .current_dir(dir)
        .env("RUST_BACKTRACE", "0")
        .stdin(Stdio::null());
    command
}

/// Runs the command in a folder.
pub(crate) fn starbreak<S: AsRef<OsStr>>(dir: &Path, args: &[S]) -> Outcome {
    command(dir, args).output().unwrap().into()
}

/// Runs the command with the [`SMALL`] crack.
pub(crate) fn starbreak_small(dir: &Path, args: &[&str]) -> Outcome {
    starbreak(dir, &[args, &SMALL].concat())
}

/// Runs the command, which must succeed.
pub(crate) fn succeed(dir: &Path, args: &[&str]) -> Outcome {
    let outcome = starbreak(dir, args);
    assert_eq!(outcome.code, Some(0), "starbreak {args:?}: {outcome:?}");
    outcome
}

/// Runs the command with the [`SMALL`] crack; it must succeed.
pub(crate) fn succeed_small(dir: &Path, args: &[&str]) -> Outcome {
    succeed(dir, &[args, &SMALL].concat())
}

/// Every case is refused in one line that contains its second part, and nothing in the folder
/// changes. All cases that are not are reported together.
pub(crate) fn all_refused(dir: &Path, cases: &[(Vec<&str>, &str)]) {
    let mut complaints = Vec::new();
    for (args, named) in cases {
        let before = snapshot(dir);
        let outcome = starbreak(dir, args);
        if let Some(complaint) = outcome.complaint(named) {
            complaints.push(format!("starbreak {args:?}: {complaint}"));
        }
        if snapshot(dir) != before {
            complaints.push(format!("starbreak {args:?} changed the folder"));
        }
    }
    assert!(
        complaints.is_empty(),
        "{} complaints about {} cases:\n{}",
        complaints.len(),
        cases.len(),
        complaints.join("\n")
    );
}

/// Every path below a folder, with the content of files.
pub(crate) fn snapshot(dir: &Path) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
    let mut found = BTreeMap::new();
    let mut to_do = vec![dir.to_owned()];
    while let Some(folder) = to_do.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let content = path.is_file().then(|| fs::read(&path).unwrap());
            if path.is_dir() && !path.is_symlink() {
                to_do.push(path.clone());
            }
            found.insert(path.strip_prefix(dir).unwrap().to_owned(), content);
        }
    }
    found
}

/// Names of the files in a folder, sorted.
pub(crate) fn names(dir: &Path) -> Vec<String> {
    snapshot(dir)
        .into_keys()
        .map(|path| path.to_string_lossy().into_owned())
        .collect()
}

/// A JSON file.
pub(crate) fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

/// Of the rows of a `numbers.csv` what stands before the value, where an earlier row has it, too.
pub(crate) fn repeated_keys(csv: &str) -> Vec<String> {
    let key = |row: &str| {
        let (mut is_quoted, mut n_fields) = (false, 0);
        let end = row.find(|c| {
            is_quoted ^= c == '"';
            n_fields += u32::from(c == ',' && !is_quoted);
            n_fields == 7
        });
        row[..end.unwrap()].to_owned()
    };
    let mut known = BTreeSet::new();
    let keys = csv.lines().map(key);
    keys.filter(|key| !known.insert(key.clone())).collect()
}

/// A picture with something in every bit.
pub(crate) fn picture<P: Pixel>(
    (width_px, height_px): (u32, u32),
    convert: impl Fn(u16) -> P::Subpixel,
) -> ImageBuffer<P, Vec<P::Subpixel>> {
    ImageBuffer::from_fn(width_px, height_px, |x, y| {
        let channels: Vec<_> = (0..u32::from(P::CHANNEL_COUNT))
            .map(|channel| {
                let wave = x * 701 + y * 907 + channel * 9973 + (x * y * 37) % 600;
                convert(u16::try_from(wave % 65_536).unwrap())
            })
            .collect();
        *P::from_slice(&channels)
    })
}

pub(crate) fn high_byte(sample: u16) -> u8 {
    sample.to_be_bytes()[0]
}

/// An RGB picture of this size.
pub(crate) fn photo(size: (u32, u32)) -> DynamicImage {
    DynamicImage::ImageRgb8(picture(size, high_byte))
}

pub(crate) fn png_bytes(pixels: &DynamicImage) -> Vec<u8> {
    encode_image(pixels, &Encoding::Png, None).unwrap()
}

pub(crate) fn jpeg_bytes(pixels: &DynamicImage) -> Vec<u8> {
    let quality = JpegQuality::new(92).unwrap();
    encode_image(pixels, &Encoding::Jpeg { quality }, None).unwrap()
}

/// Writes a small RGB photo.
pub(crate) fn write_photo(path: &Path) {
    fs::write(path, png_bytes(&photo((160, 100)))).unwrap();
}

/// A PNG file as it is stored: no sample is converted.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct RawPng {
    pub(crate) size: (u32, u32),
    pub(crate) mode: (png::ColorType, png::BitDepth),
    pub(crate) data: Vec<u8>,
}

impl RawPng {
    /// The bytes of one pixel, row by row.
    pub(crate) fn pixels(&self) -> impl Iterator<Item = &[u8]> {
        let depth = if self.mode.1 == png::BitDepth::Sixteen {
            2
        } else {
            1
        };
        self.data.chunks_exact(self.mode.0.samples() * depth)
    }
}

/// All frames of a PNG file, each as large as the file says for it.
pub(crate) fn raw_frames(path: &Path) -> Vec<RawPng> {
    let file = std::io::BufReader::new(fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let n_frames = reader
        .info()
        .animation_control()
        .map_or(1, |control| control.num_frames);
    (0..n_frames)
        .map(|_| {
            let mut data = vec![0; reader.output_buffer_size().unwrap()];
            let frame = reader.next_frame(&mut data).unwrap();
            data.truncate(frame.buffer_size());
            RawPng {
                size: (frame.width, frame.height),
                mode: (frame.color_type, frame.bit_depth),
                data,
            }
        })
        .collect()
}

/// A PNG file with one picture.
pub(crate) fn raw_png(path: &Path) -> RawPng {
    raw_frames(path).swap_remove(0)
}

/// Says on the error output that a test did not test, and why.
#[expect(clippy::print_stderr, reason = "a skipped test must be seen")]
pub(crate) fn skipped(why: &str) {
    eprintln!("SKIPPED: {why}");
}

/// A small tmpfs, unmounted with the test.
pub(crate) struct SmallDisk(TempDir);

impl SmallDisk {
    /// A disk of a size as `mount` takes it; none where mounting is not allowed.
    pub(crate) fn mount(size: &str) -> Option<Self> {
        let disk = Self(folder());
        disk.try_mount(&format!("size={size}")).then_some(disk)
    }

    /// The folder that it is.
    pub(crate) fn root(&self) -> String {
        self.0.path().to_str().unwrap().to_owned()
    }

    /// Gives it another size.
    pub(crate) fn resize(&self, size: &str) {
        assert!(self.try_mount(&format!("remount,size={size}")), "resized");
    }

    fn try_mount(&self, options: &str) -> bool {
        let mounted = Command::new("mount")
            .args(["-t", "tmpfs", "-o", options, "tmpfs"])
            .arg(self.0.path())
            .output();
        mounted.is_ok_and(|output| output.status.success())
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        // Where nothing was mounted there is nothing to unmount.
        let _ = Command::new("umount").arg(self.0.path()).output();
    }
}
