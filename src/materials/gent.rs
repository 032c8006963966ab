//! Gent law: chains of limited length.
//!
//! `W = -mu Jm/2 ln(1 - (I1bar - 3)/Jm) + K/4 (J^2 - 1 - 2 ln J)` (Gent, Rubber Chemistry and Technology 69, 1996). The stress is infinite
//! where `I1bar - 3` reaches `Jm`, and NaN beyond, so that such a step is halved.

use super::energy::StoredEnergy;
use super::row::{BULK_MODULUS, Construct, DENSITY, MaterialRow, VOLUMETRIC, number, stress};
use crate::math::catalogue::Interval;

pub(super) const ROW: MaterialRow = MaterialRow {
    name: "gent",
    summary: "Gent law: rubber that locks at a limiting stretch",
    formula: "W = -mu Jm/2 ln(1 - (I1bar - 3)/Jm) + K/4 (J^2 - 1 - 2 ln J), Jm: limit (Gent 1996)",
    volumetric: None,
    parameters: &[
        stress("mu", Interval::Positive, "shear modulus at rest"),
        number("limit", Interval::Positive, "value of I1bar - 3 that no stretch reaches: Jm, 30 to 100 for rubber"),
        BULK_MODULUS,
        DENSITY,
    ],
    example: &[0.36, 20.0, 1.0, 1.0],
    construct: Construct::Text(|values| {
        let &[mu, limit, bulk_modulus, _] = values else { unreachable!("as many values as parameters") };
        let constants = [("mu", mu), ("limit", limit), ("bulk_modulus", bulk_modulus)];
        StoredEnergy::new("-mu*limit/2*ln(1 - (I1bar - 3)/limit)", Some(VOLUMETRIC), &constants)
    }),
};
