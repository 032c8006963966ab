//! Steady vibrations as values: options, and complex amplitudes of nodes at several frequencies.

use nalgebra::Complex;
use thiserror::Error;

use super::modes::ModesError;
use crate::dynamics::model::interactions::BodyBoundary;

/// Harmonic excitation.
#[derive(Clone, Debug)]
pub enum Excitation {
    /// A force on a boundary, spread evenly `[force]`.
    Force {
        /// Loaded boundary.
        on: BodyBoundary,
        /// Amplitude of the force `[force]`.
        vector: [f64; 3],
    },
    /// Common motion of all supports and of the surroundings with this amplitude `[length]`.
    Base([f64; 3]),
}

/// Options of a harmonic analysis.
#[derive(Clone, Debug)]
pub struct HarmonicOptions {
    /// Angular frequencies `[1/time]`.
    pub frequencies: Vec<f64>,
    /// Excitation.
    pub excitation: Excitation,
    /// Damping by the mass, `alpha` `[1/time]`.
    pub mass_damping: f64,
    /// Damping by the stiffness, `beta` `[time]`.
    pub stiffness_damping: f64,
    /// Loss factor `eta` of the stiffness.
    pub loss_factor: f64,
}

/// Steady vibrations at several frequencies.
#[derive(Clone, Debug)]
pub struct HarmonicResponse {
    /// Time of the state `[time]`.
    pub time: f64,
    /// Angular frequencies `[1/time]`.
    pub frequencies: Vec<f64>,
    /// Basis vectors whose linear combinations are the vibrations, with all components of all nodes.
    pub(super) basis: Vec<Vec<f64>>,
    /// Coefficients of the basis vectors for each frequency.
    pub(super) combinations: Vec<Vec<Complex<f64>>>,
    /// Motion of the base.
    pub(super) base: [f64; 3],
    pub(super) dimension: usize,
    /// Largest relative residual of all frequencies.
    pub residual: f64,
    /// Relative asymmetry of the stiffness, as in modes.
    pub asymmetry: f64,
}

impl HarmonicResponse {
    /// Complex amplitude of the displacement of a node (numbered over all bodies) at each frequency `[length]`:
    /// `x(t) = Re(amplitude exp(i omega t))`, real parts in phase with the excitation.
    pub fn at(&self, node: usize) -> Vec<[[f64; 2]; 3]> {
        let component = |combination: &[Complex<f64>], i: usize| {
            let along = self.basis.iter().zip(combination).map(|(vector, share)| share * vector[node * self.dimension + i]);
            let sum = along.sum::<Complex<f64>>() + self.base[i];
            [sum.re, sum.im]
        };
        let of = |combination: &Vec<Complex<f64>>| {
            std::array::from_fn(|i| if i < self.dimension { component(combination, i) } else { [0.0; 2] })
        };
        self.combinations.iter().map(of).collect()
    }
}

/// Error of a harmonic analysis.
#[derive(Debug, Error)]
pub enum HarmonicError {
    /// The matrix could not be made or solved with.
    #[error(transparent)]
    Matrix(#[from] ModesError),
    /// Resonance: the excitation of an undamped model has a natural frequency.
    #[error("the vibration with the angular frequency {frequency} grows without bound: it is a natural one, and it is not damped")]
    Resonance {
        /// The frequency `[1/time]`.
        frequency: f64,
    },
    /// The residual is too large with the largest admitted number of vectors.
    #[error("the response at the angular frequency {frequency} was not found with {vectors} vectors")]
    NotFound {
        /// The frequency `[1/time]`.
        frequency: f64,
        /// Number of vectors used.
        vectors: usize,
    },
    /// The excitation is zero, or acts on supported unknowns only.
    #[error("nothing is excited: the force acts on what is held, or is zero")]
    Nothing,
}

impl HarmonicError {
    /// Stable code of the error, explained by `conserva doc`.
    pub fn code(&self) -> &'static str {
        match self {
            HarmonicError::Matrix(error) => error.code(),
            HarmonicError::Resonance { .. } => "C0711",
            HarmonicError::NotFound { .. } => "C0712",
            HarmonicError::Nothing => "C0713",
        }
    }
}

impl HarmonicOptions {
    /// The complex shift of a frequency, and the factor of its force.
    pub(super) fn shift(&self, frequency: f64) -> [Complex<f64>; 2] {
        let stiffness = Complex::new(1.0, self.loss_factor + frequency * self.stiffness_damping);
        [self.mass_factor(frequency) / stiffness, stiffness.inv()]
    }

    /// Complex factor of the mass in the dynamic stiffness.
    pub(super) fn mass_factor(&self, frequency: f64) -> Complex<f64> {
        Complex::new(frequency * frequency, -frequency * self.mass_damping)
    }
}
