//! Files of unexpected kinds and unusual names.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use crate::program::{conserva, empty_folder, folder, stderr, stdout};

/// Exit code and messages of a command that must end within seconds.
fn within_seconds(home: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let mut child = conserva(home, arguments).stdout(std::process::Stdio::null()).stderr(std::process::Stdio::piped()).spawn().unwrap();
    let begun = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begun.elapsed() > Duration::from_secs(20) {
            child.kill().unwrap();
            panic!("{arguments:?} waits");
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    let output = child.wait_with_output().unwrap();
    (output.status.code(), stderr(&output))
}

#[test]
fn pipes_are_no_files_wherever_a_file_is_read() {
    let home = folder("pipes", "import \"module\" as m;\n");
    for name in ["pipe", "pipe.rhai", "module.rhai", "pipe.msh", "pipe.csv", "pipe.parquet", "pipe.vtu", "pipe.study.toml", "history.csv"] {
        assert!(Command::new("mkfifo").arg(home.join(name)).status().unwrap().success());
    }
    std::fs::write(home.join("reads.rhai"), "read_csv(\"pipe.csv\");").unwrap();
    std::fs::write(home.join("meshes.rhai"), "read_mesh(\"pipe.msh\");").unwrap();
    let commands: [&[&str]; 15] = [
        &["run", "pipe.rhai"],
        &["run", "main.rhai"],
        &["run", "reads.rhai"],
        &["run", "meshes.rhai"],
        &["check", "pipe.rhai"],
        &["test", "pipe.rhai"],
        &["info", "pipe.rhai"],
        &["info", "pipe.msh"],
        &["info", "pipe.csv"],
        &["info", "pipe.parquet"],
        &["info", "pipe.vtu"],
        &["info", "pipe"],
        &["sweep", "pipe.study.toml"],
        &["sweep", "pipe.rhai", "--vary", "a=1,2"],
        &["sweep", "main.rhai", "--values", "pipe.csv"],
    ];
    for arguments in commands {
        let (code, message) = within_seconds(&home, arguments);
        assert_eq!(code, Some(2), "{arguments:?}: {message}");
    }
    let (_, message) = within_seconds(&home, &["run", "pipe.rhai"]);
    assert!(message.contains("it is a pipe or a device, not a file"), "{message}");
    let (code, message) = within_seconds(&home, &["run", "/dev/zero"]);
    assert!(code == Some(2) && message.contains("it is a pipe or a device"), "{message}");
}

#[test]
fn a_script_may_come_through_a_redirected_standard_input() {
    let home = folder("redirected", "print(1 + 1);");
    let input = std::fs::File::open(home.join("main.rhai")).unwrap();
    let output = conserva(&home, &["run", "/dev/stdin"]).stdin(input).output().unwrap();
    assert_eq!((output.status.code(), stdout(&output).as_str()), (Some(0), "2\n"), "{}", stderr(&output));
}

#[test]
fn names_stand_on_one_line() {
    let calls = [
        "model(NAME)",
        "model(\"m\").add_body(NAME, plate, law)",
        "result(NAME, 1)",
        "param(NAME, 1)",
        "plate.boundary_where(NAME, |x, y| x < 0.1)",
        "polygon(#{ points: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], size: 0.5, names: [NAME, \"b\", \"c\"] })",
    ];
    for (number, call) in calls.into_iter().enumerate() {
        for bad in ["\"a\\x1b[31m\"", "\"a\\nb\"", "\"a\\x00\""] {
            let script = format!(
                "let plate = rectangle(#{{ size: [1.0, 1.0], cells: [2, 2] }});\n\
                 let law = neo_hookean(#{{ youngs_modulus: 1.0, poisson_ratio: 0.3, density: 1.0 }});\n{};\n",
                call.replace("NAME", bad)
            );
            let output = conserva(&folder(&format!("names-{number}"), &script), &["check", "main.rhai"]).output().unwrap();
            let message = stderr(&output);
            assert!(output.status.code() == Some(2) && message.contains("name"), "{call} {bad}: {message}");
            assert!(!message.contains('\u{1b}'), "{message}");
        }
    }
}

#[test]
fn foreign_files_do_not_command_the_terminal() {
    let home = empty_folder("foreign");
    std::fs::write(home.join("a.csv"), "step,\u{1b}[31mred\u{7}\n0,1.0\n").unwrap();
    std::fs::write(home.join("b.csv"), "step,time\n0,\u{1b}]0;title\u{7}\n").unwrap();
    std::fs::create_dir_all(home.join("out/x")).unwrap();
    std::fs::write(home.join("out/x/summary.json"), "{\"outcome\": \"\\u001b[2Jgone\", \"script\": \"\\u001b[1m.rhai\"}\n").unwrap();
    for arguments in [&["info", "a.csv"][..], &["info", "b.csv"], &["info", "out/x"], &["info", "out/x/summary.json"], &["list"]] {
        let output = conserva(&home, arguments).output().unwrap();
        let (said, told) = (stdout(&output), stderr(&output));
        let is_clean = |text: &str| text.chars().all(|letter| letter == '\n' || !letter.is_control());
        assert!(is_clean(&said) && is_clean(&told), "{arguments:?}: {said:?} {told:?}");
        assert!(said.len() + told.len() > 10, "{arguments:?}");
    }
}
