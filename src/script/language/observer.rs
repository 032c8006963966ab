//! Observers of a session: a terminal, a test that collects messages, or none.
//!
//! The session passes printed lines, checks and warnings on; the observer decides on their presentation.

use super::diagnostics::{Diagnostic, Ink};
use crate::dynamics::LedgerRow;

/// An accepted step, for observers.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a> {
    /// Name of the model.
    pub model: &'a str,
    /// Time at which the current `run_to` began.
    pub from: f64,
    /// Time at which stepping ends, if known.
    pub until: Option<f64>,
    /// Row of the accepted step.
    pub row: &'a LedgerRow,
    /// Largest `kinetic + strain + |potential|` so far, to relate the defect to.
    pub scale: f64,
    /// Space dimension, which determines the columns of the row.
    pub dimension: usize,
}

/// Change of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactChange {
    /// The first node of the contact became active.
    Closed,
    /// The last active node of the contact became inactive.
    Opened,
}

/// Event of a run besides its steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event<'a> {
    /// A step was halved.
    Halved {
        /// Name of the simulation.
        simulation: &'a str,
        /// Cause in words, as in `halvings_by_cause` of the summary.
        cause: &'a str,
        /// Contact whose motion was too large, if that is the cause.
        contact: Option<&'a str>,
        /// Number of halvings by this cause in this step.
        count: usize,
        /// Last accepted step before the halved one.
        step: usize,
        /// Time of the last accepted step.
        time: f64,
    },
    /// A contact closed or opened as a whole.
    Contact {
        /// Name of the simulation.
        simulation: &'a str,
        /// Name of the contact.
        contact: &'a str,
        /// Closing or opening.
        change: ContactChange,
        /// Number of active nodes.
        active: usize,
        /// Accepted step in which the contact closed or opened.
        step: usize,
        /// Time of the step.
        time: f64,
    },
    /// `settle` has found equilibrium.
    Settled {
        /// Name of the simulation.
        simulation: &'a str,
        /// Number of damped steps.
        steps: usize,
        /// Number of Newton iterations of these steps.
        newton_iterations: usize,
        /// Row of the equilibrium in the history.
        row: &'a LedgerRow,
    },
}

/// Observer of a session: printed lines, checks, progress. Reports without a function are ignored.
pub trait Observer {
    /// Shows a line printed by the script.
    fn print(&self, _line: &str) {}
    /// Reports a check that holds, with its measured value.
    fn passed(&self, _line: &str) {}
    /// Reports a warning; the run continues.
    fn warn(&self, _warning: &Diagnostic) {}
    /// An accepted step.
    fn advanced(&self, _progress: &Progress) {}
    /// Reports an event, right before the step to which it belongs.
    fn noticed(&self, _event: &Event) {}
    /// Reports the start of a long computation without steps, such as `settle`.
    fn began(&self, _what: &str) {}
    /// Reports the end of a computation that reported progress.
    fn ended(&self) {}
    /// Returns the rendering of printed lines; plain by default.
    fn ink(&self) -> Ink {
        Ink::Plain
    }
}

/// Observer that ignores all reports.
pub struct Silent;

impl Observer for Silent {}
