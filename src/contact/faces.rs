//! Geometry of facets with three or four nodes in space, used by surfaces, search and contact methods.
//!
//! A facet of four nodes consists of four flat triangles about its mean point, which is a quarter of each node. The nodal loads of a
//! constant pressure, `int N_A dA`, equal those of the bilinear facet for every plane quadrilateral.

use std::iter::Sum;
use std::ops::{Add, Div};

use nalgebra::Vector3;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use crate::math::tolerances::{FACING, OPPOSITE};

/// A point or a vector in space.
pub type Vector = Vector3<f64>;

/// Position of a node.
pub fn at(node: u32, q: &[f64]) -> Vector {
    Vector::from_column_slice(&q[3 * node as usize..3 * node as usize + 3])
}

/// Distance of the nodes of a facet from its mean plane `[length]`; 0 for three nodes.
pub fn warp(facet: &[u32], q: &[f64]) -> f64 {
    let [a, b, c, d] = facet else { return 0.0 };
    let [a, b, c, d] = [a, b, c, d].map(|&node| at(node, q));
    0.25 * normal(facet, q).dot(&(a - b + c - d)).abs()
}

/// Mean point of a facet.
pub fn middle(nodes: &[u32], q: &[f64]) -> Vector {
    nodes.iter().map(|&node| at(node, q)).sum::<Vector>() / nodes.len() as f64
}

/// Twice the oriented area of a facet, outwards: `(x_2 - x_1) x (x_3 - x_1)`, `(x_3 - x_1) x (x_4 - x_2)` `[length^2]`.
pub fn area_vector(nodes: &[u32], q: &[f64]) -> Vector {
    let x = |k: usize| at(nodes[k], q);
    if nodes.len() == 3 { (x(1) - x(0)).cross(&(x(2) - x(0))) } else { (x(2) - x(0)).cross(&(x(3) - x(1))) }
}

/// Outward normal of a facet; zero for one without area.
pub fn normal(nodes: &[u32], q: &[f64]) -> Vector {
    area_vector(nodes, q).try_normalize(0.0).unwrap_or_default()
}

/// Nodal shares of the area of a facet, `int N_A dA` `[length^2]`.
pub fn shares(nodes: &[u32], q: &[f64]) -> Vec<f64> {
    shares_of(nodes, q, |area| area.norm())
}

/// Nodal shares of the area vector of a facet, `int N_A n dA` with its outward normal `n` `[length^2]`.
pub fn vector_shares(nodes: &[u32], q: &[f64]) -> Vec<Vector> {
    shares_of(nodes, q, |area| area)
}

/// Nodal shares of a measure of the area vectors of a facet's triangles, which meet in the mean of the nodes of a quadrilateral.
fn shares_of<T>(nodes: &[u32], q: &[f64], measure: impl Fn(Vector) -> T) -> Vec<T>
where
    T: Copy + Add<Output = T> + Div<f64, Output = T> + Sum,
{
    let (middle, count) = (middle(nodes, q), nodes.len());
    if count == 3 {
        return vec![measure(area_vector(nodes, q)) / 6.0; 3];
    }
    let triangle = |k: usize| {
        let [a, b] = [k, (k + 1) % count].map(|k| at(nodes[k], q) - middle);
        measure(0.5 * a.cross(&b))
    };
    let triangles: Vec<T> = (0..count).map(triangle).collect();
    let of_middle = triangles.iter().copied().sum::<T>() / (3 * count) as f64;
    (0..count).map(|k| (triangles[k] + triangles[(k + count - 1) % count]) / 3.0 + of_middle).collect()
}

/// Lower and upper corner of the bounding box of points.
pub fn bounds(points: impl Iterator<Item = Vector>) -> [Vector; 2] {
    let empty = [Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY)];
    points.fold(empty, |[low, high], x| [low.inf(&x), high.sup(&x)])
}

/// Triangles of a facet: one, or four about its mean point.
pub fn triangles(nodes: &[u32], q: &[f64]) -> impl Iterator<Item = [Vector; 3]> {
    let corners: Vec<Vector> = nodes.iter().map(|&node| at(node, q)).collect();
    let (count, middle) = (corners.len(), middle(nodes, q));
    let of = move |k: usize| if count == 3 { [corners[0], corners[1], corners[2]] } else { [corners[k], corners[(k + 1) % count], middle] };
    (0..if count == 3 { 1 } else { count }).map(of)
}

