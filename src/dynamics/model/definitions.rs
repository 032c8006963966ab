//! Definition of a problem, before any number is computed: bodies, supports, loads, contact pairs.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::amplitude::Amplitude;
use super::couplings::{Coupling, CouplingKind};
use super::error::ModelError;
use super::interactions::{BodyBoundary, Enforcement, Interaction, Partner};
use super::joints::JointDefinition;
use super::part::PartDefinition;
use super::prescription::Prescription;
use crate::bodies::{Formulation, Inertia, Plane};
use crate::contact::{FacetShape, Obstacle};
use crate::materials::Material;
use crate::mesh::Mesh;

/// A body: a mesh with a material and a name.
#[derive(Clone, Debug)]
pub struct BodyDefinition {
    /// Name, unique in the model.
    pub name: String,
    /// Mesh in the undeformed configuration.
    pub mesh: Arc<Mesh>,
    /// Material of the body.
    pub material: Material,
    /// Plane strain, plane stress or axisymmetric, and the treatment of volume changes.
    pub formulation: Formulation,
    /// Mass and inertia of a rigid body, whose material only provides the density; `None` for deformable bodies.
    pub rigid: Option<Inertia>,
}

impl BodyDefinition {
    /// True for a deformable body whose material flows plastically.
    pub fn flows(&self) -> bool {
        self.rigid.is_none() && self.material.history().is_some()
    }
}

/// Nodes that do not move in some directions.
#[derive(Clone, Debug)]
pub struct Support {
    /// Boundary whose nodes are supported.
    pub on: BodyBoundary,
    /// Fixed displacement components (x, y, z).
    pub components: [bool; 3],
}

/// Kind of a load, scaled by a time function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LoadKind {
    /// Dead traction vector per undeformed facet area `[stress]`, multiplied by the amplitude.
    Traction([f64; 3]),
    /// Dead force distributed over the boundary `[force]`, multiplied by the amplitude.
    Force([f64; 3]),
    /// Pressure on the deformed boundary `[stress]`, multiplied by the amplitude; positive values push into the body.
    Pressure(f64),
    /// Torque about an axis of this direction, of length 1: the amplitude itself `[force * length]`, as nodal forces without resultant.
    Torque([f64; 3]),
}

/// A load on a boundary.
#[derive(Clone)]
pub struct Load {
    /// Kind of the load.
    pub kind: LoadKind,
    /// Boundary on which the load acts.
    pub on: BodyBoundary,
    /// Amplitude over time.
    pub amplitude: Amplitude,
}

/// Initial velocity of a body: `linear + angular x (x - center of mass)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialVelocity {
    /// Index of the body in the model.
    pub body: usize,
    /// Velocity of the center of mass `[length/time]`.
    pub linear: [f64; 3],
    /// Angular velocity `[1/time]`; in the plane only the third component.
    pub angular: [f64; 3],
}

/// Initial displacements of a body's nodes, which strain the body relative to its mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct InitialDisplacement {
    /// Index of the body in the model.
    pub body: usize,
    /// Displacement of each node of the body's mesh `[length]`.
    pub displacement: Vec<[f64; 3]>,
}

/// Stress-free stretch of a body relative to its mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Growth {
    /// Index of the body in the model.
    pub body: usize,
    /// Ratio of stress-free length to length in the mesh at each node, equal in all directions of the body's dimension.
    pub factors: Vec<f64>,
}

/// A problem: bodies, supports, loads and interactions.
#[derive(Clone, Default)]
pub struct Model {
    /// Name of the model.
    pub name: String,
    /// Bodies in the order of their definition.
    pub bodies: Vec<BodyDefinition>,
    /// Fixed displacement components of boundaries.
    pub supports: Vec<Support>,
    /// Prescribed displacements.
    pub prescriptions: Vec<Prescription>,
    /// Acceleration of gravity `[length/time^2]`.
    pub gravity: [f64; 3],
    /// Factor of gravity over time; `None`: constant. Time-dependent gravity has no potential; its work is that of a load.
    pub gravity_amplitude: Option<Amplitude>,
    /// Loads on boundaries.
    pub loads: Vec<Load>,
    /// Interactions: contacts, obstacles and ties, in the order in which a simulation counts contacts.
    pub interactions: Vec<Interaction>,
    /// Other force elements, such as springs.
    pub parts: Vec<Arc<dyn PartDefinition>>,
    /// Exact joints between bodies, and to the ground.
    pub joints: Vec<JointDefinition>,
    /// Nodes of boundaries that linear equations couple.
    pub couplings: Vec<Coupling>,
    /// Initial displacements of bodies' nodes `[length]`; the last entry for a body is used.
    pub initial_displacements: Vec<InitialDisplacement>,
    /// Stress-free stretches of bodies; the last entry for a body is used.
    pub growths: Vec<Growth>,
    /// Initial velocities of bodies; the last entry for a body is used.
    pub initial_velocities: Vec<InitialVelocity>,
}

