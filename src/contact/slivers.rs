//! Pairs of facets that take no part in a step because they may begin or cease to overlap in it, far apart, where nothing makes up for it.
//!
//! When a primary node passes a secondary one, the gradients of the pairs' functions jump by the gap there (`pair.rs`). Inside two surfaces
//! the pairs on both sides of the node take over from each other, and their sum has no jump. It has one where both surfaces end, as contact
//! sees it: the secondary one at a corner, beyond which its next facet looks elsewhere, the primary one at a node beyond which its next
//! facet takes no part. At a gap of nearly zero that does no harm. But between nearly perpendicular facets, such as the top of a block and
//! the side of another one beside it, the gap there may be half a facet, and a constraint that friction holds at just that place has no
//! solution then, at any size of the step: neither with the pair nor without it.
//!
//! So whether such a pair overlaps is decided at the start of the step: it takes part once its overlap is longer than what the step may
//! slide ([`SHORT`] of a facet at most). What is left out until then is narrower than it is high or deep. Where it is open, it is no
//! contact; where it is deep, the way out of the body is not along the normal of this facet but across it: the next facet beyond the
//! corner, or the corner's own constraint, holds it.

use super::surface::{Sides, Surface};
use super::window::Outlook;
use crate::math::tolerances::{FAR_SLIVER, SMOOTH};

/// Overlap in secondary facets from which on a pair is no sliver, however far the step may slide.
const SHORT: f64 = 0.25;

/// Takes those pairs out of those that are near each other in a step.
pub(super) fn leave_out(near: &mut [bool], pairs: &[[u32; 2]], sides: &Sides, outlook: &Outlook) {
    // At rest nothing slides by a known length, and bodies may be pressed into each other. In space the functions have no such jump.
    if outlook.depth > 0.0 || sides.secondary.dimension() == 3 {
        return;
    }
    let found = near.to_vec();
    let takes_part = |pair: [u32; 2]| pairs.binary_search(&pair).is_ok_and(|p| found[p]);
    for (near, &[own, other]) in near.iter_mut().zip(pairs).filter(|(near, _)| **near) {
        let beyond = sides.primary.neighbors(other as usize);
        let ends = |side: usize| !beyond[side].is_some_and(|beyond| takes_part([own, beyond]));
        *near = !(0..2).any(|side| ends(side) && is_far_sliver([own, other], side, sides, outlook));
    }
}

/// Whether a pair's overlap at one end of its secondary facet, which is a corner, is that short, and its primary node there far from it.
fn is_far_sliver([own, other]: [u32; 2], side: usize, sides: &Sides, outlook: &Outlook) -> bool {
    let at = |node: u32| [outlook.q[2 * node as usize], outlook.q[2 * node as usize + 1]];
    let (facet, face) = (sides.secondary.facets()[own as usize], sides.primary.facets()[other as usize]);
    let ([x_1, x_2], y) = (facet.map(at), at(face[side]));
    let (t, d) = ([x_2[0] - x_1[0], x_2[1] - x_1[1]], [y[0] - x_1[0], y[1] - x_1[1]]);
    let length = t[0].hypot(t[1]);
    let (s, gap) = ((t[0] * d[0] + t[1] * d[1]) / (length * length), (t[1] * d[0] - t[0] * d[1]) / length);
    let overlap = if side == 0 { s } else { 1.0 - s };
    gap.abs() > FAR_SLIVER * sides.facet_size
        && overlap <= (outlook.travel::<2>(&facet, &face) / length).min(SHORT)
        && is_corner(&sides.secondary, own, side, outlook.q)
}

/// Whether a surface turns sharply, or ends, at an end of a facet.
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

    /// Whether the lower facet of a side that leans over the right end of a top takes part in a step that slides by `travel`. Nodes 0 to 2
    /// belong to the top and what is before it, 3 to 5 to the side, from the top down.
    fn takes_part(start: [f64; 2], upper: [f64; 2], middle: [f64; 2], travel: f64) -> bool {
        let q = [start, [1.0, 0.0], [0.0, 0.0], upper, middle, [1.08, 0.0]].concat();
        let sides = Sides::new(&[[0, 1], [1, 2]], &[[3, 4], [4, 5]], &q);
        let mut search = PairSearch::new(&sides, &q, 1.0);
        search.update(&sides, &Outlook::within(&q, travel));
        let pair = search.candidates.pairs().binary_search(&[1, 1]).expect("it is in reach");
        search.near[pair]
    }

    #[test]
    fn what_may_begin_to_overlap_far_apart_takes_no_part() {
        let (corner, straight, apart, beside) = ([1.0, -1.0], [2.0, 0.0], [0.9, 2.0], [0.94, 0.7]);
        // The side's middle node is above the top's end, half a facet away, by 0.02 inside, just outside, or by more than a step slides.
        assert!(!takes_part(corner, apart, [0.98, 0.45], 0.05));
        assert!(!takes_part(corner, apart, [1.02, 0.45], 0.05));
        assert!(takes_part(corner, apart, [0.98, 0.45], 0.01));
        // Behind the top's line: beside its body, or a little in it.
        assert!(!takes_part(corner, apart, [0.98, -0.45], 0.05));
        // Near it; over a top that goes on; in a side of which the next facet takes part, too.
        assert!(takes_part(corner, apart, [0.98, 0.04], 0.05));
        assert!(takes_part(straight, apart, [0.98, 0.45], 0.05));
        assert!(takes_part(corner, beside, [0.98, 0.45], 0.05));
    }
}
