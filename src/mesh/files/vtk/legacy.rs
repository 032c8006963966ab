//! Grids in the legacy format (VTK file formats, "Simple legacy formats"), as text or binary, versions 1 to 5.1.

use super::data::{Numbers, Scalar, of_bytes, of_text};
use super::grid::{Content, GridPiece};
use crate::mesh::MeshError;
use crate::mesh::file_error::{FileError, FilePosition, FileProblem};
use crate::mesh::files::words::malformed;

/// Reads the content of a VTK file in the legacy format.
pub(in crate::mesh::files) fn read(bytes: &[u8]) -> Result<Content, MeshError> {
    let mut file = File { bytes, at: 0, is_binary: false };
    // Skips the line of the version and the title.
    file.line();
    file.line();
    let format = file.line().unwrap_or_default();
    file.is_binary = match format.to_ascii_uppercase().as_str() {
        "ASCII" => false,
        "BINARY" => true,
        _ => return Err(malformed(file.place(), "ASCII or BINARY", &format)),
    };
    let (mut content, mut piece) = (Content::new(), None);
    let mut section = Section::File;
    while let Some(line) = file.next_line() {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let at = file.place();
        let count = |k: usize| -> Result<usize, MeshError> {
            words.get(k).and_then(|word| word.parse().ok()).ok_or_else(|| malformed(at, "a number behind the keyword", &line))
        };
        match words[0].to_ascii_uppercase().as_str() {
            "DATASET" if words.get(1).is_some_and(|kind| kind.eq_ignore_ascii_case("UNSTRUCTURED_GRID")) => {}
            "DATASET" => {
                let found = format!("VTK data of the type {}", words.get(1).unwrap_or(&"nothing"));
                let cure = "save it as an unstructured grid, in ParaView by the filter \"Append Datasets\"";
                return Err(FileError { at, problem: FileProblem::Form { found, cure } }.into());
            }
            "POINTS" => {
                let points = file.numbers(count(1)?.saturating_mul(3), word(&words, 2))?.reals();
                piece.get_or_insert_with(|| GridPiece::empty(at)).points = points;
            }
            "CELLS" => cells(&mut file, piece.get_or_insert_with(|| GridPiece::empty(at)), [count(1)?, count(2)?])?,
            "CELL_TYPES" => {
                let types = file.whole(count(1)?, "int")?;
                piece.get_or_insert_with(|| GridPiece::empty(at)).types = types;
            }
            "CELL_DATA" => section = Section::Cells(count(1)?),
            "POINT_DATA" => section = Section::Points(count(1)?),
            "METADATA" => while file.line().is_some_and(|line| !line.is_empty()) {},
            _ => data(&mut file, &words, section, piece.get_or_insert_with(|| GridPiece::empty(at)), &mut content)?,
        }
    }
    let missing = |section| FileError { at: file.place(), problem: FileProblem::MissingSection { section } };
    let piece = piece.filter(|piece| !piece.points.is_empty()).ok_or_else(|| missing("POINTS"))?;
    if piece.types.len() != piece.ends.len() {
        let problem = FileProblem::Count { section: "CELL_TYPES", announced: piece.ends.len(), found: piece.types.len() };
        return Err(FileError { at: file.place(), problem }.into());
    }
    content.add(piece, &Default::default())?;
    Ok(content)
}

/// Data set to which the following arrays belong: the file, its points or its cells.
#[derive(Clone, Copy)]
enum Section {
    File,
    Points(usize),
    Cells(usize),
}

impl GridPiece {
    fn empty(at: FilePosition) -> GridPiece {
        GridPiece { points: Vec::new(), connectivity: Vec::new(), ends: Vec::new(), types: Vec::new(), groups: Vec::new(), at: [at; 2] }
    }
}

fn word<'a>(words: &[&'a str], index: usize) -> &'a str {
    words.get(index).copied().unwrap_or_default()
}

