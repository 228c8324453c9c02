//! Recordings of robots and cars in MCAP files (bags): their cameras behind broken glass, all else as it was.
//!
//! A bag is read and written record by record. In a message that is damaged, only the bytes of `data` are others;
//! everything else keeps its bytes, its channel, its times and its place. Each camera has a pane of its own, broken
//! once; the glass is hit at a stamp of the headers, for all cameras at the same moment.

mod camera;
mod cdr;
mod chunk;
mod damage;
mod message;
mod promise;
mod provenance;
mod record;
mod records;
mod run;
mod survey;
mod topics;
mod write;

use std::collections::BTreeMap;
use std::io::{BufReader, Read as _, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use starbreak::{FractureSettings, OutputFormat};
use starbreak_dataset::{DatasetError, OutputBatch, open_file, refuse_inside_set, same_file};

pub use crate::bag_error::{BagError, MessageFault};
pub use camera::CameraReport;
pub use damage::Damage;
pub use message::{CameraKind, CameraMessage};
pub use provenance::BAG_SCHEMA;

use crate::clip::{ClipError, Growth, Light};
use crate::{Error, RunContext};
use camera::Camera;
use provenance::provenance;
use records::{Records, Unreadable};
use run::{Finished, run};
use survey::{Survey, SurveyFault, seconds};
use topics::{Content, camera_of};
use write::BagWriter;

/// Bytes that are read at once.
const READ_BYTES: usize = 1 << 20;

/// What is to become of a bag.
#[derive(Debug, Clone, PartialEq)]
pub struct BagRequest {
    /// An MCAP file.
    pub input: PathBuf,
    /// Another.
    pub output: PathBuf,
    /// Cameras by their topic, with a recipe each.
    pub cameras: Vec<CameraRequest>,
    /// The recipe of all cameras, where none is named.
    pub all: Option<RunContext>,
    /// When the glass is hit.
    pub impact_at: ImpactAt,
    /// Whether the growth of the cracks is shown.
    pub growth: Growth,
    /// Which light the cracks are under.
    pub light: Light,
    /// Topics that each camera gets beside its own.
    pub added: Vec<Added>,
    /// Whether a file may be replaced.
    pub replaces: bool,
}

/// A camera that is to be damaged.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraRequest {
    /// Its topic.
    pub topic: String,
    /// Recipe and seed of the run.
    pub context: RunContext,
}

/// When the glass is hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ImpactAt {
    /// After the first stamp of all cameras that are damaged, s.
    AfterFirst(f64),
    /// At a stamp of the headers, ns.
    Stamp(i64),
}

/// A topic that a camera gets beside its own, with messages of the same times right behind those of the camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Added {
    /// Affected pixels: `sensor_msgs/msg/Image`, mono8.
    Region,
    /// What the glass is like: `std_msgs/msg/String`, a line of JSON as in the track of a video.
    Track,
    /// The picture without damage, but written again: JPEG alone, which loses something by that.
    Control,
}

impl Added {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Region, Self::Track, Self::Control];

    /// The name of the topic of a camera.
    #[must_use]
    pub fn topic(self, camera: &str) -> String {
        let name = match self {
            Self::Region => "region",
            Self::Track => "track",
            Self::Control => "control",
        };
        format!("{camera}/starbreak/{name}")
    }
}

/// A bag that has been looked at, ready to run.
#[derive(Debug)]
pub struct Bag {
    request: BagRequest,
    survey: Survey,
    cameras: Vec<Camera>,
}

/// What a run says.
#[derive(Debug)]
pub struct BagReport {
    /// Messages that were read, of all topics.
    pub n_messages: u64,
    /// The cameras, by topic.
    pub cameras: Vec<CameraReport>,
    /// Where the bag is not whole, if it is not. What was written ends there.
    pub damage: Option<Damage>,
}

