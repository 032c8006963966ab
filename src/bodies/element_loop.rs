//! The element loop: internal force, exact tangent, strain energy, stresses and mass of the cells of one body.
//!
//! Per point, with displacement gradient `H`, `F = I + H`, Green-Lagrange strain `E = (H + H^T + H^T H)/2` (relative accuracy at small
//! strain), algorithmic stress `S` and its derivative `T = dS/dE_1` from the integrator,
//!
//! ```text
//! force    f_a   = w F_test S G_a
//! tangent  K_ab  = w G_a . A . G_b,   A_iJkL = (F_test)_iM T_MJNL (F_trial)_kN + share S_JL delta_ik
//! ```
//!
//! (method: Simo and Tarnow, ZAMP 43, 1992; Gonzalez 2000). The gradients of the shape functions sum to zero, so the blocks of the last
//! node follow from the others. Lanes run over elements; what is left over in the last batch repeats its first element and is not
//! scattered.

use std::sync::Arc;

use crate::elements::{CellKind, Hex8, Quad4, ReferenceCell};
use crate::integrators::{Configuration, Integrator, discrete_gradient};
use crate::linear::{Block, NodeMatrix, Pattern};
use crate::materials::{Batch as Law, Material, Strain};
use crate::math::lanes::{Lanes, Real, WIDTH, relabel, relabel_rows};
use crate::math::simd::{Kernel, dispatch};
use crate::math::tensor::{mandel_index, mandel_scale};
use crate::math::tolerances::STRAIN_INCREMENT_SQUARED;
use crate::math::workers::Workers;
use crate::mesh::Mesh;

/// A cell that is inside out in the deformed configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inverted {
    /// Cell number in its mesh.
    pub cell: usize,
    /// Smallest determinant of the deformation gradient at its quadrature points.
    pub determinant: f64,
}

/// The cells of a body in `D` dimensions. Positions, forces and velocities are flat, node after node, of the whole model.
pub trait ElementLoop<const D: usize>: Send + Sync {
    /// Node numbers (in the model) of the cells, one clique each.
    fn cliques(&self) -> &[Vec<u32>];

    /// Finds where each cell's blocks stand in a matrix.
    fn place(&mut self, pattern: &Pattern);

    /// Adds the consistent mass.
    fn add_mass(&self, mass: &mut NodeMatrix);

    /// Keeps deformation gradients and strains of the start of a step.
    fn begin_step(&mut self, q_0: &[f64]);

    /// Adds the internal force of a step that ends at `q_1`, and its derivative with respect to `q_1` to the placed blocks.
    ///
    /// # Errors
    /// The first cell that is inside out where the law is evaluated; forces and values are then of no use.
    fn assemble(
        &self,
        integrator: Integrator,
        q_1: &[f64],
        force: &mut [f64],
        values: &mut [f64],
        workers: &Workers,
    ) -> Result<(), Inverted>;

    /// Adds the material stiffness `int B^T D B dV` at `q`, the tangent of the static forces without its geometric part.
    fn add_material_stiffness(&self, q: &[f64], values: &mut [f64]);

    /// Strain energy `[energy]`.
    fn strain_energy(&self, q: &[f64]) -> f64;

    /// Smallest determinant of the deformation gradient, and its cell.
    fn smallest_determinant(&self, q: &[f64]) -> Inverted;

    /// Adds `weight * stress` and `weight` at the nodes, for a lumped projection of the Cauchy stress (xx yy zz xy yz xz).
    fn project_stress(&self, q: &[f64], stress: &mut [[f64; 6]], weight: &mut [f64]);
}

/// Eight cells.
#[derive(Clone)]
struct Batch<const D: usize, const A: usize, const Q: usize> {
    nodes: [[u32; WIDTH]; A],
    count: usize,
    gradients: [[[Lanes<false>; D]; A]; Q],
    weights: [Lanes<false>; Q],
}

