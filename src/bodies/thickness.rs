//! The strain across the plane of a body in plane stress that also resists the rate of strain.
//!
//! No stress acts across the plane: what the law answers there and what the viscosity adds vanish together, `S_33(E, E_33) + V_33 = 0`.
//! `V_33` grows with the rate of `E_33`, so the thickness lags behind the one at which the law alone has no stress there. Its strain is a
//! variable of each point with an equation of its own, remembered as the distance from that of the law. In a step the equation is
//! asked of the algorithmic stress; then nothing across the plane does work, and with a discrete gradient in all four components
//!
//! ```text
//! (S + V)_plane : (E_1 - E_0)_plane = W(E_1, E_33,1) - W(E_0, E_33,0) + V : (E_1 - E_0)
//! ```
//!
//! exactly: what is neither stored nor kept by branches is heat. The body's element loop has the law in its own plane stress,
//! `W~(E) = min over E_33 of W` ([`crate::materials::PlaneStress`]); here is what the strain across adds, `W - W~ >= 0`, which vanishes at
//! rest. The tangent is condensed as there. (The thickness strain as an unknown of each
//! point: de Borst, Communications in Applied Numerical Methods 7, 1991; that of a step that conserves is ours.)

use std::sync::Arc;

use super::batch::{Strain, mean};
use super::special::law_responses;
use crate::integrators::Derivative;
use crate::materials::{BatchedLaw, Components, Kinematics, Material, PlaneStress, Response};
use crate::math::lanes::{Lanes, WIDTH};
use crate::math::simd::{Kernel, dispatch};
use crate::math::tensor::mandel_place;
use crate::math::tolerances::THICKNESS_STRAIN;

/// Most iterations for the strain across the plane: Newton's method needs four to six.
const ITERATIONS: usize = 40;

/// Displacement gradients in the plane at eight points.
pub type PlaneGradients = [[Lanes<false>; 2]; 2];

/// The law of a material whose strain across the plane is a variable.
pub struct Thickness {
    law: Arc<dyn BatchedLaw<4>>,
    equilibrium: PlaneStress,
    strain: Strain,
}

/// How the rate of strain is resisted in a step: a stress `stress` across the plane where the strain there stays, and the derivative
/// `moduli[0] I + moduli[1] 1 (x) 1` of all viscous stresses with respect to the strain at the end.
#[derive(Clone, Copy, Debug)]
pub struct Resistance {
    /// `[stress]`, at eight points.
    pub stress: Lanes<false>,
    /// `[stress]`.
    pub moduli: [f64; 2],
}

/// What the strain across the plane does in a step at eight points.
#[derive(Clone, Copy, Debug)]
pub struct ThicknessStep {
    /// Its change.
    pub change: Lanes<false>,
    /// Its distance from the law's own at the end.
    pub distance: Lanes<false>,
    /// Elastic stress in the plane beyond that of the law's own plane stress `[stress]`.
    pub stress: Components<3>,
    /// Derivative of the stress in the plane with respect to the strain there as the law takes it, beyond the same `[stress]`.
    pub elastic_tangent: [Components<3>; 3],
    /// Derivative of the stress in the plane with respect to the strain at the end as the viscosity takes it `[stress]`.
    pub viscous_tangent: [Components<3>; 3],
}

impl Thickness {
    /// Of a material.
    pub fn new(material: &Material) -> Self {
        let strain = if material.kinematics() == Kinematics::Linear { Strain::Linear } else { Strain::Large };
        Thickness { law: material.axisymmetric(), equilibrium: PlaneStress(material.axisymmetric()), strain }
    }

    /// A step between displacement gradients that starts at a distance from the law's own strain across the plane.
    pub fn step(
        &self,
        gradients: [PlaneGradients; 2],
        distance: Lanes<false>,
        resistance: &Resistance,
        derivative: Derivative,
    ) -> ThicknessStep {
        dispatch(Solve { thickness: self, gradients, distance, resistance, derivative })
    }

