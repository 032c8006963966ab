//! The contact pairs of a model in the numbering of the system, and the conditions that a step puts on them.

use super::amplitude::Amplitude;
use super::model::{BodyBoundary, ContactMethod, Enforcement, Model, UpdateRule};
use super::system::{StepStart, System};
use crate::contact::{AveragedMortar, ContactKernel, Evaluation, Mortar, NodeToSegment, RigidContact, RigidCorners, Surface, Tie};
use crate::integrators::Integrator;
use crate::linear::Block;
use crate::math::norms::largest_size;
use crate::math::tolerances;

/// What a pair consists of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PairKind {
    /// Two surfaces, or one with itself.
    Surfaces,
    /// A surface and a rigid obstacle.
    Obstacle,
    /// Two surfaces that stay together: no contact at all.
    Tie,
}

/// What a pair adds to the contact of a pair before it: constraints of the corners that its weighted gaps do not see.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Corners {
    /// Index of the pair whose contact it is.
    pub(super) of: usize,
    /// Overlap that it leaves alone `[length]`: where surfaces lie flat on each other, the other constraints hold them, and these would
    /// depend on them.
    pub(super) slack: f64,
}

/// A contact pair with its place among the multipliers and in the matrix.
pub(super) struct Pair {
    pub(super) name: String,
    pub(super) kind: PairKind,
    pub(super) corners: Option<Corners>,
    /// Translation of the obstacle over time.
    pub(super) motion: [Option<Amplitude>; 2],
    /// Mean velocity of the obstacle in this step.
    pub(super) obstacle_velocity: [f64; 2],
    pub(super) kernel: Box<dyn ContactKernel>,
    pub(super) evaluation: Evaluation,
    pub(super) equality: bool,
    pub(super) update: UpdateRule,
    /// Stiffness `kappa` of a penalty potential; 0 with multipliers.
    pub(super) penalty: f64,
    /// Augmentation of the multipliers over the stiffness of a node; 0 without.
    pub(super) augmentation: f64,
    /// Range of its multipliers among all multipliers.
    pub(super) rows: std::ops::Range<usize>,
    /// Pressure per weighted gap, `youngs_modulus / h^2`: compares multipliers with gaps.
    pub(super) c: f64,
    /// Weighted gap that counts as closed for Newton's method.
    pub(super) gap_tolerance: f64,
    /// Per patch: blocks of node pairs (row by row), then per constraint row and node the blocks in the multiplier's row and column.
    pub(super) tangent_places: Vec<Block>,
    pub(super) row_places: Vec<Block>,
    pub(super) column_places: Vec<Block>,
}

impl Pair {
    /// Weighted gap at the start of a step that counts as closed.
    pub(super) fn closed(&self) -> f64 {
        (tolerances::CLOSED * self.kernel.facet_size().powi(2)).max(10.0 * self.gap_tolerance)
    }

    /// Whether open nodes may come through the other side within a step.
    fn may_penetrate(&self) -> bool {
        self.update == UpdateRule::Persistency && self.penalty == 0.0 && !self.equality
    }
}

/// What motion in a step is too large.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionKind {
    /// Surfaces in contact would slide beyond [`tolerances::SLIDING`].
    Sliding,
    /// Bodies would approach each other beyond [`tolerances::APPROACH`] under the persistency rule.
    Approach,
    /// They have done so in a converged step, beyond [`tolerances::CAME_THROUGH`].
    CameThrough,
}

impl MotionKind {
    /// Its stable name.
    pub fn name(self) -> &'static str {
        match self {
            MotionKind::Sliding => "sliding",
            MotionKind::Approach => "approach",
            MotionKind::CameThrough => "came_through",
        }
    }
}

/// A motion for which a step is halved although Newton's method did not fail.
#[derive(Clone, Debug, PartialEq)]
pub struct LargeMotion {
    /// Name of the contact.
    pub contact: String,
    /// What it is.
    pub kind: MotionKind,
    /// How far within the step, in secondary facets.
    pub facets: f64,
}

