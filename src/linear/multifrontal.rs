//! Numeric multifrontal LU: every front is assembled from the matrix and its children's updates and eliminated; substitution runs along the
//! tree. Numbers are not moved once they are computed, and buffers are kept from one factorisation to the next.
//!
//! Independent subtrees are shared among threads, then the fronts above them follow one by one, their dense work shared. What is computed
//! for a front does not depend on who computes it, or when, so the results are the same bytes for any number of threads.

use std::collections::TryReserveError;
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use pulp::{Simd, WithSimd};

use super::dense::{self, Blocks, Manner};
use super::pattern::Block;
use super::symbolic::{Beside, Front, Inside, Run, Symbolic};
use super::watch::Watch;
use crate::math::simd::with_registers;
use crate::math::workers::Workers;

/// Pivots below this, in a matrix scaled to entries of order one, are replaced by [`dense::REPLACEMENT`].
const TINY: f64 = 1e-10;

/// Numbers in a cache line.
const LINE: usize = 8;

/// Part of a buffer's length that is set aside for growth.
const SLACK: usize = 16;

/// Numbers that begin at a cache line.
#[derive(Debug, Default)]
struct AlignedBuffer {
    storage: Vec<f64>,
    offset: usize,
    length: usize,
}

impl AlignedBuffer {
    /// Makes room for at least `length` numbers, whose values are lost.
    fn resize(&mut self, length: usize) -> Result<(), TryReserveError> {
        if self.storage.len() < length + LINE {
            // The old numbers go first: both at once would be the peak of the whole run.
            self.storage = Vec::new();
            let mut storage = Vec::new();
            // Some more, because structures tend to grow a little while surfaces slide, and new pages are slow.
            let length = length + length / SLACK + LINE;
            storage.try_reserve_exact(length)?;
            storage.resize(length, 0.0);
            self.offset = storage.as_ptr().align_offset(LINE * size_of::<f64>()).min(LINE);
            self.storage = storage;
        }
        self.length = length;
        Ok(())
    }

    fn all(&self) -> &[f64] {
        &self.storage[self.offset..][..self.length]
    }

    fn all_mut(&mut self) -> &mut [f64] {
        &mut self.storage[self.offset..][..self.length]
    }
}

/// What one thread needs to eliminate fronts.
#[derive(Debug, Default)]
struct Scratch {
    /// Updates that wait, level of the tree by level by turns.
    stacks: [AlignedBuffer; 2],
    dense: dense::Scratch,
    /// A vector at a front.
    at_front: AlignedBuffer,
}

/// The factors of a matrix, and room to compute them.
#[derive(Debug, Default)]
pub(super) struct Multifrontal {
    factors: AlignedBuffer,
    /// Per pivot, the row of its front that was exchanged with it.
    swaps: Vec<u32>,
    /// Updates that subtrees hand over.
    handed: AlignedBuffer,
    /// One for each thread.
    scratch: Vec<Mutex<Scratch>>,
    /// Places in the order of elimination whose pivots were replaced.
    replaced: Vec<u32>,
    /// The vector in the order of elimination, and what subtrees exchange of it with the fronts above.
    ordered: Vec<f64>,
    outside: Vec<f64>,
}

/// Consecutive fronts and what their elimination writes.
struct Segment<'a, 'u> {
    fronts: Range<usize>,
    factors: &'a mut [f64],
    swaps: &'a mut [u32],
    /// The update of the last front, if it is handed over.
    update: &'u mut [f64],
    replaced: Vec<u32>,
}

/// What all fronts write, less what was split off.
struct Whole<'a> {
    symbolic: &'a Symbolic,
    factors: &'a mut [f64],
    swaps: &'a mut [u32],
}

