//! Minimization of a function of a few variables between bounds, without derivatives.
//!
//! BOBYQA: quadratic models through the values at `2n + 1` points in a shrinking trust region (M. J. D. Powell, *The BOBYQA algorithm for
//! bound constrained optimization without derivatives*, Cambridge NA report 2009/NA06), by the crate `bobyqa`, a port of the reference
//! implementation PRIMA. Variables are scaled to 0 to 1 between their bounds. The method is local and deterministic.

use bobyqa::{Bobyqa, Config, Status};

/// A minimization problem with bounds.
#[derive(Clone, Debug, PartialEq)]
pub struct Search {
    /// Start point of the search.
    pub start: Vec<f64>,
    /// Lower bound of each variable.
    pub lower: Vec<f64>,
    /// Upper bound of each variable.
    pub upper: Vec<f64>,
    /// Initial distance between sample points, relative to each variable's range; at most one half.
    pub step: f64,
    /// Final distance between sample points, relative to each variable's range.
    pub tolerance: f64,
    /// Largest number of evaluations; more than `2n + 1`.
    pub most: usize,
    /// Value at which the search ends.
    pub target: Option<f64>,
}

/// Reason for which a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The distance of the points has reached the tolerance.
    Converged,
    /// A value has reached the target.
    Target,
    /// The largest number of evaluations was reached.
    Evaluations,
    /// Round-off hides the direction of descent.
    RoundOff,
    /// The function requested a stop.
    Stopped,
}

/// Number `2n + 1` of initial sample points of a search in `n` variables.
pub fn beginnings(variables: usize) -> usize {
    2 * variables + 1
}

impl Search {
    /// Initial sample points; they do not depend on function values, so that they can be evaluated in parallel.
    pub fn first_points(&self) -> Vec<Vec<f64>> {
        let count = beginnings(self.start.len());
        let mut points = Vec::new();
        self.run(count + 1, None, |point| {
            points.push(point.to_vec());
            Some(0.0)
        });
        points.truncate(count);
        points
    }

    /// Minimizes `value`; returns the reason for which the search ended, or `None` for an invalid problem. `value` is evaluated point by
    /// point, and ends the search by returning `None`.
    pub fn minimize(&self, value: impl FnMut(&[f64]) -> Option<f64>) -> Option<End> {
        self.run(self.most, self.target, value)
    }

    /// A point of the unit box between the bounds.
    fn point(&self, unit: &[f64]) -> Vec<f64> {
        let between = |(k, share): (usize, &f64)| {
            let (low, high) = (self.lower[k], self.upper[k]);
            // This form gives the bounds exactly for shares of 0 and 1.
            (low * (1.0 - share) + high * share).clamp(low, high)
        };
        unit.iter().enumerate().map(between).collect()
    }

    fn run(&self, most: usize, target: Option<f64>, mut value: impl FnMut(&[f64]) -> Option<f64>) -> Option<End> {
        let n = self.start.len();
        let mut config = Config::new(n);
        (config.rho_begin, config.rho_end, config.max_fun) = (self.step, self.tolerance, most);
        config.f_target = target.unwrap_or(STOP);
        // With one variable, round-off would decide PRIMA's test for replacing a sample point.
        config.prima_parity = n > 1;
        let share = |k: usize| (self.start[k] - self.lower[k]) / (self.upper[k] - self.lower[k]);
        let mut unit: Vec<f64> = (0..n).map(|k| share(k).clamp(0.0, 1.0)).collect();
        let mut is_stopped = false;
        let mut solver = Bobyqa::new(n, config).ok()?;
        let outcome = solver.minimize(
            |unit| {
                let found = if is_stopped { None } else { value(&self.point(unit)) };
                is_stopped |= found.is_none();
                found.unwrap_or(STOP)
            },
            &mut unit,
            &vec![0.0; n],
            &vec![1.0; n],
        );
        match outcome.status {
            _ if is_stopped => Some(End::Stopped),
            Status::Converged | Status::FtolReached => Some(End::Converged),
            Status::TargetReached => Some(End::Target),
            Status::MaxFunReached => Some(End::Evaluations),
            Status::ModelDegenerate => Some(End::RoundOff),
            Status::InvalidArgs | Status::AllocationFailed => None,
        }
    }
}

