//! A model under construction, with the places in the script of what it consists of.
//!
//! The places serve the warnings at the end of a run: a load that never acted, contact that never closed.

use std::sync::Arc;

use crate::dynamics::Model;
use crate::script::api::time_functions::Watched;
use crate::script::language::sources::Place;

/// A load with its place in the script, for the warning that it never acted.
#[derive(Clone)]
pub struct LoadNote {
    /// What it is, such as `torque on "inner ring.inner"`.
    pub title: String,
    /// Where it was written.
    pub place: Option<Place>,
    /// Its time function.
    pub amplitude: Arc<Watched>,
}

/// A model under construction, with the places of what it consists of.
#[derive(Clone, Default)]
pub struct ModelData {
    /// The model.
    pub model: Model,
    /// One for each load.
    pub loads: Vec<LoadNote>,
    /// One for each contact pair: its name, and where it was written.
    pub contacts: Vec<(String, Option<Place>)>,
    /// Whether a simulation was made of it.
    pub is_simulated: bool,
    /// Name and place of the first change that no simulation has seen, once there is one.
    pub unseen: Option<(String, Option<Place>)>,
}

impl ModelData {
    /// Where the contact pair of that name was written.
    pub fn place_of_contact(&self, name: &str) -> Option<Place> {
        self.contacts.iter().find(|(known, _)| known == name).and_then(|(_, place)| place.clone())
    }
}
