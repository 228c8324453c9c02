/// p values corrected for their number by Holm's method, in their order \[Holm1979\]; what has no p
/// is not counted and stays without.
///
/// The i-th smallest of m becomes max over j ≤ i of min(1, (m − j + 1) p₍ⱼ₎).
///
/// # Example
/// ```
/// let corrected = starbreak_eval::statistic::holm(&[Some(0.04), None, Some(0.01)]);
/// assert_eq!(corrected, [Some(0.04), None, Some(0.02)]);
/// ```
#[must_use]
pub fn holm(p: &[Option<f64>]) -> Vec<Option<f64>> {
    let mut order: Vec<(usize, f64)> = p
        .iter()
        .enumerate()
        .filter_map(|(place, p)| p.filter(|p| p.is_finite()).map(|p| (place, p)))
        .collect();
    order.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut corrected = vec![None; p.len()];
    let mut least = 0.0_f64;
    for (rank, (place, p)) in order.iter().enumerate() {
        let n_left = (order.len() - rank) as f64;
        least = least.max((p * n_left).min(1.0));
        if let Some(slot) = corrected.get_mut(*place) {
            *slot = Some(least);
        }
    }
    corrected
}
