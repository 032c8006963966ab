//! Properties of whole materials: stiffness at rest, change of units, homogeneous tests of specimens, soundness, fits to measurements.

use conserva::materials::{
    BatchedLaw, CATALOGUE, FitError, HYPERELASTIC, HomogeneousTest, Material, MaterialError, Measured, Response, StoredEnergy, Weakness,
    fit, path,
};
use conserva::math::lanes::Lanes;
use conserva::math::tensor::{mandel_pairs, mandel_scale};
use nalgebra::Matrix3;

fn response(law: &dyn BatchedLaw<6>, strain: &[f64; 6]) -> Response<6> {
    let mut response = [Response::ZERO];
    law.responses_into(&[strain.map(|x| Lanes([x; 8]))], &mut response);
    response[0]
}

#[test]
fn the_modulus_at_rest_is_the_one_that_was_given() {
    for row in CATALOGUE.iter().filter(|row| row.parameters[0].name == "youngs_modulus") {
        let material = Material::new(row, &[1234.5, 0.37, 1.0]).unwrap();
        let tangent = response(&*material.space(), &[0.0; 6]).tangent.map(|row| row.map(|entry| entry.0[0]));
        let [lambda, mu] = [tangent[0][1], 0.5 * tangent[3][3]];
        let modulus = mu * (3.0 * lambda + 2.0 * mu) / (lambda + mu);
        assert!((modulus - 1234.5).abs() < 1e-12 * 1234.5, "{}: {modulus}", row.name);
    }
}

#[test]
fn an_energy_without_stiffness_is_no_material() {
    for (text, factor) in [("0*I1", 1.0), ("I1 - I1", 1.0), ("mu*(I1 - 3 - 2*ln(J))", 0.0)] {
        let energy = StoredEnergy { factor, ..StoredEnergy::new(text, None, &[("mu", 1.0)]).unwrap() };
        assert_eq!(Material::hyperelastic(energy, 1.0).unwrap_err(), MaterialError::Slack { law: HYPERELASTIC });
    }
}

#[test]
fn other_units_and_turns_are_the_same_material() {
    let energy = StoredEnergy::new("mu/2*(I1bar - 3) + mu*(I4 - 1)^2", Some("mu*(J - 1)^2"), &[("mu", 2.0)]).unwrap();
    let material = Material::hyperelastic(energy.with_fibers(&[[1.0, 0.0, 0.0]]), 1.0).unwrap();
    let other = material.rescaled(|dimension| Some(if dimension == "stress" { 10.0 } else { 3.0 })).unwrap();
    assert!((other.youngs_modulus() - 10.0 * material.youngs_modulus()).abs() < 1e-12);
    assert_eq!(other.density(), 3.0);
    let stress = |material: &Material, strain: [f64; 3]| {
        let mut stress = [[Lanes::ZERO; 3]];
        material.plane().stresses_into(&[strain.map(|x| Lanes([x; 8]))], &mut stress);
        stress[0].map(|component| component.0[0])
    };
    let [a, b, c] = stress(&material, [0.1, -0.05, 0.03]);
    let [d, e, f] = stress(&material.turned(0.0, 1.0).unwrap(), [-0.05, 0.1, -0.03]);
    assert!((a - e).abs() + (b - d).abs() + (c + f).abs() < 1e-15, "{a} {e} {b} {d} {c} {f}");
}

