//! `simulate`: from a model to a running simulation.

use std::cell::{Cell, RefCell};
use std::rc::Rc;
use std::time::{Duration, Instant};

use super::artifacts::{Artifacts, Columns, FirstSteps, RecordingLimits};
use super::columns::{Probe, probe_columns};
use super::doubts::warn_of_numbers;
use super::following;
use super::handle::{SimulationData, SimulationHandle, Simulations};
use super::integrators::{IntegratorHandle, title};
use super::journal::Journal;
use super::modes::warn_of_damping;
use super::step_control::{STEP_SIZE, StepSize, step_size};
use super::stills::{still_options, still_parameters};
use crate::contact::Finding;
use crate::dynamics::{LedgerRow, Model, Options, Prescription, RedundantConstraints, Simulation};
use crate::linear::SolverChoice;
use crate::materials::Weakness;
use crate::math::tolerances::NEWTON_ENERGY;
use crate::output::{History, RowStore};
use crate::script::api::examples::FLIGHT;
use crate::script::api::files::failures::output_failure;
use crate::script::api::files::run_folder::RunFolder;
use crate::script::api::models::change::keep_model;
use crate::script::api::models::data::ModelData;
use crate::script::api::models::description::describe_model;
use crate::script::api::models::handle::ModelHandle;
use crate::script::api::motion::Motion;
use crate::script::api::nested_runs::{current_motion, is_study};
use crate::script::api::parameters::check_overrides;
use crate::script::api::remedies::ScriptWords;
use crate::script::api::units::{DeclaredUnits, Units, model_units};
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::digits::{brief, brief_vector, number_text};
use crate::script::language::prelude::*;
use crate::script::language::wording::joined;

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![simulate()]
}

fn simulate() -> Function {
    function(Topic::Simulation, "simulate")
        .summary(
            "a simulation of the model as it is now, at time 0; the first one of a script writes its files into the folder of the run, \
             each further one into a folder in it that has its name (the model's, with a number from the second on)",
        )
        .parameters(vec![
            Parameter::object::<ModelHandle>("model", "the model"),
            Parameter::options("how it is integrated").keys(
                [
                    vec![
                        Parameter::object::<IntegratorHandle>("integrator", "the time integrator"),
                        Parameter::new("dt", STEP_SIZE, "the step size").of("time").within(Interval::Positive),
                        Parameter::number(
                            "tolerance",
                            "1",
                            Interval::Open(0.0, 1.0),
                            "Newton's tolerance: the energy of the residual, relative to the energy scale",
                        )
                        .or(NEWTON_ENERGY),
                        Parameter::new(
                            "solver",
                            Kind::Choice(&["auto", "direct", "iterative", "mumps"]),
                            "how linear systems are solved: by a factorization, by iteration (GMRES with algebraic multigrid), by a \
                             factorization on several machines (MUMPS, which is installed apart), or by iteration from 100 000 unknowns on \
                             in space; `conserva run --solver` replaces it",
                        )
                        .or("auto"),
                        Parameter::integer(
                            "ranks",
                            "the number of processes of the solver `mumps` (more than 64 by `conserva run --ranks`); 0: those \
                         that `mpirun` has started, or one",
                        )
                        .within(Interval::Closed(0.0, MOST_RANKS))
                        .or(0),
                        Parameter::integer("max_halvings", "how often a step that fails may be halved")
                            .within(Interval::Closed(0.0, 50.0))
                            .or(7),
                        Parameter::number(
                            "fields_every",
                            "time",
                            Interval::Positive,
                            "the time between two frames of the fields in `fields.pvd`",
                        )
                        .otherwise("the first and the last state only"),
                    ],
                    still_parameters().into(),
                    vec![
                        Parameter::flag(
                            "accept_overlap",
                            "whether bodies that overlap at the start are meant to; without it, the first step refuses them unless \
                         `settle` came before",
                        )
                        .or(false),
                    ],
                ]
                .concat(),
            ),
        ])
        .see_also(&["run_to", "step", "settle"])
        .example(format!(
            "{FLIGHT}let sim = simulate(flight, #{{ integrator: energy_momentum(), dt: 0.01, fields_every: 0.1 }});\nprint(sim);"
        ))
        .body(|call| Ok(make(call)?))
}

