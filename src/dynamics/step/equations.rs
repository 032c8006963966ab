//! The equations of a model in `D` dimensions: nodes, force elements, constraints. A step reads them; contacts keep the data that depend on
//! its start.

use std::ops::Range;
use std::sync::Arc;

use super::iterate::Linearization;
use super::making::PointInertia;
use crate::bodies::{BodyState, Elements, Space};
use crate::contact::{Correction, Setting};
use crate::dynamics::model::part::{Part, PartHistories, Pose};
use crate::dynamics::model::step_error::StepError;
use crate::dynamics::parts::body::Body;
use crate::dynamics::parts::contact_pair::{ContactPair, PairKind};
use crate::dynamics::parts::friction_rows::FrictionRows;
use crate::dynamics::parts::laws::RowState;
use crate::dynamics::parts::loads::{NodalLoad, loads_into};
use crate::dynamics::parts::nodes::Nodes;
use crate::dynamics::parts::step_damping::StepDamping;
use crate::dynamics::parts::supports::Supports;
use crate::linear::Pattern;
use crate::machine::memory::{self, Shortage};
use crate::math::workers::Workers;

/// The equations of a model in `D` dimensions.
pub struct Equations<const D: usize> {
    /// The nodes of all bodies.
    pub nodes: Nodes<D>,
    /// Supports: fixed and prescribed displacement components.
    pub supports: Supports,
    /// Deformable bodies.
    pub bodies: Vec<Body<D>>,
    /// Loads.
    pub loads: Vec<NodalLoad<D>>,
    /// Force elements other than bodies and loads.
    pub others: Vec<Box<dyn Part>>,
    /// Number of leading entries of `others` that the model defines itself.
    pub own_parts: usize,
    /// Algorithmic dissipation of the deformable bodies; empty if the time integrator does not dissipate.
    pub dampings: Vec<StepDamping<D>>,
    /// Nodal masses of the force elements in `others`.
    pub(super) point_masses: Vec<PointInertia>,
    /// Pairs of contacts, obstacles and ties, followed by their corner pairs.
    pub pairs: Vec<ContactPair>,
    /// Number of constraints of all pairs, normal ones before tangential ones.
    pub multipliers: usize,
    /// Number of normal constraints.
    pub normal_count: usize,
    /// True for each redundant constraint of ties, which depends on other constraints and on supports and is excluded from every step.
    pub redundant: Vec<bool>,
    /// Threads for sums over cells.
    pub workers: Workers,
}

/// All force elements, bodies first.
pub fn parts<'a, const D: usize>(
    bodies: &'a [Body<D>],
    loads: &'a [NodalLoad<D>],
    others: &'a [Box<dyn Part>],
) -> impl Iterator<Item = &'a dyn Part> {
    let bodies = bodies.iter().map(|body| body as &dyn Part);
    bodies.chain(loads.iter().map(|load| load as &dyn Part)).chain(others.iter().map(|part| &**part))
}

impl<const D: usize> Equations<D>
where
    Space<D>: Elements<D>,
{
    /// True if forces depend on positions and not on displacements alone.
    pub fn depends_on_positions(&self) -> bool {
        !self.pairs.is_empty() || !self.others.is_empty()
    }

    /// Energy stored by parts other than bodies with the history variables `memory`, and by the relaxing stress in bodies `[energy]`.
    pub fn stored_energy(&self, at: Pose, memory: &[Vec<f64>]) -> f64 {
        let others: f64 = self.parts().zip(memory).skip(self.bodies.len()).map(|(part, memory)| part.energy(at, memory)).sum();
        others + self.bodies.iter().zip(memory).map(|(body, history)| body.elements.relaxing_energy(history)).sum::<f64>()
    }

    /// Initial history variables of all force elements, at rest with displacements `u`.
    pub fn memory_at_rest(&self, u: &[f64]) -> PartHistories {
        let of_body = |body: &Body<D>| body.elements.relaxed(BodyState { u, history: &body.memory() });
        let others = self.parts().skip(self.bodies.len()).map(|part| part.memory());
        Arc::new(self.bodies.iter().map(of_body).chain(others).collect())
    }

    /// History variables of all parts in an equilibrium at a time: plastic strains of bodies remain, rate-dependent stresses (viscosity)
    /// have relaxed.
    pub fn relaxed(&self, time: f64, at: Pose, memory: &[Vec<f64>]) -> PartHistories {
        let bodies = self.bodies.iter().zip(memory).map(|(body, history)| body.elements.relaxed(BodyState { u: at.u, history }));
        let others = self.parts().zip(memory).skip(self.bodies.len()).map(|(part, memory)| part.settled(time, at, memory));
        Arc::new(bodies.chain(others).collect())
    }

    /// Force elements defined by the model, with their history variables.
    pub fn own_parts<'a>(&'a self, memory: &'a [Vec<f64>]) -> impl Iterator<Item = (&'a dyn Part, &'a Vec<f64>)> {
        self.parts().zip(memory).skip(self.bodies.len() + self.loads.len()).take(self.own_parts)
    }

    /// Strain energy with the history variables `memory` `[energy]`.
    pub fn strain_energy(&self, u: &[f64], memory: &[Vec<f64>]) -> f64 {
        let of = |(body, history): (&Body<D>, &Vec<f64>)| body.elements.strain_energy(BodyState { u, history });
        self.bodies.iter().zip(memory).map(of).sum()
    }
}

