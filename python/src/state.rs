//! State of a thread: sessions of the script engine, and values of the engine by the numbers that objects of Python hold.
//!
//! Values of the script engine stay on their thread. An object of Python holds a number whose upper bits identify the thread, so that it
//! may be passed to any thread. On another thread the value is not found, which is an error with a message; if the object is freed there,
//! the thread of the value frees it at its next call.

use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock};

use conserva::script::{Calls, Checkpoints, Diagnostic, Settings, worthwhile};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rhai::Dynamic;

use crate::observer::PythonObserver;
use crate::raise::{diagnostic_error, script_error};

/// Bits of a number below those of its thread.
const SERIAL_BITS: u32 = 40;

/// Largest number of nested calls, if functions of Python call Conserva again. The stack of a main thread holds more than twice as many.
const MOST_CALLS: usize = 12;

static THREADS: AtomicU64 = AtomicU64::new(1);
/// Numbers of objects that were freed on other threads.
static FREED: Mutex<Vec<u64>> = Mutex::new(Vec::new());
/// Number of entries of [`FREED`], readable without a lock.
static WAITING: AtomicUsize = AtomicUsize::new(0);
/// Interrupt flags of all sessions, and the number of running calls.
static INTERRUPTS: Mutex<Vec<Arc<AtomicBool>>> = Mutex::new(Vec::new());
static RUNNING: AtomicUsize = AtomicUsize::new(0);
/// Interrupt flag of the sessions of the main thread, which its signal sets.
static MAIN: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// Session with its interrupt flag.
pub struct Live {
    /// Functions of the session.
    pub calls: Calls,
    /// Flag that ends a computation at the next whole step.
    pub interrupt: Arc<AtomicBool>,
}

/// Sessions and values of one thread.
pub struct State {
    thread: u64,
    serial: Cell<u64>,
    values: RefCell<HashMap<u64, (Rc<Live>, Dynamic)>>,
    sessions: RefCell<BTreeMap<u64, Rc<Live>>>,
    current: Cell<u64>,
    depth: Cell<usize>,
    /// Calls that run without Python's lock, the innermost last, with their outcomes.
    pub pending: RefCell<Vec<Pending>>,
    /// Exceptions of Python that are passed through the engine.
    pub raised: RefCell<Option<PyErr>>,
}

/// A call between Python and the engine.
pub struct Pending {
    /// Session of the call.
    pub live: Rc<Live>,
    /// Work of the call, until it runs.
    pub work: Option<Work>,
    /// Outcome of the call, once it has run.
    pub outcome: Option<Result<Outcome, Box<Diagnostic>>>,
}

/// Work of the engine.
pub enum Work {
    /// A function by its place in the registry, with its arguments.
    Function(usize, Vec<Dynamic>),
    /// A function whose file is returned in place of writing it.
    File(usize, Vec<Dynamic>),
    /// A text with its variables.
    Text(String, Vec<(String, Dynamic)>),
}

/// Outcome of a call.
pub enum Outcome {
    /// A value of the engine.
    Value(Dynamic),
    /// A file.
    File(Option<Vec<u8>>),
}

impl Work {
    /// Does the work.
    ///
    /// # Errors
    /// The message that a script would end with.
    pub fn run(self, calls: &Calls) -> Result<Outcome, Box<Diagnostic>> {
        match self {
            Work::Function(function, values) => calls.call(function, values).map(Outcome::Value),
            Work::File(function, values) => calls.file(function, values).map(Outcome::File),
            Work::Text(text, variables) => calls.text(&text, variables).map(|variables| Outcome::Value(Dynamic::from_map(variables))),
        }
    }
}

thread_local! {
    static STATE: State = State {
        thread: THREADS.fetch_add(1, Ordering::Relaxed),
        serial: Cell::new(1),
        values: RefCell::default(),
        sessions: RefCell::default(),
        current: Cell::new(0),
        depth: Cell::new(0),
        pending: RefCell::default(),
        raised: RefCell::default(),
    };
}

/// The state of this thread.
pub fn with<T>(work: impl FnOnce(&State) -> T) -> T {
    STATE.with(work)
}

