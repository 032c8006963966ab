//! Special stresses of a batch, which require more than the strain of a point in the components of the cell: hoop strain of bodies of
//! revolution, dilatation of cells, history variables.
//!
//! Separate from the common element loop, because most bodies do not need them. Contributions beyond the cell's own components are added
//! during the summation:
//!
//! ```text
//! around the axis   f_a,1 = w F_33 S_33 N_a / R                     (Hughes, The Finite Element Method, 2000, section 2.12)
//! dilatation        K_ab += sum_ij p'_ij (sum_g w phi_i DG[J] : B_a) (sum_g w phi_j dJ/dE : B_b), of a mean with phi_0 = 1, p'_00 = p'/V
//! ```

use std::sync::Arc;

use super::batch::{MOST_POINTS, Strain, cast, discrete_stress, mean, volume_change};
use super::dilatation::{MOST_MODES, Modes, Pressure, VolumeRatio};
use crate::integrators::{Configuration, Derivative};
use crate::materials::{BatchedLaw, Components, HistoryLaw, IncrementResponse, Response, StrainStep, StressOf, VolumetricLaw};
use crate::math::lanes::{Lanes, Real, relabel, relabel_rows};
use crate::math::simd::{Kernel, dispatch};

/// Special stress: law of `L` components (four in the plane, including the one across), and the volumetric energy of a cell dilatation.
pub(super) struct Special<const L: usize> {
    /// Law at the points; without its volumetric part in cells with a cell dilatation.
    pub(super) law: PointLaw<L>,
    /// Volumetric part of the law for a cell dilatation; `None` without cell dilatation.
    pub(super) volumetric: Option<Arc<dyn VolumetricLaw>>,
    /// True if the dilatation is linear in the cell; false for a mean.
    pub(super) is_linear: bool,
    /// Strain measure of the law.
    pub(super) strain: Strain,
    /// True for a body of revolution, which has a hoop strain.
    pub(super) is_axisymmetric: bool,
}

/// The law of a point.
pub(super) enum PointLaw<const L: usize> {
    /// Stress as a function of the strain only.
    Elastic(Arc<dyn BatchedLaw<L>>),
    /// Stress that also depends on history variables or the strain rate.
    History(Arc<dyn HistoryLaw<L>>),
}

impl<const L: usize> PointLaw<L> {
    /// The law with history variables.
    pub(super) fn history(&self) -> Option<&dyn HistoryLaw<L>> {
        if let PointLaw::History(law) = self { Some(&**law) } else { None }
    }

    /// Number of history variables of a point.
    pub(super) fn variables(&self) -> usize {
        self.history().map_or(0, HistoryLaw::variables)
    }
}

/// Data of a step for a batch: algorithmic gradient, history variables at the start, step size.
#[derive(Clone, Copy)]
pub(super) struct BatchStep<'a> {
    pub(super) derivative: Derivative,
    /// History variables of the batch at the start of the step.
    pub(super) history: &'a [Lanes<false>],
    pub(super) dt: f64,
}

/// Kind of stress of a law with history variables that corresponds to an algorithmic gradient.
pub(super) fn stress_of(derivative: Derivative) -> StressOf {
    match derivative {
        Derivative::DiscreteGradient => StressOf::Step,
        Derivative::Gradient(Configuration::Middle) => StressOf::Middle,
        Derivative::Gradient(Configuration::End) => StressOf::End,
    }
}

/// Data of a batch at its points: volumes, undeformed positions, displacement gradients at start and end.
pub(super) struct SpecialPoints<const D: usize> {
    pub(super) count: usize,
    pub(super) volume: [Lanes<false>; MOST_POINTS],
    /// Undeformed positions of the points relative to the last node of each cell.
    pub(super) places: [[Lanes<false>; D]; MOST_POINTS],
    pub(super) gradients: [[[[Lanes<false>; D]; D]; MOST_POINTS]; 2],
    /// Hoop displacement gradients at the start and at the end of the step.
    pub(super) hoop: [[Lanes<false>; MOST_POINTS]; 2],
}

