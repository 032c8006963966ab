//! `expect_conserved`: energy, linear and angular momentum, or the balance of every step.

use rhai::EvalAltResult;

use super::verdicts::{failed, only_listed, passed};
use crate::dynamics::{LedgerRow, Rows};
use crate::math::tolerances::SAME_MOMENT;
use crate::output::Inertia;
use crate::script::api::examples::flight_example;
use crate::script::api::simulations::handle::SimulationHandle;
use crate::script::language::digits::{brief, number_text, significant};
use crate::script::language::prelude::*;

/// Quantities that can be conserved, by name.
const QUANTITIES: &[&str] = &["energy", "momentum", "angular_momentum", "ledger"];

/// `expect_conserved`: requires that a quantity does not drift.
pub fn expect_conserved() -> Function {
    function(Topic::Checks, "expect_conserved")
        .summary(
            "ends the script with an error when a quantity drifts by more than a relative tolerance; \"ledger\" checks that the energy \
             balance of every step closes",
        )
        .parameters(vec![
            Parameter::object::<SimulationHandle>("simulation", "the simulation"),
            Parameter::new("quantity", Kind::Choice(QUANTITIES), "what should be conserved"),
            Parameter::options("from when and how well"),
        ])
        .keys(vec![
            Parameter::number(
                "after",
                "time",
                Interval::Finite,
                "the time from which it should be constant: from the first step that begins there or later",
            )
            .or(0.0),
            Parameter::number("tolerance", "1", Interval::NonNegative, "the largest drift, relative to the size of the quantity"),
        ])
        .see_also(&["expect_close", "history"])
        .example(flight_example("sim.run_to(0.05);\nexpect_conserved(sim, \"energy\", #{ after: 0.0, tolerance: 1e-10 });"))
        .body(conserved)
}

fn conserved(call: &Call) -> Result<(), Box<EvalAltResult>> {
    let (handle, quantity, options) = (call.handle::<SimulationHandle>("simulation")?, call.text("quantity")?, call.options("options")?);
    let (after, tolerance) = (options.number("after")?, options.number("tolerance")?);
    let what = format!("{} of \"{}\" after t = {}", title(&quantity), handle.0.name, number_text(after));
    if only_listed(call, &format!("{what} drifts by at most {}", number_text(tolerance))) {
        return Ok(());
    }
    let rows = handle.0.history.borrow();
    // The first step that begins at `after` or later; it may begin a little before, because steps meet a time only up to round-off.
    let begins = |row: &LedgerRow| row.time >= after - SAME_MOMENT * after.abs().max(row.dt);
    let (mut index, mut first, mut kinetic, mut round_off) = (0, None, 0.0, 0.0);
    rows.visit(0, &mut |row| {
        raise(&mut kinetic, row.kinetic);
        round_off = row.work_round_off;
        first = first.or_else(|| begins(row).then_some(index));
        index += 1;
    });
    let Some(first) = first.filter(|first| first + 2 <= index) else {
        let failure = failed(call, format!("the simulation \"{}\" took no step after t = {}", handle.0.name, number_text(after)));
        let end = rows.last().map_or(0.0, |row| row.time);
        return Err(failure
            .cause(format!("it ended at t = {}", number_text(end)))
            .hint("run it longer, or choose an earlier `after`")
            .into());
    };
    let mut drift = worst_drift(&quantity, &*rows, first, kinetic, Inertia::of(&handle.0.model.model));
    // Reactions do work on the round-off of the positions of supported nodes, which may be the only energy of the model.
    if matches!(&*quantity, "energy" | "ledger") && drift.size * drift.scale <= round_off {
        drift.size = 0.0;
    }
    let measured = format!("{what} drifts by {} at most, at step {} (t = {})", significant(drift.size, 3), drift.step, brief(drift.time));
    if drift.size <= tolerance {
        return passed(call, &format!("ok  {measured}; tolerance {}", number_text(tolerance)));
    }
    let failure = failed(call, format!("{} of \"{}\" is not conserved", title(&quantity), handle.0.name))
        .label(format!("tolerance {}", number_text(tolerance)));
    let failure = failure.cause(measured).cause(format!(
        "relative to {}; its first value in this time is {}",
        brief(drift.scale),
        brief(drift.first)
    ));
    let [rubs, loaded, touched, heated] = drift.acted;
    let hint = match quantity.as_str() {
        "energy" if rubs => "friction turns energy into heat: write \"ledger\", which asks whether all of it is booked",
        "energy" if loaded => "a load does work in this time: choose a later `after`",
        "energy" if touched => "closing contact costs energy under the update rule \"gap\"; \"ledger\" asks whether all of it is booked",
        "energy" if heated => "viscous materials turn energy into heat; \"ledger\" asks whether all of it is booked",
        "energy" | "ledger" => "only `energy_momentum()` conserves the energy for every step size",
        _ => "supports and loads change momenta",
    };
    Err(failure.hint(hint).into())
}

