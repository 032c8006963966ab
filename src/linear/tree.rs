//! Elimination tree of a pattern, whose vertices are merged into fronts if that adds few zeros or if the fronts would be too small for
//! efficient calls.

use std::ops::Range;

use super::pattern::Pattern;

/// Number of pivots below which two fronts are merged unless zeros dominate. Measured run time: with 1 a fifth longer, with 24 a seventh.
const SMALL: u32 = 8;
/// Largest share of zeros in a front merged from small fronts.
const SMALL_ZEROS: f64 = 0.6;
/// Largest share of zeros in any merged front.
const ZEROS: f64 = 0.05;

/// Marker for a missing vertex.
pub(super) const NONE: u32 = u32::MAX;

/// Elimination tree with merged vertices. A vertex is named by its position in the order of elimination, a front by its last vertex.
pub(super) struct Tree {
    pub(super) roots: Vec<u32>,
    pub(super) first_kid: Vec<u32>,
    pub(super) next_kid: Vec<u32>,
    /// First vertex of each front.
    pub(super) head: Vec<u32>,
    /// Next vertex of the front, for each vertex.
    pub(super) next: Vec<u32>,
    /// Number of non-pivot unknowns of each front.
    pub(super) update: Vec<u32>,
    /// Non-pivot vertices of the fronts, listed by vertex.
    pub(super) structure: Vec<u32>,
    /// First entry of each vertex in `structure`.
    pub(super) starts: Vec<u32>,
}

impl Tree {
    /// Children of a front in the tree; before merging, children of a vertex.
    pub(super) fn kids(&self, k: u32) -> impl Iterator<Item = u32> + '_ {
        let mut kid = self.first_kid[k as usize];
        std::iter::from_fn(move || {
            let this = kid;
            (this != NONE).then(|| {
                kid = self.next_kid[this as usize];
                this
            })
        })
    }

    /// Range of the non-pivot vertices of a front in `structure`.
    pub(super) fn range(&self, k: u32) -> Range<usize> {
        self.starts[k as usize] as usize..self.starts[k as usize + 1] as usize
    }

    /// Elimination tree after merging, and the parents of the vertices before merging.
    pub(super) fn new(pattern: &Pattern, order: &[u32]) -> (Self, Vec<u32>) {
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

    /// Merges fronts into their parents where that saves time.
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
