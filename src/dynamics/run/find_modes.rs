//! Natural vibrations about the present state: `K x = omega^2 M x` with `G x = 0` for ties and active constraints.
//!
//! The shift lies below all eigenvalues, so that Lanczos' method finds the lowest ones first. The number of eigenvalues below a value is
//! the number of negative eigenvalues of the shifted matrix (Sylvester; Parlett, The Symmetric Eigenvalue Problem, 1980): none is missed.

use super::balance::Balance;
use super::engine::Engine;
use super::modes::{Mode, Modes, ModesError};
use super::state::State;
use super::steps::Steps;
use crate::bodies::{Elements, Space};
use crate::contact::{MotionBound, PredictedMotion};
use crate::dynamics::model::step_error::StepError;
use crate::dynamics::step::failure::Failure;
use crate::dynamics::step::vibrations::{VibrationState, Vibrations};
use crate::linear::{Lanczos, LinearError, Ritz, product};
use crate::math::tolerances;

/// Factor of a negative shift above an eigenvalue.
const LOWER: f64 = 10.0;
/// Largest number of times that a shift is lowered by [`LOWER`]: unstable modes are at most as stiff as the stiffest cells.
const MOST_SHIFTS: usize = 25;

/// Largest number of Lanczos vectors per mode.
const VECTORS: usize = 20;
/// Largest number of Lanczos vectors in addition to [`VECTORS`] per mode.
const BESIDES: usize = 200;

/// Least number of vectors between two convergence checks.
const LOOK_AFTER: usize = 3;
/// Ratio of the number of vectors so far to the number between two convergence checks.
const LOOK_SHARE: usize = 24;

