//! Contact conditions of a step, by the update rules of the pairs.

use std::collections::BTreeMap;

use super::equations::Equations;
use super::start::StepStart;
use crate::dynamics::model::step_error::StepError;
use crate::dynamics::model::update_rules::ActiveConstraints;
use crate::dynamics::parts::body::Body;
use crate::dynamics::parts::contact_pair::{ContactPair, PairKind};
use crate::dynamics::parts::laws::{Row, RowStart, RowState};
use crate::integrators::Derivative;
use crate::math::norms::largest_size;
use crate::math::tolerances;

/// Values of joints, ties and rigid bodies at the start of a step that are round-off, in units of the round-off of gaps.
const ROUND_OFF: f64 = 16.0;
/// Decrease of such values in a step: fast enough that the round-off of many steps does not add up, and slow enough that its work is below
/// the energy tolerance.
const DECAY: f64 = 1.0 / 1024.0;

/// Contact conditions of a step: `Phi_A(q_1) >= target_A` for admitted constraints, with multipliers `>= 0`.
pub struct Conditions {
    /// Weighted gaps at the start of the step.
    pub gap_n: Vec<f64>,
    /// Weighted gap of an active constraint at the end of the step.
    pub targets: Vec<f64>,
    /// True for each constraint that takes part in this step.
    pub members: Vec<bool>,
    /// Weighted gap per change of the multiplier within an iteration, `1/kappa_A`; nonzero only for augmented Lagrange.
    pub compliance: Vec<f64>,
    /// True if penalty pressures are evaluated at the end of the step (statics, trapezoidal rule) instead of from the change of energy.
    pub end_point: bool,
    /// Offset added to weighted gaps in the penalty potential, so that overlap found by newly admitted facet pairs stores no energy.
    pub shift: Vec<f64>,
    /// Stiffness at the node of every constraint in the step: pressure per weighted gap, or multiplier per slip.
    pub stiffness: Vec<f64>,
    /// True for each tangential constraint that may come to rest within the step, because it slipped in the previous one, or others of its
    /// contact did and it was open.
    pub stops: Vec<bool>,
    /// Slip speed of each constraint at the start of the step, if friction laws are evaluated there; empty: they are evaluated at the
    /// speeds of the step's slips.
    pub lagged_speeds: Vec<f64>,
    /// Time step size, 0 at rest.
    pub dt: f64,
}

impl Conditions {
    /// Compliance of a constraint in an iteration; `compliance_ratio` is its requested ratio to the initial compliance.
    pub fn compliance_at(&self, row: usize, compliance_ratio: f64) -> f64 {
        let compliance = self.compliance[row];
        let is_large = compliance * self.stiffness[row] > tolerances::LARGE_COMPLIANCE;
        if is_large { compliance * compliance_ratio.max(tolerances::LEAST_REGULARIZATION_RATIO) } else { compliance }
    }

    /// Constraint of a pair at an iterate with the given gap and multiplier.
    pub fn row(&self, pair: &ContactPair, row: usize, gap: f64, lambda: f64) -> Row {
        Row {
            gap,
            lambda,
            gap_n: self.gap_n[row],
            target: self.targets[row],
            shift: self.shift[row],
            end_point: self.end_point,
            compliance: self.compliance[row],
            c: pair.c,
            stiffness: pair.penalty(row).unwrap_or(0.0),
            tolerance: pair.gap_tolerance,
        }
    }
}

impl<const D: usize> Equations<D> {
    /// Evaluates the friction coefficients of a step that starts at `q`; `time` is its middle.
    ///
    /// # Errors
    /// A function failed, or returned no coefficient.
    pub fn begin_friction(&mut self, time: f64, q: &[f64]) -> Result<(), StepError> {
        for pair in &mut self.pairs {
            let ContactPair { name, friction, kernel, .. } = pair;
            let Some(friction) = friction else { continue };
            let (nodes, stride) = (kernel.row_nodes(), kernel.rows_per_node());
            let place = |row: usize| {
                let mut point = [0.0; 3];
                if let Some(node) = nodes.get(row / stride).copied().or_else(|| kernel.shown_at(row, q)) {
                    point[..D].copy_from_slice(&q[node as usize * D..(node as usize + 1) * D]);
                }
                point
            };
            friction.begin_step(time, place).map_err(|source| StepError::Friction { contact: name.clone(), time, source })?;
        }
        Ok(())
    }

