//! Press fits of rings by `settle` with the kernels alone, over interference, refinement, ratio of radii and contact method, compared with
//! the pressures of Lamé. Inaccurate cases must be refused: an accepted fit without pressure is counted, and the program fails.
//!
//! Rows of bodies of revolution are slices fixed along the axis (plane strain) with an interference of a thousandth of the radius, whatever
//! it is in facets: the length of the slice follows. Rows of plane rings (plane stress) are polygons around the axis, which converge to
//! Lamé's solution with refinement, and for more than small strains to a limit of their own.
//!
//! `cargo example fits -- [most cells around]`

use std::error::Error;

use conserva::bodies::{Formulation, Plane};
use conserva::contact::{AVERAGED_MORTAR, ContactMethod, DUAL_MORTAR, MORTAR, NODE_TO_SEGMENT};
use conserva::dynamics::{Model, Options, Simulation};
use conserva::integrators::ENERGY_MOMENTUM;
use conserva::materials::{Material, NeoHookean};
use conserva::mesh::{Mesh, rectangle, ring};

const YOUNG: f64 = 1000.0;
const POISSON: f64 = 0.3;

/// Cells across each ring.
const ACROSS: usize = 8;

/// Largest relative error of a pressure for small strains and fine facets.
const OFF: f64 = 0.01;

type Outcome = Result<f64, Box<dyn Error>>;

/// Mean pressure of two rings with their contact sides and supports.
fn pressure(meshes: [(Mesh, &str); 2], plane: Plane, method: &'static ContactMethod, held: &[&str]) -> Outcome {
    let law: Material = NeoHookean { youngs_modulus: YOUNG, poisson_ratio: POISSON, density: 1.0 }.material()?;
    let mut model = Model::new("fit");
    let mut sides = Vec::new();
    for (name, (mesh, side)) in ["hub", "shaft"].into_iter().zip(meshes) {
        let body = model.add_formulated_body(name, mesh, &law, Formulation { plane, ..Formulation::default() });
        for end in held {
            model.fix(model.boundary(body, end)?, [false, true, false]);
        }
        sides.push(model.boundary(body, side)?);
    }
    let primary = sides.remove(0);
    model.add_contact("fit", sides.remove(0), primary).method = method;
    let mut sim = Simulation::new(&model, Options::new(&ENERGY_MOMENTUM, 1e-3))?;
    sim.settle()?;
    let fields = sim.contact("fit").ok_or("there is no such contact")?;
    // Mean over the surface: nodal pressures of a method that fails the patch test vary, and end nodes have half the weight.
    Ok(fields.normal_force / fields.area)
}

/// Radial displacement of a ring's contact side at radius 1 under unit pressure, with its other side at the radius `other`.
fn compliance(other: f64, plane: Plane) -> f64 {
    let (square, flat) = (other * other, if plane == Plane::Stress { (1.0 - POISSON) / (1.0 + POISSON) } else { 1.0 - 2.0 * POISSON });
    (1.0 + POISSON) / YOUNG * (flat + square) / (square - 1.0).abs()
}

/// Pressure of a slice of two rings of revolution with an interference in facets along the axis, over Lamé's.
fn slice(facets: f64, cells: usize, ratio: f64, method: &'static ContactMethod) -> Outcome {
    let interference = 1e-3;
    let (inner, length) = (1.0 / ratio, cells as f64 * interference / facets);
    let hub = rectangle([ratio - 1.0, length], [ACROSS, cells], [1.0, 0.0])?;
    let shaft = rectangle([1.0 + interference - inner, length], [ACROSS, cells + 1], [inner, 0.0])?;
    let pressure = pressure([(hub, "left"), (shaft, "right")], Plane::Axisymmetric, method, &["bottom", "top"])?;
    Ok(pressure * (compliance(ratio, Plane::Strain) + compliance(inner, Plane::Strain)) / interference)
}

/// Pressure of two plane rings with a number of facets around and an interference over the radius, over Lamé's.
fn rings(interference: f64, cells: usize, ratio: f64, method: &'static ContactMethod) -> Outcome {
    let inner = 1.0 / ratio;
    let hub = ring(1.0, ratio, [ACROSS, cells], [0.0; 2], 0.0)?;
    let shaft = ring(inner, 1.0 + interference, [ACROSS, cells], [0.0; 2], 0.0)?;
    let pressure = pressure([(hub, "inner"), (shaft, "outer")], Plane::Stress, method, &[])?;
    Ok(pressure * (compliance(ratio, Plane::Stress) + compliance(inner, Plane::Stress)) / interference)
}

fn main() -> Result<(), Box<dyn Error>> {
    let most: usize = std::env::args().nth(1).map_or(Ok(64), |text| text.parse())?;
    let methods = [&MORTAR, &DUAL_MORTAR, &AVERAGED_MORTAR, &NODE_TO_SEGMENT];
    let (mut wrong, mut refused, mut right) = (0, 0, 0);
    let mut judge = |what: String, outcome: &Outcome, is_right: &dyn Fn(f64) -> bool| {
        let verdict = match outcome {
            Err(error) => {
                refused += 1;
                format!("refused: {error}")
            }
            Ok(ratio) if is_right(*ratio) => {
                right += 1;
                format!("{ratio:.5} of Lamé")
            }
            Ok(ratio) => {
                wrong += 1;
                format!("{ratio:.5} of Lamé: WRONG")
            }
        };
        println!("{what}: {verdict}");
    };
    for method in methods {
        for ratio in [1.2, 1.5, 3.0] {
            for cells in [4, 16, 64].into_iter().filter(|cells| *cells <= most) {
                for facets in [0.01, 0.3, 1.0, 5.0, 20.0] {
                    let what = format!("slice, {}, radii 1 : {ratio}, {cells} facets, interference of {facets} facets", method.name);
                    judge(what, &slice(facets, cells, ratio, method), &|found| (found - 1.0).abs() < OFF);
                }
            }
        }
    }
    for method in methods {
        for ratio in [1.2, 1.5, 3.0] {
            for interference in [1e-4, 1e-3, 0.08, 0.3] {
                let mut change = f64::INFINITY;
                let mut before: Option<f64> = None;
                for cells in [4, 8, 16, 32, 64, 128].into_iter().filter(|cells| *cells <= most) {
                    let facets = interference * cells as f64 / std::f64::consts::TAU;
                    let what = format!("rings, {}, radii 1 : {ratio}, {cells} facets around, {facets:.4} facets", method.name);
                    let found = rings(interference, cells, ratio, method);
                    // Each doubling changes less than the previous one, and small strains converge to Lamé's solution.
                    let now = found.as_ref().ok().copied();
                    let least = before.zip(now).map_or(change, |(before, now)| (now - before).abs());
                    let converges = least <= change || least < OFF * OFF;
                    let is_fine = cells >= 32 && interference <= 1e-3;
                    judge(what, &found, &|found| found > 0.0 && converges && (!is_fine || (found - 1.0).abs() < OFF));
                    (before, change) = (now, least);
                }
            }
        }
    }
    println!("{right} right, {refused} refused, {wrong} wrong");
    if wrong > 0 { Err("a fit is wrong and was not refused".into()) } else { Ok(()) }
}
