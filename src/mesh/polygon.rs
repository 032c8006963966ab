//! Unstructured quadrilaterals in a polygon.
//!
//! The polygon is triangulated (constrained Delaunay, refined to angles of about 30 degrees at least and to the wanted size: J. Ruppert,
//! J. Algorithms 18, 1995), then every triangle is cut from its center to the middles of its sides into three quadrilaterals. So every
//! polygon can be meshed, and every cell is convex. Sides are divided evenly.

use std::collections::HashMap;

use spade::{AngleLimit, ConstrainedDelaunayTriangulation, Point2, RefinementParameters, Triangulation};

use super::{Boundary, CELL_LIMIT, Facet, Mesh, MeshError};
use crate::elements::CellKind;

/// Smallest angle that refinement aims at, in degrees: above 33 it need not end.
const ANGLE: f64 = 28.0;

/// Cells of quad4 with edges of about `size` `[length]` in the polygon with these corners, in either direction of traversal; boundaries by
/// `names`, one for each side in the order of the corners (from the first to the second and so on), equal names joined, and `outer`. Each
/// of the `holes` is a polygon inside; its boundary is `hole 1`, `hole 2` and so on.
///
/// # Errors
/// Fewer than 3 corners, sides that cross or have no length, holes that are not inside or meet, a size that is not positive, numbers that
/// are not finite, too many cells.
pub fn polygon(corners: &[[f64; 2]], holes: &[Vec<[f64; 2]>], size: f64, names: &[String]) -> Result<Mesh, MeshError> {
    check(corners, size)?;
    for (hole, rim) in holes.iter().enumerate() {
        check(rim, size)?;
        let apart = |other: &[[f64; 2]]| !sides_meet(rim, other);
        let is_free =
            apart(corners) && holes[..hole].iter().all(|other| apart(other) && !contains(other, rim[0]) && !contains(rim, other[0]));
        if !is_free || !contains(corners, rim[0]) {
            return Err(MeshError::HoleOutside { hole: hole + 1 });
        }
    }
    let count = corners.len();
    let area: f64 = (0..count).map(|k| cross(corners[k], corners[(k + 1) % count])).sum::<f64>() / 2.0;
    // Estimated before memory is taken.
    let cells = area.abs() / (size * size);
    if cells > CELL_LIMIT as f64 {
        return Err(MeshError::TooManyCells { cells: cells as usize, limit: CELL_LIMIT });
    }
    // Sides counter-clockwise, each with the index of its name.
    let sides: Vec<(usize, [f64; 2], [f64; 2])> = if area > 0.0 {
        (0..count).map(|k| (k, corners[k], corners[(k + 1) % count])).collect()
    } else {
        (0..count).rev().map(|k| (k, corners[(k + 1) % count], corners[k])).collect()
    };
    // A triangle's edge is twice that of its quadrilaterals.
    let edge = 2.0 * size;
    let mut rim = Rim::default();
    rim.add_loop(&sides, edge, Owner::Side);
    for (hole, corners) in holes.iter().enumerate() {
        // The body is on the left: round a hole clockwise.
        let count = corners.len();
        let clockwise = (0..count).map(|k| cross(corners[k], corners[(k + 1) % count])).sum::<f64>() < 0.0;
        let sides = (0..count).map(|k| (k, corners[k], corners[(k + 1) % count]));
        let sides: Vec<_> = if clockwise { sides.collect() } else { sides.rev().map(|(k, from, to)| (k, to, from)).collect() };
        rim.add_loop(&sides, edge, |_| Owner::Hole(hole));
    }
    let (vertices, triangles) = triangulate(&rim, edge)?;
    quadrilaterals(&vertices, &triangles, &rim, names).checked()
}

/// Whom an edge of the rim belongs to.
#[derive(Clone, Copy)]
enum Owner {
    /// A side of the polygon.
    Side(usize),
    /// A hole.
    Hole(usize),
}

/// The outline and the holes in pieces of about one edge, the body on their left.
#[derive(Default)]
struct Rim {
    vertices: Vec<[f64; 2]>,
    /// The vertex behind each one.
    next: Vec<usize>,
    owners: Vec<Owner>,
}

