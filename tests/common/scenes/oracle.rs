//! Energies, momenta and penetrations of a state, from positions, velocities and the scene alone.
//!
//! No function here calls the kernels; nodes and cells are numbered as in the mesh. Energies are integrated with two by two Gauss points in
//! each quadrilateral, which is exact for the kinetic energy and equals the discretization for the strain energy.

use conserva::mesh::MeshError;

use super::geometry::{Outline, Point, add, cross, distance, dot, length, scaled, segments_cross, subtract};
use super::{Body, Scene, Wall, hull, plane};

/// Energies and momenta of a state.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums {
    pub kinetic: f64,
    pub strain: f64,
    pub potential: f64,
    pub momentum: Point,
    pub angular_momentum: f64,
}

impl Sums {
    pub fn total(&self) -> f64 {
        self.kinetic + self.strain + self.potential
    }
}

/// Penetration of one object in another one.
#[derive(Clone, Debug, Default)]
pub struct Depth {
    /// Penetration `[length]`.
    pub length: f64,
    /// Penetration over the coarser of the two facets involved.
    pub facets: f64,
    /// Description of the two objects.
    pub place: String,
}

impl Depth {
    fn raise(&mut self, length: f64, facet: f64, place: impl FnOnce() -> String) {
        let facets = length / facet;
        if facets > self.facets {
            *self = Depth { length, facets, place: place() };
        }
    }
}

/// Gauss point: shape functions, their gradients, its undeformed area.
struct GaussPoint {
    shape: [f64; 4],
    gradients: [Point; 4],
    area: f64,
}

/// A body in the numbering of its mesh.
struct Matter {
    /// Number of its first node in the model.
    first: usize,
    points: Vec<Point>,
    cells: Vec<[usize; 4]>,
    quadrature: Vec<[GaussPoint; 4]>,
    /// Facets of the hull with their undeformed lengths.
    facets: Vec<([usize; 2], f64)>,
    /// Nodes of the hull, each with its longer facet.
    rim: Vec<(usize, f64)>,
    lame: [f64; 2],
    density: f64,
    neo_hookean: bool,
}

/// Quadrature and geometry of a scene.
pub struct Oracle {
    bodies: Vec<Matter>,
    walls: Vec<Wall>,
    gravity: Point,
}

impl Matter {
    fn new(body: &Body, first: usize) -> Result<Matter, MeshError> {
        let mesh = body.mesh()?;
        let points: Vec<Point> = mesh.points.iter().map(|&x| plane(x)).collect();
        let cells: Vec<[usize; 4]> = mesh.cells().map(|cell| std::array::from_fn(|a| cell[a] as usize)).collect();
        let quadrature = cells.iter().map(|cell| gauss_points(cell.map(|node| points[node]))).collect();
        let with_length = |[a, b]: [usize; 2]| ([a, b], length(subtract(points[b], points[a])));
        let facets: Vec<_> = hull(&mesh).into_iter().map(with_length).collect();
        let mut rim: Vec<(usize, f64)> = Vec::new();
        for &(ends, size) in &facets {
            for node in ends {
                match rim.iter_mut().find(|(known, _)| *known == node) {
                    Some((_, longer)) => *longer = longer.max(size),
                    None => rim.push((node, size)),
                }
            }
        }
        let [modulus, ratio, density] = body.constants;
        let lame = [modulus * ratio / ((1.0 + ratio) * (1.0 - 2.0 * ratio)), modulus / (2.0 * (1.0 + ratio))];
        Ok(Matter { first, points, cells, quadrature, facets, rim, lame, density, neo_hookean: body.law == "neo_hookean" })
    }

    /// Position (or velocity) of a node.
    fn at(&self, values: &[f64], node: usize) -> Point {
        let index = 2 * (self.first + node);
        [values[index], values[index + 1]]
    }

    fn outline(&self, positions: &[f64]) -> Outline {
        Outline::new(self.facets.iter().map(|(ends, _)| ends.map(|node| self.at(positions, node))).collect())
    }

    /// Stored energy per area of the displacement gradient.
    fn stored_energy(&self, [[xx, xy], [yx, yy]]: [[f64; 2]; 2]) -> f64 {
        let [lambda, mu] = self.lame;
        let (exx, eyy) = (xx + 0.5 * (xx * xx + yx * yx), yy + 0.5 * (yy * yy + xy * xy));
        let exy = 0.5 * (xy + yx + xx * xy + yx * yy);
        let trace = exx + eyy;
        if self.neo_hookean {
            // ln J from det C - 1, which is accurate for small strains.
            let log = 0.5 * (2.0 * trace + 4.0 * (exx * eyy - exy * exy)).ln_1p();
            mu * (trace - log) + 0.5 * lambda * log * log
        } else {
            0.5 * lambda * trace * trace + mu * (exx * exx + eyy * eyy + 2.0 * exy * exy)
        }
    }

    fn add_sums(&self, positions: &[f64], velocities: &[f64], gravity: Point, sums: &mut Sums) {
        for (cell, points) in self.cells.iter().zip(&self.quadrature) {
            let x = cell.map(|node| self.at(positions, node));
            let v = cell.map(|node| self.at(velocities, node));
            for point in points {
                let mean = |values: &[Point; 4]| (0..4).fold([0.0; 2], |sum, a| add(sum, scaled(point.shape[a], values[a])));
                let (place, velocity, mass) = (mean(&x), mean(&v), self.density * point.area);
                let mut gradient = [[0.0; 2]; 2];
                for a in 0..4 {
                    let u = subtract(x[a], self.points[cell[a]]);
                    for i in 0..2 {
                        for k in 0..2 {
                            gradient[i][k] += u[i] * point.gradients[a][k];
                        }
                    }
                }
                sums.kinetic += 0.5 * mass * dot(velocity, velocity);
                sums.strain += point.area * self.stored_energy(gradient);
                sums.potential -= mass * dot(gravity, place);
                sums.momentum = add(sums.momentum, scaled(mass, velocity));
                sums.angular_momentum += mass * cross(place, velocity);
            }
        }
    }
}

