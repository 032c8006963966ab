//! Elastic-plastic law: work, tangents, and large shears.

use std::sync::Arc;

use conserva::materials::{
    BackStress, Components, ElasticPlastic, Hardening, Heat, HistoryLaw, HistoryLaws, Material, RateDependence, Response, StrainStep,
    StressOf,
};
use conserva::math::lanes::{Lanes, WIDTH};
use conserva::math::tensor::{mandel_index, mandel_scale};

fn steel() -> ElasticPlastic {
    ElasticPlastic {
        youngs_modulus: 200.0,
        poisson_ratio: 0.3,
        density: 1.0,
        yield_stress: 0.5,
        hardening: Hardening::NONE,
        back_stresses: Vec::new(),
        rate: RateDependence::None,
    }
}

/// Every kind of hardening and rate.
fn laws() -> Vec<ElasticPlastic> {
    let back = |modulus, recovery| BackStress { modulus, recovery };
    let voce = Hardening::Saturating { modulus: 2.0, saturation: 0.3, exponent: 12.0 };
    let table = Hardening::Table(vec![[0.0, 0.5], [0.01, 0.56], [0.1, 0.7]]);
    let cook = RateDependence::JohnsonCook { factor: 0.05, reference_rate: 0.01 };
    vec![
        steel(),
        ElasticPlastic { hardening: voce.clone(), ..steel() },
        ElasticPlastic { hardening: Hardening::Swift { strain: 0.01, exponent: 0.2 }, ..steel() },
        ElasticPlastic { hardening: Hardening::Ludwik { modulus: 0.4, exponent: 0.3 }, ..steel() },
        ElasticPlastic { hardening: table.clone(), ..steel() },
        ElasticPlastic { back_stresses: vec![back(5.0, 0.0)], ..steel() },
        ElasticPlastic { back_stresses: vec![back(20.0, 40.0), back(2.0, 3.0)], hardening: voce, ..steel() },
        ElasticPlastic { rate: RateDependence::Perzyna { viscosity: 0.7 }, back_stresses: vec![back(5.0, 9.0)], ..steel() },
        ElasticPlastic { rate: cook, hardening: table, ..steel() },
    ]
}

struct Random(u64);

impl Random {
    fn next(&mut self, size: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        size * ((self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0)
    }

    fn strain<const S: usize>(&mut self, around: &Components<S>, size: f64) -> Components<S> {
        around.map(|component| Lanes(component.0.map(|x| x + self.next(size))))
    }
}

const ZERO: Lanes<false> = Lanes::ZERO;

fn step<'a, const S: usize>(
    ends: [&'a [Components<S>; 1]; 2],
    middle: &'a [Components<S>; 1],
    history: &'a [Lanes<false>],
    stress: StressOf,
) -> StrainStep<'a, S> {
    StrainStep { start: ends[0], end: ends[1], middle, change: middle, history, dt: 0.3, stress }
}

fn dotted<const S: usize>(a: &Components<S>, b: &Components<S>, lane: usize) -> f64 {
    (0..S).map(|k| a[k].0[lane] * b[k].0[lane]).sum()
}

/// The law of an elastic-plastic material in the strain components that `choose` takes.
fn law_of<const S: usize>(constants: &ElasticPlastic, choose: &impl Fn(&HistoryLaws) -> Arc<dyn HistoryLaw<S>>) -> Arc<dyn HistoryLaw<S>> {
    let material = Material::elastic_plastic(constants).expect("the constants are in their ranges");
    choose(material.history().expect("it has history variables"))
}

fn work_is_stored_or_heat<const S: usize>(law: impl Fn(&HistoryLaws) -> Arc<dyn HistoryLaw<S>>) {
    for constants in laws() {
        for size in [1e-6, 1e-3, 0.02, 0.15] {
            let law = law_of(&constants, &law);
            let mut random = Random(7);
            let (mut strain, mut history) = ([[ZERO; S]], vec![ZERO; law.variables()]);
            let (mut yielded, mut after, mut heat) = (false, history.clone(), [Heat::ZERO]);
            for _ in 0..12 {
                let next = [random.strain(&[ZERO; S], size)];
                let at = step([&strain, &next], &next, &history, StressOf::Step);
                let mut response = [Response::ZERO];
                law.responses_into(&at, &mut response);
                law.advance_into(&at, &mut after, &mut heat);
                let [mut before, mut stored] = [[ZERO]; 2];
                law.energies_into(&strain, &history, &mut before);
                law.energies_into(&next, &after, &mut stored);
                for lane in 0..WIDTH {
                    let mut change = next[0];
                    (0..S).for_each(|k| change[k].0[lane] -= strain[0][k].0[lane]);
                    let work = dotted(&response[0].stress, &change, lane);
                    let defect = work - (stored[0].0[lane] - before[0].0[lane]) - heat[0].plastic.0[lane];
                    // Round-off relative to strains whose elastic stress would be of the order of the modulus.
                    let scale = stored[0].0[lane] + before[0].0[lane] + heat[0].plastic.0[lane] + 1e-3;
                    assert!(defect.abs() < 1e-13 * scale.max(1.0), "{constants:?} {size}: {defect:e} of {scale:e}");
                    // With rate dependence, a step of many yield strains that unloads from above the static yield stress may return a small
                    // part of its plastic work.
                    let least = if constants.rate == RateDependence::None { -1e-14 } else { -size * constants.yield_stress };
                    assert!(heat[0].plastic.0[lane] >= least, "{constants:?} {size}: heat {:e}", heat[0].plastic.0[lane]);
                    yielded |= heat[0].plastic.0[lane] > 0.0;
                }
                strain = next;
                std::mem::swap(&mut history, &mut after);
            }
            assert!(yielded || size < 0.01);
        }
    }
}

