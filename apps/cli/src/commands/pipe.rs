//! `starbreak pipe`: raw frames from standard input to the same behind broken glass on standard output.

use std::io::{ErrorKind, IsTerminal as _, Write as _};
use std::path::Path;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use starbreak::optics::FrameMut;
use starbreak_dataset::video::Fraction;
use starbreak_dataset::{DatasetError, ImageLimits};
use starbreak_runs::clip::{GlassState, LiveClip, LiveFrames, LiveRequest};
use starbreak_runs::{Patterns, RunContext};

use super::latencies::Latencies;
use super::simulate::{radius_hint, why_no_damage};
use super::video::damage_of;
use super::waiting_frames::{Frame, InputEnd, Next, WaitingFrames};
use crate::args::Global;
use crate::args::pipe::{LateWord, PipeArgs};
use crate::failure::{DONE, Failure};
use crate::interrupt::Interrupt;
use crate::screen::Screen;

/// How often a run that waits for a frame looks whether it is to stop.
const LOOK_AROUND: Duration = Duration::from_millis(100);

pub(crate) fn run(global: &Global, args: &PipeArgs, screen: &Screen) -> Result<u8, Failure> {
    refuse_terminals(screen)?;
    let n_bytes = frame_bytes(args)?;
    let rate = args.fps.parse::<Fraction>();
    let rate = rate.map_err(|error| Failure::from(DatasetError::Video(error)))?;
    let (patterns, recipe) = damage_of(global, &args.damage, &[])?;
    let context = RunContext::new(&recipe, global.seed(), Path::new("-"))?;
    args.damage
        .overlay_args
        .refuse_idle_gain(&context.settings)?;
    let interrupt = Interrupt::listen(screen);
    let clip = LiveClip::open(request_of(args, rate), &context, &patterns)?;
    if matches!(patterns, Patterns::Fresh)
        && let Some(hint) = radius_hint(&context.settings, args.size)
    {
        screen.note(&hint);
    }
    if let Some(why) = why_no_damage(clip.chain()) {
        screen.note(&format!("note: {why}"));
    }
    let period = Duration::from_secs_f64(1.0 / rate.value());
    let late_after = (args.late == LateWord::Drop).then_some(period);
    let frames = WaitingFrames::read_from(std::io::stdin(), n_bytes, late_after);
    let mut stream = Stream {
        args,
        period,
        clip: &clip,
        live: clip.frames()?,
        told: Told::default(),
    };
    let started = Instant::now();
    let end = stream.run(&frames, &interrupt)?;
    let n_lights = stream.live.n_lights();
    let told = stream.told;
    let elapsed_s = started.elapsed().as_secs_f64();
    if let End::Interrupted | End::Finished | End::ReaderGone = end {
        screen.note(&told.describe(args, elapsed_s, matches!(end, End::ReaderGone)));
        screen.result_beside(|| told.to_json(args, rate, (elapsed_s, n_lights)));
    }
    match end {
        End::Finished if told.n_read == 0 => Err(Failure::wrong_input(
            "no frame came on standard input: 0 bytes; look at what the program before this one says",
        )),
        End::Finished | End::ReaderGone => Ok(DONE),
        End::Interrupted => Err(Failure::interrupted(format!(
            "interrupted after {} frames",
            told.n_written
        ))),
        End::Truncated { n_came } => Err(Failure::wrong_input(format!(
            "standard input ended within frame {}: {n_came} of its {n_bytes} bytes came, {} are missing, after {} whole \
             frames, of which {} are written; compare --size {}x{} and --pixels {} with what is sent",
            told.n_read,
            n_bytes - n_came,
            told.n_read,
            told.n_written,
            args.size.0,
            args.size.1,
            args.pixels.name(),
        ))),
        End::Unread(cause) => Err(Failure::wrong_input(format!(
            "standard input cannot be read after {} frames: {cause}",
            told.n_read
        ))),
    }
}

/// Raw frames are for programs, and standard output is that of the whole process.
fn refuse_terminals(screen: &Screen) -> Result<(), Failure> {
    if screen.stop().is_some() {
        return Err(Failure::wrong_input(
            "pipe reads standard input and writes standard output, which a program that calls the command has for \
             itself; start `starbreak pipe` as a process, or put frames behind glass by ReadyCrack.over",
        ));
    }
    let ends = [
        ("input", std::io::stdin().is_terminal(), "from"),
        ("output", std::io::stdout().is_terminal(), "to"),
    ];
    match ends.into_iter().find(|(_, is_terminal, _)| *is_terminal) {
        Some((end, _, way)) => Err(Failure::wrong_input(format!(
            "standard {end} is a terminal, and frames are raw bytes; pipe them {way} another program, such as ffmpeg \
             (see starbreak pipe --help)"
        ))),
        None => Ok(()),
    }
}

/// Bytes of a frame that can be worked with.
fn frame_bytes(args: &PipeArgs) -> Result<usize, Failure> {
    let (width, height) = args.size;
    let most = ImageLimits::default().max_pixels;
    if u64::from(width) * u64::from(height) > most {
        return Err(Failure::wrong_input(format!(
            "--size {width}x{height} is {} px; expected {most} px at most",
            u64::from(width) * u64::from(height)
        )));
    }
    let n_samples = args.pixels.channels().n_samples();
    Ok(width as usize * height as usize * n_samples)
}

