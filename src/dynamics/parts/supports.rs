//! Supports: displacement components that are held or follow a time function.
//!
//! They stay in the numbering; their rows and columns of the matrix are replaced by the identity.

use crate::dynamics::model::definitions::Model;
use crate::dynamics::model::interactions::BodyBoundary;
use crate::dynamics::model::prescription::{PrescribedMotion, Prescription};
use crate::dynamics::model::step_error::StepError;

/// A displacement component that follows a time function.
pub struct PrescribedUnknown {
    /// Its number.
    pub unknown: usize,
    /// Index of what moves it among the motions of the supports.
    motion: usize,
    /// Place of its node at rest `[length]`, and the direction.
    place: [f64; 3],
    component: usize,
}

/// All supports of a model.
pub struct Supports {
    /// Which displacement components are held or prescribed.
    pub fixed: Vec<bool>,
    /// Those that follow a time function.
    pub prescribed: Vec<PrescribedUnknown>,
    /// The motions with the names of their boundaries.
    motions: Vec<(Prescription, String)>,
    /// The components that each boundary of [`Model::support_names`] holds; each component belongs to one of them.
    pub held: Vec<Vec<usize>>,
}

impl Supports {
    /// How many components of a node may move.
    pub fn free_components<const D: usize>(&self, node: u32) -> usize {
        self.fixed[node as usize * D..][..D].iter().filter(|fixed| !**fixed).count()
    }

    /// The supports of a model with so many unknowns, `global` the number of a body's node in the model.
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
        for prescription in &model.prescriptions {
            let mesh = &model.bodies[prescription.on.body].mesh;
            for component in (0..D).filter(|&component| prescription.moves(component)) {
                for node in mesh.boundary_nodes(&prescription.on.boundary) {
                    let unknown = global(prescription.on.body, node) as usize * D + component;
                    fixed[unknown] = true;
                    owner[unknown] = number(&prescription.on);
                    // A later prescription of the same component replaces an earlier one.
                    prescribed.retain(|other: &PrescribedUnknown| other.unknown != unknown);
                    let place = mesh.points[node as usize];
                    prescribed.push(PrescribedUnknown { unknown, motion: motions.len(), place, component });
                }
            }
            motions.push((prescription.clone(), model.boundary_name(&prescription.on)));
        }
        let mut held = vec![Vec::new(); names.len()];
        owner.iter().enumerate().for_each(|(unknown, owner)| owner.iter().for_each(|&number: &usize| held[number].push(unknown)));
        Supports { fixed, prescribed, motions, held }
    }

    /// Name of the boundary that moves a prescribed unknown.
    pub fn boundary(&self, prescribed: &PrescribedUnknown) -> &str {
        &self.motions[prescribed.motion].1
    }

    /// Displacements and velocities of the prescribed unknowns at a time.
    ///
    /// # Errors
    /// A time function failed or gave no finite number.
    pub fn prescribed_motion(&self, time: f64) -> Result<(Vec<f64>, Vec<f64>), StepError> {
        let mut motions: Vec<PrescribedMotion> = Vec::with_capacity(self.motions.len());
        for (motion, boundary) in &self.motions {
            motions.push(motion.at(time).map_err(|source| StepError::Amplitude { boundary: boundary.clone(), time, source })?);
        }
        Ok(self.prescribed.iter().map(|one| motions[one.motion].of(one.place, one.component)).unzip())
    }

    /// The largest angle by which a boundary turns from one time to another `[rad]`, and that boundary's name.
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

    /// Whether a boundary turns.
    pub fn turn(&self) -> bool {
        self.motions.iter().any(|(motion, _)| motion.turn.is_some())
    }
}
