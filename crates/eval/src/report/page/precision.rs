//! AP: paired in and out of the region, on whole images, by the protocol's own table.

use super::super::charts::{ChartText, Ink, RowSeries, row_chart};
use super::super::conditions::Summed;
use super::super::words;
use super::{Block, Cell, Table, curves};
use crate::chart::{Axis, Marker};
use crate::evaluation::{
    Evaluation, Group, GroupKind, PairedMetric, PairedRow, ProtocolResults, Scope, ScopeKind, Study,
};

/// Most rows of a chart.
const MAX_CHART_ROWS: usize = 24;

/// The twelve numbers of MS-COCO.
const COCO_STATS: [&str; 12] = [
    "AP",
    "AP50",
    "AP75",
    "AP small",
    "AP medium",
    "AP large",
    "AR 1",
    "AR 10",
    "AR 100",
    "AR small",
    "AR medium",
    "AR large",
];

pub(super) fn blocks(study: &Study, evaluation: &Evaluation, id: &str) -> Vec<Block> {
    let mut blocks = paired_blocks(study, &evaluation.paired, &region_text(evaluation), id);
    blocks.extend(subset_table(evaluation).map(|table| {
        Block::fold(
            "By coverage, and by size in the region",
            vec![Block::table(table)],
        )
    }));
    blocks.extend(curves::of_condition(study, &Summed::of(evaluation), id));
    let clean = study.clean_of(&evaluation.detector).map(|one| &one.results);
    if let Some(clean) = clean {
        blocks.extend(coco_table(clean, evaluation).map(|table| {
            Block::fold(
                "The twelve MS-COCO metrics, whole images",
                vec![Block::table(table)],
            )
        }));
        blocks.extend(kitti_table(clean, evaluation).map(Block::table));
    }
    blocks
}

/// Chart and tables of paired rows, the region first.
pub(super) fn paired_blocks(
    study: &Study,
    paired: &[PairedRow],
    words_first: &str,
    id: &str,
) -> Vec<Block> {
    let mut blocks = Vec::new();
    let own = study.provenance.settings.tau;
    let mut scopes = words::distinct(paired.iter().map(|row| &row.scope));
    if !scopes.is_empty() {
        blocks.push(Block::heading(
            format!("{id}-ap"),
            "Average precision, paired".to_owned(),
        ));
        blocks.push(Block::text(words_first));
    }
    let main = scopes
        .iter()
        .find(|scope| scope.kind == ScopeKind::InRegion && scope.is_at(own))
        .or_else(|| scopes.first())
        .copied();
    if let Some(main) = main {
        blocks.extend(chart(paired, main, id));
        blocks.push(Block::table(paired_table(paired, main)));
    }
    // The control first, then everything, then other thresholds.
    let rank = |scope: &Scope| match (scope.kind, scope.is_at(own)) {
        (ScopeKind::OutOfRegion, true) => 0,
        (ScopeKind::WholeImage, _) => 1,
        _ => 2,
    };
    scopes.sort_by_key(|scope| rank(scope));
    for scope in scopes {
        if Some(scope) == main {
            continue;
        }
        blocks.push(Block::fold(
            format!("Average precision, {}", words::scope(scope)),
            vec![Block::table(paired_table(paired, scope))],
        ));
    }
    blocks
}

fn region_text(evaluation: &Evaluation) -> String {
    let counts = &evaluation.counts;
    let mut text =
        "The clean and the damaged image are evaluated on the same objects under the same mask; \
                    the difference is damaged minus clean."
            .to_owned();
    if let (Some(n_images), Some(n_objects)) =
        (counts.n_images_with_region, counts.n_objects_in_region)
    {
        text.push_str(&format!(
            " The region touches {} of {} images and contains {} of {} objects",
            words::count(n_images),
            words::count(counts.n_images),
            words::count(n_objects),
            words::count(counts.n_objects),
        ));
        if let Some(n_intact @ 1..) = counts.n_images_intact {
            text.push_str(&format!(
                "; {} images are undamaged, as their pattern changes no pixel",
                words::count(n_intact)
            ));
        }
        if let Some(share) = counts.mean_region_share {
            text.push_str(&format!(
                "; it covers {} % of an image on average",
                words::percent(share)
            ));
        }
        text.push('.');
    }
    text
}

fn find<'a>(
    paired: &'a [PairedRow],
    scope: &Scope,
    group: &Group,
    metric: PairedMetric,
) -> Option<&'a PairedRow> {
    paired
        .iter()
        .find(|row| row.scope == *scope && row.group == *group && row.metric == metric)
}

