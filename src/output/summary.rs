//! `summary.json`: a run in numbers, for programs that compare runs.
//!
//! Drifts are deviations of the conserved quantities since the loads ended, relative to a scale of the problem, so that round-off is not
//! judged relative to a zero momentum. Steps are recorded in `history.csv`.

use std::collections::BTreeMap;
use std::time::Duration;

use serde::{Serialize, Serializer};

use crate::dynamics::{BodyDefinition, EnergyAccount, Halving, LedgerRow, Model, PhaseTimes, Rows, RunFinding, Statistics};
use crate::linear::SolverCalls;

/// Name of the file.
pub const SUMMARY: &str = "summary.json";
/// Outcome of a run that ended normally.
pub const COMPLETED: &str = "completed";
/// Outcome of a run that ended normally, but whose integrator changed the energy.
pub const NOT_CONSERVING: &str = "not conserving";

/// Content of `summary.json`; the names of the fields are those of the file.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Summary {
    /// Path of the script.
    pub script: String,
    /// Values of `param(...)` by name.
    pub parameters: BTreeMap<String, serde_json::Value>,
    /// Units of the parameters that have one, by name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub parameter_units: BTreeMap<String, String>,
    /// Results of the script from `result(...)`, in the order of the calls.
    #[serde(serialize_with = "in_order")]
    pub results: Vec<(String, serde_json::Value)>,
    /// Units of the results that have one, by name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub result_units: BTreeMap<String, String>,
    /// Version of the program.
    pub version: String,
    /// Units of mass, length, time, force, stress and energy; `None` where the script declares none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub units: Option<BTreeMap<&'static str, String>>,
    /// Number of bodies.
    pub bodies: usize,
    /// Number of free displacement components.
    pub unknowns: usize,
    /// Accepted steps.
    pub steps: usize,
    /// Newton iterations, including those of refused steps.
    pub newton_iterations: usize,
    /// Number of halvings.
    pub halvings: usize,
    /// Numeric factorizations.
    pub factorizations: usize,
    /// Linear solver: `direct`, `iterative` or `mumps`, with `direct` where the direct one took over.
    pub solver: &'static str,
    /// Iterations of the iterative solver.
    pub solver_iterations: usize,
    /// Largest memory of each rank of the distributed solver.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rank_memory_bytes: Vec<u64>,
    /// Wall-clock time by phase.
    pub wall_seconds: WallSeconds,
    /// Largest resident memory of the process, if the system reports it.
    pub peak_memory_bytes: Option<u64>,
    /// See [`Drifts::energy`].
    pub energy_drift: Option<f64>,
    /// See [`Drifts::unexplained_energy`].
    pub energy_unexplained: Option<f64>,
    /// See [`Drifts::momentum`].
    pub momentum_drift: Option<f64>,
    /// See [`Drifts::angular_momentum`].
    pub angular_momentum_drift: Option<f64>,
    /// See [`Drifts::worst_energy_defect`].
    pub worst_energy_defect: Option<f64>,
    /// Energy changes beyond round-off, by cause.
    pub energy_changes: BTreeMap<&'static str, EnergyChange>,
    /// Halvings by cause, including those of steps that were not tried.
    pub halvings_by_cause: BTreeMap<String, usize>,
    /// Findings of the run.
    pub findings: Vec<FindingRecord>,
    /// [`COMPLETED`], [`NOT_CONSERVING`], `interrupted`, or the title of the error.
    pub outcome: String,
}

