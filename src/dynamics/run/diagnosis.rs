//! Diagnosis of a failed step from the Newton iterations, the loads and the factors of the tangent.
//!
//! A cause is named only if numbers show it; otherwise the failure is called slow convergence. The diagnosis changes no step.

use super::report::{CyclingNode, FailureCause, FailureReport, IterationReport, TryReport};
use super::state::State;
use crate::bodies::{Elements, Inverted, Space};
use crate::dynamics::model::definitions::Model;
use crate::dynamics::parts::contact_pair::ContactPair;
use crate::dynamics::parts::nodal::{moment, resultant};
use crate::dynamics::step::convergence::Iteration;
use crate::dynamics::step::failure::Failure;
use crate::dynamics::step::system::System;
use crate::dynamics::step::task::Trace;
use crate::linear::LinearError;
use crate::math::tolerances::{EXPLAINED, RIGID};

/// Number of last iterations; a node that changed in at least half of them is called cycling.
const CYCLE: usize = 6;
/// Displacement by a load in one step, in cells, from which the load is named as the cause.
const FAST_LOAD: f64 = 0.5;
/// Growth of the residual above its minimum that counts as divergence.
const GROWTH: f64 = 1e3;
/// Data of a failed step from which its cause is determined.
pub struct Evidence<'a, const D: usize> {
    pub model: &'a Model,
    pub system: &'a System<D>,
    pub state: &'a State,
    /// Newton iterations of the last attempt.
    pub trace: &'a Trace,
    /// All attempts at the step, including the last one.
    pub tries: &'a [TryReport],
    /// Time step size of the last attempt; 0 in `settle`.
    pub dt: f64,
    pub halvings: usize,
}

