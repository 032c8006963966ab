//! A closure that is called for many points, in parallel on threads where it can be transferred to other sessions.
//!
//! A closure can be transferred if all captured values are plain data. Each thread then has a session of its own (`session/worker.rs`),
//! also with a single thread, so that results do not depend on the number of threads. If the closure captures an object, such as a mesh, or
//! was made where other sessions do not find it, the points are computed one after another in the session itself. In both cases every point
//! begins with equal captured values, and its messages are reported in the order of the points.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

use crate::script::api::files::shown::Printed;
use crate::script::api::nested_runs::begin_study;
use crate::script::api::parameters::Overrides;
use crate::script::api::units::DeclaredUnits;
use crate::script::language::callback::Callback;
use crate::script::language::diagnostics::defect;
use crate::script::language::failure::Class;
use crate::script::language::limits::STACK;
use crate::script::language::message::Message;
use crate::script::language::plain::Plain;
use crate::script::language::prelude::*;
use crate::script::language::settings::{Checkpoints, Settings};
use crate::script::language::worker_pool::{
    Blueprint, ClosureCaller, Computed, MakeWorker, NewWorker, Outcome, PortableClosure, Program, Reading, ScriptOutput, outcome_of,
};

/// Period at which interrupts are checked.
const PATIENCE: Duration = Duration::from_millis(50);

/// Receiver of the results of points.
pub trait Results {
    /// Returns the result of a point that was computed before.
    fn known(&self, point: &[Plain]) -> Option<Computed>;

    /// Receives a computed point; points come in any order.
    ///
    /// # Errors
    /// A file that cannot be written.
    fn computed(&mut self, point: &[Plain], computed: &Computed) -> Result<(), Failure>;

    /// True if messages of the point are shown to the user.
    fn is_told(&self, _outcome: &Outcome) -> bool {
        true
    }

    /// Receives the outcome of a point; points come in order.
    ///
    /// # Errors
    /// Any error ends the study; later points are dropped.
    fn take(&mut self, index: usize, outcome: Outcome) -> Result<(), Failure>;
}

/// Pool that computes points: worker threads, or the session itself.
pub struct WorkerPool<'a> {
    call: &'a Call<'a>,
    form: Form,
}

enum Form {
    Threads(Threads),
    Here { callback: Callback, captured: Vec<Option<Plain>>, reading: Reading },
}

impl<'a> WorkerPool<'a> {
    /// Returns a pool for a closure, with at most `threads` threads.
    pub fn new(call: &'a Call<'a>, callback: Callback, reading: Reading, threads: usize) -> Self {
        let captured: Vec<Option<Plain>> = callback.captured().map(Plain::of).collect();
        let start_worker = call.host.slots.get::<MakeWorker>().0;
        let carried = captured.iter().cloned().collect::<Option<Vec<Plain>>>();
        let found = carried.zip(start_worker).and_then(|(captured, start_worker)| {
            let closure = PortableClosure { name: callback.name().into(), captured, reading };
            Threads::begin(start_worker, &blueprint(call, threads)?, &closure, threads)
        });
        let form = found.map_or(Form::Here { callback, captured, reading }, Form::Threads);
        WorkerPool { call, form }
    }

    /// True if points are computed on worker threads, so that their results can be stored for a resumed run.
    pub fn is_apart(&self) -> bool {
        matches!(self.form, Form::Threads(_))
    }

    /// Computes the points without results; `title` is shown by the observer.
    ///
    /// # Errors
    /// An interrupt, or an error of the receiver.
    pub fn compute(&mut self, title: &str, points: &[Vec<Plain>], results: &mut dyn Results) -> Result<(), Failure> {
        let host = self.call.host;
        match &mut self.form {
            Form::Threads(threads) => threads.compute(host, title, points, results),
            Form::Here { callback, captured, reading } => {
                let outcome = points.iter().enumerate().try_for_each(|(index, point)| {
                    host.go_on()?;
                    if points.len() > 1 {
                        host.observer.began(&format!("{title}: {index} of {} points, one after another", points.len()));
                    }
                    let outcome = here(self.call, callback, captured, *reading, point);
                    accept(host, index, Computed::only(outcome), results)
                });
                if points.len() > 1 {
                    host.observer.ended();
                }
                outcome
            }
        }
    }
}

