//! AP of points that an oracle has put right.

use super::ErrorKind;
use super::classify::Classified;

/// What the oracle does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fix {
    Nothing,
    Kind(ErrorKind),
    FalsePositives,
    FalseNegatives,
}

/// The points of all curves.
pub(super) struct Points<'a> {
    found: &'a Classified,
    n_categories: usize,
}

impl<'a> Points<'a> {
    pub(super) fn new(found: &'a Classified, n_categories: usize) -> Self {
        Self {
            found,
            n_categories,
        }
    }

    /// Mean over categories with points or objects, 0 to 100.
    pub(super) fn mean_ap(&self, fix: Fix) -> Option<f64> {
        let mut points: Vec<Vec<(f64, bool)>> = vec![Vec::new(); self.n_categories];
        let mut n_objects = self.found.n_objects.clone();
        if fix == Fix::Nothing {
            for (category, score, is_right) in &self.found.points {
                points[*category as usize].push((*score, *is_right));
            }
        } else {
            // Errors before the rest: so tidecv has equal scores here, unlike above.
            self.push_errors(fix, &mut points, &mut n_objects);
            for (category, score, _) in self.found.points.iter().filter(|it| it.2) {
                points[*category as usize].push((*score, true));
            }
        }
        match fix {
            Fix::FalsePositives => {
                for (score, is_right) in points.iter_mut().flatten() {
                    *score = f64::from(u8::from(*is_right));
                }
            }
            Fix::FalseNegatives => {
                for (n, n_missed) in n_objects.iter_mut().zip(&self.found.n_missed) {
                    *n = n.saturating_sub(*n_missed);
                }
            }
            Fix::Nothing | Fix::Kind(_) => {}
        }
        let (mut sum, mut n) = (0.0, 0_u32);
        for (points, n_objects) in points.iter_mut().zip(&n_objects) {
            if *n_objects > 0 || !points.is_empty() {
                sum += average_precision(points, *n_objects);
                n += 1;
            }
        }
        (n > 0).then(|| sum / f64::from(n))
    }

    fn push_errors(&self, fix: Fix, points: &mut [Vec<(f64, bool)>], n_objects: &mut [u64]) {
        for error in &self.found.errors {
            let (point, is_right) = if fix == Fix::Kind(error.kind) {
                if let Some(category) = error.missed {
                    n_objects[category as usize] = n_objects[category as usize].saturating_sub(1);
                }
                (error.fixed, true)
            } else {
                (error.as_is, false)
            };
            if let Some((category, score)) = point {
                points[category as usize].push((score, is_right));
            }
        }
    }
}

/// Mean over 101 recalls k/100 of the greatest precision from there on, 0 to 100.
fn average_precision(points: &mut [(f64, bool)], n_objects: u64) -> f64 {
    if n_objects == 0 {
        return 0.0;
    }
    points.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (mut n_true, mut precisions, mut recalls) = (0_u64, Vec::new(), Vec::new());
    for (place, (_, is_right)) in points.iter().enumerate() {
        n_true += u64::from(*is_right);
        precisions.push(n_true as f64 / (place + 1) as f64);
        recalls.push(n_true as f64 / n_objects as f64);
    }
    let mut greatest = 0.0_f64;
    for precision in precisions.iter_mut().rev() {
        greatest = greatest.max(*precision);
        *precision = greatest;
    }
    let at = |k: u32| {
        let recall = f64::from(k) / 100.0;
        let place = recalls.partition_point(|it| *it < recall);
        precisions.get(place).copied().unwrap_or(0.0)
    };
    (0..=100).map(at).sum::<f64>() / 101.0 * 100.0
}
