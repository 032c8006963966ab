//! A contact pair in global node numbers: its constraints, its places in the matrix, its enforcement.
//!
//! Pairs are two surfaces, a surface and a rigid obstacle, ties, and the corners that the weighted gaps of another pair do not resolve. The
//! values of a pair at an iterate are in an [`Evaluation`], which belongs to the iterate and not to the pair.

use std::ops::Range;
use std::sync::Arc;

use super::force_shares::ForceShares;
use super::friction_rows::FrictionRows;
use super::joint_reaction::JointReaction;
use super::laws::{Bilateral, Equation, Penalty, Reaction, RowLaw, Unilateral};
use super::obstacle_velocity::ObstacleVelocity;
use crate::contact::{ContactKernel, Coulomb, Evaluation, Patches};
use crate::dynamics::model::amplitude::Amplitude;
use crate::dynamics::model::interactions::{Coefficient, Friction, Interaction, ObstacleRotation};
use crate::dynamics::model::joints::Coordinate;
use crate::dynamics::model::update_rules::{ActiveConstraints, GAP, UpdateRule};
use crate::linear::{Block, Pattern};
use crate::math::tolerances;

/// Kind of a constraint block: the entities that its constraints connect.
#[derive(Clone, Debug, PartialEq)]
pub enum PairKind {
    /// Two surfaces, or a surface in self contact.
    Surfaces,
    /// Surface and rigid obstacle.
    Obstacle,
    /// Two tied surfaces, without contact.
    Tie,
    /// Masters and dependent nodes of a rigid body.
    Rigidity,
    /// Constraints of a joint.
    Joint,
    /// Friction of a joint.
    JointFriction,
    /// Equations between nodes.
    Coupling(Arc<CoupledNodes>),
}

impl PairKind {
    /// True if the constraints hold in both directions: ties, rigid bodies, joints and couplings.
    pub fn is_bilateral(&self) -> bool {
        matches!(self, PairKind::Tie) || self.is_of_points()
    }

    /// True if the constraints connect points: rigid bodies, joints and couplings, which are no interactions of the model.
    pub fn is_of_points(&self) -> bool {
        matches!(self, PairKind::Rigidity | PairKind::Joint | PairKind::JointFriction | PairKind::Coupling(_))
    }
}

/// Nodes on which the constraint forces of a coupling act, one per constraint: nodes of the symmetry plane or of the second boundary.
#[derive(Clone, Debug, PartialEq)]
pub struct CoupledNodes {
    /// Index of the coupling in the model.
    pub coupling: usize,
    /// Unit direction of the forces.
    pub along: [f64; 3],
    /// Nodes, in the order of the constraints.
    pub nodes: Vec<u32>,
    /// Nodes of the boundary of a coupling to a reference body in ascending order, whose forces follow from gradients.
    pub pushed: Vec<u32>,
}

/// Reference from corner constraints to the contact pair whose weighted gaps do not resolve the corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CornersOf {
    /// Index of the contact pair.
    pub pair: usize,
    /// Admitted overlap of corner constraints `[length]`: without it, those of flat touching surfaces depend linearly on those of the pair.
    pub slack: f64,
}

