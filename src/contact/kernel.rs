//! Interface of a contact method to the solver of a step: constraint functions as sums over contact elements ([`Patches`]), their
//! candidates, and the rigid obstacle of a pair.

use super::patches::{Evaluation, Patches};
use super::placement::ObstaclePlacement;
use super::profile::Profile;
use super::search::{Candidates, PairSearch};
use super::slip::SlipStep;
use super::surface::{Sides, Surface};
use super::window::PredictedMotion;
use crate::integrators::Derivative;
use crate::math::workers::Workers;

/// Variants of the discrete gradient of a mortar method. All conserve energy; they differ at the kinks where overlaps change their ends. In
/// space, forces at nearly coinciding edges pass from one facet to the next continuously within a band, or with a kink.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Correction {
    /// Gradient at mid-step, with a correction for each contact element.
    #[default]
    PerPatch,
    /// As `PerPatch`, but the ends of the overlap at mid-step stay at the nodes at which they are at the start of the step. While aligned
    /// nodes of both sides approach (two equal blocks), the mid-step gradient of a moving end is a force of the size of the gap there,
    /// which attracts the nodes from both sides, without an equilibrium; fixed ends avoid this force. In space: the band is replaced by a
    /// kink.
    SteadyEnds,
    /// One correction per secondary node. The correction of one contact element jumps where its overlap changes ends; in the sum over all
    /// elements of a node the jumps cancel before the division by the squared increment. The tangent omits the derivative of the
    /// correction, which would couple all elements of a node.
    PerNode,
}

/// Setting of a contact kernel; kernels without use for it ignore it.
pub enum Setting<'a> {
    /// Variant of the discrete gradient.
    Correction(Correction),
    /// Multipliers are pressure times circumference, for bodies of revolution about the second axis.
    AboutAxis,
    /// Height profiles of the facets of both sides in the plane.
    Profiles([Vec<Profile>; 2]),
    /// Edges and corners of the other side have constraints of their own against the facets of this contact, so that a node which an edge
    /// passes needs none of its own (`edge_plane.rs`). Contacts by penalty, equalities and self-contact have none.
    BesideCorners,
    /// Threads for the evaluation of contact elements; results do not depend on their number.
    Workers(&'a Workers),
}

/// Receiver of tangent blocks. Arguments: index of the contact element, and its block row by row, empty if the element has no pressure.
pub type TangentSink<'a> = dyn FnMut(usize, &[f64]) + 'a;

/// Constraint functions of a pair of surfaces, as sums over contact elements.
///
/// Constraint `A` belongs to the secondary node `secondary().nodes()[A]` (with several constraints per node: those of a node are
/// consecutive). It is the sum over the contact elements that list row `A`. An element couples any number of nodes. The element list is
/// fixed within a step and usually over many steps, so that its matrix pattern lasts. Position vectors contain all nodes of the model, node
/// by node.
pub trait PatchFunctions {
    /// Both surfaces, their measures, and the contact elements of the present candidates.
    fn sides(&self) -> &Sides;

    /// Kernel that this one wraps: settings and queries independent of positions that a wrapper does not define are those of this kernel.
    fn inner(&self) -> Option<&dyn ContactKernel> {
        None
    }

    /// Mutable wrapped kernel, see [`Self::inner`].
    fn inner_mut(&mut self) -> Option<&mut dyn ContactKernel> {
        None
    }

    /// Side with the multipliers; its node order is that of the constraints.
    fn secondary(&self) -> &Surface {
        &self.sides().secondary
    }

    /// Side without multipliers; empty for a rigid obstacle.
    fn primary(&self) -> &Surface {
        &self.sides().primary
    }

    /// Number of constraints per secondary node.
    fn rows_per_node(&self) -> usize {
        self.inner().map_or(1, |inner| inner.rows_per_node())
    }

    /// True if each constraint is the gap of a node times its weight; false if it is an integral over the surface.
    fn is_nodal(&self) -> bool {
        self.inner().is_some_and(|inner| inner.is_nodal())
    }

    /// Nodes to which the constraints belong, in their order: all secondary nodes, or none if the constraints belong to corners of an
    /// obstacle.
    fn row_nodes(&self) -> &[u32] {
        self.inner().map_or(self.secondary().nodes(), |inner| inner.row_nodes())
    }

    /// Node to which output at the positions `_q` assigns the multiplier of constraint `row`, if the constraint acts on nodes other than
    /// those of the surface (masters of a rigid body).
    fn shown_at(&self, _row: usize, _q: &[f64]) -> Option<u32> {
        None
    }

    /// Node of the primary side to which output assigns the opposite force; `None` for obstacles, and where forces act on nodes of the
    /// surface.
    fn shown_on_primary(&self, _row: usize, _q: &[f64]) -> Option<u32> {
        None
    }

    /// Nodes that the force of a constraint accelerates, if it is not the constraint's own node.
    fn carriers(&self, row: usize) -> &[u32] {
        self.inner().map_or(&[], |inner| inner.carriers(row))
    }

