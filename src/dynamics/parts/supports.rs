//! Supports: displacement components that are fixed or follow a time function.
//!
//! Their unknowns stay in the numbering; rows and columns of the matrix are replaced by the identity.

use nalgebra::{DMatrix, DVector, Vector3, Vector6};

use super::body::Body;
use crate::bodies::Plane;
use crate::dynamics::model::definitions::{BodyDefinition, Model};
use crate::dynamics::model::interactions::BodyBoundary;
use crate::dynamics::model::prescription::{PrescribedMotion, Prescription};
use crate::dynamics::model::step_error::StepError;
use crate::math::norms::diameter;
use crate::math::tolerances;

/// A displacement component that follows a time function.
pub struct PrescribedUnknown {
    /// Index of the unknown.
    pub unknown: usize,
    /// Index of the prescribed motion among the motions of the supports.
    motion: usize,
    /// Position of the node at the start `[length]`.
    place: [f64; 3],
    /// Prescribed component.
    component: usize,
    /// Displacement at the start for bodies with initial displacements, otherwise `None` `[length]`.
    start: Option<f64>,
}

/// All supports of a model.
pub struct Supports {
    /// True for each displacement component that is fixed or prescribed.
    pub fixed: Vec<bool>,
    /// Components that follow a time function.
    pub prescribed: Vec<PrescribedUnknown>,
    /// Prescribed motions with the names of their boundaries.
    motions: Vec<(Prescription, String)>,
    /// Index of the prescribed rotation of each boundary of `held`; `None` without one.
    turning: Vec<Option<usize>>,
    /// Components supported by each boundary of [`Model::support_names`]; each component belongs to one of them.
    pub held: Vec<Vec<usize>>,
}

impl Supports {
    /// Number of free displacement components of a node.
    pub fn free_components<const D: usize>(&self, node: u32) -> usize {
        self.fixed[node as usize * D..][..D].iter().filter(|fixed| !**fixed).count()
    }

    /// Supports of a model with `unknowns` components.
    ///
    /// A component of a rigid body's motion that a prescribed motion of some nodes determines, such as the rotation of an edge, is
    /// prescribed at all its nodes: only prescribed nodes have the velocity of the time function, which differs from that of the time
    /// integrator by an error of second order in the step.
    pub fn new<const D: usize>(model: &Model, bodies: &[Body<D>], unknowns: usize) -> Self {
        let names = model.support_names();
        let number = |on: &BodyBoundary| names.iter().position(|name| *name == model.boundary_name(on));
        let nodes = |on: &BodyBoundary| model.bodies[on.body].mesh.boundary_nodes(&on.boundary);
        let global = |on: &BodyBoundary, node: u32, i: usize| (bodies[on.body].nodes.start + node as usize) * D + i;
        let mut held = HeldUnknowns { fixed: vec![false; unknowns], owner: vec![None; unknowns], prescribed: Vec::new() };
        for support in &model.supports {
            for node in nodes(&support.on) {
                let supported = (0..D).filter(|&i| support.components[i]);
                supported.for_each(|i| held.fix(global(&support.on, node, i), number(&support.on)));
            }
        }
        for (body, definition) in bodies.iter().zip(&model.bodies).filter(|(body, _)| body.rigid.is_none()) {
            held.fix_on_axis(body, definition);
        }
        bodies.iter().filter(|body| body.rigid.is_some()).for_each(|body| held.fix_along_edges(body, &model.start(body.number)));
        let (mut motions, mut turning) = (Vec::new(), vec![None; names.len()]);
        for prescription in &model.prescriptions {
            let (on, owner, motion) = (&prescription.on, number(&prescription.on), motions.len());
            let (points, places) = (&model.bodies[on.body].mesh.points, model.start(on.body));
            let is_displaced = model.initial_displacements.iter().any(|initial| initial.body == on.body);
            let moved = |node: u32, component: usize| {
                let place = places[node as usize];
                let start = is_displaced.then(|| place[component] - points[node as usize][component]);
                PrescribedUnknown { unknown: global(on, node, component), motion, place, component, start }
            };
            let own = nodes(on);
            for component in (0..D).filter(|&component| prescription.moves(component)) {
                own.iter().for_each(|&node| held.prescribe(moved(node, component), owner));
            }
            if let Some(rigid) = &bodies[on.body].rigid {
                let all = rigid.unknown_nodes().map(|node| node - bodies[on.body].nodes.start as u32);
                let others: Vec<u32> = all.filter(|node| own.binary_search(node).is_err()).collect();
                for component in determined_components::<D>(model, prescription, &places, &others) {
                    let free = others.iter().map(|&node| moved(node, component)).filter(|one| !held.fixed[one.unknown]);
                    let free: Vec<PrescribedUnknown> = free.collect();
                    free.into_iter().for_each(|one| held.prescribe(one, owner));
                }
            }
            if let (Some(number), Some(_)) = (owner, &prescription.turn) {
                turning[number] = Some(motion);
            }
            motions.push((prescription.clone(), model.boundary_name(on)));
        }
        let HeldUnknowns { fixed, owner, prescribed } = held;
        let mut held = vec![Vec::new(); names.len()];
        owner.iter().enumerate().for_each(|(unknown, owner)| owner.iter().for_each(|&number| held[number].push(unknown)));
        Supports { fixed, prescribed, motions, turning, held }
    }

