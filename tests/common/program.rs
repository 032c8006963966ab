//! The program from outside, as the tests of its commands start it.

// Each test program uses its part of it.
#![allow(dead_code)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// An empty folder of its own for a test.
pub fn empty_folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{}-{name}", env!("CARGO_CRATE_NAME")));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// A folder of its own for a test, with a script in it.
pub fn folder(name: &str, script: &str) -> PathBuf {
    let folder = empty_folder(name);
    std::fs::write(folder.join("main.rhai"), script).unwrap();
    folder
}

/// The program, to be started in a folder.
pub fn conserva(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_conserva"));
    command.current_dir(folder).args(arguments).env_remove("NO_COLOR");
    command
}

/// What it printed, when it has ended.
pub fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// Its messages.
pub fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}
