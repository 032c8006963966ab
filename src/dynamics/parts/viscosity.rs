//! The viscous stress of a body, a part beside the element loop.
//!
//! Its stress is symmetric and acts on the body in the middle of a step, so momenta are kept; its work on the step's strain, which
//! `B(q_mid) (q_1 - q_0)` is exactly, is what its branches store and what is dissipated (formulas: [`crate::materials::Viscosity`]). At
//! rest, in `settle`, everything has relaxed.

use nalgebra::SMatrix;

use crate::dynamics::model::definitions::BodyDefinition;
use crate::dynamics::model::part::{Iterate, Part, Refusal, Remembered, Sums};
use crate::integrators::Configuration;
use crate::linear::{Block, Pattern};
use crate::materials::Viscosity;

/// A quadrature point of a cell: volume, and the gradients of the shape functions.
struct Point {
    volume: f64,
    gradients: Vec<[f64; 3]>,
}

/// A viscous body in the numbering of the model.
pub struct ViscousBody {
    dimension: usize,
    viscosity: Viscosity,
    /// Nodes of the cells.
    cells: Vec<Vec<u32>>,
    /// Points of the cells, cell by cell.
    points: Vec<Vec<Point>>,
    /// Blocks of the cells, node pairs row by row.
    places: Vec<Vec<Block>>,
}

/// Derivatives of the position at a point.
type Matrix<const D: usize> = SMatrix<f64, D, D>;

/// What a point contributes to a step.
struct Contribution<const D: usize> {
    stress: Matrix<D>,
    /// `dS/dE_1 = a I_4 + b I (x) I`.
    moduli: [f64; 2],
    dissipated: f64,
    /// Strains of the branches at the end.
    remembered: Vec<Matrix<D>>,
}

impl ViscousBody {
    /// The viscous part of a body whose nodes are numbered from `first`; `None` for a body without viscosity.
    pub fn new(body: &BodyDefinition, first: usize) -> Option<Self> {
        let viscosity = body.material.viscosity().clone();
        if viscosity.is_none() {
            return None;
        }
        let (mesh, row) = (&body.mesh, body.mesh.kind.row());
        let points = mesh.cells().map(|cell| {
            let at = |(xi, weight): ([f64; 3], f64)| {
                let slopes = (row.gradients)(xi);
                let mut jacobian = nalgebra::Matrix3::identity();
                for i in 0..row.dimension {
                    for j in 0..row.dimension {
                        jacobian[(i, j)] = cell.iter().zip(&slopes).map(|(&node, slope)| mesh.points[node as usize][i] * slope[j]).sum();
                    }
                }
                // The mesh is sound, or the body's own loop has refused it.
                let inverse = jacobian.try_inverse().unwrap_or_else(nalgebra::Matrix3::identity);
                let gradient = |slope: &[f64; 3]| (inverse.transpose() * nalgebra::Vector3::from(*slope)).into();
                Point { volume: weight * jacobian.determinant(), gradients: slopes.iter().map(gradient).collect() }
            };
            (row.quadrature)().into_iter().map(at).collect()
        });
        let points = points.collect();
        let cells = mesh.cells().map(|cell| cell.iter().map(|&node| node + first as u32).collect()).collect();
        Some(ViscousBody { dimension: row.dimension, viscosity, cells, points, places: Vec::new() })
    }

    /// Components of a strain that are remembered.
    fn components(&self) -> usize {
        self.dimension * (self.dimension + 1) / 2
    }

    fn point_count(&self) -> usize {
        self.points.iter().map(Vec::len).sum()
    }

    /// Deformation gradient of a point at positions.
    fn deformation<const D: usize>(&self, cell: usize, point: &Point, q: &[f64]) -> Matrix<D> {
        let mut f = Matrix::<D>::zeros();
        let last = self.cells[cell].len() - 1;
        let origin = self.cells[cell][last] as usize * D;
        for (&node, gradient) in self.cells[cell].iter().zip(&point.gradients) {
            for i in 0..D {
                // Relative to one node: gradients sum to zero.
                let x = q[node as usize * D + i] - q[origin + i];
                (0..D).for_each(|j| f[(i, j)] += x * gradient[j]);
            }
        }
        f
    }

