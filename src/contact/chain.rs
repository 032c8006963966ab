//! Gap of a point to a chain of straight facets as a continuous function of all positions; geometry of `node_patch.rs`.
//!
//! The facet with the closest point defines the gap `g = n.(x - y_1)`, with the outward normal `n` on the right of the facet (the body is
//! on the left). If the closest point is a vertex, the body near it is the intersection of two half planes at a convex corner and their
//! union at a concave one: the gap is the larger or the smaller of both normal distances. The distance to the vertex itself is not used, so
//! that the gap is smooth through zero. The gap is continuous where the closest point is continuous, or jumps between facets with the point
//! on the same side.
//!
//! With a height profile `p` of the facet the gap is the distance to the curve, `n.(x - y_1) - l p(s)`.
//!
//! Beyond the end of a chain the gap is the distance to the continuation of the end facet where that is positive, else zero, and the point
//! is not covered. A point opposite the end up to round-off is covered; in a step that it begins as such, up to [`Chain::extension`], too.

use nalgebra::{SVector, Vector2};

use super::edge_plane::{ACROSS_EDGE, AtEdge};
use super::numbers::Number;
use super::profile::Profile;
use crate::math::tolerances::CHAIN_END;

/// Facets and their connections, in node indices of the contact element `(x, y_1, y_2, ...)`: the point is node 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chain {
    facets: Vec<[u32; 2]>,
    /// Facet that ends at the first node of this one, and facet that starts at its second node; `NONE` at an end of the chain.
    neighbors: Vec<[u32; 2]>,
    /// Height profiles of the facets; empty for straight facets.
    profiles: Vec<Profile>,
    /// Distance beyond an end of the chain, in lengths of the end facet, up to which a point is opposite it in this step.
    pub extension: f64,
}

/// Distance from a node along the facet, relative to its length, up to which a point is at the node. A tip in equilibrium at a node stays
/// there to the tolerance of the solution; with 0.04 a motion and its mirror image differed.
const AT_NODE: f64 = 0.003;

/// Sine of the angle between two facets, 30 degrees, up to which they belong to a smooth part of the chain.
const SMOOTH: f64 = 0.5;

/// Distance from a facet, relative to its length, up to which a point touches it.
const TOUCHES: f64 = 0.2;

const NONE: u32 = u32::MAX;

/// Gap of the point, and the facet or node that defines it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measure {
    /// Index of the facet in the chain.
    pub facet: u32,
    /// Normal distance to that facet `[length]`.
    pub gap: f64,
    /// True unless the closest point is beyond an end of the chain.
    pub covered: bool,
    /// Node index in the contact element if the gap is a distance from a node, with the sign of the gap: 1 in front of it, -1 behind.
    pub vertex: Option<(u32, f64)>,
    /// Facet whose line defines the gap as well: the mean of both distances.
    pub beside: Option<u32>,
}

/// Straight lines that define the gap of a point in a step, instead of the chain.
#[derive(Clone, Copy, Debug)]
pub enum Line {
    /// Line of a facet.
    Facet(u32),
    /// Mean of the lines of two adjacent facets.
    Mean([u32; 2]),
}

impl Measure {
    /// Both lines of a mean distance.
    fn lines(&self) -> Option<[Measure; 2]> {
        self.beside.map(|beside| [self.facet, beside].map(|facet| Measure { facet, beside: None, ..*self }))
    }
}

impl Chain {
    /// Chain of the given facets, in node indices of the contact element (the point is node 0).
    pub fn new(facets: Vec<[u32; 2]>) -> Self {
        let find = |side: usize, node: u32| {
            let found = facets.iter().position(|facet| facet[side] == node);
            found.map_or(NONE, |index| index as u32)
        };
        let neighbors = facets.iter().map(|&[from, to]| [find(1, from), find(0, to)]).collect();
        Chain { facets, neighbors, ..Chain::default() }
    }

    /// Adds height profiles of the facets.
    pub fn with_profiles(self, profiles: Vec<Profile>) -> Self {
        Chain { profiles, ..self }
    }

    /// Height profile of a facet; `None` for a straight one.
    pub fn profile(&self, facet: usize) -> Option<&Profile> {
        self.profiles.get(facet).filter(|profile| !profile.is_flat())
    }

    /// Facets in node indices of the contact element.
    pub fn facets(&self) -> &[[u32; 2]] {
        &self.facets
    }

