//! Treloar's tests of rubber with 8 % sulphur (1944): fits of the catalogue's laws next to Ogden's (Proceedings of the Royal Society A 326,
//! 1972: mu = 6.3, 0.012, -0.1 kg/cm^2, alpha = 1.3, 5, -2). Oracle: a published fit of the same tests.

use std::path::Path;

use conserva::materials::{CATALOGUE, Fit, HomogeneousTest, Measured, StoredEnergy, fit};

fn table(name: &str, piece: HomogeneousTest) -> Measured {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/materials").join(name);
    let text = std::fs::read_to_string(path).unwrap();
    let point = |line: &str| {
        let (stretch, stress) = line.split_once(',')?;
        Some([stretch.trim().parse().ok()?, stress.trim().parse().ok()?])
    };
    Measured { piece, points: text.lines().filter_map(point).collect() }
}

fn tests() -> [Measured; 2] {
    [table("treloar_uniaxial.csv", HomogeneousTest::Uniaxial), table("treloar_equibiaxial.csv", HomogeneousTest::Equibiaxial)]
}

fn fitted(law: &str, names: &[&str]) -> Fit {
    let row = CATALOGUE.iter().find(|row| row.name == law).unwrap();
    let energy = |values: &[f64]| row.energy(|name| names.iter().position(|known| *known == name).map(|index| values[index]));
    fit(energy, &vec![None; names.len()], &tests()).unwrap()
}

fn ogden(moduli: &[f64]) -> Result<StoredEnergy, conserva::materials::EnergyError> {
    let row = CATALOGUE.iter().find(|row| row.name == "ogden").unwrap();
    row.energy(|name| match name {
        "mu1" => Some(moduli[0]),
        "mu2" => Some(moduli[1]),
        "mu3" => Some(moduli[2]),
        "alpha1" => Some(1.3),
        "alpha2" => Some(5.0),
        "alpha3" => Some(-2.0),
        _ => None,
    })
}

#[test]
fn moduli_for_ogdens_powers_fit_better_than_his_and_are_near_them() {
    assert_eq!(tests().map(|test| test.points.len()), [24, 16]);
    let found = fit(ogden, &[None; 3], &tests()).unwrap();
    let published = ogden(&[6.3, 0.012, -0.1]).unwrap();
    let square = |test: &Measured| {
        let stretches: Vec<f64> = test.points.iter().map(|point| point[0]).collect();
        let stresses = published.incompressible_stresses(test.piece, &stretches).unwrap();
        stresses.iter().zip(&test.points).map(|(stress, point)| (stress - point[1]).powi(2)).sum::<f64>()
    };
    let rms = (tests().iter().map(square).sum::<f64>() / 40.0).sqrt();
    // Ogden's fit leaves out the last points, at which the rubber crystallizes.
    assert!(found.rms < rms && rms < 4.0 * found.rms, "{} against {rms}", found.rms);
    for (found, published) in found.constants.iter().zip([6.3, 0.012, -0.1]) {
        assert!((found / published - 1.0).abs() < 0.3, "{found} {published}");
    }
}

#[test]
fn more_terms_fit_better() {
    let ogden = fitted("ogden", &["mu1", "alpha1", "mu2", "alpha2", "mu3", "alpha3"]);
    let yeoh = fitted("yeoh", &["c10", "c20", "c30"]);
    let mooney = fitted("mooney_rivlin", &["c10", "c01"]);
    assert!(ogden.r_squared > 0.998 && yeoh.r_squared > 0.99 && mooney.r_squared < 0.9, "{ogden:?} {yeoh:?} {mooney:?}");
    // The shear modulus at small strain, half of the sum of mu alpha, 2 c10: about 0.4 N/mm^2, 4 kg/cm^2 (Treloar 1975, chapter 5).
    let [mu1, alpha1, mu2, alpha2, mu3, alpha3] = ogden.constants[..] else { panic!("six constants") };
    let shear = 0.5 * (mu1 * alpha1 + mu2 * alpha2 + mu3 * alpha3);
    assert!((3.0..5.0).contains(&shear) && (3.0..5.0).contains(&(2.0 * yeoh.constants[0])), "{shear} {yeoh:?}");
}
