//! The contact pairs of a model in the numbering of the system, and the conditions that a step puts on them.

use super::amplitude::Amplitude;
use super::model::{BodyBoundary, ContactMethod, Enforcement, Model, UpdateRule};
use super::system::{StepStart, System};
use crate::contact::{AveragedMortar, ContactKernel, Evaluation, Mortar, NodeToSegment, RigidContact, Surface, Tie};
use crate::integrators::Integrator;
use crate::linear::Block;
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

/// A contact pair with its place among the multipliers and in the matrix.
pub(super) struct Pair {
    pub(super) name: String,
    pub(super) kind: PairKind,
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

/// Why a step was halved before it was tried.
#[derive(Clone, Debug, PartialEq)]
pub struct LargeMotion {
    /// Name of the contact.
    pub contact: String,
    /// Whether bodies approach each other under the persistency rule; otherwise they slide.
    pub approach: bool,
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
}

impl Conditions {
    /// Pressure of a pair's penalty potential at a constraint whose weighted gap is `gap`, and its derivative.
    pub(super) fn penalty_pressure(&self, pair: &Pair, row: usize, gap: f64) -> (f64, f64) {
        // From a start at zero the quotient is half the pressure of the end.
        if self.end_point { penalty_pressure(2.0 * pair.penalty, 0.0, gap) } else { penalty_pressure(pair.penalty, self.gap_n[row], gap) }
    }
}

impl<const D: usize> System<D> {
    /// Inverse augmentation of every constraint row in a step.
    pub(super) fn compliance(&self, start: &StepStart) -> Vec<f64> {
        let mut compliance = vec![0.0; self.multipliers];
        for pair in self.pairs.iter().filter(|pair| pair.augmentation > 0.0) {
            for (local, row) in pair.rows.clone().enumerate() {
                let node = pair.kernel.secondary().nodes()[local] as usize;
                let body = self.bodies.iter().position(|body| body.nodes.contains(&node)).expect("every node belongs to a body");
                let inertia = start.inertia(body) * self.nodal_mass[node] / pair.kernel.weights()[local].powi(2);
                compliance[row] = 1.0 / (pair.augmentation * (pair.c + inertia));
            }
        }
        compliance
    }

    /// The contact conditions of the step that has begun, by the pairs' update rules.
    pub(super) fn conditions(&self, start: &StepStart) -> Conditions {
        let gap_n: Vec<f64> = self.pairs.iter().flat_map(|pair| pair.kernel.start_gap()).collect();
        let mut targets = vec![0.0; gap_n.len()];
        let mut members = vec![true; gap_n.len()];
        for pair in self.pairs.iter().filter(|pair| pair.update == UpdateRule::Persistency && pair.penalty == 0.0) {
            let closed = tolerances::CLOSED * pair.kernel.facet_size().powi(2);
            for row in pair.rows.clone() {
                members[row] = pair.equality || gap_n[row] <= closed;
                targets[row] = gap_n[row];
            }
        }
        Conditions { gap_n, targets, members, compliance: self.compliance(start), end_point: start.integrator == Integrator::Trapezoidal }
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
                return Some(LargeMotion { contact: pair.name.clone(), approach: false, facets });
            }
            if pair.update == UpdateRule::Persistency && pair.penalty == 0.0 && !pair.equality {
                let (gaps, coverage, weights) = (pair.kernel.gap(predicted), pair.kernel.coverage(predicted), pair.kernel.weights());
                let open = (0..gaps.len()).filter(|&k| !conditions.members[pair.rows.start + k] && coverage[k] > tolerances::SLIVER);
                let facets = open.map(|k| -gaps[k] / (coverage[k] * weights[k] * size)).fold(0.0, f64::max);
                if facets > tolerances::APPROACH {
                    return Some(LargeMotion { contact: pair.name.clone(), approach: true, facets });
                }
            }
        }
        None
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
                for &node in patches.nodes(p).iter().filter(|&&node| lies_on[node as usize] == side) {
                    count += 1.0;
                    for i in 0..D {
                        let k = node as usize * D + i;
                        sum[i] += predicted[k] - q_0[k];
                    }
                }
                (count > 0.0).then(|| sum.map(|sum| sum / count))
            };
            if let (Some(a), Some(b)) = (mean(SECONDARY), mean(PRIMARY)) {
                largest = largest.max((0..D).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt());
            }
        }
        largest
    }
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
            motion: [None, None],
            obstacle_velocity: [0.0; 2],
            equality: kind == PairKind::Tie,
            update: UpdateRule::Gap,
            penalty: 0.0,
            augmentation: 0.0,
            rows: 0..kernel.rows_per_node() * kernel.secondary().nodes().len(),
            c: model.bodies[body].material.youngs_modulus() / (size * size),
            gap_tolerance: tolerances::GAP * size * size,
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
    let mut first = 0;
    for pair in &mut pairs {
        pair.rows = first..first + pair.rows.end;
        first = pair.rows.end;
    }
    pairs
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
