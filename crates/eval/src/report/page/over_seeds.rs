//! The mean over seeds of conditions that differ in nothing else.

use super::super::conditions::Summed;
use super::super::words;
use super::failures::rate_table;
use super::overview::units;
use super::precision::group_name;
use super::precision::paired_blocks;
use super::{Block, Section, Table, curves};
use crate::evaluation::{FailureRow, GroupKind, OverSeeds, Study};

pub(super) fn section(study: &Study, one: &OverSeeds, id: &str) -> Section {
    let seeds: Vec<String> = one.seeds.iter().map(u64::to_string).collect();
    let text = format!(
        "AP is the mean over the seeds {}. Rates are over the objects of all seeds, so an object counts once \
         for each seed in which it is in the region. Intervals and p resample and exchange {} with all their \
         seeds.",
        seeds.join(", "),
        units(study)
    );
    let mut blocks = paired_blocks(study, &one.paired, &text, id);
    blocks.extend(curves::of_condition(study, &Summed::of_pool(one), id));
    blocks.push(Block::heading(
        format!("{id}-failures"),
        "Detection failures".to_owned(),
    ));
    blocks.push(Block::table(rates(one)));
    let title = words::name(&format!("{} · {}", one.detector, one.condition.name));
    Section {
        id: id.to_owned(),
        blocks: vec![Block::fold(format!("All numbers for {title}"), blocks)],
        title,
    }
}

/// All classes, and the groups and classes with a number, place by place.
fn rates(one: &OverSeeds) -> Table {
    let is_shown =
        |row: &&FailureRow| row.group.kind == GroupKind::All || row.failure_rate.value.is_some();
    let about = |row: &FailureRow| vec![words::scope(&row.scope), group_name(&row.group)];
    rate_table(
        "Objects found in the clean images and lost, over all seeds. p tests lost against recovered objects, \
         without and with Holm's correction. 95 % intervals in brackets.",
        "Where|Class",
        one.rates
            .iter()
            .filter(is_shown)
            .map(|row| (about(row), row)),
    )
}