/// A contact pair.
pub struct ContactPair {
    /// Name of the contact.
    pub name: String,
    /// Kind of the pair.
    pub kind: PairKind,
    /// Contact pair to which the corner constraints belong; `None` for other constraint blocks.
    pub corners: Option<CornersOf>,
    /// Translation of the obstacle over time.
    pub motion: [Option<Amplitude>; 3],
    /// Rotation of the obstacle over time.
    pub turn: Option<ObstacleRotation>,
    /// Prescribed coordinate of a joint over time.
    pub drive: Option<(Coordinate, Amplitude)>,
    /// True if the prescribed coordinate changes in this step.
    pub is_driven: bool,
    /// Indices of the two joints that a gear couples.
    pub geared: Option<[usize; 2]>,
    /// Limit of a joint's friction.
    pub reaction: Option<JointReaction>,
    /// Mean velocity of the obstacle in this step.
    pub obstacle_velocity: ObstacleVelocity,
    /// Constraint functions.
    pub kernel: Box<dyn ContactKernel>,
    /// Law of the normal constraints.
    pub law: &'static dyn RowLaw,
    /// Update rule over a step.
    pub update: &'static UpdateRule,
    /// Coefficient of restitution of impacts between rigid sides; `None` for a deformable side or a penalty potential.
    pub restitution: Option<f64>,
    /// Augmentation factor relative to the stiffness of a node; `None` without a proximal term.
    pub augmentation: Option<f64>,
    /// True if the bodies are axisymmetric: multipliers are then pressures times circumferences.
    pub is_axisymmetric: bool,
    /// Range of the normal constraints among all constraints.
    pub rows: Range<usize>,
    /// Tangential constraints; `None` without friction.
    pub friction: Option<FrictionRows>,
    /// Pressure per weighted gap, `youngs_modulus / h^2`: compares multipliers with gaps.
    pub c: f64,
    /// Stiffness of the penalty potential of each constraint; empty without penalties.
    pub penalties: Vec<f64>,
    /// Weighted gap that counts as closed for Newton's method.
    pub gap_tolerance: f64,
    /// Weighted gap at the start of a step that counts as closed.
    pub closed: f64,
    /// True if the multipliers of bilateral constraints enter only their own step, too.
    pub acts_at_once: bool,
    places: Places,
}

/// Blocks of the contact elements in the matrix: those of node pairs (row by row), then for each constraint and node the blocks in the row
/// and in the column of the multiplier.
#[derive(Default)]
struct Places {
    tangent: Vec<Block>,
    rows: Vec<[Block; 2]>,
    /// Blocks of tangential constraints in the rows and in the columns of their multipliers.
    slip_rows: Vec<[Block; 2]>,
}

/// Normal or tangential constraints of a pair at an iterate.
pub struct RowBlock<'a> {
    /// Contact pair of the block.
    pub pair: &'a ContactPair,
    /// Range of the block's constraints among all constraints.
    pub rows: Range<usize>,
    /// Constraints of each contact element.
    pub patches: &'a Patches,
    /// Evaluation of the constraints.
    pub evaluation: &'a Evaluation,
    /// Blocks of rows and columns in the matrix, if they are kept.
    places: &'a [[Block; 2]],
}

/// Constraint of a contact element with its nodes.
pub struct PatchRow<'a> {
    /// Index of the contact element.
    pub patch: usize,
    /// Index among all constraints.
    pub row: usize,
    /// Nodes of the contact element.
    pub nodes: &'a [u32],
    /// Range of the gradient in [`Evaluation::gradient_end`] and [`Evaluation::gradient_bar`].
    pub gradient: Range<usize>,
}

impl PatchRow<'_> {
    /// Unknowns of the nodes in `D` dimensions, each with the index of its gradient entry.
    pub fn unknowns<const D: usize>(&self) -> impl Iterator<Item = (usize, usize)> {
        let components = self.nodes.iter().flat_map(|&node| (0..D).map(move |i| node as usize * D + i));
        components.zip(self.gradient.clone())
    }
}

impl ContactPair {
    /// Contact pair `name` with multipliers under the `gap` rule; `modulus` is that of the secondary body, `reach` the largest coordinate
    /// of the model.
    pub fn new(name: &str, kind: PairKind, kernel: Box<dyn ContactKernel>, modulus: f64, reach: f64) -> Self {
        let (size, dimension) = (kernel.facet_size(), kernel.patches().dimension() as i32);
        let gap_tolerance = (tolerances::GAP * size.powi(dimension)).max(tolerances::GAP_FLOOR * reach * size.powi(dimension - 1));
        ContactPair {
            name: name.into(),
            law: if kind.is_bilateral() { &Bilateral } else { &Unilateral },
            kind,
            corners: None,
            motion: [None, None, None],
            turn: None,
            drive: None,
            is_driven: false,
            geared: None,
            reaction: None,
            obstacle_velocity: ObstacleVelocity::default(),
            update: &GAP,
            restitution: None,
            augmentation: None,
            is_axisymmetric: false,
            rows: 0..kernel.rows(),
            friction: None,
            c: modulus / size.powi(dimension),
            penalties: Vec::new(),
            gap_tolerance,
            closed: (tolerances::CLOSED * size.powi(dimension)).max(10.0 * gap_tolerance),
            kernel,
            acts_at_once: false,
            places: Places::default(),
        }
    }

