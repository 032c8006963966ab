//! Keyword by keyword to the tables of a file.

use std::collections::HashMap;

use super::super::tables::{NodeSet, Shape, Surface, Tables};
use super::super::text::format_of;
use super::lines::{Data, Item, Keyword, Lines};
use super::sets::{Sets, key_of};
use super::types::shape_of;
use crate::mesh::MeshError;
use crate::mesh::file_error::{FileError, FileProblem, Place};

/// Keywords that would change the mesh in a way that is not followed here.
const REFUSED: &[(&str, &str)] = &[
    ("INCLUDE", "it takes lines from another file"),
    ("NGEN", "it makes nodes between others"),
    ("NFILL", "it makes nodes between others"),
    ("NCOPY", "it makes nodes from others"),
    ("NMAP", "it moves nodes"),
    ("ELGEN", "it makes elements from others"),
    ("ELCOPY", "it makes elements from others"),
    ("SYSTEM", "it gives nodes in coordinates of their own"),
    ("PARAMETER", "it computes values of the file"),
];

/// What lines of data belong to.
enum Open {
    /// Nothing that is read.
    Other,
    Nodes {
        set: Option<usize>,
    },
    Elements {
        shape: Shape,
        set: Option<usize>,
        /// Fields of an element that goes on in the next line, and where it began.
        begun: Option<(Vec<u64>, Place)>,
    },
    NodeSet {
        set: usize,
        is_range: bool,
    },
    ElementSet {
        set: usize,
        is_range: bool,
    },
    Surface {
        surface: usize,
    },
    Instance {
        keyword: Keyword,
    },
}

/// A surface whose sets of elements are not looked up yet.
struct Sides {
    name: String,
    at: Place,
    is_internal: bool,
    /// Element or set of elements, and a side or 0.
    sides: Vec<(String, u8)>,
}

struct Reader {
    tables: Tables,
    node_sets: Sets,
    element_sets: Sets,
    surfaces: Vec<Sides>,
    /// Where each element stands in the tables.
    elements: HashMap<u64, (Shape, u32)>,
    parts: usize,
    instances: usize,
    nodes_begin: Option<Place>,
}

/// What an input file holds.
pub(in crate::mesh::files) fn read(content: &[u8]) -> Result<Tables, MeshError> {
    let mut lines = Lines::new(content);
    let mut reader = Reader {
        tables: Tables::default(),
        node_sets: Sets::default(),
        element_sets: Sets::default(),
        surfaces: Vec::new(),
        elements: HashMap::new(),
        parts: 0,
        instances: 0,
        nodes_begin: None,
    };
    let mut open = Open::Other;
    let mut is_first = true;
    while let Some(item) = lines.next()? {
        match item {
            Item::Keyword(keyword) => {
                if is_first && keyword.name == "KEYWORD" {
                    return keyword.fail(FileProblem::OtherFormat { found: "an LS-DYNA input file" });
                }
                reader.close(open, lines.place())?;
                open = reader.open(keyword)?;
            }
            Item::Data(data) if is_first => {
                return Err(FileError { at: data.at, problem: FileProblem::OtherFormat { found: format_of(content) } }.into());
            }
            Item::Data(data) => reader.data(&mut open, &data)?,
        }
        is_first = false;
    }
    reader.close(open, lines.place())?;
    for (begin, section) in [(reader.nodes_begin, "*NODE"), (reader.tables.elements_begin, "*ELEMENT")] {
        if begin.is_none() {
            return Err(FileError { at: lines.place(), problem: FileProblem::MissingSection { section } }.into());
        }
    }
    reader.finish()
}

