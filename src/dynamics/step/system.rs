//! The equations of one model: its parts in one numbering, and what joins them at the start of a step.
//!
//! Unknowns: the displacement components of all nodes, then one multiplier per row of every contact pair. Newton's system of a step is
//!
//! ```text
//! [ K   -Gbar^T ] [ dq     ]     [ r_0 ]         K = d r / d q_1  with the contact forces' part,
//! [ G_1     0   ] [ lambda ] = - [ Phi ]         r = r_0 - Gbar^T lambda
//! ```
//!
//! (Hesch and Betsch 2007, equation 3). Its numbers at an iterate are a [`Linearization`](super::iterate::Linearization).

use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use super::counters::Counters;
use super::iterate::{Linearization, Spare};
use super::making::{PointInertia, bodies_of, deformable, loads_of, mass_of, part_followers, varying_gravity};
use super::matrix::{Matrix, pattern_of};
use super::search_history::SearchHistory;
use crate::bodies::{Elements, Space};
use crate::contact::{Correction, Outlook};
use crate::dynamics::model::boundaries::middles;
use crate::dynamics::model::definitions::Model;
use crate::dynamics::model::error::ModelError;
use crate::dynamics::model::part::{Numbering, Part, Pose};
use crate::dynamics::model::step_error::StepError;
use crate::dynamics::model::update_rules::default_rule;
use crate::dynamics::parts::body::Body;
use crate::dynamics::parts::contact_pair::{ContactPair, PairKind};
use crate::dynamics::parts::couplings::coupling_pairs;
use crate::dynamics::parts::friction_rows::FrictionRows;
use crate::dynamics::parts::laws::RowState;
use crate::dynamics::parts::loads::{NodalLoad, loads_into};
use crate::dynamics::parts::nodes::Nodes;
use crate::dynamics::parts::pairing::contact_pairs;
use crate::dynamics::parts::rigid_bodies::point_pairs;
use crate::dynamics::parts::step_damping::StepDamping;
use crate::dynamics::parts::supports::Supports;
use crate::dynamics::parts::viscosity::ViscousBody;
use crate::integrators::Scheme;
use crate::linear::{Block, LinearError, Pattern, Watch, Work};
use crate::machine::memory::{self, Shortage};
use crate::math::workers::Workers;

/// The equations of a model in `D` dimensions.
pub struct System<const D: usize> {
    /// The nodes of all bodies.
    pub nodes: Nodes<D>,
    /// What holds or moves some of them.
    pub supports: Supports,
    /// Deformable bodies.
    pub bodies: Vec<Body<D>>,
    /// Loads.
    pub loads: Vec<NodalLoad<D>>,
    /// What pushes on nodes besides.
    pub others: Vec<Box<dyn Part>>,
    /// How many of these, the first, are the model's own parts.
    pub own_parts: usize,
    /// What the time integrator takes from the vibrations of deformable bodies; none where it takes nothing.
    pub dampings: Vec<StepDamping>,
    /// Masses that these have at nodes.
    pub(super) point_masses: Vec<PointInertia>,
    /// Contacts, obstacles and ties, then the corners that belong to them.
    pub pairs: Vec<ContactPair>,
    /// Number of their rows, those that press before the tangential ones.
    pub multipliers: usize,
    /// Number of the rows that press.
    pub pressing: usize,
    /// Rows of ties that follow from others and from supports, and take part in no step.
    pub redundant: Vec<bool>,
    /// The matrix of the steps.
    pub matrix: Matrix,
    /// What has been done so far.
    pub counters: Counters,
    /// Storage of iterates that are gone.
    pub spare: Spare,
    /// What the next step takes over from the ones before, as it was asked for last.
    search: Arc<SearchHistory>,
    /// Whether an iterate is so far from a solution that tangents leave out how contact forces turn with the surfaces: with multipliers
    /// that do not belong to its positions that is no stiffness, and may make the matrix all but singular.
    pub is_far: bool,
    /// Displacements of prescribed unknowns, among all unknowns and multipliers, that Newton's next system takes for given; nothing where
    /// they have none.
    pub given: Vec<f64>,
    pub workers: Workers,
}