    /// Pairs of facets that follow each other, with their three nodes in order.
    pub fn corners(&self) -> impl Iterator<Item = ([u32; 2], [u32; 3])> {
        let pairs = self.neighbors.iter().enumerate().filter(|(_, [_, next])| *next != NONE);
        pairs.map(|(facet, &[_, next])| {
            let [before, at] = self.facets[facet];
            ([facet as u32, next], [before, at, self.facets[next as usize][1]])
        })
    }

    /// Gap at the node positions `z`. Only `admitted` facets can be the closest. `None` where the function vanishes identically.
    pub fn measure(&self, z: &[f64], admitted: &[bool]) -> Option<Measure> {
        let (index, s) = self.closest_admitted(z, admitted)?;
        self.measure_at(index, s, z)
    }

    /// Gap to one branch of the chain at a vertex, at the node positions `z`. The branch consists of the facet, continued as a straight
    /// line beyond its end `vertex` (0 or 1), and of the `admitted` facets that follow at its other end.
    pub fn measure_branch(&self, [facet, vertex]: [u32; 2], z: &[f64], admitted: &[bool]) -> Option<Measure> {
        let (first, end) = (facet as usize, vertex as usize);
        let next = |&index: &usize| {
            let next = self.neighbors[index][1 - end];
            (next != NONE && next != facet && admitted[next as usize]).then_some(next as usize)
        };
        let mut range = [0.0, 1.0];
        range[end] = if end == 1 { f64::INFINITY } else { f64::NEG_INFINITY };
        let away = std::iter::successors(next(&first), next).take(self.facets.len()).map(|index| (index, [0.0, 1.0]));
        let (index, s) = self.closest(std::iter::once((first, range)).chain(away), z)?;
        if index == first && (if end == 1 { s >= 1.0 } else { s <= 0.0 }) {
            Some(self.line(facet, z))
        } else {
            self.measure_at(index, s, z)
        }
    }

    /// Closest facet among the `admitted` ones, and the coordinate of the closest point.
    fn closest_admitted(&self, z: &[f64], admitted: &[bool]) -> Option<(usize, f64)> {
        let facets = (0..self.facets.len()).filter(|&index| admitted[index]);
        self.closest(facets.map(|index| (index, [0.0, 1.0])), z)
    }

    /// Closest facet among `facets`, each with the admissible range of its coordinate, and the coordinate of the closest point.
    fn closest(&self, facets: impl Iterator<Item = (usize, [f64; 2])>, z: &[f64]) -> Option<(usize, f64)> {
        let mut closest = (f64::INFINITY, 0, 0.0);
        for (index, [low, high]) in facets {
            let s = self.coordinate(index, z).clamp(low, high);
            let (t, d) = self.offsets(index, z);
            let distance = (d[0] - s * t[0]).powi(2) + (d[1] - s * t[1]).powi(2);
            if distance < closest.0 {
                closest = (distance, index, s);
            }
        }
        closest.0.is_finite().then_some((closest.1, closest.2))
    }

    /// Coordinate of the orthogonal projection of the point on a facet, 0 to 1 between its ends.
    fn coordinate(&self, index: usize, z: &[f64]) -> f64 {
        let (t, d) = self.offsets(index, z);
        let square = t[0] * t[0] + t[1] * t[1];
        if square > 0.0 { (t[0] * d[0] + t[1] * d[1]) / square } else { 0.0 }
    }

    /// Distance of a point beyond the end of the chain, in lengths of the end facet; `None` if the closest point is not the end.
    pub fn beyond_end(&self, z: &[f64], admitted: &[bool]) -> Option<f64> {
        let (index, s) = self.closest_admitted(z, admitted)?;
        let is_end = (s <= 0.0 || s >= 1.0) && self.neighbors[index][usize::from(s >= 1.0)] == NONE;
        is_end.then(|| self.excess(index, s, z))
    }

    /// Distance between the projection of the point on the line of a facet and the closest point with the coordinate `s`, in lengths of the
    /// facet.
    fn excess(&self, index: usize, s: f64, z: &[f64]) -> f64 {
        (self.coordinate(index, z) - s).abs()
    }