impl Rim {
    fn add_loop(&mut self, sides: &[(usize, [f64; 2], [f64; 2])], edge: f64, owner: impl Fn(usize) -> Owner) {
        let first = self.vertices.len();
        for &(side, from, to) in sides {
            let pieces = ((to[0] - from[0]).hypot(to[1] - from[1]) / edge).ceil().max(1.0) as usize;
            for piece in 0..pieces {
                let share = piece as f64 / pieces as f64;
                self.vertices.push([0, 1].map(|i| from[i] * (1.0 - share) + to[i] * share));
                self.owners.push(owner(side));
                self.next.push(self.vertices.len());
            }
        }
        if let Some(last) = self.next.last_mut() {
            *last = first;
        }
    }
}

fn contains(corners: &[[f64; 2]], point: [f64; 2]) -> bool {
    is_inside((0..corners.len()).map(|k| [corners[k], corners[(k + 1) % corners.len()]]), point)
}

/// Whether a point is inside the closed lines with these sides: a ray from it crosses an odd number of them.
pub fn is_inside(sides: impl Iterator<Item = [[f64; 2]; 2]>, [x, y]: [f64; 2]) -> bool {
    let crosses = |[[ax, ay], [bx, by]]: &[[f64; 2]; 2]| (*ay > y) != (*by > y) && x < ax + (y - ay) / (by - ay) * (bx - ax);
    sides.filter(crosses).count() % 2 == 1
}

/// Whether a side of one polygon meets a side of another one.
fn sides_meet(one: &[[f64; 2]], other: &[[f64; 2]]) -> bool {
    let side = |corners: &[[f64; 2]], k: usize| [corners[k], corners[(k + 1) % corners.len()]];
    (0..one.len()).any(|k| (0..other.len()).any(|l| meet(side(one, k), side(other, l))))
}

fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    cross([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]])
}