/// Value below all others: the search ends when the function returns it.
const STOP: f64 = f64::MIN;

#[cfg(test)]
mod tests {
    use super::*;

    fn search(start: &[f64], lower: &[f64], upper: &[f64]) -> Search {
        let (start, lower, upper) = (start.to_vec(), lower.to_vec(), upper.to_vec());
        Search { start, lower, upper, step: 0.1, tolerance: 1e-8, most: 1000, target: None }
    }

    /// The best point, its value, the end, and the number of evaluations.
    fn solve(search: &Search, f: impl Fn(&[f64]) -> f64) -> (Vec<f64>, f64, End, usize) {
        let (mut best, mut least, mut count) = (Vec::new(), f64::INFINITY, 0);
        let end = search.minimize(|x| {
            assert!((0..x.len()).all(|k| search.lower[k] <= x[k] && x[k] <= search.upper[k]), "{x:?}");
            count += 1;
            let value = f(x);
            if value < least {
                (best, least) = (x.to_vec(), value);
            }
            Some(value)
        });
        (best, least, end.unwrap(), count)
    }

    fn near(found: &[f64], expected: &[f64], tolerance: f64) -> bool {
        found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= tolerance)
    }

    fn rosenbrock(x: &[f64]) -> f64 {
        100.0 * (x[1] - x[0] * x[0]).powi(2) + (1.0 - x[0]).powi(2)
    }

    #[test]
    fn known_minima_are_found() {
        let (best, value, end, _) = solve(&search(&[-1.2, 1.0], &[-2.0, -2.0], &[2.0, 2.0]), rosenbrock);
        assert!(near(&best, &[1.0, 1.0], 1e-6) && value < 1e-12 && end == End::Converged, "{best:?} {value} {end:?}");
        // One variable; then variables of very different size.
        let (best, ..) = solve(&search(&[0.2], &[0.0], &[1.0]), |x| (x[0] - 0.7).powi(2));
        assert!(near(&best, &[0.7], 1e-7), "{best:?}");
        let f = |x: &[f64]| (x[0] / 2.1e11 - 1.0).powi(2) + (x[1] - 0.3).powi(2);
        let (best, ..) = solve(&search(&[1e11, 0.1], &[1e10, 0.0], &[1e12, 0.49]), f);
        assert!(near(&best, &[2.1e11, 0.3], 1e5), "{best:?}");
        // Minimum exactly on a bound.
        let (best, ..) = solve(&search(&[0.5, 0.5], &[0.0, 0.25], &[1.0, 1.0]), |x| (x[0] + 1.0).powi(2) + x[1]);
        assert_eq!(best, [0.0, 0.25]);
    }

    #[test]
    fn a_search_ends_where_it_is_told_to() {
        let begin = search(&[-1.2, 1.0], &[-2.0, -2.0], &[2.0, 2.0]);
        assert_eq!(solve(&Search { most: 20, ..begin.clone() }, rosenbrock).2, End::Evaluations);
        let (_, value, end, _) = solve(&Search { target: Some(0.5), ..begin.clone() }, rosenbrock);
        assert!(value <= 0.5 && end == End::Target);
        let mut count = 0;
        let end = begin.minimize(|x| {
            count += 1;
            (count < 12).then(|| rosenbrock(x))
        });
        assert_eq!((end, count), (Some(End::Stopped), 12));
        assert_eq!(Search { step: 0.7, ..begin }.minimize(|_| Some(0.0)), None);
    }

    #[test]
    fn the_first_points_do_not_depend_on_values() {
        for n in 1..5 {
            let begin = search(&vec![0.3; n], &vec![0.0; n], &vec![2.0; n]);
            let mut asked = Vec::new();
            let f = |x: &[f64]| x.iter().enumerate().map(|(k, x)| (x - 1.0 - 0.1 * k as f64).powi(4)).sum::<f64>().sin();
            begin.minimize(|x| {
                asked.push(x.to_vec());
                Some(f(x))
            });
            assert_eq!(begin.first_points(), asked[..2 * n + 1]);
            assert_eq!(begin.first_points()[0], begin.start);
        }
    }
}
