//! Motion of contacts that is too large for one step: predicted before the step, or found in the converged step.

use super::conditions::Conditions;
use super::equations::Equations;
use super::iterate::Linearization;
use super::large_motion::{LargeMotion, MotionKind};
use crate::dynamics::parts::contact_pair::{ContactPair, PairKind};
use crate::dynamics::parts::laws::RowState;
use crate::math::tolerances;

impl<const D: usize> Equations<D> {
    /// Predicted motion that is too large for one step: sliding of surfaces in contact beyond [`tolerances::SLIDING`], approach beyond
    /// [`tolerances::APPROACH`] under the persistency rule, of obstacles beyond [`tolerances::PASSING`] under all rules.
    pub fn foreseen(&self, q_0: &[f64], predicted: &[f64], conditions: &Conditions, active: &[RowState]) -> Option<LargeMotion> {
        for pair in self.pairs.iter().filter(|pair| !pair.kind.is_bilateral()) {
            let size = pair.kernel.facet_size();
            let facets = self.sliding(pair, q_0, predicted, active) / size;
            if facets > tolerances::SLIDING {
                return Some(LargeMotion { contact: pair.name.clone(), kind: MotionKind::Sliding, facets });
            }
            if let Some(facets) = passing(pair, predicted, true) {
                return Some(LargeMotion { contact: pair.name.clone(), kind: MotionKind::Passing, facets });
            }
            if pair.may_penetrate() {
                let facets = through(pair, conditions, &pair.kernel.gap(predicted), &pair.kernel.coverage(predicted));
                if facets > tolerances::APPROACH {
                    return Some(LargeMotion { contact: pair.name.clone(), kind: MotionKind::Approach, facets });
                }
            }
        }
        None
    }

    /// Largest penetration of a converged step that began at `q_0`, if it is too large: nodes that have passed through a rigid obstacle, or
    /// nodes behind the other side under the persistency rule. Elastic motion is not predicted, so this is checked afterwards. An inactive
    /// constraint counts with its gap; every node counts with its penetration where that has grown, since a closed weighted gap only bounds
    /// a mean over its neighborhood.
    pub fn penetration_after_step(&self, q_0: &[f64], at: &Linearization, conditions: &Conditions) -> Option<LargeMotion> {
        let passed = |pair: &ContactPair| {
            let facets = passing(pair, &at.q_1, false)?;
            Some(LargeMotion { contact: pair.name.clone(), kind: MotionKind::Passing, facets })
        };
        if let Some(motion) = self.pairs.iter().find_map(passed) {
            return Some(motion);
        }
        self.pairs.iter().zip(&at.pairs).filter(|(pair, _)| pair.may_penetrate()).find_map(|(pair, evaluation)| {
            let facets = through(pair, conditions, &evaluation.gap, &evaluation.coverage).max(sunk(pair, q_0, &at.q_1));
            (facets > tolerances::CAME_THROUGH).then(|| LargeMotion { contact: pair.name.clone(), kind: MotionKind::CameThrough, facets })
        })
    }

    /// Largest predicted motion of the secondary nodes of an active contact element relative to its primary nodes `[length]`.
    fn sliding(&self, pair: &ContactPair, q_0: &[f64], predicted: &[f64], active: &[RowState]) -> f64 {
        let patches = pair.kernel.patches();
        if !active[pair.rows.clone()].contains(&RowState::Closed) {
            return 0.0;
        }
        // Sides on which each node of the model lies: a search for every contact element would dominate the time of this check.
        const SECONDARY: u8 = 1;
        const PRIMARY: u8 = 2;
        let mut lies_on = vec![0u8; self.nodes.count()];
        for (side, surface) in [(SECONDARY, pair.kernel.secondary()), (PRIMARY, pair.kernel.primary())] {
            surface.nodes().iter().for_each(|&node| lies_on[node as usize] |= side);
        }
        let mut largest = 0.0f64;
        for p in 0..patches.len() {
            if !patches.rows(p).iter().any(|&row| active[pair.rows.start + row as usize].is_closed()) {
                continue;
            }
            let mean = |side: u8| -> Option<[f64; D]> {
                let (mut sum, mut count) = ([0.0; D], 0.0);
                pair.kernel.for_each_participant(p, &mut |node| {
                    if lies_on[node as usize] == side {
                        count += 1.0;
                        for i in 0..D {
                            let k = node as usize * D + i;
                            sum[i] += predicted[k] - q_0[k];
                        }
                    }
                });
                (count > 0.0).then(|| sum.map(|sum| sum / count))
            };
            if let (Some(a), Some(b)) = (mean(SECONDARY), mean(PRIMARY)) {
                largest = largest.max((0..D).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt());
            }
        }
        largest
    }
}

