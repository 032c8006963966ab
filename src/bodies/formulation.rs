//! Strain formulation of a body: plane strain, plane stress or axisymmetric, and the treatment of the dilatation.

use thiserror::Error;

use crate::elements::CellKind;
use crate::materials::{Kinematics, Material};
use crate::math::tolerances::AXIS;
use crate::mesh::Mesh;

/// Condition for the third direction of plane cells; ignored for bodies in space.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Plane {
    /// Plane strain: no stretch across the plane.
    #[default]
    Strain,
    /// Plane stress: the stretch across the plane follows from zero stress there. Forces are per thickness.
    Stress,
    /// Body of revolution about the second axis, meshed as half a section: the first coordinate is the radius. Volumes, masses and forces
    /// are those of the whole circumference.
    Axisymmetric,
}

/// Treatment of the dilatation in an element.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Dilatation {
    /// Dilatation of each quadrature point: volumetric locking for nearly incompressible materials.
    #[default]
    Pointwise,
    /// Mean dilatation of the element (Nagtegaal, Parks and Rice 1974; Simo, Taylor and Pister 1985), without volumetric locking.
    Mean,
    /// Dilatation linear in the element: no volumetric locking with biquadratic displacements, second-order accurate.
    Linear,
}

/// The formulation of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Formulation {
    /// Condition for the third direction of a plane body.
    pub plane: Plane,
    /// Treatment of the dilatation.
    pub dilatation: Dilatation,
}

/// Formulation that is incompatible with the material or mesh.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FormulationError {
    /// Law whose energy is not split into a volumetric and a remaining part.
    #[error("a dilatation of the cell needs a law with a volumetric part, and `{law}` has none")]
    NoVolumetricPart {
        /// Name of the law.
        law: &'static str,
    },
    /// Mean dilatation in plane stress, where the stretch across the plane would be determined by two conditions.
    #[error("a dilatation of the cell cannot be combined with plane stress, in which the volume is free anyway")]
    MeanInPlaneStress,
    /// Linear dilatation in unsuitable cells, which would lock or leave the pressure undetermined.
    #[error("a linear dilatation is one of `quad9` or `hex27` cells, and these are `{cells}`")]
    LinearOfOthers {
        /// Name of the body's cell kind.
        cells: &'static str,
    },
    /// Plane stress, plane strain or axisymmetry requested for a body in space.
    #[error("a body of `{cells}` cells is in space: it is neither plane nor axisymmetric")]
    NotPlane {
        /// Name of the body's cell kind.
        cells: &'static str,
    },
    /// Body of revolution with nodes beyond its axis.
    #[error("a node of an axisymmetric body is at x = {x}, on the other side of the axis x = 0")]
    BeyondAxis {
        /// Smallest first coordinate `[length]`.
        x: f64,
    },
    /// Dilatation of the cell for a law of linear strains, which is not supported.
    #[error("a dilatation of the cell is one of large strains, and `{law}` is linear")]
    MeanOfLinear {
        /// Name of the law.
        law: &'static str,
    },
}

impl FormulationError {
    /// Returns the stable code of the error, which `conserva doc` explains.
    pub fn code(&self) -> &'static str {
        match self {
            FormulationError::NoVolumetricPart { .. } => "C0151",
            FormulationError::MeanInPlaneStress => "C0152",
            FormulationError::LinearOfOthers { .. } => "C0153",
            FormulationError::NotPlane { .. } => "C0154",
            FormulationError::BeyondAxis { .. } => "C0155",
            FormulationError::MeanOfLinear { .. } => "C0156",
        }
    }

    /// Suggested remedy.
    pub fn hint(&self) -> String {
        use FormulationError::*;
        match self {
            NoVolumetricPart { .. } => "take `neo_hookean` or another law with a bulk modulus, or give the energy a part in J alone".into(),
            MeanInPlaneStress => "leave one of the two out".into(),
            LinearOfOthers { .. } => "take a mean dilatation, or cells of `quad9` or `hex27`".into(),
            NotPlane { .. } => "leave the plane condition out".into(),
            BeyondAxis { .. } => "mesh one half of the section, with x >= 0 as the radius".into(),
            MeanOfLinear { .. } => "take `neo_hookean`, whose small strains are those of linear elasticity".into(),
        }
    }
}

/// True if cells of a kind support a linear dilatation.
fn takes_linear(kind: CellKind) -> bool {
    matches!(kind, CellKind::Quad9 | CellKind::Hex27)
}

impl Formulation {
    /// Default formulation for a mesh and a material. If the law is nearly incompressible and splits off a volumetric energy, the
    /// dilatation is linear in biquadratic and triquadratic cells and a mean in other cells that permit it; otherwise pointwise.
    pub fn suited(plane: Plane, mesh: &Mesh, material: &Material) -> Self {
        let can = plane != Plane::Stress && material.kinematics() == Kinematics::GreenLagrange && material.split().is_some();
        let dilatation = if !can || mesh.kinds().all(CellKind::has_one_point) || !material.hardly_changes_volume() {
            Dilatation::Pointwise
        } else if mesh.kinds().all(takes_linear) {
            Dilatation::Linear
        } else {
            Dilatation::Mean
        };
        Formulation { plane, dilatation }
    }

    /// Moves nodes of a body of revolution onto the axis if they miss it by round-off; returns true if at least one was moved.
    pub fn put_on_axis(&self, points: &mut [[f64; 3]]) -> bool {
        let extent = points.iter().flatten().fold(0.0f64, |largest, x| largest.max(x.abs()));
        let is_beside = |x: f64| x != 0.0 && x.abs() <= AXIS * extent;
        if self.plane != Plane::Axisymmetric || !points.iter().any(|point| is_beside(point[0])) {
            return false;
        }
        points.iter_mut().filter(|point| is_beside(point[0])).for_each(|point| point[0] = 0.0);
        true
    }

    /// Checks that the formulation is compatible with a mesh and a material.
    ///
    /// # Errors
    /// The first incompatibility.
    pub fn check(&self, mesh: &Mesh, material: &Material) -> Result<(), FormulationError> {
        let law = material.name();
        if mesh.dimension() == 3 && self.plane != Plane::Strain {
            return Err(FormulationError::NotPlane { cells: mesh.blocks[0].kind.name() });
        }
        let other = mesh.kinds().find(|&kind| !takes_linear(kind));
        if let (Dilatation::Linear, Some(other)) = (self.dilatation, other) {
            return Err(FormulationError::LinearOfOthers { cells: other.name() });
        }
        if self.dilatation != Dilatation::Pointwise {
            if self.plane == Plane::Stress {
                return Err(FormulationError::MeanInPlaneStress);
            }
            if material.kinematics() == Kinematics::Linear {
                return Err(FormulationError::MeanOfLinear { law });
            }
            if material.split().is_none() {
                return Err(FormulationError::NoVolumetricPart { law });
            }
        }
        let least = mesh.points.iter().map(|point| point[0]).fold(f64::INFINITY, f64::min);
        if self.plane == Plane::Axisymmetric && least < 0.0 {
            return Err(FormulationError::BeyondAxis { x: least });
        }
        Ok(())
    }
}
