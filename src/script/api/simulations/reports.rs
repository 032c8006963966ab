//! `report.html`: data of a simulation, its model and its script for the page, and `report(sim, path)`.

use std::collections::BTreeMap;

use serde_json::Value;

use super::columns::{further_values, model_columns, names, probe_columns};
use super::handle::{SimulationData, SimulationHandle, busy};
use super::integrators::title;
use super::report_pictures::pictures;
use super::step_control::step_size;
use super::writing::write_course;
use crate::bodies::{Dilatation, Formulation, Plane};
use crate::dynamics::{
    BodyDefinition, Enforcement, Gear, Interaction, JointDefinition, JointKind, LedgerRow, Model, Partner, PlacedObstacle, Quantity, Rows,
    RunFinding, Simulation, default_rule,
};
use crate::output::{
    Field, History, Report, ReportPage, ReportTable, Still, kept_rows, marks, pretty_unit, report, report_of_several, shapes,
};
use crate::script::api::examples::flight_example;
use crate::script::api::files::failures::output_failure;
use crate::script::api::files::results::Results;
use crate::script::api::files::shown::Printed;
use crate::script::api::files::writing::path_parameter;
use crate::script::api::models::description::{describe_obstacle, prescribed};
use crate::script::api::models::joint_friction::friction_text;
use crate::script::api::parameters::{Overrides, ParameterUnits};
use crate::script::api::remedies::explained;
use crate::script::language::digits::{brief, brief_vector, number_text, vector_text};
use crate::script::language::prelude::*;
use crate::script::language::wording::joined;

/// `report`: the page of the present simulation.
pub(super) fn report_function() -> Function {
    function(Topic::Results, "report")
        .summary(
            "writes a page about the run so far that opens in any browser without a network: the model, an animation, plots and the ledger \
             over its time, warnings, the script; at the end of a run `report.html` is written without being asked for. Of several \
             simulations the page shows their pictures side by side and their curves in one set of axes",
        )
        .parameters(vec![
            Parameter::new(
                "simulation",
                Kind::Either("a Simulation, or an array of two to six of them"),
                "the simulation, or several to compare",
            ),
            path_parameter("an `.html` file below the output folder"),
        ])
        .see_also(&["picture", "plot", "simulate"])
        .example(flight_example("sim.run_to(0.05);\nreport(sim, \"flight.html\");"))
        .body(|call| {
            let handles = simulations(&call.argument("simulation"))?;
            let content = || {
                let pages = handles.iter().map(|handle| {
                    handle.refuse_in_check(call)?;
                    let simulation = handle.0.simulation.try_borrow().map_err(|_| busy(call))?;
                    Ok((handle.0.name.clone(), page(call.host, &handle.0, &simulation, None)))
                });
                Ok(joined_pages(pages.collect::<Result<_, Failure>>()?))
            };
            Ok(write_course(call, &handles[0], &[".html"], content)?)
        })
}

/// Simulations of an argument, at least one.
fn simulations(argument: &Argument) -> Result<Vec<SimulationHandle>, Failure> {
    let value = argument.value();
    if let Some(handle) = value.clone().try_cast::<SimulationHandle>() {
        return Ok(vec![handle]);
    }
    let Some(all) = value.read_lock::<Array>().map(|all| all.clone()) else { return Err(argument.wrong_type()) };
    let handles: Option<Vec<SimulationHandle>> = all.iter().map(|value| value.clone().try_cast()).collect();
    let handles = handles.ok_or_else(|| argument.wrong_type().hint("write `report([first, second], \"both.html\")`"))?;
    match handles.len() {
        1..=6 => Ok(handles),
        count => {
            let failure = argument.wrong(causes::COUNT, "must have one to six simulations");
            Err(failure.label(format!("it has {count}")).hint("choose those that matter; a table of many is made by `conserva sweep`"))
        }
    }
}

