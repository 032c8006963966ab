//! `settle`: equilibrium under the loads of the present time, by damped steps without inertia.
//!
//! A step solves `f(q_1) + mu M (q_1 - q_0) = 0`, the forces at its end and a damping, with the contact conditions. Each body has its own
//! `mu`: proportional to its unbalanced resultant and torque, so that loose bodies move by at most half a facet, and never less than a
//! small fraction of its own stiffness, so that rigid motions stay regular. The damping decreases with the imbalance, and with it the error
//! of the result (pseudo-transient continuation; Kelley and Keyes, SIAM J. Numer. Anal. 35, 1998). `balance.rs` decides when equilibrium is
//! reached; damping does not count as a force there.
//!
//! Overlaps are separated by a fraction of a facet per step (`closing.rs`), and prescribed motions advance as far per step as Newton's
//! method converges.
//!
//! Of several equilibria any may be found, stable or not; but no step moves against the unbalanced forces.

use std::sync::Arc;

use super::balance::{Balance, Imbalance};
use super::closing::Closing;
use super::engine::Engine;
use super::loaded::EvaluatedContacts;
use super::options::SettleReport;
use super::report::{FailureCause, Missing};
use super::settle_progress::{Progress, SettleEffort};
use super::slip_memory::slipped;
use super::state::State;
use crate::bodies::{Elements, Space};
use crate::contact::{MotionBound, PredictedMotion, Surface};
use crate::dynamics::model::part::Pose;
use crate::dynamics::model::step_error::StepError;
use crate::dynamics::parts::contact_pair::ContactPair;
use crate::dynamics::parts::laws::RowState;
use crate::dynamics::step::attempts::PreferredAttempt;
use crate::dynamics::step::conditions::Conditions;
use crate::dynamics::step::contact_set::meets;
use crate::dynamics::step::equations::Equations;
use crate::dynamics::step::failure::Failure;
use crate::dynamics::step::iterate::Linearization;
use crate::dynamics::step::newton::{Solution, solve};
use crate::dynamics::step::predictor::{displacements_to, follow_prescribed};
use crate::dynamics::step::start::{StepKind, StepStart};
use crate::dynamics::step::task::Task;
use crate::math::norms::largest_size;
use crate::math::tolerances;

/// Largest number of damped steps: stacks of twenty need seven, a fall from a distance one per halving of the distance.
const MAX_STEPS: usize = 100;

/// Displacement limit of an unsupported body in a step, in facets; above it Newton's method fails to follow closing contacts.
const FALL: f64 = 0.5;

/// Displacement limit in a step of a body without a contact partner, relative to the model extent.
const FLIGHT: f64 = 10.0;
/// Distance from which a body counts as lost, relative to the model extent.
const GONE: f64 = 95.0;

/// Growth of the damping after a refused step.
const MORE_DAMPING: f64 = 100.0;
/// Growth of the damping after a refused step of a mechanism.
const DAMPING_OF_MECHANISMS: f64 = 10.0;

/// Factor of the fraction of a prescribed motion after a failed step.
const SHORTER: f64 = 0.25;

/// Displacement limit of prescribed nodes in a step, in facets, after the whole prescribed motion at once has failed.
pub(super) const STRIDE: f64 = 0.5;

/// Largest number of steps that close part of an overlap or follow part of a prescribed motion; they do not count in `MAX_STEPS`.
const MAX_PARTS: usize = 200;

/// Growth of the search horizon after bodies moved beyond it.
const WIDER: f64 = 3.0;

/// Largest number of repetitions of a step.
const MAX_TRIES: usize = 6;
/// Largest number of repetitions of a step with a single remedy.
const EARLY_TRIES: usize = 3;

/// Number of steps with increased damping that may pass without a smaller imbalance: enough for buckling, while a sliding body is given up.
const MAX_STUCK: usize = 20;

/// Imbalance relative to its tolerance, 1e-8 of the forces, below which its direction is not evaluated: the iteration is about to converge.
const TRIFLE: f64 = 1e3;

/// Number of steps without motion after which zero motion is predicted: otherwise facet pairs that are admitted only during motion would
/// prolong it.
const MAX_STOOD: usize = 3;

/// Imbalance relative to its tolerance, 1e-6 of the forces, that suffices for intermediate equilibria.
const COARSE: f64 = 1e5;

