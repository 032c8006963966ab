//! Interactions as defined in the model: one list of contacts, obstacles, self-contact and ties.

use std::slice;
use std::sync::Arc;

use super::amplitude::{Amplitude, TimeFunctionError};
use super::update_rules::UpdateRule;
use crate::contact::{
    ContactKernel, ContactMethod, ExactShape, FacetShape, FrictionLaw, MORTAR, Obstacle, ObstaclePlacement, ProxySurfacesInSpace,
    TurningAxis, TurningContact,
};
use crate::mesh::Boundary;

/// A boundary of a body.
#[derive(Clone, Debug)]
pub struct BodyBoundary {
    /// Index of the body in the model.
    pub body: usize,
    /// The boundary of the body's mesh.
    pub boundary: Boundary,
}

/// Enforcement of the contact constraints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Enforcement {
    /// Lagrange multipliers: the update rule holds exactly.
    Multiplier,
    /// Penalty potential `kappa/2 min(Phi, 0)^2` of the weighted gap `Phi`, `kappa = factor * youngs_modulus / (h w)` with the tributary
    /// length `w` of a node: small penetration, exact energy by the quotient `(U(Phi_1) - U(Phi_0)) / (Phi_1 - Phi_0)`. The update rule is
    /// not used.
    Penalty {
        /// Penalty stiffness (pressure per penetration) relative to `youngs_modulus / h`, `h` the shortest facet of the secondary body.
        factor: f64,
    },
    /// Augmented Lagrangian: `lambda = max(0, lambda_old - kappa (Phi - target))`, with the multiplier brought up to date in every Newton
    /// iteration until the update rule holds as exactly as with multipliers. It copes with constraints that depend on one another.
    /// `kappa = factor (youngs_modulus / h^2 + m_A / w_A^2 * 2 / dt^2)`: the stiffness of a facet and the inertia of the node.
    AugmentedLagrange {
        /// Augmentation relative to the node's stiffness in the step; larger values need fewer iterations.
        factor: f64,
    },
}

/// Friction of an interaction.
#[derive(Clone)]
pub struct Friction {
    /// Friction law: shear stress as a function of pressure and slip rate.
    pub law: Arc<dyn FrictionLaw>,
    /// Friction coefficient.
    pub coefficient: Coefficient,
}

/// A coefficient of friction, never negative.
#[derive(Clone)]
pub enum Coefficient {
    /// Constant coefficient.
    Constant(f64),
    /// Coefficient over time, taken at the middle of a step.
    OverTime(Amplitude),
    /// Coefficient as a function of place, evaluated at a contact point at the start of a step.
    OverPlace(Arc<dyn PlaceFunction>),
}

/// Scalar function of place. Script closures implement it, too, so evaluation may fail.
pub trait PlaceFunction: Send + Sync {
    /// Value at a point.
    ///
    /// # Errors
    /// Error of a user's function; the step is not taken.
    fn value(&self, point: [f64; 3]) -> Result<f64, TimeFunctionError>;

    /// Text form of the function.
    fn describe(&self) -> String;
}

/// A boundary with its contact partner, or with the boundary to which it is tied.
#[derive(Clone)]
pub struct Interaction {
    /// Name, unique among interactions.
    pub name: String,
    /// The side that carries the multipliers (slave, nonmortar).
    pub secondary: BodyBoundary,
    /// Contact partner of the secondary side.
    pub partner: Partner,
    /// Contact method between two surfaces, such as mortar or node-to-segment.
    pub method: &'static ContactMethod,
    /// Geometry of the facets of both sides; `None`: default of the method ([`Interaction::facet_shape`]).
    pub facets: Option<FacetShape>,
    /// Exact shapes of the secondary and of the primary side; `None`: the curve, or curved surface, through the nodes.
    pub shapes: [Option<Obstacle>; 2],
    /// Update rule; `None`: default of the time integrator ([`default_rule`](super::update_rules::default_rule)).
    pub update: Option<&'static UpdateRule>,
    /// Enforcement of the constraints.
    pub enforcement: Enforcement,
    /// Bilateral constraints: every covered node is active, tension is allowed.
    pub equality: bool,
    /// Friction; `None`: surfaces slide freely.
    pub friction: Option<Friction>,
    /// Coefficient of restitution of impacts between rigid sides, 0 to 1; `None`: that of the update rule ([`UpdateRule::restitution`]).
    pub restitution: Option<f64>,
}

/// Partner of the secondary side of an interaction.
#[derive(Clone)]
pub enum Partner {
    /// Boundaries of one or several bodies (master, mortar).
    Surfaces(Vec<BodyBoundary>),
    /// The secondary side itself, for self-contact of folds.
    Itself,
    /// A rigid obstacle.
    Obstacle {
        /// Shape and place of the obstacle.
        shape: Obstacle,
        /// Translation in x, y and z over time `[length]`; `None` without translation.
        motion: [Option<Amplitude>; 3],
        /// Rotation; `None` without rotation.
        turn: Option<ObstacleRotation>,
    },
    /// Boundary to which the secondary side is tied with nonmatching meshes; preferably the coarser one.
    Tied {
        /// Boundary to which the secondary side is tied.
        to: BodyBoundary,
        /// Largest distance of tied points in the undeformed bodies `[length]`; `None`: half of the shortest secondary facet.
        reach: Option<f64>,
    },
}

