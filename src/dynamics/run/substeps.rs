//! Who decides how long the next substep is: halvings, which later substeps keep, and of which the next step begins with one less.
//!
//! A rule that looks at errors in time would be another value with the same questions: how long is the next one, may a refused one be
//! shorter, and what follows an accepted one.

/// Equal parts of a stretch of time, made half as long as often as one of them is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Substeps {
    from: f64,
    dt: f64,
    level: usize,
    /// In units of `dt / 2^level`: done, and all.
    done: usize,
    all: usize,
}

impl Substeps {
    /// Of a stretch of size `dt` from a time, with so many halvings from the beginning.
    pub fn new(from: f64, dt: f64, level: usize) -> Self {
        Substeps { from, dt, level, done: 0, all: 1 << level }
    }

    /// Size of the next one `[time]`.
    pub fn size(&self) -> f64 {
        self.dt / self.all as f64
    }

    /// Halvings that have led to it.
    pub fn level(&self) -> usize {
        self.level
    }

    /// Whether nothing is left.
    pub fn are_done(&self) -> bool {
        self.done == self.all
    }

    /// The next one is done: the time at its end, nothing where that is the end of the stretch.
    pub fn accepted(&mut self) -> Option<f64> {
        self.done += 1;
        (!self.are_done()).then(|| self.from + self.dt * (self.done as f64 / self.all as f64))
    }

    /// The next one is refused: what is left goes in substeps half as long.
    pub fn halve(&mut self) {
        (self.level, self.done, self.all) = (self.level + 1, 2 * self.done, 2 * self.all);
    }

    /// Halvings with which another stretch begins: after a whole one larger substeps are tried again.
    pub fn next_level(&self) -> usize {
        if self.are_done() { self.level.saturating_sub(1) } else { self.level }
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
}
