//! Structured solids with round sides, of hexahedra: tube, cylinder, torus, sphere, rounded block.
//!
//! Spheres and rounded blocks have no poles. The surface of a grid of cells grows outward in layers, as six blocks around a core (C.
//! Ronchi, R. Iacono, P. Paolucci, J. Comput. Phys. 124, 1996, 93-114, section 2). A grid line has a base `b` and a slope `t = tan(a)` from
//! -1 to 1; node `b + r t/|t|` of the surface lies on the sphere of radius `r` about `b`, with uniform angles `a`. In a sphere all bases
//! are its center; in a rounded block they lie on the inner block, and `t = 0` along its flat sides.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use super::grid::{at_least, graded, grid, limited, positive};
use super::{Axis, Boundary, Change, Facet, Mesh, MeshError, Prisms, block, disk, graded_ring};
use crate::elements::CellKind;

/// A tube of hex8 cells along z, its bottom about `base` `[length]`, `cells` along the radius, around and along the height; boundaries
/// `inner outer bottom top`. The outermost cell is `grading[0]` times the innermost, the topmost `grading[1]` times the lowest.
///
/// # Errors
/// Errors of [`ring`](super::ring) and [`Mesh::extruded`].
pub fn tube(radii: [f64; 2], height: f64, cells: [usize; 3], base: [f64; 3], grading: [f64; 2]) -> Result<Mesh, MeshError> {
    let ring = graded_ring(radii[0], radii[1], [cells[0], cells[1]], [0.0; 2], 0.0, grading[0])?;
    ring.extruded(height, cells[2], grading[1], Change::NONE)?.translate(base)
}

/// A solid cylinder of hex8 cells along z, its bottom about `base` `[length]`: `cells[0]` layers with `cells[1]` cells around a square
/// core, `cells[2]` along the height, the topmost `grading` times the lowest; boundaries `outer bottom top`.
///
/// # Errors
/// Errors of [`disk`] and [`Mesh::extruded`].
pub fn cylinder(radius: f64, height: f64, cells: [usize; 3], base: [f64; 3], grading: f64) -> Result<Mesh, MeshError> {
    let disk = disk(radius, [cells[0], cells[1]], [0.0; 2])?;
    disk.extruded(height, cells[2], grading, Change::NONE)?.translate(base)
}

/// Solid torus of hex8 cells about the z axis through `center` `[length]`: a [`disk`] of the radius `section_radius` whose center moves
/// around at the distance `ring_radius`; `cells` are its layers, cells around the section, and cells along the ring; boundary `outer`.
///
/// # Errors
/// Errors of [`disk`] and [`Mesh::revolved`]; a section that reaches the axis.
pub fn torus(ring_radius: f64, section_radius: f64, cells: [usize; 3], center: [f64; 3]) -> Result<Mesh, MeshError> {
    positive("the radius of a torus", ring_radius)?;
    let section = disk(section_radius, [cells[0], cells[1]], [ring_radius, 0.0])?;
    let mut torus = section.revolved(-std::f64::consts::TAU, cells[2], Axis::Y, 1.0, Prisms::Cut)?;
    for point in &mut torus.points {
        *point = [point[0], 0.0 - point[2], point[1]];
    }
    torus.translate(center)
}

/// A solid sphere of hex8 cells about `center` `[length]`: `cells[0]` layers round a core of `cells[1]/4` cells along each edge, so that
/// `cells[1]` go around it; the outermost layer is `grading` times the innermost. Boundary `outer`.
///
/// # Errors
/// A radius that is not positive, a number of cells around that is no multiple of 4, numbers that are not finite, too many cells.
pub fn sphere(radius: f64, cells: [usize; 2], center: [f64; 3], grading: f64) -> Result<Mesh, MeshError> {
    positive("the radius of a sphere", radius)?;
    let line = round_line(cells)?;
    let grown = Grown::new([&line, &line, &line], Some(CORE * radius), radius, &graded(cells[0], grading)?)?;
    grown.mesh(|_| "outer".into()).translate(center)
}

/// A hollow sphere of hex8 cells about `center` `[length]`, `cells` along the radius and around (six blocks of `cells[1]/4` by as many);
/// the outermost cell is `grading` times the innermost. Boundaries `inner outer`.
///
/// # Errors
/// Errors of [`sphere`]; radii that are not in order.
pub fn hollow_sphere(radii: [f64; 2], cells: [usize; 2], center: [f64; 3], grading: f64) -> Result<Mesh, MeshError> {
    let [inner, outer] = radii;
    positive("the inner radius of a hollow sphere", inner)?;
    positive("the outer radius of a hollow sphere", outer)?;
    if inner >= outer {
        return Err(MeshError::Radii { inner, outer });
    }
    let line = round_line(cells)?;
    let places: Vec<f64> = graded(cells[0], grading)?.iter().map(|share| inner / outer * (1.0 - share) + share).collect();
    Grown::new([&line, &line, &line], None, outer, &places)?.mesh(|_| "outer".into()).translate(center)
}

