//! Newton's method of one step, with the contact conditions found together with the nonlinear equations.
//!
//! Semi-smooth Newton: the set of active nodes is finished on the frozen linearisation of each iteration before the geometry is evaluated
//! again; increments are limited to a tenth of a facet; nodes with a sliver of overlap sit out the step; convergence is decided by the
//! natural residual `min(lambda, c Phi)` and by the energy that the residual can still move, not by an unchanged set.

use super::error::StepError;
use super::pairs::{Conditions, LargeMotion, Pair};
use super::system::{AssemblyError, ConstraintRows, Forces, StepStart, System, add_force, add_moment};
use crate::bodies::{Elements, Inverted, Space};
use crate::linear::LinearError;
use crate::math::norms::largest_size;
use crate::math::tolerances;

/// A converged step.
pub(super) struct Solution {
    pub(super) q_1: Vec<f64>,
    pub(super) lambda: Vec<f64>,
    pub(super) active: Vec<bool>,
    pub(super) forces: Forces,
    pub(super) iterations: usize,
}

/// The course of Newton's method, kept for the report of a failure.
#[derive(Clone, Debug, Default)]
pub(super) struct Trace {
    pub(super) iterations: Vec<Iteration>,
    /// The last iterate.
    pub(super) q_1: Vec<f64>,
    /// The iterations of strategies that were tried before.
    pub(super) earlier: Vec<Vec<Iteration>>,
}

/// What an iteration looked like.
#[derive(Clone, Debug, Default)]
pub(super) struct Iteration {
    /// Largest component of the residual and its unknown.
    pub(super) residual: f64,
    pub(super) worst: usize,
    /// Force by which residuals are judged in this iteration.
    pub(super) target: f64,
    /// Round-off of the forces: a residual below it cannot be trusted to fall.
    pub(super) floor: f64,
    /// Energy that the residual can still move, over what is tolerated.
    pub(super) energy: f64,
    /// Largest violation of the contact conditions over what is tolerated, and its constraint.
    pub(super) violation: f64,
    pub(super) worst_row: usize,
    /// Constraints whose contact state changed.
    pub(super) changed: Vec<usize>,
    /// Active contact nodes.
    pub(super) active: usize,
}

/// Why a step did not converge.
pub(super) enum Failure {
    /// Too many iterations.
    Iterations,
    Inverted {
        body: String,
        inverted: Inverted,
    },
    Linear(LinearError),
    /// The iterate left the range of numbers.
    Diverged,
    /// Bodies moved farther than the candidate pairs reach.
    BeyondSearch {
        pair: String,
    },
    /// Something that took no part in the step, since it was not expected to close, overlaps at its end.
    Overlooked {
        pair: String,
    },
    /// The predicted motion is too large: the step was not tried.
    Foreseen(LargeMotion),
    /// Not a matter of the numerics: do not try again.
    Fatal(StepError),
}

impl Failure {
    /// What was seen, in two words.
    pub(super) fn name(&self) -> &'static str {
        match self {
            Failure::Iterations => "iterations used up",
            Failure::Inverted { .. } => "inverted cell",
            Failure::Linear(_) => "singular system",
            Failure::Diverged => "divergence",
            Failure::Foreseen(_) | Failure::BeyondSearch { .. } | Failure::Overlooked { .. } => "motion too fast",
            Failure::Fatal(_) => "given up",
        }
    }
}

impl From<AssemblyError> for Failure {
    fn from(error: AssemblyError) -> Self {
        match error {
            AssemblyError::Inverted { body, inverted } => Failure::Inverted { body, inverted },
            AssemblyError::Load(error) => Failure::Fatal(error),
            AssemblyError::NotFinite => Failure::Diverged,
        }
    }
}

impl Failure {
    /// The same, or the end of the run where a factorisation was interrupted.
    pub(super) fn or_interrupt(self, time: f64) -> Self {
        match self {
            Failure::Linear(LinearError::Interrupted) => Failure::Fatal(StepError::Interrupted { time }),
            failure => failure,
        }
    }
}

