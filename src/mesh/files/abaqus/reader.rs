//! Reading of keywords into the scopes of a file.

use super::super::options::{FileNote, Includes};
use super::super::tables::Shape;
use super::super::text::format_of;
use super::contents::Contents;
use super::definitions::Statement;
use super::includes::Text;
use super::lines::{Data, Item, Keyword, Lines};
use super::scope::{Scope, Sides};
use super::sets::key_of;
use super::types::{ElementType, Family, type_of};
use crate::mesh::MeshError;
use crate::mesh::file_error::{FileError, FilePosition, FileProblem};

/// Keywords that change the mesh in a way that is not supported.
const REFUSED: &[(&str, &str)] = &[
    ("NGEN", "it makes nodes between others"),
    ("NFILL", "it makes nodes between others"),
    ("NCOPY", "it makes nodes from others"),
    ("NMAP", "it moves nodes"),
    ("ELGEN", "it makes elements from others"),
    ("ELCOPY", "it makes elements from others"),
    ("SYSTEM", "it gives nodes in coordinates of their own"),
];

/// Scope that keywords refer to.
#[derive(Clone, Copy)]
enum Current {
    Rest,
    Part(usize),
    Instance(usize),
}

/// Keyword block that the current data lines belong to.
enum Open {
    /// Ignored keyword.
    Other,
    Nodes {
        set: Option<usize>,
    },
    Elements {
        shape: Shape,
        set: Option<usize>,
        /// True if the elements are no plane or solid cells.
        is_structural: bool,
        /// Fields of an element that continues in the next line, and its first line.
        begun: Option<Begun>,
    },
    /// Elements without a cell shape, such as springs and masses.
    Structural {
        name: String,
        set: Option<usize>,
        goes_on: bool,
    },
    NodeSet {
        set: usize,
        is_range: bool,
        scope: Option<usize>,
    },
    ElementSet {
        set: usize,
        is_range: bool,
        scope: Option<usize>,
    },
    /// Nodes of a surface, each with its area.
    NodeSurface {
        set: usize,
    },
    Surface {
        surface: usize,
    },
    /// Number of translation and rotation lines of an instance that have been read so far.
    Placing {
        lines: usize,
    },
    Statement(Statement),
}

/// An element whose lines have not all been read.
struct Begun {
    fields: Vec<u64>,
    at: FilePosition,
    /// True if every line so far ends with a comma, as Abaqus demands; CalculiX reads on until the last node without it.
    has_commas: bool,
}

struct Reader {
    contents: Contents,
    parts: Vec<Scope>,
    current: Current,
}

/// Reads the blocks of an Abaqus input file and of the files it includes.
pub(super) fn read(content: &[u8], includes: Includes) -> Result<Contents, MeshError> {
    let text = Text::new(content, includes)?;
    match read_lines(&text.content) {
        Ok(mut contents) => {
            contents.origins = text.origins;
            Ok(contents)
        }
        Err(error) => Err(text.origins.located(error)),
    }
}

fn read_lines(content: &[u8]) -> Result<Contents, MeshError> {
    let mut lines = Lines::new(content);
    let mut reader = Reader { contents: Contents::default(), parts: Vec::new(), current: Current::Rest };
    let mut open = Open::Other;
    let mut is_first = true;
    while let Some(item) = lines.next()? {
        match item {
            Item::Keyword(keyword) => {
                if is_first && keyword.name == "KEYWORD" {
                    return keyword.fail(FileProblem::OtherFormat { found: "an LS-DYNA input file" });
                }
                reader.close(open)?;
                open = reader.open(keyword)?;
            }
            Item::Data(data) if is_first => {
                return Err(FileError { at: data.at, problem: FileProblem::OtherFormat { found: format_of(content) } }.into());
            }
            Item::Data(data) => reader.data(&mut open, &data)?,
        }
        is_first = false;
    }
    reader.close(open)?;
    let Reader { mut contents, parts, .. } = reader;
    if contents.scopes.len() == 1 {
        // In a file without an assembly, parts are used directly.
        contents.scopes.extend(parts);
    }
    let has = |what: fn(&Scope) -> bool| contents.scopes.iter().any(what);
    let has_elements = has(|scope| !scope.elements.is_empty() || !scope.structural.is_empty());
    for (is_there, section) in [(has(|scope| !scope.tables.node_numbers.is_empty()), "*NODE"), (has_elements, "*ELEMENT")] {
        if !is_there {
            return Err(FileError { at: lines.place(), problem: FileProblem::MissingSection { section } }.into());
        }
    }
    Ok(contents)
}

