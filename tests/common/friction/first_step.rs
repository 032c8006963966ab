//! First steps of bars, plates and blocks at rest under a load: every law, cell and conserving rule, loads of any size.

use conserva::integrators::{self, ConservedQuantities};

use super::{Case, pick, promised_figures, random_of, scaled};

const LAWS: [&str; 10] = [
    "linear_elasticity(#{ youngs_modulus: E, poisson_ratio: 0.3, density: 1.0 })",
    "neo_hookean(#{ youngs_modulus: E, poisson_ratio: 0.3, density: 1.0 })",
    "saint_venant_kirchhoff(#{ youngs_modulus: E, poisson_ratio: 0.3, density: 1.0 })",
    "hencky(#{ youngs_modulus: E, poisson_ratio: 0.3, density: 1.0 })",
    "mooney_rivlin(#{ c10: 0.13 * E, c01: 0.05 * E, bulk_modulus: E, density: 1.0 })",
    "yeoh(#{ c10: 0.18 * E, c20: 0.02 * E, c30: 0.01 * E, bulk_modulus: E, density: 1.0 })",
    "gent(#{ mu: 0.36 * E, limit: 20, bulk_modulus: E, density: 1.0 })",
    "arruda_boyce(#{ mu: 0.33 * E, locking_stretch: 3, bulk_modulus: E, density: 1.0 })",
    "ogden(#{ mu1: 0.4 * E, alpha1: 1.3, mu2: 0.02 * E, alpha2: 5, bulk_modulus: E, density: 1.0 })",
    "holzapfel_gasser_ogden(#{ mu: 0.3 * E, k1: 0.3 * E, k2: 0.8, kappa: 0.1, angle: 0.6, bulk_modulus: E, density: 1.0 })",
];

/// Case of a seed.
pub fn case(seed: u64) -> Case {
    let mut random = random_of(seed);
    let (law, in_space) = (pick(&mut random, &LAWS), random.next() > 0.0);
    let integrator = pick(&mut random, &["energy_momentum()", "mean_value()", "energy_decaying()", "triple_jump()"]);
    let element = if in_space {
        pick(&mut random, &["hex8", "tet4", "hex20", "hex27", "tet10"])
    } else {
        pick(&mut random, &["quad4", "tri3", "tri6", "quad8", "quad9"])
    };
    let most = if element == "hex8" || !in_space { 5000.0 } else { 400.0 };
    let (count, shape) = (scaled(&mut random, 10.0, most), pick(&mut random, &["bar", "bar", "plate", "block"]));
    let cells: [usize; 3] = match (shape, in_space) {
        ("bar", _) => [count as usize, 1, 1],
        ("plate", true) => [count.sqrt() as usize, count.sqrt() as usize, 1],
        (_, true) => [count.cbrt().max(1.0) as usize; 3],
        (_, false) => [count.sqrt() as usize, count.sqrt() as usize, 1],
    };
    // Edges of cells are 1, wave speeds about the root of the modulus, strains by the load at most a hundredth.
    let load = scaled(&mut random, 1e-30, 1e30);
    let modulus = (load * scaled(&mut random, 1e2, 1e16)).clamp(1e-28, 1e40);
    let dt = scaled(&mut random, 1e-2, 1e2) / modulus.sqrt();
    let [x, y, z] = cells;
    let (mesh, vector) = if in_space {
        (format!("block(#{{ size: [{x}.0, {y}.0, {z}.0], cells: [{x}, {y}, {z}], element: \"{element}\" }})"), "[0.3, 0.2, 0.9]")
    } else {
        (format!("rectangle(#{{ size: [{x}.0, {y}.0], cells: [{x}, {y}], element: \"{element}\" }})"), "[0.3, 0.9]")
    };
    // Stress of linear elasticity is not symmetric in the deformed configuration: its moment is of the size of the strain.
    let promises = &integrators::ENERGY_MOMENTUM.promises;
    let is_objective = !law.starts_with("linear_elasticity");
    let promises = ConservedQuantities { angular_momentum: promises.angular_momentum && is_objective, ..*promises };
    let script = format!(
        "let E = {modulus:.4e};\nlet m = model(\"first\");\nlet b = m.add_body(\"b\", {mesh}, {law});\n\
         m.traction(b.boundary(\"left\"), {vector}, |t| {load:.4e});\n\
         let sim = simulate(m, #{{ integrator: {integrator}, dt: {dt:.4e} }});\nsim.step(2);\n{}",
        promised_figures((x * y * z) as f64, &promises)
    );
    let name = format!("{cells:?} {element}, load {load:.2e}, modulus {modulus:.2e}, dt {dt:.2e}, {integrator}, {law}");
    Case { kind: format!("{shape} {element}"), name, script, expected: Vec::new() }
}
