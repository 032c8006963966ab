//! Exclusion of facet pairs in the plane whose overlap may begin or end in a step at a large gap without a neighboring pair that
//! compensates.
//!
//! If a primary node passes a secondary one, the gradients of the pair functions jump by the gap there (`pair.rs`). Inside two surfaces the
//! pairs on both sides of the node compensate each other, and their sum is continuous. The sum jumps where both surfaces end: the secondary
//! one at a corner, the primary one at a node whose next facet takes no part. At a small gap the jump is harmless. Between nearly
//! perpendicular facets, such as the top of a block and the side of another block, the gap may be half a facet; a constraint that friction
//! holds at that point then has no solution for any step size, with or without the pair.
//!
//! Participation of such a pair is therefore decided at the start of the step: it takes part if its overlap exceeds the possible sliding
//! ([`SHORT`] of a facet at most). The overlap of an excluded pair is narrower than its gap. If open, the pair is not in contact. If
//! penetrated, the shortest way out is not along the facet's normal, but across it: the next facet beyond the corner, or the corner's own
//! constraint, resolves the penetration.

use super::surface::{Sides, Surface};
use super::window::PredictedMotion;
use crate::math::tolerances::{FAR_SLIVER, SMOOTH};

/// Overlap, as a fraction of the secondary facet, from which a pair always takes part.
const SHORT: f64 = 0.25;

/// Excludes short overlaps at large gaps from the pairs that take part in a step.
pub(super) fn leave_out(near: &mut [bool], pairs: &[[u32; 2]], sides: &Sides, predicted_motion: &PredictedMotion) {
    // In a search for equilibrium the sliding distance has no bound, and bodies may overlap at the start. Pair functions in space have no
    // such jump.
    if predicted_motion.depth > 0.0 || sides.secondary.dimension() == 3 {
        return;
    }
    let found = near.to_vec();
    let takes_part = |pair: [u32; 2]| pairs.binary_search(&pair).is_ok_and(|p| found[p]);
    for (near, &[own, other]) in near.iter_mut().zip(pairs).filter(|(near, _)| **near) {
        let beyond = sides.primary.neighbors(other as usize);
        let ends = |side: usize| !beyond[side].is_some_and(|beyond| takes_part([own, beyond]));
        *near = !(0..2).any(|side| ends(side) && is_far_sliver([own, other], side, sides, predicted_motion));
    }
}

/// True if the pair's overlap is short at the corner `side` of its secondary facet, and its primary node there has a large gap.
fn is_far_sliver([own, other]: [u32; 2], side: usize, sides: &Sides, predicted_motion: &PredictedMotion) -> bool {
    let at = |node: u32| [predicted_motion.q[2 * node as usize], predicted_motion.q[2 * node as usize + 1]];
    let (facet, face) = (sides.secondary.facets()[own as usize], sides.primary.facets()[other as usize]);
    let ([x_1, x_2], y) = (facet.map(at), at(face[side]));
    let (t, d) = ([x_2[0] - x_1[0], x_2[1] - x_1[1]], [y[0] - x_1[0], y[1] - x_1[1]]);
    let length = t[0].hypot(t[1]);
    let (s, gap) = ((t[0] * d[0] + t[1] * d[1]) / (length * length), (t[1] * d[0] - t[0] * d[1]) / length);
    let overlap = if side == 0 { s } else { 1.0 - s };
    gap.abs() > FAR_SLIVER * sides.facet_size
        && overlap <= (predicted_motion.motion_bound::<2>(&facet, &face) / length).min(SHORT)
        && is_corner(&sides.secondary, own, side, predicted_motion.q)
}

/// True if a surface ends or bends sharply at an end of a facet.
fn is_corner(surface: &Surface, facet: u32, side: usize, q: &[f64]) -> bool {
    let along = |facet: u32| {
        let [a, b] = surface.facets()[facet as usize].map(|node| 2 * node as usize);
        [q[b] - q[a], q[b + 1] - q[a + 1]]
    };
    let Some(next) = surface.neighbors(facet as usize)[side] else { return true };
    let (t, u) = (along(facet), along(next));
    t[0] * u[0] + t[1] * u[1] < SMOOTH * t[0].hypot(t[1]) * u[0].hypot(u[1])
}

#[cfg(test)]
mod tests {
    use super::super::search::PairSearch;
    use super::*;

    /// True if the lower of two facets that overhang the right end of a horizontal surface takes part in a step with the given bound of the
    /// sliding distance. Nodes 0 to 2: facet before the surface and the surface; nodes 3 to 5: overhanging side, from the top down.
    fn takes_part(start: [f64; 2], upper: [f64; 2], middle: [f64; 2], motion_bound: f64) -> bool {
        let q = [start, [1.0, 0.0], [0.0, 0.0], upper, middle, [1.08, 0.0]].concat();
        let sides = Sides::new(&[[0, 1], [1, 2]], &[[3, 4], [4, 5]], &q);
        let mut search = PairSearch::new(&sides, &q, 1.0);
        search.update(&sides, &PredictedMotion::within(&q, motion_bound));
        let pair = search.candidates.pairs().binary_search(&[1, 1]).expect("it is in reach");
        search.near[pair]
    }

    #[test]
    fn what_may_begin_to_overlap_far_apart_takes_no_part() {
        let (corner, straight, apart, beside) = ([1.0, -1.0], [2.0, 0.0], [0.9, 2.0], [0.94, 0.7]);
        // Middle node of the overhanging side half a facet above the end of the surface: overlap 0.02, no overlap, and overlap larger than
        // the sliding distance.
        assert!(!takes_part(corner, apart, [0.98, 0.45], 0.05));
        assert!(!takes_part(corner, apart, [1.02, 0.45], 0.05));
        assert!(takes_part(corner, apart, [0.98, 0.45], 0.01));
        // Middle node below the line of the surface: beside the body, or slightly inside.
        assert!(!takes_part(corner, apart, [0.98, -0.45], 0.05));
        // At a small gap, above a surface that continues, and on a side whose adjacent facet takes part, too.
        assert!(takes_part(corner, apart, [0.98, 0.04], 0.05));
        assert!(takes_part(straight, apart, [0.98, 0.45], 0.05));
        assert!(takes_part(corner, beside, [0.98, 0.45], 0.05));
    }
}
