//! A simulation in `D` dimensions at its present state: the equations, the state, and records of the run so far.
//!
//! Functions are grouped in files: substeps (`substep.rs`), their acceptance (`accept.rs`, `impact.rs`), rest (`settle.rs`), quantities
//! (`quantities.rs`), failures (`failed.rs`). `time_loop.rs` joins them.

use std::sync::Arc;

use super::halvings::Halvings;
use super::initial_velocities::initial_velocities;
use super::ledger::LedgerRow;
use super::options::{Options, Statistics};
use super::pace::{StepSizeState, time_of_sound};
use super::report::{FailureReport, TryReport};
use super::slip_memory::SlipMemory;
use super::state::{Clock, State};
use crate::bodies::{Elements, Inverted, Space};
use crate::dynamics::model::definitions::Model;
use crate::dynamics::model::error::ModelError;
use crate::dynamics::model::integrator_limits::check_integrator;
use crate::dynamics::model::part::Pose;
use crate::dynamics::parts::contact_pair::PairKind;
use crate::dynamics::parts::laws::RowState;
use crate::dynamics::step::attempts::PreferredAttempt;
use crate::dynamics::step::equations::Equations;
use crate::dynamics::step::system::System;
use crate::dynamics::step::task::Trace;
use crate::linear::InterruptWatch;
use crate::machine::memory;
use crate::math::tolerances;

/// A simulation in `D` dimensions.
pub struct Engine<const D: usize> {
    /// Simulated model.
    pub model: Model,
    /// Equations of the model.
    pub system: System<D>,
    /// Options of the integration.
    pub options: Options,
    /// Present state, shared with other owners; a step makes a new one.
    pub state: Arc<State>,
    /// Work done so far.
    pub statistics: Statistics,
    /// Nodes whose motion is recorded in every row of the ledger.
    pub probes: Vec<usize>,
    /// Newton iterations of the last step.
    pub trace: Trace,
    /// Attempts at the current step.
    pub tries: Vec<TryReport>,
    /// Report on the last finally failed step, and the iterate at which its solution was abandoned.
    pub failure: Option<(FailureReport, Vec<f64>)>,
    /// Halvings by cause.
    pub halvings: Halvings,
    /// Times of kinks in loads and prescribed motions, in ascending order.
    pub corners: Vec<f64>,
    /// True if friction acts in equilibria.
    pub rest_friction: bool,
    /// Time in which an elastic wave crosses a cell, 0 if all bodies are rigid `[time]`.
    pub sound: f64,
}

