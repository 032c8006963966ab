//! The deformed bodies as SVG, filled with the colors of a nodal field, with a color bar.
//!
//! Plane bodies get filled contours ([`super::contours`]), thin cell edges where there is room for them, and an outline. Bodies in space
//! show the facets of their hull from one fixed direction, far ones first (painter's algorithm), lightly shaded; facets that pierce
//! each other are not resolved. Text is text: the reader's own sans-serif font is used. Names of the bodies appear as tool tips.

use std::collections::HashMap;
use std::fmt::Write as _;

use super::axis::Axis;
use super::colormap::viridis;
use super::contours::{Patch, simplified};
use crate::dynamics::BodyFields;
use crate::math::tolerances::PICTURE_THICKNESS;

/// A nodal field that a picture can show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Field {
    /// Von Mises stress.
    #[default]
    VonMises,
    /// Mean pressure.
    Pressure,
    /// Pressure between bodies.
    ContactPressure,
    /// Length of the displacement.
    Displacement,
    /// Length of the velocity.
    Velocity,
    /// A component of the Cauchy stress, as an index into [`BodyFields::stress`].
    Stress(Component),
}

/// A component of a symmetric stress, in the order of [`BodyFields::stress`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Component {
    /// xx
    Xx,
    /// yy
    Yy,
    /// zz
    Zz,
    /// xy
    Xy,
    /// yz
    Yz,
    /// xz
    Xz,
}

impl Field {
    /// All fields with their names in a script and in words.
    pub const ALL: &'static [(&'static str, &'static str, Field)] = &[
        ("von_mises", "von Mises stress", Field::VonMises),
        ("pressure", "pressure (−tr σ / 3)", Field::Pressure),
        ("contact_pressure", "contact pressure", Field::ContactPressure),
        ("displacement", "displacement", Field::Displacement),
        ("velocity", "velocity", Field::Velocity),
        ("stress_xx", "stress xx", Field::Stress(Component::Xx)),
        ("stress_yy", "stress yy", Field::Stress(Component::Yy)),
        ("stress_zz", "stress zz", Field::Stress(Component::Zz)),
        ("stress_xy", "stress xy", Field::Stress(Component::Xy)),
        ("stress_yz", "stress yz", Field::Stress(Component::Yz)),
        ("stress_xz", "stress xz", Field::Stress(Component::Xz)),
    ];

    /// The field of that name in a script.
    pub fn from_name(name: &str) -> Option<Self> {
        Field::ALL.iter().find(|row| row.0 == name).map(|row| row.2)
    }

    /// Its name in words.
    pub fn words(self) -> &'static str {
        Field::ALL.iter().find(|row| row.2 == self).map_or("", |row| row.1)
    }

    /// Its value at a node.
    pub fn value(self, body: &BodyFields, node: usize) -> f64 {
        let length = |[x, y, z]: [f64; 3]| x.hypot(y).hypot(z);
        match self {
            Field::VonMises => body.von_mises(node),
            Field::Pressure => -(body.stress[node][0] + body.stress[node][1] + body.stress[node][2]) / 3.0,
            Field::ContactPressure => body.contact_pressure[node],
            Field::Displacement => length(body.displacement[node]),
            Field::Velocity => length(body.velocity[node]),
            Field::Stress(component) => body.stress[node][component as usize],
        }
    }
}

/// What a picture shows and how.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureOptions {
    /// The field that gives the colors.
    pub field: Field,
    /// Text above the picture.
    pub title: String,
    /// Values at the ends of the color bar; those of the field where there is none. Give one to make pictures comparable.
    pub range: Option<[f64; 2]>,
    /// Width in pixels; below 240 there would be no room for the bodies beside the color bar, so 240 is taken.
    pub width: f64,
}

impl Default for PictureOptions {
    fn default() -> Self {
        PictureOptions { field: Field::default(), title: String::new(), range: None, width: 720.0 }
    }
}

