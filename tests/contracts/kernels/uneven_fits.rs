//! Press fits of unlike meshes: which of them are reported as uneven.

use conserva::contact::{ProxySurfacesInSpace, UnevenFit, uneven_fit};
use conserva::elements::CellKind;
use conserva::mesh::{Mesh, Round, hollow_sphere, tube};

/// Press fit of full tubes or hollow spheres of the radius 1 with such numbers of cells around; the first is secondary.
fn found(kind: CellKind, is_sphere: bool, around: [usize; 2], is_hub: bool, fit: f64) -> UnevenFit {
    let radii = [[0.5, 1.0 + fit], [1.0, 1.5]];
    let mesh = |side: usize, around: usize| -> Mesh {
        let made = match is_sphere {
            true => hollow_sphere(radii[side], [1, around], [0.0; 3], 1.0),
            false => tube(radii[side], 0.2, [1, around, 1], [0.0; 3], [1.0; 2]),
        };
        let round = if is_sphere { Round::AboutPoint([0.0; 3]) } else { Round::About([0.0; 2]) };
        made.and_then(|mesh| mesh.with_round_cells(kind, round)).expect("it is a mesh")
    };
    let sides = if is_hub { [1, 0] } else { [0, 1] };
    let meshes = [mesh(sides[0], around[0]), mesh(sides[1], around[1])];
    let q: Vec<f64> = meshes.iter().flat_map(|mesh| &mesh.points).flatten().copied().collect();
    let first = [0, meshes[0].points.len() as u32];
    let faces = [0, 1].map(|k| -> Vec<Vec<u32>> {
        let boundary = meshes[k].boundary(["outer", "inner"][sides[k]]).expect("it has one");
        boundary.facets.iter().map(|&facet| meshes[k].facet_nodes(facet).map(|node| node + first[k]).collect()).collect()
    });
    uneven_fit(&ProxySurfacesInSpace::new(faces.each_ref().map(|faces| &faces[..]), &q), &q).expect("they overlap")
}

/// Measured error of nodal pressures in quarter tubes of `hex8`, 9 on 5 cells, with the finer side as secondary and an interference of 1e-4
/// of the radius: 3.1 %; 0.5 % with 1e-3, with the coarser side, and with 7 on 5 cells. Matching meshes overlap evenly.
#[test]
fn overlaps_of_unlike_meshes_are_uneven() {
    let of = |around, is_hub, fit| found(CellKind::Hex8, false, around, is_hub, fit);
    let fine = of([36, 20], false, 1e-4);
    assert!((fine.interference / 1e-4 - 1.0).abs() < 0.05, "{fine:?}");
    assert!(fine.pressure_error > 0.022 && fine.pressure_error < 0.047 && fine.is_distorted(), "{fine:?}");
    let small = of([36, 20], false, 1e-5);
    assert!((small.pressure_error / fine.pressure_error / 10.0 - 1.0).abs() < 0.25, "{small:?} {fine:?}");
    assert!(!of([36, 20], false, 1e-3).is_distorted() && !of([20, 36], true, 1e-4).is_distorted());
    assert!(!of([28, 20], false, 1e-4).is_distorted() && !of([48, 40], false, 1e-4).is_distorted());
    assert!(of([28, 28], false, 1e-4).pressure_error < 1e-3);
}

/// Measured errors in quarter tubes (root mean square): of `hex8` 3.1, 19, 6.7 and 5.0 % for an interference of 1e-4 with 9, 10, 12 and 17
/// on 5 or 4 cells, of `tet10` 2.3 % for 1e-5 with 17 on 5 cells. The other fits have less than 1.6 %; `hex8`, 10 on 4 cells, has 1.9 % for
/// 1e-3, at the bound.
#[test]
fn unlike_meshes_are_reported_where_pressures_are_wrong() {
    let is_reported = |kind, cells: [usize; 2], fit: f64| found(kind, false, cells.map(|n| 4 * n), cells[0] < cells[1], fit).is_distorted();
    let of_first = |cells, fit| is_reported(CellKind::Hex8, cells, fit);
    assert!([[9, 5], [10, 4], [12, 5], [17, 5]].into_iter().all(|cells| of_first(cells, 1e-4)));
    assert!([[7, 5], [9, 5], [12, 5], [17, 5]].into_iter().all(|cells| !of_first(cells, 1e-3)));
    assert!([[7, 5], [9, 6], [12, 8], [12, 10], [13, 9], [16, 11]].into_iter().all(|cells| !of_first(cells, 1e-4)));
    for kind in [CellKind::Hex20, CellKind::Hex27] {
        for fit in [1e-3, 1e-4, 1e-5] {
            assert!([[9, 5], [10, 4], [17, 5]].into_iter().all(|cells| !is_reported(kind, cells, fit)), "{kind:?}, {fit}");
        }
    }
    assert!(!is_reported(CellKind::Tet10, [17, 5], 1e-4) && is_reported(CellKind::Tet10, [17, 5], 1e-5));
}

/// Spheres of six blocks: facets of first order of 16 cells around are too coarse for a thousandth of the radius (measured: 5.7 %), those
/// of `tet10` for less. Those of `hex20` follow the sphere (measured in octants: 1.0 % for every interference).
#[test]
fn coarse_spheres_are_uneven() {
    assert!(found(CellKind::Hex8, true, [24, 16], false, 1e-3).is_distorted());
    for fit in [1e-2, 1e-3, 1e-5] {
        let found = found(CellKind::Hex20, true, [24, 16], false, fit);
        assert!(found.pressure_error > 0.005 && !found.is_distorted(), "{found:?}");
    }
    assert!(found(CellKind::Tet10, true, [24, 16], false, 1e-5).is_distorted());
}
