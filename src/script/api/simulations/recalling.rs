//! Computations taken from the journal, and checkpoints of all simulations: the connection of the [journal](Journal) with the simulations.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Instant;

use super::artifacts::Artifacts;
use super::handle::{PastState, SimulationHandle, Simulations};
use super::journal::{Journal, is_kept, of_another_model, something_else, unreadable};
use crate::dynamics::{State, Tally, TimeFunction};
use crate::output::checkpoint::SavedSimulation;
use crate::output::journal::{Computation, Entry, Outcome};
use crate::output::shapes;
use crate::script::api::files::failures::output_failure;
use crate::script::api::files::run_folder::RunFolder;
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::prelude::*;

impl Journal {
    /// Writes a checkpoint before a long computation whose results are kept elsewhere ([`PointLog`](crate::output::PointLog)).
    ///
    /// # Errors
    /// An interrupt, or a result that cannot be written.
    pub fn secure(&self, host: &Host) -> Result<(), Failure> {
        if self.is_recalling() {
            return Ok(());
        }
        go_on(host)?;
        self.write(host)
    }

    /// Returns the next computation of the journal, which must be `computation`.
    fn next(&self, host: &Host, simulation: usize, computation: Computation) -> Result<(Outcome, Tally), Failure> {
        match self.next_event(host)? {
            Some(Entry::Computed { simulation: known, computation: asked, outcome, tally })
                if (known, asked) == (simulation, computation) =>
            {
                self.0.borrow_mut().repeats = outcome == Outcome::Failed;
                Ok((outcome, *tally))
            }
            _ => Err(something_else()),
        }
    }

    /// Returns the next computation or return to a state of the journal; states before it are set in their simulations.
    fn next_event(&self, host: &Host) -> Result<Option<Entry>, Failure> {
        while let Some((other, state)) = self.next_state(None)? {
            let handle = Simulations::of(host).0.borrow().get(other).cloned().ok_or_else(something_else)?;
            handle.adopt_point(&state)?;
        }
        let mut pages = self.0.borrow_mut();
        pages.left = pages.left.saturating_sub(1);
        pages.earlier.as_mut().map_or(Ok(None), |reader| reader.take().map_err(|error| unreadable(&error)))
    }

    /// Writes a checkpoint of all simulations. A checkpoint that cannot be written is reported once, and the run continues.
    ///
    /// # Errors
    /// A result that cannot be written.
    pub fn write(&self, host: &Host) -> Result<(), Failure> {
        let begun = Instant::now();
        let Some(files) = RunFolder::of(host).files(host).map_err(|error| output_failure(&error))? else { return Ok(()) };
        let Some(simulations) = simulations(host)? else { return Ok(()) };
        let mut pages = self.0.borrow_mut();
        let written = pages.write(host, &files, simulations);
        pages.new = 0;
        pages.last = Some((Instant::now(), begun.elapsed()));
        let told = written.err().filter(|_| !std::mem::replace(&mut pages.is_told, true));
        drop(pages);
        told.iter().for_each(|error| {
            let warning = Diagnostic::warning("the run cannot be resumed from here: a checkpoint could not be written", None);
            // The warning is not written to the files of the run, whose results are unaffected.
            host.observer.warn(&warning.code(error.code()).cause(error.to_string()).hint(format!("the run goes on; {}", error.hint())));
        });
        Ok(())
    }

    /// Writes a last checkpoint of an interrupted run, if there are new computations.
    ///
    /// # Errors
    /// A result that cannot be written.
    pub fn close(&self, host: &Host) -> Result<(), Failure> {
        let is_new = !self.is_recalling() && self.0.borrow().new > 0;
        if is_new && is_kept(host) { self.write(host) } else { Ok(()) }
    }
}

