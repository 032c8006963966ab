//! `settle`: equilibrium under the loads of the present time, by damped steps without inertia.
//!
//! A step solves `K(q_1) + mu M (q_1 - q_0) = 0` with the contact conditions. Each body has its own damping `mu`: as much as its unbalanced
//! resultant and torque need so that nothing loose moves by more than half a facet, and never less than a trifle of its own stiffness, so that
//! rigid motions stay regular. As the forces come to balance the damping goes with them, and so does the error that it leaves
//! (pseudo-transient continuation; Kelley and Keyes, SIAM J. Numer. Anal. 35, 1998). The end is judged by `balance.rs`, where damping does
//! not count as a force. Does not follow a path: which of several equilibria is found is not promised.

use std::sync::Arc;

use super::balance::{Balance, Imbalance};
use super::error::StepError;
use super::newton::{self, Failure, Solution, Task};
use super::pairs::Conditions;
use super::predictor;
use super::report::{FailureCause, Missing};
use super::simulation::{Clock, SettleReport, State};
use super::system::{Forces, StepStart};
use super::time_loop::{TimeLoop, solve};
use crate::bodies::{Elements, Space};
use crate::integrators::Integrator;
use crate::math::norms::largest_size;
use crate::math::tolerances;

/// Damped steps that `settle` takes at most.
const MAX_STEPS: usize = 100;

/// Least damping of a body over the stiffness of its slowest elastic motion.
const LEAST_DAMPING: f64 = 1e-8;

/// What a loose body may move in a step, in facets: more, and Newton's method does not follow contacts that close on the way.
const FALL: f64 = 0.5;

/// Growth of the damping after a step that failed, and how often in a row.
const MORE_DAMPING: f64 = 100.0;
const MAX_TRIES: usize = 5;

/// Motion in a step, in facets, below which a body is not expected to move in the next one.
const STANDS: f64 = 1e-3;

/// How often a body may be expected to move farther than in the step before: pairs that take part only while bodies move must not keep them
/// moving.
const MAX_WIDENINGS: usize = 20;

/// Distance from where it began, in extents of the model, at which a body has left for good.
const GONE: f64 = 1e3;

/// What the next step is expected to do, from the steps before.
struct Course {
    /// How much more damping than the forces ask for.
    excess: f64,
    /// Failures in a row.
    tries: usize,
    /// Largest motion of each piece in the last step.
    last: Option<Vec<f64>>,
    widenings: usize,
}

/// A damped step as it is planned.
struct Plan {
    /// Damping of each body.
    damping: Vec<f64>,
    /// Displacement with which Newton's method starts, of each piece.
    shift: Vec<[f64; 3]>,
    /// How far the nodes of each piece are expected to move at most.
    travel: Vec<f64>,
}

