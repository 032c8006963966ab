//! What every part of a model owes the equations, whatever it is.
//!
//! A part pushes on nodes. It tells which of them it couples, finds its places in the matrix, adds its forces and their derivative at an
//! iterate, and says what it stores and remembers. Bodies and loads are parts. A new kind of part (a dashpot, an added mass) is one file
//! with a [`PartDefinition`], which goes into [`Model::parts`](super::definitions::Model::parts), and its [`Part`]; nobody else asks what
//! it is.

use std::sync::Arc;

use super::amplitude::Amplitude;
use super::error::ModelError;
use super::step_error::StepError;
use crate::bodies::Inverted;
use crate::integrators::Derivative;
use crate::linear::{NodeMatrix, Pattern};
use crate::math::workers::Workers;

/// Where the nodes are. Both are flat, node after node, of the whole model.
#[derive(Clone, Copy)]
pub struct Pose<'a> {
    /// Positions `[length]`.
    pub q: &'a [f64],
    /// Displacements, with the accuracy of their own size: strains follow from them `[length]`.
    pub u: &'a [f64],
}

/// Where a step stands when its parts are asked for their forces. Positions are flat, node after node, of the whole model.
pub struct Iterate<'a> {
    /// How potentials are differentiated.
    pub derivative: Derivative,
    /// Share of the forces in the equations of the step.
    pub weight: f64,
    /// Time at which loads act `[time]`.
    pub time: f64,
    /// Size of the step `[time]`, 0 at rest.
    pub dt: f64,
    /// Positions at the start of the step `[length]`.
    pub q_0: &'a [f64],
    /// Positions at its end `[length]`.
    pub q_1: &'a [f64],
    /// Displacements at the start, with the accuracy of their own size: strains follow from them `[length]`.
    pub u_0: &'a [f64],
    /// Displacements at the end `[length]`.
    pub u_1: &'a [f64],
    /// Positions at which loads act `[length]`.
    pub q_test: &'a [f64],
    /// Velocities at which forces act: with the time integrator's derivative the mean of both ends of the step, or those of its end. At
    /// rest they are zero, or those of the start, where the forces there are asked for `[length/time]`.
    pub velocity: &'a [f64],
    /// Derivative of each of them with respect to its component of `q_1`: 0 where they do not change with it `[1/time]`.
    pub velocity_slope: f64,
    /// Whether an equilibrium is asked for, in which nothing moves.
    pub is_still: bool,
    /// Factor of the mass in the tangent, body by body `[1/time^2]`.
    pub inertia: &'a [f64],
}

#[cfg(test)]
impl<'a> Iterate<'a> {
    /// One between two positions, for tests of parts to which neither times nor velocities matter.
    pub(in crate::dynamics) fn between(derivative: Derivative, q_0: &'a [f64], q_1: &'a [f64]) -> Self {
        Iterate {
            derivative,
            weight: 1.0,
            time: 0.0,
            dt: 0.1,
            q_0,
            q_1,
            u_0: q_0,
            u_1: q_1,
            q_test: q_1,
            velocity: q_1,
            velocity_slope: 0.0,
            is_still: false,
            inertia: &[],
        }
    }
}

/// Sums that parts add to, unknown by unknown of the whole model.
pub struct Sums<'a> {
    /// Weighted forces of potentials, as the residual has them: against the motion that they drive `[force]`.
    pub internal: &'a mut [f64],
    /// Forces from outside, not weighted `[force]`.
    pub load: &'a mut [f64],
    /// Values of the matrix, where the weighted derivative is wanted `[force/length]`.
    pub tangent: Option<&'a mut [f64]>,
    /// Threads to share work among.
    pub workers: &'a Workers,
}

/// Why forces could not be computed.
pub enum Refusal {
    /// A cell turned inside out.
    Inverted {
        /// Its body.
        body: String,
        /// The cell.
        inverted: Inverted,
    },
    /// A time function failed.
    Load(StepError),
}

/// A part of a model that pushes on nodes.
pub trait Part: Send {
    /// Tells groups of nodes that it couples: every two of a group have a block in the matrix.
    fn for_each_coupling(&self, visit: &mut dyn FnMut(&[u32]));

    /// Learns what all nodes weigh, before it finds its places.
    fn weigh(&mut self, _mass: &NodeMatrix) {}

    /// Finds its places in a new pattern.
    fn place(&mut self, pattern: &Pattern);

    /// Adds its forces at an iterate and their derivative with respect to `q_1`; `memory` is what it remembered of the steps before.
    ///
    /// # Errors
    /// The iterate is no configuration of this part, or a time function failed.
    fn linearize(&self, at: &Iterate, memory: &[f64], sums: &mut Sums) -> Result<(), Refusal>;

    /// What it stores where the nodes are, remembering `memory` `[energy]`; 0 for what pushes from outside.
    fn energy(&self, at: Pose, memory: &[f64]) -> f64;

    /// Whether its forces come from outside the model, such as from the ground: then they change the momenta.
    fn is_outside(&self) -> bool {
        false
    }

