//! The nodes of all bodies: reference positions, masses, connected components, and scales for error measures.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use super::body::Body;
use super::nodal::{half_product, moment, resultant};
use crate::dynamics::model::definitions::Model;
use crate::linear::NodeMatrix;
use crate::math::norms::largest_size;

/// Nodes of a model, body by body.
pub struct Nodes<const D: usize> {
    /// Reference positions.
    pub reference: Vec<f64>,
    /// Mass matrix: consistent, or lumped at the nodes.
    pub mass: NodeMatrix,
    /// Mass of every node (row sums); zero or negative at the corners of cells of second order.
    pub nodal_mass: Vec<f64>,
    /// Lumped mass for estimates of the motion of single nodes: positive, at least the diagonal of the mass matrix.
    pub lumped_mass: Vec<f64>,
    /// Largest nodal mass.
    pub largest_nodal_mass: f64,
    /// Mass of all bodies.
    pub total_mass: f64,
    /// Force of gravity.
    pub weight: Vec<f64>,
    /// Largest uniaxial-strain modulus, for the round-off limit of forces.
    pub modulus: f64,
    /// Largest extent of the model `[length]`.
    pub extent: f64,
    /// Number of the connected component that each node belongs to.
    pub component_of: Vec<u32>,
    /// True if the bodies are axisymmetric.
    pub is_axisymmetric: bool,
    /// True for each connected component without supports.
    pub component_is_free: Vec<bool>,
}

impl<const D: usize> Nodes<D> {
    /// Nodes of a model's bodies at rest at `reference`. `fixed` marks fixed unknowns, including those of `followers` of rigid bodies.
    pub fn new(
        model: &Model,
        bodies: &[Body<D>],
        reference: Vec<f64>,
        (fixed, followers): (&[bool], &BTreeSet<u32>),
        mass: NodeMatrix,
    ) -> Self {
        let count = reference.len() / D;
        let rigid = bodies.iter().filter_map(|body| body.rigid.as_ref()).map(|rigid| &rigid.nodes);
        let (component_of, number) = connected_components(count, bodies.iter().flat_map(|body| body.elements.cliques()).chain(rigid));
        let mut component_is_free = vec![true; number];
        // Bodies of revolution only move along their axis, the second direction.
        let is_rigid_motion = |unknown: usize| !model.is_axisymmetric() || unknown % D == 1;
        let is_held = |unknown: usize| fixed[unknown] && is_rigid_motion(unknown) && !followers.contains(&((unknown / D) as u32));
        for unknown in (0..fixed.len()).filter(|&unknown| is_held(unknown)) {
            component_is_free[component_of[unknown / D] as usize] = false;
        }
        let along = |i: usize| {
            let coordinates = || reference.iter().skip(i).step_by(D).copied();
            coordinates().fold(f64::NEG_INFINITY, f64::max) - coordinates().fold(f64::INFINITY, f64::min)
        };
        let nodal_mass = mass.row_sums();
        let mut lumped_mass = nodal_mass.clone();
        for (row, _, diagonal) in mass.entries().filter(|(row, column, _)| row == column) {
            lumped_mass[row as usize] = lumped_mass[row as usize].max(diagonal);
        }
        let is_constant = model.gravity_amplitude.is_none();
        let deformable = model.bodies.iter().filter(|body| body.rigid.is_none());
        let stiffest = deformable.map(|body| body.material.stiffness()).fold(0.0, f64::max);
        Nodes {
            mass,
            largest_nodal_mass: largest_size(&nodal_mass),
            total_mass: nodal_mass.iter().sum(),
            weight: (0..reference.len()).map(|k| if is_constant { nodal_mass[k / D] * model.gravity[k % D] } else { 0.0 }).collect(),
            nodal_mass,
            lumped_mass,
            modulus: if stiffest > 0.0 { stiffest } else { model.modulus(0) },
            extent: (0..D).map(along).fold(0.0, f64::max),
            component_of,
            is_axisymmetric: model.is_axisymmetric(),
            component_is_free,
            reference,
        }
    }

    /// Force per displacement of the whole model, for round-off limits; in axisymmetric models for the whole circumference
    /// `[force/length]`. Multiplied by a squared length it is an energy.
    pub fn stiffness(&self) -> f64 {
        let around = if self.is_axisymmetric { TAU * self.reference.iter().step_by(D).copied().fold(0.0, f64::max) } else { 1.0 };
        self.modulus * self.extent.powi(D as i32 - 2) * around
    }

    /// Positions of the nodes for the displacements `u`.
    pub fn positions(&self, u: &[f64]) -> Vec<f64> {
        let mut q = Vec::new();
        self.positions_into(u, &mut q);
        q
    }

    /// Writes the positions for the displacements `u` to `q`.
    pub fn positions_into(&self, u: &[f64], q: &mut Vec<f64>) {
        q.clear();
        q.extend(self.reference.iter().zip(u).map(|(x, u)| x + u));
    }

    /// Number of nodes.
    pub fn count(&self) -> usize {
        self.reference.len() / D
    }

    /// Nodal momenta `M v`.
    pub fn momenta_of(&self, v: &[f64]) -> Vec<f64> {
        let mut momenta = vec![0.0; v.len()];
        self.mass.multiply_into::<D>(v, &mut momenta);
        momenta
    }

    /// Kinetic energy `[energy]`.
    pub fn kinetic_energy(&self, v: &[f64]) -> f64 {
        half_product(v, &self.momenta_of(v))
    }

    /// Potential energy of gravity `[energy]`, zero at the origin.
    pub fn potential_energy(&self, q: &[f64]) -> f64 {
        -q.iter().zip(&self.weight).map(|(q, w)| q * w).sum::<f64>()
    }

    /// Sum of nodal vectors (linear momentum, resultant force); in axisymmetric models the axial component, as the others cancel.
    pub fn resultant(&self, vectors: &[f64]) -> [f64; 3] {
        let sum = resultant::<D>(vectors);
        if self.is_axisymmetric { [0.0, sum[1], 0.0] } else { sum }
    }

    /// Moment of nodal vectors about the origin; zero in axisymmetric models.
    pub fn moment(&self, q: &[f64], vectors: &[f64]) -> [f64; 3] {
        if self.is_axisymmetric { [0.0; 3] } else { moment::<D>(q, vectors) }
    }

    /// Linear and angular momentum about the origin.
    pub fn momenta(&self, q: &[f64], v: &[f64]) -> ([f64; 3], [f64; 3]) {
        let momenta = self.momenta_of(v);
        (self.resultant(&momenta), self.moment(q, &momenta))
    }
}

/// Connected components of nodes: the component of each node, and the number of components.
fn connected_components<'a>(nodes: usize, cliques: impl Iterator<Item = &'a Vec<u32>>) -> (Vec<u32>, usize) {
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
