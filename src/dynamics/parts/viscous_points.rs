//! The quadrature points of a viscous body: what of positions they see, and what they answer.
//!
//! `E_1 - E_0 = sym(F_mid^T (F_1 - F_0))` exactly, without the cancellation of the two strains; around an axis
//! `(l_0 + l_1)/2 (l_1 - l_0)` of the stretches `l = r/R`. Strains of small displacements are linear in both.

use nalgebra::SMatrix;

use crate::bodies::Plane;
use crate::materials::Viscosity;
use crate::mesh::Mesh;

/// Derivatives of the position at a point.
pub type Matrix<const D: usize> = SMatrix<f64, D, D>;

/// A quadrature point of a cell.
pub struct Point {
    /// Volume that belongs to it, around an axis that of the circumference.
    pub volume: f64,
    /// Gradients of the shape functions.
    pub gradients: Vec<[f64; 3]>,
    /// Shape functions over the radius, of a body of revolution.
    pub around: Vec<f64>,
}

/// The points of a mesh's cells.
pub fn points_of(mesh: &Mesh, plane: Plane) -> Vec<Vec<Point>> {
    let row = mesh.kind.row();
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
            let mut point =
                Point { volume: weight * jacobian.determinant(), gradients: slopes.iter().map(gradient).collect(), around: Vec::new() };
            if plane == Plane::Axisymmetric {
                let shapes = (row.shape)(xi);
                let radius: f64 = cell.iter().zip(&shapes).map(|(&node, shape)| mesh.points[node as usize][0] * shape).sum();
                point.volume *= radius * std::f64::consts::TAU;
                point.around = shapes.iter().map(|shape| shape / radius).collect();
            }
            point
        };
        (row.quadrature)().into_iter().map(at).collect()
    });
    points.collect()
}

/// Displacement gradient of a point, and its stretch around an axis less 1, 0 where there is none.
#[derive(Clone, Copy)]
pub struct Deformation<const D: usize> {
    /// Among the directions of the cells.
    pub inner: Matrix<D>,
    /// Around.
    pub around: f64,
}

/// Deformation gradient of a point, and its stretch around an axis.
pub struct Frame<const D: usize> {
    /// Among the directions of the cells.
    pub inner: Matrix<D>,
    /// Around.
    pub around: f64,
}

impl<const D: usize> Frame<D> {
    /// No displacement.
    pub fn rest() -> Self {
        Frame { inner: Matrix::identity(), around: 1.0 }
    }
}

/// A symmetric tensor: among the directions of the cells, and across the plane.
#[derive(Clone, Copy)]
pub struct Strain<const D: usize> {
    /// Among the directions of the cells.
    pub inner: Matrix<D>,
    /// Across.
    pub across: f64,
}

impl<const D: usize> Strain<D> {
    /// `A + B`.
    pub fn sum(&self, other: &Self) -> Self {
        Strain { inner: self.inner + other.inner, across: self.across + other.across }
    }

    /// `s A`.
    pub fn times(&self, factor: f64) -> Self {
        Strain { inner: self.inner * factor, across: self.across * factor }
    }

    fn trace(&self) -> f64 {
        self.inner.trace() + self.across
    }

    /// Sum of the squares of all components.
    pub fn norm_squared(&self) -> f64 {
        self.inner.norm_squared() + self.across.powi(2)
    }

    /// Appends so many of its components; that across is the last.
    pub fn pack(&self, components: usize, into: &mut Vec<f64>) {
        let start = into.len();
        (0..D).for_each(|i| (i..D).for_each(|j| into.push(self.inner[(i, j)])));
        into.push(self.across);
        into.truncate(start + components);
    }

    /// From its components.
    pub fn unpacked(components: &[f64]) -> Self {
        let mut strain = Strain { inner: Matrix::<D>::zeros(), across: 0.0 };
        let mut next = components.iter();
        for i in 0..D {
            for j in i..D {
                let value = next.next().copied().unwrap_or_default();
                (strain.inner[(i, j)], strain.inner[(j, i)]) = (value, value);
            }
        }
        strain.across = next.next().copied().unwrap_or_default();
        strain
    }
}

impl<const D: usize> Deformation<D> {
    /// The deformation gradient `I + H`, by which forces are pulled forward and strains are varied.
    pub fn frame(&self) -> Frame<D> {
        Frame { inner: Matrix::identity() + self.inner, around: 1.0 + self.around }
    }

    /// In the middle of a step.
    pub fn mean(&self, other: &Self) -> Self {
        Deformation { inner: (self.inner + other.inner) * 0.5, around: (self.around + other.around) * 0.5 }
    }

    /// Change of the Green-Lagrange strain to another deformation.
    pub fn strain_to(&self, other: &Self) -> Strain<D> {
        let middle = self.mean(other).frame();
        let product = middle.inner.transpose() * (other.inner - self.inner);
        Strain { inner: (product + product.transpose()) * 0.5, across: middle.around * (other.around - self.around) }
    }

    /// Change of the strain of small displacements to another deformation.
    pub fn linear_strain_to(&self, other: &Self) -> Strain<D> {
        let difference = other.inner - self.inner;
        Strain { inner: (difference + difference.transpose()) * 0.5, across: other.around - self.around }
    }
}

/// What a point contributes to a step.
pub struct Contribution<const D: usize> {
    /// Its stress `[stress]`.
    pub stress: Strain<D>,
    /// `dS/dE_1 = a I_4 + b I (x) I` `[stress]`.
    pub moduli: [f64; 2],
    /// Heat `[energy/volume]`.
    pub dissipated: f64,
    /// Strains of the branches at the end.
    pub remembered: Vec<Strain<D>>,
    /// The part of the stress that resists the rate of strain `[stress]`.
    pub of_rate: Strain<D>,
}

impl<const D: usize> Contribution<D> {
    /// To a step of size `dt`, whose strain changes by `change`, with the strains of the branches at the start.
    pub fn new(viscosity: &Viscosity, change: &Strain<D>, before: &[Strain<D>], dt: f64) -> Self {
        let Viscosity { shear, bulk, branches } = viscosity;
        let rate = Strain { inner: change.inner / dt, across: change.across / dt };
        let volumetric = bulk * rate.trace();
        let mut stress = rate.times(2.0 * shear).sum(&Strain { inner: Matrix::<D>::identity() * volumetric, across: volumetric });
        let of_rate = stress;
        let mut dissipated = dt * (2.0 * shear * rate.norm_squared() + bulk * rate.trace().powi(2));
        let (mut moduli, mut remembered) = ([2.0 * shear / dt, bulk / dt], Vec::with_capacity(branches.len()));
        for (branch, y_0) in branches.iter().zip(before) {
            let [left, comes] = branch.shares(dt);
            let y_1 = y_0.times(left).sum(&change.times(comes));
            let middle = y_0.sum(&y_1).times(0.5);
            stress = stress.sum(&middle.times(2.0 * branch.shear_modulus));
            moduli[0] += branch.shear_modulus * comes;
            dissipated += 2.0 * branch.shear_modulus * dt / branch.relaxation_time * middle.norm_squared();
            remembered.push(y_1);
        }
        Contribution { stress, moduli, dissipated, remembered, of_rate }
    }
}
