//! Rows of a ledger in their order, wherever they are kept, and rows as plain numbers.

use super::ledger::{ContactTotals, JointTotals, LedgerRow, PartTotals, ProbeValues, Reaction};

/// Rows of a ledger that are visited in their order, such as an array of them or a history whose older rows are on the disk.
pub trait Rows {
    /// Number of rows.
    fn count(&self) -> usize;

    /// Calls a function with every row from the one of index `from` on.
    fn visit(&self, from: usize, each: &mut dyn FnMut(&LedgerRow));

    /// The last row.
    fn last_row(&self) -> Option<LedgerRow>;
}

impl Rows for [LedgerRow] {
    fn count(&self) -> usize {
        self.len()
    }

    fn visit(&self, from: usize, each: &mut dyn FnMut(&LedgerRow)) {
        self.iter().skip(from).for_each(each);
    }

    fn last_row(&self) -> Option<LedgerRow> {
        self.last().cloned()
    }
}

impl Rows for Vec<LedgerRow> {
    fn count(&self) -> usize {
        self.len()
    }

    fn visit(&self, from: usize, each: &mut dyn FnMut(&LedgerRow)) {
        self.as_slice().visit(from, each);
    }

    fn last_row(&self) -> Option<LedgerRow> {
        self.last().cloned()
    }
}

/// Numbers of a row that do not depend on its model.
const OWN: usize = 27;
/// Numbers of a contact, a reaction, a joint, a probe.
const CONTACT: usize = 10;
const REACTION: usize = 6;
const JOINT: usize = 8;
const PROBE: usize = 6;

/// Lengths of the lists of a row: rows of one shape have equally many numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RowShape {
    contacts: usize,
    reactions: usize,
    parts: Vec<usize>,
    joints: usize,
    probes: usize,
}

impl RowShape {
    /// Shape of a row.
    pub fn of(row: &LedgerRow) -> Self {
        RowShape {
            contacts: row.contacts.len(),
            reactions: row.reactions.len(),
            parts: row.parts.iter().map(|part| part.readings.len()).collect(),
            joints: row.joints.len(),
            probes: row.probes.len(),
        }
    }

    /// Whether a row has this shape.
    pub fn is_of(&self, row: &LedgerRow) -> bool {
        (self.contacts, self.reactions, self.joints, self.probes)
            == (row.contacts.len(), row.reactions.len(), row.joints.len(), row.probes.len())
            && self.parts.len() == row.parts.len()
            && self.parts.iter().zip(&row.parts).all(|(length, part)| *length == part.readings.len())
    }

    /// Numbers of a row of this shape.
    pub fn numbers(&self) -> usize {
        let parts: usize = self.parts.iter().map(|readings| readings + 1).sum();
        OWN + CONTACT * self.contacts + REACTION * self.reactions + parts + JOINT * self.joints + PROBE * self.probes
    }
}

/// Reads numbers one after the other; 0 behind the end.
struct Reader<'a>(std::slice::Iter<'a, f64>);

impl Reader<'_> {
    fn one(&mut self) -> f64 {
        self.0.next().copied().unwrap_or(0.0)
    }

    fn count(&mut self) -> usize {
        self.one() as usize
    }

    fn three(&mut self) -> [f64; 3] {
        std::array::from_fn(|_| self.one())
    }
}

impl LedgerRow {
    /// Appends the row's numbers; counts are below 2^53 and stay exact.
    pub fn put_numbers(&self, into: &mut Vec<f64>) {
        let LedgerRow { step, time, dt, kinetic, strain, potential, reserve, load_work, contact_work, friction_work, .. } = self;
        let LedgerRow { dissipation, damping, numerical, energy_defect, momentum, angular_momentum, momentum_defect, .. } = self;
        let LedgerRow { angular_momentum_defect, newton_iterations, factorizations, halvings, active, max_penetration, .. } = self;
        let LedgerRow { contacts, reactions, parts, joints, probes, .. } = self;
        into.extend([*step as f64, *time, *dt, *kinetic, *strain, *potential, *reserve, *load_work, *contact_work, *friction_work]);
        into.extend([*dissipation, *damping, *numerical, *energy_defect]);
        into.extend(momentum.iter().chain(angular_momentum));
        into.extend([*momentum_defect, *angular_momentum_defect, *newton_iterations as f64, *factorizations as f64, *halvings as f64]);
        into.extend([*active as f64, *max_penetration]);
        for ContactTotals { active, force, normal_force, area, pressure, penetration, friction_work, sliding } in contacts {
            into.extend(force);
            into.extend([*active as f64, *normal_force, *area, *pressure, *penetration, *friction_work, *sliding as f64]);
        }
        reactions.iter().for_each(|Reaction { force, moment }| into.extend(force.iter().chain(moment)));
        for PartTotals { readings, dissipated } in parts {
            into.extend(readings);
            into.push(*dissipated);
        }
        for JointTotals { force, moment, value, work } in joints {
            into.extend(force.iter().chain(moment).chain([value, work]));
        }
        probes.iter().for_each(|ProbeValues { displacement, velocity }| into.extend(displacement.iter().chain(velocity)));
    }