impl Bag {
    /// Checks a request and looks at the beginning of the bag: to the end, where it has no summary.
    ///
    /// # Errors
    /// [`Error::Bag`] for a file that is no MCAP file, a topic that is not there or not damaged, and a first message
    /// that is not read; [`Error::Dataset`] for a file that cannot be read, and an output in a generated set or in the
    /// place of a file.
    pub fn open(request: BagRequest) -> Result<Self, Error> {
        let (input, output) = (&request.input, &request.output);
        if same_file(input, output) {
            let output = output.clone();
            return Err(BagError::OutputIsInput { output }.into());
        }
        refuse_inside_set(output)?;
        let batch = OutputBatch::new().replacing(request.replaces);
        batch.may_write(output)?;
        let names: Vec<String> = request.cameras.iter().map(|it| it.topic.clone()).collect();
        let is_again = |(k, name): &(usize, &String)| names.iter().take(*k).any(|it| it == *name);
        if let Some((_, topic)) = names.iter().enumerate().find(is_again) {
            let topic = topic.clone();
            return Err(BagError::TopicTwice { topic }.into());
        }
        let names = request.all.is_none().then_some(names.as_slice());
        let mut file = BufReader::with_capacity(READ_BYTES, open_file(input)?);
        let survey = match Survey::of(&mut file, names) {
            Ok(survey) => survey,
            Err(SurveyFault::Bag(error)) => return Err(error.into()),
            Err(SurveyFault::Unreadable(Unreadable::NotMcap)) => {
                return Err(other_bag(input, &mut file).into());
            }
            Err(SurveyFault::Unreadable(fault)) => return Err(unreadable(input, fault)),
        };
        for topic in names.into_iter().flatten() {
            if !survey.cameras.contains_key(topic) {
                return Err(not_a_camera(input, &survey, topic).into());
            }
        }
        if survey.cameras.is_empty() && request.all.is_some() {
            return Err(BagError::NoCamera {
                path: input.clone(),
                n_topics: survey.all_topics().len(),
                damage: survey.damage.as_ref().map(Damage::to_string),
            }
            .into());
        }
        let cameras = cameras(&request, &survey)?;
        refuse_taken(&request, &survey)?;
        Ok(Self {
            request,
            survey,
            cameras,
        })
    }

    /// How many images are to be expected, where the bag says so.
    #[must_use]
    pub fn n_frames(&self) -> Option<u64> {
        self.survey.n_frames()
    }

    /// Breaks the glass and writes the bag, which appears whole or not at all. `done` is called after each image.
    /// `None` if `stop` was set: nothing is written then.
    ///
    /// The bytes are a function of input, settings and seed alone.
    ///
    /// # Errors
    /// [`Error`]; nothing is written then. A bag that is not whole is no error: [`BagReport::damage`].
    ///
    /// # Limits
    /// A record, and a chunk when it is unpacked, has at most 1 GiB, also in memory, and a map at most 100,000 keys.
    pub fn run(
        &self,
        stop: &AtomicBool,
        done: impl Fn() + Sync,
    ) -> Result<Option<BagReport>, Error> {
        let (input, output) = (&self.request.input, &self.request.output);
        let mut batch = OutputBatch::new().replacing(self.request.replaces);
        let to = batch.open(output)?;
        let writer = BagWriter::new(to, self)?;
        let file = BufReader::with_capacity(READ_BYTES, open_file(input)?);
        let promise = self.survey.promise.as_ref();
        let records = Records::open(file, promise).map_err(|fault| unreadable(input, fault))?;
        let Some(finished) = run(self, records, writer, stop, &done)? else {
            return Ok(None);
        };
        let Finished {
            mut writer,
            cameras,
            n_messages,
            damage,
        } = finished;
        self.check_impact(&cameras)?;
        writer.silent(&self.survey)?;
        writer.metadata(provenance(self, &cameras, damage.as_ref()))?;
        writer.finish()?;
        batch.commit()?;
        Ok(Some(BagReport {
            n_messages,
            cameras,
            damage,
        }))
    }

    /// The hit comes no later than the last image.
    fn check_impact(&self, cameras: &[CameraReport]) -> Result<(), Error> {
        let last_s = cameras
            .iter()
            .filter_map(|camera| camera.last_s)
            .reduce(f64::max);
        let impact_at_s = self
            .cameras
            .iter()
            .map(|camera| camera.impact_at_s)
            .reduce(f64::max);
        match (impact_at_s, last_s) {
            (Some(impact_at_s), Some(last_s)) if impact_at_s > last_s + 1e-6 => {
                Err(BagError::ImpactTime {
                    impact_at_s,
                    last_s,
                }
                .into())
            }
            _ => Ok(()),
        }
    }
}

