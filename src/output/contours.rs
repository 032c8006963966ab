//! Regions where a nodal field is above a level, on a set of cells, as closed loops.
//!
//! Painting the regions of ascending levels over each other gives filled contours without seams between cells, and a picture whose size
//! depends on its content, not on the fineness of the mesh. Cells with more than three corners are split into triangles around their
//! center, on which the field is linear (marching triangles). Loops close exactly, because their corners are identified by the mesh edge on
//! which they lie and not by their coordinates. Curved sides are drawn as two straight ones.

use std::collections::HashMap;

/// Triangles with a value at each vertex.
#[derive(Debug)]
pub(super) struct Patch {
    points: Vec<[f64; 2]>,
    values: Vec<f64>,
    triangles: Vec<[u32; 3]>,
    edges: Vec<[u32; 2]>,
    boundary: Vec<[u32; 2]>,
}

impl Patch {
    /// Set of polygons, given by indices of points. Values that are not finite count as the lowest; polygons with a point that is not
    /// finite are left out.
    pub fn new<'a>(points: &[[f64; 2]], values: &[f64], polygons: impl IntoIterator<Item = &'a [u32]>) -> Self {
        let mut points = points.to_vec();
        let mut values: Vec<f64> = values.iter().map(|&value| if value.is_finite() { value } else { f64::MIN }).collect();
        let mut triangles = Vec::new();
        let mut edges: Vec<([u32; 2], usize)> = Vec::new();
        let mut index_of = HashMap::new();
        for polygon in polygons {
            if polygon.len() < 3 || polygon.iter().any(|&node| !points[node as usize].iter().all(|x| x.is_finite())) {
                continue;
            }
            for (&a, &b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
                let edge = [a.min(b), a.max(b)];
                let index = *index_of.entry(edge).or_insert(edges.len());
                if index == edges.len() {
                    edges.push((edge, 0));
                }
                edges[index].1 += 1;
            }
            if let &[a, b, c] = polygon {
                triangles.push([a, b, c]);
                continue;
            }
            let middle = points.len() as u32;
            let mean = |part: &dyn Fn(usize) -> f64| polygon.iter().map(|&node| part(node as usize) / polygon.len() as f64).sum::<f64>();
            let center = [mean(&|node| points[node][0]), mean(&|node| points[node][1])];
            let value = mean(&|node| values[node]);
            points.push(center);
            values.push(value);
            triangles.extend(polygon.iter().zip(polygon.iter().cycle().skip(1)).map(|(&a, &b)| [a, b, middle]));
        }
        let boundary = edges.iter().filter(|(_, cells)| *cells == 1).map(|&(edge, _)| edge).collect();
        let edges = edges.into_iter().map(|(edge, _)| edge).collect();
        Patch { points, values, triangles, edges, boundary }
    }

    /// Lowest and highest value.
    pub fn range(&self) -> [f64; 2] {
        self.values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &value| [low.min(value), high.max(value)])
    }

    /// Every edge of the cells once.
    pub fn edges(&self) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
        self.edges.iter().map(|edge| edge.map(|node| self.points[node as usize]))
    }

    /// Outline of the set of cells as loops.
    pub fn outline(&self) -> Vec<Vec<[f64; 2]>> {
        self.above(f64::NEG_INFINITY)
    }

    /// Region in which the field is at or above a level, as loops in the sense of the even-odd rule.
    pub fn above(&self, level: f64) -> Vec<Vec<[f64; 2]>> {
        let inside = |node: u32| self.values[node as usize] >= level;
        let mut segments: Vec<[Corner; 2]> = Vec::new();
        for &[a, b, c] in &self.triangles {
            // The vertex that is alone on its side of the level.
            let [lone, p, q] = match [inside(a), inside(b), inside(c)] {
                [true, false, false] | [false, true, true] => [a, b, c],
                [false, true, false] | [true, false, true] => [b, c, a],
                [false, false, true] | [true, true, false] => [c, a, b],
                [true, true, true] | [false, false, false] => continue,
            };
            segments.push([corner(lone, p), corner(lone, q)]);
        }
        for &[a, b] in &self.boundary {
            match [inside(a), inside(b)] {
                [true, true] => segments.push([corner(a, a), corner(b, b)]),
                [true, false] => segments.push([corner(a, a), corner(a, b)]),
                [false, true] => segments.push([corner(b, b), corner(a, b)]),
                [false, false] => {}
            }
        }
        let place = |[a, b]: Corner| {
            let (p, q) = (self.points[a as usize], self.points[b as usize]);
            let (low, high) = (self.values[a as usize], self.values[b as usize]);
            // Halved first: the difference of two huge values may overflow.
            let share = if a == b { 0.0 } else { (0.5 * level - 0.5 * low) / (0.5 * high - 0.5 * low) };
            [p[0] + share * (q[0] - p[0]), p[1] + share * (q[1] - p[1])]
        };
        loops(&segments).into_iter().map(|corners| corners.into_iter().map(place).collect()).collect()
    }
}