/// Page of one simulation, or of several side by side.
fn joined_pages(mut pages: Vec<(String, Vec<u8>)>) -> Vec<u8> {
    if pages.len() == 1 {
        return pages.swap_remove(0).1;
    }
    let mut runs: Vec<(String, ReportPage)> = Vec::new();
    for (name, bytes) in pages {
        let count = runs.iter().filter(|(label, _)| *label == name || label.starts_with(&format!("{name} ("))).count();
        let label = if count > 0 { format!("{name} ({})", count + 1) } else { name };
        runs.extend(ReportPage::of_bytes(&bytes).map(|page| (label, page)));
    }
    report_of_several(runs)
}

/// Outcome of a run.
pub struct Ending {
    /// Outcome in words.
    pub outcome: String,
    /// True if the run ended as intended.
    pub is_well: bool,
}

/// Page of a simulation; `ending` if the run is complete.
pub fn page(host: &Host, data: &SimulationData, simulation: &Simulation, ending: Option<Ending>) -> Vec<u8> {
    let model = &data.model.model;
    let history = data.history.borrow();
    let last = history.len() - 1;
    let artifacts = data.artifacts.borrow();
    let Some(artifacts) = artifacts.as_ref() else { return Vec::new() };
    let recording = artifacts.recording();
    let stills = artifacts.stills(simulation, last);
    let stills: Vec<&Still> = stills.iter().map(|still| &**still).collect();
    let rows = kept_rows(&*history, &stills.iter().map(|still| still.row).collect::<Vec<_>>());
    let warnings = host.warnings().into_iter().chain(findings(host, data, simulation, &history));
    let lines = summary(host, data, simulation, &stills, ending.as_ref());
    report(&Report {
        name: data.name.clone(),
        is_well: ending.as_ref().is_none_or(|ending| ending.is_well),
        summary: lines,
        outcome: ending.map(|ending| ending.outcome),
        version: env!("CARGO_PKG_VERSION").into(),
        scripts: scripts(host),
        parameters: parameters(host),
        tables: tables(data, simulation).into_iter().chain(outcomes(host)).collect(),
        warnings: warnings.collect(),
        printed: Printed::of(host),
        pictures: pictures(host, &data.name, artifacts),
        columns: columns(data, &history, &rows),
        rows,
        row_count: history.len(),
        contacts: model.contact_names().into_iter().map(String::from).collect(),
        bodies: &model.bodies,
        skins: recording.bodies(),
        shown: &data.keeping.stills,
        stills: &stills,
        obstacles: placed(model),
        units: data.listed_units(),
        marks: marks(model, recording.bodies()),
    })
}

/// Returns the findings of a run in words, without those of which the user was warned.
pub fn findings(host: &Host, data: &SimulationData, simulation: &Simulation, history: &History) -> Vec<String> {
    let (warnings, named) = (host.warnings(), format!("(simulation \"{}\", ", data.name));
    let is_told = |finding: &RunFinding| {
        let title = format!(": {finding}\n");
        warnings.iter().any(|text| text.contains(&title) && (!text.contains("(simulation \"") || text.contains(&named)))
    };
    let found = data.found(simulation, history);
    found.findings.iter().filter(|finding| !is_told(finding)).map(|finding| format!("{finding}: {}", explained(finding))).collect()
}

/// Values of `param(...)` by name.
pub fn parameters(host: &Host) -> BTreeMap<String, Value> {
    let units = ParameterUnits::of(host);
    let named = |name: String| match units.get(&name) {
        Some(unit) => format!("{name} [{}]", pretty_unit(unit)),
        None => name,
    };
    host.slots.get::<Overrides>().parameters().into_iter().map(|(name, value)| (named(name), json(&value))).collect()
}

/// Value of a script parameter as JSON, for a file of results.
pub fn json(value: &Dynamic) -> Value {
    match (value.as_bool(), value.as_int(), value.as_float()) {
        (Ok(flag), ..) => flag.into(),
        (_, Ok(whole), _) => whole.into(),
        (.., Ok(number)) => number.into(),
        _ => value.to_string().into(),
    }
}

