//! Penalty potential `U = kappa/2 min(Phi, 0)^2`: the pressure is its difference quotient over the step, `-(U_1 - U_0)/(Phi_1 - Phi_0)`.

use super::law::{ConstraintCondition, Equation, Row, RowLaw, RowStart, RowState};

/// Law `lambda = p(Phi)`.
#[derive(Debug)]
pub struct Penalty;

impl RowLaw for Penalty {
    fn has_multiplier(&self) -> bool {
        false
    }

    /// Conditions of the step; overlap found by newly admitted facet pairs, not caused by motion, stores no energy.
    fn demand(&self, start: &RowStart) -> ConstraintCondition {
        let shift = if start.end_point { 0.0 } else { (start.penalty_gap.min(0.0) - start.gap.min(0.0)).max(0.0) };
        ConstraintCondition { gap: if start.end_point { start.gap } else { start.gap + shift }, target: 0.0, is_member: true, shift }
    }

    fn first_state(&self, _row: &Row) -> RowState {
        RowState::Closed
    }

    fn residual(&self, row: &Row) -> (f64, f64) {
        let off = row.lambda - pressure_at(row).0;
        (off / row.c, off * (row.gap + row.shift - row.gap_n))
    }

    /// Equation `lambda = p(Phi_1 + G_1 dq)`, divided by the slope, so that all rows have similar entries.
    fn equation(&self, row: &Row) -> Equation {
        match pressure_at(row) {
            (_, 0.0) => Equation::OPEN,
            (pressure, slope) => Equation::held(-1.0 / slope, -pressure / slope),
        }
    }

    fn change(&self, _state: RowState, _row: &Row) -> Option<f64> {
        None
    }

    fn pressure(&self, row: &Row) -> f64 {
        pressure_at(row).0
    }

    fn energy(&self, stiffness: f64, gap: f64) -> f64 {
        0.5 * stiffness * gap.min(0.0).powi(2)
    }
}

/// Pressure at an iterate, and its derivative.
fn pressure_at(row: &Row) -> (f64, f64) {
    // For a start at `Phi = 0` the quotient is half of the pressure at the end, hence the factor 2.
    if row.end_point { pressure(2.0 * row.stiffness, 0.0, row.gap) } else { pressure(row.stiffness, row.gap_n, row.gap + row.shift) }
}

/// Pressure of the penalty potential over a step, `-(U_1 - U_0)/(Phi_1 - Phi_0)`, and its derivative with respect to `Phi_1`.
fn pressure(kappa: f64, gap_n: f64, gap: f64) -> (f64, f64) {
    if gap_n <= 0.0 && gap <= 0.0 {
        (-0.5 * kappa * (gap_n + gap), -0.5 * kappa)
    } else if gap_n >= 0.0 && gap >= 0.0 {
        (0.0, 0.0)
    } else {
        // One end is open: the numerator is the potential of the other end.
        let (step, closed) = (gap - gap_n, gap.min(0.0).powi(2) - gap_n.min(0.0).powi(2));
        (-0.5 * kappa * closed / step, -0.5 * kappa * (2.0 * gap.min(0.0) - closed / step) / step)
    }
}

#[cfg(test)]
mod tests {
    use super::pressure;

    #[test]
    fn pressure_does_the_work_of_its_potential_and_has_an_exact_derivative() {
        let energy = |gap: f64| 0.5 * 3.0 * gap.min(0.0).powi(2);
        for (gap_n, gap) in [(-0.3, -0.1), (-0.3, 0.2), (0.4, -0.1), (0.4, 0.2), (0.0, -0.2), (-0.2, 0.0)] {
            let (found, slope) = pressure(3.0, gap_n, gap);
            assert!((found * (gap - gap_n) + energy(gap) - energy(gap_n)).abs() < 1e-16);
            assert!(found >= 0.0);
            let h = 1e-6;
            let difference = (pressure(3.0, gap_n, gap + h).0 - pressure(3.0, gap_n, gap - h).0) / (2.0 * h);
            // At a kink (gap = 0) the two sides differ by order kappa h.
            assert!((difference - slope).abs() < 1e-5, "{gap_n} {gap}: {difference} {slope}");
        }
    }
}