/// Units of the drawing per pixel: whole numbers keep the file small.
const UNIT: f64 = 10.0;
/// Colors between the ends of the color bar. Odd, so that the round-off of a constant field stays inside the middle one.
const BANDS: usize = 41;
/// Deviation from a curve that nobody sees, in pixels.
const INVISIBLE: f64 = 0.1;
/// Cells with shorter sides, in pixels on average, are drawn without their edges: they would hide the colors.
const ROOM_FOR_EDGES: f64 = 5.0;
/// Cosine of the angle between facets from which their common edge is drawn as an edge of the body.
const SHARP: f64 = 0.8;
/// Direction to the lamp that shades bodies in space, and the light on a facet that it does not reach: weak enough to leave the colors
/// readable.
const LAMP: [f64; 3] = [0.2, -0.5, 0.84];
const AMBIENT: f64 = 0.75;
/// Outlines and text.
const INK: &str = "#222";

/// Color scale of a picture.
struct Scale {
    low: f64,
    high: f64,
}

impl Scale {
    /// Color of a band under a light from 0 to 1, as `#rrggbb`.
    fn color(&self, band: usize, light: f64) -> String {
        let [red, green, blue] = viridis((band as f64 + 0.5) / BANDS as f64).map(|channel| (channel * light).round() as u8);
        format!("#{red:02x}{green:02x}{blue:02x}")
    }

    /// Lower end of a band.
    fn level(&self, band: usize) -> f64 {
        let share = band as f64 / BANDS as f64;
        self.low * (1.0 - share) + self.high * share
    }

    fn band(&self, value: f64) -> usize {
        (1..BANDS).take_while(|&band| value >= self.level(band)).count()
    }
}

/// The bodies as SVG.
pub fn picture(bodies: &[BodyFields], options: &PictureOptions) -> String {
    let values: Vec<Vec<f64>> =
        bodies.iter().map(|body| (0..body.mesh.points.len()).map(|node| options.field.value(body, node)).collect()).collect();
    let axis = match options.range {
        Some(range) => Axis::over(range, 6),
        None => Axis::over(values.iter().flatten().copied(), 6),
    };
    let scale = Scale { low: axis.unscaled(axis.low), high: axis.unscaled(axis.high) };

    // The view: bodies left, color bar right.
    let planes: Vec<Vec<[f64; 2]>> =
        bodies.iter().map(|body| (0..body.mesh.points.len()).map(|node| projected(body, node)).collect()).collect();
    let bounds = Bounds::of(planes.iter().flatten());
    let width = options.width.max(240.0);
    let margin = 14.0;
    let top = if options.title.is_empty() { margin } else { 44.0 };
    let widest = axis.ticks.iter().map(|&tick| axis.label(tick).chars().count()).max().unwrap_or(1);
    let bar = Bar { width: 16.0, right: 12.0 + 8.0 * widest as f64 + 26.0 };
    let room = [width - 3.0 * margin - bar.width - bar.right, width];
    let zoom = (room[0] / bounds.size[0]).min(room[1] / bounds.size[1]);
    let drawn = bounds.size.map(|size| size * zoom);
    let height = drawn[1].max(180.0);
    let corner = [margin + 0.5 * (room[0] - drawn[0]), top + 0.5 * (height - drawn[1])];
    let view = |[x, y]: [f64; 2]| [corner[0] + (x - bounds.low[0]) * zoom, corner[1] + drawn[1] - (y - bounds.low[1]) * zoom];

    let mut out = String::new();
    let total = [width, top + height + margin];
    let _ = writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" \
         font-family=\"sans-serif\" fill=\"{INK}\">",
        short(total[0]),
        short(total[1])
    );
    let _ = writeln!(out, "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>");
    if !options.title.is_empty() {
        let _ = writeln!(out, "<text x=\"{}\" y=\"28\" font-size=\"17\">{}</text>", short(margin), escaped(&options.title));
    }
    let _ =
        writeln!(out, "<g transform=\"scale({})\" fill-rule=\"evenodd\" stroke-linejoin=\"round\" stroke-linecap=\"round\">", 1.0 / UNIT);
    if bodies.iter().any(|body| body.mesh.dimension() == 3) {
        hulls_into(&mut out, bodies, &values, &planes, view, &scale);
    } else {
        for ((body, values), plane) in bodies.iter().zip(&values).zip(&planes) {
            let points: Vec<[f64; 2]> = plane.iter().map(|&point| view(point)).collect();
            let _ = writeln!(out, "<g><title>{}</title>", escaped(&body.name));
            plane_into(&mut out, body, &points, values, &scale);
            let _ = writeln!(out, "</g>");
        }
    }
    let _ = writeln!(out, "</g>");
    let bar_height = height.clamp(120.0, 360.0);
    bar.draw_into(
        &mut out,
        &axis,
        &scale,
        [width - margin - bar.right - bar.width, top + 0.5 * (height - bar_height)],
        bar_height,
        options.field,
    );
    out.push_str("</svg>\n");
    out
}

