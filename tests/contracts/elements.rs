//! Contract of every row of the catalogue of cell kinds: shape functions, quadrature, mass and facets (Hughes, The Finite Element Method,
//! 2000, chapter 3).

use conserva::bodies::{BodyCells, Elements, Formulation, Space};
use conserva::elements::{CellKind, CellRow, CellShape};
use conserva::linear::{NodeMatrix, Pattern, Vertex};
use conserva::materials::NeoHookean;
use conserva::mesh::Mesh;
use nalgebra::{Matrix3, Vector3};

use crate::common::Random;

/// Sums of a few terms of order one.
const ROUND_OFF: f64 = 1e-14;

fn shape_functions(row: &CellRow) {
    for (node, &place) in row.node_places.iter().enumerate() {
        for (a, value) in (row.shape)(place).into_iter().enumerate() {
            assert_eq!(value, f64::from(u8::from(a == node)), "{}: one at its node, zero at the others", row.name);
        }
    }
    let mut random = Random(1);
    for _ in 0..20 {
        let xi: [f64; 3] = std::array::from_fn(|i| if i < row.dimension { random.next() } else { 0.0 });
        let (values, gradients) = ((row.shape)(xi), (row.gradients)(xi));
        assert_eq!((values.len(), gradients.len()), (row.nodes, row.nodes));
        assert!((values.iter().sum::<f64>() - 1.0).abs() < ROUND_OFF, "partition of unity");
        for i in 0..row.dimension {
            let place = |xi: [f64; 3]| row.cell_shape.place(xi)[i];
            let interpolated: f64 = values.iter().zip(row.node_places).map(|(value, &at)| value * place(at)).sum();
            assert!((interpolated - place(xi)).abs() < ROUND_OFF, "a linear field is represented");
            assert!(gradients.iter().map(|gradient| gradient[i]).sum::<f64>().abs() < ROUND_OFF, "gradients sum to zero");
            // At most quadratic in each coordinate (`pyr13`: in zeta along the edges), so that a central difference of any size is exact.
            let (mut up, mut down) = (xi, xi);
            up[i] += 0.5;
            down[i] -= 0.5;
            for (a, (up, down)) in (row.shape)(up).iter().zip((row.shape)(down)).enumerate() {
                assert!((up - down - gradients[a][i]).abs() < ROUND_OFF, "{}: gradient {i} of node {a}", row.name);
            }
        }
    }
}

fn factorial(n: usize) -> f64 {
    (1..=n).map(|k| k as f64).product()
}

/// Integral of a product of powers of the reference coordinates: over a simplex, over a triangle by an interval, over a cube.
fn exact(row: &CellRow, powers: &[usize]) -> f64 {
    let simplex = |powers: &[usize]| {
        powers.iter().map(|&power| factorial(power)).product::<f64>() / factorial(powers.iter().sum::<usize>() + powers.len())
    };
    let product = |powers: &[usize]| -> f64 {
        powers.iter().map(|&power| if power.is_multiple_of(2) { 2.0 / (power + 1) as f64 } else { 0.0 }).product()
    };
    match row.cell_shape {
        CellShape::Wedge => simplex(&powers[..2]) * product(&powers[2..]),
        shape if shape.is_simplex() => simplex(powers),
        _ => product(powers),
    }
}

/// Quadrature is exact for every product of powers that the row states, and not for the next one.
fn quadrature(row: &CellRow) {
    let (dimension, promised) = (row.dimension, row.exact_power);
    let is_total = row.cell_shape.is_simplex() || row.cell_shape == CellShape::Wedge;
    let rule = |powers: &[usize]| -> f64 {
        (row.quadrature)().iter().map(|(xi, w)| w * powers.iter().zip(xi).map(|(&power, x)| x.powi(power as i32)).product::<f64>()).sum()
    };
    for k in 0..(promised + 1).pow(dimension as u32) {
        let powers: Vec<usize> = (0..dimension).map(|i| k / (promised + 1).pow(i as u32) % (promised + 1)).collect();
        if !is_total || powers.iter().sum::<usize>() <= promised {
            assert!((rule(&powers) - exact(row, &powers)).abs() < ROUND_OFF, "{}: {powers:?}", row.name);
        }
    }
    let mut next = vec![0; dimension];
    next[0] = if is_total { promised + 1 } else { (promised + 1).next_multiple_of(2) };
    assert!((rule(&next) - exact(row, &next)).abs() > 1e-4, "{}", row.name);
}

/// Determinant of the Jacobian of the reference cell: 1 except in a pyramid.
fn determinant(row: &CellRow, xi: [f64; 3]) -> f64 {
    if row.dimension == 2 {
        return 1.0;
    }
    let mut jacobian = Matrix3::zeros();
    for (gradient, &place) in (row.gradients)(xi).into_iter().zip(row.node_places) {
        jacobian += Vector3::from(row.cell_shape.place(place)) * Vector3::from(gradient).transpose();
    }
    jacobian.determinant()
}

