//! Who watches a session: a terminal, a test that keeps what it hears, or nobody.
//!
//! The session says what it prints, checks and warns of; how that looks is the watcher's business.

use super::diagnostics::{Diagnostic, Ink};
use crate::dynamics::LedgerRow;

/// An accepted step, as an observer sees it.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a> {
    /// Name of the model.
    pub model: &'a str,
    /// Time at which the current `run_to` began.
    pub from: f64,
    /// Time at which it ends, if it is known.
    pub until: Option<f64>,
    /// The step.
    pub row: &'a LedgerRow,
    /// Largest `kinetic + strain + |potential|` so far, to relate the defect to.
    pub scale: f64,
    /// Space dimension, by which the row has its columns.
    pub dimension: usize,
}

/// What became of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactChange {
    /// The first of its nodes closed.
    Closed,
    /// The last of its nodes opened.
    Opened,
}

/// Something that happens in a run besides its steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event<'a> {
    /// A step was halved.
    Halved {
        /// Name of the simulation.
        simulation: &'a str,
        /// Why, as in `halvings_by_cause` of the summary, in words.
        cause: &'a str,
        /// The contact whose motion was too large, where that is the cause.
        contact: Option<&'a str>,
        /// How often for this cause in this step.
        count: usize,
        /// The last accepted step before.
        step: usize,
        /// Its time.
        time: f64,
    },
    /// A contact closed or opened as a whole.
    Contact {
        /// Name of the simulation.
        simulation: &'a str,
        /// Name of the contact.
        contact: &'a str,
        /// Which.
        change: ContactChange,
        /// Its nodes in contact now.
        active: usize,
        /// The accepted step.
        step: usize,
        /// Its time.
        time: f64,
    },
    /// `settle` has found equilibrium.
    Settled {
        /// Name of the simulation.
        simulation: &'a str,
        /// Damped steps that it took.
        steps: usize,
        /// Their Newton iterations.
        newton_iterations: usize,
        /// The row of the history that it gave.
        row: &'a LedgerRow,
    },
}

/// Watches a session: what the script prints, what it checks, how far it is.
pub trait Observer {
    /// A line that the script prints.
    fn print(&self, line: &str);
    /// A check that holds, with what it measured.
    fn passed(&self, line: &str);
    /// Something the user should know; the run goes on.
    fn warn(&self, warning: &Diagnostic);
    /// An accepted step.
    fn advanced(&self, progress: &Progress);
    /// Something that happened besides a step; told right before the step that it belongs to.
    fn noticed(&self, _event: &Event) {}
    /// A long computation without steps begins, such as `settle`.
    fn began(&self, what: &str);
    /// A computation that reported progress has ended.
    fn ended(&self);
    /// Whether printed lines may have colors.
    fn ink(&self) -> Ink {
        Ink::Plain
    }
}

/// An observer that looks away.
pub struct Silent;

impl Observer for Silent {
    fn print(&self, _: &str) {}
    fn passed(&self, _: &str) {}
    fn warn(&self, _: &Diagnostic) {}
    fn advanced(&self, _: &Progress) {}
    fn began(&self, _: &str) {}
    fn ended(&self) {}
}
