//! Answers to requests for the page and its updates, only at the complete address.
//!
//! The address contains a secret, unknown to other users of the machine and to other pages. A page under another name that resolves to this
//! machine is refused by the header `Host`.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::request::{Refusal, Request};
use crate::output::{LiveReport, ReportChanges};

/// Time for which a page is reused for further readers, who request later changes.
const FRESH: Duration = Duration::from_secs(2);
/// Time for which an update is reused for further readers in the same state.
const NEW: Duration = Duration::from_millis(250);
/// Time after its last request from which a reader counts as gone at the end of the run.
const AWAY: Duration = Duration::from_secs(2);
/// Largest number of readers, and of updates kept for readers.
const READERS: usize = 1024;
/// Largest number of pages kept.
const PAGES: usize = 8;

/// An answer.
pub struct Answer {
    /// Status code and text.
    pub status: &'static str,
    /// Content type.
    pub kind: &'static str,
    /// The content.
    pub body: Arc<Vec<u8>>,
    /// True if only the head is sent.
    pub is_head: bool,
}

impl Answer {
    fn new(status: &'static str, kind: &'static str, body: impl Into<Arc<Vec<u8>>>) -> Self {
        Answer { status, kind, body: body.into(), is_head: false }
    }

    fn text(status: &'static str, text: &str) -> Self {
        Answer::new(status, "text/plain; charset=utf-8", format!("{text}\n").into_bytes())
    }

    /// Returns the answer to a connection beyond the limit.
    pub fn busy() -> Self {
        Answer::text("503 Service Unavailable", "too many connections at once")
    }

    /// Returns the answer to an invalid request; `None` if the client has gone.
    pub fn refusal(refusal: Refusal) -> Option<Self> {
        match refusal {
            Refusal::Gone => None,
            Refusal::Slow => Some(Answer::text("408 Request Timeout", "the request took too long")),
            Refusal::Long => Some(Answer::text("431 Request Header Fields Too Large", "the request is too long")),
            Refusal::Malformed => Some(Answer::text("400 Bad Request", "this is no request")),
        }
    }

    /// Returns the bytes of the answer up to its content.
    pub fn head(&self) -> Vec<u8> {
        let policy = if self.kind.starts_with("text/html") {
            "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:; connect-src 'self'; \
             base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
        } else {
            "default-src 'none'; frame-ancestors 'none'"
        };
        let allow = if self.status.starts_with("405") { "Allow: GET, HEAD\r\n" } else { "" };
        format!(
            "HTTP/1.1 {}\r\nContent-Type: {}\r\nContent-Length: {}\r\n{allow}Cache-Control: no-store\r\n\
             Content-Security-Policy: {policy}\r\nX-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n\
             Cross-Origin-Resource-Policy: same-origin\r\n\
             Connection: close\r\n\r\n",
            self.status,
            self.kind,
            self.body.len()
        )
        .into_bytes()
    }
}

/// Moment of a reader's last request, and true if the reader has received the outcome of the run.
type Reader = (Instant, bool);

/// Recent answers with their time: pages by simulation, updates by the last change that the reader has. Many readers request equal data.
#[derive(Default)]
struct Made {
    pages: HashMap<Option<usize>, (Instant, Arc<Vec<u8>>)>,
    news: HashMap<(Option<usize>, u64), (Instant, Arc<ReportChanges>)>,
}

/// Content that is served.
pub struct Site {
    live: Arc<LiveReport>,
    port: u16,
    secret: String,
    /// Lock for encoding, held by one thread at a time, so that readers never take more than one processor from the run.
    encoding: Mutex<Made>,
    readers: Mutex<HashMap<u64, Reader>>,
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// True if two texts are equal; for texts of equal length the time does not depend on where they differ.
fn are_equal(a: &str, b: &str) -> bool {
    a.len() == b.len() && a.bytes().zip(b.bytes()).fold(0, |differences, (a, b)| differences | (a ^ b)) == 0
}

impl Site {
    /// Returns a site that is served at `port` and requires `secret` in the address.
    pub fn new(live: Arc<LiveReport>, port: u16, secret: String) -> Self {
        Site { live, port, secret, encoding: Mutex::default(), readers: Mutex::default() }
    }

    /// Address of the page.
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/{}/", self.port, self.secret)
    }

    /// Returns the answer to a request.
    pub fn answer(&self, request: &Request) -> Answer {
        let names = [format!("127.0.0.1:{}", self.port), format!("localhost:{}", self.port)];
        let [host] = &request.hosts[..] else { return Answer::text("400 Bad Request", "a request names one host") };
        if !names.iter().any(|name| name.eq_ignore_ascii_case(host)) {
            return Answer::text("403 Forbidden", "this host is not served here");
        }
        if !["GET", "HEAD"].contains(&&*request.method) {
            return Answer::text("405 Method Not Allowed", "this can only be read");
        }
        let answer = self.content(&request.target).unwrap_or_else(|| Answer::text("404 Not Found", "there is nothing at this address"));
        Answer { is_head: request.method == "HEAD", ..answer }
    }

