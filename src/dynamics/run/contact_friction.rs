//! Friction at the nodes of a contact: nodal forces, shear stress, states, slips.
//!
//! The shear stress at a node is `tau L(pressure)/L(lambda)` with the tangential multiplier `tau`, the normal multiplier `lambda`, the
//! node's pressure in the output and the limit `L` of the law. It is therefore at most `L(pressure)`; if a whole contact slips under
//! Coulomb's law, it is coefficient times pressure. In space, stress and slip are the norms of their two components.

use super::fields::NodeState;
use super::loaded::{ContactForces, LoadedContact};
use super::slip_memory::{SlipMemory, Tangential, size};
use crate::contact::SlipState;
use crate::dynamics::parts::contact_pair::{ContactPair, PairKind};
use crate::dynamics::parts::laws::RowState;
use crate::math::tolerances;

/// Adds friction forces to the forces of a contact and of its corners.
pub fn add_friction<const D: usize>(contact: LoadedContact, corners: &[LoadedContact], forces: &mut ContactForces) {
    let secondary = contact.pair.kernel.secondary();
    let (with_itself, count) = (secondary == contact.pair.kernel.primary(), secondary.nodes().len());
    (forces.friction, forces.corner_shears) = (vec![[0.0; 3]; count], vec![0.0; count]);
    let ContactForces { friction, all, corner_shears, corner_forces, .. } = forces;
    if let Some(Tangential { lambda, .. }) = contact.tangential {
        contact.for_each_shear::<D>(lambda, |node, own, _, force| {
            all.push((node, force));
            if own && let Some(index) = secondary.index(node) {
                (0..D).for_each(|i| friction[index][i] += force[i]);
            }
        });
    }
    let (mut of_corners, mut largest) = (vec![[0.0; 3]; count], vec![0.0f64; count]);
    for corners in corners {
        let Some(tangential) = corners.tangential else { continue };
        corners.for_each_shown_shear::<D>(tangential.lambda, |node, own, multiplier, force| {
            all.push((node, force));
            if (!with_itself || own)
                && let Some(index) = secondary.index(node)
            {
                (0..D).for_each(|i| friction[index][i] += force[i]);
                match D {
                    2 => corner_shears[index] += multiplier.signum() * size(&force),
                    _ => (0..D).for_each(|i| of_corners[index][i] += force[i]),
                }
            }
        });
        let shear = tangential.multipliers();
        for row in corners.pair.live_rows(corners.evaluation) {
            let local = row.row - corners.pair.rows.start;
            if corners.lambda[local] > 0.0 {
                let ratio = shear[local].abs() / corners.lambda[local];
                let shown = corners.pair.kernel.shown_at(local, corners.q);
                let nodes = shown.as_ref().map_or(row.nodes, std::slice::from_ref);
                nodes.iter().filter_map(|&node| secondary.index(node)).for_each(|index| largest[index] = largest[index].max(ratio));
            }
        }
    }
    if D == 3 {
        corner_shears.iter_mut().zip(&of_corners).for_each(|(shear, force)| *shear = size(force));
    }
    // Shear forces of several corner constraints add up even if their normal forces have different directions, and act at mid-step: their
    // sum is limited by the normal forces at the end.
    for ((shear, force), largest) in corner_shears.iter_mut().zip(corner_forces).zip(largest) {
        let most = largest * *force;
        *shear = shear.clamp(-most, most);
    }
}

/// Pressure that bounds friction, for a normal multiplier or pressure: a bilateral contact bears on either side.
fn bearing(pair: &ContactPair, pressure: f64) -> f64 {
    if pair.law.is_bilateral() { pressure.abs() } else { pressure.max(0.0) }
}

