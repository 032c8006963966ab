//! Time functions: the scalar histories that loads follow.

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::math::tolerances::{EQUAL, SMALL_TIME, TIME_DIFFERENCE};

/// Error of a time function.
pub type TimeFunctionError = Box<dyn std::error::Error + Send + Sync>;

/// Scalar function of time, such as a load's amplitude. Script closures implement it, too, so evaluation may fail.
pub trait TimeFunction: Send + Sync {
    /// Value at `time`.
    ///
    /// # Errors
    /// Error of a user's function; the step is not taken.
    fn value(&self, time: f64) -> Result<f64, TimeFunctionError>;

    /// Rate of change at `time`, by default a central difference; at a kink the mean of the one-sided rates.
    ///
    /// # Errors
    /// Errors of [`value`](Self::value).
    fn rate(&self, time: f64) -> Result<f64, TimeFunctionError> {
        // The best step of a central difference is the cube root of the round-off.
        let h = TIME_DIFFERENCE * time.abs().max(SMALL_TIME);
        Ok((self.value(time + h)? - self.value(time - h)?) / (2.0 * h))
    }

    /// Known times of kinks; steps end at these times.
    fn corners(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Rate of a motion that follows the function: at the start, time 0, after a kink there, since no motion precedes it.
    ///
    /// # Errors
    /// Errors of [`value`](Self::value).
    fn rate_of_motion(&self, time: f64) -> Result<f64, TimeFunctionError> {
        self.rate(if time == 0.0 && self.corners().contains(&0.0) { beside(0.0) } else { time })
    }

    /// First time after the start at which the rate jumps, among the known kinks; `None` without one.
    fn jump(&self) -> Option<f64> {
        let rate = |time: f64| self.rate(time).unwrap_or(0.0);
        let jumps = |time: &f64| {
            let [before, after] = [rate(time - beside(*time)), rate(time + beside(*time))];
            (after - before).abs() > EQUAL * before.abs().max(after.abs())
        };
        self.corners().into_iter().filter(|time| *time > 0.0).find(jumps)
    }

    /// Text of the function, such as `hat(0, 0.5, 0.1)`.
    fn describe(&self) -> String;
}

/// Distance from a kink at `time` at which it is outside of the interval of the central difference `[time]`.
fn beside(time: f64) -> f64 {
    4.0 * TIME_DIFFERENCE * time.abs().max(SMALL_TIME)
}

/// Time function that several definitions may share.
pub type Amplitude = Arc<dyn TimeFunction>;

/// Constant time function.
#[derive(Clone, Copy, Debug)]
pub struct Constant(pub f64);

/// Piecewise linear hat: zero, `peak` in the middle between `start` and `end`, zero again.
#[derive(Clone, Copy, Debug)]
pub struct Hat {
    /// Last time of zero value before the rise `[time]`.
    pub start: f64,
    /// First time of zero value after the fall `[time]`.
    pub end: f64,
    /// Value in the middle, at `(start + end) / 2`.
    pub peak: f64,
}

/// Zero until `start`, linear to `value` at `end`, constant afterwards.
#[derive(Clone, Copy, Debug)]
pub struct Ramp {
    /// Last time of zero value before the rise `[time]`.
    pub start: f64,
    /// First time of constant value `[time]`.
    pub end: f64,
    /// Value from `end` on.
    pub value: f64,
}

/// `amplitude * sin(2 pi frequency t)`.
#[derive(Clone, Copy, Debug)]
pub struct Sine {
    /// Amplitude of the oscillation.
    pub amplitude: f64,
    /// Cycles per time `[1/time]`.
    pub frequency: f64,
}

/// Linear between given points, constant before the first and after the last.
#[derive(Clone, Debug)]
pub struct Table {
    points: Vec<(f64, f64)>,
}

impl Table {
    /// Table of `(time, value)` points with increasing times; `None` for an empty list or other orders.
    pub fn new(points: Vec<(f64, f64)>) -> Option<Self> {
        let increasing = points.windows(2).all(|pair| pair[0].0 < pair[1].0);
        (!points.is_empty() && increasing).then_some(Table { points })
    }
}

impl TimeFunction for Constant {
    fn value(&self, _: f64) -> Result<f64, TimeFunctionError> {
        Ok(self.0)
    }
    fn describe(&self) -> String {
        self.0.to_string()
    }
}

impl TimeFunction for Hat {
    fn value(&self, time: f64) -> Result<f64, TimeFunctionError> {
        let s = (time - self.start) / (self.end - self.start);
        Ok(self.peak * (1.0 - (2.0 * s - 1.0).abs()).max(0.0))
    }
    fn corners(&self) -> Vec<f64> {
        vec![self.start, 0.5 * (self.start + self.end), self.end]
    }
    fn describe(&self) -> String {
        format!("hat({}, {}, {})", self.start, self.end, self.peak)
    }
}

impl TimeFunction for Ramp {
    fn value(&self, time: f64) -> Result<f64, TimeFunctionError> {
        Ok(self.value * ((time - self.start) / (self.end - self.start)).clamp(0.0, 1.0))
    }
    fn corners(&self) -> Vec<f64> {
        vec![self.start, self.end]
    }
    fn describe(&self) -> String {
        format!("ramp({}, {}, {})", self.start, self.end, self.value)
    }
}

impl TimeFunction for Sine {
    fn value(&self, time: f64) -> Result<f64, TimeFunctionError> {
        Ok(self.amplitude * (TAU * self.frequency * time).sin())
    }
    fn describe(&self) -> String {
        format!("sine({}, {})", self.amplitude, self.frequency)
    }
}

impl TimeFunction for Table {
    fn value(&self, time: f64) -> Result<f64, TimeFunctionError> {
        let after = self.points.partition_point(|point| point.0 <= time);
        Ok(match after {
            0 => self.points[0].1,
            n if n == self.points.len() => self.points[n - 1].1,
            n => {
                let ((t0, v0), (t1, v1)) = (self.points[n - 1], self.points[n]);
                v0 + (v1 - v0) * (time - t0) / (t1 - t0)
            }
        })
    }
    fn corners(&self) -> Vec<f64> {
        self.points.iter().map(|point| point.0).collect()
    }
    fn describe(&self) -> String {
        format!("table of {} points", self.points.len())
    }
}

/// Time function converted to other units.
pub struct Rescaled {
    inner: Amplitude,
    time: f64,
    value: f64,
}

impl Rescaled {
    /// Time function with factors of time and value.
    pub fn of(inner: &Amplitude, time: f64, value: f64) -> Amplitude {
        if time == 1.0 && value == 1.0 { inner.clone() } else { Arc::new(Rescaled { inner: inner.clone(), time, value }) }
    }
}

impl TimeFunction for Rescaled {
    fn value(&self, time: f64) -> Result<f64, TimeFunctionError> {
        Ok(self.value * self.inner.value(time / self.time)?)
    }
    fn rate(&self, time: f64) -> Result<f64, TimeFunctionError> {
        Ok(self.value / self.time * self.inner.rate(time / self.time)?)
    }
    fn rate_of_motion(&self, time: f64) -> Result<f64, TimeFunctionError> {
        Ok(self.value / self.time * self.inner.rate_of_motion(time / self.time)?)
    }
    fn jump(&self) -> Option<f64> {
        Some(self.inner.jump()? * self.time)
    }
    fn corners(&self) -> Vec<f64> {
        self.inner.corners().into_iter().map(|time| time * self.time).collect()
    }
    fn describe(&self) -> String {
        self.inner.describe()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hat_rises_to_its_peak_in_the_middle_and_is_zero_outside() {
        let hat = Hat { start: 1.0, end: 3.0, peak: 4.0 };
        let values = [0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 9.0].map(|t| hat.value(t).unwrap());
        assert_eq!(values, [0.0, 0.0, 2.0, 4.0, 2.0, 0.0, 0.0]);
    }

    #[test]
    fn table_is_linear_inside_and_constant_outside() {
        let table = Table::new(vec![(0.0, 1.0), (2.0, 5.0)]).unwrap();
        assert_eq!([-1.0, 0.0, 1.0, 2.0, 7.0].map(|t| table.value(t).unwrap()), [1.0, 1.0, 3.0, 5.0, 5.0]);
        assert!(Table::new(vec![(1.0, 0.0), (1.0, 1.0)]).is_none());
    }

    #[test]
    fn motions_that_begin_with_a_kink_have_the_rate_after_it() {
        let ramp: Amplitude = Arc::new(Table::new(vec![(0.0, 0.0), (2.0, 6.0)]).unwrap());
        let rescaled = Rescaled { inner: ramp.clone(), time: 0.5, value: 2.0 };
        let near = |rate: Result<f64, TimeFunctionError>, exact: f64| (rate.unwrap() - exact).abs() < 1e-9;
        assert!(near(ramp.rate(0.0), 1.5) && near(ramp.rate_of_motion(0.0), 3.0) && near(ramp.rate_of_motion(1.0), 3.0));
        assert!(near(rescaled.rate_of_motion(0.0), 12.0) && near(rescaled.rate_of_motion(2.0), 0.0));
        assert_eq!([ramp.jump(), rescaled.jump()], [Some(2.0), Some(1.0)]);
    }
}