impl Model {
    /// True if the model has contacts between rigid sides.
    pub fn has_rigid_contacts(&self) -> bool {
        self.interactions.iter().any(|interaction| self.is_rigid_contact(interaction))
    }

    /// Deformable bodies whose material flows plastically.
    pub fn flowing_bodies(&self) -> impl Iterator<Item = &BodyDefinition> {
        self.bodies.iter().filter(|body| body.flows())
    }

    /// Checks that restitution is defined for impacts between rigid sides with multipliers only.
    fn check_restitution(&self, interaction: &Interaction) -> Result<(), ModelError> {
        let Some(restitution) = interaction.restitution else { return Ok(()) };
        let refused =
            |reason: String, remedy: &'static str| Err(ModelError::NoRestitution { contact: interaction.name.clone(), reason, remedy });
        if !(0.0..=1.0).contains(&restitution) {
            return refused(format!("its coefficient is {restitution}"), "give a coefficient of 0 to 1");
        }
        let sides = std::iter::once(&interaction.secondary).chain(interaction.primary());
        if let Some(soft) = sides.filter_map(|side| self.bodies.get(side.body)).find(|body| body.rigid.is_none()) {
            return refused(
                format!("body \"{}\" deforms, and rebounds by its own elasticity", soft.name),
                "leave it out, or make the body rigid; what an elastic body loses in an impact is the work of a viscous material",
            );
        }
        if interaction.equality || matches!(interaction.enforcement, Enforcement::Penalty { .. }) {
            return refused("its impacts are not solved by multipliers that press".into(), "hold the contact by multipliers");
        }
        Ok(())
    }

    /// True if both sides of an interaction are rigid: two rigid bodies, or a rigid body and an obstacle.
    pub fn is_rigid_contact(&self, interaction: &Interaction) -> bool {
        let is_rigid = |on: &BodyBoundary| self.bodies.get(on.body).is_some_and(|body| body.rigid.is_some());
        !interaction.is_tie() && is_rigid(&interaction.secondary) && interaction.primary().iter().all(is_rigid)
    }

    /// True if curves of the secondary side touch an obstacle in the plane with arcs at the nodes: deformable bodies, on demand.
    ///
    /// Pressed flat over several facets, arcs have an error of a tenth of the peak at the edge of the contact (`tests/scripts/hertz.rhai`),
    /// nodes of a twentieth: by default the nodes touch.
    pub fn touches_with_arcs(&self, interaction: &Interaction) -> bool {
        let is_deformable = self.bodies.get(interaction.secondary.body).is_some_and(|body| body.rigid.is_none());
        let is_wanted = interaction.facets == Some(FacetShape::Curved) || interaction.shapes[0].is_some();
        is_deformable && is_wanted && self.dimension() == 2 && matches!(interaction.partner, Partner::Obstacle { .. })
    }

    /// Refuses properties of an interaction that contacts in space do not support.
    fn check_in_space(&self, interaction: &Interaction) -> Result<(), ModelError> {
        let without_middles = self.bodies.get(interaction.secondary.body).and_then(|body| {
            let facets = &interaction.secondary.boundary.facets;
            let serendipity = facets.iter().find(|&&facet| body.mesh.facet_nodes(facet).count() == 8)?;
            Some(body.mesh.kind_of(serendipity.cell as usize).name())
        });
        let lacking = match &interaction.partner {
            Partner::Tied { .. } => None,
            // 8-node faces have no node at their center, hence no tangents for the friction there.
            _ if interaction.friction.is_some() && without_middles.is_some() => {
                without_middles.map(|cells| format!("friction on a secondary side of `{cells}`"))
            }
            Partner::Obstacle { .. } => None,
            Partner::Itself if interaction.method.is_nodal => Some(format!("self contact by the method \"{}\"", interaction.method.name)),
            _ if interaction.method.in_space.is_none() => Some(format!("the method \"{}\"", interaction.method.name)),
            _ => None,
        };
        lacking.map_or(Ok(()), |what| Err(ModelError::NotInSpace { contact: interaction.name.clone(), what }))
    }