impl<const D: usize> SpecialPoints<D> {
    /// Data of `count` points, all zero.
    pub(super) fn new(count: usize) -> Self {
        SpecialPoints {
            count,
            volume: [Lanes::ZERO; MOST_POINTS],
            places: [[Lanes::ZERO; D]; MOST_POINTS],
            gradients: [[[[Lanes::ZERO; D]; D]; MOST_POINTS]; 2],
            hoop: [[Lanes::ZERO; MOST_POINTS]; 2],
        }
    }
}

/// Stresses of a step with their derivatives by the strains at the end, and data of a dilatation common to a cell.
pub(super) struct Answer<const L: usize> {
    pub(super) responses: [Response<L>; MOST_POINTS],
    /// Derivatives with respect to the strain increment, for a mid-step stress that also depends on the increment.
    pub(super) rates: Option<Box<[Response<L>; MOST_POINTS]>>,
    /// For each point: `DG[J]`, and `dJ/dE` at the trial configuration.
    pub(super) ratios: [[Components<L>; 2]; MOST_POINTS],
    /// Modes of the cell dilatation and derivatives of its pressures ([`Modes::slopes`]); `None` without cell dilatation.
    pub(super) dilatation: Option<(Modes, [[Lanes<false>; MOST_MODES]; MOST_MODES])>,
}

impl<const L: usize> Answer<L> {
    pub(super) const EMPTY: Self =
        Answer { responses: [Response::ZERO; MOST_POINTS], rates: None, ratios: [[[Lanes::ZERO; L]; 2]; MOST_POINTS], dilatation: None };
}

impl<const L: usize> Special<L> {
    /// Writes the stresses of a step to `answer`.
    pub(super) fn respond<const D: usize>(&self, points: &SpecialPoints<D>, course: BatchStep, answer: &mut Answer<L>) {
        dispatch(Respond { special: self, points, course, answer });
    }

    /// Strains at the end of a step.
    pub(super) fn strains<const D: usize>(&self, points: &SpecialPoints<D>) -> [Components<L>; MOST_POINTS] {
        let mut strains = [[Lanes::ZERO; L]; MOST_POINTS];
        for q in 0..points.count {
            strains[q] = self.strain.of(&points.gradients[1][q], points.hoop[1][q]);
        }
        strains
    }

    /// Strains of the mean of two displacement gradients: those at the ends of `from` and `to`.
    pub(super) fn middles<const D: usize>(&self, from: &SpecialPoints<D>, to: &SpecialPoints<D>) -> [Components<L>; MOST_POINTS] {
        let mut strains = [[Lanes::ZERO; L]; MOST_POINTS];
        for q in 0..to.count {
            strains[q] = self.strain.of(&mean(&from.gradients[1][q], &to.gradients[1][q]), (from.hoop[1][q] + to.hoop[1][q]) * 0.5);
        }
        strains
    }

    /// Strain increments between the ends of `from` and `to`, without cancellation.
    pub(super) fn changes<const D: usize>(&self, from: &SpecialPoints<D>, to: &SpecialPoints<D>) -> [Components<L>; MOST_POINTS] {
        let mut changes = [[Lanes::ZERO; L]; MOST_POINTS];
        for q in 0..to.count {
            changes[q] = self.strain.change([&from.gradients[1][q], &to.gradients[1][q]], [from.hoop[1][q], to.hoop[1][q]]);
        }
        changes
    }

    /// Stored energy of each cell at the end of a step, with the history variables `history` there.
    pub(super) fn energy<const D: usize>(&self, points: &SpecialPoints<D>, history: &[Lanes<false>]) -> Lanes<false> {
        let (energies, mut sum) = (self.densities(points, history), Lanes::ZERO);
        for q in 0..points.count {
            sum = sum + points.volume[q] * energies[q];
        }
        sum
    }