/// Displacement gradients and strains of a batch at the points.
#[derive(Clone, Copy)]
struct Deformation<const D: usize, const S: usize, const Q: usize> {
    gradient: [[[Lanes<false>; D]; D]; Q],
    strain: [Strain<S>; Q],
}

/// Force and tangent of a batch, `tangent[a][b][i][k]`.
#[derive(Clone, Copy)]
struct Contribution<const D: usize, const A: usize> {
    force: [[Lanes<false>; D]; A],
    tangent: [[[[Lanes<false>; D]; D]; A]; A],
}

struct Cells<C, const D: usize, const S: usize, const A: usize, const Q: usize> {
    law: Arc<dyn Law<S>>,
    spatial_law: Arc<dyn Law<6>>,
    density: f64,
    reference: Vec<f64>,
    first_node: usize,
    cliques: Vec<Vec<u32>>,
    batches: Vec<Batch<D, A, Q>>,
    start: Vec<Deformation<D, S, Q>>,
    places: Vec<[[Block; A]; A]>,
    cell: std::marker::PhantomData<C>,
}

/// A space dimension for which there are cells.
pub struct Space<const D: usize>;

/// Chooses the cells of a mesh by its cell kind.
pub trait Elements<const D: usize> {
    /// The loop over the cells of `mesh`, whose nodes begin at `first_node` of the model.
    ///
    /// # Errors
    /// The first cell that is inside out in the mesh.
    fn elements(mesh: &Mesh, material: &Material, first_node: usize) -> Result<Box<dyn ElementLoop<D>>, Inverted>;
}

impl Elements<2> for Space<2> {
    fn elements(mesh: &Mesh, material: &Material, first_node: usize) -> Result<Box<dyn ElementLoop<2>>, Inverted> {
        match mesh.kind {
            CellKind::Quad4 => Ok(Box::new(Cells::<Quad4, 2, 3, 4, 4>::new(mesh, material, material.plane(), first_node)?)),
            CellKind::Hex8 => unreachable!("a model has bodies of one dimension"),
        }
    }
}

impl Elements<3> for Space<3> {
    fn elements(mesh: &Mesh, material: &Material, first_node: usize) -> Result<Box<dyn ElementLoop<3>>, Inverted> {
        match mesh.kind {
            CellKind::Hex8 => Ok(Box::new(Cells::<Hex8, 3, 6, 8, 8>::new(mesh, material, material.space(), first_node)?)),
            CellKind::Quad4 => unreachable!("a model has bodies of one dimension"),
        }
    }
}

