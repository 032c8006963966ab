//! Strips of thin cells along boundaries of a region, and the remaining region.
//!
//! From every vertex of a layered stretch of the rim a straight *column* goes into the body, with a node at each level; two consecutive
//! columns bound a stack of cells. Along a stretch columns are normal to it. At a corner between two layered curves there is one column on
//! the bisector; the columns beside it are inclined gradually, so that columns do not cross. If the following curve has no layers, the last
//! column runs along it or, if the outline continues nearly straight, ends within the body. The inner ends of the columns, the *front*, are
//! part of the rim of the remaining region.

use std::f64::consts::PI;

use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

use super::MeshError;
use super::layers::Layers;
use super::plane::cross;
use super::strips::{CurveSegment, Layered, Node, Strip};
use super::triangulation::Rim;

type Point = [f64; 2];

/// Turning angle between two curves above which their common point is a corner `[rad]`; columns beside a corner lean.
const CORNER: f64 = 20.0 * PI / 180.0;
/// Largest turning angle at a corner with a single column `[rad]`.
const SHARPEST: f64 = 150.0 * PI / 180.0;
/// Turning angle towards a curve without layers above which the last column runs along that curve `[rad]`.
const FLUSH: f64 = 40.0 * PI / 180.0;
/// Distance over which leaning columns become normal again, as a multiple of the shift of the column.
const SPREAD: f64 = 3.0;
/// Ratio of front length to base length of a stack below which columns are too close.
const NARROW: f64 = 0.1;
/// Remaining share of a cut rim segment below which the rest is added to the neighboring segment.
const REST: f64 = 0.4;

/// Reason why there are no valid columns.
enum Trouble {
    /// Columns or fronts meet each other or the rim.
    Collision(Point),
    /// Another error.
    Refused(MeshError),
}

impl From<MeshError> for Trouble {
    fn from(error: MeshError) -> Self {
        Trouble::Refused(error)
    }
}

/// Layers along all segments of the rim that belong to a layered boundary. Each rim segment carries one stack of cells, or two if `halves`
/// is 2.
///
/// # Errors
/// Layers that leave no room, corners that are too sharp, an odd number of layers that end within the body of quadrilaterals.
pub(super) fn layered(rim: &Rim, layers: &Layers, halves: usize) -> Result<Layered, MeshError> {
    let levels = layers.levels();
    let scaled = |share: f64| levels.iter().map(|level| share * level).collect::<Vec<f64>>();
    match LayerBuilder::of(rim, layers, scaled(1.0), halves) {
        Ok(layered) => Ok(layered),
        Err(Trouble::Refused(error)) => Err(error),
        Err(Trouble::Collision(near)) => {
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..12 {
                let middle = 0.5 * (low + high);
                if LayerBuilder::of(rim, layers, scaled(middle), halves).is_ok() { low = middle } else { high = middle }
            }
            let thickness = layers.thickness();
            Err(MeshError::LayersCollide { names: layers.quoted(), thickness, room: low * thickness, near })
        }
    }
}

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn unit(a: Point) -> Point {
    let length = a[0].hypot(a[1]);
    [a[0] / length, a[1] / length]
}

/// Direction rotated by a right angle to the left.
fn left([x, y]: Point) -> Point {
    [-y, x]
}

/// Signed angle from one direction to another `[rad]`, positive counter-clockwise.
fn turn(from: Point, to: Point) -> f64 {
    cross(from, to).atan2(dot(from, to))
}

/// Construction of layers along the rim.
struct LayerBuilder<'a> {
    rim: &'a Rim,
    names: String,
    levels: Vec<f64>,
    halves: usize,
}

/// End of a strip: the points of its last column and, if the column runs along a curve, that curve with the parameters of the points.
struct End {
    column: Vec<Point>,
    along: Option<(usize, Vec<f64>)>,
}