/// Returns the present data of the simulations; `None` during a step.
fn simulations(host: &Host) -> Result<Option<Vec<SavedSimulation>>, Failure> {
    let mut simulations = Vec::new();
    for handle in Simulations::of(host).0.borrow().iter() {
        let Ok(simulation) = handle.0.simulation.try_borrow() else { return Ok(None) };
        // Frames to which the checkpoint refers must be on disk before it.
        handle.0.artifacts.borrow_mut().as_mut().map_or(Ok(()), |artifacts| artifacts.wait())?;
        let rows = handle.0.artifacts.borrow_mut().as_mut().and_then(Artifacts::digest);
        let (row, past) = (simulation.row(), handle.0.past.borrow());
        simulations.push(SavedSimulation {
            name: handle.0.name.clone(),
            unknowns: simulation.unknowns(),
            reached: (row.step, row.time),
            tally: simulation.tally(),
            state: Some(simulation.shared_state()),
            past: known_states(&past),
            recording: handle.0.artifacts.borrow().as_ref().map(|artifacts| artifacts.recording().clone()),
            rows,
        });
    }
    Ok(Some(simulations))
}

/// Returns the states before the last steps, the newest last, up to the first unknown one.
fn known_states(past: &VecDeque<PastState>) -> Vec<Arc<State>> {
    let mut known: Vec<Arc<State>> = past.iter().rev().map_while(|past| past.state.clone()).collect();
    known.reverse();
    known
}

impl SimulationHandle {
    fn adopt_point(&self, state: &State) -> Result<(), Failure> {
        let Ok(mut simulation) = self.0.simulation.try_borrow_mut() else { return Ok(()) };
        if !simulation.fits(state) {
            return Err(of_another_model());
        }
        simulation.restore(state);
        self.0.is_behind.set(false);
        self.0.is_known.set(true);
        Ok(())
    }

    /// Returns the outcome of a computation made by an earlier process, whose row the solver then has. `None` if the computation has to
    /// be made.
    ///
    /// # Errors
    /// The computation differs from the one in the run that is resumed.
    pub fn recalled(&self, call: &Call, computation: Computation) -> Result<Option<Outcome>, Failure> {
        if !Journal::of(call.host).is_recalling() {
            go_on(call.host)?;
            return Ok(None);
        }
        let Some((journal, number)) = self.0.journal.clone() else { return Ok(None) };
        let (outcome, tally) = journal.next(call.host, number, computation)?;
        if outcome == Outcome::Failed {
            // A failed computation is repeated from the state before.
            return Ok(None);
        }
        self.0.is_behind.set(true);
        self.0.is_known.set(false);
        let Ok(mut simulation) = self.0.simulation.try_borrow_mut() else { return Ok(Some(outcome)) };
        simulation.count_from(&tally);
        if let Outcome::Stepped(rows) = &outcome {
            rows.last().into_iter().for_each(|row| simulation.recall(row));
            // Evaluating the loads marks those with nonzero values.
            let asked = || rows.iter().flat_map(|row| [row.time - 0.5 * row.dt, row.time]);
            let idle = self.0.model.loads.iter().filter(|load| !load.amplitude.has_acted());
            idle.for_each(|load| asked().for_each(|time| drop(load.amplitude.value(time))));
        }
        Ok(Some(outcome))
    }

    /// Records a computation in the journal; for a failed one also the state at its start.
    pub fn take_down(&self, computation: Computation, outcome: Outcome, before: &Arc<State>, tally: Tally) {
        let Some((journal, simulation)) = self.0.journal.as_ref().map(|(journal, number)| (journal, *number)) else { return };
        let has_failed = outcome == Outcome::Failed;
        if has_failed && !self.0.is_known.get() {
            journal.keep(simulation, before.clone());
        }
        journal.add(&Entry::Computed { simulation, computation, outcome, tally: Box::new(tally) });
        self.0.is_known.set(has_failed);
    }

    /// Records that the simulation has returned to a kept state, unless a resumed run finds this event in its journal.
    ///
    /// # Errors
    /// The script requests another computation than in the run that is resumed; a file that cannot be written.
    pub fn record_return(&self, host: &Host) -> Result<(), Failure> {
        let Some((journal, simulation)) = self.0.journal.as_ref().map(|(journal, number)| (journal, *number)) else { return Ok(()) };
        let event = Entry::WentBack { simulation };
        if !journal.is_recalling() {
            go_on(host)?;
            journal.add(&event);
        } else if journal.next_event(host)? != Some(event) {
            return Err(something_else());
        }
        Ok(())
    }

