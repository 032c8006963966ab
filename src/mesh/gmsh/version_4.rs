//! Sections of version 4.1: entities with their physical groups, nodes and elements in blocks of one entity each.

use std::collections::HashMap;

use super::lines::{Lines, Section};
use super::tables::{ELEMENT, Tables};
use crate::mesh::MeshError;

/// Physical groups of the geometric entities by dimension and number; `None` without a section of entities.
pub(super) type Entities = Option<HashMap<(usize, i64), Vec<u64>>>;

/// `number x y z n groups…` for points, `number box n groups… m bounding…` for the others.
pub(super) fn read_entities(lines: &mut Lines, entities: &mut Entities) -> Result<(), MeshError> {
    const EXPECTED: &str = "an entity with its number, place and physical groups";
    let mut section = Section { name: "Entities", begin: lines.number, announced: 0, found: 0 };
    let counts: [usize; 4] = lines.entry(&section)?.numbers("the numbers of points, curves, surfaces and volumes")?;
    section.announced = counts.iter().fold(0, |sum: usize, &count| sum.saturating_add(count));
    let entities = entities.get_or_insert_default();
    for (dimension, count) in counts.into_iter().enumerate() {
        for _ in 0..count {
            let mut fields = lines.entry(&section)?;
            let entity: i64 = fields.number(EXPECTED)?;
            for _ in 0..if dimension == 0 { 3 } else { 6 } {
                fields.number::<f64>(EXPECTED)?;
            }
            let physical: u64 = fields.number(EXPECTED)?;
            let mut groups = Vec::new();
            for _ in 0..physical {
                // a negative number means reversed; orientation comes from the cells here
                groups.push(fields.number::<i64>(EXPECTED)?.unsigned_abs());
            }
            groups.sort_unstable();
            groups.dedup();
            entities.insert((dimension, entity), groups);
            section.found += 1;
        }
    }
    lines.close(&section)
}

/// Blocks of `dimension entity parametric count`, then the numbers of the nodes, then as many lines of coordinates.
pub(super) fn read_nodes(lines: &mut Lines, tables: &mut Tables) -> Result<(), MeshError> {
    const HEADER: &str = "the numbers of blocks and nodes and the least and greatest node number";
    const BLOCK: &str = "a block of nodes with dimension, entity, 0 or 1, and the number of nodes";
    const POINT: &str = "three coordinates of a node";
    let mut section = Section { name: "Nodes", begin: lines.number, announced: 0, found: 0 };
    let [blocks, announced, ..]: [usize; 4] = lines.entry(&section)?.numbers(HEADER)?;
    section.announced = announced;
    for _ in 0..blocks {
        let mut header = lines.entry(&section)?;
        let [_, _, parametric]: [i64; 3] = header.numbers(BLOCK)?;
        let count: usize = header.number(BLOCK)?;
        header.end(BLOCK)?;
        let mut numbers: Vec<u64> = Vec::new();
        for _ in 0..count {
            let mut fields = lines.entry(&section)?;
            numbers.push(fields.number("the number of a node")?);
            fields.end("the number of a node")?;
        }
        for number in numbers {
            let mut fields = lines.entry(&section)?;
            let point = fields.numbers(POINT)?;
            // coordinates on the curve or surface may follow
            if parametric == 0 {
                fields.end(POINT)?;
            }
            tables.add_node(number, point, lines.number)?;
            section.found += 1;
        }
    }
    complete(lines, &section)
}

/// Blocks of `dimension entity type count`, then as many lines `number nodes…`.
pub(super) fn read_elements(lines: &mut Lines, tables: &mut Tables, entities: &Entities) -> Result<(), MeshError> {
    const HEADER: &str = "the numbers of blocks and elements and the least and greatest element number";
    const BLOCK: &str = "a block of elements with dimension, entity, type and the number of elements";
    let mut section = Section { name: "Elements", begin: lines.number, announced: 0, found: 0 };
    let [blocks, announced, ..]: [usize; 4] = lines.entry(&section)?.numbers(HEADER)?;
    section.announced = announced;
    for _ in 0..blocks {
        let mut header = lines.entry(&section)?;
        let dimension: usize = header.number(BLOCK)?;
        let entity: i64 = header.number(BLOCK)?;
        let gmsh_type: u64 = header.number(BLOCK)?;
        let count: usize = header.number(BLOCK)?;
        header.end(BLOCK)?;
        let physical = match entities {
            None => Vec::new(),
            Some(known) => match known.get(&(dimension, entity)) {
                Some(groups) => groups.clone(),
                None => return Err(MeshError::UnknownEntity { line: lines.number, dimension, entity }),
            },
        };
        let groups = tables.groups_index(physical);
        for _ in 0..count {
            let mut fields = lines.entry(&section)?;
            let number = fields.number(ELEMENT)?;
            tables.add_element(gmsh_type, number, groups, &mut fields, lines.number)?;
            section.found += 1;
        }
    }
    complete(lines, &section)
}

/// The blocks together hold what the section announces.
fn complete(lines: &mut Lines, section: &Section) -> Result<(), MeshError> {
    lines.close(section)?;
    match *section {
        Section { name, announced, found, .. } if announced != found => {
            Err(MeshError::Count { line: lines.number, section: name, announced, found })
        }
        _ => Ok(()),
    }
}