/// Calls the closure in the session of the script.
fn here(call: &Call, callback: &Callback, captured: &[Option<Plain>], reading: Reading, point: &[Plain]) -> Outcome {
    let arguments = point.iter().map(Plain::value).collect();
    let value = {
        let _aside = begin_study(call.host, None);
        catch_unwind(AssertUnwindSafe(|| callback.call_by_itself(captured, arguments)))
    };
    match value {
        Ok(value) => outcome_of(call.host, call.engine(), value, reading),
        Err(panic) => Outcome::Failed(Message::of(&defect(&*panic))),
    }
}

/// Reports the messages of a point, and passes its outcome on.
fn accept(host: &Host, index: usize, computed: Computed, results: &mut dyn Results) -> Result<(), Failure> {
    if let Outcome::Failed(message) = &computed.outcome
        && matches!(message.class, Class::Interrupted | Class::ResultUsed)
    {
        return Err(message.failure(&host.sources));
    }
    for (name, text) in &computed.modules {
        if host.sources.text(name).is_none() {
            host.sources.insert(name, text);
        }
    }
    for told in computed.told.iter().filter(|_| results.is_told(&computed.outcome)) {
        match told {
            ScriptOutput::Line(line) => Printed::show(host, line),
            ScriptOutput::Passed(key, line) => host.passed_as(key, line),
            ScriptOutput::Warning(message) => host.warn(message.diagnostic(&host.sources)),
        }
    }
    let overrides = host.slots.get::<Overrides>();
    computed.asked.iter().for_each(|(name, value)| overrides.note(name, value.value()));
    computed.read.iter().for_each(|file| host.sandbox.note(file.clone()));
    results.take(index, computed.outcome)
}

/// Returns the data to create further sessions with equal functions; `None` if the data cannot be determined.
fn blueprint(call: &Call, threads: usize) -> Option<Blueprint> {
    let host = call.host;
    let global = call.context.global_runtime_state();
    let main = host.main.borrow().clone();
    let path = |source: &str| source.strip_suffix(".rhai").map(String::from);
    // All modules are loaded, because closures may come from any; named ones come last, so that names refer to the modules of the script.
    let sources = host.sources.all();
    let loaded = sources.iter().filter(|(name, _)| *name != main).filter_map(|(name, _)| Some((String::new(), path(name)?)));
    let named = global.scan_imports_raw().map(|(alias, module)| Some((alias.to_string(), host.module_path(module)?)));
    let imports = loaded.map(Some).chain(named).collect::<Option<Vec<_>>>()?;
    let mut constants = Vec::new();
    for (name, value) in global.constants.iter().flat_map(|constants| constants.borrow().clone()) {
        match Plain::of(&value) {
            Some(value) => constants.push((name.to_string(), value)),
            // Functions of the script may use an object that cannot be transferred to another session.
            None if sources.iter().any(|(_, text)| text.contains(&format!("global::{name}"))) => return None,
            None => {}
        }
    }
    let settings = Settings {
        output: None,
        checkpoints: Checkpoints::Never,
        until: None,
        interactive: false,
        workers: 1,
        threads: if threads > 1 { 1 } else { host.settings.threads },
        factorization: Arc::default(),
        ..host.settings.clone()
    };
    let program = host.slots.get::<Program>().0.borrow().clone();
    let (sources, units) = (host.sources.clone(), DeclaredUnits::names(host));
    Some(Blueprint { settings, home: host.sandbox.home().into(), main, sources, program, imports, constants, units })
}

/// A point to compute.
struct Job {
    index: usize,
    point: Vec<Plain>,
}

/// Message of a worker thread.
enum WorkerMessage {
    /// Start of the thread; true if the thread can compute points.
    Begun(bool),
    /// Index and result of a point.
    Computed(usize, Box<Computed>),
}

/// A thread and its connections.
struct Thread {
    handle: Option<JoinHandle<()>>,
    interrupt: Arc<AtomicBool>,
    /// Index of the point in computation.
    index: Arc<AtomicUsize>,
}

/// Worker threads, each with a session of its own.
struct Threads {
    jobs: Option<Sender<Job>>,
    news: Receiver<WorkerMessage>,
    threads: Vec<Thread>,
    /// Index of the last point whose result is needed.
    last: Arc<AtomicUsize>,
}

