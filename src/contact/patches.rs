//! Contact elements (patches): nodes and constraints that each one couples, and the numbers of one evaluation in flat storage.
//!
//! Contact element `p` with `k` nodes and `m` constraints has `n = k * dimension` unknowns, node by node as in [`Patches::nodes`]. Its
//! gradient blocks are `m x n`, its tangent block `n x n`, row-major, at [`Patches::gradient_range`] and [`Patches::tangent_range`].
//!
//! An evaluation stores the blocks of all elements, or after [`Evaluation::begin_live`] only those of *live* elements, whose blocks are
//! nonzero. In space most candidates are not live, and the blocks of a pair of quadrilaterals take 6.1 kB.

use std::ops::Range;

/// Contact elements of a list of candidates, with any numbers of nodes and constraints.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Patches {
    dimension: usize,
    nodes: Vec<u32>,
    rows: Vec<u32>,
    starts: Vec<Starts>,
}

/// Offsets of a contact element's data in the flat arrays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Starts {
    nodes: usize,
    rows: usize,
    gradient: usize,
    tangent: usize,
}

impl Patches {
    /// Empty list.
    pub fn new(dimension: usize) -> Self {
        Patches { dimension, nodes: Vec::new(), rows: Vec::new(), starts: vec![Starts::default()] }
    }

    /// Removes all contact elements.
    pub fn clear(&mut self) {
        self.nodes.clear();
        self.rows.clear();
        self.starts.truncate(1);
    }

    /// Appends a contact element: model numbers of its nodes, and its constraints (indices of secondary nodes).
    pub fn push(&mut self, nodes: &[u32], rows: &[u32]) {
        let last = self.starts[self.starts.len() - 1];
        let unknowns = nodes.len() * self.dimension;
        self.nodes.extend_from_slice(nodes);
        self.rows.extend_from_slice(rows);
        self.starts.push(Starts {
            nodes: self.nodes.len(),
            rows: self.rows.len(),
            gradient: last.gradient + rows.len() * unknowns,
            tangent: last.tangent + unknowns * unknowns,
        });
    }

    /// Number of contact elements.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Bytes of the blocks of one evaluation.
    pub fn bytes(&self) -> u64 {
        let last = self.starts[self.starts.len() - 1];
        (size_of::<f64>() as u64).saturating_mul((2 * last.gradient + last.tangent) as u64)
    }

    /// Bytes of the gradient blocks of one evaluation.
    pub fn gradient_bytes(&self) -> u64 {
        (size_of::<f64>() as u64).saturating_mul(2 * self.starts[self.starts.len() - 1].gradient as u64)
    }

    /// True without contact elements.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Space dimension.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Positions of the nodes of contact element `p` at `q`, node by node, into `z`.
    pub(crate) fn gather_into(&self, p: usize, q: &[f64], z: &mut Vec<f64>) {
        let d = self.dimension;
        z.clear();
        z.extend(self.nodes(p).iter().flat_map(|&node| &q[d * node as usize..d * (node as usize + 1)]));
    }

    /// Model numbers of the nodes that contact element `p` couples, in the order of its blocks.
    pub fn nodes(&self, p: usize) -> &[u32] {
        &self.nodes[self.starts[p].nodes..self.starts[p + 1].nodes]
    }

    /// Constraints of contact element `p`, in the order of its blocks: indices of secondary nodes.
    pub fn rows(&self, p: usize) -> &[u32] {
        &self.rows[self.starts[p].rows..self.starts[p + 1].rows]
    }

    /// Number of unknowns of contact element `p`: nodes times dimension.
    pub fn unknowns(&self, p: usize) -> usize {
        self.nodes(p).len() * self.dimension
    }

    /// Range of the `m x n` blocks of contact element `p` in [`Evaluation::gradient_end`] and [`Evaluation::gradient_bar`].
    pub fn gradient_range(&self, p: usize) -> Range<usize> {
        self.starts[p].gradient..self.starts[p + 1].gradient
    }

    /// Range of the `n x n` block of contact element `p` in [`Evaluation::tangent`].
    pub fn tangent_range(&self, p: usize) -> Range<usize> {
        self.starts[p].tangent..self.starts[p + 1].tangent
    }
}

