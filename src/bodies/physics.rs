//! What a body's cells ask of its material and formulation: laws in the `S` components of the cells, and in `L` where that is not enough.

use std::sync::Arc;

use super::batch::Strain;
use super::formulation::{Dilatation, Formulation, Plane};
use super::special::Special;
use crate::materials::{BatchedLaw, Components, Kinematics, Material, MeanValue, PlaneStress};
use crate::math::lanes::Lanes;
use crate::math::tensor::mandel_place;

/// Laws and strains of a body.
pub(super) struct Physics<const S: usize, const L: usize> {
    /// The law of the points.
    pub(super) law: Arc<dyn BatchedLaw<S>>,
    /// What the cells ask instead, where that is not enough.
    pub(super) special: Option<Special<L>>,
    /// The law in space, which also knows the stress across the plane; with a dilatation of the cell, without its volumetric part.
    pub(super) spatial_law: Arc<dyn BatchedLaw<6>>,
    /// The law whose strain across the plane is solved for.
    plane_stress: Option<PlaneStress>,
    /// Which strain it is.
    pub(super) strain: Strain,
    /// Mass per undeformed volume.
    pub(super) density: f64,
}

fn strain_of(material: &Material) -> Strain {
    if material.kinematics() == Kinematics::Linear { Strain::Linear } else { Strain::Large }
}

impl<const S: usize, const L: usize> Physics<S, L> {
    fn new(material: &Material, law: Arc<dyn BatchedLaw<S>>, special: Option<Special<L>>) -> Self {
        let is_mean = special.as_ref().is_some_and(|special| special.volumetric.is_some());
        let spatial_law = match material.split() {
            Some(split) if is_mean => split.space.clone(),
            _ => material.space(),
        };
        Physics { law, special, spatial_law, plane_stress: None, strain: strain_of(material), density: material.density() }
    }

    /// With the mean-value discrete gradients of its laws. The volumetric part of a law is a function of one number, which has but one
    /// discrete gradient.
    pub(super) fn averaged(self) -> Self
    where
        MeanValue<S>: BatchedLaw<S>,
        MeanValue<L>: BatchedLaw<L>,
    {
        let special = self.special.map(|special| Special { law: Arc::new(MeanValue(special.law)), ..special });
        Physics { law: Arc::new(MeanValue(self.law)), special, ..self }
    }

    /// Whether the body is stretched around an axis.
    pub(super) fn is_axisymmetric(&self) -> bool {
        self.special.as_ref().is_some_and(|special| special.is_axisymmetric)
    }

    /// Number of directions in which cells in so many dimensions have lengths.
    pub(super) fn directions<const D: usize>(&self) -> usize {
        if self.is_axisymmetric() { 3 } else { D }
    }

    /// Strain in space at a point; `hoop` is the displacement gradient around an axis.
    pub(super) fn spatial_strain(&self, strain: &Components<S>, hoop: Lanes<false>) -> Components<6> {
        let mut all = [Lanes::ZERO; 6];
        for (k, component) in strain.iter().enumerate() {
            all[mandel_place::<S>(k)] = *component;
        }
        if self.is_axisymmetric() {
            all[2] = self.strain.around(hoop);
        }
        if let Some(law) = &self.plane_stress {
            all[2] = law.thickness_strain(&[all[0], all[1], all[3]]);
        }
        all
    }
}

impl Physics<3, 4> {
    /// Of a plane body, or one of revolution.
    pub(super) fn of_plane(material: &Material, formulation: Formulation) -> Self {
        let (is_axisymmetric, strain) = (formulation.plane == Plane::Axisymmetric, strain_of(material));
        let whole = || Special { law: material.axisymmetric(), volumetric: None, is_linear: false, strain, is_axisymmetric };
        match (formulation.dilatation, material.split()) {
            (Dilatation::Mean | Dilatation::Linear, Some(split)) => {
                let volumetric = Some(split.volumetric.clone());
                let is_linear = formulation.dilatation == Dilatation::Linear;
                let special = Special { law: split.axisymmetric.clone(), volumetric, is_linear, ..whole() };
                Physics::new(material, material.plane(), Some(special))
            }
            _ if is_axisymmetric => Physics::new(material, material.plane(), Some(whole())),
            _ if formulation.plane == Plane::Stress => {
                let law = || PlaneStress(material.axisymmetric());
                Physics { plane_stress: Some(law()), ..Physics::new(material, Arc::new(law()), None) }
            }
            _ => Physics::new(material, material.plane(), None),
        }
    }
}

impl Physics<6, 6> {
    /// Of a body in space.
    pub(super) fn of_space(material: &Material, formulation: Formulation) -> Self {
        let special = material.split().filter(|_| formulation.dilatation != Dilatation::Pointwise).map(|split| Special {
            law: split.space.clone(),
            volumetric: Some(split.volumetric.clone()),
            is_linear: formulation.dilatation == Dilatation::Linear,
            strain: strain_of(material),
            is_axisymmetric: false,
        });
        Physics::new(material, material.space(), special)
    }
}
