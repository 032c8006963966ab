//! The equations of one model: numbering, supports, and the residual and tangent of a step.
//!
//! Unknowns: the displacement components of all nodes (those of supports stay in the numbering, their rows and columns are replaced by
//! the identity), then one multiplier per secondary node of every contact pair. Newton's system of a step is
//!
//! ```text
//! [ K   -Gbar^T ] [ dq     ]     [ r_0 ]         K = d r / d q_1  with the contact forces' part,
//! [ G_1     0   ] [ lambda ] = - [ Phi ]         r = r_0 - Gbar^T lambda
//! ```
//!
//! (Hesch and Betsch 2007, equation 3). The constraint rows of nodes that are not active read `lambda = 0`; switching them does not change
//! the pattern.

use std::sync::Arc;
use std::time::Instant;

use super::amplitude::Amplitude;
use super::error::{ModelError, StepError};
use super::loads::{NodalLoad, PrescribedUnknown};
use super::model::{LoadKind, Model};
use super::pairs::{Pair, PairKind, boundary_facets, contact_pairs};
use super::simulation::PhaseTimes;
use crate::bodies::{ElementLoop, Elements, Inverted, Space, Step, nodal_areas};
use crate::contact::{Candidates, Correction, Evaluation, Outlook};
use crate::integrators::{Configuration, Integrator};
use crate::linear::{Block, EliminationOrder, Factorization, LinearError, NodeMatrix, Pattern, Watch, Work};
use crate::math::norms::largest_size;
use crate::math::tolerances;
use crate::math::workers::Workers;

/// A body in the numbering of the model.
pub(super) struct Body<const D: usize> {
    pub(super) name: String,
    /// Range of its nodes.
    pub(super) nodes: std::ops::Range<usize>,
    pub(super) elements: Box<dyn ElementLoop<D>>,
}

/// What a step starts from and how it is integrated.
pub(super) struct StepStart<'a> {
    pub(super) integrator: Integrator,
    pub(super) time: f64,
    pub(super) dt: f64,
    pub(super) q_0: &'a [f64],
    pub(super) v_0: &'a [f64],
    /// Half of the forces that are not inertial at the start of the step; only the trapezoidal rule uses it.
    pub(super) half_force: &'a [f64],
    /// Velocities at the end of the step of the prescribed unknowns, in their order.
    pub(super) prescribed_v_1: &'a [f64],
    /// `Some(mu)`: no inertia but a damping `mu/2 M (q_1 - q_0)` with a factor for each body; velocities are not used.
    pub(super) damping: Option<&'a [f64]>,
}

impl StepStart<'_> {
    /// Factor of a body's mass in the tangent.
    pub(super) fn inertia(&self, body: usize) -> f64 {
        self.damping.map_or(2.0 / (self.dt * self.dt), |mu| 0.5 * mu[body])
    }
}

/// The constraint rows of Newton's system: `gradient_A G_1A dq + diagonal_A lambda_A = right_A`.
pub(super) struct ConstraintRows {
    /// 1, or 0 for `lambda = right`.
    pub(super) gradient: Vec<bool>,
    pub(super) diagonal: Vec<f64>,
    pub(super) right: Vec<f64>,
}

/// A change of the velocities by impulses.
pub(super) struct Push {
    pub(super) velocity: Vec<f64>,
    /// Impulses of the constraints.
    pub(super) lambda: Vec<f64>,
    /// Impulses of supports and obstacles on the nodes.
    pub(super) impulse: Vec<f64>,
    /// Work of obstacles that move.
    pub(super) work: f64,
}

/// Forces of a step at one iterate.
pub(super) struct Forces {
    /// Residual without contact forces.
    pub(super) without_contact: Vec<f64>,
    /// Contact forces `Gbar^T lambda`.
    pub(super) contact: Vec<f64>,
    /// Loads, gravity not included.
    pub(super) load: Vec<f64>,
    /// Work of the internal forces over the step, to measure energies with.
    pub(super) internal_work: f64,
    /// Size of the largest internal, inertial or external force component, to measure residuals with.
    pub(super) scale: f64,
}

/// The equations of a model in `D` dimensions.
pub(super) struct System<const D: usize> {
    pub(super) bodies: Vec<Body<D>>,
    pub(super) pairs: Vec<Pair>,
    pub(super) loads: Vec<NodalLoad>,
    /// Node positions at rest.
    pub(super) reference: Vec<f64>,
    /// Which displacement components are held or prescribed.
    pub(super) fixed: Vec<bool>,
    /// Those that follow a time function.
    pub(super) prescribed: Vec<PrescribedUnknown>,
    pub(super) prescriptions: Vec<(Amplitude, String)>,
    pub(super) mass: NodeMatrix,
    /// Mass of every node (row sums).
    pub(super) nodal_mass: Vec<f64>,
    pub(super) largest_nodal_mass: f64,
    /// Mass of all bodies.
    pub(super) total_mass: f64,
    /// Force of gravity.
    pub(super) weight: Vec<f64>,
    /// Largest Young's modulus and largest extent, for the round-off floor of forces.
    pub(super) modulus: f64,
    pub(super) extent: f64,
    /// Pieces of connected nodes: number per node, and whether the piece holds no support.
    pub(super) pieces: Vec<u32>,
    pub(super) piece_is_free: Vec<bool>,
    pub(super) multipliers: usize,
    pub(super) values: Vec<f64>,
    pub(super) times: PhaseTimes,
    pub(super) factorizations: usize,
    pub(super) assemblies: usize,
    pattern: Pattern,
    identity_places: Vec<u32>,
    zero_places: Vec<u32>,
    diagonal_places: Vec<u32>,
    pub(super) factorization: Factorization,
    /// Whether pattern and factorisation are those of other candidates.
    stale: bool,
    /// What the next step takes over from the ones before, as it was asked for last.
    search: Arc<SearchHistory>,
    workers: Workers,
    scratch: Scratch,
    /// Assemblies since the start of the step, and in the step before.
    assemblies_of_step: [usize; 2],
    deferred: Option<DeferredTangent>,
}

