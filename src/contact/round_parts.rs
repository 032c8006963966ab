//! Detection of round parts of a surface from its nodes: arcs in the plane, parts of spheres and rims of cylinders in space.
//!
//! A node is *inside* a round part if it and its neighbors lie on one circle or sphere, convex outwards, with angles of at most
//! [`ROUND`] between neighbors as seen from the center. Adjacent inside nodes with equal circles form a part; its *rim* are their
//! neighbors that are not inside. With the node at the origin, the center `c` satisfies `2 c.y = y.y` for its neighbors `y`, in space by
//! least squares.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};

use super::surface::{Edge, Surface};
use crate::math::tolerances::{ROUND_PART, ROUND_PART_TURN};

/// Largest angles between neighbors as seen from the center or the axis of a round part `[rad]`.
#[derive(Clone, Copy)]
struct Turns {
    /// In arcs of the plane.
    arc: f64,
    /// In parts of spheres.
    sphere: f64,
    /// Around cylinders.
    cylinder: f64,
}

/// Angles of round parts. A circle of twelve facets is round, an octagon is not. A sphere with eight facets around has 55 degrees from the
/// middle of a side of its cube to the corner, an icosahedron 63.
const ROUND: Turns = Turns { arc: 30.5 * PI / 180.0, sphere: 55.5 * PI / 180.0, cylinder: 44.5 * PI / 180.0 };

/// Angles of circles and cylinders that may be meant, which the mesh makes an octagon.
const COARSE: Turns = Turns { arc: 46.0 * PI / 180.0, sphere: ROUND.sphere, cylinder: 46.0 * PI / 180.0 };

/// Smallest mean square component of the normals of a cylinder's side in each direction perpendicular to its axis; smaller values belong to
/// a strip that does not surround the axis.
const ALL_AROUND: f64 = 0.2;

/// Largest ratio of the angles to the neighbors of a node, as seen from the center of a round part.
const LARGEST_RATIO: f64 = 3.0;

/// Least number of inside nodes of a part: a corner beveled by two facets is no arc, and the ends of a straight side with their neighbors
/// may lie on a circle by symmetry.
const LEAST_INSIDE: usize = 3;

/// Round part of a surface: arc of a circle, part of a sphere, or rim of a cylinder.
#[derive(Clone, Debug, PartialEq)]
pub struct RoundPart {
    /// Center `[length]`.
    pub center: Vector3<f64>,
    /// Radius `[length]`.
    pub radius: f64,
    /// Unit vector along the axis of a cylinder, for a rim; `None` for arcs and parts of spheres.
    pub axis: Option<Vector3<f64>>,
    /// Model numbers of the inside nodes, ascending; for a rim of a cylinder, the nodes of the rim.
    pub inside: Vec<u32>,
    /// Model numbers of the nodes at the border of the part, each with its inside neighbors.
    pub rim: Vec<(u32, Vec<u32>)>,
}

/// Circle or sphere through a node and its neighbors: vector from the node to the center, radius.
type Fit = (Vector3<f64>, f64);

/// Side of a round part on which its body lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Curvature {
    /// The body is inside of the circle or sphere: disk, ball.
    Convex,
    /// The body is outside of it: wall of a hole, race of an outer ring.
    Hollow,
}

/// Arcs, parts of spheres and rims of cylinders of a surface at the positions `q`, convex outwards.
pub fn round_parts(surface: &Surface, q: &[f64]) -> Vec<RoundPart> {
    let mut parts = arcs_and_spheres(surface, q, Curvature::Convex, ROUND);
    parts.extend(rims(surface, q, ROUND));
    parts
}

/// Number of facets around, if the nodes of a surface lie on a circle or around a cylinder, convex outwards, but are too few for a round
/// part: the surface is a prism with corners.
pub fn facets_of_coarse_circle(surface: &Surface, q: &[f64]) -> Option<usize> {
    if !round_parts(surface, q).is_empty() {
        return None;
    }
    match surface.dimension() {
        2 => arcs_and_spheres(surface, q, Curvature::Convex, COARSE).pop().filter(|part| part.rim.is_empty()),
        _ => rims(surface, q, COARSE).pop(),
    }
    .map(|part| part.inside.len())
}

/// Circle or sphere that a surface covers completely at the positions `q`; `None` for other surfaces.
pub fn whole_circle(surface: &Surface, q: &[f64]) -> Option<(RoundPart, Curvature)> {
    [Curvature::Convex, Curvature::Hollow].into_iter().find_map(|curvature| {
        let mut parts = arcs_and_spheres(surface, q, curvature, ROUND);
        let part = parts.pop().filter(|part| parts.is_empty() && part.inside.len() == surface.nodes().len())?;
        Some((part, curvature))
    })
}

