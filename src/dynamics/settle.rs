//! `settle`: equilibrium under the loads of the present time, by damped steps without inertia.

use std::sync::Arc;

use super::error::StepError;
use super::newton::{Failure, Task};
use super::pairs::Conditions;
use super::predictor;
use super::report::FailureCause;
use super::simulation::{Clock, SettleReport, State};
use super::system::StepStart;
use super::time_loop::{TimeLoop, solve};
use crate::bodies::{Elements, Space};
use crate::contact::Outlook;
use crate::integrators::Integrator;
use crate::math::tolerances;

/// Damped steps that `settle` takes at most.
const MAX_SETTLE_STEPS: usize = 60;

/// Damping of `settle` over the stiffness of the slowest elastic motion: small, so that few steps suffice, not zero, so that rigid motions
/// stay regular.
const SETTLE_DAMPING: f64 = 1e-5;

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
        let zero = vec![0.0; self.state.positions.len()];
        // Slowest elastic motion: wave speed over the largest extent.
        let density = self.model.bodies.iter().map(|body| body.material.density()).fold(f64::INFINITY, f64::min);
        let frequency_squared = self.system.modulus / density / self.system.extent.powi(2);
        let mut steps = 0;
        loop {
            let positions = self.state.positions.clone();
            let (displacement, _) = self.system.prescribed_motion(self.state.row.time)?;
            let mut predicted = positions.clone();
            predictor::follow_prescribed(&self.system, &positions, &displacement, &mut predicted);
            // Both sides may follow what is prescribed, and a facet more.
            let moved = predicted.iter().zip(&positions).fold(0.0, |largest: f64, (new, old)| largest.max((new - old).abs()));
            let size = self.system.pairs.iter().map(|pair| pair.kernel.facet_size()).fold(f64::INFINITY, f64::min);
            let outlook = Outlook::within(&positions, if size.is_finite() { 2.0 * size + 2.0 * moved } else { 0.0 });
            self.system.move_obstacles(self.state.row.time, 0.0)?;
            if let Err(error) = self.system.begin_step(&outlook) {
                return Err(self.failed(&Failure::Linear(error), 0.0, 0));
            }
            let start = StepStart {
                integrator: Integrator::Trapezoidal,
                time: self.state.row.time,
                dt: 0.0,
                q_0: &positions,
                v_0: &zero,
                half_force: &zero,
                prescribed_v_1: &[],
                damping: Some(SETTLE_DAMPING * frequency_squared),
            };
            let floor = tolerances::FORCE_FLOOR * self.system.modulus * self.system.extent.powi(D as i32);
            let energy = self.system.strain_energy(&positions).max(floor);
            let options = &self.options;
            // At rest every rule closes the gaps.
            let count = self.system.multipliers;
            let conditions = Conditions {
                gap_n: vec![0.0; count],
                targets: vec![0.0; count],
                members: vec![true; count],
                compliance: self.system.compliance(&start),
                end_point: true,
                shift: vec![0.0; count],
            };
            let task = Task {
                start: &start,
                predicted: &predicted,
                lambda: &self.state.lambda,
                conditions: &conditions,
                energy,
                tolerance: options.tolerance,
                interrupted: &|| options.interrupted(),
            };
            let outcome = solve(&mut self.system, &task, &mut self.statistics.newton_iterations, &mut self.trace);
            let solution = match outcome {
                Ok(solution) => solution,
                Err(Failure::Fatal(error)) => return Err(error),
                Err(failure) => return Err(self.failed(&failure, 0.0, 0)),
            };
            self.check_search(&outlook, &solution).map_err(|failure| self.failed(&failure, 0.0, 0))?;
            steps += 1;
            let strain = self.system.strain_energy(&solution.q_1);
            // What the damping did in this step: nothing, at equilibrium.
            let motion: Vec<f64> = solution.q_1.iter().zip(&positions).map(|(a, b)| a - b).collect();
            let dissipated = 2.0 * SETTLE_DAMPING * frequency_squared * self.system.kinetic_energy(&motion);
            let state = Arc::make_mut(&mut self.state);
            state.positions = solution.q_1;
            state.lambda = solution.lambda;
            state.active = solution.active;
            state.search = self.system.search();
            if dissipated <= 1e-14 * strain.max(floor) {
                break;
            }
            if steps == MAX_SETTLE_STEPS {
                let (body, how) = self.moving_body(&motion);
                let cause = FailureCause::NoEquilibrium { steps, dissipated, body, how };
                let report = self.evidence(0.0, 0).report_of(cause);
                return Err(self.given_up(report));
            }
        }
        let contacts = self.contact_totals(&self.state.positions, &self.state.lambda, &self.state.active);
        let probes = self.probe_values(&self.state.positions, &self.state.velocities);
        let State { positions: q, velocities: v, row, active, felt, reserve, .. } = Arc::make_mut(&mut self.state);
        row.strain = self.system.strain_energy(q);
        let gaps: Vec<f64> = self.system.pairs.iter().flat_map(|pair| pair.kernel.gap(q)).collect();
        row.potential = self.system.potential_energy(q) + self.system.penalty_energy(&gaps);
        *felt = gaps;
        reserve.fill(0.0);
        row.reserve = 0.0;
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
}
