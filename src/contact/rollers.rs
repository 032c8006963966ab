//! Round parts of rigid bodies with the bodies' masters: centers, axes, and the material points that touch.

use nalgebra::SVector;

use super::numbers::Number;
use super::obstacle_side::{Distance, ObstacleSide};
use super::round_parts::{Curvature, RoundPart};

/// Largest number of masters of a constraint: those of two bodies in space.
pub const MASTERS: usize = 8;

/// Circle or sphere of a rigid body that another one touches.
#[derive(Clone, Debug)]
pub struct RoundBody {
    /// Center, radius and nodes.
    pub part: RoundPart,
    /// Side of the circle on which the body lies.
    pub curvature: Curvature,
    /// Model node numbers of the masters, with their coefficients in the center.
    pub masters: Vec<(u32, f64)>,
}

/// Round part with the masters of its body.
#[derive(Clone, Debug)]
pub struct Roller<S> {
    /// Center, radius and nodes.
    pub part: RoundPart,
    /// Obstacle, or the other body about its center.
    pub shape: S,
    /// Model node numbers of the masters, with their coefficients in the center: those of the part's own body, then those of the other body
    /// with negative coefficients.
    pub masters: Vec<(u32, f64)>,
    /// Coefficients of the masters in the axis of a rim.
    pub axis: Option<Vec<f64>>,
    /// Second round body; `None` for an obstacle.
    pub other: Option<OtherBody>,
}

/// Second round body of a constraint.
#[derive(Clone, Debug)]
pub struct OtherBody {
    /// Center, radius and nodes.
    pub part: RoundPart,
    /// True if this body is the secondary side of the contact.
    pub is_secondary: bool,
}

impl<S> Roller<S> {
    /// Round part on an obstacle. `shares_of` maps a reference point to the body's masters with their coefficients.
    pub fn on_obstacle(part: RoundPart, shape: S, shares_of: &dyn Fn([f64; 3]) -> Vec<(u32, f64)>) -> Self {
        let masters = shares_of(part.center.into());
        let to = part.axis.map(|axis| shares_of((part.center + axis).into()));
        let axis = to.map(|to| to.iter().zip(&masters).map(|(to, from)| to.1 - from.1).collect());
        Roller { part, shape, masters, axis, other: None }
    }

    /// Two round bodies, at least one of them convex. `shape_of` returns the obstacle with this radius about the origin.
    pub fn between(secondary: &RoundBody, primary: RoundBody, shape_of: &dyn Fn(f64, Curvature) -> S) -> Self {
        let is_secondary = secondary.curvature == Curvature::Hollow;
        let (own, other) = if is_secondary { (primary, secondary.clone()) } else { (secondary.clone(), primary) };
        let negative = other.masters.iter().map(|(node, share)| (*node, -share));
        let masters = own.masters.into_iter().chain(negative).collect();
        let shape = shape_of(other.part.radius, other.curvature);
        Roller { part: own.part, shape, masters, axis: None, other: Some(OtherBody { part: other.part, is_secondary }) }
    }

    /// Center of the part, relative to that of the other body if there is one.
    pub fn center<const D: usize>(&self, q: &[f64]) -> SVector<f64, D> {
        self.masters.iter().map(|&(node, share)| place::<D>(node, q) * share).sum()
    }

    /// Number of masters of the part's own body.
    pub fn own(&self, dimension: usize) -> usize {
        self.masters.len().min(dimension + 1)
    }

    /// True if the force on the master `node` acts on the secondary side.
    pub fn is_on_secondary(&self, node: u32, dimension: usize) -> bool {
        let is_own = self.masters[..self.own(dimension)].iter().any(|(master, _)| *master == node);
        is_own != self.other.as_ref().is_some_and(|other| other.is_secondary)
    }

    /// Axis of a rim for the masters at `q`.
    pub fn axis<const D: usize>(&self, q: &[f64]) -> Option<SVector<f64, D>> {
        let Roller { masters, axis, .. } = self;
        axis.as_ref().map(|axis| masters.iter().zip(axis).map(|((node, _), share)| place::<D>(*node, q) * *share).sum())
    }

    /// Nodes of the secondary and of the primary side nearest to the contact point, for the normal at the part; nodes of the same side on
    /// an obstacle.
    pub fn nearest<const D: usize>(&self, q: &[f64], normal: SVector<f64, D>) -> [u32; 2] {
        let own = self.facing(q, -normal).0;
        let Some(OtherBody { part, is_secondary }) = &self.other else { return [own; 2] };
        let to_contact_point = self.center(q) - normal * self.part.radius;
        let other = farthest(part.inside.iter().copied(), q, to_contact_point).map_or(own, |(_, node)| node);
        if *is_secondary { [other, own] } else { [own, other] }
    }

