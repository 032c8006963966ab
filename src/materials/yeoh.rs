//! Yeoh law: a cubic of the first isochoric invariant.
//!
//! `W = c10 (I1bar - 3) + c20 (I1bar - 3)^2 + c30 (I1bar - 3)^3 + K/4 (J^2 - 1 - 2 ln J)`; shear modulus at rest `2 c10` (Yeoh, Rubber
//! Chemistry and Technology 66, 1993). With negative `c20` it softens, then stiffens; it underestimates biaxial stress.

use super::energy::StoredEnergy;
use super::row::{BULK_MODULUS, Construct, DENSITY, MaterialRow, VOLUMETRIC, stress};
use crate::math::catalogue::Interval;

pub(super) const ROW: MaterialRow = MaterialRow {
    name: "yeoh",
    summary: "Yeoh law: filled rubber to large stretches, from uniaxial tests alone",
    formula: "W = c10 (I1bar - 3) + c20 (I1bar - 3)^2 + c30 (I1bar - 3)^3 + K/4 (J^2 - 1 - 2 ln J) (Yeoh 1993)",
    volumetric: None,
    parameters: &[
        stress("c10", Interval::Finite, "coefficient of the linear term; the shear modulus at rest is 2 c10"),
        stress("c20", Interval::Finite, "coefficient of the quadratic term"),
        stress("c30", Interval::Finite, "coefficient of the cubic term"),
        BULK_MODULUS,
        DENSITY,
    ],
    example: &[0.18, 0.02, 0.01, 1.0, 1.0],
    construct: Construct::Text(|values| {
        let &[c10, c20, c30, bulk_modulus, _] = values else { unreachable!("as many values as parameters") };
        let constants = [("c10", c10), ("c20", c20), ("c30", c30), ("bulk_modulus", bulk_modulus)];
        StoredEnergy::new("c10*(I1bar - 3) + c20*(I1bar - 3)^2 + c30*(I1bar - 3)^3", Some(VOLUMETRIC), &constants)
    }),
};
