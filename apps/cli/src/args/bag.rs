//! `bag` as it is typed.

use std::path::PathBuf;

use clap::Args;
use starbreak_runs::bag::ImpactAt;

use super::video::{GrowthArgs, LightWord};

/// Flags of `starbreak bag`.
#[derive(Debug, Args)]
pub(crate) struct BagArgs {
    /// A recording in MCAP
    #[arg(value_name = "IN")]
    pub(crate) input: PathBuf,
    /// Output recording (.mcap)
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// Damage this camera; repeatable. A preset or a recipe file behind the name is its own, as
    /// in /cam/front=front.toml [default: all cameras, each with a pane of its own]
    #[arg(long, value_name = "TOPIC[=RECIPE]", value_parser = parse_topic)]
    pub(crate) topic: Vec<TopicArg>,
    /// Time of the impact, s after the first image of all cameras, or @ and a header stamp in
    /// seconds; earlier images stay unchanged
    #[arg(long, value_name = "S|@STAMP", default_value = "0", value_parser = parse_impact, allow_hyphen_values = true)]
    pub(crate) impact_at: ImpactAt,
    #[command(flatten)]
    pub(crate) growth: GrowthArgs,
    /// Add to each camera TOPIC/starbreak/region, a mask of affected pixels for each image, and
    /// TOPIC/starbreak/track, a line of JSON on the state of its glass
    #[arg(long)]
    pub(crate) masks: bool,
    /// Add to each camera with JPEG TOPIC/starbreak/control: its images without damage, but
    /// decoded and encoded again
    #[arg(long)]
    pub(crate) control: bool,
    /// Light around the camera: the mean of about the last second, or that of the first image
    #[arg(long, value_enum, default_value_t = LightWord::Follow)]
    pub(crate) light: LightWord,
}

/// A topic, and a recipe for it.
#[derive(Debug, Clone)]
pub(crate) struct TopicArg {
    pub(crate) topic: String,
    /// A preset or a file.
    pub(crate) recipe: Option<String>,
}

/// Names of topics have no equals sign.
fn parse_topic(text: &str) -> Result<TopicArg, String> {
    let (topic, recipe) = match text.split_once('=') {
        Some((topic, recipe)) => (topic, Some(recipe.to_owned())),
        None => (text, None),
    };
    if topic.is_empty() || recipe.as_ref().is_some_and(String::is_empty) {
        return Err("expected a topic, or a topic and a recipe: /cam/front=front.toml".to_owned());
    }
    Ok(TopicArg {
        topic: topic.to_owned(),
        recipe,
    })
}

/// Longest time after the first image, s: a year.
const MAX_AFTER_S: f64 = 31_557_600.0;

fn parse_impact(text: &str) -> Result<ImpactAt, String> {
    let wrong = || {
        "expected seconds after the first image (2.5), or @ and a header stamp in seconds (@1700000000.25)".to_owned()
    };
    match text.strip_prefix('@') {
        Some(stamp) => stamp_ns(stamp).map(ImpactAt::Stamp).ok_or_else(wrong),
        None => match text.parse() {
            Ok(after_s) if (0.0..=MAX_AFTER_S).contains(&after_s) => {
                Ok(ImpactAt::AfterFirst(after_s))
            }
            _ => Err(wrong()),
        },
    }
}

/// A stamp in nanoseconds, to the last digit.
fn stamp_ns(text: &str) -> Option<i64> {
    let (seconds, fraction) = text.split_once('.').unwrap_or((text, "0"));
    let is_digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    if !(is_digits(seconds) && is_digits(fraction) && fraction.len() <= 9) {
        return None;
    }
    let seconds: i64 = seconds.parse().ok()?;
    let nanoseconds: i64 = format!("{fraction:0<9}").parse().ok()?;
    seconds.checked_mul(1_000_000_000)?.checked_add(nanoseconds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_of_an_impact() {
        for (text, expected) in [
            ("0", Ok(ImpactAt::AfterFirst(0.0))),
            ("2.5", Ok(ImpactAt::AfterFirst(2.5))),
            (
                "@1700000000",
                Ok(ImpactAt::Stamp(1_700_000_000_000_000_000)),
            ),
            (
                "@1700000000.25",
                Ok(ImpactAt::Stamp(1_700_000_000_250_000_000)),
            ),
            ("@0.000000001", Ok(ImpactAt::Stamp(1))),
            ("-1", Err(())),
            ("nan", Err(())),
            ("1e12", Err(())),
            ("@", Err(())),
            ("@-1", Err(())),
            ("@1.0000000001", Err(())),
            ("@99999999999999999999", Err(())),
        ] {
            assert_eq!(parse_impact(text).map_err(|_| ()), expected, "{text}");
        }
    }

    #[test]
    fn topics_with_and_without_a_recipe() {
        let parsed = |text| {
            let TopicArg { topic, recipe } = parse_topic(text).ok()?;
            Some((topic, recipe))
        };
        let front = |recipe: Option<&str>| Some(("/front".to_owned(), recipe.map(str::to_owned)));
        assert_eq!(parsed("/front"), front(None), "alone");
        assert_eq!(parsed("/front=a=b.toml"), front(Some("a=b.toml")), "a file");
        for wrong in ["", "=a.toml", "/front="] {
            assert_eq!(parsed(wrong), None, "{wrong}");
        }
    }
}
