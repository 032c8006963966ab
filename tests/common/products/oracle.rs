//! Oracles for the run of any product, evaluated from its printed lines and its files.
//!
//! Ledger and sums, momenta, signs of works, friction cone, constraints, penetration, exit code against outcome, and agreement of the
//! history with the printed state, the frames and the summary. No function here calls a kernel.

use std::path::Path;

use conserva::integrators;
use conserva::output::{Table, read_table};
use conserva::script::Class;

use super::agreement::agreement;
use super::geometry::Frame;
use super::numbers::Numbers;
use super::run::Ended;
use super::script::{self, LEFT, SIZE};
use super::{Named, told};

/// Largest energy defect of a step of a conserving scheme over the energy of the run, and momentum defect over the momentum.
pub const DEFECT: f64 = 1e-11;
/// Round-off of sums and signs, over the energy of the run.
const ROUND_OFF: f64 = 1e-12;
/// Least energy and momentum scale of a run with motion: masses, speeds and loads are of order one, and a model at rest has round-off of
/// forces.
const AT_REST: f64 = 1e-5;
/// Loads and weights of the models `[force]`: on a body at rest their impulses and those of its supports cancel up to round-off of the
/// impulses, not of the body's momentum.
const LOAD: f64 = 3.0;
/// Largest penetration over the facet size.
const DEPTH: f64 = 0.15;
/// Largest relative difference of a rotated, translated or rescaled model: the default tolerance of `expect_invariant`.
pub const INVARIANT: f64 = 1e-7;
/// Largest relative difference of the histories of a model in another numbering.
const RENUMBERED: f64 = 1e-6;
/// Largest violation of supports and joints `[length]`.
const HELD: f64 = 1e-9;

/// Violation of an oracle.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Kind of the fault, one word.
    pub kind: &'static str,
    /// Evidence of the fault.
    pub found: String,
}

impl Fault {
    /// A fault.
    pub fn new(kind: &'static str, found: impl Into<String>) -> Self {
        Fault { kind, found: found.into() }
    }

    /// True if the program reported the fault itself, by an error or a finding.
    pub fn is_told(&self) -> bool {
        matches!(self.kind, "failed" | "doubtful")
    }
}

/// The history of a run, and its scales.
pub struct History {
    /// The table of `history.csv`.
    pub table: Table,
    energy: f64,
    momentum: f64,
}

impl History {
    /// Column of the history; NaN for missing values.
    pub fn column(&self, name: &str) -> Vec<f64> {
        let values = self.table.column(name).map(|column| column.values.clone()).unwrap_or_default();
        values.into_iter().map(|value| value.unwrap_or(f64::NAN)).collect()
    }

    fn read(path: &Path) -> Result<Self, String> {
        let table = read_table(path).map_err(|error| error.to_string())?.table;
        let mut history = History { table, energy: 0.0, momentum: 0.0 };
        let largest = |names: &[&str]| {
            let columns: Vec<Vec<f64>> = names.iter().map(|name| history.column(name)).collect();
            (0..history.table.rows())
                .map(|row| columns.iter().map(|column| column.get(row).map_or(0.0, |value| value.abs())).sum::<f64>())
                .fold(0.0, f64::max)
        };
        let energy = largest(&["kinetic", "strain", "potential", "load_work", "contact_work", "friction_work", "dissipation"]);
        let momentum = largest(&["momentum_x", "momentum_y", "momentum_z"]).max((2.0 * 0.5 * energy).sqrt());
        let impulse = LOAD * largest(&["dt"]);
        // Velocities are differences of positions, which are of order one as are the masses, divided by the step size.
        let round_off = f64::EPSILON / largest(&["dt"]).max(1e-6);
        history.energy = energy.max(AT_REST);
        history.momentum = momentum.max(impulse).max(AT_REST).max(round_off / DEFECT);
        Ok(history)
    }
}

/// All faults of a run.
pub fn judge(product: Named, ended: &Ended, out: &Path) -> Vec<Fault> {
    let mut faults = Vec::new();
    if ended.is_endless {
        return vec![Fault::new("endless", "stopped after a minute")];
    }
    if let Some(error) = &ended.error {
        let kind = match error.class {
            Class::Internal => "panic",
            Class::Numerics => "failed",
            _ => "ended",
        };
        faults.push(Fault::new(kind, format!("{} {}: {}", error.code, error.title, error.causes.join("; "))));
        return faults;
    }
    let history = match History::read(&out.join("history.csv")) {
        Ok(history) => history,
        Err(error) => return vec![Fault::new("no_history", error)],
    };
    faults.extend(agreement(product, ended, &history, out));
    if faults.iter().any(Fault::is_told) {
        return faults;
    }
    faults.extend(ledger(product, &history));
    faults.extend(cone(product, ended));
    match Frame::read(&out.join("end.vtu")) {
        Ok(frame) => faults.extend(places(product, ended, &frame)),
        Err(error) => faults.push(Fault::new("no_frame", error)),
    }
    faults
}

