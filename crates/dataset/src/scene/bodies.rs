//! The forms of car and van bodies.
//!
//! What comes out is, for each body, its outline as tables over the height
//! above the road, from which every drawn panel takes its place.

/// The form of a body; heights in metres, tables sorted by rising height.
pub(super) struct Build {
    pub(super) length_m: f32,
    pub(super) width_m: f32,
    /// (height, distance from the rear end) along the rear outline.
    pub(super) rear: &'static [[f32; 2]],
    /// (height, distance from the front end) along the front outline.
    pub(super) front: &'static [[f32; 2]],
    /// (height, share of the half width) up the flanks.
    pub(super) flank: &'static [[f32; 2]],
    /// Lower edge of the windows.
    pub(super) belt_m: f32,
    pub(super) glass_top_m: f32,
    pub(super) roof_m: f32,
    /// Upper front edge of the hood.
    pub(super) hood_m: f32,
    /// Side windows as (distance from the rear, height, rounding).
    pub(super) side_glass: &'static [&'static [[f32; 3]]],
    /// Door gaps, in metres from the rear.
    pub(super) doors_m: &'static [f32],
    pub(super) rear_axle_m: f32,
    pub(super) front_axle_m: f32,
    pub(super) wheel_radius_m: f32,
}

/// A compact car with a steep tailgate.
pub(super) const HATCHBACK: Build = Build {
    length_m: 4.1,
    width_m: 1.80,
    rear: &[
        [0.24, 0.08],
        [0.50, 0.0],
        [0.92, 0.05],
        [1.02, 0.14],
        [1.40, 0.48],
        [1.48, 0.95],
    ],
    front: &[
        [0.20, 0.14],
        [0.36, 0.0],
        [0.62, 0.05],
        [0.80, 0.28],
        [0.98, 1.10],
        [1.40, 1.95],
        [1.48, 2.6],
    ],
    flank: &[
        [0.2, 0.93],
        [0.5, 0.99],
        [0.75, 1.0],
        [0.96, 0.95],
        [1.40, 0.72],
        [1.48, 0.62],
    ],
    belt_m: 0.99,
    glass_top_m: 1.38,
    roof_m: 1.48,
    hood_m: 0.80,
    side_glass: &[
        &[
            [0.50, 1.02, 0.05],
            [0.72, 1.37, 0.06],
            [1.46, 1.41, 0.02],
            [1.46, 1.00, 0.02],
        ],
        &[
            [1.53, 1.00, 0.02],
            [1.53, 1.41, 0.02],
            [2.05, 1.38, 0.08],
            [2.85, 0.99, 0.05],
        ],
    ],
    doors_m: &[1.42, 2.62],
    rear_axle_m: 0.72,
    front_axle_m: 3.28,
    wheel_radius_m: 0.32,
};

/// A longer car with a trunk lid.
pub(super) const SEDAN: Build = Build {
    length_m: 4.6,
    width_m: 1.82,
    rear: &[
        [0.24, 0.08],
        [0.48, 0.0],
        [0.90, 0.06],
        [0.99, 0.45],
        [1.36, 1.20],
        [1.44, 1.8],
    ],
    front: &[
        [0.20, 0.14],
        [0.36, 0.0],
        [0.60, 0.05],
        [0.76, 0.28],
        [0.95, 1.35],
        [1.36, 2.15],
        [1.44, 2.7],
    ],
    flank: &[
        [0.2, 0.93],
        [0.5, 0.99],
        [0.75, 1.0],
        [0.94, 0.95],
        [1.36, 0.71],
        [1.44, 0.60],
    ],
    belt_m: 0.96,
    glass_top_m: 1.34,
    roof_m: 1.44,
    hood_m: 0.76,
    side_glass: &[
        &[
            [0.80, 0.98, 0.05],
            [1.32, 1.33, 0.08],
            [2.02, 1.37, 0.02],
            [2.02, 0.97, 0.02],
        ],
        &[
            [2.09, 0.97, 0.02],
            [2.09, 1.37, 0.02],
            [2.48, 1.34, 0.08],
            [3.15, 0.96, 0.05],
        ],
    ],
    doors_m: &[1.12, 2.05, 3.0],
    rear_axle_m: 0.95,
    front_axle_m: 3.72,
    wheel_radius_m: 0.33,
};

/// A high delivery van.
pub(super) const VAN: Build = Build {
    length_m: 5.3,
    width_m: 1.98,
    rear: &[[0.30, 0.05], [0.55, 0.0], [2.20, 0.05], [2.38, 0.20]],
    front: &[
        [0.24, 0.12],
        [0.42, 0.0],
        [0.95, 0.06],
        [1.12, 0.25],
        [1.32, 0.85],
        [2.10, 1.50],
        [2.38, 2.05],
    ],
    flank: &[
        [0.24, 0.95],
        [0.6, 1.0],
        [1.3, 0.98],
        [2.10, 0.90],
        [2.38, 0.80],
    ],
    belt_m: 1.30,
    glass_top_m: 2.06,
    roof_m: 2.38,
    hood_m: 1.10,
    side_glass: &[&[
        [3.40, 1.32, 0.04],
        [3.40, 1.98, 0.08],
        [3.86, 1.98, 0.08],
        [4.42, 1.32, 0.06],
    ]],
    doors_m: &[1.75, 3.30, 4.30],
    rear_axle_m: 0.95,
    front_axle_m: 4.35,
    wheel_radius_m: 0.36,
};

/// Reads a table of (height, value), straight between its rows.
pub(super) fn look_up(table: &[[f32; 2]], up_m: f32) -> f32 {
    let mut before = table[0];
    for &row in table {
        if up_m <= row[0] {
            let span_m = (row[0] - before[0]).max(1e-6);
            let share = ((up_m - before[0]) / span_m).clamp(0.0, 1.0);
            return before[1] + (row[1] - before[1]) * share;
        }
        before = row;
    }
    before[1]
}
