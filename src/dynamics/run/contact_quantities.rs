//! What a contact pair does at a configuration: nodal forces, their resultant, pressure, gap, area.
//!
//! Forces are `lambda_A grad Phi_A(q)` with the multipliers of the last step. Each patch of a kernel has an own side (the nodes of its
//! constraint rows) and another one on which the opposite forces act. So a surface in contact with itself is covered, too: each pair of
//! its facets is taken once, and its force is that on the side that was taken as secondary.

use super::fields::ContactFields;
use super::ledger::ContactTotals;
use crate::contact::Evaluation;
use crate::dynamics::parts::contact_pair::{ContactPair, PairKind, RowState};
use crate::math::tolerances;

/// Forces of a contact, evaluated at one configuration.
pub struct ContactForces {
    /// On the secondary nodes, from the rows that each of them owns and from corners `[force]`.
    pub own: Vec<[f64; 3]>,
    /// Sizes of what corners press on each secondary node `[force]`.
    pressed: Vec<f64>,
    /// On the nodes of both sides, by their numbers in the model, with repetitions `[force]`.
    pub all: Vec<(u32, [f64; 3])>,
}

/// A pair with its evaluation at a configuration and its multipliers.
#[derive(Clone, Copy)]
pub struct Loaded<'a> {
    pub pair: &'a ContactPair,
    pub evaluation: &'a Evaluation,
    pub lambda: &'a [f64],
    pub active: &'a [RowState],
}

impl Loaded<'_> {
    /// Tells the force of every row on every node of its patches: the node, whether it owns a row of the patch, the force.
    fn for_each_force<const D: usize>(&self, mut tell: impl FnMut(u32, bool, [f64; 3])) {
        let Loaded { pair, evaluation, lambda, .. } = self;
        for row in pair.live_rows(evaluation) {
            let factor = lambda[row.row - pair.rows.start];
            if factor == 0.0 {
                continue;
            }
            let gradient = &evaluation.gradient_end[row.gradient];
            for (&node, gradient) in row.nodes.iter().zip(gradient.chunks_exact(D)) {
                let mut force = [0.0; 3];
                (0..D).for_each(|i| force[i] = factor * gradient[i]);
                tell(node, pair.owns_row(row.patch, node), force);
            }
        }
    }
}

/// Forces of a contact and of its corners.
pub fn contact_forces<const D: usize>(contact: Loaded, corners: &[Loaded]) -> ContactForces {
    let secondary = contact.pair.kernel.secondary();
    let with_itself = secondary == contact.pair.kernel.primary();
    let count = secondary.nodes().len();
    let mut forces = ContactForces { own: vec![[0.0; 3]; count], pressed: vec![0.0; count], all: Vec::new() };
    contact.for_each_force::<D>(|node, own, force| {
        forces.all.push((node, force));
        if own && let Some(index) = secondary.index(node) {
            (0..D).for_each(|i| forces.own[index][i] += force[i]);
        }
    });
    let mut more = vec![[0.0; 3]; count];
    for corners in corners {
        corners.for_each_force::<D>(|node, own, force| {
            forces.all.push((node, force));
            // On a surface that touches itself, the corner's side.
            if (!with_itself || own)
                && let Some(index) = secondary.index(node)
            {
                (0..D).for_each(|i| more[index][i] += force[i]);
            }
        });
    }
    for (index, force) in more.iter().enumerate() {
        (0..D).for_each(|i| forces.own[index][i] += force[i]);
        forces.pressed[index] = size(force);
    }
    forces
}

/// Sums over a contact at a configuration.
pub fn totals<const D: usize>(contact: Loaded, corners: &[Loaded], q: &[f64]) -> ContactTotals {
    let forces = contact_forces::<D>(contact, corners);
    summed(contact, corners, &forces, q)
}

