//! Gives back the reserves of constraints that have opened, in the step in which they open: never across an open gap.
//!
//! They push, each in proportion to the impact that its reserve stands for. Not all of them can: one that is opposite nothing any more has
//! no gradient, and one that opened for another's sake still approaches. Then the closed constraints of the same contact take the reserve
//! over, and give it when they open; without any, the nearest open one takes that of one opposite nothing, and pushes although it
//! approaches: the energy is exact all the same. What cannot be given even so is lost at once, in the work of contact.

use super::engine::Engine;
use super::velocity_correction::{Ending, VelocityCorrection};
use crate::bodies::{Elements, Space};
use crate::dynamics::step::failure::Failure;
use crate::dynamics::step::impulse_response::ImpulseResponse;
use crate::math::tolerances;

/// Gap in secondary facets up to which an open constraint takes over the reserve of one that has slid off.
const NEAR: f64 = 0.5;

/// How constraints push that have opened.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    /// Only if they part.
    Parting,
    /// In any case.
    Anyhow,
}

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// Gives back what constraints keep that have opened.
    ///
    /// # Errors
    /// The run was interrupted.
    pub fn give_back(&mut self, end: &mut Ending, jump: &mut VelocityCorrection) -> Result<(), Failure> {
        let slid_off = self.opened(end, jump).into_iter().filter(|&row| !self.is_opposite(end, row));
        for row in slid_off.collect::<Vec<_>>() {
            self.hand_to_closed(end, jump, row);
            self.hand_to_nearest(end, jump, row);
        }
        if self.push_apart(end, jump, Way::Parting)? {
            return Ok(());
        }
        self.opened(end, jump).into_iter().for_each(|row| self.hand_to_closed(end, jump, row));
        if !self.push_apart(end, jump, Way::Anyhow)? {
            self.opened(end, jump).into_iter().for_each(|row| jump.reserve[row] = 0.0);
        }
        Ok(())
    }

    /// Rows that have left the active set with a reserve.
    fn opened(&self, end: &Ending, jump: &VelocityCorrection) -> Vec<usize> {
        (0..end.ours.len()).filter(|&row| end.has_opened(row, &jump.reserve)).collect()
    }

    /// Index of the pair of a row, and its place there.
    fn place(&self, row: usize) -> (usize, usize) {
        let pair = self.system.pairs.iter().position(|pair| pair.rows.contains(&row)).expect("every row belongs to a pair");
        (pair, row - self.system.pairs[pair].rows.start)
    }

    /// Whether a row is opposite something at the end of the step.
    fn is_opposite(&self, end: &Ending, row: usize) -> bool {
        let (pair, local) = self.place(row);
        end.solution.at.pairs[pair].coverage[local] > tolerances::SLIVER
    }

    /// Rows under the rule of the contact of a row, those of its corners included.
    fn of_same_contact(&self, end: &Ending, row: usize) -> Vec<usize> {
        let pairs = &self.system.pairs;
        let contact = |index: usize| self.system.contact_of(index);
        let own = contact(self.place(row).0);
        let rows = (0..pairs.len()).filter(|&index| contact(index) == own).flat_map(|index| pairs[index].rows.clone());
        rows.filter(|&row| end.ours[row]).collect()
    }

    /// Hands the reserve of a row to the closed ones of its contact in equal parts, if there are any.
    fn hand_to_closed(&self, end: &Ending, jump: &mut VelocityCorrection, row: usize) {
        let closed: Vec<usize> = self.of_same_contact(end, row).into_iter().filter(|&other| end.hold[other]).collect();
        if !closed.is_empty() {
            let share = std::mem::take(&mut jump.reserve[row]) / closed.len() as f64;
            closed.into_iter().for_each(|other| jump.reserve[other] += share);
        }
    }

    /// Hands the reserve of a row to the nearest open one of its contact that is opposite something, if one is near.
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

    /// Open constraints push in proportion to the impact that their reserve stands for, and give it back: `v + s w` with the positive root
    /// of `a s^2 + b s = reserve`. Whether nothing is left to give.
    fn push_apart(&mut self, end: &mut Ending, jump: &mut VelocityCorrection, way: Way) -> Result<bool, Failure> {
        let opened = self.opened(end, jump);
        if opened.is_empty() {
            return Ok(true);
        }
        let mut pushes = vec![0.0; end.hold.len()];
        for &row in &opened {
            let (pair, local) = self.place(row);
            pushes[row] = (jump.reserve[row] / self.system.pairs[pair].kernel.weights()[local]).sqrt();
        }
        let rates = self.system.rates(end.rows(), &end.v);
        let parting: f64 = pushes.iter().zip(rates).map(|(push, rate)| push * rate).sum();
        if way == Way::Parting && parting <= 0.0 {
            return Ok(false);
        }
        let Some(push) = self.smoothed_push(end, &pushes)? else { return Ok(false) };
        let slopes = self.slopes(end, &push);
        let [a, b] = slopes.pressing;
        if a <= 0.0 || (way == Way::Parting && b <= 0.0) {
            return Ok(false);
        }
        let energy: f64 = opened.iter().map(|&row| jump.reserve[row]).sum();
        let root = (b * b + 4.0 * a * energy).sqrt();
        let s = if b > 0.0 { 2.0 * energy / (b + root) } else { (root - b) / (2.0 * a) };
        end.add(jump, s, &push, &slopes);
        opened.into_iter().for_each(|row| jump.reserve[row] = 0.0);
        Ok(true)
    }

    /// A push smoothed by the stiffness, or by the mass alone where the stiffness's round-off would be felt as momentum.
    fn smoothed_push(&mut self, end: &Ending, pushes: &[f64]) -> Result<Option<ImpulseResponse>, Failure> {
        let still = vec![0.0; pushes.len()];
        match self.balanced_push(end, 0.25 * end.motion.dt * end.motion.dt, pushes, &still)? {
            Some(push) => Ok(Some(push)),
            None => self.balanced_push(end, 0.0, pushes, &still),
        }
    }
}
