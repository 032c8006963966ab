//! Quantities of a contact pair at a configuration: nodal forces, their resultant, pressure, gap, area.
//!
//! Forces are `lambda_A grad Phi_A(q)` with the multipliers of the last step. Each contact element has an own side (the nodes of its
//! constraints) and another side with the opposite forces. In self-contact each facet pair is evaluated once, and its force is that on the
//! secondary facet.
//!
//! Pressures are forces per present area, including the circumference in axisymmetric models. The multipliers of a mortar method are nodal
//! values of a linear field on the covered surface. At a partly covered node the field is extrapolated, and its value there can be many
//! times the pressure; the uncovered part is therefore replaced by the mean of the field over the node's part of the contact, the ratio of
//! the nodal force to that of a unit pressure. This mean is also a separate field. A node on the axis of revolution has no force: its
//! pressure is extrapolated from its neighbors.
//!
//! Quantities of friction are in `contact_friction.rs`.

use super::contact_friction::{add_friction, corner_node, mark_between, shears, slipped, states};
use super::fields::{ContactFields, NodeState};
use super::ledger::ContactTotals;
use super::loaded::{ContactForces, LoadedContact};
use super::slip_memory::size;
use crate::contact::Evaluation;
use crate::dynamics::parts::contact_pair::{ContactPair, PairKind};
use crate::dynamics::parts::laws::RowState;
use crate::math::tolerances;

/// Forces of a contact and of its corners.
pub fn contact_forces<const D: usize>(contact: LoadedContact, corners: &[LoadedContact]) -> ContactForces {
    let secondary = contact.pair.kernel.secondary();
    let with_itself = secondary == contact.pair.kernel.primary();
    let count = secondary.nodes().len();
    let mut forces = ContactForces { own: vec![[0.0; 3]; count], corner_forces: vec![0.0; count], ..ContactForces::default() };
    contact.for_each_force::<D>(contact.lambda, |node, own, _, force| {
        forces.all.push((node, force));
        if own && let Some(index) = secondary.index(node) {
            (0..D).for_each(|i| forces.own[index][i] += force[i]);
        }
    });
    forces.mean = means::<D>(contact, contact.lambda, &forces.own, |lambda, visit| contact.for_each_force::<D>(lambda, visit));
    let mut more = vec![[0.0; 3]; count];
    for corners in corners {
        corners.for_each_shown_force::<D>(corners.lambda, |node, own, _, force| {
            forces.all.push((node, force));
            // In self-contact, forces on the corner's own side only.
            if (!with_itself || own)
                && let Some(index) = secondary.index(node)
            {
                (0..D).for_each(|i| more[index][i] += force[i]);
            }
        });
    }
    for (index, force) in more.iter().enumerate() {
        (0..D).for_each(|i| forces.own[index][i] += force[i]);
        forces.corner_forces[index] = size(force);
    }
    forces.normal_count = forces.all.len();
    if contact.tangential.is_some() || corners.iter().any(|corners| corners.tangential.is_some()) {
        add_friction::<D>(contact, corners, &mut forces);
    }
    forces
}

/// Ratio of nodal contact forces to those of unit multipliers, projected on the latter; `for_each` visits the forces. Corners of six-node
/// faces carry almost no force; their multipliers are used instead.
fn means<const D: usize>(
    contact: LoadedContact,
    lambda: &[f64],
    forces: &[[f64; 3]],
    for_each: impl FnOnce(&[f64], &mut dyn FnMut(u32, bool, f64, [f64; 3])),
) -> Vec<f64> {
    let dot = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let unit = unit_forces::<D>(contact, lambda, for_each);
    let covered: Vec<f64> = areas(contact).iter().zip(&contact.evaluation.coverage).map(|(area, share)| area * share).collect();
    let of = |(node, (force, unit)): (usize, (&[f64; 3], &[f64; 3]))| match size(unit) {
        0.0 => 0.0,
        of_unit if D == 3 && of_unit < 0.5 * covered[node] => lambda[node],
        _ => dot(force, unit) / dot(unit, unit),
    };
    forces.iter().zip(&unit).enumerate().map(of).collect()
}

