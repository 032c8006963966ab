//! Structure of the factors: elimination tree, fronts, and the positions of all entries of matrix and update matrices.
//!
//! Graph algorithms work on vertices, which are merged into fronts in [`super::tree`]. This module numbers the fronts and divides them into
//! tasks; [`super::places`] finds the positions of entries.

use std::ops::Range;

use super::fronts::{Front, Numbering};
use super::pattern::{Block, Pattern};
use super::places::Places;
use super::tiles::padded;
use super::tree::{NONE, Tree};
use super::waiting::{UpdateStack, surplus};
use crate::math::workers::Workers;

/// Number of operations above which several threads are used: tenths of a millisecond.
const WORTH_TASKS: f64 = 3e6;
/// Subtrees with more than `1/TASKS` of the total work are split further: enough tasks to balance a few threads.
const TASKS: f64 = 10.0;

/// Structure of the factors of a pattern for one order of elimination.
#[derive(Debug, Default)]
pub(super) struct Symbolic {
    /// Parent, in the elimination tree, of each position of the order of elimination; `u32::MAX` for roots.
    pub(super) parents: Vec<u32>,
    /// Unknown at each position of the order of elimination after the merging of fronts.
    pub(super) unknowns: Vec<u32>,
    pub(super) fronts: Vec<Front>,
    pub(super) children: Vec<u32>,
    pub(super) places: Places,
    /// Number of unknowns of each vertex.
    pub(super) sizes: Vec<u8>,
    /// Number of entries of all factors.
    pub(super) factors: usize,
    /// Independent subtrees, as ranges of fronts in ascending order, which are eliminated before the remaining fronts; empty for a small
    /// matrix.
    pub(super) tasks: Vec<Range<usize>>,
    /// Stack layouts of the update matrices: `alone` for one thread, `shared` for several tasks.
    pub(super) alone: UpdateStack,
    pub(super) shared: UpdateStack,
    /// Unknowns of the largest front.
    pub(super) largest: usize,
    /// Floating-point operations of a factorisation.
    pub(super) operations: f64,
}

impl Symbolic {
    /// Structure for vertices eliminated in the given order.
    pub(super) fn new(pattern: &Pattern, order: &[u32]) -> Self {
        let (tree, parents) = Tree::new(pattern, order);
        let mut symbolic =
            Symbolic { sizes: (0..pattern.vertices()).map(|v| pattern.size(v) as u8).collect(), parents, ..Symbolic::default() };
        let numbering = symbolic.number_fronts(pattern, order, &tree);
        symbolic.places = Places::find(pattern, order, &tree, &numbering, &mut symbolic.fronts, &symbolic.children);
        symbolic.find_tasks();
        symbolic.largest = symbolic.fronts.iter().map(|front| front.p + front.u).max().unwrap_or(0);
        symbolic.alone = UpdateStack::new(&symbolic.fronts, &symbolic.children, &[]);
        symbolic.shared = UpdateStack::new(&symbolic.fronts, &symbolic.children, &symbolic.tasks);
        symbolic
    }

    /// Finds the blocks of a pattern with other couplings; blocks of the structure that the pattern lacks are marked as zero.
    pub(super) fn find_blocks(&mut self, pattern: &Pattern) {
        let find = |row: u32, column: u32| pattern.find_block(row, column).unwrap_or(Block::NOWHERE);
        for entry in &mut self.places.inside {
            entry.source = find(entry.row, entry.column);
        }
        for entry in &mut self.places.beside {
            (entry.lower, entry.upper) = (find(entry.other, entry.pivot), find(entry.pivot, entry.other));
        }
    }

    /// Returns the stack layout of the update matrices and the number of threads.
    pub(super) fn waiting(&self, workers: &Workers) -> (&UpdateStack, usize) {
        if workers.are_many() && !self.tasks.is_empty() { (&self.shared, workers.count()) } else { (&self.alone, 1) }
    }

    /// Splits the tree into independent subtrees (tasks) of comparable work; the fronts above them remain.
    fn find_tasks(&mut self) {
        if self.operations < WORTH_TASKS {
            return;
        }
        let mut work: Vec<f64> = self.fronts.iter().map(Front::work).collect();
        // First front of the subtree of each front.
        let mut from: Vec<usize> = (0..self.fronts.len()).collect();
        for k in 0..self.fronts.len() {
            if let Some(parent) = self.fronts[k].parent {
                work[parent as usize] += work[k];
                from[parent as usize] = from[parent as usize].min(from[k]);
            }
        }
        let roots = |k: &usize| self.fronts[*k].parent.is_none();
        let mut open: Vec<usize> = (0..self.fronts.len()).filter(roots).collect();
        let whole: f64 = open.iter().map(|&k| work[k]).sum();
        let mut tasks = Vec::new();
        while let Some(k) = open.pop() {
            if work[k] > whole / TASKS {
                open.extend(self.children[self.fronts[k].children.clone()].iter().map(|&child| child as usize));
            } else if work[k] > whole / (4.0 * TASKS * TASKS) {
                tasks.push(from[k]..k + 1);
            }
        }
        tasks.sort_unstable_by_key(|task| task.start);
        self.tasks = tasks;
    }

    /// Orders fronts so that every subtree ends with its root. Returns the last vertex of each front and the first pivot of each vertex in
    /// the order of elimination.
    fn number_fronts(&mut self, pattern: &Pattern, order: &[u32], tree: &Tree) -> Numbering {
        let count = order.len();
        let mut numbering = Numbering { roots: Vec::new(), first: vec![0; count], sequence: Vec::with_capacity(count) };
        let mut number = vec![NONE; count];
        let mut children: Vec<u32> = Vec::new();
        let surplus = surplus(tree);
        let mut stack: Vec<(u32, bool)> = tree.roots.iter().rev().map(|&k| (k, false)).collect();
        while let Some((k, done)) = stack.pop() {
            if !done {
                stack.push((k, true));
                children.clear();
                children.extend(tree.kids(k));
                // Processing the child with the largest update first keeps the stack of updates small.
                children.sort_by_key(|&c| (surplus.as_ref().map_or(tree.update[c as usize] as usize, |surplus| surplus[c as usize]), c));
                stack.extend(children.iter().map(|&c| (c, false)));
                continue;
            }
            let front = self.fronts.len() as u32;
            number[k as usize] = front;
            numbering.roots.push(k);
            let first = self.unknowns.len();
            let mut pivot = tree.head[k as usize];
            while pivot != NONE {
                numbering.first[pivot as usize] = self.unknowns.len() as u32;
                numbering.sequence.push(pivot);
                let vertex = order[pivot as usize] as usize;
                let unknown = pattern.first_unknown(vertex) as u32;
                self.unknowns.extend(unknown..unknown + pattern.size(vertex) as u32);
                pivot = tree.next[pivot as usize];
            }
            let from = self.children.len();
            self.children.extend(tree.kids(k).map(|c| number[c as usize]));
            self.children[from..].sort_unstable();
            for &child in &self.children[from..] {
                self.fronts[child as usize].parent = Some(front);
            }
            let (pivots, update) = (self.unknowns.len() - first, tree.update[k as usize] as usize);
            let front = Front {
                first,
                pivots,
                update,
                p: padded(pivots),
                u: padded(update),
                factors: self.factors,
                children: from..self.children.len(),
                ..Front::default()
            };
            self.factors += front.length();
            self.operations += front.operations();
            self.fronts.push(front);
        }
        numbering
    }
}
