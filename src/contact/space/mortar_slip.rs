//! Slip of mortar contact in space, with the weights of the gap and, between curved facets, weights along the normal.

use super::curve_slip::{NormalPart, NormalWeights};
use super::mortar::MortarInSpace;
use super::pair::Pair;
use super::slip::{Group, SlipGroups, groups_of};
use super::vectors::{FacetFrame, Vec3, jets};
use super::vertices::{OfNodes, UNKNOWNS};
use crate::contact::numbers::Number;

impl MortarInSpace {
    /// Adds the weights along the normal of the secondary facet.
    fn add_normal_parts<T: Number>(&self, p: usize, normal: Vec3<T>, weights: Option<NormalWeights<T>>, groups: &mut [Group<T>]) {
        let Some([x, y]) = weights else { return };
        let (x, y) = (self.shape(p).of_lists(x), self.shape(p).of_lists(y));
        for (group, tangents) in groups.iter_mut().zip(self.tangents(p)) {
            group.normal = Some(NormalPart::new(normal, [&x[group.place], &y[group.place]], tangents));
        }
    }
}

/// Slip with the weights of the gap: multiplier shape functions times shape functions of the opposite facet, over the overlap.
impl SlipGroups for MortarInSpace {
    fn groups(&self, p: usize, z: &[Vec3<f64>]) -> Vec<Group<f64>> {
        let Some(pair) = Pair::at(z, self.counts(p)).filter(Pair::overlaps) else { return Vec::new() };
        let (pair, shape) = (pair.curved(self.profiles(p)), self.shape(p));
        let mut groups = groups_of(&shape.of_lists(pair.mortar_weights()), shape.of(pair.covered()), pair.axes(), self.tangents(p));
        self.add_normal_parts(p, pair.axes()[2], pair.normal_weights(), &mut groups);
        groups
    }

    fn differentiated(&self, p: usize, z: &[Vec3<f64>]) -> Vec<Group<OfNodes>> {
        let counts = self.counts(p);
        let Some(pair) = Pair::at(z, counts).filter(Pair::overlaps) else { return Vec::new() };
        let Some(frame) = FacetFrame::new(&jets::<UNKNOWNS>(z[..counts[0]].as_flattened(), 0)) else { return Vec::new() };
        let (pair, shape) = (pair.curved(self.profiles(p)), self.shape(p));
        let weights = pair.differentiated_weights();
        let mut groups = groups_of(&shape.of_lists(weights), shape.of(pair.covered()), frame.axes, self.tangents(p));
        self.add_normal_parts(p, frame.axes[2], pair.differentiated_normal_weights(&frame.axes[0]), &mut groups);
        groups
    }
}
