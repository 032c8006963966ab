//! Unstructured cells in a region bounded by curves.
//!
//! The region is triangulated; for quadrilaterals every triangle is divided into three, from its center to the midpoints of its sides.
//! Every region can be meshed in this way, and every cell is convex. New nodes on the rim lie on its curves.

use super::cell_size::CellSize;
use super::columns::layered;
use super::curves::{Curve, OutlineSide, SIDE_LIMIT};
use super::filling::filled;
use super::layers::Layers;
use super::plane::is_inside;
use super::triangulation::Rim;
use super::{Boundary, Facet, Mesh, MeshError};
use crate::elements::{CellKind, CellShape};

/// Plane cells of a kind with edges of about `size` `[length]` in the region inside the outline and outside the holes. Outline and holes
/// are closed chains of curves, in either direction of traversal. Boundaries are `outer`, `hole 1`, `hole 2` and so on, and the names of
/// the sides, with equal names joined. Mid-side nodes on the rim lie on its curves.
///
/// # Errors
/// Curves that do not follow each other, that cross or touch, holes that are not inside, sizes that are not positive, too many cells,
/// errors of `size`.
pub fn region<E: From<MeshError>>(
    outline: &[OutlineSide],
    holes: &[Vec<OutlineSide>],
    size: CellSize<E>,
    kind: CellKind,
) -> Result<Mesh, E> {
    layered_region(outline, holes, size, kind, None)
}

/// [`region`] with strips of thin cells along some of its boundaries: stacks of quadrilaterals, or of pairs of triangles for triangular
/// kinds. Second-order cells follow the curved boundary at all levels.
///
/// # Errors
/// Errors of [`region`]; unknown boundaries, layers that leave no room for cells, corners too sharp for layers.
pub fn layered_region<E: From<MeshError>>(
    outline: &[OutlineSide],
    holes: &[Vec<OutlineSide>],
    mut size: CellSize<E>,
    kind: CellKind,
    layers: Option<&Layers>,
) -> Result<Mesh, E> {
    // a triangle's edge is twice that of the quadrilaterals into which it is divided
    let (factor, halves) = if kind.shape() == CellShape::Triangle { (1.0, 1) } else { (2.0, 2) };
    let Some(layers) = layers else {
        let rim = rim(outline, holes, &mut size, factor)?;
        let filled = filled(&rim, &mut size, factor)?;
        let along: Vec<_> =
            (0..rim.vertices.len()).map(|piece| (rim.pieces[piece].0, filled.along.get(&piece).cloned().unwrap_or_default())).collect();
        let boundaries = boundaries(&rim, &along);
        return Ok(filled.finished(&rim, boundaries, kind)?);
    };
    layers.check()?;
    let near = layers.near(outline, holes)?;
    let fill = |size: &mut CellSize<E>| -> Result<Mesh, E> {
        let whole = rim(outline, holes, size, factor)?;
        let layered = layered(&whole, layers, halves)?;
        let mut filled = filled(&layered.rest, size, factor)?;
        let along = layered.complete(&mut filled)?;
        let boundaries = boundaries(&whole, &along);
        Ok(filled.finished(&layered.rest, boundaries, kind).map_err(|error| layers.cramped(error))?)
    };
    match layers.along {
        None => fill(&mut size),
        Some(_) => fill(&mut CellSize::At(&mut |point| near.size(&mut size, point))),
    }
}

