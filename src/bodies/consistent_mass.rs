//! Consistent mass of cells with a variable Jacobian.
//!
//! `m_ab = int rho N_a N_b det J dxi`. The stiffness quadrature is exact for a constant Jacobian only. In curved and distorted cells and
//! around an axis of revolution it is inexact: with eight `tet10` facets around a circle, the kinetic energy had an error of 1 %. Such
//! cells store `int N_a N_b det J` by an exact quadrature, one number for each pair of nodes.

use super::batch::{Batch, Point, Table, filled};
use crate::elements::{CellShape, ReferenceCell};
use crate::math::lanes::{Lanes, Real, WIDTH};

/// Relative difference up to which two quadratures of a product of shape functions count as equal: round-off of their sums.
const MASS_PRODUCT: f64 = 50.0 * f64::EPSILON;

/// Quadrature point of the mass: values and gradients of the shape functions, and weight.
struct MassPoint<const D: usize, const A: usize> {
    shapes: [f64; A],
    gradients: [[f64; D]; A],
    weight: f64,
}

/// Mass quadrature of a cell kind.
pub(super) struct MassRule<const D: usize, const A: usize> {
    points: Vec<MassPoint<D, A>>,
}

/// Index of a node pair in the lower triangle of a symmetric matrix, row by row.
fn place(a: usize, b: usize) -> usize {
    let (row, column) = (a.max(b), a.min(b));
    row * (row + 1) / 2 + column
}

impl<const D: usize, const A: usize> MassRule<D, A> {
    /// Mass quadrature of a cell kind.
    pub(super) fn new<C: ReferenceCell<D, N, P>, const N: usize, const P: usize>(shape: CellShape) -> Self {
        let at = |(xi, weight): ([f64; 3], f64)| {
            let xi: [f64; D] = std::array::from_fn(|i| xi[i]);
            MassPoint { shapes: filled(C::shape(xi), 0.0), gradients: filled(C::gradients(xi), [0.0; D]), weight }
        };
        MassRule { points: shape.mass_points().into_iter().map(at).collect() }
    }

    /// Integrals of the products of two shape functions over the cells of a batch; over the circumference if `is_section`.
    fn products(&self, batch: &Batch<D>, is_section: bool, products: &mut Vec<Lanes<false>>) {
        let last = batch.nodes.len() - 1;
        products.clear();
        products.resize(place(last, last) + 1, Lanes::ZERO);
        for MassPoint { shapes, gradients, weight } in &self.points {
            let mut point = Point::<false, D, A>::ZERO;
            point.set(&batch.edges, gradients, *weight);
            if is_section {
                point.revolve(batch.last, &batch.edges, shapes);
            }
            for a in 0..=last {
                let share = point.weighed * shapes[a];
                for b in 0..=a {
                    let product = &mut products[place(a, b)];
                    *product = share.mul_add(Lanes::splat(shapes[b]), *product);
                }
            }
        }
    }
}

impl<const D: usize> Batch<D> {
    /// Stores the integrals of products of shape functions if the stiffness quadrature with these volumes is inexact; `exact` is a buffer
    /// shared by all batches.
    pub(super) fn keep_mass<const A: usize, const Q: usize>(
        &mut self,
        rule: &MassRule<D, A>,
        table: &Table<D, A, Q>,
        volumes: &[Lanes<false>; Q],
        is_section: bool,
        exact: &mut Vec<Lanes<false>>,
    ) {
        rule.products(self, is_section, exact);
        let is_off = |lane: usize| {
            let largest = exact.iter().map(|product| product.0[lane].abs()).fold(0.0, f64::max);
            (0..table.counts.nodes()).any(|a| {
                (0..=a).any(|b| (exact[place(a, b)].0[lane] - summed(table, volumes, lane, [a, b])).abs() > MASS_PRODUCT * largest)
            })
        };
        self.mass = if (0..WIDTH).any(is_off) { exact.clone() } else { Vec::new() };
    }

    /// Stored integral of the product of two nodes' shape functions over the cells of the batch; `None` if not stored.
    #[inline(always)]
    pub(super) fn kept_mass(&self, a: usize, b: usize) -> Option<Lanes<false>> {
        self.mass.get(place(a, b)).copied()
    }
}

/// Sum over the stiffness quadrature points of the product of two nodes' shape functions.
pub(super) fn summed<const D: usize, const A: usize, const Q: usize>(
    table: &Table<D, A, Q>,
    volumes: &[Lanes<false>; Q],
    lane: usize,
    [a, b]: [usize; 2],
) -> f64 {
    (0..table.counts.points()).map(|q| volumes[q].0[lane] * table.products[q][a][b]).sum()
}
