//! Ogden law: powers of the isochoric principal stretches, up to three terms.
//!
//! `W = sum_p mu_p/alpha_p (l1^alpha_p + l2^alpha_p + l3^alpha_p - 3) + K/4 (J^2 - 1 - 2 ln J)` of `l_i J^(-1/3)`; shear modulus at rest
//! `sum mu_p alpha_p / 2` (Ogden, Proceedings of the Royal Society A 326, 1972). `mu_p = 0` omits a term. The law is stable if `mu_p
//! alpha_p > 0` for every term.

use super::energy::StoredEnergy;
use super::row::{BULK_MODULUS, Construct, DENSITY, MaterialRow, VOLUMETRIC, number, stress};
use crate::math::catalogue::{Interval, Parameter};

pub(super) const ROW: MaterialRow = MaterialRow {
    name: "ogden",
    summary: "Ogden law: rubber to the largest stretches, in up to three powers of the principal stretches",
    formula: "W = sum_p mu_p/alpha_p (l1^alpha_p + l2^alpha_p + l3^alpha_p - 3) of J^(-1/3) l_i, + K/4 (J^2 - 1 - 2 ln J) (Ogden 1972)",
    volumetric: None,
    parameters: &[
        stress("mu1", Interval::Finite, "coefficient of the first term; the shear modulus at rest is half of the sum of mu_p alpha_p"),
        number("alpha1", Interval::Finite, "power of the first term, not 0"),
        Parameter { default: Some(0.0), ..stress("mu2", Interval::Finite, "coefficient of the second term") },
        Parameter { default: Some(2.0), ..number("alpha2", Interval::Finite, "power of the second term, not 0") },
        Parameter { default: Some(0.0), ..stress("mu3", Interval::Finite, "coefficient of the third term") },
        Parameter { default: Some(2.0), ..number("alpha3", Interval::Finite, "power of the third term, not 0") },
        BULK_MODULUS,
        DENSITY,
    ],
    example: &[0.4, 1.3, 0.02, 5.0, -0.05, -2.0, 1.0, 1.0],
    construct: Construct::Text(|values| {
        let &[mu1, alpha1, mu2, alpha2, mu3, alpha3, bulk_modulus, _] = values else { unreachable!("as many values as parameters") };
        let term = |p: u8| format!("mu{p}/alpha{p}*(stretch_power(alpha{p})*J^(-alpha{p}/3) - 3)");
        let terms: Vec<String> = [(1, mu1), (2, mu2), (3, mu3)].into_iter().filter(|(_, mu)| *mu != 0.0).map(|(p, _)| term(p)).collect();
        let text = if terms.is_empty() { "0".into() } else { terms.join(" + ") };
        let powers = [("alpha1", alpha1), ("alpha2", alpha2), ("alpha3", alpha3)];
        let constants = [[("mu1", mu1), ("mu2", mu2), ("mu3", mu3)], powers].concat();
        StoredEnergy::new(&text, Some(VOLUMETRIC), &[constants, vec![("bulk_modulus", bulk_modulus)]].concat())
    }),
};
