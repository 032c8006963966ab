//! Small vibrations about a state: the symmetric stiffness with active constraints, shifted by masses.
//!
//! ```text
//! [ K - sigma M   G^T ] [ x  ]   [ M b ]        K: the tangent at rest with the geometric part and that of the multipliers
//! [ G             -C  ] [ mu ] = [ 0   ]        G: gradients of ties and of active constraints; C: 1/kappa of penalties, else 0
//! ```

use std::time::Instant;

use super::constraint_rows::ConstraintRows;
use super::equations::Equations;
use super::explicit::at_rest;
use super::failure::Failure;
use super::iterate::Linearization;
use super::making::loads_of;
use super::start::{StepKind, StepStart};
use super::system::System;
use crate::bodies::{Elements, Space};
use crate::contact::Evaluation;
use crate::dynamics::model::definitions::Model;
use crate::dynamics::model::part::Pose;
use crate::dynamics::parts::contact_pair::ContactPair;
use crate::dynamics::parts::force_shares::ForceShares;
use crate::dynamics::parts::laws::{Equation, RowState};
use crate::linear::Operator;
use crate::math::tolerances;

/// Sign that makes the constraint columns symmetric to the rows.
const OPPOSED: ForceShares = ForceShares { lagging: -1.0, alone: -1.0 };

/// A state about which a model vibrates.
#[derive(Clone, Copy)]
pub struct VibrationState<'a> {
    /// Time of the state `[time]`.
    pub time: f64,
    /// Positions and displacements.
    pub at: Pose<'a>,
    /// History variables of the parts.
    pub memory: &'a [Vec<f64>],
    /// Multipliers.
    pub lambda: &'a [f64],
    /// Contact state of every constraint.
    pub active: &'a [RowState],
}

/// The shifted matrix of a state in the solver.
pub struct Vibrations<'a, const D: usize> {
    system: &'a mut System<D>,
    rest: VibrationState<'a>,
    /// Values of the factorized matrix.
    values: Vec<f64>,
    /// Number of active constraints.
    pub held: usize,
    /// Largest difference between an entry of the stiffness and its transpose, relative to the largest entry.
    asymmetry: f64,
    /// Largest stiffness over mass of an unknown `[1/time^2]`.
    pub stiffest: f64,
    /// Factorizations so far.
    pub factorizations: usize,
}

