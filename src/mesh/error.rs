//! What can go wrong with a mesh: one sentence with the numbers that show it, the line of the file where there is one, and a cure.
//!
//! One type for generators, transforms, selections, checks and readers, since they hand the same meshes to each other.

use std::path::PathBuf;

use thiserror::Error;

/// A mesh that cannot be made, changed, found or read.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MeshError {
    /// A size, radius or factor that must be greater than zero.
    #[error("{what} must be a finite number greater than 0, but is {value}")]
    NotPositive {
        /// What the number is.
        what: &'static str,
        /// The number.
        value: f64,
    },
    /// A number that must be finite.
    #[error("{what} must be finite, but is {value}")]
    NotFinite {
        /// What the number is.
        what: &'static str,
        /// The number.
        value: f64,
    },
    /// A polygon of fewer than three corners.
    #[error("a polygon needs at least 3 corners, but has {count}")]
    FewCorners {
        /// How many it has.
        count: usize,
    },
    /// A hole that is not wholly inside its polygon, or meets another hole.
    #[error("hole {hole} is not inside the polygon and apart from the other holes")]
    HoleOutside {
        /// Its number, from 1.
        hole: usize,
    },
    /// Meshes of different cells cannot be one.
    #[error("a mesh of {first} and one of {second} cannot be joined")]
    JoinedKinds {
        /// Cells of one mesh.
        first: &'static str,
        /// Cells of the other mesh.
        second: &'static str,
    },
    /// Meshes to be joined have no node in common.
    #[error("the two meshes have no node at the same place")]
    NothingShared,
    /// Two corners of a polygon that follow each other coincide.
    #[error("side {side} of the polygon has no length")]
    EmptySide {
        /// Number of the side between them, from 1.
        side: usize,
    },
    /// Two sides of a polygon have a point in common that is no corner of both.
    #[error("the sides {first} and {second} of the polygon touch or cross")]
    CrossingSides {
        /// Number of the first side, from 1.
        first: usize,
        /// Number of the second side, from 1.
        second: usize,
    },
    /// A polygon that could not be divided into triangles.
    #[error("the polygon cannot be divided into triangles")]
    NoTriangulation,
    /// A cell count that does not divide as the shape asks.
    #[error("the number of cells {direction} must be a multiple of {of}, but is {count}")]
    NotMultiple {
        /// Direction that is divided.
        direction: &'static str,
        /// The count.
        count: usize,
        /// What it must be a multiple of.
        of: usize,
    },
    /// A cell count below its minimum.
    #[error("the number of cells {direction} must be at least {least}, but is {count}")]
    TooFewCells {
        /// Direction that is divided.
        direction: &'static str,
        /// The count.
        count: usize,
        /// The least admissible count.
        least: usize,
    },
    /// More cells than a mesh may have.
    #[error("the mesh would have {cells} cells, but {limit} is the limit")]
    TooManyCells {
        /// Number of cells asked for, saturated.
        cells: usize,
        /// The limit.
        limit: usize,
    },
    /// Cells that cannot be made of a mesh's cells.
    #[error("cells of the kind {to} cannot be made of cells of the kind {from}")]
    NoConversion {
        /// Kind of the mesh.
        from: &'static str,
        /// Kind asked for.
        to: &'static str,
    },
    /// A ring whose inner radius is not below the outer one.
    #[error("the inner radius {inner} of a ring must be smaller than its outer radius {outer}")]
    Radii {
        /// Inner radius.
        inner: f64,
        /// Outer radius.
        outer: f64,
    },
    /// A transform that takes a plane mesh out of its plane.
    #[error("{what} takes the plane mesh out of its plane z = 0")]
    LeavesPlane {
        /// The transform.
        what: &'static str,
    },
    /// A rotation axis without direction.
    #[error("the rotation axis ({}, {}, {}) has no direction", axis[0], axis[1], axis[2])]
    NoAxis {
        /// The axis.
        axis: [f64; 3],
    },
    /// A part that the mesh does not have.
    #[error("the mesh has no part \"{name}\"; its parts are {}", listed(.available))]
    UnknownPart {
        /// The name asked for.
        name: String,
        /// The names that there are.
        available: Vec<String>,
    },
    /// A boundary that is to be named like one that there is.
    #[error("the mesh already has a boundary \"{name}\"; its boundaries are {}", listed(.available))]
    BoundaryExists {
        /// The name.
        name: String,
        /// The names that there are.
        available: Vec<String>,
    },

    /// A cell whose nodes run the wrong way round or whose facets cross.
    #[error(
        "cell {cell} at {} is inside out: its Jacobian determinant is {} ({inverted} of {cells} cells are)",
        place(.center), rounded(*.determinant)
    )]
    InvertedCell {
        /// Line of the file.
        line: Option<usize>,
        /// Number in the file; index in the mesh when no file was read.
        cell: u64,
        /// Mean of its nodes, one coordinate per dimension `[length]`.
        center: Vec<f64>,
        /// Smallest Jacobian determinant at its quadrature points.
        determinant: f64,
        /// How many cells are inside out.
        inverted: usize,
        /// How many cells there are.
        cells: usize,
    },
    /// A cell without area or volume.
    #[error("cell {cell} at {} has no {}: its Jacobian determinant is {}", place(.center), extent(.center), rounded(*.determinant))]
    DegenerateCell {
        /// Line of the file.
        line: Option<usize>,
        /// Number in the file; index in the mesh when no file was read.
        cell: u64,
        /// Mean of its nodes, one coordinate per dimension `[length]`.
        center: Vec<f64>,
        /// Smallest Jacobian determinant at its quadrature points.
        determinant: f64,
    },
    /// A cell that names a node twice.
    #[error("cell {cell} names node {node} twice")]
    RepeatedNode {
        /// Line of the file.
        line: Option<usize>,
        /// Number in the file; index in the mesh when no file was read.
        cell: u64,
        /// The node.
        node: u64,
    },
    /// A facet that more than two cells share.
    #[error("{sharing} cells share one facet of cell {cell}, but a facet has at most two sides")]
    CrowdedFacet {
        /// Line of the file.
        line: Option<usize>,
        /// Number of the first of the cells in the file; its index in the mesh when no file was read.
        cell: u64,
        /// How many cells share the facet.
        sharing: usize,
    },
    /// Nodes that no cell uses.
    #[error("{count} nodes belong to no cell, the first is node {node}")]
    UnusedNodes {
        /// How many.
        count: usize,
        /// The first, as index in the mesh.
        node: u64,
    },
    /// A cell, facet or part that refers to something that the mesh does not have (a mesh put together by hand).
    #[error("{what} {index} refers to {target}, but there are only {count}")]
    BrokenReference {
        /// What refers.
        what: &'static str,
        /// Its index.
        index: usize,
        /// The index that it refers to.
        target: usize,
        /// How many there are.
        count: usize,
    },

    /// A file that cannot be opened or read.
    #[error("the mesh file {} cannot be read: {reason}", path.display())]
    Unreadable {
        /// Path of the file.
        path: PathBuf,
        /// What the system says.
        reason: String,
    },
    /// A file that is not text.
    #[error("the mesh file is not text: line {line} holds bytes that are not UTF-8")]
    NotText {
        /// Line of the file.
        line: usize,
    },
    /// A file of another format.
    #[error("this is not a Gmsh mesh file but {found}")]
    OtherFormat {
        /// Line of the file.
        line: usize,
        /// What it looks like.
        found: &'static str,
    },
    /// A binary Gmsh file.
    #[error("this Gmsh mesh file is binary")]
    Binary {
        /// Line of the file.
        line: usize,
    },
    /// A Gmsh version that is not read.
    #[error("the file has Gmsh format version {version}, but versions 2.2 and 4.1 are read")]
    Version {
        /// Line of the file.
        line: usize,
        /// The version as written.
        version: String,
    },
    /// A file that ends too early.
    #[error("the file ends inside section ${section} that began in line {begin}: {found} of {announced} entries are there")]
    Truncated {
        /// Last line of the file.
        line: usize,
        /// Name of the section.
        section: String,
        /// Line of its first line.
        begin: usize,
        /// Entries read.
        found: usize,
        /// Entries announced; equal to `found` when only the closing line is missing.
        announced: usize,
    },
    /// A section whose number of entries is not the one that it announces.
    #[error("section ${section} announces {announced} entries but has {}", more_or(*.found, *.announced))]
    Count {
        /// Line where this shows.
        line: usize,
        /// Name of the section.
        section: &'static str,
        /// Entries announced.
        announced: usize,
        /// Entries found so far.
        found: usize,
    },
    /// A section that must be there is not.
    #[error("the file has no section ${section}")]
    MissingSection {
        /// Last line of the file.
        line: usize,
        /// Name of the section.
        section: &'static str,
    },
    /// A section that is there twice.
    #[error("section ${section} is there a second time")]
    RepeatedSection {
        /// Line of the file.
        line: usize,
        /// Name of the section.
        section: String,
    },
    /// A section of a partitioned mesh.
    #[error("the mesh is partitioned (section ${section})")]
    Partitioned {
        /// Line of the file.
        line: usize,
        /// Name of the section.
        section: String,
    },
    /// A line that does not hold what belongs there.
    #[error("expected {expected}, found \"{found}\"")]
    Malformed {
        /// Line of the file.
        line: usize,
        /// What belongs there.
        expected: &'static str,
        /// What is there, shortened.
        found: String,
    },
    /// A node with a coordinate that is infinite or not a number.
    #[error("node {node} has the coordinate {value}")]
    Coordinate {
        /// Line of the file.
        line: usize,
        /// Number of the node in the file.
        node: u64,
        /// The coordinate.
        value: f64,
    },
    /// Two nodes with one number.
    #[error("node {node} is there twice, first in line {first}")]
    DuplicateNode {
        /// Line of the second.
        line: usize,
        /// Number of the node in the file.
        node: u64,
        /// Line of the first.
        first: usize,
    },
    /// An element that names a node that is not in the file.
    #[error("element {element} names node {node}, but the file has no such node")]
    MissingNode {
        /// Line of the file.
        line: usize,
        /// Number of the element in the file.
        element: u64,
        /// Number of the node.
        node: u64,
    },
    /// Two cells with the same nodes in the same physical group.
    #[error("cells {first} and {cell} have the same nodes")]
    DuplicateCell {
        /// Line of the second.
        line: usize,
        /// Number of the second cell in the file.
        cell: u64,
        /// Number of the first.
        first: u64,
    },
    /// A kind of element that bodies are not made of here.
    #[error("element {element} is a {kind}, but quad4 and hex8 cells are read")]
    UnsupportedCell {
        /// Line of the file.
        line: usize,
        /// Number of the element in the file.
        element: u64,
        /// Gmsh's type number.
        gmsh_type: u64,
        /// Name of the kind.
        kind: String,
    },
    /// Quadrilaterals that are not facets of the hexahedra in the same file.
    #[error("the file mixes quad4 and hex8 cells: quad4 {element} touches no hex8")]
    MixedKinds {
        /// Line of the file.
        line: usize,
        /// Number of the quadrilateral in the file.
        element: u64,
    },
    /// A file without quad4 or hex8 cells.
    #[error("the file has no quad4 or hex8 cells, only {lines} line elements")]
    NoCells {
        /// Line of the section of elements.
        line: usize,
        /// How many line elements it has.
        lines: usize,
    },
    /// An element of a boundary that is not a facet of any cell.
    #[error("element {element} of boundary \"{boundary}\" is not a facet of any cell")]
    StrayFacet {
        /// Line of the file.
        line: usize,
        /// Number of the element in the file.
        element: u64,
        /// Name of the physical group.
        boundary: String,
    },
    /// A node of a plane mesh that is not in the plane.
    #[error("node {node} of the plane mesh has z = {z}, but must have z = 0")]
    NotPlane {
        /// Line of the file.
        line: usize,
        /// Number of the node in the file.
        node: u64,
        /// Its third coordinate.
        z: f64,
    },
    /// A physical group that the entity table does not know.
    #[error("there is no entity {entity} of dimension {dimension} in section $Entities")]
    UnknownEntity {
        /// Line of the file.
        line: usize,
        /// Dimension of the entity.
        dimension: usize,
        /// Its number.
        entity: i64,
    },
    /// Two physical groups of one dimension with the same name.
    #[error("two physical groups of dimension {dimension} have the name \"{name}\": {first} and {second}")]
    AmbiguousName {
        /// Line of the name of the second group.
        line: usize,
        /// Dimension of the groups.
        dimension: usize,
        /// The name.
        name: String,
        /// Number of the first group.
        first: u64,
        /// Number of the second group.
        second: u64,
    },
}

