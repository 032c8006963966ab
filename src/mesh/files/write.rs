//! A mesh as a Gmsh file, MSH 4.1 ASCII.
//!
//! A written file is read back with the same nodes, cells, boundaries and parts, and numbers agree to the last bit. Every boundary is an
//! entity of its own with one physical group of its name, so a facet of two boundaries is written twice; cells of several parts belong to
//! an entity for this combination. Blocks of cells keep their order.

use std::collections::{BTreeMap, HashSet};
use std::fmt::Write;

use super::gmsh::number_of;
use super::tables::Shape;
use crate::elements::CellKind;
use crate::mesh::Mesh;
use crate::mesh::topology::facet_key;

/// A block of elements of one entity.
struct Block {
    dimension: usize,
    entity: usize,
    gmsh_type: u64,
    elements: Vec<Vec<u32>>,
}

impl Mesh {
    /// The mesh as the text of a Gmsh file (MSH 4.1 ASCII); boundaries and parts are physical groups of their names.
    ///
    /// When the file is read, boundaries of nodes follow those with facets. Characters that are invalid in a line become spaces in names.
    pub fn to_gmsh(&self) -> String {
        let dimension = self.dimension();
        // Groups of cells: combination of the parts of each cell.
        let mut parts_of: Vec<Vec<usize>> = vec![Vec::new(); self.cell_count()];
        for (part, (_, cells)) in self.parts.iter().enumerate() {
            cells.iter().for_each(|&cell| parts_of[cell as usize].push(part + 1));
        }
        let mut entities: BTreeMap<&[usize], usize> = BTreeMap::new();
        let mut blocks = self.boundary_blocks();
        for (cell, parts) in parts_of.iter().enumerate() {
            let next = entities.len() + 1;
            let entity = *entities.entry(parts).or_insert(next);
            let kind = self.kind_of(cell);
            let (mut nodes, order) = (self.cell(cell).to_vec(), kind.row().gmsh_order);
            self.cell(cell).iter().zip(order).for_each(|(&node, &place)| nodes[usize::from(place)] = node);
            let gmsh_type = number_of(Shape::Cell(kind));
            match blocks.last_mut() {
                Some(last) if (last.dimension, last.entity, last.gmsh_type) == (dimension, entity, gmsh_type) => last.elements.push(nodes),
                _ => blocks.push(Block { dimension, entity, gmsh_type, elements: vec![nodes] }),
            }
        }
        let mut text = String::from("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n");
        self.write_names(&mut text);
        self.write_entities(&mut text, &entities);
        self.write_nodes(&mut text);
        write_elements(&mut text, &blocks);
        text
    }

    /// Nodes and facets of the boundaries as blocks of elements; a block has the entity number of its boundary.
    fn boundary_blocks(&self) -> Vec<Block> {
        let mut blocks = Vec::new();
        for (boundary, entity) in self.boundaries.iter().zip(1..) {
            if !boundary.nodes.is_empty() {
                let elements = boundary.nodes.iter().map(|&node| vec![node]).collect();
                blocks.push(Block { dimension: 0, entity, gmsh_type: number_of(Shape::Point), elements });
            }
        }
        for (boundary, entity) in self.boundaries.iter().zip(1..).filter(|(boundary, _)| !boundary.facets.is_empty()) {
            // One element represents both sides of an interior facet.
            let mut seen = HashSet::new();
            let facets = boundary.facets.iter().filter(|&&facet| seen.insert(facet_key(self.facet_nodes(facet))));
            let elements: Vec<Vec<u32>> = facets.map(|&facet| self.facet_nodes(facet).collect()).collect();
            for elements in elements.chunk_by(|a, b| a.len() == b.len()) {
                let nodes = elements[0].len();
                let shape = if self.dimension() == 2 { Shape::Line(nodes) } else { Shape::Cell(CellKind::of_face(nodes)) };
                blocks.push(Block { dimension: self.dimension() - 1, entity, gmsh_type: number_of(shape), elements: elements.to_vec() });
            }
        }
        blocks
    }

