//! Equations of one model with matrix and solver: force elements in one numbering, and contact pairs, updated at the start of a step.
//!
//! Unknowns: the displacement components of all nodes, then one multiplier per row of every contact pair. Newton's system of a step is
//!
//! ```text
//! [ K   -Gbar^T ] [ dq     ]     [ r_0 ]         K = d r / d q_1  with the contact forces' part,
//! [ G_1     0   ] [ lambda ] = - [ Phi ]         r = r_0 - Gbar^T lambda
//! ```
//!
//! (Hesch and Betsch 2007, equation 3). Its numbers at an iterate are a [`Linearization`](super::iterate::Linearization).

use std::ops::Deref;
use std::sync::Arc;
use std::time::Instant;

use super::counters::Counters;
use super::equations::{Equations, parts};
use super::iterate::IterateStore;
use super::making::{PointInertia, bodies_of, deformable, loads_of, mass_of, part_followers, varying_gravity};
use super::matrix::{Matrix, pattern_of};
use super::search_history::SearchHistory;
use crate::bodies::{Elements, Space};
use crate::contact::{PredictedMotion, Setting};
use crate::dynamics::model::boundaries::middles;
use crate::dynamics::model::definitions::Model;
use crate::dynamics::model::error::ModelError;
use crate::dynamics::model::part::{Numbering, Part};
use crate::dynamics::model::update_rules::default_rule;
use crate::dynamics::parts::couplings::coupling_pairs;
use crate::dynamics::parts::nodes::Nodes;
use crate::dynamics::parts::pairing::contact_pairs;
use crate::dynamics::parts::rigid_bodies::point_pairs;
use crate::dynamics::parts::step_damping::StepDamping;
use crate::dynamics::parts::supports::Supports;
use crate::integrators::Scheme;
use crate::linear::{Block, InterruptWatch, LinearError, Pattern, SolverChoice, TakenOver, Work};
use crate::machine::memory::Shortage;
use crate::math::workers::Workers;

/// The equations of a model in `D` dimensions with matrix, counters and storage; functions that take [`Equations`] alone leave the latter
/// unchanged.
pub struct System<const D: usize> {
    /// Equations of the model: nodes, force elements, constraints.
    pub equations: Equations<D>,
    /// The matrix of the steps.
    pub matrix: Matrix,
    /// Counters of the work done so far.
    pub counters: Counters,
    /// Reusable storage of earlier iterates.
    pub spare: IterateStore,
    /// Search results and solver data for the next step, as last returned.
    search: Arc<SearchHistory>,
    /// True if an iterate is far from a solution, so that tangents omit the geometric stiffness of contact forces: with inaccurate
    /// multipliers this term may make the matrix nearly singular.
    pub is_far: bool,
    /// Displacements of prescribed unknowns, among all unknowns and multipliers, that Newton's next system prescribes; empty without
    /// prescribed displacements.
    pub given: Vec<f64>,
}

/// Gives read access to the equations.
impl<const D: usize> Deref for System<D> {
    type Target = Equations<D>;

    fn deref(&self) -> &Equations<D> {
        &self.equations
    }
}

