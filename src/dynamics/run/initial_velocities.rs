//! Velocities at the start.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::bodies::Inertia;
use crate::dynamics::model::definitions::Model;
use crate::dynamics::step::equations::Equations;
use crate::math::tolerances;

/// Initial velocities: those of the bodies, of supports, and of prescribed motions.
pub(super) fn initial_velocities<const D: usize>(system: &Equations<D>, model: &Model, positions: &[f64]) -> Vec<f64> {
    let mut velocities = vec![0.0; system.nodes.reference.len()];
    for initial in &model.initial_velocities {
        let nodes = system.bodies[initial.body].nodes.clone();
        let mut center = Vector3::zeros();
        let mut mass = 0.0;
        let position = |node: usize| {
            let mut x = Vector3::zeros();
            x.as_mut_slice()[..D].copy_from_slice(&positions[node * D..(node + 1) * D]);
            x
        };
        for node in nodes.clone() {
            mass += system.nodes.nodal_mass[node];
            center += position(node) * system.nodes.nodal_mass[node];
        }
        center /= mass;
        let (linear, angular) = (Vector3::from(initial.linear), Vector3::from(initial.angular));
        for node in nodes {
            let velocity = linear + angular.cross(&(position(node) - center));
            velocities[node * D..(node + 1) * D].copy_from_slice(&velocity.as_slice()[..D]);
        }
    }
    let supports = &system.supports;
    for (velocity, _) in velocities.iter_mut().zip(&supports.fixed).filter(|(_, fixed)| **fixed) {
        *velocity = 0.0;
    }
    // Errors of time functions are reported by the first step, which evaluates them again.
    if let Ok((_, rates)) = supports.prescribed_motion(0.0) {
        for (prescribed, rate) in supports.prescribed.iter().zip(rates) {
            velocities[prescribed.unknown] = rate;
        }
    }
    (0..model.bodies.len()).for_each(|body| hold_rigid_body(system, model, body, positions, &mut velocities));
    system.lead(&mut velocities);
    velocities
}

/// Replaces the velocities of a rigid body by the closest rigid motion in the kinetic energy norm that satisfies its prescribed components.
/// Otherwise velocities and initial energy would depend on the node numbering.
fn hold_rigid_body<const D: usize>(system: &Equations<D>, model: &Model, body: usize, positions: &[f64], velocities: &mut [f64]) {
    let (Some(inertia), nodes) = (model.bodies[body].rigid, system.bodies[body].nodes.clone()) else { return };
    let own = nodes.start * D..nodes.end * D;
    let held: Vec<usize> = system.supports.held.iter().flatten().copied().filter(|k| own.contains(k)).collect();
    if held.is_empty() {
        return;
    }
    let arm = |node: usize| Vector3::from_fn(|i, _| if i < D { positions[node * D + i] - inertia.center[i] } else { 0.0 });
    // Translations and rotations, and the velocity of a component per unit of each.
    let motions = if D == 2 { &[0, 1, 5][..] } else { &[0, 1, 2, 3, 4, 5] };
    let row = |k: usize| {
        let (arm, i) = (arm(k / D), k % D);
        let per_unit = |&j: &usize| if j < 3 { f64::from(u8::from(i == j)) } else { Vector3::ith(j - 3, 1.0).cross(&arm)[i] };
        DVector::from_iterator(motions.len(), motions.iter().map(per_unit))
    };
    let given = model.initial_velocities.iter().rfind(|given| given.body == body);
    let given = |j: usize| given.map_or(0.0, |given| if j < 3 { given.linear[j] } else { given.angular[j - 3] });
    let given = DVector::from_iterator(motions.len(), motions.iter().map(|&j| given(j)));
    // With `z = R w`, for which the kinetic energy is half the square, components of `z` independent of the prescribed velocities are kept,
    // and the others follow from the prescribed velocities.
    let root = mass_root(&inertia, motions);
    let inverse = root.clone().try_inverse().unwrap_or_else(|| DMatrix::zeros(motions.len(), motions.len()));
    let (mut normal, mut right) = (DMatrix::zeros(motions.len(), motions.len()), DVector::zeros(motions.len()));
    for &k in &held {
        let scaled = inverse.transpose() * row(k);
        normal += &scaled * scaled.transpose();
        right += scaled * velocities[k];
    }
    let eigen = normal.symmetric_eigen();
    let least = tolerances::TURNS * eigen.eigenvalues.max();
    let kept = root * given;
    let mut coordinates = DVector::zeros(motions.len());
    for (value, direction) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        let along = if *value > least { right.dot(&direction) / value } else { kept.dot(&direction) };
        coordinates += direction * along;
    }
    let motion = inverse * coordinates;
    for k in own.filter(|k| !held.contains(k)) {
        velocities[k] = row(k).dot(&motion);
    }
}

/// A root `R` of the mass matrix `R^T R` of the motions of a rigid body: translations 0 to 2, rotations about its center of mass 3 to 5.
fn mass_root(inertia: &Inertia, motions: &[usize]) -> DMatrix<f64> {
    let euler = Matrix3::from_fn(|i, j| inertia.euler[i][j]);
    let moments = (Matrix3::identity() * euler.trace() - euler).symmetric_eigen();
    let turning = Matrix3::from_diagonal(&moments.eigenvalues.map(f64::sqrt)) * moments.eigenvectors.transpose();
    DMatrix::from_fn(motions.len(), motions.len(), |row, column| match (motions[row], motions[column]) {
        (i, j) if i < 3 || j < 3 => f64::from(u8::from(i == j)) * inertia.mass.sqrt(),
        (5, 5) if motions.len() == 3 => euler.trace().sqrt(),
        (i, j) => turning[(i - 3, j - 3)],
    })
}
