//! Flags for photographs of broken glass in the place of simulated cracks.

use std::path::{Path, PathBuf};

use clap::{Args as ClapArgs, ValueEnum};
use starbreak::optics::photo::{Background, PhotoParams, PlacementRange};
use starbreak::photo::OverlayOptions;
use starbreak::{OpticsSettings, Settings};
use starbreak_dataset::same_file;
use starbreak_runs::Patterns;
use starbreak_runs::bank::{BANK_FILE, OVERLAY_BANK_FILE, OverlayBank};
use starbreak_runs::overlay::{OverlaySet, read_photo};

use crate::failure::Failure;

/// How photographs of broken glass are read and lit.
#[derive(Debug, ClapArgs)]
pub(crate) struct OverlayArgs {
    /// Background of the photo: `alpha` (cut out), `black` or `white` [default: found from its
    /// transparency and its border]
    #[arg(long, value_enum, value_name = "WHAT")]
    pub(crate) overlay_background: Option<BackgroundWord>,
    /// Tolerance of a black or white background, as a share of the largest code, 0 to 0.5; more
    /// hides noise of the photo and faint cracks
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    pub(crate) overlay_floor: Option<f64>,
    /// Brightness of the photo's white relative to a white sheet in the place of the glass, 0
    /// to 1000; 1 lights the glass like its scene (physical optics only)
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true)]
    pub(crate) overlay_gain: Option<f64>,
    /// Minimum side of a random part relative to the largest part that has the frame's shape,
    /// 0.05 to 1
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    pub(crate) overlay_min_scale: Option<f64>,
    /// How far a random part may extend beyond the photo, relative to its own side, 0 to 1
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    pub(crate) overlay_max_shift: Option<f64>,
}

/// What is behind the glass in a photograph.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum BackgroundWord {
    /// Nothing: the glass is cut out
    Alpha,
    /// Black: its light is added
    Black,
    /// White: it darkens
    White,
}

impl OverlayArgs {
    /// What the flags ask for, with random parts or the whole photograph.
    pub(crate) fn options(&self, is_random: bool) -> Result<OverlayOptions, Failure> {
        let usual = OverlayOptions::default();
        let range = PlacementRange::default();
        let options = OverlayOptions {
            params: PhotoParams {
                background: self.overlay_background.map(|word| match word {
                    BackgroundWord::Alpha => Background::Alpha,
                    BackgroundWord::Black => Background::Black,
                    BackgroundWord::White => Background::White,
                }),
                floor: self.overlay_floor.unwrap_or(usual.params.floor),
            },
            gain: self.overlay_gain.unwrap_or(usual.gain),
            random: is_random.then_some(PlacementRange {
                min_scale: self.overlay_min_scale.unwrap_or(range.min_scale),
                max_shift: self.overlay_max_shift.unwrap_or(range.max_shift),
            }),
        };
        options.check()?;
        Ok(options)
    }

    /// Refuses flags that would do nothing: those of a photograph without one, and those of random
    /// parts without them.
    pub(crate) fn refuse_idle(&self, has_photos: bool, is_random: bool) -> Result<(), Failure> {
        if !has_photos && let Some(flag) = self.given() {
            return Err(Failure::wrong_input(format!(
                "{flag} is for photos of broken glass, of which none are named; name them, too"
            )));
        }
        let placing = [
            ("--overlay-min-scale", self.overlay_min_scale),
            ("--overlay-max-shift", self.overlay_max_shift),
        ];
        if !is_random && let Some((flag, _)) = placing.iter().find(|(_, given)| given.is_some()) {
            return Err(Failure::wrong_input(format!(
                "{flag} is for random parts of a photo; ask for them with --overlay-random"
            )));
        }
        Ok(())
    }

    /// Refuses a gain with the paper's optics, which have no light that it could scale.
    pub(crate) fn refuse_idle_gain(&self, settings: &Settings) -> Result<(), Failure> {
        if self.overlay_gain.is_some() && matches!(settings.optics, OpticsSettings::Paper(_)) {
            return Err(Failure::wrong_input(
                "--overlay-gain is for the physical optics; the paper's lay the photo over the frame as it is: leave \
                 it out, or set optics.model=physical",
            ));
        }
        Ok(())
    }

    /// The photographs below a folder, if one was named, of which random parts are taken; or a
    /// bank of such parts, with which the flags are settled.
    pub(crate) fn read_folder(&self, folder: Option<&Path>) -> Result<Option<Patterns>, Failure> {
        self.refuse_idle(folder.is_some(), true)?;
        let Some(folder) = folder else {
            return Ok(None);
        };
        if folder.join(BANK_FILE).is_file() {
            return Err(Failure::wrong_input(format!(
                "{folder:?} is a bank of cracks, not of photos; `generate --bank` takes it"
            )));
        }
        if !is_bank(folder) {
            let photos = OverlaySet::read(folder, &self.options(true)?)?;
            return Ok(Some(Patterns::Overlays(photos)));
        }
        if let Some(flag) = self.given() {
            return Err(Failure::wrong_input(format!(
                "{flag} was settled when the bank {folder:?} was made; leave it out, or make another bank with it"
            )));
        }
        let bank = OverlayBank::open(folder)?;
        Ok(Some(Patterns::OverlayBank(Box::new(bank))))
    }

    /// The first flag that is given.
    fn given(&self) -> Option<&'static str> {
        let flags = [
            ("--overlay-background", self.overlay_background.is_some()),
            ("--overlay-floor", self.overlay_floor.is_some()),
            ("--overlay-gain", self.overlay_gain.is_some()),
            ("--overlay-min-scale", self.overlay_min_scale.is_some()),
            ("--overlay-max-shift", self.overlay_max_shift.is_some()),
        ];
        let given = flags.into_iter().find(|(_, is_given)| *is_given);
        given.map(|(flag, _)| flag)
    }

    /// The photograph in a file, if one was named; none of the outputs is that file.
    pub(crate) fn read_one(
        &self,
        file: Option<&Path>,
        is_random: bool,
        outputs: &[PathBuf],
    ) -> Result<Option<Patterns>, Failure> {
        self.refuse_idle(file.is_some(), is_random)?;
        let Some(file) = file else {
            return Ok(None);
        };
        if let Some(output) = outputs.iter().find(|output| same_file(file, output)) {
            return Err(Failure::wrong_input(format!(
                "the output {output:?} would replace the photo of glass {file:?}; choose another name"
            )));
        }
        let options = self.options(is_random)?;
        let glass = read_photo(file, &options.params)?;
        Ok(Some(Patterns::Overlays(OverlaySet::of(glass, &options))))
    }
}

/// Whether a path is that of a bank of photographs, or of the folder of one.
pub(crate) fn is_bank(path: &Path) -> bool {
    let is_named = path
        .file_name()
        .is_some_and(|name| name == OVERLAY_BANK_FILE);
    (is_named && path.is_file()) || path.join(OVERLAY_BANK_FILE).is_file()
}