impl<C: ReferenceCell<D, A, Q>, const D: usize, const S: usize, const A: usize, const Q: usize> Cells<C, D, S, A, Q> {
    fn new(mesh: &Mesh, material: &Material, law: Arc<dyn Law<S>>, first_node: usize) -> Result<Self, Inverted> {
        let points = C::quadrature();
        let reference_gradients = points.map(|(xi, _)| C::gradients(xi));
        let mut batches = Vec::with_capacity(mesh.cell_count().div_ceil(WIDTH));
        let cells: Vec<&[u32]> = mesh.cells().collect();
        for (index, chunk) in cells.chunks(WIDTH).enumerate() {
            let mut batch =
                Batch { nodes: [[0; WIDTH]; A], count: chunk.len(), gradients: [[[Lanes::ZERO; D]; A]; Q], weights: [Lanes::ZERO; Q] };
            for lane in 0..WIDTH {
                let cell = chunk.get(lane).unwrap_or(&chunk[0]);
                for a in 0..A {
                    batch.nodes[a][lane] = cell[a] + first_node as u32;
                }
                for q in 0..Q {
                    let mut jacobian = nalgebra::SMatrix::<f64, D, D>::zeros();
                    for a in 0..A {
                        let x = mesh.points[cell[a] as usize];
                        for i in 0..D {
                            for j in 0..D {
                                jacobian[(i, j)] += x[i] * reference_gradients[q][a][j];
                            }
                        }
                    }
                    // D is 2 or 3: the determinant and the adjugate by expansion.
                    let (determinant, adjugate) = determinant_and_adjugate(&jacobian);
                    if determinant.is_nan() || determinant <= 0.0 {
                        return Err(Inverted { cell: index * WIDTH + lane.min(chunk.len() - 1), determinant });
                    }
                    for a in 0..A {
                        for i in 0..D {
                            let sum: f64 = (0..D).map(|j| adjugate[(j, i)] * reference_gradients[q][a][j]).sum();
                            batch.gradients[q][a][i].0[lane] = sum / determinant;
                        }
                    }
                    batch.weights[q].0[lane] = if lane < chunk.len() { determinant * points[q].1 } else { 0.0 };
                }
            }
            batches.push(batch);
        }
        let reference: Vec<f64> = mesh.points.iter().flat_map(|point| point[..D].to_vec()).collect();
        let cliques = cells.iter().map(|cell| cell.iter().map(|&node| node + first_node as u32).collect()).collect();
        let mut cells = Cells {
            law,
            spatial_law: material.space(),
            density: material.density(),
            reference,
            first_node,
            cliques,
            start: Vec::new(),
            places: Vec::new(),
            batches,
            cell: std::marker::PhantomData::<C>,
        };
        let at_rest: Vec<f64> = std::iter::repeat_n(0.0, first_node * D).chain(cells.reference.iter().copied()).collect();
        cells.begin_step(&at_rest);
        Ok(cells)
    }

    fn deform(&self, batch: &Batch<D, A, Q>, q: &[f64]) -> Deformation<D, S, Q> {
        dispatch(Deform::<D, S, A, Q> { batch, displacement: self.displacement(batch, q) })
    }

    fn displacement(&self, batch: &Batch<D, A, Q>, q: &[f64]) -> [[Lanes<false>; D]; A] {
        let mut u = [[Lanes::ZERO; D]; A];
        for a in 0..A {
            for lane in 0..WIDTH {
                let node = batch.nodes[a][lane] as usize;
                for i in 0..D {
                    u[a][i].0[lane] = q[node * D + i] - self.reference[(node - self.first_node) * D + i];
                }
            }
        }
        u
    }

    /// Force and tangent of one batch, and the smallest determinant of `F` at `q_1` in each lane.
    fn contribution(&self, index: usize, integrator: Integrator, q_1: &[f64], out: &mut Contribution<D, A>) -> [f64; WIDTH] {
        let batch = &self.batches[index];
        let start = &self.start[index];
        let end = self.deform(batch, q_1);
        let placement = integrator.placement();
        let middle = || {
            let mut gradient = end.gradient;
            for q in 0..Q {
                for i in 0..D {
                    for j in 0..D {
                        gradient[q][i][j] = (start.gradient[q][i][j] + end.gradient[q][i][j]) * 0.5;
                    }
                }
            }
            gradient
        };
        let test = if placement.test == Configuration::Middle { middle() } else { end.gradient };
        let trial = if placement.trial == placement.test { test } else { end.gradient };
        let mut stress = [[Lanes::ZERO; S]; Q];
        let mut tangent = [[[Lanes::ZERO; S]; S]; Q];
        match integrator {
            Integrator::EnergyMomentum => {
                let (mut stress_end, mut remainder) = ([[Lanes::ZERO; S]; Q], [Lanes::ZERO; Q]);
                let mut mean = end.strain;
                for q in 0..Q {
                    for s in 0..S {
                        mean[q][s] = (start.strain[q][s] + end.strain[q][s]) * 0.5;
                    }
                }
                self.law.stress_tangent_into(&mean, &mut stress, &mut tangent);
                self.law.stress_into(&end.strain, &mut stress_end);
                self.law.remainder_into(&start.strain, &end.strain, &mut remainder);
                dispatch(Combine {
                    strain_n: &start.strain,
                    strain_n1: &end.strain,
                    stress_end: &stress_end,
                    remainder: &remainder,
                    stress: &mut stress,
                    tangent: &mut tangent,
                });
            }
            Integrator::Midpoint => {
                let strain = dispatch(Strains::<D, S, Q> { gradient: &test });
                self.law.stress_tangent_into(&strain, &mut stress, &mut tangent);
                halve(&mut tangent);
            }
            Integrator::Trapezoidal => self.law.stress_tangent_into(&end.strain, &mut stress, &mut tangent),
        }
        dispatch(Integrate::<D, S, A, Q> {
            batch,
            test: &test,
            trial: &trial,
            stress: &stress,
            tangent: &tangent,
            share: placement.share,
            weight: placement.weight,
            out,
        });
        smallest_determinants(&end.gradient)
    }

