//! Runs work that cannot be stopped on a separate thread, so that an interrupt need not wait for it.

use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

/// Longest delay of the reaction to an interrupt.
const PATIENCE: Duration = Duration::from_millis(20);

/// Stack size of the thread; memory is used only as the stack grows.
const STACK: usize = 64 << 20;

/// Message from the thread of the work.
enum Word<Q, T> {
    Question(Q),
    Result(T),
}

/// Returns the result of work that does not check the flag itself; `None` if the flag becomes true first.
///
/// The work runs on a thread of its own, which is abandoned after an interrupt. A panic of the work is passed on to the caller.
pub fn watched<T: Send + 'static>(interrupt: &Arc<AtomicBool>, work: impl FnOnce() -> T + Send + 'static) -> Option<T> {
    consulted(interrupt, |_: &dyn Fn(()) -> Option<()>| work(), |()| ())
}

/// Returns the result of work that queries its caller, which answers on its own thread; `None` after an interrupt.
///
/// The work runs on a thread of its own. After an interrupt its questions return `None`.
pub fn consulted<T: Send + 'static, Q: Send + 'static, A: Send + 'static>(
    interrupt: &Arc<AtomicBool>,
    work: impl FnOnce(&dyn Fn(Q) -> Option<A>) -> T + Send + 'static,
    mut answer: impl FnMut(Q) -> A,
) -> Option<T> {
    let (words, heard) = mpsc::channel();
    let (answers, known) = mpsc::channel();
    let thread = std::thread::Builder::new().name("watched".into()).stack_size(STACK).spawn(move || {
        let ask = |question: Q| {
            words.send(Word::Question(question)).ok()?;
            known.recv().ok()
        };
        let result = work(&ask);
        // After an interrupt the receiver no longer exists.
        let _ = words.send(Word::Result(result));
    });
    // Without threads hardly any work is possible.
    let thread = thread.unwrap_or_else(|error| panic!("no thread could be started: {error}"));
    loop {
        match heard.recv_timeout(PATIENCE) {
            Ok(Word::Result(result)) => return Some(result),
            Ok(Word::Question(question)) => drop(answers.send(answer(question))),
            Err(RecvTimeoutError::Timeout) if interrupt.load(Ordering::Relaxed) => return None,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => match thread.join() {
                Err(panic) => resume_unwind(panic),
                Ok(()) => return None,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Instant;

    #[test]
    fn work_is_done_left_behind_or_panics() {
        let flag = Arc::new(AtomicBool::new(false));
        assert_eq!(watched(&flag, || 7), Some(7));
        let panicked = std::panic::catch_unwind(|| watched(&Arc::default(), || panic!("inside")));
        assert_eq!(panicked.unwrap_err().downcast_ref::<&str>(), Some(&"inside"));
        let sum = consulted(&flag, |ask: &dyn Fn(i32) -> Option<i32>| (1..4).filter_map(ask).sum::<i32>(), |asked| 10 * asked);
        assert_eq!(sum, Some(60));
        let begun = Instant::now();
        let raise = flag.clone();
        std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(50));
            raise.store(true, Ordering::Relaxed);
        });
        assert_eq!(watched(&flag, || std::thread::sleep(Duration::from_secs(20))), None);
        assert!(begun.elapsed() < Duration::from_secs(5));
    }
}