/// Everything that pushes on nodes, bodies first.
pub fn parts<'a, const D: usize>(
    bodies: &'a [Body<D>],
    loads: &'a [NodalLoad<D>],
    others: &'a [Box<dyn Part>],
) -> impl Iterator<Item = &'a dyn Part> {
    let bodies = bodies.iter().map(|body| body as &dyn Part);
    bodies.chain(loads.iter().map(|load| load as &dyn Part)).chain(others.iter().map(|part| &**part))
}

impl<const D: usize> System<D>
where
    Space<D>: Elements<D>,
{
    /// The equations of a model in its initial configuration for a time integrator. With a mass at the nodes alone there is no matrix until
    /// one is asked for, if bodies and loads are all that there is.
    ///
    /// # Errors
    /// A model that cannot be simulated.
    pub fn new(model: &Model, threads: usize, integrator: &Scheme) -> Result<Self, ModelError> {
        model.check()?;
        let lumping = integrator.lumping();
        let (mut bodies, reference) = bodies_of(model, integrator)?;
        let firsts: Vec<usize> = bodies.iter().map(|body| body.nodes.start).collect();
        let first = |body: usize| firsts[body];
        let mut supports = Supports::new::<D>(model, reference.len(), |body, node| node + first(body) as u32);
        let mut loads = loads_of(model, &bodies);
        let numbering = Numbering { dimension: D, first: &firsts, reference: &reference };
        let mut others: Vec<Box<dyn Part>> = model.parts.iter().map(|part| part.part(&numbering)).collect();
        others.extend(deformable(model).filter_map(|(index, body)| Some(Box::new(ViscousBody::new(body, first(index))?) as Box<dyn Part>)));
        let damped = deformable(model).filter(|_| !integrator.dissipation.is_none());
        let dampings = damped.map(|(index, body)| StepDamping::new(body, first(index))).collect();
        let followers = part_followers(model, &mut bodies, first, &others);
        followers.iter().for_each(|&node| supports.fixed[node as usize * D..][..D].fill(true));
        let middles = middles(model, first);
        let mut points = point_pairs(model, &bodies, &reference);
        points.extend(coupling_pairs(model, first, &reference));
        let pairs = contact_pairs(model, first, &middles, &reference, default_rule(integrator), points);
        let pressing = pairs.last().map_or(0, |pair| pair.rows.end);
        let multipliers =
            pairs.iter().filter_map(|pair| pair.friction.as_ref()).map(|friction| friction.rows.end).fold(pressing, usize::max);
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
        let matrix = Matrix::new(pattern, &workers).map_err(|error| ModelError::TooLarge { reason: error.to_string() })?;
        let mut system = System {
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
            pressing,
            redundant: vec![false; multipliers],
            matrix,
            counters: Counters::default(),
            spare: Spare::default(),
            search: Arc::default(),
            is_far: false,
            given: Vec::new(),
            workers,
        };
        system.matrix.is_stale = !has_matrix;
        if has_matrix {
            system.place();
        }
        Ok(system)
    }

    /// Whether something depends on positions, not on displacements alone.
    pub fn sees_positions(&self) -> bool {
        !self.pairs.is_empty() || !self.others.is_empty()
    }

    /// Energy that parts other than bodies store with what each part remembers `[energy]`.
    pub fn stored_energy(&self, at: Pose, memory: &[Vec<f64>]) -> f64 {
        self.parts().zip(memory).skip(self.bodies.len()).map(|(part, memory)| part.energy(at, memory)).sum()
    }

    /// What the parts remember at the start, and at rest.
    pub fn memory_at_rest(&self) -> Arc<Vec<Vec<f64>>> {
        Arc::new(self.parts().map(|part| part.memory()).collect())
    }

    /// The model's own parts with what each remembers.
    pub fn own_parts<'a>(&'a self, memory: &'a [Vec<f64>]) -> impl Iterator<Item = (&'a dyn Part, &'a Vec<f64>)> {
        self.parts().zip(memory).skip(self.bodies.len() + self.loads.len()).take(self.own_parts)
    }

    /// Strain energy `[energy]`.
    pub fn strain_energy(&self, u: &[f64]) -> f64 {
        self.bodies.iter().map(|body| body.elements.strain_energy(u)).sum()
    }
}

