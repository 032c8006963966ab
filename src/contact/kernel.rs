//! What a contact method is for the solver of a step: functions of patches of nodes.

use super::patches::{Evaluation, Patches};
use super::profile::Profile;
use super::search::{Candidates, PairSearch};
use super::slip::SlipStep;
use super::surface::{Sides, Surface};
use super::window::Outlook;
use crate::integrators::Derivative;
use crate::math::workers::Workers;

/// Discrete gradients of a mortar sum: all conserve, each copes with other kinks, where overlaps change their ends. In space forces on
/// edges that nearly coincide pass from one facet to the other within a band, or with a kink.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Correction {
    /// The gradient at mid-step, corrected patch by patch.
    #[default]
    PerPatch,
    /// As `PerPatch`, but the overlaps of mid-step end at the nodes at which they end at the start of the step. Where nodes of both sides
    /// stay aligned while a gap closes, as those of two equal blocks, the gradient at mid-step pulls them together from both sides with the
    /// depth at the overlap's end: a force that no position balances. Steady ends have no such pull. In space: with a kink what usually has
    /// a band, and the other way round.
    SteadyEnds,
    /// One correction for each secondary node. A patch's own correction jumps where its overlap changes ends; in the sum over a node's
    /// patches the jumps cancel before they are divided by the size of the step. The tangent leaves out the correction's derivative, which
    /// would couple all patches of a node.
    PerNode,
}

/// Receiver of tangent blocks: the patch, and its block row by row; empty without pressure.
pub type TangentSink<'a> = dyn FnMut(usize, &[f64]) + 'a;

/// Constraint functions of one pair of surfaces, as sums over patches of nodes.
///
/// Constraint `A` belongs to the secondary node `secondary().nodes()[A]` (with several rows for each node: those of node `A` follow each
/// other); it is the sum over the patches that list row `A`. A patch couples a run-time number of nodes. The list of patches is fixed
/// within a step and usually over many steps, so that a matrix pattern made from it lasts. All position vectors are those of the whole
/// model, node after node.
pub trait PatchFunctions {
    /// Its surfaces, their measures, and the patches of the present candidates.
    fn sides(&self) -> &Sides;

    /// The side with the multipliers; its node order is that of the constraints.
    fn secondary(&self) -> &Surface {
        &self.sides().secondary
    }

    /// The other side; empty for a rigid obstacle.
    fn primary(&self) -> &Surface {
        &self.sides().primary
    }

    /// Constraint rows of each secondary node.
    fn rows_per_node(&self) -> usize {
        1
    }

    /// Whether a constraint is a node's own gap times its weight, and not an integral over the surface.
    fn is_nodal(&self) -> bool {
        false
    }

    /// The nodes that own constraints, in the order of the rows: all secondary nodes; none where the constraints are those of an obstacle's
    /// corners.
    fn row_nodes(&self) -> &[u32] {
        self.secondary().nodes()
    }

    /// The node at which output shows what a row does, where its force acts between nodes that are no part of the contact.
    fn shown_at(&self, _row: usize) -> Option<u32> {
        None
    }

    /// Nodes whose mass a row moves, where these are not the node that owns it.
    fn carriers(&self, _row: usize) -> &[u32] {
        &[]
    }

    /// Number of constraint rows.
    fn rows(&self) -> usize {
        self.weights().len()
    }

    /// Weight `w_A` of each constraint row in the reference configuration: half the adjacent facets' measure `[length]` (3D: their share of
    /// the area).
    fn weights(&self) -> &[f64] {
        &self.sides().weights
    }

    /// Whether the force of patch `p` on a node is one on the side of its rows.
    fn owns(&self, p: usize, node: u32) -> bool {
        self.patches().rows(p).iter().any(|&row| self.row_nodes().get(row as usize / self.rows_per_node()) == Some(&node))
    }

    /// Length `h` of the shortest secondary facet in the reference configuration `[length]`.
    fn facet_size(&self) -> f64 {
        self.sides().facet_size
    }

    /// The patches of the present candidates.
    fn patches(&self) -> &Patches {
        &self.sides().patches
    }

