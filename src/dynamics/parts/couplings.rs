//! Linear equations between nodes of boundaries in the numbering of the model: planes of symmetry, periodic pairs.
//!
//! Each equation is `sum_k d_k . x_k = c + s(t)` with constant directions `d_k`. Linear functions are their own discrete gradients: energy
//! is exact. Forces of a plane are external. Forces of a periodic pair have zero resultant (unless it includes a rotation) and a moment,
//! which neighboring cells exert.

use std::sync::Arc;

use nalgebra::Rotation3;

use super::body::Body;
use super::contact_pair::{ContactPair, CoupledNodes, PairKind};
use super::joint_ends::node_vector;
use crate::bodies::Inertia;
use crate::contact::{ContactKernel, PointConstraints, PointFunction};
use crate::dynamics::model::amplitude::Amplitude;
use crate::dynamics::model::couplings::{Coupling, CouplingKind};
use crate::dynamics::model::definitions::Model;
use crate::dynamics::model::joints::Coordinate;
use crate::math::norms::{largest_size, length};
use crate::math::tolerances;

/// Nodes, each with the direction by which its position enters an equation.
type Terms = Vec<(u32, [f64; 3])>;

/// Equations of a coupling in one direction; they differ in their nodes only.
struct Direction {
    /// Direction of the force that the equations exert on the nodes of the plane, or of the second boundary.
    along: [f64; 3],
    /// One equation per node, in which this node is the first term.
    equations: Vec<Terms>,
    /// Value added to the right side of all equations over time.
    offset: Option<Amplitude>,
}

/// Equations of a coupling, direction by direction.
fn directions<const D: usize>(model: &Model, bodies: &[Body<D>], coupling: &Coupling) -> Vec<Direction> {
    let first = |body: usize| bodies[body].nodes.start as u32;
    match &coupling.kind {
        CouplingKind::Plane { on, normal } => {
            let size = length(*normal);
            let along = normal.map(|x| x / size);
            let nodes = model.bodies[on.body].mesh.boundary_nodes(&on.boundary);
            let equations = nodes.into_iter().map(|node| vec![(first(on.body) + node, along)]).collect();
            vec![Direction { along, equations, offset: None }]
        }
        CouplingKind::Periodic { from, to, turn, offset, follows } => {
            // Checked with the model.
            let pairs = model.opposite_nodes(from, to, turn.as_ref()).unwrap_or_default();
            let unit = |i: usize| -> [f64; 3] { std::array::from_fn(|k| if k == i { 1.0 } else { 0.0 }) };
            let rotation = turn.map_or(Rotation3::identity(), |turn| turn.rotation());
            let led: Vec<(u32, f64)> = follows.map_or(Vec::new(), |body| center_of(&bodies[body], model.bodies[body].rigid.as_ref()));
            let equation = |i: usize, [a, b]: [u32; 2]| {
                let led = led.iter().map(move |&(node, share)| (node, unit(i).map(|x| -share * x)));
                let sides = [(first(to.body) + b, unit(i)), (first(from.body) + a, [0, 1, 2].map(|j| -rotation[(i, j)]))];
                sides.into_iter().chain(led).collect()
            };
            let along = |i: usize| Direction {
                along: unit(i),
                equations: pairs.iter().map(|&pair| equation(i, pair)).collect(),
                offset: offset[i].clone(),
            };
            (0..D).map(along).collect()
        }
    }
}

/// Center of mass of a rigid body as coefficients of its masters.
fn center_of<const D: usize>(body: &Body<D>, inertia: Option<&Inertia>) -> Vec<(u32, f64)> {
    let (Some(rigid), Some(inertia)) = (&body.rigid, inertia) else { return Vec::new() };
    rigid.masters.iter().copied().zip(rigid.frame.shares(inertia.center)).collect()
}

/// Pairs of all couplings in the order of the model, one per direction; the equations hold at the positions `start`.
pub fn coupling_pairs<const D: usize>(model: &Model, bodies: &[Body<D>], start: &[f64]) -> Vec<ContactPair> {
    let (reach, size) = (largest_size(start), model.extent());
    let mut pairs = Vec::new();
    for (index, coupling) in model.couplings.iter().enumerate() {
        let modulus = coupling.kind.boundaries().iter().map(|on| model.modulus(on.body)).fold(0.0, f64::max);
        for direction in directions(model, bodies, coupling) {
            let offset = direction.offset.clone();
            let nodes = direction.equations.iter().map(|terms| terms[0].0).collect();
            let coupled = CoupledNodes { coupling: index, along: direction.along, nodes };
            let kernel: Box<dyn ContactKernel> =
                Box::new(constraints(direction.equations, offset.is_some(), start, size, model.dimension()));
            let mut pair = ContactPair::new(&coupling.name, PairKind::Coupling(Arc::new(coupled)), kernel, modulus, reach);
            pair.gap_tolerance = (tolerances::JOINT * size).max(tolerances::GAP_FLOOR * reach);
            pair.closed = (tolerances::CLOSED * size).max(10.0 * pair.gap_tolerance);
            pair.drive = offset.map(|offset| (Coordinate::Travel, offset));
            pairs.push(pair);
        }
    }
    pairs
}

/// Constraints that are satisfied at the positions `start`; if driven, their right side follows a prescribed value.
fn constraints(equations: Vec<Terms>, is_driven: bool, start: &[f64], size: f64, dimension: usize) -> PointConstraints {
    let mut kernel = PointConstraints::new(dimension, size);
    for terms in equations {
        let at_start: f64 =
            terms.iter().map(|(node, along)| (0..dimension).map(|i| along[i] * start[*node as usize * dimension + i]).sum::<f64>()).sum();
        let vectors = terms.iter().map(|(node, _)| node_vector(*node)).collect();
        let linear: Vec<(usize, [f64; 3])> = terms.iter().enumerate().map(|(k, (_, along))| (k, *along)).collect();
        let function = move |value: f64| PointFunction { linear: linear.clone(), constant: -at_start - value, ..PointFunction::default() };
        if is_driven {
            kernel.add_driven(vectors, Box::new(function), 0.0, true);
        } else {
            kernel.add(vectors, vec![function(0.0)], None, true);
        }
    }
    kernel
}