impl LayerBuilder<'_> {
    fn of(rim: &Rim, layers: &Layers, levels: Vec<f64>, halves: usize) -> Result<Layered, Trouble> {
        let is_layered = |piece: usize| rim.names(piece).iter().any(|name| layers.boundaries.contains(name));
        let growth = LayerBuilder { rim, names: layers.quoted(), levels, halves };
        let mut layered =
            Layered { rest: Rim::of_curves(rim, format!("the layers of {}", growth.names)), strips: Vec::new(), order: Vec::new() };
        for range in rim.loops.windows(2) {
            let pieces: Vec<usize> = (range[0]..range[1]).collect();
            growth.round(&pieces, &is_layered, &mut layered)?;
        }
        growth.apart(&layered)?;
        Ok(layered)
    }

    /// Adds the strips of one loop, and its part of the rim of the remaining region.
    fn round(&self, pieces: &[usize], is_layered: &impl Fn(usize) -> bool, layered: &mut Layered) -> Result<(), Trouble> {
        let first = layered.rest.vertices.len();
        let begins = |k: usize| is_layered(pieces[k]) && !is_layered(pieces[(k + pieces.len() - 1) % pieces.len()]);
        let Some(start) = (0..pieces.len()).find(|&k| begins(k)) else {
            if is_layered(pieces[0]) {
                let strip = self.closed(pieces)?;
                layered.add_strip(strip, self.halves);
            } else {
                pieces.iter().for_each(|&piece| layered.add_piece(self.rim.pieces[piece]));
            }
            layered.rest.end_loop(first);
            return Ok(());
        };
        let turned: Vec<usize> = (0..pieces.len()).map(|k| pieces[(start + k) % pieces.len()]).collect();
        // Stretches with layers and the gaps that follow them, alternately.
        let stretches: Vec<&[usize]> = turned.chunk_by(|a, b| is_layered(*a) == is_layered(*b)).collect();
        let mut gaps: Vec<Vec<CurveSegment>> =
            stretches.chunks(2).map(|pair| pair[1].iter().map(|&piece| self.rim.pieces[piece]).collect()).collect();
        let mut strips = Vec::new();
        for (number, pair) in stretches.chunks(2).enumerate() {
            let base = self.base(pair[0]);
            let before = (number + gaps.len() - 1) % gaps.len();
            let last = base.len() - 1;
            let start = self.end(&mut gaps[before], base[0], minus(base[1], base[0]), |point| point)?;
            // When traversed backwards the body is on the right; a reflection in the x axis moves it to the left.
            let mut behind: Vec<CurveSegment> = gaps[number].iter().rev().map(|&(curve, [from, to])| (curve, [to, from])).collect();
            let end = self.end(&mut behind, base[last], minus(base[last - 1], base[last]), |[x, y]| [x, -y])?;
            gaps[number] = behind.into_iter().rev().map(|(curve, [from, to])| (curve, [to, from])).collect();
            strips.push(self.open(pair[0], &base, start, end)?);
        }
        for (strip, gap) in strips.into_iter().zip(gaps) {
            layered.add_strip(strip, self.halves);
            gap.into_iter().for_each(|piece| layered.add_piece(piece));
        }
        layered.rest.end_loop(first);
        Ok(())
    }

    /// Foot points of the columns on consecutive rim segments, including the end point of the last segment.
    fn base(&self, pieces: &[usize]) -> Vec<Point> {
        let rim = self.rim;
        let mut base = Vec::new();
        for &piece in pieces {
            let [from, to] = [piece, rim.next[piece]].map(|vertex| rim.vertices[vertex]);
            base.push(from);
            if self.halves == 2 {
                base.push(rim.between(piece, 0.5).unwrap_or([0, 1].map(|i| 0.5 * (from[i] + to[i]))));
            }
        }
        base.extend(pieces.last().map(|&piece| rim.vertices[rim.next[piece]]));
        base
    }

    /// Curve segments below the stacks of cells, one per stack.
    fn stands(&self, pieces: &[usize]) -> Vec<CurveSegment> {
        let halves = self.halves as f64;
        let part = |piece: &usize| {
            let (curve, [from, to]) = self.rim.pieces[*piece];
            (0..self.halves).map(move |k| {
                let at = |k: usize| from + (to - from) * k as f64 / halves;
                (curve, [at(k), at(k + 1)])
            })
        };
        pieces.iter().flat_map(part).collect()
    }

    /// Column at the start of a strip with the foot point `foot` and a direction, and the preceding gap, whose pieces are shortened if the
    /// column runs along them. All points are transformed by `seen`, so that the body is on the left.
    fn end(&self, gap: &mut Vec<CurveSegment>, foot: Point, ahead: Point, seen: impl Fn(Point) -> Point) -> Result<End, Trouble> {
        let Some(&(curve, [from, to])) = gap.last() else { return Err(Trouble::Collision(foot)) };
        let near = self.rim.curves[curve].at(to + (from - to) / 64.0);
        let [here, along] = [seen(foot), unit(seen(ahead))];
        let turned = turn(minus(here, seen(near)), along);
        let normal = left(along);
        if turned.abs() > SHARPEST {
            return Err(self.sharp(turned, foot).into());
        }
        if turned < FLUSH {
            if self.halves == 2 && self.levels.len().is_multiple_of(2) {
                return Err(MeshError::OddLayers { names: self.names.clone(), count: self.levels.len() - 1, near: foot }.into());
            }
            let column = self.levels.iter().map(|level| seen([0, 1].map(|i| here[i] + level * normal[i])));
            return Ok(End { column: column.collect(), along: None });
        }
        // Follow the curve backwards from the end of the gap, as far as the curve extends there.
        let own = gap.iter().rev().take_while(|piece| piece.0 == curve);
        let far = own.map(|piece| piece.1[0]).last().unwrap_or(from);
        let height = |t: f64| dot(normal, minus(seen(self.rim.curves[curve].at(t)), here));
        let samples = 64 * gap.len();
        let place = |sample: usize| to + (far - to) * sample as f64 / samples as f64;
        let mut places = vec![to];
        for level in &self.levels[1..] {
            let Some(above) = (1..=samples).find(|&sample| height(place(sample)) >= *level) else { return Err(Trouble::Collision(near)) };
            let (mut low, mut high) = (place(above - 1), place(above));
            for _ in 0..64 {
                let middle = 0.5 * (low + high);
                if height(middle) < *level { low = middle } else { high = middle }
            }
            places.push(high);
        }
        shorten(gap, places[places.len() - 1]).ok_or(Trouble::Collision(near))?;
        let column = places.iter().map(|&t| self.rim.curves[curve].at(t)).collect();
        Ok(End { column, along: Some((curve, places)) })
    }

    fn sharp(&self, turned: f64, near: Point) -> MeshError {
        MeshError::LayerCorner { names: self.names.clone(), degrees: 180.0 - turned.to_degrees(), near }
    }

    fn closed(&self, pieces: &[usize]) -> Result<Strip, Trouble> {
        let count = pieces.len();
        // The strip of a closed loop begins at a corner if there is one, so that no stretch between corners is divided.
        let is_corner = |k: usize| {
            let before = pieces[(k + count - 1) % count];
            self.rim.pieces[before].0 != self.rim.pieces[pieces[k]].0 && {
                let chord = |piece: usize| minus(self.rim.vertices[self.rim.next[piece]], self.rim.vertices[piece]);
                turn(chord(before), chord(pieces[k])).abs() > CORNER
            }
        };
        let first = (0..count).find(|&k| is_corner(k)).unwrap_or(0);
        let turned: Vec<usize> = (0..count).map(|k| pieces[(first + k) % count]).collect();
        let base = self.base(&turned);
        let columns = self.columns(&base, &self.stands(&turned), None)?;
        Ok(self.strip(columns, &turned, [None, None], true))
    }

    fn open(&self, pieces: &[usize], base: &[Point], start: End, end: End) -> Result<Strip, Trouble> {
        let columns = self.columns(base, &self.stands(pieces), Some([start.column, end.column]))?;
        Ok(self.strip(columns, pieces, [start.along, end.along], false))
    }

    fn strip(&self, columns: Vec<Vec<Point>>, pieces: &[usize], along: [Option<(usize, Vec<f64>)>; 2], is_closed: bool) -> Strip {
        let nodes = vec![vec![Node::Own; self.levels.len()]; columns.len()];
        Strip { columns, nodes, pieces: self.stands(pieces), along, is_closed }
    }

    /// Columns on a stretch of the rim with given end columns; without end columns the stretch is a closed loop.
    fn columns(&self, base: &[Point], stands: &[CurveSegment], ends: Option<[Vec<Point>; 2]>) -> Result<Vec<Vec<Point>>, Trouble> {
        let (count, thickness) = (base.len() - 1, self.levels[self.levels.len() - 1]);
        let ahead: Vec<Point> = base.windows(2).map(|pair| unit(minus(pair[1], pair[0]))).collect();
        let length = |k: usize| dot(minus(base[k + 1], base[k]), ahead[k]);
        let is_end = |column: usize| ends.is_some() && (column == 0 || column == count);
        let before = |column: usize| (column + count - 1) % count;
        let turned = |column: usize| if is_end(column) { 0.0 } else { turn(ahead[before(column)], ahead[column % count]) };
        let is_corner = |column: usize| stands[before(column)].0 != stands[column % count].0 && turned(column).abs() > CORNER;
        // Inclinations of the columns at both ends of each stretch between corners, relative to the thickness; positive if the stretch
        // becomes shorter inwards.
        let breaks: Vec<usize> = (0..=count).filter(|&column| column == 0 || column == count || is_corner(column)).collect();
        let mut leaning = vec![0.0; count + 1];
        for pair in breaks.windows(2) {
            let shift = |column: usize, is_last: bool| match (&ends, is_end(column), is_corner(column)) {
                (Some(ends), true, _) => {
                    let to = minus(ends[usize::from(is_last)][self.levels.len() - 1], base[column]);
                    let along = dot(to, ahead[if is_last { count - 1 } else { 0 }]) / thickness;
                    if is_last { -along } else { along }
                }
                (_, _, true) => (0.5 * turned(column)).tan(),
                _ => 0.0,
            };
            let shifts = [shift(pair[0], false), shift(pair[1], true)];
            let whole: f64 = (pair[0]..pair[1]).map(length).sum();
            let is_short = SPREAD * thickness * (shifts[0].abs() + shifts[1].abs()) > whole;
            let reach = shifts.map(|shift| if is_short { whole } else { SPREAD * thickness * shift.abs() });
            let mut passed = 0.0;
            for column in pair[0] + 1..pair[1] {
                passed += length(column - 1);
                let share = |passed: f64, reach: f64| if passed < reach { 1.0 - passed / reach } else { 0.0 };
                leaning[column] = shifts[0] * share(passed, reach[0]) - shifts[1] * share(whole - passed, reach[1]);
            }
        }
        let mut columns = Vec::with_capacity(count + 1);
        for column in 0..=count {
            if let (Some(ends), true) = (&ends, is_end(column)) {
                columns.push(ends[usize::from(column > 0)].clone());
                continue;
            }
            if turned(column).abs() > SHARPEST {
                return Err(self.sharp(turned(column), base[column]).into());
            }
            let [one, other] = [before(column), column % count].map(|k| left(ahead[k]));
            let scale = 1.0 / (1.0 + dot(one, other));
            let along = unit([0, 1].map(|i| ahead[before(column)][i] + ahead[column % count][i]));
            let direction = [0, 1].map(|i| scale * (one[i] + other[i]) + leaning[column] * along[i]);
            columns.push(self.levels.iter().map(|level| [0, 1].map(|i| base[column][i] + level * direction[i])).collect());
        }
        for k in 0..count {
            let front = [k, k + 1].map(|column| columns[column][self.levels.len() - 1]);
            if dot(minus(front[1], front[0]), ahead[k]) < NARROW * length(k) {
                return Err(Trouble::Collision(base[k]));
            }
        }
        Ok(columns)
    }

    /// Checks that columns and fronts cross neither one another nor the rim.
    fn apart(&self, layered: &Layered) -> Result<(), Trouble> {
        let (mut lines, front) = (Lines::default(), layered.rest.front());
        for strip in &layered.strips {
            let top = self.levels.len() - 1;
            for pair in strip.columns.windows(2) {
                lines.add(pair[0][0], pair[1][0])?;
                lines.add(pair[0][0], pair[0][top])?;
                lines.add(pair[0][top], pair[1][top])?;
            }
            if let (Some(last), false) = (strip.columns.last(), strip.is_closed) {
                lines.add(last[0], last[top])?;
            }
        }
        for (vertex, &next) in layered.rest.next.iter().enumerate().filter(|(vertex, _)| layered.rest.pieces[*vertex].0 != front) {
            lines.add(layered.rest.vertices[vertex], layered.rest.vertices[next])?;
        }
        Ok(())
    }
}