impl<const D: usize> Evidence<'_, D>
where
    Space<D>: Elements<D>,
{
    /// Report on a failure, with its cause.
    pub fn report(&self, failure: &Failure) -> FailureReport {
        let cause = match failure {
            Failure::Iterations | Failure::Inexact { .. } => self.not_converged(),
            Failure::Inverted { body, inverted } => self.blamed_on_a_load(self.inverted_cell(body, inverted)),
            Failure::Diverged => self.blamed_on_a_load(FailureCause::Divergence),
            Failure::Linear(error) => FailureCause::SingularSystem { reason: self.explain(error), constraint: self.constraint_of(error) },
            Failure::Foreseen(motion) => FailureCause::TooFast { contact: motion.contact.clone() },
            Failure::BeyondSearch { pair } | Failure::Overlooked { pair } => FailureCause::TooFast { contact: pair.clone() },
            Failure::Fatal(error) => FailureCause::SingularSystem { reason: error.to_string(), constraint: None },
        };
        self.report_of(cause)
    }

    /// Report of the failure with its cause.
    pub fn report_of(&self, cause: FailureCause) -> FailureReport {
        let row = &self.state.row;
        FailureReport {
            time: row.time,
            step: row.step + 1,
            dt: self.dt,
            halvings: self.halvings,
            cause,
            iterations: self.iterations(),
            unheld: if self.dt == 0.0 { self.unheld() } else { None },
            tries: self.tries.to_vec(),
        }
    }

    fn pair_of(&self, row: usize) -> Option<&ContactPair> {
        self.system.pair_of(row)
    }

    fn iterations(&self) -> Vec<IterationReport> {
        let iterations = self.trace.iterations.iter();
        iterations
            .map(|iteration| {
                let (body, node) = self.system.owner(iteration.worst / D);
                IterationReport {
                    residual: iteration.residual,
                    target: iteration.target,
                    energy: iteration.energy,
                    gap_violation: iteration.violation,
                    changes: iteration.changed.len(),
                    active: iteration.active,
                    body: body.into(),
                    node,
                    contact: self.pair_of(iteration.worst_row).map(|pair| pair.name.clone()),
                    is_slip: iteration.worst_row >= self.system.normal_count,
                }
            })
            .collect()
    }

    /// Cause of a failure at the iteration limit.
    fn not_converged(&self) -> FailureCause {
        let residuals: Vec<f64> = self.trace.iterations.iter().map(|iteration| iteration.residual).collect();
        let last = residuals.last().copied().unwrap_or(0.0);
        let least = residuals.iter().copied().fold(f64::INFINITY, f64::min);
        if let Some(cycling) = self.cycling_contact(&self.trace.iterations) {
            return cycling;
        }
        let ratios: Vec<f64> = self.tries.iter().map(|tried| tried.residual / tried.target).collect();
        // Residuals below their targets are not the cause.
        let is_short = self.trace.iterations.last().is_some_and(|iteration| iteration.residual > iteration.target);
        let nearer = is_short && ratios.len() > 1 && ratios.windows(2).all(|pair| pair[1] < 0.5 * pair[0]);
        // The residual still decreased at the last iteration.
        let falling = is_short && residuals.len() > CYCLE && last < 0.5 * residuals[residuals.len() - CYCLE];
        if nearer || falling {
            return FailureCause::StepLimit { ratios: if nearer { ratios } else { Vec::new() } };
        }
        if let Some(cycling) = self.trace.earlier.iter().find_map(|earlier| self.cycling_contact(earlier)) {
            return cycling;
        }
        let grew = last > GROWTH * least && least > 0.0;
        self.blamed_on_a_load(if grew { FailureCause::Divergence } else { FailureCause::SlowConvergence })
    }

    /// The pair with the most nodes that kept changing their state in the last iterations.
    fn cycling_contact(&self, iterations: &[Iteration]) -> Option<FailureCause> {
        let last = &iterations[iterations.len().saturating_sub(CYCLE)..];
        let cycling = |row: usize| 2 * last.iter().filter(|iteration| iteration.changed.contains(&row)).count() >= last.len();
        let of_pair = |pair: &ContactPair| -> (Vec<CyclingNode>, bool) {
            let rows = pair.kernel.rows_per_node();
            let mut indices: Vec<usize> = pair.rows.clone().filter(|&row| cycling(row)).map(|row| (row - pair.rows.start) / rows).collect();
            let is_slip = indices.is_empty();
            let tangential = pair.tangential().filter(|&(row, _)| cycling(row));
            indices.extend(tangential.map(|(_, normal_row)| (normal_row - pair.rows.start) / rows));
            indices.sort_unstable();
            indices.dedup();
            let contact = pair.corners.map_or(pair, |corners| &self.system.pairs[corners.pair]);
            let secondary = contact.kernel.secondary();
            let along = secondary.along();
            let place_of = |number: u32| secondary.index(number).and_then(|index| along.iter().position(|&other| other == index));
            // The corners of an obstacle have no name.
            let named = indices.into_iter().filter_map(|index| {
                let number = *pair.kernel.row_nodes().get(index)?;
                let (body, node) = self.system.owner(number as usize);
                Some(CyclingNode { body: body.into(), node, index: place_of(number) })
            });
            (named.collect(), is_slip)
        };
        if last.len() < CYCLE {
            return None;
        }
        let found = self.system.pairs.iter().map(|pair| (pair, of_pair(pair)));
        let (pair, (cycling, is_slip)) = found.max_by_key(|(_, (nodes, _))| nodes.len()).filter(|(_, (nodes, _))| !nodes.is_empty())?;
        Some(FailureCause::CyclingContact { contact: pair.name.clone(), cycling, nodes: pair.kernel.row_nodes().len(), is_slip })
    }

    fn inverted_cell(&self, body: &str, inverted: &Inverted) -> FailureCause {
        let index = self.system.bodies.iter().position(|other| other.name == *body).unwrap_or(0);
        let mesh = &self.model.bodies[index].mesh;
        let corners = mesh.cell(inverted.cell);
        let mut center = [0.0; 3];
        for &node in corners {
            for i in 0..3 {
                center[i] += mesh.points[node as usize][i] / corners.len() as f64;
            }
        }
        let (cell, determinant) = (inverted.cell, inverted.determinant);
        FailureCause::InvertedCell { body: body.into(), cell, determinant, center, dimension: D }
    }

    /// Failure with the load that moves nodes too far in the step as its cause, if there is one; otherwise `outcome` unchanged.
    fn blamed_on_a_load(&self, outcome: FailureCause) -> FailureCause {
        match self.fastest_load().filter(|(_, _, cells)| *cells > FAST_LOAD) {
            Some((load, node, cells)) => {
                let (body, node) = self.system.owner(node);
                FailureCause::LoadTooFast { load, body: body.into(), node, cells, outcome: Box::new(outcome) }
            }
            None => outcome,
        }
    }

    /// Load or prescribed motion with the largest displacement of a node in the step, the node, and the displacement in cells.
    ///
    /// A force moves a node at most by `f dt^2 / 2m`, because of its inertia, and at most by about `f / (E h^(D-2))`, because of the
    /// stiffness of the adjacent cells.
    fn fastest_load(&self) -> Option<(String, usize, f64)> {
        if self.dt == 0.0 {
            return None;
        }
        let (time, positions) = (self.state.row.time, &self.state.positions);
        let mut fastest: Option<(String, usize, f64)> = None;
        let mut note = |name: &str, node: usize, cells: f64| {
            if fastest.as_ref().is_none_or(|(_, _, most)| cells > *most) {
                fastest = Some((name.into(), node, cells));
            }
        };
        for load in &self.system.loads {
            let mut change = vec![0.0; positions.len()];
            let now = if self.state.row.step == 0 { Some(0.0) } else { load.amplitude(time).ok() };
            let (Some(now), Ok(middle)) = (now, load.amplitude(time + 0.5 * self.dt)) else { continue };
            load.force_into(middle - now, positions, &mut change);
            for node in (0..self.system.nodes.count()).filter(|node| !self.system.supports.fixed[node * D]) {
                let force = change[node * D..(node + 1) * D].iter().map(|f| f * f).sum::<f64>().sqrt();
                let (size, modulus) = self.cell_of(node);
                let inertial = 0.5 * force * self.dt * self.dt / self.system.nodes.lumped_mass[node];
                let elastic = force / (modulus * size.powi(D as i32 - 2));
                note(&format!("the load on \"{}\"", load.name), node, inertial.min(elastic) / size);
            }
        }
        if let (Ok((from, _)), Ok((to, rates))) =
            (self.system.supports.prescribed_motion(time), self.system.supports.prescribed_motion(time + self.dt))
        {
            for (index, prescribed) in self.system.supports.prescribed.iter().enumerate() {
                let node = prescribed.unknown / D;
                let moved = (to[index] - from[index]).abs().max(rates[index].abs() * self.dt);
                let what = format!("the prescribed motion of \"{}\"", self.system.supports.boundary(prescribed));
                note(&what, node, moved / self.cell_of(node).0);
            }
        }
        fastest
    }

    /// Body of a connected component without supports whose loads are unbalanced; `None` without one.
    fn unheld(&self) -> Option<String> {
        let (system, positions) = (self.system, &self.state.positions);
        let mut force = system.nodes.weight.clone();
        system.loads_into(positions, self.state.row.time, &mut force).ok()?;
        for (piece, _) in system.nodes.component_is_free.iter().enumerate().filter(|(_, free)| **free) {
            let nodes = (0..system.nodes.count()).filter(|&node| system.nodes.component_of[node] as usize == piece);
            let mut inside = vec![0.0; force.len()];
            let mut first = None;
            let mut size = 0.0;
            for node in nodes {
                first = first.or(Some(node));
                for k in node * D..(node + 1) * D {
                    inside[k] = force[k];
                    size += force[k].abs();
                }
            }
            let largest = |vector: [f64; 3]| vector.iter().fold(0.0f64, |largest, x| largest.max(x.abs()));
            let (sum, turn) = (largest(resultant::<D>(&inside)), largest(moment::<D>(positions, &inside)) / system.nodes.extent);
            if size > 0.0 && sum.max(turn) > EXPLAINED * size {
                return first.map(|node| system.owner(node).0.to_string());
            }
        }
        None
    }

    /// Mean size of the cells around a node and their Young's modulus.
    fn cell_of(&self, node: usize) -> (f64, f64) {
        let index = self.system.body_of(node);
        let body = &self.model.bodies[index];
        let size = (body.mesh.measure() / body.mesh.cell_count() as f64).powf(1.0 / D as f64);
        (size, body.material.youngs_modulus())
    }
}

