//! Bulk data of Nastran (`.bdf`, `.nas`, `.dat`): grid points, cells, constraints of nodes; small, large and free fields.
//!
//! The property number of a cell names its part, or its boundary if it is a facet of solid cells; nodes of SPC and SPC1 form boundaries
//! `spc` with the number of the set. CTRIA3, CQUAD4 and similar elements are shells. Beams, springs, masses and rigid elements are counted
//! and left out; other cards are ignored (MSC Nastran, Quick Reference Guide, "Bulk data entries").

use std::collections::BTreeMap;

use super::tables::{NodeSet, Shape, Tables};
use super::text::utf8;
use super::words::malformed;
use crate::elements::CellKind;
use crate::mesh::MeshError;
use crate::mesh::file_error::{FileError, FilePosition, FileProblem};

/// Cards of cells: prefix of the name, kinds of first and second order, and true for shells.
const CELLS: &[(&str, CellKind, CellKind, bool)] = &[
    ("CTETRA", CellKind::Tet4, CellKind::Tet10, false),
    ("CHEXA", CellKind::Hex8, CellKind::Hex20, false),
    ("CPENTA", CellKind::Wedge6, CellKind::Wedge15, false),
    ("CPYRAM", CellKind::Pyr5, CellKind::Pyr13, false),
    ("CPYRA", CellKind::Pyr5, CellKind::Pyr13, false),
    ("CPLSTN3", CellKind::Tri3, CellKind::Tri6, false),
    ("CPLSTS3", CellKind::Tri3, CellKind::Tri6, false),
    ("CPLSTN4", CellKind::Quad4, CellKind::Quad8, false),
    ("CPLSTS4", CellKind::Quad4, CellKind::Quad8, false),
    ("CPLSTN6", CellKind::Tri3, CellKind::Tri6, false),
    ("CPLSTS6", CellKind::Tri3, CellKind::Tri6, false),
    ("CPLSTN8", CellKind::Quad4, CellKind::Quad8, false),
    ("CPLSTS8", CellKind::Quad4, CellKind::Quad8, false),
    ("CTRIA3", CellKind::Tri3, CellKind::Tri6, true),
    ("CTRIAR", CellKind::Tri3, CellKind::Tri6, true),
    ("CTRIA6", CellKind::Tri3, CellKind::Tri6, true),
    ("CQUAD4", CellKind::Quad4, CellKind::Quad8, true),
    ("CQUADR", CellKind::Quad4, CellKind::Quad8, true),
    ("CQUAD8", CellKind::Quad4, CellKind::Quad8, true),
];

/// Cards of elements that are no cells.
const STRUCTURAL: &[&str] = &[
    "CBAR", "CBEAM", "CBEND", "CBUSH", "CDAMP1", "CDAMP2", "CELAS1", "CELAS2", "CGAP", "CMASS1", "CMASS2", "CONM1", "CONM2", "CONROD",
    "CROD", "CTUBE", "CVISC", "PLOTEL", "RBAR", "RBE1", "RBE2", "RBE3", "RROD",
];

/// Node permutation of hexahedra and wedges, whose mid-side nodes along the axis precede those of the second face.
const HEXAHEDRON: [u8; 20] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15];
const WEDGE: [u8; 15] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11];

/// Data fields of a line: eight of 8 characters, or four of 16.
const FIELDS: usize = 8;

/// True if a file has grid points of Nastran and does not begin like a Gmsh file.
pub(super) fn begins(content: &[u8]) -> bool {
    let is_grid = |line: &[u8]| {
        line.get(..4).is_some_and(|word| word.eq_ignore_ascii_case(b"GRID")) && line.get(4).is_some_and(|&byte| b" ,*\t".contains(&byte))
    };
    let is_gmsh = content.trim_ascii_start().starts_with(b"$MeshFormat");
    !is_gmsh && content.split(|&byte| byte == b'\n').any(is_grid)
}

/// First card of a set of constraints, and its ranges of nodes.
type Held = (FilePosition, Vec<(u64, u64)>);

