//! Newton's method of one step, with the contact conditions found together with the nonlinear equations.
//!
//! Semi-smooth Newton method: the active set is completed on the frozen linearization of each iteration before the geometry is evaluated
//! again; increments are limited to a tenth of a facet; nodes with a sliver of overlap are excluded from the step; convergence is decided
//! by the natural residual `min(lambda, c Phi)` and by the energy error, the work of the residual along the displacement in the step, not
//! by an unchanged set.

use super::anderson::Anderson;
use super::attempts::{ATTEMPTS, PER_NODE, PreferredAttempt, Strategy, usual_order};
use super::contact_set::{constraint_rows, drop_slivers, has_row, pairs_at, slips_at, starting_set, sticking_work, worst_violation};
use super::convergence::{Convergence, IterateDecision, Iteration};
use super::failure::Failure;
use super::iterate::Linearization;
use super::system::System;
use super::task::{Task, Trace};
use crate::bodies::{Elements, Space};
use crate::contact::Correction;
use crate::dynamics::model::step_error::StepError;
use crate::dynamics::parts::contact_pair::PairKind;
use crate::dynamics::parts::laws::RowState;
use crate::dynamics::parts::nodal::{add_force, add_moment};
use crate::integrators::{Derivative, LEAST_SQUARE};
use crate::math::norms::largest_size;
use crate::math::tolerances;

/// A converged step.
pub struct Solution {
    /// Linearization at the end of the step.
    pub at: Linearization,
    /// Contact state of every constraint.
    pub active: Vec<RowState>,
    /// The attempt that a later step tries first.
    pub preferred: PreferredAttempt,
}

impl Solution {
    /// Multipliers of the active constraints, 0 for others.
    pub fn multipliers(&self) -> Vec<f64> {
        self.at.lambda.iter().zip(&self.active).map(|(&lambda, row)| if row.acts() { lambda } else { 0.0 }).collect()
    }
}

/// Growth of the increment limit after a limited increment that confirmed the linearization.
const GROWTH: f64 = 4.0;
/// Largest increment limit relative to the first.
const LARGEST_LIMIT: f64 = 10.0;

/// Increment relative to the first limit beyond which the next linearization omits the geometric stiffness of contact forces; not at rest,
/// where no inertia compensates for it.
const FAR: f64 = 2.0;

/// Iterations with a constant active set at the end of a failed attempt after which another discrete gradient is tried before the step is
/// halved.
const SOME_ITERATIONS: usize = 4;

/// Iterations without a decrease of the energy that are admitted before a residual below round-off is accepted, with joints and rigid
/// bodies: their residuals are small from the first iterations on, while sticking friction of joints approaches its multiplier step by step
/// (`tests/scripts/joint_friction_in_space.rhai`).
const MOST_STALLS: usize = 3;

/// Energy that friction of sticking contacts may supply in a step, relative to the tolerance: a tenth of the admissible defect.
const STICKING: f64 = 10.0;

/// Fractions of an increment that backtracking tries.
const FRACTIONS: [f64; 4] = [1.0, 0.5, 0.25, 0.125];

