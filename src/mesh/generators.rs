//! Structured meshes of simple bodies: rectangle, block, ring, disk and half disk.
//!
//! Each is a mapped grid of cells; the names of its boundaries are fixed. Plane boundaries are traversed with the body on the left,
//! so that each facet begins where the one before it ends.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, FRAC_PI_4, PI, TAU};

use super::{Boundary, CELL_LIMIT, Facet, Mesh, MeshError};
use crate::elements::CellKind;

/// A rectangle of quad4 cells, `size` and `origin` (its lower left corner) `[length]`; boundaries `left right bottom top`.
///
/// Nodes run along x first, from the bottom row up; so do cells.
///
/// # Errors
/// Sizes that are not positive, counts of zero, numbers that are not finite, too many cells.
pub fn rectangle(size: [f64; 2], cells: [usize; 2], origin: [f64; 2]) -> Result<Mesh, MeshError> {
    positive("the width of a rectangle", size[0])?;
    positive("the height of a rectangle", size[1])?;
    at_least("along the width", cells[0], 1)?;
    at_least("along the height", cells[1], 1)?;
    limited(&cells)?;
    let [nx, ny] = cells;
    let node = |i: usize, j: usize| (j * (nx + 1) + i) as u32;
    let points = grid(ny).flat_map(|y| grid(nx).map(move |x| [origin[0] + size[0] * x, origin[1] + size[1] * y, 0.0])).collect();
    let connectivity =
        (0..ny).flat_map(|j| (0..nx).flat_map(move |i| [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)])).collect();
    let facet = |i: usize, j: usize, local: u8| Facet { cell: (j * nx + i) as u32, local };
    let boundaries = vec![
        boundary("left", (0..ny).rev().map(|j| facet(0, j, 3))),
        boundary("right", (0..ny).map(|j| facet(nx - 1, j, 1))),
        boundary("bottom", (0..nx).map(|i| facet(i, 0, 0))),
        boundary("top", (0..nx).rev().map(|i| facet(i, ny - 1, 2))),
    ];
    Mesh { kind: CellKind::Quad4, points, connectivity, boundaries, parts: Vec::new() }.checked()
}