    fn scatter(&self, index: usize, contribution: &Contribution<D, A>, force: &mut [f64], values: &mut [f64]) {
        let batch = &self.batches[index];
        for lane in 0..batch.count {
            let places = &self.places[index * WIDTH + lane];
            for a in 0..A {
                let node = batch.nodes[a][lane] as usize * D;
                for i in 0..D {
                    force[node + i] += contribution.force[a][i].0[lane];
                }
                for b in 0..A {
                    for k in 0..D {
                        for i in 0..D {
                            values[places[a][b].at(i, k)] += contribution.tangent[a][b][i][k].0[lane];
                        }
                    }
                }
            }
        }
    }

    fn check(&self, index: usize, determinants: [f64; WIDTH]) -> Result<(), Inverted> {
        for (lane, &determinant) in determinants.iter().enumerate().take(self.batches[index].count) {
            if determinant.is_nan() || determinant <= 0.0 {
                return Err(Inverted { cell: index * WIDTH + lane, determinant });
            }
        }
        Ok(())
    }
}

fn halve<const S: usize, const Q: usize>(tangent: &mut [[Strain<S>; S]; Q]) {
    for component in tangent.iter_mut().flatten().flatten() {
        *component = *component * 0.5;
    }
}

fn determinant_and_adjugate<const D: usize>(m: &nalgebra::SMatrix<f64, D, D>) -> (f64, nalgebra::SMatrix<f64, D, D>) {
    let mut adjugate = nalgebra::SMatrix::<f64, D, D>::zeros();
    for i in 0..D {
        for j in 0..D {
            let minor = |r: usize, c: usize| m[(r % D, c % D)];
            adjugate[(j, i)] = if D == 2 {
                let sign = if i == j { 1.0 } else { -1.0 };
                sign * minor(i + 1, j + 1)
            } else {
                minor(i + 1, j + 1) * minor(i + 2, j + 2) - minor(i + 1, j + 2) * minor(i + 2, j + 1)
            };
        }
    }
    let determinant = (0..D).map(|j| m[(0, j)] * adjugate[(j, 0)]).sum();
    (determinant, adjugate)
}

fn smallest_determinants<const D: usize, const Q: usize>(gradient: &[[[Lanes<false>; D]; D]; Q]) -> [f64; WIDTH] {
    let mut smallest = [f64::INFINITY; WIDTH];
    for h in gradient {
        for (lane, least) in smallest.iter_mut().enumerate() {
            let m = |i: usize, j: usize| h[i][j].0[lane] + if i == j { 1.0 } else { 0.0 };
            let determinant = if D == 2 {
                m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0)
            } else {
                m(0, 0) * (m(1, 1) * m(2, 2) - m(1, 2) * m(2, 1)) - m(0, 1) * (m(1, 0) * m(2, 2) - m(1, 2) * m(2, 0))
                    + m(0, 2) * (m(1, 0) * m(2, 1) - m(1, 1) * m(2, 0))
            };
            if determinant.is_nan() || determinant < *least {
                *least = determinant;
            }
        }
    }
    smallest
}