impl Threads {
    /// Starts `count` threads; `None` if they do not find the closure.
    fn begin(start_worker: NewWorker, blueprint: &Blueprint, closure: &PortableClosure, count: usize) -> Option<Self> {
        let (jobs, queue) = channel();
        let (sender, news) = channel();
        let (queue, last) = (Arc::new(Mutex::new(queue)), Arc::new(AtomicUsize::new(usize::MAX)));
        let mut worker_pool = Threads { jobs: Some(jobs), news, threads: Vec::new(), last };
        for number in 0..count.max(1) {
            let (interrupt, index) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicUsize::new(usize::MAX)));
            let mut blueprint = blueprint.clone();
            blueprint.settings.interrupt = interrupt.clone();
            let work = Work {
                start_worker,
                blueprint,
                closure: closure.clone(),
                queue: queue.clone(),
                news: sender.clone(),
                last: worker_pool.last.clone(),
                index: index.clone(),
            };
            let Ok(handle) = Builder::new().name(format!("study-{number}")).stack_size(STACK).spawn(move || work.run()) else { break };
            worker_pool.threads.push(Thread { handle: Some(handle), interrupt, index });
        }
        drop(sender);
        // All threads are equal, so the first answer holds for all.
        match worker_pool.news.recv() {
            Ok(WorkerMessage::Begun(true)) => Some(worker_pool),
            _ => None,
        }
    }

    fn compute(&mut self, host: &Host, title: &str, points: &[Vec<Plain>], results: &mut dyn Results) -> Result<(), Failure> {
        self.last.store(usize::MAX, Ordering::Relaxed);
        let mut waiting = BTreeMap::new();
        for (index, point) in points.iter().enumerate() {
            match (results.known(point), &self.jobs) {
                (Some(computed), _) => drop(waiting.insert(index, computed)),
                (None, Some(jobs)) => drop(jobs.send(Job { index, point: point.clone() })),
                (None, None) => {}
            }
        }
        let (mut next, mut count) = (0, waiting.len());
        let say = |count: usize| {
            if points.len() > 1 {
                host.observer.began(&format!("{title}: {count} of {} points", points.len()));
            }
        };
        say(count);
        let outcome = loop {
            let mut outcome = Ok(());
            while let (Ok(()), Some(computed)) = (&outcome, waiting.remove(&next)) {
                outcome = accept(host, next, computed, results);
                next += 1;
            }
            if outcome.is_err() || next == points.len() {
                break outcome;
            }
            match self.news.recv_timeout(PATIENCE) {
                Ok(WorkerMessage::Computed(index, computed)) => {
                    if is_result(&computed)
                        && let Err(failure) = results.computed(&points[index], &computed)
                    {
                        break Err(failure);
                    }
                    waiting.insert(index, *computed);
                    count += 1;
                    say(count);
                }
                Ok(WorkerMessage::Begun(_)) | Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break Err(Failure::new(Class::Internal, "all threads of a study have ended")),
            }
            if let Err(failure) = host.go_on() {
                break Err(failure);
            }
        };
        if outcome.is_err() {
            self.stop_behind(next);
        }
        if points.len() > 1 {
            host.observer.ended();
        }
        outcome
    }

    /// Cancels the computation of points from index `next` on.
    fn stop_behind(&self, next: usize) {
        self.last.store(next, Ordering::SeqCst);
        for thread in &self.threads {
            let index = thread.index.load(Ordering::SeqCst);
            if index >= next && index != usize::MAX {
                thread.interrupt.store(true, Ordering::Relaxed);
            }
        }
    }
}

/// True if a computation was completed, i.e. neither interrupted nor ended by an internal error.
fn is_result(computed: &Computed) -> bool {
    !matches!(&computed.outcome, Outcome::Failed(message) if matches!(message.class, Class::Interrupted | Class::Internal))
}

impl Drop for Threads {
    fn drop(&mut self) {
        self.last.store(0, Ordering::SeqCst);
        self.jobs = None;
        for thread in &mut self.threads {
            thread.interrupt.store(true, Ordering::Relaxed);
        }
        for thread in &mut self.threads {
            // A thread that panicked has already ended.
            thread.handle.take().map(JoinHandle::join);
        }
    }
}

/// Data of a worker thread.
struct Work {
    start_worker: NewWorker,
    blueprint: Blueprint,
    closure: PortableClosure,
    queue: Arc<Mutex<Receiver<Job>>>,
    news: Sender<WorkerMessage>,
    last: Arc<AtomicUsize>,
    index: Arc<AtomicUsize>,
}

impl Work {
    fn hand(&self) -> Option<Box<dyn ClosureCaller>> {
        let hand = catch_unwind(AssertUnwindSafe(|| (self.start_worker)(&self.blueprint)));
        hand.ok()?.filter(|hand| hand.knows(&self.closure))
    }

