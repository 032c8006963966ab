//! Grids as XML (VTK file formats, "XML file formats"): arrays of text, base64 or appended bytes, in zlib blocks or plain.
//!
//! Names of groups come from comments such as `body 0: ring`, which this program writes for its bodies.

use std::collections::{BTreeMap, BTreeSet};

use roxmltree::{Document, Node};

use super::super::text::utf8;
use super::data::{Layout, Numbers, Scalar, of_base64, of_bytes, of_text, unpacked};
use super::grid::{Content, GridPiece};
use crate::mesh::MeshError;
use crate::mesh::file_error::{FileError, FilePosition, FileProblem};

/// Tag after which bytes follow that are not XML.
const APPENDED: &[u8] = b"<AppendedData";

/// Reads the content of a VTK file in the XML format.
pub(in crate::mesh::files) fn read(bytes: &[u8]) -> Result<Content, MeshError> {
    let head_end = bytes.windows(APPENDED.len()).position(|window| window == APPENDED).unwrap_or(bytes.len());
    let mut head = utf8(&bytes[..head_end])?.to_string();
    if head_end < bytes.len() {
        head.push_str("</VTKFile>");
    }
    let document = Document::parse(&head).map_err(|error| {
        let problem = FileProblem::Undecodable { what: "the XML".into(), reason: error.to_string() };
        FileError { at: FilePosition::Line(error.pos().row as usize), problem }
    })?;
    let file = File::new(&document, &bytes[head_end..])?;
    let mut content = Content::new();
    let names = names_of(&document);
    for piece in document.descendants().filter(|node| node.has_tag_name("Piece")) {
        let piece = file.piece(piece, &mut content)?;
        content.add(piece, &names)?;
    }
    Ok(content)
}

/// Names of bodies in comments, by the array and the value.
fn names_of(document: &Document) -> BTreeMap<(String, i64), String> {
    let comments = document.descendants().filter(Node::is_comment).filter_map(|node| node.text());
    let named = comments.filter_map(|text| {
        let (group, name) = text.trim().split_once(": ")?;
        let (array, value) = group.split_once(' ')?;
        Some(((array.into(), value.parse().ok()?), name.into()))
    });
    named.collect()
}

/// File with the data that its arrays need.
struct File<'a> {
    layout: Layout,
    /// Appended data.
    appended: &'a [u8],
    /// True if the appended data are base64 text.
    is_text: bool,
    /// Starts of the arrays in the appended data, ascending.
    offsets: BTreeSet<usize>,
}