/// Pressure at each secondary node: its multiplier, and what corners press on it over its length.
fn pressures(contact: Loaded, forces: &ContactForces, q: &[f64]) -> Vec<f64> {
    let (stride, weights) = (contact.pair.kernel.rows_per_node(), contact.pair.kernel.weights());
    let nodes = contact.pair.kernel.secondary().nodes();
    let of = |(index, rows): (usize, &[f64])| {
        (size(rows) + forces.pressed[index] / weights[index * stride]) / contact.pair.circumference(nodes[index], q)
    };
    contact.lambda.chunks_exact(stride).enumerate().map(of).collect()
}

/// Which secondary nodes are in contact, and how many corners of the other side are.
fn active_nodes(contact: Loaded, corners: &[Loaded]) -> (Vec<bool>, usize) {
    let nodes = contact.active.chunks_exact(contact.pair.kernel.rows_per_node());
    let mut active: Vec<bool> = nodes.map(|rows| rows.contains(&RowState::Closed)).collect();
    let mut others = 0;
    for corners in corners {
        let kernel = &corners.pair.kernel;
        for (index, _) in
            corners.active.chunks_exact(kernel.rows_per_node()).enumerate().filter(|(_, rows)| rows.contains(&RowState::Closed))
        {
            match kernel.row_nodes().get(index).and_then(|&node| contact.pair.kernel.secondary().index(node)) {
                Some(index) => active[index] = true,
                None => others += 1,
            }
        }
    }
    (active, others)
}

fn summed(contact: Loaded, corners: &[Loaded], forces: &ContactForces, q: &[f64]) -> ContactTotals {
    let Loaded { pair, evaluation: Evaluation { coverage, .. }, .. } = contact;
    let stride = pair.kernel.rows_per_node();
    let mut totals = ContactTotals::default();
    if pair.kind != PairKind::Tie {
        totals.penetration = corners.iter().map(|corners| corners.pair.kernel.deepest(q)).fold(pair.kernel.deepest(q), f64::max);
    }
    for force in &forces.own {
        (0..3).for_each(|i| totals.force[i] += force[i]);
        totals.normal_force += force[0].hypot(force[1]).hypot(force[2]);
    }
    let (weights, pressures) = (pair.kernel.secondary().weights(q), pressures(contact, forces, q));
    let (active, others) = active_nodes(contact, corners);
    totals.active = others;
    for (node, weight) in weights.iter().enumerate() {
        let row = node * stride;
        if active[node] {
            totals.active += 1;
            totals.area += coverage[row] * weight * pair.circumference(pair.kernel.secondary().nodes()[node], q);
        }
        totals.pressure = totals.pressure.max(pressures[node]);
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

/// Everything about a contact in a state, evaluated at its positions.
pub fn contact_fields<const D: usize>(contact: Loaded, corners: &[Loaded], q: &[f64]) -> ContactFields {
    let Loaded { pair, evaluation, .. } = contact;
    let (rows, secondary) = (pair.kernel.rows_per_node(), pair.kernel.secondary().nodes());
    let (gaps, coverage) = (&evaluation.gap, &evaluation.coverage);
    let forces = contact_forces::<D>(contact, corners);
    let totals = summed(contact, corners, &forces, q);
    let position = |node: u32| {
        let mut x = [0.0; 3];
        x[..D].copy_from_slice(&q[node as usize * D..(node as usize + 1) * D]);
        x
    };
    let node_rows = || (0..secondary.len()).map(|node| node * rows..(node + 1) * rows);
    ContactFields {
        positions: secondary.iter().map(|&node| position(node)).collect(),
        pressure: pressures(contact, &forces, q),
        gap: node_rows()
            .map(|rows| {
                let (covered, weight) = (coverage[rows.start], pair.kernel.weights()[rows.start]);
                if covered > tolerances::SLIVER { size(&gaps[rows]) / (covered * weight) } else { f64::NAN }
            })
            .collect(),
        active: active_nodes(contact, corners).0,
        forces: forces.own,
        force: totals.force,
        normal_force: totals.normal_force,
        area: totals.area,
    }
}
