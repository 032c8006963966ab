//! Separation of initial overlaps in `settle`: measured depths, a limited displacement per step, and a check that no overlap remains.
//!
//! Overlapping pairs are admitted at any depth ([`PredictedMotion::depth`](crate::contact::PredictedMotion::depth)). A damped step closes
//! only part of the overlap: Newton's method moves nodes by a fraction of a facet per iteration, and large strains must stay within its
//! range of convergence. The target thus exceeds the gap at the start by at most a fraction of a facet, which is reduced when a step fails.

use super::engine::Engine;
use crate::bodies::{Elements, Space};
use crate::dynamics::model::definitions::Model;
use crate::dynamics::model::depths::{Depth, Depths};
use crate::dynamics::model::hulls::{BodyHull, MutualPenetration};
use crate::dynamics::model::interactions::Partner;
use crate::dynamics::model::step_error::StepError;
use crate::dynamics::parts::contact_pair::{ContactPair, PairKind};
use crate::dynamics::step::conditions::Conditions;
use crate::dynamics::step::equations::Equations;
use crate::math::tolerances::{LEFT, LEFT_HELD, LEFT_PASSED};

/// Overlap closed in a step, in shortest secondary facets: initial and largest value. A step with 25 iterations of a tenth of a facet moves
/// nodes by 2.5 facets.
const FIRST: f64 = 0.4;
const MOST: f64 = 1.6;

/// Factors of the closed overlap per step after a failed and after a successful step.
const SHRINK: f64 = 0.25;
const GROW: f64 = 2.0;

/// Overlap in shortest secondary facets that needs no gradual closing: contact search always admits half a facet.
const SHALLOW: f64 = 0.25;

/// Reach of a pair as a factor of the measured depth, since gaps and depths are measured along different lines.
const DEEPER: f64 = 1.1;
/// Extra reach of a pair as a fraction of the facet length, since gaps and depths are measured at different points.
const ELSEWHERE: f64 = 0.5;

/// Initial overlaps of contacts and the progress of their closing.
pub struct Closing {
    depths: Depths,
    /// Largest closing in a step, in shortest secondary facets.
    facets: f64,
}

impl Closing {
    /// Initial overlaps of a model, with the closing of the first step.
    pub fn of(model: &Model) -> Closing {
        Closing { depths: Depths::of(model), facets: FIRST }
    }

    /// Depth up to which each pair of the model takes part at rest with the nodes at `q` `[length]`.
    pub fn reaches<const D: usize>(&self, equations: &Equations<D>, q: &[f64], time: f64) -> Vec<f64> {
        let mut reaches = vec![0.0; equations.pairs.len()];
        for found in self.depths.at(q, time, &|_| true) {
            let index = pair_of(equations, &found);
            if let Some(index) = index.filter(|&index| found.depth > SHALLOW * equations.pairs[index].kernel.facet_size()) {
                reaches[index] = DEEPER * found.depth + ELSEWHERE * found.size;
            }
        }
        reaches
    }

    /// Displacement by which the next step separates overlapping sides `[length]`.
    pub fn motion<const D: usize>(&self, equations: &Equations<D>, reaches: &[f64]) -> f64 {
        let sizes = equations.pairs.iter().zip(reaches).filter(|(_, reach)| **reach > 0.0).map(|(pair, _)| pair.kernel.facet_size());
        self.facets * sizes.fold(0.0, f64::max)
    }

    /// Limits the gap targets of a step that starts at `q` to the overlap it may close; returns true if any target was reduced.
    pub fn limit<const D: usize>(&self, equations: &Equations<D>, q: &[f64], conditions: &mut Conditions) -> bool {
        let mut is_part = false;
        for pair in equations.pairs.iter().filter(|pair| !pair.kind.is_bilateral() && pair.has_multipliers()) {
            let closing = self.facets * pair.kernel.facet_size();
            let (gaps, coverage) = (pair.kernel.start_gap(), pair.kernel.coverage(q));
            for (local, row) in pair.rows.clone().enumerate() {
                let nearer = gaps[local] + closing * coverage[local] * pair.kernel.weights()[local];
                if gaps[local] < 0.0 && nearer < conditions.targets[row] {
                    conditions.targets[row] = nearer;
                    is_part = true;
                }
            }
        }
        is_part
    }

