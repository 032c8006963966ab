//! Equilibrium path under a load, controlled by load or by arc length.
//!
//! The load parameter is the time in all time functions of forces, pressures and prescribed motions. A point is predicted along the tangent
//! and corrected by Newton's method in displacements and load, on a sphere around the previous point (Crisfield, Computers & Structures 13,
//! 1981: arc length of displacements only). A failed step is shortened; after fast convergence the next step is longer. The number of
//! unstable directions is the inertia of the symmetric stiffness.

use std::sync::Arc;

use super::engine::Engine;
use super::ledger::LedgerRow;
use super::paths::{CriticalKind, CriticalPoint, Path, PathEnd, PathError, PathOptions, PathPoint};
use super::settle_progress::SettleEffort;
use super::steps::Steps;
use crate::bodies::{Elements, Space};
use crate::contact::{MotionBound, PredictedMotion};
use crate::dynamics::model::step_error::StepError;
use crate::dynamics::parts::laws::RowState;
use crate::dynamics::step::contact_set::constraint_rows;
use crate::dynamics::step::failure::Failure;
use crate::dynamics::step::start::{StepKind, StepStart};
use crate::dynamics::step::vibrations::{VibrationState, Vibrations};
use crate::linear::product;
use crate::math::tolerances;

/// Largest number of corrections of a point.
const CORRECTIONS: usize = 12;
/// Number of corrections for which the step size is kept.
const WANTED: f64 = 4.0;

/// Factor of the path step after a failed step.
const SHORTER: f64 = 0.5;
/// Largest growth of the path step from one step to the next.
const LONGER: f64 = 1.5;
/// Largest path step relative to the first one.
const LONGEST: f64 = 4.0;

/// Largest number of successive reductions of a step.
const MOST_SHORTER: i32 = 12;

/// Number of bisections of the path segment in which stability changes: to a thousandth of an increment.
const BISECTIONS: usize = 10;

/// Iterate of a point on the path.
#[derive(Clone)]
struct Guess {
    load: f64,
    u: Vec<f64>,
    lambda: Vec<f64>,
}

/// Derivatives of the forces on the right-hand side and of prescribed motions with respect to the load parameter, for all unknowns.
struct Rates {
    force: Vec<f64>,
    motion: Vec<f64>,
    /// Derivatives of the gaps of all constraints at fixed nodes; nonzero for driven joints.
    gap: Vec<f64>,
}

