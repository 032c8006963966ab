//! Random scenes as plain data, and oracles that are independent of the kernels.
//!
//! A [`Scene`] contains the data of a script: shapes, places, constants, velocities, walls. It can be converted to a model of the kernels
//! ([`Scene::model`]), to a script ([`Scene::script`]), to its mirror image and to a rotated scene. [`run`](run::run) computes it and
//! evaluates after every nominal step only positions and velocities: energy, momenta, penetration.
//!
//! Bodies are numbered in their order; the whole hull of each body is in contact with all earlier bodies and with every wall.

// Each program uses a part of this file.
#![allow(dead_code)]

pub mod geometry;
pub mod obstacles;
pub mod oracle;
pub mod random;
pub mod run;
pub mod script;
pub mod shrink;

use std::sync::Arc;

use conserva::contact::{ContactMethod, Coulomb, Obstacle};
use conserva::dynamics::{BodyBoundary, BodyDefinition, Coefficient, Friction, InitialVelocity, Interaction, Model, Partner, UpdateRule};
use conserva::mesh::{Boundary, Mesh, MeshError, disk, polygon, rectangle, ring};

use self::geometry::{Outline, Point, add, cross, distance, dot, length, subtract, turned};
use crate::common::material;

/// Shape of a body with its mesh, around the origin.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Width and height, cells along them.
    Rectangle { size: [f64; 2], cells: [usize; 2] },
    /// Layers and cells around.
    Disk { radius: f64, cells: [usize; 2] },
    /// Inner and outer radius, cells along the radius and around.
    Ring { radii: [f64; 2], cells: [usize; 2] },
    /// Corners and length of the cells' edges.
    Polygon { corners: Vec<Point>, size: f64 },
}

/// A deformable body.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    pub shape: Shape,
    /// True if the shape is mirrored at the y axis before its rotation.
    pub mirrored: bool,
    /// Rotation angle about the origin before the translation.
    pub angle: f64,
    /// Translation of the origin, after the rotation.
    pub center: Point,
    /// Name of the row of the material.
    pub law: &'static str,
    /// Young's modulus, Poisson's ratio, density.
    pub constants: [f64; 3],
    pub velocity: Point,
    pub spin: f64,
}

/// A rigid obstacle at rest.
#[derive(Clone, Debug, PartialEq)]
pub enum Wall {
    /// Bodies are on the side of the normal.
    Plane { point: Point, normal: Point },
    /// Bodies are outside.
    Disk { center: Point, radius: f64 },
    /// Bodies are inside.
    Ring { center: Point, radius: f64 },
    /// The obstacle is on the left; the polyline is open, and bodies do not reach its ends.
    Polyline { points: Vec<Point> },
}

/// Type of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Bodies fly freely into each other.
    Collision,
    /// Bodies in a deformable ring.
    Nested,
    /// Bodies between four rigid planes.
    Box,
    /// Bodies in a rigid ring.
    FiniteCylinder,
    /// Bodies fall on a plane, a hill or a landscape.
    Fall,
    /// Bodies one on another.
    Stack,
    /// Very different facet sizes and stiffnesses.
    Extreme,
}

/// All data of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    pub seed: u64,
    pub kind: Kind,
    pub bodies: Vec<Body>,
    pub walls: Vec<Wall>,
    pub gravity: Point,
    pub method: &'static ContactMethod,
    pub rule: &'static UpdateRule,
    /// Friction coefficient of all contacts; 0: none.
    pub friction: f64,
    pub dt: f64,
    pub steps: usize,
}

impl Body {
    /// Mesh of the body at its place.
    ///
    /// # Errors
    /// Errors of the mesh generators.
    pub fn mesh(&self) -> Result<Mesh, MeshError> {
        let mut mesh = match &self.shape {
            Shape::Rectangle { size, cells } => rectangle(*size, *cells, [-0.5 * size[0], -0.5 * size[1]])?,
            Shape::Disk { radius, cells } => disk(*radius, *cells, [0.0; 2])?,
            Shape::Ring { radii, cells } => ring(radii[0], radii[1], *cells, [0.0; 2], 0.0)?,
            Shape::Polygon { corners, size } => polygon(corners, &[], *size, &vec!["side".to_string(); corners.len()])?,
        };
        if self.mirrored {
            mesh.points.iter_mut().for_each(|point| point[0] = -point[0]);
            mesh.blocks[0].connectivity.chunks_exact_mut(4).for_each(|cell| cell.swap(1, 3));
        }
        mesh.boundaries.clear();
        mesh.rotate(self.angle, [0.0; 3])?.translate([self.center[0], self.center[1], 0.0])
    }

