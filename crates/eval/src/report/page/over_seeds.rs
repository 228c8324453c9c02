//! The mean over seeds of conditions that differ in nothing else.

use super::super::words;
use super::overview::units;
use super::precision::group_name;
use super::precision::paired_blocks;
use super::{Block, Cell, Section, Table};
use crate::evaluation::{GroupKind, OverSeeds, Study};

pub(super) fn section(study: &Study, one: &OverSeeds, id: &str) -> Section {
    let seeds: Vec<String> = one.seeds.iter().map(u64::to_string).collect();
    let text = format!(
        "AP is the mean over the seeds {}; a share is that of the objects of all seeds, so that an object \
         counts once for each seed in which it is in the region. Intervals and p draw and exchange {} with \
         all their seeds.",
        seeds.join(", "),
        units(study)
    );
    let mut blocks = paired_blocks(study, &one.paired, &text, id);
    blocks.push(Block::Heading {
        id: format!("{id}-failures"),
        text: "What fails".to_owned(),
    });
    blocks.push(Block::Table {
        table: rate_table(one),
    });
    let title = words::name(&format!("{} · {}", one.detector, one.condition.name));
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
fn rate_table(one: &OverSeeds) -> Table {
    let mut table = Table::new(
        "Lost of the objects found clean, over all seeds; p of lost against recovered, alone and corrected by \
         Holm's method. 95 % intervals in brackets.",
        &[
            ("Where", false),
            ("Class", false),
            ("Objects", true),
            ("Found clean", true),
            ("Found cracked", true),
            ("Lost", true),
            ("Recovered", true),
            ("Failure rate, %", true),
            ("p", true),
            ("p (Holm)", true),
        ],
    );
    let is_shown = |kind: GroupKind, has_number: bool| kind == GroupKind::All || has_number;
    for row in &one.rates {
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
            Cell::probability(row.p),
            Cell::probability(row.p_holm),
        ]);
    }
    table
}