    /// Bytes of the blocks of one evaluation, at most.
    fn bytes(&self) -> u64 {
        self.patches().bytes()
    }

    /// The same patches with the tangential rows beside those: as many in the plane, in space two, which follow each other, for each.
    fn slip_patches(&self) -> &Patches {
        self.sides().slip_patches()
    }

    /// Keeps what depends on the start of the step, `q_0`, for the present candidates.
    fn begin_step(&mut self, q_0: &[f64]);

    /// Constraint functions at the start of the step.
    fn start_gap(&self) -> Vec<f64>;

    /// Chooses among discrete gradients that all conserve. Kernels without patch sums ignore it.
    fn set_correction(&mut self, _correction: Correction) {}

    /// Lets multipliers be pressures times circumferences, of bodies of revolution about the second axis.
    fn turn_about_axis(&mut self) {}

    /// Sets the height profiles of the facets of both sides in the plane. Methods that measure from straight facets ignore them.
    fn set_profiles(&mut self, _profiles: [Vec<Profile>; 2]) {}

    /// Gives it threads among which it may share its patches: results do not depend on them.
    fn share_among(&mut self, _workers: &Workers) {}

    /// Values, gradients and tangent of a step that ends at `q_1`, into `out`; `lambda` one multiplier per constraint row.
    fn evaluate(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation);

    /// As [`Self::evaluate`], but the tangent blocks go to `tangent`, patch by patch in ascending order, and need not stay in `out`. `None`
    /// where no tangent is needed.
    fn linearize(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation, tangent: Option<&mut TangentSink>) {
        self.evaluate(derivative, q_1, lambda, out);
        if let Some(tangent) = tangent {
            out.hand_tangents_over(self.patches(), tangent);
        }
    }

    /// Slips of a step with their gradients and tangent, row by row as [`Self::evaluate`] gives gaps: what friction works on. `lambda` are
    /// the tangential multipliers; coverage is that in mid-step. A kernel without slips clears everything.
    fn evaluate_slips(&self, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
        let (patches, _) = (self.slip_patches(), step);
        out.prepare(patches, lambda.len());
        (0..patches.len()).for_each(|p| out.clear_patch(patches, p));
    }

    /// Constraint functions `Phi_A(q)` of the present candidates (an obstacle where the step ends), one per secondary node (mortar:
    /// weighted gap `[length^2]`).
    fn gap(&self, q: &[f64]) -> Vec<f64>;

    /// Slack of the constraint of every row in this step, over that of the pair.
    fn slacks(&self) -> Vec<f64> {
        vec![1.0; self.weights().len()]
    }

    /// Share of each secondary node's weight function that lies opposite the primary side, 0 to 1; 0: the constraint is the zero function.
    fn coverage(&self, q: &[f64]) -> Vec<f64>;
}

/// What is found where: the patches that may touch in a step, and how deep what takes part overlaps.
pub trait CandidateSearch: PatchFunctions {
    /// Makes the patches contain everything that may touch in a step; returns whether the list changed (a matrix pattern made from it must
    /// then be made anew).
    fn update_candidates(&mut self, outlook: &Outlook) -> bool {
        let Some((search, sides)) = self.search_mut() else { return false };
        let changed = search.update(sides, outlook);
        if changed {
            self.list_patches();
        }
        changed
    }

    /// Distance within which everything is that may take part in a step `[length]`.
    fn margin(&self, outlook: &Outlook) -> f64 {
        outlook.margin(self.sides())
    }

    /// Whether something that took no part in the step from `q_0` to `q_1` overlaps by more than `tolerance` `[length]` at its end.
    fn overlooks(&self, q_0: &[f64], q_1: &[f64], tolerance: f64) -> bool {
        self.search().is_some_and(|search| search.overlooks(self.sides(), q_0, q_1, tolerance))
    }

    /// Tells the nodes of patch `p` that take part in this step. The others are there for later steps.
    fn for_each_participant(&self, p: usize, visit: &mut dyn FnMut(u32)) {
        if self.search().is_none_or(|search| search.near[p]) {
            self.patches().nodes(p).iter().copied().for_each(visit);
        }
    }