    /// Hull of the undeformed body.
    ///
    /// # Errors
    /// As for the mesh.
    pub fn outline(&self) -> Result<Outline, MeshError> {
        let mesh = self.mesh()?;
        Ok(Outline::new(hull(&mesh).into_iter().map(|facet| facet.map(|node| plane(mesh.points[node]))).collect()))
    }

    /// Speed of pressure waves.
    pub fn wave_speed(&self) -> f64 {
        let [modulus, ratio, density] = self.constants;
        (modulus * (1.0 - ratio) / ((1.0 + ratio) * (1.0 - 2.0 * ratio) * density)).sqrt()
    }
}

/// Nodes of all facets of the hull, with the body on the left.
pub fn hull(mesh: &Mesh) -> Vec<[usize; 2]> {
    let ends = |facet| {
        let mut nodes = mesh.facet_nodes(facet).map(|node| node as usize);
        [nodes.next().expect("a facet has two nodes"), nodes.next().expect("a facet has two nodes")]
    };
    mesh.hull().into_iter().map(ends).collect()
}

/// The first two coordinates.
pub fn plane(x: [f64; 3]) -> Point {
    [x[0], x[1]]
}

impl Wall {
    /// Signed distance of a point, negative inside.
    pub fn gap(&self, x: Point) -> f64 {
        match self {
            Wall::Plane { point, normal } => dot(*normal, subtract(x, *point)) / length(*normal),
            Wall::Disk { center, radius } => length(subtract(x, *center)) - radius,
            Wall::Ring { center, radius } => radius - length(subtract(x, *center)),
            Wall::Polyline { points } => {
                // If the nearest point is a corner, the side is that of the facet whose line is farther away.
                let mut nearest = (f64::INFINITY, 0.0f64);
                for pair in points.windows(2) {
                    let d = distance(x, [pair[0], pair[1]]);
                    let side = subtract(pair[1], pair[0]);
                    let height = -cross(side, subtract(x, pair[0])) / length(side);
                    let same = (d - nearest.0).abs() <= 1e-12 * (1.0 + d);
                    if (same && height.abs() > nearest.1.abs()) || (!same && d < nearest.0) {
                        nearest = (d, height);
                    }
                }
                nearest.0.copysign(nearest.1)
            }
        }
    }

    /// Corners of the wall that could enter a body.
    pub fn corners(&self) -> &[Point] {
        match self {
            Wall::Polyline { points } => &points[1..points.len() - 1],
            _ => &[],
        }
    }

    /// Distance of a body from the wall; 0 if they overlap.
    pub fn clearance(&self, outline: &Outline) -> f64 {
        let least = outline.corners().map(|x| self.gap(x)).fold(f64::INFINITY, f64::min);
        let peaks = self.corners().iter().map(|&x| if outline.holds(x) { 0.0 } else { outline.nearest(x).1 });
        let least = peaks.fold(least, f64::min);
        let near = match self {
            // The middle of a straight side is nearer to a disk than its ends.
            Wall::Disk { center, radius } => outline.nearest(*center).1 - radius,
            _ => least,
        };
        near.min(least).max(0.0)
    }

    fn obstacle(&self) -> Obstacle {
        match self.clone() {
            Wall::Plane { point, normal } => Obstacle::HalfPlane { point, normal },
            Wall::Disk { center, radius } => Obstacle::Disk { center, radius },
            Wall::Ring { center, radius } => Obstacle::Ring { center, radius },
            Wall::Polyline { points } => Obstacle::Polyline { points },
        }
    }

    fn mapped(&self, place: impl Fn(Point) -> Point, direction: impl Fn(Point) -> Point) -> Wall {
        match self {
            Wall::Plane { point, normal } => Wall::Plane { point: place(*point), normal: direction(*normal) },
            Wall::Disk { center, radius } => Wall::Disk { center: place(*center), radius: *radius },
            Wall::Ring { center, radius } => Wall::Ring { center: place(*center), radius: *radius },
            Wall::Polyline { points } => Wall::Polyline { points: points.iter().map(|&point| place(point)).collect() },
        }
    }
}

impl Scene {
    /// The scene with another method and rule.
    pub fn with(mut self, method: &'static ContactMethod, rule: &'static UpdateRule) -> Scene {
        (self.method, self.rule) = (method, rule);
        self
    }

    /// The scene with friction.
    pub fn with_friction(self, friction: f64) -> Scene {
        Scene { friction, ..self }
    }

