//! The end of a converged step: velocities, returned impact energy, the row of the ledger.

use std::sync::Arc;

use super::engine::Engine;
use super::ledger::{LedgerRow, Reaction, heat, unexplained};
use super::loaded::EvaluatedContacts;
use super::slip_memory::{add_heat, rested, slipped};
use super::state::State;
use super::velocity_correction::VelocityCorrection;
use crate::bodies::{Elements, Space};
use crate::dynamics::model::part::{PartDissipation, PartHistories};
use crate::dynamics::model::step_error::StepError;
use crate::dynamics::parts::contact_pair::{ContactPair, PairKind, RowBlock};
use crate::dynamics::parts::force_shares::ForceShares;
use crate::dynamics::parts::laws::RowState;
use crate::dynamics::parts::nodal::{add_force, add_moment, half_product};
use crate::dynamics::step::conditions::Conditions;
use crate::dynamics::step::iterate::{Forces, Linearization};
use crate::dynamics::step::newton::Solution;
use crate::dynamics::step::scheme_history::SchemeHistory;
use crate::dynamics::step::start::{Motion, StepStart};
use crate::integrators::{Derivative, History};
use crate::math::norms::largest_size;
use crate::math::tolerances;

/// External forces and their work in a step.
struct Outside {
    /// Loads on the nodes `[force]`.
    load: Vec<f64>,
    /// Forces of rigid obstacles and of the ground.
    obstacles: Vec<f64>,
    /// Work of moving obstacles.
    obstacle_work: f64,
    /// Part of the obstacle work that the drive of each joint does.
    drive_works: Vec<f64>,
    /// Work of moving supports.
    prescribed_work: f64,
    /// Angular impulse of moving supports in addition to that of the reactions.
    slip_moment: [f64; 3],
    /// Contribution of this step's loads and of its obstacle forces to the force history of a scheme that keeps one.
    own: [Vec<f64>; 2],
}

impl Outside {
    /// Work of loads, obstacles and prescribed motions in a step with the displacement `moved`.
    fn work(&self, moved: &[f64]) -> f64 {
        let loads = self.load.iter().zip(moved).map(|(load, moved)| load * moved).sum::<f64>();
        loads + self.obstacle_work + self.prescribed_work
    }

    /// Adds the velocities of an impact to those of the step, and the work of obstacles in the impact.
    fn add_jump(&mut self, jump: Option<&VelocityCorrection>, v_1: &mut [f64]) {
        if let Some(jump) = jump {
            v_1.iter_mut().zip(&jump.velocity).for_each(|(v, w)| *v += w);
            self.obstacle_work += jump.work;
        }
    }

    /// True if loads or obstacles do work or exert forces.
    fn pushes(&self) -> bool {
        self.obstacle_work != 0.0 || self.load.iter().any(|f| *f != 0.0)
    }
}

/// Weighted gaps in the penalty potentials, of every constraint.
fn penalty_gaps(at: &Linearization, conditions: &Conditions) -> Vec<f64> {
    let gaps = at.pairs.iter().flat_map(|pair| pair.gap.iter());
    let mut shifted_gaps: Vec<f64> = gaps.zip(&conditions.shift).map(|(gap, shift)| gap + shift).collect();
    shifted_gaps.resize(conditions.shift.len(), 0.0);
    shifted_gaps
}

