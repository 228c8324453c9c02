//! The command line, as typed.

pub(crate) mod bag;
pub(crate) mod bench;
mod completed;
pub(crate) mod crack;
pub(crate) mod detect;
pub(crate) mod divergence;
pub(crate) mod evaluate;
pub(crate) mod generate;
pub(crate) mod overlay;
pub(crate) mod patterns;
pub(crate) mod pipe;
pub(crate) mod runtime;
pub(crate) mod simulate;
pub(crate) mod study;
pub(crate) mod timeline;
mod unused;
pub(crate) mod video;

use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use bench::BenchArgs;
use clap::{Args as ClapArgs, CommandFactory as _, FromArgMatches as _, Parser, Subcommand};
use completed::Completed;
use crack::CrackArgs;
use detect::DetectArgs;
use divergence::DivergenceArgs;
use generate::{GenerateArgs, MergeArgs, VerifyArgs};
use patterns::PatternsArgs;
use simulate::SimulateArgs;
use starbreak::{
    Assignment, DEFAULT_PRESET, LEAST_MAX_MEMORY_BYTES, MAX_RECIPE_BYTES, Recipe, RecipeError, Seed,
};
use starbreak_dataset::{DatasetError, MAX_ITEM_BYTES, OutputBatch, SourceSpec, same_file};

use crate::failure::Failure;

/// Break or soil the glass in front of a camera, or give the camera faults; render what it then sees, and measure how
/// detectors fail.
#[derive(Debug, Parser)]
#[command(
    name = "starbreak",
    version,
    propagate_version = true,
    max_term_width = 100
)]
#[command(
    after_help = "Start with `starbreak demo`. Exit codes: 0 done, 1 some items failed (listed in \
failures.jsonl), 2 the command line, the recipe or the input is wrong, 130 interrupted."
)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) verb: Verb,
    #[command(flatten)]
    pub(crate) global: Global,
}

/// The definition of the command line.
pub(crate) fn command() -> clap::Command {
    unused::hidden(Args::command())
}

/// The command line, the program's name first.
pub(crate) fn parse(words: impl IntoIterator<Item = OsString>) -> Result<Args, clap::Error> {
    let words: Vec<OsString> = words.into_iter().collect();
    let mut command = command();
    let matches = command.try_get_matches_from_mut(&words)?;
    unused::refuse(&mut command, &matches)?;
    let mut args = Args::from_arg_matches(&matches)?;
    args.global.command = as_typed(words);
    Ok(args)
}

/// A command line as a shell takes it.
pub(crate) fn as_typed(words: impl IntoIterator<Item = OsString>) -> String {
    let words = words.into_iter().skip(1);
    let said: Vec<String> = words.map(|word| shell_word(&word)).collect();
    format!("starbreak {}", said.join(" "))
}