impl<const D: usize> System<D> {
    /// Everything that pushes on nodes, bodies first.
    pub fn parts(&self) -> impl Iterator<Item = &dyn Part> {
        parts(&self.bodies, &self.loads, &self.others)
    }

    /// Moves what rigid bodies carry along, in a nodal vector: displacements, velocities.
    pub fn lead(&self, values: &mut [f64]) {
        self.bodies.iter().filter_map(|body| body.rigid.as_ref()).for_each(|rigid| rigid.lead::<D>(values));
    }

    /// The same in displacements and the positions that follow from them.
    pub fn lead_positions(&self, u: &mut [f64], q: &mut [f64]) {
        for rigid in self.bodies.iter().filter_map(|body| body.rigid.as_ref()) {
            rigid.lead::<D>(u);
            for node in rigid.followers() {
                (node * D..(node + 1) * D).for_each(|k| q[k] = self.nodes.reference[k] + u[k]);
            }
        }
    }

    /// The same in what a step that has converged ends with.
    pub fn lead_end(&self, at: &mut Linearization) {
        self.lead(&mut at.moved);
        self.lead_positions(&mut at.u_1, &mut at.q_1);
    }

    /// The smallest facet of all contacts `[length]`; infinite without one.
    pub fn smallest_facet(&self) -> f64 {
        let contacts = self.pairs.iter().filter(|pair| !pair.kind.is_of_points());
        contacts.map(|pair| pair.kernel.facet_size()).fold(f64::INFINITY, f64::min)
    }

    /// Chooses the contact kernels' discrete gradient.
    pub fn set_correction(&mut self, correction: Correction) {
        self.pairs.iter_mut().for_each(|pair| pair.kernel.set_correction(correction));
    }

    /// What the linear solver has done.
    pub fn work(&self) -> Work {
        self.matrix.solver.work()
    }

    /// Bytes of the factors.
    pub fn factor_bytes(&self) -> usize {
        self.matrix.solver.bytes()
    }

    /// Lets long factorisations be looked into.
    pub fn watch(&mut self, watch: Watch) {
        self.matrix.solver.set_watch(watch);
    }

    /// Number of secondary nodes in contact: active constraints, those of ties left out.
    pub fn touching(&self, active: &[RowState]) -> usize {
        self.closed_nodes(active).iter().zip(&self.pairs).filter(|(_, pair)| pair.kind != PairKind::Tie).map(|(closed, _)| closed).sum()
    }

    /// Number of nodes that active constraints hold, of each contact in the order of the model.
    pub fn closed_nodes(&self, active: &[RowState]) -> Vec<usize> {
        let held_by = |pair: &ContactPair| -> Vec<u32> {
            let stride = pair.kernel.rows_per_node();
            let rows = active[pair.rows.clone()].chunks_exact(stride).enumerate().filter(|(_, rows)| rows.contains(&RowState::Closed));
            // Corners of obstacles are numbered by their rows, from behind.
            rows.map(|(index, _)| pair.kernel.row_nodes().get(index).copied().unwrap_or(u32::MAX - index as u32)).collect()
        };
        let of = |(index, pair): (usize, &ContactPair)| {
            let mut nodes = held_by(pair);
            let corners = self.corners_of(index);
            corners.for_each(|corners| nodes.extend(held_by(corners)));
            nodes.sort_unstable();
            nodes.dedup();
            nodes.len()
        };
        self.contacts().map(of).collect()
    }

    /// Index of the contact that a pair belongs to: itself, or that whose corners it holds.
    pub fn contact_of(&self, index: usize) -> usize {
        self.pairs[index].corners.map_or(index, |corners| corners.pair)
    }

    /// Sums what each pair has over the contact that it belongs to.
    pub fn by_contact(&self, of: impl Fn(usize, &ContactPair) -> f64) -> Vec<f64> {
        let mut sums = vec![0.0; self.contacts().count()];
        let pairs = self.pairs.iter().enumerate().filter(|(_, pair)| !pair.kind.is_of_points());
        pairs.for_each(|(index, pair)| sums[self.contact_of(index)] += of(index, pair));
        sums
    }

    /// The pairs that are contacts of the model, with their indices.
    pub fn contacts(&self) -> impl Iterator<Item = (usize, &ContactPair)> {
        self.pairs.iter().enumerate().filter(|(_, pair)| pair.corners.is_none() && !pair.kind.is_of_points())
    }