    /// Friction of the scene in the form of a contact.
    fn friction(&self) -> Option<Friction> {
        let law = || Friction { law: Arc::new(Coulomb::default()), coefficient: Coefficient::Constant(self.friction) };
        (self.friction > 0.0).then(law)
    }

    /// Mirror image at the y axis.
    pub fn mirrored(&self) -> Scene {
        let flip = |[x, y]: Point| [-x, y];
        let mut scene = self.clone();
        for body in &mut scene.bodies {
            body.mirrored = !body.mirrored;
            (body.angle, body.center, body.velocity, body.spin) = (-body.angle, flip(body.center), flip(body.velocity), -body.spin);
        }
        for wall in &mut scene.walls {
            *wall = wall.mapped(flip, flip);
            if let Wall::Polyline { points } = wall {
                points.reverse();
            }
        }
        scene.gravity = flip(scene.gravity);
        scene
    }

    /// The scene turned about the origin.
    pub fn turned(&self, angle: f64) -> Scene {
        let turn = |x: Point| turned(angle, x);
        let mut scene = self.clone();
        for body in &mut scene.bodies {
            (body.angle, body.center, body.velocity) = (body.angle + angle, turn(body.center), turn(body.velocity));
        }
        scene.walls = self.walls.iter().map(|wall| wall.mapped(turn, turn)).collect();
        scene.gravity = turn(scene.gravity);
        scene
    }

    /// The scene without motion and gravity.
    pub fn at_rest(&self) -> Scene {
        let mut scene = self.clone();
        scene.bodies.iter_mut().for_each(|body| (body.velocity, body.spin) = ([0.0; 2], 0.0));
        scene.gravity = [0.0; 2];
        scene
    }

    /// Hulls of all undeformed bodies.
    ///
    /// # Errors
    /// Errors of the mesh generators.
    pub fn outlines(&self) -> Result<Vec<Outline>, MeshError> {
        self.bodies.iter().map(Body::outline).collect()
    }

    /// True if no bodies overlap at the start.
    pub fn is_free_of_overlap(&self) -> bool {
        let Ok(outlines) = self.outlines() else { return false };
        let apart = |k: usize| outlines[..k].iter().all(|other| outlines[k].clearance(other) > 0.0);
        (0..outlines.len()).all(|k| apart(k) && self.walls.iter().all(|wall| wall.clearance(&outlines[k]) > 0.0))
    }

    /// The model of the kernels.
    ///
    /// # Errors
    /// Errors of the mesh generators.
    pub fn model(&self) -> Result<Model, MeshError> {
        let mut model = Model { name: format!("scene {}", self.seed), ..Model::default() };
        model.gravity = [self.gravity[0], self.gravity[1], 0.0];
        let mut hulls = Vec::new();
        for (k, body) in self.bodies.iter().enumerate() {
            let mut mesh = body.mesh()?;
            let boundary = Boundary::of_facets("hull", mesh.hull());
            mesh.boundaries.push(boundary.clone());
            hulls.push(BodyBoundary { body: k, boundary });
            let material = material(body.law, body.constants);
            model.bodies.push(BodyDefinition {
                name: format!("body {k}"),
                mesh: Arc::new(mesh),
                material,
                formulation: Default::default(),
                rigid: None,
            });
            let [x, y] = body.velocity;
            model.initial_velocities.push(InitialVelocity { body: k, linear: [x, y, 0.0], angular: [0.0, 0.0, body.spin] });
        }
        for k in 0..hulls.len() {
            if k > 0 {
                let partner = Partner::Surfaces(hulls[..k].to_vec());
                let pair = Interaction::new(&format!("contact {k}"), hulls[k].clone(), partner);
                model.add_interaction(Interaction { method: self.method, update: Some(self.rule), friction: self.friction(), ..pair });
            }
            for (number, wall) in self.walls.iter().enumerate() {
                let name = format!("wall {number} and body {k}");
                let pair = Interaction::obstacle(&name, hulls[k].clone(), wall.obstacle());
                model.add_interaction(Interaction { update: Some(self.rule), friction: self.friction(), ..pair });
            }
        }
        Ok(model)
    }

    /// Magnitude of gravity.
    pub fn gravity_size(&self) -> f64 {
        length(self.gravity)
    }

    /// The scene translated.
    pub fn moved(&self, offset: Point) -> Scene {
        let mut scene = self.clone();
        scene.bodies.iter_mut().for_each(|body| body.center = add(body.center, offset));
        scene.walls = self.walls.iter().map(|wall| wall.mapped(|x| add(x, offset), |normal| normal)).collect();
        scene
    }
}
