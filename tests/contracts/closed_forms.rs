//! Stresses of the catalogue's laws against closed forms, written by hand from the literature, to 1e-12 of the modulus.
//!
//! In deformations that keep the volume the differences of the principal Cauchy stresses are those of the incompressible law: for
//! `W(I1, I2)` uniaxial `2 (l^2 - 1/l) (W1 + W2/l)`, equibiaxial `2 (l^2 - l^-4) (W1 + l^2 W2)`, simple shear `s12 = 2 g (W1 + W2)`,
//! `s11 - s33 = 2 g^2 W1`, `s22 - s33 = -2 g^2 W2` (Treloar, The Physics of Rubber Elasticity, 1975, chapter 10; Rivlin 1948).

use std::sync::Arc;

use conserva::materials::{BatchedLaw, CATALOGUE, Components, HomogeneousTest, Material, MaterialRow, Response, StoredEnergy, path};
use conserva::math::lanes::{Lanes, WIDTH};
use conserva::math::tensor::{mandel_pairs, mandel_scale};
use nalgebra::Matrix3;

type Matrix = Matrix3<f64>;

/// Row of the catalogue with this name, of a law with several forms that of the default.
fn row(name: &str) -> &'static MaterialRow {
    CATALOGUE.iter().find(|row| row.name == name).expect("the catalogue has it")
}

/// Lame constants `[stress]`.
fn lame(youngs_modulus: f64, poisson_ratio: f64) -> (f64, f64) {
    let mu = youngs_modulus / (2.0 * (1.0 + poisson_ratio));
    (2.0 * mu * poisson_ratio / (1.0 - 2.0 * poisson_ratio), mu)
}

fn components(e: &Matrix) -> Components<6> {
    mandel_pairs::<6>().map(|(i, j)| Lanes([e[(i, j)] / mandel_scale(i, j); WIDTH]))
}

fn matrix(components: &Components<6>) -> Matrix {
    let mut result = Matrix::zeros();
    for (k, (i, j)) in mandel_pairs::<6>().into_iter().enumerate() {
        let entry = components[k].0[4] * mandel_scale(i, j);
        (result[(i, j)], result[(j, i)]) = (entry, entry);
    }
    result
}

fn cauchy(law: &dyn BatchedLaw<6>, f: &Matrix) -> Matrix {
    let e = (f.transpose() * f - Matrix::identity()) * 0.5;
    let mut stress = [[Lanes::ZERO; 6]];
    law.stresses_into(&[components(&e)], &mut stress);
    f * matrix(&stress[0]) * f.transpose() / f.determinant()
}

fn stretched(l1: f64, l2: f64, l3: f64) -> Matrix {
    Matrix::from_diagonal(&[l1, l2, l3].into())
}

