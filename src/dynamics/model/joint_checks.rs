//! Checks of joints and rigid bodies, and scales of models with them.

use super::definitions::{BodyDefinition, Model};
use super::error::ModelError;
use super::joints::{Anchor, Coordinate, Gear, JointDefinition, JointKind};
use crate::bodies::{BarycentricMap, Plane};
use crate::integrators::Scheme;
use crate::math::digits::three_digits;
use crate::math::norms::{diameter, length};
use crate::math::tolerances;

const GEAR_REMEDY: &str =
    "couple the angles or travels of two joints of rigid bodies: hinges (in the plane of the kind \"point\"), sliders, slots";

const NODE_REMEDY: &str = "tie a boundary of the body that deforms to the other body, which holds all directions, or join nodes by points, \
                           links and cables";

const DRIVE_REMEDY: &str = "what a drive prescribes begins with what the joint is at rest, 0 for angles and travels, and limits contain \
                            that; hinges have an angle, sliders and slots a travel, links and cables a distance";

const FRICTION_REMEDY: &str = "hinges and balls (of the kind \"point\"), sliders, slots, links with limits or a drive, and cables have \
                               friction; for other motions use a damper beside the joint";

impl Model {
    /// Node of a body nearest to a point in the initial configuration, and its distance `[length]`.
    pub fn nearest_node(&self, body: usize, point: [f64; 3]) -> (u32, f64) {
        let distance = |at: [f64; 3]| length(std::array::from_fn(|i| at[i] - point[i]));
        let all = (0..).zip(self.start(body).into_iter().map(distance));
        all.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, f64::INFINITY))
    }

    /// Modulus that relates forces to gaps at a body: its own, or for a rigid body that of the stiffest deformable body. In models of rigid
    /// bodies only it follows from their weight or, without gravity, their inertia.
    pub fn modulus(&self, body: usize) -> f64 {
        let own = |body: &BodyDefinition| if body.rigid.is_some() { 0.0 } else { body.material.youngs_modulus() };
        let (own, stiffest) = (own(&self.bodies[body]), self.bodies.iter().map(own).fold(0.0, f64::max));
        let modulus = if own > 0.0 { own } else { stiffest };
        if modulus > 0.0 {
            return modulus;
        }
        let mass = self.bodies.iter().filter_map(|body| body.rigid.map(|inertia| inertia.mass)).fold(0.0, f64::max);
        let extent = self.extent();
        let speed = self.initial_velocities.iter().map(|given| length(given.linear) + extent * length(given.angular)).fold(0.0, f64::max);
        let acceleration = length(self.gravity) + speed * speed / extent;
        mass * if acceleration > 0.0 { acceleration } else { 1.0 } / extent.powi(self.dimension() as i32 - 1)
    }

    /// True if a joint connects two bodies, which may then overlap at the joint.
    pub(crate) fn are_joined(&self, first: usize, second: usize) -> bool {
        let joins = |joint: &JointDefinition, body: usize| self.joints_of(joint).any(|joint| joint.bodies().any(|other| other == body));
        self.joints.iter().any(|joint| joins(joint, first) && joins(joint, second))
    }

    /// The two joints of a gear, or the joint itself.
    pub fn joints_of<'a>(&'a self, joint: &'a JointDefinition) -> impl Iterator<Item = &'a JointDefinition> {
        let coupled = match joint.kind {
            JointKind::Gear(gear) => gear.joints.map(|index| self.joints.get(index)),
            _ => [Some(joint), None],
        };
        coupled.into_iter().flatten()
    }

    /// Size of the undeformed bodies together, whatever their orientation `[length]`.
    pub fn extent(&self) -> f64 {
        diameter(self.bodies.iter().flat_map(|body| &body.mesh.points))
    }

    /// Checks rigid bodies and joints.
    pub(super) fn check_joints(&self) -> Result<(), ModelError> {
        for (index, body) in self.bodies.iter().enumerate().filter(|(_, body)| body.rigid.is_some()) {
            body.check_rigid()?;
            if self.initial_displacements.iter().any(|initial| initial.body == index) {
                return Err(ModelError::NotRigid { body: body.name.clone(), reason: "it cannot start with displacements".into() });
            }
        }
        for (index, joint) in self.joints.iter().enumerate() {
            let of_parts = self.parts.iter().map(|part| part.name()).chain(self.contact_names());
            if self.joints[..index].iter().map(|other| other.name.as_str()).chain(of_parts).any(|name| name == joint.name) {
                return Err(ModelError::DuplicateName { what: "joint", name: joint.name.clone() });
            }
            self.check_joint(joint)?;
            if let JointKind::Gear(gear) = &joint.kind {
                self.check_gear(index, gear)?;
            }
        }
        Ok(())
    }

    /// Checks the gear with the index `index` among the joints.
    fn check_gear(&self, index: usize, gear: &Gear) -> Result<(), ModelError> {
        let unsound =
            |reason: String| Err(ModelError::Unsound { what: "gear", name: self.joints[index].name.clone(), reason, remedy: GEAR_REMEDY });
        if !(gear.ratio.is_finite() && gear.ratio != 0.0) {
            return unsound(format!("the ratio {} couples nothing", gear.ratio));
        }
        let [first, second] = gear.joints;
        if first == second || first.max(second) >= index {
            return unsound("it couples two joints that were added before it".into());
        }
        let coupled = [&self.joints[first], &self.joints[second]];
        for joint in coupled {
            if !matches!(joint.kind.coordinate(self.dimension()), Some(Coordinate::Angle | Coordinate::Travel)) {
                return unsound(format!("joint \"{}\" is a {}, which has neither an angle nor a travel", joint.name, joint.kind.name()));
            }
            self.check_directions(joint).or_else(unsound)?;
        }
        match coupled.iter().all(|joint| joint.drive.is_some()) {
            true => unsound(format!("joints \"{}\" and \"{}\" are both driven", coupled[0].name, coupled[1].name)),
            false => Ok(()),
        }
    }

    /// Checks that both ends of a joint that rotates have directions.
    fn check_directions(&self, joint: &JointDefinition) -> Result<(), String> {
        let deforms = |end: &&Anchor| end.body.is_some_and(|body| self.bodies[body].rigid.is_none());
        match (joint.kind.rotates(self.dimension()), joint.ends.iter().find(deforms)) {
            (true, Some(end)) => {
                let body = end.body.map_or("", |body| &self.bodies[body].name);
                Err(format!("an angle needs directions, and a node of body \"{body}\", which deforms, has none"))
            }
            _ => Ok(()),
        }
    }

    fn check_joint(&self, joint: &JointDefinition) -> Result<(), ModelError> {
        let name = || joint.name.clone();
        let unsound = |reason: String| Err(ModelError::UnsoundJoint { joint: name(), reason });
        match joint.ends.map(|end| end.body) {
            [None, None] => return unsound("it joins the ground to itself".into()),
            [Some(a), Some(b)] if a == b => return unsound(format!("it joins body \"{}\" to itself", self.bodies[a].name)),
            _ => {}
        }
        if let Some(direction) = joint.kind.direction() {
            let size = length(direction);
            if !(size.is_finite() && size > 0.0) {
                return unsound(format!("the direction {direction:?} has no length"));
            }
            if self.dimension() == 2 && matches!(joint.kind, JointKind::Hinge(_)) {
                return unsound("a hinge about an axis is one in space; in the plane a point joint is a hinge".into());
            }
        }
        for (k, end) in joint.ends.iter().enumerate() {
            let Some(body) = end.body.map(|body| &self.bodies[body]) else { continue };
            if body.rigid.is_none() && joint.kind.turns(k) {
                let (kind, name) = (joint.kind.name(), joint.name.clone());
                let reason = format!("a {kind} needs directions, and a node of body \"{}\", which deforms, has none", body.name);
                return Err(ModelError::Unsound { what: "joint", name, reason, remedy: NODE_REMEDY });
            }
        }
        let apart = self.apart(joint);
        if apart > tolerances::JOINT_APART * self.extent() {
            return Err(ModelError::JointApart { joint: name(), place: joint.ends[0].point, distance: apart });
        }
        if let JointKind::Cable(longest) = joint.kind
            && !(longest.is_finite() && longest > 0.0)
        {
            return unsound(format!("a cable has a length, and this one has {longest}"));
        }
        self.check_coordinate(joint)?;
        self.check_friction(joint)?;
        if joint.kind == JointKind::Link && length(joint.distance()) <= tolerances::JOINT_APART * self.extent() {
            return unsound("both of its points are the same, and a link has a length".into());
        }
        Ok(())
    }

    /// Checks the friction of a joint.
    fn check_friction(&self, joint: &JointDefinition) -> Result<(), ModelError> {
        let unsound =
            |reason: String| Err(ModelError::Unsound { what: "joint", name: joint.name.clone(), reason, remedy: FRICTION_REMEDY });
        let Some(friction) = &joint.friction else { return Ok(()) };
        let (kind, rotates) = (joint.kind.name(), joint.kind.rotates(self.dimension()));
        let is_distance = joint.kind.coordinate(self.dimension()) == Some(Coordinate::Distance);
        if !rotates && joint.kind.coordinate(self.dimension()).is_none() {
            return unsound(format!("it has friction, and a {kind} has no free motion of its own"));
        }
        if joint.kind == JointKind::Link && joint.limits.is_none() && joint.drive.is_none() {
            return unsound("it has friction, and a link without limits and drive keeps its length".into());
        }
        self.check_directions(joint).or_else(unsound)?;
        let values = [friction.coefficient, friction.radius, friction.preload, friction.constant];
        if let Some(value) = values.into_iter().find(|value| !(value.is_finite() && *value >= 0.0)) {
            return unsound(format!("its friction has the value {value}, and all of them are finite and not negative"));
        }
        if is_distance && friction.coefficient > 0.0 && friction.preload == 0.0 {
            return unsound(format!("its friction coefficient acts on nothing: a {kind} has no reaction across its line, and no preload"));
        }
        if rotates && friction.coefficient > 0.0 && friction.radius == 0.0 {
            return unsound("its friction coefficient has no lever arm: the radius of the bearing is 0".into());
        }
        Ok(())
    }

    /// Checks the drive or the limits of a joint.
    fn check_coordinate(&self, joint: &JointDefinition) -> Result<(), ModelError> {
        let unsound = |reason: String| Err(ModelError::Unsound { what: "joint", name: joint.name.clone(), reason, remedy: DRIVE_REMEDY });
        let what = match (&joint.drive, &joint.limits) {
            (None, None) => return Ok(()),
            (Some(_), Some(_)) => return unsound("it has a drive and limits, and a drive leaves nothing to limit".into()),
            (Some(_), None) => "drive",
            (None, Some(_)) => "limit",
        };
        let (kind, dimension) = (joint.kind.name(), self.dimension());
        let Some(coordinate) = joint.kind.coordinate(dimension) else {
            let left = if joint.kind == JointKind::Weld { "nothing" } else { "turning about a point in space, which is no single angle" };
            return unsound(format!("there is nothing to {what}: a {kind} leaves {left}"));
        };
        self.check_directions(joint).or_else(unsound)?;
        let (rest, name) = (joint.at_rest(), coordinate.name());
        if let Some(drive) = &joint.drive {
            let start = drive.value(0.0).unwrap_or(f64::NAN);
            let scale = if coordinate == Coordinate::Angle { 1.0 } else { self.extent() };
            // Values that are not finite are reported when a step evaluates them.
            if (start - rest).abs() > tolerances::DRIVE_AT_REST * scale {
                return unsound(format!("its drive begins with the {name} {start}, and in the bodies at rest it is {rest}"));
            }
        }
        let Some([least, largest]) = joint.limits else { return Ok(()) };
        if matches!(joint.kind, JointKind::Cable(_)) {
            return unsound("a cable has a length and no other limits; a link has a least and a largest distance".into());
        }
        if !(least.is_finite() && largest.is_finite() && least < largest) {
            return unsound(format!("its limits {least} and {largest} are no range"));
        }
        if !(least..=largest).contains(&rest) {
            return unsound(format!(
                "the {name} is {rest} in the bodies at rest, outside of its limits {} and {}",
                three_digits(least),
                three_digits(largest)
            ));
        }
        match coordinate {
            Coordinate::Angle if largest - least > tolerances::WIDEST_ANGLE => {
                unsound(format!("its limits are {} rad apart, and stops leave 6 at most", three_digits(largest - least)))
            }
            Coordinate::Distance if least < 0.0 => unsound(format!("the least distance {least} is below zero")),
            _ => Ok(()),
        }
    }

    /// Checks that stops and cables are compatible with a time integrator: with a force history, pressures act beyond their step and drive
    /// open constraints apart.
    pub(crate) fn check_stops(&self, scheme: &Scheme) -> Result<(), ModelError> {
        match self.joints.iter().find(|joint| joint.holds_one_way()) {
            Some(joint) if !scheme.remembers.is_empty() => {
                Err(ModelError::OneSidedJoint { joint: joint.name.clone(), integrator: scheme.name })
            }
            _ => Ok(()),
        }
    }

    /// Initial distance between the two points of a joint, or of a point from the node of a deformable body `[length]`.
    fn apart(&self, joint: &JointDefinition) -> f64 {
        let off = |end: &Anchor| {
            let body = end.body.filter(|&body| self.bodies[body].rigid.is_none());
            body.map_or(0.0, |body| self.nearest_node(body, end.point).1)
        };
        let at_nodes = off(&joint.ends[0]).max(off(&joint.ends[1]));
        let distance = joint.distance();
        let between = match joint.kind {
            JointKind::Link | JointKind::Gear(_) => 0.0,
            JointKind::Cable(longest) => (length(distance) - longest).max(0.0),
            JointKind::Slider(direction) | JointKind::Slot(direction) => {
                let along: f64 = (0..3).map(|i| distance[i] * direction[i]).sum::<f64>() / length(direction).powi(2);
                length(std::array::from_fn(|i| distance[i] - along * direction[i]))
            }
            _ => length(distance),
        };
        at_nodes.max(between)
    }
}

