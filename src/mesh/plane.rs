//! Points and directions in the plane.

/// True if a point is inside closed polylines with these sides: a ray from the point crosses an odd number of sides.
pub fn is_inside(sides: impl Iterator<Item = [[f64; 2]; 2]>, [x, y]: [f64; 2]) -> bool {
    let crosses = |[[ax, ay], [bx, by]]: &[[f64; 2]; 2]| (*ay > y) != (*by > y) && x < ax + (y - ay) / (by - ay) * (bx - ax);
    sides.filter(crosses).count() % 2 == 1
}

/// Third component of the cross product of two plane vectors.
pub fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}
