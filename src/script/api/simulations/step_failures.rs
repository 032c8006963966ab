//! Message of a failed step, in terms of the script: place, cause, hint.

use super::handle::SimulationHandle;
use crate::dynamics::{BodyBoundary, FailureCause, Interaction, LoadKind, Missing, PERSISTENCY, StepError, default_rule};
use crate::math::norms::diameter;
use crate::script::api::remedies::ScriptWords;
use crate::script::api::time_functions::ClosureError;
use crate::script::language::digits::{brief, vector_text};
use crate::script::language::failure::{Class, interrupted};
use crate::script::language::prelude::*;

/// Ratio of stress to Young's modulus above which a load crushes a body, whatever its law.
const CRUSHES: f64 = 0.5;

impl SimulationHandle {
    /// Describes an overlap, such as `by 0.02 mm, 0.21 facets, at [1.0, 2.0] mm`.
    pub(super) fn overlap_text(&self, depth: f64, facets: f64, at: &[f64]) -> String {
        let told = |number: String| self.0.told(number, "length");
        format!("by {}, {facets:.2} facets, at {}", told(brief(depth)), told(vector_text(at)))
    }

    /// Failure of the call that requested the step.
    pub(super) fn step_failure(&self, call: &Call, error: StepError) -> Failure {
        let told = |text: String| self.0.with_units(&text);
        let (title, hint, code) = (told(error.to_string()), told(error.remedy()), error.code());
        let failure = match error {
            StepError::Interrupted { time } => interrupted(told(format!("interrupted at t = {}", brief(time)))).hint(hint),
            // The run can be resumed from its last accepted step, as after an interrupt.
            StepError::Ranks { .. } => interrupted(title).hint(hint),
            StepError::StillOverlaps { depth, facets, at, .. } => call.fail(title).cause(self.overlap_text(depth, facets, &at)).hint(hint),
            StepError::OutOfMemory { .. }
            | StepError::Contradiction { .. }
            | StepError::Blocked { .. }
            | StepError::Unyielding { .. }
            | StepError::Jammed { .. }
            | StepError::TurnsFar { .. }
            | StepError::TooLong { .. }
            | StepError::RanAway { .. } => Failure::new(Class::Numerics, title).hint(hint),
            StepError::Amplitude { source, .. } | StepError::Friction { source, .. } => {
                match source.downcast_ref::<ClosureError>().and_then(ClosureError::error) {
                    Some(inner) => call.fail(title).caused_by(inner),
                    None => call.fail(title).cause(source.to_string()).hint(hint),
                }
            }
            // A failure without a step size comes from `settle`.
            StepError::NotConverged { dt: 0.0, cause, .. } => self.no_equilibrium(told(cause), hint),
            StepError::NotConverged { time, step, dt, halvings, cause, .. } => {
                let (time, dt) = (brief(time), brief(dt));
                let title = format!("Newton's method did not converge at t = {time} (step {step}, dt = {dt}, after {halvings} halvings)");
                let failure = self.not_converged(told(title), told(cause), hint);
                let failure = match self.contact_hint() {
                    Some(hint) => failure.hint(hint),
                    None => failure,
                };
                let failure = match self.keeps_depth() {
                    Some(contact) => failure.hint(format!(
                        "between rigid bodies `persistency` keeps the depth of contact \"{contact}\", and from two sides that jams: \
                         `update: \"gap\"` keeps none"
                    )),
                    None => failure,
                };
                if call.host.settings.interactive { failure.hint("`sim.why()` shows the iterations") } else { failure }
            }
        };
        failure.code(code)
    }

    /// Returns the failure of a completed run with a remaining overlap that the script has not accepted.
    pub fn overlap_left(&self) -> Option<Failure> {
        let has_stepped = self.0.history.borrow().len() > 1;
        if !has_stepped || self.0.accepts_overlap.get() {
            return None;
        }
        let error = self.0.simulation.try_borrow().ok()?.check_apart().err()?;
        let (title, hint) = (self.0.with_units(&error.to_string()), self.0.with_units(&error.remedy()));
        let code = error.code();
        let StepError::StillOverlaps { contact, depth, facets, at, .. } = error else { return None };
        let failure = Failure::new(Class::Numerics, title).code(code).cause(self.overlap_text(depth, facets, &at)).hint(hint);
        Some(failure.placed(self.0.model.place_of_contact(&contact)))
    }