    /// Inverse augmentation of every constraint in a step, by the stiffness of the constraints.
    ///
    /// Nodes of a rigid body have more constraints than motions, and nodes at both sides of a periodic pair, or of a boundary that moves
    /// with a reference body, have one motion: their pressures are undetermined. From iteration to iteration, compliances `C_A` select
    /// those with the least `sum_A C_A lambda_A^2`. With `C_A` by area, a flat face has even pressures; by stiffness they would follow
    /// nodal masses.
    pub fn compliance(&self, stiffness: &[f64]) -> Vec<f64> {
        // A tangential constraint in the plane may coincide with the constraint of a symmetry plane or of a periodic pair.
        let has_couplings = self.pairs.iter().any(|pair| matches!(pair.kind, PairKind::Coupling(_)));
        let eases_all = D == 3 || has_couplings;
        // In a closed loop of joints that all stick, the distribution of the load is undetermined.
        let eases_slips = |pair: &ContactPair| pair.friction.is_some() && (eases_all || pair.kind == PairKind::JointFriction);
        if self.pairs.iter().all(|pair| pair.augmentation.is_none() && !eases_slips(pair)) {
            return vec![0.0; self.multipliers];
        }
        let mut compliance = stiffness.to_vec();
        for pair in &self.pairs {
            let rows = &mut compliance[pair.rows.clone()];
            rows.iter_mut().for_each(|row| *row = pair.augmentation.map_or(0.0, |factor| 1.0 / (factor * *row)));
        }
        self.copy_to_slips(&mut compliance);
        // Supports may prevent a slip in a direction oblique to both tangents.
        for pair in self.pairs.iter().filter(|pair| pair.augmentation.is_none() && eases_slips(pair)) {
            for (row, normal_row) in pair.tangential() {
                compliance[row] = 1.0 / (tolerances::CORNER_AUGMENTATION * stiffness[normal_row]);
            }
        }
        for pair in self.pairs.iter().filter(|pair| pair.has_multipliers() && !pair.kind.is_bilateral()) {
            let is_rigid = self.is_on_rigid_body(pair);
            let Some(factor) = pair.augmentation.filter(|_| is_rigid || has_couplings) else { continue };
            let weights = pair.kernel.weights();
            let of_area: f64 = pair.rows.clone().zip(weights).map(|(row, weight)| stiffness[row] * weight).sum();
            let is_limited = is_rigid && !self.touches_deformable(pair);
            let factor = if is_limited { factor.min(tolerances::RIGID_AUGMENTATION) } else { factor };
            let by_weight = pair.rows.len() as f64 / (factor * of_area);
            pair.rows.clone().zip(weights).for_each(|(row, weight)| compliance[row] = by_weight * weight);
            pair.tangential().for_each(|(row, normal_row)| compliance[row] = compliance[normal_row]);
        }
        compliance
    }

    /// True if the constraints of a contact belong to nodes of a rigid body.
    fn is_on_rigid_body(&self, pair: &ContactPair) -> bool {
        let node = pair.node_of(pair.rows.start);
        node.is_some_and(|node| self.bodies[self.body_of(node as usize)].rigid.is_some())
    }

    /// True if the primary side of a contact belongs to a deformable body. A fine rigid face on a coarse deformable one has nearly
    /// dependent constraints: with [`tolerances::RIGID_AUGMENTATION`] their gaps decrease by 1 % per iteration
    /// (`tests/scripts/rigid_friction_in_space.rhai`).
    fn touches_deformable(&self, pair: &ContactPair) -> bool {
        let contact = pair.corners.map_or(pair, |corners| &self.pairs[corners.pair]);
        let mut nodes = contact.kernel.primary().nodes().iter();
        nodes.any(|&node| self.bodies[self.body_of(node as usize)].rigid.is_none())
    }