impl<const D: usize> Equations<D> {
    /// All force elements, bodies first.
    pub fn parts(&self) -> impl Iterator<Item = &dyn Part> {
        parts(&self.bodies, &self.loads, &self.others)
    }

    /// Moves the followers of rigid bodies with their masters, in a nodal vector: displacements, velocities.
    pub fn lead(&self, values: &mut [f64]) {
        self.bodies.iter().filter_map(|body| body.rigid.as_ref()).for_each(|rigid| rigid.lead::<D>(values));
    }

    /// Moves the followers of rigid bodies with their masters, in displacements `u` and positions `q`.
    pub fn lead_positions(&self, u: &mut [f64], q: &mut [f64]) {
        for rigid in self.bodies.iter().filter_map(|body| body.rigid.as_ref()) {
            rigid.lead::<D>(u);
            for node in rigid.followers() {
                (node * D..(node + 1) * D).for_each(|k| q[k] = self.nodes.reference[k] + u[k]);
            }
        }
    }

    /// Moves the followers of rigid bodies with their masters, in the displacements and positions at the end of a converged step.
    pub fn lead_end(&self, at: &mut Linearization) {
        self.lead(&mut at.moved);
        self.lead_positions(&mut at.u_1, &mut at.q_1);
    }

    /// True if some bodies are rigid.
    pub fn has_rigid_bodies(&self) -> bool {
        self.pairs.iter().any(|pair| pair.kind == PairKind::Rigidity)
    }

    /// True for models of rigid bodies and joints without contact.
    pub fn is_mechanism(&self) -> bool {
        self.has_rigid_bodies() && self.smallest_facet().is_infinite()
    }

    /// Smallest facet length of all contacts `[length]`; infinite without contacts.
    pub fn smallest_facet(&self) -> f64 {
        let contacts = self.pairs.iter().filter(|pair| !pair.kind.is_of_points());
        contacts.map(|pair| pair.kernel.facet_size()).fold(f64::INFINITY, f64::min)
    }

    /// Number of secondary nodes in contact: active constraints without those of ties.
    pub fn touching(&self, active: &[RowState]) -> usize {
        self.closed_nodes(active).iter().zip(&self.pairs).filter(|(_, pair)| pair.kind != PairKind::Tie).map(|(closed, _)| closed).sum()
    }

