//! Available memory of this process, and refusal of computations that would exceed it.
//!
//! The memory of a mesh, a simulation or a factorization is estimated before allocation, because operating systems grant more memory than
//! exists and kill the process when it runs out. Available is the least of the machine's free memory and the unused parts of the limits of
//! container, address space and process ([`set_limit`]). Linux provides these numbers; other systems refuse nothing.

use std::fmt::{Display, Formatter};
use std::sync::atomic::{AtomicU64, Ordering};

/// Memory limit of this process in bytes; the maximum stands for no limit.
static LIMIT: AtomicU64 = AtomicU64::new(u64::MAX);

/// Bytes reserved for the operating system.
const RESERVE: u64 = 128 << 20;

/// Number of bytes below which the memory left is not checked.
const SMALL: u64 = 4 << 20;

/// Shortage of memory: bytes needed, and bytes left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shortage {
    /// Estimated number of bytes needed.
    pub needed: u64,
    /// Number of bytes left.
    pub left: u64,
}

impl Display for Shortage {
    fn fmt(&self, out: &mut Formatter<'_>) -> std::fmt::Result {
        write!(out, "it takes about {} of memory, and {} are left", written(self.needed), written(self.left))
    }
}

impl std::error::Error for Shortage {}

impl Shortage {
    /// Returns the stable code of the error, which `conserva doc` explains.
    pub fn code(&self) -> &'static str {
        "C0531"
    }
}

/// Formats bytes in the largest suitable unit: `4.1 GB`, `512 MB`.
pub fn written(bytes: u64) -> String {
    let units = [(1e12, "TB"), (1e9, "GB"), (1e6, "MB"), (1e3, "kB")];
    let value = bytes as f64;
    match units.into_iter().find(|(unit, _)| value >= *unit) {
        Some((unit, name)) if value < 10.0 * unit => format!("{:.1} {name}", value / unit),
        Some((unit, name)) => format!("{:.0} {name}", value / unit),
        None => format!("{bytes} bytes"),
    }
}

/// Limits the total memory of this process, in bytes.
pub fn set_limit(bytes: u64) {
    LIMIT.store(bytes, Ordering::Relaxed);
}

/// Memory limit of this process set by [`set_limit`]; `None` without one.
pub fn limit() -> Option<u64> {
    Some(LIMIT.load(Ordering::Relaxed)).filter(|&limit| limit < u64::MAX)
}

/// Refuses an allocation of more bytes than are available.
///
/// # Errors
/// A [`Shortage`] if `bytes` exceeds the memory that is left.
pub fn ensure(bytes: u64) -> Result<(), Shortage> {
    if bytes < SMALL {
        return Ok(());
    }
    match left() {
        Some(left) if bytes > left => Err(Shortage { needed: bytes, left }),
        _ => Ok(()),
    }
}

/// Number of available bytes; `None` if the system does not provide it.
pub fn left() -> Option<u64> {
    let own = limit().and_then(|limit| Some(limit.saturating_sub(used()?)));
    let machine = [available(), address_space()].into_iter().flatten().min().map(|bytes| bytes.saturating_sub(RESERVE));
    [own, machine, container()].into_iter().flatten().min()
}

/// Bytes of memory used by this process.
fn used() -> Option<u64> {
    kilobytes("/proc/self/status", "VmRSS:")
}

/// Bytes that the machine can provide without swapping.
fn available() -> Option<u64> {
    kilobytes("/proc/meminfo", "MemAvailable:")
}

/// Bytes left under a limit of address space (`ulimit -v`).
fn address_space() -> Option<u64> {
    let limits = std::fs::read_to_string("/proc/self/limits").ok()?;
    let most = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?.split_whitespace().next()?.parse::<u64>().ok()?;
    Some(most.saturating_sub(kilobytes("/proc/self/status", "VmSize:")?))
}

/// Bytes left in the control group (version 2) of this process and in its parent groups.
fn container() -> Option<u64> {
    let groups = std::fs::read_to_string("/proc/self/cgroup").ok()?;
    let path = groups.lines().find_map(|line| line.strip_prefix("0::"))?;
    let read = |folder: &std::path::Path, name: &str| std::fs::read_to_string(folder.join(name)).ok()?.trim().parse::<u64>().ok();
    let own = std::path::Path::new("/sys/fs/cgroup").join(path.trim_start_matches('/'));
    let left = own.ancestors().take_while(|folder| folder.starts_with("/sys/fs/cgroup")).filter_map(|folder| {
        let (most, current) = (read(folder, "memory.max")?, read(folder, "memory.current")?);
        Some(most.saturating_sub(current).saturating_sub(RESERVE.min(most / 8)))
    });
    left.min()
}

/// Number of kB after the key `word` in a file of the system, in bytes.
fn kilobytes(file: &str, word: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let number = text.lines().find_map(|line| line.strip_prefix(word))?.split_whitespace().next()?.parse::<u64>().ok()?;
    Some(1024 * number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_is_told_and_what_does_not_fit_is_refused() {
        assert_eq!([999, 1000, 4_100_000_000, 512_000_000].map(written), ["999 bytes", "1.0 kB", "4.1 GB", "512 MB"]);
        assert_eq!(ensure(1000), Ok(()));
        if let Some(left) = left() {
            assert!(left > SMALL, "{left}");
            let shortage = ensure(1 << 60).unwrap_err();
            assert!(shortage.to_string().starts_with("it takes about 1152922 TB of memory, and "), "{shortage}");
        }
    }
}
