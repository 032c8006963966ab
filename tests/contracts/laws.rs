//! Contract tests of every law of the catalogue, in plane strain, with a stretched third direction and in space.

use conserva::materials::{BatchedLaw, CATALOGUE, Components, IncrementResponse, Law, Material, MaterialRow, Response, StoredEnergy};
use conserva::math::lanes::{Lanes, Real, WIDTH};
use conserva::math::tensor::{Mandel, Tensor};
use conserva::math::tolerances::STRAIN_QUOTIENT;

/// Strains of a few sizes in the plane and in space, with increments of a few sizes; reproducible.
fn pairs<const S: usize>() -> Vec<(Components<S>, Components<S>)> {
    let mut seed = 7u64;
    let mut random = move || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    let mut all = Vec::new();
    for size in [1e-6, 1e-3, 0.2] {
        for step in [1e-7, 1e-4, 1e-2, 0.2] {
            let n: [f64; S] = std::array::from_fn(|_| size * random());
            let d: [f64; S] = std::array::from_fn(|_| step * random());
            let at = |s: f64| std::array::from_fn(|k| Lanes([n[k] + s * d[k]; WIDTH]));
            all.push((at(0.0), at(1.0)));
        }
    }
    all
}

fn energy<const S: usize>(law: &dyn BatchedLaw<S>, strain: &Components<S>) -> f64 {
    let mut energy = [Lanes::ZERO];
    law.energies_into(&[*strain], &mut energy);
    energy[0].0[5]
}

fn stress_tangent<const S: usize>(law: &dyn BatchedLaw<S>, strain: &Components<S>) -> ([f64; S], [[f64; S]; S]) {
    let (mut response, mut only_stress) = ([Response::ZERO], [[Lanes::ZERO; S]]);
    law.responses_into(&[*strain], &mut response);
    law.stresses_into(&[*strain], &mut only_stress);
    assert_eq!(response[0].stress, only_stress[0], "the two calls agree");
    (response[0].stress.map(|c| c.0[2]), response[0].tangent.map(|row| row.map(|c| c.0[2])))
}

fn increment<const S: usize>(law: &dyn BatchedLaw<S>, strain_n: &Components<S>, strain_n1: &Components<S>) -> IncrementResponse<S> {
    let mut increment = [IncrementResponse::ZERO];
    law.increments_into(&[*strain_n], &[*strain_n1], &mut increment);
    increment[0]
}

fn shifted<const S: usize>(strain: &Components<S>, component: usize, by: f64) -> Components<S> {
    let mut moved = *strain;
    moved[component] = moved[component] + by;
    moved
}

