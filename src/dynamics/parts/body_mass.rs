//! Consistent mass of one body in global node numbers, for forces proportional to mass.

use crate::bodies::{BodyCells, ElementLoop, Elements, Space};
use crate::dynamics::model::definitions::BodyDefinition;
use crate::dynamics::model::part::{Change, Numbering};
use crate::linear::{Block, NodeMatrix, Pattern};
use std::sync::Arc;

/// Element loop of a body, used to compute its mass.
enum Cells {
    Plane(Box<dyn ElementLoop<2>>),
    Space(Box<dyn ElementLoop<3>>),
}

/// Mass of a body.
pub struct BodyMass {
    /// Number of the model's nodes.
    nodes: usize,
    /// Element loop of the body; `None` for an invalid body, which the model check refuses.
    cells: Option<Cells>,
    /// Entries between nodes, with their blocks in the matrix.
    pub entries: Vec<(u32, u32, f64, Block)>,
}

impl BodyMass {
    /// Mass of the body with the index `number`.
    pub fn new(body: &BodyDefinition, number: usize, numbering: &Numbering) -> Self {
        let (BodyDefinition { mesh, material, formulation, .. }, first) = (body, numbering.first[number]);
        let cells = BodyCells { first_node: first, ..BodyCells::new(mesh, material, *formulation) };
        let cells = match numbering.dimension {
            2 => Space::<2>::elements(&cells).ok().map(Cells::Plane),
            _ => Space::<3>::elements(&cells).ok().map(Cells::Space),
        };
        BodyMass { nodes: numbering.reference.len() / numbering.dimension, cells, entries: Vec::new() }
    }

    /// Finds the matrix blocks; nodes of a cell are coupled by their body.
    pub fn place(&mut self, pattern: &Pattern) {
        let mut mass = NodeMatrix::new(pattern, self.nodes);
        match &self.cells {
            Some(Cells::Plane(cells)) => cells.add_mass(&mut mass),
            Some(Cells::Space(cells)) => cells.add_mass(&mut mass),
            None => {}
        }
        let entries = mass.entries().filter(|(.., mass)| *mass != 0.0);
        self.entries = entries.map(|(row, column, mass)| (row, column, mass, pattern.block(row, column))).collect();
    }

    /// Visits the components of `M x`, term by term: unknown and value.
    pub fn visit(&self, dimension: usize, x: &[f64], mut visit: impl FnMut(usize, f64)) {
        for &(row, column, mass, _) in &self.entries {
            for i in 0..dimension {
                visit(row as usize * dimension + i, mass * x[column as usize * dimension + i]);
            }
        }
    }
}

/// Body in other units; only data that determine the mass are converted.
pub fn changed_mass(body: &BodyDefinition, change: &Change) -> BodyDefinition {
    let ([mass, length, _], mut changed) = (change.units, body.clone());
    let density = |dimension: &str| Some(if dimension == "mass/volume" { mass / length.powi(3) } else { 1.0 });
    if let (Ok(material), Ok(mesh)) = (body.material.rescaled(density), (*body.mesh).clone().scale([length; 3])) {
        (changed.material, changed.mesh) = (material, Arc::new(mesh));
    }
    changed
}