impl<const D: usize> System<D>
where
    Space<D>: Elements<D>,
{
    /// Equations of a model in its initial configuration for a time integrator. With a lumped mass and without force elements other than
    /// bodies and loads no matrix is made until one is needed.
    ///
    /// # Errors
    /// A model that cannot be simulated.
    pub fn new(model: &Model, threads: usize, integrator: &Scheme, solver: SolverChoice) -> Result<Self, ModelError> {
        model.check()?;
        let lumping = integrator.lumping();
        let (mut bodies, reference) = bodies_of(model, integrator)?;
        let firsts: Vec<usize> = bodies.iter().map(|body| body.nodes.start).collect();
        let first = |body: usize| firsts[body];
        let mut loads = loads_of(model, &bodies);
        let numbering = Numbering { dimension: D, first: &firsts, reference: &reference };
        let mut others: Vec<Box<dyn Part>> = model.parts.iter().map(|part| part.part(&numbering)).collect();
        let damped = deformable(model).filter(|_| !integrator.dissipation.is_none());
        let dampings = damped.filter_map(|(index, body)| StepDamping::new(body, first(index))).collect();
        let followers = part_followers(model, &mut bodies, first, &reference, &others);
        let mut supports = Supports::new(model, &bodies, reference.len());
        followers.iter().for_each(|&node| supports.fixed[node as usize * D..][..D].fill(true));
        let middles = middles(model, first);
        let start = model.start_positions();
        let mut points = point_pairs(model, &bodies, &start);
        points.extend(coupling_pairs(model, &bodies, &start));
        let mut pairs = contact_pairs(model, first, &middles, [&reference, &start], default_rule(integrator), points);
        if !integrator.solves_impacts() {
            pairs.iter_mut().for_each(|pair| pair.restitution = None);
        }
        pairs.iter_mut().for_each(|pair| pair.acts_at_once = integrator.swings_at_constraints() && pair.has_multipliers());
        let normal_count = pairs.last().map_or(0, |pair| pair.rows.end);
        let multipliers =
            pairs.iter().filter_map(|pair| pair.friction.as_ref()).map(|friction| friction.rows.end).fold(normal_count, usize::max);
        let (mut masses, count): (Vec<(u32, f64)>, _) = (others.iter().flat_map(|part| part.point_masses()).collect(), reference.len() / D);
        // Bodies and loads have forces without places in a matrix, other parts may not.
        let has_matrix = lumping.is_none() || !others.is_empty();
        let pattern = if has_matrix {
            pattern_of::<D>(&supports.fixed, multipliers, parts(&bodies, &loads, &others), &pairs)
        } else {
            Pattern::new(&[], std::iter::empty::<&[u32]>())
        };
        let mass = mass_of(&bodies, lumping, &pattern, count, &mut masses)?;
        others.iter_mut().for_each(|part| part.weigh(&mass));
        let nodes = Nodes::new(model, &bodies, reference, (&supports.fixed, &followers), mass);
        loads.extend(varying_gravity(model, &nodes.nodal_mass));
        let workers = Workers::new(threads);
        pairs.iter_mut().for_each(|pair| pair.kernel.set(Setting::Workers(&workers)));
        let matrix = Matrix::new(pattern, solver, &nodes.reference, &workers).map_err(|error| match error {
            LinearError::Ranks(error) => ModelError::Ranks(error),
            error => ModelError::TooLarge { reason: error.to_string() },
        })?;
        let equations = Equations {
            nodes,
            supports,
            bodies,
            loads,
            others,
            own_parts: model.parts.len(),
            dampings,
            point_masses: masses.into_iter().map(|(node, mass)| PointInertia { node, mass, place: Block::default() }).collect(),
            pairs,
            multipliers,
            normal_count,
            redundant: vec![false; multipliers],
            workers,
        };
        let mut system = System {
            equations,
            matrix,
            counters: Counters::default(),
            spare: IterateStore::default(),
            search: Arc::default(),
            is_far: false,
            given: Vec::new(),
        };
        system.matrix.is_stale = !has_matrix;
        if has_matrix {
            system.place();
        }
        Ok(system)
    }
}

impl<const D: usize> System<D> {
    /// Work counters of the linear solver.
    pub fn work(&self) -> Work {
        self.matrix.solver.work()
    }

    /// Matrices that the direct solver took over from the chosen one.
    pub fn taken_over(&self) -> TakenOver {
        self.matrix.solver.taken_over()
    }

    /// Memory of the matrix factors `[bytes]`.
    pub fn factor_bytes(&self) -> usize {
        self.matrix.solver.bytes()
    }

    /// Largest memory of each rank of a distributed solver `[bytes]`; empty for others.
    pub fn rank_bytes(&self) -> &[u64] {
        self.matrix.solver.rank_bytes()
    }

    /// Sets the interrupt flag and progress counter of long factorizations.
    pub fn watch(&mut self, watch: InterruptWatch) {
        self.matrix.solver.set_watch(watch);
    }

    /// Motion and multipliers in the (approximate) null space of the singular tangent of the last solve.
    pub fn near_null_vector(&self) -> &[f64] {
        self.matrix.solver.near_null_vector().unwrap_or_default()
    }

    /// Finds the matrix positions of all contributions in a new pattern.
    fn place(&mut self) {
        self.equations.place(&self.matrix.pattern);
        self.matrix.place::<D>(&self.equations.supports.fixed, self.equations.multipliers);
    }

