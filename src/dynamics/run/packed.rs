//! Ledger rows as bytes, for files that hold many of them: numbers of 8 bytes (little endian), lists behind their length.
//!
//! Compiled with full optimization: a run visits each row a dozen times, and `serde` takes ten times as long.

use super::ledger::{ContactTotals, JointTotals, LedgerRow, PartTotals, ProbeValues, Reaction};

/// Bytes of a number.
const NUMBER: usize = 8;

/// Value that is converted to and from bytes.
trait Packed {
    /// Appends the value to a buffer, as bytes.
    fn put(&self, into: &mut Vec<u8>);

    /// Reads the value from the front of a byte slice; `None` if the slice is too short.
    fn take(&mut self, from: &mut &[u8]) -> Option<()>;
}

impl Packed for f64 {
    fn put(&self, into: &mut Vec<u8>) {
        into.extend_from_slice(&self.to_le_bytes());
    }

    fn take(&mut self, from: &mut &[u8]) -> Option<()> {
        let (number, rest) = from.split_first_chunk::<NUMBER>()?;
        (*self, *from) = (f64::from_le_bytes(*number), rest);
        Some(())
    }
}

impl Packed for usize {
    fn put(&self, into: &mut Vec<u8>) {
        into.extend_from_slice(&(*self as u64).to_le_bytes());
    }

    fn take(&mut self, from: &mut &[u8]) -> Option<()> {
        let (number, rest) = from.split_first_chunk::<NUMBER>()?;
        (*self, *from) = (usize::try_from(u64::from_le_bytes(*number)).ok()?, rest);
        Some(())
    }
}

impl Packed for [f64; 3] {
    fn put(&self, into: &mut Vec<u8>) {
        self.iter().for_each(|number| number.put(into));
    }

    fn take(&mut self, from: &mut &[u8]) -> Option<()> {
        self.iter_mut().try_for_each(|number| number.take(from))
    }
}

impl<T: Packed + Clone + Default> Packed for Vec<T> {
    fn put(&self, into: &mut Vec<u8>) {
        self.len().put(into);
        self.iter().for_each(|entry| entry.put(into));
    }

    fn take(&mut self, from: &mut &[u8]) -> Option<()> {
        let mut length = 0;
        length.take(from)?;
        // A damaged length must not require more memory than there are bytes.
        if length > from.len() / NUMBER {
            return None;
        }
        self.resize(length, T::default());
        self.iter_mut().try_for_each(|entry| entry.take(from))
    }
}

/// Packs a struct by its fields, all of which must be named.
macro_rules! packed {
    ($type:ident: $($field:ident)*) => {
        impl Packed for $type {
            fn put(&self, into: &mut Vec<u8>) {
                let $type { $($field),* } = self;
                $($field.put(into);)*
            }

            fn take(&mut self, from: &mut &[u8]) -> Option<()> {
                let $type { $($field),* } = self;
                $($field.take(from)?;)*
                Some(())
            }
        }
    };
}

packed!(LedgerRow: step time dt kinetic strain potential reserve load_work contact_work friction_work joint_friction dissipation damping
    numerical impact plastic energy_defect work_round_off momentum angular_momentum momentum_defect angular_momentum_defect
    newton_iterations factorizations halvings active max_penetration contacts reactions plastic_work parts joints probes);
packed!(ContactTotals: active force normal_force area pressure penetration friction_work sliding);
packed!(Reaction: force moment);
packed!(PartTotals: readings dissipated);
packed!(JointTotals: force moment value work friction friction_work);
packed!(ProbeValues: displacement velocity acceleration);

impl LedgerRow {
    /// Appends the row's bytes.
    #[inline(never)]
    pub fn pack(&self, into: &mut Vec<u8>) {
        self.put(into);
    }

    /// Replaces the row by one read from the front of a byte slice; returns the remaining bytes, or `None` if the slice is too short.
    #[inline(never)]
    pub fn unpack<'a>(&mut self, mut bytes: &'a [u8]) -> Option<&'a [u8]> {
        self.take(&mut bytes)?;
        Some(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row() -> LedgerRow {
        let three = |number: f64| [number, 2.0 * number, -number];
        let mut row =
            LedgerRow { step: 1 << 40, time: 0.1, kinetic: -0.0, impact: 3.0, energy_defect: f64::MIN_POSITIVE, ..LedgerRow::default() };
        (row.momentum, row.halvings, row.max_penetration) = (three(0.3), 5, f64::INFINITY);
        row.contacts = vec![ContactTotals { active: 3, force: three(1.0), sliding: 2, friction_work: -1.0, ..ContactTotals::default() }; 2];
        row.reactions = vec![Reaction { force: three(4.0), moment: three(5.0) }];
        row.parts = vec![PartTotals { readings: vec![1.0, 2.0], dissipated: 3.0 }, PartTotals::default()];
        row.joints = vec![JointTotals { force: three(6.0), moment: three(7.0), value: 1.5, work: 2.5, friction: 3.5, friction_work: -4.5 }];
        row.probes = vec![ProbeValues { displacement: three(8.0), velocity: three(9.0), acceleration: three(10.0) }; 3];
        row
    }

    #[test]
    fn rows_come_back_from_their_bytes() {
        let (other, mut bytes) = (LedgerRow { step: 7, ..LedgerRow::default() }, Vec::new());
        row().pack(&mut bytes);
        other.pack(&mut bytes);
        row().pack(&mut bytes);
        let (mut read, mut rest) = (LedgerRow::default(), &bytes[..]);
        for expected in [row(), other, row()] {
            rest = read.unpack(rest).unwrap();
            assert_eq!(format!("{read:?}"), format!("{expected:?}"));
        }
        assert!(rest.is_empty());
    }

    #[test]
    fn damaged_bytes_are_no_row() {
        let mut bytes = Vec::new();
        row().pack(&mut bytes);
        (0..bytes.len()).for_each(|length| assert!(LedgerRow::default().unpack(&bytes[..length]).is_none(), "{length} bytes"));
        for place in (0..bytes.len()).step_by(NUMBER) {
            let mut damaged = bytes.clone();
            damaged[place..place + NUMBER].fill(0xff);
            // Damaged lengths beyond the end of the data are refused; other damaged numbers are accepted.
            let _ = LedgerRow::default().unpack(&damaged);
        }
    }
}
