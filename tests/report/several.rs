//! Several runs on one page, and the content of a page of one run: nodes with curves, symbols of the model, pictures, printed lines.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::{Value, json};

use super::{SCRIPT, browser, folder, run, texts};

fn report(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_conserva")).arg("report").args(arguments).current_dir(folder).output().unwrap()
}

/// A wheel with a drive, a spring and a link, and a fixed and loaded block.
const PARTS: &str = r#"
let m = model("parts");
let rubber = neo_hookean(#{ youngs_modulus: 1e3, poisson_ratio: 0.3, density: 1.0 });
let wheel = m.add_rigid_body("wheel", disk(#{ radius: 0.5, cells: [2, 16], center: [0.0, 0.0] }), #{ mass: 1.0 });
let block = m.add_body("block", rectangle(#{ size: [1.0, 1.0], cells: [4, 4], origin: [2.0, 0.0] }), rubber);
m.add_joint("axle", #{ kind: "point", from: wheel, point: [0.0, 0.0], drive: |t| 4.0 * t * t });
m.add_spring("tie", #{ from: wheel, from_point: [0.3, 0.1], to: "ground", to_point: [0.0, 2.0], stiffness: 1.0 });
m.fix(block.boundary("bottom"));
m.pressure(block.boundary("top"), 0.1);
m.traction(block.boundary("right"), [0.1, 0.0]);
let sim = simulate(m, #{ integrator: energy_momentum(), dt: 0.01 });
sim.run_to(0.5);
let u = sim.field("displacement", block)[24];
result("displacement", sqrt(u[0] * u[0] + u[1] * u[1]));
result("principal", sim.field("principal_3", block)[12]);
result("tresca", sim.field("tresca", block)[12]);
sim.picture("parts.svg");
plot_curves("line.svg", [#{ x: [0.0, 1.0], y: [0.0, 1.0] }]);
print("first line\nsecond <b>line</b>");
"#;

#[test]
fn a_page_shows_nodes_over_time_and_the_symbols_of_the_problem() {
    let folder = folder("parts");
    let Some(mut page) = browser(&folder) else { return };
    let out = run(&folder, PARTS, "out");
    page.open(&out.join("report.html"));
    // A value of a node, alone and of the whole field, in every still.
    let same = "(() => { const { film, bodies, data } = conserva; let worst = 0; \
                for (const { name } of data.fields) for (const k of [0, 17, data.stills.length - 1]) { \
                film.show(k); bodies.forEach((body, b) => { const all = film.field(name, b, new Float32Array(body.nodes)); \
                for (let i = 0; i < body.nodes; i += 3) { const off = Math.abs(all[i] - film.valueAt(name, k, b, i)); \
                worst = Math.max(worst, off / (1e-9 + Math.abs(all[i]))); } }); } return worst; })()";
    assert!(page.evaluate(same).as_f64().unwrap() < 1e-5);
    // Node entered with the keyboard: its curve ends at the value printed by the script.
    let summary: Value = serde_json::from_str(&fs::read_to_string(out.join("summary.json")).unwrap()).unwrap();
    let expected = summary["results"]["displacement"].as_f64().unwrap();
    page.evaluate(
        "(() => { const f = document.getElementById('field'); f.value = 'displacement'; f.dispatchEvent(new Event('change')); \
                   document.getElementById('node-body').value = '1'; document.getElementById('node-number').focus(); })()",
    );
    page.call("Input.insertText", json!({ "text": "24" }));
    for kind in ["keyDown", "keyUp"] {
        page.call(
            "Input.dispatchKeyEvent",
            json!({ "type": kind, "key": "Enter", "code": "Enter", "text": "\r", "windowsVirtualKeyCode": 13 }),
        );
    }
    page.settle();
    let curve = page.evaluate("conserva.nodes.plot.curves[0].values");
    let last = curve.as_array().unwrap().last().unwrap().as_f64().unwrap();
    assert!((last - expected).abs() < 1e-4 * expected, "{last} {expected}");
    assert_eq!(texts(&mut page, "#nodes .pair button"), ["Curve of the node", "× block, node 24"]);
    // Fields computed by the page from the stress, at the end.
    for (name, field) in [("principal", "principal_3"), ("tresca", "tresca")] {
        let expected = summary["results"][name].as_f64().unwrap();
        let found = page.evaluate(&format!("conserva.film.valueAt('{field}', conserva.data.stills.length - 1, 1, 12)")).as_f64().unwrap();
        assert!((found - expected).abs() < 1e-3 * expected.abs(), "{field}: {found} {expected}");
    }
    // A click on a node adds it; an invalid number is reported.
    let place = "(() => { document.getElementById('canvas').scrollIntoView(); \
                 const s = conserva.scene, p = s.places[1], b = s.canvas.getBoundingClientRect(); \
                 return [b.left + p[0] / s.fineness, b.top + p[1] / s.fineness]; })()";
    let at = page.evaluate(place);
    for kind in ["mouseMoved", "mousePressed", "mouseReleased"] {
        page.call("Input.dispatchMouseEvent", json!({ "type": kind, "x": at[0], "y": at[1], "button": "left", "clickCount": 1 }));
    }
    page.settle();
    assert_eq!(page.evaluate("conserva.nodes.chosen[1]"), json!({ "body": 1, "node": 0 }));
    page.evaluate("conserva.nodes.addNumber(1, '99')");
    assert_eq!(page.evaluate("conserva.nodes.note.textContent"), json!("block has nodes 0 to 24."));
    // Symbols: those of the model, few, at their points.
    let kinds = page.evaluate("conserva.data.marks.map(({ kind, name }) => `${kind} ${name}`)");
    assert_eq!(kinds, json!(["support block.bottom", "pressure block.top", "load block.right", "line tie", "joint axle"]));
    let spring = page.evaluate(
        "conserva.goToStill(conserva.data.stills.length - 1), conserva.film.show(conserva.still), \
                                conserva.placeOf(conserva.data.marks.find(({ kind }) => kind === 'line').places[0])",
    );
    let (sine, cosine) = 1.0_f64.sin_cos();
    let turned = [0.3 * cosine - 0.1 * sine, 0.3 * sine + 0.1 * cosine];
    for (component, expected) in turned.into_iter().enumerate() {
        assert!((spring[component].as_f64().unwrap() - expected).abs() < 1e-4, "{spring} {turned:?}");
    }
    let picture = "conserva.draw(), document.getElementById('canvas').toDataURL()";
    let with = page.evaluate(picture);
    page.evaluate("document.getElementById('marks').click()");
    assert_ne!(page.evaluate(picture), with);
    // Pictures and lines of the script.
    assert_eq!(texts(&mut page, "#printed-lines"), ["first line\nsecond <b>line</b>"]);
    assert_eq!(texts(&mut page, "#picture-list figcaption"), ["parts.svg", "line.svg"]);
    page.wait_for("[...document.querySelectorAll('#picture-list img')].every((image) => image.complete && image.naturalWidth > 100)");
    assert_eq!(page.complaints, Vec::<Value>::new());
}

#[test]
fn several_runs_stand_on_one_page() {
    let folder = folder("several");
    let Some(mut page) = browser(&folder) else { return };
    run(&folder, SCRIPT, "low");
    run(&folder, &SCRIPT.replace("param(\"height\", 0.1)", "param(\"height\", 0.2)"), "high");
    // A run that fails, of a model in space.
    let failing = r#"
let m = model("cube");
let rubber = neo_hookean(#{ youngs_modulus: 1e3, poisson_ratio: 0.3, density: 1.0 });
let cube = m.add_body("cube", block(#{ size: [1.0, 1.0, 1.0], cells: [2, 2, 2] }), rubber);
let sim = simulate(m, #{ integrator: energy_momentum(), dt: 0.01 });
sim.run_to(0.1);
throw "<i>stopped</i>";
"#;
    fs::write(folder.join("cube.rhai"), failing).unwrap();
    let failed = Command::new(env!("CARGO_BIN_EXE_conserva")).args(["run", "cube.rhai", "--out", "cube"]).current_dir(&folder).output();
    assert_eq!(failed.unwrap().status.code(), Some(2));
    let made = report(&folder, &["low", "high", "cube", "--out", "pages/three.html"]);
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    page.open(&folder.join("pages/three.html"));
    assert_eq!(texts(&mut page, "#views figcaption > span:first-child"), ["low", "high", "cube"]);
    assert_eq!(
        page.evaluate("[...document.querySelectorAll('#views .badge')].map((e) => e.classList.contains('well'))"),
        json!([true, true, false])
    );
    // One set of axes for all runs: the kinetic energy of each at its own times, with the values of the histories.
    let kinetic = page.evaluate("conserva.plots[0].curves.map(({ label, values, time }) => [label, values.length === time.length])");
    assert_eq!(kinetic, json!([["low", true], ["high", true], ["cube", true]]));
    let history = fs::read_to_string(folder.join("high/history.csv")).unwrap();
    let column = history.lines().next().unwrap().split(',').position(|name| name == "kinetic").unwrap();
    let last: f64 = history.lines().last().unwrap().split(',').nth(column).unwrap().parse().unwrap();
    assert_eq!(page.evaluate("[...conserva.plots[0].curves[1].values].pop()").as_f64().unwrap(), last);
    // Differences: the parameter, the model, the line of the script.
    let cells = texts(&mut page, "#difference-list tbody tr");
    assert!(cells.iter().any(|row| row == "height0.10.2–"), "{cells:?}");
    let lines = texts(&mut page, "#difference-list pre .added");
    assert!(lines.iter().any(|line| line.contains("param(\"height\", 0.2)")), "{lines:?}");
    // Pictures are synchronized; after the end of a run its last one remains.
    page.evaluate("conserva.goTo(conserva.times.length - 1)");
    let clocks = texts(&mut page, "#views figure > span");
    assert_eq!(clocks, ["t = 0.3", "t = 0.3", "ended at t = 0.1"]);
    let before = page.evaluate("conserva.sides.map((side) => side.scene.magnify)");
    page.evaluate("conserva.sides[0].canvas.focus()");
    page.press("+");
    assert_ne!(page.evaluate("conserva.sides.map((side) => side.scene.magnify)"), before);
    assert_eq!(page.evaluate("document.querySelectorAll('i').length"), json!(0), "texts stay texts");
    assert_eq!(page.complaints, Vec::<Value>::new());
}

#[test]
fn a_script_compares_its_simulations() {
    let folder = folder("compared");
    let script = r#"
let rubber = neo_hookean(#{ youngs_modulus: 1e3, poisson_ratio: 0.3, density: 1.0 });
let thrown = |speed| {
    let m = model("plate");
    let plate = m.add_body("plate", rectangle(#{ size: [1.0, 1.0], cells: [2, 2] }), rubber);
    m.initial_velocity(plate, #{ linear: [speed, 0.0] });
    let sim = simulate(m, #{ integrator: energy_momentum(), dt: 0.01 });
    sim.run_to(0.05);
    sim
};
report([thrown.call(1.0), thrown.call(2.0)], "both.html");
"#;
    let out = run(&folder, script, "out");
    let text = fs::read_to_string(out.join("both.html")).unwrap();
    let start = text.find("id=\"data\">").unwrap() + 10;
    let data: Value = serde_json::from_str(&text[start..start + text[start..].find("</script>").unwrap()]).unwrap();
    let labels: Vec<&str> = data["runs"].as_array().unwrap().iter().map(|run| run["label"].as_str().unwrap()).collect();
    assert_eq!(labels.len(), 2);
    assert_ne!(labels[0], labels[1]);
    let Some(mut page) = browser(&folder) else { return };
    page.open(&out.join("both.html"));
    let kinetic = page.evaluate("conserva.plots[0].curves.map(({ values }) => values[0])");
    for (found, expected) in kinetic.as_array().unwrap().iter().zip([0.5, 2.0]) {
        assert!((found.as_f64().unwrap() - expected).abs() < 1e-12, "{kinetic}");
    }
    assert_eq!(page.complaints, Vec::<Value>::new());
}

#[test]
fn what_makes_no_page_is_told() {
    let folder = folder("refused");
    run(&folder, SCRIPT, "low");
    run(&folder, SCRIPT, "cut");
    fs::remove_file(folder.join("cut/report.html")).unwrap();
    fs::write(folder.join("other.html"), "<html></html>").unwrap();
    let cases: [(&[&str], &str, &str); 8] = [
        (&["low"], "is one run, and nothing to compare", "low/report.html"),
        (&["low", "low"], "is named twice", "once"),
        (&["low", "none"], "does not exist", "check the path"),
        (&["low", "cut"], "has no report.html", "conserva resume cut"),
        (&["low", "other.html"], "is no report of a run", "folder of a run"),
        (&["low", "."], "holds no run", "conserva list"),
        (&["low", "cut", "--out", "page.txt"], "which ends with `.html`", "--out page.html"),
        (&["a", "b", "c", "d", "e", "f", "g"], "is one of 7 runs", "conserva sweep"),
    ];
    for (arguments, title, hint) in cases {
        let output = report(&folder, arguments);
        let message = String::from_utf8_lossy(&output.stderr).replace("\n ", " ");
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(title) && message.contains(hint), "{arguments:?}: {message}");
        assert!(!folder.join("comparison.html").exists() && !folder.join("page.txt").exists());
    }
    // A page of several runs is not accepted as that of one run.
    run(&folder, SCRIPT, "high");
    assert!(report(&folder, &["low", "high"]).status.success());
    let output = report(&folder, &["low", "comparison.html"]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("shows several runs"));
}