    /// Name of the boundary that moves a prescribed unknown.
    pub fn boundary(&self, prescribed: &PrescribedUnknown) -> &str {
        &self.motions[prescribed.motion].1
    }

    /// Displacements and velocities of the prescribed unknowns at a time; prescribed displacements are added to initial ones.
    ///
    /// # Errors
    /// A time function failed, or returned a value that is not finite.
    pub fn prescribed_motion(&self, time: f64) -> Result<(Vec<f64>, Vec<f64>), StepError> {
        let motions = self.motions_at(time)?;
        let begun = if self.prescribed.iter().any(|one| one.start.is_some()) { self.motions_at(0.0)? } else { Vec::new() };
        let of = |one: &PrescribedUnknown| {
            let (moved, velocity) = motions[one.motion].of(one.place, one.component);
            let before = one.start.map_or(0.0, |start| start - begun[one.motion].of(one.place, one.component).0);
            (moved + before, velocity)
        };
        Ok(self.prescribed.iter().map(of).unzip())
    }

    fn motions_at(&self, time: f64) -> Result<Vec<PrescribedMotion<'_>>, StepError> {
        let mut motions = Vec::with_capacity(self.motions.len());
        for (motion, boundary) in &self.motions {
            motions.push(motion.at(time).map_err(|source| StepError::Amplitude { boundary: boundary.clone(), time, source })?);
        }
        Ok(motions)
    }

    /// Angle of the prescribed rotation of a boundary of `held` since the start `[rad]`; 0 without one.
    pub fn turned_by(&self, boundary: usize, time: f64) -> f64 {
        let turn = self.turning[boundary].and_then(|motion| self.motions[motion].0.turn.as_ref());
        let angle = |time: f64| turn.and_then(|turn| turn.angle.value(time).ok()).unwrap_or(0.0);
        (angle(time) - angle(0.0)).abs()
    }

    /// Largest prescribed rotation of a boundary between two times `[rad]`, and that boundary's name.
    ///
    /// # Errors
    /// A time function failed.
    pub fn turned(&self, from: f64, to: f64) -> Result<(f64, &str), StepError> {
        let mut largest = (0.0, "");
        for (motion, boundary) in &self.motions {
            let Some(turn) = &motion.turn else { continue };
            let angle = |time| turn.angle.value(time).map_err(|source| StepError::Amplitude { boundary: boundary.clone(), time, source });
            let turned = angle(to)? - angle(from)?;
            if turned.abs() > largest.0 {
                largest = (turned.abs(), boundary);
            }
        }
        Ok(largest)
    }

    /// True if a boundary has a prescribed rotation.
    pub fn turn(&self) -> bool {
        self.motions.iter().any(|(motion, _)| motion.turn.is_some())
    }
}

/// Supported components while supports are made.
struct HeldUnknowns {
    /// True for each fixed or prescribed component.
    fixed: Vec<bool>,
    /// Boundary of [`Model::support_names`] to which each component belongs.
    owner: Vec<Option<usize>>,
    /// Components that follow a time function.
    prescribed: Vec<PrescribedUnknown>,
}

impl HeldUnknowns {
    /// Fixes a component; it belongs to the first boundary that fixes it.
    fn fix(&mut self, unknown: usize, owner: Option<usize>) {
        self.fixed[unknown] = true;
        self.owner[unknown] = self.owner[unknown].or(owner);
    }

    /// Fixes the radial displacements on the axis of a body of revolution: other displacements would open a hole or pass the axis, and the
    /// stiffness against them is small, because a node on the axis has no circumference.
    fn fix_on_axis<const D: usize>(&mut self, body: &Body<D>, definition: &BodyDefinition) {
        if definition.formulation.plane != Plane::Axisymmetric {
            return;
        }
        let on_axis = definition.mesh.points.iter().enumerate().filter(|(_, point)| point[0] == 0.0);
        on_axis.for_each(|(node, _)| self.fix((body.nodes.start + node) * D, None));
    }