impl State {
    /// Stores a value; returns its number.
    pub fn keep(&self, live: &Rc<Live>, value: Dynamic) -> u64 {
        let serial = self.serial.replace(self.serial.get() + 1);
        let number = self.thread << SERIAL_BITS | serial;
        self.values.borrow_mut().insert(number, (live.clone(), value));
        number
    }

    /// Value with a number.
    ///
    /// # Errors
    /// The object belongs to another thread, or its session has ended.
    pub fn value(&self, py: Python, number: u64) -> PyResult<(Rc<Live>, Dynamic)> {
        if let Some(found) = self.values.borrow().get(&number) {
            return Ok(found.clone());
        }
        let (what, hint) = if number >> SERIAL_BITS == self.thread {
            ("the object has no value any more", "its session has ended: make the object anew, or use it before the session ends")
        } else {
            (
                "the object belongs to another thread",
                "make models and simulations in the thread that uses them; pass numbers, arrays and texts between threads",
            )
        };
        Err(script_error(py, what, "objects of Conserva are bound to the thread and session that made them", hint))
    }

    /// Drops a value.
    pub fn release(&self, number: u64) {
        if number >> SERIAL_BITS == self.thread {
            let value = self.values.borrow_mut().remove(&number);
            drop(value);
        } else if let Ok(mut freed) = FREED.lock() {
            freed.push(number);
            WAITING.store(freed.len(), Ordering::Relaxed);
        }
    }

    /// Drops the values whose objects were freed on other threads.
    fn sweep(&self) {
        if WAITING.load(Ordering::Relaxed) == 0 {
            return;
        }
        let mine: Vec<u64> = match FREED.lock() {
            Ok(mut freed) => {
                let (mine, others) = std::mem::take(&mut *freed).into_iter().partition(|number| number >> SERIAL_BITS == self.thread);
                *freed = others;
                WAITING.store(freed.len(), Ordering::Relaxed);
                mine
            }
            Err(_) => Vec::new(),
        };
        mine.into_iter().for_each(|number| self.release(number));
    }

    /// Session of calls without an object; on the first call a session without files.
    ///
    /// # Errors
    /// The working folder does not exist.
    pub fn current(&self, py: Python) -> PyResult<Rc<Live>> {
        self.sweep();
        if let Some(live) = self.sessions.borrow().get(&self.current.get()) {
            return Ok(live.clone());
        }
        let number = self.open(py, settings(), PathBuf::from("."))?;
        self.current.set(number);
        Ok(self.sessions.borrow()[&number].clone())
    }

    fn open(&self, py: Python, mut settings: Settings, home: PathBuf) -> PyResult<u64> {
        settings.interrupt = interrupt_of_thread(py)?;
        let interrupt = settings.interrupt.clone();
        let calls = Calls::new(settings, &home, Rc::new(PythonObserver::new(interrupt.clone())));
        let calls = calls.map_err(|error| diagnostic_error(py, &error))?;
        let number = self.serial.replace(self.serial.get() + 1);
        self.sessions.borrow_mut().insert(number, Rc::new(Live { calls, interrupt }));
        Ok(number)
    }

    /// Opens a session with settings and makes it the current one of this thread; returns its number and that of the previous session.
    ///
    /// # Errors
    /// Unknown settings, or a missing folder.
    pub fn enter(&self, py: Python, options: &Bound<'_, PyDict>) -> PyResult<(u64, u64)> {
        let mut settings = settings();
        let text = |key: &str| options.get_item(key).ok().flatten().filter(|value| !value.is_none());
        if let Some(output) = text("output") {
            settings.output = Some(output.extract()?);
        }
        if let Some(threads) = text("threads") {
            settings.threads = worthwhile(threads.extract()?);
        }
        if let Some(folders) = text("allow_read") {
            settings.allow_read = folders.extract()?;
        }
        if let Some(overrides) = text("parameters") {
            settings.overrides = overrides.extract()?;
        }
        let home = text("home").map_or(Ok(PathBuf::from(".")), |home| home.extract())?;
        let number = self.open(py, settings, home)?;
        Ok((number, self.current.replace(number)))
    }