    /// Search results and solver data for the next step; the shared value is replaced only if something has changed.
    pub fn search(&mut self) -> Arc<SearchHistory> {
        let (kept, solver) = (&self.search.candidates, self.matrix.solver.memory());
        let are_same = kept.len() == self.pairs.len()
            && self.pairs.iter().zip(kept.iter()).all(|(pair, kept)| pair.kernel.candidates() == kept.as_ref());
        if !are_same || self.search.solver != solver {
            let listed = || Arc::new(self.pairs.iter().map(|pair| pair.kernel.candidates().cloned()).collect());
            let candidates = if are_same { kept.clone() } else { listed() };
            self.search = Arc::new(SearchHistory { candidates, solver });
        }
        self.search.clone()
    }

    /// Restores the candidate pairs of an earlier step at its positions.
    pub fn restore_search(&mut self, search: &Arc<SearchHistory>, q: &[f64], time: f64) {
        // Errors of time functions are reported by the next step, which evaluates them again.
        let _ = self.equations.move_obstacles(time, 0.0);
        let is_present = *self.search() == **search;
        for (pair, candidates) in self.equations.pairs.iter_mut().zip(search.candidates.iter()) {
            if let Some(candidates) = candidates {
                pair.kernel.restore_candidates(candidates, q);
            }
        }
        if is_present {
            return;
        }
        self.matrix.solver.recall(&search.solver);
        self.search = search.clone();
        self.matrix.is_stale = true;
    }

    /// Begins a step (or a substep): candidate pairs of each contact, and the data of the kernels that depend on the start.
    ///
    /// # Errors
    /// The equations do not fit into memory.
    pub fn begin_step(&mut self, predicted_motion: &PredictedMotion) -> Result<(), LinearError> {
        self.begin_deep_step(predicted_motion, &[])
    }

    /// Begins a step at rest; `depths`: largest penetration up to which each pair is admitted. Pairs beyond the list are admitted as in
    /// motion.
    pub fn begin_deep_step(&mut self, predicted_motion: &PredictedMotion, depths: &[f64]) -> Result<(), LinearError> {
        let changed = self.find_candidates(predicted_motion, depths);
        self.matrix.solver.locate(predicted_motion.q);
        if changed || self.matrix.is_stale {
            let clock = Instant::now();
            self.ensure_patches().map_err(|shortage| LinearError::out_of_memory(self.nodes.reference.len(), shortage))?;
            self.matrix.renew(pattern_of::<D>(
                &self.supports.fixed,
                self.multipliers,
                parts(&self.bodies, &self.loads, &self.others),
                &self.pairs,
            ))?;
            self.place();
            self.counters.times.factorization += clock.elapsed();
        }
        self.begin_pairs(predicted_motion);
        Ok(())
    }

    /// Finds the candidate pairs of each contact; returns true if they changed.
    pub(super) fn find_candidates(&mut self, predicted_motion: &PredictedMotion, depths: &[f64]) -> bool {
        self.spare.begin_step();
        let clock = Instant::now();
        let mut changed = false;
        for (pair, depth) in self.equations.pairs.iter_mut().zip(depths.iter().copied().chain(std::iter::repeat(0.0))) {
            changed |= pair.kernel.update_candidates(&PredictedMotion { depth, ..*predicted_motion });
        }
        self.counters.times.search += clock.elapsed();
        changed
    }

    /// Updates the data of contacts that depend on the start of a step.
    pub(super) fn begin_pairs(&mut self, predicted_motion: &PredictedMotion) {
        let clock = Instant::now();
        for pair in &mut self.equations.pairs {
            pair.kernel.begin_step(predicted_motion.q);
        }
        self.counters.times.contact += clock.elapsed();
    }

    /// Evaluates the contact search at `q` before the first step, so that gaps are available from the start.
    ///
    /// # Errors
    /// The contacts do not fit into memory.
    pub fn survey(&mut self, q: &[f64]) -> Result<(), Shortage> {
        for pair in &mut self.equations.pairs {
            self.matrix.is_stale |= pair.kernel.update_candidates(&PredictedMotion::within(q, 0.0));
        }
        self.ensure_patches()?;
        self.equations.pairs.iter_mut().for_each(|pair| pair.kernel.begin_step(q));
        self.equations.redundant = self.redundant_rows();
        Ok(())
    }
}
