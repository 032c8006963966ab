//! Structure of the factors: elimination tree, fronts, and where every entry of the matrix and of every update goes.
//!
//! A *front* is a dense matrix of a few pivots and of the unknowns that their elimination couples. Its remainder after elimination, the
//! *update*, is added to the front of its parent in the tree (multifrontal method: Duff and Reid 1983, Liu 1992). All graph work is done on
//! vertices. Vertices are merged into one front where that costs next to no zeros or where the fronts would be too small to be worth a
//! call.

use std::ops::Range;

use super::dense::padded;
use super::pattern::{Block, Pattern};

/// Two fronts of fewer pivots than this are merged unless most of the result were zeros (measured: 1 costs a fifth, 24 a seventh).
const SMALL: u32 = 8;
/// Zeros that a merger of small fronts may bring, as a share of the front.
const SMALL_ZEROS: f64 = 0.6;
/// Zeros that any merger may bring.
const ZEROS: f64 = 0.05;

/// Operations from which on a matrix is worth more than one thread: some tenths of a millisecond.
const WORTH_TASKS: f64 = 3e6;
/// Subtrees with more work than the whole divided by this are split: enough parts for a few threads to end at about the same time.
const TASKS: f64 = 10.0;

const NONE: u32 = u32::MAX;

/// A front. Ranges are into the lists of [`Symbolic`].
#[derive(Clone, Debug, Default)]
pub(super) struct Front {
    /// First pivot in the order of elimination.
    pub(super) first: usize,
    /// Number of pivots.
    pub(super) pivots: usize,
    /// Number of other unknowns.
    pub(super) update: usize,
    /// The same, padded.
    pub(super) p: usize,
    pub(super) u: usize,
    /// Place of the front's factors: `p * p` of the pivot block, `u * p` below it, `u * p` to its right.
    pub(super) factors: usize,
    /// Where its update waits for the parent: in one of two stacks (0 or 1), by turns from level to level of the tree, or, if the front is
    /// the last of a task, among the updates that are handed over (2).
    pub(super) side: usize,
    pub(super) update_at: usize,
    /// The other unknowns in `rows`.
    pub(super) rows: Range<usize>,
    /// Their places in the parent's front, in `runs`: first those that are pivots there, then the others.
    pub(super) to_pivots: Range<usize>,
    pub(super) to_others: Range<usize>,
    pub(super) parent: Option<u32>,
    /// Fronts whose updates are added, in ascending order.
    pub(super) children: Range<usize>,
    /// Entries of the matrix in the pivot block and beside it.
    pub(super) inside: Range<usize>,
    pub(super) beside: Range<usize>,
}

impl Front {
    /// Length of the front's factors.
    pub(super) fn length(&self) -> usize {
        (self.p + 2 * self.u) * self.p
    }

    /// Floating-point operations of its elimination.
    pub(super) fn operations(&self) -> f64 {
        let (p, u) = (self.pivots as f64, self.update as f64);
        2.0 / 3.0 * p * p * p + 2.0 * p * p * u + 2.0 * p * u * u
    }

    /// Time of its elimination in units of an operation: assembling an entry costs about twenty.
    fn work(&self) -> f64 {
        let side = (self.p + self.u) as f64;
        self.operations() + 20.0 * side * side
    }
}

/// A block of the matrix that goes into the pivot block of a front.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inside {
    pub(super) source: Block,
    /// Place of the block's first entry in the pivot block.
    pub(super) target: u32,
    /// Vertices of the rows and columns.
    pub(super) row: u32,
    pub(super) column: u32,
}

/// A block below the pivot block and its mirror image to the right.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beside {
    pub(super) lower: Block,
    pub(super) upper: Block,
    /// Place of the first entry of both, the right one stored transposed.
    pub(super) target: u32,
    /// The vertex among the pivots and the other one.
    pub(super) pivot: u32,
    pub(super) other: u32,
}

/// Unknowns of an update that stay side by side in the parent's front.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    /// First of them in the update.
    pub(super) source: u32,
    /// Its place among the parent's pivots, or among the parent's others.
    pub(super) target: u32,
    pub(super) length: u32,
}

