//! Polygons with unstructured cells: regions with straight sides, whose corners are checked first.

use super::cell_size::CellSize;
use super::curves::{Curve, OutlineSide};
use super::layers::Layers;
use super::plane::{cross, is_inside};
use super::region::layered_region;
use super::{Mesh, MeshError};
use crate::elements::CellKind;

/// Cells of quad4 with edges of about `size` `[length]` in the polygon with these corners, in either direction of traversal. Boundaries
/// have the `names` of the sides in the order of the corners (from the first to the second and so on), with equal names joined, and
/// `outer`. Each of the `holes` is a polygon inside; its boundary is `hole 1`, `hole 2` and so on.
///
/// # Errors
/// Fewer than 3 corners, sides that cross or have no length, holes that are not inside or meet, a size that is not positive, numbers that
/// are not finite, too many cells.
pub fn polygon(corners: &[[f64; 2]], holes: &[Vec<[f64; 2]>], size: f64, names: &[String]) -> Result<Mesh, MeshError> {
    polygon_of(CellKind::Quad4, corners, holes, size, names)
}

/// [`polygon`] with another plane kind of cells.
///
/// # Errors
/// Errors of [`polygon`]; a kind that is not plane.
pub fn polygon_of(kind: CellKind, corners: &[[f64; 2]], holes: &[Vec<[f64; 2]>], size: f64, names: &[String]) -> Result<Mesh, MeshError> {
    layered_polygon(kind, corners, holes, size, names, None)
}

/// [`polygon_of`] with strips of thin cells along some of its boundaries.
///
/// # Errors
/// Errors of [`polygon_of`] and of [`layered_region`].
pub fn layered_polygon(
    kind: CellKind,
    corners: &[[f64; 2]],
    holes: &[Vec<[f64; 2]>],
    size: f64,
    names: &[String],
    layers: Option<&Layers>,
) -> Result<Mesh, MeshError> {
    let (outline, holes) = sides(corners, holes, size, names)?;
    layered_region(&outline, &holes, CellSize::<MeshError>::Even(size), kind, layers)
}

/// Sides of a polygon and of its holes as curves.
///
/// # Errors
/// Errors of [`polygon`].
fn sides(
    corners: &[[f64; 2]],
    holes: &[Vec<[f64; 2]>],
    size: f64,
    names: &[String],
) -> Result<(Vec<OutlineSide>, Vec<Vec<OutlineSide>>), MeshError> {
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
    let sides = |corners: &[[f64; 2]], names: &[String]| {
        let side = |k: usize| OutlineSide {
            curve: Curve::Line { from: corners[k], to: corners[(k + 1) % corners.len()] },
            name: names.get(k).cloned(),
        };
        (0..corners.len()).map(side).collect::<Vec<OutlineSide>>()
    };
    Ok((sides(corners, names), holes.iter().map(|hole| sides(hole, &[])).collect()))
}

fn contains(corners: &[[f64; 2]], point: [f64; 2]) -> bool {
    is_inside((0..corners.len()).map(|k| [corners[k], corners[(k + 1) % corners.len()]]), point)
}

/// True if a side of one polygon meets a side of the other.
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

/// True if two segments have a point in common.
fn meet([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> bool {
    let (u, v, w, z) = (turn(a, b, c), turn(a, b, d), turn(c, d, a), turn(c, d, b));
    (u * v < 0.0 && w * z < 0.0)
        || (u == 0.0 && between(a, b, c))
        || (v == 0.0 && between(a, b, d))
        || (w == 0.0 && between(c, d, a))
        || (z == 0.0 && between(c, d, b))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Facet;

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
