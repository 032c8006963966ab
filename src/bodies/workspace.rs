//! Force and tangent of eight cells, from their displacement gradients and the responses of the law.

use super::batch::{
    Batch, Counts, MOST_POINTS, Point, Strain, Table, cast, deformation_gradient, determinant_and_cofactor, discrete_stress, mean,
};
use super::special::{Answer, SpecialPoints};
use super::sums::{add_force, add_point, finish_force};
use crate::integrators::{Configuration, Derivative, Placement};
use crate::materials::{BatchedLaw, Components, IncrementResponse, Response};
use crate::math::lanes::{Lanes, Real, WIDTH, relabel, relabel_rows};
use crate::math::tensor::mandel_place;

/// Work data of a batch: strains and responses of the law at its points, force and tangent.
pub(super) struct Workspace<const FMA: bool, const D: usize, const S: usize, const A: usize, const Q: usize> {
    strain: Strain,
    pub(super) counts: Counts<A, Q>,
    pub(super) points: [Point<FMA, D, A>; Q],
    /// Displacement gradients at the start and at the end of the step.
    pub(super) gradient_0: [[[Lanes<FMA>; D]; D]; Q],
    pub(super) gradient_1: [[[Lanes<FMA>; D]; D]; Q],
    pub(super) strain_0: [Components<S>; Q],
    pub(super) strain_1: [Components<S>; Q],
    increments: [IncrementResponse<S>; Q],
    pub(super) responses: [Response<S>; Q],
    /// True if `responses` are the algorithmic stresses of the step; false if these must still be computed from the responses of the law.
    pub(super) is_final: bool,
    /// Forces on the nodes.
    pub(super) force: [[Lanes<FMA>; D]; A],
    /// Tangent, column by column of the nodes: `tangent[b][k][a][i]` is the derivative of `force[a][i]` with respect to `u[b][k]`.
    pub(super) tangent: [[[[Lanes<FMA>; D]; A]; D]; A],
}

impl<const FMA: bool, const D: usize, const S: usize, const A: usize, const Q: usize> Workspace<FMA, D, S, A, Q> {
    #[inline(always)]
    pub(super) fn new(strain: Strain, counts: Counts<A, Q>) -> Self {
        Workspace {
            strain,
            counts,
            points: [Point::ZERO; Q],
            gradient_0: [[[Lanes::ZERO; D]; D]; Q],
            gradient_1: [[[Lanes::ZERO; D]; D]; Q],
            strain_0: [[Lanes::ZERO; S]; Q],
            strain_1: [[Lanes::ZERO; S]; Q],
            increments: [IncrementResponse::ZERO; Q],
            responses: [Response::ZERO; Q],
            is_final: false,
            force: [[Lanes::ZERO; D]; A],
            tangent: [[[[Lanes::ZERO; D]; A]; D]; A],
        }
    }

    /// Returns the point data of the batch for a special stress. `around`: displacements at start and end, for hoop displacement gradients.
    #[inline(always)]
    pub(super) fn special_points(&self, batch: &Batch<D>, table: &Table<D, A, Q>, around: [Option<&[f64]>; 2]) -> SpecialPoints<D> {
        let count = self.counts.nodes();
        let mut points = SpecialPoints::new(self.counts.points());
        for q in 0..points.count {
            points.volume[q] = Lanes(self.points[q].volume.0);
            points.places[q] = table.place(batch, q);
            points.gradients[0][q] = relabel_rows(&self.gradient_0[q]);
            points.gradients[1][q] = relabel_rows(&self.gradient_1[q]);
        }
        for (time, all) in around.into_iter().enumerate() {
            let Some(all) = all else { continue };
            let u = batch.displacements::<FMA, A>(count, all);
            for q in 0..points.count {
                points.hoop[time][q] = Lanes(self.points[q].hoop(count, &u, &table.shapes[q]).0);
            }
        }
        points
    }

    /// Replaces the responses by the algorithmic stresses of a special stress.
    #[inline(always)]
    pub(super) fn take<const L: usize>(&mut self, answer: &Answer<L>) {
        self.is_final = true;
        for q in 0..self.counts.points() {
            self.responses[q] = in_components(&answer.responses[q]);
        }
    }

