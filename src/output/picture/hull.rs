//! Bodies in space: the facets of their hull that face the viewer, distant ones first (painter's algorithm), lightly shaded. Intersecting
//! facets are not resolved. The cut faces of a section are in front of all other facets.

use std::collections::HashMap;

use super::plane::{WALL, contours_into, has_room_for_edges, undeformed_stroke};
use super::scale::{INK, Scale};
use super::skin::Skin;
use super::view::{Camera, View, dot};
use crate::output::contours::Patch;
use crate::output::drawing::{Color, Drawing, Ink, Line, Point, Stroke};
use crate::output::obstacle_surfaces::ObstacleSurface;

/// Cosine of the angle between facets from which their common edge is drawn as an edge of the body.
const SHARP: f64 = 0.8;
/// Direction of the light (to the right, up, toward the viewer) on bodies in space.
const LAMP: [f64; 3] = [-0.21, 0.4, 0.89];
/// Ambient light on bodies in space: weak enough to keep the colors readable.
const AMBIENT: f64 = 0.75;

/// A facet that faces the viewer.
struct VisibleFacet {
    body: usize,
    nodes: Vec<u32>,
    normal: [f64; 3],
    depth: f64,
    /// True for a facet of the section.
    is_cut: bool,
}

impl VisibleFacet {
    fn edges(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        self.nodes.iter().zip(self.nodes.iter().cycle().skip(1)).map(|(&a, &b)| [a, b])
    }
}

/// Normals of the facets at every edge of a body; the end nodes of an edge are in ascending order.
type EdgeNormals = HashMap<(usize, [u32; 2]), Vec<[f64; 3]>>;

/// Returns the facets that face the viewer, from far to near.
fn sides(skins: &[Skin], camera: &Camera) -> (Vec<VisibleFacet>, EdgeNormals) {
    let (mut sides, mut normals_at) = (Vec::new(), EdgeNormals::new());
    let toward = camera.view.toward;
    for (index, skin) in skins.iter().enumerate() {
        let facets = skin.facets.iter().map(|nodes| (nodes, false));
        for (nodes, is_cut) in facets.chain(skin.faces.iter().map(|nodes| (nodes, true))) {
            let corners: Vec<[f64; 3]> = nodes.iter().map(|&node| skin.points[node as usize]).collect();
            let normal = if is_cut { skin.normal } else { normal(&corners) };
            let depth = corners.iter().map(|&corner| dot(corner, toward) / corners.len() as f64).sum();
            let side = VisibleFacet { body: index, nodes: nodes.clone(), normal, depth, is_cut };
            for [a, b] in side.edges() {
                normals_at.entry((index, [a.min(b), a.max(b)])).or_default().push(normal);
            }
            if dot(normal, toward) > 0.0 {
                sides.push(side);
            }
        }
    }
    sort(&mut sides);
    (sides, normals_at)
}

/// Sorts facets from far to near.
fn sort(sides: &mut [VisibleFacet]) {
    sides.sort_by(|a, b| a.is_cut.cmp(&b.is_cut).then(a.depth.total_cmp(&b.depth)));
}

/// Returns the edges of a facet that are sharp edges of the body, or its silhouette.
fn sharp_edges(side: &VisibleFacet, normals_at: &EdgeNormals, toward: [f64; 3]) -> Vec<[u32; 2]> {
    let is_sharp = |&[a, b]: &[u32; 2]| {
        let around = &normals_at[&(side.body, [a.min(b), a.max(b)])];
        around.len() != 2 || dot(around[0], around[1]) < SHARP || around.iter().any(|&normal| dot(normal, toward) <= 0.0)
    };
    side.edges().filter(is_sharp).collect()
}

/// Returns the facets of obstacles that face the viewer; their indices follow those of `bodies` bodies. They are drawn before the bodies,
/// which are on their visible side.
fn wall_sides(surfaces: &[ObstacleSurface], bodies: usize, camera: &Camera) -> Vec<VisibleFacet> {
    let toward = camera.view.toward;
    let side = |index: usize, surface: &ObstacleSurface, facet: &Vec<u32>| {
        let corners: Vec<[f64; 3]> = facet.iter().map(|&node| surface.points[node as usize]).collect();
        let normal = normal(&corners);
        let least = corners.iter().map(|&corner| dot(corner, toward)).fold(f64::INFINITY, f64::min);
        (dot(normal, toward) > 0.0).then(|| VisibleFacet {
            body: bodies + index,
            nodes: facet.clone(),
            normal,
            depth: least,
            is_cut: false,
        })
    };
    let of = |(index, surface)| {
        let surface: &ObstacleSurface = surface;
        surface.facets.iter().filter_map(move |facet| side(index, surface, facet))
    };
    surfaces.iter().enumerate().flat_map(of).collect()
}

