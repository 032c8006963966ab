//! Simulations aside of the run: a check that runs a scenario for itself wants no files, no summary, and perhaps a moved model.

use std::cell::Cell;
use std::rc::Rc;

use super::motion::Motion;
use crate::script::language::host::Host;

/// What holds while a check runs a scenario for itself.
#[derive(Clone, Copy)]
struct Study {
    motion: Option<Motion>,
}

/// The check that runs now, if one does.
#[derive(Default)]
struct Current(Cell<Option<Study>>);

/// Ends a study when it goes out of scope.
pub struct NestedRun {
    current: Rc<Current>,
    before: Option<Study>,
}

impl Drop for NestedRun {
    fn drop(&mut self) {
        self.current.0.set(self.before);
    }
}

/// While the returned value lives, simulations are aside of the run: no files, no summary, and moved if a motion is given (or was
/// already).
pub fn begin_study(host: &Host, motion: Option<Motion>) -> NestedRun {
    let current = host.slots.get::<Current>();
    let before = current.0.replace(Some(Study { motion: motion.or(current_motion(host)) }));
    NestedRun { current, before }
}

/// Whether simulations are made for a check only.
pub fn is_study(host: &Host) -> bool {
    host.slots.get::<Current>().0.get().is_some()
}

/// How models are moved now.
pub fn current_motion(host: &Host) -> Option<Motion> {
    host.slots.get::<Current>().0.get().and_then(|study| study.motion)
}
