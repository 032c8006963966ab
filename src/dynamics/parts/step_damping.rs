//! Algorithmic dissipation of a body: a stress proportional to the change of the strain in a step, and the stiffness of the velocity filter
//! ([`Dissipation`](crate::integrators::Dissipation)).
//!
//! The stress is that of a viscosity whose unit of time is the step. Its moduli are the isotropic ones of the law at rest, limited to
//! nonnegative values for laws that soften; in plane stress those with a stress-free thickness direction. In cells with a mean dilatation
//! it acts on shear alone, since these do not resist a volume change at a point.

use super::body::step_of;
use crate::bodies::{BodyCells, Dilatation, ElementLoop, Elements, Formulation, Plane, Space, Step};
use crate::dynamics::model::definitions::BodyDefinition;
use crate::dynamics::model::part::{Iterate, Sums};
use crate::integrators::Derivative;
use crate::linear::Pattern;
use crate::materials::Viscosity;

/// The dissipation of a deformable body in global node numbers.
pub struct StepDamping<const D: usize> {
    /// Element loop with the isotropic moduli of the body as viscosities.
    elements: Box<dyn ElementLoop<D>>,
}

impl<const D: usize> StepDamping<D>
where
    Space<D>: Elements<D>,
{
    /// Algorithmic dissipation of a body whose nodes are numbered from `first`; `None` for an unsound mesh, which the body itself refuses.
    pub fn new(body: &BodyDefinition, first: usize) -> Option<Self> {
        let [bulk, shear] = body.material.moduli_at_rest().map(|modulus| modulus.max(0.0));
        let lame = bulk - 2.0 / 3.0 * shear;
        let (plane, lame) = match (body.formulation.plane, body.formulation.dilatation) {
            (Plane::Stress, _) if bulk > 0.0 => (Plane::Strain, 2.0 * shear * lame / (lame + 2.0 * shear)),
            (Plane::Stress, _) => (Plane::Strain, 0.0),
            (plane, Dilatation::Pointwise) => (plane, lame),
            (plane, Dilatation::Mean | Dilatation::Linear) => (plane, 0.0),
        };
        let (formulation, moduli) =
            (Formulation { plane, dilatation: Dilatation::Pointwise }, Viscosity { shear, bulk: lame, branches: Vec::new() });
        let cells = BodyCells { first_node: first, resistance: Some(&moduli), ..BodyCells::new(&body.mesh, &body.material, formulation) };
        Some(StepDamping { elements: Space::<D>::elements(&cells).ok()? })
    }
}

impl<const D: usize> StepDamping<D> {
    /// Finds the positions of the body's blocks in a new pattern.
    pub fn place(&mut self, pattern: &Pattern) {
        self.elements.place(pattern);
    }

    /// Adds the stress `chi/2 C (E_1 - E_0)` at an iterate, and its derivative.
    pub fn linearize(&self, at: &Iterate, chi: f64, sums: &mut Sums) {
        let step = Step { weight: 0.5 * chi * at.weight, dt: 1.0, ..step_of(at, &[]) };
        self.elements.add_step(&step, sums.internal, sums.tangent.as_deref_mut());
    }

    /// Energy dissipated by the viscous stress with the factor `chi` over a step `[energy]`.
    pub fn dissipated(&self, at: &Iterate, chi: f64) -> f64 {
        0.5 * chi * self.elements.advance(&Step { dt: 1.0, ..step_of(at, &[]) }).viscous
    }

    /// Adds `beta` times the stiffness `B^T C B` at the displacements `u` to values of the matrix; its null space are the rigid velocities.
    pub fn add_stiffness(&self, u: &[f64], beta: f64, values: &mut [f64]) {
        // A constant strain has no viscous stress.
        let step = Step { derivative: Derivative::AT_END, weight: beta, inertia: 0.0, u_0: u, u_1: u, history: &[], dt: 1.0 };
        self.elements.add_step(&step, &mut vec![0.0; u.len()], Some(values));
    }
}
