//! Fields of the bodies and quantities of the contacts at the present state.

use super::contact_quantities::{Loaded, contact_fields, contact_forces, totals};
use super::engine::Engine;
use super::fields::{BodyFields, BodyTotals, ContactFields, ContactSurface, PlacedObstacle};
use super::ledger::{ContactTotals, ProbeValues, Reaction};
use crate::bodies::{Elements, Projected, Space, StressError};
use crate::contact::Evaluation;
use crate::dynamics::model::interactions::Partner;
use crate::dynamics::parts::body::Body;
use crate::dynamics::parts::contact_pair::{ContactPair, PairKind, RowState};
use crate::dynamics::parts::nodal::{add_force, add_moment, half_product};
use crate::dynamics::step::system::System;

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    pub fn fields_at(&self, u: &[f64]) -> Vec<BodyFields> {
        let q = &self.system.nodes.positions(u)[..];
        let v = &self.state.velocities;
        let nodes = self.system.nodes.count();
        let (stress, strain) = self.stresses_at(u);
        let mut error = StressError::new(nodes);
        self.system.bodies.iter().for_each(|body| body.elements.stress_error(u, &stress, &mut error));
        let (mut pressure, mut gap) = (vec![0.0; nodes], vec![f64::NAN; nodes]);
        let (mut contact_force, mut contact_active) = (vec![[0.0; 3]; nodes], vec![0.0; nodes]);
        let evaluations = self.system.evaluations_at(q, &self.state.lambda);
        for (index, pair) in self.system.contacts().filter(|(_, pair)| pair.kind != PairKind::Tie) {
            let (contact, corners) = self.loaded(index, &evaluations);
            for (node, force) in contact_forces::<D>(contact, &corners, q).all {
                (0..3).for_each(|i| contact_force[node as usize][i] += force[i]);
            }
            let fields = contact_fields::<D>(contact, &corners, q);
            for (local, &node) in pair.kernel.secondary().nodes().iter().enumerate() {
                let node = node as usize;
                pressure[node] += fields.pressure[local];
                if fields.active[local] {
                    contact_active[node] = 1.0;
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
            .map(|(body, definition)| BodyFields {
                name: body.name.clone(),
                mesh: definition.mesh.clone(),
                displacement: body.nodes.clone().map(|node| vector(u, node)).collect(),
                velocity: body.nodes.clone().map(|node| vector(v, node)).collect(),
                stress: stress[body.nodes.clone()].to_vec(),
                strain: strain[body.nodes.clone()].to_vec(),
                stress_error: body.nodes.clone().map(|node| error.at(node)).collect(),
                contact_pressure: pressure[body.nodes.clone()].to_vec(),
                contact_gap: gap[body.nodes.clone()].to_vec(),
                contact_force: contact_force[body.nodes.clone()].to_vec(),
                contact_active: contact_active[body.nodes.clone()].to_vec(),
            })
            .collect()
    }

    /// Stress and strain at all nodes.
    fn stresses_at(&self, u: &[f64]) -> (Vec<[f64; 6]>, Vec<[f64; 6]>) {
        let mut sums = Projected::new(self.system.nodes.count());
        self.system.bodies.iter().for_each(|body| body.elements.project(u, &mut sums));
        let mean = |(sum, weight): (&[f64; 6], &f64)| sum.map(|value| value / weight);
        (sums.stress.iter().zip(&sums.weight).map(mean).collect(), sums.strain.iter().zip(&sums.weight).map(mean).collect())
    }

    /// Estimated errors of the stresses of all bodies over the size of the stresses.
    pub fn estimated_errors(&self) -> Vec<f64> {
        let u = &self.state.displacements;
        let (stress, _) = self.stresses_at(u);
        let of = |body: &Body<D>| {
            let mut error = StressError::new(self.system.nodes.count());
            body.elements.stress_error(u, &stress, &mut error);
            error.relative()
        };
        self.system.bodies.iter().map(of).collect()
    }

    /// One body as a whole.
    pub fn body_totals(&self, body: usize) -> BodyTotals {
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
            stress_error: self.estimated_errors()[body],
            kinetic: half_product(v, momenta),
            strain: elements.strain_energy(&state.displacements),
            potential: -q.iter().zip(&system.nodes.weight[range]).map(|(q, weight)| q * weight).sum::<f64>(),
            momentum: system.nodes.resultant(momenta),
            angular_momentum: system.nodes.moment(q, momenta),
            center,
        }
    }

    /// Every rigid obstacle where it is; one that several contacts have in common is one.
    pub fn placed_obstacles(&self) -> Vec<PlacedObstacle> {
        let mut placed: Vec<PlacedObstacle> = Vec::new();
        for interaction in &self.model.interactions {
            let Partner::Obstacle { shape, .. } = &interaction.partner else { continue };
            let pair = self.system.pairs.iter().find(|pair| pair.kind == PairKind::Obstacle && pair.name == interaction.name);
            let translation = pair.map_or([0.0; 2], |pair| pair.kernel.obstacle_translation());
            match placed.iter_mut().find(|other| other.shape == *shape && other.translation == translation) {
                Some(same) => same.name = format!("{}, {}", same.name, interaction.name),
                None => placed.push(PlacedObstacle { name: interaction.name.clone(), shape: shape.clone(), translation }),
            }
        }
        placed
    }

    pub fn contact_fields(&self, name: &str) -> Option<ContactFields> {
        let (index, _) = self.system.contacts().find(|(_, pair)| pair.name == name)?;
        let evaluations = self.system.evaluations_at(&self.state.positions, &self.state.lambda);
        let (contact, corners) = self.loaded(index, &evaluations);
        let order = contact.pair.kernel.secondary().along();
        Some(contact_fields::<D>(contact, &corners, &self.state.positions).in_order(&order))
    }

    /// The secondary surfaces of all contacts but ties, in the order of the model.
    pub fn contact_surfaces(&self) -> Vec<ContactSurface> {
        let evaluations = self.system.evaluations_at(&self.state.positions, &self.state.lambda);
        let reference = &self.system.nodes.reference;
        let place = |node: u32| {
            let node = node as usize;
            let body = self.system.bodies.iter().position(|body| body.nodes.contains(&node)).unwrap_or(0);
            (body, node - self.system.bodies[body].nodes.start)
        };
        let of = |(index, pair): (usize, &ContactPair)| {
            let (contact, corners) = self.loaded(index, &evaluations);
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
                facets: surface.local_facets().iter().map(|facet| facet.map(|local| rank[local as usize])).collect(),
                fields: contact_fields::<D>(contact, &corners, &self.state.positions).in_order(&order),
            }
        };
        self.system.contacts().filter(|(_, pair)| pair.kind != PairKind::Tie).map(of).collect()
    }

    /// A contact and its corners with evaluations of all pairs, in the present state.
    fn loaded<'a>(&'a self, index: usize, evaluations: &'a [Evaluation]) -> (Loaded<'a>, Vec<Loaded<'a>>) {
        loaded(&self.system, index, evaluations, &self.state.lambda, &self.state.active)
    }

    /// Sums over each contact at `q` with what all pairs are there.
    pub fn contact_totals(&self, q: &[f64], evaluations: &[Evaluation], lambda: &[f64], active: &[RowState]) -> Vec<ContactTotals> {
        let of = |(index, _): (usize, &ContactPair)| {
            let (contact, corners) = loaded(&self.system, index, evaluations, lambda, active);
            totals::<D>(contact, &corners, q)
        };
        self.system.contacts().map(of).collect()
    }

    /// What the supports of each boundary exert, `reaction` the force on a component that is held and `q` where moments are taken.
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

    /// Displacement and velocity of the watched nodes.
    pub fn probe_values(&self, u: &[f64], v: &[f64]) -> Vec<ProbeValues> {
        let values = |&node: &usize| {
            let mut values = ProbeValues::default();
            for i in 0..D {
                values.displacement[i] = u[node * D + i];
                values.velocity[i] = v[node * D + i];
            }
            values
        };
        self.probes.iter().map(values).collect()
    }
}

/// A contact and its corners with their evaluations and multipliers.
fn loaded<'a, const D: usize>(
    system: &'a System<D>,
    index: usize,
    evaluations: &'a [Evaluation],
    lambda: &'a [f64],
    active: &'a [RowState],
) -> (Loaded<'a>, Vec<Loaded<'a>>) {
    let of = |k: usize| {
        let pair = &system.pairs[k];
        Loaded { pair, evaluation: &evaluations[k], lambda: &lambda[pair.rows.clone()], active: &active[pair.rows.clone()] }
    };
    let corners = (0..system.pairs.len()).filter(|&k| system.pairs[k].corners.is_some_and(|corners| corners.pair == index));
    (of(index), corners.map(of).collect())
}