/// A block of hex8 cells whose edges and corners are rounded with `radius` `[length]`, `size` and `origin` (its corner of least
/// coordinates, which is rounded off) `[length]`: `cells` along the flat sides, `around[0]` layers below the surface and `around[1]` cells
/// across each edge. Boundaries `left right bottom top back front` are the flat sides as of a [`block`], `edges` the rounded edges and
/// corners.
///
/// # Errors
/// Lengths that are not positive, a radius of half the least size or more, counts of 0, an odd number of cells across the edges, numbers
/// that are not finite, too many cells.
pub fn rounded_block(size: [f64; 3], radius: f64, cells: [usize; 3], around: [usize; 2], origin: [f64; 3]) -> Result<Mesh, MeshError> {
    for (what, value) in ["the width of a block", "the height of a block", "the depth of a block"].into_iter().zip(size) {
        positive(what, value)?;
    }
    positive("the radius of the edges of a block", radius)?;
    let least = size.into_iter().fold(f64::INFINITY, f64::min);
    if radius >= 0.5 * least {
        return Err(MeshError::Rounding { radius, size: least });
    }
    for (direction, count) in ["along the width", "along the height", "along the depth"].into_iter().zip(cells) {
        at_least(direction, count, 1)?;
    }
    at_least("below the surface", around[0], 1)?;
    let [layers, across] = around;
    if across == 0 || !across.is_multiple_of(2) {
        return Err(MeshError::NotMultiple { direction: "across an edge", count: across, of: 2 });
    }
    let lines: Vec<Vec<Line>> = (0..3)
        .map(|i| {
            let (low, high) = (radius, size[i] - radius);
            let slope = |k: usize| (FRAC_PI_2 * k as f64 / across as f64 - FRAC_PI_4).tan();
            let round = |base: f64, from: usize| (from..=from + across / 2).map(move |k| Line { base, slope: exact(slope(k)) });
            let flat = grid(cells[i]).map(|share| Line { base: low * (1.0 - share) + high * share, slope: 0.0 });
            let flat: Vec<Line> = flat.skip(1).take(cells[i] - 1).collect();
            round(low, 0).chain(flat).chain(round(high, across / 2)).collect()
        })
        .collect();
    let shares: Vec<f64> = grid(layers).collect();
    let grown = Grown::new([&lines[0], &lines[1], &lines[2]], Some(CORE * radius), radius, &shares)?;
    let is_flat = |slopes: [f64; 3]| slopes.iter().filter(|slope| **slope != 0.0).count() == 1;
    let named = |side: &GridFacet| if side.slopes.iter().all(|&slopes| is_flat(slopes)) { side.name.clone() } else { "edges".into() };
    let mut mesh = grown.mesh(named);
    // Boundaries of flat sides come first, in the order of `block`.
    mesh.boundaries.sort_by_key(|boundary| boundary.name == "edges");
    mesh.translate(origin)
}

/// Distance of the centers of the core's sides from the sphere's center, relative to the radius. With [`BULGE`], the scaled Jacobian is at
/// least 0.68 for every number of cells, near the optimum of both.
const CORE: f64 = 0.45;
/// Blend of the shape of a sphere's core between a cube (0) and a sphere (1).
const BULGE: f64 = 0.6;

/// Grid line with the base `b` and the slope `t` of the module description.
#[derive(Clone, Copy)]
struct Line {
    base: f64,
    slope: f64,
}

/// Slope with the values -1, 0 and 1 cleared of round-off.
fn exact(slope: f64) -> f64 {
    let whole = slope.round();
    if (slope - whole).abs() < crate::math::tolerances::PLANE { whole } else { slope }
}

/// Grid lines of a sphere.
fn round_line(cells: [usize; 2]) -> Result<Vec<Line>, MeshError> {
    at_least("along the radius", cells[0], 1)?;
    let side = cells[1] / 4;
    if cells[1] == 0 || !cells[1].is_multiple_of(4) {
        return Err(MeshError::NotMultiple { direction: "around", count: cells[1], of: 4 });
    }
    limited(&[side, side, side.saturating_add(cells[0].saturating_mul(6))])?;
    Ok(grid(side).map(|share| Line { base: 0.0, slope: exact((FRAC_PI_2 * share - FRAC_PI_4).tan()) }).collect())
}