impl Reader {
    /// What the lines behind a keyword belong to.
    fn open(&mut self, keyword: Keyword) -> Result<Open, MeshError> {
        let refuse = |reason| keyword.fail(FileProblem::Keyword { keyword: keyword.name.clone(), reason });
        if let Some((_, reason)) = REFUSED.iter().find(|(name, _)| *name == keyword.name) {
            return refuse(reason);
        }
        if matches!(&*keyword.name, "NODE" | "ELEMENT" | "NSET" | "ELSET") && keyword.value("INPUT").is_some() {
            return refuse("it takes lines from another file");
        }
        Ok(match &*keyword.name {
            "NODE" => {
                if keyword.value("SYSTEM").is_some_and(|system| !system.eq_ignore_ascii_case("R")) {
                    return refuse("its coordinates are not rectangular");
                }
                self.nodes_begin.get_or_insert(keyword.at);
                Open::Nodes { set: keyword.value("NSET").map(|name| self.node_sets.open(name, &keyword)) }
            }
            "ELEMENT" => {
                let name = keyword.required("TYPE")?;
                let Some(shape) = shape_of(name) else { return keyword.fail(FileProblem::UnsupportedType { name: name.into() }) };
                self.tables.elements_begin.get_or_insert(keyword.at);
                let set = keyword.value("ELSET").map(|name| self.element_sets.open(name, &keyword));
                Open::Elements { shape, set, begun: None }
            }
            "NSET" => {
                let set = self.node_sets.open(keyword.required("NSET")?, &keyword);
                if let Some(elements) = keyword.value("ELSET") {
                    self.node_sets.list[set].of_elements.push(key_of(elements));
                }
                Open::NodeSet { set, is_range: keyword.value("GENERATE").is_some() }
            }
            "ELSET" => {
                let set = self.element_sets.open(keyword.required("ELSET")?, &keyword);
                Open::ElementSet { set, is_range: keyword.value("GENERATE").is_some() }
            }
            "SURFACE" => {
                let name = keyword.required("NAME")?.to_string();
                if keyword.value("COMBINE").is_some() {
                    return refuse("it makes a surface from others");
                }
                match keyword.value("TYPE").map(str::to_ascii_uppercase).as_deref() {
                    None | Some("ELEMENT") => {
                        let is_internal = keyword.value("INTERNAL").is_some();
                        self.surfaces.push(Sides { name, at: keyword.at, is_internal, sides: Vec::new() });
                        Open::Surface { surface: self.surfaces.len() - 1 }
                    }
                    Some("NODE") => Open::NodeSet { set: self.node_sets.open(&name, &keyword), is_range: false },
                    // analytical surfaces are no part of the mesh
                    Some(_) => Open::Other,
                }
            }
            "PART" => {
                self.parts += 1;
                if self.parts > 1 {
                    return refuse("it is a second part, and files of one part are read");
                }
                Open::Other
            }
            "INSTANCE" => {
                self.instances += 1;
                if self.instances > 1 {
                    return refuse("it is a second instance, and files of one part are read");
                }
                Open::Instance { keyword }
            }
            _ => Open::Other,
        })
    }

    /// What was begun must be complete.
    fn close(&mut self, open: Open, at: Place) -> Result<(), MeshError> {
        match open {
            Open::Elements { begun: Some((fields, begin)), shape, .. } => {
                let (found, announced) = (fields.len(), shape.nodes() + 1);
                let problem = FileProblem::Truncated { section: "*ELEMENT".into(), begin, found, announced };
                Err(FileError { at, problem }.into())
            }
            _ => Ok(()),
        }
    }

    /// A line of data.
    fn data(&mut self, open: &mut Open, data: &Data) -> Result<(), MeshError> {
        match open {
            Open::Other => Ok(()),
            Open::Nodes { set } => {
                const EXPECTED: &str = "a node with its number and up to three coordinates";
                let mut fields = data.fields();
                let node = data.number(fields.next(), EXPECTED)?;
                let point = [data.real(fields.next(), EXPECTED)?, data.real(fields.next(), EXPECTED)?, data.real(fields.next(), EXPECTED)?];
                if let Some(set) = set {
                    self.node_sets.add(*set, node);
                }
                self.tables.add_node(node, point, data.at)
            }
            Open::Elements { shape, set, begun } => {
                const EXPECTED: &str = "an element with its number and nodes";
                let (mut fields, at) = begun.take().unwrap_or((Vec::new(), data.at));
                let needed = shape.nodes() + 1;
                for field in data.fields() {
                    fields.push(data.number(Some(field), EXPECTED)?);
                    if fields.len() > needed {
                        return data.malformed(EXPECTED);
                    }
                }
                if fields.len() < needed {
                    if !data.goes_on() {
                        return data.malformed(EXPECTED);
                    }
                    *begun = Some((fields, at));
                    return Ok(());
                }
                let (number, nodes) = (fields[0], &fields[1..]);
                let place = self.tables.elements.get(shape).map_or(0, |elements| elements.numbers.len() as u32);
                if let Some((shape, before)) = self.elements.insert(number, (*shape, place)) {
                    let first = self.tables.element_place(&self.tables.elements[&shape], before as usize);
                    return Err(FileError { at, problem: FileProblem::DuplicateElement { element: number, first } }.into());
                }
                let order = shape.row().map_or(&[][..], |row| row.abaqus_order);
                self.tables.add_element(*shape, number, 0, (nodes, order), at);
                if let Some(set) = set {
                    self.element_sets.add(*set, number);
                }
                Ok(())
            }
            Open::NodeSet { set, is_range } => self.node_sets.add_line(*set, data, *is_range),
            Open::ElementSet { set, is_range } => self.element_sets.add_line(*set, data, *is_range),
            Open::Surface { surface } => {
                const EXPECTED: &str = "an element or a set of elements, and a side from S1 to S6";
                let mut fields = data.fields();
                let owner = fields.next().unwrap_or_default().to_string();
                let side = match fields.next() {
                    None | Some("") => 0,
                    Some(side) => match side.to_ascii_uppercase().strip_prefix('S').and_then(|number| number.parse().ok()) {
                        Some(number @ 1..=6) => number,
                        _ => return data.malformed(EXPECTED),
                    },
                };
                self.surfaces[*surface].sides.push((owner, side));
                Ok(())
            }
            Open::Instance { keyword } => {
                keyword.fail(FileProblem::Keyword { keyword: keyword.name.clone(), reason: "it moves the part by the numbers behind it" })
            }
        }
    }

