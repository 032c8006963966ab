//! Symbols of supports, loads, springs and joints in the picture of the problem, at few places of each boundary.

use serde::Serialize;

use crate::bodies::BarycentricMap;
use crate::dynamics::{BodyBoundary, JointDefinition, JointKind, LoadKind, Model, PartPlace, Prescription};
use crate::mesh::{Facet, Mesh};
use crate::output::recording::Skin;

/// Largest number of symbols along a boundary.
const MOST: usize = 8;
const AXES: [&str; 3] = ["x", "y", "z"];

/// A symbol in the picture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mark {
    /// Kind of the symbol: `support`, `motion`, `load`, `pressure`, `torque`, `gravity`, `line`, `point`, `joint` or `link`.
    pub kind: &'static str,
    /// Name of the boundary, force element or joint.
    pub name: String,
    /// Description in words.
    pub words: String,
    /// Direction of a load or joint, or of the axis of a torque; all zero without one.
    pub along: [f32; 3],
    /// Held directions of a support.
    pub held: [bool; 3],
    /// Places of the symbol: two of a line, otherwise one for each copy.
    pub places: Vec<MarkPlace>,
}

/// Place that moves with recorded nodes of a body, or a fixed point.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum MarkPlace {
    /// Weighted sum of the positions of nodes.
    Nodes {
        /// Index of the body.
        body: usize,
        /// Places of the nodes among the recorded nodes of the body; those of a facet are counterclockwise around its outward normal.
        nodes: Vec<u32>,
        /// Weights of the nodes; their sum is 1.
        shares: Vec<f32>,
    },
    /// Fixed point.
    Point {
        /// Position `[length]`.
        point: [f32; 3],
    },
}

/// Returns the symbols of a model whose recorded nodes are `skins`.
pub fn marks(model: &Model, skins: &[Skin]) -> Vec<Mark> {
    let marker = Marker { model, skins };
    let dimension = model.dimension();
    let held = model.supports.iter().map(|support| {
        let names: Vec<&str> = AXES.into_iter().zip(support.components).take(dimension).filter(|row| row.1).map(|row| row.0).collect();
        let places = marker.spread(&support.on);
        Mark { held: support.components, places, ..Mark::new("support", model.boundary_name(&support.on), &names.join(", ")) }
    });
    let moved = model.prescriptions.iter().map(|given| marker.motion(given));
    let loads = model.loads.iter().map(|load| marker.load(&load.on, load.kind));
    let parts = model.parts.iter().filter_map(|part| {
        let places: Option<Vec<MarkPlace>> = part.places().iter().map(|place| marker.place(place)).collect();
        let places = places.filter(|places| !places.is_empty())?;
        let kind = if places.len() == 2 { "line" } else { "point" };
        Some(Mark { places, ..Mark::new(kind, part.name().to_string(), "") })
    });
    let joints = model.joints.iter().filter_map(|joint| marker.joint(joint));
    let mut all: Vec<Mark> = held.chain(moved).chain(loads).chain(parts).chain(joints).collect();
    all.retain(|mark| !mark.places.is_empty());
    if model.gravity != [0.0; 3] {
        all.push(Mark { along: model.gravity.map(|x| x as f32), ..Mark::new("gravity", String::new(), "gravity") });
    }
    all
}

impl Mark {
    fn new(kind: &'static str, name: String, words: &str) -> Self {
        Mark { kind, name, words: words.into(), along: [0.0; 3], held: [false; 3], places: Vec::new() }
    }
}

struct Marker<'a> {
    model: &'a Model,
    skins: &'a [Skin],
}

