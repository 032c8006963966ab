//! Results at paths given by a script, below the run's output folder, and plots drawn with characters in the terminal.

use std::sync::Arc;

use super::artifacts::has_surfaces;
use super::handle::SimulationHandle;
use super::writing::chosen_columns;
use super::{movies, pictures, plots, reports, tables};
use crate::dynamics::{Partner, Simulation};
use crate::output::{Frame, Surroundings, braille_plot};
use crate::script::api::examples::flight_example;
use crate::script::api::files::writing::{path_parameter, write, write_at};
use crate::script::language::diagnostics::Ink;
use crate::script::language::prelude::*;

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![
        write_fields(),
        tables::table(),
        plots::plot(),
        plots::plot_curves(),
        show(),
        pictures::picture_function(),
        movies::movie_function(),
        reports::report_function(),
    ]
}

fn write_fields() -> Function {
    method_of::<SimulationHandle>(Topic::Results, "write_fields")
        .summary(
            "writes displacement, velocity, stress, contact pressure and gap of all bodies as they are now as VTU, and beside it, where \
             there are any, their rigid obstacles (`start_obstacles.vtu` for `start.vtu`) and the secondary surfaces of their contacts \
             (`start_contacts.vtu`)",
        )
        .parameters(vec![path_parameter("a `.vtu` file below the output folder")])
        .see_also(&["picture", "simulate"])
        .example(flight_example("sim.write_fields(\"start.vtu\");"))
        .body(|call, handle| {
            let units = || handle.0.units.clone().map(Arc::new);
            let content = || handle.with(call, |simulation| Frame::new(simulation.time(), &simulation.fields()).in_units(units()).encode());
            let written = write(call, Some(&handle), &[".vtu"], content)?;
            if has_surfaces(&handle.0.model.model) && !call.host.is_check() {
                let path = call.text("path")?.replace(".vtu", "_contacts.vtu");
                let frame = |simulation: &Simulation| {
                    Frame::of_contacts(simulation.time(), &simulation.contact_surfaces()).in_units(units()).encode()
                };
                write_at(call, Some(&handle), &path, &handle.with(call, frame)?)?;
            }
            let has_obstacles = handle.0.model.model.interactions.iter().any(|all| matches!(all.partner, Partner::Obstacle { .. }));
            if has_obstacles && !call.host.is_check() {
                let path = call.text("path")?.replace(".vtu", "_obstacles.vtu");
                let frame = |simulation: &Simulation| {
                    let around = Surroundings::of_bodies(&simulation.fields());
                    Frame::of_obstacles(simulation.time(), &simulation.obstacles(), &around).in_units(units()).encode()
                };
                write_at(call, Some(&handle), &path, &handle.with(call, frame)?)?;
            }
            Ok(written)
        })
}

fn show() -> Function {
    method_of::<SimulationHandle>(Topic::Results, "show")
        .summary("draws columns of the history over time right here, with letters")
        .parameters(vec![Parameter::any("columns", "the name of a column, or an array of names").otherwise("\"total\"")])
        .see_also(&["plot", "history"])
        .example(flight_example("sim.run_to(0.05);\nsim.show([\"kinetic\", \"strain\", \"total\"]);"))
        .body(|call, handle| {
            let columns = chosen_columns(call, &handle)?;
            if call.host.is_check() {
                return Ok(());
            }
            let time = handle.column("time").unwrap_or_default();
            let curves: Vec<(&str, &[f64])> = columns.iter().map(|(name, values)| (name.as_str(), values.as_slice())).collect();
            let is_colored = call.host.observer.ink() == Ink::Colored;
            call.host.observer.print(&braille_plot(&handle.0.name, "time", &time, &curves, is_colored));
            Ok(())
        })
}
