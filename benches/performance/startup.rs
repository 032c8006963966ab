//! Time of whole processes: start of the prompt, a ten-line script, the bearing up to its first step; and the bearing's peak memory, if the
//! system reports it.

use std::error::Error;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

const TEN_LINES: &str = r#"let rubber = neo_hookean(#{ youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 });
let free = model("bar");
let bar = free.add_body("bar", rectangle(#{ size: [2.0, 1.0], cells: [8, 4] }), rubber);
free.initial_velocity(bar, #{ linear: [1.0, 0.0], angular: 2.0 });
let sim = simulate(free, #{ integrator: energy_momentum(), dt: 0.05 });
sim.run_to(0.5);
print(sim.momentum);
print(sim.angular_momentum);
expect_conserved(sim, "energy", #{ tolerance: 1e-10 });
expect_conserved(sim, "momentum", #{ tolerance: 1e-10 });
"#;

/// Minimum time of some repetitions of a process, which must succeed `[ms]`.
fn least(program: &mut Command, repetitions: usize) -> Result<f64, Box<dyn Error>> {
    let mut least = f64::INFINITY;
    for _ in 0..repetitions {
        let clock = Instant::now();
        let output = program.stdin(Stdio::null()).output()?;
        if !output.status.success() {
            return Err(format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr)).into());
        }
        least = least.min(1e3 * clock.elapsed().as_secs_f64());
    }
    Ok(least)
}

/// Prints the times.
pub fn times(repetitions: usize) -> Result<(), Box<dyn Error>> {
    let program = Path::new(env!("CARGO_BIN_EXE_conserva"));
    let folder = std::env::temp_dir().join(format!("conserva-startup-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let script = folder.join("ten_lines.rhai");
    std::fs::write(&script, TEN_LINES)?;
    let bearing = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/scenarios/bearing.rhai");
    let out = folder.join("out");
    let version = least(Command::new(program).arg("--version"), repetitions)?;
    let ten_lines = least(Command::new(program).arg("run").arg(&script).arg("--quiet").arg("--out").arg(&out), repetitions)?;
    let mut first_step = Command::new(program);
    first_step.arg("run").arg(&bearing).args(["--quiet", "--set", "until=0.005"]).arg("--out").arg(&out);
    let first_step = least(&mut first_step, repetitions)?;
    println!("whole processes, ms: --version {version:.1}, ten lines {ten_lines:.1}, bearing with one step and its output {first_step:.1}");
    std::fs::remove_dir_all(&folder)?;
    Ok(())
}
