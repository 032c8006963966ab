//! What the loop over a body's cells owes the equations: internal force, exact tangent, strain energy, stresses and mass.
//!
//! A [`Step`] says how the strain energy is differentiated; how that is done stands in `cells.rs`.

use crate::integrators::Derivative;
use crate::linear::{NodeMatrix, Pattern};
use crate::math::workers::Workers;

/// A cell that is inside out in the deformed configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inverted {
    /// Cell number in its mesh.
    pub cell: usize,
    /// Smallest determinant of the deformation gradient at its quadrature points.
    pub determinant: f64,
}

/// A step as the element loop sees it. Displacements are flat, node after node, of the whole model: strains have the accuracy of their
/// own size, however small they are.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    /// How the strain energy is differentiated.
    pub derivative: Derivative,
    /// Factor of the force.
    pub weight: f64,
    /// Factor of the mass in the tangent.
    pub inertia: f64,
    /// Displacements at the start.
    pub u_0: &'a [f64],
    /// Displacements at the end.
    pub u_1: &'a [f64],
}

/// The cells of a body in `D` dimensions. Displacements and forces are flat, node after node, of the whole model.
pub trait ElementLoop<const D: usize>: Send + Sync {
    /// Node numbers (in the model) of the cells, one clique each.
    fn cliques(&self) -> &[Vec<u32>];

    /// Finds where each cell's blocks stand in a matrix.
    fn place(&mut self, pattern: &Pattern);

    /// Adds the consistent mass.
    fn add_mass(&self, mass: &mut NodeMatrix);

    /// Sets the internal force of a step on the nodes of the cells, and in their columns of the matrix its derivative with respect to `u_1`
    /// with the weighted mass; these columns are zero elsewhere. Without `values` only the force, to the same bytes.
    ///
    /// # Errors
    /// A cell that is inside out at `u_1`, the same one for any number of threads; forces and values are then of no use.
    fn assemble(&self, step: &Step, force: &mut [f64], values: Option<&mut [f64]>, workers: &Workers) -> Result<(), Inverted>;

    /// Adds the mass and `factor` times the material stiffness `int B^T D B dV` at `u`, the tangent of the static forces without its
    /// geometric part.
    fn add_material_stiffness(&self, u: &[f64], factor: f64, values: &mut [f64]);

    /// Strain energy `[energy]`.
    fn strain_energy(&self, u: &[f64]) -> f64;

    /// Smallest determinant of the deformation gradient, and its cell.
    fn smallest_determinant(&self, u: &[f64]) -> Inverted;

    /// Adds stress and strain at the nodes, extrapolated from the quadrature points of each cell, to sums over the cells at a node by their
    /// volumes (Hinton and Campbell, International Journal for Numerical Methods in Engineering 8, 1974).
    fn project(&self, u: &[f64], sums: &mut Projected);

    /// Adds how far the stresses of the cells are from a continuous one, which has these values at the nodes (Zienkiewicz and Zhu,
    /// International Journal for Numerical Methods in Engineering 24, 1987).
    fn stress_error(&self, u: &[f64], continuous: &[[f64; 6]], error: &mut StressError);
}

/// How far stresses of cells are from a continuous stress, squares over volumes.
pub struct StressError {
    /// Of all cells `[stress^2 volume]`.
    pub off: f64,
    /// The same of the continuous stress itself.
    pub size: f64,
    /// Of the cells at each node, and their volumes.
    pub at_nodes: Vec<f64>,
    /// Volume of the cells at each node.
    pub weight: Vec<f64>,
}

impl StressError {
    /// Nothing at so many nodes yet.
    pub fn new(nodes: usize) -> Self {
        StressError { off: 0.0, size: 0.0, at_nodes: vec![0.0; nodes], weight: vec![0.0; nodes] }
    }

    /// All of it over the size of the stress; 0 where there is no stress.
    pub fn relative(&self) -> f64 {
        if self.size > 0.0 { (self.off / self.size).sqrt() } else { 0.0 }
    }

    /// Root mean square over the cells at a node `[stress]`.
    pub fn at(&self, node: usize) -> f64 {
        if self.weight[node] > 0.0 { (self.at_nodes[node] / self.weight[node]).sqrt() } else { 0.0 }
    }
}

/// Values of cells as they are summed up at their nodes, components xx, yy, zz, xy, yz, xz.
pub struct Projected {
    /// Cauchy stress times weight, for each node.
    pub stress: Vec<[f64; 6]>,
    /// Green-Lagrange strain times weight.
    pub strain: Vec<[f64; 6]>,
    /// Volume of the cells at each node.
    pub weight: Vec<f64>,
}

impl Projected {
    /// Nothing at so many nodes yet.
    pub fn new(nodes: usize) -> Self {
        Projected { stress: vec![[0.0; 6]; nodes], strain: vec![[0.0; 6]; nodes], weight: vec![0.0; nodes] }
    }
}
