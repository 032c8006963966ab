//! Consistent mass of cells with a variable Jacobian.
//!
//! `m_ab = int rho N_a N_b det J dxi`. The stiffness quadrature is exact for a constant Jacobian only. In curved and distorted cells and
//! around an axis of revolution it is inexact: with eight `tet10` facets around a circle, the kinetic energy had an error of 1 %. Such
//! cells store `int N_a N_b det J` by an exact quadrature, one number for each pair of nodes.

use super::batch::{Batch, Point, Table, many};
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
    pub(super) fn new<C: ReferenceCell<D, A, Q>, const Q: usize>(shape: CellShape) -> Self {
        let at = |(xi, weight): ([f64; 3], f64)| {
            let xi: [f64; D] = std::array::from_fn(|i| xi[i]);
            MassPoint { shapes: C::shape(xi), gradients: C::gradients(xi), weight }
        };
        MassRule { points: shape.mass_points().into_iter().map(at).collect() }
    }

    /// Integrals of the products of two shape functions over the cells of a batch; over the circumference if `is_section`.
    fn products(&self, batch: &Batch<D, A>, is_section: bool, products: &mut Vec<Lanes<false>>) {
        products.clear();
        products.resize(place(A - 1, A - 1) + 1, Lanes::ZERO);
        for MassPoint { shapes, gradients, weight } in &self.points {
            let mut point = Point::<false, D, A>::new(&batch.edges, gradients, *weight);
            if is_section {
                point.revolve(batch, shapes);
            }
            for a in 0..many::<A>() {
                let share = point.weighed * shapes[a];
                for b in 0..=a {
                    let product = &mut products[place(a, b)];
                    *product = share.mul_add(Lanes::splat(shapes[b]), *product);
                }
            }
        }
    }
}

