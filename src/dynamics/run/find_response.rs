//! Steady vibrations about the present state under a harmonic force or base motion of one frequency.
//!
//! ```text
//! (K (1 + i eta + i omega beta) - omega^2 M + i omega alpha M) x = f
//! ```
//!
//! with `G x = 0` for ties and active constraints. Only stiffness and mass are on the left, so the matrix is `K - s M` with a complex `s`
//! for each frequency, and one real shift serves all: `x` is approximated in the Krylov space of `(K - sigma M)^-1 M` that starts with the
//! static response (Lanczos' method; Freund, Acta Numerica 12, 2003), until the residual is small at all frequencies. Under base motion `x`
//! is the displacement relative to the base, under the force `(omega^2 - i omega alpha) M r`.

use std::sync::Arc;

use nalgebra::Complex;

use super::engine::Engine;
use super::find_modes::below_all;
use super::harmonic::{Excitation, HarmonicError, HarmonicOptions, HarmonicResponse};
use crate::bodies::{Elements, Space};
use crate::dynamics::model::amplitude::Constant;
use crate::dynamics::model::definitions::{Load, LoadKind, Model};
use crate::dynamics::step::failure::Failure;
use crate::dynamics::step::vibrations::Vibrations;
use crate::linear::{Lanczos, LinearError, Operator, Ritz, product};
use crate::math::tolerances;

/// Largest number of vectors.
const VECTORS: usize = 600;
/// Number of vectors between two evaluations of the residual.
const LOOK_AFTER: usize = 6;

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// Steady vibrations about the present state, which is not changed.
    ///
    /// # Errors
    /// [`HarmonicError`].
    pub fn find_response(&mut self, options: &HarmonicOptions) -> Result<HarmonicResponse, HarmonicError> {
        let excited = match &options.excitation {
            Excitation::Force { on, vector } => {
                let load = Load { kind: LoadKind::Force(*vector), on: on.clone(), amplitude: Arc::new(Constant(1.0)) };
                self.system.forces_of_loads(&Model { loads: vec![load], ..self.model.clone() }, &self.state.positions)
            }
            Excitation::Base(vector) => self.system.nodes.momenta_of(&self.carried_along(*vector)),
        };
        if self.system.carries(&excited, &self.state.positions) {
            return Err(HarmonicError::Nothing);
        }
        let first = self.first_shift();
        let found = self.about_rest(|vibrations, _, is_interrupted| {
            let outcome = below_all(vibrations, first).and_then(|shift| Ok(search(vibrations, shift, excited, options, is_interrupted)?));
            (outcome, vibrations.told_asymmetry())
        });
        let (outcome, asymmetry) = found.map_err(|error| HarmonicError::Matrix(error.into()))?;
        let (mut basis, combinations, residual) = outcome.map_err(|error| HarmonicError::Matrix(self.modes_error(error)))??;
        basis.iter_mut().for_each(|vector| self.system.lead(vector));
        let base = if let Excitation::Base(vector) = options.excitation { vector } else { [0.0; 3] };
        Ok(HarmonicResponse {
            time: self.state.row.time,
            frequencies: options.frequencies.clone(),
            basis,
            combinations,
            base,
            dimension: D,
            residual,
            asymmetry,
        })
    }

    /// A translation of all nodes.
    fn carried_along(&self, vector: [f64; 3]) -> Vec<f64> {
        (0..self.system.nodes.reference.len()).map(|k| vector[k % D]).collect()
    }
}

/// Lanczos vectors, their coefficients for each frequency, and the largest relative residual.
type Found = (Vec<Vec<f64>>, Vec<Vec<Complex<f64>>>, f64);

fn search<const D: usize>(
    vibrations: &mut Vibrations<D>,
    shift: f64,
    excited: Vec<f64>,
    options: &HarmonicOptions,
    is_interrupted: &dyn Fn() -> bool,
) -> Result<Result<Found, HarmonicError>, Failure>
where
    Space<D>: Elements<D>,
{
    let mut lanczos = Lanczos::new(excited.len(), 1);
    let first = vibrations.solve(excited)?;
    let size = lanczos.begin_with(vibrations, first);
    if size == 0.0 {
        return Ok(Err(HarmonicError::Nothing));
    }
    loop {
        let is_exhausted = lanczos.is_exhausted();
        if is_exhausted || (lanczos.applied() > 0 && lanczos.applied().is_multiple_of(LOOK_AFTER)) {
            let ritz = lanczos.ritz();
            let (mut combinations, mut worst) = (Vec::with_capacity(options.frequencies.len()), (0.0f64, 0.0));
            for &frequency in &options.frequencies {
                let Some((combination, missed)) = combined(&ritz, &lanczos.coupling(), size, shift, frequency, options) else {
                    return Ok(Err(HarmonicError::Resonance { frequency }));
                };
                if missed > worst.0 {
                    worst = (missed, frequency);
                }
                combinations.push(combination);
            }
            if is_exhausted || worst.0 <= tolerances::RESPONSE {
                let basis = lanczos.into_vectors(ritz.len());
                return Ok(Ok((basis, combinations, worst.0)));
            }
            if lanczos.applied() >= VECTORS {
                return Ok(Err(HarmonicError::NotFound { frequency: worst.1, vectors: lanczos.applied() }));
            }
        }
        if is_interrupted() {
            return Err(Failure::Linear(LinearError::Interrupted));
        }
        lanczos.expand(vibrations)?;
    }
}

/// Response at a frequency in the basis, and its relative residual; `None` at an undamped resonance.
fn combined(
    ritz: &[Ritz],
    coupling: &[f64],
    size: f64,
    sigma: f64,
    frequency: f64,
    options: &HarmonicOptions,
) -> Option<(Vec<Complex<f64>>, f64)> {
    let [shift, factor] = options.shift(frequency);
    let is_base = matches!(options.excitation, Excitation::Base(_));
    let factor = factor * size * if is_base { options.mass_factor(frequency) } else { Complex::from(1.0) };
    let distance = shift - sigma;
    let mut combination = vec![Complex::default(); ritz.len()];
    for one in ritz {
        let denominator = Complex::from(1.0) - distance * one.theta;
        if denominator.norm() < tolerances::MODE_GAP * tolerances::MODE_GAP {
            return None;
        }
        let share = factor * one.coefficients[0] / denominator;
        combination.iter_mut().zip(&one.coefficients).for_each(|(sum, coefficient)| *sum += share * coefficient);
    }
    let norm = combination.iter().map(Complex::norm_sqr).sum::<f64>().sqrt();
    let parts = [|x: &Complex<f64>| x.re, |x: &Complex<f64>| x.im];
    let along = parts.map(|part| product(coupling, &combination.iter().map(part).collect::<Vec<f64>>()));
    let missed = distance.norm() * along[0].hypot(along[1]);
    Some((combination, if norm > 0.0 { missed / norm } else { 0.0 }))
}
