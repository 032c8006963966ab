//! Variables of an energy: invariants of `C = F^T F`, components of the strain, functions of the principal stretches.

/// Bit pattern of a number, as a key of tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Bits(u64);

impl Bits {
    pub(super) fn of(value: f64) -> Self {
        // Zeros of both signs have one bit pattern.
        Bits(if value == 0.0 { 0 } else { value.to_bits() })
    }

    pub(super) fn value(self) -> f64 {
        f64::from_bits(self.0)
    }
}

/// Variable of an energy: zero at zero strain up to a constant, with hand-written derivatives with respect to the strain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Variable {
    /// First invariant `tr C`.
    I1,
    /// Second invariant `((tr C)^2 - tr C^2)/2`.
    I2,
    /// Volume ratio `det F`.
    J,
    /// `a.C.a` along the unit vector `a` of a fiber in the undeformed state.
    Fiber(usize),
    /// Component of the Green-Lagrange strain, as an index among the Mandel components in space.
    Strain(usize),
    /// `l1^a + l2^a + l3^a` of the principal stretches.
    StretchPower(Bits),
    /// Squared norm of the logarithmic strain, `(ln l1)^2 + (ln l2)^2 + (ln l3)^2`.
    LogStrainSquared,
}

impl Variable {
    /// Value at zero strain.
    pub(super) fn rest(self) -> f64 {
        match self {
            Variable::I1 | Variable::I2 | Variable::StretchPower(_) => 3.0,
            Variable::J | Variable::Fiber(_) => 1.0,
            Variable::Strain(_) | Variable::LogStrainSquared => 0.0,
        }
    }
}
