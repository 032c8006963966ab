//! Nodes of a failed step that friction locks: constrained in one direction, they could only move along the other one, and the friction
//! along it exceeds the component of the pressure that causes the friction.

use super::engine::Engine;
use crate::bodies::{Elements, Space};
use crate::contact::{Evaluation, SlipState};
use crate::dynamics::model::step_error::StepError;
use crate::dynamics::parts::contact_pair::ContactPair;
use crate::integrators::Derivative;

/// Gap of a node, relative to the facet length, below which it counts as touching.
const TOUCHING: f64 = 0.01;

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// Error for a node in the plane that friction locks in the present state; `None` without one.
    ///
    /// With the normal `n`, the tangent `t` and the free direction `d` of a node, its pressure acts along `d` with `n.d`, and friction with
    /// at most `mu t.d`. If `mu |t.d| >= |n.d|` the node can neither stick to a moving side nor slide off it.
    pub(super) fn jammed(&self) -> Option<StepError> {
        let rubs = |pair: &&ContactPair| D == 2 && pair.friction.is_some() && !pair.kind.is_of_points();
        self.system.pairs.iter().filter(rubs).find_map(|pair| self.jammed_in(pair))
    }

    fn jammed_in(&self, pair: &ContactPair) -> Option<StepError> {
        let (system, q) = (&self.system, &self.state.positions);
        let (friction, mut evaluation) = (pair.friction.as_ref()?, Evaluation::default());
        pair.kernel.evaluate(Derivative::AT_END, q, &vec![0.0; pair.rows.len()], &mut evaluation);
        pair.live_rows(&evaluation).find_map(|row| {
            let (local, node) = (row.row - pair.rows.start, pair.node_of(row.row)?);
            let weight = pair.kernel.weights()[local];
            let own: Vec<(usize, usize)> = row.unknowns::<D>().filter(|(unknown, _)| unknown / D == node as usize).collect();
            let free: Vec<usize> = own.iter().filter(|(unknown, _)| !system.supports.fixed[*unknown]).map(|(_, entry)| *entry).collect();
            let size = own.iter().map(|(_, entry)| evaluation.gradient_end[*entry].powi(2)).sum::<f64>().sqrt();
            let &[only] = free.as_slice() else { return None };
            if own.len() != D || size == 0.0 || evaluation.gap[local] > TOUCHING * weight * pair.kernel.facet_size() {
                return None;
            }
            let along = (evaluation.gradient_end[only] / size).abs().min(1.0);
            let across = (1.0 - along * along).sqrt();
            let coefficient = friction.coefficients[local];
            let most = friction.law.limit(SlipState { coefficient, pressure: 1.0, speed: 0.0 }).shear;
            let (body, number) = system.owner(node as usize);
            (most * across > along).then(|| StepError::Jammed {
                contact: pair.name.clone(),
                body: body.into(),
                node: number,
                time: self.state.row.time,
                limit: along / across,
            })
        })
    }
}