/// A tangent that was not assembled with its forces, because the step before was done when it had as many.
struct DeferredTangent {
    integrator: Integrator,
    /// Of each body.
    inertia: Vec<f64>,
    q_0: Vec<f64>,
    q_1: Vec<f64>,
}

/// Vectors that every assembly needs for itself.
#[derive(Default)]
struct Scratch {
    /// Internal forces.
    internal: Vec<f64>,
    /// Positions that loads act at, then the motion that the mass opposes.
    motion: Vec<f64>,
}

/// What a system keeps from one step to the next. Sums depend on it in their last bits, so it belongs to the state.
#[derive(Debug, Default, PartialEq)]
pub(super) struct SearchHistory {
    /// One for each contact pair that searches.
    candidates: Vec<Option<Candidates>>,
    order: Option<EliminationOrder>,
}

impl<const D: usize> System<D>
where
    Space<D>: Elements<D>,
{
    pub(super) fn new(model: &Model, threads: usize) -> Result<Self, ModelError> {
        model.check()?;
        let mut bodies = Vec::new();
        let mut reference: Vec<f64> = Vec::new();
        for body in &model.bodies {
            let first = reference.len() / D;
            let elements = Space::<D>::elements(&body.mesh, &body.material, first).map_err(|Inverted { cell, determinant }| {
                ModelError::InvertedCell { body: body.name.clone(), cell, jacobian: determinant }
            })?;
            reference.extend(body.mesh.points.iter().flat_map(|point| point[..D].to_vec()));
            bodies.push(Body { name: body.name.clone(), nodes: first..reference.len() / D, elements });
        }
        let nodes = reference.len() / D;
        let global = |body: usize, node: u32| node + bodies[body].nodes.start as u32;

        let mut fixed = vec![false; reference.len()];
        for support in &model.supports {
            for node in model.bodies[support.on.body].mesh.boundary_nodes(&support.on.boundary) {
                for i in (0..D).filter(|&i| support.components[i]) {
                    fixed[global(support.on.body, node) as usize * D + i] = true;
                }
            }
        }
        let (mut prescribed, mut prescriptions) = (Vec::new(), Vec::new());
        for prescription in &model.prescriptions {
            for node in model.bodies[prescription.on.body].mesh.boundary_nodes(&prescription.on.boundary) {
                let unknown = global(prescription.on.body, node) as usize * D + prescription.component;
                fixed[unknown] = true;
                // A later prescription of the same component replaces an earlier one.
                prescribed.retain(|other: &PrescribedUnknown| other.unknown != unknown);
                prescribed.push(PrescribedUnknown { unknown, function: prescriptions.len() });
            }
            prescriptions.push((prescription.displacement.clone(), model.boundary_name(&prescription.on)));
        }
        let loads = model
            .loads
            .iter()
            .map(|load| NodalLoad {
                kind: load.kind,
                weights: nodal_areas(&model.bodies[load.on.body].mesh, &load.on.boundary)
                    .into_iter()
                    .map(|(node, weight)| (global(load.on.body, node), weight))
                    .collect(),
                facets: match load.kind {
                    LoadKind::Pressure(_) => boundary_facets(model, &load.on, bodies[load.on.body].nodes.start)
                        .into_iter()
                        .map(|facet| (facet, [Block::default(); 4]))
                        .collect(),
                    _ => Vec::new(),
                },
                amplitude: load.amplitude.clone(),
                name: model.boundary_name(&load.on),
            })
            .collect();

        let pairs = contact_pairs(model, |on| boundary_facets(model, on, bodies[on.body].nodes.start), &reference);
        let multipliers = pairs.last().map_or(0, |pair| pair.rows.end);

        let (pieces, count) = connected_pieces(nodes, bodies.iter().flat_map(|body| body.elements.cliques()));
        let mut piece_is_free = vec![true; count];
        for (unknown, _) in fixed.iter().enumerate().filter(|(_, fixed)| **fixed) {
            piece_is_free[pieces[unknown / D] as usize] = false;
        }
        let extent = (0..D)
            .map(|i| {
                let coordinates = || reference.iter().skip(i).step_by(D).copied();
                coordinates().fold(f64::NEG_INFINITY, f64::max) - coordinates().fold(f64::INFINITY, f64::min)
            })
            .fold(0.0, f64::max);

        let pattern = pattern_of(&fixed, multipliers, &bodies, &pairs);
        let mut mass = NodeMatrix::new(&pattern, nodes);
        for body in &bodies {
            body.elements.add_mass(&mut mass);
        }
        let nodal_mass = mass.row_sums();
        let weight = (0..reference.len()).map(|k| nodal_mass[k / D] * model.gravity[k % D]).collect();
        let workers = Workers::new(threads);
        let factorization = Factorization::new(&pattern).map_err(|error| ModelError::TooLarge { reason: error.to_string() })?;
        let mut system = System {
            bodies,
            pairs,
            loads,
            fixed,
            prescribed,
            prescriptions,
            mass,
            largest_nodal_mass: largest_size(&nodal_mass),
            total_mass: nodal_mass.iter().sum(),
            nodal_mass,
            weight,
            modulus: model.bodies.iter().map(|body| body.material.youngs_modulus()).fold(0.0, f64::max),
            extent,
            pieces,
            piece_is_free,
            multipliers,
            values: Vec::new(),
            times: PhaseTimes::default(),
            factorizations: 0,
            assemblies: 0,
            pattern,
            identity_places: Vec::new(),
            zero_places: Vec::new(),
            diagonal_places: Vec::new(),
            factorization: factorization.with_workers(&workers),
            stale: false,
            search: Arc::default(),
            workers,
            scratch: Scratch::default(),
            assemblies_of_step: [0; 2],
            deferred: None,
            reference,
        };
        system.place();
        Ok(system)
    }

    /// Chooses the contact kernels' discrete gradient.
    pub(super) fn set_correction(&mut self, correction: Correction) {
        self.pairs.iter_mut().for_each(|pair| pair.kernel.set_correction(correction));
    }

    /// What the linear solver has done.
    pub(super) fn work(&self) -> Work {
        self.factorization.work()
    }

    /// Bytes of the factors.
    pub(super) fn factor_bytes(&self) -> usize {
        self.factorization.bytes()
    }

    /// Lets long factorisations be looked into.
    pub(super) fn watch(&mut self, watch: Watch) {
        self.factorization.set_watch(watch);
    }

    /// Number of nodes.
    pub(super) fn nodes(&self) -> usize {
        self.reference.len() / D
    }

    /// Number of secondary nodes in contact: active constraints, those of ties left out.
    pub(super) fn touching(&self, active: &[bool]) -> usize {
        self.closed_nodes(active).iter().zip(&self.pairs).filter(|(_, pair)| pair.kind != PairKind::Tie).map(|(closed, _)| closed).sum()
    }

    /// Number of nodes that active constraints hold, of each contact in the order of the model.
    pub(super) fn closed_nodes(&self, active: &[bool]) -> Vec<usize> {
        let held_by = |pair: &Pair| -> Vec<u32> {
            let stride = pair.kernel.rows_per_node();
            let rows = active[pair.rows.clone()].chunks_exact(stride).enumerate().filter(|(_, rows)| rows.contains(&true));
            // Corners of obstacles are numbered by their rows, from behind.
            rows.map(|(index, _)| pair.kernel.row_nodes().get(index).copied().unwrap_or(u32::MAX - index as u32)).collect()
        };
        let of = |(index, pair): (usize, &Pair)| {
            let mut nodes = held_by(pair);
            let corners = self.corners_of(index);
            corners.for_each(|corners| nodes.extend(held_by(corners)));
            nodes.sort_unstable();
            nodes.dedup();
            nodes.len()
        };
        self.contacts().map(of).collect()
    }

    /// The pairs that are contacts of the model, with their indices.
    pub(super) fn contacts(&self) -> impl Iterator<Item = (usize, &Pair)> {
        self.pairs.iter().enumerate().filter(|(_, pair)| pair.corners.is_none())
    }

    /// The pairs that belong to a contact besides.
    pub(super) fn corners_of(&self, index: usize) -> impl Iterator<Item = &Pair> {
        self.pairs.iter().filter(move |pair| pair.corners.is_some_and(|corners| corners.of == index))
    }

    /// Name of the body that owns a node, and the node's number in the body's mesh.
    pub(super) fn owner(&self, node: usize) -> (&str, usize) {
        let body = self.bodies.iter().find(|body| body.nodes.contains(&node)).expect("every node belongs to a body");
        (&body.name, node - body.nodes.start)
    }

    /// A motion and multipliers that the singular tangent of the last solve maps to zero, near enough.
    pub(super) fn near_null_vector(&self) -> &[f64] {
        self.factorization.near_null_vector().unwrap_or_default()
    }

    /// Name of the boundary that moves a prescribed unknown.
    pub(super) fn prescription(&self, prescribed: &PrescribedUnknown) -> &str {
        &self.prescriptions[prescribed.function].1
    }

    /// Finds the places of all contributions in a new pattern.
    fn place(&mut self) {
        let pattern = &self.pattern;
        self.values = vec![0.0; pattern.values()];
        for body in &mut self.bodies {
            body.elements.place(pattern);
        }
        for (facet, blocks) in self.loads.iter_mut().flat_map(|load| &mut load.facets) {
            *blocks = std::array::from_fn(|k| pattern.block(facet[k / 2], facet[k % 2]));
        }
        let nodes = self.reference.len() / D;
        for pair in &mut self.pairs {
            (pair.tangent_places, pair.row_places, pair.column_places) = Default::default();
            let patches = pair.kernel.patches();
            for p in 0..patches.len() {
                for &u in patches.nodes(p) {
                    pair.tangent_places.extend(patches.nodes(p).iter().map(|&v| pattern.block(u, v)));
                }
                for &row in patches.rows(p) {
                    let multiplier = (nodes + pair.rows.start + row as usize) as u32;
                    for &node in patches.nodes(p) {
                        pair.row_places.push(pattern.block(multiplier, node));
                        pair.column_places.push(pattern.block(node, multiplier));
                    }
                }
            }
        }
        self.diagonal_places = (nodes..nodes + self.multipliers).map(|v| pattern.block(v as u32, v as u32).start).collect();
        (self.identity_places, self.zero_places) = Default::default();
        for (unknown, _) in self.fixed.iter().enumerate().filter(|(_, fixed)| **fixed) {
            let (node, i) = ((unknown / D) as u32, unknown % D);
            for &other in pattern.neighbors(unknown / D) {
                let (row, column) = (pattern.block(node, other), pattern.block(other, node));
                let size = if (other as usize) < nodes { D } else { 1 };
                for k in 0..size {
                    self.zero_places.push(row.at(i, k) as u32);
                    self.zero_places.push(column.at(k, i) as u32);
                }
            }
            self.identity_places.push(pattern.block(node, node).at(i, i) as u32);
        }
    }

    /// Puts the rigid obstacles where they are in a step of that size from `time`; their time functions may fail.
    pub(super) fn move_obstacles(&mut self, time: f64, dt: f64) -> Result<(), StepError> {
        for pair in self.pairs.iter_mut().filter(|pair| pair.kind == PairKind::Obstacle) {
            let mut translations = [[0.0; 2]; 3];
            for (translation, time) in translations.iter_mut().zip([time, time + 0.5 * dt, time + dt]) {
                for (component, function) in translation.iter_mut().zip(&pair.motion) {
                    let Some(function) = function else { continue };
                    let failed = |source| StepError::Amplitude { boundary: pair.name.clone(), time, source };
                    *component = function.value(time).map_err(failed)?;
                    if !component.is_finite() {
                        return Err(failed(format!("the time function returned {component}").into()));
                    }
                }
            }
            let [start, _, end] = translations;
            pair.obstacle_velocity = std::array::from_fn(|i| if dt > 0.0 { (end[i] - start[i]) / dt } else { 0.0 });
            pair.kernel.move_obstacle(&translations);
        }
        Ok(())
    }

    /// What the next step takes over from the ones before; the same value as long as nothing has changed.
    pub(super) fn search(&mut self) -> Arc<SearchHistory> {
        let is_same = self.search.order.as_ref() == Some(self.factorization.order())
            && self.search.candidates.len() == self.pairs.len()
            && self.pairs.iter().zip(&self.search.candidates).all(|(pair, kept)| pair.kernel.candidates() == kept.as_ref());
        if !is_same {
            let candidates = self.pairs.iter().map(|pair| pair.kernel.candidates().cloned()).collect();
            self.search = Arc::new(SearchHistory { candidates, order: Some(self.factorization.order().clone()) });
        }
        self.search.clone()
    }

    /// Puts the candidates of an earlier step in place, at its positions.
    pub(super) fn restore_search(&mut self, search: &Arc<SearchHistory>, q: &[f64], time: f64) {
        // A time function that fails does so again, with its error, in the next step.
        let _ = self.move_obstacles(time, 0.0);
        if *self.search() == **search {
            return;
        }
        for (pair, candidates) in self.pairs.iter_mut().zip(&search.candidates) {
            if let Some(candidates) = candidates {
                pair.kernel.restore_candidates(candidates, q);
            }
        }
        if let Some(order) = &search.order {
            self.factorization.restore_order(order);
        }
        self.search = search.clone();
        self.stale = true;
    }

    /// Starts a step (or a piece of one): candidate pairs of each contact, and what the kernels keep of the start.
    pub(super) fn begin_step(&mut self, outlook: &Outlook) -> Result<(), LinearError> {
        self.assemblies_of_step = [0, self.assemblies_of_step[0]];
        let clock = Instant::now();
        let mut changed = false;
        for pair in &mut self.pairs {
            changed |= pair.kernel.update_candidates(outlook);
        }
        self.times.search += clock.elapsed();
        if changed || self.stale {
            let clock = Instant::now();
            self.pattern = pattern_of(&self.fixed, self.multipliers, &self.bodies, &self.pairs);
            self.factorization.renew(&self.pattern)?;
            self.place();
            self.stale = false;
            self.times.factorization += clock.elapsed();
        }
        let clock = Instant::now();
        for pair in &mut self.pairs {
            pair.kernel.begin_step(outlook.q);
        }
        self.times.contact += clock.elapsed();
        Ok(())
    }

    /// Residual and tangent of a step at `q_1` and `lambda`; the tangent waits for [`Self::solve`] where that will hardly come. Values of
    /// constraint rows are written by [`Self::solve`].
    pub(super) fn assemble(&mut self, start: &StepStart, q_1: &[f64], lambda: &[f64]) -> Result<Forces, AssemblyError> {
        let unknowns = q_1.len();
        let placement = start.integrator.placement();
        let clock = Instant::now();
        let inertia: Vec<f64> = (0..self.bodies.len()).map(|body| start.inertia(body)).collect();
        self.assemblies += 1;
        self.assemblies_of_step[0] += 1;
        let has_pressure = self.loads.iter().any(|load| matches!(load.kind, LoadKind::Pressure(_)));
        let is_probably_last = self.assemblies_of_step[0] == self.assemblies_of_step[1] && !has_pressure;
        self.deferred = None;
        let Scratch { mut internal, mut motion } = std::mem::take(&mut self.scratch);
        internal.resize(unknowns, 0.0);
        for (body, &inertia) in self.bodies.iter().zip(&inertia) {
            let step = Step { integrator: start.integrator, inertia, q_0: start.q_0, q_1 };
            body.elements
                .assemble(&step, &mut internal, (!is_probably_last).then_some(&mut self.values[..]), &self.workers)
                .map_err(|inverted| AssemblyError::Inverted { body: body.name.clone(), inverted })?;
        }
        let mut load = vec![0.0; unknowns];
        if !self.loads.is_empty() {
            motion.clear();
            let time = match placement.test {
                Configuration::Middle => {
                    motion.extend(start.q_0.iter().zip(q_1).map(|(a, b)| 0.5 * (a + b)));
                    start.time + 0.5 * start.dt
                }
                Configuration::End => {
                    motion.extend_from_slice(q_1);
                    start.time + start.dt
                }
            };
            self.loads_into(&motion, time, &mut load).map_err(AssemblyError::Load)?;
            self.add_pressure_tangent(time, placement.share * placement.weight).map_err(AssemblyError::Load)?;
        }
        // d: q_1 - q_0 for damping, q_1 - q_0 - dt v_0 for inertia.
        let push = if start.damping.is_some() { 0.0 } else { start.dt };
        motion.clear();
        motion.extend(q_1.iter().zip(start.q_0).zip(start.v_0).map(|((q_1, q_0), v_0)| q_1 - q_0 - push * v_0));
        if start.damping.is_none() {
            for (prescribed, v_1) in self.prescribed.iter().zip(start.prescribed_v_1) {
                motion[prescribed.unknown] = 0.5 * start.dt * (v_1 - start.v_0[prescribed.unknown]);
            }
        }
        let mut residual = vec![0.0; unknowns];
        self.mass.multiply_into::<D>(&motion, &mut residual);
        let (mut scale, mut internal_work) = (0.0f64, 0.0);
        for (body, inertia) in self.bodies.iter().zip(&inertia) {
            for k in body.nodes.start * D..body.nodes.end * D {
                let inertial = inertia * residual[k];
                load[k] *= placement.weight;
                internal_work += internal[k] * (q_1[k] - start.q_0[k]);
                let external = load[k] + placement.weight * self.weight[k];
                scale = scale.max(inertial.abs().max(internal[k].abs()).max(external.abs()));
                residual[k] = inertial + internal[k] - external + start.half_force[k];
            }
        }
        self.scratch = Scratch { internal, motion };
        self.times.assembly += clock.elapsed();

        let clock = Instant::now();
        let mut contact = vec![0.0; unknowns];
        for pair in &mut self.pairs {
            let lambda = &lambda[pair.rows.clone()];
            pair.kernel.evaluate(start.integrator, q_1, lambda, &mut pair.evaluation);
            let patches = pair.kernel.patches();
            let evaluation = &pair.evaluation;
            for p in 0..patches.len() {
                let (nodes, count) = (patches.nodes(p), patches.unknowns(p));
                if evaluation.live[p] {
                    let gradients = &evaluation.gradient_bar[patches.gradient_range(p)];
                    for (row, gradient) in patches.rows(p).iter().zip(gradients.chunks_exact(count)) {
                        let lambda = lambda[*row as usize];
                        for (u, &node) in nodes.iter().enumerate() {
                            for i in 0..D {
                                contact[node as usize * D + i] += lambda * gradient[u * D + i];
                            }
                        }
                    }
                }
            }
        }
        if is_probably_last {
            let (q_0, q_1) = (start.q_0.to_vec(), q_1.to_vec());
            self.deferred = Some(DeferredTangent { integrator: start.integrator, inertia, q_0, q_1 });
        } else {
            self.add_contact_tangent();
        }
        scale = scale.max(largest_size(&contact));
        self.times.contact += clock.elapsed();
        if residual.iter().any(|r| !r.is_finite()) {
            return Err(AssemblyError::NotFinite);
        }
        Ok(Forces { without_contact: residual, contact, load, internal_work, scale })
    }

    /// Subtracts the derivative of the contact forces at fixed multipliers.
    fn add_contact_tangent(&mut self) {
        for pair in &self.pairs {
            let patches = pair.kernel.patches();
            let (mut block, evaluation) = (0, &pair.evaluation);
            for p in 0..patches.len() {
                let (nodes, count) = (patches.nodes(p).len(), patches.unknowns(p));
                if evaluation.live[p] {
                    let tangent = &evaluation.tangent[patches.tangent_range(p)];
                    for u in 0..nodes {
                        for v in 0..nodes {
                            let place = pair.tangent_places[block + u * nodes + v];
                            for i in 0..D {
                                for k in 0..D {
                                    self.values[place.at(i, k)] -= tangent[(u * D + i) * count + v * D + k];
                                }
                            }
                        }
                    }
                }
                block += nodes * nodes;
            }
        }
    }

    /// Assembles the tangent that the last assembly left out, if it did.
    fn assemble_deferred_tangent(&mut self) {
        let Some(DeferredTangent { integrator, inertia, q_0, q_1 }) = self.deferred.take() else { return };
        let clock = Instant::now();
        self.scratch.internal.resize(q_1.len(), 0.0);
        for (body, inertia) in self.bodies.iter().zip(inertia) {
            let step = Step { integrator, inertia, q_0: &q_0, q_1: &q_1 };
            // No cell was inside out when the forces were assembled.
            let _ = body.elements.assemble(&step, &mut self.scratch.internal, Some(&mut self.values), &self.workers);
        }
        self.times.assembly += clock.elapsed();
        let clock = Instant::now();
        self.add_contact_tangent();
        self.times.contact += clock.elapsed();
    }

    /// Solves Newton's system for the increment and the new multipliers.
    pub(super) fn solve(&mut self, forces: &Forces, rows: &ConstraintRows) -> Result<(Vec<f64>, Vec<f64>), LinearError> {
        self.assemble_deferred_tangent();
        let clock = Instant::now();
        self.write_constraints(&rows.gradient, &rows.diagonal, |evaluation| &evaluation.gradient_bar);
        let unknowns = self.reference.len();
        let mut right: Vec<f64> = forces.without_contact.iter().zip(&self.fixed).map(|(r, &fixed)| if fixed { 0.0 } else { -r }).collect();
        right.extend_from_slice(&rows.right);
        self.factorizations += 1;
        self.factorization.factorize(&self.values)?;
        self.times.factorization += clock.elapsed();
        let clock = Instant::now();
        let outcome = self.factorization.solve(&self.values, &mut right);
        self.times.solve += clock.elapsed();
        outcome?;
        let lambda = right.split_off(unknowns);
        Ok((right, lambda))
    }

    /// Rates `grad Phi_A(q_1).v` of all constraints at the last [`Self::assemble`], as seen from obstacles that move.
    pub(super) fn rates(&self, v: &[f64]) -> Vec<f64> {
        let mut rates = vec![0.0; self.multipliers];
        self.for_each_end_gradient(|pair, row, k, gradient| {
            let seen = if pair.kind == PairKind::Obstacle { pair.obstacle_velocity[k % D] } else { 0.0 };
            rates[row] += gradient * (v[k] - seen);
        });
        rates
    }

    /// Tells every entry of the gradients at the end of the step: pair, row, unknown, value.
    fn for_each_end_gradient(&self, mut tell: impl FnMut(&Pair, usize, usize, f64)) {
        for pair in &self.pairs {
            let patches = pair.kernel.patches();
            for p in (0..patches.len()).filter(|&p| pair.evaluation.live[p]) {
                let gradients = &pair.evaluation.gradient_end[patches.gradient_range(p)];
                for (&row, gradient) in patches.rows(p).iter().zip(gradients.chunks_exact(patches.unknowns(p))) {
                    for (u, &node) in patches.nodes(p).iter().enumerate() {
                        for i in 0..D {
                            tell(pair, pair.rows.start + row as usize, node as usize * D + i, gradient[u * D + i]);
                        }
                    }
                }
            }
        }
    }

    /// A change of the velocities by impulses of the constraints: `w` with `(M + beta K_m(q_1)) w = G_1^T (lambda + mu)` and
    /// `G_1 w = rate` where `hold`, gradients as at the last [`Self::assemble`]. `K_m` is the material stiffness: its forces have neither
    /// resultant nor moment at `q_1`, so that `v_1 + s w` has the momenta of `v_1` for every `s`, up to what supports and obstacles push.
    pub(super) fn push(&mut self, q_1: &[f64], beta: f64, lambda: &[f64], hold: &[bool], rate: &[f64]) -> Result<Push, LinearError> {
        let clock = Instant::now();
        self.deferred = None;
        self.values.fill(0.0);
        for body in &self.bodies {
            body.elements.add_material_stiffness(q_1, beta, &mut self.values);
        }
        let free_values = self.fixed.contains(&true).then(|| self.values.clone());
        // Masses as large as gradients, or the round-off of the constraints would be felt as momentum.
        let gradient = self.pairs.iter().map(|pair| largest_size(&pair.evaluation.gradient_end)).fold(0.0, f64::max);
        let scale = gradient / self.largest_nodal_mass;
        self.values.iter_mut().for_each(|value| *value *= scale);
        let diagonal: Vec<f64> = hold.iter().map(|hold| if *hold { 0.0 } else { 1.0 }).collect();
        self.write_constraints(hold, &diagonal, |evaluation| &evaluation.gradient_end);
        let mut right = vec![0.0; q_1.len()];
        self.for_each_end_gradient(|_, row, k, gradient| right[k] += scale * lambda[row] * gradient);
        right.iter_mut().zip(&self.fixed).filter(|(_, fixed)| **fixed).for_each(|(f, _)| *f = 0.0);
        right.extend(hold.iter().zip(rate).map(|(hold, rate)| if *hold { *rate } else { 0.0 }));
        self.times.assembly += clock.elapsed();
        let clock = Instant::now();
        self.factorizations += 1;
        self.factorization.factorize(&self.values)?;
        self.times.factorization += clock.elapsed();
        let clock = Instant::now();
        self.factorization.solve(&self.values, &mut right)?;
        self.times.solve += clock.elapsed();
        let mu = right.split_off(q_1.len());
        let lambda: Vec<f64> = lambda.iter().zip(&mu).map(|(lambda, mu)| lambda + mu / scale).collect();
        let mut push = Push { velocity: right, lambda, impulse: vec![0.0; q_1.len()], work: 0.0 };
        let (mut on_nodes, mut from_obstacles, mut work) = (vec![0.0; q_1.len()], vec![0.0; q_1.len()], 0.0);
        self.for_each_end_gradient(|pair, row, k, gradient| {
            let f = push.lambda[row] * gradient;
            on_nodes[k] += f;
            if pair.kind == PairKind::Obstacle {
                from_obstacles[k] += f;
                work += f * pair.obstacle_velocity[k % D];
            }
        });
        (push.impulse, push.work) = (from_obstacles, work);
        // What the supports must push so that their nodes stay, besides what obstacles push.
        if let Some(values) = free_values {
            let mut vector = push.velocity.clone();
            vector.resize(q_1.len() + self.multipliers, 0.0);
            let mut needed = vec![0.0; q_1.len() + self.multipliers];
            self.pattern.multiply_into(&values, &vector, &mut needed);
            for k in (0..q_1.len()).filter(|&k| self.fixed[k]) {
                push.impulse[k] += needed[k] - on_nodes[k];
            }
        }
        Ok(push)
    }

    /// Whether the momenta of a push are the impulses from outside, as far as round-off lets them: where constraints all but depend on one
    /// another, the solution is accurate in its residual and in nothing else.
    pub(super) fn is_balanced(&self, push: &Push, q_1: &[f64]) -> bool {
        let momenta = self.nodal_momenta(&push.velocity);
        let sizes = |values: &[f64]| values.iter().map(|value| value.abs()).sum::<f64>();
        let (size, reach) = (sizes(&momenta), largest_size(q_1).max(self.extent));
        let off: Vec<f64> = momenta.iter().zip(&push.impulse).map(|(momentum, impulse)| momentum - impulse).collect();
        let far = |sum: [f64; 3], limit: f64| sum.iter().any(|x| x.abs() > limit);
        !far(resultant::<D>(&off), tolerances::PUSH * size) && !far(moment::<D>(q_1, &off), tolerances::PUSH * size * reach)
    }

    /// What contacts see at `q` before there is a step: gaps are known from the start.
    pub(super) fn survey(&mut self, q: &[f64]) {
        for pair in &mut self.pairs {
            self.stale |= pair.kernel.update_candidates(&Outlook::within(q, 0.0));
            pair.kernel.begin_step(q);
        }
    }

    /// Writes rows `G_1` and columns `-columns^T` of the active constraints, and the diagonal of all.
    fn write_constraints(&mut self, active: &[bool], diagonal: &[f64], columns: fn(&Evaluation) -> &Vec<f64>) {
        for (pair, clear) in self.pairs.iter().flat_map(|pair| [(pair, true), (pair, false)]) {
            let patches = pair.kernel.patches();
            let mut place = 0;
            for p in 0..patches.len() {
                let (nodes, count) = (patches.nodes(p).len(), patches.unknowns(p));
                let range = patches.gradient_range(p);
                for (m, &row) in patches.rows(p).iter().enumerate() {
                    let live = active[pair.rows.start + row as usize] && pair.evaluation.live[p];
                    if clear || live {
                        for u in 0..nodes {
                            let (row_place, column_place) = (pair.row_places[place + u], pair.column_places[place + u]);
                            for i in 0..D {
                                let entry = range.start + m * count + u * D + i;
                                if clear {
                                    self.values[row_place.at(0, i)] = 0.0;
                                    self.values[column_place.at(i, 0)] = 0.0;
                                } else {
                                    self.values[row_place.at(0, i)] += pair.evaluation.gradient_end[entry];
                                    self.values[column_place.at(i, 0)] -= columns(&pair.evaluation)[entry];
                                }
                            }
                        }
                    }
                    place += nodes;
                }
            }
        }
        for (place, &diagonal) in self.diagonal_places.iter().zip(diagonal) {
            self.values[*place as usize] = diagonal;
        }
        for &place in &self.zero_places {
            self.values[place as usize] = 0.0;
        }
        for &place in &self.identity_places {
            self.values[place as usize] = self.modulus;
        }
    }

    /// Constraint values after an increment `dq`, on the linearisation of the last [`Self::assemble`].
    pub(super) fn linearized_gaps(&self, dq: &[f64]) -> Vec<f64> {
        let mut gaps = Vec::with_capacity(self.multipliers);
        for pair in &self.pairs {
            gaps.extend_from_slice(&pair.evaluation.gap);
            let gaps = &mut gaps[pair.rows.clone()];
            let patches = pair.kernel.patches();
            for p in (0..patches.len()).filter(|&p| pair.evaluation.live[p]) {
                let gradients = &pair.evaluation.gradient_end[patches.gradient_range(p)];
                for (row, gradient) in patches.rows(p).iter().zip(gradients.chunks_exact(patches.unknowns(p))) {
                    for (u, &node) in patches.nodes(p).iter().enumerate() {
                        for i in 0..D {
                            gaps[*row as usize] += gradient[u * D + i] * dq[node as usize * D + i];
                        }
                    }
                }
            }
        }
        gaps
    }

    /// Kinetic energy `[energy]`.
    pub(super) fn kinetic_energy(&self, v: &[f64]) -> f64 {
        half_product(v, &self.nodal_momenta(v))
    }

    /// Strain energy `[energy]`.
    pub(super) fn strain_energy(&self, q: &[f64]) -> f64 {
        self.bodies.iter().map(|body| body.elements.strain_energy(q)).sum()
    }

    /// Potential energy of the penalty springs at the given weighted gaps `[energy]`.
    pub(super) fn penalty_energy(&self, gaps: &[f64]) -> f64 {
        let of = |pair: &Pair| 0.5 * pair.penalty * gaps[pair.rows.clone()].iter().map(|gap| gap.min(0.0).powi(2)).sum::<f64>();
        self.pairs.iter().map(of).sum()
    }

    /// Potential energy of gravity `[energy]`, zero at the origin.
    pub(super) fn potential_energy(&self, q: &[f64]) -> f64 {
        -q.iter().zip(&self.weight).map(|(q, w)| q * w).sum::<f64>()
    }

    /// Linear and angular momentum about the origin.
    pub(super) fn momenta(&self, q: &[f64], v: &[f64]) -> ([f64; 3], [f64; 3]) {
        let momenta = self.nodal_momenta(v);
        (resultant::<D>(&momenta), moment::<D>(q, &momenta))
    }

    /// `M v`.
    pub(super) fn nodal_momenta(&self, v: &[f64]) -> Vec<f64> {
        let mut momenta = vec![0.0; v.len()];
        self.mass.multiply_into::<D>(v, &mut momenta);
        momenta
    }
}

