//! Plane stress of laws with history variables: the strain across the plane follows from zero stress there.
//!
//! The strain across the plane is an additional history variable, because the stress of a conserving step is a mean over the step and does
//! not vanish at its end only. Newton's method solves `S_33 = 0` for the requested stress of the step, so that no work is done across the
//! plane; the tangent is condensed (de Borst, Communications in Applied Numerical Methods 7, 1991).

use std::sync::Arc;

use super::batched::{Components, Response};
use super::history::{Heat, HistoryLaw, PointHistory, StrainStep, StressOf};
use crate::math::lanes::{Lanes, WIDTH};
use crate::math::tolerances::THICKNESS_STRAIN;

/// Largest number of iterations: Newton's method needs four to eight.
const ITERATIONS: usize = 40;

/// Largest reduction of the present thickness in one iteration, as a strain.
const LARGEST_CUT: f64 = 0.45;

/// Index of the direction across the plane among four Mandel components.
const ACROSS: usize = 2;

/// A law without stress across the plane.
pub struct FreeThickness(pub Arc<dyn HistoryLaw<4>>);

/// Step with the strains across the plane that satisfy plane stress.
struct Found {
    start: Vec<Components<4>>,
    end: Vec<Components<4>>,
    middle: Vec<Components<4>>,
    change: Vec<Components<4>>,
    /// History variables of the law, without the strain across the plane.
    inner: Vec<Lanes<false>>,
    responses: Vec<Response<4>>,
    /// Derivatives with respect to the strain increment; `None` without any.
    rates: Option<Vec<Response<4>>>,
}

impl FreeThickness {
    /// Splits the history variables of all points into those of the law and the strains across the plane.
    fn parted(&self, history: &[Lanes<false>]) -> (Vec<Lanes<false>>, Vec<Lanes<false>>) {
        let size = self.variables();
        let (mut inner, mut across) = (Vec::with_capacity(history.len()), Vec::with_capacity(history.len() / size));
        for kept in history.chunks_exact(size) {
            inner.extend_from_slice(&kept[..size - 1]);
            across.push(kept[size - 1]);
        }
        (inner, across)
    }

    /// Joins the history variables of the law and the strains across the plane; inverse of `parted`.
    fn join(&self, inner: &[Lanes<false>], strain: &[Components<4>], history: &mut [Lanes<false>]) {
        let size = self.variables();
        for (point, (history, strain)) in history.chunks_exact_mut(size).zip(strain).enumerate() {
            history[..size - 1].copy_from_slice(&inner[point * (size - 1)..(point + 1) * (size - 1)]);
            history[size - 1] = strain[ACROSS];
        }
    }

    /// Finds the strains across the plane at the end of a step. Without a solution the stress is NaN, and the step is halved.
    fn solve(&self, step: &StrainStep<4>) -> Found {
        let (inner, start) = self.parted(step.history);
        let count = start.len();
        let mut found = Found {
            start: completed(step.start, &start),
            end: completed(step.end, &start),
            middle: completed(step.middle, &start),
            change: completed(step.change, &vec![Lanes::ZERO; count]),
            inner,
            responses: Vec::new(),
            rates: None,
        };
        let (mut responses, mut rates) = (vec![Response::ZERO; count], vec![Response::ZERO; count]);
        let (mut across, mut changes, mut is_found) = (start.clone(), vec![[0.0f64; WIDTH]; count], false);
        let mut has_rates = false;
        for _ in 0..ITERATIONS {
            self.0.responses_into(&found.step(step), &mut responses);
            has_rates = step.stress == StressOf::Middle && self.0.rate_responses_into(&found.step(step), &mut rates);
            if is_found {
                break;
            }
            for (point, (Response { stress, tangent }, rates)) in responses.iter().zip(&rates).enumerate() {
                let stiffness = tangent[ACROSS][ACROSS] + rates.tangent[ACROSS][ACROSS];
                for lane in 0..WIDTH {
                    let least = -LARGEST_CUT * (1.0 + 2.0 * across[point].0[lane]);
                    changes[point][lane] = (-stress[ACROSS].0[lane] / stiffness.0[lane]).max(least);
                    across[point].0[lane] += changes[point][lane];
                }
                found.end[point][ACROSS] = across[point];
                found.middle[point][ACROSS] = (start[point] + across[point]) * 0.5;
                found.change[point][ACROSS] = across[point] - start[point];
            }
            is_found = changes.iter().flatten().all(|change| change.abs() <= THICKNESS_STRAIN);
        }
        for ((response, rates), changes) in responses.iter_mut().zip(&mut rates).zip(&changes) {
            condense(response, rates);
            for (lane, change) in changes.iter().enumerate() {
                if change.is_nan() || change.abs() > THICKNESS_STRAIN {
                    response.stress[0].0[lane] = f64::NAN;
                }
            }
        }
        Found { responses, rates: has_rates.then_some(rates), ..found }
    }
}

