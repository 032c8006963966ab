//! Detection of volumetric locking: bodies whose cells cannot follow a nearly incompressible law.
//!
//! A nearly incompressible law leaves no freedom to cells that preserve the volume at every quadrature point: they lock (Nagtegaal, Parks
//! and Rice, CMAME 4, 1974). A mean dilatation per cell avoids this, except in first-order triangles and tetrahedra, which have a single
//! point.

use super::definitions::{BodyDefinition, Model};
use crate::bodies::{Dilatation, Plane};
use crate::elements::CellKind;
use crate::materials::Kinematics;

/// Body with volumetric locking.
#[derive(Clone, Debug, PartialEq)]
pub struct Locking {
    /// Name of the body.
    pub body: String,
    /// Material law.
    pub law: &'static str,
    /// Element type.
    pub cells: CellKind,
    /// Bulk modulus over shear modulus at zero strain.
    pub ratio: f64,
    /// True if a mean dilatation prevents locking.
    pub is_curable: bool,
    /// True if the law has a form with a mean dilatation.
    pub has_mean: bool,
    /// True if plastic flow and not the elastic law preserves the volume.
    pub flows: bool,
}

impl std::fmt::Display for Locking {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Locking { body, cells, ratio, flows, .. } = self;
        let why = if *flows {
            "plastic flow keeps its volume".into()
        } else {
            format!("its law resists a change of volume {ratio:.0} times as much as shear")
        };
        write!(out, "body \"{body}\" locks: {why}, and `{}` cells", cells.name())?;
        write!(
            out,
            " {}",
            if self.is_curable { "with a pointwise dilatation cannot follow" } else { "cannot keep their volume and still deform" }
        )
    }
}

impl Locking {
    /// Stable code of the finding, explained by `conserva doc`.
    pub fn code(&self) -> &'static str {
        "C0321"
    }

    /// Suggested remedy.
    pub fn hint(&self) -> String {
        if !self.has_mean {
            return "take `neo_hookean`, whose small strains are the same, so that cells can have a mean dilatation".into();
        }
        match (self.is_curable, self.cells) {
            (true, _) => "let the dilatation be one mean for each cell".into(),
            (false, CellKind::Tet4) => "mesh the body with `tet10` or `hex8` cells".into(),
            (false, _) => "mesh the body with `tri6`, `quad4` or `quad8` cells".into(),
        }
    }
}

impl Model {
    /// Bodies that lock because their laws are nearly incompressible.
    pub fn locking(&self) -> Vec<Locking> {
        let of = |body: &BodyDefinition| {
            let one_point = body.mesh.kinds().find(|kind| kind.has_one_point());
            let (ratio, has_one_point) = (body.material.bulk_over_shear(), one_point.is_some());
            let cells = one_point.unwrap_or(body.mesh.blocks[0].kind);
            let is_free =
                body.formulation.plane == Plane::Stress || (body.formulation.dilatation != Dilatation::Pointwise && !has_one_point);
            let has_mean = body.material.kinematics() == Kinematics::GreenLagrange && body.material.split().is_some();
            (body.material.hardly_changes_volume() && !is_free).then(|| Locking {
                body: body.name.clone(),
                law: body.material.name(),
                cells,
                ratio,
                is_curable: !has_one_point,
                has_mean,
                flows: body.flows(),
            })
        };
        self.bodies.iter().filter(|body| body.rigid.is_none()).filter_map(of).collect()
    }
}
