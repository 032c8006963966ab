//! Errors of a model: one sentence with the numbers that show the cause, and a hint.

use thiserror::Error;

use crate::bodies::FormulationError;
use crate::linear::RanksError;
use crate::math::digits::three_digits;

/// Reason why a model cannot be simulated.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A model without bodies.
    #[error("model \"{model}\" has no bodies")]
    NoBodies {
        /// Name of the model.
        model: String,
    },
    /// Two objects of one kind with the same name.
    #[error("there are two objects of kind {what} with the name \"{name}\"")]
    DuplicateName {
        /// Kind of the objects.
        what: &'static str,
        /// Name of both objects.
        name: String,
    },
    /// No initial size for adaptive steps: it cannot be derived from rigid bodies.
    #[error("the first step cannot be estimated if all bodies are rigid")]
    NoFirstStep,
    /// Body that cannot be rigid, for the given reason.
    #[error("body \"{body}\" cannot be rigid: {reason}")]
    NotRigid {
        /// Name of the body.
        body: String,
        /// Cause of the error.
        reason: String,
    },
    /// Joint without two different ends, or without a required direction.
    #[error("joint \"{joint}\" cannot be made: {reason}")]
    UnsoundJoint {
        /// Name of the joint.
        joint: String,
        /// Cause of the error.
        reason: String,
    },
    /// Drive, limits, gear or bushing with inconsistent data.
    #[error("{what} \"{name}\" cannot be made: {reason}")]
    Unsound {
        /// Kind of the entity.
        what: &'static str,
        /// Name of the entity.
        name: String,
        /// Cause of the error.
        reason: String,
        /// Suggested remedy.
        remedy: &'static str,
    },
    /// Joint with unilateral constraints under a time integrator with a force history.
    #[error("joint \"{joint}\" is unilateral, but the integrator \"{integrator}\" applies forces in later steps, too")]
    OneSidedJoint {
        /// Name of the joint.
        joint: String,
        /// Name of the integrator.
        integrator: &'static str,
    },
    /// A joint whose points do not coincide.
    #[error("joint \"{joint}\" at {place:?} is open: the points that it joins are {distance:.3e} apart")]
    JointApart {
        /// Name of the joint.
        joint: String,
        /// Reference position of the first point `[length]`.
        place: [f64; 3],
        /// Distance between both points `[length]`.
        distance: f64,
    },
    /// Bodies of different dimension.
    #[error("body \"{first}\" is {first_dimension}-dimensional, but body \"{second}\" is {second_dimension}-dimensional")]
    MixedDimensions {
        /// Name of the first body.
        first: String,
        /// Dimension of the first body.
        first_dimension: usize,
        /// Name of the other body.
        second: String,
        /// Dimension of the second body.
        second_dimension: usize,
    },
    /// Boundary that does not exist in the body.
    #[error("body \"{body}\" has no boundary \"{boundary}\"; it has {}", listed(.available))]
    UnknownBoundary {
        /// Name of the body.
        body: String,
        /// Name of the missing boundary.
        boundary: String,
        /// Names of the body's boundaries.
        available: Vec<String>,
    },
    /// Inconsistent coefficients of a time integrator.
    #[error("the integrator \"{integrator}\" is not sound: {reason}")]
    UnsoundIntegrator {
        /// Name of the integrator.
        integrator: &'static str,
        /// Violated condition.
        reason: &'static str,
    },
    /// Row sums of the cell masses are not positive at all nodes.
    #[error("the row sums of the mass of the cells of body \"{body}\" are not positive at all nodes")]
    NoLumpedMass {
        /// Name of the body.
        body: String,
    },
    /// Entity of the model that the steps of a time integrator do not support.
    #[error("{steps} do not take {what}: {reason}")]
    NotTaken {
        /// Kind of the steps.
        steps: &'static str,
        /// Unsupported entity of the model.
        what: String,
        /// Reason why the entity is not supported.
        reason: &'static str,
        /// Suggested remedy.
        instead: &'static str,
    },
    /// A boundary without facets.
    #[error("boundary \"{boundary}\" has no facets")]
    EmptyBoundary {
        /// Name of the boundary, `body.boundary`.
        boundary: String,
    },
    /// Boundary of single points where facets are required.
    #[error("\"{boundary}\" has single points, which have no area")]
    PointBoundary {
        /// Name of the boundary, `body.boundary`.
        boundary: String,
    },
    /// Initial displacements that invert a cell.
    #[error(
        "the initial displacement turns cell {cell} of body \"{body}\" inside out: the determinant of its deformation is {determinant:.2e}"
    )]
    InvertedAtStart {
        /// Name of the body.
        body: String,
        /// Number of the cell in its mesh.
        cell: usize,
        /// Smallest determinant of the deformation gradient.
        determinant: f64,
    },
    /// A contact of bodies in space with a property that is available in the plane only.
    #[error("contact \"{contact}\" is in space, and {what} is for plane bodies")]
    NotInSpace {
        /// Name of the contact.
        contact: String,
        /// Unsupported property of the contact.
        what: String,
    },
    /// An obstacle of the plane for bodies in space, or the reverse.
    #[error("contact \"{contact}\" has an obstacle of {of_shape} dimensions, and its body has {of_bodies}")]
    ObstacleDimension {
        /// Name of the contact.
        contact: String,
        /// Dimension of the obstacle.
        of_shape: usize,
        /// Dimension of the bodies.
        of_bodies: usize,
    },
    /// Contact pair whose sides share facets, defined as two surfaces.
    #[error("both sides of contact \"{contact}\" contain facets of \"{boundary}\"")]
    SelfContact {
        /// Name of the pair.
        contact: String,
        /// `body.boundary` of the secondary side.
        boundary: String,
    },
    /// Spring or damper with coinciding ends.
    #[error("the ends of \"{spring}\" are at the same place")]
    SpringOfNoLength {
        /// Name of the spring.
        spring: String,
    },
    /// A chamber whose surface has a rim.
    #[error("the surface of chamber \"{chamber}\" is open at ({})", place.map(three_digits).join(", "))]
    OpenChamber {
        /// Name of the chamber.
        chamber: String,
        /// A point of the surface's rim.
        place: [f64; 3],
    },
    /// Chamber without volume.
    #[error("chamber \"{chamber}\" encloses the volume {}", three_digits(*volume))]
    ChamberOfNoVolume {
        /// Name of the chamber.
        chamber: String,
        /// Computed volume.
        volume: f64,
    },
    /// Negative or non-finite mass.
    #[error("the mass of \"{part}\" is {mass}")]
    NoMass {
        /// Name of the point mass.
        part: String,
        /// Mass of the part.
        mass: f64,
    },
    /// The equations do not fit into memory.
    #[error("the model is too large: {reason}")]
    TooLarge {
        /// Number of unknowns or contact elements, and the shortage of memory.
        reason: String,
    },
    /// MPI processes (ranks) of the distributed solver that are missing, or have ended too early.
    #[error(transparent)]
    Ranks(#[from] RanksError),
    /// Boundary that is fixed and moved in one direction.
    #[error("\"{boundary}\" is held and moved in the direction {direction}")]
    HeldAndMoved {
        /// Name of the boundary, `body.boundary`.
        boundary: String,
        /// Direction in which the boundary is fixed and moved: x, y or z.
        direction: &'static str,
    },
    /// Two contacts between equal surfaces, whose constraints are linearly dependent.
    #[error("contacts \"{first}\" and \"{second}\" are between the same surfaces: \"{boundary}\" has the same facets opposite in both")]
    RepeatedContact {
        /// Name of the first contact.
        first: String,
        /// Name of the second contact.
        second: String,
        /// Secondary `body.boundary` of the second.
        boundary: String,
    },
    /// Contact between surfaces that are also tied.
    #[error("contact \"{contact}\" is between surfaces that \"{tie}\" ties: \"{boundary}\" has the same facets opposite in both")]
    TiedContact {
        /// Name of the contact.
        contact: String,
        /// Name of the tie.
        tie: String,
        /// Secondary `body.boundary` of the contact.
        boundary: String,
    },
    /// Exact shape that a contact cannot use.
    #[error("contact \"{contact}\" takes no exact shape: {reason}")]
    NoShape {
        /// Name of the contact.
        contact: String,
        /// Reason why the contact cannot use the shape.
        reason: &'static str,
        /// Suggested remedy.
        remedy: &'static str,
    },
    /// Node of a boundary that does not lie on the exact shape of the boundary.
    #[error(
        "node {node} of \"{boundary}\" at ({}) is {} off the exact shape of contact \"{contact}\"",
        place.iter().copied().map(three_digits).collect::<Vec<_>>().join(", "),
        three_digits(*distance)
    )]
    OffShape {
        /// Name of the contact.
        contact: String,
        /// Name of the boundary, `body.boundary`.
        boundary: String,
        /// Number of the node in its mesh.
        node: u32,
        /// Position of the node.
        place: Vec<f64>,
        /// Distance of the node from the shape `[length]`.
        distance: f64,
    },
    /// Formulation that is incompatible with a body.
    #[error("body \"{body}\": {source}")]
    Formulation {
        /// Name of the body.
        body: String,
        /// Cause of the error.
        source: FormulationError,
    },
    /// Model with both axisymmetric and other bodies.
    #[error("body \"{first}\" is axisymmetric and body \"{second}\" is not")]
    MixedSymmetry {
        /// Name of the first body.
        first: String,
        /// Name of the second body.
        second: String,
    },
    /// Load, support or other entity that breaks the symmetry of an axisymmetric model.
    #[error("{what} does not keep the symmetry of the axisymmetric model")]
    BreaksSymmetry {
        /// Entity that breaks the symmetry.
        what: String,
    },
    /// Coefficient of restitution of a contact that does not resolve impacts of rigid bodies.
    #[error("contact \"{contact}\" has no restitution: {reason}")]
    NoRestitution {
        /// Name of the contact.
        contact: String,
        /// Cause of the error.
        reason: String,
        /// Suggested remedy.
        remedy: &'static str,
    },
    /// A bilateral contact whose sides are apart at the start.
    #[error(
        "contact \"{contact}\" also pulls, and its sides are {} apart at the start, {} facets",
        three_digits(*gap),
        three_digits(*facets)
    )]
    OpenEquality {
        /// Name of the contact.
        contact: String,
        /// Largest distance of a secondary node from the other side `[length]`.
        gap: f64,
        /// Distance relative to the length of the secondary facets.
        facets: f64,
    },
    /// Inverted or degenerate cell.
    #[error("cell {cell} of body \"{body}\" has a Jacobian determinant of {jacobian:.3e}")]
    InvertedCell {
        /// Name of the body.
        body: String,
        /// Cell number in its mesh.
        cell: usize,
        /// Smallest Jacobian determinant at its quadrature points.
        jacobian: f64,
    },
}

