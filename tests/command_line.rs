//! The program as a process: exit codes, files, messages, interrupts, closed pipes, sudden termination.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

#[path = "common/program.rs"]
mod program;

use program::{conserva, folder, stderr, stdout};

fn run(folder: &Path, arguments: &[&str]) -> Output {
    conserva(folder, arguments).output().unwrap()
}

/// A free plate; `rest` is appended.
fn flight(rest: &str) -> String {
    format!(
        "let dt = param(\"dt\", 0.01);\n\
         let rubber = neo_hookean(#{{ youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 }});\n\
         let flight = model(\"flight\");\n\
         let plate = flight.add_body(\"plate\", rectangle(#{{ size: [2.0, 1.0], cells: [4, 2] }}), rubber);\n\
         flight.initial_velocity(plate, #{{ linear: [1.0, 0.0], angular: 2.0 }});\n\
         let sim = simulate(flight, #{{ integrator: energy_momentum(), dt: dt }});\n{rest}\n"
    )
}

/// Number of complete rows of a history after its header.
fn rows(folder: &Path) -> usize {
    let text = std::fs::read_to_string(folder.join("out/main/history.csv")).unwrap();
    let mut lines = text.lines();
    let columns = lines.next().unwrap().split(',').count();
    assert!(columns >= 19);
    // Values that are unknown before the first step are empty.
    let is_number = |row: usize, field: &str| field.parse::<f64>().is_ok() || row == 0 && field.is_empty();
    lines
        .enumerate()
        .inspect(|(row, line)| assert!(line.split(',').filter(|field| is_number(*row, field)).count() == columns, "{line}"))
        .count()
}

