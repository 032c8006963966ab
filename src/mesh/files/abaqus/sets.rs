//! Sets of numbers: listed, as ranges, and as other sets.

use std::collections::BTreeMap;

use super::lines::{Data, Keyword};
use crate::mesh::MeshError;
use crate::mesh::file_error::FilePosition;

/// Member of a set.
#[derive(Clone)]
pub(super) enum Member {
    Number(u64),
    /// Range of numbers: first, last, increment.
    Range([u64; 3]),
    /// Another set in lower case, or a number after the name of an instance.
    Name(String),
}

/// A set of nodes or elements.
#[derive(Clone)]
pub(super) struct Set {
    /// Name as written at the first occurrence.
    pub name: String,
    /// Place of the first definition.
    pub at: FilePosition,
    /// True if the set is internal to the input file: marked `INTERNAL`, or a name with a leading underscore.
    pub is_internal: bool,
    /// Members of the set, each with the scope named by the keyword; `None`: the scope of the set.
    pub members: Vec<(Option<usize>, Member)>,
    /// For sets of nodes: sets of elements whose nodes belong to it.
    pub of_elements: Vec<(Option<usize>, String)>,
}

/// All sets of one kind, in the order of the file; names are compared without case.
#[derive(Clone, Default)]
pub(super) struct Sets {
    pub list: Vec<Set>,
    places: BTreeMap<String, usize>,
}

/// Key for comparisons of names of sets, parts and instances: in lower case, without quotation marks.
pub(super) fn key_of(name: &str) -> String {
    name.replace('"', "").to_lowercase()
}

impl Sets {
    /// Set with a name, which is created if missing.
    pub fn open(&mut self, name: &str, keyword: &Keyword) -> usize {
        let next = self.list.len();
        let place = *self.places.entry(key_of(name)).or_insert(next);
        if place == next {
            let is_internal = keyword.value("INTERNAL").is_some() || name.starts_with('_');
            self.list.push(Set { name: name.into(), at: keyword.at, is_internal, members: Vec::new(), of_elements: Vec::new() });
        }
        place
    }

    /// Adds a number to a set.
    pub fn add(&mut self, set: usize, number: u64) {
        self.list[set].members.push((None, Member::Number(number)));
    }

    /// Reads a data line of a set whose numbers belong to a scope.
    pub fn add_line(&mut self, set: usize, data: &Data, is_range: bool, scope: Option<usize>) -> Result<(), MeshError> {
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
            self.list[set].members.push((scope, Member::Range([first, last, step])));
            return Ok(());
        }
        data.fields().filter(|field| !field.is_empty()).for_each(|field| self.add_field(set, field, scope));
        Ok(())
    }

    /// Adds a number or name to a set.
    pub fn add_field(&mut self, set: usize, field: &str, scope: Option<usize>) {
        let member = field.parse().map_or_else(|_| Member::Name(key_of(field)), Member::Number);
        self.list[set].members.push((scope, member));
    }

    /// Set with a name.
    pub fn find(&self, key: &str) -> Option<usize> {
        self.places.get(key).copied()
    }
}