/// Names in quotation marks, or `none`.
fn listed(names: &[String]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
    if quoted.is_empty() { "none".into() } else { quoted.join(", ") }
}

impl ModelError {
    /// Suggested remedy in one sentence.
    pub fn hint(&self) -> String {
        match self {
            ModelError::NoBodies { .. } => "add a body with a mesh and a material".into(),
            ModelError::DuplicateName { .. } => "give each its own name: messages, tables and files refer to it".into(),
            ModelError::MixedDimensions { .. } => "use meshes of one dimension in a model".into(),
            ModelError::UnknownBoundary { .. } => "use one of its boundaries, or select one with `Mesh::boundary_where`".into(),
            ModelError::UnsoundIntegrator { .. } => "mend its row: `integrators::Scheme` has what each coefficient stands for".into(),
            ModelError::NoLumpedMass { .. } => "lump the mass by its diagonal: `hrz`".into(),
            ModelError::NotTaken { instead, .. } => (*instead).into(),
            ModelError::EmptyBoundary { .. } => "choose a boundary that has facets".into(),
            ModelError::PointBoundary { .. } => {
                "points can be held, moved and loaded with a force; other loads and contacts need facets".into()
            }
            ModelError::InvertedAtStart { .. } => "displace neighboring nodes by less than their distance".into(),
            ModelError::ObstacleDimension { of_bodies: 3, .. } => {
                "give a plane a point and a normal of 3 numbers; bodies in space touch spheres, cylinders, cones, tori, boxes, surfaces"
                    .into()
            }
            ModelError::ObstacleDimension { .. } => {
                "give a plane a point and a normal of 2 numbers; plane bodies touch disks, rings and polylines".into()
            }
            ModelError::NotInSpace { .. } => {
                "bodies in space touch each other by the methods \"mortar\", \"dual_mortar\" and \"node_to_segment\", each itself by \
                 the first two; leave this out, take `hex27` where friction is, or use plane meshes"
                    .into()
            }
            ModelError::SelfContact { .. } => {
                "name two boundaries without common facets, or define a contact of the surface with itself where it folds".into()
            }
            ModelError::NoFirstStep => "give the size of the first step".into(),
            ModelError::NotRigid { .. } => {
                "give it the mass and the moments of inertia of a body, and a mesh with an area or a volume".into()
            }
            ModelError::UnsoundJoint { .. } => {
                "join a body to another one or to the ground, and give a direction where one is needed".into()
            }
            ModelError::Unsound { remedy, .. } => (*remedy).into(),
            ModelError::OneSidedJoint { .. } => {
                "stops and cables take an integrator without a memory of forces, such as the energy-momentum method, the midpoint rule or \
                 backward Euler: with others they would make energy out of nothing"
                    .into()
            }
            ModelError::JointApart { .. } => {
                "give points that are in the same place at the start, where displaced bodies are displaced".into()
            }
            ModelError::SpringOfNoLength { .. } => {
                "choose two ends that are apart: springs and dampers pull along the line between them".into()
            }
            ModelError::OpenChamber { .. } => {
                "name all boundaries around the gas, or where symmetry closes it a point in the planes of all its rims".into()
            }
            ModelError::ChamberOfNoVolume { .. } => "name the boundaries that face the gas: it is outside their bodies".into(),
            ModelError::NoMass { .. } => "give a mass of 0 or more".into(),
            ModelError::TooLarge { .. } => "use fewer cells, or a machine with more memory".into(),
            ModelError::Ranks(error) => error.hint().into(),
            ModelError::Formulation { source, .. } => source.hint(),
            ModelError::RepeatedContact { .. } => "define one contact for each pair of surfaces".into(),
            ModelError::TiedContact { .. } => {
                "leave the contact out where the tie holds, or give each its own facets: constraints of one follow from those of the other"
                    .into()
            }
            ModelError::HeldAndMoved { .. } => "hold the other directions only, or leave this one out of the motion".into(),
            ModelError::MixedSymmetry { .. } => "make all bodies of the model axisymmetric, or none".into(),
            ModelError::BreaksSymmetry { .. } => {
                "keep to motions along the axis, the second direction, and to loads that are even around it".into()
            }
            ModelError::NoRestitution { remedy, .. } | ModelError::NoShape { remedy, .. } => (*remedy).into(),
            ModelError::OffShape { .. } => {
                "compare its center, axis and radius with the mesh; all nodes of the side lie on the shape, middles of edges, too".into()
            }
            ModelError::OpenEquality { .. } => {
                "let the sides touch at the start wherever they are opposite each other, name only the part of the boundary that touches, \
                 or take a contact that only presses"
                    .into()
            }
            ModelError::InvertedCell { .. } => {
                "mend the mesh: nodes of a cell run counter-clockwise and its angles stay below 180 degrees".into()
            }
        }
    }
}
