//! Hulls of bodies in space, and points of one hull inside of another, for the detection of initial overlaps, independent of the defined
//! contacts.

use rstar::RTree;
use rstar::primitives::{GeomWithData, Rectangle};

use super::faces::{self, FacetDistance, Vector};
use super::surface::{Edge, Surface};

/// Admitted overlap as a fraction of the facet size, in addition to the height of curved sides.
const ALLOWED: f64 = 0.01;

/// Angle between adjacent facets `[rad]` above which they form an edge, without curvature of the surface there: 45 degrees.
const EDGE: f64 = std::f64::consts::FRAC_PI_4;

/// Hull of a body in space.
pub struct Solid {
    surface: Surface,
    edges: Vec<Edge>,
    q: Vec<f64>,
    tree: RTree<GeomWithData<Rectangle<[f64; 3]>, u32>>,
    /// Admitted overlap of each facet: estimated height of the curved surface over it plus a fraction of its size `[length]`.
    allowed: Vec<f64>,
    bounds: [Vector; 2],
}

/// Deepest point of two hulls inside of each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HullPenetration {
    /// Penetration `[length]`.
    pub depth: f64,
    /// Size of the smaller one of the two facets at the deepest point `[length]`.
    pub size: f64,
    /// Position `[length]`.
    pub at: [f64; 3],
}

impl Solid {
    /// Hull with the given facets, counter-clockwise as seen from outside, in indices of nodes with positions `q`.
    pub fn new<'a>(facets: impl IntoIterator<Item = &'a [u32]>, q: Vec<f64>) -> Solid {
        let surface = Surface::in_space(facets);
        let mut turns = vec![0.0f64; surface.count()];
        let edges = surface.edges();
        for edge in &edges {
            let [Some(one), Some(other)] = edge.facets else { continue };
            let normal = |facet: u32| faces::normal(surface.facet(facet as usize), &q);
            let turn = normal(one).angle(&normal(other));
            for facet in [one, other].into_iter().filter(|_| turn < EDGE) {
                turns[facet as usize] = turns[facet as usize].max(turn);
            }
        }
        let allowed = turns.iter().enumerate().map(|(facet, turn)| surface.facet_size(facet, &q) * (ALLOWED + turn / 4.0)).collect();
        let boxed = |facet: usize| {
            let [low, high] = faces::bounds(surface.facet(facet).iter().map(|&node| faces::at(node, &q)));
            GeomWithData::new(Rectangle::from_corners(low.into(), high.into()), facet as u32)
        };
        let tree = RTree::bulk_load((0..surface.count()).map(boxed).collect());
        let bounds = faces::bounds(surface.nodes().iter().map(|&node| faces::at(node, &q)));
        Solid { surface, edges, tree, allowed, bounds, q }
    }

    /// Nearest facet to a point inside of the hull, with its distance; `None` outside, or if the nearest point is on an edge.
    fn around(&self, x: Vector) -> Option<(usize, f64)> {
        let is_out = (0..3).any(|i| x[i] <= self.bounds[0][i] || x[i] >= self.bounds[1][i]);
        if is_out {
            return None;
        }
        let mut nearest: Option<(usize, FacetDistance)> = None;
        for (found, square) in self.tree.nearest_neighbor_iter_with_distance_2(x.into()) {
            if nearest.is_some_and(|(_, seen)| square > seen.distance * seen.distance) {
                break;
            }
            let seen = FacetDistance::new(x, self.surface.facet(found.data as usize), &self.q);
            if nearest.is_none_or(|(_, known)| seen.distance < known.distance) {
                nearest = Some((found.data as usize, seen));
            }
        }
        nearest.filter(|(_, seen)| !seen.is_beside && seen.gap < 0.0).map(|(facet, seen)| (facet, seen.distance))
    }

    /// Deepest node, or middle of a facet or edge, of this hull inside of another one.
    fn deepest_in(&self, other: &Solid) -> Option<HullPenetration> {
        let surface = &self.surface;
        let at = |node: u32| faces::at(node, &self.q);
        let nodes = surface.nodes().iter().enumerate().map(|(index, &node)| (surface.adjacent_facets(index).to_vec(), at(node)));
        let edges =
            self.edges.iter().map(|edge| (edge.facets.into_iter().flatten().collect(), 0.5 * (at(edge.nodes[0]) + at(edge.nodes[1]))));
        let facets = (0..surface.count()).map(|facet| (vec![facet as u32], faces::middle(surface.facet(facet), &self.q)));
        // The admitted overlap is that of the adjacent facet for which it is smallest.
        let sunk = |(on, x): (Vec<u32>, Vector)| {
            let (facet, depth) = other.around(x)?;
            let own = on.into_iter().map(|own| own as usize).min_by(|&a, &b| self.allowed[a].total_cmp(&self.allowed[b]))?;
            let size = surface.facet_size(own, &self.q).min(other.surface.facet_size(facet, &other.q));
            (depth > self.allowed[own] + other.allowed[facet]).then(|| HullPenetration { depth, size, at: x.into() })
        };
        nodes.chain(edges).chain(facets).filter_map(sunk).max_by(|a, b| a.depth.total_cmp(&b.depth))
    }

    /// Deepest point of two hulls inside of each other, sampled at nodes and at middles of facets and edges.
    pub fn inside(&self, other: &Solid) -> Option<HullPenetration> {
        let apart = |i: usize| self.bounds[0][i] >= other.bounds[1][i] || other.bounds[0][i] >= self.bounds[1][i];
        if (0..3).any(apart) {
            return None;
        }
        [self.deepest_in(other), other.deepest_in(self)].into_iter().flatten().max_by(|a, b| a.depth.total_cmp(&b.depth))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Box with one facet per side; `from` is its lowest corner.
    fn solid(from: [f64; 3], size: [f64; 3]) -> Solid {
        let corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
        let q = corners.iter().flat_map(|corner| (0..3).map(move |i| from[i] + f64::from(corner[i]) * size[i])).collect();
        let facets: [[u32; 4]; 6] = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
        Solid::new(facets.iter().map(|facet| &facet[..]), q)
    }

    #[test]
    fn what_touches_is_not_inside_and_what_overlaps_is_as_deep_as_it_is() {
        let cube = solid([0.0; 3], [1.0; 3]);
        for (from, depth) in [([1.0, 0.0, 0.0], None), ([0.3, 0.2, 1.0], None), ([0.2, 0.1, 0.9], Some(0.1)), ([2.0, 0.0, 0.0], None)] {
            let found = cube.inside(&solid(from, [1.0; 3]));
            assert_eq!(found.map(|found| (found.depth * 1e9).round() * 1e-9), depth, "{from:?}");
        }
        // Two crossed bars have no node inside of each other; a small box may be inside as a whole.
        let bar = solid([-2.0, 0.3, 0.3], [5.0, 0.4, 0.4]);
        assert!(cube.inside(&bar).is_some_and(|found| found.depth > 0.1));
        assert!(cube.inside(&solid([0.4; 3], [0.2; 3])).is_some());
    }
}