impl<'a, const D: usize> Vibrations<'a, D>
where
    Space<D>: Elements<D>,
{
    /// Vibrations about the state `rest`, at which the contacts of `system` have begun a step at rest.
    pub fn new(system: &'a mut System<D>, rest: VibrationState<'a>) -> Self {
        Vibrations { system, rest, values: Vec::new(), held: 0, asymmetry: 0.0, stiffest: 0.0, factorizations: 0 }
    }

    /// Number of displacement components of all nodes.
    pub fn unknowns(&self) -> usize {
        self.rest.at.q.len()
    }

    /// Number of motions admitted by supports and constraints.
    pub fn motions(&self) -> usize {
        self.system.supports.fixed.iter().filter(|fixed| !**fixed).count().saturating_sub(self.held)
    }

    /// Factors the matrix with a shift `[1/time^2]`.
    ///
    /// # Errors
    /// The stiffness cannot be computed, or does not fit into memory.
    pub fn factorize(&mut self, shift: f64) -> Result<(), Failure> {
        let (at, lambda) = (self.rest.at, self.rest.lambda);
        let at = self.stiffness_at(at, lambda, shift)?;
        let rows = self.rows(&at);
        self.constrain(&at, &rows, shift);
        self.system.recycle(at);
        self.factorize_values()
    }

    /// Computes the symmetric shifted stiffness at a pose with the multipliers `lambda`, without constraints.
    fn stiffness_at(&mut self, pose: Pose, lambda: &[f64], shift: f64) -> Result<Linearization, Failure> {
        let (Pose { q, u }, VibrationState { time, memory, .. }) = (pose, self.rest);
        let damping = vec![-shift; self.system.bodies.len()];
        let start = StepStart { time, q_0: q, u_0: u, memory, kind: StepKind::Rest { damping: &damping, velocities: None } };
        let mut at = self.system.linearize(&start, q, &vec![0.0; q.len()], lambda)?;
        self.system.complete_tangent(&start, &mut at)?;
        self.values.clone_from(&at.tangent);
        self.values.iter_mut().for_each(|value| *value /= start.weight());
        self.asymmetry = self.symmetrize();
        Ok(at)
    }

    /// Writes the constraints with their gradients at an iterate to the matrix values.
    fn constrain(&mut self, at: &Linearization, rows: &ConstraintRows, shift: f64) {
        self.held = rows.0.iter().filter(|row| row.acts).count();
        self.system.write_constraints(
            &self.system.matrix.pattern,
            [&at.pairs, &at.slips],
            rows,
            OPPOSED,
            |pair| &pair.gradient_end,
            &mut self.values,
        );
        self.stiffest = self.stiffness_over_mass(shift);
        if shift == 0.0 {
            self.system.stiffen_constraints(&at.pairs, &mut self.values);
        }
        self.system.matrix.finish(rows, self.system.nodes.modulus, &mut self.values);
    }

    fn factorize_values(&mut self) -> Result<(), Failure> {
        let clock = Instant::now();
        self.factorizations += 1;
        self.system.counters.factorizations += 1;
        self.system.matrix.solver.factorize_directly(&self.values).map_err(Failure::Linear)?;
        self.system.counters.times.factorization += clock.elapsed();
        Ok(())
    }

    /// Factorizes the stiffness of the unloaded model with the state's constraints; returns that stiffness and its change by the state,
    /// both without constraints.
    ///
    /// # Errors
    /// A stiffness cannot be computed, or does not fit into memory.
    pub fn factorize_unloaded(&mut self) -> Result<[Vec<f64>; 2], Failure> {
        let (loaded, none) = (self.rest.at, vec![0.0; self.rest.lambda.len()]);
        let at = self.stiffness_at(loaded, self.rest.lambda, 0.0)?;
        let mut change = self.values.clone();
        let (q, u) = (self.system.nodes.reference.clone(), vec![0.0; loaded.u.len()]);
        let unloaded = self.stiffness_at(Pose { q: &q, u: &u }, &none, 0.0)?;
        change.iter_mut().zip(&self.values).for_each(|(change, value)| *change -= value);
        let stiffness = self.values.clone();
        self.system.recycle(unloaded);
        let rows = self.rows(&at);
        self.constrain(&at, &rows, 0.0);
        self.system.recycle(at);
        self.factorize_values()?;
        Ok([stiffness, change])
    }

    /// Number of buckling load factors below `factor`, by the inertia of the stiffness at that multiple of the load, which remains
    /// factorized. Returns `None` if the inertia is not available.
    ///
    /// # Errors
    /// A stiffness cannot be computed, or does not fit into memory.
    pub fn load_factors_below(&mut self, stiffness: &[f64], change: &[f64], factor: f64) -> Result<Option<usize>, Failure> {
        let at = self.stiffness_at(self.rest.at, self.rest.lambda, 0.0)?;
        self.values.iter_mut().zip(stiffness.iter().zip(change)).for_each(|(value, (k, d))| *value = k + factor * d);
        let rows = self.rows(&at);
        self.constrain(&at, &rows, 0.0);
        self.system.recycle(at);
        self.factorize_values()?;
        Ok(self.below())
    }

    /// Relative asymmetry of the stiffness matrix; 0 below round-off.
    pub fn told_asymmetry(&self) -> f64 {
        if self.asymmetry > tolerances::ASYMMETRY { self.asymmetry } else { 0.0 }
    }

    /// Product of a matrix with the pattern and a nodal vector, restricted to nodal rows.
    pub fn times(&self, values: &[f64], v: &[f64]) -> Vec<f64> {
        let mut x = v.to_vec();
        x.resize(v.len() + self.system.multipliers, 0.0);
        let mut y = vec![0.0; x.len()];
        self.system.matrix.pattern.multiply_into(values, &x, &mut y);
        y.truncate(v.len());
        y
    }

    /// Number of eigenvalues below the shift; `None` if the inertia is not available.
    pub fn below(&self) -> Option<usize> {
        // Each active constraint adds one negative eigenvalue.
        self.system.matrix.solver.negative_eigenvalues()?.checked_sub(self.held)
    }

    /// Makes the blocks between nodes symmetric; returns the relative asymmetry before.
    fn symmetrize(&mut self) -> f64 {
        let (pattern, nodes) = (&self.system.matrix.pattern, self.system.nodes.count() as u32);
        // Entries of constraints may still be those of the last step.
        let (mut off, mut largest) = (0.0f64, f64::MIN_POSITIVE);
        for v in 0..nodes {
            for &u in pattern.neighbors(v as usize).iter().filter(|&&u| u >= v && u < nodes) {
                let (block, mirrored) = (pattern.block(u, v), pattern.block(v, u));
                for i in 0..D {
                    for k in 0..D {
                        let (a, b) = (block.at(i, k), mirrored.at(k, i));
                        off = off.max((self.values[a] - self.values[b]).abs());
                        largest = largest.max(self.values[a].abs()).max(self.values[b].abs());
                        let mean = 0.5 * (self.values[a] + self.values[b]);
                        (self.values[a], self.values[b]) = (mean, mean);
                    }
                }
            }
        }
        off / largest
    }

    /// Equations of the constraints: ties and active constraints hold, unless they depend on others; penalties are compliant.
    fn rows(&self, at: &Linearization) -> ConstraintRows {
        let (system, active) = (&*self.system, self.rest.active);
        let mut rows = ConstraintRows::open(system.multipliers);
        for (pair, evaluation) in system.pairs.iter().zip(&at.pairs) {
            for row in pair.rows.clone().filter(|&row| !system.redundant[row]) {
                let local = row - pair.rows.start;
                if pair.has_multipliers() {
                    let holds = pair.law.is_bilateral() || active[row].is_closed();
                    if holds && evaluation.coverage[local] > tolerances::SLIVER {
                        rows.0[row] = Equation::held(0.0, 0.0);
                    }
                } else if pair.reaction.is_none() {
                    let Equation { acts, diagonal, .. } = pair.law.equation(&at_rest(pair, row, evaluation.gap[local]));
                    if acts {
                        rows.0[row] = Equation::held(-diagonal, 0.0);
                    }
                }
            }
        }
        for (row, _) in system.pairs.iter().flat_map(ContactPair::tangential) {
            if active[row].is_closed() && !at.held[row - system.normal_count] {
                rows.0[row] = Equation::held(0.0, 0.0);
            }
        }
        system.open_dependent_rows([&at.pairs, &at.slips], &mut rows);
        rows
    }

    /// The largest quotient of the diagonals of stiffness and mass.
    fn stiffness_over_mass(&self, shift: f64) -> f64 {
        let (system, mut largest) = (&*self.system, 0.0f64);
        for (node, _, mass) in system.nodes.mass.entries().filter(|(row, column, _)| row == column) {
            let block = system.matrix.pattern.block(node, node);
            let diagonal = |i: usize| (self.values[block.at(i, i)] / mass + shift).abs();
            largest = (0..D).filter(|i| !system.supports.fixed[node as usize * D + i]).map(diagonal).fold(largest, f64::max);
        }
        largest
    }
}

