//! Height profiles in space: the curved surface through the nodes as a height over each facet of three or four nodes.
//!
//! Nodal normals are those of the sphere through the neighboring nodes where one exists (N. Max, J. Graphics Tools 4, 1999), over the
//! facets that continue smoothly. On facets of four nodes along the axis of a cylinder they are exact. Between triangles this is the
//! initial guess `n_0` of the normal `n = n_0 + t` with the second fundamental form `k` that satisfies in the least-squares sense, for the
//! vectors `r` to the neighbors,
//!
//! ```text
//! n.r/|r|^2 = -k(r, r)/(2 |r|^2)
//! ```
//!
//! Spheres and circles are exact solutions. With too few neighbors at a border, `t` and `k` have minimum norm. Along an edge `e` of a facet
//! with the normal `n` from node `i` to node `j` the angles `sin a = e.(n - n_i)/|e|` and `e.(n_j - n)/|e|` have the mean `a`, at most
//! twice the smaller one and zero for different signs: an isolated kink is not taken for curvature. At a border one angle stands for both;
//! normals there are in `border_normals.rs`.
//! Facets of first order that lie with their neighbors on a sphere or a cylinder have its exact heights (`quadric.rs`).
//! Faces of second order have normals of their own at all their nodes (`curved_face.rs`), which stand at borders and at kinks.
//! The sagitta `s_e = |e| a (1 + 2 a^2/15 + ..)/4` preserves the area of the circular segment. The height is quadratic over the facet with
//! the mean `sum_e s_e/3`, and constant in facet coordinates, so that the surface moves with the facet.

use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

use nalgebra::{DMatrix, DVector};

use super::border_normals::border_normal;
use super::exact_profile::exact_profile;
use super::facet_profile::Profile;
use super::interior::Interior;
use super::quadric::Quadric;
use super::vectors::Vec3;
use crate::contact::faces::{self, Vector};
use crate::contact::surface::Surface;
use crate::math::tolerances::STRAIGHT;

/// Cosine of the largest angle between two facets of a curve, 25 degrees: on spheres with 24 cells around, facets turn by 15 and, across
/// corners, by 21 degrees.
const SMOOTH: f64 = 0.906_307_787_036_65;

/// Cosine of the largest angle between an edge and the vector to a node by which the surface counts as continued in the direction of the
/// edge.
const ONWARDS: f64 = 0.3;

/// Relative singular value of the fit of a quadric below which the corresponding direction is undetermined.
const OPEN: f64 = 0.05;

/// Largest difference of the normals of a face of second order from those of the surface, relative to the turn along a facet, up to which
/// the face continues its neighbors.
const AGREEING: f64 = 0.2;

/// Upper bound of the height of points over the mean height of their facets: faces of six nodes raise their mid-side points alone, by 4/3
/// of it.
const MOST_RAISED: f64 = 1.5;

/// Data of nodal constraints in space, one entry per secondary node.
#[derive(Clone, Debug)]
pub struct NodalRows {
    /// Height of the curve over each secondary node `[length]`.
    pub heights: Vec<f64>,
    /// Height profiles of the primary facets.
    pub profiles: Vec<Profile>,
}

/// Mean heights of the curved surface over its facets.
#[derive(Clone, Debug, Default)]
pub struct Profiles {
    /// Mean height over each facet `[length]`.
    heights: Vec<f64>,
}

impl Profiles {
    /// Heights of a surface at the positions `q`.
    pub fn new(surface: &Surface, q: &[f64]) -> Self {
        Self::of_curve(surface, q, SMOOTH)
    }

    /// Heights with another cosine of the largest angle between two facets of a curve.
    pub fn of_curve(surface: &Surface, q: &[f64], smooth: f64) -> Self {
        let facets = Facets::new(surface, q, smooth);
        let height = |facet: usize| facets.sagittas(facet).iter().sum::<f64>() / 3.0;
        Profiles { heights: (0..surface.count()).map(height).collect() }
    }

    /// Mean height of the curved surface over a facet, 0 for flat facets `[length]`.
    pub fn height(&self, facet: usize) -> f64 {
        self.heights[facet]
    }

