//! Laws of constraints: active set, equation, residual; one file each.

mod bilateral;
mod law;
mod penalty;
mod reaction;
mod unilateral;

pub use bilateral::Bilateral;
pub use law::{Equation, Row, RowLaw, RowStart, RowState};
pub use penalty::Penalty;
pub use reaction::Reaction;
pub use unilateral::Unilateral;

#[cfg(test)]
mod tests {
    use super::*;

    const LAWS: [&dyn RowLaw; 3] = [&Bilateral, &Unilateral, &Penalty];

    fn row(gap: f64, lambda: f64) -> Row {
        Row {
            gap,
            lambda,
            gap_n: -0.02,
            target: -0.02,
            shift: 0.0,
            end_point: true,
            compliance: 0.0,
            c: 10.0,
            stiffness: 7.0,
            tolerance: 1e-9,
        }
    }

    /// A constraint that solves the equation of its state has no residual unless its state must change.
    #[test]
    fn the_solution_of_the_equation_has_no_residual() {
        for law in LAWS {
            for (gap, lambda) in [(-0.3, 2.0), (-0.02, 0.4), (0.5, 0.0), (-0.1, -1.0)] {
                let start = row(gap, lambda);
                let Equation { acts, diagonal, right, .. } = law.equation(&start);
                for pressed in [-3.0, 0.0, 3.0] {
                    // The multiplier is given; the gap follows, or, for a potential, the multiplier follows from the gap.
                    let change = if acts { right - diagonal * pressed } else { 0.0 };
                    let solved = row(gap + change, if acts { pressed } else { right });
                    let asks = law.change(RowState::Closed, &solved).is_some();
                    let is_linear = law.has_multiplier() || solved.gap <= 0.0;
                    let residual = law.residual(&solved).0;
                    assert!(asks || !is_linear || residual.abs() < 1e-14, "{law:?}: {residual:e} at {gap}, {lambda}, {pressed}");
                    assert_eq!(asks, law.has_multiplier() && !law.is_bilateral() && pressed <= 0.0, "{law:?}");
                }
            }
            // Open and apart: no change.
            assert!(law.change(RowState::Open, &row(0.5, 0.0)).is_none());
        }
    }

    #[test]
    fn demands_never_drive_apart_what_overlaps() {
        for (gap, keeps) in [(-0.3, false), (-0.3, true), (0.2, false), (0.2, true)] {
            let start = RowStart { gap, penalty_gap: gap, held: 0.0, closed: 1e-6, keeps, end_point: false };
            for law in LAWS.into_iter().filter(|law| !law.is_bilateral()) {
                let demand = law.demand(&start);
                assert!(!law.has_multiplier() || demand.target <= demand.gap);
                assert_eq!(demand.is_member, !law.has_multiplier() || !keeps || gap <= 0.0);
            }
            assert_eq!(Bilateral.demand(&start).target, if keeps { gap } else { 0.0 });
        }
        // Overlap of newly admitted pairs has no potential.
        let start = RowStart { gap: -0.3, penalty_gap: -0.1, held: 0.0, closed: 1e-6, keeps: false, end_point: false };
        let demand = Penalty.demand(&start);
        assert!((demand.shift - 0.2).abs() < 1e-15 && (demand.gap + 0.1).abs() < 1e-15);
    }
}
