//! Sections of version 4.1: entities with their physical groups, nodes and elements in blocks of one entity each.

use std::collections::HashMap;

use super::super::tables::Tables;
use super::elements::{ELEMENT, add_element};
use super::source::{Section, Source};
use crate::mesh::MeshError;
use crate::mesh::file_error::{FileError, FileProblem};

/// Physical groups of the geometric entities by dimension and number; `None` without a section of entities.
pub(super) type Entities = Option<HashMap<(usize, i64), Vec<u64>>>;

/// `number x y z n groups…` for points, `number box n groups… m bounding…` for the others.
pub(super) fn read_entities(source: &mut Source, entities: &mut Entities) -> Result<(), MeshError> {
    read_entities_of(source, Section::new("$Entities", source), entities)
}

/// Reads the entities of a partitioned mesh: number of partitions, number of ghost entities with `entity part` each, then entities whose
/// numbers are followed by `parent-dimension parent n parts…`. Nodes and elements refer to these entities instead of their parents.
pub(super) fn read_partitioned_entities(source: &mut Source, entities: &mut Entities) -> Result<(), MeshError> {
    const PARTS: &str = "the number of parts";
    const GHOSTS: &str = "the number of ghost entities, each with the number of its part";
    let section = Section::new("$PartitionedEntities", source);
    let mut entry = source.entry(&section)?;
    entry.size(PARTS)?;
    entry.end(PARTS)?;
    let mut entry = source.entry(&section)?;
    // Each ghost entity has a line of its own in a text file.
    let ghosts = entry.count(GHOSTS)?;
    entry.end(GHOSTS)?;
    for _ in 0..ghosts {
        let mut entry = source.entry(&section)?;
        entry.int(GHOSTS)?;
        entry.int(GHOSTS)?;
    }
    read_entities_of(source, section, entities)
}

fn read_entities_of(source: &mut Source, mut section: Section, entities: &mut Entities) -> Result<(), MeshError> {
    const HEADER: &str = "the numbers of points, curves, surfaces and volumes";
    const EXPECTED: &str = "an entity with its number, place and physical groups";
    let is_partitioned = section.name == "$PartitionedEntities";
    let mut header = source.entry(&section)?;
    let counts = [header.count(HEADER)?, header.count(HEADER)?, header.count(HEADER)?, header.count(HEADER)?];
    section.announced = counts.iter().fold(0, |sum: usize, &count| sum.saturating_add(count));
    let entities = entities.get_or_insert_default();
    for (dimension, count) in counts.into_iter().enumerate() {
        for _ in 0..count {
            let is_binary = source.is_binary();
            let mut entry = source.entry(&section)?;
            let number = entry.int(EXPECTED)?;
            if is_partitioned {
                entry.int(EXPECTED)?;
                entry.int(EXPECTED)?;
                for _ in 0..entry.size(EXPECTED)? {
                    entry.int(EXPECTED)?;
                }
            }
            for _ in 0..if dimension == 0 { 3 } else { 6 } {
                entry.real(EXPECTED)?;
            }
            let mut groups = Vec::new();
            for _ in 0..entry.size(EXPECTED)? {
                // A negative group number means reversed orientation; here orientation follows from the cells.
                groups.push(entry.int(EXPECTED)?.unsigned_abs());
            }
            groups.sort_unstable();
            groups.dedup();
            // Bounding entities at the end of the line are not needed.
            if is_binary && dimension > 0 {
                for _ in 0..entry.size(EXPECTED)? {
                    entry.int(EXPECTED)?;
                }
            }
            entities.insert((dimension, number), groups);
            section.found += 1;
        }
    }
    source.close(&section)
}

/// Starts a section of blocks; returns the section and the number of its blocks. The smallest and largest numbers are ignored.
fn blocks(source: &mut Source, name: &'static str, expected: &'static str) -> Result<(Section, usize), MeshError> {
    let mut section = Section::new(name, source);
    let mut header = source.entry(&section)?;
    let (blocks, announced) = (header.count(expected)?, header.count(expected)?);
    header.size(expected)?;
    header.size(expected)?;
    section.announced = announced;
    Ok((section, blocks))
}

/// Blocks of `dimension entity parametric count`, then the numbers of the nodes, then as many entries of coordinates.
pub(super) fn read_nodes(source: &mut Source, tables: &mut Tables) -> Result<(), MeshError> {
    const HEADER: &str = "the numbers of blocks and nodes and the least and greatest node number";
    const BLOCK: &str = "a block of nodes with dimension, entity, 0 or 1, and the number of nodes";
    const POINT: &str = "three coordinates of a node";
    let (mut section, blocks) = blocks(source, "$Nodes", HEADER)?;
    for _ in 0..blocks {
        let is_binary = source.is_binary();
        let mut header = source.entry(&section)?;
        let [dimension, _, parametric] = [header.int(BLOCK)?, header.int(BLOCK)?, header.int(BLOCK)?];
        let count = header.count(BLOCK)?;
        header.end(BLOCK)?;
        let mut numbers: Vec<u64> = Vec::new();
        for _ in 0..count {
            let mut entry = source.entry(&section)?;
            numbers.push(entry.size("the number of a node")?);
            entry.end("the number of a node")?;
        }
        for number in numbers {
            let mut entry = source.entry(&section)?;
            let point = entry.point(POINT)?;
            // Parametric nodes have further coordinates, on the curve or surface.
            if parametric == 0 {
                entry.end(POINT)?;
            } else if is_binary {
                for _ in 0..dimension.clamp(0, 3) {
                    entry.real(POINT)?;
                }
            }
            tables.add_node(number, point, entry.place())?;
            section.found += 1;
        }
    }
    complete(source, &section)
}

/// Blocks of `dimension entity type count`, then as many entries `number nodes…`.
pub(super) fn read_elements(source: &mut Source, tables: &mut Tables, entities: &Entities) -> Result<(), MeshError> {
    const HEADER: &str = "the numbers of blocks and elements and the least and greatest element number";
    const BLOCK: &str = "a block of elements with dimension, entity, type and the number of elements";
    let (mut section, blocks) = blocks(source, "$Elements", HEADER)?;
    for _ in 0..blocks {
        let mut header = source.entry(&section)?;
        let (dimension, entity, gmsh_type) = (header.natural(BLOCK)? as usize, header.int(BLOCK)?, header.natural(BLOCK)?);
        let count = header.count(BLOCK)?;
        header.end(BLOCK)?;
        let physical = match entities {
            None => Vec::new(),
            Some(known) => match known.get(&(dimension, entity)) {
                Some(groups) => groups.clone(),
                None => return header.fail(FileProblem::UnknownEntity { dimension, entity }),
            },
        };
        let groups = tables.groups_index(physical);
        for _ in 0..count {
            let mut entry = source.entry(&section)?;
            let number = entry.size(ELEMENT)?;
            add_element(tables, gmsh_type, number, groups, entry)?;
            section.found += 1;
        }
    }
    complete(source, &section)
}

/// Checks that the blocks together have the announced number of entries.
fn complete(source: &mut Source, section: &Section) -> Result<(), MeshError> {
    source.close(section)?;
    match *section {
        Section { name, announced, found, .. } if announced != found => {
            Err(FileError { at: source.place(), problem: FileProblem::Count { section: name, announced, found } }.into())
        }
        _ => Ok(()),
    }
}
