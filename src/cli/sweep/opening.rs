//! Common start of the parts of `conserva sweep`: the interrupt key, the study, the folder to which its paths are relative.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::cli::signals::interrupt;
use crate::script::{Class, Diagnostic};
use crate::studies::{Plan, StudyFolder};

/// The flag of the interrupt key.
pub fn interrupted() -> Result<Arc<AtomicBool>, Box<Diagnostic>> {
    interrupt().map_err(|error| {
        let refused = Diagnostic::error(Class::Internal, "the interrupt key cannot be watched");
        Box::new(refused.cause(error.to_string()))
    })
}

/// Changes to the folder in which a study was planned, to which its paths are relative.
pub fn enter(plan: &Plan) -> Result<(), Box<Diagnostic>> {
    let folder = &plan.scenario.folder;
    std::env::set_current_dir(folder).map_err(|error| {
        let refused =
            Diagnostic::error(Class::Script, format!("the folder {} cannot be entered", folder.display())).cause(error.to_string());
        Box::new(refused.hint("the study was planned there, and the paths of its script and files are relative to it"))
    })
}

/// Returns a study's folder (by its absolute path) and its plan.
pub fn opened(path: &Path) -> Result<(StudyFolder, Plan), Box<Diagnostic>> {
    let path = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    let study = StudyFolder::open(&path)?;
    let plan = study.plan()?;
    Ok((study, plan))
}
