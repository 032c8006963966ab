//! Forces and moments of joints.

use super::engine::Engine;
use super::fields::{JointFrictionLoad, JointLoad};
use super::ledger::JointTotals;
use super::slip_memory::size;
use crate::bodies::{Elements, Space};
use crate::contact::Evaluation;
use crate::dynamics::model::joints::{Anchor, Coordinate, JointDefinition};
use crate::dynamics::parts::contact_pair::{ContactPair, PairKind, PatchRow};
use crate::dynamics::parts::free_motion::FreeMotion;
use crate::dynamics::parts::nodal::{add_force, add_moment};
use crate::dynamics::step::iterate::Linearization;
use crate::dynamics::step::start::StepStart;
use crate::integrators::Derivative;
use crate::math::norms::largest_size;
use crate::math::tolerances;

/// Evaluations of the normal and of the tangential constraints of all pairs.
type Evaluated<'a> = [&'a [Evaluation]; 2];

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// Force, moment and coordinate of the joint `name`: acting on its second body, with the multipliers of the last step at the present
    /// positions. Returns `None` without such a joint.
    pub fn joint_load(&self, name: &str) -> Option<JointLoad> {
        let index = self.model.joints.iter().position(|joint| joint.name == name)?;
        let joint = &self.model.joints[index];
        let (q, row) = (&self.state.positions, &self.state.row);
        let known = row.joints.get(index);
        let JointTotals { force, moment, value, friction, friction_work, .. } =
            known.copied().unwrap_or_else(|| JointTotals { value: self.joint_value(joint, q, 0.0), ..JointTotals::default() });
        // Damped steps to an equilibrium reset the clock; their forces act at the end.
        let share = if self.state.clock.count == 0 { 1.0 } else { self.options.integrator.share_of_joints() };
        let coordinate = joint.kind.coordinate(D).map(|coordinate| (coordinate, value));
        let work = joint.drive.as_ref().map(|_| known.map_or(0.0, |known| known.work));
        let time = row.time - (1.0 - share) * row.dt;
        let friction = joint.friction.map(|_| JointFrictionLoad { force: friction, work: friction_work });
        Some(JointLoad { force, moment, time, place: self.anchor_place(&joint.ends[1], q)?, coordinate, work, friction })
    }

    /// Forces of all joints in a step that ends at the iterate `at`, at the configuration where the forces act.
    pub(super) fn joints_after(&self, start: &StepStart, at: &Linearization, lambda: &[f64], works: &[f64]) -> Vec<JointTotals> {
        let share = if start.is_at_rest() { 1.0 } else { self.options.integrator.share_of_joints() };
        let acting: Vec<f64> = start.q_0.iter().zip(&at.q_1).map(|(q_0, q_1)| q_0 + share * (q_1 - q_0)).collect();
        self.joint_totals(&at.q_1, (&acting, [&at.pairs, &at.slips]), lambda, works)
    }

    /// Forces of all joints with the multipliers of a step; `acting`: configuration and evaluations at which forces act, `q`: positions at
    /// its end for the coordinates, `works`: work of the drives in this step.
    pub(super) fn joint_totals(&self, q: &[f64], acting: (&[f64], Evaluated), lambda: &[f64], works: &[f64]) -> Vec<JointTotals> {
        let mut works = works.iter();
        let known = &self.state.row.joints;
        let of = |(index, joint): (usize, &JointDefinition)| {
            let mut total = self.joint_total(joint, acting, lambda);
            total.value = self.joint_value(joint, q, known.get(index).map_or(0.0, |known| known.value));
            total.work = if joint.drive.is_some() { works.next().copied().unwrap_or(0.0) } else { 0.0 };
            total
        };
        self.model.joints.iter().enumerate().map(of).collect()
    }

    /// Coordinate of a joint at the positions `q`, counted on from `before`.
    fn joint_value(&self, joint: &JointDefinition, q: &[f64], before: f64) -> f64 {
        FreeMotion::new(&self.model, &self.system.bodies, joint, 1.0).map_or(f64::NAN, |free| free.value(q, before))
    }

    /// Force and moment of a joint in a step; with the gradients of the step they equal the momentum change of its bodies.
    fn joint_total(&self, joint: &JointDefinition, (q, [pairs, slips]): (&[f64], Evaluated), lambda: &[f64]) -> JointTotals {
        let held = joint.ends[1].body.map_or(0..0, |body| self.system.bodies[body].nodes.clone());
        let place = self.anchor_place(&joint.ends[1], q).unwrap_or_default();
        let mut total = JointTotals::default();
        let is_own = |pair: &ContactPair| matches!(pair.kind, PairKind::Joint | PairKind::JointFriction) && pair.name == joint.name;
        for block in self.system.blocks(pairs, slips).filter(|block| is_own(block.pair)) {
            if block.is_slip() {
                let arm = if joint.kind.rotates(D) { block.pair.kernel.facet_size() } else { 1.0 };
                (total.friction, total.friction_work) = (arm * size(&lambda[block.rows.clone()]), block.friction_work(lambda) + 0.0);
            }
            for row in block.live_rows() {
                let pressure = lambda[row.row];
                let gradients = block.evaluation.gradient_bar[row.gradient.clone()].chunks_exact(D);
                for (&node, gradient) in row.nodes.iter().zip(gradients).filter(|(node, _)| held.contains(&(**node as usize))) {
                    let force: [f64; D] = std::array::from_fn(|i| pressure * gradient[i]);
                    let arm: [f64; D] = std::array::from_fn(|i| q[node as usize * D + i] - place[i]);
                    add_force(&mut total.force, &force);
                    add_moment(&mut total.moment, &arm, &force);
                }
            }
        }
        total
    }

    /// Updates the counted turns of joints that gears couple, from the present state.
    pub(super) fn count_turns(&mut self) {
        let known = &self.state.row.joints;
        let value = |joint: usize| known.get(joint).map_or(0.0, |known| known.value);
        for pair in &mut self.system.equations.pairs {
            if let Some(joints) = pair.geared {
                pair.kernel.count_from(joints.map(value));
            }
        }
    }

    /// Joints violated by the initial velocities, with the rate at which each would open `[length/time]`.
    pub fn loose_joints(&self) -> Vec<(String, f64)> {
        let (q, v) = (&self.state.positions, &self.state.velocities);
        let rate = |pair: &ContactPair| {
            let mut evaluation = Evaluation::default();
            pair.kernel.evaluate(Derivative::AT_END, q, &vec![0.0; pair.rows.len()], &mut evaluation);
            // The last constraint of the pair is that of the drive, whose rate is prescribed.
            let driven = pair.drive.as_ref().map_or(0.0, |(coordinate, function)| {
                let arm = if *coordinate == Coordinate::Angle { pair.kernel.facet_size() } else { 1.0 };
                arm * function.rate_of_motion(self.state.row.time).unwrap_or(f64::NAN)
            });
            let of_row = |row: PatchRow| {
                let demanded = if row.row + 1 == pair.rows.end { driven } else { 0.0 };
                (row.unknowns::<D>().map(|(k, entry)| evaluation.gradient_end[entry] * v[k]).sum::<f64>() - demanded).abs()
            };
            pair.live_rows(&evaluation).map(of_row).fold(0.0, f64::max)
        };
        let joints = self.system.pairs.iter().filter(|pair| pair.kind == PairKind::Joint && pair.law.is_bilateral());
        let rates = joints.map(|pair| (pair.name.clone(), rate(pair)));
        rates.filter(|(_, rate)| *rate > tolerances::LOOSE_JOINT * largest_size(v)).collect()
    }

    /// Position of an end of a joint.
    fn anchor_place(&self, anchor: &Anchor, q: &[f64]) -> Option<[f64; 3]> {
        let body = &self.system.bodies[anchor.body?];
        let at = |node: usize, i: usize| if i < D { q[node * D + i] } else { 0.0 };
        let Some(rigid) = &body.rigid else {
            let node = body.nodes.start + self.model.nearest_node(body.number, anchor.point).0 as usize;
            return Some(std::array::from_fn(|i| at(node, i)));
        };
        let shares = rigid.frame.shares(anchor.point);
        Some(std::array::from_fn(|i| rigid.masters.iter().zip(&shares).map(|(&node, share)| share * at(node as usize, i)).sum()))
    }
}
