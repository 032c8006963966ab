//! Smoothed aggregation: a hierarchy of coarser matrices, and its V-cycle.
//!
//! Near-null vectors (rigid motions) are reproduced exactly by the prolongation `P = (I - omega D^-1 A) P_0`, where `P_0` reproduces them
//! on each aggregate; the coarse matrix is `P^T A P` (Vanek, Mandel and Brezina, Computing 56, 1996). Nodes of the finest level have `D`
//! unknowns, those of all others `M`, one for each near-null vector. The last nodes of a level may be *kept*: they are not smoothed, and
//! the next level contains them unchanged.

use super::aggregation::{NONE, aggregates, tentative};
use super::blocks::{Block, BlockMatrix, TOGETHER, add_product, frobenius, in_parts};
use super::coarsest::Coarsest;
use super::smoother::{InitialGuess, Smoother};
use crate::math::workers::Workers;

/// Numerator of the damping `omega` of the prolongation smoother, to be divided by the largest eigenvalue of `D^-1 A`: the best for model
/// problems.
const DAMPING: f64 = 4.0 / 3.0;

/// Threshold of strong couplings on the finest level, halved from level to level.
const STRONG: f64 = 0.08;

/// Number of unknowns up to which a level is factorized instead of coarsened.
pub(super) const SMALL: usize = 1200;

/// Largest number of levels.
const MOST_LEVELS: usize = 20;

/// Number of coarse rows that a thread computes at a time.
const COARSE_ROWS: usize = 64;

/// Level of the hierarchy with the transfer to the next coarser one.
struct Level<const N: usize, const M: usize> {
    matrix: BlockMatrix<N, N>,
    smoother: Smoother<N>,
    prolongation: BlockMatrix<N, M>,
    restriction: BlockMatrix<M, N>,
    /// Right-hand side, solution and two scratch vectors of this level.
    vectors: [Vec<[f64; N]>; 4],
    /// Correction of the next coarser level, before prolongation to this one.
    coarse: Vec<[f64; M]>,
}

/// Levels of a matrix with `D` unknowns per node and `M` near-null vectors, without the coarsest level.
pub(super) struct Hierarchy<const D: usize, const M: usize> {
    first: Option<Box<Level<D, M>>>,
    rest: Vec<Level<M, M>>,
}

/// Matrix of the coarsest level: the given matrix itself if there is only one level, otherwise a Galerkin matrix.
pub(super) enum Last<const D: usize, const M: usize> {
    Fine(BlockMatrix<D, D>),
    Coarse(BlockMatrix<M, M>),
}

/// Numbers of nodes of a level: free nodes, which are aggregated, followed by kept nodes.
#[derive(Clone, Copy)]
struct Nodes {
    free: usize,
    kept: usize,
}

impl<const D: usize, const M: usize> Hierarchy<D, M> {
    /// Builds the levels of a matrix with its near-null vectors as columns of `modes`. The leading `free` nodes are aggregated. Returns the
    /// levels, and the matrix of the coarsest one.
    pub fn new(matrix: BlockMatrix<D, D>, modes: Vec<Block<D, M>>, free: usize, workers: &Workers) -> (Self, Last<D, M>) {
        if D * matrix.rows() <= SMALL || free == 0 {
            return (Hierarchy { first: None, rest: Vec::new() }, Last::Fine(matrix));
        }
        let mut threshold = STRONG;
        let mut nodes = Nodes { free, kept: matrix.rows() - free };
        let (first, mut coarse, mut modes) = Level::new(matrix, &modes, &mut nodes, |row| row.is_kept(), threshold, workers);
        let mut rest: Vec<Level<M, M>> = Vec::new();
        while M * nodes.free > SMALL && rest.len() < MOST_LEVELS {
            threshold *= 0.5;
            let before = nodes.free;
            let (level, next, coarse_modes) = Level::new(coarse, &modes, &mut nodes, |row| row.touches_kept(), threshold, workers);
            rest.push(level);
            (coarse, modes) = (next, coarse_modes);
            if nodes.free == 0 || nodes.free == before {
                break;
            }
        }
        (Hierarchy { first: Some(Box::new(first)), rest }, Last::Coarse(coarse))
    }

    /// Bytes of all levels.
    pub fn bytes(&self) -> usize {
        self.first.as_ref().map_or(0, |level| level.bytes()) + self.rest.iter().map(Level::bytes).sum::<usize>()
    }

