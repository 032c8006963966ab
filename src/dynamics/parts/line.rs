//! Line between two ends, along which springs, dampers and actuators act.
//!
//! An end is a node, the weighted mean of the nodes of a boundary, or a point of the ground. The vector between the ends is linear in the
//! positions, `r = sum s_i q_i + ground`, and a force `f` on the head acts on node `i` as `s_i f`.

use std::sync::Arc;

use crate::dynamics::model::amplitude::Amplitude;
use crate::dynamics::model::error::ModelError;
use crate::dynamics::model::part::{Change, Iterate, Numbering, Part, PartDefinition, PartPlace, Sums};
use crate::dynamics::model::quantity::Quantity;
use crate::linear::{Block, Pattern};

/// End of a line element.
#[derive(Clone, Debug, PartialEq)]
pub enum End {
    /// A node: body, and node of the body's mesh.
    Node(usize, u32),
    /// Weighted mean of nodes of a body; the weights add up to 1.
    Mean(usize, Vec<(u32, f64)>),
    /// Fixed point `[length]`.
    Ground([f64; 3]),
}

impl From<(usize, u32)> for End {
    fn from((body, node): (usize, u32)) -> Self {
        End::Node(body, node)
    }
}

impl End {
    /// Mean of the positions of a boundary's nodes, weighted by their shares of its measure.
    pub fn mean(body: usize, shares: &[(u32, f64)]) -> Self {
        let whole: f64 = shares.iter().map(|(_, share)| share).sum();
        End::Mean(body, shares.iter().map(|&(node, share)| (node, share / whole)).collect())
    }

    /// Body of the end; `None` for the ground.
    pub fn body(&self) -> Option<usize> {
        match self {
            End::Node(body, _) | End::Mean(body, _) => Some(*body),
            End::Ground(_) => None,
        }
    }

    /// Position of the end in the undeformed bodies; `point` gives the positions of their nodes.
    pub fn place(&self, point: &dyn Fn(usize, u32) -> [f64; 3]) -> [f64; 3] {
        match self {
            End::Node(body, node) => point(*body, *node),
            End::Mean(body, shares) => {
                let mut sum = [0.0; 3];
                for &(node, share) in shares {
                    let x = point(*body, node);
                    (0..3).for_each(|i| sum[i] += share * x[i]);
                }
                sum
            }
            End::Ground(place) => *place,
        }
    }

    /// Returns the end in a transformed model.
    pub fn changed(&self, change: &Change) -> Self {
        match self {
            End::Ground(place) => End::Ground((change.point)(*place)),
            of_body => of_body.clone(),
        }
    }
}

/// Force element along the line between two ends: spring, damper or actuator.
pub trait LineElement: Clone + Send + Sync + 'static {
    /// Names of the element's columns in the history.
    const READINGS: &'static [Quantity];
    /// True if the element dissipates energy.
    const DISSIPATES: bool = false;

    /// Time functions of the element.
    fn functions(&self) -> Vec<Amplitude> {
        Vec::new()
    }

    /// Makes the part `name` on a line of the length `at_rest` at rest; `is_grounded` if one end is fixed to the ground.
    fn part(&self, name: &str, line: Line, at_rest: f64, is_grounded: bool) -> Box<dyn Part>;

    /// Returns the element in a transformed model.
    fn changed(&self, change: &Change) -> Self;

    /// Describes the part `name` in words.
    fn describe(&self, name: &str) -> String;
}

/// Definition of a line element between two ends.
#[derive(Clone, Debug, PartialEq)]
pub struct LineDefinition<E> {
    /// Name, unique among the parts.
    pub name: String,
    /// Ends of the line.
    pub ends: [End; 2],
    /// Force element between the ends.
    pub element: E,
}

impl<E: LineElement> PartDefinition for LineDefinition<E> {
    fn name(&self) -> &str {
        &self.name
    }

    fn bodies(&self) -> Vec<usize> {
        let mut bodies: Vec<usize> = self.ends.iter().filter_map(End::body).collect();
        bodies.dedup();
        bodies
    }

    fn is_grounded(&self) -> bool {
        self.ends.iter().any(|end| end.body().is_none())
    }

    fn functions(&self) -> Vec<Amplitude> {
        self.element.functions()
    }

    fn readings(&self) -> &'static [Quantity] {
        E::READINGS
    }

    fn dissipates(&self) -> bool {
        E::DISSIPATES
    }

    fn places(&self) -> Vec<PartPlace> {
        let place = |end: &End| match end {
            End::Node(body, node) => PartPlace::Nodes(*body, vec![(*node, 1.0)]),
            End::Mean(body, shares) => PartPlace::Nodes(*body, shares.clone()),
            End::Ground(point) => PartPlace::Point(None, *point),
        };
        self.ends.iter().map(place).collect()
    }

    fn check(&self, point: &dyn Fn(usize, u32) -> [f64; 3]) -> Result<(), ModelError> {
        // Coinciding ends define no direction.
        let [a, b] = [0, 1].map(|k| self.ends[k].place(point));
        if a == b { Err(ModelError::SpringOfNoLength { spring: self.name.clone() }) } else { Ok(()) }
    }

    fn part(&self, numbering: &Numbering) -> Box<dyn Part> {
        let line = Line::new(&self.ends, numbering);
        let at_rest = line.vector(numbering.reference).1;
        self.element.part(&self.name, line, at_rest, self.is_grounded())
    }

    fn changed(&self, change: &Change) -> Arc<dyn PartDefinition> {
        let ends = [0, 1].map(|k| self.ends[k].changed(change));
        Arc::new(LineDefinition { name: self.name.clone(), ends, element: self.element.changed(change) })
    }

    fn describe(&self) -> String {
        self.element.describe(&self.name)
    }
}

