//! Computes the points of a study on this machine, in one process per processor; each process computes one point after another.
//!
//! A process runs [`serve`] as `conserva sweep point DIR --index -`: it reads indices of points, one per line, and answers each with a
//! word. A point that crashes its process thus does not affect other points.

use std::collections::VecDeque;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use super::folder::{PointState, StudyFolder};
use super::plan::Plan;
use super::point::{PointOutcome, compute};
use super::record::{Record, RecordOutcome};
use super::values::refusal;
use super::watchdog::Watchdog;
use crate::script::{Class, Diagnostic};

/// Message upon which a process ends after its current point.
const STOP: &str = "stop";
/// Answer of a process whose point is done.
const DONE: &str = "done";
/// Answer of a process whose point is computed by another process.
const BUSY: &str = "busy";
/// Answer of a process that was interrupted.
const INTERRUPTED: &str = "interrupted";
/// Period at which interrupts, and points computed by other processes, are checked.
const PERIOD: Duration = Duration::from_millis(100);

/// Computes the points whose indices are read line by line, and answers each with a word.
///
/// # Errors
/// Files that cannot be written, indices that the study does not have.
pub fn serve(
    study: &StudyFolder,
    plan: &Plan,
    interrupt: &Arc<AtomicBool>,
    watchdog: &Watchdog,
    say: &mut dyn FnMut(&str),
) -> Result<(), Box<Diagnostic>> {
    let (sender, receiver) = mpsc::channel();
    let flag = interrupt.clone();
    let read = move || {
        for line in std::io::stdin().lock().lines().map_while(Result::ok) {
            if line == STOP {
                flag.store(true, Ordering::Relaxed);
            } else if sender.send(line).is_err() {
                break;
            }
        }
    };
    let begun = std::thread::Builder::new().name("orders".into()).spawn(read);
    begun.map_err(|error| Box::new(Diagnostic::error(Class::Internal, "no thread could be started").cause(error.to_string())))?;
    for line in receiver {
        let point = line.trim().parse::<usize>().ok().and_then(|index| plan.points.get(index));
        let Some(point) = point else { return Err(Box::new(refusal(format!("the study has no point `{line}`")))) };
        match compute(study, plan, point, watchdog)? {
            PointOutcome::Computed(_) | PointOutcome::Kept(_) => say(DONE),
            PointOutcome::UnderWay => say(BUSY),
            PointOutcome::Interrupted => {
                say(INTERRUPTED);
                return Ok(());
            }
        }
    }
    Ok(())
}

/// A computed point.
#[derive(Clone, Debug)]
pub struct Done {
    /// Index of the point.
    pub index: usize,
    /// Record of the point.
    pub record: Record,
}

enum Message {
    Done(Box<Done>),
    Trouble(Box<Diagnostic>),
}

/// Data shared by the threads that control one process each.
struct Pool<'a> {
    study: &'a StudyFolder,
    plan: &'a Plan,
    program: &'a Path,
    waiting: Mutex<VecDeque<usize>>,
    is_over: AtomicBool,
}

/// Input of a process for indices of points.
type Orders = Mutex<Option<ChildStdin>>;