impl MeshError {
    /// Line of the mesh file, counted from 1, where the error has one.
    pub fn line(&self) -> Option<usize> {
        use MeshError::*;
        match self {
            InvertedCell { line, .. } | DegenerateCell { line, .. } | RepeatedNode { line, .. } | CrowdedFacet { line, .. } => *line,
            NotText { line }
            | OtherFormat { line, .. }
            | Binary { line }
            | Version { line, .. }
            | Truncated { line, .. }
            | Count { line, .. }
            | MissingSection { line, .. }
            | RepeatedSection { line, .. }
            | Partitioned { line, .. }
            | Malformed { line, .. }
            | Coordinate { line, .. }
            | DuplicateNode { line, .. }
            | MissingNode { line, .. }
            | DuplicateCell { line, .. }
            | UnsupportedCell { line, .. }
            | MixedKinds { line, .. }
            | NoCells { line, .. }
            | StrayFacet { line, .. }
            | NotPlane { line, .. }
            | UnknownEntity { line, .. }
            | AmbiguousName { line, .. } => Some(*line),
            // Nothing of a file.
            _ => None,
        }
    }
}

/// Names in quotation marks, or `none`.
fn listed(names: &[String]) -> String {
    if names.is_empty() {
        return "none (it has no physical groups of cells)".into();
    }
    names.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
}

/// A count that falls short, or that there is more than announced.
fn more_or(found: usize, announced: usize) -> String {
    if found > announced { "more".into() } else { found.to_string() }
}

/// A point with six digits.
fn place(point: &[f64]) -> String {
    format!("({})", point.iter().map(|&x| rounded(x)).collect::<Vec<_>>().join(", "))
}

fn extent(point: &[f64]) -> &'static str {
    if point.len() == 2 { "area" } else { "volume" }
}

/// Six significant digits, without trailing zeros.
pub(super) fn rounded(value: f64) -> String {
    match format!("{value:.5e}").parse::<f64>() {
        Ok(short) if (1e-4..1e7).contains(&short.abs()) || short == 0.0 => format!("{short}"),
        Ok(short) => format!("{short:e}"),
        Err(_) => format!("{value}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        assert_eq!(rounded(1.0 / 3.0), "0.333333");
        assert_eq!(rounded(0.0), "0");
        assert_eq!(rounded(-2.5e-9), "-2.5e-9");
        assert_eq!(rounded(f64::NAN), "NaN");
        assert_eq!(place(&[0.1 + 0.2, -4.0]), "(0.3, -4)");
    }
}