/// Numbers of one evaluation of a step. Each kernel keeps one evaluation and reuses its storage.
#[derive(Clone, Debug, Default)]
pub struct Evaluation {
    /// True for each live contact element, whose blocks are nonzero.
    pub live: Vec<bool>,
    /// `G_1 = grad Phi(q_1)` per contact element: the constraint rows of Newton's system.
    pub gradient_end: Vec<f64>,
    /// `Gbar` per contact element, the algorithmic gradient of the step; the contact force is `+ Gbar^T lambda`.
    pub gradient_bar: Vec<f64>,
    /// `d(sum_A lambda_A Gbar_A) / d q_1` per contact element; not symmetric for the energy-momentum scheme.
    pub tangent: Vec<f64>,
    /// `Phi_A(q_1)` per constraint.
    pub gap: Vec<f64>,
    /// Covered share at `q_1` per constraint, 0 to 1.
    pub coverage: Vec<f64>,
    /// Starts of the gradient and tangent blocks of each contact element; empty if the blocks of all elements are stored.
    places: Vec<[usize; 2]>,
}

/// Block start that marks a block without storage.
const NO_ROOM: usize = usize::MAX;

impl Evaluation {
    /// Allocates storage for the contact elements `patches` and the given number of constraints; sets gaps and coverage to zero. Blocks of
    /// unchanged size keep their values, so that a kernel clears only those that were nonzero.
    pub fn prepare(&mut self, patches: &Patches, constraints: usize) {
        let last = patches.starts[patches.len()];
        let had_room = std::mem::take(&mut self.places).is_empty();
        let lengths = [self.live.len(), self.gradient_end.len(), self.gradient_bar.len(), self.tangent.len()];
        if !had_room || lengths != [patches.len(), last.gradient, last.gradient, last.tangent] {
            self.live.clear();
            self.live.resize(patches.len(), false);
            for (blocks, length) in
                [(&mut self.gradient_end, last.gradient), (&mut self.gradient_bar, last.gradient), (&mut self.tangent, last.tangent)]
            {
                // Zeroed memory that is never written occupies no pages, and most candidates stay without values.
                *blocks = Vec::new();
                *blocks = vec![0.0; length];
            }
        }
        self.clear_sums(constraints);
    }

    /// Evaluation of a single normal constraint that is always present and exerts no force.
    pub(crate) fn prepare_without_force(&mut self, patches: &Patches) {
        self.prepare(patches, 1);
        self.coverage.fill(1.0);
        for p in 0..patches.len() {
            self.clear_patch(patches, p);
            self.live[p] = true;
        }
    }

    /// Begins an evaluation that stores the blocks of live contact elements only, which are added in ascending order by [`Self::open`];
    /// sets gaps and coverage to zero.
    pub(crate) fn begin_live(&mut self, patches: &Patches, constraints: usize) {
        self.live.clear();
        self.live.resize(patches.len(), false);
        self.places.clear();
        self.places.resize(patches.len(), [NO_ROOM; 2]);
        [&mut self.gradient_end, &mut self.gradient_bar, &mut self.tangent].into_iter().for_each(Vec::clear);
        self.clear_sums(constraints);
    }

    fn clear_sums(&mut self, constraints: usize) {
        for sums in [&mut self.gap, &mut self.coverage] {
            sums.clear();
            sums.resize(constraints, 0.0);
        }
    }

    /// Marks contact element `p` as live and allocates its blocks, filled with zeros, with or without a tangent.
    pub(crate) fn open(&mut self, patches: &Patches, p: usize, has_tangent: bool) -> ElementBlocks<'_> {
        let (gradient, square) = (patches.gradient_range(p).len(), if has_tangent { patches.tangent_range(p).len() } else { 0 });
        let (first, first_of_tangent) = (self.gradient_end.len(), self.tangent.len());
        self.live[p] = true;
        self.places[p] = [first, if has_tangent { first_of_tangent } else { NO_ROOM }];
        self.gradient_end.resize(first + gradient, 0.0);
        self.gradient_bar.resize(first + gradient, 0.0);
        self.tangent.resize(first_of_tangent + square, 0.0);
        ElementBlocks {
            gradient_end: &mut self.gradient_end[first..],
            gradient_bar: &mut self.gradient_bar[first..],
            tangent: &mut self.tangent[first_of_tangent..],
        }
    }

    /// Range of the `constraints x unknowns` blocks of contact element `p` in [`Self::gradient_end`] and [`Self::gradient_bar`]; empty if
    /// they are not stored.
    pub fn gradient_range(&self, patches: &Patches, p: usize) -> Range<usize> {
        placed(patches.gradient_range(p), self.places.get(p).map(|[first, _]| *first))
    }

    /// Range of the `unknowns x unknowns` block of contact element `p` in [`Self::tangent`]; empty if it is not stored.
    pub fn tangent_range(&self, patches: &Patches, p: usize) -> Range<usize> {
        placed(patches.tangent_range(p), self.places.get(p).map(|[_, first]| *first))
    }

    /// Passes the tangent blocks of live contact elements to a receiver in ascending order, then frees them by [`Self::drop_tangent`].
    pub fn hand_tangents_over(&mut self, patches: &Patches, receiver: &mut dyn FnMut(usize, &[f64])) {
        let ranges = (0..patches.len()).filter(|&p| self.live[p]).map(|p| (p, self.tangent_range(patches, p)));
        ranges.filter(|(_, range)| !range.is_empty()).for_each(|(p, range)| receiver(p, &self.tangent[range]));
        self.drop_tangent();
    }

    /// Frees the tangent blocks of an evaluation of live contact elements; storage for all elements is kept for reuse.
    pub fn drop_tangent(&mut self) {
        if !self.places.is_empty() {
            self.tangent = Vec::new();
            self.places.iter_mut().for_each(|[_, first]| *first = NO_ROOM);
        }
    }

    /// Replaces the share `share` of the algorithmic gradient by the gradient at the end of the step.
    pub fn shift_to_end(&mut self, share: f64) {
        if share != 0.0 {
            self.gradient_bar.iter_mut().zip(&self.gradient_end).for_each(|(bar, end)| *bar += share * (end - *bar));
        }
    }

    /// Zeroes the blocks of contact element `p` if it was live and the evaluation stores all elements.
    pub(crate) fn clear_patch(&mut self, patches: &Patches, p: usize) {
        if std::mem::replace(&mut self.live[p], false) {
            let gradient = patches.gradient_range(p);
            self.gradient_end[gradient.clone()].fill(0.0);
            self.gradient_bar[gradient].fill(0.0);
            self.tangent[patches.tangent_range(p)].fill(0.0);
        }
    }
}

