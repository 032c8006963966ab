//! Connection to rank 0 of the distributed solver, a program of its own (`packages/mumps`, whose head describes the messages).
//!
//! There is one set of ranks per process, because an MPI job has one rank 0; all solvers share it.

use std::io::{ErrorKind, Read, Write};
use std::os::unix::fs::DirBuilderExt;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::process::Child;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::launch::start;
use crate::linear::error::{LinearError, RanksError};
use crate::linear::watch::InterruptWatch;

/// Period at which a wait looks for an interrupt.
const LOOK: Duration = Duration::from_millis(50);

/// Longest time until all ranks are connected: a cluster starts some hundred processes in seconds.
const START: Duration = Duration::from_secs(180);

/// Longest time for ranks to end after the last message, before they are killed.
const END: Duration = Duration::from_secs(10);

/// Number at the beginning of the first message (greeting) of rank 0.
const MAGIC: i64 = 0x0031_304d_554d_4f43;

/// Length of the version text in the first message (greeting) of rank 0 `[bytes]`.
const VERSION: usize = 32;

/// Number of bytes that are buffered before they are sent.
const BUFFER: usize = 1 << 18;

/// Command of a message.
#[derive(Clone, Copy)]
pub(super) enum Command {
    Structure = 1,
    Factorize = 2,
    Solve = 3,
    Free = 4,
    Finish = 5,
}

/// Head of a message.
pub(super) type Head = [i64; 8];

/// Returns the header of a message: command and arguments.
pub(super) fn head(command: Command, arguments: &[i64]) -> Head {
    let mut head = [0; 8];
    head[0] = command as i64;
    head[1..=arguments.len()].copy_from_slice(arguments);
    head
}

/// MPI processes (ranks) of the distributed solver.
pub(super) struct Ranks {
    stream: Option<UnixStream>,
    child: Child,
    /// Number of ranks that was requested.
    wanted: u32,
    /// Number of ranks.
    pub count: usize,
    buffer: Vec<u8>,
    /// Matrices made so far; each has a number of its own.
    matrices: i64,
}

/// Ranks of the distributed solver that this process uses, started with the first solver.
static RANKS: Mutex<Option<Arc<Mutex<Ranks>>>> = Mutex::new(None);

/// Locks a mutex, also after a panic of another thread: inconsistent data would be reported by the connection.
pub(super) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns the ranks of the distributed solver, which are started if needed.
pub(super) fn ranks(wanted: u32, watch: &InterruptWatch) -> Result<Arc<Mutex<Ranks>>, LinearError> {
    let mut known = locked(&RANKS);
    if let Some(ranks) = &*known {
        let is_usable = { locked(ranks) }.is_usable(wanted);
        if is_usable {
            return Ok(ranks.clone());
        }
    }
    let ranks = Arc::new(Mutex::new(Ranks::started(wanted, watch)?));
    *known = Some(ranks.clone());
    Ok(ranks)
}

/// Ends the ranks of the distributed solver, if there are any. A program that was started by an MPI launcher calls it before its end:
/// launchers take a process that ends before the others for a failure of the job.
pub fn end_ranks() {
    if let Some(ranks) = locked(&RANKS).take() {
        locked(&ranks).end();
    }
}

/// Folder of the socket, which only this user can enter; removed with its contents.
struct Folder(PathBuf);