#[test]
fn stresses_across_vanish_and_near_incompressible_pieces_keep_their_volume() {
    let stretches: Vec<f64> = (1..=20).map(|k| 1.0 + 0.05 * f64::from(k)).collect();
    for row in CATALOGUE {
        let material = Material::new(row, &row.example(1.0, 1.0)).unwrap();
        for (name, piece) in HomogeneousTest::ALL {
            let states = path(&material, piece, &stretches);
            assert!(states.len() >= 6, "{} {name}: {} states", row.name, states.len());
            for state in &states {
                let stress = {
                    let f = state.deformation_gradient();
                    let e = 0.5 * (f.transpose() * f - Matrix3::identity());
                    let strain = mandel_pairs::<6>().map(|(i, j)| e[(i, j)] / mandel_scale(i, j));
                    response(&*material.space(), &strain).stress.map(|x| x.0[0])
                };
                assert!(stress[2].abs() < 1e-11 && stress[4].abs() + stress[5].abs() < 1e-11, "{} {name}", row.name);
                assert!(state.nominal_stress > 0.0, "{} {name}", row.name);
            }
        }
    }
    let energy = StoredEnergy::new("mu/2*(I1bar - 3)", Some("k/2*(J - 1)^2"), &[("mu", 1.0), ("k", 1e5)]).unwrap();
    let rubber = Material::hyperelastic(energy, 1.0).unwrap();
    for (piece, closed) in [
        (HomogeneousTest::Uniaxial, (|l: f64| l - l.powi(-2)) as fn(f64) -> f64),
        (HomogeneousTest::Equibiaxial, |l| l - l.powi(-5)),
        (HomogeneousTest::PureShear, |l| l - l.powi(-3)),
    ] {
        let states = path(&rubber, piece, &[1.5, 2.0, 3.0]);
        assert_eq!(states.len(), 3);
        for state in states {
            // Treloar 1975; the effect of compressibility is of the order mu/k.
            let expected = closed(state.stretch);
            assert!((state.nominal_stress - expected).abs() < 1e-4 * expected, "{piece:?} {state:?} {expected}");
            assert!((state.deformation_gradient().determinant() - 1.0).abs() < 1e-4);
        }
    }
}

fn weaknesses(energy: &str, volumetric: &str) -> Vec<Weakness> {
    let energy = StoredEnergy::new(energy, Some(volumetric), &[("mu", 1.0)]).unwrap();
    Material::hyperelastic(energy, 1.0).unwrap().weaknesses()
}

#[test]
fn sound_laws_have_no_weakness_and_others_are_told() {
    assert_eq!(weaknesses("mu/2*(I1bar - 3)", "10*mu*(J - 1)^2"), []);
    let found = weaknesses("mu/2*I1bar", "10*mu*(J - 1)^2");
    assert_eq!(found, [Weakness::EnergyAtRest(1.5)]);
    // The law resists volume changes only; the stress at rest resists shear.
    let found = weaknesses("mu/2*(I1 - 3)", "10*mu*(J - 1)^2");
    let [Weakness::StressAtRest(stress), Weakness::StiffnessAtRest(stiffness)] = found[..] else { panic!("{found:?}") };
    assert!((stress - 1.0).abs() + stiffness.abs() < 1e-14, "{found:?}");
    // Shear modulus -1: the least eigenvalue of the tangent is twice that.
    let found = weaknesses("-mu/2*(I1bar - 3)", "10*mu*(J - 1)^2");
    assert!(matches!(found[..], [Weakness::StiffnessAtRest(stiffness)] if (stiffness + 2.0).abs() < 1e-12), "{found:?}");
    for row in CATALOGUE.iter().filter(|row| ["neo_hookean", "mooney_rivlin", "gent"].contains(&row.name)) {
        let found = Material::new(row, &row.example(1.0, 1.0)).unwrap().weaknesses();
        assert_eq!(found, [], "{}", row.name);
    }
}

#[test]
fn hencky_loses_ellipticity_where_the_closed_form_says() {
    // Incompressible pure shear with w(l) = 2 mu (ln l)^2: l^2 w'' + 2 l w'/(l^2 + 1) > 0 (Knowles and Sternberg, Journal of Elasticity
    // 5, 1975) is x tanh x < 1 with x = ln l: x = 1.19968.
    let found = weaknesses("mu*(log_strain_squared - ln(J)^2/3)", "5000*mu*ln(J)^2");
    let at = found.iter().find_map(|weakness| match weakness {
        Weakness::Ellipticity { test: "pure shear", stretch } if *stretch > 1.0 => Some(*stretch),
        _ => None,
    });
    // Directions lie four degrees from each other.
    assert!(at.is_some_and(|stretch| (stretch / 1.19968f64.exp() - 1.0).abs() < 0.01), "{found:?}");
}

