//! Evaluations for explicit steps: forces, nodal motions and contacts at given positions.

use std::time::Instant;

use super::equations::Equations;
use super::failure::Failure;
use super::iterate::Linearization;
use super::start::{IterateInputs, StepStart};
use super::system::System;
use crate::bodies::{Elements, Space};
use crate::contact::{Evaluation, PredictedMotion};
use crate::dynamics::model::part::{Iterate, Sums};
use crate::dynamics::parts::contact_pair::ContactPair;
use crate::dynamics::parts::laws::Row;
use crate::integrators::Derivative;
use crate::linear::LinearError;

/// Forces at positions, component by component `[force]`.
#[derive(Default)]
pub struct PartForces {
    /// Forces of potentials and dampers with the sign of the residual, opposite to the motion that they drive.
    pub internal: Vec<f64>,
    /// Loads, without constant gravity.
    pub load: Vec<f64>,
    /// Internal forces exerted by the ground; empty without parts that are attached to it.
    pub ground: Vec<f64>,
}

impl<const D: usize> System<D>
where
    Space<D>: Elements<D>,
{
    /// Starts an explicit step, which solves no equations; otherwise like [`Self::begin_step`].
    ///
    /// # Errors
    /// The contacts do not fit into memory.
    pub fn begin_explicit_step(&mut self, predicted_motion: &PredictedMotion) -> Result<(), LinearError> {
        if self.find_candidates(predicted_motion, &[]) {
            self.matrix.is_stale = true;
            self.ensure_patches().map_err(|shortage| LinearError::out_of_memory(self.nodes.reference.len(), shortage))?;
        }
        self.begin_pairs(predicted_motion);
        Ok(())
    }

    /// Forces of all parts at the end of a motion, without a matrix.
    ///
    /// # Errors
    /// A cell is inverted, a time function failed, or forces are not finite.
    pub fn part_forces(&mut self, start: &StepStart, at: &Linearization) -> Result<PartForces, Failure> {
        let clock = Instant::now();
        let mut told = std::mem::take(&mut self.spare.told);
        self.visit(start, &at.q_1, &at.moved, &mut told);
        let forces = self.forces_of(&Iterate { weight: 1.0, ..start.iterate(&at.q_1, &at.u_1, &told) }, start.memory);
        self.spare.told = told;
        self.counters.assemblies += 1;
        self.counters.times.assembly += clock.elapsed();
        let forces = forces?;
        if forces.internal.iter().chain(&forces.load).any(|force| !force.is_finite()) {
            return Err(Failure::Diverged);
        }
        Ok(forces)
    }

    /// Evaluates all contact pairs at the positions `q`, with obstacles at their place at the end of the step.
    pub fn evaluate_pairs(&mut self, q: &[f64], pairs: &mut Vec<Evaluation>) {
        let clock = Instant::now();
        let none = vec![0.0; self.multipliers];
        pairs.resize_with(self.pairs.len(), Evaluation::default);
        for (pair, evaluation) in self.pairs.iter().zip(pairs) {
            pair.kernel.evaluate(Derivative::AT_END, q, &none[pair.rows.clone()], evaluation);
        }
        self.counters.times.contact += clock.elapsed();
    }
}

impl<const D: usize> Equations<D>
where
    Space<D>: Elements<D>,
{
    /// Sets positions and displacements after a motion, consistent with [`Self::linearize`].
    pub fn place_after(&self, start: &StepStart, at: &mut Linearization) {
        if self.depends_on_positions() {
            let Linearization { q_1, moved, .. } = at;
            q_1.clear();
            q_1.extend(start.q_0.iter().zip(moved.iter()).map(|(q, moved)| q + moved));
        }
        self.displace(start, at);
    }

    fn forces_of(&self, iterate: &Iterate, memory: &[Vec<f64>]) -> Result<PartForces, Failure> {
        let unknowns = iterate.q_1.len();
        let mut forces = PartForces { internal: vec![0.0; unknowns], load: vec![0.0; unknowns], ground: Vec::new() };
        let mut sums = Sums { internal: &mut forces.internal, load: &mut forces.load, tangent: None, workers: &self.workers };
        self.parts().zip(memory).try_for_each(|(part, memory)| part.linearize(iterate, memory, &mut sums))?;
        if self.own_parts(memory).any(|(part, _)| part.is_outside()) {
            let (mut ground, mut loads) = (vec![0.0; unknowns], vec![0.0; unknowns]);
            let mut sums = Sums { internal: &mut ground, load: &mut loads, tangent: None, workers: &self.workers };
            for (part, memory) in self.own_parts(memory).filter(|(part, _)| part.is_outside()) {
                part.linearize(iterate, memory, &mut sums)?;
            }
            forces.ground = ground;
        }
        Ok(forces)
    }

    /// Change of the internal forces along a motion of all nodes `[force]`: stiffness times motion plus damping times motion over `dt`, as
    /// a central difference with the factor `size` of the motion.
    ///
    /// # Errors
    /// A cell is inverted.
    pub fn force_change(&self, start: &StepStart, motion: &[f64], dt: f64, size: f64) -> Result<Vec<f64>, Failure> {
        let told = IterateInputs::default();
        let at = |size: f64| -> Result<Vec<f64>, Failure> {
            let moved = |from: &[f64]| -> Vec<f64> { from.iter().zip(motion).map(|(from, x)| from + size * x).collect() };
            let (q_1, u_1) = (moved(start.q_0), moved(start.u_0));
            let velocity: Vec<f64> = motion.iter().map(|x| size * x / dt).collect();
            let iterate = start.iterate(&q_1, &u_1, &told);
            let iterate =
                Iterate { weight: 1.0, dt, q_test: &q_1, velocity: &velocity, velocity_slope: 1.0 / dt, is_still: false, ..iterate };
            Ok(self.forces_of(&iterate, start.memory)?.internal)
        };
        let (ahead, behind) = (at(size)?, at(-size)?);
        Ok(ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * size)).collect())
    }

    /// Nodal forces of the multipliers of the chosen pairs `[force]`.
    pub fn pressed(&self, pairs: &[Evaluation], lambda: &[f64], chosen: impl Fn(&ContactPair) -> bool) -> Vec<f64> {
        let mut forces = vec![0.0; self.nodes.reference.len()];
        for (pair, evaluation) in self.pairs.iter().zip(pairs).filter(|(pair, _)| chosen(pair)) {
            for row in pair.live_rows(evaluation).filter(|row| lambda[row.row] != 0.0) {
                row.unknowns::<D>().for_each(|(k, entry)| forces[k] += lambda[row.row] * evaluation.gradient_end[entry]);
            }
        }
        forces
    }

    /// Writes the pressures of penalties at evaluations.
    pub fn press_by_penalties(&self, pairs: &[Evaluation], lambda: &mut [f64]) {
        for (pair, evaluation) in self.pairs.iter().zip(pairs).filter(|(pair, _)| !pair.has_multipliers()) {
            for (local, row) in pair.rows.clone().enumerate() {
                lambda[row] = pair.law.pressure(&at_rest(pair, row, evaluation.gap[local]));
            }
        }
    }
}

/// Constraint with a potential at a gap, at rest.
pub(super) fn at_rest(pair: &ContactPair, row: usize, gap: f64) -> Row {
    Row {
        gap,
        lambda: 0.0,
        gap_n: gap,
        target: 0.0,
        shift: 0.0,
        end_point: true,
        compliance: 0.0,
        c: pair.c,
        stiffness: pair.penalty(row).unwrap_or(0.0),
        tolerance: pair.gap_tolerance,
    }
}