    /// Magnitude of the sum of the principal curvatures of a facet of the length `size`, whose mean height is `k l^2/12` `[1/length]`.
    pub fn curvature(&self, facet: usize, size: f64) -> f64 {
        12.0 * self.height(facet).abs() / size.powi(2)
    }

    /// Largest mean height of a convex surface over the given facets, by which sub-facet points may lie above the surface `[length]`.
    pub fn raised_by(&self, facets: &[u32]) -> f64 {
        facets.iter().filter_map(|&facet| self.heights.get(facet as usize)).copied().fold(0.0, f64::max)
    }

    /// Largest height of the points of a convex surface of second order at a facet `[length]`. Vertices of a finer hollow surface lie below
    /// them.
    pub fn raised_points(&self, facet: u32) -> f64 {
        MOST_RAISED * self.raised_by(&[facet])
    }

    /// Largest distance between facet middles and a hollow surface below them `[length]`: 1.5 times the mean height, as for a parabola.
    pub fn hollow(&self, facets: &[u32]) -> f64 {
        -1.5 * facets.iter().filter_map(|&facet| self.heights.get(facet as usize)).copied().fold(0.0, f64::min)
    }
}

/// Facets of a surface, with the normals from which profiles are computed.
struct Facets<'a> {
    surface: &'a Surface,
    q: &'a [f64],
    normals: Vec<Vector>,
    smooth: f64,
    /// Surface normals at nodes around which all facets continue smoothly.
    at_nodes: Vec<Option<Vector>>,
    /// Normals of faces of second order at the corners of their facets; empty for faces of first order.
    of_faces: &'a [Option<[Vector; 4]>],
}

/// Height profiles of the facets of a surface between the points `seen`, which represent points of the curve at `truth`. `of_faces`:
/// normals of faces of second order at the corners of their facets, empty for faces of first order.
pub fn profiles(surface: &Surface, seen: &[f64], truth: &[f64], of_faces: &[Option<[Vector; 4]>]) -> Vec<Profile> {
    let facets = Facets::new(surface, truth, SMOOTH).with_faces(of_faces);
    (0..surface.count()).map(|facet| facets.profile(facet, seen)).collect()
}

/// Height profiles of primary facets from heights along the facets' normals, see [`Profile::across_triangles`].
pub fn across_triangles(surface: &Surface, q: &[f64], profiles: &mut [Profile]) {
    for (facet, profile) in profiles.iter_mut().enumerate().filter(|(_, profile)| !profile.is_flat()) {
        let nodes: Vec<Vector> = surface.facet(facet).iter().map(|&node| faces::at(node, q)).collect();
        *profile = std::mem::take(profile).across_triangles(&nodes, faces::normal(surface.facet(facet), q));
    }
}

/// Height profiles that follow the stretches of their facets, whose reference positions are `q`.
pub fn stretching(surface: &Surface, q: &[f64], profiles: Vec<Profile>) -> Vec<Profile> {
    let on_facet = |(facet, profile): (usize, Profile)| {
        let nodes: Vec<Vec3<f64>> = surface.facet(facet).iter().map(|&node| faces::at(node, q).into()).collect();
        profile.on_facet(&nodes)
    };
    profiles.into_iter().enumerate().map(on_facet).collect()
}

impl<'a> Facets<'a> {
    fn new(surface: &'a Surface, q: &'a [f64], smooth: f64) -> Self {
        let normals: Vec<Vector> = (0..surface.count()).map(|facet| faces::normal(surface.facet(facet), q)).collect();
        let mut facets = Facets { surface, q, normals, smooth, at_nodes: vec![None; surface.nodes().len()], of_faces: &[] };
        let of_node = |node: usize| {
            let around: Vec<usize> = surface.adjacent_facets(node).iter().map(|&facet| facet as usize).collect();
            let is_smooth = around.iter().all(|&facet| facets.connected(facet, node).len() == around.len());
            is_smooth.then(|| facets.fitted(surface.nodes()[node], &around))
        };
        let at_nodes = (0..surface.nodes().len()).map(of_node).collect();
        facets.at_nodes = at_nodes;
        let borders: Vec<(usize, Vector)> = (0..surface.nodes().len()).filter_map(|node| Some((node, facets.at_border(node)?))).collect();
        borders.into_iter().for_each(|(node, normal)| facets.at_nodes[node] = Some(normal));
        facets
    }