    /// Sets displacement gradients and strains at the end of the step.
    #[inline(always)]
    pub(super) fn set_end(&mut self, batch: &Batch<D>, u_1: &[f64]) {
        let count = self.counts.nodes();
        let u = batch.displacements(count, u_1);
        for q in 0..self.counts.points() {
            self.gradient_1[q] = self.points[q].displacement_gradient(count, &u);
            self.strain_1[q] = self.strain.of(&self.gradient_1[q], Lanes::ZERO);
        }
    }

    /// Sets displacement gradients and strains at the start of the step.
    #[inline(always)]
    pub(super) fn set_start(&mut self, batch: &Batch<D>, u_0: &[f64]) {
        let count = self.counts.nodes();
        let u = batch.displacements(count, u_0);
        for q in 0..self.counts.points() {
            self.gradient_0[q] = self.points[q].displacement_gradient(count, &u);
            self.strain_0[q] = self.strain.of(&self.gradient_0[q], Lanes::ZERO);
        }
    }

    /// True if at least one cell is inverted at the end of the step.
    #[inline(always)]
    pub(super) fn is_inside_out(&self) -> bool {
        let mut sound = true;
        for h in &self.gradient_1[..self.counts.points()] {
            let determinant = determinant_and_cofactor(&deformation_gradient(h)).0;
            for lane in 0..WIDTH {
                sound &= determinant.0[lane] > 0.0;
            }
        }
        !sound
    }

    /// Evaluates stresses and derivatives for the step's algorithmic gradient, between [`Self::set_end`] and [`Self::integrate`].
    #[inline(always)]
    pub(super) fn respond(&mut self, law: &dyn BatchedLaw<S>, derivative: Derivative) {
        let count = self.counts.points();
        let (end, responses) = (&self.strain_1[..count], &mut self.responses[..count]);
        match derivative {
            Derivative::DiscreteGradient => law.increments_into(&self.strain_0[..count], end, &mut self.increments[..count]),
            Derivative::Gradient(Configuration::Middle) => {
                let mut strain = [[Lanes::ZERO; S]; Q];
                for q in 0..self.counts.points() {
                    strain[q] = self.strain.of(&mean(&self.gradient_0[q], &self.gradient_1[q]), Lanes::ZERO);
                }
                law.responses_into(&strain[..count], responses);
            }
            Derivative::Gradient(Configuration::End) => law.responses_into(end, responses),
        }
    }

    /// Algorithmic stress at a point and its derivative with respect to the strain at the end.
    #[inline(always)]
    fn stress_and_tangent(&self, q: usize, derivative: Derivative) -> ([Lanes<FMA>; S], [[Lanes<FMA>; S]; S]) {
        if !self.is_final && derivative == Derivative::DiscreteGradient {
            return discrete_stress([&self.strain_0[q], &self.strain_1[q]], &self.increments[q]);
        }
        let (stress, mut tangent) = (relabel(&self.responses[q].stress), relabel_rows(&self.responses[q].tangent));
        if !self.is_final && derivative == Derivative::Gradient(Configuration::Middle) {
            for component in tangent.iter_mut().flatten() {
                *component = *component * 0.5;
            }
        }
        (stress, tangent)
    }

    /// Deformation gradient at a point.
    #[inline(always)]
    pub(super) fn deformation_gradient(&self, q: usize, configuration: Configuration) -> [[Lanes<FMA>; D]; D] {
        match configuration {
            Configuration::Middle => self.strain.frame(&mean(&self.gradient_0[q], &self.gradient_1[q])),
            Configuration::End => self.strain.frame(&self.gradient_1[q]),
        }
    }

    /// Hoop stretch for the push-forward of forces; 1 for linear strains.
    #[inline(always)]
    pub(super) fn frame_around(&self, hoop: Lanes<false>) -> Lanes<FMA> {
        if self.strain == Strain::Linear { Lanes::splat(1.0) } else { cast::<FMA>(hoop) + 1.0 }
    }

    /// Derivative of the configuration in which the forces act with respect to the end; 0 for linear strains, whose forces act in the
    /// reference configuration.
    #[inline(always)]
    pub(super) fn geometric_share(&self, share: f64) -> f64 {
        if self.strain == Strain::Linear { 0.0 } else { share }
    }