/// A facet of the surface of the grid.
struct GridFacet {
    /// Name of the grid side that contains the facet.
    name: String,
    nodes: Vec<u32>,
    /// Slopes of the grid lines in the three directions, for each node of the facet.
    slopes: Vec<[f64; 3]>,
}

/// Grid with layers of cells grown outwards from its surface.
struct Grown {
    /// Mesh with the cells of the core first, if there is a core, and without boundaries.
    mesh: Mesh,
    sides: Vec<GridFacet>,
    layers: usize,
    has_core: bool,
}

impl Grown {
    /// Constructs the layers: with a core, `places` are fractions of the distance from the core to the surface, without a core distances
    /// from the bases relative to the radius.
    fn new(lines: [&[Line]; 3], core: Option<f64>, radius: f64, places: &[f64]) -> Result<Grown, MeshError> {
        let counts = lines.map(|line| line.len() - 1);
        let layers = places.len() - 1;
        let [nx, ny, nz] = counts;
        let surface = 2 * (nx * ny + ny * nz + nz * nx);
        limited(&[nx * ny * nz + surface * layers])?;
        let grid = block([1.0; 3], counts, [0.0; 3])?;
        let corners: Vec<[Line; 3]> =
            lines[2].iter().flat_map(|&z| lines[1].iter().flat_map(move |&y| lines[0].iter().map(move |&x| [x, y, z]))).collect();
        let sides: Vec<GridFacet> = grid
            .boundaries
            .iter()
            .flat_map(|boundary| {
                boundary.facets.iter().map(|&facet| (boundary.name.clone(), grid.facet_nodes(facet).collect::<Vec<u32>>()))
            })
            .map(|(name, nodes)| GridFacet {
                name,
                slopes: nodes.iter().map(|&n| corners[n as usize].map(|line| line.slope)).collect(),
                nodes,
            })
            .collect();
        let mut rim: Vec<u32> = sides.iter().flat_map(|side| side.nodes.iter().copied()).collect();
        rim.sort_unstable();
        rim.dedup();
        let at = |node: u32, place: f64| {
            let corner = &corners[node as usize];
            let slope = corner.map(|line| line.slope);
            let length = slope[0].hypot(slope[1]).hypot(slope[2]);
            let largest = slope.into_iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            let bulged = if length > 0.0 { 1.0 - BULGE + BULGE * largest / length } else { 1.0 };
            let factor = match core {
                Some(core) if place == 0.0 => core * bulged,
                Some(core) => core * bulged * (1.0 - place) + radius * place / length,
                None => radius * place / length,
            };
            [0, 1, 2].map(|i| corner[i].base + factor * slope[i])
        };
        let mut mesh = Mesh::new(CellKind::Hex8, Vec::new(), Vec::new());
        if core.is_some() {
            mesh.points.extend((0..corners.len() as u32).map(|node| at(node, 0.0)));
            mesh.blocks.clone_from(&grid.blocks);
        }
        let first = mesh.points.len();
        let skipped = usize::from(core.is_some());
        for &place in &places[skipped..] {
            mesh.points.extend(rim.iter().map(|&node| at(node, place)));
        }
        let number = |layer: usize, node: u32| match rim.binary_search(&node) {
            Ok(index) if layer >= skipped => (first + (layer - skipped) * rim.len() + index) as u32,
            _ => node,
        };
        for layer in 0..layers {
            for side in &sides {
                mesh.blocks[0]
                    .connectivity
                    .extend([layer, layer + 1].into_iter().flat_map(|layer| side.nodes.iter().map(move |&node| number(layer, node))));
            }
        }
        Ok(Grown { mesh, sides, layers, has_core: core.is_some() })
    }

    /// Mesh with each facet of its surface in a boundary named by `named`, and with `inner` if there is no core.
    fn mesh(self, named: impl Fn(&GridFacet) -> String) -> Mesh {
        let Grown { mut mesh, sides, layers, has_core } = self;
        let core = mesh.cell_count() - layers * sides.len();
        let cell = |layer: usize, side: usize| (core + layer * sides.len() + side) as u32;
        if !has_core {
            let facets = (0..sides.len()).map(|side| Facet { cell: cell(0, side), local: 0 }).collect();
            mesh.boundaries.push(Boundary::of_facets("inner", facets));
        }
        for (index, side) in sides.iter().enumerate() {
            let (name, facet) = (named(side), Facet { cell: cell(layers - 1, index), local: 1 });
            match mesh.boundaries.iter_mut().find(|boundary| boundary.name == name) {
                Some(boundary) => boundary.facets.push(facet),
                None => mesh.boundaries.push(Boundary::of_facets(&name, vec![facet])),
            }
        }
        mesh
    }
}
