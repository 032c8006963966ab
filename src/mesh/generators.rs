//! Structured meshes with straight sides: rectangle and block.
//!
//! Each is a grid of cells; the names of its boundaries are fixed. Plane boundaries are traversed with the body on the left, so that each
//! facet begins at the end of the previous one.

use super::grid::{at_least, boundary, graded, limited, positive};
use super::{Facet, Mesh, MeshError};
use crate::elements::CellKind;

/// A rectangle of quad4 cells, `size` and `origin` (its lower left corner) `[length]`; boundaries `left right bottom top`.
///
/// Nodes run along x first, from the bottom row up; so do cells.
///
/// # Errors
/// Sizes that are not positive, counts of zero, numbers that are not finite, too many cells.
pub fn rectangle(size: [f64; 2], cells: [usize; 2], origin: [f64; 2]) -> Result<Mesh, MeshError> {
    graded_rectangle(size, cells, origin, [1.0; 2])
}

/// [`rectangle`] with cells that grow in geometric progression: along the width and the height the last is `grading` times the first.
///
/// # Errors
/// Errors of [`rectangle`]; ratios that are not positive, or so far from 1 that cells vanish.
pub fn graded_rectangle(size: [f64; 2], cells: [usize; 2], origin: [f64; 2], grading: [f64; 2]) -> Result<Mesh, MeshError> {
    positive("the width of a rectangle", size[0])?;
    positive("the height of a rectangle", size[1])?;
    at_least("along the width", cells[0], 1)?;
    at_least("along the height", cells[1], 1)?;
    limited(&cells)?;
    let [nx, ny] = cells;
    let node = |i: usize, j: usize| (j * (nx + 1) + i) as u32;
    let (xs, ys) = (graded(nx, grading[0])?, graded(ny, grading[1])?);
    let points = ys.iter().flat_map(|y| xs.iter().map(move |x| [origin[0] + size[0] * x, origin[1] + size[1] * y, 0.0])).collect();
    let connectivity =
        (0..ny).flat_map(|j| (0..nx).flat_map(move |i| [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)])).collect();
    let facet = |i: usize, j: usize, local: u8| Facet { cell: (j * nx + i) as u32, local };
    let boundaries = vec![
        boundary("left", (0..ny).rev().map(|j| facet(0, j, 3))),
        boundary("right", (0..ny).map(|j| facet(nx - 1, j, 1))),
        boundary("bottom", (0..nx).map(|i| facet(i, 0, 0))),
        boundary("top", (0..nx).rev().map(|i| facet(i, ny - 1, 2))),
    ];
    Mesh { boundaries, ..Mesh::new(CellKind::Quad4, points, connectivity) }.checked()
}

/// A block of hex8 cells, `size` and `origin` (its corner of least coordinates) `[length]`; boundaries `left right` (x),
/// `bottom top` (y), `back front` (z), the lesser coordinate first.
///
/// Nodes run along x first, then y, then z; so do cells.
///
/// # Errors
/// Sizes that are not positive, counts of zero, numbers that are not finite, too many cells.
pub fn block(size: [f64; 3], cells: [usize; 3], origin: [f64; 3]) -> Result<Mesh, MeshError> {
    graded_block(size, cells, origin, [1.0; 3])
}