    /// Times of kinks of loads, prescribed motions, drives and obstacles, ascending.
    pub fn corners(&self) -> Vec<f64> {
        let motions = self.interactions.iter().filter_map(|interaction| match &interaction.partner {
            Partner::Obstacle { motion, turn, .. } => Some(motion.iter().flatten().chain(turn.as_ref().map(|turn| &turn.angle))),
            _ => None,
        });
        let loads = self.loads.iter().map(|load| &load.amplitude).chain(&self.gravity_amplitude);
        let offsets = self.couplings.iter().flat_map(|coupling| coupling.kind.functions());
        let drives = self.joints.iter().filter_map(|joint| joint.drive.as_ref()).chain(offsets);
        let all = loads.chain(self.prescriptions.iter().flat_map(Prescription::functions)).chain(motions.flatten()).chain(drives);
        let of_parts = self.parts.iter().flat_map(|part| part.functions());
        let of_parts = of_parts.flat_map(|function| function.corners());
        let mut corners: Vec<f64> = all.flat_map(|function| function.corners()).chain(of_parts).collect();
        corners.sort_by(f64::total_cmp);
        corners.dedup();
        corners
    }

    /// Space dimension of the bodies; 2 without bodies.
    pub fn dimension(&self) -> usize {
        self.bodies.first().map_or(2, |body| body.mesh.dimension())
    }

    /// `"body.boundary"`, as messages name a boundary.
    pub fn boundary_name(&self, on: &BodyBoundary) -> String {
        format!("{}.{}", self.bodies[on.body].name, on.boundary.name)
    }

    /// Names of all interactions, in the order in which a simulation counts contacts.
    pub fn contact_names(&self) -> Vec<&str> {
        self.interactions.iter().map(|interaction| interaction.name.as_str()).collect()
    }

    /// Inserts an interaction after the others of its kind; the order of kinds is contacts, self-contact, obstacles, ties.
    pub fn add_interaction(&mut self, interaction: Interaction) -> &mut Interaction {
        let place = self.interactions.partition_point(|other| other.rank() <= interaction.rank());
        self.interactions.insert(place, interaction);
        &mut self.interactions[place]
    }

    /// Names of the boundaries with supports or prescribed motions, each once, in the order of their reactions.
    pub fn support_names(&self) -> Vec<String> {
        let boundaries = self.supports.iter().map(|support| &support.on).chain(self.prescriptions.iter().map(|given| &given.on));
        let mut names: Vec<String> = Vec::new();
        for name in boundaries.map(|on| self.boundary_name(on)) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }

    /// Names of the reactions in their order: [`Model::support_names`], then couplings.
    pub fn reaction_names(&self) -> Vec<String> {
        let couplings = self.couplings.iter().map(|coupling| coupling.name.clone());
        self.support_names().into_iter().chain(couplings).collect()
    }

    /// Bodies that fall under gravity without limit: without a support, and connected by neither interactions nor parts to a supported body
    /// or an obstacle.
    pub fn falling(&self) -> Vec<&BodyDefinition> {
        if self.gravity == [0.0; 3] {
            return Vec::new();
        }
        let held = self.supports.iter().map(|support| support.on.body).chain(self.prescriptions.iter().map(|given| given.on.body));
        let on_obstacles =
            self.interactions.iter().filter(|one| matches!(one.partner, Partner::Obstacle { .. })).map(|one| one.secondary.body);
        let touching = self.interactions.iter().map(|one| std::iter::once(&one.secondary).chain(one.primary()).map(|on| on.body).collect());
        let joined: Vec<Vec<usize>> = touching
            .chain(self.parts.iter().map(|part| part.bodies()))
            .chain(self.joints.iter().map(|joint| joint.bodies().collect()))
            .chain(self.couplings.iter().map(|coupling| coupling.kind.bodies()))
            .collect();
        let parts = self.parts.iter().filter(|part| part.is_grounded()).flat_map(|part| part.bodies());
        let planes = self.couplings.iter().filter_map(|coupling| match &coupling.kind {
            CouplingKind::Plane { on, .. } => Some(on.body),
            CouplingKind::Periodic { .. } | CouplingKind::Reference { .. } => None,
        });
        let grounded = self.joints.iter().filter(|joint| joint.is_grounded()).flat_map(|joint| joint.bodies()).chain(parts).chain(planes);
        let mut kept: BTreeSet<usize> = held.chain(on_obstacles).chain(grounded).collect();
        while let Some(group) = joined.iter().find(|group| {
            let count = group.iter().filter(|body| kept.contains(body)).count();
            count > 0 && group.iter().any(|body| !kept.contains(body))
        }) {
            kept.extend(group);
        }
        let falls = |(index, _): &(usize, &BodyDefinition)| !kept.contains(index);
        self.bodies.iter().enumerate().filter(falls).map(|(_, body)| body).collect()
    }

