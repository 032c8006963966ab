//! What joints exert.

use super::engine::Engine;
use super::fields::JointLoad;
use crate::bodies::{Elements, Space};
use crate::contact::Evaluation;
use crate::dynamics::model::joints::Anchor;
use crate::dynamics::parts::contact_pair::{ContactPair, PairKind, PatchRow};
use crate::dynamics::parts::nodal::{add_force, add_moment};
use crate::integrators::Derivative;
use crate::math::norms::largest_size;
use crate::math::tolerances;

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// What the joint of that name exerts on the body that it holds, with the multipliers of the last step in the present positions;
    /// `None` when there is none.
    pub fn joint_load(&self, name: &str) -> Option<JointLoad> {
        let index = self.model.joints.iter().position(|joint| joint.name == name)?;
        let joint = &self.model.joints[index];
        let pair = self.system.pairs.iter().filter(|pair| pair.kind == PairKind::Joint).nth(index)?;
        let (q, lambda) = (&self.state.positions, &self.state.lambda[pair.rows.clone()]);
        let held = self.system.bodies[joint.ends[1].body?].nodes.clone();
        let place = self.anchor_place(&joint.ends[1])?;
        let mut evaluation = Evaluation::default();
        pair.kernel.evaluate(Derivative::AT_END, q, lambda, &mut evaluation);
        let mut load = JointLoad { force: [0.0; 3], moment: [0.0; 3], place };
        for row in pair.live_rows(&evaluation) {
            let pressure = lambda[row.row - pair.rows.start];
            let gradients = evaluation.gradient_end[row.gradient.clone()].chunks_exact(D);
            for (&node, gradient) in row.nodes.iter().zip(gradients).filter(|(node, _)| held.contains(&(**node as usize))) {
                let force: [f64; D] = std::array::from_fn(|i| pressure * gradient[i]);
                let arm: [f64; D] = std::array::from_fn(|i| q[node as usize * D + i] - place[i]);
                add_force(&mut load.force, &force);
                add_moment(&mut load.moment, &arm, &force);
            }
        }
        Some(load)
    }

    /// Joints that the velocities at the start do not fit, with the rate at which what they hold would part `[length/time]`.
    pub fn loose_joints(&self) -> Vec<(String, f64)> {
        let (q, v) = (&self.state.positions, &self.state.velocities);
        let rate = |pair: &ContactPair| {
            let mut evaluation = Evaluation::default();
            pair.kernel.evaluate(Derivative::AT_END, q, &vec![0.0; pair.rows.len()], &mut evaluation);
            let of_row = |row: PatchRow| row.unknowns::<D>().map(|(k, entry)| evaluation.gradient_end[entry] * v[k]).sum::<f64>().abs();
            pair.live_rows(&evaluation).map(of_row).fold(0.0, f64::max)
        };
        let joints = self.system.pairs.iter().filter(|pair| pair.kind == PairKind::Joint && pair.law.is_bilateral());
        let rates = joints.map(|pair| (pair.name.clone(), rate(pair)));
        rates.filter(|(_, rate)| *rate > tolerances::LOOSE_JOINT * largest_size(v)).collect()
    }

    /// Where an end of a joint is.
    fn anchor_place(&self, anchor: &Anchor) -> Option<[f64; 3]> {
        let body = &self.system.bodies[anchor.body?];
        let q = &self.state.positions;
        let at = |node: usize, i: usize| if i < D { q[node * D + i] } else { 0.0 };
        let Some(rigid) = &body.rigid else {
            let node = body.nodes.start + self.model.bodies[body.number].nearest_node(anchor.point).0 as usize;
            return Some(std::array::from_fn(|i| at(node, i)));
        };
        let shares = rigid.frame.shares(anchor.point);
        Some(std::array::from_fn(|i| rigid.masters.iter().zip(&shares).map(|(&node, share)| share * at(node as usize, i)).sum()))
    }
}
