//! Which facet pairs can come near each other: a spatial tree over the primary facets' boxes, kept while it stays valid.
//!
//! A new list means a new matrix pattern and a new symbolic factorisation, so the list is made with a *spare* margin and kept until the
//! surfaces have moved too far relative to each other. The bound: the distance between the boxes of two facets changes by no more than the
//! largest difference between a secondary and a primary node's displacement, component by component. Where the bound fails, the pairs that
//! are needed now are searched for and compared with the list before it is made anew. The largest-component distance between boxes is meant
//! throughout. The result depends on the positions alone, not on the number of threads.
//!
//! Pairs that share a node (one surface touching itself) are left out. Pairs that look the same way are not: how far they may turn within
//! the step is not known here, and the pair functions tell them apart at the cost of a comparison.

use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use super::surface::Surface;

/// A list of facet pairs that contains every pair within a margin, valid for a bounded relative motion.
#[derive(Clone, Debug)]
pub struct Candidates {
    pairs: Vec<[u32; 2]>,
    spare: f64,
    margin: f64,
    secondary_at_search: Vec<[f64; 2]>,
    primary_at_search: Vec<[f64; 2]>,
}

/// The list is made anew when its margin exceeds what is needed, with the spare, by this factor: after one fast step it would stay long.
const EXCESSIVE: f64 = 4.0;

impl Candidates {
    /// An empty list that will be made with `spare` `[length]` beyond the margin that is needed.
    pub fn new(spare: f64) -> Self {
        Candidates { pairs: Vec::new(), spare, margin: f64::NEG_INFINITY, secondary_at_search: Vec::new(), primary_at_search: Vec::new() }
    }

    /// The pairs (secondary facet, primary facet), ascending.
    pub fn pairs(&self) -> &[[u32; 2]] {
        &self.pairs
    }

    /// Makes the list contain all pairs whose boxes lie within `margin` of each other at `q`; returns whether it changed.
    ///
    /// Positions or margins that are not finite leave the list as it is: such a step fails elsewhere.
    pub fn update(&mut self, secondary: &Surface, primary: &Surface, q: &[f64], margin: f64) -> bool {
        let (secondary_now, primary_now) = (positions(secondary, q), positions(primary, q));
        let finite = secondary_now.iter().chain(&primary_now).all(|x| x[0].is_finite() && x[1].is_finite());
        if !finite || !margin.is_finite() {
            return false;
        }
        let wanted = margin.max(0.0) + self.spare;
        if self.margin.is_finite() && self.margin <= EXCESSIVE * wanted {
            let motion = relative_motion(&self.secondary_at_search, &secondary_now, &self.primary_at_search, &primary_now);
            if motion + margin <= self.margin {
                return false;
            }
            let needed = near_pairs(secondary, primary, q, margin);
            if is_subset(&needed, &self.pairs) {
                return false;
            }
        }
        let pairs = near_pairs(secondary, primary, q, wanted);
        self.margin = wanted;
        self.secondary_at_search = secondary_now;
        self.primary_at_search = primary_now;
        let changed = pairs != self.pairs;
        self.pairs = pairs;
        changed
    }
}

/// Positions of a surface's nodes.
fn positions(surface: &Surface, q: &[f64]) -> Vec<[f64; 2]> {
    surface.nodes().iter().map(|&node| [q[2 * node as usize], q[2 * node as usize + 1]]).collect()
}

/// Largest component of `u_s - u_p` over all secondary and primary nodes, `u` the displacements since the search.
fn relative_motion(secondary_then: &[[f64; 2]], secondary_now: &[[f64; 2]], primary_then: &[[f64; 2]], primary_now: &[[f64; 2]]) -> f64 {
    let range = |then: &[[f64; 2]], now: &[[f64; 2]], axis: usize| {
        then.iter().zip(now).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high): (f64, f64), (a, b)| {
            let u = b[axis] - a[axis];
            (low.min(u), high.max(u))
        })
    };
    (0..2).fold(0.0, |largest: f64, axis| {
        let (secondary_low, secondary_high) = range(secondary_then, secondary_now, axis);
        let (primary_low, primary_high) = range(primary_then, primary_now, axis);
        largest.max(secondary_high - primary_low).max(primary_high - secondary_low)
    })
}

/// Lower and upper corner of a facet's box.
fn facet_box([a, b]: [u32; 2], q: &[f64]) -> ([f64; 2], [f64; 2]) {
    let (a, b) = (2 * a as usize, 2 * b as usize);
    ([q[a].min(q[b]), q[a + 1].min(q[b + 1])], [q[a].max(q[b]), q[a + 1].max(q[b + 1])])
}

/// All pairs without a common node whose boxes lie within `margin` of each other, ascending.
fn near_pairs(secondary: &Surface, primary: &Surface, q: &[f64], margin: f64) -> Vec<[u32; 2]> {
    let boxes = primary.facets().iter().zip(0u32..).map(|(&facet, number)| {
        let (low, high) = facet_box(facet, q);
        GeomWithData::new(Rectangle::from_corners(low, high), number)
    });
    let tree = RTree::bulk_load(boxes.collect());
    let mut pairs = Vec::new();
    for (&facet, number) in secondary.facets().iter().zip(0u32..) {
        let (low, high) = facet_box(facet, q);
        let grown = AABB::from_corners(low.map(|x| x - margin), high.map(|x| x + margin));
        for found in tree.locate_in_envelope_intersecting(grown) {
            let other = primary.facets()[found.data as usize];
            if !other.contains(&facet[0]) && !other.contains(&facet[1]) {
                pairs.push([number, found.data]);
            }
        }
    }
    pairs.sort_unstable();
    pairs
}

/// Whether every entry of `part` is in `whole`; both ascending.
fn is_subset(part: &[[u32; 2]], whole: &[[u32; 2]]) -> bool {
    let mut rest = whole.iter();
    part.iter().all(|pair| rest.any(|other| other == pair))
}
