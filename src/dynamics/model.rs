//! What a problem consists of, before any number is computed: bodies, supports, loads, contact pairs.

use std::rc::Rc;

use super::amplitude::Amplitude;
use super::error::ModelError;
use crate::contact::Obstacle;
use crate::materials::Material;
use crate::mesh::{Boundary, Mesh};

/// A deformable body: a mesh with a material and a name.
#[derive(Clone, Debug)]
pub struct BodyDefinition {
    /// Name, unique in the model.
    pub name: String,
    /// Its mesh in the undeformed configuration.
    pub mesh: Rc<Mesh>,
    /// Its material.
    pub material: Material,
}

/// A boundary of a body.
#[derive(Clone, Debug)]
pub struct BodyBoundary {
    /// Index of the body in the model.
    pub body: usize,
    /// The boundary of the body's mesh.
    pub boundary: Boundary,
}

/// Nodes that do not move in some directions.
#[derive(Clone, Debug)]
pub struct Support {
    /// The nodes of this boundary are held.
    pub on: BodyBoundary,
    /// Which components (x, y, z) are held.
    pub components: [bool; 3],
}

/// Nodes whose displacement in one direction follows a time function.
#[derive(Clone)]
pub struct Prescription {
    /// The nodes of this boundary.
    pub on: BodyBoundary,
    /// The component (0, 1, 2: x, y, z).
    pub component: usize,
    /// Displacement over time `[length]`.
    pub displacement: Amplitude,
}

/// What a load does; its size follows a time function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LoadKind {
    /// Dead traction vector per undeformed facet area `[stress]`, times the amplitude.
    Traction([f64; 3]),
    /// Dead force spread evenly over the boundary `[force]`, times the amplitude.
    Force([f64; 3]),
    /// Pressure against the deformed boundary `[stress]`, times the amplitude; positive pushes into the body. In the plane only.
    Pressure(f64),
    /// Torque about the third axis `[force * length]`, the amplitude itself, as nodal forces without resultant.
    Torque,
}

/// A load on a boundary.
#[derive(Clone)]
pub struct Load {
    /// What it does.
    pub kind: LoadKind,
    /// Where it acts.
    pub on: BodyBoundary,
    /// Its size over time.
    pub amplitude: Amplitude,
}

/// How contact conditions are discretized in space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ContactMethod {
    /// Mortar method with standard Lagrange multipliers on the secondary nodes.
    Mortar,
    /// Mortar method with dual (biorthogonal) multiplier shape functions (Wohlmuth, SIAM J. Numer. Anal. 38, 2000).
    DualMortar,
    /// Mortar method with averaged nodal normals, interpolated along the secondary facets (Yang, Laursen and Meng, IJNME 62, 2005).
    AveragedMortar,
    /// The gap of each secondary node to the chain of primary facets, one multiplier per node.
    NodeToSegment,
}

impl ContactMethod {
    /// All methods, in the order of the reference.
    pub const ALL: &'static [ContactMethod] =
        &[ContactMethod::Mortar, ContactMethod::DualMortar, ContactMethod::AveragedMortar, ContactMethod::NodeToSegment];

    /// Name as written in a script.
    pub fn name(self) -> &'static str {
        match self {
            ContactMethod::Mortar => "mortar",
            ContactMethod::DualMortar => "dual_mortar",
            ContactMethod::AveragedMortar => "averaged_mortar",
            ContactMethod::NodeToSegment => "node_to_segment",
        }
    }

    /// One sentence for the reference.
    pub fn summary(self) -> &'static str {
        match self {
            ContactMethod::Mortar => "mortar method: pressures at the secondary nodes, gaps integrated over the common surface",
            ContactMethod::DualMortar => "mortar method with dual shape functions: each multiplier presses its own node and no other",
            ContactMethod::AveragedMortar => "mortar method with averaged nodal normals: the normal is continuous along the secondary side",
            ContactMethod::NodeToSegment => {
                "node-to-segment method: no secondary node enters the primary side; locks where both are polygons. In two passes: two \
                 contacts with the sides swapped, both with `penalty` or `augmented_lagrange`"
            }
        }
    }
}

/// The condition that an active contact node fulfils over a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum UpdateRule {
    /// The gap is zero at the end of the step, or what it was at the start where that was an overlap.
    Gap,
    /// A node that is closed at the start of the step does not approach further (Laursen and Chawla, IJNME 40, 1997).
    Persistency,
    /// As `Gap`; closings are plastic impacts whose energy a smoothed velocity jump returns at the opening (after Laursen and Love, IJNME
    /// 53, 2002, who return it at once).
    Velocity,
}

impl UpdateRule {
    /// All rules, in the order of the reference.
    pub const ALL: &'static [UpdateRule] = &[UpdateRule::Gap, UpdateRule::Persistency, UpdateRule::Velocity];