/// The cameras of a run, each with its recipe, by topic.
fn cameras(request: &BagRequest, survey: &Survey) -> Result<Vec<Camera>, Error> {
    let own: BTreeMap<&str, &RunContext> = (request.cameras.iter())
        .map(|camera| (camera.topic.as_str(), &camera.context))
        .collect();
    let clock = survey.clock();
    let impact_at_s = match request.impact_at {
        ImpactAt::AfterFirst(after_s) => after_s,
        ImpactAt::Stamp(stamp_ns) if clock.is_of_another(stamp_ns) => {
            let [stamp_s, first_s] = [stamp_ns, clock.first_ns].map(seconds);
            return Err(BagError::StampClock { stamp_s, first_s }.into());
        }
        ImpactAt::Stamp(stamp_ns) => clock.since_first_s(stamp_ns),
    };
    let depends_on_time = impact_at_s > 0.0 || request.growth != Growth::Whole;
    let mut cameras = Vec::new();
    for (topic, seen) in &survey.cameras {
        let Some(context) = own.get(topic.as_str()).copied().or(request.all.as_ref()) else {
            continue;
        };
        if context.settings.output.format != OutputFormat::Same {
            let topic = topic.clone();
            return Err(BagError::Format { topic }.into());
        }
        let breaks = !matches!(context.settings.fracture, FractureSettings::None(_));
        if breaks && depends_on_time {
            let topic = topic.clone();
            if seen.has_no_stamps(clock) {
                return Err(BagError::NoStamps { topic }.into());
            }
            if seen.has_other_clock(clock) {
                return Err(BagError::OtherClock { topic }.into());
            }
        }
        cameras.push(Camera {
            topic: topic.clone(),
            context: context.clone(),
            clock,
            frame_s: seen.frame_s(clock),
            impact_at_s: if breaks { impact_at_s } else { 0.0 },
            growth: if breaks {
                request.growth
            } else {
                Growth::Whole
            },
            light: request.light,
            added: (request.added.iter().copied())
                .filter(|added| *added != Added::Control || seen.is_jpeg)
                .collect(),
        });
    }
    let breaks =
        |camera: &Camera| !matches!(camera.context.settings.fracture, FractureSettings::None(_));
    if depends_on_time && !cameras.iter().any(breaks) {
        return Err(ClipError::NothingBreaks.into());
    }
    Ok(cameras)
}

/// Topics of ours are new, and control pictures differ from the input.
fn refuse_taken(request: &BagRequest, survey: &Survey) -> Result<(), BagError> {
    for added in &request.added {
        if *added == Added::Control && !survey.cameras.values().any(|seen| seen.is_jpeg) {
            return Err(BagError::NoJpeg);
        }
        for (camera, seen) in &survey.cameras {
            if *added == Added::Control && !seen.is_jpeg {
                continue;
            }
            let topic = added.topic(camera);
            if survey.has_topic(&topic) {
                return Err(BagError::TopicTaken { topic });
            }
        }
    }
    Ok(())
}

/// What a topic is that was named and is no camera.
fn not_a_camera(path: &Path, survey: &Survey, topic: &str) -> BagError {
    let all = survey.all_topics();
    match all.get(topic) {
        Some(Content::Other) if camera_of(topic).is_some_and(|it| survey.has_topic(it)) => survey
            .refusal(
                topic,
                "an earlier run of starbreak added it, and it is no camera",
            ),
        Some(Content::Other) => survey.refusal(topic, "it holds no images"),
        _ => BagError::NoTopic {
            path: path.to_owned(),
            topic: topic.to_owned(),
            cameras: (all.iter())
                .filter(|(_, content)| matches!(content, Content::Camera(_)))
                .map(|(topic, _)| (*topic).to_owned())
                .collect(),
            damage: survey.damage.as_ref().map(Damage::to_string),
        },
    }
}

/// What a file is that is no MCAP file.
fn other_bag(path: &Path, file: &mut (impl std::io::Read + std::io::Seek)) -> BagError {
    let mut head = Vec::new();
    // A file that was read a moment ago; what cannot be told is no other bag.
    let _ = file.seek(SeekFrom::Start(0));
    let _ = file.take(16).read_to_end(&mut head);
    let kind = match head.as_slice() {
        head if head.starts_with(b"#ROSBAG V") => Some("a bag of ROS 1"),
        head if head.starts_with(b"SQLite format 3\0") => Some("a bag of ROS 2 in SQLite"),
        _ => None,
    };
    let path = path.to_owned();
    match kind {
        Some(kind) => BagError::OtherBag {
            mcap: path.with_extension("mcap"),
            path,
            kind,
        },
        None => BagError::NotMcap { path },
    }
}

/// A file whose records cannot be read.
fn unreadable(path: &Path, fault: Unreadable) -> Error {
    let path = path.to_owned();
    match fault {
        Unreadable::Io(source) => DatasetError::Read { path, source }.into(),
        Unreadable::NotMcap => BagError::NotMcap { path }.into(),
        Unreadable::Records(reason) => BagError::Records { path, reason }.into(),
    }
}
