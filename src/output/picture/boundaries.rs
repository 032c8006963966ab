//! A mesh with its boundaries in colors and their names: the content of a mesh file.
//!
//! In space, the mesh is shown from two opposite corners, far facets first (painter's algorithm). Facets of several boundaries have the
//! color of the smallest one; nodes of boundaries without facets are dots.

use std::collections::HashMap;

use super::marks::{TRIAD_ROOM, bar_into, triad_into};
use super::scale::{INK, TEXT};
use super::view::{Bounds, Camera, View, dot};
use crate::mesh::{Boundary, Facet, Mesh};
use crate::output::drawing::{Anchor, Color, Drawing, Ink, Line, Point, Stroke, elided};

/// Margin, width of a panel and of the list of names, height of a panel, in pixels.
const MARGIN: f64 = 14.0;
const PANEL: f64 = 420.0;
const LIST: f64 = 230.0;
/// Height of a line of the list in pixels.
const ROW: f64 = 20.0;
/// Largest number of listed boundaries.
const LISTED: usize = 40;

/// Colors of boundaries in turn (Okabe and Ito, 2008, and darker shades of these), and of facets without a boundary.
const COLORS: [Color; 12] = [
    [230, 159, 0],
    [86, 180, 233],
    [0, 158, 115],
    [213, 94, 0],
    [0, 114, 178],
    [204, 121, 167],
    [240, 228, 66],
    [138, 95, 0],
    [0, 95, 69],
    [128, 56, 0],
    [122, 73, 100],
    [100, 100, 200],
];
const PLAIN: Color = [222, 222, 222];

fn color(index: usize) -> Color {
    COLORS[index % COLORS.len()]
}

/// Draws a mesh with its boundaries.
pub fn picture_of_boundaries(mesh: &Mesh, title: &str) -> Drawing {
    let views: Vec<View> = if mesh.dimension() == 2 {
        vec![View::PLANE]
    } else {
        [[1.0, -1.0, 0.8], [-1.0, 1.0, -0.8]].into_iter().filter_map(|direction| View::from_direction(direction, 2)).collect()
    };
    let flat = |view: &View| mesh.points.iter().map(|&point| view.flat(point)).collect::<Vec<Point>>();
    let bounds: Vec<Bounds> = views.iter().map(|view| Bounds::of(flat(view).iter())).collect();
    let most = |d: usize| bounds.iter().map(|bounds| bounds.size[d]).fold(0.0, f64::max);
    let zoom = (PANEL / most(0)).min(PANEL / most(1));
    let height = most(1) * zoom;
    let listed = mesh.boundaries.len().min(LISTED + 1);
    let top = 2.5 * MARGIN + TEXT;
    let footer = if mesh.dimension() == 3 { 2.0 * TRIAD_ROOM } else { 2.0 * TEXT };
    let width = MARGIN + (PANEL + MARGIN) * views.len() as f64 + LIST;
    let mut out = Drawing::new([width, (top + height + footer + 2.0 * MARGIN).max(top + ROW * listed as f64 + MARGIN).ceil()]);
    out.text([MARGIN, MARGIN + TEXT], elided(title, TEXT, width - 2.0 * MARGIN), TEXT, Anchor::Start);
    for (index, (view, bounds)) in views.iter().zip(&bounds).enumerate() {
        let left = MARGIN + index as f64 * (PANEL + MARGIN);
        let corner = [left + 0.5 * (PANEL - bounds.size[0] * zoom), top + 0.5 * (height + bounds.size[1] * zoom)];
        let camera = Camera { view: *view, bounds: *bounds, corner, zoom };
        facets_into(&mut out, mesh, &camera);
        nodes_into(&mut out, mesh, &camera);
        let bottom = top + height + footer;
        if mesh.dimension() == 3 {
            triad_into(&mut out, [left + TRIAD_ROOM, bottom - TRIAD_ROOM + MARGIN], view);
        }
        if index == 0 {
            bar_into(&mut out, [left + if mesh.dimension() == 3 { 2.5 * TRIAD_ROOM } else { 0.0 }, bottom], zoom, PANEL, "");
        }
    }
    list_into(&mut out, mesh, [width - LIST, top]);
    out
}

