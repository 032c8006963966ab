//! The program as a process, for the tests of its commands.

// Each test program uses a part of this file.
#![allow(dead_code)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// New empty folder for a test.
pub fn empty_folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{}-{name}", env!("CARGO_CRATE_NAME")));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// New folder for a test, with a script in it.
pub fn folder(name: &str, script: &str) -> PathBuf {
    let folder = empty_folder(name);
    std::fs::write(folder.join("main.rhai"), script).unwrap();
    folder
}

/// Command of the program in a folder, not yet started.
pub fn conserva(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_conserva"));
    command.current_dir(folder).args(arguments).env_remove("NO_COLOR");
    command
}

/// Standard output of an ended process.
pub fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// Standard error of an ended process.
pub fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}