#[inline(always)]
fn cast<const FMA: bool>(x: Lanes<false>) -> Lanes<FMA> {
    Lanes(x.0)
}

/// Green-Lagrange strain of `F = I + H` in Mandel components.
#[inline(always)]
fn strain_of<const FMA: bool, const D: usize, const S: usize>(h: &[[Lanes<FMA>; D]; D]) -> Strain<S> {
    let mut strain = [Lanes::ZERO; S];
    for i in 0..D {
        for j in i..D {
            let mut sum = h[i][j] + h[j][i];
            for row in h {
                sum = row[i].mul_add(row[j], sum);
            }
            strain[mandel_index::<D>(i, j)] = Lanes((sum * (0.5 / mandel_scale(i, j))).0);
        }
    }
    strain
}

/// Displacement gradients and strains of a batch.
struct Deform<'a, const D: usize, const S: usize, const A: usize, const Q: usize> {
    batch: &'a Batch<D, A, Q>,
    displacement: [[Lanes<false>; D]; A],
}

impl<const D: usize, const S: usize, const A: usize, const Q: usize> Kernel for Deform<'_, D, S, A, Q> {
    type Output = Deformation<D, S, Q>;

    #[inline(always)]
    fn run<const FMA: bool>(self) -> Deformation<D, S, Q> {
        let mut result = Deformation { gradient: [[[Lanes::ZERO; D]; D]; Q], strain: [[Lanes::ZERO; S]; Q] };
        for q in 0..Q {
            let mut h = [[Lanes::<FMA>::ZERO; D]; D];
            for a in 0..A {
                for i in 0..D {
                    for j in 0..D {
                        h[i][j] = cast::<FMA>(self.displacement[a][i]).mul_add(cast(self.batch.gradients[q][a][j]), h[i][j]);
                    }
                }
            }
            result.strain[q] = strain_of(&h);
            result.gradient[q] = relabel_rows(&h);
        }
        result
    }
}

/// Strains of given displacement gradients.
struct Strains<'a, const D: usize, const S: usize, const Q: usize> {
    gradient: &'a [[[Lanes<false>; D]; D]; Q],
}

impl<const D: usize, const S: usize, const Q: usize> Kernel for Strains<'_, D, S, Q> {
    type Output = [Strain<S>; Q];

    #[inline(always)]
    fn run<const FMA: bool>(self) -> [Strain<S>; Q] {
        let mut strain = [[Lanes::ZERO; S]; Q];
        for q in 0..Q {
            strain[q] = strain_of(&relabel_rows::<false, FMA, D, D>(&self.gradient[q]));
        }
        strain
    }
}

/// Turns stress and tangent at the mean strain into the discrete gradient and its derivative.
struct Combine<'a, const S: usize, const Q: usize> {
    strain_n: &'a [Strain<S>; Q],
    strain_n1: &'a [Strain<S>; Q],
    stress_end: &'a [Strain<S>; Q],
    remainder: &'a [Lanes<false>; Q],
    stress: &'a mut [Strain<S>; Q],
    tangent: &'a mut [[Strain<S>; S]; Q],
}

impl<const S: usize, const Q: usize> Kernel for Combine<'_, S, Q> {
    type Output = ();

    #[inline(always)]
    fn run<const FMA: bool>(self) {
        for q in 0..Q {
            let mut d = [Lanes::<FMA>::ZERO; S];
            for s in 0..S {
                d[s] = cast::<FMA>(self.strain_n1[q][s]) - cast(self.strain_n[q][s]);
            }
            let (stress, tangent) = discrete_gradient(
                &d,
                &relabel(&self.stress[q]),
                &relabel_rows(&self.tangent[q]),
                &relabel(&self.stress_end[q]),
                cast(self.remainder[q]),
                STRAIN_INCREMENT_SQUARED,
            );
            self.stress[q] = relabel(&stress);
            self.tangent[q] = relabel_rows(&tangent);
        }
    }
}

