//! Pages at the widths of a telephone, a laptop and a large screen, light and dark: no overlapping or cut texts, no errors, and no serious
//! finding of the accessibility checker axe-core. Without axe-core on the machine (`AXE_CORE` names its `axe.min.js`, or a global
//! `npm install -g axe-core`) this part is skipped with a message.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::{Value, json};

use super::browser::Browser;
use super::{MACHINE, browser, folder, run};

/// Ten bodies in space that fall onto each other, loaded, fixed and connected by a spring.
const IN_SPACE: &str = r#"
let m = model("ten bodies");
let rubber = neo_hookean(#{ youngs_modulus: 1e4, poisson_ratio: 0.3, density: 1.0 });
let bodies = [];
for k in 0..10 {
    let origin = [1.5 * (k % 5), 0.0, 1.2 * (k / 5)];
    bodies.push(m.add_body(`block ${k}`, block(#{ size: [1.0, 1.0, 1.0], cells: [2, 2, 2], origin: origin }), rubber));
}
m.fix(bodies[0].boundary("back"));
m.traction(bodies[1].boundary("front"), [0.0, 0.0, -1.0]);
m.pressure(bodies[2].boundary("right"), 1.0);
m.add_spring("tie", #{ from: bodies[3], from_point: [5.5, 1.0, 1.0], to: bodies[9], to_point: [6.0, 0.0, 2.2], stiffness: 10.0 });
m.gravity([0.0, 0.0, -9.81]);
let sim = simulate(m, #{ integrator: energy_momentum(), dt: 0.01 });
sim.run_to(0.1);
sim.picture("blocks.svg", #{ field: "velocity" });
print("printed by the script");
"#;

/// A damper for the machine with joints, a gear and a drive.
const BRAKE: &str =
    r#"mill.add_damper("brake", #{ from: driven, from_point: [1.5, 0.4], to: "ground", to_point: [1.5, 1.5], coefficient: 0.1 });"#;

/// A study of a spring with a point that fails.
const STUDY: &str = r#"
let stiffness = param("stiffness", 1.0);
let label = param("label", "soft");
expect(stiffness < 3.0, "the spring is not too stiff");
result("period", 6.2831853 / sqrt(stiffness));
"#;

/// Place of axe-core.
fn axe() -> Option<String> {
    let given = std::env::var_os("AXE_CORE").map(PathBuf::from);
    let global = ["/usr/lib", "/usr/local/lib"].map(|place| Path::new(place).join("node_modules/axe-core/axe.min.js"));
    given.into_iter().chain(global).find_map(|path| fs::read_to_string(path).ok())
}

/// Script that finds cut or overlapping texts, and bodies outside of the frame.
const FAULTS: &str = r#"(async () => {
  const faults = [], shown = (e) => e.checkVisibility() && e.getClientRects().length > 0;
  const name = (e) => `${e.tagName.toLowerCase()}#${e.id}.${e.className.baseVal ?? e.className} "${e.textContent.trim().slice(0, 30)}"`;
  if (document.documentElement.scrollWidth > innerWidth) faults.push(`the page is ${document.documentElement.scrollWidth} wide`);
  const box = (e) => e.getBoundingClientRect(), by = 1;
  const covers = (a, b) => a.left < b.right - by && b.left < a.right - by && a.top < b.bottom - by && b.top < a.bottom - by;
  const apart = (elements, what) => elements.forEach((a, k) => elements.slice(k + 1).forEach((b) => {
    if (!a.contains(b) && !b.contains(a) && covers(box(a), box(b))) faults.push(`${what} overlap: ${name(a)} and ${name(b)}`);
  }));
  apart([...document.querySelectorAll("main > section, header, footer")].filter(shown), "sections");
  const inScroll = (e) => e.closest(".rows, .wide, pre, #tip");
  const parts = "canvas, .scale, button, select, input, output, nav a, h1, h2, h3, figcaption, .badge, .legend li, p";
  apart([...document.querySelectorAll(parts)].filter((e) => shown(e) && !inScroll(e)), "elements");
  for (const drawing of document.querySelectorAll("figure svg[role=img]")) {
    const frame = drawing.getBoundingClientRect(), texts = [...drawing.querySelectorAll("text")];
    apart(texts, "labels");
    for (const text of texts) {
      const at = text.getBoundingClientRect(), isIn = at.left > frame.left - 1 && at.right < frame.right + 1;
      if (!isIn || at.top < frame.top - 1 || at.bottom > frame.bottom + 1) faults.push(`cut: ${name(text)}`);
    }
  }
  for (const e of document.querySelectorAll("h1, h2, h3, p, dt, dd, li, button, output, figcaption, label, .marks span")) {
    const isCut = e.scrollWidth > e.clientWidth + 1 && getComputedStyle(e).display !== "inline";
    if (isCut && shown(e) && !inScroll(e)) faults.push(`cut: ${name(e)}`);
  }
  for (const scene of window.conserva?.sides?.map((side) => side.scene) ?? (window.conserva ? [conserva.scene] : [])) {
    for (let k = 0; k < scene.data.stills.length; k += 5) {
      scene.film.show(k);
      scene.project(1);
      const { width, height } = scene.canvas;
      const isOut = (x, i) => (i % 3 === 0 && !(x >= 0 && x <= width)) || (i % 3 === 1 && !(x >= 0 && x <= height));
      if (scene.places.some((p) => p.some(isOut))) faults.push(`a body leaves the frame in still ${k}`);
    }
  }
  return [...new Set(faults)].slice(0, 20);
})()"#;

fn looked_at(page: &mut Browser, path: &Path, axe: Option<&str>) {
    for width in [390, 1280, 1920] {
        for theme in ["light", "dark"] {
            page.call(
                "Emulation.setDeviceMetricsOverride",
                json!({ "width": width, "height": 900, "deviceScaleFactor": 1, "mobile": false }),
            );
            let features = json!([{ "name": "prefers-color-scheme", "value": theme }]);
            page.call("Emulation.setEmulatedMedia", json!({ "features": features }));
            let is_report = fs::read_to_string(path).unwrap().contains("id=\"data\"");
            if is_report {
                page.open(path);
                // With curves of nodes.
                page.evaluate("conserva.nodes && [0, 1].forEach((node) => conserva.nodes.add(0, node))");
                page.settle();
            } else {
                page.call("Page.navigate", json!({ "url": format!("file://{}", path.display()) }));
                page.wait_for("document.readyState === 'complete' && location.protocol === 'file:' && document.images.length >= 0");
                page.settle();
            }
            let what = format!("{} at {width}, {theme}", path.display());
            assert_eq!(page.evaluate(FAULTS), json!([]), "{what}");
            assert_eq!(page.complaints, Vec::<Value>::new(), "{what}");
            let dark = "(() => { const [r, g, b] = getComputedStyle(document.body).backgroundColor.match(/\\d+/g).map(Number); \
                        return r + g + b < 200; })()";
            assert_eq!(page.evaluate(dark), json!(theme == "dark"), "{what}");
            let Some(axe) = axe else { continue };
            page.evaluate(&format!("{axe}; true"));
            let run = "axe.run(document).then(({ violations }) => violations \
                       .filter(({ impact }) => ['serious', 'critical'].includes(impact)) \
                       .map(({ id, nodes }) => `${id}: ${nodes.map(({ target }) => target).slice(0, 3).join(' | ')}`))";
            assert_eq!(page.evaluate(run), json!([]), "{what}");
        }
    }
}

#[test]
fn pages_fit_every_screen_and_can_be_read_by_everyone() {
    let folder = folder("layout");
    let Some(mut page) = browser(&folder) else { return };
    let axe = axe();
    if axe.is_none() {
        eprintln!("SKIPPED: no axe-core on this machine, so accessibility was not checked");
    }
    let bearing = fs::read_to_string("scripts/scenarios/bearing.rhai").unwrap();
    let bearing = run(&folder, &bearing, "bearing").join("report.html");
    let size = fs::metadata(&bearing).unwrap().len();
    assert!(size <= 1_500_000, "the page of the bearing has {size} bytes");
    let space = run(&folder, IN_SPACE, "space").join("report.html");
    let machine = run(&folder, &MACHINE.replace("let sim", &format!("{BRAKE}\nlet sim")), "machine").join("report.html");
    fs::write(folder.join("study.rhai"), STUDY).unwrap();
    let study = folder.join("study");
    let swept = Command::new(env!("CARGO_BIN_EXE_conserva"))
        .args(["sweep", "study.rhai", "--quiet", "--vary", "stiffness=1,2,4", "--out"])
        .arg(&study)
        .current_dir(&folder)
        .output()
        .unwrap();
    assert!(matches!(swept.status.code(), Some(0 | 1)), "{}", String::from_utf8_lossy(&swept.stderr));
    let both = folder.join("both.html");
    let compared = Command::new(env!("CARGO_BIN_EXE_conserva"))
        .arg("report")
        .args([folder.join("bearing"), folder.join("machine")])
        .arg("--out")
        .arg(&both)
        .output()
        .unwrap();
    assert!(compared.status.success(), "{}", String::from_utf8_lossy(&compared.stderr));
    for path in [bearing, space, machine, study.join("study.html"), both] {
        looked_at(&mut page, &path, axe.as_deref());
    }
}