    /// Name as written in a script.
    pub fn name(self) -> &'static str {
        match self {
            UpdateRule::Gap => "gap",
            UpdateRule::Persistency => "persistency",
            UpdateRule::Velocity => "velocity",
        }
    }

    /// One sentence for the reference.
    pub fn summary(self) -> &'static str {
        match self {
            UpdateRule::Gap => {
                "closed at the end of a step; each closing loses energy, which the ledger books as contact work (never positive: an \
                 overlap at the start is kept, not driven apart)"
            }
            UpdateRule::Persistency => {
                "a gap that is closed stays as it is: energy exact through impact and release, penetrates by at most a tenth of a facet"
            }
            UpdateRule::Velocity => {
                "closed as with `gap`, and exact energy: what a closing takes is kept in reserve (column `reserve`, part of `potential`) \
                 and becomes motion again when the contact opens"
            }
        }
    }
}

/// What keeps a contact node from penetrating.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Enforcement {
    /// Lagrange multipliers: the update rule holds exactly.
    Multiplier,
    /// The potential `kappa/2 min(Phi, 0)^2` of the weighted gap, with `kappa = factor * youngs_modulus / h^2`: a small penetration, and
    /// exact energy by the quotient `(U(Phi_1) - U(Phi_0)) / (Phi_1 - Phi_0)`. The update rule is not used.
    Penalty {
        /// Stiffness over that of the secondary body's facets.
        factor: f64,
    },
    /// Augmented Lagrangian: `lambda = max(0, lambda_old - kappa (Phi - target))`, with the multiplier brought up to date in every Newton
    /// iteration until the update rule holds as exactly as with multipliers. It copes with constraints that depend on one another.
    /// `kappa = factor (youngs_modulus / h^2 + m_A / w_A^2 * 2 / dt^2)`: the stiffness of a facet and the inertia of the node.
    AugmentedLagrange {
        /// Augmentation over the stiffness that a node has in the step; the larger, the fewer iterations.
        factor: f64,
    },
}

/// A contact pair.
#[derive(Clone, Debug)]
pub struct ContactDefinition {
    /// Name, unique in the model.
    pub name: String,
    /// The side that carries the multipliers (slave, nonmortar).
    pub secondary: BodyBoundary,
    /// The other side (master, mortar): one boundary or several, of one body or several.
    pub primary: Vec<BodyBoundary>,
    /// Discretisation.
    pub method: ContactMethod,
    /// Condition over a step.
    pub update: UpdateRule,
    /// What keeps nodes from penetrating.
    pub enforcement: Enforcement,
    /// The paper's bilateral constraints: every covered node is closed, tension is allowed.
    pub equality: bool,
}

impl ContactDefinition {
    /// Mortar contact with multipliers and the `gap` rule; change the fields for anything else.
    pub fn new(name: &str, secondary: BodyBoundary, primary: BodyBoundary) -> Self {
        ContactDefinition {
            name: name.into(),
            secondary,
            primary: vec![primary],
            method: ContactMethod::Mortar,
            update: UpdateRule::Gap,
            enforcement: Enforcement::Multiplier,
            equality: false,
        }
    }
}

/// Contact of a boundary with a rigid obstacle.
#[derive(Clone)]
pub struct ObstacleDefinition {
    /// Name, unique among contacts.
    pub name: String,
    /// The boundary that may touch it; it carries the multipliers.
    pub secondary: BodyBoundary,
    /// Its shape and place.
    pub obstacle: Obstacle,
    /// Translation in x and y over time `[length]`; `None`: at rest.
    pub motion: [Option<Amplitude>; 2],
    /// Condition over a step.
    pub update: UpdateRule,
    /// What keeps nodes from penetrating.
    pub enforcement: Enforcement,
    /// Every node is held at the obstacle, tension is allowed.
    pub equality: bool,
}

impl ObstacleDefinition {
    /// An obstacle at rest, with multipliers and the `gap` rule; change the fields for anything else.
    pub fn new(name: &str, secondary: BodyBoundary, obstacle: Obstacle) -> Self {
        ObstacleDefinition {
            name: name.into(),
            secondary,
            obstacle,
            motion: [None, None],
            update: UpdateRule::Gap,
            enforcement: Enforcement::Multiplier,
            equality: false,
        }
    }
}

/// Contact of a boundary with itself.
#[derive(Clone, Debug)]
pub struct SelfContactDefinition {
    /// Name, unique among contacts.
    pub name: String,
    /// The boundary.
    pub surface: BodyBoundary,
    /// Discretisation.
    pub method: ContactMethod,
    /// Condition over a step.
    pub update: UpdateRule,
    /// What keeps nodes from penetrating.
    pub enforcement: Enforcement,
}

/// Two boundaries that stay together although their meshes do not match.
#[derive(Clone, Debug)]
pub struct TieDefinition {
    /// Name, unique among contacts.
    pub name: String,
    /// The side that carries the multipliers, better the finer one.
    pub secondary: BodyBoundary,
    /// The other side.
    pub primary: BodyBoundary,
    /// Distance in the undeformed bodies within which they are tied `[length]`; `None`: half of the shortest secondary facet.
    pub reach: Option<f64>,
}

