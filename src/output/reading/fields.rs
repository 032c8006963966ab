//! A frame (`.vtu`) read back: its arrays, appended as zlib blocks, appended plain, or as text.
//!
//! Reads only files of the form that this program writes: one piece, little-endian bytes with 64-bit headers, numbers of type `Float64`,
//! `Int64`, `UInt8`. Every length in the file is checked against the number of points and cells before it is used.

use std::io::Read as _;
use std::path::Path;

use flate2::read::ZlibDecoder;

use super::error::{ReadError, bytes_of};
use super::tags::{Tag, UNITS_LABEL, tags};

/// Section of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Section {
    /// Coordinates of points.
    Points,
    /// Connectivity, offsets and types.
    Cells,
    /// Values at points.
    PointData,
    /// Values in cells.
    CellData,
}

/// Numbers of an array.
#[derive(Clone, Debug, PartialEq)]
pub enum Numbers {
    /// Values of type `Float64`.
    Reals(Vec<f64>),
    /// Values of type `Int64` or `UInt8`.
    Integers(Vec<i64>),
}

impl Numbers {
    /// Number of values.
    pub fn len(&self) -> usize {
        match self {
            Numbers::Reals(values) => values.len(),
            Numbers::Integers(values) => values.len(),
        }
    }

    /// True if the array has no values.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the value with an index.
    pub fn at(&self, index: usize) -> f64 {
        match self {
            Numbers::Reals(values) => values[index],
            Numbers::Integers(values) => values[index] as f64,
        }
    }
}

/// A named array.
#[derive(Clone, Debug, PartialEq)]
pub struct ArrayRead {
    /// Name of the array.
    pub name: String,
    /// Section of the array.
    pub section: Section,
    /// Number of components per point or cell.
    pub components: usize,
    /// Values point by point or cell by cell.
    pub numbers: Numbers,
    /// Unit of the values; empty where the file has none.
    pub unit: String,
}

/// Content of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldsRead {
    /// Time of the frame, if the file has one.
    pub time: Option<f64>,
    /// Kind of the frame's parts: `body`, `obstacle` or `contact`.
    pub kind: String,
    /// Names of the parts.
    pub parts: Vec<String>,
    /// Number of points.
    pub points: usize,
    /// Number of cells.
    pub cells: usize,
    /// All arrays, in the order of the file.
    pub arrays: Vec<ArrayRead>,
}

impl FieldsRead {
    /// Returns the array with a name in a section.
    pub fn array(&self, section: Section, name: &str) -> Option<&ArrayRead> {
        self.arrays.iter().find(|array| array.section == section && array.name == name)
    }

    /// Nodes of every cell, with VTK's number of the cell type.
    pub fn cells(&self) -> impl Iterator<Item = (u8, &[i64])> {
        let integers = |name| match self.array(Section::Cells, name).map(|array| &array.numbers) {
            Some(Numbers::Integers(values)) => values.as_slice(),
            _ => &[],
        };
        let (nodes, ends, kinds) = (integers("connectivity"), integers("offsets"), integers("types"));
        // The reader has checked that ends ascend within the connectivity.
        ends.iter().zip(kinds).enumerate().map(move |(cell, (&end, &kind))| {
            let start = if cell == 0 { 0 } else { ends[cell - 1] };
            (kind as u8, &nodes[start as usize..end as usize])
        })
    }
}

/// Reads a frame.
///
/// # Errors
/// A file that cannot be read, is cut or damaged, or is a VTK file of another form.
pub fn read_fields(path: &Path) -> Result<FieldsRead, ReadError> {
    let bytes = bytes_of(path)?;
    fields_of(path, &bytes)
}