    /// What a point contributes to a step of size `dt`, whose strain changes by `change`, with the strains of its branches at the start.
    fn contribution<const D: usize>(&self, change: &Matrix<D>, before: &[Matrix<D>], dt: f64) -> Contribution<D> {
        let Viscosity { shear, bulk, branches } = &self.viscosity;
        let rate = change / dt;
        let mut stress = rate * (2.0 * shear) + Matrix::<D>::identity() * (bulk * rate.trace());
        let mut dissipated = dt * (2.0 * shear * rate.norm_squared() + bulk * rate.trace().powi(2));
        let (mut moduli, mut remembered) = ([2.0 * shear / dt, bulk / dt], Vec::with_capacity(branches.len()));
        for (branch, y_0) in branches.iter().zip(before) {
            let [left, comes] = branch.shares(dt);
            let y_1 = y_0 * left + change * comes;
            let middle = (y_0 + y_1) * 0.5;
            stress += middle * (2.0 * branch.shear_modulus);
            moduli[0] += branch.shear_modulus * comes;
            dissipated += 2.0 * branch.shear_modulus * dt / branch.relaxation_time * middle.norm_squared();
            remembered.push(y_1);
        }
        Contribution { stress, moduli, dissipated, remembered }
    }

    /// Calls `tell` for every point with its cell, its deformation gradients at start and end, and its strains that are remembered.
    fn for_each_point<const D: usize>(
        &self,
        at: &Iterate,
        memory: &[f64],
        mut tell: impl FnMut(usize, &Point, [Matrix<D>; 2], &[Matrix<D>]),
    ) {
        let (count, mut strains) = (self.viscosity.branches.len(), Vec::new());
        let mut blocks = memory.chunks_exact(self.components());
        for (cell, points) in self.points.iter().enumerate() {
            for point in points {
                strains.clear();
                strains.extend(blocks.by_ref().take(count).map(unpacked::<D>));
                let f = [at.q_0, at.q_1].map(|q| self.deformation::<D>(cell, point, q));
                tell(cell, point, f, &strains);
            }
        }
    }

    fn linearize_in<const D: usize>(&self, at: &Iterate, memory: &[f64], sums: &mut Sums) {
        let placement = at.derivative.placement();
        self.for_each_point::<D>(at, memory, |cell, point, [f_0, f_1], before| {
            let Contribution { stress, moduli: [a, b], .. } = self.contribution(&strain_change(&f_0, &f_1), before, at.dt);
            let test = if placement.test == Configuration::Middle { (f_0 + f_1) * 0.5 } else { f_1 };
            let (weight, nodes) = (point.volume * at.weight, &self.cells[cell]);
            let piola = test * stress * weight;
            let gradient = |a: usize| nalgebra::SVector::<f64, D>::from_fn(|i, _| point.gradients[a][i]);
            for (k, &node) in nodes.iter().enumerate() {
                let force = piola * gradient(k);
                (0..D).for_each(|i| sums.internal[node as usize * D + i] += force[i]);
            }
            let Some(values) = sums.tangent.as_deref_mut() else { return };
            let (across, weighted) = (test * f_1.transpose(), stress * weight);
            for k in 0..nodes.len() {
                let (g, left) = (gradient(k), test * gradient(k));
                for l in 0..nodes.len() {
                    let (h, right) = (gradient(l), f_1 * gradient(l));
                    // dE_1 = sym(F_1^T dx (x) G), so 2 (F_test dE_1 G) = F_test (F_1^T dx (G_l . G) + G_l (F_1 G . dx)).
                    let around = g.dot(&h);
                    let other = test * h;
                    let geometric = placement.share * g.dot(&(weighted * h));
                    let block = self.places[cell][k * nodes.len() + l];
                    let ahead = f_1 * g;
                    for i in 0..D {
                        for j in 0..D {
                            let slope = 0.5 * a * (across[(i, j)] * around + other[i] * ahead[j]) + b * left[i] * right[j];
                            values[block.at(i, j)] += weight * slope + if i == j { geometric } else { 0.0 };
                        }
                    }
                }
            }
        });
    }