fn between(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> bool {
    (0..2).all(|i| c[i] >= a[i].min(b[i]) && c[i] <= a[i].max(b[i]))
}

/// Whether two segments have a point in common.
fn meet([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> bool {
    let (u, v, w, z) = (turn(a, b, c), turn(a, b, d), turn(c, d, a), turn(c, d, b));
    (u * v < 0.0 && w * z < 0.0)
        || (u == 0.0 && between(a, b, c))
        || (v == 0.0 && between(a, b, d))
        || (w == 0.0 && between(c, d, a))
        || (z == 0.0 && between(c, d, b))
}

/// Third component of the cross product of two plane vectors.
pub fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn check(corners: &[[f64; 2]], size: f64) -> Result<(), MeshError> {
    let count = corners.len();
    if count < 3 {
        return Err(MeshError::FewCorners { count });
    }
    if let Some(&value) = corners.as_flattened().iter().find(|value| !value.is_finite()) {
        return Err(MeshError::NotFinite { what: "a coordinate of a polygon's corner", value });
    }
    if !(size.is_finite() && size > 0.0) {
        return Err(MeshError::NotPositive { what: "the cell size of a polygon", value: size });
    }
    let side = |k: usize| (corners[k], corners[(k + 1) % count]);
    if let Some(side) = (1..=count).find(|number| corners[number - 1] == corners[number % count]) {
        return Err(MeshError::EmptySide { side });
    }
    for first in 0..count {
        let (a, b) = side(first);
        for second in first + 1..count {
            let (c, d) = side(second);
            let touches = if second == first + 1 {
                turn(a, b, d) == 0.0 && between(a, b, d)
            } else if (second + 1) % count == first {
                turn(a, b, c) == 0.0 && between(a, b, c)
            } else {
                meet([a, b], [c, d])
            };
            if touches {
                return Err(MeshError::CrossingSides { first: first + 1, second: second + 1 });
            }
        }
    }
    Ok(())
}

/// Vertices, those of the rim first and in its order, and triangles counter-clockwise.
type Triangles = (Vec<[f64; 2]>, Vec<[usize; 3]>);

fn triangulate(rim: &Rim, edge: f64) -> Result<Triangles, MeshError> {
    let failed = || MeshError::NoTriangulation;
    let mut triangulation = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
    let mut handles = Vec::with_capacity(rim.vertices.len());
    for &[x, y] in &rim.vertices {
        handles.push(triangulation.insert(Point2::new(x, y)).map_err(|_| failed())?);
    }
    for k in 0..handles.len() {
        let (from, to) = (handles[k], handles[rim.next[k]]);
        if from == to || !triangulation.can_add_constraint(from, to) {
            return Err(failed());
        }
        triangulation.add_constraint(from, to);
    }
    let parameters = RefinementParameters::<f64>::new()
        .exclude_outer_faces(true)
        .keep_constraint_edges()
        .with_angle_limit(AngleLimit::from_deg(ANGLE))
        .with_max_allowed_area(0.6 * edge * edge);
    let outside: std::collections::HashSet<_> = triangulation.refine(parameters).excluded_faces.into_iter().collect();
    // Refinement only adds vertices, so those of the rim keep their places at the beginning.
    let vertices: Vec<[f64; 2]> = triangulation.vertices().map(|vertex| [vertex.position().x, vertex.position().y]).collect();
    let inside = triangulation.inner_faces().filter(|face| !outside.contains(&face.fix()));
    let triangles: Vec<[usize; 3]> = inside.map(|face| face.vertices().map(|vertex| vertex.fix().index())).collect();
    if triangles.is_empty() { Err(failed()) } else { Ok((vertices, triangles)) }
}

fn quadrilaterals(vertices: &[[f64; 2]], triangles: &[[usize; 3]], rim: &Rim, names: &[String]) -> Mesh {
    let mut points: Vec<[f64; 3]> = Vec::new();
    let mut corner: HashMap<usize, u32> = HashMap::new();
    let mut middle: HashMap<[usize; 2], u32> = HashMap::new();
    let mut connectivity = Vec::new();
    // The cell at the start and at the end of each edge that runs along the rim.
    let mut along: HashMap<usize, [u32; 2]> = HashMap::new();
    for (triangle, nodes) in triangles.iter().enumerate() {
        let mut add = |sum: &[usize]| {
            let mean = |i: usize| sum.iter().map(|&vertex| vertices[vertex][i]).sum::<f64>() / sum.len() as f64;
            points.push([mean(0), mean(1), 0.0]);
            points.len() as u32 - 1
        };
        let own = nodes.map(|vertex| *corner.entry(vertex).or_insert_with(|| add(&[vertex])));
        let edges = [0, 1, 2].map(|k| [nodes[k], nodes[(k + 1) % 3]]);
        let middles = edges.map(|[a, b]| *middle.entry([a.min(b), a.max(b)]).or_insert_with(|| add(&[a, b])));
        let center = add(nodes);
        for k in 0..3 {
            connectivity.extend([own[k], middles[k], center, middles[(k + 2) % 3]]);
        }
        for (k, [from, to]) in edges.into_iter().enumerate() {
            if rim.next.get(from) == Some(&to) {
                along.insert(from, [(3 * triangle + k) as u32, (3 * triangle + (k + 1) % 3) as u32]);
            }
        }
    }
    let mut boundaries: Vec<Boundary> = Vec::new();
    let mut add = |name: &str, facets: [Facet; 2]| match boundaries.iter_mut().find(|boundary| boundary.name == name) {
        Some(boundary) => boundary.facets.extend(facets),
        None => boundaries.push(Boundary::of_facets(name, facets.into())),
    };
    for (piece, owner) in rim.owners.iter().enumerate() {
        let Some(&[start, end]) = along.get(&piece) else { continue };
        let facets = [Facet { cell: start, local: 0 }, Facet { cell: end, local: 3 }];
        match *owner {
            Owner::Hole(hole) => add(&format!("hole {}", hole + 1), facets),
            Owner::Side(side) => {
                add("outer", facets);
                if let Some(name) = names.get(side).filter(|name| *name != "outer") {
                    add(name, facets);
                }
            }
        }
    }
    Mesh { kind: CellKind::Quad4, points, connectivity, boundaries, parts: Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(count: usize) -> Vec<String> {
        (1..=count).map(|side| format!("side {side}")).collect()
    }

    #[test]
    fn an_angle_has_its_area_and_sides_whatever_way_its_corners_go() {
        let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
        let lengths = [2.0, 1.0, 1.0, 2.0, 1.0, 3.0];
        let reversed: Vec<[f64; 2]> = corners.iter().rev().copied().collect();
        for (corners, lengths) in [(corners.to_vec(), lengths.to_vec()), (reversed, vec![1.0, 2.0, 1.0, 1.0, 2.0, 3.0])] {
            let mesh = polygon(&corners, &[], 0.1, &names(6)).unwrap();
            assert!((mesh.measure() - 4.0).abs() < 1e-12, "{}", mesh.measure());
            for (side, length) in lengths.iter().enumerate() {
                let boundary = mesh.boundary(&format!("side {}", side + 1)).unwrap();
                assert!((mesh.boundary_measure(boundary) - length).abs() < 1e-12, "side {side}");
            }
            let outer = mesh.boundary("outer").unwrap();
            assert_eq!(outer.facets.len(), mesh.hull().len());
            let ends = |facet: Facet| mesh.facet_nodes(facet).collect::<Vec<_>>();
            assert!(outer.facets.windows(2).all(|pair| ends(pair[0])[1] == ends(pair[1])[0]), "traversed with the body on the left");
            let quality = mesh.quality();
            assert!(quality.smallest_scaled_jacobian > 0.2, "{quality:?}");
            // 4 / 0.1^2 = 400 cells of that size.
            assert!((200..1200).contains(&mesh.cell_count()), "{}", mesh.cell_count());
        }
    }

    #[test]
    fn a_triangle_of_one_size_is_three_cells_and_equal_names_are_joined() {
        let both = ["floor".to_string(), "roof".to_string(), "roof".to_string()];
        let mesh = polygon(&[[0.0, 0.0], [1.0, 0.0], [0.5, 0.9]], &[], 0.6, &both).unwrap();
        assert_eq!(mesh.cell_count(), 3);
        assert_eq!(mesh.boundary("roof").unwrap().facets.len(), 4);
        assert_eq!(mesh.boundary("floor").unwrap().facets.len(), 2);
    }

    #[test]
    fn what_is_no_polygon_is_refused() {
        let text = |corners: &[[f64; 2]], size: f64| polygon(corners, &[], size, &[]).unwrap_err().to_string();
        assert_eq!(text(&[[0.0, 0.0], [1.0, 0.0]], 0.1), "a polygon needs at least 3 corners, but has 2");
        assert_eq!(text(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]], 0.1), "the sides 1 and 3 of the polygon touch or cross");
        assert_eq!(text(&[[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 1.0]], 0.1), "side 2 of the polygon has no length");
        assert!(text(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], 0.0).contains("greater than 0"));
        assert!(matches!(polygon(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], &[], 1e-6, &[]), Err(MeshError::TooManyCells { .. })));
    }

    #[test]
    fn holes_are_left_out_and_have_boundaries() {
        let square =
            |x: f64, y: f64, half: f64| vec![[x - half, y - half], [x + half, y - half], [x + half, y + half], [x - half, y + half]];
        let mut reversed = square(2.0, 0.5, 0.2);
        reversed.reverse();
        let holes = [square(1.0, 0.5, 0.25), reversed];
        let mesh = polygon(&[[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [0.0, 1.0]], &holes, 0.1, &[]).unwrap();
        assert!((mesh.measure() - (3.0 - 0.25 - 0.16)).abs() < 1e-12);
        let length = |name: &str| mesh.boundary_measure(mesh.boundary(name).unwrap());
        assert!((length("outer") - 8.0).abs() < 1e-12 && (length("hole 1") - 2.0).abs() < 1e-12 && (length("hole 2") - 1.6).abs() < 1e-12);
        let named: usize = mesh.boundaries.iter().map(|boundary| boundary.facets.len()).sum();
        assert_eq!(mesh.hull().len(), named);
        let refusal = |holes: &[Vec<[f64; 2]>]| polygon(&[[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [0.0, 1.0]], holes, 0.1, &[]).unwrap_err();
        assert!(matches!(refusal(&[square(5.0, 0.5, 0.2)]), MeshError::HoleOutside { hole: 1 }));
        assert!(matches!(refusal(&[square(1.0, 0.5, 0.6)]), MeshError::HoleOutside { hole: 1 }));
        assert!(matches!(refusal(&[square(1.0, 0.5, 0.3), square(1.0, 0.5, 0.1)]), MeshError::HoleOutside { hole: 2 }));
        assert!(matches!(refusal(&[vec![[1.0, 0.5], [1.1, 0.5]]]), MeshError::FewCorners { count: 2 }));
    }
}