fn sheared(g: f64) -> Matrix {
    Matrix::new(1.0, g, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
}

/// A material of the catalogue whose stresses are compared with closed forms.
struct Compared {
    material: Material,
    law: Arc<dyn BatchedLaw<6>>,
    name: &'static str,
}

impl Compared {
    fn new(row: &'static MaterialRow) -> Self {
        let material = Material::new(row, &row.example(1.0, 1.0)).unwrap();
        Compared { law: material.space(), material, name: row.name }
    }

    #[track_caller]
    fn close(&self, what: &str, found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-12, "{}, {what}: {found} against {expected}", self.name);
    }

    /// Compares with closed forms of the principal stresses without pressure, as functions of the stretches.
    fn principal(&self, stress: impl Fn([f64; 3], usize) -> f64) {
        for l in [0.5, 0.9, 1.0, 1.0 + 1e-9, 1.3, 2.0] {
            let across = 1.0 / f64::sqrt(l);
            for stretches in [[l, across, across], [l, l, l.powi(-2)], [l, 1.0, 1.0 / l], [1.2 * l, 0.8, 1.0 / (0.96 * l)]] {
                let s = cauchy(&*self.law, &stretched(stretches[0], stretches[1], stretches[2]));
                let at = |i: usize| stress(stretches, i);
                self.close(&format!("{stretches:?}, 1 - 2"), s[(0, 0)] - s[(1, 1)], at(0) - at(1));
                self.close(&format!("{stretches:?}, 1 - 3"), s[(0, 0)] - s[(2, 2)], at(0) - at(2));
            }
        }
        for g in [1e-9f64, 0.1, 0.7, 2.0] {
            // l - 1/l = g; the first principal axis of b has the slope l: s12 = (s1 - s2) l/(1 + l^2).
            let l = 0.5 * g + (1.0 + 0.25 * g * g).sqrt();
            let s = cauchy(&*self.law, &sheared(g));
            let at = |i: usize| stress([l, 1.0 / l, 1.0], i);
            self.close(&format!("shear {g}"), s[(0, 1)], (at(0) - at(1)) * l / (1.0 + l * l));
        }
    }

    /// Closed forms by the derivatives of `W(I1, I2)`.
    fn invariants(&self, w1: impl Fn(f64) -> f64, w2: f64) {
        let first = |l: [f64; 3]| l.iter().map(|l| l * l).sum::<f64>();
        self.principal(|l, i| 2.0 * l[i] * l[i] * w1(first(l)) - 2.0 * w2 / (l[i] * l[i]));
        for l in [0.6, 1.5] {
            let s = cauchy(&*self.law, &stretched(l, 1.0 / f64::sqrt(l), 1.0 / f64::sqrt(l)));
            let expected = 2.0 * (l * l - 1.0 / l) * (w1(l * l + 2.0 / l) + w2 / l);
            self.close("uniaxial", s[(0, 0)] - s[(1, 1)], expected);
            let s = cauchy(&*self.law, &stretched(l, l, l.powi(-2)));
            let expected = 2.0 * (l * l - l.powi(-4)) * (w1(2.0 * l * l + l.powi(-4)) + l * l * w2);
            self.close("equibiaxial", s[(0, 0)] - s[(2, 2)], expected);
        }
        for g in [0.2f64, 1.1] {
            let (s, w1) = (cauchy(&*self.law, &sheared(g)), w1(3.0 + g * g));
            self.close("shear", s[(0, 1)], 2.0 * g * (w1 + w2));
            self.close("shear, 1 - 3", s[(0, 0)] - s[(2, 2)], 2.0 * g * g * w1);
            self.close("shear, 2 - 3", s[(1, 1)] - s[(2, 2)], -2.0 * g * g * w2);
        }
    }

    /// Compares the pressure in purely volumetric deformations with `slope`, the function `U'(J)`.
    fn volume(&self, slope: impl Fn(f64) -> f64) {
        for l in [0.7, 1.0 - 1e-9, 1.4] {
            let s = cauchy(&*self.law, &stretched(l, l, l));
            (0..3).for_each(|i| self.close("volume", s[(i, i)], slope(l.powi(3))));
        }
    }
}

/// `U'` of `K/4 (J^2 - 1 - 2 ln J)` with `K = 1`.
fn simo_taylor(j: f64) -> f64 {
    0.5 * (j - 1.0 / j)
}

#[test]
fn laws_of_invariants() {
    let mooney = Compared::new(row("mooney_rivlin"));
    mooney.invariants(|_| 0.13, 0.05);
    mooney.volume(simo_taylor);
    let yeoh = Compared::new(row("yeoh"));
    yeoh.invariants(|i1| 0.18 + 2.0 * 0.02 * (i1 - 3.0) + 3.0 * 0.01 * (i1 - 3.0).powi(2), 0.0);
    yeoh.volume(simo_taylor);
    let gent = Compared::new(row("gent"));
    gent.invariants(|i1| 0.5 * 0.36 * 20.0 / (20.0 - (i1 - 3.0)), 0.0);
    gent.volume(simo_taylor);
    let chains = Compared::new(row("arruda_boyce"));
    chains.invariants(
        |i1| {
            let n = 9.0f64;
            let series = 0.5 + i1 / (10.0 * n) + 33.0 * i1 * i1 / (1050.0 * n * n) + 76.0 * i1.powi(3) / (7000.0 * n.powi(3));
            0.33 * (series + 2595.0 * i1.powi(4) / (673750.0 * n.powi(4)))
        },
        0.0,
    );
    chains.volume(simo_taylor);
}

