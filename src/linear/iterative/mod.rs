//! Iterative solver: GMRES with smoothed aggregation as preconditioner, refined on the true residual.
//!
//! A solution is refined to the backward error of the direct solver ([`tolerances::LINEAR_REFINED`]), so that Newton's method and the
//! energy balance do not depend on the choice of the solver. Memory and time grow in proportion to the number of unknowns. The hierarchy is
//! made anew for every matrix and depends on the matrix and the positions of the nodes only.

mod aggregation;
mod blocks;
mod border;
mod coarsest;
mod hierarchy;
mod krylov;
mod refusal;
mod saddle;
mod smoother;
#[cfg(test)]
mod tests;

use border::Scaled;
use krylov::{Krylov, RESTART, System};
pub(super) use refusal::Refusal;
use saddle::Saddle;

use super::error::LinearError;
use super::pattern::Pattern;
use super::scaling::{all_finite, largest, spread, vertex_scales};
use super::watch::InterruptWatch;
use crate::math::tolerances;
use crate::math::workers::Workers;

/// Largest number of iterations of one solve.
const MOST_ITERATIONS: usize = 600;

/// Ratio of residuals after and before a restart cycle above which the iteration is abandoned.
const SLOW: f64 = 0.5;

/// Preconditioners for two and three unknowns per node.
enum Preconditioner {
    Plane(Box<Saddle<2, 3>>),
    Space(Box<Saddle<3, 6>>),
}

/// The iterative solver.
#[derive(Default)]
pub(super) struct Iterative {
    preconditioner: Option<Preconditioner>,
    krylov: Krylov,
    /// Scales of the vertices.
    vertex_scale: Vec<f64>,
    /// Scales of the unknowns.
    scale: Vec<f64>,
    /// Iterations of all solves.
    pub iterations: usize,
}

impl Iterative {
    /// Makes the preconditioner of a matrix.
    pub fn prepare(
        &mut self,
        pattern: &Pattern,
        positions: &[f64],
        values: &[f64],
        workers: &Workers,
        watch: &InterruptWatch,
    ) -> Result<(), Refusal> {
        self.preconditioner = None;
        if !all_finite(values) {
            return Err(Refusal::Error(LinearError::NotFinite));
        }
        self.vertex_scale.resize(pattern.vertices(), 1.0);
        self.scale.resize(pattern.unknowns(), 1.0);
        vertex_scales(pattern, values, &mut self.vertex_scale);
        spread(pattern, &self.vertex_scale, &mut self.scale);
        let matrix = Scaled { pattern, values, scales: &self.vertex_scale, positions };
        self.preconditioner = Some(match (0..pattern.vertices()).find(|&v| !pattern.is_multiplier(v)).map(|v| pattern.size(v)) {
            Some(2) => Preconditioner::Plane(Box::new(Saddle::new(&matrix, workers, watch)?)),
            Some(3) => Preconditioner::Space(Box::new(Saddle::new(&matrix, workers, watch)?)),
            _ => return Err(Refusal::Unsuited),
        });
        Ok(())
    }

    /// Solves with the matrix of the last preconditioner; `right` becomes the solution. Returns the backward error, defined as by the
    /// direct solver.
    pub fn solve(
        &mut self,
        pattern: &Pattern,
        values: &[f64],
        right: &mut [f64],
        workers: &Workers,
        watch: &InterruptWatch,
    ) -> Result<f64, Refusal> {
        let Iterative { preconditioner: Some(preconditioner), krylov, scale, iterations, .. } = self else {
            return Err(Refusal::Unsuited);
        };
        let b: Vec<f64> = right.iter().zip(&*scale).map(|(b, scale)| b * scale).collect();
        let size = largest(b.iter().copied());
        if size == 0.0 {
            return Ok(0.0);
        }
        if !size.is_finite() {
            return Err(Refusal::Error(LinearError::NotFinite));
        }
        let mut system = ScaledSystem { pattern, values, scale, preconditioner, scratch: vec![0.0; b.len()], workers, watch };
        let (mut x, mut r) = (vec![0.0; b.len()], b.clone());
        // Size of the solution for the backward error, estimated by one preconditioner step.
        system.precondition(&b, &mut x);
        let mut solution = largest(x.iter().copied());
        x.fill(0.0);
        let (mut done, mut last) = (0, size);
        loop {
            let goal = 0.5 * tolerances::LINEAR_REFINED * (solution + size);
            let count = workers.together(|| krylov.cycle(&mut system, &mut r, &mut x, goal, MOST_ITERATIONS - done, workers));
            done += count;
            *iterations += count;
            if system.is_interrupted() {
                return Err(Refusal::Error(LinearError::Interrupted));
            }
            system.multiply(&x, &mut r);
            r.iter_mut().zip(&b).for_each(|(r, b)| *r = b - *r);
            solution = largest(x.iter().copied());
            let residual = largest(r.iter().copied());
            let error = residual / (solution + size);
            if error <= tolerances::LINEAR_REFINED && residual <= tolerances::LINEAR_UNSOLVED * size {
                right.iter_mut().zip(x.iter().zip(system.scale)).for_each(|(right, (x, scale))| *right = x * scale);
                return Ok(error);
            }
            let is_slow = count == RESTART && residual > SLOW * last || count == 0;
            if is_slow || residual.is_nan() || done >= MOST_ITERATIONS {
                return Err(Refusal::NotConverged);
            }
            last = residual;
        }
    }

    /// Bytes of the hierarchy and of the vectors of an iteration.
    pub fn bytes(&self) -> usize {
        let levels = match &self.preconditioner {
            Some(Preconditioner::Plane(saddle)) => saddle.bytes(),
            Some(Preconditioner::Space(saddle)) => saddle.bytes(),
            None => 0,
        };
        levels + self.krylov.bytes()
    }

    /// Frees the hierarchy and the vectors.
    pub fn clear(&mut self) {
        self.preconditioner = None;
        self.krylov.clear();
    }
}

/// The scaled matrix with its preconditioner.
struct ScaledSystem<'a> {
    pattern: &'a Pattern,
    values: &'a [f64],
    scale: &'a [f64],
    preconditioner: &'a mut Preconditioner,
    scratch: Vec<f64>,
    workers: &'a Workers,
    watch: &'a InterruptWatch,
}

impl System for ScaledSystem<'_> {
    fn multiply(&mut self, x: &[f64], y: &mut [f64]) {
        self.scratch.iter_mut().zip(x.iter().zip(self.scale)).for_each(|(scaled, (x, scale))| *scaled = x * scale);
        self.pattern.multiply_into(self.values, &self.scratch, y);
        y.iter_mut().zip(self.scale).for_each(|(y, scale)| *y *= scale);
    }

    fn precondition(&mut self, x: &[f64], y: &mut [f64]) {
        match self.preconditioner {
            Preconditioner::Plane(saddle) => saddle.apply(x, y, self.workers),
            Preconditioner::Space(saddle) => saddle.apply(x, y, self.workers),
        }
    }

    fn is_interrupted(&self) -> bool {
        self.watch.is_interrupted()
    }
}
