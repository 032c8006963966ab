//! The end of an explicit step: velocities, and its row of the ledger.
//!
//! Half of the forces act at either end of the step: moments are evaluated there, and works follow the trapezoidal rule. The balances of
//! linear and angular momentum close to round-off; the energy defect is that of the scheme.

use std::sync::Arc;

use super::engine::Engine;
use super::explicit::ExplicitStep;
use super::ledger::{LedgerRow, heat, unexplained};
use super::loaded::EvaluatedContacts;
use super::state::State;
use crate::bodies::{Elements, Space};
use crate::dynamics::parts::contact_pair::PairKind;
use crate::dynamics::parts::laws::RowState;
use crate::dynamics::step::explicit::PartForces;
use crate::dynamics::step::failure::Failure;
use crate::dynamics::step::iterate::Linearization;
use crate::dynamics::step::scheme_history::SchemeHistory;
use crate::dynamics::step::start::{Motion, StepStart};
use crate::integrators::Derivative;

/// External forces in a step, at its start and at its end, as means over the step `[force]`.
struct Ends {
    /// Forces of rigid obstacles; at the start only the change by the multipliers of this step.
    obstacles: [Vec<f64>; 2],
    /// Reactions of supports.
    reactions: [Vec<f64>; 2],
    /// Loads, weights and forces of the ground; at the start also the obstacle forces of the previous step.
    others: [Vec<f64>; 2],
    /// Work of moving obstacles: of all, and of those with multipliers.
    obstacle_work: [f64; 2],
}

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// New state after an explicit step, with the static forces at its end.
    pub(super) fn land(
        &mut self,
        start: &StepStart,
        motion: &Motion,
        leap: ExplicitStep,
        at: Linearization,
        forces: PartForces,
    ) -> Result<State, Failure> {
        let (dt, search) = (leap.dt, self.system.search());
        let f_1 = self.static_forces(&forces, &at.pairs, &leap.lambda[1]);
        let (system, old) = (&self.system, &self.state);
        let mut v_1: Vec<f64> =
            at.moved.iter().zip(&f_1).enumerate().map(|(k, (moved, f_1))| moved / dt - 0.5 * dt * system.mobility(k) * f_1).collect();
        for (one, rate) in system.supports.prescribed.iter().zip(motion.prescribed_v_1) {
            v_1[one.unknown] = *rate;
        }
        let ends = self.ends(motion, &leap, &at, &forces, [&f_1, &v_1]);
        let (memory, heats) = self.memory_after(start, &at).map_err(Failure::Fatal)?;
        let active: Vec<RowState> = leap.lambda[1].iter().map(|lambda| RowState::closed_if(*lambda > 0.0)).collect();
        let mut penalty_gap: Vec<f64> = at.pairs.iter().flat_map(|pair| pair.gap.iter().copied()).collect();
        penalty_gap.resize(system.multipliers, 0.0);

        let accelerations = self.accelerations_to(&v_1, dt);
        let mut row = self.row_at_end(dt, &at, [&v_1, &accelerations], (&memory, &heats), &active);
        [row.dissipation, row.damping, _] = heat(&heats.all, &row.parts, 0.0);
        row.book_plastic(&system.bodies, &old.row, &heats.plastic);
        row.potential = self.potential(&at, &penalty_gap, &memory);
        self.book_explicit_work(&mut row, motion, &leap, &at, &forces, (&ends, &v_1));
        self.book_explicit_momenta(&mut row, start, &at, &ends);
        let touching = EvaluatedContacts::of(&at, &leap.lambda[1], &active, &[]);
        self.book_contacts(&mut row, &touching, None, &[]);
        let middle = |k: usize| 0.5 * (start.q_0[k] + at.q_1[k]);
        row.reactions = self.reactions(middle, |k| ends.reactions[0][k] + ends.reactions[1][k]);

        let pushes = forces.load.iter().any(|load| *load != 0.0) || ends.obstacle_work[0] != 0.0;
        let exchanged = old.scheme_history.exchanged + row.load_work.abs() + (row.potential - old.row.potential).abs();
        let mut scheme_history = SchemeHistory { of: old.scheme_history.of.clone(), dt, exchanged, ..SchemeHistory::default() };
        scheme_history.keep(motion.scheme, &f_1, forces, &ends.obstacles[1]);
        let state = State {
            drift: old.drift + row.energy_defect,
            pushed: old.pushed,
            row,
            positions: at.q_1.clone(),
            displacements: at.u_1.clone(),
            velocities: v_1,
            accelerations,
            lambda: leap.lambda[1].clone(),
            penalty_gap,
            reserve: old.reserve.clone(),
            active,
            slipped: old.slipped.clone(),
            scheme_history: Arc::new(scheme_history),
            memory,
            clock: old.clock,
            search,
            level: 0,
            pace: old.pace.clone(),
            preferred: old.preferred,
            slips_until: old.slips_until,
            loads_ended: if pushes { start.time + dt } else { old.loads_ended },
        };
        self.system.recycle(at);
        Ok(state)
    }

    /// External forces at both ends of a step with the static forces `f_1` and the velocities `v_1` at its end.
    fn ends(&self, motion: &Motion, leap: &ExplicitStep, at: &Linearization, forces: &PartForces, [f_1, v_1]: [&[f64]; 2]) -> Ends {
        let (system, unknowns, dt) = (&self.system, f_1.len(), leap.dt);
        let nothing = || [vec![0.0; unknowns], vec![0.0; unknowns]];
        let (mut obstacles, mut obstacle_work) = (nothing(), [0.0; 2]);
        for pair in system.pairs.iter().filter(|pair| pair.kind == PairKind::Obstacle) {
            let [before, now] = [0, 1].map(|k: usize| &leap.lambda[k][pair.rows.clone()]);
            let has_multipliers = pair.has_multipliers();
            // Multipliers of this step replace the earlier ones at its start. The force of the earlier multipliers acted with the
            // constraints of the previous step, whose facets may differ, and is stored (`outside`); their work is computed with the present
            // constraints.
            let change: Vec<f64> = before.iter().zip(now).map(|(before, now)| if has_multipliers { now - before } else { 0.0 }).collect();
            let half = |lambda: &[f64]| -> Vec<f64> { lambda.iter().map(|lambda| 0.5 * lambda).collect() };
            let none = vec![0.0; now.len()];
            let [at_start, at_end] = &mut obstacles;
            let push = |first: &[f64], last: &[f64], into: &mut Vec<f64>| {
                pair.kernel.obstacle_force_into(Derivative::AT_END, &at.q_1, first, last, into)
            };
            let earlier = push(&half(before), &none, &mut vec![0.0; unknowns]);
            let work = earlier + push(&change, &none, at_start) + push(&none, &half(now), at_end);
            obstacle_work[0] += work;
            obstacle_work[1] += if has_multipliers { work } else { 0.0 };
        }
        let mut reactions = nothing();
        for k in (0..unknowns).filter(|&k| system.supports.fixed[k]) {
            let mass = system.nodes.nodal_mass[k / D] / dt;
            let middle = at.moved[k] / dt;
            let kick = leap.kick.get(k).copied().unwrap_or_default();
            reactions[0][k] = mass * (middle - motion.v_0[k]) + 0.5 * leap.f_0[k] - kick;
            reactions[1][k] = mass * (v_1[k] - middle) + 0.5 * f_1[k];
        }
        let weight = &system.nodes.weight;
        // Forces of the ground without those of obstacles.
        let [load_0, ground_0] = motion.scheme_history.outside.each_ref().map(|lagging| &lagging.left);
        let half = |k: usize, load: f64, ground: &[f64], share: f64| 0.5 * weight[k] + load - share * ground.get(k).copied().unwrap_or(0.0);
        let others = [
            (0..unknowns).map(|k| half(k, load_0[k], ground_0, 1.0)).collect(),
            (0..unknowns).map(|k| half(k, 0.5 * forces.load[k], &forces.ground, 0.5)).collect(),
        ];
        Ends { obstacles, reactions, others, obstacle_work }
    }

    /// Books the work of loads, supports and obstacles in the step, and that of contact by velocities before and after each impulse.
    fn book_explicit_work(
        &self,
        row: &mut LedgerRow,
        motion: &Motion,
        leap: &ExplicitStep,
        at: &Linearization,
        forces: &PartForces,
        (ends, v_1): (&Ends, &[f64]),
    ) {
        let (system, old) = (&self.system, &self.state.row);
        let load_0 = &motion.scheme_history.outside[0].left;
        let loads: f64 = (0..at.moved.len()).map(|k| (load_0[k] + 0.5 * forces.load[k]) * at.moved[k]).sum();
        let prescribed = system.supports.prescribed.iter().map(|one| one.unknown);
        let supports: f64 = prescribed.map(|k| (ends.reactions[0][k] + ends.reactions[1][k]) * at.moved[k]).sum();
        row.load_work = loads + supports + ends.obstacle_work[0];
        if !leap.kick.is_empty() {
            let pressed_1 = system.pressed(&at.pairs, &leap.lambda[1], |pair| pair.has_multipliers());
            let dt = leap.dt;
            let of = |k: usize| {
                let (begun, left) = (leap.unpushed[k], at.moved[k]);
                let before = 0.25 * leap.pressed_0[k] * (dt * motion.v_0[k] + begun);
                before + 0.5 * leap.kick[k] * (begun + left) + 0.25 * pressed_1[k] * (left + dt * v_1[k])
            };
            row.contact_work = (0..at.moved.len()).map(of).sum::<f64>() - ends.obstacle_work[1];
        }
        row.energy_defect = row.total() - old.total() - row.load_work - row.contact_work + row.dissipation;
    }

    fn book_explicit_momenta(&self, row: &mut LedgerRow, start: &StepStart, at: &Linearization, ends: &Ends) {
        let (nodes, old, dt) = (&self.system.nodes, &self.state.row, row.dt);
        let (mut external, mut turning) = ([0.0; 3], [0.0; 3]);
        for (end, q) in [start.q_0, &at.q_1].into_iter().enumerate() {
            let parts = [&ends.obstacles[end], &ends.reactions[end], &ends.others[end]];
            let force: Vec<f64> = (0..q.len()).map(|k| parts.iter().map(|part| part[k]).sum()).collect();
            let (resultant, moment) = (nodes.resultant(&force), nodes.moment(q, &force));
            (0..3).for_each(|i| {
                external[i] += resultant[i];
                turning[i] += moment[i];
            });
        }
        let changes = |force: [f64; 3]| [force.map(|x| dt * x), [0.0; 3]];
        row.momentum_defect = unexplained([row.momentum, old.momentum], changes(external));
        row.angular_momentum_defect = unexplained([row.angular_momentum, old.angular_momentum], changes(turning));
    }
}