    fn run(self) {
        let mut hand = self.hand();
        let _ = self.news.send(WorkerMessage::Begun(hand.is_some()));
        while let Some(worker) = &mut hand {
            let job = match self.queue.lock() {
                Ok(queue) => queue.recv(),
                Err(_) => break,
            };
            let Ok(Job { index, point }) = job else { break };
            if index >= self.last.load(Ordering::SeqCst) {
                continue;
            }
            self.index.store(index, Ordering::SeqCst);
            let computed = catch_unwind(AssertUnwindSafe(|| worker.compute(&self.closure, &point)));
            self.index.store(usize::MAX, Ordering::SeqCst);
            let computed = computed.unwrap_or_else(|panic| {
                // The session is replaced, because a panic may have left it inconsistent.
                hand = self.hand();
                Computed::only(Outcome::Failed(Message::of(&defect(&*panic))))
            });
            if self.news.send(WorkerMessage::Computed(index, Box::new(computed))).is_err() {
                break;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::script::language::observer::Silent;
    use crate::script::language::sandbox::Sandbox;
    use std::rc::Rc;

    /// Closure caller that doubles numbers; the number 3 causes a panic, which changes the session.
    struct Doubler(bool);

    impl ClosureCaller for Doubler {
        fn knows(&self, closure: &PortableClosure) -> bool {
            closure.name == "double"
        }

        fn compute(&mut self, _: &PortableClosure, point: &[Plain]) -> Computed {
            let number = point[0].number().unwrap();
            assert!(!self.0, "it was hired anew");
            self.0 = number == 3.0;
            assert!(number != 3.0, "three is too many");
            Computed::only(Outcome::Done(Plain::Number(2.0 * number)))
        }
    }

    #[derive(Default)]
    struct Taken(Vec<String>);

    impl Results for Taken {
        fn known(&self, point: &[Plain]) -> Option<Computed> {
            (point[0] == Plain::Number(1.0)).then(|| Computed::only(Outcome::Done(Plain::Text("known".into()))))
        }

        fn computed(&mut self, point: &[Plain], _: &Computed) -> Result<(), Failure> {
            assert_ne!(point[0], Plain::Number(1.0));
            assert_ne!(point[0], Plain::Number(3.0), "a defect is not kept");
            Ok(())
        }

        fn take(&mut self, index: usize, outcome: Outcome) -> Result<(), Failure> {
            assert_eq!(index, self.0.len());
            match outcome {
                Outcome::Done(plain) => self.0.push(plain.field()),
                Outcome::Failed(message) => self.0.push(message.line(&Default::default())),
                Outcome::Refused(_) => return Err(Failure::script("refused")),
            }
            if index == 5 { Err(Failure::script("enough")) } else { Ok(()) }
        }
    }

    fn begin(name: &str, count: usize) -> Option<Threads> {
        let blueprint = Blueprint {
            settings: Settings::default(),
            home: ".".into(),
            main: String::new(),
            sources: Default::default(),
            program: Vec::new(),
            imports: Vec::new(),
            constants: Vec::new(),
            units: Vec::new(),
        };
        let closure = PortableClosure { name: name.into(), captured: Vec::new(), reading: |_, _| Ok(Plain::Nothing) };
        Threads::begin(|_| Some(Box::new(Doubler(false))), &blueprint, &closure, count)
    }

    #[test]
    fn a_defect_is_the_failure_of_its_point() {
        let host = Host::new(Settings::default(), Sandbox::new(".".as_ref(), &[]).unwrap(), Rc::new(Silent));
        assert!(begin("triple", 2).is_none());
        for count in [1, 2, 7] {
            let points: Vec<Vec<Plain>> = (0..5).map(|number| vec![Plain::Number(f64::from(number))]).collect();
            let (mut threads, mut taken) = (begin("double", count).unwrap(), Taken::default());
            threads.compute(&host, "test", &points, &mut taken).unwrap();
            let defect = "the program has a defect and had to stop; three is too many";
            assert_eq!(taken.0, ["0.0", "known", "4.0", defect, "8.0"], "{count} threads");
            // An error of the receiver ends the study.
            let points: Vec<Vec<Plain>> = (4..1000).map(|number| vec![Plain::Number(f64::from(number))]).collect();
            let mut taken = Taken::default();
            let failure = threads.compute(&host, "test", &points, &mut taken).unwrap_err();
            assert_eq!((failure.title.as_str(), taken.0.len()), ("enough", 6));
        }
    }
}