    /// One V-cycle for the right-hand sides `b` of the nodes and `border` of the constraints, which become the solution.
    pub fn cycle(&mut self, b: &mut [[f64; D]], border: &mut [f64], coarsest: &mut Coarsest, workers: &Workers) {
        let Some(first) = &mut self.first else {
            return coarsest.solve(b, border);
        };
        first.vectors[0].copy_from_slice(b);
        let mut right = first.descend(workers);
        for level in &mut self.rest {
            std::mem::swap(&mut level.vectors[0], &mut right);
            right = level.descend(workers);
        }
        coarsest.solve(&mut right, border);
        for level in self.rest.iter_mut().rev() {
            level.ascend(&right, workers);
            right.clone_from(&level.vectors[1]);
        }
        first.ascend(&right, workers);
        b.copy_from_slice(&first.vectors[1]);
    }
}

impl<const N: usize, const M: usize> Level<N, M> {
    /// Makes a level; returns it with the matrix and the near-null vectors of the next level, and sets `nodes` to those of the next level.
    /// Rows for which `is_still` holds have the tentative prolongation without smoothing.
    fn new(
        matrix: BlockMatrix<N, N>,
        modes: &[Block<N, M>],
        nodes: &mut Nodes,
        is_still: fn(&Row<N>) -> bool,
        threshold: f64,
        workers: &Workers,
    ) -> (Self, BlockMatrix<M, M>, Vec<Block<M, M>>) {
        let Nodes { free, kept } = *nodes;
        let smoother = Smoother::new(&matrix, free, workers);
        let (mut of, aggregates) = aggregates(&matrix, free, threshold);
        let (mut values, mut coarse_modes) = tentative(&of, aggregates, &modes[..free]);
        for (k, modes) in modes[free..].iter().enumerate() {
            of.push((aggregates + k) as u32);
            values.push(std::array::from_fn(|i| std::array::from_fn(|k| f64::from(i == k))));
            coarse_modes.push(std::array::from_fn(|i| modes.get(i).copied().unwrap_or([0.0; M])));
        }
        let count = aggregates + kept;
        let prolongation = smoothed(&matrix, &smoother, &of, &values, free, is_still, workers);
        let restriction = prolongation.transposed(count);
        let coarse = galerkin(&matrix, &prolongation, &restriction, workers);
        *nodes = Nodes { free: aggregates, kept };
        let rows = matrix.rows();
        let level = Level {
            matrix,
            smoother,
            prolongation,
            restriction,
            vectors: std::array::from_fn(|_| vec![[0.0; N]; rows]),
            coarse: vec![[0.0; M]; count],
        };
        (level, coarse, coarse_modes)
    }

    fn bytes(&self) -> usize {
        self.matrix.bytes() + self.prolongation.bytes() + self.restriction.bytes() + size_of_val(&self.smoother.inverse[..])
    }

    /// Pre-smooths from a zero start; returns the restricted residual, the right-hand side of the next level.
    fn descend(&mut self, workers: &Workers) -> Vec<[f64; M]> {
        let Level { matrix, smoother, restriction, vectors: [b, x, r, d], coarse, .. } = self;
        x.fill([0.0; N]);
        smoother.smooth(matrix, b, x, [r, d], InitialGuess::Zero, workers);
        matrix.multiply(-1.0, x, b, r, workers);
        coarse.fill([0.0; M]);
        let mut right = vec![[0.0; M]; coarse.len()];
        restriction.multiply(1.0, r, coarse, &mut right, workers);
        right
    }

    /// Adds the prolonged correction of the next level, and post-smooths.
    fn ascend(&mut self, correction: &[[f64; M]], workers: &Workers) {
        let Level { matrix, smoother, prolongation, vectors: [b, x, r, d], .. } = self;
        prolongation.multiply(1.0, correction, x, r, workers);
        std::mem::swap(x, r);
        smoother.smooth(matrix, b, x, [r, d], InitialGuess::Solution, workers);
    }
}

/// Row of a level matrix in which the nodes from `free` on are kept nodes.
struct Row<'a, const N: usize> {
    number: usize,
    free: usize,
    columns: &'a [u32],
    blocks: &'a [Block<N, N>],
}

impl<const N: usize> Row<'_, N> {
    /// True for kept nodes.
    fn is_kept(&self) -> bool {
        self.number >= self.free
    }

    /// True for kept nodes, and for nodes that couple with kept nodes. Smoothing these on coarse levels would multiply their couplings with
    /// kept nodes by nine from level to level.
    fn touches_kept(&self) -> bool {
        self.is_kept() || self.columns.iter().zip(self.blocks).any(|(j, block)| *j as usize >= self.free && frobenius(block) > 0.0)
    }
}