fn scheme(product: Named) -> Option<&'static integrators::Scheme> {
    let all = integrators::CATALOGUE.iter().chain(integrators::EXPLICIT).chain(integrators::STATIC);
    all.copied().find(|scheme| scheme.name == product.row("integrator"))
}

/// True above a bound, and for NaN.
fn exceeds(value: f64, bound: f64) -> bool {
    value.is_nan() || value > bound
}

/// Largest value with its row; NaN counts as the largest.
fn worst(values: impl Iterator<Item = f64>) -> (usize, f64) {
    values.enumerate().fold((0, 0.0), |worst, (row, value)| if value > worst.1 || value.is_nan() { (row, value) } else { worst })
}

/// Checks sums, defects and signs of the ledger.
fn ledger(product: Named, history: &History) -> Vec<Fault> {
    let mut faults = Vec::new();
    let of = |name: &str| history.column(name);
    let [kinetic, strain, potential, total] = ["kinetic", "strain", "potential", "total"].map(of);
    let [load, contact, friction, dissipation] = ["load_work", "contact_work", "friction_work", "dissipation"].map(of);
    let (defect, dt, time) = (of("energy_defect"), of("dt"), of("time"));
    let rows = history.table.rows();
    let mut above = |kind: &'static str, bound: f64, values: &mut dyn Iterator<Item = f64>| {
        let (row, value) = worst(values);
        if exceeds(value, bound) {
            faults.push(Fault::new(kind, format!("{value:.2e} in row {row}, bound {bound:.0e}")));
        }
    };
    let at = |column: &[f64], row: usize| column.get(row).copied().unwrap_or(0.0);
    let energy = history.energy;
    above(
        "sum_of_energies",
        ROUND_OFF,
        &mut (0..rows).map(|row| (kinetic[row] + strain[row] + potential[row] - total[row]).abs() / energy),
    );
    above("negative_energy", 0.0, &mut (0..rows).map(|row| (-kinetic[row]).max(-(strain[row] + ROUND_OFF * energy)).max(0.0)));
    let books = |row: usize| {
        let change = total[row] - total[row - 1] - load[row] - at(&contact, row) - at(&friction, row) + at(&dissipation, row);
        (change - defect[row]).abs() / energy
    };
    let is_step = |row: &usize| dt[*row] > 0.0;
    above("ledger_formula", ROUND_OFF, &mut (1..rows).map(|row| if is_step(&row) { books(row) } else { 0.0 }));
    above("friction_gives", ROUND_OFF, &mut friction.iter().map(|work| (work / energy).max(0.0)));
    above("negative_heat", ROUND_OFF, &mut dissipation.iter().map(|heat| (-heat / energy).max(0.0)));
    let is_statics = product.is("integrator", &["statics"]);
    // An impulse of an explicit step may return in one step what it takes in the next (docs/integrators.md, Explicit steps).
    if !is_statics && !product.is("integrator", &["central_differences"]) {
        above("contact_gives", 10.0 * DEFECT, &mut (1..rows).filter(is_step).map(|row| (at(&contact, row) / energy).max(0.0)));
    }
    above("time", 1e-9, &mut (1..rows).filter(is_step).map(|row| (time[row] - time[row - 1] - dt[row]).abs() / dt[row].max(1e-300)));
    let promises = scheme(product).map(|scheme| scheme.promises);
    if promises.is_some_and(|promises| promises.energy) && !is_statics {
        above("energy_defect", DEFECT, &mut (1..rows).filter(is_step).map(|row| defect[row].abs() / energy));
    }
    if promises.is_some_and(|promises| promises.momentum) && !is_statics {
        above("momentum_defect", DEFECT, &mut of("momentum_defect").into_iter().skip(1).map(|value| value.abs() / history.momentum));
    }
    let turns = !product.is("material", &["linear_elasticity"]);
    if promises.is_some_and(|promises| promises.angular_momentum) && !is_statics && turns {
        // Lengths are of order one or two.
        let scale = 2.0 * history.momentum;
        above("angular_momentum_defect", DEFECT, &mut of("angular_momentum_defect").into_iter().skip(1).map(|value| value.abs() / scale));
    }
    if is_free(product) && promises.is_some_and(|promises| promises.momentum) {
        for name in ["momentum_x", "momentum_y", "momentum_z", "angular_momentum"] {
            let is_kept = name != "angular_momentum" || (promises.is_some_and(|promises| promises.angular_momentum) && turns);
            let values = of(name);
            // A run from an equilibrium starts to move later.
            if is_kept && let Some(&first) = values.first() {
                above("momentum", 10.0 * DEFECT, &mut values.iter().map(|value| (value - first).abs() / (2.0 * history.momentum)));
            }
        }
    }
    faults
}

