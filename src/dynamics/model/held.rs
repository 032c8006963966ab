//! Velocities, loads and supports without effect, on nodes that are already supported or moved.

use nalgebra::Vector3;

use super::couplings::CouplingKind;
use super::definitions::{LoadKind, Model};
use super::interactions::BodyBoundary;
use crate::bodies::Inertia;
use crate::math::digits::three_digits;
use crate::math::norms::length;

/// Fraction of a body's initial velocity, blocked by a support, above which it is reported: more than round-off or a rounded center of
/// mass.
const AGAINST_SUPPORT: f64 = 0.001;

/// Definition without effect, on nodes that are supported or moved otherwise.
#[derive(Clone, Debug, PartialEq)]
pub enum OverriddenDefinition {
    /// Initial velocity of a body that supports or prescribed motions override at some nodes.
    Thrown {
        /// Name of the body.
        body: String,
        /// `body.boundary` of the nodes.
        boundary: String,
        /// Largest velocity difference at these nodes `[length/time]`.
        speed: f64,
    },
    /// Load on nodes that are all fixed in its direction.
    Loaded {
        /// `body.boundary` of the load.
        boundary: String,
    },
    /// Support whose nodes all have a prescribed motion in a supported direction.
    Overruled {
        /// `body.boundary` of the support.
        held: String,
        /// `body.boundary` with the prescribed motion.
        moved: String,
        /// Direction of support and prescribed motion: x, y or z.
        direction: &'static str,
    },
}

impl std::fmt::Display for OverriddenDefinition {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            OverriddenDefinition::Thrown { body, boundary, .. } => {
                write!(out, "the initial velocity of body \"{body}\" does not act on \"{boundary}\", which is held or moved")
            }
            OverriddenDefinition::Loaded { boundary } => {
                write!(out, "the load on \"{boundary}\" acts on nodes that are held in its direction")
            }
            OverriddenDefinition::Overruled { held, moved, direction } => {
                write!(out, "the support of \"{held}\" in the direction {direction} holds nothing: \"{moved}\" moves all its nodes")
            }
        }
    }
}

impl OverriddenDefinition {
    /// Stable code, which `conserva doc` explains.
    pub fn code(&self) -> &'static str {
        match self {
            OverriddenDefinition::Thrown { .. } => "C0435",
            OverriddenDefinition::Loaded { .. } => "C0436",
            OverriddenDefinition::Overruled { .. } => "C0437",
        }
    }

    /// Consequence, one sentence.
    pub fn cause(&self) -> String {
        match self {
            OverriddenDefinition::Thrown { speed, .. } => {
                format!("velocities there differ by up to {}: the nodes stop in the first step, as in an impact", three_digits(*speed))
            }
            OverriddenDefinition::Loaded { .. } => "the supports take it up: it moves nothing, and is part of their reactions".into(),
            OverriddenDefinition::Overruled { .. } => "where a node is held and moved the motion counts".into(),
        }
    }

    /// Remedy, one sentence.
    pub fn hint(&self) -> &'static str {
        match self {
            OverriddenDefinition::Thrown { .. } => {
                "give a velocity that the supports allow, such as a spin about what holds the body; leave this as it is if a body that \
                 flies is stopped there"
            }
            OverriddenDefinition::Loaded { .. } => "load other nodes, or leave one of the two out",
            OverriddenDefinition::Overruled { .. } => "leave the support or the motion in this direction out",
        }
    }
}