/// Returns the texts of the script and its modules by file name, without folders, which differ between machines.
pub fn scripts(host: &Host) -> Vec<(String, String)> {
    let main = host.main.borrow();
    let file = |name: &str| name.rsplit(['/', '\\']).next().unwrap_or(name).to_string();
    let mut all = host.sources.all();
    all.sort_by_key(|(name, _)| *name != *main);
    all.into_iter().map(|(name, text)| (file(&name), text.to_string())).collect()
}

/// Columns of the history in the reported rows.
fn columns(data: &SimulationData, history: &History, rows: &[usize]) -> Vec<(String, Vec<f64>)> {
    let model = &data.model.model;
    let ledger = Quantity::names(&LedgerRow::columns(model.dimension()));
    let mut own_values = vec![Vec::with_capacity(rows.len()); ledger.len()];
    let mut further: Vec<Vec<f64>> = Vec::with_capacity(rows.len());
    let (mut index, mut wanted) = (0, rows.iter().copied().peekable());
    history.visit(0, &mut |row| {
        if wanted.next_if_eq(&index).is_some() {
            further.push(further_values(model, row));
            own_values.iter_mut().zip(&ledger).for_each(|(values, name)| values.push(row.column(name).unwrap_or(f64::NAN)));
        }
        index += 1;
    });
    let own = ledger.iter().map(|name| name.to_string()).zip(own_values);
    let extra = names(model_columns(model)).into_iter().chain(names(probe_columns(model, &data.probes.borrow())));
    let extra = extra.enumerate().map(|(index, name)| {
        let values = further.iter().map(|values| values.get(index).copied().unwrap_or(f64::NAN));
        (name, values.collect())
    });
    own.chain(extra).collect()
}

/// Returns the different shapes of rigid obstacles at their initial positions.
pub fn placed(model: &Model) -> Vec<PlacedObstacle> {
    let named = |shape| {
        let touching =
            model.interactions.iter().filter(|one| matches!(&one.partner, Partner::Obstacle { shape: other, .. } if *other == shape));
        let name = touching.map(|one| one.name.as_str()).collect::<Vec<_>>().join(", ");
        PlacedObstacle { name, shape, place: Default::default() }
    };
    shapes(model).into_iter().map(named).collect()
}

fn table(title: &str, head: &[&str], rows: Vec<Vec<String>>) -> ReportTable {
    ReportTable { title: title.into(), head: head.iter().map(|name| name.to_string()).collect(), rows }
}

/// Returns the tables of the model: bodies, supports, loads, time integration.
pub fn tables(data: &SimulationData, simulation: &Simulation) -> Vec<ReportTable> {
    let model = &data.model.model;
    let bodies = model.bodies.iter().map(|body| {
        let mesh = &body.mesh;
        let cells = mesh.blocks.iter().map(|block| format!("{} {}", block.count(), block.kind.name())).collect::<Vec<_>>().join(" and ");
        vec![body.name.clone(), cells, mesh.points.len().to_string(), material(body), formulation(body.formulation, mesh.dimension())]
    });
    let mut all = vec![
        table("Bodies", &["body", "cells", "nodes", "material", "formulation"], bodies.collect()),
        table("Held and loaded", &[], conditions(data)),
        table("Joints, gears and drives", &["name", "kind", "from", "to", "at", "driven or limited"], joints(model)),
        table("Contacts", &["contact", "secondary", "primary", "method", "update", "enforcement"], contacts(data, simulation)),
        table("Time integration", &[], integration(data, simulation)),
    ];
    all.retain(|table| !table.rows.is_empty());
    all
}