impl<const D: usize> Evidence<'_, D> {
    /// Constraint at which the elimination of a singular system stopped; `None` if it stopped at a node.
    fn constraint_of(&self, error: &LinearError) -> Option<usize> {
        let LinearError::Singular { vertex: Some(vertex) } = error else { return None };
        (*vertex as usize).checked_sub(self.system.nodes.count())
    }

    /// Explanation of a linear solver failure in terms of the model: the free rigid motion of a body, or the dependent constraints.
    fn explain(&self, error: &LinearError) -> String {
        let (system, positions) = (self.system, &self.state.positions);
        let LinearError::Singular { vertex: Some(vertex) } = error else { return error.to_string() };
        let vertex = *vertex as usize;
        if let Some(row) = self.constraint_of(error) {
            let own = system.pair_of(row);
            let node = own.and_then(|pair| pair.node_of(row));
            if let (Some(own), None) = (own, node) {
                return format!("the constraints of \"{}\" and others depend on one another: singular matrix", own.name);
            }
            // The row at which elimination stops depends on round-off: all pairs that constrain its node are named.
            let pairs = system.pairs.iter().filter(|pair| node.is_some_and(|node| pair.kernel.secondary().index(node).is_some()));
            let mut names: Vec<String> = pairs.map(|pair| format!("\"{}\"", pair.name)).collect();
            let mut known = std::collections::BTreeSet::new();
            names.retain(|name| known.insert(name.clone()));
            let contacts = if names.len() == 1 { "contact" } else { "contacts" };
            return format!("the constraints of {contacts} {} depend on one another: singular matrix", names.join(" and "));
        }
        let (body, number) = system.owner(vertex);
        let nodes = system.bodies.iter().find(|body| body.nodes.contains(&vertex)).map_or(vertex..vertex + 1, |body| body.nodes.clone());
        if system.nodes.component_is_free[system.nodes.component_of[vertex] as usize] {
            return format!("body \"{body}\" can move and turn freely, for it has no support: singular matrix");
        }
        let motion = system.near_null_vector();
        let Some(moved) = motion.get(nodes.start * D..nodes.end * D) else { return error.to_string() };
        match rigid_motion_of::<D>(&positions[nodes.start * D..nodes.end * D], moved, RIGID) {
            Some(rigid) => format!("body \"{body}\" can {rigid} without resistance: singular matrix"),
            None => {
                let along = direction(&motion[vertex * D..(vertex + 1) * D]);
                format!("nothing resists a motion of body \"{body}\" that moves its node {number} along {along}: singular matrix")
            }
        }
    }
}

