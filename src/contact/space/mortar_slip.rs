//! Slip of mortar contact in space, with the weights of the gap.

use super::mortar::MortarInSpace;
use super::pair::Pair;
use super::slip::{Group, SlipGroups, groups_of};
use super::vectors::{FacetFrame, Vec3, jets};
use super::vertices::OfNodes;

/// Slip with the weights of the gap: multiplier shape functions times shape functions of the opposite facet, over the overlap.
impl SlipGroups for MortarInSpace {
    fn groups(&self, p: usize, z: &[Vec3<f64>]) -> Vec<Group<f64>> {
        let Some(pair) = Pair::at(z, self.counts(p)).filter(Pair::overlaps) else { return Vec::new() };
        let shape = self.shape(p);
        groups_of(&shape.of_lists(pair.mortar_weights()), shape.of(pair.covered()), pair.axes(), self.turns(p))
    }

    fn differentiated(&self, p: usize, z: &[Vec3<f64>]) -> Vec<Group<OfNodes>> {
        let counts = self.counts(p);
        let Some(pair) = Pair::at(z, counts).filter(Pair::overlaps) else { return Vec::new() };
        let positions: Vec<Vec3<OfNodes>> = jets(z.as_flattened(), 0);
        let Some(frame) = FacetFrame::new(&positions[..counts[0]]) else { return Vec::new() };
        // Weights have a kink where edges of both facets coincide. There the corners of the overlap move with what defines them:
        // derivatives by edges, which belong to either facet by round-off, made resting arches crawl
        // (`tests/scripts/rigid_friction_in_space.rhai`).
        let weights = match Pair::new(&positions, counts).filter(|_| pair.has_coinciding_edges()) {
            Some(clipped) => clipped.mortar_weights(),
            None => pair.differentiated_weights(),
        };
        let shape = self.shape(p);
        groups_of(&shape.of_lists(weights), shape.of(pair.covered()), frame.axes, self.turns(p))
    }
}