/// Joints of a model with their ends, drives and limits.
fn joints(model: &Model) -> Vec<Vec<String>> {
    let dimension = model.dimension();
    let end = |body: Option<usize>| body.map_or("ground".to_string(), |body| model.bodies[body].name.clone());
    let row = |joint: &JointDefinition| {
        let [from, to] = joint.ends;
        let kind = match joint.kind {
            JointKind::Gear(Gear { joints: [a, b], ratio }) => {
                let name = |index: usize| model.joints.get(index).map_or("", |joint| joint.name.as_str());
                format!("gear of \"{}\" and \"{}\", ratio {}", name(a), name(b), brief(ratio))
            }
            kind => kind.name().to_string(),
        };
        let axis = joint.kind.direction().map(|axis| format!(", along {}", brief_vector(&axis[..dimension]))).unwrap_or_default();
        let drive = joint.drive.as_ref().map(|drive| format!("driven: {}", drive.describe()));
        let limits = joint.limits.map(|limits| format!("limits {}", brief_vector(&limits)));
        let friction = joint.friction.map(|friction| friction_text(&friction));
        let moved: Vec<String> = drive.into_iter().chain(limits).chain(friction).collect();
        let at = format!("{}{axis}", brief_vector(&from.point[..dimension]));
        vec![joint.name.clone(), kind, end(from.body), end(to.body), at, moved.join(", ")]
    };
    model.joints.iter().map(row).collect()
}

/// Tables of results and passed checks of the script.
fn outcomes(host: &Host) -> Vec<ReportTable> {
    let units = Results::units(host);
    let told = |name: &str, value: String| units.get(name).map_or(value.clone(), |unit| format!("{value} {}", pretty_unit(unit)));
    let row = |(name, value): (String, Value)| vec![name.clone(), told(&name, value.as_f64().map_or(value.to_string(), brief))];
    let results = Results::of(host).into_iter().map(row).collect();
    // Without folders, which differ between machines.
    let plain = |line: String| match line.rsplit_once("  [") {
        Some((what, place)) => format!("{what}  [{}", place.rsplit(['/', '\\']).next().unwrap_or_default()),
        None => line,
    };
    let checks = host.passed_checks().into_iter().map(|line| vec![plain(line)]).collect();
    let mut all = vec![table("Results", &["result", "value"], results), table("Checks that held", &[], checks)];
    all.retain(|table| !table.rows.is_empty());
    all
}

