//! Processes of the distributed solver: the MPI job of this process, the program of a rank, and its start.

use std::ffi::OsString;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use crate::linear::error::RanksError;

/// Program of a rank (`packages/mumps`).
const PROGRAM: &str = "conserva-mumps";

/// Environment variable with the path of the program of a rank.
const PROGRAM_VARIABLE: &str = "CONSERVA_MUMPS";

/// Environment variable with the command that starts ranks.
const LAUNCHER_VARIABLE: &str = "CONSERVA_MPIRUN";
/// Default of the command that starts ranks, for Open MPI.
const LAUNCHER: &str = "mpirun --oversubscribe --bind-to none";

/// Environment variables of a process that an MPI launcher has started: rank and number of ranks (Open MPI; MPICH, Intel MPI and Slurm with
/// PMI; Slurm with PMIx).
const VARIABLES: [(&str, &str); 3] =
    [("OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"), ("PMI_RANK", "PMI_SIZE"), ("PMIX_RANK", "SLURM_STEP_NUM_TASKS")];

/// Rank of a process in an MPI job, and number of ranks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MpiProcess {
    /// Number of this process, from 0.
    pub rank: u32,
    /// Number of processes of the job.
    pub ranks: u32,
}

impl MpiProcess {
    /// Rank of this process; `None` if it was not started by an MPI launcher.
    pub fn this() -> Option<Self> {
        Self::among(&|name| std::env::var(name).ok())
    }

    fn among(variable: &dyn Fn(&str) -> Option<String>) -> Option<Self> {
        let number = |name: &str| variable(name)?.parse().ok();
        let known = VARIABLES.iter().filter_map(|(rank, ranks)| Some(MpiProcess { rank: number(rank)?, ranks: number(ranks)? }));
        known.into_iter().find(|process| process.rank < process.ranks)
    }
}

/// Path of the program of a rank: as the environment says, beside this program, or on the search path.
fn program() -> Result<PathBuf, RanksError> {
    if let Some(given) = std::env::var_os(PROGRAM_VARIABLE) {
        return Some(PathBuf::from(given)).filter(|path| path.is_file()).ok_or(RanksError::NoProgram);
    }
    let beside = std::env::current_exe().ok().and_then(|own| own.parent().map(Path::to_path_buf));
    let searched = std::env::var_os("PATH").unwrap_or_default();
    let mut folders = beside.into_iter().chain(std::env::split_paths(&searched));
    folders.find_map(|folder| Some(folder.join(PROGRAM)).filter(|path| path.is_file())).ok_or(RanksError::NoProgram)
}

/// Replaces this process, whose rank is not 0, by the program of a rank. Returns only on failure.
pub fn become_rank() -> RanksError {
    match program() {
        Ok(program) => {
            let _ = Command::new(program).exec();
            RanksError::NotStarted
        }
        Err(error) => error,
    }
}

/// Starts rank 0 of the MPI job of this process, or all ranks if this process belongs to none. They connect to a socket.
pub(super) fn start(ranks: u32, socket: &Path) -> Result<Child, RanksError> {
    let program = program()?;
    let mut command = if MpiProcess::this().is_some() || ranks <= 1 {
        Command::new(program)
    } else {
        let launcher = std::env::var(LAUNCHER_VARIABLE).unwrap_or_else(|_| LAUNCHER.into());
        let mut words = launcher.split_whitespace();
        let mut command = Command::new(words.next().ok_or(RanksError::NoLauncher)?);
        command.args(words).args([OsString::from("-n"), ranks.to_string().into(), program.into()]);
        // The interrupt key of the terminal is for this process, which ends the ranks.
        command.process_group(0);
        command
    };
    command.arg(socket).stdin(Stdio::null()).stdout(Stdio::null());
    command.spawn().map_err(|_| if ranks > 1 { RanksError::NoLauncher } else { RanksError::NotStarted })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_place_in_a_job_is_known_for_every_launcher() {
        let place = |given: &[(&str, &str)]| {
            MpiProcess::among(&|name| given.iter().find(|(known, _)| *known == name).map(|(_, value)| (*value).to_string()))
        };
        assert_eq!(place(&[("OMPI_COMM_WORLD_RANK", "2"), ("OMPI_COMM_WORLD_SIZE", "4")]), Some(MpiProcess { rank: 2, ranks: 4 }));
        assert_eq!(place(&[("PMI_RANK", "0"), ("PMI_SIZE", "1")]), Some(MpiProcess { rank: 0, ranks: 1 }));
        assert_eq!(place(&[("PMIX_RANK", "7"), ("SLURM_STEP_NUM_TASKS", "64")]), Some(MpiProcess { rank: 7, ranks: 64 }));
        for other in [&[][..], &[("SLURM_PROCID", "0"), ("SLURM_STEP_NUM_TASKS", "64")], &[("PMI_RANK", "4"), ("PMI_SIZE", "4")]] {
            assert_eq!(place(other), None, "{other:?}");
        }
    }
}