    /// Gap if the closest point has the coordinate `s` on the facet.
    fn measure_at(&self, index: usize, s: f64, z: &[f64]) -> Option<Measure> {
        let own = self.line(index as u32, z);
        if s > 0.0 && s < 1.0 {
            return Some(own);
        }
        let side = usize::from(s >= 1.0);
        let neighbor = self.neighbors[index][side];
        if neighbor == NONE {
            let covered = self.excess(index, s, z) <= CHAIN_END + self.extension;
            return (covered || own.gap > 0.0).then_some(Measure { covered, ..own });
        }
        let other = self.line(neighbor, z);
        let (own_t, other_t) = (self.offsets(index, z).0, self.offsets(neighbor as usize, z).0);
        let turn = own_t[0] * other_t[1] - own_t[1] * other_t[0];
        let convex = if side == 1 { turn > 0.0 } else { turn < 0.0 };
        Some(if (other.gap > own.gap) == convex { other } else { own })
    }

    /// Distance of the point from a facet; beyond the facet, from its nearer end `[length]`.
    pub fn distance(&self, facet: u32, z: &[f64]) -> f64 {
        let s = self.coordinate(facet as usize, z).clamp(0.0, 1.0);
        let (t, d) = self.offsets(facet as usize, z);
        (d[0] - s * t[0]).hypot(d[1] - s * t[1])
    }

    /// Normal distance of the point from the line of a facet.
    pub fn line(&self, facet: u32, z: &[f64]) -> Measure {
        Measure { facet, gap: self.gap(facet as usize, z), covered: true, vertex: None, beside: None }
    }

    /// Normal distance of the point from one or two lines.
    pub fn distance_from(&self, line: Line, z: &[f64]) -> Measure {
        match line {
            Line::Facet(facet) => self.line(facet, z),
            Line::Mean([one, other]) => {
                let (own, beside) = (self.line(one, z), self.line(other, z));
                Measure { gap: 0.5 * (own.gap + beside.gap), beside: Some(other), ..own }
            }
        }
    }

    /// Distance from the only facet of the chain of a disk with its center at the point `[length]`: normal distance minus the radius;
    /// beyond the facet, distance to its nearer node minus the radius. Both have the same gradient at the transition. The distance is
    /// negative behind the facet, and inside of the body at a concave corner.
    pub fn distance_of_disk(&self, z: &[f64], is_concave: [bool; 2], radius: f64) -> Option<Measure> {
        let &facet = self.facets.first()?;
        let (t, d) = self.offsets(0, z);
        let (s, line) = ((t[0] * d[0] + t[1] * d[1]) / (t[0] * t[0] + t[1] * t[1]), self.line(0, z));
        if (0.0..=1.0).contains(&s) {
            return Some(Measure { gap: line.gap - radius, ..line });
        }
        let end = usize::from(s > 1.0);
        let (node, sign) = (2 * facet[end] as usize, if line.gap < 0.0 && is_concave[end] { -1.0 } else { 1.0 });
        let gap = sign * (z[0] - z[node]).hypot(z[1] - z[node + 1]) - radius;
        Some(Measure { gap, vertex: Some((facet[end], sign)), ..line })
    }

    /// Both facets of the concave corner (pocket) at that end of `facet` that is nearer to the point, ascending, each with its end (0 or 1)
    /// at the corner. `None` if the corner is convex, or if the sine of its angle is at most `sine`.
    pub fn pocket(&self, facet: u32, z: &[f64], sine: f64) -> Option<[[u32; 2]; 2]> {
        let t = self.offsets(facet as usize, z).0;
        let side = usize::from(self.coordinate(facet as usize, z) >= 0.5);
        let neighbor = self.neighbors[facet as usize][side];
        if neighbor == NONE {
            return None;
        }
        let u = self.offsets(neighbor as usize, z).0;
        let turn = (t[0] * u[1] - t[1] * u[0]) / (t[0].hypot(t[1]) * u[0].hypot(u[1]));
        let mut branches = [[facet, side as u32], [neighbor, 1 - side as u32]];
        branches.sort_unstable();
        (if side == 1 { turn < -sine } else { turn > sine }).then_some(branches)
    }

