//! Colors of the picture: every field of the page has the values of `sim.field`, in the plane, of revolution and in space.

use std::fs;

use serde_json::json;

use super::{browser, folder, run};

/// Fields that are recorded on request, in local frames, and those that the page computes from the stress.
const NAMES: &str = r#"["von_mises", "pressure", "displacement", "velocity", "stress_xx", "stress_yy", "stress_zz", "stress_xy", "tresca",
    "principal_1", "principal_2", "principal_3", "acceleration", "energy_density", "stress_error", "strain_xx", "strain_yy", "strain_zz",
    "strain_xy", "principal_strain_1", "principal_strain_2", "principal_strain_3", "stress_rr", "stress_tt", "stress_aa", "stress_rt",
    "stress_ta", "stress_ra", "strain_rr", "strain_tt", "strain_aa", "strain_rt", "strain_ta", "strain_ra", "stress_along", "strain_along",
    "traction"]"#;

/// A body that is bent and set in motion, with the values of all fields printed for the page to read.
fn script(body: &str, frame: &str) -> String {
    format!(
        r#"
let m = model("bent");
let rubber = neo_hookean(#{{ youngs_modulus: 1e3, poisson_ratio: 0.3, density: 1.0 }});
{body}
let names = {NAMES};
let sim = simulate(m, #{{
    integrator: energy_momentum(), dt: 0.01, stills_inside: true, stills_fields: names, stills_frame: #{{ {frame} }}
}});
sim.step(3);
for name in names {{ print(`{{"${{name}}": ${{sim.field(name, b, #{{ {frame} }})}}}}`); }}
"#
    )
}

/// Largest difference between the page's values of a printed field and the printed ones, relative to the largest value of the field's
/// source; an error text of fields that are missing.
const DIFFERENCES: &str = r#"(() => {
  const { film, data, bodies } = conserva, last = data.stills.length - 1, { nodes } = bodies[0];
  film.show(last);
  const faults = [];
  for (const line of data.printed) {
    const [[name, printed]] = Object.entries(JSON.parse(line)), field = data.fields.find((other) => other.name === name);
    if (!field) { faults.push(`${name} is not offered`); continue; }
    const size = (v) => Array.isArray(v) ? Math.hypot(...v) : v, values = film.field(name, 0, new Float64Array(nodes));
    const largest = (values) => Math.max(...values.map(Math.abs));
    const isOfStress = name.includes("stress") || /^(tresca|traction|principal_[123])$/.test(name);
    const source = isOfStress ? "von_mises" : name.includes("strain") ? "principal_strain_1" : name;
    const scale = largest(Array.from(film.field(source, 0, new Float64Array(nodes)))) + largest(printed.map(size));
    const off = largest(printed.map((v, i) => values[i] - size(v)));
    if (!(off <= 1e-4 * scale) || !(scale > 0)) faults.push(`${name}: ${off} of ${scale}`);
    const at = Math.floor(nodes / 2);
    if (!(Math.abs(film.valueAt(name, last, 0, at) - values[at]) <= 1e-6 * scale)) faults.push(`${name} of a node`);
    const [low, high] = film.range(field);
    if (!(low <= Math.min(...values) + 1e-5 * scale && high >= Math.max(...values) - 1e-5 * scale)) faults.push(`range of ${name}`);
  }
  return faults;
})()"#;

#[test]
fn fields_of_the_page_are_those_of_the_script() {
    let folder = folder("fields");
    let Some(mut page) = browser(&folder) else { return };
    let plane = r#"
let b = m.add_body("b", rectangle(#{ size: [3.0, 1.0], cells: [6, 3], element: "quad8" }), rubber);
m.initial_velocity(b, #{ angular: 2.0 });
m.traction(b.boundary("right"), [0.0, 30.0]);"#;
    let round = r#"
let b = m.add_body("b", rectangle(#{ size: [1.0, 2.0], cells: [3, 6], origin: [0.5, 0.0] }), rubber, #{ plane: "axisymmetric" });
m.fix(b.boundary("bottom"));
m.traction(b.boundary("top"), [20.0, 10.0]);"#;
    let space = r#"
let b = m.add_body("b", block(#{ size: [3.0, 1.0, 1.0], cells: [4, 2, 2] }), rubber);
m.initial_velocity(b, #{ angular: [1.0, 2.0, 3.0] });
m.traction(b.boundary("right"), [5.0, 30.0, -10.0]);"#;
    let frames =
        ["center: [0.5, 2.0], direction: [1, 2]", "direction: [1, 2]", "center: [0.5, 2.0, 0], axis: [1, 0.5, 2], direction: [1, 2, 3]"];
    for ((name, body), frame) in [("plane", plane), ("round", round), ("space", space)].into_iter().zip(frames) {
        let out = run(&folder, &script(body, frame), name);
        page.open(&out.join("report.html"));
        page.settle();
        assert_eq!(page.evaluate(DIFFERENCES), json!([]), "{name}");
        // Each one is drawn without a complaint.
        page.evaluate("for (const { name } of conserva.data.fields) { document.getElementById('field').value = name; conserva.draw(); }");
        assert_eq!(page.complaints, Vec::<serde_json::Value>::new());
    }
    // Without a request the page offers what follows from the stress alone.
    let plain = script(plane, frames[0]).replace("stills_fields: names, ", "");
    let out = run(&folder, &plain, "plain");
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("\"principal_1\"") && !page.contains("\"name\":\"strain_xx\"") && !page.contains("\"name\":\"stress_tt\""));
}