#[test]
fn saint_venant_kirchhoff_loses_ellipticity_in_compression() {
    // With nu = 0, uniaxial compression: A_1111 = mu (3 l^2 - 1), which is zero at 1/sqrt 3.
    let row = CATALOGUE.iter().find(|row| row.name == "saint_venant_kirchhoff").unwrap();
    let found = Material::new(row, &[1.0, 0.0, 1.0]).unwrap().weaknesses();
    let at = |name: &str| {
        found.iter().find_map(|weakness| match weakness {
            Weakness::Ellipticity { test, stretch } if *test == name && *stretch < 1.0 => Some(*stretch),
            _ => None,
        })
    };
    let stretch = at("uniaxial").expect("it softens in compression");
    assert!(stretch > 0.5 && stretch < 0.999, "{found:?}");
    assert!(stretch >= 1.0 / 3f64.sqrt() - 1e-3, "lost at {stretch}, at the latest where the force is largest");
}

fn sampled(energy: &StoredEnergy) -> Vec<Measured> {
    let test = |(_, piece): &(&str, HomogeneousTest)| {
        let stretches: Vec<f64> = (1..=12).map(|k| 1.0 + 0.25 * f64::from(k)).collect();
        let stresses = energy.incompressible_stresses(*piece, &stretches).unwrap();
        Measured { piece: *piece, points: stretches.into_iter().zip(stresses).map(|(l, stress)| [l, stress]).collect() }
    };
    HomogeneousTest::ALL.iter().map(test).collect()
}

#[test]
fn constants_are_found_again() {
    let ogden = |values: &[f64]| {
        let text = "a/p*(stretch_power(p)*J^(-p/3) - 3) + b/q*(stretch_power(q)*J^(-q/3) - 3)";
        StoredEnergy::new(text, None, &[("a", values[0]), ("p", values[1]), ("b", values[2]), ("q", values[3])])
    };
    let exact = [0.62, 1.3, -0.01, -2.2];
    let found = fit(ogden, &[None; 4], &sampled(&ogden(&exact).unwrap())).unwrap();
    // The fit may return the two terms in reverse order.
    let mut pairs = [[found.constants[1], found.constants[0]], [found.constants[3], found.constants[2]]];
    pairs.sort_by(|a, b| b[0].total_cmp(&a[0]));
    for (found, exact) in pairs.iter().flatten().zip([1.3, 0.62, -2.2, -0.01]) {
        assert!((found - exact).abs() < 1e-5 * exact.abs(), "{pairs:?}");
    }
    let gent = |values: &[f64]| StoredEnergy::new("-mu*m/2*ln(1 - (I1bar - 3)/m)", None, &[("mu", values[0]), ("m", values[1])]);
    let found = fit(gent, &[None; 2], &sampled(&gent(&[0.27, 86.0]).unwrap())).unwrap();
    assert!((found.constants[0] - 0.27).abs() < 1e-6 && (found.constants[1] - 86.0).abs() < 1e-4, "{found:?}");
    assert!(found.rms < 1e-8 && found.r_squared > 1.0 - 1e-14, "{found:?}");
}

#[test]
fn a_linear_law_is_the_solution_of_the_normal_equations() {
    // Mooney-Rivlin in uniaxial tension: stress = 2 (l - l^-2) (c10 + c01/l); exact for two points.
    let energy = |values: &[f64]| StoredEnergy::new("c10*(I1bar - 3) + c01*(I2bar - 3)", None, &[("c10", values[0]), ("c01", values[1])]);
    let at = |l: f64| [l, 2.0 * (l - l.powi(-2)) * (0.2 + 0.03 / l)];
    let measured = [Measured { piece: HomogeneousTest::Uniaxial, points: vec![at(1.4), at(2.5)] }];
    let found = fit(energy, &[None, None], &measured).unwrap();
    assert!((found.constants[0] - 0.2).abs() < 1e-13 && (found.constants[1] - 0.03).abs() < 1e-13, "{found:?}");
    let error = fit(energy, &[None, None], &[Measured { piece: HomogeneousTest::Uniaxial, points: vec![at(2.0)] }]).unwrap_err();
    assert_eq!(error, FitError::Points { points: 1, constants: 2 });
}