/// Rotation of a rigid obstacle about an axis.
#[derive(Clone)]
pub struct ObstacleRotation {
    /// Angle over time `[rad]`, counter-clockwise, in space as a right-handed screw.
    pub angle: Amplitude,
    /// Axis about which the shape turns; `None` for a round obstacle that turns about its own axis, which affects friction alone.
    pub about: Option<TurningAxis>,
}

impl ObstacleRotation {
    /// Contact with the obstacle that turns, from the contact with the obstacle at rest.
    pub fn turning(rotation: Option<&Self>, kernel: Box<dyn ContactKernel>, reference: &[f64]) -> Box<dyn ContactKernel> {
        match rotation.and_then(|rotation| rotation.about) {
            Some(axis) => Box::new(TurningContact::new(kernel, axis, reference)),
            None => kernel,
        }
    }
}

/// Place of a rigid obstacle at a time; motions whose time functions fail count as none, since steps report the failure.
pub fn obstacle_place(motion: &[Option<Amplitude>; 3], turn: Option<&ObstacleRotation>, time: f64) -> ObstaclePlacement {
    let at = |function: &Amplitude| function.value(time).ok().unwrap_or(0.0);
    let translation = motion.each_ref().map(|motion| motion.as_ref().map_or(0.0, at));
    let turned = turn.and_then(|turn| turn.about.map(|axis| axis.place(at(&turn.angle), translation)));
    turned.unwrap_or(ObstaclePlacement { translation, ..ObstaclePlacement::default() })
}

impl Interaction {
    /// Interaction by mortar contact with multipliers and the default update rule; other options are set in the fields.
    pub fn new(name: &str, secondary: BodyBoundary, partner: Partner) -> Self {
        Interaction {
            name: name.into(),
            secondary,
            partner,
            method: &MORTAR,
            facets: None,
            shapes: [None, None],
            update: None,
            enforcement: Enforcement::Multiplier,
            equality: false,
            friction: None,
            restitution: None,
        }
    }

    /// Contact with another boundary.
    pub fn contact(name: &str, secondary: BodyBoundary, primary: BodyBoundary) -> Self {
        Interaction::new(name, secondary, Partner::Surfaces(vec![primary]))
    }

    /// Contact with a fixed rigid obstacle.
    pub fn obstacle(name: &str, secondary: BodyBoundary, shape: Obstacle) -> Self {
        Interaction::new(name, secondary, Partner::Obstacle { shape, motion: [None, None, None], turn: None })
    }

    /// Tie of a boundary to another one: no relative motion.
    pub fn tie(name: &str, secondary: BodyBoundary, to: BodyBoundary) -> Self {
        Interaction::new(name, secondary, Partner::Tied { to, reach: None })
    }

    /// Boundaries of the primary side; empty for obstacles.
    pub fn primary(&self) -> &[BodyBoundary] {
        match &self.partner {
            Partner::Surfaces(primary) => primary,
            Partner::Itself => slice::from_ref(&self.secondary),
            Partner::Obstacle { .. } => &[],
            Partner::Tied { to, .. } => slice::from_ref(to),
        }
    }

    /// Geometry of the facets of both sides: curved by default; straight for node-to-segment contact in the plane without exact shapes,
    /// which rarely has an equilibrium between curves at rest.
    pub fn facet_shape(&self, dimension: usize) -> FacetShape {
        let is_straight = self.method.is_nodal && dimension == 2 && self.shapes.iter().all(Option::is_none);
        self.facets.unwrap_or(if is_straight { FacetShape::Straight } else { FacetShape::Curved })
    }

    /// Exact shapes of the secondary and of the primary side.
    pub fn exact_shapes(&self) -> [Option<ExactShape>; 2] {
        self.shapes.each_ref().map(|shape| shape.as_ref().and_then(ExactShape::new))
    }

    /// Radius of the exact shape of the secondary side, if it is a disk `[length]`.
    pub fn radius(&self) -> Option<f64> {
        match self.shapes[0] {
            Some(Obstacle::Disk { radius, .. }) => Some(radius),
            _ => None,
        }
    }

    /// Surfaces of a contact in space between the faces of both sides, with facets of its shape and its exact shapes, for nodes at
    /// `reference`.
    pub fn proxy_surfaces_in_space<'a>(&self, faces: &[Vec<Vec<u32>>; 2], reference: &'a [f64]) -> ProxySurfacesInSpace<'a> {
        let exact = self.exact_shapes();
        let surfaces = ProxySurfacesInSpace::new(faces.each_ref().map(|faces| &faces[..]), reference).of_shape(self.facet_shape(3));
        surfaces.of_exact(exact.map(|shape| shape.map(|shape| move |x, normal| shape.height_in_space(x, normal))))
    }

    /// True if the interaction is a tie.
    pub fn is_tie(&self) -> bool {
        matches!(self.partner, Partner::Tied { .. })
    }

    /// Rank of the interaction's kind in the order of contacts in a simulation.
    pub fn rank(&self) -> usize {
        match self.partner {
            Partner::Surfaces(_) => 0,
            Partner::Itself => 1,
            Partner::Obstacle { .. } => 2,
            Partner::Tied { .. } => 3,
        }
    }
}
