//! Constructor of the contact of the nodes of a surface with rigid obstacles (`rigid.rs`), and their slip in the plane.

use super::kernel::ContactKernel;
use super::node_arcs::{NodeArc, node_arcs};
use super::numbers::Number;
use super::obstacle_side::{Distance, ObstacleSide};
use super::patches::Evaluation;
use super::rigid::{NodesOnObstacle, RigidContact, TouchingPoints};
use super::rigid_shape::{Obstacle, PlaneOutline};
use super::slip::{self, Carrier, SlipRows, SlipStep, Slips};
use super::space::RigidInSpace;
use super::surface::Surface;

/// Contact of nodes, or of arcs about them, in the plane.
pub(super) type RigidInPlane = RigidContact<2, PlaneOutline, NodeArc>;

/// Contact of the nodes of a surface with an obstacle, sized in the reference positions.
pub fn rigid_contact(surface: Surface, obstacle: &Obstacle, reference: &[f64], nodes: NodesOnObstacle) -> Box<dyn ContactKernel> {
    if let Obstacle::InSpace(shape) = obstacle {
        return Box::new(RigidInSpace::of_nodes(surface, shape, reference, nodes));
    }
    let shape = PlaneOutline::new(obstacle);
    let curves = match nodes.points {
        TouchingPoints::Nodes => Vec::new(),
        TouchingPoints::Arcs { radius } => node_arcs(&surface, reference, radius, &shape),
    };
    Box::new(RigidInPlane::new(surface, shape, reference, nodes, curves))
}

/// Slip of nodes relative to the translating obstacle.
impl SlipRows for RigidInPlane {
    fn places(&self, p: usize, _z: &[f64], places: &mut Vec<usize>) -> bool {
        places.extend(0..self.sides.patches.nodes(p).len());
        self.sides_near(p)[0].is_some()
    }

    fn rows<T: Number>(&self, p: usize, _places: &[usize], z: &[T], rows: &mut [T], covered: &mut [f64]) -> bool {
        let middle = self.moved(1);
        let relative = |k: usize| [0, 1].map(|i| z[2 * k + i] - middle[i]);
        let Some(shape) = &self.sides_near(p)[0] else { return false };
        let touching = self.curve(p).map(|arc| {
            let z = [0, 1, 2].map(relative);
            let shares = arc.shares_at(shape, &z);
            (shares, NodeArc::combined(&shares, &z))
        });
        let x = touching.map_or_else(|| relative(0), |(_, x)| x);
        let Distance { normal, covered: true, .. } = shape.at(x.map(|x| x.re()).into()) else { return false };
        let normal = if let PlaneOutline::Circle { center, sign, .. } = shape {
            let r: [T; 2] = std::array::from_fn(|i| x[i] - center[i]);
            let inverse = (r[0] * r[0] + r[1] * r[1]).sqrt().recip() * *sign;
            r.map(|r| r * inverse)
        } else {
            [normal[0], normal[1]].map(T::from)
        };
        let along = [normal[1] * self.weight(p), -normal[0] * self.weight(p)];
        covered[0] = 1.0;
        let Some((shares, _)) = touching else {
            rows.copy_from_slice(&along);
            return true;
        };
        for (row, [a, b]) in rows.chunks_exact_mut(2).zip(shares) {
            (row[0], row[1]) = (a * along[0] + b * along[1], a * along[1] - b * along[0]);
        }
        true
    }

    fn is_relative(&self, _p: usize) -> bool {
        false
    }

    fn other_side(&self) -> Carrier {
        self.shape.carrier(self.carried, self.translations[1])
    }
}

impl Slips for RigidInPlane {
    fn slips(&self, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
        slip::evaluate(self, &self.sides.patches, step, lambda, out);
    }
}
