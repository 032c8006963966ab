//! Numeric multifrontal LU: every front is assembled from matrix entries and its children's updates, and eliminated; substitution follows
//! the tree. Computed factors are not moved, and buffers are reused by successive factorizations.
//!
//! Threads share independent subtrees, then the dense work of the remaining fronts, one by one. The computation of a front depends neither
//! on the thread nor on the time, so results are byte-identical for any number of threads.

use std::collections::TryReserveError;
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use pulp::{Simd, WithSimd};

use super::aligned::AlignedBuffer;
use super::assembly::{Received, add_entries};
use super::panels::{self, Blocks, EliminationOptions};
use super::substitution::{Direction, Part, PartOfVector, Substitution, each, parts};
use super::symbolic::Symbolic;
use super::waiting::{UpdateLocation, UpdateStack};
use super::watch::InterruptWatch;
use crate::math::simd::with_registers;
use crate::math::tolerances::LINEAR_PIVOT;
use crate::math::workers::Workers;

/// Largest number of vectors that are substituted together: enough that factors are read from memory rarely.
pub(super) const TOGETHER: usize = 16;

/// Buffers of one thread for the elimination of fronts.
#[derive(Debug, Default)]
struct Scratch {
    /// Buffer for the stacks of update matrices that are not yet assembled into parent fronts.
    waiting: AlignedBuffer,
    dense: panels::Scratch,
    /// Vectors at a front.
    at_front: AlignedBuffer,
}

/// Factors of a matrix, and buffers for their computation.
#[derive(Debug, Default)]
pub(super) struct Multifrontal {
    factors: AlignedBuffer,
    /// For each pivot, the row of its front that was exchanged with it.
    swaps: Vec<u32>,
    /// Update matrices of the last fronts of subtrees (tasks), assembled into the fronts above.
    handed: AlignedBuffer,
    /// Scratch buffers, one per thread.
    scratch: Vec<Mutex<Scratch>>,
    /// Positions in the order of elimination whose pivots were replaced.
    replaced: Vec<u32>,
    /// Vectors in the order of elimination.
    ordered: Vec<f64>,
    /// Components exchanged between subtrees and the fronts above.
    outside: Vec<f64>,
}

/// Consecutive fronts, with the slices that receive their factors, row exchanges and update matrix.
struct Segment<'a, 'u> {
    fronts: Range<usize>,
    factors: &'a mut [f64],
    swaps: &'a mut [u32],
    /// Update matrix of the last front, if another task assembles it.
    update: &'u mut [f64],
    replaced: Vec<u32>,
}

/// Factors and row exchanges of all fronts, from which slices are split off for segments.
struct Whole<'a> {
    symbolic: &'a Symbolic,
    factors: &'a mut [f64],
    swaps: &'a mut [u32],
}

impl<'a> Whole<'a> {
    /// Splits off the output of the next fronts.
    fn split_off<'u>(&mut self, fronts: Range<usize>, update: &'u mut [f64]) -> Segment<'a, 'u> {
        let all = &self.symbolic.fronts[fronts.clone()];
        let (numbers, pivots) = all.iter().fold((0, 0), |(numbers, pivots), front| (numbers + front.length(), pivots + front.pivots));
        Segment {
            fronts,
            factors: self.factors.split_off_mut(..numbers).unwrap_or_default(),
            swaps: self.swaps.split_off_mut(..pivots).unwrap_or_default(),
            update,
            replaced: Vec::new(),
        }
    }
}

impl Multifrontal {
    /// Makes room for the factors of a structure.
    pub(super) fn reserve(&mut self, symbolic: &Symbolic, workers: &Workers) -> Result<(), TryReserveError> {
        self.factors.resize(symbolic.factors)?;
        let (waiting, threads) = symbolic.waiting(workers);
        self.handed.resize(waiting.handed)?;
        self.swaps.resize(symbolic.unknowns.len(), 0);
        self.scratch.resize_with(threads, Mutex::default);
        // The first buffer also serves the fronts above the tasks.
        let lengths = std::iter::once(waiting.buffer.max(waiting.of_task)).chain(std::iter::repeat(waiting.of_task));
        for (scratch, length) in self.scratch.iter_mut().filter_map(|scratch| scratch.get_mut().ok()).zip(lengths) {
            scratch.waiting.resize(length)?;
            scratch.at_front.resize(TOGETHER * symbolic.largest)?;
        }
        self.replaced.clear();
        Ok(())
    }

