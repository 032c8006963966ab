//! Fields of the bodies and quantities of the contacts at the present state.

use std::sync::Arc;

use super::buckling::{Buckling, BucklingError};
use super::closing::Closing;
use super::contact_quantities::{contact_fields, contact_forces, totals};
use super::engine::Engine;
use super::fields::{
    BodyFields, BodyTotals, CellPlaces, CellStress, ContactFields, ContactSurface, JointLoad, PlacedObstacle, RedundantConstraints,
};
use super::halvings::Halving;
use super::harmonic::{HarmonicError, HarmonicOptions, HarmonicResponse};
use super::ledger::{ContactTotals, LedgerRow, ProbeValues, Reaction};
use super::loaded::{EvaluatedContacts, LoadedContact};
use super::modes::{Modes, ModesError};
use super::options::{Options, Statistics};
use super::paths::{Path, PathError, PathOptions};
use super::present_state::PresentState;
use super::report::FailureReport;
use super::run_findings::{RunFinding, RunFindingKind};
use super::section_force::SectionForce;
use super::stable_step::StableStep;
use super::state::State;
use crate::bodies::{BodyState, Elements, Recovery, Space, StressError, Stresses};
use crate::contact::Evaluation;
use crate::dynamics::model::interactions::Partner;
use crate::dynamics::model::step_error::StepError;
use crate::dynamics::parts::body::Body;
use crate::dynamics::parts::contact_pair::{ContactPair, PairKind};
use crate::dynamics::parts::nodal::{add_force, add_moment, half_product};
use crate::math::tolerances;

