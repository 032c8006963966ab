//! Prescribed motions of rigid obstacles, and driven coordinates of joints, in a step.

use super::contact_pair::{ContactPair, PairKind};
use super::obstacle_velocity::ObstacleVelocity;
use super::time_values::value_of;
use crate::dynamics::model::amplitude::Amplitude;
use crate::dynamics::model::joints::Coordinate;
use crate::dynamics::model::step_error::StepError;
use crate::math::tolerances;

impl ContactPair {
    /// Sets the positions of a rigid obstacle, or the coordinate of a drive, for a step of size `dt` from `time`.
    ///
    /// # Errors
    /// A time function of the motion failed, or the prescribed angle of the step is too large.
    pub fn move_obstacle(&mut self, time: f64, dt: f64) -> Result<(), StepError> {
        if let Some((coordinate, function)) = &self.drive {
            let ends = [value_of(&self.name, function, time)?, value_of(&self.name, function, time + dt)?];
            if *coordinate == Coordinate::Angle {
                self.check_angle(time, dt, ends)?;
            }
            self.kernel.drive(ends);
            // Functions in the middle of the step are those of the mean coordinate.
            self.is_driven = ends[0] != ends[1];
        }
        if self.kind != PairKind::Obstacle {
            return Ok(());
        }
        let at = |time: f64| Ok([self.at(&self.motion[0], time)?, self.at(&self.motion[1], time)?, self.at(&self.motion[2], time)?]);
        let translations = [at(time)?, at(time + 0.5 * dt)?, at(time + dt)?];
        let [start, _, end] = translations;
        let rate = |start: f64, end: f64| if dt > 0.0 { (end - start) / dt } else { 0.0 };
        let linear = std::array::from_fn(|i| rate(start[i], end[i]));
        self.obstacle_velocity = ObstacleVelocity { linear, ..ObstacleVelocity::default() };
        if let Some(axis) = self.turn.as_ref().and_then(|turn| turn.about) {
            let angles = [self.angle(time)?, self.angle(time + dt)?];
            self.check_angle(time, dt, angles)?;
            // Chords in place of arcs, as in the work of the drive (`contact/turning.rs`).
            let speed = 2.0 * (0.5 * (angles[1] - angles[0])).tan();
            let angular = axis.direction.map(|a| a * rate(0.0, speed));
            let pivot = std::array::from_fn(|i| axis.center[i] + end[i]);
            self.obstacle_velocity = ObstacleVelocity { linear, angular, pivot };
            self.kernel.turn_obstacle(angles);
        }
        self.kernel.move_obstacle(&translations);
        self.carry(time, time + dt)
    }

    /// Checks that a prescribed angle changes by at most an eighth of a turn in a step.
    fn check_angle(&self, time: f64, dt: f64, [start, end]: [f64; 2]) -> Result<(), StepError> {
        let angle = (end - start).abs();
        if angle > tolerances::EIGHTH_TURN {
            return Err(StepError::TurnsFar { boundary: self.name.clone(), time, dt, angle });
        }
        Ok(())
    }

    /// Moves the points of a rigid obstacle to which nodes stick, by the obstacle's motion between two times.
    ///
    /// # Errors
    /// A time function of the motion failed.
    pub fn carry(&mut self, from: f64, to: f64) -> Result<(), StepError> {
        if self.kind != PairKind::Obstacle || self.friction.is_none() {
            return Ok(());
        }
        let by = |function: &Option<Amplitude>| Ok(self.at(function, to)? - self.at(function, from)?);
        let (shift, angle) = ([by(&self.motion[0])?, by(&self.motion[1])?, by(&self.motion[2])?], self.angle(to)? - self.angle(from)?);
        self.kernel.carry(shift, angle);
        Ok(())
    }

    /// True if a moving rigid obstacle moves sticking nodes with it.
    pub fn carries(&self) -> bool {
        self.friction.is_some() && (self.motion.iter().any(Option::is_some) || self.turn.is_some())
    }

    /// True if the obstacle turns about its own axis, a motion that friction alone transmits.
    pub fn spins_in_place(&self) -> bool {
        self.turn.as_ref().is_some_and(|turn| turn.about.is_none())
    }

    /// Largest displacement of the obstacle between two times at the secondary nodes at the positions `q` `[length]`.
    ///
    /// # Errors
    /// A time function of the motion failed.
    pub fn obstacle_travel(&self, from: f64, to: f64, q: &[f64]) -> Result<f64, StepError> {
        let by = |function: &Option<Amplitude>| Ok(self.at(function, to)? - self.at(function, from)?);
        let shift: f64 = [by(&self.motion[0])?, by(&self.motion[1])?, by(&self.motion[2])?].iter().map(|x| x * x).sum();
        let Some(axis) = self.turn.as_ref().and_then(|turn| turn.about) else { return Ok(shift.sqrt()) };
        let d = self.kernel.patches().dimension();
        let nodes = self.kernel.secondary().nodes().iter().map(|&node| d * node as usize).filter(|&first| first + d <= q.len());
        let reach = axis.reach(nodes.map(|first| std::array::from_fn(|i| if i < d { q[first + i] } else { 0.0 })));
        Ok(shift.sqrt() + reach * (self.angle(to)? - self.angle(from)?).abs())
    }

    /// Angle of the obstacle's rotation.
    fn angle(&self, time: f64) -> Result<f64, StepError> {
        self.turn.as_ref().map_or(Ok(0.0), |turn| value_of(&self.name, &turn.angle, time))
    }

    /// A component of the obstacle's motion.
    fn at(&self, function: &Option<Amplitude>, time: f64) -> Result<f64, StepError> {
        function.as_ref().map_or(Ok(0.0), |function| value_of(&self.name, function, time))
    }
}
