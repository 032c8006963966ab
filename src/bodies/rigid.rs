//! Rigid bodies: the motion of all nodes of a mesh follows from `D + 1` of them.
//!
//! An affine motion is determined by `D + 1` nodes in general position, the *masters*: `x(X) = sum_i a_i(X) x_i` with the barycentric
//! coordinates `a_i` of the point in the reference positions. With the positions of the masters as unknowns the mass matrix is constant,
//!
//! ```text
//! M_ij = int rho a_i a_j dV = m a_i(X_c) a_j(X_c) + grad a_i . E grad a_j          X_c center of mass, E Euler tensor about it
//! ```
//!
//! and the motion is rigid if the distances between masters are constant, which are quadratic constraints (rotationless formulation: Betsch
//! and Steinmann, IJNME 53, 2001; natural coordinates: de Jalon and Bayo 1994). Their gradients at mid-step are discrete gradients, so that
//! energy and momenta are exact for any choice of masters.

use std::ops::Range;

use nalgebra::{Matrix3, Vector3};

use super::element_loop::{Advance, BodyState, ElementLoop, FastestCell, ForcePerMass, Inverted, PointStress, Step};
use super::formulation::Formulation;
use super::kinds::{Elements, Space};
use super::physics::BodyCells;
use crate::integrators::Lumping;
use crate::linear::{Block, NodeMatrix, Pattern, Vertex};
use crate::materials::Material;
use crate::math::tolerances;
use crate::math::workers::Workers;
use crate::mesh::Mesh;

/// Mass of a rigid body, its center and its second moments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia {
    /// Mass, per thickness in the plane `[mass]`.
    pub mass: f64,
    /// Center of mass in the reference positions `[length]`.
    pub center: [f64; 3],
    /// Euler tensor `E = int rho (X - X_c) (X - X_c)^T dV` `[mass * length^2]`; in the plane its first two rows and columns. The tensor of
    /// inertia is `tr(E) I - E`.
    pub euler: [[f64; 3]; 3],
}

impl Inertia {
    /// Returns the inertia of a mesh with the density of a material.
    ///
    /// # Errors
    /// A cell that is inside out in the mesh.
    pub fn of_mesh(mesh: &Mesh, material: &Material, formulation: Formulation) -> Result<Self, Inverted> {
        if mesh.dimension() == 2 { of_cells::<2>(mesh, material, formulation) } else { of_cells::<3>(mesh, material, formulation) }
    }

    /// Returns the inertia from mass, center, and moments and products of inertia about the center, `int rho (|r|^2 I - r r^T) dV`.
    pub fn of_moments(mass: f64, center: [f64; 3], moments: [[f64; 3]; 3]) -> Self {
        let half_trace = 0.5 * (moments[0][0] + moments[1][1] + moments[2][2]);
        let entry = |i: usize, j: usize| if i == j { half_trace - moments[i][j] } else { -moments[i][j] };
        Inertia { mass, center, euler: std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))) }
    }

    /// Returns the inertia of a plane body from its mass, its center, and the moment of inertia about the center; plane rotations depend on
    /// the trace of the Euler tensor only.
    pub fn in_plane(mass: f64, center: [f64; 3], moment: f64) -> Self {
        let mut euler = [[0.0; 3]; 3];
        (euler[0][0], euler[1][1]) = (0.5 * moment, 0.5 * moment);
        Inertia { mass, center, euler }
    }

    /// Principal moments of inertia in ascending order `[mass * length^2]`; in the plane the last is that about the third axis.
    pub fn principal_moments(&self) -> [f64; 3] {
        let euler = Matrix3::from_fn(|i, j| self.euler[i][j]);
        let mut values = euler.symmetric_eigenvalues();
        let trace = values.sum();
        values.apply(|value| *value = trace - *value);
        let mut values: [f64; 3] = values.into();
        values.sort_by(f64::total_cmp);
        values
    }

    /// Second moments of the mass along its principal axes in ascending order `[mass * length^2]`; nonnegative for physical bodies.
    pub fn principal_spreads(&self) -> [f64; 3] {
        let mut values: [f64; 3] = Matrix3::from_fn(|i, j| self.euler[i][j]).symmetric_eigenvalues().into();
        values.sort_by(f64::total_cmp);
        values
    }
}

/// Inertia of a mesh from its consistent mass matrix, which integrates affine functions exactly.
fn of_cells<const D: usize>(mesh: &Mesh, material: &Material, formulation: Formulation) -> Result<Inertia, Inverted>
where
    Space<D>: Elements<D>,
{
    let elements = Space::<D>::elements(&BodyCells::new(mesh, material, formulation))?;
    let vertices = vec![Vertex::coordinates(D as u8); mesh.points.len()];
    let pattern = Pattern::new(&vertices, elements.cliques().iter().map(|clique| &clique[..]));
    let mut matrix = NodeMatrix::new(&pattern, mesh.points.len());
    elements.add_mass(&mut matrix);
    let point = |node: u32| Vector3::from(mesh.points[node as usize]);
    let (mut mass, mut first) = (0.0, Vector3::zeros());
    for (node, value) in (0..).zip(matrix.row_sums()) {
        mass += value;
        first += point(node) * value;
    }
    let center = first / mass;
    let mut euler = Matrix3::zeros();
    for (row, column, value) in matrix.entries() {
        euler += (point(row) - center) * (point(column) - center).transpose() * value;
    }
    Ok(Inertia { mass, center: center.into(), euler: std::array::from_fn(|i| std::array::from_fn(|j| euler[(i, j)])) })
}