    /// Stiffness of the node of every constraint, pressure per weighted gap: its elastic stiffness and its inertia in a step.
    pub fn row_stiffness(&self, start: &StepStart) -> Vec<f64> {
        let mut stiffness = Vec::with_capacity(self.multipliers);
        // The mass of a rigid body is that of the few nodes whose motion the others follow: the nodes of a contact share it instead.
        let mass_of = |body: &Body<D>| body.rigid.as_ref().map(|_| self.nodes.nodal_mass[body.nodes.clone()].iter().sum::<f64>());
        let masses: Vec<Option<f64>> = self.bodies.iter().map(mass_of).collect();
        for pair in &self.pairs {
            let (patches, mut of_elements) = (pair.kernel.patches(), vec![0.0f64; pair.rows.len()]);
            let inertia = |&node: &u32| {
                let body = self.body_of(node as usize);
                let share = masses[body].map(|mass| mass / pair.rows.len() as f64);
                start.inertia(body) * share.unwrap_or(self.nodes.lumped_mass[node as usize])
            };
            // Constraints of facets or edges accelerate the nodes of their contact elements.
            for p in (0..patches.len()).filter(|_| pair.kernel.row_nodes().is_empty()) {
                let heaviest = patches.nodes(p).iter().map(inertia).fold(0.0, f64::max);
                patches.rows(p).iter().for_each(|&row| of_elements[row as usize] = of_elements[row as usize].max(heaviest));
            }
            stiffness.extend(pair.rows.clone().zip(pair.kernel.weights()).zip(&of_elements).map(|((row, weight), of_elements)| {
                let own = pair.node_of(row);
                let carriers = pair.kernel.carriers(row - pair.rows.start);
                let of_nodes = own.as_slice().iter().chain(carriers).map(inertia).sum::<f64>();
                pair.c + of_nodes.max(*of_elements) / weight.powi(2)
            }));
        }
        stiffness.resize(self.multipliers, 0.0);
        self.copy_to_slips(&mut stiffness);
        stiffness
    }

    /// Copies the values of normal constraints to their tangential constraints.
    pub(super) fn copy_to_slips<T: Copy>(&self, values: &mut [T]) {
        self.pairs.iter().flat_map(ContactPair::tangential).for_each(|(row, normal_row)| values[row] = values[normal_row]);
    }

    /// Weighted gaps of active constraints: zero except for corners.
    pub fn closed_gaps(&self) -> Vec<f64> {
        let of = |pair: &ContactPair| -> Vec<f64> {
            let Some(corners) = pair.corners else { return vec![0.0; pair.kernel.weights().len()] };
            pair.kernel.weights().iter().zip(pair.kernel.slacks()).map(|(weight, slack)| -corners.slack * slack * weight).collect()
        };
        self.pairs.iter().flat_map(of).collect()
    }

    /// Weighted gaps of active constraints in a step that starts with the weighted gaps `gap_n`. Under a rule that keeps an overlap,
    /// corners admit the one that all surface constraints around them have, on which they would otherwise depend: after the impact of a
    /// flat face, all its edges and vertices.
    fn held_gaps(&self, gap_n: &[f64]) -> Vec<f64> {
        let mut held = self.closed_gaps();
        for pair in self.pairs.iter().filter(|pair| pair.update.holds == ActiveConstraints::AsItIs) {
            let Some(contact) = pair.corners.map(|corners| &self.pairs[corners.pair]) else { continue };
            if gap_n[contact.rows.clone()].iter().all(|&gap| gap >= 0.0) {
                continue;
            }
            let rows = contact.rows.clone().zip(contact.kernel.weights());
            let gaps: BTreeMap<u32, f64> = rows.filter_map(|(row, weight)| Some((contact.node_of(row)?, gap_n[row] / weight))).collect();
            let (patches, weights) = (pair.kernel.patches(), pair.kernel.weights());
            for p in 0..patches.len() {
                let around = patches.nodes(p).iter().filter_map(|node| gaps.get(node).copied());
                let admitted = around.reduce(f64::max).map_or(0.0, |gap| gap.min(0.0));
                for &row in patches.rows(p) {
                    held[pair.rows.start + row as usize] += admitted * weights[row as usize];
                }
            }
        }
        held
    }