/// Frictional shear stress at each secondary node, corners included, for the given nodal pressures and areas.
pub fn shears(contact: LoadedContact, forces: &ContactForces, [pressures, areas]: [&[f64]; 2]) -> Vec<f64> {
    let LoadedContact { pair, q, lambda, tangential, .. } = contact;
    let (Some(tangential), Some(friction)) = (tangential, &pair.friction) else { return vec![0.0; forces.own.len()] };
    let (stride, nodes) = (pair.kernel.rows_per_node(), pair.kernel.secondary().nodes());
    let multipliers = tangential.multipliers();
    let limit = |row: usize, pressure: f64| {
        friction.law.limit(SlipState { coefficient: friction.coefficients[row], pressure: bearing(pair, pressure), speed: 0.0 }).shear
    };
    let of = |(index, &pressure): (usize, &f64)| {
        let rows = index * stride..(index + 1) * stride;
        let around = pair.circumference(nodes[index], q);
        let (shear, normal) = (size(&multipliers[rows.clone()]), size(&lambda[rows.clone()]));
        let corners = forces.corner_shears.get(index).map_or(0.0, |corner_shears| corner_shears / areas[index]);
        if shear == 0.0 || around <= 0.0 {
            return corners;
        }
        let (borne, most) = (limit(rows.start, normal / around), limit(rows.start, pressure));
        shear / around * if borne > 0.0 { most / borne } else { 0.0 } + corners
    };
    pressures.iter().enumerate().map(of).collect()
}

/// State of each secondary node, and the number of sliding corners of the primary side.
pub fn states(contact: LoadedContact, corners: &[LoadedContact], active: &[bool]) -> (Vec<NodeState>, usize) {
    let pressed = if is_held(contact) { NodeState::Stick } else { NodeState::Slip };
    let mut states: Vec<NodeState> = active.iter().map(|&active| if active { pressed } else { NodeState::Open }).collect();
    let slides = |state: &RowState| state.slides();
    if let Some(Tangential { active, count, .. }) = contact.tangential {
        let sliding = states.iter_mut().zip(active.iter().step_by(count)).filter(|(_, state)| slides(state));
        sliding.for_each(|(state, _)| *state = NodeState::Slip);
    }
    let mut others = 0;
    for corners in corners {
        let rows = corners.tangential.iter().flat_map(|tangential| tangential.active.iter().step_by(tangential.count)).enumerate();
        for (row, _) in rows.filter(|(_, state)| slides(state)) {
            match corner_node(contact, corners, row / corners.pair.kernel.rows_per_node()) {
                Some(node) => states[node] = NodeState::Slip,
                None => others += 1,
            }
        }
    }
    (states, others)
}

/// True for contacts with friction and for ties, which resist sliding.
fn is_held(contact: LoadedContact) -> bool {
    contact.tangential.is_some() || contact.pair.kind == PairKind::Tie
}

/// True for each corner constraint that slips: its shear stress equals the limit up to round-off.
fn sliding_rows(corners: &LoadedContact, tangential: &Tangential) -> Vec<bool> {
    let Some(friction) = &corners.pair.friction else { return Vec::new() };
    let groups = tangential.active.iter().step_by(tangential.count).zip(tangential.lambda.chunks_exact(tangential.count));
    let slides = |(row, (state, shear)): (usize, (&RowState, &[f64]))| {
        let sliding =
            SlipState { coefficient: friction.coefficients[row], pressure: bearing(corners.pair, corners.lambda[row]), speed: 0.0 };
        let limit = friction.law.limit(sliding).shear;
        state.slides() || limit > 0.0 && size(shear) >= (1.0 - tolerances::ON_CONE) * limit
    };
    groups.enumerate().map(slides).collect()
}

/// Marks as active the secondary nodes loaded by facet and edge constraints that have no node of their own.
pub fn mark_between(contact: LoadedContact, corners: &[LoadedContact], active: &mut [bool], states: &mut [NodeState]) {
    for corners in corners {
        let slides: Vec<bool> = corners.tangential.iter().flat_map(|of| sliding_rows(corners, of)).collect();
        for (row, nodes) in rows_between(contact, corners).into_iter().enumerate() {
            if !corners.active[row].is_closed() {
                continue;
            }
            let is_slip = !is_held(contact) || slides.get(row).is_some_and(|slides| *slides);
            for node in pressed_nodes(&nodes) {
                active[node] = true;
                if is_slip || states[node] == NodeState::Open {
                    states[node] = if is_slip { NodeState::Slip } else { NodeState::Stick };
                }
            }
        }
    }
}

