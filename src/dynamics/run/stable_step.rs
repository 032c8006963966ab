//! Longest stable explicit step: `omega dt <= 2` for the fastest vibration about the present state.
//!
//! The step is found without a matrix, by Lanczos' method on `m^-1 K` (Parlett, The Symmetric Eigenvalue Problem, 1980), with `K x` from
//! the change of the forces along `x`. Dampers, whose velocities lag by half a step, count as a stiffness: with `K + 2 C/dt` the condition
//! is unchanged. Penalties count as if active, by their largest stiffness relative to the nodal masses on either side. The fastest single
//! cell gives a bound, and shows where the mesh limits the step.

use super::engine::Engine;
use crate::bodies::{Elements, FastestCell, Space};
use crate::dynamics::model::step_error::StepError;
use crate::dynamics::parts::contact_pair::ContactPair;
use crate::dynamics::step::equations::Equations;
use crate::dynamics::step::failure::Failure;
use crate::dynamics::step::start::{StepKind, StepStart};
use crate::integrators::Lumping;
use crate::linear::{Lanczos, Operator};
use crate::math::tolerances;

/// Largest number of vectors.
const VECTORS: usize = 150;
/// Number of vectors between two evaluations.
const LOOK_AFTER: usize = 5;

/// Largest number of iterations for a step that depends on its own size because of dampers.
const TRIES: usize = 20;

/// Longest stable explicit step, and its cause.
#[derive(Clone, Debug, PartialEq)]
pub struct StableStep {
    /// Stable time step size `[time]`.
    pub dt: f64,
    /// Angular frequency of the fastest vibration, as resolved by steps of this size `[1/time]`.
    pub frequency: f64,
    /// Step size by the fastest cell alone, an upper bound of `dt` without dampers and penalties `[time]`.
    pub bound: f64,
    /// Body with the fastest cell.
    pub body: String,
    /// Index of the fastest cell in its mesh.
    pub cell: usize,
    /// Share of penalties in the square of the frequency.
    pub penalty_share: f64,
}

/// Operator `m^-1 K` at a state, for Lanczos' method.
struct Fastest<'a, const D: usize> {
    system: &'a Equations<D>,
    start: &'a StepStart<'a>,
    mobility: Vec<f64>,
    /// Time step size for damping terms.
    dt: f64,
}

