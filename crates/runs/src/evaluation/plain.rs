//! Numbers of whole images, as plain values and as arrays.

use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};
use starbreak_dataset::encode_array_f64;
use starbreak_eval::{
    CocoEvaluation, CompareParams, CoverageOf, Coverages, Evaluated, GroundTruth, KittiCurve,
    SaidDetections, Subset, subset_curves,
};

use super::not_json;
use crate::Error;

/// What a protocol says of one set, with the numbers of MS-COCO as pycocotools has them.
pub(super) fn side(evaluated: &Evaluated, said: &SaidDetections) -> Result<Value, Error> {
    let mut value = serde_json::to_value(&evaluated.results).map_err(not_json)?;
    let Value::Object(members) = &mut value else {
        return Ok(value);
    };
    if let Some(stats) = evaluated.coco.as_ref().and_then(CocoEvaluation::stats) {
        members.insert("coco_stats".to_owned(), json!(stats));
    }
    if !evaluated.kitti.is_empty() {
        members.insert("kitti".to_owned(), kitti(&evaluated.kitti));
    }
    let n_unused = said.unused.as_ref().map_or(0, |unused| unused.n_detections);
    members.insert(
        "n_detections_of_unknown_categories".to_owned(),
        json!(n_unused),
    );
    Ok(value)
}

/// Curves of KITTI by class and difficulty; average precisions in percent, as the benchmark has
/// them.
fn kitti(curves: &[KittiCurve]) -> Value {
    let mut classes = Map::new();
    for curve in curves {
        let class = classes
            .entry(curve.class.name())
            .or_insert_with(|| Value::Object(Map::new()));
        let [ceiling_ap11, ceiling_ap40] = KittiCurve::ceiling(curve.n_gt);
        if let Value::Object(class) = class {
            let of_difficulty = json!({
                "n_gt": curve.n_gt,
                "ap11": curve.ap11(),
                "ap40": curve.ap40(),
                "ceiling_ap11": ceiling_ap11,
                "ceiling_ap40": ceiling_ap40,
                "min_overlap": curve.class.min_overlap(),
                "precision": curve.precision.to_vec(),
                "recall": curve.recall(),
                "thresholds": curve.thresholds,
                "counts": curve.counts,
            });
            class.insert(curve.difficulty.name().to_owned(), of_difficulty);
        }
    }
    Value::Object(classes)
}

/// Files of the curves of one set, in a folder of this name.
pub(super) fn curve_files(
    folder: &Path,
    truth: &GroundTruth,
    said: &SaidDetections,
    evaluated: &Evaluated,
    coverages: Option<(&Coverages, usize)>,
    params: &CompareParams,
) -> Result<Vec<(PathBuf, Vec<u8>)>, Error> {
    let Some(coco) = &evaluated.coco else {
        let mut text = kitti(&evaluated.kitti).to_string();
        text.push('\n');
        return Ok(vec![(folder.join("kitti.json"), text.into_bytes())]);
    };
    let mut files = arrays(folder, coco)?;
    let Some((coverages, idx)) = coverages else {
        return Ok(files);
    };
    let coverage = CoverageOf {
        objects: &coverages.objects,
        detections: coverages.detections.get(idx).map_or(&[], Vec::as_slice),
    };
    let most = params.coco.max_detections.last().copied().unwrap_or(100);
    for tau in &params.taus {
        let subset = Subset::InRegion { tau: *tau };
        let curves = subset_curves(&truth.labels, &said.detections, coverage, &subset, most)?;
        files.extend(arrays(&folder.join(format!("region_tau_{tau}")), &curves)?);
    }
    Ok(files)
}

fn arrays(folder: &Path, coco: &CocoEvaluation) -> Result<Vec<(PathBuf, Vec<u8>)>, Error> {
    let [t, r, k, a, m] = coco.shape();
    let each = [
        ("precision", vec![t, r, k, a, m], &coco.precision),
        ("recall", vec![t, k, a, m], &coco.recall),
        ("scores", vec![t, r, k, a, m], &coco.scores),
    ];
    let file = |(name, shape, values): (&str, Vec<usize>, &Vec<f64>)| {
        let array = encode_array_f64(&shape, values)?;
        Ok((folder.join(format!("{name}.npy")), array))
    };
    each.into_iter().map(file).collect()
}
