//! Bodies with a stress-free stretch (`grow`): swelling, uneven thermal expansion.
//!
//! A factor `g` at every point is the stress-free stretch: with the deformation gradient `F` relative to the mesh, the law is evaluated at
//! `F/g`, and its energy is per grown volume. The mass is conserved. Cells interpolate the factor between nodes like displacements.

use super::definitions::Model;
use super::error::ModelError;

impl Model {
    /// Nodal factors of a body with a stress-free stretch; `None` for other bodies.
    pub fn growth(&self, body: usize) -> Option<&[f64]> {
        self.growths.iter().rfind(|growth| growth.body == body).map(|growth| &growth.factors[..])
    }

    /// Checks that bodies with a stress-free stretch are deformable, not viscous, and have positive factors.
    pub(super) fn check_growths(&self) -> Result<(), ModelError> {
        for growth in &self.growths {
            let body = &self.bodies[growth.body];
            if body.rigid.is_some() {
                return Err(ModelError::NotRigid { body: body.name.clone(), reason: "it cannot be strained by a growth".into() });
            }
            if !body.material.viscosity().is_none() {
                return Err(unsound(&body.name, "its material is viscous, and its memory knows nothing of a growth".into()));
            }
            if let Some((node, factor)) = growth.factors.iter().enumerate().find(|(_, factor)| !(factor.is_finite() && **factor > 0.0)) {
                return Err(unsound(&body.name, format!("the factor at its node {node} is {factor}")));
            }
        }
        Ok(())
    }
}

/// Error for a body with an invalid stress-free stretch.
pub fn unsound(body: &str, reason: String) -> ModelError {
    let remedy = "factors are positive numbers about 1, such as `1 + alpha dT`, on a body of an elastic material";
    ModelError::Unsound { what: "growth of body", name: body.into(), reason, remedy }
}
