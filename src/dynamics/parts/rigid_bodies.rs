//! Rigid bodies and joints in the numbering of the model: which nodes are carried, and the constraints between points.
//!
//! All mesh nodes of a rigid body stay in the numbering, so that boundaries, loads, contacts, probes and pictures know it as they know any
//! other. Its *masters* have its mass; the distances between them are constant. Nodes on which something acts (a contact, a load, a
//! support, a spring) are unknowns with a part of the mass that linear constraints tie to the masters; the others are *followers*, which
//! are no unknowns at all: they are moved along when a step is done.

use std::collections::BTreeSet;

use super::body::Body;
use super::carried::Carried;
use super::contact_pair::{ContactPair, PairKind};
use super::laws::Unilateral;
use crate::contact::{PointConstraints, PointFunction, PointVector};
use crate::dynamics::model::boundaries::inner_nodes;
use crate::dynamics::model::definitions::Model;
use crate::dynamics::model::interactions::{BodyBoundary, Partner};
use crate::dynamics::model::joints::{Anchor, JointDefinition, JointKind};
use crate::dynamics::model::update_rules::PERSISTENCY;
use crate::math::norms::largest_size;
use crate::math::tolerances;

/// Nodes of the model on which boundaries of rigid bodies make something act.
pub fn used_nodes(model: &Model, first: impl Fn(usize) -> usize) -> BTreeSet<u32> {
    let contacts = model.interactions.iter().flat_map(|one| std::iter::once(&one.secondary).chain(one.primary()));
    let loads = model.loads.iter().map(|load| &load.on);
    let supports = model.supports.iter().map(|support| &support.on).chain(model.prescriptions.iter().map(|given| &given.on));
    let all = contacts.chain(loads).chain(supports);
    let nodes = |on: &BodyBoundary| {
        let first = first(on.body) as u32;
        model.bodies[on.body].mesh.boundary_nodes(&on.boundary).into_iter().map(move |node| node + first).collect::<Vec<_>>()
    };
    let mut used: BTreeSet<u32> = all.filter(|on| model.bodies[on.body].rigid.is_some()).flat_map(nodes).collect();
    // The offset of a tie in space goes with a node within the body.
    for interaction in model.interactions.iter().filter(|_| model.dimension() == 3) {
        if let Partner::Tied { to, .. } = &interaction.partner
            && model.bodies[to.body].rigid.is_some()
        {
            used.extend(inner_nodes(model, to, first(to.body)));
        }
    }
    used
}

/// The constraints of rigid bodies and joints: for each body its rigidity and what it carries, then one pair for each joint.
pub fn point_pairs<const D: usize>(model: &Model, bodies: &[Body<D>], reference: &[f64]) -> Vec<ContactPair> {
    let mut pairs = Vec::new();
    let reach = largest_size(reference);
    let mut add = |name: &str, kind: PairKind, body: usize, size: f64, kernel: PointConstraints| {
        if !kernel.is_empty() {
            let is_one_sided = |joint: &JointDefinition| joint.name == name && matches!(joint.kind, JointKind::Cable(_));
            let mut pair = ContactPair::new(name, kind, Box::new(kernel), model.modulus(body), reach);
            pair.gap_tolerance = (tolerances::JOINT * size).max(tolerances::GAP_FLOOR * reach);
            pair.closed = (tolerances::CLOSED * size).max(10.0 * pair.gap_tolerance);
            if kind == PairKind::Joint && model.joints.iter().any(is_one_sided) {
                // What is taut gives back what it took.
                (pair.law, pair.update) = (&Unilateral, &PERSISTENCY);
            }
            pairs.push(pair);
        }
    };
    for body in bodies {
        let Some(rigid) = &body.rigid else { continue };
        add(&body.name, PairKind::Rigidity, body.number, rigid.size, rigidity::<D>(rigid, reference));
        add(&body.name, PairKind::Rigidity, body.number, rigid.size, ties::<D>(rigid));
    }
    let extent = model.extent();
    for joint in &model.joints {
        let body = joint.bodies().next().unwrap_or(0);
        let size = joint.bodies().filter_map(|body| bodies[body].rigid.as_ref()).map(|rigid| rigid.size).fold(extent, f64::min);
        add(&joint.name, PairKind::Joint, body, size, joint_constraints(model, bodies, joint, size));
    }
    pairs
}

fn node_vector(node: u32) -> PointVector {
    PointVector { parts: vec![(node, 1.0)], offset: [0.0; 3] }
}