/// Line in global node numbers, from its first to its second end.
pub struct Line {
    dimension: usize,
    /// Nodes with their coefficients in `r`.
    nodes: Vec<(u32, f64)>,
    ground: [f64; 3],
    /// Blocks of the nodes, row by row.
    places: Vec<Block>,
}

impl Line {
    /// Line between two ends.
    pub fn new(ends: &[End; 2], numbering: &Numbering) -> Self {
        let mut line = Line { dimension: numbering.dimension, nodes: Vec::new(), ground: [0.0; 3], places: Vec::new() };
        for (end, sign) in ends.iter().zip([-1.0, 1.0]).rev() {
            let node = |body: usize, node: u32| numbering.first[body] as u32 + node;
            match end {
                End::Node(body, one) => line.nodes.push((node(*body, *one), sign)),
                End::Mean(body, shares) => line.nodes.extend(shares.iter().map(|&(one, share)| (node(*body, one), sign * share))),
                End::Ground(place) => (0..numbering.dimension).for_each(|i| line.ground[i] += sign * place[i]),
            }
        }
        line
    }

    /// Nodes of both ends.
    pub fn nodes(&self) -> Vec<u32> {
        self.nodes.iter().map(|(node, _)| *node).collect()
    }

    /// Finds the matrix blocks of the line's nodes.
    pub fn place(&mut self, pattern: &Pattern) {
        let nodes = self.nodes();
        self.places = nodes.iter().flat_map(|&a| nodes.iter().map(move |&b| pattern.block(a, b))).collect();
    }

    /// Vector `r` and its length; in the plane the third component is zero.
    pub fn vector(&self, q: &[f64]) -> ([f64; 3], f64) {
        let r = self.combined(q, self.ground);
        (r, r[0].hypot(r[1]).hypot(r[2]))
    }

    /// Velocity of the head relative to the tail, from nodal velocities.
    pub fn velocity(&self, v: &[f64]) -> [f64; 3] {
        self.combined(v, [0.0; 3])
    }

    fn combined(&self, x: &[f64], start: [f64; 3]) -> [f64; 3] {
        let mut sum = start;
        for &(node, factor) in &self.nodes {
            (0..self.dimension).for_each(|i| sum[i] += factor * x[node as usize * self.dimension + i]);
        }
        sum
    }

    /// Adds a force on the head that opposes the motion, and its derivative with respect to `r` at the end of the step.
    pub fn add(&self, weight: f64, force: [f64; 3], slope: impl Fn(usize, usize) -> f64, sums: &mut Sums) {
        self.push(force.map(|force| weight * force), sums.internal);
        self.add_slope(weight, slope, sums);
    }

    /// Adds a force along the line that pushes the ends apart (negative: pulls) to the loads, and its derivative; zero for coinciding ends.
    pub fn push_apart(&self, force: f64, at: &Iterate, sums: &mut Sums) {
        let (r, length) = self.vector(at.q_test);
        if length > 0.0 {
            let (e, turning) = (r.map(|r| r / length), at.derivative.placement().share * force / length);
            self.push(e.map(|e| force * e), sums.load);
            self.add_slope(at.weight, |i, j| turning * (e[i] * e[j] - if i == j { 1.0 } else { 0.0 }), sums);
        }
    }

    /// Work in a step of a force that pushes the ends apart `[energy]`.
    pub fn work_apart(&self, force: f64, at: &Iterate) -> f64 {
        let ((r, length), (r_0, _), (r_1, _)) = (self.vector(at.q_test), self.vector(at.q_0), self.vector(at.q_1));
        let moved: f64 = if length > 0.0 { (0..3).map(|i| r[i] / length * (r_1[i] - r_0[i])).sum() } else { 0.0 };
        force * moved
    }

    /// Adds a force on the head to nodal forces.
    fn push(&self, force: [f64; 3], sum: &mut [f64]) {
        for &(node, factor) in &self.nodes {
            for i in 0..self.dimension {
                sum[node as usize * self.dimension + i] += factor * force[i];
            }
        }
    }

    /// Adds the derivative of a force that opposes the motion.
    fn add_slope(&self, weight: f64, slope: impl Fn(usize, usize) -> f64, sums: &mut Sums) {
        let Some(values) = sums.tangent.as_deref_mut() else { return };
        let pairs = self.nodes.iter().flat_map(|(_, a)| self.nodes.iter().map(move |(_, b)| a * b));
        for (block, factor) in self.places.iter().zip(pairs) {
            for i in 0..self.dimension {
                for j in 0..self.dimension {
                    values[block.at(i, j)] += factor * weight * slope(i, j);
                }
            }
        }
    }
}
