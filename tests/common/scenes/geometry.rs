//! Points, segments and outlines in the plane: inside or outside, depth, clearance, crossings. Brute force, independent of the kernels.

/// A point or a vector.
pub type Point = [f64; 2];

/// Straight segment between two points.
pub type Segment = [Point; 2];

pub fn add(a: Point, b: Point) -> Point {
    [a[0] + b[0], a[1] + b[1]]
}

pub fn subtract(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

pub fn scaled(factor: f64, a: Point) -> Point {
    [factor * a[0], factor * a[1]]
}

pub fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

pub fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

pub fn length(a: Point) -> f64 {
    a[0].hypot(a[1])
}

/// A vector rotated counter-clockwise.
pub fn turned(angle: f64, a: Point) -> Point {
    let (s, c) = angle.sin_cos();
    [c * a[0] - s * a[1], s * a[0] + c * a[1]]
}

/// Distance of a point from a segment.
pub fn distance(x: Point, [a, b]: Segment) -> f64 {
    let (side, arm) = (subtract(b, a), subtract(x, a));
    let square = dot(side, side);
    let share = if square > 0.0 { (dot(side, arm) / square).clamp(0.0, 1.0) } else { 0.0 };
    length(subtract(arm, scaled(share, side)))
}

/// True if two segments cross, each with its ends on both sides of the other.
pub fn segments_cross([a, b]: Segment, [c, d]: Segment) -> bool {
    let side = |p: Point, q: Point, x: Point| cross(subtract(q, p), subtract(x, p));
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}

/// Closed loops that bound a region, as segments in any order.
#[derive(Clone, Debug)]
pub struct Outline {
    pub segments: Vec<Segment>,
    /// Smallest and largest coordinates.
    pub bounds: [Point; 2],
}

impl Outline {
    pub fn new(segments: Vec<Segment>) -> Outline {
        let mut bounds = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        for point in segments.iter().flatten() {
            for i in 0..2 {
                bounds[0][i] = bounds[0][i].min(point[i]);
                bounds[1][i] = bounds[1][i].max(point[i]);
            }
        }
        Outline { segments, bounds }
    }

    /// The outline displaced.
    pub fn moved(&self, offset: Point) -> Outline {
        Outline::new(self.segments.iter().map(|segment| segment.map(|point| add(point, offset))).collect())
    }

    /// Length of the shortest segment.
    pub fn shortest(&self) -> f64 {
        self.segments.iter().map(|[a, b]| length(subtract(*b, *a))).fold(f64::INFINITY, f64::min)
    }

    /// First points of all segments: each corner of the closed loops once.
    pub fn corners(&self) -> impl Iterator<Item = Point> + '_ {
        self.segments.iter().map(|segment| segment[0])
    }

    /// True if a point lies in the bounding box of the outline.
    pub fn may_hold(&self, x: Point) -> bool {
        (0..2).all(|i| x[i] >= self.bounds[0][i] && x[i] <= self.bounds[1][i])
    }

    /// True if a point lies inside: a ray from the point crosses the outline an odd number of times.
    pub fn holds(&self, x: Point) -> bool {
        if !self.may_hold(x) {
            return false;
        }
        let crossed = |&[a, b]: &Segment| (a[1] > x[1]) != (b[1] > x[1]) && x[0] < a[0] + (x[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
        self.segments.iter().filter(|segment| crossed(segment)).count() % 2 == 1
    }

    /// The segment nearest to a point, and its distance.
    pub fn nearest(&self, x: Point) -> (usize, f64) {
        let distances = self.segments.iter().map(|&segment| distance(x, segment)).enumerate();
        distances.fold((0, f64::INFINITY), |least, next| if next.1 < least.1 { next } else { least })
    }

    /// Distance of two regions; 0 if they overlap.
    pub fn clearance(&self, other: &Outline) -> f64 {
        let overlap = self.segments.iter().any(|a| other.segments.iter().any(|b| segments_cross(*a, *b)));
        if overlap || self.corners().any(|x| other.holds(x)) || other.corners().any(|x| self.holds(x)) {
            return 0.0;
        }
        let from = |a: &Outline, b: &Outline| a.corners().map(|x| b.nearest(x).1).fold(f64::INFINITY, f64::min);
        from(self, other).min(from(other, self))
    }
}
