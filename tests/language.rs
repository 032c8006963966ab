//! The language as a library: modules, closures, states, parameters, and the output of `check`.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::atomic::{AtomicUsize, Ordering};

use conserva::script::{Class, Diagnostic, Ink, Mode, Observer, Progress, Report, Session, Settings};

#[derive(Default)]
struct Recorder {
    lines: RefCell<Vec<String>>,
    warnings: RefCell<Vec<String>>,
}

impl Observer for Recorder {
    fn print(&self, line: &str) {
        self.lines.borrow_mut().push(line.into());
    }
    fn passed(&self, _: &str) {}
    fn warn(&self, warning: &Diagnostic) {
        self.warnings.borrow_mut().push(warning.title.clone());
    }
    fn advanced(&self, _: &Progress) {}
    fn began(&self, _: &str) {}
    fn ended(&self) {}
}

/// New folder for a test.
fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("language-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Runs a script with settings in a folder; returns printed lines, warnings, and the report.
fn run_in(folder: &Path, text: &str, settings: Settings) -> (Vec<String>, Vec<String>, Report) {
    let script = folder.join("main.rhai");
    std::fs::write(&script, text).unwrap();
    let recorder = Rc::new(Recorder::default());
    let mut session = Session::new(settings, folder, recorder.clone()).unwrap();
    let report = session.run_file(&script);
    drop(session);
    (recorder.lines.take(), recorder.warnings.take(), report)
}

/// Runs a script that must not fail; returns printed lines.
fn run(name: &str, text: &str) -> Vec<String> {
    let (lines, _, report) = run_in(&folder(name), text, Settings::default());
    assert!(report.error.is_none(), "{}", report.error.unwrap().render(Ink::Plain));
    lines
}

const FLIGHT: &str = r#"
    let rubber = neo_hookean(#{ youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 });
    let flight = model("flight");
    let plate = flight.add_body("plate", rectangle(#{ size: [2.0, 1.0], cells: [4, 2] }), rubber);
    flight.initial_velocity(plate, #{ linear: [1.0, 0.0], angular: 2.0 });
"#;

fn flight(rest: &str) -> String {
    format!("{FLIGHT}let sim = simulate(flight, #{{ integrator: energy_momentum(), dt: 0.01 }});\n{rest}")
}

#[test]
fn every_object_prints_something_useful() {
    let lines = run(
        "print",
        &flight(
            r#"
            sim.step();
            print(rubber); print(flight); print(plate); print(plate.mesh); print(plate.boundary("top")); print(hat(0, 1, 2));
            print(energy_momentum()); print(mortar()); print(sim); print(sim.save()); print(sim.history);
            print(`${plate}`); print([hat(0, 1, 2)]);
            "#,
        ),
    );
    let beginnings = [
        "neo_hookean(#{ youngs_modulus: 100,",
        "model \"flight\"",
        "body \"plate\"",
        "mesh of 8 quad4 cells and 15 nodes",
        "boundary \"plate.top\" of 4 facets and length 2",
        "hat(0, 1, 2)",
        "energy_momentum()",
        "mortar()",
        "simulation \"flight\" at t = 0.01, step 1",
        "state of simulation",
        "history of 2 rows",
        "body \"plate\"",
        "[hat(0, 1, 2)]",
    ];
    assert_eq!(lines.len(), beginnings.len());
    for (line, beginning) in lines.iter().zip(beginnings) {
        assert!(line.starts_with(beginning), "{line}");
    }
}

#[test]
fn going_back_and_forward_again_gives_the_same_bytes() {
    let home = folder("branches");
    let text = flight(
        "sim.run_to(0.05); let here = sim.save(); sim.run_to(0.1); let first = sim.energy.strain; let rows = sim.history.total;\n\
         sim.restore(here); expect(sim.time == 0.05); expect(sim.history.time.len() == 6);\n\
         sim.run_to(0.1); expect(sim.energy.strain == first); expect(sim.history.total == rows);",
    );
    let (_, _, report) = run_in(&home, &text, Settings { output: Some(home.join("out")), ..Settings::default() });
    assert!(report.error.is_none(), "{}", report.error.unwrap().render(Ink::Plain));
    let csv = std::fs::read_to_string(home.join("out/history.csv")).unwrap();
    assert_eq!(csv.lines().count(), 12, "header, beginning and 10 steps:\n{csv}");
}

#[test]
fn closures_made_in_a_module_work_when_the_solver_calls_them() {
    let home = folder("modules");
    std::fs::create_dir(home.join("lib")).unwrap();
    std::fs::write(
        home.join("lib/loads.rhai"),
        "import \"lib/shapes\" as shapes;\nconst STRENGTH = 3.0;\nfn half(x) { 0.5 * x }\n\
         fn push(factor) { |t| factor * half(global::STRENGTH) * shapes::rise(t) }",
    )
    .unwrap();
    std::fs::write(home.join("lib/shapes.rhai"), "fn rise(t) { if t < 0.5 { 2.0 * t } else { 1.0 } }").unwrap();
    let text = "import \"lib/loads\" as loads;\n".to_string()
        + FLIGHT
        + "flight.force(plate.boundary(\"right\"), [1.0, 0.0], loads::push(2.0));\n\
           let sim = simulate(flight, #{ integrator: energy_momentum(), dt: 0.01 });\n\
           let before = sim.momentum[0]; sim.run_to(0.2);\n\
           // the integral of 2 * 1.5 * 2 t from 0 to 0.2; the midpoint rule is exact for a linear function\n\
           expect_close(sim.momentum[0] - before, 0.12, #{ relative: 1e-10 });";
    let (_, _, report) = run_in(&home, &text, Settings::default());
    assert!(report.error.is_none(), "{}", report.error.unwrap().render(Ink::Plain));
}

#[test]
fn on_step_sees_every_step_and_may_collect() {
    let lines = run(
        "on_step",
        &flight("let times = []; sim.on_step(|s| times.push(s.time)); sim.run_to(0.03); print(times.len()); print(times[-1] == sim.time);"),
    );
    assert_eq!(lines, ["3", "true"]);
}

#[test]
fn parameters_come_from_outside() {
    let home = folder("parameters");
    let set = |name: &str, value: &str| Settings { overrides: vec![(name.into(), value.into())], ..Settings::default() };
    let text = "let n = param(\"n\", 2); let name = param(\"name\", \"a\"); print(n * 1.5); print(name);";
    assert_eq!(run_in(&home, text, Settings::default()).0, ["3.0", "a"]);
    assert_eq!(run_in(&home, text, set("n", "4")).0, ["6.0", "a"]);
    assert_eq!(run_in(&home, text, set("name", "a b")).0, ["3.0", "a b"]);
    // An unknown name is refused before a long computation.
    let late = flight("print(\"never\"); let dt = param(\"dt\", 1.0);").replace("let sim", "param(\"known\", 1); let sim");
    let (lines, _, report) = run_in(&home, &late, set("unknown", "1"));
    assert!(lines.is_empty());
    assert!(report.error.unwrap().title.contains("unknown"));
}

#[test]
fn a_parameter_may_be_asked_for_after_the_simulation() {
    let home = folder("late-parameter");
    let run = |text: &str| run_in(&home, text, Settings { overrides: vec![("late".into(), "1".into())], ..Settings::default() });
    let (lines, _, report) = run(&flight("print(param(\"late\", 2));"));
    assert!(report.error.is_none() && lines == ["1"], "{lines:?}");
    // The name is computed at run time, or the call is in a module that is imported later.
    let (lines, _, report) = run(&flight("let name = \"la\" + \"te\"; print(param(name, 2));"));
    assert!(report.error.is_none() && lines == ["1"], "{lines:?}");
    std::fs::write(home.join("asks.rhai"), "fn late() { param(\"late\", 2) }").unwrap();
    let (lines, _, report) = run(&flight("import \"asks\" as asks; print(asks::late());"));
    assert!(report.error.is_none() && lines == ["1"], "{lines:?}");
    // A call that is not reached still counts as a place of the parameter; `check` stops earlier and does not report it.
    let text = flight("if sim.time > 9.0 { param(\"late\", 2); }");
    let error = run(&text).2.error.unwrap();
    assert!(error.title.contains("ended before the script asked for `late`") && error.place.is_some(), "{}", error.title);
    let check = Settings { mode: Mode::Check, overrides: vec![("late".into(), "1".into())], ..Settings::default() };
    assert!(run_in(&home, &text, check).2.error.is_none());
}

#[test]
fn check_lists_everything_and_takes_no_step() {
    let home = folder("check");
    let settings = || Settings { mode: Mode::Check, output: Some(home.join("out")), ..Settings::default() };
    let text = flight("sim.settle(); sim.run_to(1e9); expect_conserved(sim, \"energy\", #{ tolerance: 1e-9 });");
    let (_, _, report) = run_in(&home, &text, settings());
    assert!(report.error.is_none());
    let findings = report.findings.join("\n");
    for part in ["simulation \"flight\": energy_momentum, dt = 0.01, 30 unknowns", "body \"plate\"", "drifts by at most 1e-9"] {
        assert!(findings.contains(part), "{findings}");
    }
    assert!(!home.join("out").exists());

    let text = flight("sim.run_to(1.0); if sim.energy.total > 0.0 { nonsense(); }");
    let (_, _, report) = run_in(&home, &text, settings());
    assert!(report.error.is_none());
    assert!(report.findings.last().unwrap().contains("the script uses `energy`"), "{:?}", report.findings);

    // The result of `settle` counts as a result, too.
    let text = flight("let settled = sim.settle();\nprint(settled.strain);\nnonsense();");
    let (_, _, report) = run_in(&home, &text, settings());
    assert!(report.error.is_none(), "{:?}", report.error);
    let last = report.findings.last().unwrap();
    assert!(last.contains("the script uses `strain`"), "{:?}", report.findings);
    assert!(last.contains(".rhai:"), "a place: {last}");

    let text = flight("sim.run_to(1.0); nonsense();");
    assert_eq!(run_in(&home, &text, settings()).2.error.unwrap().class, Class::Script);
}

#[test]
fn errors_can_be_caught_and_looked_at() {
    let lines = run(
        "caught",
        "try { ring(#{ inner_radius: -1, outer_radius: 1, cells: [1, 8] }); } catch (error) { print(error); print(type_of(error)); }",
    );
    assert!(lines[0].starts_with("`inner_radius` of `ring` must be greater than 0"), "{lines:?}");
    assert_eq!(lines[1], "Error");
}

#[test]
fn an_interrupt_cannot_be_caught() {
    let home = folder("interrupt");
    let settings = Settings::default();
    let interrupt = settings.interrupt.clone();
    interrupt.store(true, std::sync::atomic::Ordering::Relaxed);
    let (lines, _, report) = run_in(&home, "try { loop { } } catch { print(\"caught\"); }", settings);
    assert!(lines.is_empty());
    assert_eq!(report.error.unwrap().class, Class::Interrupted);
}

#[test]
fn boundaries_found_by_a_condition_work_on_meshes_and_bodies() {
    let lines = run(
        "where",
        r#"
        let steel = neo_hookean(#{ youngs_modulus: 1.0, poisson_ratio: 0.3, density: 1.0 });
        let mesh = rectangle(#{ size: [2.0, 1.0], cells: [4, 2] });
        mesh.boundary_where("corner", |x, y| x < 0.51 && y < 0.01);
        let m = model("m");
        let body = m.add_body("b", mesh, steel);
        print(body.boundary("corner").facets);
        let side = body.boundary_where("side", |x, y| x > 1.99);
        m.fix(side, "x");
        print(body.boundary("side").measure);
        let solid = block(#{ size: [1.0, 1.0, 1.0], cells: [2, 2, 2] });
        print(solid.boundary_where("lid", |x, y, z| z > 0.99).boundary("lid").facets);
        "#,
    );
    assert_eq!(lines, ["1", "1.0", "4"]);
}

#[test]
fn warnings_name_what_never_happened() {
    let home = folder("idle");
    let text = flight("sim.step(2);").replace("let sim", "flight.force(plate.boundary(\"top\"), [1, 0], ramp(5, 6, 1)); let sim");
    let warnings = run_in(&home, &text, Settings::default()).1;
    assert_eq!(warnings, ["the force [1, 0] on \"plate.top\" with amplitude ramp(5, 6, 1) never acted"]);
}

#[test]
fn several_simulations_have_folders_of_their_own() {
    let home = folder("several");
    let text = flight("sim.step(2); let again = simulate(flight, #{ integrator: midpoint(), dt: 0.02 }); again.step();");
    let (_, _, report) = run_in(&home, &text, Settings { output: Some(home.join("out")), ..Settings::default() });
    assert!(report.error.is_none());
    for (file, rows) in [("out/history.csv", 4), ("out/flight-2/history.csv", 3)] {
        assert_eq!(std::fs::read_to_string(home.join(file)).unwrap().lines().count(), rows, "{file}");
    }
    for file in ["summary.json", "history.svg", "fields.pvd", "flight-2/summary.json"] {
        assert!(home.join("out").join(file).is_file(), "{file}");
    }
}

#[test]
fn frames_come_at_the_interval_that_the_script_chooses() {
    let home = folder("frames");
    let text = flight("sim.run_to(0.1);").replace("dt: 0.01", "dt: 0.01, fields_every: 0.03");
    let (_, _, report) = run_in(&home, &text, Settings { output: Some(home.join("out")), ..Settings::default() });
    assert!(report.error.is_none());
    let list = std::fs::read_to_string(home.join("out/fields.pvd")).unwrap();
    let times: Vec<f64> = list.split("timestep=\"").skip(1).map(|rest| rest.split('"').next().unwrap().parse().unwrap()).collect();
    // beginning, every 0.03, end
    assert_eq!(times.len(), 5, "{times:?}");
    for (time, expected) in times.iter().zip([0.0, 0.03, 0.06, 0.09, 0.1]) {
        assert!((time - expected).abs() < 1e-12, "{times:?}");
    }
}

#[test]
fn scripts_are_reproducible_to_the_last_bit() {
    let text = flight("sim.run_to(0.1); print(sim.history.total); print(sim.energy);");
    assert_eq!(run("first", &text), run("second", &text));
}

/// Scenarios that run longest, with parameters that shorten them where their checks allow it; they begin first, so that both threads end at
/// about the same time. `cargo example gallery` runs them as they are.
const LONGEST: [(&str, &[(&str, &str)]); 17] = [
    ("lees_frame", &[]),
    ("gears", &[("dt", "0.02")]),
    ("snap_fit", &[("steps", "60")]),
    ("roller", &[("dt", "0.04")]),
    ("screw_and_nut", &[("dt", "0.02")]),
    ("roller_bearing", &[("turns", "0.1")]),
    ("wheel_over_kerb", &[("rest", "1.5")]),
    ("pile", &[("rows", "2")]),
    ("crossing_tubes", &[("around", "8"), ("dt", "0.01")]),
    ("geneva_drive", &[("turns", "2"), ("size", "0.1")]),
    ("ball_in_bowl", &[("until", "1.0")]),
    ("bearing_integrators", &[("until", "1.0")]),
    ("driven_bearing", &[("turns", "0.25"), ("dt", "0.004")]),
    ("bouncing_ring", &[("bounces", "8")]),
    ("wedge", &[("cells", "8")]),
    ("hertz_ball", &[("cells", "4")]),
    ("o_ring", &[("layers", "8")]),
];

#[test]
fn the_shipped_scenarios_hold_their_checks() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/scenarios");
    let entries = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
    let mut scripts: Vec<_> = entries.filter(|path| path.extension().is_some_and(|extension| extension == "rhai")).collect();
    let rank = |path: &Path| LONGEST.iter().position(|(name, _)| path.file_stem().is_some_and(|stem| stem == *name));
    scripts.sort_by_key(|path| (rank(path).unwrap_or(LONGEST.len()), path.clone()));
    // A session stays on its thread.
    let next = AtomicUsize::new(0);
    let worker = || {
        let mut checks = 0;
        while let Some(script) = scripts.get(next.fetch_add(1, Ordering::Relaxed)) {
            let shorter = rank(script).map_or(&[][..], |k| LONGEST[k].1);
            let overrides = shorter.iter().map(|&(name, value)| (name.into(), value.into())).collect();
            let settings = Settings { overrides, ..Settings::default() };
            let mut session = Session::new(settings, &folder, Rc::new(Recorder::default())).unwrap();
            let report = session.run_file(script);
            assert!(report.error.is_none(), "{}", report.error.unwrap().render(Ink::Plain));
            assert!(report.checks > 0, "{} checks something", script.display());
            checks += report.checks;
        }
        checks
    };
    let checks: usize = std::thread::scope(|scope| {
        let workers = [scope.spawn(worker), scope.spawn(worker)];
        workers.into_iter().map(|worker| worker.join().unwrap()).sum()
    });
    assert!(checks >= 15);
}

#[test]
fn a_loop_of_pushes_takes_time_as_it_has_pushes_and_keeps_the_limits() {
    let begun = std::time::Instant::now();
    run(
        "pushes",
        "fn filled() { let l = []; for i in 0..400000 { l.push(`entry`); } l } let l = filled(); for i in 0..400000 { l.push(i); }",
    );
    // Measuring all values after every push would take minutes.
    assert!(begun.elapsed().as_secs() < 10, "{:?}", begun.elapsed());
    for bomb in [
        "let big = []; big.pad(100000, 1); let l = []; loop { l.push(big); }",
        "let a = []; let b = []; let big = []; big.pad(100000, 1); loop { a.push(1); b.push(big); a.push(2); }",
        "let m = #{ l: [] }; let text = \"conserva\"; for i in 0..15 { text += text; } loop { m.l.push(text); }",
    ] {
        let (_, _, report) = run_in(&folder("push-bombs"), bomb, Settings::default());
        assert!(report.error.is_some_and(|error| error.title.contains("too large")), "{bomb}");
    }
}

/// Points that print, warn, check, fail and run simulations, in parallel and nested.
const STUDY: &str = r#"
fn flight(speed) {
    let rubber = neo_hookean(#{ youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 });
    let sky = model("sky");
    let plate = sky.add_body("plate", rectangle(#{ size: [2.0, 1.0], cells: [2, 1] }), rubber);
    sky.initial_velocity(plate, #{ angular: speed });
    sky.gravity([0.0, -1.0]);
    let sim = simulate(sky, #{ integrator: energy_momentum(), dt: 0.01 });
    sim.on_step(|sim| if sim.history.step[-1] == 3 { print(`${sim}`); });
    sim.run_to(0.1);
    sim
}
let one = flight(1.0);
let rows = sweep(#{ vary: #{ x: 0..12 }, run: |p| {
    print(`begin ${p.x} ${param("p", 1.5)}`);
    let sim = flight(0.5 * p.x);
    expect(p.x != 4);
    while p.x == 7 { }
    if p.x == 9 { let s = 1/2; throw s; }
    #{ energy: sim.energy.total, time: sim.history.time, inner: sweep(#{ vary: #{ y: 0..2 }, run: |q| q.y * 0.1 }).len() }
} });
print(rows);
expect_order(|dt| { let sim = flight(1.0 + dt); sim.energy.total }, 1.0, #{ dt: 0.1, tolerance: 1.0 });
let found = minimize(|p| {
    let sim = flight(p.speed);
    if p.speed > 2.7 { throw "fast"; }
    (sim.energy.kinetic - 1.0) ** 2.0
}, #{ bounds: #{ speed: [0.5, 3.0] } });
print(found);
"#;

#[test]
fn studies_give_the_same_bytes_on_any_number_of_threads() {
    let study = |workers: usize| {
        let home = folder(&format!("workers-{workers}"));
        let output = home.join("out");
        let settings = Settings {
            workers,
            max_operations: 200_000,
            output: Some(output.clone()),
            overrides: vec![("p".into(), "2.5".into())],
            ..Settings::default()
        };
        let (lines, warnings, report) = run_in(&home, STUDY, settings);
        assert!(report.error.is_none(), "{}", report.error.unwrap().render(Ink::Plain));
        let table = |name: &str| std::fs::read_to_string(output.join("studies").join(name)).unwrap();
        (lines, warnings, report.checks, table("sweep.csv"), table("minimize.csv"))
    };
    let one = study(1);
    assert_eq!(one.0.iter().filter(|line| line.starts_with("begin")).count(), 12);
    assert_eq!(one.0[1], "begin 0 2.5", "{:?}", &one.0[..5]);
    assert_eq!(one.1.iter().filter(|title| title.contains("points of `sweep` failed")).count(), 1, "{:?}", one.1);
    assert!(one.3.lines().nth(8).unwrap().contains("too many operations") || one.3.contains("operations"), "{}", one.3);
    assert_eq!(one.3.lines().count(), 13);
    for workers in [2, 5] {
        assert_eq!(study(workers), one, "{workers} threads");
    }
}

#[test]
fn an_interrupt_ends_a_study_at_once() {
    for (text, workers) in [
        ("sweep(#{ vary: #{ x: 0..100 }, run: |p| { loop { } } });", 4),
        ("let m = rectangle(#{ size: [1.0, 1.0], cells: [1, 1] }); sweep(#{ vary: #{ x: 0..9 }, run: |p| { loop { m.nodes; } } });", 1),
        ("minimize(|p| { loop { } }, #{ bounds: #{ x: [0.0, 1.0] } });", 2),
        ("expect_order(|dt| { loop { } }, 1.0, #{ dt: 0.1 });", 2),
    ] {
        let interrupt: std::sync::Arc<std::sync::atomic::AtomicBool> = std::sync::Arc::default();
        let settings = Settings { workers, interrupt: interrupt.clone(), ..Settings::default() };
        let later = std::thread::spawn(move || {
            std::thread::sleep(std::time::Duration::from_millis(200));
            interrupt.store(true, std::sync::atomic::Ordering::Relaxed);
            std::time::Instant::now()
        });
        let (_, _, report) = run_in(&folder("study-interrupted"), text, settings);
        let begun = later.join().unwrap();
        assert!(begun.elapsed().as_millis() < 1000, "{text}: {:?}", begun.elapsed());
        assert_eq!(report.error.unwrap().class, Class::Interrupted, "{text}");
    }
}

#[test]
fn a_module_may_study_while_it_loads() {
    let home = folder("study-module");
    let module = "const SQUARES = sweep(#{ vary: #{ x: 0..4 }, run: |p| square(p.x) }).map(|row| row.value);\n\
                  fn square(x) { x * x }\nfn squares() { global::SQUARES }";
    std::fs::write(home.join("squares.rhai"), module).unwrap();
    let text =
        "import \"squares\" as squares;\nprint(sweep(#{ vary: #{ x: [2, 3] }, run: |p| squares::squares()[p.x] }).map(|row| row.value));";
    let (lines, _, report) = run_in(&home, text, Settings::default());
    assert!(report.error.is_none(), "{}", report.error.unwrap().render(Ink::Plain));
    assert_eq!(lines, ["[4, 9]"]);
}

#[test]
fn a_study_is_listed_by_check_and_computes_nothing() {
    let settings = Settings { mode: Mode::Check, ..Settings::default() };
    let (lines, _, report) =
        run_in(&folder("study-check"), "let r = sweep(#{ vary: #{ x: 0..5 }, run: |p| { print(p.x); p.x } });", settings);
    assert!(report.error.is_none() && lines.is_empty());
    assert_eq!(report.findings[0], "would compute 5 points of `x`");
    assert!(report.findings[1].contains("the script uses what `sweep` gives"), "{:?}", report.findings);
}
