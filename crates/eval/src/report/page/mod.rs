//! The page as blocks: what is said in which order, without a tag. The template gives each kind of
//! block its markup and escapes all text.

mod clip_charts;
mod curves;
mod definitions;
mod errors;
mod failures;
mod over_seeds;
mod overview;
mod pictures;
mod precision;
mod provenance;
mod sets;
mod severity;
mod table;
mod timeline;
mod warnings;

use serde::Serialize;

use crate::evaluation::{Evaluation, Study};

use super::charts::{Chart, KeyEntry};
use super::conditions::pool_of;
use super::words;
pub(super) use table::{Cell, Table};

/// The whole page.
#[derive(Debug, Serialize)]
pub(super) struct Page {
    pub(super) title: String,
    pub(super) subtitle: String,
    pub(super) warnings: Vec<PageWarning>,
    pub(super) facts: Vec<String>,
    pub(super) sections: Vec<Section>,
}

/// A warning with the word for what it is about.
#[derive(Debug, Serialize)]
pub(super) struct PageWarning {
    pub(super) about: &'static str,
    pub(super) text: String,
}

/// A heading with what stands under it.
#[derive(Debug, Serialize)]
pub(super) struct Section {
    pub(super) id: String,
    pub(super) title: String,
    pub(super) blocks: Vec<Block>,
}

/// One thing after the other.
#[derive(Debug, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub(super) enum Block {
    /// A heading below that of the section.
    Heading { id: String, text: String },
    /// A paragraph.
    Text { text: String },
    /// A table.
    Table { table: Table },
    /// A chart with the table of its numbers, folded away if it is only that.
    Chart {
        id: String,
        svg: String,
        key: Vec<KeyEntry>,
        caption: String,
        table: Option<Table>,
    },
    /// Blocks that open when asked for, and in print.
    Fold { title: String, blocks: Vec<Block> },
    /// Words and what they mean.
    Terms { terms: Vec<Term> },
    /// Clean | cracked pairs of pictures.
    Pictures { pairs: Vec<pictures::Pair> },
    /// Text as it is, with its line breaks.
    Verbatim { title: String, text: String },
}

impl Block {
    fn table(table: Table) -> Self {
        Self::Table { table }
    }

    fn heading(id: String, text: impl Into<String>) -> Self {
        let text = text.into();
        Self::Heading { id, text }
    }

    fn text(text: impl Into<String>) -> Self {
        Self::Text { text: text.into() }
    }

    fn fold(title: impl Into<String>, blocks: Vec<Self>) -> Self {
        let title = title.into();
        Self::Fold { title, blocks }
    }

    fn chart(chart: Chart, caption: impl Into<String>, table: Option<Table>) -> Self {
        Self::Chart {
            id: format!("fig-{}", chart.id),
            svg: chart.svg,
            key: chart.key,
            caption: caption.into(),
            table,
        }
    }
}

/// A word and what it means.
#[derive(Debug, Serialize)]
pub(super) struct Term {
    pub(super) word: &'static str,
    pub(super) meaning: &'static str,
}

/// Everything that the page says about a study.
pub(super) fn page(study: &Study) -> Page {
    let n_evaluations = study.evaluations.len();
    let of_clips = timeline::is_of_clips_alone(study);
    let mut sections = vec![match of_clips {
        true => timeline::section(study),
        false => {
            let mut section = overview::section(study);
            section.blocks.splice(0..0, severity::charts(study));
            section
        }
    }];
    sections.extend(errors::classes_section(study));
    for (place, one) in study.over_seeds.iter().enumerate() {
        sections.push(over_seeds::section(study, one, &format!("p{place}")));
    }
    let mut one_by_one = Vec::new();
    for (place, evaluation) in study.evaluations.iter().enumerate() {
        let id = format!("e{place}");
        let section = evaluation_section(study, evaluation, &id, n_evaluations);
        // What stands above with all its seeds needs no line of its own among the contents.
        match pool_of(study, evaluation) {
            Some(_) => one_by_one.push(Block::Fold {
                title: section.title,
                blocks: unfolded(section.blocks),
            }),
            None => sections.push(section),
        }
    }
    if !one_by_one.is_empty() {
        sections.push(Section {
            id: "seeds".to_owned(),
            title: "Each seed separately".to_owned(),
            blocks: one_by_one,
        });
    }
    sections.extend(study.divergence.as_ref().map(sets::section));
    sections.push(definitions::section());
    sections.push(provenance::section(study));
    Page {
        title: words::name(&study.title),
        subtitle: match of_clips {
            true => timeline::subtitle(study),
            false => overview::subtitle(study),
        },
        warnings: warnings::warnings(study),
        facts: [overview::facts(study), timeline::facts(study)].concat(),
        sections,
    }
}

/// What a section holds, without a fold around all of it.
fn unfolded(mut blocks: Vec<Block>) -> Vec<Block> {
    match (blocks.len(), blocks.pop()) {
        (1, Some(Block::Fold { blocks, .. })) => blocks,
        (_, last) => {
            blocks.extend(last);
            blocks
        }
    }
}

fn evaluation_section(
    study: &Study,
    evaluation: &Evaluation,
    id: &str,
    n_evaluations: usize,
) -> Section {
    let mut blocks = precision::blocks(study, evaluation, id);
    blocks.extend(failures::blocks(study, evaluation, id));
    blocks.extend(errors::blocks(study, evaluation, id));
    blocks.extend(timeline::blocks(evaluation, id));
    blocks.extend(pictures::blocks(study, evaluation, id));
    let title = words::name(&format!(
        "{} · {}",
        evaluation.detector, evaluation.condition.name
    ));
    // Of many, a reader opens what he wants to see.
    if n_evaluations > 2 {
        blocks = vec![Block::Fold {
            title: format!("All numbers for {title}"),
            blocks,
        }];
    }
    Section {
        id: id.to_owned(),
        title,
        blocks,
    }
}
