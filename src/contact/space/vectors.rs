//! Vectors of any numbers, and what makes a second derivative of a gradient that is written for any numbers.

use std::ops::Mul;

use crate::contact::numbers::{self, Number};
use crate::math::simd::{Kernel, dispatch};

/// A vector in space.
pub type Vec3<T> = [T; 3];

/// Unknowns with respect to which one pass differentiates: half of those of two facets, all plane coordinates of two triangles.
pub const LANES: usize = 12;

/// A number with its derivatives with respect to some unknowns.
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

/// The diagonals of a facet of four nodes, two sides of one of three: their product is along its normal.
#[inline(always)]
pub fn diagonals<T: Number>(nodes: &[Vec3<T>]) -> [Vec3<T>; 2] {
    if nodes.len() == 3 { [sub(nodes[1], nodes[0]), sub(nodes[2], nodes[0])] } else { [sub(nodes[2], nodes[0]), sub(nodes[3], nodes[1])] }
}

/// The axes of a facet: its first one along the first side and that opposite, its third one normal to its diagonals.
pub struct Frame<T> {
    /// Unit vectors.
    pub axes: [Vec3<T>; 3],
    /// Diagonals, or two sides of a triangle, and the length of their product.
    pub diagonals: [Vec3<T>; 2],
    pub length: T,
}

impl<T: Number> Frame<T> {
    /// That of a facet with these nodes; nothing where it has no area.
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
        Some(Frame { axes: [first, cross(normal, first), normal], diagonals, length })
    }
}

/// The unknowns `z`, three for each node, as numbers that carry the derivatives with respect to some of them, from `first` on.
#[inline(always)]
pub fn jets(z: &[f64], first: usize) -> Vec<Vec3<Jet>> {
    let jet = |k: usize| Jet::unknown(z[k], k.checked_sub(first));
    (0..z.len() / 3).map(|node| std::array::from_fn(|i| jet(3 * node + i))).collect()
}

/// A gradient of a function of `N` nodes that is written for numbers with derivatives. `at` must be `#[inline(always)]`, and so must all it
/// calls.
pub trait Gradient<const N: usize> {
    /// The gradient at positions of the nodes.
    fn at(&self, x: &[Vec3<Jet>]) -> [Vec3<Jet>; N];
}

/// `share` times the derivatives of a gradient at the unknowns `z`, row by row over them, some columns at a time.
pub fn hessian_into<const N: usize>(z: &[f64], share: f64, out: &mut [f64], gradient: &impl Gradient<N>) {
    dispatch(Hessian { z, share, out, gradient });
}

/// A Hessian, with the instructions that the processor has.
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

/// `share` times the derivatives that a gradient carries as columns of its Hessian, from `first` on.
#[inline(always)]
pub fn columns_into(gradient: &[Vec3<Jet>], first: usize, share: f64, out: &mut [f64]) {
    let unknowns = out.len().isqrt();
    for (row, jet) in out.chunks_exact_mut(unknowns).zip(gradient.as_flattened()) {
        row[first..].iter_mut().zip(jet.eps).for_each(|(entry, slope)| *entry = share * slope);
    }
}