fn outcome(folder: &Path) -> String {
    let text = std::fs::read_to_string(folder.join("out/main/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
    summary["outcome"].as_str().unwrap().to_string()
}

/// Waits until the run has written some rows.
fn wait_for_rows(folder: &Path, child: &mut Child) {
    let begun = Instant::now();
    let file = folder.join("out/main/history.csv");
    while std::fs::read_to_string(&file).map_or(0, |text| text.lines().count()) < 10 {
        assert!(begun.elapsed() < Duration::from_secs(60), "the run writes no rows");
        assert!(child.try_wait().unwrap().is_none(), "the run ended early");
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn signal(child: &Child, name: &str) {
    assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
}

#[test]
fn a_run_writes_its_files_and_says_so() {
    let home =
        folder("done", &flight("sim.run_to(0.1); print(`t = ${sim.time}`); expect_conserved(sim, \"energy\", #{ tolerance: 1e-10 });"));
    let output = run(&home, &["run", "main.rhai", "--set", "dt=0.02"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let said = stdout(&output);
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(lines[0], "t = 0.1");
    assert!(lines[1].starts_with("ok  the energy of \"flight\" after t = 0 drifts by") && lines[1].ends_with("[main.rhai:7]"), "{said}");
    assert_eq!(stderr(&output), "done, 1 check passed; results in out/main\n");
    assert_eq!(rows(&home), 6);
    let text = std::fs::read_to_string(home.join("out/main/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(summary["script"], "main.rhai");
    assert_eq!(summary["parameters"]["dt"], 0.02);
    assert_eq!((&summary["bodies"], &summary["unknowns"], &summary["steps"]), (&1.into(), &30.into(), &5.into()));
    assert_eq!(summary["outcome"], "completed");
    assert!(summary["energy_drift"].as_f64().unwrap() < 1e-10);
    let seconds = summary["wall_seconds"].as_object().unwrap();
    let parts: f64 = seconds.iter().filter(|(name, _)| *name != "total").map(|(_, value)| value.as_f64().unwrap()).sum();
    let total = seconds["total"].as_f64().unwrap();
    // The parts cover the total time; `other` is the remainder, so they exceed the total only by time that is measured twice.
    assert!(parts <= 1.01 * total && parts >= 0.99 * total, "{text}");
    for file in ["history.svg", "fields.pvd", "fields/fields_000000.vtu", "fields/fields_000001.vtu"] {
        assert!(home.join("out/main").join(file).is_file(), "{file}");
    }
}

/// A plate that falls on a moving plane, drawn in both formats.
#[test]
fn obstacles_and_pictures_are_written() {
    let script = flight(
        "let press = model(\"press\");\n\
         let block = press.add_body(\"block\", rectangle(#{ size: [1.0, 1.0], cells: [2, 2] }), rubber);\n\
         let lift = rigid_plane(#{ point: [0.0, -0.1], normal: [0.0, 1.0], motion: #{ y: ramp(0.0, 0.05, 0.05) } });\n\
         press.add_contact(\"lift\", #{ secondary: block.boundary(\"bottom\"), primary: lift });\n\
         let sim = simulate(press, #{ integrator: energy_momentum(), dt: 0.01, fields_every: 0.01 });\n\
         sim.run_to(0.05); sim.picture(\"block.svg\");\n\
         sim.picture(\"block.png\", #{ vectors: \"velocity\" }); sim.write_fields(\"now.vtu\");\n\
         plot_curves(\"both.png\", [#{ of: sim, y: \"total\" }, #{ x: [0.0, 1.0], y: [1.0, 2.0] }]);",
    );
    let home = folder("obstacles", &script);
    let output = run(&home, &["run", "main.rhai", "--quiet"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let read = |file: &str| std::fs::read(home.join("out/main").join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
    let text = |file: &str| String::from_utf8_lossy(&read(file)).into_owned();
    assert!(read("press/block.png").starts_with(b"\x89PNG") && read("both.png").starts_with(b"\x89PNG"));
    assert!(text("press/block.svg").contains("<title>lift</title>"));
    assert!(text("press/now_obstacles.vtu").contains("obstacle 0: lift"));
    // The obstacle moves: no two frames are the same.
    assert_eq!(text("press/obstacles.pvd").matches("<DataSet").count(), 6);
    let frame = |number: usize| read(&format!("press/obstacles/obstacles_{number:06}.vtu"));
    assert_ne!(frame(0).split_at(frame(0).len() / 2).1, frame(5).split_at(frame(5).len() / 2).1);
    // A simulation without obstacles has no such files.
    assert!(!home.join("out/main/obstacles.pvd").exists());
}

#[test]
fn results_go_where_out_says_and_quiet_is_quiet() {
    let home = folder("out", &flight("sim.step(); sim.plot(\"plots/energy.svg\", [\"kinetic\", \"strain\"]); sim.picture(\"plate.svg\");"));
    let output = run(&home, &["run", "main.rhai", "--out", "results", "--quiet", "--threads", "2"]);
    assert_eq!((output.status.code(), stdout(&output), stderr(&output)), (Some(0), String::new(), String::new()));
    assert!(home.join("results/plots/energy.svg").is_file() && home.join("results/plate.svg").is_file());
    assert!(!home.join("out").exists());
}

#[test]
fn exit_codes_tell_how_it_went() {
    let code = |name: &str, script: &str, arguments: &[&str]| {
        let home = folder(name, script);
        let output = run(&home, arguments);
        (output.status.code().unwrap(), stderr(&output))
    };
    let (exit, message) = code("check-fails", &flight("sim.step(); expect(sim.time > 1.0, \"too early\");"), &["run", "main.rhai"]);
    assert_eq!(exit, 1);
    assert!(message.contains("error[C1031]: too early\n --> main.rhai:7:20\n"), "{message}");
    let (exit, message) = code("script-wrong", "let a = ringg();", &["run", "main.rhai"]);
    assert_eq!(exit, 2);
    assert!(message.contains("did you mean `ring`"), "{message}");
    let (exit, message) = code("no-script", "", &["run", "man.rhai"]);
    assert_eq!(exit, 2);
    assert!(message.contains("the script man.rhai cannot be read"), "{message}");
    let (exit, message) = code("bad-argument", "", &["run", "main.rhai", "--set", "dt"]);
    assert_eq!(exit, 2);
    assert!(message.contains("NAME=VALUE"), "{message}");
    let (exit, message) = code("bad-folder", "", &["run", "main.rhai", "--allow-read", "nowhere"]);
    assert_eq!(exit, 2);
    assert!(message.contains("the folder nowhere cannot be opened"), "{message}");
    let (exit, message) = code("bad-set", "let a = param(\"a\", 1);", &["run", "main.rhai", "--set", "b=1"]);
    assert_eq!(exit, 2);
    assert!(message.contains("the script has no parameter `b`"), "{message}");
    // A load that no step of this size can follow.
    let wild = flight("").replace("let sim", "flight.force(plate.boundary(\"top\"), [1e9, 0.0]); let sim");
    let wild = wild.replace("dt: dt", "dt: dt, max_halvings: 0") + "sim.step();";
    let (exit, message) = code("numerics", &wild, &["run", "main.rhai"]);
    assert_eq!(exit, 3, "{message}");
    assert!(message.contains("error[C0504]: Newton's method did not converge"), "{message}");
}

#[test]
fn a_failed_run_keeps_its_results() {
    let home = folder("failed", &flight("sim.run_to(0.05); nonsense();"));
    let output = run(&home, &["run", "main.rhai"]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(rows(&home), 6);
    assert_eq!(outcome(&home), "there is no function `nonsense`");
}

#[test]
fn the_first_interrupt_ends_the_run_with_its_results() {
    let home = folder("interrupt", &flight("try { sim.run_to(1e6); } catch { print(\"caught\"); }"));
    let mut child = conserva(&home, &["run", "main.rhai"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    wait_for_rows(&home, &mut child);
    signal(&child, "-INT");
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
    assert!(stdout(&output).is_empty(), "an interrupt cannot be caught");
    assert!(stderr(&output).contains("error[C0508]: interrupted at t ="), "{}", stderr(&output));
    assert!(rows(&home) >= 9);
    assert_eq!(outcome(&home), "interrupted");
    assert!(home.join("out/main/history.svg").is_file());
}

#[test]
fn interrupts_in_a_moment_are_one() {
    // `timeout -s INT` signals the process, and then its group.
    let home = folder("interrupt-twice", &flight("sim.run_to(1e6);"));
    let mut child = conserva(&home, &["run", "main.rhai"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    wait_for_rows(&home, &mut child);
    (0..3).for_each(|_| signal(&child, "-INT"));
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
    assert!(stderr(&output).contains("go on with `conserva resume out/main`"), "{}", stderr(&output));
    assert_eq!(outcome(&home), "interrupted");
}

#[test]
fn an_interrupt_ends_a_long_step_of_a_large_model_at_once() {
    // 40 000 unknowns under a load that no step of this size can follow: halvings take many seconds, each iteration with its assembly and
    // factorization. The first step, with a very small load, determines the elimination order.
    let script = "let rubber = neo_hookean(#{ youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 });\n\
                  let press = model(\"press\");\n\
                  let block = press.add_body(\"block\", rectangle(#{ size: [2.0, 1.0], cells: [200, 100] }), rubber);\n\
                  press.fix(block.boundary(\"bottom\"));\n\
                  press.traction(block.boundary(\"top\"), [30.0, -60.0], |t| if t > 0.1 { 1.0 } else { 1e-6 });\n\
                  let sim = simulate(press, #{ integrator: energy_momentum(), dt: 0.1 });\n\
                  sim.step();\n\
                  print(\"stepping\");\n\
                  sim.step();\n";
    let home = folder("interrupt-step", script);
    let mut child = conserva(&home, &["run", "main.rhai"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
    assert_eq!(line, "stepping\n");
    // The step does not end before the signal arrives.
    std::thread::sleep(Duration::from_millis(300));
    signal(&child, "-INT");
    let asked = Instant::now();
    let output = child.wait_with_output().unwrap();
    let waited = asked.elapsed();
    assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
    // Without the interrupt the step takes tens of seconds in a debug build and several in a release build; with it 0.3 s on a machine with
    // twice as many busy processes as processors.
    assert!(waited < Duration::from_secs(2), "the run ended only after {waited:?}");
    let message = stderr(&output);
    assert!(message.contains("error[C0508]: interrupted at t = 0.1\n --> main.rhai:9:5\n"), "{message}");
    assert!(message.contains("everything up to this time is kept"), "{message}");
    assert_eq!((rows(&home), outcome(&home)), (2, "interrupted".into()));
}

#[test]
fn a_run_that_does_not_conserve_says_so_at_its_end() {
    let run = |name: &str, integrator: &str| {
        let home = folder(name, &flight("sim.run_to(0.5);").replace("energy_momentum()", integrator));
        let output = conserva(&home, &["run", "main.rhai"]).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        (stderr(&output), outcome(&home))
    };
    let (told, outcome) = run("conserving", "energy_momentum()");
    assert!(told.contains("done; results in") && !told.contains("energy:") && outcome == "completed", "{told}");
    let (told, outcome) = run("not-conserving", "backward_euler()");
    assert!(told.contains("energy: the integrator took") && told.contains("ended, not conserving; results in"), "{told}");
    assert_eq!(outcome, "not conserving");
}

#[test]
fn an_interrupt_ends_a_script_that_only_loops() {
    let home = folder("interrupt-loop", "print(\"looping\"); loop { }");
    let mut child = conserva(&home, &["run", "main.rhai", "--max-operations", "1000000000000"]).stdout(Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
    assert_eq!(line, "looping\n");
    signal(&child, "-INT");
    assert_eq!(child.wait().unwrap().code(), Some(130));
}

/// A flight with a frame of the fields at every step.
fn filmed(rest: &str) -> String {
    flight(rest).replace("dt: dt }", "dt: dt, fields_every: dt }")
}

/// Number of frames in the list of fields, all of which exist.
fn frames(folder: &Path) -> usize {
    let list = std::fs::read_to_string(folder.join("out/main/fields.pvd")).unwrap();
    let files = list.lines().filter_map(|line| line.split("file=\"").nth(1)?.split('"').next());
    files.inspect(|file| assert!(folder.join("out/main").join(file).is_file(), "{file}")).count()
}

#[test]
fn every_way_out_keeps_the_frames_up_to_the_last_step() {
    // Errors thrown in a closure after a step, in the script, and between single steps.
    let ways = [
        ("thrown", "sim.on_step(|sim| if sim.steps == 30 { throw \"enough\"; }); sim.run_to(1.0);", 2),
        ("nonsense", "sim.run_to(0.3); nonsense();", 2),
        ("checked", "for i in 0..30 { sim.step(); } expect(sim.time > 1.0, \"too early\");", 1),
        ("steps", "for i in 0..30 { sim.step(); }", 0),
    ];
    for (name, rest, exit) in ways {
        let home = folder(&format!("frames-{name}"), &filmed(rest));
        let output = run(&home, &["run", "main.rhai"]);
        assert_eq!(output.status.code(), Some(exit), "{name}: {}", stderr(&output));
        assert_eq!((rows(&home), frames(&home)), (31, 31), "{name}");
    }
    let home = folder("frames-interrupted", &filmed("sim.run_to(1e6);"));
    let mut child = conserva(&home, &["run", "main.rhai", "--quiet"]).spawn().unwrap();
    wait_for_rows(&home, &mut child);
    signal(&child, "-INT");
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(rows(&home), frames(&home));
}

#[test]
fn a_frame_that_cannot_be_written_ends_the_run_with_its_place() {
    let home = folder("frames-refused", &filmed("sim.run_to(1e6);"));
    let mut child = conserva(&home, &["run", "main.rhai", "--quiet"]).stderr(Stdio::piped()).spawn().unwrap();
    wait_for_rows(&home, &mut child);
    let fields = home.join("out/main/fields");
    // The run may create the folder again between the two calls.
    while std::fs::remove_dir_all(&fields).is_err() || std::fs::write(&fields, "in the way").is_err() {}
    let output = child.wait_with_output().unwrap();
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(3), "{message}");
    // A frame written between the two calls finds no directory at all.
    let refused = ["not a directory", "no such file"].iter().any(|cause| message.contains(&format!("could not be written: {cause}")));
    assert!(refused && message.contains("--> main.rhai:7:5"), "{message}");
    assert!(rows(&home) >= 9);
    assert!(outcome(&home).contains("could not be written"), "{}", outcome(&home));
}

#[test]
fn a_killed_run_leaves_whole_rows() {
    let home = folder("killed", &flight("sim.run_to(1e6);"));
    let mut child = conserva(&home, &["run", "main.rhai", "--quiet"]).spawn().unwrap();
    wait_for_rows(&home, &mut child);
    signal(&child, "-KILL");
    child.wait().unwrap();
    assert!(rows(&home) >= 9);
    assert!(std::fs::read_to_string(home.join("out/main/history.csv")).unwrap().ends_with('\n'));
}

#[test]
fn a_reader_that_goes_away_does_not_stop_the_run() {
    let home = folder("pipe", &flight("for i in 0..2000 { print(`a line of some length, number ${i}`); }\nsim.step(3);"));
    let mut child = conserva(&home, &["run", "main.rhai"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut first = String::new();
    BufReader::with_capacity(64, child.stdout.take().unwrap()).read_line(&mut first).unwrap();
    let mut message = String::new();
    child.stderr.take().unwrap().read_to_string(&mut message).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(0), "{message}");
    assert!(!message.contains("panicked"), "{message}");
    assert_eq!(rows(&home), 4);
}

#[test]
fn check_takes_no_step_and_finds_what_is_wrong() {
    let home = folder("check", &flight("sim.run_to(1e9);\nexpect_conserved(sim, \"energy\", #{ tolerance: 1e-9 });"));
    let output = run(&home, &["check", "main.rhai"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let said = stdout(&output);
    assert!(said.contains("simulation \"flight\": energy_momentum, dt = 0.01, 30 unknowns"), "{said}");
    assert!(said.ends_with("main.rhai: nothing wrong found\n"), "{said}");
    assert!(!home.join("out").exists());
    let home = folder("check-wrong", &flight("sim.run_to(1e9);\nexpect_conserved(sim, \"enrgy\", #{ tolerance: 1e-9 });"));
    let output = run(&home, &["check", "main.rhai"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("did you mean \"energy\"?"), "{}", stderr(&output));
}

#[test]
fn sliding_is_foreseen_by_check_and_found_by_run() {
    let script = std::fs::read_to_string("tests/errors/cases/contact_slides_fast.rhai").unwrap();
    let home = folder("sliding", &script);
    let title = "warning[C0609]: steps are halved beforehand: fast sliding in contact \"faces\"";
    let checked = run(&home, &["check", "main.rhai"]);
    assert_eq!(checked.status.code(), Some(0));
    assert_eq!(stderr(&checked).matches(title).count(), 1, "{}", stderr(&checked));
    let ran = run(&home, &["run", "main.rhai", "--quiet"]);
    assert_eq!(stderr(&ran).matches(title).count(), 1, "told when it begins, not again at the end: {}", stderr(&ran));
    let summary: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(home.join("out/main/summary.json")).unwrap()).unwrap();
    assert!(summary["halvings_by_cause"]["sliding"].as_u64() >= Some(4), "{summary}");
    let found = &summary["findings"][0];
    assert_eq!((found["kind"].as_str(), found["contact"].as_str(), found["limit"].as_f64()), (Some("sliding"), Some("faces"), Some(0.9)));
    assert!((found["value"].as_f64().unwrap() - 1.6).abs() < 1e-3, "0.2 in a step over facets of 0.125: {found}");
    // A wheel that rolls does not slide, although points off the contact are fast.
    let wheel = "let m = model(\"wheel\");\n\
        let rubber = neo_hookean(#{ youngs_modulus: 1e4, poisson_ratio: 0.3, density: 1.0 });\n\
        let rim = m.add_body(\"rim\", ring(#{ inner_radius: 0.2, outer_radius: 0.5, cells: [3, 40], center: [0.0, 0.5] }), rubber);\n\
        m.initial_velocity(rim, #{ linear: [param(\"speed\", 10.0), 0.0], angular: -20.0 });\n\
        let floor = rigid_plane(#{ point: [0.0, 0.0], normal: [0.0, 1.0] });\n\
        m.add_contact(\"floor\", #{ secondary: rim.boundary(\"outer\"), primary: floor });\n\
        let sim = simulate(m, #{ integrator: energy_momentum(), dt: 0.01 });\n";
    let home = folder("wheel", wheel);
    assert_eq!(stderr(&run(&home, &["check", "main.rhai"])), "");
    let slips = run(&home, &["check", "main.rhai", "--set", "speed=0.0"]);
    assert!(stderr(&slips).contains("fast sliding in contact \"floor\""), "{}", stderr(&slips));
}

#[test]
fn a_script_reads_only_what_it_may() {
    let home = folder("sandbox", "let mesh = read_mesh(param(\"mesh\", \"\")); print(mesh.cells);");
    let mesh = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/errors/cases/meshes/square.msh");
    let set = format!("mesh={}", mesh.display());
    let output = run(&home, &["run", "main.rhai", "--set", &set]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("may not read"), "{}", stderr(&output));
    let output = run(&home, &["run", "main.rhai", "--set", &set, "--allow-read", mesh.parent().unwrap().to_str().unwrap()]);
    assert_eq!((output.status.code(), stdout(&output).as_str()), (Some(0), "1\n"), "{}", stderr(&output));
}

#[test]
fn progress_without_a_terminal_is_plain_lines() {
    let home = folder("progress", &flight("sim.run_to(1e6);"));
    let mut child = conserva(&home, &["run", "main.rhai"]).stderr(Stdio::piped()).spawn().unwrap();
    wait_for_rows(&home, &mut child);
    std::thread::sleep(Duration::from_secs(1));
    signal(&child, "-INT");
    let output = child.wait_with_output().unwrap();
    assert!(!stderr(&output).contains('\u{1b}'), "no escape codes: {}", stderr(&output));
}

#[test]
fn the_reference_is_searched_and_shells_are_told_of_the_commands() {
    let home = folder("tools", "fn test_a() { expect(true); }\nfn test_b() { expect(false); }\nfn test_c(x) { expect(x); }\n");
    let found = run(&home, &["doc", "--search", "angular velocity"]);
    assert!(stdout(&found).contains("Model.initial_velocity: "), "{}", stdout(&found));
    assert_eq!(run(&home, &["doc", "--search", "zebra quagga"]).status.code(), Some(2));
    assert!(stdout(&run(&home, &["doc", "for"])).starts_with("loops over values\n"));
    assert!(stdout(&run(&home, &["completions", "bash"])).contains("_conserva"));
    assert!(stdout(&run(&home, &["man"])).contains(".TH conserva"));
    let listed = run(&home, &["test", "--list", "main.rhai"]);
    assert_eq!((stdout(&listed).as_str(), listed.status.code()), ("main.rhai::test_a\nmain.rhai::test_b\n", Some(0)));
    assert!(stderr(&listed).contains("`test_c` is not run: a test has no parameters"), "{}", stderr(&listed));
}

/// Overlapping bodies without a contact between them: the run completes with the exit code of untrustworthy results.
#[test]
fn a_run_that_is_not_to_be_trusted_has_a_code_of_its_own() {
    let home = folder(
        "doubtful",
        "let m = model(\"through\");\n\
         let law = neo_hookean(#{ youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 });\n\
         let a = m.add_body(\"a\", rectangle(#{ size: [1.0, 1.0], cells: [3, 3] }), law);\n\
         m.add_body(\"b\", rectangle(#{ size: [1.0, 1.0], cells: [3, 3], origin: [1.2, 0.0] }), law);\n\
         m.initial_velocity(a, #{ linear: [1.0, 0.0] });\n\
         let sim = simulate(m, #{ integrator: energy_momentum(), dt: 0.05 });\n\
         sim.run_to(0.8);\n",
    );
    let output = run(&home, &["run", "main.rhai"]);
    assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
    assert!(stderr(&output).contains("bodies have passed into each other") && stderr(&output).contains("not to be trusted"));
}

/// Typical mistakes of new users: commands of other names, a mesh in place of a script, words of other programs.
#[test]
fn what_a_newcomer_types_is_answered() {
    let home = folder("newcomer", "print(1);");
    std::fs::write(home.join("part.msh"), "$MeshFormat\n").unwrap();
    let mesh = run(&home, &["run", "part.msh"]);
    assert_eq!(mesh.status.code(), Some(2));
    assert!(stderr(&mesh).contains("part.msh is a mesh, not a script") && stderr(&mesh).contains("read_mesh(\"part.msh\")"));
    assert!(!home.join("out").exists(), "and nothing is written");
    let help = run(&home, &["help", "run"]);
    assert!(help.status.success() && stdout(&help).contains("--threads"), "{}", stderr(&help));
    let manual = run(&home, &["man", "run"]);
    assert!(manual.status.success() && stdout(&manual).contains("conserva\\-run") && stdout(&manual).contains("checkpoint"));
    let none = run(&home, &["man", "fly"]);
    assert!(none.status.code() == Some(2) && stderr(&none).contains("there is no command `fly`"));
    let threads = run(&home, &["run", "main.rhai", "--threads", "0"]);
    assert!(stderr(&threads).contains("write at least 1"), "{}", stderr(&threads));
    let beginning = run(&home, &["doc", "rect"]);
    assert!(stderr(&beginning).contains("did you mean `rectangle`?"), "{}", stderr(&beginning));
    for (words, ours) in [("Dirichlet", "prescribe"), ("quasi-static", "settle"), ("B-bar", "add_body"), ("restart", "restore")] {
        let found = run(&home, &["doc", "--search", words]);
        assert!(found.status.success() && stdout(&found).contains(&format!("`{ours}`")), "{words}: {}", stdout(&found));
    }
}

#[test]
fn a_deck_becomes_a_script_that_runs_and_a_picture() {
    let home = folder("deck", "");
    let deck = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes/two_blocks.inp");
    std::fs::copy(deck, home.join("two_blocks.inp")).unwrap();
    let made = run(&home, &["new", "--from", "two_blocks.inp"]);
    assert!(made.status.success() && stdout(&made).contains("two_blocks.rhai is written"), "{}", stderr(&made));
    let script = std::fs::read_to_string(home.join("two_blocks.rhai")).unwrap();
    for line in [
        "let deck = read_deck(\"two_blocks.inp\");",
        "let block_1 = scene.add_body(\"Block-1\", deck.parts[\"Block-1\"], deck.materials[\"Rubber\"]);",
        "scene.fix(block_1.boundary(\"Ground\"));",
        "scene.add_contact(\"contact 1\", #{ secondary: block_2.boundary(\"Foot\"), primary: block_1.boundary(\"Top\") });",
    ] {
        assert!(script.contains(line), "{script}");
    }
    // Densities in t/mm^3 go with the earth's gravity in mm/s^2.
    assert!(script.contains("scene.gravity([0.0, -9810.0]);"), "{script}");
    assert_eq!(script.lines().filter(|line| !line.starts_with("//")).count(), 10, "{script}");
    let ran = run(&home, &["run", "two_blocks.rhai", "--quiet"]);
    assert!(ran.status.success(), "{}", stderr(&ran));
    let again = run(&home, &["new", "--from", "two_blocks.inp"]);
    assert!(!again.status.success() && stderr(&again).contains("there already is a file two_blocks.rhai"));
    let drawn = run(&home, &["info", "two_blocks.inp", "--picture"]);
    assert!(stdout(&drawn).contains("picture: two_blocks.png"), "{}", stderr(&drawn));
    assert!(std::fs::read(home.join("two_blocks.png")).unwrap().starts_with(b"\x89PNG"));
    let no_mesh = run(&home, &["info", "two_blocks.rhai", "--picture", "a.svg"]);
    assert!(stderr(&no_mesh).contains("is no mesh file"));
}

#[test]
fn the_distributed_solver_that_is_not_installed_is_told_with_what_to_install() {
    let folder = folder("ranks-missing", &flight("sim.run_to(0.02);"));
    let output =
        conserva(&folder, &["run", "main.rhai", "--solver", "mumps", "--ranks", "2"]).env("CONSERVA_MUMPS", "/nowhere").output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("C0526") && stderr(&output).contains("packages/mumps/build.sh"), "{}", stderr(&output));
    let solved = run(&folder, &["run", "main.rhai", "--solver", "direct"]);
    assert_eq!(solved.status.code(), Some(0), "{}", stderr(&solved));
}

#[test]
fn only_the_first_process_of_a_job_without_its_solver_says_so() {
    let folder = folder("ranks-refused", &flight("sim.run_to(0.02);"));
    for rank in ["0", "1"] {
        let of_job = |arguments: &[&str]| {
            let mut command = conserva(&folder, arguments);
            command.env("OMPI_COMM_WORLD_RANK", rank).env("OMPI_COMM_WORLD_SIZE", "2").output().unwrap()
        };
        for arguments in [&["run", "main.rhai"][..], &["run", "main.rhai", "--solver", "mumps", "--ranks", "3"], &["run", "--wrong"]] {
            let output = of_job(arguments);
            assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
            assert_eq!(stderr(&output).is_empty(), rank == "1", "{}", stderr(&output));
            assert_eq!(stderr(&output).contains("C0529"), rank == "0" && arguments[1] == "main.rhai", "{}", stderr(&output));
        }
    }
    assert!(!folder.join("out").exists(), "no process has begun the run");
}