    /// Energy per undeformed volume at each point at the end of a step, with the history variables of the batch there.
    pub(super) fn densities<const D: usize>(&self, points: &SpecialPoints<D>, history: &[Lanes<false>]) -> [Lanes<false>; MOST_POINTS] {
        let count = points.count;
        let (strains, mut energies) = (self.strains(points), [Lanes::ZERO; MOST_POINTS]);
        match &self.law {
            PointLaw::Elastic(law) => law.energies_into(&strains[..count], &mut energies[..count]),
            PointLaw::History(law) => law.energies_into(&strains[..count], history, &mut energies[..count]),
        }
        let mut volumetric = [Lanes::ZERO; MOST_POINTS];
        if let Some(law) = &self.volumetric {
            let changes = self.modes(points).projected(points.volumes(), |q| points.change(q));
            law.energies_into(&changes[..count], &mut volumetric[..count]);
        }
        for q in 0..count {
            energies[q] = energies[q] + volumetric[q];
        }
        energies
    }

    /// Pressures of the cell dilatation at the points at the end of a step; zero without cell dilatation.
    pub(super) fn pressures<const D: usize>(&self, points: &SpecialPoints<D>) -> [Lanes<false>; MOST_POINTS] {
        let Some(law) = &self.volumetric else { return [Lanes::ZERO; MOST_POINTS] };
        let modes = self.modes(points);
        let changes = modes.projected(points.volumes(), |q| points.change(q));
        modes.projected(points.volumes(), |q| Pressure::at(&**law, changes[q]).value)
    }

    fn modes<const D: usize>(&self, points: &SpecialPoints<D>) -> Modes {
        Modes::new(points.volumes(), self.is_linear.then(|| &points.places[..points.count]))
    }
}

impl<const D: usize> SpecialPoints<D> {
    fn volumes(&self) -> &[Lanes<false>] {
        &self.volume[..self.count]
    }

    /// Volume ratio minus 1 of a point at the end of the step.
    fn change(&self, q: usize) -> Lanes<false> {
        change(&self.gradients[1][q], self.hoop[1][q])
    }
}

/// Volume ratio minus 1; `hoop` is zero in plane strain and in space.
#[inline(always)]
fn change<const FMA: bool, const D: usize>(h: &[[Lanes<FMA>; D]; D], hoop: Lanes<FMA>) -> Lanes<FMA> {
    let inner = volume_change(h);
    hoop.mul_add(inner, inner + hoop)
}

struct Respond<'a, const D: usize, const L: usize> {
    special: &'a Special<L>,
    points: &'a SpecialPoints<D>,
    course: BatchStep<'a>,
    answer: &'a mut Answer<L>,
}