/// Evaluation of the present state in `settle`.
struct EvaluatedState {
    positions: Vec<f64>,
    displacements: Vec<f64>,
    /// Positions with prescribed motion.
    predicted: Vec<f64>,
    /// Displacement to the positions with prescribed motion.
    moved: Vec<f64>,
    /// Size of the displacement to the positions with prescribed motion `[length]`.
    prescribed: f64,
    /// True if the prescribed motion is complete.
    is_whole: bool,
    /// Depth up to which each pair takes part `[length]`.
    reaches: Vec<f64>,
    at: Linearization,
    imbalance: Imbalance,
    /// True if contact conditions and prescribed motions are satisfied.
    is_closed: bool,
}

/// Planned damped step.
struct Plan {
    /// Damping factor of each body.
    damping: Vec<f64>,
    /// Initial displacement of each component in Newton's method.
    shift: Vec<[f64; 3]>,
    /// Expected largest displacement of the nodes of each component.
    travel: Vec<f64>,
}

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// Settles at the present time, prescribed nodes moved by at most `stride` in a step `[length]`.
    pub(super) fn settle_from_here(&mut self, stride: f64, care: SettleEffort) -> Result<SettleReport, StepError> {
        self.tries.clear();
        let iterations_before = self.statistics.newton_iterations;
        let balance = Balance::new(&self.system, &self.model);
        let begun = self.state.positions.clone();
        let mut progress = Progress::new(begun.len(), Closing::of(&self.model), stride, care);
        progress.returned = f64::EPSILON * largest_size(&self.state.displacements);
        let at = loop {
            let present = self.look(&balance, &progress)?;
            if present.is_closed && present.imbalance.excess() <= if care == SettleEffort::Coarse { COARSE } else { 1.0 } {
                break present.at;
            }
            if present.is_closed && progress.has_only_ripples(present.imbalance.excess()) {
                break present.at;
            }
            if present.is_closed && present.imbalance.is_returned {
                break present.at;
            }
            if present.is_closed && self.gains_nothing(&present.imbalance, &mut progress.best) {
                // Forces and pairs must belong to the restored state.
                break self.look(&balance, &progress)?.at;
            }
            let is_gone = present.positions.iter().zip(&begun).any(|(q, begun)| (q - begun).abs() > GONE * self.system.nodes.extent);
            if is_gone || progress.steps - progress.parts == MAX_STEPS || progress.parts == MAX_PARTS || progress.stuck == MAX_STUCK {
                return Err(self.no_equilibrium(&balance, &present.imbalance, &progress));
            }
            self.step_to_rest(&balance, &present, &mut progress)?;
            self.system.recycle(present.at);
        };
        self.advance_histories(&at)?;
        let state = Arc::make_mut(&mut self.state);
        state.search = self.system.search();
        self.system.lead_positions(&mut state.displacements, &mut state.positions);
        let State { positions: q, lambda, active, slipped, .. } = &*self.state;
        let touching = EvaluatedContacts { q, evaluations: &at.pairs, slips: &at.slips, lambda, active, slipped };
        let contacts = self.contact_totals(&touching);
        let reaction = |k: usize| at.forces.whole(at.forces.residual(k));
        let mut reactions = self.reactions(|k| q[k], reaction);
        reactions.extend(self.coupling_reactions(|k| q[k], &at, lambda, self.state.row.time)?);
        let joints = self.joint_totals(q, (q, [&at.pairs, &at.slips]), lambda, &[]);
        self.system.recycle(at);
        Arc::make_mut(&mut self.state).accelerations.fill(0.0);
        let probes = self.probe_values(&self.state.displacements, &self.state.velocities, &self.state.accelerations);
        let State { positions: q, displacements: u, velocities: v, row, active, penalty_gap, reserve, memory, drift, slips_until, .. } =
            Arc::make_mut(&mut self.state);
        *memory = self.system.relaxed(row.time, Pose { q, u }, memory);
        *slips_until = row.time;
        row.strain = self.system.strain_energy(u, memory);
        let mut gaps: Vec<f64> = self.system.pairs.iter().flat_map(|pair| pair.kernel.gap(q)).collect();
        gaps.resize(self.system.multipliers, 0.0);
        row.potential =
            self.system.nodes.potential_energy(q) + self.system.penalty_energy(&gaps) + self.system.stored_energy(Pose { q, u }, memory);
        *penalty_gap = gaps;
        reserve.fill(0.0);
        (row.reserve, *drift) = (0.0, 0.0);
        (row.momentum, row.angular_momentum) = self.system.nodes.momenta(q, v);
        row.active = self.system.touching(active);
        row.max_penetration = contacts.iter().map(|contact| contact.penetration).fold(0.0, f64::max);
        (row.contacts, row.reactions, row.joints, row.probes) = (contacts, reactions, joints, probes);
        row.parts = self.system.part_totals(Pose { q, u }, v, memory, &[]);
        self.check_overlaps(&progress.closing)?;
        Ok(SettleReport {
            steps: progress.steps,
            newton_iterations: self.statistics.newton_iterations - iterations_before,
            strain: self.state.row.strain,
            active: self.state.row.active,
        })
    }

    /// Advances the history variables of bodies from the initial state to the equilibrium in one step: intermediate states are unbalanced,
    /// and their plastic flow would be an artifact.
    fn advance_histories(&mut self, at: &Linearization) -> Result<(), StepError> {
        let (state, undamped) = (self.state.clone(), vec![0.0; self.system.bodies.len()]);
        let kind = StepKind::Rest { damping: &undamped, velocities: None };
        let start = StepStart { time: state.row.time, q_0: &state.positions, u_0: &state.displacements, memory: &state.memory, kind };
        let (memory, heats) = self.system.history_after(&start, at, &state.memory)?;
        let present = Arc::make_mut(&mut self.state);
        present.memory = memory;
        present.row.book_plastic(&self.system.bodies, &state.row, &heats.plastic);
        Ok(())
    }

    /// Evaluates the imbalance of the present state, with the contact pairs of a state at rest.
    fn look(&mut self, balance: &Balance, progress: &Progress) -> Result<EvaluatedState, StepError> {
        let (positions, displacements) = (self.state.positions.clone(), self.state.displacements.clone());
        let (mut displacement, _) = self.system.supports.prescribed_motion(self.state.row.time)?;
        let prescribed = &self.system.supports.prescribed;
        let now: Vec<f64> = prescribed.iter().map(|one| displacements[one.unknown]).collect();
        let farthest = displacement.iter().zip(&now).fold(0.0, |farthest: f64, (then, now)| farthest.max((then - now).abs()));
        let is_whole = progress.share == 1.0 && farthest <= progress.stride;
        if !is_whole {
            let share = progress.share.min(progress.stride / farthest);
            displacement.iter_mut().zip(&now).for_each(|(then, now)| *then = now + share * (*then - now));
        }
        let mut predicted = positions.clone();
        follow_prescribed(&self.system, &positions, &displacement, &mut predicted);
        let moved = displacements_to(&self.system, self.state.pose(), &displacement, &predicted);
        let prescribed = largest_size(&moved);
        let still = vec![0.0; self.system.nodes.count()];
        let motion_bound =
            MotionBound::Each { sizes: &still, besides: 2.0 * prescribed, is_continued: progress.steps + progress.tries > 0 };
        let reaches = progress.closing.reaches(&self.system, &positions, self.state.row.time);
        self.begin_at_rest(&PredictedMotion { q: &positions, motion_bound, reach: self.options.reach, depth: 0.0 }, &reaches)?;
        let undamped = vec![0.0; self.system.bodies.len()];
        let memory = self.state.memory.clone();
        let (time, kind) = (self.state.row.time, StepKind::Rest { damping: &undamped, velocities: None });
        let start = StepStart { time, q_0: &positions, u_0: &displacements, memory: &memory, kind };
        let at = match self.system.linearize(&start, &positions, &vec![0.0; positions.len()], &self.state.lambda) {
            Ok(at) => at,
            Err(Failure::Fatal(error)) => return Err(error),
            Err(failure) => return Err(self.failed(&failure, 0.0, 0)),
        };
        let is_carried = self.rest_friction && self.state.slips_until != time && self.system.pairs.iter().any(ContactPair::carries);
        let is_closed = prescribed == 0.0 && !is_carried && meets(&self.system, &at, &self.conditions_of_equilibrium(&start, &at.lambda));
        let imbalance = balance.judge(&self.system, at.pose(), &at.forces, progress.returned);
        Ok(EvaluatedState { positions, displacements, predicted, moved, prescribed, is_whole, reaches, at, imbalance, is_closed })
    }

    /// True if only round-off remains and a further step has halved neither the imbalance of sums nor that of nodes. That step is undone,
    /// so that a settled state stays unchanged. Internal forces cancel in sums, so round-off of positions limits nodal forces only.
    fn gains_nothing(&mut self, imbalance: &Imbalance, best: &mut Option<(Arc<State>, [f64; 2])>) -> bool {
        if !imbalance.is_round_off {
            return false;
        }
        let now = [imbalance.of_sums, imbalance.of_nodes];
        let is_less = |before: &[f64; 2]| (0..2).any(|k| before[k] > 1.0 && now[k] <= 0.5 * before[k]);
        match best.take().filter(|(_, before)| !is_less(before)) {
            Some((state, _)) => {
                self.system.restore_search(&state.search, &state.positions, state.row.time);
                self.state = state;
                true
            }
            None => {
                *best = Some((self.state.clone(), now));
                false
            }
        }
    }

    /// Takes a damped step or, if it is refused, increases the damping or the expected motion for the next attempt.
    fn step_to_rest(&mut self, balance: &Balance, present: &EvaluatedState, progress: &mut Progress) -> Result<(), StepError> {
        let EvaluatedState { positions, displacements, imbalance, .. } = present;
        let plan = self.plan(balance, present, progress);
        // Motion bound of each node: the expected motion of its component; for the two sides of a contact twice the prescribed motion in
        // addition.
        let sizes: Vec<f64> = balance.spread(&plan.travel, self.system.nodes.count()).iter().map(|size| progress.leeway * size).collect();
        // After an overlooked contact, components without an expected motion may also have moved.
        let facet = self.shortest_facet();
        let unexpected = if progress.leeway > 1.0 && facet.is_finite() { progress.leeway * FALL * facet } else { 0.0 };
        let besides = 2.0 * present.prescribed + unexpected + progress.closing.motion(&self.system, &present.reaches);
        let predicted_motion = PredictedMotion {
            q: positions,
            motion_bound: MotionBound::Each { sizes: &sizes, besides, is_continued: true },
            reach: self.options.reach,
            depth: 0.0,
        };
        self.begin_at_rest(&predicted_motion, &present.reaches)?;
        let mut predicted = present.predicted.clone();
        balance.shift(&self.system, &plan.shift, &mut predicted);
        let mut moved: Vec<f64> = predicted.iter().zip(positions).map(|(new, old)| new - old).collect();
        self.system.supports.prescribed.iter().for_each(|one| moved[one.unknown] = present.moved[one.unknown]);
        let memory = self.state.memory.clone();
        let rest = StepKind::Rest { damping: &plan.damping, velocities: None };
        let start = StepStart { time: self.state.row.time, q_0: positions, u_0: displacements, memory: &memory, kind: rest };
        let mut conditions = self.conditions_at_rest(&start);
        let closes_in_part = progress.closing.limit(&self.system, positions, &mut conditions);
        let outcome = self.damped_step(&start, [&predicted, &moved], &conditions, progress.care);
        let is_part = closes_in_part || (present.prescribed > 0.0 && !present.is_whole);
        let refused = match outcome.and_then(|solution| self.check_search(&predicted_motion, progress.leeway, &solution).map(|()| solution))
        {
            Err(Failure::Fatal(error)) => return Err(error),
            Err(failure) => Some(failure),
            Ok(solution) if present.is_pushed_by(&solution.at.moved, &self.system) => {
                let motion = solution.at.moved.clone();
                progress.parts += usize::from(is_part);
                progress.accepted(imbalance.excess(), balance.motions::<D>(&motion), motion, tolerances::STANDS * self.shortest_facet());
                let (own, system) = (&self.state.slipped, &self.system);
                let slipped = slipped(system, own, &solution.at, 1.0, (&solution.at.lambda, &solution.active));
                let state = Arc::make_mut(&mut self.state);
                (state.slipped, state.slips_until) = (slipped, state.row.time);
                (state.lambda, state.active) = (solution.at.lambda.clone(), solution.active);
                (state.positions, state.displacements) = (solution.at.q_1.clone(), solution.at.u_1.clone());
                self.system.recycle(solution.at);
                state.search = self.system.search();
                return Ok(());
            }
            Ok(_) => None,
        };
        let is_overlooked = matches!(refused, Some(Failure::BeyondSearch { .. } | Failure::Overlooked { .. }));
        if progress.tries == MAX_TRIES || (progress.care != SettleEffort::Patient && refused.is_some() && !is_overlooked) {
            return Err(match refused {
                Some(failure) => self.failed(&failure, 0.0, 0),
                None => self.no_equilibrium(balance, imbalance, progress),
            });
        }
        progress.tries += 1;
        match refused {
            Some(Failure::BeyondSearch { .. } | Failure::Overlooked { .. }) => progress.leeway *= WIDER,
            _ => {
                // Overlaps: less is closed in the next step. Prescribed motions: more damping near their end, a smaller fraction of the
                // motion before.
                if closes_in_part {
                    progress.closing.failed();
                }
                if present.prescribed > 0.0 && progress.tries >= EARLY_TRIES {
                    progress.share *= SHORTER;
                }
                if !closes_in_part || progress.tries > EARLY_TRIES {
                    progress.excess *= if self.system.is_mechanism() { DAMPING_OF_MECHANISMS } else { MORE_DAMPING };
                }
            }
        }
        Ok(())
    }

    /// Damping of the next step, and expected displacements of the components.
    fn plan(&self, balance: &Balance, EvaluatedState { imbalance, positions: q, at, .. }: &EvaluatedState, progress: &Progress) -> Plan {
        let facet = self.shortest_facet();
        let turn = if facet.is_finite() { FALL * facet } else { self.system.nodes.extent };
        // Components without contact partners may be displaced farther, but not rotated farther.
        let fall = |clearance: f64| if clearance.is_finite() { clearance.max(turn) } else { FLIGHT * self.system.nodes.extent };
        let falls: Vec<f64> = balance.clearances(&self.system, q, &imbalance.components).into_iter().map(fall).collect();
        let mut damping = vec![0.0f64; self.system.bodies.len()];
        let load = balance.largest_load::<D>(&at.forces);
        for ((component, pull), &fall) in balance.components.iter().zip(&imbalance.components).zip(&falls) {
            let loose = (pull.shift_size() / fall.min(component.turn_bound)).max(pull.turn / turn.min(component.turn_bound));
            let needed = loose.max(component.least_damping::<D>(&at.forces, load));
            damping[component.body] = damping[component.body].max(progress.excess * needed);
        }
        let mut plan = Plan { damping, shift: Vec::new(), travel: Vec::new() };
        for (number, ((component, pull), &fall)) in balance.components.iter().zip(&imbalance.components).zip(&falls).enumerate() {
            let (mu, flies) = (plan.damping[component.body], fall > turn);
            let jumps = flies && !balance.is_resisted(&self.system, &self.state.memory, (number, pull), q);
            plan.shift.push(if jumps { pull.shift.map(|x| x / mu) } else { [0.0; 3] });
            let loose = (pull.shift_size() + pull.turn) / mu;
            let expected = match &progress.travelled {
                _ if progress.stood >= MAX_STOOD => 0.0,
                // The displacements of components in contact decrease from step to step.
                Some(travelled) if !flies => loose.min(2.0 * travelled[number]),
                _ => loose,
            };
            plan.travel.push(if expected < tolerances::STANDS * facet { 0.0 } else { expected });
        }
        plan
    }

    /// Starts a step at rest.
    pub(super) fn begin_at_rest(&mut self, predicted_motion: &PredictedMotion, reaches: &[f64]) -> Result<(), StepError> {
        self.system.equations.move_obstacles(self.state.row.time, 0.0)?;
        self.system.equations.carry(self.state.slips_until, self.state.row.time)?;
        self.system.begin_deep_step(predicted_motion, reaches).map_err(|error| self.error_of(Failure::Linear(error)))?;
        self.system.equations.begin_friction(self.state.row.time, predicted_motion.q)
    }

    /// Conditions of a static step, in which every update rule closes the gaps.
    pub(super) fn conditions_at_rest(&self, start: &StepStart) -> Conditions {
        let (count, stiffness) = (self.system.multipliers, self.system.row_stiffness(start));
        Conditions {
            gap_n: vec![0.0; count],
            targets: self.system.closed_gaps(),
            members: (0..count).map(|row| !self.system.redundant[row] && (row < self.system.normal_count || self.rest_friction)).collect(),
            compliance: self.system.compliance(&stiffness),
            end_point: true,
            shift: vec![0.0; count],
            stiffness,
            stops: vec![false; count],
            lagged_speeds: Vec::new(),
            dt: 0.0,
        }
    }

    /// Conditions by which a state is an equilibrium: those of a static step, but corner constraints without a force may overlap by twice
    /// their slack. The facet opposite a corner is chosen anew for every state; a constraint whose facet changes once it is closed would
    /// otherwise close and open in turn, without end.
    fn conditions_of_equilibrium(&self, start: &StepStart, lambda: &[f64]) -> Conditions {
        let mut conditions = self.conditions_at_rest(start);
        let corners = self.system.pairs.iter().filter(|pair| pair.corners.is_some());
        corners.flat_map(|pair| pair.rows.clone()).filter(|&row| lambda[row] == 0.0).for_each(|row| conditions.targets[row] *= 2.0);
        conditions
    }

    fn damped_step(
        &mut self,
        start: &StepStart,
        [predicted, moved]: [&[f64]; 2],
        conditions: &Conditions,
        care: SettleEffort,
    ) -> Result<Solution, Failure> {
        // Energy of round-off strains: relative to positions if forces depend on positions, otherwise relative to small displacements.
        let round_off = if self.system.depends_on_positions() { tolerances::FORCE_FLOOR } else { tolerances::FORCE_FLOOR.powi(2) };
        let floor = round_off * self.system.nodes.stiffness() * self.system.nodes.extent.powi(2);
        let options = &self.options;
        let task = Task {
            start,
            predicted,
            moved,
            lambda: &self.state.lambda,
            conditions,
            energy: self.system.strain_energy(start.u_0, start.memory).max(floor),
            tolerance: if care == SettleEffort::Coarse { options.tolerance.max(tolerances::ON_THE_WAY) } else { options.tolerance },
            is_still: false,
            is_exact: false,
            at_least: 1,
            // In mechanisms, shorter steps need fewer factorizations.
            is_patient: care == SettleEffort::Patient && !self.system.is_mechanism(),
            preferred: PreferredAttempt::default(),
            interrupted: &|| options.interrupted(),
        };
        solve(&mut self.system, &task, &mut self.statistics.newton_iterations, &mut self.trace)
    }

    /// Error if damped steps find no equilibrium.
    fn no_equilibrium(&mut self, balance: &Balance, imbalance: &Imbalance, progress: &Progress) -> StepError {
        let (body, how) = self.moving_body(&progress.motion);
        let number = self.system.bodies.iter().position(|other| other.name == body).unwrap_or(0);
        let nodes = self.system.bodies[number].nodes.clone();
        let pulls =
            || balance.components.iter().zip(&imbalance.components).filter(|(component, _)| component.body == number).map(|(_, pull)| pull);
        let unbalanced = pulls().map(|pull| pull.relative).fold(0.0, f64::max);
        let is_loose = pulls().any(|pull| pull.shift_size() + pull.turn > 0.0);
        let is_side = |surface: &Surface| surface.nodes().iter().any(|&node| nodes.contains(&(node as usize)));
        let touches = self.system.pairs.iter().any(|pair| {
            (is_side(pair.kernel.secondary()) || is_side(pair.kernel.primary()))
                && self.state.active[pair.rows.clone()].contains(&RowState::Closed)
        });
        let missing = is_loose.then_some(match touches {
            true if self.system.multipliers > self.system.normal_count => Missing::Friction,
            true => Missing::Guidance,
            false => Missing::Support,
        });
        let cause = FailureCause::NoEquilibrium { steps: progress.steps, unbalanced, body, how, missing };
        let report = self.evidence(0.0, 0).report_of(cause);
        self.given_up(report)
    }
}

impl EvaluatedState {
    /// True if the unbalanced forces do positive work along a displacement; Newton's method may also converge to unstable equilibria
    /// against them. Always true while contacts or prescribed motions are not satisfied, and for forces or displacements at round-off (gaps
    /// are met to 1e-12 of a facet).
    fn is_pushed_by<const D: usize>(&self, moved: &[f64], system: &Equations<D>) -> bool {
        let push = |k: usize| self.at.forces.contact[k] - self.at.forces.without_contact[k];
        let free = (0..moved.len()).filter(|&k| !system.supports.fixed[k]);
        let (work, size) = free.fold((0.0, 0.0), |(work, size), k| (work + push(k) * moved[k], size + push(k).abs()));
        let climbs = work < -tolerances::GAP * system.nodes.extent * size;
        !self.is_closed || self.imbalance.is_round_off || self.imbalance.excess() <= TRIFLE || !climbs
    }
}