/// The two metrics of a table: those of the paper, or KITTI's.
fn metrics(paired: &[PairedRow], scope: &Scope) -> Vec<PairedMetric> {
    use PairedMetric::{Ap, Ap50, Ap75, KittiAp11, KittiAp40};
    let has = |metric| {
        paired
            .iter()
            .any(|row| row.scope == *scope && row.metric == metric)
    };
    let all = [Ap50, Ap75, KittiAp40, KittiAp11, Ap];
    all.into_iter()
        .filter(|metric| has(*metric))
        .take(2)
        .collect()
}

/// The groups of a scope: all, supercategories, classes; those with many objects first.
fn groups(paired: &[PairedRow], scope: &Scope) -> Vec<(Group, u64)> {
    let mut groups: Vec<(Group, u64)> = Vec::new();
    for row in paired.iter().filter(|row| row.scope == *scope) {
        if groups.iter().all(|(known, _)| *known != row.group) {
            groups.push((row.group.clone(), row.n_objects));
        }
    }
    groups.sort_by(|a, b| (a.0.kind, b.1, &a.0.name).cmp(&(b.0.kind, a.1, &b.0.name)));
    groups
}

fn chart(paired: &[PairedRow], scope: &Scope, id: &str) -> Option<Block> {
    let metric = *metrics(paired, scope).first()?;
    let rows: Vec<&PairedRow> = groups(paired, scope)
        .iter()
        .filter_map(|(group, _)| find(paired, scope, group, metric))
        .filter(|row| row.clean.value.is_some() && row.cracked.value.is_some())
        .take(MAX_CHART_ROWS)
        .collect();
    if rows.is_empty() {
        return None;
    }
    let names: Vec<String> = rows.iter().map(|row| group_name(&row.group)).collect();
    let series = |name, ink, marker, of: fn(&PairedRow) -> &crate::evaluation::Estimate| {
        let values = rows.iter().filter_map(|pair| {
            let estimate = of(pair);
            let ends = estimate.interval().map(|ends| ends.map(|end| end * 100.0));
            Some((estimate.value? * 100.0, ends))
        });
        RowSeries {
            name,
            ink,
            marker: Some(marker),
            values: values.collect(),
        }
    };
    let series = [
        series("clean", Ink::Clean, Marker::Circle, |row| &row.clean),
        series("damaged", Ink::Cracked, Marker::Diamond, |row| &row.cracked),
    ];
    let metric = words::metric(metric);
    let place = words::scope(scope);
    let chart_id = format!("{id}-ap-chart");
    let chart = row_chart(
        &names,
        &series,
        Axis::of([0.0, 100.0], &format!("{metric}, %")),
        &ChartText {
            id: &chart_id,
            title: &format!("{metric} {place}, clean and damaged, with 95 % intervals"),
            description: "One row per group of classes; the table below gives the numbers.",
        },
    );
    Some(Block::chart(
        chart,
        format!(
            "{metric} {place} of all classes, and of supercategories and classes with enough objects; lines \
             are 95 % bootstrap intervals."
        ),
        None,
    ))
}

pub(super) fn group_name(group: &Group) -> String {
    match group.kind {
        GroupKind::All => "all classes".to_owned(),
        GroupKind::MeanOfSupercategories => "mean of supercategories".to_owned(),
        GroupKind::Supercategory => format!("{} (all)", words::name(&group.name)),
        GroupKind::Class => words::name(&group.name),
    }
}

