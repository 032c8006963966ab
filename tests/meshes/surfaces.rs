//! Faulty surfaces of triangles: repaired and refused cases.

use std::collections::BTreeMap;

use conserva::contact::{Facets, FacetsError, Mending};

type Triangle = [u32; 3];

/// True if every edge has two triangles.
fn is_closed(facets: &Facets) -> bool {
    let mut edges: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for nodes in facets.triangles() {
        for (a, b) in (0..3).map(|k| (nodes[k], nodes[(k + 1) % 3])) {
            *edges.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
    }
    edges.values().all(|count| *count == 2)
}

/// A unit cube of twelve triangles with points of their own.
fn cube() -> (Vec<[f64; 3]>, Vec<Triangle>) {
    let facets = Facets::cuboid([0.0; 3], [1.0; 3]).unwrap();
    let points = facets.triangles().iter().flatten().map(|&node| facets.points()[node as usize]).collect();
    (points, (0..12).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect())
}

fn volume(facets: &Facets) -> f64 {
    let at = |node: u32| facets.points()[node as usize];
    let triple = |[a, b, c]: [[f64; 3]; 3]| {
        a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    };
    facets.triangles().iter().map(|nodes| triple(nodes.map(at)) / 6.0).sum()
}

#[test]
fn sound_surfaces_stay_as_they_are() {
    let (points, triangles) = cube();
    let (facets, mending) = Facets::mended(&points, &triangles).unwrap();
    assert_eq!((facets, mending), (Facets::new(&points, &triangles).unwrap(), Mending::default()));
}

#[test]
fn turned_doubled_and_flat_triangles_and_points_apart_are_mended() {
    let (mut points, mut triangles) = cube();
    triangles[3].swap(0, 1);
    triangles[8].swap(0, 1);
    triangles.push(triangles[0]);
    // a point of one triangle has the round-off of a file with six digits
    points[15][0] += 3e-8;
    let (facets, mending) = Facets::mended(&points, &triangles).unwrap();
    assert_eq!(mending, Mending { joined: 1, slivers: 0, doubled: 1, turned: 2 });
    assert_eq!(facets.triangles().len(), 12);
    assert!((volume(&facets) - 1.0).abs() < 1e-6);
    assert_eq!(mending.to_string(), "1 point joined with another, 1 triangle on another taken out, 2 triangles turned");
}

#[test]
fn a_sliver_leaves_no_gap() {
    // the first edge of the first triangle is split at its middle on one side, a flat triangle fills the gap, and another triangle is
    // reversed
    let (mut points, mut triangles) = cube();
    let [a, b, c] = [0, 1, 2].map(|k| points[k]);
    let middle = [0, 1, 2].map(|i| 0.5 * (a[i] + b[i]));
    points.push(middle);
    let m = points.len() as u32 - 1;
    let [first, second, third] = triangles[0];
    assert_eq!(points[third as usize], c);
    triangles[0] = [first, m, third];
    triangles.push([m, second, third]);
    triangles.push([first, second, m]);
    triangles[5].swap(0, 1);
    let (facets, mending) = Facets::mended(&points, &triangles).unwrap();
    assert_eq!(mending, Mending { joined: 0, slivers: 1, doubled: 0, turned: 1 });
    assert!((volume(&facets) - 1.0).abs() < 1e-12 && is_closed(&facets));
}

#[test]
fn what_has_no_one_repair_is_refused_with_its_place() {
    // a fin on an edge of the cube
    let (mut points, mut triangles) = cube();
    points.extend([points[0], points[1], [5.0, 5.0, 5.0]]);
    triangles.push([36, 37, 38]);
    let error = Facets::mended(&points, &triangles).unwrap_err();
    assert!(matches!(error, FacetsError::Turned(_)));
    // half of the triangles face inward
    let (points, mut triangles) = cube();
    triangles[..6].iter_mut().for_each(|triangle| triangle.swap(0, 1));
    assert!(matches!(Facets::mended(&points, &triangles), Err(FacetsError::Turned(_))));
}