impl<const D: usize, const L: usize> Kernel for Respond<'_, D, L> {
    type Output = ();

    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Respond { special, points, course, answer } = self;
        let (count, derivative) = (points.count, course.derivative);
        // Strains at start, end and middle of the step.
        let mut strains = [[[Lanes::ZERO; L]; MOST_POINTS]; 3];
        let mut changes = [[Lanes::ZERO; MOST_POINTS]; 3];
        for q in 0..count {
            let middle = (mean(&points.gradients[0][q], &points.gradients[1][q]), (points.hoop[0][q] + points.hoop[1][q]) * 0.5);
            let all = [(points.gradients[0][q], points.hoop[0][q]), (points.gradients[1][q], points.hoop[1][q]), middle];
            for (k, (h, hoop)) in all.iter().enumerate() {
                strains[k][q] = special.strain.of(h, *hoop);
                changes[k][q] = change(h, *hoop);
            }
        }
        let all = strains.each_ref().map(|strains| &strains[..count]);
        let responses = &mut answer.responses[..count];
        match &special.law {
            PointLaw::Elastic(law) => law_responses::<FMA, L>(&**law, all, stress_of(derivative), responses),
            PointLaw::History(law) if course.history.is_empty() && law.variables() > 0 => law.rest_responses_into(all[1], responses),
            PointLaw::History(law) => {
                let mut changes = [[Lanes::ZERO; L]; MOST_POINTS];
                for q in 0..count {
                    let [start, end] = &points.gradients;
                    changes[q] = special.strain.change([&start[q], &end[q]], [points.hoop[0][q], points.hoop[1][q]]);
                }
                let ([start, end, middle], change) = (all, &changes[..count]);
                let BatchStep { history, dt, .. } = course;
                let step = StrainStep { start, end, middle, change, history, dt, stress: stress_of(derivative) };
                law.responses_into(&step, responses);
                answer.rates = None;
                if step.stress == StressOf::Middle {
                    let mut rates = Box::new([Response::ZERO; MOST_POINTS]);
                    answer.rates = law.rate_responses_into(&step, &mut rates[..count]).then_some(rates);
                }
            }
        }
        answer.dilatation = None;
        let Some(law) = &special.volumetric else { return };
        let (volumes, modes) = (points.volumes(), special.modes(points));
        let theta = |k: usize| modes.projected(volumes, |q| changes[k][q]);
        let (theta, mut of_points) = ([theta(0), theta(1), theta(2)], [Pressure::ZERO; MOST_POINTS]);
        // With a mean dilatation the pressure is equal at all points and computed once.
        for q in 0..if special.is_linear { count } else { 1 } {
            of_points[q] = match derivative {
                Derivative::DiscreteGradient => Pressure::between(&**law, theta[0][q], theta[1][q]),
                Derivative::Gradient(Configuration::Middle) => Pressure::at(&**law, theta[2][q]),
                Derivative::Gradient(Configuration::End) => Pressure::at(&**law, theta[1][q]),
            };
        }
        if !special.is_linear {
            of_points = [of_points[0]; MOST_POINTS];
        }
        let pressures = modes.projected(volumes, |q| of_points[q].value);
        let slopes = modes.slopes(volumes, &of_points.map(|pressure| pressure.slope));
        answer.dilatation = Some((modes, slopes));
        for q in 0..count {
            let p = cast::<FMA>(pressures[q]);
            let change = |k: usize| cast::<FMA>(changes[k][q]);
            let ratio = VolumeRatio::new(derivative, [&strains[0][q], &strains[1][q]], [change(0), change(1)], (&strains[2][q], change(2)));
            let Response { stress, tangent } = &mut answer.responses[q];
            for k in 0..L {
                stress[k] = Lanes(p.mul_add(ratio.gradient[k], cast(stress[k])).0);
                for l in 0..L {
                    tangent[k][l] = Lanes(p.mul_add(ratio.hessian[k][l], cast(tangent[k][l])).0);
                }
            }
            answer.ratios[q] = [relabel(&ratio.gradient), relabel(&ratio.trial)];
        }
    }
}

/// Stresses and derivatives of the law, without the cell dilatation, for strains at start, end and middle; at most [`MOST_POINTS`].
#[inline(always)]
pub(super) fn law_responses<const FMA: bool, const L: usize>(
    law: &dyn BatchedLaw<L>,
    [start, end, middle]: [&[Components<L>]; 3],
    stress: StressOf,
    responses: &mut [Response<L>],
) {
    match stress {
        StressOf::Step => {
            let mut increments = [IncrementResponse::ZERO; MOST_POINTS];
            law.increments_into(start, end, &mut increments[..start.len()]);
            for q in 0..start.len() {
                let (stress, tangent) = discrete_stress::<FMA, L>([&start[q], &end[q]], &increments[q]);
                responses[q] = Response { stress: relabel(&stress), tangent: relabel_rows(&tangent) };
            }
        }
        StressOf::Middle => {
            law.responses_into(middle, responses);
            for component in responses.iter_mut().flat_map(|response| response.tangent.iter_mut().flatten()) {
                *component = *component * 0.5;
            }
        }
        StressOf::End => law.responses_into(end, responses),
    }
}