/// A block of hex8 cells, `size` and `origin` (its corner of least coordinates) `[length]`; boundaries `left right` (x),
/// `bottom top` (y), `back front` (z), the lesser coordinate first.
///
/// Nodes run along x first, then y, then z; so do cells.
///
/// # Errors
/// Sizes that are not positive, counts of zero, numbers that are not finite, too many cells.
pub fn block(size: [f64; 3], cells: [usize; 3], origin: [f64; 3]) -> Result<Mesh, MeshError> {
    for (what, value) in ["the width of a block", "the height of a block", "the depth of a block"].into_iter().zip(size) {
        positive(what, value)?;
    }
    for (direction, count) in ["along the width", "along the height", "along the depth"].into_iter().zip(cells) {
        at_least(direction, count, 1)?;
    }
    limited(&cells)?;
    let [nx, ny, nz] = cells;
    let mut points = Vec::with_capacity((nx + 1) * (ny + 1) * (nz + 1));
    for z in grid(nz) {
        for y in grid(ny) {
            points.extend(grid(nx).map(|x| [origin[0] + size[0] * x, origin[1] + size[1] * y, origin[2] + size[2] * z]));
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
    Mesh { kind: CellKind::Hex8, points, connectivity, boundaries, parts: Vec::new() }.checked()
}

/// A closed ring of quad4 cells between two circles around `center` `[length]`, `cells` radially and around; boundaries `inner outer`.
///
/// All nodes lie on circles: layers from the inside out, counter-clockwise in each from `start_angle` `[rad]`.
///
/// # Errors
/// Radii that are not positive or not in order, no cell radially, fewer than 3 around, numbers that are not finite, too many cells.
pub fn ring(inner_radius: f64, outer_radius: f64, cells: [usize; 2], center: [f64; 2], start_angle: f64) -> Result<Mesh, MeshError> {
    positive("the inner radius of a ring", inner_radius)?;
    positive("the outer radius of a ring", outer_radius)?;
    if inner_radius >= outer_radius {
        return Err(MeshError::Radii { inner: inner_radius, outer: outer_radius });
    }
    at_least("along the radius", cells[0], 1)?;
    at_least("around", cells[1], 3)?;
    limited(&cells)?;
    if !start_angle.is_finite() {
        return Err(MeshError::NotFinite { what: "the start angle of a ring", value: start_angle });
    }
    let [radial, around] = cells;
    // one sine and cosine per spoke: the nodes of a spoke are exactly in line
    let spokes: Vec<(f64, f64)> = (0..around).map(|j| (start_angle + TAU * j as f64 / around as f64).sin_cos()).collect();
    let points = grid(radial)
        .flat_map(|share| {
            // this form meets both radii exactly, at share 0 and 1
            let radius = inner_radius * (1.0 - share) + outer_radius * share;
            spokes.iter().map(move |&(sine, cosine)| [center[0] + radius * cosine, center[1] + radius * sine, 0.0])
        })
        .collect();
    let node = |layer: usize, j: usize| (layer * around + j % around) as u32;
    let connectivity =
        (0..radial).flat_map(|i| (0..around).flat_map(move |j| [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)])).collect();
    let facet = |layer: usize, j: usize, local: u8| Facet { cell: (layer * around + j) as u32, local };
    let boundaries =
        vec![boundary("inner", (0..around).rev().map(|j| facet(0, j, 3))), boundary("outer", (0..around).map(|j| facet(radial - 1, j, 1)))];
    Mesh { kind: CellKind::Quad4, points, connectivity, boundaries, parts: Vec::new() }.checked()
}

/// Distance of the corners of a disk's square core from its center, over the radius: angles of the cells there stay near 120 degrees.
const CORE: f64 = 0.55;

/// A disk of quad4 cells around `center` `[length]`: a square core in a ring of `cells[0]` layers with `cells[1]` cells around; boundary
/// `outer`.
///
/// Nodes: the core row by row from below, then the layers from the inside out, counter-clockwise in each from the lower left.
///
/// # Errors
/// A radius that is not positive, a number of cells around that is no multiple of 4, numbers that are not finite, too many cells.
pub fn disk(radius: f64, cells: [usize; 2], center: [f64; 2]) -> Result<Mesh, MeshError> {
    positive("the radius of a disk", radius)?;
    let [radial, around] = checked_round(cells)?;
    let side = around / 4;
    let half = CORE * radius * FRAC_1_SQRT_2;
    let at = |x: f64, y: f64| [center[0] + x, center[1] + y, 0.0];
    let mut points: Vec<[f64; 3]> =
        grid(side).flat_map(|y| grid(side).map(move |x| [half * (2.0 * x - 1.0), half * (2.0 * y - 1.0)])).map(|[x, y]| at(x, y)).collect();
    let core = |i: usize, j: usize| (j * (side + 1) + i) as u32;
    // Around the core counter-clockwise from its lower left corner.
    let rim = |k: usize| match (k / side % 4, k % side) {
        (0, i) => core(i, 0),
        (1, j) => core(side, j),
        (2, i) => core(side - i, side),
        (_, j) => core(0, side - j),
    };
    let first = points.len();
    for layer in 1..=radial {
        let share = layer as f64 / radial as f64;
        for k in 0..around {
            let inside = points[rim(k) as usize];
            let (sine, cosine) = (-0.75 * PI + TAU * k as f64 / around as f64).sin_cos();
            let outside = at(radius * cosine, radius * sine);
            points.push([0, 1, 2].map(|i| inside[i] * (1.0 - share) + outside[i] * share));
        }
    }
    let node = |layer: usize, k: usize| if layer == 0 { rim(k % around) } else { (first + (layer - 1) * around + k % around) as u32 };
    let mut connectivity = core_cells(side, side);
    connectivity.extend(
        (0..radial).flat_map(|i| (0..around).flat_map(move |k| [(i, k), (i + 1, k), (i + 1, k + 1), (i, k + 1)])).map(|(i, k)| node(i, k)),
    );
    let facet = |k: usize| Facet { cell: (side * side + (radial - 1) * around + k) as u32, local: 1 };
    let boundaries = vec![boundary("outer", (0..around).map(facet))];
    Mesh { kind: CellKind::Quad4, points, connectivity, boundaries, parts: Vec::new() }.checked()
}

/// The lower half of a disk around `center` `[length]`, of quad4 cells: a core below the diameter, and `cells[0]` layers with `cells[1]`
/// cells around it; boundaries `arc` and `flat`.
///
/// With `finest` `[length]` facets are that long at the lowest point and grow in geometric progression away from it, along the arc and into
/// the body; without, or where even ones are smaller, they are even.
///
/// # Errors
/// Lengths that are not positive, a number of cells around that is no multiple of 4, numbers that are not finite, too many cells.
pub fn half_disk(radius: f64, cells: [usize; 2], center: [f64; 2], finest: Option<f64>) -> Result<Mesh, MeshError> {
    positive("the radius of a half disk", radius)?;
    if let Some(finest) = finest {
        positive("the finest facet of a half disk", finest)?;
    }
    let [radial, around] = checked_round(cells)?;
    let (width, side) = (around / 2, around / 4);
    let half = CORE * radius * FRAC_1_SQRT_2;
    let at = |x: f64, y: f64| [center[0] + x, center[1] + y, 0.0];
    // Places along the lower quarter of the arc, -1 to 1, and across the layers, 0 to 1 at the arc.
    let along = progression(side, FRAC_PI_4 * radius, finest);
    let along: Vec<f64> = along.iter().rev().map(|s| -s).chain(along[1..].iter().copied()).collect();
    let across: Vec<f64> = progression(radial, radius - half, finest).iter().rev().map(|s| 1.0 - s).collect();
    let mut points: Vec<[f64; 3]> =
        grid(side).flat_map(|y| along.iter().map(move |x| [half * x, half * (y - 1.0)])).map(|[x, y]| at(x, y)).collect();
    let core = |i: usize, j: usize| (j * (width + 1) + i) as u32;
    // Around the core counter-clockwise from its upper left corner to the upper right one.
    let rim = |k: usize| match k {
        _ if k <= side => core(0, side - k),
        _ if k <= side + width => core(k - side, 0),
        _ => core(width, k - side - width),
    };
    let angle = |k: usize| match k {
        _ if k <= side => -PI + FRAC_PI_4 * k as f64 / side as f64,
        _ if k <= side + width => -FRAC_PI_2 + FRAC_PI_4 * along[k - side],
        _ => FRAC_PI_4 * (k as f64 - around as f64) / side as f64,
    };
    let first = points.len();
    for share in &across[1..] {
        for k in 0..=around {
            let inside = points[rim(k) as usize];
            // The ends of the arc lie exactly on the diameter.
            let (sine, cosine) = if k == 0 {
                (0.0, -1.0)
            } else if k == around {
                (0.0, 1.0)
            } else {
                angle(k).sin_cos()
            };
            let outside = at(radius * cosine, radius * sine);
            points.push([0, 1, 2].map(|i| inside[i] * (1.0 - share) + outside[i] * share));
        }
    }
    let node = |layer: usize, k: usize| if layer == 0 { rim(k) } else { (first + (layer - 1) * (around + 1) + k) as u32 };
    let mut connectivity = core_cells(width, side);
    connectivity.extend(
        (0..radial).flat_map(|i| (0..around).flat_map(move |k| [(i, k), (i + 1, k), (i + 1, k + 1), (i, k + 1)])).map(|(i, k)| node(i, k)),
    );
    let facet = |layer: usize, k: usize, local: u8| Facet { cell: (width * side + layer * around + k) as u32, local };
    let top = (0..width).rev().map(|i| Facet { cell: ((side - 1) * width + i) as u32, local: 2 });
    let flat = (0..radial).rev().map(|layer| facet(layer, around - 1, 2)).chain(top).chain((0..radial).map(|layer| facet(layer, 0, 0)));
    let boundaries = vec![boundary("arc", (0..around).map(|k| facet(radial - 1, k, 1))), boundary("flat", flat)];
    Mesh { kind: CellKind::Quad4, points, connectivity, boundaries, parts: Vec::new() }.checked()
}

/// Cells of a core of `width` times `height`, row by row.
fn core_cells(width: usize, height: usize) -> Vec<u32> {
    let node = |i: usize, j: usize| (j * (width + 1) + i) as u32;
    (0..height).flat_map(|j| (0..width).flat_map(move |i| [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)])).collect()
}