    /// Facet whose line represents the chain for a point that passes a node in this step; `size` is the facet size `[length]`. At the node
    /// itself it is the first of both facets, so that the choice does not alternate.
    pub fn facet_at_node(&self, measure: &Measure, z: &[f64], size: f64) -> Option<u32> {
        let own = measure.facet as usize;
        let (end, distance) = self.nearest_end(own, z);
        let beside = self.neighbors[own][end];
        let is_at_node = (self.coordinate(own, z) - end as f64).abs() <= AT_NODE;
        let facet = if is_at_node { measure.facet.min(beside) } else { measure.facet };
        (measure.covered && beside != NONE && distance <= ACROSS_EDGE * size).then_some(facet)
    }

    /// Both facets at a node of a smooth part of the chain that the point touches. Where the point would change from facet to facet with
    /// round-off, the force would turn by the angle between them.
    pub fn touched_node(&self, measure: &Measure, z: &[f64]) -> Option<Line> {
        let own = measure.facet as usize;
        let end = self.nearest_end(own, z).0;
        let beside = self.neighbors[own][end];
        if !measure.covered || beside == NONE {
            return None;
        }
        let vertex = 2 * self.facets[own][end] as usize;
        let from_node = Vector2::new(z[0] - z[vertex], z[1] - z[vertex + 1]);
        let (t, u) = (Vector2::from(self.offsets(own, z).0), Vector2::from(self.offsets(beside as usize, z).0));
        let length = t.norm().min(u.norm());
        // In front of the node and behind it, the middle between both facets belongs to the node.
        let along = 0.5 * (t.normalize() + u.normalize()).dot(&from_node);
        let is_smooth = t.perp(&u).abs() <= SMOOTH * t.norm() * u.norm();
        let touches = along.abs() <= AT_NODE * length && measure.gap.abs() <= TOUCHES * length;
        (is_smooth && touches).then(|| Line::Mean([measure.facet.min(beside), measure.facet.max(beside)]))
    }

    /// Sides of the chain at its convex corner within `near` of the point, whose gap is `measure`.
    pub fn at_corner(&self, measure: &Measure, z: &[f64], near: f64) -> Option<AtEdge<2>> {
        if !measure.covered || self.pocket(measure.facet, z, 0.0).is_some() {
            return None;
        }
        let own = measure.facet as usize;
        let (end, distance) = self.nearest_end(own, z);
        let node = 2 * self.facets[own][end] as usize;
        let corner = Vector2::new(z[node], z[node + 1]);
        let beside = self.neighbors[own][end];
        let sides = std::iter::once(own).chain((beside != NONE).then_some(beside as usize));
        let normals: Vec<Vector2<f64>> = sides
            .map(|facet| {
                let [x, y] = self.offsets(facet, z).0;
                Vector2::new(y, -x).normalize()
            })
            .collect();
        let at = AtEdge { points: vec![corner; normals.len()], normals, edge: vec![corner], distance };
        (at.distance <= near).then_some(at)
    }

    /// Nearest end of a facet, 0 or 1, and the distance of the point from it `[length]`.
    fn nearest_end(&self, facet: usize, z: &[f64]) -> (usize, f64) {
        let distances = self.facets[facet].map(|node| (z[0] - z[2 * node as usize]).hypot(z[1] - z[2 * node as usize + 1]));
        let end = usize::from(distances[1] < distances[0]);
        (end, distances[end])
    }

    /// Facet vector, and vector from its first node to the point.
    fn offsets(&self, facet: usize, z: &[f64]) -> ([f64; 2], [f64; 2]) {
        let [a, b] = self.facets[facet].map(|node| 2 * node as usize);
        ([z[b] - z[a], z[b + 1] - z[a + 1]], [z[0] - z[a], z[1] - z[a + 1]])
    }

    /// Normal distance of the point from a facet, less the height of its curve `[length]`.
    fn gap(&self, facet: usize, z: &[f64]) -> f64 {
        if let Some((profile, variables)) = self.curve(facet, z) {
            return gap_to_curve(profile, variables);
        }
        let (t, d) = self.offsets(facet, z);
        (t[1] * d[0] - t[0] * d[1]) / t[0].hypot(t[1])
    }

    /// Arguments of [`gap_to_curve`] for a curved facet at the node positions `z`; `None` for a straight one.
    fn curve(&self, facet: usize, z: &[f64]) -> Option<(&Profile, SVector<f64, 4>)> {
        let profile = self.profile(facet)?;
        let (t, d) = self.offsets(facet, z);
        Some((profile, SVector::from([t[0], t[1], d[0], d[1]])))
    }

