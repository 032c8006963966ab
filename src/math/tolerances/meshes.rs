//! Tolerances of meshes and of surfaces of triangles.

/// Jacobian determinant of a cell, relative to its longest edge to the power of the dimension, below which it has no area or volume:
/// ten thousand times the round-off of the product, and far below any graded mesh (an aspect ratio of 1e4 gives 1e-5).
pub const DEGENERATE_CELL: f64 = 1e-12;

/// Distance of two nodes of meshes to be joined, relative to the largest coordinate, up to which they are at the same place.
pub const SAME_PLACE: f64 = 1e-9;

/// Distance from a plane, cylinder or sphere, relative to the largest coordinate, up to which nodes are on it: files of meshes are written
/// with six digits or more.
pub const ON_SHAPE: f64 = 1e-6;

/// Distance of two points of a surface of triangles, relative to its size, up to which they are one point: STL files have seven digits.
pub const SAME_POINT: f64 = 1e-6;

/// Two faces count as coplanar if `1 - cos(a/2)` is at most this, with the angle `a` between their normals: round-off of triangle normals.
pub const COPLANAR: f64 = 1e-12;

/// Share of each corner, in a point of a facet that an edge goes through, above which the point is inside and not on the facet's rim: edges
/// that only touch meet the rim to round-off, 1e-15.
pub const PIERCED: f64 = 1e-6;

/// Third coordinate of a plane mesh file, relative to the largest coordinate, that counts as zero: what rotations in a mesh
/// generator leave.
pub const PLANE: f64 = 1e-12;

/// Distance of a point from the place that reference coordinates give, relative to the cell, at which Newton's method has found them.
pub const LOCATED: f64 = 1e-14;

/// Distance from the reference cell up to which reference coordinates are inside: points on a side that neighbors share.
pub const INSIDE_CELL: f64 = 1e-9;

/// Offset of a mid-side node from the chord, relative to the chord, below which the edge counts as straight: round-off of mesh files with
/// few digits, far below any relevant curvature.
pub const STRAIGHT: f64 = 1e-7;