    fn no_equilibrium(&self, cause: String, hint: String) -> Failure {
        let failure = self.not_converged("no static equilibrium was found".into(), cause, hint);
        // Gaps of this method jump when a node passes the end of the other surface or enters one of its corners.
        let failure = [self.crushed(), self.contact_hint()].into_iter().flatten().fold(failure, Failure::hint);
        let by_nodes = |contact: &&Interaction| self.is_lost() && contact.method.is_nodal;
        match self.0.model.model.interactions.iter().find(by_nodes) {
            Some(contact) => {
                let name = &contact.name;
                failure.hint(format!("`node_to_segment()` often has no equilibrium at rest: use `mortar()` for contact \"{name}\""))
            }
            None => failure,
        }
    }

    /// Hint to check the units, if the weight of a body or a load per area is of the order of Young's modulus, which no body can carry.
    fn crushed(&self) -> Option<String> {
        let model = &self.0.model.model;
        let time = self.0.simulation.try_borrow().ok()?.time();
        let size = |vector: [f64; 3]| vector.iter().map(|x| x * x).sum::<f64>().sqrt();
        let units = "use one set of units for all: N, m, kg and s with stresses in N/m^2, or N, mm, t and s with stresses in N/mm^2";
        for (index, body) in model.bodies.iter().enumerate().filter(|(_, body)| body.rigid.is_none()) {
            let modulus = body.material.youngs_modulus();
            // Gravity times the height of the body along it.
            let along = |x: &[f64; 3]| (0..3).map(|i| model.gravity[i] * x[i]).sum::<f64>();
            let [low, high] = body.mesh.points.iter().map(along).fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)]);
            let weight = body.material.density() * (high - low) / modulus;
            // Side of a square or cube of this size.
            let side = diameter(body.mesh.points.iter()) / (body.mesh.dimension() as f64).sqrt();
            if weight > CRUSHES {
                return Some(format!(
                    "the weight of body \"{}\" alone presses it by {weight:.0e} times Young's modulus: {units}",
                    body.name
                ));
            }
            for load in model.loads.iter().filter(|load| load.on.body == index) {
                let stress = match load.kind {
                    LoadKind::Traction(vector) => size(vector),
                    LoadKind::Pressure(pressure) => pressure.abs(),
                    LoadKind::Force(vector) => size(vector) / side.powi(body.mesh.dimension() as i32 - 1),
                    LoadKind::Torque(_) => 0.0,
                };
                let part = stress * load.amplitude.value(time).map_or(0.0, f64::abs) / modulus;
                if part > CRUSHES {
                    let name = model.boundary_name(&load.on);
                    return Some(format!("the load on \"{name}\" presses by {part:.0e} times Young's modulus of its body: {units}"));
                }
            }
        }
        None
    }

    /// Returns a numerical failure; its hint is kept for `sim.why()`.
    fn not_converged(&self, title: String, cause: String, hint: String) -> Failure {
        *self.0.hint.borrow_mut() = hint.clone();
        Failure::new(Class::Numerics, title).cause(cause).hint(hint)
    }

    /// Returns the name of a contact between rigid bodies with the update rule `PERSISTENCY`, which keeps penetrations from step to step.
    fn keeps_depth(&self) -> Option<&str> {
        let model = &self.0.model.model;
        let by_default = default_rule(&self.0.simulation.try_borrow().ok()?.options().integrator);
        let rule = |interaction: &Interaction| interaction.update.unwrap_or(by_default);
        let is_rigid = |on: &BodyBoundary| model.bodies[on.body].rigid.is_some();
        let keeps = |one: &&Interaction| {
            *rule(one) == PERSISTENCY && is_rigid(&one.secondary) && !one.primary().is_empty() && one.primary().iter().all(is_rigid)
        };
        model.interactions.iter().find(keeps).map(|interaction| interaction.name.as_str())
    }

    /// True if the iterations of the last failure diverged, stalled or cycled without an apparent fault of supports and loads.
    fn is_lost(&self) -> bool {
        use FailureCause::{CyclingContact, Divergence, InvertedCell, NoEquilibrium, SlowConvergence};
        let simulation = self.0.simulation.try_borrow();
        simulation.is_ok_and(|simulation| {
            let cause = simulation.failure().map(|report| &report.cause);
            let cycles = matches!(
                cause,
                Some(CyclingContact { .. } | NoEquilibrium { missing: None | Some(Missing::Guidance | Missing::Friction), .. })
            );
            cycles || matches!(cause, Some(Divergence | InvertedCell { .. } | SlowConvergence))
        })
    }
}
