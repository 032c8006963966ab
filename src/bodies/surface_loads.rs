//! Nodal weights of boundaries and the forces of a torque.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};

use super::formulation::Plane;
use crate::elements::{MOST_FACE_NODES, edge_points, edge_shapes, face_points};
use crate::mesh::{Boundary, Mesh};

fn sum(shares: &[f64], values: impl Iterator<Item = f64>) -> f64 {
    shares.iter().zip(values).map(|(share, value)| share * value).sum()
}

/// Nodes of a boundary with their tributary measures `int N_a ds` `[length]` (in space and for a body of revolution: area).
///
/// Single points without facets have equal shares. Exact for straight facets of two nodes and plane ones of three in space; for curved
/// edges and those of bodies of revolution by three Gauss points, for other faces by [`face_points`].
pub fn nodal_areas(mesh: &Mesh, boundary: &Boundary, plane: Plane) -> Vec<(u32, f64)> {
    areas(mesh, boundary, plane, face_shares)
}

/// Nodes of a boundary with positive shares of its measure, for laws that hold at each node. They are the tributary measures, except on
/// faces of six and eight nodes, where those of corners are zero and negative: there they are proportional to `int N_a^2 dA` (Hinton,
/// Rock and Zienkiewicz, Earthquake Eng. Struct. Dyn. 4, 1976).
pub fn positive_areas(mesh: &Mesh, boundary: &Boundary, plane: Plane) -> Vec<(u32, f64)> {
    areas(mesh, boundary, plane, |points| if matches!(points.len(), 6 | 8) { shares_of_squares(points) } else { face_shares(points) })
}

fn areas(mesh: &Mesh, boundary: &Boundary, plane: Plane, of_face: impl Fn(&[[f64; 3]]) -> Vec<f64>) -> Vec<(u32, f64)> {
    if boundary.facets.is_empty() {
        return boundary.nodes.iter().map(|&node| (node, 1.0)).collect();
    }
    let mut areas = BTreeMap::new();
    for &facet in &boundary.facets {
        let nodes: Vec<u32> = mesh.facet_nodes(facet).collect();
        let points: Vec<[f64; 3]> = nodes.iter().map(|&node| mesh.points[node as usize]).collect();
        let shares = match (mesh.dimension(), nodes.len()) {
            (2, 2) if plane != Plane::Axisymmetric => vec![0.5 * (points[1][0] - points[0][0]).hypot(points[1][1] - points[0][1]); 2],
            (2, _) => edge_shares(&points, plane),
            (_, 3) => {
                let edge = |k: usize| nalgebra::Vector3::from(points[k]) - nalgebra::Vector3::from(points[0]);
                vec![edge(1).cross(&edge(2)).norm() / 6.0; 3]
            }
            _ => of_face(&points),
        };
        for (node, share) in nodes.into_iter().zip(shares) {
            *areas.entry(node).or_insert(0.0) += share;
        }
    }
    areas.into_iter().collect()
}

fn edge_shares(points: &[[f64; 3]], plane: Plane) -> Vec<f64> {
    let mut shares = vec![0.0; points.len()];
    for (s, weight) in edge_points() {
        let (shapes, slopes) = edge_shapes(points.len(), s);
        let slope = |i: usize| sum(&slopes, points.iter().map(|point| point[i]));
        let around = if plane == Plane::Axisymmetric { TAU * sum(&shapes, points.iter().map(|point| point[0])) } else { 1.0 };
        let length = weight * slope(0).hypot(slope(1)) * around;
        shares.iter_mut().zip(shapes).for_each(|(share, shape)| *share += length * shape);
    }
    shares
}

/// Tributary areas of the nodes of a face in space: `int N_a dA`.
fn face_shares(points: &[[f64; 3]]) -> Vec<f64> {
    let mut shares = vec![0.0; points.len()];
    for point in face_points(points.len()) {
        let [x, y, z] = point.normal(points);
        let area = point.weight * x.hypot(y).hypot(z);
        shares.iter_mut().zip(&point.shapes).for_each(|(share, shape)| *share += area * shape);
    }
    shares
}

/// Shares of the area of a face in space, proportional to `int N_a^2 dA`.
fn shares_of_squares(points: &[[f64; 3]]) -> Vec<f64> {
    let mut squares = vec![0.0; points.len()];
    for point in face_points(points.len()) {
        let [x, y, z] = point.normal(points);
        let area = point.weight * x.hypot(y).hypot(z);
        squares.iter_mut().zip(&point.shapes).for_each(|(square, shape)| *square += area * shape * shape);
    }
    let whole = face_shares(points).iter().sum::<f64>() / squares.iter().sum::<f64>();
    squares.iter().map(|square| whole * square).collect()
}