/// Lines at the top of the page.
fn summary(host: &Host, data: &SimulationData, simulation: &Simulation, stills: &[&Still], ending: Option<&Ending>) -> Vec<[String; 2]> {
    let (model, history, options) = (&data.model.model, data.history.borrow(), simulation.options());
    let count = |number: usize, one: &str, many: &str| format!("{number} {}", if number == 1 { one } else { many });
    let nodes: usize = model.bodies.iter().map(|body| body.mesh.points.len()).sum();
    let (joints, contacts) = (model.joints.len(), model.interactions.len());
    let parts =
        [(model.bodies.len(), "body", "bodies"), (nodes, "node", "nodes"), (joints, "joint", "joints"), (contacts, "contact", "contacts")];
    let parts: Vec<String> = parts.into_iter().filter(|part| part.0 > 0).map(|(number, one, many)| count(number, one, many)).collect();
    let (mut halved, mut depth) = (0, 0.0_f64);
    history.visit(0, &mut |row| {
        halved += row.halvings;
        depth = depth.max(row.max_penetration);
    });
    let row = simulation.row();
    let told = |number: f64, dimension| data.told(brief(number), dimension);
    let steps =
        format!("to t = {} in {}, {}", told(row.time, "time"), count(row.step, "step", "steps"), count(halved, "halving", "halvings"));
    let method = format!(
        "{}, dt {}, {} unknowns",
        title(&options.integrator).replace('_', " "),
        step_size(options, |dt| data.told(dt, "time")),
        simulation.unknowns()
    );
    let energy = format!(
        "kinetic {}, strain {}, potential {}, total {}",
        told(row.kinetic, "energy"),
        told(row.strain, "energy"),
        told(row.potential, "energy"),
        told(row.total(), "energy")
    );
    let account = data.found(simulation, &history).account.to_string();
    let account = if account.is_empty() { "kept to round-off".to_string() } else { account };
    let peak = |wanted: &str| {
        let index = Field::BASIC.iter().position(|name| *name == wanted)?;
        let still = stills.iter().max_by(|a, b| a.extremes[index][1].total_cmp(&b.extremes[index][1]))?;
        let value = still.extremes[index][1];
        let field = Field::from_name(wanted).filter(|_| value > 0.0 && value.is_finite())?;
        Some(format!("{} {} at t = {}", field.words(), told(value, field.dimension()), told(still.time, "time")))
    };
    let is_soft = model.bodies.iter().any(|body| body.rigid.is_none());
    let peaks = ["von_mises", "contact_pressure", "displacement", "velocity"].into_iter().filter(|name| is_soft || *name != "von_mises");
    let peaks: Vec<String> = peaks.filter_map(peak).collect();
    let units = data.units.as_ref().map(|units| units.set.overview()).unwrap_or_default();
    let units: Vec<String> = units.into_iter().map(|(name, unit)| format!("{name} {}", pretty_unit(&unit))).collect();
    let energy_since = format!("energy since the start{}", data.bracketed("energy"));
    let lines = [
        ("model", parts.join(", ")),
        ("units", units.join(", ")),
        ("outcome", ending.map(|ending| ending.outcome.clone()).unwrap_or_default()),
        ("time", steps),
        ("method", method),
        ("energy at the end", energy),
        (&energy_since, account),
        ("peaks of the pictures", peaks.join("; ")),
        ("largest overlap", if contacts > 0 { told(depth, "length") } else { String::new() }),
        ("checks", if host.checks() > 0 { format!("{} held", host.checks()) } else { String::new() }),
        ("program", format!("Conserva {}", env!("CARGO_PKG_VERSION"))),
    ];
    lines.into_iter().filter(|(_, text)| !text.is_empty()).map(|(name, text)| [name.to_string(), text]).collect()
}

fn material(body: &BodyDefinition) -> String {
    if let Some(inertia) = &body.rigid {
        return format!("rigid: mass {}", brief(inertia.mass));
    }
    let constants = body.material.constants().into_iter().map(|(name, value)| format!("{} {}", name.replace('_', " "), brief(value)));
    format!("{}: {}", body.material.name().replace('_', " "), constants.collect::<Vec<_>>().join(", "))
}

fn formulation(formulation: Formulation, dimension: usize) -> String {
    let plane = match formulation.plane {
        _ if dimension == 3 => "in space",
        Plane::Strain => "plane strain",
        Plane::Stress => "plane stress",
        Plane::Axisymmetric => "axisymmetric",
    };
    let mean = match formulation.dilatation {
        Dilatation::Pointwise => "",
        Dilatation::Mean => ", mean dilatation",
        Dilatation::Linear => ", linear dilatation",
    };
    format!("{plane}{mean}")
}