/// Map from the masters of a rigid body to its points.
#[derive(Clone, Debug, PartialEq)]
pub struct BarycentricMap {
    /// Masters: `D + 1` nodes of the mesh.
    pub masters: Vec<u32>,
    /// Gradients of the barycentric coordinates of the masters in the reference positions `[1/length]`.
    gradients: Vec<Vector3<f64>>,
    /// Reference position of the first master `[length]`.
    origin: Vector3<f64>,
}

impl BarycentricMap {
    /// Returns the frame of a mesh, with masters as far from each other as possible; `None` if all nodes lie in one plane (plane bodies: on
    /// one line).
    pub fn new(mesh: &Mesh) -> Option<Self> {
        let dimension = mesh.dimension();
        let point = |node: usize| Vector3::from(mesh.points[node]);
        // Among equally far nodes the first is chosen; round-off of a translated mesh must not decide.
        let farthest = |size: &dyn Fn(usize) -> f64| {
            let largest = (0..mesh.points.len()).map(size).fold(0.0, f64::max);
            (0..mesh.points.len()).find(|&node| size(node) >= (1.0 - tolerances::EQUALLY_FAR) * largest)
        };
        let mean = mesh.points.iter().map(|&point| Vector3::from(point)).sum::<Vector3<f64>>() / mesh.points.len() as f64;
        let mut masters = vec![farthest(&|node| (point(node) - mean).norm())?];
        let mut directions: Vec<Vector3<f64>> = Vec::new();
        let origin = point(masters[0]);
        for _ in 0..dimension {
            let off =
                |node: usize| directions.iter().fold(point(node) - origin, |rest, direction| rest - *direction * direction.dot(&rest));
            let next = farthest(&|node| off(node).norm())?;
            let length = off(next).norm();
            if length <= FLAT * (origin - mean).norm() {
                return None;
            }
            directions.push(off(next) / length);
            masters.push(next);
        }
        let mut edges = Matrix3::identity();
        (0..dimension).for_each(|k| edges.set_row(k, &(point(masters[k + 1]) - origin).transpose()));
        let inverse = edges.try_inverse()?;
        let others: Vec<Vector3<f64>> = (0..dimension).map(|k| inverse.column(k).into()).collect();
        let first = -others.iter().sum::<Vector3<f64>>();
        let gradients = std::iter::once(first).chain(others).collect();
        Some(BarycentricMap { masters: masters.into_iter().map(|node| node as u32).collect(), gradients, origin })
    }

    /// Barycentric coordinates `a_i` of a point of the body, given its reference position; they sum to one.
    pub fn shares(&self, point: [f64; 3]) -> Vec<f64> {
        let arm = Vector3::from(point) - self.origin;
        let share = |(k, gradient): (usize, &Vector3<f64>)| gradient.dot(&arm) + if k == 0 { 1.0 } else { 0.0 };
        self.gradients.iter().enumerate().map(share).collect()
    }

    /// Factors of the masters in a vector fixed to the body, given its initial components: `grad a_i . v`; the factors sum to zero.
    pub fn direction(&self, vector: [f64; 3]) -> Vec<f64> {
        self.gradients.iter().map(|gradient| gradient.dot(&Vector3::from(vector))).collect()
    }

    /// The mass matrix between masters.
    pub fn masses(&self, inertia: &Inertia) -> Vec<Vec<f64>> {
        let (at_center, euler) = (self.shares(inertia.center), Matrix3::from_fn(|i, j| inertia.euler[i][j]));
        let entry = |i: usize, j: usize| inertia.mass * at_center[i] * at_center[j] + self.gradients[i].dot(&(euler * self.gradients[j]));
        let count = self.masters.len();
        (0..count).map(|i| (0..count).map(|j| entry(i.min(j), i.max(j))).collect()).collect()
    }
}

/// Distance from the plane (line, point) of the masters already chosen, relative to the mesh size, below which nodes count as coplanar.
const FLAT: f64 = tolerances::FLAT_FRAME;

/// Fraction of a rigid body's mass that is moved from its masters to the nodes tied to them, in equal parts.
const TIED_PART: f64 = 0.125;

/// A rigid body as an [`ElementLoop`]: it has mass, but no internal force.
pub struct RigidMass {
    /// Master nodes of the body in the numbering of the model, as one clique.
    cliques: Vec<Vec<u32>>,
    nodes: Range<usize>,
    masses: Vec<Vec<f64>>,
    /// Nodes tied to the masters, each with its part of the mass.
    tied: Vec<(u32, f64)>,
    /// Matrix blocks between masters, row by row.
    blocks: Vec<Block>,
    /// Matrix blocks of the tied nodes.
    tied_blocks: Vec<Block>,
    /// Matrix columns of all nodes.
    columns: Vec<Range<usize>>,
}

