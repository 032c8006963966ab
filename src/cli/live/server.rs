//! Connections: a limited number, each with a thread and limited times for request and answer.
//!
//! Clients cannot delay the run, whose thread is not involved.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{Ipv4Addr, Shutdown, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::{self, Builder};
use std::time::{Duration, Instant};

use super::request;
use super::site::{Answer, Site};

/// Largest number of simultaneous connections.
const MOST: usize = 128;
/// Largest number of connections that wait to be refused.
const REFUSED: usize = 64;
/// Longest time for a request.
const ASKING: Duration = Duration::from_secs(5);
/// Longest time for an answer, and for a piece of an answer.
const ANSWERING: [Duration; 2] = [Duration::from_secs(20), Duration::from_secs(5)];
/// Time for a connection that is refused.
const REFUSING: Duration = Duration::from_millis(50);
/// Number of bytes of an answer that are written at once.
const PIECE: usize = 64 << 10;
/// Stack size of a connection's thread `[bytes]`.
const STACK: usize = 1 << 20;

/// Opens a port of the local host; 0 for any free one.
///
/// # Errors
/// The port is taken, or not permitted.
pub fn open(port: u16) -> io::Result<TcpListener> {
    TcpListener::bind((Ipv4Addr::LOCALHOST, port))
}

/// Serves in separate threads until the process ends.
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
                // Errors such as too many open files may be temporary.
                thread::sleep(REFUSING);
                continue;
            };
            let place = ConnectionSlot::take(&open);
            if place.0.load(Ordering::Relaxed) > MOST {
                // Beyond the limit, connections are closed without an answer.
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

/// Slot of an open connection.
struct ConnectionSlot(Arc<AtomicUsize>);

impl ConnectionSlot {
    fn take(open: &Arc<AtomicUsize>) -> Self {
        open.fetch_add(1, Ordering::Relaxed);
        ConnectionSlot(open.clone())
    }
}

impl Drop for ConnectionSlot {
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

/// Reads a request and sends its answer.
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

/// Sends an answer until a deadline, with `patience` as the time limit of each piece.
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

/// Closes a connection after reading the client's remaining data, so that the client receives the answer before the end of the connection.
fn close(mut stream: TcpStream, patience: Duration) {
    let until = Instant::now() + patience;
    let mut rest = [0; 4096];
    if stream.shutdown(Shutdown::Write).is_err() || stream.set_read_timeout(Some(patience)).is_err() {
        return;
    }
    while Instant::now() < until && stream.read(&mut rest).is_ok_and(|count| count > 0) {}
}