impl<'a> File<'a> {
    fn new(document: &Document, tail: &'a [u8]) -> Result<File<'a>, MeshError> {
        let root = document.root_element();
        let refused = |found: String, cure| Err(FileError { at: line_of(root), problem: FileProblem::Form { found, cure } }.into());
        if !root.has_tag_name("VTKFile") {
            return Err(FileError { at: line_of(root), problem: FileProblem::OtherFormat { found: "an XML file without VTKFile" } }.into());
        }
        let kind = root.attribute("type").unwrap_or_default();
        if kind != "UnstructuredGrid" {
            let cure = match kind {
                "PUnstructuredGrid" | "vtkMultiBlockDataSet" | "Collection" => "read the `.vtu` files that it lists",
                _ => "save it as an unstructured grid (`.vtu`), in ParaView by the filter \"Append Datasets\"",
            };
            return refused(format!("VTK data of the type {kind}"), cure);
        }
        let is_compressed = match root.attribute("compressor") {
            None | Some("") => false,
            Some("vtkZLibDataCompressor") => true,
            Some(other) => return refused(format!("data compressed by {other}"), "write it with zlib or without compression"),
        };
        let header = if root.attribute("header_type") == Some("UInt64") { 8 } else { 4 };
        let tag_end = tail.iter().position(|&byte| byte == b'>').unwrap_or(tail.len());
        let is_text = tail[..tag_end].windows(6).any(|window| window == b"base64");
        let start = tail.iter().position(|&byte| byte == b'_').map_or(tail.len(), |start| start + 1);
        let offsets = document.descendants().filter_map(|node| node.attribute("offset")?.parse().ok()).collect();
        let layout = Layout { is_little: root.attribute("byte_order") != Some("BigEndian"), header, is_compressed };
        Ok(File { layout, appended: &tail[start..], is_text, offsets })
    }

    fn piece(&self, piece: Node, content: &mut Content) -> Result<GridPiece, MeshError> {
        let count = |key: &'static str| {
            let value = piece.attribute(key).unwrap_or("nothing");
            value.trim().parse::<usize>().map_err(|_| {
                let problem = FileProblem::Malformed { expected: "NumberOfPoints and NumberOfCells of a piece", found: value.into() };
                MeshError::from(FileError { at: line_of(piece), problem })
            })
        };
        let (points, cells) = (count("NumberOfPoints")?, count("NumberOfCells")?);
        let section = |name: &str| piece.children().find(|node| node.has_tag_name(name));
        let missing = |section| FileError { at: line_of(piece), problem: FileProblem::MissingSection { section } };
        let place = section("Points").and_then(|node| arrays_of(node).next()).ok_or_else(|| missing("Points"))?;
        let topology = section("Cells").ok_or_else(|| missing("Cells"))?;
        let of_cells = |name: &'static str| {
            let array = arrays_of(topology).find(|node| node.attribute("Name") == Some(name)).ok_or_else(|| missing(name))?;
            self.whole(array, (name != "connectivity").then_some(cells))
        };
        let mut groups = Vec::new();
        for array in section("CellData").into_iter().flat_map(arrays_of) {
            let name = array.attribute("Name").unwrap_or("unnamed").to_string();
            let is_single = array.attribute("NumberOfComponents").is_none_or(|count| count.trim() == "1");
            let is_whole = array.attribute("type").and_then(Scalar::of_name).is_some_and(Scalar::is_whole);
            if is_single && is_whole {
                groups.push((name, self.whole(array, Some(cells))?));
            } else {
                content.leave_out(&name);
            }
        }
        section("PointData")
            .into_iter()
            .flat_map(arrays_of)
            .filter_map(|node| node.attribute("Name"))
            .for_each(|name| content.leave_out(name));
        Ok(GridPiece {
            points: self.numbers(place, Some(points.saturating_mul(3)))?.reals(),
            connectivity: of_cells("connectivity")?,
            ends: of_cells("offsets")?,
            types: of_cells("types")?,
            groups,
            at: [line_of(place), line_of(topology)],
        })
    }

    fn whole(&self, array: Node, count: Option<usize>) -> Result<Vec<i64>, MeshError> {
        self.numbers(array, count)?.whole().ok_or_else(|| undecodable(array, "it has numbers that are not whole".into()))
    }

    /// Numbers of an array, with the required count.
    fn numbers(&self, array: Node, count: Option<usize>) -> Result<Numbers, MeshError> {
        let numbers = self.decoded(array).map_err(|reason| undecodable(array, reason))?;
        match count {
            Some(count) if numbers.len() != count => Err(undecodable(array, format!("it has {} numbers, not {count}", numbers.len()))),
            _ => Ok(numbers),
        }
    }

    fn decoded(&self, array: Node) -> Result<Numbers, String> {
        let name = array.attribute("type").unwrap_or_default();
        let scalar = Scalar::of_name(name).ok_or_else(|| format!("its type \"{name}\" is none of Int8 to UInt64, Float32 and Float64"))?;
        let data = match array.attribute("format").unwrap_or("ascii") {
            "ascii" => return of_text(array.text().unwrap_or(""), scalar),
            "binary" => of_base64(array.text().unwrap_or("").as_bytes())?,
            "appended" => {
                let offset = array.attribute("offset").and_then(|offset| offset.trim().parse::<usize>().ok()).ok_or("it has no offset")?;
                let end = self.offsets.range(offset + 1..).next().copied().unwrap_or(self.appended.len()).min(self.appended.len());
                let data = self.appended.get(offset..end).ok_or("the data end too early")?;
                if self.is_text { of_base64(data.split(|&byte| byte == b'<').next().unwrap_or(data))? } else { data.to_vec() }
            }
            other => return Err(format!("its format \"{other}\" is none of ascii, binary and appended")),
        };
        of_bytes(&unpacked(&data, self.layout)?, scalar, self.layout.is_little)
    }
}

fn arrays_of<'a, 'input>(node: Node<'a, 'input>) -> impl Iterator<Item = Node<'a, 'input>> {
    node.children().filter(|node| node.has_tag_name("DataArray"))
}

fn line_of(node: Node) -> FilePosition {
    FilePosition::Line(node.document().text_pos_at(node.range().start).row as usize)
}

fn undecodable(array: Node, reason: String) -> MeshError {
    let what = format!("the array \"{}\"", array.attribute("Name").unwrap_or("without name"));
    FileError { at: line_of(array), problem: FileProblem::Undecodable { what, reason } }.into()
}
