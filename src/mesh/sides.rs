//! Facets of the hull by their normals, for meshes without names.

use std::collections::HashMap;

use super::check::{between, cross, dot, norm};
use super::{Boundary, Facet, Mesh, MeshError};

impl Mesh {
    /// Mesh with a further boundary that consists of the given facets.
    ///
    /// # Errors
    /// A boundary of that name exists.
    pub fn with_boundary(mut self, name: &str, facets: Vec<Facet>) -> Result<Mesh, MeshError> {
        if self.boundary(name).is_some() {
            let available = self.boundaries.iter().map(|boundary| boundary.name.clone()).collect();
            return Err(MeshError::BoundaryExists { name: name.into(), available });
        }
        self.boundaries.push(Boundary::of_facets(name, facets));
        Ok(self)
    }

    /// Corners of a facet, without the middle nodes of its edges.
    fn corners(&self, facet: Facet) -> Vec<u32> {
        let nodes: Vec<u32> = self.facet_nodes(facet).collect();
        let count = match (self.dimension(), nodes.len()) {
            (2, _) => 2,
            (_, 3 | 6) => 3,
            _ => 4,
        };
        nodes[..count].to_vec()
    }

    /// Outward unit normal of the polygon of a facet's corners.
    pub fn facet_normal(&self, facet: Facet) -> [f64; 3] {
        let places: Vec<[f64; 3]> = self.corners(facet).into_iter().map(|node| self.points[node as usize]).collect();
        let normal = match places[..] {
            [a, b] => cross(between(a, b), [0.0, 0.0, 1.0]),
            [a, b, c] => cross(between(a, b), between(a, c)),
            [a, b, c, d] => cross(between(a, c), between(b, d)),
            _ => [0.0; 3],
        };
        let length = norm(normal);
        normal.map(|x| if length > 0.0 { x / length } else { 0.0 })
    }

    /// Facets of the hull whose normals make an angle of at most `angle` `[rad]` with a direction.
    pub fn facets_by_normal(&self, direction: [f64; 3], angle: f64) -> Vec<Facet> {
        let unit = direction.map(|x| x / norm(direction));
        self.hull().into_iter().filter(|&facet| angle_between(self.facet_normal(facet), unit) <= angle).collect()
    }

    /// Facets of the hull that are reached from the facet nearest to a point (by its center), over edges (in the plane: nodes) at which the
    /// normal turns by at most `angle` `[rad]`.
    pub fn facets_from(&self, point: [f64; 3], angle: f64) -> Vec<Facet> {
        let hull = self.hull();
        let normals: Vec<[f64; 3]> = hull.iter().map(|&facet| self.facet_normal(facet)).collect();
        let mut sharing: HashMap<[u32; 2], Vec<usize>> = HashMap::new();
        let edges: Vec<Vec<[u32; 2]>> = hull.iter().map(|&facet| self.edges_of(facet)).collect();
        for (index, edge) in edges.iter().enumerate().flat_map(|(index, edges)| edges.iter().map(move |edge| (index, edge))) {
            sharing.entry(*edge).or_default().push(index);
        }
        let middle = |facet: Facet| {
            let corners = self.corners(facet);
            [0, 1, 2].map(|i| corners.iter().map(|&node| self.points[node as usize][i]).sum::<f64>() / corners.len() as f64)
        };
        let distances: Vec<f64> = hull.iter().map(|&facet| norm(between(middle(facet), point))).collect();
        let Some(seed) = (0..hull.len()).min_by(|&a, &b| distances[a].total_cmp(&distances[b])) else { return Vec::new() };
        let (mut reached, mut waiting) = (vec![false; hull.len()], vec![seed]);
        reached[seed] = true;
        while let Some(current) = waiting.pop() {
            for &next in edges[current].iter().flat_map(|edge| &sharing[edge]) {
                if !reached[next] && angle_between(normals[current], normals[next]) <= angle {
                    reached[next] = true;
                    waiting.push(next);
                }
            }
        }
        hull.into_iter().zip(reached).filter(|(_, is_reached)| *is_reached).map(|(facet, _)| facet).collect()
    }

    /// Edges of a facet as ascending pairs of corners; in the plane its ends, each twice.
    fn edges_of(&self, facet: Facet) -> Vec<[u32; 2]> {
        let corners = self.corners(facet);
        match corners[..] {
            [a, b] => vec![[a, a], [b, b]],
            _ => (0..corners.len()).map(|k| (corners[k], corners[(k + 1) % corners.len()])).map(|(a, b)| [a.min(b), a.max(b)]).collect(),
        }
    }
}

/// Angle between unit vectors `[rad]`, accurate for small angles.
fn angle_between(a: [f64; 3], b: [f64; 3]) -> f64 {
    norm(cross(a, b)).atan2(dot(a, b))
}

#[cfg(test)]
mod tests {
    use crate::elements::CellKind;
    use crate::mesh::{block, cylinder, rectangle};

    #[test]
    fn normals_pick_sides_of_blocks_of_every_kind() {
        let cube = block([1.0, 2.0, 3.0], [2; 3], [0.0; 3]).unwrap();
        for kind in [CellKind::Hex8, CellKind::Tet4, CellKind::Tet10, CellKind::Hex20, CellKind::Hex27] {
            let mesh = cube.with_cells(kind).unwrap();
            for (name, direction) in [("right", [1.0, 0.0, 0.0]), ("top", [0.0, 7.0, 0.0]), ("back", [0.0, 0.0, -1.0])] {
                let mut facets = mesh.facets_by_normal(direction, 0.01);
                let mut expected = mesh.boundary(name).unwrap().facets.clone();
                facets.sort_unstable();
                expected.sort_unstable();
                assert_eq!(facets, expected, "{kind:?} {name}");
                let point = [0, 1, 2].map(|i| {
                    if direction[i] > 0.0 {
                        9.0
                    } else if direction[i] < 0.0 {
                        -9.0
                    } else {
                        0.8
                    }
                });
                assert_eq!(mesh.facets_from(point, 0.01), facets, "{kind:?} {name}");
            }
        }
        let plate = rectangle([2.0, 1.0], [4, 2], [0.0; 2]).unwrap();
        let upside: Vec<_> = plate.boundary("top").unwrap().facets.iter().rev().copied().collect();
        assert_eq!(plate.facets_by_normal([0.0, 1.0, 0.0], 0.1), upside);
        assert_eq!(plate.facets_from([1.0, -0.2, 0.0], 0.1), plate.boundary("bottom").unwrap().facets);
    }

    #[test]
    fn a_seed_grows_round_a_smooth_side_and_stops_at_its_rim() {
        let rod = cylinder(1.0, 2.0, [2, 16, 2], [0.0; 3], 1.0).unwrap();
        // Normals turn by 22.5 degrees between facets of the round side, and by 90 degrees at its rim.
        let side = rod.facets_from([1.0, 0.0, 1.0], 0.5);
        assert_eq!(side.len(), 32);
        assert!(side.iter().all(|&facet| rod.facet_normal(facet)[2].abs() < 1e-12));
        let all = rod.facets_from([1.0, 0.0, 1.0], 2.0);
        assert_eq!(all.len(), rod.hull().len());
    }
}