    /// Number of constraints.
    fn rows(&self) -> usize {
        self.weights().len()
    }

    /// Reference weight `w_A` of each constraint: half the length of the adjacent facets in the plane, nodal share of their area in space
    /// `[length^(D-1)]`.
    fn weights(&self) -> &[f64] {
        &self.sides().weights
    }

    /// True if the force of contact element `p` on `node` acts on the secondary side.
    fn owns(&self, p: usize, node: u32) -> bool {
        let is_own = |row: u32| self.row_nodes().get(row as usize / self.rows_per_node()) == Some(&node);
        self.inner().map_or_else(|| self.patches().rows(p).iter().any(|&row| is_own(row)), |inner| inner.owns(p, node))
    }

    /// Length `h` of the shortest secondary facet in the reference configuration `[length]`.
    fn facet_size(&self) -> f64 {
        self.sides().facet_size
    }

    /// Contact elements of the present candidates.
    fn patches(&self) -> &Patches {
        &self.sides().patches
    }

    /// Upper bound of the bytes of the blocks of one evaluation.
    fn bytes(&self) -> u64 {
        self.inner().map_or_else(|| self.patches().bytes(), |inner| inner.bytes())
    }

    /// Contact elements of the tangential constraints: one constraint per normal constraint in the plane, two in space.
    fn slip_patches(&self) -> &Patches {
        self.sides().slip_patches()
    }

    /// Stores quantities of the present candidates at the start of the step, with positions `q_0`.
    fn begin_step(&mut self, q_0: &[f64]);

    /// Constraint functions at the start of the step.
    fn start_gap(&self) -> Vec<f64>;

    /// Applies a setting.
    fn set(&mut self, setting: Setting) {
        if let Some(inner) = self.inner_mut() {
            inner.set(setting);
        }
    }

    /// Values, gradients and tangent of a step that ends at `q_1`, into `out`; `lambda` has one multiplier per constraint.
    fn evaluate(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation);

    /// As [`Self::evaluate`], but the tangent blocks go to `tangent`, contact element by contact element in ascending order, and need not
    /// stay in `out`. `None` where no tangent is needed.
    fn linearize(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation, tangent: Option<&mut TangentSink>) {
        self.evaluate(derivative, q_1, lambda, out);
        if let Some(tangent) = tangent {
            out.hand_tangents_over(self.patches(), tangent);
        }
    }

    /// Slips of a step with gradients and tangent, in the layout of [`Self::evaluate`]. `lambda` are the tangential multipliers, coverage
    /// is that of mid-step. Kernels without slip return zeros.
    fn evaluate_slips(&self, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
        let (patches, _) = (self.slip_patches(), step);
        out.prepare(patches, lambda.len());
        (0..patches.len()).for_each(|p| out.clear_patch(patches, p));
    }

    /// Constraint functions `Phi_A(q)` of the present candidates, one per constraint (mortar methods: weighted gap `[length^D]`); an
    /// obstacle is at its end position of the step.
    fn gap(&self, q: &[f64]) -> Vec<f64>;

    /// Slack (admitted overlap) of each constraint in this step, relative to that of the pair.
    fn slacks(&self) -> Vec<f64> {
        self.inner().map_or_else(|| vec![1.0; self.weights().len()], |inner| inner.slacks())
    }

    /// Covered share of each secondary node's weight function, 0 to 1; the constraint function vanishes identically at 0. Constraints that
    /// are always present are covered.
    fn coverage(&self, _q: &[f64]) -> Vec<f64> {
        vec![1.0; self.weights().len()]
    }
}

/// Search for the contact elements of a step, and penetration of the candidates.
pub trait CandidateSearch: PatchFunctions {
    /// Lists all contact elements that may touch in a step; true if the list changed, so that the matrix pattern must be rebuilt.
    fn update_candidates(&mut self, predicted_motion: &PredictedMotion) -> bool {
        let Some((search, sides)) = self.search_mut() else { return false };
        let changed = search.update(sides, predicted_motion);
        if changed {
            self.list_patches();
        }
        changed
    }

    /// Search horizon: distance within which facets may take part in a step `[length]`.
    fn margin(&self, predicted_motion: &PredictedMotion) -> f64 {
        predicted_motion.margin(self.sides())
    }

    /// True if a candidate excluded from the step from `q_0` to `q_1` overlaps by more than `tolerance` `[length]` at its end.
    fn overlooks(&self, q_0: &[f64], q_1: &[f64], tolerance: f64) -> bool {
        self.search().is_some_and(|search| search.overlooks(self.sides(), q_0, q_1, tolerance))
    }

    /// Visits the nodes of contact element `p` if it takes part in this step; elements that do not are candidates for later steps.
    fn for_each_participant(&self, p: usize, visit: &mut dyn FnMut(u32)) {
        if let Some(inner) = self.inner() {
            inner.for_each_participant(p, visit);
        } else if self.search().is_none_or(|search| search.near[p]) {
            self.patches().nodes(p).iter().copied().for_each(visit);
        }
    }