impl RigidMass {
    /// Mass of a rigid body at its masters; node numbers of the mesh start at `first_node` in the model.
    pub fn new(mesh: &Mesh, frame: &BarycentricMap, inertia: &Inertia, first_node: usize) -> Self {
        RigidMass {
            cliques: vec![frame.masters.iter().map(|node| node + first_node as u32).collect()],
            nodes: first_node..first_node + mesh.points.len(),
            masses: frame.masses(inertia),
            tied: Vec::new(),
            blocks: Vec::new(),
            tied_blocks: Vec::new(),
            columns: Vec::new(),
        }
    }

    /// Transfers part of the mass from the masters to the tied nodes, given with their coefficients of the masters: energy and momenta are
    /// unchanged while the ties hold, and the equations of the tied nodes get inertia.
    pub fn tied_to<'a>(mut self, tied: impl ExactSizeIterator<Item = &'a (u32, Vec<f64>)>) -> Self {
        let total: f64 = self.masses.iter().flatten().sum();
        let part = TIED_PART * total / tied.len() as f64;
        for (node, shares) in tied {
            for (row, of_row) in self.masses.iter_mut().zip(shares) {
                row.iter_mut().zip(shares).for_each(|(mass, share)| *mass -= part * of_row * share);
            }
            self.tied.push((*node, part));
        }
        self
    }

    fn add_inertia<const D: usize>(&self, factor: f64, values: &mut [f64]) {
        for (block, mass) in self.blocks.iter().zip(self.masses.iter().flatten()) {
            (0..D).for_each(|i| values[block.at(i, i)] += factor * mass);
        }
        for (block, (_, mass)) in self.tied_blocks.iter().zip(&self.tied) {
            (0..D).for_each(|i| values[block.at(i, i)] += factor * mass);
        }
    }
}

impl<const D: usize> ElementLoop<D> for RigidMass {
    fn cliques(&self) -> &[Vec<u32>] {
        &self.cliques
    }

    fn place(&mut self, pattern: &Pattern) {
        let masters = &self.cliques[0];
        self.blocks = masters.iter().flat_map(|&u| masters.iter().map(move |&v| pattern.block(u, v))).collect();
        self.tied_blocks = self.tied.iter().map(|&(node, _)| pattern.block(node, node)).collect();
        let column = |node: usize| {
            let neighbors = pattern.neighbors(node);
            let length: usize = neighbors.iter().map(|&other| pattern.size(other as usize)).sum();
            let start = pattern.block(neighbors[0], node as u32).at(0, 0);
            start..start + D * length
        };
        self.columns = self.nodes.clone().map(column).collect();
    }

    fn add_mass(&self, mass: &mut NodeMatrix) {
        let masters = &self.cliques[0];
        for (&u, row) in masters.iter().zip(&self.masses) {
            masters.iter().zip(row).for_each(|(&v, &value)| mass.add(u, v, value));
        }
        self.tied.iter().for_each(|&(node, value)| mass.add(node, node, value));
    }

    fn add_lumped_mass(&self, _lumping: Lumping, _mass: &mut [f64]) -> bool {
        false
    }

    fn fastest_cell(&self, _lumping: Lumping, _u: &[f64]) -> FastestCell {
        FastestCell { cell: 0, frequency_squared: 0.0 }
    }

    fn assemble(&self, step: &Step, force: &mut [f64], values: Option<&mut [f64]>, _workers: &Workers) -> Result<(), Inverted> {
        force[self.nodes.start * D..self.nodes.end * D].fill(0.0);
        if let Some(values) = values {
            self.columns.iter().for_each(|column| values[column.clone()].fill(0.0));
            self.add_inertia::<D>(step.inertia, values);
        }
        Ok(())
    }

    fn add_material_stiffness(&self, _u: &[f64], _factor: f64, values: &mut [f64]) {
        self.add_inertia::<D>(1.0, values);
    }

    fn add_step(&self, _step: &Step, _force: &mut [f64], _values: Option<&mut [f64]>) {}

    fn history(&self) -> usize {
        0
    }

    fn relaxed(&self, _at: BodyState) -> Vec<f64> {
        Vec::new()
    }

    fn flows(&self) -> bool {
        false
    }

    fn advance(&self, _step: &Step) -> Advance {
        Advance { history: Vec::new(), plastic: 0.0, viscous: 0.0 }
    }

    fn strain_energy(&self, _at: BodyState) -> f64 {
        0.0
    }

    fn relaxing_energy(&self, _history: &[f64]) -> f64 {
        0.0
    }

    fn smallest_determinant(&self, _u: &[f64]) -> Inverted {
        Inverted { cell: 0, determinant: 1.0 }
    }

    fn visit_stresses(&self, _at: BodyState, _visit: &mut dyn FnMut(&PointStress)) {}

    fn visit_forces(&self, _at: BodyState, _field: &ForcePerMass, _visit: &mut dyn FnMut(usize, &[[f64; 3]])) {}
}
