//! Force per mass on a body as a function of position, velocity and time: `f = M b`, with the field `b` at the nodes where forces act in
//! the step, and the body's consistent mass.
//!
//! The field needs no potential: its work is that of a load. Its derivatives are difference quotients.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;

use super::body_mass::{BodyMass, changed_mass};
use crate::dynamics::model::amplitude::TimeFunctionError;
use crate::dynamics::model::definitions::BodyDefinition;
use crate::dynamics::model::part::{Change, Iterate, Numbering, Part, PartDefinition, Refusal, Sums};
use crate::dynamics::model::step_error::StepError;
use crate::linear::{Pattern, product};
use crate::math::norms::largest_size;
use crate::math::tolerances::{SMALL_TIME, TIME_DIFFERENCE};

/// Field of accelerations. Script closures implement it, so evaluation may fail.
pub trait BodyField: Send + Sync {
    /// Force per mass as a function of position, velocity and time `[length/time^2]`.
    ///
    /// # Errors
    /// The user's function failed.
    fn value(&self, position: [f64; 3], velocity: [f64; 3], time: f64) -> Result<[f64; 3], TimeFunctionError>;
}

/// Field of accelerations in a transformed model (translated, rotated, other units): `x' = length R x + offset`.
struct Moved {
    inner: Arc<dyn BodyField>,
    /// Images of the axes, the columns of `R`.
    axes: [[f64; 3]; 3],
    /// Image of the origin.
    offset: [f64; 3],
    length: f64,
    time: f64,
}

impl Moved {
    fn new(inner: Arc<dyn BodyField>, change: &Change) -> Self {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(change.direction);
        let [_, length, time] = change.units;
        Moved { inner, axes, offset: (change.point)([0.0; 3]), length, time }
    }

    /// Components of a vector along the images of the axes.
    fn before(&self, vector: [f64; 3], scale: f64) -> [f64; 3] {
        self.axes.map(|axis| product(&axis, &vector) / scale)
    }
}

impl BodyField for Moved {
    fn value(&self, position: [f64; 3], velocity: [f64; 3], time: f64) -> Result<[f64; 3], TimeFunctionError> {
        let from_offset = [0, 1, 2].map(|i| position[i] - self.offset[i]);
        let (x, v) = (self.before(from_offset, self.length), self.before(velocity, self.length / self.time));
        let value = self.inner.value(x, v, time / self.time)?;
        let scale = self.length / (self.time * self.time);
        Ok([0, 1, 2].map(|i| scale * (0..3).map(|k| self.axes[k][i] * value[k]).sum::<f64>()))
    }
}

/// A force per mass on a body.
#[derive(Clone)]
pub struct BodyForceDefinition {
    /// Name, unique among the parts.
    pub name: String,
    /// Number of the body.
    pub body: usize,
    /// Definition of the body, from which its mass is computed.
    pub definition: BodyDefinition,
    /// Force per unit mass as a function of position, velocity and time.
    pub field: Arc<dyn BodyField>,
}

impl PartDefinition for BodyForceDefinition {
    fn name(&self) -> &str {
        &self.name
    }

    fn bodies(&self) -> Vec<usize> {
        vec![self.body]
    }

    fn part(&self, numbering: &Numbering) -> Box<dyn Part> {
        let mass = BodyMass::new(&self.definition, self.body, numbering);
        Box::new(BodyForce { dimension: numbering.dimension, name: self.name.clone(), mass, field: self.field.clone() })
    }

    fn changed(&self, change: &Change) -> Arc<dyn PartDefinition> {
        let field = Arc::new(Moved::new(self.field.clone(), change));
        Arc::new(BodyForceDefinition { definition: changed_mass(&self.definition, change), field, ..self.clone() })
    }

    fn describe(&self) -> String {
        format!("body force \"{}\" on \"{}\"", self.name, self.definition.name)
    }
}

/// A force per mass in global node numbers.
struct BodyForce {
    dimension: usize,
    name: String,
    mass: BodyMass,
    field: Arc<dyn BodyField>,
}

/// Field at a node, and its derivative with respect to the positions at the end of the step, row by row.
type At = ([f64; 3], [[f64; 3]; 3]);

impl BodyForce {
    fn at(&self, node: u32, at: &Iterate, wants_slope: bool) -> Result<At, StepError> {
        let own = |all: &[f64]| {
            let mut vector = [0.0; 3];
            (0..self.dimension).for_each(|i| vector[i] = all[node as usize * self.dimension + i]);
            vector
        };
        let (x, v, mut slope) = (own(at.q_test), own(at.velocity), [[0.0; 3]; 3]);
        let field = |x: [f64; 3], v: [f64; 3]| {
            let failed = |source| StepError::Amplitude { boundary: self.name.clone(), time: at.time, source };
            self.field.value(x, v, at.time).map_err(failed)
        };
        let value = field(x, v)?;
        let steps = [x, v].map(|all| TIME_DIFFERENCE * largest_size(&all).max(SMALL_TIME));
        let shares = [at.derivative.placement().share, at.velocity_slope];
        for (k, share) in shares.iter().enumerate().filter(|(_, share)| wants_slope && **share != 0.0) {
            for j in 0..self.dimension {
                let (mut moved, step) = ([x, v], steps[k]);
                moved[k][j] += step;
                let [x, v] = moved;
                let other = field(x, v)?;
                (0..3).for_each(|i| slope[i][j] += share * (other[i] - value[i]) / step);
            }
        }
        Ok((value, slope))
    }
}

impl Part for BodyForce {
    fn for_each_coupling(&self, _visit: &mut dyn FnMut(&[u32])) {
        // The body couples the nodes of each cell already.
    }

    fn place(&mut self, pattern: &Pattern) {
        self.mass.place(pattern);
    }

    fn linearize(&self, at: &Iterate, _memory: &[f64], sums: &mut Sums) -> Result<(), Refusal> {
        let (d, wants_slope) = (self.dimension, sums.tangent.is_some());
        let mut fields: BTreeMap<u32, At> = BTreeMap::new();
        for &(_, node, ..) in &self.mass.entries {
            if let Entry::Vacant(place) = fields.entry(node) {
                place.insert(self.at(node, at, wants_slope).map_err(Refusal::Load)?);
            }
        }
        for (row, column, mass, block) in &self.mass.entries {
            let (value, slope) = &fields[column];
            (0..d).for_each(|i| sums.load[*row as usize * d + i] += mass * value[i]);
            if let Some(values) = sums.tangent.as_deref_mut() {
                (0..d * d).for_each(|k| values[block.at(k / d, k % d)] -= at.weight * mass * slope[k / d][k % d]);
            }
        }
        Ok(())
    }

    fn is_outside(&self) -> bool {
        true
    }
}