    /// Adds `weight` times the gradient of the gap to `out`.
    pub fn add_gradient(&self, measure: &Measure, z: &[f64], weight: f64, out: &mut [f64]) {
        if let Some(lines) = measure.lines() {
            return lines.iter().for_each(|line| self.add_gradient(line, z, 0.5 * weight, out));
        }
        if let Some((vertex, sign)) = measure.vertex {
            let (normal, _) = direction(vertex, z);
            for (node, share) in [(0, sign * weight), (vertex as usize, -sign * weight)] {
                out[2 * node] += share * normal[0];
                out[2 * node + 1] += share * normal[1];
            }
            return;
        }
        let facet = measure.facet as usize;
        if let Some((profile, variables)) = self.curve(facet, z) {
            let (_, gradient) = num_dual::gradient(|v| gap_to_curve(profile, v), &variables);
            for (node, of) in self.nodes(facet).into_iter().zip(OF_VARIABLES) {
                (0..2).for_each(|i| out[2 * node + i] += weight * (of[0] * gradient[i] + of[1] * gradient[2 + i]));
            }
            return;
        }
        let FacetFrame { nodes, normal, s, .. } = self.frame(measure.facet, z);
        for (node, share) in nodes.into_iter().zip([1.0, s - 1.0, -s]) {
            out[2 * node] += weight * share * normal[0];
            out[2 * node + 1] += weight * share * normal[1];
        }
    }

    /// Adds `weight` times the Hessian of the gap to `out`, row by row over the contact element.
    pub fn add_hessian(&self, measure: &Measure, z: &[f64], weight: f64, out: &mut [f64]) {
        if let Some(lines) = measure.lines() {
            return lines.iter().for_each(|line| self.add_hessian(line, z, 0.5 * weight, out));
        }
        let unknowns = z.len();
        if let Some((vertex, sign)) = measure.vertex {
            let ([x, y], length) = direction(vertex, z);
            let across = [[y * y, -x * y], [-x * y, x * x]];
            for (a, row) in [(1.0, 0), (-1.0, vertex as usize)] {
                for (b, column) in [(1.0, 0), (-1.0, vertex as usize)] {
                    for i in 0..2 {
                        for k in 0..2 {
                            out[(2 * row + i) * unknowns + 2 * column + k] += sign * weight * a * b * across[i][k] / length;
                        }
                    }
                }
            }
            return;
        }
        let facet = measure.facet as usize;
        if let Some((profile, variables)) = self.curve(facet, z) {
            let (_, _, hessian) = num_dual::hessian(|v| gap_to_curve(profile, v), &variables);
            let nodes = || self.nodes(facet).into_iter().zip(OF_VARIABLES);
            for ((row, a), (column, b)) in nodes().flat_map(|one| nodes().map(move |other| (one, other))) {
                for (i, k) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    let sum: f64 =
                        [(0, 0), (0, 1), (1, 0), (1, 1)].iter().map(|&(m, n)| a[m] * b[n] * hessian[(2 * m + i, 2 * n + k)]).sum();
                    out[(2 * row + i) * unknowns + 2 * column + k] += weight * sum;
                }
            }
            return;
        }
        let FacetFrame { nodes, normal, along, length, s, gap } = self.frame(measure.facet, z);
        // d2g = -(t^ n' (d (x) t) + n t^' (t (x) d))/l + (s (n t^' + t^ n') - g n n'/l) (t (x) t)/l, d = x - y_1, t = y_2 - y_1.
        let (of_d, of_t) = ([1.0, -1.0, 0.0], [0.0, -1.0, 1.0]);
        let factor = weight / length;
        for (a, &row) in nodes.iter().enumerate() {
            for (b, &column) in nodes.iter().enumerate() {
                let (d_t, t_d, t_t) = (of_d[a] * of_t[b], of_t[a] * of_d[b], of_t[a] * of_t[b]);
                for i in 0..2 {
                    for k in 0..2 {
                        let h = (s * t_t - d_t) * along[i] * normal[k] + (s * t_t - t_d) * normal[i] * along[k]
                            - t_t * gap / length * normal[i] * normal[k];
                        out[(2 * row + i) * unknowns + 2 * column + k] += factor * h;
                    }
                }
            }
        }
    }

    /// Node indices of the point and of a facet in the contact element.
    fn nodes(&self, facet: usize) -> [usize; 3] {
        let [a, b] = self.facets[facet].map(|node| node as usize);
        [0, a, b]
    }

    fn frame(&self, facet: u32, z: &[f64]) -> FacetFrame {
        let (t, d) = self.offsets(facet as usize, z);
        let length = t[0].hypot(t[1]);
        let along = [t[0] / length, t[1] / length];
        FacetFrame {
            nodes: self.nodes(facet as usize),
            normal: [along[1], -along[0]],
            along,
            length,
            s: (along[0] * d[0] + along[1] * d[1]) / length,
            gap: along[1] * d[0] - along[0] * d[1],
        }
    }
}