    /// Sums the weighted force over the points; bitwise equal to the force of [`Self::integrate`].
    #[inline(always)]
    pub(super) fn integrate_force(&mut self, derivative: Derivative, weight: f64) {
        let Placement { test, .. } = derivative.placement();
        let count = self.counts.nodes();
        self.force[..count].fill([Lanes::ZERO; D]);
        for q in 0..self.counts.points() {
            let (stress, _) = self.stress_and_tangent(q, derivative);
            let test = self.deformation_gradient(q, test);
            add_force(count, &self.points[q].gradients, &test, &stress, self.points[q].volume * weight, &mut self.force);
        }
        finish_force(count, &mut self.force);
    }

    /// Sums weighted force and tangent over the points. `geometric` is the factor of the geometric stiffness; `rates`, the derivatives with
    /// respect to the strain increment, are multiplied by strain variations at the end of the step.
    #[inline(always)]
    pub(super) fn integrate<const L: usize>(
        &mut self,
        derivative: Derivative,
        weight: f64,
        geometric: f64,
        rates: Option<&[Response<L>; MOST_POINTS]>,
    ) {
        let Placement { test, trial, share } = derivative.placement();
        let share = geometric * self.geometric_share(share);
        let count = self.counts.nodes();
        self.clear();
        for q in 0..self.counts.points() {
            let test = self.deformation_gradient(q, test);
            for pass in 0..=usize::from(rates.is_some()) {
                let (trial, share, (stress, tangent)) = match rates.filter(|_| pass == 1) {
                    Some(rates) => {
                        let Response { stress, tangent } = in_components::<L, S>(&rates[q]);
                        (Configuration::End, 0.0, (relabel(&stress), relabel_rows(&tangent)))
                    }
                    None => (trial, share, self.stress_and_tangent(q, derivative)),
                };
                let trial = self.deformation_gradient(q, trial);
                let Point { gradients, volume, .. } = &self.points[q];
                add_point(count, gradients, &test, &trial, &stress, &tangent, *volume * weight, share, &mut self.force, &mut self.tangent);
            }
        }
        self.finish();
    }

    /// Zeroes force and tangent.
    #[inline(always)]
    fn clear(&mut self) {
        let count = self.counts.nodes();
        self.force[..count].fill([Lanes::ZERO; D]);
        self.tangent[..count].iter_mut().flatten().for_each(|column| column[..count].fill([Lanes::ZERO; D]));
    }

    /// Sets force and tangent of the last node to the negative sums of the others.
    #[inline(always)]
    fn finish(&mut self) {
        let count = self.counts.nodes();
        finish_force(count, &mut self.force);
        for k in 0..D {
            for i in 0..D {
                for b in 0..count - 1 {
                    let mut last = Lanes::ZERO;
                    for a in 0..count - 1 {
                        last = last - self.tangent[b][k][a][i];
                    }
                    self.tangent[b][k][count - 1][i] = last;
                }
                for a in 0..count {
                    let mut last = Lanes::ZERO;
                    for b in 0..count - 1 {
                        last = last - self.tangent[b][k][a][i];
                    }
                    self.tangent[count - 1][k][a][i] = last;
                }
            }
        }
    }

    /// Adds `factor` times the consistent mass to the tangent.
    #[inline(always)]
    pub(super) fn add_mass(&mut self, batch: &Batch<D>, table: &Table<D, A, Q>, factor: f64) {
        for a in 0..self.counts.nodes() {
            for b in 0..=a {
                let mut mass = Lanes::<FMA>::ZERO;
                if let Some(product) = batch.kept_mass(a, b) {
                    mass = cast::<FMA>(product) * factor;
                } else {
                    for q in 0..self.counts.points() {
                        mass = self.points[q].weighed.mul_add(Lanes::splat(factor * table.products[q][a][b]), mass);
                    }
                }
                for i in 0..D {
                    self.tangent[b][i][a][i] = self.tangent[b][i][a][i] + mass;
                    if a != b {
                        self.tangent[a][i][b][i] = self.tangent[a][i][b][i] + mass;
                    }
                }
            }
        }
    }
}

/// Restriction of a response in `L` components to the `S` components of the cells.
#[inline(always)]
fn in_components<const L: usize, const S: usize>(response: &Response<L>) -> Response<S> {
    let mut own = Response::ZERO;
    for k in 0..S {
        own.stress[k] = response.stress[mandel_place::<S>(k)];
        for l in 0..S {
            own.tangent[k][l] = response.tangent[mandel_place::<S>(k)][mandel_place::<S>(l)];
        }
    }
    own
}