    /// Factorizes `diag(scale) A diag(scale)`, with one scale per vertex, into allocated buffers. The factors are useless after an
    /// interrupt.
    pub(super) fn factorize(&mut self, symbolic: &Symbolic, values: &[f64], scale: &[f64], workers: &Workers, watch: &InterruptWatch) {
        self.replaced.clear();
        let Multifrontal { factors, swaps, handed, scratch, replaced, .. } = self;
        let mut whole = Whole { symbolic, factors: factors.all_mut(), swaps };
        let (mut tasks, mut above) = (Vec::with_capacity(symbolic.tasks.len()), Vec::with_capacity(symbolic.tasks.len() + 1));
        let mut updates = handed.all_mut();
        let mut done = 0;
        let waiting = symbolic.waiting(workers).0;
        for task in symbolic.tasks.iter().filter(|_| waiting.handed > 0) {
            above.push(whole.split_off(done..task.start, &mut []));
            let u = symbolic.fronts[task.end - 1].u;
            tasks.push(whole.split_off(task.clone(), updates.split_off_mut(..u * u).unwrap_or_default()));
            done = task.end;
        }
        above.push(whole.split_off(done..symbolic.fronts.len(), &mut []));
        let operations = AtomicU64::new(0);
        let eliminate = |segment: &mut Segment<'_, '_>, handed: &[f64], workers: &Workers| {
            // There are as many buffers as threads, so that one is always free.
            let Some(mut scratch) = scratch.iter().find_map(|scratch| scratch.try_lock().ok()) else { return };
            with_registers(Elimination {
                symbolic,
                waiting,
                values,
                scale,
                segment,
                handed,
                scratch: &mut scratch,
                workers,
                watch,
                operations: &operations,
            });
        };
        let alone = Workers::default();
        workers.for_each(&mut tasks, 1, |_, task| eliminate(task, &[], &alone));
        let found: Vec<u32> = tasks.into_iter().flat_map(|task| task.replaced).collect();
        let handed = handed.all();
        for segment in &mut above {
            eliminate(segment, handed, workers);
        }
        replaced.extend(found);
        replaced.extend(above.into_iter().flat_map(|segment| segment.replaced));
        replaced.sort_unstable();
    }

    /// Factors of all fronts and, for each pivot, the row of its front that was exchanged with it.
    pub(super) fn factors(&self) -> (&[f64], &[u32]) {
        (self.factors.all(), &self.swaps)
    }

    /// Positions in the order of elimination whose pivots were unusable and replaced.
    pub(super) fn replaced(&self) -> &[u32] {
        &self.replaced
    }

    /// `x := A^-1 x`, with one scale per unknown, for at most [`TOGETHER`] vectors `x` one after another. Every vector gets the same
    /// numbers as alone.
    pub(super) fn solve(&mut self, symbolic: &Symbolic, scale: &[f64], x: &mut [f64], workers: &Workers) {
        let Multifrontal { factors, swaps, ordered, outside, scratch, .. } = self;
        let (factors, fronts, unknowns) = (factors.all(), symbolic.fronts.len(), symbolic.unknowns.len());
        let count = x.len() / unknowns.max(1);
        ordered.clear();
        for x in x.chunks_exact(unknowns.max(1)) {
            ordered.extend(symbolic.unknowns.iter().map(|&unknown| scale[unknown as usize] * x[unknown as usize]));
        }
        let exchanged: usize = symbolic.tasks.iter().map(|task| symbolic.fronts[task.end - 1].update).sum();
        outside.clear();
        outside.resize(exchanged * count, 0.0);
        let run = |part: &mut Part<'_>, direction: Direction| {
            let Some(mut scratch) = scratch.iter().find_map(|scratch| scratch.try_lock().ok()) else { return };
            let at_front = scratch.at_front.all_mut();
            with_registers(Substitution { symbolic, factors, swaps, part, at_front, direction });
        };
        let above = || {
            let starts = std::iter::once(0).chain(symbolic.tasks.iter().map(|task| task.end));
            starts.zip(symbolic.tasks.iter().map(|task| task.start).chain([fronts])).map(|(start, end)| start..end)
        };
        let whole = |ordered: &mut [f64], fronts: Range<usize>, direction: Direction| {
            let vectors = each(ordered, count).map(|own| PartOfVector { own, outside: &mut [] }).collect();
            run(&mut Part { fronts, start: 0, rows: &[], vectors }, direction);
        };
        let rows = || symbolic.tasks.iter().flat_map(|task| &symbolic.places.rows[symbolic.fronts[task.end - 1].rows.clone()]);