/// Why residual and tangent could not be computed.
pub(super) enum AssemblyError {
    Inverted { body: String, inverted: Inverted },
    Load(StepError),
    NotFinite,
}

/// `1/2 v.p`: kinetic energy from velocities and their nodal momenta.
pub(super) fn half_product(v: &[f64], p: &[f64]) -> f64 {
    0.5 * v.iter().zip(p).map(|(v, p)| v * p).sum::<f64>()
}

/// Sum of nodal vectors.
pub(super) fn resultant<const D: usize>(force: &[f64]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    force.chunks_exact(D).for_each(|f| add_force(&mut sum, f));
    sum
}

/// Sum of moments `q x f` about the origin.
pub(super) fn moment<const D: usize>(q: &[f64], force: &[f64]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    q.chunks_exact(D).zip(force.chunks_exact(D)).for_each(|(q, f)| add_moment(&mut sum, q, f));
    sum
}

/// Adds a nodal vector.
#[inline(always)]
pub(super) fn add_force(sum: &mut [f64; 3], f: &[f64]) {
    sum.iter_mut().zip(f).for_each(|(sum, f)| *sum += f);
}

/// Adds a moment `q x f`.
#[inline(always)]
pub(super) fn add_moment(sum: &mut [f64; 3], q: &[f64], f: &[f64]) {
    sum[2] += q[0] * f[1] - q[1] * f[0];
    if q.len() == 3 {
        sum[0] += q[1] * f[2] - q[2] * f[1];
        sum[1] += q[2] * f[0] - q[0] * f[2];
    }
}