/// Reads cells: until version 4 each with the number of its nodes before them, from version 5 on as offsets and connectivity.
fn cells(file: &mut File, piece: &mut GridPiece, [count, size]: [usize; 2]) -> Result<(), MeshError> {
    piece.at[1] = file.place();
    let before = file.at;
    let line = file.next_line().unwrap_or_default();
    if line.to_ascii_uppercase().starts_with("OFFSETS") {
        let kind = |line: &str| line.split_ascii_whitespace().nth(1).unwrap_or_default().to_string();
        // The first offset is 0, the last one the length of the connectivity.
        let offsets = file.whole(count, &kind(&line))?;
        piece.ends = offsets.get(1..).map(<[i64]>::to_vec).unwrap_or_default();
        let line = file.next_line().unwrap_or_default();
        if !line.to_ascii_uppercase().starts_with("CONNECTIVITY") {
            return Err(malformed(file.place(), "CONNECTIVITY", &line));
        }
        piece.connectivity = file.whole(size, &kind(&line))?;
        return Ok(());
    }
    file.at = before;
    let numbers = file.whole(size, "int")?;
    let mut rest = &numbers[..];
    for _ in 0..count {
        let nodes = rest.split_first().and_then(|(&nodes, rest)| rest.split_at_checked(usize::try_from(nodes).ok()?));
        let Some((nodes, others)) = nodes else {
            let problem = FileProblem::Count { section: "CELLS", announced: count, found: piece.ends.len() };
            return Err(FileError { at: piece.at[1], problem }.into());
        };
        piece.connectivity.extend(nodes);
        piece.ends.push(piece.connectivity.len() as i64);
        rest = others;
    }
    Ok(())
}

/// Reads an array of points or cells, or the fields of a file; single whole numbers of cells are groups.
fn data(file: &mut File, words: &[&str], section: Section, piece: &mut GridPiece, content: &mut Content) -> Result<(), MeshError> {
    let at = file.place();
    let expected = "a keyword of the legacy format, such as CELLS or SCALARS";
    let tuples = match section {
        Section::Points(count) | Section::Cells(count) => count,
        Section::File => 0,
    };
    let mut keep = |name: &str, numbers: Numbers, components: usize| match numbers {
        Numbers::Whole(values) if components == 1 && matches!(section, Section::Cells(count) if count == values.len()) => {
            piece.groups.push((name.into(), values));
        }
        _ if !matches!(section, Section::File) => content.leave_out(name),
        _ => {}
    };
    let components = match words[0].to_ascii_uppercase().as_str() {
        "SCALARS" => word(words, 3).parse().unwrap_or(1),
        "VECTORS" | "NORMALS" => 3,
        "TENSORS" => 9,
        "TENSORS6" => 6,
        "TEXTURE_COORDINATES" => word(words, 2).parse().map_err(|_| malformed(at, "a number behind the keyword", word(words, 2)))?,
        "GLOBAL_IDS" | "PEDIGREE_IDS" => 1,
        "LOOKUP_TABLE" => {
            // Colors of a lookup table, which are skipped: bytes in a binary file, numbers from 0 to 1 in a text.
            let count: usize = word(words, 2).parse().unwrap_or(0);
            return file.numbers(count.saturating_mul(4), if file.is_binary { "unsigned_char" } else { "float" }).map(drop);
        }
        "COLOR_SCALARS" => {
            let count: usize = word(words, 2).parse().unwrap_or(1);
            return file.numbers(count.saturating_mul(tuples), if file.is_binary { "unsigned_char" } else { "float" }).map(drop);
        }
        "FIELD" => {
            let arrays: usize = word(words, 2).parse().map_err(|_| malformed(at, "the number of arrays", word(words, 2)))?;
            for _ in 0..arrays {
                let mut line = file.next_line().unwrap_or_default();
                if line.starts_with("METADATA") {
                    while file.line().is_some_and(|line| !line.is_empty()) {}
                    line = file.next_line().unwrap_or_default();
                }
                let parts: Vec<&str> = line.split_ascii_whitespace().collect();
                let [name, components, count, kind] = parts[..] else {
                    return Err(malformed(file.place(), "an array with name, components, count and type", &line));
                };
                let (Ok(components), Ok(count)) = (components.parse::<usize>(), count.parse::<usize>()) else {
                    return Err(malformed(file.place(), "an array with name, components, count and type", &line));
                };
                let numbers = file.numbers(components.saturating_mul(count), kind)?;
                keep(&decoded(name), numbers, components);
            }
            return Ok(());
        }
        _ => return Err(malformed(at, expected, words[0])),
    };
    let kind = word(words, if words[0].eq_ignore_ascii_case("TEXTURE_COORDINATES") { 3 } else { 2 });
    if words[0].eq_ignore_ascii_case("SCALARS") {
        let before = file.at;
        if !file.next_line().is_some_and(|line| line.to_ascii_uppercase().starts_with("LOOKUP_TABLE")) {
            file.at = before;
        }
    }
    let numbers = file.numbers(tuples.saturating_mul(components), kind)?;
    keep(&decoded(word(words, 1)), numbers, components);
    Ok(())
}