/// Keys of the file in their order, with descriptions.
pub const KEYS: &[(&str, &str)] = &[
    ("script", "the path of the script"),
    ("parameters", "the values of `param(...)` by name"),
    ("parameter_units", "an object: the units of the parameters for which `param` was given one"),
    ("results", "what the script yields with `result(...)` by name; numbers that are not finite are the texts `NaN`, `inf` and `-inf`"),
    ("result_units", "an object: the units of the results for which `result` was given one"),
    ("version", "the version of the program"),
    ("units", "an object: the units of mass, length, time, force, stress and energy, where the script has declared them"),
    ("bodies", "the number of bodies"),
    ("unknowns", "the number of free displacement components"),
    ("steps", "the number of accepted steps"),
    ("newton_iterations", "the Newton iterations, those of refused steps included"),
    ("halvings", "halvings of steps that were tried"),
    ("factorizations", "the number of numeric factorizations"),
    ("solver", "the linear solver: `direct`, `iterative` or `mumps`, followed by `, direct` where the direct one had to take over"),
    ("solver_iterations", "the iterations of the iterative solver"),
    ("rank_memory_bytes", "an array, with the solver `mumps`: the largest memory of MUMPS on each rank"),
    ("wall_seconds", "an object: where the time went, `total` and its parts [s]"),
    ("peak_memory_bytes", "the largest resident memory of the process, where the system tells"),
    ("energy_drift", "the largest change of the total energy since the loads ended, relative to the largest energy since then"),
    (
        "energy_unexplained",
        "the same of what neither loads nor contact nor friction nor dissipation explain: the largest sum of energy defects since then",
    ),
    ("momentum_drift", "the same for the linear momentum, less what supports explain"),
    ("angular_momentum_drift", "the same for the angular momentum"),
    ("worst_energy_defect", "the largest energy defect of a step, relative to the largest kinetic + strain + |potential| of the run"),
    (
        "energy_changes",
        "an object: what changed the energy beyond round-off (`loads`, `contact`, `friction`, `viscosity`, `plastic flow`, `dampers`, \
         `numerical damping`, `impacts`, `integrator`, `settling`), each with `energy`, positive where it was given, and its `share` of \
         the largest energy",
    ),
    (
        "halvings_by_cause",
        "an object: all halvings by cause; `sliding`, `approach` and `passing` were foreseen, `came_through` was seen after convergence, \
         `error_too_large` counts steps that chose too large a size, the others followed a failure of Newton's method",
    ),
    (
        "findings",
        "an array of the findings of the run, each with `kind`, `contact` (or null), `value` and its `limit`, the `step` and its `time`, \
         and a `message`",
    ),
    (
        "outcome",
        "`completed`, `not conserving` (completed, but its integrator changed the energy), `interrupted`, or the title of the error",
    ),
];

/// Energy change by one cause, as written to the file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EnergyChange {
    /// Energy added to the system `[energy]`; negative if removed.
    pub energy: f64,
    /// Energy change relative to the largest energy of the run.
    pub share: f64,
}

/// A finding of the run, as written to the file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FindingRecord {
    /// Stable name of the kind.
    pub kind: &'static str,
    /// Contact of the finding.
    pub contact: Option<String>,
    /// Value of the finding.
    pub value: f64,
    /// Threshold of the value above which the finding is reported.
    pub limit: f64,
    /// Time of the finding `[time]`.
    pub time: f64,
    /// Accepted step of the finding.
    pub step: usize,
    /// Description of the finding with its numbers.
    pub message: String,
}

impl From<&RunFinding> for FindingRecord {
    fn from(finding: &RunFinding) -> Self {
        let RunFinding { kind, contact, value, limit, step, time, explanation } = finding;
        let (kind, contact, message) = (kind.name(), contact.clone(), format!("{finding}: {explanation}"));
        FindingRecord { kind, contact, value: *value, limit: *limit, time: *time, step: *step, message }
    }
}

