//! Conversion of numbers of a file to indices of a table.

use std::collections::HashMap;

use super::tables::{Elements, Tables};
use crate::mesh::MeshError;
use crate::mesh::check::repeated;
use crate::mesh::file_error::{FileError, FileProblem};

/// Indices of the node table by the numbers of nodes in the file.
pub(super) enum Numbering {
    /// Index by number, `u32::MAX` for none; for numbers without large gaps.
    Dense(Vec<u32>),
    /// Any numbers.
    Sparse(HashMap<u64, u32>),
}

impl Numbering {
    pub fn new(tables: &Tables) -> Result<Numbering, MeshError> {
        let numbers = &tables.node_numbers;
        let greatest = numbers.iter().max().copied().unwrap_or(0);
        // The size of the table is limited by the number of nodes, not by the values of their numbers.
        let mut numbering = match usize::try_from(greatest) {
            Ok(greatest) if greatest / 4 <= numbers.len() => Numbering::Dense(vec![u32::MAX; greatest + 1]),
            _ => Numbering::Sparse(HashMap::new()),
        };
        for (index, &node) in numbers.iter().enumerate() {
            let before = match &mut numbering {
                Numbering::Dense(table) => match std::mem::replace(&mut table[node as usize], index as u32) {
                    u32::MAX => None,
                    before => Some(before),
                },
                Numbering::Sparse(table) => table.insert(node, index as u32),
            };
            if let Some(before) = before {
                let first = tables.node_place(before as usize);
                return Err(FileError { at: tables.node_place(index), problem: FileProblem::DuplicateNode { node, first } }.into());
            }
        }
        Ok(numbering)
    }

    pub fn index(&self, number: u64) -> Option<u32> {
        match self {
            Numbering::Dense(table) => usize::try_from(number).ok().and_then(|n| table.get(n)).copied().filter(|&index| index != u32::MAX),
            Numbering::Sparse(table) => table.get(&number).copied(),
        }
    }

    /// Checks that the nodes of all elements exist and differ.
    pub fn check(&self, tables: &Tables) -> Result<(), MeshError> {
        for (shape, elements) in &tables.elements {
            for (element, nodes) in elements.nodes.chunks_exact(shape.nodes()).enumerate() {
                if let Some(&node) = nodes.iter().find(|&&node| self.index(node).is_none()) {
                    let number = tables.written_element(elements.numbers[element]);
                    let problem = FileProblem::MissingNode { element: number, node };
                    return Err(FileError { at: tables.element_place(elements, element), problem }.into());
                }
            }
        }
        Ok(())
    }

    /// Writes the indices of the nodes of an element to `indices`; the nodes must exist and differ.
    pub fn indices_into(&self, tables: &Tables, elements: &Elements, element: usize, indices: &mut [u32]) -> Result<(), MeshError> {
        let nodes = &elements.nodes[element * indices.len()..(element + 1) * indices.len()];
        let (at, number) = (tables.element_place(elements, element), tables.written_element(elements.numbers[element]));
        for (index, &node) in indices.iter_mut().zip(nodes) {
            let Some(known) = self.index(node) else {
                return Err(FileError { at, problem: FileProblem::MissingNode { element: number, node } }.into());
            };
            *index = known;
        }
        match repeated(nodes) {
            Some(node) => Err(MeshError::RepeatedNode { at: Some(at), cell: number, node: tables.written_node(node) }),
            None => Ok(()),
        }
    }
}
