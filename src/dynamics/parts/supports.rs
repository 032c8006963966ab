//! Supports: displacement components that are held or follow a time function.
//!
//! They stay in the numbering; their rows and columns of the matrix are replaced by the identity.

use crate::dynamics::model::amplitude::Amplitude;
use crate::dynamics::model::definitions::Model;
use crate::dynamics::model::error::StepError;
use crate::dynamics::model::interactions::BodyBoundary;

/// A displacement component that follows a time function.
pub struct PrescribedUnknown {
    /// Its number.
    pub unknown: usize,
    /// Index of the time function among those of the supports.
    function: usize,
}

/// All supports of a model.
pub struct Supports {
    /// Which displacement components are held or prescribed.
    pub fixed: Vec<bool>,
    /// Those that follow a time function.
    pub prescribed: Vec<PrescribedUnknown>,
    /// The time functions with the names of their boundaries.
    functions: Vec<(Amplitude, String)>,
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
        let (mut prescribed, mut functions) = (Vec::new(), Vec::new());
        for prescription in &model.prescriptions {
            for node in model.bodies[prescription.on.body].mesh.boundary_nodes(&prescription.on.boundary) {
                let unknown = global(prescription.on.body, node) as usize * D + prescription.component;
                fixed[unknown] = true;
                owner[unknown] = number(&prescription.on);
                // A later prescription of the same component replaces an earlier one.
                prescribed.retain(|other: &PrescribedUnknown| other.unknown != unknown);
                prescribed.push(PrescribedUnknown { unknown, function: functions.len() });
            }
            functions.push((prescription.displacement.clone(), model.boundary_name(&prescription.on)));
        }
        let mut held = vec![Vec::new(); names.len()];
        owner.iter().enumerate().for_each(|(unknown, owner)| owner.iter().for_each(|&number: &usize| held[number].push(unknown)));
        Supports { fixed, prescribed, functions, held }
    }

    /// Name of the boundary that moves a prescribed unknown.
    pub fn boundary(&self, prescribed: &PrescribedUnknown) -> &str {
        &self.functions[prescribed.function].1
    }

    /// Displacements and velocities of the prescribed unknowns at a time.
    ///
    /// # Errors
    /// A time function failed or gave no finite number.
    pub fn prescribed_motion(&self, time: f64) -> Result<(Vec<f64>, Vec<f64>), StepError> {
        let mut values = Vec::with_capacity(self.functions.len());
        for (function, boundary) in &self.functions {
            let failed = |source| StepError::Amplitude { boundary: boundary.clone(), time, source };
            let (value, rate) = (function.value(time).map_err(failed)?, function.rate(time).map_err(failed)?);
            if !value.is_finite() || !rate.is_finite() {
                return Err(failed(format!("the time function returned {value} with rate {rate}").into()));
            }
            values.push((value, rate));
        }
        Ok(self.prescribed.iter().map(|prescribed| values[prescribed.function]).unzip())
    }
}
