//! Rigid bodies and joints in global node numbers: dependent nodes, and constraints between points.
//!
//! All mesh nodes of a rigid body are numbered, so that boundaries, loads, contacts, probes and pictures refer to them as to others. Its
//! *masters* have its mass; the distances between them are constant. Nodes with loads, contacts, supports or springs are unknowns with a
//! part of the mass, tied to the masters by linear constraints. The others are *followers*: they are not unknowns and are moved along when
//! a step is accepted.

use std::collections::BTreeSet;

use super::body::Body;
use super::contact_pair::{ContactPair, PairKind};
use super::free_motion::{FreeMotion, geared};
use super::joint_ends::{End, across, node_vector};
use super::joint_reaction::JointReaction;
use super::laws::Unilateral;
use super::rigid_body::RigidBody;
use super::round_contacts::RoundContacts;
use crate::contact::{BallSlip, ContactKernel, JointSlip, PointConstraints, PointFunction, PointVector};
use crate::dynamics::model::boundaries::inner_nodes;
use crate::dynamics::model::definitions::Model;
use crate::dynamics::model::interactions::{BodyBoundary, Partner};
use crate::dynamics::model::joints::{JointDefinition, JointKind};
use crate::dynamics::model::update_rules::PERSISTENCY;
use crate::math::norms::{largest_size, length};
use crate::math::tolerances;

/// Nodes of rigid bodies with constraints of contacts, loads or supports.
pub fn used_nodes(model: &Model, first: impl Fn(usize) -> usize, reference: &[f64]) -> BTreeSet<u32> {
    let round = RoundContacts { model, first: &first, reference };
    let loads = model.loads.iter().map(|load| &load.on);
    let supports = model.supports.iter().map(|support| &support.on).chain(model.prescriptions.iter().map(|given| &given.on));
    let nodes = |on: &BodyBoundary| {
        let first = first(on.body) as u32;
        model.bodies[on.body].mesh.boundary_nodes(&on.boundary).into_iter().map(move |node| node + first).collect::<Vec<_>>()
    };
    let mut used: BTreeSet<u32> = loads.chain(supports).filter(|on| model.bodies[on.body].rigid.is_some()).flat_map(nodes).collect();
    used.extend(model.interactions.iter().flat_map(|interaction| round.constrained_nodes(interaction)));
    // The offset of a tie in space uses a node inside of the body.
    for interaction in model.interactions.iter().filter(|_| model.dimension() == 3) {
        if let Partner::Tied { to, .. } = &interaction.partner
            && model.bodies[to.body].rigid.is_some()
        {
            used.extend(inner_nodes(model, to, first(to.body)));
        }
    }
    used
}

/// Multiplier per slip of a joint's friction in units of weight over size. With 1 here and in [`OF_JOINT`] the admissible residual of
/// friction would be below the round-off of forces.
const OF_WEIGHT: f64 = 10.0;
/// Slip tolerance of a joint's friction in units of the joint's gap tolerance.
const OF_JOINT: f64 = 1000.0;