/// Reads a frame from the bytes of a file; `path` is for messages.
///
/// # Errors
/// As [`read_fields`].
pub fn fields_of(path: &Path, bytes: &[u8]) -> Result<FieldsRead, ReadError> {
    let damaged = |what: &str| ReadError::damaged(path, what);
    let mark = b"<AppendedData";
    let head = bytes.windows(mark.len()).position(|window| window == mark).unwrap_or(bytes.len());
    let text = std::str::from_utf8(&bytes[..head]).map_err(|_| damaged("its head is not text"))?;
    let appended = &bytes[head..];
    let data = appended.iter().position(|&byte| byte == b'_').map_or(&[][..], |start| &appended[start + 1..]);
    let tags = tags(text);
    let file = tags.iter().find(|tag| tag.name == "VTKFile").ok_or_else(|| damaged("it is no VTK file in XML"))?;
    let other = |what: String| ReadError::new(path, what, "name a frame that a run has written; other files open in ParaView");
    let is = |key: &str, value: &str| file.attribute(key).as_deref() == Some(value);
    if !is("type", "UnstructuredGrid") || !is("byte_order", "LittleEndian") || !is("header_type", "UInt64") {
        return Err(other("is a VTK file of a form that this program does not write".into()));
    }
    let compressed = match file.attribute("compressor").as_deref() {
        None => false,
        Some("vtkZLibDataCompressor") => true,
        Some(compressor) => return Err(other(format!("is compressed with {compressor}, which this program does not read"))),
    };
    let mut pieces = tags.iter().filter(|tag| tag.name == "Piece");
    let piece = pieces.next().ok_or_else(|| damaged("it has no piece"))?;
    if pieces.next().is_some() {
        return Err(other("has several pieces, which this program does not read".into()));
    }
    let count = |key: &str| piece.count(key).ok_or_else(|| damaged("its piece does not tell the numbers of points and cells"));
    let (points, cells) = (count("NumberOfPoints")?, count("NumberOfCells")?);
    let mut read = FieldsRead { time: None, kind: String::new(), parts: Vec::new(), points, cells, arrays: Vec::new() };
    let mut section = None;
    for tag in &tags {
        match tag.name {
            "!--" => note_part(&mut read, tag.text),
            "Points" => section = Some(Section::Points),
            "Cells" => section = Some(Section::Cells),
            "PointData" => section = Some(Section::PointData),
            "CellData" => section = Some(Section::CellData),
            "DataArray" => match section {
                Some(section) => {
                    let array = array_of(tag, section, data, compressed, &read).map_err(|what| damaged(&what))?;
                    read.arrays.push(array);
                }
                None if tag.attribute("Name").as_deref() == Some("TimeValue") => read.time = tag.text.trim().parse().ok(),
                None => {}
            },
            "InformationKey" if tag.attribute("name").as_deref() == Some(UNITS_LABEL) => {
                read.arrays.iter_mut().last().into_iter().for_each(|array| array.unit = tag.text.trim().into());
            }
            _ => {}
        }
    }
    check(&read).map_err(|what| damaged(&what))?;
    Ok(read)
}

/// Reads the name of a part from a comment `body 0: ring`.
fn note_part(read: &mut FieldsRead, comment: &str) {
    if let Some((kind, name)) = comment.split_once(": ")
        && let Some((kind, number)) = kind.split_once(' ')
        && number.parse() == Ok(read.parts.len())
    {
        read.kind = kind.into();
        read.parts.push(name.into());
    }
}

/// Reads an array from its tag.
fn array_of(tag: &Tag, section: Section, data: &[u8], compressed: bool, read: &FieldsRead) -> Result<ArrayRead, String> {
    let name = tag.attribute("Name").unwrap_or_else(|| "Points".into());
    let components = tag.count("NumberOfComponents").unwrap_or(1).max(1);
    let scalar = tag.attribute("type").unwrap_or_default();
    let size = match scalar.as_str() {
        "Float64" | "Int64" => 8,
        "UInt8" => 1,
        other => return Err(format!("array `{name}` has the type `{other}`, which this program does not write")),
    };
    let tuples = match section {
        Section::Points | Section::PointData => Some(read.points),
        Section::CellData => Some(read.cells),
        Section::Cells if name == "connectivity" => None,
        Section::Cells => Some(read.cells),
    };
    let expected = tuples.map(|tuples| tuples.saturating_mul(components));
    let numbers = match tag.attribute("format").as_deref() {
        Some("ascii") => numbers_of_text(tag.text, scalar == "Float64").ok_or_else(|| format!("array `{name}` has what is no number"))?,
        Some("appended") => {
            let offset = tag.count("offset").ok_or_else(|| format!("array `{name}` has no offset"))?;
            let data = data.get(offset..).ok_or_else(|| format!("the data of array `{name}` are missing"))?;
            let most = expected.map(|expected| expected.saturating_mul(size));
            let bytes = if compressed { inflated(data, most) } else { plain(data) };
            let bytes = bytes.ok_or_else(|| format!("the data of array `{name}` are cut or not what they were"))?;
            numbers_of_bytes(&bytes, &scalar)
        }
        _ => return Err(format!("array `{name}` is neither text nor appended")),
    };
    match expected {
        Some(expected) if numbers.len() != expected => Err(format!("array `{name}` has {} numbers, not {expected}", numbers.len())),
        _ => Ok(ArrayRead { name, section, components, numbers, unit: String::new() }),
    }
}

fn numbers_of_text(text: &str, real: bool) -> Option<Numbers> {
    let words = text.split_whitespace();
    if real {
        words.map(|word| word.parse().ok()).collect::<Option<_>>().map(Numbers::Reals)
    } else {
        words.map(|word| word.parse().ok()).collect::<Option<_>>().map(Numbers::Integers)
    }
}

fn numbers_of_bytes(bytes: &[u8], scalar: &str) -> Numbers {
    let words = || bytes.chunks_exact(8).map(|word| word.try_into().unwrap_or_default());
    match scalar {
        "Float64" => Numbers::Reals(words().map(f64::from_le_bytes).collect()),
        "Int64" => Numbers::Integers(words().map(i64::from_le_bytes).collect()),
        _ => Numbers::Integers(bytes.iter().map(|&byte| byte.into()).collect()),
    }
}

