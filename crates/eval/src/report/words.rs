//! Numbers and names as a reader sees them.

use crate::evaluation::{GroupKind, PairedMetric, Scope, ScopeKind};

/// How intervals of differences of AP come about: the words of files.
pub(super) const DIFFERENCE_INTERVAL: &str = "permutation interval, 95 %";
/// Those of rPC.
pub(super) const RATIO_INTERVAL: &str =
    "wider of expanded percentile bootstrap and permutation interval, 95 %";
/// Those of AP alone, of mPC and of what is counted per area.
pub(super) const AP_INTERVAL: &str = "expanded percentile bootstrap, 95 %";
/// Those of shares of objects.
pub(super) const RATE_INTERVAL: &str = "cluster-adjusted Wilson (images), 95 %";
/// Those of mean changes.
pub(super) const SHIFT_INTERVAL: &str = "cluster-robust t (images), 95 %";
/// Those of slopes over a dose.
pub(super) const SLOPE_INTERVAL: &str = "maximum likelihood, cluster-robust t (images), 95 %";

/// The same method where clusters of images are drawn in the place of images.
pub(super) fn over_clusters(method: &'static str) -> &'static str {
    match method {
        RATE_INTERVAL => "cluster-adjusted Wilson (clusters of images), 95 %",
        SHIFT_INTERVAL => "cluster-robust t (clusters of images), 95 %",
        SLOPE_INTERVAL => "maximum likelihood, cluster-robust t (clusters of images), 95 %",
        other => other,
    }
}

/// What intervals are, for a reader; of the methods that [`crate::resampling`] and [`crate::statistic`] take.
pub(super) const INTERVALS: &str = "Difference of AP: permutation interval. The clean and damaged versions of random images (or clips and drives, \
     where frames belong together) are exchanged. The interval is the difference plus or minus the size within \
     which 95 % of the differences after exchange lie, so it contains 0 exactly where p is 0.05 or more. AP alone, \
     mPC, and counts per area: bootstrap over images, each with all its seeds. The expanded percentile interval is \
     slightly wider than the central 95 % of the replicates, to allow for few images. The lower end of an AP \
     interval is moved down by the amount by which halves of the images have a higher AP than all images. rPC: at \
     each end the wider of this bootstrap and the permutation interval of its logarithm. Rates: Wilson's interval \
     with the variance between images instead of that of independent objects. Mean changes of score and IoU, and \
     slopes: intervals from the same variance. All intervals are for other images with other damage of the same \
     kind, not for another detector.";
/// What tests are, for a reader.
pub(super) const TESTS: &str = "p is the probability of a difference at least this large by chance alone, two-sided. Permutation test: the \
     clean and damaged versions of random images (or clips and drives) are exchanged, with all seeds; for lost \
     against recovered objects, every combination of images is exchanged. Holm's correction keeps the probability of any \
     false alarm at the level of one test, over all tests of one metric and one detector under all conditions. The \
     tests of all classes are one family, those of supercategories and classes another. A class that is all of its \
     supercategory shares its test.";

/// What stands where there is no number.
pub(super) const NOTHING: &str = "–";

/// A number with so many digits behind the point, and a true minus sign.
pub(super) fn decimal(value: f64, n_digits: usize) -> String {
    if !value.is_finite() {
        return NOTHING.to_owned();
    }
    let text = format!("{value:.n_digits$}");
    // −0.0 is 0.0.
    let is_zero = text.chars().all(|c| matches!(c, '-' | '0' | '.'));
    match text.strip_prefix('-') {
        Some(positive) if is_zero => positive.to_owned(),
        Some(positive) => format!("−{positive}"),
        None => text,
    }
}

/// A share as percent, without the sign.
pub(super) fn percent(share: f64) -> String {
    decimal(share * 100.0, 1)
}

/// The same with its sign, for differences.
pub(super) fn signed_percent(share: f64) -> String {
    let text = percent(share);
    if share > 0.0 && text != "0.0" {
        return format!("+{text}");
    }
    text
}

/// A probability.
pub(super) fn probability(p: f64) -> String {
    if !p.is_finite() {
        return NOTHING.to_owned();
    }
    if p < 0.001 {
        return "<0.001".to_owned();
    }
    decimal(p, 3)
}

/// A count with thin spaces between thousands.
pub(super) fn count(n: u64) -> String {
    let digits = n.to_string();
    if digits.len() < 5 {
        return digits;
    }
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

/// A count as a number to compute with.
pub(super) fn as_number(n: u64) -> f64 {
    #[expect(
        clippy::cast_precision_loss,
        reason = "counts of objects are far below 2^53"
    )]
    let number = n as f64;
    number
}