    /// Tolerance of the weighted gap where the largest coordinate is `reach`: bodies may move far away from where they began.
    pub fn gap_tolerance_at(&self, reach: f64) -> f64 {
        self.gap_tolerance.max(self.gap_round_off(reach))
    }

    /// Round-off of the weighted gap where the largest coordinate is `reach`.
    pub fn gap_round_off(&self, reach: f64) -> f64 {
        let dimension = self.kernel.patches().dimension() as i32;
        let measure = if self.kind.is_of_points() { 1.0 } else { self.kernel.facet_size().powi(dimension - 1) };
        tolerances::GAP_FLOOR * reach * measure
    }

    /// Adds the tangential constraints of the contact's friction, if defined.
    pub fn add_friction(&mut self, interaction: &Interaction) {
        let tangents = self.kernel.patches().dimension() - 1;
        self.friction = interaction.friction.as_ref().map(|friction| FrictionRows::new(friction, self.kernel.rows(), tangents, self.c));
    }

    /// Adds the tangential constraints of a joint, whose friction is at most `limit`: one for each component of its slip.
    pub fn add_joint_friction(&mut self, limit: JointReaction, components: usize) {
        let friction = Friction { law: Arc::new(Coulomb::default()), coefficient: Coefficient::Constant(1.0) };
        self.friction = Some(FrictionRows::new(&friction, 1, components, self.c));
        (self.law, self.reaction) = (&Reaction, Some(limit));
    }

    /// Factor from length in the section at a node to area: 1 in the plane, the circumference in an axisymmetric model `[length]`.
    pub fn circumference(&self, node: u32, q: &[f64]) -> f64 {
        if self.is_axisymmetric { std::f64::consts::TAU * q[2 * node as usize] } else { 1.0 }
    }

    /// Replaces the multipliers by penalty potentials: the pressure at a node is `factor * youngs_modulus / h` times its penetration,
    /// independent of the node's tributary length and circumference. `q` are the reference positions; `has_middles`: edges are of second
    /// order, whose ends on the axis have no weight.
    pub fn penalize(&mut self, factor: f64, q: &[f64], has_middles: bool) {
        let of_depth = factor * self.c * self.kernel.facet_size().powi(self.kernel.patches().dimension() as i32 - 1);
        // A half facet that ends on the axis has the stiffness of a third of a facet away from it.
        let on_axis = if self.is_axisymmetric && !has_middles { std::f64::consts::TAU * 2.0 / 3.0 } else { 0.0 };
        let around = |row: usize| self.node_of(row).map_or(1.0, |node| self.circumference(node, q));
        let rows = self.rows.clone().zip(self.kernel.weights());
        let stiffness = |(row, &weight): (usize, &f64)| of_depth * f64::max(around(row), on_axis * weight) / weight.max(f64::MIN_POSITIVE);
        self.penalties = rows.map(stiffness).collect();
        (self.law, self.augmentation) = (&Penalty, None);
    }

    /// Stiffness of the penalty potential of a constraint; `None` without one.
    pub fn penalty(&self, row: usize) -> Option<f64> {
        self.penalties.get(row - self.rows.start).copied()
    }

    /// True if the multipliers enter only their own step: those of unilateral constraints and of friction with every time integrator, those
    /// of bilateral constraints with [`Self::acts_at_once`].
    pub fn forces_stay_in_step(&self) -> bool {
        self.friction.is_some() || self.is_unilateral() || self.acts_at_once
    }

    /// True if multipliers enforce the constraints.
    pub fn has_multipliers(&self) -> bool {
        self.law.has_multiplier()
    }