    /// What is remembered and what has been dissipated at the end of a step.
    fn outcome<const D: usize>(&self, at: &Iterate, before: &[f64]) -> Remembered {
        let (mut memory, mut dissipated) = (Vec::with_capacity(before.len()), 0.0);
        self.for_each_point::<D>(at, before, |_, point, [f_0, f_1], before| {
            let end = self.contribution(&strain_change(&f_0, &f_1), before, at.dt);
            dissipated += point.volume * end.dissipated;
            end.remembered.iter().for_each(|strain| pack(strain, &mut memory));
        });
        Remembered { memory, dissipated }
    }
}

/// `E_1 - E_0 = sym(F_mid^T (F_1 - F_0))`, exactly, without the cancellation of the two strains.
fn strain_change<const D: usize>(f_0: &Matrix<D>, f_1: &Matrix<D>) -> Matrix<D> {
    let product = ((f_0 + f_1) * 0.5).transpose() * (f_1 - f_0);
    (product + product.transpose()) * 0.5
}

fn pack<const D: usize>(strain: &Matrix<D>, into: &mut Vec<f64>) {
    (0..D).for_each(|i| (i..D).for_each(|j| into.push(strain[(i, j)])));
}

fn unpacked<const D: usize>(components: &[f64]) -> Matrix<D> {
    let mut strain = Matrix::<D>::zeros();
    let mut next = components.iter();
    for i in 0..D {
        for j in i..D {
            let value = next.next().copied().unwrap_or_default();
            (strain[(i, j)], strain[(j, i)]) = (value, value);
        }
    }
    strain
}

impl Part for ViscousBody {
    fn for_each_coupling(&self, _tell: &mut dyn FnMut(&[u32])) {
        // The nodes of a cell are coupled by the body.
    }

    fn place(&mut self, pattern: &Pattern) {
        let blocks = |nodes: &Vec<u32>| nodes.iter().flat_map(|&a| nodes.iter().map(move |&b| pattern.block(a, b))).collect();
        self.places = self.cells.iter().map(blocks).collect();
    }

    fn linearize(&self, at: &Iterate, memory: &[f64], sums: &mut Sums) -> Result<(), Refusal> {
        match (at.dt > 0.0, self.dimension) {
            (false, _) => {}
            (true, 2) => self.linearize_in::<2>(at, memory, sums),
            (true, _) => self.linearize_in::<3>(at, memory, sums),
        }
        Ok(())
    }

    fn energy(&self, _q: &[f64], memory: &[f64]) -> f64 {
        let (count, size) = (self.viscosity.branches.len(), self.components());
        let volumes = self.points.iter().flatten().map(|point| point.volume);
        let stored = |strains: &[f64]| -> f64 {
            let branches = strains.chunks_exact(size).zip(&self.viscosity.branches);
            let square = |strain: &[f64]| {
                if self.dimension == 2 { unpacked::<2>(strain).norm_squared() } else { unpacked::<3>(strain).norm_squared() }
            };
            branches.map(|(strain, branch)| branch.shear_modulus * square(strain)).sum()
        };
        if count == 0 {
            0.0
        } else {
            volumes.zip(memory.chunks_exact(size * count)).map(|(volume, strains)| volume * stored(strains)).sum()
        }
    }

    fn memory(&self) -> Vec<f64> {
        vec![0.0; self.point_count() * self.viscosity.branches.len() * self.components()]
    }

    fn remembered(&self, at: &Iterate, memory: &[f64]) -> Remembered {
        match (at.dt > 0.0, self.dimension) {
            (false, _) => Remembered { memory: self.memory(), dissipated: 0.0 },
            (true, 2) => self.outcome::<2>(at, memory),
            (true, _) => self.outcome::<3>(at, memory),
        }
    }
}
