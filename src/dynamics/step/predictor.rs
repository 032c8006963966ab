//! Initial iterate of Newton's method: every unsupported connected component moves by its rigid velocity only.
//!
//! `q_1 = c + dt u + R(theta) (q_0 - c)` with the mass center `c`, its velocity `u`, and Cayley's rotation by the angular velocity of the
//! component's angular momentum. Elastic velocities are omitted (noise if dt is many element periods), and a proper rotation does not
//! inflate the body like `q_0 + dt v_0`. Components with supports start at their positions.

use std::collections::BTreeMap;

use super::equations::Equations;
use crate::bodies::{Elements, Space};
use crate::dynamics::model::part::Pose;
use crate::math::tolerances;

/// Predicted positions of all nodes at the end of a step.
pub fn rigid_motion<const D: usize>(equations: &Equations<D>, q_0: &[f64], v_0: &[f64], dt: f64) -> Vec<f64>
where
    Space<D>: Elements<D>,
{
    let mut q_1 = q_0.to_vec();
    if !equations.nodes.component_is_free.contains(&true) {
        return q_1;
    }
    let pieces = equations.nodes.component_is_free.len();
    let (momentum, mass_position) = (equations.nodes.momenta_of(v_0), equations.nodes.momenta_of(q_0));
    let mut mass = vec![0.0; pieces];
    let mut center = vec![nalgebra::Vector3::zeros(); pieces];
    let mut velocity = vec![nalgebra::Vector3::zeros(); pieces];
    // Nodes of the moving components, with the component of each.
    let free = || {
        equations
            .nodes
            .component_of
            .iter()
            .map(|&piece| piece as usize)
            .enumerate()
            .filter(|&(_, piece)| equations.nodes.component_is_free[piece])
    };
    for (node, piece) in free() {
        mass[piece] += equations.nodes.nodal_mass[node];
        center[piece] += vector::<D>(&mass_position, node);
        velocity[piece] += vector::<D>(&momentum, node);
    }
    for piece in 0..pieces {
        center[piece] /= mass[piece];
        velocity[piece] /= mass[piece];
    }
    let mut spin = vec![nalgebra::Vector3::zeros(); pieces];
    let mut inertia = vec![nalgebra::Matrix3::zeros(); pieces];
    for (node, piece) in free() {
        let arm = vector::<D>(q_0, node) - center[piece];
        spin[piece] += arm.cross(&vector::<D>(&momentum, node));
        let weighted = vector::<D>(&mass_position, node) - center[piece] * equations.nodes.nodal_mass[node];
        if D == 2 {
            // In the plane only this entry of the inertia tensor is used.
            inertia[piece].m33 += arm.dot(&weighted);
        } else {
            inertia[piece] += nalgebra::Matrix3::identity() * arm.dot(&weighted) - arm * weighted.transpose();
        }
    }
    let rotation: Vec<nalgebra::Matrix3<f64>> = (0..pieces)
        .map(|piece| {
            let angular = if D == 2 {
                spin[piece] / inertia[piece].m33
            } else {
                inertia[piece].try_inverse().map_or(nalgebra::Vector3::zeros(), |inverse| inverse * spin[piece])
            };
            // Cayley: (I - W/2)^-1 (I + W/2) with W = dt angular x.
            let half = angular.cross_matrix() * (0.5 * dt);
            (nalgebra::Matrix3::identity() - half)
                .try_inverse()
                .map_or(nalgebra::Matrix3::identity(), |inverse| inverse * (nalgebra::Matrix3::identity() + half))
        })
        .collect();
    for (node, piece) in free() {
        let arm = vector::<D>(q_0, node) - center[piece];
        let moved = center[piece] + velocity[piece] * dt + rotation[piece] * arm;
        q_1[node * D..(node + 1) * D].copy_from_slice(&moved.as_slice()[..D]);
    }
    if equations.nodes.is_axisymmetric {
        // Bodies of revolution only move along their axis, and nodes on the axis stay there.
        for (node, piece) in free() {
            q_1[node * D] = q_0[node * D];
            q_1[node * D + 1] = q_0[node * D + 1] + velocity[piece][1] * dt;
        }
    }
    q_1
}

