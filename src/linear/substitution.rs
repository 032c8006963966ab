//! Substitution along the tree: from the leaves to the roots with the lower factors, then back with the upper factors.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use super::fronts::Front;
use super::symbolic::Symbolic;
use super::triangular::{substitute_lower, substitute_upper};

/// Direction of a substitution: from the leaves to the roots (lower factor) or back (upper factor).
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Direction {
    Down,
    Up,
}

/// Consecutive fronts with their part of several vectors, and the components exchanged with the fronts above.
pub(super) struct Part<'a> {
    pub(super) fronts: Range<usize>,
    /// First position in the order of elimination that belongs to these fronts.
    pub(super) start: usize,
    /// Positions of the exchanged components in the order of elimination, ascending.
    pub(super) rows: &'a [u32],
    pub(super) vectors: Vec<PartOfVector<'a>>,
}

/// Part of one vector.
pub(super) struct PartOfVector<'a> {
    pub(super) own: &'a mut [f64],
    /// Exchanged components: contributions to fronts above (forward), or the solution there (backward).
    pub(super) outside: &'a mut [f64],
}

/// Splits consecutive vectors of equal length into `count` slices.
pub(super) fn each(mut data: &mut [f64], count: usize) -> impl Iterator<Item = &mut [f64]> {
    let length = data.len() / count.max(1);
    (0..count).filter_map(move |_| data.split_off_mut(..length))
}

/// Parts of several vectors for all tasks.
pub(super) fn parts<'a>(symbolic: &'a Symbolic, ordered: &'a mut [f64], outside: &'a mut [f64], count: usize) -> Vec<Part<'a>> {
    let mut vectors: Vec<_> = each(ordered, count).zip(each(outside, count)).collect();
    let mut done = 0;
    let part = |task: &Range<usize>| {
        let (start, last) = (symbolic.fronts[task.start].first, &symbolic.fronts[task.end - 1]);
        let end = last.first + last.pivots;
        let own = |(ordered, outside): &mut (&'a mut [f64], &'a mut [f64])| {
            // Components between two tasks belong to fronts above the tasks.
            let _ = ordered.split_off_mut(..start - done);
            PartOfVector {
                own: ordered.split_off_mut(..end - start).unwrap_or_default(),
                outside: outside.split_off_mut(..last.update).unwrap_or_default(),
            }
        };
        let vectors = vectors.iter_mut().map(own).collect();
        done = end;
        Part { fronts: task.clone(), start, rows: &symbolic.places.rows[last.rows.clone()], vectors }
    };
    symbolic.tasks.iter().map(part).collect()
}

/// A substitution along some fronts.
pub(super) struct Substitution<'a, 'p> {
    pub(super) symbolic: &'a Symbolic,
    pub(super) factors: &'a [f64],
    pub(super) swaps: &'a [u32],
    pub(super) part: &'a mut Part<'p>,
    pub(super) at_front: &'a mut [f64],
    pub(super) direction: Direction,
}

impl WithSimd for Substitution<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Substitution { symbolic, factors, swaps, part, at_front, direction } = self;
        let Part { fronts, start, rows: above, vectors } = part;
        let fronts = &symbolic.fronts[fronts.clone()];
        let mut at_front = AtFront { symbolic, factors, swaps, start: *start, above, buffer: at_front };
        // No closures, which the compiler may leave out of line, without the registers of the caller.
        if direction == Direction::Down {
            for front in fronts {
                at_front.down(simd, front, vectors);
            }
        } else {
            for front in fronts.iter().rev() {
                at_front.up(simd, front, vectors);
            }
        }
    }
}

/// Substitution at one front after another.
struct AtFront<'a> {
    symbolic: &'a Symbolic,
    factors: &'a [f64],
    swaps: &'a [u32],
    start: usize,
    above: &'a [u32],
    /// The parts of all vectors that belong to a front.
    buffer: &'a mut [f64],
}

impl AtFront<'_> {
    #[inline(always)]
    fn down<S: Simd>(&mut self, simd: S, front: &Front, vectors: &mut [PartOfVector<'_>]) {
        let AtFront { symbolic, factors, swaps, start, above, buffer } = self;
        let (side, start) = (front.p + front.u, *start);
        let buffer = &mut buffer[..side * vectors.len()];
        for (PartOfVector { own: ordered, .. }, at_front) in vectors.iter_mut().zip(buffer.chunks_exact_mut(side)) {
            let own = &mut ordered[front.first - start..][..front.pivots];
            for (k, &other) in swaps[front.first..][..front.pivots].iter().enumerate() {
                own.swap(k, other as usize);
            }
            at_front[..front.pivots].copy_from_slice(own);
            at_front[front.pivots..].fill(0.0);
        }
        let factors = &factors[front.factors..][..front.length()];
        let (diagonal, beside) = factors.split_at(front.p * front.p);
        substitute_lower(simd, diagonal, &beside[..front.u * front.p], [front.p, front.u], buffer);
        let rows = &symbolic.places.rows[front.rows.clone()];
        for (PartOfVector { own: ordered, outside }, at_front) in vectors.iter_mut().zip(buffer.chunks_exact(side)) {
            let (pivots, others) = at_front.split_at(front.p);
            let end = start + ordered.len();
            ordered[front.first - start..][..front.pivots].copy_from_slice(&pivots[..front.pivots]);
            let (mine, theirs) = rows.split_at(rows.partition_point(|&row| (row as usize) < end));
            for (&row, value) in mine.iter().zip(others) {
                ordered[row as usize - start] += value;
            }
            let mut k = 0;
            for (&row, value) in theirs.iter().zip(&others[mine.len()..]) {
                k += above[k..].iter().take_while(|&&other| other < row).count();
                outside[k] += value;
            }
        }
    }

    #[inline(always)]
    fn up<S: Simd>(&mut self, simd: S, front: &Front, vectors: &mut [PartOfVector<'_>]) {
        let AtFront { symbolic, factors, start, above, buffer, .. } = self;
        let (side, start) = (front.p + front.u, *start);
        let buffer = &mut buffer[..side * vectors.len()];
        let rows = &symbolic.places.rows[front.rows.clone()];
        for (PartOfVector { own: ordered, outside }, at_front) in vectors.iter_mut().zip(buffer.chunks_exact_mut(side)) {
            let (pivots, others) = at_front.split_at_mut(front.p);
            let (known, padding) = others.split_at_mut(front.update);
            let end = start + ordered.len();
            let (mine, theirs) = rows.split_at(rows.partition_point(|&row| (row as usize) < end));
            let (inside, beyond) = known.split_at_mut(mine.len());
            for (&row, value) in mine.iter().zip(inside) {
                *value = ordered[row as usize - start];
            }
            let mut k = 0;
            for (&row, value) in theirs.iter().zip(beyond) {
                k += above[k..].iter().take_while(|&&other| other < row).count();
                *value = outside[k];
            }
            padding.fill(0.0);
            pivots[..front.pivots].copy_from_slice(&ordered[front.first - start..][..front.pivots]);
            pivots[front.pivots..].fill(0.0);
        }
        let factors = &factors[front.factors..][..front.length()];
        let (diagonal, beside) = factors.split_at(front.p * front.p);
        substitute_upper(simd, diagonal, &beside[front.u * front.p..], [front.p, front.u], buffer);
        for (PartOfVector { own: ordered, .. }, at_front) in vectors.iter_mut().zip(buffer.chunks_exact(side)) {
            ordered[front.first - start..][..front.pivots].copy_from_slice(&at_front[..front.pivots]);
        }
    }
}