impl<const D: usize> PresentState for Engine<D>
where
    Space<D>: Elements<D>,
{
    fn dimension(&self) -> usize {
        D
    }

    fn options(&self) -> &Options {
        &self.options
    }

    fn unknowns(&self) -> usize {
        self.system.supports.fixed.iter().filter(|fixed| !**fixed).count()
    }

    fn restore(&mut self, state: &State) {
        assert_eq!(
            (state.positions.len(), state.lambda.len()),
            (self.state.positions.len(), self.state.lambda.len()),
            "the state is of the same model"
        );
        self.state = Arc::new(state.clone());
        if self.state.row.probes.len() != self.probes.len() {
            // Watched nodes may differ from those of the restored state.
            Arc::make_mut(&mut self.state).row.probes = self.probe_values(&state.displacements, &state.velocities, &state.accelerations);
        }
        self.system.restore_search(&state.search, &state.positions, state.row.time);
    }

    fn look(&mut self) {
        self.restore_search();
    }

    fn recall(&mut self, row: &LedgerRow) {
        Arc::make_mut(&mut self.state).row.clone_from(row);
    }

    fn prescribed_jump(&self) -> Result<Option<(String, f64)>, StepError> {
        let supports = &self.system.supports;
        let (displacement, _) = supports.prescribed_motion(self.state.row.time)?;
        let jumps = supports.prescribed.iter().zip(displacement).map(|(one, then)| (one, then - self.state.displacements[one.unknown]));
        let farthest = jumps.max_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs()));
        let seen = farthest.filter(|(_, jump)| jump.abs() > tolerances::JUMP * self.system.nodes.extent);
        Ok(seen.map(|(one, jump)| (supports.boundary(one).to_string(), jump)))
    }

    fn interrupted_friction(&self) -> Option<(&str, f64)> {
        let bounces = |pair: &&ContactPair| {
            let is_deformable = pair.has_multipliers() && pair.restitution.is_none() && pair.is_unilateral();
            is_deformable && pair.update.keeps_energy && !pair.update.gives_back
        };
        let needs_time = |pair: &&ContactPair| pair.friction.as_ref().is_some_and(|friction| friction.law.needs_time());
        let is_short = self.options.dt < tolerances::BOUNCES * self.sound;
        let mut pairs = self.system.pairs.iter().filter(bounces).filter(needs_time);
        pairs.next().filter(|_| is_short).map(|pair| (&*pair.name, self.sound))
    }

    fn check_apart(&self) -> Result<(), StepError> {
        self.check_overlaps(&Closing::of(&self.model))
    }

    fn modes(&mut self, count: usize) -> Result<Modes, ModesError> {
        self.find_modes(count)
    }

    fn harmonic_response(&mut self, options: &HarmonicOptions) -> Result<HarmonicResponse, HarmonicError> {
        self.find_response(options)
    }

    fn buckling(&mut self, count: usize) -> Result<Buckling, BucklingError> {
        self.find_buckling(count)
    }

    fn stable_step(&mut self) -> Result<StableStep, StepError> {
        Engine::stable_step(self)
    }

    fn path(&mut self, options: &PathOptions, told: &mut dyn FnMut(&LedgerRow)) -> Result<Path, PathError> {
        self.find_path(options, told)
    }

    fn watch(&mut self, node: usize) {
        self.probes.push(node);
        let probes = self.probe_values(&self.state.displacements, &self.state.velocities, &self.state.accelerations);
        Arc::make_mut(&mut self.state).row.probes = probes;
    }

    fn watched(&self) -> &[usize] {
        &self.probes
    }

    fn fields(&self) -> Vec<BodyFields> {
        self.fields_at(&self.state.displacements)
    }

    fn failure(&self) -> Option<&FailureReport> {
        self.failure.as_ref().map(|(report, _)| report)
    }

    fn failed_fields(&self) -> Option<Vec<BodyFields>> {
        self.failure.as_ref().map(|(_, u)| self.fields_at(u))
    }

    fn cell_stresses(&self, body: usize, places: CellPlaces) -> Vec<CellStress> {
        let (q, body, reference) = (&self.state.positions, &self.system.bodies[body], &self.system.nodes.reference);
        let mut points = Vec::new();
        body.elements.visit_stresses(self.present(body), &mut |point| {
            let (mut position, mut rest) = ([0.0; 3], [0.0; 3]);
            for (shape, &node) in point.shapes.iter().zip(point.nodes) {
                (0..D).for_each(|i| position[i] += shape * q[node as usize * D + i]);
                (0..D).for_each(|i| rest[i] += shape * reference[node as usize * D + i]);
            }
            let share = point.volume / point.cell_volume;
            let kept = point.kept.unwrap_or_default();
            points.push((
                point.cell,
                share,
                CellStress {
                    position,
                    rest,
                    energy: point.energy,
                    stress: point.stress,
                    strain: point.strain,
                    plastic_strain: kept.plastic_strain,
                    back_stress: kept.back_stress,
                },
            ));
        });
        points.sort_by_key(|point| point.0);
        match places {
            CellPlaces::Points => points.into_iter().map(|(.., values)| values).collect(),
            CellPlaces::Cells => points.chunk_by(|a, b| a.0 == b.0).map(mean).collect(),
        }
    }

    fn section_force(&self, body: usize, point: [f64; 3], normal: [f64; 3]) -> Option<SectionForce> {
        self.section_force_of(body, point, normal)
    }

    fn body(&self, body: usize) -> BodyTotals {
        let (system, state) = (&self.system, &self.state);
        let Body { nodes, elements, .. } = &system.bodies[body];
        let range = nodes.start * D..nodes.end * D;
        let (q, v) = (&state.positions[range.clone()], &state.velocities[range.clone()]);
        let momenta = &system.nodes.momenta_of(&state.velocities)[range.clone()];
        let masses = &system.nodes.nodal_mass[nodes.clone()];
        let mass = masses.iter().sum();
        let mut center = [0.0; 3];
        for (x, m) in q.chunks_exact(D).zip(masses) {
            (0..D).for_each(|i| center[i] += m * x[i] / mass);
        }
        BodyTotals {
            mass,
            stress_error: self.estimated_error(body),
            kinetic: half_product(v, momenta),
            strain: elements.strain_energy(self.present(&system.bodies[body])),
            potential: -q.iter().zip(&system.nodes.weight[range]).map(|(q, weight)| q * weight).sum::<f64>(),
            momentum: system.nodes.resultant(momenta),
            angular_momentum: system.nodes.moment(q, momenta),
            center,
        }
    }

    fn redundant_constraints(&self) -> Vec<RedundantConstraints> {
        let system = &self.system;
        let of = |pair: &ContactPair| {
            let mut rows = pair.rows.clone().filter(|&row| system.redundant[row]);
            let node = pair.node_of(rows.next()?).map(|node| {
                let (body, number) = system.owner(node as usize);
                let place = std::array::from_fn(|i| if i < D { system.nodes.reference[node as usize * D + i] } else { 0.0 });
                (body.to_string(), number, place)
            });
            let (name, count, of) = (pair.name.clone(), rows.count() + 1, pair.rows.len());
            // The last constraint of a joint is that of its drive.
            let is_driven = pair.drive.is_some() && system.redundant[pair.rows.end - 1];
            Some(RedundantConstraints { name, is_joint: pair.kind == PairKind::Joint, is_driven, count, of, node })
        };
        // Redundancy is expected, and not reported, for nodes of rigid bodies (supports hold more nodes than a body has motions) and for
        // couplings (periodic pairs share corners).
        let is_told = |pair: &&ContactPair| !matches!(pair.kind, PairKind::Rigidity | PairKind::Coupling(_));
        system.pairs.iter().filter(is_told).filter_map(of).collect()
    }

    fn loose_joints(&self) -> Vec<(String, f64)> {
        Engine::loose_joints(self)
    }

    fn joint(&self, name: &str) -> Option<JointLoad> {
        self.joint_load(name)
    }

    fn obstacles(&self) -> Vec<PlacedObstacle> {
        let mut placed: Vec<PlacedObstacle> = Vec::new();
        for interaction in &self.model.interactions {
            let Partner::Obstacle { shape, .. } = &interaction.partner else { continue };
            let pair = self.system.pairs.iter().find(|pair| pair.kind == PairKind::Obstacle && pair.name == interaction.name);
            let place = pair.map_or_else(Default::default, |pair| pair.kernel.obstacle_placement());
            match placed.iter_mut().find(|other| other.shape == *shape && other.place == place) {
                Some(same) => same.name = format!("{}, {}", same.name, interaction.name),
                None => placed.push(PlacedObstacle { name: interaction.name.clone(), shape: shape.clone(), place }),
            }
        }
        placed
    }

    fn contact(&self, name: &str) -> Option<ContactFields> {
        let (index, _) = self.system.contacts().find(|(_, pair)| pair.name == name)?;
        let there = self.system.evaluated_at(&self.state.positions);
        let (contact, corners) = self.loaded(index, &self.state.positions, &there);
        let order = contact.pair.kernel.secondary().along();
        Some(contact_fields::<D>(contact, &corners).in_order(&order))
    }

    fn contact_surfaces(&self) -> Vec<ContactSurface> {
        let there = self.system.evaluated_at(&self.state.positions);
        let reference = &self.system.nodes.reference;
        let place = |node: u32| {
            let node = node as usize;
            let body = self.system.body_of(node);
            (body, node - self.system.bodies[body].nodes.start)
        };
        let of = |(index, pair): (usize, &ContactPair)| {
            let (contact, corners) = self.loaded(index, &self.state.positions, &there);
            let surface = pair.kernel.secondary();
            let order = surface.along();
            let mut rank = vec![0; order.len()];
            order.iter().zip(0u32..).for_each(|(&local, along)| rank[local] = along);
            let nodes: Vec<u32> = order.iter().map(|&local| surface.nodes()[local]).collect();
            let point = |&node: &u32| std::array::from_fn(|i| if i < D { reference[node as usize * D + i] } else { 0.0 });
            ContactSurface {
                name: pair.name.clone(),
                points: nodes.iter().map(point).collect(),
                nodes: nodes.into_iter().map(place).collect(),
                facets: (0..surface.count())
                    .map(|facet| surface.local_facet(facet).iter().map(|&local| rank[local as usize]).collect())
                    .collect(),
                fields: contact_fields::<D>(contact, &corners).in_order(&order),
            }
        };
        self.system.contacts().filter(|(_, pair)| pair.kind != PairKind::Tie).map(of).collect()
    }

    fn closed_nodes(&self) -> Vec<usize> {
        self.system.closed_nodes(&self.state.active)
    }

    fn friction_multipliers(&self) -> Vec<[f64; 2]> {
        let lambda = &self.state.lambda;
        let rows: Vec<(usize, usize)> = self.system.pairs.iter().flat_map(ContactPair::tangential).collect();
        let of = |group: &[(usize, usize)]| match *group {
            [(row, normal_row)] => [lambda[normal_row], lambda[row]],
            _ => [lambda[group[0].1], group.iter().map(|&(row, _)| lambda[row]).fold(0.0, f64::hypot)],
        };
        rows.chunk_by(|a, b| a.1 == b.1).map(of).collect()
    }

    fn rank_bytes(&self) -> &[u64] {
        self.system.rank_bytes()
    }

    fn halvings(&self) -> &[Halving] {
        self.halvings.all()
    }

    fn findings_at_start(&self) -> Vec<RunFinding> {
        let (dt, row) = (self.options.dt, &self.state.row);
        let motions = self.system.sliding_by_velocity(&self.state.positions, &self.state.velocities, dt);
        motions.iter().map(|motion| RunFinding::of_motion(RunFindingKind::Motion, motion, dt, row.step, row.time)).collect()
    }

    fn statistics(&self) -> Statistics {
        let counters = &self.system.counters;
        let calls = counters.calls_before_resume.plus(self.system.work().solver_calls(), counters.calls_at_resume);
        Statistics {
            factorizations: counters.factorizations,
            discarded: counters.discarded,
            linear: self.system.work(),
            solver_calls: calls,
            taken_over: self.system.taken_over(),
            assemblies: counters.assemblies,
            cells: self.system.bodies.iter().map(|body| body.elements.cliques().len()).sum(),
            factor_bytes: self.system.factor_bytes(),
            times: counters.times,
            ..self.statistics
        }
    }
}

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    pub fn fields_at(&self, u: &[f64]) -> Vec<BodyFields> {
        let q = &self.system.nodes.positions(u)[..];
        let (v, a) = (&self.state.velocities, &self.state.accelerations);
        let nodes = self.system.nodes.count();
        let (mut pressure, mut gap) = (vec![0.0; nodes], vec![f64::NAN; nodes]);
        let (mut contact_force, mut contact_pressing) = (vec![[0.0; 3]; nodes], vec![[0.0; 3]; nodes]);
        let [mut contact_active, mut contact_state, mut contact_slip] = [(); 3].map(|()| vec![0.0; nodes]);
        let there = self.system.evaluated_at(q);
        for (index, pair) in self.system.contacts().filter(|(_, pair)| pair.kind != PairKind::Tie) {
            let (contact, corners) = self.loaded(index, q, &there);
            let forces = contact_forces::<D>(contact, &corners);
            for (index, (node, force)) in forces.all.into_iter().enumerate() {
                (0..3).for_each(|i| contact_force[node as usize][i] += force[i]);
                if index < forces.normal_count {
                    (0..3).for_each(|i| contact_pressing[node as usize][i] += force[i]);
                }
            }
            let fields = contact_fields::<D>(contact, &corners);
            for (local, &node) in pair.kernel.secondary().nodes().iter().enumerate() {
                let node = node as usize;
                pressure[node] += fields.pressure[local];
                if fields.active[local] {
                    contact_active[node] = 1.0;
                }
                contact_state[node] = f64::from(fields.state[local] as u8).max(contact_state[node]);
                if pair.friction.is_some() {
                    contact_slip[node] = f64::from(fields.state[local] as u8).max(contact_slip[node]);
                }
                if !fields.gap[local].is_nan() {
                    gap[node] = fields.gap[local];
                }
            }
        }
        let vector = |values: &[f64], node: usize| {
            let mut vector = [0.0; 3];
            vector[..D].copy_from_slice(&values[node * D..(node + 1) * D]);
            vector
        };
        self.system
            .bodies
            .iter()
            .zip(&self.model.bodies)
            .map(|(body, definition)| {
                let Stresses { stress, strain, kept } = self.stresses_at(body);
                BodyFields {
                    name: body.name.clone(),
                    mesh: definition.mesh.clone(),
                    displacement: body.nodes.clone().map(|node| vector(u, node)).collect(),
                    velocity: body.nodes.clone().map(|node| vector(v, node)).collect(),
                    acceleration: body.nodes.clone().map(|node| vector(a, node)).collect(),
                    stress_error: StressError::new(&*body.elements, self.present(body), body.nodes.clone(), &stress).at_nodes(),
                    stress,
                    strain,
                    is_rigid: definition.rigid.is_some(),
                    flows: definition.flows(),
                    plastic_strain: kept.iter().map(|kept| kept[0]).collect(),
                    back_stress: kept.iter().map(|kept| kept[1]).collect(),
                    energy_density: kept.iter().map(|kept| kept[2]).collect(),
                    contact_pressure: pressure[body.nodes.clone()].to_vec(),
                    contact_gap: gap[body.nodes.clone()].to_vec(),
                    contact_force: contact_force[body.nodes.clone()].to_vec(),
                    contact_pressing: contact_pressing[body.nodes.clone()].to_vec(),
                    contact_active: contact_active[body.nodes.clone()].to_vec(),
                    contact_state: contact_state[body.nodes.clone()].to_vec(),
                    contact_slip: contact_slip[body.nodes.clone()].to_vec(),
                }
            })
            .collect()
    }

    /// Present state of a body, as passed to its element loop.
    pub(super) fn present(&self, body: &Body<D>) -> BodyState<'_> {
        let history = self.state.memory.get(body.number).map_or(&[][..], Vec::as_slice);
        BodyState { u: &self.state.displacements, history }
    }

    /// Stress and strain at the nodes of a body.
    fn stresses_at(&self, body: &Body<D>) -> Stresses {
        if body.rigid.is_some() {
            return Stresses::zeros(body.nodes.len());
        }
        let recovery = body.recovery.get_or_init(|| Recovery::new(&self.model.bodies[body.number].mesh));
        Stresses::at_nodes(&*body.elements, self.present(body), body.nodes.clone(), recovery)
    }

    /// Estimated error of the stresses of a body relative to their size.
    pub fn estimated_error(&self, body: usize) -> f64 {
        let body = &self.system.bodies[body];
        let continuous = self.stresses_at(body).stress;
        StressError::new(&*body.elements, self.present(body), body.nodes.clone(), &continuous).relative()
    }

    /// A contact and its corners with the evaluations of all pairs, in the present state.
    fn loaded<'a>(
        &'a self,
        index: usize,
        q: &'a [f64],
        [evaluations, slips]: &'a [Vec<Evaluation>; 2],
    ) -> (LoadedContact<'a>, Vec<LoadedContact<'a>>) {
        let State { lambda, active, slipped, .. } = &*self.state;
        EvaluatedContacts { q, evaluations, slips, lambda, active, slipped }.contact(&self.system, index)
    }

    /// Sums over each contact.
    pub fn contact_totals(&self, touching: &EvaluatedContacts) -> Vec<ContactTotals> {
        let of = |(index, _): (usize, &ContactPair)| {
            let (contact, corners) = touching.contact(&self.system, index);
            totals::<D>(contact, &corners)
        };
        self.system.contacts().map(of).collect()
    }

    /// Resultant and moment of the support forces of each boundary; `reaction` gives the force on a supported component, `q` the positions
    /// for moments.
    pub fn reactions(&self, q: impl Fn(usize) -> f64, reaction: impl Fn(usize) -> f64) -> Vec<Reaction> {
        let of = |held: &Vec<usize>| {
            let mut sum = Reaction::default();
            for &k in held {
                let mut force = [0.0; D];
                force[k % D] = reaction(k);
                add_force(&mut sum.force, &force);
                add_moment(&mut sum.moment, &std::array::from_fn::<f64, D, _>(|i| q(k / D * D + i)), &force);
            }
            sum
        };
        self.system.supports.held.iter().map(of).collect()
    }

    /// Displacement, velocity and acceleration of the watched nodes.
    pub fn probe_values(&self, u: &[f64], v: &[f64], a: &[f64]) -> Vec<ProbeValues> {
        let values = |&node: &usize| {
            let mut values = ProbeValues::default();
            for i in 0..D {
                values.displacement[i] = u[node * D + i];
                values.velocity[i] = v[node * D + i];
                values.acceleration[i] = a[node * D + i];
            }
            values
        };
        self.probes.iter().map(values).collect()
    }
}

/// Weighted mean of the values at the points of a cell.
fn mean(points: &[(usize, f64, CellStress)]) -> CellStress {
    let mut mean = CellStress::default();
    for (_, share, values) in points {
        (0..3).for_each(|i| mean.position[i] += share * values.position[i]);
        (0..3).for_each(|i| mean.rest[i] += share * values.rest[i]);
        (0..6).for_each(|k| mean.stress[k] += share * values.stress[k]);
        (0..6).for_each(|k| mean.strain[k] += share * values.strain[k]);
        mean.plastic_strain += share * values.plastic_strain;
        mean.back_stress += share * values.back_stress;
        mean.energy += share * values.energy;
    }
    mean
}
