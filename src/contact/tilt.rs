//! Tilt of the rim of a cylinder relative to a plane: the height by which its lowest point is nearer to the plane than its center
//! (`rolling.rs`).

use crate::integrators::{Configuration, Derivative};
use crate::math::tolerances::{RIM_FLAT, RIM_LEAST};

/// Tilt of a rim with axis `a` relative to the normal `n` of an obstacle: `s = n.a`, `h(s) = sqrt(1 - s^2)` and `h'(s)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tilt {
    sine: f64,
    pub height: f64,
    pub slope: f64,
}

impl Tilt {
    pub fn of(sine: f64) -> Self {
        // A rim that becomes flat within a step keeps a small height, since `h` has a cusp at zero.
        let height = (1.0 - sine * sine).max(RIM_LEAST * RIM_LEAST).sqrt();
        Tilt { sine, height, slope: -sine / height }
    }

    /// True for a rim that lies flat, so that nodal constraints act instead.
    pub fn is_flat(&self) -> bool {
        self.height <= RIM_FLAT
    }

    /// Derivative of `h` for the forces of a step from `self` to `end`: discrete, or at a configuration; and its derivative with respect to
    /// `s` at the end.
    pub fn to(self, end: Tilt, derivative: Derivative) -> [f64; 2] {
        let plain = |at: Tilt, share: f64| [at.slope, -share / at.height.powi(3)];
        match derivative {
            Derivative::DiscreteGradient => {
                let sum = self.height + end.height;
                if end.height == RIM_LEAST {
                    let way = end.sine - self.sine;
                    return [(end.height - self.height) / way, 0.0];
                }
                let slope = -(self.sine + end.sine) / sum;
                [slope, (-1.0 - slope * end.slope) / sum]
            }
            Derivative::Gradient(Configuration::Middle) => plain(Tilt::of(0.5 * (self.sine + end.sine)), Configuration::Middle.share()),
            Derivative::Gradient(Configuration::End) => plain(end, Configuration::End.share()),
        }
    }
}