/// Serializes pairs as an object in this order.
fn in_order<S: Serializer>(pairs: &[(String, serde_json::Value)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(pairs.iter().map(|(name, value)| (name, value)))
}

impl Summary {
    /// Sets the counters from a simulation; `rank_bytes`: memory of the ranks of a distributed solver.
    pub fn count(&mut self, statistics: &Statistics, rank_bytes: &[u64]) {
        self.steps = statistics.steps;
        self.newton_iterations = statistics.newton_iterations;
        self.halvings = statistics.halvings;
        self.factorizations = statistics.factorizations;
        let SolverCalls { factorizations, iterations } = statistics.solver_calls;
        self.solver = match (iterations, factorizations) {
            _ if !rank_bytes.is_empty() && statistics.taken_over.unconverged > 0 => "mumps, direct",
            _ if !rank_bytes.is_empty() => "mumps",
            (0, _) => "direct",
            (_, 0) => "iterative",
            _ => "iterative, direct",
        };
        self.solver_iterations = iterations;
        self.rank_memory_bytes = rank_bytes.to_vec();
    }

    /// Sets the drifts.
    pub fn judge(&mut self, drifts: &Drifts) {
        self.energy_drift = drifts.energy;
        self.energy_unexplained = drifts.unexplained_energy;
        self.momentum_drift = drifts.momentum;
        self.angular_momentum_drift = drifts.angular_momentum;
        self.worst_energy_defect = drifts.worst_energy_defect;
    }

    /// Sets the energy changes.
    pub fn book(&mut self, account: &EnergyAccount) {
        let change = |(cause, energy): (&'static str, f64)| {
            (cause.trim_start_matches("the "), EnergyChange { energy, share: energy / account.scale })
        };
        self.energy_changes = account.changes().into_iter().map(change).collect();
    }

    /// Sets findings and causes of halvings.
    pub fn tell(&mut self, findings: &[RunFinding], halvings: &[Halving]) {
        self.findings = findings.iter().map(FindingRecord::from).collect();
        for Halving { cause, count, .. } in halvings {
            *self.halvings_by_cause.entry(cause.replace(' ', "_")).or_default() += count;
        }
    }

    /// Returns the text of the file. Numbers that are not finite become `null`.
    pub fn to_json(&self) -> String {
        // Strings, numbers and maps with string keys always have a JSON form.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}

/// Wall-clock time by phase `[s]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct WallSeconds {
    /// Time from the start of the program to the summary.
    pub total: f64,
    /// Element loop.
    pub assembly: f64,
    /// Contact functions.
    pub contact: f64,
    /// Factorizations.
    pub factorization: f64,
    /// Linear solves.
    pub solve: f64,
    /// Contact search.
    pub search: f64,
    /// Writing of files.
    pub output: f64,
    /// Statements and closures of the script.
    pub script: f64,
    /// Remaining wall-clock time `[s]`.
    pub other: f64,
}

impl WallSeconds {
    /// Returns the times of solver, output and script; `other` is the remainder of `total`.
    pub fn new(total: Duration, phases: &PhaseTimes, output: Duration, script: Duration) -> Self {
        let PhaseTimes { assembly, contact, factorization, solve, search } = *phases;
        let known = assembly + contact + factorization + solve + search + output + script;
        WallSeconds {
            total: total.as_secs_f64(),
            assembly: assembly.as_secs_f64(),
            contact: contact.as_secs_f64(),
            factorization: factorization.as_secs_f64(),
            solve: solve.as_secs_f64(),
            search: search.as_secs_f64(),
            output: output.as_secs_f64(),
            script: script.as_secs_f64(),
            other: total.saturating_sub(known).as_secs_f64(),
        }
    }
}

/// Largest resident memory of this process in bytes, if the system reports it (Linux).
pub fn peak_memory_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let kilobytes = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    kilobytes.split_whitespace().next()?.parse::<u64>().ok().map(|count| count * 1024)
}

/// Mass and size of a model, the scales of linear and angular momentum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia {
    /// Mass of all bodies `[mass]`.
    pub mass: f64,
    /// Largest distance of an undeformed point from the origin `[length]`.
    pub radius: f64,
}

impl Inertia {
    /// Returns mass and size of a model.
    pub fn of(model: &Model) -> Self {
        let bodies = || model.bodies.iter();
        let points = bodies().flat_map(|body| &body.mesh.points);
        Inertia {
            mass: bodies().map(BodyDefinition::mass).sum(),
            radius: points.map(|[x, y, z]| x.hypot(*y).hypot(*z)).fold(0.0, f64::max),
        }
    }
}

