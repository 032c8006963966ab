//! Conversion of places to the protocol: lines and UTF-16 units from 0, and files as addresses.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::protocol::{self, Position};

/// Returns the byte of a position; a position beyond the end of the line or text is moved to this end.
pub fn byte_of(text: &str, position: Position) -> usize {
    let mut start = 0;
    for _ in 0..position.line {
        match text[start..].find('\n') {
            Some(newline) => start += newline + 1,
            None => return text.len(),
        }
    }
    let mut units = 0;
    let line = text[start..].split('\n').next().unwrap_or("").trim_end_matches('\r');
    for (byte, letter) in line.char_indices() {
        if units >= position.character as usize {
            return start + byte;
        }
        units += letter.len_utf16();
    }
    start + line.len()
}

/// Returns the position of a byte.
pub fn position_of(text: &str, byte: usize) -> Position {
    let mut byte = byte.min(text.len());
    while !text.is_char_boundary(byte) {
        byte -= 1;
    }
    let before = &text[..byte];
    let start = before.rfind('\n').map_or(0, |newline| newline + 1);
    let units: usize = before[start..].chars().map(char::len_utf16).sum();
    let count = |number: usize| u32::try_from(number).unwrap_or(u32::MAX);
    Position { line: count(before.matches('\n').count()), character: count(units) }
}

/// Returns the range of bytes.
pub fn range_of(text: &str, bytes: &Range<usize>) -> protocol::Range {
    protocol::Range { start: position_of(text, bytes.start), end: position_of(text, bytes.end.max(bytes.start)) }
}

/// Returns the file of an address; `None` for texts that are no files.
pub fn file_of(uri: &str) -> Option<PathBuf> {
    let path = uri.strip_prefix("file://")?;
    let path = &path[path.find('/')?..];
    let mut bytes = Vec::with_capacity(path.len());
    let mut rest = path.as_bytes();
    while let [first, after @ ..] = rest {
        let code = after.get(..2).filter(|_| *first == b'%').and_then(|digits| std::str::from_utf8(digits).ok());
        match code.and_then(|digits| u8::from_str_radix(digits, 16).ok()) {
            Some(byte) => (bytes.push(byte), rest = &after[2..]).1,
            None => (bytes.push(*first), rest = after).1,
        }
    }
    let path = String::from_utf8(bytes).ok()?;
    // `/c:/folder` of Windows.
    let is_drive = matches!(path.as_bytes(), [b'/', letter, b':', ..] if letter.is_ascii_alphabetic());
    Some(PathBuf::from(if is_drive { &path[1..] } else { &path }))
}

/// Returns the address of a file.
pub fn address_of(file: &Path) -> Option<String> {
    let path = file.to_str()?.replace('\\', "/");
    let mut text = String::from(if path.starts_with('/') { "file://" } else { "file:///" });
    for byte in path.bytes() {
        match byte {
            b'/' | b'-' | b'.' | b'_' | b'~' => text.push(char::from(byte)),
            _ if byte.is_ascii_alphanumeric() => text.push(char::from(byte)),
            _ => text += &format!("%{byte:02X}"),
        }
    }
    Some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_count_units_of_utf16() {
        let text = "aä𝄞b\r\n\nx";
        for (line, character, byte) in
            [(0, 0, 0), (0, 1, 1), (0, 2, 3), (0, 4, 7), (0, 5, 8), (0, 99, 8), (1, 3, 10), (2, 1, 12), (9, 0, 12)]
        {
            assert_eq!(byte_of(text, Position { line, character }), byte, "{line}:{character}");
        }
        assert_eq!(position_of(text, 7), Position { line: 0, character: 4 });
        assert_eq!(position_of(text, 99), Position { line: 2, character: 1 });
        assert_eq!(position_of(text, 5), Position { line: 0, character: 2 });
    }

    #[test]
    fn files_have_addresses() {
        let file = Path::new("/a b/ä%.rhai");
        let address = address_of(file).unwrap();
        assert_eq!(address, "file:///a%20b/%C3%A4%25.rhai");
        assert_eq!(file_of(&address).unwrap(), file);
        assert_eq!(file_of("file:///c%3A/x").unwrap(), Path::new("c:/x"));
        assert_eq!(file_of("untitled:a"), None);
    }
}
