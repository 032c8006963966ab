//! Constants of an elastic-plastic material, and their checks.

use thiserror::Error;

use crate::math::catalogue::{Interval, OutOfRange};

/// Largest number of back stresses.
pub const MOST_BACK_STRESSES: usize = 4;

/// Invalid constants of an elastic-plastic material.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PlasticityError {
    /// A constant outside its range.
    #[error("`{constant}` of a material with plastic flow {fault}")]
    Constant {
        /// Name of the constant.
        constant: &'static str,
        /// Admissible range, and the given value outside of it.
        fault: OutOfRange,
    },
    /// Invalid table of a hardening curve.
    #[error("point {number} of the hardening table, [{strain}, {stress}], {fault}")]
    Table {
        /// Number of the point, from 1.
        number: usize,
        /// Plastic strain of the point.
        strain: f64,
        /// Yield stress of the point `[stress]`.
        stress: f64,
        /// Description of the fault, as the end of a sentence.
        fault: &'static str,
    },
    /// A table with too few points.
    #[error("the hardening table has {count} points; at least 2 make a curve")]
    ShortTable {
        /// Number of points.
        count: usize,
    },
    /// More back stresses than the maximum.
    #[error("{count} back stresses are given; there may be {MOST_BACK_STRESSES} at most")]
    BackStresses {
        /// Number of given back stresses.
        count: usize,
    },
}

impl PlasticityError {
    /// Stable code of the message, which `conserva doc` explains.
    pub fn code(&self) -> &'static str {
        match self {
            PlasticityError::Constant { .. } => "C0305",
            PlasticityError::Table { .. } | PlasticityError::ShortTable { .. } => "C0306",
            PlasticityError::BackStresses { .. } => "C0307",
        }
    }
}

/// Isotropic hardening: the yield stress `k` as a function of the equivalent plastic strain `alpha`.
#[derive(Clone, Debug, PartialEq)]
pub enum Hardening {
    /// `k = yield_stress + modulus alpha + saturation (1 - exp(-exponent alpha))` (linear; Voce, Journal of the Institute of Metals 74,
    /// 1948); perfect plasticity if both are zero.
    Saturating {
        /// Linear hardening modulus `[stress]`.
        modulus: f64,
        /// Gain of the yield stress in the limit of large plastic strain `[stress]`.
        saturation: f64,
        /// Inverse of the plastic strain at which 63 % of the saturation are reached.
        exponent: f64,
    },
    /// `k = yield_stress (1 + alpha/strain)^exponent` (Swift, Journal of the Mechanics and Physics of Solids 1, 1952).
    Swift {
        /// Plastic strain `strain` in the formula; the slope decreases over it.
        strain: f64,
        /// Exponent, from 0 to 1.
        exponent: f64,
    },
    /// `k = yield_stress + modulus alpha^exponent` (Ludwik 1909; Johnson and Cook 1983).
    Ludwik {
        /// Hardening modulus `[stress]`.
        modulus: f64,
        /// Exponent, from 0 to 1.
        exponent: f64,
    },
    /// Straight lines between points `[alpha, k]`, the first at 0; constant beyond the last.
    Table(Vec<[f64; 2]>),
}

impl Hardening {
    /// Perfect plasticity.
    pub const NONE: Self = Hardening::Saturating { modulus: 0.0, saturation: 0.0, exponent: 0.0 };

    /// Plastic strain of the last point of a table.
    pub fn last_strain(&self) -> Option<f64> {
        if let Hardening::Table(points) = self { points.last().map(|point| point[0]) } else { None }
    }
}

/// A back stress `X = 2/3 modulus a` with `da = dep - recovery a d alpha` (Armstrong and Frederick 1966; without recovery Prager 1955).
/// The uniaxial back stress grows by `modulus` per plastic strain, up to `modulus/recovery`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BackStress {
    /// Kinematic hardening modulus `[stress]`.
    pub modulus: f64,
    /// Coefficient of dynamic recovery.
    pub recovery: f64,
}

impl BackStress {
    /// Ratio of the back stress to the back strain, `X = factor a`.
    pub(super) fn factor(&self) -> f64 {
        2.0 / 3.0 * self.modulus
    }
}

/// Dependence of the yield stress on the rate of the plastic strain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum RateDependence {
    /// No dependence.
    #[default]
    None,
    /// `k + viscosity d alpha/dt` (Perzyna 1963, of exponent 1).
    Perzyna {
        /// Viscosity `[stress * time]`.
        viscosity: f64,
    },
    /// `k (1 + factor ln(d alpha/dt / reference_rate))` above the reference rate (Johnson and Cook 1983, without heat).
    JohnsonCook {
        /// Rate sensitivity `C`.
        factor: f64,
        /// Reference rate of the equivalent plastic strain `[1/time]`.
        reference_rate: f64,
    },
}