impl BodyDefinition {
    /// Mass of the body, per thickness in the plane `[mass]`.
    pub fn mass(&self) -> f64 {
        self.rigid.map_or_else(|| self.material.density() * self.mesh.measure(), |inertia| inertia.mass)
    }

    /// Checks that mass and moments of inertia of a rigid body are physically possible.
    fn check_rigid(&self) -> Result<(), ModelError> {
        let Some(inertia) = &self.rigid else { return Ok(()) };
        let wrong = |reason: String| Err(ModelError::NotRigid { body: self.name.clone(), reason });
        if self.formulation.plane == Plane::Axisymmetric {
            return wrong("it is a body of revolution".into());
        }
        if !(inertia.mass.is_finite() && inertia.mass > 0.0) {
            return wrong(format!("its mass is {}", inertia.mass));
        }
        let moments = inertia.principal_moments();
        let least = if self.mesh.dimension() == 2 { moments[2] } else { moments[0] };
        if !(least.is_finite() && least > 0.0) {
            return wrong(match self.mesh.dimension() {
                2 => format!("its moment of inertia is {least}, and must be positive"),
                _ => format!("its principal moments of inertia are {moments:?}, and must be positive"),
            });
        }
        let spread = inertia.principal_spreads()[0];
        if self.mesh.dimension() == 3 && spread < -tolerances::JOINT_APART * moments[2] {
            return wrong(format!("of its principal moments of inertia {moments:?} the largest exceeds the sum of the others"));
        }
        if BarycentricMap::new(&self.mesh).is_none() {
            return wrong("its nodes lie on a line or in a plane".into());
        }
        Ok(())
    }
}