impl Begun {
    /// Error of an element that has fewer nodes than its shape.
    fn fail<T>(&self, shape: Shape) -> Result<T, MeshError> {
        let problem = FileProblem::FewNodes { element: self.fields[0], found: self.fields.len() - 1, nodes: shape.nodes() };
        Err(FileError { at: self.at, problem }.into())
    }
}

impl Reader {
    /// Ends the lines of a keyword; a cell whose lines end before its last node is an error.
    fn close(&mut self, open: Open) -> Result<(), MeshError> {
        match open {
            Open::Elements { begun: Some(Begun { fields, at, .. }), shape, set, is_structural: true } => {
                self.element(shape, &fields, set, at)
            }
            Open::Elements { begun: Some(begun), shape, .. } => begun.fail(shape),
            _ => Ok(()),
        }
    }

    /// Keeps an element; an element with fewer nodes than its shape is recorded as structural and left out.
    fn element(&mut self, shape: Shape, fields: &[u64], set: Option<usize>, at: FilePosition) -> Result<(), MeshError> {
        let (number, scope) = (fields[0], self.scope());
        if let Some(nodes) = fields.get(1..=shape.nodes()) {
            scope.add_element(shape, number, nodes, at)?;
        } else {
            scope.structural.insert(number);
            scope.tables.leave_out(shape, 1, at);
        }
        if let Some(set) = set {
            scope.element_sets.add(set, number);
        }
        Ok(())
    }

    fn scope(&mut self) -> &mut Scope {
        match self.current {
            Current::Rest => &mut self.contents.scopes[0],
            Current::Part(part) => &mut self.parts[part],
            Current::Instance(scope) => &mut self.contents.scopes[scope],
        }
    }

