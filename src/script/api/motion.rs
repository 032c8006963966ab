//! Motion of a finished model: translation, rotation, other units.
//!
//! While a [`Motion`] is active on the host, `simulate` moves the whole model before it builds the simulation: meshes, loads, gravity,
//! velocities, material constants, step size and time functions. The script builds its model as always (`boundary_where` sees the
//! coordinates it was written for) and keeps its own clock: `run_to`, `.time`, the history's times and time functions are those of the
//! script. Everything else that it reads is that of the moved model.

use std::sync::Arc;

use super::units::Units;
use crate::bodies::Inertia;
use crate::contact::{Obstacle, ObstacleInSpace, TurningAxis};
use crate::dynamics::{
    Amplitude, AxisRotation, Change, Coefficient, Coordinate, CouplingKind, Friction, JointDefinition, JointKind, LedgerRow, LoadKind,
    Model, ObstacleRotation, Partner, PlaceFunction, Prescription, Rescaled, Sector, Support, TimeFunction, TimeFunctionError,
};
use crate::materials::Material;
use crate::math::tolerances::QUARTER_TURN;
use crate::output::Dimension;
use crate::script::language::digits::{brief, number_text};

/// Motion of a model: `x' = length (R x + offset)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    cosine: f64,
    sine: f64,
    /// Number of quarter turns, if the rotation is a multiple of a quarter turn.
    quarters: Option<i64>,
    offset: [f64; 3],
    /// Conversion of units.
    pub units: Units,
}

/// Linear combination of other time functions, in other units of time.
struct Combined {
    terms: Vec<(f64, Amplitude)>,
    time: f64,
}

impl TimeFunction for Combined {
    fn value(&self, time: f64) -> Result<f64, TimeFunctionError> {
        self.terms.iter().try_fold(0.0, |sum, (factor, inner)| Ok(sum + factor * inner.value(time / self.time)?))
    }

    fn rate(&self, time: f64) -> Result<f64, TimeFunctionError> {
        self.terms.iter().try_fold(0.0, |sum, (factor, inner)| Ok(sum + factor / self.time * inner.rate(time / self.time)?))
    }

    fn corners(&self) -> Vec<f64> {
        self.terms.iter().flat_map(|(_, inner)| inner.corners()).map(|time| time * self.time).collect()
    }

    fn describe(&self) -> String {
        self.terms.iter().map(|(factor, inner)| format!("{} {}", brief(*factor), inner.describe())).collect::<Vec<_>>().join(" + ")
    }
}

/// Function of position in a moved model.
struct Displaced {
    inner: Arc<dyn PlaceFunction>,
    motion: Motion,
}

impl PlaceFunction for Displaced {
    fn value(&self, point: [f64; 3]) -> Result<f64, TimeFunctionError> {
        self.inner.value(self.motion.before(point))
    }

    fn describe(&self) -> String {
        self.inner.describe()
    }
}

impl Motion {
    /// Translation by a vector.
    pub fn translation(offset: [f64; 3]) -> Self {
        Motion { cosine: 1.0, sine: 0.0, quarters: Some(0), offset, units: Units::SAME }
    }

