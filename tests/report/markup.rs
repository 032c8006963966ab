//! Texts of a script that contain markup: every page shows them as text, and none is executed.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::{Value, json};

use super::browser::Browser;
use super::{browser, folder};

/// Payload with a number that would be executed.
fn payload(number: usize) -> String {
    let forms = ["<img src=x onerror=hit(N)>", "</script><script>hit(N)</script>", "<svg onload=hit(N)>", "'><img src=x onerror=hit(N)>"];
    forms[number % forms.len()].replace('N', &number.to_string())
}

/// A script with a payload in every `@`.
fn filled(script: &str, count: &mut usize) -> String {
    let mut parts = script.split('@');
    let mut text = parts.next().unwrap_or_default().to_string();
    for part in parts {
        *count += 1;
        text += &payload(*count);
        text += part;
    }
    text
}

const MODULE: &str = "// @\nconst X = \"@\";\n";

const SCRIPT: &str = r#"// @
/* @ */
import "lib" as lib;
let color = param("color", "@");
let other = param("other", `@`);
let law = neo_hookean(#{ youngs_modulus: 1e3, poisson_ratio: 0.3, density: 1.0 });
let m = model("@");
let ball = m.add_body("@", disk(#{ radius: 0.5, cells: [3, 12], center: [0.0, 0.55] }), law);
let plate = m.add_body("@", region(#{ outline: [[2.0, 0.0], line_to([3.0, 0.0], "@"), [3.0, 1.0], [2.0, 1.0]], size: 0.4 }), law);
m.gravity([0.0, -10.0]);
m.add_contact("@", #{ secondary: ball.boundary("outer"), primary: rigid_plane(#{ point: [0.0, 0.0], normal: [0.0, 1.0] }) });
m.add_spring("@", #{ from: ball, from_point: [0.12940952255126037, 0.06703708685546589], to: plate, to_point: [2.0, 0.0], stiffness: 1.0 });
let sim = simulate(m, #{ integrator: energy_momentum(), dt: 0.005, fields_every: 0.05 });
sim.probe("@", ball, [0.0, 0.06]);
sim.on_step(|s| { if s.time > 0.09 { print("@"); } });
sim.run_to(0.1);
result("@", "@");
result("@", 1.0);
result("undefined @", 0.0 / 0.0);
expect(true, "@");
expect(sim.time > 0.0, "@");
let rows = sweep(#{ vary: #{ x: [1.0, 2.0] }, run: |p| #{ y: `@` } });
write_table("@.csv", rows);
let third = model("@");
third.add_body("@", rectangle(#{ size: [1.0, 1.0], cells: [1, 1] }), law);
let flight = simulate(third, #{ integrator: midpoint(), dt: 0.1 });
flight.step();
if param("fails", false) { throw "@"; }
expect(color != "stop", "@");
"#;

/// Opens a page and returns the payloads that were executed.
fn ran(page: &mut Browser, path: &Path) -> Value {
    page.call("Page.navigate", json!({ "url": format!("file://{}", path.display()) }));
    page.wait_for("document.readyState === 'complete' && location.protocol === 'file:'");
    // Errors of images that cannot be loaded come later.
    page.evaluate("new Promise((done) => setTimeout(() => done(true), 300))");
    page.evaluate("window.hits")
}

#[test]
fn texts_that_are_markup_run_in_no_page() {
    let home = folder("markup");
    let Some(mut page) = browser(&home) else { return };
    page.call("Page.addScriptToEvaluateOnNewDocument", json!({ "source": "window.hits = []; window.hit = (n) => window.hits.push(n);" }));
    // Payloads without escaping are executed.
    let all: Vec<String> = (1..5).map(payload).collect();
    fs::write(home.join("plain.html"), format!("<!DOCTYPE html><script>0</script>{}", all.concat())).unwrap();
    let hits = ran(&mut page, &home.join("plain.html"));
    assert_eq!(hits.as_array().map(Vec::len), Some(4), "{hits}");

    let mut count = 0;
    fs::write(home.join("main.rhai"), filled(SCRIPT, &mut count)).unwrap();
    fs::write(home.join("lib.rhai"), filled(MODULE, &mut count)).unwrap();
    assert!(count >= 26, "{count}");
    let conserva = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_conserva")).current_dir(&home).args(arguments).output().unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    // One that completes and one that fails, with markup in values and in the name of the folder.
    let value = format!("color={}", payload(30));
    let (code, messages) = conserva(&["run", "main.rhai", "--quiet", "--out", "whole", "--set", &value]);
    assert_eq!(code, Some(0), "{messages}");
    let (code, messages) = conserva(&["run", "main.rhai", "--quiet", "--out", "<img src=x onerror=hit(31)>", "--set", "fails=true"]);
    assert_eq!(code, Some(2), "{messages}");
    let (code, messages) =
        conserva(&["sweep", "main.rhai", "--quiet", "--out", "study", "--vary", &format!("color={},red,stop", payload(34))]);
    assert!(matches!(code, Some(0 | 1)), "{code:?} {messages}");
    let mut pages = pages_below(&home);
    pages.retain(|path| !path.ends_with("plain.html") && !path.starts_with(home.join("profile")));
    assert!(pages.len() > 4, "{pages:?}");
    for path in &pages {
        let hits = ran(&mut page, path);
        assert_eq!(hits, json!([]), "{}", path.display());
        // All data of the run are visible, as text.
        let text = page.evaluate("document.documentElement.outerHTML");
        assert!(text.as_str().unwrap_or_default().contains("hit("), "{}", path.display());
    }
}

/// The pages in a folder and below it.
fn pages_below(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(pages_below(&path));
        } else if path.extension().is_some_and(|ending| ending == "html") {
            found.push(path);
        }
    }
    found
}
