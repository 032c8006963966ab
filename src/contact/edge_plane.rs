//! Plane that stands for a sharp edge of a rigid obstacle where a smooth surface slides across it.
//!
//! Where the edge lies between two nodes of the surface, a constraint of the edge against the facet acts along the facet's normal
//! (`rigid_corners.rs`), with a small admitted overlap. As the edge passes a node, this node lies behind both sides of the obstacle.
//! The force of either side would have another direction; that of the side ahead would stop the motion. In a step that begins like this,
//! the constraint of a node against an obstacle acts along the surface's normal, too: its gap is that to a plane through the edge. In
//! node-to-segment contact of two bodies the node has no constraint in this step. Both need the constraint of the edge.

use nalgebra::{DMatrix, DVector, SVector};

use super::bends::CORNER_BESIDE_NODES;

/// Distance from a sharp edge or corner of an obstacle, in smallest facets, within which the edge may stand for the obstacle. A facet
/// inclined by 11 degrees to a side of the obstacle overlaps it up to this distance when the edge has the admitted overlap of 0.02.
pub const ACROSS_EDGE: f64 = 0.1;

/// Distance from a sharp edge or convex corner of an obstacle, in smallest facets, within which a node has the plane of one face as
/// obstacle in a step.
const AT_EDGE: f64 = 0.02;

/// Largest overlap with the plane at the start of a step, in smallest facets; above the admitted overlap of corners, far below a node that
/// has entered through a side.
const DEEP: f64 = 0.05;

/// Distance from the plane, in smallest facets, up to which a node touches it: the plane of a facet that turns about the edge from step to
/// step would otherwise leave the node, which then enters by a step before it is held again.
const TOUCHES: f64 = 0.005;

/// Largest cosine by which the surface next to a node may recede behind a side of the obstacle that is in front of the node.
const RECEDES: f64 = 0.1;

/// Cosine of the angle between the facets at a node, 45 degrees, from which on the node is a tip, whose own constraint is needed. A load at
/// one node of a coarse surface bends it by more than 20 degrees.
const TIP: f64 = 0.707;

/// Largest number of sides at an edge or vertex that are considered.
const SIDES: usize = 4;

/// Cosine of the angle between a facet and a side of the obstacle, 1 degree, above which the facet lies along the side.
const ALONG: f64 = 0.999_8;

/// Cosine of the angle between two normals from which on both belong to one side.
const ALIKE: f64 = 0.999_999;

/// Sides of an obstacle at a sharp edge or convex corner near a node.
#[derive(Clone, Debug)]
pub struct AtEdge<const D: usize> {
    /// Outward unit normals of the sides, first the side to which the node belongs.
    pub normals: Vec<SVector<f64, D>>,
    /// Point of each side's plane.
    pub points: Vec<SVector<f64, D>>,
    /// Nearest points of the edges.
    pub edge: Vec<SVector<f64, D>>,
    /// Distance of the node from the obstacle's surface, or of the nearest point there from the edge, if that is larger `[length]`.
    pub distance: f64,
}

/// Node of a surface near a sharp edge or convex corner of an obstacle.
pub struct NodeAtEdge<const D: usize> {
    /// Sides of the obstacle at the edge.
    pub at: AtEdge<D>,
    /// Position of the node.
    pub x: SVector<f64, D>,
    /// Directions to the neighbors of the node.
    pub around: Vec<SVector<f64, D>>,
    /// Inward normals of the surface's facets at the node, of any length.
    pub facing: Vec<SVector<f64, D>>,
    /// Smallest facet `[length]`.
    pub size: f64,
    /// True if sharp edges of the obstacle have constraints of their own against the facets.
    pub is_beside_corners: bool,
}

impl<const D: usize> NodeAtEdge<D> {
    /// True if the node is so near to the edge that the plane of a face stands for the obstacle.
    pub fn is_on_edge(&self) -> bool {
        self.at.distance <= AT_EDGE * self.size
    }

    /// True if the surface next to the node does not recede behind a side with the normal `normal`.
    pub fn is_in_front(&self, normal: SVector<f64, D>) -> bool {
        self.around.iter().all(|to| normal.dot(&to.normalize()) >= -RECEDES)
    }