    /// True if the constraints have no force and only measure penetration: corners of contacts with penalties.
    pub fn only_measures(&self) -> bool {
        self.corners.is_some() && !self.has_multipliers() && self.penalties.iter().all(|&stiffness| stiffness == 0.0)
    }

    /// True if multipliers enforce the constraints and are nonnegative.
    pub fn is_unilateral(&self) -> bool {
        self.law.has_multiplier() && !self.law.is_bilateral()
    }

    /// True if inactive nodes may penetrate the other side within a step.
    pub fn may_penetrate(&self) -> bool {
        self.update.holds == ActiveConstraints::AsItIs && self.is_unilateral()
    }

    /// First index and contact elements of the normal constraints, and of the tangential ones.
    fn row_kinds(&self) -> impl Iterator<Item = (usize, &Patches)> {
        let tangential = self.friction.iter().map(|friction| (friction.rows.start, self.kernel.slip_patches()));
        std::iter::once((self.rows.start, self.kernel.patches())).chain(tangential)
    }

    /// Index of each tangential constraint, with that of its normal constraint.
    pub fn tangential(&self) -> impl Iterator<Item = (usize, usize)> {
        let of = |friction: &FrictionRows, row: usize| (row, self.rows.start + friction.normal_row(row));
        self.friction.iter().flat_map(move |friction| friction.rows.clone().map(move |row| of(friction, row)))
    }

