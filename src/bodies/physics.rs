//! Laws of a body by its material and formulation: in the `S` strain components of the cells, or in `L` components where a hoop strain, a
//! strain across the plane, history variables or a cell dilatation require them.

use std::sync::Arc;

use super::batch::Strain;
use super::formulation::{Dilatation, Formulation, Plane};
use super::special::{PointLaw, Special};
use super::viscous::ViscousLaw;
use crate::materials::{
    BatchedLaw, Components, FreeThickness, HistoryLaw, Kinematics, Material, MeanValue, PlaneStress, PointHistory, Viscosity,
};
use crate::math::lanes::Lanes;
use crate::math::tensor::mandel_place;
use crate::mesh::Mesh;

/// Data of a body's cells from which its element loop is made.
#[derive(Clone, Copy, Debug)]
pub struct BodyCells<'a> {
    /// Mesh of the body.
    pub mesh: &'a Mesh,
    /// Material of the body.
    pub material: &'a Material,
    /// Formulation that is compatible with mesh and material ([`Formulation::check`]).
    pub formulation: Formulation,
    /// Number of the mesh's first node in the model.
    pub first_node: usize,
    /// True if the time integrator uses the mean stress over a step (mean-value discrete gradient).
    pub averages_stress: bool,
    /// Viscosity whose stress replaces the stress of the material; `None`: stress of the material.
    pub resistance: Option<&'a Viscosity>,
}

impl<'a> BodyCells<'a> {
    /// Returns the cells of a single body, without stress averaging.
    pub fn new(mesh: &'a Mesh, material: &'a Material, formulation: Formulation) -> Self {
        BodyCells { mesh, material, formulation, first_node: 0, averages_stress: false, resistance: None }
    }
}

/// Laws and strains of a body.
pub(super) struct Physics<const S: usize, const L: usize> {
    /// Law at the quadrature points.
    pub(super) law: Arc<dyn BatchedLaw<S>>,
    /// Special stress, used in place of `law` if the strain components of the cells do not suffice.
    pub(super) special: Option<Special<L>>,
    /// Law in space, for the stress across the plane; without its volumetric part in cells with a cell dilatation.
    pub(super) spatial_law: Arc<dyn BatchedLaw<6>>,
    /// Law in plane stress, which determines the strain across the plane.
    plane_stress: Option<PlaneStress>,
    /// Strain measure of the law.
    pub(super) strain: Strain,
    /// Mass per undeformed volume.
    pub(super) density: f64,
}

/// Green-Lagrange strain and second Piola-Kirchhoff stress in space at a point of eight cells.
pub(super) struct BatchStress {
    pub(super) strain: Components<6>,
    pub(super) stress: Components<6>,
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

    /// True for a body of revolution, which has a hoop strain.
    pub(super) fn is_axisymmetric(&self) -> bool {
        self.special.as_ref().is_some_and(|special| special.is_axisymmetric)
    }

    /// Number of directions in which stress-free lengths of cells in `D` dimensions can change.
    pub(super) fn directions<const D: usize>(&self) -> usize {
        if self.is_axisymmetric() { 3 } else { D }
    }

    /// Green-Lagrange strain and second Piola-Kirchhoff stress in space at a point of a batch with the history variables `kept`.
    pub(super) fn seen(&self, strain: &Components<S>, hoop: Lanes<false>, kept: &[Lanes<false>], point: usize) -> BatchStress {
        let mut space = self.spatial_strain(strain, hoop);
        let (mut own, mut stress) = ([[Lanes::ZERO; L]], [[Lanes::ZERO; 6]]);
        let Some((law, kept)) = self.history_of(kept, point) else {
            self.spatial_law.stresses_into(&[space], &mut stress);
            return BatchStress { strain: space, stress: stress[0] };
        };
        if let Some(across) = law.across(kept) {
            space[2] = across;
        }
        for k in 0..L {
            own[0][k] = space[mandel_place::<L>(k)];
        }
        let mut answer = [[Lanes::ZERO; L]];
        law.stresses_into(&own, kept, &mut answer);
        for k in 0..L {
            stress[0][mandel_place::<L>(k)] = answer[0][k];
        }
        BatchStress { strain: space, stress: stress[0] }
    }

    /// History values of a point for fields, in one lane of a batch.
    pub(super) fn shown(&self, kept: &[Lanes<false>], point: usize, lane: usize) -> Option<PointHistory> {
        self.history_of(kept, point).and_then(|(law, kept)| law.shown(kept, lane))
    }