#[derive(Default)]
struct Drift {
    size: f64,
    scale: f64,
    first: f64,
    step: usize,
    time: f64,
    /// True for each of friction, loads, contact and viscosity that did work.
    acted: [bool; 4],
}

fn title(quantity: &str) -> &'static str {
    match quantity {
        "energy" => "the energy",
        "momentum" => "the linear momentum",
        "angular_momentum" => "the angular momentum",
        _ => "the energy balance",
    }
}

fn length([x, y, z]: [f64; 3]) -> f64 {
    x.hypot(y).hypot(z)
}

/// Returns the largest drift of a quantity over the rows from index `begin` on, relative to its scale: the largest energy, or the momentum
/// of the bodies if all their kinetic energy were translational.
fn worst_drift<R: Rows + ?Sized>(quantity: &str, rows: &R, begin: usize, kinetic: f64, inertia: Inertia) -> Drift {
    let bound = (2.0 * inertia.mass * kinetic).max(0.0).sqrt();
    let difference = |a: [f64; 3], b: [f64; 3]| length([a[0] - b[0], a[1] - b[1], a[2] - b[2]]);
    let [mut energy, mut momentum, mut angular] = [0.0; 3];
    let (mut first, mut worst): (Option<LedgerRow>, Option<f64>) = (None, None);
    let mut drift = Drift::default();
    rows.visit(begin, &mut |row| {
        raise(&mut energy, row.energy_scale());
        raise(&mut momentum, length(row.momentum));
        raise(&mut angular, length(row.angular_momentum));
        let is_first = first.is_none();
        let first = first.get_or_insert_with(|| row.clone());
        let change = match quantity {
            "energy" => (row.total() - first.total()).abs(),
            "momentum" => difference(row.momentum, first.momentum),
            "angular_momentum" => difference(row.angular_momentum, first.angular_momentum),
            _ if is_first => 0.0,
            _ => row.energy_defect.abs(),
        };
        // NaN counts as the largest value, so that a diverged run cannot pass.
        if worst.is_none_or(|worst| change.total_cmp(&worst).is_ge()) {
            (worst, drift.step, drift.time) = (Some(change), row.step, row.time);
        }
        if is_first {
            return;
        }
        let acts = [row.friction_work != 0.0, row.load_work != 0.0, row.contact_work != 0.0, row.dissipation > 0.0];
        drift.acted.iter_mut().zip(acts).for_each(|(acted, acts)| *acted |= acts);
    });
    let (first, change) = (first.unwrap_or_default(), worst.unwrap_or(0.0));
    (drift.scale, drift.first) = match quantity {
        "momentum" => (momentum.max(bound), length(first.momentum)),
        "angular_momentum" => (angular.max(bound * inertia.radius), length(first.angular_momentum)),
        _ => (energy, first.total()),
    };
    drift.size = if change == 0.0 { 0.0 } else { change / drift.scale };
    drift
}

/// Maximum of two values; NaN counts as the largest.
fn raise(most: &mut f64, value: f64) {
    *most = if value <= *most { *most } else { value };
}
