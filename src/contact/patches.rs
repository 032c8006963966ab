//! Contact elements (patches): nodes and constraints that each one couples, and the numbers of one evaluation in flat storage.
//!
//! Contact element `p` with `k` nodes and `m` constraints has `n = k * dimension` unknowns, node by node as in [`Patches::nodes`]. Its
//! gradient blocks are `m x n`, its tangent block `n x n`, row-major, at [`Patches::gradient_range`] and [`Patches::tangent_range`].

use std::ops::Range;

/// Contact elements of a list of candidates, with any numbers of nodes and constraints.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Patches {
    dimension: usize,
    nodes: Vec<u32>,
    rows: Vec<u32>,
    starts: Vec<Starts>,
}

/// Offsets of an element's data in the flat arrays.
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

/// Numbers of one evaluation of a step. Each kernel has its own, whose storage is reused.
#[derive(Clone, Debug, Default)]
pub struct Evaluation {
    /// True for each contact element with nonzero blocks.
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
}

impl Evaluation {
    /// Sizes the storage for `patches` and `constraints`; sets gaps and coverage to zero. Blocks of unchanged size keep their numbers, so
    /// that a kernel clears only those that were nonzero.
    pub fn prepare(&mut self, patches: &Patches, constraints: usize) {
        let last = patches.starts[patches.len()];
        if self.live.len() != patches.len() || self.gradient_end.len() != last.gradient || self.tangent.len() != last.tangent {
            self.live.clear();
            self.live.resize(patches.len(), false);
            for (blocks, length) in
                [(&mut self.gradient_end, last.gradient), (&mut self.gradient_bar, last.gradient), (&mut self.tangent, last.tangent)]
            {
                // Zeroed memory that is never written takes no pages: most candidates have no numbers.
                *blocks = Vec::new();
                *blocks = vec![0.0; length];
            }
        }
        for sums in [&mut self.gap, &mut self.coverage] {
            sums.clear();
            sums.resize(constraints, 0.0);
        }
    }

    /// Sets the blocks of contact element `p` to zero.
    pub(crate) fn clear_patch(&mut self, patches: &Patches, p: usize) {
        Place {
            live: &mut self.live[p],
            gradient_end: &mut self.gradient_end[patches.gradient_range(p)],
            gradient_bar: &mut self.gradient_bar[patches.gradient_range(p)],
            tangent: &mut self.tangent[patches.tangent_range(p)],
        }
        .clear();
    }

    /// Blocks of all contact elements, in order.
    pub(crate) fn places<'a>(&'a mut self, patches: &'a Patches) -> impl Iterator<Item = Place<'a>> {
        let Evaluation { live, gradient_end, gradient_bar, tangent, .. } = self;
        let (mut ends, mut bars, mut tangents) = (&mut gradient_end[..], &mut gradient_bar[..], &mut tangent[..]);
        live.iter_mut().enumerate().map(move |(p, live)| {
            let (gradient, square) = (patches.gradient_range(p).len(), patches.tangent_range(p).len());
            Place {
                live,
                gradient_end: ends.split_off_mut(..gradient).unwrap_or_default(),
                gradient_bar: bars.split_off_mut(..gradient).unwrap_or_default(),
                tangent: tangents.split_off_mut(..square).unwrap_or_default(),
            }
        })
    }
}

/// Blocks of one contact element in an [`Evaluation`].
pub(crate) struct Place<'a> {
    pub(crate) live: &'a mut bool,
    pub(crate) gradient_end: &'a mut [f64],
    pub(crate) gradient_bar: &'a mut [f64],
    pub(crate) tangent: &'a mut [f64],
}

impl Place<'_> {
    /// Sets the blocks to zero.
    pub(crate) fn clear(&mut self) {
        if std::mem::replace(self.live, false) {
            [&mut *self.gradient_end, &mut *self.gradient_bar, &mut *self.tangent].into_iter().for_each(|block| block.fill(0.0));
        }
    }
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
}