/// The contact conditions of a step: `Phi_A(q_1) >= target_A` for the members, with a multiplier that presses or is zero.
pub(super) struct Conditions {
    /// Weighted gaps at the start of the step.
    pub(super) gap_n: Vec<f64>,
    /// What the weighted gap of an active node is at the end of the step.
    pub(super) targets: Vec<f64>,
    /// Whether a node takes part in this step.
    pub(super) members: Vec<bool>,
    /// Weighted gap per change of the multiplier within an iteration, `1/kappa_A`: 0 but for augmented Lagrange.
    pub(super) compliance: Vec<f64>,
    /// Penalty pressures belong to the end of the step (statics, trapezoidal rule) instead of to its change of energy.
    pub(super) end_point: bool,
    /// By how much a penalty potential feels the weighted gaps larger than they are: an overlap that no motion has made, but that pairs
    /// find which take part in this step and took none in the one before, has no potential.
    pub(super) shift: Vec<f64>,
}

impl Conditions {
    /// Pressure of a pair's penalty potential at a constraint whose weighted gap is `gap`, and its derivative.
    pub(super) fn penalty_pressure(&self, pair: &Pair, row: usize, gap: f64) -> (f64, f64) {
        // From a start at zero the quotient is half the pressure of the end.
        if self.end_point {
            penalty_pressure(2.0 * pair.penalty, 0.0, gap)
        } else {
            penalty_pressure(pair.penalty, self.gap_n[row], gap + self.shift[row])
        }
    }
}

impl<const D: usize> System<D> {
    /// Inverse augmentation of every constraint row in a step.
    pub(super) fn compliance(&self, start: &StepStart) -> Vec<f64> {
        let mut compliance = vec![0.0; self.multipliers];
        for pair in self.pairs.iter().filter(|pair| pair.augmentation > 0.0) {
            for (local, row) in pair.rows.clone().enumerate() {
                let node = pair.kernel.row_nodes().get(local / pair.kernel.rows_per_node()).map(|&node| node as usize);
                let inertia = node.map_or(0.0, |node| {
                    let body = self.bodies.iter().position(|body| body.nodes.contains(&node)).expect("every node belongs to a body");
                    start.inertia(body) * self.nodal_mass[node] / pair.kernel.weights()[local].powi(2)
                });
                compliance[row] = 1.0 / (pair.augmentation * (pair.c + inertia));
            }
        }
        compliance
    }

    /// Weighted gaps of closed constraints: zero, but for corners.
    pub(super) fn closed_gaps(&self) -> Vec<f64> {
        let of = |pair: &Pair| -> Vec<f64> {
            let slack = pair.corners.map_or(0.0, |corners| corners.slack);
            pair.kernel.weights().iter().map(|weight| -slack * weight).collect()
        };
        self.pairs.iter().flat_map(of).collect()
    }

    /// The contact conditions of the step that has begun, by the pairs' update rules; `felt` are the weighted gaps that penalty potentials
    /// felt at the end of the step before.
    ///
    /// Whatever the rule, the target of a unilateral constraint is not above the gap at the start where that is an overlap: contact drives
    /// nothing apart, its work `lambda (target - Phi_n)` is never positive.
    pub(super) fn conditions(&self, start: &StepStart, felt: &[f64]) -> Conditions {
        let mut gap_n: Vec<f64> = self.pairs.iter().flat_map(|pair| pair.kernel.start_gap()).collect();
        let held = self.closed_gaps();
        let mut targets = vec![0.0; gap_n.len()];
        let mut members = vec![true; gap_n.len()];
        let mut shift = vec![0.0; gap_n.len()];
        let end_point = start.integrator == Integrator::Trapezoidal;
        for pair in &self.pairs {
            let closed = pair.closed();
            for row in pair.rows.clone() {
                let held = held[row];
                if pair.penalty > 0.0 {
                    if !end_point {
                        shift[row] = (felt[row].min(0.0) - gap_n[row].min(0.0)).max(0.0);
                        gap_n[row] += shift[row];
                    }
                } else if pair.update == UpdateRule::Persistency {
                    members[row] = pair.equality || gap_n[row] <= held + closed;
                    targets[row] = gap_n[row];
                } else if !pair.equality {
                    targets[row] = if gap_n[row] < held - closed { gap_n[row] } else { held };
                }
            }
        }
        Conditions { gap_n, targets, members, compliance: self.compliance(start), end_point, shift }
    }
}

