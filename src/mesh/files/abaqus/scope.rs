//! Nodes, elements, sets and surfaces with common numbers and names: those of a part, of an instance, or of the rest of the file.

use std::collections::{HashMap, HashSet};

use super::super::tables::{Shape, Tables};
use super::lines::Data;
use super::sets::{Set, Sets};
use crate::mesh::MeshError;
use crate::mesh::file_error::{FileError, FilePosition, FileProblem};

/// Surface whose element sets are not resolved yet.
#[derive(Clone)]
pub(super) struct Sides {
    pub name: String,
    pub is_internal: bool,
    /// Element or element set, side as written (empty: all sides on the hull), and line.
    pub sides: Vec<(String, String, FilePosition)>,
}

/// Kind of a set.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Kind {
    Nodes,
    Elements,
}

impl Kind {
    pub fn of_set(self) -> &'static str {
        match self {
            Kind::Nodes => "node set",
            Kind::Elements => "element set",
        }
    }
}

/// Nodes, elements and sets of a part or instance, whose numbers and names are its own.
#[derive(Clone, Default)]
pub(super) struct Scope {
    /// Name of the part or instance; empty for the rest of the file.
    pub name: String,
    pub tables: Tables,
    pub node_sets: Sets,
    pub element_sets: Sets,
    pub surfaces: Vec<Sides>,
    /// Position of each element in the tables.
    pub elements: HashMap<u64, (Shape, u32)>,
    /// Elements that are no cells, without their nodes.
    pub structural: HashSet<u64>,
    /// Sections: set of elements and material.
    pub sections: Vec<(String, String)>,
}

impl Scope {
    pub fn new(name: &str) -> Scope {
        Scope { name: name.into(), ..Scope::default() }
    }

    pub fn has_content(&self) -> bool {
        !self.tables.node_numbers.is_empty() || !self.elements.is_empty() || !self.structural.is_empty()
    }

    pub fn sets(&self, kind: Kind) -> &Sets {
        match kind {
            Kind::Nodes => &self.node_sets,
            Kind::Elements => &self.element_sets,
        }
    }

    /// Sets that are not internal to the file, with their indices.
    pub fn named_sets(&self, kind: Kind) -> impl Iterator<Item = (usize, &Set)> {
        self.sets(kind).list.iter().enumerate().filter(|(_, set)| !set.is_internal)
    }

    /// All numbers of a kind in ascending order.
    pub fn numbers(&self, kind: Kind) -> Vec<u64> {
        let mut all: Vec<u64> = match kind {
            Kind::Nodes => self.tables.node_numbers.clone(),
            Kind::Elements => self.elements.keys().chain(&self.structural).copied().collect(),
        };
        all.sort_unstable();
        all
    }

    /// Nodes of an element with a shape.
    pub fn nodes_of(&self, element: u64) -> &[u64] {
        self.elements.get(&element).map_or(&[], |(shape, index)| {
            let count = shape.nodes();
            &self.tables.elements[shape].nodes[*index as usize * count..][..count]
        })
    }

    /// Keeps an element with a shape.
    pub fn add_element(&mut self, shape: Shape, number: u64, nodes: &[u64], at: FilePosition) -> Result<(), MeshError> {
        let place = self.tables.elements.get(&shape).map_or(0, |elements| elements.numbers.len() as u32);
        if let Some((shape, before)) = self.elements.insert(number, (shape, place)) {
            let first = self.tables.element_place(&self.tables.elements[&shape], before as usize);
            return Err(FileError { at, problem: FileProblem::DuplicateElement { element: number, first } }.into());
        }
        let order = shape.row().map_or(&[][..], |row| row.abaqus_order);
        self.tables.add_element(shape, number, 0, (nodes, order), at);
        Ok(())
    }

    /// Reads a data line of an instance: a translation, or the axis and angle of a rotation after the translation.
    pub fn place(&mut self, data: &Data, line: usize) -> Result<(), MeshError> {
        const MOVED: &str = "three numbers by which the instance is moved";
        const TURNED: &str = "two points of an axis and an angle in degrees by which the instance is turned";
        let expected = if line == 0 { MOVED } else { TURNED };
        let mut numbers = [0.0; 7];
        let mut fields = data.fields();
        for number in &mut numbers[..if line == 0 { 3 } else { 7 }] {
            *number = data.real(fields.next(), expected)?;
        }
        if line > 1 || !numbers.iter().all(|x| x.is_finite()) {
            return data.malformed(expected);
        }
        let [a, b, c, d, e, f, angle] = numbers;
        if line == 0 {
            self.tables.points.iter_mut().for_each(|x| *x = [x[0] + a, x[1] + b, x[2] + c]);
        } else {
            let axis = [d - a, e - b, f - c];
            let length = axis[0].hypot(axis[1]).hypot(axis[2]);
            if length == 0.0 {
                return data.malformed(expected);
            }
            self.turn([a, b, c], axis.map(|x| x / length), angle);
        }
        let is_finite = self.tables.points.as_flattened().iter().all(|x| x.is_finite());
        if is_finite { Ok(()) } else { data.malformed(expected) }
    }

    /// Turns all nodes by an angle in degrees about the line through a point along the unit vector `u` (O. Rodrigues, 1840).
    fn turn(&mut self, center: [f64; 3], u: [f64; 3], angle: f64) {
        let (sine, cosine) = sine_and_cosine(angle);
        for point in &mut self.tables.points {
            let arm = [0, 1, 2].map(|i| point[i] - center[i]);
            let along: f64 = (0..3).map(|i| u[i] * arm[i]).sum();
            let across = [u[1] * arm[2] - u[2] * arm[1], u[2] * arm[0] - u[0] * arm[2], u[0] * arm[1] - u[1] * arm[0]];
            *point = [0, 1, 2].map(|i| center[i] + u[i] * along + (arm[i] - u[i] * along) * cosine + across[i] * sine);
        }
    }
}

/// Sine and cosine of an angle in degrees, exact for right angles.
fn sine_and_cosine(degrees: f64) -> (f64, f64) {
    match degrees.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        degrees => degrees.to_radians().sin_cos(),
    }
}
