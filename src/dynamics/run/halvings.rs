//! Counters of halved steps, and of steps that would have had to be halved, by cause.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};

use super::ledger::LedgerRow;
use crate::dynamics::step::failure::Failure;
use crate::dynamics::step::large_motion::{LargeMotion, MotionKind};

/// Name of a cause; the type alias prevents `serde` from borrowing it from the input.
pub type Cause = &'static str;

/// Halvings for one cause.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Halving {
    /// Cause: name of a too large motion, or kind of failure of Newton's method.
    #[serde(deserialize_with = "known_cause")]
    pub cause: Cause,
    /// First motion that was too large; `None` for other causes.
    pub motion: Option<LargeMotion>,
    /// Number of halvings for this cause.
    pub count: usize,
    /// Number of the last accepted step before the first halving.
    pub step: usize,
    /// Time of the first halving `[time]`.
    pub time: f64,
    /// Size of the first halved step `[time]`.
    pub dt: f64,
}

/// All halvings of a simulation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Halvings {
    done: Vec<Halving>,
    refused: Vec<Halving>,
}

impl Halvings {
    /// Counts the halving of a step of size `dt` after `row`.
    pub fn count(&mut self, failure: &Failure, dt: f64, row: &LedgerRow) {
        let (cause, motion) = match failure {
            Failure::Foreseen(motion) => (motion.kind.name(), Some(motion)),
            failure => (failure.name(), None),
        };
        let new = Halving { cause, motion: motion.cloned(), count: 1, step: row.step, time: row.time, dt };
        new.count_among(&mut self.done);
    }

    /// Counts a step of size `dt` after `row` that requires halving but has reached the largest number of halvings.
    pub fn refuse(&mut self, motion: LargeMotion, dt: f64, row: &LedgerRow) {
        let new = Halving { cause: motion.kind.name(), motion: Some(motion), count: 1, step: row.step, time: row.time, dt };
        new.count_among(&mut self.refused);
    }

    /// Halvings by cause and contact, in the order of first occurrence.
    pub fn all(&self) -> &[Halving] {
        &self.done
    }

    /// Steps taken without the halving that their motion requires, by cause and contact.
    pub fn refused(&self) -> &[Halving] {
        &self.refused
    }
}

/// Known cause with the name in a file.
fn known_cause<'de, D: Deserializer<'de>>(reader: D) -> Result<Cause, D::Error> {
    let name = String::deserialize(reader)?;
    let known = Failure::NAMES.iter().chain(MotionKind::NAMES).find(|known| **known == name);
    known.copied().ok_or_else(|| D::Error::custom("unknown cause"))
}

impl Halving {
    fn count_among(self, known: &mut Vec<Halving>) {
        let contact = |halving: &Halving| halving.motion.as_ref().map(|motion| motion.contact.clone());
        match known.iter_mut().find(|known| known.cause == self.cause && contact(known) == contact(&self)) {
            Some(known) => known.count += 1,
            None => known.push(self),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_cause_and_contact_is_counted_by_itself() {
        let mut halvings = Halvings::default();
        let sliding =
            |contact: &str, facets: f64| Failure::Foreseen(LargeMotion { contact: contact.into(), kind: MotionKind::Sliding, facets });
        let row = |step: usize| LedgerRow { step, time: step as f64, ..LedgerRow::default() };
        halvings.count(&sliding("race", 1.2), 0.1, &row(3));
        halvings.count(&Failure::Diverged, 0.1, &row(4));
        halvings.count(&sliding("race", 2.0), 0.05, &row(5));
        halvings.count(&sliding("floor", 1.0), 0.1, &row(6));
        let told: Vec<_> = halvings.all().iter().map(|halving| (halving.cause, halving.count, halving.step, halving.dt)).collect();
        assert_eq!(told, [("sliding", 2, 3, 0.1), ("divergence", 1, 4, 0.1), ("sliding", 1, 6, 0.1)]);
        assert_eq!(halvings.all()[0].motion.as_ref().map(|motion| motion.facets), Some(1.2), "the first one");
        assert!(halvings.refused().is_empty());
    }
}
