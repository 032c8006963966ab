//! Report that follows a running simulation: data handed over by the run, and the snapshots served to readers.
//!
//! The run's thread adds rows and stills through a [`LiveSimulation`], and never waits for a reader: while a reader holds the lock, updates
//! are buffered. Readers take references under the lock and encode without it. Memory is bounded: stills are those of the recording, and of
//! a long history the peaks are kept as in a report ([`kept_rows`](super::kept_rows)).

use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::followed::TrackedEntries;
use super::marks::Mark;
use super::rows::{MEASURES, ROWS, measures};
use super::tables::ReportTable;
use crate::dynamics::{BodyDefinition, LedgerRow, PlacedObstacle};
use crate::output::recording::{Skin, Still};
use crate::output::still_fields::StillOptions;
use crate::output::units::ListedUnits;

/// Least time between two updates of a simulation's problem.
const BETWEEN_LOOKS: Duration = Duration::from_secs(1);

/// Constant data of a simulation: names, bodies, recorded nodes, obstacle shapes.
#[derive(Clone, Debug)]
pub struct LiveModel {
    /// Name of the simulation.
    pub name: String,
    /// Names of the contacts.
    pub contacts: Vec<String>,
    /// The bodies.
    pub bodies: Vec<BodyDefinition>,
    /// Recorded nodes of each body.
    pub skins: Vec<Skin>,
    /// Content of the stills (recorded animation frames).
    pub shown: StillOptions,
    /// The different shapes of rigid obstacles.
    pub obstacles: Vec<PlacedObstacle>,
    /// Units of columns and fields; `None` where none are declared.
    pub units: Option<ListedUnits>,
    /// Symbols of supports, loads, springs and joints.
    pub marks: Vec<Mark>,
}

/// Description of a simulation's problem in the report; a script may extend the description during the run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LiveProblem {
    /// Names and texts of the script and its modules, the script first.
    pub scripts: Vec<(String, String)>,
    /// Values of `param(...)` by name.
    pub parameters: BTreeMap<String, Value>,
    /// Tables of the model: bodies, supports, loads, time integration.
    pub tables: Vec<ReportTable>,
}

/// Outcome of a run or of a simulation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LiveOutcome {
    /// Outcome in words.
    pub words: String,
    /// True if the run or simulation ended as intended.
    pub is_well: bool,
}

/// A row of the history.
#[derive(Debug)]
pub struct LiveRow {
    /// Row number within the history.
    pub number: usize,
    /// Values of the history's columns; NaN for a missing value.
    pub values: Vec<f64>,
    measures: [f64; MEASURES],
}

/// Snapshot of a simulation for readers.
#[derive(Clone)]
pub struct FollowedSimulation {
    /// Constant data of the simulation.
    pub model: Arc<LiveModel>,
    /// Names of the history's columns.
    pub columns: Arc<Vec<String>>,
    /// Number of the change that last replaced the model or added columns.
    pub shaped: u64,
    /// Problem, and the revision number of its last change.
    pub problem: (u64, Arc<LiveProblem>),
    /// Rows that are kept.
    pub rows: TrackedEntries<Arc<LiveRow>>,
    /// Number of rows of the whole history.
    pub row_count: usize,
    /// Length of the intervals of which only the last row and the peaks are kept.
    stretch: usize,
    /// Stills (recorded animation frames) of the simulation.
    pub stills: TrackedEntries<Arc<Still>>,
    /// Findings of the run, and the number of the change that last updated them.
    pub findings: (u64, Vec<String>),
    /// Outcome; `None` while the simulation runs.
    pub outcome: Option<LiveOutcome>,
}

/// Current activity of the run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Activity {
    /// Description of a computation without steps.
    pub what: Option<String>,
    /// Time until which steps are taken.
    pub until: Option<f64>,
}

/// Data shared with readers.
#[derive(Default)]
pub struct Shared {
    /// Number of the last change.
    pub change: u64,
    /// The simulations in the order in which the script made them.
    pub simulations: Vec<FollowedSimulation>,
    /// Warnings issued to the user, and the number of the change that added the last one.
    pub warnings: (u64, Vec<String>),
    /// Current activity of the run.
    pub doing: Activity,
    /// Outcome; `None` during the run.
    pub outcome: Option<LiveOutcome>,
}

/// Report of a running simulation, shared with its readers.
pub struct LiveReport {
    shared: Mutex<Shared>,
    /// Folder of the results as given by the user.
    pub folder: String,
}

impl fmt::Debug for LiveReport {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "report of the run in {}", self.folder)
    }
}

impl LiveReport {
    /// Returns an empty report of a run whose results are in `folder`.
    pub fn new(folder: String) -> Self {
        LiveReport { shared: Mutex::default(), folder }
    }

    /// Locks the shared data; hold the guard only briefly.
    pub(super) fn look(&self) -> MutexGuard<'_, Shared> {
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a warning to the user.
    pub fn warn(&self, text: String) {
        let mut shared = self.look();
        let change = shared.next();
        shared.warnings.0 = change;
        shared.warnings.1.push(text);
    }

