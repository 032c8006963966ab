//! The content of an input file, scope by scope, and tables of a mesh from some of its scopes.

use std::cell::OnceCell;
use std::collections::{BTreeSet, HashMap};

use super::super::numbering::Numbering;
use super::super::options::FileNote;
use super::super::tables::{Appended, NodeSet, Surface, Tables};
use super::definitions::Definitions;
use super::includes::Origins;
use super::scope::{Kind, Scope};
use super::sets::{Member, key_of};
use crate::mesh::MeshError;
use crate::mesh::file_error::{FileError, FileProblem};

/// A number with the scope to which it belongs.
type Owned = (usize, u64);

/// Contents of an input file.
pub(super) struct Contents {
    /// Scope of the content outside of parts, then one scope per part instance (per part in a file without an assembly).
    pub scopes: Vec<Scope>,
    pub definitions: Definitions,
    pub notes: Vec<FileNote>,
    pub origins: Origins,
    /// All numbers of each scope in ascending order.
    all: OnceCell<Vec<[Vec<u64>; 2]>>,
}

impl Default for Contents {
    fn default() -> Contents {
        let (definitions, notes, origins) = Default::default();
        Contents { scopes: vec![Scope::default()], definitions, notes, origins, all: OnceCell::new() }
    }
}

impl Contents {
    /// The scope of an instance.
    pub fn instance(&self, key: &str) -> Option<usize> {
        (1..self.scopes.len()).find(|&scope| key_of(&self.scopes[scope].name) == key)
    }

    /// All numbers of a scope in ascending order.
    fn all(&self, scope: usize, kind: Kind) -> &[u64] {
        let of_scope = |scope: &Scope| [Kind::Nodes, Kind::Elements].map(|kind| scope.numbers(kind));
        &self.all.get_or_init(|| self.scopes.iter().map(of_scope).collect())[scope][kind as usize]
    }

    /// Scopes with nodes or elements.
    pub fn used(&self) -> Vec<usize> {
        (0..self.scopes.len()).filter(|&scope| self.scopes[scope].has_content()).collect()
    }