    /// Candidate facet pairs, the state that a method with a search keeps between steps.
    fn candidates(&self) -> Option<&Candidates> {
        self.inner().map_or_else(|| self.search().map(|search| &search.candidates), |inner| inner.candidates())
    }

    /// Restores earlier candidates of this pair, and the values that depend on the step start `q`.
    fn restore_candidates(&mut self, candidates: &Candidates, q: &[f64]) {
        if let Some((search, sides)) = self.search_mut() {
            search.restore(candidates, sides, q);
            self.list_patches();
            self.begin_step(q);
        }
    }

    /// Search for facet pairs; `None` for methods without facet pairs.
    fn search(&self) -> Option<&PairSearch> {
        self.inner()?.search()
    }

    /// Mutable search for facet pairs, with both surfaces.
    fn search_mut(&mut self) -> Option<(&mut PairSearch, &Sides)> {
        None
    }

    /// Lists the contact elements of the facet pairs that the search has found.
    fn list_patches(&mut self) {}

    /// Largest penetration of a node of either side in the other body at `q` `[length]`, over the pairs that take part; 0 without
    /// penetration.
    fn deepest(&self, q: &[f64]) -> f64 {
        self.search().map_or(0.0, |search| search.deepest(self.sides(), q))
    }

    /// Relative depth by which facets of both sides cross at `q`, in facet lengths; 0 without crossing.
    fn crossing(&self, q: &[f64]) -> f64 {
        self.search().map_or(0.0, |search| search.crossing(self.sides(), q))
    }
}

/// Operations of a pair whose other side is a rigid obstacle; pairs of two surfaces use the default implementations.
pub trait RigidObstacle: PatchFunctions {
    /// Sets the translations of the obstacle at the start, in the middle and at the end of the step `[length]`.
    fn move_obstacle(&mut self, translations: &[[f64; 3]; 3]) {
        if let Some(inner) = self.inner_mut() {
            inner.move_obstacle(translations);
        }
    }

    /// Sets the angles of an obstacle that turns about an axis, at the start and at the end of the step `[rad]`.
    fn turn_obstacle(&mut self, _angles: [f64; 2]) {}

    /// Sets the prescribed coordinate of a joint at the start and at the end of the step.
    fn drive(&mut self, _values: [f64; 2]) {}

    /// Sets the approximate start values of the coordinates that a gear couples, which define the whole turns of angles.
    fn count_from(&mut self, _coordinates: [f64; 2]) {}

    /// Sets the motion of the obstacle's surface, relative to which friction measures slip: displacement in the step `[length]` and, for a
    /// round obstacle, rotation about its center `[rad]`. In a search for equilibrium: motion since the previous equilibrium, although the
    /// obstacle does not move.
    fn carry(&mut self, shift: [f64; 3], angle: f64) {
        if let Some(inner) = self.inner_mut() {
            inner.carry(shift, angle);
        }
    }

    /// Translation of the obstacle at the end of the step `[length]`.
    fn obstacle_translation(&self) -> [f64; 3] {
        self.inner().map_or([0.0; 3], |inner| inner.obstacle_translation())
    }

    /// Rotation and translation of the obstacle at the end of the step.
    fn obstacle_placement(&self) -> ObstaclePlacement {
        ObstaclePlacement { translation: self.obstacle_translation(), ..ObstaclePlacement::default() }
    }

    /// Largest values over all nodes on their straight paths to `q_1`: change of the distance near the obstacle, in facet lengths, and path
    /// length, in shortest facets, of nodes that cross the obstacle.
    fn passage(&self, _q_1: &[f64]) -> [f64; 2] {
        [0.0; 2]
    }

    /// Adds the nodal forces of the obstacle in a step that ends at `q_1`, and returns the work of its motion `[energy]`; zero for two
    /// surfaces, whose forces cancel. `before` are the multipliers of the gradient at the start of the step, `lambda` those of the
    /// algorithmic gradient.
    ///
    /// The energy balance counts this work as work of loads. Its sum with the work of the contact forces is
    ///
    /// `sum_A lambda_A (Phi_A(q_1) - Phi_A(q_0))`.
    fn obstacle_force_into(&self, _derivative: Derivative, _q_1: &[f64], _before: &[f64], _lambda: &[f64], _force: &mut [f64]) -> f64 {
        0.0
    }
}

/// Contact method of one pair of surfaces, as used by the solver of a step.
///
/// Order of calls: [`move_obstacle`](RigidObstacle::move_obstacle), [`update_candidates`](CandidateSearch::update_candidates) and
/// [`begin_step`](PatchFunctions::begin_step) at the start of every step (of a halved one as well), then
/// [`evaluate`](PatchFunctions::evaluate) once for each Newton iteration.
pub trait ContactKernel: CandidateSearch + RigidObstacle + Send + Sync {}

impl<K: CandidateSearch + RigidObstacle + Send + Sync> ContactKernel for K {}
