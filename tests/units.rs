//! Units: a script in SI and in mm, N, t, s gives the same motion; files, tables and the prompt show units; wrong numbers are reported;
//! without `units` no file changes.

use std::collections::BTreeMap;
use std::path::Path;

use conserva::output::{Exactness, compare, read_fields, read_table, read_units};

#[path = "common/program.rs"]
mod program;

use program::{folder, stderr, stdout};

/// Two steel rings in contact, pressed into each other and spun up, written in quantities: only the call of `units` differs.
const BEARING: &str = r#"
units(param("units", "SI"));
let steel = neo_hookean(#{ youngs_modulus: gpa(210), poisson_ratio: 0.3, density: kg_m3(7850) });
let bearing = model("bearing");
let outer = bearing.add_body("outer", ring(#{ inner_radius: mm(10), outer_radius: mm(15), cells: [3, 24] }), steel);
let inner = bearing.add_body("inner", ring(#{ inner_radius: mm(5), outer_radius: mm(10.02), cells: [3, 20] }), steel);
bearing.fix(outer.boundary("outer"));
bearing.add_contact("race", #{ secondary: inner.boundary("outer"), primary: outer.boundary("inner"), method: mortar() });
let ms = quantity(1, "ms");
bearing.torque(inner.boundary("inner"), hat(0.0, 0.1 * ms, quantity(20, "kN*m/m")));
let sim = simulate(bearing, #{ integrator: energy_momentum(), dt: 0.002 * ms, fields_every: 0.05 * ms });
sim.probe("rim", inner, mm([5, 0]));
sim.settle();
sim.run_to(0.1 * ms);
sim.table("all.parquet");
sim.plot("energies.svg", ["kinetic", "strain", "total"]);
sim.plot("mixed.svg", ["kinetic", "rim.ux"]);
sim.picture("stress.svg", #{ field: ["von_mises", "displacement"], vectors: "velocity" });
print(sim);
"#;

/// A rubber block that falls obliquely on a rubber plate with friction and gravity, in the plane.
const DROP: &str = r#"
units(param("units", "SI"));
let rubber = neo_hookean(#{ youngs_modulus: mpa(5), poisson_ratio: 0.3, density: kg_m3(1100) });
let drop = model("drop");
let plate = drop.add_body("plate", rectangle(#{ size: mm([40, 20]), cells: [3, 2] }), rubber);
let cube = drop.add_body("cube", rectangle(#{ size: mm([20, 20]), cells: [2, 2], origin: mm([9, 20.5]) }), rubber);
drop.fix(plate.boundary("bottom"));
drop.gravity(quantity([0.0, -9.81], "m/s^2"));
drop.initial_velocity(cube, #{ linear: m_s([2, -5]) });
drop.add_contact("pad", #{ secondary: cube.boundary("bottom"), primary: plate.boundary("top"), friction: 0.3 });
let sim = simulate(drop, #{ integrator: energy_momentum(), dt: quantity(50, "us"), fields_every: quantity(200, "us") });
sim.probe("corner", cube, mm([9, 20.5]));
sim.run_to(quantity(2, "ms"));
"#;

/// Block of steel in space with a spring and a rigid body: columns of forces and moments in all directions.
const IN_SPACE: &str = r#"
units(param("units", "SI"));
let steel = neo_hookean(#{ youngs_modulus: gpa(210), poisson_ratio: 0.3, density: kg_m3(7850) });
let rubber = neo_hookean(#{ youngs_modulus: mpa(5), poisson_ratio: 0.4, density: kg_m3(1100) });
let drop = model("drop");
let plate = drop.add_body("plate", block(#{ size: mm([40, 10, 40]), cells: [3, 1, 3] }), rubber);
let cube = drop.add_body("cube", block(#{ size: mm([20, 20, 20]), cells: [2, 2, 2], origin: mm([9, 10.1, 11]) }), steel);
let cover = block(#{ size: mm([10, 5, 10]), cells: [1, 1, 1], origin: mm([14, 50, 16]) });
let lid = drop.add_rigid_body("lid", cover, #{ density: kg_m3(2700) });
drop.fix(plate.boundary("bottom"));
drop.gravity(quantity([0.0, -9.81, 0.0], "m/s^2"));
drop.initial_velocity(cube, #{ linear: m_s([0.5, -1.0, 0.2]) });
drop.add_contact("pad", #{ secondary: cube.boundary("bottom"), primary: plate.boundary("top"), friction: 0.3 });
drop.add_spring("wire", #{ from: lid.boundary("bottom"), to: cube.boundary("top"), stiffness: quantity(20, "N/mm") });
drop.add_joint("pin", #{ kind: "hinge", from: lid, point: mm([14, 50, 16]), axis: [0, 0, 1] });
let sim = simulate(drop, #{ integrator: energy_momentum(), dt: quantity(20, "us") });
sim.probe("corner", cube, mm([9, 10.1, 11]));
sim.run_to(quantity(1, "ms"));
"#;

fn run(folder: &Path, set: &str) -> String {
    let arguments = ["run", "main.rhai", "--quiet", "--out", set, "--set", &format!("units={set}")];
    let output = program::conserva(folder, &arguments).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(!stderr(&output).contains("warning"), "{}", stderr(&output));
    stdout(&output)
}

/// Runs a script in SI and in another set, and compares histories and fields in SI, except those that are `ignored`.
fn agrees(name: &str, script: &str, set: &str, tolerance: f64, ignored: &[&str]) {
    let home = folder(name, script);
    run(&home, "SI");
    run(&home, set);
    let ignored = ["parameter units"].iter().chain(ignored).map(|name| name.to_string()).collect();
    let exactness = Exactness { tolerance, ignored };
    let all = compare(&home.join("SI"), &home.join(set), &exactness).unwrap().remove(0);
    assert!(all.is_same(), "{all:#?}");
    assert!(all.rows[2] > 40 && all.frames_compared > 1, "{all:?}");
    // Without the conversion the numbers differ.
    std::fs::remove_file(home.join(set).join("units.json")).unwrap();
    assert!(!compare(&home.join("SI"), &home.join(set), &exactness).unwrap()[0].is_same());
}

/// Largest size in a column of a history.
fn largest(run: &Path, column: &str) -> f64 {
    let table = read_table(&run.join("history.csv")).unwrap().table;
    table.column(column).unwrap().values.iter().flatten().fold(0.0, |most: f64, value| most.max(value.abs()))
}

#[test]
fn an_impact_with_friction_in_millimeters_is_that_in_si_to_round_off() {
    // Every column and every field, the numbers of iterations included, but slips: in a frame in which all nodes stick they are round-off.
    agrees("drop", DROP, "mm-N-t", 1e-12, &["contact_slip"]);
    agrees("drop in milliseconds", DROP, "mm-kg-ms", 1e-12, &["contact_slip"]);
    let home = folder("drop in inches", DROP);
    run(&home, "US");
    assert!(largest(&home.join("US"), "pad.normal_force") > 1.0 && largest(&home.join("US"), "pad.friction_work") > 1e-6);
}

#[test]
fn a_bearing_in_millimeters_is_that_in_si() {
    // Round-off of vanishing quantities has no scale: momenta of rings at rest, resultants of a round support. The press fit of steel
    // amplifies that of displacements.
    let ignored = ["momentum_*", "*max_penetration", "*.reaction.*", "rim.*", "contact_gap"];
    agrees(
        "bearing",
        BEARING,
        "mm-N-t",
        1e-11,
        &[&ignored[..], &["displacement", "velocity", "acceleration", "contact_force", "stress*"]].concat(),
    );
    agrees(
        "bearing energies",
        BEARING,
        "mm-N-t",
        1e-12,
        &[
            &ignored[..],
            &["race.max_pressure", "*_stress", "stress*", "strain", "*_density", "von_mises"],
            &["displacement", "velocity", "acceleration", "contact_*"],
        ]
        .concat(),
    );
}

#[test]
fn springs_joints_and_rigid_bodies_have_the_dimensions_of_their_columns() {
    // A wrong dimension of a column would differ by a power of 1000.
    agrees("in space", IN_SPACE, "mm-N-t", 1e-6, &["newton_iterations", "factorizations"]);
    agrees("in space in milliseconds", IN_SPACE, "mm-kg-ms", 1e-6, &["newton_iterations", "factorizations"]);
}

#[test]
fn files_and_pictures_say_their_units() {
    let home = folder("shown", BEARING);
    let printed = run(&home, "mm-N-t");
    assert!(printed.contains(" mJ/mm") && printed.contains("t = 0.0001 s"), "{printed}");
    let out = home.join("mm-N-t");
    let text = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    let units = read_units(&out).unwrap().unwrap();
    for (column, unit) in [
        ("time", "s"),
        ("kinetic", "mJ/mm"),
        ("momentum_x", "t/s"),
        ("angular_momentum", "t*mm/s"),
        ("max_penetration", "mm"),
        ("race.normal_force", "N/mm"),
        ("race.max_pressure", "MPa"),
        ("race.area", "mm"),
        ("outer.outer.reaction.moment", "N"),
        ("rim.ux", "mm"),
        ("rim.ax", "mm/s^2"),
    ] {
        assert_eq!(units.columns.get(column).map(String::as_str), Some(unit), "{column}");
    }
    // Every column except counts has a unit of the table.
    let numbers = ["step", "newton_iterations", "halvings", "active", "factorizations", "race.active", "race.sliding"];
    for column in read_table(&out.join("history.csv")).unwrap().table.columns {
        assert_eq!(units.columns.contains_key(&column.name), !numbers.contains(&&*column.name), "{}", column.name);
    }
    let fields: BTreeMap<String, String> =
        read_fields(&out.join("fields/fields_000001.vtu")).unwrap().arrays.into_iter().map(|array| (array.name, array.unit)).collect();
    for (field, unit) in
        [("Points", "mm"), ("velocity", "mm/s"), ("stress", "MPa"), ("contact_force", "N/mm"), ("strain", ""), ("types", "")]
    {
        assert_eq!(fields[field], unit, "{field}");
    }
    assert!(text("summary.json").contains("\"stress\": \"MPa\""));
    assert!(text("energies.svg").contains("energy [mJ/mm]") && text("energies.svg").contains("time [s]"));
    assert!(text("history.svg").contains("energy [mJ/mm]"));
    assert!(text("mixed.svg").contains("kinetic energy [mJ/mm]") && text("mixed.svg").contains("displacement x [mm]"));
    assert!(text("stress.svg").contains("von Mises stress [MPa]") && text("stress.svg").contains("displacement [mm]"));
    let parquet = std::fs::read(out.join("all.parquet")).unwrap();
    assert!(String::from_utf8_lossy(&parquet).contains("\"race.max_pressure\":\"MPa\""));
    assert!(text("report.html").contains("\"von_mises\":\"MPa\""));
    run(&home, "SI");
    let different = program::conserva(&home, &["diff", "SI", "mm-N-t", "--ignore", "momentum*"]).output().unwrap();
    assert!(stdout(&different).contains(" J/m ") && stdout(&different).contains(" Pa "), "{}", stdout(&different));
    let exported = program::conserva(&home, &["export", "mm-N-t", "--format", "xdmf"]).output().unwrap();
    assert_eq!(exported.status.code(), Some(0), "{}", stderr(&exported));
    let list = std::fs::read_to_string(out.join("fields.xdmf")).unwrap();
    let of_stress = list.split("Attribute Name=\"stress\"").nth(1).unwrap();
    assert!(of_stress.split("</Attribute>").next().unwrap().contains("<Information Name=\"units\" Value=\"MPa\"/>"), "{list}");
    let info = program::conserva(&home, &["info", "mm-N-t"]).output().unwrap();
    assert!(stdout(&info).contains("stress=MPa"), "{}", stdout(&info));
}

/// Results name their unit or their dimension, in files of a run and of a study; what is no unit is refused.
#[test]
fn results_say_their_units() {
    let script = |unit: &str| {
        format!(
            "units(\"mm-N-t\");\nlet f = param(\"f\", 1.0, \"force / length\");\nresult(\"peak\", 2.5 * f, \"{unit}\");\n\
             result(\"force\", f, \"force / length\");\n\
             result(\"count\", 3);\nlet steel = neo_hookean(#{{ youngs_modulus: gpa(210), poisson_ratio: 0.3, density: kg_m3(7850) }});\n\
             let m = model(\"m\");\nm.add_body(\"b\", rectangle(#{{ size: [1.0, 1.0], cells: [2, 2] }}), steel);\n\
             let sim = simulate(m, #{{ integrator: energy_momentum(), dt: 1e-6 }});\nsim.step(2);"
        )
    };
    let home = folder("results", &script("MPa"));
    let output = program::conserva(&home, &["run", "main.rhai", "--out", "run"]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let summary = std::fs::read_to_string(home.join("run/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    assert_eq!(summary["result_units"], serde_json::json!({ "peak": "MPa", "force": "N/mm" }));
    assert_eq!(summary["parameter_units"], serde_json::json!({ "f": "N/mm" }));
    assert!(std::fs::read_to_string(home.join("run/report.html")).unwrap().contains("f [N/mm]"));
    assert!(std::fs::read_to_string(home.join("run/report.html")).unwrap().contains("2.5 MPa"));
    let arguments = ["sweep", "main.rhai", "--vary", "f=1,2,4", "--out", "study"];
    let output = program::conserva(&home, &arguments).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(format!("{}{}", stdout(&output), stderr(&output)).contains("peak [MPa]"), "{}{}", stdout(&output), stderr(&output));
    let text = |name: &str| String::from_utf8_lossy(&std::fs::read(home.join("study").join(name)).unwrap()).into_owned();
    assert!(text("study.html").contains(">peak [MPa]<") && text("study.html").contains(">force [N/mm]<"));
    assert!(text("pictures/peak_over_f.svg").contains("peak [MPa]") && text("pictures/peak_over_f.svg").contains("f [N/mm]"));
    assert!(text("study.html").contains(">f [N/mm]<") && !text("study.html").contains(">cause<"), "a column without values is left out");
    assert!(text("table.csv").starts_with("index,id,f,peak,force,count,"));
    let units: serde_json::Value = serde_json::from_str(&text("units.json")).unwrap();
    assert_eq!(units["columns"], serde_json::json!({ "f": "N/mm", "peak": "MPa", "force": "N/mm", "wall_seconds": "s" }));
    assert!(text("table.parquet").contains("\"peak\":\"MPa\""));
    let wrong = folder("wrong result", &script("MPx"));
    let output = program::conserva(&wrong, &["run", "main.rhai", "--out", "run"]).output().unwrap();
    assert!(stderr(&output).contains("C1077") && stderr(&output).contains("did you mean"), "{}", stderr(&output));
}

/// Lines of `conserva check` name the units of gravity, places, loads, prescribed motions and times.
#[test]
fn checks_say_their_units() {
    let script = "units(\"mm-N-t\");\nlet rubber = neo_hookean(#{ youngs_modulus: 2.0, poisson_ratio: 0.3, density: kg_m3(1000) });\n\
                  let m = model(\"m\");\nlet b = m.add_body(\"b\", rectangle(#{ size: [20.0, 10.0], cells: [4, 2] }), rubber);\n\
                  m.gravity([0.0, -9810.0]);\nm.pressure(b.boundary(\"top\"), 0.01);\n\
                  m.prescribe(b.boundary(\"left\"), #{ x: ramp(0.0, 0.1, 1.0) });\n\
                  let disk = rigid_disk(#{ center: [10.0, -5.0], radius: 4.0, motion: #{ angle: 0.0, about: [9.0, -5.0] } });\n\
                  m.add_contact(\"cam\", #{ secondary: b.boundary(\"bottom\"), primary: disk });\n\
                  let sim = simulate(m, #{ integrator: energy_momentum(), dt: 0.001 });";
    let home = folder("check", script);
    let output = program::conserva(&home, &["check", "main.rhai"]).output().unwrap();
    let text = stdout(&output);
    for line in [
        "dt = 0.001 s",
        "gravity [0, -9810] mm/s²",
        "prescribed x [mm] of \"b.left\"",
        "on \"b.top\" with amplitude 1, in MPa",
        "disk of radius 4 mm around [10, -5] mm, moving by angle: 0 about [9, -5] mm",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
}

#[test]
fn without_units_only_the_names_of_units_are_missing() {
    // The same numbers with and without a declaration: the histories have the same bytes.
    let script = |head: &str| {
        format!(
            "{head}\nlet rubber = neo_hookean(#{{ youngs_modulus: 1e6, poisson_ratio: 0.3, density: 1000.0 }});\nlet m = model(\"m\");\n\
             let b = m.add_body(\"b\", rectangle(#{{ size: [1.0, 1.0], cells: [2, 2] }}), rubber);\nm.initial_velocity(b, #{{ linear: \
             [1.0, 0.0], angular: 2.0 }});\nlet sim = simulate(m, #{{ integrator: energy_momentum(), dt: 0.01 }});\nsim.run_to(0.1);"
        )
    };
    let [with, without] = [("with", "units(\"SI\");"), ("without", "")].map(|(name, head)| {
        let home = folder(name, &script(head));
        let output = program::conserva(&home, &["run", "main.rhai", "--quiet", "--out", "out"]).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        home
    });
    let read = |home: &Path, name: &str| std::fs::read(home.join("out").join(name)).unwrap();
    assert_eq!(read(&with, "history.csv"), read(&without, "history.csv"));
    assert!(!without.join("out/units.json").exists());
    assert!(!String::from_utf8_lossy(&read(&without, "summary.json")).contains("units"));
    assert!(!String::from_utf8_lossy(&read(&without, "fields/fields_000000.vtu")).contains("UNITS_LABEL"));
}
