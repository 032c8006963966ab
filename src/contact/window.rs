//! Selection of the facet pairs that take part in a step: pairs whose gap may close in the step somewhere on their overlap.
//!
//! An open pair would offset the overlap of another pair in the weighted gap of a node, and a pair of far sides of two thin bodies would
//! count as a deep overlap. A pair therefore takes part while, on its overlap,
//!
//! ```text
//! least gap <= h/2 + motion_bound      and      largest gap > -1/2 min(|t|, thickness of both bodies)
//! ```
//!
//! with the shortest secondary facet `h`, the relative motion bound `motion_bound` of the pair, and the length `|t|` of its secondary
//! facet; while its facets face each other ([`OPPOSITE`]), and while their boxes are within `h + 3/2 motion_bound` of each other, which
//! every search covers. The decision depends on the pair and on the start of the step only, not on the search distance or on fast nodes
//! elsewhere. `slivers.rs` then excludes pairs whose overlap may begin or end in the step beside a corner.
//!
//! In a search for equilibrium, bodies that overlap by many facets may be pressed apart. The overlap is then given
//! ([`PredictedMotion::depth`]) and replaces `|t|/2`: boxes may be farther apart by the same amount, and thickness is measured to twice
//! that depth, which keeps far sides excluded.

use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use super::faces;
use super::surface::{Sides, Surface};
use crate::math::tolerances::{FACING, OPPOSITE};

/// Opening beyond the motion bound, in shortest secondary facets, up to which a pair takes part.
const OPEN: f64 = 0.5;

/// Overlap up to which a pair takes part, as a fraction of the secondary facet or of the total thickness of both bodies.
const DEEP: f64 = 0.5;

/// Sliding by deformation in a step at rest, in secondary facets, up to which a pair takes part.
const SLIDING: f64 = 0.25;

/// Distance between boxes beyond the shortest secondary facet up to which a pair takes part, in units of the motion bound: normal approach
/// plus equal sliding.
const DIAGONAL: f64 = 1.5;

/// Predicted motion of a step, from which its search horizon follows.
#[derive(Clone, Copy, Debug)]
pub struct PredictedMotion<'a> {
    /// Positions at the start of the step `[length]`.
    pub q: &'a [f64],
    /// Motion bound of the nodes.
    pub motion_bound: MotionBound<'a>,
    /// Factor on the search distance; results do not depend on it.
    pub reach: f64,
    /// Overlap up to which pairs take part in a search for equilibrium, in which bodies are pressed apart; 0 in motion `[length]`.
    pub depth: f64,
}

/// Upper bound of the relative motion of two nodes within a step.
#[derive(Clone, Copy, Debug)]
pub enum MotionBound<'a> {
    /// Common bound for any two nodes `[length]`.
    UpTo(f64),
    /// Bound for each node in any direction.
    Each {
        /// Bound of each node `[length]`.
        sizes: &'a [f64],
        /// Additional relative motion of any two nodes, to be added to the bounds of both `[length]`.
        besides: f64,
        /// True if the search for equilibrium goes on: nodes keep their facets while they are opposite them.
        is_continued: bool,
    },
    /// Two predicted displacement fields; the bound is the larger of both relative motions times a safety factor.
    Guessed {
        /// Displacements `[length]`, component by component.
        displacements: [&'a [f64]; 2],
        /// Safety factor on the predicted motion.
        factor: f64,
    },
}

/// Predicted motion of other points than the nodes.
pub(super) struct MappedMotion<'a> {
    of_nodes: PredictedMotion<'a>,
    q: Vec<f64>,
    sizes: Vec<f64>,
    displacements: [Vec<f64>; 2],
}

impl MappedMotion<'_> {
    /// Predicted motion of the points.
    pub fn of_points(&self) -> PredictedMotion<'_> {
        let [a, b] = &self.displacements;
        let motion_bound = match self.of_nodes.motion_bound {
            MotionBound::UpTo(motion_bound) => MotionBound::UpTo(motion_bound),
            MotionBound::Each { besides, is_continued, .. } => MotionBound::Each { sizes: &self.sizes, besides, is_continued },
            MotionBound::Guessed { factor, .. } => MotionBound::Guessed { displacements: [a, b], factor },
        };
        PredictedMotion { q: &self.q, motion_bound, ..self.of_nodes }
    }
}