/// The distances between masters stay: `(|x_i - x_j|^2 / l - l) / 2 = 0` of every two.
fn rigidity<const D: usize>(rigid: &Carried, reference: &[f64]) -> PointConstraints {
    let mut kernel = PointConstraints::new(D, rigid.size);
    let (mut vectors, mut functions) = (Vec::new(), Vec::new());
    for (k, &a) in rigid.masters.iter().enumerate() {
        for &b in &rigid.masters[..k] {
            let vector = node_vector(a).minus(&node_vector(b));
            let length = size_of(vector.at(D, reference));
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

/// Nodes on which something acts are where the masters carry them.
fn ties<const D: usize>(rigid: &Carried) -> PointConstraints {
    let mut kernel = PointConstraints::new(D, rigid.size);
    for (index, (node, shares)) in rigid.carried.iter().enumerate() {
        if rigid.followers.binary_search(&index).is_err() {
            let carried = PointVector { parts: rigid.masters.iter().copied().zip(shares.iter().copied()).collect(), offset: [0.0; 3] };
            kernel.add(vec![node_vector(*node).minus(&carried)], components(D), Some(*node), false);
        }
    }
    kernel
}

/// Each component of the first vector.
fn components(dimension: usize) -> Vec<PointFunction> {
    let along = |i: usize| std::array::from_fn(|k| if k == i { 1.0 } else { 0.0 });
    (0..dimension).map(|i| PointFunction { linear: vec![(0, along(i))], ..PointFunction::default() }).collect()
}

/// The product of two vectors by their numbers.
fn product(a: usize, b: usize, by: f64) -> PointFunction {
    PointFunction { products: vec![(a, b, by)], ..PointFunction::default() }
}

fn size_of(vector: [f64; 3]) -> f64 {
    vector.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// One end of a joint in the numbering of the model.
struct End<'a, const D: usize> {
    model: &'a Model,
    body: Option<&'a Body<D>>,
    anchor: Anchor,
}

impl<const D: usize> End<'_, D> {
    /// Its point.
    fn point(&self) -> PointVector {
        let point = self.anchor.point;
        match self.body.map(|body| (body, &body.rigid)) {
            None => PointVector { parts: Vec::new(), offset: point },
            Some((_, Some(rigid))) => {
                PointVector { parts: rigid.masters.iter().copied().zip(rigid.frame.shares(point)).collect(), offset: [0.0; 3] }
            }
            Some((body, None)) => node_vector(body.nodes.start as u32 + self.model.bodies[body.number].nearest_node(point).0),
        }
    }

    /// A direction of it, given at rest.
    fn direction(&self, vector: [f64; 3]) -> PointVector {
        match self.body.and_then(|body| body.rigid.as_ref()) {
            Some(rigid) => {
                PointVector { parts: rigid.masters.iter().copied().zip(rigid.frame.direction(vector)).collect(), offset: [0.0; 3] }
            }
            None => PointVector { parts: Vec::new(), offset: vector },
        }
    }
}

/// Two unit vectors across a direction: in the plane the first lies in it.
pub fn across(direction: [f64; 3]) -> [[f64; 3]; 3] {
    let size = size_of(direction);
    let t = direction.map(|x| x / size);
    let cross = |a: [f64; 3], b: [f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    if t[2] == 0.0 {
        return [t, [-t[1], t[0], 0.0], [0.0, 0.0, 1.0]];
    }
    let smallest = (0..3).min_by(|&a, &b| t[a].abs().total_cmp(&t[b].abs())).unwrap_or(0);
    let axis = std::array::from_fn(|i| if i == smallest { 1.0 } else { 0.0 });
    let raw = cross(t, axis);
    let first = raw.map(|x| x / size_of(raw));
    [t, first, cross(t, first)]
}

/// The constraints of a joint; angles count by `size`, so that all are lengths.
fn joint_constraints<const D: usize>(model: &Model, bodies: &[Body<D>], joint: &JointDefinition, size: f64) -> PointConstraints {
    let [a, b] = joint.ends.map(|anchor| End { model, body: anchor.body.map(|body| &bodies[body]), anchor });
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
        JointKind::Link => {
            let length = size_of(joint.distance());
            functions.push(PointFunction { constant: -0.5 * length, ..product(0, 0, 0.5 / length) });
        }
        JointKind::Cable(longest) => {
            functions.push(PointFunction { constant: 0.5 * longest, ..product(0, 0, -0.5 / longest) });
        }
        JointKind::Point => functions.extend(components(D)),
        JointKind::Weld => {
            functions.extend(components(D));
            holds(&mut vectors, &mut functions, frames);
        }
        JointKind::Hinge(axis) => {
            functions.extend(components(D));
            let axis = axis.map(|x| x / size_of(axis));
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
    kernel.add(vectors, functions, None, joint.is_grounded());
    kernel
}
