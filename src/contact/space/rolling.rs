//! Slip of round parts of rigid bodies (`contact/rolling.rs`) in space.

use nalgebra::Vector3;

use super::obstacle::Shape;
use super::slip::{self, Carrier, Group, SlipsInSpace};
use super::vectors::Vec3;
use super::vertices::NODES;
use crate::contact::numbers::Number;
use crate::contact::patches::Evaluation;
use crate::contact::rolling::RollingContact;
use crate::contact::slip::{SlipStep, Slips};

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
            Some(Group { place, weights, tangents: slip::tangents(normal, axis), covered: 1.0, normal: None })
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