        let mut tasks = parts(symbolic, ordered, outside, count);
        workers.for_each(&mut tasks, 1, |_, part| run(part, Direction::Down));
        for (ordered, received) in each(ordered, count).zip(each(outside, count)) {
            rows().zip(received).for_each(|(&row, value)| ordered[row as usize] += *value);
        }
        above().for_each(|fronts| whole(ordered, fronts, Direction::Down));
        above().collect::<Vec<_>>().into_iter().rev().for_each(|fronts| whole(ordered, fronts, Direction::Up));
        for (ordered, given) in each(ordered, count).zip(each(outside, count)) {
            rows().zip(given).for_each(|(&row, value)| *value = ordered[row as usize]);
        }
        let mut tasks = parts(symbolic, ordered, outside, count);
        workers.for_each(&mut tasks, 1, |_, part| run(part, Direction::Up));
        for (x, ordered) in x.chunks_exact_mut(unknowns.max(1)).zip(each(ordered, count)) {
            for (&unknown, value) in symbolic.unknowns.iter().zip(&*ordered) {
                x[unknown as usize] = scale[unknown as usize] * value;
            }
        }
    }
}

/// Consecutive fronts that one thread eliminates.
struct Elimination<'a, 's, 'u> {
    symbolic: &'a Symbolic,
    waiting: &'a UpdateStack,
    values: &'a [f64],
    scale: &'a [f64],
    segment: &'a mut Segment<'s, 'u>,
    handed: &'a [f64],
    scratch: &'a mut Scratch,
    workers: &'a Workers,
    watch: &'a InterruptWatch,
    operations: &'a AtomicU64,
}

impl WithSimd for Elimination<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Elimination {
            symbolic,
            waiting: UpdateStack { places, .. },
            values,
            scale,
            segment,
            handed,
            scratch,
            workers,
            watch,
            operations,
        } = self;
        let Segment { fronts, factors, swaps, update, replaced } = segment;
        let Scratch { waiting, dense, .. } = scratch;
        let (mut factors, mut swaps) = (&mut factors[..], &mut swaps[..]);
        let stopped = || watch.is_interrupted();
        for (front, &(side, at)) in symbolic.fronts[fronts.clone()].iter().zip(&places[fronts.clone()]) {
            if stopped() {
                return;
            }
            let (p, u) = (front.p, front.u);
            let (own, rest) = factors.split_at_mut(front.length());
            factors = rest;
            let (diagonal, beside) = own.split_at_mut(p * p);
            let (lower, upper) = beside.split_at_mut(u * p);
            let children = &symbolic.children[front.children.clone()];
            let (rest, waiting, start) = match side {
                UpdateLocation::Low => {
                    let (low, high) = waiting.all_mut().split_at_mut(at + u * u);
                    (&mut low[at..], &*high, at + u * u)
                }
                UpdateLocation::High => {
                    let (low, high) = waiting.all_mut().split_at_mut(at);
                    (&mut high[..u * u], &*low, 0)
                }
                UpdateLocation::Handed => (&mut update[..], waiting.all(), 0),
            };
            let mut blocks = Blocks { pivots: front.pivots, p, u, diagonal, lower, upper, rest };
            Received { symbolic, places, children, waiting, start, handed }.add_up(simd, &mut blocks, workers);
            add_entries(symbolic, front, values, scale, &mut blocks);
            let manner = EliminationOptions { tiny: LINEAR_PIVOT, workers, stopped: &stopped };
            let (own, rest) = swaps.split_at_mut(front.pivots);
            swaps = rest;
            blocks.eliminate(simd, &manner, own, dense, &mut |k| replaced.push((front.first + k) as u32));
            watch.progressed(operations.fetch_add(front.operations() as u64, Ordering::Relaxed), symbolic.operations);
        }
    }
}
