//! Simulations of checks and studies: they write no files and no summary, and may have a moved model.

use std::cell::Cell;
use std::rc::Rc;

use super::motion::Motion;
use crate::script::language::host::Host;

/// Settings of simulations during a check or study.
#[derive(Clone, Copy)]
struct Study {
    motion: Option<Motion>,
}

/// Settings of the check or study in progress.
#[derive(Default)]
struct Current(Cell<Option<Study>>);

/// Ends a check or study when dropped.
pub struct NestedRun {
    current: Rc<Current>,
    before: Option<Study>,
}

impl Drop for NestedRun {
    fn drop(&mut self) {
        self.current.0.set(self.before);
    }
}

/// Begins a check or study, until the result is dropped: simulations write no files and no summary, and are moved by `motion`, or by the
/// motion of an enclosing check.
pub fn begin_study(host: &Host, motion: Option<Motion>) -> NestedRun {
    let current = host.slots.get::<Current>();
    let before = current.0.replace(Some(Study { motion: motion.or(current_motion(host)) }));
    NestedRun { current, before }
}

/// True while simulations are made for a check or study only.
pub fn is_study(host: &Host) -> bool {
    host.slots.get::<Current>().0.get().is_some()
}

/// Returns the motion that is applied to models; `None` if there is none.
pub fn current_motion(host: &Host) -> Option<Motion> {
    host.slots.get::<Current>().0.get().and_then(|study| study.motion)
}