    fn write_names(&self, text: &mut String) {
        let below = self.dimension() - 1;
        let mut names: Vec<(usize, usize, &str)> = Vec::new();
        for (boundary, number) in self.boundaries.iter().zip(1..) {
            if !boundary.nodes.is_empty() {
                names.push((0, number, &boundary.name));
            }
            if !boundary.facets.is_empty() {
                names.push((below, number, &boundary.name));
            }
        }
        names.extend(self.parts.iter().zip(1..).map(|((name, _), number)| (below + 1, number, name.as_str())));
        if names.is_empty() {
            return;
        }
        names.sort_unstable();
        line(text, format_args!("$PhysicalNames\n{}", names.len()));
        for (dimension, number, name) in names {
            let name: String = name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
            line(text, format_args!("{dimension} {number} \"{name}\""));
        }
        line(text, format_args!("$EndPhysicalNames"));
    }

    fn write_entities(&self, text: &mut String, cells: &BTreeMap<&[usize], usize>) {
        let below = self.dimension() - 1;
        let corner = |pick: fn(f64, f64) -> f64| {
            let start = self.points.first().copied().unwrap_or_default();
            self.points.iter().fold(start, |so_far, point| [0, 1, 2].map(|i| pick(so_far[i], point[i])))
        };
        let [[ax, ay, az], [bx, by, bz]] = [corner(f64::min), corner(f64::max)];
        let points: Vec<usize> = (1..).zip(&self.boundaries).filter(|(_, b)| !b.nodes.is_empty()).map(|(number, _)| number).collect();
        let facets: Vec<usize> = (1..).zip(&self.boundaries).filter(|(_, b)| !b.facets.is_empty()).map(|(number, _)| number).collect();
        let mut counts = [0; 4];
        counts[0] = points.len();
        counts[below] += facets.len();
        counts[below + 1] += cells.len();
        let [a, b, c, d] = counts;
        line(text, format_args!("$Entities\n{a} {b} {c} {d}"));
        for number in points {
            // The point entity has the position of its first node.
            let [x, y, z] = self.points[self.boundaries[number - 1].nodes[0] as usize];
            line(text, format_args!("{number} {x:?} {y:?} {z:?} 1 {number}"));
        }
        for number in facets {
            line(text, format_args!("{number} {ax:?} {ay:?} {az:?} {bx:?} {by:?} {bz:?} 1 {number} 0"));
        }
        let mut in_order: Vec<(usize, &[usize])> = cells.iter().map(|(parts, number)| (*number, *parts)).collect();
        in_order.sort_unstable();
        for (number, parts) in in_order {
            let groups: String = parts.iter().map(|part| format!(" {part}")).collect();
            line(text, format_args!("{number} {ax:?} {ay:?} {az:?} {bx:?} {by:?} {bz:?} {}{groups} 0", parts.len()));
        }
        line(text, format_args!("$EndEntities"));
    }

    fn write_nodes(&self, text: &mut String) {
        let count = self.points.len();
        line(text, format_args!("$Nodes\n1 {count} 1 {count}\n{} 1 0 {count}", self.dimension()));
        for number in 1..=count {
            line(text, format_args!("{number}"));
        }
        for [x, y, z] in &self.points {
            line(text, format_args!("{x:?} {y:?} {z:?}"));
        }
        line(text, format_args!("$EndNodes"));
    }
}

fn write_elements(text: &mut String, blocks: &[Block]) {
    let count: usize = blocks.iter().map(|block| block.elements.len()).sum();
    line(text, format_args!("$Elements\n{} {count} 1 {count}", blocks.len()));
    let mut number = 0;
    for Block { dimension, entity, gmsh_type, elements } in blocks {
        line(text, format_args!("{dimension} {entity} {gmsh_type} {}", elements.len()));
        for nodes in elements {
            number += 1;
            let nodes: String = nodes.iter().map(|node| format!(" {}", node + 1)).collect();
            line(text, format_args!("{number}{nodes}"));
        }
    }
    line(text, format_args!("$EndElements"));
}

/// Appends a formatted line; writing into a string cannot fail.
fn line(text: &mut String, content: std::fmt::Arguments) {
    let _ = text.write_fmt(content);
    text.push('\n');
}