impl Folder {
    fn new() -> std::io::Result<Self> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let name = format!("conserva-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let path = std::env::temp_dir().join(name);
        std::fs::DirBuilder::new().mode(0o700).create(&path)?;
        Ok(Folder(path))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // If the removal fails, an empty folder remains among the temporary files.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

impl Ranks {
    /// Starts the ranks and waits for their greeting.
    fn started(wanted: u32, watch: &InterruptWatch) -> Result<Self, LinearError> {
        let refused = |_| LinearError::Ranks(RanksError::NotStarted);
        let folder = Folder::new().map_err(refused)?;
        let path = folder.0.join("socket");
        let listener = UnixListener::bind(&path).map_err(refused)?;
        listener.set_nonblocking(true).map_err(refused)?;
        let child = start(wanted, Path::new(&path)).map_err(LinearError::Ranks)?;
        let mut ranks = Ranks { stream: None, child, wanted, count: 0, buffer: Vec::new(), matrices: 0 };
        let begun = Instant::now();
        let stream = loop {
            match listener.accept() {
                Ok((stream, _)) => break stream,
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Err(error) => return Err(refused(error)),
            }
            if watch.is_interrupted() {
                return Err(LinearError::Interrupted);
            }
            if begun.elapsed() > START || !matches!(ranks.child.try_wait(), Ok(None)) {
                return Err(LinearError::Ranks(RanksError::NotStarted));
            }
            std::thread::sleep(LOOK / 5);
        };
        stream.set_nonblocking(false).map_err(refused)?;
        stream.set_read_timeout(Some(LOOK)).map_err(refused)?;
        stream.set_write_timeout(Some(LOOK)).map_err(refused)?;
        ranks.stream = Some(stream);
        let greeting = ranks.answer(watch)?;
        ranks.receive(&mut [0; VERSION], watch)?;
        if greeting[0] != MAGIC || greeting[1] < 1 {
            return Err(LinearError::Ranks(RanksError::NotStarted));
        }
        ranks.count = greeting[1] as usize;
        Ok(ranks)
    }

    /// True if these ranks serve a solver that requests `wanted` ranks. Those of an MPI job, whose launcher has no second rank 0, serve
    /// all.
    fn is_usable(&self, wanted: u32) -> bool {
        super::launch::MpiProcess::this().is_some() || self.stream.is_some() && self.wanted == wanted
    }

    /// Returns a number for a new matrix.
    pub fn new_matrix(&mut self) -> i64 {
        self.matrices += 1;
        self.matrices
    }

    /// Ends the connection after an error, because the next byte may belong to any message. The ranks end when they find it closed.
    fn broken(&mut self, error: LinearError) -> LinearError {
        self.stream = None;
        self.buffer.clear();
        error
    }

    /// Adds bytes to the message.
    pub fn put(&mut self, bytes: &[u8], watch: &InterruptWatch) -> Result<(), LinearError> {
        self.buffer.extend_from_slice(bytes);
        if self.buffer.len() >= BUFFER { self.flush(watch) } else { Ok(()) }
    }

    /// Adds the head of a message.
    pub fn put_head(&mut self, head: Head, watch: &InterruptWatch) -> Result<(), LinearError> {
        head.iter().try_for_each(|number| self.put(&number.to_ne_bytes(), watch))
    }

    /// Sends the buffered bytes.
    pub fn flush(&mut self, watch: &InterruptWatch) -> Result<(), LinearError> {
        let mut sent = 0;
        while sent < self.buffer.len() {
            let Some(stream) = &mut self.stream else { return Err(LinearError::Ranks(RanksError::Lost)) };
            match stream.write(&self.buffer[sent..]) {
                Ok(count) if count > 0 => sent += count,
                outcome => self.go_on(outcome, watch)?,
            }
        }
        self.buffer.clear();
        Ok(())
    }

    /// Fills an array with bytes that rank 0 sends.
    pub fn receive(&mut self, into: &mut [u8], watch: &InterruptWatch) -> Result<(), LinearError> {
        let mut received = 0;
        while received < into.len() {
            let Some(stream) = &mut self.stream else { return Err(LinearError::Ranks(RanksError::Lost)) };
            match stream.read(&mut into[received..]) {
                Ok(count) if count > 0 => received += count,
                outcome => self.go_on(outcome, watch)?,
            }
        }
        Ok(())
    }

    /// Decides if a transfer without bytes is repeated: after a timeout, unless the user has interrupted.
    fn go_on(&mut self, outcome: std::io::Result<usize>, watch: &InterruptWatch) -> Result<(), LinearError> {
        let is_waiting =
            outcome.is_err_and(|error| matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted));
        match is_waiting {
            true if watch.is_interrupted() => Err(self.broken(LinearError::Interrupted)),
            true => Ok(()),
            false => Err(self.broken(LinearError::Ranks(RanksError::Lost))),
        }
    }

    /// Receives the header of an answer of rank 0.
    pub fn answer(&mut self, watch: &InterruptWatch) -> Result<Head, LinearError> {
        let mut numbers = [0.0; 8];
        self.receive_numbers(&mut numbers, watch)?;
        Ok(numbers.map(|number| number.to_bits() as i64))
    }

    /// Receives floating-point numbers.
    pub fn receive_numbers(&mut self, into: &mut [f64], watch: &InterruptWatch) -> Result<(), LinearError> {
        let mut bytes = vec![0; BUFFER.min(size_of_val(into))];
        for numbers in into.chunks_mut(BUFFER / size_of::<f64>()) {
            let bytes = &mut bytes[..size_of_val(numbers)];
            self.receive(bytes, watch)?;
            let (words, _) = bytes.as_chunks();
            numbers.iter_mut().zip(words).for_each(|(number, word)| *number = f64::from_ne_bytes(*word));
        }
        Ok(())
    }

    /// Frees a matrix on the ranks; without effect if the connection is lost.
    pub fn free(&mut self, matrix: i64) {
        let watch = InterruptWatch::default();
        if self.stream.is_some() && self.put_head(head(Command::Free, &[matrix]), &watch).is_ok() {
            let _ = self.flush(&watch);
        }
    }

    /// Ends the ranks of the distributed solver: waits for connected ones, and kills those that compute for too long.
    fn end(&mut self) {
        let watch = InterruptWatch::default();
        if self.stream.is_some() && self.put_head(head(Command::Finish, &[]), &watch).is_ok() {
            let _ = self.flush(&watch);
        }
        self.stream = None;
        let begun = Instant::now();
        while begun.elapsed() < END && matches!(self.child.try_wait(), Ok(None)) {
            std::thread::sleep(LOOK / 5);
        }
        // Both calls fail only if the process has already ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Drop for Ranks {
    fn drop(&mut self) {
        self.end();
    }
}
