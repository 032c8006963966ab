//! Hencky law: quadratic in the logarithms of the principal stretches.
//!
//! `W = mu sum (ln l_i)^2 + lambda/2 (ln J)^2` (Hencky, Zeitschrift fuer technische Physik 9, 1928; Anand, Journal of Applied Mechanics 46,
//! 1979). Split into `mu (sum (ln l_i)^2 - (ln J)^2/3)` and `K/2 (ln J)^2`. For moderate strains, up to stretches of about 1.5; loses
//! ellipticity in tension (in pure shear at a stretch of 3.3 where it is incompressible).

use super::energy::StoredEnergy;
use super::row::{Construct, DENSITY, MaterialRow, POISSON_RATIO, YOUNGS_MODULUS, lame};

pub(super) const ROW: MaterialRow = MaterialRow {
    name: "hencky",
    summary: "Hencky law: stress linear in the logarithmic strain; metals and plastics at moderate strains",
    formula: "W = mu sum (ln l_i)^2 + lambda/2 (ln J)^2 (Hencky 1928, Anand 1979)",
    volumetric: None,
    parameters: &[YOUNGS_MODULUS, POISSON_RATIO, DENSITY],
    example: &[1.0, 0.3, 1.0],
    construct: Construct::Text(|values| {
        let &[youngs_modulus, poisson_ratio, _] = values else { unreachable!("as many values as parameters") };
        let (lambda, mu) = lame(youngs_modulus, poisson_ratio);
        let constants = [("mu", mu), ("k", lambda + 2.0 / 3.0 * mu)];
        StoredEnergy::new("mu*(log_strain_squared - ln(J)^2/3)", Some("k/2*ln(J)^2"), &constants)
    }),
};
