//! Hints on models: refusals and findings.

use super::words::ScriptWords;
use crate::bodies::FormulationError;
use crate::dynamics::{Locking, ModelError, Overlap, OverlapKind};
use crate::elements::CellKind;

impl ScriptWords for ModelError {
    fn remedy(&self) -> String {
        match self {
            ModelError::NoBodies { .. } => "add one with `model.add_body(name, mesh, material)`".into(),
            ModelError::EmptyBoundary { .. } => "choose a boundary that has facets; `print(mesh)` lists them with their counts".into(),
            ModelError::PointBoundary { .. } => {
                "points can be held (`fix`), moved (`prescribe`) and loaded with a `force`; other loads and contacts need facets".into()
            }
            ModelError::OpenChamber { .. } => {
                "name all boundaries around the gas in `boundaries`, or where symmetry closes it give `rim_point`, a point in the planes \
                 of all its rims"
                    .into()
            }
            ModelError::SelfContact { .. } => {
                "name two boundaries without common facets as `secondary` and `primary`, or use `add_self_contact` for a surface that folds"
                    .into()
            }
            ModelError::HeldAndMoved { .. } => {
                "hold the other directions only, as in `fix(boundary, \"x\")`, or leave this one out of `prescribe`".into()
            }
            ModelError::Formulation { source, .. } => source.remedy(),
            _ => self.hint(),
        }
    }
}

impl ScriptWords for FormulationError {
    fn remedy(&self) -> String {
        match self {
            FormulationError::NoVolumetricPart { .. } => {
                "take `neo_hookean` or another law with a bulk modulus, or `hyperelastic` with the key `volumetric` for the part in J"
                    .into()
            }
            FormulationError::LinearOfOthers { .. } => {
                "take `dilatation: \"mean\"`, or `mesh.with_elements(\"quad9\")` (in space `\"hex27\"`)".into()
            }
            FormulationError::NotPlane { .. } => "leave `plane` out".into(),
            _ => self.hint(),
        }
    }
}

impl ScriptWords for Locking {
    fn remedy(&self) -> String {
        match (self.is_curable, self.cells) {
            _ if !self.has_mean => self.hint(),
            (true, _) => "let the dilatation be one mean for each cell: `#{ dilatation: \"mean\" }`, or leave it out".into(),
            (false, CellKind::Tet4) => "take `mesh.with_elements(\"tet10\")`, or mesh the body with `hex8` cells".into(),
            (false, _) => "take `mesh.with_elements(\"tri6\")`, or mesh the body with `quad4` or `quad8` cells".into(),
        }
    }
}

impl ScriptWords for Overlap {
    fn remedy(&self) -> String {
        let kept = "move one of them, press them apart by `sim.settle()` before the first step, or keep the overlap with `accept_overlap: \
                    true` in `simulate`";
        match (&self.kind, &self.contact) {
            (OverlapKind::Bodies(_), None) | (OverlapKind::Obstacle { whole: true, .. }, _) => self.hint().into(),
            (OverlapKind::Bodies(_), Some(_)) => kept.into(),
            (OverlapKind::Obstacle { whole: false, .. }, _) => format!("{kept}; turn round an obstacle that looks the wrong way"),
        }
    }
}