/// True if no external force acts on the model.
fn is_free(product: Named) -> bool {
    product.is("partner", &["none", "free_body", "rigid_body", "self"])
        && product.is("support", &["none"])
        && product.is("part", &["none", "add_mass"])
        && product.is("joint", &["none"])
        && product.is("load", &["none", "initial_displacement", "grow"])
        && !product.is("plane", &["axisymmetric"])
        && !script::rests(product)
}

/// Checks shear stress against pressure at the end.
fn cone(product: Named, ended: &Ended) -> Vec<Fault> {
    let numbers = Numbers::new(product.product.seed);
    let mu = numbers.friction;
    let (pressure, shear, slip) =
        (told::first(&ended.printed, "pressure"), told::first(&ended.printed, "shear"), told::first(&ended.printed, "slip"));
    // Pressures below a millionth of Young's moduli are round-off of what moved before.
    let most = pressure.iter().fold(1e-6 * 100.0, |most: f64, p| most.max(p.abs()));
    // Viscosity times the speed of the last step. A node without slip may be beside the contact, where pressure and shear stress are means
    // over a partly covered facet: the fastest node bounds its film.
    let fastest = slip.iter().fold(0.0f64, |fastest, slip| fastest.max(slip.abs()));
    let film = |node: usize| {
        let slip = slip.get(node).map(|slip| slip.abs()).filter(|slip| *slip > 0.0).unwrap_or(fastest);
        0.1 * slip / told::first(&ended.printed, "column dt:").first().copied().unwrap_or(numbers.dt)
    };
    let bound = |node: usize| {
        let p = if product.is("enforcement", &["equality"]) { pressure[node].abs() } else { pressure[node].max(0.0) };
        match product.row("friction") {
            "number" => mu * p,
            "coulomb" => 1.2 * mu * p + film(node),
            "friction_curve" => 1.5 * mu * p,
            "rough" => 10.0 * p,
            _ => 0.0,
        }
    };
    if pressure.len() != shear.len() {
        return Vec::new();
    }
    let beyond = |node: usize| (shear[node].abs() - bound(node)) / most;
    let found = (0..shear.len()).map(beyond).fold(0.0, f64::max);
    if found > 1e-6 { vec![Fault::new("cone", format!("{found:.2e} of the largest pressure outside"))] } else { Vec::new() }
}