/// Forces of a unit pressure on a face in space with nodes at `nodes`, against the outward normal: `-int N_a n dA`.
pub fn face_pressure(nodes: &[[f64; 3]]) -> [[f64; 3]; MOST_FACE_NODES] {
    let mut forces = [[0.0; 3]; MOST_FACE_NODES];
    for point in face_points(nodes.len()) {
        let normal = point.normal(nodes);
        for (force, shape) in forces.iter_mut().zip(&point.shapes) {
            (0..3).for_each(|i| force[i] -= point.weight * shape * normal[i]);
        }
    }
    forces
}

/// Derivative of [`face_pressure`]: the force on node `a` changes by `arms[a][b] x v` (cross product) if node `b` moves by `v`, with
/// `arms[a][b] = int N_a (dN_b/d1 t_2 - dN_b/d2 t_1)` and the tangents `t` of the face.
pub fn face_pressure_arms(nodes: &[[f64; 3]]) -> [[[f64; 3]; MOST_FACE_NODES]; MOST_FACE_NODES] {
    let mut arms = [[[0.0; 3]; MOST_FACE_NODES]; MOST_FACE_NODES];
    for point in face_points(nodes.len()) {
        let [along, across] = point.tangents(nodes);
        for (arms, shape) in arms.iter_mut().zip(&point.shapes) {
            for (arm, slopes) in arms.iter_mut().zip(&point.slopes) {
                (0..3).for_each(|i| arm[i] += point.weight * shape * (slopes[0] * across[i] - slopes[1] * along[i]));
            }
        }
    }
    arms
}

/// A matrix of two components.
type Block = [[f64; 2]; 2];

/// Forces of a unit pressure on an edge of a body of revolution with nodes at `nodes`, `2 pi int N_a r z x dx`, and their derivative:
/// `[a][b][i][k]` is the derivative of component `i` at node `a` with respect to coordinate `k` of node `b`.
pub fn round_pressure(nodes: &[[f64; 2]]) -> ([[f64; 2]; 3], [[Block; 3]; 3]) {
    let (mut force, mut slope) = ([[0.0; 2]; 3], [[[[0.0; 2]; 2]; 3]; 3]);
    for (s, weight) in edge_points() {
        let (shapes, slopes) = edge_shapes(nodes.len(), s);
        let radius = sum(&shapes, nodes.iter().map(|x| x[0]));
        let along = [0, 1].map(|i| sum(&slopes, nodes.iter().map(|x| x[i])));
        let turned = [-along[1], along[0]];
        for a in 0..nodes.len() {
            let share = TAU * weight * shapes[a];
            for i in 0..2 {
                force[a][i] += share * radius * turned[i];
            }
            for b in 0..nodes.len() {
                slope[a][b][0][0] += share * shapes[b] * turned[0];
                slope[a][b][1][0] += share * (shapes[b] * turned[1] + radius * slopes[b]);
                slope[a][b][0][1] -= share * radius * slopes[b];
            }
        }
    }
    (force, slope)
}

/// Matrix `C_ab = int N_a dN_b/ds ds` of an edge with `nodes` nodes (its ends, then its middle).
///
/// The force of a uniform pressure `p` on node `a` is `p sum_b C_ab z x q_b`.
pub fn pressure_shares(nodes: usize) -> &'static [&'static [f64]] {
    const HALF: [&[f64]; 2] = [&[-0.5, 0.5], &[-0.5, 0.5]];
    const SIXTHS: [&[f64]; 3] = [&[-0.5, -1.0 / 6.0, 2.0 / 3.0], &[1.0 / 6.0, 0.5, -2.0 / 3.0], &[-2.0 / 3.0, 2.0 / 3.0, 0.0]];
    if nodes == 2 { &HALF } else { &SIXTHS }
}

/// Adds the nodal forces of a torque: `w_a omega x r_a` with `r_a` from the `w`-weighted centroid of the boundary at `q`, and `omega` such
/// that their moment equals `moment`, in the plane its third component. The resultant is zero. `None` if all nodes are on a line along
/// `moment`.
pub fn torque_forces<const D: usize>(weights: &[(u32, f64)], q: &[f64], moment: [f64; 3], force: &mut [f64]) {
    let place = |node: u32| Vector3::from_fn(|i, _| if i < D { q[node as usize * D + i] } else { 0.0 });
    let total: f64 = weights.iter().map(|(_, w)| w).sum();
    let center = weights.iter().map(|&(node, w)| place(node) * w).sum::<Vector3<f64>>() / total;
    let mut inertia = Matrix3::zeros();
    for &(node, w) in weights {
        let r = place(node) - center;
        inertia += (Matrix3::identity() * r.norm_squared() - r * r.transpose()) * w;
    }
    // In the plane `omega` follows from the polar moment alone.
    let omega = match D {
        2 => Some(Vector3::new(0.0, 0.0, moment[2] / inertia.m33)).filter(|_| inertia.m33 > 0.0),
        _ => inertia.try_inverse().map(|inverse| inverse * Vector3::from(moment)),
    };
    let Some(omega) = omega else { return };
    for &(node, w) in weights {
        let part = omega.cross(&(place(node) - center)) * w;
        (0..D).for_each(|i| force[node as usize * D + i] += part[i]);
    }
}
