//! Validity of the surface of a mesh in space as that of a solid body: closed where cells meet, not folded, without self-intersection.

use std::collections::HashMap;

use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use super::check::{between, cross, dot, norm};
use super::{Facet, Mesh, MeshError};
use crate::math::tolerances::{PIERCED, SAME_PLACE};

type Vector = [f64; 3];

/// Smallest part of an edge behind a facet that counts as an intersection. Polygons on touching round sides with nonmatching nodes overlap
/// by an eighth of the angle between facets, 0.03 at 15 degrees.
const DEEP: f64 = 0.05;

impl Mesh {
    /// Returns defects of the surface of a mesh in space whose cells are sound; always empty in the plane.
    ///
    /// One error per kind of defect, with its first place and its count: folded facets, coincident facets without common nodes (cells are
    /// not joined there), and edges that go through facets elsewhere.
    ///
    /// Parts that only touch do not go through each other.
    pub fn surface_defects(&self) -> Vec<MeshError> {
        if self.dimension() != 3 {
            return Vec::new();
        }
        let corners = |facet: Facet| self.facet_nodes(facet).take(self.facet_corners(facet)).collect();
        let hull: Vec<(Facet, Vec<u32>)> = self.hull().into_iter().map(|facet| (facet, corners(facet))).collect();
        [self.folded(&hull), self.unjoined(&hull), self.crossing(&hull)].into_iter().flatten().collect()
    }

    fn places(&self, nodes: &[u32]) -> Vec<Vector> {
        nodes.iter().map(|&node| self.points[node as usize]).collect()
    }

    /// Facets of four corners with a corner normal against the facet normal: their projection along the facet normal is not a convex
    /// quadrilateral, so that contact is not defined on them.
    fn folded(&self, hull: &[(Facet, Vec<u32>)]) -> Option<MeshError> {
        let is_folded = |nodes: &[u32]| {
            let [a, b, c, d] = <[Vector; 4]>::try_from(self.places(nodes)).ok()?;
            let normal = cross(between(a, c), between(b, d));
            let corner = |before, at, after| dot(normal, cross(between(at, after), between(at, before)));
            Some([corner(d, a, b), corner(a, b, c), corner(b, c, d), corner(c, d, a)].into_iter().any(|turn| turn <= 0.0))
        };
        let folded: Vec<_> = hull.iter().filter(|(_, nodes)| is_folded(nodes) == Some(true)).collect();
        let (facet, nodes) = folded.first()?;
        Some(MeshError::FoldedFacet { cell: facet.cell.into(), at: middle(&self.places(nodes)), count: folded.len() })
    }

    /// Coincident facets of the hull without common nodes.
    fn unjoined(&self, hull: &[(Facet, Vec<u32>)]) -> Option<MeshError> {
        let extent = self.points.as_flattened().iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let near = (SAME_PLACE * extent).powi(2);
        let mut nodes: Vec<u32> = hull.iter().flat_map(|(_, nodes)| nodes.iter().copied()).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let tree = RTree::bulk_load(nodes.iter().map(|&node| GeomWithData::new(self.points[node as usize], node)).collect());
        // Coincident nodes are represented by the one with the smallest number.
        let first = |node: u32| tree.locate_within_distance(self.points[node as usize], near).map(|found| found.data).min().unwrap_or(node);
        let firsts: HashMap<u32, u32> = nodes.iter().map(|&node| (node, first(node))).collect();
        let mut keyed: Vec<(Vec<u32>, usize)> = hull
            .iter()
            .zip(0..)
            .map(|((_, nodes), index)| {
                let mut key: Vec<u32> = nodes.iter().map(|node| firsts[node]).collect();
                key.sort_unstable();
                (key, index)
            })
            .collect();
        keyed.sort_unstable();
        let on_each_other: Vec<usize> = keyed.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() > 1).map(|same| same[0].1).collect();
        let &index = on_each_other.iter().min()?;
        Some(MeshError::Unjoined { count: on_each_other.len(), at: middle(&self.places(&hull[index].1)) })
    }

    /// Edges of the hull that intersect facets without common nodes.
    fn crossing(&self, hull: &[(Facet, Vec<u32>)]) -> Option<MeshError> {
        let boxes = hull.iter().zip(0usize..).map(|((_, nodes), index)| {
            let [low, high] = bounds(&self.places(nodes));
            GeomWithData::new(Rectangle::from_corners(low, high), index)
        });
        let tree = RTree::bulk_load(boxes.collect());
        let mut edges: Vec<([u32; 2], u32)> = hull
            .iter()
            .flat_map(|(facet, nodes)| (0..nodes.len()).map(|k| ([nodes[k], nodes[(k + 1) % nodes.len()]], facet.cell)))
            .map(|([a, b], cell)| ([a.min(b), a.max(b)], cell))
            .collect();
        edges.sort_unstable();
        edges.dedup_by_key(|(ends, _)| *ends);
        let mut found: Vec<(u32, u32, Vector)> = Vec::new();
        for (ends, cell) in edges {
            let [a, b] = ends.map(|node| self.points[node as usize]);
            let [low, high] = bounds(&[a, b]);
            for other in tree.locate_in_envelope_intersecting(AABB::from_corners(low, high)) {
                let (facet, nodes) = &hull[other.data];
                if ends.iter().any(|end| nodes.contains(end)) {
                    continue;
                }
                found.extend(pierced(a, b, &self.places(nodes)).map(|at| (cell, facet.cell, at)));
            }
        }
        let &(cell, other, at) = found.iter().min_by_key(|(cell, other, _)| (cell, other))?;
        Some(MeshError::CrossingSurface { cells: [cell.into(), other.into()], at: at.to_vec(), count: found.len() })
    }
}