    /// Energy per volume beyond that of the law's own plane stress, at a distance from its strain across `[energy/volume]`.
    pub fn energy(&self, gradient: &PlaneGradients, distance: Lanes<false>) -> Lanes<false> {
        let strain = self.strain.of(gradient, Lanes::ZERO);
        let across = self.equilibrium.thickness_strain(&strain);
        let mut energies = [Lanes::ZERO; 2];
        self.law.energies_into(&[completed(&strain, across + distance), completed(&strain, across)], &mut energies);
        energies[0] - energies[1]
    }
}

/// Strains of the plane with that across it.
fn completed(strain: &Components<3>, across: Lanes<false>) -> Components<4> {
    [strain[0], strain[1], across, strain[2]]
}

struct Solve<'a> {
    thickness: &'a Thickness,
    gradients: [PlaneGradients; 2],
    distance: Lanes<false>,
    resistance: &'a Resistance,
    derivative: Derivative,
}

impl Kernel for Solve<'_> {
    type Output = ThicknessStep;

    #[inline(always)]
    fn run<const FMA: bool>(self) -> ThicknessStep {
        let Solve { thickness: Thickness { law, equilibrium, strain }, gradients: [h_0, h_1], distance, resistance, derivative } = self;
        let [start, end, middle]: [Components<3>; 3] = [h_0, h_1, mean(&h_0, &h_1)].map(|h| strain.of(&h, Lanes::ZERO));
        let [own_0, own_1] = [&start, &end].map(|strain| equilibrium.thickness_strain(strain));
        let (across_0, [shear, bulk]) = (own_0 + distance, resistance.moduli);
        let (mut across_1, mut response) = (own_1 + distance, [Response::ZERO]);
        let (mut is_found, mut changes) = (false, [0.0f64; WIDTH]);
        for _ in 0..ITERATIONS {
            let strains = [(start, across_0), (end, across_1), (middle, (across_0 + across_1) * 0.5)];
            let strains = strains.map(|(strain, across)| completed(&strain, across));
            law_responses::<FMA, 4>(&**law, strains.each_ref().map(std::slice::from_ref), derivative, &mut response);
            if is_found {
                break;
            }
            let slope = response[0].tangent[2][2] + (shear + bulk);
            let stress = response[0].stress[2] + resistance.stress + (across_1 - across_0) * (shear + bulk);
            for lane in 0..WIDTH {
                // No more than to a fifth of the thickness in one step.
                changes[lane] = (-stress.0[lane] / slope.0[lane]).max(-0.48 * (1.0 + 2.0 * across_1.0[lane]));
                across_1.0[lane] += changes[lane];
            }
            is_found = changes.iter().all(|change| change.abs() <= THICKNESS_STRAIN);
        }
        let mut own_response = [Response::ZERO];
        law_responses::<FMA, 3>(equilibrium, [&start, &end, &middle].map(std::slice::from_ref), derivative, &mut own_response);
        let elastic = response[0].tangent;
        let viscous = |k: usize, l: usize| shear * f64::from(k == l) + bulk * f64::from(k < 3 && l < 3);
        let across = elastic[2][2] + viscous(2, 2);
        let mut step = ThicknessStep {
            change: across_1 - across_0,
            distance: across_1 - own_1,
            stress: [Lanes::ZERO; 3],
            elastic_tangent: [[Lanes::ZERO; 3]; 3],
            viscous_tangent: [[Lanes::ZERO; 3]; 3],
        };
        for k in 0..3 {
            let row = mandel_place::<3>(k);
            step.stress[k] = response[0].stress[row] - own_response[0].stress[k];
            for lane in 0..WIDTH {
                // Where there is no such strain, there is no stress, and the step is taken in halves.
                if changes[lane].abs() > THICKNESS_STRAIN {
                    step.stress[k].0[lane] = f64::NAN;
                }
            }
            let drawn = (elastic[row][2] + viscous(row, 2)) / across;
            for l in 0..3 {
                let column = mandel_place::<3>(l);
                step.elastic_tangent[k][l] = elastic[row][column] - drawn * elastic[2][column] - own_response[0].tangent[k][l];
                step.viscous_tangent[k][l] = drawn * -viscous(2, column) + viscous(row, column);
            }
        }
        step
    }
}