    /// The candidates, for a method that searches: all that it keeps from one step to the next.
    fn candidates(&self) -> Option<&Candidates> {
        self.search().map(|search| &search.candidates)
    }

    /// Puts earlier candidates of this pair in place of the present ones, and keeps what depends on `q`, where a step may start.
    fn restore_candidates(&mut self, candidates: &Candidates, q: &[f64]) {
        if let Some((search, sides)) = self.search_mut() {
            search.restore(candidates, sides, q);
            self.list_patches();
            self.begin_step(q);
        }
    }

    /// The search for pairs of facets, in a method whose patches are such pairs.
    fn search(&self) -> Option<&PairSearch> {
        None
    }

    /// The same to change it, with the sides between which it searches.
    fn search_mut(&mut self) -> Option<(&mut PairSearch, &Sides)> {
        None
    }

    /// Makes the patches of the pairs that the search has found.
    fn list_patches(&mut self) {}

    /// Largest depth of a node of either side in the other body at `q` `[length]`, point by point, among what takes part; 0 where none is.
    fn deepest(&self, q: &[f64]) -> f64 {
        self.search().map_or(0.0, |search| search.deepest(self.sides(), q))
    }

    /// How far facets of both sides that cross at `q` have come through each other, in facets; 0 where none do.
    fn crossing(&self, q: &[f64]) -> f64 {
        self.search().map_or(0.0, |search| search.crossing(self.sides(), q))
    }
}

/// The rigid obstacle of a pair that has one; a pair of two surfaces has nothing to say.
pub trait RigidObstacle {
    /// Where a rigid obstacle is in this step: its translations at the start, in the middle and at the end `[length]`.
    fn move_obstacle(&mut self, _translations: &[[f64; 3]; 3]) {}

    /// What is prescribed over time of a joint, at the start and at the end of this step.
    fn drive(&mut self, _values: [f64; 2]) {}

    /// What the coordinates that a gear couples are, about, at the start of this step, their angles over whole turns.
    fn count_from(&mut self, _coordinates: [f64; 2]) {}

    /// How a rigid obstacle carries along what sticks to it in this step: by a displacement, and, if it is round, by an angle about its
    /// center `[length]`, `[rad]`. At rest that is its motion since the equilibrium before, although it stands where it is.
    fn carry(&mut self, _shift: [f64; 3], _angle: f64) {}

    /// Where a rigid obstacle is at the end of this step, as its translation `[length]`.
    fn obstacle_translation(&self) -> [f64; 3] {
        [0.0; 3]
    }

    /// How a node passes a rigid obstacle on its straight way through the step to `q_1`, the largest of all nodes: by how much its distance
    /// changes where it comes near, in lengths of its facets, and how far it moves, in shortest ones, where it gets through to the other
    /// side.
    fn passage(&self, _q_1: &[f64]) -> [f64; 2] {
        [0.0; 2]
    }

    /// Adds the nodal forces that a rigid obstacle exerts in a step that ends at `q_1`, and returns the work that its motion does
    /// `[energy]`: between two surfaces nothing, their forces cancel. `before` are the multipliers that press as at the start of the step,
    /// `lambda` those that press by the step's derivative.
    ///
    /// It belongs to the ledger as work of loads: the step's contact forces do `sum_A lambda_A (Phi_A(q_1) - Phi_A(q_0))` and this work.
    fn obstacle_force_into(&self, _derivative: Derivative, _q_1: &[f64], _before: &[f64], _lambda: &[f64], _force: &mut [f64]) -> f64 {
        0.0
    }
}

/// A contact method on one pair of surfaces, as the solver of a step sees it.
///
/// Order of calls: [`move_obstacle`](RigidObstacle::move_obstacle), [`update_candidates`](CandidateSearch::update_candidates) and
/// [`begin_step`](PatchFunctions::begin_step) at the start of every step (of a halved one as well), then
/// [`evaluate`](PatchFunctions::evaluate) once for each Newton iteration.
pub trait ContactKernel: CandidateSearch + RigidObstacle + Send + Sync {}

impl<K: CandidateSearch + RigidObstacle + Send + Sync> ContactKernel for K {}