    fn content(&self, target: &str) -> Option<Answer> {
        let (path, query) = target.split_once('?').unwrap_or((target, ""));
        let (secret, name) = path.strip_prefix('/')?.split_once('/')?;
        if !are_equal(secret, &self.secret) {
            return None;
        }
        let value =
            |key: &str| query.split('&').filter_map(|pair| pair.split_once('=')).find(|(name, _)| *name == key).map(|(_, value)| value);
        // A value that is no number is ignored.
        let simulation = value("simulation").and_then(|text| text.parse().ok());
        match name {
            "" => Some(Answer::new("200 OK", "text/html; charset=utf-8", self.page(simulation))),
            "data" => {
                let known = value("since").and_then(|text| text.parse().ok()).unwrap_or(0);
                let news = self.news(simulation, known);
                if let Some(reader) = value("reader").and_then(|text| text.parse().ok()) {
                    self.note(reader, news.is_last);
                }
                Some(Answer::new("200 OK", "application/json", news.bytes.clone()))
            }
            _ => None,
        }
    }

    fn page(&self, simulation: Option<usize>) -> Arc<Vec<u8>> {
        let mut made = locked(&self.encoding);
        made.pages.retain(|_, (at, _)| at.elapsed() < FRESH);
        if made.pages.len() >= PAGES {
            made.pages.clear();
        }
        let make = || (Instant::now(), Arc::new(self.live.page(simulation)));
        made.pages.entry(simulation).or_insert_with(make).1.clone()
    }

    fn news(&self, simulation: Option<usize>, known: u64) -> Arc<ReportChanges> {
        let mut made = locked(&self.encoding);
        let is_over = self.live.is_over();
        made.news.retain(|_, (at, news)| at.elapsed() < NEW && news.is_last == is_over);
        if made.news.len() >= READERS {
            made.news.clear();
        }
        let make = || (Instant::now(), Arc::new(self.live.news(simulation, known)));
        made.news.entry((simulation, known)).or_insert_with(make).1.clone()
    }

    fn note(&self, reader: u64, knows_end: bool) {
        let mut readers = locked(&self.readers);
        if readers.len() >= READERS {
            readers.retain(|_, (at, _)| at.elapsed() < AWAY);
        }
        if readers.len() < READERS {
            readers.insert(reader, (Instant::now(), knows_end));
        }
    }

    /// True if a reader who is present has not received the end of the run yet.
    pub fn has_readers(&self) -> bool {
        locked(&self.readers).values().any(|(at, knows_end)| !knows_end && at.elapsed() < AWAY)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn status(method: &str, target: &str, hosts: &[&str]) -> &'static str {
        let site = Site::new(Arc::new(LiveReport::new("out".into())), 4711, "secret".into());
        let hosts = hosts.iter().map(ToString::to_string).collect();
        site.answer(&Request { method: method.into(), target: target.into(), hosts }).status
    }

    #[test]
    fn only_those_who_know_the_address_get_an_answer() {
        let own = ["127.0.0.1:4711"];
        for target in ["/secret/", "/secret/data", "/secret/data?since=3&simulation=0", "/secret/?simulation=x"] {
            for (method, hosts) in [("GET", own), ("HEAD", own), ("GET", ["LOCALHOST:4711"])] {
                assert_eq!(status(method, target, &hosts), "200 OK", "{method} {target}");
            }
        }
        for target in [
            "/",
            "/secret",
            "/secreT/",
            "/secre/",
            "/secrets/",
            "//secret/",
            "/secret/page",
            "/secret/data/",
            "*",
            "http://127.0.0.1:4711/secret/",
        ] {
            assert_eq!(status("GET", target, &own), "404 Not Found", "{target}");
        }
        for host in ["evil.example:4711", "127.0.0.1", "127.0.0.1:4712", "localhost:4711.evil.example", "", "[::1]:4711"] {
            assert_eq!(status("GET", "/secret/", &[host]), "403 Forbidden", "{host}");
        }
        for method in ["POST", "PUT", "DELETE", "OPTIONS", "CONNECT", "get"] {
            assert_eq!(status(method, "/secret/", &own), "405 Method Not Allowed", "{method}");
        }
        assert_eq!(status("GET", "/secret/", &[]), "400 Bad Request");
        assert_eq!(status("GET", "/secret/", &["127.0.0.1:4711", "evil.example"]), "400 Bad Request");
    }
}