/// Constraints of rigid bodies and joints: for each body its rigidity and its tied nodes, then for each joint its constraints and its
/// stops.
pub fn point_pairs<const D: usize>(model: &Model, bodies: &[Body<D>], reference: &[f64]) -> Vec<ContactPair> {
    let mut pairs = Vec::new();
    let reach = largest_size(reference);
    let made = |name: &str, kind: PairKind, body: usize, size: f64, kernel: Box<dyn ContactKernel>| {
        let mut pair = ContactPair::new(name, kind, kernel, model.modulus(body), reach);
        pair.gap_tolerance = (tolerances::JOINT * size).max(tolerances::GAP_FLOOR * reach);
        pair.closed = (tolerances::CLOSED * size).max(10.0 * pair.gap_tolerance);
        pair
    };
    let of_points = |name: &str, kind: PairKind, body: usize, size: f64, kernel: PointConstraints| {
        (!kernel.is_empty()).then(|| made(name, kind, body, size, Box::new(kernel)))
    };
    for body in bodies {
        let Some(rigid) = &body.rigid else { continue };
        for kernel in [rigidity::<D>(rigid, reference), ties::<D>(rigid)] {
            pairs.extend(of_points(&body.name, PairKind::Rigidity, body.number, rigid.size, kernel));
        }
    }
    let extent = model.extent();
    for joint in &model.joints {
        let body = joint.bodies().next().unwrap_or(0);
        let joined = model.joints_of(joint).flat_map(JointDefinition::bodies);
        let size = joined.filter_map(|body| bodies[body].rigid.as_ref()).map(|rigid| rigid.size).fold(extent, f64::min);
        if let JointKind::Gear(gear) = joint.kind {
            let coupled: Vec<FreeMotion> = model.joints_of(joint).filter_map(|joint| FreeMotion::new(model, bodies, joint, size)).collect();
            let mut pair = made(&joint.name, PairKind::Joint, body, size, Box::new(geared(&coupled, gear.ratio, size)));
            pair.geared = Some(gear.joints);
            pairs.push(pair);
            continue;
        }
        let pair = of_points(&joint.name, PairKind::Joint, body, size, joint_constraints(model, bodies, joint, size));
        pairs.extend(pair.map(|mut pair| {
            pair.drive = joint.drive.clone().and_then(|drive| Some((joint.kind.coordinate(D)?, drive)));
            if matches!(joint.kind, JointKind::Cable(_)) { one_sided(pair) } else { pair }
        }));
        pairs.extend(slip_of(model, bodies, joint, size).map(|(kernel, limit)| {
            let mut pair = made(&joint.name, PairKind::JointFriction, body, size, kernel);
            // Forces of fast machines exceed those of the weight by orders of magnitude, and so does their round-off.
            pair.c = OF_WEIGHT * (model.modulus(body) * size.powi(D as i32 - 2)).max(limit.constant / size);
            pair.gap_tolerance *= OF_JOINT;
            pair.closed = pair.closed.max(OF_WEIGHT * pair.gap_tolerance);
            pair.add_joint_friction(limit, if joint.kind.is_ball(D) { 3 } else { 1 });
            pair
        }));
        let stops = of_points(&joint.name, PairKind::Joint, body, size, stops(model, bodies, joint, size));
        pairs.extend(stops.map(one_sided));
    }
    pairs
}

/// Slip of a joint with friction, and the limit of its friction; `None` without friction.
fn slip_of<const D: usize>(
    model: &Model,
    bodies: &[Body<D>],
    joint: &JointDefinition,
    size: f64,
) -> Option<(Box<dyn ContactKernel>, JointReaction)> {
    let (friction, components, is_driven) = (joint.friction?, joint.kind.reactions(D), joint.drive.is_some());
    if joint.kind.is_ball(D) {
        let axes = [0, 1, 2].map(|k| std::array::from_fn(|i| if i == k { 1.0 } else { 0.0 }));
        let [first, second] = End::of(model, bodies, joint).map(|end| axes.map(|axis| end.direction(axis)));
        let limit = friction.limit(true).map(|limit| limit / size);
        let limit = JointReaction::new(components, limit, joint.is_grounded(), is_driven);
        return Some((Box::new(BallSlip::new(first, second, size)), limit));
    }
    let free = FreeMotion::new(model, bodies, joint, size)?;
    let limit = free.limit_of(components, &friction, is_driven);
    Some((Box::new(JointSlip::new(geared(std::slice::from_ref(&free), 1.0, size))), limit))
}

/// Makes a pair unilateral (taut cables, stops) under the persistency rule.
fn one_sided(mut pair: ContactPair) -> ContactPair {
    (pair.law, pair.update) = (&Unilateral, &PERSISTENCY);
    pair
}

/// Constant distances between all pairs of masters: `(|x_i - x_j|^2 / l - l) / 2 = 0`.
fn rigidity<const D: usize>(rigid: &RigidBody, reference: &[f64]) -> PointConstraints {
    let mut kernel = PointConstraints::new(D, rigid.size);
    let (mut vectors, mut functions) = (Vec::new(), Vec::new());
    for (k, &a) in rigid.masters.iter().enumerate() {
        for &b in &rigid.masters[..k] {
            let vector = node_vector(a).minus(&node_vector(b));
            let length = length(vector.at(D, reference));
            functions.push(PointFunction {
                products: vec![(vectors.len(), vectors.len(), 0.5 / length)],
                linear: Vec::new(),
                constant: -0.5 * length,
            });
            vectors.push(vector);
        }
    }
    kernel.add(vectors, functions, None, false);
    kernel
}

