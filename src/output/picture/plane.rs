//! Plane bodies: filled contours, thin cell edges if there is room for them, an outline; rigid obstacles beside them.

use std::collections::BTreeMap;

use super::scale::{INK, Scale};
use super::view::{Bounds, Camera};
use crate::dynamics::BodyFields;
use crate::elements::CellKind;
use crate::output::contours::{Patch, simplified};
use crate::output::drawing::{Drawing, Ink, Line, Point, Stroke};
use crate::output::obstacles::Wall;

/// Largest invisible deviation from a curve, in pixels.
const INVISIBLE: f64 = 0.1;
/// Average side length of cells, in pixels, below which cell edges are not drawn: they would hide the colors.
const ROOM_FOR_EDGES: f64 = 5.0;
/// Width of lines that show categories, in pixels.
const KIND: f64 = 4.5;
/// Fill color of rigid obstacles, and of rigid bodies where the field is one of deformation.
pub(super) const WALL: [u8; 3] = [176, 180, 186];

/// Draws a plane body with a value at each node, or in one color without values.
pub(super) fn body_into(out: &mut Drawing, body: &BodyFields, values: &[f64], camera: &Camera, scale: &Scale, is_meshed: bool) {
    let points: Vec<Point> = (0..body.mesh.points.len()).map(|node| camera.place(body.position(node))).collect();
    let has_field = !values.is_empty();
    let plain = vec![0.0; points.len()];
    let patch = patch_of(body, &points, if has_field { values } else { &plain });
    let outline = seen(patch.outline());
    if has_field {
        contours_into(out, &patch, &outline, scale, 1.0);
    } else {
        out.paint(outline.clone(), Ink::Fill(WALL));
    }
    if is_meshed && has_room_for_edges(patch.edges()) {
        let edges = patch.edges().map(Line::open).collect();
        out.paint(edges, Ink::Stroke(Stroke { opacity: 0.28, ..Stroke::new([0; 3], 0.5) }));
    }
    out.paint(outline, Ink::Stroke(Stroke::new(INK, 1.1)));
}

/// Draws the hull of a plane body in the colors of its nodes' categories, each up to the midpoints of the adjacent edges.
pub(super) fn kinds_into(out: &mut Drawing, body: &BodyFields, values: &[f64], camera: &Camera, scale: &Scale) {
    let mut halves: BTreeMap<usize, Vec<Line>> = BTreeMap::new();
    for ends in body.mesh.outline() {
        let [a, b] = ends.map(|node| camera.place(body.position(node as usize)));
        let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
        for (node, at) in [(ends[0], a), (ends[1], b)] {
            let kind = values[node as usize] as usize;
            if kind > 0 {
                halves.entry(kind).or_default().push(Line::open([at, middle]));
            }
        }
    }
    halves.into_iter().for_each(|(kind, lines)| out.paint(lines, Ink::Stroke(Stroke::new(scale.kind_color(kind), KIND))));
}

/// Draws the outline of an undeformed plane body.
pub(super) fn undeformed_into(out: &mut Drawing, body: &BodyFields, camera: &Camera) {
    let points: Vec<Point> = body.mesh.points.iter().map(|&point| camera.place(point)).collect();
    let patch = patch_of(body, &points, &vec![0.0; points.len()]);
    out.paint(seen(patch.outline()), Ink::Stroke(undeformed_stroke()));
}

/// Stroke of the outline of undeformed bodies.
pub(super) fn undeformed_stroke() -> Stroke {
    Stroke { dash: Some(5.0), opacity: 0.6, ..Stroke::new([0; 3], 1.0) }
}

fn patch_of(body: &BodyFields, points: &[Point], values: &[f64]) -> Patch {
    // Around the cell: the start of every edge, and its mid-side node if it has one.
    let corners = |kind: CellKind| kind.facets().iter().flat_map(|facet| facet.iter().step_by(2));
    let polygon = |(kind, cell): (CellKind, &'_ [u32])| corners(kind).map(|&corner| cell[corner]).collect();
    let polygons: Vec<Vec<u32>> = body.mesh.cells_with_kinds().map(polygon).collect();
    Patch::new(points, values, polygons.iter().map(|polygon| &polygon[..]))
}

/// Draws a rigid obstacle.
pub(super) fn wall_into(out: &mut Drawing, wall: &Wall, camera: &Camera) {
    out.begin_named(&wall.name);
    let pieces: Vec<Line> = wall.pieces().map(|piece| Line::closed(piece.map(|point| camera.pixel(point)))).collect();
    // Painted separately: pieces may overlap behind a corner. The stroke closes the hairlines between neighbors.
    for piece in pieces {
        out.paint(vec![piece.clone()], Ink::Fill(WALL));
        out.paint(vec![piece], Ink::Stroke(Stroke::new(WALL, 0.6)));
    }
    let border: Vec<Point> = wall.border.iter().map(|&point| camera.pixel(point)).collect();
    out.paint(vec![Line { points: border, is_closed: wall.is_closed }], Ink::Stroke(Stroke::new(INK, 1.6)));
    out.end();
}

/// True if cell edges are long enough on average that colors remain visible between them.
pub(super) fn has_room_for_edges(edges: impl Iterator<Item = [Point; 2]>) -> bool {
    let (count, length) = edges.fold((0, 0.0), |(count, length), [a, b]| (count + 1, length + (a[0] - b[0]).hypot(a[1] - b[1])));
    length >= ROOM_FOR_EDGES * f64::from(count)
}

/// Draws filled contours: the patch in the color of its lowest band, then the region above each further level; plain for categories.
pub(super) fn contours_into(out: &mut Drawing, patch: &Patch, outline: &[Line], scale: &Scale, light: f64) {
    if scale.has_kinds() {
        return out.paint(outline.to_vec(), Ink::Fill(scale.color(0, light)));
    }
    let lowest = scale.band(patch.range()[0]);
    out.paint(outline.to_vec(), Ink::Fill(scale.color(lowest, light)));
    for band in lowest + 1..=scale.band(patch.range()[1]) {
        out.paint(seen(patch.above(scale.level(band))), Ink::Fill(scale.color(band, light)));
    }
}

/// Returns closed lines from loops; parts too small to be visible are left out.
fn seen(loops: Vec<Vec<Point>>) -> Vec<Line> {
    let simple = loops.into_iter().map(|corners| simplified(&corners, INVISIBLE));
    let is_seen = |corners: &Vec<Point>| {
        let size = Bounds::of(corners.iter()).size;
        corners.len() > 2 && size[0].max(size[1]) > 4.0 * INVISIBLE
    };
    simple.filter(is_seen).map(Line::closed).collect()
}
