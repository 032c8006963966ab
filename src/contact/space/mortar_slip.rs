//! Slip of mortar contact in space, with the weights of the gap.

use super::mortar::MortarInSpace;
use super::pair::Pair;
use super::slip::{Group, SlipGroups, groups_of};
use super::vectors::{FacetFrame, Vec3, jets};
use super::vertices::{OfNodes, UNKNOWNS};

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
        let Some(frame) = FacetFrame::new(&jets::<UNKNOWNS>(z[..counts[0]].as_flattened(), 0)) else { return Vec::new() };
        let weights = pair.differentiated_weights();
        let shape = self.shape(p);
        groups_of(&shape.of_lists(weights), shape.of(pair.covered()), frame.axes, self.turns(p))
    }
}