impl<const D: usize> TimeLoop<D>
where
    Space<D>: Elements<D>,
{
    /// Equilibrium at a time: that of the state, or a later one, to which the model goes without inertia.
    pub(super) fn settle_at(&mut self, time: f64) -> Result<SettleReport, StepError> {
        if time != self.state.row.time {
            let state = Arc::make_mut(&mut self.state);
            state.row.time = time;
            state.clock = Clock { origin: time, count: 0, dt: self.options.dt };
        }
        self.settle_from_here()
    }

    fn settle_from_here(&mut self) -> Result<SettleReport, StepError> {
        self.tries.clear();
        let iterations_before = self.statistics.newton_iterations;
        let balance = Balance::new(&self.system, &self.model);
        let begun = self.state.positions.clone();
        let mut course = Course { excess: 1.0, tries: 0, last: None, widenings: 0 };
        let mut motion = vec![0.0; begun.len()];
        let mut best: Option<(Arc<State>, f64)> = None;
        let mut steps = 0;
        loop {
            let positions = self.state.positions.clone();
            let time = self.state.row.time;
            let (displacement, _) = self.system.prescribed_motion(time)?;
            let mut predicted = positions.clone();
            predictor::follow_prescribed(&self.system, &positions, &displacement, &mut predicted);
            let moved = predicted.iter().zip(&positions).fold(0.0, |largest: f64, (new, old)| largest.max((new - old).abs()));

            // At rest nothing is expected to move.
            let at_rest = vec![0.0; balance.pieces.len()];
            let mut margins = self.margins(&balance, &at_rest, moved);
            self.begin_settling(&positions, &margins)?;
            let undamped = vec![0.0; self.system.bodies.len()];
            let forces = self.forces_at_rest(&positions, &undamped)?;
            let conditions = self.conditions_at_rest(&positions, &undamped);
            let is_closed = moved == 0.0 && newton::meets(&self.system, &conditions, &self.state.lambda);
            let imbalance = balance.judge(&self.system, &positions, &forces);
            if is_closed && imbalance.excess <= 1.0 {
                break;
            }
            if is_closed && imbalance.is_round_off {
                // A step that gains nothing is not taken: a state that was settled stays as it is.
                match best.take().filter(|(_, before)| imbalance.excess > 0.5 * before) {
                    Some((state, _)) => {
                        self.system.restore_search(&state.search, &state.positions, time);
                        self.state = state;
                        break;
                    }
                    None => best = Some((self.state.clone(), imbalance.excess)),
                }
            }
            let gone = positions.iter().zip(&begun).any(|(q, begun)| (q - begun).abs() > GONE * self.system.extent);
            if gone || steps == MAX_STEPS {
                return Err(self.no_equilibrium(&balance, &imbalance, steps, &motion));
            }

            let plan = self.plan(&balance, &imbalance, &mut course, &positions);
            if plan.travel.iter().any(|&travel| travel > 0.0) {
                margins = self.margins(&balance, &plan.travel, moved);
                self.begin_settling(&positions, &margins)?;
            }
            balance.shift(&self.system, &plan.shift, &mut predicted);
            let outcome = self.damped_step(&positions, &predicted, &plan.damping).and_then(|solution| {
                self.check_reach(&solution, &margins)?;
                Ok(solution)
            });
            let refused = match outcome {
                Ok(solution) if !is_closed || imbalance.is_round_off || goes_with(&forces, &solution.q_1, &positions, &self.system.fixed) => {
                    motion = solution.q_1.iter().zip(&positions).map(|(new, old)| new - old).collect();
                    course.accepted(balance.motions::<D>(&motion));
                    steps += 1;
                    let state = Arc::make_mut(&mut self.state);
                    (state.positions, state.lambda, state.active) = (solution.q_1, solution.lambda, solution.active);
                    state.search = self.system.search();
                    if std::env::var_os("SETTLE").is_some() {
                        eprintln!("settle {steps}: mu {:.3?} excess {:.1e} motion {:.2e} it {} before {:.2e} closed {is_closed} ro {}", plan.damping, course.excess, largest_size(&motion), solution.iterations, imbalance.excess, imbalance.is_round_off);
                    }
                    continue;
                }
                Ok(_) => None,
                Err(Failure::Fatal(error)) => return Err(error),
                Err(failure) => Some(failure),
            };
            if std::env::var_os("SETTLE").is_some() {
                eprintln!("settle refused: {} excess {:.1e}", refused.as_ref().map_or("against", |f| f.name()), course.excess);
            }
            if course.tries == MAX_TRIES {
                return Err(match refused {
                    Some(failure) => self.failed(&failure, 0.0, 0),
                    None => self.no_equilibrium(&balance, &imbalance, steps, &motion),
                });
            }
            (course.tries, course.excess) = (course.tries + 1, MORE_DAMPING * course.excess);
        }
        let contacts = self.contact_totals(&self.state.positions, &self.state.lambda, &self.state.active);
        let probes = self.probe_values(&self.state.positions, &self.state.velocities);
        let State { positions: q, velocities: v, row, active, .. } = Arc::make_mut(&mut self.state);
        row.strain = self.system.strain_energy(q);
        let gaps: Vec<f64> = self.system.pairs.iter().flat_map(|pair| pair.kernel.gap(q)).collect();
        row.potential = self.system.potential_energy(q) + self.system.penalty_energy(&gaps);
        (row.momentum, row.angular_momentum) = self.system.momenta(q, v);
        row.active = self.system.touching(active);
        (row.contacts, row.probes) = (contacts, probes);
        Ok(SettleReport {
            steps,
            newton_iterations: self.statistics.newton_iterations - iterations_before,
            strain: row.strain,
            active: row.active,
        })
    }

    /// The damping of the next step, and how far it is expected to move the pieces.
    fn plan(&self, balance: &Balance, imbalance: &Imbalance, course: &mut Course, q: &[f64]) -> Plan {
        let facet = self.shortest_facet();
        let fall = if facet.is_finite() { FALL * facet } else { self.system.extent };
        // What is far from all others may fall farther, but not turn farther.
        let falls: Vec<f64> = balance.clearances(&self.system, q).into_iter().map(|clearance| far(clearance, fall, self.system.extent)).collect();
        let mut damping = vec![0.0f64; self.system.bodies.len()];
        for ((piece, pull), &farthest) in balance.pieces.iter().zip(&imbalance.pieces).zip(&falls) {
            let needed = (pull.shift_size() / farthest).max(pull.turn / fall).max(LEAST_DAMPING * piece.frequency_squared);
            damping[piece.body] = damping[piece.body].max(course.excess * needed);
        }
        let (mut shift, mut travel) = (Vec::new(), Vec::new());
        let mut is_wider = false;
        for (number, ((piece, pull), &farthest)) in balance.pieces.iter().zip(&imbalance.pieces).zip(&falls).enumerate() {
            let mu = damping[piece.body];
            let flies = farthest > fall;
            shift.push(if flies { pull.shift.map(|x| x / mu) } else { [0.0; 3] });
            let loose = (pull.shift_size() + pull.turn) / mu;
            let expected = match &course.last {
                Some(last) if !flies => {
                    let last = if last[number] < STANDS * facet { 0.0 } else { last[number] };
                    is_wider |= last == 0.0 && loose > fall;
                    loose.min(2.0 * last)
                }
                _ => loose,
            };
            travel.push(if expected < STANDS * facet { 0.0 } else { expected });
        }
        let _ = is_wider;
        Plan { damping, shift, travel }
    }

    /// Shortest facet of all contacts; infinite without one.
    fn shortest_facet(&self) -> f64 {
        self.system.pairs.iter().map(|pair| pair.kernel.facet_size()).fold(f64::INFINITY, f64::min)
    }

    /// Reach of the search for contact in a damped step: a facet, what both sides are expected to travel, and what is prescribed.
    fn margins(&self, balance: &Balance, travel: &[f64], prescribed: f64) -> Vec<f64> {
        let mut of_node = vec![0.0; self.system.nodes()];
        balance.spread(travel, &mut of_node);
        let largest = |nodes: &[u32]| nodes.iter().fold(0.0f64, |largest, &node| largest.max(of_node[node as usize]));
        let reach = |pair: &super::pairs::Pair| {
            let travel = largest(pair.kernel.secondary().nodes()) + largest(pair.kernel.primary().nodes());
            pair.kernel.facet_size() + travel + 2.0 * prescribed
        };
        self.system.pairs.iter().map(reach).collect()
    }

    fn begin_settling(&mut self, q: &[f64], margins: &[f64]) -> Result<(), StepError> {
        self.system.move_obstacles(self.state.row.time, 0.0)?;
        self.system.begin_step(q, margins).map_err(|error| self.failed(&Failure::Linear(error), 0.0, 0))
    }

    /// The forces on the present state.
    fn forces_at_rest(&mut self, q: &[f64], undamped: &[f64]) -> Result<Forces, StepError> {
        let zero = vec![0.0; q.len()];
        let start = at_rest(self.state.row.time, q, &zero, undamped);
        let forces = self.system.assemble(&start, q, &self.state.lambda);
        forces.map_err(|error| match error.into() {
            Failure::Fatal(error) => error,
            failure => self.failed(&failure, 0.0, 0),
        })
    }

    /// At rest every rule closes the gaps.
    fn conditions_at_rest(&self, q: &[f64], damping: &[f64]) -> Conditions {
        let count = self.system.multipliers;
        let zero = vec![0.0; q.len()];
        let compliance = self.system.compliance(&at_rest(self.state.row.time, q, &zero, damping));
        Conditions { gap_n: vec![0.0; count], targets: vec![0.0; count], members: vec![true; count], compliance, end_point: true }
    }

    fn damped_step(&mut self, positions: &[f64], predicted: &[f64], damping: &[f64]) -> Result<Solution, Failure> {
        let zero = vec![0.0; positions.len()];
        let start = at_rest(self.state.row.time, positions, &zero, damping);
        let conditions = self.conditions_at_rest(positions, damping);
        let floor = tolerances::FORCE_FLOOR * self.system.modulus * self.system.extent.powi(D as i32);
        let options = &self.options;
        let task = Task {
            start: &start,
            predicted,
            lambda: &self.state.lambda,
            conditions: &conditions,
            energy: self.system.strain_energy(positions).max(floor),
            tolerance: options.tolerance,
            at_least: 1,
            interrupted: &|| options.interrupted(),
        };
        solve(&mut self.system, &task, &mut self.statistics.newton_iterations, &mut self.trace)
    }

    /// The error where damped steps lead to no equilibrium.
    fn no_equilibrium(&mut self, balance: &Balance, imbalance: &Imbalance, steps: usize, motion: &[f64]) -> StepError {
        let (body, how) = self.moving_body(motion);
        let number = self.system.bodies.iter().position(|other| other.name == body).unwrap_or(0);
        let of_body = || balance.pieces.iter().zip(&imbalance.pieces).filter(|(piece, _)| piece.body == number).map(|(_, pull)| pull);
        let unbalanced = of_body().map(|pull| pull.relative).fold(0.0, f64::max);
        let is_loose = of_body().any(|pull| pull.shift_size() + pull.turn > 0.0);
        let nodes = self.system.bodies[number].nodes.clone();
        let touches = self.system.pairs.iter().any(|pair| {
            let is_of_body = |surface: &crate::contact::Surface| surface.nodes().iter().any(|&node| nodes.contains(&(node as usize)));
            let sides = is_of_body(pair.kernel.secondary()) || is_of_body(pair.kernel.primary());
            sides && self.state.active[pair.rows.clone()].contains(&true)
        });
        let missing = match (is_loose, touches) {
            (false, _) => None,
            (true, true) => Some(Missing::Guidance),
            (true, false) => Some(Missing::Support),
        };
        let cause = FailureCause::NoEquilibrium { steps, unbalanced, body, how, missing };
        let report = self.evidence(0.0, 0).report_of(cause);
        self.given_up(report)
    }
}