/// Prolongation `(I - omega D^-1 A) P_0`.
fn smoothed<const N: usize, const M: usize>(
    matrix: &BlockMatrix<N, N>,
    smoother: &Smoother<N>,
    of: &[u32],
    values: &[Block<N, M>],
    free: usize,
    is_still: fn(&Row<N>) -> bool,
    workers: &Workers,
) -> BlockMatrix<N, M> {
    let omega = DAMPING / smoother.largest;
    let row = |i: usize, row: &mut Vec<(u32, Block<N, M>)>| {
        row.clear();
        let (columns, blocks) = matrix.row(i);
        if is_still(&Row { number: i, columns, free, blocks }) {
            row.extend((of[i] != NONE).then_some((of[i], values[i])));
            return;
        }
        for (&j, block) in columns.iter().zip(blocks).filter(|(j, _)| of[**j as usize] != NONE) {
            let a = of[j as usize];
            let place = row.iter().position(|(other, _)| *other == a).unwrap_or_else(|| {
                row.push((a, [[0.0; M]; N]));
                row.len() - 1
            });
            add_product(&mut row[place].1, block, &values[j as usize]);
        }
        for (a, sum) in row.iter_mut() {
            let mut scaled = [[0.0; M]; N];
            add_product(&mut scaled, &smoother.inverse[i], sum);
            *sum = scaled.map(|row| row.map(|x| -omega * x));
            if of[i] == *a {
                sum.iter_mut().flatten().zip(values[i].iter().flatten()).for_each(|(x, value)| *x += value);
            }
        }
        row.sort_unstable_by_key(|(a, _)| *a);
    };
    in_parts(matrix.rows(), TOGETHER, workers, |rows, part| {
        let mut own = Vec::new();
        for i in rows {
            row(i, &mut own);
            part.push_row(own.drain(..));
        }
    })
}

/// Galerkin matrix `P^T A P`, row by row. Near-null vectors that an aggregate cannot represent get a unit diagonal.
fn galerkin<const N: usize, const M: usize>(
    matrix: &BlockMatrix<N, N>,
    prolongation: &BlockMatrix<N, M>,
    restriction: &BlockMatrix<M, N>,
    workers: &Workers,
) -> BlockMatrix<M, M> {
    let (fine, coarse) = (matrix.rows(), restriction.rows());
    in_parts(coarse, COARSE_ROWS, workers, |rows, part| {
        // Positions of fine and of coarse nodes in the lists of the present row.
        let (mut fine_place, mut coarse_place) = (vec![NONE; fine], vec![NONE; coarse]);
        let mut half: Vec<(u32, Block<M, N>)> = Vec::new();
        let mut sums: Vec<(u32, Block<M, M>)> = Vec::new();
        for row in rows {
            half.clear();
            sums.clear();
            let (nodes, weights) = restriction.row(row);
            for (&i, weight) in nodes.iter().zip(weights) {
                let (columns, blocks) = matrix.row(i as usize);
                for (&j, block) in columns.iter().zip(blocks) {
                    let place = place_of(&mut fine_place[j as usize], &mut half, j, [[0.0; N]; M]);
                    add_product(&mut half[place].1, weight, block);
                }
            }
            for (j, product) in &half {
                fine_place[*j as usize] = NONE;
                let (columns, blocks) = prolongation.row(*j as usize);
                for (&a, block) in columns.iter().zip(blocks) {
                    let place = place_of(&mut coarse_place[a as usize], &mut sums, a, [[0.0; M]; M]);
                    add_product(&mut sums[place].1, product, block);
                }
            }
            for (a, sum) in &mut sums {
                coarse_place[*a as usize] = NONE;
                if *a as usize == row {
                    for m in 0..M {
                        if sum[m][m] == 0.0 {
                            sum[m][m] = 1.0;
                        }
                    }
                }
            }
            sums.sort_unstable_by_key(|(a, _)| *a);
            part.push_row(sums.drain(..));
        }
    })
}

/// Position of an item in a list; the item is appended with the value `zero` if it is missing.
#[inline(always)]
fn place_of<B>(place: &mut u32, list: &mut Vec<(u32, B)>, item: u32, zero: B) -> usize {
    if *place == NONE {
        *place = list.len() as u32;
        list.push((item, zero));
    }
    *place as usize
}