    /// Rotation about the third axis through the origin.
    pub fn rotation(angle: f64) -> Self {
        let turns = angle / std::f64::consts::FRAC_PI_2;
        // `deg(90)` differs from a quarter turn in the last bit of the conversion.
        if (turns - turns.round()).abs() < QUARTER_TURN {
            let quarters = (turns.round() as i64).rem_euclid(4);
            let (cosine, sine) = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][quarters as usize];
            return Motion { cosine, sine, quarters: Some(quarters), ..Motion::translation([0.0; 3]) };
        }
        Motion { cosine: angle.cos(), sine: angle.sin(), quarters: None, ..Motion::translation([0.0; 3]) }
    }

    /// Change of the units of a model only.
    pub fn in_units(units: Units) -> Self {
        Motion { units, ..Motion::translation([0.0; 3]) }
    }

    /// Returns true if the axis of a model of revolution, `x = 0` in the plane of its section, is mapped to itself.
    pub fn keeps_axis_of_revolution(&self) -> bool {
        self.quarters == Some(0) && self.offset[0] == 0.0
    }

    /// Vector rotated and multiplied by a factor.
    pub fn vector(&self, [x, y, z]: [f64; 3], factor: f64) -> [f64; 3] {
        [factor * (self.cosine * x - self.sine * y), factor * (self.sine * x + self.cosine * y), factor * z]
    }

    fn point(&self, point: [f64; 3]) -> [f64; 3] {
        let turned = self.vector(point, 1.0);
        [0, 1, 2].map(|i| self.units.length * (turned[i] + self.offset[i]))
    }

    /// Returns the largest distance from the origin in the moved model of points within a distance `reach` in the original model
    /// `[length]`.
    pub fn reach(&self, reach: f64) -> f64 {
        self.units.length * (reach + self.offset.iter().map(|x| x * x).sum::<f64>().sqrt())
    }

    /// Returns the original position of a moved point.
    fn before(&self, point: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = [0, 1, 2].map(|i| point[i] / self.units.length - self.offset[i]);
        [self.cosine * x + self.sine * y, self.cosine * y - self.sine * x, z]
    }

    /// Factor of energies: per thickness in the plane; of the whole circumference for bodies of revolution, with `dimension` 3.
    pub fn energy(&self, dimension: usize) -> f64 {
        self.units.stress() * self.units.length.powi(dimension as i32)
    }

    /// Mass and inertia of a moved rigid body.
    fn inertia(&self, inertia: &Inertia, dimension: usize) -> Inertia {
        let (units, transposed) = (&self.units, |rows: [[f64; 3]; 3]| [0, 1, 2].map(|i| [0, 1, 2].map(|j| rows[j][i])));
        let mass = self.energy(dimension) * (units.time / units.length).powi(2);
        let turned = transposed(inertia.euler.map(|row| self.vector(row, 1.0))).map(|row| self.vector(row, mass * units.length.powi(2)));
        Inertia { mass: mass * inertia.mass, center: self.point(inertia.center), euler: turned }
    }

    /// Returns the moved model.
    ///
    /// # Errors
    /// A part of the model that cannot be moved in this way; the text gives the reason.
    pub fn model(&self, model: &Model) -> Result<Model, String> {
        let mut moved = model.clone();
        let (units, dimension) = (&self.units, model.dimension());
        let speed = units.length / units.time;
        // Forces and masses of bodies of revolution are those of the whole circumference.
        let of_energy = if model.is_axisymmetric() { 3 } else { dimension };
        for body in &mut moved.bodies {
            let mut mesh = (*body.mesh).clone();
            mesh.points.iter_mut().for_each(|point| *point = self.point(*point));
            body.mesh = Arc::new(mesh);
            body.material = self.material(&body.material)?;
            body.rigid = body.rigid.map(|inertia| self.inertia(&inertia, dimension));
        }
        let coordinates: Vec<Option<Coordinate>> = model.joints.iter().map(|joint| joint.kind.coordinate(dimension)).collect();
        for joint in &mut moved.joints {
            self.join(joint, dimension, self.energy(of_energy));
            if let JointKind::Gear(gear) = &mut joint.kind {
                let [first, second] = gear.joints.map(|index| coordinates[index].map_or(0, Coordinate::lengths));
                gear.ratio *= units.length.powi(first - second);
            }
        }
        moved.couplings.iter_mut().for_each(|coupling| self.couple(&mut coupling.kind));
        moved.gravity = self.vector(model.gravity, speed / units.time);
        moved.gravity_amplitude = model.gravity_amplitude.as_ref().map(|amplitude| self.amplitude(amplitude, 1.0));
        for initial in &mut moved.initial_displacements {
            initial.displacement.iter_mut().for_each(|u| *u = self.vector(*u, units.length));
        }
        for velocity in &mut moved.initial_velocities {
            velocity.linear = self.vector(velocity.linear, speed);
            velocity.angular = self.vector(velocity.angular, 1.0 / units.time);
        }
        moved.supports.iter_mut().try_for_each(|support| self.support(model, support))?;
        moved.prescriptions = model.prescriptions.iter().map(|given| self.prescription(model, given)).collect::<Result<_, _>>()?;
        let force = units.stress() * units.length.powi(of_energy as i32 - 1);
        for load in &mut moved.loads {
            let mut size = 1.0;
            match &mut load.kind {
                LoadKind::Traction(vector) => *vector = self.vector(*vector, units.stress()),
                LoadKind::Force(vector) => *vector = self.vector(*vector, force),
                LoadKind::Pressure(pressure) => *pressure *= units.stress(),
                LoadKind::Torque(axis) => {
                    *axis = if dimension == 3 { self.vector(*axis, 1.0) } else { *axis };
                    size = self.energy(of_energy);
                }
            }
            load.amplitude = self.amplitude(&load.amplitude, size);
        }
        for interaction in &mut moved.interactions {
            match &mut interaction.partner {
                Partner::Surfaces(_) | Partner::Itself => {}
                Partner::Obstacle { shape, motion, turn } => {
                    *shape = self.obstacle(shape);
                    *turn = turn.as_ref().map(|turn| self.turn(turn));
                    *motion = self.along(motion.each_ref());
                }
                Partner::Tied { reach, .. } => *reach = reach.map(|reach| units.length * reach),
            }
            if let Some(Friction { law, coefficient }) = &mut interaction.friction {
                *law = law.in_units(units.stress(), speed);
                *coefficient = self.coefficient(coefficient);
            }
        }
        let change = Change {
            point: &|point| self.point(point),
            direction: &|vector| self.vector(vector, 1.0),
            units: [units.mass, units.length, units.time],
            is_plane: of_energy == 2,
        };
        moved.parts = model.parts.iter().map(|part| part.changed(&change)).collect();
        Ok(moved)
    }

    fn turn(&self, ObstacleRotation { angle, about }: &ObstacleRotation) -> ObstacleRotation {
        let axis = |axis: &TurningAxis| TurningAxis::new(self.point(axis.center), self.vector(axis.direction, 1.0));
        ObstacleRotation { angle: self.amplitude(angle, 1.0), about: about.as_ref().map(axis) }
    }

    fn join(&self, joint: &mut JointDefinition, dimension: usize, energy: f64) {
        let units = &self.units;
        joint.kind = joint.kind.along(|direction| self.vector(direction, 1.0));
        joint.ends.iter_mut().for_each(|end| end.point = self.point(end.point));
        let scale = joint.kind.coordinate(dimension).map_or(1.0, |coordinate| units.length.powi(coordinate.lengths()));
        joint.drive = joint.drive.as_ref().map(|drive| self.amplitude(drive, scale));
        joint.limits = joint.limits.map(|limits| limits.map(|limit| scale * limit));
        if let Some(friction) = &mut joint.friction {
            friction.radius *= units.length;
            friction.preload *= energy / units.length;
            friction.constant *= energy / scale;
        }
        if let JointKind::Cable(longest) = &mut joint.kind {
            *longest *= units.length;
        }
    }

    fn support(&self, model: &Model, support: &mut Support) -> Result<(), String> {
        let [x, y, _] = support.components;
        if x != y {
            let quarters = self.quarters.ok_or_else(|| oblique(&format!("the support of \"{}\"", model.boundary_name(&support.on))))?;
            if quarters % 2 == 1 {
                support.components.swap(0, 1);
            }
        }
        Ok(())
    }

    fn couple(&self, kind: &mut CouplingKind) {
        match kind {
            CouplingKind::Plane { normal, .. } => *normal = self.vector(*normal, 1.0),
            CouplingKind::Periodic { turn, offset, .. } => {
                *turn = turn.map(|turn| Sector { center: self.point(turn.center), axis: self.vector(turn.axis, 1.0), angle: turn.angle });
                *offset = self.along(offset.each_ref());
            }
            CouplingKind::Reference { .. } => {}
        }
    }

    fn coefficient(&self, coefficient: &Coefficient) -> Coefficient {
        match coefficient {
            Coefficient::Constant(value) => Coefficient::Constant(*value),
            Coefficient::OverTime(function) => Coefficient::OverTime(self.amplitude(function, 1.0)),
            Coefficient::OverPlace(inner) => Coefficient::OverPlace(Arc::new(Displaced { inner: inner.clone(), motion: *self })),
        }
    }

    fn obstacle(&self, obstacle: &Obstacle) -> Obstacle {
        let point = |[x, y]: [f64; 2]| {
            let [x, y, _] = self.point([x, y, 0.0]);
            [x, y]
        };
        let length = self.units.length;
        match obstacle {
            Obstacle::HalfPlane { point: on, normal: [x, y] } => {
                let [x, y, _] = self.vector([*x, *y, 0.0], 1.0);
                Obstacle::HalfPlane { point: point(*on), normal: [x, y] }
            }
            Obstacle::Disk { center, radius } => Obstacle::Disk { center: point(*center), radius: length * radius },
            Obstacle::Ring { center, radius } => Obstacle::Ring { center: point(*center), radius: length * radius },
            Obstacle::Polyline { points } => Obstacle::Polyline { points: points.iter().map(|&at| point(at)).collect() },
            Obstacle::InSpace(shape) => Obstacle::InSpace(self.obstacle_in_space(shape)),
        }
    }

    fn obstacle_in_space(&self, obstacle: &ObstacleInSpace) -> ObstacleInSpace {
        let (length, at, along) = (self.units.length, |point: &[f64; 3]| self.point(*point), |vector: &[f64; 3]| self.vector(*vector, 1.0));
        match obstacle {
            ObstacleInSpace::Plane { point, normal } => ObstacleInSpace::Plane { point: at(point), normal: along(normal) },
            ObstacleInSpace::Sphere { center, radius, axis, is_hollow } => {
                ObstacleInSpace::Sphere { center: at(center), radius: length * radius, axis: along(axis), is_hollow: *is_hollow }
            }
            ObstacleInSpace::Cylinder { point, axis, radius, is_hollow } => {
                ObstacleInSpace::Cylinder { point: at(point), axis: along(axis), radius: length * radius, is_hollow: *is_hollow }
            }
            ObstacleInSpace::FiniteCylinder { center, axis, radius, length: long, edge } => {
                let [radius, long, edge] = [radius, long, edge].map(|size| length * size);
                ObstacleInSpace::FiniteCylinder { center: at(center), axis: along(axis), radius, length: long, edge }
            }
            ObstacleInSpace::Cone { tip, axis, angle, is_hollow } => {
                ObstacleInSpace::Cone { tip: at(tip), axis: along(axis), angle: *angle, is_hollow: *is_hollow }
            }
            ObstacleInSpace::Torus { center, axis, radius, tube, is_hollow } => {
                let (radius, tube) = (length * radius, length * tube);
                ObstacleInSpace::Torus { center: at(center), axis: along(axis), radius, tube, is_hollow: *is_hollow }
            }
            ObstacleInSpace::Facets(facets) => {
                // A rigid motion keeps the facets valid.
                let moved = facets.mapped(|point| self.point(point));
                ObstacleInSpace::Facets(moved.map_or_else(|_| facets.clone(), Arc::new))
            }
        }
    }

    /// Displacements over time along the axes.
    fn along(&self, displacement: [&Option<Amplitude>; 3]) -> [Option<Amplitude>; 3] {
        let turned = |factors: [f64; 3]| -> Option<Amplitude> {
            let terms = factors.into_iter().zip(displacement).filter(|(factor, _)| *factor != 0.0);
            let terms: Vec<_> = terms.filter_map(|(factor, inner)| Some((self.units.length * factor, inner.clone()?))).collect();
            match &terms[..] {
                [] => None,
                [(factor, inner)] => Some(self.amplitude(inner, *factor)),
                _ => Some(Arc::new(Combined { terms, time: self.units.time })),
            }
        };
        [turned([self.cosine, -self.sine, 0.0]), turned([self.sine, self.cosine, 0.0]), turned([0.0, 0.0, 1.0])]
    }

    fn amplitude(&self, inner: &Amplitude, value: f64) -> Amplitude {
        Rescaled::of(inner, self.units.time, value)
    }

    fn prescription(&self, model: &Model, given: &Prescription) -> Result<Prescription, String> {
        let [x, y, z] = &given.displacement;
        // A rotation other than by quarter turns mixes the directions, so both must be prescribed or both free.
        if given.turn.is_none() && x.is_some() != y.is_some() && self.quarters.is_none() {
            return Err(oblique(&format!("the prescribed displacement of \"{}\"", model.boundary_name(&given.on))));
        }
        let [x, y, z] = self.along([x, y, z]);
        let turn = given.turn.as_ref().map(|AxisRotation { center, axis, angle }| AxisRotation {
            center: self.point(*center),
            axis: self.vector(*axis, 1.0),
            angle: self.amplitude(angle, 1.0),
        });
        Ok(Prescription { on: given.on.clone(), displacement: [x, y, z], turn })
    }

    fn material(&self, material: &Material) -> Result<Material, String> {
        let turned = material.turned(self.cosine, self.sine).map_err(|error| error.to_string())?;
        if self.units == Units::SAME {
            return Ok(turned);
        }
        turned.rescaled(|dimension| Dimension::parse(dimension).map(|dimension| self.units.factor(dimension)))
    }

    /// Row of the ledger with its times converted to the units of the script.
    pub fn on_script_clock(&self, row: LedgerRow) -> LedgerRow {
        LedgerRow { time: row.time / self.units.time, dt: row.dt / self.units.time, ..row }
    }

    /// Describes the motion in words, such as `turned by 0.5 rad`.
    pub fn describe(&self) -> String {
        if self.units != Units::SAME {
            let Units { mass, length, time } = self.units;
            let numbers = [mass, length, time].map(number_text);
            return format!("in other units (mass x {}, length x {}, time x {})", numbers[0], numbers[1], numbers[2]);
        }
        if self.offset != [0.0; 3] {
            return format!("moved by [{}]", self.offset.map(number_text).join(", "));
        }
        format!("turned by {} rad", brief(self.sine.atan2(self.cosine)))
    }
}

fn oblique(what: &str) -> String {
    format!("{what} is along one axis only, so the scenario can only be turned by quarters: `rotate: deg(90)`")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarter_turns_are_exact_and_others_are_rotations() {
        assert_eq!(Motion::rotation(90.0_f64.to_radians()).vector([1.0, 2.0, 3.0], 2.0), [-4.0, 2.0, 6.0]);
        assert_eq!(Motion::rotation(-90.0_f64.to_radians()).vector([1.0, 2.0, 3.0], 1.0), [2.0, -1.0, 3.0]);
        let [x, y, _] = Motion::rotation(0.5).vector([1.0, 0.0, 0.0], 1.0);
        assert!((x - 0.5_f64.cos()).abs() < 1e-16 && (y - 0.5_f64.sin()).abs() < 1e-16);
    }
}