impl<'a> Whole<'a> {
    /// The fronts that come next.
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
        self.handed.resize(symbolic.handed)?;
        let updates = symbolic.tasks.iter().map(|task| symbolic.fronts[task.end - 1].update);
        self.outside.resize(updates.sum(), 0.0);
        self.swaps.resize(symbolic.unknowns.len(), 0);
        self.scratch.resize_with(if symbolic.tasks.is_empty() { 1 } else { workers.count() }, Mutex::default);
        for scratch in self.scratch.iter_mut().filter_map(|scratch| scratch.get_mut().ok()) {
            for (stack, &size) in scratch.stacks.iter_mut().zip(&symbolic.stacks) {
                stack.resize(size)?;
            }
            scratch.at_front.resize(symbolic.largest)?;
        }
        self.replaced.clear();
        Ok(())
    }

    /// Factors `diag(scale) A diag(scale)`, with one scale per vertex; room was made before. What is left when the watch was interrupted is
    /// of no use.
    pub(super) fn factorize(&mut self, symbolic: &Symbolic, values: &[f64], scale: &[f64], workers: &Workers, watch: &Watch) {
        self.replaced.clear();
        let Multifrontal { factors, swaps, handed, scratch, replaced, .. } = self;
        let mut whole = Whole { symbolic, factors: factors.all_mut(), swaps };
        let (mut tasks, mut above) = (Vec::with_capacity(symbolic.tasks.len()), Vec::with_capacity(symbolic.tasks.len() + 1));
        let mut updates = handed.all_mut();
        let mut done = 0;
        for task in &symbolic.tasks {
            above.push(whole.split_off(done..task.start, &mut []));
            let u = symbolic.fronts[task.end - 1].u;
            tasks.push(whole.split_off(task.clone(), updates.split_off_mut(..u * u).unwrap_or_default()));
            done = task.end;
        }
        above.push(whole.split_off(done..symbolic.fronts.len(), &mut []));
        let operations = AtomicU64::new(0);
        let eliminate = |segment: &mut Segment<'_, '_>, handed: &[f64], workers: &Workers| {
            // There are as many as threads, so one is free.
            let Some(mut scratch) = scratch.iter().find_map(|scratch| scratch.try_lock().ok()) else { return };
            with_registers(Elimination {
                symbolic,
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

    /// Places in the order of elimination where no usable pivot was found.
    pub(super) fn replaced(&self) -> &[u32] {
        &self.replaced
    }

    /// `x := A^-1 x`, with one scale per unknown.
    pub(super) fn solve(&mut self, symbolic: &Symbolic, scale: &[f64], x: &mut [f64], workers: &Workers) {
        let Multifrontal { factors, swaps, ordered, outside, scratch, .. } = self;
        let (factors, count) = (factors.all(), symbolic.fronts.len());
        ordered.clear();
        ordered.extend(symbolic.unknowns.iter().map(|&unknown| scale[unknown as usize] * x[unknown as usize]));
        outside.fill(0.0);
        let run = |part: &mut Part<'_>, direction: Direction| {
            let Some(mut scratch) = scratch.iter().find_map(|scratch| scratch.try_lock().ok()) else { return };
            let at_front = scratch.at_front.all_mut();
            with_registers(Substitution { symbolic, factors, swaps, part, at_front, direction });
        };
        let above = || {
            let starts = std::iter::once(0).chain(symbolic.tasks.iter().map(|task| task.end));
            starts.zip(symbolic.tasks.iter().map(|task| task.start).chain([count])).map(|(start, end)| start..end)
        };

        let mut tasks = parts(symbolic, ordered, outside);
        workers.for_each(&mut tasks, 1, |_, part| run(part, Direction::Down));
        let mut received = &outside[..];
        for task in &symbolic.tasks {
            for &row in &symbolic.rows[symbolic.fronts[task.end - 1].rows.clone()] {
                if let Some((value, rest)) = received.split_first() {
                    ordered[row as usize] += value;
                    received = rest;
                }
            }
        }
        for fronts in above() {
            run(&mut Part { fronts, start: 0, own: ordered, rows: &[], outside: &mut [] }, Direction::Down);
        }
        for fronts in above().collect::<Vec<_>>().into_iter().rev() {
            run(&mut Part { fronts, start: 0, own: ordered, rows: &[], outside: &mut [] }, Direction::Up);
        }
        let mut given = outside.iter_mut();
        for task in &symbolic.tasks {
            for (&row, value) in symbolic.rows[symbolic.fronts[task.end - 1].rows.clone()].iter().zip(&mut given) {
                *value = ordered[row as usize];
            }
        }
        let mut tasks = parts(symbolic, ordered, outside);
        workers.for_each(&mut tasks, 1, |_, part| run(part, Direction::Up));
        for (&unknown, value) in symbolic.unknowns.iter().zip(&*ordered) {
            x[unknown as usize] = scale[unknown as usize] * value;
        }
    }
}

/// Whether a substitution goes from the leaves to the roots (the lower factor) or back (the upper one).
#[derive(Clone, Copy, PartialEq, Eq)]
enum Direction {
    Down,
    Up,
}

/// Consecutive fronts and the part of the vector that they own, with what they exchange with the fronts above.
struct Part<'a> {
    fronts: Range<usize>,
    /// Place of the first owned number.
    start: usize,
    own: &'a mut [f64],
    /// Places of the numbers above that matter, ascending, and what is added to them, or what they are.
    rows: &'a [u32],
    outside: &'a mut [f64],
}

/// The parts of a vector that belong to the tasks.
fn parts<'a>(symbolic: &'a Symbolic, mut ordered: &'a mut [f64], mut outside: &'a mut [f64]) -> Vec<Part<'a>> {
    let mut done = 0;
    let part = |task: &Range<usize>| {
        let (start, last) = (symbolic.fronts[task.start].first, &symbolic.fronts[task.end - 1]);
        let end = last.first + last.pivots;
        // What stands between two tasks belongs to fronts above.
        let _ = ordered.split_off_mut(..start - done);
        done = end;
        Part {
            fronts: task.clone(),
            start,
            own: ordered.split_off_mut(..end - start).unwrap_or_default(),
            rows: &symbolic.rows[last.rows.clone()],
            outside: outside.split_off_mut(..last.update).unwrap_or_default(),
        }
    };
    symbolic.tasks.iter().map(part).collect()
}