#[test]
fn laws_of_principal_stretches() {
    // Ogden 1972: s_i = sum mu_p l_i^alpha_p - p.
    let ogden = Compared::new(row("ogden"));
    ogden.principal(|l, i| 0.4 * l[i].powf(1.3) + 0.02 * l[i].powf(5.0) - 0.05 * l[i].powf(-2.0));
    ogden.volume(simo_taylor);
    // Hencky: Kirchhoff stress 2 mu ln l_i + lambda ln J.
    let (lambda, mu) = lame(1.0, 0.3);
    let hencky = Compared::new(row("hencky"));
    hencky.principal(|l, i| 2.0 * mu * l[i].ln());
    hencky.volume(|j| (lambda + 2.0 / 3.0 * mu) * j.ln() / j);
}

#[test]
fn laws_of_the_stretch_and_the_strain() {
    // Bonet and Wood 2008, section 6.4.3: s = mu/J (b - 1) + lambda/J ln J.
    let (lambda, mu) = lame(1.0, 0.3);
    let neo_hookean = Compared::new(row("neo_hookean"));
    neo_hookean.invariants(|_| 0.5 * mu, 0.0);
    neo_hookean.volume(|j| (mu * (j.powf(2.0 / 3.0) - 1.0) + lambda * j.ln()) / j);
    // s_i = l_i^2/J (lambda tr E + 2 mu e_i).
    let venant = Compared::new(row("saint_venant_kirchhoff"));
    let strain = |l: f64| 0.5 * (l * l - 1.0);
    venant.principal(|l, i| l[i] * l[i] * (lambda * l.iter().map(|l| strain(*l)).sum::<f64>() + 2.0 * mu * strain(l[i])));
    venant.volume(|j| j.powf(-1.0 / 3.0) * (3.0 * lambda + 2.0 * mu) * strain(j.cbrt()));
}