/// Derivatives of `t = y_2 - y_1` and `d = x - y_1` with respect to `x`, `y_1`, `y_2`.
const OF_VARIABLES: [[f64; 2]; 3] = [[0.0, 1.0], [-1.0, -1.0], [1.0, 0.0]];

/// Normal distance of a point from a facet less the height of its curve. The curve continues along its tangents beyond the ends. Variables
/// are the facet vector `t` and the vector `d` from its first node to the point.
fn gap_to_curve<T: Number>(profile: &Profile, variables: SVector<T, 4>) -> T {
    let [t_x, t_y, d_x, d_y] = variables.data.0[0];
    let square = t_x * t_x + t_y * t_y;
    let length = square.sqrt();
    (t_y * d_x - t_x * d_y) / length - length * profile.continued((t_x * d_x + t_y * d_y) / square)
}

/// Unit vector from a node of the contact element to the point, and their distance.
fn direction(vertex: u32, z: &[f64]) -> ([f64; 2], f64) {
    let node = 2 * vertex as usize;
    let d = [z[0] - z[node], z[1] - z[node + 1]];
    let length = d[0].hypot(d[1]);
    (d.map(|d| d / length), length)
}

/// Local frame of a facet with the coordinates of the point in it.
struct FacetFrame {
    nodes: [usize; 3],
    normal: [f64; 2],
    along: [f64; 2],
    length: f64,
    /// Coordinate of the point's projection, 0 to 1 on the facet.
    s: f64,
    gap: f64,
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    use super::*;

    /// Two facets of unit length that meet at the origin: the first along x, the second turned by `angle` to the left, the body below.
    fn corner(angle: f64, x: [f64; 2]) -> (Chain, [f64; 8]) {
        // Traversed from right to left: the body, on the left, is below.
        (Chain::new(vec![[1, 2], [2, 3]]), [x[0], x[1], 1.0, 0.0, 0.0, 0.0, -angle.cos(), -angle.sin()])
    }

