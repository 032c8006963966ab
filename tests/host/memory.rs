//! Memory limits: allocations beyond the limit are refused with the figure, and scripts that exceed it are stopped.

use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use crate::program::{conserva, folder, stderr};

/// Exit code, messages, and peak memory of a command in MB.
fn held(home: &Path, arguments: &[&str]) -> (Option<i32>, String, u64) {
    let mut child = conserva(home, arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut most = 0;
    while child.try_wait().unwrap().is_none() {
        let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
        let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")?.split_whitespace().next()?.parse::<u64>().ok());
        most = most.max(peak.unwrap_or(0) / 1000);
        std::thread::sleep(Duration::from_millis(2));
    }
    let output = child.wait_with_output().unwrap();
    (output.status.code(), stderr(&output), most)
}

#[test]
fn what_does_not_fit_is_refused_with_its_figure() {
    let law = "let law = neo_hookean(#{ youngs_modulus: 1.0, poisson_ratio: 0.3, density: 1.0 });\n";
    let cases = [
        (
            "rectangle(#{ size: [1.0, 1.0], cells: [2000, 2000] });",
            "the mesh would have 4000000 cells: it takes about 720 MB of memory, and ",
        ),
        ("rectangle(#{ size: [1.0, 1.0], cells: [400, 400] }).refine(3);", "of memory, and "),
        ("block(#{ size: [1.0, 1.0, 1.0], cells: [100, 100, 100] });", "1000000 cells: it takes about 180 MB"),
        ("polygon(#{ points: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], size: 0.001 });", "of memory, and "),
        (
            "let m = model(\"m\"); m.add_body(\"b\", rectangle(#{ size: [1.0, 1.0], cells: [300, 300] }), law);\n\
             simulate(m, #{ integrator: energy_momentum(), dt: 0.1 });",
            "the model is too large: of 181202 unknowns, it takes about 272 MB of memory, and ",
        ),
    ];
    for (number, (script, told)) in cases.into_iter().enumerate() {
        let home = folder(&format!("too-large-{number}"), &format!("{law}{script}\n"));
        let (code, message, most) = held(&home, &["run", "main.rhai", "--memory", "150MB"]);
        assert_eq!(code, Some(2), "{script}: {message}");
        assert!(message.contains(told) && message.contains("= hint: "), "{script}: {message}");
        assert!(most <= 150, "{script}: {most} MB");
    }
}

#[test]
fn a_factorization_that_does_not_fit_ends_the_run_with_its_results() {
    let script = "let law = neo_hookean(#{ youngs_modulus: 1.0, poisson_ratio: 0.3, density: 1.0 });\n\
                  let m = model(\"m\");\n\
                  let b = m.add_body(\"b\", block(#{ size: [1.0, 1.0, 1.0], cells: [16, 16, 16] }), law);\n\
                  m.gravity([0.0, 0.0, -1.0]);\n\
                  let sim = simulate(m, #{ integrator: energy_momentum(), dt: 0.1, solver: \"direct\" });\n\
                  sim.step();\n";
    let home = folder("factors", script);
    let (code, message, _) = held(&home, &["run", "main.rhai", "--memory", "120MB"]);
    assert_eq!(code, Some(3), "{message}");
    assert!(message.contains("the memory is used up at t = 0: the factorization of 14739 unknowns takes at least"), "{message}");
    assert!(home.join("out/main/summary.json").is_file());
}

#[test]
fn arrays_and_strings_have_one_limit_together() {
    let scripts = [
        "let all = []; loop { let a = []; a.pad(100000, 1.5); all.push(a); }",
        "let all = #{}; let i = 0; loop { let s = \"x\"; s.pad(1000000, 'y'); all[i.to_string()] = s; i += 1; }",
        "let all = []; loop { try { all.push(linspace(0.0, 1.0, 100000)); } catch { } }",
        "fn grow(a) { let b = a; b.pad(b.len() + 100000, 1); grow(b) } grow([])",
    ];
    for (number, script) in scripts.into_iter().enumerate() {
        let home = folder(&format!("arrays-{number}"), script);
        let (code, message, most) = held(&home, &["run", "main.rhai", "--memory", "100MB"]);
        assert_eq!(code, Some(2), "{script}: {message}");
        let told = message.contains("there is no memory left for the script") && message.contains("may take 100 MB together");
        // The last script may end at the call depth before it reaches the limit.
        assert!(told || number == 3, "{script}: {message}");
        assert!(most <= 160, "{script}: {most} MB");
    }
}

#[test]
fn sizes_are_given_with_their_unit() {
    let home = folder("sizes", "print(1);");
    let (code, message, _) = held(&home, &["run", "main.rhai", "--memory", "8"]);
    assert!(code == Some(2) && message.contains("500MB, 8GB"), "{message}");
    for command in [&["check", "main.rhai"][..], &["run", "main.rhai"], &["test", "main.rhai"], &["sweep", "main.rhai", "--vary", "a=1,2"]]
    {
        let (code, message, _) = held(&home, &[command, &["--memory", "1GB"]].concat());
        // The script has no parameter, and is no test with expectations.
        assert!(code == Some(0) || message.contains("has no parameter"), "{command:?}: {message}");
    }
}