/// How Newton's method proceeds.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Strategy {
    /// Set finished on the frozen linearisation, increments limited.
    InnerLoop,
    /// One set update per iteration, backtracking on the residual: for what the first did not solve.
    Backtracking,
}

/// Where Newton's method starts and when it is done.
pub(super) struct Task<'a> {
    pub(super) start: &'a StepStart<'a>,
    pub(super) predicted: &'a [f64],
    pub(super) lambda: &'a [f64],
    pub(super) conditions: &'a Conditions,
    pub(super) energy: f64,
    pub(super) tolerance: f64,
    /// Iterations before it may be done: a step that starts at its own solution moves no energy, whatever its residual.
    pub(super) at_least: usize,
    pub(super) interrupted: &'a dyn Fn() -> bool,
}

const MAX_ITERATIONS: usize = 25;
const MAX_BACKTRACKING_ITERATIONS: usize = 40;
const MAX_INNER: usize = 20;

/// The members of the contact sets and the multipliers of one iterate.
struct Contacts {
    /// Nodes that sit out the step.
    dropped: Vec<bool>,
    active: Vec<bool>,
}

/// Solves one step; `trace` tells its course.
pub(super) fn solve<const D: usize>(system: &mut System<D>, task: &Task, strategy: Strategy, trace: &mut Trace) -> Result<Solution, Failure>
where
    Space<D>: Elements<D>,
{
    let start = task.start;
    *trace = Trace { iterations: Vec::new(), q_1: task.predicted.to_vec(), earlier: std::mem::take(&mut trace.earlier) };
    let Trace { iterations: history, q_1, .. } = trace;
    let mut lambda = task.lambda.to_vec();
    let conditions = task.conditions;
    let dropped = conditions.members.iter().map(|member| !member).collect();
    let mut contacts = Contacts { dropped, active: vec![false; system.multipliers] };
    for (lambda, _) in lambda.iter_mut().zip(&conditions.members).filter(|(_, member)| !**member) {
        *lambda = 0.0;
    }
    let limit = system.pairs.iter().map(|pair| pair.kernel.facet_size()).fold(f64::INFINITY, f64::min) * tolerances::STEP_LIMIT;
    let mut last_energy = f64::INFINITY;
    let iterations = if strategy == Strategy::InnerLoop { MAX_ITERATIONS } else { MAX_BACKTRACKING_ITERATIONS };
    let mut forces = system.assemble(start, q_1, &lambda)?;
    for iteration in 0..=iterations {
        if (task.interrupted)() {
            return Err(Failure::Fatal(StepError::Interrupted { time: start.time }));
        }
        if iteration > 0 && drop_slivers(system, &mut contacts.dropped, &mut lambda) {
            // Their multipliers are gone, so the forces changed.
            forces = system.assemble(start, q_1, &lambda)?;
        }
        let (mut record, moved) = measure(system, task, &forces, q_1, &lambda, &contacts.dropped);
        let converged_force = record.residual <= record.target;
        let small = task.tolerance * task.energy.max(forces.internal_work.abs());
        record.energy = moved / small;
        // Round-off: the energy no longer falls although everything else has converged.
        let stalled = (moved <= 100.0 * small || record.residual <= record.floor) && moved > 0.5 * last_energy;
        if iteration >= task.at_least && converged_force && record.violation <= 1.0 && (moved <= small || stalled) {
            // With a penalty every covered node is in the system: in contact are those that press.
            let mut active = starting_set(system, conditions, &lambda, &contacts.dropped);
            active.iter_mut().zip(&lambda).for_each(|(active, lambda)| *active &= *lambda != 0.0);
            return Ok(Solution { q_1: q_1.clone(), lambda, active, forces, iterations: iteration });
        }
        last_energy = moved;
        if iteration == iterations {
            record.active = contacts.active.iter().filter(|active| **active).count();
            history.push(record);
            break;
        }

        let mut set = starting_set(system, conditions, &lambda, &contacts.dropped);
        let (increment, new_lambda) = match strategy {
            Strategy::InnerLoop => inner_loop(system, &forces, conditions, &lambda, &mut set, &contacts.dropped)?,
            Strategy::Backtracking => {
                let rows = constraint_rows(system, conditions, &lambda, &set);
                system.solve(&forces, &rows).map_err(Failure::Linear)?
            }
        };
        record.changed = (0..set.len()).filter(|&row| set[row] != contacts.active[row]).collect();
        record.active = set.iter().filter(|active| **active).count();
        contacts.active = set;
        history.push(record);
        let largest = largest_size(&increment);
        if !largest.is_finite() {
            return Err(Failure::Diverged);
        }
        let moved_to = |alpha: f64| -> (Vec<f64>, Vec<f64>) {
            (
                q_1.iter().zip(&increment).map(|(q, d)| q + alpha * d).collect(),
                lambda.iter().zip(&new_lambda).map(|(old, new)| old + alpha * (new - old)).collect(),
            )
        };
        match strategy {
            Strategy::InnerLoop => {
                let alpha = if largest > limit { limit / largest } else { 1.0 };
                q_1.iter_mut().zip(&increment).for_each(|(q, d)| *q += alpha * d);
                lambda.iter_mut().zip(&new_lambda).for_each(|(old, new)| *old += alpha * (new - *old));
                forces = system.assemble(start, q_1, &lambda)?;
            }
            Strategy::Backtracking => {
                let merit_before = merit(system, &forces, conditions, &lambda, &contacts.dropped);
                let mut best: Option<(f64, f64)> = None;
                let mut refused = None;
                for alpha in [1.0, 0.5, 0.25, 0.125] {
                    let (q, l) = moved_to(alpha);
                    let trial = match system.assemble(start, &q, &l) {
                        Ok(trial) => trial,
                        Err(error) => {
                            refused = Some(error);
                            continue;
                        }
                    };
                    let value = merit(system, &trial, conditions, &l, &contacts.dropped);
                    if best.is_none_or(|(least, _)| value < least) {
                        best = Some((value, alpha));
                    }
                    if value < merit_before {
                        break;
                    }
                }
                let (_, alpha) = best.ok_or_else(|| refused.map_or(Failure::Diverged, Failure::from))?;
                (*q_1, lambda) = moved_to(alpha);
                forces = system.assemble(start, q_1, &lambda)?;
            }
        }
    }
    Err(Failure::Iterations)
}

