//! What every cell kind promises: shape functions, quadrature and facets (Hughes, The Finite Element Method, 2000, chapter 3).

use conserva::elements::{CellKind, Hex8, Quad4, ReferenceCell};

use crate::common::Random;

/// Sums of a few terms of order one.
const ROUND_OFF: f64 = 1e-14;

/// The corner of the reference cell `[-1, 1]^D` at which each node's shape function is one.
fn corners<C: ReferenceCell<D, A, Q>, const D: usize, const A: usize, const Q: usize>() -> Vec<[f64; D]> {
    let all = (0..1 << D).map(|k| std::array::from_fn::<f64, D, _>(|i| if k >> i & 1 == 0 { -1.0 } else { 1.0 }));
    let mut found = vec![[f64::NAN; D]; A];
    for corner in all {
        let values = C::shape(corner);
        let node = values.iter().position(|value| *value == 1.0).expect("one node stands at every corner");
        assert!(values.iter().enumerate().all(|(a, value)| a == node || *value == 0.0), "no other reaches there");
        found[node] = corner;
    }
    assert!(found.iter().all(|corner| corner[0].is_finite()), "every node stands at a corner");
    found
}

fn shape_functions<C: ReferenceCell<D, A, Q>, const D: usize, const A: usize, const Q: usize>() {
    let corners = corners::<C, D, A, Q>();
    let mut random = Random(1);
    for _ in 0..20 {
        let xi: [f64; D] = std::array::from_fn(|_| random.next());
        let (values, gradients) = (C::shape(xi), C::gradients(xi));
        assert!((values.iter().sum::<f64>() - 1.0).abs() < ROUND_OFF, "partition of unity");
        for i in 0..D {
            let interpolated: f64 = (0..A).map(|a| values[a] * corners[a][i]).sum();
            assert!((interpolated - xi[i]).abs() < ROUND_OFF, "a linear field is represented");
            assert!((0..A).map(|a| gradients[a][i]).sum::<f64>().abs() < ROUND_OFF, "gradients sum to zero");
            // Linear in each coordinate, so that a difference of any size is exact.
            let (mut up, mut down) = (xi, xi);
            up[i] += 0.5;
            down[i] -= 0.5;
            for (a, (up, down)) in C::shape(up).iter().zip(C::shape(down)).enumerate() {
                assert!((up - down - gradients[a][i]).abs() < ROUND_OFF, "gradient {i} of node {a}");
            }
        }
    }
}

/// Exact for every product of powers up to three, which is all that two Gauss points in each direction can do: the power four is not.
fn quadrature<C: ReferenceCell<D, A, Q>, const D: usize, const A: usize, const Q: usize>() {
    let exact = |power: i32| if power % 2 == 0 { 2.0 / (power + 1) as f64 } else { 0.0 };
    let rule = |powers: [i32; D]| -> f64 {
        C::quadrature().iter().map(|(xi, w)| w * (0..D).map(|i| xi[i].powi(powers[i])).product::<f64>()).sum()
    };
    for k in 0..4usize.pow(D as u32) {
        let powers: [i32; D] = std::array::from_fn(|i| (k / 4usize.pow(i as u32) % 4) as i32);
        let integral: f64 = powers.iter().map(|&power| exact(power)).product();
        assert!((rule(powers) - integral).abs() < ROUND_OFF, "{powers:?}");
    }
    let mut fourth = [0; D];
    fourth[0] = 4;
    assert!((rule(fourth) - exact(4) * 2f64.powi(D as i32 - 1)).abs() > 0.1);
}

/// Facets tile the hull and look outward: with the cell on the left in the plane, by the right hand in space.
fn facets<C: ReferenceCell<D, A, Q>, const D: usize, const A: usize, const Q: usize>() {
    let (corners, kind) = (corners::<C, D, A, Q>(), C::KIND);
    assert_eq!((kind.dimension(), kind.nodes(), kind.facets().len()), (D, A, 2 * D));
    let mut normals = Vec::new();
    for facet in kind.facets() {
        assert_eq!(facet.len(), 1 << (D - 1));
        let x = |local: usize| nalgebra::Vector3::from_fn(|i, _| if i < D { corners[facet[local]][i] } else { 0.0 });
        let area = if D == 2 {
            let along = x(1) - x(0);
            nalgebra::Vector3::new(along.y, -along.x, 0.0)
        } else {
            (x(2) - x(0)).cross(&(x(3) - x(1))) * 0.5
        };
        let center = (0..facet.len()).map(x).sum::<nalgebra::Vector3<f64>>() / facet.len() as f64;
        // The facet of the cube [-1, 1]^D through `center` has measure 2^(D-1) and the normal `center`.
        assert!((area - center * (1 << (D - 1)) as f64).norm() < ROUND_OFF, "facet {facet:?} looks outward");
        normals.push(center);
    }
    assert!(normals.iter().sum::<nalgebra::Vector3<f64>>().norm() < ROUND_OFF, "the hull is closed");
}

#[test]
fn every_cell_kind_fulfils_the_contract() {
    fn contract<C: ReferenceCell<D, A, Q>, const D: usize, const A: usize, const Q: usize>(kind: CellKind) {
        assert_eq!(C::KIND, kind);
        shape_functions::<C, D, A, Q>();
        quadrature::<C, D, A, Q>();
        facets::<C, D, A, Q>();
    }
    for &kind in CellKind::ALL {
        match kind {
            CellKind::Quad4 => contract::<Quad4, 2, 4, 4>(kind),
            CellKind::Hex8 => contract::<Hex8, 3, 8, 8>(kind),
        }
    }
}
