//! Conditions that differ in nothing but their seed, taken together.

use super::super::words;
use super::precision::group_name;
use super::precision::paired_blocks;
use super::{Block, Cell, Section, Table};
use crate::evaluation::{GroupKind, PooledSeeds, Study};

pub(super) fn section(study: &Study, pooled: &PooledSeeds, id: &str) -> Section {
    let seeds: Vec<String> = pooled.seeds.iter().map(u64::to_string).collect();
    let text = format!(
        "The cracked images of the seeds {} are one set, of which an image is a part once per seed; an \
         object counts once for each seed in which it is in the region. Intervals draw images and seeds. \
         There is no p: the same object behind several patterns is no independent pair.",
        seeds.join(", ")
    );
    let mut blocks = paired_blocks(study, &pooled.paired, &text, id);
    blocks.push(Block::Heading {
        id: format!("{id}-failures"),
        text: "What fails".to_owned(),
    });
    blocks.push(Block::Table {
        table: rate_table(pooled),
    });
    let title = words::name(&format!("{} · {}", pooled.detector, pooled.condition.name));
    Section {
        id: id.to_owned(),
        blocks: vec![Block::Fold {
            title: format!("All numbers of {title}"),
            blocks,
        }],
        title,
    }
}

/// All classes, and the groups and classes with a number, place by place.
fn rate_table(pooled: &PooledSeeds) -> Table {
    let mut table = Table::new(
        "Lost of the objects found clean, over all seeds, with 95 % intervals of the two-way bootstrap over \
         images and seeds.",
        &[
            ("Where", false),
            ("Class", false),
            ("Objects", true),
            ("Found clean", true),
            ("Found cracked", true),
            ("Lost", true),
            ("Recovered", true),
            ("Failure rate, %", true),
        ],
    );
    let is_shown = |kind: GroupKind, has_number: bool| kind == GroupKind::All || has_number;
    for row in &pooled.rates {
        if !is_shown(row.group.kind, row.failure_rate.value.is_some()) {
            continue;
        }
        let rate = table.estimate(&row.failure_rate, words::percent);
        table.push(vec![
            Cell::head(words::scope(&row.scope)),
            Cell::text(group_name(&row.group)),
            Cell::count(row.n_objects),
            Cell::count(row.n_found_clean),
            Cell::count(row.n_found_cracked),
            Cell::count(row.n_lost),
            Cell::count(row.n_recovered),
            rate,
        ]);
    }
    table
}