    /// Number of nodes with active constraints in each contact, in the order of the model.
    pub fn closed_nodes(&self, active: &[RowState]) -> Vec<usize> {
        let held_by = |pair: &ContactPair| -> Vec<u32> {
            let stride = pair.kernel.rows_per_node();
            let rows = active[pair.rows.clone()].chunks_exact(stride).enumerate().filter(|(_, rows)| rows.contains(&RowState::Closed));
            // Corners of obstacles have no nodes: they are numbered by their constraints, downwards from the largest number.
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

    /// Index of the contact of a pair: the pair itself, or the contact for whose corners it has constraints.
    pub fn contact_of(&self, index: usize) -> usize {
        self.pairs[index].corners.map_or(index, |corners| corners.pair)
    }

    /// Sums of a quantity of pairs over each contact, corner pairs included.
    pub fn by_contact(&self, of: impl Fn(usize, &ContactPair) -> f64) -> Vec<f64> {
        let mut sums = vec![0.0; self.contacts().count()];
        let pairs = self.pairs.iter().enumerate().filter(|(_, pair)| !pair.kind.is_of_points());
        pairs.for_each(|(index, pair)| sums[self.contact_of(index)] += of(index, pair));
        sums
    }

    /// Pairs that are contacts of the model, with their indices.
    pub fn contacts(&self) -> impl Iterator<Item = (usize, &ContactPair)> {
        self.pairs.iter().enumerate().filter(|(_, pair)| pair.corners.is_none() && !pair.kind.is_of_points())
    }

    /// Corner pairs that belong to the contact with this index.
    pub fn corners_of(&self, index: usize) -> impl Iterator<Item = &ContactPair> {
        self.pairs.iter().filter(move |pair| pair.corners.is_some_and(|corners| corners.pair == index))
    }

    /// Contact pair of a normal or tangential constraint.
    pub fn pair_of(&self, row: usize) -> Option<&ContactPair> {
        let is_own =
            |pair: &&ContactPair| pair.rows.contains(&row) || pair.friction.as_ref().is_some_and(|friction| friction.rows.contains(&row));
        self.pairs.iter().find(is_own)
    }

    /// Normal constraint of a tangential constraint.
    pub fn pressing_row(&self, slip: usize) -> usize {
        self.tangential_at(slip, |pair, friction| pair.rows.start + friction.normal_row(slip))
            .expect("every tangential row belongs to a pair")
    }

    /// Constraints that change their state together: a single normal one, or all tangential ones of one normal constraint.
    pub fn group_of(&self, row: usize) -> Range<usize> {
        self.tangential_at(row, |_, friction| friction.group(friction.normal_row(row))).unwrap_or(row..row + 1)
    }

    /// Other tangential constraints of the group of `slip`, from the next one on and around.
    pub fn partner_rows(&self, slip: usize) -> impl Iterator<Item = usize> + use<D> {
        self.tangential_at(slip, |_, friction| friction.others(slip)).into_iter().flatten()
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

    /// Adds the loads at a configuration and time, without gravity; returns true if a load acts.
    ///
    /// # Errors
    /// A time function failed.
    pub fn loads_into(&self, q: &[f64], time: f64, force: &mut [f64]) -> Result<bool, StepError> {
        loads_into::<D>(&self.loads, q, time, force)
    }

    /// Energy of the penalty potentials at the given weighted gaps `[energy]`.
    pub fn penalty_energy(&self, gaps: &[f64]) -> f64 {
        let of = |pair: &ContactPair| {
            pair.penalties.iter().zip(&gaps[pair.rows.clone()]).map(|(&kappa, &gap)| pair.law.energy(kappa, gap)).sum::<f64>()
        };
        self.pairs.iter().map(of).sum()
    }

    /// Checks that the contact elements fit into memory: the element of a coarse facet against `n` fine facets grows with `n^2`.
    pub(super) fn ensure_patches(&self) -> Result<(), Shortage> {
        memory::ensure(self.pairs.iter().map(|pair| pair.kernel.bytes()).fold(0, u64::saturating_add))
    }

    /// Chooses the contact kernels' discrete gradient.
    pub fn set_correction(&mut self, correction: Correction) {
        self.pairs.iter_mut().for_each(|pair| pair.kernel.set(Setting::Correction(correction)));
    }

    /// Moves the rigid obstacles to their positions in a step of size `dt` from `time`.
    ///
    /// # Errors
    /// A time function failed.
    pub fn move_obstacles(&mut self, time: f64, dt: f64) -> Result<(), StepError> {
        self.pairs.iter_mut().try_for_each(|pair| pair.move_obstacle(time, dt))
    }

    /// Moves the points of rigid obstacles to which nodes stick, by the obstacles' motion between two times.
    ///
    /// # Errors
    /// A time function failed.
    pub fn carry(&mut self, from: f64, to: f64) -> Result<(), StepError> {
        self.pairs.iter_mut().try_for_each(|pair| pair.carry(from, to))
    }

    /// Largest displacement of an obstacle between two times at its contact partner at the positions `q`, relative to the shortest facet of
    /// that partner.
    ///
    /// # Errors
    /// A time function failed.
    pub fn obstacle_motion(&self, from: f64, to: f64, q: &[f64]) -> Result<f64, StepError> {
        let mut largest = 0.0f64;
        for pair in &self.pairs {
            largest = largest.max(pair.obstacle_travel(from, to, q)? / pair.kernel.facet_size());
        }
        Ok(largest)
    }

    /// Finds the matrix positions of all contributions in a new pattern.
    pub(super) fn place(&mut self, pattern: &Pattern) {
        let nodes = self.nodes.count();
        self.bodies.iter_mut().for_each(|body| body.place(pattern));
        self.loads.iter_mut().for_each(|load| load.place(pattern));
        self.others.iter_mut().for_each(|part| part.place(pattern));
        self.dampings.iter_mut().for_each(|damping| damping.place(pattern));
        self.point_masses.iter_mut().for_each(|point| point.place = pattern.block(point.node, point.node));
        self.pairs.iter_mut().for_each(|pair| pair.place(pattern, nodes));
    }
}
