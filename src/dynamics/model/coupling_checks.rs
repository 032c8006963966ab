//! Nodes of couplings, and the checks of couplings.

use nalgebra::Vector3;

use super::couplings::{CouplingKind, Sector};
use super::definitions::Model;
use super::error::ModelError;
use super::interactions::BodyBoundary;
use crate::math::digits::three_digits;
use crate::math::norms::length;
use crate::math::tolerances;
use crate::mesh::PointIndex;

const PLANE_REMEDY: &str = "take a flat boundary, or give the normal in which its nodes are held; a rigid body is guided by a joint";

const PERIODIC_REMEDY: &str = "both boundaries need the same nodes, moved or turned about the axis by the angle; unlike meshes are joined \
                               by a tie, rigid bodies by joints";

const REFERENCE_REMEDY: &str = "couple a boundary of a deformable body to a rigid body, on which forces, joints and springs then act; two \
                                rigid bodies are joined by a joint";

impl Model {
    /// Unit normal of the plane that contains the undeformed nodes of a boundary; `None` if there is no such plane, or no unique one.
    pub fn flat_normal(&self, on: &BodyBoundary) -> Option<[f64; 3]> {
        let mesh = &self.bodies[on.body].mesh;
        let points: Vec<[f64; 3]> = mesh.boundary_nodes(&on.boundary).into_iter().map(|node| mesh.points[node as usize]).collect();
        let first = Vector3::from(*points.first()?);
        let from_first = |point: &[f64; 3]| Vector3::from(*point) - first;
        let farthest = |of: &dyn Fn(Vector3<f64>) -> Vector3<f64>| {
            points.iter().map(|point| of(from_first(point))).max_by(|a, b| a.norm().total_cmp(&b.norm())).unwrap_or_default()
        };
        let along = farthest(&|vector| vector);
        let normal = if self.dimension() == 2 { Vector3::new(along[1], -along[0], 0.0) } else { farthest(&|vector| along.cross(&vector)) };
        let (size, near) = (normal.norm(), tolerances::SAME_NODE * self.extent());
        let normal = normal / size;
        let is_plane = size.is_normal() && points.iter().all(|point| from_first(point).dot(&normal).abs() <= near);
        is_plane.then_some(normal.into())
    }

    /// Node pairs of a periodic coupling: each node of the first boundary and its counterpart, by node numbers in their meshes.
    ///
    /// # Errors
    /// A node without a counterpart, or different numbers of nodes.
    pub fn opposite_nodes(&self, from: &BodyBoundary, to: &BodyBoundary, turn: Option<&Sector>) -> Result<Vec<[u32; 2]>, String> {
        let nodes = |on: &BodyBoundary| self.bodies[on.body].mesh.boundary_nodes(&on.boundary);
        let points = |on: &BodyBoundary| -> Vec<[f64; 3]> {
            nodes(on).into_iter().map(|node| self.bodies[on.body].mesh.points[node as usize]).collect()
        };
        let (own, others, numbers) = (points(from), points(to), nodes(to));
        let names = || [from, to].map(|on| self.boundary_name(on));
        if own.len() != others.len() {
            let [first, second] = names();
            return Err(format!("\"{first}\" has {} nodes, and \"{second}\" has {}", own.len(), others.len()));
        }
        let center =
            |of: &[[f64; 3]]| -> [f64; 3] { std::array::from_fn(|i| of.iter().map(|point| point[i]).sum::<f64>() / of.len() as f64) };
        let (a, b) = (center(&own), center(&others));
        let moved = |point: [f64; 3]| -> [f64; 3] {
            turn.map_or_else(|| std::array::from_fn(|i| point[i] - a[i] + b[i]), |turn| turn.carried(point))
        };
        let (index, near) = (PointIndex::new(&others), tolerances::SAME_NODE * self.extent());
        let opposite = |(&point, node): (&[f64; 3], u32)| {
            let place = moved(point);
            let found = index.nearest(place).filter(|(_, distance)| *distance <= near);
            found.map(|(other, _)| [node, numbers[other]]).ok_or_else(|| {
                let ([_, second], [point, place]) = (names(), [&point, &place].map(|at| &at[..self.dimension()]));
                format!("the node at {} is carried to {}, where \"{second}\" has no node", place_text(point), place_text(place))
            })
        };
        own.iter().zip(nodes(from)).map(opposite).collect()
    }