/// Drifts of the conserved quantities; `None` where there is nothing to compare.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Drifts {
    /// Largest change of the total energy since the loads ended, contact work included, over the largest `kinetic + strain + |potential|`
    /// since then.
    pub energy: Option<f64>,
    /// Largest sum of energy defects since the loads ended, not explained by loads, contact or dissipation, relative to the largest
    /// `kinetic + strain + |potential|` since then.
    pub unexplained_energy: Option<f64>,
    /// Largest change of the linear momentum since the loads ended, less what supports explain, over the largest of `|p|` and
    /// `sqrt(2 mass kinetic)`, which bounds `|p|` from above. Without [`Inertia`]: over the largest `|p|`.
    pub momentum: Option<f64>,
    /// Largest change of the angular momentum since the loads ended, less contributions of supports, relative to `radius` times the scale
    /// of the linear momentum.
    pub angular_momentum: Option<f64>,
    /// Largest `|energy_defect|` of a step, over the largest `kinetic + strain + |potential|` of the run.
    pub worst_energy_defect: Option<f64>,
}

/// Returns the drifts of a run whose last load acted until `loads_ended`; rows are in ascending order of time.
///
/// Momenta may change where a support holds a body. The part not explained by loads and reactions is booked in the ledger's defects in each
/// step; the drift is the smaller one of the plain change and of the sum of the defects.
pub fn drifts<R: Rows + ?Sized>(rows: &R, loads_ended: f64, inertia: Option<Inertia>) -> Drifts {
    let length = |[x, y, z]: [f64; 3]| x.hypot(y).hypot(z);
    let [mut scale, mut worst, mut kinetic, mut momentum, mut angular] = [0.0; 5];
    // Last row at or before the end of the loads; an equilibrium adds a second row at the same time.
    let (mut index, mut first) = (0, None);
    rows.visit(0, &mut |row| {
        raise(&mut scale, row.energy_scale());
        raise(&mut worst, row.energy_defect.abs());
        raise(&mut kinetic, row.kinetic);
        raise(&mut momentum, length(row.momentum));
        raise(&mut angular, length(row.angular_momentum));
        first = if row.time <= loads_ended { Some(index) } else { first };
        index += 1;
    });
    let worst_energy_defect = Some(relative(worst, scale)).filter(|_| index > 1);
    let Some(first) = first.filter(|first| first + 1 < index) else { return Drifts { worst_energy_defect, ..Drifts::default() } };
    let mut since: Option<LedgerRow> = None;
    let [mut energy, mut energy_scale, mut booked, mut unexplained] = [0.0; 4];
    let mut changes = [[0.0; 2]; 2];
    rows.visit(first, &mut |row| {
        raise(&mut energy_scale, row.energy_scale());
        let Some(since) = &since else {
            since = Some(row.clone());
            return;
        };
        raise(&mut energy, (row.total() - since.total()).abs());
        booked += row.energy_defect;
        raise(&mut unexplained, f64::abs(booked));
        let momenta = [(row.momentum, since.momentum), (row.angular_momentum, since.angular_momentum)];
        let defects = [row.momentum_defect, row.angular_momentum_defect];
        for (([plain, unexplained], (now, start)), defect) in changes.iter_mut().zip(momenta).zip(defects) {
            raise(plain, length([now[0] - start[0], now[1] - start[1], now[2] - start[2]]));
            *unexplained += defect.abs();
        }
    });
    let [momentum_change, angular_change] = changes.map(|[plain, unexplained]| if unexplained < plain { unexplained } else { plain });
    let speed_scale = inertia.map_or(0.0, |inertia| (2.0 * inertia.mass * kinetic).max(0.0).sqrt());
    let momentum_scale = f64::max(momentum, speed_scale);
    let angular_scale = f64::max(angular, speed_scale * inertia.map_or(0.0, |inertia| inertia.radius));
    Drifts {
        energy: Some(relative(energy, energy_scale)),
        unexplained_energy: Some(relative(unexplained, energy_scale)),
        momentum: Some(relative(momentum_change, momentum_scale)),
        angular_momentum: Some(relative(angular_change, angular_scale)),
        worst_energy_defect,
    }
}

/// Sets `most` to the maximum. Unlike `f64::max` this keeps a NaN: a diverged run must not look perfect.
fn raise(most: &mut f64, value: f64) {
    if value > *most || value.is_nan() {
        *most = value;
    }
}

/// Returns `part / scale`; 0 for `0 / 0`.
fn relative(part: f64, scale: f64) -> f64 {
    if part == 0.0 { 0.0 } else { part / scale }
}

