//! Curves that bound a region: lines, circular arcs, cubic splines; and their division into pieces.
//!
//! A spline is the natural cubic one over its chord lengths (C. de Boor, A Practical Guide to Splines, 1978, chapter IV): twice
//! continuously differentiable, with zero curvature at its ends. A closed spline is periodic, without a corner.

use std::f64::consts::{PI, TAU};

use super::MeshError;
use super::grid::positive;
use crate::math::tolerances::{ON_CIRCLE, SUM_OF_LENGTHS};

type Point = [f64; 2];

/// Largest number of pieces of a side: with more, any region but a thin strip exceeds the largest number of cells.
pub(super) const SIDE_LIMIT: usize = 100_000;

/// A curve of an outline or a hole.
#[derive(Clone, Debug, PartialEq)]
pub struct OutlineSide {
    /// Shape of the side.
    pub curve: Curve,
    /// Name of the boundary of the side, in addition to `outer` or the boundary of its hole.
    pub name: Option<String>,
}

/// A curve with a parameter from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub enum Curve {
    /// A straight line.
    Line {
        /// Start of the line `[length]`.
        from: [f64; 2],
        /// End of the line `[length]`.
        to: [f64; 2],
    },
    /// An arc of a circle.
    Arc {
        /// Center of the circle `[length]`.
        center: [f64; 2],
        /// Radius of the circle `[length]`.
        radius: f64,
        /// Angle of the start `[rad]`.
        start: f64,
        /// Angle from the start to the end `[rad]`, positive counter-clockwise.
        sweep: f64,
        /// Exact end points, to the last bit.
        ends: [[f64; 2]; 2],
    },
    /// A cubic spline.
    Spline {
        /// Interpolated points `[length]`.
        points: Vec<[f64; 2]>,
        /// Chord lengths from the first point on.
        knots: Vec<f64>,
        /// Second derivatives at the points.
        bends: Vec<[f64; 2]>,
    },
}

fn finite(points: &[Point]) -> Result<(), MeshError> {
    match points.as_flattened().iter().find(|value| !value.is_finite()) {
        Some(&value) => Err(MeshError::NotFinite { what: "a coordinate of an outline", value }),
        None => Ok(()),
    }
}

fn distance(a: Point, b: Point) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

impl Curve {
    /// A straight line.
    ///
    /// # Errors
    /// Coordinates that are not finite.
    pub fn line(from: [f64; 2], to: [f64; 2]) -> Result<Curve, MeshError> {
        finite(&[from, to])?;
        Ok(Curve::Line { from, to })
    }

    /// Arc about a center. Its end is the intersection of the circle with the direction to `to`, which must lie on the circle up to a
    /// thousandth of the radius; if start and end coincide it is a full circle.
    ///
    /// # Errors
    /// Coordinates that are not finite, a center at the start, an end that is not on the circle.
    pub fn arc(from: [f64; 2], to: [f64; 2], center: [f64; 2], is_clockwise: bool) -> Result<Curve, MeshError> {
        finite(&[from, to, center])?;
        let radius = distance(center, from);
        positive("the radius of an arc", radius)?;
        let far = distance(center, to);
        if (far - radius).abs() > ON_CIRCLE * radius {
            return Err(MeshError::OffCircle { radius, distance: far });
        }
        let angle = |point: Point| (point[1] - center[1]).atan2(point[0] - center[0]);
        let start = angle(from);
        let mut sweep = (angle(to) - start).rem_euclid(TAU);
        if is_clockwise {
            sweep -= TAU;
        }
        if from == to || sweep == 0.0 {
            sweep = if is_clockwise { -TAU } else { TAU };
        }
        Ok(Curve::Arc { center, radius, start, sweep, ends: [from, to] })
    }

    /// The arc from one point through another to a third.
    ///
    /// # Errors
    /// Coordinates that are not finite, points on one line.
    pub fn arc_through(from: [f64; 2], through: [f64; 2], to: [f64; 2]) -> Result<Curve, MeshError> {
        finite(&[from, through, to])?;
        let (a, b) = ([through[0] - from[0], through[1] - from[1]], [to[0] - from[0], to[1] - from[1]]);
        let twice = 2.0 * (a[0] * b[1] - a[1] * b[0]);
        let (aa, bb) = (a[0] * a[0] + a[1] * a[1], b[0] * b[0] + b[1] * b[1]);
        let center = [from[0] + (b[1] * aa - a[1] * bb) / twice, from[1] + (a[0] * bb - b[0] * aa) / twice];
        if !center.iter().all(|x| x.is_finite()) {
            return Err(MeshError::StraightArc);
        }
        // With `through` to the right of the chord from `from` to `to`, the arc is counter-clockwise.
        Curve::arc(from, to, center, twice < 0.0)
    }

