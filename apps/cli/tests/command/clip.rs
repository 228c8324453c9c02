//! Clips made and measured by ffmpeg itself.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::program::{Outcome, SMALL, skipped, starbreak};

/// The ffmpeg that `cargo xtask test` provides; says loudly that there is none.
pub(crate) fn ffmpeg() -> Option<PathBuf> {
    let path = std::env::var_os("STARBREAK_TEST_FFMPEG").map(PathBuf::from);
    if path.is_none() {
        skipped("clips: STARBREAK_TEST_FFMPEG is not set; `cargo xtask test` provides an ffmpeg");
    }
    path
}

/// A folder with clips, and the programs that work in it.
pub(crate) struct Studio {
    pub(crate) dir: tempfile::TempDir,
    pub(crate) ffmpeg: PathBuf,
}

impl Studio {
    /// `None` where there is no ffmpeg.
    pub(crate) fn open() -> Option<Self> {
        let ffmpeg = ffmpeg()?;
        Some(Self {
            dir: crate::program::folder(),
            ffmpeg,
        })
    }

    pub(crate) fn path(&self) -> &Path {
        self.dir.path()
    }

    /// What ffmpeg prints when it is run quietly in the folder; it must succeed.
    pub(crate) fn ffmpeg<S: AsRef<OsStr>>(&self, args: &[S]) -> Vec<u8> {
        let output = Command::new(&self.ffmpeg)
            .args(["-hide_banner", "-v", "error", "-nostdin", "-y"])
            .args(args)
            .current_dir(self.path())
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "ffmpeg: {said}");
        output.stdout
    }

    /// Makes a clip of a moving test picture: `source` as for `testsrc2`, then more arguments.
    pub(crate) fn make(&self, source: &str, args: &str, name: &str) {
        let source = format!("testsrc2={source}");
        let mut all = vec!["-f", "lavfi", "-i", &source];
        all.extend(args.split_whitespace());
        all.push(name);
        self.ffmpeg(&all);
    }

    /// `starbreak video` with a small crack, by this ffmpeg.
    pub(crate) fn video(&self, args: &[&str]) -> Outcome {
        starbreak(self.path(), &self.args(args))
    }

    /// The same, which must succeed.
    pub(crate) fn succeed(&self, args: &[&str]) -> Outcome {
        let outcome = self.video(args);
        assert_eq!(outcome.code, Some(0), "{args:?}: {outcome:?}");
        outcome
    }

    pub(crate) fn args(&self, args: &[&str]) -> Vec<String> {
        let ffmpeg = self.ffmpeg.to_str().unwrap();
        [&["video"], args, &["--ffmpeg", ffmpeg], &SMALL]
            .concat()
            .into_iter()
            .map(str::to_owned)
            .collect()
    }

    /// Times of the video packets, s, in the order of showing, and of the first audio packet.
    pub(crate) fn times(&self, clip: &str) -> (Vec<f64>, Option<f64>) {
        let text = self.ffmpeg(&["-i", clip, "-c", "copy", "-f", "framecrc", "-"]);
        let text = String::from_utf8(text).unwrap();
        let mut bases = Vec::new();
        let (mut video, mut audio) = (Vec::new(), None);
        for line in text.lines() {
            if let Some((_, base)) = line.strip_prefix("#tb ").and_then(|l| l.split_once(": ")) {
                let (above, below) = base.split_once('/').unwrap();
                bases.push(above.parse::<f64>().unwrap() / below.parse::<f64>().unwrap());
            } else if !line.starts_with('#') {
                let columns: Vec<&str> = line.split(',').map(str::trim).collect();
                let stream: usize = columns[0].parse().unwrap();
                let time_s = columns[2].parse::<f64>().unwrap() * bases[stream];
                match stream {
                    0 => video.push(time_s),
                    _ if audio.is_none() => audio = Some(time_s),
                    _ => {}
                }
            }
        }
        video.sort_by(f64::total_cmp);
        (video, audio)
    }

    /// The frames of a clip as RGB, each with its bytes, turned upright.
    pub(crate) fn frames(&self, clip: &str, (width, height): (usize, usize)) -> Vec<Vec<u8>> {
        let flags = "bicubic+accurate_rnd+full_chroma_int+full_chroma_inp";
        let args = ["-i", clip, "-map", "0:v:0", "-fps_mode", "passthrough"];
        let raw = [
            "-sws_flags",
            flags,
            "-f",
            "rawvideo",
            "-pix_fmt",
            "rgb24",
            "-",
        ];
        let bytes = self.ffmpeg(&[&args[..], &raw].concat());
        let n = width * height * 3;
        assert_eq!(bytes.len() % n, 0, "whole frames of {width} x {height}");
        bytes.chunks_exact(n).map(<[u8]>::to_vec).collect()
    }

    /// MD5 of the packets of the audio.
    pub(crate) fn audio(&self, clip: &str) -> String {
        let args = ["-i", clip, "-map", "0:a", "-c", "copy", "-f", "streamhash"];
        String::from_utf8(self.ffmpeg(&[&args[..], &["-hash", "md5", "-"]].concat())).unwrap()
    }

    /// What ffmpeg says of the streams of a clip.
    pub(crate) fn described(&self, clip: &str) -> String {
        let output = Command::new(&self.ffmpeg)
            .args(["-hide_banner", "-i", clip])
            .current_dir(self.path())
            .output()
            .unwrap();
        String::from_utf8_lossy(&output.stderr).into_owned()
    }

    /// The track beside an output.
    pub(crate) fn track(&self, output: &str) -> serde_json::Value {
        crate::program::json(&self.path().join(format!("{output}.track.json")))
    }
}

/// The states of all frames by their first letter, e.g. `iiggss`.
pub(crate) fn states(track: &serde_json::Value) -> String {
    let frames = track["frames"].as_array().unwrap();
    frames
        .iter()
        .map(|frame| frame["state"].as_str().unwrap().chars().next().unwrap())
        .collect()
}
