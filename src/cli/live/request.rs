//! The head of a request, read within limits of time and size. The body is not read.

use std::io::{ErrorKind, Read};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// Longest head of a request `[bytes]`.
pub const LONGEST: usize = 8 << 10;
/// Largest number of lines of a head.
const LINES: usize = 64;

/// Head of a request.
#[derive(Debug, PartialEq, Eq)]
pub struct Request {
    /// Method, such as `GET`.
    pub method: String,
    /// Path and query as received.
    pub target: String,
    /// Values of all `Host` headers.
    pub hosts: Vec<String>,
}

/// Reason why there is no request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The client has closed the connection.
    Gone,
    /// The request took too long.
    Slow,
    /// The head is too long.
    Long,
    /// The bytes are not a request.
    Malformed,
}

/// Parses the bytes received so far; `None` while the head is incomplete.
///
/// # Errors
/// The bytes are not a request, or the head is too long.
pub fn parse(bytes: &[u8]) -> Result<Option<Request>, Refusal> {
    let mut lines = [httparse::EMPTY_HEADER; LINES];
    let mut head = httparse::Request::new(&mut lines);
    match head.parse(bytes) {
        Ok(httparse::Status::Complete(_)) => {}
        Ok(httparse::Status::Partial) => return if bytes.len() >= LONGEST { Err(Refusal::Long) } else { Ok(None) },
        Err(httparse::Error::TooManyHeaders) => return Err(Refusal::Long),
        Err(_) => return Err(Refusal::Malformed),
    }
    let hosts = head.headers.iter().filter(|line| line.name.eq_ignore_ascii_case("host"));
    let hosts = hosts.map(|line| String::from_utf8_lossy(line.value).into_owned()).collect();
    let (Some(method), Some(target)) = (head.method, head.path) else { return Err(Refusal::Malformed) };
    Ok(Some(Request { method: method.into(), target: target.into(), hosts }))
}

/// Reads a request until a deadline.
///
/// # Errors
/// No valid request, or not in time.
pub fn read(stream: &mut TcpStream, until: Instant) -> Result<Request, Refusal> {
    let mut bytes = Vec::new();
    loop {
        let left = until.saturating_duration_since(Instant::now());
        if left.is_zero() || stream.set_read_timeout(Some(left.max(Duration::from_millis(1)))).is_err() {
            return Err(Refusal::Slow);
        }
        let mut piece = [0; 2048];
        match stream.read(&mut piece) {
            Ok(0) => return Err(Refusal::Gone),
            Ok(count) => {
                bytes.extend(&piece[..count.min(LONGEST - bytes.len())]);
                if let Some(request) = parse(&bytes)? {
                    return Ok(request);
                }
            }
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => return Err(Refusal::Slow),
            Err(_) => return Err(Refusal::Gone),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_head_is_read_when_it_is_complete() {
        let text = b"GET /a?b=1 HTTP/1.1\r\nHost: localhost:80\r\nhost: other\r\n\r\nmore";
        for length in 0..text.len() - 4 {
            assert_eq!(parse(&text[..length]), Ok(None), "{length}");
        }
        let request = parse(text).unwrap().unwrap();
        assert_eq!((&*request.method, &*request.target), ("GET", "/a?b=1"));
        assert_eq!(request.hosts, ["localhost:80", "other"]);
    }

    #[test]
    fn what_is_no_request_or_too_long_is_refused() {
        assert_eq!(parse(b"\x16\x03\x01\x02\x00 hello of another protocol\r\n\r\n"), Err(Refusal::Malformed));
        assert_eq!(parse(b"GET / HTTP/1.1\r\nHost\r\n\r\n"), Err(Refusal::Malformed));
        let long = format!("GET /{} HTTP/1.1\r\n", "x".repeat(LONGEST));
        assert_eq!(parse(&long.as_bytes()[..LONGEST]), Err(Refusal::Long));
        let many = format!("GET / HTTP/1.1\r\n{}\r\n", "a: b\r\n".repeat(LINES + 1));
        assert_eq!(parse(many.as_bytes()), Err(Refusal::Long));
    }
}