fn middle(points: &[Vector]) -> Vec<f64> {
    (0..3).map(|i| points.iter().map(|point| point[i]).sum::<f64>() / points.len() as f64).collect()
}

fn bounds(points: &[Vector]) -> [Vector; 2] {
    [f64::min, f64::max].map(|pick: fn(f64, f64) -> f64| [0, 1, 2].map(|i| points.iter().map(|p| p[i]).reduce(pick).unwrap_or_default()))
}

/// Intersection of the line from `a` to `b` with the interior of a facet, well beyond it on both sides; `None` without one. A facet of four
/// corners is split into two triangles, whose common diagonal counts as interior.
fn pierced(a: Vector, b: Vector, facet: &[Vector]) -> Option<Vector> {
    let along = between(a, b);
    let through = |corners: [Vector; 3], has_diagonal: bool| {
        let [p, u, v] = [corners[0], between(corners[0], corners[1]), between(corners[0], corners[2])];
        let normal = cross(u, v);
        let (square, slope) = (dot(normal, normal), dot(normal, along));
        let from = dot(normal, between(a, p));
        let share = from / slope;
        let is_deep = share * (1.0 - share) > 0.0 && slope.abs() * share.min(1.0 - share) > DEEP * norm(along) * square.sqrt();
        if !is_deep {
            return None;
        }
        let at = [0, 1, 2].map(|i| a[i] + share * along[i]);
        let arm = between(p, at);
        // Barycentric coordinates of the second and third corner; that of the first is the remainder.
        let [second, third] = [dot(normal, cross(arm, v)) / square, dot(normal, cross(u, arm)) / square];
        // The diagonal of a quadrilateral, between its first and third corner, counts as interior: there the second coordinate is 0.
        let on_diagonal = if has_diagonal { -PIERCED } else { PIERCED };
        (second > on_diagonal && third > PIERCED && 1.0 - second - third > PIERCED).then_some(at)
    };
    match *facet {
        [p, q, r] => through([p, q, r], false),
        [p, q, r, s] => through([p, q, r], true).or_else(|| through([r, s, p], true)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elements::CellKind;
    use crate::mesh::{Change, block, disk, rectangle, sphere, torus};

    /// Union of two meshes without common nodes.
    fn together(one: &Mesh, other: &Mesh) -> Mesh {
        let shift = one.points.len() as u32;
        let mut both = one.clone();
        both.points.extend(&other.points);
        both.blocks[0].connectivity.extend(other.connectivity().map(|node| node + shift));
        both.boundaries.clear();
        both
    }

    fn moved(mesh: &Mesh, by: Vector) -> Mesh {
        mesh.clone().translate(by).unwrap()
    }

    #[test]
    fn sound_solids_have_sound_surfaces() {
        for mesh in [
            block([1.0, 2.0, 3.0], [2, 3, 4], [0.0; 3]).unwrap(),
            sphere(1.0, [2, 16], [1.0; 3], 1.0).unwrap(),
            torus(2.0, 0.5, [1, 12, 24], [0.0; 3]).unwrap(),
        ] {
            assert_eq!(mesh.surface_defects(), []);
            assert_eq!(mesh.with_cells(CellKind::Tet4).unwrap().surface_defects(), []);
        }
        assert_eq!(rectangle([1.0; 2], [1; 2], [0.0; 2]).unwrap().surface_defects(), []);
    }

    #[test]
    fn a_surface_through_itself_is_found_where_it_is_and_touching_is_none() {
        for kind in [CellKind::Hex8, CellKind::Tet4] {
            let cube = block([1.0; 3], [2; 3], [0.0; 3]).unwrap().with_cells(kind).unwrap();
            for by in [[0.9, 0.1, 0.2], [0.6, 0.7, 0.65], [0.25, 0.3, 0.75]] {
                let both = together(&cube, &moved(&cube, by));
                assert_eq!(both.defects(), []);
                let found = both.surface_defects();
                let [MeshError::CrossingSurface { cells: [one, other], at, count }] = &found[..] else { panic!("{by:?}: {found:?}") };
                let half = cube.cell_count() as u64;
                assert!((*one < half) != (*other < half) && *count > 1, "{found:?}");
                assert!((0..3).all(|i| at[i] >= by[i] - 1e-12 && at[i] <= 1.0 + 1e-12), "{found:?}");
                assert!(found[0].to_string().starts_with("the surface of the mesh goes through itself at ("), "{}", found[0]);
            }
            // Cubes in contact at a face, an edge, a corner and part of a face, and separate cubes.
            for by in [[1.0, 0.2, 0.3], [1.0, 1.0, 0.1], [1.0, 1.0, 1.0], [1.0, 0.0, 0.25], [1.2, 0.0, 0.0]] {
                assert_eq!(together(&cube, &moved(&cube, by)).surface_defects(), [], "{by:?}");
            }
        }
        // A bar that is extruded along a path through the bar itself.
        let mut path: Vec<Vector> = (0..=30).map(|k| 0.2 * f64::from(k)).map(|t| [2.0 * t.sin(), 2.0 * t.cos(), 0.02 * t]).collect();
        path.extend((31..=40).map(|k| 0.2 * f64::from(k)).map(|t| [2.0 * t.sin(), 2.0 * t.cos(), 0.02 * t]));
        let coil = disk(0.3, [1, 8], [0.0; 2]).unwrap().extruded_along(&path, Change::NONE).unwrap();
        assert!(matches!(coil.surface_defects()[..], [MeshError::CrossingSurface { .. }]));
    }

    #[test]
    fn cells_that_are_not_joined_are_found() {
        let cube = block([1.0; 3], [2; 3], [0.0; 3]).unwrap();
        let found = together(&cube, &moved(&cube, [1.0, 0.0, 0.0])).surface_defects();
        assert_eq!(found, [MeshError::Unjoined { count: 4, at: vec![1.0, 0.25, 0.25] }]);
        assert_eq!(cube.joined(&moved(&cube, [1.0, 0.0, 0.0])).unwrap().surface_defects(), []);
        assert!(!found[0].hint().is_empty());
    }

    #[test]
    fn a_folded_facet_is_found_though_its_cell_can_be_computed_with() {
        let mut cube = block([1.0; 3], [2, 2, 1], [0.0; 3]).unwrap();
        // A corner of the upper side is moved beyond the diagonal of its facet.
        let corner = cube.points.iter().position(|point| *point == [1.0; 3]).unwrap();
        cube.points[corner] = [0.72, 0.72, 1.0];
        assert_eq!(cube.defects(), []);
        let found = cube.surface_defects();
        assert!(matches!(found[..], [MeshError::FoldedFacet { cell: 3, count: 1, .. }]), "{found:?}");
        assert!(found[0].hint().contains("tetrahedra"));
        // Moderate warping of the facet is permitted.
        cube.points[corner] = [1.0, 1.0, 1.4];
        assert_eq!(cube.surface_defects(), []);
    }
}