/// Flags that every verb takes.
#[derive(Debug, ClapArgs)]
pub(crate) struct Global {
    /// Recipe file (TOML) with all parameters. Keys that it leaves out come from
    /// `windshield-star` without its long crack, or from `paper` if it sets fracture.model =
    /// "paper". A record that holds a recipe is accepted, too: that of an image written by
    /// `crack`, or the run.json of a set
    #[arg(long, global = true, value_name = "FILE", conflicts_with = "preset")]
    pub(crate) recipe: Option<PathBuf>,
    /// Preset, a named set of parameters: broken glass, rain or dirt on it, or a fault of the
    /// camera [default: windshield-spiderweb; for bench: paper];
    /// `starbreak recipe --list` lists them
    #[arg(long, global = true, value_name = "NAME", value_parser = Completed::PRESET, hide_possible_values = true)]
    pub(crate) preset: Option<String>,
    /// Severity of the preset, 1 (mild) to 5 (severe); 3 is the preset itself. `starbreak
    /// recipe --severity N` prints what it sets
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=5))]
    pub(crate) severity: Option<u8>,
    /// Camera, applied over the recipe: focal length, lens, pixels and pose behind the glass;
    /// `starbreak recipe --list` lists them
    #[arg(long, global = true, value_name = "NAME", value_parser = Completed::CAMERA, hide_possible_values = true)]
    pub(crate) camera: Option<String>,
    /// Override one parameter, e.g. impact.speed_m_s=30 or impact.0.position=[0.5,0.5];
    /// repeatable, applied in order, after --severity and --camera
    #[arg(long, global = true, value_name = "TABLE.KEY=VALUE", value_parser = Completed::SET, hide_possible_values = true)]
    pub(crate) set: Vec<String>,
    /// Random seed; the same seed gives the same bytes
    #[arg(long, global = true, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Number of threads; 0 for one per processor
    #[arg(long, global = true, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=1024))]
    pub(crate) threads: u16,
    /// Overwrite existing files that no earlier run of the same kind has written; without it
    /// they are refused
    #[arg(long, global = true)]
    pub(crate) replace: bool,
    /// Follow links in a plain folder (folder:DIR) that lead outside of it
    #[arg(long, global = true)]
    pub(crate) follow_links: bool,
    /// Memory limit of one picture, e.g. 800MiB or 16GiB; a picture that would take more is
    /// refused before the work. Each thread makes one picture at a time
    #[arg(long, global = true, value_name = "SIZE", default_value = "4GiB", value_parser = parse_memory)]
    pub(crate) max_memory: u64,
    /// Print one machine-readable result to standard output, everything else to standard error
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Print errors only
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
    /// The whole command line as a shell takes it, for the records of what was made.
    #[arg(skip)]
    pub(crate) command: String,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// Damage an embedded street scene: pictures, masks, network and growth in one folder
    Demo {
        /// Output folder
        #[arg(short, long, value_name = "DIR", default_value = "starbreak-demo")]
        output: PathBuf,
    },
    /// Damage photos: writes each image, its mask of affected pixels, its crack mask and its
    /// record
    Crack(CrackArgs),
    /// Damage a whole dataset: same layout, names and labels, with masks and records beside
    /// them
    Generate(GenerateArgs),
    /// Verify that a generated set is complete, consistent and reproducible
    Verify(VerifyArgs),
    /// Merge the shards of a generated set
    Merge(MergeArgs),
    /// Run a detector (ONNX) over a dataset and write its detections
    Detect(DetectArgs),
    /// Measure the distance between sets of images: K-L and other divergences, with noise
    /// floors
    Divergence(DivergenceArgs),
    /// Damage one photo by the values of one parameter, with a contact sheet
    Sweep {
        /// PNG or JPEG file
        #[arg(value_name = "IMAGE")]
        input: PathBuf,
        /// Output folder
        #[arg(short, long, value_name = "DIR")]
        output: PathBuf,
        /// The parameter and its values
        #[arg(
            long,
            value_name = "TABLE.KEY=VALUE,…",
            default_value = "camera.focus_distance_m=far,2,1,0.5,0.3,0.2,0.1,short"
        )]
        over: String,
    },
    /// Simulate the crack network alone: JSON, SVG and growth frames
    Simulate(SimulateArgs),
    /// Make a bank of cracks for whole datasets, simulated and baked once, with statistics
    Patterns(PatternsArgs),
    /// Damage a video, or a folder of frames: cracks that stay or grow, rain, dirt, camera faults
    Video(video::VideoArgs),
    /// Damage the cameras of a recording of a robot or car (MCAP); all else in it stays the same
    Bag(bag::BagArgs),
    /// Damage raw frames as they come, from standard input to standard output
    Pipe(pipe::PipeArgs),
    /// Evaluate detections on clean and damaged images, inside and outside the damaged region
    Evaluate(evaluate::EvaluateArgs),
    /// Follow objects through a clip, clean and damaged: when each is found, and its time to
    /// detection loss
    Timeline(timeline::TimelineArgs),
    /// Damage a dataset, run detectors on clean and damaged images, and report what fails
    Study(study::StudyArgs),
    /// Print a complete, commented recipe
    Recipe {
        /// Print the JSON Schema of recipes instead
        #[arg(long, conflicts_with = "list")]
        schema: bool,
        /// List presets and cameras instead
        #[arg(long)]
        list: bool,
    },
    /// Measure the time per stage on this machine: the paper's timing figure, physics and
    /// optics
    Bench(BenchArgs),
    /// Print shell completions
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Write man pages
    Man {
        /// Output folder
        #[arg(short, long, value_name = "DIR")]
        output: PathBuf,
    },
}