    /// The circle of a hole or an outline, counter-clockwise.
    ///
    /// # Errors
    /// A radius that is not positive, coordinates that are not finite.
    pub fn circle(center: [f64; 2], radius: f64) -> Result<Curve, MeshError> {
        positive("the radius of a circle", radius)?;
        let start = [center[0] + radius, center[1]];
        finite(&[center, start])?;
        Ok(Curve::Arc { center, radius, start: 0.0, sweep: TAU, ends: [start, start] })
    }

    /// Smooth curve through points, of which consecutive ones must differ; closed without a corner if it ends at its start.
    ///
    /// # Errors
    /// Fewer than 2 points (closed: 4), coordinates that are not finite, points that coincide.
    pub fn spline(points: Vec<[f64; 2]>) -> Result<Curve, MeshError> {
        finite(&points)?;
        let is_closed = points.len() > 1 && points.first() == points.last();
        let least = if is_closed { 4 } else { 2 };
        if points.len() < least {
            return Err(MeshError::FewPoints { count: points.len(), least });
        }
        let chords: Vec<f64> = points.windows(2).map(|pair| distance(pair[0], pair[1])).collect();
        if let Some(place) = chords.iter().position(|&chord| chord == 0.0) {
            return Err(MeshError::EmptySide { side: place + 1 });
        }
        let mut knots = vec![0.0];
        chords.iter().for_each(|chord| knots.push(knots[knots.len() - 1] + chord));
        let bends = if is_closed { periodic_bends(&points, &chords) } else { natural_bends(&points, &chords) };
        Ok(Curve::Spline { points, knots, bends })
    }

    /// Point at a parameter.
    pub fn at(&self, t: f64) -> [f64; 2] {
        match self {
            Curve::Line { from, to } => [0, 1].map(|i| from[i] * (1.0 - t) + to[i] * t),
            Curve::Arc { ends, .. } if t <= 0.0 => ends[0],
            Curve::Arc { ends, .. } if t >= 1.0 => ends[1],
            Curve::Arc { center, radius, start, sweep, .. } => {
                let (sine, cosine) = (start + sweep * t).sin_cos();
                [center[0] + radius * cosine, center[1] + radius * sine]
            }
            Curve::Spline { points, knots, bends } => {
                let last = points.len() - 1;
                if t >= 1.0 {
                    return points[last];
                }
                let s = t.max(0.0) * knots[last];
                let k = (knots.partition_point(|&knot| knot <= s).max(1) - 1).min(last - 1);
                let h = knots[k + 1] - knots[k];
                let (a, b) = ((knots[k + 1] - s) / h, (s - knots[k]) / h);
                let bend = |i: usize| ((a * a * a - a) * bends[k][i] + (b * b * b - b) * bends[k + 1][i]) * h * h / 6.0;
                [0, 1].map(|i| a * points[k][i] + b * points[k + 1][i] + bend(i))
            }
        }
    }

    /// Start point of the curve.
    pub fn start(&self) -> [f64; 2] {
        self.at(0.0)
    }

    /// End point of the curve.
    pub fn end(&self) -> [f64; 2] {
        self.at(1.0)
    }

    /// Smallest number of pieces that represent the shape: an eighth of a circle each, and two between the points of a spline.
    fn fewest(&self) -> usize {
        match self {
            Curve::Line { .. } => 1,
            Curve::Arc { sweep, .. } => (sweep.abs() / (PI / 4.0) - ON_CIRCLE).ceil().max(1.0) as usize,
            Curve::Spline { points, .. } => 2 * (points.len() - 1),
        }
    }