impl Marker<'_> {
    fn motion(&self, given: &Prescription) -> Mark {
        let dimension = self.model.dimension();
        let held: [bool; 3] = std::array::from_fn(|component| component < dimension && given.moves(component));
        let names: Vec<&str> = AXES.into_iter().zip(held).filter(|row| row.1).map(|row| row.0).collect();
        let places = self.spread(&given.on);
        Mark { held, places, ..Mark::new("motion", self.model.boundary_name(&given.on), &names.join(", ")) }
    }

    fn load(&self, on: &BodyBoundary, kind: LoadKind) -> Mark {
        let name = self.model.boundary_name(on);
        let along = |vector: [f64; 3]| vector.map(|x| x as f32);
        match kind {
            LoadKind::Traction(vector) => Mark { along: along(vector), places: self.spread(on), ..Mark::new("load", name, "traction") },
            LoadKind::Force(vector) => Mark { along: along(vector), places: self.spread(on), ..Mark::new("load", name, "force") },
            LoadKind::Pressure(_) => Mark { places: self.facets(on), ..Mark::new("pressure", name, "pressure") },
            LoadKind::Torque(axis) => {
                let places = self.mean(on).into_iter().collect();
                Mark { along: along(axis), places, ..Mark::new("torque", name, "torque") }
            }
        }
    }

    fn joint(&self, joint: &JointDefinition) -> Option<Mark> {
        let [from, to] = joint.ends;
        let kind = match joint.kind {
            // The ends of a gear are those of the first of its joints.
            JointKind::Gear(_) => return None,
            JointKind::Link | JointKind::Cable(_) => "link",
            _ => "joint",
        };
        let places = [from, to].map(|end| self.place(&PartPlace::Point(end.body, end.point)));
        let places: Vec<MarkPlace> = places.into_iter().take(if kind == "link" { 2 } else { 1 }).collect::<Option<_>>()?;
        let along = joint.kind.direction().unwrap_or_default().map(|x| x as f32);
        let driven = if joint.drive.is_some() { ", driven" } else { "" };
        Some(Mark { along, places, ..Mark::new(kind, joint.name.clone(), &format!("{}{driven}", joint.kind.name())) })
    }

    fn mesh(&self, body: usize) -> &Mesh {
        &self.model.bodies[body].mesh
    }

    /// Place of nodes with shares; `None` if a node is not recorded.
    fn nodes(&self, body: usize, shares: &[(u32, f64)]) -> Option<MarkPlace> {
        let recorded = &self.skins[body].nodes;
        let nodes: Option<Vec<u32>> = shares.iter().map(|(node, _)| recorded.binary_search(node).ok().map(|place| place as u32)).collect();
        Some(MarkPlace::Nodes { body, nodes: nodes?, shares: shares.iter().map(|&(_, share)| share as f32).collect() })
    }

    fn place(&self, place: &PartPlace) -> Option<MarkPlace> {
        match place {
            PartPlace::Nodes(body, shares) => self.nodes(*body, shares),
            PartPlace::Point(None, point) => Some(MarkPlace::Point { point: point.map(|x| x as f32) }),
            PartPlace::Point(Some(body), point) => {
                let frame = self.model.bodies[*body].rigid.as_ref().and_then(|_| BarycentricMap::new(self.mesh(*body)));
                let shares = match frame {
                    Some(frame) => frame.masters.iter().copied().zip(frame.shares(*point)).collect(),
                    None => vec![(self.model.nearest_node(*body, *point).0, 1.0)],
                };
                self.nodes(*body, &shares)
            }
        }
    }

    /// Nodes of a boundary far from each other.
    fn spread(&self, on: &BodyBoundary) -> Vec<MarkPlace> {
        let mesh = self.mesh(on.body);
        let mut nodes: Vec<u32> = on.boundary.facets.iter().flat_map(|&facet| mesh.facet_nodes(facet)).collect();
        nodes.extend(&on.boundary.nodes);
        nodes.sort_unstable();
        nodes.dedup();
        let points: Vec<[f64; 3]> = nodes.iter().map(|&node| mesh.points[node as usize]).collect();
        apart(&points).into_iter().filter_map(|index| self.nodes(on.body, &[(nodes[index], 1.0)])).collect()
    }

    /// Facets of a boundary far from each other, by the corners around each.
    fn facets(&self, on: &BodyBoundary) -> Vec<MarkPlace> {
        let mesh = self.mesh(on.body);
        let corners = |facet: Facet| -> Vec<u32> {
            let count = if mesh.dimension() == 2 { 2 } else { 3 };
            mesh.facet_nodes(facet).take(count).collect()
        };
        let all: Vec<Vec<u32>> = on.boundary.facets.iter().map(|&facet| corners(facet)).collect();
        let middle = |nodes: &Vec<u32>| -> [f64; 3] {
            std::array::from_fn(|d| nodes.iter().map(|&node| mesh.points[node as usize][d]).sum::<f64>() / nodes.len() as f64)
        };
        let points: Vec<[f64; 3]> = all.iter().map(middle).collect();
        let share = |nodes: &[u32]| nodes.iter().map(|&node| (node, 1.0 / nodes.len() as f64)).collect::<Vec<_>>();
        apart(&points).into_iter().filter_map(|index| self.nodes(on.body, &share(&all[index]))).collect()
    }

    /// Mean of some nodes of a boundary.
    fn mean(&self, on: &BodyBoundary) -> Option<MarkPlace> {
        let (mut all, mut shares) = (Vec::new(), Vec::new());
        for place in self.spread(on) {
            if let MarkPlace::Nodes { nodes, .. } = place {
                all.extend(nodes);
            }
        }
        shares.resize(all.len(), 1.0 / all.len().max(1) as f32);
        (!all.is_empty()).then_some(MarkPlace::Nodes { body: on.body, nodes: all, shares })
    }
}

/// Returns the indices of at most `MOST` points, each as far as possible from those before it.
fn apart(points: &[[f64; 3]]) -> Vec<usize> {
    let square = |a: [f64; 3], b: [f64; 3]| (0..3).map(|d| (a[d] - b[d]).powi(2)).sum::<f64>();
    let mut chosen = Vec::new();
    let mut nearest = vec![f64::INFINITY; points.len()];
    while chosen.len() < MOST.min(points.len()) {
        let farthest = (0..points.len()).rev().max_by(|&a, &b| nearest[a].total_cmp(&nearest[b]));
        let Some(next) = farthest.filter(|&index| nearest[index] > 0.0) else { break };
        nearest.iter_mut().zip(points).for_each(|(distance, &point)| *distance = distance.min(square(point, points[next])));
        chosen.push(next);
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbols_of_a_long_edge_are_few_and_at_its_ends() {
        let edge: Vec<[f64; 3]> = (0..1001).map(|k| [f64::from(k), 0.0, 0.0]).collect();
        let mut chosen = apart(&edge);
        assert_eq!(chosen.len(), MOST);
        chosen.sort_unstable();
        assert_eq!((chosen[0], chosen[MOST - 1]), (0, 1000));
        assert!(chosen.windows(2).all(|pair| pair[1] - pair[0] >= 100), "{chosen:?}");
        assert_eq!(apart(&edge[..2]), [0, 1]);
        assert!(apart(&[]).is_empty());
    }
}