/// Force and tangent from stresses and their derivatives.
struct Integrate<'a, const D: usize, const S: usize, const A: usize, const Q: usize> {
    batch: &'a Batch<D, A, Q>,
    test: &'a [[[Lanes<false>; D]; D]; Q],
    trial: &'a [[[Lanes<false>; D]; D]; Q],
    stress: &'a [Strain<S>; Q],
    tangent: &'a [[Strain<S>; S]; Q],
    share: f64,
    weight: f64,
    out: &'a mut Contribution<D, A>,
}

impl<const D: usize, const S: usize, const A: usize, const Q: usize> Kernel for Integrate<'_, D, S, A, Q> {
    type Output = ();

    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let mut force = [[Lanes::<FMA>::ZERO; D]; A];
        let mut blocks = [[[[Lanes::<FMA>::ZERO; D]; D]; A]; A];
        for q in 0..Q {
            let test = deformation_gradient::<FMA, D>(&self.test[q]);
            let trial = deformation_gradient::<FMA, D>(&self.trial[q]);
            let weight = cast::<FMA>(self.batch.weights[q]) * self.weight;
            let gradients = &self.batch.gradients[q];
            let stress = relabel::<false, FMA, S>(&self.stress[q]);
            // half[iJ][s] = w (F_test)_iM T_MJ,s, first Piola stress P_iJ = w (F_test)_iM S_MJ.
            let mut half = [[[Lanes::<FMA>::ZERO; S]; D]; D];
            let mut piola = [[Lanes::<FMA>::ZERO; D]; D];
            for i in 0..D {
                for j in 0..D {
                    for m in 0..D {
                        let factor = test[i][m] * weight * mandel_scale(m, j);
                        let component = mandel_index::<D>(m, j);
                        piola[i][j] = factor.mul_add(stress[component], piola[i][j]);
                        for s in 0..S {
                            half[i][j][s] = factor.mul_add(cast(self.tangent[q][component][s]), half[i][j][s]);
                        }
                    }
                }
            }
            // moduli[i][J][k][L] = half[iJ][NL] (F_trial)_kN + share w S_JL delta_ik.
            let mut moduli = [[[[Lanes::<FMA>::ZERO; D]; D]; D]; D];
            for i in 0..D {
                for j in 0..D {
                    for k in 0..D {
                        for l in 0..D {
                            let mut sum = Lanes::<FMA>::ZERO;
                            for n in 0..D {
                                sum = (half[i][j][mandel_index::<D>(n, l)] * mandel_scale(n, l)).mul_add(trial[k][n], sum);
                            }
                            if i == k {
                                let geometric = stress[mandel_index::<D>(j, l)] * (mandel_scale(j, l) * self.share);
                                sum = geometric.mul_add(weight, sum);
                            }
                            moduli[i][j][k][l] = sum;
                        }
                    }
                }
            }
            for a in 0..A - 1 {
                let mut row = [[[Lanes::<FMA>::ZERO; D]; D]; D];
                for i in 0..D {
                    for j in 0..D {
                        force[a][i] = piola[i][j].mul_add(cast(gradients[a][j]), force[a][i]);
                        for k in 0..D {
                            for l in 0..D {
                                row[i][k][l] = cast::<FMA>(gradients[a][j]).mul_add(moduli[i][j][k][l], row[i][k][l]);
                            }
                        }
                    }
                }
                for b in 0..A - 1 {
                    for i in 0..D {
                        for k in 0..D {
                            for l in 0..D {
                                blocks[a][b][i][k] = row[i][k][l].mul_add(cast(gradients[b][l]), blocks[a][b][i][k]);
                            }
                        }
                    }
                }
            }
        }
        // The shape functions' gradients sum to zero: the last node takes what the others leave.
        for a in 0..A - 1 {
            for i in 0..D {
                force[A - 1][i] = force[A - 1][i] - force[a][i];
                for k in 0..D {
                    for b in 0..A - 1 {
                        let block = blocks[a][b][i][k];
                        blocks[a][A - 1][i][k] = blocks[a][A - 1][i][k] - block;
                        blocks[A - 1][b][i][k] = blocks[A - 1][b][i][k] - block;
                        blocks[A - 1][A - 1][i][k] = blocks[A - 1][A - 1][i][k] + block;
                    }
                }
            }
        }
        self.out.force = relabel_rows(&force);
        for a in 0..A {
            for b in 0..A {
                self.out.tangent[a][b] = relabel_rows(&blocks[a][b]);
            }
        }
    }
}