/// Reads a word of the header.
fn word(data: &[u8], index: usize) -> Option<usize> {
    let bytes = data.get(index.checked_mul(8)?..index.checked_add(1)?.checked_mul(8)?)?;
    usize::try_from(u64::from_le_bytes(bytes.try_into().ok()?)).ok()
}

/// Reads appended bytes, which follow their length.
fn plain(data: &[u8]) -> Option<Vec<u8>> {
    let length = word(data, 0)?;
    data.get(8..8usize.checked_add(length)?).map(<[u8]>::to_vec)
}

/// Inflates appended zlib blocks, which follow their sizes; `most` is the expected number of bytes, if known.
fn inflated(data: &[u8], most: Option<usize>) -> Option<Vec<u8>> {
    let (count, size, last) = (word(data, 0)?, word(data, 1)?, word(data, 2)?);
    let whole = if last > 0 { count.checked_sub(1)? } else { count };
    let total = whole.checked_mul(size)?.checked_add(last)?;
    if most.is_some_and(|most| total != most) {
        return None;
    }
    let mut at = count.checked_add(3)?.checked_mul(8)?;
    let mut bytes = Vec::new();
    for index in 0..count {
        let packed = data.get(at..at.checked_add(word(data, 3 + index)?)?)?;
        let length = if index + 1 == count && last > 0 { last } else { size };
        let before = bytes.len();
        // One byte beyond the expected length reveals a block that is too long.
        ZlibDecoder::new(packed).take(length as u64 + 1).read_to_end(&mut bytes).ok()?;
        if bytes.len() - before != length {
            return None;
        }
        at += packed.len();
    }
    Some(bytes)
}

/// Checks that connectivity, offsets and points of the cells are consistent.
fn check(read: &FieldsRead) -> Result<(), String> {
    let integers = |name: &str| match read.array(Section::Cells, name).map(|array| &array.numbers) {
        Some(Numbers::Integers(values)) => Ok(values),
        _ => Err(format!("its cells have no `{name}`")),
    };
    let (nodes, ends) = (integers("connectivity")?, integers("offsets")?);
    integers("types")?;
    if read.array(Section::Points, "Points").is_none_or(|array| array.components != 3) {
        return Err("it has no points with three coordinates".into());
    }
    let ascend = ends.windows(2).all(|ends| ends[0] <= ends[1]) && ends.first().is_none_or(|&first| first >= 0);
    if !ascend || ends.last().copied().unwrap_or(0) != nodes.len() as i64 {
        return Err("the offsets of its cells do not fit their nodes".into());
    }
    match nodes.iter().find(|&&node| node < 0 || node as usize >= read.points) {
        Some(node) => Err(format!("a cell has the node {node}, but there are {} points", read.points)),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::samples::{block, ring};
    use super::super::super::vtu::Frame;
    use super::*;

    fn frame() -> Vec<u8> {
        Frame::new(0.25, &[ring("outer ring", [1.0, 1.5], [40, 80]), ring("inner", [0.5, 1.0], [2, 9])]).encode()
    }

    #[test]
    fn a_frame_reads_back() {
        let bodies = [ring("outer ring", [1.0, 1.5], [4, 8]), block([2, 1, 1], [1.0; 3])];
        let read = fields_of(Path::new("x"), &Frame::new(0.1 + 0.2, &bodies).encode()).unwrap();
        assert_eq!((read.time, read.kind.as_str(), read.parts.join("|").as_str()), (Some(0.1 + 0.2), "body", "outer ring|block"));
        assert_eq!((read.points, read.cells), (40 + 12, 34));
        let stress = read.array(Section::PointData, "stress").unwrap();
        let expected: Vec<f64> = bodies.iter().flat_map(|body| body.stress.concat()).collect();
        assert_eq!((stress.components, &stress.numbers), (6, &Numbers::Reals(expected)));
        let cells: Vec<(u8, usize)> = read.cells().map(|(kind, nodes)| (kind, nodes.len())).collect();
        assert_eq!((cells[0], cells[33]), ((9, 4), (12, 8)));
        let gap = read.array(Section::PointData, "contact_gap").unwrap();
        assert!((0..read.points).any(|node| gap.numbers.at(node).is_nan()));
    }

    #[test]
    fn damage_is_told_and_never_a_panic() {
        let whole = frame();
        for part in 0..40 {
            let end = whole.len() * part / 40;
            let error = fields_of(Path::new("x.vtu"), &whole[..end]).unwrap_err().to_string();
            assert!(error.contains("x.vtu"), "{error}");
        }
        // Any byte may be changed: the reader reports an error or reads other numbers.
        for place in (0..whole.len()).step_by(97) {
            let mut other = whole.clone();
            other[place] ^= 0x5a;
            let _ = fields_of(Path::new("x.vtu"), &other);
        }
        let claims = String::from_utf8_lossy(&whole[..400]).replace("NumberOfPoints=\"", "NumberOfPoints=\"99999999999");
        assert!(fields_of(Path::new("x"), claims.as_bytes()).is_err());
    }
}