    /// Normal at a node of the border that has one inner neighbor, see `border_normals.rs`.
    fn at_border(&self, node: usize) -> Option<Vector> {
        let &[first, second] = self.surface.adjacent_facets(node) else { return None };
        let neighbors = |facet: u32| {
            let nodes = <[u32; 4]>::try_from(self.surface.local_facet(facet as usize)).ok()?;
            let place = nodes.iter().position(|&other| other as usize == node)?;
            Some([nodes[(place + 1) % 4], nodes[(place + 3) % 4]])
        };
        let neighbors = [neighbors(first)?, neighbors(second)?];
        let inner = neighbors[0].into_iter().find(|other| neighbors[1].contains(other))?;
        let rim = neighbors.map(|[one, other]| if one == inner { other } else { one });
        let way = |to: u32| faces::at(self.surface.nodes()[to as usize], self.q) - faces::at(self.surface.nodes()[node], self.q);
        if !self.is_inside(inner as usize) {
            return None;
        }
        Some(border_normal(self.at_nodes[node]?, rim.map(way), way(inner), self.at_nodes[inner as usize]?))
    }

    /// Adds the normals of faces of second order, which stand at borders and where faces do not continue each other.
    fn with_faces(mut self, of_faces: &'a [Option<[Vector; 4]>]) -> Self {
        self.of_faces = of_faces;
        if !of_faces.is_empty() {
            self.at_nodes = (0..self.at_nodes.len()).map(|node| self.common_normal(node, self.at_nodes[node]?)).collect();
        }
        self
    }

    /// Normal of the surface at a node of faces of second order: `fitted` inside of the surface, the mean of the faces' normals at its
    /// border; `None` where they do not agree.
    fn common_normal(&self, node: usize, fitted: Vector) -> Option<Vector> {
        let place = |facet: usize| self.surface.local_facet(facet).iter().position(|&other| other as usize == node).unwrap_or(0);
        let around: Vec<usize> = self.surface.adjacent_facets(node).iter().map(|&facet| facet as usize).collect();
        let of_faces = || around.iter().filter_map(|&facet| self.of_face(facet, place(facet)));
        let normal = if self.is_inside(node) { fitted } else { of_faces().sum::<Vector>().try_normalize(0.0)? };
        let agrees = |&facet: &usize| {
            let (Some(corners), k) = (self.of_faces[facet], place(facet)) else { return true };
            let turns = corners[..self.surface.facet(facet).len()].iter().map(|other| (other - corners[k]).norm());
            (corners[k] - normal).norm() <= AGREEING * turns.fold(0.0, f64::max)
        };
        around.iter().all(agrees).then_some(normal)
    }

    /// True if facets surround a node.
    fn is_inside(&self, node: usize) -> bool {
        let own = self.surface.nodes()[node];
        let mut ends: Vec<u32> = Vec::new();
        for &facet in self.surface.adjacent_facets(node) {
            let nodes = self.surface.facet(facet as usize);
            let place = nodes.iter().position(|&other| other == own).unwrap_or(0);
            ends.extend([1, nodes.len() - 1].map(|step| nodes[(place + step) % nodes.len()]));
        }
        ends.sort_unstable();
        ends.chunk_by(|a, b| a == b).all(|same| same.len() == 2)
    }

    /// Facets around a node that continue a facet smoothly, including itself: connected to it by edges along which facets turn by at most
    /// the largest angle of a curve. Across a node where three facets meet, facets of a sphere turn by up to 1.4 times that.
    fn connected(&self, facet: usize, node: usize) -> Vec<usize> {
        let own = self.surface.nodes()[node];
        let widest = (SQRT_2 * self.smooth.acos()).cos();
        let turn = |one: usize, other: usize| self.normals[one].dot(&self.normals[other]);
        let have_edge = |one: usize, other: usize| {
            let others = self.surface.facet(other);
            self.surface.facet(one).iter().any(|&corner| corner != own && others.contains(&corner))
        };
        let mut found = vec![facet];
        let mut next = 0;
        while next < found.len() {
            for other in self.surface.adjacent_facets(node).iter().map(|&other| other as usize) {
                let goes_on = turn(found[next], other) >= self.smooth && turn(facet, other) >= widest;
                if goes_on && !found.contains(&other) && have_edge(found[next], other) {
                    found.push(other);
                }
            }
            next += 1;
        }
        found
    }