    /// Object to which the data lines of a keyword belong.
    fn open(&mut self, keyword: Keyword) -> Result<Open, MeshError> {
        let refuse = |reason| keyword.fail(FileProblem::Keyword { keyword: keyword.name.clone(), reason });
        if let Some((_, reason)) = REFUSED.iter().find(|(name, _)| *name == keyword.name) {
            return refuse(reason);
        }
        Ok(match &*keyword.name {
            "NODE" => {
                if keyword.value("SYSTEM").is_some_and(|system| !system.eq_ignore_ascii_case("R")) {
                    return refuse("its coordinates are not rectangular");
                }
                Open::Nodes { set: keyword.value("NSET").map(|name| self.scope().node_sets.open(name, &keyword)) }
            }
            "ELEMENT" => self.open_elements(&keyword)?,
            "NSET" => {
                let (scope, name) = (self.instance_of(&keyword)?, keyword.required("NSET")?);
                let sets = &mut self.scope().node_sets;
                let set = sets.open(name, &keyword);
                sets.list[set].of_elements.extend(keyword.value("ELSET").map(|elements| (scope, key_of(elements))));
                Open::NodeSet { set, is_range: keyword.value("GENERATE").is_some(), scope }
            }
            "ELSET" => {
                let (scope, name) = (self.instance_of(&keyword)?, keyword.required("ELSET")?);
                let set = self.scope().element_sets.open(name, &keyword);
                Open::ElementSet { set, is_range: keyword.value("GENERATE").is_some(), scope }
            }
            "SURFACE" => {
                let name = keyword.required("NAME")?.to_string();
                if keyword.value("COMBINE").is_some() {
                    return refuse("it makes a surface from others");
                }
                match keyword.value("TYPE").map(str::to_ascii_uppercase).as_deref() {
                    None | Some("ELEMENT") => {
                        let is_internal = keyword.value("INTERNAL").is_some();
                        let surfaces = &mut self.scope().surfaces;
                        surfaces.push(Sides { name, is_internal, sides: Vec::new() });
                        Open::Surface { surface: surfaces.len() - 1 }
                    }
                    Some("NODE") => Open::NodeSurface { set: self.scope().node_sets.open(&name, &keyword) },
                    // Analytical surfaces are not part of the mesh.
                    Some(_) => Open::Other,
                }
            }
            "PART" => {
                self.parts.push(Scope::new(keyword.value("NAME").unwrap_or("part")));
                self.current = Current::Part(self.parts.len() - 1);
                Open::Other
            }
            "INSTANCE" => self.open_instance(&keyword)?,
            "END PART" | "END INSTANCE" => {
                self.current = Current::Rest;
                Open::Other
            }
            "SOLID SECTION" => {
                if let (Some(set), Some(material)) = (keyword.value("ELSET"), keyword.value("MATERIAL")) {
                    self.scope().sections.push((key_of(set), material.to_string()));
                }
                Open::Other
            }
            _ => self.contents.definitions.open(&keyword).map_or(Open::Other, Open::Statement),
        })
    }

    fn open_elements(&mut self, keyword: &Keyword) -> Result<Open, MeshError> {
        let name = keyword.required("TYPE")?;
        let Some(found) = type_of(name) else { return keyword.fail(FileProblem::UnsupportedType { name: name.into() }) };
        let scope = self.scope();
        scope.tables.elements_begin.get_or_insert(keyword.at);
        let set = keyword.value("ELSET").map(|name| scope.element_sets.open(name, keyword));
        Ok(match found {
            ElementType::Shaped(shape, family) => {
                let is_structural = family != Family::Cell;
                if is_structural {
                    scope.tables.structural_types.insert(shape, (name.to_ascii_uppercase(), keyword.at));
                    scope.tables.has_beams |= family == Family::Beam;
                }
                Open::Elements { shape, set, is_structural, begun: None }
            }
            ElementType::Structural => {
                let name = name.to_ascii_uppercase();
                scope.tables.left_out.entry(name.clone()).or_insert((0, keyword.at));
                Open::Structural { name, set, goes_on: false }
            }
        })
    }

    fn open_instance(&mut self, keyword: &Keyword) -> Result<Open, MeshError> {
        let refuse = |reason| keyword.fail(FileProblem::Keyword { keyword: keyword.name.clone(), reason });
        if keyword.value("LIBRARY").is_some() || keyword.value("INSTANCE").is_some() {
            return refuse("it comes from the results of another job");
        }
        let (name, part) = (keyword.required("NAME")?, keyword.required("PART")?);
        let Some(part) = self.parts.iter().find(|known| key_of(&known.name) == key_of(part)) else {
            return keyword.fail(FileProblem::UnknownSet { kind: "part", name: part.into() });
        };
        if self.contents.instance(&key_of(name)).is_some() {
            return refuse("an instance of this name is there already");
        }
        self.contents.scopes.push(Scope { name: name.into(), ..part.clone() });
        self.current = Current::Instance(self.contents.scopes.len() - 1);
        Ok(Open::Placing { lines: 0 })
    }