    /// Sets the current activity of the run.
    pub fn does(&self, doing: Activity) {
        self.look().doing = doing;
    }

    /// True if the run has ended.
    pub fn is_over(&self) -> bool {
        self.look().outcome.is_some()
    }

    /// Sets the outcome of the run.
    pub fn end(&self, outcome: LiveOutcome) {
        let mut shared = self.look();
        shared.next();
        shared.doing = Activity::default();
        shared.outcome = Some(outcome);
    }
}

impl Shared {
    fn next(&mut self) -> u64 {
        self.change += 1;
        self.change
    }

    fn apply(&mut self, number: usize, what: Handed) {
        let change = self.next();
        let Some(followed) = self.simulations.get_mut(number) else { return };
        match what {
            Handed::Row(row) => {
                followed.row_count = row.number + 1;
                followed.rows.push(change, Arc::new(row));
                followed.thin(change);
            }
            Handed::Cut(rows) => {
                followed.row_count = followed.row_count.min(rows);
                followed.rows.retain(change, |row| row.number < rows);
            }
            Handed::Columns(names) => {
                followed.shaped = change;
                followed.columns = Arc::new(followed.columns.iter().cloned().chain(names).collect());
            }
            Handed::Stills(stills) => {
                let mut known = 0;
                followed.stills.retain(change, |still| {
                    let stays = stills.get(known).is_some_and(|new| Arc::ptr_eq(new, still));
                    known += usize::from(stays);
                    stays
                });
                for still in stills.into_iter().skip(known) {
                    let change = self.change + 1;
                    self.change = change;
                    followed.stills.push(change, still);
                }
            }
            Handed::Problem(problem) => followed.problem = (change, Arc::new(problem)),
            Handed::End(outcome, findings) => {
                followed.outcome = Some(outcome);
                followed.findings = (change, findings);
            }
        }
    }
}

impl FollowedSimulation {
    /// Thins a long history to the last row and the peaks of each interval, and the rows of stills; intervals double as the history grows.
    fn thin(&mut self, change: u64) {
        if self.rows.entries().len() <= ROWS {
            return;
        }
        loop {
            self.stretch = if self.stretch == 0 { 4 * (MEASURES + 1) } else { self.stretch };
            let kept = self.kept();
            if kept.len() <= ROWS / 2 || self.stretch > self.row_count {
                let mut kept = kept.into_iter().peekable();
                self.rows.retain(change, |row| kept.next_if_eq(&row.number).is_some());
                return;
            }
            self.stretch *= 2;
        }
    }

    /// Numbers of the rows to keep, ascending.
    fn kept(&self) -> Vec<usize> {
        let entries = self.rows.entries();
        let mut kept: Vec<usize> = self.stills.entries().iter().map(|(_, still)| still.row).chain([0]).collect();
        for rows in entries.chunk_by(|(_, a), (_, b)| a.number / self.stretch == b.number / self.stretch) {
            kept.extend(rows.last().map(|(_, row)| row.number));
            let peak = |measure: usize| rows.iter().rev().max_by(|(_, a), (_, b)| a.measures[measure].total_cmp(&b.measures[measure]));
            kept.extend((0..MEASURES).filter_map(peak).map(|(_, row)| row.number));
        }
        kept.retain(|number| entries.binary_search_by(|(_, row)| row.number.cmp(number)).is_ok());
        kept.sort_unstable();
        kept.dedup();
        kept
    }
}

/// Updates of a simulation that the run hands over.
enum Handed {
    Row(LiveRow),
    /// Number of rows that are kept; later ones are dropped.
    Cut(usize),
    /// Names of further columns; earlier rows have no values there.
    Columns(Vec<String>),
    Stills(Vec<Arc<Still>>),
    Problem(LiveProblem),
    End(LiveOutcome, Vec<String>),
}

/// Interface of the run to a simulation's live report.
pub struct LiveSimulation {
    live: Arc<LiveReport>,
    number: usize,
    /// Updates that could not be handed over yet, because a reader held the lock.
    waiting: Vec<Handed>,
    /// Number of stills (recorded animation frames) handed over, and the last one.
    stills: (usize, Option<Arc<Still>>),
    told: Option<(Instant, LiveProblem)>,
}

impl LiveSimulation {
    /// Adds a simulation with the columns of its history.
    pub fn begin(live: &Arc<LiveReport>, model: LiveModel, columns: Vec<String>) -> Self {
        let mut shared = live.look();
        let change = shared.next();
        shared.simulations.push(FollowedSimulation {
            model: Arc::new(model),
            columns: Arc::new(columns),
            shaped: change,
            problem: (change, Arc::default()),
            rows: TrackedEntries::default(),
            row_count: 0,
            stretch: 0,
            stills: TrackedEntries::default(),
            findings: (change, Vec::new()),
            outcome: None,
        });
        let number = shared.simulations.len() - 1;
        drop(shared);
        LiveSimulation { live: live.clone(), number, waiting: Vec::new(), stills: (0, None), told: None }
    }