/// Moves prescribed nodes to their prescribed positions, and connected components with such nodes by their mean motion.
pub fn follow_prescribed<const D: usize>(equations: &Equations<D>, q_0: &[f64], displacement: &[f64], predicted: &mut [f64]) {
    if equations.supports.prescribed.is_empty() {
        return;
    }
    let pieces = equations.nodes.component_is_free.len();
    let (mut motion, mut count) = (vec![[0.0; D]; pieces], vec![[0usize; D]; pieces]);
    let target = |k: usize| equations.nodes.reference[equations.supports.prescribed[k].unknown] + displacement[k];
    let mut is_prescribed = vec![false; q_0.len()];
    for (k, prescribed) in equations.supports.prescribed.iter().enumerate() {
        is_prescribed[prescribed.unknown] = true;
        let (piece, i) = (equations.nodes.component_of[prescribed.unknown / D] as usize, prescribed.unknown % D);
        motion[piece][i] += target(k) - q_0[prescribed.unknown];
        count[piece][i] += 1;
    }
    for unknown in (0..q_0.len()).filter(|&unknown| equations.supports.fixed[unknown] && !is_prescribed[unknown]) {
        count[equations.nodes.component_of[unknown / D] as usize][unknown % D] += 1;
    }
    let turned = if equations.supports.turn() { turns(equations, q_0, &target) } else { BTreeMap::new() };
    for unknown in (0..q_0.len()).filter(|&unknown| !equations.supports.fixed[unknown]) {
        if let Some(turn) = turned.get(&equations.nodes.component_of[unknown / D]) {
            let moved = turn.to + turn.rotation * (vector::<D>(q_0, unknown / D) - turn.from);
            predicted[unknown] = moved[unknown % D];
            continue;
        }
        let (piece, i) = (equations.nodes.component_of[unknown / D] as usize, unknown % D);
        if count[piece][i] > 0 {
            predicted[unknown] += motion[piece][i] / count[piece][i] as f64;
        }
    }
    for (k, prescribed) in equations.supports.prescribed.iter().enumerate() {
        predicted[prescribed.unknown] = target(k);
    }
}

/// Rigid motion that maps one point to another.
struct RigidMotion {
    from: nalgebra::Vector3<f64>,
    to: nalgebra::Vector3<f64>,
    rotation: nalgebra::Matrix3<f64>,
}

/// Rigid motions of connected components closest to those of their prescribed nodes (Kabsch, Acta Cryst. A 32, 1976), if the nodes
/// determine them.
fn turns<const D: usize>(equations: &Equations<D>, q_0: &[f64], target: &impl Fn(usize) -> f64) -> BTreeMap<u32, RigidMotion> {
    let mut targets: BTreeMap<usize, [Option<f64>; 3]> = BTreeMap::new();
    for (k, one) in equations.supports.prescribed.iter().enumerate() {
        targets.entry(one.unknown / D).or_default()[one.unknown % D] = Some(target(k));
    }
    let mut points: BTreeMap<u32, Vec<[nalgebra::Vector3<f64>; 2]>> = BTreeMap::new();
    for (node, target) in targets {
        if target[..D].iter().all(Option::is_some) {
            let target = target.map(Option::unwrap_or_default);
            points.entry(equations.nodes.component_of[node]).or_default().push([vector::<D>(q_0, node), target.into()]);
        }
    }
    // Components with prescribed nodes at rest stay exactly.
    let least = tolerances::JUMP * equations.nodes.extent;
    let moving = points.into_iter().filter(|(_, points)| points.iter().any(|[from, to]| (to - from).norm() > least));
    moving.filter_map(|(piece, points)| Some((piece, nearest_motion::<D>(&points)?))).collect()
}

fn nearest_motion<const D: usize>(points: &[[nalgebra::Vector3<f64>; 2]]) -> Option<RigidMotion> {
    let mean = |k: usize| points.iter().map(|pair| pair[k]).sum::<nalgebra::Vector3<f64>>() / points.len() as f64;
    let (from, to) = (mean(0), mean(1));
    let mut covariance: nalgebra::Matrix3<f64> = points.iter().map(|[a, b]| (b - to) * (a - from).transpose()).sum();
    if D == 2 {
        // In the plane the third direction is fixed.
        covariance.m33 = covariance.norm();
    }
    let svd = covariance.svd(true, true);
    let (u, v_t, values) = (svd.u?, svd.v_t?, svd.singular_values);
    let sign = (u.determinant() * v_t.determinant()).signum();
    let rotation = u * nalgebra::Matrix3::from_diagonal(&nalgebra::Vector3::new(1.0, 1.0, sign)) * v_t;
    (values[1] > tolerances::TURNS * values[0]).then_some(RigidMotion { from, to, rotation })
}

/// Displacements in a step to predicted positions; those of prescribed nodes are accurate relative to their own size.
pub fn displacements_to<const D: usize>(equations: &Equations<D>, from: Pose, displacement: &[f64], predicted: &[f64]) -> Vec<f64>
where
    Space<D>: Elements<D>,
{
    let mut moved: Vec<f64> = predicted.iter().zip(from.q).map(|(predicted, q)| predicted - q).collect();
    if !equations.depends_on_positions() {
        for (prescribed, displacement) in equations.supports.prescribed.iter().zip(displacement) {
            moved[prescribed.unknown] = displacement - from.u[prescribed.unknown];
        }
    }
    moved
}

fn vector<const D: usize>(values: &[f64], node: usize) -> nalgebra::Vector3<f64> {
    let mut vector = nalgebra::Vector3::zeros();
    vector.as_mut_slice()[..D].copy_from_slice(&values[node * D..(node + 1) * D]);
    vector
}
