//! `report.html` in a headless Chromium: it loads without errors, the picture changes when it is played and scrubbed, numbers equal those
//! of `history.csv`, and names cannot inject markup. Without a browser on the machine these tests print a message and pass.

#[path = "../common/browser.rs"]
mod browser;
mod fields;
mod layout;
mod markup;
mod several;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use browser::Browser;
use serde_json::{Value, json};

/// A drop onto the ground, with names that contain markup.
const SCRIPT: &str = r#"
let height = param("height", 0.1);
let rubber = neo_hookean(#{ youngs_modulus: 1e3, poisson_ratio: 0.3, density: 1.0 });
let drop = model("drop");
let ball = drop.add_body("</script><script>alert(1)</script>", disk(#{ radius: 0.5, cells: [4, 16], center: [0.0, 0.5 + height] }), rubber);
drop.gravity([0.0, -10.0]);
drop.add_contact("<b>ground</b>", #{ secondary: ball.boundary("outer"), primary: rigid_plane(#{ point: [0.0, 0.0], normal: [0.0, 1.0] }) });
let sim = simulate(drop, #{ integrator: energy_momentum(), dt: 0.005 });
sim.run_to(0.3);
report(sim, "halfway.html");
"#;

/// An empty folder for a test.
fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("conserva report {name} {}", std::process::id()));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Runs a script into a folder.
fn run(folder: &Path, script: &str, out: &str) -> PathBuf {
    fs::write(folder.join("drop.rhai"), script).unwrap();
    let out = folder.join(out);
    let output =
        Command::new(env!("CARGO_BIN_EXE_conserva")).arg("run").arg(folder.join("drop.rhai")).arg("--out").arg(&out).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    out
}

/// Starts the browser; prints a message and returns `None` if no browser is found.
fn browser(folder: &Path) -> Option<Browser> {
    let browser = Browser::start(&folder.join("profile"));
    if browser.is_none() {
        eprintln!("SKIPPED: no Chromium on this machine, so nobody has looked at the report");
    }
    browser
}

/// Checksum of the picture.
const PICTURE: &str =
    "[...document.getElementById('canvas').toDataURL()].reduce((sum, letter) => (sum * 31 + letter.charCodeAt(0)) >>> 0, 0)";

#[test]
fn two_runs_have_the_same_page() {
    let folder = folder("twice");
    let (first, second) = (run(&folder, SCRIPT, "a"), run(&folder, SCRIPT, "b"));
    for name in ["report.html", "halfway.html"] {
        let page = fs::read(first.join(name)).unwrap();
        assert!(page == fs::read(second.join(name)).unwrap(), "{name}");
        let text = String::from_utf8(page).unwrap();
        assert!(!text.contains(&*folder.to_string_lossy()), "no folder of this machine is in the page");
    }
}

#[test]
fn a_run_that_fails_has_its_page_too() {
    let folder = folder("failed");
    fs::write(folder.join("drop.rhai"), format!("{SCRIPT}\nexpect(false, \"<i>never</i>\");")).unwrap();
    let out = folder.join("out");
    let run =
        Command::new(env!("CARGO_BIN_EXE_conserva")).arg("run").arg(folder.join("drop.rhai")).arg("--out").arg(&out).output().unwrap();
    assert_eq!(run.status.code(), Some(1));
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("\\u003ci>never"), "the page tells how the run ended");
}

#[test]
fn the_picture_plays_and_is_scrubbed_and_numbers_are_those_of_the_history() {
    let folder = folder("browser");
    let Some(mut page) = browser(&folder) else { return };
    let out = run(&folder, SCRIPT, "out");
    page.open(&out.join("report.html"));
    assert_eq!(page.evaluate("document.querySelectorAll('script').length > 3 && document.getElementById('trouble').hidden"), json!(true));

    // Moving the time slider changes the picture.
    let start = page.evaluate(PICTURE);
    page.evaluate("(() => { const m = document.getElementById('moment'); m.value = 30; m.dispatchEvent(new Event('input')); })()");
    page.settle();
    let middle = page.evaluate(PICTURE);
    assert_ne!(start, middle);

    // Every number at the chosen time and in the ledger equals that of history.csv.
    let mut history = csv_of(&out.join("history.csv"));
    let names = history.remove(0);
    let row = page.evaluate("conserva.row").as_u64().unwrap() as usize;
    assert_eq!(row, 30, "a still for every step");
    let shown = page.evaluate("Object.fromEntries([...document.querySelectorAll('#readout dd')].map((e) => [e.dataset.column, e.title]))");
    let shown = shown.as_object().unwrap();
    assert!(shown.len() > 10);
    for (name, text) in shown {
        let column = names.iter().position(|known| known == name).unwrap();
        assert_eq!(text.as_str().unwrap().parse::<f64>().unwrap(), history[row][column].parse::<f64>().unwrap(), "{name}");
    }
    for row in [0, 30, 60] {
        page.evaluate(&format!("conserva.goToRow({row})"));
        let cells = page.evaluate(&format!("[...document.querySelectorAll('#rows tr[data-row=\"{row}\"] td')].map((e) => e.textContent)"));
        let cells: Vec<&str> = cells.as_array().unwrap().iter().map(|cell| cell.as_str().unwrap()).collect();
        assert_eq!(cells.len(), names.len());
        for ((cell, value), name) in cells.iter().zip(&history[row]).zip(&names) {
            let same = if value.is_empty() { *cell == "–" } else { cell.parse::<f64>().unwrap() == value.parse::<f64>().unwrap() };
            assert!(same, "row {row}, {name}: {cell} for {value}");
        }
    }

    // The space key starts and stops the animation.
    page.evaluate("(() => { conserva.goToStill(0); document.getElementById('canvas').focus(); })()");
    page.press(" ");
    page.wait_for("conserva.still > 5");
    page.press(" ");
    assert_eq!(page.evaluate("conserva.isPlaying"), json!(false));
    page.press("End");
    assert_eq!(page.evaluate("conserva.row"), json!(60));
    page.press("ArrowLeft");
    assert_eq!(page.evaluate("conserva.row"), json!(59));
    let before = page.evaluate(PICTURE);
    page.press("+");
    assert_ne!(page.evaluate(PICTURE), before, "zoomed");

    // All fields, the other shapes, the other theme.
    for field in page.evaluate("conserva.data.fields.map((field) => field.name)").as_array().unwrap().clone() {
        page.evaluate(&format!(
            "(() => {{ const f = document.getElementById('field'); f.value = {field}; f.dispatchEvent(new Event('change')); }})()"
        ));
        page.settle();
    }
    for change in ["undeformed", "mesh", "arrows"] {
        page.evaluate(&format!("document.getElementById('{change}').click()"));
        page.settle();
    }
    let light = page.evaluate(PICTURE);
    page.evaluate("(() => { const t = document.getElementById('theme'); t.value = 'dark'; t.dispatchEvent(new Event('change')); })()");
    page.settle();
    assert_ne!(page.evaluate(PICTURE), light, "dark");

    // Names injected nothing, and there were no errors.
    let body = page.evaluate("conserva.data.bodies[0].name");
    assert_eq!(body, json!("</script><script>alert(1)</script>"));
    assert_eq!(page.evaluate("document.querySelectorAll('b, i').length === document.querySelectorAll('.legend b').length"), json!(true));
    assert_eq!(page.complaints, Vec::<Value>::new());
    page.open(&out.join("halfway.html"));
    assert_eq!(page.evaluate("document.getElementById('outcome').textContent"), json!("so far, t = 0.3"));
    assert_eq!(page.complaints, Vec::<Value>::new());
}

/// A crank with a motor and a geared wheel: rigid bodies only.
const MACHINE: &str = r#"
let mill = model("mill");
let wheel = |name, x| mill.add_rigid_body(name, disk(#{ radius: 0.5, cells: [2, 16], center: [x, 0.0] }), #{ mass: 1.0 });
let driver = wheel.call("driver", 0.0);
let driven = wheel.call("driven", 1.5);
mill.add_joint("axle", #{ kind: "point", from: driver, point: [0.0, 0.0], drive: |t| t * t });
mill.add_joint("shaft", #{ kind: "point", from: driven, point: [1.5, 0.0] });
mill.add_gear("mesh", #{ joints: ["axle", "shaft"], ratio: 2.0 });
let sim = simulate(mill, #{ integrator: energy_momentum(), dt: 0.01 });
sim.run_to(0.5);
result("angle", sim.joint("shaft").angle);
expect_conserved(sim, "ledger", #{ tolerance: 1e-10 });
"#;

/// Texts of the elements that a selector finds.
fn texts(page: &mut Browser, selector: &str) -> Vec<String> {
    let found = page.evaluate(&format!("[...document.querySelectorAll('{selector}')].map((e) => e.textContent)"));
    found.as_array().unwrap().iter().map(|text| text.as_str().unwrap().to_string()).collect()
}

#[test]
fn a_machine_is_summed_up_and_colored_by_its_bodies() {
    let folder = folder("machine");
    let out = run(&folder, MACHINE, "out");
    let Some(mut page) = browser(&folder) else { return };
    for width in [390, 1280] {
        page.call("Emulation.setDeviceMetricsOverride", json!({ "width": width, "height": 900, "deviceScaleFactor": 1, "mobile": false }));
        page.open(&out.join("report.html"));
        let lines = texts(&mut page, "#summary dd");
        assert!((7..=10).contains(&lines.len()), "{lines:?}");
        assert!(lines[0].starts_with("2 bodies, ") && lines[0].ends_with("3 joints"), "{lines:?}");
        let cells = texts(&mut page, "#tables td");
        let is_shown = |text: &str| cells.iter().any(|cell| cell.starts_with(text));
        assert!(is_shown("gear of \"axle\" and \"shaft\", ratio 2") && is_shown("driven: ") && is_shown("-0.125"), "{cells:?}");
        assert_eq!(page.evaluate("document.getElementById('field').value"), json!("body"));
        // On a narrow screen plots come before the numbers at the chosen time.
        let top = |id: &str| format!("document.getElementById('{id}').getBoundingClientRect().top");
        let comes_first = page.evaluate(&format!("{} < {}", top("plots"), top("now")));
        assert_eq!(comes_first, json!(width == 390));
        assert_eq!(page.evaluate("document.documentElement.scrollWidth <= innerWidth"), json!(true), "{width}");
        assert_eq!(page.complaints, Vec::<Value>::new());
    }
}

/// Visibility in space: near bodies hide distant ones, and the ground is visible from above and not from below.
#[test]
fn bodies_in_space_and_the_ground_below_them_are_seen_from_where_the_viewer_is() {
    let folder = folder("space");
    let Some(mut page) = browser(&folder) else { return };
    let script = r#"
let m = model("cube");
let rubber = neo_hookean(#{ youngs_modulus: 1e3, poisson_ratio: 0.3, density: 1.0 });
let cube = m.add_body("cube", block(#{ size: [1.0, 1.0, 1.0], cells: [2, 2, 2] }), rubber);
m.add_contact("ground", #{ secondary: cube.boundary("back"), primary: rigid_plane(#{ point: [0.0, 0.0, 0.0], normal: [0.0, 0.0, 1.0] }) });
let sim = simulate(m, #{ integrator: energy_momentum(), dt: 0.01 });
sim.step(2);
"#;
    let out = run(&folder, script, "out");
    page.open(&out.join("report.html"));
    page.settle();
    let off = "Math.max(...(() => { const [r, u, t] = conserva.scene.axes(); \
               const x = [r[1] * u[2] - r[2] * u[1], r[2] * u[0] - r[0] * u[2], r[0] * u[1] - r[1] * u[0]]; \
               return x.map((x, k) => Math.abs(x - t[k])); })())";
    assert!(page.evaluate(off).as_f64().unwrap() < 1e-12, "right, up and toward the viewer make a right-handed triad");
    // Fraction of the picture with the lit gray of obstacles.
    let gray = "(() => { const { data } = conserva.scene.image; let count = 0; \
                for (let k = 0; k < data.length; k += 4) { \
                  const [r, g, b] = data.slice(k, k + 3); if (r > 100 && r < 200 && r <= g && g <= b && b - r < 14) count += 1; } \
                return 4 * count / data.length; })()";
    let seen = page.evaluate(gray).as_f64().unwrap();
    assert!(seen > 0.05, "the ground is seen from above: {seen}");
    page.evaluate("conserva.scene.turn[1] = -0.5; conserva.redraw()");
    page.settle();
    assert!(page.evaluate(gray).as_f64().unwrap() < 0.01, "and not from below");
    assert_eq!(page.complaints, Vec::<Value>::new());
}

/// A section of a tube: its wall has a face, plain if only the surface is recorded and colored if the inside is; its hole has none, and the
/// part on the viewer's side is removed.
#[test]
fn a_cut_shows_the_inside() {
    let folder = folder("cut");
    let Some(mut page) = browser(&folder) else { return };
    for inside in [false, true] {
        let script = format!(
            r#"
let m = model("tube");
let rubber = neo_hookean(#{{ youngs_modulus: 1e3, poisson_ratio: 0.3, density: 1.0 }});
let b = m.add_body("tube", tube(#{{ inner_radius: 0.5, outer_radius: 1.0, height: 2.0, cells: [3, 24, 4] }}), rubber);
m.initial_velocity(b, #{{ angular: [0.0, 0.0, 1.0] }});
let sim = simulate(m, #{{ integrator: energy_momentum(), dt: 0.01, stills_inside: {inside} }});
sim.step(2);
"#
        );
        let out = run(&folder, &script, if inside { "inside" } else { "outside" });
        page.open(&out.join("report.html"));
        page.settle();
        page.evaluate("conserva.scene.turn = [0, 1.57]; conserva.scene.magnify = 1");
        page.evaluate("document.getElementById('field').value = 'velocity'; document.getElementById('mesh').checked = false");
        page.evaluate("document.getElementById('cut').value = '2'; document.getElementById('cut').dispatchEvent(new Event('input'))");
        page.settle();
        // Distance of the picture from the viewer, and its color, a distance from the axis.
        let at = |page: &mut Browser, x: f64| {
            let pixel = format!(
                "(() => {{ const s = conserva.scene, x = s.place([{x}, 0, 0]), k = Math.floor(x[1]) * s.canvas.width + Math.floor(x[0]); \
                 const c = s.pixels[k]; return [s.depths[k] / s.zoom, c & 255, (c >> 8) & 255, (c >> 16) & 255]; }})()"
            );
            let value = page.evaluate(&pixel);
            value.as_array().unwrap().iter().map(|number| number.as_f64()).collect::<Vec<_>>()
        };
        let [wall, hole] = [0.75, 0.0].map(|x| at(&mut page, x));
        assert!(wall[0].unwrap().abs() < 0.01, "the face lies in the middle of the tube: {wall:?}");
        assert_eq!(hole[0], None, "the hole is open: {hole:?}");
        let saturation = (wall[1].unwrap() - wall[3].unwrap()).abs();
        assert_eq!(saturation > 20.0, inside, "{wall:?}");
        let note = page.evaluate("document.getElementById('cut-note').hidden");
        assert_eq!(note, json!(inside));
        // At the far end only the face itself is removed.
        page.evaluate(
            "document.getElementById('cut-at').value = '1000'; document.getElementById('cut-at').dispatchEvent(new Event('input'))",
        );
        page.settle();
        assert!((at(&mut page, 0.75)[0].unwrap() - 1.0).abs() < 0.01);
        page.evaluate("document.getElementById('cut').value = ''; document.getElementById('cut').dispatchEvent(new Event('input'))");
        page.settle();
        assert!((at(&mut page, 0.75)[0].unwrap() - 1.0).abs() < 0.01, "the end of the tube");
        assert_eq!(page.complaints, Vec::<Value>::new());
    }
}

/// Lines and fields of a file; no name has a comma or quote here.
fn csv_of(path: &Path) -> Vec<Vec<String>> {
    let text = fs::read_to_string(path).unwrap();
    text.lines().map(|line| line.split(',').map(String::from).collect()).collect()
}
