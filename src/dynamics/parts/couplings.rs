//! Equations between nodes of boundaries in global node numbers: planes of symmetry, periodic pairs, reference bodies.
//!
//! Each equation is `sum_k d_k . x_k = c + s(t)` with constant directions `d_k`. Linear functions are their own discrete gradients: energy
//! is exact. Forces of a plane are external. Forces of a periodic pair have zero resultant (unless it includes a rotation) and a moment,
//! which neighboring cells exert.

use std::sync::Arc;

use nalgebra::{Rotation3, Vector3};

use super::body::Body;
use super::contact_pair::{ContactPair, CoupledNodes, PairKind};
use super::joint_ends::node_vector;
use super::rigid_body::RigidBody;
use crate::bodies::{Inertia, nodal_areas};
use crate::contact::{ContactKernel, PointConstraints, PointFunction, PointVector};
use crate::dynamics::model::amplitude::Amplitude;
use crate::dynamics::model::couplings::{Coupling, CouplingKind};
use crate::dynamics::model::definitions::Model;
use crate::dynamics::model::interactions::BodyBoundary;
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
fn directions<const D: usize>(model: &Model, bodies: &[Body<D>], coupling: &Coupling, start: &[f64]) -> Vec<Direction> {
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
        CouplingKind::Reference { on, to, is_rigid } => {
            let Some(rigid) = &bodies[*to].rigid else { return Vec::new() };
            let shares = |point: [f64; 3]| rigid.masters.iter().copied().zip(rigid.frame.shares(point));
            let Weighted { weights, points, center } = weights_of(model, bodies, on, start);
            let equation = |i: usize, nodes: &[(u32, f64)], point: [f64; 3]| -> Terms {
                let along = |by: f64| std::array::from_fn(|k| if k == i { by } else { 0.0 });
                let own = nodes.iter().map(|&(node, share)| (first(on.body) + node, along(share)));
                own.chain(shares(point).map(|(node, share)| (node, along(-share)))).collect()
            };
            let direction = |i: usize| Direction {
                along: std::array::from_fn(|k| if k == i { 1.0 } else { 0.0 }),
                equations: match is_rigid {
                    true => weights.iter().zip(&points).map(|(&(node, _), &point)| equation(i, &[(node, 1.0)], point)).collect(),
                    false => vec![equation(i, &weights, center)],
                },
                offset: None,
            };
            (0..D).map(direction).collect()
        }
    }
}

/// Nodes of a boundary, in the numbering of the body, with their shares of its area, which add up to 1; their positions at the start, and
/// the mean of these. A coupling is made at the start: with positions at rest, its forces would have a moment on bodies that start with
/// displacements.
struct Weighted {
    weights: Vec<(u32, f64)>,
    points: Vec<[f64; 3]>,
    center: [f64; 3],
}

fn weights_of<const D: usize>(model: &Model, bodies: &[Body<D>], on: &BodyBoundary, start: &[f64]) -> Weighted {
    let body = &model.bodies[on.body];
    let areas = nodal_areas(&body.mesh, &on.boundary, body.formulation.plane);
    let whole: f64 = areas.iter().map(|(_, area)| area).sum();
    let weights: Vec<(u32, f64)> = areas.into_iter().map(|(node, area)| (node, area / whole)).collect();
    let first = bodies[on.body].nodes.start;
    let point = |&(node, _): &(u32, f64)| std::array::from_fn(|i| if i < D { start[(first + node as usize) * D + i] } else { 0.0 });
    let points: Vec<[f64; 3]> = weights.iter().map(point).collect();
    let center = std::array::from_fn(|i| weights.iter().zip(&points).map(|(&(_, share), point)| share * point[i]).sum());
    Weighted { weights, points, center }
}

