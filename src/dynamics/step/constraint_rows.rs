//! The constraint rows of Newton's system, as a value.

use crate::dynamics::parts::laws::Equation;

/// The equations of all constraint rows in Newton's system.
#[derive(Clone)]
pub struct ConstraintRows(pub Vec<Equation>);

impl ConstraintRows {
    /// All of `count` open: `lambda = 0`.
    pub fn open(count: usize) -> Self {
        ConstraintRows(vec![Equation::OPEN; count])
    }

    /// Rows that `hold`: `G_1 dq = 0`.
    pub fn held(hold: &[bool]) -> Self {
        ConstraintRows(hold.iter().map(|hold| if *hold { Equation::held(0.0, 0.0) } else { Equation::OPEN }).collect())
    }

    /// Adds a proximal term to the first `pressing` rows, as far as they hold: their weighted gaps give way by so much per change of their
    /// multipliers from `lambda`. Tangential rows have it in their equations.
    pub fn add_proximal(&mut self, pressing: usize, terms: &[f64], lambda: &[f64]) {
        for (row, (term, lambda)) in self.0[..pressing].iter_mut().zip(terms.iter().zip(lambda)) {
            if row.acts && row.gradient == 1.0 && row.normal == 0.0 {
                row.diagonal += term;
                row.right += term * lambda;
            }
        }
    }
}