#[inline(always)]
fn deformation_gradient<const FMA: bool, const D: usize>(h: &[[Lanes<false>; D]; D]) -> [[Lanes<FMA>; D]; D] {
    let mut f = relabel_rows::<false, FMA, D, D>(h);
    for (i, row) in f.iter_mut().enumerate() {
        row[i] = row[i] + 1.0;
    }
    f
}

/// Batches that are computed in parallel before their sums are made in order.
const CHUNK: usize = 64;

impl<C: ReferenceCell<D, A, Q>, const D: usize, const S: usize, const A: usize, const Q: usize> ElementLoop<D> for Cells<C, D, S, A, Q> {
    fn cliques(&self) -> &[Vec<u32>] {
        &self.cliques
    }

    fn place(&mut self, pattern: &Pattern) {
        self.places.clear();
        for (index, batch) in self.batches.iter().enumerate() {
            for lane in 0..batch.count {
                let nodes = &self.cliques[index * WIDTH + lane];
                self.places.push(std::array::from_fn(|a| std::array::from_fn(|b| pattern.block(nodes[a], nodes[b]))));
            }
        }
    }

    fn add_mass(&self, mass: &mut NodeMatrix) {
        let shapes = C::quadrature().map(|(xi, _)| C::shape(xi));
        for (index, batch) in self.batches.iter().enumerate() {
            for lane in 0..batch.count {
                let nodes = &self.cliques[index * WIDTH + lane];
                for a in 0..A {
                    for b in 0..A {
                        let sum: f64 = (0..Q).map(|q| batch.weights[q].0[lane] * shapes[q][a] * shapes[q][b]).sum();
                        mass.add(nodes[a], nodes[b], self.density * sum);
                    }
                }
            }
        }
    }

    fn begin_step(&mut self, q_0: &[f64]) {
        self.start = self.batches.iter().map(|batch| self.deform(batch, q_0)).collect();
    }

    fn assemble(
        &self,
        integrator: Integrator,
        q_1: &[f64],
        force: &mut [f64],
        values: &mut [f64],
        workers: &Workers,
    ) -> Result<(), Inverted> {
        let empty = Contribution { force: [[Lanes::ZERO; D]; A], tangent: [[[[Lanes::ZERO; D]; D]; A]; A] };
        if !workers.are_many() {
            let mut contribution = empty;
            for index in 0..self.batches.len() {
                self.check(index, self.contribution(index, integrator, q_1, &mut contribution))?;
                self.scatter(index, &contribution, force, values);
            }
            return Ok(());
        }
        let mut computed = vec![(empty, [0.0; WIDTH]); CHUNK.min(self.batches.len())];
        for first in (0..self.batches.len()).step_by(CHUNK) {
            let count = CHUNK.min(self.batches.len() - first);
            workers.for_each(&mut computed[..count], 8, |offset, (contribution, determinants)| {
                *determinants = self.contribution(first + offset, integrator, q_1, contribution);
            });
            for (offset, (contribution, determinants)) in computed[..count].iter().enumerate() {
                self.check(first + offset, *determinants)?;
                self.scatter(first + offset, contribution, force, values);
            }
        }
        Ok(())
    }