/// [`block`] with cells that grow in geometric progression: along each direction the last is `grading` times the first.
///
/// # Errors
/// Errors of [`block`]; ratios that are not positive, or so far from 1 that cells vanish.
pub fn graded_block(size: [f64; 3], cells: [usize; 3], origin: [f64; 3], grading: [f64; 3]) -> Result<Mesh, MeshError> {
    for (what, value) in ["the width of a block", "the height of a block", "the depth of a block"].into_iter().zip(size) {
        positive(what, value)?;
    }
    for (direction, count) in ["along the width", "along the height", "along the depth"].into_iter().zip(cells) {
        at_least(direction, count, 1)?;
    }
    limited(&cells)?;
    let [nx, ny, nz] = cells;
    let mut points = Vec::with_capacity((nx + 1) * (ny + 1) * (nz + 1));
    let [xs, ys, zs] = [graded(nx, grading[0])?, graded(ny, grading[1])?, graded(nz, grading[2])?];
    for z in &zs {
        for y in &ys {
            points.extend(xs.iter().map(|x| [origin[0] + size[0] * x, origin[1] + size[1] * y, origin[2] + size[2] * z]));
        }
    }
    let node = |i: usize, j: usize, k: usize| ((k * (ny + 1) + j) * (nx + 1) + i) as u32;
    let mut connectivity = Vec::with_capacity(8 * nx * ny * nz);
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                for layer in [k, k + 1] {
                    connectivity.extend([node(i, j, layer), node(i + 1, j, layer), node(i + 1, j + 1, layer), node(i, j + 1, layer)]);
                }
            }
        }
    }
    let facet = |i: usize, j: usize, k: usize, local: u8| Facet { cell: ((k * ny + j) * nx + i) as u32, local };
    let pairs = |outer: usize, inner: usize| (0..outer).flat_map(move |b| (0..inner).map(move |a| (a, b)));
    let boundaries = vec![
        boundary("left", pairs(nz, ny).map(|(j, k)| facet(0, j, k, 5))),
        boundary("right", pairs(nz, ny).map(|(j, k)| facet(nx - 1, j, k, 3))),
        boundary("bottom", pairs(nz, nx).map(|(i, k)| facet(i, 0, k, 2))),
        boundary("top", pairs(nz, nx).map(|(i, k)| facet(i, ny - 1, k, 4))),
        boundary("back", pairs(ny, nx).map(|(i, j)| facet(i, j, 0, 0))),
        boundary("front", pairs(ny, nx).map(|(i, j)| facet(i, j, nz - 1, 1))),
    ];
    Mesh { boundaries, ..Mesh::new(CellKind::Hex8, points, connectivity) }.checked()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{arc, disk, graded_ring, half_disk, ring};
    use std::f64::consts::{PI, TAU};

    /// Round-off of sums of some hundred terms of order one.
    const ROUND_OFF: f64 = 1e-13;

    fn names(mesh: &Mesh) -> Vec<&str> {
        mesh.boundaries.iter().map(|b| b.name.as_str()).collect()
    }

    /// Asserts that each facet of a plane boundary begins where the previous one ends.
    fn is_traversed(mesh: &Mesh, boundary: &str) -> bool {
        let facets = &mesh.boundary(boundary).unwrap().facets;
        let ends = |facet: Facet| mesh.facet_nodes(facet).collect::<Vec<_>>();
        facets.windows(2).all(|pair| ends(pair[0])[1] == ends(pair[1])[0])
    }

    #[test]
    fn a_rectangle_has_its_area_sides_and_corners() {
        let mesh = rectangle([3.0, 2.0], [5, 4], [-1.0, 0.5]).unwrap();
        assert_eq!((mesh.points.len(), mesh.cell_count()), (30, 20));
        assert_eq!(names(&mesh), ["left", "right", "bottom", "top"]);
        assert!((mesh.measure() - 6.0).abs() < ROUND_OFF);
        let lengths: Vec<f64> = mesh.boundaries.iter().map(|b| mesh.boundary_measure(b)).collect();
        for (length, expected) in lengths.iter().zip([2.0, 2.0, 3.0, 3.0]) {
            assert!((length - expected).abs() < ROUND_OFF);
        }
        for (name, coordinate, value) in [("left", 0, -1.0), ("right", 0, 2.0), ("bottom", 1, 0.5), ("top", 1, 2.5)] {
            let boundary = mesh.boundary(name).unwrap();
            assert!(mesh.boundary_nodes(boundary).iter().all(|&n| mesh.points[n as usize][coordinate] == value), "{name}");
            assert!(is_traversed(&mesh, name), "{name}");
        }
    }

    #[test]
    fn a_block_has_its_volume_and_sides() {
        let mesh = block([3.0, 2.0, 1.0], [3, 2, 2], [0.0, 1.0, -1.0]).unwrap();
        assert_eq!((mesh.points.len(), mesh.cell_count()), (36, 12));
        assert_eq!(names(&mesh), ["left", "right", "bottom", "top", "back", "front"]);
        assert!((mesh.measure() - 6.0).abs() < ROUND_OFF);
        for (name, coordinate, value, area) in [
            ("left", 0, 0.0, 2.0),
            ("right", 0, 3.0, 2.0),
            ("bottom", 1, 1.0, 3.0),
            ("top", 1, 3.0, 3.0),
            ("back", 2, -1.0, 6.0),
            ("front", 2, 0.0, 6.0),
        ] {
            let boundary = mesh.boundary(name).unwrap();
            assert!(mesh.boundary_nodes(boundary).iter().all(|&n| mesh.points[n as usize][coordinate] == value), "{name}");
            assert!((mesh.boundary_measure(boundary) - area).abs() < ROUND_OFF, "{name}");
        }
        let mut named: Vec<Facet> = mesh.boundaries.iter().flat_map(|b| b.facets.clone()).collect();
        named.sort_unstable();
        assert_eq!(mesh.hull(), named);
    }

    #[test]
    fn facets_of_a_block_point_outward() {
        let mesh = block([1.0, 1.0, 1.0], [2, 2, 2], [0.0; 3]).unwrap();
        for facet in mesh.hull() {
            let [a, b, c, d] = <[u32; 4]>::try_from(mesh.facet_nodes(facet).collect::<Vec<_>>()).unwrap().map(|n| mesh.points[n as usize]);
            let [s, t] = [[c, a], [d, b]].map(|[to, from]| [0, 1, 2].map(|i| to[i] - from[i]));
            let normal = [s[1] * t[2] - s[2] * t[1], s[2] * t[0] - s[0] * t[2], s[0] * t[1] - s[1] * t[0]];
            let outward: f64 = (0..3).map(|i| normal[i] * ((a[i] + c[i]) / 2.0 - 0.5)).sum();
            assert!(outward > 0.0, "{facet:?}");
        }
    }

    #[test]
    fn a_ring_is_the_difference_of_two_polygons() {
        let (inner, outer, center) = (0.5, 1.25, [3.0, -2.0]);
        let mesh = ring(inner, outer, [4, 48], center, 0.3).unwrap();
        assert_eq!((mesh.points.len(), mesh.cell_count()), (5 * 48, 4 * 48));
        assert_eq!(names(&mesh), ["inner", "outer"]);
        // A regular n-gon of radius r has the area n/2 r^2 sin(2 pi/n) and the perimeter 2 n r sin(pi/n).
        let n = 48.0;
        let area = n / 2.0 * (TAU / n).sin() * (outer * outer - inner * inner);
        assert!((mesh.measure() - area).abs() < ROUND_OFF);
        for (name, radius) in [("inner", inner), ("outer", outer)] {
            let boundary = mesh.boundary(name).unwrap();
            assert!((mesh.boundary_measure(boundary) - 2.0 * n * radius * (TAU / n / 2.0).sin()).abs() < ROUND_OFF);
            let nodes = mesh.boundary_nodes(boundary);
            assert_eq!(nodes.len(), 48);
            for point in nodes.iter().map(|&n| mesh.points[n as usize]) {
                let distance = (point[0] - center[0]).hypot(point[1] - center[1]);
                assert!((distance - radius).abs() < 4.0 * f64::EPSILON * 3.0, "{name}: {distance}");
            }
            assert!(is_traversed(&mesh, name));
        }
        assert_eq!(mesh.hull().len(), 2 * 48);
        // Nodes run counter-clockwise from the start angle, in layers from the inside out.
        assert_eq!(mesh.points[0], [center[0] + inner * 0.3f64.cos(), center[1] + inner * 0.3f64.sin(), 0.0]);
        assert!(mesh.points[1][1] > mesh.points[0][1]);
        assert_eq!(mesh.points[4 * 48], [center[0] + outer * 0.3f64.cos(), center[1] + outer * 0.3f64.sin(), 0.0]);
    }

    #[test]
    fn a_disk_is_a_polygon_with_its_corners_on_the_circle() {
        let (radius, center) = (2.0, [1.0, -3.0]);
        let mesh = disk(radius, [3, 24], center).unwrap();
        assert_eq!((mesh.points.len(), mesh.cell_count()), (49 + 3 * 24, 36 + 3 * 24));
        let n = 24.0;
        assert!((mesh.measure() - n / 2.0 * radius * radius * (TAU / n).sin()).abs() < ROUND_OFF * 10.0);
        let outer = mesh.boundary("outer").unwrap();
        assert!(is_traversed(&mesh, "outer"));
        assert_eq!(mesh.hull().len(), 24);
        assert_eq!(mesh.boundary_nodes(outer).len(), 24);
        for point in mesh.boundary_nodes(outer).into_iter().map(|node| mesh.points[node as usize]) {
            assert!(((point[0] - center[0]).hypot(point[1] - center[1]) - radius).abs() < ROUND_OFF);
        }
        assert!(mesh.quality().smallest_scaled_jacobian > 0.4, "{}", mesh.quality().smallest_scaled_jacobian);
        assert_eq!(disk(1.0, [1, 4], [0.0; 2]).unwrap().cell_count(), 5);
    }

    #[test]
    fn a_half_disk_is_graded_towards_its_lowest_point() {
        let (radius, finest) = (2.0, 0.004);
        for (first, around) in [(None, 24), (Some(finest), 64)] {
            let mesh = half_disk(radius, [12, around], [0.0, 1.0], first).unwrap();
            assert_eq!(mesh.cell_count(), around / 2 * (around / 4) + 12 * around);
            assert_eq!(names(&mesh), ["arc", "flat"]);
            assert_eq!(mesh.hull().len(), mesh.boundaries.iter().map(|boundary| boundary.facets.len()).sum::<usize>());
            for name in ["arc", "flat"] {
                assert!(is_traversed(&mesh, name), "{name}");
            }
            let flat = mesh.boundary("flat").unwrap();
            assert!(mesh.boundary_nodes(flat).iter().all(|&node| mesh.points[node as usize][1] == 1.0));
            assert!((mesh.boundary_measure(flat) - 2.0 * radius).abs() < ROUND_OFF);
            let arc = mesh.boundary("arc").unwrap();
            for point in mesh.boundary_nodes(arc).into_iter().map(|node| mesh.points[node as usize]) {
                assert!((point[0].hypot(point[1] - 1.0) - radius).abs() < ROUND_OFF);
            }
            let middle = mesh.facet_nodes(arc.facets[around / 2]).map(|node| mesh.points[node as usize]).collect::<Vec<_>>();
            let length = (middle[1][0] - middle[0][0]).hypot(middle[1][1] - middle[0][1]);
            assert!(middle[0][0].abs() < ROUND_OFF, "the lowest point is a node");
            // The facet length is compared with that of the chord.
            let expected = first.unwrap_or(2.0 * radius * (PI / 2.0 / around as f64).sin());
            assert!((length / expected - 1.0).abs() < 1e-5, "{length} {expected}");
        }
    }

    #[test]
    fn the_smallest_meshes_are_sound() {
        assert_eq!(rectangle([1.0, 1.0], [1, 1], [0.0; 2]).unwrap().blocks[0].connectivity, [0, 1, 3, 2]);
        assert_eq!(block([1.0; 3], [1, 1, 1], [0.0; 3]).unwrap().blocks[0].connectivity, [0, 1, 3, 2, 4, 5, 7, 6]);
        let triangle = ring(0.5, 1.0, [1, 3], [0.0; 2], 0.0).unwrap();
        assert_eq!(triangle.blocks[0].connectivity, [0, 3, 4, 1, 1, 4, 5, 2, 2, 5, 3, 0]);
    }

    #[test]
    fn bad_numbers_are_refused_with_the_number() {
        let text = |result: Result<Mesh, MeshError>| result.unwrap_err().to_string();
        assert_eq!(
            text(rectangle([-1.0, 1.0], [1, 1], [0.0; 2])),
            "the width of a rectangle must be a finite number greater than 0, but is -1"
        );
        assert_eq!(text(rectangle([1.0, 1.0], [1, 0], [0.0; 2])), "the number of cells along the height must be at least 1, but is 0");
        assert_eq!(text(ring(1.0, 0.5, [1, 8], [0.0; 2], 0.0)), "the inner radius 1 of a ring must be smaller than its outer radius 0.5");
        assert_eq!(text(ring(0.5, 1.0, [1, 2], [0.0; 2], 0.0)), "the number of cells around must be at least 3, but is 2");
        assert_eq!(text(disk(1.0, [1, 6], [0.0; 2])), "the number of cells around must be a multiple of 4, but is 6");
        assert!(matches!(half_disk(1.0, [1, 8], [0.0; 2], Some(0.0)), Err(MeshError::NotPositive { .. })));
        assert!(matches!(ring(0.5, 1.0, [1, 8], [0.0; 2], f64::NAN), Err(MeshError::NotFinite { .. })));
        assert!(matches!(rectangle([f64::NAN, 1.0], [1, 1], [0.0; 2]), Err(MeshError::NotPositive { .. })));
        assert!(matches!(rectangle([1.0, 1.0], [1, 1], [f64::INFINITY, 0.0]), Err(MeshError::NotFinite { .. })));
        assert!(matches!(block([1.0, 1.0, 0.0], [1; 3], [0.0; 3]), Err(MeshError::NotPositive { .. })));
        // A request that exceeds the memory is refused before allocation.
        assert!(matches!(rectangle([1.0, 1.0], [usize::MAX, 7], [0.0; 2]), Err(MeshError::TooManyCells { cells: usize::MAX, .. })));
        assert!(matches!(block([1.0; 3], [1000, 1000, 1000], [0.0; 3]), Err(MeshError::TooManyCells { .. })));
        // An origin so far away that neighboring nodes round to the same point.
        assert!(matches!(rectangle([1.0, 1.0], [10, 10], [1e17, 0.0]), Err(MeshError::DegenerateCell { .. })));
    }

    #[test]
    fn graded_cells_grow_by_one_factor() {
        let mesh = graded_rectangle([2.0, 1.0], [4, 1], [0.0, 0.0], [8.0, 1.0]).unwrap();
        let widths: Vec<f64> = (0..4).map(|i| mesh.points[i + 1][0] - mesh.points[i][0]).collect();
        // Widths in the ratio 1 : 2 : 4 : 8, that is in fifteenths of the whole.
        for (width, parts) in widths.iter().zip([1.0, 2.0, 4.0, 8.0]) {
            assert!((width - 2.0 * parts / 15.0).abs() < ROUND_OFF, "{widths:?}");
        }
        let tire = graded_ring(1.0, 2.0, [3, 12], [0.0, 0.0], 0.0, 0.25).unwrap();
        let radii: Vec<f64> = (0..4).map(|i| tire.points[12 * i][0]).collect();
        assert!((radii[1] - radii[0] - 4.0 * (radii[3] - radii[2])).abs() < ROUND_OFF && radii[3] == 2.0, "{radii:?}");
        assert!((graded_block([1.0; 3], [2, 3, 2], [0.0; 3], [2.0, 1.0, 0.5]).unwrap().measure() - 1.0).abs() < ROUND_OFF);
        assert!(matches!(graded_rectangle([1.0; 2], [9, 1], [0.0; 2], [1e-40, 1.0]), Err(MeshError::Grading { count: 9, .. })));
        assert!(matches!(graded_rectangle([1.0; 2], [9, 1], [0.0; 2], [-1.0, 1.0]), Err(MeshError::NotPositive { .. })));
    }

    #[test]
    fn an_arc_is_a_sector_of_a_ring() {
        let (inner, outer, turn, cells) = (0.5, 1.5, 2.0, [3, 16]);
        let mesh = arc([inner, outer], [0.3, 0.3 + turn], cells, [1.0, -1.0], [2.0, 1.0]).unwrap();
        assert_eq!(names(&mesh), ["inner", "outer", "start", "end"]);
        // The mesh consists of the triangles between spokes of the outer circle minus those of the inner circle.
        let area = 16.0 / 2.0 * (turn / 16.0).sin() * (outer * outer - inner * inner);
        assert!((mesh.measure() - area).abs() < ROUND_OFF);
        let length = |name: &str| mesh.boundary_measure(mesh.boundary(name).unwrap());
        assert!((length("start") - 1.0).abs() < ROUND_OFF && (length("end") - 1.0).abs() < ROUND_OFF);
        assert!((length("outer") - 16.0 * 2.0 * outer * (turn / 32.0).sin()).abs() < ROUND_OFF);
        let mut named: Vec<Facet> = mesh.boundaries.iter().flat_map(|b| b.facets.clone()).collect();
        named.sort_unstable();
        assert_eq!(mesh.hull(), named);
        assert_eq!(mesh.defects(), []);
        assert!(matches!(arc([0.5, 1.0], [1.0, 0.5], [1, 4], [0.0; 2], [1.0; 2]), Err(MeshError::Turn { .. })));
        assert!(matches!(arc([0.5, 1.0], [0.0, TAU], [1, 4], [0.0; 2], [1.0; 2]), Err(MeshError::Turn { .. })));
        assert!(matches!(arc([0.5, 1.0], [0.0, 6.0], [1, 2], [0.0; 2], [1.0; 2]), Err(MeshError::TooFewCells { least: 3, .. })));
        assert!(matches!(arc([1.0, 0.5], [0.0, 1.0], [1, 2], [0.0; 2], [1.0; 2]), Err(MeshError::Radii { .. })));
    }
}
