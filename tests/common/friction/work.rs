//! Friction work of every integrator that supports friction, each with one scene and four step sizes.

use conserva::integrators;

use super::{Case, Expected, pick, promised_figures, random_of, scaled, whole};

/// Integrators that support friction; true for those that bound the energy of a motion without external work.
pub const INTEGRATORS: [(&str, bool); 14] = [
    ("energy_momentum()", true),
    ("mean_value()", true),
    ("energy_decaying()", true),
    ("energy_decaying(#{ spectral_radius: 0.8 })", true),
    ("midpoint()", false),
    ("trapezoidal()", false),
    ("backward_euler()", false),
    ("newmark()", false),
    ("hht()", false),
    ("wbz()", false),
    ("generalized_alpha()", false),
    ("generalized_alpha(#{ spectral_radius: 0.3 })", false),
    ("bdf2()", false),
    ("tr_bdf2()", false),
];

/// Step sizes.
pub const SIZES: [f64; 4] = [2e-2, 5e-3, 1e-3, 2e-4];

/// Case of a seed: the scene is `seed / 56`.
pub fn case(seed: u64) -> Case {
    let of_scene = (INTEGRATORS.len() * SIZES.len()) as u64;
    let mut random = random_of(seed / of_scene);
    let within = (seed % of_scene) as usize;
    let ((integrator, bounds), dt) = (INTEGRATORS[within / SIZES.len()], SIZES[within % SIZES.len()]);
    let (mu, modulus, drive) = (scaled(&mut random, 0.05, 1.0), scaled(&mut random, 1e3, 1e5), random.next() > 0.2);
    let (v, cells) = (scaled(&mut random, 0.05, 1.5), [whole(&mut random, 1, 3), whole(&mut random, 1, 2)]);
    let rule = pick(&mut random, &["", "", ", update: \"gap\"", ", update: \"velocity\""]);
    let penalty = pick(&mut random, &["", "", ", penalty: 10.0", ", augmented_lagrange: 100.0"]);
    let in_space = random.next() > 0.0;
    let law = format!("neo_hookean(#{{ youngs_modulus: {modulus:.4e}, poisson_ratio: 0.3, density: 1.0 }})");
    let [i, j] = cells;
    let (mesh, face, plane, vector, spring, down) = if in_space {
        (
            format!("block(#{{ size: [0.6, 0.5, 0.4], cells: [{i}, {j}, 1] }})"),
            "back",
            "point: [0.0, 0.0, 0.0], normal: [0.0, 0.0, 1.0]",
            format!("[{v:.4e}, {:.4e}, 0.0]", 0.3 * v),
            "from_point: [0.0, 0.0, 0.4], to: \"ground\", to_point: [-1.0, 0.0, 0.4]",
            "[0.0, 0.0, -10.0]",
        )
    } else {
        (
            format!("rectangle(#{{ size: [0.6, 0.4], cells: [{}, {j}] }})", 2 * i),
            "bottom",
            "point: [0.0, 0.0], normal: [0.0, 1.0]",
            format!("[{v:.4e}, 0.0]"),
            "from_point: [0.0, 0.4], to: \"ground\", to_point: [-1.0, 0.4]",
            "[0.0, -10.0]",
        )
    };
    let motion = if drive { format!(", motion: #{{ x: |t| {v:.4e} * t }}") } else { String::new() };
    let mut script = format!(
        "let m = model(\"work\");\nlet b = m.add_body(\"b\", {mesh}, {law});\n\
         m.add_contact(\"c\", #{{ secondary: b.boundary(\"{face}\"), primary: rigid_plane(#{{ {plane}{motion} }}), \
         friction: {mu:.4e}{rule}{penalty} }});\n\
         m.add_spring(\"k\", #{{ from: b, {spring}, stiffness: 10.0 }});\nm.gravity({down});\n"
    );
    if !drive {
        script += &format!("m.initial_velocity(b, #{{ linear: {vector} }});\n");
    }
    let scheme = integrators::CATALOGUE.iter().find(|scheme| integrator.split('(').next() == Some(scheme.name));
    let figures = promised_figures(0.2, &scheme.expect("the integrator is of the catalogue").promises);
    script += &format!("let sim = simulate(m, #{{ integrator: {integrator}, dt: {dt:e} }});\nsim.step(60);\n{figures}");
    let mut expected = Vec::new();
    if !drive && bounds {
        script += "let growth = 0.0;\nlet least = 1e300;\n\
                   for k in 0..h.total.len() { let e = h.total[k]; if e - least > growth { growth = e - least; } \
                   if e < least { least = e; } }\nprint(`figure growth ${growth / scale}`);\n";
        // Penalty potentials store energy that contact returns.
        if penalty.is_empty() && rule != ", update: \"velocity\"" {
            expected.push(Expected { name: "growth", value: 0.0, tolerance: 1e-11 });
        }
    }
    let name = format!(
        "{integrator}, dt {dt:e}, {}, cells {cells:?}, mu {mu:.3}, E {modulus:.3e}, v {v:.3}{}{rule}{penalty}",
        if in_space { "space" } else { "plane" },
        if drive { ", driven" } else { "" }
    );
    Case { kind: integrator.into(), name, script, expected }
}