/// Least and largest gap between two facets along the normal of the first, over the part where they are opposite each other, widened by a
/// sliding distance `spare`. `None` if that part is empty or the facets do not face each other.
pub fn gaps(own: &[u32], other: &[u32], q: &[f64], spare: f64) -> Option<[f64; 2]> {
    let normal = normal(own, q);
    if normal.dot(&self::normal(other, q)) > OPPOSITE {
        return None;
    }
    let middle = middle(own, q);
    let mut polygon: Vec<Vector> = other.iter().rev().map(|&node| at(node, q)).collect();
    let corners: Vec<Vector> = own.iter().map(|&node| at(node, q)).collect();
    for (k, from) in corners.iter().enumerate() {
        let along = corners[(k + 1) % corners.len()] - from;
        let inward = normal.cross(&along).try_normalize(0.0)?;
        let side = |x: &Vector| inward.dot(&(x - from)) + spare;
        let mut cut = Vec::with_capacity(polygon.len() + 1);
        for (k, a) in polygon.iter().enumerate() {
            let b = &polygon[(k + 1) % polygon.len()];
            let (of_a, of_b) = (side(a), side(b));
            if of_a >= 0.0 {
                cut.push(*a);
            }
            if (of_a >= 0.0) != (of_b >= 0.0) {
                cut.push(a + (b - a) * (of_a / (of_a - of_b)));
            }
        }
        polygon = cut;
    }
    let range = |points: &[Vector]| {
        let heights = points.iter().map(|x| normal.dot(&(x - middle)));
        heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], height| [low.min(height), high.max(height)])
    };
    let ([low, high], [own_low, own_high]) = (range(&polygon), range(&corners));
    (polygon.len() >= 3).then_some([low - own_high, high - own_low])
}

/// Thickness of the body below each facet: distance from its mean point along the inward normal to the next facet with the opposite
/// orientation; infinite from `reach` on.
pub fn thickness<'a>(facets: impl Iterator<Item = &'a [u32]>, q: &[f64], reach: f64) -> Vec<f64> {
    let facets: Vec<&[u32]> = facets.collect();
    let boxes = facets.iter().map(|nodes| {
        let [low, high] = bounds(nodes.iter().map(|&node| at(node, q)));
        GeomWithData::new(Rectangle::from_corners(low.into(), high.into()), *nodes)
    });
    let tree: RTree<GeomWithData<Rectangle<[f64; 3]>, &[u32]>> = RTree::bulk_load(boxes.collect());
    let through = |nodes: &&[u32]| {
        let (from, inward) = (middle(nodes, q), -normal(nodes, q));
        let leaves = |[a, b, c]: [Vector; 3]| {
            // Ray `from + r inward = a + s (b - a) + t (c - a)` that leaves the body: the outward normal has a component along the ray.
            let (u, v, to) = (b - a, c - a, from - a);
            let across = inward.cross(&v);
            let volume = u.dot(&across);
            let is_out = inward.dot(&u.cross(&v)) > FACING * u.cross(&v).norm();
            let (s, turn) = (to.dot(&across) / volume, to.cross(&u));
            let (t, r) = (inward.dot(&turn) / volume, v.dot(&turn) / volume);
            (is_out && s >= -FACING && t >= -FACING && s + t <= 1.0 + FACING && r > FACING * reach).then_some(r)
        };
        let envelope = AABB::from_corners(from.into(), (from + reach * inward).into());
        let found = tree.locate_in_envelope_intersecting(envelope).flat_map(|facet| triangles(facet.data, q)).filter_map(leaves);
        found.fold(f64::INFINITY, f64::min)
    };
    facets.iter().map(through).collect()
}

/// Position of a point relative to a facet: distance from its closest point, distance from the plane of the triangle there `[length]`, and
/// true if the closest point lies on the border with the point beside it.
#[derive(Clone, Copy, Debug)]
pub struct FacetDistance {
    pub distance: f64,
    pub gap: f64,
    pub is_beside: bool,
}

impl FacetDistance {
    /// Relative position of `x` and a facet.
    pub fn new(x: Vector, nodes: &[u32], q: &[f64]) -> FacetDistance {
        let of = |corners: [Vector; 3]| {
            let gap =
                (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).try_normalize(0.0).unwrap_or_default().dot(&(x - corners[0]));
            let distance = (x - closest(x, corners)).norm();
            FacetDistance { distance, gap, is_beside: distance > gap.abs() * (1.0 + FACING) }
        };
        let nearer = |a: FacetDistance, b: FacetDistance| if b.distance < a.distance { b } else { a };
        triangles(nodes, q).map(of).reduce(nearer).unwrap_or(FacetDistance { distance: f64::INFINITY, gap: 0.0, is_beside: true })
    }
}

/// Closest point to `x` of a triangle (Ericson, Real-Time Collision Detection, 2005, section 5.1.5).
fn closest(x: Vector, [a, b, c]: [Vector; 3]) -> Vector {
    let (ab, ac) = (b - a, c - a);
    let [(d1, d2), (d3, d4), (d5, d6)] = [a, b, c].map(|corner| (ab.dot(&(x - corner)), ac.dot(&(x - corner))));
    let along = |from: Vector, to: Vector, s: f64| from + (to - from) * s;
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let [of_a, of_b, of_c] = [d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2];
    if of_c <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return along(a, b, d1 / (d1 - d3));
    }
    if of_b <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return along(a, c, d2 / (d2 - d6));
    }
    if of_a <= 0.0 && d4 >= d3 && d5 >= d6 {
        return along(b, c, (d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let whole = of_a + of_b + of_c;
    if whole > 0.0 { a + ab * (of_b / whole) + ac * (of_c / whole) } else { a }
}
