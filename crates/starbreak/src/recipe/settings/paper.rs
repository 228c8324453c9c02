//! Settings of the paper's model.

use starbreak_fracture::paper::{Neighborhood, PaperImpact, PaperParams, Position, Rule};
use starbreak_glass::Pane;

use super::super::error::{Place, RecipeError};
use super::super::tables::{NeighborhoodWord, PaperFractureTables, PaperImpactTable, RuleWord};
use super::{Mount, direction, impacts, is_aimed, position};

/// What the paper's model needs to know.
#[derive(Debug, Clone, PartialEq)]
pub struct PaperSettings {
    /// Parameters of the model.
    pub params: PaperParams,
    /// How the pane stands before the camera, for the physical optics; the paper's own optics
    /// have no glass.
    pub mount: Option<Mount>,
    /// Impacts on a pane of one by one.
    unit_impacts: Vec<PaperImpact>,
    /// Which of them are to be before a labeled object.
    pub(super) aimed: Vec<bool>,
}

impl PaperSettings {
    /// The impacts on a given pane.
    #[must_use]
    pub fn impacts_on(&self, pane: &Pane) -> Vec<PaperImpact> {
        let on_pane = |impact: &PaperImpact| match impact.position {
            Position::Random { .. } => *impact,
            Position::At { x, y } => PaperImpact {
                position: Position::At {
                    x: x * pane.width,
                    y: y * pane.height,
                },
                ..*impact
            },
        };
        self.unit_impacts.iter().map(on_pane).collect()
    }

    /// Puts impacts before the objects that are drawn for them.
    pub(super) fn aim(&mut self, drawn: impl Fn(u64) -> Option<Position>) {
        let impacts = self.unit_impacts.iter_mut().zip(&mut self.aimed);
        for (k, (impact, is_aimed)) in (0..).zip(impacts) {
            if std::mem::take(is_aimed) {
                impact.position = drawn(k).unwrap_or(impact.position);
            }
        }
    }
}

pub(super) fn settings(
    place: &Place,
    recipe: &PaperFractureTables,
    mount: Option<Mount>,
) -> Result<PaperSettings, RecipeError> {
    let given = &recipe.fracture;
    let params = PaperParams {
        particles: given.particles,
        neighbor_radius: given.neighbour_radius_px,
        neighborhood: match given.neighbourhood {
            NeighborhoodWord::Radius => Neighborhood::Radius,
            NeighborhoodWord::MeshEdges => Neighborhood::MeshEdges,
        },
        critical_stress: given.critical_stress,
        safety_factor: given.safety_factor,
        rule: match given.rule {
            RuleWord::Algorithm1 => Rule::Algorithm1,
            RuleWord::Caption => Rule::Caption,
            RuleWord::Literal => Rule::Literal,
        },
        branches: given.branches,
        two_sided: given.two_sided,
        snap_to_mesh: given.snap_to_mesh,
    };
    params
        .check()
        .map_err(|error| RecipeError::of_model(place, "fracture", error))?;
    let unit_impacts = impacts(place, &recipe.impact, |k, impact| {
        unit_impact(place, k, impact)
    })?;
    Ok(PaperSettings {
        params,
        mount,
        unit_impacts,
        aimed: (recipe.impact.iter())
            .map(|impact| is_aimed(impact.position))
            .collect(),
    })
}

fn unit_impact(
    place: &Place,
    k: usize,
    impact: &PaperImpactTable,
) -> Result<PaperImpact, RecipeError> {
    let resolved = PaperImpact {
        position: position(impact.position),
        force: impact.force,
        direction: direction(impact.direction_deg),
    };
    let unit_pane = Pane {
        width: 1.0,
        height: 1.0,
        thickness_mm: None,
        kind: None,
    };
    resolved
        .check(&unit_pane)
        .map_err(|error| RecipeError::of_model(place, &format!("impact.{k}"), error))?;
    Ok(resolved)
}