/// Draws the cells in the plane, or facets of the hull that face the viewer in space, and over these the boundaries.
fn facets_into(out: &mut Drawing, mesh: &Mesh, camera: &Camera) {
    let place = |nodes: &[u32]| nodes.iter().map(|&node| camera.place(mesh.points[node as usize])).collect::<Vec<Point>>();
    let thin = Ink::Stroke(Stroke { opacity: 0.35, ..Stroke::new(INK, 0.5) });
    // from the largest to the smallest boundary
    let mut order: Vec<usize> = (0..mesh.boundaries.len()).collect();
    order.sort_by_key(|&index| std::cmp::Reverse(mesh.boundaries[index].facets.len()));
    let mut owners: HashMap<Facet, usize> = HashMap::new();
    for &index in &order {
        owners.extend(mesh.boundaries[index].facets.iter().map(|&facet| (facet, index)));
    }
    if mesh.dimension() == 2 {
        for (kind, cell) in mesh.cells_with_kinds() {
            let outline = Line::closed(place(&cell[..kind.shape().corners()]));
            out.paint(vec![outline.clone()], Ink::Fill(PLAIN));
            out.paint(vec![outline], thin);
        }
        for (index, boundary) in order.into_iter().map(|index| (index, &mesh.boundaries[index])) {
            out.begin_named(&boundary.name);
            let pieces = boundary.facets.iter().flat_map(|&facet| mesh.straight_pieces(facet));
            out.paint(pieces.map(|ends| Line::open(place(&ends))).collect(), Ink::Stroke(Stroke::new(color(index), 4.0)));
            out.end();
        }
        return;
    }
    let toward = camera.view.toward;
    let mut seen: Vec<(f64, Facet)> = mesh
        .hull()
        .into_iter()
        .filter(|&facet| dot(mesh.facet_normal(facet), toward) > 0.0)
        .map(|facet| {
            let nodes = mesh.around(facet);
            (nodes.iter().map(|&node| dot(mesh.points[node as usize], toward)).sum::<f64>() / nodes.len() as f64, facet)
        })
        .collect();
    seen.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (_, facet) in seen {
        let outline = Line::closed(place(&mesh.around(facet)));
        let light = 0.7 + 0.3 * dot(mesh.facet_normal(facet), toward);
        let shade = owners.get(&facet).map_or(PLAIN, |&index| color(index)).map(|part| (f64::from(part) * light) as u8);
        out.paint(vec![outline.clone()], Ink::Fill(shade));
        out.paint(vec![outline], thin);
    }
}

/// Draws dots for nodes of boundaries without facets.
fn nodes_into(out: &mut Drawing, mesh: &Mesh, camera: &Camera) {
    for (index, boundary) in mesh.boundaries.iter().enumerate().filter(|(_, boundary)| boundary.facets.is_empty()) {
        out.begin_named(&boundary.name);
        for &node in &boundary.nodes {
            let [x, y] = camera.place(mesh.points[node as usize]);
            out.filled_box([x - 3.0, y - 3.0], [x + 3.0, y + 3.0], color(index));
        }
        out.end();
    }
}

/// Draws the names of boundaries beside their colors.
fn list_into(out: &mut Drawing, mesh: &Mesh, [x, top]: Point) {
    let words = |boundary: &Boundary| match (boundary.facets.len(), boundary.nodes.len()) {
        (0, nodes) => format!("{} ({nodes} nodes)", boundary.name),
        (facets, 0) => format!("{} ({facets})", boundary.name),
        (facets, nodes) => format!("{} ({facets}, {nodes} nodes)", boundary.name),
    };
    for (index, boundary) in mesh.boundaries.iter().take(LISTED).enumerate() {
        let y = top + ROW * index as f64;
        out.filled_box([x, y], [x + 14.0, y + 14.0], color(index));
        out.text([x + 22.0, y + 12.0], elided(&words(boundary), TEXT, LIST - 22.0 - MARGIN), TEXT, Anchor::Start);
    }
    let y = top + ROW * mesh.boundaries.len().min(LISTED) as f64 + 12.0;
    match mesh.boundaries.len() {
        0 => out.text([x, y], "no boundaries", TEXT, Anchor::Start),
        all if all > LISTED => out.text([x, y], format!("and {} more", all - LISTED), TEXT, Anchor::Start),
        _ => {}
    }
}
