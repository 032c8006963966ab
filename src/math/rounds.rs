//! Runs of cells that can be computed at the same time.
//!
//! The cells of a body, in mesh order, are divided into runs of nearly equal length. A run needs the forces and matrix columns of its span
//! of node numbers only. Runs with disjoint spans form a *round*; rounds are computed one after the other. The division depends on the mesh
//! and not on the number of threads, and so does the order of summation.
//!
//! Two or three rounds suffice if nodes are numbered roughly along the cells, as in most meshes. With shuffled numbers every span is the
//! whole body, each round has one run, and threads gain nothing.

use std::ops::Range;

/// Work of a body, in cells times the square of the nodes of a cell, below which a single thread is used, since waking another one takes
/// longer than it saves: 2000 cells of four nodes, 500 of eight. The order of summation is the same.
pub const LEAST_WORK_FOR_THREADS: usize = 32_000;

/// Smallest number of cells per run, for efficient threads.
const LEAST_CELLS: usize = 128;
/// Largest number of runs of a body.
const MOST_RUNS: usize = 16;

/// Consecutive cells of a body, computed by one thread.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Cells, as positions in the order of the loop.
    pub cells: Range<usize>,
    /// Smallest range of node numbers that has all nodes of the run.
    pub nodes: Range<usize>,
    /// Ranges within `nodes` to which no earlier round contributes: this run assigns sums there instead of adding.
    pub fresh: Vec<Range<usize>>,
}

/// Divides the cells of a block into rounds, each in ascending order of its nodes; runs consist of whole groups of `together` cells.
/// `touched` contains the node ranges of the preceding blocks in ascending order, and is extended by those of this block.
pub fn rounds(cells: &[Vec<u32>], together: usize, touched: &mut Vec<Range<usize>>) -> Vec<Vec<Run>> {
    let length = cells.len().div_ceil(MOST_RUNS).max(LEAST_CELLS).next_multiple_of(together);
    let mut rounds: Vec<Vec<Run>> = Vec::new();
    for first in (0..cells.len()).step_by(length) {
        let cells_of_run = first..(first + length).min(cells.len());
        let (mut low, mut high) = (usize::MAX, 0);
        for &node in cells[cells_of_run.clone()].iter().flatten() {
            low = low.min(node as usize);
            high = high.max(node as usize + 1);
        }
        let run = Run { cells: cells_of_run, nodes: low..high, fresh: Vec::new() };
        let is_apart = |other: &Run| other.nodes.end <= run.nodes.start || run.nodes.end <= other.nodes.start;
        match rounds.iter_mut().find(|round| round.iter().all(is_apart)) {
            Some(round) => round.push(run),
            None => rounds.push(vec![run]),
        }
    }
    for round in &mut rounds {
        round.sort_by_key(|run| run.nodes.start);
        for run in round.iter_mut() {
            run.fresh = without(run.nodes.clone(), touched);
        }
        touched.extend(round.iter().map(|run| run.nodes.clone()));
        touched.sort_by_key(|span| span.start);
    }
    rounds
}

/// Parts of a range that lie outside of other, ascending ranges.
fn without(range: Range<usize>, others: &[Range<usize>]) -> Vec<Range<usize>> {
    let (mut left, mut start) = (Vec::new(), range.start);
    for other in others {
        left.push(start..other.start.min(range.end));
        start = start.max(other.end);
    }
    left.push(start..range.end);
    left.retain(|piece| piece.start < piece.end);
    left
}

/// Returns disjoint slices of `data` at ascending ranges.
pub fn pieces(mut data: &mut [f64], ranges: impl Iterator<Item = Range<usize>>) -> Vec<&mut [f64]> {
    let mut done = 0;
    ranges
        .map(|range| {
            let (_, rest) = std::mem::take(&mut data).split_at_mut(range.start - done);
            let (piece, rest) = rest.split_at_mut(range.len());
            (data, done) = (rest, range.end);
            piece
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cells of a grid of quadrilaterals, numbered row by row like those of a generator.
    fn strip(rows: usize, columns: usize) -> Vec<Vec<u32>> {
        let node = |i: usize, j: usize| (i * (columns + 1) + j) as u32;
        let cell = |k: usize| (k / columns, k % columns);
        (0..rows * columns).map(cell).map(|(i, j)| vec![node(i, j), node(i, j + 1), node(i + 1, j + 1), node(i + 1, j)]).collect()
    }

    #[test]
    fn every_cell_is_in_one_run_and_runs_of_a_round_share_no_node() {
        let cells = strip(100, 40);
        let rounds = rounds(&cells, 8, &mut Vec::new());
        assert_eq!(rounds.len(), 2, "a run touches the one before and the one after");
        let mut seen = vec![0; cells.len()];
        for round in &rounds {
            let mut owner = vec![usize::MAX; 101 * 41];
            for (number, run) in round.iter().enumerate() {
                assert_eq!(run.cells.start % 8, 0);
                for k in run.cells.clone() {
                    seen[k] += 1;
                    for &node in &cells[k] {
                        assert!(run.nodes.contains(&(node as usize)));
                        assert!(owner[node as usize] == usize::MAX || owner[node as usize] == number);
                        owner[node as usize] = number;
                    }
                }
            }
            assert!(round.windows(2).all(|pair| pair[0].nodes.end <= pair[1].nodes.start));
        }
        assert!(seen.iter().all(|&times| times == 1));
        let mut begun = vec![0; 101 * 41];
        rounds.iter().flatten().flat_map(|run| run.fresh.iter().cloned()).flatten().for_each(|node| begun[node] += 1);
        assert!(begun.iter().all(|&times| times == 1), "every sum begins once");
    }

    #[test]
    fn shuffled_numbers_are_computed_one_run_after_the_other() {
        let mut cells = strip(30, 40);
        let nodes = 31 * 41;
        cells.iter_mut().flatten().for_each(|node| *node = *node * 500 % nodes);
        let rounds = rounds(&cells, 8, &mut Vec::new());
        assert!(rounds.iter().all(|round| round.len() == 1));
        assert_eq!(rounds.iter().flatten().map(|run| run.cells.len()).sum::<usize>(), cells.len());
        assert_eq!(rounds.iter().flatten().flat_map(|run| run.fresh.iter().cloned()).flatten().count(), nodes as usize);
    }

    #[test]
    fn pieces_are_those_of_the_ranges() {
        let mut data = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        let pieces = pieces(&mut data, [1..2, 2..4, 5..6].into_iter());
        assert_eq!(pieces, [&[1.0][..], &[2.0, 3.0], &[5.0]]);
    }
}
