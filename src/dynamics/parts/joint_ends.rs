//! One end of a joint in global node numbers: its point, and directions that rotate with its body.

use super::body::Body;
use crate::contact::PointVector;
use crate::dynamics::model::definitions::Model;
use crate::dynamics::model::joints::{Anchor, JointDefinition};
use crate::math::norms::length;

/// Position of a node as a combination of nodes.
pub fn node_vector(node: u32) -> PointVector {
    PointVector { parts: vec![(node, 1.0)], offset: [0.0; 3] }
}

/// One end of a joint in global node numbers.
pub struct End<'a, const D: usize> {
    model: &'a Model,
    body: Option<&'a Body<D>>,
    anchor: Anchor,
}

impl<'a, const D: usize> End<'a, D> {
    /// Both ends of a joint.
    pub fn of(model: &'a Model, bodies: &'a [Body<D>], joint: &JointDefinition) -> [Self; 2] {
        joint.ends.map(|anchor| End { model, body: anchor.body.map(|body| &bodies[body]), anchor })
    }

    /// Attachment point of the end.
    pub fn point(&self) -> PointVector {
        let point = self.anchor.point;
        match self.body.map(|body| (body, &body.rigid)) {
            None => PointVector { parts: Vec::new(), offset: point },
            Some((_, Some(rigid))) => {
                PointVector { parts: rigid.masters.iter().copied().zip(rigid.frame.shares(point)).collect(), offset: [0.0; 3] }
            }
            Some((body, None)) => node_vector(body.nodes.start as u32 + self.model.nearest_node(body.number, point).0),
        }
    }

    /// Direction that rotates with the body, given in the reference positions; constant on the ground.
    pub fn direction(&self, vector: [f64; 3]) -> PointVector {
        match self.body.and_then(|body| body.rigid.as_ref()) {
            Some(rigid) => {
                PointVector { parts: rigid.masters.iter().copied().zip(rigid.frame.direction(vector)).collect(), offset: [0.0; 3] }
            }
            None => PointVector { parts: Vec::new(), offset: vector },
        }
    }
}

/// Unit vector along a direction, and two perpendicular unit vectors; for plane directions the first of these lies in the plane.
pub fn across(direction: [f64; 3]) -> [[f64; 3]; 3] {
    let size = length(direction);
    let t = direction.map(|x| x / size);
    let cross = |a: [f64; 3], b: [f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    if t[2] == 0.0 {
        return [t, [-t[1], t[0], 0.0], [0.0, 0.0, 1.0]];
    }
    let smallest = (0..3).min_by(|&a, &b| t[a].abs().total_cmp(&t[b].abs())).unwrap_or(0);
    let axis = std::array::from_fn(|i| if i == smallest { 1.0 } else { 0.0 });
    let raw = cross(t, axis);
    let first = raw.map(|x| x / length(raw));
    [t, first, cross(t, first)]
}