/// Whether constraint `row` of a pair can hold at all at this iterate: its node has an overlap. A penalty potential always counts.
fn has_row(pair: &Pair, row: usize) -> bool {
    pair.penalty > 0.0 || pair.evaluation.coverage[row] > tolerances::ZERO_ROW
}

/// Takes nodes with a sliver of overlap out of the step; returns whether a multiplier was lost.
fn drop_slivers<const D: usize>(system: &System<D>, dropped: &mut [bool], lambda: &mut [f64]) -> bool {
    let mut lost = false;
    for pair in system.pairs.iter().filter(|pair| pair.penalty == 0.0) {
        for row in pair.rows.clone() {
            let covered = pair.evaluation.coverage[row - pair.rows.start];
            if !dropped[row] && covered > 0.0 && covered < tolerances::SLIVER {
                dropped[row] = true;
                lost |= lambda[row] != 0.0;
                lambda[row] = 0.0;
            }
        }
    }
    lost
}

/// The iterate in numbers, and the energy that its residual can still move.
fn measure<const D: usize>(
    system: &System<D>,
    task: &Task,
    forces: &Forces,
    q_1: &[f64],
    lambda: &[f64],
    dropped: &[bool],
) -> (Iteration, f64)
where
    Space<D>: Elements<D>,
{
    let mut record = Iteration::default();
    let mut work = 0.0;
    let (mut resultant, mut turning) = ([0.0; 3], [0.0; 3]);
    // One pass over the nodes: long vectors are not read twice.
    for node in 0..q_1.len() / D {
        let mut unbalanced = [0.0; D];
        for i in 0..D {
            let k = node * D + i;
            if system.fixed[k] {
                continue;
            }
            let r = forces.without_contact[k] - forces.contact[k];
            unbalanced[i] = r;
            if r.abs() > record.residual {
                (record.residual, record.worst) = (r.abs(), k);
            }
            work += r * (q_1[k] - task.start.q_0[k]);
        }
        add_force(&mut resultant, &unbalanced);
        add_moment(&mut turning, &q_1[node * D..][..D], &unbalanced);
    }
    // Momenta that the residual gives, as an energy at the speed that the energy stands for.
    let size = |vector: [f64; 3]| vector.iter().map(|x| x * x).sum::<f64>().sqrt();
    let kick = size(resultant) + size(turning) / system.extent;
    let momentum = tolerances::NEWTON_MOMENTUM * task.start.dt * kick * (2.0 * task.energy / system.total_mass).sqrt();
    // Positions carry round-off in proportion to their size; stiffness and inertia turn it into force.
    let reach = largest_size(q_1).max(system.extent);
    let inertia = (0..system.bodies.len()).map(|body| task.start.inertia(body)).fold(0.0, f64::max);
    let stiffness = system.modulus * system.extent.powi(D as i32 - 2) + inertia * system.largest_nodal_mass;
    record.floor = tolerances::FORCE_FLOOR * stiffness * reach;
    record.target = (tolerances::NEWTON_FORCE * forces.scale).max(record.floor);
    let contact_work;
    (record.violation, record.worst_row, contact_work) = worst_violation(system, task.conditions, lambda, dropped);
    (record, momentum.max(work.abs() + contact_work.abs()))
}

