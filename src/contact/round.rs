//! Contact of a small rigid disk with the facets of a surface, for penetration between the surface's nodes (used by `rigid_corners.rs`).
//!
//! Each facet has a constraint: the distance of the disk's center from it less the radius. The disk may touch several facets, as in a slot.
//! Beyond the ends of a facet the constraint is the distance from a node, like that of the node itself: constraints that end with the facet
//! would jump where the disk passes a node.

use super::depth::NodePosition;
use super::kernel::{CandidateSearch, PatchFunctions, RigidObstacle};
use super::node_patch::{self, PointStart, Round};
use super::patches::Evaluation;
use super::search::Candidates;
use super::slip::{self, SlipStep};
use super::surface::Sides;
use super::window::PredictedMotion;
use crate::integrators::Derivative;

/// Search distance beyond the required one, in shortest facets of the surface.
const SEARCH_MARGIN: f64 = 1.0;

/// Penetration, in shortest facets, beyond which a facet has no constraint: initial overlaps are resolved by the constraints of the nodes.
const OVERLAP_OF_SURFACES: f64 = 0.15;

/// Contact of a disk, represented by a node at its center, with a surface; one constraint per facet.
#[derive(Clone, Debug)]
pub struct RoundContact {
    /// Contact surfaces; the secondary side is the center of the disk, as a facet of zero length.
    sides: Sides,
    radius: f64,
    /// Rotation angle in the step `[rad]`.
    turn: f64,
    candidates: Candidates,
    start: Vec<PointStart>,
}

impl RoundContact {
    /// Contact of a disk with a surface (facets in model node numbers, the body on the left).
    pub fn new(center: u32, radius: f64, surface: &[[u32; 2]], reference: &[f64], facet_size: f64) -> Self {
        let sides = Sides { weights: vec![facet_size; surface.len()], facet_size, ..Sides::new(&[[center; 2]], surface, reference) };
        RoundContact { sides, radius, turn: 0.0, candidates: Candidates::new(SEARCH_MARGIN * facet_size), start: Vec::new() }
    }

    /// Lists the contact elements of the present candidates: center and nodes of a facet.
    fn list_patches(&mut self) {
        self.sides.patches.clear();
        self.start.clear();
        let center = self.sides.secondary.nodes()[0];
        for &[_, facet] in self.candidates.pairs() {
            let [a, b] = self.sides.primary.facets()[facet as usize];
            self.sides.patches.push(&[center, a, b], &[facet]);
        }
    }

    /// Values of contact element `p` at the start of a step; without a gap if the facet is too deep or out of reach.
    fn prepare(&self, p: usize, predicted_motion: &PredictedMotion) -> PointStart {
        let (facet, surface) = (self.sides.patches.rows(p)[0] as usize, &self.sides.primary);
        let (center, ends) = (self.sides.secondary.nodes()[0], surface.facets()[facet]);
        let is_concave = surface.local_facets()[facet].map(|node| !surface.is_convex(node as usize, predicted_motion.q));
        let round = Round { radius: self.radius, is_concave };
        let opposite = PointStart::round([0, 1, 2], round);
        let mut z = Vec::new();
        opposite.gather_into(self.sides.patches.nodes(p), predicted_motion.q, &mut z);
        let is_overlapped = opposite.measures(&z)[0].is_none_or(|measure| measure.gap <= -OVERLAP_OF_SURFACES * self.sides.facet_size);
        let apart = NodePosition::new(center, ends, predicted_motion.q).distance - self.radius;
        if is_overlapped || apart > self.sides.facet_size + predicted_motion.motion_bound::<2>(&[center], &ends) {
            PointStart::default()
        } else {
            opposite
        }
    }

    fn begin_all(&mut self, predicted_motion: &PredictedMotion) {
        self.start = (0..self.sides.patches.len()).map(|p| self.prepare(p, predicted_motion)).collect();
    }
}

impl PatchFunctions for RoundContact {
    fn sides(&self) -> &Sides {
        &self.sides
    }

    fn row_nodes(&self) -> &[u32] {
        // Constraints belong to facets, not to nodes.
        &[]
    }

    fn begin_step(&mut self, q_0: &[f64]) {
        for (p, start) in self.start.iter_mut().enumerate() {
            start.begin(self.sides.patches.nodes(p), q_0, |_| None, |_| None, |_| false);
        }
    }

    fn start_gap(&self) -> Vec<f64> {
        node_patch::start_gaps(&self.sides, &self.start)
    }

    fn evaluate(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation) {
        node_patch::evaluate(&self.sides, &self.start, derivative, q_1, lambda, out);
    }

    fn evaluate_slips(&self, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
        let slips = node_patch::Slips { sides: &self.sides, starts: &self.start, turned: self.turn };
        slip::evaluate(&slips, &self.sides.patches, step, lambda, out);
    }

    fn gap(&self, q: &[f64]) -> Vec<f64> {
        node_patch::gaps(&self.sides, &self.start, q)
    }

    fn coverage(&self, q: &[f64]) -> Vec<f64> {
        node_patch::coverage(&self.sides, &self.start, q)
    }
}

impl CandidateSearch for RoundContact {
    fn update_candidates(&mut self, predicted_motion: &PredictedMotion) -> bool {
        let margin = predicted_motion.search_margin(&self.sides) + self.radius;
        let changed = self.candidates.update(&self.sides.secondary, &self.sides.primary, predicted_motion.q, margin);
        if changed {
            self.list_patches();
        }
        self.begin_all(predicted_motion);
        changed
    }

    fn for_each_participant(&self, p: usize, visit: &mut dyn FnMut(u32)) {
        let nodes = self.sides.patches.nodes(p);
        self.start[p].places.iter().map(|&place| nodes[place as usize]).for_each(visit);
    }

    fn candidates(&self) -> Option<&Candidates> {
        Some(&self.candidates)
    }

    fn restore_candidates(&mut self, candidates: &Candidates, q: &[f64]) {
        self.candidates = candidates.clone();
        self.list_patches();
        self.begin_all(&PredictedMotion::within(q, 0.0));
        self.begin_step(q);
    }

    fn deepest(&self, q: &[f64]) -> f64 {
        node_patch::deepest(&self.sides, &self.start, q)
    }
}

impl RigidObstacle for RoundContact {
    fn carry(&mut self, _shift: [f64; 3], angle: f64) {
        self.turn = angle;
    }
}
