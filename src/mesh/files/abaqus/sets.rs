//! Sets of numbers: listed, as ranges, and as other sets.

use std::collections::{BTreeMap, BTreeSet};

use super::lines::{Data, Keyword};
use crate::mesh::MeshError;
use crate::mesh::file_error::{FileError, FileProblem, Place};

/// What a set names.
#[derive(Clone)]
enum Member {
    Number(u64),
    /// First, last, step.
    Range([u64; 3]),
    /// Another set, in small letters.
    Set(String),
}

/// A set of nodes or elements.
pub(super) struct Set {
    /// As it was written first.
    pub name: String,
    /// Where it was begun.
    pub at: Place,
    /// Whether the file keeps it for its own use.
    pub is_internal: bool,
    members: Vec<Member>,
    /// For sets of nodes: sets of elements whose nodes belong to it.
    pub of_elements: Vec<String>,
}

/// All sets of one kind, in the order of the file; names are compared without case.
#[derive(Default)]
pub(super) struct Sets {
    pub list: Vec<Set>,
    places: BTreeMap<String, usize>,
}

/// The name in small letters, without the instance before a point.
pub(super) fn key_of(name: &str) -> String {
    let name = name.trim_matches('"');
    name.rsplit_once('.').map_or(name, |(_, own)| own).to_lowercase()
}

impl Sets {
    /// The set of that name, which is begun here if it is not there yet.
    pub fn open(&mut self, name: &str, keyword: &Keyword) -> usize {
        let next = self.list.len();
        let place = *self.places.entry(key_of(name)).or_insert(next);
        if place == next {
            let is_internal = keyword.value("INTERNAL").is_some() || name.starts_with('_');
            let name = name.rsplit_once('.').map_or(name, |(_, own)| own).to_string();
            self.list.push(Set { name, at: keyword.at, is_internal, members: Vec::new(), of_elements: Vec::new() });
        }
        place
    }

    /// One more number for a set.
    pub fn add(&mut self, set: usize, number: u64) {
        self.list[set].members.push(Member::Number(number));
    }

    /// A line of data of a set.
    pub fn add_line(&mut self, set: usize, data: &Data, is_range: bool) -> Result<(), MeshError> {
        if is_range {
            const EXPECTED: &str = "the first and the last number of a range, and its step";
            let mut fields = data.fields();
            let (first, last) = (data.number(fields.next(), EXPECTED)?, data.number(fields.next(), EXPECTED)?);
            let step = match fields.next() {
                None | Some("") => 1,
                step => data.number(step, EXPECTED)?,
            };
            if step == 0 || last < first || fields.next().is_some() {
                return data.malformed(EXPECTED);
            }
            self.list[set].members.push(Member::Range([first, last, step]));
            return Ok(());
        }
        for field in data.fields().filter(|field| !field.is_empty()) {
            let own = field.rsplit_once('.').map_or(field, |(_, own)| own);
            let member = own.parse().map_or_else(|_| Member::Set(key_of(field)), Member::Number);
            self.list[set].members.push(member);
        }
        Ok(())
    }

    /// The set of that name.
    pub fn find(&self, key: &str) -> Option<usize> {
        self.places.get(key).copied()
    }

    /// The numbers of a set in ascending order; of a range those that are among the ascending numbers that there are.
    pub fn numbers(&self, set: usize, kind: &'static str, all: &[u64]) -> Result<BTreeSet<u64>, MeshError> {
        let (mut numbers, mut seen, mut waiting) = (BTreeSet::new(), BTreeSet::from([set]), vec![set]);
        while let Some(current) = waiting.pop() {
            for member in &self.list[current].members {
                match member {
                    Member::Number(number) => drop(numbers.insert(*number)),
                    Member::Range([first, last, step]) => {
                        let begin = all.partition_point(|number| number < first);
                        let within = all[begin..].iter().take_while(|number| *number <= last);
                        numbers.extend(within.filter(|number| (*number - first).is_multiple_of(*step)));
                    }
                    Member::Set(name) => match self.find(name) {
                        // a set that names itself has no more for it
                        Some(other) if seen.insert(other) => waiting.push(other),
                        Some(_) => {}
                        None => {
                            let problem = FileProblem::UnknownSet { kind, name: name.clone() };
                            return Err(FileError { at: self.list[current].at, problem }.into());
                        }
                    },
                }
            }
        }
        Ok(numbers)
    }
}