/// The largest violation of the contact conditions over what is tolerated, its constraint, and the energy of all violations.
fn worst_violation<const D: usize>(system: &System<D>, conditions: &Conditions, lambda: &[f64], dropped: &[bool]) -> (f64, usize, f64) {
    let (mut worst, mut worst_row, mut work) = (0.0, 0, 0.0);
    for pair in &system.pairs {
        for row in pair.rows.clone().filter(|&row| !dropped[row]) {
            // A node that has come to lie opposite nothing must not keep its multiplier: the force would have no function.
            let (natural, energy) = if has_row(pair, row - pair.rows.start) {
                violation(pair, conditions, row, lambda[row])
            } else {
                (lambda[row] / pair.c, lambda[row] * conditions.gap_n[row])
            };
            let violation = natural.abs() / pair.gap_tolerance;
            if violation > worst {
                (worst, worst_row) = (violation, row);
            }
            work += energy;
        }
    }
    (worst, worst_row, work)
}

/// Whether the iterate of the last assembly meets the contact conditions.
pub(super) fn meets<const D: usize>(system: &System<D>, conditions: &Conditions, lambda: &[f64]) -> bool {
    let (mut dropped, mut kept) = (vec![false; lambda.len()], lambda.to_vec());
    !drop_slivers(system, &mut dropped, &mut kept) && worst_violation(system, conditions, lambda, &dropped).0 <= 1.0
}

/// The set that an iteration begins with: pressed nodes and nodes that overlap.
fn starting_set<const D: usize>(system: &System<D>, conditions: &Conditions, lambda: &[f64], dropped: &[bool]) -> Vec<bool> {
    let mut set = vec![false; system.multipliers];
    for pair in &system.pairs {
        for row in pair.rows.clone() {
            let local = row - pair.rows.start;
            let pressed =
                pair.equality || pair.penalty > 0.0 || lambda[row] - pair.c * (pair.evaluation.gap[local] - conditions.targets[row]) > 0.0;
            set[row] = pressed && !dropped[row] && has_row(pair, local);
        }
    }
    set
}

