//! A unit of any dimension and size.

use super::dimension::Dimension;
use super::scale::Scale;

/// A unit: its dimension and its size in units of the SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Dimension.
    pub dimension: Dimension,
    /// Size.
    pub scale: Scale,
}

impl Unit {
    /// A number without unit.
    pub const ONE: Unit = Unit { dimension: Dimension([0; 3]), scale: Scale::ONE };

    /// Product with a power of another unit.
    pub fn times(self, other: Unit, power: i32) -> Self {
        Unit { dimension: self.dimension.times(other.dimension, power), scale: self.scale.times(other.scale, power) }
    }
}
