//! Fit of a law's constants to tests: least squares of the nominal stresses of incompressible test pieces.
//!
//! Rubber is nearly incompressible in tests: stresses follow from the stretches with the pressure that makes the third face free, and the
//! volumetric energy drops out (Ogden 1972). Constants in which the energy is linear (moduli) follow from the others by linear least
//! squares; the others (powers, limits) are found (variable projection: Golub and Pereyra, SIAM Journal on Numerical Analysis 10, 1973) by
//! damped Gauss-Newton steps (Levenberg 1944, Marquardt 1963) from the best of many starts, so that moduli need no initial guess. The crate
//! `levenberg-marquardt` is not used because it depends on another version of nalgebra.

use nalgebra::{DMatrix, DVector};

use super::batched::BatchedLaw;
use super::energy::{EnergyError, StoredEnergy};
use super::homogeneous::{HomogeneousTest, response};
use crate::math::tolerances::{FIT, FIT_DIFFERENCE, FIT_LINEAR, FIT_RANK};

/// Measurement of a test piece.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// Kind of test.
    pub piece: HomogeneousTest,
    /// Stretches and nominal stresses.
    pub points: Vec<[f64; 2]>,
}

/// Fitted constants, and quality of the fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Constants in the requested order.
    pub constants: Vec<f64>,
    /// Root of the mean of the squared differences of the stresses.
    pub rms: f64,
    /// Coefficient of determination: 1 minus the ratio of squared residuals to squared deviations from the mean stress.
    pub r_squared: f64,
}

/// Errors of a fit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitError {
    /// A mistake in the energy.
    #[error(transparent)]
    Energy(#[from] EnergyError),
    /// Fewer points than constants.
    #[error("{points} points cannot determine {constants} constants")]
    Points {
        /// Number of points in the tests.
        points: usize,
        /// Number of constants to be fitted.
        constants: usize,
    },
    /// No start gives finite stresses.
    #[error("the law gives no finite stresses for any start")]
    NoStart,
}

impl FitError {
    /// Returns the stable code of the error, which `conserva doc` explains.
    pub fn code(&self) -> &'static str {
        match self {
            FitError::Energy(error) => error.code(),
            FitError::Points { .. } => "C0311",
            FitError::NoStart => "C0312",
        }
    }
}

/// Start values of constants on which stresses depend nonlinearly: powers, and limits of `I1 - 3`.
const STARTS: [f64; 8] = [-2.0, 0.5, 1.5, 3.0, 5.0, 9.0, 30.0, 90.0];
/// Number of start points tried.
const TRIED: usize = 512;
/// Number of the best start points from which the search continues.
const FOLLOWED: usize = 6;
/// Largest number of Gauss-Newton steps from one start point.
const STEPS: usize = 200;

/// Nominal stress of an incompressible test piece at a stretch.
pub fn incompressible_stress(law: &dyn BatchedLaw<6>, piece: HomogeneousTest, stretch: f64) -> f64 {
    let stretches = piece.isochoric(stretch);
    let mut strain = [0.0; 6];
    (0..3).for_each(|i| strain[i] = 0.5 * (stretches[i] - 1.0) * (stretches[i] + 1.0));
    let (stress, _) = response(law, &strain);
    // Cauchy stress along an axis: l^2 S; the third face is free.
    (stretches[0].powi(2) * stress[0] - stretches[2].powi(2) * stress[2]) / stretch
}

impl StoredEnergy {
    /// Nominal stresses of an incompressible test piece at some stretches.
    ///
    /// # Errors
    /// A mistake in the energy.
    pub fn incompressible_stresses(&self, piece: HomogeneousTest, stretches: &[f64]) -> Result<Vec<f64>, EnergyError> {
        let law = self.in_space()?;
        Ok(stretches.iter().map(|stretch| incompressible_stress(&law, piece, *stretch)).collect())
    }
}