    /// Reduces the overlap closed per step after a failure.
    pub fn failed(&mut self) {
        self.facets *= SHRINK;
    }

    /// Increases the overlap closed per step after a success.
    pub fn succeeded(&mut self) {
        self.facets = (GROW * self.facets).min(MOST);
    }
}

/// Index of the pair whose constraints separate an overlap.
fn pair_of<const D: usize>(equations: &Equations<D>, found: &Depth) -> Option<usize> {
    let is_corner = |pair: &ContactPair| pair.kind == PairKind::Obstacle && pair.corners.is_some_and(|of| of.pair == found.contact);
    if found.is_corner { equations.pairs.iter().position(is_corner) } else { Some(found.contact) }
}

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// Refuses contacts whose sides overlap too deeply in the present state to be intended.
    ///
    /// # Errors
    /// Sides overlap: the deepest place.
    pub fn check_overlaps(&self, closing: &Closing) -> Result<(), StepError> {
        let is_left = |found: &Depth| {
            let Some(pair) = pair_of(&self.system, found).map(|index| &self.system.pairs[index]) else { return false };
            let presses = |row: usize| self.state.lambda[row] > 0.0;
            let stride = pair.kernel.rows_per_node();
            let of_node = |&node: &u32| {
                let index = pair.kernel.secondary().index(node)?;
                Some((index * stride..(index + 1) * stride).map(|local| pair.rows.start + local))
            };
            let is_held = if found.is_corner {
                pair.rows.clone().any(presses)
            } else {
                found.nodes.iter().filter_map(of_node).flatten().any(presses)
            };
            let facets = found.depth / found.size;
            facets > LEFT && !(is_held && (!pair.has_multipliers() || facets <= LEFT_HELD))
        };
        let found = self.closing_depths(closing, &is_left);
        let Some(worst) = found.into_iter().max_by(|a, b| (a.depth / a.size).total_cmp(&(b.depth / b.size))) else {
            return self.check_passed();
        };
        Err(StepError::StillOverlaps {
            contact: self.model.interactions[worst.contact].name.clone(),
            time: self.state.row.time,
            depth: worst.depth,
            facets: worst.depth / worst.size,
            at: worst.at.into(),
        })
    }

    /// Checks that no bodies have passed into each other so far that contact search finds no partners and no forces act.
    ///
    /// # Errors
    /// Bodies are inside each other.
    fn check_passed(&self) -> Result<(), StepError> {
        if self.options.accepts_overlap {
            return Ok(());
        }
        let q = &self.state.positions;
        let hull = |body: usize| {
            let std::ops::Range { start, end } = self.system.bodies[body].nodes;
            BodyHull::new(body, &self.model.bodies[body].mesh, &q[D * start..D * end])
        };
        for (index, interaction) in self.model.interactions.iter().enumerate() {
            let Partner::Surfaces(primary) = &interaction.partner else { continue };
            let pairs = std::iter::once(&self.system.pairs[index]).chain(self.system.corners_of(index));
            if D == 2 && pairs.flat_map(|pair| pair.rows.clone()).any(|row| self.state.lambda[row] > 0.0) {
                continue;
            }
            for other in primary.iter().map(|on| on.body).filter(|&other| other != interaction.secondary.body) {
                if let Some(MutualPenetration { depth, size, at }) = hull(interaction.secondary.body).inside(&hull(other))
                    && depth > LEFT_PASSED * size
                {
                    let (contact, time) = (interaction.name.clone(), self.state.row.time);
                    return Err(StepError::StillOverlaps { contact, time, depth, facets: depth / size, at });
                }
            }
        }
        Ok(())
    }

    fn closing_depths(&self, closing: &Closing, counts: &dyn Fn(&Depth) -> bool) -> Vec<Depth> {
        closing.depths.at(&self.state.positions, self.state.row.time, counts)
    }
}
