//! Cells with repeated nodes: every way in which nodes of a cell may be equal, with the numbers of those that leave another kind of cell.
//!
//! Oracles: the volume of the cell as it is written, by quadrature of its mapping; and the numbers. A hexahedron is a wedge where two
//! opposite edges of a face collapse (6 faces, 2 pairs each); pyramids and tetrahedra were counted by another program among the closed
//! surfaces of the facets that remain. A wedge is a pyramid where an edge between its triangles collapses (3), a tetrahedron where two of
//! these do (3), one with an edge of a triangle opposite to it (6), or a triangle (2); a pyramid is a tetrahedron where an edge of its base
//! collapses (4), a quadrilateral a triangle where an edge does (4).

use std::collections::BTreeMap;

use conserva::elements::CellKind;
use conserva::mesh::{Mesh, MeshError, read_mesh_bytes};

/// All ways in which `count` things are equal to earlier ones: the first equal one of each.
fn partitions(count: usize) -> Vec<Vec<usize>> {
    let mut all = vec![Vec::new()];
    for next in 0..count {
        let longer = |known: &Vec<usize>| -> Vec<Vec<usize>> {
            let firsts = (0..next).filter(|&k| known[k] == k).chain([next]);
            firsts.map(|first| known.iter().copied().chain([first]).collect()).collect()
        };
        all = all.iter().flat_map(longer).collect();
    }
    all
}

/// Places of the corners of a cell, out of order so that no facet is plane.
fn places(kind: CellKind) -> Vec<[f64; 3]> {
    let moved = |(k, [x, y, z]): (usize, &[f64; 3])| {
        let by = |step: f64| 0.1 * (step * (k as f64 + 1.0)).sin();
        if kind.dimension() == 2 { [x + by(1.0), y + by(2.0), 0.0] } else { [x + by(1.0), y + by(2.0), z + by(3.0)] }
    };
    kind.row().node_places.iter().enumerate().map(moved).collect()
}

/// A file of Medit with one cell.
fn file(kind: CellKind, points: &[[f64; 3]], nodes: &[usize]) -> String {
    let section = match kind {
        CellKind::Quad4 => "Quadrilaterals",
        CellKind::Hex8 => "Hexahedra",
        CellKind::Wedge6 => "Prisms",
        _ => "Pyramids",
    };
    let points: Vec<String> = points.iter().map(|[x, y, z]| format!("{x} {y} {z} 0")).collect();
    let nodes: Vec<String> = nodes.iter().map(|node| (node + 1).to_string()).collect();
    let (count, points, nodes) = (points.len(), points.join("\n"), nodes.join(" "));
    format!("MeshVersionFormatted 2\nDimension 3\nVertices\n{count}\n{points}\n{section}\n1\n{nodes} 0\nEnd\n")
}

#[test]
fn cells_with_repeated_nodes_are_what_is_left_of_them_or_refused() {
    use CellKind::{Hex8, Pyr5, Quad4, Tet4, Tri3, Wedge6};
    // kinds with their numbers, cells that are inside out at these places, and all ways (Bell's numbers)
    for (kind, expected, inside_out, all) in [
        (Quad4, vec![(Tri3, 4)], 0, 15),
        (Hex8, vec![(Tet4, 100), (Wedge6, 12), (Pyr5, 54)], 2, 4140),
        (Wedge6, vec![(Tet4, 11), (Pyr5, 3)], 0, 203),
        (Pyr5, vec![(Tet4, 4)], 0, 52),
    ] {
        let points = places(kind);
        let (mut counts, mut refused, mut inverted) = (BTreeMap::new(), 0, 0);
        for nodes in partitions(points.len()).into_iter().filter(|nodes| nodes.iter().enumerate().any(|(k, &first)| k != first)) {
            let written = Mesh::new(kind, points.clone(), nodes.iter().map(|&node| node as u32).collect()).measure();
            match read_mesh_bytes(file(kind, &points, &nodes).as_bytes()) {
                Ok(mesh) => {
                    let volume = mesh.measure();
                    assert!((volume - written).abs() < 1e-12, "{kind:?} {nodes:?}: {volume} for {written}");
                    *counts.entry(mesh.only_kind().unwrap()).or_insert(0) += 1;
                }
                Err(MeshError::InvertedCell { .. }) => {
                    assert!(written < 0.0, "{kind:?} {nodes:?}: {written}");
                    inverted += 1;
                }
                Err(error) => {
                    assert!(error.code() == "C0837" && error.line().is_some(), "{kind:?} {nodes:?}: {error}");
                    refused += 1;
                }
            }
        }
        assert_eq!((counts.into_iter().collect::<Vec<_>>(), inverted), (expected.clone(), inside_out), "{kind:?}");
        let read: usize = expected.iter().map(|(_, count)| count).sum();
        assert_eq!(refused + read + inverted, all - 1, "{kind:?}");
    }
}
