//! Events of a run besides its steps, for observers: halvings, contacts that become active or inactive, equilibria.

use super::handle::SimulationHandle;
use crate::dynamics::{Halving, LedgerRow, SettleReport, Simulation};
use crate::script::language::host::Host;
use crate::script::language::observer::{ContactChange, Event};

impl SimulationHandle {
    /// Reports the halvings of the step after `row`; `before` are the earlier counts.
    pub(super) fn tell_halvings(&self, host: &Host, simulation: &Simulation, before: &[Halving], row: &LedgerRow) {
        for (index, halving) in simulation.halvings().iter().enumerate() {
            let count = halving.count - before.get(index).map_or(0, |before| before.count);
            if count > 0 {
                let contact = halving.motion.as_ref().map(|motion| motion.contact.as_str());
                let time = self.0.script_time(row.time);
                let event = Event::Halved { simulation: &self.0.name, cause: halving.cause, contact, count, step: row.step, time };
                host.observer.noticed(&event);
            }
        }
    }

    /// Reports an equilibrium, and contacts that became active or inactive in the search for it.
    pub(super) fn tell_settled(&self, host: &Host, row: &LedgerRow, report: &SettleReport) {
        self.tell_contacts(host, row);
        let &SettleReport { steps, newton_iterations, .. } = report;
        host.observer.noticed(&Event::Settled { simulation: &self.0.name, steps, newton_iterations, row });
    }

    /// Reports contacts that became active or inactive between two rows. Before the first step, all contacts count as inactive; ties are
    /// not reported.
    pub(super) fn tell_contacts(&self, host: &Host, row: &LedgerRow) {
        let (model, history) = (&self.0.model.model, self.0.history.borrow());
        for (index, (name, totals)) in model.contact_names().into_iter().zip(&row.contacts).enumerate() {
            let before = history.last().and_then(|row| row.contacts.get(index)).map_or(0, |totals| totals.active);
            let change = match (before, totals.active) {
                (0, 1..) => ContactChange::Closed,
                (1.., 0) => ContactChange::Opened,
                _ => continue,
            };
            if model.interactions.iter().any(|tie| tie.is_tie() && tie.name == name) {
                continue;
            }
            let (simulation, active) = (self.0.name.as_str(), totals.active);
            host.observer.noticed(&Event::Contact { simulation, contact: name, change, active, step: row.step, time: row.time });
        }
    }
}