/// Uniaxial and biaxial test pieces with free sides, for both forms of the neo-Hookean law. The Cauchy stresses are `(mu (l_i^2 - 1) + J
/// U'(J))/J`, so that `mu (1 - l^2) = J U'` for the stretch `l` of a free side. For the power form this is a quadratic equation for `y =
/// l^2`; for the logarithmic form it gives the axial stretch for a chosen `y`.
#[test]
fn pieces_of_both_neo_hookean_forms_stretch_freely_across() {
    let (youngs_modulus, poisson_ratio) = (1.0, 0.3);
    let (lambda, mu) = lame(youngs_modulus, poisson_ratio);
    let power = CATALOGUE.iter().find(|row| row.volumetric.as_ref().is_some_and(|form| form.name == "power")).expect("it has two forms");
    let (logarithmic, power) = (Compared::new(row("neo_hookean")), Compared::new(power));
    let check = |compared: &Compared, stretches: [f64; 3], free: &[usize]| {
        let s = cauchy(&*compared.law, &stretched(stretches[0], stretches[1], stretches[2]));
        let j: f64 = stretches.iter().product();
        // `J U'` follows from the free side, so that the axial stress is mu times the difference of the squared stretches.
        let along = mu * (stretches[0].powi(2) - stretches[free[0]].powi(2)) / j;
        compared.close(&format!("along {stretches:?}"), s[(0, 0)] / mu, along / mu);
        free.iter().for_each(|&i| compared.close(&format!("across {stretches:?}"), s[(i, i)] / mu, 0.0));
        let piece = if free.len() == 2 { HomogeneousTest::Uniaxial } else { HomogeneousTest::Equibiaxial };
        let found = path(&compared.material, piece, &[stretches[0]])[0].nominal_stress;
        compared.close(&format!("{piece:?} {stretches:?}"), found / mu, along * j / stretches[0] / mu);
    };
    for l in [0.4f64, 0.8, 1.0 + 1e-9, 1.5, 3.0] {
        // Power form, uniaxial and equibiaxial: lambda/2 (l^2 y^2 - 1) = mu (1 - y) and lambda/2 (l^4 y - 1) = mu (1 - y).
        let y = ((mu * mu + 2.0 * lambda * l * l * (mu + 0.5 * lambda)).sqrt() - mu) / (lambda * l * l);
        check(&power, [l, y.sqrt(), y.sqrt()], &[1, 2]);
        let y = (mu + 0.5 * lambda) / (mu + 0.5 * lambda * l.powi(4));
        check(&power, [l, l, y.sqrt()], &[2]);
    }
    for y in [0.5f64, 0.9, 1.0 - 1e-9, 1.3] {
        // Logarithmic form, uniaxial and equibiaxial: lambda ln(l y) = mu (1 - y) and lambda ln(l^2 sqrt y) = mu (1 - y).
        check(&logarithmic, [(mu / lambda * (1.0 - y)).exp() / y, y.sqrt(), y.sqrt()], &[1, 2]);
        let l = (0.5 * (mu / lambda * (1.0 - y) - 0.5 * y.ln())).exp();
        check(&logarithmic, [l, l, y.sqrt()], &[2]);
    }
    for compared in [&logarithmic, &power] {
        for g in [1e-9, 0.3, 1.0, 2.5] {
            // At constant volume the Cauchy stress is mu (b - 1) for every volumetric form.
            let s = cauchy(&*compared.law, &sheared(g));
            compared.close("shear", s[(0, 1)] / mu, g);
            compared.close("shear, along", s[(0, 0)] / mu, g * g);
            [1, 2].into_iter().for_each(|i| compared.close("shear, across", s[(i, i)], 0.0));
        }
    }
    power.invariants(|_| 0.5 * mu, 0.0);
    power.volume(|j| (mu * (j.powf(2.0 / 3.0) - 1.0) + 0.5 * lambda * (j * j - 1.0)) / j);
}

#[test]
fn fibers_pull_and_do_not_push() {
    // Gasser, Ogden and Holzapfel 2006, with both families along the first axis: s = 2 W1 b + 2 W4 a a - p.
    let (mu, k1, k2, kappa) = (0.3, 0.3, 0.8, 0.1);
    let row = row("holzapfel_gasser_ogden");
    let mut values = row.example(1.0, 1.0);
    values[4] = 0.0;
    let material = Material::new(row, &values).unwrap();
    let law = Compared { law: material.space(), material, name: row.name };
    law.volume(simo_taylor);
    let slopes = |i1: f64, i4: f64| {
        let e = f64::max(kappa * (i1 - 3.0) + (1.0 - 3.0 * kappa) * (i4 - 1.0), 0.0);
        let slope = 2.0 * k1 * e * (k2 * e * e).exp();
        (0.5 * mu + kappa * slope, (1.0 - 3.0 * kappa) * slope)
    };
    for l in [0.7f64, 0.95, 1.2, 1.6] {
        let s = cauchy(&*law.law, &stretched(l, l.powf(-0.5), l.powf(-0.5)));
        let (w1, w4) = slopes(l * l + 2.0 / l, l * l);
        law.close("uniaxial", s[(0, 0)] - s[(1, 1)], 2.0 * (l * l - 1.0 / l) * w1 + 2.0 * l * l * w4);
        let s = cauchy(&*law.law, &stretched(l, l, l.powi(-2)));
        let (w1, w4) = slopes(2.0 * l * l + l.powi(-4), l * l);
        law.close("equibiaxial", s[(0, 0)] - s[(2, 2)], 2.0 * (l * l - l.powi(-4)) * w1 + 2.0 * l * l * w4);
        let s = cauchy(&*law.law, &sheared(l));
        law.close("shear along the fibers", s[(0, 1)], 2.0 * l * slopes(3.0 + l * l, 1.0).0);
    }
    // Under compression along the fibers no dispersed fiber is in tension: the stress is that of the matrix.
    assert_eq!(slopes(0.7 * 0.7 + 2.0 / 0.7, 0.7 * 0.7).1, 0.0);
}