/// The constraint rows for a set of active nodes.
fn constraint_rows<const D: usize>(system: &System<D>, conditions: &Conditions, lambda: &[f64], set: &[bool]) -> ConstraintRows {
    let mut rows = ConstraintRows { gradient: set.to_vec(), diagonal: vec![1.0; system.multipliers], right: vec![0.0; system.multipliers] };
    for pair in &system.pairs {
        for row in pair.rows.clone().filter(|&row| set[row]) {
            let gap = pair.evaluation.gap[row - pair.rows.start];
            if pair.penalty == 0.0 {
                let compliance = conditions.compliance[row];
                (rows.diagonal[row], rows.right[row]) = (compliance, conditions.targets[row] - gap + compliance * lambda[row]);
                continue;
            }
            // lambda = p(Phi_1 + G_1 dq), divided by the slope so that all rows are of one size.
            let (pressure, slope) = conditions.penalty_pressure(pair, row, gap);
            rows.gradient[row] = slope != 0.0;
            if slope != 0.0 {
                (rows.diagonal[row], rows.right[row]) = (-1.0 / slope, -pressure / slope);
            }
        }
    }
    rows
}

/// By how much an iterate violates the condition of a constraint, as a weighted gap, and the energy that goes with it.
fn violation(pair: &Pair, conditions: &Conditions, row: usize, lambda: f64) -> (f64, f64) {
    let gap = pair.evaluation.gap[row - pair.rows.start];
    if pair.penalty > 0.0 {
        let off = lambda - conditions.penalty_pressure(pair, row, gap).0;
        return (off / pair.c, off * (gap + conditions.shift[row] - conditions.gap_n[row]));
    }
    let gap = gap - conditions.targets[row];
    (if pair.equality { gap } else { gap.min(lambda / pair.c) }, lambda * gap)
}

/// Finishes the set on the frozen linearisation: active nodes that pull leave, inactive nodes that would overlap enter.
fn inner_loop<const D: usize>(
    system: &mut System<D>,
    forces: &Forces,
    conditions: &Conditions,
    lambda: &[f64],
    set: &mut Vec<bool>,
    dropped: &[bool],
) -> Result<(Vec<f64>, Vec<f64>), Failure>
where
    Space<D>: Elements<D>,
{
    let mut seen = vec![set.clone()];
    let mut one_at_a_time = false;
    for inner in 0..MAX_INNER {
        let rows = constraint_rows(system, conditions, lambda, set);
        let (increment, new_lambda) = system.solve(forces, &rows).map_err(Failure::Linear)?;
        let gaps = system.linearized_gaps(&increment);
        let mut next = set.clone();
        let mut worst = (0.0, usize::MAX);
        for pair in system.pairs.iter().filter(|pair| !pair.equality && pair.penalty == 0.0) {
            for row in pair.rows.clone().filter(|&row| !dropped[row] && has_row(pair, row - pair.rows.start)) {
                let violation =
                    if set[row] { -new_lambda[row] / pair.c } else { conditions.targets[row] - gaps[row] - 1e-3 * pair.gap_tolerance };
                if violation > 0.0 || (set[row] && new_lambda[row] <= 0.0) {
                    next[row] = !set[row];
                    if violation > worst.0 {
                        worst = (violation, row);
                    }
                }
            }
        }
        if next == *set || inner + 1 == MAX_INNER {
            return Ok((increment, new_lambda));
        }
        one_at_a_time |= seen.contains(&next);
        if one_at_a_time {
            next = set.clone();
            if worst.1 == usize::MAX {
                return Ok((increment, new_lambda));
            }
            next[worst.1] = !set[worst.1];
            if seen.contains(&next) {
                return Ok((increment, new_lambda));
            }
        }
        seen.push(next.clone());
        *set = next;
    }
    unreachable!("the last pass returns")
}

/// Size of residual and contact violation, for the line search: forces and multipliers times facet size.
fn merit<const D: usize>(system: &System<D>, forces: &Forces, conditions: &Conditions, lambda: &[f64], dropped: &[bool]) -> f64 {
    let mut sum = 0.0;
    for (k, (r, c)) in forces.without_contact.iter().zip(&forces.contact).enumerate() {
        if !system.fixed[k] {
            sum += (r - c) * (r - c);
        }
    }
    for pair in &system.pairs {
        let size = pair.kernel.facet_size();
        for row in pair.rows.clone().filter(|&row| !dropped[row] && has_row(pair, row - pair.rows.start)) {
            let natural = size * pair.c * violation(pair, conditions, row, lambda[row]).0;
            sum += natural * natural;
        }
    }
    sum.sqrt()
}
