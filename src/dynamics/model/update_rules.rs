//! Update rules: gap conditions of active contact nodes over a step.

use std::fmt;

use crate::integrators::Scheme;

/// An update rule as a row of the catalogue.
pub struct UpdateRule {
    /// Name as written in a script.
    pub name: &'static str,
    /// One sentence for the reference.
    pub summary: &'static str,
    /// Constraints that are active in a step, and their gaps at its end.
    pub holds: ActiveConstraints,
    /// True if closings are plastic impacts whose energy is stored and returned at the opening.
    pub gives_back: bool,
    /// True if the energy is conserved through impact and release for every time step size; it never increases.
    pub keeps_energy: bool,
}

impl UpdateRule {
    /// Default coefficient of restitution of impacts between rigid bodies under this rule.
    pub fn restitution(&self) -> f64 {
        if self.keeps_energy { 1.0 } else { 0.0 }
    }
}

/// Constraints that are active in a step, and their gaps at its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActiveConstraints {
    /// Constraints that would overlap are active: the gap at the end is zero, or the gap at the start if that is an overlap.
    Closed,
    /// Constraints that are closed at the start are active: their gap stays constant. Others may penetrate the other side within a step.
    AsItIs,
}

/// Zero gap at the end of the step, or the gap at the start if that is an overlap.
pub static GAP: UpdateRule = UpdateRule {
    name: "gap",
    summary: "closed at the end of a step; each closing loses energy, 3 to 12 % of an impact and more where parts rattle, which the ledger \
              books as contact work (never positive: an overlap at the start is kept, not driven apart)",
    holds: ActiveConstraints::Closed,
    gives_back: false,
    keeps_energy: false,
};

/// No further approach of a node that is closed at the start of the step (Laursen and Chawla, IJNME 40, 1997).
pub static PERSISTENCY: UpdateRule = UpdateRule {
    name: "persistency",
    summary: "a gap that is closed stays as it is: energy exact through impact and release, penetrates by at most a tenth of a facet",
    holds: ActiveConstraints::AsItIs,
    gives_back: false,
    keeps_energy: true,
};

/// As [`GAP`], but closings are plastic impacts whose energy a smoothed velocity jump returns at the opening (after Laursen and Love, IJNME
/// 53, 2002, who return it at once).
pub static VELOCITY: UpdateRule = UpdateRule {
    name: "velocity",
    summary: "closed as with `gap`, and exact energy: the energy of a closing is stored (column `reserve`, part of `potential`) and \
              returned when the contact opens",
    holds: ActiveConstraints::Closed,
    gives_back: true,
    keeps_energy: true,
};

/// All update rules, in the order of the reference.
pub static UPDATE_RULES: &[&UpdateRule] = &[&GAP, &PERSISTENCY, &VELOCITY];

/// Default update rule: an energy-conserving one for energy-conserving schemes. For others `persistency` would keep penetrations without
/// conserving energy.
pub fn default_rule(scheme: &Scheme) -> &'static UpdateRule {
    if scheme.promises.energy { &PERSISTENCY } else { &GAP }
}

impl PartialEq for UpdateRule {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl fmt::Debug for UpdateRule {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        out.write_str(self.name)
    }
}
