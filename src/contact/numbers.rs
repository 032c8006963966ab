//! Number types of contact formulas: plain numbers, several numbers at once, and numbers with first derivatives.
//!
//! A [`Jet`] carries a fixed number of derivatives in a plain array; more unknowns take several passes. Numbers of `num-dual` also store
//! the absence of derivatives, which tripled the time of second derivatives of facet pairs in space.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use num_dual::DualNumCopy;

/// Number type of a formula, with or without derivatives.
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
    /// Value without derivatives.
    fn re(self) -> f64;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Reciprocal value.
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

/// `N` numbers that are computed together; branches of a formula are decided by the first number.
#[derive(Clone, Copy, Debug)]
pub struct Each<const N: usize>(pub [f64; N]);

impl<const N: usize> From<f64> for Each<N> {
    #[inline(always)]
    fn from(x: f64) -> Self {
        Each([x; N])
    }
}

impl<const N: usize> Number for Each<N> {
    #[inline(always)]
    fn re(self) -> f64 {
        self.0[0]
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Each(self.0.map(f64::sqrt))
    }

    #[inline(always)]
    fn recip(self) -> Self {
        Each(self.0.map(f64::recip))
    }
}

impl<const N: usize> Neg for Each<N> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Each(self.0.map(|x| -x))
    }
}

/// Elementwise arithmetic, with another `Each` or with a plain number.
macro_rules! of_each {
    ($($trait:ident $name:ident $operator:tt;)*) => { $(
        impl<const N: usize> $trait for Each<N> {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Each(std::array::from_fn(|k| self.0[k] $operator other.0[k]))
            }
        }

        impl<const N: usize> $trait<f64> for Each<N> {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: f64) -> Self {
                Each(self.0.map(|x| x $operator other))
            }
        }
    )* };
}
of_each! { Add add +; Sub sub -; Mul mul *; Div div /; }

/// Addition and subtraction in place.
macro_rules! in_place {
    ($($type:ident $trait:ident $name:ident $operator:tt;)*) => { $(
        impl<const N: usize> $trait for $type<N> {
            #[inline(always)]
            fn $name(&mut self, other: Self) {
                *self = *self $operator other;
            }
        }
    )* };
}
in_place! { Each AddAssign add_assign +; Each SubAssign sub_assign -; Jet AddAssign add_assign +; Jet SubAssign sub_assign -; }

/// Number with its derivatives with respect to `N` unknowns.
#[derive(Clone, Copy, Debug)]
pub struct Jet<const N: usize> {
    /// Value.
    pub re: f64,
    /// Derivatives.
    pub eps: [f64; N],
}

impl<const N: usize> Jet<N> {
    /// Unknown with derivative 1 in the given lane; a constant if `lane` is `None`.
    #[inline(always)]
    pub fn unknown(re: f64, lane: Option<usize>) -> Self {
        Jet { re, eps: std::array::from_fn(|k| if Some(k) == lane { 1.0 } else { 0.0 }) }
    }

    /// Chain rule: function value `re` and derivative `slope`.
    #[inline(always)]
    fn chain(self, re: f64, slope: f64) -> Self {
        Jet { re, eps: self.eps.map(|eps| eps * slope) }
    }

    #[inline(always)]
    fn with(self, other: Self, re: f64, eps: impl Fn(f64, f64) -> f64) -> Self {
        Jet { re, eps: std::array::from_fn(|k| eps(self.eps[k], other.eps[k])) }
    }

    #[inline(always)]
    fn product(self, other: Self) -> Self {
        self.with(other, self.re * other.re, |a, b| a * other.re + b * self.re)
    }

    #[inline(always)]
    fn quotient(self, other: Self) -> Self {
        let inverse = other.re.recip();
        self.with(other, self.re * inverse, |a, b| (a * other.re - b * self.re) * inverse * inverse)
    }
}

impl<const N: usize> From<f64> for Jet<N> {
    #[inline(always)]
    fn from(re: f64) -> Self {
        Jet { re, eps: [0.0; N] }
    }
}

impl<const N: usize> Add for Jet<N> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.with(other, self.re + other.re, |a, b| a + b)
    }
}

impl<const N: usize> Sub for Jet<N> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.with(other, self.re - other.re, |a, b| a - b)
    }
}

impl<const N: usize> Mul for Jet<N> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.product(other)
    }
}

impl<const N: usize> Div for Jet<N> {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.quotient(other)
    }
}

impl<const N: usize> Neg for Jet<N> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Jet { re: -self.re, eps: self.eps.map(|eps| -eps) }
    }
}

impl<const N: usize> Add<f64> for Jet<N> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: f64) -> Self {
        Jet { re: self.re + other, ..self }
    }
}

impl<const N: usize> Sub<f64> for Jet<N> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: f64) -> Self {
        Jet { re: self.re - other, ..self }
    }
}

impl<const N: usize> Mul<f64> for Jet<N> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self.chain(self.re * other, other)
    }
}

impl<const N: usize> Mul<Jet<N>> for f64 {
    type Output = Jet<N>;

    #[inline(always)]
    fn mul(self, other: Jet<N>) -> Jet<N> {
        other * self
    }
}

impl<const N: usize> Number for Jet<N> {
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
