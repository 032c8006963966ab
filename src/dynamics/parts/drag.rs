//! Drag: forces of a medium at rest around the bodies, opposite to the velocities of their nodes.
//!
//! On a boundary the force is `-F(|v|) v/|v|` per undeformed area, distributed to the nodes by positive shares. On a body it is
//! `-alpha M v` with its consistent mass (mass-proportional Rayleigh damping): the amplitude of every mode decays with the rate `alpha/2`
//! for any frequency, and so do rigid motions; neither conserves momenta. The heat is `dt v.f`, never negative.

use std::sync::Arc;

use super::body_mass::{BodyMass, changed_mass};
use super::force_laws::Viscous;
use crate::dynamics::model::definitions::BodyDefinition;
use crate::dynamics::model::part::{Change, Iterate, Numbering, Part, PartDefinition, PartStepResult, Refusal, Sums};
use crate::dynamics::model::step_error::StepError;
use crate::linear::{Block, Pattern};

/// Boundary or mass of a body on which drag acts.
#[derive(Clone, Debug)]
pub enum DragTarget {
    /// Nodes of a body with their shares of the area of a boundary `[area]`, and force per area by speed `[stress]`.
    Nodes(usize, Vec<(u32, f64)>, Viscous),
    /// Mass of a body, with the rate `alpha` `[1/time]`.
    Mass(usize, Box<BodyDefinition>, f64),
}

/// Drag on a body.
#[derive(Clone, Debug)]
pub struct DragDefinition {
    /// Name, unique among the parts.
    pub name: String,
    /// Boundary or mass on which the drag acts.
    pub on: DragTarget,
}

impl PartDefinition for DragDefinition {
    fn name(&self) -> &str {
        &self.name
    }

    fn bodies(&self) -> Vec<usize> {
        match self.on {
            DragTarget::Nodes(body, ..) | DragTarget::Mass(body, ..) => vec![body],
        }
    }

    fn dissipates(&self) -> bool {
        true
    }

    fn part(&self, numbering: &Numbering) -> Box<dyn Part> {
        let dimension = numbering.dimension;
        match &self.on {
            DragTarget::Nodes(body, shares, law) => {
                let first = numbering.first[*body] as u32;
                let nodes = shares.iter().map(|&(node, share)| (node + first, share)).collect();
                Box::new(NodeDrag { dimension, nodes, law: law.clone(), places: Vec::new() })
            }
            DragTarget::Mass(body, definition, rate) => {
                let mass = BodyMass::new(definition, *body, numbering);
                Box::new(MassDrag { dimension, mass, rate: *rate })
            }
        }
    }

    fn changed(&self, change: &Change) -> Arc<dyn PartDefinition> {
        let [mass, length, time] = change.units;
        let on = match &self.on {
            DragTarget::Nodes(body, shares, law) => {
                let area = if change.is_plane { length } else { length * length };
                let shares = shares.iter().map(|&(node, share)| (node, share * area)).collect();
                DragTarget::Nodes(*body, shares, law.changed([length / time, mass / (length * time * time)]))
            }
            DragTarget::Mass(body, definition, rate) => DragTarget::Mass(*body, Box::new(changed_mass(definition, change)), rate / time),
        };
        Arc::new(DragDefinition { name: self.name.clone(), on })
    }

    fn describe(&self) -> String {
        match &self.on {
            DragTarget::Nodes(_, shares, law) => format!("drag \"{}\": on {} nodes, {}", self.name, shares.len(), law.describe()),
            DragTarget::Mass(_, body, rate) => format!("drag \"{}\": on the mass of \"{}\", rate {rate}", self.name, body.name),
        }
    }
}

/// Drag on nodes in global node numbers.
struct NodeDrag {
    dimension: usize,
    nodes: Vec<(u32, f64)>,
    law: Viscous,
    places: Vec<Block>,
}

impl NodeDrag {
    /// Velocity of a node and its magnitude.
    fn velocity(&self, node: u32, v: &[f64]) -> ([f64; 3], f64) {
        let mut velocity = [0.0; 3];
        (0..self.dimension).for_each(|i| velocity[i] = v[node as usize * self.dimension + i]);
        (velocity, velocity[0].hypot(velocity[1]).hypot(velocity[2]))
    }
}

impl Part for NodeDrag {
    fn for_each_coupling(&self, visit: &mut dyn FnMut(&[u32])) {
        self.nodes.iter().for_each(|&(node, _)| visit(&[node]));
    }

    fn place(&mut self, pattern: &Pattern) {
        self.places = self.nodes.iter().map(|&(node, _)| pattern.block(node, node)).collect();
    }

    fn linearize(&self, at: &Iterate, _memory: &[f64], sums: &mut Sums) -> Result<(), Refusal> {
        for (&(node, share), block) in self.nodes.iter().zip(&self.places) {
            let (v, speed) = self.velocity(node, at.velocity);
            let (force, slope) = self.law.force(speed);
            // Secant F/|v|, which is F' at rest.
            let secant = if speed > 0.0 { force / speed } else { slope };
            let along = if speed > 0.0 { (slope - secant) / (speed * speed) } else { 0.0 };
            let weighted = at.weight * share;
            for i in 0..self.dimension {
                sums.internal[node as usize * self.dimension + i] += weighted * secant * v[i];
            }
            if let Some(values) = sums.tangent.as_deref_mut() {
                for (i, j) in (0..self.dimension).flat_map(|i| (0..self.dimension).map(move |j| (i, j))) {
                    let isotropic = if i == j { secant } else { 0.0 };
                    values[block.at(i, j)] += weighted * at.velocity_slope * (isotropic + along * v[i] * v[j]);
                }
            }
        }
        Ok(())
    }

    fn is_outside(&self) -> bool {
        true
    }

    fn after_step(&self, at: &Iterate, _memory: &[f64]) -> Result<PartStepResult, StepError> {
        let power = |&(node, share): &(u32, f64)| {
            let speed = self.velocity(node, at.velocity).1;
            share * speed * self.law.force(speed).0
        };
        Ok(PartStepResult { dissipated: at.dt * self.nodes.iter().map(power).sum::<f64>(), ..PartStepResult::default() })
    }
}

/// Drag on the mass of a body in global node numbers.
struct MassDrag {
    dimension: usize,
    mass: BodyMass,
    rate: f64,
}

impl Part for MassDrag {
    fn for_each_coupling(&self, _visit: &mut dyn FnMut(&[u32])) {
        // The body couples the nodes of each cell already.
    }

    fn place(&mut self, pattern: &Pattern) {
        self.mass.place(pattern);
    }

    fn linearize(&self, at: &Iterate, _memory: &[f64], sums: &mut Sums) -> Result<(), Refusal> {
        let factor = at.weight * self.rate;
        self.mass.visit(self.dimension, at.velocity, |unknown, momentum| sums.internal[unknown] += factor * momentum);
        if let Some(values) = sums.tangent.as_deref_mut() {
            for (.., mass, block) in &self.mass.entries {
                (0..self.dimension).for_each(|i| values[block.at(i, i)] += factor * at.velocity_slope * mass);
            }
        }
        Ok(())
    }

    fn is_outside(&self) -> bool {
        true
    }

    fn after_step(&self, at: &Iterate, _memory: &[f64]) -> Result<PartStepResult, StepError> {
        let mut square = 0.0;
        self.mass.visit(self.dimension, at.velocity, |unknown, momentum| square += at.velocity[unknown] * momentum);
        Ok(PartStepResult { dissipated: at.dt * self.rate * square, ..PartStepResult::default() })
    }
}