    /// Splits a name such as `instance.rest` if the text before a dot is an instance of the file.
    fn of_instance<'n>(&self, name: &'n str) -> Option<(usize, &'n str)> {
        let cuts = name.match_indices('.').map(|(at, _)| (&name[..at], &name[at + 1..]));
        cuts.filter_map(|(instance, rest)| Some((self.instance(&key_of(instance))?, rest))).next()
    }

    /// Finds the set of a name that is visible in a scope, with the scope to which it belongs.
    fn find(&self, kind: Kind, scope: usize, name: &str) -> Option<(usize, usize)> {
        let own = |scope: usize, name: &str| Some((scope, self.scopes[scope].sets(kind).find(name)?));
        own(scope, name).or_else(|| self.of_instance(name).and_then(|(scope, rest)| own(scope, rest)))
    }

    /// Splits a name of the assembly into an instance, if any, and the name in the instance.
    pub fn in_scope<'n>(&self, name: &'n str) -> (Option<usize>, &'n str) {
        let name = name.trim_matches('"');
        self.of_instance(name).map_or((None, name), |(scope, rest)| (Some(scope), rest))
    }

    /// Numbers of a set in ascending order; of a range those that exist.
    fn numbers(&self, kind: Kind, scope: usize, set: usize) -> Result<BTreeSet<Owned>, MeshError> {
        let (mut numbers, mut seen, mut waiting) = (BTreeSet::new(), BTreeSet::from([(scope, set)]), vec![(scope, set)]);
        while let Some((scope, set)) = waiting.pop() {
            let current = &self.scopes[scope].sets(kind).list[set];
            for (owner, member) in &current.members {
                let owner = owner.unwrap_or(scope);
                match member {
                    Member::Number(number) => drop(numbers.insert((owner, *number))),
                    Member::Range([first, last, step]) => {
                        let all = self.all(owner, kind);
                        let begin = all.partition_point(|number| number < first);
                        let within = all[begin..].iter().take_while(|number| *number <= last);
                        numbers.extend(within.filter(|number| (*number - first).is_multiple_of(*step)).map(|&number| (owner, number)));
                    }
                    Member::Name(name) => match (self.find(kind, owner, name), self.of_instance(name)) {
                        // A set that was visited already (a set may contain itself) adds nothing.
                        (Some(other), _) if seen.insert(other) => waiting.push(other),
                        (Some(_), _) => {}
                        (None, Some((owner, number))) if number.parse::<u64>().is_ok() => {
                            numbers.extend(number.parse().ok().map(|number| (owner, number)));
                        }
                        _ => {
                            let problem = FileProblem::UnknownSet { kind: kind.of_set(), name: name.clone() };
                            return Err(FileError { at: current.at, problem }.into());
                        }
                    },
                }
            }
        }
        Ok(numbers)
    }

    /// Tables of the nodes and elements of some scopes, with their sets and surfaces.
    pub fn tables(&self, used: &[usize]) -> Result<Tables, MeshError> {
        let mut merged = Merged::new(&self.scopes, used)?;
        self.groups(used, &mut merged)?;
        for scope in self.in_order() {
            self.node_sets(scope, used, &mut merged)?;
            self.surfaces(scope, used, &mut merged)?;
        }
        Ok(merged.tables)
    }

    /// Scopes in the order of the file: instances before the statements of the assembly about them.
    fn in_order(&self) -> impl Iterator<Item = usize> {
        (1..self.scopes.len()).chain([0])
    }

    /// Name of a set for the mesh: its own name, preceded by the name of its instance if other instances of the mesh may have a set of this
    /// name.
    fn label(&self, scope: usize, name: &str, used: &[usize], is_taken: impl Fn(&str) -> bool) -> String {
        let name = name.trim_matches('"');
        let is_alone = used.iter().filter(|&&other| other > 0).count() <= 1;
        if scope == 0 || is_alone && !is_taken(&key_of(name)) { name.into() } else { format!("{}.{name}", self.scopes[scope].name) }
    }

    /// Lists of the sets of each element; several instances are groups, too.
    fn groups(&self, used: &[usize], merged: &mut Merged) -> Result<(), MeshError> {
        let mut groups: HashMap<u64, Vec<u64>> = HashMap::new();
        let mut group = 0;
        let mut add = |name: String, numbers: Vec<u64>, tables: &mut Tables| {
            group += 1;
            numbers.into_iter().for_each(|number| groups.entry(number).or_default().push(group));
            tables.names.extend((0..=3).map(|dimension| ((dimension, group), name.clone())));
        };
        if used.iter().filter(|&&scope| scope > 0).count() > 1 {
            for &scope in used.iter().filter(|&&scope| scope > 0) {
                let own = self.all(scope, Kind::Elements).iter();
                let numbers: Vec<u64> = own.filter_map(|&number| merged.element(scope, number)).collect();
                add(self.scopes[scope].name.clone(), numbers, &mut merged.tables);
            }
        }
        for scope in self.in_order() {
            for (place, set) in self.scopes[scope].named_sets(Kind::Elements) {
                let mut numbers = Vec::new();
                for (owner, number) in self.numbers(Kind::Elements, scope, place)? {
                    let own = &self.scopes[owner];
                    if !own.elements.contains_key(&number) && !own.structural.contains(&number) {
                        let problem = FileProblem::UnknownMember { owner: "element set", name: set.name.clone(), kind: "element", number };
                        return Err(FileError { at: set.at, problem }.into());
                    }
                    numbers.extend(merged.element(owner, number));
                }
                let is_taken = |key: &str| self.scopes[0].named_sets(Kind::Elements).any(|(_, set)| key_of(&set.name) == key);
                add(self.label(scope, &set.name, used, is_taken), numbers, &mut merged.tables);
            }
        }
        let tables = &mut merged.tables;
        // Empty list of groups, for the elements that belong to no set.
        tables.groups_index(Vec::new());
        let mut list_of: HashMap<u64, u32> = HashMap::new();
        let mut lists: Vec<(u64, Vec<u64>)> = groups.into_iter().collect();
        lists.sort_unstable();
        for (number, list) in lists {
            list_of.insert(number, tables.groups_index(list));
        }
        for elements in tables.elements.values_mut() {
            for (number, groups) in elements.numbers.iter().zip(&mut elements.groups) {
                *groups = list_of.get(number).copied().unwrap_or(0);
            }
        }
        Ok(())
    }

    fn node_sets(&self, scope: usize, used: &[usize], merged: &mut Merged) -> Result<(), MeshError> {
        for (place, set) in self.scopes[scope].named_sets(Kind::Nodes) {
            let mut nodes = self.numbers(Kind::Nodes, scope, place)?;
            for (owner, name) in &set.of_elements {
                let Some((owner, elements)) = self.find(Kind::Elements, owner.unwrap_or(scope), name) else {
                    let problem = FileProblem::UnknownSet { kind: "element set", name: name.clone() };
                    return Err(FileError { at: set.at, problem }.into());
                };
                for (owner, number) in self.numbers(Kind::Elements, owner, elements)? {
                    nodes.extend(self.scopes[owner].nodes_of(number).iter().map(|&node| (owner, node)));
                }
            }
            let mut numbers = Vec::new();
            for (owner, number) in nodes {
                if self.all(owner, Kind::Nodes).binary_search(&number).is_err() {
                    let problem = FileProblem::UnknownMember { owner: "node set", name: set.name.clone(), kind: "node", number };
                    return Err(FileError { at: set.at, problem }.into());
                }
                numbers.extend(merged.node(owner, number));
            }
            let is_taken = |key: &str| self.scopes[0].named_sets(Kind::Nodes).any(|(_, set)| key_of(&set.name) == key);
            let name = self.label(scope, &set.name, used, is_taken);
            merged.tables.node_sets.push(NodeSet { name, at: set.at, nodes: numbers });
        }
        Ok(())
    }

    fn surfaces(&self, scope: usize, used: &[usize], merged: &mut Merged) -> Result<(), MeshError> {
        for surface in self.scopes[scope].surfaces.iter().filter(|surface| !surface.is_internal) {
            let mut sides = Vec::new();
            let mut has_others = false;
            for (written, side, at) in &surface.sides {
                let fail = |problem| Err(FileError { at: *at, problem }.into());
                let key = key_of(written);
                let of_instance = self.of_instance(&key);
                let set = self.find(Kind::Elements, scope, &key);
                let number = |text: &str| text.parse::<u64>().ok();
                let members: Vec<Owned> = match (number(&key), set, of_instance.and_then(|(scope, rest)| Some((scope, number(rest)?)))) {
                    (Some(number), ..) => vec![(scope, number)],
                    (None, Some((scope, set)), _) => self.numbers(Kind::Elements, scope, set)?.into_iter().collect(),
                    (None, None, Some(member)) => vec![member],
                    _ => return fail(FileProblem::UnknownSet { kind: "element set", name: written.clone() }),
                };
                for (owner, number) in members {
                    let own = &self.scopes[owner];
                    if own.structural.contains(&number) || own.tables.structural.contains(&number) {
                        has_others = true;
                        continue;
                    }
                    let side = match side.to_ascii_uppercase().strip_prefix('S').map(str::parse) {
                        None if side.is_empty() => 0,
                        Some(Ok(number @ 1..=6)) => number,
                        _ => {
                            let expected = "an element or a set of elements, and a side from S1 to S6";
                            return fail(FileProblem::Malformed { expected, found: format!("{written}, {side}") });
                        }
                    };
                    if !own.elements.contains_key(&number) {
                        let name = surface.name.clone();
                        return fail(FileProblem::UnknownMember { owner: "surface", name, kind: "element", number });
                    }
                    match merged.element(owner, number) {
                        Some(number) => sides.push((number, side, *at)),
                        None => has_others = true,
                    }
                }
            }
            if sides.is_empty() && has_others {
                continue;
            }
            let is_taken = |key: &str| self.scopes[0].surfaces.iter().any(|known| !known.is_internal && key_of(&known.name) == key);
            let name = self.label(scope, &surface.name, used, is_taken);
            merged.tables.surfaces.push(Surface { name, sides });
        }
        Ok(())
    }
}

