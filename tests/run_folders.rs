//! Commands on run folders as processes: `diff`, `list`, `info`, `export`, and the log of a run. Numbers read from files are compared with
//! printed ones; damage is reported with its place and a hint.

use std::path::Path;
use std::process::Output;

use conserva::output::{Numbers, Section, read_fields, read_frames, read_parquet, read_table};
use serde_json::Value;

#[path = "common/program.rs"]
mod program;

use program::{folder, stderr, stdout};

/// A block that falls on another one, with a probe; prints contact results at the end.
const PUNCH: &str = r#"
let dt = param("dt", 0.005);
let rubber = neo_hookean(#{ youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 });
let punch = model("punch");
let upper = punch.add_body("upper", rectangle(#{ size: [1.0, 0.5], cells: [4, 2], origin: [0.5, 0.52] }), rubber);
let lower = punch.add_body("lower", rectangle(#{ size: [2.0, 0.5], cells: [5, 2], element: "quad8" }), rubber);
punch.fix(lower.boundary("bottom"));
punch.initial_velocity(upper, #{ linear: [0.0, -1.0] });
punch.add_contact("race", #{ secondary: upper.boundary("bottom"), primary: lower.boundary("top") });
let sim = simulate(punch, #{ integrator: energy_momentum(), dt: dt, fields_every: 0.02 });
sim.probe("tip", upper, [1.0, 1.02]);
sim.run_to(0.1);
print(sim.contact("race").pressure);
print(sim.contact("race").positions);
print(sim.history.total);
sim.table("some.csv", ["time", "race.normal_force", "tip.uy"]);
sim.table("all.csv");
sim.table("all.parquet");
sim.write_fields("now.vtu");
"#;

fn conserva(folder: &Path, arguments: &[&str]) -> Output {
    program::conserva(folder, arguments).output().unwrap()
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let output = conserva(folder, &[&["run", "main.rhai", "--quiet"], arguments].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    output
}

/// Exit code and messages of a refused command.
fn refused(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let output = conserva(folder, arguments);
    (output.status.code(), stderr(&output))
}

/// An array of numbers as a script prints it.
fn printed(line: &str) -> Vec<f64> {
    line.split(['[', ']', ',', ' ']).filter(|word| !word.is_empty()).map(|word| word.parse().unwrap()).collect()
}

#[test]
fn files_give_back_what_the_script_sees() {
    let home = folder("files", PUNCH);
    let said = stdout(&run(&home, &[]));
    let lines: Vec<Vec<f64>> = said.lines().map(printed).collect();
    let out = home.join("out/main");
    // Tables: all columns equal the history, in both formats; chosen ones are in the order of the call.
    assert_eq!(std::fs::read(out.join("all.csv")).unwrap(), std::fs::read(out.join("history.csv")).unwrap());
    let history = read_table(&out.join("history.csv")).unwrap().table;
    assert_eq!(read_parquet(&out.join("all.parquet")).unwrap(), history);
    let total: Vec<f64> = history.column("total").unwrap().values.iter().map(|value| value.unwrap()).collect();
    assert_eq!(total, lines[2]);
    let some = std::fs::read_to_string(out.join("some.csv")).unwrap();
    assert!(some.starts_with("time,race.normal_force,tip.uy\n0.0,,0.0\n0.005,0.0,"), "{some}");
    // Contact surface: a file beside each frame, values of the contact alone, in the order along the surface.
    let frames = read_frames(&out.join("contacts.pvd")).unwrap();
    assert_eq!(frames.len(), read_frames(&out.join("fields.pvd")).unwrap().len());
    for surface in [frames.last().unwrap().path.clone(), out.join("now_contacts.vtu")] {
        let surface = read_fields(&surface).unwrap();
        assert_eq!((surface.kind.as_str(), surface.parts.as_slice(), surface.cells), ("contact", &["race".to_string()][..], 4));
        let reals = |section, name: &str| match &surface.array(section, name).unwrap().numbers {
            Numbers::Reals(values) => values.clone(),
            Numbers::Integers(values) => values.iter().map(|&value| value as f64).collect(),
        };
        assert_eq!(reals(Section::PointData, "contact_pressure"), lines[0]);
        let places = reals(Section::Points, "Points").into_iter().zip(reals(Section::PointData, "displacement"));
        for (point, printed) in places.map(|(x, u)| x + u).collect::<Vec<_>>().chunks(3).zip(lines[1].chunks(2)) {
            // Displacements are differences of positions.
            assert!((point[0] - printed[0]).abs() < 1e-15 && (point[1] - printed[1]).abs() < 1e-15, "{point:?} {printed:?}");
        }
        // Body and node numbers lead to the same point of the fields.
        let fields = read_fields(&out.join("now.vtu")).unwrap();
        let points = fields.array(Section::Points, "Points").unwrap();
        for (index, node) in reals(Section::PointData, "node").into_iter().enumerate() {
            let own = surface.array(Section::Points, "Points").unwrap();
            assert!((0..3).all(|i| points.numbers.at(3 * node as usize + i) == own.numbers.at(3 * index + i)));
        }
    }
}

#[test]
fn runs_are_converted_and_described() {
    let home = folder("export", PUNCH);
    run(&home, &[]);
    for (format, files) in [
        ("parquet", &["out/main/history.parquet"][..]),
        ("csv", &["out/main/fields-csv.csv", "out/main/contacts-csv.csv"]),
        ("vtu", &["out/main/fields-text.pvd", "out/main/contacts-text.pvd"]),
        ("vtm", &["out/main/fields-blocks.pvd", "out/main/contacts-blocks.pvd"]),
        ("xdmf", &["out/main/fields.xdmf", "out/main/contacts.xdmf"]),
    ] {
        let output = conserva(&home, &["export", "out/main", "--format", format]);
        assert_eq!((output.status.code(), stdout(&output)), (Some(0), files.iter().map(|file| format!("{file}\n")).collect()));
        assert!(files.iter().all(|file| home.join(file).is_file()));
    }
    let out = home.join("out/main");
    assert_eq!(read_parquet(&out.join("history.parquet")).unwrap(), read_table(&out.join("history.csv")).unwrap().table);
    // Text and packed frames have the same numbers; a table has them row by row.
    let packed = read_fields(&out.join("fields/fields_000005.vtu")).unwrap();
    let text = read_fields(&out.join("fields-text/fields_000005.vtu")).unwrap();
    assert_eq!(format!("{packed:?}"), format!("{text:?}"));
    let nodes = read_table(&out.join("fields-csv/fields_000005.csv")).unwrap().table;
    let stress = packed.array(Section::PointData, "stress").unwrap();
    for (node, value) in nodes.column("stress_yy").unwrap().values.iter().enumerate() {
        assert_eq!(*value, Some(stress.numbers.at(6 * node + 1)));
    }
    for (file, words) in [
        ("out/main", "run\n  script: main.rhai\n  parameters: dt=0.005\n"),
        ("out/main/history.csv", "table\n  rows: 21\n"),
        ("out/main/history.parquet", "table (Parquet)\n  rows: 21\n"),
        ("out/main/summary.json", "summary of a run\n  script: main.rhai\n"),
        ("out/main/fields.pvd", "series of fields (PVD)\n  frames: 6\n"),
        ("out/main/now_contacts.vtu", "fields (VTU)\n  time: 0.1\n  points: 5\n  cells: 4\n  contacts: race\n"),
        ("out/main/history.svg", "picture\n  format: SVG\n  size: "),
        ("main.rhai", "script\n  lines: 19\n"),
    ] {
        let output = conserva(&home, &["info", file]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        assert!(stdout(&output).starts_with(&format!("{file}: {words}")), "{}", stdout(&output));
        let json = conserva(&home, &["info", file, "--format", "json"]);
        assert_eq!(serde_json::from_str::<Value>(&stdout(&json)).unwrap()["path"], file);
    }
    let mesh = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/errors/cases/meshes/square.msh");
    let output = conserva(&home, &["info", mesh.to_str().unwrap()]);
    assert!(stdout(&output).contains(": mesh\n  cells: 1 of quad4\n"), "{}{}", stdout(&output), stderr(&output));
}

#[test]
fn runs_that_failed_alike_are_the_same_as_far_as_they_went() {
    let home = folder("diff-failed", &format!("{PUNCH}\nthrow \"no more\";"));
    for out in ["out/a", "out/b"] {
        assert_eq!(conserva(&home, &["run", "main.rhai", "--quiet", "--out", out]).status.code(), Some(2));
    }
    let output = conserva(&home, &["diff", "out/a", "out/b"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let last = stdout(&output).lines().last().unwrap_or_default().to_string();
    assert!(last.starts_with("neither run was completed, and both ended so: ") && last.contains("no more"), "{}", stdout(&output));
}

#[test]
fn runs_are_compared_and_listed() {
    let home = folder("diff", PUNCH);
    for (out, dt) in [("out/a", "dt=0.005"), ("out/b", "dt=0.005"), ("out/deep/coarse", "dt=0.01")] {
        run(&home, &["--out", out, "--set", dt]);
    }
    let same = conserva(&home, &["diff", "out/a", "out/b"]);
    assert_eq!((same.status.code(), stderr(&same).as_str()), (Some(0), ""));
    assert!(stdout(&same).starts_with("same: 21 rows with 41 columns and 12 frames with 36 arrays"), "{}", stdout(&same));
    let other = conserva(&home, &["diff", "out/a", "out/deep/coarse", "--format", "json"]);
    assert_eq!(other.status.code(), Some(1));
    let found: Value = serde_json::from_str(&stdout(&other)).unwrap();
    let first = &found["simulations"][0];
    assert_eq!((&found["same"], &first["rows"]), (&false.into(), &serde_json::json!([21, 11, 11])));
    assert_eq!((&first["entries"][0]["name"], &first["entries"][0]["second"]), (&"parameter dt".into(), &0.01.into()));
    // Both blocks fall freely until the landing: columns of probes differ by round-off before.
    let tip = first["columns"].as_array().unwrap().iter().find(|column| column["column"] == "tip.uy").unwrap();
    assert!(tip["largest"].as_f64().unwrap() > 1e-4, "{tip}");
    assert!(stdout(&conserva(&home, &["diff", "out/a", "out/deep/coarse"])).contains("parameter dt: 0.005 | 0.01\n"));

    // One changed number of the history is reported with column, step and size; a larger tolerance makes the runs equal.
    let path = home.join("out/b/history.csv");
    let text = std::fs::read_to_string(&path).unwrap();
    let line = text.lines().nth(8).unwrap();
    let fields: Vec<&str> = line.split(',').collect();
    let kinetic: f64 = fields[3].parse().unwrap();
    let changed = line.replacen(fields[3], &format!("{:?}", kinetic + 1e-6), 1);
    std::fs::write(&path, text.replacen(line, &changed, 1)).unwrap();
    let output = conserva(&home, &["diff", "out/a", "out/b", "--format", "json"]);
    let found: Value = serde_json::from_str(&stdout(&output)).unwrap();
    let columns = found["simulations"][0]["columns"].as_array().unwrap();
    assert_eq!((output.status.code(), columns.len(), &columns[0]["column"]), (Some(1), 1, &"kinetic".into()));
    assert_eq!((&columns[0]["from_step"], &columns[0]["rows"]), (&7.into(), &1.into()));
    assert!((columns[0]["largest"].as_f64().unwrap() - 1e-6).abs() < 1e-15);
    assert_eq!(conserva(&home, &["diff", "out/a", "out/b", "--tolerance", "1e-5"]).status.code(), Some(0));
    assert_eq!(conserva(&home, &["diff", "out/a", "out/b", "--ignore", "kin*"]).status.code(), Some(0));

    let listed = stdout(&conserva(&home, &["list"]));
    let lines: Vec<&str> = listed.lines().collect();
    assert!(lines[0].starts_with("run          script     parameters that differ  outcome"), "{listed}");
    assert!(lines[1].starts_with("a            main.rhai  dt=0.005                completed") && lines.len() == 4, "{listed}");
    let json: Value = serde_json::from_str(&stdout(&conserva(&home, &["list", "out", "--format", "json"]))).unwrap();
    assert_eq!(
        (&json[2]["run"], &json[2]["parameters"]["dt"], &json[2]["end_time"]),
        (&"out/deep/coarse".into(), &0.01.into(), &0.1.into())
    );
}

#[test]
fn damage_and_absence_have_a_place_and_a_cure() {
    let home = folder("damage", PUNCH);
    run(&home, &["--out", "out/a"]);
    run(&home, &["--out", "out/b"]);
    let (code, said) = refused(&home, &["diff", "out", "out/b"]);
    assert!(code == Some(2) && said.contains("\"out\" holds no run") && said.contains("`conserva list out` shows them"), "{said}");
    for command in [&["diff", "out/a", "none"][..], &["info", "none"], &["list", "none"], &["export", "none", "--format", "csv"]] {
        let (code, said) = refused(&home, command);
        assert!(code == Some(2) && said.contains("\"none\" does not exist"), "{said}");
    }
    let (code, said) = refused(&home, &["export", "out/a", "--format", "excel"]);
    assert!(code == Some(2) && said.contains("[possible values: parquet, csv, vtu, vtm, xdmf]"), "{said}");

    // An incomplete last line of a killed run is ignored; a damaged line in the middle is an error.
    let history = home.join("out/b/history.csv");
    let text = std::fs::read_to_string(&history).unwrap();
    std::fs::remove_file(home.join("out/b/summary.json")).unwrap();
    std::fs::write(&history, &text[..text.len() - 30]).unwrap();
    let said = stdout(&conserva(&home, &["info", "out/b"]));
    assert!(said.contains("outcome: no summary: killed, or still running\n  rows of history.csv: 20\n"), "{said}");
    assert!(said.contains("the last line of history.csv is cut"), "{said}");
    let output = conserva(&home, &["diff", "out/a", "out/b"]);
    assert!(output.status.code() == Some(1) && stdout(&output).contains("rows of history.csv: 21 | 20"), "{}", stdout(&output));
    std::fs::write(&history, text.replacen("\n5,", "\nfive,", 1)).unwrap();
    for command in [&["diff", "out/a", "out/b"][..], &["info", "out/b"], &["export", "out/b", "--format", "parquet"]] {
        let (code, said) = refused(&home, command);
        assert!(code == Some(2) && said.contains("line 7 has \"five\" in column `step`, which is no number"), "{said}");
    }
    assert!(stdout(&conserva(&home, &["list"])).contains("killed, or still running"));
    std::fs::write(&history, &text).unwrap();

    // A truncated frame, and a missing one.
    let frame = home.join("out/b/fields/fields_000005.vtu");
    let bytes = std::fs::read(&frame).unwrap();
    std::fs::write(&frame, &bytes[..bytes.len() / 2]).unwrap();
    let (code, said) = refused(&home, &["diff", "out/a", "out/b"]);
    assert!(code == Some(2) && said.contains("fields_000005.vtu\" is damaged: the data of array"), "{said}");
    std::fs::remove_file(&frame).unwrap();
    let (code, said) = refused(&home, &["export", "out/b", "--format", "xdmf"]);
    assert!(code == Some(2) && said.contains("fields_000005.vtu\" does not exist"), "{said}");
    assert!(stdout(&conserva(&home, &["info", "out/b/fields.pvd"])).contains("missing files: fields/fields_000005.vtu"));
    let (code, said) = refused(&home, &["info", "main.rhai.txt"]);
    assert!(code == Some(2) && said.contains("does not exist"), "{said}");
}

/// A run replaces the files of the previous run; a run that fails before its first simulation changes nothing.
#[test]
fn a_run_replaces_the_files_of_the_run_before_and_a_failed_start_nothing() {
    let home = folder("replaced", PUNCH);
    let names = |files: &Path| -> Vec<String> {
        let text = std::fs::read_to_string(files.join(".files")).unwrap();
        text.lines().map(String::from).collect()
    };
    run(&home, &["--out", "o"]);
    let (out, first) = (home.join("o"), names(&home.join("o")));
    assert!(first.contains(&"fields/fields_000000.vtu".to_string()) && first.contains(&"summary.json".to_string()), "{first:?}");
    assert!(first.iter().all(|name| out.join(name).is_file()), "all that it names is there");
    // A script without a simulation does not touch existing files.
    std::fs::write(out.join("mine.txt"), "kept").unwrap();
    let summary = std::fs::read(out.join("summary.json")).unwrap();
    std::fs::create_dir_all(out.join("checkpoints")).unwrap();
    std::fs::write(out.join("checkpoints/000001.checkpoint"), "of an interrupted run").unwrap();
    std::fs::write(home.join("broken.rhai"), "let a = (1;").unwrap();
    std::fs::write(home.join("early.rhai"), "let m = modell(\"a\");").unwrap();
    for script in ["mistyped.rhai", "broken.rhai", "early.rhai"] {
        let (code, _) = refused(&home, &["run", script, "--quiet", "--out", "o"]);
        assert_eq!(code, Some(2), "{script}");
        assert_eq!(std::fs::read(out.join("summary.json")).unwrap(), summary, "{script}");
        assert!(out.join("checkpoints/000001.checkpoint").is_file(), "{script}");
        let (code, _) = refused(&home, &["run", script, "--quiet", "--out", "new"]);
        assert_eq!((code, home.join("new/summary.json").exists()), (Some(2), script == "early.rhai"), "{script}: nothing is hidden");
    }
    // Another script in the same folder: files of the old run are removed, foreign files stay.
    let shorter = PUNCH.replace("run_to(0.1)", "run_to(0.03)").replace("sim.table(\"some.csv\"", "sim.table(\"other.csv\"");
    std::fs::write(home.join("main.rhai"), shorter).unwrap();
    run(&home, &["--out", "o"]);
    let second = names(&out);
    assert!(second.contains(&"other.csv".to_string()) && second.len() < first.len());
    for gone in first.iter().filter(|name| !second.contains(name)) {
        assert!(!out.join(gone).exists(), "{gone}");
    }
    assert_eq!(std::fs::read_to_string(out.join("mine.txt")).unwrap(), "kept");
    assert!(!out.join("checkpoints").exists());
}

/// The record of files can be edited by anybody: paths outside of the folder are ignored.
#[test]
fn a_record_that_names_files_elsewhere_removes_none() {
    let home = folder("record", PUNCH);
    let out = home.join("o");
    std::fs::create_dir_all(&out).unwrap();
    std::fs::write(home.join("theirs"), "kept").unwrap();
    let absolute = home.join("theirs").display().to_string();
    #[cfg(unix)]
    std::os::unix::fs::symlink(&home, out.join("link")).unwrap();
    std::fs::write(out.join(".files"), format!("../theirs\n{absolute}\nlink/theirs\n\n.\no\n")).unwrap();
    run(&home, &["--out", "o"]);
    assert_eq!(std::fs::read_to_string(home.join("theirs")).unwrap(), "kept");
}

fn events(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}"))).collect()
}

fn count(events: &[Value], event: &str) -> usize {
    events.iter().filter(|line| line["event"] == event).count()
}

#[test]
fn the_log_tells_what_happens() {
    let script = PUNCH.replace("boundary(\"top\") }", "boundary(\"top\"), update: \"persistency\" }");
    let script = script.replace("sim.run_to(0.1);", "sim.run_to(0.2); expect_conserved(sim, \"energy\", #{ tolerance: 1e-9 });");
    let home = folder("log", &script);
    let output = run(&home, &["--log", "json"]);
    let lines = events(&stderr(&output));
    let history = read_table(&home.join("out/main/history.csv")).unwrap().table;
    let ends = [&lines[0], &lines[lines.len() - 1]].map(|line| line["event"].as_str().unwrap());
    assert_eq!(ends, ["start", "end"]);
    assert_eq!((count(&lines, "step"), count(&lines, "print"), count(&lines, "check")), (history.rows() - 1, 3, 1));
    // Numbers of the text itself: this JSON reader may differ in the last bit.
    let told = stderr(&output);
    for (row, step) in told.lines().filter(|line| line.starts_with("{\"event\":\"step\"")).enumerate() {
        for name in ["step", "time", "total", "energy_defect", "newton_iterations", "active"] {
            let text = step.split(&format!("\"{name}\":")).nth(1).unwrap().split([',', '}']).next().unwrap();
            assert_eq!(text.parse().ok(), history.column(name).unwrap().values[row + 1], "{name} of row {row}");
        }
    }
    // The block lands and bounces: the log has closing and opening at the steps of the column.
    let active: Vec<f64> = history.column("race.active").unwrap().values.iter().map(|value| value.unwrap_or(0.0)).collect();
    let expected: Vec<(u64, &str)> = (1..active.len())
        .filter(|&row| (active[row] > 0.0) != (active[row - 1] > 0.0))
        .map(|row| (row as u64, if active[row] > 0.0 { "closed" } else { "opened" }))
        .collect();
    let told = lines.iter().filter(|line| line["event"] == "contact");
    assert_eq!(told.map(|line| (line["step"].as_u64().unwrap(), line["change"].as_str().unwrap())).collect::<Vec<_>>(), expected);
    assert!(expected.len() >= 2, "{expected:?}");
    let end = &lines[lines.len() - 1];
    assert_eq!((&end["outcome"], &end["exit_code"], &end["checks"]), (&"completed".into(), &0.into(), &1.into()));
    // Except for wall times, logs of equal runs are equal.
    let again = run(&home, &["--log", "json:run.jsonl"]);
    assert_eq!(stderr(&again), "");
    let file = std::fs::read_to_string(home.join("run.jsonl")).unwrap();
    let (last, other) = (stderr(&output).lines().count() - 1, stderr(&output));
    let described = stdout(&conserva(&home, &["info", "run.jsonl"]));
    assert!(described.starts_with("run.jsonl: log of a run\n  script: main.rhai\n  outcome: completed\n  events: check=1 "), "{described}");
    assert_eq!(file.lines().take(last).collect::<Vec<_>>(), other.lines().take(last).collect::<Vec<_>>());
}

#[test]
fn the_log_tells_of_halvings_and_failures() {
    // A fast impact must be halved; the number of halvings equals that of the summary.
    let script = PUNCH.replace("0.0, -1.0", "80.0, -8.0").replace("sim.run_to(0.1);", "sim.settle(); sim.run_to(0.015); expect(false);");
    let home = folder("log-failure", &script);
    let output = conserva(&home, &["run", "main.rhai", "--log", "json"]);
    assert_eq!(output.status.code(), Some(1));
    let lines = events(&stderr(&output));
    let failure = lines.iter().find(|line| line["event"] == "failure").unwrap();
    assert_eq!((&failure["class"], &failure["file"], failure["line"].is_u64()), (&"check".into(), &"main.rhai".into(), true), "{failure}");
    assert_eq!(lines[lines.len() - 1]["outcome"], "failed");
    assert_eq!(count(&lines, "settled"), 1);
    let summary: Value = serde_json::from_str(&std::fs::read_to_string(home.join("out/main/summary.json")).unwrap()).unwrap();
    let counted: u64 = summary["halvings_by_cause"].as_object().unwrap().values().map(|count| count.as_u64().unwrap()).sum();
    let told: u64 = lines.iter().filter(|line| line["event"] == "halving").map(|line| line["count"].as_u64().unwrap()).sum();
    assert_eq!(told, counted);
    assert!(told > 0, "the scene is meant to halve");
    // A log that cannot be written is refused before the run.
    let (code, said) = refused(&home, &["run", "main.rhai", "--log", "json:none/x"]);
    assert!(code == Some(2) && said.contains("the log none/x cannot be written"), "{said}");
    let (code, said) = refused(&home, &["run", "main.rhai", "--log", "text"]);
    assert!(code == Some(2) && said.contains("`--log json:run.jsonl` for a file"), "{said}");
}