/// Counts of cells across the layers of a disk and around it.
fn checked_round(cells: [usize; 2]) -> Result<[usize; 2], MeshError> {
    at_least("along the radius", cells[0], 1)?;
    limited(&cells)?;
    let core = cells[1] / 4;
    limited(&[core, core])?;
    if cells[1] == 0 || !cells[1].is_multiple_of(4) {
        return Err(MeshError::NotMultiple { direction: "around", count: cells[1], of: 4 });
    }
    Ok(cells)
}

/// `count + 1` numbers from 0 to 1, both met exactly, whose steps grow in geometric progression from `first / length`; even ones without
/// a first step, or when even ones are smaller.
fn progression(count: usize, length: f64, first: Option<f64>) -> Vec<f64> {
    let Some(first) = first.map(|first| first / length).filter(|first| first * (count as f64) < 1.0 && count > 1) else {
        return grid(count).collect();
    };
    let sum = |ratio: f64| (0..count).fold(0.0, |sum: f64, _| sum * ratio + first);
    let (mut low, mut high) = (1.0, 1.0 / first);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if sum(middle) < 1.0 { low = middle } else { high = middle }
    }
    let mut places: Vec<f64> = vec![0.0];
    let mut step = first;
    for _ in 1..count {
        places.push(places[places.len() - 1] + step);
        step *= low;
    }
    places.push(1.0);
    places
}

