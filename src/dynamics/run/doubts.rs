//! Consequences of findings: whether a run conserved its energy, and whether it is reliable.

use super::run_findings::RunFindingKind;

impl RunFindingKind {
    /// True if a run with such a finding did not conserve energy as its integrator requires, apart from the work of loads and losses of
    /// contact.
    pub fn breaks_conservation(self) -> bool {
        matches!(self, RunFindingKind::NotConserved | RunFindingKind::EnergyDefect | RunFindingKind::PositiveContactWork)
    }

    /// True if a run with such a finding is not reliable: contact supplied energy, energy appeared or vanished with a conserving
    /// integrator, or bodies have penetrated each other or obstacles.
    pub fn is_doubt(self) -> bool {
        use RunFindingKind::{EnergyDefect, PassedObstacle, PassedThrough, PositiveContactWork};
        matches!(self, PositiveContactWork | EnergyDefect | PassedThrough | PassedObstacle)
    }
}
