//! Files that are read as a whole: regular ones, that fit into memory.
//!
//! A pipe has no end until it is closed, and a device may have none at all: reading one by mistake would never return.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

use super::memory;

/// Memory needed per byte of a file while it is read and parsed.
const SHARE: u64 = 4;

/// Opens a regular file and returns it with its length.
///
/// # Errors
/// The operating system refused; a pipe, a socket or a device.
pub fn open(path: &Path) -> Result<(File, u64)> {
    // Opening a pipe may block.
    let found = std::fs::metadata(path)?;
    if !found.is_file() && !found.is_dir() {
        return Err(Error::new(ErrorKind::InvalidInput, "it is a pipe or a device, not a file"));
    }
    Ok((File::open(path)?, found.len()))
}

/// Returns the bytes of a regular file.
///
/// # Errors
/// Errors of [`open`]; a file that does not fit into memory.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    let (mut file, length) = open(path)?;
    memory::ensure(SHARE.saturating_mul(length)).map_err(|shortage| Error::new(ErrorKind::OutOfMemory, shortage))?;
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The text of a regular file.
///
/// # Errors
/// Errors of [`read`]; a file that is no text.
pub fn read_text(path: &Path) -> Result<String> {
    String::from_utf8(read(path)?).map_err(|_| Error::new(ErrorKind::InvalidData, "it is not text (UTF-8)"))
}
