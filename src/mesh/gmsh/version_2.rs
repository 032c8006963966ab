//! Sections of version 2.2: one list of nodes, one list of elements that carry their physical group themselves.
//!
//! An element in several physical groups is written once for each.

use super::lines::{Lines, Section};
use super::tables::{ELEMENT, Tables};
use crate::mesh::MeshError;

/// `number x y z` per line.
pub(super) fn read_nodes(lines: &mut Lines, tables: &mut Tables) -> Result<(), MeshError> {
    const EXPECTED: &str = "a node with its number and three coordinates";
    let mut section = Section { name: "Nodes", begin: lines.number, announced: 0, found: 0 };
    section.announced = lines.entry(&section)?.number("the number of nodes")?;
    while section.found < section.announced {
        let mut fields = lines.entry(&section)?;
        let number = fields.number(EXPECTED)?;
        let point = fields.numbers(EXPECTED)?;
        fields.end(EXPECTED)?;
        tables.add_node(number, point, lines.number)?;
        section.found += 1;
    }
    lines.close(&section)
}

/// `number type tag-count tags… nodes…` per line; the first tag is the physical group, 0 for none.
pub(super) fn read_elements(lines: &mut Lines, tables: &mut Tables) -> Result<(), MeshError> {
    let mut section = Section { name: "Elements", begin: lines.number, announced: 0, found: 0 };
    section.announced = lines.entry(&section)?.number("the number of elements")?;
    let mut current = (0, tables.groups_index(Vec::new()));
    while section.found < section.announced {
        let mut fields = lines.entry(&section)?;
        let [number, gmsh_type, tags]: [u64; 3] = fields.numbers(ELEMENT)?;
        let mut physical = 0;
        for tag in 0..tags {
            let value: i64 = fields.number(ELEMENT)?;
            if tag == 0 {
                // a negative number means reversed; orientation comes from the cells here
                physical = value.unsigned_abs();
            }
        }
        if physical != current.0 {
            current = (physical, tables.groups_index(if physical == 0 { Vec::new() } else { vec![physical] }));
        }
        tables.add_element(gmsh_type, number, current.1, &mut fields, lines.number)?;
        section.found += 1;
    }
    lines.close(&section)
}
