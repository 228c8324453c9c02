use starbreak_fracture::paper::*;
use starbreak_glass::*;
use std::time::Instant;
fn main() {
    let pane = Pane::from_frame_px(1242, 375);
    for (n, scaled) in [
        (1000u32, true),
        (10_000, true),
        (20_000, false),
        (50_000, true),
        (50_000, false),
        (100_000, true),
        (1_000_000, true),
    ] {
        let params = PaperParams {
            particles: n,
            neighbor_radius: if scaled {
                PaperParams::mesh_scaled_radius(n)
            } else {
                65.0
            },
            ..Default::default()
        };
        let runs = if n > 100_000 { 2 } else { 10 };
        let mut all = vec![];
        let mut last = None;
        for seed in 0..runs {
            let t = Instant::now();
            let mut at = vec![];
            let r = simulate(
                &pane,
                &[PaperImpact::default()],
                &params,
                Seed(seed),
                |_| at.push(t.elapsed().as_secs_f64() * 1e3),
            );
            let Ok(f) = r else {
                println!("{n} seed {seed}: {}", r.unwrap_err());
                continue;
            };
            let st: Vec<f64> = at
                .iter()
                .enumerate()
                .map(|(k, v)| v - if k > 0 { at[k - 1] } else { 0.0 })
                .collect();
            all.push(st);
            last = Some(f);
        }
        let med = |k: usize| {
            let mut v: Vec<f64> = all.iter().map(|s| s[k]).collect();
            v.sort_by(f64::total_cmp);
            v[v.len() / 2]
        };
        let Some(f) = last else { continue };
        println!(
            "{n} scaled {scaled}: mesh {:.2} prop {:.2} mst {:.2} net {:.2} | segs {} fronts {} stressed {} steps {} radial {} {:?}",
            med(0),
            med(1),
            med(2),
            med(3),
            f.network.n_segments(),
            f.convergence.n_fronts,
            f.n_stressed_nodes,
            f.convergence.n_steps(),
            f.network.summary().n_radial,
            f.network.check_invariants().map_err(|e| e.to_string())
        );
    }
}