/// Solves one step by the first attempt that converges; `iterations` counts those of all attempts, `trace` records them.
///
/// A step that may be halved has no further attempt if its contact conditions are violated by more than the tolerance.
///
/// # Errors
/// Failure of the last attempt.
pub fn solve<const D: usize>(system: &mut System<D>, task: &Task, iterations: &mut usize, trace: &mut Trace) -> Result<Solution, Failure>
where
    Space<D>: Elements<D>,
{
    trace.earlier.clear();
    let mut outcome = Err(Failure::Iterations);
    // The correction affects the discrete gradients of facet pairs only.
    let has_facets = system.pairs.iter().any(|pair| !pair.kind.is_of_points());
    let has_friction = system.pairs.iter().any(|pair| pair.friction.is_some());
    let is_corrected =
        task.start.derivative() == Derivative::DiscreteGradient && system.pairs.iter().any(|pair| pair.kind == PairKind::Surfaces);
    let usual = usual_order(D, has_facets && has_friction);
    let attempts = task.preferred.order(usual).filter(|&index| has_facets || ATTEMPTS[index].1 == Correction::default());
    for (number, index) in attempts.enumerate() {
        let ((strategy, correction), before) = (ATTEMPTS[index], system.counters.factorizations);
        if number > 0 {
            trace.earlier.push(std::mem::take(&mut trace.iterations));
        }
        system.equations.set_correction(correction);
        let is_accelerated = is_corrected && !has_friction && index == PER_NODE;
        outcome = attempt(system, task, strategy, is_accelerated, iterations, trace).map_err(|failure| failure.or_end(task.start.time));
        system.equations.set_correction(Correction::default());
        system.is_far = false;
        match &mut outcome {
            Ok(solution) => solution.preferred = task.preferred.after(index, usual),
            Err(_) => system.counters.discarded += system.counters.factorizations - before,
        }
        // A cell inverted by the first strategy is also inverted by the others.
        let is_inverted = number == 0 && matches!(outcome, Err(Failure::Inverted { .. }));
        // If vertices of both meshes coincide, another discrete gradient may avoid the kink that stops convergence. Steps with violated
        // contact conditions are rather halved.
        let is_far = !task.is_patient && trace.iterations.last().is_some_and(|last| last.violation > 1.0);
        // Kinks of nodes or edges that coincide stop convergence although the active set stays; with one correction per node they cancel.
        let is_set_constant = trace.iterations.iter().rev().take(SOME_ITERATIONS).all(|one| one.changed.is_empty());
        let may_be_kink = (D == 3 || is_corrected) && number == 0 && index != PER_NODE && is_set_constant;
        if system.multipliers == 0 || is_inverted || is_far && !may_be_kink || matches!(outcome, Ok(_) | Err(Failure::Fatal(_))) {
            break;
        }
    }
    outcome
}

/// Increment of the positions with the new multipliers.
pub(super) type Increment = (Vec<f64>, Vec<f64>);

/// Reduction of the tangential compliance of overconstrained nodes per iteration; a constant compliance needs tens of iterations.
const COMPLIANCE_REDUCTION: f64 = 4.0;

/// State of an attempt.
pub(super) struct Attempt<'a, const D: usize> {
    pub(super) system: &'a mut System<D>,
    pub(super) task: &'a Task<'a>,
    /// True for each constraint that is excluded from the step.
    pub(super) dropped: Vec<bool>,
    /// Active set of the last iteration.
    active: Vec<RowState>,
    /// Largest admitted component of an increment, at present and at the first iteration.
    limit: f64,
    first_limit: f64,
    /// Fraction of the last increment that was applied.
    taken: f64,
    /// Proximal term of the multipliers relative to the compliance of their nodes; `None` if an active set solved the last linearization
    /// without a proximal term.
    pub(super) proximal: Option<f64>,
    /// True if the active constraints of a linearization were linearly dependent: without a proximal term the matrix was singular.
    pub(super) is_dependent: bool,
    /// True if an active set solved the last linearization with a proximal term, which shortens the increment.
    pub(super) is_damped: bool,
    /// Tangential compliance of overconstrained nodes relative to its first value; decreases while the active set stays.
    pub(super) compliance_ratio: f64,
    /// Acceleration of iterations whose tangent omits derivatives: those of corrections shared by all pairs of a node. Not with friction,
    /// whose equations change from iteration to iteration.
    anderson: Option<Anderson>,
}