/// Range of a block: `everywhere` if all contact elements are stored, otherwise it starts at `first`; empty for [`NO_ROOM`].
fn placed(everywhere: Range<usize>, first: Option<usize>) -> Range<usize> {
    match first {
        None => everywhere,
        Some(NO_ROOM) => 0..0,
        Some(first) => first..first + everywhere.len(),
    }
}

/// Blocks of one live contact element in an [`Evaluation`].
pub(crate) struct ElementBlocks<'a> {
    pub(crate) gradient_end: &'a mut [f64],
    pub(crate) gradient_bar: &'a mut [f64],
    pub(crate) tangent: &'a mut [f64],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_of_unequal_patches_follow_each_other() {
        let mut patches = Patches::new(2);
        patches.push(&[7, 8, 3, 2], &[0, 1]);
        patches.push(&[9, 3, 2], &[4]);
        assert_eq!((patches.len(), patches.nodes(1), patches.rows(1)), (2, &[9u32, 3, 2][..], &[4u32][..]));
        assert_eq!((patches.gradient_range(0), patches.gradient_range(1)), (0..16, 16..22));
        assert_eq!((patches.tangent_range(0), patches.tangent_range(1)), (0..64, 64..100));
        patches.clear();
        assert!(patches.is_empty());
    }

    #[test]
    fn a_cleared_patch_is_zero_and_others_are_kept() {
        let mut patches = Patches::new(2);
        patches.push(&[0, 1], &[0]);
        patches.push(&[1, 2], &[1]);
        let mut out = Evaluation::default();
        out.prepare(&patches, 2);
        out.live.fill(true);
        out.tangent.fill(1.0);
        out.prepare(&patches, 2);
        out.clear_patch(&patches, 0);
        assert_eq!((out.tangent[0], out.tangent[16], out.live[1]), (0.0, 1.0, true));
    }

    #[test]
    fn live_patches_alone_have_room() {
        let mut patches = Patches::new(2);
        patches.push(&[0, 1], &[0]);
        patches.push(&[1, 2, 3], &[1]);
        patches.push(&[2, 3], &[2]);
        let mut out = Evaluation::default();
        out.prepare(&patches, 3);
        out.begin_live(&patches, 3);
        out.open(&patches, 1, false).gradient_end[5] = 1.0;
        out.open(&patches, 2, true).tangent[15] = 2.0;
        assert_eq!((out.gradient_end.len(), out.gradient_bar.len(), out.tangent.len()), (10, 10, 16));
        assert_eq!(
            (out.gradient_range(&patches, 0), out.gradient_range(&patches, 1), out.gradient_range(&patches, 2)),
            (0..0, 0..6, 6..10)
        );
        assert_eq!((out.tangent_range(&patches, 1), out.tangent_range(&patches, 2)), (0..0, 0..16));
        out.drop_tangent();
        assert_eq!((out.tangent.capacity(), out.tangent_range(&patches, 2)), (0, 0..0));
        // `prepare` switches back to storage for all contact elements.
        out.prepare(&patches, 3);
        assert_eq!((out.live.contains(&true), out.gradient_range(&patches, 1), out.tangent.len()), (false, 4..10, 68));
        assert!(out.gradient_end.iter().all(|entry| *entry == 0.0));
    }
}
