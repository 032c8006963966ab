//! Sizes of substeps: halvings are kept for later substeps, and the next step starts with one less; with step size control (`pace.rs`) the
//! chosen size is reduced until it is accepted.

/// Equal parts of a time interval, halved when one of them is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Substeps {
    from: f64,
    dt: f64,
    level: usize,
    /// Completed and total time in units of `dt / 2^level`.
    done: usize,
    all: usize,
    /// True if the first accepted substep ends the step; the remainder belongs to the next step.
    is_alone: bool,
    /// True if the substep was shortened.
    is_short: bool,
}

impl Substeps {
    /// Substeps of an interval of size `dt` from the time `from`, with `level` initial halvings.
    pub fn new(from: f64, dt: f64, level: usize) -> Self {
        Substeps { from, dt, level, done: 0, all: 1 << level, is_alone: false, is_short: false }
    }

    /// A single substep of the size `dt`, which may be shortened.
    pub fn one(from: f64, dt: f64) -> Self {
        Substeps { is_alone: true, ..Substeps::new(from, dt, 0) }
    }

    /// True if a single substep covers the whole interval.
    pub fn is_whole(&self) -> bool {
        self.is_alone && !self.is_short
    }

    /// Size of the next substep `[time]`.
    pub fn size(&self) -> f64 {
        self.dt / self.all as f64
    }

    /// Number of halvings of the interval.
    pub fn level(&self) -> usize {
        self.level
    }

    /// True if the interval is complete.
    pub fn are_done(&self) -> bool {
        self.done == self.all || self.is_alone && self.done > 0
    }

    /// Counts the next substep as accepted; returns the time at its end, or `None` at the end of the interval.
    pub fn accepted(&mut self) -> Option<f64> {
        self.done += 1;
        (self.is_short || !self.are_done()).then(|| self.from + self.dt * (self.done as f64 / self.all as f64))
    }

    /// Halves the remaining substeps after the next one was refused.
    pub fn halve(&mut self) {
        (self.level, self.done, self.all) = (self.level + 1, 2 * self.done, 2 * self.all);
        self.is_short = self.is_alone;
    }

    /// Shortens a single substep to another size `[time]`.
    pub fn shorten(&mut self, size: f64) {
        (self.dt, self.is_short) = (size * self.all as f64, true);
    }

    /// Initial number of halvings of the next interval: one less after a complete interval.
    pub fn next_level(&self) -> usize {
        match self.is_alone {
            true => 0,
            false if self.are_done() => self.level.saturating_sub(1),
            false => self.level,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Substeps;

    #[test]
    fn pieces_are_halved_and_end_where_they_should() {
        let mut substeps = Substeps::new(1.0, 0.5, 1);
        assert_eq!((substeps.size(), substeps.accepted()), (0.25, Some(1.25)));
        substeps.halve();
        assert_eq!((substeps.size(), substeps.level(), substeps.next_level()), (0.125, 2, 2));
        assert_eq!((substeps.accepted(), substeps.are_done()), (Some(1.375), false));
        assert_eq!((substeps.accepted(), substeps.are_done(), substeps.next_level()), (None, true, 1));
    }

    #[test]
    fn a_single_one_ends_where_it_was_made_shorter() {
        let mut one = Substeps::one(1.0, 0.5);
        assert!(one.is_whole());
        one.halve();
        one.shorten(0.125);
        assert_eq!((one.size(), one.level(), one.is_whole()), (0.125, 1, false));
        assert_eq!((one.accepted(), one.are_done(), one.next_level()), (Some(1.125), true, 0));
        assert_eq!(Substeps::one(1.0, 0.5).accepted(), None);
    }
}