/// Equations of the mean rotation of a boundary with a rigid body: with the unit vectors `e_k` and the arms `r_a` at the start, turned by
/// `R`, `sum_a w_a R (e_k x r_a) . x_a = sum_j R e_j . y_kj`, `y_kj = sum_a w_a (e_k x r_a)_j x_a`, divided by the size of the boundary.
fn mean_rotation<const D: usize>(weighted: &Weighted, first: u32, rigid: &RigidBody, size: f64) -> PointConstraints {
    let Weighted { weights, points, center } = weighted;
    let arms: Vec<Vector3<f64>> = points.iter().map(|point| Vector3::from(*point) - Vector3::from(*center)).collect();
    let scale = weights.iter().zip(&arms).map(|((_, share), arm)| share * arm.norm_squared()).sum::<f64>().sqrt();
    let mut kernel = PointConstraints::new(D, size);
    if scale == 0.0 {
        return kernel;
    }
    let (mut vectors, mut functions) = (Vec::new(), Vec::new());
    for k in if D == 2 { 2..3 } else { 0..3 } {
        let mut function = PointFunction::default();
        for j in 0..D {
            let unit: [f64; 3] = std::array::from_fn(|i| if i == j { 1.0 } else { 0.0 });
            let turned = rigid.masters.iter().copied().zip(rigid.frame.direction(unit)).collect();
            let moment = |(&(node, share), arm): (&(u32, f64), &Vector3<f64>)| (first + node, share * Vector3::ith(k, 1.0).cross(arm)[j]);
            function.products.push((vectors.len(), vectors.len() + 1, 1.0 / scale));
            vectors.push(PointVector { parts: turned, offset: [0.0; 3] });
            vectors.push(PointVector { parts: weights.iter().zip(&arms).map(moment).collect(), offset: [0.0; 3] });
        }
        functions.push(function);
    }
    kernel.add(vectors, functions, None, false);
    kernel
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
        let made = |along: [f64; 3], nodes: Vec<u32>, pushed: Vec<u32>, kernel: Box<dyn ContactKernel>| {
            let coupled = CoupledNodes { coupling: index, along, nodes, pushed };
            let mut pair = ContactPair::new(&coupling.name, PairKind::Coupling(Arc::new(coupled)), kernel, modulus, reach);
            pair.gap_tolerance = (tolerances::JOINT * size).max(tolerances::GAP_FLOOR * reach);
            pair.closed = (tolerances::CLOSED * size).max(10.0 * pair.gap_tolerance);
            pair
        };
        let pushed = match &coupling.kind {
            CouplingKind::Reference { on, .. } => {
                let first = bodies[on.body].nodes.start as u32;
                model.bodies[on.body].mesh.boundary_nodes(&on.boundary).into_iter().map(|node| node + first).collect()
            }
            _ => Vec::new(),
        };
        for direction in directions(model, bodies, coupling, start) {
            let offset = direction.offset.clone();
            let nodes = if pushed.is_empty() { direction.equations.iter().map(|terms| terms[0].0).collect() } else { Vec::new() };
            let frame = Equalities { is_driven: offset.is_some(), is_grounded: pushed.is_empty(), size, dimension: model.dimension() };
            let mut pair = made(direction.along, nodes, pushed.clone(), Box::new(constraints(direction.equations, start, &frame)));
            pair.drive = offset.map(|offset| (Coordinate::Travel, offset));
            pairs.push(pair);
        }
        if let CouplingKind::Reference { on, to, is_rigid: false } = &coupling.kind
            && let Some(rigid) = &bodies[*to].rigid
        {
            let weighted = weights_of(model, bodies, on, start);
            let kernel = mean_rotation::<D>(&weighted, bodies[on.body].nodes.start as u32, rigid, size);
            pairs.extend((!kernel.is_empty()).then(|| made([0.0; 3], Vec::new(), pushed.clone(), Box::new(kernel))));
        }
    }
    pairs
}

/// Properties that the equations of a coupling have in common.
struct Equalities {
    /// True if the right side follows a prescribed value over time.
    is_driven: bool,
    /// True if the constraint forces are external forces.
    is_grounded: bool,
    size: f64,
    dimension: usize,
}

/// Constraints that are satisfied at the positions `start`; if driven, their right side follows a prescribed value.
fn constraints(equations: Vec<Terms>, start: &[f64], properties: &Equalities) -> PointConstraints {
    let &Equalities { is_driven, is_grounded, size, dimension } = properties;
    let mut kernel = PointConstraints::new(dimension, size);
    for terms in equations {
        let at_start: f64 =
            terms.iter().map(|(node, along)| (0..dimension).map(|i| along[i] * start[*node as usize * dimension + i]).sum::<f64>()).sum();
        let vectors = terms.iter().map(|(node, _)| node_vector(*node)).collect();
        let linear: Vec<(usize, [f64; 3])> = terms.iter().enumerate().map(|(k, (_, along))| (k, *along)).collect();
        let function = move |value: f64| PointFunction { linear: linear.clone(), constant: -at_start - value, ..PointFunction::default() };
        if is_driven {
            kernel.add_driven(vectors, Box::new(function), 0.0, is_grounded);
        } else {
            kernel.add(vectors, vec![function(0.0)], None, is_grounded);
        }
    }
    kernel
}