    /// Ends a session, returns to another one, and returns its report.
    ///
    /// # Errors
    /// The session has ended before.
    pub fn leave(&self, py: Python, number: u64, back: u64) -> PyResult<conserva::script::Report> {
        let live = self.sessions.borrow_mut().remove(&number);
        self.current.set(back);
        let live = live.ok_or_else(|| {
            script_error(py, "the session has ended already", "a session is left once, on the thread that entered it", "open a new one")
        })?;
        Ok(live.calls.finish(None))
    }

    /// Counts a call that begins; clears the interrupt of an earlier one.
    ///
    /// # Errors
    /// Too many calls are open.
    pub fn begin(&self, py: Python, live: &Live) -> PyResult<()> {
        let depth = self.depth.get();
        if depth >= MOST_CALLS {
            let cause =
                format!("{MOST_CALLS} calls of Conserva are open, each made by a function of Python that the one before has called");
            let hint = "let functions that are handed to Conserva compute with numbers, without handing out functions themselves";
            return Err(script_error(py, "calls are nested too deeply", &cause, hint));
        }
        if depth == 0 {
            live.interrupt.store(false, Ordering::Relaxed);
            self.raised.replace(None);
            RUNNING.fetch_add(1, Ordering::Relaxed);
        }
        self.depth.set(depth + 1);
        Ok(())
    }

    /// Counts a call that has ended.
    pub fn end(&self) {
        self.depth.set(self.depth.get() - 1);
        if self.depth.get() == 0 {
            RUNNING.fetch_sub(1, Ordering::Relaxed);
        }
    }

    /// Drops all sessions and values of this thread.
    pub fn clear(&self) {
        let values = std::mem::take(&mut *self.values.borrow_mut());
        let sessions = std::mem::take(&mut *self.sessions.borrow_mut());
        drop((values, sessions));
    }
}

/// Settings of a session. A program may read all files of its user, so that restrictions of a session would have no effect.
fn settings() -> Settings {
    let root = std::env::current_dir().ok().and_then(|folder| folder.ancestors().last().map(PathBuf::from));
    Settings { checkpoints: Checkpoints::Never, interactive: true, allow_read: root.into_iter().collect(), ..Settings::default() }
}

/// Flag that ends computations of this thread.
fn interrupt_of_thread(py: Python) -> PyResult<Arc<AtomicBool>> {
    let threading = py.import("threading")?;
    let is_main = threading.call_method0("current_thread")?.is(&threading.call_method0("main_thread")?);
    let flag = if is_main { MAIN.get_or_init(watched_flag).clone() } else { Arc::default() };
    if let Ok(mut all) = INTERRUPTS.lock() {
        all.retain(|known| Arc::strong_count(known) > 1);
        all.push(flag.clone());
    }
    Ok(flag)
}

/// Flag that the interrupt key sets, before Python's own handler raises its exception.
fn watched_flag() -> Arc<AtomicBool> {
    let flag = Arc::new(AtomicBool::new(false));
    // If this fails, the flag is set after each step, when Python's signals are checked.
    let _ = signal_hook::flag::register(signal_hook::consts::SIGINT, flag.clone());
    flag
}

/// Interrupts the computations of all threads, and waits until they have ended, for a limited time.
pub fn interrupt_all(longest: std::time::Duration) {
    if let Ok(all) = INTERRUPTS.lock() {
        all.iter().for_each(|flag| flag.store(true, Ordering::Relaxed));
    }
    let begun = std::time::Instant::now();
    while RUNNING.load(Ordering::Relaxed) > 0 && begun.elapsed() < longest {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
}

impl State {
    /// Session of the innermost open call, otherwise the current one.
    ///
    /// # Errors
    /// The working folder does not exist.
    pub fn current_call(&self, py: Python) -> PyResult<Rc<Live>> {
        let innermost = self.pending.borrow().last().map(|pending| pending.live.clone());
        innermost.map_or_else(|| self.current(py), Ok)
    }

    /// Ends the computation of the innermost open call at the next whole step.
    pub fn interrupt(&self) {
        if let Some(pending) = self.pending.borrow().last() {
            pending.live.interrupt.store(true, Ordering::Relaxed);
        }
    }
}