    /// Positions of a body's nodes at the start `[length]`.
    pub fn start(&self, body: usize) -> Vec<[f64; 3]> {
        let moved = |(x, u): (&[f64; 3], [f64; 3])| std::array::from_fn(|i| x[i] + u[i]);
        self.bodies[body].mesh.points.iter().zip(self.initial_displacement(body)).map(moved).collect()
    }

    /// Initial positions of all nodes `[length]`, body after body, with one coordinate per dimension.
    pub fn start_positions(&self) -> Vec<f64> {
        let dimension = self.dimension();
        (0..self.bodies.len()).flat_map(|body| self.start(body)).flat_map(|x| x.into_iter().take(dimension)).collect()
    }

    /// Displacements of a body's nodes at the start `[length]`.
    pub fn initial_displacement(&self, body: usize) -> Vec<[f64; 3]> {
        let given = self.initial_displacements.iter().rfind(|initial| initial.body == body);
        given.map_or_else(|| vec![[0.0; 3]; self.bodies[body].mesh.points.len()], |initial| initial.displacement.clone())
    }

    /// True if the bodies are axisymmetric.
    pub fn is_axisymmetric(&self) -> bool {
        self.bodies.iter().any(|body| body.formulation.plane == Plane::Axisymmetric)
    }

    /// Refuses entities of an axisymmetric model that break its symmetry.
    fn check_symmetry(&self) -> Result<(), ModelError> {
        if !self.is_axisymmetric() {
            return Ok(());
        }
        let is_axisymmetric = |body: &&BodyDefinition| body.formulation.plane == Plane::Axisymmetric;
        if let (Some(first), Some(second)) =
            (self.bodies.iter().find(is_axisymmetric), self.bodies.iter().find(|body| !is_axisymmetric(body)))
        {
            return Err(ModelError::MixedSymmetry { first: first.name.clone(), second: second.name.clone() });
        }
        let breaks = |what: String| Err(ModelError::BreaksSymmetry { what });
        if self.gravity[0] != 0.0 {
            return breaks("gravity across the axis".into());
        }
        if let Some(load) = self.loads.iter().find(|load| matches!(load.kind, LoadKind::Torque(_))) {
            return breaks(format!("the torque on \"{}\"", self.boundary_name(&load.on)));
        }
        if let Some(given) = self.prescriptions.iter().find(|given| given.turn.is_some()) {
            return breaks(format!("the prescribed angle of \"{}\"", self.boundary_name(&given.on)));
        }
        let tilts = |one: &&Interaction| matches!(&one.partner, Partner::Obstacle { turn: Some(turn), .. } if turn.about.is_some());
        if let Some(Interaction { name, .. }) = self.interactions.iter().find(tilts) {
            return breaks(format!("the angle of the obstacle of contact \"{name}\""));
        }
        match self.initial_velocities.iter().find(|given| given.linear[0] != 0.0 || given.angular[2] != 0.0) {
            Some(given) => breaks(format!("the initial velocity of body \"{}\"", self.bodies[given.body].name)),
            None => Ok(()),
        }
    }

    /// Checks that no boundary is supported and moved in one direction. For nodes shared by two boundaries the prescribed motion is used.
    fn check_held_and_moved(&self) -> Result<(), ModelError> {
        let contradiction = |support: &Support, moved: &Prescription| {
            let (held, on) = (&support.on, &moved.on);
            let is_same = held.body == on.body && held.boundary.facets == on.boundary.facets && held.boundary.nodes == on.boundary.nodes;
            (0..3).find(|&i| is_same && support.components[i] && moved.moves(i))
        };
        let both = |moved| Some((moved, self.supports.iter().find_map(|support| contradiction(support, moved))?));
        self.prescriptions.iter().find_map(both).map_or(Ok(()), |(moved, component)| {
            Err(ModelError::HeldAndMoved { boundary: self.boundary_name(&moved.on), direction: ["x", "y", "z"][component] })
        })
    }

