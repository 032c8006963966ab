//! Plans a study in its folder from the arguments.

use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

use super::arguments::{DesignArguments, Retry, seconds};
use super::opening::opened;
use crate::script::{Class, Diagnostic, Session, Settings, Silent, home, read_script};
use crate::studies::{Design, Limits, Pairing, Plan, PointState, Rows, Scenario, StudyFile, StudyFolder, read_study_file};

/// A study that is planned.
pub struct Planned {
    /// Folder of the study, by its absolute path.
    pub study: StudyFolder,
    /// Plan of the study.
    pub plan: Plan,
    /// Path of the folder in messages.
    pub shown: PathBuf,
}

fn refusal(title: impl Into<String>) -> Diagnostic {
    Diagnostic::error(Class::Script, title)
}

/// Plans a study from the arguments, or continues a planned study.
///
/// # Errors
/// The arguments do not define a study, or the folder holds another study.
pub fn planned(arguments: &DesignArguments) -> Result<Planned, Box<Diagnostic>> {
    let Some(what) = &arguments.what else {
        let error = refusal("a study needs a script, a study file or the folder of a study");
        return Err(Box::new(error.hint("conserva sweep bearing.rhai --vary dt=0.01,0.005")));
    };
    if StudyFolder::is_study(what) {
        return taken_up(arguments, what);
    }
    if what.is_dir() {
        let error = refusal(format!("{} holds no study", what.display())).cause("there is no study.json in it");
        return Err(Box::new(error.hint("name a script and what varies: `conserva sweep bearing.rhai --vary dt=0.01,0.005`")));
    }
    let file = if what.extension().is_some_and(|ending| ending == "toml") { Some(read_study_file(what)?) } else { None };
    let script = file.as_ref().map_or(what, |file| &file.script).clone();
    let plan = planned_anew(arguments, file.as_ref(), &script)?;
    let stem =
        what.file_stem().map(|stem| stem.to_string_lossy().trim_end_matches(".study").to_string()).unwrap_or_else(|| "script".into());
    let shown = arguments.out.clone().unwrap_or_else(|| Path::new("out").join(format!("{stem}-sweep")));
    let path = StudyFolder::create(&shown)?.path().canonicalize().unwrap_or_else(|_| shown.clone());
    let study = StudyFolder::create(&path)?;
    let lock = study.lock()?;
    if StudyFolder::is_study(&path) {
        compare(&study.plan()?, &plan, arguments.retry, &shown)?;
    }
    study.write_plan(&plan)?;
    drop(lock);
    Ok(Planned { study, plan, shown })
}

/// Continues a study that was planned before.
fn taken_up(arguments: &DesignArguments, what: &Path) -> Result<Planned, Box<Diagnostic>> {
    let is_new = !arguments.vary.is_empty() || !arguments.fixed.is_empty() || arguments.values.is_some() || arguments.sample.is_some();
    if is_new || arguments.out.is_some() {
        let error = refusal(format!("{} is a study that is planned already", what.display()));
        return Err(Box::new(error.hint("to change it, name its script with all that varies and this folder with `--out`")));
    }
    let (study, mut plan) = opened(what)?;
    let now = Scenario { digest: Scenario::digest_now(&plan.scenario.folder, &plan.scenario.script)?, ..plan.scenario.clone() };
    compare(&plan, &Plan { scenario: now.clone(), ..plan.clone() }, arguments.retry, what)?;
    plan.scenario = now;
    if let Some(seconds) = arguments.point_time {
        plan.limits.seconds = Some(seconds);
    }
    plan.limits.memory = arguments.memory.memory.or(plan.limits.memory);
    let lock = study.lock()?;
    study.write_plan(&plan)?;
    drop(lock);
    Ok(Planned { study, plan, shown: what.into() })
}