/// Computes points in `jobs` processes of `program`; `tell` is called with each computed point.
///
/// # Errors
/// A process that cannot be started, or could not write its files. Points computed before are kept.
pub(crate) fn compute_all(
    (study, plan): (&StudyFolder, &Plan),
    points: Vec<usize>,
    (program, jobs): (&Path, usize),
    interrupt: &AtomicBool,
    tell: &mut dyn FnMut(&Done),
) -> Result<(), Box<Diagnostic>> {
    let jobs = jobs.clamp(1, points.len().max(1));
    let pool = Pool { study, plan, program, waiting: Mutex::new(points.into()), is_over: AtomicBool::new(false) };
    let orders: Vec<Orders> = (0..jobs).map(|_| Orders::default()).collect();
    let (sender, receiver) = mpsc::channel();
    let (mut trouble, mut is_told) = (None, false);
    std::thread::scope(|scope| {
        for orders in &orders {
            let (pool, sender) = (&pool, sender.clone());
            scope.spawn(move || pool.look_after(orders, &sender));
        }
        drop(sender);
        loop {
            match receiver.recv_timeout(PERIOD) {
                Ok(Message::Done(done)) => tell(&done),
                Ok(Message::Trouble(error)) => {
                    trouble.get_or_insert(error);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            if interrupt.load(Ordering::Relaxed) || trouble.is_some() {
                pool.is_over.store(true, Ordering::Relaxed);
                if !std::mem::replace(&mut is_told, true) {
                    orders.iter().for_each(|orders| give(orders, STOP));
                }
            }
        }
    });
    trouble.map_or(Ok(()), Err)
}

/// Writes a line to a process; an ended process is detected by its answers.
fn give(orders: &Orders, order: &str) {
    if let Ok(mut orders) = orders.lock()
        && let Some(pipe) = orders.as_mut()
    {
        let _ = writeln!(pipe, "{order}").and_then(|()| pipe.flush());
    }
}

/// A process and its answers.
struct Worker {
    child: Child,
    answers: BufReader<std::process::ChildStdout>,
}

impl Pool<'_> {
    /// Gives points to a process until none are left.
    fn look_after(&self, orders: &Orders, sender: &Sender<Message>) {
        let mut worker: Option<Worker> = None;
        while let Some(index) = self.next() {
            let running = match worker.take().map_or_else(|| self.start(orders), Ok) {
                Ok(running) => worker.insert(running),
                Err(error) => {
                    let _ = sender.send(Message::Trouble(error));
                    break;
                }
            };
            give(orders, &index.to_string());
            if self.is_over.load(Ordering::Relaxed) {
                give(orders, STOP);
            }
            let mut answer = String::new();
            let read = running.answers.read_line(&mut answer);
            match (read, answer.trim()) {
                (_, DONE) => self.tell(index, sender),
                (_, BUSY) => self.come_back_to(index),
                (_, INTERRUPTED) => break,
                _ => {
                    let status = end(orders, worker.take());
                    if !self.bury(index, status, sender) {
                        break;
                    }
                }
            }
        }
        end(orders, worker);
    }

    fn next(&self) -> Option<usize> {
        let is_over = self.is_over.load(Ordering::Relaxed);
        self.waiting.lock().ok().filter(|_| !is_over)?.pop_front()
    }

    /// Puts back a point that another process computes, and waits if it is the only one left.
    fn come_back_to(&self, index: usize) {
        let Ok(mut waiting) = self.waiting.lock() else { return };
        waiting.push_back(index);
        let others = waiting.len() > 1;
        drop(waiting);
        if !others {
            std::thread::sleep(PERIOD);
        }
    }

    fn start(&self, orders: &Orders) -> Result<Worker, Box<Diagnostic>> {
        let mut command = Command::new(self.program);
        command.args(["sweep", "point"]).arg(self.study.path()).args(["--index", "-"]);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let failed = |error: std::io::Error| {
            let title = format!("a process of {} could not be started", self.program.display());
            Box::new(Diagnostic::error(Class::Internal, title).cause(error.to_string()).hint("take fewer at a time with `--jobs`"))
        };
        let mut child = command.spawn().map_err(failed)?;
        if let Ok(mut orders) = orders.lock() {
            *orders = child.stdin.take();
        }
        let answers = child.stdout.take().ok_or_else(|| failed(std::io::ErrorKind::BrokenPipe.into()))?;
        Ok(Worker { child, answers: BufReader::new(answers) })
    }

    fn tell(&self, index: usize, sender: &Sender<Message>) {
        if let Some(record) = self.study.record(&self.plan.points[index]) {
            let _ = sender.send(Message::Done(Box::new(Done { index, record })));
        }
    }

    /// Records a point whose process has ended. Returns true if the thread continues with other points.
    fn bury(&self, index: usize, (status, said): (Option<ExitStatus>, String), sender: &Sender<Message>) -> bool {
        let point = &self.plan.points[index];
        // A point stopped at its time limit has a record.
        if self.study.record(point).is_some_and(|record| record.outcome != RecordOutcome::Killed) {
            self.tell(index, sender);
            return true;
        }
        let code = status.and_then(|status| status.code());
        if self.is_over.load(Ordering::Relaxed) || code == Some(0) {
            return false;
        }
        if code.is_some() {
            let error = Diagnostic::error(Class::Output, format!("the point {} could not be computed", point.id));
            // Fault and hint from the message of the process.
            let title =
                |line: &'_ str| line.strip_prefix("error").and_then(|rest| rest.split_once(": ")).map(|(_, title)| title.to_string());
            let error = said.lines().fold(error, |error, line| match (title(line), line.trim().strip_prefix("= hint: ")) {
                (Some(title), _) => error.cause(title),
                (_, Some(hint)) => error.hint(hint),
                _ => error,
            });
            let error = error.hint("`conserva sweep` again goes on with what is missing");
            let _ = sender.send(Message::Trouble(Box::new(error)));
            return false;
        }
        let record = Record::of(&point.id, RecordOutcome::Killed, status.map_or("its process is gone".into(), how));
        let written = match self.study.claim(point) {
            Ok(Some(_claim)) => self.study.write_record(&record),
            Ok(None) => Ok(()),
            Err(error) => Err(error),
        };
        let message = written.map_or_else(Message::Trouble, |()| Message::Done(Box::new(Done { index, record })));
        let goes_on = matches!(message, Message::Done(_));
        let _ = sender.send(message);
        goes_on
    }
}

/// Ends a process, and returns its exit status and last message.
fn end(orders: &Orders, worker: Option<Worker>) -> (Option<ExitStatus>, String) {
    if let Ok(mut orders) = orders.lock() {
        *orders = None;
    }
    let Some(mut worker) = worker else { return (None, String::new()) };
    let mut said = String::new();
    if let Some(mut errors) = worker.child.stderr.take() {
        let _ = errors.read_to_string(&mut said);
    }
    (worker.child.wait().ok(), said)
}

/// Describes how a process was ended from outside.
#[cfg(unix)]
fn how(status: ExitStatus) -> String {
    use std::os::unix::process::ExitStatusExt;
    match status.signal() {
        Some(signal) => format!("its process was ended by signal {signal}"),
        None => "its process is gone".into(),
    }
}

/// Describes how a process was ended from outside.
#[cfg(not(unix))]
fn how(status: ExitStatus) -> String {
    format!("its process was ended: {status}")
}

/// Indices of the points that have to be computed.
pub(crate) fn open_points(study: &StudyFolder, plan: &Plan) -> Vec<usize> {
    let is_open = |index: &usize| match study.state(&plan.points[*index]) {
        PointState::UnderWay => true,
        state => state.is_open(),
    };
    (0..plan.points.len()).filter(is_open).collect()
}
