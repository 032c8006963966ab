//! Composition of the energy-momentum scheme to order four, the triple jump: three of its steps, the second one backward in time (Creutz
//! and Gocksch, Phys. Rev. Lett. 63, 1989; Yoshida, Phys. Lett. A 150, 1990; Hairer, Lubich and Wanner, Geometric Numerical Integration,
//! 2006, section II.4).
//!
//! ```text
//! c dt, (1 - 2 c) dt, c dt,    c = 1 / (2 - 2^(1/3)) = 1.3512
//! ```
//!
//! The error of a symmetric second-order scheme has odd powers of the step; these fractions cancel the cubes, `2 c^3 + (1 - 2 c)^3 = 0`.
//! The step conserves what each stage conserves. Dissipation would supply energy in the middle stage.

use super::energy_momentum::ROW;
use super::scheme::{ConservedQuantities, LeadingError, Scheme, StepKind};

/// Cube root of 2.
const CUBE_ROOT_OF_TWO: f64 = 1.259_921_049_894_873_2;

/// First and last step as fractions `c` of the whole step.
const OUTER: f64 = 1.0 / (2.0 - CUBE_ROOT_OF_TWO);

static STAGES: [(f64, Scheme); 3] = [(OUTER, STAGE), (1.0 - 2.0 * OUTER, STAGE), (OUTER, STAGE)];

const STAGE: Scheme = Scheme {
    name: "triple_jump",
    summary: "energy-momentum scheme in three stages, the middle one back in time, of fourth order: conserves energy, linear and angular \
              momentum, for smooth motions with high accuracy; the model must not dissipate energy",
    promises: ConservedQuantities { order: 4, ..ROW.promises },
    // Leading errors of the composition have a higher order.
    error: LeadingError { first: 0.0, second: 0.0 },
    ..ROW
};

/// Triple jump: conserves energy, linear and angular momentum exactly.
pub static TRIPLE_JUMP: Scheme = Scheme { step: StepKind::Stages(&STAGES), ..STAGE };