fn request_of(args: &PipeArgs, rate: Fraction) -> LiveRequest {
    LiveRequest {
        name: args.name.clone(),
        size_px: args.size,
        rate,
        impact_at_s: args.damage.impact_at,
        growth: args.damage.growth.growth(),
        light: args.light.light(),
    }
}

/// How a run ends.
enum End {
    Finished,
    Truncated { n_came: usize },
    Unread(std::io::Error),
    ReaderGone,
    Interrupted,
}

struct Stream<'a> {
    args: &'a PipeArgs,
    /// From one frame to the next.
    period: Duration,
    clip: &'a LiveClip,
    live: LiveFrames<'a>,
    told: Told,
}

impl Stream<'_> {
    fn run(&mut self, frames: &WaitingFrames, interrupt: &Interrupt) -> Result<End, Failure> {
        let mut stdout = std::io::stdout().lock();
        loop {
            if interrupt.is_set() {
                return Ok(End::Interrupted);
            }
            let Frame {
                idx: frame_idx,
                mut bytes,
                whole_at,
            } = match frames.next(LOOK_AROUND) {
                Next::Frame(frame) => frame,
                Next::Nothing => continue,
                Next::End(InputEnd::Ended { n_came: 0 }) => return Ok(End::Finished),
                Next::End(InputEnd::Ended { n_came }) => return Ok(End::Truncated { n_came }),
                Next::End(InputEnd::Failed(cause)) => return Ok(End::Unread(cause)),
            };
            // All that came between the last one and this were left out.
            self.told.n_dropped += frame_idx - self.told.n_read;
            self.told.n_read = frame_idx + 1;
            self.damage(&mut bytes, frame_idx)?;
            let written = stdout.write_all(&bytes).and_then(|()| stdout.flush());
            match written {
                Ok(()) => {}
                Err(cause) if cause.kind() == ErrorKind::BrokenPipe => return Ok(End::ReaderGone),
                Err(cause) => {
                    return Err(Failure::wrong_input(format!(
                        "standard output cannot be written, at frame {frame_idx}: {cause}"
                    )));
                }
            }
            let latency = whole_at.elapsed();
            self.told.n_written += 1;
            self.told.n_late += u64::from(latency > self.period);
            self.told.latencies.add(latency);
            frames.give_back(bytes);
        }
    }

    /// Puts the damage over a frame.
    fn damage(&mut self, bytes: &mut [u8], frame_idx: u64) -> Result<(), Failure> {
        let frame = FrameMut::of_bytes(bytes, self.args.size, self.args.pixels.channels());
        let mut frame = frame.map_err(starbreak::Error::from)?;
        let state = self.live.over(&mut frame, frame_idx)?;
        if state != GlassState::Intact && self.told.onset.is_none() {
            self.told.onset = Some((frame_idx, self.clip.time_s(frame_idx)));
        }
        Ok(())
    }
}

/// What a run counts.
#[derive(Debug, Default)]
struct Told {
    n_read: u64,
    n_written: u64,
    /// Left out because they had waited too long.
    n_dropped: u64,
    /// Written later than a period after they were whole.
    n_late: u64,
    /// Number and time, s, of the first frame that is written behind broken glass.
    onset: Option<(u64, f64)>,
    latencies: Latencies,
}

impl Told {
    fn describe(&self, args: &PipeArgs, elapsed_s: f64, is_reader_gone: bool) -> String {
        #[expect(clippy::cast_precision_loss, reason = "counts, for a rate")]
        let rate = self.n_written as f64 / elapsed_s.max(1e-9);
        let mut said = format!(
            "{} frames read, {} written in {elapsed_s:.1} s ({rate:.1} per second)",
            self.n_read, self.n_written
        );
        if let Some((idx, time_s)) = self.onset {
            said += &format!(", broken from frame {idx} ({time_s:.3} s)");
        }
        said += &match args.late {
            LateWord::Drop => format!(
                "; late: {} dropped, {} written",
                self.n_dropped, self.n_late
            ),
            LateWord::Wait => format!("; late: {} written", self.n_late),
        };
        let [p50, p99] = [50, 99].map(|percent| self.latencies.percentile_ms(percent));
        if let (Some(p50), Some(p99), Some(most)) = (p50, p99, self.latencies.most_ms()) {
            said += &format!("; latency {p50:.2} ms p50, {p99:.2} ms p99, {most:.2} ms maximum");
        }
        if is_reader_gone {
            said += "; whoever reads standard output has closed it";
        }
        said
    }

    fn to_json(&self, args: &PipeArgs, rate: Fraction, of: (f64, u64)) -> Value {
        let (elapsed_s, n_lights) = of;
        let late = match args.late {
            LateWord::Drop => "drop",
            LateWord::Wait => "wait",
        };
        let onset = self.onset;
        json!({
            "n_read": self.n_read,
            "n_written": self.n_written,
            "n_dropped": self.n_dropped,
            "n_late": self.n_late,
            "late": late,
            "fps": rate.value(),
            "width_px": args.size.0,
            "height_px": args.size.1,
            "pixels": args.pixels.name(),
            "damage_onset": onset.map(|(idx, time_s)| json!({ "frame_idx": idx, "time_s": time_s })),
            "n_lights": n_lights,
            "latency_ms": {
                "p50": self.latencies.percentile_ms(50),
                "p99": self.latencies.percentile_ms(99),
                "maximum": self.latencies.most_ms(),
            },
            "elapsed_s": elapsed_s,
        })
    }
}