/// Tables of one or several scopes. With several scopes, nodes and elements get new numbers.
struct Merged {
    tables: Tables,
    /// New numbers by scope and number.
    new: HashMap<(Kind, usize, u64), u64>,
    /// Single scope, whose numbers are kept; `None` if there are several.
    alone: Option<usize>,
}

impl Merged {
    fn new(scopes: &[Scope], used: &[usize]) -> Result<Merged, MeshError> {
        if let &[alone] = used {
            return Ok(Merged { tables: scopes[alone].tables.clone(), new: HashMap::new(), alone: Some(alone) });
        }
        let mut merged = Merged { tables: Tables::default(), new: HashMap::new(), alone: None };
        for &scope in used {
            Numbering::new(&scopes[scope].tables)?.check(&scopes[scope].tables)?;
            let Appended { nodes, elements } = merged.tables.append(&scopes[scope].tables);
            merged.new.extend(nodes.into_iter().map(|(old, new)| ((Kind::Nodes, scope, old), new)));
            merged.new.extend(elements.into_iter().map(|(old, new)| ((Kind::Elements, scope, old), new)));
        }
        Ok(merged)
    }

    fn number(&self, kind: Kind, scope: usize, number: u64) -> Option<u64> {
        match self.alone {
            Some(alone) => (alone == scope).then_some(number),
            None => self.new.get(&(kind, scope, number)).copied(),
        }
    }

    fn node(&self, scope: usize, number: u64) -> Option<u64> {
        self.number(Kind::Nodes, scope, number)
    }

    /// The number of an element with a shape.
    fn element(&self, scope: usize, number: u64) -> Option<u64> {
        self.number(Kind::Elements, scope, number)
    }
}
