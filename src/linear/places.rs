//! Positions in the fronts of the matrix entries and update matrices added to them.

use std::ops::Range;

use super::fronts::{Front, Numbering, OffDiagonalBlock, PivotBlock, Run};
use super::pattern::{Block, Pattern};
use super::tree::{NONE, Tree};

/// Positions of matrix blocks and update matrices in the fronts: lists of which each front owns a range.
#[derive(Debug, Default)]
pub(super) struct Places {
    /// Non-pivot unknowns of all fronts, as positions in the order of elimination.
    pub(super) rows: Vec<u32>,
    pub(super) runs: Vec<Run>,
    pub(super) inside: Vec<PivotBlock>,
    pub(super) beside: Vec<OffDiagonalBlock>,
}

/// Working data for the search of positions. Vertices are numbered by their position in the order of elimination, as in the tree.
struct Finder<'a> {
    pattern: &'a Pattern,
    order: &'a [u32],
    numbering: &'a Numbering,
    updates: Updates,
    /// Position of each vertex of the pattern in the order of elimination.
    place_in_order: Vec<u32>,
    /// Block in row `v` and column `u`, for every vertex `v` and each of its neighbors `u`.
    mirrored: Vec<Block>,
    /// First entry of each vertex.
    entry_starts: Vec<usize>,
    /// Position of each vertex in the present front.
    local: Vec<u32>,
}

impl Places {
    /// Finds the rows of all fronts, and the positions of update matrices in parent fronts and of matrix entries.
    pub(super) fn find(
        pattern: &Pattern,
        order: &[u32],
        tree: &Tree,
        numbering: &Numbering,
        fronts: &mut [Front],
        children: &[u32],
    ) -> Self {
        let count = order.len();
        let mut place_in_order = vec![0u32; count];
        for (k, &v) in order.iter().enumerate() {
            place_in_order[v as usize] = k as u32;
        }
        let mut entry_starts = Vec::with_capacity(count + 1);
        entry_starts.push(0);
        for v in 0..count {
            entry_starts.push(entry_starts[v] + pattern.neighbors(v).len());
        }
        let (updates, mirrored) = (Updates::sorted(count, tree, numbering), mirrored_blocks(pattern));
        let mut finder = Finder { pattern, order, numbering, updates, place_in_order, mirrored, entry_starts, local: vec![0u32; count] };
        let mut places = Places::default();
        let mut sequence = numbering.sequence.as_slice();
        for front in 0..fronts.len() {
            let own = finder.number_pivots(fronts[front].pivots, &mut sequence);
            fronts[front].rows = finder.number_others(front, fronts[front].pivots, &mut places.rows);
            for &child in &children[fronts[front].children.clone()] {
                let [to_pivots, to_others] = finder.find_runs(child as usize, fronts[front].pivots, &mut places.runs);
                (fronts[child as usize].to_pivots, fronts[child as usize].to_others) = (to_pivots, to_others);
            }
            let (inside, beside) = (places.inside.len(), places.beside.len());
            finder.find_blocks(own, &fronts[front], &mut places);
            fronts[front].inside = inside..places.inside.len();
            fronts[front].beside = beside..places.beside.len();
        }
        places
    }
}

