//! Connections: so many at once, each with a thread and with bounded times for its request and its answer.
//!
//! Nobody who connects can hold up the run: its thread takes no part in this.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{Ipv4Addr, Shutdown, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::{self, Builder};
use std::time::{Duration, Instant};

use super::request;
use super::site::{Answer, Site};

/// Connections that are served at once.
const MOST: usize = 128;
/// Connections that wait to be refused.
const REFUSED: usize = 64;
/// Longest time for a request.
const ASKING: Duration = Duration::from_secs(5);
/// Longest time for an answer, and for a piece of it.
const ANSWERING: [Duration; 2] = [Duration::from_secs(20), Duration::from_secs(5)];
/// Time for one that is refused.
const REFUSING: Duration = Duration::from_millis(50);
/// Bytes of an answer that are written at once.
const PIECE: usize = 64 << 10;
/// Stack of a connection's thread.
const STACK: usize = 1 << 20;

/// Opens a port of this machine alone; 0 takes any that is free.
///
/// # Errors
/// The port is taken, or may not be used.
pub fn open(port: u16) -> io::Result<TcpListener> {
    TcpListener::bind((Ipv4Addr::LOCALHOST, port))
}

/// Serves from threads of their own until the process ends.
///
/// # Errors
/// No thread can be started.
pub fn serve(listener: TcpListener, site: Arc<Site>) -> io::Result<()> {
    let (refuse, refused) = sync_channel(REFUSED);
    thread("page-refuse", move || refuse_all(refused))?;
    thread("page", move || {
        let open = Arc::new(AtomicUsize::new(0));
        for stream in listener.incoming() {
            let Ok(stream) = stream else {
                // Such as too many open files: it may pass.
                thread::sleep(REFUSING);
                continue;
            };
            let place = Place::take(&open);
            if place.0.load(Ordering::Relaxed) > MOST {
                // Where too many wait to be refused, they are told nothing.
                let _ = refuse.try_send(stream);
                continue;
            }
            let site = site.clone();
            // Without a thread the connection closes.
            let _ = thread("page-answer", move || {
                let _place = place;
                converse(stream, &site);
            });
        }
    })
}

fn thread(name: &str, work: impl FnOnce() + Send + 'static) -> io::Result<()> {
    Builder::new().name(name.into()).stack_size(STACK).spawn(work).map(drop)
}

/// One of the connections that are open.
struct Place(Arc<AtomicUsize>);

impl Place {
    fn take(open: &Arc<AtomicUsize>) -> Self {
        open.fetch_add(1, Ordering::Relaxed);
        Place(open.clone())
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

fn refuse_all(refused: Receiver<TcpStream>) {
    for mut stream in refused {
        let until = Instant::now() + REFUSING;
        let _ = request::read(&mut stream, until);
        let _ = send(&mut stream, &Answer::busy(), until + REFUSING, REFUSING);
        close(stream, REFUSING);
    }
}

/// A request and its answer.
fn converse(mut stream: TcpStream, site: &Site) {
    let answer = match request::read(&mut stream, Instant::now() + ASKING) {
        Ok(request) => Some(site.answer(&request)),
        Err(refusal) => Answer::refusal(refusal),
    };
    if let Some(answer) = answer
        && send(&mut stream, &answer, Instant::now() + ANSWERING[0], ANSWERING[1]).is_ok()
    {
        close(stream, REFUSING);
    }
}

/// Writes an answer until a moment, with so much time for a piece of it.
fn send(stream: &mut TcpStream, answer: &Answer, until: Instant, patience: Duration) -> io::Result<()> {
    let mut write = |bytes: &[u8]| {
        let mut rest = bytes;
        while !rest.is_empty() {
            let left = until.saturating_duration_since(Instant::now()).min(patience);
            if left.is_zero() {
                return Err(ErrorKind::TimedOut.into());
            }
            stream.set_write_timeout(Some(left.max(Duration::from_millis(1))))?;
            match stream.write(&rest[..rest.len().min(PIECE)]) {
                Ok(0) => return Err(ErrorKind::WriteZero.into()),
                Ok(count) => rest = &rest[count..],
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    };
    write(&answer.head())?;
    if answer.is_head { Ok(()) } else { write(&answer.body) }
}

/// Closes a connection after what the other side still sends, so that it reads the answer before it hears of the end.
fn close(mut stream: TcpStream, patience: Duration) {
    let until = Instant::now() + patience;
    let mut rest = [0; 4096];
    if stream.shutdown(Shutdown::Write).is_err() || stream.set_read_timeout(Some(patience)).is_err() {
        return;
    }
    while Instant::now() < until && stream.read(&mut rest).is_ok_and(|count| count > 0) {}
}