/// A word as a shell takes it.
pub(crate) fn shell_word(word: &OsStr) -> String {
    let word = word.to_string_lossy().into_owned();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./:=,+@%".contains(c);
    match !word.is_empty() && word.chars().all(is_plain) {
        true => word,
        false => format!("'{}'", word.replace('\'', "'\\''")),
    }
}

/// The recipe in a file, or in what a pipe gives: its text, or what a record of ours has under `recipe`.
pub(crate) fn read_recipe(path: &Path) -> Result<Recipe, Failure> {
    // One byte more than a recipe may have is known to be too long; a record is longer.
    let longest = u64::try_from(MAX_RECIPE_BYTES).unwrap_or(u64::MAX);
    let read = File::open(path).and_then(|mut file| {
        let mut text = String::new();
        let mut start = file.by_ref().take(longest.saturating_add(1));
        start.read_to_string(&mut text)?;
        if text.starts_with('{') {
            file.take(MAX_ITEM_BYTES).read_to_string(&mut text)?;
            let record: Option<serde_json::Value> = serde_json::from_str(&text).ok();
            let recipe = record.and_then(|record| record["recipe"].as_str().map(str::to_owned));
            text = recipe.unwrap_or(text);
        }
        Ok(text)
    });
    let text = read.map_err(|cause| {
        Failure::wrong_input(format!(
            "recipe {path:?} cannot be read as UTF-8 text: {cause}"
        ))
    })?;
    Ok(Recipe::parse(&path.to_string_lossy(), &text)?)
}