    /// Normal constraints and tangential constraints of the pair at an iterate, as two blocks.
    pub fn blocks<'a>(&'a self, [normal, slip]: [&'a Evaluation; 2]) -> impl Iterator<Item = RowBlock<'a>> {
        let places = &self.places;
        let own =
            RowBlock { pair: self, rows: self.rows.clone(), patches: self.kernel.patches(), evaluation: normal, places: &places.rows };
        let tangential = self.friction.iter().map(move |friction| RowBlock {
            pair: self,
            rows: friction.rows.clone(),
            patches: self.kernel.slip_patches(),
            evaluation: slip,
            places: &places.slip_rows,
        });
        std::iter::once(own).chain(tangential)
    }

    /// Visits groups of coupled vertices; vertices of constraints follow `nodes` nodes.
    pub fn for_each_coupling(&self, nodes: usize, visit: &mut dyn FnMut(&[u32])) {
        let (patches, mut clique) = (self.kernel.patches(), Vec::new());
        for p in 0..patches.len() {
            clique.clear();
            clique.extend_from_slice(patches.nodes(p));
            for (first, patches) in self.row_kinds() {
                clique.extend(patches.rows(p).iter().map(|row| (nodes + first) as u32 + row));
            }
            visit(&clique);
        }
        if let Some(friction) = &self.friction {
            // Constraints outside of all contact elements have matrix rows, too.
            for (local, row) in self.rows.clone().enumerate() {
                clique.clear();
                let components = self.reaction.iter().flat_map(|reaction| reaction.rows.clone());
                clique.extend(std::iter::once(row).chain(friction.group(local)).chain(components).map(|row| (nodes + row) as u32));
                visit(&clique);
            }
        }
    }

    /// Finds the blocks of the pair in a new matrix pattern.
    pub fn place(&mut self, pattern: &Pattern, nodes: usize) {
        let mut places = Places::default();
        let patches = self.kernel.patches();
        for p in (0..patches.len()).filter(|_| patches.dimension() == 2) {
            for &u in patches.nodes(p) {
                places.tangent.extend(patches.nodes(p).iter().map(|&v| pattern.block(u, v)));
            }
            for ((first, patches), of_rows) in self.row_kinds().zip([&mut places.rows, &mut places.slip_rows]) {
                for &row in patches.rows(p) {
                    let multiplier = (nodes + first + row as usize) as u32;
                    of_rows.extend(patches.nodes(p).iter().map(|&node| [pattern.block(multiplier, node), pattern.block(node, multiplier)]));
                }
            }
        }
        self.places = places;
        self.reaction.iter_mut().for_each(|reaction| reaction.place(pattern, nodes, self.rows.start));
        if let Some(friction) = &mut self.friction {
            let block = |row: usize, column: usize| pattern.block((nodes + row) as u32, (nodes + column) as u32);
            friction.couplings = friction.rows.clone().map(|slip| block(slip, self.rows.start + friction.normal_row(slip))).collect();
            friction.partners = friction.pairs().map(|[slip, other]| block(slip, other)).collect();
        }
    }

    /// Subtracts `weight` times the derivative of the forces of a contact element at fixed multipliers.
    pub fn tangent_into<const D: usize>(&self, (pattern, p): (&Pattern, usize), weight: f64, tangent: &[f64], values: &mut [f64]) {
        let patches = self.kernel.patches();
        let (nodes, count, first) = (patches.nodes(p), patches.unknowns(p), patches.tangent_range(p).start / (D * D));
        for (u, &row) in nodes.iter().enumerate() {
            for (v, &column) in nodes.iter().enumerate() {
                let kept = self.places.tangent.get(first + u * nodes.len() + v);
                let place = kept.copied().unwrap_or_else(|| pattern.block(row, column));
                for i in 0..D {
                    for k in 0..D {
                        values[place.at(i, k)] -= weight * tangent[(u * D + i) * count + v * D + k];
                    }
                }
            }
        }
    }

    /// Normal constraints of the contact elements that contribute.
    pub fn live_rows<'a>(&'a self, evaluation: &'a Evaluation) -> impl Iterator<Item = PatchRow<'a>> {
        live_rows(self.rows.start, self.kernel.patches(), evaluation)
    }

    /// True for ties, joints, couplings and rigid bodies, whose functions are at most quadratic in positions, or have an exact discrete
    /// gradient (gears).
    pub fn has_quadratic_functions(&self) -> bool {
        matches!(self.kind, PairKind::Tie | PairKind::Rigidity | PairKind::Joint | PairKind::Coupling(_))
    }

    /// Replaces the values of ties, joints, couplings and rigid bodies at the end of a step by `Phi_0 + Gbar . (q_1 - q_0)` with the
    /// increment `moved`, exact for the discrete gradient `Gbar` of these functions.
    ///
    /// A stop that reverses a motion has a multiplier of momentum over `dt`: times the round-off of `Phi(q_1)`, in short steps this is more
    /// energy than the tolerance, and Newton's method does not converge (`tests/scripts/joints_in_short_steps.rhai`).
    pub fn follow_increment<const D: usize>(&self, moved: &[f64], evaluation: &mut Evaluation) {
        if !self.has_quadratic_functions() || self.is_driven {
            return;
        }
        let mut gap = self.kernel.start_gap();
        for row in self.live_rows(evaluation) {
            let change = row.unknowns::<D>().map(|(k, entry)| evaluation.gradient_bar[entry] * moved[k]).sum::<f64>();
            gap[row.row - self.rows.start] += change;
        }
        evaluation.gap = gap;
    }

    /// Work of friction on the slips of a group of tangential constraints `[energy]`: not positive for slips within their tolerance.
    /// Sticking constraints leave such slips, in any direction; their work is an error of the solution, not of the friction law, and
    /// remains in the energy defect.
    pub fn friction_work(&self, shear: &[f64], slips: &[f64]) -> f64 {
        let work = shear.iter().zip(slips).map(|(shear, slip)| shear * slip).sum::<f64>();
        let is_stick = slips.iter().map(|slip| slip * slip).sum::<f64>() <= self.gap_tolerance * self.gap_tolerance;
        if is_stick { work.min(0.0) } else { work }
    }

    /// True if `node` owns a constraint of the contact element `patch`.
    pub fn owns_row(&self, patch: usize, node: u32) -> bool {
        self.kernel.owns(patch, node)
    }

    /// Secondary node that owns a constraint of the model; `None` if no node owns it.
    pub fn node_of(&self, row: usize) -> Option<u32> {
        let tangential = self.friction.as_ref().filter(|friction| row >= friction.rows.start && !self.rows.contains(&row));
        let local = tangential.map_or_else(|| row - self.rows.start, |friction| friction.normal_row(row));
        self.kernel.row_nodes().get(local / self.kernel.rows_per_node()).copied()
    }
}

/// Constraints of the contact elements that contribute, numbered from `first_row`.
fn live_rows<'a>(first_row: usize, patches: &'a Patches, evaluation: &'a Evaluation) -> impl Iterator<Item = PatchRow<'a>> {
    (0..patches.len()).filter(|&p| evaluation.live[p]).flat_map(move |p| {
        let (first, count) = (evaluation.gradient_range(patches, p).start, patches.unknowns(p));
        patches.rows(p).iter().enumerate().map(move |(m, &row)| {
            let start = first + m * count;
            PatchRow { patch: p, row: first_row + row as usize, nodes: patches.nodes(p), gradient: start..start + count }
        })
    })
}

impl<'a> RowBlock<'a> {
    /// True if the constraints of the block are tangential.
    pub fn is_slip(&self) -> bool {
        self.rows.start != self.pair.rows.start
    }

