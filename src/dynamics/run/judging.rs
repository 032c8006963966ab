//! Whether a step that has converged is accurate enough, where steps choose their size.

use super::engine::Engine;
use super::options::Options;
use super::ledger::ContactTotals;
use super::pace::{Measure, Stepped, Touch};
use super::state::State;
use super::substeps::Substeps;
use crate::bodies::{Elements, Space};
use crate::dynamics::model::definitions::{BodyDefinition, Model};
use crate::dynamics::model::error::ModelError;
use crate::dynamics::step::counters::Counters;
use crate::dynamics::step::failure::Failure;
use crate::dynamics::step::system::System;
use crate::math::tolerances;

/// Times that sound takes across a cell for which a contact must have been open for a touch to be a first one: nodes of a surface that presses
/// bounce with the mesh.
const BOUNCE: f64 = 10.0;

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// A state at the end of a step of size `dt` with what it knows of the next one; `before`: what had been done before the step.
    ///
    /// # Errors
    /// The error of the step is too large.
    pub fn judged(&mut self, state: State, dt: f64, substeps: &Substeps, before: Counters) -> Result<State, Failure> {
        let Some(control) = self.options.control else { return Ok(state) };
        let (old, options) = (&self.state, &self.options);
        let scheme = options.integrator.after(old.remembered.dt, dt);
        let chosen = old.pace.size(&control, options.dt);
        let is_cut = substeps.is_whole() && dt < chosen * (1.0 - tolerances::SAME_MOMENT);
        let touch = first_touch(&old.row.contacts, &state.row.contacts, |contact| old.pace.is_open(contact, BOUNCE * self.sound));
        let step = Stepped { scheme: &scheme, dt, u: [&old.displacements, &state.displacements], v_0: &old.velocities, is_cut, touch };
        match old.pace.after(&step, &control, options.dt, &self.system) {
            Ok(pace) => {
                let pace = pace.with_contacts(dt, state.row.contacts.iter().map(|contact| contact.active > 0));
                Ok(State { pace: if substeps.level() > 0 { pace.held(dt) } else { pace }, ..state })
            }
            Err(size) => {
                let counters = &mut self.system.counters;
                counters.discarded = before.discarded + (counters.factorizations - before.factorizations);
                self.restore_search();
                Err(Failure::Inexact { size })
            }
        }
    }
}

impl<const D: usize> Measure for System<D>
where
    Space<D>: Elements<D>,
{
    fn size(&self, vector: &[f64], free: bool) -> f64 {
        let masses = &self.nodes.lumped_mass;
        let of_body = |nodes: std::ops::Range<usize>| {
            let unknowns = (nodes.start * D..nodes.end * D).filter(|&k| !free || !self.supports.fixed[k]);
            let sum: f64 = unknowns.map(|k| masses[k / D] * vector[k].powi(2)).sum();
            let mass: f64 = masses[nodes].iter().sum();
            if mass > 0.0 { (sum / mass).sqrt() } else { 0.0 }
        };
        self.bodies.iter().map(|body| of_body(body.nodes.clone())).fold(0.0, f64::max)
    }
}

/// The first touch of a contact within a step, the deepest of those that have been open.
fn first_touch(before: &[ContactTotals], after: &[ContactTotals], is_open: impl Fn(usize) -> bool) -> Option<Touch> {
    let none = ContactTotals::default();
    let (mut depth, mut is_kept) = (0.0f64, false);
    for (index, now) in after.iter().enumerate() {
        let before = before.get(index).unwrap_or(&none);
        if before.active == 0 && is_open(index) {
            depth = depth.max(now.penetration - before.penetration);
            is_kept |= now.active > 0 && before.penetration == 0.0;
        }
    }
    let passed = (depth > 0.0).then_some(Touch::Passed(depth));
    passed.or(is_kept.then_some(Touch::Kept))
}

/// Size of the first step: the nominal one, or short against what vibrates fastest, by as much as the tolerance asks for `[time]`.
///
/// # Errors
/// Nothing vibrates.
pub fn first_step(model: &Model, options: &Options) -> Result<f64, ModelError> {
    match options.control {
        Some(control) if options.dt == 0.0 => {
            time_of_sound(model).map(|time| control.tolerance.sqrt() * time).ok_or(ModelError::NoFirstStep)
        }
        _ => Ok(options.dt),
    }
}

/// The time that sound takes across a cell, where it is shortest `[time]`; `None` where all bodies are rigid.
fn time_of_sound(model: &Model) -> Option<f64> {
    let of_body = |body: &BodyDefinition| {
        let points = &body.mesh.points;
        let extent = |i: usize| {
            let ends = points.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], point| [a.min(point[i]), b.max(point[i])]);
            ends[1] - ends[0]
        };
        let dimension = body.mesh.dimension();
        let volume: f64 = (0..dimension).map(extent).product();
        let cell = (volume / points.len() as f64).powf(1.0 / dimension as f64);
        cell * (body.material.density() / body.material.stiffness()).sqrt()
    };
    model.bodies.iter().filter(|body| body.rigid.is_none()).map(of_body).reduce(f64::min)
}