impl Global {
    /// A flag that says which recipe, where one is given.
    pub(crate) fn recipe_flag(&self) -> Option<&'static str> {
        let given = [
            ("recipe", self.recipe.is_some()),
            ("preset", self.preset.is_some()),
            ("severity", self.severity.is_some()),
            ("camera", self.camera.is_some()),
            ("set", !self.set.is_empty()),
        ];
        given.into_iter().find_map(|(flag, is)| is.then_some(flag))
    }

    /// The recipe that the flags ask for.
    pub(crate) fn recipe(&self) -> Result<Recipe, Failure> {
        self.recipe_or(DEFAULT_PRESET)
    }

    /// The recipe that the flags ask for, with this preset where they name none.
    pub(crate) fn recipe_or(&self, default_preset: &str) -> Result<Recipe, Failure> {
        match &self.recipe {
            Some(path) => self.recipe_of(path),
            None => self.preset_called(self.preset.as_deref().unwrap_or(default_preset)),
        }
    }

    /// A preset, with the severity and all else that the flags say of recipes.
    pub(crate) fn preset_called(&self, name: &str) -> Result<Recipe, Failure> {
        let mut recipe = match self.severity {
            Some(severity) => Recipe::preset_at(name, severity)?,
            None => Recipe::preset(name)?,
        };
        self.adjust(&mut recipe)?;
        Ok(recipe)
    }

    /// The recipe in a file, with what the flags say of recipes.
    fn recipe_of(&self, path: &Path) -> Result<Recipe, Failure> {
        if self.severity.is_some() {
            return Err(Failure::wrong_input(format!(
                "--severity scales a preset, but the recipe {path:?} says its values itself; leave one of the two \
                 out, or begin a recipe with `starbreak recipe --preset NAME --severity N`"
            )));
        }
        let mut recipe = read_recipe(path)?;
        self.adjust(&mut recipe)?;
        Ok(recipe)
    }

    /// The same, of a file that the output does not replace.
    pub(crate) fn recipe_in(&self, path: &Path, output: &Path) -> Result<Recipe, Failure> {
        refuse_recipe(path, &[output.to_owned()])?;
        self.recipe_of(path)
    }

    /// Lays the camera over a recipe, then sets single parameters; and the limit of its memory.
    pub(crate) fn adjust(&self, recipe: &mut Recipe) -> Result<(), RecipeError> {
        recipe.set_max_memory(self.max_memory);
        let set = self.set.iter().map(|text| Assignment::parse(text));
        recipe.adjust(self.camera.as_deref(), &set.collect::<Result<Vec<_>, _>>()?)
    }

    /// An empty batch for outputs, which replaces what the flags say.
    pub(crate) fn batch(&self) -> OutputBatch {
        OutputBatch::new().replacing(self.replace)
    }

    /// Refuses outputs that are there already, before the work.
    pub(crate) fn refuse_taken(&self, outputs: &[PathBuf]) -> Result<(), Failure> {
        let batch = self.batch();
        Ok(outputs.iter().try_for_each(|path| batch.may_write(path))?)
    }

    /// The dataset in `FORMAT:PATH`.
    pub(crate) fn spec(&self, text: &OsStr) -> Result<SourceSpec, DatasetError> {
        Ok(SourceSpec::parse(text)?.following_links(self.follow_links))
    }

    /// None of the outputs is the recipe file, which would be lost.
    pub(crate) fn refuse_recipe_among(&self, outputs: &[PathBuf]) -> Result<(), Failure> {
        match &self.recipe {
            Some(recipe) => refuse_recipe(recipe, outputs),
            None => Ok(()),
        }
    }

    /// Whether a flag says with which recipe or seed something is to be made.
    pub(crate) fn says_what_to_make(&self) -> bool {
        self.recipe_flag().is_some() || self.seed != 0
    }

    /// The seed.
    pub(crate) fn seed(&self) -> Seed {
        Seed(self.seed)
    }
}

/// None of the outputs is this recipe file, which would be lost.
fn refuse_recipe(recipe: &Path, outputs: &[PathBuf]) -> Result<(), Failure> {
    match outputs.iter().find(|output| same_file(recipe, output)) {
        Some(output) => Err(Failure::wrong_input(format!(
            "the output {output:?} would replace the recipe {recipe:?}; choose another name"
        ))),
        None => Ok(()),
    }
}

/// Units of memory and their bytes.
const MEMORY_UNITS: [(&str, f64); 4] = [
    ("MiB", 1_048_576.0),
    ("GiB", 1_073_741_824.0),
    ("MB", 1e6),
    ("GB", 1e9),
];

fn parse_memory(text: &str) -> Result<u64, String> {
    let number = |(unit, bytes): &(&str, f64)| {
        let number: f64 = text.strip_suffix(unit)?.trim().parse().ok()?;
        Some(number * bytes)
    };
    let bytes = MEMORY_UNITS.iter().find_map(number);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "`as` saturates"
    )]
    let bytes = bytes.map(|bytes| bytes as u64);
    bytes
        .filter(|bytes| *bytes >= LEAST_MAX_MEMORY_BYTES)
        .ok_or_else(|| {
            "expected a size with its unit, MiB, GiB, MB or GB, from 64MiB on, e.g. 800MiB or 16GiB"
                .to_owned()
        })
}

/// Longest side of a simulated frame, px; that of the largest image that can be read.
const MAX_SIDE_PX: u32 = 32_768;

fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let wrong =
        || format!("expected WIDTHxHEIGHT in whole px, each 1 to {MAX_SIDE_PX}, e.g. 1242x375");
    let (width, height) = text.split_once(['x', '×']).ok_or_else(wrong)?;
    let side = |text: &str| {
        text.trim()
            .parse()
            .ok()
            .filter(|side| (1..=MAX_SIDE_PX).contains(side))
            .ok_or_else(wrong)
    };
    Ok((side(width)?, side(height)?))
}