fn contract<const S: usize>(name: &str, law: &dyn BatchedLaw<S>, is_given: bool) {
    let rest = [Lanes::ZERO; S];
    let (stress, tangent) = stress_tangent(law, &rest);
    assert_eq!(energy(law, &rest), 0.0, "{name}: no energy at rest");
    assert_eq!(stress, [0.0; S], "{name}: no stress at rest");
    // Lame constants of Young's modulus 1000 and Poisson's ratio 0.3.
    let (lambda, mu) = (300.0 / (1.3 * 0.4), 1000.0 / 2.6);
    if is_given {
        // Tangent at rest: uniaxial modulus lambda + 2 mu and, because of Mandel components, 2 mu on the shear diagonal.
        assert!((tangent[0][0] - lambda - 2.0 * mu).abs() < 1e-12 * mu, "{name}: modulus at rest");
        assert!((tangent[S - 1][S - 1] - 2.0 * mu).abs() < 1e-12 * mu, "{name}: shear modulus at rest");
    }
    let mut compared = 0;
    for (n, n1) in pairs::<S>() {
        let (stress, tangent) = stress_tangent(law, &n1);
        let h = 1e-5;
        for k in 0..S {
            // Central differences leave h^2/6 times a third derivative of stress or energy, seen to be 60 and 600 moduli where the
            // strain is largest; round-off eps/h is below.
            let (up, down) = (shifted(&n1, k, h), shifted(&n1, k, -h));
            let ((above, stiffness), (below, other)) = (stress_tangent(law, &up), stress_tangent(law, &down));
            // The stiffness jumps within the difference, where fibers come into tension.
            if stiffness.iter().flatten().zip(other.iter().flatten()).any(|(a, b)| (a - b).abs() > 0.01 * mu) {
                continue;
            }
            let difference = (energy(law, &up) - energy(law, &down)) / (2.0 * h);
            assert!((difference - stress[k]).abs() < 2e-9 * mu, "{name}: stress {k} {difference} {}", stress[k]);
            for l in 0..S {
                compared += 1;
                let difference = (above[l] - below[l]) / (2.0 * h);
                assert!((difference - tangent[l][k]).abs() < 2e-8 * mu, "{name}: tangent {l}{k} {difference} {}", tangent[l][k]);
            }
        }
        // The remainder is compared with its definition, to the round-off of the terms of the definition.
        let mid: Components<S> = std::array::from_fn(|k| (n[k] + n1[k]) * 0.5);
        let d: [f64; S] = std::array::from_fn(|k| n1[k].0[0] - n[k].0[0]);
        let work: f64 = stress_tangent(law, &mid).0.iter().zip(d).map(|(s, d)| s * d).sum();
        let plain = energy(law, &n1) - energy(law, &n) - work;
        let IncrementResponse { mean, stress_end, remainder } = increment(law, &n, &n1);
        let remainder = remainder.0[0];
        let expected = stress_tangent(law, &mid);
        assert!(mean.tangent.iter().flatten().zip(expected.1.iter().flatten()).all(|(a, b)| (a.0[2] - b).abs() < 1e-14 * mu), "{name}");
        for k in 0..S {
            assert!((mean.stress[k].0[2] - expected.0[k]).abs() < 1e-15 * mu, "{name}: stress {k} at the mean");
            // Round-off of logarithms of order one, times a modulus.
            assert!((stress_end[k].0[2] - stress[k]).abs() < 1e-14 * mu, "{name}: stress {k} at the end");
        }
        let scale = energy(law, &n1).abs() + energy(law, &n).abs() + work.abs();
        // Energies given as text compute the remainder as a difference of terms of first order in the strain.
        let is_text = !["neo_hookean", "neo_hookean, power", "saint_venant_kirchhoff"].contains(&name);
        let first_order = n.iter().chain(&n1).map(|e| e.0[0].abs()).fold(0.0, f64::max);
        let scale = scale + if is_text { mu * first_order } else { 0.0 };
        assert!((remainder - plain).abs() < 1e-14 * scale, "{name}: remainder {remainder} against {plain}");
    }
    assert!(compared > 6 * S * S, "{name}: {compared} entries of tangents compared");
}

/// A material of a row, about as stiff as one with Young's modulus 1000.
fn example(row: &'static MaterialRow) -> Material {
    Material::new(row, &row.example(1000.0, 1000.0)).expect("the values are in their ranges")
}

#[test]
fn every_law_fulfils_the_contract_in_every_kind_of_strain() {
    for row in CATALOGUE {
        let material = example(row);
        let is_given = row.parameters[0].name == "youngs_modulus";
        contract::<3>(&row.title(), &*material.plane(), is_given);
        contract::<4>(&row.title(), &*material.axisymmetric(), is_given);
        contract::<6>(&row.title(), &*material.space(), is_given);
    }
}

#[test]
fn energies_as_text_fulfil_the_contract() {
    // Energies that together contain every function and every quantity, without stress at zero strain.
    for text in [
        "mu*((I1/3)^1.5/J - 1) + mu*ln(J)^2",
        "mu*(sinh(E11)^2 + cosh(E12) + tanh(E22)*E22 + exp(E33^2) + E23^2 + abs(E13)^5)",
        "mu*(sqrt(I3)*I1 - 2.5*I3) + mu*(I2bar - 3)^2/I2 + mu*J^(I1 - 3)/J^I1*J^3",
        "mu*(stretch_power(-1.3)*J^(1.3/3) - 3) + mu*log_strain_squared + mu*max(J - 1, 0)^5 - mu*min(0, I1bar - I2bar)^5",
        "mu*pos(I4bar - I6bar)^5 + mu*(I6 - 1)^2*I4 + pi*mu*pow(I4 - 1, 4)",
    ] {
        let energy = StoredEnergy::new(text, None, &[("mu", 300.0)]).unwrap().with_fibers(&[[1.0, 2.0, 0.0], [-1.0, 0.5, 0.3]]);
        let material = Material::hyperelastic(energy, 1.0).unwrap();
        contract::<3>(text, &*material.plane(), false);
        contract::<4>(text, &*material.axisymmetric(), false);
        contract::<6>(text, &*material.space(), false);
    }
}

