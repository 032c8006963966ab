//! Interactions with linearly dependent constraints, whose forces would be arbitrary or whose equations singular.

use super::definitions::Model;
use super::error::ModelError;
use super::interactions::{BodyBoundary, Enforcement, Interaction, Partner};

impl Model {
    /// Checks that no two contacts with multipliers, and no contact and tie, have facets of both sides in common.
    pub(super) fn check_repeated(&self) -> Result<(), ModelError> {
        let exact: Vec<&Interaction> = self.interactions.iter().filter(|one| one.is_exact()).collect();
        for (index, second) in exact.iter().enumerate() {
            for first in exact[..index].iter().filter(|first| repeats(first, second)) {
                let boundary = |contact: &Interaction| self.boundary_name(&contact.secondary);
                return Err(match (first.is_tie(), second.is_tie()) {
                    // Repeated ties of the same nodes are consistent; redundant constraints are removed.
                    (true, true) => continue,
                    (true, false) => {
                        ModelError::TiedContact { contact: second.name.clone(), tie: first.name.clone(), boundary: boundary(second) }
                    }
                    (false, true) => {
                        ModelError::TiedContact { contact: first.name.clone(), tie: second.name.clone(), boundary: boundary(first) }
                    }
                    (false, false) => {
                        ModelError::RepeatedContact { first: first.name.clone(), second: second.name.clone(), boundary: boundary(second) }
                    }
                });
            }
        }
        Ok(())
    }
}

impl Interaction {
    /// True if multipliers satisfy the constraints of the interaction exactly.
    fn is_exact(&self) -> bool {
        self.is_tie() || self.enforcement == Enforcement::Multiplier
    }
}

/// True if two boundaries have a facet in common.
fn shares(a: &BodyBoundary, b: &BodyBoundary) -> bool {
    a.body == b.body && a.boundary.facets.iter().any(|facet| b.boundary.facets.contains(facet))
}

/// True if both interactions are between equal facets.
fn repeats(first: &Interaction, second: &Interaction) -> bool {
    let is_opposite = |on: &BodyBoundary, of: &Interaction| of.primary().iter().any(|other| shares(on, other));
    let along = || shares(&first.secondary, &second.secondary) && first.primary().iter().any(|on| is_opposite(on, second));
    let across = || is_opposite(&first.secondary, second) && is_opposite(&second.secondary, first);
    match (&first.partner, &second.partner) {
        (Partner::Obstacle { shape: one, .. }, Partner::Obstacle { shape: other, .. }) => {
            one == other && shares(&first.secondary, &second.secondary)
        }
        (Partner::Obstacle { .. }, _) | (_, Partner::Obstacle { .. }) => false,
        (Partner::Tied { .. }, _) | (_, Partner::Tied { .. }) => along() || across(),
        _ => along(),
    }
}