impl<'a> PredictedMotion<'a> {
    /// True if a search for equilibrium goes on.
    pub(super) fn is_continued(&self) -> bool {
        matches!(self.motion_bound, MotionBound::Each { is_continued: true, .. })
    }

    /// Step from `q` in which nodes move relative to each other by at most `motion_bound` `[length]`.
    pub fn within(q: &'a [f64], motion_bound: f64) -> Self {
        PredictedMotion { q, motion_bound: MotionBound::UpTo(motion_bound), reach: 1.0, depth: 0.0 }
    }

    /// Motion of points that are at `q` at the start of the step; `sizes` and `displacements` map motion bounds and displacements of the
    /// nodes to those of the points.
    pub(super) fn mapped(
        &self,
        q: Vec<f64>,
        sizes: impl Fn(&[f64]) -> Vec<f64>,
        displacements: impl Fn(&[f64]) -> Vec<f64>,
    ) -> MappedMotion<'a> {
        let mut mapped = MappedMotion { of_nodes: *self, q, sizes: Vec::new(), displacements: Default::default() };
        match self.motion_bound {
            MotionBound::UpTo(_) => {}
            MotionBound::Each { sizes: given, .. } => mapped.sizes = sizes(given),
            MotionBound::Guessed { displacements: given, .. } => mapped.displacements = given.map(displacements),
        }
        mapped
    }

    /// Predicted positions at the end of the step `[length]`, by the first displacement field; `None` without predicted fields.
    pub(super) fn end(&self) -> Option<Vec<f64>> {
        let MotionBound::Guessed { displacements: [first, _], .. } = self.motion_bound else { return None };
        Some(self.q.iter().zip(first).map(|(q, u)| q + u).collect())
    }

    /// Search distance for facet pairs `[length]`.
    pub(super) fn search_margin(&self, sides: &Sides) -> f64 {
        self.reach * self.margin(sides)
    }

    /// Search horizon: distance that contains all pairs that may take part `[length]`.
    pub(super) fn margin(&self, sides: &Sides) -> f64 {
        let motion_bound = match self.motion_bound {
            MotionBound::UpTo(motion_bound) => motion_bound,
            MotionBound::Each { sizes, besides, .. } => {
                largest(sizes, sides.secondary.nodes()) + largest(sizes, sides.primary.nodes()) + besides
            }
            MotionBound::Guessed { displacements, factor } => {
                let dimension = sides.secondary.dimension();
                let range = |u: &[f64], axis: usize, surface: &Surface| {
                    let moved = surface.nodes().iter().map(|&node| u[dimension * node as usize + axis]);
                    moved.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high): (f64, f64), u| (low.min(u), high.max(u)))
                };
                let largest = |u: &[f64]| {
                    let along = |axis: usize| {
                        let (own, other) = (range(u, axis, &sides.secondary), range(u, axis, &sides.primary));
                        (own.1 - other.0).max(other.1 - own.0).max(0.0)
                    };
                    (0..dimension).map(along).fold(0.0, f64::hypot)
                };
                factor * displacements.map(largest).into_iter().fold(0.0, f64::max)
            }
        };
        sides.facet_size + DIAGONAL * motion_bound + self.depth
    }

    /// Bound of the relative motion of nodes of two facets, or of a node and a facet, in `D` dimensions `[length]`.
    pub(super) fn motion_bound<const D: usize>(&self, own: &[u32], other: &[u32]) -> f64 {
        match self.motion_bound {
            MotionBound::UpTo(motion_bound) => motion_bound,
            MotionBound::Each { sizes, besides, .. } => largest(sizes, own) + largest(sizes, other) + besides,
            MotionBound::Guessed { displacements, factor } => {
                let mut largest = 0.0f64;
                for u in displacements {
                    for (&a, &b) in own.iter().flat_map(|a| other.iter().map(move |b| (a, b))) {
                        let (a, b) = (D * a as usize, D * b as usize);
                        largest = largest.max((0..D).map(|i| (u[a + i] - u[b + i]).powi(2)).sum());
                    }
                }
                factor * largest.sqrt()
            }
        }
    }
}

/// Largest of the values at the given nodes.
fn largest(sizes: &[f64], nodes: &[u32]) -> f64 {
    nodes.iter().fold(0.0, |largest, &node| largest.max(sizes[node as usize]))
}

