//! Holzapfel-Gasser-Ogden law: a soft matrix with two families of fibers, as in the wall of an artery.
//!
//! `W = mu/2 (I1bar - 3) + k1/(2 k2) sum_i (exp(k2 <E_i>^2) - 1) + K/4 (J^2 - 1 - 2 ln J)` with `E_i = kappa (I1bar - 3) + (1 - 3 kappa)
//! (I4bar_i - 1)` and `<x> = max(x, 0)`: fibers carry no compression (Gasser, Ogden and Holzapfel, Journal of the Royal Society Interface
//! 3, 2006). The two families lie in the plane of the first two axes, at plus and minus `angle` to the first axis. The stiffness jumps
//! where fibers come into tension. The isochoric fiber term distorts the body unphysically under hydrostatic pressure (Nolan et al.,
//! Journal of the Mechanical Behavior of Biomedical Materials 39, 2014): write the energy with `I4` where that matters.

use super::energy::StoredEnergy;
use super::row::{BULK_MODULUS, Construct, DENSITY, MaterialRow, VOLUMETRIC, number, stress};
use crate::math::catalogue::{Interval, Parameter};

pub(super) const ROW: MaterialRow = MaterialRow {
    name: "holzapfel_gasser_ogden",
    summary: "Holzapfel-Gasser-Ogden law: soft tissue with two families of fibers that do not push",
    formula: "W = mu/2 (I1bar - 3) + k1/(2 k2) sum_i (exp(k2 <E_i>^2) - 1) + K/4 (J^2 - 1 - 2 ln J), \
              E_i = kappa (I1bar - 3) + (1 - 3 kappa) (I4bar_i - 1) (Gasser, Ogden and Holzapfel 2006)",
    volumetric: None,
    parameters: &[
        stress("mu", Interval::Positive, "shear modulus of the matrix"),
        stress("k1", Interval::NonNegative, "stiffness of the fibers"),
        number("k2", Interval::Positive, "how fast the fibers stiffen"),
        Parameter {
            default: Some(0.0),
            ..number("kappa", Interval::Closed(0.0, 1.0 / 3.0), "dispersion of the fibers: 0 all parallel, 1/3 all directions")
        },
        number("angle", Interval::Finite, "angle of the fibers to the first axis, in radians: `deg(30)`"),
        BULK_MODULUS,
        DENSITY,
    ],
    example: &[0.3, 0.3, 0.8, 0.1, 0.6, 1.0, 1.0],
    construct: Construct::Text(|values| {
        let &[mu, k1, k2, kappa, angle, bulk_modulus, _] = values else { unreachable!("as many values as parameters") };
        let constants = [("mu", mu), ("k1", k1), ("k2", k2), ("kappa", kappa), ("bulk_modulus", bulk_modulus)];
        let fiber = |name: &str| format!("k1/(2*k2)*(exp(k2*pos(kappa*(I1bar - 3) + (1 - 3*kappa)*({name} - 1))^2) - 1)");
        let text = format!("mu/2*(I1bar - 3) + {} + {}", fiber("I4bar"), fiber("I6bar"));
        let energy = StoredEnergy::new(&text, Some(VOLUMETRIC), &constants)?;
        Ok(energy.with_fibers(&[[angle.cos(), angle.sin(), 0.0], [angle.cos(), -angle.sin(), 0.0]]))
    }),
};
