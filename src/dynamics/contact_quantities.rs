//! What a contact pair does at a configuration: nodal forces, their resultant, pressure, gap, area.
//!
//! Forces are `lambda_A grad Phi_A(q)` with the multipliers of the last step. Each patch of a kernel has an own side (the nodes of its
//! constraint rows) and another one on which the opposite forces act. So a surface in contact with itself is covered, too: each pair of
//! its facets is taken once, and its force is that on the side that was taken as secondary.

use super::fields::ContactFields;
use super::ledger::ContactTotals;
use super::pairs::{Pair, PairKind};
use super::simulation::State;
use crate::contact::Evaluation;
use crate::integrators::Integrator;
use crate::math::tolerances;

/// Forces of a pair, evaluated at one configuration.
pub(super) struct PairForces {
    /// On the secondary nodes, from the rows that each of them owns `[force]`.
    pub(super) own: Vec<[f64; 3]>,
    /// On the nodes of both sides, by their numbers in the model, with repetitions `[force]`.
    pub(super) all: Vec<(u32, [f64; 3])>,
}

/// Forces of a pair with its evaluation at a configuration and its multipliers.
pub(super) fn pair_forces<const D: usize>(pair: &Pair, evaluation: &Evaluation, lambda: &[f64]) -> PairForces {
    let (patches, rows_per_node, secondary) = (pair.kernel.patches(), pair.kernel.rows_per_node(), pair.kernel.secondary().nodes());
    let mut own = vec![[0.0; 3]; secondary.len()];
    let mut all = Vec::new();
    for p in (0..patches.len()).filter(|&p| evaluation.live[p]) {
        let (nodes, rows) = (patches.nodes(p), patches.rows(p));
        let gradients = &evaluation.gradient_end[patches.gradient_range(p)];
        for (&row, gradient) in rows.iter().zip(gradients.chunks_exact(patches.unknowns(p))) {
            let factor = lambda[row as usize];
            if factor == 0.0 {
                continue;
            }
            for (u, &node) in nodes.iter().enumerate() {
                let mut force = [0.0; 3];
                (0..D).for_each(|i| force[i] = factor * gradient[u * D + i]);
                all.push((node, force));
                if rows.iter().any(|&row| secondary[row as usize / rows_per_node] == node) {
                    (0..D).for_each(|i| own[row as usize / rows_per_node][i] += force[i]);
                }
            }
        }
    }
    PairForces { own, all }
}

/// Sums over a pair at a configuration.
pub(super) fn totals<const D: usize>(pair: &Pair, evaluation: &Evaluation, lambda: &[f64], active: &[bool], q: &[f64]) -> ContactTotals {
    let forces = pair_forces::<D>(pair, evaluation, lambda);
    summed(pair, &forces, &evaluation.coverage, &evaluation.gap, lambda, active, q)
}

fn summed(pair: &Pair, forces: &PairForces, coverage: &[f64], gap: &[f64], lambda: &[f64], active: &[bool], q: &[f64]) -> ContactTotals {
    let rows = pair.kernel.rows_per_node();
    let mut totals = ContactTotals::default();
    for force in &forces.own {
        (0..3).for_each(|i| totals.force[i] += force[i]);
        totals.normal_force += force[0].hypot(force[1]).hypot(force[2]);
    }
    let weights = pair.kernel.secondary().weights(q);
    for (node, weight) in weights.iter().enumerate() {
        let row = node * rows;
        if active[row..row + rows].contains(&true) {
            totals.active += 1;
            totals.area += coverage[row] * weight;
        }
        totals.pressure = totals.pressure.max(size(&lambda[row..row + rows]));
        if pair.kind != PairKind::Tie && coverage[row] > tolerances::SLIVER {
            totals.penetration = totals.penetration.max(-gap[row] / (coverage[row] * pair.kernel.weights()[row]));
        }
    }
    totals
}

/// One value per secondary node: the only row's own, or the length of several.
fn size(rows: &[f64]) -> f64 {
    match rows {
        [only] => *only,
        _ => rows.iter().map(|value| value * value).sum::<f64>().sqrt(),
    }
}

/// Everything about a pair in a state.
pub(super) fn contact_fields<const D: usize>(pair: &Pair, state: &State) -> ContactFields {
    let (q, rows, secondary) = (&state.positions, pair.kernel.rows_per_node(), pair.kernel.secondary().nodes());
    let (lambda, active) = (&state.lambda[pair.rows.clone()], &state.active[pair.rows.clone()]);
    let (gaps, coverage) = (pair.kernel.gap(q), pair.kernel.coverage(q));
    let mut evaluation = Evaluation::default();
    pair.kernel.evaluate(Integrator::Trapezoidal, q, lambda, &mut evaluation);
    let forces = pair_forces::<D>(pair, &evaluation, lambda);
    let totals = summed(pair, &forces, &coverage, &gaps, lambda, active, q);
    let position = |node: u32| {
        let mut x = [0.0; 3];
        x[..D].copy_from_slice(&q[node as usize * D..(node as usize + 1) * D]);
        x
    };
    let node_rows = || (0..secondary.len()).map(|node| node * rows..(node + 1) * rows);
    ContactFields {
        positions: secondary.iter().map(|&node| position(node)).collect(),
        pressure: node_rows().map(|rows| size(&lambda[rows])).collect(),
        gap: node_rows()
            .map(|rows| {
                let (covered, weight) = (coverage[rows.start], pair.kernel.weights()[rows.start]);
                if covered > tolerances::SLIVER { size(&gaps[rows]) / (covered * weight) } else { f64::NAN }
            })
            .collect(),
        active: active.chunks_exact(rows).map(|rows| rows.contains(&true)).collect(),
        forces: forces.own,
        force: totals.force,
        normal_force: totals.normal_force,
        area: totals.area,
    }
}