/// Elastic-plastic material: Hencky's law, von Mises yield condition, hardening.
#[derive(Clone, Debug, PartialEq)]
pub struct ElasticPlastic {
    /// Young's modulus `[stress]`.
    pub youngs_modulus: f64,
    /// Poisson's ratio.
    pub poisson_ratio: f64,
    /// Mass per undeformed volume `[mass/volume]`.
    pub density: f64,
    /// Yield stress in tension before any plastic strain `[stress]`.
    pub yield_stress: f64,
    /// Isotropic hardening.
    pub hardening: Hardening,
    /// Back stresses of kinematic hardening, which are summed.
    pub back_stresses: Vec<BackStress>,
    /// Rate dependence.
    pub rate: RateDependence,
}

impl ElasticPlastic {
    /// Shear modulus `[stress]`.
    pub fn shear_modulus(&self) -> f64 {
        0.5 * self.youngs_modulus / (1.0 + self.poisson_ratio)
    }

    /// Bulk modulus `[stress]`.
    pub fn bulk_modulus(&self) -> f64 {
        self.youngs_modulus / (3.0 - 6.0 * self.poisson_ratio)
    }

    /// Checks yield stress, hardening, back stresses and rate; the elastic law checks the other constants.
    ///
    /// # Errors
    /// The first constant that is outside its range.
    pub fn check(&self) -> Result<(), PlasticityError> {
        let within = |constant: &'static str, range: Interval, value: f64| {
            range.check(value).map(|_| ()).map_err(|fault| PlasticityError::Constant { constant, fault })
        };
        within("yield_stress", Interval::Positive, self.yield_stress)?;
        match &self.hardening {
            Hardening::Saturating { modulus, saturation, exponent } => {
                within("modulus", Interval::NonNegative, *modulus)?;
                within("saturation", Interval::NonNegative, *saturation)?;
                within("exponent", Interval::NonNegative, *exponent)?;
            }
            Hardening::Swift { strain, exponent } => {
                within("strain", Interval::Positive, *strain)?;
                within("exponent", Interval::Closed(0.0, 1.0), *exponent)?;
            }
            Hardening::Ludwik { modulus, exponent } => {
                within("modulus", Interval::NonNegative, *modulus)?;
                within("exponent", Interval::Closed(0.0, 1.0), *exponent)?;
            }
            Hardening::Table(points) => check_table(points)?,
        }
        if self.back_stresses.len() > MOST_BACK_STRESSES {
            return Err(PlasticityError::BackStresses { count: self.back_stresses.len() });
        }
        for back in &self.back_stresses {
            within("modulus", Interval::Positive, back.modulus)?;
            within("recovery", Interval::NonNegative, back.recovery)?;
        }
        match self.rate {
            RateDependence::None => {}
            RateDependence::Perzyna { viscosity } => within("viscosity", Interval::Positive, viscosity)?,
            RateDependence::JohnsonCook { factor, reference_rate } => {
                within("factor", Interval::Positive, factor)?;
                within("reference_rate", Interval::Positive, reference_rate)?;
            }
        }
        Ok(())
    }

    /// Constants converted to other units by the factors of stress, density and time.
    pub fn rescaled(&self, stress: f64, density: f64, time: f64) -> Self {
        let hardening = match &self.hardening {
            Hardening::Saturating { modulus, saturation, exponent } => {
                Hardening::Saturating { modulus: modulus * stress, saturation: saturation * stress, exponent: *exponent }
            }
            Hardening::Ludwik { modulus, exponent } => Hardening::Ludwik { modulus: modulus * stress, exponent: *exponent },
            Hardening::Table(points) => Hardening::Table(points.iter().map(|[strain, k]| [*strain, k * stress]).collect()),
            swift @ Hardening::Swift { .. } => swift.clone(),
        };
        let back = |back: &BackStress| BackStress { modulus: back.modulus * stress, recovery: back.recovery };
        let rate = match self.rate {
            RateDependence::Perzyna { viscosity } => RateDependence::Perzyna { viscosity: viscosity * stress * time },
            RateDependence::JohnsonCook { factor, reference_rate } => {
                RateDependence::JohnsonCook { factor, reference_rate: reference_rate / time }
            }
            RateDependence::None => RateDependence::None,
        };
        ElasticPlastic {
            youngs_modulus: self.youngs_modulus * stress,
            poisson_ratio: self.poisson_ratio,
            density: self.density * density,
            yield_stress: self.yield_stress * stress,
            hardening,
            back_stresses: self.back_stresses.iter().map(back).collect(),
            rate,
        }
    }
}

fn check_table(points: &[[f64; 2]]) -> Result<(), PlasticityError> {
    if points.len() < 2 {
        return Err(PlasticityError::ShortTable { count: points.len() });
    }
    for (index, &[strain, stress]) in points.iter().enumerate() {
        let fault = if !strain.is_finite() || !stress.is_finite() {
            "is not finite"
        } else if index == 0 && strain != 0.0 {
            "does not begin at a plastic strain of 0"
        } else if index > 0 && strain <= points[index - 1][0] {
            "has a plastic strain that is not above the one before"
        } else if stress <= 0.0 {
            "has a yield stress that is not positive"
        } else {
            continue;
        };
        return Err(PlasticityError::Table { number: index + 1, strain, stress, fault });
    }
    Ok(())
}