impl<const D: usize> Operator for Fastest<'_, D>
where
    Space<D>: Elements<D>,
{
    type Error = Failure;

    fn solve(&mut self, image: Vec<f64>) -> Result<Vec<f64>, Failure> {
        let x: Vec<f64> = image.iter().zip(&self.mobility).map(|(image, mobility)| image * mobility).collect();
        let largest = x.iter().fold(0.0f64, |largest, x| largest.max(x.abs()));
        if largest == 0.0 {
            return Ok(x);
        }
        let size = tolerances::SMALL_MOTION * self.system.nodes.extent / largest;
        let forces = self.system.force_change(self.start, &x, 0.5 * self.dt, size)?;
        Ok(forces.iter().zip(&self.mobility).map(|(force, mobility)| force * mobility).collect())
    }

    fn mass_times(&self, v: &[f64]) -> Vec<f64> {
        self.system.nodes.momenta_of(v)
    }
}

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// Longest stable explicit step about the present state, which is not changed.
    pub(super) fn stable_step(&mut self) -> Result<StableStep, StepError> {
        let state = self.state.clone();
        let lumping = self.options.integrator.lumping().expect("the steps are explicit");
        let undamped = vec![0.0; self.system.bodies.len()];
        let kind = StepKind::Rest { damping: &undamped, velocities: None };
        let start = StepStart { time: state.row.time, q_0: &state.positions, u_0: &state.displacements, memory: &state.memory, kind };
        let (body, FastestCell { cell, frequency_squared }) = fastest_cell(&self.system, lumping, &state.displacements);
        let body = self.system.bodies[body].name.clone();
        let bound = 2.0 / frequency_squared.sqrt();
        let by_penalties = penalties(&self.system);
        let mut dt = bound;
        let mut squared = 0.0;
        for _ in 0..TRIES {
            squared = self.fastest(&start, dt).map_err(|failure| self.error_of(failure))? + by_penalties;
            let next = 2.0 / squared.sqrt();
            let is_found = self.system.others.is_empty() || (next - dt).abs() < tolerances::FASTEST * dt;
            dt = next;
            if is_found {
                break;
            }
        }
        Ok(StableStep { dt, frequency: squared.sqrt(), bound, body, cell, penalty_share: by_penalties / squared })
    }

    /// Square of the largest angular frequency, from below within the relative error [`tolerances::FASTEST`].
    fn fastest(&self, start: &StepStart, dt: f64) -> Result<f64, Failure> {
        let unknowns = start.q_0.len();
        let mobility = (0..unknowns).map(|k| self.system.mobility(k)).collect();
        let mut operator = Fastest { system: &self.system, start, mobility, dt };
        let (mut lanczos, mut largest) = (Lanczos::new(unknowns, 1), 0.0);
        while lanczos.applied() < VECTORS {
            let goes_on = lanczos.expand(&mut operator)?;
            if goes_on && !lanczos.applied().is_multiple_of(LOOK_AFTER) {
                continue;
            }
            let Some(first) = lanczos.ritz().into_iter().next() else { break };
            largest = first.theta + first.residual;
            if !goes_on || first.residual <= tolerances::FASTEST * first.theta {
                break;
            }
            if self.options.interrupted() {
                return Err(Failure::Fatal(StepError::Interrupted { time: start.time }));
            }
        }
        Ok(largest)
    }

    /// Refuses steps longer than the stable one.
    pub(super) fn check_stable(&mut self) -> Result<(), StepError> {
        if self.options.integrator.lumping().is_none() {
            return Ok(());
        }
        let StableStep { dt: stable, frequency, body, cell, penalty_share, .. } = self.stable_step()?;
        let (time, dt) = (self.state.row.time, self.options.dt);
        if dt > stable { Err(StepError::TooLong { time, dt, stable, frequency, body, cell, penalty_share }) } else { Ok(()) }
    }
}

/// Fastest cell of all bodies, with the index of its body.
fn fastest_cell<const D: usize>(system: &Equations<D>, lumping: Lumping, u: &[f64]) -> (usize, FastestCell) {
    let all = system.bodies.iter().map(|body| body.elements.fastest_cell(lumping, u)).enumerate();
    let fastest = all.max_by(|(_, a), (_, b)| a.frequency_squared.total_cmp(&b.frequency_squared));
    fastest.unwrap_or((0, FastestCell { cell: 0, frequency_squared: 0.0 }))
}

/// Bound of the contribution of active penalties to a squared frequency: `k w / m` of the nodes on either side, with the penalty stiffness
/// `k` per area and the area `w` of a node.
fn penalties<const D: usize>(system: &Equations<D>) -> f64 {
    let of = |pair: &ContactPair| {
        let weights = pair.kernel.weights();
        let of_depth = pair.penalties.iter().zip(weights).map(|(kappa, weight)| kappa * weight).fold(0.0, f64::max);
        let least = |nodes: &[u32]| nodes.iter().map(|&node| system.nodes.nodal_mass[node as usize]).fold(f64::INFINITY, f64::min);
        let widest = weights.iter().copied().fold(0.0, f64::max);
        let sides = [least(pair.kernel.secondary().nodes()), least(pair.kernel.primary().nodes())];
        sides.iter().map(|mass| of_depth * widest / mass).sum::<f64>()
    };
    // Penalties of different surfaces act on different nodes: their largest value counts.
    system.pairs.iter().filter(|pair| !pair.has_multipliers()).map(of).fold(0.0, f64::max)
}
