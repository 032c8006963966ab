//! A nodal field as arrows, the longest of a fixed length, and their key.

use std::collections::HashSet;

use super::field::Vectors;
use super::hull::facing_nodes;
use super::scale::TEXT;
use super::skin::Skin;
use super::view::Camera;
use crate::dynamics::BodyFields;
use crate::output::drawing::{Anchor, Color, Drawing, Ink, Line, Point, Stroke, elided};

/// Red, which is not used for bodies.
const COLOR: Color = [214, 39, 40];
/// Length of the longest arrow relative to the extent of the bodies.
const LONGEST: f64 = 0.12;
/// Length of the longest arrow in the key, in pixels.
const KEY: f64 = 36.0;
/// Least distance between arrows, in pixels.
const APART: f64 = 18.0;
/// Shorter arrows are not drawn, in pixels.
const SHORTEST: f64 = 1.0;
/// Length of an arrow's head in pixels.
const HEAD: f64 = 8.0;
/// Largest length of an arrow's head relative to the arrow.
const HEAD_SHARE: f64 = 0.5;

/// Length of the longest vector of all bodies.
pub(super) fn longest(bodies: &[BodyFields], vectors: Vectors) -> f64 {
    let size = |[x, y, z]: [f64; 3]| x.hypot(y).hypot(z);
    let sizes = bodies.iter().flat_map(|body| (0..body.mesh.points.len()).map(move |node| size(vectors.value(body, node))));
    sizes.filter(|size| size.is_finite()).fold(0.0, f64::max)
}

/// Returns the ratio of arrow length to vector length for bodies of this extent; zero if all vectors vanish.
pub(super) fn factor(longest: f64, extent: f64) -> f64 {
    if longest > 0.0 { LONGEST * extent / longest } else { 0.0 }
}

/// Returns the end of a node's arrow away from the node.
pub(super) fn far_end(body: &BodyFields, node: usize, vectors: Vectors, factor: f64) -> [f64; 3] {
    let way = if vectors.ends_at_node() { -factor } else { factor };
    let (x, vector) = (body.position(node), vectors.value(body, node));
    [0, 1, 2].map(|d| x[d] + way * vector[d])
}

/// Draws arrows at the nodes of all bodies; in space, at visible nodes.
pub(super) fn arrows_into(out: &mut Drawing, (bodies, skins): (&[BodyFields], &[Skin]), vectors: Vectors, camera: &Camera, factor: f64) {
    let mut taken = HashSet::new();
    let (mut shafts, mut heads) = (Vec::new(), Vec::new());
    for (index, body) in bodies.iter().enumerate() {
        let nodes = skins.get(index).map_or_else(|| (0..body.mesh.points.len()).collect(), |skin| facing_nodes(skin, camera));
        for node in nodes {
            let (place, far) = (camera.place(body.position(node)), camera.place(far_end(body, node, vectors, factor)));
            let is_finite = place.iter().chain(&far).all(|x| x.is_finite());
            let is_seen = is_finite && (far[0] - place[0]).hypot(far[1] - place[1]) >= SHORTEST;
            if is_seen && taken.insert(place.map(|x| (x / APART).floor() as i64)) {
                let (start, end) = if vectors.ends_at_node() { (far, place) } else { (place, far) };
                arrow(&mut shafts, &mut heads, start, end);
            }
        }
    }
    out.paint(shafts, Ink::Stroke(Stroke::new(COLOR, 1.4)));
    out.paint_each(heads, Ink::Fill(COLOR));
}

/// Draws the longest arrow with its value, to the right of a point.
pub(super) fn key_into(out: &mut Drawing, longest: f64, vectors: Vectors, unit: &str, [x, y]: Point, width: f64) {
    let (mut shafts, mut heads) = (Vec::new(), Vec::new());
    arrow(&mut shafts, &mut heads, [x, y], [x + KEY, y]);
    out.paint(shafts, Ink::Stroke(Stroke::new(COLOR, 1.4)));
    out.paint(heads, Ink::Fill(COLOR));
    let label = format!("{} up to {} {unit}", vectors.words(), number(longest));
    out.text([x + KEY + 8.0, y + 0.35 * TEXT], elided(label.trim_end(), TEXT, width - KEY - 8.0), TEXT, Anchor::Start);
}

/// Returns a number as text with three digits.
pub(super) fn number(value: f64) -> String {
    let rounded: f64 = format!("{value:.2e}").parse().unwrap_or(value);
    if rounded == 0.0 || (0.01..1e5).contains(&rounded.abs()) { format!("{rounded}") } else { format!("{rounded:e}") }
}

fn arrow(shafts: &mut Vec<Line>, heads: &mut Vec<Line>, start: Point, end: Point) {
    let [dx, dy] = [end[0] - start[0], end[1] - start[1]];
    let length = dx.hypot(dy);
    let head = HEAD.min(HEAD_SHARE * length);
    let [along, across] = [[dx / length, dy / length], [-dy / length, dx / length]];
    let back = |way: f64| [0, 1].map(|d| end[d] - head * along[d] + way * 0.4 * head * across[d]);
    shafts.push(Line::open([start, back(0.0)]));
    heads.push(Line::closed([end, back(1.0), back(-1.0)]));
}
