//! Penetration in a frame, from geometry alone.

use std::collections::BTreeMap;
use std::path::Path;

use conserva::elements::CellKind;
use conserva::output::{FieldsRead, Section, read_fields};

use super::super::plane::{Outline, Point};
use super::super::solids::{Skin, deepest};
use super::script::{RADII, TOP};
use super::{Named, catalogue, script};

/// Facets by their sorted nodes: number of occurrences in the cells of a body, and the nodes in order.
type Facets = BTreeMap<Vec<usize>, (usize, Vec<usize>)>;

/// Bodies of a frame.
pub struct Frame {
    /// Undeformed points, three components each.
    pub points: Vec<[f64; 3]>,
    /// Displacement of the points.
    pub displacement: Vec<[f64; 3]>,
    /// Facets of the hull of every body by their corners, in the plane with the node between them.
    pub hulls: Vec<Vec<Vec<usize>>>,
}

fn vectors(read: &FieldsRead, section: Section, name: &str) -> Option<Vec<[f64; 3]>> {
    let array = read.array(section, name)?;
    let count = array.components;
    let component = |point: usize, i: usize| if i < count { array.numbers.at(count * point + i) } else { 0.0 };
    Some((0..read.points).map(|point| std::array::from_fn(|i| component(point, i))).collect())
}

impl Frame {
    /// The frame of a file.
    pub fn read(path: &Path) -> Result<Self, String> {
        let read = read_fields(path).map_err(|error| error.to_string())?;
        let points = vectors(&read, Section::Points, "Points").ok_or("no points")?;
        let displacement = vectors(&read, Section::PointData, "displacement").ok_or("no displacement")?;
        let body = read.array(Section::CellData, "body").ok_or("no bodies")?;
        let mut found: Vec<Facets> = vec![BTreeMap::new(); read.parts.len()];
        for (cell, (_, nodes)) in read.cells().enumerate() {
            let of = body.numbers.at(cell) as usize;
            let is_plane = points.iter().all(|point| point[2] == 0.0);
            let dimension = if is_plane { 2 } else { 3 };
            let kind =
                CellKind::ALL.iter().find(|kind| kind.nodes() == nodes.len() && kind.dimension() == dimension).ok_or("a strange cell")?;
            let corners = kind.shape().corners();
            for facet in kind.facets() {
                let is_kept = |local: usize| is_plane || local < corners;
                let facet: Vec<usize> = facet.iter().filter(|&&local| is_kept(local)).map(|&local| nodes[local] as usize).collect();
                let mut key = facet.clone();
                key.sort_unstable();
                let entry = found[of].entry(key).or_insert((0, facet));
                entry.0 += 1;
            }
        }
        let hulls = found.into_iter().map(|facets| facets.into_values().filter(|(count, _)| *count == 1).map(|(_, facet)| facet).collect());
        Ok(Frame { points, displacement, hulls: hulls.collect() })
    }

    fn place(&self, node: usize) -> [f64; 3] {
        std::array::from_fn(|i| self.points[node][i] + self.displacement[node][i])
    }

    /// Penetration over the facet size: of corners of the body in an obstacle, of corners and edges of two bodies in each other.
    pub fn depth(&self, product: Named, time: f64) -> f64 {
        let is_plane = catalogue::is_plane(product.row("cell"));
        let partner = product.row("partner");
        let own = if self.hulls.len() > 1 && !partner.starts_with("rigid_") && self.hulls.is_empty() { 1 } else { 0 };
        let Some(hull) = self.hulls.get(own) else { return 0.0 };
        let size = self.facet_size(hull, is_plane);
        if ["held_body", "free_body", "rigid_body"].contains(&partner) && self.hulls.len() > 1 {
            return self.mutual(is_plane) / size;
        }
        let nodes: std::collections::BTreeSet<usize> = hull.iter().flatten().copied().collect();
        let offset = script::obstacle_offset(product, time);
        let depth = |node: usize| {
            let [x, y, z] = self.place(node);
            -distance(product, [x, y - offset, z])
        };
        nodes.into_iter().map(depth).fold(0.0, f64::max) / size
    }

    fn facet_size(&self, hull: &[Vec<usize>], is_plane: bool) -> f64 {
        let skin = |facets: &[Vec<usize>]| Skin {
            first: 0,
            facets: facets.iter().map(|facet| facet.iter().map(|&node| node as u32).collect()).collect(),
        };
        if is_plane {
            return Outline::new(self.segments(hull)).segments.iter().map(|[a, b]| (b[0] - a[0]).hypot(b[1] - a[1])).sum::<f64>()
                / hull.len() as f64;
        }
        let flat: Vec<f64> = (0..self.points.len()).flat_map(|node| self.place(node)).collect();
        skin(hull).size(&flat)
    }

    fn segments(&self, hull: &[Vec<usize>]) -> Vec<[Point; 2]> {
        let point = |node: usize| {
            let [x, y, _] = self.place(node);
            [x, y]
        };
        let pieces = |facet: &Vec<usize>| match facet[..] {
            [start, end, middle] => vec![[start, middle], [middle, end]],
            _ => vec![[facet[0], facet[1]]],
        };
        hull.iter().flat_map(pieces).map(|ends| ends.map(point)).collect()
    }

    fn mutual(&self, is_plane: bool) -> f64 {
        let [first, second] = [&self.hulls[0], &self.hulls[1]];
        if is_plane {
            let outlines = [first, second].map(|hull| Outline::new(self.segments(hull)));
            let inside = |own: usize| {
                let other = &outlines[1 - own];
                let samples = outlines[own]
                    .segments
                    .iter()
                    .flat_map(|[a, b]| [0.0, 0.5].map(|s| [a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])]));
                samples.filter(|x| other.holds(*x)).map(|x| other.nearest(x).1).fold(0.0, f64::max)
            };
            return inside(0).max(inside(1));
        }
        let facets = |hull: &Vec<Vec<usize>>| hull.iter().map(|facet| facet.iter().map(|&node| node as u32).collect()).collect();
        let skins = [first, second].map(|hull| Skin { first: 0, facets: facets(hull) });
        let flat: Vec<f64> = (0..self.points.len()).flat_map(|node| self.place(node)).collect();
        deepest(&skins, &flat)
    }
}

/// Distance of a point from an obstacle of `script.rs` at rest, negative inside.
fn distance(product: Named, [x, y, z]: [f64; 3]) -> f64 {
    let is_round = product.is("shape", &["round"]);
    let [x, z] = if product.is("partner", &["rigid_ring"]) { [x - 1.0, z] } else { [x - TOP[0], z - TOP[1]] };
    match product.row("partner") {
        "rigid_plane" | "rigid_box" | "rigid_surface" => y,
        "rigid_disk" | "rigid_cylinder" => x.hypot(y + 0.5) - 0.5,
        "rigid_ring" => {
            let high = if is_round { 1.5 } else { (1.5f64.powi(2) - 0.25).sqrt() };
            1.5 - x.hypot(y - high)
        }
        "rigid_polyline" => (y + 0.1 * x.abs()) / 1.01f64.sqrt(),
        "rigid_sphere" => (x.powi(2) + (y + 0.5).powi(2) + z.powi(2)).sqrt() - 0.5,
        "rigid_cone" => {
            let angle = 70f64.to_radians();
            x.hypot(z) * angle.cos() + y * angle.sin()
        }
        "rigid_torus" => (x.hypot(z) - 0.3).hypot(y + 0.2) - RADII[0],
        _ => f64::INFINITY,
    }
}