/// Result of a search: eigenvalues, and vectors in the Lanczos basis.
struct Found {
    ritz: Vec<Ritz>,
    lanczos: Lanczos,
    is_complete: bool,
}

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// Lowest natural vibrations about the present state, which is not changed.
    ///
    /// # Errors
    /// [`ModesError`].
    pub fn find_modes(&mut self, count: usize) -> Result<Modes, ModesError> {
        let first = self.first_shift();
        let (outcome, asymmetry, factorizations, stiffest) = self.about_rest(|vibrations, _, is_interrupted| {
            let outcome = below_all(vibrations, first).and_then(|shift| Ok((shift, search(vibrations, shift, count, is_interrupted)?)));
            (outcome, vibrations.told_asymmetry(), vibrations.factorizations, vibrations.stiffest)
        })?;
        let (shift, found) = outcome.map_err(|error| self.modes_error(error))?;
        let floor = tolerances::MODE_FLOOR * stiffest;
        let modes = found.ritz.iter().map(|ritz| self.mode(ritz, &found.lanczos, shift, floor)).collect();
        Ok(Modes {
            time: self.state.row.time,
            modes,
            mass: self.system.nodes.total_mass,
            directions: self.directions(),
            is_complete: found.is_complete,
            asymmetry,
            work: [factorizations, found.lanczos.applied()],
        })
    }

    /// Runs a search with the matrices about the present state; `search` receives a function that returns true on an interrupt. State,
    /// counters and solver data remain unchanged.
    pub(super) fn about_rest<T>(
        &mut self,
        search: impl FnOnce(&mut Vibrations<D>, &State, &dyn Fn() -> bool) -> T,
    ) -> Result<T, StepError> {
        let (state, tally) = (self.state.clone(), self.tally());
        let still = vec![0.0; self.system.nodes.count()];
        let motion_bound = MotionBound::Each { sizes: &still, besides: 0.0, is_continued: false };
        self.count_turns();
        self.begin_at_rest(&PredictedMotion { q: &state.positions, motion_bound, reach: self.options.reach, depth: 0.0 }, &[])?;
        let rest =
            VibrationState { time: state.row.time, at: state.pose(), memory: &state.memory, lambda: &state.lambda, active: &state.active };
        let options = &self.options;
        let found = search(&mut Vibrations::new(&mut self.system, rest), &state, &|| options.interrupted());
        self.count_from(&tally);
        self.restore_search();
        Ok(found)
    }

    /// First shift tried below all eigenvalues: `-MODE_SHIFT` times the least squared elastic frequency of a component.
    pub(super) fn first_shift(&self) -> f64 {
        let components = Balance::new(&self.system, &self.model).components;
        -tolerances::MODE_SHIFT * components.iter().map(|component| component.frequency_squared).fold(f64::INFINITY, f64::min)
    }

    /// Directions of rigid translation: for bodies of revolution only the axial one.
    fn directions(&self) -> Vec<usize> {
        if self.system.nodes.is_axisymmetric { vec![1] } else { (0..D).collect() }
    }

    /// Vibration mode from an eigenvalue and vector in the Lanczos basis.
    fn mode(&self, ritz: &Ritz, lanczos: &Lanczos, shift: f64, floor: f64) -> Mode {
        let x = self.shape_of(lanczos.vector(&ritz.coefficients));
        let momenta = self.system.nodes.momenta_of(&x);
        let modal_mass = product(&x, &momenta);
        let along: Vec<f64> = self.directions().into_iter().map(|i| momenta.iter().skip(i).step_by(D).sum()).collect();
        let eigenvalue = shift + 1.0 / ritz.theta;
        Mode {
            eigenvalue: if eigenvalue.abs() <= floor { 0.0 } else { eigenvalue },
            shape: self.by_body(&x),
            modal_mass,
            participation: along.iter().map(|momentum| momentum / modal_mass).collect(),
            effective_mass: along.iter().map(|momentum| momentum * momentum / modal_mass).collect(),
            residual: ritz.residual / ritz.theta,
        }
    }

    /// Nodal shape of a motion of the unknowns, including followers of rigid bodies, scaled to a longest displacement of 1.
    pub(super) fn shape_of(&self, mut x: Vec<f64>) -> Vec<f64> {
        self.system.lead(&mut x);
        scaled_to_one::<D>(x)
    }

    /// A nodal vector body by body, in space.
    pub(super) fn by_body(&self, x: &[f64]) -> Vec<Vec<[f64; 3]>> {
        let vector = |node: usize| std::array::from_fn(|i| if i < D { x[node * D + i] } else { 0.0 });
        self.system.bodies.iter().map(|body| body.nodes.clone().map(vector).collect()).collect()
    }

    pub(super) fn modes_error(&mut self, error: SearchError) -> ModesError {
        match error {
            SearchError::Failed(Failure::Linear(LinearError::Singular { .. } | LinearError::Inaccurate { .. })) => ModesError::Dependent,
            SearchError::Failed(failure) => ModesError::Step(self.error_of(failure)),
            SearchError::Refused(error) => error,
        }
    }
}

/// Scales a nodal motion to a longest displacement of 1; the sign makes the first of its (nearly) largest components positive.
fn scaled_to_one<const D: usize>(mut x: Vec<f64>) -> Vec<f64> {
    let size = |node: &[f64]| node.iter().map(|x| x * x).sum::<f64>().sqrt();
    let largest = x.chunks_exact(D).map(size).fold(0.0, f64::max);
    let widest = x.iter().fold(0.0f64, |widest, x| widest.max(x.abs()));
    let leading = x.iter().copied().find(|x| x.abs() >= (1.0 - tolerances::ALIKE) * widest).unwrap_or(1.0);
    let scale = if largest > 0.0 { leading.signum() / largest } else { 1.0 };
    // Adding 0.0 removes the sign of zeros.
    x.iter_mut().for_each(|x| *x = *x * scale + 0.0);
    x
}

/// Cause of a search without result.
pub(super) enum SearchError {
    Failed(Failure),
    Refused(ModesError),
}