/// Corner of a loop: the end nodes of the mesh edge on which the corner lies, or a node twice.
type Corner = [u32; 2];

fn corner(a: u32, b: u32) -> Corner {
    [a.min(b), a.max(b)]
}

/// Joins segments into closed loops; every corner has an even number of segments.
fn loops(segments: &[[Corner; 2]]) -> Vec<Vec<Corner>> {
    let mut at: HashMap<Corner, Vec<usize>> = HashMap::with_capacity(segments.len());
    for (index, ends) in segments.iter().enumerate() {
        for &end in ends {
            at.entry(end).or_default().push(index);
        }
    }
    let mut used = vec![false; segments.len()];
    let mut found = Vec::new();
    for first in 0..segments.len() {
        let (mut current, mut end) = (first, segments[first][0]);
        let mut corners = Vec::new();
        while !used[current] {
            used[current] = true;
            corners.push(end);
            let [a, b] = segments[current];
            end = if a == end { b } else { a };
            current = at[&end].iter().copied().find(|&next| !used[next]).unwrap_or(current);
        }
        if corners.len() > 2 {
            found.push(corners);
        }
    }
    found
}

/// Leaves out corners of a closed loop that lie within `tolerance` of the line between their neighbors (Douglas & Peucker 1973).
pub(super) fn simplified(corners: &[[f64; 2]], tolerance: f64) -> Vec<[f64; 2]> {
    if corners.len() < 4 {
        return corners.to_vec();
    }
    let distance = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    // A closed loop is cut at its first corner and at the one farthest from it.
    let opposite =
        (0..corners.len()).max_by(|&a, &b| distance(corners[0], corners[a]).total_cmp(&distance(corners[0], corners[b]))).unwrap_or(0);
    let at = |index: usize| corners[index % corners.len()];
    let mut keep = vec![false; corners.len()];
    (keep[0], keep[opposite]) = (true, true);
    let mut open = vec![(0, opposite), (opposite, corners.len())];
    while let Some((first, last)) = open.pop() {
        let (a, b) = (at(first), at(last));
        let length = distance(a, b);
        let off = |p: [f64; 2]| match length {
            0.0 => distance(a, p),
            _ => ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])).abs() / length,
        };
        let farthest = (first + 1..last).map(|index| (index, off(at(index)))).max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((index, _)) = farthest.filter(|&(_, far)| far > tolerance) {
            keep[index] = true;
            open.extend([(first, index), (index, last)]);
        }
    }
    corners.iter().zip(&keep).filter(|&(_, &keep)| keep).map(|(&corner, _)| corner).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Signed area of a closed loop.
    fn area(corners: &[[f64; 2]]) -> f64 {
        corners.iter().zip(corners.iter().cycle().skip(1)).map(|(a, b)| 0.5 * (a[0] * b[1] - a[1] * b[0])).sum()
    }

    /// The unit square in `n` times `n` cells with the values of a function.
    fn square(n: usize, value: impl Fn(f64, f64) -> f64) -> Patch {
        let points: Vec<[f64; 2]> =
            (0..(n + 1) * (n + 1)).map(|k| [(k % (n + 1)) as f64 / n as f64, (k / (n + 1)) as f64 / n as f64]).collect();
        let cells: Vec<[u32; 4]> =
            (0..n * n).map(|k| (k / n * (n + 1) + k % n) as u32).map(|k| [k, k + 1, k + n as u32 + 2, k + n as u32 + 1]).collect();
        let values: Vec<f64> = points.iter().map(|[x, y]| value(*x, *y)).collect();
        Patch::new(&points, &values, cells.iter().map(|cell| &cell[..]))
    }

    #[test]
    fn a_linear_field_is_cut_along_a_straight_line() {
        let patch = square(7, |x, y| 2.0 * x + y);
        for level in [0.3, 1.1, 2.0, 2.9] {
            let loops = patch.above(level);
            assert_eq!(loops.len(), 1);
            // Area of the unit square where 2x + y >= level.
            let below = match level {
                l if l <= 1.0 => l * l / 4.0,
                l if l <= 2.0 => l / 2.0 - 0.25,
                l => 1.0 - (3.0 - l).powi(2) / 4.0,
            };
            assert!((area(&loops[0]).abs() - (1.0 - below)).abs() < 1e-14, "level {level}");
        }
        assert!(patch.above(3.1).is_empty());
        assert!((area(&patch.outline()[0]).abs() - 1.0).abs() < 1e-14, "round-off of a sum of 28 terms");
    }

    #[test]
    fn holes_and_islands_are_loops_of_their_own() {
        let ring = square(40, |x, y| -((x - 0.5).hypot(y - 0.5) - 0.3).abs());
        let mut areas: Vec<f64> = ring.above(-0.1).iter().map(|corners| area(corners).abs()).collect();
        areas.sort_by(f64::total_cmp);
        // The region between radii 0.2 and 0.4; linear pieces on cells of 1/40 are off by their squared size.
        let exact = [0.2, 0.4].map(|r: f64| std::f64::consts::PI * r * r);
        assert_eq!(areas.len(), 2);
        assert!(areas.iter().zip(exact).all(|(found, exact)| (found - exact).abs() < 2.0 / 1600.0), "{areas:?}");
    }

    #[test]
    fn levels_through_nodes_and_values_that_are_no_numbers_close_too() {
        let patch = square(4, |x, y| if x == 0.5 && y == 0.5 { f64::NAN } else { (4.0 * x).max(4.0 * y) });
        let areas = |level: f64| {
            let mut areas: Vec<f64> = patch.above(level).iter().map(|corners| area(corners).abs()).collect();
            areas.sort_by(f64::total_cmp);
            areas
        };
        // The four cells around the missing value are a hole; at the level 4 the region is reduced to two sides.
        assert_eq!(areas(0.0), [0.25, 1.0]);
        assert_eq!(areas(1.0).iter().sum::<f64>(), 0.25 + 1.0 - 0.0625);
        assert_eq!(areas(4.0).iter().sum::<f64>(), 0.0);
        let loose = Patch::new(&[[0.0, 0.0], [1.0, 0.0], [f64::NAN, 1.0]], &[0.0; 3], [&[0u32, 1, 2][..]]);
        assert!(loose.outline().is_empty());
    }

    #[test]
    fn straight_sides_lose_their_middle_corners_only() {
        let outline = &square(10, |_, _| 0.0).outline()[0];
        assert_eq!(outline.len(), 40);
        let few = simplified(outline, 1e-9);
        assert_eq!((few.len(), area(&few).abs()), (4, 1.0), "corners are kept as they are");
        let circle: Vec<[f64; 2]> = (0..1000).map(|k| std::f64::consts::TAU * f64::from(k) / 1000.0).map(|a| [a.cos(), a.sin()]).collect();
        let few = simplified(&circle, 1e-3);
        // A sagitta of 1e-3 means an angle of 2 acos(1 - 1e-3) = 0.09, so about 70 corners; the halving of arcs may double that.
        assert!((70..=140).contains(&few.len()), "{}", few.len());
    }
}