/// Secondary node that owns the constraints of a corner; `None` if there is none.
pub fn corner_node(contact: LoadedContact, corners: &LoadedContact, index: usize) -> Option<usize> {
    corners.pair.kernel.row_nodes().get(index).and_then(|&node| contact.pair.kernel.secondary().index(node))
}

/// Loaded secondary nodes, with their shares of the force, of each corner constraint without a node of its own; equal shares of its first
/// contact element while inactive.
fn rows_between(contact: LoadedContact, corners: &LoadedContact) -> Vec<Vec<(usize, f64)>> {
    let (pair, secondary) = (corners.pair, contact.pair.kernel.secondary());
    let (patches, stride) = (pair.kernel.patches(), pair.kernel.rows_per_node());
    let mut nodes = vec![Vec::new(); corners.active.len()];
    let belongs = |row: usize| corner_node(contact, corners, row / stride).is_some();
    for (row, nodes) in nodes.iter_mut().enumerate() {
        nodes.extend(pair.kernel.shown_at(row, corners.q).and_then(|node| Some((secondary.index(node)?, 1.0))));
    }
    for row in pair.live_rows(corners.evaluation) {
        let local = row.row - pair.rows.start;
        if belongs(local) || pair.kernel.shown_at(local, corners.q).is_some() {
            continue;
        }
        let gradients = corners.evaluation.gradient_end[row.gradient.clone()].chunks_exact(patches.dimension());
        let sizes = row.nodes.iter().zip(gradients).filter_map(|(&node, gradient)| Some((secondary.index(node)?, norm(gradient))));
        nodes[local].extend(sizes.filter(|(_, size)| *size > 0.0));
    }
    for p in 0..patches.len() {
        for &row in patches.rows(p) {
            if nodes[row as usize].is_empty() && !belongs(row as usize) {
                nodes[row as usize].extend(patches.nodes(p).iter().filter_map(|&node| Some((secondary.index(node)?, 1.0))));
            }
        }
    }
    for of_row in &mut nodes {
        let sum: f64 = of_row.iter().map(|(_, share)| share).sum();
        of_row.iter_mut().for_each(|(_, share)| *share /= sum);
    }
    nodes
}

fn norm(vector: &[f64]) -> f64 {
    vector.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Indices of the nodes with a share of the constraint's force above `ZERO_ROW`.
fn pressed_nodes(nodes: &[(usize, f64)]) -> impl Iterator<Item = usize> {
    nodes.iter().filter(|(_, share)| *share > tolerances::ZERO_ROW).map(|(node, _)| *node)
}

/// Accumulated slip, slip path and frictional heat of the secondary nodes: of several constraints the longest slips and the sum of heat.
pub fn slipped(contact: LoadedContact, corners: &[LoadedContact]) -> Vec<SlipMemory> {
    let mut nodes = vec![SlipMemory::default(); contact.pair.kernel.secondary().nodes().len()];
    if let Some(tangential) = contact.tangential {
        nodes.iter_mut().zip(tangential.memories()).for_each(|(node, own)| *node = own);
    }
    let lengthen = |node: &mut SlipMemory, more: &SlipMemory| {
        if more.slip.abs() > node.slip.abs() {
            node.slip = more.slip;
        }
        node.path = node.path.max(more.path);
    };
    for corners in corners.iter().filter(|corners| corners.tangential.is_some()) {
        let between = rows_between(contact, corners);
        for (row, more) in corners.tangential.iter().flat_map(Tangential::memories).enumerate() {
            if let Some(node) = corner_node(contact, corners, row / corners.pair.kernel.rows_per_node()) {
                lengthen(&mut nodes[node], &more);
                nodes[node].heat += more.heat;
                continue;
            }
            pressed_nodes(&between[row]).for_each(|node| lengthen(&mut nodes[node], &more));
            between[row].iter().for_each(|(node, share)| nodes[*node].heat += share * more.heat);
        }
    }
    nodes
}