/// Name with decoded escapes such as `%20`.
fn decoded(name: &str) -> String {
    let mut pieces = name.split('%');
    let mut text = pieces.next().unwrap_or_default().to_string();
    for piece in pieces {
        match piece.get(..2).and_then(|code| u8::from_str_radix(code, 16).ok()) {
            Some(code) if code.is_ascii() => {
                text.push(char::from(code));
                text.push_str(&piece[2..]);
            }
            _ => {
                text.push('%');
                text.push_str(piece);
            }
        }
    }
    text
}

/// A file that is being read.
struct File<'a> {
    bytes: &'a [u8],
    at: usize,
    is_binary: bool,
}

impl File<'_> {
    /// Line of a text, or byte of a binary file.
    fn place(&self) -> FilePosition {
        if self.is_binary {
            return FilePosition::Byte(self.at);
        }
        let read = &self.bytes[..self.at];
        let lines = read.iter().filter(|&&byte| byte == b'\n').count();
        FilePosition::Line(lines + usize::from(!read.ends_with(b"\n")))
    }

    /// The next line without surrounding space; `None` at the end.
    fn line(&mut self) -> Option<String> {
        let rest = &self.bytes[self.at..];
        if rest.is_empty() {
            return None;
        }
        let end = rest.iter().position(|&byte| byte == b'\n').unwrap_or(rest.len());
        self.at += (end + 1).min(rest.len());
        Some(String::from_utf8_lossy(rest[..end].trim_ascii()).into_owned())
    }

    /// The next line that is not blank.
    fn next_line(&mut self) -> Option<String> {
        loop {
            let line = self.line()?;
            if !line.is_empty() {
                return Some(line);
            }
        }
    }

    fn whole(&mut self, count: usize, kind: &str) -> Result<Vec<i64>, MeshError> {
        let at = self.place();
        self.numbers(count, kind)?.whole().ok_or_else(|| malformed(at, "whole numbers", "others"))
    }

    /// Numbers of a type.
    fn numbers(&mut self, count: usize, kind: &str) -> Result<Numbers, MeshError> {
        let at = self.place();
        let scalar = match kind.to_ascii_lowercase().as_str() {
            "float" => Scalar::Real(4),
            "double" => Scalar::Real(8),
            "int" | "vtkidtype" => Scalar::Signed(4),
            "unsigned_int" => Scalar::Unsigned(4),
            "long" | "long_long" | "vtktypeint64" => Scalar::Signed(8),
            "unsigned_long" | "vtktypeuint64" => Scalar::Unsigned(8),
            "short" => Scalar::Signed(2),
            "unsigned_short" => Scalar::Unsigned(2),
            "char" | "signed_char" => Scalar::Signed(1),
            "unsigned_char" => Scalar::Unsigned(1),
            _ => {
                let (found, cure) = (format!("an array of the type \"{kind}\""), "write the file without this array, or as `.vtu`");
                return Err(FileError { at, problem: FileProblem::Form { found, cure } }.into());
            }
        };
        let undecodable =
            |reason| FileError { at, problem: FileProblem::Undecodable { what: "the data behind the keyword".into(), reason } };
        let rest = &self.bytes[self.at..];
        let short = |found: usize| undecodable(format!("the file ends after {found} of {count} numbers"));
        if self.is_binary {
            let bytes = count.checked_mul(scalar.bytes()).and_then(|length| rest.get(..length));
            let bytes = bytes.ok_or_else(|| short(rest.len() / scalar.bytes()))?;
            self.at += bytes.len();
            return of_bytes(bytes, scalar, false).map_err(|reason| undecodable(reason).into());
        }
        let (mut end, mut found) = (0, 0);
        while found < count {
            let begin = end + rest[end..].iter().take_while(|byte| byte.is_ascii_whitespace()).count();
            end = begin + rest[begin..].iter().take_while(|byte| !byte.is_ascii_whitespace()).count();
            if begin == end {
                return Err(short(found).into());
            }
            found += 1;
        }
        let text = std::str::from_utf8(&rest[..end]).map_err(|_| FileError { at, problem: FileProblem::NotText })?;
        let numbers = of_text(text, scalar).map_err(undecodable)?;
        self.at += end;
        Ok(numbers)
    }
}
