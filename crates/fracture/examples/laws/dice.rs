//! V10, V11: number and areas of dice.

use starbreak_fracture::dice::{count_law_empirical, count_law_energy, dice_cascade, dice_cells};
use starbreak_seed::Seed;

use crate::areas::{faces, gamma_cdf, kolmogorov_smirnov, window_counts};
use crate::measures::network::mean;
use crate::measures::panes::rectangle;
use crate::table::{Row, Rows};

/// Panes of V10.
const N_PANES: u32 = 500;

pub(crate) fn rows() -> Rows {
    let mut rows = counts()?;
    rows.extend(areas()?);
    Ok(rows)
}

fn counts() -> Rows {
    let side = 0.34;
    let mut n_off = 0;
    let (mut worst, mut least_safe): (f64, f64) = (1.0, f64::INFINITY);
    for k in 0..N_PANES {
        let share = f64::from(k) / f64::from(N_PANES);
        let pa = 60e6 + 100e6 * share;
        let thickness = 4e-3 + 8e-3 * (share * 7.3).fract();
        let hit = [0.1 + 0.1 * (share * 13.7).fract(), 0.1];
        let seed = Seed(k.into());
        let diced = dice_cells(&rectangle(side, side), thickness, pa, &[hit], seed)?;
        let count = mean(window_counts(&diced, side, hit));
        let laws = [count_law_energy(pa), count_law_empirical(pa, thickness)];
        let (low, high) = (laws[0].min(laws[1]), laws[0].max(laws[1]));
        // Outside of the two laws by this factor.
        let off = (low / count).max(count / high).max(1.0);
        n_off += u32::from(off > 1.1);
        worst = worst.max(off);
        if pa >= 90e6 {
            least_safe = least_safe.min(count);
        }
    }
    let (mut n_safe, mut n) = (0.0, 0.0);
    for k in 0..200_u32 {
        let thickness = [4e-3, 6e-3, 8e-3, 12e-3][k as usize % 4];
        let hit = [0.17, 0.17];
        let seed = Seed(u64::from(k / 4));
        let diced = dice_cells(&rectangle(side, side), thickness, 100e6, &[hit], seed)?;
        for count in window_counts(&diced, side, hit) {
            n_safe += f64::from(u8::from(count >= 40.0));
            n += 1.0;
        }
    }
    Ok(vec![
        Row::judged(
            "V10 mean of N50 of 500 panes, 60-160 MPa, 4-12 mm",
            "between the two laws",
            format!("{n_off} panes off, outside by a factor of {worst:.3} at most"),
            "factor 1.1",
            "Pourmoghaddam2018",
            n_off == 0,
        ),
        Row::judged(
            "V10 least mean of N50 from 90 MPa on",
            "at least 40",
            format!("{least_safe:.1}"),
            "bound",
            "EN 12150",
            least_safe >= 40.0,
        ),
        Row::judged(
            "V10 windows of 50 mm with at least 40 dice, 200 panes, 100 MPa",
            "at least 99 %",
            format!("{:.2} % of {n}", 100.0 * n_safe / n),
            "bound",
            "EN 12150",
            n_safe >= 0.99 * n,
        ),
    ])
}

fn areas() -> Rows {
    let side = 0.5;
    let diced = dice_cells(&rectangle(side, side), 4e-3, 110e6, &[[0.0, 0.0]], Seed(8))?;
    let inner = |diced: &_, margin: f64, side: f64| -> Vec<f64> {
        faces(diced)
            .into_iter()
            .filter(|(_, at)| at.iter().all(|c| (margin..side - margin).contains(c)))
            .map(|(area, _)| area)
            .collect()
    };
    let cells = inner(&diced, 0.05, side);
    let middle = mean(cells.iter().copied());
    let variance = mean(cells.iter().map(|area| (area / middle - 1.0).powi(2)));
    let shape = 1.0 / variance;
    let n = cells.len();
    let gamma = kolmogorov_smirnov(cells, |x| gamma_cdf(shape, shape * x));
    let mut worst: f64 = 0.0;
    for (pa, seed) in [(70e6, 8), (100e6, 1), (140e6, 2), (100e6, 3), (120e6, 4)] {
        let side = 0.3;
        let diced = dice_cascade(&rectangle(side, side), pa, &[[0.15, 0.14]], Seed(seed))?;
        let distance = kolmogorov_smirnov(inner(&diced, 0.03, side), |x| 1.0 - libm::exp(-x));
        worst = worst.max(distance);
    }
    Ok(vec![
        Row::judged(
            "V11 areas of cells",
            "gamma distribution",
            format!("KS {gamma:.3} with shape {shape:.1}, {n} dice"),
            "KS 0.05",
            "statistics of hard-core cells",
            gamma <= 0.05,
        ),
        Row::judged(
            "V11 areas of a cascade, worst of 5 panes",
            "exponential distribution",
            format!("KS {worst:.3}"),
            "KS 0.08",
            "Dawara2026",
            worst <= 0.08,
        ),
    ])
}
