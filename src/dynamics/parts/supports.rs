//! Supports: displacement components that are fixed or follow a time function.
//!
//! Their unknowns stay in the numbering; rows and columns of the matrix are replaced by the identity.

use crate::dynamics::model::definitions::Model;
use crate::dynamics::model::interactions::BodyBoundary;
use crate::dynamics::model::prescription::{PrescribedMotion, Prescription};
use crate::dynamics::model::step_error::StepError;

/// A displacement component that follows a time function.
pub struct PrescribedUnknown {
    /// Index of the unknown.
    pub unknown: usize,
    /// Index of the prescribed motion among the motions of the supports.
    motion: usize,
    /// Position of the node at the start `[length]`.
    place: [f64; 3],
    /// Prescribed component.
    component: usize,
    /// Displacement at the start for bodies with initial displacements, otherwise `None` `[length]`.
    start: Option<f64>,
}

/// All supports of a model.
pub struct Supports {
    /// True for each displacement component that is fixed or prescribed.
    pub fixed: Vec<bool>,
    /// Components that follow a time function.
    pub prescribed: Vec<PrescribedUnknown>,
    /// Prescribed motions with the names of their boundaries.
    motions: Vec<(Prescription, String)>,
    /// Index of the prescribed rotation of each boundary of `held`; `None` without one.
    turning: Vec<Option<usize>>,
    /// Components supported by each boundary of [`Model::support_names`]; each component belongs to one of them.
    pub held: Vec<Vec<usize>>,
}

impl Supports {
    /// Number of free displacement components of a node.
    pub fn free_components<const D: usize>(&self, node: u32) -> usize {
        self.fixed[node as usize * D..][..D].iter().filter(|fixed| !**fixed).count()
    }

    /// Supports of a model with `unknowns` components; `global` maps body and node to the node number in the model.
    pub fn new<const D: usize>(model: &Model, unknowns: usize, global: impl Fn(usize, u32) -> u32) -> Self {
        let mut fixed = vec![false; unknowns];
        let names = model.support_names();
        let number = |on: &BodyBoundary| names.iter().position(|name| *name == model.boundary_name(on));
        let mut owner = vec![None; unknowns];
        for support in &model.supports {
            for node in model.bodies[support.on.body].mesh.boundary_nodes(&support.on.boundary) {
                for i in (0..D).filter(|&i| support.components[i]) {
                    let unknown = global(support.on.body, node) as usize * D + i;
                    fixed[unknown] = true;
                    owner[unknown] = owner[unknown].or(number(&support.on));
                }
            }
        }
        let (mut prescribed, mut motions) = (Vec::new(), Vec::new());
        let mut turning = vec![None; names.len()];
        for prescription in &model.prescriptions {
            let (mesh, places) = (&model.bodies[prescription.on.body].mesh, model.start(prescription.on.body));
            let is_displaced = model.initial_displacements.iter().any(|initial| initial.body == prescription.on.body);
            for component in (0..D).filter(|&component| prescription.moves(component)) {
                for node in mesh.boundary_nodes(&prescription.on.boundary) {
                    let unknown = global(prescription.on.body, node) as usize * D + component;
                    fixed[unknown] = true;
                    owner[unknown] = number(&prescription.on);
                    // A later prescription of the same component replaces an earlier one.
                    prescribed.retain(|other: &PrescribedUnknown| other.unknown != unknown);
                    let place = places[node as usize];
                    let start = is_displaced.then(|| place[component] - mesh.points[node as usize][component]);
                    prescribed.push(PrescribedUnknown { unknown, motion: motions.len(), place, component, start });
                }
            }
            if let (Some(number), Some(_)) = (number(&prescription.on), &prescription.turn) {
                turning[number] = Some(motions.len());
            }
            motions.push((prescription.clone(), model.boundary_name(&prescription.on)));
        }
        let mut held = vec![Vec::new(); names.len()];
        owner.iter().enumerate().for_each(|(unknown, owner)| owner.iter().for_each(|&number: &usize| held[number].push(unknown)));
        Supports { fixed, prescribed, motions, turning, held }
    }

    /// Name of the boundary that moves a prescribed unknown.
    pub fn boundary(&self, prescribed: &PrescribedUnknown) -> &str {
        &self.motions[prescribed.motion].1
    }

    /// Displacements and velocities of the prescribed unknowns at a time; prescribed displacements are added to initial ones.
    ///
    /// # Errors
    /// A time function failed, or returned a value that is not finite.
    pub fn prescribed_motion(&self, time: f64) -> Result<(Vec<f64>, Vec<f64>), StepError> {
        let motions = self.motions_at(time)?;
        let begun = if self.prescribed.iter().any(|one| one.start.is_some()) { self.motions_at(0.0)? } else { Vec::new() };
        let of = |one: &PrescribedUnknown| {
            let (moved, velocity) = motions[one.motion].of(one.place, one.component);
            let before = one.start.map_or(0.0, |start| start - begun[one.motion].of(one.place, one.component).0);
            (moved + before, velocity)
        };
        Ok(self.prescribed.iter().map(of).unzip())
    }

    fn motions_at(&self, time: f64) -> Result<Vec<PrescribedMotion<'_>>, StepError> {
        let mut motions = Vec::with_capacity(self.motions.len());
        for (motion, boundary) in &self.motions {
            motions.push(motion.at(time).map_err(|source| StepError::Amplitude { boundary: boundary.clone(), time, source })?);
        }
        Ok(motions)
    }

    /// Angle of the prescribed rotation of a boundary of `held` since the start `[rad]`; 0 without one.
    pub fn turned_by(&self, boundary: usize, time: f64) -> f64 {
        let turn = self.turning[boundary].and_then(|motion| self.motions[motion].0.turn.as_ref());
        let angle = |time: f64| turn.and_then(|turn| turn.angle.value(time).ok()).unwrap_or(0.0);
        (angle(time) - angle(0.0)).abs()
    }

    /// Largest prescribed rotation of a boundary between two times `[rad]`, and that boundary's name.
    ///
    /// # Errors
    /// A time function failed.
    pub fn turned(&self, from: f64, to: f64) -> Result<(f64, &str), StepError> {
        let mut largest = (0.0, "");
        for (motion, boundary) in &self.motions {
            let Some(turn) = &motion.turn else { continue };
            let angle = |time| turn.angle.value(time).map_err(|source| StepError::Amplitude { boundary: boundary.clone(), time, source });
            let turned = angle(to)? - angle(from)?;
            if turned.abs() > largest.0 {
                largest = (turned.abs(), boundary);
            }
        }
        Ok(largest)
    }

    /// True if a boundary has a prescribed rotation.
    pub fn turn(&self) -> bool {
        self.motions.iter().any(|(motion, _)| motion.turn.is_some())
    }
}
