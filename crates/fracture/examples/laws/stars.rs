//! Stars of laminates: how far the legs come, against the tip's law on a plate in closed form.

use std::error::Error;

use starbreak_fracture::physics::{
    GlassPane, MeshResolution, PhysicsParams, StoneImpact, simulate,
};
use starbreak_seed::Seed;

use crate::measures::network::{leg_reach_m, mean};
use crate::measures::panes::windscreen;
use crate::measures::star::{StarLaw, arrest_m};
use crate::table::{Row, Rows};

/// Seeds of each star.
const N_STARS: u64 = 40;

fn fast() -> PhysicsParams {
    PhysicsParams {
        mesh: MeshResolution::Fast,
        ..PhysicsParams::default()
    }
}

/// Stars on an elastic foundation: its length, and how far they come.
pub(crate) fn rows() -> Rows {
    let mut rows = Vec::new();
    let moduli = [30e6, 300e6, 1e9];
    for (modulus_pa, expected_mm) in moduli.into_iter().zip([4.9, 2.7, 2.0]) {
        let length_m = windscreen(modulus_pa)?
            .foundation_length_m()
            .unwrap_or_default();
        rows.push(Row::judged(
            &format!(
                "laminate, {:.0} MPa: length of the foundation",
                modulus_pa * 1e-6
            ),
            &format!("{expected_mm} mm"),
            format!("{:.2} mm", 1e3 * length_m),
            "± 0.05 mm",
            "(D/k)^¼",
            (1e3 * length_m - expected_mm).abs() <= 0.05 + 1e-9,
        ));
    }
    for (radius_m, speed_m_s, of_design_mm) in [
        (3e-3, 25.0, [9.2, 4.6, 3.1]),
        (5e-3, 30.0, [11.4, 5.9, 4.2]),
    ] {
        let stone = StoneImpact::granite([0.7, 0.4], speed_m_s, radius_m);
        let hit = format!("{:.0} mm, {speed_m_s} m/s", 1e3 * radius_m);
        let mut all = Vec::new();
        for (modulus_pa, design_mm) in moduli.into_iter().zip(of_design_mm) {
            let stars = Stars::of(&windscreen(modulus_pa)?, &stone)?;
            rows.extend(stars.rows(&hit, modulus_pa, design_mm));
            all.push(stars);
        }
        let [softest, _, stiffest] = all.as_slice() else {
            continue;
        };
        let expected = softest.equal_mm / stiffest.equal_mm;
        let got = softest.legs_mm / stiffest.legs_mm;
        let got_far = softest.farthest_mm / stiffest.farthest_mm;
        rows.push(Row::judged(
            &format!("laminate: lengths of legs, 30 MPa over 1000 MPa, {hit}"),
            &format!("{expected:.2}"),
            format!("{got:.2}; farthest {got_far:.2}"),
            &percent(SCALING_TOLERANCE),
            "K = K_IC of equal legs; ℓ alone: 2.40",
            (got / expected - 1.0).abs() <= SCALING_TOLERANCE
                && (got_far / expected - 1.0).abs() <= SCALING_TOLERANCE,
        ));
    }
    Ok(rows)
}

/// Legs of stars differ by a factor of two, and their mean is that of no one length.
const LEGS_TOLERANCE: f64 = 0.15;

/// What competition takes from legs depends on how many of them there are, and so on ℓ.
const SCALING_TOLERANCE: f64 = 0.15;

fn percent(part: f64) -> String {
    format!("± {:.0} %", 100.0 * part)
}

/// What 40 stars are like, and what is expected of them.
struct Stars {
    legs_mm: f64,
    farthest_mm: f64,
    n_legs: f64,
    n_stars: usize,
    /// As many legs of one length.
    equal_mm: f64,
    /// One leg.
    lone_mm: f64,
    /// The law of the design, of as many legs.
    uncalibrated_mm: f64,
}

impl Stars {
    fn of(screen: &GlassPane, stone: &StoneImpact) -> Result<Self, Box<dyn Error>> {
        let (mut means, mut farthest, mut legs) = (Vec::new(), Vec::new(), Vec::new());
        for seed in 0..N_STARS {
            let broken = simulate(screen, &[*stone], None, &fast(), Seed(seed), |_| ())?;
            if let Some([middle, far]) = leg_reach_m(&broken.network) {
                means.push(1e3 * middle);
                farthest.push(1e3 * far);
                legs.push(f64::from(u16::try_from(broken.impacts[0].n_legs)?));
            }
        }
        let n_legs = mean(legs);
        let arrest_mm = |n, law| 1e3 * arrest_m(screen, stone, n, law).unwrap_or_default();
        Ok(Self {
            n_stars: means.len(),
            legs_mm: mean(means),
            farthest_mm: mean(farthest),
            n_legs,
            equal_mm: arrest_mm(n_legs, StarLaw::Calibrated),
            lone_mm: arrest_mm(1.0, StarLaw::Calibrated),
            uncalibrated_mm: arrest_mm(n_legs, StarLaw::Design),
        })
    }

    fn rows(&self, hit: &str, modulus_pa: f64, design_mm: f64) -> [Row; 3] {
        let Self {
            legs_mm,
            farthest_mm,
            n_legs,
            n_stars,
            equal_mm,
            lone_mm,
            uncalibrated_mm,
        } = self;
        let name = |what| format!("laminate, {:.0} MPa: {what}, {hit}", modulus_pa * 1e-6);
        let ratio = legs_mm / equal_mm;
        [
            Row::judged(
                &name("mean length of legs"),
                &format!("{equal_mm:.1} mm"),
                format!("{legs_mm:.1} mm, {ratio:.2} of it; {n_stars} stars of {n_legs:.1} legs"),
                &percent(LEGS_TOLERANCE),
                "K = K_IC of equal legs, on kei(r/ℓ)",
                (ratio - 1.0).abs() <= LEGS_TOLERANCE,
            ),
            Row::judged(
                &name("farthest leg"),
                &format!("{equal_mm:.1} mm to {lone_mm:.1} mm"),
                format!(
                    "{farthest_mm:.1} mm, {:.2} and {:.2} of them",
                    farthest_mm / equal_mm,
                    farthest_mm / lone_mm
                ),
                "bounds",
                "equal legs, lone leg",
                (equal_mm..=lone_mm).contains(&farthest_mm),
            ),
            Row::report(
                &name("farthest leg, of the design"),
                &format!("{design_mm} mm"),
                format!(
                    "{:.2} of it; its K was not calibrated: {uncalibrated_mm:.1} mm for so many legs",
                    farthest_mm / design_mm
                ),
                "closed form of the design, of about 6 legs",
            ),
        ]
    }
}