impl Run {
    /// The part whose places are among `count` places from `first` on, its target counted from there.
    pub(super) fn within(&self, first: usize, count: usize) -> Option<Self> {
        let (first, end) = (first as u32, (first + count) as u32);
        let from = self.target.max(first);
        let to = (self.target + self.length).min(end);
        (from < to).then(|| Run { source: self.source + from - self.target, target: from - first, length: to - from })
    }
}

/// The structure of the factors of a pattern, for one order of elimination.
#[derive(Debug, Default)]
pub(super) struct Symbolic {
    /// Parent in the elimination tree of the vertex at each place of the order, or `u32::MAX`.
    pub(super) parents: Vec<u32>,
    /// Unknown at each place of the order of elimination, which the merger of fronts has changed.
    pub(super) unknowns: Vec<u32>,
    pub(super) fronts: Vec<Front>,
    pub(super) rows: Vec<u32>,
    pub(super) runs: Vec<Run>,
    pub(super) children: Vec<u32>,
    pub(super) inside: Vec<Inside>,
    pub(super) beside: Vec<Beside>,
    /// Number of unknowns of each vertex.
    pub(super) sizes: Vec<u8>,
    /// Length of all factors.
    pub(super) factors: usize,
    /// Independent subtrees, as ranges of fronts in ascending order: each can be eliminated before what is left. None in a small matrix.
    pub(super) tasks: Vec<Range<usize>>,
    /// Numbers in updates that wait at one time on the two stacks of one thread, and in those that tasks hand over.
    pub(super) stacks: [usize; 2],
    pub(super) handed: usize,
    /// Unknowns of the largest front.
    pub(super) largest: usize,
    /// Floating-point operations of a factorisation.
    pub(super) operations: f64,
}

impl Symbolic {
    /// The structure for vertices eliminated in the order given.
    pub(super) fn new(pattern: &Pattern, order: &[u32]) -> Self {
        let (tree, parents) = Tree::new(pattern, order);
        let mut symbolic =
            Symbolic { sizes: (0..pattern.vertices()).map(|v| pattern.size(v) as u8).collect(), parents, ..Symbolic::default() };
        let numbering = symbolic.number_fronts(pattern, order, &tree);
        symbolic.place_entries(pattern, order, &tree, &numbering);
        symbolic.find_tasks();
        symbolic.place_updates();
        symbolic
    }

    /// Finds the blocks of a pattern with other couplings; those of the structure that it lacks stand nowhere.
    pub(super) fn find_blocks(&mut self, pattern: &Pattern) {
        let find = |row: u32, column: u32| pattern.find_block(row, column).unwrap_or(Block::NOWHERE);
        for entry in &mut self.inside {
            entry.source = find(entry.row, entry.column);
        }
        for entry in &mut self.beside {
            (entry.lower, entry.upper) = (find(entry.other, entry.pivot), find(entry.pivot, entry.other));
        }
    }