impl Course {
    /// A step was taken, in which the pieces moved that far.
    fn accepted(&mut self, motions: Vec<f64>) {
        self.last = Some(motions);
        self.tries = 0;
        self.excess = (self.excess / MORE_DAMPING).max(1.0);
        self.widenings += 0;
    }
}

fn far(clearance: f64, fall: f64, extent: f64) -> f64 {
    if clearance.is_finite() { clearance.max(fall) } else { fall.max(extent) }
}

/// A step without inertia.
fn at_rest<'a>(time: f64, q_0: &'a [f64], zero: &'a [f64], damping: &'a [f64]) -> StepStart<'a> {
    StepStart { integrator: Integrator::Trapezoidal, time, dt: 0.0, q_0, v_0: zero, half_force: zero, prescribed_v_1: &[], damping: Some(damping) }
}

/// Whether a step goes the way that the unbalanced forces push. One that goes against them climbs to an equilibrium that does not last.
fn goes_with(forces: &Forces, q_1: &[f64], q_0: &[f64], fixed: &[bool]) -> bool {
    let push = |k: usize| forces.contact[k] - forces.without_contact[k];
    (0..q_0.len()).filter(|&k| !fixed[k]).map(|k| push(k) * (q_1[k] - q_0[k])).sum::<f64>() >= 0.0
}