    /// Weight of the block's multipliers in the balance of momentum.
    pub fn share(&self, shares: ForceShares) -> f64 {
        if self.pair.forces_stay_in_step() { shares.alone } else { shares.lagging }
    }

    /// Work of the multipliers on the slips `[energy]`.
    pub fn work(&self, lambda: &[f64]) -> f64 {
        lambda[self.rows.clone()].iter().zip(&self.evaluation.gap).map(|(tau, slip)| tau * slip).sum()
    }

    /// Work of friction in a block of tangential constraints `[energy]`.
    pub fn friction_work(&self, shear: &[f64]) -> f64 {
        let tangents = self.pair.friction.as_ref().map_or(1, |friction| friction.tangents);
        let groups = shear[self.rows.clone()].chunks(tangents).zip(self.evaluation.gap.chunks(tangents));
        groups.map(|(shear, slips)| self.pair.friction_work(shear, slips)).sum()
    }

    /// Constraints of the contact elements of the block that contribute, element by element.
    pub fn live_rows(&self) -> impl Iterator<Item = PatchRow<'a>> {
        live_rows(self.rows.start, self.patches, self.evaluation)
    }

    /// Adds rows `factor G_1` and columns `-share columns^T` of the constraints whose multipliers may be nonzero.
    pub fn constraints_into<const D: usize>(
        &self,
        (pattern, nodes): (&Pattern, usize),
        equations: &[Equation],
        columns: &[f64],
        shares: ForceShares,
        values: &mut [f64],
    ) {
        let (RowBlock { patches, evaluation, places, .. }, weight) = (self, self.share(shares));
        let tangents = self.pair.friction.as_ref().map_or(1, |friction| friction.tangents);
        for p in (0..patches.len()).filter(|&p| evaluation.live[p]) {
            let (coupled, count) = (patches.nodes(p), patches.unknowns(p));
            let (first, kept) = (evaluation.gradient_range(patches, p).start, patches.gradient_range(p).start / D);
            for (m, &row) in patches.rows(p).iter().enumerate() {
                let Equation { acts, gradient: factor, beside, .. } = equations[self.rows.start + row as usize];
                if !acts {
                    continue;
                }
                let multiplier = (nodes + self.rows.start + row as usize) as u32;
                for (u, &node) in coupled.iter().enumerate() {
                    let searched = || [pattern.block(multiplier, node), pattern.block(node, multiplier)];
                    let [row_place, column_place] = places.get(kept + m * coupled.len() + u).copied().unwrap_or_else(searched);
                    for i in 0..D {
                        let entry = first + m * count + u * D + i;
                        values[row_place.at(0, i)] += factor * evaluation.gradient_end[entry];
                        values[column_place.at(i, 0)] -= weight * columns[entry];
                    }
                    for (by, [of_other, _]) in (1..).zip(beside).filter(|(_, [of_other, _])| *of_other != 0.0) {
                        // The rows of a group follow each other.
                        let other = first + (m - m % tangents + (m + by) % tangents) * count + u * D;
                        (0..D).for_each(|i| values[row_place.at(0, i)] += of_other * evaluation.gradient_end[other + i]);
                    }
                }
            }
        }
    }
}
