//! Hints on contact options for steps that did not converge.

use super::handle::SimulationHandle;
use crate::contact::{Obstacle, ObstacleInSpace};
use crate::dynamics::{Enforcement, Interaction, Partner};
use crate::script::language::digits::brief;

/// Penalty factor above which the tangent is ill-conditioned; 10 to 1000 are usual.
const STIFF: f64 = 1e5;

/// Radius of the edges of a cylinder with ends, relative to the width of the facets, below which Newton's method may not follow the motion
/// of a contact point round the edge: of 12 punches on blocks 7 fail with 0.01, 2 with 0.1, none with 0.3.
const SHARP: f64 = 0.15;

/// Suggested radius of the edges, relative to the width of the facets.
const ROUNDED: f64 = 0.3;

impl SimulationHandle {
    /// Hint for a failed step whose contacts have an option that makes convergence unlikely.
    pub(super) fn contact_hint(&self) -> Option<String> {
        let model = &self.0.model.model;
        let width = |contact: &Interaction| {
            let (mesh, boundary) = (&model.bodies[contact.secondary.body].mesh, &contact.secondary.boundary);
            (mesh.boundary_measure(boundary) / boundary.facets.len().max(1) as f64).sqrt()
        };
        let told = |length: f64| self.0.told(brief(length), "length");
        model.interactions.iter().find_map(|contact| {
            let name = &contact.name;
            if let Enforcement::Penalty { factor } = contact.enforcement
                && factor > STIFF
            {
                return Some(format!("the penalty {} of contact \"{name}\" is too stiff: take 10 to 1000, or leave it out", brief(factor)));
            }
            let Partner::Obstacle { shape: Obstacle::InSpace(shape), .. } = &contact.partner else { return None };
            let ObstacleInSpace::FiniteCylinder { edge, .. } = *shape else { return None };
            let width = width(contact);
            (edge < SHARP * width).then(|| {
                format!(
                    "the edges of the cylinder of contact \"{name}\" are sharp, rounded by {}, between facets of {}: take finer facets, or \
                     `edge_radius: {}`",
                    told(edge),
                    told(width),
                    brief(ROUNDED * width)
                )
            })
        })
    }
}