/// Solves one step with one strategy; `trace` records the iterations.
fn attempt<const D: usize>(
    system: &mut System<D>,
    task: &Task,
    strategy: Strategy,
    is_accelerated: bool,
    iterations: &mut usize,
    trace: &mut Trace,
) -> Result<Solution, Failure>
where
    Space<D>: Elements<D>,
{
    let u_1 = task.start.u_0.iter().zip(task.moved).map(|(u_0, moved)| u_0 + moved).collect();
    *trace = Trace { iterations: Vec::new(), u_1, earlier: std::mem::take(&mut trace.earlier) };
    let lambda: Vec<f64> =
        task.lambda.iter().zip(&task.conditions.members).map(|(&lambda, member)| if *member { lambda } else { 0.0 }).collect();
    let mut attempt = Attempt::new(system, task, strategy, is_accelerated);
    let mut convergence = Convergence::new(strategy.iterations(), task.is_patient, task.is_exact);
    let mut at = attempt.beginning(&lambda, iterations)?;
    for iteration in 0.. {
        if (task.interrupted)() {
            return Err(Failure::Fatal(StepError::Interrupted { time: task.start.time }));
        }
        if iteration > 0 {
            at = attempt.without_slivers(at)?;
        }
        let mut record = attempt.measure(&at);
        match convergence.judge(iteration, task.at_least, &record) {
            IterateDecision::Done => return Ok(attempt.solution(at)),
            IterateDecision::GivesUp => {
                record.active = attempt.active.iter().filter(|row| row.is_closed()).count();
                trace.iterations.push(record);
                break;
            }
            IterateDecision::GoesOn => {}
        }
        *iterations += 1;
        let (mut set, mut increment, mut new_lambda);
        set = starting_set(attempt.system, &at, task.conditions, &attempt.dropped);
        (increment, new_lambda) = match strategy {
            Strategy::InnerLoop => attempt.finish_set(&mut at, &mut set)?,
            Strategy::Backtracking => {
                let rows = constraint_rows(attempt.system, &at, task.conditions, &set, attempt.compliance_ratio, None);
                attempt.system.solve(task.start, &mut at, &rows)?
            }
        };
        record.changed = (0..set.len()).filter(|&row| set[row] != attempt.active[row]).collect();
        record.active = set.iter().filter(|row| row.is_closed()).count();
        attempt.compliance_ratio = if record.changed.is_empty() {
            (attempt.compliance_ratio / COMPLIANCE_REDUCTION).max(tolerances::LEAST_STICKING_COMPLIANCE_RATIO)
        } else {
            1.0
        };
        attempt.active = set;
        attempt.adapt_limit(trace.iterations.last(), &record);
        convergence.is_limited = attempt.is_damped || largest_size(&increment) > attempt.limit;
        attempt.accelerate(record.changed.is_empty() && !convergence.is_limited, &at.lambda, [&mut increment, &mut new_lambda]);
        trace.iterations.push(record);
        let searches = strategy == Strategy::Backtracking;
        at = attempt.moved(searches, at, &increment, &new_lambda, &mut trace.u_1)?;
    }
    Err(Failure::Iterations)
}

impl<'a, const D: usize> Attempt<'a, D>
where
    Space<D>: Elements<D>,
{
    fn new(system: &'a mut System<D>, task: &'a Task<'a>, strategy: Strategy, is_accelerated: bool) -> Self {
        let limit = match strategy {
            Strategy::InnerLoop => system.smallest_facet() * tolerances::STEP_LIMIT,
            Strategy::Backtracking => f64::INFINITY,
        };
        Attempt {
            dropped: task.conditions.members.iter().map(|member| !member).collect(),
            active: vec![RowState::Open; system.multipliers],
            limit,
            first_limit: limit,
            taken: 1.0,
            proximal: None,
            is_dependent: false,
            is_damped: false,
            compliance_ratio: 1.0,
            anderson: is_accelerated.then(Anderson::default),
            system,
            task,
        }
    }

    /// Accelerates an increment of positions and the new multipliers, which follow the positions, from the multipliers `lambda`.
    fn accelerate(&mut self, has_same_tangent: bool, lambda: &[f64], [increment, new_lambda]: [&mut [f64]; 2]) {
        let Some(anderson) = &mut self.anderson else { return };
        if has_same_tangent {
            anderson.accelerate_with_multipliers(lambda, increment, new_lambda);
        } else {
            anderson.clear();
        }
    }
}