/// Strains in the plane completed by those across the plane.
fn completed(strain: &[Components<4>], across: &[Lanes<false>]) -> Vec<Components<4>> {
    strain.iter().zip(across).map(|(strain, across)| [strain[0], strain[1], *across, strain[3]]).collect()
}

impl Found {
    fn step<'a>(&'a self, step: &StrainStep<'a, 4>) -> StrainStep<'a, 4> {
        let Found { start, end, middle, change, inner, .. } = self;
        StrainStep { start, end, middle, change, history: inner, ..*step }
    }
}

/// Condenses the strain across the plane out of a response and its derivatives with respect to the strain increment (zero if none).
fn condense(response: &mut Response<4>, rates: &mut Response<4>) {
    let full = [response.tangent, rates.tangent];
    let whole = |k: usize| full[0][k][ACROSS] + full[1][k][ACROSS];
    for (condensed, full) in [&mut response.tangent, &mut rates.tangent].into_iter().zip(&full) {
        for k in 0..4 {
            for l in 0..4 {
                condensed[k][l] =
                    if k == ACROSS || l == ACROSS { Lanes::ZERO } else { full[k][l] - whole(k) * full[ACROSS][l] / whole(ACROSS) };
            }
        }
    }
    response.stress[ACROSS] = Lanes::ZERO;
}

impl HistoryLaw<4> for FreeThickness {
    fn variables(&self) -> usize {
        self.0.variables() + 1
    }

    fn responses_into(&self, step: &StrainStep<4>, responses: &mut [Response<4>]) {
        responses.copy_from_slice(&self.solve(step).responses);
    }

    fn rate_responses_into(&self, step: &StrainStep<4>, responses: &mut [Response<4>]) -> bool {
        let rates = self.solve(step).rates;
        rates.iter().for_each(|rates| responses.copy_from_slice(rates));
        rates.is_some()
    }

    fn advance_into(&self, step: &StrainStep<4>, after: &mut [Lanes<false>], heat: &mut [Heat]) {
        let found = self.solve(step);
        let mut inner = found.inner.clone();
        self.0.advance_into(&found.step(step), &mut inner, heat);
        self.join(&inner, &found.end, after);
    }

    fn relax(&self, strain: &[Components<4>], history: &mut [Lanes<false>]) {
        let (mut inner, across) = self.parted(history);
        self.0.relax(&completed(strain, &across), &mut inner);
        self.join(&inner, &completed(strain, &across), history);
        let still = vec![[Lanes::ZERO; 4]; strain.len()];
        let Found { end, .. } = self.solve(&StrainStep::at_rest(strain, &still, history));
        self.join(&inner, &end, history);
    }

    fn energies_into(&self, strain: &[Components<4>], history: &[Lanes<false>], energies: &mut [Lanes<false>]) {
        let (inner, across) = self.parted(history);
        self.0.energies_into(&completed(strain, &across), &inner, energies);
    }

    fn add_relaxing_energies(&self, history: &[Lanes<false>], energies: &mut [Lanes<false>]) {
        self.0.add_relaxing_energies(&self.parted(history).0, energies);
    }

    fn stresses_into(&self, strain: &[Components<4>], history: &[Lanes<false>], stresses: &mut [Components<4>]) {
        let (inner, across) = self.parted(history);
        self.0.stresses_into(&completed(strain, &across), &inner, stresses);
    }

    fn across(&self, history: &[Lanes<false>]) -> Option<Lanes<false>> {
        history.last().copied()
    }

    fn shown(&self, history: &[Lanes<false>], lane: usize) -> Option<PointHistory> {
        self.0.shown(&history[..self.0.variables()], lane)
    }
}