/// A name from outside: what would steer a terminal or turn the direction of reading is shown as a
/// replacement character.
pub(super) fn name(text: &str) -> String {
    let is_unseen = |c: char| {
        c.is_control()
            || matches!(c, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{2069}')
            || matches!(c, '\u{feff}' | '\u{fffe}' | '\u{ffff}')
    };
    text.chars()
        .map(|c| if is_unseen(c) { '\u{fffd}' } else { c })
        .collect()
}

/// Each once, in the order in which they come first.
pub(super) fn distinct<T: PartialEq>(all: impl Iterator<Item = T>) -> Vec<T> {
    let mut distinct = Vec::new();
    for one in all {
        if !distinct.contains(&one) {
            distinct.push(one);
        }
    }
    distinct
}

/// Where, in words.
pub(super) fn scope(scope: &Scope) -> String {
    match (scope.kind, scope.tau) {
        (ScopeKind::WholeImage, _) => "whole image".to_owned(),
        (ScopeKind::InRegion, Some(tau)) if tau <= 0.0 => "in region (any overlap)".to_owned(),
        (ScopeKind::InRegion, Some(tau)) => format!("in region (τ = {tau})"),
        (ScopeKind::InRegion, None) => "in region".to_owned(),
        (ScopeKind::OutOfRegion, Some(tau)) if tau <= 0.0 => {
            "out of region (no overlap)".to_owned()
        }
        (ScopeKind::OutOfRegion, Some(tau)) => format!("out of region (τ = {tau})"),
        (ScopeKind::OutOfRegion, None) => "out of region".to_owned(),
    }
}

/// A metric's name.
pub(super) fn metric(metric: PairedMetric) -> &'static str {
    match metric {
        PairedMetric::Ap50 => "AP50",
        PairedMetric::Ap75 => "AP75",
        PairedMetric::Ap => "AP",
        PairedMetric::KittiAp11 => "AP11",
        PairedMetric::KittiAp40 => "AP40",
    }
}

/// A metric's key in files.
pub(super) fn metric_key(metric: PairedMetric) -> &'static str {
    match metric {
        PairedMetric::Ap50 => "ap50",
        PairedMetric::Ap75 => "ap75",
        PairedMetric::Ap => "ap",
        PairedMetric::KittiAp11 => "kitti_ap11",
        PairedMetric::KittiAp40 => "kitti_ap40",
    }
}

/// The sort of a group.
pub(super) fn group_kind(kind: GroupKind) -> &'static str {
    match kind {
        GroupKind::All => "all",
        GroupKind::MeanOfSupercategories => "mean_of_supercategories",
        GroupKind::Supercategory => "supercategory",
        GroupKind::Class => "class",
    }
}

#[cfg(test)]
mod tests {
    use super::{count, decimal, name, percent, probability, signed_percent};

    #[test]
    fn numbers_read_as_in_print() {
        assert_eq!(percent(0.4131), "41.3", "one digit");
        assert_eq!(signed_percent(-0.139), "−13.9", "a true minus");
        assert_eq!(signed_percent(0.02), "+2.0", "a sign");
        assert_eq!(decimal(-0.0001, 1), "0.0", "no minus before nothing");
        assert_eq!(probability(0.000_2), "<0.001", "too small to tell");
        assert_eq!(count(35_871), "35\u{202f}871", "thousands");
        assert_eq!(count(1200), "1200", "four digits stay together");
    }

    #[test]
    fn what_turns_the_direction_of_reading_is_shown() {
        assert_eq!(
            name("a\u{202e}b\u{7}c"),
            "a\u{fffd}b\u{fffd}c",
            "both shown"
        );
        assert_eq!(name("Straße"), "Straße", "letters stay");
    }
}