/// Returns the brightness of a facet, between `AMBIENT` and 1.
fn light(side: &VisibleFacet, view: &View) -> f64 {
    let lit = LAMP[0] * dot(side.normal, view.right) + LAMP[1] * dot(side.normal, view.up) + LAMP[2] * dot(side.normal, view.toward);
    AMBIENT + (1.0 - AMBIENT) * lit.clamp(0.0, 1.0)
}

/// Color of rigid obstacles and bodies under a light intensity from 0 to 1.
fn wall_color(light: f64) -> Color {
    WALL.map(|part| (f64::from(part) * light).round() as u8)
}

/// Draws bodies with a value at each node, or in one color without values, and rigid obstacles between the bodies.
pub(super) fn bodies_into(
    out: &mut Drawing,
    (skins, surfaces): (&[Skin], &[ObstacleSurface]),
    values: &[Vec<f64>],
    camera: &Camera,
    scale: &Scale,
    is_meshed: bool,
) {
    let on_skin = |(skin, values): (&Skin, &Vec<f64>)| if values.is_empty() { Vec::new() } else { skin.values(values) };
    let values: Vec<Vec<f64>> = skins.iter().zip(values).map(on_skin).collect();
    let (mut sides, normals_at) = sides(skins, camera);
    let place = |side: &VisibleFacet, node: u32| camera.place(skins[side.body].points[node as usize]);
    let edges = sides.iter().flat_map(|side| side.edges().map(|edge| edge.map(|node| place(side, node))).collect::<Vec<_>>());
    let is_coarse = has_room_for_edges(edges);
    let view = camera.view;
    sides.extend(wall_sides(surfaces, skins.len(), camera));
    sort(&mut sides);
    for side in &sides {
        let light = light(side, &view);
        if let Some(surface) = side.body.checked_sub(skins.len()).map(|index| &surfaces[index]) {
            let corners: Vec<Point> = side.nodes.iter().map(|&node| camera.place(surface.points[node as usize])).collect();
            let outline = vec![Line::closed(corners)];
            let color = wall_color(light);
            out.paint(outline.clone(), Ink::Stroke(Stroke::new(color, 0.5)));
            out.paint(outline, Ink::Fill(color));
            continue;
        }
        let points: Vec<Point> = side.nodes.iter().map(|&node| place(side, node)).collect();
        let has_field = !values[side.body].is_empty();
        let local: Vec<f64> = side.nodes.iter().filter_map(|&node| values[side.body].get(node as usize).copied()).collect();
        let outline = vec![Line::closed(points.clone())];
        let mean = || local.iter().sum::<f64>() / local.len() as f64;
        let color = if has_field { scale.color(scale.band(mean()), light) } else { wall_color(light) };
        // The stroke closes the hairlines between neighbors.
        out.paint(outline.clone(), Ink::Stroke(Stroke::new(color, 0.5)));
        if is_coarse && has_field {
            let numbers: Vec<u32> = (0..side.nodes.len() as u32).collect();
            contours_into(out, &Patch::new(&points, &local, [&numbers[..]]), &outline, scale, light);
        } else {
            out.paint(outline.clone(), Ink::Fill(color));
        }
        if is_coarse && is_meshed {
            out.paint(outline, Ink::Stroke(Stroke { opacity: 0.3, ..Stroke::new([0; 3], 0.5) }));
        }
        let sharp = sharp_edges(side, &normals_at, view.toward).into_iter().map(|edge| Line::open(edge.map(|node| place(side, node))));
        out.paint(sharp.collect(), Ink::Stroke(Stroke::new(INK, 1.1)));
    }
}

/// Draws the edges of undeformed bodies, except those that face away.
pub(super) fn undeformed_into(out: &mut Drawing, skins: &[Skin], camera: &Camera) {
    let (sides, normals_at) = sides(skins, camera);
    let edges = sides.iter().flat_map(|side| {
        let sharp = sharp_edges(side, &normals_at, camera.view.toward);
        sharp.into_iter().map(|edge| Line::open(edge.map(|node| camera.place(skins[side.body].points[node as usize])))).collect::<Vec<_>>()
    });
    out.paint(edges.collect(), Ink::Stroke(undeformed_stroke()));
}

/// Returns the nodes of facets that face the viewer.
pub(super) fn facing_nodes(skin: &Skin, camera: &Camera) -> Vec<usize> {
    let (sides, _) = sides(std::slice::from_ref(skin), camera);
    let nodes = sides.iter().flat_map(|side| side.nodes.iter().map(|&node| node as usize));
    let mut nodes: Vec<usize> = nodes.filter(|&node| node < skin.nodes).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// Returns the unit normal of a polygon in space by Newell's sums; zero for a degenerate polygon.
fn normal(corners: &[[f64; 3]]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        for (d, component) in sum.iter_mut().enumerate() {
            let (e, f) = ((d + 1) % 3, (d + 2) % 3);
            *component += (a[e] - b[e]) * (a[f] + b[f]);
        }
    }
    let length = sum[0].hypot(sum[1]).hypot(sum[2]);
    if length > 0.0 { sum.map(|x| x / length) } else { [0.0; 3] }
}
