//! The end of a converged step: velocities, what an impact gives back, the row of the ledger.

use std::sync::Arc;

use super::impact::Jump;
use super::ledger::LedgerRow;
use super::newton::Solution;
use super::pairs::Conditions;
use super::simulation::State;
use super::system::{Forces, StepStart, add_force, add_moment, half_product, moment, resultant};
use super::time_loop::TimeLoop;
use crate::bodies::{Elements, Space};
use crate::integrators::Integrator;

impl<const D: usize> TimeLoop<D>
where
    Space<D>: Elements<D>,
{
    /// The state at the end of a converged step, with its row of the ledger.
    pub(super) fn accept(&mut self, start: &StepStart, solution: Solution, conditions: &Conditions, jump: Option<Jump>) -> State {
        let Solution { q_1, mut lambda, active, mut forces, iterations } = solution;
        let search = self.system.search();
        let (system, dt, unknowns) = (&self.system, start.dt, q_1.len());
        for (lambda, _) in lambda.iter_mut().zip(&active).filter(|(_, active)| !**active) {
            *lambda = 0.0;
        }
        let gaps = system.pairs.iter().flat_map(|pair| pair.evaluation.gap.iter());
        let felt: Vec<f64> = gaps.zip(&conditions.shift).map(|(gap, shift)| gap + shift).collect();
        let mut v_1: Vec<f64> = (0..unknowns).map(|k| 2.0 / dt * (q_1[k] - start.q_0[k]) - start.v_0[k]).collect();
        for (prescribed, v) in system.prescribed.iter().zip(start.prescribed_v_1) {
            v_1[prescribed.unknown] = *v;
        }
        let half_force = if start.integrator == Integrator::Trapezoidal {
            // r = inertia + new half + old half, so the new half is what is left after the inertia.
            let rate: Vec<f64> = (0..unknowns).map(|k| (v_1[k] - start.v_0[k]) / dt).collect();
            let mut inertia = vec![0.0; unknowns];
            system.mass.multiply_into::<D>(&rate, &mut inertia);
            let new = |k: usize| forces.without_contact[k] - forces.contact[k] - inertia[k] - start.half_force[k];
            Arc::new((0..unknowns).map(new).collect())
        } else {
            self.state.half_force.clone()
        };
        let v_before = jump.is_some().then(|| v_1.clone());
        let reserve = jump.as_ref().map_or_else(|| self.state.reserve.clone(), |jump| jump.reserve.clone());
        if let Some(jump) = &jump {
            v_1.iter_mut().zip(&jump.velocity).for_each(|(v, w)| *v += w);
        }
        let momenta = system.nodal_momenta(&v_1);
        let old = &self.state.row;
        let mut row = LedgerRow {
            step: old.step + 1,
            dt,
            kinetic: half_product(&v_1, &momenta),
            strain: system.strain_energy(&q_1),
            reserve: reserve.iter().sum(),
            newton_iterations: iterations,
            active: system.touching(&active),
            ..LedgerRow::default()
        };
        row.potential = system.potential_energy(&q_1) + system.penalty_energy(&felt) + row.reserve;
        (row.momentum, row.angular_momentum) = (resultant::<D>(&momenta), moment::<D>(&q_1, &momenta));

        // The trapezoidal rule's forces are the mean of both ends; the load of the start is part of the half force.
        let weight = start.integrator.placement().weight;
        let mut load = std::mem::take(&mut forces.load);
        if start.integrator == Integrator::Trapezoidal {
            let mut load_n = vec![0.0; unknowns];
            if system.loads_into(start.q_0, start.time, &mut load_n).is_ok() {
                load.iter_mut().zip(&load_n).for_each(|(load, n)| *load += 0.5 * n);
            }
        }
        row.load_work = (0..unknowns).map(|k| load[k] * (q_1[k] - start.q_0[k])).sum();
        // Rigid obstacles push from outside, and do work where they move.
        let mut obstacle_force = vec![0.0; unknowns];
        let mut obstacle_work = 0.0;
        for pair in &system.pairs {
            let (lambda_n, lambda) = (&self.state.lambda[pair.rows.clone()], &lambda[pair.rows.clone()]);
            obstacle_work += pair.kernel.obstacle_force_into(start.integrator, &q_1, lambda_n, lambda, &mut obstacle_force);
        }
        obstacle_work += jump.as_ref().map_or(0.0, |jump| jump.work);
        row.load_work += obstacle_work;
        let mut slip_moment = [0.0; 3];
        if !system.prescribed.is_empty() {
            let (work, moment) = self.prescribed_work(start, &forces, &q_1, v_before.as_ref().unwrap_or(&v_1));
            row.load_work += work;
            slip_moment = moment;
        }
        let closing: f64 = system
            .pairs
            .iter()
            .filter(|pair| pair.penalty == 0.0)
            .flat_map(|pair| pair.rows.clone())
            .map(|row| lambda[row] * (conditions.targets[row] - conditions.gap_n[row]))
            .sum();
        // A potential that is felt through other pairs than at the end of the step before is another one.
        let found = if system.pairs.iter().any(|pair| pair.penalty > 0.0) && !conditions.end_point {
            system.potential_energy(start.q_0) + system.penalty_energy(&conditions.gap_n) + old.reserve - old.potential
        } else {
            0.0
        };
        let kept = row.reserve - old.reserve;
        row.contact_work = found + weight * closing + jump.as_ref().map_or(0.0, |jump| jump.energy) + kept;
        row.energy_defect = row.total() - old.total() - row.load_work - row.contact_work;

        // Reactions of supports are the residual there; with loads and weight they explain the change of the momenta.
        let (mut external, mut turning) = ([0.0; 3], [0.0; 3]);
        for node in 0..unknowns / D {
            let (mut force, mut middle) = ([0.0; D], [0.0; D]);
            for i in 0..D {
                let k = node * D + i;
                force[i] = load[k] + (system.weight[k] + obstacle_force[k]);
                if system.fixed[k] {
                    force[i] += forces.without_contact[k] - forces.contact[k];
                }
                middle[i] = 0.5 * (q_1[k] + start.q_0[k]);
            }
            add_force(&mut external, &force);
            add_moment(&mut turning, &middle, &force);
        }
        let impulse = jump.as_ref().map_or(&[][..], |jump| &jump.impulse);
        let unexplained = |new: [f64; 3], old: [f64; 3], rate: [f64; 3], impulse: [f64; 3]| {
            (0..3).map(|i| (new[i] - old[i] - dt * rate[i] - impulse[i]).abs()).fold(0.0, f64::max)
        };
        row.momentum_defect = unexplained(row.momentum, old.momentum, external, resultant::<D>(impulse));
        let mut impulse = moment::<D>(&q_1, impulse);
        (0..3).for_each(|i| impulse[i] += slip_moment[i]);
        row.angular_momentum_defect = unexplained(row.angular_momentum, old.angular_momentum, turning, impulse);

        let pressing: Vec<f64> = match &jump {
            Some(jump) => lambda.iter().zip(&jump.lambda).map(|(lambda, jump)| lambda + jump).collect(),
            None => lambda.clone(),
        };
        row.contacts = self.contact_totals(&q_1, &pressing, &active);
        row.max_penetration = row.contacts.iter().map(|contact| contact.penetration).fold(0.0, f64::max);
        row.probes = self.probe_values(&q_1, &v_1);
        let acted = obstacle_work != 0.0 || load.iter().any(|f| *f != 0.0);
        State {
            row,
            positions: q_1,
            velocities: v_1,
            lambda,
            felt,
            reserve,
            active,
            half_force,
            clock: self.state.clock,
            search,
            level: self.state.level,
            loads_ended: if acted { start.time + dt } else { self.state.loads_ended },
        }
    }

    /// Work of the reactions that move the prescribed nodes, and the angular momentum that they give by moving them by `dq` while their
    /// velocities are those of the time functions: inertia forces work on `dt (v_0 + v_1)/2`, all others on `dq`.
    fn prescribed_work(&self, start: &StepStart, forces: &Forces, q_1: &[f64], v_1: &[f64]) -> (f64, [f64; 3]) {
        let unknowns = q_1.len();
        let change: Vec<f64> = (0..unknowns).map(|k| (v_1[k] - start.v_0[k]) / start.dt).collect();
        let mean: Vec<f64> = (0..unknowns).map(|k| 0.5 * (v_1[k] + start.v_0[k])).collect();
        let (mut inertia, mut momentum, mut slip) = (vec![0.0; unknowns], vec![0.0; unknowns], vec![0.0; unknowns]);
        self.system.mass.multiply_into::<D>(&change, &mut inertia);
        self.system.mass.multiply_into::<D>(&mean, &mut momentum);
        let mut work = 0.0;
        for k in self.system.prescribed.iter().map(|prescribed| prescribed.unknown) {
            let reaction = forces.without_contact[k] - forces.contact[k];
            let moved = q_1[k] - start.q_0[k];
            slip[k] = moved - start.dt * mean[k];
            work += inertia[k] * start.dt * mean[k] + (reaction - inertia[k]) * moved;
        }
        (work, moment::<D>(&slip, &momentum))
    }
}
