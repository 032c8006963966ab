//! Arruda-Boyce law: eight chains from the center of a cube to its corners, as a series of five terms.
//!
//! `W = mu sum_i C_i / m^(2i-2) (I1bar^i - 3^i) + K/4 (J^2 - 1 - 2 ln J)` with `C = 1/2, 1/20, 11/1050, 19/7000, 519/673750` (Arruda and
//! Boyce, Journal of the Mechanics and Physics of Solids 41, 1993). The shear modulus at rest is greater than `mu`, by the factor `1 + 3/(5
//! m^2) + 99/(175 m^4) + 513/(875 m^6) + 42039/(67375 m^8)`. Unlike the inverse Langevin function that it approximates, the series stays
//! finite at the locking stretch `m`.

use super::energy::StoredEnergy;
use super::row::{BULK_MODULUS, Construct, DENSITY, MaterialRow, VOLUMETRIC, number, stress};
use crate::math::catalogue::Interval;

pub(super) const ROW: MaterialRow = MaterialRow {
    name: "arruda_boyce",
    summary: "Arruda-Boyce law: rubber as a network of eight chains, in a series of five terms",
    formula: "W = mu sum_i C_i/m^(2i-2) (I1bar^i - 3^i) + K/4 (J^2 - 1 - 2 ln J), \
              C = 1/2, 1/20, 11/1050, 19/7000, 519/673750 (Arruda and Boyce 1993)",
    volumetric: None,
    parameters: &[
        stress("mu", Interval::Positive, "rubber modulus n k T; a little less than the shear modulus at rest"),
        number("locking_stretch", Interval::Positive, "stretch of a chain at its full length: m, 2 to 8 for rubber"),
        BULK_MODULUS,
        DENSITY,
    ],
    example: &[0.33, 3.0, 1.0, 1.0],
    construct: Construct::Text(|values| {
        let &[mu, locking_stretch, bulk_modulus, _] = values else { unreachable!("as many values as parameters") };
        let constants = [("mu", mu), ("q", locking_stretch.powi(-2)), ("bulk_modulus", bulk_modulus)];
        let text = "mu*(1/2*(I1bar - 3) + q/20*(I1bar^2 - 9) + 11*q^2/1050*(I1bar^3 - 27) + 19*q^3/7000*(I1bar^4 - 81) \
                    + 519*q^4/673750*(I1bar^5 - 243))";
        StoredEnergy::new(text, Some(VOLUMETRIC), &constants)
    }),
};