/// Arcs or parts of spheres of a surface.
fn arcs_and_spheres(surface: &Surface, q: &[f64], curvature: Curvature, turns: Turns) -> Vec<RoundPart> {
    let largest = if surface.dimension() == 2 { turns.arc } else { turns.sphere };
    let count = surface.nodes().len();
    let neighbors: Vec<Vec<usize>> = (0..count).map(|index| neighbors_of(surface, index)).collect();
    let fits: Vec<Option<Fit>> = (0..count).map(|index| fit(surface, &neighbors[index], index, q, (curvature, largest))).collect();
    let mut is_taken = vec![false; count];
    let mut parts = Vec::new();
    for first in 0..count {
        let (false, Some(circle)) = (is_taken[first], fits[first]) else { continue };
        let center = at(surface, first, q) + circle.0;
        let is_same = |index: usize| {
            fits[index].is_some_and(|(to, radius)| {
                let off = (at(surface, index, q) + to - center).norm().max((radius - circle.1).abs());
                off <= ROUND_PART * circle.1
            })
        };
        let mut inside = vec![first];
        is_taken[first] = true;
        let mut next = 0;
        while let Some(&index) = inside.get(next) {
            next += 1;
            for &other in &neighbors[index] {
                if !is_taken[other] && is_same(other) {
                    is_taken[other] = true;
                    inside.push(other);
                }
            }
        }
        if inside.len() >= LEAST_INSIDE {
            inside.sort_unstable();
            parts.push(part(surface, &neighbors, &inside, (center, circle.1)));
        }
    }
    parts
}

/// Round part with the given inside nodes, center and radius.
fn part(surface: &Surface, neighbors: &[Vec<usize>], inside: &[usize], (center, radius): Fit) -> RoundPart {
    let is_inside = |index: &usize| inside.binary_search(index).is_ok();
    let mut rim: Vec<usize> = inside.iter().flat_map(|&index| &neighbors[index]).copied().filter(|index| !is_inside(index)).collect();
    rim.sort_unstable();
    rim.dedup();
    let number = |index: &usize| surface.nodes()[*index];
    let with_neighbors = |index: &usize| (number(index), neighbors[*index].iter().filter(|other| is_inside(other)).map(number).collect());
    RoundPart { center, radius, axis: None, inside: inside.iter().map(number).collect(), rim: rim.iter().map(with_neighbors).collect() }
}

/// Position of the node with the given index; third coordinate 0 in the plane.
fn at(surface: &Surface, index: usize, q: &[f64]) -> Vector3<f64> {
    let dimension = surface.dimension();
    let first = dimension * surface.nodes()[index] as usize;
    Vector3::from_fn(|i, _| if i < dimension { q[first + i] } else { 0.0 })
}

/// Nodes connected to the node with the given index by a side of a facet; empty unless facets surround the node.
fn neighbors_of(surface: &Surface, index: usize) -> Vec<usize> {
    let facets = surface.adjacent_facets(index);
    let mut sides: Vec<usize> = Vec::new();
    for &facet in facets {
        let nodes = surface.local_facet(facet as usize);
        let Some(place) = nodes.iter().position(|&node| node as usize == index) else { continue };
        let count = nodes.len();
        sides.push(nodes[(place + 1) % count] as usize);
        if count > 2 {
            sides.push(nodes[(place + count - 1) % count] as usize);
        }
    }
    sides.sort_unstable();
    let all = sides.len();
    sides.dedup();
    let surrounded = if surface.dimension() == 2 { facets.len() == 2 && sides.len() == 2 } else { all == 2 * sides.len() };
    if surrounded { sides } else { Vec::new() }
}