fn conditions(data: &SimulationData) -> Vec<Vec<String>> {
    let model = &data.model.model;
    const AXES: [&str; 3] = ["x", "y", "z"];
    let held = model.supports.iter().map(|support| {
        let names = AXES.into_iter().zip(support.components).take(model.dimension()).filter(|(_, held)| *held);
        let names: Vec<&str> = names.map(|(name, _)| name).collect();
        vec![format!("\"{}\"", model.boundary_name(&support.on)), format!("fixed in {}", joined(&names, "and"))]
    });
    let moved = model.prescriptions.iter().flat_map(|given| {
        let boundary = format!("\"{}\"", model.boundary_name(&given.on));
        prescribed(given).into_iter().map(move |(what, function)| vec![boundary.clone(), format!("prescribed {what}: {function}")])
    });
    let loads = model.loads.iter().zip(&data.model.loads).map(|(load, note)| {
        let what = note.title.split(" on \"").next().unwrap_or(&note.title);
        vec![format!("\"{}\"", model.boundary_name(&load.on)), format!("{what}: {}", load.amplitude.describe())]
    });
    let mut all: Vec<Vec<String>> = held.chain(moved).chain(loads).collect();
    if model.gravity != [0.0; 3] {
        let size = model.gravity_amplitude.as_ref().map(|size| format!(", times {}", size.describe())).unwrap_or_default();
        all.push(vec!["all bodies".into(), format!("gravity {}{size}", vector_text(&model.gravity[..model.dimension()]))]);
    }
    all.extend(model.initial_velocities.iter().map(|given| {
        let (linear, spin) = (vector_text(&given.linear[..model.dimension()]), &given.angular);
        let spin = if model.dimension() == 2 { number_text(spin[2]) } else { vector_text(spin) };
        vec![format!("\"{}\"", model.bodies[given.body].name), format!("starts with the velocity {linear} and the spin {spin}")]
    }));
    all.extend(model.parts.iter().map(|part| vec![part.name().to_string(), part.describe()]));
    all
}

fn contacts(data: &SimulationData, simulation: &Simulation) -> Vec<Vec<String>> {
    let (model, told) = (&data.model.model, |number: String, dimension: &str| data.told(number, dimension));
    let row = |interaction: &Interaction| {
        let primary = match &interaction.partner {
            Partner::Obstacle { shape, motion, turn } => describe_obstacle(shape, motion, turn.as_ref(), &told),
            Partner::Itself => "itself".into(),
            _ => joined(&interaction.primary().iter().map(|on| model.boundary_name(on)).collect::<Vec<_>>(), "and"),
        };
        let enforcement = match interaction.enforcement {
            Enforcement::Multiplier => "multipliers".into(),
            Enforcement::Penalty { factor } => format!("penalty, factor {}", number_text(factor)),
            Enforcement::AugmentedLagrange { factor } => format!("augmented Lagrangian, factor {}", number_text(factor)),
        };
        let update = match (interaction.is_tie(), interaction.equality) {
            (true, _) => "tied".into(),
            (_, true) => "bilateral".into(),
            _ => interaction.update.unwrap_or_else(|| default_rule(&simulation.options().integrator)).name.to_string(),
        };
        let method = interaction.method.name.replace('_', " ");
        vec![interaction.name.clone(), model.boundary_name(&interaction.secondary), primary, method, update, enforcement]
    };
    model.interactions.iter().map(row).collect()
}

fn integration(data: &SimulationData, simulation: &Simulation) -> Vec<Vec<String>> {
    let options = simulation.options();
    let row = |name: &str, value: String| vec![name.to_string(), value];
    vec![
        row("integrator", format!("{}: {}", title(&options.integrator).replace('_', " "), options.integrator.summary)),
        row("step size", step_size(options, |dt| data.told(dt, "time"))),
        row("tolerance", number_text(options.tolerance)),
        row("halvings at most", options.max_halvings.to_string()),
        row("unknowns", simulation.unknowns().to_string()),
    ]
}

/// Writes the page at the end of a run.
///
/// # Errors
/// The file cannot be written.
pub fn write_at_end(host: &Host, handle: &SimulationHandle, ending: Ending) -> Result<(), Failure> {
    let Ok(simulation) = handle.0.simulation.try_borrow() else { return Ok(()) };
    let begun = std::time::Instant::now();
    let bytes = page(host, &handle.0, &simulation, Some(ending));
    let mut artifacts = handle.0.artifacts.borrow_mut();
    let Some(artifacts) = artifacts.as_mut() else { return Ok(()) };
    artifacts.count(begun.elapsed());
    artifacts.write("report.html", &bytes).map_err(|error| output_failure(&error))
}