/// Rim of a region in pieces of about `factor` times the size, with their curves and names.
fn rim<E: From<MeshError>>(outline: &[OutlineSide], holes: &[Vec<OutlineSide>], size: &mut CellSize<E>, factor: f64) -> Result<Rim, E> {
    let mut rim = Rim::default();
    for (number, sides) in std::iter::once(outline).chain(holes.iter().map(Vec::as_slice)).enumerate() {
        let (what, whole) = match number {
            0 => ("the outline".to_string(), "outer".to_string()),
            hole => (format!("hole {hole}"), format!("hole {hole}")),
        };
        follow_each_other(sides, &what)?;
        let first = rim.vertices.len();
        for (side, place) in sides.iter().zip(1..) {
            let places = match (&side.curve, &mut *size) {
                (Curve::Line { from, to }, CellSize::Even(even)) => {
                    let wanted = (to[0] - from[0]).hypot(to[1] - from[1]) / (factor * *even);
                    if wanted.is_nan() || wanted >= SIDE_LIMIT as f64 {
                        return Err(MeshError::TooManyCells { cells: wanted as usize, limit: SIDE_LIMIT }.into());
                    }
                    let pieces = wanted.ceil().max(1.0) as usize;
                    (0..=pieces).map(|piece| piece as f64 / pieces as f64).collect()
                }
                (curve, size) => curve.divided(|point| Ok::<f64, E>(factor * size.at(point)?), SIDE_LIMIT)?,
            };
            let mut names = vec![whole.clone()];
            names.extend(side.name.clone().filter(|name| *name != whole));
            rim.add_side(side.curve.clone(), names, format!("curve {place} of {what}"), &places);
        }
        // the body is on the left: clockwise around a hole
        rim.close_loop(first, number == 0);
    }
    for hole in 1..=holes.len() {
        let point = rim.first_of_loop(hole);
        let is_within = |other: usize| is_inside(rim.sides_of_loop(other), point);
        if !is_within(0) || (1..=holes.len()).any(|other| other != hole && is_within(other)) {
            return Err(MeshError::HoleOutside { hole }.into());
        }
    }
    Ok(rim)
}

/// Checks that each curve begins at the end of the previous one, and the first at the end of the last.
fn follow_each_other(sides: &[OutlineSide], what: &str) -> Result<(), MeshError> {
    let is_loop = |side: &OutlineSide| side.curve.start() == side.curve.end();
    if sides.is_empty() || sides.len() == 1 && !is_loop(&sides[0]) {
        return Err(MeshError::FewCorners { count: sides.len() });
    }
    for curve in 0..sides.len() {
        let before = (curve + sides.len() - 1) % sides.len();
        let (found, expected) = (sides[curve].curve.start(), sides[before].curve.end());
        if found != expected {
            return Err(MeshError::OpenOutline { what: what.into(), curve: curve + 1, found, expected });
        }
        let is_empty = matches!(sides[curve].curve, Curve::Line { .. }) && is_loop(&sides[curve]);
        if is_empty {
            return Err(MeshError::EmptySide { side: curve + 1 });
        }
    }
    Ok(())
}