    /// What the history tells of it where the nodes are and move so, by the names of [`PartDefinition::readings`].
    fn readings(&self, _at: Pose, _velocity: &[f64], _memory: &[f64]) -> Vec<f64> {
        Vec::new()
    }

    /// Masses of its own at nodes, which move and weigh as those of bodies do: node and mass `[mass]`, per thickness in the plane and of
    /// the whole circumference around an axis.
    fn point_masses(&self) -> Vec<(u32, f64)> {
        Vec::new()
    }

    /// What it remembers at the start: a block of numbers that every state keeps.
    fn memory(&self) -> Vec<f64> {
        Vec::new()
    }

    /// What it remembers after a step that has converged.
    ///
    /// # Errors
    /// A time function failed, or was interrupted: the step is not taken.
    fn remembered(&self, _at: &Iterate, memory: &[f64]) -> Result<Remembered, StepError> {
        Ok(Remembered { memory: memory.to_vec(), ..Remembered::default() })
    }
}

/// History variables of every part.
pub type PartHistories = Arc<Vec<Vec<f64>>>;

/// What a step leaves in a part.
#[derive(Default)]
pub struct Remembered {
    /// What it remembers at the end.
    pub memory: Vec<f64>,
    /// What it has turned into heat in the step `[energy]`.
    pub dissipated: f64,
    /// The share of plastic flow in it `[energy]`.
    pub plastic: f64,
}

/// Heat of each part in a step `[energy]`, bodies first; empty where nothing dissipates.
#[derive(Clone, Debug, Default)]
pub struct Heats {
    /// All of it.
    pub all: Vec<f64>,
    /// The share of plastic flow.
    pub plastic: Vec<f64>,
}

impl Heats {
    /// Adds the heat of the next part.
    pub fn push(&mut self, remembered: &Remembered) {
        self.all.push(remembered.dissipated);
        self.plastic.push(remembered.plastic);
    }
}

/// The numbers of a model's nodes, for parts that are made.
pub struct Numbering<'a> {
    /// Space dimension.
    pub dimension: usize,
    /// First node of each body.
    pub first: &'a [usize],
    /// Positions at rest, node after node `[length]`.
    pub reference: &'a [f64],
}

/// How a whole model is moved and written in other units: [`PartDefinition::changed`].
pub struct Change<'a> {
    /// Where a point goes.
    pub point: &'a dyn Fn([f64; 3]) -> [f64; 3],
    /// What a vector becomes, units left out.
    pub direction: &'a dyn Fn([f64; 3]) -> [f64; 3],
    /// Factors of mass, length and time.
    pub units: [f64; 3],
    /// Whether the model is plane, its forces then per thickness.
    pub is_plane: bool,
}

impl Change<'_> {
    /// Factor of a force, per thickness in the plane.
    pub fn force(&self) -> f64 {
        let [mass, length, time] = self.units;
        mass * length / (time * time) / self.thickness()
    }

    /// Factor of an energy and of a moment, per thickness in the plane.
    pub fn energy(&self) -> f64 {
        let [mass, length, time] = self.units;
        mass * length * length / (time * time) / self.thickness()
    }

    /// Factor of a stiffness, per thickness in the plane.
    pub fn stiffness(&self) -> f64 {
        let [mass, _, time] = self.units;
        mass / (time * time) / self.thickness()
    }

    fn thickness(&self) -> f64 {
        if self.is_plane { self.units[1] } else { 1.0 }
    }
}

/// A part of a model as it is defined.
pub trait PartDefinition: Send + Sync {
    /// Its name, unique among the parts.
    fn name(&self) -> &str;

    /// The bodies that it joins.
    fn bodies(&self) -> Vec<usize>;

    /// Names of what the history tells of it: columns `name.reading`.
    fn readings(&self) -> &'static [&'static str] {
        &[]
    }

    /// Whether it turns energy into heat, which the history then tells as a column `name.dissipation`.
    fn dissipates(&self) -> bool {
        false
    }

    /// Whether it has forces across velocities, which do no work.
    fn is_gyroscopic(&self) -> bool {
        false
    }

    /// Whether it joins its bodies to something that stays where it is.
    fn is_grounded(&self) -> bool {
        false
    }

    /// Time functions that it follows: steps land on their kinks.
    fn functions(&self) -> Vec<Amplitude> {
        Vec::new()
    }

    /// Checks what can be said without computing, nothing by itself; the argument is where a node of a body is at rest.
    ///
    /// # Errors
    /// What is wrong with it.
    fn check(&self, _point: &dyn Fn(usize, u32) -> [f64; 3]) -> Result<(), ModelError> {
        Ok(())
    }

    /// The part with its numbers.
    fn part(&self, numbering: &Numbering) -> Box<dyn Part>;

    /// The same in a model that is moved or written in other units.
    fn changed(&self, change: &Change) -> Arc<dyn PartDefinition>;

    /// One line for the list of a model.
    fn describe(&self) -> String;
}
