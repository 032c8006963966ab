//! Vectors and facet frames for any number type, and Hessians from gradients with numbers that carry derivatives.

use std::ops::Mul;

use crate::contact::numbers::{self, Number};
use crate::math::simd::{Kernel, dispatch};

/// Vector in space.
pub type Vec3<T> = [T; 3];

/// Number of unknowns per differentiation pass: half of those of two facets, or all plane coordinates of two triangles.
pub const LANES: usize = 12;

/// Number with its derivatives with respect to [`LANES`] unknowns.
pub type Jet = numbers::Jet<LANES>;

#[inline(always)]
pub fn sub<T: Number, const N: usize>(mut a: [T; N], b: [T; N]) -> [T; N] {
    for i in 0..N {
        a[i] -= b[i];
    }
    a
}

#[inline(always)]
pub fn scaled<T: Copy, R: Number + Mul<T, Output = R>, const N: usize>(mut a: [R; N], s: T) -> [R; N] {
    for i in 0..N {
        a[i] = a[i] * s;
    }
    a
}

#[inline(always)]
pub fn dot<T: Number>(a: Vec3<T>, b: Vec3<T>) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub fn cross<T: Copy, R: Number + Mul<T, Output = R>>(a: Vec3<R>, b: Vec3<T>) -> Vec3<R> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Diagonals of a facet of four nodes, or two sides of a triangle, whose cross product is along the normal.
#[inline(always)]
pub fn diagonals<T: Number>(nodes: &[Vec3<T>]) -> [Vec3<T>; 2] {
    let [c, d] = diagonal_ends(nodes.len());
    [sub(nodes[c.1], nodes[c.0]), sub(nodes[d.1], nodes[d.0])]
}

/// Start and end of each of the vectors [`diagonals`] among the nodes of a facet.
#[inline(always)]
pub fn diagonal_ends(count: usize) -> [(usize, usize); 2] {
    if count == 3 { [(0, 1), (0, 2)] } else { [(0, 2), (1, 3)] }
}

/// Axes of a facet: the first along the mean of the first side and the opposite one, the third along the normal.
pub struct FacetFrame<T> {
    /// Unit vectors.
    pub axes: [Vec3<T>; 3],
    /// Diagonals of a quadrilateral, or two sides of a triangle `[length]`.
    pub diagonals: [Vec3<T>; 2],
    /// Length of the cross product of `diagonals`, twice the facet's area `[length^2]`.
    pub length: T,
}

impl<T: Number> FacetFrame<T> {
    /// Frame of a facet with the given nodes; `None` for a facet without area.
    #[inline(always)]
    pub fn new(x: &[Vec3<T>]) -> Option<Self> {
        let diagonals = diagonals(x);
        let product = cross(diagonals[0], diagonals[1]);
        let square = dot(product, product);
        if square.re() <= 0.0 {
            return None;
        }
        let length = square.sqrt();
        let normal = scaled(product, length.recip());
        let side = if x.len() == 3 { diagonals[0] } else { sub(sub(x[1], x[0]), sub(x[3], x[2])) };
        let along = sub(side, scaled(normal, dot(side, normal)));
        let first = scaled(along, dot(along, along).sqrt().recip());
        Some(FacetFrame { axes: [first, cross(normal, first), normal], diagonals, length })
    }
}

/// Unknowns `z`, three per node, as numbers that carry derivatives with respect to `N` of the unknowns, from `first` on.
#[inline(always)]
pub fn jets<const N: usize>(z: &[f64], first: usize) -> Vec<Vec3<numbers::Jet<N>>> {
    let jet = |k: usize| numbers::Jet::unknown(z[k], k.checked_sub(first));
    (0..z.len() / 3).map(|node| std::array::from_fn(|i| jet(3 * node + i))).collect()
}

/// Gradient of a function of `N` nodes, for numbers with derivatives. `at` and all functions that it calls must be `#[inline(always)]`.
pub trait Gradient<const N: usize> {
    /// Gradient at the positions of the nodes.
    fn at(&self, x: &[Vec3<Jet>]) -> [Vec3<Jet>; N];
}

/// Writes `share` times the derivatives of a gradient at the unknowns `z`, row-major, [`LANES`] columns at a time.
pub fn hessian_into<const N: usize>(z: &[f64], share: f64, out: &mut [f64], gradient: &impl Gradient<N>) {
    dispatch(Hessian { z, share, out, gradient });
}

/// Hessian, compiled for the instruction set of the processor.
struct Hessian<'a, G, const N: usize> {
    z: &'a [f64],
    share: f64,
    out: &'a mut [f64],
    gradient: &'a G,
}

impl<G: Gradient<N>, const N: usize> Kernel for Hessian<'_, G, N> {
    type Output = ();

    #[inline(always)]
    fn run<const FMA: bool>(self) {
        for first in (0..self.z.len()).step_by(LANES) {
            columns_into(&self.gradient.at(&jets(self.z, first)), first, self.share, self.out);
        }
    }
}

/// Writes `share` times the derivatives that a gradient carries as columns of its Hessian, from `first` on.
#[inline(always)]
pub fn columns_into(gradient: &[Vec3<Jet>], first: usize, share: f64, out: &mut [f64]) {
    let unknowns = out.len().isqrt();
    for (row, jet) in out.chunks_exact_mut(unknowns).zip(gradient.as_flattened()) {
        row[first..].iter_mut().zip(jet.eps).for_each(|(entry, slope)| *entry = share * slope);
    }
}