    /// Records the present state before the script reads more than the history row of its step: a resumed run then needs the state.
    ///
    /// # Errors
    /// The script requests another computation than in the run that is resumed.
    pub fn looked(&self) -> Result<(), Failure> {
        let data = &self.0;
        let Some((journal, number)) = data.journal.as_ref().filter(|_| !data.is_known.get()) else { return Ok(()) };
        if data.is_behind.get() {
            let (_, state) = journal.next_state(Some(*number))?.ok_or_else(something_else)?;
            return self.adopt_point(&state);
        }
        // During a step, there is no state to record.
        if let Ok(simulation) = data.simulation.try_borrow() {
            journal.keep(*number, simulation.shared_state());
            data.is_known.set(true);
        }
        Ok(())
    }

    /// Returns the state before one of the last steps.
    ///
    /// # Errors
    /// The state was not kept.
    pub fn past_state(&self, call: &Call, index: usize) -> Result<Arc<State>, Failure> {
        let past = self.0.past.borrow()[index].clone();
        match (past.state, self.0.journal.as_ref().filter(|_| !past.is_known)) {
            (Some(state), None) => Ok(state),
            (Some(state), Some((journal, number))) => {
                journal.keep(*number, state.clone());
                Ok(state)
            }
            (None, journal) => {
                let known = journal.map_or(Ok(None), |(journal, number)| journal.next_state(Some(*number)))?;
                let missing =
                    || call.refuse(causes::TIME, "the state to go back to is not in the checkpoint from which the run was resumed");
                let hint = "keep a state with `sim.save()` and go back to it with `sim.restore(state)`, or run the script anew";
                known.map(|(_, state)| state).ok_or_else(|| missing().hint(hint))
            }
        }
    }

    /// Prepares the present state for access by the script, so that fields and gaps depend on the state only.
    pub fn show(&self) {
        if let Ok(mut simulation) = self.0.simulation.try_borrow_mut()
            && !self.0.is_behind.get()
        {
            simulation.look();
        }
    }

    /// Writes a checkpoint if due.
    ///
    /// # Errors
    /// A result that cannot be written.
    pub fn checkpoint(&self, host: &Host) -> Result<(), Failure> {
        let journal = Journal::of(host);
        if journal.is_due(host) { journal.write(host) } else { Ok(()) }
    }
}

/// Ends recalling: sets the simulations and their counters to the end of the journal; their files grow again. Called after all computations
/// of an earlier process have been written to the files.
///
/// # Errors
/// A file that cannot be written; a state of another model.
pub fn go_on(host: &Host) -> Result<(), Failure> {
    let journal = Journal::of(host);
    if journal.is_recalling() {
        return Ok(());
    }
    let simulations = std::mem::take(&mut journal.0.borrow_mut().simulations);
    for (handle, saved) in Simulations::of(host).0.borrow().iter().zip(simulations) {
        let data = &handle.0;
        if let Ok(mut simulation) = data.simulation.try_borrow_mut() {
            if let Some(state) = saved.state.filter(|_| data.is_behind.get()) {
                if !simulation.fits(&state) {
                    return Err(of_another_model());
                }
                simulation.restore(&state);
                data.is_behind.set(false);
            }
            simulation.count_from(&saved.tally);
        }
        for (past, state) in data.past.borrow_mut().iter_mut().rev().zip(saved.past.into_iter().rev()) {
            past.state.get_or_insert(state);
        }
        handle.warn_of_large_motion(host);
        if let (Some(artifacts), Some(recording)) = (data.artifacts.borrow_mut().as_mut(), saved.recording) {
            let history = data.history.borrow();
            if !artifacts.recording().goes_on_with(&recording, history.len(), shapes(&data.model.model).len()) {
                return Err(of_another_model());
            }
            artifacts.go_on(recording, &history, saved.rows)?;
        }
    }
    Ok(())
}
