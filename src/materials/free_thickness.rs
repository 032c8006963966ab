//! Plane stress of laws with history variables: the strain across the plane is the one at which no stress acts there.
//!
//! That strain is one more history variable, because the stress of a step that conserves is a mean over the step: at its end alone it does
//! not vanish. In a step it is solved for by Newton's method, `S_33 = 0` of the stress that is asked for, so that nothing across the plane
//! does work; the tangent is condensed (de Borst, Communications in Applied Numerical Methods 7, 1991).

use std::sync::Arc;

use super::batched::{Components, Response};
use super::history::{HistoryLaw, PointHistory, StrainStep};
use crate::math::lanes::{Lanes, WIDTH};
use crate::math::tolerances::THICKNESS_STRAIN;

/// Most iterations: Newton's method needs four to eight.
const ITERATIONS: usize = 40;

/// Part of the present thickness, as a strain, that one iteration may take: a tenth would be left.
const LARGEST_CUT: f64 = 0.45;

/// Index of the direction across the plane among four Mandel components.
const ACROSS: usize = 2;

/// A law without stress across the plane.
pub struct FreeThickness(pub Arc<dyn HistoryLaw<4>>);

/// A step with the strains across that were found.
struct Found {
    start: Vec<Components<4>>,
    end: Vec<Components<4>>,
    middle: Vec<Components<4>>,
    /// History variables of the law itself.
    inner: Vec<Lanes<false>>,
    responses: Vec<Response<4>>,
}

impl FreeThickness {
    /// History variables of the law itself at all points, and the strains across.
    fn parted(&self, history: &[Lanes<false>]) -> (Vec<Lanes<false>>, Vec<Lanes<false>>) {
        let size = self.variables();
        let (mut inner, mut across) = (Vec::with_capacity(history.len()), Vec::with_capacity(history.len() / size));
        for kept in history.chunks_exact(size) {
            inner.extend_from_slice(&kept[..size - 1]);
            across.push(kept[size - 1]);
        }
        (inner, across)
    }

    /// Finds the strains across at the end of a step. Where there is none, the stress is no number, and the step is taken in halves.
    fn solve(&self, step: &StrainStep<4>) -> Found {
        let (inner, start) = self.parted(step.history);
        let mut found = Found {
            start: completed(step.start, &start),
            end: completed(step.end, &start),
            middle: completed(step.middle, &start),
            inner,
            responses: Vec::new(),
        };
        let mut responses = vec![Response::ZERO; step.start.len()];
        let (mut across, mut changes, mut is_found) = (start.clone(), vec![[0.0f64; WIDTH]; start.len()], false);
        for _ in 0..ITERATIONS {
            self.0.responses_into(&found.step(step), &mut responses);
            if is_found {
                break;
            }
            for (point, Response { stress, tangent }) in responses.iter().enumerate() {
                for lane in 0..WIDTH {
                    let least = -LARGEST_CUT * (1.0 + 2.0 * across[point].0[lane]);
                    changes[point][lane] = (-stress[ACROSS].0[lane] / tangent[ACROSS][ACROSS].0[lane]).max(least);
                    across[point].0[lane] += changes[point][lane];
                }
                found.end[point][ACROSS] = across[point];
                found.middle[point][ACROSS] = (start[point] + across[point]) * 0.5;
            }
            is_found = changes.iter().flatten().all(|change| change.abs() <= THICKNESS_STRAIN);
        }
        for (response, changes) in responses.iter_mut().zip(&changes) {
            condense(response);
            for (lane, change) in changes.iter().enumerate() {
                if change.is_nan() || change.abs() > THICKNESS_STRAIN {
                    response.stress[0].0[lane] = f64::NAN;
                }
            }
        }
        Found { responses, ..found }
    }
}

/// Strains in the plane with those across it.
fn completed(strain: &[Components<4>], across: &[Lanes<false>]) -> Vec<Components<4>> {
    strain.iter().zip(across).map(|(strain, across)| [strain[0], strain[1], *across, strain[3]]).collect()
}

impl Found {
    fn step<'a>(&'a self, step: &StrainStep<'a, 4>) -> StrainStep<'a, 4> {
        StrainStep { start: &self.start, end: &self.end, middle: &self.middle, history: &self.inner, ..*step }
    }
}

/// Takes the strain across out of a response.
fn condense(response: &mut Response<4>) {
    let Response { stress, tangent } = response;
    let full = *tangent;
    for k in 0..4 {
        for l in 0..4 {
            tangent[k][l] = if k == ACROSS || l == ACROSS {
                Lanes::ZERO
            } else {
                full[k][l] - full[k][ACROSS] * full[ACROSS][l] / full[ACROSS][ACROSS]
            };
        }
    }
    stress[ACROSS] = Lanes::ZERO;
}

impl HistoryLaw<4> for FreeThickness {
    fn variables(&self) -> usize {
        self.0.variables() + 1
    }

    fn responses_into(&self, step: &StrainStep<4>, responses: &mut [Response<4>]) {
        responses.copy_from_slice(&self.solve(step).responses);
    }

    fn advance_into(&self, step: &StrainStep<4>, after: &mut [Lanes<false>], heat: &mut [Lanes<false>]) {
        let found = self.solve(step);
        let mut inner = found.inner.clone();
        self.0.advance_into(&found.step(step), &mut inner, heat);
        let size = self.variables();
        for ((after, inner), end) in after.chunks_exact_mut(size).zip(inner.chunks_exact(size - 1)).zip(&found.end) {
            after[..size - 1].copy_from_slice(inner);
            after[size - 1] = end[ACROSS];
        }
    }

    fn energies_into(&self, strain: &[Components<4>], history: &[Lanes<false>], energies: &mut [Lanes<false>]) {
        let (inner, across) = self.parted(history);
        self.0.energies_into(&completed(strain, &across), &inner, energies);
    }

    fn stresses_into(&self, strain: &[Components<4>], history: &[Lanes<false>], stresses: &mut [Components<4>]) {
        let (inner, across) = self.parted(history);
        self.0.stresses_into(&completed(strain, &across), &inner, stresses);
    }

    fn across(&self, history: &[Lanes<false>]) -> Option<Lanes<false>> {
        history.last().copied()
    }

    fn shown(&self, history: &[Lanes<false>], lane: usize) -> PointHistory {
        self.0.shown(&history[..self.0.variables()], lane)
    }
}