/// Solutions of Newton's system at a point for the residual and for a unit load.
struct Response {
    /// Largest residual relative to the largest force.
    residual: f64,
    correction: Vec<f64>,
    lambda: Vec<f64>,
    per_load: Vec<f64>,
    lambda_per_load: Vec<f64>,
}

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// Equilibria on the path from the present state on; the simulation is not changed.
    ///
    /// # Errors
    /// [`PathError`].
    pub fn find_path(&mut self, options: &PathOptions, told: &mut dyn FnMut(&LedgerRow)) -> Result<Path, PathError> {
        if let Some(pair) = self.system.pairs.iter().find(|pair| !pair.law.is_bilateral()) {
            return Err(PathError::Contact { contact: pair.name.clone() });
        }
        let (begun, tally) = (self.state.clone(), self.tally());
        let outcome = self.follow(options, told);
        self.system.given.clear();
        self.take_back(&begun);
        self.count_from(&tally);
        outcome.map_err(PathError::Step)
    }

    fn follow(&mut self, options: &PathOptions, told: &mut dyn FnMut(&LedgerRow)) -> Result<Path, StepError> {
        let begun = self.state.row.time;
        self.settle_once(begun, SettleEffort::Exact)?;
        let mut points = vec![self.point(0.0)];
        let (mut before, mut first, mut arc): (Option<Vec<f64>>, Option<f64>, f64) = (None, None, 0.0);
        let end = loop {
            if self.state.row.time == options.until {
                break PathEnd::Reached;
            }
            if self.options.interrupted() {
                return Err(StepError::Interrupted { time: begun });
            }
            if points.len() >= options.points {
                break PathEnd::Points;
            }
            let reached = self.state.clone();
            let from = Guess { load: reached.row.time, u: reached.displacements.clone(), lambda: reached.lambda.clone() };
            let mut failures: i32 = 0;
            let found = loop {
                let tried = self.rates(&from, options.increment).and_then(|rates| {
                    let tangent = self.respond(&from, &rates)?;
                    if first.is_none() {
                        arc = options.increment.abs() * norm(&tangent.per_load);
                        first = Some(arc);
                    }
                    let increment = options.increment.abs() * SHORTER.powi(failures);
                    self.next_point(&from, (&tangent, &rates), before.as_deref(), (arc, increment), options)
                });
                match tried {
                    Ok(found) => break Ok(found),
                    Err(failure) => {
                        self.take_back(&reached);
                        let failure = failure.or_end(from.load);
                        if let Failure::Fatal(error) = failure {
                            return Err(error);
                        }
                        failures += 1;
                        if failures > MOST_SHORTER {
                            break Err(failure.name().to_string());
                        }
                        arc *= SHORTER;
                    }
                }
            };
            let (guess, corrections) = match found {
                Ok(found) => found,
                Err(cause) => break PathEnd::Lost(cause),
            };
            let moved: Vec<f64> = guess.u.iter().zip(&from.u).map(|(now, before)| now - before).collect();
            if let Err(error) = self.adopt_point(&guess) {
                self.take_back(&reached);
                match error {
                    StepError::NotConverged { .. } => break PathEnd::Lost(error.to_string()),
                    error => return Err(error),
                }
            }
            let length = points.last().map_or(0.0, |point| point.length) + norm(&moved);
            points.push(self.point(length));
            told(&self.state.row);
            before = Some(moved);
            let change = (WANTED / corrections.max(1) as f64).sqrt().clamp(SHORTER, LONGER);
            arc = (arc * change).min(LONGEST * first.unwrap_or(arc));
        };
        let mut critical = critical_points(&points);
        critical.iter_mut().filter(|point| point.kind == CriticalKind::Bifurcation).for_each(|point| self.sharpen(&points, point));
        Ok(Path { points, critical, end })
    }

    /// Locates the load of a bifurcation: by bisection on the number of negative eigenvalues, then from the eigenvalues that change sign,
    /// if found. If several vanish at one load, their order differs at both ends, and only close ends distinguish them.
    fn sharpen(&mut self, points: &[PathPoint], critical: &mut CriticalPoint) {
        let Some(ahead) = (critical.after + 1..points.len()).find(|&k| points[k].unstable.is_some()) else { return };
        let [mut from, mut to] = [critical.after, ahead].map(|k| points[k].clone());
        for _ in 0..BISECTIONS {
            let mean = |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect() };
            let (a, b) = (&from.state, &to.state);
            let load = 0.5 * (a.row.time + b.row.time);
            let guess = Guess { load, u: mean(&a.displacements, &b.displacements), lambda: mean(&a.lambda, &b.lambda) };
            self.take_back(&from.state);
            if self.adopt_point(&guess).is_err() {
                break;
            }
            let middle = self.point(0.0);
            match middle.unstable {
                Some(_) if middle.unstable == from.unstable => from = middle,
                Some(_) => to = middle,
                // The tangent is singular: this is the critical point.
                None => {
                    critical.load = load;
                    return;
                }
            }
        }
        let index = [&from, &to].into_iter().filter_map(|point| point.unstable).min().unwrap_or(0);
        let mut eigenvalue = |point: &PathPoint| {
            self.take_back(&point.state);
            Some(self.find_modes(index + 1).ok()?.modes.get(index)?.eigenvalue)
        };
        let [first, last] = [&from, &to].map(|point| point.state.row.time);
        critical.load = 0.5 * (first + last);
        let Some((before, after)) = eigenvalue(&from).zip(eigenvalue(&to)) else { return };
        if before * after < 0.0 {
            critical.load = first + (last - first) * before / (before - after);
        }
    }

    /// The present state as a point of a path.
    fn point(&mut self, length: f64) -> PathPoint {
        let state = self.state.clone();
        let rest =
            VibrationState { time: state.row.time, at: state.pose(), memory: &state.memory, lambda: &state.lambda, active: &state.active };
        let mut vibrations = Vibrations::new(&mut self.system, rest);
        let unstable = vibrations.factorize(0.0).ok().and_then(|()| vibrations.below());
        PathPoint { state, unstable, length }
    }

    /// Adopts a point of the path as the present state, with its row of the ledger.
    fn adopt_point(&mut self, guess: &Guess) -> Result<(), StepError> {
        let (from, before) = (self.state.row.time, self.state.row.clone());
        let positions = self.system.nodes.positions(&guess.u);
        let state = Arc::make_mut(&mut self.state);
        (state.positions, state.displacements, state.lambda) = (positions, guess.u.clone(), guess.lambda.clone());
        let report = self.settle_once(guess.load, SettleEffort::Exact)?;
        let row = &mut Arc::make_mut(&mut self.state).row;
        *row = LedgerRow {
            step: row.step + 1,
            dt: guess.load - from,
            load_work: 0.0,
            contact_work: 0.0,
            friction_work: 0.0,
            energy_defect: 0.0,
            momentum_defect: 0.0,
            angular_momentum_defect: 0.0,
            newton_iterations: report.newton_iterations,
            halvings: 0,
            ..std::mem::take(row)
        };
        row.book_flow_at_rest(&before);
        Ok(())
    }

    /// Finds the next point; returns also the number of corrections. `increment` is the load step where the load moves no node.
    fn next_point(
        &mut self,
        from: &Guess,
        (tangent, rates): (&Response, &Rates),
        before: Option<&[f64]>,
        (arc, increment): (f64, f64),
        options: &PathOptions,
    ) -> Result<(Guess, usize), Failure> {
        let speed = norm(&tangent.per_load).max(f64::MIN_POSITIVE);
        // Direction along the path: that of the previous step; at first towards the end.
        let onwards = before.map_or((options.until - from.load).signum(), |before| product(before, &tangent.per_load).signum());
        let left = options.until - from.load;
        // Positions that change by round-off only (loads that are zero, or act on supports alone) define no arc length.
        let round_off = tolerances::POSITION * self.system.nodes.extent * (from.u.len() as f64).sqrt();
        let moves = arc > round_off;
        let (by_arc, step) = (options.by_arc && moves, if moves { arc / speed } else { increment });
        let step = if by_arc { onwards * step } else { left.signum() * step };
        let is_last = step * left > 0.0 && step.abs() >= left.abs();
        let step = if is_last { left } else { step };
        let mut guess = Guess {
            load: if is_last { options.until } else { from.load + step },
            u: from.u.iter().zip(&tangent.per_load).map(|(u, rate)| u + step * rate).collect(),
            lambda: from.lambda.iter().zip(&tangent.lambda_per_load).map(|(lambda, rate)| lambda + step * rate).collect(),
        };
        let mut least = f64::INFINITY;
        for corrections in 1..=CORRECTIONS {
            let response = self.respond(&guess, rates)?;
            let is_trifle = || norm(&response.correction) <= round_off.max(tolerances::PATH * norm(&guess.u));
            let is_stuck = response.residual >= 0.5 * least && (response.residual <= tolerances::PATH_STUCK || is_trifle());
            if response.residual <= tolerances::PATH || is_stuck {
                return Ok((guess, corrections));
            }
            least = least.min(response.residual);
            let change = if by_arc && !is_last { on_sphere(from, &guess, &response, arc).ok_or(Failure::Diverged)? } else { 0.0 };
            guess.load += change;
            guess.u.iter_mut().zip(&response.correction).for_each(|(u, own)| *u += own);
            guess.u.iter_mut().zip(&response.per_load).for_each(|(u, rate)| *u += change * rate);
            guess.lambda = response.lambda.iter().zip(&response.lambda_per_load).map(|(own, rate)| own + change * rate).collect();
        }
        Err(Failure::Iterations)
    }

    /// Starts a step at rest at a guess; gives its positions.
    fn begin_at(&mut self, guess: &Guess) -> Result<Vec<f64>, Failure> {
        let q = self.system.nodes.positions(&guess.u);
        Arc::make_mut(&mut self.state).row.time = guess.load;
        let still = vec![0.0; self.system.nodes.count()];
        let predicted_motion = PredictedMotion {
            q: &q,
            motion_bound: MotionBound::Each { sizes: &still, besides: 0.0, is_continued: false },
            reach: self.options.reach,
            depth: 0.0,
        };
        self.begin_at_rest(&predicted_motion, &[]).map_err(Failure::Fatal)?;
        Ok(q)
    }

    /// Derivatives with respect to the load parameter, by central differences.
    fn rates(&mut self, guess: &Guess, increment: f64) -> Result<Rates, Failure> {
        let q = self.begin_at(guess)?;
        let Guess { load, u, lambda } = guess;
        let (memory, undamped, zeros) = (self.state.memory.clone(), vec![0.0; self.system.bodies.len()], vec![0.0; u.len()]);
        let h = tolerances::LOAD_DIFFERENCE * increment.abs();
        let all = u.len() + self.system.multipliers;
        let mut rates = Rates { force: vec![0.0; all], motion: vec![0.0; all], gap: vec![0.0; self.system.multipliers] };
        for (sign, time) in [(1.0, load + h), (-1.0, load - h)] {
            let kind = StepKind::Rest { damping: &undamped, velocities: None };
            let at = self.system.linearize(&StepStart { time, q_0: &q, u_0: u, memory: &memory, kind }, &q, &zeros, lambda)?;
            let forces = rates.force.iter_mut().zip(&at.forces.without_contact);
            forces.for_each(|(rate, force)| *rate -= sign * force / (2.0 * h));
            self.system.recycle(at);
            self.system.equations.move_obstacles(time, 0.0).map_err(Failure::Fatal)?;
            let gaps = self.system.pairs.iter().flat_map(|pair| pair.kernel.gap(&q));
            rates.gap.iter_mut().zip(gaps).for_each(|(rate, gap)| *rate += sign * gap / (2.0 * h));
            let (place, _) = self.system.supports.prescribed_motion(time).map_err(Failure::Fatal)?;
            for (one, place) in self.system.supports.prescribed.iter().zip(place) {
                rates.motion[one.unknown] += sign * place / (2.0 * h);
            }
        }
        Ok(rates)
    }

    /// Solves Newton's system at a guess.
    fn respond(&mut self, guess: &Guess, rates: &Rates) -> Result<Response, Failure> {
        let q = self.begin_at(guess)?;
        let Guess { load, u, lambda } = guess;
        let unknowns = u.len();
        let (memory, undamped, zeros) = (self.state.memory.clone(), vec![0.0; self.system.bodies.len()], vec![0.0; unknowns]);
        let kind = StepKind::Rest { damping: &undamped, velocities: None };
        let start = StepStart { time: *load, q_0: &q, u_0: u, memory: &memory, kind };
        let mut at = self.system.linearize(&start, &q, &zeros, lambda)?;
        self.system.complete_tangent(&start, &mut at)?;
        let pull = self.system.stiffen_constraints(&at.pairs, &mut at.tangent);
        let mut rate = rates.force.clone();
        let mut image = vec![0.0; rate.len()];
        self.system.matrix.pattern.multiply_into(&at.tangent, &rates.motion, &mut image);
        rate.iter_mut().zip(image).for_each(|(rate, image)| *rate -= image);
        let (place, _) = self.system.supports.prescribed_motion(*load).map_err(Failure::Fatal)?;
        let mut given = vec![0.0; rate.len()];
        self.system.supports.prescribed.iter().zip(place).for_each(|(one, place)| given[one.unknown] = place - u[one.unknown]);
        self.system.given = given;
        let set: Vec<RowState> = self.system.redundant.iter().map(|redundant| RowState::closed_if(!redundant)).collect();
        let rows = constraint_rows(&self.system, &at, &self.conditions_at_rest(&start), &set, 0.0, None);
        let modulus = self.system.nodes.modulus;
        let outcome = self.system.write_system(&start, &mut at, &rows);
        self.system.given.clear();
        let mut right = outcome?;
        (0..unknowns).filter(|&k| !self.system.supports.fixed[k]).for_each(|k| right[k] -= pull[k]);
        let free = |k: &usize| !self.system.supports.fixed[*k];
        let left = |k: usize| at.forces.residual(k).abs();
        let residual = (0..unknowns).filter(free).map(left).fold(0.0, f64::max) / at.forces.scale.max(f64::MIN_POSITIVE);
        for k in (0..unknowns).filter(|&k| self.system.supports.fixed[k]) {
            rate[k] = modulus * rates.motion[k];
        }
        // Free nodes compensate the gap rates of prescribed motions and drives.
        rate[unknowns..].iter_mut().zip(&rates.gap).for_each(|(rate, gap)| *rate = -gap);
        self.system.for_each_end_gradient([&at.pairs, &at.slips], |_, row, k, gradient| rate[unknowns + row] -= gradient * rates.motion[k]);
        (0..self.system.multipliers).filter(|&row| !rows.0[row].acts).for_each(|row| rate[unknowns + row] = 0.0);
        self.system.solve_with(&at.tangent, &mut right, std::time::Instant::now())?;
        self.system.matrix.solver.solve(&at.tangent, &mut rate).map_err(Failure::Linear)?;
        self.system.recycle(at);
        let (lambda, lambda_per_load) = (right.split_off(unknowns), rate.split_off(unknowns));
        Ok(Response { residual, correction: right, lambda, per_load: rate, lambda_per_load })
    }
}