    /// The pairs that belong to a contact besides.
    pub fn corners_of(&self, index: usize) -> impl Iterator<Item = &ContactPair> {
        self.pairs.iter().filter(move |pair| pair.corners.is_some_and(|corners| corners.pair == index))
    }

    /// The pair of a row, one that presses or a tangential one.
    pub fn pair_of(&self, row: usize) -> Option<&ContactPair> {
        let is_own =
            |pair: &&ContactPair| pair.rows.contains(&row) || pair.friction.as_ref().is_some_and(|friction| friction.rows.contains(&row));
        self.pairs.iter().find(is_own)
    }

    /// The row that presses beside a tangential row.
    pub fn pressing_row(&self, slip: usize) -> usize {
        self.tangential_at(slip, |pair, friction| pair.rows.start + friction.pressing(slip))
            .expect("every tangential row belongs to a pair")
    }

    /// The rows that change their state together with a row: it alone, or all tangential ones beside one that presses.
    pub fn group_of(&self, row: usize) -> Range<usize> {
        self.tangential_at(row, |_, friction| friction.group(friction.pressing(row))).unwrap_or(row..row + 1)
    }

    /// The other tangential row of a group of two.
    pub fn partner_row(&self, slip: usize) -> usize {
        let group = self.group_of(slip);
        group.start + group.end - 1 - slip
    }

    fn tangential_at<T>(&self, row: usize, of: impl Fn(&ContactPair, &FrictionRows) -> T) -> Option<T> {
        let owns = |pair: &ContactPair| Some(of(pair, pair.friction.as_ref().filter(|friction| friction.rows.contains(&row))?));
        self.pairs.iter().find_map(owns)
    }

    /// The body that owns a node.
    pub fn body_of(&self, node: usize) -> usize {
        self.bodies.iter().position(|body| body.nodes.contains(&node)).expect("every node belongs to a body")
    }

    /// Name of the body that owns a node, and the node's number in the body's mesh.
    pub fn owner(&self, node: usize) -> (&str, usize) {
        let body = &self.bodies[self.body_of(node)];
        (&body.name, node - body.nodes.start)
    }

    /// A motion and multipliers that the singular tangent of the last solve maps to zero, near enough.
    pub fn near_null_vector(&self) -> &[f64] {
        self.matrix.solver.near_null_vector().unwrap_or_default()
    }

    /// Loads at a configuration and time, gravity not included; tells whether any acted.
    ///
    /// # Errors
    /// A time function failed.
    pub fn loads_into(&self, q: &[f64], time: f64, force: &mut [f64]) -> Result<bool, StepError> {
        loads_into::<D>(&self.loads, q, time, force)
    }

    /// Energy of the potentials of rows at the given weighted gaps `[energy]`.
    pub fn penalty_energy(&self, gaps: &[f64]) -> f64 {
        let of = |pair: &ContactPair| {
            pair.penalties.iter().zip(&gaps[pair.rows.clone()]).map(|(&kappa, &gap)| pair.law.energy(kappa, gap)).sum::<f64>()
        };
        self.pairs.iter().map(of).sum()
    }

    /// Finds the places of all contributions in a new pattern.
    fn place(&mut self) {
        let (pattern, nodes) = (&self.matrix.pattern, self.nodes.count());
        self.bodies.iter_mut().for_each(|body| body.place(pattern));
        self.loads.iter_mut().for_each(|load| load.place(pattern));
        self.others.iter_mut().for_each(|part| part.place(pattern));
        self.dampings.iter_mut().for_each(|damping| damping.place(pattern));
        self.point_masses.iter_mut().for_each(|point| point.place = pattern.block(point.node, point.node));
        self.pairs.iter_mut().for_each(|pair| pair.place(pattern, nodes));
        self.matrix.place::<D>(&self.supports.fixed, self.multipliers);
    }

    /// Puts the rigid obstacles where they are in a step of that size from `time`.
    ///
    /// # Errors
    /// A time function failed.
    pub fn move_obstacles(&mut self, time: f64, dt: f64) -> Result<(), StepError> {
        self.pairs.iter_mut().try_for_each(|pair| pair.move_obstacle(time, dt))
    }