fn planned_anew(arguments: &DesignArguments, file: Option<&StudyFile>, script: &Path) -> Result<Plan, Box<Diagnostic>> {
    let mut varied = file.map_or(Ok(Vec::new()), StudyFile::varied)?;
    varied.retain(|varied| arguments.vary.iter().all(|other| other.name != varied.name));
    varied.extend(arguments.vary.iter().cloned());
    let mut fixed = file.map_or(Ok(Vec::new()), StudyFile::fixed)?;
    fixed.retain(|(name, _)| arguments.fixed.iter().all(|(other, _)| other != name));
    fixed.extend(arguments.fixed.iter().cloned());
    let of_file = |text: &String| text.parse().map_err(|reason: String| Box::new(refusal("`sample` of the study file").cause(reason)));
    let sampling = match (arguments.sample, file.and_then(|file| file.sample.as_ref())) {
        (Some(sampling), _) => Some(sampling),
        (None, text) => text.map(of_file).transpose()?,
    };
    let seed = arguments.seed.or(file.and_then(|file| file.seed)).unwrap_or(0);
    let sampling = sampling.map(|sampling| crate::studies::Sampling { seed, ..sampling });
    let rows = arguments.values.as_ref().or(file.and_then(|file| file.values.as_ref()));
    let is_zipped = arguments.zip || file.is_some_and(|file| file.zip);
    let design = Design {
        rows: rows.map(|path| Rows::read(path)).transpose()?,
        varied,
        pairing: if is_zipped { Pairing::Zip } else { Pairing::Grid },
        sampling,
    };
    let limit = match (arguments.point_time, file.and_then(|file| file.point_time.as_ref())) {
        (Some(time), _) => Some(time),
        (None, Some(text)) => Some(seconds(text).map_err(|reason| Box::new(refusal("`point_time` of the study file").cause(reason)))?),
        (None, None) => None,
    };
    let folder = std::env::current_dir().map_err(|error| Box::new(refusal("the current folder is gone").cause(error.to_string())))?;
    let rows = design.points()?;
    let names: Vec<&String> = rows.names.iter().chain(fixed.iter().map(|(name, _)| name)).collect();
    look_at(script, &names, arguments)?;
    let scenario = Scenario {
        digest: Scenario::digest_now(&folder, script)?,
        script: script.into(),
        folder,
        fixed,
        allow_read: arguments.allow_read.clone(),
        max_operations: arguments.max_operations,
    };
    Plan::new(scenario, Limits { seconds: limit, threads: arguments.threads, memory: arguments.memory.memory }, rows)
}

/// Checks that the script parses and has the named parameters, before the points are computed.
fn look_at(script: &Path, names: &[&String], arguments: &DesignArguments) -> Result<(), Box<Diagnostic>> {
    let text: Arc<str> = read_script(script)?.into();
    let settings = Settings { allow_read: arguments.allow_read.clone(), ..Settings::default() };
    let session = Session::new(settings, home(script), Rc::new(Silent))?;
    let outline = session.outline(&script.display().to_string(), &text)?;
    let Some(known) = outline.parameters else { return Ok(()) };
    let Some(unknown) = names.iter().find(|name| !known.contains(name)) else { return Ok(()) };
    let error = refusal(format!("the script has no parameter `{unknown}`"));
    let error = match known.as_slice() {
        [] => error.cause("it has no parameters").hint(format!("write `param(\"{unknown}\", default)` in the script")),
        known => error.cause(format!("its parameters are {}", known.join(", "))),
    };
    let near = known.iter().map(|known| (strsim::jaro_winkler(known, unknown), known)).max_by(|a, b| a.0.total_cmp(&b.0));
    Err(Box::new(match near.filter(|(likeness, _)| *likeness > 0.8) {
        Some((_, known)) => error.hint(format!("did you mean `{known}`?")),
        None => error,
    }))
}

/// Refuses to mix points of different scenarios in one folder.
fn compare(then: &Plan, now: &Plan, retry: Option<Retry>, shown: &Path) -> Result<(), Box<Diagnostic>> {
    if retry == Some(Retry::All) {
        return Ok(());
    }
    let (a, b) = (&then.scenario, &now.scenario);
    let differs = if (&a.folder, &a.script) != (&b.folder, &b.script) {
        format!("it is a study of {}", a.folder.join(&a.script).display())
    } else if a.fixed != b.fixed {
        let shown = |fixed: &[(String, String)]| match fixed {
            [] => "nothing".to_string(),
            pairs => pairs.iter().map(|(name, value)| format!("{name}={value}")).collect::<Vec<_>>().join(" "),
        };
        format!("it was planned with {} set, now {}", shown(&a.fixed), shown(&b.fixed))
    } else if a.digest != b.digest {
        format!("{} has been changed since", a.script.display())
    } else {
        return Ok(());
    };
    let error = refusal(format!("the points in {} do not belong to this study", shown.display())).cause(differs);
    Err(Box::new(error.hint("choose another folder with `--out`, or compute all of them anew with `--retry all`")))
}

/// Removes the records of points that are to be computed again.
///
/// # Errors
/// A record that cannot be removed.
pub fn retry(planned: &Planned, retry: Option<Retry>) -> Result<(), Box<Diagnostic>> {
    let Some(retry) = retry else { return Ok(()) };
    for point in &planned.plan.points {
        let is_meant = match planned.study.state(point) {
            PointState::Done(record) => retry == Retry::All || !record.outcome.is_completed(),
            _ => false,
        };
        // A point that another process computes at present is new anyway.
        if is_meant && let Some(_claim) = planned.study.claim(point)? {
            planned.study.forget(point)?;
        }
    }
    Ok(())
}