impl<const D: usize> Equations<D> {
    /// Contacts whose sides, closer than a facet, slide so fast that steps of size `dt` would be halved.
    pub fn sliding_by_velocity(&self, q: &[f64], v: &[f64], dt: f64) -> Vec<LargeMotion> {
        let contacts = self.pairs.iter().filter(|pair| D == 2 && pair.corners.is_none() && !pair.kind.is_bilateral());
        let motion = |pair: &ContactPair| {
            let travel = if pair.kind == PairKind::Obstacle { travel_at_obstacle(pair, q, v, dt) } else { travel_along(pair, q, v, dt) };
            let facets = travel / pair.kernel.facet_size();
            (facets > tolerances::SLIDING).then(|| LargeMotion { contact: pair.name.clone(), kind: MotionKind::Sliding, facets })
        };
        contacts.filter_map(motion).collect()
    }
}

/// Largest sliding distance of a secondary facet in the plane along its nearest primary facet, if they face each other within a facet.
fn travel_along(pair: &ContactPair, q: &[f64], v: &[f64], dt: f64) -> f64 {
    let at = |x: &[f64], node: u32| [0, 1].map(|i| x[2 * node as usize + i]);
    let mean = |x: &[f64], [a, b]: [u32; 2]| std::array::from_fn(|i| 0.5 * (at(x, a)[i] + at(x, b)[i]));
    let apart = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
    let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
    let mut largest = 0.0f64;
    for &facet in pair.kernel.secondary().facets() {
        let from = |other: [u32; 2]| apart(mean(q, facet), mean(q, other));
        let distance = |other: [u32; 2]| dot(from(other), from(other));
        let nearest = pair.kernel.primary().facets().iter().copied().min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
        let Some(other) = nearest else { continue };
        let [own, along] = [facet, other].map(|[a, b]| apart(at(q, b), at(q, a)));
        let length = along[0].hypot(along[1]);
        let gap = dot(from(other), [along[1], -along[0]]) / length;
        if dot(own, along) < 0.0 && gap.abs() < pair.kernel.facet_size() {
            largest = largest.max(dt * dot(apart(mean(v, facet), mean(v, other)), along).abs() / length);
        }
    }
    largest
}

/// Largest tangential displacement of the nodes closer than a facet to an obstacle.
fn travel_at_obstacle(pair: &ContactPair, q: &[f64], v: &[f64], dt: f64) -> f64 {
    let moved: Vec<f64> = q.iter().zip(v).map(|(q, v)| q + dt * v).collect();
    let (coverage, weights) = (pair.kernel.coverage(q), pair.kernel.weights());
    let [before, after] = [q, &moved].map(|q| pair.kernel.gap(q));
    let nodes = pair.kernel.secondary().nodes().iter().enumerate();
    let near = nodes.filter(|&(row, _)| coverage[row] > tolerances::SLIVER && before[row].abs() < weights[row] * pair.kernel.facet_size());
    let travel = |(row, &node): (usize, &u32)| {
        let size = dt * v[2 * node as usize].hypot(v[2 * node as usize + 1]);
        let normal = (after[row] - before[row]) / weights[row];
        (size * size - normal * normal).max(0.0).sqrt()
    };
    near.map(travel).fold(0.0, f64::max)
}

/// Relative motion of the nodes of a pair and its rigid obstacle in a step to `q_1`, in facets, if too large: through the obstacle or, if
/// predicted, towards it.
fn passing(pair: &ContactPair, q_1: &[f64], is_predicted: bool) -> Option<f64> {
    let [direction_change, crossing] = pair.kernel.passage(q_1);
    let is_too_far = is_predicted && direction_change > tolerances::PASSING || crossing > 0.0;
    is_too_far.then_some(direction_change.max(crossing))
}

/// Largest depth, in secondary facets, of nodes of a pair behind the other side that were open at the start of the step.
fn through(pair: &ContactPair, conditions: &Conditions, gaps: &[f64], coverage: &[f64]) -> f64 {
    let (size, weights) = (pair.kernel.facet_size(), pair.kernel.weights());
    let open = (0..gaps.len()).filter(|&k| !conditions.members[pair.rows.start + k] && coverage[k] > tolerances::SLIVER);
    open.map(|k| -gaps[k] / (coverage[k] * weights[k] * size)).fold(0.0, f64::max)
}

/// Depth in secondary facets of the deepest node of a pair at `q_1`, or of facets that crossed each other, if it exceeds the depth at
/// `q_0`; otherwise 0.
fn sunk(pair: &ContactPair, q_0: &[f64], q_1: &[f64]) -> f64 {
    let depth = |q: &[f64]| (pair.kernel.deepest(q) / pair.kernel.facet_size()).max(pair.kernel.crossing(q));
    let now = depth(q_1);
    // Most steps end below `CAME_THROUGH`, and need no comparison with `q_0`.
    if now > tolerances::CAME_THROUGH && now > depth(q_0) + tolerances::SUNK_DEEPER { now } else { 0.0 }
}
