//! A motion of a contact that is too large for one step.

use serde::{Deserialize, Serialize};

#[cfg(doc)]
use crate::math::tolerances;

/// Motion of a contact that is too large for one step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum MotionKind {
    /// Surfaces in contact would slide beyond [`tolerances::SLIDING`].
    Sliding,
    /// Bodies would approach each other beyond [`tolerances::APPROACH`] under the persistency rule.
    Approach,
    /// Bodies have penetrated each other in a converged step beyond [`tolerances::CAME_THROUGH`].
    CameThrough,
    /// A rigid obstacle and nodes would pass, or have passed, each other beyond [`tolerances::PASSING`].
    Passing,
}

impl MotionKind {
    /// Stable name of the kind of motion.
    pub fn name(self) -> &'static str {
        MotionKind::NAMES[match self {
            MotionKind::Sliding => 0,
            MotionKind::Approach => 1,
            MotionKind::CameThrough => 2,
            MotionKind::Passing => 3,
        }]
    }

    /// Names of all kinds of motion.
    pub const NAMES: &'static [&'static str] = &["sliding", "approach", "came_through", "passing"];
}

/// A motion for which a step is halved although Newton's method did not fail.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LargeMotion {
    /// Name of the contact.
    pub contact: String,
    /// Kind of motion.
    pub kind: MotionKind,
    /// Motion within the step, relative to the secondary facet length.
    pub facets: f64,
}