/// Geometry of two surfaces by which participating pairs are selected.
#[derive(Clone, Debug)]
pub struct Window {
    /// Thickness of the body behind each facet of both sides in the reference positions, measured to far sides that belong to the contact
    /// `[length]`.
    thickness: [Vec<f64>; 2],
    /// Distance to which thickness has been measured on each side; larger values are infinite `[length]`.
    measured: [f64; 2],
    /// Reference positions `[length]`.
    reference: Vec<f64>,
    /// Sizes of the facets `[length]`.
    lengths: [Vec<f64>; 2],
    facet_size: f64,
    /// Overlap up to which pairs take part in this search for equilibrium; 0 in motion `[length]`.
    depth: f64,
}

/// Least and largest gap of a pair on its overlap, and the penetration from which it is excluded `[length]`.
#[derive(Clone, Copy, Debug)]
struct Gaps {
    least: f64,
    largest: f64,
    deep: f64,
}

impl Window {
    /// Window of two surfaces; facets and bodies are measured in the reference positions.
    pub fn new(sides: &Sides, reference: &[f64]) -> Self {
        let surfaces = [&sides.secondary, &sides.primary];
        let lengths = surfaces.map(|surface| (0..surface.count()).map(|facet| surface.facet_size(facet, reference)).collect::<Vec<f64>>());
        // In motion only bodies thinner than a facet length limit the admitted overlap, so that thickness is measured up to the largest
        // facet length.
        let measured = [0, 1].map(|side| lengths[side].iter().copied().fold(0.0, f64::max));
        let thickness = [0, 1].map(|side| thickness(surfaces[side], reference, measured[side]));
        Window { thickness, measured, reference: reference.to_vec(), lengths, facet_size: sides.facet_size, depth: 0.0 }
    }

    /// Prepares for a step whose pairs may overlap by `depth` at its start `[length]`.
    pub fn begin(&mut self, sides: &Sides, depth: f64) {
        self.depth = depth;
        let needed = depth / DEEP;
        for (side, surface) in [&sides.secondary, &sides.primary].into_iter().enumerate() {
            if self.measured[side] < needed {
                (self.thickness[side], self.measured[side]) = (thickness(surface, &self.reference, needed), needed);
            }
        }
    }

    /// Penetration from which pairs with the given facet length and total body thickness are excluded `[length]`.
    fn deep(&self, length: f64, thickness: f64) -> f64 {
        (DEEP * length.min(thickness)).max(self.depth.min(DEEP * thickness))
    }

    /// Overlap up to which nodes take part in this search for equilibrium; 0 in motion `[length]`.
    pub(super) fn depth(&self) -> f64 {
        self.depth
    }

    /// True if a pair (secondary facet, primary facet) takes part in a step.
    pub fn admits(&self, pair: [u32; 2], sides: &Sides, predicted_motion: &PredictedMotion) -> bool {
        let motion_bound = Self::motion_bound(pair, sides, predicted_motion);
        if !self.is_within(pair, sides, predicted_motion.q, self.facet_size + DIAGONAL * motion_bound + self.depth) {
            return false;
        }
        // At rest the motion bound does not contain the sliding by deformation. If a node passes another and the pair beyond is left out,
        // forces jump.
        let at_rest = matches!(predicted_motion.motion_bound, MotionBound::Each { .. });
        let sliding = motion_bound.max(SLIDING * self.lengths[0][pair[0] as usize]);
        let gaps = self.gaps(pair, sides, predicted_motion.q, motion_bound);
        let gaps = gaps.or_else(|| at_rest.then(|| self.gaps(pair, sides, predicted_motion.q, sliding)).flatten());
        gaps.is_some_and(|gaps| gaps.least <= OPEN * self.facet_size + motion_bound && gaps.largest > -gaps.deep)
    }

    /// Bound of the relative motion of a pair's nodes in a step `[length]`.
    fn motion_bound([own, other]: [u32; 2], sides: &Sides, predicted_motion: &PredictedMotion) -> f64 {
        let (own, other) = (sides.secondary.facet(own as usize), sides.primary.facet(other as usize));
        if sides.secondary.dimension() == 2 {
            predicted_motion.motion_bound::<2>(own, other)
        } else {
            predicted_motion.motion_bound::<3>(own, other)
        }
    }