    /// Looks up what sets and surfaces name.
    fn finish(mut self) -> Result<Tables, MeshError> {
        let mut all: Vec<u64> = self.elements.keys().copied().collect();
        all.sort_unstable();
        let mut groups: HashMap<u64, Vec<u64>> = HashMap::new();
        for (place, set) in self.element_sets.list.iter().enumerate().filter(|(_, set)| !set.is_internal) {
            let group = place as u64 + 1;
            for number in self.element_sets.numbers(place, "element set", &all)? {
                if !self.elements.contains_key(&number) {
                    let problem = FileProblem::UnknownMember { owner: "element set", name: set.name.clone(), kind: "element", number };
                    return Err(FileError { at: set.at, problem }.into());
                }
                groups.entry(number).or_default().push(group);
            }
            self.tables.names.extend((0..=3).map(|dimension| ((dimension, group), set.name.clone())));
        }
        // the list that belongs to no group, for all others
        self.tables.groups_index(Vec::new());
        let mut list_of: HashMap<u64, u32> = HashMap::new();
        for (number, list) in groups {
            list_of.insert(number, self.tables.groups_index(list));
        }
        for elements in self.tables.elements.values_mut() {
            for (number, groups) in elements.numbers.iter().zip(&mut elements.groups) {
                *groups = list_of.get(number).copied().unwrap_or(0);
            }
        }
        self.finish_node_sets()?;
        self.finish_surfaces(&all)?;
        Ok(self.tables)
    }

    fn finish_node_sets(&mut self) -> Result<(), MeshError> {
        let mut all = self.tables.node_numbers.clone();
        all.sort_unstable();
        let mut elements: Vec<u64> = self.elements.keys().copied().collect();
        elements.sort_unstable();
        for (place, set) in self.node_sets.list.iter().enumerate().filter(|(_, set)| !set.is_internal) {
            let mut nodes = self.node_sets.numbers(place, "node set", &all)?;
            for owner in &set.of_elements {
                let Some(owner) = self.element_sets.find(owner) else {
                    let problem = FileProblem::UnknownSet { kind: "element set", name: owner.clone() };
                    return Err(FileError { at: set.at, problem }.into());
                };
                for number in self.element_sets.numbers(owner, "element set", &elements)? {
                    if let Some((shape, index)) = self.elements.get(&number) {
                        let count = shape.nodes();
                        nodes.extend(&self.tables.elements[shape].nodes[*index as usize * count..][..count]);
                    }
                }
            }
            let nodes = nodes.into_iter().collect();
            self.tables.node_sets.push(NodeSet { name: set.name.clone(), at: set.at, nodes });
        }
        Ok(())
    }

    fn finish_surfaces(&mut self, all: &[u64]) -> Result<(), MeshError> {
        for surface in self.surfaces.iter().filter(|surface| !surface.is_internal) {
            let mut sides = Vec::new();
            for (owner, side) in &surface.sides {
                let own = key_of(owner);
                match (own.parse(), self.element_sets.find(&own)) {
                    (Ok(number), _) => sides.push((number, *side)),
                    (_, Some(set)) => {
                        sides.extend(self.element_sets.numbers(set, "element set", all)?.into_iter().map(|number| (number, *side)));
                    }
                    _ => {
                        let problem = FileProblem::UnknownSet { kind: "element set", name: owner.clone() };
                        return Err(FileError { at: surface.at, problem }.into());
                    }
                }
            }
            self.tables.surfaces.push(Surface { name: surface.name.clone(), at: surface.at, sides });
        }
        Ok(())
    }
}