/// Circle or sphere through a node and its neighbors, if the node is inside of a round part with angles of at most `largest`.
fn fit(surface: &Surface, neighbors: &[usize], index: usize, q: &[f64], (side, largest): (Curvature, f64)) -> Option<Fit> {
    if neighbors.is_empty() {
        return None;
    }
    let place = |index: usize| at(surface, index, q);
    let node = place(index);
    let (mut matrix, mut right) = (Matrix3::zeros(), Vector3::zeros());
    let around = surface.adjacent_facets(index).iter().flat_map(|&facet| surface.local_facet(facet as usize));
    let ring: Vec<Vector3<f64>> = around.filter(|&&other| other as usize != index).map(|&other| place(other as usize) - node).collect();
    for y in &ring {
        matrix += y * y.transpose() * 2.0;
        right += y * y.norm_squared();
    }
    if surface.dimension() == 2 {
        matrix[(2, 2)] = 1.0;
    }
    let center = matrix.try_inverse()? * right;
    let radius = center.norm();
    let is_on_it = ring.iter().all(|y| ((y - center).norm() - radius).abs() <= ROUND_PART * radius);
    let turn = |&other: &usize| 2.0 * (0.5 * (place(other) - node).norm() / radius).min(1.0).asin();
    let [least, most] = neighbors.iter().map(turn).fold([f64::INFINITY, 0.0], |[least, most], turn| [turn.min(least), turn.max(most)]);
    let is_curve = least >= ROUND_PART_TURN && most <= largest.min(LARGEST_RATIO * least);
    let outward = |facet: &u32| surface.outward(*facet as usize, q).iter().zip(center.iter()).map(|(n, c)| n * c).sum::<f64>();
    let is_on_side = surface.adjacent_facets(index).iter().all(|facet| (outward(facet) < 0.0) == (side == Curvature::Convex));
    (is_on_it && is_curve && is_on_side).then_some((center, radius))
}

/// Rims of the cylinders of a surface in space.
fn rims(surface: &Surface, q: &[f64], turns: Turns) -> Vec<RoundPart> {
    if surface.dimension() == 2 {
        return Vec::new();
    }
    smooth_regions(surface, q, turns.cylinder).iter().filter_map(|region| rims_of(surface, region, q, turns.cylinder)).flatten().collect()
}

/// Regions of facets in space that are connected across edges with angles of at most `largest`.
fn smooth_regions(surface: &Surface, q: &[f64], largest: f64) -> Vec<Vec<usize>> {
    let mut beside = vec![Vec::new(); surface.count()];
    for Edge { facets, .. } in surface.edges() {
        let [Some(one), Some(other)] = facets else { continue };
        let [a, b] = [one, other].map(|facet| outward(surface, facet as usize, q));
        if a.dot(&b) >= largest.cos() {
            beside[one as usize].push(other as usize);
            beside[other as usize].push(one as usize);
        }
    }
    let mut is_taken = vec![false; surface.count()];
    let mut regions = Vec::new();
    for first in 0..surface.count() {
        if is_taken[first] {
            continue;
        }
        is_taken[first] = true;
        let mut region = vec![first];
        let mut next = 0;
        while let Some(&facet) = region.get(next) {
            next += 1;
            for &other in &beside[facet] {
                if !is_taken[other] {
                    is_taken[other] = true;
                    region.push(other);
                }
            }
        }
        regions.push(region);
    }
    regions
}

/// Outward unit normal of a facet in space.
fn outward(surface: &Surface, facet: usize, q: &[f64]) -> Vector3<f64> {
    Vector3::from_column_slice(&surface.outward(facet, q)).normalize()
}

/// Both rims of a region of facets that is the side of a cylinder: all normals are perpendicular to one axis, all nodes on one circle
/// around it, with angles of at most `largest`.
fn rims_of(surface: &Surface, region: &[usize], q: &[f64], largest: f64) -> Option<[RoundPart; 2]> {
    let count = region.len() as f64;
    let spread: Matrix3<f64> = region.iter().map(|&facet| outward(surface, facet, q)).map(|n| n * n.transpose()).sum();
    let eigen = spread.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let [least, next] = [order[0], order[1]].map(|k| eigen.eigenvalues[k]);
    if least > (ROUND_PART * count).powi(2) || next < ALL_AROUND * count {
        return None;
    }
    let axis: Vector3<f64> = eigen.eigenvectors.column(order[0]).into();
    let mut nodes: Vec<usize> = region.iter().flat_map(|&facet| surface.local_facet(facet)).map(|&node| node as usize).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let origin = at(surface, nodes[0], q);
    // 2 c.y = y.y for the components perpendicular to the axis, with the first node at the origin.
    let across = |x: Vector3<f64>| (x - origin) - axis * axis.dot(&(x - origin));
    let (mut matrix, mut right) = (axis * axis.transpose(), Vector3::zeros());
    for y in nodes.iter().map(|&node| across(at(surface, node, q))) {
        matrix += y * y.transpose() * 2.0;
        right += y * y.norm_squared();
    }
    let center = matrix.try_inverse()? * right;
    let radius = center.norm();
    let height = |node: usize| axis.dot(&(at(surface, node, q) - origin));
    let arm = |node: usize| across(at(surface, node, q)) - center;
    let is_round = nodes.iter().all(|&node| (arm(node).norm() - radius).abs() <= ROUND_PART * radius);
    let is_convex = region.iter().all(|&facet| {
        let node = surface.local_facet(facet)[0] as usize;
        outward(surface, facet, q).dot(&arm(node)) > 0.0
    });
    if !is_round || !is_convex {
        return None;
    }
    let ends = [f64::min, f64::max].map(|pick| nodes.iter().map(|&node| height(node)).reduce(pick).unwrap_or(0.0));
    let rim = |end: f64| {
        let on_it: Vec<usize> = nodes.iter().copied().filter(|&node| (height(node) - end).abs() <= ROUND_PART * radius).collect();
        is_whole(on_it.iter().map(|&node| arm(node)), axis, largest).then(|| RoundPart {
            center: origin + center + axis * end,
            radius,
            axis: Some(axis),
            inside: on_it.iter().map(|&node| surface.nodes()[node]).collect(),
            rim: Vec::new(),
        })
    };
    Some([rim(ends[0])?, rim(ends[1])?])
}

