//! A motion of a contact that is too large for one step.

use serde::{Deserialize, Serialize};

#[cfg(doc)]
use crate::math::tolerances;

/// What motion in a step is too large.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum MotionKind {
    /// Surfaces in contact would slide beyond [`tolerances::SLIDING`].
    Sliding,
    /// Bodies would approach each other beyond [`tolerances::APPROACH`] under the persistency rule.
    Approach,
    /// They have done so in a converged step, beyond [`tolerances::CAME_THROUGH`].
    CameThrough,
    /// A rigid obstacle and nodes would pass, or have passed, each other beyond [`tolerances::PASSING`].
    Passing,
}

impl MotionKind {
    /// Its stable name.
    pub fn name(self) -> &'static str {
        MotionKind::NAMES[match self {
            MotionKind::Sliding => 0,
            MotionKind::Approach => 1,
            MotionKind::CameThrough => 2,
            MotionKind::Passing => 3,
        }]
    }

    /// All names.
    pub const NAMES: &'static [&'static str] = &["sliding", "approach", "came_through", "passing"];
}

/// A motion for which a step is halved although Newton's method did not fail.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LargeMotion {
    /// Name of the contact.
    pub contact: String,
    /// What it is.
    pub kind: MotionKind,
    /// How far within the step, in secondary facets.
    pub facets: f64,
}