impl From<Failure> for SearchError {
    fn from(failure: Failure) -> Self {
        SearchError::Failed(failure)
    }
}

/// Factorizes the matrix with a shift below all eigenvalues, if these can be counted: the first of `shift`, 10 `shift`, ...; returns it.
pub(super) fn below_all<const D: usize>(vibrations: &mut Vibrations<D>, mut shift: f64) -> Result<f64, SearchError>
where
    Space<D>: Elements<D>,
{
    for _ in 0..MOST_SHIFTS {
        vibrations.factorize(shift)?;
        if vibrations.below().is_none_or(|below| below == 0) {
            break;
        }
        shift *= LOWER;
    }
    Ok(shift)
}

/// The first `count` eigenvalues above a shift whose matrix is in the solver.
fn search<const D: usize>(
    vibrations: &mut Vibrations<D>,
    shift: f64,
    count: usize,
    interrupted: &dyn Fn() -> bool,
) -> Result<Found, SearchError>
where
    Space<D>: Elements<D>,
{
    let motions = vibrations.motions();
    if motions < count {
        return Err(SearchError::Refused(ModesError::TooMany { count, motions }));
    }
    // Block size: the number of rigid motions, which have the same eigenvalue.
    let mut lanczos = Lanczos::new(vibrations.unknowns(), (D * (D + 1) / 2).min(motions));
    let (mut wanted, mut next) = (count, count);
    loop {
        if interrupted() {
            return Err(SearchError::Failed(Failure::Linear(LinearError::Interrupted)));
        }
        let goes_on = lanczos.expand(vibrations)?;
        let is_spent = !goes_on || lanczos.applied() >= motions;
        if lanczos.applied() < next && !is_spent {
            continue;
        }
        next = lanczos.applied() + LOOK_AFTER.max(lanczos.applied() / LOOK_SHARE);
        let ritz: Vec<Ritz> = lanczos.ritz().into_iter().filter(|ritz| ritz.theta > 0.0).collect();
        let found = ritz.iter().take_while(|ritz| ritz.residual <= tolerances::MODE_RESIDUAL * ritz.theta).count();
        if is_spent && ritz.len() >= count {
            // The model has no further eigenvalues.
            return Ok(Found { ritz: ritz.into_iter().take(count).collect(), lanczos, is_complete: true });
        }
        let vectors = lanczos.applied();
        if is_spent || vectors >= VECTORS * count + BESIDES {
            return Err(SearchError::Refused(ModesError::NotFound { count, found: found.min(count), vectors }));
        }
        if found < wanted || ritz.len() == wanted {
            continue;
        }
        let Some(place) = gap_after(&ritz, wanted, found) else {
            wanted = found + 1;
            continue;
        };
        let end = shift + place;
        let first = ritz.iter().filter(|ritz| 1.0 / ritz.theta < place).count();
        vibrations.factorize(end)?;
        let below = vibrations.below();
        if below.is_none_or(|below| below <= first) {
            let is_complete = below == Some(first);
            return Ok(Found { ritz: ritz.into_iter().take(count).collect(), lanczos, is_complete });
        }
        // Lanczos vectors contain one direction of each multiple eigenvalue: a new search adds the missing ones.
        vibrations.factorize(shift)?;
        lanczos.begin(vibrations)?;
        next = lanczos.applied() + LOOK_AFTER.max(count);
    }
}

/// Middle of a gap between two eigenvalues beyond the first `wanted`, as a distance from the shift; `None` if known ones lie too close.
fn gap_after(ritz: &[Ritz], wanted: usize, found: usize) -> Option<f64> {
    let distance = |k: usize| 1.0 / ritz[k].theta;
    let is_gap = |k: &usize| distance(*k) - distance(k - 1) > tolerances::MODE_GAP * distance(*k);
    (wanted..=found.min(ritz.len() - 1)).find(is_gap).map(|k| 0.5 * (distance(k - 1) + distance(k)))
}
