//! Arguments of `conserva sweep` and of its parts.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use crate::cli::memory::MemoryArguments;
use crate::cli::script_arguments::{assignment, threads};
use crate::script::MAX_OPERATIONS;
use crate::studies::{Sampling, Varied};

/// Arguments of `conserva sweep`.
#[derive(Args)]
#[command(args_conflicts_with_subcommands = true, after_long_help = HELP)]
pub struct Arguments {
    #[command(subcommand)]
    pub part: Option<Part>,
    #[command(flatten)]
    pub whole: WholeArguments,
}

const HELP: &str = "\
Examples:
  conserva sweep bearing.rhai --vary dt=0.01,0.005 --vary torque=0.05..0.2:7
  conserva sweep seal.rhai --vary gap=0..0.1 --vary stiffness=1e3..1e6:log --sample sobol:256
  conserva sweep out/seal-sweep --retry failed

A script yields what the table shows with `result(\"peak pressure\", p)`. Each point is a run in a folder of its own; one that fails is a
row with its cause. `conserva sweep` again computes what is missing. Exit code: 0 all points completed, 1 some did not, 3 files could not
be written, 130 interrupted.

On a cluster: `--engine slurm`, or any engine around `conserva sweep plan`, `sweep point` and `sweep collect`, such as
  conserva sweep plan seal.rhai --vary gap=0..0.1:200 --out study
  parallel conserva sweep point study --index {} ::: $(seq 0 199)
  conserva sweep collect study";

/// One of the three parts of a study.
#[derive(Subcommand)]
pub enum Part {
    /// Write the list of points without computing any
    Plan(PlanArguments),
    /// Compute one or several points of a planned study
    Point(PointArguments),
    /// Make table, pictures and page of the points computed so far
    Collect(CollectArguments),
}

/// Arguments of a study as a whole.
#[derive(Args)]
pub struct WholeArguments {
    #[command(flatten)]
    pub design: DesignArguments,
    #[command(flatten)]
    pub compute: ComputeArguments,
}

/// Arguments of `conserva sweep plan`.
#[derive(Args)]
pub struct PlanArguments {
    #[command(flatten)]
    pub design: DesignArguments,
}

/// Design of a study: script and varied values.
#[derive(Args)]
pub struct DesignArguments {
    /// The script, a study file (TOML) beside it, or the folder of a study that is to go on
    #[arg(value_name = "SCRIPT|STUDY.toml|DIR")]
    pub what: Option<PathBuf>,
    /// Values of a parameter: listed (dt=0.01,0.005), a number of them between two ends (torque=0.05..0.2:7, with equal factors
    /// E=1e3..1e6:4:log), or an interval to sample (gap=0..0.1). Every value is combined with every value of the other parameters
    #[arg(long, value_name = "NAME=VALUES")]
    pub vary: Vec<Varied>,
    /// Combine listed values side by side: the first with the first, the second with the second
    #[arg(long)]
    pub zip: bool,
    /// Samples of the intervals: sobol:256 (even) or random:256 (independent)
    #[arg(long, value_name = "METHOD:COUNT")]
    pub sample: Option<Sampling>,
    /// Seed of the samples
    #[arg(long, value_name = "N")]
    pub seed: Option<u32>,
    /// A CSV file of points: a header with names of parameters, and a row for each point
    #[arg(long, value_name = "FILE.csv")]
    pub values: Option<PathBuf>,
    /// Value of a parameter that does not vary
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = assignment)]
    pub fixed: Vec<(String, String)>,
    /// Let the script read files below this folder, too (it may read those below its own)
    #[arg(long, value_name = "DIR")]
    pub allow_read: Vec<PathBuf>,
    /// Operations after which a script counts as endless
    #[arg(long, value_name = "N", default_value_t = MAX_OPERATIONS)]
    pub max_operations: u64,
    /// Abandon a point after this time (30s, 10min, 2h); it counts as failed
    #[arg(long, value_name = "TIME", value_parser = seconds)]
    pub point_time: Option<f64>,
    #[command(flatten)]
    pub memory: MemoryArguments,
    /// Threads of a point's element loop; results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = threads)]
    pub threads: u16,
    /// Folder of the study [default: out/<script name>-sweep]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Compute finished points again: the failed ones, or all
    #[arg(long, value_enum)]
    pub retry: Option<Retry>,
}

/// Which points are computed again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Retry {
    /// Failed points only
    Failed,
    /// All
    All,
}

/// Where and how points are computed.
#[derive(Args)]
pub struct ComputeArguments {
    /// Engine that computes the points
    #[arg(long, value_enum, default_value_t = Engine::Here)]
    pub engine: Engine,
    /// Points computed at a time on this machine [default: one for each processor]
    #[arg(long, value_name = "N", value_parser = threads)]
    pub jobs: Option<u16>,
    /// No progress, no table
    #[arg(long)]
    pub quiet: bool,
    /// Slurm: points of a task
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub per_task: u32,
    /// Slurm: tasks that may run at a time
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub at_once: Option<u32>,
    /// Slurm: time limit of a task, as `sbatch` takes it
    #[arg(long, value_name = "TIME")]
    pub time: Option<String>,
    /// Slurm: memory of a task, as `sbatch` takes it
    #[arg(long, value_name = "SIZE")]
    pub mem: Option<String>,
    /// Slurm: partition
    #[arg(long, value_name = "NAME")]
    pub partition: Option<String>,
    /// Slurm: any other option of `sbatch`, such as --sbatch=--account=bearings
    #[arg(long, value_name = "OPTION", allow_hyphen_values = true)]
    pub sbatch: Vec<String>,
}

/// Engine that computes the points of a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Engine {
    /// This machine
    Here,
    /// Array jobs of Slurm
    Slurm,
}

/// Arguments of `conserva sweep point`.
#[derive(Args)]
pub struct PointArguments {
    /// Folder of the study
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Numbers of the points, from 0 on (`points.csv` lists them): 3, or 0-9,12; `-` reads them from standard input
    #[arg(long, value_name = "K", allow_hyphen_values = true)]
    pub index: String,
    /// Number of points to compute, from `--index` on
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub count: Option<u32>,
}

/// Arguments of `conserva sweep collect`.
#[derive(Args)]
pub struct CollectArguments {
    /// Folder of the study
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// No table
    #[arg(long)]
    pub quiet: bool,
}

/// Parses a time in seconds.
///
/// # Errors
/// The text is not of the expected form; the message describes the form.
pub fn seconds(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let digits = text.trim_end_matches(|letter: char| letter.is_ascii_alphabetic()).trim_end();
    let unit = match text[digits.len()..].trim() {
        "s" => 1.0,
        "min" => 60.0,
        "h" => 3600.0,
        _ => f64::NAN,
    };
    let time = digits.parse::<f64>().ok().map(|count| count * unit).filter(|time| (0.001..1e9).contains(time));
    time.ok_or_else(|| "write a time: 30s, 10min, 2h".into())
}