/// `J - 1` of a strain in space.
fn change_of_volume(strain: &Components<6>) -> Lanes<false> {
    let e = Mandel(*strain);
    let growth = e.trace() * 2.0 + e.second_invariant() * 4.0 + e.determinant() * 8.0;
    Lanes(growth.0.map(|g| g / (1.0 + (1.0 + g).sqrt())))
}

#[test]
fn the_two_parts_of_a_split_add_up() {
    let mut found = 0;
    for row in CATALOGUE {
        let material = example(row);
        let Some(split) = material.split() else { continue };
        found += 1;
        let mu = material.youngs_modulus() / 3.0;
        for (_, strain) in pairs::<6>() {
            let change = change_of_volume(&strain);
            let (mut energies, mut responses) = ([Lanes::ZERO; 3], [[Lanes::ZERO; 2]; 3]);
            let changes = [change, change + 1e-5, change + -1e-5];
            split.volumetric.energies_into(&changes, &mut energies);
            split.volumetric.responses_into(&changes, &mut responses);
            let [u, up, down] = energies.map(|u| u.0[1]);
            let whole = energy::<6>(&*material.space(), &strain);
            assert!((energy::<6>(&*split.space, &strain) + u - whole).abs() < 1e-15 * mu, "{}", row.name);
            // As in `contract`: h^2/6 times a third derivative of less than 200 moduli.
            let [slope, curvature] = responses[0].map(|x| x.0[3]);
            assert!(((up - down) / 2e-5 - slope).abs() < 4e-9 * mu, "{}: slope {slope} {}", row.name, (up - down) / 2e-5);
            let difference = (responses[1][0].0[0] - responses[2][0].0[0]) / 2e-5;
            assert!((difference - curvature).abs() < 2e-8 * mu, "{}: curvature {curvature} {difference}", row.name);
            // W_d in the plane and with a stretched third direction is that in space.
            let [xx, yy, zz, xy, ..] = strain;
            let four = [xx, yy, zz, xy];
            let difference =
                energy::<4>(&*split.axisymmetric, &four) - energy::<6>(&*split.space, &[xx, yy, zz, xy, Lanes::ZERO, Lanes::ZERO]);
            assert!(difference.abs() < 1e-15 * mu, "{}: {difference}", row.name);
            let difference = energy::<3>(&*split.plane, &[xx, yy, xy])
                - energy::<6>(&*split.space, &[xx, yy, Lanes::ZERO, xy, Lanes::ZERO, Lanes::ZERO]);
            assert!(difference.abs() < 1e-15 * mu, "{}: {difference}", row.name);
        }
    }
    assert!(found > 0);
}

#[test]
fn default_remainder_is_exact_for_a_cubic_energy() {
    struct Sampled(f64);
    impl Law for Sampled {
        fn energy<T: Tensor>(&self, e: &T) -> T::Scalar {
            let t = e.trace();
            t * t * t * self.0
        }
        fn stress<T: Tensor>(&self, e: &T) -> T {
            T::identity() * (e.trace() * e.trace() * (3.0 * self.0))
        }
        fn stress_tangent<T: Tensor>(&self, e: &T) -> (T, T::Tangent) {
            (self.stress(e), T::isotropic_tangent(e.trace() * (6.0 * self.0), T::Scalar::splat(0.0), &T::identity()))
        }
    }
    // W = c (tr E)^3: remainder exactly c (tr dE)^3 / 4 at every step size, below and above the threshold.
    for step in [1e-7, 1e-3, 0.1] {
        let (n, n1) = ([Lanes::splat(0.1); 3], [Lanes::splat(0.1 + step); 3]);
        let remainder = increment::<3>(&Sampled(5.0), &n, &n1).remainder.0[0];
        let exact = 5.0 * (2.0 * step).powi(3) / 4.0;
        // For the large step the remainder is the plain difference, with the round-off of the energies.
        let round_off = if step < STRAIN_QUOTIENT { 15.0 * 0.4f64.powi(2) * step } else { 5.0 * 0.4f64.powi(3) };
        assert!((remainder - exact).abs() < 1e-15 * round_off, "step {step}: {remainder} {exact}");
    }
}
