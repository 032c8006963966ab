//! Limit of the friction force of a joint, from the multipliers of the joint's constraints.
//!
//! ```text
//! L = a |lambda_J| + b,    dL = a lambda_J . d lambda_J / |lambda_J|
//! ```
//!
//! `lambda_J` are the components of the transverse reaction, `a` the friction coefficient, for an angle times the radius over the length
//! that converts the angle, `b` the friction without reaction. `L` is the normal multiplier beside the tangential constraint of the joint.

use std::ops::Range;

use super::laws::Equation;
use crate::linear::{Block, Pattern};

/// Reaction of a joint with friction.
pub struct JointReaction {
    /// Constraints of the joint with the components of its transverse reaction.
    pub rows: Range<usize>,
    /// Limit `a` per reaction.
    pub by_reaction: f64,
    /// Limit `b` without reaction `[force]`.
    pub constant: f64,
    /// True if one end of the joint is fixed to the ground.
    pub is_grounded: bool,
    /// True if a drive prescribes the coordinate.
    pub is_driven: bool,
    /// Matrix blocks that couple the limit with each component of the reaction.
    places: Vec<Block>,
}

impl JointReaction {
    /// Limit of a joint whose first `components` constraints are components of its reaction; their numbers are assigned later.
    pub fn new(components: usize, [by_reaction, constant]: [f64; 2], is_grounded: bool, is_driven: bool) -> Self {
        JointReaction { rows: 0..components, by_reaction, constant, is_grounded, is_driven, places: Vec::new() }
    }

    /// Limit of the friction force for the multipliers of all constraints `[force]`.
    pub fn limit(&self, lambda: &[f64]) -> f64 {
        self.by_reaction * self.size(lambda) + self.constant
    }

    fn size(&self, lambda: &[f64]) -> f64 {
        lambda[self.rows.clone()].iter().fold(0.0f64, |size, component| size.hypot(*component))
    }

    /// Derivative of the limit with respect to each component of the reaction; zero without reaction.
    fn slopes<'a>(&'a self, lambda: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        let size = self.size(lambda);
        let by = if size > 0.0 { self.by_reaction / size } else { 0.0 };
        lambda[self.rows.clone()].iter().map(move |component| by * component)
    }

    /// Equation of the limit, linearized at the multipliers `lambda` and divided by `stiffness`; [`Self::couple`] writes its other entries.
    pub fn equation(&self, lambda: &[f64], stiffness: f64) -> Equation {
        let linear: f64 = self.slopes(lambda).zip(&lambda[self.rows.clone()]).map(|(slope, component)| slope * component).sum();
        Equation { acts: true, diagonal: 1.0 / stiffness, right: (self.limit(lambda) - linear) / stiffness, ..Equation::OPEN }
    }

    /// Finds the blocks of the constraint `row` of the limit in a new pattern; vertices of constraints follow `nodes` nodes.
    pub fn place(&mut self, pattern: &Pattern, nodes: usize, row: usize) {
        self.places = self.rows.clone().map(|component| pattern.block((nodes + row) as u32, (nodes + component) as u32)).collect();
    }

    /// Writes the factors of the components of the reaction in the equation of the limit into values of the matrix.
    pub fn couple(&self, equation: &Equation, lambda: &[f64], values: &mut [f64]) {
        let by = if equation.acts { -equation.diagonal } else { 0.0 };
        self.places.iter().zip(self.slopes(lambda)).for_each(|(place, slope)| values[place.at(0, 0)] = by * slope);
    }
}