/// Load increment that moves a corrected point onto the sphere around the last point; of two solutions the one in the direction of the
/// step. `None` if no node moves with the load.
fn on_sphere(from: &Guess, guess: &Guess, response: &Response, arc: f64) -> Option<f64> {
    let step: Vec<f64> = guess.u.iter().zip(&from.u).map(|(now, before)| now - before).collect();
    let corrected: Vec<f64> = step.iter().zip(&response.correction).map(|(step, own)| step + own).collect();
    let rate = &response.per_load;
    let (a, b, c) = (product(rate, rate), 2.0 * product(rate, &corrected), product(&corrected, &corrected) - arc * arc);
    if a == 0.0 {
        return None;
    }
    // Without an intersection with the sphere: the point nearest to it.
    let root = (b * b - 4.0 * a * c).max(0.0);
    let ahead = |change: &f64| product(&step, &corrected) + change * product(&step, rate);
    let roots = [(-b + root.sqrt()) / (2.0 * a), (-b - root.sqrt()) / (2.0 * a)];
    roots.into_iter().max_by(|x, y| ahead(x).total_cmp(&ahead(y)))
}

fn norm(x: &[f64]) -> f64 {
    product(x, x).sqrt()
}

/// Critical points: extrema of the load, and other changes of stability.
fn critical_points(points: &[PathPoint]) -> Vec<CriticalPoint> {
    let load = |k: usize| points[k].state.row.time;
    let turns: Vec<usize> =
        (1..points.len().saturating_sub(1)).filter(|&k| (load(k) - load(k - 1)) * (load(k + 1) - load(k)) < 0.0).collect();
    let mut found: Vec<CriticalPoint> = turns
        .iter()
        .map(|&k| {
            // Parabola through three points, relative to the middle one.
            let (back, ahead) = (points[k - 1].length - points[k].length, points[k + 1].length - points[k].length);
            let (low, high) = ((load(k - 1) - load(k)) / back, (load(k + 1) - load(k)) / ahead);
            let curvature = (high - low) / (ahead - back);
            let slope = low - curvature * back;
            let at = if curvature == 0.0 { load(k) } else { load(k) - 0.25 * slope * slope / curvature };
            let after = if -0.5 * slope / curvature < 0.0 { k - 1 } else { k };
            CriticalPoint { kind: CriticalKind::Limit, load: at, after }
        })
        .collect();
    // A point at a critical load has a singular tangent and no count of unstable directions.
    let counted: Vec<(usize, usize)> = points.iter().enumerate().filter_map(|(k, point)| Some((k, point.unstable?))).collect();
    for pair in counted.windows(2) {
        let [(k, now), (next, then)] = [pair[0], pair[1]];
        if now != then && !turns.iter().any(|turn| (k..=next).contains(turn)) {
            found.push(CriticalPoint { kind: CriticalKind::Bifurcation, load: 0.5 * (load(k) + load(next)), after: k });
        }
    }
    if let Some(&(k, _)) = counted.last().filter(|(k, _)| k + 1 < points.len()) {
        found.push(CriticalPoint { kind: CriticalKind::Bifurcation, load: load(k + 1), after: k });
    }
    found.sort_by_key(|point| point.after);
    found
}
