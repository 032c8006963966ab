//! Linear buckling of a settled state: the load factors at which a small motion meets no resistance,
//!
//! ```text
//! (K_0 + lambda (K_1 - K_0)) x = 0
//! ```
//!
//! with the stiffness `K_0` of the unloaded model and `K_1` of the state (Brendel and Ramm, Computers & Structures 12, 1980): its change by
//! stresses and displacements is proportional to the load as far as the path to the state is linear. Lanczos' method on
//! `K_0^-1 (K_0 - K_1)`, symmetric in the product of `K_0`, finds the largest `1/lambda`.

use super::buckling::{Buckling, BucklingError};
use super::engine::Engine;
use super::modes::ModesError;
use crate::bodies::{Elements, Space};
use crate::dynamics::model::definitions::LoadKind;
use crate::dynamics::step::failure::Failure;
use crate::dynamics::step::vibrations::Vibrations;
use crate::linear::{Lanczos, LinearError, Operator, Ritz, product};
use crate::math::tolerances;

/// Largest number of Lanczos vectors per factor.
const VECTORS: usize = 20;
/// Largest number of Lanczos vectors in addition to [`VECTORS`] per factor.
const BESIDES: usize = 300;
/// Number of vectors between two convergence checks.
const LOOK_AFTER: usize = 4;

/// Largest number of repeated searches for missing factors.
const MOST_RECOUNTS: usize = 8;

/// Operator `K_0^-1 (K_0 - K_1)` of the eigenvalue problem.
struct Softening<'a, 'b, const D: usize> {
    vibrations: &'a mut Vibrations<'b, D>,
    stiffness: Vec<f64>,
    change: Vec<f64>,
}

impl<const D: usize> Operator for Softening<'_, '_, D>
where
    Space<D>: Elements<D>,
{
    type Error = Failure;

    fn solve(&mut self, image: Vec<f64>) -> Result<Vec<f64>, Failure> {
        self.vibrations.solve(image)
    }

    fn mass_times(&self, v: &[f64]) -> Vec<f64> {
        self.vibrations.times(&self.stiffness, v)
    }

    fn image(&self, v: &[f64]) -> Vec<f64> {
        let mut image = self.vibrations.times(&self.change, v);
        image.iter_mut().for_each(|x| *x = -*x);
        image
    }
}

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// Smallest factors of the present load at which the model buckles; the state is not changed.
    ///
    /// # Errors
    /// [`BucklingError`].
    pub fn find_buckling(&mut self, count: usize) -> Result<Buckling, BucklingError> {
        let turns = |kind: &LoadKind| matches!(kind, LoadKind::Pressure(_) | LoadKind::Torque(_));
        if let Some(load) = self.model.loads.iter().find(|load| turns(&load.kind)) {
            return Err(BucklingError::Follows { boundary: self.model.boundary_name(&load.on) });
        }
        if self.state.displacements.iter().all(|u| *u == 0.0) {
            return Err(BucklingError::Unloaded);
        }
        let outcome = self.about_rest(|vibrations, state, is_interrupted| search(vibrations, &state.displacements, count, is_interrupted));
        let outcome = outcome.map_err(ModesError::Step)?;
        let (found, linear, is_complete) = outcome.map_err(|failure| self.modes_error(failure.into()))?;
        let found = found?;
        if found.len() < count {
            return Err(BucklingError::NotFound { count, found: found.len() });
        }
        let strain = self.system.strain_energy(&self.state.displacements, &self.state.memory);
        Ok(Buckling {
            time: self.state.row.time,
            factors: found.iter().map(|(factor, _)| *factor).collect(),
            shapes: found.into_iter().map(|(_, x)| self.by_body(&self.shape_of(x))).collect(),
            is_complete,
            nonlinearity: (strain / linear - 1.0).abs(),
        })
    }
}

/// Load factors with their shapes, strain energy of the linear model under the state's displacements, true if no factor is missing.
type Found = (Result<Vec<(f64, Vec<f64>)>, BucklingError>, f64, bool);

fn search<const D: usize>(
    vibrations: &mut Vibrations<D>,
    displacements: &[f64],
    count: usize,
    is_interrupted: &dyn Fn() -> bool,
) -> Result<Found, Failure>
where
    Space<D>: Elements<D>,
{
    let [stiffness, change] = vibrations.factorize_unloaded()?;
    if vibrations.below().is_some_and(|below| below > 0) {
        return Ok((Err(BucklingError::Loose), 1.0, false));
    }
    let linear = 0.5 * product(displacements, &vibrations.times(&stiffness, displacements));
    let motions = vibrations.motions();
    let mut operator = Softening { vibrations, stiffness, change };
    let (mut lanczos, mut recounts) = (Lanczos::new(displacements.len(), D.min(motions)), 0);
    loop {
        if is_interrupted() {
            return Err(Failure::Linear(LinearError::Interrupted));
        }
        let goes_on = lanczos.expand(&mut operator)?;
        let is_spent = !goes_on || lanczos.applied() >= motions.min(VECTORS * count + BESIDES);
        if !lanczos.applied().is_multiple_of(LOOK_AFTER) && !is_spent {
            continue;
        }
        let ritz = lanczos.ritz();
        let floor = tolerances::MODE_GAP * ritz.first().map_or(0.0, |first| first.theta.abs());
        let ritz: Vec<Ritz> = ritz.into_iter().take_while(|ritz| ritz.theta > 0.0).collect();
        let softer = ritz.iter().take_while(|ritz| ritz.theta > floor);
        let is_done = |residual: f64, theta: f64| residual <= tolerances::MODE_RESIDUAL * theta;
        let found: Vec<_> = softer.take_while(|ritz| is_spent || is_done(ritz.residual, ritz.theta)).take(count).collect();
        if found.len() < count && !is_spent {
            continue;
        }
        let of = |ritz: &&Ritz| (1.0 / ritz.theta, lanczos.vector(&ritz.coefficients));
        let done: Vec<_> = found.iter().filter(|ritz| is_done(ritz.residual, ritz.theta)).map(of).collect();
        let Some((last, _)) = done.last() else { return Ok((Ok(done), linear, false)) };
        let next = ritz.iter().map(|ritz| 1.0 / ritz.theta).find(|factor| *factor > last * (1.0 + tolerances::MODE_GAP));
        let place = next.map_or(f64::INFINITY, |next| 0.5 * (last + next)).min(last * (1.0 + tolerances::COUNTED_BEYOND));
        let known = ritz.iter().filter(|ritz| ritz.theta * place > 1.0).count();
        let below = operator.vibrations.load_factors_below(&operator.stiffness, &operator.change, place)?;
        if is_spent || recounts == MOST_RECOUNTS || below.is_none_or(|below| below <= known) {
            return Ok((Ok(done), linear, below == Some(known)));
        }
        // Lanczos vectors contain one direction of each multiple eigenvalue: a new search adds the missing ones.
        recounts += 1;
        operator.vibrations.factorize_unloaded()?;
        lanczos.begin(&mut operator)?;
    }
}