    /// Node of a part that is farthest from the center in a direction (nearest to the other side), and true if the part faces that
    /// direction.
    pub fn facing<const D: usize>(&self, q: &[f64], direction: SVector<f64, D>) -> (u32, bool) {
        let nodes = &self.part.inside;
        let inside = farthest(nodes.iter().copied(), q, direction).unwrap_or((f64::NEG_INFINITY, nodes[0]));
        match farthest(self.part.rim.iter().map(|(node, _)| *node), q, direction) {
            Some((most, node)) if most > inside.0 => {
                let beside = self.part.rim.iter().filter(|(other, _)| *other == node).flat_map(|(_, inner)| inner);
                let inward: SVector<f64, D> = beside.map(|&other| place::<D>(other, q) - place::<D>(node, q)).sum();
                let out = (place::<D>(node, q) - self.center(q)).normalize();
                // Direction from the rim node along the surface.
                (node, (direction - out * direction.dot(&out)).dot(&inward) > 0.0)
            }
            _ => (inside.1, true),
        }
    }

    /// Coefficients of the masters, at `z` in mid-step, in the displacement of the material point that touches the side `obstacle_side`,
    /// relative to that of the other body, and the normal there; `moved` is the translation of the obstacle in mid-step.
    pub fn touching<T: Number, const D: usize>(&self, obstacle_side: &S, moved: SVector<f64, D>, z: &[[T; D]]) -> ([T; MASTERS], [T; D])
    where
        S: ObstacleSide<D>,
    {
        let Roller { masters, part, axis, .. } = self;
        let mut center = [T::from(0.0); D];
        for (&(_, share), z) in masters.iter().zip(z) {
            (0..D).for_each(|i| center[i] += z[i] * share);
        }
        let Distance { normal, curvature, .. } = obstacle_side.at(SVector::from_fn(|i, _| center[i].re() - moved[i]));
        let normal: [T; D] =
            std::array::from_fn(|i| (0..D).fold(T::from(normal[i]), |sum, k| sum + (center[k] - center[k].re()) * curvature[(i, k)]));
        let mut direction = normal;
        if let Some(shares) = axis {
            // Component perpendicular to the axis of a rim.
            let axis: [T; D] = std::array::from_fn(|i| shares.iter().zip(z).fold(T::from(0.0), |sum, (&share, z)| sum + z[i] * share));
            let dot = |a: &[T; D], b: &[T; D]| a.iter().zip(b).fold(T::from(0.0), |sum, (&a, &b)| sum + a * b);
            let along = dot(&normal, &axis) / dot(&axis, &axis);
            let across: [T; D] = std::array::from_fn(|i| normal[i] - axis[i] * along);
            let length = dot(&across, &across).sqrt().recip();
            direction = across.map(|x| x * length);
        }
        let arm = direction.map(|n| n * -part.radius);
        let mut shares = [T::from(0.0); MASTERS];
        let own = self.own(D);
        material_point(&z[..own], arm, 1.0, &masters[..own], &mut shares);
        if own < masters.len() {
            let arm = std::array::from_fn(|i| center[i] + arm[i]);
            material_point(&z[own..], arm, -1.0, &masters[own..], &mut shares[own..]);
        }
        (shares, normal)
    }
}

/// Coefficients of a body's masters at `z` in the displacement of its material point at the vector `arm` from the center, times `sign`;
/// `masters` have the coefficients of the center with this sign.
fn material_point<T: Number, const D: usize>(z: &[[T; D]], arm: [T; D], sign: f64, masters: &[(u32, f64)], shares: &mut [T]) {
    // Coordinates of the vector in the basis of the edges between masters.
    let edges = std::array::from_fn(|k| std::array::from_fn(|i| z[k + 1][i] - z[0][i]));
    let arm = coordinates(&edges, arm).map(|a| a * sign);
    for (k, (share, &(_, of_center))) in shares.iter_mut().zip(masters).enumerate() {
        *share = if k == 0 { arm.iter().fold(T::from(of_center), |sum, &a| sum - a) } else { arm[k - 1] + of_center };
    }
}

/// Node that is farthest in a direction, with its coordinate in that direction.
fn farthest<const D: usize>(nodes: impl Iterator<Item = u32>, q: &[f64], direction: SVector<f64, D>) -> Option<(f64, u32)> {
    nodes.map(|node| (place::<D>(node, q).dot(&direction), node)).max_by(|a, b| a.0.total_cmp(&b.0))
}

fn place<const D: usize>(node: u32, q: &[f64]) -> SVector<f64, D> {
    SVector::from_fn(|i, _| q[D * node as usize + i])
}

/// Coordinates `b` of a vector in the basis `e_k`, `sum_k b_k e_k = r`, by Cramer's rule.
fn coordinates<T: Number, const D: usize>(e: &[[T; D]; D], r: [T; D]) -> [T; D] {
    let with = |k: usize| -> [[T; D]; D] { std::array::from_fn(|j| if j == k { r } else { e[j] }) };
    let inverse = determinant(e).recip();
    std::array::from_fn(|k| determinant(&with(k)) * inverse)
}

fn determinant<T: Number, const D: usize>(m: &[[T; D]; D]) -> T {
    let minor = |i: usize, k: usize| m[1][i] * m[D - 1][k] - m[1][k] * m[D - 1][i];
    match D {
        2 => m[0][0] * m[1][1] - m[0][1] * m[1][0],
        _ => m[0][0] * minor(1, 2) + m[0][1] * minor(2, 0) + m[0][2] * minor(0, 1),
    }
}
