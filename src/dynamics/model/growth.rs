//! Bodies whose parts are larger or smaller without stress than where they are: warmed unevenly, swollen.
//!
//! A factor `g` at every point stretches what is without stress: with the deformation gradient `F` against the mesh, the law sees `F/g`,
//! and its energy counts per grown volume. The mass is kept. Cells interpolate the factor between nodes as they do displacements.

use super::definitions::Model;
use super::error::ModelError;

impl Model {
    /// Factors at the nodes of a body that is not without stress in its mesh.
    pub fn growth(&self, body: usize) -> Option<&[f64]> {
        self.growths.iter().rfind(|growth| growth.body == body).map(|growth| &growth.factors[..])
    }

    /// What cannot grow, or not so.
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

/// A body that cannot grow so.
pub fn unsound(body: &str, reason: String) -> ModelError {
    let remedy = "factors are positive numbers about 1, such as `1 + alpha dT`, on a body of an elastic material";
    ModelError::Unsound { what: "growth of body", name: body.into(), reason, remedy }
}