/// Fits constants of an energy. `energy` returns the energy for values of the constants; `start` are initial values, where known.
///
/// # Errors
/// A mistake in the energy, too few points, no finite stresses.
pub fn fit(
    energy: impl Fn(&[f64]) -> Result<StoredEnergy, EnergyError>,
    start: &[Option<f64>],
    measured: &[Measured],
) -> Result<Fit, FitError> {
    let stresses: Vec<f64> = measured.iter().flat_map(|test| test.points.iter().map(|point| point[1])).collect();
    if stresses.len() < start.len() {
        return Err(FitError::Points { points: stresses.len(), constants: start.len() });
    }
    let problem = Problem { energy: &energy, measured, stresses: DVector::from_vec(stresses), count: start.len() };
    let linear = problem.linear(start)?;
    let searched: Vec<usize> = (0..start.len()).filter(|index| !linear.contains(index)).collect();
    let separated = Separated { problem: &problem, linear, searched };
    let mut tried: Vec<(f64, Vec<f64>)> = separated
        .starts(start)
        .into_iter()
        .map(|values| (separated.solve(&values).map_or(f64::INFINITY, |(_, rest)| rest.norm_squared()), values))
        .filter(|(size, _)| size.is_finite())
        .collect();
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    let found = tried.into_iter().take(FOLLOWED).map(|(_, values)| separated.descend(values));
    let best = found.flatten().min_by(|a, b| a.1.norm_squared().total_cmp(&b.1.norm_squared()));
    let (constants, rest) = best.ok_or(FitError::NoStart)?;
    let mean = problem.stresses.mean();
    let spread: f64 = problem.stresses.iter().map(|stress| (stress - mean).powi(2)).sum();
    let rms = (rest.norm_squared() / rest.len() as f64).sqrt();
    Ok(Fit { constants, rms, r_squared: 1.0 - rest.norm_squared() / spread })
}

type EnergyOf<'a> = &'a dyn Fn(&[f64]) -> Result<StoredEnergy, EnergyError>;

struct Problem<'a> {
    energy: EnergyOf<'a>,
    measured: &'a [Measured],
    stresses: DVector<f64>,
    count: usize,
}

impl Problem<'_> {
    /// Stresses of the law with the given constants at all measured points.
    fn law(&self, constants: &[f64]) -> Result<DVector<f64>, EnergyError> {
        let law = (self.energy)(constants)?.in_space()?;
        let stresses = self.measured.iter().flat_map(|test| test.points.iter().map(|point| (test.piece, point[0])));
        Ok(DVector::from_vec(stresses.map(|(piece, stretch)| incompressible_stress(&law, piece, stretch)).collect()))
    }

    /// Indices of the constants in which the stresses are linear, each alone and all together.
    fn linear(&self, start: &[Option<f64>]) -> Result<Vec<usize>, EnergyError> {
        let base: Vec<f64> = start.iter().enumerate().map(|(k, value)| value.unwrap_or(1.3 + 0.4 * k as f64)).collect();
        let scaled = |indices: &[usize], factor: f64| {
            let mut values = base.clone();
            indices.iter().for_each(|&index| values[index] *= factor);
            self.law(&values)
        };
        let is_linear = |indices: &[usize]| -> Result<bool, EnergyError> {
            // Not linear if one of the three stresses cannot be computed.
            let (Ok(none), Ok(once), Ok(twice)) = (scaled(indices, 0.0), scaled(indices, 1.0), scaled(indices, 2.0)) else {
                return Ok(false);
            };
            Ok((&twice - &once * 2.0 + &none).amax() <= FIT_LINEAR * once.amax().max(twice.amax()))
        };
        // An error in the text is returned; otherwise it would make every constant nonlinear.
        self.law(&base)?;
        let mut linear = Vec::new();
        for index in 0..self.count {
            if is_linear(&[index])? && is_linear(&[linear.clone(), vec![index]].concat())? {
                linear.push(index);
            }
        }
        Ok(linear)
    }
}

