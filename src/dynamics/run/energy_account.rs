//! Energy account of a run: the ledger's rows summed by cause.

use std::fmt;

use super::ledger::LedgerRow;
use super::rows::Rows;
use crate::math::digits::{percent, three_digits};
use crate::math::tolerances::{CONSERVED, NO_ENERGY};

/// Sums over the rows of a run `[energy]`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyAccount {
    /// Total energy at the start.
    pub start: f64,
    /// Total energy at the end.
    pub end: f64,
    /// Work of loads and of supports that move.
    pub loads: f64,
    /// Work of contact, never positive: the loss by update rules.
    pub contact: f64,
    /// Work of friction in contacts, negative: heat.
    pub friction: f64,
    /// Work of friction in joints, negative: heat.
    pub joint_friction: f64,
    /// Dissipation of viscous materials, negative.
    pub viscosity: f64,
    /// Dissipation of plastic flow, negative.
    pub plastic: f64,
    /// Dissipation of dampers and drag, negative.
    pub damping: f64,
    /// Algorithmic dissipation of the time integrator, negative.
    pub numerical: f64,
    /// Energy loss of impacts of rigid bodies by restitution, negative.
    pub impacts: f64,
    /// Sum of the energy defects of the time integrator.
    pub integrator: f64,
    /// Other changes of the energy: by `settle`, or by return to another state.
    pub otherwise: f64,
    /// Largest `kinetic + strain + |potential|` of the run.
    pub scale: f64,
}

impl EnergyAccount {
    /// Energy account of a run with the rows `rows`.
    pub fn of<R: Rows + ?Sized>(rows: &R) -> Self {
        let of_row: [fn(&LedgerRow) -> f64; 10] = [
            |row| row.load_work,
            |row| row.contact_work,
            |row| row.friction_work - row.joint_friction,
            |row| row.joint_friction,
            |row| row.dissipation - row.damping - row.numerical - row.impact - row.plastic,
            |row| row.plastic,
            |row| row.damping,
            |row| row.numerical,
            |row| row.impact,
            |row| row.energy_defect,
        ];
        let mut sums = [std::iter::empty::<f64>().sum::<f64>(); 10];
        let (mut ends, mut scale) = (None, NO_ENERGY);
        rows.visit(0, &mut |row| {
            scale = f64::max(scale, row.kinetic + row.strain.abs() + row.potential.abs());
            if ends.is_some() {
                sums.iter_mut().zip(of_row).for_each(|(sum, of)| *sum += of(row));
            }
            ends = Some([ends.map_or(row.total(), |[start, _]: [f64; 2]| start), row.total()]);
        });
        let Some([start, end]) = ends else { return EnergyAccount::default() };
        let [loads, contact, friction, joint_friction, viscosity, plastic, damping, numerical, impacts, integrator] = sums;
        let [viscosity, plastic, damping, numerical, impacts] = [-viscosity, -plastic, -damping, -numerical, -impacts];
        let known = loads + contact + friction + joint_friction + viscosity + plastic + damping + numerical + impacts + integrator;
        let otherwise = end - start - known;
        EnergyAccount {
            start,
            end,
            loads,
            contact,
            friction,
            joint_friction,
            viscosity,
            plastic,
            damping,
            numerical,
            impacts,
            integrator,
            otherwise,
            scale,
        }
    }

    /// Changes of the energy beyond round-off, by cause.
    pub fn changes(&self) -> Vec<(&'static str, f64)> {
        let all = [
            ("loads", self.loads),
            ("contact", self.contact),
            ("friction", self.friction),
            ("friction of joints", self.joint_friction),
            ("viscosity", self.viscosity),
            ("plastic flow", self.plastic),
            ("dampers", self.damping),
            ("numerical damping", self.numerical),
            ("impacts", self.impacts),
            ("the integrator", self.integrator),
            ("settling", self.otherwise),
        ];
        all.into_iter().filter(|(_, amount)| amount.abs() > CONSERVED * self.scale).collect()
    }
}

impl fmt::Display for EnergyAccount {
    /// Writes the account, such as `contact took 0.0129 (2.45 %), loads gave 0.3 (57 %)`; empty without energy changes. The percentages are
    /// those of the largest energy of the run, or of all that was given if that is more, as where most of it becomes heat.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let changes = self.changes();
        let given: f64 = changes.iter().map(|(_, amount)| amount.max(0.0)).sum();
        let whole = self.scale.max(given);
        let parts = changes.iter().map(|(cause, amount)| {
            let verb = if *amount > 0.0 { "gave" } else { "took" };
            format!("{cause} {verb} {} ({})", three_digits(amount.abs()), percent(amount.abs() / whole))
        });
        write!(out, "{}", parts.collect::<Vec<_>>().join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_came_and_went_is_told_by_cause() {
        let row = |step: usize, kinetic: f64| LedgerRow { step, time: 0.1 * step as f64, kinetic, ..LedgerRow::default() };
        let mut rows = vec![row(0, 2.0), row(1, 3.0), row(2, 2.5), row(3, 2.5 + 1e-14)];
        assert_eq!(EnergyAccount::of::<[LedgerRow]>(&[]), EnergyAccount::default());
        assert_eq!(EnergyAccount::of(&rows[2..]).to_string(), "", "round-off is not told");
        (rows[1].load_work, rows[2].contact_work) = (1.0, -0.5);
        assert_eq!(EnergyAccount::of(&rows).to_string(), "loads gave 1 (33.33 %), contact took 0.5 (16.67 %)");
        (rows[1].load_work, rows[1].energy_defect) = (1.0 - 3e-5, 3e-5);
        assert!(EnergyAccount::of(&rows).to_string().ends_with(", the integrator gave 3e-5 (1e-3 %)"));
        rows.push(row(3, 2.0));
        assert!(EnergyAccount::of(&rows).to_string().ends_with(", settling took 0.5 (16.67 %)"));
        (rows[3].dissipation, rows[3].numerical) = (0.25, 0.25);
        assert!(EnergyAccount::of(&rows).to_string().contains(", numerical damping took 0.25 (8.33 %)"));
        rows[4].friction_work = -0.5;
        assert!(EnergyAccount::of(&rows).to_string().contains(", friction took 0.5 (16.67 %), numerical damping"));
        let [mut driven, start] = [row(1, 1.0), row(0, 1.0)];
        (driven.load_work, driven.dissipation, driven.plastic) = (8.0, 8.0, 8.0);
        assert_eq!(EnergyAccount::of(&[start, driven][..]).to_string(), "loads gave 8 (100.00 %), plastic flow took 8 (100.00 %)");
    }
}