/// Position of a node in the plane of the picture: of bodies in space, as seen from the direction (1, -1, 1) with z upwards.
fn projected(body: &BodyFields, node: usize) -> [f64; 2] {
    let [x, y, z] = body.position(node);
    if body.mesh.dimension() == 2 { [x, y] } else { [(x + y) / 2f64.sqrt(), (y - x + 2.0 * z) / 6f64.sqrt()] }
}

/// The box around points.
struct Bounds {
    low: [f64; 2],
    size: [f64; 2],
}

impl Bounds {
    fn of<'a>(points: impl Iterator<Item = &'a [f64; 2]>) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in points.filter(|point| point.iter().all(|x| x.is_finite())) {
            for d in 0..2 {
                low[d] = low[d].min(point[d]);
                high[d] = high[d].max(point[d]);
            }
        }
        let size = [high[0] - low[0], high[1] - low[1]];
        let longest = size[0].max(size[1]);
        if longest > 0.0 && longest.is_finite() {
            Bounds { low, size: size.map(|side| side.max(PICTURE_THICKNESS * longest)) }
        } else {
            Bounds { low: [0.0; 2], size: [1.0; 2] }
        }
    }
}

/// One plane body, points in pixels.
fn plane_into(out: &mut String, body: &BodyFields, points: &[[f64; 2]], values: &[f64], scale: &Scale) {
    let corners: Vec<usize> = body.mesh.kind.facets().iter().map(|facet| facet[0]).collect();
    let polygons: Vec<Vec<u32>> = body.mesh.cells().map(|cell| corners.iter().map(|&corner| cell[corner]).collect()).collect();
    let patch = Patch::new(points, values, polygons.iter().map(|polygon| &polygon[..]));
    let outline = loops_path(&patch.outline());
    contours_into(out, &patch, &outline, scale, 1.0);
    if has_room_for_edges(patch.edges()) {
        let mut path = String::new();
        for [a, b] in patch.edges() {
            polyline_into(&mut path, &[a, b], "");
        }
        let _ = writeln!(out, "<path d=\"{path}\" fill=\"none\" stroke=\"#000\" stroke-opacity=\".28\" stroke-width=\"4\"/>");
    }
    let _ = writeln!(out, "<path d=\"{outline}\" fill=\"none\" stroke=\"{INK}\" stroke-width=\"11\"/>");
}

fn has_room_for_edges(edges: impl Iterator<Item = [[f64; 2]; 2]>) -> bool {
    let (count, length) = edges.fold((0, 0.0), |(count, length), [a, b]| (count + 1, length + (a[0] - b[0]).hypot(a[1] - b[1])));
    length >= ROOM_FOR_EDGES * f64::from(count)
}

/// Filled contours: the whole patch in the color of its lowest band, then what is above each further level.
fn contours_into(out: &mut String, patch: &Patch, outline: &str, scale: &Scale, light: f64) {
    let lowest = scale.band(patch.range()[0]);
    let _ = writeln!(out, "<path d=\"{outline}\" fill=\"{}\"/>", scale.color(lowest, light));
    for band in lowest + 1..=scale.band(patch.range()[1]) {
        let path = loops_path(&patch.above(scale.level(band)));
        if !path.is_empty() {
            let _ = writeln!(out, "<path d=\"{path}\" fill=\"{}\"/>", scale.color(band, light));
        }
    }
}

