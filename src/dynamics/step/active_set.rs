//! The active set, completed on the frozen linearization of one iteration.

use super::contact_set::{SlipPlace, constraint_rows, first_state, has_row, pairs_at, slips_at};
use super::failure::Failure;
use super::frozen::{Frozen, RowValues};
use super::iterate::Linearization;
use super::newton::{Attempt, Increment};
use crate::bodies::{Elements, Space};
use crate::dynamics::parts::laws::{Equation, RowState};
use crate::linear::LinearError;
use crate::math::tolerances;

/// Largest number of active sets per linearization; if none of them is a solution, a new linearization is more effective than further sets.
const MAX_SETS: usize = 30;

/// Proximal term relative to the compliance of the constraint's node: small enough to cost few extra iterations, large enough to regularize
/// nearly dependent gradients.
const PROXIMAL: f64 = 0.1;

/// Growth of the proximal term in the next iteration if the present one does not suffice.
const MORE_PROXIMAL: f64 = 10.0;
/// Reduction of the proximal term in the next iteration if the present one suffices, because the term limits the speed at which multipliers
/// converge.
const LESS_PROXIMAL: f64 = 3.0;
/// Largest factor of the proximal term.
const LARGEST_PROXIMAL: f64 = 10.0;

impl<const D: usize> Attempt<'_, D>
where
    Space<D>: Elements<D>,
{
    /// Solves the frozen linearization together with its active set: active nodes in tension become inactive, inactive nodes that would
    /// overlap active.
    ///
    /// At partly covered nodes, or with secondary facets much finer than primary ones, gradients of neighboring constraints are nearly
    /// dependent, and possibly no active set is a solution. Multipliers then get a proximal term (Rockafellar, SIAM J. Control Optim. 14,
    /// 1976), which makes the conditions solvable and vanishes as the multipliers converge.
    pub(super) fn finish_set(&mut self, at: &mut Linearization, set: &mut Vec<RowState>) -> Result<Increment, Failure> {
        let begun = set.clone();
        let most = if self.proximal.is_some() && !self.task.is_patient { 1 } else { MAX_SETS };
        if !self.is_dependent {
            match self.find_set(at, set, most, None) {
                Ok((true, solution)) => {
                    (self.is_damped, self.proximal) = (false, None);
                    return Ok(solution);
                }
                Ok((false, _)) => {}
                // Constraints of periodic pairs and joints depend on those of an obstacle at the same nodes.
                Err(Failure::Linear(LinearError::Singular { .. })) => self.is_dependent = true,
                Err(failure) => return Err(failure),
            }
            *set = begun;
        }
        let first = if self.is_dependent { tolerances::PROXIMAL_OF_DEPENDENT } else { PROXIMAL };
        let factor = self.proximal.unwrap_or(first);
        let terms = self.proximal_terms(at, factor);
        let (is_solved, solution) = self.find_set(at, set, MAX_SETS, Some(&terms))?;
        self.is_damped = is_solved;
        let least = if self.is_dependent { tolerances::PROXIMAL_OF_DEPENDENT } else { 0.0 };
        self.proximal = Some(if is_solved { (factor / LESS_PROXIMAL).max(least) } else { (MORE_PROXIMAL * factor).min(LARGEST_PROXIMAL) });
        Ok(solution)
    }

    /// Changes the active set until it solves the frozen linearization, at most `most` times; returns success and the last solution.
    fn find_set(
        &mut self,
        at: &mut Linearization,
        set: &mut Vec<RowState>,
        most: usize,
        proximal: Option<&[f64]>,
    ) -> Result<(bool, Increment), Failure> {
        let (mut seen, mut frozen): (_, Option<Frozen>) = (vec![set.clone()], None);
        let mut one_at_a_time = false;
        let is_solved = loop {
            let RowValues { gaps, lambda } = self.rows_of(at, set, proximal, &mut frozen)?;
            let (mut next, worst) = self.next_set(at, set, &gaps, &lambda);
            if next == *set || seen.len() == most {
                break next == *set;
            }
            one_at_a_time |= seen.contains(&next);
            if one_at_a_time {
                // Without a worst constraint, the changes are round-off.
                let Some(worst) = worst else { break true };
                let changed = next[worst];
                next.clone_from(set);
                next[self.system.group_of(worst)].fill(changed);
                self.follow(at, set, &mut next);
                if seen.contains(&next) {
                    break false;
                }
            }
            seen.push(next.clone());
            *set = next;
        };
        let frozen = frozen.expect("the first set makes it");
        Ok((is_solved, self.system.thaw(frozen, self.task.start, at)?))
    }

    /// Weighted gaps and multipliers after the increment that solves the frozen linearization with an active set, from the existing factors
    /// or a new factorization.
    fn rows_of(
        &mut self,
        at: &mut Linearization,
        set: &[RowState],
        proximal: Option<&[f64]>,
        frozen: &mut Option<Frozen>,
    ) -> Result<RowValues, Failure> {
        let mut rows = constraint_rows(self.system, at, self.task.conditions, set, self.compliance_ratio, proximal);
        if let Some(terms) = proximal {
            rows.add_proximal(self.system.normal_count, terms, &at.lambda);
        }
        let known = frozen.as_mut().and_then(|frozen| self.system.rows_with(frozen, self.task.start, at, &rows));
        let mut values = match known {
            Some(values) => values,
            None => frozen.insert(self.system.freeze(self.task.start, at, &rows)?).base().clone(),
        };
        let slips = self.system.pairs.iter().zip(&at.slips).filter(|(pair, _)| pair.friction.is_some()).flat_map(|(_, slip)| &slip.gap);
        let evaluated = at.pairs.iter().flat_map(|pair| &pair.gap).chain(slips);
        values.gaps.iter_mut().zip(evaluated).for_each(|(change, gap)| *change += gap);
        if let Some(terms) = proximal {
            let normal = values.gaps[..self.system.normal_count].iter_mut();
            normal.zip(terms).zip(&at.lambda).for_each(|((gap, term), lambda)| *gap -= term * lambda);
        }
        // Gaps and slips including the compliance of the constraints, by which stick or slip is decided.
        for (row, Equation { compliance, .. }) in rows.0.iter().enumerate().filter(|(_, row)| row.compliance > 0.0) {
            values.gaps[row] += compliance * (values.lambda[row] - at.lambda[row]);
        }
        Ok(values)
    }

    /// Proximal compliance of every constraint: a fraction of the compliance of its own node.
    fn proximal_terms(&self, at: &Linearization, factor: f64) -> Vec<f64> {
        let mut terms = self.task.conditions.stiffness.clone();
        for (pair, evaluation) in pairs_at(self.system, at) {
            // Constraints of rigid bodies and joints are active in every set: proximal terms would only soften them.
            let factor = if pair.kind.is_of_points() && pair.law.is_bilateral() { 0.0 } else { factor };
            for (term, coverage) in terms[pair.rows.clone()].iter_mut().zip(&evaluation.coverage) {
                *term = factor * coverage * coverage / *term;
            }
        }
        self.system.copy_to_slips(&mut terms);
        terms
    }

    /// Makes tangential constraints inactive whose normal constraint becomes inactive, and sets the first state of those whose normal
    /// constraint becomes active.
    fn follow(&self, at: &Linearization, set: &[RowState], next: &mut [RowState]) {
        for place in slips_at(self.system, at).filter(|place| !self.dropped[place.rows.start]) {
            if next[place.normal_row] != set[place.normal_row] {
                let state = first_state(&place, self.task.conditions, at, next);
                next[place.rows].fill(state);
            }
        }
    }

    /// Active set that the solution of Newton's system requires, and the constraint with the largest violation.
    ///
    /// Corners wait until no more constraints of their contact become active, which may resolve their overlap: as long as a body is not
    /// held, all overlap alike, and dependent constraints with different gaps have multipliers of which the next iterates keep a part.
    fn next_set(&self, at: &Linearization, set: &[RowState], gaps: &[f64], lambda: &[f64]) -> (Vec<RowState>, Option<usize>) {
        let mut next = set.to_vec();
        let (mut largest, mut worst) = (0.0, None);
        let mut closes = vec![false; self.system.pairs.len()];
        for (index, (pair, evaluation)) in pairs_at(self.system, at).enumerate() {
            let waits = pair.corners.is_some_and(|corners| closes[corners.pair]);
            for row in pair.rows.clone().filter(|&row| !self.dropped[row] && has_row(pair, evaluation, row - pair.rows.start)) {
                let found = self.task.conditions.row(pair, row, gaps[row], lambda[row]);
                let Some(violation) = pair.law.change(set[row], &found) else { continue };
                if waits && !set[row].is_closed() {
                    continue;
                }
                closes[index] |= !set[row].is_closed();
                next[row] = set[row].switched();
                if violation > largest {
                    (largest, worst) = (violation, Some(row));
                }
            }
        }
        let takes_part = |place: &SlipPlace| place.exists && !self.dropped[place.rows.start] && set[place.normal_row].is_closed();
        for place in slips_at(self.system, at).filter(takes_part) {
            let first = place.rows.start;
            // A slip starts in the direction of the trial multiplier, which is defined at a later iterate.
            let iterate = place.at(self.task.conditions, at);
            if !iterate.is_directed() {
                continue;
            }
            let Some((state, violation)) = place.with(self.task.conditions, gaps, lambda).change(set[first], &iterate) else { continue };
            next[place.rows].fill(state);
            if violation > largest {
                (largest, worst) = (violation, Some(first));
            }
        }
        self.follow(at, set, &mut next);
        (next, worst)
    }
}