/// Bytes of memory per unknown, including its matrix entries but not the factors (measured: 700 to 900 before the first step, and 150 to
/// 700 for the matrix).
const UNKNOWN: u64 = 1500;

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// A model in its initial state.
    ///
    /// # Errors
    /// A model that cannot be simulated.
    pub fn new(model: &Model, options: Options) -> Result<Self, ModelError> {
        options.integrator.check().map_err(|reason| ModelError::UnsoundIntegrator { integrator: options.integrator.name, reason })?;
        model.check_stops(&options.integrator)?;
        let sound = time_of_sound(model);
        let options = Options { dt: first_step(&options, sound).ok_or(ModelError::NoFirstStep)?, ..options };
        let unknowns = D * model.bodies.iter().map(|body| body.mesh.points.len()).sum::<usize>();
        memory::ensure(UNKNOWN * unknowns as u64)
            .map_err(|shortage| ModelError::TooLarge { reason: format!("of {unknowns} unknowns, {shortage}") })?;
        check_integrator(model, &options.integrator, options.control.is_some())?;
        let mut system = System::<D>::new(model, options.threads, &options.integrator, options.solver)?;
        system.watch(InterruptWatch { interrupt: options.interrupt.clone(), progress: options.progress.clone() });
        // Errors of time functions are reported by the first step, which evaluates them again.
        let _ = system.equations.move_obstacles(0.0, 0.0);
        let displaced = (0..model.bodies.len()).flat_map(|body| model.initial_displacement(body));
        let displacements: Vec<f64> = displaced.flat_map(|u| u[..D].to_vec()).collect();
        let positions = system.nodes.positions(&displacements);
        inverted_at_start(&system, model, &displacements)?;
        let mut velocities = initial_velocities(&system, model, &positions);
        if options.integrator.is_static() {
            velocities.fill(0.0);
        }
        system
            .survey(&positions)
            .map_err(|shortage| ModelError::TooLarge { reason: format!("whose contacts couple many nodes: {shortage}") })?;
        open_equality(&system, &positions)?;
        let (momentum, angular_momentum) = system.nodes.momenta(&positions, &velocities);
        let memory = system.memory_at_rest(&displacements);
        let is_strained = !(model.initial_displacements.is_empty() && model.growths.is_empty());
        let row = LedgerRow {
            kinetic: system.nodes.kinetic_energy(&velocities),
            strain: if is_strained { system.strain_energy(&displacements, &memory) } else { 0.0 },
            potential: system.nodes.potential_energy(&positions) + system.stored_energy(Pose { q: &positions, u: &displacements }, &memory),
            momentum,
            angular_momentum,
            parts: system.part_totals(Pose { q: &positions, u: &displacements }, &velocities, &memory, &[]),
            ..LedgerRow::default()
        };
        let state = State {
            row,
            lambda: vec![0.0; system.multipliers],
            penalty_gap: vec![0.0; system.multipliers],
            reserve: vec![0.0; system.multipliers],
            active: vec![RowState::Open; system.multipliers],
            slipped: vec![SlipMemory::default(); system.multipliers - system.normal_count],
            scheme_history: Arc::default(),
            memory,
            clock: Clock { origin: 0.0, count: 0, dt: options.dt },
            search: system.search(),
            level: 0,
            pace: StepSizeState::default(),
            drift: 0.0,
            pushed: 0.0,
            preferred: PreferredAttempt::default(),
            slips_until: 0.0,
            loads_ended: 0.0,
            positions,
            displacements,
            accelerations: vec![0.0; velocities.len()],
            velocities,
        };
        Ok(Engine {
            model: model.clone(),
            system,
            options,
            state: Arc::new(state),
            statistics: Statistics::default(),
            probes: Vec::new(),
            trace: Trace::default(),
            tries: Vec::new(),
            failure: None,
            halvings: Halvings::default(),
            corners: model.corners(),
            rest_friction: true,
            sound: sound.unwrap_or_default(),
        })
    }

    /// Restores the search results of the present state.
    pub fn restore_search(&mut self) {
        self.system.restore_search(&self.state.search, &self.state.positions, self.state.row.time);
    }
}

/// Size of the first step; `None` if it depends on `sound`, the time of an elastic wave through a cell, and that time is unknown.
fn first_step(options: &Options, sound: Option<f64>) -> Option<f64> {
    match options.control {
        // Time in which an elastic wave crosses a cell, times the square root of the tolerance.
        Some(control) if options.dt == 0.0 => sound.map(|time| control.tolerance.sqrt() * time),
        _ => Some(options.dt),
    }
}

/// Refuses bilateral contacts whose sides are apart: such a constraint would keep a gap open, or close it without a contact force.
fn open_equality<const D: usize>(system: &Equations<D>, q: &[f64]) -> Result<(), ModelError> {
    for pair in system.pairs.iter().filter(|pair| pair.law.is_bilateral() && matches!(pair.kind, PairKind::Surfaces | PairKind::Obstacle)) {
        let kernel = &pair.kernel;
        let (gaps, weights, coverage) = (kernel.gap(q), kernel.weights(), kernel.coverage(q));
        let covered = (0..gaps.len()).filter(|&row| coverage[row] > tolerances::SLIVER);
        let gap = covered.map(|row| gaps[row] / (coverage[row] * weights[row])).fold(0.0, f64::max);
        let facets = gap / kernel.facet_size();
        if facets > tolerances::DEPTH {
            return Err(ModelError::OpenEquality { contact: pair.name.clone(), gap, facets });
        }
    }
    Ok(())
}

/// Refuses initial displacements that invert a cell.
fn inverted_at_start<const D: usize>(system: &Equations<D>, model: &Model, u: &[f64]) -> Result<(), ModelError> {
    for initial in &model.initial_displacements {
        let body = &system.bodies[initial.body];
        let Inverted { cell, determinant } = body.elements.smallest_determinant(u);
        if determinant <= 0.0 {
            return Err(ModelError::InvertedAtStart { body: body.name.clone(), cell, determinant });
        }
    }
    Ok(())
}
