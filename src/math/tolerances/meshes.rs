//! Tolerances of meshes and of surfaces of triangles.

/// Jacobian determinant of a cell, relative to its longest edge to the power of the dimension, below which it has no area or volume:
/// ten thousand times the round-off of the product, and far below any graded mesh (an aspect ratio of 1e4 gives 1e-5).
pub const DEGENERATE_CELL: f64 = 1e-12;

/// Distance between nodes of joined meshes, relative to the largest coordinate, up to which they are merged.
pub const SAME_PLACE: f64 = 1e-9;

/// Distance from a plane, cylinder or sphere, relative to the largest coordinate, up to which nodes lie on it: mesh files have at least six
/// digits.
pub const ON_SHAPE: f64 = 1e-6;

/// Distance between points of a triangulated surface, relative to its size, up to which they are merged: STL files have seven digits.
pub const SAME_POINT: f64 = 1e-6;

/// Two faces count as coplanar if `1 - cos(a/2)` is at most this, with the angle `a` between their normals: round-off of triangle normals.
pub const COPLANAR: f64 = 1e-12;

/// Smallest barycentric coordinate above which an edge intersects the interior of a facet and not its border: edges that only touch have
/// round-off, 1e-15.
pub const PIERCED: f64 = 1e-6;

/// Third coordinate in a plane mesh file, relative to the largest coordinate, that counts as zero: round-off of rotations in a mesh
/// generator.
pub const PLANE: f64 = 1e-12;

/// Residual position error, relative to the cell, at which Newton's method for the reference coordinates of a point has converged.
pub const LOCATED: f64 = 1e-14;

/// Distance from the reference cell up to which reference coordinates count as inside, for points on a side that neighbors share.
pub const INSIDE_CELL: f64 = 1e-9;

/// Offset of a mid-side node from the chord, relative to the chord, below which the edge counts as straight: round-off of mesh files with
/// few digits, far below any relevant curvature.
pub const STRAIGHT: f64 = 1e-7;
