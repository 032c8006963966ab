//! What a time integrator takes from the vibrations of a body: a stress on the change of the strain in a step, and the stiffness by which
//! velocities are filtered ([`Dissipation`](crate::integrators::Dissipation)).
//!
//! The stress is that of a viscosity whose unit of time is the step. Its moduli are the isotropic ones of the law at rest, which are never
//! negative, wherever the law itself softens; in plane stress those of a plane that is free across. Where cells have a dilatation of their
//! own, the change of volume at a point is nothing that they resist, and only shear is taken.

use super::viscosity::ViscousBody;
use crate::bodies::{Dilatation, Plane};
use crate::dynamics::model::definitions::BodyDefinition;
use crate::dynamics::model::part::{Iterate, Part, Refusal, Sums};
use crate::integrators::Derivative;
use crate::linear::Pattern;
use crate::materials::Viscosity;
use crate::math::workers::Workers;

/// The dissipation of a deformable body in the numbering of the model.
pub struct StepDamping {
    /// With the moduli of the body as viscosities.
    body: ViscousBody,
}

impl StepDamping {
    /// That of a body whose nodes are numbered from `first`.
    pub fn new(body: &BodyDefinition, first: usize) -> Self {
        let [bulk, shear] = body.material.moduli_at_rest().map(|modulus| modulus.max(0.0));
        let lame = bulk - 2.0 / 3.0 * shear;
        let (plane, lame) = match (body.formulation.plane, body.formulation.dilatation) {
            (Plane::Stress, _) if bulk > 0.0 => (Plane::Strain, 2.0 * shear * lame / (lame + 2.0 * shear)),
            (Plane::Stress, _) => (Plane::Strain, 0.0),
            (plane, Dilatation::Pointwise) => (plane, lame),
            (plane, Dilatation::Mean | Dilatation::Linear) => (plane, 0.0),
        };
        StepDamping { body: ViscousBody::with(body, first, plane, Viscosity { shear, bulk: lame, branches: Vec::new() }) }
    }

    /// Finds its places in a new pattern.
    pub fn place(&mut self, pattern: &Pattern) {
        self.body.place(pattern);
    }

    /// Adds the stress `chi/2 C (E_1 - E_0)` at an iterate, and its derivative.
    pub fn linearize(&self, at: &Iterate, chi: f64, sums: &mut Sums) -> Result<(), Refusal> {
        self.body.linearize(&Iterate { weight: 0.5 * chi * at.weight, dt: 1.0, ..*at }, &[], sums)
    }

    /// What that stress has dissipated at the end of a step `[energy]`.
    pub fn dissipated(&self, at: &Iterate, chi: f64) -> f64 {
        0.5 * chi * self.body.after(&Iterate { dt: 1.0, ..*at }, &[]).dissipated
    }

    /// Adds `beta` times the stiffness `B^T C B` at displacements to values of the matrix: its null space are the rigid velocities there.
    pub fn add_stiffness(&self, u: &[f64], beta: f64, workers: &Workers, values: &mut [f64]) {
        let at = Iterate {
            derivative: Derivative::AT_END,
            weight: beta,
            time: 0.0,
            dt: 1.0,
            q_0: &[],
            q_1: &[],
            u_0: u,
            u_1: u,
            q_test: &[],
            velocity: &[],
            velocity_slope: 0.0,
            is_still: false,
            inertia: &[],
        };
        let (mut internal, mut load) = (vec![0.0; u.len()], Vec::new());
        let mut sums = Sums { internal: &mut internal, load: &mut load, tangent: Some(values), workers };
        // A strain that does not change has no stress, and a viscous body refuses nothing.
        let _ = self.body.linearize(&at, &[], &mut sums);
    }
}
