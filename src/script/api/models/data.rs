//! A model under construction, with the places of its definitions in the script.
//!
//! The places serve the warnings at the end of a run: a load that never acted, contact that never closed.

use std::sync::Arc;

use crate::dynamics::Model;
use crate::script::api::time_functions::RecordedTimeFunction;
use crate::script::language::sources::SourceSpan;

/// Load with the position of its definition in the script, for the warning about a load that never acted.
#[derive(Clone)]
pub struct LoadNote {
    /// Description of the load, such as `torque on "inner ring.inner"`.
    pub title: String,
    /// Dimension of the load.
    pub dimension: &'static str,
    /// Position of the definition in the script.
    pub place: Option<SourceSpan>,
    /// Time function of the load.
    pub amplitude: Arc<RecordedTimeFunction>,
}

/// Model under construction, with the positions of its definitions in the script.
#[derive(Clone, Default)]
pub struct ModelData {
    /// The model.
    pub model: Model,
    /// Loads with the positions of their definitions in the script.
    pub loads: Vec<LoadNote>,
    /// Contact pairs by name, with the positions of their definitions in the script.
    pub contacts: Vec<(String, Option<SourceSpan>)>,
    /// True if a simulation was made of the model.
    pub is_simulated: bool,
    /// Name and script position of the first change after the last simulation.
    pub unseen: Option<(String, Option<SourceSpan>)>,
}

impl ModelData {
    /// Returns the script position of the definition of a contact pair.
    pub fn place_of_contact(&self, name: &str) -> Option<SourceSpan> {
        self.contacts.iter().find(|(known, _)| known == name).and_then(|(_, place)| place.clone())
    }
}