    /// Contact conditions of the step that has begun, by the update rules; `penalty_gap`: weighted gaps in the penalty potentials at the
    /// end of the previous step, `active`: constraint states in that step.
    pub fn conditions(&self, start: &StepStart, penalty_gap: &[f64], active: &[RowState]) -> Conditions {
        let mut gap_n: Vec<f64> = self.pairs.iter().flat_map(|pair| pair.kernel.start_gap()).collect();
        gap_n.resize(self.multipliers, 0.0);
        let held = self.held_gaps(&gap_n);
        let mut targets = vec![0.0; gap_n.len()];
        let mut members: Vec<bool> = self.redundant.iter().map(|is_redundant| !is_redundant).collect();
        let mut shift = vec![0.0; gap_n.len()];
        let (end_point, reach) = (start.derivative() == Derivative::AT_END, largest_size(start.q_0));
        for pair in &self.pairs {
            let (closed, keeps) = (pair.closed, pair.update.holds == ActiveConstraints::AsItIs);
            // An active equation of a contact keeps its gap under a rule that keeps energy: weights of dual multipliers around an axis
            // follow the motion, so that the gap of the last step has another value now, and closing it would supply energy or take it.
            let follows = pair.update.keeps_energy && pair.law.is_bilateral() && !pair.kind.is_bilateral();
            // To close the round-off of the last positions at once takes or supplies multipliers times round-off, which is much where they
            // are large, as in stops and in short steps.
            let may_keep = pair.has_quadratic_functions() && pair.law.is_bilateral() && !pair.is_driven && !start.is_at_rest();
            let kept = if may_keep { ROUND_OFF * pair.gap_round_off(reach) } else { -1.0 };
            for row in pair.rows.clone() {
                let is_round_off = gap_n[row].abs() <= kept;
                let keeps = keeps || follows && active[row].is_closed() || is_round_off;
                let start = RowStart { gap: gap_n[row], penalty_gap: penalty_gap[row], held: held[row], closed, keeps, end_point };
                let demand = pair.law.demand(&start);
                (gap_n[row], targets[row], shift[row]) = (demand.gap, demand.target, demand.shift);
                if is_round_off {
                    targets[row] *= 1.0 - DECAY;
                }
                members[row] &= demand.is_member;
            }
        }
        self.copy_to_slips(&mut members);
        let stiffness = self.row_stiffness(start);
        for pair in self.pairs.iter().filter(|pair| pair.restitution.is_some()) {
            // Contacts between rigid sides that close in the step have the friction of their impact only.
            pair.tangential().for_each(|(row, normal_row)| members[row] &= gap_n[normal_row] <= held[normal_row] + pair.closed);
        }
        Conditions {
            gap_n,
            targets,
            members,
            compliance: self.compliance(&stiffness),
            end_point,
            shift,
            stiffness,
            stops: self.stops(active),
            lagged_speeds: Vec::new(),
            dt: start.dt(),
        }
    }

    /// Tangential constraints that may come to rest within a step, for the constraint states `active` of the previous one. A node that was
    /// open moves as those around it: if it had to stick throughout the step, a body at the end of its slip would turn about it.
    fn stops(&self, active: &[RowState]) -> Vec<bool> {
        let mut stops: Vec<bool> = active.iter().map(|state| state.slides()).collect();
        for pair in &self.pairs {
            let Some(friction) = &pair.friction else { continue };
            if friction.rows.clone().any(|row| active[row].slides()) {
                friction.rows.clone().for_each(|row| stops[row] |= active[row] == RowState::Open);
            }
        }
        stops
    }
}