/// Checks penetration, supports and joints.
fn places(product: Named, ended: &Ended, frame: &Frame) -> Vec<Fault> {
    let mut faults = Vec::new();
    let time = told::first(&ended.printed, "time").first().copied().unwrap_or(0.0);
    let numbers = Numbers::new(product.product.seed);
    let is_soft = product.is("enforcement", &["penalty"]);
    let depth = frame.depth(product, time);
    if exceeds(depth, DEPTH) && !is_soft && !product.is("partner", &["none", "tie", "self"]) {
        faults.push(Fault::new("deep", format!("{depth:.3} facets")));
    }
    let gap = script::gap(product, &numbers);
    let mut off = |what: &str, distance: f64| {
        if exceeds(distance, HELD) {
            faults.push(Fault::new("held", format!("{what} is {distance:.2e} off")));
        }
    };
    // Initially displaced nodes are fixed at their displaced position.
    if product.is("shape", &["box"]) && !product.is("load", &["initial_displacement"]) {
        let on = |which: &dyn Fn(&[f64; 3]) -> bool| -> Vec<usize> {
            (0..frame.points.len()).filter(|&node| which(&frame.points[node])).collect()
        };
        let is_own = |x: &[f64; 3]| x[1] > gap - 1e-9 && (LEFT - 1e-9..LEFT + SIZE[0] + 1e-9).contains(&x[0]);
        let cap = on(&|x| is_own(x) && (x[1] - gap - SIZE[1]).abs() < 1e-9);
        let flank = on(&|x| is_own(x) && (x[0] - LEFT).abs() < 1e-9);
        let largest = |nodes: &[usize], i: usize, value: f64| {
            nodes.iter().map(|&node| (frame.displacement[node][i] - value).abs()).fold(0.0, f64::max)
        };
        match product.row("support") {
            "fix" => (0..3).for_each(|i| off("a fixed boundary", largest(&cap, i, 0.0))),
            "fix_x" => off("a boundary fixed along x", largest(&flank, 0, 0.0)),
            "add_symmetry" => off("a symmetry", largest(&flank, 0, 0.0)),
            "prescribe" => {
                off("a prescribed boundary", largest(&cap, 1, script::motion_at(product, script::prescribed_peak(product), time)))
            }
            _ => {}
        }
    }
    let joint = told::first(&ended.printed, "joint");
    if !joint.is_empty() && !numbers.is_joined {
        let at = script::joint_point(product);
        let away: Vec<f64> = joint.iter().zip(at).map(|(x, at)| x - at).collect();
        let beside = away.iter().enumerate().filter(|(k, _)| *k != 1).fold(0.0, |sum: f64, (_, away)| sum.hypot(*away));
        let length = beside.hypot(away[1] - 1.0);
        match product.row("joint") {
            "point" | "hinge" | "weld" | "gear" => off("a joint", beside.hypot(away[1])),
            "slider" | "slot" => off("a slide", beside),
            "link" if product.is("drive", &["free"]) => off("a link", (length - 1.0).abs()),
            // The cable becomes taut within a step.
            "cable" => off("a cable", (length - 1.0 - 3.0 * numbers.dt).max(0.0)),
            _ => {}
        }
    }
    faults
}

/// Largest change of the printed energies, displacements and velocities between two runs, each relative to the largest of its kind.
pub fn largest_change(first: &[String], second: &[String]) -> f64 {
    ["energy", "displacement", "velocity"].map(|word| change_of(word, first, second)).into_iter().fold(0.0, f64::max)
}

/// Largest change of the printed numbers after a word between two runs, relative to the largest of them.
fn change_of(word: &str, first: &[String], second: &[String]) -> f64 {
    let [a, b] = [first, second].map(|printed| told::lines(printed, word).into_iter().flat_map(told::numbers).collect::<Vec<f64>>());
    let size = a.iter().fold(0.0f64, |size, value| size.max(value.abs()));
    let change = a.iter().zip(&b).fold(0.0f64, |largest, (a, b)| largest.max((a - b).abs()));
    if change > 0.0 { change / size } else { 0.0 }
}

/// Differences between two runs of a model with different numberings; `admitted` is evaluated for differences above [`RENUMBERED`].
pub fn compare_histories(kind: &'static str, first: (&Ended, &Path), second: (&Ended, &Path), admitted: &dyn Fn() -> f64) -> Option<Fault> {
    if first.0.code != second.0.code {
        let title = second.0.error.as_ref().map(|error| error.title.clone()).unwrap_or_default();
        // A step that fails is told.
        let is_told = second.0.error.as_ref().is_some_and(|error| error.class == Class::Numerics);
        let kind = if is_told { "failed" } else { kind };
        return Some(Fault::new(kind, format!("exit codes {} and {}: {title}", first.0.code, second.0.code)));
    }
    let read = |out: &Path| History::read(&out.join("history.csv"));
    let (Ok(a), Ok(b)) = (read(first.1), read(second.1)) else { return Some(Fault::new(kind, "no history")) };
    let found = difference_of(&a, &b)?;
    // A model that amplifies round-off may choose other steps: then only the energies of its end are compared.
    let admitted = admitted();
    let is_admitted = admitted > RENUMBERED && change_of("energy", &first.0.printed, &second.0.printed) <= admitted;
    (!is_admitted).then(|| Fault::new(kind, found))
}

/// Description of a difference between two histories above [`RENUMBERED`].
fn difference_of(a: &History, b: &History) -> Option<String> {
    if a.table.rows() != b.table.rows() {
        return Some(format!("{} and {} rows", a.table.rows(), b.table.rows()));
    }
    for name in ["kinetic", "strain", "potential", "load_work", "friction_work", "contact_work", "dissipation"] {
        let (row, value) = worst(a.column(name).iter().zip(b.column(name)).map(|(a, b)| (a - b).abs()));
        let scale = a.energy;
        if exceeds(value, RENUMBERED * scale) {
            return Some(format!("{name} differs by {value:.2e} in row {row}, the energy is {scale:.2e}"));
        }
    }
    None
}
