//! A simulation at the prompt: time, ledger and contacts as tables.

use super::handle::{SimulationHandle, angular_text};
use super::integrators::title as integrator_title;
use super::step_control::step_size;
use crate::dynamics::Rows;
use crate::script::language::digits::{brief, brief_vector};
use crate::script::language::handle::Handle;
use crate::script::language::tables::table;

impl SimulationHandle {
    /// Time, ledger row and contacts of a simulation as tables.
    pub fn table(&self) -> String {
        let data = &self.0;
        let _ = self.looked();
        let Ok(simulation) = data.simulation.try_borrow() else { return self.describe() };
        let (row, options) = (simulation.row(), simulation.options());
        let title = format!("simulation \"{}\" at t = {}, step {}", data.name, data.told(brief(row.time), "time"), row.step);
        let method = format!(
            "  {}, dt = {}, {} unknowns",
            integrator_title(&options.integrator),
            step_size(options, |dt| data.told(dt, "time")),
            simulation.unknowns()
        );
        let history = data.history.borrow();
        let mut worst = 0.0;
        history.visit(0, &mut |row| worst = f64::max(worst, row.energy_defect.abs()));
        let energy = |value: f64| data.told(brief(value), "energy");
        let ledger = [
            ("kinetic", energy(row.kinetic)),
            ("strain", energy(row.strain)),
            ("potential", energy(row.potential)),
            ("total", energy(row.total())),
            ("largest energy defect", energy(worst)),
            ("momentum", data.told(brief_vector(&row.momentum[..simulation.dimension()]), "mass * velocity")),
            ("angular momentum", data.told(angular_text(row, simulation.dimension()), "mass * area/time")),
        ];
        let ledger: Vec<Vec<String>> = ledger.into_iter().map(|(name, value)| vec![name.to_string(), value]).collect();
        let mut parts = vec![title, method, table(&["ledger", ""], &ledger)];
        let contacts: Vec<Vec<String>> = data
            .model
            .model
            .contact_names()
            .into_iter()
            .filter_map(|name| {
                let fields = simulation.contact(name)?;
                let active = fields.active.iter().filter(|active| **active).count();
                let pressure = fields.pressure.iter().fold(0.0_f64, |largest, pressure| largest.max(*pressure));
                let force = brief_vector(&fields.force[..simulation.dimension()]);
                Some(vec![
                    name.into(),
                    active.to_string(),
                    fields.active.len().to_string(),
                    data.told(brief(pressure), "stress"),
                    data.told(force, "force"),
                ])
            })
            .collect();
        if !contacts.is_empty() {
            parts.push(table(&["contact", "active", "nodes", "largest pressure", "force"], &contacts));
        }
        parts.extend(data.remarks(&simulation));
        parts.join("\n")
    }
}