    /// Facets adjacent to corner `k` of a facet that continue it smoothly, including itself.
    fn around(&self, facet: usize, k: usize) -> Vec<usize> {
        self.connected(facet, self.surface.local_facet(facet)[k] as usize)
    }

    /// Edge vectors of a facet from one of its nodes.
    fn sides(&self, facet: usize, node: u32) -> [Vector; 2] {
        let nodes = self.surface.facet(facet);
        let place = nodes.iter().position(|&other| other == node).unwrap_or(0);
        [place + 1, place + nodes.len() - 1].map(|k| faces::at(nodes[k % nodes.len()], self.q) - faces::at(node, self.q))
    }

    /// Normal at corner `k` of a facet of the face of second order to which the facet belongs.
    fn of_face(&self, facet: usize, k: usize) -> Option<Vector> {
        self.of_faces.get(facet)?.map(|corners| corners[k])
    }

    /// Surface normal at corner `k` of a facet.
    fn normal(&self, facet: usize, k: usize) -> Vector {
        let node = self.surface.local_facet(facet)[k] as usize;
        let fitted = || self.fitted(self.surface.facet(facet)[k], &self.around(facet, k));
        self.at_nodes[node].or_else(|| self.of_face(facet, k)).unwrap_or_else(fitted)
    }

    /// Normal at a node of the quadric fitted to the nodes of the facets `around`.
    fn fitted(&self, node: u32, around: &[usize]) -> Vector {
        let weighted = |&other: &usize| {
            let [a, b] = self.sides(other, node);
            a.cross(&b) / (a.norm_squared() * b.norm_squared())
        };
        let normal = around.iter().map(weighted).sum::<Vector>().try_normalize(0.0).unwrap_or_default();
        if around.iter().all(|&facet| self.surface.facet(facet).len() == 4) {
            return normal;
        }
        let ring = self.ring(node, around);
        let size = ring.iter().map(|r| r.norm()).sum::<f64>() / ring.len() as f64;
        let Some(first) = ring.first().and_then(|r| (r - normal * normal.dot(r)).try_normalize(0.0)) else { return normal };
        let second = normal.cross(&first);
        let row = |r: &Vector| {
            let across = first.dot(r).hypot(second.dot(r)).max(f64::MIN_POSITIVE);
            let [x, y] = [first.dot(r), second.dot(r)].map(|along| along / across);
            [size * x / r.norm(), size * y / r.norm(), 0.5 * x * x, FRAC_1_SQRT_2 * x * y, 0.5 * y * y]
        };
        let rows = DMatrix::from_row_iterator(ring.len(), 5, ring.iter().flat_map(row));
        let heights = DVector::from_iterator(ring.len(), ring.iter().map(|r| -normal.dot(r) / r.norm_squared()));
        let fit = rows.svd(true, true);
        let least = OPEN * fit.singular_values.max();
        let Ok(found) = fit.solve(&heights, least) else { return normal };
        (normal + (first * found[0] + second * found[1]) * size).normalize()
    }

    /// Vectors from a node to the other nodes of the facets `around`.
    fn ring(&self, node: u32, around: &[usize]) -> Vec<Vector> {
        let mut nodes: Vec<u32> =
            around.iter().flat_map(|&facet| self.surface.facet(facet)).copied().filter(|&other| other != node).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let ways = nodes.into_iter().map(|other| faces::at(other, self.q) - faces::at(node, self.q));
        ways.filter(|way| way.norm_squared() > 0.0).collect()
    }

    /// Angle between the surface and the side of a facet that ends at corner `k` with the vector `way` `[rad]`, in the plane of the side
    /// and the facet's normal; positive on a convex surface, `None` where the surface ends.
    fn turn(&self, facet: usize, k: usize, way: Vector) -> Option<f64> {
        let normal = self.normals[facet];
        let rise = normal.dot(&way);
        let along = way - normal * rise;
        let angle = || {
            let of_surface = self.normal(facet, k);
            (rise / along.norm()).atan() + (of_surface.dot(&along) / (of_surface.dot(&normal) * along.norm())).atan()
        };
        if self.of_face(facet, k).is_some() {
            return Some(angle());
        }
        let goes_on = |r: &Vector| r.dot(&way) > ONWARDS * r.norm() * way.norm();
        self.ring(self.surface.facet(facet)[k], &self.around(facet, k)).iter().any(goes_on).then(angle)
    }

