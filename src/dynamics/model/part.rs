//! Interface of force elements (parts of a model).
//!
//! A part exerts forces on nodes. It lists the nodes that it couples, determines its places in the matrix, adds its forces and their
//! derivative at an iterate, and returns its stored energy and history variables. Bodies and loads are parts. A new kind of part (a
//! dashpot, an added mass) is one file with a [`PartDefinition`], which goes into [`Model::parts`](super::definitions::Model::parts), and
//! its [`Part`]; the solver does not distinguish kinds of parts.

use std::sync::Arc;

use super::amplitude::Amplitude;
use super::error::ModelError;
use super::quantity::Quantity;
use super::step_error::StepError;
use crate::bodies::Inverted;
use crate::integrators::Derivative;
use crate::linear::{NodeMatrix, Pattern};
use crate::math::workers::Workers;

/// Positions and displacements of all nodes of the model, as flat vectors, node after node.
#[derive(Clone, Copy)]
pub struct Pose<'a> {
    /// Positions `[length]`.
    pub q: &'a [f64],
    /// Displacements, accurate relative to their own size, from which strains are computed `[length]`.
    pub u: &'a [f64],
}

/// State of a step at which force elements evaluate their forces. Positions are flat, node after node, of the whole model.
pub struct Iterate<'a> {
    /// Algorithmic gradient of potentials.
    pub derivative: Derivative,
    /// Share of the forces in the equations of the step.
    pub weight: f64,
    /// Time at which loads act `[time]`.
    pub time: f64,
    /// Time step size `[time]`, 0 at rest.
    pub dt: f64,
    /// Positions at the start of the step `[length]`.
    pub q_0: &'a [f64],
    /// Positions at the end of the step `[length]`.
    pub q_1: &'a [f64],
    /// Displacements at the start, accurate relative to their own size, from which strains are computed `[length]`.
    pub u_0: &'a [f64],
    /// Displacements at the end `[length]`.
    pub u_1: &'a [f64],
    /// Positions at which loads act `[length]`.
    pub q_test: &'a [f64],
    /// Velocities at which forces act `[length/time]`: the mean over the step, or the velocities at its end, depending on the algorithmic
    /// gradient. In equilibrium iterations they are zero, or the velocities at the start if forces are evaluated without moving.
    pub velocity: &'a [f64],
    /// Derivative of each velocity component with respect to its component of `q_1` `[1/time]`; 0 for constant velocities.
    pub velocity_slope: f64,
    /// True if an equilibrium is computed, without motion.
    pub is_still: bool,
    /// Factor of the mass in the tangent, body by body `[1/time^2]`.
    pub inertia: &'a [f64],
}

#[cfg(test)]
impl<'a> Iterate<'a> {
    /// Iterate between two positions, for tests of force elements that depend on neither time nor velocity.
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

/// Sums to which force elements contribute, indexed by unknowns of the whole model.
pub struct Sums<'a> {
    /// Weighted forces of potentials with the sign of the residual, opposite to the motion that they drive `[force]`.
    pub internal: &'a mut [f64],
    /// Forces from outside, not weighted `[force]`.
    pub load: &'a mut [f64],
    /// Matrix values for the weighted derivative `[force/length]`; `None` if it is not requested.
    pub tangent: Option<&'a mut [f64]>,
    /// Threads to share work among.
    pub workers: &'a Workers,
}

/// Cause why forces could not be computed.
pub enum Refusal {
    /// A cell turned inside out.
    Inverted {
        /// Name of the body.
        body: String,
        /// The inverted cell.
        inverted: Inverted,
    },
    /// A time function failed.
    Load(StepError),
}

/// Force element of a model: contributes forces, their derivative, energy and history variables.
pub trait Part: Send {
    /// Visits groups of coupled nodes: every two nodes of a group have a block in the matrix.
    fn for_each_coupling(&self, visit: &mut dyn FnMut(&[u32]));

    /// Receives the mass matrix of all nodes, before [`Self::place`].
    fn weigh(&mut self, _mass: &NodeMatrix) {}

    /// Determines the places of the part's blocks in a new sparsity pattern.
    fn place(&mut self, pattern: &Pattern);

    /// Adds the forces of the part at an iterate and their derivative with respect to `q_1`; `memory` has the history variables at the
    /// start.
    ///
    /// # Errors
    /// The iterate is no configuration of this part, or a time function failed.
    fn linearize(&self, at: &Iterate, memory: &[f64], sums: &mut Sums) -> Result<(), Refusal>;

    /// Stored energy at a configuration with the history variables `memory` `[energy]`; 0 for external forces.
    fn energy(&self, _at: Pose, _memory: &[f64]) -> f64 {
        0.0
    }

    /// True if the forces are exerted from outside the model, such as by the ground, and change the momenta.
    fn is_outside(&self) -> bool {
        false
    }

    /// Values for the history at a configuration with the given velocities, in the order of [`PartDefinition::readings`].
    fn readings(&self, _at: Pose, _velocity: &[f64], _memory: &[f64]) -> Vec<f64> {
        Vec::new()
    }