    /// Prescribes a component; a later prescription of the same one replaces an earlier one.
    fn prescribe(&mut self, one: PrescribedUnknown, owner: Option<usize>) {
        if self.fixed[one.unknown] {
            self.prescribed.retain(|other| other.unknown != one.unknown);
        }
        (self.fixed[one.unknown], self.owner[one.unknown]) = (true, owner);
        self.prescribed.push(one);
    }

    /// Fixes the components of a rigid body that its supports determine, but not in the linearized motion, at all its nodes ([`spans`]).
    fn fix_along_edges<const D: usize>(&mut self, body: &Body<D>, places: &[[f64; 3]]) {
        let first = body.nodes.start;
        for i in 0..D {
            let own: Vec<u32> = (0..places.len() as u32).filter(|&node| self.fixed[(first + node as usize) * D + i]).collect();
            if spans(places, &own, i) {
                let owner = self.owner[(first + own[0] as usize) * D + i];
                let nodes = body.rigid.iter().flat_map(|rigid| rigid.unknown_nodes());
                nodes.for_each(|node| self.fix(node as usize * D + i, owner));
            }
        }
    }
}

/// Components of the displacements of a rigid body's `others` that a prescribed motion of its nodes at `places` determines: those that
/// are zero in each rigid motion in which the prescribed components are zero. Supports count, too, in directions in which a prescribed
/// displacement leaves them at rest.
fn determined_components<const D: usize>(model: &Model, prescription: &Prescription, places: &[[f64; 3]], others: &[u32]) -> Vec<usize> {
    let nodes = |on: &BodyBoundary| model.bodies[on.body].mesh.boundary_nodes(&on.boundary);
    let (center, size, own) = (places[0], diameter(places.iter()), nodes(&prescription.on));
    let row = |node: u32, component: usize| displacement_by_rigid_motions(places[node as usize], center, size, component);
    let mut held = DMatrix::zeros(6, 6);
    let mut hold = |row: Vector6<f64>| held += row * row.transpose();
    let moved = |component: &usize| prescription.moves(*component);
    for component in (0..D).filter(moved) {
        own.iter().for_each(|&node| hold(row(node, component)));
        if prescription.turn.is_none() && spans(places, &own, component) {
            // No rotation changes the component.
            (0..3).filter(|&axis| axis != component).for_each(|axis| hold(Vector6::ith(3 + axis, 1.0)));
        }
    }
    for support in model.supports.iter().filter(|support| support.on.body == prescription.on.body) {
        for component in (0..D).filter(|component| support.components[*component] && !moved(component)) {
            nodes(&support.on).into_iter().for_each(|node| hold(row(node, component)));
        }
    }
    let free = null_vectors(held);
    let is_held = |component: usize| others.iter().all(|&node| free.iter().all(|free| is_absent(row(node, component).dot(free))));
    (0..D).filter(moved).filter(|&component| is_held(component)).collect()
}

/// True if distances between these nodes determine a component: the direction of the component lies in the line or the plane that they
/// span. Equal displacements by this component then keep the direction of the component in the body, although the linearized constraints
/// admit a rotation: the horizontal component of a horizontal edge.
fn spans(places: &[[f64; 3]], nodes: &[u32], component: usize) -> bool {
    let Some(&first) = nodes.first() else { return false };
    let center = Vector3::from(places[first as usize]);
    let mut spread = DMatrix::zeros(3, 3);
    for arm in nodes.iter().map(|&node| Vector3::from(places[node as usize]) - center) {
        spread += arm * arm.transpose();
    }
    null_vectors(spread).iter().all(|across| is_absent(across[component]))
}

/// Orthonormal vectors that a symmetric positive semidefinite matrix maps to zero, up to round-off.
fn null_vectors(matrix: DMatrix<f64>) -> Vec<DVector<f64>> {
    let (limit, eigen) = (tolerances::HELD * matrix.trace(), matrix.symmetric_eigen());
    eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()).filter(|(value, _)| **value <= limit).map(|(_, v)| v.into()).collect()
}

/// True for a component of a unit vector that is zero as far as [`null_vectors`] can tell.
fn is_absent(component: f64) -> bool {
    component * component <= tolerances::HELD
}

/// Displacement of a component of a point by each rigid motion: three translations, then three rotations about `center` times `size`.
fn displacement_by_rigid_motions(point: [f64; 3], center: [f64; 3], size: f64, component: usize) -> Vector6<f64> {
    let arm: [f64; 3] = std::array::from_fn(|i| (point[i] - center[i]) / size);
    let (next, last) = ((component + 1) % 3, (component + 2) % 3);
    let mut row = Vector6::zeros();
    (row[component], row[3 + next], row[3 + last]) = (1.0, arm[last], -arm[next]);
    row
}