/// True if vectors perpendicular to an axis surround it with angles of at most `largest` between them.
fn is_whole(arms: impl Iterator<Item = Vector3<f64>>, axis: Vector3<f64>, largest: f64) -> bool {
    let arms: Vec<Vector3<f64>> = arms.collect();
    let Some(&first) = arms.first() else { return false };
    let mut angles: Vec<f64> = arms.iter().map(|arm| axis.dot(&first.cross(arm)).atan2(first.dot(arm))).collect();
    angles.sort_by(f64::total_cmp);
    let closing = angles[0] + 2.0 * PI - angles[angles.len() - 1];
    angles.windows(2).map(|pair| pair[1] - pair[0]).fold(closing, f64::max) <= largest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts_of(points: &[[f64; 2]]) -> Vec<RoundPart> {
        let count = points.len() as u32;
        let facets: Vec<[u32; 2]> = (0..count).map(|k| [k, (k + 1) % count]).collect();
        round_parts(&Surface::new(&facets), points.as_flattened())
    }

    fn polygon(count: u32) -> Vec<[f64; 2]> {
        (0..count).map(|k| (f64::from(k) * 2.0 * PI / f64::from(count)).sin_cos()).map(|(sin, cos)| [1.0 + 2.0 * cos, 2.0 * sin]).collect()
    }

    #[test]
    fn circles_of_twelve_facets_are_round_and_octagons_are_not() {
        for count in [12, 40] {
            let parts = parts_of(&polygon(count));
            assert!(parts.len() == 1 && parts[0].rim.is_empty() && parts[0].inside.len() == count as usize, "{parts:?}");
            assert!((parts[0].radius - 2.0).abs() < 1e-12 && (parts[0].center - Vector3::new(1.0, 0.0, 0.0)).norm() < 1e-12);
        }
        assert!(parts_of(&polygon(8)).is_empty());
        let inside_out: Vec<[f64; 2]> = polygon(24).into_iter().rev().collect();
        assert!(parts_of(&inside_out).is_empty(), "the wall of a hole is hollow");
        let whole = |points: &[[f64; 2]]| {
            let count = points.len() as u32;
            let facets: Vec<[u32; 2]> = (0..count).map(|k| [k, (k + 1) % count]).collect();
            whole_circle(&Surface::new(&facets), points.as_flattened()).map(|(part, curvature)| (part.inside.len(), curvature))
        };
        assert_eq!(whole(&inside_out), Some((24, Curvature::Hollow)));
        assert_eq!(whole(&polygon(24)), Some((24, Curvature::Convex)));
        assert_eq!(whole(&polygon(8)), None);
    }

    #[test]
    fn octagons_may_be_coarse_circles() {
        let around = |count: u32| {
            let facets: Vec<[u32; 2]> = (0..count).map(|k| [k, (k + 1) % count]).collect();
            facets_of_coarse_circle(&Surface::new(&facets), polygon(count).as_flattened())
        };
        assert_eq!([6, 8, 12].map(around), [None, Some(8), None]);
    }

    /// Slot: two half circles and two straight sides.
    #[test]
    fn arcs_end_where_straight_sides_begin() {
        let half =
            |x: f64, from: f64| (0..=8).map(move |k| (from + f64::from(k) * PI / 8.0).sin_cos()).map(move |(sin, cos)| [x + cos, sin]);
        let points: Vec<[f64; 2]> = half(2.0, -0.5 * PI).chain(half(-2.0, 0.5 * PI)).collect();
        let parts = parts_of(&points);
        assert_eq!(parts.len(), 2);
        for (part, x) in parts.iter().zip([2.0, -2.0]) {
            assert!(part.inside.len() == 7 && part.rim.len() == 2 && (part.center.x - x).abs() < 1e-12, "{part:?}");
        }
    }
}
