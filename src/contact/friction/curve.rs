//! Friction law whose coefficient is a piecewise linear function of the slip speed.

use std::sync::Arc;

use super::law::{FrictionLaw, Limit, SlipState};

/// `L = mu f(v) p`; `f` is linear between the given points and constant beyond them.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionCurve {
    /// Points `(speed, f)`, speeds ascending.
    points: Vec<(f64, f64)>,
}

impl FrictionCurve {
    /// Law through `(speed, coefficient)` points; `None` without points, for speeds that do not increase, negative or non-finite numbers.
    pub fn new(points: Vec<(f64, f64)>) -> Option<Self> {
        let is_sound = points.iter().all(|(speed, value)| speed.is_finite() && value.is_finite() && *speed >= 0.0 && *value >= 0.0);
        let increases = points.windows(2).all(|pair| pair[0].0 < pair[1].0);
        (is_sound && increases && !points.is_empty()).then_some(FrictionCurve { points })
    }

    /// Friction coefficient at a speed, and its derivative.
    fn at(&self, speed: f64) -> (f64, f64) {
        match self.points.partition_point(|point| point.0 <= speed) {
            0 => (self.points[0].1, 0.0),
            after if after == self.points.len() => (self.points[after - 1].1, 0.0),
            after => {
                let ((v, a), (w, b)) = (self.points[after - 1], self.points[after]);
                let slope = (b - a) / (w - v);
                (a + slope * (speed - v), slope)
            }
        }
    }
}

impl FrictionLaw for FrictionCurve {
    fn depends_on_speed(&self) -> bool {
        self.points.len() > 1
    }

    fn limit(&self, SlipState { coefficient, pressure, speed }: SlipState) -> Limit {
        let (mu, slope) = self.at(speed);
        Limit { shear: coefficient * mu * pressure, by_pressure: coefficient * mu, by_speed: coefficient * slope * pressure }
    }

    fn in_units(&self, _stress: f64, speed: f64) -> Arc<dyn FrictionLaw> {
        Arc::new(FrictionCurve { points: self.points.iter().map(|(v, mu)| (speed * v, *mu)).collect() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_linear_between_its_points_and_constant_beyond() {
        let law = FrictionCurve::new(vec![(0.0, 0.5), (1.0, 0.3), (3.0, 0.4)]).unwrap();
        let at = |speed: f64| law.limit(SlipState { coefficient: 2.0, pressure: 10.0, speed });
        assert_eq!(at(0.0), Limit { shear: 10.0, by_pressure: 1.0, by_speed: 20.0 * (0.3 - 0.5) });
        let found = at(0.5);
        assert!((found.shear - 8.0).abs() < 1e-14 && (found.by_pressure - 0.8).abs() < 1e-14 && (found.by_speed + 4.0).abs() < 1e-13);
        assert_eq!(at(7.0), Limit { shear: 8.0, by_pressure: 0.8, by_speed: 0.0 });
        let other = law.in_units(3.0, 10.0).limit(SlipState { coefficient: 2.0, pressure: 30.0, speed: 5.0 });
        assert!((other.shear - 24.0).abs() < 1e-13 && (other.by_speed + 1.2).abs() < 1e-13);
    }

    #[test]
    fn what_is_no_curve_is_refused() {
        for points in [vec![], vec![(0.0, -0.1)], vec![(0.0, f64::NAN)], vec![(1.0, 0.1), (1.0, 0.2)], vec![(-1.0, 0.3)]] {
            assert_eq!(FrictionCurve::new(points), None);
        }
    }
}