fn make(call: &Call) -> Result<SimulationHandle, Failure> {
    let (original, options) = (call.handle::<ModelHandle>("model")?, call.options("options")?);
    let IntegratorHandle(integrator) = options.handle("integrator")?;
    let size = StepSize::of(&options.argument("dt"))?;
    let mut kernel = Options::new(&integrator, 0.0);
    kernel.tolerance = options.number("tolerance")?;
    let solver = options.text("solver")?;
    let chosen = SolverChoice::ALL.into_iter().find(|(name, _)| *name == solver).map_or(SolverChoice::Auto, |(_, choice)| choice);
    let ranks = options.integer("ranks")? as u16;
    let chosen = if let SolverChoice::Mumps { .. } = chosen { SolverChoice::Mumps { ranks } } else { chosen };
    kernel.solver = match call.host.settings.solver.unwrap_or(chosen) {
        // `conserva check` takes no steps, and starts no processes.
        SolverChoice::Mumps { .. } if call.host.is_check() => SolverChoice::Auto,
        chosen => chosen,
    };
    kernel.max_halvings = options.integer("max_halvings")? as usize;
    kernel.threads = call.host.settings.threads;
    kernel.interrupt = Some(call.host.settings.interrupt.clone());
    kernel.progress = Some(call.host.settings.factorization.clone());
    let fields_every = options.optional_number("fields_every")?;
    let stills = still_options(&options, &original.0.borrow().model)?;
    let accepts_overlap = options.flag("accept_overlap")?;
    kernel.accepts_overlap = accepts_overlap;
    check_overrides(call.host, call.engine(), false)?;
    let model = original.0.borrow().clone();
    let begun = Instant::now();
    let motion = current_motion(call.host);
    size.on_clock(motion.map_or(1.0, |motion| motion.units.time)).put_into(&mut kernel, 0.0);
    let simulation = kernels(call, &model.model, motion, kernel)?;
    let kernel_dt = simulation.options().dt;
    for (contact, finding) in model.model.findings() {
        let what = if matches!(finding, Finding::Untied { .. }) { "tie" } else { "contact" };
        if finding.is_void() {
            let failure =
                Failure::script(format!("{what} \"{contact}\" holds nothing: {finding}")).code(finding.code()).hint(finding.hint());
            return Err(failure.placed(model.place_of_contact(&contact)));
        }
        let warning = Diagnostic::warning(format!("{what} \"{contact}\": {finding}"), model.place_of_contact(&contact));
        let mut hint = finding.hint();
        if matches!(finding, Finding::FacingAway { .. }) && model.model.dimension() == 3 {
            hint += "; of a `block`, `bottom` and `top` are along y, `back` and `front` along z";
        }
        if matches!(finding, Finding::CoarseCircle { .. }) {
            hint += ": `facets: \"straight\"`";
        }
        call.host.warn(warning.code(finding.code()).hint(hint));
    }
    check_joints(call, &model, &simulation)?;
    warn_of_bodies(call, &model.model);
    warn_of_held(call, &model.model);
    for [moving, other] in model.model.meetings() {
        let title = format!("body \"{moving}\" moves towards \"{other}\", and no contact is defined between them");
        let warning = Diagnostic::warning(title, call.place(&Target::Call));
        call.host.warn(
            warning.code("C0421").cause("they will pass through each other").hint("define one with `model.add_contact(…)` if they meet"),
        );
    }
    warn_of_units(call, &model.model, kernel_dt);
    warn_of_numbers(call, &model.model, !integrator.is_static());
    let overlaps = if accepts_overlap { Vec::new() } else { model.model.overlaps() };
    let history = new_history(call.host, simulation.row())?;
    let so_far = InitialHistory { history, probes: Vec::new(), spent: begun.elapsed() };
    let handle = create(call, model, simulation, motion, RecordingLimits { fields_every, stills }, so_far)?;
    *handle.0.overlaps.borrow_mut() = overlaps;
    handle.0.accepts_overlap.set(accepts_overlap);
    handle.note_contact();
    if integrator.is_static() {
        warn_of_damping(call, &handle, "equilibria are those of the relaxed model", "take an integrator with inertia to see what it does");
    }
    keep_model(call.host, &original);
    Ok(handle)
}