/// Line segments that may meet only at their ends.
#[derive(Default)]
struct Lines(ConstrainedDelaunayTriangulation<Point2<f64>>);

impl Lines {
    fn add(&mut self, from: Point, to: Point) -> Result<(), Trouble> {
        let [a, b] = [from, to].map(|[x, y]| self.0.insert(Point2::new(x, y)));
        let (Ok(a), Ok(b)) = (a, b) else { return Err(MeshError::NoTriangulation.into()) };
        if a == b || !self.0.can_add_constraint(a, b) {
            return Err(Trouble::Collision(from));
        }
        self.0.add_constraint(a, b);
        Ok(())
    }
}

/// Cuts the end of a gap at a parameter of its last curve; a short remaining part of a segment is added to the neighboring segment. Returns
/// `None` if nothing of the gap remains.
fn shorten(gap: &mut Vec<CurveSegment>, at: f64) -> Option<()> {
    loop {
        let &(curve, [from, to]) = gap.last()?;
        let left = (at - from) / (to - from);
        let has_neighbor = gap.len() > 1 && gap[gap.len() - 2].0 == curve;
        if left > REST || left > 0.0 && !has_neighbor {
            gap.last_mut()?.1[1] = at;
            return Some(());
        }
        gap.pop();
        if left > 0.0 {
            gap.last_mut()?.1[1] = at;
            return Some(());
        }
        if !has_neighbor {
            return None;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use proptest::prelude::*;

    use super::*;
    use crate::elements::CellKind;
    use crate::mesh::{CellSize, Curve, Facet, Mesh, OutlineSide, layered_polygon, layered_region};

    const KINDS: [CellKind; 5] = [CellKind::Tri3, CellKind::Quad4, CellKind::Tri6, CellKind::Quad8, CellKind::Quad9];

    fn layers(names: &[&str], first: f64, count: usize, growth: f64) -> Layers {
        Layers { boundaries: names.iter().map(|name| name.to_string()).collect(), first, count, growth, along: None }
    }

    /// Asserts that a mesh is valid, that the loops name its hull exactly once, and that its area is that enclosed by the facets.
    fn is_whole(mesh: &Mesh) {
        assert_eq!(mesh.defects(), []);
        let mut named: Vec<Facet> = Vec::new();
        let loops = mesh.boundaries.iter().filter(|b| b.name == "outer" || b.name.starts_with("hole "));
        loops.for_each(|b| named.extend(&b.facets));
        for boundary in mesh.boundaries.iter().filter(|b| b.name == "outer") {
            let ends: Vec<Vec<u32>> = boundary.facets.iter().map(|&facet| mesh.facet_nodes(facet).collect()).collect();
            assert!(ends.windows(2).all(|pair| pair[0][1] == pair[1][0]), "traversed with the body on the left");
        }
        // Gauss' theorem: the area is half the integral of x dy - y dx. A parabola through the points a, c, b contributes chord products as
        // in Simpson's rule with weights 1, 4, 1.
        let bounded: f64 = named
            .iter()
            .map(|&facet| {
                let points: Vec<Point> = mesh.facet_nodes(facet).map(|n| mesh.points[n as usize]).map(|[x, y, _]| [x, y]).collect();
                let chord = 0.5 * cross(points[0], points[1]);
                let bulge = points.get(2).map_or(0.0, |&m| 2.0 / 3.0 * cross(minus(m, points[0]), minus(points[1], points[0])));
                chord + bulge
            })
            .sum();
        assert!((mesh.measure() - bounded).abs() < 1e-12 * bounded, "{} {bounded}", mesh.measure());
        named.sort_unstable();
        assert_eq!(mesh.hull(), named);
    }

    fn circle(radius: f64, name: &str) -> Vec<OutlineSide> {
        vec![OutlineSide { curve: Curve::circle([0.0, 0.0], radius).unwrap(), name: Some(name.into()) }]
    }

    /// Distances of all nodes from the origin, each distance once.
    fn radii(mesh: &Mesh) -> Vec<f64> {
        let mut radii: Vec<f64> = mesh.points.iter().map(|p| p[0].hypot(p[1])).collect();
        radii.sort_by(f64::total_cmp);
        radii
    }

    #[test]
    fn layers_of_a_hole_and_of_an_outline_have_their_thicknesses() {
        for kind in KINDS {
            let layers = Layers { along: Some(0.1), ..layers(&["bore", "rim"], 0.002, 4, 1.5) };
            let size = CellSize::<MeshError>::Even(0.2);
            let mesh = layered_region(&circle(1.0, "rim"), &[circle(0.4, "bore")], size, kind, Some(&layers)).unwrap();
            is_whole(&mesh);
            // corners of the first levels lie on circles at the distance of the layer, up to the cosine of half a chord
            for level in [0.002, 0.005, 0.0095] {
                for radius in [0.4 + level, 1.0 - level] {
                    let near = radii(&mesh).iter().filter(|r| (*r - radius).abs() < 0.03 * level).count();
                    assert!(near >= 24, "{kind:?} {radius}: {near}");
                }
            }
            let facets = |name: &str| mesh.boundary(name).unwrap().facets.len();
            assert!(facets("rim") >= 62 && facets("bore") >= 25, "{kind:?} {} {}", facets("rim"), facets("bore"));
        }
    }

    #[test]
    fn layers_end_at_sides_and_within_the_body() {
        let square = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let names: Vec<String> = ["floor", "wall", "step", "riser", "roof", "back"].map(String::from).to_vec();
        for kind in KINDS {
            for wanted in [&["floor"][..], &["step", "riser"], &["floor", "wall", "step", "riser", "roof", "back"], &["outer"], &["step"]] {
                let layers = layers(wanted, 0.01, 4, 1.3);
                let mesh = layered_polygon(kind, &square, &[], 0.1, &names, Some(&layers));
                let mesh = mesh.unwrap_or_else(|error| panic!("{kind:?} {wanted:?} {error}"));
                is_whole(&mesh);
                assert!((mesh.measure() - 3.0).abs() < 1e-12);
                for (name, length) in names.iter().zip([2.0, 1.0, 1.0, 1.0, 1.0, 2.0]) {
                    assert!((mesh.boundary_measure(mesh.boundary(name).unwrap()) - length).abs() < 1e-12, "{kind:?} {name}");
                }
            }
        }
        // Three layers end within the body: an odd number, which quadrilaterals do not allow.
        let odd = |kind| layered_polygon(kind, &square, &[], 0.1, &names, Some(&layers(&["step"], 0.01, 3, 1.3)));
        assert!(matches!(odd(CellKind::Quad4), Err(MeshError::OddLayers { count: 3, .. })));
        is_whole(&odd(CellKind::Tri6).unwrap());
    }

    #[test]
    fn layers_without_room_are_refused_with_the_room_there_is() {
        let strip = [[0.0, 0.0], [2.0, 0.0], [2.0, 0.4], [0.0, 0.4]];
        let names: Vec<String> = ["floor", "right", "roof", "left"].map(String::from).to_vec();
        let refusal = |wanted: &[&str], first| {
            let layers = layers(wanted, first, 2, 1.0);
            layered_polygon(CellKind::Quad4, &strip, &[], 0.1, &names, Some(&layers)).unwrap_err()
        };
        let MeshError::LayersCollide { room, thickness, .. } = refusal(&["floor", "roof"], 0.15) else { panic!() };
        assert!((room - 0.2).abs() < 0.01 && (thickness - 0.3).abs() < 1e-12, "{room}");
        let MeshError::LayersCollide { room, .. } = refusal(&["floor"], 0.25) else { panic!() };
        assert!((room - 0.4).abs() < 0.01, "{room}");
        let ring = |radius: f64| {
            let layers = layers(&["rim"], 0.15, 2, 1.0);
            let size = CellSize::<MeshError>::Even(0.1);
            layered_region(&circle(1.0, "rim"), &[circle(radius, "bore")], size, CellKind::Tri3, Some(&layers))
        };
        is_whole(&ring(0.6).unwrap());
        let Err(MeshError::LayersCollide { room, .. }) = ring(0.9) else { panic!() };
        assert!((room - 0.1).abs() < 0.01, "{room}");
        let unknown = refusal(&["flor"], 0.01);
        assert_eq!(unknown.hint(), "did you mean \"floor\"?");
        let needle = [[0.0, 0.0], [2.0, 0.0], [2.0, 0.4]];
        let layers = layers(&["outer"], 0.01, 2, 1.0);
        let sharp = layered_polygon(CellKind::Quad4, &needle, &[], 0.1, &names[..3], Some(&layers)).unwrap_err();
        assert!(matches!(sharp, MeshError::LayerCorner { degrees, .. } if (degrees - 11.3).abs() < 0.1), "{sharp}");
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 120, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn random_regions_have_whole_layers_or_say_why_not(
            radii in prop::collection::vec(0.6f64..1.4, 4..9),
            hole in 0.1f64..0.35,
            first in 0.002f64..0.06,
            count in 1usize..6,
            growth in 0.8f64..1.6,
            kind in 0usize..5,
            choice in 0usize..6,
            along in prop::option::of(0.03f64..0.2),
        ) {
            let corners = radii.len();
            let at = |k: usize| {
                let (sine, cosine) = (TAU * (k % corners) as f64 / corners as f64).sin_cos();
                [radii[k % corners] * cosine, radii[k % corners] * sine]
            };
            // Outline of straight sides with an arc as every third side.
            let outline: Vec<OutlineSide> = (0..corners).map(|k| {
                let (from, to) = (at(k), at(k + 1));
                let out = [0, 1].map(|i| 0.55 * (from[i] + to[i]));
                let curve = if k % 3 == 1 { Curve::arc_through(from, out, to) } else { Curve::line(from, to) };
                OutlineSide { curve: curve.unwrap(), name: Some(format!("side {}", k + 1)) }
            }).collect();
            let choices = [&["outer"][..], &["bore"], &["side 1"],
                &["side 2", "side 3"], &["side 1", "side 3", "hole 1"], &["outer", "bore"]];
            let names = choices[choice];
            let layers = Layers { along, ..layers(names, first, count, growth) };
            let size = CellSize::<MeshError>::Even(0.15);
            match layered_region(&outline, &[circle(hole, "bore")], size, KINDS[kind], Some(&layers)) {
                Ok(mesh) => is_whole(&mesh),
                Err(MeshError::LayersCollide { room, thickness, .. }) => prop_assert!(room < thickness),
                Err(MeshError::LayerCorner { .. } | MeshError::OddLayers { .. } | MeshError::LayersCramped { .. }) => {}
                Err(error) => prop_assert!(false, "{error}"),
            }
        }
    }
}