/// Forces of unit multipliers on the secondary nodes; empty if no means are defined or `lambda` is empty.
fn unit_forces<const D: usize>(
    contact: LoadedContact,
    lambda: &[f64],
    for_each: impl FnOnce(&[f64], &mut dyn FnMut(u32, bool, f64, [f64; 3])),
) -> Vec<[f64; 3]> {
    let (pair, secondary) = (contact.pair, contact.pair.kernel.secondary());
    let mut of_unit = vec![[0.0; 3]; secondary.nodes().len()];
    if pair.kernel.rows_per_node() != 1 || pair.kernel.is_nodal() || lambda.iter().all(|lambda| *lambda == 0.0) {
        return of_unit;
    }
    let unit: Vec<f64> = secondary.nodes().iter().map(|&node| pair.circumference(node, contact.q)).collect();
    for_each(&unit, &mut |node, own, _, force| {
        if own && let Some(index) = secondary.index(node) {
            (0..D).for_each(|i| of_unit[index][i] += force[i]);
        }
    });
    of_unit
}

/// Sums over a contact at a configuration.
pub fn totals<const D: usize>(contact: LoadedContact, corners: &[LoadedContact]) -> ContactTotals {
    let forces = contact_forces::<D>(contact, corners);
    summed(contact, corners, &forces)
}

/// Present area of each secondary node, `int N_A ds`; around an axis times the circumference `[length]`, `[length^2]`.
fn areas(contact: LoadedContact) -> Vec<f64> {
    let LoadedContact { pair, q, .. } = contact;
    let secondary = pair.kernel.secondary();
    let mut areas = if secondary.dimension() == 3 { secondary.weights(q) } else { vec![0.0; secondary.nodes().len()] };
    for (facet, ends) in secondary.local_facets().iter().enumerate() {
        let length = secondary.facet_measure(facet, q);
        let [a, b] = secondary.facets()[facet].map(|node| pair.circumference(node, q));
        areas[ends[0] as usize] += length * (2.0 * a + b) / 6.0;
        areas[ends[1] as usize] += length * (a + 2.0 * b) / 6.0;
    }
    areas.iter_mut().enumerate().for_each(|(index, area)| *area *= share(pair, index));
    areas
}

/// Ratio of the weight of a node to its length of facets: 1, except for edges of second order whose nodes have constraints of their own.
fn share(pair: &ContactPair, index: usize) -> f64 {
    let sides = pair.kernel.sides();
    sides.weights[index * pair.kernel.rows_per_node()] / sides.lengths[index]
}

/// True if a node lies on the axis of an axisymmetric body, where circumference, force and multiplier vanish for every pressure.
fn is_on_axis(contact: LoadedContact, index: usize) -> bool {
    let LoadedContact { pair, q, .. } = contact;
    let secondary = pair.kernel.secondary();
    pair.is_axisymmetric && pair.circumference(secondary.nodes()[index], q) <= tolerances::CLOSED * secondary.node_measure(index, q)
}

/// True if a node on the axis touches the other side.
fn touches_on_axis(contact: LoadedContact, index: usize) -> bool {
    let LoadedContact { pair, evaluation, .. } = contact;
    let row = index * pair.kernel.rows_per_node();
    let covered = evaluation.coverage[row];
    is_on_axis(contact, index)
        && covered > tolerances::SLIVER
        && evaluation.gap[row] <= tolerances::TOUCHES_ON_AXIS * pair.kernel.facet_size() * covered * pair.kernel.weights()[row]
}

/// Pressure of a node on the axis that touches the other side: extrapolated from the next two nodes as an even function of the radius.
fn pressure_on_axis(contact: LoadedContact, index: usize, pressures: &[f64]) -> f64 {
    let secondary = contact.pair.kernel.secondary();
    let next = |index: usize, except: usize| {
        let ends = secondary.adjacent_facets(index).iter().flat_map(|&facet| secondary.local_facets()[facet as usize]);
        ends.map(|end| end as usize).find(|&end| end != index && end != except)
    };
    let Some(first) = next(index, index).filter(|_| touches_on_axis(contact, index)) else { return 0.0 };
    let square = |index: usize| contact.q[2 * secondary.nodes()[index] as usize].powi(2);
    match next(first, index).filter(|&second| pressures[second] > 0.0 && square(second) > square(first)) {
        Some(second) => {
            let rise = (pressures[first] - pressures[second]) * square(first) / (square(second) - square(first));
            (pressures[first] + rise).max(0.0)
        }
        None => pressures[first],
    }
}