    /// Parameters of the ends of pieces with lengths of about `size`, from 0 to 1; at most `limit` pieces.
    ///
    /// # Errors
    /// An error of `size`; more pieces than the limit.
    pub fn divided<E: From<MeshError>>(&self, mut size: impl FnMut([f64; 2]) -> Result<f64, E>, limit: usize) -> Result<Vec<f64>, E> {
        // Number of samples, sufficient for the length of an arc to a millionth and to find places with a small cell size.
        const SAMPLES: usize = 1024;
        let mut wanted = vec![0.0];
        let mut before = self.at(0.0);
        let mut size_before = size(before)?;
        for sample in 1..=SAMPLES {
            let point = self.at(sample as f64 / SAMPLES as f64);
            let size_here = size(point)?;
            wanted.push(wanted[sample - 1] + distance(before, point) * 0.5 * (1.0 / size_before + 1.0 / size_here));
            (before, size_before) = (point, size_here);
        }
        let whole = wanted[SAMPLES];
        if whole.is_nan() || whole >= limit as f64 {
            return Err(MeshError::TooManyCells { cells: whole as usize, limit }.into());
        }
        // Round-off of the summed length must not add a piece.
        let pieces = ((whole * (1.0 - SUM_OF_LENGTHS)).ceil() as usize).max(self.fewest());
        let mut places = vec![0.0];
        let mut sample = 0;
        for piece in 1..pieces {
            let share = whole * piece as f64 / pieces as f64;
            while wanted[sample + 1] < share {
                sample += 1;
            }
            let part = (share - wanted[sample]) / (wanted[sample + 1] - wanted[sample]);
            places.push((sample as f64 + part) / SAMPLES as f64);
        }
        places.push(1.0);
        Ok(places)
    }
}

/// Second derivatives of the natural spline: zero at both ends.
fn natural_bends(points: &[Point], chords: &[f64]) -> Vec<Point> {
    let count = points.len();
    let rows = (1..count - 1).map(|k| row(points, chords, k - 1, k, k + 1, k));
    let mut inner = tridiagonal(rows.collect());
    inner.insert(0, [0.0; 2]);
    inner.push([0.0; 2]);
    inner
}

/// Row of the spline's tridiagonal equations: coefficients of the second derivatives at the point before, at the point and at the point
/// after, and the right-hand side.
type Row = ([f64; 3], Point);

fn row(points: &[Point], chords: &[f64], before: usize, here: usize, after: usize, chord: usize) -> Row {
    let (h, g) = (chords[if chord == 0 { chords.len() - 1 } else { chord - 1 }], chords[chord]);
    let right = [0, 1].map(|i| (points[after][i] - points[here][i]) / g - (points[here][i] - points[before][i]) / h);
    ([h / 6.0, (h + g) / 3.0, g / 6.0], right)
}

/// Gaussian elimination from the first row to the last; the matrix is diagonally dominant.
fn tridiagonal(mut rows: Vec<Row>) -> Vec<Point> {
    for k in 1..rows.len() {
        let ([_, diagonal, above], right) = rows[k - 1];
        let ([below, here, _], own) = &mut rows[k];
        let factor = *below / diagonal;
        *here -= factor * above;
        *own = [0, 1].map(|i| own[i] - factor * right[i]);
    }
    let mut solution = vec![[0.0; 2]; rows.len()];
    for k in (0..rows.len()).rev() {
        let ([_, diagonal, above], right) = rows[k];
        let next = solution.get(k + 1).copied().unwrap_or_default();
        solution[k] = [0, 1].map(|i| (right[i] - above * next[i]) / diagonal);
    }
    solution
}