/// Boundaries by the names of the rim's curves, given curve and facets of each piece in their order.
fn boundaries(rim: &Rim, along: &[(usize, Vec<Facet>)]) -> Vec<Boundary> {
    let mut boundaries: Vec<Boundary> = Vec::new();
    for (curve, facets) in along.iter().filter(|(_, facets)| !facets.is_empty()) {
        for name in &rim.names[*curve] {
            match boundaries.iter_mut().find(|boundary| boundary.name == *name) {
                Some(boundary) => boundary.facets.extend(facets),
                None => boundaries.push(Boundary::of_facets(name, facets.clone())),
            }
        }
    }
    boundaries
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn side(curve: Result<Curve, MeshError>, name: &str) -> OutlineSide {
        OutlineSide { curve: curve.unwrap(), name: (!name.is_empty()).then(|| name.to_string()) }
    }

    fn length(mesh: &Mesh, name: &str) -> f64 {
        mesh.boundary_measure(mesh.boundary(name).unwrap_or_else(|| panic!("no boundary {name}")))
    }

    /// A slot: two straight sides, a round end and a straight one, with a round hole.
    fn slot(is_reversed: bool) -> (Vec<OutlineSide>, Vec<Vec<OutlineSide>>) {
        let mut outline = vec![
            side(Curve::line([0.0, 0.0], [2.0, 0.0]), "floor"),
            side(Curve::arc([2.0, 0.0], [2.0, 2.0], [2.0, 1.0], false), "nose"),
            side(Curve::line([2.0, 2.0], [0.0, 2.0]), ""),
            side(Curve::line([0.0, 2.0], [0.0, 0.0]), "wall"),
        ];
        if is_reversed {
            outline = vec![
                side(Curve::line([0.0, 0.0], [0.0, 2.0]), "wall"),
                side(Curve::line([0.0, 2.0], [2.0, 2.0]), ""),
                side(Curve::arc([2.0, 2.0], [2.0, 0.0], [2.0, 1.0], true), "nose"),
                side(Curve::line([2.0, 0.0], [0.0, 0.0]), "floor"),
            ];
        }
        (outline, vec![vec![side(Curve::circle([1.5, 1.0], 0.4), "bore")]])
    }

    #[test]
    fn a_slot_has_its_area_and_sides_whatever_way_it_goes() {
        for is_reversed in [false, true] {
            let (outline, holes) = slot(is_reversed);
            let mesh = region(&outline, &holes, CellSize::<MeshError>::Even(0.06), CellKind::Quad4).unwrap();
            assert_eq!(mesh.defects(), []);
            let exact = 4.0 + PI / 2.0 - PI * 0.16;
            // chords of length s cut off s^2 / (8 r) of a circle of radius r
            assert!((mesh.measure() - exact).abs() < 2e-3, "{}", mesh.measure() - exact);
            assert!((length(&mesh, "floor") - 2.0).abs() < 1e-12 && (length(&mesh, "wall") - 2.0).abs() < 1e-12);
            assert!((length(&mesh, "nose") - PI).abs() < 1e-3 && (length(&mesh, "bore") - 0.8 * PI).abs() < 3e-3);
            assert_eq!(length(&mesh, "bore"), length(&mesh, "hole 1"));
            assert!((length(&mesh, "outer") - 6.0 - PI).abs() < 1e-3);
            for (name, center, radius) in [("nose", [2.0, 1.0], 1.0), ("bore", [1.5, 1.0], 0.4)] {
                for node in mesh.boundary_nodes(mesh.boundary(name).unwrap()) {
                    let [x, y, _] = mesh.points[node as usize];
                    assert!(((x - center[0]).hypot(y - center[1]) - radius).abs() < 1e-14, "{name}");
                }
            }
            let quality = mesh.quality();
            assert!(quality.smallest_scaled_jacobian > 0.15, "{quality}");
            assert!((quality.measure / quality.cells as f64).sqrt() < 0.08, "{quality}");
        }
    }

    #[test]
    fn cells_of_second_order_follow_the_curves() {
        let (outline, holes) = slot(false);
        let exact = 4.0 + PI / 2.0 - PI * 0.16;
        for kind in [CellKind::Tri3, CellKind::Tri6, CellKind::Quad4, CellKind::Quad8, CellKind::Quad9] {
            let mesh = region(&outline, &holes, CellSize::<MeshError>::Even(0.1), kind).unwrap();
            assert_eq!((mesh.only_kind(), mesh.defects()), (Some(kind), Vec::new()));
            let error = (mesh.measure() / exact - 1.0).abs();
            // edges of 0.1 on radii of 0.4 and 1: chords err by a part of h^2 / (6 r^2), parabolas by one of h^4 / (480 r^4)
            assert!(error < if kind.is_quadratic() { 1e-5 } else { 5e-3 }, "{kind:?} {error}");
            let named: usize = ["outer", "hole 1"].iter().map(|name| mesh.boundary(name).unwrap().facets.len()).sum();
            assert_eq!(named, mesh.hull().len());
        }
    }

    #[test]
    fn sizes_by_place_are_kept() {
        let square = |k: usize| [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]][k % 4];
        let outline: Vec<OutlineSide> = (0..4).map(|k| side(Curve::line(square(k), square(k + 1)), "")).collect();
        let mut wanted = |[x, y]: [f64; 2]| Ok::<f64, MeshError>(0.005 + 0.1 * x.hypot(y));
        let mesh = region(&outline, &[], CellSize::At(&mut wanted), CellKind::Quad4).unwrap();
        assert!((mesh.measure() - 1.0).abs() < 1e-12);
        let quality = mesh.quality();
        assert!(quality.smallest_scaled_jacobian > 0.15, "{quality}");
        // mean ratio of the cell size to the requested size at the center of the cell
        let ratios: Vec<f64> = (0..mesh.cell_count())
            .map(|cell| {
                let points: Vec<[f64; 3]> = mesh.cell(cell).iter().map(|&node| mesh.points[node as usize]).collect();
                let edge = |k: usize| (points[(k + 1) % 4][0] - points[k][0]).hypot(points[(k + 1) % 4][1] - points[k][1]);
                let center = mesh.cell_center(cell);
                (0..4).map(edge).sum::<f64>() / 4.0 / wanted([center[0], center[1]]).unwrap()
            })
            .collect();
        let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
        let (least, most) = ratios.iter().fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), &r| (low.min(r), high.max(r)));
        assert!((0.5..1.2).contains(&mean) && least > 0.2 && most < 2.0, "{least} {mean} {most} of {}", mesh.cell_count());
        let even = region(&outline, &[], CellSize::<MeshError>::Even(0.005), CellKind::Quad4).unwrap();
        // 1 / 0.005^2 = 40000 cells of this size: refinement is complete
        assert!((25_000..80_000).contains(&even.cell_count()), "{}", even.cell_count());
        let mut tiny = |_: [f64; 2]| Ok::<f64, MeshError>(1e-7);
        assert!(matches!(region(&outline, &[], CellSize::At(&mut tiny), CellKind::Quad4), Err(MeshError::TooManyCells { .. })));
        let mut negative = |[x, _]: [f64; 2]| Ok::<f64, MeshError>(0.1 - x);
        assert!(matches!(region(&outline, &[], CellSize::At(&mut negative), CellKind::Quad4), Err(MeshError::NotPositive { .. })));
    }

    #[test]
    fn what_does_not_bound_a_region_is_refused() {
        let refusal = |outline: &[OutlineSide], holes: &[Vec<OutlineSide>]| {
            region(outline, holes, CellSize::<MeshError>::Even(0.1), CellKind::Quad4).unwrap_err()
        };
        let (outline, _) = slot(false);
        let hole = |x: f64, radius: f64| vec![side(Curve::circle([x, 1.0], radius), "")];
        assert!(matches!(refusal(&outline[..3], &[]), MeshError::OpenOutline { curve: 1, .. }));
        assert!(matches!(refusal(&outline[..1], &[]), MeshError::FewCorners { .. }));
        assert!(matches!(refusal(&outline, &[hole(5.0, 0.4)]), MeshError::HoleOutside { hole: 1 }));
        assert!(matches!(refusal(&outline, &[hole(1.0, 0.4), hole(1.0, 0.2)]), MeshError::HoleOutside { .. }));
        let crossing = refusal(&outline, &[hole(0.2, 0.4)]);
        assert!(crossing.to_string().contains("curve 1 of hole 1") && crossing.to_string().contains("touch or cross"), "{crossing}");
        // a circle that touches a side leaves no room for cells
        refusal(&outline, &[hole(0.4, 0.4)]);
        assert!(!crossing.hint().is_empty());
        let bow = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
        let bow: Vec<OutlineSide> = (0..4).map(|k| side(Curve::line(bow[k], bow[(k + 1) % 4]), "")).collect();
        assert!(matches!(refusal(&bow, &[]), MeshError::CrossingCurves { .. }));
    }
}