impl<const D: usize> System<D> {
    /// The motion within a step, as predicted, that is too large to be tried whole: sliding of surfaces in contact beyond
    /// [`tolerances::SLIDING`], approach beyond [`tolerances::APPROACH`] under the persistency rule.
    pub(super) fn foreseen(&self, q_0: &[f64], predicted: &[f64], conditions: &Conditions, active: &[bool]) -> Option<LargeMotion> {
        for pair in self.pairs.iter().filter(|pair| pair.kind != PairKind::Tie) {
            let size = pair.kernel.facet_size();
            let facets = self.sliding(pair, q_0, predicted, active) / size;
            if facets > tolerances::SLIDING {
                return Some(LargeMotion { contact: pair.name.clone(), kind: MotionKind::Sliding, facets });
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

    /// How far open nodes have come through the other side in a converged step of the persistency rule, if too far: elastic motion is not
    /// foreseen.
    pub(super) fn came_through(&self, conditions: &Conditions) -> Option<LargeMotion> {
        self.pairs.iter().filter(|pair| pair.may_penetrate()).find_map(|pair| {
            let facets = through(pair, conditions, &pair.evaluation.gap, &pair.evaluation.coverage);
            (facets > tolerances::CAME_THROUGH).then(|| LargeMotion { contact: pair.name.clone(), kind: MotionKind::CameThrough, facets })
        })
    }

    /// Largest predicted motion of the nodes of an active patch's secondary side relative to those of its primary side `[length]`.
    fn sliding(&self, pair: &Pair, q_0: &[f64], predicted: &[f64], active: &[bool]) -> f64 {
        let patches = pair.kernel.patches();
        if !active[pair.rows.clone()].contains(&true) {
            return 0.0;
        }
        // On which sides a node of the model lies: to look it up for every patch would take longer than all the rest.
        const SECONDARY: u8 = 1;
        const PRIMARY: u8 = 2;
        let mut lies_on = vec![0u8; self.nodal_mass.len()];
        for (side, surface) in [(SECONDARY, pair.kernel.secondary()), (PRIMARY, pair.kernel.primary())] {
            surface.nodes().iter().for_each(|&node| lies_on[node as usize] |= side);
        }
        let mut largest = 0.0f64;
        for p in 0..patches.len() {
            if !patches.rows(p).iter().any(|&row| active[pair.rows.start + row as usize]) {
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

impl<const D: usize> System<D> {
    /// Contacts whose sides, where they are less than a facet apart, move along each other so fast that steps of that size would be halved.
    pub(super) fn sliding_by_velocity(&self, q: &[f64], v: &[f64], dt: f64) -> Vec<LargeMotion> {
        let contacts = self.pairs.iter().filter(|pair| D == 2 && pair.corners.is_none() && pair.kind != PairKind::Tie);
        let motion = |pair: &Pair| {
            let travel = if pair.kind == PairKind::Obstacle { travel_at_obstacle(pair, q, v, dt) } else { travel_along(pair, q, v, dt) };
            let facets = travel / pair.kernel.facet_size();
            (facets > tolerances::SLIDING).then(|| LargeMotion { contact: pair.name.clone(), kind: MotionKind::Sliding, facets })
        };
        contacts.filter_map(motion).collect()
    }
}

/// Largest motion of a secondary facet in the plane along the primary facet nearest to it, of those that face each other within a facet.
fn travel_along(pair: &Pair, q: &[f64], v: &[f64], dt: f64) -> f64 {
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

/// Largest motion of the nodes that are within a facet of an obstacle, without what changes their distance.
fn travel_at_obstacle(pair: &Pair, q: &[f64], v: &[f64], dt: f64) -> f64 {
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

/// Largest depth at which nodes of a pair that were open at the start of the step are behind the other side, in secondary facets.
fn through(pair: &Pair, conditions: &Conditions, gaps: &[f64], coverage: &[f64]) -> f64 {
    let (size, weights) = (pair.kernel.facet_size(), pair.kernel.weights());
    let open = (0..gaps.len()).filter(|&k| !conditions.members[pair.rows.start + k] && coverage[k] > tolerances::SLIVER);
    open.map(|k| -gaps[k] / (coverage[k] * weights[k] * size)).fold(0.0, f64::max)
}

/// Pressure of the penalty potential `kappa/2 min(Phi, 0)^2` over a step, `-(U_1 - U_0)/(Phi_1 - Phi_0)`, and its derivative with respect
/// to `Phi_1`.
fn penalty_pressure(kappa: f64, gap_n: f64, gap: f64) -> (f64, f64) {
    if gap_n <= 0.0 && gap <= 0.0 {
        (-0.5 * kappa * (gap_n + gap), -0.5 * kappa)
    } else if gap_n >= 0.0 && gap >= 0.0 {
        (0.0, 0.0)
    } else {
        // One end is open: the numerator is the other end's potential.
        let (step, closed) = (gap - gap_n, gap.min(0.0).powi(2) - gap_n.min(0.0).powi(2));
        (-0.5 * kappa * closed / step, -0.5 * kappa * (2.0 * gap.min(0.0) - closed / step) / step)
    }
}

/// Facets of a boundary in the plane, in node numbers of the model.
pub(super) fn boundary_facets(model: &Model, on: &BodyBoundary, first_node: usize) -> Vec<[u32; 2]> {
    let mesh = &model.bodies[on.body].mesh;
    let nodes = |facet| mesh.facet_nodes(facet).map(|node| node + first_node as u32).collect::<Vec<u32>>();
    on.boundary.facets.iter().map(|&facet| nodes(facet)).map(|nodes| [nodes[0], nodes[1]]).collect()
}

/// Distance within which a tie holds when none is given: half of the shortest secondary facet.
pub(super) fn tie_reach(secondary: &[[u32; 2]], reference: &[f64]) -> f64 {
    0.5 * Surface::new(secondary).shortest_facet(reference)
}

/// Facets of several boundaries, those in more than one of them once.
pub(super) fn facets_of_all(boundaries: &[BodyBoundary], facets: impl Fn(&BodyBoundary) -> Vec<[u32; 2]>) -> Vec<[u32; 2]> {
    let mut known = std::collections::BTreeSet::new();
    boundaries.iter().flat_map(facets).filter(|&facet| known.insert(facet)).collect()
}

/// All pairs of a model, `facets` a boundary's in the numbering of the model.
pub(super) fn contact_pairs(model: &Model, facets: impl Fn(&BodyBoundary) -> Vec<[u32; 2]>, reference: &[f64]) -> Vec<Pair> {
    let mut pairs: Vec<Pair> = Vec::new();
    let fresh = |name: &str, kind: PairKind, body: usize, kernel: Box<dyn ContactKernel>| {
        let size = kernel.facet_size();
        Pair {
            name: name.into(),
            kind,
            corners: None,
            motion: [None, None],
            obstacle_velocity: [0.0; 2],
            equality: kind == PairKind::Tie,
            update: UpdateRule::Gap,
            penalty: 0.0,
            augmentation: 0.0,
            rows: 0..kernel.rows(),
            c: model.bodies[body].material.youngs_modulus() / (size * size),
            gap_tolerance: (tolerances::GAP * size * size).max(tolerances::GAP_FLOOR * largest_size(reference) * size),
            kernel,
            evaluation: Evaluation::default(),
            tangent_places: Vec::new(),
            row_places: Vec::new(),
            column_places: Vec::new(),
        }
    };
    let between = |method: ContactMethod, secondary: &BodyBoundary, primary: &[BodyBoundary]| -> Box<dyn ContactKernel> {
        let (secondary, primary) = (facets(secondary), facets_of_all(primary, &facets));
        match method {
            ContactMethod::Mortar => Box::new(Mortar::new(&secondary, &primary, reference)),
            ContactMethod::DualMortar => Box::new(Mortar::new(&secondary, &primary, reference).with_dual_multipliers()),
            ContactMethod::AveragedMortar => Box::new(AveragedMortar::new(&secondary, &primary, reference)),
            ContactMethod::NodeToSegment => Box::new(NodeToSegment::new(&secondary, &primary, reference)),
        }
    };
    let rules = |mut pair: Pair, update: UpdateRule, enforcement: Enforcement, equality: bool| {
        (pair.update, pair.equality) = (update, equality);
        match enforcement {
            Enforcement::Multiplier => {}
            Enforcement::Penalty { factor } => pair.penalty = factor * pair.c,
            Enforcement::AugmentedLagrange { factor } => pair.augmentation = factor,
        }
        pair
    };
    for contact in &model.contacts {
        let kernel = between(contact.method, &contact.secondary, &contact.primary);
        let pair = fresh(&contact.name, PairKind::Surfaces, contact.secondary.body, kernel);
        pairs.push(rules(pair, contact.update, contact.enforcement, contact.equality));
    }
    for contact in &model.self_contacts {
        let kernel = between(contact.method, &contact.surface, std::slice::from_ref(&contact.surface));
        let pair = fresh(&contact.name, PairKind::Surfaces, contact.surface.body, kernel);
        pairs.push(rules(pair, contact.update, contact.enforcement, false));
    }
    for obstacle in &model.obstacles {
        let kernel = Box::new(RigidContact::new(&facets(&obstacle.secondary), &obstacle.obstacle, reference));
        let pair = Pair { motion: obstacle.motion.clone(), ..fresh(&obstacle.name, PairKind::Obstacle, obstacle.secondary.body, kernel) };
        pairs.push(rules(pair, obstacle.update, obstacle.enforcement, obstacle.equality));
    }
    for tie in &model.ties {
        let secondary = facets(&tie.secondary);
        let reach = tie.reach.unwrap_or_else(|| tie_reach(&secondary, reference));
        let kernel = Box::new(Tie::new(&secondary, &facets(&tie.primary), reference, reach));
        pairs.push(fresh(&tie.name, PairKind::Tie, tie.secondary.body, kernel));
    }
    let has_corners = |of: usize| !pairs[of].equality && pairs[of].penalty == 0.0;
    let size = |of: usize| pairs[of].kernel.facet_size();
    let mut corners: Vec<(usize, PairKind, usize, Box<dyn ContactKernel>)> = Vec::new();
    for (of, on, against) in cornered(model).into_iter().filter(|&(of, ..)| has_corners(of)) {
        let kernel = NodeToSegment::of_corners(&facets_of_all(on, &facets), &facets_of_all(against, &facets), reference, size(of));
        corners.extend(kernel.map(|kernel| (of, PairKind::Surfaces, on[0].body, Box::new(kernel) as Box<dyn ContactKernel>)));
    }
    let obstacles = model.obstacles.iter().zip(model.contacts.len() + model.self_contacts.len()..);
    for (obstacle, of) in obstacles.filter(|&(_, of)| has_corners(of)) {
        let kernel = RigidCorners::new(&facets(&obstacle.secondary), &obstacle.obstacle, reference, size(of));
        let body = obstacle.secondary.body;
        corners.extend(kernel.map(|kernel| (of, PairKind::Obstacle, body, Box::new(kernel) as Box<dyn ContactKernel>)));
    }
    for (of, kind, body, kernel) in corners {
        let owner = &pairs[of];
        let slack = tolerances::CORNER_SLACK * owner.kernel.facet_size();
        let (name, update, motion) = (owner.name.clone(), owner.update, owner.motion.clone());
        let augmentation = if owner.augmentation > 0.0 { owner.augmentation } else { tolerances::CORNER_AUGMENTATION };
        pairs.push(Pair { corners: Some(Corners { of, slack }), update, augmentation, motion, ..fresh(&name, kind, body, kernel) });
    }
    let mut first = 0;
    for pair in &mut pairs {
        pair.rows = first..first + pair.rows.end;
        first = pair.rows.end;
    }
    pairs
}

/// Sides of the contacts between deformable bodies whose corners may enter the other side, each with the index of its contact among the
/// pairs: all but those whose nodes have constraints of their own.
fn cornered(model: &Model) -> Vec<(usize, &[BodyBoundary], &[BodyBoundary])> {
    let mut sides = Vec::new();
    for (of, contact) in model.contacts.iter().enumerate() {
        let (secondary, primary) = (std::slice::from_ref(&contact.secondary), &contact.primary[..]);
        if contact.method != ContactMethod::NodeToSegment {
            sides.push((of, secondary, primary));
        }
        sides.push((of, primary, secondary));
    }
    for (of, contact) in model.self_contacts.iter().enumerate() {
        let surface = std::slice::from_ref(&contact.surface);
        if contact.method != ContactMethod::NodeToSegment {
            sides.push((model.contacts.len() + of, surface, surface));
        }
    }
    sides
}

#[cfg(test)]
mod tests {
    use super::penalty_pressure;

    #[test]
    fn penalty_pressure_does_the_work_of_its_potential_and_has_an_exact_derivative() {
        let energy = |gap: f64| 0.5 * 3.0 * gap.min(0.0).powi(2);
        for (gap_n, gap) in [(-0.3, -0.1), (-0.3, 0.2), (0.4, -0.1), (0.4, 0.2), (0.0, -0.2), (-0.2, 0.0)] {
            let (pressure, slope) = penalty_pressure(3.0, gap_n, gap);
            assert!((pressure * (gap - gap_n) + energy(gap) - energy(gap_n)).abs() < 1e-16);
            assert!(pressure >= 0.0);
            let h = 1e-6;
            let difference = (penalty_pressure(3.0, gap_n, gap + h).0 - penalty_pressure(3.0, gap_n, gap - h).0) / (2.0 * h);
            // At a kink (gap = 0) the two sides differ by order kappa h.
            assert!((difference - slope).abs() < 1e-5, "{gap_n} {gap}: {difference} {slope}");
        }
    }
}