    /// Adds a row of the history with the values of all columns.
    pub fn row(&mut self, number: usize, row: &LedgerRow, values: Vec<f64>) {
        self.hand(Handed::Row(LiveRow { number, values, measures: measures(row) }));
    }

    /// Removes all rows behind the first `rows`.
    pub fn cut(&mut self, rows: usize) {
        self.hand(Handed::Cut(rows));
    }

    /// Adds columns of the history.
    pub fn add_columns(&mut self, names: &[String]) {
        self.hand(Handed::Columns(names.to_vec()));
    }

    /// Updates the stills (recorded animation frames).
    pub fn stills(&mut self, stills: &[Arc<Still>]) {
        let is_known = match (&self.stills, stills.last()) {
            ((count, Some(known)), Some(last)) => *count == stills.len() && Arc::ptr_eq(known, last),
            ((_, known), last) => known.is_none() && last.is_none(),
        };
        if !is_known {
            self.stills = (stills.len(), stills.last().cloned());
            self.hand(Handed::Stills(stills.to_vec()));
        }
    }

    /// True if the problem has not been reported for at least `BETWEEN_LOOKS`.
    pub fn wants_problem(&self) -> bool {
        self.told.as_ref().is_none_or(|(at, _)| at.elapsed() >= BETWEEN_LOOKS)
    }

    /// Updates the problem.
    pub fn tell(&mut self, problem: LiveProblem) {
        if self.told.as_ref().is_none_or(|(_, known)| *known != problem) {
            self.hand(Handed::Problem(problem.clone()));
        }
        self.told = Some((Instant::now(), problem));
    }

    /// Sets the outcome of the simulation and its findings.
    pub fn end(&mut self, outcome: LiveOutcome, findings: Vec<String>) {
        self.waiting.push(Handed::End(outcome, findings));
        let mut shared = self.live.look();
        self.waiting.drain(..).for_each(|what| shared.apply(self.number, what));
    }

    /// Hands over an update, or buffers it while a reader holds the lock.
    fn hand(&mut self, what: Handed) {
        self.waiting.push(what);
        let mut shared = match self.live.shared.try_lock() {
            Ok(shared) => shared,
            Err(TryLockError::Poisoned(shared)) => shared.into_inner(),
            Err(TryLockError::WouldBlock) => return,
        };
        self.waiting.drain(..).for_each(|what| shared.apply(self.number, what));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn simulation(live: &Arc<LiveReport>) -> LiveSimulation {
        let (contacts, bodies, skins, shown, obstacles, marks) = Default::default();
        let model = LiveModel { name: "a".into(), contacts, bodies, skins, shown, obstacles, units: None, marks };
        LiveSimulation::begin(live, model, vec!["step".into()])
    }

    fn numbers(live: &LiveReport) -> Vec<usize> {
        live.look().simulations[0].rows.entries().iter().map(|(_, row)| row.number).collect()
    }

    #[test]
    fn a_long_history_keeps_its_peaks_and_stays_bounded() {
        let live = Arc::new(LiveReport::new("out".into()));
        let mut simulation = simulation(&live);
        for number in 0..100_000 {
            let mut row = LedgerRow { newton_iterations: 3, ..LedgerRow::default() };
            row.energy_defect = if number == 1234 { -1e-3 } else { 0.0 };
            row.halvings = usize::from(number == 77_777);
            simulation.row(number, &row, vec![number as f64]);
            if number % 9999 == 0 {
                assert!(live.look().simulations[0].rows.entries().len() <= ROWS);
            }
        }
        let kept = numbers(&live);
        assert!(kept.len() <= ROWS && kept.len() > 500 && kept.windows(2).all(|pair| pair[0] < pair[1]), "{}", kept.len());
        assert!([0, 1234, 77_777, 99_999].iter().all(|number| kept.contains(number)));
        simulation.cut(50_000);
        assert_eq!(live.look().simulations[0].row_count, 50_000);
        assert!(numbers(&live).iter().all(|&number| number < 50_000));
    }

    #[test]
    fn what_is_handed_over_while_somebody_looks_comes_later_and_in_order() {
        let live = Arc::new(LiveReport::new("out".into()));
        let mut simulation = simulation(&live);
        let looking = live.look();
        simulation.row(0, &LedgerRow::default(), vec![0.0]);
        simulation.row(1, &LedgerRow::default(), vec![1.0]);
        simulation.cut(1);
        drop(looking);
        assert!(numbers(&live).is_empty(), "it did not wait");
        simulation.row(1, &LedgerRow::default(), vec![2.0]);
        assert_eq!(numbers(&live), [0, 1]);
        assert_eq!(live.look().simulations[0].rows.entries()[1].1.values, [2.0]);
    }
}
