//! Warnings about a run, and about unused definitions.

use std::rc::Rc;

use super::handle::{Found, SimulationHandle, Simulations};
use crate::dynamics::{RunFinding, RunFindingKind};
use crate::math::tolerances::LOST;
use crate::script::api::remedies::{ScriptWords, explained};
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::digits::brief;
use crate::script::language::prelude::*;
use crate::script::language::wording::joined;

/// Largest number of contacts named in a warning.
const NAMED: usize = 6;

impl SimulationHandle {
    /// Warns of loads that never acted and contact that never closed.
    pub fn warn_of_idle_parts(&self, host: &Host) {
        let stepped = self.0.history.borrow().len() > 1;
        if !stepped {
            return;
        }
        self.warn_of_degrees(host);
        for load in self.0.model.loads.iter().filter(|load| load.amplitude.never_acted()) {
            let warning = Diagnostic::warning(format!("the {} never acted", load.title), load.place.clone())
                .code("C0641")
                .cause("its amplitude was zero at every step of the run")
                .hint("check its times and its size against the time that the simulation covers");
            host.warn(warning);
        }
        let closed = self.0.closed_since.borrow();
        let model = &self.0.model.model;
        let is_tie = |name: &str| model.interactions.iter().any(|tie| tie.is_tie() && tie.name == name);
        let open = model.contact_names().into_iter().zip(&*closed).filter(|(name, since)| since.is_none() && !is_tie(name));
        let open: Vec<&str> = open.map(|(name, _)| name).collect();
        let (title, cause) = match open[..] {
            [] => return,
            [name] => (format!("contact \"{name}\" never closed"), "no node of its secondary side was active in any step"),
            _ => {
                let mut names: Vec<String> = open.iter().map(|name| format!("\"{name}\"")).collect();
                if let Some(more) = names.len().checked_sub(NAMED).filter(|more| *more > 1) {
                    names.truncate(NAMED);
                    names.push(format!("{more} more"));
                }
                (format!("contacts {} never closed", joined(&names, "and")), "no node of their secondary sides was active in any step")
            }
        };
        let hint = "check the positions and velocities of the bodies, and how far the simulation runs";
        host.warn(Diagnostic::warning(title, self.0.model.place_of_contact(open[0])).code("C0642").cause(cause).hint(hint));
    }

    /// Warns of findings of the run so far; non-conservation of energy only above `LOST`.
    pub fn warn_of_findings(&self, host: &Host) {
        let shows = |finding: &&RunFinding| finding.kind != RunFindingKind::NotConserved || finding.value > LOST;
        self.evaluation().iter().flat_map(|found| found.findings.iter()).filter(shows).for_each(|finding| self.warn_of(host, finding));
    }

    /// Describes the energy changes of the run so far in one line; `None` if below round-off.
    pub fn energy_line(&self, host: &Host) -> Option<String> {
        let account = self.evaluation()?.account.to_string();
        (!account.is_empty()).then(|| format!("energy{}: {}{account}", self.0.bracketed("energy"), self.prefix(host)))
    }

    /// True if the results so far should not be trusted.
    pub fn is_doubtful(&self) -> bool {
        self.evaluation().is_some_and(|found| found.findings.iter().any(|finding| finding.kind.is_doubt()))
    }

    /// True if the run so far has conserved its energy.
    pub fn is_conserving(&self) -> bool {
        self.evaluation().is_some_and(|found| !found.findings.iter().any(|finding| finding.kind.breaks_conservation()))
    }

    /// Evaluation of the rows so far; `None` while steps are taken.
    fn evaluation(&self) -> Option<Rc<Found>> {
        self.0.simulation.try_borrow().ok().map(|simulation| self.0.found(&simulation, &self.0.history.borrow()))
    }

    /// Prefix `simulation "drop", ` for scripts with several simulations; otherwise empty.
    fn prefix(&self, host: &Host) -> String {
        if Simulations::of(host).0.borrow().len() > 1 { format!("simulation \"{}\", ", self.0.name) } else { String::new() }
    }

    /// Warns of a finding, at its contact pair or where the simulation was made.
    pub(super) fn warn_of(&self, host: &Host, finding: &RunFinding) {
        let RunFinding { contact, step, time, .. } = finding;
        let place = contact.as_ref().map_or(self.0.place.clone(), |name| self.0.model.place_of_contact(name));
        let which = self.prefix(host);
        let cause = self.0.with_units(&format!("{} ({which}t = {}, step {step})", explained(finding), brief(*time)));
        let (title, hint) = (self.0.with_units(&finding.to_string()), self.0.with_units(&finding.remedy()));
        host.warn(Diagnostic::warning(title, place).code(finding.code()).cause(cause).hint(hint));
    }

    /// Warns before the first step of prescribed motions that do not begin where the bodies are, and of adhesion and films of contacts that
    /// bounce.
    pub(super) fn warn_at_start(&self, call: &Call) {
        if self.0.history.borrow().len() > 1 || self.0.is_behind.get() {
            return;
        }
        let Ok(simulation) = self.0.simulation.try_borrow() else { return };
        if simulation.row().step > 0 || simulation.options().integrator.is_static() {
            return;
        }
        if let Some((contact, time)) = simulation.interrupted_friction() {
            let title = format!("the adhesion or viscosity of contact \"{contact}\" may act for part of the time only");
            let cause = format!(
                "with `update: \"persistency\"` nodes in contact bounce where steps (dt = {}) are much shorter than the time in which an \
                 elastic wave crosses a cell ({}); they have no shear stress while they are open",
                brief(simulation.options().dt),
                brief(time)
            );
            let warning = Diagnostic::warning(title, self.0.model.place_of_contact(contact)).code("C0645").cause(self.0.with_units(&cause));
            call.host.warn(warning.hint("take `update: \"velocity\"`, whose nodes stay closed, or a larger step"));
        }
        // Errors of a time function are reported by the step.
        let Ok(Some((boundary, jump))) = simulation.prescribed_jump() else { return };
        let title = format!("the prescribed motion of \"{boundary}\" jumps by {} in the first step", brief(jump));
        let warning = Diagnostic::warning(title, call.place(&Target::Call)).code("C0643");
        let warning = warning.cause(format!("it is not where the body is at t = {}: waves run through the body", brief(simulation.time())));
        call.host
            .warn(warning.hint("let it begin there, such as with `ramp(0.0, 1.0, 0.1)`, or bring the body to rest first with `settle`"));
    }

    /// Warns at once of motion for which steps are halved: a run may take long from then on.
    pub(super) fn warn_of_large_motion(&self, host: &Host) {
        let Ok(simulation) = self.0.simulation.try_borrow() else { return };
        let causes = simulation.halvings().len();
        if self.0.causes_seen.replace(causes) < causes {
            let found = simulation.findings(&*self.0.history.borrow());
            let motions = found.iter().filter(|finding| matches!(finding.kind, RunFindingKind::Motion(_)));
            motions.for_each(|finding| self.warn_of(host, finding));
        }
    }
}