#[test]
fn the_work_of_a_step_is_stored_or_heat() {
    work_is_stored_or_heat::<4>(|laws| laws.plane(true));
    work_is_stored_or_heat::<6>(|laws| laws.space(true));
}

fn tangents_are_derivatives<const S: usize>(law: impl Fn(&HistoryLaws) -> Arc<dyn HistoryLaw<S>>) {
    for constants in laws() {
        for (stress, size) in [(StressOf::Step, 2e-3), (StressOf::Step, 0.02), (StressOf::Middle, 0.004), (StressOf::End, 0.01)] {
            let law = law_of(&constants, &law);
            let mut random = Random(3);
            let (mut strain, mut history) = ([[ZERO; S]], vec![ZERO; law.variables()]);
            let (mut after, mut heat, mut wrong) = (history.clone(), [Heat::ZERO], Vec::new());
            for _ in 0..8 {
                let next = [random.strain(&strain[0], size)];
                let mut response = [Response::ZERO];
                law.responses_into(&step([&strain, &next], &next, &history, stress), &mut response);
                let (direction, h) = (random.strain(&[ZERO; S], 1.0), 1e-7);
                let moved = |sign: f64| {
                    let mut moved = next;
                    (0..S).for_each(|k| (0..WIDTH).for_each(|lane| moved[0][k].0[lane] += sign * h * direction[k].0[lane]));
                    let mut response = [Response::ZERO];
                    law.responses_into(&step([&strain, &moved], &moved, &history, stress), &mut response);
                    response[0].stress
                };
                let (up, down) = (moved(1.0), moved(-1.0));
                // The tangent of [`StressOf::Middle`] is half the derivative with respect to the strain at mid-step.
                let share = if stress == StressOf::Middle { 0.5 } else { 1.0 };
                for lane in 0..WIDTH {
                    let (mut off, mut scale) = (0.0f64, 0.0f64);
                    for k in 0..S {
                        let difference = share * (up[k].0[lane] - down[k].0[lane]) / (2.0 * h);
                        let tangent: f64 = (0..S).map(|l| response[0].tangent[k][l].0[lane] * direction[l].0[lane]).sum();
                        off = off.max((difference - tangent).abs());
                        scale = scale.max(difference.abs());
                    }
                    wrong.push(off / scale);
                }
                law.advance_into(&step([&strain, &next], &next, &history, stress), &mut after, &mut heat);
                strain = next;
                std::mem::swap(&mut history, &mut after);
            }
            // Difference quotients across the yield surface are no derivatives: the largest tenth of the deviations is ignored.
            wrong.sort_by(f64::total_cmp);
            let most = wrong[wrong.len() * 9 / 10];
            assert!(most < 2e-6, "{constants:?} {stress:?} {size}: {most:e}");
        }
    }
}

#[test]
fn tangents_are_the_derivatives_of_stresses() {
    tangents_are_derivatives::<4>(|laws| laws.plane(true));
    tangents_are_derivatives::<6>(|laws| laws.space(true));
}

/// Simple shear of a perfectly plastic material: the shear stress stays at `yield_stress/sqrt(3)` however large the shear, where a purely
/// additive logarithmic strain falls to 0.22 of it at a shear of 10 (Itskov, International Journal of Solids and Structures 41, 2004).
#[test]
fn simple_shear_does_not_soften() {
    let law = law_of(&steel(), &|laws: &HistoryLaws| laws.space(true));
    let strain = |shear: f64| {
        let mut strain = [[ZERO; 6]];
        strain[0][mandel_index::<3>(0, 1)] = Lanes([0.5 * shear / mandel_scale(0, 1); WIDTH]);
        strain[0][1] = Lanes([0.5 * shear * shear; WIDTH]);
        strain
    };
    let (mut history, mut after, mut heat) = (vec![ZERO; law.variables()], vec![ZERO; law.variables()], [Heat::ZERO]);
    let count = 1000;
    for k in 1..=count {
        let [start, end] = [k - 1, k].map(|k| strain(0.01 * f64::from(k)));
        law.advance_into(&step([&start, &end], &end, &history, StressOf::Step), &mut after, &mut heat);
        std::mem::swap(&mut history, &mut after);
        if k % 50 == 0 {
            let mut stress = [[ZERO; 6]];
            law.stresses_into(&end, &history, &mut stress);
            let entry = |i: usize, j: usize| stress[0][mandel_index::<3>(i, j)].0[0] * mandel_scale(i, j);
            // tau = F S F^T with F = 1 + shear e_1 e_2.
            let tau = entry(0, 1) + 0.01 * f64::from(k) * entry(1, 1);
            assert!((tau * 3f64.sqrt() / 0.5 - 1.0).abs() < 1e-4, "{k}: {tau}");
        }
    }
}