impl<const D: usize, const A: usize> Batch<D, A> {
    /// Stores the integrals of products of shape functions if the stiffness quadrature with these volumes is inexact; `exact` is a buffer
    /// shared by all batches.
    pub(super) fn keep_mass<const Q: usize>(
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
            (0..A).any(|a| {
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
    (0..Q).map(|q| volumes[q].0[lane] * table.products[q][a][b]).sum()
}

#[cfg(test)]
mod tests {
    use crate::bodies::{BodyCells, Elements, Formulation, Plane, Space};
    use crate::elements::{CellKind, CellShape};
    use crate::integrators::Lumping;
    use crate::linear::{NodeMatrix, Pattern, Vertex};
    use crate::materials::NeoHookean;
    use crate::mesh::Mesh;

    /// Gauss points and weights on [-1, 1], `count` of them, by Newton's method on the Legendre polynomial.
    fn gauss(count: usize) -> Vec<(f64, f64)> {
        let point = |k: usize| {
            let (mut x, mut slope) = ((std::f64::consts::PI * (k as f64 + 0.75) / (count as f64 + 0.5)).cos(), 0.0);
            for _ in 0..50 {
                let (mut before, mut value) = (1.0, x);
                for n in 2..=count {
                    let n = n as f64;
                    (before, value) = (value, ((2.0 * n - 1.0) * x * value - (n - 1.0) * before) / n);
                }
                slope = count as f64 * (x * value - before) / (x * x - 1.0);
                x -= value / slope;
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        };
        (0..count).map(point).collect()
    }

    /// Points and weights of a rule of much higher degree than the mass; simplices by repeated integration over `0 <= y <= 1 - x`.
    fn fine_rule(shape: CellShape) -> Vec<([f64; 3], f64)> {
        let line = gauss(9);
        let over = |from: f64, to: f64| line.iter().map(move |(x, w)| (from + 0.5 * (to - from) * (x + 1.0), 0.5 * (to - from) * w));
        let mut rule = Vec::new();
        let (is_simplex, is_wedge) = (shape.is_simplex(), shape == CellShape::Wedge);
        for (x, a) in if is_simplex || is_wedge { over(0.0, 1.0) } else { over(-1.0, 1.0) } {
            for (y, b) in if is_simplex || is_wedge { over(0.0, 1.0 - x) } else { over(-1.0, 1.0) } {
                match shape {
                    CellShape::Triangle | CellShape::Quadrilateral => rule.push(([x, y, 0.0], a * b)),
                    _ => rule
                        .extend((if is_simplex { over(0.0, 1.0 - x - y) } else { over(-1.0, 1.0) }).map(|(z, c)| ([x, y, z], a * b * c))),
                }
            }
        }
        rule
    }

    /// Mesh of one cell with a curved shape, away from the axis.
    fn bent(kind: CellKind) -> Mesh {
        let plane = kind.dimension() == 2;
        let bend = |[x, y, z]: [f64; 3]| {
            let z = if plane { 0.0 } else { z + 0.11 * (1.3 * x - 0.4 * y).sin() };
            [3.0 + x + 0.12 * (1.7 * y + 0.3 + z).sin(), y + 0.15 * (1.1 * x + 0.6 * z).cos(), z]
        };
        let points: Vec<[f64; 3]> = kind.row().node_places.iter().map(|&place| bend(kind.shape().place(place))).collect();
        let connectivity = (0..points.len() as u32).collect();
        Mesh::new(kind, points, connectivity)
    }

    fn masses<const D: usize>(mesh: &Mesh, formulation: Formulation, density: f64) -> (Vec<(u32, u32, f64)>, f64)
    where
        Space<D>: Elements<D>,
    {
        let material =
            NeoHookean { youngs_modulus: 1.0, poisson_ratio: 0.3, density }.material().expect("the constants are in their ranges");
        let cells = Space::<D>::elements(&BodyCells::new(mesh, &material, formulation)).expect("the cell is sound");
        let pattern =
            Pattern::new(&vec![Vertex::coordinates(D as u8); mesh.points.len()], cells.cliques().iter().map(|clique| &clique[..]));
        let mut matrix = NodeMatrix::new(&pattern, mesh.points.len());
        cells.add_mass(&mut matrix);
        let mut lumped = vec![0.0; mesh.points.len()];
        cells.add_lumped_mass(Lumping::Suitable, &mut lumped);
        (matrix.entries().collect(), lumped.iter().sum())
    }

    #[test]
    fn mass_of_every_kind_is_the_integral_over_the_bent_cell() {
        for &kind in CellKind::ALL {
            for plane in [Plane::Strain, Plane::Axisymmetric] {
                let (mesh, row) = (bent(kind), kind.row());
                if plane == Plane::Axisymmetric && kind.dimension() == 3 {
                    continue;
                }
                let formulation = Formulation { plane, ..Formulation::default() };
                let (found, lumped) = match kind.dimension() {
                    2 => masses::<2>(&mesh, formulation, 2.0),
                    _ => masses::<3>(&mesh, formulation, 2.0),
                };
                let (count, mut exact) = (mesh.points.len(), vec![0.0; mesh.points.len() * mesh.points.len()]);
                for (xi, weight) in fine_rule(kind.shape()) {
                    let (shapes, slopes) = ((row.shape)(xi), (row.gradients)(xi));
                    let mut jacobian = nalgebra::Matrix3::zeros();
                    for (point, slope) in mesh.points.iter().zip(&slopes) {
                        (0..3).for_each(|i| (0..3).for_each(|j| jacobian[(i, j)] += point[i] * slope[j]));
                    }
                    if kind.dimension() == 2 {
                        jacobian[(2, 2)] = 1.0;
                    }
                    let radius: f64 = shapes.iter().zip(&mesh.points).map(|(share, point)| share * point[0]).sum();
                    let around = if plane == Plane::Axisymmetric { std::f64::consts::TAU * radius } else { 1.0 };
                    let volume = 2.0 * weight * jacobian.determinant() * around;
                    (0..count * count).for_each(|k| exact[k] += volume * shapes[k / count] * shapes[k % count]);
                }
                let (whole, largest) = (exact.iter().sum::<f64>(), exact.iter().copied().fold(0.0, f64::max));
                for (a, b, mass) in found {
                    let off = mass - exact[a as usize * count + b as usize];
                    assert!(off.abs() < 1e-13 * largest, "{kind:?} {plane:?} {a} {b}: {off:e} of {largest}");
                }
                assert!((lumped / whole - 1.0).abs() < 1e-13, "{kind:?} {plane:?}: {lumped} {whole}");
                let measure = if plane == Plane::Axisymmetric { mesh.volume_of_revolution() } else { mesh.measure() };
                assert!((2.0 * measure / whole - 1.0).abs() < 1e-13, "{kind:?} {plane:?}: {measure} {whole}");
            }
        }
    }
}