/// The couplings of all cells and candidate pairs. The anchor of a multiplier is its secondary node, if that one is free to move and no
/// other pair's.
fn pattern_of<const D: usize>(fixed: &[bool], multipliers: usize, bodies: &[Body<D>], pairs: &[Pair]) -> Pattern {
    let nodes = fixed.len() / D;
    let mut sizes = vec![D as u8; nodes];
    sizes.resize(nodes + multipliers, 1);
    let mut patches: Vec<Vec<u32>> = Vec::new();
    for pair in pairs {
        let list = pair.kernel.patches();
        for p in 0..list.len() {
            let rows = list.rows(p).iter().map(|row| (nodes + pair.rows.start) as u32 + row);
            patches.push(list.nodes(p).iter().copied().chain(rows).collect());
        }
    }
    let cells = bodies.iter().flat_map(|body| body.elements.cliques().iter());
    let mut taken: Vec<bool> = fixed.chunks_exact(D).map(|components| components.contains(&true)).collect();
    let mut anchors = Vec::with_capacity(multipliers);
    for pair in pairs {
        // Several rows of one node oppose its motion in different directions.
        let rows: Vec<usize> = pair.rows.clone().collect();
        for (rows, &node) in rows.chunks_exact(pair.kernel.rows_per_node()).zip(pair.kernel.row_nodes()) {
            if !std::mem::replace(&mut taken[node as usize], true) {
                anchors.extend(rows.iter().map(|row| ((nodes + row) as u32, node)));
            }
        }
    }
    Pattern::new(&sizes, cells.chain(patches.iter()).map(|clique| &clique[..])).with_anchors(anchors)
}

/// Connected pieces of nodes: a number for each node, and how many pieces there are.
fn connected_pieces<'a>(nodes: usize, cliques: impl Iterator<Item = &'a Vec<u32>>) -> (Vec<u32>, usize) {
    let mut parent: Vec<u32> = (0..nodes as u32).collect();
    fn root(parent: &mut [u32], mut node: u32) -> u32 {
        while parent[node as usize] != node {
            parent[node as usize] = parent[parent[node as usize] as usize];
            node = parent[node as usize];
        }
        node
    }
    for clique in cliques {
        let first = root(&mut parent, clique[0]);
        for &node in &clique[1..] {
            let other = root(&mut parent, node);
            parent[other as usize] = first;
        }
    }
    let mut number = vec![u32::MAX; nodes];
    let mut count = 0;
    for node in 0..nodes {
        let top = root(&mut parent, node as u32) as usize;
        if number[top] == u32::MAX {
            number[top] = count;
            count += 1;
        }
        number[node] = number[top];
    }
    (number, count as usize)
}
