//! Interface of the element loop over a body's cells: internal force, exact tangent, strain energy, stresses and mass.
//!
//! A [`Step`] selects the algorithmic gradient of the strain energy. The implementation is in `cells.rs`.

use crate::integrators::{Derivative, Lumping};
use crate::linear::{NodeMatrix, Pattern};
use crate::materials::PointHistory;
use crate::math::workers::Workers;

/// Inverted cell in the deformed configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inverted {
    /// Cell number in its mesh.
    pub cell: usize,
    /// Smallest determinant of the deformation gradient at the cell's quadrature points.
    pub determinant: f64,
}

/// Cell with the largest eigenfrequency of all cells considered in isolation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FastestCell {
    /// Number of the cell in the mesh.
    pub cell: usize,
    /// Upper bound of the squared angular frequencies of the cell `[1/time^2]`.
    pub frequency_squared: f64,
}

/// Input of the element loop for a step. Displacements are flat, node after node, of the whole model, not positions, so that small strains
/// keep their relative accuracy.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    /// Algorithmic gradient of the strain energy: discrete gradient, or gradient at mid-step or at the end.
    pub derivative: Derivative,
    /// Factor of the force.
    pub weight: f64,
    /// Factor of the mass in the tangent.
    pub inertia: f64,
    /// Displacements at the start.
    pub u_0: &'a [f64],
    /// Displacements at the end.
    pub u_1: &'a [f64],
    /// History variables at the start ([`ElementLoop::history`]). With an empty slice, a law with history variables gives its elastic
    /// stiffness at rest.
    pub history: &'a [f64],
    /// Size of the step `[time]`, 0 at rest.
    pub dt: f64,
}

/// State of a body: displacements and history variables.
#[derive(Clone, Copy, Debug)]
pub struct BodyState<'a> {
    /// Displacements, flat, node after node, of the whole model.
    pub u: &'a [f64],
    /// History variables ([`ElementLoop::history`]).
    pub history: &'a [f64],
}

/// Results of an accepted step at the quadrature points of a body.
#[derive(Clone, Debug)]
pub struct Advance {
    /// History variables at the end.
    pub history: Vec<f64>,
    /// Heat of plastic flow in the step `[energy]`.
    pub plastic: f64,
    /// Heat of viscosity in the step `[energy]`.
    pub viscous: f64,
}

/// Stress and strain at a quadrature point.
#[derive(Clone, Copy, Debug)]
pub struct PointStress<'a> {
    /// Number of the cell in its mesh.
    pub cell: usize,
    /// The cell's nodes in the model.
    pub nodes: &'a [u32],
    /// Values of the cell's shape functions at the point.
    pub shapes: &'a [f64],
    /// Factors of this point's value in the extrapolation to each of the cell's nodes.
    pub extrapolation: &'a [f64],
    /// Undeformed volume of the point.
    pub volume: f64,
    /// Undeformed volume of the cell.
    pub cell_volume: f64,
    /// Cauchy stress xx, yy, zz, xy, yz, xz `[stress]`.
    pub stress: [f64; 6],
    /// Green-Lagrange strain xx, yy, zz, xy, yz, xz.
    pub strain: [f64; 6],
    /// Stored energy per undeformed volume, without that of relaxing (Maxwell) branches `[energy/volume]`.
    pub energy: f64,
    /// Plastic strain, heat and back stress; `None` for laws without history variables.
    pub kept: Option<PointHistory>,
}

/// Force per mass at a point, from the nodes of a cell and the values of its shape functions there `[length/time^2]`.
pub type ForcePerMass<'a> = dyn Fn(&[u32], &[f64]) -> [f64; 3] + 'a;

/// Element loop over the cells of a body in `D` dimensions. Displacements and forces are flat, node after node, of the whole model.
pub trait ElementLoop<const D: usize>: Send + Sync {
    /// Node numbers (in the model) of the cells, one clique each.
    fn cliques(&self) -> &[Vec<u32>];

    /// Finds the positions of each cell's blocks in a matrix.
    fn place(&mut self, pattern: &Pattern);

    /// Scales the stress-free lengths by a factor given at the nodes and interpolated in the cells (swelling, thermal expansion); masses
    /// are unchanged. Returns the least factor at a point.
    fn grow(&mut self, _factor: &dyn Fn(u32) -> f64) -> f64 {
        f64::INFINITY
    }

    /// Adds the consistent mass.
    fn add_mass(&self, mass: &mut NodeMatrix);

    /// Adds the lumped mass of the cells to the nodal masses; returns true if every node of every cell has a positive mass.
    fn add_lumped_mass(&self, lumping: Lumping, mass: &mut [f64]) -> bool;

    /// Cell with the highest frequency bound about displacements `u`, considered in isolation with lumped mass: an upper bound for the
    /// body.
    fn fastest_cell(&self, lumping: Lumping, u: &[f64]) -> FastestCell;

    /// Sets the internal force of a step on the nodes of the cells and, in their matrix columns, its derivative with respect to `u_1` plus
    /// the weighted mass; these columns are zero elsewhere. Without `values` only the force, with bitwise equal results.
    ///
    /// # Errors
    /// A cell that is inside out at `u_1`, the same one for any number of threads; forces and values are then undefined.
    fn assemble(&self, step: &Step, force: &mut [f64], values: Option<&mut [f64]>, workers: &Workers) -> Result<(), Inverted>;

    /// Adds the force and derivative that [`Self::assemble`] sets, for a configuration without inverted cells.
    fn add_step(&self, step: &Step, force: &mut [f64], values: Option<&mut [f64]>);

    /// Adds the mass and `factor` times the material stiffness `int B^T D B dV` at `u`, the tangent of the static forces without its
    /// geometric part.
    fn add_material_stiffness(&self, u: &[f64], factor: f64, values: &mut [f64]);

    /// Number of history variables of all quadrature points, which are 0 at rest; zero if stresses follow from displacements alone.
    fn history(&self) -> usize;

    /// History variables after full relaxation at constant displacements.
    fn relaxed(&self, at: BodyState) -> Vec<f64>;

    /// True if the body's material has plastic flow.
    fn flows(&self) -> bool;

    /// History variables at the end of a step, and its heat.
    fn advance(&self, step: &Step) -> Advance;

    /// Energy stored by strains and history variables, without that of relaxing (Maxwell) branches `[energy]`.
    fn strain_energy(&self, at: BodyState) -> f64;

    /// Energy stored in relaxing (Maxwell) branches `[energy]`.
    fn relaxing_energy(&self, history: &[f64]) -> f64;

    /// Cell with the smallest determinant of the deformation gradient, and the determinant.
    fn smallest_determinant(&self, u: &[f64]) -> Inverted;

    /// Visits stress and strain at all quadrature points, one cell after another within a batch.
    fn visit_stresses(&self, at: BodyState, visit: &mut dyn FnMut(&PointStress));

    /// Visits the forces of all cells: index of the cell, and force on each of its nodes in the order of [`Self::cliques`] `[force]`:
    /// internal force of its stress minus the force `field` on its mass, with the sign of the residual.
    fn visit_forces(&self, at: BodyState, field: &ForcePerMass, visit: &mut dyn FnMut(usize, &[[f64; 3]]));
}