/// `count + 1` numbers from 0 to 1, both met exactly.
fn grid(count: usize) -> impl Iterator<Item = f64> {
    (0..=count).map(move |i| i as f64 / count as f64)
}

fn boundary(name: &str, facets: impl Iterator<Item = Facet>) -> Boundary {
    Boundary::of_facets(name, facets.collect())
}

fn positive(what: &'static str, value: f64) -> Result<(), MeshError> {
    if value.is_finite() && value > 0.0 { Ok(()) } else { Err(MeshError::NotPositive { what, value }) }
}

fn at_least(direction: &'static str, count: usize, least: usize) -> Result<(), MeshError> {
    if count >= least { Ok(()) } else { Err(MeshError::TooFewCells { direction, count, least }) }
}

fn limited(cells: &[usize]) -> Result<(), MeshError> {
    let total = cells.iter().fold(1, |product: usize, &count| product.saturating_mul(count));
    if total <= CELL_LIMIT { Ok(()) } else { Err(MeshError::TooManyCells { cells: total, limit: CELL_LIMIT }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Round-off of sums of some hundred terms of order one.
    const ROUND_OFF: f64 = 1e-13;

    fn names(mesh: &Mesh) -> Vec<&str> {
        mesh.boundaries.iter().map(|b| b.name.as_str()).collect()
    }

    /// Each plane facet begins where the one before it ends.
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
        // a regular n-gon of radius r has area n/2 r^2 sin(2 pi/n) and perimeter 2 n r sin(pi/n)
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
        // counter-clockwise from the start angle, layers from the inside out
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
            // A chord of a facet that is short against the radius.
            let expected = first.unwrap_or(2.0 * radius * (PI / 2.0 / around as f64).sin());
            assert!((length / expected - 1.0).abs() < 1e-5, "{length} {expected}");
        }
    }

    #[test]
    fn the_smallest_meshes_are_sound() {
        assert_eq!(rectangle([1.0, 1.0], [1, 1], [0.0; 2]).unwrap().connectivity, [0, 1, 3, 2]);
        assert_eq!(block([1.0; 3], [1, 1, 1], [0.0; 3]).unwrap().connectivity, [0, 1, 3, 2, 4, 5, 7, 6]);
        let triangle = ring(0.5, 1.0, [1, 3], [0.0; 2], 0.0).unwrap();
        assert_eq!(triangle.connectivity, [0, 3, 4, 1, 1, 4, 5, 2, 2, 5, 3, 0]);
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
        // asking for more than fits in memory must not take the memory
        assert!(matches!(rectangle([1.0, 1.0], [usize::MAX, 7], [0.0; 2]), Err(MeshError::TooManyCells { cells: usize::MAX, .. })));
        assert!(matches!(block([1.0; 3], [1000, 1000, 1000], [0.0; 3]), Err(MeshError::TooManyCells { .. })));
        // so far from the origin that neighboring nodes round to the same point
        assert!(matches!(rectangle([1.0, 1.0], [10, 10], [1e17, 0.0]), Err(MeshError::DegenerateCell { .. })));
    }
}
