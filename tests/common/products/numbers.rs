//! Numbers of a product: simple ones for the seed 0, random ones for others.

use super::super::splitmix::SplitMix;

/// Lengths, speeds, loads and steps of a product.
#[derive(Clone, Copy, Debug)]
pub struct Numbers {
    /// Distance of the body from its partner.
    pub gap: f64,
    /// Speed of the approach.
    pub speed: f64,
    /// Speed along the partner.
    pub slide: f64,
    /// Angular velocity.
    pub spin: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Factor of loads and prescribed motions.
    pub load: f64,
    /// Size of the steps.
    pub dt: f64,
    /// Number of steps.
    pub steps: usize,
    /// Step at which a run is interrupted.
    pub interrupted: usize,
    /// Angle by which a model is rotated.
    pub angle: f64,
    /// True if the joint connects the body to its partner.
    pub is_joined: bool,
}

impl Numbers {
    /// Multiplies gap, velocities and loads by a factor.
    pub fn scale(&mut self, by: f64) {
        for number in [&mut self.gap, &mut self.speed, &mut self.slide, &mut self.spin, &mut self.load] {
            *number *= by;
        }
    }

    /// Random numbers of a seed.
    pub fn new(seed: u64) -> Self {
        let plain = Numbers {
            gap: 0.01,
            speed: 1.0,
            slide: 0.3,
            spin: 0.5,
            friction: 0.3,
            load: 1.0,
            dt: 0.005,
            steps: 8,
            interrupted: 3,
            angle: 0.7,
            is_joined: false,
        };
        if seed == 0 {
            return plain;
        }
        let mut random = SplitMix(seed ^ 0x7072_6f64);
        let mut between = |low: f64, high: f64| low + (high - low) * random.below(1_000_000) as f64 * 1e-6;
        Numbers {
            gap: between(0.002, 0.02),
            speed: between(0.3, 1.5),
            slide: between(-0.5, 0.5),
            spin: between(-1.0, 1.0),
            friction: between(0.05, 1.0),
            load: between(0.3, 2.0),
            dt: 0.001 * 10f64.powf(between(0.0, 1.0)),
            steps: between(4.0, 12.0) as usize,
            interrupted: between(1.0, 6.0) as usize,
            angle: between(0.2, 3.0),
            is_joined: between(0.0, 1.0) > 0.5,
        }
    }
}