struct Elimination<'a, 's, 'u> {
    symbolic: &'a Symbolic,
    values: &'a [f64],
    scale: &'a [f64],
    segment: &'a mut Segment<'s, 'u>,
    handed: &'a [f64],
    scratch: &'a mut Scratch,
    workers: &'a Workers,
    watch: &'a Watch,
    operations: &'a AtomicU64,
}

impl WithSimd for Elimination<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Elimination { symbolic, values, scale, segment, handed, scratch, workers, watch, operations } = self;
        let Segment { fronts, factors, swaps, update, replaced } = segment;
        let Scratch { stacks: [even, odd], dense, .. } = scratch;
        let (mut factors, mut swaps) = (&mut factors[..], &mut swaps[..]);
        let stopped = || watch.is_interrupted();
        for front in &symbolic.fronts[fronts.clone()] {
            if stopped() {
                return;
            }
            let (p, u) = (front.p, front.u);
            let (own, rest) = factors.split_at_mut(front.length());
            factors = rest;
            let (diagonal, beside) = own.split_at_mut(p * p);
            let (lower, upper) = beside.split_at_mut(u * p);
            let children = &symbolic.children[front.children.clone()];
            let (rest, waiting) = match front.side {
                0 => (&mut even.all_mut()[front.update_at..][..u * u], odd.all()),
                1 => (&mut odd.all_mut()[front.update_at..][..u * u], even.all()),
                _ if children.iter().any(|&child| symbolic.fronts[child as usize].side == 0) => (&mut update[..], even.all()),
                _ => (&mut update[..], odd.all()),
            };
            let mut blocks = Blocks { pivots: front.pivots, p, u, diagonal, lower, upper, rest };
            Received { symbolic, children, waiting, handed }.add_up(simd, &mut blocks, workers);
            add_entries(symbolic, front, values, scale, &mut blocks);
            let manner = Manner { tiny: TINY, workers, stopped: &stopped };
            let (own, rest) = swaps.split_at_mut(front.pivots);
            swaps = rest;
            blocks.eliminate(simd, &manner, own, dense, &mut |k| replaced.push((front.first + k) as u32));
            watch.progressed(operations.fetch_add(front.operations() as u64, Ordering::Relaxed), symbolic.operations);
        }
    }
}