    /// Takes the row's numbers from where [`Self::put_numbers`] has put them.
    pub fn take_numbers(&mut self, shape: &RowShape, numbers: &[f64]) {
        let mut from = Reader(numbers.iter());
        self.step = from.count();
        for own in [&mut self.time, &mut self.dt, &mut self.kinetic, &mut self.strain, &mut self.potential, &mut self.reserve] {
            *own = from.one();
        }
        for own in [&mut self.load_work, &mut self.contact_work, &mut self.friction_work, &mut self.dissipation, &mut self.damping] {
            *own = from.one();
        }
        (self.numerical, self.energy_defect) = (from.one(), from.one());
        (self.momentum, self.angular_momentum) = (from.three(), from.three());
        (self.momentum_defect, self.angular_momentum_defect) = (from.one(), from.one());
        for own in [&mut self.newton_iterations, &mut self.factorizations, &mut self.halvings, &mut self.active] {
            *own = from.count();
        }
        self.max_penetration = from.one();
        self.contacts.clear();
        self.contacts.extend((0..shape.contacts).map(|_| ContactTotals {
            force: from.three(),
            active: from.count(),
            normal_force: from.one(),
            area: from.one(),
            pressure: from.one(),
            penetration: from.one(),
            friction_work: from.one(),
            sliding: from.count(),
        }));
        self.reactions.clear();
        self.reactions.extend((0..shape.reactions).map(|_| Reaction { force: from.three(), moment: from.three() }));
        self.parts.resize_with(shape.parts.len(), PartTotals::default);
        for (part, readings) in self.parts.iter_mut().zip(&shape.parts) {
            part.readings.clear();
            part.readings.extend((0..*readings).map(|_| from.one()));
            part.dissipated = from.one();
        }
        self.joints.clear();
        let joint = |_| JointTotals { force: from.three(), moment: from.three(), value: from.one(), work: from.one() };
        self.joints.extend((0..shape.joints).map(joint));
        self.probes.clear();
        self.probes.extend((0..shape.probes).map(|_| ProbeValues { displacement: from.three(), velocity: from.three() }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_comes_back_from_its_numbers() {
        let mut count = 0.0;
        let mut next = || {
            count += 1.25;
            count
        };
        let mut three = || [next(), next(), -next()];
        let mut row = LedgerRow {
            step: 1 << 40,
            time: 0.1,
            dt: 1e-3,
            kinetic: -0.0,
            reserve: 3.0,
            numerical: 7.0,
            energy_defect: f64::MIN_POSITIVE,
            momentum: three(),
            angular_momentum: three(),
            momentum_defect: 1.0,
            angular_momentum_defect: 2.0,
            newton_iterations: 3,
            factorizations: 4,
            halvings: 5,
            active: 6,
            max_penetration: 0.5,
            ..LedgerRow::default()
        };
        row.contacts = vec![ContactTotals { active: 3, force: three(), sliding: 2, friction_work: -1.0, ..ContactTotals::default() }; 2];
        row.reactions = vec![Reaction { force: three(), moment: three() }];
        row.parts = vec![PartTotals { readings: vec![1.0, 2.0], dissipated: 3.0 }, PartTotals::default()];
        row.joints = vec![JointTotals { force: three(), moment: three(), value: 1.5, work: 2.5 }];
        row.probes = vec![ProbeValues { displacement: three(), velocity: three() }; 3];
        let (shape, mut numbers) = (RowShape::of(&row), Vec::new());
        row.put_numbers(&mut numbers);
        assert_eq!(numbers.len(), shape.numbers());
        for mut back in [LedgerRow::default(), row.clone()] {
            back.take_numbers(&shape, &numbers);
            assert_eq!(back, row);
            assert!(shape.is_of(&back) && back.kinetic.is_sign_negative());
        }
        assert!(!shape.is_of(&LedgerRow::default()));
    }
}
