//! What the glass and the surfaces of its cracks are like.

/// The glass before the lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Glass {
    /// Thickness of the ply that was hit, or of the only sheet, mm, 0.05 to 100. **Default**: 2.1,
    /// the outer ply of a windscreen.
    pub thickness_mm: f64,
    /// Laminates: thickness of the interlayer that is bonded to it on the camera's side, mm, 0 to
    /// 100. **Default**: 0.
    pub interlayer_mm: f64,
    /// Laminates: thickness of the ply beyond the interlayer, mm, 0 to 100. **Default**: 0.
    pub inner_ply_mm: f64,
    /// Refractive index, 1.3 to 2. **Default**: 1.52, soda-lime.
    pub refractive_index: f64,
    /// Share of the light that the rim of the pane sends back into it, 0 to 1. **Default**: 0, the
    /// black frit around a windscreen.
    pub rim_reflectance: f64,
    /// Mean way to the rim, mm, 0 to 10⁵. **Default**: 550, that of a windscreen.
    pub rim_way_mm: f64,
}

impl Default for Glass {
    fn default() -> Self {
        Self {
            thickness_mm: 2.1,
            interlayer_mm: 0.0,
            inner_ply_mm: 0.0,
            refractive_index: 1.52,
            rim_reflectance: 0.0,
            rim_way_mm: 550.0,
        }
    }
}

/// What the surfaces of cracks are like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceParams {
    /// GGX α of a mirror zone, 0 to 1, in place of that of its roughness: 0.13 R^0.55 of the RMS
    /// roughness R in µm, from 0.02 to 0.3 (FIT), or 0.02 where the network has none.
    pub mirror_alpha: Option<f64>,
    /// The same of a mist zone, or 0.08.
    pub mist_alpha: Option<f64>,
    /// The same of a hackle zone, or 0.3.
    pub hackle_alpha: Option<f64>,
    /// Opening of cracks of a network without that column, µm, 0 to 1000. **Default**: 10.
    pub opening_um: f64,
    /// Radius of the crushed glass over that of the pit (`Impact::pit_radius_mm`), 0 (none) to 10. **Default**: 1.
    pub crushed_zone: f64,
    /// Radius of the shell that chips off around the pit, over that of the pit, 0 to 10; up to 1 there is none. FIT.
    /// **Default**: 2.
    pub chip: f64,
    /// Mean slope of the flakes of the chipped surface, degrees, 0 to 60. FIT. **Default**: 12.
    pub chip_slope_deg: f64,
    /// Radius of the film of air that runs sideways under the pit (lateral cracks), over that of the pit, 0 to 10; up to
    /// 1 there is none. FIT. **Default**: 2.5.
    pub film: f64,
    /// Greatest thickness of that film, µm, 0 to 100. FIT. **Default**: 1.5.
    pub film_um: f64,
    /// Standard deviation of the wedge angle between the faces of a fragment, degrees, 0 to 10.
    /// **Default**: 0: the faces of a broken plate stay parallel.
    pub fragment_wedge_deg: f64,
}

impl Default for SurfaceParams {
    fn default() -> Self {
        Self {
            mirror_alpha: None,
            mist_alpha: None,
            hackle_alpha: None,
            opening_um: 10.0,
            crushed_zone: 1.0,
            chip: 2.0,
            chip_slope_deg: 12.0,
            film: 2.5,
            film_um: 1.5,
            fragment_wedge_deg: 0.0,
        }
    }
}