/// Warns of bodies with locking elements, of laws that are unsound in the undeformed state, and of bodies without support under gravity.
fn warn_of_bodies(call: &Call, model: &Model) {
    for body in model.locking() {
        call.host.warn(Diagnostic::warning(body.to_string(), call.place(&Target::Call)).code(body.code()).hint(body.remedy()));
    }
    for body in &model.bodies {
        // Laws of the catalogue need no check: they are free of stress and stable in the undeformed state.
        let of_text = body.material.energy().map(|_| body.material.weaknesses_at_rest()).unwrap_or_default();
        for weakness in of_text.iter().filter(|weakness| !matches!(weakness, Weakness::EnergyAtRest(_))) {
            let title = format!("the law of body \"{}\" is not sound at rest: {weakness}", body.name);
            let warning = Diagnostic::warning(title, call.place(&Target::Call)).code("C0322");
            call.host.warn(warning.hint("mend its energy, such as with `I1bar` in place of `I1`; `material.check()` reports all faults"));
        }
    }
    let falling: Vec<String> = model.falling().into_iter().map(|body| format!("\"{}\"", body.name)).collect();
    if let Some(first) = falling.first() {
        let title = match falling.len() {
            1 => format!("gravity moves body {first} for ever: neither it nor what it may touch has a support to rest on"),
            count => {
                let more = count.saturating_sub(NAMED_BODIES);
                let names = falling.iter().take(NAMED_BODIES).cloned().chain((more > 0).then(|| format!("{more} more")));
                let names = joined(&names.collect::<Vec<_>>(), "and");
                format!("gravity moves bodies {names} for ever: neither they nor what they may touch have a support to rest on")
            }
        };
        let warning = Diagnostic::warning(title, call.place(&Target::Call)).code("C0171");
        call.host.warn(warning.hint("hold it with `fix`, or let it touch something with `add_contact`"));
    }
}

/// Warns of redundant constraints, of rates of drives and of prescribed motions that jump, and of velocities incompatible with joints.
///
/// # Errors
/// A drive of a coordinate that is already constrained.
fn check_joints(call: &Call, model: &ModelData, simulation: &Simulation) -> Result<(), Failure> {
    for found in simulation.redundant_constraints() {
        let RedundantConstraints { name, is_joint, is_driven, count, of, node } = found;
        if is_driven {
            let failure = Failure::script(format!("the drive of joint \"{name}\" moves what is held already, or driven by another joint"));
            let hint = "a mechanism takes as many drives as it has motions: leave out this one, or another joint or support";
            return Err(failure.code("C0172").hint(hint).placed(call.place(&Target::Call)));
        }
        if is_joint {
            let title = format!("{count} of {of} constraints of joint \"{name}\" follow from the joints before it, and are left out");
            let warning = Diagnostic::warning(title, call.place(&Target::Call));
            let cause =
                "where the bodies are at rest they hold nothing that is not held: a closed loop of hinges in a plane, or a body held twice";
            let hint = "leave more free, such as by a `point` in place of a `hinge`; at a dead center start a little beside it";
            call.host.warn(warning.code("C0173").cause(cause).hint(hint));
            continue;
        }
        let title = format!("{count} of {of} constraints of tie \"{name}\" follow from supports and other ties, and are left out");
        let mut warning = Diagnostic::warning(title, model.place_of_contact(&name)).code("C0422");
        if let Some((body, number, place)) = node {
            warning = warning.cause(format!("the first is that of node {number} of body \"{body}\", at {}", brief_vector(&place[..2])));
        }
        call.host.warn(warning.hint(
            "tie surfaces once, and support only one of two tied surfaces; results are the same unless supports move the surfaces apart",
        ));
    }
    let has_velocities = !simulation.options().integrator.is_static();
    let is_rigid = |given: &&Prescription| model.model.bodies[given.on.body].rigid.is_some();
    let of_supports =
        |given: &Prescription| Some((given.jump()?, format!("prescribed motion of \"{}\"", model.model.boundary_name(&given.on))));
    let moved = model.model.prescriptions.iter().filter(is_rigid).filter_map(of_supports);
    let driven = model.model.joints.iter().filter_map(|joint| Some((joint.jump()?, format!("drive of joint \"{}\"", joint.name))));
    for (time, motion) in driven.chain(moved).filter(|_| has_velocities) {
        let title = format!("the rate of the {motion} jumps at t = {}", brief(time));
        let warning = Diagnostic::warning(title, call.place(&Target::Call));
        let cause = "velocities at the ends of steps swing about the right ones from then on";
        call.host
            .warn(warning.code("C0174").cause(cause).hint("let it change smoothly: `|t| if t < 1.0 { 0.5 * t * t } else { t - 0.5 }`"));
    }
    for (name, rate) in simulation.loose_joints().into_iter().filter(|_| has_velocities) {
        let title = format!("the initial velocities do not fit joint \"{name}\": what it holds would part at {}", brief(rate));
        let warning = Diagnostic::warning(title, call.place(&Target::Call));
        let cause = "the first step makes them fit, and the velocities at the ends of steps swing about the right ones from then on";
        call.host
            .warn(warning.code("C0175").cause(cause).hint("give every body of a mechanism a velocity and a spin that its joints permit"));
    }
    Ok(())
}