/// A card with its data fields.
struct Card {
    name: String,
    fields: Vec<String>,
    at: FilePosition,
}

impl Card {
    fn field(&self, index: usize) -> &str {
        self.fields.get(index).map_or("", String::as_str)
    }

    fn natural(&self, index: usize, expected: &'static str) -> Result<u64, MeshError> {
        self.field(index).parse().map_err(|_| self.malformed(expected, index))
    }

    /// Real number; 0 for an empty field. Exponents may have no letter: `1.5-3`.
    fn real(&self, index: usize, expected: &'static str) -> Result<f64, MeshError> {
        let text = self.field(index).replace(['D', 'd'], "E");
        if text.is_empty() {
            return Ok(0.0);
        }
        let sign = text.char_indices().skip(1).find(|&(place, c)| "+-".contains(c) && !text[..place].ends_with(['E', 'e']));
        let number = sign.map_or_else(|| text.clone(), |(place, _)| format!("{}E{}", &text[..place], &text[place..]));
        number.parse().map_err(|_| self.malformed(expected, index))
    }

    fn malformed(&self, expected: &'static str, index: usize) -> MeshError {
        let found = self.field(index);
        malformed(self.at, expected, if found.is_empty() { "an empty field" } else { found })
    }

    fn refused<T>(&self, found: String, cure: &'static str) -> Result<T, MeshError> {
        Err(FileError { at: self.at, problem: FileProblem::Form { found, cure } }.into())
    }
}

/// Name in the first field of a line, and its data fields without comment.
fn fields_of(line: &str) -> (String, Vec<String>) {
    if line.contains(',') {
        let mut fields = line.split(',').map(|field| field.trim().to_string());
        let name = fields.next().unwrap_or_default();
        return (name, fields.take(FIELDS).collect());
    }
    let expanded = line.replace('\t', "        ");
    let at = |from: usize, to: usize| expanded.get(from.min(expanded.len())..to.min(expanded.len())).unwrap_or("").trim().to_string();
    let name = at(0, FIELDS);
    let width = if name.ends_with('*') || name.starts_with('*') { 16 } else { 8 };
    (name, (0..64 / width).map(|k| at(8 + width * k, 8 + width * (k + 1))).collect())
}

/// Calls `take` with every card of the bulk data, with its continuation lines.
fn each_card(text: &str, mut take: impl FnMut(Card) -> Result<(), MeshError>) -> Result<(), MeshError> {
    let mut last: Option<Card> = None;
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.split('$').next().unwrap_or("").trim_end();
        if line.trim().is_empty() {
            continue;
        }
        let (name, fields) = fields_of(line);
        let name = name.to_ascii_uppercase();
        if name == "ENDDATA" {
            break;
        }
        if name.is_empty() || name.starts_with(['+', '*']) {
            last.iter_mut().for_each(|card| card.fields.extend_from_slice(&fields));
        } else {
            // `BEGIN BULK` and the lines before it are ignored like unknown cards.
            let card = Card { name: name.trim_end_matches('*').trim().into(), fields, at: FilePosition::Line(number) };
            last.replace(card).map_or(Ok(()), &mut take)?;
        }
    }
    last.map_or(Ok(()), take)
}

/// Reads the tables of nodes, cells and constrained node sets from the content of a Nastran bulk data file.
pub(super) fn read(content: &[u8]) -> Result<Tables, MeshError> {
    let (mut tables, mut held) = (Tables::default(), BTreeMap::new());
    each_card(utf8(content)?, |card| match card.name.as_str() {
        "GRID" => grid_point(&card, &mut tables),
        "SPC" | "SPC1" => constraint(&card, &mut held),
        name if name.starts_with("INCLUDE") => {
            card.refused("an included file (INCLUDE)".into(), "put the lines of the other file in the place of the card")
        }
        name => match CELLS.iter().find(|(known, ..)| *known == name) {
            Some(&(_, first, second, is_shell)) => cell(&card, &mut tables, [first, second], is_shell),
            None => {
                if STRUCTURAL.contains(&name) {
                    tables.left_out.entry(name.into()).or_insert((0, card.at)).0 += 1;
                }
                Ok(())
            }
        },
    })?;
    tables.node_sets = held_nodes(held, &tables);
    Ok(tables)
}