impl<const D: usize> System<D> {
    /// Adds `gamma G^T G` of the constraints of rigid bodies and joints to a stiffness, with its largest diagonal as `gamma`. Motions that
    /// satisfy the constraints are unaffected, hence solutions and inertia, and masters without stiffness get pivots. Returns the
    /// corresponding right-hand side `gamma G^T g` with the gaps `g`.
    pub fn stiffen_constraints(&self, pairs: &[Evaluation], values: &mut [f64]) -> Vec<f64> {
        let mut pull = vec![0.0; self.nodes.reference.len()];
        let held = |pair: &ContactPair| pair.kind.is_of_points() && pair.law.is_bilateral() && pair.drive.is_none();
        if !self.has_rigid_bodies() {
            return pull;
        }
        let pattern = &self.matrix.pattern;
        let nodes = (0..self.nodes.count() as u32).map(|node| pattern.block(node, node));
        let largest = nodes.flat_map(|block| (0..D).map(move |i| block.at(i, i))).map(|place| values[place].abs()).fold(0.0, f64::max);
        let gamma = if largest > 0.0 { largest } else { self.nodes.stiffness() };
        for (pair, evaluation) in self.pairs.iter().zip(pairs).filter(|(pair, _)| held(pair)) {
            for row in pair.live_rows(evaluation).filter(|row| !self.redundant[row.row]) {
                let gap = evaluation.gap[row.row - pair.rows.start];
                row.unknowns::<D>().for_each(|(unknown, entry)| pull[unknown] += gamma * gap * evaluation.gradient_end[entry]);
                let gradients = || row.nodes.iter().zip(evaluation.gradient_end[row.gradient.clone()].chunks_exact(D));
                for ((&a, of_a), (&b, of_b)) in gradients().flat_map(|one| gradients().map(move |other| (one, other))) {
                    let block = pattern.block(a, b);
                    (0..D).for_each(|i| (0..D).for_each(|k| values[block.at(i, k)] += gamma * of_a[i] * of_b[k]));
                }
            }
        }
        pull
    }
}

impl<const D: usize> Equations<D> {
    /// Forces of the loads of a model with the same bodies, at time 0 `[force]`; loads with a failing time function are omitted. Forces on
    /// followers of rigid bodies act on the masters.
    pub fn forces_of_loads(&self, model: &Model, q: &[f64]) -> Vec<f64> {
        let mut force = vec![0.0; q.len()];
        for load in loads_of(model, &self.bodies) {
            load.force_into(load.amplitude(0.0).unwrap_or_default(), q, &mut force);
        }
        self.bodies.iter().filter_map(|body| body.rigid.as_ref()).for_each(|rigid| rigid.hand_over::<D>(&mut force));
        force
    }
}

impl<const D: usize> Operator for Vibrations<'_, D>
where
    Space<D>: Elements<D>,
{
    type Error = Failure;

    fn solve(&mut self, mut image: Vec<f64>) -> Result<Vec<f64>, Failure> {
        let unknowns = image.len();
        let clock = Instant::now();
        image.iter_mut().zip(&self.system.supports.fixed).filter(|(_, fixed)| **fixed).for_each(|(x, _)| *x = 0.0);
        image.resize(unknowns + self.system.multipliers, 0.0);
        let outcome = self.system.matrix.solver.solve(&self.values, &mut image);
        self.system.counters.times.solve += clock.elapsed();
        outcome.map_err(Failure::Linear)?;
        image.truncate(unknowns);
        Ok(image)
    }

    fn mass_times(&self, v: &[f64]) -> Vec<f64> {
        self.system.nodes.momenta_of(v)
    }
}