impl<const D: usize> Attempt<'_, D>
where
    Space<D>: Elements<D>,
{
    /// Solution at an iterate. Penalty constraints are part of every active set: those without pressure count as inactive.
    fn solution(&self, at: Linearization) -> Solution {
        let mut active = starting_set(self.system, &at, self.task.conditions, &self.dropped);
        let normal = active.iter_mut().zip(&at.lambda).take(self.system.normal_count);
        normal.filter(|(_, lambda)| **lambda == 0.0).for_each(|(row, _)| *row = RowState::Open);
        let idle = slips_at(self.system, &at).filter(|place| !active[place.normal_row].is_closed());
        let idle: Vec<usize> = idle.flat_map(|place| place.rows).collect();
        idle.into_iter().for_each(|row| active[row] = RowState::Open);
        Solution { at, active, preferred: PreferredAttempt::default() }
    }

    /// First iterate: the predicted one. For a prescribed motion at rest: the solution of the linearization at the start under this motion,
    /// if it has a smaller merit, because a motion of the prescribed nodes alone crushes the adjacent cells.
    fn beginning(&mut self, lambda: &[f64], iterations: &mut usize) -> Result<Linearization, Failure> {
        let task = self.task;
        let predicted = self.system.linearize(task.start, task.predicted, task.moved, lambda);
        let is_moved = self.system.supports.prescribed.iter().any(|one| task.moved[one.unknown] != 0.0);
        if !task.start.is_at_rest() || !is_moved || matches!(predicted, Err(Failure::Fatal(_))) {
            return predicted;
        }
        *iterations += 1;
        match (self.led(lambda), predicted) {
            (Err(Failure::Fatal(error)), _) => Err(Failure::Fatal(error)),
            (Ok(led), Ok(predicted)) if self.merit(&led) <= self.merit(&predicted) => {
                self.system.recycle(predicted);
                Ok(led)
            }
            (Ok(led), Err(_)) => Ok(led),
            (_, predicted) => predicted,
        }
    }

    /// Start of the step, displaced by the solution of its linearization under the prescribed motion.
    fn led(&mut self, lambda: &[f64]) -> Result<Linearization, Failure> {
        let (task, unknowns) = (self.task, self.task.moved.len());
        let mut at = self.system.linearize(task.start, task.start.q_0, &vec![0.0; unknowns], lambda)?;
        let mut given = vec![0.0; unknowns + self.system.multipliers];
        self.system.supports.prescribed.iter().for_each(|one| given[one.unknown] = task.moved[one.unknown]);
        self.system.given = given;
        let mut set = starting_set(self.system, &at, task.conditions, &self.dropped);
        let solved = self.finish_set(&mut at, &mut set);
        self.system.given.clear();
        let (mut moved, lambda) = solved?;
        let mut q_1: Vec<f64> = task.start.q_0.iter().zip(&moved).map(|(q, moved)| q + moved).collect();
        for one in &self.system.supports.prescribed {
            (q_1[one.unknown], moved[one.unknown]) = (task.predicted[one.unknown], task.moved[one.unknown]);
        }
        self.system.recycle(at);
        self.system.linearize(task.start, &q_1, &moved, &lambda)
    }

    /// Returns the iterate without constraints of nodes that have a sliver of overlap; forces are evaluated again if multipliers are
    /// dropped.
    fn without_slivers(&mut self, at: Linearization) -> Result<Linearization, Failure> {
        let mut lambda = at.lambda.clone();
        if !drop_slivers(self.system, &at, &mut self.dropped, &mut lambda) {
            return Ok(at);
        }
        let (q_1, moved) = (at.q_1.clone(), at.moved.clone());
        self.system.recycle(at);
        self.system.linearize(self.task.start, &q_1, &moved, &lambda)
    }

    /// Increases the limit of increments if the last limited increment, the fraction `f` of the whole, reduced residual and violation to at
    /// most `1 - f/2`; otherwise decreases it.
    fn adapt_limit(&mut self, last: Option<&Iteration>, now: &Iteration) {
        let Some(last) = last.filter(|_| self.taken < 1.0) else { return };
        let expected = 1.0 - 0.5 * self.taken;
        let is_right = now.residual <= expected * last.residual && now.violation <= expected * last.violation;
        let limit = if is_right { self.limit * GROWTH } else { self.limit / GROWTH };
        self.limit = limit.clamp(self.first_limit, LARGEST_LIMIT * self.first_limit);
    }

    /// Next iterate, by the limited increment or the fraction that backtracking finds; `u_1` receives its displacements even if forces
    /// cannot be computed.
    fn moved(
        &mut self,
        searches: bool,
        at: Linearization,
        increment: &[f64],
        lambda: &[f64],
        u_1: &mut Vec<f64>,
    ) -> Result<Linearization, Failure> {
        let largest = largest_size(increment);
        if !largest.is_finite() {
            return Err(Failure::Diverged);
        }
        let moved_to = |at: &Linearization, alpha: f64| -> [Vec<f64>; 3] {
            let by_increment = |values: &[f64]| values.iter().zip(increment).map(|(q, d)| q + alpha * d).collect();
            let multipliers = at.lambda.iter().zip(lambda).map(|(old, new)| old + alpha * (new - old)).collect();
            [by_increment(&at.q_1), by_increment(&at.moved), multipliers]
        };
        let first = if largest > self.limit { self.limit / largest } else { 1.0 };
        let is_kept = self.task.is_patient || self.task.start.is_at_rest();
        (self.taken, self.system.is_far) = (first, !is_kept && largest > FAR * self.first_limit);
        if !searches {
            let [q_1, moved, lambda] = moved_to(&at, first);
            self.system.recycle(at);
            u_1.clear();
            u_1.extend(self.task.start.u_0.iter().zip(&moved).map(|(u_0, moved)| u_0 + moved));
            return self.system.linearize(self.task.start, &q_1, &moved, &lambda);
        }
        let merit_before = self.merit(&at);
        let mut best: Option<(f64, Linearization)> = None;
        let mut refused = None;
        for alpha in FRACTIONS.map(|fraction| first * fraction) {
            let [q_1, moved, lambda] = moved_to(&at, alpha);
            let trial = match self.system.linearize(self.task.start, &q_1, &moved, &lambda) {
                Ok(trial) => trial,
                Err(failure) => {
                    refused = Some(failure);
                    continue;
                }
            };
            let merit = self.merit(&trial);
            let worse =
                if best.as_ref().is_none_or(|(least, _)| merit < *least) { best.replace((merit, trial)) } else { Some((merit, trial)) };
            worse.into_iter().for_each(|(_, trial)| self.system.recycle(trial));
            if merit < merit_before {
                break;
            }
        }
        let (_, best) = best.ok_or_else(|| refused.unwrap_or(Failure::Diverged))?;
        self.system.recycle(at);
        u_1.clone_from(&best.u_1);
        Ok(best)
    }

    /// Residual, violation, energy and tolerances of an iterate.
    fn measure(&self, at: &Linearization) -> Iteration {
        let (system, task, forces) = (&*self.system, self.task, &at.forces);
        let mut record = Iteration::default();
        let mut work = 0.0;
        let (mut resultant, mut turning) = ([0.0; 3], [0.0; 3]);
        // One pass over the nodes, because long vectors do not fit into the cache.
        for node in 0..at.q_1.len() / D {
            let mut unbalanced = [0.0; D];
            for i in 0..D {
                let k = node * D + i;
                if system.supports.fixed[k] {
                    continue;
                }
                let r = forces.without_contact[k] - forces.contact[k];
                unbalanced[i] = r;
                if r.abs() > record.residual {
                    (record.residual, record.worst) = (r.abs(), k);
                }
                work += r * at.moved[k];
            }
            add_force(&mut resultant, &unbalanced);
            add_moment(&mut turning, &at.q_1[node * D..][..D], &unbalanced);
        }
        // Energy of the momentum change by the residual, at the speed of a model with the reference energy.
        let size = |vector: [f64; 3]| vector.iter().map(|x| x * x).sum::<f64>().sqrt();
        let kick = size(resultant) + size(turning) / system.nodes.extent;
        let momentum = tolerances::NEWTON_MOMENTUM * task.start.dt().abs() * kick * (2.0 * task.energy / system.nodes.total_mass).sqrt();
        // Round-off of the displacements at both ends, and of positions if forces depend on them, times stiffness, plus round-off of the
        // motion times inertia.
        let least = f64::MIN_POSITIVE.sqrt() * system.nodes.extent;
        let of_positions = if system.depends_on_positions() { largest_size(&at.q_1).max(system.nodes.extent) } else { least };
        let moved = largest_size(&at.moved);
        let reach = largest_size(&at.u_1).max(moved).max(of_positions);
        let inertia = (0..system.bodies.len()).map(|body| task.start.inertia(body)).fold(0.0, f64::max);
        let (stiffness, mass) = (system.nodes.stiffness(), system.nodes.largest_nodal_mass);
        record.floor = tolerances::FORCE_FLOOR * (stiffness * reach + inertia * mass * moved);
        record.stalls = if system.has_point_constraints() { MOST_STALLS } else { 1 };
        record.enough = if task.start.is_at_rest() && system.has_rigid_bodies() {
            (tolerances::REST_STEP * forces.opposing).max(tolerances::REST_STEP * tolerances::BALANCE * forces.scale)
        } else {
            0.0
        };
        record.target = (tolerances::NEWTON_FORCE * forces.scale).max(record.floor);
        let contact_work;
        (record.violation, record.worst_row, contact_work) = worst_violation(system, at, task.conditions, &self.dropped);
        let small = (task.tolerance * task.energy.max(forces.internal_work.abs())).max(LEAST_SQUARE);
        let [of_joints, of_contacts] = sticking_work(system, at, &self.active);
        let sticking = of_joints + (of_contacts - STICKING * small).max(0.0);
        record.energy = momentum.max(work.abs() + contact_work.abs() + sticking) / small;
        if task.is_still {
            let free = forces.contact.iter().zip(&system.supports.fixed).filter(|(_, is_fixed)| !**is_fixed);
            let contact_forces: f64 = free.map(|(force, _)| force.abs()).sum();
            let positions = largest_size(&at.q_1).max(system.nodes.extent);
            record.round_off = tolerances::CONTACT_ROUND_OFF * contact_forces * positions / small;
        }
        record
    }

    /// Size of residual and contact violation, for the line search: forces and multipliers times facet size.
    fn merit(&self, at: &Linearization) -> f64 {
        let mut sum = 0.0;
        for (k, (r, c)) in at.forces.without_contact.iter().zip(&at.forces.contact).enumerate() {
            if !self.system.supports.fixed[k] {
                sum += (r - c) * (r - c);
            }
        }
        for (pair, evaluation) in pairs_at(self.system, at) {
            let size = pair.kernel.facet_size();
            for row in pair.rows.clone() {
                let local = row - pair.rows.start;
                if self.dropped[row] || !has_row(pair, evaluation, local) {
                    continue;
                }
                let natural =
                    size * pair.c * pair.law.residual(&self.task.conditions.row(pair, row, evaluation.gap[local], at.lambda[row])).0;
                sum += natural * natural;
            }
        }
        for place in slips_at(self.system, at).filter(|place| place.exists && !self.dropped[place.rows.start]) {
            let natural = place.pair.kernel.facet_size() * place.pair.c * place.at(self.task.conditions, at).residual().0;
            sum += natural * natural;
        }
        sum.sqrt()
    }
}
