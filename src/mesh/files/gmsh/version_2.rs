//! Sections of version 2.2: one list of nodes, one list of elements with their physical group.
//!
//! An element in several physical groups is repeated for each. In a binary file a header contains the common data of the following
//! elements.

use super::super::tables::Tables;
use super::elements::{ELEMENT, add_element};
use super::source::{Section, Source};
use crate::mesh::MeshError;
use crate::mesh::file_error::FileProblem;

/// `number x y z` per entry; of parametric nodes `dimension entity` follow, and as many coordinates on the curve or surface.
pub(super) fn read_nodes(source: &mut Source, tables: &mut Tables, name: &'static str) -> Result<(), MeshError> {
    const EXPECTED: &str = "a node with its number and three coordinates";
    let mut section = Section::new(name, source);
    section.announced = source.line(&section)?.word("the number of nodes")?;
    while section.found < section.announced {
        let mut entry = source.entry(&section)?;
        let number = entry.natural(EXPECTED)?;
        let point = entry.point(EXPECTED)?;
        if name == "$ParametricNodes" {
            let dimension = entry.natural(EXPECTED)?;
            entry.int(EXPECTED)?;
            if matches!(dimension, 1 | 2) {
                (0..dimension).try_for_each(|_| entry.real(EXPECTED).map(drop))?;
            }
        }
        entry.end(EXPECTED)?;
        tables.add_node(number, point, entry.place())?;
        section.found += 1;
    }
    source.close(&section)
}

/// `number type tag-count tags… nodes…` per line; in binary `type count tag-count` and then `number tags… nodes…` for each. The first
/// tag is the physical group, 0 for none.
pub(super) fn read_elements(source: &mut Source, tables: &mut Tables) -> Result<(), MeshError> {
    const HEAD: &str = "the type of some elements, their number and the number of their tags";
    let mut section = Section::new("$Elements", source);
    section.announced = source.line(&section)?.word("the number of elements")?;
    let mut current = (0, tables.groups_index(Vec::new()));
    while section.found < section.announced {
        let mut head = (0, 1, 0);
        if source.is_binary() {
            let mut entry = source.entry(&section)?;
            head = (entry.natural(HEAD)?, entry.natural(HEAD)?, entry.natural(HEAD)?);
        }
        for _ in 0..head.1 {
            let is_binary = source.is_binary();
            let mut entry = source.entry(&section)?;
            let number = entry.natural(ELEMENT)?;
            let (gmsh_type, tags) = if is_binary { (head.0, head.2) } else { (entry.natural(ELEMENT)?, entry.natural(ELEMENT)?) };
            let mut physical = 0;
            for tag in 0..tags {
                let value = entry.int(ELEMENT)?;
                if tag == 0 {
                    // A negative group number means reversed orientation; here orientation follows from the cells.
                    physical = value.unsigned_abs();
                }
            }
            if physical != current.0 {
                current = (physical, tables.groups_index(if physical == 0 { Vec::new() } else { vec![physical] }));
            }
            add_element(tables, gmsh_type, number, current.1, entry)?;
            section.found += 1;
        }
    }
    if section.found > section.announced {
        let Section { name, announced, found, .. } = section;
        return source.fail(FileProblem::Count { section: name, announced, found });
    }
    source.close(&section)
}
