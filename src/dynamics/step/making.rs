//! Assembly of a system from bodies, loads and followers of rigid bodies.

use std::collections::BTreeSet;
use std::sync::OnceLock;

use crate::bodies::{BarycentricMap, BodyCells, Elements, Inverted, Plane, RigidMass, Space, nodal_areas};
use crate::dynamics::model::definitions::{BodyDefinition, LoadKind, Model};
use crate::dynamics::model::error::ModelError;
use crate::dynamics::model::growth::unsound;
use crate::dynamics::model::part::Part;
use crate::dynamics::parts::body::Body;
use crate::dynamics::parts::loads::NodalLoad;
use crate::dynamics::parts::rigid_bodies::used_nodes;
use crate::dynamics::parts::rigid_body::RigidBody;
use crate::integrators::{Lumping, Scheme};
use crate::linear::{Block, NodeMatrix, Pattern};

/// A mass at a node, with the node's block in the matrix.
pub struct PointInertia {
    pub node: u32,
    pub mass: f64,
    pub place: Block,
}

/// Deformable bodies with their indices.
pub fn deformable(model: &Model) -> impl Iterator<Item = (usize, &BodyDefinition)> {
    model.bodies.iter().enumerate().filter(|(_, body)| body.rigid.is_none())
}

/// Divides the dependent nodes of rigid bodies into loaded nodes and followers; returns the followers.
pub(super) fn part_followers<const D: usize>(
    model: &Model,
    bodies: &mut [Body<D>],
    first: impl Fn(usize) -> usize,
    reference: &[f64],
    others: &[Box<dyn Part>],
) -> BTreeSet<u32> {
    let mut used = used_nodes(model, first, reference);
    others.iter().for_each(|part| part.for_each_coupling(&mut |nodes| used.extend(nodes)));
    let mut followers = BTreeSet::new();
    for body in bodies {
        let (Some(rigid), Some(inertia)) = (&mut body.rigid, &model.bodies[body.number].rigid) else { continue };
        let RigidBody { dependents, followers: own, .. } = rigid;
        own.retain(|&index| !used.contains(&dependents[index].0));
        followers.extend(own.iter().map(|&index| dependents[index].0));
        let tied: Vec<&(u32, Vec<f64>)> = dependents.iter().filter(|(node, _)| used.contains(node)).collect();
        if !tied.is_empty() {
            let mass = RigidMass::new(&model.bodies[body.number].mesh, &rigid.frame, inertia, body.nodes.start);
            body.elements = Box::new(mass.tied_to(tied.into_iter()));
        }
    }
    followers
}

/// Bodies of a model, and the reference positions of their nodes.
pub(super) fn bodies_of<const D: usize>(model: &Model, integrator: &Scheme) -> Result<(Vec<Body<D>>, Vec<f64>), ModelError>
where
    Space<D>: Elements<D>,
{
    let (mut bodies, mut reference): (Vec<Body<D>>, Vec<f64>) = (Vec::new(), Vec::new());
    for (number, body) in model.bodies.iter().enumerate() {
        let first = reference.len() / D;
        let frame = body.rigid.as_ref().and_then(|inertia| Some((inertia, BarycentricMap::new(&body.mesh)?)));
        let cells = BodyCells {
            first_node: first,
            averages_stress: integrator.averages_stress,
            ..BodyCells::new(&body.mesh, &body.material, body.formulation)
        };
        let mut elements = match &frame {
            Some((inertia, frame)) => Box::new(RigidMass::new(&body.mesh, frame, inertia, first)),
            None => Space::<D>::elements(&cells).map_err(|Inverted { cell, determinant }| ModelError::InvertedCell {
                body: body.name.clone(),
                cell,
                jacobian: determinant,
            })?,
        };
        if let Some(factors) = model.growth(number)
            && elements.grow(&|node| factors[node as usize - first]) <= 0.0
        {
            return Err(unsound(&body.name, "between nodes the factor is not positive".into()));
        }
        reference.extend(body.mesh.points.iter().flat_map(|point| point[..D].to_vec()));
        let nodes = first..reference.len() / D;
        let rigid = frame.map(|(_, frame)| RigidBody::new(&body.mesh.points, frame, first));
        bodies.push(Body {
            name: body.name.clone(),
            number,
            nodes,
            is_lumped: integrator.lumping().is_some(),
            elements,
            recovery: OnceLock::new(),
            rigid,
        });
    }
    Ok((bodies, reference))
}

/// Mass matrix of the given nodes and of other force elements: consistent in a pattern or, without cells, lumped at nodes.
///
/// # Errors
/// Row sums of a body's mass that are not positive at all its nodes.
pub(super) fn mass_of<const D: usize>(
    bodies: &[Body<D>],
    lumping: Option<Lumping>,
    pattern: &Pattern,
    nodes: usize,
    others: &mut Vec<(u32, f64)>,
) -> Result<NodeMatrix, ModelError> {
    let Some(lumping) = lumping else {
        let mut mass = NodeMatrix::new(pattern, nodes);
        bodies.iter().for_each(|body| body.elements.add_mass(&mut mass));
        others.iter().for_each(|&(node, value)| mass.add(node, node, value));
        return Ok(mass);
    };
    let mut mass = vec![0.0; nodes];
    for body in bodies {
        if !body.elements.add_lumped_mass(lumping, &mut mass) {
            return Err(ModelError::NoLumpedMass { body: body.name.clone() });
        }
    }
    others.iter().for_each(|&(node, value)| mass[node as usize] += value);
    *others = (0..).zip(mass.iter().copied()).collect();
    Ok(NodeMatrix::diagonal(mass))
}

/// Time-dependent gravity, as a load on all nodes.
pub(super) fn varying_gravity<const D: usize>(model: &Model, masses: &[f64]) -> Option<NodalLoad<D>> {
    Some(NodalLoad {
        kind: LoadKind::Traction(model.gravity),
        weights: (0..).zip(masses.iter().copied()).collect(),
        facets: Vec::new(),
        is_on_cells: true,
        plane: Plane::Strain,
        amplitude: model.gravity_amplitude.clone()?,
        name: "gravity".into(),
    })
}

/// The loads of a model.
pub(super) fn loads_of<const D: usize>(model: &Model, bodies: &[Body<D>]) -> Vec<NodalLoad<D>> {
    let first = |body: usize| bodies[body].nodes.start;
    let load = model.loads.iter().map(|load| NodalLoad {
        kind: load.kind,
        weights: nodal_areas(&model.bodies[load.on.body].mesh, &load.on.boundary, model.bodies[load.on.body].formulation.plane)
            .into_iter()
            .map(|(node, weight)| (node + first(load.on.body) as u32, weight))
            .collect(),
        facets: match load.kind {
            LoadKind::Pressure(_) => {
                let mesh = &model.bodies[load.on.body].mesh;
                let nodes = |&facet| mesh.facet_nodes(facet).map(|node| node + first(load.on.body) as u32).collect();
                load.on.boundary.facets.iter().map(|facet| (nodes(facet), Vec::new())).collect()
            }
            _ => Vec::new(),
        },
        is_on_cells: model.bodies[load.on.body].rigid.is_none(),
        plane: model.bodies[load.on.body].formulation.plane,
        amplitude: load.amplitude.clone(),
        name: model.boundary_name(&load.on),
    });
    load.collect()
}