    /// Lets the rigid obstacles carry along what sticks to them as far as they move from one time to another.
    ///
    /// # Errors
    /// A time function failed.
    pub fn carry(&mut self, from: f64, to: f64) -> Result<(), StepError> {
        self.pairs.iter_mut().try_for_each(|pair| pair.carry(from, to))
    }

    /// How far an obstacle goes from one time to another at most, over the shortest facet of what it may touch.
    ///
    /// # Errors
    /// A time function failed.
    pub fn obstacle_motion(&mut self, from: f64, to: f64) -> Result<f64, StepError> {
        let mut at = |time: f64| -> Result<Vec<[f64; 3]>, StepError> {
            self.move_obstacles(time, 0.0)?;
            Ok(self.pairs.iter().map(|pair| pair.kernel.obstacle_translation()).collect())
        };
        let (begins, ends) = (at(from)?, at(to)?);
        let moved = begins.iter().zip(&ends).map(|(a, b)| (b[0] - a[0]).hypot(b[1] - a[1]).hypot(b[2] - a[2]));
        Ok(moved.zip(&self.pairs).map(|(moved, pair)| moved / pair.kernel.facet_size()).fold(0.0, f64::max))
    }

    /// What the next step takes over from the ones before; the same value as long as nothing has changed.
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

    /// Puts the candidates of an earlier step in place, at its positions.
    pub fn restore_search(&mut self, search: &Arc<SearchHistory>, q: &[f64], time: f64) {
        // A time function that fails does so again, with its error, in the next step.
        let _ = self.move_obstacles(time, 0.0);
        let is_present = *self.search() == **search;
        for (pair, candidates) in self.pairs.iter_mut().zip(search.candidates.iter()) {
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

    /// Starts a step (or a piece of one): candidate pairs of each contact, and what the kernels keep of the start.
    ///
    /// # Errors
    /// The equations do not fit into memory.
    pub fn begin_step(&mut self, outlook: &Outlook) -> Result<(), LinearError> {
        self.begin_deep_step(outlook, &[])
    }

    /// The same at rest, where pairs take part up to a depth of their own; those beyond the list as they do in motion.
    ///
    /// # Errors
    /// The equations do not fit into memory.
    pub fn begin_deep_step(&mut self, outlook: &Outlook, depths: &[f64]) -> Result<(), LinearError> {
        let changed = self.find_candidates(outlook, depths);
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
        self.begin_pairs(outlook);
        Ok(())
    }

    /// Finds the candidate pairs of each contact; whether they are others than before.
    pub(super) fn find_candidates(&mut self, outlook: &Outlook, depths: &[f64]) -> bool {
        self.spare.begin_step();
        let clock = Instant::now();
        let mut changed = false;
        for (pair, depth) in self.pairs.iter_mut().zip(depths.iter().copied().chain(std::iter::repeat(0.0))) {
            changed |= pair.kernel.update_candidates(&Outlook { depth, ..*outlook });
        }
        self.counters.times.search += clock.elapsed();
        changed
    }

    /// Lets contacts keep what depends on the start of a step.
    pub(super) fn begin_pairs(&mut self, outlook: &Outlook) {
        let clock = Instant::now();
        for pair in &mut self.pairs {
            pair.kernel.begin_step(outlook.q);
        }
        self.counters.times.contact += clock.elapsed();
    }

    /// What contacts see at `q` before there is a step: gaps are known from the start.
    ///
    /// # Errors
    /// The contacts do not fit into memory.
    pub fn survey(&mut self, q: &[f64]) -> Result<(), Shortage> {
        for pair in &mut self.pairs {
            self.matrix.is_stale |= pair.kernel.update_candidates(&Outlook::within(q, 0.0));
        }
        self.ensure_patches()?;
        self.pairs.iter_mut().for_each(|pair| pair.kernel.begin_step(q));
        self.redundant = self.redundant_rows();
        Ok(())
    }

    /// Whether there is memory for what contacts couple: a patch of a coarse side and many fine facets grows with the square of these.
    pub(super) fn ensure_patches(&self) -> Result<(), Shortage> {
        memory::ensure(self.pairs.iter().map(|pair| pair.kernel.patches().bytes()).fold(0, u64::saturating_add))
    }
}