/// Adds the entries of the matrix that belong to a front, and the identity where its pivot block is padded.
#[inline(always)]
fn add_entries(symbolic: &Symbolic, front: &Front, values: &[f64], scale: &[f64], blocks: &mut Blocks) {
    let p = blocks.p;
    for k in blocks.pivots..p {
        blocks.diagonal[k * p + k] = 1.0;
    }
    let sizes = &symbolic.sizes;
    for entry in symbolic.inside[front.inside.clone()].iter().filter(|entry| entry.source != Block::NOWHERE) {
        let factor = scale[entry.row as usize] * scale[entry.column as usize];
        match (sizes[entry.row as usize], sizes[entry.column as usize]) {
            (2, 2) => add_inside(entry, 2, 2, factor, values, blocks),
            (3, 3) => add_inside(entry, 3, 3, factor, values, blocks),
            (rows, columns) => add_inside(entry, rows as usize, columns as usize, factor, values, blocks),
        }
    }
    for entry in symbolic.beside[front.beside.clone()].iter().filter(|entry| entry.lower != Block::NOWHERE) {
        let factor = scale[entry.pivot as usize] * scale[entry.other as usize];
        match (sizes[entry.pivot as usize], sizes[entry.other as usize]) {
            (2, 2) => add_beside(entry, 2, 2, factor, values, blocks),
            (3, 3) => add_beside(entry, 3, 3, factor, values, blocks),
            (pivots, others) => add_beside(entry, pivots as usize, others as usize, factor, values, blocks),
        }
    }
}

/// Adds a block inside the pivot block; inlined for the sizes that are common, so that its loops unroll.
#[inline(always)]
fn add_inside(entry: &Inside, rows: usize, columns: usize, factor: f64, values: &[f64], blocks: &mut Blocks) {
    for k in 0..columns {
        let source = &values[entry.source.at(0, k)..][..rows];
        let target = &mut blocks.diagonal[entry.target as usize + k * blocks.p..][..rows];
        for i in 0..rows {
            target[i] += factor * source[i];
        }
    }
}

/// Adds a block below the pivot block and its mirror image.
#[inline(always)]
fn add_beside(entry: &Beside, pivots: usize, others: usize, factor: f64, values: &[f64], blocks: &mut Blocks) {
    let target = entry.target as usize;
    for k in 0..pivots {
        let source = &values[entry.lower.at(0, k)..][..others];
        let lower = &mut blocks.lower[target + k * blocks.u..][..others];
        for i in 0..others {
            lower[i] += factor * source[i];
        }
    }
    for i in 0..others {
        let source = &values[entry.upper.at(0, i)..][..pivots];
        for k in 0..pivots {
            blocks.upper[target + k * blocks.u + i] += factor * source[k];
        }
    }
}

/// Pivots, or other unknowns, whose columns are put together at a time: few enough to stay in a cache near by.
const COLUMNS: usize = 32;

/// Entries of a front from which on its columns are shared among threads.
const WORTH_SHARING: usize = 20_000;

/// The updates that a front receives from its children.
#[derive(Clone, Copy)]
struct Received<'a> {
    symbolic: &'a Symbolic,
    children: &'a [u32],
    waiting: &'a [f64],
    handed: &'a [f64],
}

/// Columns of some pivots: those of the pivot block, and what is below and to the right of it.
struct PivotColumns<'a> {
    first: usize,
    count: usize,
    diagonal: &'a mut [f64],
    lower: &'a mut [f64],
    upper: &'a mut [f64],
}

/// Columns of the remainder of a front.
struct RestColumns<'a> {
    first: usize,
    columns: &'a mut [f64],
}

