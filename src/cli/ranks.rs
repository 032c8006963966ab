//! The linear solver of a run, and its processes: with `mpirun -n 4 conserva run … --solver mumps` the first process computes the run, and
//! the others become ranks of the solver.

use clap::Args;

use super::console::{complain, ink};
use super::process::exit_code;
use crate::linear::SolverChoice;
use crate::script::{Class, Diagnostic};

/// Arguments on the linear solver.
#[derive(Args)]
pub struct SolverArguments {
    /// Linear solver in place of the script's choice: auto, direct, iterative, or mumps (see docs/distributed.md)
    #[arg(long, value_name = "NAME", value_parser = SolverChoice::ALL.map(|(name, _)| name))]
    solver: Option<String>,
    /// Processes of the solver mumps, which are started by mpirun
    #[arg(long, value_name = "N", requires = "solver", value_parser = clap::value_parser!(u16).range(1..))]
    ranks: Option<u16>,
}

impl SolverArguments {
    /// Returns the solver that replaces the script's choice.
    pub fn choice(&self) -> Option<SolverChoice> {
        let name = self.solver.as_ref()?;
        let (_, choice) = SolverChoice::ALL.into_iter().find(|(known, _)| known == name)?;
        Some(match choice {
            SolverChoice::Mumps { .. } => SolverChoice::Mumps { ranks: self.ranks.unwrap_or(0) },
            choice => choice,
        })
    }

    /// Makes a process of an MPI job that is not the first one a rank of the solver, and returns in the first one.
    ///
    /// # Errors
    /// The exit code: the job has several processes, but no solver for them, or their program is not installed.
    pub fn join_job(&self) -> Result<(), u8> {
        #[cfg(unix)]
        if let Some(process) = crate::linear::MpiProcess::this().filter(|process| process.ranks > 1) {
            self.check_job(process.ranks).map_err(|error| refused(&error, process.rank == 0))?;
            if process.rank > 0 {
                let error = crate::linear::become_rank();
                // The first process reports what is missing on its machine, which ends this one.
                std::thread::sleep(std::time::Duration::from_secs(2));
                let error =
                    Diagnostic::error(Class::Numerics, format!("rank {}: {error}", process.rank)).code(error.code()).hint(error.hint());
                return Err(refused(&error, true));
            }
        }
        Ok(())
    }

    /// Refuses a job whose processes the solver does not use.
    fn check_job(&self, ranks: u32) -> Result<(), Box<Diagnostic>> {
        let refusal = |title: String| Diagnostic::error(Class::Script, title).code("C0529");
        if !matches!(self.choice(), Some(SolverChoice::Mumps { .. })) {
            let error = refusal(format!("MPI has started {ranks} processes, each of which would compute the whole run"));
            return Err(Box::new(error.hint("add `--solver mumps`, whose matrices they share, or start one process")));
        }
        match self.ranks {
            Some(wanted) if u32::from(wanted) != ranks => {
                let error = refusal(format!("MPI has started {ranks} processes, and `--ranks` asks for {wanted}"));
                Err(Box::new(error.hint("leave out `--ranks`, or leave the start of processes to it")))
            }
            _ => Ok(()),
        }
    }
}

fn refused(error: &Diagnostic, has_voice: bool) -> u8 {
    if has_voice {
        complain(&error.render(ink()));
    }
    exit_code(error.class)
}

/// True if this process belongs to an MPI job and is not its first one, which alone writes to the terminal.
pub fn is_served() -> bool {
    #[cfg(unix)]
    return crate::linear::MpiProcess::this().is_some_and(|process| process.rank > 0);
    #[cfg(not(unix))]
    return false;
}

/// Ends the ranks of the solver.
pub fn end() {
    #[cfg(unix)]
    crate::linear::end_ranks();
}

/// Returns an explanation of the interrupt of a process of an MPI job: launchers end all processes if one is lost.
pub fn told_by_launcher(error: &Diagnostic) -> Option<&'static str> {
    #[cfg(unix)]
    if error.class == Class::Interrupted && crate::linear::MpiProcess::this().is_some_and(|process| process.ranks > 1) {
        return Some("= cause: the launcher of MPI has ended the job, because a rank was lost or the job was stopped; it tells which\n");
    }
    None
}
