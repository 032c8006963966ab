//! Laws whose stress depends on the deformation history, by history variables at every quadrature point.
//!
//! A law is given the strains at both ends of a step and the history variables at its start. It returns the stress of the step with its
//! derivative and, at the end of an accepted step, the new history variables and the heat. The work of [`StressOf::Step`] on the strain
//! increment is exactly the change of the stored energy plus the heat `D`:
//!
//! ```text
//! S : (E_1 - E_0) = psi(E_1, h_1) - psi(E_0, h_0) + D
//! ```

use std::sync::Arc;

use super::batched::{Components, Response};
use crate::math::lanes::Lanes;

/// Kind of stress required in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StressOf {
    /// Mean stress of the step: its work is exactly the change of the stored energy and the heat.
    Step,
    /// Stress at the strain in the middle of the step.
    Middle,
    /// Stress at the end of the step.
    End,
}

/// A step at some points of eight elements each.
#[derive(Clone, Copy)]
pub struct StrainStep<'a, const S: usize> {
    /// Green-Lagrange strains at the start.
    pub start: &'a [Components<S>],
    /// Strains at the end.
    pub end: &'a [Components<S>],
    /// Strains of the mean displacement gradient.
    pub middle: &'a [Components<S>],
    /// Strain increments from start to end, without the cancellation of two nearly equal strains.
    pub change: &'a [Components<S>],
    /// History variables at the start: [`HistoryLaw::variables`] numbers per point, point after point.
    pub history: &'a [Lanes<false>],
    /// Step size `[time]`; 0 at rest, where rate-dependent stresses have relaxed.
    pub dt: f64,
    /// Required kind of stress.
    pub stress: StressOf,
}

impl<'a, const S: usize> StrainStep<'a, S> {
    /// A step at rest without motion.
    pub fn at_rest(strain: &'a [Components<S>], change: &'a [Components<S>], history: &'a [Lanes<false>]) -> Self {
        StrainStep { start: strain, end: strain, middle: strain, change, history, dt: 0.0, stress: StressOf::End }
    }

    /// History variables of a point, `variables` of them.
    pub fn history_of(&self, point: usize, variables: usize) -> &'a [Lanes<false>] {
        &self.history[point * variables..(point + 1) * variables]
    }
}

/// A law with history variables, in `S` Mandel components: 4 where the third direction is stretched but not sheared, 6 in space. All
/// history variables are 0 at the start.
pub trait HistoryLaw<const S: usize>: Send + Sync {
    /// Number of history variables of a point.
    fn variables(&self) -> usize;

    /// Stresses of a step and their derivatives `[stress]` with respect to the strain at the end; for [`StressOf::Middle`], half of the
    /// derivatives with respect to the strain at mid-step.
    fn responses_into(&self, step: &StrainStep<S>, responses: &mut [Response<S>]);

    /// Computes derivatives of the stress with respect to the strain increment, as responses without a stress; returns false if the stress
    /// at mid-step does not depend on the increment.
    ///
    /// Called for [`StressOf::Middle`] only: the derivatives of [`HistoryLaw::responses_into`] then refer to the strain at mid-step.
    fn rate_responses_into(&self, _step: &StrainStep<S>, _responses: &mut [Response<S>]) -> bool {
        false
    }

    /// Elastic stiffness at rest, at the given strains or at zero strain.
    fn rest_responses_into(&self, strain: &[Components<S>], responses: &mut [Response<S>]) {
        let none = vec![[Lanes::ZERO; S]; strain.len()];
        let history = vec![Lanes::ZERO; self.variables() * strain.len()];
        self.responses_into(&StrainStep::at_rest(&none, &none, &history), responses);
    }

    /// Writes the history variables at the end of a step to `after`, and the heat of the step at each point.
    fn advance_into(&self, step: &StrainStep<S>, after: &mut [Lanes<false>], heat: &mut [Heat]);

    /// Relaxes the rate-dependent history variables at constant strains.
    fn relax(&self, _strain: &[Components<S>], _history: &mut [Lanes<false>]) {}

    /// Stored energies at strains and history variables `[energy/volume]`, without those of relaxing (Maxwell) branches.
    fn energies_into(&self, strain: &[Components<S>], history: &[Lanes<false>], energies: &mut [Lanes<false>]);

    /// Adds the stored energies of relaxing (Maxwell) branches `[energy/volume]`.
    fn add_relaxing_energies(&self, _history: &[Lanes<false>], _energies: &mut [Lanes<false>]) {}

    /// Second Piola-Kirchhoff stresses at strains and history variables `[stress]`.
    fn stresses_into(&self, strain: &[Components<S>], history: &[Lanes<false>], stresses: &mut [Components<S>]);

    /// Strain across the plane at a point, if it is a history variable; otherwise `None`.
    fn across(&self, _history: &[Lanes<false>]) -> Option<Lanes<false>> {
        None
    }

    /// Plastic history values of one point for fields; `None` for laws without plastic flow.
    fn shown(&self, _history: &[Lanes<false>], _lane: usize) -> Option<PointHistory> {
        None
    }
}

/// Heat of a step at a point of eight elements `[energy/volume]`.
#[derive(Clone, Copy, Debug)]
pub struct Heat {
    /// Heat of plastic flow.
    pub plastic: Lanes<false>,
    /// Heat of viscosity.
    pub viscous: Lanes<false>,
}

impl Heat {
    /// No heat.
    pub const ZERO: Self = Heat { plastic: Lanes::ZERO, viscous: Lanes::ZERO };
}

/// Values of the history of a point for fields.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointHistory {
    /// Equivalent plastic strain, the integral of `sqrt(2/3) |d eps_p|`.
    pub plastic_strain: f64,
    /// Heat so far `[energy/volume]`.
    pub heat: f64,
    /// Von Mises' norm `sqrt(3/2) |X|` of the back stress `[stress]`.
    pub back_stress: f64,
}

/// A law with history variables in the forms that bodies need: plane and space, with and without the energy of the volume.
#[derive(Clone)]
pub struct HistoryLaws {
    plane: [Arc<dyn HistoryLaw<4>>; 2],
    space: [Arc<dyn HistoryLaw<6>>; 2],
}

impl HistoryLaws {
    /// Laws with history variables: the whole law, then the law without volumetric energy.
    pub(super) fn new<H: HistoryLaw<4> + HistoryLaw<6> + 'static>(laws: [H; 2]) -> Self {
        let [whole, rest] = laws.map(Arc::new);
        HistoryLaws { plane: [whole.clone(), rest.clone()], space: [whole, rest] }
    }

    /// Law with a stretched, unsheared third direction; without volumetric energy if `has_volume` is false.
    pub fn plane(&self, has_volume: bool) -> Arc<dyn HistoryLaw<4>> {
        self.plane[usize::from(!has_volume)].clone()
    }

    /// Law in space; without volumetric energy if `has_volume` is false.
    pub fn space(&self, has_volume: bool) -> Arc<dyn HistoryLaw<6>> {
        self.space[usize::from(!has_volume)].clone()
    }
}
