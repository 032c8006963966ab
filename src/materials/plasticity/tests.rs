//! Flow of a step from the yield surface; the law as a whole is tested in `tests/contracts/plasticity.rs`.

use super::constants::MOST_BACK_STRESSES;
use super::flow::{FlowStep, ROOT, Rule};
use super::*;
use crate::math::lanes::{Lanes, WIDTH};

const ZERO: Lanes<false> = Lanes::ZERO;

fn steel() -> ElasticPlastic {
    ElasticPlastic {
        youngs_modulus: 200.0,
        poisson_ratio: 0.3,
        density: 1.0,
        yield_stress: 0.5,
        hardening: Hardening::NONE,
        back_stresses: Vec::new(),
        rate: RateDependence::None,
    }
}

/// A shear of 1e-20 from a point on the yield surface, like the round-off of a rigid motion, whose straight path leaves the elastic range
/// within the step. The elastic fraction must have no derivative: it would be 1e34 times an excess of 1e-15 of the plastic strain.
#[test]
fn round_off_on_the_yield_surface_has_no_elastic_share_with_a_slope() {
    let law = steel();
    let size = ROOT * law.yield_stress * (1.0 + 1e-12) / (2.0 * law.shear_modulus()) / 2f64.sqrt();
    let at = |shear: f64| [size, -size, 0.0, shear].map(|x| Lanes([x; WIDTH]));
    for way in [1e-20, 1e-14, 1e-10] {
        let back = [[ZERO; 4]; MOST_BACK_STRESSES];
        let (strains, shear) = ([at(-0.24 * way), at(0.76 * way)], law.shear_modulus());
        let flow = FlowStep { law: &law, rule: Rule::Fitted, shear, dt: 0.1, strains, back, alpha: ZERO }.flow(true);
        let slope = flow.slopes.expect("they were asked for").share.map(|component| component.0[0]);
        let most = |values: &[f64]| values.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        let product = most(&slope) * most(&flow.strain.map(|component| component.0[0]));
        assert!(flow.strain[0].0[0] > 0.0 && product < 1.0, "{way:e}: {product:e}");
    }
}
