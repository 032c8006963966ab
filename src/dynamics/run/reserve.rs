//! Return of the stored impact energy of constraints that have opened, in the step in which they open: never across an open gap.
//!
//! The constraints exert impulses in proportion to the impact that their stored energy represents. Two kinds cannot: a constraint whose
//! node faces no other side has no gradient, and a constraint that was opened by another one still approaches. Their energy is transferred
//! to the active constraints of the contact, which return it when they open. Without active constraints the nearest inactive one takes over
//! the energy of a constraint without gradient, and exerts an impulse although it approaches: the energy remains exact. Energy that cannot
//! be returned in these ways is lost at once, in the work of contact.

use super::engine::Engine;
use super::velocity_correction::{Ending, VelocityCorrection};
use crate::bodies::{Elements, Space};
use crate::dynamics::step::failure::Failure;
use crate::dynamics::step::impulse_response::ImpulseResponse;
use crate::math::tolerances;

/// Gap relative to the secondary facet length up to which an inactive constraint takes over the stored impact energy of a constraint whose
/// node left the surface.
const NEAR: f64 = 0.5;

/// Condition on opened constraints for the return of their stored energy.
#[derive(Clone, Copy, PartialEq)]
enum ReturnCondition {
    /// Only constraints whose sides part.
    Parting,
    /// All opened constraints, also those whose sides still approach.
    Anyhow,
}

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// Returns the stored impact energy of constraints that have opened.
    ///
    /// # Errors
    /// The run was interrupted.
    pub fn give_back(&mut self, end: &mut Ending, jump: &mut VelocityCorrection) -> Result<(), Failure> {
        let slid_off = self.opened(end, jump).into_iter().filter(|&row| !self.is_opposite(end, row));
        for row in slid_off.collect::<Vec<_>>() {
            self.hand_to_closed(end, jump, row);
            self.hand_to_nearest(end, jump, row);
        }
        if self.push_apart(end, jump, ReturnCondition::Parting)? {
            return Ok(());
        }
        self.opened(end, jump).into_iter().for_each(|row| self.hand_to_closed(end, jump, row));
        if !self.push_apart(end, jump, ReturnCondition::Anyhow)? {
            self.opened(end, jump).into_iter().for_each(|row| jump.reserve[row] = 0.0);
        }
        Ok(())
    }

    /// Constraints with stored impact energy that have become inactive.
    fn opened(&self, end: &Ending, jump: &VelocityCorrection) -> Vec<usize> {
        (0..end.ours.len()).filter(|&row| end.has_opened(row, &jump.reserve)).collect()
    }

    /// Index of the pair of a constraint, and index in the pair.
    fn place(&self, row: usize) -> (usize, usize) {
        let pair = self.system.pairs.iter().position(|pair| pair.rows.contains(&row)).expect("every row belongs to a pair");
        (pair, row - self.system.pairs[pair].rows.start)
    }

    /// True if the node of a constraint faces the other side at the end of the step.
    fn is_opposite(&self, end: &Ending, row: usize) -> bool {
        let (pair, local) = self.place(row);
        end.solution.at.pairs[pair].coverage[local] > tolerances::SLIVER
    }

    /// Constraints with the `velocity` rule in the contact of the constraint `row`, corner constraints included.
    fn of_same_contact(&self, end: &Ending, row: usize) -> Vec<usize> {
        let pairs = &self.system.pairs;
        let contact = |index: usize| self.system.contact_of(index);
        let own = contact(self.place(row).0);
        let rows = (0..pairs.len()).filter(|&index| contact(index) == own).flat_map(|index| pairs[index].rows.clone());
        rows.filter(|&row| end.ours[row]).collect()
    }

    /// Transfers the stored impact energy of a constraint to the active ones of its contact in equal parts, if there are any.
    fn hand_to_closed(&self, end: &Ending, jump: &mut VelocityCorrection, row: usize) {
        let closed: Vec<usize> = self.of_same_contact(end, row).into_iter().filter(|&other| end.hold[other]).collect();
        if !closed.is_empty() {
            let share = std::mem::take(&mut jump.reserve[row]) / closed.len() as f64;
            closed.into_iter().for_each(|other| jump.reserve[other] += share);
        }
    }

    /// Transfers the stored impact energy of a constraint to the nearest inactive constraint of its contact that faces the other side
    /// within `NEAR`.
    fn hand_to_nearest(&self, end: &Ending, jump: &mut VelocityCorrection, row: usize) {
        let facets = |row: usize| {
            let (pair, local) = self.place(row);
            let kernel = &self.system.pairs[pair].kernel;
            let evaluation = &end.solution.at.pairs[pair];
            evaluation.gap[local] / (evaluation.coverage[local] * kernel.weights()[local] * kernel.facet_size())
        };
        let open = self.of_same_contact(end, row).into_iter().filter(|&other| self.is_opposite(end, other));
        let near = open.map(|other| (facets(other), other)).filter(|(facets, _)| *facets < NEAR);
        if let Some((_, other)) = near.min_by(|a, b| a.0.total_cmp(&b.0)) {
            jump.reserve[other] += std::mem::take(&mut jump.reserve[row]);
        }
    }

    /// Applies impulses of constraints that have opened, in proportion to the impact that their stored energy represents, and returns the
    /// energy: `v + s w` with the positive root of `a s^2 + b s = reserve`. Returns true if no stored energy remains.
    fn push_apart(&mut self, end: &mut Ending, jump: &mut VelocityCorrection, way: ReturnCondition) -> Result<bool, Failure> {
        let opened = self.opened(end, jump);
        if opened.is_empty() {
            return Ok(true);
        }
        let mut pushes = vec![0.0; end.hold.len()];
        for &row in &opened {
            let (pair, local) = self.place(row);
            pushes[row] = (jump.reserve[row] / self.system.pairs[pair].kernel.weights()[local]).sqrt();
        }
        let rates = self.system.rates(end.rows(), &end.solution.at.q_1, &end.v);
        let parting: f64 = pushes.iter().zip(rates).map(|(push, rate)| push * rate).sum();
        if way == ReturnCondition::Parting && parting <= 0.0 {
            return Ok(false);
        }
        let Some(push) = self.smoothed_push(end, &pushes)? else { return Ok(false) };
        let slopes = self.slopes(end, &push);
        let [a, b] = slopes.normal;
        if a <= 0.0 || (way == ReturnCondition::Parting && b <= 0.0) {
            return Ok(false);
        }
        let energy: f64 = opened.iter().map(|&row| jump.reserve[row]).sum();
        let root = (b * b + 4.0 * a * energy).sqrt();
        let s = if b > 0.0 { 2.0 * energy / (b + root) } else { (root - b) / (2.0 * a) };
        end.add(jump, s, &push, &slopes);
        opened.into_iter().for_each(|row| jump.reserve[row] = 0.0);
        Ok(true)
    }

    /// Impulse response smoothed by the stiffness, or by the mass alone if the round-off of the stiffness would appear as momentum.
    fn smoothed_push(&mut self, end: &Ending, pushes: &[f64]) -> Result<Option<ImpulseResponse>, Failure> {
        let still = vec![0.0; pushes.len()];
        match self.balanced_push(end, 0.25 * end.motion.dt * end.motion.dt, pushes, &still)? {
            Some(push) => Ok(Some(push)),
            None => self.balanced_push(end, 0.0, pushes, &still),
        }
    }
}
