//! What every row of the catalogue of cell kinds promises: shape functions, quadrature and facets (Hughes, The Finite Element Method, 2000,
//! chapter 3).

use conserva::elements::{CellKind, CellRow};
use nalgebra::Vector3;

use crate::common::Random;

/// Sums of a few terms of order one.
const ROUND_OFF: f64 = 1e-14;

/// The corner of the reference cell `[-1, 1]^D` at which each node's shape function is one; what is beyond the dimension is zero.
fn corners(row: &CellRow) -> Vec<[f64; 3]> {
    let dimension = row.dimension;
    let coordinate = |k: usize, i: usize| if i >= dimension { 0.0 } else { [-1.0, 1.0][k >> i & 1] };
    let mut found = vec![[f64::NAN; 3]; row.nodes];
    for corner in (0..1 << dimension).map(|k| std::array::from_fn(|i| coordinate(k, i))) {
        let values = (row.shape)(corner);
        let node = values.iter().position(|value| *value == 1.0).expect("one node stands at every corner");
        assert!(values.iter().enumerate().all(|(a, value)| a == node || *value == 0.0), "no other reaches there");
        found[node] = corner;
    }
    assert!(found.iter().all(|corner| corner[0].is_finite()), "every node stands at a corner");
    found
}

fn shape_functions(row: &CellRow) {
    let corners = corners(row);
    let mut random = Random(1);
    for _ in 0..20 {
        let xi: [f64; 3] = std::array::from_fn(|i| if i < row.dimension { random.next() } else { 0.0 });
        let (values, gradients) = ((row.shape)(xi), (row.gradients)(xi));
        assert_eq!((values.len(), gradients.len()), (row.nodes, row.nodes));
        assert!((values.iter().sum::<f64>() - 1.0).abs() < ROUND_OFF, "partition of unity");
        for i in 0..row.dimension {
            let interpolated: f64 = values.iter().zip(&corners).map(|(value, corner)| value * corner[i]).sum();
            assert!((interpolated - xi[i]).abs() < ROUND_OFF, "a linear field is represented");
            assert!(gradients.iter().map(|gradient| gradient[i]).sum::<f64>().abs() < ROUND_OFF, "gradients sum to zero");
            // Linear in each coordinate, so that a difference of any size is exact.
            let (mut up, mut down) = (xi, xi);
            up[i] += 0.5;
            down[i] -= 0.5;
            for (a, (up, down)) in (row.shape)(up).iter().zip((row.shape)(down)).enumerate() {
                assert!((up - down - gradients[a][i]).abs() < ROUND_OFF, "gradient {i} of node {a}");
            }
        }
    }
}

/// Exact for every product of powers that the row promises, and not for the next even one.
fn quadrature(row: &CellRow) {
    let (dimension, promised) = (row.dimension as u32, row.exact_power);
    let exact = |power: usize| if power.is_multiple_of(2) { 2.0 / (power + 1) as f64 } else { 0.0 };
    let rule = |powers: &[usize]| -> f64 {
        (row.quadrature)().iter().map(|(xi, w)| w * powers.iter().zip(xi).map(|(&power, x)| x.powi(power as i32)).product::<f64>()).sum()
    };
    for k in 0..(promised + 1).pow(dimension) {
        let powers: Vec<usize> = (0..dimension).map(|i| k / (promised + 1).pow(i) % (promised + 1)).collect();
        let integral: f64 = powers.iter().map(|&power| exact(power)).product();
        assert!((rule(&powers) - integral).abs() < ROUND_OFF, "{powers:?}");
    }
    let mut next = vec![0; row.dimension];
    next[0] = (promised + 1).next_multiple_of(2);
    assert!((rule(&next) - exact(next[0]) * 2f64.powi(dimension as i32 - 1)).abs() > 0.1);
}

/// Facets tile the hull and look outward: with the cell on the left in the plane, by the right hand in space.
fn facets(row: &CellRow) {
    let (corners, dimension) = (corners(row), row.dimension);
    assert_eq!(row.facets.len(), 2 * dimension);
    let mut normals = Vec::new();
    for facet in row.facets {
        assert_eq!(facet.len(), 1 << (dimension - 1));
        let x = |local: usize| Vector3::from(corners[facet[local]]);
        let area = if dimension == 2 {
            let along = x(1) - x(0);
            Vector3::new(along.y, -along.x, 0.0)
        } else {
            (x(2) - x(0)).cross(&(x(3) - x(1))) * 0.5
        };
        let center = (0..facet.len()).map(x).sum::<Vector3<f64>>() / facet.len() as f64;
        // The facet of the cube [-1, 1]^D through `center` has measure 2^(D-1) and the normal `center`.
        assert!((area - center * (1 << (dimension - 1)) as f64).norm() < ROUND_OFF, "facet {facet:?} looks outward");
        normals.push(center);
    }
    assert!(normals.iter().sum::<Vector3<f64>>().norm() < ROUND_OFF, "the hull is closed");
}

#[test]
fn every_cell_kind_fulfils_the_contract() {
    for (index, kind) in CellKind::ALL.iter().enumerate() {
        assert!(CellKind::ALL[..index].iter().all(|other| other.name() != kind.name()), "{} has a name of its own", kind.name());
        shape_functions(kind.row());
        quadrature(kind.row());
        facets(kind.row());
    }
}
