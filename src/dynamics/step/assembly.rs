//! Sums of force elements and contact pairs at an iterate.
//!
//! The tangent of an iterate that is probably the last of its step is computed on demand, which is rare.

use std::sync::Arc;
use std::time::Instant;

use super::equations::Equations;
use super::failure::Failure;
use super::iterate::Linearization;
use super::start::{IterateInputs, StepStart, Stopping};
use super::system::System;
use crate::bodies::{Elements, Space};
use crate::contact::{Evaluation, SlipStep, TangentSink};
use crate::dynamics::model::part::{Iterate, Part, PartDissipation, PartHistories, Refusal, Sums};
use crate::dynamics::model::step_error::StepError;
use crate::dynamics::parts::contact_pair::{ContactPair, RowBlock};
use crate::integrators::{Configuration, Derivative};
use crate::math::norms::largest_size;
use crate::math::tolerances;

impl<const D: usize> System<D>
where
    Space<D>: Elements<D>,
{
    /// Returns the storage of an iterate for reuse.
    pub fn recycle(&mut self, at: Linearization) {
        self.spare.recycle(at);
    }

    /// The equations of a step at `q_1`, after a displacement `moved` in the step, with the multipliers `lambda`.
    ///
    /// If contacts or force elements depend on positions, strains follow from the rounded positions, too; otherwise from the displacements.
    ///
    /// # Errors
    /// A cell is inverted, a time function failed, or forces are not finite.
    pub fn linearize(&mut self, start: &StepStart, q_1: &[f64], moved: &[f64], lambda: &[f64]) -> Result<Linearization, Failure> {
        let (mut at, is_probably_last) = self.spare.next();
        for (own, values) in [(&mut at.moved, moved), (&mut at.lambda, lambda)] {
            own.clear();
            own.extend_from_slice(values);
        }
        if self.depends_on_positions() {
            at.q_1.clear();
            at.q_1.extend_from_slice(q_1);
        }
        self.displace(start, &mut at);
        at.tangent_of = None;
        self.counters.assemblies += 1;
        self.sum_parts(start, &mut at, !is_probably_last)?;
        self.sum_contacts(start, &mut at, !is_probably_last);
        Ok(at)
    }

    /// Computes the tangent of an iterate if it was omitted.
    pub fn complete_tangent(&mut self, start: &StepStart, at: &mut Linearization) -> Result<(), Failure> {
        if at.tangent_of != Some(self.matrix.generation) {
            self.sum_parts(start, at, true)?;
            let clock = Instant::now();
            self.evaluate_contacts(start, at, true);
            self.counters.times.contact += clock.elapsed();
        }
        Ok(())
    }

    /// Sums the forces of all force elements and of inertia, and their tangent if requested.
    fn sum_parts(&mut self, start: &StepStart, at: &mut Linearization, wants_tangent: bool) -> Result<(), Failure> {
        let clock = Instant::now();
        let Linearization { q_1, u_1, moved, forces, tangent, tangent_of, storage_of, .. } = at;
        let (unknowns, weight) = (q_1.len(), start.weight());
        let generation = Some(self.matrix.generation);
        if wants_tangent && *storage_of != generation {
            tangent.clear();
            tangent.resize(self.matrix.pattern.values(), 0.0);
            *storage_of = generation;
        }
        let (mut internal, mut motion) = (std::mem::take(&mut self.spare.internal), std::mem::take(&mut self.spare.motion));
        let mut told = std::mem::take(&mut self.spare.told);
        internal.resize(unknowns, 0.0);
        self.visit(start, q_1, moved, &mut told);
        forces.load.clear();
        forces.load.resize(unknowns, 0.0);
        let iterate = start.iterate(q_1, u_1, &told);
        let tangent = wants_tangent.then_some(&mut tangent[..]);
        let mut sums = Sums { internal: &mut internal, load: &mut forces.load, tangent, workers: &self.workers };
        self.parts().zip(start.memory).try_for_each(|(part, memory)| part.linearize(&iterate, memory, &mut sums))?;
        let chi = start.dissipation().strain;
        self.dampings.iter().filter(|_| chi > 0.0).for_each(|damping| damping.linearize(&iterate, chi, &mut sums));
        if let Some(values) = sums.tangent {
            self.add_point_inertia(|body| told.inertia[body], values);
            *tangent_of = generation;
        }

        start.opposed_into(moved, &self.supports.prescribed, &mut motion);
        let residual = &mut forces.without_contact;
        residual.clear();
        residual.resize(unknowns, 0.0);
        self.nodes.mass.multiply_into::<D>(&motion, residual);
        let (mut scale, mut opposing, mut internal_work) = (0.0f64, 0.0f64, 0.0);
        for (body, inertia) in self.bodies.iter().zip(&told.inertia) {
            for k in body.nodes.start * D..body.nodes.end * D {
                let inertial = inertia * residual[k];
                opposing = opposing.max(inertial.abs());
                forces.load[k] *= weight;
                internal_work += internal[k] * moved[k];
                let external = forces.load[k] + weight * self.nodes.weight[k];
                scale = scale.max(inertial.abs().max(internal[k].abs()).max(external.abs()));
                residual[k] = inertial + internal[k] - external;
            }
        }
        residual.iter_mut().zip(start.remembered_force()).for_each(|(residual, force)| *residual += force);
        (forces.weight, forces.scale, forces.opposing, forces.internal_work) = (weight, scale, opposing, internal_work);
        (self.spare.internal, self.spare.motion, self.spare.told) = (internal, motion, told);
        self.counters.times.assembly += clock.elapsed();
        if forces.without_contact.iter().any(|r| !r.is_finite()) {
            return Err(Failure::Diverged);
        }
        Ok(())
    }

    /// Evaluates the contact functions of all pairs, and adds their tangents to that of the iterate if requested.
    fn evaluate_contacts(&mut self, start: &StepStart, at: &mut Linearization, wants_tangent: bool) {
        let (shares, wants_tangent) = (start.shares(), wants_tangent && !self.is_far);
        let Linearization { q_1, moved, lambda, pairs, slips, tangent: values, .. } = at;
        pairs.resize_with(self.pairs.len(), Evaluation::default);
        slips.resize_with(self.pairs.len(), Evaluation::default);
        let pattern = &self.matrix.pattern;
        for ((pair, evaluation), slip) in self.equations.pairs.iter().zip(pairs.iter_mut()).zip(slips.iter_mut()) {
            let weight = if pair.forces_stay_in_step() { shares.alone } else { shares.lagging };
            let (derivative, end_share) = (start.derivative_of(pair), start.end_share_of(pair));
            let mut linearize = |derivative, share: f64, out: &mut Evaluation| {
                let mut add = |p: usize, tangent: &[f64]| pair.tangent_into::<D>((pattern, p), share * weight, tangent, values);
                let receiver: Option<&mut TangentSink> = if wants_tangent { Some(&mut add) } else { None };
                pair.kernel.linearize(derivative, q_1, &lambda[pair.rows.clone()], out, receiver);
            };
            if end_share != 0.0 && wants_tangent {
                linearize(Derivative::AT_END, end_share, &mut Evaluation::default());
            }
            linearize(derivative, 1.0 - end_share, evaluation);
            if derivative.placement().share < 1.0 {
                pair.follow_increment::<D>(moved, evaluation);
            }
            evaluation.shift_to_end(end_share);
            let mut add = |p: usize, tangent: &[f64]| pair.tangent_into::<D>((pattern, p), weight, tangent, values);
            if let Some(friction) = &pair.friction {
                let step = SlipStep { q_0: start.q_0, q_1, moved, test: start.friction_at(), live: &evaluation.live, wants_tangent };
                pair.kernel.evaluate_slips(step, &lambda[friction.rows.clone()], slip);
                if wants_tangent {
                    slip.hand_tangents_over(pair.kernel.slip_patches(), &mut add);
                } else {
                    slip.drop_tangent();
                }
            }
            pair.reaction.iter().for_each(|reaction| evaluation.gap[0] = reaction.limit(lambda));
        }
    }

    /// Evaluates the contact functions and contact forces of all pairs, with tangents if requested.
    fn sum_contacts(&mut self, start: &StepStart, at: &mut Linearization, wants_tangent: bool) {
        let clock = Instant::now();
        self.evaluate_contacts(start, at, wants_tangent);
        let shares = start.shares();
        let Linearization { q_1, moved, lambda, forces, pairs, slips, held, rests, .. } = at;
        forces.contact.clear();
        forces.contact.resize(q_1.len(), 0.0);
        for block in self.blocks(pairs, slips) {
            let share = block.share(shares);
            for row in block.live_rows() {
                let pressure = share * lambda[row.row];
                let gradient = &block.evaluation.gradient_bar[row.gradient];
                for (&node, gradient) in row.nodes.iter().zip(gradient.chunks_exact(D)) {
                    for i in 0..D {
                        forces.contact[node as usize * D + i] += pressure * gradient[i];
                    }
                }
            }
        }
        self.find_held(pairs, slips, held);
        self.find_rests(start, moved, pairs, slips, rests);
        forces.scale = forces.scale.max(largest_size(&forces.contact));
        self.counters.times.contact += clock.elapsed();
    }
}