    /// Plane (point, normal) through an edge of an obstacle for a node that is not in front of its own side. The normal is the direction
    /// nearest to that of a facet between the normals of the sides. If it is that of a side, the plane is this side; otherwise it goes
    /// through the node where that touches or overlaps: the overlap is kept. `None` if the node is in front of its side, if a facet lies
    /// along a side, as at the edge of a flat punch, or if the node overlaps the plane by more than the edge may.
    pub fn plane_through(&self) -> Option<[SVector<f64, D>; 2]> {
        let NodeAtEdge { at, x, size, .. } = self;
        let own = *at.normals.first()?;
        if self.is_in_front(own) {
            return None;
        }
        let mut distinct: Vec<SVector<f64, D>> = Vec::new();
        for normal in &at.normals {
            if distinct.len() < SIDES && distinct.iter().all(|other| other.dot(normal) < ALIKE) {
                distinct.push(*normal);
            }
        }
        let facing: Vec<SVector<f64, D>> = self.facing.iter().filter_map(|normal| normal.try_normalize(0.0)).collect();
        let lies_along = |direction: &SVector<f64, D>| distinct.iter().find(|normal| normal.dot(direction) > ALONG);
        if facing.iter().any(|direction| lies_along(direction).is_some()) {
            return None;
        }
        let between = nearest_between(&distinct, facing.into_iter().max_by(|a, b| a.dot(&own).total_cmp(&b.dot(&own)))?)?;
        let side = lies_along(&between);
        let normal = side.copied().unwrap_or(between);
        let point = *at.edge.iter().max_by(|a, b| a.dot(&normal).total_cmp(&b.dot(&normal)))?;
        let gap = normal.dot(&(x - point));
        let kept = if side.is_some() || gap > TOUCHES * size { 0.0 } else { gap };
        (gap >= -DEEP * size).then(|| [point + normal * kept, normal])
    }

    /// True if a sharp edge of another body, which has constraints of its own against the facets of the node, passes a node of a smooth
    /// part of the surface that is not in front of the side to which it belongs. The normals of the facets are unit vectors.
    pub fn is_passed(&self) -> bool {
        let bends = |normals: &[SVector<f64, D>], cosine: f64| normals.iter().any(|normal| normal.dot(&normals[0]) < cosine);
        bends(&self.at.normals, CORNER_BESIDE_NODES) && !bends(&self.facing, TIP) && self.plane_through().is_some()
    }
}

/// Unit vector nearest to `direction` among the nonnegative combinations of unit vectors: of the least-squares solutions of every set of up
/// to `D` vectors without negative coefficients the one with the largest projection.
fn nearest_between<const D: usize>(vectors: &[SVector<f64, D>], direction: SVector<f64, D>) -> Option<SVector<f64, D>> {
    let solved = |set: usize| -> Option<SVector<f64, D>> {
        let chosen: Vec<SVector<f64, D>> = (0..vectors.len()).filter(|k| set >> k & 1 == 1).map(|k| vectors[k]).collect();
        let count = chosen.len();
        if count > D {
            return None;
        }
        let products = DMatrix::from_fn(count, count, |i, k| chosen[i].dot(&chosen[k]));
        let shares = products.cholesky()?.solve(&DVector::from_fn(count, |i, _| chosen[i].dot(&direction)));
        let is_between = shares.iter().all(|share| *share >= 0.0);
        let sum: SVector<f64, D> = chosen.iter().zip(shares.iter()).map(|(vector, share)| vector * *share).sum();
        sum.try_normalize(0.0).filter(|_| is_between)
    };
    (1..1 << vectors.len()).filter_map(solved).max_by(|a, b| a.dot(&direction).total_cmp(&b.dot(&direction)))
}

#[cfg(test)]
mod tests {
    use nalgebra::{Vector2, Vector3};

    use super::*;

    /// Closed forms: directions between two and three perpendicular normals, and beyond them.
    #[test]
    fn nearest_directions() {
        let (left, top) = (Vector2::new(-1.0, 0.0), Vector2::new(0.0, 1.0));
        let facet = Vector2::new(-0.6, 0.8);
        assert!((nearest_between(&[left, top], facet).unwrap() - facet).norm() < 1e-15);
        assert_eq!(nearest_between(&[left, top], Vector2::new(0.6, 0.8)), Some(top));
        let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()];
        let diagonal = Vector3::new(1.0, 2.0, 3.0).normalize();
        assert!((nearest_between(&[x, y, z], diagonal).unwrap() - diagonal).norm() < 1e-15);
        let across = nearest_between(&[x, y, z], Vector3::new(1.0, 1.0, -3.0).normalize()).unwrap();
        assert!((across - Vector3::new(1.0, 1.0, 0.0).normalize()).norm() < 1e-15);
        // Both triangles of a side have the same normal.
        assert_eq!(nearest_between(&[x, x, y], (x - y).normalize()), Some(x));
    }

    #[test]
    fn a_node_that_is_deeper_than_an_edge_may_be_keeps_its_side() {
        let edge = vec![Vector2::zeros()];
        let normals = vec![Vector2::new(-1.0, 0.0), Vector2::new(0.0, 1.0)];
        let (at, facing) = (AtEdge { points: vec![edge[0]; 2], normals, edge, distance: 0.0 }, Vector2::new(-0.6, 0.8));
        let around = vec![Vector2::new(0.8, 0.6), Vector2::new(-0.8, -0.6)];
        let mut node = NodeAtEdge { at, x: -0.02 * facing, around, facing: vec![facing], size: 1.0, is_beside_corners: true };
        assert!(node.plane_through().is_some());
        node.x = -0.08 * facing;
        assert!(node.plane_through().is_none());
    }
}
