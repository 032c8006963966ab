//! Mooney-Rivlin law: linear in both isochoric invariants.
//!
//! `W = c10 (I1bar - 3) + c01 (I2bar - 3) + K/4 (J^2 - 1 - 2 ln J)`; shear modulus at rest `2 (c10 + c01)` (Mooney, Journal of Applied
//! Physics 11, 1940; Rivlin, Philosophical Transactions A 241, 1948). Valid up to stretches of about 2; does not model the stiffening of
//! rubber at larger stretches.

use super::energy::StoredEnergy;
use super::row::{BULK_MODULUS, Construct, DENSITY, MaterialRow, VOLUMETRIC, stress};
use crate::math::catalogue::Interval;

pub(super) const ROW: MaterialRow = MaterialRow {
    name: "mooney_rivlin",
    summary: "Mooney-Rivlin law: rubber at moderate stretches, up to about 2",
    formula: "W = c10 (I1bar - 3) + c01 (I2bar - 3) + K/4 (J^2 - 1 - 2 ln J) (Mooney 1940, Rivlin 1948)",
    volumetric: None,
    parameters: &[
        stress("c10", Interval::Finite, "coefficient of the first invariant; the shear modulus at rest is 2 (c10 + c01)"),
        stress("c01", Interval::Finite, "coefficient of the second invariant"),
        BULK_MODULUS,
        DENSITY,
    ],
    example: &[0.13, 0.05, 1.0, 1.0],
    construct: Construct::Text(|values| {
        let &[c10, c01, bulk_modulus, _] = values else { unreachable!("as many values as parameters") };
        let constants = [("c10", c10), ("c01", c01), ("bulk_modulus", bulk_modulus)];
        StoredEnergy::new("c10*(I1bar - 3) + c01*(I2bar - 3)", Some(VOLUMETRIC), &constants)
    }),
};