    fn gap(angle: f64, x: [f64; 2]) -> f64 {
        let (chain, z) = corner(angle, x);
        chain.measure(&z, &[true; 2]).unwrap().gap
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 1000, rng_seed: RngSeed::Fixed(2007), failure_persistence: None, ..Default::default() })]

        #[test]
        fn the_gap_is_continuous_around_convex_and_concave_corners(
            angle in -1.2..1.2f64, radius in 0.01..0.4f64, around in 0.0..std::f64::consts::TAU,
        ) {
            // On a circle about the corner, a change of the polar angle by 1e-7 moves the point by 1e-7 times the radius.
            let at = |phi: f64| gap(angle, [radius * phi.cos(), radius * phi.sin()]);
            prop_assert!((at(around + 1e-7) - at(around)).abs() < 1.1e-7 * radius);
        }

        #[test]
        fn derivatives_agree_with_differences(noise in prop::array::uniform6(-0.2..0.2f64), is_curved: bool) {
            let base = [0.5, 0.1, 1.0, 0.0, 0.0, 0.0];
            let z: [f64; 6] = std::array::from_fn(|i| base[i] + noise[i]);
            let profiles = if is_curved { vec![Profile([0.01, 0.2, -0.15, -0.08, 0.02])] } else { Vec::new() };
            let chain = Chain::new(vec![[1, 2]]).with_profiles(profiles);
            let gradient = |z: &[f64; 6]| {
                let mut g = [0.0; 6];
                chain.add_gradient(&chain.line(0, z), z, 2.0, &mut g);
                g
            };
            let mut hessian = [0.0; 36];
            chain.add_hessian(&chain.line(0, &z), &z, 2.0, &mut hessian);
            let step = 1e-3;
            for k in 0..6 {
                let at = |shift: f64| {
                    let mut moved = z;
                    moved[k] += shift * step;
                    (2.0 * chain.gap(0, &moved), gradient(&moved))
                };
                let (a, b, c, d) = (at(-2.0), at(-1.0), at(1.0), at(2.0));
                // Difference quotient of fourth order, for a function whose fifth derivatives are below 1e3.
                let expected = (a.0 - 8.0 * b.0 + 8.0 * c.0 - d.0) / (12.0 * step);
                prop_assert!((gradient(&z)[k] - expected).abs() < 1e-9);
                for i in 0..6 {
                    let expected = (a.1[i] - 8.0 * b.1[i] + 8.0 * c.1[i] - d.1[i]) / (12.0 * step);
                    prop_assert!((hessian[6 * i + k] - expected).abs() < 1e-8, "{i} {k} {} {expected}", hessian[6 * i + k]);
                }
            }
        }
    }

    /// Disk in front of the facet, beyond either of its ends, and behind it at a concave corner.
    #[test]
    fn the_distance_of_a_disk_has_no_kink_at_the_ends_and_exact_derivatives() {
        let chain = Chain::new(vec![[1, 2]]);
        // The facet runs from right to left, so that the outward direction is up.
        let at = |x: [f64; 2]| [x[0], x[1], 1.0, 0.0, 0.0, 0.0];
        let gap = |z: &[f64; 6], concave: bool| chain.distance_of_disk(z, [concave; 2], 0.1).unwrap().gap;
        assert!((gap(&at([0.4, 0.3]), false) - 0.2).abs() < 1e-15);
        assert!((gap(&at([1.3, 0.4]), false) - 0.4).abs() < 1e-15, "three, four, five");
        assert!((gap(&at([-0.3, -0.4]), false) - 0.4).abs() < 1e-15, "in front of the other side of the corner");
        assert!((gap(&at([-0.3, -0.4]), true) + 0.6).abs() < 1e-15, "within the body");
        for (x, concave) in [([0.4, 0.3], false), ([1.3, 0.4], false), ([-0.3, 0.2], true), ([-0.3, -0.4], true)] {
            let z = at(x);
            let gradient = |z: &[f64; 6]| {
                let mut g = [0.0; 6];
                chain.add_gradient(&chain.distance_of_disk(z, [concave; 2], 0.1).unwrap(), z, 2.0, &mut g);
                g
            };
            let mut hessian = [0.0; 36];
            chain.add_hessian(&chain.distance_of_disk(&z, [concave; 2], 0.1).unwrap(), &z, 2.0, &mut hessian);
            let step = 1e-5;
            for k in 0..6 {
                let moved = |by: f64| std::array::from_fn(|i| z[i] + if i == k { by } else { 0.0 });
                let (less, more): ([f64; 6], [f64; 6]) = (moved(-step), moved(step));
                let slope = (gap(&more, concave) - gap(&less, concave)) / step;
                assert!((gradient(&z)[k] - slope).abs() < 1e-8, "{x:?} {k}");
                for i in 0..6 {
                    let slope = (gradient(&more)[i] - gradient(&less)[i]) / (2.0 * step);
                    assert!((hessian[6 * i + k] - slope).abs() < 1e-8, "{x:?} {i} {k}");
                }
            }
        }
        let beyond = |by: f64| chain.distance_of_disk(&at([1.0 + by, 0.3]), [false; 2], 0.1).unwrap().gap;
        assert!((beyond(1e-6) - beyond(-1e-6)).abs() < 1e-11, "the same slope on both sides of an end");
    }

    /// Closed form: a right angle, points on the bisector outside and inside.
    #[test]
    fn at_a_corner_the_body_is_an_intersection_or_a_union() {
        let quarter = std::f64::consts::FRAC_PI_2;
        // Convex corner, body x > 0, y < 0. For points outside on the bisector both normal distances are 0.1; to its left the distance from
        // the left side counts.
        assert!((gap(quarter, [-0.1, 0.1]) - 0.1).abs() < 1e-16);
        assert!((gap(quarter, [-0.1, 0.02]) - 0.1).abs() < 1e-16);
        assert!((gap(quarter, [0.2, -0.1]) + 0.1).abs() < 1e-16);
        // Concave: body y < 0 or x < 0.
        assert!((gap(-quarter, [0.1, 0.3]) - 0.1).abs() < 1e-16);
        assert!((gap(-quarter, [-0.1, -0.3]) + 0.3).abs() < 1e-16);
    }

    /// Dent of two facets that turn by a right angle; the chain continues flat on the right. A branch is independent of the other one,
    /// continues as a line beyond the vertex, and follows the chain at its far end.
    #[test]
    fn a_branch_goes_on_as_a_line_beyond_its_vertex() {
        let chain = Chain::new(vec![[1, 2], [2, 3], [3, 4]]);
        // From right to left: (2, 1) to (1, 1), down to the vertex (0, 0), up to (-1, 1).
        let at = |x: [f64; 2]| [x[0], x[1], 2.0, 1.0, 1.0, 1.0, 0.0, 0.0, -1.0, 1.0];
        let root = std::f64::consts::FRAC_1_SQRT_2;
        assert_eq!(chain.pocket(1, &at([0.1, 0.2]), 0.1), Some([[1, 1], [2, 0]]));
        let right = |x: [f64; 2]| chain.measure_branch([1, 1], &at(x), &[true; 3]).unwrap();
        let near = |measure: Measure, facet: u32, gap: f64| measure.facet == facet && (measure.gap - gap).abs() < 1e-15;
        assert!(near(right([0.1, 0.3]), 1, 0.2 * root), "within the facet");
        assert!(near(right([-0.3, 0.1]), 1, 0.4 * root), "beyond the vertex");
        assert!(near(right([1.5, 0.9]), 0, -0.1), "on the next facet");
        let left = chain.measure_branch([2, 0], &at([0.3, 0.1]), &[true; 3]).unwrap();
        assert!(near(left, 2, 0.4 * root));
        assert!((chain.distance(2, &at([0.3, 0.1])) - 0.3f64.hypot(0.1)).abs() < 1e-15);
    }

    #[test]
    fn beyond_an_end_nothing_is_covered() {
        let (chain, z) = corner(0.0, [1.1, 0.2]);
        let beyond = chain.measure(&z, &[true; 2]).unwrap();
        assert!(!beyond.covered && (beyond.gap - 0.2).abs() < 1e-16);
        assert_eq!(chain.measure(&corner(0.0, [1.1, -0.2]).1, &[true; 2]), None);
        assert!(chain.measure(&corner(0.0, [0.9, -0.2]).1, &[true; 2]).unwrap().covered);
        assert_eq!(chain.measure(&z, &[false; 2]), None);
    }

    /// A point that is pressed into a smooth bend has the mean of both lines, with exact derivatives; beside it, in front of it, and at a
    /// sharp corner it has the chain.
    #[test]
    fn a_point_at_a_node_has_the_mean_of_both_lines() {
        let line = |angle: f64, x: [f64; 2]| {
            let (chain, z) = corner(angle, x);
            let measure = chain.measure(&z, &[true; 2]).unwrap();
            chain.touched_node(&measure, &z).map(|line| (chain.distance_from(line, &z), chain, z))
        };
        // Below the node, along the bisector of the facets.
        let half = 0.1f64;
        let below = |by: f64, along: f64| [by * half.sin() + along * half.cos(), -by * half.cos() + along * half.sin()];
        for by in [0.1, 0.01, -0.01] {
            assert!(line(2.0 * half, below(by, 0.0)).is_some() && line(2.0 * half, below(by, 0.01)).is_none(), "{by}");
        }
        assert!(line(2.0 * half, below(-0.3, 0.0)).is_none() && line(0.6, [0.0, 0.0]).is_none());
        let (measure, chain, z) = line(2.0 * half, below(0.05, 0.002)).unwrap();
        assert!((measure.gap + 0.05 * half.cos()).abs() < 1e-15);
        let mut gradient = [0.0; 8];
        chain.add_gradient(&measure, &z, 1.0, &mut gradient);
        let line = Line::Mean([0, 1]);
        for k in 0..8 {
            let at = |by: f64| chain.distance_from(line, &std::array::from_fn::<f64, 8, _>(|i| if i == k { z[i] + by } else { z[i] })).gap;
            assert!((gradient[k] - (at(1e-6) - at(-1e-6)) / 2e-6).abs() < 1e-9, "unknown {k}");
        }
    }
}