/// States of the constraints in a step; constraints that were active in its impact count as closed.
fn touched(active: &[RowState], jump: Option<&VelocityCorrection>) -> Vec<RowState> {
    let mut touched = active.to_vec();
    jump.iter().flat_map(|jump| &jump.closed).for_each(|&row| touched[row] = RowState::Closed);
    touched
}

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// The state at the end of a converged step, with its row of the ledger.
    ///
    /// # Errors
    /// A time function failed at the start of the step.
    pub fn accept(
        &mut self,
        start: &StepStart,
        motion: &Motion,
        solution: Solution,
        conditions: &Conditions,
        jump: Option<VelocityCorrection>,
    ) -> Result<State, StepError> {
        let lambda = solution.multipliers();
        let Solution { mut at, active, preferred } = solution;
        self.system.lead_end(&mut at);
        let search = self.system.search();
        let (system, dt) = (&self.system, motion.dt);
        let penalty_gap = penalty_gaps(&at, conditions);
        let mut v_1 = motion.velocities(&at.moved, &system.supports.prescribed);
        let mut outside = self.outside(start, motion, &at, &lambda, &v_1)?;
        let scheme_history = self.scheme_history_after(start, motion, &at, &v_1, &outside.own);
        outside.add_jump(jump.as_ref(), &mut v_1);
        system.lead(&mut v_1);
        let old = &self.state.row;
        let reserve = jump.as_ref().map_or_else(|| self.state.reserve.clone(), |jump| jump.reserve.clone());
        let touched = touched(&active, jump.as_ref());
        let (memory, heats) = self.memory_after(start, &at)?;
        let accelerations = self.accelerations_to(&v_1, dt);
        let mut row = self.row_at_end(dt, &at, [&v_1, &accelerations], (&memory, &heats), &touched);
        row.reserve = reserve.iter().sum();
        [row.dissipation, row.damping, row.numerical] = heat(&heats.all, &row.parts, self.taken(start, &at, jump.as_ref()));
        row.impact = jump.as_ref().map_or(0.0, |jump| jump.impact);
        row.dissipation += row.impact;
        row.book_plastic(&system.bodies, old, &heats.plastic);
        row.potential = self.potential(&at, &penalty_gap, &memory) + row.reserve;
        row.load_work = outside.work(&at.moved);
        row.contact_work = self.contact_work(start, &lambda, conditions, jump.as_ref(), row.reserve);
        row.joints = self.joints_after(start, &at, &lambda, &outside.drive_works);
        let frictional = self.friction_work(&at, &lambda, jump.as_ref());
        row.book_friction(&frictional);
        row.energy_defect = row.total() - old.total() - row.load_work - row.contact_work - row.friction_work + row.dissipation;
        self.book_momentum_defects(&mut row, start, &at, &outside, jump.as_ref());
        let mut slipped = slipped(system, &self.state.slipped, &at, 0.0, (&lambda, &active));
        jump.iter().for_each(|jump| add_heat(&mut slipped, &jump.friction[system.normal_count..]));
        let touching = EvaluatedContacts::of(&at, &lambda, &touched, &slipped);
        self.book_contacts(&mut row, &touching, jump.as_ref(), &frictional);
        row.reactions = self.reactions_after(start, &at, &lambda, jump.as_ref())?;
        let pushed = self.state.pushed + dt * at.forces.scale;
        row.work_round_off = self.work_round_off(pushed / (start.time + dt), &at.q_1);
        let state = State {
            drift: self.state.drift + row.energy_defect,
            pushed,
            row,
            positions: at.q_1.clone(),
            displacements: at.u_1.clone(),
            accelerations,
            velocities: v_1,
            lambda,
            penalty_gap,
            reserve,
            active: rested(system, &at, active),
            slipped,
            scheme_history,
            memory,
            clock: self.state.clock,
            search,
            level: self.state.level,
            pace: self.state.pace.clone(),
            preferred,
            slips_until: self.state.slips_until,
            loads_ended: if outside.pushes() { start.time + dt } else { self.state.loads_ended },
        };
        self.system.recycle(at);
        Ok(state)
    }

    /// Reactions of supports and couplings in a step, with the impulses of its impact.
    fn reactions_after(
        &self,
        start: &StepStart,
        at: &Linearization,
        lambda: &[f64],
        jump: Option<&VelocityCorrection>,
    ) -> Result<Vec<Reaction>, StepError> {
        let middle = |k: usize| 0.5 * (start.q_0[k] + at.q_1[k]);
        let pushed = |k: usize| jump.map_or(0.0, |jump| jump.impulse[k] / start.dt());
        let mut reactions = self.reactions(middle, |k| at.forces.without_contact[k] - at.forces.contact[k] + pushed(k));
        reactions.extend(self.coupling_reactions(middle, at, lambda, start.time + start.dt())?);
        Ok(reactions)
    }

    /// Mean accelerations in a step from the present state to the velocities `v_1`.
    pub(super) fn accelerations_to(&self, v_1: &[f64], dt: f64) -> Vec<f64> {
        v_1.iter().zip(&self.state.velocities).map(|(v_1, v_0)| (v_1 - v_0) / dt).collect()
    }

    /// Potential energy at the end of a step, excluding the stored impact energy of active contacts.
    pub(super) fn potential(&self, at: &Linearization, penalty_gap: &[f64], memory: &[Vec<f64>]) -> f64 {
        let system = &self.system;
        system.nodes.potential_energy(&at.q_1) + system.penalty_energy(penalty_gap) + system.stored_energy(at.pose(), memory)
    }

    /// Sums over the contacts, with the work of friction in each.
    pub(super) fn book_contacts(
        &self,
        row: &mut LedgerRow,
        touching: &EvaluatedContacts,
        jump: Option<&VelocityCorrection>,
        frictional: &[f64],
    ) {
        let pressed = |jump: &VelocityCorrection| touching.lambda.iter().zip(&jump.lambda).map(|(lambda, jump)| lambda + jump).collect();
        let normal: Option<Vec<f64>> = jump.map(pressed);
        let touching = EvaluatedContacts { lambda: normal.as_deref().unwrap_or(touching.lambda), ..*touching };
        row.contacts = self.contact_totals(&touching);
        row.contacts.iter_mut().zip(frictional).for_each(|(contact, work)| contact.friction_work = *work);
        row.max_penetration = row.contacts.iter().map(|contact| contact.penetration).fold(0.0, f64::max);
    }

    /// History variables of the parts after a step, and the dissipation of each part in the step.
    pub(super) fn memory_after(&self, start: &StepStart, at: &Linearization) -> Result<(PartHistories, PartDissipation), StepError> {
        let remembers = self.state.memory.iter().any(|memory| !memory.is_empty()) || !self.system.others.is_empty();
        if remembers { self.system.memory_after(start, at) } else { Ok((self.state.memory.clone(), PartDissipation::default())) }
    }

    /// History variables of the time integrator after this step; unchanged for a scheme without any.
    fn scheme_history_after(
        &self,
        start: &StepStart,
        motion: &Motion,
        at: &Linearization,
        v_1: &[f64],
        outside: &[Vec<f64>; 2],
    ) -> Arc<SchemeHistory> {
        let (scheme, before) = (motion.scheme, motion.scheme_history);
        if scheme.remembers.is_empty() {
            return self.state.scheme_history.clone();
        }
        let mut scheme_history = SchemeHistory { of: before.of.clone(), dt: motion.dt, ..SchemeHistory::default() };
        if scheme.remembers(History::Force) {
            let mut own = self.own_forces(motion, &at.forces, v_1);
            self.system.alone_into(start, at, &mut own);
            scheme_history.force = before.force.after(scheme, &own);
        }
        if scheme.remembers(History::Acceleration) {
            scheme_history.acceleration = motion.accelerations_after(&at.moved);
        }
        let lagging = before.outside.iter().zip(outside).map(|(before, own)| before.after(scheme, own));
        scheme_history.outside.iter_mut().zip(lagging).for_each(|(slot, lagging)| *slot = lagging);
        Arc::new(scheme_history)
    }

    /// Part of the static forces of this step, including contact: the residual is the sum of inertia, this part and the force history.
    fn own_forces(&self, motion: &Motion, forces: &Forces, v_1: &[f64]) -> Vec<f64> {
        let Motion { dt, v_0, .. } = *motion;
        let rate: Vec<f64> = v_1.iter().zip(v_0).map(|(v_1, v_0)| (v_1 - v_0) / dt).collect();
        let inertia = self.system.nodes.momenta_of(&rate);
        let own = (0..v_1.len()).zip(motion.remembered_force());
        own.map(|(k, scheme_history)| forces.without_contact[k] - forces.contact[k] - inertia[k] - scheme_history).collect()
    }

    /// External forces in a step, with the weights that the time integrator gives to start and end.
    fn outside(&self, start: &StepStart, motion: &Motion, at: &Linearization, lambda: &[f64], v_1: &[f64]) -> Result<Outside, StepError> {
        let (system, scheme, unknowns) = (&self.system, motion.scheme, at.q_1.len());
        let (is_long, remembers) = (self.options.integrator.is_long(), scheme.remembers(History::Force));
        let mut load = at.forces.load.clone();
        let (mut obstacles, mut obstacle_work, mut drive_works) = (vec![0.0; unknowns], 0.0, Vec::new());
        if let Some([internal, _]) = system.outside_of(start, [&at.q_1, &at.u_1, &at.moved])? {
            obstacles.iter_mut().zip(&internal).for_each(|(sum, force)| *sum -= scheme.weight * force);
        }
        // Multipliers at the start of the step do work; their forces belong to the force history.
        let (before, mut at_start) = (if is_long { 0.0 } else { 1.0 - scheme.weight }, vec![0.0; if is_long { 0 } else { unknowns }]);
        for (index, pair) in system.pairs.iter().enumerate().filter(|(_, pair)| !pair.forces_stay_in_step()) {
            let shares = |lambda: &[f64], share: f64| -> Vec<f64> { lambda[pair.rows.clone()].iter().map(|x| share * x).collect() };
            let (none, own) = (vec![0.0; pair.rows.len()], shares(lambda, scheme.weight));
            let mut work = pair.kernel.obstacle_force_into(scheme.derivative, &at.q_1, &none, &own, &mut obstacles);
            if before > 0.0 {
                let lambda_n = shares(&self.state.lambda, before);
                work += pair.kernel.obstacle_force_into(scheme.derivative, &at.q_1, &lambda_n, &none, &mut at_start);
            }
            obstacle_work += work;
            drive_works.extend(pair.drive.as_ref().map(|_| (index, if is_long { work / scheme.weight } else { work })));
        }
        if is_long {
            // The work of moving obstacles is that of the end forces over the whole step.
            obstacle_work /= scheme.weight;
        }
        let own = if remembers { [load.clone(), obstacles.clone()] } else { [Vec::new(), Vec::new()] };
        for (index, pair) in system.pairs.iter().enumerate().filter(|(_, pair)| pair.forces_stay_in_step()) {
            let (none, end_share) = (vec![0.0; pair.rows.len()], start.end_share_of(pair));
            let mut work = 0.0;
            for (derivative, share) in [(start.derivative_of(pair), 1.0 - end_share), (Derivative::AT_END, end_share)] {
                let own: Vec<f64> = lambda[pair.rows.clone()].iter().map(|lambda| share * lambda).collect();
                work += pair.kernel.obstacle_force_into(derivative, &at.q_1, &none, &own, &mut obstacles);
            }
            obstacle_work += work;
            drive_works.extend(pair.drive.as_ref().map(|_| (index, work)));
        }
        drive_works.sort_by_key(|(index, _)| *index);
        let drive_works = drive_works.into_iter().map(|(_, work)| work).collect();
        let is_grounded = |pair: &ContactPair| pair.reaction.as_ref().is_some_and(|reaction| reaction.is_grounded);
        let is_outside = |block: &RowBlock| block.is_slip() && (block.pair.kind == PairKind::Obstacle || is_grounded(block.pair));
        for block in system.blocks(&at.pairs, &at.slips).filter(is_outside) {
            let mut work = 0.0;
            for row in block.live_rows() {
                for (k, entry) in row.unknowns::<D>() {
                    let force = lambda[row.row] * block.evaluation.gradient_bar[entry];
                    obstacles[k] += force;
                    work += force * at.moved[k];
                }
            }
            if block.pair.kind == PairKind::Obstacle {
                // The work on the slip is that of friction, the rest that of the obstacle's motion.
                obstacle_work += work - block.work(lambda);
            }
        }
        let (prescribed_work, slip_moment) =
            if system.supports.prescribed.is_empty() { Default::default() } else { self.prescribed_work(motion, at, v_1) };
        if remembers {
            for (force, lagging) in [&mut load, &mut obstacles].into_iter().zip(&motion.scheme_history.outside) {
                force.iter_mut().zip(&lagging.left).for_each(|(force, left)| *force += scheme.lag.used * left);
            }
        }
        Ok(Outside { load, obstacles, obstacle_work, drive_works, prescribed_work, slip_moment, own })
    }

    /// Work of friction with these multipliers, contact by contact `[energy]`.
    pub(super) fn friction_work(&self, at: &Linearization, shear: &[f64], jump: Option<&VelocityCorrection>) -> Vec<f64> {
        self.system.by_contact(|index, pair| {
            let slips = pair.blocks([&at.pairs[index], &at.slips[index]]).filter(RowBlock::is_slip);
            let at_once = |jump: &VelocityCorrection| pair.tangential().map(|(row, _)| jump.friction[row]).sum::<f64>();
            slips.map(|block| block.friction_work(shear)).sum::<f64>() + jump.map_or(0.0, at_once)
        })
    }

    /// Row of the ledger at the end of a step with its energies, momenta and values of parts, without works and contacts. `memory`,
    /// `heats`: history variables of the parts and their heats; `touched`: contact state of every constraint.
    pub(super) fn row_at_end(
        &self,
        dt: f64,
        at: &Linearization,
        [v_1, accelerations]: [&[f64]; 2],
        (memory, heats): (&PartHistories, &PartDissipation),
        touched: &[RowState],
    ) -> LedgerRow {
        let (system, momenta) = (&self.system, self.system.nodes.momenta_of(v_1));
        LedgerRow {
            step: self.state.row.step + 1,
            dt,
            kinetic: half_product(v_1, &momenta),
            strain: system.strain_energy(&at.u_1, memory),
            active: system.touching(touched),
            momentum: system.nodes.resultant(&momenta),
            angular_momentum: system.nodes.moment(&at.q_1, &momenta),
            parts: system.part_totals(at.pose(), v_1, memory, &heats.all),
            probes: self.probe_values(&at.u_1, v_1, accelerations),
            ..LedgerRow::default()
        }
    }

    /// Work of a force on the round-off of the positions `positions` `[energy]`.
    fn work_round_off(&self, force: f64, positions: &[f64]) -> f64 {
        tolerances::WORK_ROUND_OFF * force * largest_size(positions).max(self.system.nodes.extent)
    }

    /// Work of contact that the update rules remove or add by design `[energy]`; `reserve`: stored impact energy of the new state.
    fn contact_work(
        &self,
        start: &StepStart,
        lambda: &[f64],
        conditions: &Conditions,
        jump: Option<&VelocityCorrection>,
        reserve: f64,
    ) -> f64 {
        let (system, old) = (&self.system, &self.state.row);
        let ForceShares { lagging, alone } = start.shares();
        let closing = |of: &dyn Fn(&ContactPair) -> bool| -> f64 {
            let held = system.pairs.iter().filter(|pair| pair.has_multipliers() && of(pair));
            held.flat_map(|pair| pair.rows.clone()).map(|row| lambda[row] * (conditions.targets[row] - conditions.gap_n[row])).sum()
        };
        let closed = match lagging == alone {
            true => lagging * closing(&|_| true),
            false => lagging * closing(&|pair| !pair.forces_stay_in_step()) + alone * closing(&ContactPair::forces_stay_in_step),
        };
        // If facet pairs have entered or left since the previous step, the penalty energy at the start differs from the stored one.
        let found = if system.pairs.iter().any(|pair| !pair.penalties.is_empty()) && !conditions.end_point {
            system.nodes.potential_energy(start.q_0)
                + system.penalty_energy(&conditions.gap_n)
                + system.stored_energy(start.pose(), &self.state.memory)
                + old.reserve
                - old.potential
        } else {
            0.0
        };
        let kept = reserve - old.reserve;
        found + closed + jump.map_or(0.0, |jump| jump.energy + jump.impact) + kept
    }

    /// Books the momentum defects of a step: changes of the momenta that loads, weight and support reactions (the residual) do not explain.
    fn book_momentum_defects(
        &self,
        row: &mut LedgerRow,
        start: &StepStart,
        at: &Linearization,
        outside: &Outside,
        jump: Option<&VelocityCorrection>,
    ) {
        let (system, old, dt) = (&self.system, &self.state.row, row.dt);
        let (mut external, mut turning) = ([0.0; 3], [0.0; 3]);
        for node in 0..system.nodes.count() {
            let (mut force, mut middle) = ([0.0; D], [0.0; D]);
            for i in 0..D {
                let k = node * D + i;
                force[i] = outside.load[k] + (system.nodes.weight[k] + outside.obstacles[k]);
                if system.supports.fixed[k] {
                    force[i] += at.forces.without_contact[k] - at.forces.contact[k];
                }
                middle[i] = 0.5 * (at.q_1[k] + start.q_0[k]);
            }
            add_force(&mut external, &force);
            add_moment(&mut turning, &middle, &force);
        }
        let impulse = jump.map_or(&[][..], |jump| &jump.impulse);
        if system.nodes.is_axisymmetric {
            (external, turning) = ([0.0, external[1], 0.0], [0.0; 3]);
        }
        let changes = |force: [f64; 3], impulse: [f64; 3]| [force.map(|x| dt * x), impulse];
        row.momentum_defect = unexplained([row.momentum, old.momentum], changes(external, system.nodes.resultant(impulse)));
        let mut impulse = system.nodes.moment(&at.q_1, impulse);
        (0..3).for_each(|i| impulse[i] += outside.slip_moment[i]);
        row.angular_momentum_defect = unexplained([row.angular_momentum, old.angular_momentum], changes(turning, impulse));
    }

    /// Work of the reactions at prescribed nodes, and their angular momentum from the difference between the displacements `dq` and the
    /// velocities of the time functions: inertia forces work on `dt (v_0 + v_1)/2`, all others on `dq`.
    fn prescribed_work(&self, motion: &Motion, at: &Linearization, v_1: &[f64]) -> (f64, [f64; 3]) {
        let (Motion { dt, v_0, .. }, unknowns) = (*motion, at.q_1.len());
        let change: Vec<f64> = (0..unknowns).map(|k| (v_1[k] - v_0[k]) / dt).collect();
        let mean: Vec<f64> = (0..unknowns).map(|k| 0.5 * (v_1[k] + v_0[k])).collect();
        let (inertia, momentum) = (self.system.nodes.momenta_of(&change), self.system.nodes.momenta_of(&mean));
        let (mut slip, mut work) = (vec![0.0; unknowns], 0.0);
        for k in self.system.supports.prescribed.iter().map(|prescribed| prescribed.unknown) {
            let reaction = at.forces.without_contact[k] - at.forces.contact[k];
            let moved = at.moved[k];
            slip[k] = moved - dt * mean[k];
            work += inertia[k] * dt * mean[k] + (reaction - inertia[k]) * moved;
        }
        (work, self.system.nodes.moment(&slip, &momentum))
    }
}
