//! Errors of mesh files with their place: a line of a text file, a byte of a binary one.

use std::path::PathBuf;

use thiserror::Error;

/// A place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilePosition {
    /// Line of a text, counted from 1.
    Line(usize),
    /// Byte of a binary file, counted from 0.
    Byte(usize),
}

impl std::fmt::Display for FilePosition {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            FilePosition::Line(line) => write!(out, "in line {line}"),
            FilePosition::Byte(byte) => write!(out, "at byte {byte}"),
        }
    }
}

/// A mesh file that is refused.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{problem}")]
pub struct FileError {
    /// Place in the file at which the problem was found.
    pub at: FilePosition,
    /// Problem found at the place.
    pub problem: FileProblem,
}

/// Problem of a mesh file.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FileProblem {
    /// A file that cannot be opened or read.
    #[error("the mesh file {} cannot be read: {reason}", path.display())]
    Unreadable {
        /// Path of the file.
        path: PathBuf,
        /// Message of the operating system.
        reason: String,
    },
    /// A line that is not text.
    #[error("the mesh file is not text here: the line holds bytes that are not UTF-8")]
    NotText,
    /// A file of another format.
    #[error("this is not a mesh file that is read here but {found}")]
    OtherFormat {
        /// Description of the probable format of the file.
        found: &'static str,
    },
    /// A binary file whose numbers have an unsupported size.
    #[error("the binary file says that its sizes have {bytes} bytes, but 4 and 8 are read")]
    NumberSize {
        /// The size as written.
        bytes: u64,
    },
    /// A binary file whose byte order cannot be determined, because the number 1 is missing after the version.
    #[error("the binary file has no number 1 behind its version, in neither order of bytes")]
    ByteOrder,
    /// An unsupported Gmsh version.
    #[error("the file has Gmsh format version {version}, but versions 2.2 and 4.1 are read")]
    Version {
        /// The version as written.
        version: String,
    },
    /// A file that ends too early.
    #[error("the file ends inside section {section} that began {begin}: {found} of {announced} entries are there")]
    Truncated {
        /// Name of the section.
        section: String,
        /// Start of the section.
        begin: FilePosition,
        /// Number of entries read.
        found: usize,
        /// Number of entries announced in the file; equal to `found` when only the closing line is missing.
        announced: usize,
    },
    /// A section whose number of entries differs from the announced number.
    #[error("section {section} announces {announced} entries but has {}", more_or(*.found, *.announced))]
    Count {
        /// Name of the section.
        section: &'static str,
        /// Number of entries announced in the file.
        announced: usize,
        /// Number of entries found so far.
        found: usize,
    },
    /// A required section that is missing.
    #[error("the file has no section {section}")]
    MissingSection {
        /// Name of the section.
        section: &'static str,
    },
    /// A section that occurs twice.
    #[error("section {section} occurs a second time")]
    RepeatedSection {
        /// Name of the section.
        section: String,
    },
    /// A place with other content than expected.
    #[error("expected {expected}, found \"{found}\"")]
    Malformed {
        /// Description of the expected content.
        expected: &'static str,
        /// Content found at the place, shortened.
        found: String,
    },
    /// A node with a coordinate that is infinite or not a number.
    #[error("node {node} has the coordinate {value}")]
    Coordinate {
        /// Number of the node in the file.
        node: u64,
        /// Refused coordinate: infinite or not a number.
        value: f64,
    },
    /// Content in an unsupported form.
    #[error("the file has {found}, which is not read here")]
    Form {
        /// Description of the content.
        found: String,
        /// Remedy, one sentence.
        cure: &'static str,
    },
    /// Data that cannot be decoded.
    #[error("{what} cannot be read: {reason}")]
    Undecodable {
        /// Description of the data.
        what: String,
        /// Reason why the data cannot be decoded, in words.
        reason: String,
    },
    /// Two nodes with one number.
    #[error("node {node} occurs twice, first {first}")]
    DuplicateNode {
        /// Number of the node in the file.
        node: u64,
        /// Place of the first occurrence.
        first: FilePosition,
    },
    /// Two elements with one number.
    #[error("element {element} occurs twice, first {first}")]
    DuplicateElement {
        /// Number of the element in the file.
        element: u64,
        /// Place of the first occurrence.
        first: FilePosition,
    },
    /// An element that names a node that is not in the file.
    #[error("element {element} names node {node}, but the file has no such node")]
    MissingNode {
        /// Number of the element in the file.
        element: u64,
        /// Number of the node.
        node: u64,
    },
    /// Two cells with the same nodes in the same group.
    #[error("cells {first} and {cell} have the same nodes")]
    DuplicateCell {
        /// Number of the second cell in the file.
        cell: u64,
        /// Number of the first.
        first: u64,
    },
    /// A cell with fewer nodes than its type has.
    #[error("element {element} has {found} {}, but its type has {nodes}", if *.found == 1 { "node" } else { "nodes" })]
    FewNodes {
        /// Number of the element in the file.
        element: u64,
        /// Number of nodes in the file.
        found: usize,
        /// Number of nodes of its type.
        nodes: usize,
    },
    /// A cell with repeated nodes that does not collapse to a cell of another supported kind.
    #[error("element {element}, a {kind}, names node {node} more than once{}", not_smaller(smaller))]
    Collapsed {
        /// Number of the element in the file.
        element: u64,
        /// Name of the cell kind as which the file declares the cell.
        kind: &'static str,
        /// Number of the first repeated node.
        node: u64,
        /// Names of the kinds that cells of this kind may collapse to.
        smaller: Vec<&'static str>,
    },
    /// An element kind that is not supported as a cell of a body.
    #[error("element {element} is a {kind}, but cells read are {}", readable_cells())]
    UnsupportedCell {
        /// Number of the element in the file.
        element: u64,
        /// Name of the kind.
        kind: String,
    },
    /// An unknown element type.
    #[error("elements of the type {name} are not read here")]
    UnsupportedType {
        /// Name of the type as written.
        name: String,
    },
    /// Cells of first and of second order in one file.
    #[error(
        "the file mixes cells of first and of second order: {count} {kind} and {others} {other}; the first {other} is element {element}"
    )]
    MixedCells {
        /// The kind that most cells are of.
        kind: &'static str,
        /// Number of cells of that kind.
        count: usize,
        /// Name of the other, less frequent cell kind.
        other: &'static str,
        /// Number of cells of the other kind.
        others: usize,
        /// Number of the first element of the other kind in the file.
        element: u64,
    },
    /// Plane cells that are not facets of the solid cells in the same file.
    #[error("the file mixes plane and solid cells: {kind} {element} touches no {solid}")]
    MixedDimensions {
        /// Kind of the plane cell.
        kind: &'static str,
        /// Kind of the solid cells.
        solid: &'static str,
        /// Number of the plane cell in the file.
        element: u64,
    },
    /// A file without cells.
    #[error("the file has no solid or plane cells{}", if *.lines > 0 { format!(", only {lines} line elements") } else { String::new() })]
    NoCells {
        /// Number of line elements in the file.
        lines: usize,
    },
    /// An element of a boundary that is not a facet of any cell.
    #[error("element {element} of boundary \"{boundary}\" is not a facet of any cell")]
    StrayFacet {
        /// Number of the element in the file.
        element: u64,
        /// Name of the group.
        boundary: String,
    },
    /// A node of a plane mesh that is not in the plane.
    #[error("node {node} of the plane mesh has z = {z}, but must have z = 0")]
    NotPlane {
        /// Number of the node in the file.
        node: u64,
        /// Third coordinate of the node.
        z: f64,
    },
    /// An entity that is missing in the table of entities.
    #[error("there is no entity {entity} of dimension {dimension} in section $Entities")]
    UnknownEntity {
        /// Dimension of the entity.
        dimension: usize,
        /// Number of the entity.
        entity: i64,
    },
    /// Two physical groups of one dimension with the same name.
    #[error("two physical groups of dimension {dimension} have the name \"{name}\": {first} and {second}")]
    AmbiguousName {
        /// Dimension of the groups.
        dimension: usize,
        /// Name that several groups have.
        name: String,
        /// Number of the first group.
        first: u64,
        /// Number of the second group.
        second: u64,
    },
    /// A keyword of an Abaqus file that changes the mesh in a way that is not followed here.
    #[error("the keyword *{keyword} is not read here: {reason}")]
    Keyword {
        /// Unsupported keyword of the input file.
        keyword: String,
        /// Reason for which the keyword is refused: its effect.
        reason: &'static str,
    },
    /// A file that is included and cannot be read.
    #[error("the included file \"{name}\" cannot be read: {reason}")]
    Included {
        /// Name of the included file as the deck writes it.
        name: String,
        /// Reason of the system.
        reason: String,
    },
    /// Shells or membranes without solid or plane cells.
    #[error("the file has no solid or plane cells, but {count} shell, membrane or rigid elements ({name})")]
    Shells {
        /// Name of one type of the shells or membranes.
        name: String,
        /// Number of shells and membranes in the file.
        count: usize,
    },
    /// Elements that are no cells, refused because of the option `Structural::Refused`.
    #[error("the file has elements that are no cells of bodies: {count} {name}")]
    Structural {
        /// Name of one type of the elements that are no cells.
        name: String,
        /// Number of elements of this type.
        count: usize,
    },
    /// A keyword without a required parameter.
    #[error("the keyword *{keyword} needs the parameter {parameter}")]
    MissingParameter {
        /// Keyword line that lacks the parameter.
        keyword: String,
        /// Missing parameter of the keyword.
        parameter: &'static str,
    },
    /// A set that the file does not have.
    #[error("there is no {kind} \"{name}\" in the file")]
    UnknownSet {
        /// Kind of the missing name: a set, part or instance.
        kind: &'static str,
        /// Name that the file does not define.
        name: String,
    },
    /// An element or node of a set or surface that the file does not have.
    #[error("{owner} \"{name}\" names the {kind} {number}, but the file has none of that number")]
    UnknownMember {
        /// Set or surface.
        owner: &'static str,
        /// Name of the set or surface.
        name: String,
        /// Node or element.
        kind: &'static str,
        /// Number of the node or element.
        number: u64,
    },
    /// A side that elements do not have.
    #[error("surface \"{name}\" names the side {side}, which {kind} elements do not have")]
    UnknownSide {
        /// Name of the surface.
        name: String,
        /// The side as written.
        side: String,
        /// Kind of the cells.
        kind: &'static str,
    },
}

/// List of the supported cell kinds for messages.
fn readable_cells() -> String {
    listed(&crate::elements::CellKind::ALL.iter().map(|kind| kind.name()).collect::<Vec<_>>(), "and")
}

/// Part of a sentence that names the kinds to which the cell does not collapse; empty if there are none.
fn not_smaller(smaller: &[&str]) -> String {
    if smaller.is_empty() { String::new() } else { format!(", but not so that it would be a {}", listed(smaller, "or")) }
}

/// Names as a list with `word` (`and`, `or`) before the last one.
fn listed(names: &[&str], word: &str) -> String {
    match names.split_last() {
        Some((last, [])) => (*last).into(),
        Some((last, others)) => format!("{} {word} {last}", others.join(", ")),
        None => String::new(),
    }
}

/// Number of entries found, or the word `more` if there are more entries than announced.
fn more_or(found: usize, announced: usize) -> String {
    if found > announced { "more".into() } else { found.to_string() }
}