/// Nonlinear constants, separated from those that follow by linear least squares.
struct Separated<'a> {
    problem: &'a Problem<'a>,
    linear: Vec<usize>,
    searched: Vec<usize>,
}

impl Separated<'_> {
    /// Initial values of the nonlinear constants.
    fn starts(&self, given: &[Option<f64>]) -> Vec<Vec<f64>> {
        let mut all = vec![Vec::new()];
        for &index in &self.searched {
            let values = given[index].map_or(STARTS.to_vec(), |value| vec![value]);
            let longer = all.iter().flat_map(|begun: &Vec<f64>| values.iter().map(|value| [begun.as_slice(), &[*value]].concat()));
            all = longer.take(TRIED).collect();
        }
        all
    }

    /// All constants for values of the nonlinear ones, and the stress residuals.
    fn solve(&self, searched: &[f64]) -> Option<(Vec<f64>, DVector<f64>)> {
        let mut constants = vec![0.0; self.problem.count];
        self.searched.iter().zip(searched).for_each(|(&index, value)| constants[index] = *value);
        let fixed = self.problem.law(&constants).ok()?;
        let mut columns = Vec::new();
        for &index in &self.linear {
            constants[index] = 1.0;
            columns.push(self.problem.law(&constants).ok()? - &fixed);
            constants[index] = 0.0;
        }
        let wanted = &self.problem.stresses - &fixed;
        if columns.is_empty() {
            return wanted.iter().all(|x| x.is_finite()).then_some((constants, wanted));
        }
        let matrix = DMatrix::from_columns(&columns);
        if !matrix.iter().chain(wanted.iter()).all(|x| x.is_finite()) {
            return None;
        }
        let factors = matrix.clone().svd(true, true);
        let values = factors.solve(&wanted, FIT_RANK * factors.singular_values.max()).ok()?;
        self.linear.iter().zip(values.iter()).for_each(|(&index, value)| constants[index] = *value);
        Some((constants, wanted - matrix * values))
    }

    /// Damped Gauss-Newton steps from a start point to a local minimum of the squared residuals.
    fn descend(&self, mut at: Vec<f64>) -> Option<(Vec<f64>, DVector<f64>)> {
        let (mut constants, mut rest) = self.solve(&at)?;
        let mut damping = FIT_DIFFERENCE;
        for _ in 0..STEPS {
            if at.is_empty() {
                break;
            }
            let mut columns = Vec::new();
            for k in 0..at.len() {
                let h = FIT_DIFFERENCE * at[k].abs().max(1.0);
                let shifted = |by: f64| {
                    let mut values = at.clone();
                    values[k] += by;
                    self.solve(&values).map(|(_, rest)| rest)
                };
                columns.push((shifted(h)? - shifted(-h)?) / (2.0 * h));
            }
            let slopes = DMatrix::from_columns(&columns);
            let (gradient, normal) = (slopes.transpose() * &rest, slopes.transpose() * &slopes);
            let mut better = None;
            while better.is_none() && damping < 1.0 / FIT_DIFFERENCE {
                let mut damped = normal.clone();
                (0..at.len()).for_each(|k| damped[(k, k)] += damping * (normal[(k, k)] + FIT_RANK * normal.amax()));
                let step = damped.lu().solve(&gradient)?;
                let values: Vec<f64> = at.iter().zip(step.iter()).map(|(value, step)| value - step).collect();
                better = self.solve(&values).filter(|(_, next)| next.norm_squared() < rest.norm_squared()).map(|found| (values, found));
                damping = if better.is_some() { damping * 0.2 } else { damping * 4.0 };
            }
            let Some((values, (next_constants, next))) = better else { break };
            let gained = 1.0 - next.norm_squared() / rest.norm_squared();
            (at, constants, rest) = (values, next_constants, next);
            if gained < FIT {
                break;
            }
        }
        Some((constants, rest))
    }
}
