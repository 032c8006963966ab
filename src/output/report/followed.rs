//! A growing list of which readers have different older states; entries can be thinned and removed.
//!
//! Every change has a number, and each entry the number of the change that added it. A reader sends the last number it has received, and
//! gets the entries added later, and the numbers of the remaining entries if some were dropped since.

/// Entries with the numbers of the changes that added these.
#[derive(Clone, Debug)]
pub struct TrackedEntries<T> {
    entries: Vec<(u64, T)>,
    dropped: u64,
}

/// Changes that a reader has not received.
#[derive(Clone, Debug, PartialEq)]
pub struct Changes<T> {
    /// Numbers of all remaining entries, if entries were dropped that the reader may have.
    pub left: Option<Vec<u64>>,
    /// Entries that the reader does not have, with their numbers.
    pub added: Vec<(u64, T)>,
}

impl<T> Default for TrackedEntries<T> {
    fn default() -> Self {
        TrackedEntries { entries: Vec::new(), dropped: 0 }
    }
}

impl<T: Clone> TrackedEntries<T> {
    /// Adds an entry with the change `number`, which exceeds all earlier ones.
    pub fn push(&mut self, number: u64, entry: T) {
        self.entries.push((number, entry));
    }

    /// Drops entries with the change `number`.
    pub fn retain(&mut self, number: u64, mut keeps: impl FnMut(&T) -> bool) {
        let before = self.entries.len();
        self.entries.retain(|(_, entry)| keeps(entry));
        if self.entries.len() < before {
            self.dropped = number;
        }
    }

    /// The entries with their numbers.
    pub fn entries(&self) -> &[(u64, T)] {
        &self.entries
    }

    /// Returns the changes after the change number `known`.
    pub fn since(&self, known: u64) -> Changes<T> {
        let left = (self.dropped > known).then(|| self.entries.iter().map(|(number, _)| *number).collect());
        let first = self.entries.partition_point(|(number, _)| *number <= known);
        Changes { left, added: self.entries[first..].to_vec() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reader_of_any_age_comes_to_the_same_list() {
        let mut list: TrackedEntries<u64> = TrackedEntries::default();
        let mut readers: Vec<(u64, Vec<(u64, u64)>)> = vec![(0, Vec::new())];
        for number in 1..200u64 {
            match number % 17 {
                0 => list.retain(number, |entry| entry % 2 == 0),
                5 => list.retain(number, |entry| *entry + 20 < number),
                _ => list.push(number, number * 7 % 31),
            }
            readers.push((number, list.entries().to_vec()));
        }
        for (known, mut has) in readers {
            let Changes { left, added } = list.since(known);
            if let Some(left) = left {
                has.retain(|(number, _)| left.contains(number));
            }
            has.extend(added);
            assert_eq!(has, list.entries(), "known: {known}");
        }
        assert_eq!(list.since(199), Changes { left: None, added: Vec::new() });
    }
}
