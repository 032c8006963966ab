//! A list that grows, is thinned and cut, and of which each reader has an older state.
//!
//! Every change has a number. An entry has that of the change that added it, so a reader who tells the last number that it knows gets the
//! entries behind it, and the numbers of those that are left where some were dropped since.

/// Entries with the numbers of the changes that added them.
#[derive(Clone, Debug)]
pub struct Followed<T> {
    entries: Vec<(u64, T)>,
    dropped: u64,
}

/// What a reader does not know yet.
#[derive(Clone, Debug, PartialEq)]
pub struct News<T> {
    /// Numbers of all entries that are left, where some were dropped that the reader may have.
    pub left: Option<Vec<u64>>,
    /// Entries that it does not have, with their numbers.
    pub added: Vec<(u64, T)>,
}

impl<T> Default for Followed<T> {
    fn default() -> Self {
        Followed { entries: Vec::new(), dropped: 0 }
    }
}

impl<T: Clone> Followed<T> {
    /// Adds an entry with the change `number`, which is above all before.
    pub fn push(&mut self, number: u64, entry: T) {
        self.entries.push((number, entry));
    }

    /// Drops with the change `number` what is not to be kept.
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

    /// What is new to a reader who knows the changes up to `known`.
    pub fn since(&self, known: u64) -> News<T> {
        let left = (self.dropped > known).then(|| self.entries.iter().map(|(number, _)| *number).collect());
        let first = self.entries.partition_point(|(number, _)| *number <= known);
        News { left, added: self.entries[first..].to_vec() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reader_of_any_age_comes_to_the_same_list() {
        let mut list: Followed<u64> = Followed::default();
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
            let News { left, added } = list.since(known);
            if let Some(left) = left {
                has.retain(|(number, _)| left.contains(number));
            }
            has.extend(added);
            assert_eq!(has, list.entries(), "known: {known}");
        }
        assert_eq!(list.since(199), News { left: None, added: Vec::new() });
    }
}