    /// Height profile over a facet of first order that lies with its neighbors on a sphere or a cylinder.
    fn round_profile(&self, facet: usize) -> Option<Profile> {
        if !self.of_faces.is_empty() {
            return None;
        }
        let nodes = self.surface.facet(facet);
        let around = (0..nodes.len()).flat_map(|k| self.around(facet, k)).flat_map(|other| self.surface.facet(other));
        let mut others: Vec<u32> = around.copied().filter(|node| !nodes.contains(node)).collect();
        others.sort_unstable();
        others.dedup();
        let quadric = Quadric::around(nodes, &others, self.q)?;
        exact_profile(|x, normal| quadric.height(x, normal), nodes, self.q)
    }

    /// Height profile over a facet between the points `seen`, which represent its nodes.
    fn profile(&self, facet: usize, seen: &[f64]) -> Profile {
        let nodes = self.surface.facet(facet);
        let (sagittas, quartics) = self.sides_of(facet);
        if sagittas == [0.0; 4] {
            return Profile::default();
        }
        if let Some(profile) = self.round_profile(facet) {
            return profile;
        }
        let normal = faces::normal(nodes, seen);
        let apart = |k: usize| faces::at(nodes[k], self.q) - faces::at(nodes[k], seen);
        // Distance along the facet's normal from a point of `seen` to the tangent plane of the surface at its node.
        let height = |k: usize| {
            let of_curve = self.normal(facet, k);
            apart(k).dot(&of_curve) / of_curve.dot(&normal)
        };
        let stretched = |k: usize| {
            let [from, to] = [nodes[k], nodes[(k + 1) % nodes.len()]];
            let [is, was] = [seen, self.q].map(|q| (faces::at(to, q) - faces::at(from, q)).norm_squared());
            sagittas[k] * is / was
        };
        let Ok(points) = <[Vector; 4]>::try_from(nodes.iter().map(|&node| faces::at(node, seen)).collect::<Vec<_>>()) else {
            return Profile::of_three([0, 1, 2].map(height), [0, 1, 2].map(stretched));
        };
        let [corners, sagittas] = [[0, 1, 2, 3].map(height), [0, 1, 2, 3].map(stretched)];
        let interior = Interior { quartics, ..Interior::of_facet(&points, normal, &corners, &sagittas) };
        Profile::of_four(&corners, &sagittas, &interior)
    }

    /// Sagittas along the sides of a facet; zero if the mean height is negligible.
    fn sagittas(&self, facet: usize) -> [f64; 4] {
        self.sides_of(facet).0
    }

