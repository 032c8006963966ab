//! The constraint rows of Newton's system, as a value.

use crate::dynamics::parts::laws::Equation;

/// Equations of all constraints in Newton's system.
#[derive(Clone)]
pub struct ConstraintRows(pub Vec<Equation>);

impl ConstraintRows {
    /// Equations of `count` inactive constraints: `lambda = 0`.
    pub fn open(count: usize) -> Self {
        ConstraintRows(vec![Equation::OPEN; count])
    }

    /// Equations `G_1 dq = 0` of the constraints that `hold`.
    pub fn held(hold: &[bool]) -> Self {
        ConstraintRows(hold.iter().map(|hold| if *hold { Equation::held(0.0, 0.0) } else { Equation::OPEN }).collect())
    }

    /// Adds a proximal term to the active ones of the first `normal_count` constraints: a compliance for changes of their multipliers from
    /// `lambda`.
    /// Equations of tangential constraints include the term already.
    pub fn add_proximal(&mut self, normal_count: usize, terms: &[f64], lambda: &[f64]) {
        for (row, (term, lambda)) in self.0[..normal_count].iter_mut().zip(terms.iter().zip(lambda)) {
            if row.acts && row.gradient == 1.0 && row.normal == 0.0 {
                row.diagonal += term;
                row.right += term * lambda;
            }
        }
    }
}