/// Stress at each secondary node from one multiplier per constraint; `mean` is used at partly covered nodes, `more` is the corner force.
/// Nodes on an axis of revolution get zero.
fn at_nodes(contact: LoadedContact, [lambda, coverage]: [&[f64]; 2], [mean, more]: [&[f64]; 2]) -> Vec<f64> {
    let LoadedContact { pair, q, .. } = contact;
    let (kernel, secondary) = (&pair.kernel, pair.kernel.secondary());
    let (stride, weights, areas) = (kernel.rows_per_node(), kernel.weights(), areas(contact));
    let of = |(index, rows): (usize, &[f64])| {
        if is_on_axis(contact, index) {
            return 0.0;
        }
        let (multiplier, area) = (size(rows), areas[index]);
        let length = share(pair, index) * secondary.node_measure(index, q);
        let around = pair.circumference(secondary.nodes()[index], q) * length;
        let stress = if kernel.is_nodal() {
            multiplier * weights[index * stride] / area
        } else if stride > 1 {
            multiplier
        } else if multiplier == 0.0 {
            0.0
        } else {
            let covered = coverage[index].clamp(0.0, 1.0);
            let at_node = covered * (around / area).min(1.0);
            at_node * multiplier * length / around.max(f64::MIN_POSITIVE) + (1.0 - at_node) * mean[index]
        };
        stress + more[index] / area
    };
    lambda.chunks_exact(stride).enumerate().map(of).collect()
}

/// Pressure at each secondary node, without corner forces.
fn own_pressures(contact: LoadedContact, forces: &ContactForces) -> Vec<f64> {
    let LoadedContact { evaluation, lambda, .. } = contact;
    at_nodes(contact, [lambda, &evaluation.coverage], [&forces.mean, &vec![0.0; forces.own.len()]])
}

/// Pressure at each secondary node, including forces of its corners.
fn pressures(contact: LoadedContact, forces: &ContactForces) -> Vec<f64> {
    let LoadedContact { evaluation, lambda, .. } = contact;
    let mut pressures = at_nodes(contact, [lambda, &evaluation.coverage], [&forces.mean, &forces.corner_forces]);
    for index in (0..pressures.len()).filter(|&index| is_on_axis(contact, index)) {
        pressures[index] = pressure_on_axis(contact, index, &pressures);
    }
    pressures
}

/// Nodal pressures as means over the covered area of each node. The multipliers of a consistent mortar method oscillate beside the edge of
/// a contact, the forces do not.
fn smoothed(contact: LoadedContact, forces: &ContactForces, pressures: &[f64]) -> Vec<f64> {
    let kernel = &contact.pair.kernel;
    if kernel.is_nodal() || kernel.rows_per_node() > 1 {
        return pressures.to_vec();
    }
    let of = |((mean, force), area): ((&f64, &f64), f64)| mean + if *force > 0.0 { force / area } else { 0.0 };
    let mut means: Vec<f64> = forces.mean.iter().zip(&forces.corner_forces).zip(areas(contact)).map(of).collect();
    for index in (0..means.len()).filter(|&index| is_on_axis(contact, index)) {
        means[index] = pressure_on_axis(contact, index, &means);
    }
    means
}

/// True for each node whose consistent force under a uniform pressure points outward: corner nodes of second-order faces in space.
fn pulling(contact: LoadedContact, forces: &[[f64; 3]]) -> Vec<bool> {
    let LoadedContact { pair, q, .. } = contact;
    let secondary = pair.kernel.secondary();
    if secondary.dimension() == 2 || pair.law.is_bilateral() {
        return vec![false; forces.len()];
    }
    let mut outward = vec![[0.0; 3]; forces.len()];
    for facet in 0..secondary.count() {
        let normal = secondary.outward(facet, q);
        for &node in secondary.local_facet(facet) {
            (0..3).for_each(|i| outward[node as usize][i] += normal[i]);
        }
    }
    let dot = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    forces.iter().zip(&outward).map(|(force, normal)| dot(force, normal) > 0.5 * size(force) * size(normal)).collect()
}

