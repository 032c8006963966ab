//! States before the last steps, to go back to.
//!
//! They are kept where the session can go back: it is interactive, or one of its texts calls `back`, which is known before the first step.

use std::cell::Cell;

use super::handle::{PastState, SimulationHandle};
use crate::script::language::host::Host;

/// Largest memory of the states that a simulation keeps for going back by steps `[bytes]`.
const PAST_BYTES: usize = 64 << 20;

/// Largest number of states that a simulation keeps for going back by steps (`back`).
const PAST_STATES: usize = 1000;

/// Name of the script function that goes back by steps, for which states of earlier steps are kept.
const GOES_BACK: &str = "back";

/// Result of the search for calls of `back` in the texts of the session, and the number of texts searched.
#[derive(Default)]
struct Searched(Cell<Option<(usize, bool)>>);

/// True if the session may go back by steps.
pub fn goes_back(host: &Host) -> bool {
    if host.settings.interactive {
        return true;
    }
    let (count, searched) = (host.sources.count(), host.slots.get::<Searched>());
    if let Some((_, found)) = searched.0.get().filter(|(searched, _)| *searched == count) {
        return found;
    }
    let found = host.sources.all().iter().any(|(_, text)| calls_back(text));
    searched.0.set(Some((count, found)));
    found
}

/// True if a text names the function `back` before a parenthesis, or as the name of a function pointer.
fn calls_back(text: &str) -> bool {
    text.match_indices(GOES_BACK).any(|(at, name)| {
        let (before, after) = (&text[..at], &text[at + name.len()..]);
        let is_part = |c: char| c.is_alphanumeric() || c == '_';
        let is_pointer = before.trim_end_matches('"').trim_end().ends_with("Fn(");
        !before.ends_with(is_part) && (after.trim_start().starts_with('(') || is_pointer)
    })
}

impl SimulationHandle {
    /// Keeps the state before a step where the session can go back; drops the oldest states if they exceed the memory limit.
    pub fn keep_past(&self, host: &Host, mut before: PastState) {
        if !goes_back(host) {
            return;
        }
        let mut past = self.0.past.borrow_mut();
        let last = past.back().and_then(|past| past.state.clone());
        before.size = before.state.as_ref().map_or(0, |state| state.size(last.as_deref()));
        let mut size = before.size + past.iter().map(|past| past.size).sum::<usize>();
        while !past.is_empty() && (past.len() >= PAST_STATES || size > PAST_BYTES) {
            let gone = past.pop_front();
            let first = past.front_mut().unwrap_or(&mut before);
            // The oldest state now owns the data that it shared.
            let alone = first.state.as_ref().map_or(0, |state| state.size(None));
            size = size + alone - first.size - gone.map_or(0, |gone| gone.size);
            first.size = alone;
        }
        past.push_back(before);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_that_calls_the_function_is_told_from_one_that_names_a_boundary() {
        for text in ["sim.back();", "sim . back (3)", "back(sim, 2)", "let f = Fn(\"back\"); f.call(sim)", "// sim.back(2)"] {
            assert!(calls_back(text), "{text}");
        }
        for text in ["plate.boundary(\"back\")", "feedback(2)", "back_stress(x)", "let back = 3;", ""] {
            assert!(!calls_back(text), "{text}");
        }
    }
}
