//! All that the numbers depend on.

use super::super::words;
use super::{Block, Cell, Section, Table};
use crate::evaluation::{Provenance, Study};

pub(super) fn section(study: &Study) -> Section {
    let provenance = &study.provenance;
    let mut blocks = vec![Block::table(settings(provenance))];
    if !provenance.inputs.is_empty() {
        let mut table = Table::new("Input files, with SHA-256.", "What|Path|#Bytes|SHA-256");
        for input in &provenance.inputs {
            table.push(vec![
                Cell::head(&input.role),
                Cell::text(&input.path),
                input.n_bytes.map_or_else(Cell::nothing, Cell::count),
                Cell::hash(&input.sha256),
            ]);
        }
        blocks.push(Block::table(table));
    }
    if let Some(command) = &provenance.command {
        blocks.push(Block::Verbatim {
            title: "Command".to_owned(),
            text: words::name(command),
        });
    }
    if let Some(recipe) = &provenance.recipe {
        let lines: Vec<String> = recipe.lines().map(words::name).collect();
        blocks.push(Block::fold(
            "The recipe of the damage",
            vec![Block::Verbatim {
                title: "Recipe".to_owned(),
                text: lines.join("\n"),
            }],
        ));
    }
    Section {
        id: "provenance".to_owned(),
        title: "Provenance".to_owned(),
        blocks,
    }
}

fn settings(provenance: &Provenance) -> Table {
    let settings = &provenance.settings;
    let mut table = Table::new("Settings and versions.", "Setting|Value");
    let mut row = |what: &str, value: String| {
        table.push(vec![Cell::head(what), Cell::text(value)]);
    };
    row("protocol", settings.protocol.clone());
    if let Some(definition) = &settings.region_definition {
        row("region definition", definition.clone());
    }
    if let Some(tau) = settings.tau {
        row(
            "τ, minimum coverage of an object in the region",
            tau.to_string(),
        );
    }
    row(
        "minimum confidence score of a found object",
        settings.score_threshold.to_string(),
    );
    row(
        "minimum IoU of a found object",
        settings.iou_threshold.to_string(),
    );
    if settings.min_objects > 0 {
        row(
            "minimum number of objects for a number",
            settings.min_objects.to_string(),
        );
    }
    if let Some(n) = settings.max_detections {
        row("maximum detections per image and class", n.to_string());
    }
    row("bootstrap replicates", settings.n_bootstrap.to_string());
    if settings.n_permutations > 0 {
        row(
            "replicates of the permutation test",
            settings.n_permutations.to_string(),
        );
    }
    row("resampling unit", settings.resampling_unit.clone());
    row("random seed", settings.seed.to_string());
    for version in &provenance.versions {
        row(&version.name, version.version.clone());
    }
    table
}