/// Text of a unit vector, such as `(1.00, 0.00)`.
fn direction(vector: &[f64]) -> String {
    let length = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
    // Adding 0.0 removes the sign of a zero.
    let components: Vec<String> = vector.iter().map(|x| format!("{:.2}", (100.0 * x / length).round() / 100.0 + 0.0)).collect();
    format!("({})", components.join(", "))
}

/// Description of a motion that is rigid up to the relative remainder `within`: `move along (1.00, 0.00)` or, in the plane,
/// `turn about (0.50, 0.25)`; `None` for other motions.
pub fn rigid_motion_of<const D: usize>(positions: &[f64], motion: &[f64], within: f64) -> Option<String> {
    let count = (motion.len() / D) as f64;
    let mut mean = ([0.0; D], [0.0; D]);
    for (x, u) in positions.chunks_exact(D).zip(motion.chunks_exact(D)) {
        for i in 0..D {
            mean.0[i] += x[i] / count;
            mean.1[i] += u[i] / count;
        }
    }
    let (center, shift) = mean;
    // Best-fit rotation about the mean position.
    let (mut moment, mut inertia) = (0.0, 0.0);
    for (x, u) in positions.chunks_exact(D).zip(motion.chunks_exact(D)) {
        if D == 2 {
            let (r, v) = ([x[0] - center[0], x[1] - center[1]], [u[0] - shift[0], u[1] - shift[1]]);
            moment += r[0] * v[1] - r[1] * v[0];
            inertia += r[0] * r[0] + r[1] * r[1];
        }
    }
    let turn = if inertia > 0.0 { moment / inertia } else { 0.0 };
    let (mut rest, mut size, mut turned) = (0.0f64, 0.0f64, 0.0f64);
    for (x, u) in positions.chunks_exact(D).zip(motion.chunks_exact(D)) {
        for i in 0..D {
            let spin = match (D, i) {
                (2, 0) => -turn * (x[1] - center[1]),
                (2, 1) => turn * (x[0] - center[0]),
                _ => 0.0,
            };
            rest = rest.max((u[i] - shift[i] - spin).abs());
            size = size.max(u[i].abs());
            turned = turned.max(spin.abs());
        }
    }
    if size == 0.0 || rest > within * size {
        return None;
    }
    if turned <= within * size {
        return Some(format!("move along {}", direction(&shift)));
    }
    let pole = [center[0] - shift[1] / turn, center[1] + shift[0] / turn];
    Some(format!("turn about ({:.4}, {:.4})", pole[0], pole[1]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [f64; 8] = [0.0, 0.0, 2.0, 0.0, 2.0, 1.0, 0.0, 1.0];

    #[test]
    fn rigid_motions_are_named() {
        let shifted: Vec<f64> = SQUARE.chunks(2).flat_map(|_| [0.0, -3.0]).collect();
        assert_eq!(rigid_motion_of::<2>(&SQUARE, &shifted, RIGID).unwrap(), "move along (0.00, -1.00)");
        let about =
            |pole: [f64; 2]| -> Vec<f64> { SQUARE.chunks(2).flat_map(|x| [-0.1 * (x[1] - pole[1]), 0.1 * (x[0] - pole[0])]).collect() };
        assert_eq!(rigid_motion_of::<2>(&SQUARE, &about([2.0, 0.0]), RIGID).unwrap(), "turn about (2.0000, 0.0000)");
        assert_eq!(rigid_motion_of::<2>(&SQUARE, &about([-1.0, 5.0]), RIGID).unwrap(), "turn about (-1.0000, 5.0000)");
        // stretched: not rigid
        let stretched: Vec<f64> = SQUARE.chunks(2).flat_map(|x| [0.1 * x[0], 0.0]).collect();
        assert_eq!(rigid_motion_of::<2>(&SQUARE, &stretched, RIGID), None);
    }
}