    /// Checks the model without computing: names, dimensions, empty boundaries, self-contact.
    ///
    /// # Errors
    /// The first defect found.
    pub fn check(&self) -> Result<(), ModelError> {
        let first = self.bodies.first().ok_or(ModelError::NoBodies { model: self.name.clone() })?;
        for (index, body) in self.bodies.iter().enumerate() {
            if self.bodies[..index].iter().any(|other| other.name == body.name) {
                return Err(ModelError::DuplicateName { what: "body", name: body.name.clone() });
            }
            let formulated = body.formulation.check(&body.mesh, &body.material);
            formulated.map_err(|source| ModelError::Formulation { body: body.name.clone(), source })?;
            if body.mesh.dimension() != first.mesh.dimension() {
                return Err(ModelError::MixedDimensions {
                    first: first.name.clone(),
                    first_dimension: first.mesh.dimension(),
                    second: body.name.clone(),
                    second_dimension: body.mesh.dimension(),
                });
            }
        }
        self.check_symmetry()?;
        self.check_growths()?;
        let held = self.supports.iter().map(|support| &support.on).chain(self.prescriptions.iter().map(|prescription| &prescription.on));
        let forced = self.loads.iter().filter(|load| matches!(load.kind, LoadKind::Force(_))).map(|load| &load.on);
        for on in held.chain(forced) {
            if on.boundary.facets.is_empty() && on.boundary.nodes.is_empty() {
                return Err(ModelError::EmptyBoundary { boundary: self.boundary_name(on) });
            }
        }
        self.check_held_and_moved()?;
        let surfaces =
            self.interactions.iter().flat_map(|interaction| std::iter::once(&interaction.secondary).chain(interaction.primary()));
        let spread = self.loads.iter().filter(|load| !matches!(load.kind, LoadKind::Force(_))).map(|load| &load.on);
        for on in spread.chain(surfaces) {
            let boundary = self.boundary_name(on);
            if !on.boundary.nodes.is_empty() {
                return Err(ModelError::PointBoundary { boundary });
            }
            if on.boundary.facets.is_empty() {
                return Err(ModelError::EmptyBoundary { boundary });
            }
        }
        for (index, part) in self.parts.iter().enumerate() {
            if self.parts[..index].iter().any(|other| other.name() == part.name()) {
                return Err(ModelError::DuplicateName { what: "part", name: part.name().into() });
            }
            part.check(&|body, node| self.bodies[body].mesh.points[node as usize])?;
        }
        let names = self.contact_names();
        for (index, name) in names.iter().enumerate() {
            if names[..index].contains(name) {
                return Err(ModelError::DuplicateName { what: "contact", name: name.to_string() });
            }
        }
        if self.dimension() == 3 {
            self.interactions.iter().try_for_each(|interaction| self.check_in_space(interaction))?;
        }
        for Interaction { name, partner, .. } in &self.interactions {
            let Partner::Obstacle { shape, .. } = partner else { continue };
            let of_shape = if matches!(shape, Obstacle::InSpace(_)) { 3 } else { 2 };
            if of_shape != self.dimension() {
                return Err(ModelError::ObstacleDimension { contact: name.clone(), of_shape, of_bodies: self.dimension() });
            }
        }
        for Interaction { name, secondary, partner, .. } in &self.interactions {
            let Partner::Surfaces(primary) = partner else { continue };
            let shares = |primary: &BodyBoundary| {
                secondary.body == primary.body && secondary.boundary.facets.iter().any(|facet| primary.boundary.facets.contains(facet))
            };
            if primary.iter().any(shares) {
                return Err(ModelError::SelfContact { contact: name.clone(), boundary: self.boundary_name(secondary) });
            }
        }
        self.interactions.iter().try_for_each(|interaction| self.check_restitution(interaction))?;
        self.interactions.iter().try_for_each(|interaction| self.check_shapes(interaction))?;
        self.check_joints()?;
        self.check_couplings()?;
        self.check_repeated()
    }
}