/// Facets of cells in space that no other cell shares, painted from far to near.
fn hulls_into(
    out: &mut String,
    bodies: &[BodyFields],
    values: &[Vec<f64>],
    planes: &[Vec<[f64; 2]>],
    view: impl Fn([f64; 2]) -> [f64; 2],
    scale: &Scale,
) {
    struct Side {
        body: usize,
        nodes: Vec<u32>,
        normal: [f64; 3],
        depth: f64,
    }
    let toward_viewer = [1.0, -1.0, 1.0].map(|x: f64| x / 3f64.sqrt());
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let mut sides = Vec::new();
    let mut normals_at: HashMap<(usize, [u32; 2]), Vec<[f64; 3]>> = HashMap::new();
    for (index, body) in bodies.iter().enumerate() {
        for facet in body.mesh.hull() {
            let nodes: Vec<u32> = body.mesh.facet_nodes(facet).collect();
            let corners: Vec<[f64; 3]> = nodes.iter().map(|&node| body.position(node as usize)).collect();
            let normal = normal(&corners);
            for (&a, &b) in nodes.iter().zip(nodes.iter().cycle().skip(1)) {
                normals_at.entry((index, [a.min(b), a.max(b)])).or_default().push(normal);
            }
            let depth = corners.iter().map(|&corner| dot(corner, toward_viewer) / corners.len() as f64).sum();
            if dot(normal, toward_viewer) > 0.0 {
                sides.push(Side { body: index, nodes, normal, depth });
            }
        }
    }
    sides.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    let edges = sides.iter().flat_map(|side| {
        let point = |node: u32| view(planes[side.body][node as usize]);
        side.nodes.iter().zip(side.nodes.iter().cycle().skip(1)).map(move |(&a, &b)| [point(a), point(b)]).collect::<Vec<_>>()
    });
    let coarse = has_room_for_edges(edges);
    for Side { body, nodes, normal, .. } in &sides {
        let points: Vec<[f64; 2]> = nodes.iter().map(|&node| view(planes[*body][node as usize])).collect();
        let local: Vec<f64> = nodes.iter().map(|&node| values[*body][node as usize]).collect();
        let numbers: Vec<u32> = (0..nodes.len() as u32).collect();
        let patch = Patch::new(&points, &local, [&numbers[..]]);
        let outline = loops_path(std::slice::from_ref(&points));
        let light = AMBIENT + (1.0 - AMBIENT) * dot(*normal, LAMP).max(0.0);
        if coarse {
            contours_into(out, &patch, &outline, scale, light);
            let _ = writeln!(out, "<path d=\"{outline}\" fill=\"none\" stroke=\"#000\" stroke-opacity=\".3\" stroke-width=\"4\"/>");
        } else {
            let color = scale.color(scale.band(local.iter().sum::<f64>() / local.len() as f64), light);
            // The stroke closes the hairlines between neighbors.
            let _ = writeln!(out, "<path d=\"{outline}\" fill=\"{color}\" stroke=\"{color}\" stroke-width=\"5\"/>");
        }
        let mut sharp = String::new();
        for (local, (&a, &b)) in nodes.iter().zip(nodes.iter().cycle().skip(1)).enumerate() {
            let around = &normals_at[&(*body, [a.min(b), a.max(b)])];
            if around.len() != 2 || dot(around[0], around[1]) < SHARP || around.iter().any(|&normal| dot(normal, toward_viewer) <= 0.0) {
                polyline_into(&mut sharp, &[points[local], points[(local + 1) % points.len()]], "");
            }
        }
        if !sharp.is_empty() {
            let _ = writeln!(out, "<path d=\"{sharp}\" fill=\"none\" stroke=\"{INK}\" stroke-width=\"11\"/>");
        }
    }
}

/// Unit normal of a polygon in space by Newell's sums; zero for a degenerate one.
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

/// Closed loops in pixels as path data; what is smaller than anyone sees is left out.
fn loops_path(loops: &[Vec<[f64; 2]>]) -> String {
    let mut path = String::new();
    for corners in loops {
        let corners = simplified(corners, INVISIBLE);
        let size = Bounds::of(corners.iter()).size;
        if corners.len() > 2 && size[0].max(size[1]) > 4.0 * INVISIBLE {
            polyline_into(&mut path, &corners, "z");
        }
    }
    path
}

/// Points in pixels as path data in whole units, each relative to the one before; `close` is `z` for a closed path.
fn polyline_into(path: &mut String, points: &[[f64; 2]], close: &str) {
    let mut last = [0i64; 2];
    for (index, point) in points.iter().enumerate() {
        let now = point.map(|x| (x * UNIT).round() as i64);
        let [x, y] = [now[0] - last[0], now[1] - last[1]];
        if index > 0 && [x, y] == [0, 0] {
            continue;
        }
        let between = |number: i64| if number < 0 { "" } else { " " };
        let _ = match index {
            0 => write!(path, "M{x}{}{y}l", between(y)),
            _ if path.ends_with('l') => write!(path, "{x}{}{y}", between(y)),
            _ => write!(path, "{}{x}{}{y}", between(x), between(y)),
        };
        last = now;
    }
    path.push_str(close);
}