/// Largest number of processes of a distributed solver that a script starts, which is untrusted; the command line allows more.
const MOST_RANKS: f64 = 64.0;

/// Largest ratio of a step to the travel time of sound through a body; beyond it the density is taken for an error of units.
const CROSSINGS: f64 = 1e9;

/// Largest number of bodies that a warning names.
const NAMED_BODIES: usize = 4;

/// Warns of bodies whose mass is too small for the time step size.
fn warn_of_units(call: &Call, model: &Model, dt: f64) {
    for body in model.bodies.iter().filter(|body| body.rigid.is_none()) {
        let (density, modulus) = (body.material.density(), body.material.youngs_modulus());
        let extent = |i: usize| {
            let ends =
                body.mesh.points.iter().map(|point| point[i]).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
            ends.1 - ends.0
        };
        let (size, speed) = ((0..3).map(extent).fold(0.0, f64::max), (modulus / density).sqrt());
        if speed * dt > CROSSINGS * size {
            let title = format!("the density {} of body \"{}\" can only be a mistake of units", number_text(density), body.name);
            let cause = format!("sound would cross the body {:.0e} times in one step of dt = {}", speed * dt / size, number_text(dt));
            let warning = Diagnostic::warning(title, call.place(&Target::Call)).code("C0323").cause(cause);
            let hint = "use one set of units for all: N, m, kg and s with stresses in N/m^2, or N, mm, t and s with stresses in N/mm^2";
            call.host.warn(warning.hint(hint));
        }
    }
}

/// Warns of velocities, loads and supports on nodes that are constrained or prescribed elsewhere.
fn warn_of_held(call: &Call, model: &Model) {
    for held in model.held() {
        let warning = Diagnostic::warning(held.to_string(), call.place(&Target::Call)).code(held.code());
        call.host.warn(warning.cause(held.cause()).hint(held.hint()));
    }
}

/// Makes the simulation of a model, which is moved first if a motion is given.
///
/// # Errors
/// A model that cannot be moved in this way, or that the solver refuses.
pub fn kernels(call: &Call, model: &Model, motion: Option<Motion>, options: Options) -> Result<Simulation, Failure> {
    let moved = motion.map(|motion| motion.model(model)).transpose().map_err(|cause| call.fail(cause))?;
    let simulation = Simulation::new(moved.as_ref().unwrap_or(model), options);
    simulation.map_err(|error| call.fail(error.to_string()).code(error.code()).hint(error.remedy()))
}

/// History of a simulation at its creation.
pub struct InitialHistory {
    /// Rows of the history so far, at least the initial one.
    pub history: History,
    /// Probes, with the points that they follow.
    pub probes: Vec<Probe>,
    /// Computing time of the solver.
    pub spent: Duration,
}

/// Returns a history that begins with a row; older rows are kept in the folder of the run, if there is one.
fn new_history(host: &Host, row: &LedgerRow) -> Result<History, Failure> {
    let files = RunFolder::of(host).files(host).map_err(|error| output_failure(&error))?;
    let store = match files {
        Some(files) => {
            let store = host.slots.get::<RowStore>();
            store.keep_in(&files);
            store
        }
        None => Rc::default(),
    };
    Ok(History::new(store, vec![row.clone()]))
}