fn grid_point(card: &Card, tables: &mut Tables) -> Result<(), MeshError> {
    const EXPECTED: &str = "a coordinate of a grid point";
    let number = card.natural(0, "the number of a grid point")?;
    if !matches!(card.field(1), "" | "0") {
        let found = format!("grid point {number} in the coordinate system {}", card.field(1));
        return card.refused(found, "write all grid points in the basic coordinate system");
    }
    tables.add_node(number, [card.real(2, EXPECTED)?, card.real(3, EXPECTED)?, card.real(4, EXPECTED)?], card.at)
}

fn cell(card: &Card, tables: &mut Tables, [first, second]: [CellKind; 2], is_shell: bool) -> Result<(), MeshError> {
    const EXPECTED: &str = "a grid point of the cell";
    let (number, property) = (card.natural(0, "the number of the element")?, card.natural(1, "the number of its property")?);
    let fields = |range: std::ops::Range<usize>| range.filter(|&k| !card.field(2 + k).is_empty()).count();
    let kind = match fields(first.nodes()..second.nodes()) {
        0 => first,
        // Further numbers after the corners of these shells may be angles and thicknesses, no nodes.
        _ if is_shell && matches!(card.name.as_str(), "CTRIA3" | "CQUAD4" | "CTRIAR" | "CQUADR") => first,
        all if all == second.nodes() - first.nodes() => second,
        _ => {
            let found = format!("{} {number} with nodes in the middle of some edges only", card.name);
            return card.refused(found, "give the cell all middle nodes or none");
        }
    };
    let nodes: Vec<u64> = (0..kind.nodes()).map(|k| card.natural(2 + k, EXPECTED)).collect::<Result<_, _>>()?;
    let shape = Shape::Cell(kind);
    if is_shell {
        tables.structural.insert(number);
        tables.structural_types.entry(shape).or_insert((card.name.clone(), card.at));
    }
    tables.elements_begin.get_or_insert(card.at);
    let groups = tables.groups_index(vec![property]);
    let order: &[u8] = match kind {
        CellKind::Hex20 => &HEXAHEDRON,
        CellKind::Wedge15 => &WEDGE,
        _ => &[],
    };
    tables.add_element(shape, number, groups, (&nodes, order), card.at);
    Ok(())
}

/// Reads ranges of nodes of SPC (pairs of a node and its components, with a value) and SPC1 (components, then nodes, or a range with THRU).
fn constraint(card: &Card, held: &mut BTreeMap<u64, Held>) -> Result<(), MeshError> {
    const EXPECTED: &str = "a grid point of the constraint";
    let number = card.natural(0, "the number of a set of constraints")?;
    let (_, ranges) = held.entry(number).or_insert((card.at, Vec::new()));
    let places: Vec<usize> = if card.name == "SPC" { vec![1, 4] } else { (2..card.fields.len()).collect() };
    let mut is_range = false;
    for place in places.into_iter().filter(|&place| !card.field(place).is_empty()) {
        if card.field(place).eq_ignore_ascii_case("THRU") {
            is_range = true;
            continue;
        }
        let node = card.natural(place, EXPECTED)?;
        match ranges.last_mut() {
            Some((_, last)) if is_range => *last = node,
            _ => ranges.push((node, node)),
        }
        is_range = false;
    }
    Ok(())
}

/// Boundaries of the constrained nodes; a range contributes only the nodes that exist.
fn held_nodes(held: BTreeMap<u64, Held>, tables: &Tables) -> Vec<NodeSet> {
    let nodes = |(first, last): (u64, u64)| match first == last {
        true => vec![first],
        false => tables.node_numbers.iter().copied().filter(|node| (first..=last).contains(node)).collect(),
    };
    let set = |(number, (at, ranges)): (u64, Held)| NodeSet {
        name: format!("spc {number}"),
        at,
        nodes: ranges.into_iter().flat_map(nodes).collect(),
    };
    held.into_iter().map(set).collect()
}