    /// Additional masses of the part at nodes, with inertia and weight: node and mass `[mass]`, per thickness in the plane and of the whole
    /// circumference in axisymmetric models.
    fn point_masses(&self) -> Vec<(u32, f64)> {
        Vec::new()
    }

    /// History variables at the start, stored in every state.
    fn memory(&self) -> Vec<f64> {
        Vec::new()
    }

    /// History variables in an equilibrium at a time; by default those at the start.
    fn settled(&self, _time: f64, _at: Pose, _memory: &[f64]) -> Vec<f64> {
        self.memory()
    }

    /// History variables after a converged step.
    ///
    /// # Errors
    /// A time function failed, or was interrupted: the step is not taken.
    fn after_step(&self, _at: &Iterate, memory: &[f64]) -> Result<PartStepResult, StepError> {
        Ok(PartStepResult { memory: memory.to_vec(), ..PartStepResult::default() })
    }
}

/// History variables of every part.
pub type PartHistories = Arc<Vec<Vec<f64>>>;

/// Result of a step for a part: history variables and dissipation.
#[derive(Default)]
pub struct PartStepResult {
    /// History variables at the end of the step.
    pub memory: Vec<f64>,
    /// Dissipation in the step `[energy]`.
    pub dissipated: f64,
    /// Plastic part of the dissipation `[energy]`.
    pub plastic: f64,
}

/// Dissipation of each part in a step `[energy]`, bodies first; empty where nothing dissipates.
#[derive(Clone, Debug, Default)]
pub struct PartDissipation {
    /// Dissipation of each part `[energy]`.
    pub all: Vec<f64>,
    /// Dissipation of each part by plastic flow `[energy]`.
    pub plastic: Vec<f64>,
}

impl PartDissipation {
    /// Appends the dissipation of the next part.
    pub fn push(&mut self, result: &PartStepResult) {
        self.all.push(result.dissipated);
        self.plastic.push(result.plastic);
    }
}

/// Node numbers of a model, from which force elements are made.
pub struct Numbering<'a> {
    /// Space dimension.
    pub dimension: usize,
    /// First node of each body.
    pub first: &'a [usize],
    /// Reference positions, node after node `[length]`.
    pub reference: &'a [f64],
}

/// Transformation of a whole model to another position and other units: [`PartDefinition::changed`].
pub struct Change<'a> {
    /// Map of a point to its position after the transformation, in the new units.
    pub point: &'a dyn Fn([f64; 3]) -> [f64; 3],
    /// Map of directions, without change of units.
    pub direction: &'a dyn Fn([f64; 3]) -> [f64; 3],
    /// Factors of mass, length and time.
    pub units: [f64; 3],
    /// True if the model is plane, with forces per thickness.
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

/// Place at which a force element acts.
#[derive(Clone, Debug, PartialEq)]
pub enum PartPlace {
    /// Weighted mean of nodes of a body; the weights add up to 1.
    Nodes(usize, Vec<(u32, f64)>),
    /// Point of a body, or of the ground (`None`), at its reference position `[length]`.
    Point(Option<usize>, [f64; 3]),
}

/// Definition of a force element.
pub trait PartDefinition: Send + Sync {
    /// Name of the part, unique among the parts.
    fn name(&self) -> &str;

    /// Indices of the bodies that the part connects.
    fn bodies(&self) -> Vec<usize>;

    /// Mass that the part adds to a body `[mass]`, per thickness in the plane.
    fn mass_on(&self, _body: usize) -> f64 {
        0.0
    }

    /// Values for the history: columns `name.reading`, with their dimensions.
    fn readings(&self) -> &'static [Quantity] {
        &[]
    }

    /// True if the part dissipates energy; the history then has a column `name.dissipation`.
    fn dissipates(&self) -> bool {
        false
    }

    /// True if the part has gyroscopic forces, normal to velocities, which do no work.
    fn is_gyroscopic(&self) -> bool {
        false
    }

    /// True if the part connects its bodies to the ground.
    fn is_grounded(&self) -> bool {
        false
    }

    /// Time functions of the element; steps end at their kinks.
    fn functions(&self) -> Vec<Amplitude> {
        Vec::new()
    }

    /// Places at which the element acts, for pictures: two of a line, none of an element that acts everywhere.
    fn places(&self) -> Vec<PartPlace> {
        Vec::new()
    }

    /// Checks the definition before anything is computed; `_point` gives the reference position of a body's node.
    ///
    /// # Errors
    /// Cause why the definition is refused.
    fn check(&self, _point: &dyn Fn(usize, u32) -> [f64; 3]) -> Result<(), ModelError> {
        Ok(())
    }

    /// Makes the force element from its definition.
    fn part(&self, numbering: &Numbering) -> Box<dyn Part>;

    /// Returns the definition in a transformed model: moved or in other units.
    fn changed(&self, change: &Change) -> Arc<dyn PartDefinition>;

    /// Description of the element in one line, for the list of a model.
    fn describe(&self) -> String;
}