/// The color bar.
struct Bar {
    width: f64,
    /// Room to its right for numbers and the name of the field.
    right: f64,
}

impl Bar {
    fn draw_into(&self, out: &mut String, axis: &Axis, scale: &Scale, [x, y]: [f64; 2], height: f64, field: Field) {
        let _ = writeln!(out, "<g font-size=\"13\">");
        for band in 0..BANDS {
            // Each reaches up to the end of the bar: no hairlines between them.
            let size = height * (1.0 - band as f64 / BANDS as f64);
            let (x, y, width) = (short(x), short(y), short(self.width));
            let _ = writeln!(
                out,
                "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{}\" fill=\"{}\"/>",
                short(size),
                scale.color(band, 1.0)
            );
        }
        let (left, top) = (short(x), short(y));
        let _ = writeln!(
            out,
            "<rect x=\"{left}\" y=\"{top}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"{INK}\" stroke-width=\".8\"/>",
            short(self.width),
            short(height)
        );
        for &tick in &axis.ticks {
            let at = y + height * (1.0 - (tick - axis.low) / (axis.high - axis.low));
            let end = x + self.width;
            let _ = writeln!(
                out,
                "<path d=\"M{} {}h4\" stroke=\"{INK}\" stroke-width=\".8\"/><text x=\"{}\" y=\"{}\">{}</text>",
                short(end),
                short(at),
                short(end + 7.0),
                short(at + 4.5),
                axis.label(tick)
            );
        }
        let (x, y) = (short(x + self.width + self.right - 6.0), short(y + 0.5 * height));
        let _ = writeln!(
            out,
            "<text transform=\"translate({x} {y}) rotate(-90)\" text-anchor=\"middle\" font-size=\"14\">{}</text>",
            escaped(&axis.name(field.words()))
        );
        let _ = writeln!(out, "</g>");
    }
}

/// A length in pixels with one decimal at most.
fn short(value: f64) -> String {
    format!("{}", (value * 10.0).round() / 10.0)
}

