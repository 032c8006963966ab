//! Numbers that formulas of contact are written for: plain ones, and ones that carry derivatives.
//!
//! A [`Jet`] is a plain array of derivatives, a few at a time ([`LANES`]): it fits into registers, and more unknowns are more passes. Those
//! of the library `num-dual` know whether they have any derivatives, and take five times as long for it.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use num_dual::DualNumCopy;

/// Derivatives that one pass finds.
pub const LANES: usize = 8;

/// A number, or one with derivatives.
pub trait Number:
    Copy
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    /// Its value.
    fn re(self) -> f64;
    /// Its square root.
    fn sqrt(self) -> Self;
    /// One over it.
    fn recip(self) -> Self;
}

impl<T: DualNumCopy<Primitive = f64>> Number for T {
    #[inline(always)]
    fn re(self) -> f64 {
        num_dual::DualStruct::re(&self)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        num_dual::DualNum::sqrt(&self)
    }

    #[inline(always)]
    fn recip(self) -> Self {
        num_dual::DualNum::recip(&self)
    }
}

/// A number with its derivatives with respect to some unknowns.
#[derive(Clone, Copy, Debug)]
pub struct Jet {
    /// The number.
    pub re: f64,
    /// Its derivatives.
    pub eps: [f64; LANES],
}

impl Jet {
    /// An unknown: the one of that lane, if any.
    #[inline(always)]
    pub fn unknown(re: f64, lane: Option<usize>) -> Self {
        Jet { re, eps: std::array::from_fn(|k| if Some(k) == lane { 1.0 } else { 0.0 }) }
    }

    /// A function of it, by its value and its derivative.
    #[inline(always)]
    fn chain(self, re: f64, slope: f64) -> Self {
        Jet { re, eps: self.eps.map(|eps| eps * slope) }
    }

    #[inline(always)]
    fn with(self, other: Self, re: f64, eps: impl Fn(f64, f64) -> f64) -> Self {
        Jet { re, eps: std::array::from_fn(|k| eps(self.eps[k], other.eps[k])) }
    }
}

impl From<f64> for Jet {
    #[inline(always)]
    fn from(re: f64) -> Self {
        Jet { re, eps: [0.0; LANES] }
    }
}

impl Add for Jet {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.with(other, self.re + other.re, |a, b| a + b)
    }
}

impl Sub for Jet {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.with(other, self.re - other.re, |a, b| a - b)
    }
}

impl Mul for Jet {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.with(other, self.re * other.re, |a, b| a * other.re + b * self.re)
    }
}

impl Div for Jet {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let inverse = other.re.recip();
        self.with(other, self.re * inverse, |a, b| (a * other.re - b * self.re) * inverse * inverse)
    }
}

impl Neg for Jet {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Jet { re: -self.re, eps: self.eps.map(|eps| -eps) }
    }
}

impl AddAssign for Jet {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Jet {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Add<f64> for Jet {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: f64) -> Self {
        Jet { re: self.re + other, ..self }
    }
}

impl Sub<f64> for Jet {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: f64) -> Self {
        Jet { re: self.re - other, ..self }
    }
}

impl Mul<f64> for Jet {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self.chain(self.re * other, other)
    }
}

impl Number for Jet {
    #[inline(always)]
    fn re(self) -> f64 {
        self.re
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.re.sqrt();
        self.chain(root, root * self.re.recip() * 0.5)
    }

    #[inline(always)]
    fn recip(self) -> Self {
        let inverse = self.re.recip();
        self.chain(inverse, -inverse * inverse)
    }
}