#[cfg(test)]
mod tests {
    use super::super::samples::{block, rows};
    use super::*;
    use crate::dynamics::{BodyDefinition, RunFindingKind};
    use crate::materials::NeoHookean;

    #[test]
    fn keys_are_those_of_the_language() {
        let drifts = Drifts { energy: Some(1e-13), momentum: Some(f64::NAN), ..Drifts::default() };
        let phases = PhaseTimes { solve: Duration::from_millis(250), ..PhaseTimes::default() };
        let mut summary = Summary {
            script: "bearing.rhai".into(),
            parameters: [("dt".into(), 0.005.into()), ("held".into(), true.into())].into(),
            parameter_units: [("dt".into(), "s".into())].into(),
            wall_seconds: WallSeconds::new(Duration::from_secs(1), &phases, Duration::from_millis(125), Duration::ZERO),
            outcome: "completed".into(),
            units: Some([("mass", "kg".to_string())].into()),
            results: [("peak".into(), 2.5.into())].into(),
            result_units: [("peak".into(), "MPa".into())].into(),
            ..Summary::default()
        };
        summary.judge(&drifts);
        let counted = Statistics { steps: 400, newton_iterations: 1600, halvings: 1, factorizations: 1601, ..Statistics::default() };
        summary.count(&Statistics { times: phases, ..counted }, &[127_000_000, 73_000_000]);
        let halving = |cause, count| Halving { cause, motion: None, count, step: 0, time: 0.0, dt: 0.1 };
        let finding = RunFinding {
            kind: RunFindingKind::Depth,
            contact: Some("race".into()),
            value: 0.25,
            limit: 0.1,
            step: 3,
            time: 0.015,
            explanation: "nodes lie deep".into(),
        };
        summary.tell(&[finding], &[halving("sliding", 2), halving("inverted cell", 1), halving("sliding", 3)]);
        let keys: Vec<String> =
            summary.to_json().lines().filter_map(|line| Some(line.strip_prefix("  \"")?.split_once('"')?.0.to_string())).collect();
        assert_eq!(keys, KEYS.iter().map(|(key, _)| *key).collect::<Vec<_>>());
        insta::assert_snapshot!(summary.to_json(), @r#"
        {
          "script": "bearing.rhai",
          "parameters": {
            "dt": 0.005,
            "held": true
          },
          "parameter_units": {
            "dt": "s"
          },
          "results": {
            "peak": 2.5
          },
          "result_units": {
            "peak": "MPa"
          },
          "version": "",
          "units": {
            "mass": "kg"
          },
          "bodies": 0,
          "unknowns": 0,
          "steps": 400,
          "newton_iterations": 1600,
          "halvings": 1,
          "factorizations": 1601,
          "solver": "mumps",
          "solver_iterations": 0,
          "rank_memory_bytes": [
            127000000,
            73000000
          ],
          "wall_seconds": {
            "total": 1.0,
            "assembly": 0.0,
            "contact": 0.0,
            "factorization": 0.0,
            "solve": 0.25,
            "search": 0.0,
            "output": 0.125,
            "script": 0.0,
            "other": 0.625
          },
          "peak_memory_bytes": null,
          "energy_drift": 1e-13,
          "energy_unexplained": null,
          "momentum_drift": null,
          "angular_momentum_drift": null,
          "worst_energy_defect": null,
          "energy_changes": {},
          "halvings_by_cause": {
            "inverted_cell": 1,
            "sliding": 5
          },
          "findings": [
            {
              "kind": "depth",
              "contact": "race",
              "value": 0.25,
              "limit": 0.1,
              "time": 0.015,
              "step": 3,
              "message": "the sides of contact \"race\" overlap: nodes lie deep"
            }
          ],
          "outcome": "completed"
        }
        "#);
    }

    #[test]
    fn drifts_compare_with_the_row_at_which_the_loads_ended() {
        let mut rows = rows();
        rows[300].kinetic += 0.001;
        rows[300].energy_defect = -0.001;
        rows[301].energy_defect = 0.0005;
        rows[200].angular_momentum[2] -= 0.003;
        let found = drifts(&rows, 0.5, None);
        let total = 0.05;
        // Round-off of sums of two numbers of the size of the total.
        assert!((found.energy.unwrap() - 0.001 / (total + 0.001)).abs() < 1e-14);
        assert!((found.worst_energy_defect.unwrap() - 0.001 / (total + 0.001)).abs() < 1e-14);
        assert_eq!(found.momentum, Some(0.0));
        assert_eq!(found.angular_momentum, Some(0.0), "no step books a defect, so a reaction explains the change");
        rows[200].angular_momentum_defect = 0.003;
        rows[201].angular_momentum_defect = 0.003;
        // The plain change (0.003) is below the sum of the defects (0.006); the scale is the largest angular momentum (0.03).
        assert!((drifts(&rows, 0.5, None).angular_momentum.unwrap() - 0.1).abs() < 1e-14);
    }

    #[test]
    fn nothing_to_compare_gives_none() {
        let rows = rows();
        assert_eq!(drifts::<[LedgerRow]>(&[], 0.0, None), Drifts::default());
        assert_eq!(drifts(&rows[..1], 0.0, None), Drifts::default());
        let loaded = drifts(&rows[..50], rows[49].time, None);
        assert_eq!(loaded, Drifts { worst_energy_defect: Some(0.0), ..Drifts::default() });
        let rest = vec![LedgerRow::default(), LedgerRow { step: 1, time: 1.0, ..LedgerRow::default() }];
        assert_eq!(drifts(&rest, 0.0, None).energy, Some(0.0), "a body at rest keeps its energy");
    }

    #[test]
    fn the_state_after_settling_is_the_reference() {
        let row = |time: f64, strain: f64| LedgerRow { time, strain, ..LedgerRow::default() };
        assert_eq!(drifts(&[row(0.0, 5.0), row(0.0, 1.0), row(0.1, 1.0)][..], 0.0, None).energy, Some(0.0));
    }

    #[test]
    fn a_broken_run_has_no_drift_of_zero() {
        let mut rows = rows();
        rows[300].kinetic = f64::NAN;
        rows[301].momentum[0] = f64::NAN;
        rows[301].momentum_defect = f64::NAN;
        let found = drifts(&rows, 0.5, None);
        assert!(found.energy.unwrap().is_nan() && found.momentum.unwrap().is_nan());
    }

    #[test]
    fn round_off_in_a_momentum_that_vanishes_is_small() {
        let mut rows = rows();
        for row in &mut rows {
            row.momentum[0] = 1e-16 * (row.step % 3) as f64;
            row.momentum_defect = 1e-16;
        }
        assert!(drifts(&rows, 0.5, None).momentum.unwrap() > 0.4, "without a scale it is all there is");
        let inertia = Inertia { mass: 8e-3, radius: 1.5 };
        assert!(drifts(&rows, 0.5, Some(inertia)).momentum.unwrap() < 2e-14, "2e-16 over sqrt(2 * 8e-3 * 0.034)");
    }

    #[test]
    fn inertia_is_that_of_the_meshes() {
        let material = NeoHookean { youngs_modulus: 1.0, poisson_ratio: 0.3, density: 2.0 }.material().unwrap();
        let definition = |body: crate::dynamics::BodyFields| BodyDefinition {
            name: body.name,
            mesh: body.mesh,
            material: material.clone(),
            formulation: Default::default(),
            rigid: None,
        };
        let bodies = vec![definition(block([3, 2, 2], [3.0, 1.0, 0.5])), definition(block([1, 1, 1], [1.0, 1.0, 1.0]))];
        let found = Inertia::of(&Model { bodies, ..Model::default() });
        // Volumes 1.5 and 1 with density 2, by quadrature; the far corner of the first block.
        assert!((found.mass - 5.0).abs() < 1e-14);
        assert!((found.radius - (9.0f64 + 1.0 + 0.25).sqrt()).abs() < 1e-15);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn peak_memory_is_at_least_that_of_a_small_program() {
        assert!(peak_memory_bytes().unwrap() > 1 << 20);
    }
}