/// True for each secondary node in contact, and the number of active corners of the other side.
fn active_nodes(contact: LoadedContact, corners: &[LoadedContact]) -> (Vec<bool>, usize) {
    let nodes = contact.active.chunks_exact(contact.pair.kernel.rows_per_node());
    let mut active: Vec<bool> = nodes.map(|rows| rows.contains(&RowState::Closed)).collect();
    if contact.pair.is_axisymmetric && active.contains(&true) {
        (0..active.len()).for_each(|index| active[index] |= touches_on_axis(contact, index));
    }
    let mut others = 0;
    for corners in corners {
        let kernel = &corners.pair.kernel;
        for (index, _) in
            corners.active.chunks_exact(kernel.rows_per_node()).enumerate().filter(|(_, rows)| rows.contains(&RowState::Closed))
        {
            match corner_node(contact, corners, index) {
                Some(index) => active[index] = true,
                None => others += 1,
            }
        }
    }
    (active, others)
}

fn summed(contact: LoadedContact, corners: &[LoadedContact], forces: &ContactForces) -> ContactTotals {
    let LoadedContact { pair, evaluation: Evaluation { coverage, .. }, .. } = contact;
    let stride = pair.kernel.rows_per_node();
    let mut totals = ContactTotals::default();
    if pair.kind != PairKind::Tie {
        totals.penetration =
            corners.iter().map(|corners| corners.pair.kernel.deepest(contact.q)).fold(pair.kernel.deepest(contact.q), f64::max);
    }
    let shears_into = pulling(contact, &forces.own);
    for (force, shears_into) in forces.own.iter().zip(shears_into) {
        (0..3).for_each(|i| totals.force[i] += force[i]);
        let size = force[0].hypot(force[1]).hypot(force[2]);
        totals.normal_force += if shears_into { -size } else { size };
    }
    forces.friction.iter().for_each(|force| (0..3).for_each(|i| totals.force[i] += force[i]));
    let (areas, pressures) = (areas(contact), pressures(contact, forces));
    let (active, others) = active_nodes(contact, corners);
    totals.active = others;
    if contact.tangential.is_some() {
        let (states, others) = states(contact, corners, &active);
        totals.sliding = others + states.iter().filter(|state| **state == NodeState::Slip).count();
    }
    for (node, area) in areas.iter().enumerate() {
        if active[node] {
            totals.active += 1;
            totals.area += coverage[node * stride] * area;
        }
        totals.pressure = totals.pressure.max(pressures[node]);
    }
    totals
}

/// All fields of a contact in a state, evaluated at its positions.
pub fn contact_fields<const D: usize>(contact: LoadedContact, corners: &[LoadedContact]) -> ContactFields {
    let LoadedContact { pair, evaluation, .. } = contact;
    let (rows, secondary) = (pair.kernel.rows_per_node(), pair.kernel.secondary().nodes());
    let (gaps, coverage) = (&evaluation.gap, &evaluation.coverage);
    let forces = contact_forces::<D>(contact, corners);
    let totals = summed(contact, corners, &forces);
    let pressure = pressures(contact, &forces);
    let position = |node: u32| {
        let mut x = [0.0; 3];
        x[..D].copy_from_slice(&contact.q[node as usize * D..(node as usize + 1) * D]);
        x
    };
    let (mut active, _) = active_nodes(contact, corners);
    let (mut state, _) = states(contact, corners, &active);
    mark_between(contact, corners, &mut active, &mut state);
    let slipped = slipped(contact, corners);
    let mut all = forces.own.clone();
    all.iter_mut().zip(&forces.friction).for_each(|(own, more)| (0..3).for_each(|i| own[i] += more[i]));
    let node_rows = || (0..secondary.len()).map(|node| node * rows..(node + 1) * rows);
    ContactFields {
        positions: secondary.iter().map(|&node| position(node)).collect(),
        mean_pressure: smoothed(contact, &forces, &pressure),
        pressure,
        gap: node_rows()
            .map(|rows| {
                let (covered, weight) = (coverage[rows.start], pair.kernel.weights()[rows.start]);
                if covered > tolerances::SLIVER { size(&gaps[rows]) / (covered * weight) } else { f64::NAN }
            })
            .collect(),
        active,
        state,
        shear: shears(contact, &forces, [&own_pressures(contact, &forces), &areas(contact)]),
        slip: slipped.iter().map(|memory| memory.slip).collect(),
        slip_path: slipped.iter().map(|memory| memory.path).collect(),
        heat: slipped.iter().zip(areas(contact)).map(|(memory, area)| if memory.heat == 0.0 { 0.0 } else { memory.heat / area }).collect(),
        forces: all,
        force: totals.force,
        normal_force: totals.normal_force,
        area: totals.area,
        sliding: totals.sliding,
    }
}
