//! Contact of round parts of rigid bodies (`contact/rolling.rs`) in space: distances from obstacles, and slip.

use nalgebra::{Matrix3, Vector3};

use super::facets::Distance;
use super::obstacle::{Profile, Shape, StepGradient};
use super::slip::{self, Carrier, Group, SlipsInSpace};
use super::vectors::Vec3;
use super::vertices::NODES;
use crate::contact::numbers::Number;
use crate::contact::obstacle_side::{Local, ObstacleSide};
use crate::contact::patches::Evaluation;
use crate::contact::rolling::{RollingContact, Slips};
use crate::contact::slip::SlipStep;

/// Largest number of sides of an obstacle with pockets that a round part touches simultaneously.
const SIDES: usize = 3;

impl ObstacleSide<3> for Shape {
    fn sides(&self) -> usize {
        match self {
            Shape::Facets(facets) if facets.has_pockets() => SIDES,
            _ => 1,
        }
    }

    fn near(&self, x: Vector3<f64>, radius: f64, spare: f64) -> Vec<Self> {
        match self {
            Shape::Facets(facets) if facets.has_pockets() => {
                let (nearest, rising) = facets.around(x, radius + spare);
                if rising.is_empty() {
                    return vec![self.clone()];
                }
                let mut sides: Vec<usize> = std::iter::once(nearest).chain(rising).take(SIDES).collect();
                sides.sort_unstable();
                sides.into_iter().map(|side| Shape::Side(facets.clone(), side)).collect()
            }
            _ => vec![self.clone()],
        }
    }

    fn at(&self, x: Vector3<f64>) -> Local<3> {
        let Distance { gap, normal, curvature, covered } = self.distance(x);
        Local { gap, normal, curvature, covered }
    }

    fn between(&self, x_0: Vector3<f64>, x_1: Vector3<f64>, size: f64) -> (Vector3<f64>, Matrix3<f64>) {
        let StepGradient { bar, tangent } = self.step_gradient(x_0, x_1, size);
        (bar, tangent)
    }

    fn takes_rims(&self) -> bool {
        match self {
            Shape::Plane { .. } | Shape::Facets(_) | Shape::Side(..) => true,
            Shape::Revolved { profile, .. } => matches!(profile, Profile::Cylinder { .. }),
            Shape::Sphere { .. } => false,
        }
    }

    fn passage(&self, x_0: Vector3<f64>, x_1: Vector3<f64>, near: f64) -> (f64, bool) {
        (self.direction_change(x_0, x_1, near), self.is_crossed(x_0, x_1, near))
    }
}

/// Slip of round parts relative to the translating and rotating obstacle.
impl SlipsInSpace for RollingContact<3, Shape> {
    fn groups<T: Number>(&self, p: usize, z: &[Vec3<T>]) -> Vec<Group<T>> {
        let first = self.sides_near(p).len() * p;
        let group = |(place, obstacle_side): (usize, &Option<(Shape, Vector3<f64>)>)| {
            let (obstacle_side, at_start) = obstacle_side.as_ref()?;
            let (shares, normal) = self.touching(p, obstacle_side, z);
            let axis = slip::farthest_axis((*at_start).into());
            let mut weights = [T::from(0.0); NODES];
            for (weight, share) in weights.iter_mut().zip(shares) {
                *weight = share * self.weight(first + place);
            }
            Some(Group { place, weights, tangents: slip::tangents(normal, axis), covered: 1.0 })
        };
        self.sides_near(p).iter().enumerate().filter_map(group).collect()
    }

    fn carrier(&self) -> Option<Carrier> {
        self.shape().filter(|_| self.is_on_obstacle()).map(|shape| shape.carrier(self.carried, self.translations[2]))
    }
}

impl Slips for RollingContact<3, Shape> {
    fn slips(&self, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
        slip::evaluate(self, self.own_sides(), step, lambda, out);
    }
}