    /// Law with history variables, and the history variables of a point of a batch; `None` for other laws.
    fn history_of<'a>(&self, kept: &'a [Lanes<false>], point: usize) -> Option<(&dyn HistoryLaw<L>, &'a [Lanes<false>])> {
        let law = self.special.as_ref()?.law.history()?;
        Some((law, &kept[point * law.variables()..][..law.variables()]))
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

/// Elastic law, with the mean-value discrete gradient if the time integrator averages the stress over a step. A volumetric law depends on
/// one number, for which all discrete gradients coincide.
fn of_step<const S: usize>(body: &BodyCells, law: Arc<dyn BatchedLaw<S>>) -> Arc<dyn BatchedLaw<S>>
where
    MeanValue<S>: BatchedLaw<S>,
{
    if body.averages_stress { Arc::new(MeanValue(law)) } else { law }
}

/// Law at the points of a body: elastic or with history variables, including the viscosity of the material.
fn point_law<const L: usize>(body: &BodyCells, elastic: Arc<dyn BatchedLaw<L>>, history: Option<Arc<dyn HistoryLaw<L>>>) -> PointLaw<L>
where
    MeanValue<L>: BatchedLaw<L>,
{
    if let Some(resistance) = body.resistance {
        return PointLaw::History(Arc::new(ViscousLaw::alone(resistance)));
    }
    let law = history.map_or_else(|| PointLaw::Elastic(of_step(body, elastic)), PointLaw::History);
    let viscosity = body.material.viscosity();
    if viscosity.is_none() { law } else { PointLaw::History(Arc::new(ViscousLaw::new(law, viscosity))) }
}

/// True for bodies whose stress depends on history variables or strain rates.
fn remembers(body: &BodyCells) -> bool {
    body.resistance.is_some() || body.material.history().is_some() || !body.material.viscosity().is_none()
}

impl Physics<3, 4> {
    /// Returns the laws of a plane body or a body of revolution.
    pub(super) fn of_plane(body: &BodyCells) -> Self {
        let &BodyCells { material, formulation, .. } = body;
        let (is_axisymmetric, strain) = (formulation.plane == Plane::Axisymmetric, strain_of(material));
        let is_free = formulation.plane == Plane::Stress;
        let law = |has_volume: bool, elastic| match point_law(body, elastic, material.history().map(|history| history.plane(has_volume))) {
            PointLaw::History(law) if is_free => PointLaw::History(Arc::new(FreeThickness(law))),
            law => law,
        };
        let whole = || Special { law: law(true, material.axisymmetric()), volumetric: None, is_linear: false, strain, is_axisymmetric };
        let of = |special| Physics::new(material, of_step(body, material.plane()), special);
        match (formulation.dilatation, material.split()) {
            (Dilatation::Mean | Dilatation::Linear, Some(split)) => {
                let volumetric = Some(split.volumetric.clone());
                let is_linear = formulation.dilatation == Dilatation::Linear;
                of(Some(Special { law: law(false, split.axisymmetric.clone()), volumetric, is_linear, ..whole() }))
            }
            _ if is_axisymmetric || remembers(body) => of(Some(whole())),
            _ if is_free => {
                let law = || PlaneStress(material.axisymmetric());
                Physics { plane_stress: Some(law()), ..Physics::new(material, of_step(body, Arc::new(law())), None) }
            }
            _ => of(None),
        }
    }
}

impl Physics<6, 6> {
    /// Returns the laws of a body in space.
    pub(super) fn of_space(body: &BodyCells) -> Self {
        let &BodyCells { material, formulation, .. } = body;
        let law = |has_volume: bool, elastic| point_law(body, elastic, material.history().map(|history| history.space(has_volume)));
        let of = |law, volumetric| Special {
            law,
            volumetric,
            is_linear: formulation.dilatation == Dilatation::Linear,
            strain: strain_of(material),
            is_axisymmetric: false,
        };
        let special = match material.split().filter(|_| formulation.dilatation != Dilatation::Pointwise) {
            Some(split) => Some(of(law(false, split.space.clone()), Some(split.volumetric.clone()))),
            None => remembers(body).then(|| of(law(true, material.space()), None)),
        };
        Physics::new(material, of_step(body, material.space()), special)
    }
}