    /// The scope that a keyword of the assembly names.
    fn instance_of(&self, keyword: &Keyword) -> Result<Option<usize>, MeshError> {
        let Some(name) = keyword.value("INSTANCE") else { return Ok(None) };
        match self.contents.instance(&key_of(name)) {
            Some(scope) => Ok(Some(scope)),
            None => keyword.fail(FileProblem::UnknownSet { kind: "instance", name: name.into() }),
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
                let scope = self.scope();
                if let Some(set) = set {
                    scope.node_sets.add(*set, node);
                }
                scope.tables.add_node(node, point, data.at)
            }
            Open::Elements { shape, set, is_structural, begun } => {
                let notes = if *is_structural { None } else { Some(&mut self.contents.notes) };
                let Some((fields, at)) = element_fields(*shape, begun, data, notes)? else { return Ok(()) };
                if *is_structural && fields.len() > shape.nodes() {
                    self.scope().tables.structural.insert(fields[0]);
                }
                self.element(*shape, &fields, *set, at)
            }
            Open::Structural { name, set, goes_on } => {
                let is_next = !std::mem::replace(goes_on, data.goes_on());
                if is_next {
                    let number = data.number(data.fields().next(), "an element with its number and nodes")?;
                    let scope = self.scope();
                    scope.structural.insert(number);
                    if let Some((count, _)) = scope.tables.left_out.get_mut(name) {
                        *count += 1;
                    }
                    if let Some(set) = set {
                        scope.element_sets.add(*set, number);
                    }
                }
                Ok(())
            }
            Open::NodeSet { set, is_range, scope } => self.scope().node_sets.add_line(*set, data, *is_range, *scope),
            Open::ElementSet { set, is_range, scope } => self.scope().element_sets.add_line(*set, data, *is_range, *scope),
            Open::NodeSurface { set } => {
                const EXPECTED: &str = "a node or a set of nodes, and an area";
                let mut fields = data.fields();
                let owner = fields.next().unwrap_or_default();
                data.real(fields.next(), EXPECTED)?;
                if owner.is_empty() {
                    return data.malformed(EXPECTED);
                }
                self.scope().node_sets.add_field(*set, owner, None);
                Ok(())
            }
            Open::Surface { surface } => {
                let mut fields = data.fields();
                let mut field = || fields.next().unwrap_or_default().to_string();
                let side = (field(), field(), data.at);
                self.scope().surfaces[*surface].sides.push(side);
                Ok(())
            }
            Open::Placing { lines } => {
                self.scope().place(data, *lines)?;
                *lines += 1;
                Ok(())
            }
            Open::Statement(statement) => {
                self.contents.definitions.data(*statement, data);
                Ok(())
            }
        }
    }
}

/// Number and nodes of a complete element, and its first line. Numbers after the nodes are ignored.
fn element_fields(
    shape: Shape,
    begun: &mut Option<Begun>,
    data: &Data,
    notes: Option<&mut Vec<FileNote>>,
) -> Result<Option<(Vec<u64>, FilePosition)>, MeshError> {
    const EXPECTED: &str = "an element with its number and nodes";
    let mut element = begun.take().unwrap_or(Begun { fields: Vec::new(), at: data.at, has_commas: true });
    let needed = shape.nodes() + 1;
    let more: Vec<u64> = data.fields().map(|field| data.number(Some(field), EXPECTED)).collect::<Result<_, _>>()?;
    if element.fields.len() + more.len() > needed && !element.has_commas {
        // Without a trailing comma this line is that of the next element, so that the current one lacks nodes.
        return element.fail(shape);
    }
    element.fields.extend(more);
    if element.fields.len() < needed && (notes.is_some() || data.goes_on()) {
        element.has_commas &= data.goes_on();
        *begun = Some(element);
        return Ok(None);
    }
    let Begun { fields, at, .. } = element;
    if let Some(notes) = notes.filter(|_| fields.len() > needed) {
        match notes.iter_mut().find_map(|note| if let FileNote::LongLines { count, .. } = note { Some(count) } else { None }) {
            Some(count) => *count += 1,
            None => notes.push(FileNote::LongLines { count: 1, first: fields[0] }),
        }
    }
    Ok(Some((fields, at)))
}