impl<'a> Received<'a> {
    /// Fills the blocks with the sums of the updates.
    #[inline(always)]
    fn add_up<S: Simd>(self, simd: S, blocks: &mut Blocks, workers: &Workers) {
        let (p, u) = (blocks.p, blocks.u);
        let (mut diagonal, mut lower, mut upper) = (&mut *blocks.diagonal, &mut *blocks.lower, &mut *blocks.upper);
        let pivots = (0..p).step_by(COLUMNS).map(|first| {
            let count = COLUMNS.min(p - first);
            PivotColumns {
                first,
                count,
                diagonal: diagonal.split_off_mut(..count * p).unwrap_or_default(),
                lower: lower.split_off_mut(..count * u).unwrap_or_default(),
                upper: upper.split_off_mut(..count * u).unwrap_or_default(),
            }
        });
        let rest = blocks.rest.chunks_mut((COLUMNS * u).max(1)).enumerate();
        let rest = rest.map(|(k, columns)| RestColumns { first: k * COLUMNS, columns });
        if workers.are_many() && (p + u) * (p + u) >= WORTH_SHARING {
            let (mut pivots, mut rest) = (pivots.collect::<Vec<_>>(), rest.collect::<Vec<_>>());
            workers.for_each(&mut pivots, 1, |_, part| with_registers(AddUp { received: self, part, p, u }));
            workers.for_each(&mut rest, 1, |_, part| with_registers(AddUp { received: self, part, p, u }));
        } else {
            for mut part in pivots {
                self.add_to_pivots(simd, &mut part, p, u);
            }
            for mut part in rest {
                self.add_to_rest(simd, &mut part, u);
            }
        }
    }

    /// A child and its update.
    #[inline(always)]
    fn update(self, child: u32) -> (&'a Front, &'a [f64]) {
        let child = &self.symbolic.fronts[child as usize];
        let source = if child.side == 2 { self.handed } else { self.waiting };
        (child, &source[child.update_at..][..child.u * child.u])
    }

    #[inline(always)]
    fn add_to_pivots<S: Simd>(self, simd: S, part: &mut PivotColumns, p: usize, u: usize) {
        let PivotColumns { first, count, diagonal, lower, upper } = part;
        diagonal.fill(0.0);
        lower.fill(0.0);
        upper.fill(0.0);
        for &child in self.children {
            let (child, update) = self.update(child);
            let (pivots, others) = (&self.symbolic.runs[child.to_pivots.clone()], &self.symbolic.runs[child.to_others.clone()]);
            for run in pivots {
                let Some(mine) = run.within(*first, *count) else { continue };
                let columns = &update[mine.source as usize * child.u..][..mine.length as usize * child.u];
                let target = mine.target as usize;
                for rows in pivots {
                    add_run(simd, rows, columns, child.u, &mut diagonal[target * p..], p);
                }
                for rows in others {
                    add_run(simd, rows, columns, child.u, &mut lower[target * u..], u);
                }
                for columns in others {
                    let source = &update[columns.source as usize * child.u..][..columns.length as usize * child.u];
                    for i in 0..mine.length as usize {
                        let target = &mut upper[(target + i) * u + columns.target as usize..][..columns.length as usize];
                        for (x, source) in target.iter_mut().zip(source[mine.source as usize + i..].iter().step_by(child.u)) {
                            *x += source;
                        }
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn add_to_rest<S: Simd>(self, simd: S, part: &mut RestColumns, u: usize) {
        part.columns.fill(0.0);
        for &child in self.children {
            let (child, update) = self.update(child);
            let others = &self.symbolic.runs[child.to_others.clone()];
            for run in others {
                let Some(mine) = run.within(part.first, COLUMNS) else { continue };
                let columns = &update[mine.source as usize * child.u..][..mine.length as usize * child.u];
                for rows in others {
                    add_run(simd, rows, columns, child.u, &mut part.columns[mine.target as usize * u..], u);
                }
            }
        }
    }
}

/// [`Received`], where a thread takes a part.
struct AddUp<'a, P> {
    received: Received<'a>,
    part: P,
    p: usize,
    u: usize,
}

impl WithSimd for AddUp<'_, &mut PivotColumns<'_>> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.received.add_to_pivots(simd, self.part, self.p, self.u);
    }
}

impl WithSimd for AddUp<'_, &mut RestColumns<'_>> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.received.add_to_rest(simd, self.part, self.u);
    }
}

