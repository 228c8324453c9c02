//! The program ffmpeg: found, started, listened to, and ended.

use std::ffi::OsString;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{ChildStderr, ExitStatus};
use std::sync::mpsc::{Receiver, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use ffmpeg_sidecar::child::FfmpegChild;
use ffmpeg_sidecar::command::FfmpegCommand;
use ffmpeg_sidecar::event::{FfmpegEvent, LogLevel};
use ffmpeg_sidecar::log_parser::{FfmpegLogParser, try_parse_version};

use super::VideoError;
use super::showinfo::FrameInfo;
use crate::error::one_line;

/// The ffmpeg of this machine.
///
/// It is started in a process group of its own: Ctrl-C in a terminal reaches the caller alone,
/// who ends it.
#[derive(Debug, Clone)]
pub struct Ffmpeg {
    path: PathBuf,
    /// How to ask for every frame once with its own time: `-vsync` up to 5.0, `-fps_mode` after.
    every_frame: [&'static str; 2],
    /// The filter that tells of each frame, without its checksums where they can be turned off.
    pub(super) showinfo: &'static str,
}

impl Ffmpeg {
    /// The program at a path, or, by a bare name such as `ffmpeg`, where the system finds it.
    ///
    /// # Errors
    /// [`VideoError::NoFfmpeg`] where it does not start, [`VideoError::NotFfmpeg`] where it is
    /// something else.
    pub fn at(path: &Path) -> Result<Self, VideoError> {
        let no_ffmpeg = |source| VideoError::NoFfmpeg {
            program: path.to_owned(),
            source,
        };
        let mut running = Running::start(path, &["-version".into()]).map_err(no_ffmpeg)?;
        let mut said = Vec::new();
        // Enough for the first line, whatever it is that answers.
        if let Some(stdout) = running.child.take_stdout() {
            stdout
                .take(1 << 16)
                .read_to_end(&mut said)
                .map_err(no_ffmpeg)?;
        }
        running.kill();
        let said = String::from_utf8_lossy(&said);
        let first = said.lines().next().unwrap_or_default();
        let Some(version) = try_parse_version(first) else {
            return Err(VideoError::NotFfmpeg {
                program: path.to_owned(),
                said: first.chars().take(80).collect(),
            });
        };
        let (every_frame, showinfo) = if is_before_5_1(&version) {
            (["-vsync", "passthrough"], "showinfo")
        } else {
            (["-fps_mode", "passthrough"], "showinfo=checksum=0")
        };
        Ok(Self {
            path: path.to_owned(),
            every_frame,
            showinfo,
        })
    }

    pub(super) fn every_frame(&self) -> [OsString; 2] {
        self.every_frame.map(OsString::from)
    }

    pub(super) fn start(&self, args: &[OsString]) -> Result<Running, VideoError> {
        Running::start(&self.path, args).map_err(|source| VideoError::NoFfmpeg {
            program: self.path.clone(),
            source,
        })
    }
}

/// Whether a version such as `4.4.2-0ubuntu0.22.04.1` or `n5.0` is before 5.1; builds that are
/// named by date or revision are new.
fn is_before_5_1(version: &str) -> bool {
    let mut parts = version
        .trim_start_matches('n')
        .split(|c: char| !c.is_ascii_digit());
    let mut part = || parts.next().and_then(|part| part.parse::<u32>().ok());
    match (part(), part()) {
        (Some(major), Some(minor)) => (major, minor) < (5, 1),
        _ => false,
    }
}

/// A path as ffmpeg takes it, whatever its first letters are.
pub(super) fn file_arg(path: &Path) -> OsString {
    let mut arg = OsString::from("file:");
    arg.push(path);
    arg
}

/// A child at work. Dropping it ends it.
#[derive(Debug)]
pub(super) struct Running {
    pub(super) child: Child,
    log: Option<JoinHandle<Vec<String>>>,
    frames: Receiver<FrameInfo>,
    /// It was waited for; its number may be another's by now.
    has_ended: bool,
}

/// [`FfmpegChild`] with a `Debug` that says nothing.
pub(super) struct Child(FfmpegChild);

impl std::fmt::Debug for Child {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("ffmpeg")
    }
}

impl std::ops::Deref for Child {
    type Target = FfmpegChild;

    fn deref(&self) -> &FfmpegChild {
        &self.0
    }
}

impl std::ops::DerefMut for Child {
    fn deref_mut(&mut self) -> &mut FfmpegChild {
        &mut self.0
    }
}

/// How a child ended.
pub(super) struct Ended {
    /// Whether it says that all went well.
    pub(super) is_success: bool,
    /// Its complaints, or its exit status, in one line.
    pub(super) said: String,
    /// Whether it complained at all.
    pub(super) has_complained: bool,
}

impl Running {
    fn start(path: &Path, args: &[OsString]) -> std::io::Result<Self> {
        let mut command = FfmpegCommand::new_with_path(path);
        command.hide_banner().args(["-nostats"]).args(args);
        #[cfg(unix)]
        {
            use std::os::unix::process::CommandExt as _;
            command.as_inner_mut().process_group(0);
        }
        let mut child = command.spawn()?;
        let (to, frames) = channel();
        // Always read to its end, or the child waits for it.
        let log = child.take_stderr().map(|stderr| {
            std::thread::spawn(move || {
                listen(stderr, |info| {
                    // Whoever asked only for the first has gone.
                    let _ = to.send(info);
                })
            })
        });
        Ok(Self {
            child: Child(child),
            log,
            frames,
            has_ended: false,
        })
    }

    /// What ffmpeg says of the next frame; none after the last.
    pub(super) fn next_info(&self) -> Option<FrameInfo> {
        self.frames.recv().ok()
    }

    /// Waits for the end.
    pub(super) fn wait(&mut self) -> Ended {
        drop(self.child.take_stdin());
        drop(self.child.take_stdout());
        let status = self.child.wait();
        self.has_ended = true;
        let complaints = self.log.take().and_then(|log| log.join().ok());
        let complaints = complaints.unwrap_or_default();
        Ended {
            is_success: status.as_ref().is_ok_and(ExitStatus::success),
            has_complained: !complaints.is_empty(),
            said: if complaints.is_empty() {
                match status {
                    Ok(status) => format!("ffmpeg ended with {status}"),
                    Err(cause) => one_line(&cause),
                }
            } else {
                one_line(&complaints.join(": "))
            },
        }
    }

    /// Ends it at once.
    pub(super) fn kill(&mut self) {
        if self.has_ended {
            return;
        }
        drop(self.child.take_stdin());
        drop(self.child.take_stdout());
        // Where the program is a script around ffmpeg, the script's end is not that of ffmpeg, so
        // the whole group goes. The library of the language has no way to; a system without this
        // command waits below.
        #[cfg(unix)]
        {
            let group = format!("-{}", self.child.as_inner().id());
            let mut kill = std::process::Command::new("kill");
            kill.args(["-KILL", "--", &group]);
            kill.stdin(std::process::Stdio::null())
                .stdout(std::process::Stdio::null())
                .stderr(std::process::Stdio::null());
            let _ = kill.status();
        }
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
        self.has_ended = true;
        // Whoever still holds the log open is still writing; but nobody is waited for long.
        for _ in 0..200 {
            if self.log.as_ref().is_none_or(JoinHandle::is_finished) {
                break;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.kill();
    }
}

/// Complaints that are kept; the first say most.
const MAX_COMPLAINTS: usize = 3;

/// Reads the log to its end, passes on what it says of frames, and returns its complaints.
fn listen(stderr: ChildStderr, mut seen: impl FnMut(FrameInfo)) -> Vec<String> {
    let mut parser = FfmpegLogParser::new(stderr);
    let mut complaints: Vec<String> = Vec::new();
    let mut info = None;
    loop {
        let line = match parser.parse_next_event() {
            Ok(FfmpegEvent::LogEOF) => break,
            Ok(FfmpegEvent::Log(LogLevel::Error | LogLevel::Fatal, line)) => {
                let said = message(&line);
                if complaints.len() < MAX_COMPLAINTS && !complaints.contains(&said) {
                    complaints.push(said);
                }
                continue;
            }
            Ok(FfmpegEvent::Log(_, line)) => line,
            // Of a line that the parser does not expect; that of the pipe is its end.
            Err(error) if error.downcast_ref::<std::io::Error>().is_some() => break,
            _ => continue,
        };
        if line.contains("Parsed_showinfo") {
            FrameInfo::read_line(&mut info, &line, &mut seen);
        }
    }
    complaints
}

/// A line of the log without where in ffmpeg it comes from.
fn message(line: &str) -> String {
    let after = |mark: &str| line.split_once(mark).map(|(_, message)| message);
    let message = after("[error] ").or_else(|| after("[fatal] "));
    message
        .unwrap_or(line)
        .trim_end_matches(['.', ' '])
        .chars()
        .take(200)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn old_versions_are_told_by_their_number() {
        for (version, is_old) in [
            ("4.4.2-0ubuntu0.22.04.1", true),
            ("n5.0", true),
            ("5.0.1", true),
            ("5.1.6-0+deb12u1", false),
            ("n9.0.2-17-g2a571b6068-20260930", false),
            ("N-109542-g8bdb4a3a5d", false),
            ("2023-01-18-git-ba36e6ed52-full_build-www.gyan.dev", false),
        ] {
            assert_eq!(is_before_5_1(version), is_old, "{version}");
        }
    }

    #[test]
    fn complaints_lose_the_address_they_come_from() {
        let line = "[mov @ 0x55755f79d200] [error] moov atom not found.";
        assert_eq!(message(line), "moov atom not found", "{line}");
    }
}