    /// Checks the names and definitions of all couplings.
    pub(super) fn check_couplings(&self) -> Result<(), ModelError> {
        for (index, coupling) in self.couplings.iter().enumerate() {
            let mut others = self.couplings[..index].iter().map(|other| other.name.as_str());
            let of_joints = self.joints.iter().map(|joint| joint.name.as_str());
            let of_parts = self.parts.iter().map(|part| part.name()).chain(self.contact_names()).chain(of_joints);
            if others.any(|name| name == coupling.name) || of_parts.into_iter().any(|name| name == coupling.name) {
                return Err(ModelError::DuplicateName { what: "coupling", name: coupling.name.clone() });
            }
            self.check_coupling(&coupling.kind).map_err(|reason| {
                let remedy = match coupling.kind {
                    CouplingKind::Plane { .. } => PLANE_REMEDY,
                    CouplingKind::Periodic { .. } => PERIODIC_REMEDY,
                    CouplingKind::Reference { .. } => REFERENCE_REMEDY,
                };
                ModelError::Unsound { what: coupling.kind.name(), name: coupling.name.clone(), reason, remedy }
            })?;
        }
        Ok(())
    }

    fn check_coupling(&self, kind: &CouplingKind) -> Result<(), String> {
        for on in kind.boundaries() {
            let body = &self.bodies[on.body];
            if body.mesh.boundary_nodes(&on.boundary).is_empty() {
                return Err(format!("\"{}\" has no nodes", self.boundary_name(on)));
            }
            if body.rigid.is_some() {
                return Err(format!("body \"{}\" is rigid, and one of its points stands for all", body.name));
            }
        }
        match kind {
            CouplingKind::Plane { normal, .. } => {
                let size = length(*normal);
                if !(size.is_finite() && size > 0.0) {
                    return Err(format!("the normal {normal:?} has no length"));
                }
                if self.is_axisymmetric() && normal[0].abs().min(normal[1].abs()) > tolerances::QUARTER_TURN * size {
                    return Err("around an axis a plane lies across it, or contains it".into());
                }
                Ok(())
            }
            CouplingKind::Reference { to, .. } => {
                let body = &self.bodies[*to];
                if body.rigid.is_none() {
                    return Err(format!("body \"{}\", to which it is coupled, deforms: only a rigid body has one motion", body.name));
                }
                if self.is_axisymmetric() {
                    return Err("bodies of revolution have no rigid bodies beside them".into());
                }
                Ok(())
            }
            CouplingKind::Periodic { from, to, turn, offset, follows } => {
                if turn.is_some() && self.is_axisymmetric() {
                    return Err("bodies of revolution are alike at all angles".into());
                }
                if let (Some(_), Some(_)) = (turn, offset.iter().flatten().next()) {
                    return Err("sectors that turn have no mean strain".into());
                }
                if let Some(body) = follows.map(|body| &self.bodies[body]) {
                    if body.rigid.is_none() {
                        return Err(format!("body \"{}\", which it follows, deforms: only a rigid body has one motion", body.name));
                    }
                    if turn.is_some() || offset.iter().any(Option::is_some) {
                        return Err(format!("it follows body \"{}\", and cannot turn or move over time besides", body.name));
                    }
                }
                let pairs = self.opposite_nodes(from, to, turn.as_ref())?;
                if from.body == to.body && pairs.iter().all(|[a, b]| a == b) {
                    let names = [from, to].map(|on| self.boundary_name(on));
                    return Err(format!("\"{}\" and \"{}\" have the same nodes, each opposite itself", names[0], names[1]));
                }
                for offset in offset.iter().flatten() {
                    let start = offset.value(0.0).unwrap_or(f64::NAN);
                    // Values that are not finite are reported when a step evaluates them.
                    if start.abs() > tolerances::DRIVE_AT_REST * self.extent() {
                        return Err(format!("the second boundary moves from {start} on, and in the bodies at rest it has not moved"));
                    }
                }
                Ok(())
            }
        }
    }
}

/// Text of a position, with three significant digits per coordinate.
fn place_text(place: &[f64]) -> String {
    format!("[{}]", place.iter().map(|&x| three_digits(x)).collect::<Vec<_>>().join(", "))
}