/// Adds a run of rows of some columns to where they go.
#[inline(always)]
fn add_run<S: Simd>(simd: S, rows: &Run, source: &[f64], source_stride: usize, target: &mut [f64], target_stride: usize) {
    let (length, from, to) = (rows.length as usize, rows.source as usize, rows.target as usize);
    for (source, target) in source.chunks_exact(source_stride).zip(target.chunks_mut(target_stride)) {
        let (sources, source_rest) = S::as_simd_f64s(&source[from..from + length]);
        let (targets, target_rest) = S::as_mut_simd_f64s(&mut target[to..to + length]);
        for (x, value) in targets.iter_mut().zip(sources) {
            *x = simd.add_f64s(*x, *value);
        }
        for (x, value) in target_rest.iter_mut().zip(source_rest) {
            *x += value;
        }
    }
}

struct Substitution<'a, 'p> {
    symbolic: &'a Symbolic,
    factors: &'a [f64],
    swaps: &'a [u32],
    part: &'a mut Part<'p>,
    at_front: &'a mut [f64],
    direction: Direction,
}

impl WithSimd for Substitution<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Substitution { symbolic, factors, swaps, part, at_front, direction } = self;
        let Part { fronts, start, own: ordered, rows: above, outside } = part;
        let fronts = &symbolic.fronts[fronts.clone()];
        let end = *start + ordered.len();
        if direction == Direction::Down {
            for front in fronts {
                let (pivots, others) = at_front[..front.p + front.u].split_at_mut(front.p);
                let own = &mut ordered[front.first - *start..][..front.pivots];
                for (k, &other) in swaps[front.first..][..front.pivots].iter().enumerate() {
                    own.swap(k, other as usize);
                }
                let (inside, padding) = pivots.split_at_mut(front.pivots);
                inside.copy_from_slice(own);
                padding.fill(0.0);
                others.fill(0.0);
                let factors = &factors[front.factors..][..front.length()];
                let (diagonal, beside) = factors.split_at(front.p * front.p);
                dense::substitute_lower(simd, diagonal, &beside[..front.u * front.p], pivots, others);
                own.copy_from_slice(&pivots[..front.pivots]);
                let rows = &symbolic.rows[front.rows.clone()];
                let (mine, theirs) = rows.split_at(rows.partition_point(|&row| (row as usize) < end));
                for (&row, value) in mine.iter().zip(&*others) {
                    ordered[row as usize - *start] += value;
                }
                let mut k = 0;
                for (&row, value) in theirs.iter().zip(&others[mine.len()..]) {
                    k += above[k..].iter().take_while(|&&other| other < row).count();
                    outside[k] += value;
                }
            }
            return;
        }
        for front in fronts.iter().rev() {
            let (pivots, others) = at_front[..front.p + front.u].split_at_mut(front.p);
            let (known, padding) = others.split_at_mut(front.update);
            let rows = &symbolic.rows[front.rows.clone()];
            let (mine, theirs) = rows.split_at(rows.partition_point(|&row| (row as usize) < end));
            let (inside, beyond) = known.split_at_mut(mine.len());
            for (&row, value) in mine.iter().zip(inside) {
                *value = ordered[row as usize - *start];
            }
            let mut k = 0;
            for (&row, value) in theirs.iter().zip(beyond) {
                k += above[k..].iter().take_while(|&&other| other < row).count();
                *value = outside[k];
            }
            padding.fill(0.0);
            let own = &mut ordered[front.first - *start..][..front.pivots];
            let (inside, padding) = pivots.split_at_mut(front.pivots);
            inside.copy_from_slice(own);
            padding.fill(0.0);
            let factors = &factors[front.factors..][..front.length()];
            let (diagonal, beside) = factors.split_at(front.p * front.p);
            dense::substitute_upper(simd, diagonal, &beside[front.u * front.p..], pivots, others);
            own.copy_from_slice(&pivots[..front.pivots]);
        }
    }
}