/// Second derivatives of the periodic spline, with the corner entries of the matrix by the Sherman-Morrison formula (1950).
fn periodic_bends(points: &[Point], chords: &[f64]) -> Vec<Point> {
    let count = points.len() - 1;
    let around = |k: usize| if k == 0 { count - 1 } else { k - 1 };
    let mut rows: Vec<Row> = (0..count).map(|k| row(points, chords, around(k), k, k + 1, k)).collect();
    let corner = rows[0].0[0];
    let gamma = -rows[0].0[1];
    rows[0].0[1] -= gamma;
    rows[count - 1].0[1] -= corner * corner / gamma;
    let plain = tridiagonal(rows.clone());
    for (k, (_, right)) in rows.iter_mut().enumerate() {
        *right = [
            if k == 0 {
                gamma
            } else if k == count - 1 {
                corner
            } else {
                0.0
            },
            0.0,
        ];
    }
    let column: Vec<f64> = tridiagonal(rows).iter().map(|entry| entry[0]).collect();
    let share = corner / gamma;
    let bottom = 1.0 + column[0] + share * column[count - 1];
    let factor = [0, 1].map(|i| (plain[0][i] + share * plain[count - 1][i]) / bottom);
    let mut bends: Vec<Point> = plain.iter().zip(&column).map(|(entry, c)| [0, 1].map(|i| entry[i] - factor[i] * c)).collect();
    bends.push(bends[0]);
    bends
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pieces(curve: &Curve, size: f64) -> Vec<f64> {
        curve.divided(|_| Ok::<_, MeshError>(size), 1000).unwrap()
    }

    #[test]
    fn arcs_go_the_way_that_is_asked_for() {
        let quarter = Curve::arc([1.0, 0.0], [0.0, 1.0], [0.0, 0.0], false).unwrap();
        let middle = quarter.at(0.5);
        assert!((middle[0] - 0.5f64.sqrt()).abs() < 1e-15 && (middle[1] - 0.5f64.sqrt()).abs() < 1e-15);
        let rest = Curve::arc([1.0, 0.0], [0.0, 1.0], [0.0, 0.0], true).unwrap();
        assert!((rest.at(0.5)[0] + 0.5f64.sqrt()).abs() < 1e-15);
        for through in [[0.6, 0.8], [0.0, -1.0], [-0.6, 0.8]] {
            let arc = Curve::arc_through([1.0, 0.0], through, [-0.8, -0.6]).unwrap();
            let near = (0..=1000).map(|i| distance(arc.at(f64::from(i) / 1000.0), through)).fold(f64::INFINITY, f64::min);
            assert!(near < 0.01, "{through:?} {near}");
        }
        assert_eq!(pieces(&Curve::circle([0.0, 0.0], 1.0).unwrap(), 10.0).len(), 9);
        assert_eq!(Curve::arc_through([0.0, 0.0], [1.0, 1.0], [2.0, 2.0]), Err(MeshError::StraightArc));
        assert!(matches!(Curve::arc([1.0, 0.0], [0.0, 1.1], [0.0, 0.0], false), Err(MeshError::OffCircle { .. })));
    }

    #[test]
    fn splines_meet_their_points_and_closed_ones_are_smooth() {
        let points = vec![[0.0, 0.0], [1.0, 0.5], [1.5, 2.0], [3.0, 2.0]];
        let open = Curve::spline(points.clone()).unwrap();
        let Curve::Spline { knots, .. } = &open else { unreachable!() };
        for (point, knot) in points.iter().zip(knots) {
            assert!(distance(open.at(knot / knots[3]), *point) < 1e-14);
        }
        // a circle through 24 points: the error of a cubic spline is h^4 / 384 of the fourth derivative, here 1e-5
        let around: Vec<[f64; 2]> = (0..=24).map(|k| (f64::from(k % 24) * TAU / 24.0).sin_cos()).map(|(s, c)| [c, s]).collect();
        let circle = Curve::spline(around).unwrap();
        let worst = (0..500).map(|k| circle.at(f64::from(k) / 500.0)).map(|[x, y]| (x.hypot(y) - 1.0).abs()).fold(0.0, f64::max);
        assert!(worst < 2e-5, "{worst}");
        let (before, after) = (circle.at(1.0 - 1e-6), circle.at(1e-6));
        assert!((before[0] - after[0]).abs() < 1e-9 && (before[1] + after[1]).abs() < 1e-9, "{before:?} {after:?}");
        // A spline through collinear points is a straight line.
        let line = Curve::spline(vec![[0.0, 0.0], [1.0, 1.0], [3.0, 3.0]]).unwrap();
        assert!((0..100).map(|k| line.at(f64::from(k) / 100.0)).all(|[x, y]| (x - y).abs() < 1e-15));
        assert!(matches!(Curve::spline(vec![[0.0, 0.0]]), Err(MeshError::FewPoints { .. })));
        assert!(matches!(Curve::spline(vec![[0.0, 0.0], [1.0, 0.0], [0.0, 0.0]]), Err(MeshError::FewPoints { .. })));
        assert!(matches!(Curve::spline(vec![[0.0, 0.0], [0.0, 0.0], [1.0, 0.0]]), Err(MeshError::EmptySide { side: 1 })));
    }

    #[test]
    fn pieces_are_as_long_as_wanted() {
        let line = Curve::line([0.0, 0.0], [1.0, 0.0]).unwrap();
        assert_eq!(pieces(&line, 0.25).len(), 5);
        // sizes from 0.01 to 0.11 along the line: as many pieces as the integral of 1 / size, ln(11) / 0.1 = 24
        let fine = line.divided(|[x, _]| Ok::<_, MeshError>(0.01 + 0.1 * x), 1000).unwrap();
        assert_eq!(fine.len(), 25);
        for pair in fine.windows(2) {
            let (length, middle) = (pair[1] - pair[0], 0.5 * (pair[0] + pair[1]));
            assert!((length / (0.01 + 0.1 * middle) - 1.0).abs() < 0.05, "{pair:?}");
        }
        assert!(matches!(line.divided(|_| Ok::<_, MeshError>(1e-9), 1000), Err(MeshError::TooManyCells { .. })));
    }
}