fn gauss_points(x: [Point; 4]) -> [GaussPoint; 4] {
    const CORNERS: [Point; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    CORNERS.map(|corner| {
        let [xi, eta] = scaled(1.0 / 3f64.sqrt(), corner);
        let local = CORNERS.map(|[a, b]| [0.25 * a * (1.0 + eta * b), 0.25 * b * (1.0 + xi * a)]);
        let sum = |i: usize, k: usize| (0..4).map(|a| x[a][i] * local[a][k]).sum::<f64>();
        let jacobian = [[sum(0, 0), sum(0, 1)], [sum(1, 0), sum(1, 1)]];
        let area = jacobian[0][0] * jacobian[1][1] - jacobian[0][1] * jacobian[1][0];
        let gradients =
            local.map(|[a, b]| [(a * jacobian[1][1] - b * jacobian[1][0]) / area, (b * jacobian[0][0] - a * jacobian[0][1]) / area]);
        GaussPoint { shape: CORNERS.map(|[a, b]| 0.25 * (1.0 + xi * a) * (1.0 + eta * b)), gradients, area }
    })
}

impl Oracle {
    /// # Errors
    /// Errors of the mesh generators.
    pub fn new(scene: &Scene) -> Result<Oracle, MeshError> {
        let (mut bodies, mut first) = (Vec::new(), 0);
        for body in &scene.bodies {
            let matter = Matter::new(body, first)?;
            first += matter.points.len();
            bodies.push(matter);
        }
        Ok(Oracle { bodies, walls: scene.walls.clone(), gravity: scene.gravity })
    }

    pub fn sums(&self, positions: &[f64], velocities: &[f64]) -> Sums {
        let mut sums = Sums::default();
        self.bodies.iter().for_each(|body| body.add_sums(positions, velocities, self.gravity, &mut sums));
        sums
    }

    /// Mass of all bodies.
    pub fn mass(&self) -> f64 {
        let mass = |body: &Matter| body.density * body.quadrature.iter().flatten().map(|point| point.area).sum::<f64>();
        self.bodies.iter().map(mass).sum()
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.bodies.iter().map(|body| body.cells.len()).sum()
    }

    /// Extent of the undeformed bodies in a direction.
    pub fn extent(&self, direction: Point) -> f64 {
        let heights = || self.bodies.iter().flat_map(|body| &body.points).map(|&x| dot(direction, x));
        heights().fold(f64::NEG_INFINITY, f64::max) - heights().fold(f64::INFINITY, f64::min)
    }

    /// Largest distance of an undeformed node from the origin.
    pub fn reach(&self) -> f64 {
        self.bodies.iter().flat_map(|body| &body.points).map(|&x| length(x)).fold(0.0, f64::max)
    }

    /// The node of a hull with the largest penetration in another body or a wall, or the corner of a wall with the largest penetration in a
    /// body.
    pub fn deepest(&self, positions: &[f64]) -> Depth {
        let mut deepest = Depth::default();
        let outlines: Vec<Outline> = self.bodies.iter().map(|body| body.outline(positions)).collect();
        for (a, body) in self.bodies.iter().enumerate() {
            for &(node, size) in &body.rim {
                let x = body.at(positions, node);
                for (b, outline) in outlines.iter().enumerate().filter(|(b, outline)| *b != a && outline.holds(x)) {
                    let (facet, depth) = outline.nearest(x);
                    let size = size.max(self.bodies[b].facets[facet].1);
                    deepest.raise(depth, size, || format!("node {node} of body {a} in body {b}"));
                }
                for (number, wall) in self.walls.iter().enumerate() {
                    deepest.raise(-wall.gap(x), size, || format!("node {node} of body {a} in wall {number}"));
                }
            }
            for (number, wall) in self.walls.iter().enumerate() {
                for &corner in wall.corners().iter().filter(|&&corner| outlines[a].holds(corner)) {
                    let (facet, depth) = outlines[a].nearest(corner);
                    deepest.raise(depth, body.facets[facet].1, || format!("corner {corner:?} of wall {number} in body {a}"));
                }
            }
        }
        deepest
    }

    /// The worst pair of crossing facets of different bodies: all four ends are far from the other facet. If a node has entered a body this
    /// is at most its penetration; if a body has passed through another one it is not small.
    pub fn crossing(&self, positions: &[f64]) -> Depth {
        let mut worst = Depth::default();
        let outlines: Vec<Outline> = self.bodies.iter().map(|body| body.outline(positions)).collect();
        for a in 0..outlines.len() {
            for b in 0..a {
                for (k, s) in outlines[a].segments.iter().enumerate() {
                    let apart =
                        |i: usize| s[0][i].max(s[1][i]) < outlines[b].bounds[0][i] || s[0][i].min(s[1][i]) > outlines[b].bounds[1][i];
                    if apart(0) || apart(1) {
                        continue;
                    }
                    for (l, t) in outlines[b].segments.iter().enumerate().filter(|(_, t)| segments_cross(*s, **t)) {
                        let ends = [distance(s[0], *t), distance(s[1], *t), distance(t[0], *s), distance(t[1], *s)];
                        let depth = ends.into_iter().fold(f64::INFINITY, f64::min);
                        let size = self.bodies[a].facets[k].1.max(self.bodies[b].facets[l].1);
                        worst.raise(depth, size, || format!("facet {k} of body {a} with facet {l} of body {b}"));
                    }
                }
            }
        }
        worst
    }
}