/// Velocity of a body at the start: `linear + angular x (x - center of mass)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialVelocity {
    /// Index of the body in the model.
    pub body: usize,
    /// Velocity of the center of mass `[length/time]`.
    pub linear: [f64; 3],
    /// Angular velocity `[1/time]`; in the plane only the third component.
    pub angular: [f64; 3],
}

/// A problem: what there is, how it is held and loaded, what touches what.
#[derive(Clone, Default)]
pub struct Model {
    /// Name of the model.
    pub name: String,
    /// Bodies in the order in which they were added.
    pub bodies: Vec<BodyDefinition>,
    /// Supports.
    pub supports: Vec<Support>,
    /// Prescribed displacements.
    pub prescriptions: Vec<Prescription>,
    /// Acceleration of gravity `[length/time^2]`.
    pub gravity: [f64; 3],
    /// Loads.
    pub loads: Vec<Load>,
    /// Contact pairs.
    pub contacts: Vec<ContactDefinition>,
    /// Boundaries that may touch themselves.
    pub self_contacts: Vec<SelfContactDefinition>,
    /// Rigid obstacles.
    pub obstacles: Vec<ObstacleDefinition>,
    /// Ties.
    pub ties: Vec<TieDefinition>,
    /// Initial velocities; a later one of the same body replaces an earlier one.
    pub initial_velocities: Vec<InitialVelocity>,
}

impl Model {
    /// Space dimension of the bodies; 2 while there is none.
    pub fn dimension(&self) -> usize {
        self.bodies.first().map_or(2, |body| body.mesh.dimension())
    }

    /// `"body.boundary"`, as messages name a boundary.
    pub fn boundary_name(&self, on: &BodyBoundary) -> String {
        format!("{}.{}", self.bodies[on.body].name, on.boundary.name)
    }

    /// Names of all contact pairs, in the order in which a simulation counts them: pairs of surfaces, surfaces with themselves, obstacles,
    /// ties.
    pub fn contact_names(&self) -> Vec<&str> {
        let names = self.contacts.iter().map(|contact| &contact.name).chain(self.self_contacts.iter().map(|contact| &contact.name));
        let names = names.chain(self.obstacles.iter().map(|obstacle| &obstacle.name)).chain(self.ties.iter().map(|tie| &tie.name));
        names.map(String::as_str).collect()
    }

    /// Checks everything that can be said without computing: names, dimensions, empty boundaries, a surface in contact with itself.
    ///
    /// # Errors
    /// The first defect found.
    pub fn check(&self) -> Result<(), ModelError> {
        let first = self.bodies.first().ok_or(ModelError::NoBodies { model: self.name.clone() })?;
        for (index, body) in self.bodies.iter().enumerate() {
            if self.bodies[..index].iter().any(|other| other.name == body.name) {
                return Err(ModelError::DuplicateName { what: "body", name: body.name.clone() });
            }
            if body.mesh.dimension() != first.mesh.dimension() {
                return Err(ModelError::MixedDimensions {
                    first: first.name.clone(),
                    first_dimension: first.mesh.dimension(),
                    second: body.name.clone(),
                    second_dimension: body.mesh.dimension(),
                });
            }
        }
        let surfaces = self.contacts.iter().flat_map(|contact| std::iter::once(&contact.secondary).chain(&contact.primary));
        let surfaces = surfaces.chain(self.ties.iter().flat_map(|tie| [&tie.secondary, &tie.primary]));
        let surfaces = surfaces.chain(self.obstacles.iter().map(|obstacle| &obstacle.secondary));
        let surfaces = surfaces.chain(self.self_contacts.iter().map(|contact| &contact.surface));
        let prescribed = self.prescriptions.iter().map(|prescription| &prescription.on);
        for on in
            self.supports.iter().map(|support| &support.on).chain(prescribed).chain(self.loads.iter().map(|load| &load.on)).chain(surfaces)
        {
            if on.boundary.facets.is_empty() {
                return Err(ModelError::EmptyBoundary { boundary: self.boundary_name(on) });
            }
        }
        if let Some(load) = self.loads.iter().find(|load| matches!(load.kind, LoadKind::Pressure(_)) && self.dimension() != 2) {
            return Err(ModelError::PressureDimension { boundary: self.boundary_name(&load.on) });
        }
        let names = self.contact_names();
        for (index, name) in names.iter().enumerate() {
            if names[..index].contains(name) {
                return Err(ModelError::DuplicateName { what: "contact", name: name.to_string() });
            }
            if self.dimension() != 2 {
                return Err(ModelError::ContactDimension { contact: name.to_string(), dimension: self.dimension() });
            }
        }
        for contact in &self.contacts {
            let shares = |primary: &BodyBoundary| {
                contact.secondary.body == primary.body
                    && contact.secondary.boundary.facets.iter().any(|facet| primary.boundary.facets.contains(facet))
            };
            if contact.primary.iter().any(shares) {
                return Err(ModelError::SelfContact { contact: contact.name.clone(), boundary: self.boundary_name(&contact.secondary) });
            }
        }
        Ok(())
    }
}