    /// True if the least gap of a pair on its overlap at `q` is at most the shortest secondary facet. Unlike the distance of axis-aligned
    /// boxes, this is invariant under rotation of the model.
    pub(super) fn is_beside(&self, pair: [u32; 2], sides: &Sides, q: &[f64]) -> bool {
        self.gaps(pair, sides, q, 0.0).is_some_and(|gaps| gaps.least <= self.facet_size)
    }

    /// True if the boxes of a pair's facets are within `margin` of each other.
    fn is_within(&self, [own, other]: [u32; 2], sides: &Sides, q: &[f64], margin: f64) -> bool {
        let (own, other) = (sides.secondary.facet(own as usize), sides.primary.facet(other as usize));
        let dimension = sides.secondary.dimension();
        (0..dimension).all(|axis| {
            let range = |nodes: &[u32]| {
                let along = nodes.iter().map(|&node| q[dimension * node as usize + axis]);
                along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high): (f64, f64), x| (low.min(x), high.max(x)))
            };
            let (own, other) = (range(own), range(other));
            own.0 - other.1 <= margin && other.0 - own.1 <= margin
        })
    }

    /// Distance that contains all pairs that overlap at `q` and are not excluded as too deep `[length]`.
    pub fn deepest(&self, sides: &Sides, q: &[f64]) -> f64 {
        let now = (0..sides.secondary.count()).map(|facet| sides.secondary.facet_size(facet, q));
        self.depth.max(DEEP * self.lengths.iter().flatten().copied().chain(now).fold(0.0, f64::max))
    }

    /// True if a pair that was open at `q_0` and was excluded from the step overlaps at its end `q_1`.
    pub fn is_overlooked(&self, pair: [u32; 2], sides: &Sides, q_0: &[f64], q_1: &[f64], tolerance: f64) -> bool {
        let closed = |gaps: Gaps| gaps.least < -tolerance && gaps.largest > -gaps.deep;
        if !self.gaps(pair, sides, q_1, 0.0).is_some_and(closed) {
            return false;
        }
        let moved: Vec<f64> = q_1.iter().zip(q_0).map(|(a, b)| a - b).collect();
        let predicted_motion = PredictedMotion {
            q: q_0,
            motion_bound: MotionBound::Guessed { displacements: [&moved; 2], factor: 1.0 },
            reach: 1.0,
            depth: 0.0,
        };
        let motion_bound = Self::motion_bound(pair, sides, &predicted_motion);
        self.gaps(pair, sides, q_0, motion_bound).is_some_and(|gaps| gaps.least > 0.0)
    }

    /// True if a node of `side` (0: secondary) is not too deep behind facet `other` of the other side, given its adjacent facets
    /// `own_facets` and its gap `gap` to that facet.
    pub fn admits_depth(&self, side: usize, own_facets: &[u32], other: u32, gap: f64) -> bool {
        let (thickness, lengths, other) = (&self.thickness[side], &self.lengths[side], other as usize);
        let own = own_facets.iter().map(|&facet| thickness[facet as usize]).fold(f64::INFINITY, f64::min);
        let length = own_facets.iter().map(|&facet| lengths[facet as usize]).fold(self.lengths[1 - side][other], f64::max);
        gap > -self.deep(length, own + self.thickness[1 - side][other])
    }

    /// Gaps of a pair on its overlap, widened by a sliding distance `spare`; `None` without overlap.
    fn gaps(&self, [own, other]: [u32; 2], sides: &Sides, q: &[f64], spare: f64) -> Option<Gaps> {
        if sides.secondary.dimension() == 3 {
            let [least, largest] = faces::gaps(sides.secondary.facet(own as usize), sides.primary.facet(other as usize), q, spare)?;
            let thickness = self.thickness[0][own as usize] + self.thickness[1][other as usize];
            let deep = self.deep(sides.secondary.facet_size(own as usize, q), thickness);
            return Some(Gaps { least, largest, deep });
        }
        let at = |node: u32| [q[2 * node as usize], q[2 * node as usize + 1]];
        let minus = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let ([x_1, x_2], [y_1, y_2]) = (sides.secondary.facets()[own as usize].map(at), sides.primary.facets()[other as usize].map(at));
        let (t, u) = (minus(x_2, x_1), minus(y_2, y_1));
        let (square, length) = (dot(t, t), t[0].hypot(t[1]));
        if dot(t, u) > OPPOSITE * length * u[0].hypot(u[1]) {
            return None;
        }
        let seen = |y: [f64; 2]| {
            let d = minus(y, x_1);
            (dot(t, d) / square, (t[1] * d[0] - t[0] * d[1]) / length)
        };
        let ((s_1, g_1), (s_2, g_2)) = (seen(y_1), seen(y_2));
        let spare = spare / length;
        let (a, b) = (s_2.max(-spare), s_1.min(1.0 + spare));
        if s_1 - s_2 <= FACING || a > b {
            return None;
        }
        let gap = |s: f64| g_2 + (g_1 - g_2) * (s - s_2) / (s_1 - s_2);
        let (at_a, at_b) = (gap(a), gap(b));
        let deep = self.deep(length, self.thickness[0][own as usize] + self.thickness[1][other as usize]);
        Some(Gaps { least: at_a.min(at_b), largest: at_a.max(at_b), deep })
    }
}