/// Points and weights over the reference cell, exact for the products of two shape functions: five Gauss points in each direction of a
/// cube, folded into a simplex (Duffy 1982).
fn fine_rule(row: &CellRow) -> Vec<([f64; 3], f64)> {
    let gauss = [
        (0.0, 128.0 / 225.0),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
        (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
        (0.906_179_845_938_664, 0.236_926_885_056_189_08),
        (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
    ];
    let mut rule = Vec::new();
    for k in 0..5usize.pow(row.dimension as u32) {
        let pick = |i: u32| gauss[k / 5usize.pow(i) % 5];
        let mut weight: f64 = (0..row.dimension as u32).map(|i| pick(i).1).product();
        let mut xi: [f64; 3] = std::array::from_fn(|i| if i < row.dimension { pick(i as u32).0 } else { 0.0 });
        let folded = if row.cell_shape == CellShape::Wedge { 2 } else { row.dimension };
        if row.cell_shape.is_simplex() || row.cell_shape == CellShape::Wedge {
            let mut left = 1.0;
            for (i, x) in xi.iter_mut().enumerate().take(folded) {
                let unit = 0.5 * (1.0 + *x);
                *x = unit * left;
                left *= 1.0 - unit;
                weight *= 0.5 * (1.0 - unit).powi((folded - 1 - i) as i32);
            }
        }
        // of a pyramid, whose coordinates are those of a cube
        weight *= determinant(row, xi);
        rule.push((xi, weight));
    }
    rule
}

/// Consistent mass of the reference cell.
fn mass(kind: CellKind) {
    let row = kind.row();
    let connectivity: Vec<u32> = (0..row.nodes as u32).collect();
    let mesh = Mesh::new(kind, row.node_places.iter().map(|&place| row.cell_shape.place(place)).collect(), connectivity);
    let material = NeoHookean { youngs_modulus: 1.0, poisson_ratio: 0.0, density: 3.0 }.material().expect("in range");
    let pattern = |dimension: u8, cliques: &[Vec<u32>]| {
        Pattern::new(&vec![Vertex::coordinates(dimension); row.nodes], cliques.iter().map(|clique| &clique[..]))
    };
    let mass = if row.dimension == 2 {
        let elements = Space::<2>::elements(&BodyCells::new(&mesh, &material, Formulation::default())).expect("no cell is inside out");
        let mut mass = NodeMatrix::new(&pattern(2, elements.cliques()), row.nodes);
        elements.add_mass(&mut mass);
        mass
    } else {
        let elements = Space::<3>::elements(&BodyCells::new(&mesh, &material, Formulation::default())).expect("no cell is inside out");
        let mut mass = NodeMatrix::new(&pattern(3, elements.cliques()), row.nodes);
        elements.add_mass(&mut mass);
        mass
    };
    let rule = fine_rule(row);
    for (a, b, entry) in mass.entries() {
        let product = |xi: [f64; 3]| {
            let shapes = (row.shape)(xi);
            shapes[a as usize] * shapes[b as usize]
        };
        let expected: f64 = rule.iter().map(|&(xi, weight)| 3.0 * weight * product(xi)).sum();
        assert!((entry - expected).abs() < 1e-13, "{}: mass ({a}, {b}) {entry} {expected}", row.name);
    }
}

/// Facets cover the hull with outward normals: cell on the left in the plane, right-hand rule in space.
fn facets(row: &CellRow) {
    let corners = row.cell_shape.corners();
    let place = |local: usize| Vector3::from(row.cell_shape.place(row.node_places[local]));
    let (mut sum, mut volume) = (Vector3::zeros(), 0.0);
    for facet in row.facets {
        let ends: Vec<usize> = facet.iter().copied().filter(|&local| local < corners).collect();
        let x = |k: usize| place(ends[k]);
        let area = match (row.dimension, ends.len()) {
            (2, _) => Vector3::new((x(1) - x(0)).y, -(x(1) - x(0)).x, 0.0),
            (_, 3) => (x(1) - x(0)).cross(&(x(2) - x(0))) * 0.5,
            _ => (x(2) - x(0)).cross(&(x(3) - x(1))) * 0.5,
        };
        let center = (0..ends.len()).map(x).sum::<Vector3<f64>>() / ends.len() as f64;
        if let (2, &[from, to, middle]) = (row.dimension, *facet) {
            assert!((place(middle) - (place(from) + place(to)) * 0.5).norm() < ROUND_OFF, "the middle node follows the ends");
        }
        sum += area;
        volume += area.dot(&center) / row.dimension as f64;
    }
    assert!(sum.norm() < ROUND_OFF, "{}: the hull is closed", row.name);
    // Divergence theorem with outward normals.
    let measure: f64 = (row.quadrature)().into_iter().map(|(xi, weight)| weight * determinant(row, xi)).sum();
    assert!((volume - measure).abs() < ROUND_OFF, "{}: {volume}", row.name);
}

#[test]
fn every_cell_kind_fulfils_the_contract() {
    for (index, kind) in CellKind::ALL.iter().enumerate() {
        assert!(CellKind::ALL[..index].iter().all(|other| other.name() != kind.name()), "{} has a name of its own", kind.name());
        shape_functions(kind.row());
        quadrature(kind.row());
        mass(*kind);
        facets(kind.row());
    }
}