/// Makes the object of the language for a simulation, with its history so far.
pub fn create(
    call: &Call,
    model: ModelData,
    simulation: Simulation,
    motion: Option<Motion>,
    keeping: RecordingLimits,
    InitialHistory { history, probes, spent }: InitialHistory,
) -> Result<SimulationHandle, Failure> {
    let name = unique_name(call.host, &model.model.name);
    // The first simulation writes into the folder of the run itself.
    let below = Some(name.as_str()).filter(|_| !Simulations::of(call.host).0.borrow().is_empty());
    DeclaredUnits::settle(call.host);
    // In a check of other units the numbers of the model are not in the declared units.
    let is_same = motion.is_none_or(|motion| motion.units == Units::SAME);
    let units = model_units(call.host, &model.model).filter(|_| is_same);
    let journal = Journal::of(call.host);
    journal.begin(call.host).map_err(|error| output_failure(&error))?;
    let start = if journal.is_recalling() { FirstSteps::Recalled } else { FirstSteps::Anew };
    let number = (!is_study(call.host)).then(|| Simulations::of(call.host).0.borrow().len());
    let journal = number.map(|number| (journal, number));
    let columns = probe_columns(&model.model, &probes);
    let first = history.row(0).unwrap_or_default();
    let mut artifacts =
        Artifacts::create(call.host, below, &model.model, &keeping, &first, Columns { probes: columns, units: units.clone() }, start)?;
    if let Some(artifacts) = &mut artifacts {
        artifacts.rewrite(&history.first(1), &history, &simulation)?;
    }
    let data = SimulationData {
        place: call.place(&Target::Call),
        artifacts: RefCell::new(artifacts),
        model,
        name,
        closed_since: RefCell::new(vec![None; simulation.closed_nodes().len()]),
        motion,
        spent: Cell::new(spent),
        scale: Cell::new(simulation.row().energy_scale()),
        standing: Cell::new(0),
        overlaps: RefCell::default(),
        accepts_overlap: Cell::default(),
        simulation: RefCell::new(simulation),
        history: RefCell::new(history),
        columns: RefCell::default(),
        keeping,
        hint: RefCell::default(),
        past: RefCell::default(),
        probes: RefCell::new(probes),
        callbacks: RefCell::default(),
        causes_seen: Cell::default(),
        advancing: Cell::new(false),
        is_behind: Cell::new(false),
        journal,
        is_known: Cell::new(true),
        units,
        found: RefCell::default(),
    };
    let handle = SimulationHandle(Rc::new(data));
    following::begin(call.host, &handle);
    if call.host.is_check() {
        call.host.findings.borrow_mut().push(described_for_check(&handle));
        let at_start = handle.0.simulation.borrow().findings_at_start();
        at_start.iter().for_each(|finding| handle.warn_of(call.host, finding));
    }
    if !is_study(call.host) {
        Simulations::of(call.host).0.borrow_mut().push(handle.clone());
    }
    call.host.count_effect();
    Ok(handle)
}

/// Returns the name of the model, numbered if earlier simulations of the script have it; simulations of checks and studies have the plain
/// name.
fn unique_name(host: &Host, model: &str) -> String {
    if is_study(host) {
        return model.to_string();
    }
    let taken: Vec<String> = Simulations::of(host).0.borrow().iter().map(|simulation| simulation.0.name.clone()).collect();
    let numbered = (2..).map(|number| format!("{model}-{number}"));
    std::iter::once(model.to_string()).chain(numbered).find(|name| !taken.contains(name)).unwrap_or_default()
}

/// Returns the description of a simulation in `conserva check`.
fn described_for_check(handle: &SimulationHandle) -> String {
    let simulation = handle.0.simulation.borrow();
    let options = simulation.options();
    let told = |number: String, dimension: &str| handle.0.told(number, dimension);
    format!(
        "simulation \"{}\": {}, dt = {}, {} unknowns\n{}",
        handle.0.name,
        title(&options.integrator),
        step_size(options, |dt| handle.0.told(dt, "time")),
        simulation.unknowns(),
        handle.0.with_units(&describe_model(&handle.0.model, &told))
    )
}