impl Finder<'_> {
    fn size(&self, i: u32) -> u32 {
        self.pattern.size(self.order[i as usize] as usize) as u32
    }

    /// Removes the vertices of a front from the sequence and numbers their unknowns.
    fn number_pivots<'s>(&mut self, pivots: usize, sequence: &mut &'s [u32]) -> &'s [u32] {
        let mut length = 0;
        let mut count = 0;
        while let Some(&i) = sequence.get(count).filter(|_| length < pivots) {
            self.local[i as usize] = length as u32;
            length += self.size(i) as usize;
            count += 1;
        }
        let (own, later) = sequence.split_at(count);
        *sequence = later;
        own
    }

    /// Numbers the non-pivot unknowns of a front after its pivots; returns their range in the list of rows.
    fn number_others(&mut self, front: usize, pivots: usize, rows: &mut Vec<u32>) -> Range<usize> {
        let start = rows.len();
        let mut length = pivots as u32;
        for at in self.updates.range(front) {
            let i = self.updates.vertices[at];
            let size = self.size(i);
            self.local[i as usize] = length;
            length += size;
            let unknown = self.numbering.first[i as usize];
            rows.extend(unknown..unknown + size);
        }
        start..rows.len()
    }

    /// Finds contiguous runs of a child's update in the numbered parent front: among its pivots, and among its other unknowns.
    fn find_runs(&self, child: usize, pivots: usize, runs: &mut Vec<Run>) -> [Range<usize>; 2] {
        let (mut source, mut end) = (0, NONE);
        let first_run = runs.len();
        let mut first_other = None;
        for &i in &self.updates.vertices[self.updates.range(child)] {
            let place = self.local[i as usize];
            let size = self.size(i);
            let other = place as usize >= pivots;
            if other && first_other.is_none() {
                first_other = Some(runs.len());
                end = NONE;
            }
            match runs.last_mut() {
                Some(run) if end == place => run.length += size,
                _ => runs.push(Run { source, target: if other { place - pivots as u32 } else { place }, length: size }),
            }
            source += size;
            end = place + size;
        }
        let first_other = first_other.unwrap_or(runs.len());
        [first_run..first_other, first_other..runs.len()]
    }

    /// Finds the positions of matrix blocks in the columns of a front's own vertices.
    fn find_blocks(&self, own: &[u32], front: &Front, places: &mut Places) {
        let Front { first, pivots, p, u, .. } = *front;
        for &i in own {
            let vertex = self.order[i as usize];
            let column = self.local[i as usize];
            let mirrored = &self.mirrored[self.entry_starts[vertex as usize]..];
            let neighbors = self.pattern.neighbors(vertex as usize);
            for ((&neighbor, &upper), block) in neighbors.iter().zip(mirrored).zip(self.pattern.column_blocks(vertex as usize)) {
                let other = self.place_in_order[neighbor as usize];
                let unknown = self.numbering.first[other as usize] as usize;
                if unknown >= first + pivots {
                    let row = self.local[other as usize] as usize - pivots;
                    let target = (column as usize * u + row) as u32;
                    places.beside.push(OffDiagonalBlock { lower: block, upper, target, pivot: vertex, other: neighbor });
                } else if unknown >= first {
                    let target = column * p as u32 + self.local[other as usize];
                    places.inside.push(PivotBlock { source: block, target, row: neighbor, column: vertex });
                }
            }
        }
    }
}

/// Non-pivot vertices of all fronts; the vertices of each front are in the order of elimination.
struct Updates {
    vertices: Vec<u32>,
    starts: Vec<u32>,
    ends: Vec<u32>,
}

impl Updates {
    /// Sorts all lists at once by counting: fronts of each vertex, then vertices of each front.
    fn sorted(count: usize, tree: &Tree, numbering: &Numbering) -> Self {
        let structures = || numbering.roots.iter().map(|&root| &tree.structure[tree.range(root)]);
        let mut starts = vec![0u32; count + 1];
        for &i in structures().flatten() {
            starts[i as usize + 1] += 1;
        }
        for i in 0..count {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut fronts_of = vec![0u32; starts[count] as usize];
        let mut ends: Vec<u32> = Vec::with_capacity(numbering.roots.len());
        let mut total = 0;
        for (front, structure) in structures().enumerate() {
            ends.push(total);
            total += structure.len() as u32;
            for &i in structure {
                fronts_of[next[i as usize] as usize] = front as u32;
                next[i as usize] += 1;
            }
        }
        let front_starts = ends.clone();
        let mut vertices = vec![0u32; total as usize];
        for &i in &numbering.sequence {
            for &front in &fronts_of[starts[i as usize] as usize..starts[i as usize + 1] as usize] {
                vertices[ends[front as usize] as usize] = i;
                ends[front as usize] += 1;
            }
        }
        Updates { vertices, starts: front_starts, ends }
    }

    fn range(&self, front: usize) -> Range<usize> {
        self.starts[front] as usize..self.ends[front] as usize
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
    // Since vertices are visited in ascending order, each one is the next unvisited entry in the sorted list of its neighbor.
    let mut mirrored = Vec::with_capacity(total);
    for v in 0..count {
        for &u in pattern.neighbors(v) {
            mirrored.push(blocks[next[u as usize]]);
            next[u as usize] += 1;
        }
    }
    mirrored
}