    /// Splits the tree into independent subtrees of comparable work and the fronts above them.
    fn find_tasks(&mut self) {
        if self.operations < WORTH_TASKS {
            return;
        }
        let mut work: Vec<f64> = self.fronts.iter().map(Front::work).collect();
        // First front of each subtree.
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

    /// Finds where each update waits. The children of a front are last on the stack of the other side.
    fn place_updates(&mut self) {
        let mut depth = vec![0u8; self.fronts.len()];
        for k in (0..self.fronts.len()).rev() {
            if let Some(parent) = self.fronts[k].parent {
                depth[k] = 1 - depth[parent as usize];
            }
            self.fronts[k].side = depth[k] as usize;
            self.largest = self.largest.max(self.fronts[k].p + self.fronts[k].u);
        }
        for task in &self.tasks {
            self.fronts[task.end - 1].side = 2;
        }
        let mut tasks = self.tasks.iter().peekable();
        let (mut inside, mut above) = ([0; 2], [0; 2]);
        for k in 0..self.fronts.len() {
            while tasks.peek().is_some_and(|task| task.end <= k) {
                tasks.next();
            }
            // A task begins with empty stacks of its own.
            let tops = if tasks.peek().is_some_and(|task| task.contains(&k)) { &mut inside } else { &mut above };
            for &child in &self.children[self.fronts[k].children.clone()] {
                let child = &self.fronts[child as usize];
                if child.side < 2 {
                    tops[child.side] -= child.u * child.u;
                }
            }
            let front = &mut self.fronts[k];
            let size = front.u * front.u;
            if front.side < 2 {
                front.update_at = tops[front.side];
                tops[front.side] += size;
                self.stacks[front.side] = self.stacks[front.side].max(tops[front.side]);
            } else {
                front.update_at = self.handed;
                self.handed += size;
            }
        }
    }

    /// Puts the fronts in an order that ends every subtree with its root. Returns the last vertex of each front and, per vertex in the
    /// order of elimination, its first pivot.
    fn number_fronts(&mut self, pattern: &Pattern, order: &[u32], tree: &Tree) -> Numbering {
        let count = order.len();
        let mut numbering = Numbering { roots: Vec::new(), first: vec![0; count], sequence: Vec::with_capacity(count) };
        let mut number = vec![NONE; count];
        let mut children: Vec<u32> = Vec::new();
        let mut stack: Vec<(u32, bool)> = tree.roots.iter().rev().map(|&k| (k, false)).collect();
        while let Some((k, done)) = stack.pop() {
            if !done {
                stack.push((k, true));
                children.clear();
                children.extend(tree.kids(k));
                // The largest update first keeps the stack of updates small.
                children.sort_by_key(|&c| (tree.update[c as usize], c));
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

    /// Finds the rows of all fronts, the places of updates in their parents' fronts and of the entries of the matrix.
    fn place_entries(&mut self, pattern: &Pattern, order: &[u32], tree: &Tree, numbering: &Numbering) {
        let count = order.len();
        // Vertices of the updates in ascending order, by sorting all of them at once: fronts per vertex, then vertices per front.
        let structure = |front: usize| &tree.structure[tree.range(numbering.roots[front])];
        let mut starts = vec![0u32; count + 1];
        for front in 0..self.fronts.len() {
            for &i in structure(front) {
                starts[i as usize + 1] += 1;
            }
        }
        for i in 0..count {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut fronts_of = vec![0u32; starts[count] as usize];
        let mut ends: Vec<u32> = Vec::with_capacity(self.fronts.len());
        let mut total = 0;
        for front in 0..self.fronts.len() {
            ends.push(total);
            total += structure(front).len() as u32;
            for &i in structure(front) {
                fronts_of[next[i as usize] as usize] = front as u32;
                next[i as usize] += 1;
            }
        }
        let vertex_starts = ends.clone();
        let mut vertices = vec![0u32; total as usize];
        for &i in &numbering.sequence {
            for &front in &fronts_of[starts[i as usize] as usize..starts[i as usize + 1] as usize] {
                vertices[ends[front as usize] as usize] = i;
                ends[front as usize] += 1;
            }
        }

        let mut place_in_order = vec![0u32; count];
        for (k, &v) in order.iter().enumerate() {
            place_in_order[v as usize] = k as u32;
        }
        let mirrored = mirrored_blocks(pattern);
        let mut entry_starts = Vec::with_capacity(count + 1);
        entry_starts.push(0);
        for v in 0..count {
            entry_starts.push(entry_starts[v] + pattern.neighbors(v).len());
        }
        // Place of each vertex, by its number in the order, in the front at hand.
        let mut local = vec![0u32; count];
        let mut sequence = numbering.sequence.iter();
        for front in 0..self.fronts.len() {
            let Front { first, pivots, p, u, ref children, .. } = self.fronts[front];
            let children = children.clone();
            let own = sequence.as_slice();
            let mut length = 0;
            let rows = self.rows.len();
            while length < pivots {
                let Some(&i) = sequence.next() else { break };
                local[i as usize] = length as u32;
                length += self.sizes[order[i as usize] as usize] as usize;
            }
            let own = &own[..own.len() - sequence.as_slice().len()];
            let others = vertex_starts[front] as usize..ends[front] as usize;
            for &i in &vertices[others] {
                let size = u32::from(self.sizes[order[i as usize] as usize]);
                local[i as usize] = length as u32;
                length += size as usize;
                let unknown = numbering.first[i as usize];
                self.rows.extend(unknown..unknown + size);
            }
            self.fronts[front].rows = rows..self.rows.len();
            for child in children {
                let child = self.children[child] as usize;
                let (mut source, mut end) = (0, NONE);
                let first_run = self.runs.len();
                let mut first_other = None;
                for &i in &vertices[vertex_starts[child] as usize..ends[child] as usize] {
                    let place = local[i as usize];
                    let size = u32::from(self.sizes[order[i as usize] as usize]);
                    let other = place as usize >= pivots;
                    if other && first_other.is_none() {
                        first_other = Some(self.runs.len());
                        end = NONE;
                    }
                    match self.runs.last_mut() {
                        Some(run) if end == place => run.length += size,
                        _ => self.runs.push(Run { source, target: if other { place - pivots as u32 } else { place }, length: size }),
                    }
                    source += size;
                    end = place + size;
                }
                let first_other = first_other.unwrap_or(self.runs.len());
                self.fronts[child].to_pivots = first_run..first_other;
                self.fronts[child].to_others = first_other..self.runs.len();
            }
            let (inside, beside) = (self.inside.len(), self.beside.len());
            for &i in own {
                let vertex = order[i as usize];
                let column = local[i as usize];
                let entries = entry_starts[vertex as usize];
                for ((k, &neighbor), block) in
                    pattern.neighbors(vertex as usize).iter().enumerate().zip(pattern.column_blocks(vertex as usize))
                {
                    let other = place_in_order[neighbor as usize];
                    let unknown = numbering.first[other as usize] as usize;
                    if unknown >= first + pivots {
                        let row = local[other as usize] as usize - pivots;
                        self.beside.push(Beside {
                            lower: block,
                            upper: mirrored[entries + k],
                            target: (column as usize * u + row) as u32,
                            pivot: vertex,
                            other: neighbor,
                        });
                    } else if unknown >= first {
                        let target = column * p as u32 + local[other as usize];
                        self.inside.push(Inside { source: block, target, row: neighbor, column: vertex });
                    }
                }
            }
            self.fronts[front].inside = inside..self.inside.len();
            self.fronts[front].beside = beside..self.beside.len();
        }
    }
}

/// For every neighbor `u` of every vertex `v`, the block with row `v` and column `u`.
fn mirrored_blocks(pattern: &Pattern) -> Vec<Block> {
    let count = pattern.vertices();
    let blocks: Vec<Block> = (0..count).flat_map(|v| pattern.column_blocks(v)).collect();
    let mut next = Vec::with_capacity(count);
    let mut total = 0;
    for v in 0..count {
        next.push(total);
        total += pattern.neighbors(v).len();
    }
    // Vertices ascend, so each finds itself next in the ascending list of its neighbor.
    let mut mirrored = Vec::with_capacity(total);
    for v in 0..count {
        for &u in pattern.neighbors(v) {
            mirrored.push(blocks[next[u as usize]]);
            next[u as usize] += 1;
        }
    }
    mirrored
}

/// How fronts and pivots are numbered.
struct Numbering {
    /// Per front, the last of its vertices (numbers in the order of elimination, as everywhere in the tree).
    roots: Vec<u32>,
    /// Per vertex, its first pivot.
    first: Vec<u32>,
    /// Vertices in the order of their pivots.
    sequence: Vec<u32>,
}

/// The elimination tree with merged vertices; a vertex is named by its place in the order of elimination, a front by its last vertex.
struct Tree {
    roots: Vec<u32>,
    first_kid: Vec<u32>,
    next_kid: Vec<u32>,
    /// First of the vertices of a front, and the vertex that follows each.
    head: Vec<u32>,
    next: Vec<u32>,
    /// Number of unknowns in the update.
    update: Vec<u32>,
    /// Vertices of the updates, one vertex after the other.
    structure: Vec<u32>,
    starts: Vec<u32>,
}

impl Tree {
    fn kids(&self, k: u32) -> impl Iterator<Item = u32> + '_ {
        let mut kid = self.first_kid[k as usize];
        std::iter::from_fn(move || {
            let this = kid;
            (this != NONE).then(|| {
                kid = self.next_kid[this as usize];
                this
            })
        })
    }

    fn range(&self, k: u32) -> Range<usize> {
        self.starts[k as usize] as usize..self.starts[k as usize + 1] as usize
    }

    /// The tree, and the parents of the vertices before any merger.
    fn new(pattern: &Pattern, order: &[u32]) -> (Self, Vec<u32>) {
        let count = order.len();
        let mut place = vec![0u32; count];
        for (k, &v) in order.iter().enumerate() {
            place[v as usize] = k as u32;
        }
        let weights: Vec<u32> = order.iter().map(|&v| pattern.size(v as usize) as u32).collect();

        // Elimination tree with path compression (Liu 1986), and the structures of all columns, in one sweep.
        let (mut parent, mut ancestor) = (vec![NONE; count], vec![NONE; count]);
        let (mut first_kid, mut next_kid) = (vec![NONE; count], vec![NONE; count]);
        let mut mark = vec![NONE; count];
        let mut structure: Vec<u32> = Vec::with_capacity(8 * count);
        let mut starts = Vec::with_capacity(count + 1);
        starts.push(0u32);
        let mut update = vec![0u32; count];
        for k in 0..count as u32 {
            mark[k as usize] = k;
            let start = structure.len();
            for &neighbor in pattern.neighbors(order[k as usize] as usize) {
                let mut i = place[neighbor as usize];
                if i > k {
                    mark[i as usize] = k;
                    structure.push(i);
                    continue;
                }
                while i != k {
                    let above = std::mem::replace(&mut ancestor[i as usize], k);
                    if above == NONE {
                        parent[i as usize] = k;
                        next_kid[i as usize] = first_kid[k as usize];
                        first_kid[k as usize] = i;
                        break;
                    }
                    i = above;
                }
            }
            let mut kid = first_kid[k as usize];
            while kid != NONE {
                for at in starts[kid as usize] as usize..starts[kid as usize + 1] as usize {
                    let i = structure[at];
                    if mark[i as usize] != k {
                        mark[i as usize] = k;
                        structure.push(i);
                    }
                }
                kid = next_kid[kid as usize];
            }
            update[k as usize] = structure[start..].iter().map(|&i| weights[i as usize]).sum();
            starts.push(structure.len() as u32);
        }
        let roots = (0..count as u32).filter(|&k| parent[k as usize] == NONE).collect();
        let mut tree =
            Tree { roots, first_kid, next_kid, head: (0..count as u32).collect(), next: vec![NONE; count], update, structure, starts };
        tree.merge(weights);
        (tree, parent)
    }

    /// Merges children into their parents where it pays.
    fn merge(&mut self, mut pivots: Vec<u32>) {
        let count = pivots.len();
        let mut zeros = vec![0.0f64; count];
        let mut tail: Vec<u32> = (0..count as u32).collect();
        let mut kids: Vec<u32> = Vec::new();
        let area = |p: u32, u: u32| f64::from(p) * (f64::from(p) + 2.0 * f64::from(u));
        for k in 0..count {
            kids.clear();
            kids.extend(self.kids(k as u32));
            if kids.is_empty() {
                continue;
            }
            kids.sort_by_key(|&c| (std::cmp::Reverse(self.update[c as usize]), c));
            self.first_kid[k] = NONE;
            let u = self.update[k];
            for &c in &kids {
                let child = c as usize;
                let (p, together) = (pivots[k], pivots[child] + pivots[k]);
                let stored = area(together, u);
                let new_zeros = stored - area(pivots[child], self.update[child]) - area(p, u);
                let all_zeros = zeros[child] + zeros[k] + new_zeros;
                let small = pivots[child] < SMALL && p < SMALL && all_zeros < SMALL_ZEROS * stored;
                if new_zeros < 0.5 || small || all_zeros < ZEROS * stored {
                    pivots[k] = together;
                    zeros[k] = all_zeros;
                    self.next[tail[child] as usize] = self.head[k];
                    self.head[k] = self.head[child];
                    let mut grandchild = self.first_kid[child];
                    while grandchild != NONE {
                        let next = self.next_kid[grandchild as usize];
                        self.next_kid[grandchild as usize] = self.first_kid[k];
                        self.first_kid[k] = grandchild;
                        grandchild = next;
                    }
                } else {
                    self.next_kid[child] = self.first_kid[k];
                    self.first_kid[k] = c;
                }
            }
            tail[k] = k as u32;
        }
    }
}
