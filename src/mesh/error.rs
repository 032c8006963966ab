//! Errors of meshes: one sentence with the numbers that show the error, the place in the file (if a file was read), and a hint.
//!
//! One type for generators, transforms, selections, checks and readers, since they hand the same meshes to each other.

use std::path::PathBuf;

use thiserror::Error;

use super::file_error::{FileError, FilePosition};
use crate::machine::memory::Shortage;

/// A mesh that cannot be made, changed, found or read.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MeshError {
    /// A size, radius or factor that must be greater than zero.
    #[error("{what} must be a finite number greater than 0, but is {value}")]
    NotPositive {
        /// Name of the number.
        what: &'static str,
        /// Refused number, which must be positive.
        value: f64,
    },
    /// A number that must be finite.
    #[error("{what} must be finite, but is {value}")]
    NotFinite {
        /// Name of the number.
        what: &'static str,
        /// Refused number, which is infinite or NaN.
        value: f64,
    },
    /// A polygon with fewer than three corners.
    #[error("a polygon needs at least 3 corners, but has {count}")]
    FewCorners {
        /// Number of corners given.
        count: usize,
    },
    /// A hole that is not wholly inside its polygon, or that intersects another hole.
    #[error("hole {hole} is not inside the polygon and apart from the other holes")]
    HoleOutside {
        /// Number of the hole, from 1.
        hole: usize,
    },
    /// Meshes of cells of different dimension or order, which cannot be joined.
    #[error("a mesh of {first} and one of {second} cannot be joined")]
    JoinedKinds {
        /// Cell kinds of the first mesh.
        first: &'static str,
        /// Cell kinds of the second mesh.
        second: &'static str,
    },
    /// Meshes to be joined have no node in common.
    #[error("the two meshes have no node at the same place")]
    NothingShared,
    /// Two corners of a polygon that follow each other coincide.
    #[error("side {side} of the polygon has no length")]
    EmptySide {
        /// Number of the side of zero length, from 1.
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
    /// A cell count that is not a multiple of the number required by the shape.
    #[error("the number of cells {direction} must be a multiple of {of}, but is {count}")]
    NotMultiple {
        /// Direction that is divided.
        direction: &'static str,
        /// Refused number of cells.
        count: usize,
        /// Divisor that the count must be a multiple of.
        of: usize,
    },
    /// A cell count below its minimum.
    #[error("the number of cells {direction} must be at least {least}, but is {count}")]
    TooFewCells {
        /// Direction that is divided.
        direction: &'static str,
        /// Refused number of cells.
        count: usize,
        /// The least admissible count.
        least: usize,
    },
    /// More cells than a mesh may have.
    #[error("the mesh would have {cells} cells, but {limit} is the limit")]
    TooManyCells {
        /// Number of cells requested, saturated.
        cells: usize,
        /// Largest admissible number of cells.
        limit: usize,
    },
    /// More cells than fit into memory.
    #[error("the mesh would have {cells} cells: {shortage}")]
    Memory {
        /// Number of cells requested.
        cells: usize,
        /// Required and available memory `[bytes]`.
        shortage: Shortage,
    },
    /// Cells of a kind into which the cells of the mesh cannot be converted.
    #[error("cells of the kind {to} cannot be made of cells of the kind {from}")]
    NoConversion {
        /// Kind of the mesh.
        from: &'static str,
        /// Requested cell kind.
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
    /// An arc whose end angle does not exceed its start angle by more than 0 and less than a full turn.
    #[error("an arc must end behind its start by less than a full turn, but goes from {start} to {end}")]
    Turn {
        /// Angle of the start `[rad]`.
        start: f64,
        /// Angle of the end `[rad]`.
        end: f64,
    },
    /// The end of an arc that is not on its circle.
    #[error("the arc starts {radius} from its center, but ends {distance} from it")]
    OffCircle {
        /// Distance of the start from the center `[length]`.
        radius: f64,
        /// Distance of the end from the center `[length]`.
        distance: f64,
    },
    /// Three points of an arc on one line.
    #[error("the three points of the arc are on one line")]
    StraightArc,
    /// A curve through too few points.
    #[error("a spline needs at least {least} points, but has {count}")]
    FewPoints {
        /// Number of points given.
        count: usize,
        /// Minimum number of points.
        least: usize,
    },
    /// An outline that does not close, or whose curves do not follow each other.
    #[error("curve {curve} of {what} begins at {}, but the one before it ends at {}", spot(.found), spot(.expected))]
    OpenOutline {
        /// The outline or a hole.
        what: String,
        /// Number of the curve, from 1.
        curve: usize,
        /// Start of the curve `[length]`.
        found: [f64; 2],
        /// End of the preceding curve `[length]`.
        expected: [f64; 2],
    },
    /// Two curves of the outline or of holes with a common point that is not an end of both.
    #[error("{first} and {second} touch or cross near {}", spot(.near))]
    CrossingCurves {
        /// Name of the first crossing curve.
        first: String,
        /// Name of the second crossing curve.
        second: String,
        /// Approximate position `[length]`.
        near: [f64; 2],
    },
    /// Layers along a boundary that no side belongs to.
    #[error("there is no boundary \"{name}\" for layers; the boundaries are {}", listed(.available))]
    UnknownLayers {
        /// Requested name.
        name: String,
        /// Names of the existing boundaries.
        available: Vec<String>,
    },
    /// Layers that are too thick: they intersect each other or the rim.
    #[error(
        "the layers of {names} are {} thick together, but near {} there is room for {}",
        rounded(*.thickness), spot(.near), rounded(*.room)
    )]
    LayersCollide {
        /// Quoted names of the boundaries with layers.
        names: String,
        /// Thickness of all layers `[length]`.
        thickness: f64,
        /// Approximate thickness for which there is room `[length]`.
        room: f64,
        /// Approximate position `[length]`.
        near: [f64; 2],
    },
    /// Layers that leave no room for a valid cell beside them.
    #[error("the layers of {names}, {} thick together, leave a cell near {} without room", rounded(*.thickness), spot(.near))]
    LayersCramped {
        /// Quoted names of the boundaries with layers.
        names: String,
        /// Thickness of all layers `[length]`.
        thickness: f64,
        /// Approximate position `[length]`.
        near: [f64; 2],
    },
    /// A corner that is too sharp for layers around it.
    #[error("the layers of {names} cannot go round the corner of {:.0} degrees at {}", degrees, spot(.near))]
    LayerCorner {
        /// Quoted names of the boundaries with layers.
        names: String,
        /// Interior angle of the body at the corner, in degrees.
        degrees: f64,
        /// Position of the corner `[length]`.
        near: [f64; 2],
    },
    /// An odd number of layers of quadrilaterals that end within the body.
    #[error("the {count} layers of {names} end within the body at {}, where quadrilaterals fit to an even number only", spot(.near))]
    OddLayers {
        /// Quoted names of the boundaries with layers.
        names: String,
        /// Refused number of layers.
        count: usize,
        /// Position where the layers end `[length]`.
        near: [f64; 2],
    },
    /// A cell kind that cannot be refined locally.
    #[error("cells of the kind {kind} cannot be refined in some places only: nodes would hang on the edges of their neighbors")]
    NotLocally {
        /// Kind of the cells.
        kind: &'static str,
    },
    /// A cell kind that cannot be refined.
    #[error("cells of the kind {kind} cannot be refined: half a pyramid is a tetrahedron")]
    NotRefined {
        /// Kind of the cells.
        kind: &'static str,
    },
    /// A grading so strong that the smallest cells have zero size.
    #[error("{count} cells whose last is {ratio} times the first leave no room for some of them")]
    Grading {
        /// Ratio of the last to the first cell.
        ratio: f64,
        /// Number of cells.
        count: usize,
    },
    /// A cell kind that cannot be extruded.
    #[error("a mesh of {kind} cells cannot be extruded")]
    Extruded {
        /// Kind of the cells.
        kind: &'static str,
    },
    /// A section that sweeps over itself on its path, so that cells are inverted.
    #[error("the section sweeps over itself: a cell at {} is inside out", spot(.center))]
    SweptOver {
        /// Mean of the nodes of the cell `[length]`.
        center: Vec<f64>,
    },
    /// A path of too few points.
    #[error("a path needs at least {least} points, but has {count}")]
    PathPoints {
        /// Number of points given.
        count: usize,
        /// Minimum number of points.
        least: usize,
    },
    /// Two coincident consecutive points of a path.
    #[error("the points {point} and {} of the path are at the same place, {}", point + 1, spot(.at))]
    CoincidentPathPoints {
        /// Number of the first of the two points, from 1.
        point: usize,
        /// Common position of the two points `[length]`.
        at: [f64; 3],
    },
    /// A path with a turn of 90 degrees or more at a point.
    #[error("the path turns by {degrees:.0} degrees at its point {point}, {}", spot(.at))]
    PathTurns {
        /// Number of the point, from 1.
        point: usize,
        /// Position of the point `[length]`.
        at: [f64; 3],
        /// Angle by which the path turns, in degrees.
        degrees: f64,
    },
    /// A twist, scale or grading along a closed path, whose last section must equal its first one.
    #[error("the path is closed, so the section at its end must equal that at its start: without twist, scale and grading")]
    ClosedChange,
    /// Two meshes for a loft whose cells do not name the same nodes.
    #[error("the cells of the two meshes do not name the same nodes: {first}, and {second}")]
    Lofted {
        /// Counts of nodes and cells of the first mesh.
        first: String,
        /// Counts of nodes and cells of the second mesh.
        second: String,
    },
    /// An angle of revolution that is zero, or larger than a full turn.
    #[error("a mesh is turned by more than 0 and by at most a full turn of 2 pi, but the angle is {angle}")]
    Revolution {
        /// Refused angle of the revolution `[rad]`.
        angle: f64,
    },
    /// A plane mesh that the axis of revolution touches or cuts.
    #[error("the mesh is not wholly on one side of the axis of revolution: it meets it near {}", spot(.at))]
    OnAxis {
        /// A node on the axis or beyond it `[length]`.
        at: [f64; 2],
    },
    /// A rounding radius of at least half the smallest size of the block.
    #[error("the radius {} of the edges must be smaller than half the least size {}", rounded(*.radius), rounded(*.size))]
    Rounding {
        /// The radius `[length]`.
        radius: f64,
        /// The least size `[length]`.
        size: f64,
    },
    /// A transform that takes a plane mesh out of its plane.
    #[error("{what} takes the plane mesh out of its plane z = 0")]
    LeavesPlane {
        /// Transform that would leave the plane.
        what: &'static str,
    },
    /// A rotation axis without direction.
    #[error("the rotation axis ({}, {}, {}) has no direction", axis[0], axis[1], axis[2])]
    NoAxis {
        /// Refused axis, of length zero or not finite.
        axis: [f64; 3],
    },
    /// A part that the mesh does not have.
    #[error("the mesh has no part \"{name}\"; its parts are {}", listed(.available))]
    UnknownPart {
        /// Requested name.
        name: String,
        /// Names of the existing parts.
        available: Vec<String>,
    },
    /// A new boundary with the name of an existing one.
    #[error("the mesh already has a boundary \"{name}\"; its boundaries are {}", listed(.available))]
    BoundaryExists {
        /// Name that is in use.
        name: String,
        /// Names of the existing boundaries.
        available: Vec<String>,
    },

    /// A cell with a nonpositive Jacobian determinant: reversed node order, or crossing facets.
    #[error(
        "cell {cell} at {} is inside out: its Jacobian determinant is {} ({inverted} of {cells} cells are)",
        spot(.center), rounded(*.determinant)
    )]
    InvertedCell {
        /// Place in the file.
        at: Option<FilePosition>,
        /// Number in the file; index in the mesh when no file was read.
        cell: u64,
        /// Mean of the nodes of the cell, one coordinate per dimension `[length]`.
        center: Vec<f64>,
        /// Smallest Jacobian determinant at the quadrature points of the cell.
        determinant: f64,
        /// Number of cells that are inside out.
        inverted: usize,
        /// Number of all cells.
        cells: usize,
    },
    /// A cell without area or volume.
    #[error("cell {cell} at {} has no {}: its Jacobian determinant is {}", spot(.center), extent(.center), rounded(*.determinant))]
    DegenerateCell {
        /// Place in the file.
        at: Option<FilePosition>,
        /// Number in the file; index in the mesh when no file was read.
        cell: u64,
        /// Mean of the nodes of the cell, one coordinate per dimension `[length]`.
        center: Vec<f64>,
        /// Smallest Jacobian determinant at the quadrature points of the cell.
        determinant: f64,
    },
    /// A cell that names a node twice.
    #[error("cell {cell} names node {node} twice")]
    RepeatedNode {
        /// Place in the file.
        at: Option<FilePosition>,
        /// Number in the file; index in the mesh when no file was read.
        cell: u64,
        /// Number of the node that occurs twice in the cell.
        node: u64,
    },
    /// A facet that more than two cells share.
    #[error("{sharing} cells share one facet of cell {cell}, but a facet has at most two sides")]
    CrowdedFacet {
        /// Place in the file.
        at: Option<FilePosition>,
        /// Number of the first of the cells in the file; its index in the mesh when no file was read.
        cell: u64,
        /// Number of cells that share the facet.
        sharing: usize,
    },
    /// Cells of different kinds side by side whose facets do not match.
    #[error("cell {cell} at {} does not match its neighbor: a facet of {kind} and one of {other} have different nodes", spot(.center))]
    Unmatched {
        /// Place in the file.
        at: Option<FilePosition>,
        /// Number in the file; index in the mesh when no file was read.
        cell: u64,
        /// Mean of the nodes of the cell `[length]`.
        center: Vec<f64>,
        /// Kind of the cell.
        kind: &'static str,
        /// Kind of the neighbor.
        other: &'static str,
    },
    /// A non-convex (folded) facet of the surface, on which contact is not defined.
    #[error("a facet of cell {cell} at {} is folded: its corners do not all look to the same side ({count} facets are)", spot(.at))]
    FoldedFacet {
        /// Index of the cell.
        cell: u64,
        /// Mean of the corners of the facet `[length]`.
        at: Vec<f64>,
        /// Number of folded facets.
        count: usize,
    },
    /// Adjacent cells with coincident facets but different nodes: the parts are not joined.
    #[error("{count} facets of the mesh lie on others without common nodes, the first at {}: the cells are not joined there", spot(.at))]
    Unjoined {
        /// Number of facets that lie on another one without common nodes.
        count: usize,
        /// Mean of the corners of the first facet that lies on another one `[length]`.
        at: Vec<f64>,
    },
    /// A surface that intersects itself.
    #[error(
        "the surface of the mesh goes through itself at {}: an edge of cell {} through a facet of cell {} ({count} edges do)",
        spot(.at), cells[0], cells[1]
    )]
    CrossingSurface {
        /// Indices of the cells.
        cells: [u64; 2],
        /// Point of the crossing `[length]`.
        at: Vec<f64>,
        /// Number of edges that go through facets.
        count: usize,
    },
    /// Nodes that no cell uses.
    #[error("{count} nodes belong to no cell, the first is node {node}")]
    UnusedNodes {
        /// Number of unused nodes.
        count: usize,
        /// Index of the first unused node in the mesh.
        node: u64,
    },
    /// A cell, facet or part that refers to something that the mesh does not have (a mesh put together by hand).
    #[error("{what} {index} refers to {target}, but there are only {count}")]
    BrokenReference {
        /// Kind of the entity that refers, such as a cell.
        what: &'static str,
        /// Index of the entity that refers.
        index: usize,
        /// Invalid index that is referred to.
        target: usize,
        /// Number of entities that exist; valid indices are smaller.
        count: usize,
    },

    /// A mesh file that is refused.
    #[error(transparent)]
    File(#[from] FileError),
    /// An error in a file that a mesh file includes.
    #[error("{error}")]
    Included {
        /// Path of the included file.
        file: PathBuf,
        /// Error found in the included file.
        error: Box<MeshError>,
    },
}

/// Names in quotation marks, or `none`.
fn listed(names: &[String]) -> String {
    if names.is_empty() {
        return "none (it has no physical groups of cells)".into();
    }
    names.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
}

/// A point with six digits.
fn spot(point: &[f64]) -> String {
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
        assert_eq!(spot(&[0.1 + 0.2, -4.0]), "(0.3, -4)");
    }
}