    fn sides_of(&self, facet: usize) -> ([f64; 4], [f64; 4]) {
        let nodes = self.surface.facet(facet);
        let (mut sagittas, mut quartics) = ([0.0; 4], [0.0; 4]);
        for (k, sagitta) in sagittas[..nodes.len()].iter_mut().enumerate() {
            let next = (k + 1) % nodes.len();
            let edge = faces::at(nodes[next], self.q) - faces::at(nodes[k], self.q);
            let angle: f64 = match [self.turn(facet, k, -edge), self.turn(facet, next, edge)] {
                [Some(a), Some(b)] if a * b > 0.0 => a.signum() * (0.5 * (a + b)).abs().min(2.0 * a.abs().min(b.abs())),
                [Some(a), None] | [None, Some(a)] => a,
                _ => 0.0,
            };
            let length = edge.norm_squared() / (edge - self.normals[facet] * self.normals[facet].dot(&edge)).norm();
            *sagitta = 0.25 * length * angle * (1.0 + angle * angle * (2.0 / 15.0 + 2.0 / 105.0 * angle * angle));
            quartics[k] = 0.0625 * length * angle * angle * angle;
        }
        let least = STRAIGHT * self.surface.facet_size(facet, self.q);
        if sagittas.iter().any(|sagitta| sagitta.abs() > least) { (sagittas, quartics) } else { ([0.0; 4], [0.0; 4]) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::space::forms::{derivatives, value};
    use crate::contact::space::products::POINTS;

    /// Strip of a quarter cylinder of radius 1 with `count` facets, round or hollow.
    fn strip(count: u32, is_hollow: bool) -> (Surface, Vec<f64>) {
        let angle = |k: u32| std::f64::consts::FRAC_PI_2 * f64::from(k) / f64::from(count);
        let q = (0..=count).flat_map(|k| [0.0, 0.3].map(|z| [angle(k).cos(), angle(k).sin(), z])).flatten().collect();
        let facet = |k: u32| {
            let mut nodes = [2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1];
            if is_hollow {
                nodes.reverse();
            }
            nodes
        };
        let facets: Vec<[u32; 4]> = (0..count).map(facet).collect();
        (Surface::in_space(facets.iter().map(|facet| &facet[..])), q)
    }

    /// Two triangles for each facet of four nodes.
    fn split(surface: &Surface) -> Surface {
        let of = |facet: usize| match surface.facet(facet) {
            &[a, b, c, d] => [[a, b, c], [a, c, d]],
            _ => [[0; 3]; 2],
        };
        let facets: Vec<[u32; 3]> = (0..surface.count()).flat_map(of).collect();
        Surface::in_space(facets.iter().map(|facet| &facet[..]))
    }

    /// Closed form: sides around a cylinder and diagonals have the sagittas of the circle, sides along the axis none.
    #[test]
    fn triangles_of_a_cylinder_have_its_sagittas() {
        let (surface, q) = strip(8, true);
        let triangles = split(&surface);
        let exact = Profiles::new(&surface, &q).height(3) * 1.5;
        let found = Facets::new(&triangles, &q, SMOOTH);
        for facet in 0..triangles.count() {
            let nodes = triangles.facet(facet);
            for k in 0..3 {
                // The sides between nodes 2 k and 2 k + 1, which have the same polar angle, are straight.
                let around = if nodes[k] / 2 == nodes[(k + 1) % 3] / 2 { 0.0 } else { exact };
                if nodes.iter().all(|&node| (2..16).contains(&node)) {
                    let sagitta = found.sagittas(facet)[k];
                    assert!((sagitta - around).abs() < 0.02 * exact.abs(), "{facet} {k}: {sagitta} {around}");
                }
            }
        }
    }

    /// Closed form: normals of a sphere and of a cylinder at the borders of a patch, except at its corners.
    #[test]
    fn normals_at_borders_are_exact() {
        let facets: Vec<[u32; 4]> = (0..9).map(|k| k / 3 * 4 + k % 3).map(|k| [k, k + 1, k + 5, k + 4]).collect();
        let surface = Surface::in_space(facets.iter().map(|facet| &facet[..]));
        let angles = |k: usize| [k % 4, k / 4].map(|k| 0.3 * k as f64);
        for is_sphere in [true, false] {
            let normal = |k: usize| {
                let [a, b] = angles(k);
                let [across, up] = if is_sphere { [b.cos(), b.sin()] } else { [1.0, 0.0] };
                Vector::new(a.cos() * across, a.sin() * across, up)
            };
            let point = |k: usize| if is_sphere { normal(k) } else { normal(k) + Vector::new(0.0, 0.0, angles(k)[1]) };
            let q: Vec<f64> = (0..16).flat_map(|k| <[f64; 3]>::from(point(k))).collect();
            let found = Facets::new(&surface, &q, SMOOTH);
            for k in (0..16).filter(|k| ![0, 3, 12, 15].contains(k)) {
                let at = found.at_nodes[surface.index(k as u32).unwrap()].unwrap();
                assert!((at - normal(k)).norm() < 1e-12, "{k} of a sphere ({is_sphere}): {at} {}", normal(k));
            }
        }
    }

    /// Closed form: facets of spheres have the sphere's heights in the mean square, whatever their shape, but at the corners of a patch,
    /// where few neighbors determine the sphere.
    #[test]
    fn facets_of_spheres_have_its_heights() {
        let facets: Vec<[u32; 4]> = (0..9).map(|k| k / 3 * 4 + k % 3).map(|k| [k, k + 1, k + 5, k + 4]).collect();
        let surface = Surface::in_space(facets.iter().map(|facet| &facet[..]));
        let point = |k: usize| {
            let [a, b] = [0.2 * (k % 4) as f64, 0.25 * (k / 4) as f64 + 0.02 * (3 * k % 7) as f64];
            [a.cos() * b.cos(), a.sin() * b.cos(), b.sin()]
        };
        let q: Vec<f64> = (0..16).flat_map(point).collect();
        for surface in [split(&surface), surface] {
            for (facet, profile) in profiles(&surface, &q, &q, &[]).into_iter().enumerate() {
                let nodes = surface.facet(facet);
                if nodes.iter().any(|node| [0, 3, 12, 15].contains(node)) {
                    continue;
                }
                let normal = faces::normal(nodes, &q);
                for (k, [a, b, c]) in faces::triangles(nodes, &q).enumerate() {
                    let mean = |height: &dyn Fn([f64; 3]) -> f64| POINTS.iter().map(|(at, weight)| weight * height(*at)).sum::<f64>();
                    let exact = mean(&|at| {
                        let x = a * at[0] + b * at[1] + c * at[2];
                        (x.dot(&normal).powi(2) + 1.0 - x.norm_squared()).sqrt() - x.dot(&normal)
                    });
                    let found = mean(&|at| value(&derivatives(profile.form(k), &at), &at));
                    assert!((found / exact - 1.0).abs() < 1e-5, "{facet} {k}: {found} {exact}");
                }
            }
        }
    }

    /// Closed form: mean height of a circular segment, also at borders.
    #[test]
    fn heights_keep_the_area_of_segments() {
        for (count, is_hollow) in [(5, false), (12, true)] {
            let (surface, q) = strip(count, is_hollow);
            let profiles = Profiles::new(&surface, &q);
            let half = std::f64::consts::FRAC_PI_4 / f64::from(count);
            let exact = (half - half.sin() * half.cos()) / (2.0 * half.sin()) * if is_hollow { -1.0 } else { 1.0 };
            for facet in 0..count as usize {
                assert!((profiles.height(facet) / exact - 1.0).abs() < 1e-4, "{facet} of {count}: {} {exact}", profiles.height(facet));
            }
        }
    }

    /// The profile of a curved strip is a parabola over the whole facet; facets of a plane, of an isolated kink and of a fold have none.
    #[test]
    fn profiles_are_those_of_curves() {
        let profile = Profile::new(&[0.0; 4], &[0.1, 0.0, 0.1, 0.0]);
        for (k, x) in [0.0, 1.0, 1.0, 0.0].into_iter().enumerate() {
            let next = [1.0, 1.0, 0.0, 0.0][k];
            for l in [[0.2, 0.3, 0.5], [0.6, 0.1, 0.3], [0.0, 0.5, 0.5]] {
                let [a, b, c, ab, bc, ca] = *profile.form(k);
                let height =
                    a * l[0] * l[0] + b * l[1] * l[1] + c * l[2] * l[2] + 2.0 * (ab * l[0] * l[1] + bc * l[1] * l[2] + ca * l[2] * l[0]);
                let place = l[0] * x + l[1] * next + l[2] * 0.5;
                assert!((height - 0.4 * place * (1.0 - place)).abs() < 1e-15, "{k} {l:?}: {height}");
            }
        }
        let (coarse, q) = strip(3, false);
        assert!((0..3).all(|facet| Profiles::new(&coarse, &q).height(facet) == 0.0), "facets turn by 30 degrees");
        let kink: Vec<f64> =
            (0..5).flat_map(|k| [0.0, 1.0].map(|y| [f64::from(k), y, -0.2 * f64::from(k - 2).max(0.0)])).flatten().collect();
        let facets: Vec<[u32; 4]> = (0..4).map(|k| [2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1]).collect();
        let profiles = Profiles::new(&Surface::in_space(facets.iter().map(|facet| &facet[..])), &kink);
        assert!((0..4).all(|facet| profiles.height(facet) == 0.0), "a single kink is no curve");
    }
}