fn paired_table(paired: &[PairedRow], scope: &Scope) -> Table {
    let metrics = metrics(paired, scope);
    let has_p = paired.iter().any(|row| row.p.is_some());
    let mut columns = "Class|#Objects|#Images".to_owned();
    for metric in &metrics {
        let metric = words::metric(*metric);
        let of_test = if has_p { "|#p|#p (Holm)" } else { "" };
        columns += &format!("|#{metric} clean|#{metric} damaged|#Difference{of_test}");
    }
    let place = words::scope(scope);
    let mut table = Table::new("", &columns);
    let mut left_out: Vec<String> = Vec::new();
    for (group, n_objects) in groups(paired, scope) {
        let rows: Vec<Option<&PairedRow>> = metrics
            .iter()
            .map(|metric| find(paired, scope, &group, *metric))
            .collect();
        let is_empty = |row: &Option<&PairedRow>| row.is_none_or(|row| row.clean.value.is_none());
        if group.kind == GroupKind::Class && rows.iter().all(is_empty) {
            if n_objects > 0 {
                left_out.push(format!("{} ({n_objects})", words::name(&group.name)));
            }
            continue;
        }
        let n_images = rows.iter().flatten().map(|row| row.n_images).next();
        let mut cells = vec![
            Cell::head(group_name(&group)),
            Cell::count(n_objects),
            Cell::count(n_images.unwrap_or(0)),
        ];
        for row in rows {
            let Some(row) = row else {
                let n_cells = if has_p { 5 } else { 3 };
                cells.extend((0..n_cells).map(|_| Cell::nothing()));
                continue;
            };
            cells.push(table.estimate(&row.clean, words::percent));
            cells.push(table.estimate(&row.cracked, words::percent));
            cells.push(table.estimate(&row.delta, words::signed_percent));
            if has_p {
                cells.push(Cell::probability(row.p));
                cells.push(Cell::probability(row.p_holm));
            }
        }
        table.push(cells);
    }
    let tests = match has_p {
        true => "; p of the permutation test, without and with Holm's correction",
        false => "",
    };
    table.caption = format!("Average precision {place}, percent, with 95 % intervals{tests}.");
    if !left_out.is_empty() {
        table.remark(&format!(
            "Classes with too few objects for a number of their own (objects in parentheses): {}.",
            left_out.join(", ")
        ));
    }
    table
}

/// AP50 of all classes by bin of coverage and by size.
fn subset_table(evaluation: &Evaluation) -> Option<Table> {
    let mut table = Table::new(
        "AP50 of all classes by coverage and by size of the objects, percent; without intervals.",
        "Subset|#Objects|#Images|#AP50 clean|#AP50 damaged",
    );
    let all = |row: &&crate::SubsetRow| row.group.kind == GroupKind::All;
    for row in evaluation.subsets.iter().filter(all) {
        let clean = table.estimate(&row.clean_ap50, words::percent);
        let cracked = table.estimate(row.cracked_ap50.as_ref(), words::percent);
        table.push(vec![
            Cell::head(&row.subset),
            Cell::count(row.n_objects),
            Cell::count(row.n_images),
            clean,
            cracked,
        ]);
    }
    (!table.rows.is_empty()).then_some(table)
}

fn coco_table(clean: &ProtocolResults, evaluation: &Evaluation) -> Option<Table> {
    let (clean, cracked) = (clean.coco_stats?, evaluation.cracked.coco_stats?);
    let mut table = Table::new(
        "Whole images by the rules of MS-COCO, percent; equal to pycocotools on the same files.",
        "Metric|#Clean|#Damaged|#Difference",
    );
    for ((name, clean), cracked) in COCO_STATS.iter().zip(clean).zip(cracked) {
        let difference = clean.zip(cracked).map(|(clean, cracked)| cracked - clean);
        table.push(vec![
            Cell::head(name),
            Cell::number(clean, words::percent),
            Cell::number(cracked, words::percent),
            Cell::number(difference, words::signed_percent),
        ]);
    }
    Some(table)
}

fn kitti_table(of_clean: &ProtocolResults, evaluation: &Evaluation) -> Option<Table> {
    if of_clean.kitti.is_empty() {
        return None;
    }
    let mut table = Table::new(
        "Whole images by the rules of KITTI, percent. The ceiling is what a perfect detector would reach \
         with this number of objects.",
        "Class|Difficulty|#IoU above|#Objects|#AP40 clean|#AP40 damaged|#Ceiling|#AP11 clean|#AP11 damaged|#Ceiling",
    );
    for clean in &of_clean.kitti {
        let cracked = evaluation
            .cracked
            .kitti
            .iter()
            .find(|row| row.class == clean.class && row.difficulty == clean.difficulty);
        let mut cells = vec![
            Cell::head(&clean.class),
            Cell::text(&clean.difficulty),
            Cell::number(Some(clean.min_overlap), |v| words::decimal(v, 2)),
            Cell::count(clean.n_objects),
            table.estimate(&clean.ap40, words::percent),
        ];
        cells.push(match cracked {
            Some(row) => table.estimate(&row.ap40, words::percent),
            None => Cell::nothing(),
        });
        cells.push(Cell::number(Some(clean.ceiling_ap40), words::percent));
        cells.push(table.estimate(&clean.ap11, words::percent));
        cells.push(match cracked {
            Some(row) => table.estimate(&row.ap11, words::percent),
            None => Cell::nothing(),
        });
        cells.push(Cell::number(Some(clean.ceiling_ap11), words::percent));
        table.push(cells);
    }
    Some(table)
}
