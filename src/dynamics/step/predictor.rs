//! The start of Newton's method: every free piece moved by its rigid velocity alone.
//!
//! `q_1 = c + dt u + R(theta) (q_0 - c)` with the mass center `c`, its velocity `u`, and Cayley's rotation by the angular velocity that
//! belongs to the piece's angular momentum. Elastic velocities are left out (they are noise when dt is many element periods), and a
//! rotation proper does not inflate the body as `q_0 + dt v_0` does. Pieces with supports start where they are.

use super::system::System;
use crate::bodies::{Elements, Space};
use crate::dynamics::model::part::Pose;

/// Predicted positions of all nodes at the end of a step.
pub fn rigid_motion<const D: usize>(system: &System<D>, q_0: &[f64], v_0: &[f64], dt: f64) -> Vec<f64>
where
    Space<D>: Elements<D>,
{
    let mut q_1 = q_0.to_vec();
    if !system.nodes.piece_is_free.contains(&true) {
        return q_1;
    }
    let pieces = system.nodes.piece_is_free.len();
    let (momentum, mass_position) = (system.nodes.momenta_of(v_0), system.nodes.momenta_of(q_0));
    let mut mass = vec![0.0; pieces];
    let mut center = vec![nalgebra::Vector3::zeros(); pieces];
    let mut velocity = vec![nalgebra::Vector3::zeros(); pieces];
    // Nodes of the pieces that move, with these.
    let free =
        || system.nodes.pieces.iter().map(|&piece| piece as usize).enumerate().filter(|&(_, piece)| system.nodes.piece_is_free[piece]);
    for (node, piece) in free() {
        mass[piece] += system.nodes.nodal_mass[node];
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
        let weighted = vector::<D>(&mass_position, node) - center[piece] * system.nodes.nodal_mass[node];
        if D == 2 {
            // In the plane no other entry is used.
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
    q_1
}

/// Puts the prescribed nodes where they will be, and moves the pieces that have such nodes along by their mean motion.
pub fn follow_prescribed<const D: usize>(system: &System<D>, q_0: &[f64], displacement: &[f64], predicted: &mut [f64]) {
    if system.supports.prescribed.is_empty() {
        return;
    }
    let pieces = system.nodes.piece_is_free.len();
    let (mut motion, mut count) = (vec![[0.0; D]; pieces], vec![[0usize; D]; pieces]);
    let target = |k: usize| system.nodes.reference[system.supports.prescribed[k].unknown] + displacement[k];
    let mut is_prescribed = vec![false; q_0.len()];
    for (k, prescribed) in system.supports.prescribed.iter().enumerate() {
        is_prescribed[prescribed.unknown] = true;
        let (piece, i) = (system.nodes.pieces[prescribed.unknown / D] as usize, prescribed.unknown % D);
        motion[piece][i] += target(k) - q_0[prescribed.unknown];
        count[piece][i] += 1;
    }
    for unknown in (0..q_0.len()).filter(|&unknown| system.supports.fixed[unknown] && !is_prescribed[unknown]) {
        count[system.nodes.pieces[unknown / D] as usize][unknown % D] += 1;
    }
    for unknown in (0..q_0.len()).filter(|&unknown| !system.supports.fixed[unknown]) {
        let (piece, i) = (system.nodes.pieces[unknown / D] as usize, unknown % D);
        if count[piece][i] > 0 {
            predicted[unknown] += motion[piece][i] / count[piece][i] as f64;
        }
    }
    for (k, prescribed) in system.supports.prescribed.iter().enumerate() {
        predicted[prescribed.unknown] = target(k);
    }
}

/// Displacements in a step to predicted positions, those of prescribed nodes with the accuracy of their own size.
pub fn displacements_to<const D: usize>(system: &System<D>, from: Pose, displacement: &[f64], predicted: &[f64]) -> Vec<f64>
where
    Space<D>: Elements<D>,
{
    let mut moved: Vec<f64> = predicted.iter().zip(from.q).map(|(predicted, q)| predicted - q).collect();
    if !system.sees_positions() {
        for (prescribed, displacement) in system.supports.prescribed.iter().zip(displacement) {
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