/// Constraints that tie the loaded nodes of a rigid body to its masters.
fn ties<const D: usize>(rigid: &RigidBody) -> PointConstraints {
    let mut kernel = PointConstraints::new(D, rigid.size);
    for (index, (node, shares)) in rigid.dependents.iter().enumerate() {
        if rigid.followers.binary_search(&index).is_err() {
            let dependents = PointVector { parts: rigid.masters.iter().copied().zip(shares.iter().copied()).collect(), offset: [0.0; 3] };
            kernel.add(vec![node_vector(*node).minus(&dependents)], components(D), Some(*node), false);
        }
    }
    kernel
}

/// Constraint functions: the components of the first vector of a group.
fn components(dimension: usize) -> Vec<PointFunction> {
    let along = |i: usize| std::array::from_fn(|k| if k == i { 1.0 } else { 0.0 });
    (0..dimension).map(|i| PointFunction { linear: vec![(0, along(i))], ..PointFunction::default() }).collect()
}

/// Constraint function: product of two vectors of a group, given by their indices, minus `by`.
fn product(a: usize, b: usize, by: f64) -> PointFunction {
    PointFunction { products: vec![(a, b, by)], ..PointFunction::default() }
}

/// Constraints of a joint; `size` converts angles to lengths.
fn joint_constraints<const D: usize>(model: &Model, bodies: &[Body<D>], joint: &JointDefinition, size: f64) -> PointConstraints {
    let [a, b] = End::of(model, bodies, joint);
    let between = b.point().minus(&a.point());
    let mut vectors = vec![between];
    let mut functions = Vec::new();
    let [_, n, m] = across(joint.kind.direction().unwrap_or([1.0, 0.0, 0.0]));
    let holds = |vectors: &mut Vec<PointVector>, functions: &mut Vec<PointFunction>, pairs: &[[[f64; 3]; 2]]| {
        for &[of_a, of_b] in pairs {
            functions.push(product(vectors.len(), vectors.len() + 1, size));
            vectors.extend([a.direction(of_a), b.direction(of_b)]);
        }
    };
    let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let frames: &[[[f64; 3]; 2]] = if D == 2 { &[[x, y]] } else { &[[x, y], [y, z], [z, x]] };
    match joint.kind {
        // Stops or a drive constrain the distance instead.
        JointKind::Link | JointKind::Cable(_) if joint.limits.is_some() || joint.drive.is_some() => {}
        JointKind::Link => {
            let length = length(joint.distance());
            functions.push(PointFunction { constant: -0.5 * length, ..product(0, 0, 0.5 / length) });
        }
        JointKind::Cable(longest) => {
            functions.push(PointFunction { constant: 0.5 * longest, ..product(0, 0, -0.5 / longest) });
        }
        // A gear constrains two joints, not its own ends.
        JointKind::Gear(_) => {}
        JointKind::Point => functions.extend(components(D)),
        JointKind::Weld => {
            functions.extend(components(D));
            holds(&mut vectors, &mut functions, frames);
        }
        JointKind::Hinge(axis) => {
            functions.extend(components(D));
            let axis = axis.map(|x| x / length(axis));
            holds(&mut vectors, &mut functions, &[[axis, n], [axis, m]]);
        }
        JointKind::Slider(_) | JointKind::Slot(_) => {
            for normal in [n, m].into_iter().take(D - 1) {
                functions.push(product(0, vectors.len(), 1.0));
                vectors.push(a.direction(normal));
            }
            if matches!(joint.kind, JointKind::Slider(_)) {
                holds(&mut vectors, &mut functions, frames);
            }
        }
    }
    let mut kernel = PointConstraints::new(D, size);
    if !functions.is_empty() {
        kernel.add(vectors, functions, None, joint.is_grounded());
    }
    if let (Some(_), Some(free)) = (&joint.drive, FreeMotion::new(model, bodies, joint, size)) {
        free.drive_into(&mut kernel);
    }
    kernel
}

/// Constraints of the stops of a joint.
fn stops<const D: usize>(model: &Model, bodies: &[Body<D>], joint: &JointDefinition, size: f64) -> PointConstraints {
    let mut kernel = PointConstraints::new(D, size);
    if let (Some(limits), Some(free)) = (joint.limits, FreeMotion::new(model, bodies, joint, size)) {
        free.limit_into(limits, &mut kernel);
    }
    kernel
}