/// Distance from the middle of each facet along the inward normal to the next facet with the opposite orientation; infinite from `reach`
/// on.
fn thickness(surface: &Surface, reference: &[f64], reach: f64) -> Vec<f64> {
    if surface.dimension() == 3 {
        return faces::thickness((0..surface.count()).map(|facet| surface.facet(facet)), reference, reach);
    }
    let at = |node: u32| [reference[2 * node as usize], reference[2 * node as usize + 1]];
    let facets: Vec<[[f64; 2]; 2]> = surface.facets().iter().map(|facet| facet.map(at)).collect();
    let boxes = facets.iter().map(|&[c, d]| GeomWithData::new(Rectangle::from_corners(c, d), [c, d]));
    let tree = RTree::bulk_load(boxes.collect());
    let through = |[a, b]: &[[f64; 2]; 2]| {
        let (middle, t) = ([0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])], [b[0] - a[0], b[1] - a[1]]);
        let length = t[0].hypot(t[1]);
        let inward = [-t[1] / length, t[0] / length];
        let end = [middle[0] + reach * inward[0], middle[1] + reach * inward[1]];
        let distance = |[c, d]: [[f64; 2]; 2]| -> Option<f64> {
            // middle + r inward = c + k (d - c); the ray leaves a body where the outward normal (u_y, -u_x) has a component along it.
            let (u, from) = ([d[0] - c[0], d[1] - c[1]], [c[0] - middle[0], c[1] - middle[1]]);
            let cross = inward[0] * u[1] - inward[1] * u[0];
            if cross <= FACING * u[0].hypot(u[1]) {
                return None;
            }
            let r = (from[0] * u[1] - from[1] * u[0]) / cross;
            let k = (from[0] * inward[1] - from[1] * inward[0]) / cross;
            (r > FACING * length && (-FACING..=1.0 + FACING).contains(&k)).then_some(r)
        };
        let found = tree.locate_in_envelope_intersecting(AABB::from_corners(middle, end)).filter_map(|facet| distance(facet.data));
        found.fold(f64::INFINITY, f64::min)
    };
    facets.iter().map(through).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Plate with two facets on each face, its lower left corner at `(x, y)`, nodes counter-clockwise from the lower left.
    fn plate(first: u32, x: f64, y: f64, thick: f64) -> (Vec<[u32; 2]>, Vec<f64>) {
        let facets = vec![[first, first + 1], [first + 1, first + 2], [first + 3, first + 4], [first + 4, first + 5]];
        let q = vec![x, y, x + 1.0, y, x + 2.0, y, x + 2.0, y + thick, x + 1.0, y + thick, x, y + thick];
        (facets, q)
    }

    fn sides(distance: f64) -> (Sides, Vec<f64>) {
        let (upper, mut q) = plate(0, 0.0, distance, 0.1);
        let (lower, below) = plate(6, 0.3, -0.2, 0.2);
        q.extend(below);
        (Sides::new(&upper, &lower, &q), q)
    }

    #[test]
    fn thickness_is_measured_to_the_far_side() {
        let (sides, q) = sides(0.05);
        let window = Window::new(&sides, &q);
        assert!(window.thickness[0].iter().all(|t| (t - 0.1).abs() < 1e-15));
        assert!(window.thickness[1].iter().all(|t| (t - 0.2).abs() < 1e-15));
        let (top, _) = plate(0, 0.0, 0.0, 0.1);
        let only = Sides::new(&top[2..], &[], &q);
        assert!(Window::new(&only, &q).thickness[0].iter().all(|t| t.is_infinite()), "the far side is not in the contact");
    }

    /// Facing pairs take part within the opening of the window; pairs of far sides never do.
    #[test]
    fn faces_that_look_through_the_bodies_take_no_part() {
        for (distance, motion_bound, meet) in
            [(0.05, 0.0, true), (-0.02, 0.0, true), (0.49, 0.0, true), (0.51, 0.0, false), (0.9, 0.41, true)]
        {
            let (sides, q) = sides(distance);
            let window = Window::new(&sides, &q);
            let predicted_motion = PredictedMotion::within(&q, motion_bound);
            for own in 0..4 {
                for other in 0..4 {
                    let opposite = own < 2 && other >= 2;
                    let overlap = match (own, other) {
                        // Upper facets [0, 1] and [1, 2]; lower ones [1.3, 2.3] and [0.3, 1.3] along x.
                        (0, 2) => motion_bound > 0.3,
                        _ => true,
                    };
                    let expected = opposite && overlap && meet;
                    assert_eq!(window.admits([own, other], &sides, &predicted_motion), expected, "{own} {other} at {distance}");
                }
            }
        }
    }

    #[test]
    fn the_motion_of_other_nodes_does_not_matter() {
        let (sides, q) = sides(0.6);
        let window = Window::new(&sides, &q);
        let mut u = vec![0.0; q.len()];
        // All nodes move down together except the left end of the upper plate.
        u.chunks_exact_mut(2).for_each(|u| u[1] = -5.0);
        let together = [&u[..]; 2];
        let predicted_motion =
            PredictedMotion { q: &q, motion_bound: MotionBound::Guessed { displacements: together, factor: 1.0 }, reach: 1.0, depth: 0.0 };
        assert!(!window.admits([1, 3], &sides, &predicted_motion));
        let mut v = u.clone();
        v[1] = -5.2;
        let predicted_motion =
            PredictedMotion { motion_bound: MotionBound::Guessed { displacements: [&u, &v], factor: 1.0 }, ..predicted_motion };
        assert!(!window.admits([1, 3], &sides, &predicted_motion), "its nodes approach nothing");
        assert!(window.admits([0, 3], &sides, &predicted_motion));
    }

    #[test]
    fn a_pair_that_has_closed_unseen_is_overlooked() {
        let (sides, q_0) = sides(0.6);
        let window = Window::new(&sides, &q_0);
        let lowered =
            |by: f64| -> Vec<f64> { q_0.iter().enumerate().map(|(k, q)| if k < 12 && k % 2 == 1 { q - by } else { *q }).collect() };
        assert!(window.is_overlooked([0, 3], &sides, &q_0, &lowered(0.65), 1e-12));
        assert!(!window.is_overlooked([0, 3], &sides, &q_0, &lowered(0.55), 1e-12), "still open");
        assert!(!window.is_overlooked([2, 1], &sides, &q_0, &lowered(0.65), 1e-12), "looks through both plates");
    }

    /// In a search for equilibrium pairs take part up to the given depth, but never the far sides of thin bodies: the plates are 0.1 and
    /// 0.2 thick.
    #[test]
    fn at_rest_pairs_take_part_as_deep_as_is_told() {
        for (distance, depth, meet) in [(-0.14, 0.0, true), (-0.16, 0.0, false), (-0.14, 0.2, true), (-0.16, 0.2, false)] {
            let (sides, q) = sides(distance);
            let mut window = Window::new(&sides, &q);
            let predicted_motion = PredictedMotion { depth, ..PredictedMotion::within(&q, 0.0) };
            window.begin(&sides, depth);
            assert_eq!(window.admits([0, 3], &sides, &predicted_motion), meet, "{distance} {depth}");
            assert!(!meet || !window.admits([2, 0], &sides, &predicted_motion), "far sides: {distance} {depth}");
        }
        // Only the near faces overlap, by three facets.
        let (upper, mut q) = plate(0, 0.0, -3.0, 4.0);
        let (lower, below) = plate(6, 0.3, -4.0, 4.0);
        q.extend(below);
        let sides = Sides::new(&upper[..2], &lower[2..], &q);
        let mut window = Window::new(&sides, &q);
        for (depth, meet) in [(0.0, false), (2.9, false), (3.1, true)] {
            window.begin(&sides, depth);
            assert_eq!(window.admits([0, 1], &sides, &PredictedMotion { depth, ..PredictedMotion::within(&q, 0.0) }), meet, "{depth}");
        }
    }
}