/// Rotation matrix of the angle 0.4 rad in the plane.
fn turn() -> Matrix {
    let (sine, cosine) = 0.4f64.sin_cos();
    Matrix::new(cosine, -sine, 0.0, sine, cosine, 0.0, 0.0, 0.0, 1.0)
}

#[test]
fn stresses_turn_with_the_body() {
    for row in CATALOGUE {
        let material = Material::new(row, &row.example(1.0, 1.0)).unwrap();
        let (law, q) = (material.space(), turn());
        let turned = material.turned(0.4f64.cos(), 0.4f64.sin()).unwrap().space();
        for f in [stretched(1.2, 0.9, 1.1), sheared(0.6), stretched(1.3, 1.3, 0.8) * sheared(0.2)] {
            let (plain, other) = (cauchy(&*law, &f), cauchy(&*turned, &(q * f * q.transpose())));
            assert!((q * plain * q.transpose() - other).norm() < 1e-14, "{}", row.name);
        }
    }
}

fn law(text: &str) -> Arc<dyn BatchedLaw<6>> {
    Material::hyperelastic(StoredEnergy::new(text, None, &[]).unwrap(), 1.0).unwrap().space()
}

#[test]
fn functions_of_principal_stretches_hold_at_equal_stretches() {
    // l1^4 + l2^4 + l3^4 = tr C^2 and l1^-4 + l2^-4 + l3^-4 = tr C^-2: equal energies in invariants, whose derivatives need no principal
    // stretches.
    for (principal, invariant) in [("stretch_power(4)", "I1^2 - 2*I2"), ("stretch_power(-4)", "(I2^2 - 2*I1*I3)/I3^2")] {
        let (principal, invariant) = (law(principal), law(invariant));
        let q = turn();
        for apart in [0.0, 1e-300, 1e-17, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 0.1] {
            for e in [[0.2, 0.2 + apart, 0.2], [0.2, 0.2 + apart, 0.2 - apart], [apart, 0.0, 0.0], [0.3, -0.2, -0.2 + apart]] {
                for e in [Matrix::from_diagonal(&e.into()), q * Matrix::from_diagonal(&e.into()) * q.transpose()] {
                    let (mut found, mut expected) = ([Response::ZERO], [Response::ZERO]);
                    principal.responses_into(&[components(&e)], &mut found);
                    invariant.responses_into(&[components(&e)], &mut expected);
                    let size = expected[0].tangent[0][0].0[0].abs().max(expected[0].tangent[1][1].0[0].abs());
                    for i in 0..6 {
                        let (a, b) = (found[0].stress[i].0[0], expected[0].stress[i].0[0]);
                        assert!((a - b).abs() < 1e-13 * size, "{apart:e}, stress {i}: {a} {b}");
                        for j in 0..6 {
                            let (a, b) = (found[0].tangent[i][j].0[0], expected[0].tangent[i][j].0[0]);
                            assert!((a - b).abs() < 1e-12 * size, "{apart:e}, tangent {i}{j}: {a} {b}");
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn a_limit_that_is_passed_gives_no_number() {
    let gent = Material::new(row("gent"), &[1.0, 2.0, 10.0, 1.0]).unwrap().space();
    let e = |l: f64| components(&((stretched(l * l, 1.0 / l, 1.0 / l).pow(2) - Matrix::identity()) * 0.5));
    let (mut energy, mut stress) = ([Lanes::ZERO; 2], [[Lanes::ZERO; 6]; 2]);
    gent.energies_into(&[e(1.2), e(2.0)], &mut energy);
    gent.stresses_into(&[e(1.2), e(2.0)], &mut stress);
    assert!(energy[0].0[0] > 0.0 && energy[1].0[0].is_nan());
    assert!(stress[0][0].0[0] > 0.0);
}
