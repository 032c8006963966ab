//! Contract of the mass of every cell kind: integrals over a curved cell.

use conserva::bodies::{BodyCells, Elements, Formulation, Plane, Space};
use conserva::elements::{CellKind, CellShape};
use conserva::integrators::Lumping;
use conserva::linear::{NodeMatrix, Pattern, Vertex};
use conserva::materials::NeoHookean;
use conserva::mesh::Mesh;

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
                _ => rule.extend((if is_simplex { over(0.0, 1.0 - x - y) } else { over(-1.0, 1.0) }).map(|(z, c)| ([x, y, z], a * b * c))),
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
    let material = NeoHookean { youngs_modulus: 1.0, poisson_ratio: 0.3, density }.material().expect("the constants are in their ranges");
    let cells = Space::<D>::elements(&BodyCells::new(mesh, &material, formulation)).expect("the cell is sound");
    let pattern = Pattern::new(&vec![Vertex::coordinates(D as u8); mesh.points.len()], cells.cliques().iter().map(|clique| &clique[..]));
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