/// Text inside an element.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::super::samples::{block, ring, well_formed};
    use super::*;

    fn options(field: &str) -> PictureOptions {
        PictureOptions { field: Field::from_name(field).unwrap(), title: "bearing, t = 0.5".into(), ..PictureOptions::default() }
    }

    /// One square cell of side 1, moved by (1, 0), with von Mises stresses 0, 0, 4 and 4 at the corners.
    fn cell() -> BodyFields {
        let mut body = ring("cell", [1.0, 2.0], [1, 4]);
        let mut mesh = (*body.mesh).clone();
        (mesh.points, mesh.connectivity) = (vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]], vec![0, 1, 2, 3]);
        body.displacement = vec![[1.0, 0.0, 0.0]; 4];
        body.stress = [0.0, 0.0, 4.0, 4.0].map(|xx| [xx, 0.0, 0.0, 0.0, 0.0, 0.0]).to_vec();
        body.mesh = mesh.into();
        body
    }

    #[test]
    fn a_cell_is_filled_up_to_each_level() {
        let svg = picture(&[cell()], &options("von_mises"));
        well_formed(&svg);
        // The body's paths: a fill for every band, the edges, the outline.
        let group = svg.split("<title>cell</title>").nth(1).unwrap().split("</g>").next().unwrap();
        let paths: Vec<&str> = group.lines().filter(|line| line.starts_with("<path")).collect();
        assert_eq!(paths.len(), BANDS + 2);
        // The region above a level is as wide as the cell and reaches from its upper side down to the level.
        let numbers = |path: &str| -> Vec<i64> {
            let data = path.split('"').nth(1).unwrap().replace('-', " -");
            data.split(|c: char| !(c.is_ascii_digit() || c == '-')).filter_map(|word| word.parse().ok()).collect()
        };
        let extent = |path: &str| {
            let numbers = numbers(path);
            let places = numbers[2..].chunks(2).scan([0, 0], |at, step| {
                *at = [at[0] + step[0], at[1] + step[1]];
                Some(*at)
            });
            let (low, high) = places.fold(([0, 0], [0, 0]), |(low, high), at| {
                ([at[0].min(low[0]), at[1].min(low[1])], [at[0].max(high[0]), at[1].max(high[1])])
            });
            [high[0] - low[0], high[1] - low[1]]
        };
        let whole = extent(paths[0]);
        assert_eq!(whole[0], whole[1]);
        for (band, path) in paths[..BANDS].iter().enumerate() {
            let [width, height] = extent(path);
            let expected = whole[1] as f64 * (1.0 - band as f64 / BANDS as f64);
            // Both ends of a length are rounded to whole units.
            assert!((width - whole[0]).abs() <= 1 && (height as f64 - expected).abs() <= 1.5, "{band}: {width} x {height}, not {expected}");
        }
        assert!(paths[0].contains(&Scale { low: 0.0, high: 4.0 }.color(0, 1.0)));
    }

    #[test]
    fn field_title_and_body_names_are_text() {
        let mut bodies = [ring("outer <ring>", [1.0, 1.5], [3, 20]), ring("inner ring", [0.5, 1.0], [3, 16])];
        for (name, words, _) in Field::ALL {
            let svg = picture(&bodies, &options(name));
            well_formed(&svg);
            assert!(svg.contains(words) && svg.contains(">bearing, t = 0.5</text>"), "{name}");
            assert!(svg.contains("<title>outer &lt;ring&gt;</title>") && svg.contains("<title>inner ring</title>"));
        }
        assert_eq!(Field::from_name("stress"), None);
        bodies[1].stress[3] = [7.0, 0.0, 0.0, 3.0, 0.0, 0.0];
        assert_eq!(Field::Pressure.value(&bodies[1], 3), -7.0 / 3.0);
        assert_eq!(Field::Stress(Component::Xy).value(&bodies[1], 3), 3.0);
    }

    #[test]
    fn a_constant_field_has_one_color_and_a_range_makes_pictures_comparable() {
        let mut body = cell();
        body.stress = [3.0, 3.0 * (1.0 + 1e-15), 3.0, 3.0].map(|xx| [xx, 0.0, 0.0, 0.0, 0.0, 0.0]).to_vec();
        let fills = |svg: &str| svg.split("</title>").nth(1).unwrap().split("</g>").next().unwrap().matches("fill=\"#").count();
        assert_eq!(fills(&picture(&[body.clone()], &options("von_mises"))), 1);
        let ranged = picture(&[body], &PictureOptions { range: Some([0.0, 3.0]), ..options("von_mises") });
        assert!(ranged.split("</title>").nth(1).unwrap().contains(&Scale { low: 0.0, high: 3.0 }.color(BANDS - 1, 1.0)));
    }

    #[test]
    fn broken_bodies_make_a_picture_all_the_same() {
        let mut body = ring("ring", [1.0, 1.5], [3, 20]);
        well_formed(&picture(&[], &options("von_mises")));
        body.stress[0] = [f64::NAN; 6];
        body.velocity[5] = [f64::INFINITY; 3];
        body.displacement[7] = [f64::NAN; 3];
        body.displacement[8] = [1e300, 0.0, 0.0];
        for (name, ..) in Field::ALL {
            well_formed(&picture(std::slice::from_ref(&body), &options(name)));
        }
        let mut point = cell();
        point.displacement = point.mesh.points.iter().map(|x| x.map(|x| -x)).collect();
        well_formed(&picture(&[point], &options("velocity")));
    }

    #[test]
    fn a_fine_mesh_costs_hardly_more_than_a_coarse_one() {
        let size = |refine: usize| picture(&[ring("ring", [1.0, 1.5], [10 * refine, 48 * refine])], &options("von_mises")).len();
        let (coarse, fine) = (size(1), size(8));
        // Sixty-four times the cells: smoother contours, but no cell edges.
        assert!(coarse < 80_000 && fine < 2 * coarse, "{coarse} and {fine} bytes");
    }

    #[test]
    fn a_block_in_space_shows_three_sides() {
        let mut body = block([1, 1, 1], [1.0, 1.0, 1.0]);
        body.displacement = vec![[0.0; 3]; 8];
        let svg = picture(&[body], &options("stress_xx"));
        well_formed(&svg);
        assert_eq!(svg.matches("stroke-opacity").count(), 3, "one set of edges for each visible facet");
        // The corner toward the viewer has three sides in common; the three facets are seen at the same angle.
        well_formed(&picture(&[block([6, 2, 2], [3.0, 1.0, 1.0])], &options("von_mises")));
    }
}