impl Model {
    /// Velocities, loads and supports that supports or prescribed motions make ineffective, fully or partly.
    pub fn held(&self) -> Vec<OverriddenDefinition> {
        let thrown = self.supports.iter().map(|support| &support.on).chain(self.prescriptions.iter().map(|given| &given.on));
        let planes = self.couplings.iter().filter_map(|coupling| match &coupling.kind {
            CouplingKind::Plane { on, .. } => Some(on),
            CouplingKind::Periodic { .. } | CouplingKind::Reference { .. } => None,
        });
        let mut found: Vec<OverriddenDefinition> = Vec::new();
        for on in thrown.chain(planes) {
            let speed = self.speed_against(on);
            let body = self.bodies[on.body].name.clone();
            let is_known = |held: &OverriddenDefinition| matches!(held, OverriddenDefinition::Thrown { body: known, .. } if *known == body);
            if speed > 0.0 && !found.iter().any(is_known) {
                found.push(OverriddenDefinition::Thrown { body, boundary: self.boundary_name(on), speed });
            }
        }
        let loaded = self.loads.iter().filter(|load| self.is_held_against(&load.on, &load.kind));
        found.extend(loaded.map(|load| OverriddenDefinition::Loaded { boundary: self.boundary_name(&load.on) }));
        for support in &self.supports {
            let nodes = self.nodes_of(&support.on);
            for moved in self.prescriptions.iter().filter(|moved| moved.on.body == support.on.body) {
                let others = self.nodes_of(&moved.on);
                let direction = (0..self.dimension()).find(|&i| support.components[i] && moved.moves(i));
                if let Some(direction) = direction.filter(|_| nodes.iter().all(|node| others.binary_search(node).is_ok())) {
                    let [held, moved] = [&support.on, &moved.on].map(|on| self.boundary_name(on));
                    found.push(OverriddenDefinition::Overruled { held, moved, direction: ["x", "y", "z"][direction] });
                }
            }
        }
        found
    }

    fn nodes_of(&self, on: &BodyBoundary) -> Vec<u32> {
        self.bodies[on.body].mesh.boundary_nodes(&on.boundary)
    }

    /// Largest difference between the initial velocity of a boundary's body and the velocity that supports, prescribed motions and planes
    /// of symmetry admit; 0 below round-off.
    fn speed_against(&self, on: &BodyBoundary) -> f64 {
        let Some(given) = self.initial_velocities.iter().rfind(|given| given.body == on.body) else { return 0.0 };
        let body = &self.bodies[on.body];
        let inertia = body.rigid.or_else(|| Inertia::of_mesh(&body.mesh, &body.material, body.formulation).ok());
        let Some(center) = inertia.map(|inertia| Vector3::from(inertia.center)) else { return 0.0 };
        let is_same = |other: &BodyBoundary| std::ptr::eq(other, on);
        let (linear, angular) = (Vector3::from(given.linear), Vector3::from(given.angular));
        let (mut most, mut scale) = (0.0f64, 0.0f64);
        for node in self.nodes_of(on) {
            let place = body.mesh.points[node as usize];
            let velocity = linear + angular.cross(&(Vector3::from(place) - center));
            scale = scale.max(velocity.norm());
            for support in self.supports.iter().filter(|support| is_same(&support.on)) {
                (0..3).filter(|&i| support.components[i]).for_each(|i| most = most.max(velocity[i].abs()));
            }
            for given in self.prescriptions.iter().filter(|given| is_same(&given.on)) {
                // Errors of time functions are reported by the first step, which evaluates them again.
                let Ok(motion) = given.at(0.0) else { continue };
                (0..self.dimension())
                    .filter(|&i| given.moves(i))
                    .for_each(|i| most = most.max((velocity[i] - motion.of(place, i).1).abs()));
            }
            for coupling in &self.couplings {
                if let CouplingKind::Plane { on, normal } = &coupling.kind
                    && is_same(on)
                {
                    most = most.max(velocity.dot(&Vector3::from(*normal)).abs() / length(*normal));
                }
            }
        }
        if most > AGAINST_SUPPORT * scale { most } else { 0.0 }
    }

    /// True if all nodes of a load are held in all directions of the load.
    fn is_held_against(&self, on: &BodyBoundary, kind: &LoadKind) -> bool {
        let dimension = self.dimension();
        let pushes: [bool; 3] = match kind {
            LoadKind::Traction(vector) | LoadKind::Force(vector) => std::array::from_fn(|i| i < dimension && vector[i] != 0.0),
            LoadKind::Pressure(_) | LoadKind::Torque(_) => std::array::from_fn(|i| i < dimension),
        };
        let mut held = vec![[false; 3]; self.bodies[on.body].mesh.points.len()];
        for support in self.supports.iter().filter(|support| support.on.body == on.body) {
            for node in self.nodes_of(&support.on) {
                (0..3).for_each(|i| held[node as usize][i] |= support.components[i]);
            }
        }
        let nodes = self.nodes_of(on);
        let is_held = |&node: &u32| (0..3).all(|i| !pushes[i] || held[node as usize][i]);
        pushes.contains(&true) && !nodes.is_empty() && nodes.iter().all(is_held)
    }
}