    fn add_material_stiffness(&self, q: &[f64], values: &mut [f64]) {
        let mut contribution = Contribution { force: [[Lanes::ZERO; D]; A], tangent: [[[[Lanes::ZERO; D]; D]; A]; A] };
        let mut force = vec![0.0; q.len()];
        for (index, batch) in self.batches.iter().enumerate() {
            let deformation = self.deform(batch, q);
            let (mut stress, mut tangent) = ([[Lanes::ZERO; S]; Q], [[[Lanes::ZERO; S]; S]; Q]);
            self.law.stress_tangent_into(&deformation.strain, &mut stress, &mut tangent);
            let gradient = &deformation.gradient;
            let (share, weight, out) = (0.0, 1.0, &mut contribution);
            dispatch(Integrate { batch, test: gradient, trial: gradient, stress: &stress, tangent: &tangent, share, weight, out });
            self.scatter(index, &contribution, &mut force, values);
        }
    }

    fn strain_energy(&self, q: &[f64]) -> f64 {
        let mut sum = 0.0;
        for batch in &self.batches {
            let deformation = self.deform(batch, q);
            let mut energy = [Lanes::ZERO; Q];
            self.law.energy_into(&deformation.strain, &mut energy);
            for lane in 0..batch.count {
                sum += (0..Q).map(|q| batch.weights[q].0[lane] * energy[q].0[lane]).sum::<f64>();
            }
        }
        sum
    }

    fn smallest_determinant(&self, q: &[f64]) -> Inverted {
        let mut least = Inverted { cell: 0, determinant: f64::INFINITY };
        for (index, batch) in self.batches.iter().enumerate() {
            let determinants = smallest_determinants(&self.deform(batch, q).gradient);
            for (lane, &determinant) in determinants.iter().enumerate().take(batch.count) {
                if determinant.is_nan() || determinant < least.determinant {
                    least = Inverted { cell: index * WIDTH + lane, determinant };
                }
            }
        }
        least
    }

    fn project_stress(&self, q: &[f64], stress: &mut [[f64; 6]], weight: &mut [f64]) {
        let shapes = C::quadrature().map(|(xi, _)| C::shape(xi));
        for (index, batch) in self.batches.iter().enumerate() {
            let deformation = self.deform(batch, q);
            for point in 0..Q {
                // The spatial law also knows the stress across the plane.
                let mut strain = [Lanes::ZERO; 6];
                for i in 0..D {
                    for j in i..D {
                        strain[mandel_index::<3>(i, j)] = deformation.strain[point][mandel_index::<D>(i, j)];
                    }
                }
                let mut second_piola = [[Lanes::ZERO; 6]];
                self.spatial_law.stress_into(&[strain], &mut second_piola);
                for lane in 0..batch.count {
                    let f = nalgebra::Matrix3::from_fn(|i, j| {
                        let h = if i < D && j < D { deformation.gradient[point][i][j].0[lane] } else { 0.0 };
                        h + if i == j { 1.0 } else { 0.0 }
                    });
                    let s = nalgebra::Matrix3::from_fn(|i, j| second_piola[0][mandel_index::<3>(i, j)].0[lane] * mandel_scale(i, j));
                    let cauchy = f * s * f.transpose() / f.determinant();
                    let cauchy = [cauchy.m11, cauchy.m22, cauchy.m33, cauchy.m12, cauchy.m23, cauchy.m13];
                    for (a, &node) in self.cliques[index * WIDTH + lane].iter().enumerate() {
                        let share = batch.weights[point].0[lane] * shapes[point][a];
                        weight[node as usize] += share;
                        for (sum, value) in stress[node as usize].iter_mut().zip(cauchy) {
                            *sum += share * value;
                        }
                    }
                }
            }
        }
    }
}
