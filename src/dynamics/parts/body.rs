//! A body, deformable or rigid, in global node numbers.

use std::ops::Range;
use std::sync::OnceLock;

use super::rigid_body::RigidBody;
use crate::bodies::{Advance, BodyState, ElementLoop, Recovery, Step};
use crate::dynamics::model::part::{Iterate, Part, PartStepResult, Pose, Refusal, Sums};
use crate::dynamics::model::step_error::StepError;
use crate::linear::Pattern;

/// Body of the model. Bodies are evaluated before all other force elements: they set the sums of their nodes, the others add to these.
pub struct Body<const D: usize> {
    /// Name of the body.
    pub name: String,
    /// Index of the body in the model.
    pub number: usize,
    /// Range of the body's nodes.
    pub nodes: Range<usize>,
    /// True if the mass is lumped at the nodes and therefore not added by the element loop.
    pub is_lumped: bool,
    /// Element loop over the body's cells.
    pub elements: Box<dyn ElementLoop<D>>,
    /// Recovery of nodal values from values in the cells, computed on first use.
    pub recovery: OnceLock<Recovery>,
    /// Masters and dependent nodes of a rigid body; `None` for a deformable one.
    pub rigid: Option<RigidBody>,
}

impl<const D: usize> Part for Body<D> {
    fn for_each_coupling(&self, visit: &mut dyn FnMut(&[u32])) {
        self.elements.cliques().iter().for_each(|clique| visit(clique));
    }

    fn place(&mut self, pattern: &Pattern) {
        self.elements.place(pattern);
    }

    fn linearize(&self, at: &Iterate, history: &[f64], sums: &mut Sums) -> Result<(), Refusal> {
        let inertia = if self.is_lumped { 0.0 } else { at.inertia[self.number] };
        let step = Step { inertia, ..step_of(at, history) };
        let outcome = self.elements.assemble(&step, sums.internal, sums.tangent.as_deref_mut(), sums.workers);
        outcome.map_err(|inverted| Refusal::Inverted { body: self.name.clone(), inverted })
    }

    fn energy(&self, at: Pose, history: &[f64]) -> f64 {
        self.elements.strain_energy(BodyState { u: at.u, history }) + self.elements.relaxing_energy(history)
    }

    fn memory(&self) -> Vec<f64> {
        vec![0.0; self.elements.history()]
    }

    fn after_step(&self, at: &Iterate, history: &[f64]) -> Result<PartStepResult, StepError> {
        let Advance { history, plastic, viscous } = self.elements.advance(&step_of(at, history));
        Ok(PartStepResult { memory: history, dissipated: plastic + viscous, plastic })
    }
}

/// Step data for cells without mass.
pub(super) fn step_of<'a>(at: &Iterate<'a>, history: &'a [f64]) -> Step<'a> {
    let Iterate { derivative, weight, u_0, u_1, dt, .. } = *at;
    Step { derivative, weight, inertia: 0.0, u_0, u_1, history, dt }
}