impl<const D: usize> Equations<D>
where
    Space<D>: Elements<D>,
{
    /// Adds the contact forces that enter this step only (no later one), weighted by their share in its equations.
    pub fn alone_into(&self, start: &StepStart, at: &Linearization, forces: &mut [f64]) {
        let share = start.shares().alone;
        for block in self.blocks(&at.pairs, &at.slips).filter(|block| block.pair.forces_stay_in_step()) {
            for row in block.live_rows() {
                let pressure = share * at.lambda[row.row];
                row.unknowns::<D>().for_each(|(k, entry)| forces[k] += pressure * block.evaluation.gradient_bar[entry]);
            }
        }
    }

    /// Sets the displacements of an iterate: from its positions if forces depend on positions, otherwise positions and displacements from
    /// the displacement in the step.
    pub(super) fn displace(&self, start: &StepStart, at: &mut Linearization) {
        let Linearization { q_1, u_1, moved, .. } = at;
        u_1.clear();
        if self.depends_on_positions() {
            u_1.extend(q_1.iter().zip(&self.nodes.reference).map(|(q, x)| q - x));
        } else {
            u_1.extend(start.u_0.iter().zip(moved.iter()).map(|(u_0, moved)| u_0 + moved));
            self.nodes.positions_into(u_1, q_1);
        }
    }

    /// Adds the mass and `beta` times the material stiffness to values of the matrix.
    pub fn add_mass_and_stiffness(&self, u: &[f64], beta: f64, values: &mut [f64]) {
        self.bodies.iter().for_each(|body| body.elements.add_material_stiffness(u, beta, values));
        self.add_point_inertia(|_| 1.0, values);
    }

    /// Adds the nodal masses of other force elements, with a factor for each body.
    fn add_point_inertia(&self, factor: impl Fn(usize) -> f64, values: &mut [f64]) {
        for point in &self.point_masses {
            let inertia = factor(self.body_of(point.node as usize)) * point.mass;
            (0..D).for_each(|i| values[point.place.at(i, i)] += inertia);
        }
    }

    /// Writes velocities, positions of loads and mass factors at an iterate to `told`, as far as the force elements need them.
    pub(super) fn visit(&self, start: &StepStart, q_1: &[f64], moved: &[f64], told: &mut IterateInputs) {
        told.inertia.clear();
        told.inertia.extend((0..self.bodies.len()).map(|body| start.inertia(body)));
        let others = !self.others.is_empty();
        start.visit(q_1, moved, &self.supports.prescribed, [others || !self.loads.is_empty(), others], told);
    }

    /// History variables of the force elements after a step that ends at the iterate `at`, and the dissipation of each `[energy]`.
    ///
    /// # Errors
    /// A time function failed.
    pub fn memory_after(&self, start: &StepStart, at: &Linearization) -> Result<(PartHistories, PartDissipation), StepError> {
        let mut told = IterateInputs::default();
        self.visit(start, &at.q_1, &at.moved, &mut told);
        let iterate = start.iterate(&at.q_1, &at.u_1, &told);
        let mut heats = PartDissipation::default();
        let memories = self.parts().zip(start.memory).map(|(part, memory)| {
            let result = part.after_step(&iterate, memory)?;
            heats.push(&result);
            Ok(result.memory)
        });
        let memories = memories.collect::<Result<_, StepError>>()?;
        Ok((Arc::new(memories), heats))
    }

    /// History variables of all force elements after a step at rest, and the heat of each body in it `[energy]`. Only the variables of
    /// bodies change.
    ///
    /// # Errors
    /// The history variables of a body cannot be computed; no existing part returns this error.
    pub fn history_after(
        &self,
        start: &StepStart,
        at: &Linearization,
        memory: &PartHistories,
    ) -> Result<(PartHistories, PartDissipation), StepError> {
        if self.bodies.iter().all(|body| body.elements.history() == 0) {
            return Ok((memory.clone(), PartDissipation::default()));
        }
        let (mut after, told, mut heats) = (memory.to_vec(), IterateInputs::default(), PartDissipation::default());
        let iterate = start.iterate(&at.q_1, &at.u_1, &told);
        for (body, kept) in self.bodies.iter().zip(&mut after) {
            let result = body.after_step(&iterate, kept)?;
            heats.push(&result);
            *kept = result.memory;
        }
        Ok((Arc::new(after), heats))
    }

    /// Dissipation of the time integrator's viscous stress in a step that ends at the iterate `at` `[energy]`.
    pub fn dissipated_by_strains(&self, start: &StepStart, at: &Linearization) -> f64 {
        let (chi, told) = (start.dissipation().strain, IterateInputs::default());
        let iterate = start.iterate(&at.q_1, &at.u_1, &told);
        self.dampings.iter().filter(|_| chi > 0.0).map(|damping| damping.dissipated(&iterate, chi)).sum()
    }

    /// Forces on nodes exerted from outside the model at an iterate `[force]`, from potentials, dampers and loads; the sign of the former
    /// two is that of internal forces. Returns `None` without such a force element.
    ///
    /// # Errors
    /// A time function failed.
    pub fn outside_of(&self, start: &StepStart, [q_1, u_1, moved]: [&[f64]; 3]) -> Result<Option<[Vec<f64>; 2]>, StepError> {
        if !self.others.iter().any(|part| part.is_outside()) {
            return Ok(None);
        }
        let mut told = IterateInputs::default();
        self.visit(start, q_1, moved, &mut told);
        let iterate = Iterate { weight: 1.0, ..start.iterate(q_1, u_1, &told) };
        let (mut internal, mut load) = (vec![0.0; q_1.len()], vec![0.0; q_1.len()]);
        let mut sums = Sums { internal: &mut internal, load: &mut load, tangent: None, workers: &self.workers };
        for (part, memory) in self.own_parts(start.memory).filter(|(part, _)| part.is_outside()) {
            // A part whose forces cannot be evaluated here has already made the step fail.
            if let Err(Refusal::Load(error)) = part.linearize(&iterate, memory, &mut sums) {
                return Err(error);
            }
        }
        Ok(Some([internal, load]))
    }

    /// Finds tangential constraints whose slip supports prevent.
    fn find_held(&self, pairs: &[Evaluation], slips: &[Evaluation], held: &mut Vec<bool>) {
        held.clear();
        if self.multipliers == self.normal_count {
            return;
        }
        let mut sizes = vec![[0.0; 2]; self.multipliers - self.normal_count];
        for block in self.blocks(pairs, slips).filter(RowBlock::is_slip) {
            for row in block.live_rows() {
                let [all, free] = &mut sizes[row.row - self.normal_count];
                for (unknown, entry) in row.unknowns::<D>() {
                    let size = block.evaluation.gradient_end[entry].abs();
                    *all += size;
                    *free += if self.supports.fixed[unknown] { 0.0 } else { size };
                }
            }
        }
        held.extend(sizes.iter().map(|[all, free]| *free <= tolerances::HELD_ROW * all));
        for pair in self.pairs.iter().filter(|pair| pair.reaction.as_ref().is_some_and(|reaction| reaction.is_driven)) {
            pair.tangential().for_each(|(row, _)| held[row - self.normal_count] = true);
        }
    }

    /// Computes the slips for which the slip rates of tangential constraints vanish at the end of the step: 0 at rest.
    fn find_rests(&self, start: &StepStart, moved: &[f64], pairs: &[Evaluation], slips: &[Evaluation], rests: &mut Vec<f64>) {
        rests.clear();
        rests.resize(self.multipliers - self.normal_count, 0.0);
        if rests.is_empty() {
            return;
        }
        let Some(Stopping { moved: stopping, own }) = start.stopping(moved, &self.supports.prescribed) else { return };
        for block in self.blocks(pairs, slips).filter(RowBlock::is_slip) {
            for (rest, slip) in rests[block.rows.start - self.normal_count..].iter_mut().zip(&block.evaluation.gap) {
                *rest += own * slip;
            }
            for row in block.live_rows() {
                let by = |(k, entry): (usize, usize)| block.evaluation.gradient_bar[entry] * (stopping[k] - own * moved[k]);
                rests[row.row - self.normal_count] += row.unknowns::<D>().map(by).sum::<f64>();
            }
        }
    }

    /// Gaps and gradients of all contact pairs at the positions `q`, without tangents.
    pub fn evaluations_at(&self, q: &[f64]) -> Vec<Evaluation> {
        let none = vec![0.0; self.multipliers];
        let evaluated = |pair: &ContactPair| {
            let mut evaluation = Evaluation::default();
            pair.kernel.linearize(Derivative::AT_END, q, &none[pair.rows.clone()], &mut evaluation, None);
            evaluation
        };
        self.pairs.iter().map(evaluated).collect()
    }

    /// Normal and tangential constraints of all pairs at the positions `q`, without tangents and with zero slips.
    pub fn evaluated_at(&self, q: &[f64]) -> [Vec<Evaluation>; 2] {
        let pairs = self.evaluations_at(q);
        let slips = self.slips_at_rest(q, &pairs);
        [pairs, slips]
    }

    /// Speed with which the surfaces of every tangential constraint slip at the positions `q` with the velocities `v`; empty if the
    /// friction of no pair depends on it.
    pub fn slip_speeds(&self, q: &[f64], v: &[f64]) -> Vec<f64> {
        let depends = |pair: &ContactPair| pair.friction.as_ref().is_some_and(|friction| friction.law.depends_on_speed());
        if !self.pairs.iter().any(depends) {
            return Vec::new();
        }
        let [pairs, slips] = self.evaluated_at(q);
        let rates = self.rates([&pairs, &slips], q, v);
        let mut speeds = vec![0.0; self.multipliers];
        for (pair, slip) in self.pairs.iter().zip(&slips) {
            let Some(friction) = &pair.friction else { continue };
            for (local, weight) in pair.kernel.weights().iter().enumerate() {
                let group = friction.group(local);
                let covered = weight * slip.coverage[group.start - friction.rows.start];
                let rate = rates[group.clone()].iter().map(|rate| rate * rate).sum::<f64>().sqrt();
                speeds[group].fill(if covered > 0.0 { rate / covered } else { 0.0 });
            }
        }
        speeds
    }

    /// Gradients of the tangential constraints of all pairs at the positions `q`, with zero slips; `pairs` are the normal constraints at
    /// `q`.
    pub fn slips_at_rest(&self, q: &[f64], pairs: &[Evaluation]) -> Vec<Evaluation> {
        let moved = if self.multipliers > self.normal_count { vec![0.0; q.len()] } else { Vec::new() };
        let evaluated = |(pair, evaluation): (&ContactPair, &Evaluation)| {
            let mut slip = Evaluation::default();
            if let Some(friction) = &pair.friction {
                let step =
                    SlipStep { q_0: q, q_1: q, moved: &moved, test: Configuration::End, live: &evaluation.live, wants_tangent: false };
                pair.kernel.evaluate_slips(step, &vec![0.0; friction.rows.len()], &mut slip);
            }
            slip
        };
        self.pairs.iter().zip(pairs).map(evaluated).collect()
    }
}
