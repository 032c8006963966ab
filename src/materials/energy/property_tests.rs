//! Random energies: the stress is the derivative of the energy, the tangent the derivative of the stress; brackets and blanks in the text
//! change no result.

use proptest::prelude::*;

use super::*;
use crate::materials::{BatchedLaw, Components, Response};
use crate::math::lanes::{Lanes, Real};

/// Random energy texts that are finite and differentiable at all strains: roots, logarithms and quotients of positive arguments.
fn text() -> impl Strategy<Value = String> {
    let leaf = prop::sample::select(vec!["I1", "I2", "I3", "J", "I1bar", "I2bar", "E11", "E22", "E12", "I4", "mu", "0.7", "2"]);
    leaf.prop_map(String::from).prop_recursive(4, 24, 2, |inner| {
        let two = (inner.clone(), inner.clone(), prop::sample::select(vec!["+", "-", "*"]));
        let one = prop::sample::select(vec![
            "exp(-({})^2/50)",
            "ln(1 + ({})^2)",
            "sqrt(1 + ({})^2)",
            "1/(2 + ({})^2)",
            "({})^3/10",
            "-({})",
            "(3 + ({})^2)^-0.3",
        ]);
        prop_oneof![
            two.prop_map(|(a, b, sign)| format!("({a}) {sign} ({b})")),
            (inner, one).prop_map(|(a, form): (String, &str)| form.replace("{}", &a)),
        ]
    })
}

fn law(text: &str) -> std::sync::Arc<dyn BatchedLaw<6>> {
    let stored = StoredEnergy::new(text, None, &[("mu", 1.3)]).unwrap_or_else(|error| panic!("{text}: {error:?}"));
    stored.with_fibers(&[[0.6, 0.8, 0.0]]).laws().unwrap_or_else(|error| panic!("{text}: {error:?}")).space
}

/// Energy and response at a strain.
fn at(law: &dyn BatchedLaw<6>, strain: [f64; 6]) -> (f64, [f64; 6], [[f64; 6]; 6]) {
    let strain: Components<6> = strain.map(Lanes::splat);
    let (mut energy, mut response) = ([Lanes::ZERO], [Response::ZERO]);
    law.energies_into(&[strain], &mut energy);
    law.responses_into(&[strain], &mut response);
    let [Response { stress, tangent }] = response;
    (energy[0].0[0], stress.map(|x| x.0[0]), tangent.map(|row| row.map(|x| x.0[0])))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn stress_and_tangent_are_slopes(
        text in text(),
        strain in prop::array::uniform6(-0.15f64..0.15),
        way in prop::array::uniform6(-1.0f64..1.0),
    ) {
        const STEP: f64 = 1e-4;
        let law = law(&text);
        let moved = |by: f64| at(&*law, std::array::from_fn(|k| strain[k] + by * way[k]));
        let (_, stress, tangent) = moved(0.0);
        let far = [moved(-2.0 * STEP), moved(-STEP), moved(STEP), moved(2.0 * STEP)];
        // Central difference quotient of fourth order.
        let slope = |value: &dyn Fn(usize) -> f64| (value(0) - 8.0 * value(1) + 8.0 * value(2) - value(3)) / (12.0 * STEP);
        let dot = |a: &[f64; 6]| (0..6).map(|k| a[k] * way[k]).sum::<f64>();
        let largest = tangent.iter().flatten().chain(&stress).fold(far[0].0.abs().max(1.0), |most, x| most.max(x.abs()));
        let (exact, measured) = (dot(&stress), slope(&|k| far[k].0));
        prop_assert!((exact - measured).abs() < 1e-8 * largest, "{text}: stress {exact} and {measured}, {largest}");
        for row in 0..6 {
            let (exact, measured) = (dot(&tangent[row]), slope(&|k| far[k].1[row]));
            prop_assert!((exact - measured).abs() < 1e-8 * largest, "{text}: tangent {exact} and {measured}, {largest}");
            for column in 0..row {
                let (a, b) = (tangent[row][column], tangent[column][row]);
                prop_assert!((a - b).abs() < 1e-12 * largest, "{text}: {a} and {b}");
            }
        }
    }

    #[test]
    fn brackets_and_spaces_mean_nothing(text in text(), strain in prop::array::uniform6(-0.15f64..0.15)) {
        let spaced = format!("(( {} ))", text.replace('(', "( ").replace(')', " )").replace(' ', "  "));
        prop_assert_eq!(at(&*law(&text), strain), at(&*law(&spaced), strain));
    }
}
